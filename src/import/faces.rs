//! What attributes make of a part: its medium, and of each of its faces finish, coating, shape, emitter and slide.

use super::agf::Reference;
use super::binding_slots::{PartBound, Rank, Slot, Slots};
use super::build::{Builder, intern};
use super::files;
use super::frames;
use super::optics::{
    self, FinishSpec, GratingSpec, MeasuredFile, OrdersSpec, ShapeSpec, SlideSpec, SpectrumSpec, Spreading,
};
use super::select::Candidate;
use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::ids::{CoatingId, GratingId, MediumId, MeshId, ScatterId, WavePlateId};
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{
    Absorption, Emitter, Face, Finish, Medium, Note, Orders, Part, Shape, Spectrum, WavePlate, Wavelengths, glass,
};
use glam::DAffine3;
use std::path::PathBuf;

/// Whether light gets from outside of a face to what is behind it, so that the medium there counts.
fn lets_in(face: &Face) -> bool {
    match face.finish {
        Finish::None
        | Finish::Polished
        | Finish::Rough { .. }
        | Finish::Measured { .. }
        | Finish::Polariser { .. }
        | Finish::Retarder { .. }
        | Finish::WavePlate { .. }
        | Finish::CircularPolariser { .. }
        | Finish::ReflectivePolariser { .. }
        | Finish::Grating { .. } => true,
        Finish::Lambert { transmittance, .. }
        | Finish::Gauss { transmittance, .. }
        | Finish::CosM { transmittance, .. } => transmittance > 0.0,
        Finish::MirrorMetal { .. }
        | Finish::MirrorIdeal { .. }
        | Finish::Abg { .. }
        | Finish::Surface { .. }
        | Finish::Absorber => false,
    }
}

impl Builder<'_> {
    /// `index`: of the part in the scene.
    pub(super) fn part(&mut self, index: usize, part: &Candidate, bound: &PartBound) -> Result<Part> {
        let to_world = self.assembly.nodes.get(part.node).map_or(DAffine3::IDENTITY, |node| node.to_world);
        let priority = bound.part.get(Slot::Priority).map(|won| optics::priority(&won.entry.value)).transpose()?;
        let mut faces = Vec::with_capacity(bound.faces.len());
        for (number, slots) in bound.faces.iter().enumerate() {
            faces.push(self.face((index, part), number, slots, &to_world)?);
        }
        let medium = self.medium(&bound.part, faces.iter().any(lets_in))?;
        if medium.is_none() {
            for ((number, slots), face) in bound.faces.iter().enumerate().zip(&mut faces) {
                self.thin_wall(part, number, slots, face)?;
            }
        }
        let named = |face: usize| {
            let index = self.assembly.meshes.get(part.mesh)?.materials.get(face).copied().flatten()?;
            Some(self.assembly.materials.get(index)?.name.clone())
        };
        let materials = (0..faces.len()).map(|face| named(face).unwrap_or_else(|| "none".to_owned())).collect();
        Ok(Part {
            materials,
            film_in: None,
            name: part.name.clone(),
            path: part.path.clone(),
            mesh: MeshId::from_index(part.mesh),
            to_world: frames::in_metres(&to_world, self.unit_m, &self.assembly.axes),
            medium,
            priority: priority.unwrap_or(0),
            faces,
        })
    }

    /// A face that a format calls clear (KHR_materials_transmission) without saying what is behind it is a thin wall: what its
    /// material looks like, which lets light through unbent. One that a person calls polished lacks its medium.
    fn thin_wall(&mut self, part: &Candidate, number: usize, slots: &Slots, face: &mut Face) -> Result<()> {
        let mapped = slots.finish().is_some_and(|(_, rank)| rank == Rank::Mapped);
        if mapped && face.finish == Finish::Polished {
            (face.finish, face.coating) = (Finish::Surface { surface: self.own_surface(part, number)? }, None);
        }
        Ok(())
    }

    /// The medium of a part; `lit`: light gets into it. An index that nothing asks for may be an impossible one:
    /// KHR_materials_ior allows any from 1 up, and who writes 1000 for a paint means that it reflects.
    fn medium(&mut self, slots: &Slots, lit: bool) -> Result<Option<MediumId>> {
        let nm = self.wavelengths.traced_nm();
        let index = slots.get(Slot::Index).filter(|won| won.entry.key != "medium");
        let absorption = slots.get(Slot::Absorption).map(|won| optics::absorption(&won.entry.value, nm)).transpose()?;
        let Some(won) = index else { return Ok(None) };
        let (own, index) = optics::law(&won.entry.key, &won.entry.value)?;
        if let Err(fault) = optics::possible(&won.entry.key, &won.entry.value, &index, nm) {
            // Below 1, or with gain, it is wrong whoever asks.
            let at_nm = index.index(nm);
            if lit || !(at_nm.re >= 1.0 && at_nm.im >= 0.0) {
                return Err(fault);
            }
            let text = format!("{}: not used, as no face of the part lets light in", fault.what);
            let note = Note::info(fault.at.clone(), text);
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
            return Ok(None);
        }
        if won.entry.key == "glass" {
            self.extrapolated(&won.entry.value);
        }
        let name = match (won.entry.key.as_str(), &won.entry.label) {
            ("glass", _) | (_, None) => own,
            (_, Some(label)) => label.clone(),
        };
        let medium = Medium { name, index, absorption: absorption.unwrap_or(Absorption::NONE) };
        Ok(Some(MediumId::from_index(intern(&mut self.media, medium))))
    }

    /// Warns of each catalogue name in `value`, a glass or the films of a coating, whose law is used beyond its range. Of
    /// colour, what is blue, green and red counts: beyond 400 to 700 nm lies less than 0.5 % of daylight's X, Y and Z.
    fn extrapolated(&mut self, value: &Value) {
        match &value.data {
            Data::Text(name) => {
                let traced = match self.wavelengths {
                    Wavelengths::Mono { nm } => [nm; 2],
                    Wavelengths::Visible => [400.0, 700.0],
                };
                let beyond = match Reference::of(name) {
                    Some(from) => {
                        self.catalogue_file(from, &value.at);
                        let read = from.compared(&value.at).ok();
                        let doubt = read.as_ref().and_then(|(_, doubt)| doubt.clone());
                        let note =
                            doubt.map(|doubt| Note::warning(value.at.clone(), doubt).code(Code::IndexContradicted));
                        self.notes.extend(note.filter(|note| !self.notes.contains(note)));
                        read.and_then(|(glass, _)| glass.beyond(traced))
                    }
                    None => glass::find(name).and_then(|glass| glass.beyond(traced)),
                };
                let Some(text) = beyond else { return };
                let note = Note::warning(value.at.clone(), text).code(Code::IndexExtrapolated);
                if !self.notes.contains(&note) {
                    self.notes.push(note);
                }
            }
            Data::List(items) => items.iter().for_each(|item| self.extrapolated(item)),
            Data::Table(entries) => {
                let holders = entries.iter().filter(|(key, _)| matches!(key.as_str(), "stack" | "material"));
                holders.for_each(|(_, inner)| self.extrapolated(inner));
            }
            Data::Bool(_) | Data::Number(_) => {}
        }
    }

    /// A catalogue file is one of the scene's, and what it says of heat is not used.
    fn catalogue_file(&mut self, from: Reference, at: &Where) {
        let file = from.path(at);
        let text =
            format!("{}: what it says of heat is not used; indices are at the temperature of its data", file.display());
        if !self.files.contains(&file) {
            self.files.push(file);
            self.notes.push(Note::info(at.clone(), text));
        }
    }

    fn face(
        &mut self,
        (index, part): (usize, &Candidate),
        number: usize,
        slots: &Slots,
        to_world: &DAffine3,
    ) -> Result<Face> {
        let shines = slots.get(Slot::Emitter).is_some_and(|won| won.entry.value.text() != Some("none"));
        let said = slots.finish();
        let finish = match said {
            Some((entry, _)) => match optics::finish(&entry.value, &mut self.notes)? {
                FinishSpec::Given(finish) => finish,
                FinishSpec::Material => Finish::Surface { surface: self.own_surface(part, number)? },
                FinishSpec::Grating(spec) => self.grating(&spec)?,
                FinishSpec::Plate { plate, of } => self.plate(plate, of),
                FinishSpec::Measured { files } => self.measured_finish(&files)?,
                FinishSpec::Surface { surface, at } => Finish::Surface { surface: self.given_surface(*surface, &at)? },
            },
            None if slots.get(Slot::Slide).is_some() && !shines => Finish::None,
            None => Finish::Surface { surface: self.own_surface(part, number)? },
        };
        let shape = match slots.get(Slot::Shape) {
            Some(won) => self.shape(part, number, &won.entry.value, to_world)?,
            None => Shape::Mesh,
        };
        let (emitter, picture) = self.shining((index, part), number, slots)?;
        let slide = match slots.get(Slot::Slide).filter(|won| won.entry.value.text() != Some("none")) {
            Some(won) if picture.is_some() => {
                let what = format!("part {} face {number} has a slide and an emitter with an image", part.path);
                return Err(Error::new(won.entry.at.clone(), what)
                    .expected("one of them: a display's picture is said by its emitter or by a slide on its face"));
            }
            Some(won) => {
                let value = self.sheet.slides.follow(&won.entry.value)?;
                Some(optics::slide(value, &mut self.notes)?)
            }
            None => picture,
        };
        let slide = slide.map(|spec| self.slide(part, number, &spec)).transpose()?;
        let is_mapped = said.is_some_and(|(_, rank)| rank == Rank::Mapped);
        let tint = if is_mapped { self.stain(part, number, finish) } else { None };
        let sensor = slots.get(Slot::Sensor).map(|won| optics::sensor(&won.entry.value)).transpose()?;
        Ok(Face { finish, coating: self.coating(part, number, slots, finish)?, shape, emitter, tint, slide, sensor })
    }

    /// What a face emits, and the picture that it shows. The rays of a file become lamps of their own.
    fn shining(
        &mut self,
        (index, part): (usize, &Candidate),
        number: usize,
        slots: &Slots,
    ) -> Result<(Option<Emitter>, Option<SlideSpec>)> {
        // `emitter = "none"` darkens what another carrier lights.
        let Some(won) = slots.get(Slot::Emitter).filter(|won| won.entry.value.text() != Some("none")) else {
            return Ok((None, None));
        };
        let spec = optics::emitter(self.sheet.emitters.follow(&won.entry.value)?, &mut self.notes)?;
        if let Spreading::RayFile { file, at } = spec.angular.clone() {
            self.rays(index, part, spec, (&file, &at))?;
            return Ok((None, None));
        }
        if spec.spectrum.is_none() && self.coloured() {
            let (at, text) = (won.entry.value.at.clone(), "`spectrum` of emitter is not said: D65".to_owned());
            self.notes.push(Note::info(at, text));
        }
        let picture = spec.picture.clone();
        let mut emitter = self.emitter(part, number, spec)?;
        // What a format says of emission goes with its texture; what a person says is the whole face's.
        if won.rank == Rank::Mapped {
            let own = self.own_surface(part, number)?;
            emitter.pattern = self.surfaces[own.index()].emission.is_some().then_some(own);
        }
        Ok((Some(emitter), picture))
    }

    /// What the base colour of a solid that transmits takes at each of its faces: the root, as light gets in and out (so has it
    /// Blender's Principled BSDF; KHR_materials_transmission leaves solids open).
    fn stain(&mut self, part: &Candidate, number: usize, finish: Finish) -> Option<[f64; 3]> {
        let (_, surface, at) = self.look_of(part, number)?;
        let (colour, at) = (surface.base_color.clone(), at.clone());
        let said = match finish {
            Finish::Polished if colour.texture.is_some() => {
                Some("a base colour texture on glass is not used: its factor alone tints")
            }
            Finish::Rough { .. } if colour.texture.is_some() || colour.factor != [1.0; 3] => {
                Some("the base colour of rough glass is not used: it is clear")
            }
            _ => None,
        };
        if let Some(text) = said {
            let note = Note::warning(at, text);
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        let root = colour.factor.map(|c| c.clamp(0.0, 1.0).sqrt());
        (finish == Finish::Polished && root != [1.0; 3]).then_some(root)
    }

    /// The finish of files of measured scattering.
    fn measured_finish(&mut self, named: &[(String, Where)]) -> Result<Finish> {
        let paths: Vec<PathBuf> = named.iter().map(|(name, at)| files::resolve(name, at)).collect();
        let name = optics::name_of_table(&paths);
        let known = self.scatters.iter().position(|table| table.file == name);
        let index = match known {
            Some(index) => index,
            None => {
                let mut sources = Vec::new();
                for (path, (_, at)) in paths.iter().zip(named) {
                    sources.push(MeasuredFile { bytes: files::read(path, at, "measured scattering")?, file: path, at });
                }
                self.scatters.push(optics::scatter_table(&sources, &mut self.notes)?);
                self.files.extend(paths);
                self.scatters.len() - 1
            }
        };
        Ok(Finish::Measured { table: ScatterId::from_index(index) })
    }

    /// The finish of a grating, which is kept among the scene's; its table is read once.
    fn grating(&mut self, spec: &GratingSpec) -> Result<Finish> {
        let orders = match &spec.orders {
            OrdersSpec::Given { orders, .. } => Orders::Even(orders.clone()),
            OrdersSpec::File { file, at } => {
                let file = files::resolve(file, at);
                let known = self.gratings.iter().find_map(|grating| match &grating.orders {
                    Orders::Table(table) => (table.file == file.display().to_string()).then(|| table.clone()),
                    Orders::Even(_) => None,
                });
                let table = match known {
                    Some(table) => table,
                    None => {
                        let bytes = files::read(&file, at, "efficiencies of a grating")?;
                        optics::efficiency_table(&bytes, &file, at)?.into()
                    }
                };
                if !self.files.contains(&file) {
                    self.files.push(file);
                }
                Orders::Table(table)
            }
        };
        let grating = intern(&mut self.gratings, spec.with(orders)?);
        Ok(Finish::Grating { grating: GratingId::from_index(grating) })
    }

    /// The finish of a wave plate, which is kept among the scene's.
    fn plate(&mut self, plate: WavePlate, of: optics::PlateOf) -> Finish {
        let plate = WavePlateId::from_index(intern(&mut self.wave_plates, plate));
        match of {
            optics::PlateOf::Retarder { axis } => Finish::WavePlate { axis, plate },
            optics::PlateOf::CircularPolariser { axis, projected_axis, transmittance, extinction, right, front } => {
                Finish::CircularPolariser { axis, projected_axis, transmittance, extinction, right, front, plate }
            }
        }
    }

    /// The spectrum that is meant; a file is read.
    pub(super) fn spectrum(&mut self, spec: SpectrumSpec) -> Result<Spectrum> {
        match spec {
            SpectrumSpec::Given(spectrum) => Ok(spectrum),
            SpectrumSpec::Csv { file, at } => {
                let file = files::resolve(&file, &at);
                let bytes = files::read(&file, &at, "spectrum")?;
                let spectrum = optics::spectrum_table(&bytes, &file, &at)?;
                if !self.files.contains(&file) {
                    self.files.push(file);
                }
                Ok(spectrum)
            }
        }
    }

    /// The coating of a face, which must be polished if the coating was bound with at least the right of the finish.
    fn coating(&mut self, part: &Candidate, number: usize, slots: &Slots, finish: Finish) -> Result<Option<CoatingId>> {
        let Some(won) = slots.get(Slot::Coating) else { return Ok(None) };
        let value = self.sheet.coatings.follow(&won.entry.value)?;
        if let (Some(name), Some(asked)) = (value.text(), won.entry.value.text()) {
            // A name that leads nowhere; `none` is a kind.
            if name != "none" {
                return Err(optics::unknown_coating(asked, &won.entry.value, self.sheet.coatings.names()));
            }
        }
        let name = won.entry.value.text().unwrap_or("inline");
        let Some(coating) = optics::coating(value, name, &mut self.notes)? else { return Ok(None) };
        if finish != Finish::Polished {
            // A film that a format's own field means (iridescence) says nothing about the finish.
            if won.rank > Rank::Mapped && slots.get(Slot::Finish).is_none_or(|finish| won.rank >= finish.rank) {
                let what = format!("a coating acts on polished faces; part {} face {number} is not", part.path);
                return Err(Error::new(won.entry.at.clone(), what)
                    .expected("finish = \"polished\" there, or no coating")
                    .code(Code::CoatingNotPolished));
            }
            return Ok(None);
        }
        if won.rank == Rank::Mapped {
            self.whole_film(part, number);
        }
        self.extrapolated(value);
        Ok(Some(CoatingId::from_index(intern(&mut self.coatings, coating))))
    }

    /// Says so if a format has a film on a part of some glass, or of many thicknesses: a coating is the same all over.
    fn whole_film(&mut self, part: &Candidate, number: usize) {
        let Some((_, surface, at)) = self.look_of(part, number) else { return };
        let Some(film) = &surface.film else { return };
        let varies = film.weight.texture.is_some() || film.thickness_nm.texture.is_some();
        if varies || film.weight.factor < 1.0 {
            let text = "a thin film on glass is taken as whole, and as thick as it gets";
            let note = Note::warning(at.clone(), text);
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
    }

    fn shape(&mut self, part: &Candidate, number: usize, value: &Value, to_world: &DAffine3) -> Result<Shape> {
        let spec = optics::shape(value, &mut self.notes)?;
        if spec == ShapeSpec::Exact(Shape::Mesh) {
            return Ok(Shape::Mesh);
        }
        let scale = frames::uniform_scale(to_world).ok_or_else(|| {
            Error::new(
                value.at.clone(),
                format!("part {} face {number} has an exact shape but its node is not scaled uniformly", part.path),
            )
            .expected("the same scale along all axes")
            .code(Code::UnevenScale)
        })?;
        match spec {
            ShapeSpec::Exact(shape) => Ok(shape),
            ShapeSpec::Fit { surface, tolerance_um, radius, conic, tube_radius } => {
                let Some(source) = self.assembly.meshes.get(part.mesh) else { return Ok(Shape::Mesh) };
                let place = frames::FacePlace { part: &part.path, number, at: &value.at };
                let order = frames::FitOrder { surface, tolerance_um, radius, conic, tube_radius };
                frames::fitted(&source.mesh, place, order, self.unit_m * scale, &mut self.notes)
            }
        }
    }
}
