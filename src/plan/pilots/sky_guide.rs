//! Through which windows light of the sky gets in: in a room most directions that are chosen by the sky's luminance end on
//! a wall. A few paths from the eye tell where it gets in, and the scatterers on all others aim there.

use super::SEED;
use super::tuning::sky_guide::{AIMED, LOOK, MOST_WIDE, NARROW, TILES, WIDE, WORTH};
use crate::Planner;
use eyebox_base::path::Class;
use eyebox_estimate::backward::{Backward, Daylight};
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::vision::Hints;
use eyebox_film::guide::{Entry, Portals};
use eyebox_film::plan::{Estimator, Plan};
use eyebox_world::mode::Mono;

/// What scatterers need to know to find the sky. None if the plan leaves
/// no light of the sky that scatterers send to paths from the eye, or the sky is open.
pub(crate) fn learn(making: &Planner<'_>, plan: &Plan) -> Option<Portals> {
    let (world, facts) = (making.world, making.checked.facts());
    let sky = world.sky.as_ref().filter(|sky| sky.integral() > 0.0)?;
    let scattered = |class: &Class| match class {
        Class::Vision => false,
        Class::Primary | Class::Caustic | Class::Secondary => {
            [false, true].iter().any(|broad| plan.computes(Estimator::Backward, sky.group, *class, *broad))
        }
    };
    if !facts.scatters || !Class::ALL.iter().any(scattered) || making.stopped() {
        return None;
    }
    let mut looks = Looks { making, plan, taken: Vec::new(), found: Vec::new() };
    let mut known = None;
    while known.is_none() && looks.paths() < MOST_WIDE && !making.stopped() {
        looks.take(None, looks.paths().max(WIDE));
        known = looks.learn(LOOK);
    }
    // An estimate that knows what was learned from is too hopeful, and that is good enough to give up by.
    let gain = looks.moment(None, 0) / looks.moment(Some(known.as_ref()?), 0);
    if gain.is_nan() || gain < WORTH {
        return None;
    }
    let mut aimed = LOOK;
    for paths in NARROW {
        if making.stopped() {
            return None;
        }
        let windows = known?;
        let of = looks.taken.len();
        looks.take(Some(windows.clone()), paths);
        // By paths of which nothing was learned.
        let aiming = AIMED.map(|aimed| (looks.moment(Some(&windows.clone().aiming(aimed)), of), aimed));
        let best = aiming.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let gain = looks.moment(None, of) / best.0;
        if gain.is_nan() || gain < WORTH {
            return None;
        }
        aimed = best.1;
        known = looks.learn(LOOK);
    }
    Some(known?.aiming(aimed))
}

/// Looks taken so far.
struct Looks<'m> {
    making: &'m Planner<'m>,
    plan: &'m Plan,
    /// Each with what guided it and its number of paths.
    taken: Vec<(Option<Portals>, u64)>,
    /// What was found, with the number of the look.
    found: Vec<(usize, Daylight)>,
}

impl Looks<'_> {
    fn paths(&self) -> u64 {
        self.taken.iter().map(|(_, paths)| paths).sum()
    }

    fn take(&mut self, windows: Option<Portals>, paths: u64) {
        let Planner { world, stop, .. } = self.making;
        let route = Ownership::new(self.plan, self.making.groups(), Estimator::Backward);
        let hints = Hints::of_sky(windows.as_ref());
        let look = self.taken.len();
        let backward = Backward::<Mono>::new(world, route, (1, 1.0), hints, SEED);
        let found = backward.daylight(look as u64, paths, stop);
        self.found.extend(found.into_iter().map(|light| (look, light)));
        self.taken.push((windows, paths));
    }

    /// What all looks from `first` on teach of each piece of light of theirs: how much of its tile's it is over the density
    /// of finding it by all their paths (the balance heuristic of E. Veach, 1997), and that density.
    fn weighed(&self, first: usize) -> Vec<(&Daylight, [f64; 2])> {
        let looks = self.taken.iter().skip(first);
        let density = |light: &Daylight| {
            looks.clone().map(|(windows, paths)| *paths as f64 * light.density(windows.as_ref())).sum::<f64>()
        };
        let mut tiles = [0.0; TILES * TILES];
        let mut all: Vec<(&Daylight, [f64; 2])> = Vec::new();
        for (_, light) in self.found.iter().filter(|(look, _)| *look >= first) {
            let density = density(light);
            tiles[tile(light)] += light.light / density;
            all.push((light, [light.light, density]));
        }
        all.iter_mut().for_each(|(light, [share, _])| *share /= tiles[tile(light)]);
        all
    }

    fn learn(&self, aimed: f64) -> Option<Portals> {
        let entry = |(light, [share, density]): (&Daylight, [f64; 2])| Entry {
            to: light.point,
            from: light.dir,
            weight: share / density,
        };
        let entries: Vec<Entry> = self.weighed(0).into_iter().map(entry).collect();
        Portals::learn(self.making.world.geometry.bounds(), aimed, &entries)
    }

    /// Second moment of what a scatterer gets, relative to its tile's light, by the looks from `first` on.
    fn moment(&self, windows: Option<&Portals>, first: usize) -> f64 {
        let square = |(light, [share, density]): (&Daylight, [f64; 2])| {
            let tried = light.density(windows);
            // Where no direction of these leads to, over faces that bend light, others do.
            (tried > 0.0).then(|| share * share / (density * tried))
        };
        self.weighed(first).into_iter().filter_map(square).sum()
    }
}

fn tile(light: &Daylight) -> usize {
    let [x, y] = light.field.map(|x| ((x * TILES as f64) as usize).min(TILES - 1));
    y * TILES + x
}
