//! Freeforms from the points of a face: a base sphere (of aspheres, conic) and an even power series, a polynomial in x
//! and y, Zernike polynomials, or B-splines. Distances count in units of what rounding to f32 does to each point, the
//! order is the simplest that foretells points that are left out as well as the best does, and points of the rim or
//! strays that miss by far more than the rest are trusted less.

mod basis;
mod model;
mod open;
mod orders;
mod place;
mod spline;
mod surface;
mod triangle;
mod trust;
mod walk;

#[cfg(test)]
mod tests;

pub use open::Open;

use super::task::Task;
use super::{Fit, FitError, Kind};
use basis::Basis;
use glam::DVec3;
use model::{FREEDOMS, Frame, Free, Model, Sample};
use orders::{Score, best, highest, residuals, scores, slack};
use place::Place;
use walk::walk;

/// Highest degree of a polynomial, and number of even powers from r⁴ on.
const DEGREE: usize = 14;
const POWERS: usize = 10;
/// As many points are walked over on the way to a frame, or as many to each term.
const SKETCH: usize = 400;
const TO_EACH: usize = 6;
/// How often the trust in points is weighed anew.
const ROUNDS: usize = 4;

/// More points than this say nothing more: what they leave open goes with the root of their number.
const MOST: usize = 20_000;

const STILL: Free = [false; FREEDOMS];
const TILTED: Free = [true, true, false, false, true];
const REVOLVED: Free = [true; FREEDOMS];

/// One of each run of so many, at a golden-ratio place in it, so that the rows of a grid are not met in step.
fn part<T>(all: &[T], stride: usize) -> impl Iterator<Item = &T> {
    let place = move |run: usize| (run as f64 * 0.618_033_988_749_895).fract() * stride as f64;
    all.chunks(stride.max(1)).enumerate().filter_map(move |(run, some)| some.get(place(run) as usize).or(some.first()))
}

/// A model, what of it was free to move, and how well it foretells points that are left out.
struct Found {
    model: Model,
    free: Free,
    left_out: f64,
    /// Of a spline, with what holds its coefficients.
    held: Option<triangle::Triangle>,
}

impl Task {
    /// The best freeform of a kind, however far the points lie from it.
    pub fn freeform(&self, kind: Kind) -> Result<Fit, FitError> {
        let place =
            Place::of(&self.face).ok_or(FitError::Undetermined { kind, why: "the face is no height over a plane" })?;
        let (mut samples, on_edge) = self.samples();
        let need = 12;
        if samples.len() < need {
            return Err(FitError::TooFew { kind, points: samples.len(), need });
        }
        let none = FitError::Undetermined { kind, why: "none passes near the points" };
        let mut found = self.found(kind, &place, &samples).ok_or(none)?;
        for _ in 0..ROUNDS {
            let Some(residuals) = residuals(&found.model, &samples, &found.free) else { break };
            if !trust::weigh(&residuals.each, &on_edge, found.model.terms(), &mut samples) {
                break;
            }
            let Some(again) = self.found(kind, &place, &samples) else { break };
            found = again;
        }
        let open = open::open(&found, &samples, self.scale.size);
        let surface = surface::fitted(kind, &found.model, self.scale);
        let model = &found.model;
        let fit = self.measured(surface, |p| model.distance(p).unwrap_or(f64::INFINITY));
        Ok(Fit { open, ..fit })
    }

    /// [`MOST`] of the points at most, and which of them are on the rim.
    fn samples(&self) -> (Vec<Sample>, Vec<bool>) {
        // Half a unit in the last place at most, evenly: its standard deviation is the unit over √12.
        let unit = |x: f64| {
            let x = (x as f32).abs();
            f64::from(f32::from_bits(x.to_bits() + 1) - x) / 12f64.sqrt()
        };
        let sample = |p: &DVec3| {
            let at = self.scale.mean + self.scale.size * *p;
            Sample { p: *p, rounding: DVec3::from_array(at.to_array().map(unit)) / self.scale.size, trust: 1.0 }
        };
        let mut on_edge = vec![false; self.face.points.len()];
        self.face.edge().iter().for_each(|i| on_edge[*i] = true);
        let stride = self.face.points.len().div_ceil(MOST).max(1);
        let all: Vec<(&DVec3, bool)> = self.face.points.iter().zip(on_edge).collect();
        part(&all, stride).map(|(p, on_edge)| (sample(p), *on_edge)).unzip()
    }

    fn found(&self, kind: Kind, place: &Place, samples: &[Sample]) -> Option<Found> {
        match kind {
            Kind::Asphere => self.asphere(samples),
            Kind::XyPoly | Kind::Zernike => self.polynomial(place, samples),
            Kind::Bspline => self.splined(place, samples),
            Kind::Plane | Kind::Sphere | Kind::Cylinder | Kind::Conic | Kind::Toroid => None,
        }
    }

    fn floor(&self) -> f64 {
        0.05 * self.noise
    }

    /// A polynomial on a sphere. The order is found in the frame of the face; a lower one does as well where tilt and
    /// base are those of the design.
    fn polynomial(&self, place: &Place, samples: &[Sample]) -> Option<Found> {
        let c = self.curvature(place.frame.axis);
        let basis = Basis::Poly { half: place.half };
        let mut start =
            Model { frame: place.frame, c, k: 0.0, basis, order: 2, heights: Vec::new(), floor: self.floor() };
        start.order = highest(&start, samples, DEGREE);
        let all = scores(&start, samples)?;
        let slack = slack(samples);
        let plain = best(&all, slack)?;
        for order in 2..plain.order {
            let start = Model { order, ..start.clone() };
            let Some(walked) = self.walked(samples, &start, &TILTED) else { continue };
            if walked.left_out <= plain.left_out * slack {
                return Some(walked);
            }
        }
        let start = Model { order: plain.order, ..start };
        let walked = self.walked(samples, &start, &TILTED).filter(|walked| walked.left_out * slack < plain.left_out);
        let still = |model| Found { model, free: STILL, left_out: plain.left_out, held: None };
        walked.or_else(|| start.solved(samples).map(still))
    }

    fn asphere(&self, samples: &[Sample]) -> Option<Found> {
        let sphere = self.sphere().ok().map(|(start, _)| start);
        let mut conic = self.conics(sphere)?.0.surface.towards_centre();
        let middle = self.face.middle();
        if let Some(other) = conic.other_pole().filter(|o| o.vertex.distance(middle) < conic.vertex.distance(middle)) {
            conic = other;
        }
        let (x, y) = conic.axis.any_orthonormal_pair();
        let frame = Frame { vertex: conic.vertex, x, y, axis: conic.axis };
        let reach = self.face.points.iter().map(|p| frame.local(*p).truncate().length()).fold(0.0, f64::max);
        let slack = slack(samples);
        let mut all: Vec<Found> = Vec::new();
        for k in [0.0, conic.k] {
            let basis = Basis::Even { reach };
            let mut last = Model { frame, c: conic.c, k, basis, order: 1, heights: Vec::new(), floor: self.floor() };
            for order in 1..=highest(&last, samples, POWERS) {
                let start = Model { order, heights: Vec::new(), ..last.clone() };
                let Some(walked) = self.walked(samples, &start, &REVOLVED) else { break };
                last = walked.model.clone();
                all.push(walked);
            }
        }
        all.sort_by_key(|found| found.model.order);
        let scores: Vec<Score> =
            all.iter().map(|found| Score { order: found.model.order, left_out: found.left_out }).collect();
        let best = best(&scores, slack)?;
        all.into_iter().find(|found| found.left_out == best.left_out)
    }

    /// On the face's sphere, which smooth surfaces are near to, and on a plane, as CAD's own splines are.
    fn splined(&self, place: &Place, samples: &[Sample]) -> Option<Found> {
        let slack = slack(samples);
        let on = |c: f64| {
            let basis = Basis::Poly { half: place.half };
            let floor = self.floor();
            let start = Model { frame: place.frame, c, k: 0.0, basis, order: 2, heights: Vec::new(), floor };
            // Slopes for the weights.
            let start = start.solved(samples)?;
            spline::best(&start, place.half, samples, slack)
        };
        let all = [on(self.curvature(place.frame.axis)), on(surface::FLATTEST)];
        let least = all.iter().flatten().map(|one| one.left_out).fold(f64::INFINITY, f64::min);
        let well = all.into_iter().flatten().filter(|one| one.left_out <= least * slack);
        let best = well.min_by_key(|one| one.model.terms())?;
        Some(Found { model: best.model, free: best.free, left_out: best.left_out, held: best.held })
    }

    /// The model at the frame and base that suit the samples best.
    fn walked(&self, samples: &[Sample], start: &Model, free: &Free) -> Option<Found> {
        let few = SKETCH.max(TO_EACH * start.terms());
        let mut model = start.clone();
        if samples.len() > 2 * few {
            let stride = samples.len().div_ceil(few);
            let part: Vec<Sample> = part(samples, stride).copied().collect();
            model = walk(&part, &model, free)?;
        }
        let model = walk(samples, &model, free)?;
        let left_out = residuals(&model, samples, free)?.left_out;
        Some(Found { model, free: *free, left_out, held: None })
    }

    /// Curvature of the nearest sphere, positive where its centre lies along `axis`.
    fn curvature(&self, axis: DVec3) -> f64 {
        let flattest = 1e-6;
        self.sphere().map_or(flattest, |(sphere, _)| {
            let c = sphere.c * sphere.axis.dot(axis).signum();
            // A face as deep as its sphere is a height over it no more at the edge.
            if c.abs() < 0.7 { c } else { 0.7 * c.signum() }
        })
    }
}
