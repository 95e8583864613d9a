//! Recovers the exact surface of a CAD face from the points of its mesh: plane, sphere, cylinder, conic of revolution or
//! torus, by orthogonal least squares in f64. Positions are good to f32; the file's normals are not used.

mod conic;
mod conics;
mod fault;
mod freeform;
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
pub use freeform::Open;

use super::weld::{rounding, weld};
use eyebox_scene::Shape;
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
    Asphere,
    XyPoly,
    Zernike,
    Bspline,
}

impl Kind {
    /// From the simplest on.
    pub const ALL: [Kind; 9] = [
        Kind::Plane,
        Kind::Sphere,
        Kind::Cylinder,
        Kind::Conic,
        Kind::Toroid,
        Kind::Asphere,
        Kind::XyPoly,
        Kind::Zernike,
        Kind::Bspline,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Plane => "plane",
            Kind::Sphere => "sphere",
            Kind::Cylinder => "cylinder",
            Kind::Conic => "conic",
            Kind::Toroid => "toroid",
            Kind::Asphere => "asphere",
            Kind::XyPoly => "xy_poly",
            Kind::Zernike => "zernike",
            Kind::Bspline => "bspline",
        }
    }

    /// Whether it has as many terms as the points tell.
    pub fn is_freeform(self) -> bool {
        match self {
            Kind::Plane | Kind::Sphere | Kind::Cylinder | Kind::Conic | Kind::Toroid => false,
            Kind::Asphere | Kind::XyPoly | Kind::Zernike | Kind::Bspline => true,
        }
    }

    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// An exact surface in mesh units. `axis` is a unit vector and `radius` > 0: the centre of curvature is vertex +
/// radius·axis.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fitted {
    /// `axis` is the normal, on the side that the triangles face; `vertex` is the mean of the points.
    Plane {
        vertex: DVec3,
        axis: DVec3,
    },
    /// `vertex` is the pole amid the face.
    Sphere {
        vertex: DVec3,
        axis: DVec3,
        radius: f64,
    },
    /// ρ² = 2·radius·z − (1 + conic)·z² about `axis`; a hyperboloid's sheet is the one through `vertex`, an ellipsoid's
    /// vertex is the pole nearer to the face.
    Conic {
        vertex: DVec3,
        axis: DVec3,
        radius: f64,
        conic: f64,
    },
    /// As [`Shape::Cylinder`]: `vertex` is amid the face.
    Cylinder {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
    },
    /// As [`Shape::Toroid`], `tube_radius` of either sign: `vertex` is on the equator amid the face.
    Toroid {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        tube_radius: f64,
    },
    /// As the [`Shape`]s of these names.
    Asphere {
        vertex: DVec3,
        axis: DVec3,
        radius: f64,
        conic: f64,
        even: Vec<f64>,
    },
    XyPoly {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        conic: f64,
        coeffs: Vec<f64>,
    },
    Zernike {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        conic: f64,
        norm_radius: f64,
        coeffs: Vec<f64>,
    },
    Bspline {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        conic: f64,
        half: [f64; 2],
        spans: [u32; 2],
        coeffs: Vec<f64>,
    },
}

impl Fitted {
    pub fn shape(&self) -> Shape {
        match self.clone() {
            Fitted::Plane { vertex, axis } => Shape::Plane { vertex, axis },
            Fitted::Sphere { vertex, axis, radius } => Shape::Sphere { vertex, axis, radius },
            Fitted::Conic { vertex, axis, radius, conic } => Shape::Conic { vertex, axis, radius, conic },
            Fitted::Cylinder { vertex, axis, x, radius } => Shape::Cylinder { vertex, axis, x, radius },
            Fitted::Toroid { vertex, axis, x, radius, tube_radius } => {
                Shape::Toroid { vertex, axis, x, radius, tube_radius }
            }
            Fitted::Asphere { vertex, axis, radius, conic, even } => {
                Shape::Asphere { vertex, axis, radius, conic, even }
            }
            Fitted::XyPoly { vertex, axis, x, radius, conic, coeffs } => {
                Shape::XyPoly { vertex, axis, x, radius, conic, coeffs }
            }
            Fitted::Zernike { vertex, axis, x, radius, conic, norm_radius, coeffs } => {
                Shape::Zernike { vertex, axis, x, radius, conic, norm_radius, coeffs }
            }
            Fitted::Bspline { vertex, axis, x, radius, conic, half, spans, coeffs } => {
                Shape::Bspline { vertex, axis, x, radius, conic, half, spans, coeffs }
            }
        }
    }

    pub fn kind(&self) -> Kind {
        match self {
            Fitted::Plane { .. } => Kind::Plane,
            Fitted::Sphere { .. } => Kind::Sphere,
            Fitted::Conic { .. } => Kind::Conic,
            Fitted::Cylinder { .. } => Kind::Cylinder,
            Fitted::Toroid { .. } => Kind::Toroid,
            Fitted::Asphere { .. } => Kind::Asphere,
            Fitted::XyPoly { .. } => Kind::XyPoly,
            Fitted::Zernike { .. } => Kind::Zernike,
            Fitted::Bspline { .. } => Kind::Bspline,
        }
    }
}

/// A surface and how far the points lie from it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Fit {
    pub surface: Fitted,
    /// Root mean square and largest orthogonal distance of the points, mesh units.
    pub rms: f64,
    pub max_residual: f64,
    /// The point that is farthest from it.
    pub worst: DVec3,
    /// Of a freeform, what the points leave open of it.
    pub open: Option<Open>,
    /// Distinct points that were fitted.
    pub points: usize,
}

/// Fits the points of one CAD face.
///
/// `points`: mesh positions; `triangles`: the face's triangles (counter-clockwise from outside). Only vertices that
/// triangles use count, coincident ones once; with no triangles at all, every vertex counts. `kind`: what to fit, or
/// None for the first of plane, sphere, cylinder, conic, toroid, asphere, xy_poly, bspline that meets `tolerance`.
/// `tolerance`: largest orthogonal distance allowed, mesh units; what rounding to f32 can do to the coordinates is
/// always allowed.
///
/// A conic's axis and vertex are found with it (7 unknowns). What the points do not determine stays at the simplest
/// value: a conic asked for on a sphere has its axis amid the face. A freeform has as many terms as the points tell.
///
/// Errors: coordinates that are not finite, indices out of range, too few or degenerate points, the best surface
/// misses the tolerance, or (freeforms) foretells points that are left out to no better than the tolerance.
pub fn fit(points: &[[f32; 3]], triangles: &[[u32; 3]], kind: Option<Kind>, tolerance: f64) -> Result<Fit, FitError> {
    fit_of(points, triangles, kind, tolerance, true)
}

/// As [`fit`], but plane, sphere, cylinder, conic and toroid only.
pub fn simple(points: &[[f32; 3]], triangles: &[[u32; 3]], tolerance: f64) -> Result<Fit, FitError> {
    fit_of(points, triangles, None, tolerance, false)
}

fn fit_of(
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    kind: Option<Kind>,
    tolerance: f64,
    freeforms: bool,
) -> Result<Fit, FitError> {
    let (face, scale) = prepare(points, triangles)?;
    let noise = rounding(points);
    let allowed = tolerance.max(noise); // also where the tolerance is not a number
    let task = Task::new(face, scale, noise / scale.size, allowed / scale.size);
    let judged = |fit: Fit| {
        let kind_found = fit.surface.kind();
        if fit.max_residual > allowed || fit.max_residual.is_nan() {
            return Err(FitError::Misses {
                kind: kind_found,
                asked: kind.is_some(),
                rms: fit.rms,
                max: fit.max_residual,
                worst: fit.worst,
                tolerance: allowed,
            });
        }
        match fit.open.filter(|open| open.left_out > allowed) {
            None => Ok(fit),
            Some(open) => Err(FitError::Open {
                kind: kind_found,
                points: fit.points,
                left_out: open.left_out,
                tolerance: allowed,
            }),
        }
    };
    match kind {
        Some(Kind::Plane) => judged(task.plane()?),
        Some(Kind::Sphere) => judged(task.sphere()?.1),
        Some(kind @ (Kind::Cylinder | Kind::Toroid)) => judged(task.round(kind)?),
        Some(Kind::Conic) => judged(task.conic(task.sphere().ok().map(|(start, _)| start))?),
        Some(kind @ (Kind::Asphere | Kind::XyPoly | Kind::Zernike | Kind::Bspline)) => judged(task.freeform(kind)?),
        None => task.simplest(judged, freeforms),
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
