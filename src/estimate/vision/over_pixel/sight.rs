//! The paths by which a pixel's footprint is known.

use super::{Linear, Met, OverPixel, Vision};
use crate::emitter_hit::EmitterHit;
use crate::ledger::Ledger;
use crate::ownership::Ownership;
use crate::pixel::Pixel;
use crate::tuning::over_pixel::{CLOSE, MOST_TRAINS, STARTS, WIDER};
use crate::tuning::vision::SPLIT_FROM;
use crate::walk::Walker;
use arrayvec::ArrayVec;
use eyebox_base::chain::Chain;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::slide::footprint::{MOST, MOST_EDGES};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::ops::{Add, Mul, Sub};

/// One for each corner of a simplex.
type AtCorners<T> = [T; STARTS.len()];

/// A place of a square, from its middle, in sides, and of the pupil, in radii.
type Place = DVec4;

/// A lamp seen along one path.
struct Sight<M: Mode> {
    chain: Chain,
    lamp: usize,
    plane: usize,
    /// Luminance per lane, cd/m², with the slides open; the mean of a lamp with a texture.
    strength: M::Lanes<f64>,
    /// Where in that it was met, columns and rows of texels.
    texel: Option<DVec2>,
    alone: bool,
    slides: ArrayVec<(usize, DVec3), MOST>,
    /// Where the faces of the chain, and the lamp's, were met: (part, face), recentred world.
    faces: Vec<((u32, u32), DVec3)>,
}

impl<M: Mode> Sight<M> {
    fn is_like(&self, other: &Sight<M>) -> bool {
        let slides = |sight: &Sight<M>| sight.slides.iter().map(|(slide, _)| *slide).collect::<ArrayVec<usize, MOST>>();
        let faces = self.faces.iter().map(|(face, _)| face).eq(other.faces.iter().map(|(face, _)| face));
        (self.lamp, self.plane, self.alone) == (other.lamp, other.plane, other.alone)
            && self.chain == other.chain
            && slides(self) == slides(other)
            && faces
    }
}

/// What all corners see in the way of one of them.
fn like<'s, M: Mode>(sight: &Sight<M>, all: &'s AtCorners<Vec<Sight<M>>>) -> Option<AtCorners<&'s Sight<M>>> {
    let [first, a, b, c, d] = all.each_ref().map(|sights| sights.iter().find(|other| other.is_like(sight)));
    Some([first?, a?, b?, c?, d?])
}

/// From values at the corners to what is linear between them.
struct Simplex {
    first: DVec4,
    inverse: DMat4,
}

impl Simplex {
    fn new(corners: AtCorners<Place>) -> Simplex {
        let [first, a, b, c, d] = corners;
        Simplex { first, inverse: DMat4::from_cols(a - first, b - first, c - first, d - first).inverse() }
    }

    fn of<T>(&self, values: AtCorners<T>) -> Linear<T>
    where
        T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
    {
        let [first, a, b, c, d] = values;
        let by = [0, 1, 2, 3].map(|k| {
            let weights = self.inverse.col(k);
            (a - first) * weights.x + (b - first) * weights.y + (c - first) * weights.z + (d - first) * weights.w
        });
        let [x, y, u, v] = by;
        let middle = first - x * self.first.x - y * self.first.y - u * self.first.z - v * self.first.w;
        Linear { middle, by_pixel: [x, y], by_pupil: [u, v] }
    }
}

impl<M: Mode> OverPixel<M> {
    /// By what paths from the corners of a simplex see. None where nothing of it is seen past the edges of faces, or more of them
    /// are near than can be cut.
    fn new(world: &World, at: AtCorners<&Sight<M>>, simplex: &Simplex) -> Option<OverPixel<M>> {
        let [first, ..] = at;
        let strength = lanes::<M, _>(|lane| simplex.of(at.map(|sight| sight.strength[lane])));
        let lanes_of = |of: &dyn Fn(&Linear<f64>) -> f64| lanes::<M, _>(|lane| of(&strength[lane]));
        let brightness = Linear {
            middle: lanes_of(&|own| own.middle),
            by_pixel: [lanes_of(&|own| own.by_pixel[0]), lanes_of(&|own| own.by_pixel[1])],
            by_pupil: [lanes_of(&|own| own.by_pupil[0]), lanes_of(&|own| own.by_pupil[1])],
        };
        let has_texture = at.iter().all(|sight| sight.texel.is_some());
        let texels = has_texture.then(|| (first.lamp, simplex.of(at.map(|sight| sight.texel.unwrap_or_default()))));
        let crossed = |k: usize| (first.slides[k].0, simplex.of(at.map(|sight| sight.slides[k].1)));
        let slides: Box<[_]> = (0..first.slides.len()).map(crossed).collect();
        let mut edges: ArrayVec<Linear<f64>, MOST_EDGES> = ArrayVec::new();
        for (k, ((part, face), _)) in first.faces.iter().enumerate() {
            let Some(outline) = world.rims.outline_to_picture(*part, *face) else { continue };
            let flat = simplex.of(at.map(|sight| outline.flat(sight.faces[k].1)));
            let lengths = |by: [DVec2; 2]| by[0].length() + by[1].length();
            let extent = 0.5 * WIDER * lengths(flat.by_pixel) + lengths(flat.by_pupil);
            let Some((on, inwards)) = outline.nearest(flat.middle, 2.0 * extent) else { continue };
            let edge = Linear {
                middle: (flat.middle - on).dot(inwards),
                by_pixel: flat.by_pixel.map(|by| by.dot(inwards)),
                by_pupil: flat.by_pupil.map(|by| by.dot(inwards)),
            };
            if edge.middle < -extent {
                return None;
            }
            if edge.middle <= extent {
                edges.try_push(edge).ok()?;
            }
        }
        // What does not fit or is not finite could not be cut.
        let fits = slides.iter().all(|(_, place)| place.is_all(DVec3::is_finite))
            && texels.iter().all(|(_, place)| place.is_all(DVec2::is_finite));
        let edges = edges.iter().copied().collect();
        let (plane, alone) = (first.plane, first.alone);
        fits.then_some(OverPixel { plane, alone, brightness, texels, slides, edges, pairs: 1 })
    }
}

/// A square about a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Square {
    /// Its middle from the pixel's, to the right and down, and its side, in pixels.
    pub(super) middle: f64,
    pub(super) side: f64,
}

impl Square {
    pub(super) const PIXEL: Square = Square { middle: 0.0, side: 1.0 };
}

/// The lamps that are seen over a square about a pixel and the pupil.
pub(super) struct Seen<M: Mode> {
    pub(super) over: Vec<OverPixel<M>>,
    /// All corners see the same, and of all that something is seen past edges.
    pub(super) whole: bool,
    /// No corner sees any.
    pub(super) dark: bool,
    /// That were followed.
    pub(super) rays: u64,
}

impl<M: Mode> Vision<'_, M> {
    /// `ending`: with those, too, that end within the square. Adds to the counted work.
    pub(super) fn over_square(
        &self,
        tracing: (&Ownership, &Optics<M>),
        (pixel, square, ending): (Pixel, Square, bool),
        work: &mut u64,
    ) -> Seen<M> {
        let choices = Rng::new(self.seed, Stream::PictureEdges, 0, pixel.index);
        let mut ledger = Ledger::new(self.world.solids.len());
        let mut at = |place: Place| {
            let in_picture = place.truncate().truncate() * square.side + square.middle;
            self.sights(tracing, (pixel, in_picture, DVec2::new(place.z, place.w)), choices.clone(), &mut ledger)
        };
        let corners = STARTS.map(Place::from_array);
        let all = corners.map(&mut at);
        let simplex = Simplex::new(corners);
        let [first, ..] = &all;
        let of_all = first.iter().filter_map(|sight| Some((sight, like(sight, &all)?)));
        let (known, mut over): (Vec<&Sight<M>>, Vec<_>) =
            of_all.map(|(sight, sights)| (sight, OverPixel::new(self.world, sights, &simplex))).unzip();
        let most = all.iter().map(Vec::len).max().unwrap_or(0);
        let (whole, dark) = (over.iter().flatten().count() == most, most == 0);
        let mut closer = 0;
        if ending && !whole {
            // What one corner alone knows of is followed close to it.
            let mut known = known;
            for (corner, sight) in
                corners.iter().zip(&all).flat_map(|(corner, all)| all.iter().map(move |own| (corner, own)))
            {
                if known.len() >= MOST_TRAINS {
                    break;
                }
                if known.iter().any(|other| other.is_like(sight)) {
                    continue;
                }
                closer += 1;
                let corners = corners.map(|other| *corner + CLOSE * other);
                let near = corners.map(&mut at);
                if let Some(sights) = like(sight, &near) {
                    over.push(OverPixel::new(self.world, sights, &Simplex::new(corners)));
                }
                known.push(sight);
            }
        }
        *work += ledger.work;
        let rays = STARTS.len() as u64 * (1 + closer);
        Seen { over: over.into_iter().flatten().collect(), whole, dark, rays }
    }

    /// The lamps, with pictures or behind slides or neither, that a path from a place of a pixel (from its middle) meets.
    fn sights(
        &self,
        (route, optics): (&Ownership, &Optics<M>),
        (pixel, place, pupil): (Pixel, DVec2, DVec2),
        rng: Rng,
        ledger: &mut Ledger,
    ) -> Vec<Sight<M>> {
        let (walker, places) = self.walker(optics, (pixel, (place + 0.5).to_array(), pupil), (1.0, rng));
        let mut walker = walker.recording();
        let mut sights = Vec::new();
        let mut each = |walker: &Walker<'_, M>, seen: &EmitterHit<'_>, plane: usize, met: Option<&Met>| {
            let (Some(chain), Some(met)) = (walker.chain(), met) else { return };
            let mut slides = met.slides.clone();
            // What is left to rays from the eye beside connections is not smooth, nor is what an opacity cuts out.
            let many = met.many
                || seen.lamp.is_patterned()
                || seen.shown().is_some_and(|shown| slides.try_push(shown).is_err());
            if many || route.is_connected(seen.lamp.group) {
                return;
            }
            let (light, alone) = walker.seen(&seen.even());
            let open: f64 = slides.iter().map(|(slide, _)| self.world.slides[*slide].t_white()).product();
            let strength = lanes::<M, _>(|lane| light[lane].open() / open);
            if strength.as_slice().iter().all(|strength| strength.is_finite()) {
                let mut faces = met.faces.clone();
                faces.push(((seen.lamp.part as u32, seen.lamp.face as u32), seen.place()));
                let (chain, lamp, texel) = (chain.clone(), seen.index, seen.in_texture());
                sights.push(Sight { chain, lamp, plane, strength, texel, alone, slides, faces });
            }
        };
        self.follow(route, &mut walker, (places, SPLIT_FROM, Some(Met::default())), ledger, &mut each);
        sights
    }
}
