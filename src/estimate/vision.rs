//! What the eye sees of lamps through specular faces alone (`E S* L`), apart from the paths that scatter: such paths
//! cost little and know their way, so they get points of their own in every pixel and follow both ways on at an
//! interface. A mirrored lamp smaller than a pixel would otherwise be the noise of the whole picture.

use super::ledger::Ledger;
use super::route::Route;
use super::walk::{Meeting, Met, Travel, Walker};
use crate::base::path::{Event, Trail};
use crate::base::rng::{Rng, Stream};
use crate::film::accumulate::Light;
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{Mode, plane_of};
use crate::world::optics::Optics;

/// Paths per pixel and pass.
const PATHS: u64 = 4;
/// A path is split where both ways on carry at least this share of what it started with; else chance decides.
const SPLIT_FROM: f64 = 1.0 / 256.0;

/// Where in a pixel path number `index` starts: a lattice of full period, moved by a shift of the pixel's own, so that
/// each point alone is uniform and all points so far are spread evenly. The area of a small image then converges
/// faster than with independent points, and passes differ by less than their variance says.
///
/// Steps 1/g and 1/g² with g³ = g + 1 (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018),
/// as fractions of 2⁶⁴.
fn point_in_pixel(shift: [u64; 2], index: u64) -> [f64; 2] {
    const STEPS: [u64; 2] = [0xc13f_a9a9_02a6_328f, 0x91e1_0da5_c79e_7b1c];
    let at = |axis: usize| {
        let fraction = shift[axis].wrapping_add(index.wrapping_mul(STEPS[axis]));
        (fraction >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    };
    [at(0), at(1)]
}

/// Follows paths from the eye to lamps, over specular events only.
pub struct Vision<'w> {
    world: &'w World,
    seed: u64,
}

impl<'w> Vision<'w> {
    /// None if the route leaves direct vision of all lamps to others.
    pub fn new(world: &'w World, route: &Route, seed: u64) -> Option<Self> {
        let owned = |trail: Trail| world.lamps.all().iter().any(|lamp| route.from_eye(lamp.group, trail).is_some());
        (owned(Trail::START) || owned(Trail::START.then(Event::Specular))).then_some(Vision { world, seed })
    }

    /// Adds what one pass sees in pixel (`x`, `y`) to `out`, by plane. `width`: of the picture, pixels.
    #[allow(clippy::too_many_arguments)]
    pub fn look<M: Mode>(
        &self,
        route: &Route,
        (pass, optics): (u64, &Optics<M>),
        x: usize,
        y: usize,
        width: usize,
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        let pixel = (y * width + x) as u64;
        let mut fixed = Rng::new(self.seed, Stream::VisionShift, 0, pixel);
        let shift = [fixed.next_u64(), fixed.next_u64()];
        let mut rng = Rng::new(self.seed, Stream::Vision, pass, pixel);
        for path in 0..PATHS {
            let jitter = point_in_pixel(shift, pass.wrapping_mul(PATHS).wrapping_add(path));
            let (origin, dir) = self.world.eye.ray(x, y, jitter, rng.pair());
            let ray = Ray { origin, dir, from: None };
            let weight = 1.0 / PATHS as f64;
            let mut walker =
                Walker::new((self.world, optics), Travel::FromEye, ray, weight, Interior::default(), rng.fork());
            let balance = ledger.imbalance();
            ledger.paths += 1;
            ledger.emitted += weight;
            self.follow(route, &mut walker, weight * SPLIT_FROM, out, ledger);
            ledger.close_path(balance);
        }
    }

    fn follow<M: Mode>(
        &self,
        route: &Route,
        walker: &mut Walker<'_, M>,
        least: f64,
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => {
                    walker.escape(ledger);
                    return;
                }
                Met::Pupil(_) | Met::Ended => return,
                Met::Face(vertex) => vertex,
            };
            if let Some(seen) = walker.lamp_at(&vertex)
                && let Some(plane) = route.from_eye(seen.lamp.group, walker.trail)
            {
                walker.see(plane_of::<M>(out, plane), &seen, 1.0);
            }
            // Without the slides' factors, so that pictures at two contrasts share every path.
            let share = walker.beam.weight();
            if share > least
                && let Some(mut reflected) = walker.split(&vertex, least / share, u8::MAX, ledger)
            {
                self.follow(route, &mut reflected, least, out, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(..) => {
                    ledger.not_owned += walker.beam.carried();
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::point_in_pixel;

    /// Over 64 shifts the area of a small disc has no bias and less than a third of the error of independent points.
    #[test]
    fn a_small_image_is_found_evenly() {
        const POINTS: u64 = 4096;
        let area = std::f64::consts::PI * 0.01;
        let errors: Vec<f64> = (0..64u64)
            .map(|k| {
                let shift = [k.wrapping_mul(0x9e37_79b9_7f4a_7c15), k.wrapping_mul(0xbf58_476d_1ce4_e5b9)];
                let inside = (0..POINTS).filter(|&index| {
                    let [x, y] = point_in_pixel(shift, index);
                    (x - 0.4).powi(2) + (y - 0.6).powi(2) < 0.01
                });
                inside.count() as f64 / POINTS as f64 - area
            })
            .collect();
        let independent = (area * (1.0 - area) / POINTS as f64).sqrt();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 64.0).sqrt();
        let mean = errors.iter().sum::<f64>() / 64.0;
        assert!(rms < independent / 3.0, "rms {rms}, independent points {independent}");
        assert!(mean.abs() < 4.0 * rms / 8.0, "mean {mean}, rms {rms}");
    }
}
