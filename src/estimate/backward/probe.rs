//! What a pilot sees of the sky: where its light gets in to the scatterers on some paths from the eye.

use super::Backward;
use super::tuning::probe::{MOST_EVENTS, MOST_SCATTERED};
use crate::ShouldStop;
use crate::ledger::Ledger;
use crate::walk::{Meeting, Met, Travel, Vertex, Walker};
use eyebox_base::lattice::lattice;
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::Frame;
use eyebox_film::guide::Portals;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use eyebox_world::sky::SkyLight;
use glam::DVec3;

/// Light of the sky that a scatterer gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    /// Place in the picture of the path, 0 to 1 across and down.
    pub field: [f64; 2],
    /// The scatterer, recentred world, m.
    pub point: DVec3,
    /// Unit direction that was chosen there.
    pub dir: DVec3,
    /// Luminance that the path would bring from there if the direction's density were 1/sr.
    pub light: f64,
    /// Density of the scatterer's own directions, and of those by luminance, 1/sr.
    pub by_face: f64,
    pub by_sky: f64,
}

impl Daylight {
    /// Density of the directions that a scatterer tries, one of its own and one to the sky, which `windows` guide: their number
    /// times that of each, 1/sr.
    pub fn density(&self, windows: Option<&Portals>) -> f64 {
        self.by_face + windows.map_or(self.by_sky, |windows| windows.among(self.point, self.dir, self.by_sky))
    }
}

impl Backward<'_, Mono> {
    /// Follows `paths` paths, spread over the picture, and tries two directions at each scatterer: one to the sky, and one of
    /// the scatterer's own. Once `stop` says true the rest is left out. `pass`: another one has other paths.
    pub fn daylight(&self, pass: u64, paths: u64, stop: &ShouldStop<'_>) -> Vec<Daylight> {
        let Some(sky) = &self.world.sky else { return Vec::new() };
        let optics = Mono::<f64>::optics(self.world, self.seed, 0);
        let path = |k: u64, found: &mut Vec<Daylight>| {
            if !stop() {
                self.probe((sky, &optics), pass * paths + k, Rng::new(self.seed, Stream::Daylight, pass, k), found);
            }
        };
        parallel::flat_map(paths, &path)
    }

    fn probe(&self, (sky, optics): (&SkyLight, &Optics<Mono>), k: u64, mut rng: Rng, found: &mut Vec<Daylight>) {
        let [width, height] = self.world.eye.size().map(|n| n as f64);
        let [x, y, u, v] = lattice([0; 4], k);
        let (px, py) = ((x * width) as usize, (y * height) as usize);
        let (origin, dir) = self.world.eye.ray(px, py, [(x * width).fract(), (y * height).fract()], [u, v]);
        let ray = Ray { origin, dir, from: None };
        let mut walker = Walker::new((self.world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng.fork());
        let ledger = &mut Ledger::new(self.world.solids.len());
        let mut scattered = 0;
        while walker.events < MOST_EVENTS {
            let Met::Face(vertex) = walker.advance(ledger) else { return };
            walker.last = None;
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) => {
                    self.ask(sky, &walker, (&vertex, scatter, &frame), ([x, y], &mut rng), found);
                    scattered += 1;
                    if scattered >= MOST_SCATTERED || walker.scatter(&vertex, scatter, &frame, ledger).is_none() {
                        return;
                    }
                }
            }
            if !self.reach.allows(walker.trail) {
                return;
            }
        }
    }

    /// Tries two directions at a scatterer.
    fn ask(
        &self,
        sky: &SkyLight,
        walker: &Walker<'_, Mono>,
        (vertex, scatter, frame): (&Vertex, &Scatter, &Frame),
        (field, rng): ([f64; 2], &mut Rng),
        found: &mut Vec<Daylight>,
    ) {
        let (point, d_in) = (vertex.hit.point, frame.to_local(walker.ray.dir));
        let sides = walker.sides(vertex, scatter);
        let sides = sides.of(0);
        let (to_sky, of_face) = (rng.pair(), rng.triple());
        let own = scatter.sample(d_in, sides, of_face).map(|sampled| frame.to_world(sampled.dir));
        let ledger = &mut Ledger::new(self.world.solids.len());
        for dir in [Some(self.skyward.sample(sky, point, to_sky).0), own].into_iter().flatten() {
            let by_face = scatter.pdf(d_in, frame.to_local(dir), sides);
            let mut there = walker.clone();
            there.rng = rng.fork();
            if !there.scatter_to((vertex, scatter, frame), (dir, 1.0), ledger)
                || !there.leave(ledger)
                || self.route.from_eye(sky.group, there.trail).is_none()
            {
                continue;
            }
            let light = there.beam.weight() * there.optics.sky(sky, there.ray.dir).as_slice()[0];
            let daylight = Daylight { field, point, dir, light, by_face, by_sky: sky.pdf(dir) };
            if light > 0.0 && light.is_finite() {
                found.push(daylight);
            }
        }
    }
}
