//! Where the light that lands about a place came from, as a few photons tell: a path from the eye that scatters there goes most
//! of the times towards it. Behind a collimator a screen is lit from a cone of a degree, which one path in thousands meets by
//! chance. Directions are weighed by the density of both ways to choose them, and a share of them is the scatterer's own
//! choice, so none has density 0 (guiding by photons: H. W. Jensen, "Importance driven path tracing using the photon map", EGWR 1995).

use super::tuning::glow::{
    ASIDE, BY_LIGHT, FAR, FEWEST, GUIDED, LEAF, LEAST_COS, MORE, NARROWEST, RIDGE, SHARES, WIDER, WIDEST,
};
use crate::photon::Landing;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::Frame;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

enum Node {
    Cut { axis: usize, at: f64, below: usize, above: usize },
    Leaf(Leaf),
}

/// Photons that landed near each other. Where they came from changes with the place, about linearly over so few: from a lens
/// that throws a picture it does, from a collimator it does not.
pub struct Leaf {
    middle: DVec3,
    /// About the mean direction to where they came from.
    frame: Frame,
    /// Change of that direction per metre, as tangents in the frame.
    slopes: [DVec3; 2],
    /// What is left of each photon's tangents, with the sum of weights so far.
    cones: Vec<(DVec2, f64)>,
    /// Cosines of the half angles of the cones, of wider ones about the same axes, and of the one about all of them: a lamp that
    /// has sent none of so few photons would else be met by none but the scatterer's own choices, with all the weight that these have.
    cos_half: f64,
    cos_wide: f64,
    cos_all: f64,
}

/// A leaf as it looks from a place.
pub struct About<'g> {
    leaf: &'g Leaf,
    shift: DVec2,
}

/// All of them, by place.
pub struct Glow {
    nodes: Vec<Node>,
    /// The share of the light that may come from where no photon points, by some that were set aside.
    missed: f64,
}

impl Glow {
    /// None if too few photons landed.
    pub fn new(landings: &[Landing]) -> Option<Glow> {
        let sound =
            |landing: &&Landing| landing.lumens > 0.0 && landing.position.is_finite() && landing.dir.is_finite();
        let mut known: Vec<Landing> = landings.iter().filter(sound).copied().collect();
        if known.len() < FEWEST {
            return None;
        }
        // By chance: photons start at even points, of which every fourth is a part of its own.
        let mut number = 0..;
        let mut aside = Vec::new();
        known.retain(|landing| {
            let is_aside = Rng::new(0, Stream::Witness, 4, number.next().unwrap_or(0)).uniform() * ASIDE < 1.0;
            if is_aside {
                aside.push(*landing);
            }
            !is_aside
        });
        let mut glow = Glow { nodes: Vec::new(), missed: 1.0 };
        glow.grow(&mut known);
        let is_missed =
            |landing: &&Landing| glow.at(landing.position).is_none_or(|about| about.density(-landing.dir, 0.0) == 0.0);
        let lumens = |all: &mut dyn Iterator<Item = &Landing>| all.map(|landing| landing.lumens).sum::<f64>();
        let all = lumens(&mut aside.iter());
        if all > 0.0 {
            let more = MORE * all / aside.len() as f64;
            glow.missed = (lumens(&mut aside.iter().filter(is_missed)) + more) / (all + more);
        }
        Some(glow)
    }

    /// The share of the light that may come from where no photon points.
    pub fn missed(&self) -> f64 {
        self.missed
    }

    fn grow(&mut self, landings: &mut [Landing]) -> usize {
        let own = self.nodes.len();
        if landings.len() <= LEAF {
            self.nodes.push(Node::Leaf(Leaf::of(landings)));
            return own;
        }
        let (low, high) = landings.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), landing| {
            (low.min(landing.position), high.max(landing.position))
        });
        let wide = (high - low).to_array();
        let axis = (0..3).fold(0, |best, axis| if wide[axis] > wide[best] { axis } else { best });
        let middle = landings.len() / 2;
        landings.select_nth_unstable_by(middle, |a, b| a.position[axis].total_cmp(&b.position[axis]));
        let at = landings[middle].position[axis];
        let (first, second) = landings.split_at_mut(middle);
        self.nodes.push(Node::Cut { axis, at, below: 0, above: 0 });
        let (below, above) = (self.grow(first), self.grow(second));
        self.nodes[own] = Node::Cut { axis, at, below, above };
        own
    }

    /// The photons about a place.
    pub fn at(&self, point: DVec3) -> Option<About<'_>> {
        let mut node = self.nodes.first()?;
        loop {
            match node {
                Node::Leaf(leaf) => return Some(leaf.about(point)),
                Node::Cut { axis, at, below, above } => {
                    node = &self.nodes[if point[*axis] < *at { *below } else { *above }];
                }
            }
        }
    }
}

impl Leaf {
    fn of(landings: &[Landing]) -> Leaf {
        let count = landings.len() as f64;
        let mean = |of: &dyn Fn(&Landing) -> DVec3| landings.iter().map(of).sum::<DVec3>() / count;
        let (middle, toward) = (mean(&|landing| landing.position), mean(&|landing| -landing.dir));
        let frame = Frame::about(toward.try_normalize().unwrap_or(DVec3::Z));
        // Far off the mean tangents mean little: such photons keep the direction that they had.
        let tangents = |landing: &Landing| {
            let local = frame.to_local(-landing.dir);
            (local.z > LEAST_COS).then(|| local.truncate() / local.z)
        };
        let slopes = slopes(landings, middle, &tangents);
        let all: f64 = landings.iter().map(|landing| landing.lumens).sum();
        let each = (1.0 - BY_LIGHT) / count;
        let mut sum = 0.0;
        let mut cones = Vec::new();
        for landing in landings {
            let Some(tangents) = tangents(landing) else { continue };
            sum += BY_LIGHT * landing.lumens / all + each;
            cones.push((tangents - linear(slopes, landing.position - middle), sum));
        }
        // None is left only where directions cancel each other.
        if cones.is_empty() {
            cones.push((DVec2::ZERO, 1.0));
            sum = 1.0;
        }
        cones.iter_mut().for_each(|(_, upto)| *upto /= sum);
        let nearest = |own: usize| {
            let others = cones.iter().enumerate().filter(|(other, _)| *other != own);
            others.map(|(_, (at, _))| at.distance(cones[own].0)).fold(f64::INFINITY, f64::min)
        };
        let mut apart: Vec<f64> = (0..cones.len()).map(nearest).collect();
        apart.sort_unstable_by(f64::total_cmp);
        let half = (WIDER * apart.get(apart.len() / 2).copied().unwrap_or(WIDEST)).clamp(NARROWEST, WIDEST);
        let farthest = cones.iter().map(|(at, _)| at.length()).fold(0.0, f64::max).atan();
        let wide = (FAR * half).min(WIDEST);
        let cos_all = (farthest + wide).min(FRAC_PI_2).cos();
        Leaf { middle, frame, slopes, cones, cos_half: half.cos(), cos_wide: wide.cos(), cos_all }
    }

    fn about(&self, point: DVec3) -> About<'_> {
        About { leaf: self, shift: linear(self.slopes, point - self.middle) }
    }
}

/// Solid angle of a cone.
fn solid_angle(cos_half: f64) -> f64 {
    TAU * (1.0 - cos_half)
}

fn linear(slopes: [DVec3; 2], by: DVec3) -> DVec2 {
    DVec2::from_array(slopes.map(|slope| slope.dot(by)))
}

/// By least squares, with a little of the spread of the places added along each axis: they lie on a face, which may be flat.
fn slopes(landings: &[Landing], middle: DVec3, tangents: &dyn Fn(&Landing) -> Option<DVec2>) -> [DVec3; 2] {
    let known = || landings.iter().filter_map(|landing| Some((landing.position - middle, tangents(landing)?)));
    let (mut squares, mut spread) = (DMat3::ZERO, 0.0);
    let mut products = [DVec3::ZERO; 2];
    for (at, tangents) in known() {
        squares += DMat3::from_cols(at * at.x, at * at.y, at * at.z);
        spread += at.length_squared();
        products[0] += at * tangents.x;
        products[1] += at * tangents.y;
    }
    let squares = squares + DMat3::from_diagonal(DVec3::splat(RIDGE * spread));
    let inverse = squares.inverse();
    if spread > 0.0 && inverse.is_finite() { products.map(|product| inverse * product) } else { [DVec3::ZERO; 2] }
}

impl About<'_> {
    /// The middle of a cone.
    fn axis(&self, tangents: DVec2) -> DVec3 {
        self.leaf.frame.to_world((tangents + self.shift).extend(1.0).normalize())
    }

    /// Whether a photon is to choose; else the scatterer does.
    pub fn chooses(&self, u: f64) -> bool {
        u < GUIDED
    }

    /// A unit direction by three numbers in [0, 1).
    pub fn draw(&self, [which, u, v]: [f64; 3]) -> DVec3 {
        let Leaf { cones, cos_half, cos_wide, cos_all, .. } = self.leaf;
        let [narrow, wide, _] = SHARES;
        let cone = |which: f64| cones[cones.partition_point(|(_, sum)| *sum <= which).min(cones.len() - 1)].0;
        let (tangents, cos_half) = if which < narrow {
            (cone(which / narrow), cos_half)
        } else if which < narrow + wide {
            (cone((which - narrow) / wide), cos_wide)
        } else {
            (DVec2::ZERO, cos_all)
        };
        let cos = 1.0 - u * (1.0 - cos_half);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * v).sin_cos();
        Frame::about(self.axis(tangents)).to_world(DVec3::new(sin * cos_phi, sin * sin_phi, cos))
    }

    /// Density per steradian of a direction by photons and the scatterer together; `own`: the scatterer's.
    pub fn density(&self, dir: DVec3, own: f64) -> f64 {
        let Leaf { cones, cos_half, cos_wide, cos_all, .. } = self.leaf;
        let (mut before, mut sums) = (0.0, [0.0; 3]);
        for (tangents, upto) in cones {
            let cos = self.axis(*tangents).dot(dir);
            sums[0] += if cos >= *cos_half { upto - before } else { 0.0 };
            sums[1] += if cos >= *cos_wide { upto - before } else { 0.0 };
            before = *upto;
        }
        sums[2] = if self.axis(DVec2::ZERO).dot(dir) >= *cos_all { 1.0 } else { 0.0 };
        let each = [*cos_half, *cos_wide, *cos_all].into_iter().zip(SHARES).zip(sums);
        let guided: f64 = each.map(|((cos, share), sum)| share * sum / solid_angle(cos)).sum();
        GUIDED * guided + (1.0 - GUIDED) * own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::path::Trail;
    use eyebox_world::geometry::Site;

    fn landing(position: DVec3, dir: DVec3) -> Landing {
        let site = Site { part: 0, face: 0, triangle: 0 };
        let lumens = 1.0 + position.x;
        Landing { site, position, dir, outside: true, lumens, connected: false, trail: Trail::START }
    }

    /// Photons about a slanted direction that turns along a line, 4° wide.
    fn photons(count: usize) -> Vec<Landing> {
        let mut rng = Rng::new(3, Stream::Check, 0, 0);
        let one = |_: usize| {
            let [x, a, b] = rng.triple();
            let to = DVec3::new(0.3 * x + 0.07 * (a - 0.5), 0.07 * (b - 0.5), 1.0).normalize();
            landing(DVec3::new(x, 0.0, 0.0), -to)
        };
        (0..count).map(one).collect()
    }

    /// Drawn directions have the density that is stated for them: of a mean over the sphere of any function.
    #[test]
    fn density_is_that_of_what_is_drawn() {
        let glow = Glow::new(&photons(2000)).unwrap();
        let leaf = glow.at(DVec3::new(0.4, 0.0, 0.0)).unwrap();
        let mut rng = Rng::new(4, Stream::Check, 0, 0);
        let (mut inside, mut total) = (0.0, 0.0);
        const COUNT: u32 = 100_000;
        for _ in 0..COUNT {
            let dir = leaf.draw(rng.triple());
            assert!((dir.length() - 1.0).abs() < 1e-12);
            let density = leaf.density(dir, 0.0) / GUIDED;
            assert!(density > 0.0);
            // The solid angle that is reached, and that of one half of it.
            total += 1.0 / density;
            inside += if dir.x > 0.12 { 1.0 / density } else { 0.0 };
        }
        // The same by even points on the sphere.
        let (mut all, mut half) = (0.0, 0.0);
        for _ in 0..20 * COUNT {
            let dir = eyebox_base::warp::sphere(rng.pair());
            let reached = f64::from(u8::from(leaf.density(dir, 0.0) > 0.0));
            all += reached;
            half += if dir.x > 0.12 { reached } else { 0.0 };
        }
        let sphere = 2.0 * TAU / f64::from(20 * COUNT);
        for (drawn, even) in [(total, all), (inside, half)] {
            let (got, want) = (drawn / f64::from(COUNT), even * sphere);
            let error = sphere * even.sqrt();
            assert!((got - want).abs() < 4.0 * error + 0.01 * want, "{got} {want} ± {error}");
        }
    }

    /// Nine lamps in a square, of which a leaf of photons knows most: hardly any is left to the scatterer's own choices, and the
    /// photons set aside tell how much of the light is.
    #[test]
    fn lamps_that_sent_no_photon_are_met_all_the_same() {
        let lamp = |k: usize| DVec2::new((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0) * 0.08;
        let toward = |k: usize, place: DVec3, [a, b]: [f64; 2]| {
            (lamp(k) + 0.01 * DVec2::new(a - 0.5, b - 0.5) - 0.5 * place.truncate()).extend(1.0).normalize()
        };
        let mut rng = Rng::new(5, Stream::Check, 0, 0);
        let mut drawn = || {
            let ([x, y, which], pair) = (rng.triple(), rng.pair());
            (DVec3::new(x, y, 0.0), ((9.0 * which) as usize).min(8), pair)
        };
        let landings: Vec<Landing> = (0..1000)
            .map(|_| {
                let (place, k, pair) = drawn();
                Landing { lumens: 1.0, ..landing(place, -toward(k, place, pair)) }
            })
            .collect();
        let glow = Glow::new(&landings).unwrap();
        const ASKED: u32 = 20_000;
        let (mut by_none, mut not_by_cones) = (0, 0);
        for _ in 0..ASKED {
            let (place, k, pair) = drawn();
            let (about, dir) = (glow.at(place).unwrap(), toward(k, place, pair));
            let Leaf { cones, cos_half, .. } = about.leaf;
            let met = cones.iter().any(|(tangents, _)| about.axis(*tangents).dot(dir) >= *cos_half);
            not_by_cones += u32::from(!met);
            by_none += u32::from(about.density(dir, 0.0) == 0.0);
        }
        let share = |count: u32| f64::from(count) / f64::from(ASKED);
        println!("{} not by cones, {} by none, {} foretold", share(not_by_cones), share(by_none), glow.missed());
        // By the cones alone a lamp in many a leaf would be left out.
        assert!(share(not_by_cones) > 0.02 && share(by_none) < 0.002, "{not_by_cones} {by_none} of {ASKED}");
        assert!(glow.missed() > share(by_none) && glow.missed() < 0.03, "{}", glow.missed());
    }

    #[test]
    fn places_have_their_own_photons() {
        let glow = Glow::new(&photons(4000)).unwrap();
        for x in [0.1, 0.5, 0.9] {
            let leaf = glow.at(DVec3::new(x, 0.0, 0.0)).unwrap();
            let to = DVec3::new(0.3 * x, 0.0, 1.0).normalize();
            assert!(leaf.density(to, 0.0) > 50.0, "{x}");
            assert_eq!(leaf.density(-to, 2.0), 2.0 * (1.0 - GUIDED));
        }
        assert!(Glow::new(&photons(FEWEST - 1)).is_none());
    }
}
