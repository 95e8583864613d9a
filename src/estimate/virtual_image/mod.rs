//! Lines of sight: in which direction an eye anywhere sees a point of a face behind specular faces, by exact rays, and what
//! such directions say of the virtual image.

pub mod aim;
mod extent;
pub mod ghosts;
pub mod image;
mod look;
mod outline;
mod same_image;
pub mod subject;
mod tuning;
mod ways;

use crate::walk::{Travel, Walker};
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;
use glam::DVec3;

/// A ray from the eye on its way: nothing is left to chance where its chain is known.
fn sent<'w, M: Mode>((world, optics): (&'w World, &'w Optics<M>), origin: DVec3, dir: DVec3) -> Walker<'w, M> {
    let ray = Ray { origin, dir, from: None };
    let rng = Rng::new(0, Stream::Check, 2, 0);
    Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng)
}
