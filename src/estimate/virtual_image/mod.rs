//! Lines of sight: in which direction an eye anywhere sees a point of a face behind specular faces, by exact rays, and what
//! such directions say of the virtual image.

pub mod aim;
pub mod ghosts;
pub mod image;
mod look;
pub mod subject;
mod tuning;

use crate::base::rng::{Rng, Stream};
use crate::estimate::walk::{Travel, Walker};
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::Mode;
use crate::world::optics::Optics;
use glam::DVec3;

/// A ray from the eye on its way: nothing is left to chance where its chain is known.
fn sent<'w, M: Mode>((world, optics): (&'w World, &'w Optics<M>), origin: DVec3, dir: DVec3) -> Walker<'w, M> {
    let ray = Ray { origin, dir, from: None };
    let rng = Rng::new(0, Stream::Check, 2, 0);
    Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng)
}
