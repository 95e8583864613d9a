//! Recovers the exact surface of a CAD face from the points of its mesh: plane, sphere, cylinder, conic of revolution or
//! torus, by orthogonal least squares in f64. Positions are good to f32; the file's normals are not used.

mod conic;
mod conics;
mod fault;
mod linalg;
mod plane;
mod pole;
mod refine;
mod start;
mod task;
mod torus; // cylinders and tori

#[cfg(test)]
pub(crate) mod cad;
#[cfg(test)]
mod cad_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod torus_tests;

pub use fault::FitError;

use super::weld::{rounding, weld};
use glam::DVec3;
use pole::Face;
use task::{Scale, Task};

/// What to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Plane,
    Sphere,
    Cylinder,
    Conic,
    Toroid,
}

impl Kind {
    /// From the simplest on.
    pub const ALL: [Kind; 5] = [Kind::Plane, Kind::Sphere, Kind::Cylinder, Kind::Conic, Kind::Toroid];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Plane => "plane",
            Kind::Sphere => "sphere",
            Kind::Cylinder => "cylinder",
            Kind::Conic => "conic",
            Kind::Toroid => "toroid",
        }
    }

    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// An exact surface in mesh units. `axis` is a unit vector and `radius` > 0: the centre of curvature is vertex +
/// radius·axis.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fitted {
    /// `axis` is the normal, on the side that the triangles face; `vertex` is the mean of the points.
    Plane { vertex: DVec3, axis: DVec3 },
    /// `vertex` is the pole amid the face.
    Sphere { vertex: DVec3, axis: DVec3, radius: f64 },
    /// ρ² = 2·radius·z − (1 + conic)·z² about `axis`; a hyperboloid's sheet is the one through `vertex`, an ellipsoid's
    /// vertex is the pole nearer to the face.
    Conic { vertex: DVec3, axis: DVec3, radius: f64, conic: f64 },
    /// As [`Shape::Cylinder`](crate::scene::Shape): `vertex` is amid the face.
    Cylinder { vertex: DVec3, axis: DVec3, x: DVec3, radius: f64 },
    /// As [`Shape::Toroid`](crate::scene::Shape), `tube_radius` of either sign: `vertex` is on the equator amid the face.
    Toroid { vertex: DVec3, axis: DVec3, x: DVec3, radius: f64, tube_radius: f64 },
}

impl Fitted {
    pub fn kind(&self) -> Kind {
        match self {
            Fitted::Plane { .. } => Kind::Plane,
            Fitted::Sphere { .. } => Kind::Sphere,
            Fitted::Conic { .. } => Kind::Conic,
            Fitted::Cylinder { .. } => Kind::Cylinder,
            Fitted::Toroid { .. } => Kind::Toroid,
        }
    }
}

/// A surface and how far the points lie from it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Fit {
    pub surface: Fitted,
    /// Root mean square and largest orthogonal distance of the points, mesh units.
    pub rms: f64,
    pub max_residual: f64,
    /// Distinct points that were fitted.
    pub points: usize,
}

/// Fits the points of one CAD face.
///
/// `points`: mesh positions; `triangles`: the face's triangles (counter-clockwise from outside). Only vertices that
/// triangles use count, coincident ones once; with no triangles at all, every vertex counts. `kind`: what to fit, or
/// None for the first of plane, sphere, cylinder, conic, toroid that meets `tolerance`. `tolerance`: largest orthogonal distance
/// allowed, mesh units; what rounding to f32 can do to the coordinates is always allowed.
///
/// A conic's axis and vertex are found with it (7 unknowns). What the points do not determine stays at the simplest
/// value: a conic asked for on a sphere has its axis amid the face.
///
/// Errors: coordinates that are not finite, indices out of range, too few or degenerate points, or the best surface
/// misses the tolerance.
pub fn fit(points: &[[f32; 3]], triangles: &[[u32; 3]], kind: Option<Kind>, tolerance: f64) -> Result<Fit, FitError> {
    let (face, scale) = prepare(points, triangles)?;
    let noise = rounding(points);
    let allowed = tolerance.max(noise); // also where the tolerance is not a number
    let task = Task::new(face, scale, noise / scale.size, allowed / scale.size);
    let judged = |fit: Fit| match fit.max_residual <= allowed {
        true => Ok(fit),
        false => Err(FitError::Misses {
            kind: fit.surface.kind(),
            asked: kind.is_some(),
            rms: fit.rms,
            max: fit.max_residual,
            tolerance: allowed,
        }),
    };
    match kind {
        Some(Kind::Plane) => judged(task.plane()?),
        Some(Kind::Sphere) => judged(task.sphere()?.1),
        Some(Kind::Cylinder) => judged(task.round(Kind::Cylinder)?),
        Some(Kind::Toroid) => judged(task.round(Kind::Toroid)?),
        Some(Kind::Conic) => judged(task.conic(task.sphere().ok().map(|(start, _)| start))?),
        None => task.simplest(judged),
    }
}

fn prepare(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(Face, Scale), FitError> {
    let mut used = vec![triangles.is_empty(); points.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &index in corners {
            let slot = usize::try_from(index).ok().and_then(|i| used.get_mut(i));
            *slot.ok_or(FitError::BadIndex { triangle, index, points: points.len() })? = true;
        }
    }
    if let Some(vertex) = points.iter().zip(&used).position(|(p, used)| *used && p.iter().any(|x| !x.is_finite())) {
        return Err(FitError::NotFinite { vertex });
    }
    let (vertices, used): (Vec<usize>, Vec<[f32; 3]>) =
        points.iter().enumerate().filter(|(vertex, _)| used[*vertex]).map(|(vertex, point)| (vertex, *point)).unzip();
    let first = weld(&used, rounding(points));
    let mut slot = vec![usize::MAX; points.len()];
    let mut kept: Vec<DVec3> = Vec::new();
    for (i, (&vertex, point)) in vertices.iter().zip(&used).enumerate() {
        slot[vertex] = match first[i] < i {
            true => slot[vertices[first[i]]],
            false => {
                kept.push(DVec3::from_array(point.map(f64::from)));
                kept.len() - 1
            }
        };
    }
    if kept.len() < 3 {
        return Err(FitError::TooFew { kind: Kind::Plane, points: kept.len(), need: 3 });
    }
    let mean = kept.iter().sum::<DVec3>() / kept.len() as f64;
    let size = kept.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    let triangles = triangles.iter().map(|t| t.map(|i| slot[i as usize])).collect();
    kept.iter_mut().for_each(|p| *p = (*p - mean) / size);
    Ok((Face::new(kept, triangles), Scale { mean, size }))
}
