//! The wavelengths that a pass's paths share, what light and the eye are at them, and what that makes of light in all pixels alike.

use super::World;
use super::mode::{self, Hero, Mode};
use super::optics::Lighting;
use super::stokes::Amount;
use eyebox_base::colour::{self, COUNT, FIRST_NM, Grid, Lane};
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::control_variates::Known;
use eyebox_scene::PowerDistribution;

const LANES: usize = <Hero as Mode>::LANES;
/// Wavelengths by which the mean over all is found.
const EVENLY: usize = 1 << 12;

/// Where in the distribution of wavelengths the first lane of a number lies, from 0 to 1: numbers in the order of van der Corput's
/// sequence, so that the heroes of 2ᵏ of them are spread evenly.
fn place(world: &World, seed: u64, number: u64) -> f64 {
    let shift = Rng::new(seed, Stream::Wavelengths, 0, 0).uniform();
    // Those of four numbers one after the other have the same four wavelengths, each with another in front.
    let number = if world.disperses { number } else { number.wrapping_mul(LANES as u64) };
    let corput = (number.reverse_bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
    (shift + corput).fract()
}

fn primary(c: usize) -> [f64; 3] {
    let mut rgb = [0.0; 3];
    rgb[c] = 1.0;
    rgb
}

/// XYZ per watt per nm of a lane, for the mean of all.
fn matching(nm: f64) -> [f64; 3] {
    colour::cmf_for_sampling(nm).map(|x| colour::K_M * x / LANES as f64)
}

/// Of a number.
pub(super) fn lighting<A: Amount>(world: &World, seed: u64, number: u64) -> Lighting<Hero<A>> {
    let waves = colour::lanes::<LANES>(place(world, seed, number));
    // A source's watts per nm and lumen over the density of the wavelength; the eye's lumens per watt for the mean
    // of the four.
    let watts = |lamps: &[PowerDistribution]| {
        lamps.iter().map(|power| waves.map(|Lane { nm, pdf }| power.at(nm) / pdf)).collect()
    };
    Lighting {
        nm: waves.map(|lane| lane.nm),
        response: waves.map(|lane| colour::apply(&colour::XYZ_TO_REC709, matching(lane.nm))),
        lamps: watts(&world.tints.lamps),
        lights: watts(&world.tints.lights),
        sky: [0, 1, 2].map(|c| waves.map(|Lane { nm, pdf }| colour::uplift_emission(primary(c), nm) / pdf)),
        slide: [0, 1, 2].map(|c| waves.map(|lane| colour::uplift_reflectance(primary(c), lane.nm))),
        reflectance: waves.map(|lane| colour::basis(lane.nm)),
    }
}

/// What passes make of the mean light of all sources through a red, a green and a blue film: [`Known`].
pub struct SharedLight<'w> {
    world: &'w World,
    /// W/nm per lumen.
    mean_source: Box<Grid>,
    /// Over all wavelengths.
    mean: Known,
}

impl<'w> SharedLight<'w> {
    /// None where passes share no wavelengths of their own, or there is no light.
    pub fn new<M: Mode>(world: &'w World) -> Option<SharedLight<'w>> {
        if !mode::wavelengths_change::<M>() {
            return None;
        }
        let sources = world.tints.lamps.iter().chain(&world.tints.lights);
        let mut mean_source: Box<Grid> = Box::new([0.0; COUNT]);
        for source in sources {
            mean_source.iter_mut().zip(source.values()).for_each(|(sum, own)| *sum += own);
        }
        if world.sky.is_some() {
            let white = |at: usize| colour::uplift_emission([1.0; 3], (FIRST_NM + at) as f64);
            mean_source.iter_mut().enumerate().for_each(|(at, sum)| *sum += white(at));
        }
        let mut shared = SharedLight { world, mean_source, mean: [0.0; 3] };
        let mut mean = [0.0; 3];
        for k in 0..EVENLY {
            let own = shared.at((k as f64 + 0.5) / EVENLY as f64);
            mean.iter_mut().zip(own).for_each(|(sum, own)| *sum += own / EVENLY as f64);
        }
        let white: f64 = mean.iter().sum();
        shared.mean_source.iter_mut().for_each(|own| *own /= white);
        shared.mean = mean.map(|own| own / white);
        (white > 0.0 && white.is_finite()).then_some(shared)
    }

    /// With the first lane there in the distribution of wavelengths: its luminance alone where paths may part.
    fn at(&self, place: f64) -> Known {
        let (lanes, times) = if self.world.disperses { (1, LANES as f64) } else { (LANES, 1.0) };
        let mut sum = [0.0; 3];
        for Lane { nm, pdf } in colour::lanes::<LANES>(place).into_iter().take(lanes) {
            let light = times * matching(nm)[1] * colour::lookup(&self.mean_source, nm) / pdf;
            let shares = [0, 1, 2].map(|c| colour::uplift_reflectance(primary(c), nm));
            sum.iter_mut().zip(shares).for_each(|(sum, share)| *sum += light * share);
        }
        sum
    }

    /// Of a pass with so many turns ([`turns`](super::mode::turns)).
    pub fn of_pass(&self, turns: u64, seed: u64, pass: u64) -> Known {
        let mut off = self.mean.map(|own| -own);
        for number in mode::numbers(turns, pass) {
            let own = self.at(place(self.world, seed, number));
            off.iter_mut().zip(own).for_each(|(sum, own)| *sum += own / turns as f64);
        }
        off
    }
}
