//! Recovers the exact surface of a CAD face from the points of its mesh: plane, sphere, cylinder, conic of revolution or
//! torus, by orthogonal least squares in f64. Positions are good to f32; the file's normals are not used.

mod conic;
mod fault;
mod linalg;
mod plane;
mod pole;
mod refine;
mod round; // cylinders and tori
mod start;

#[cfg(test)]
pub(crate) mod cad;
#[cfg(test)]
mod cad_tests;
#[cfg(test)]
mod round_tests;
#[cfg(test)]
mod tests;

pub use fault::FitError;

use super::weld::{rounding, weld};
use conic::{CURVE, Conic};
use glam::DVec3;
use plane::plane;
use pole::Face;
use refine::{CONIC, Minimum, Model, SPHERE, STILL, refine};
use start::{Monomials, Norm};

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
    let task = Task { face, scale, noise: noise / scale.size, allowed: allowed / scale.size };
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

/// Points are worked on as (p − mean) / size.
#[derive(Clone, Copy)]
struct Scale {
    mean: DVec3,
    size: f64,
}

struct Task {
    face: Face,
    scale: Scale,
    noise: f64,
    allowed: f64,
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
    let first = weld(points, rounding(points));
    let mut slot = vec![usize::MAX; points.len()];
    let mut kept: Vec<DVec3> = Vec::new();
    for (vertex, point) in points.iter().enumerate().filter(|(vertex, _)| used[*vertex]) {
        // An unused vertex can be the first of several coincident ones: its slot serves them all.
        if slot[first[vertex]] == usize::MAX {
            slot[first[vertex]] = kept.len();
            kept.push(DVec3::from_array(point.map(f64::from)));
        }
        slot[vertex] = slot[first[vertex]];
    }
    if kept.len() < 3 {
        return Err(FitError::TooFew { kind: Kind::Plane, points: kept.len(), need: 3 });
    }
    let mean = kept.iter().sum::<DVec3>() / kept.len() as f64;
    let size = kept.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    let triangles = triangles.iter().map(|t| t.map(|i| slot[i as usize])).collect();
    kept.iter_mut().for_each(|p| *p = (*p - mean) / size);
    Ok((Face { points: kept, triangles }, Scale { mean, size }))
}

impl Task {
    fn need(&self, kind: Kind, need: usize) -> Result<(), FitError> {
        let points = self.face.points.len();
        if points < need { Err(FitError::TooFew { kind, points, need }) } else { Ok(()) }
    }

    fn plane(&self) -> Result<Fit, FitError> {
        let flat = plane(&self.face.points);
        if flat.spread[1] <= 2.0 * self.noise {
            return Err(FitError::Undetermined { kind: Kind::Plane, why: "the points lie on a line" });
        }
        let down = self.face.normal().is_some_and(|n| n.dot(flat.axis) < 0.0);
        let axis = if down { -flat.axis } else { flat.axis };
        let surface = Fitted::Plane { vertex: self.scale.mean + self.scale.size * flat.vertex, axis };
        Ok(self.measured(surface, |p| (p - flat.vertex).dot(axis)))
    }

    fn sphere(&self) -> Result<(Conic, Fit), FitError> {
        self.need(Kind::Sphere, 4)?;
        let few = self.few();
        let monomials = Monomials::new(&few);
        let starts = self.norms().map(|norm| monomials.sphere(norm));
        let best = (starts.into_iter().flatten())
            .filter_map(|start| refine(&few, start, &SPHERE, 100))
            .min_by(|x, y| x.cost.total_cmp(&y.cost))
            .and_then(|best| refine(&self.face.points, best.surface, &SPHERE, 100))
            .ok_or(FitError::Undetermined { kind: Kind::Sphere, why: "no sphere passes near the points" })?;
        self.curved(Kind::Sphere, &best)?;
        let seated = self.face.seat(best.surface, self.allowed);
        let (vertex, axis, radius) = self.unscaled(&seated);
        Ok((seated, self.measured(Fitted::Sphere { vertex, axis, radius }, |p| seated.distance(p))))
    }

    /// `sphere`: the sphere fitted before, if there is one.
    fn conic(&self, sphere: Option<Conic>) -> Result<Fit, FitError> {
        self.need(Kind::Conic, 7)?;
        let points = &self.face.points;
        let few = &*self.few();
        let monomials = Monomials::new(few);
        let starts = sphere.into_iter().flat_map(|sphere| [(sphere, &STILL), (sphere, &CONIC)]);
        let algebraic = self.norms().into_iter().flat_map(|norm| monomials.conics(norm)).map(|start| (start, &CONIC));
        let mut best: Option<(Minimum, &[bool; 8])> = None;
        for (start, free) in starts.chain(algebraic) {
            let Some(found) = refine(few, start, free, 100) else { continue };
            // The first starts keep the axis amid the face; a later one must be better by more than what
            // fitting noise with another axis wins (a χ² of 2 directions, generously 20).
            let margin = 1.0 - 20.0 / (few.len() as f64 + 20.0);
            if best.as_ref().is_none_or(|(best, _)| found.cost < best.cost * margin) {
                let rounded = few.iter().all(|&p| found.surface.distance(p).abs() <= self.noise);
                best = Some((found, free));
                if rounded {
                    break; // nothing but rounding is left to explain
                }
            }
        }
        let best = best
            .and_then(|(best, free)| refine(points, best.surface, free, 100))
            .ok_or(FitError::Undetermined { kind: Kind::Conic, why: "no conic passes near the points" })?;
        self.curved(Kind::Conic, &best)?;
        let mut conic = best.surface.towards_centre();
        if let Some(other) = conic.other_pole() {
            let middle = self.face.middle();
            if other.vertex.distance(middle) < conic.vertex.distance(middle) {
                conic = other;
            }
        }
        let (vertex, axis, radius) = self.unscaled(&conic);
        let surface = Fitted::Conic { vertex, axis, radius, conic: conic.k };
        Ok(self.measured(surface, |p| conic.distance(p)))
    }

    /// A cylinder or a torus: the best of all starts.
    fn round(&self, kind: Kind) -> Result<Fit, FitError> {
        let toroid = kind == Kind::Toroid;
        self.need(kind, if toroid { 7 } else { 5 })?;
        let few = &*self.few();
        let free = if toroid { &round::TOROID } else { &round::CYLINDER };
        let found = round::starts(&self.face, few, toroid)
            .into_iter()
            .filter_map(|start| refine(few, start, free, 100))
            .min_by(|x, y| x.cost.total_cmp(&y.cost))
            .and_then(|best| refine(&self.face.points, best.surface, free, 100))
            .ok_or(FitError::Undetermined { kind, why: "none passes near the points" })?;
        // As for conics: see `curved`. The other freedoms may follow.
        let count = self.face.points.len() as f64;
        let noise = (found.cost / count).sqrt().max(0.3 * self.noise);
        let said = |freedom: usize, curvature: f64| {
            let held = std::array::from_fn(|j| free[j] && (j == freedom || j < round::CURVE));
            noise * found.triangle.errors(&held)[freedom] <= 0.1 * curvature.abs()
        };
        if !said(round::CURVE, found.surface.c) {
            return Err(FitError::Undetermined { kind, why: "the points do not say how strongly it is curved" });
        }
        if toroid && !said(round::TUBE, found.surface.tube) {
            let why = "the points do not say how strongly its tube is curved; try a cylinder";
            return Err(FitError::Undetermined { kind, why });
        }
        let seated = found.surface.seated(self.face.middle(), &self.face.points);
        let Scale { mean, size } = self.scale;
        let (vertex, axis, x) = (mean + size * seated.vertex, seated.axis, seated.x);
        let radius = size / seated.c;
        let surface = match toroid {
            true => Fitted::Toroid { vertex, axis, x, radius, tube_radius: size / seated.tube },
            false => Fitted::Cylinder { vertex, axis, x, radius },
        };
        Ok(self.measured(surface, |p| seated.distance(p)))
    }

    /// The simplest surface that meets the tolerance, else the error of the best one. A curved surface is not offered
    /// where so few points, or only points of the face's edge, lie on it that it says nothing about what is between: a
    /// sphere passes exactly through the two rings of a cylinder.
    fn simplest(&self, judged: impl Fn(Fit) -> Result<Fit, FitError>) -> Result<Fit, FitError> {
        let flat = self.plane()?;
        let mut best = match judged(flat) {
            Ok(fit) => return Ok(fit),
            Err(error) => (flat.rms, error),
        };
        let count = self.face.points.len();
        let edge = if self.face.triangles.is_empty() { 0 } else { self.face.edge().len() };
        if edge == count {
            return Err(best.1);
        }
        let sphere = if count >= 8 { self.sphere().ok() } else { None };
        let start = sphere.map(|(start, _)| start);
        let later: [&dyn Fn() -> Option<Fit>; 3] = [
            &|| if count >= 10 { self.round(Kind::Cylinder).ok() } else { None },
            &|| if count >= 14 { self.conic(start).ok() } else { None },
            &|| if count >= 14 { self.round(Kind::Toroid).ok() } else { None },
        ];
        let later = later.into_iter().filter_map(|fit| fit());
        for fit in sphere.map(|(_, fit)| fit).into_iter().chain(later) {
            match judged(fit) {
                Ok(fit) => return Ok(fit),
                Err(error) if fit.rms < best.0 => best = (fit.rms, error),
                Err(_) => {}
            }
        }
        Err(best.1)
    }

    /// Starts are tried on a part of a large face and only the best is finished on all of it. One point of each run of
    /// `stride`, at a golden-ratio place in it, so that the rows of a grid are not met in step.
    fn few(&self) -> Vec<DVec3> {
        let stride = self.face.points.len().div_ceil(4000).max(1);
        let place = |run: usize| (run as f64 * 0.618_033_988_749_895).fract() * stride as f64;
        let runs = self.face.points.chunks(stride).enumerate();
        runs.filter_map(|(run, points)| points.get(place(run) as usize).or(points.first()).copied()).collect()
    }

    fn norms(&self) -> [Norm; 2] {
        let normal = self.face.normal().unwrap_or_else(|| plane(&self.face.points).axis);
        [Norm::Slope(normal), Norm::Squares]
    }

    /// A curved surface is undetermined where noise alone (the residual, or rounding) could change its curvature by a
    /// tenth, its other shape held: a small patch says how strongly it is curved long before it says how the curvature
    /// changes.
    fn curved(&self, kind: Kind, found: &Minimum) -> Result<(), FitError> {
        let count = self.face.points.len() as f64;
        let noise = (found.cost / count).sqrt().max(0.3 * self.noise);
        let error = noise * found.triangle.errors(&SPHERE)[CURVE];
        if error <= 0.1 * found.surface.c.abs() {
            Ok(())
        } else {
            Err(FitError::Undetermined { kind, why: "the points do not say how strongly it is curved; try a plane" })
        }
    }

    /// Vertex, axis and radius in mesh units of a conic with c > 0.
    fn unscaled(&self, conic: &Conic) -> (DVec3, DVec3, f64) {
        let Scale { mean, size } = self.scale;
        (mean + size * conic.vertex, conic.axis, size / conic.c)
    }

    fn measured(&self, surface: Fitted, distance: impl Fn(DVec3) -> f64) -> Fit {
        let (mut sum, mut max) = (0.0, 0.0f64);
        for &p in &self.face.points {
            let d = distance(p).abs();
            sum += d * d;
            max = max.max(d);
        }
        let points = self.face.points.len();
        let size = self.scale.size;
        Fit { surface, rms: size * (sum / points as f64).sqrt(), max_residual: size * max, points }
    }
}
