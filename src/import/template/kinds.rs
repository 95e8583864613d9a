//! The distinct parts of an assembly, and what can be measured on their faces.

use super::TOLERANCE_UM;
use super::guess::{Role, role};
use crate::Assembly;
use crate::fit::{Fit, FitError, Fitted, fit, simple};
use crate::frames::uniform_scale;
use crate::measure::FaceMeasure;
use crate::select::{Candidate, candidates};
use eyebox_base::error::Result;
use eyebox_scene::Mesh;
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::rc::Rc;

/// A face in mesh units.
#[derive(Debug, Clone)]
pub struct FaceFacts {
    /// None for a face without triangles.
    pub measure: Option<FaceMeasure>,
    /// None where the part is scaled differently along its axes: it can have no exact shape.
    pub fit: Option<Result<Fit, FitError>>,
}

impl FaceFacts {
    pub fn area(&self) -> f64 {
        self.measure.map_or(0.0, |measure| measure.area)
    }
    pub fn normal(&self) -> Option<DVec3> {
        self.measure.and_then(|measure| measure.normal())
    }
    pub fn fitted(&self) -> Option<&Fit> {
        self.fit.as_ref().and_then(|fit| fit.as_ref().ok())
    }
    pub fn is_plane(&self) -> bool {
        self.fitted().is_some_and(|fit| matches!(fit.surface, Fitted::Plane { .. }))
    }

    /// Whether two faces are copies, as far as f32 vertices tell.
    fn same(&self, other: &FaceFacts) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * a.abs().max(b.abs());
        let side = |facts: &FaceFacts| facts.normal();
        near(self.area(), other.area())
            && match (side(self), side(other)) {
                (Some(a), Some(b)) => a.dot(b) > 1.0 - 1e-6,
                (None, None) => true,
                (Some(_), None) | (None, Some(_)) => false,
            }
            && match (self.fitted(), other.fitted()) {
                (Some(a), Some(b)) => a.surface.kind() == b.surface.kind(),
                (None, None) => true,
                (Some(_), None) | (None, Some(_)) => false,
            }
    }
}

/// Parts that are copies of each other.
#[derive(Debug)]
pub struct Kind {
    pub role: Role,
    pub members: Vec<Candidate>,
    /// What `path = ` selects exactly these; none if no path does, or for mechanics.
    pub path: Option<String>,
    pub faces: Rc<Vec<FaceFacts>>,
    /// Metres per mesh unit.
    pub metres: f64,
    /// Extent along the mesh's axes, mesh units.
    pub size: Option<DVec3>,
}

/// The kinds in the order of their first members. Faults: those of [`candidates`].
pub fn kinds(assembly: &Assembly, unit_m: f64) -> Result<Vec<Kind>> {
    let parts = candidates(assembly)?;
    let mut known: HashMap<(usize, u64, bool), Rc<Vec<FaceFacts>>> = HashMap::new();
    let mut kinds: Vec<Kind> = Vec::new();
    let mut by_stem: HashMap<String, Vec<usize>> = HashMap::new();
    for part in &parts {
        let to_world = assembly.nodes.get(part.node).map_or(DAffine3::IDENTITY, |node| node.to_world);
        let scale = uniform_scale(&to_world);
        let metres = unit_m * scale.unwrap_or_else(|| to_world.matrix3.determinant().abs().cbrt());
        let Some(mesh) = assembly.meshes.get(part.mesh).map(|source| &source.mesh) else { continue };
        let role = role(&part.name);
        let freeforms = matches!(role, Role::Lens(_) | Role::Plate(_) | Role::Mirror);
        let key = (part.mesh, scale.map_or(0, f64::to_bits), freeforms);
        let make = || Rc::new(facts(mesh, scale.map(|_| metres), freeforms));
        let faces = known.entry(key).or_insert_with(make).clone();
        let stem = part.path.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
        let same = |kind: &Kind| {
            kind.faces.len() == faces.len()
                && (kind.metres - metres).abs() <= 1e-6 * metres
                && (Rc::ptr_eq(&kind.faces, &faces) || kind.faces.iter().zip(faces.iter()).all(|(a, b)| a.same(b)))
        };
        let slots = by_stem.entry(stem).or_default();
        if let Some(kind) =
            slots.iter().find(|slot| kinds.get(**slot).is_some_and(same)).and_then(|slot| kinds.get_mut(*slot))
        {
            kind.members.push(part.clone());
            continue;
        }
        slots.push(kinds.len());
        let size = size(mesh);
        kinds.push(Kind { role, members: vec![part.clone()], path: None, faces, metres, size });
    }
    let mut all = Vec::with_capacity(kinds.len());
    for mut kind in kinds {
        if kind.role == Role::Mechanics {
            // Nothing is bound to it.
            all.push(kind);
            continue;
        }
        kind.path = path(&kind.members, &parts);
        if kind.path.is_some() || kind.members.len() == 1 {
            all.push(kind);
            continue;
        }
        // No pattern selects exactly these: one by one.
        let alone = |member: Candidate| Kind {
            role: kind.role,
            path: path(std::slice::from_ref(&member), &parts),
            members: vec![member],
            faces: kind.faces.clone(),
            metres: kind.metres,
            size: kind.size,
        };
        all.extend(std::mem::take(&mut kind.members).into_iter().map(alone));
    }
    Ok(all)
}

/// `metres` per mesh unit, if faces can be fitted. `freeforms`: also these, which mechanics aren't searched for.
fn facts(mesh: &Mesh, metres: Option<f64>, freeforms: bool) -> Vec<FaceFacts> {
    let one = |face: usize| {
        let range = mesh.faces.get(face);
        let triangles = range.and_then(|range| {
            let end = range.first.checked_add(range.count)?;
            mesh.triangles.get(range.first as usize..end as usize).filter(|triangles| !triangles.is_empty())
        });
        let fit = metres.zip(triangles);
        let fit = fit.map(|(metres, triangles)| fit_of(mesh, triangles, metres, freeforms));
        FaceFacts { measure: FaceMeasure::new(mesh, face), fit }
    };
    (0..mesh.faces.len()).map(one).collect()
}

fn fit_of(mesh: &Mesh, triangles: &[[u32; 3]], metres: f64, freeforms: bool) -> Result<Fit, FitError> {
    let tolerance = TOLERANCE_UM * 1e-6 / metres;
    match freeforms {
        true => fit(&mesh.positions, triangles, None, tolerance),
        false => simple(&mesh.positions, triangles, tolerance),
    }
}

fn size(mesh: &Mesh) -> Option<DVec3> {
    let points = mesh.positions.iter().map(|point| DVec3::from_array(point.map(f64::from)));
    let found = points.fold(None, |found: Option<(DVec3, DVec3)>, point| {
        let (low, high) = found.unwrap_or((point, point));
        Some((low.min(point), high.max(point)))
    });
    found.map(|(low, high)| high - low)
}

/// The shortest path or pattern that selects exactly `members`.
fn path(members: &[Candidate], parts: &[Candidate]) -> Option<String> {
    let first = members.first()?;
    let own = |part: &Candidate| part.short.clone().unwrap_or_else(|| part.path.clone());
    let exactly = |pattern: &String| {
        let mut chosen = parts.iter().filter(|part| part.has_path(pattern)).map(|part| part.node);
        members.iter().all(|member| chosen.next() == Some(member.node)) && chosen.next().is_none()
    };
    let pattern = match members {
        [_] => own(first),
        _ => format!("{}*", own(first).trim_end_matches(|c: char| c.is_ascii_digit())),
    };
    let whole = || Some(first.path.clone()).filter(|_| members.len() == 1);
    Some(pattern).filter(&exactly).or_else(|| whole().filter(&exactly))
}
