//! The surfaces of one face: the best of each kind, found on a part of the points and finished on all of them, and the
//! simplest of the kinds that meets a tolerance.

use super::conic::{CURVE, Conic};
use super::plane::plane;
use super::pole::Face;
use super::refine::{Minimum, Model, SPHERE, Walk, refine};
use super::start::{Monomials, Norm};
use super::torus::{self, Torus};
use super::{Fit, FitError, Fitted, Kind};
use glam::DVec3;

/// Points are worked on as (p − mean) / size.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    pub mean: DVec3,
    pub size: f64,
}

pub(super) struct Task {
    pub face: Face,
    pub scale: Scale,
    /// What rounding can move a point, and how far one may lie from the surface.
    pub noise: f64,
    pub allowed: f64,
    /// [`SKETCH`] of the points at most, on which walks from starts are tried: only what they find is finished on all.
    pub sketch: Vec<DVec3>,
}

/// Twenty to each unknown of the freest surface.
const SKETCH: usize = 160;

/// One point of each of `most` runs at most, at a golden-ratio place in it, so that the rows of a grid are not met in
/// step.
pub(super) fn part(points: &[DVec3], most: usize) -> Vec<DVec3> {
    let stride = points.len().div_ceil(most).max(1);
    let place = |run: usize| (run as f64 * 0.618_033_988_749_895).fract() * stride as f64;
    let runs = points.chunks(stride).enumerate();
    runs.filter_map(|(run, points)| points.get(place(run) as usize).or(points.first()).copied()).collect()
}

impl Task {
    pub fn new(face: Face, scale: Scale, noise: f64, allowed: f64) -> Task {
        let sketch = part(&face.points, SKETCH);
        Task { face, scale, noise, allowed, sketch }
    }

    fn need(&self, kind: Kind, need: usize) -> Result<(), FitError> {
        let points = self.face.points.len();
        if points < need { Err(FitError::TooFew { kind, points, need }) } else { Ok(()) }
    }

    pub fn plane(&self) -> Result<Fit, FitError> {
        let flat = plane(&self.face.points);
        if flat.spread[1] <= 2.0 * self.noise {
            return Err(FitError::Undetermined { kind: Kind::Plane, why: "the points lie on a line" });
        }
        let down = self.face.normal().is_some_and(|n| n.dot(flat.axis) < 0.0);
        let axis = if down { -flat.axis } else { flat.axis };
        let surface = Fitted::Plane { vertex: self.scale.mean + self.scale.size * flat.vertex, axis };
        Ok(self.measured(surface, |p| (p - flat.vertex).dot(axis)))
    }

    /// The sphere, and how far the points lie from it.
    pub fn sphere(&self) -> Result<(Conic, Fit), FitError> {
        self.need(Kind::Sphere, 4)?;
        let monomials = Monomials::new(&self.sketch);
        let starts = self.norms().map(|norm| monomials.sphere(norm));
        let best = (starts.into_iter().flatten())
            .filter_map(|start| refine(&self.sketch, start, &SPHERE, Walk::FAR))
            .min_by(|x, y| x.cost.total_cmp(&y.cost))
            .and_then(|best| refine(&self.face.points, best.surface, &SPHERE, Walk::NEAR))
            .ok_or(FitError::Undetermined { kind: Kind::Sphere, why: "no sphere passes near the points" })?;
        self.curved(Kind::Sphere, &best)?;
        let seated = self.face.seat(best.surface, self.allowed);
        let (vertex, axis, radius) = self.unscaled(&seated);
        Ok((seated, self.measured(Fitted::Sphere { vertex, axis, radius }, |p| seated.distance(p))))
    }

    /// `sphere`: the sphere fitted before, if there is one.
    pub fn conic(&self, sphere: Option<Conic>) -> Result<Fit, FitError> {
        self.need(Kind::Conic, 7)?;
        let best = (self.conics(sphere))
            .and_then(|(best, free)| refine(&self.face.points, best.surface, free, Walk::NEAR))
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
    pub fn round(&self, kind: Kind) -> Result<Fit, FitError> {
        self.finished(kind, self.rounds(kind, f64::INFINITY)?.map(|found| found.surface))
    }

    /// The best start of a cylinder or a torus, refined on the sketch. Walks that cannot come to the root mean square
    /// `goal` are given up.
    fn rounds(&self, kind: Kind, goal: f64) -> Result<Option<Minimum<Torus>>, FitError> {
        let toroid = kind == Kind::Toroid;
        self.need(kind, if toroid { 7 } else { 5 })?;
        Ok(torus::starts(&self.face, &self.sketch, toroid)
            .into_iter()
            .filter_map(|start| refine(&self.sketch, start, torus::free(toroid), Walk::towards(goal)))
            .min_by(|x, y| x.cost.total_cmp(&y.cost)))
    }

    /// A cylinder or a torus on all points, from the best on the sketch.
    fn finished(&self, kind: Kind, best: Option<Torus>) -> Result<Fit, FitError> {
        let toroid = kind == Kind::Toroid;
        let free = torus::free(toroid);
        let found = best
            .and_then(|best| refine(&self.face.points, best, free, Walk::NEAR))
            .ok_or(FitError::Undetermined { kind, why: "none passes near the points" })?;
        // As for conics: see `curved`. The other freedoms may follow.
        let count = self.face.points.len() as f64;
        let noise = (found.cost / count).sqrt().max(0.3 * self.noise);
        let said = |freedom: usize, curvature: f64| {
            let held = std::array::from_fn(|j| free[j] && (j == freedom || j < torus::CURVE));
            noise * found.triangle.errors(&held)[freedom] <= 0.1 * curvature.abs()
        };
        if !said(torus::CURVE, found.surface.c) {
            return Err(FitError::Undetermined { kind, why: "the points do not say how strongly it is curved" });
        }
        if toroid && !said(torus::TUBE, found.surface.tube) {
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
    pub fn simplest(&self, judged: impl Fn(Fit) -> Result<Fit, FitError>, freeforms: bool) -> Result<Fit, FitError> {
        let flat = self.plane()?;
        let mut best = match judged(flat.clone()) {
            Ok(fit) => return Ok(fit),
            Err(error) => (flat.rms, error),
        };
        let count = self.face.points.len();
        let edge = if self.face.triangles.is_empty() { 0 } else { self.face.edge().len() };
        if edge == count {
            return Err(best.1);
        }
        let sphere = if count >= 8 { self.sphere().ok() } else { None };
        let start = sphere.as_ref().map(|(start, _)| *start);
        let cylinder = if count >= 10 { self.rounds(Kind::Cylinder, self.allowed).ok().flatten() } else { None };
        // Where the nearest to a part of the points misses by more in the root mean square, the nearest to all misses by
        // more in one of them. Should another start or walk have been better, the last word is on all points.
        let misses = |found: &Minimum<Torus>| found.cost > self.allowed.powi(2) * self.sketch.len() as f64;
        let (late, early) = match cylinder {
            Some(found) if misses(&found) => (true, None),
            found => (false, found.map(|found| found.surface)),
        };
        let free = |kind: Kind| if freeforms { self.freeform(kind).ok() } else { None };
        let later: [&dyn Fn() -> Option<Fit>; 7] = [
            &|| early.and_then(|found| self.finished(Kind::Cylinder, Some(found)).ok()),
            &|| if count >= 14 { self.conic(start).ok() } else { None },
            &|| if count >= 14 { self.round(Kind::Toroid).ok() } else { None },
            &|| if late { self.round(Kind::Cylinder).ok() } else { None },
            &|| free(Kind::Asphere),
            &|| free(Kind::XyPoly),
            &|| free(Kind::Bspline),
        ];
        let later = later.into_iter().filter_map(|fit| fit());
        for fit in sphere.map(|(_, fit)| fit).into_iter().chain(later) {
            let rms = fit.rms;
            match judged(fit) {
                Ok(fit) => return Ok(fit),
                Err(error) if rms < best.0 => best = (rms, error),
                Err(_) => {}
            }
        }
        Err(best.1)
    }

    pub fn norms(&self) -> [Norm; 2] {
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

    pub fn measured(&self, surface: Fitted, distance: impl Fn(DVec3) -> f64) -> Fit {
        let (mut sum, mut max, mut worst) = (0.0, 0.0f64, DVec3::ZERO);
        for &p in &self.face.points {
            let d = distance(p).abs();
            sum += d * d;
            if d > max {
                (max, worst) = (d, p);
            }
        }
        let points = self.face.points.len();
        let Scale { mean, size } = self.scale;
        let (rms, worst) = (size * (sum / points as f64).sqrt(), mean + size * worst);
        Fit { surface, rms, max_residual: size * max, worst, open: None, points }
    }
}
