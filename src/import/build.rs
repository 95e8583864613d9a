//! Assembly + sidecar + `--set` → [`Scene`]: the attributes are bound, read and put where they belong.

use super::assembly::{Assembly, LayerWish};
use super::bind::bind;
use super::explain::Explained;
use super::files;
use super::gltf::looks_like_millimetres;
use super::optics::{self, FinishSpec, ShapeSpec, SpectrumSpec};
use super::place;
use super::select::{Candidate, candidates, listed};
use super::set::Set;
use super::sheet::Sheet;
use super::slots::{PartBound, Rank, Slot, Slots};
use super::value::{Data, Value};
use crate::base::fault::Result;
use crate::base::ids::{CoatingId, MediumId, MeshId, ScatterId};
use crate::base::{Fault, Where};
use crate::scene::{
    Absorption, Coating, Face, Finish, Group, LuminousProfile, Medium, Note, Part, ScatterTable, Scene, Severity,
    Shape, Slide, Spectrum, Wavelengths, glass,
};
use glam::{DAffine3, DMat3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene, and which line said what.
#[derive(Debug, Clone)]
pub struct Built {
    pub scene: Scene,
    pub explained: Explained,
    /// The layers that the asset asks for.
    pub layers: Vec<LayerWish>,
    /// The asset's own file, and its world → the scene's world, a turn that leaves lengths.
    pub asset: PathBuf,
    pub axes: DMat3,
}

/// Builds the scene of `assembly`. `assembly.dependencies` (the sidecar among them, if it was a file) are hashed.
///
/// Faults: whatever is wrong with the sidecar, the asset's attributes, the sets or the pictures they name; parts that
/// nothing binds; no eye.
pub fn build(assembly: Assembly, sidecar: Option<&Value>, sets: &[Set]) -> Result<Built> {
    let mut sheet = Sheet::new(sidecar, assembly.optics.as_ref())?;
    let mut rest = Vec::new();
    for set in sets {
        if !set.apply_to_sheet(&mut sheet)? {
            rest.push(set);
        }
    }
    let mut notes = Vec::new();
    let parts = candidates(&assembly)?;
    let mut bound = bind(&sheet, &assembly, &parts, &mut notes)?;
    for set in rest {
        set.apply(&sheet, &parts, &mut bound)?;
    }
    covered(&parts, &bound, &assembly)?;
    let explained = Explained::new(&parts, &bound);

    let wavelengths = optics::wavelengths(sheet.wavelengths.as_ref(), &mut notes)?;
    let unit_m = match &sheet.unit {
        Some(value) => {
            let unit = optics::unit(value)?;
            let text = format!("unit {unit} m replaces the {} m that the asset declares", assembly.unit_m);
            notes.push(Note { severity: Severity::Info, at: value.at.clone(), text });
            unit
        }
        None => {
            notes.extend(looks_like_millimetres(&assembly));
            assembly.unit_m
        }
    };
    let mut builder = Builder {
        assembly: &assembly,
        sheet: &sheet,
        wavelengths,
        unit_m,
        media: Vec::new(),
        coatings: Vec::new(),
        slides: Vec::new(),
        scatters: Vec::new(),
        groups: Vec::new(),
        profiles: Vec::new(),
        measured: HashMap::new(),
        pictures: HashMap::new(),
        files: assembly.dependencies.clone(),
        notes,
    };
    builder.unused(&bound)?;
    let scene_parts = parts.iter().zip(&bound).map(|(part, bound)| builder.part(part, bound)).collect::<Result<_>>()?;
    let sky = match &sheet.sky {
        Some(value) => Some(builder.sky(value)?),
        None => None,
    };
    let sun = match &sheet.sun {
        Some(value) => Some(builder.sun(value)?),
        None => None,
    };
    let mut made = builder.lights(sky.as_ref().map(|sky| sky.group))?;
    made.lights.extend(sun);
    let sky = sky.or(made.dome.take());
    let mut scene_parts: Vec<Part> = scene_parts;
    scene_parts.append(&mut made.parts);
    let eye = place::eye(&assembly, sheet.eye.as_ref(), unit_m, &mut builder.notes)?
        .ok_or_else(|| no_eye(sidecar, &assembly.file))?;
    let Builder { media, coatings, slides, scatters, groups, profiles, files, mut notes, .. } = builder;
    let hash = hash(&files, sets)?;
    let mut all = assembly.notes;
    all.append(&mut notes);
    let mut seen = Vec::<Note>::new();
    for note in all {
        // A row that binds many parts says the same of each.
        if !seen.contains(&note) {
            seen.push(note);
        }
    }
    let name = assembly.file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let meshes = assembly.meshes.into_iter().map(|source| source.mesh).chain(made.meshes).collect();
    let scene = Scene {
        name,
        unit_m,
        wavelengths,
        meshes,
        parts: scene_parts,
        media,
        coatings,
        slides,
        scatters,
        groups,
        profiles,
        lights: made.lights,
        sky,
        eye,
        notes: seen,
        hash,
    };
    Ok(Built { scene, explained, layers: assembly.layers, asset: assembly.file, axes: assembly.axes })
}

fn no_eye(sidecar: Option<&Value>, file: &Path) -> Box<Fault> {
    Fault::new(super::sheet::place(sidecar, file), "there is no eye")
        .expected("an [eye], or a perspective camera in the asset")
}

/// Every face must have a finish or a slide.
fn covered(parts: &[Candidate], bound: &[PartBound], assembly: &Assembly) -> Result<()> {
    let open = |bound: &PartBound| -> Vec<usize> {
        let bare = |(_, slots): &(usize, &Slots)| slots.get(Slot::Finish).is_none() && slots.get(Slot::Slide).is_none();
        bound.faces.iter().enumerate().filter(bare).map(|(face, _)| face).collect()
    };
    let bare: Vec<(&Candidate, &PartBound, Vec<usize>)> = parts
        .iter()
        .zip(bound)
        .map(|(part, bound)| (part, bound, open(bound)))
        .filter(|row| !row.2.is_empty())
        .collect();
    let Some((first, slots, faces)) = bare.first() else { return Ok(()) };
    let at = Where::file(&assembly.file);
    let wholly = |bound: &PartBound| bound.faces.iter().all(|face| face.all().next().is_none());
    if wholly(slots) || bare.len() > 1 {
        let names = listed(bare.iter().map(|(part, _, _)| part.path.as_str()));
        let parts = if bare.len() == 1 { "part" } else { "parts" };
        return Err(Fault::new(at, format!("no optical attributes bind {parts} {names}"))
            .expected("a finish for every face: a [[bind]] or [default] finish = \"absorber\""));
    }
    let numbers: Vec<String> = faces.iter().map(usize::to_string).collect();
    let faces = listed(numbers.iter().map(String::as_str));
    Err(Fault::new(Where::part(&first.path), format!("no finish binds face {faces}"))
        .expected("a finish for every face: a [[bind]] or [default] finish = \"absorber\""))
}

/// blake3 of all input bytes, each file preceded by its length, then the sets.
fn hash(files: &[PathBuf], sets: &[Set]) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        files::hash(&mut hasher, file, &Where::Nowhere, "input file")?;
    }
    for set in sets {
        hasher.update(&(set.text.len() as u64).to_le_bytes());
        hasher.update(set.text.as_bytes());
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// The picture of a slide: width, height, luminance and, if wanted, colour.
pub(super) type Known = (usize, usize, Arc<Vec<f32>>, Option<Arc<Vec<[f32; 3]>>>);

pub(super) struct Builder<'a> {
    pub(super) assembly: &'a Assembly,
    pub(super) sheet: &'a Sheet,
    pub(super) wavelengths: Wavelengths,
    pub(super) unit_m: f64,
    pub(super) media: Vec<Medium>,
    pub(super) coatings: Vec<Coating>,
    pub(super) slides: Vec<Slide>,
    pub(super) scatters: Vec<ScatterTable>,
    pub(super) groups: Vec<Group>,
    pub(super) profiles: Vec<LuminousProfile>,
    /// Profiles as their files say, by file.
    pub(super) measured: HashMap<PathBuf, LuminousProfile>,
    /// Pictures of slides by file.
    pub(super) pictures: HashMap<PathBuf, Known>,
    pub(super) files: Vec<PathBuf>,
    pub(super) notes: Vec<Note>,
}

/// The place of `item` in `table`, added if it isn't there yet.
pub(super) fn intern<T: PartialEq>(table: &mut Vec<T>, item: T) -> usize {
    table.iter().position(|other| *other == item).unwrap_or_else(|| {
        table.push(item);
        table.len() - 1
    })
}

impl Builder<'_> {
    /// Reads what is named but not used too: its faults are faults. Notes the sidecar's that nothing names.
    fn unused(&mut self, bound: &[PartBound]) -> Result<()> {
        let slots =
            || bound.iter().flat_map(|part| std::iter::once(&part.part).chain(&part.faces)).flat_map(Slots::all);
        let entries = || slots().flat_map(|won| std::iter::once(&won.entry).chain(won.beaten.iter().map(|(e, _)| e)));
        let coated = |name: &str| entries().any(|e| e.slot == Slot::Coating && e.value.text() == Some(name));
        let filled = |name: &str| entries().any(|e| e.label.as_deref() == Some(name));
        let coatings = self.sheet.coatings.own().filter(|(name, _)| !coated(name));
        let media = self.sheet.media.own().filter(|(name, _)| !filled(name));
        for (noun, (name, value)) in coatings.map(|own| ("coating", own)).chain(media.map(|own| ("medium", own))) {
            let text = format!("[{noun}.{name}] is not used: no part names it");
            self.notes.push(Note { severity: Severity::Info, at: value.at.clone(), text });
        }
        for (name, value) in &self.sheet.coatings.named {
            optics::coating(value, name, &mut Vec::new())?;
        }
        for (_, value) in &self.sheet.media.named {
            for (key, value) in optics::medium_entries(value)? {
                if Slot::of(key) == Some(Slot::Index) {
                    optics::index(key, value, self.wavelengths.traced_nm())?;
                }
            }
        }
        Ok(())
    }

    fn part(&mut self, part: &Candidate, bound: &PartBound) -> Result<Part> {
        let to_world = self.assembly.nodes.get(part.node).map_or(DAffine3::IDENTITY, |node| node.to_world);
        let priority = bound.part.get(Slot::Priority).map(|won| optics::priority(&won.entry.value)).transpose()?;
        let mut faces = Vec::with_capacity(bound.faces.len());
        for (number, slots) in bound.faces.iter().enumerate() {
            faces.push(self.face(part, number, slots, &to_world)?);
        }
        Ok(Part {
            name: part.name.clone(),
            path: part.path.clone(),
            mesh: MeshId::from_index(part.mesh),
            to_world: place::in_metres(&to_world, self.unit_m, &self.assembly.axes),
            medium: self.medium(&bound.part)?,
            priority: priority.unwrap_or(0),
            faces,
        })
    }

    fn medium(&mut self, slots: &Slots) -> Result<Option<MediumId>> {
        let nm = self.wavelengths.traced_nm();
        let index = slots.get(Slot::Index).filter(|won| won.entry.key != "medium");
        let absorption = slots.get(Slot::Absorption).map(|won| optics::absorption(&won.entry.value, nm)).transpose()?;
        let Some(won) = index else { return Ok(None) };
        let (own, index) = optics::index(&won.entry.key, &won.entry.value, nm)?;
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
                let Some(text) = glass::find(name).and_then(|glass| glass.beyond(traced)) else { return };
                let note = Note { severity: Severity::Warning, at: value.at.clone(), text };
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

    fn face(&mut self, part: &Candidate, number: usize, slots: &Slots, to_world: &DAffine3) -> Result<Face> {
        let finish = match slots.get(Slot::Finish) {
            Some(won) => match optics::finish(&won.entry.value, &mut self.notes)? {
                FinishSpec::Given(finish) => finish,
                FinishSpec::Measured { file, at } => self.measured_finish(&file, &at)?,
            },
            // Only a face with a slide gets here without a finish.
            None => Finish::None,
        };
        let shape = match slots.get(Slot::Shape) {
            Some(won) => self.shape(part, number, &won.entry.value, to_world)?,
            None => Shape::Mesh,
        };
        let emitter = match slots.get(Slot::Emitter) {
            // `emitter = "none"` darkens what another carrier lights.
            Some(won) if won.entry.value.text() == Some("none") => None,
            Some(won) => {
                let spec = optics::emitter(self.sheet.emitters.follow(&won.entry.value)?, &mut self.notes)?;
                if spec.spectrum.is_none() && self.coloured() {
                    let (at, text) = (won.entry.value.at.clone(), "`spectrum` of emitter is not said: D65".to_owned());
                    self.notes.push(Note { severity: Severity::Info, at, text });
                }
                Some(self.emitter(part, number, spec)?)
            }
            None => None,
        };
        let slide = match slots.get(Slot::Slide) {
            Some(won) => self.slide(part, number, &won.entry.value)?,
            None => None,
        };
        Ok(Face { finish, coating: self.coating(part, number, slots, finish)?, shape, emitter, slide })
    }

    /// The finish of a file of measured scattering.
    fn measured_finish(&mut self, name: &str, at: &Where) -> Result<Finish> {
        let file = files::resolve(name, at);
        let known = self.scatters.iter().position(|table| Path::new(&table.file) == file);
        let index = match known {
            Some(index) => index,
            None => {
                let bytes = files::read(&file, at, "measured scattering")?;
                self.scatters.push(optics::scatter_table(&bytes, &file, at)?);
                self.files.push(file);
                self.scatters.len() - 1
            }
        };
        Ok(Finish::Measured { table: ScatterId::from_index(index) })
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
                return Err(
                    Fault::new(won.entry.at.clone(), what).expected("finish = \"polished\" there, or no coating")
                );
            }
            return Ok(None);
        }
        self.extrapolated(value);
        Ok(Some(CoatingId::from_index(intern(&mut self.coatings, coating))))
    }

    fn shape(&mut self, part: &Candidate, number: usize, value: &Value, to_world: &DAffine3) -> Result<Shape> {
        let spec = optics::shape(value, &mut self.notes)?;
        if spec == ShapeSpec::Exact(Shape::Mesh) {
            return Ok(Shape::Mesh);
        }
        let scale = place::uniform_scale(to_world).ok_or_else(|| {
            Fault::new(
                value.at.clone(),
                format!("part {} face {number} has an exact shape but its node is not scaled uniformly", part.path),
            )
            .expected("the same scale along all axes")
        })?;
        match spec {
            ShapeSpec::Exact(shape) => Ok(shape),
            ShapeSpec::Fit { surface, tolerance_um, radius, conic, tube_radius } => {
                let Some(source) = self.assembly.meshes.get(part.mesh) else { return Ok(Shape::Mesh) };
                let place = place::FacePlace { part: &part.path, number, at: &value.at };
                let order = place::FitOrder { surface, tolerance_um, radius, conic, tube_radius };
                place::fitted(&source.mesh, place, order, self.unit_m * scale, &mut self.notes)
            }
        }
    }
}
