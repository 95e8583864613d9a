//! How many wavelengths a path carries at once, and whether it carries their polarisation: the types that estimators are
//! generic over. The smallest mode that is exact for a scene is chosen once, at the top.

use super::World;
use super::optics::{Lighting, Optics};
use super::stokes::{Amount, Stokes};
use super::wavelengths;
use eyebox_base::colour;
use eyebox_film::accumulate::{Components, Light};
pub use eyebox_film::plan::Spectral;
use eyebox_scene::PowerDistribution;
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

/// A fixed number of values, one per lane.
pub trait LaneArray<T>: Copy + Debug + Send + Sync + Index<usize, Output = T> + IndexMut<usize> {
    const COUNT: usize;
    fn from_fn(of_lane: impl FnMut(usize) -> T) -> Self;
    fn as_slice(&self) -> &[T];
}

impl<T: Copy + Debug + Send + Sync, const N: usize> LaneArray<T> for [T; N] {
    const COUNT: usize = N;
    #[inline]
    fn from_fn(of_lane: impl FnMut(usize) -> T) -> Self {
        std::array::from_fn(of_lane)
    }
    #[inline]
    fn as_slice(&self) -> &[T] {
        self
    }
}

/// Passes whose optical constants an estimator holds at a time.
pub const OPTICS_AT_A_TIME: u64 = 16;

/// A spectral mode with or without polarisation.
pub trait Mode: Copy + Debug + Send + Sync + 'static {
    type Lanes<T: Copy + Debug + Send + Sync>: LaneArray<T>;
    type Amount: Amount;
    const SPECTRAL: Spectral;
    const LANES: usize;
    /// Values per plane of a film: luminance, or linear Rec.709.
    const COMPONENTS: usize;

    /// The optical constants of a pass, or of a [turn](turns_of) of one.
    fn optics(world: &World, seed: u64, number: u64) -> Optics<Self>;

    /// Adds the light of the lanes to the `COMPONENTS` entries of a plane; `alone`: only the first lane is left.
    fn deposit(optics: &Optics<Self>, out: &mut [Light], lanes: Self::Lanes<Light>, alone: bool);
}

/// What the films of a mode hold.
pub fn components<M: Mode>() -> Components {
    match M::SPECTRAL {
        Spectral::Mono => Components::Luminance,
        Spectral::Rgb | Spectral::Hero => Components::Rec709,
    }
}

/// Whether each pass has wavelengths of its own, so that light goes other ways in each.
pub fn wavelengths_change<M: Mode>() -> bool {
    match M::SPECTRAL {
        Spectral::Mono | Spectral::Rgb => false,
        Spectral::Hero => true,
    }
}

/// How many of its wavelengths lead in turn in a pass, so that they all count where the others part from the one that leads: what a
/// pass sees is then much the same whatever its wavelengths are. 1 where they never part.
pub fn turns<M: Mode>(world: &World) -> u64 {
    match M::SPECTRAL {
        Spectral::Mono | Spectral::Rgb => 1,
        Spectral::Hero => {
            if world.disperses {
                M::LANES as u64
            } else {
                1
            }
        }
    }
}

/// A pass's turns ([`turns`]) with the numbers by which they draw.
pub type Turns<M> = Vec<(u64, Optics<M>)>;

/// These numbers, of a pass that has so many turns.
pub(super) fn numbers(turns: u64, pass: u64) -> impl Iterator<Item = u64> {
    (0..turns).map(move |turn| pass.wrapping_mul(turns).wrapping_add(turn))
}

/// Those of a pass that has so many.
pub fn turns_of<M: Mode>(world: &World, turns: u64, seed: u64, pass: u64) -> Turns<M> {
    numbers(turns, pass).map(|number| (number, M::optics(world, seed, number))).collect()
}

/// The entries of a plane.
#[inline]
pub fn plane_of<M: Mode>(all: &mut [Light], plane: usize) -> &mut [Light] {
    &mut all[plane * M::COMPONENTS..(plane + 1) * M::COMPONENTS]
}

/// Lanes filled one by one.
pub fn lanes<M: Mode, T: Copy + Debug + Send + Sync>(of_lane: impl FnMut(usize) -> T) -> M::Lanes<T> {
    LaneArray::from_fn(of_lane)
}

/// One lane.
#[derive(Debug, Clone, Copy)]
pub struct Mono<A = f64>(PhantomData<A>);
/// A lane per primary.
#[derive(Debug, Clone, Copy)]
pub struct Rgb<A = f64>(PhantomData<A>);
/// Four wavelengths, the first of which decides where dispersion sends the path (Wilkie et al., "Hero wavelength spectral
/// sampling", EGSR 2014).
#[derive(Debug, Clone, Copy)]
pub struct Hero<A = f64>(PhantomData<A>);

/// Mono with Stokes vectors, for tests and benches.
pub type MonoStokes = Mono<Stokes>;

impl<A: Amount> Mode for Mono<A> {
    type Lanes<T: Copy + Debug + Send + Sync> = [T; 1];
    type Amount = A;
    const SPECTRAL: Spectral = Spectral::Mono;
    const LANES: usize = 1;
    const COMPONENTS: usize = 1;

    fn optics(world: &World, _: u64, _: u64) -> Optics<Self> {
        let one = |count| vec![[1.0]; count];
        Optics::new(
            world,
            Lighting {
                nm: [world.wavelength_nm],
                response: [[1.0; 3]],
                lamps: one(world.lamps.all().len()),
                lights: one(world.lights.all().len()),
                sky: [[1.0]; 3],
                slide: [[1.0]; 3],
                reflectance: [colour::basis(world.wavelength_nm)],
            },
        )
    }

    #[inline]
    fn deposit(_: &Optics<Self>, out: &mut [Light], [light]: [Light; 1], _: bool) {
        out[0].add(light);
    }
}

impl<A: Amount> Mode for Rgb<A> {
    type Lanes<T: Copy + Debug + Send + Sync> = [T; 3];
    type Amount = A;
    const SPECTRAL: Spectral = Spectral::Rgb;
    const LANES: usize = 3;
    const COMPONENTS: usize = 3;

    fn optics(world: &World, _: u64, _: u64) -> Optics<Self> {
        const PRIMARIES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let colours = |lamps: &[PowerDistribution]| lamps.iter().map(PowerDistribution::rec709_per_lumen).collect();
        Optics::new(
            world,
            Lighting {
                nm: [world.wavelength_nm; 3],
                response: PRIMARIES,
                lamps: colours(&world.tints.lamps),
                lights: colours(&world.tints.lights),
                sky: PRIMARIES,
                slide: PRIMARIES,
                reflectance: PRIMARIES,
            },
        )
    }

    #[inline]
    fn deposit(_: &Optics<Self>, out: &mut [Light], lanes: [Light; 3], _: bool) {
        // Nothing disperses in this mode, so no lane is ever alone.
        out.iter_mut().zip(lanes).for_each(|(sum, light)| sum.add(light));
    }
}

impl<A: Amount> Mode for Hero<A> {
    type Lanes<T: Copy + Debug + Send + Sync> = [T; 4];
    type Amount = A;
    const SPECTRAL: Spectral = Spectral::Hero;
    const LANES: usize = 4;
    const COMPONENTS: usize = 3;

    fn optics(world: &World, seed: u64, number: u64) -> Optics<Self> {
        Optics::new(world, wavelengths::lighting(world, seed, number))
    }

    fn deposit(optics: &Optics<Self>, out: &mut [Light], lanes: [Light; 4], alone: bool) {
        let (count, share) = if alone { (1, 4.0) } else { (4, 1.0) };
        for (light, response) in lanes.into_iter().zip(optics.response()).take(count) {
            for (sum, weight) in out.iter_mut().zip(response) {
                sum.add(light.scaled(weight * share));
            }
        }
    }
}
