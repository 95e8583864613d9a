//! Where the pixels of a sky's picture meet in one of the eye's: the way from the eye over specular faces to the sky is smooth, so five
//! paths from a block of pixels tell where in the picture all places of it look to, and what the way leaves of the light. The
//! picture's pixels are cut by each pixel's footprint, exactly. Paths at places by chance differ from that by next to nothing, and
//! the difference is added: the mean is that of paths whatever the five have missed (a control variate, e.g. A. Owen, "Monte Carlo
//! theory, methods and examples", 2013, chapter 8.9).

mod finder;
mod sight;

use super::tuning::over_sky::{MOST_PAIRS, MOST_PIXELS, PER_PIXEL, TOLERANCE};
use crate::ledger::{Ledger, cost};
use crate::pixel::Pixel;
use eyebox_base::lattice::lattice;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::disk;
use eyebox_film::accumulate::Light;
use eyebox_world::mode::{Mode, lanes, plane_of};
use eyebox_world::optics::Optics;
use eyebox_world::sky::SkyLight;
use eyebox_world::sky::footprint::Footprint;
use glam::DVec2;
use std::sync::Arc;

/// What is linear in the place in the eye's picture, pixels from a block's middle to the right and down, and in the pupil, radii.
#[derive(Debug, Clone, Copy)]
struct Linear {
    middle: DVec2,
    by_pixel: [DVec2; 2],
    by_pupil: [DVec2; 2],
}

/// The sky's picture as a train of faces shows it to a block of pixels.
#[derive(Debug)]
struct Shown<M: Mode> {
    /// The block's middle in the eye's picture, pixels.
    middle: DVec2,
    plane: usize,
    alone: bool,
    /// Columns and rows of the sky's picture.
    place: Linear,
    /// What the train leaves of its light: in the middle, and more per pixel to the right and down.
    share: [M::Lanes<f64>; 3],
    /// By how many pairs of places of the pupil a pass knows the mean over all of it; 0 where the pupil hardly matters.
    pairs: u64,
}

/// What is foretold of the sky over specular faces, in the pixels that see borders in its picture.
#[derive(Debug)]
pub(super) struct OverSky<M: Mode> {
    sky: Arc<SkyLight>,
    shown: Vec<Shown<M>>,
    /// Those of pixel k are `of[first[k]..first[k + 1]]`.
    first: Vec<u32>,
    of: Vec<u32>,
    seed: u64,
}

impl Linear {
    /// At a place of the eye's picture, from the block's middle, and of the pupil.
    fn at(&self, pixels: DVec2, pupil: DVec2) -> DVec2 {
        let ([right, down], [u, v]) = (self.by_pixel, self.by_pupil);
        self.middle + right * pixels.x + down * pixels.y + u * pupil.x + v * pupil.y
    }
}

impl<M: Mode> Shown<M> {
    /// Of the pixel about a place (from the block's middle), for a place of the pupil.
    fn footprint(&self, pixel: DVec2, pupil: DVec2) -> Footprint {
        Footprint { at: self.place.at(pixel, pupil), by: self.place.by_pixel }
    }

    /// What the train leaves there.
    fn share(&self, pixels: DVec2, lane: usize) -> f64 {
        let [middle, right, down] = &self.share;
        middle[lane] + right[lane] * pixels.x + down[lane] * pixels.y
    }

    /// Between which places of the sky's picture a square of the eye's lies (its middle from the block's, its side in pixels), for
    /// all of the pupil and with what the map may err by.
    fn extent(&self, pixels: DVec2, side: f64) -> [DVec2; 2] {
        let ([right, down], [u, v]) = (self.place.by_pixel, self.place.by_pupil);
        let more = (right.abs() + down.abs()) * TOLERANCE + u.abs() + v.abs();
        Footprint { at: self.place.at(pixels, DVec2::ZERO), by: [right * side, down * side] }.extent(more)
    }

    /// Whether a pixel sees borders, and not so many that cutting them would take longer than paths do.
    fn has_borders(&self, sky: &SkyLight, pixel: DVec2) -> bool {
        let extent = self.extent(pixel, 1.0);
        sky.count(extent).is_some_and(|count| count <= MOST_PIXELS) && !sky.is_alike(extent)
    }

    /// `moves`: pixels by which the picture moves from the middle of the pupil to its rim.
    fn with_pairs(self, moves: f64) -> Self {
        Shown { pairs: (PER_PIXEL * moves).ceil().min(MOST_PAIRS) as u64, ..self }
    }

    /// Light per lane that comes from all of a pixel to a place of the pupil, cd/m², and of how many pieces it is put together.
    fn mean(&self, (sky, optics): (&SkyLight, &Optics<M>), pixel: DVec2, pupil: DVec2) -> (M::Lanes<f64>, u64) {
        let [_, right, down] = &self.share;
        let (mut light, mut pieces) = (lanes::<M, _>(|_| 0.0), 0);
        sky.pieces(&self.footprint(pixel, pupil), |texel, area, moment| {
            let luminance = optics.sky_at(sky, texel);
            for lane in 0..M::LANES {
                let share = self.share(pixel, lane) * area + right[lane] * moment.x + down[lane] * moment.y;
                light[lane] += luminance[lane] * share;
            }
            pieces += 1;
        });
        (light, pieces)
    }

    fn deposit(&self, optics: &Optics<M>, out: &mut [Light], light: &M::Lanes<f64>, weight: f64) {
        let light = lanes::<M, _>(|lane| Light::ONE.scaled(light[lane] * weight));
        M::deposit(optics, plane_of::<M>(out, self.plane), light, self.alone);
    }
}

impl<M: Mode> OverSky<M> {
    fn of(&self, pixel: Pixel) -> impl Iterator<Item = &Shown<M>> {
        let index = pixel.index as usize;
        let own = self.first[index] as usize..self.first[index + 1] as usize;
        self.of[own].iter().map(|shown| &self.shown[*shown as usize])
    }

    /// Whether anything is foretold of a pixel by number.
    pub(super) fn knows(&self, pixel: u64) -> bool {
        self.first[pixel as usize] < self.first[pixel as usize + 1]
    }

    /// Adds what is foretold of all of a pixel and the pupil.
    pub(super) fn add_mean(&self, optics: &Optics<M>, pixel: Pixel, out: &mut [Light], ledger: &mut Ledger) {
        for shown in self.of(pixel) {
            let middle = DVec2::new(pixel.x as f64, pixel.y as f64) + 0.5 - shown.middle;
            let mut add = |pupil: DVec2, weight: f64| {
                let (light, pieces) = shown.mean((&self.sky, optics), middle, pupil);
                ledger.work += pieces * cost::CUT;
                shown.deposit(optics, out, &light, weight);
            };
            if shown.pairs == 0 {
                add(DVec2::ZERO, 1.0);
                continue;
            }
            let mut shift = Rng::new(self.seed, Stream::SkyPixels, 1 + pixel.pass, pixel.index);
            let shift = [shift.next_u64(), shift.next_u64()];
            // Each with the one across from it: what is linear over the pupil, most of it, is exact.
            for pupil in (0..shown.pairs).map(|k| disk(lattice(shift, k))) {
                add(pupil, 0.5 / shown.pairs as f64);
                add(-pupil, 0.5 / shown.pairs as f64);
            }
        }
    }

    /// Takes off what is foretold of a place of it (right and down from its corner) and of the pupil (as
    /// [`ray`](eyebox_world::eye::EyeLens::ray) takes it).
    pub(super) fn take_off(
        &self,
        optics: &Optics<M>,
        (pixel, [x, y], lens): (Pixel, [f64; 2], [f64; 2]),
        weight: f64,
        out: &mut [Light],
    ) {
        for shown in self.of(pixel) {
            let pixels = DVec2::new(pixel.x as f64 + x, pixel.y as f64 + y) - shown.middle;
            let pupil = if shown.pairs == 0 { DVec2::ZERO } else { disk(lens) };
            let luminance = optics.sky_at(&self.sky, self.sky.pixel_at(shown.place.at(pixels, pupil)));
            let light = lanes::<M, _>(|lane| luminance[lane] * shown.share(pixels, lane));
            shown.deposit(optics, out, &light, -weight);
        }
    }
}
