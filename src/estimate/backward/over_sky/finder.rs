//! Which pixels it is worth it in: blocks are looked at by a few paths, and parted where those differ.

use super::sight::{Known, Scout, Seen, Sight};
use super::{OverSky, Shown};
use crate::backward::tuning::over_sky::{BLOCK, FAINT, LEAST_PARTED, MOST_ALIKE, PASSES_LOOKED_AT, TOLERANCE};
use crate::ownership::Ownership;
use eyebox_base::parallel;
use eyebox_base::path::{Event, Trail};
use eyebox_world::World;
use eyebox_world::mode::{Mode, wavelengths_change};
use eyebox_world::optics::Optics;
use glam::DVec2;
use std::collections::BTreeSet;

/// What has been found in a block: (pixel, number of what is shown).
struct Found<M: Mode> {
    shown: Vec<Shown<M>>,
    of: Vec<(usize, usize)>,
}

/// A square of pixels: its first column and row.
#[derive(Debug, Clone, Copy)]
struct Square {
    corner: [usize; 2],
    side: usize,
}

impl<M: Mode> OverSky<M> {
    /// In all of the eye's picture, or in some pixels of it, as a pilot looks at. None where there is nothing to find.
    pub(in crate::backward) fn find(
        world: &World,
        route: &Ownership,
        seed: u64,
        only: Option<&[[usize; 2]]>,
    ) -> Option<OverSky<M>> {
        let sky = world.sky.as_ref().filter(|sky| !world.plain && !sky.is_plain())?;
        let trails = [Trail::START, Trail::START.then(Event::Specular)];
        trails.iter().find_map(|trail| route.from_eye(sky.group, *trail))?;
        let passes = if wavelengths_change::<M>() { PASSES_LOOKED_AT } else { 1 };
        let optics: Vec<Optics<M>> = (0..passes).map(|pass| M::optics(world, seed, pass)).collect();
        let scout = Scout { world, route, sky, optics: &optics, seed };
        let [width, height] = world.eye.size();
        let squares: Vec<Square> = match only {
            None => {
                let all = (0..height).step_by(BLOCK).flat_map(|y| (0..width).step_by(BLOCK).map(move |x| [x, y]));
                all.map(|corner| Square { corner, side: BLOCK }).collect()
            }
            Some(pixels) => {
                let all: BTreeSet<&[usize; 2]> = pixels.iter().collect();
                all.into_iter().map(|corner| Square { corner: *corner, side: 1 }).collect()
            }
        };
        let in_square = |square: &Square| {
            let mut found = Found { shown: Vec::new(), of: Vec::new() };
            scout.part(*square, &mut found);
            found
        };
        let squares: Vec<Found<M>> = parallel::map_all(&squares, &in_square);
        let (mut shown, mut of) = (Vec::new(), Vec::new());
        for own in squares {
            let before = shown.len();
            of.extend(own.of.into_iter().map(|(pixel, k)| (pixel, before + k)));
            shown.extend(own.shown);
        }
        if of.is_empty() || u32::try_from(of.len().max(shown.len())).is_err() {
            return None;
        }
        of.sort_unstable();
        let mut first = vec![0u32; width * height + 1];
        of.iter().for_each(|(pixel, _)| first[pixel + 1] += 1);
        for pixel in 0..width * height {
            first[pixel + 1] += first[pixel];
        }
        let of = of.into_iter().map(|(_, k)| k as u32).collect();
        Some(OverSky { sky: sky.clone(), shown, first, of, seed })
    }
}

impl Square {
    fn middle(&self) -> DVec2 {
        let [x, y] = self.corner.map(|at| at as f64 + 0.5 * self.side as f64);
        DVec2::new(x, y)
    }

    /// Its pixels that the eye looks at.
    fn pixels(self, world: &World) -> impl Iterator<Item = [usize; 2]> {
        let ([x, y], [width, height]) = (self.corner, world.eye.size());
        let all =
            (y..(y + self.side).min(height)).flat_map(move |y| (x..(x + self.side).min(width)).map(move |x| [x, y]));
        all.filter(|pixel| world.eye.wants(*pixel))
    }

    fn quarters(self) -> [Square; 4] {
        let ([x, y], side) = (self.corner, self.side / 2);
        [[x, y], [x + side, y], [x, y + side], [x + side, y + side]].map(|corner| Square { corner, side })
    }
}

impl<M: Mode> Scout<'_, M> {
    /// Finds what is shown to a square's pixels, or to those of its quarters.
    fn part(&self, square: Square, found: &mut Found<M>) {
        if square.pixels(self.world).next().is_none() {
            return;
        }
        let side = square.side as f64;
        let seen = self.look(square.middle(), side);
        let Some((known, whole)) = self.trains(&seen, (square.middle(), side)) else { return };
        let borders = |own: &&Known<M>| !self.sky.is_alike(own.shown.extent(DVec2::ZERO, side));
        // Over a quarter of the side a map errs by a sixteenth.
        let bent = |own: &Known<M>| own.off > TOLERANCE && own.off <= TOLERANCE * side * side;
        let parts = (!whole && square.side > LEAST_PARTED) || known.iter().filter(borders).any(bent);
        if square.side > 1 && parts {
            square.quarters().into_iter().for_each(|quarter| self.part(quarter, found));
            return;
        }
        for own in known.into_iter().filter(|own| own.off <= TOLERANCE) {
            let middle = own.shown.middle;
            let place = |[x, y]: [usize; 2]| DVec2::new(x as f64, y as f64) + 0.5 - middle;
            let (number, before) = (found.shown.len(), found.of.len());
            let with = square.pixels(self.world).filter(|at| own.shown.has_borders(self.sky, place(*at)));
            found.of.extend(with.map(|[x, y]| (y * self.world.eye.size()[0] + x, number)));
            if found.of.len() > before {
                found.shown.push(own.shown);
            }
        }
    }

    /// The trains by which all paths from a square see the sky, and whether these are all that bring much of it. None where what
    /// they see of it is alike.
    fn trains(&self, seen: &Seen<M>, square: (DVec2, f64)) -> Option<(Vec<Known<M>>, bool)> {
        let all = || seen.starts.iter().chain(&seen.trials).flatten();
        let brightest = all().map(Sight::strength).fold(0.0, f64::max);
        let bright = all().filter(|sight| sight.strength() >= FAINT * brightest);
        let (mut trains, mut low, mut high): (Vec<&Sight<M>>, _, _) =
            (Vec::new(), DVec2::INFINITY, DVec2::NEG_INFINITY);
        for sight in bright {
            let place = self.sky.near(sight.place, trains.first().map_or(sight.place, |first| first.place));
            (low, high) = (low.min(place), high.max(place));
            if !trains.iter().any(|other| other.is_like(sight)) {
                trains.push(sight);
            }
        }
        // What lies between places that see one pixel of the sky's picture, and about as far beyond, is that pixel.
        let about = [low - (high - low), high + (high - low)];
        let is_alike = || self.sky.count(about).is_some_and(|count| count <= MOST_ALIKE) && self.sky.is_alike(about);
        if trains.is_empty() || is_alike() {
            return None;
        }
        let count = trains.len();
        let known: Vec<Known<M>> = trains.into_iter().filter_map(|train| self.known(train, seen, square)).collect();
        let whole = known.len() == count;
        Some((known, whole))
    }
}
