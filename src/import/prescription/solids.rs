//! Parts of a prescription: a solid for each space of glass, a sheet for each mirror, a disc for stop and image.

use super::mesh::{cap, rim};
use super::{After, Outline, Prescription, Surface};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::assembly::{MeshSource, Node};
use eyebox_scene::{Mesh, Note, assembly::Assembly};
use glam::{DAffine3, DVec3};
use std::path::Path;

/// A part, and what its faces are: indices of surfaces, or none of what is black.
#[derive(Debug, Clone)]
pub(super) struct LensPart {
    pub name: String,
    pub kind: Kind,
    /// Per face: the surface that it is, or none for the rim.
    pub faces: Vec<Option<usize>>,
    /// The surface whose axes are the part's.
    pub frame: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// The surface that the glass is behind of.
    Glass(usize),
    Mirror,
    /// Light that misses the hole ends here.
    Stop,
    /// Light that meets it ends here.
    Obscuration,
    Image,
}

pub(super) struct Design {
    pub assembly: Assembly,
    pub parts: Vec<LensPart>,
    pub notes: Vec<Note>,
    /// Where the eye stands: at the stop if light meets it first, else this far before the first surface.
    pub eye_at: DVec3,
}

/// A surface that light meets, and what is behind it: none for air.
struct Met<'p> {
    index: usize,
    surface: &'p Surface,
    /// The surface that names the glass behind it.
    glass: Option<usize>,
}

pub(super) fn design(prescription: &Prescription, frames: &[DAffine3], path: &Path) -> Result<Design> {
    let met = met(prescription);
    let [_, .., image] = met.as_slice() else {
        return Err(Error::new(Where::file(path), "holds no lens").expected("surfaces between object and image"));
    };
    let optical = |met: &&Met<'_>| met.glass.is_some() || met.surface.after == After::Mirror;
    let first = met.iter().find(optical).unwrap_or(image).index;
    let stop = met.iter().find(|met| met.surface.stop).map(|met| met.index);
    let mut notes = Vec::new();
    let mut maker = Maker { frames, path, assembly: Assembly::default(), parts: Vec::new() };
    let mut known: Vec<(DVec3, DVec3)> = Vec::new();
    for pair in met.windows(2) {
        let [front, back] = pair else { continue };
        if front.glass.is_some() {
            let ends = [front, back].map(|met| frames[met.index].translation);
            // Light that comes back through a solid meets it again.
            let near = |a: DVec3, b: DVec3| a.distance(b) <= 1e-9 * (1.0 + ends[0].distance(ends[1]));
            let again = |(a, b): &(DVec3, DVec3)| {
                near(*a, ends[1]) && near(*b, ends[0]) || near(*a, ends[0]) && near(*b, ends[1])
            };
            if !known.iter().any(again) {
                known.push((ends[0], ends[1]));
                maker.solid(front, back, &met)?;
            }
        }
    }
    for (place, mirror) in met.iter().enumerate().filter(|(_, met)| met.surface.after == After::Mirror) {
        let before = place.checked_sub(1).and_then(|before| met.get(before));
        if before.is_none_or(|before| before.glass.is_none()) && mirror.glass.is_none() {
            let ends = maker.ends(mirror.surface)?;
            let hole = mirror.surface.hole / ends.half[0].min(ends.half[1]);
            maker.sheet(mirror, Kind::Mirror, (ends, if hole < 1.0 { hole } else { 0.0 }))?;
        }
    }
    if let Some(stop) = met.iter().find(|met| Some(met.index) == stop && met.index > first && met.index != image.index)
        && stop.glass.is_none()
        && stop.surface.after == After::Air
        && stop.surface.semi_diameter > 0.0
        && !touches_glass(&met, stop.index)
    {
        let hole = stop.surface.semi_diameter;
        maker.sheet(stop, Kind::Stop, (Outline::round(2.0 * hole), 0.5))?;
    }
    for at in met.iter().filter(|met| met.index != image.index) {
        let Some(dark) = at.surface.dark else { continue };
        if stop.is_some_and(|stop| stop == at.index && stop < first) {
            let text = "the obscuration of the entrance stop is not taken over: the eye is there".to_owned();
            notes.push(Note::info(Where::Line { file: path.to_owned(), line: at.surface.line }, text));
        } else if at.glass.is_none() && at.surface.after == After::Air && !touches_glass(&met, at.index) {
            maker.sheet(at, Kind::Obscuration, dark)?;
        } else {
            let text = "the obscuration of a glass or a mirror is not taken over: nothing stops light there".to_owned();
            notes.push(Note::info(Where::Line { file: path.to_owned(), line: at.surface.line }, text));
        }
    }
    if image.surface.semi_diameter > 0.0 {
        maker.sheet(image, Kind::Image, (maker.ends(image.surface)?, 0.0))?;
    } else {
        let text = "the image has no size: nothing shines there".to_owned();
        notes.push(Note::info(Where::Line { file: path.to_owned(), line: image.surface.line }, text));
    }
    let eye_at = match stop.filter(|stop| *stop < first) {
        Some(stop) => frames[stop].translation,
        None => {
            let back = prescription.surfaces[first].semi_diameter.max(prescription.pupil.unwrap_or(0.0));
            let [x, y] = prescription.surfaces[first].outline.map_or([0.0; 2], |outline| outline.centre);
            frames[first].transform_point3(DVec3::new(x, y, -2.0 * back))
        }
    };
    let Maker { mut assembly, parts, .. } = maker;
    if parts.is_empty() {
        return Err(Error::new(Where::file(path), "holds no lens and no mirror").expected("a glass or MIRROR"));
    }
    assembly.file = path.to_owned();
    Ok(Design { assembly, parts, notes, eye_at })
}

/// Surfaces but the object and coordinate breaks, which are not met.
fn met(prescription: &Prescription) -> Vec<Met<'_>> {
    let mut medium = None;
    let mut out = Vec::new();
    for (index, surface) in prescription.surfaces.iter().enumerate().skip(1).filter(|(_, s)| s.turn.is_none()) {
        match surface.after {
            After::Air => medium = None,
            After::Glass { .. } | After::Model(_) | After::Private(_) => medium = Some(index),
            After::Mirror => {}
        }
        out.push(Met { index, surface, glass: medium });
    }
    if let Some(last) = out.last_mut() {
        last.glass = None;
    }
    out
}

fn touches_glass(met: &[Met<'_>], index: usize) -> bool {
    let place = met.iter().position(|met| met.index == index).unwrap_or(0);
    met[place].glass.is_some() || place.checked_sub(1).is_some_and(|before| met[before].glass.is_some())
}

struct Maker<'p> {
    frames: &'p [DAffine3],
    path: &'p Path,
    assembly: Assembly,
    parts: Vec<LensPart>,
}

impl Maker<'_> {
    fn fault(&self, surface: &Surface, what: &str) -> Box<Error> {
        Error::new(Where::Line { file: self.path.to_owned(), line: surface.line }, what)
    }

    fn ends(&self, surface: &Surface) -> Result<Outline> {
        surface.ends().ok_or_else(|| {
            self.fault(surface, "the surface has no size").expected("a semi-diameter (DIAM, CLAP or FLAP)")
        })
    }

    /// The solid between two surfaces: front, rim, back. Both end at the larger of their sizes, or where they meet.
    fn solid(&mut self, front: &Met<'_>, back: &Met<'_>, met: &[Met<'_>]) -> Result<()> {
        let to_front = self.frames[front.index].inverse() * self.frames[back.index];
        // Cemented ones have one rim.
        let place = met.iter().position(|met| met.index == front.index).unwrap_or(0);
        let from = (0..place).rev().take_while(|i| met[*i].glass.is_some()).last().unwrap_or(place);
        let to = (place..met.len()).take_while(|i| met[*i].glass.is_some()).last().unwrap_or(place) + 1;
        let chain = met.get(from..=to).unwrap_or(&[]).iter();
        let wanted = chain.map(|met| met.surface.semi_diameter).fold(0.0, f64::max);
        let own = front.surface.semi_diameter.max(back.surface.semi_diameter);
        // What the file says of one face alone holds for both.
        let ends = match [front, back].map(|met| met.surface.outline) {
            [Some(front), Some(back)] => vec![[front, back]],
            [Some(one), None] | [None, Some(one)] => vec![[one; 2]],
            [None, None] if wanted > 0.0 => [wanted, own].map(|radius| [Outline::round(radius); 2]).to_vec(),
            [None, None] => {
                return Err(self
                    .fault(front.surface, "the glass has no size")
                    .expected("a semi-diameter (DIAM, CLAP or FLAP)"));
            }
        };
        let profiles = [&front.surface.profile, &back.surface.profile];
        let thickness = to_front.translation.z;
        let side = if thickness < 0.0 { -1.0 } else { 1.0 };
        // Whether something is between the faces all around; not where one of them does not reach.
        let open = |[front, back]: [Outline; 2]| {
            front.around().zip(back.around()).all(|(at_front, at_back)| {
                let [a, b] = [(profiles[0], at_front), (profiles[1], at_back)].map(|(p, [x, y])| p.sag(x, y));
                let (Some(a), Some(b)) = (a, b) else { return false };
                let [a, b] = [a, to_front.transform_point3(DVec3::new(at_back[0], at_back[1], b)).z];
                side * (b - a) > 0.0
            })
        };
        let largest = ends[ends.len() - 1];
        let found = ends.iter().copied().find(|ends| open(*ends)).or_else(|| {
            let smaller = |k: u32| largest.map(|outline| outline.scaled(f64::from(k) / 1000.0));
            (1..1000).rev().map(smaller).find(|ends| open(*ends))
        });
        let Some([at_front, at_back]) = found else {
            return Err(self
                .fault(front.surface, "the faces of this glass cross on the axis")
                .expected("a thickness that keeps them apart"));
        };
        let name = named(
            front.surface,
            &format!("L{}", self.parts.iter().filter(|p| matches!(p.kind, Kind::Glass(_))).count() + 1),
        );
        let mut mesh = Mesh { name: name.clone(), ..Mesh::default() };
        // Outwards is against the light at the front, with it at the back.
        cap(&mut mesh, profiles[0], &DAffine3::IDENTITY, (at_front, 0.0), -side);
        rim(&mut mesh, &[(profiles[0], DAffine3::IDENTITY, at_front), (profiles[1], to_front, at_back)], side);
        cap(&mut mesh, profiles[1], &to_front, (at_back, 0.0), side);
        let faces = vec![Some(front.index), None, Some(back.index)];
        let glass = front.glass.unwrap_or(front.index);
        self.add(mesh, LensPart { name, kind: Kind::Glass(glass), faces, frame: front.index });
        Ok(())
    }

    /// A surface by itself, without this share of it in the middle; it looks towards the light.
    fn sheet(&mut self, at: &Met<'_>, kind: Kind, (ends, inner): (Outline, f64)) -> Result<()> {
        let base = match kind {
            Kind::Mirror => format!("M{}", self.parts.iter().filter(|part| part.kind == Kind::Mirror).count() + 1),
            Kind::Stop => "STOP".to_owned(),
            Kind::Obscuration => {
                format!("OBSCURATION{}", self.parts.iter().filter(|part| part.kind == Kind::Obscuration).count() + 1)
            }
            Kind::Image => "IMAGE".to_owned(),
            Kind::Glass(_) => "L".to_owned(),
        };
        let name = named(at.surface, &base);
        let mut mesh = Mesh { name: name.clone(), ..Mesh::default() };
        let profile = &at.surface.profile;
        let Some(outer) =
            Some(ends).filter(|ends| ends.within(profile)).or_else(|| ends.shrunk(|own| own.within(profile)))
        else {
            return Err(self.fault(at.surface, "the surface does not exist off its axis").expected("a finite curve"));
        };
        // Light arrives along the way from the surface before.
        let before = self.frames[..at.index].iter().rev().map(|frame| frame.translation);
        let here = &self.frames[at.index];
        let way = before.map(|from| here.translation - from).find(|way| way.length() > 0.0).unwrap_or(DVec3::Z);
        let side = if here.matrix3.z_axis.dot(way) < 0.0 { 1.0 } else { -1.0 };
        cap(&mut mesh, profile, &DAffine3::IDENTITY, (outer, inner), side);
        self.add(mesh, LensPart { name, kind, faces: vec![Some(at.index)], frame: at.index });
        Ok(())
    }

    fn add(&mut self, mesh: Mesh, part: LensPart) {
        let at = Where::Part { path: part.name.clone(), face: None };
        let count = mesh.faces.len();
        self.assembly.nodes.push(Node {
            name: part.name.clone(),
            path: part.name.clone(),
            parent: None,
            local: self.frames[part.frame],
            to_world: self.frames[part.frame],
            mesh: Some(self.assembly.meshes.len()),
            attributes: None,
            user: Vec::new(),
            at: at.clone(),
        });
        let (materials, attributes) = (vec![None; count], vec![None; count]);
        self.assembly.meshes.push(MeshSource {
            mesh: mesh.into(),
            materials,
            attributes,
            rig: None,
            implicit: None,
            at,
        });
        self.parts.push(part);
    }
}

/// The part's name: what the file says of its surface behind a number of its own, so that no two are alike.
fn named(surface: &Surface, base: &str) -> String {
    let words: Vec<&str> = surface
        .comment
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '-')
        .filter(|word| !word.is_empty())
        .collect();
    if words.is_empty() { base.to_owned() } else { format!("{base}_{}", words.join("_")) }
}
