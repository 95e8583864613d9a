//! Which pixels have footprints: those with edges of pictures in them, where trials say that the footprints are right.

use super::sight::Square;
use super::{OverPixel, Vision};
use crate::ledger::Ledger;
use crate::ownership::Ownership;
use crate::pixel::Pixel;
use crate::tuning::over_pixel::{BLOCK, RIGHT, TRIALS, WORTH};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::accumulate::Light;
use eyebox_world::mode::{Mode, components};
use eyebox_world::optics::Optics;
use glam::DVec2;

/// The footprints of those pixels.
pub(in crate::vision) struct PixelFootprints<M: Mode>(
    /// Per pixel; nothing where it has none.
    Vec<Box<[OverPixel<M>]>>,
);

/// What a block by itself knows of pictures.
#[derive(Debug, Clone, Copy)]
enum Known {
    Even,
    Edge,
    /// Nothing in all of it.
    Dark,
}

impl<M: Mode> PixelFootprints<M> {
    /// `optics`: of the wavelengths at which edges are looked for.
    pub(in crate::vision) fn find(
        vision: &Vision<'_, M>,
        route: &Ownership,
        optics: &[Optics<M>],
    ) -> PixelFootprints<M> {
        let [width, height] = vision.world.eye.size();
        let finders: Vec<Finder<'_, M>> = optics.iter().map(|optics| Finder { vision, route, optics, width }).collect();
        let [across, down] = [width, height].map(|side| side.div_ceil(BLOCK));
        let block = |k: usize| {
            let known = finders.iter().map(|finder| finder.block([k % across * BLOCK, k / across * BLOCK]));
            known.reduce(Known::or).unwrap_or(Known::Dark)
        };
        let blocks: Vec<Known> = parallel::map(across * down, &block);
        let is_near = |[x, y]: [usize; 2]| {
            let [x, y] = [x / BLOCK, y / BLOCK];
            let near = (y.saturating_sub(1)..(y + 2).min(down))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(across)).map(move |x| y * across + x));
            match blocks[y * across + x] {
                Known::Even => false,
                Known::Edge => true,
                Known::Dark => near.into_iter().any(|block| !matches!(blocks[block], Known::Dark)),
            }
        };
        let of_pixel = |index: usize| {
            let at = [index % width, index / width];
            let wanted = vision.world.eye.wants(at) && is_near(at);
            if !wanted {
                return Box::default();
            }
            let mut found = finders.iter().map(|finder| finder.best(Pixel::new((at[0], at[1]), width, 0)));
            found.find(|all| !all.is_empty()).unwrap_or_default().into()
        };
        PixelFootprints(parallel::map(width * height, &of_pixel))
    }

    /// Those of a pixel.
    pub(in crate::vision) fn of(&self, pixel: u64) -> &[OverPixel<M>] {
        self.0.get(pixel as usize).map_or(&[], |own| own)
    }
}

impl Known {
    fn or(self, other: Known) -> Known {
        match (self, other) {
            (Known::Edge, _) | (_, Known::Edge) | (Known::Even, Known::Dark) | (Known::Dark, Known::Even) => {
                Known::Edge
            }
            (Known::Even, Known::Even) => Known::Even,
            (Known::Dark, Known::Dark) => Known::Dark,
        }
    }
}

struct Finder<'f, M: Mode> {
    vision: &'f Vision<'f, M>,
    route: &'f Ownership,
    optics: &'f Optics<M>,
    width: usize,
}

impl<M: Mode> Finder<'_, M> {
    fn block(&self, [x, y]: [usize; 2]) -> Known {
        let wants = |k: usize| self.vision.world.eye.wants([x + k % BLOCK, y + k / BLOCK]);
        if !(0..BLOCK * BLOCK).any(wants) {
            return Known::Dark;
        }
        let middle = 0.5 * (BLOCK - 1) as f64;
        let square = Square { middle, side: BLOCK as f64 };
        let pixel = Pixel::new((x, y), self.width, 0);
        let seen = self.vision.over_square((self.route, self.optics), (pixel, square, false), &mut 0);
        let tracing = (self.vision.world, self.optics);
        if seen.dark {
            Known::Dark
        } else if !seen.whole || seen.over.iter().any(|over| over.has_edge(tracing)) {
            Known::Edge
        } else {
            Known::Even
        }
    }

    /// The footprints of a pixel, if they are worth it. None where all of it is even.
    fn best(&self, pixel: Pixel) -> Vec<OverPixel<M>> {
        let mut work = 0;
        let mut seen = self.vision.over_square((self.route, self.optics), (pixel, Square::PIXEL, true), &mut work);
        let is_even = seen.whole && !seen.over.iter().any(|over| over.has_edge((self.vision.world, self.optics)));
        seen.over.retain(|over| !over.is_fine());
        if is_even || !self.are_worth_it(pixel, &seen.over) {
            return Vec::new();
        }
        self.vision.sorted(self.optics, seen.over, work / seen.rays)
    }

    /// Whether paths differ from what footprints say by much less than they differ from each other, or by next to nothing.
    fn are_worth_it(&self, pixel: Pixel, all: &[OverPixel<M>]) -> bool {
        if all.is_empty() {
            return false;
        }
        let (vision, optics) = (self.vision, self.optics);
        let luminance = |light: &[Light]| {
            light.chunks(M::COMPONENTS).map(|own| components::<M>().luminance(own).value).sum::<f64>()
        };
        let mut ledger = Ledger::new(vision.world.solids.len());
        let mut pairs = [[0.0; 2]; TRIALS.len()];
        for (k, (pair, [x, y, u, v])) in pairs.iter_mut().zip(TRIALS).enumerate() {
            let mut seen = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
            let mut more = seen.clone();
            let (jitter, pupil) = ([x + 0.5, y + 0.5], DVec2::new(u, v));
            let rng = Rng::new(vision.seed, Stream::PictureEdges, 1 + k as u64, pixel.index);
            vision.look_along((self.route, optics), (pixel, jitter, pupil), (1.0, rng), &mut seen, &mut ledger);
            vision.take_off((optics, all), (jitter, pupil), -1.0, &mut more);
            *pair = [luminance(&seen), luminance(&more)];
        }
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / TRIALS.len() as f64;
        let variance = (mean(&|pair| pair[0] * pair[0]) - mean(&|pair| pair[0]).powi(2)).max(0.0);
        let off = mean(&|[seen, foretold]| (seen - foretold).powi(2));
        let brightest = pairs.iter().flatten().fold(0.0, |most: f64, light| most.max(*light));
        off <= (RIGHT * brightest).powi(2) || off <= WORTH * variance
    }
}
