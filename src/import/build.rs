//! Assembly + sidecar + `--set` → [`Scene`]: the attributes are bound, read and put where they belong.

use super::assembly::{Assembly, RequestedLayer};
use super::asset_attributes::AssetAttributes;
use super::bind::bind;
use super::binding_slots::{PartBound, Rank, Slot, Slots};
use super::defaults;
use super::enclosed::Bodies;
use super::explain::Explained;
use super::files;
use super::frames;
use super::gltf::{large_by_its_unit, looks_like_millimetres};
use super::optics;
use super::ray_lamps::KnownRays;
use super::select::{Candidate, candidates, listed};
use super::set::Set;
use super::surfaces::Surfaces;
use super::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Shared, Where};
use eyebox_scene::{
    Beacon, Coating, Face, Grating, Group, LuminousProfile, Medium, Note, Part, ScatterTable, Scene, Slide,
    StandardSurface, WavePlate, Wavelengths,
};
use glam::DMat3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene, and which line said what.
#[derive(Debug, Clone)]
pub struct Built {
    pub scene: Scene,
    pub explained: Explained,
    /// The layers that the asset asks for.
    pub layers: Vec<RequestedLayer>,
    /// The asset's own file, and its world → the scene's world, a turn that leaves lengths.
    pub asset: PathBuf,
    pub axes: DMat3,
    pub assumed: Assumed,
}

/// What nobody says of a bare asset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumed {
    /// The scene's eye is the one that frames the asset.
    pub eye: bool,
    /// The scene's sky is overcast, with as much light as a uniform one of `sky_cd_m2`.
    pub sky: bool,
    pub sky_cd_m2: f64,
}

/// Builds the scene of `assembly`. `assembly.dependencies` (the sidecar among them, if it was a file) are hashed.
///
/// Faults: whatever is wrong with the sidecar, the asset's attributes, the sets or the pictures they name; parts that
/// nothing binds; no eye.
pub fn build(assembly: Assembly, sidecar: Option<&Value>, sets: &[Set]) -> Result<Built> {
    build_within(assembly, sidecar, sets, super::TEXTURE_BYTES)
}

/// [`build`], with so much memory for textures.
pub(super) fn build_within(
    assembly: Assembly,
    sidecar: Option<&Value>,
    sets: &[Set],
    texture_bytes: u64,
) -> Result<Built> {
    let mut sheet = AssetAttributes::new(sidecar, assembly.optics.as_ref())?;
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
    // Nobody has said what any part is optically: the asset is a picture as it looks.
    let bare =
        sheet.default.is_none() && sheet.binds.is_empty() && sets_nothing(&bound) && !assembly.says_what_parts_are();
    if !bare {
        let seen = covered(&parts, &bound, &assembly)?;
        if !sheet.binds.is_empty() && !seen.is_empty() {
            let names = listed(seen.iter().map(|part| part.path.as_str()));
            let text = format!("no finish binds faces of {names}: they look as their materials say");
            notes.push(Note::info(Where::file(&assembly.file), text));
        }
    }
    let explained = Explained::new(&parts, &bound);

    let wavelengths = optics::wavelengths(sheet.wavelengths.as_ref(), &mut notes)?;
    let unit_m = match &sheet.unit {
        Some(value) => {
            let unit = optics::unit(value)?;
            let text = format!("unit {unit} m replaces the {} m that the asset declares", assembly.unit_m);
            notes.push(Note::info(value.at.clone(), text));
            notes.extend(large_by_its_unit(&assembly, unit, value.at.clone()));
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
        wave_plates: Vec::new(),
        gratings: Vec::new(),
        surfaces: Vec::new(),
        read: Surfaces::expecting(&bound),
        texture_bytes,
        groups: Vec::new(),
        profiles: Vec::new(),
        measured: HashMap::new(),
        ray_files: HashMap::new(),
        beacons: Vec::new(),
        pictures: HashMap::new(),
        files: assembly.dependencies.clone(),
        notes,
    };
    builder.unused(&bound)?;
    let mut scene_parts: Vec<Part> = parts
        .iter()
        .zip(&bound)
        .enumerate()
        .map(|(i, (part, bound))| builder.part(i, part, bound))
        .collect::<Result<_>>()?;
    let (sky, its_sun) = match &sheet.sky {
        Some(value) => {
            let (sky, sun) = builder.sky(value)?;
            (Some(sky), sun)
        }
        None => (None, None),
    };
    let sun = match &sheet.sun {
        Some(value) if its_sun.is_some() => {
            return Err(Error::new(value.at.clone(), "the sky has a sun already, that of its `sun_sky`")
                .expected("one of sun_sky and [sun]"));
        }
        Some(value) => Some(builder.sun(value)?),
        None => its_sun,
    };
    let bodies = Bodies { assembly: &assembly, unit_m, parts: &scene_parts, surfaces: &builder.surfaces };
    let said = frames::eye(&bodies, sheet.eye.as_ref(), bare, &mut builder.notes)?;
    let assumes_eye = said.is_none();
    let eye = match said {
        Some(eye) => eye,
        None => {
            let assumed_eye = || defaults::eye(&assembly, unit_m, defaults::RESOLUTION, defaults::FOV_DEG);
            let (eye, note) = if bare { assumed_eye() } else { None }
                .ok_or_else(|| if bare { no_surface(&assembly) } else { no_eye(sidecar, &assembly.file) })?;
            builder.notes.push(note);
            eye
        }
    };
    let mut made = builder.lights(sky.as_ref().map(|sky| sky.group), eye.position)?;
    made.lights.extend(sun.into_iter().chain(std::mem::take(&mut builder.beacons)));
    let sky = sky.or(made.dome.take());
    // Glowing pictures on things are how those look; what lights a scene shines evenly.
    let shines = |face: &Face| face.emitter.as_ref().is_some_and(|emitter| emitter.pattern.is_none());
    let lit = |parts: &[Part]| parts.iter().flat_map(|part| &part.faces).any(shines);
    let dark = sky.is_none() && made.lights.is_empty() && !lit(&scene_parts) && !lit(&made.parts);
    let assumed = Assumed { eye: assumes_eye, sky: bare && dark, sky_cd_m2: defaults::SKY_CD_M2 };
    let sky = if assumed.sky { Some(builder.assumed_sky(assumed.sky_cd_m2)) } else { sky };
    scene_parts.append(&mut made.parts);
    let Builder {
        media,
        coatings,
        slides,
        scatters,
        wave_plates,
        gratings,
        surfaces,
        groups,
        profiles,
        files,
        mut notes,
        ..
    } = builder;
    let hash = hash(&files, sets, &assembly.variants)?;
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
    let meshes = assembly
        .meshes
        .into_iter()
        .map(|source| source.mesh)
        .chain(made.meshes.into_iter().map(Shared::from))
        .collect();
    let mut scene = Scene {
        name,
        unit_m,
        wavelengths,
        meshes,
        parts: scene_parts,
        media,
        coatings,
        slides,
        scatters,
        wave_plates,
        gratings,
        surfaces,
        groups,
        profiles,
        lights: made.lights,
        sky,
        eye,
        notes: seen,
        hash,
    };
    scene.laminate()?;
    Ok(Built { scene, explained, layers: assembly.layers, asset: assembly.file, axes: assembly.axes, assumed })
}

/// Whether no `--set` says anything of a part.
fn sets_nothing(bound: &[PartBound]) -> bool {
    let slots = bound.iter().flat_map(|part| std::iter::once(&part.part).chain(&part.faces));
    slots.flat_map(Slots::all).all(|won| won.rank != Rank::Set)
}

fn no_eye(sidecar: Option<&Value>, file: &Path) -> Box<Error> {
    Error::new(super::asset_attributes::place(sidecar, file), "there is no eye")
        .expected("an [eye], or a perspective camera in the asset")
        .code(Code::EyeMissing)
}

/// An asset of which nothing can be seen.
fn no_surface(assembly: &Assembly) -> Box<Error> {
    let unread = match assembly.unread.as_slice() {
        [] => String::new(),
        kinds => format!(" (geometry of type {} is not read)", listed(kinds.iter().map(String::as_str))),
    };
    Error::new(Where::file(&assembly.file), format!("nothing in the asset has a surface{unread}"))
        .expected("a mesh or a shape to look at")
        .code(Code::NothingToTrace)
}

/// Where somebody has begun to say what parts are, every face must have a finish, a slide or a look of its own. Returns the
/// parts of which faces have only that.
fn covered<'p>(parts: &'p [Candidate], bound: &[PartBound], assembly: &Assembly) -> Result<Vec<&'p Candidate>> {
    let looks = |part: &Candidate, face: usize| {
        let materials = assembly.meshes.get(part.mesh).map_or(&[][..], |source| source.materials.as_slice());
        let material = materials.get(face).copied().flatten().and_then(|index| assembly.materials.get(index));
        let painted = || assembly.meshes.get(part.mesh).is_some_and(|source| !source.mesh.colors.is_empty());
        material.is_some_and(|material| material.surface.is_some()) || painted()
    };
    let by_look = |slots: &Slots| slots.finish().is_none() && slots.get(Slot::Slide).is_none();
    let unsaid = |slots: &Slots| by_look(slots) && slots.get(Slot::Finish).is_none();
    let open = |part: &Candidate, bound: &PartBound| -> Vec<usize> {
        let faces = bound.faces.iter().enumerate().filter(|(_, slots)| by_look(slots));
        faces.map(|(face, _)| face).filter(|face| !looks(part, *face)).collect()
    };
    let seen = parts.iter().zip(bound).filter(|(_, bound)| bound.faces.iter().any(unsaid)).map(|(part, _)| part);
    let seen = seen.collect();
    let bare: Vec<(&Candidate, &PartBound, Vec<usize>)> = parts
        .iter()
        .zip(bound)
        .map(|(part, bound)| (part, bound, open(part, bound)))
        .filter(|row| !row.2.is_empty())
        .collect();
    let Some((first, slots, faces)) = bare.first() else { return Ok(seen) };
    let at = Where::file(&assembly.file);
    let wholly = |bound: &PartBound| bound.faces.iter().all(|face| face.all().next().is_none());
    if wholly(slots) || bare.len() > 1 {
        let names = listed(bare.iter().map(|(part, _, _)| part.path.as_str()));
        let parts = if bare.len() == 1 { "part" } else { "parts" };
        return Err(Error::new(at, format!("no optical attributes bind {parts} {names}"))
            .expected("a finish for every face: a [[bind]] or [default] finish = \"absorber\"")
            .code(Code::PartUnbound));
    }
    let numbers: Vec<String> = faces.iter().map(usize::to_string).collect();
    let faces = listed(numbers.iter().map(String::as_str));
    Err(Error::new(Where::part(&first.path), format!("no finish binds face {faces}"))
        .expected("a finish for every face: a [[bind]] or [default] finish = \"absorber\"")
        .code(Code::PartUnbound))
}

/// blake3 of all input bytes, each file preceded by its length, then the sets and the variants.
fn hash(files: &[PathBuf], sets: &[Set], variants: &[String]) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        files::hash(&mut hasher, file, &Where::Nowhere, "input file").map_err(|fault| fault.code(Code::FileMissing))?;
    }
    for text in sets.iter().map(|set| &set.text).chain(variants) {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// The picture of a slide: width, height, luminance and, if wanted, colour.
pub(super) type Known = (usize, usize, Arc<Vec<f32>>, Option<Arc<Vec<[f32; 3]>>>);

pub(super) struct Builder<'a> {
    pub(super) assembly: &'a Assembly,
    pub(super) sheet: &'a AssetAttributes,
    pub(super) wavelengths: Wavelengths,
    pub(super) unit_m: f64,
    pub(super) media: Vec<Medium>,
    pub(super) coatings: Vec<Coating>,
    pub(super) slides: Vec<Slide>,
    pub(super) scatters: Vec<ScatterTable>,
    pub(super) wave_plates: Vec<WavePlate>,
    pub(super) gratings: Vec<Grating>,
    pub(super) surfaces: Vec<Shared<StandardSurface>>,
    /// What was read of ordinary materials.
    pub(super) read: Surfaces,
    /// What textures may take of memory.
    pub(super) texture_bytes: u64,
    pub(super) groups: Vec<Group>,
    pub(super) profiles: Vec<LuminousProfile>,
    /// Profiles as their files say, by file.
    pub(super) measured: HashMap<PathBuf, LuminousProfile>,
    /// Ray files, by file, and the lamps that they have become.
    pub(super) ray_files: HashMap<PathBuf, KnownRays>,
    pub(super) beacons: Vec<Beacon>,
    /// Pictures of slides by file.
    pub(super) pictures: HashMap<(PathBuf, Option<String>, [u64; 3]), Known>,
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
            self.notes.push(Note::info(value.at.clone(), text).code(Code::NamedUnused));
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
}
