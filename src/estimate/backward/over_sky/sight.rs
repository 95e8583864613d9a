//! The paths by which it is known what a block of pixels sees of the sky.

use super::{Linear, Shown};
use crate::backward::tuning::over_sky::{LEAST, MOST_STEPS, REACH, STEADY, TOLERANCE, TRIALS, UP_AND_DOWN};
use crate::ledger::{Ledger, cost};
use crate::ownership::Ownership;
use crate::walk::{Meeting, Met, Travel, Walker};
use eyebox_base::chain::Chain;
use eyebox_base::lpe::Source;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{LaneArray, Mode, lanes, wavelengths_change};
use eyebox_world::optics::Optics;
use eyebox_world::sky::SkyLight;
use eyebox_world::surface::Surface;
use glam::{DMat2, DVec2};
use std::collections::VecDeque;

/// The sky seen along one path.
pub(super) struct Sight<M: Mode> {
    chain: Chain,
    plane: usize,
    alone: bool,
    /// What of its light arrives, per lane.
    share: M::Lanes<f64>,
    /// Columns and rows of its picture.
    pub(super) place: DVec2,
}

impl<M: Mode> Sight<M> {
    pub(super) fn is_like(&self, other: &Sight<M>) -> bool {
        (self.plane, self.alone) == (other.plane, other.alone) && self.chain == other.chain
    }

    /// The largest share.
    pub(super) fn strength(&self) -> f64 {
        self.share.as_slice().iter().fold(0.0, |most: f64, own| most.max(*own))
    }

    /// The mean share of the lanes in use.
    fn mean(&self) -> f64 {
        let used = if self.alone { 1 } else { M::LANES };
        self.share.as_slice()[..used].iter().sum::<f64>() / used as f64
    }
}

/// What paths from a square of the eye's picture see: those from the corners of a simplex over it and the pupil, and those on trial.
pub(super) struct Seen<M: Mode> {
    pub(super) starts: [Vec<Sight<M>>; 5],
    pub(super) trials: [Vec<Sight<M>>; TRIALS.len()],
}

/// A train that all paths follow.
pub(super) struct Known<M: Mode> {
    pub(super) shown: Shown<M>,
    /// Largest distance of a path on trial from where the map says, pixels of the eye.
    pub(super) off: f64,
}

/// Follows such paths.
pub(super) struct Scout<'f, M: Mode> {
    pub(super) world: &'f World,
    pub(super) route: &'f Ownership,
    pub(super) sky: &'f SkyLight,
    /// Of the passes whose wavelengths are looked at.
    pub(super) optics: &'f [Optics<M>],
    pub(super) seed: u64,
}

/// What a path sees in the way of another.
fn like<'s, M: Mode>(sight: &Sight<M>, all: &'s [Sight<M>]) -> Option<&'s Sight<M>> {
    all.iter().find(|other| other.is_like(sight))
}

impl<M: Mode> Scout<'_, M> {
    /// `middle`: of a square in the picture, pixels.
    pub(super) fn look(&self, middle: DVec2, side: f64) -> Seen<M> {
        let [right, left, down, up] = UP_AND_DOWN;
        let places =
            [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0], [0.0; 2]].map(|at| DVec2::from_array(at) * REACH);
        let pupils = [[right, down], [left, down], [left, down], [right, down], [0.0, up]];
        let from = |k: usize, place: DVec2, pupil: [f64; 2]| {
            self.sights(&self.optics[k % self.optics.len()], middle + place * side, DVec2::from_array(pupil))
        };
        Seen {
            starts: std::array::from_fn(|k| from(0, places[k], pupils[k])),
            trials: std::array::from_fn(|k| {
                let [x, y, u, v] = TRIALS[k];
                from(k + 1, DVec2::new(x, y), [u, v])
            }),
        }
    }

    /// What a path from a place of the picture and the pupil sees of the sky.
    fn sights(&self, optics: &Optics<M>, at: DVec2, pupil: DVec2) -> Vec<Sight<M>> {
        let eye = &self.world.eye;
        let film = eye.film_of(0, 0, at.to_array());
        let (origin, (_, dir), ..) = eye.ray_of(film, eye.pupil_radius_m() * pupil);
        let ray = Ray { origin, dir, from: None };
        let rng = Rng::new(self.seed, Stream::SkyPixels, 0, 0);
        let walker = Walker::new((self.world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
        let mut sights = Vec::new();
        self.follow(walker.recording(), &mut Ledger::new(self.world.solids.len()), &mut sights);
        sights
    }

    /// Nothing is left to chance: where light parts both ways are followed while they have enough of it.
    fn follow(&self, walker: Walker<'_, M>, ledger: &mut Ledger, sights: &mut Vec<Sight<M>>) {
        let mut waiting = VecDeque::from([walker]);
        while let Some(mut walker) = waiting.pop_front() {
            while walker.beam.weight() >= LEAST && ledger.work < MOST_STEPS * cost::STEP {
                let vertex = match walker.advance(ledger) {
                    Met::Sky => {
                        sights.extend(self.sight(&walker));
                        break;
                    }
                    Met::Pupil(_) | Met::Ended => break,
                    Met::Face(vertex) => vertex,
                };
                match &walker.face(&vertex).surface {
                    // What is seen through these is not smooth, or not for certain.
                    Surface::Absorber | Surface::Slide(_) | Surface::Grating(_) | Surface::Scatter(_) => break,
                    Surface::Absent
                    | Surface::Sheet(_)
                    | Surface::Mirror(_)
                    | Surface::Splitter(_)
                    | Surface::Interface(_) => {}
                }
                waiting.extend(walker.split(&vertex, 0.0, u8::MAX, ledger));
                match walker.meet(&vertex, ledger) {
                    Meeting::Went => {}
                    Meeting::Ended | Meeting::Scatter(..) => break,
                }
            }
        }
    }

    fn sight(&self, walker: &Walker<'_, M>) -> Option<Sight<M>> {
        let group = self.sky.group;
        let share = self.route.from_eye(group, walker.trail)?;
        let plane = self.route.plane_from_eye(share, walker.told, group, Source::Sky);
        let (index, (light, alone)) = (walker.index_here(), walker.beam.stored());
        let share = lanes::<M, _>(|lane| light[lane].value / (index[lane] * index[lane]));
        let (chain, place) = (walker.chain()?.clone(), self.sky.place(walker.ray.dir));
        let finite = place.is_finite() && share.as_slice().iter().all(|share| share.is_finite());
        finite.then_some(Sight { chain, plane, alone, share, place })
    }

    /// What a square sees in the way of one of its paths; none if some see otherwise.
    pub(super) fn known(&self, sight: &Sight<M>, seen: &Seen<M>, (middle, side): (DVec2, f64)) -> Option<Known<M>> {
        let found: Vec<&Sight<M>> = seen.starts.iter().map(|all| like(sight, all)).collect::<Option<_>>()?;
        let tried: Vec<&Sight<M>> = seen.trials.iter().map(|all| like(sight, all)).collect::<Option<_>>()?;
        let at = |k: usize| self.sky.near(found[k].place, sight.place);
        let slope = |of: [DVec2; 4]| (of[0] + of[1] - of[2] - of[3]) / 4.0;
        let [a, b, c, d] = [0, 1, 2, 3].map(at);
        let (even, centre) = ((a + b + c + d) / 4.0, at(4));
        let by_pixel = [slope([a, b, c, d]), slope([a, c, b, d])].map(|by| by / (REACH * side));
        let [to_right, _, below, above] = UP_AND_DOWN;
        let by_pupil = [slope([a, d, b, c]) / to_right, (centre - even) / (above - below)];
        let to_pixels = DMat2::from_cols(by_pixel[0], by_pixel[1]).inverse();
        if !to_pixels.is_finite() {
            return None;
        }
        // How far from where a map says the paths on trial see the sky.
        let off = |place: &Linear| {
            let of = |(own, [x, y, u, v]): (&&Sight<M>, [f64; 4])| {
                let foretold = place.at(DVec2::new(x, y) * side, DVec2::new(u, v));
                (to_pixels * (self.sky.near(own.place, foretold) - foretold)).abs().max_element()
            };
            tried.iter().zip(TRIALS).map(of).fold(0.0, f64::max)
        };
        let still = Linear { middle: 0.5 * (even + centre), by_pixel, by_pupil: [DVec2::ZERO; 2] };
        let moving = Linear { middle: even - by_pupil[1] * below, by_pixel, by_pupil };
        let (place, off, moves) = match off(&still) {
            own if own <= TOLERANCE || self.world.eye.pupil_radius_m() <= 0.0 => (still, own, 0.0),
            _ => (moving, off(&moving), by_pupil.iter().map(|by| (to_pixels * *by).length()).sum()),
        };
        let all = found.iter().chain(&tried).map(|own| own.mean());
        let shares = all.sum::<f64>() / (found.len() + tried.len()) as f64;
        let share = if wavelengths_change::<M>() {
            // What the wavelengths of other passes leave is not known: all the same in the mean.
            [lanes::<M, _>(|_| shares), lanes::<M, _>(|_| 0.0), lanes::<M, _>(|_| 0.0)]
        } else {
            let of = |signs: [f64; 4], per: f64| {
                let sum = |lane: usize| signs.iter().zip(&found).map(|(sign, own)| sign * own.share[lane]).sum::<f64>();
                lanes::<M, _>(|lane| sum(lane) / (4.0 * per))
            };
            let reach = REACH * side;
            [of([1.0; 4], 1.0), of([1.0, 1.0, -1.0, -1.0], reach), of([1.0, -1.0, 1.0, -1.0], reach)]
        };
        let steady = wavelengths_change::<M>()
            || tried.iter().zip(TRIALS).all(|(own, [x, y, ..])| {
                let mean = |of: &M::Lanes<f64>| of.as_slice().iter().sum::<f64>() / M::LANES as f64;
                let foretold = mean(&share[0]) + side * (mean(&share[1]) * x + mean(&share[2]) * y);
                (own.mean() - foretold).abs() <= STEADY * foretold
            });
        let shown = Shown { middle, plane: sight.plane, alone: sight.alone, place, share, pairs: 0 };
        steady.then(|| Known { shown: shown.with_pairs(moves), off })
    }
}
