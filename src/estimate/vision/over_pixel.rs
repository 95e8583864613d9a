//! Where a slide's picture, or a display's, has an edge in a pixel, or a lamp's emission texture detail: the way from the pixel and
//! the pupil to the picture is smooth, so five paths tell where all of both lands on it, and how bright that is. For a place of the
//! pupil the picture's pixels are cut by this footprint, exactly, and so are the outlines of the faces on the way. Paths at places of
//! the pixel and the pupil by chance differ from it by next to nothing, and the difference is added: the mean is that of paths
//! whatever the five have missed (a control variate, e.g. A. Owen, "Monte Carlo theory, methods and examples", 2013, chapter 8.9).

mod finder;
mod sight;

use super::{Met, Vision};
use crate::ledger::{Ledger, cost};
use crate::ownership::Ownership;
use crate::pixel::Pixel;
use crate::tuning::over_pixel::{CUTS, MOST_PAIRS, PER_PIXEL, RAYS_TO_CUT, WIDER};
use arrayvec::ArrayVec;
use eyebox_base::rng::Stream;
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::mode::{LaneArray, Mode, lanes, plane_of};
use eyebox_world::optics::Optics;
use eyebox_world::slide::footprint::{self, Brightness, Edge, Footprint, Lines, MOST, MOST_EDGES};
use eyebox_world::slide::texels::Texels;
pub(super) use finder::PixelFootprints;
use glam::{DVec2, DVec3};
use sight::Square;
use std::f64::consts::PI;

/// What is linear in the place in a pixel, from its middle to the right and down, and in the pupil, in radii.
#[derive(Debug, Clone, Copy)]
struct Linear<T> {
    middle: T,
    by_pixel: [T; 2],
    by_pupil: [T; 2],
}

/// A lamp seen over all of a pixel and the pupil.
#[derive(Debug)]
pub(super) struct OverPixel<M: Mode> {
    plane: usize,
    alone: bool,
    /// Luminance per lane, cd/m², with the slides open; the mean of a lamp with a texture.
    brightness: Linear<M::Lanes<f64>>,
    /// Such a lamp, and where in its texture it is seen, columns and rows of texels.
    texels: Option<(usize, Linear<DVec2>)>,
    /// Where each slide is crossed, mesh units.
    slides: Box<[(usize, Linear<DVec3>)]>,
    /// How far inside of where the chain's faces, and the lamp, end.
    edges: Box<[Linear<f64>]>,
    /// By how many pairs of places of the pupil a pass knows the mean over all of it.
    pairs: u64,
}

impl<T: Copy> Linear<T> {
    /// By how many pixels the place moves from the middle of the pupil to its rim, about.
    fn pixels_over_pupil(&self, length: impl Fn(T) -> f64) -> f64 {
        let of = |by: [T; 2]| length(by[0]) + length(by[1]);
        of(self.by_pupil) / of(self.by_pixel)
    }

    fn is_all(&self, of: impl Fn(T) -> bool) -> bool {
        [self.middle].iter().chain(&self.by_pixel).chain(&self.by_pupil).all(|own| of(*own))
    }
}

/// The same for one place of the pupil.
struct AtPupil<M: Mode> {
    brightness: Brightness<M>,
    texels: Option<Texels>,
    footprints: ArrayVec<Footprint, MOST>,
    edges: ArrayVec<Edge, MOST_EDGES>,
}

/// Place number `k` of so many on a disc, in its radii: a spiral by the golden angle, each place in a ring of the same area (H. Vogel,
/// "A better way to construct the sunflower head", Math. Biosci. 44, 1979). `start`: 0 to 1, where in its ring the first lies.
fn on_spiral(k: u64, count: u64, start: [f64; 2]) -> DVec2 {
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    let radius = ((k as f64 + start[0]) / count as f64).sqrt();
    DVec2::from_angle(golden_angle * k as f64 + 2.0 * PI * start[1]) * radius
}

impl<M: Mode> AtPupil<M> {
    fn mean(&self, tracing: (&World, &Optics<M>)) -> Option<(M::Lanes<Light>, u64)> {
        footprint::mean_of(tracing, (&self.brightness, self.texels.as_ref()), (&self.edges, &self.footprints))
    }
}

impl<M: Mode> OverPixel<M> {
    /// `pupil`: in radii.
    fn at_pupil(&self, pupil: DVec2) -> AtPupil<M> {
        let Linear { middle, by_pixel, by_pupil } = &self.brightness;
        let along = |lane: usize| middle[lane] + by_pupil[0][lane] * pupil.x + by_pupil[1][lane] * pupil.y;
        let footprint = |(slide, place): &(usize, Linear<DVec3>)| {
            let at = place.middle + place.by_pupil[0] * pupil.x + place.by_pupil[1] * pupil.y;
            Footprint { slide: *slide, at, by: place.by_pixel }
        };
        let texels = |(lamp, place): &(usize, Linear<DVec2>)| {
            let at = place.middle + place.by_pupil[0] * pupil.x + place.by_pupil[1] * pupil.y;
            let [right, down] = place.by_pixel;
            let lines = [0, 1].map(|way| Lines { first: at[way], by: DVec2::new(right[way], down[way]) });
            Texels { lamp: *lamp, at: lines }
        };
        let edge = |inside: &Linear<f64>| Edge {
            first: inside.middle + DVec2::from_array(inside.by_pupil).dot(pupil),
            by: DVec2::from_array(inside.by_pixel),
        };
        AtPupil {
            brightness: Brightness { middle: lanes::<M, _>(along), by: *by_pixel },
            texels: self.texels.as_ref().map(texels),
            footprints: self.slides.iter().map(footprint).collect(),
            edges: self.edges.iter().map(edge).collect(),
        }
    }

    /// In the middle, cd/m².
    fn strength(&self) -> f64 {
        self.brightness.middle.as_slice().iter().fold(0.0, |most: f64, own| most.max(own.abs()))
    }

    /// How many pairs of places of the pupil tell what is seen through all of it: more the farther the picture moves from one to
    /// another, fewer where it has but a share of the light or is put together of many pieces.
    /// `cuts`: pieces that all places may take.
    fn pairs(&self, share: f64, pieces: u64, cuts: u64) -> u64 {
        let of_slides = self.slides.iter().map(|(_, place)| place.pixels_over_pupil(DVec3::length));
        let of_texture = self.texels.iter().map(|(_, place)| place.pixels_over_pupil(DVec2::length));
        let of_edge = |by: &[f64; 2]| by[0].abs() + by[1].abs();
        let of_edges = self.edges.iter().map(|inside| of_edge(&inside.by_pupil) / of_edge(&inside.by_pixel));
        let pixels = of_slides.chain(of_texture).chain(of_edges).filter(|moves| moves.is_finite()).fold(0.0, f64::max);
        let share = if share.is_finite() { share } else { 1.0 };
        ((share * (PER_PIXEL * pixels).min(MOST_PAIRS)) as u64).min(cuts / pieces.max(1)).max(1)
    }

    /// What is seen at a place of the pixel, from its middle, and of the pupil; none where that is beside a picture or an edge.
    fn at(&self, tracing: (&World, &Optics<M>), (within, pupil): (DVec2, DVec2)) -> Option<M::Lanes<Light>> {
        let AtPupil { brightness, texels, footprints, edges } = self.at_pupil(pupil);
        let light = footprint::at(tracing, &brightness, (&edges, &footprints), within)?;
        let Some(texels) = texels else { return Some(light) };
        let factor = texels.factor(tracing, within);
        Some(lanes::<M, _>(|lane| light[lane].scaled(factor[lane])))
    }

    /// In the middle of the pupil, without edges and with pictures over more than the pixel: what is seen by any place of the pupil
    /// lies in that.
    fn wide(&self) -> AtPupil<M> {
        let mut wide = self.at_pupil(DVec2::ZERO);
        wide.edges.clear();
        for (footprint, (_, place)) in wide.footprints.iter_mut().zip(&self.slides) {
            let wider = WIDER + 2.0 * place.pixels_over_pupil(DVec3::length);
            footprint.by = footprint.by.map(|by| wider * by);
        }
        if let (Some(texels), Some((_, place))) = (&mut wide.texels, &self.texels) {
            // A texture may be the same place of itself all over: 0/0.
            let wider = WIDER + 2.0 * place.pixels_over_pupil(DVec2::length).max(0.0);
            texels.at = texels.at.map(|lines| Lines { by: wider * lines.by, ..lines });
        }
        wide
    }

    /// Whether a picture, or what it is seen by, has an edge about here, for any place of the pupil.
    fn has_edge(&self, tracing: (&World, &Optics<M>)) -> bool {
        let wide = self.wide();
        let at_rim = |footprint: &Footprint| footprint.to_rim(&tracing.0.slides[footprint.slide]) <= 0.0;
        !self.edges.is_empty()
            || wide.texels.is_some_and(|texels| !texels.are_even(tracing.0))
            || wide.footprints.iter().any(at_rim)
            || wide.mean(tracing).is_none_or(|(_, pieces)| pieces != 1)
    }

    /// Whether a texture is much finer than the pixel.
    fn is_fine(&self) -> bool {
        self.at_pupil(DVec2::ZERO).texels.is_some_and(|texels| texels.count() > CUTS as f64)
    }

    /// Whether nothing of its picture lies about here.
    fn is_beside(&self, tracing: (&World, &Optics<M>)) -> bool {
        let is_none = |light: &Light| *light == Light::default();
        self.wide().mean(tracing).is_some_and(|(mean, _)| mean.as_slice().iter().all(is_none))
    }
}

impl<M: Mode> Vision<'_, M> {
    /// Footprints that say something, with how many places of the pupil they are to be asked about. None where a picture is much
    /// finer than the pixel: rays average it for less.
    /// `work`: of a ray, counted.
    fn sorted(&self, optics: &Optics<M>, mut all: Vec<OverPixel<M>>, work: u64) -> Vec<OverPixel<M>> {
        let tracing = (self.world, optics);
        all.retain(|over| !over.is_fine());
        all.retain(|over| !over.is_beside(tracing));
        // More than rays cost many times over is better spent on passes.
        let most = CUTS.min(RAYS_TO_CUT * work / (cost::CUT * all.len().max(1) as u64).max(1));
        let brightest = all.iter().map(OverPixel::strength).fold(0.0, f64::max);
        for over in &mut all {
            match over.at_pupil(DVec2::ZERO).mean(tracing) {
                Some((_, pieces)) if pieces <= CUTS => {
                    over.pairs = over.pairs(over.strength() / brightest, pieces, most);
                }
                Some(_) | None => return Vec::new(),
            }
        }
        all
    }

    /// The footprints of a pixel at a pass's wavelengths.
    pub(super) fn footprints_at(
        &self,
        tracing: (&Ownership, &Optics<M>),
        pixel: Pixel,
        work: &mut u64,
    ) -> Vec<OverPixel<M>> {
        let mut own = 0;
        let seen = self.over_square(tracing, (pixel, Square::PIXEL, true), &mut own);
        *work += own;
        self.sorted(tracing.1, seen.over, own / seen.rays)
    }

    /// Adds what footprints say of all of a pixel that is looked at with this share.
    pub(super) fn add_mean(
        &self,
        (optics, all): (&Optics<M>, &[OverPixel<M>]),
        (pixel, share): (Pixel, f64),
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        if all.is_empty() {
            return;
        }
        let [first, turn] = pixel.start(self.seed, Stream::PictureEdges, pixel.pass);
        for over in all {
            let pairs = over.pairs;
            let weight = 1.0 / (share * 2.0 * pairs as f64);
            // Each with the one across from it: what is linear over the pupil, most of it, is exact.
            for place in (0..pairs).map(|k| on_spiral(k, pairs, [first, turn])).flat_map(|place| [place, -place]) {
                let Some((mean, pieces)) = over.at_pupil(place).mean((self.world, optics)) else { continue };
                ledger.work += pieces * cost::CUT;
                let light = lanes::<M, _>(|lane| mean[lane].scaled(weight));
                M::deposit(optics, plane_of::<M>(out, over.plane), light, over.alone);
            }
        }
    }

    /// Takes off what they say of a place of the pixel (right and down from its corner) and the pupil (in radii).
    pub(super) fn take_off(
        &self,
        (optics, all): (&Optics<M>, &[OverPixel<M>]),
        (jitter, pupil): ([f64; 2], DVec2),
        weight: f64,
        out: &mut [Light],
    ) {
        let within = DVec2::from_array(jitter) - 0.5;
        for over in all {
            if let Some(light) = over.at((self.world, optics), (within, pupil)) {
                let light = lanes::<M, _>(|lane| light[lane].scaled(-weight));
                M::deposit(optics, plane_of::<M>(out, over.plane), light, over.alone);
            }
        }
    }
}
