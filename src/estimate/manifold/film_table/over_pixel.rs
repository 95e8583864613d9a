//! What a table says of all of a pixel, for one point of the lamp: linear in the place within the pixel, so that its mean over
//! the pixel is known exactly, the slides' pictures with it. What is not linear, the solved connections make good.

use super::{Node, SLIDES, Spot};
use crate::base::lpe::LpeState;
use crate::base::path::Trail;
use crate::film::accumulate::Light;
use crate::world::World;
use crate::world::mode::{Mode, lanes};
use crate::world::optics::Optics;
use crate::world::slide::footprint::{Brightness, Footprint};
use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};

/// A branch over a pixel; places within it are from its middle, in pixels to the right and down.
pub(in crate::estimate::manifold) struct OverPixel<M: Mode> {
    /// Place in the pupil of the light that comes to the middle, m; and how far from there others of the pixel may lie.
    pub(in crate::estimate::manifold) pupil: DVec2,
    pub(super) pupil_reach: f64,
    /// cd/m², with the slides open.
    pub(in crate::estimate::manifold) brightness: Brightness<M>,
    pub(in crate::estimate::manifold) footprints: ArrayVec<Footprint, SLIDES>,
    pub(in crate::estimate::manifold) alone: bool,
    pub(in crate::estimate::manifold) trail: Trail,
    pub(in crate::estimate::manifold) told: LpeState,
}

impl<M: Mode> OverPixel<M> {
    /// None where a node is missing or they do not cross the same slides. `cells`: from one pixel to the next.
    pub(super) fn read(nodes: &[Option<Node<M>>], spot: &Spot, cells: DVec2, off: DVec2) -> Option<OverPixel<M>> {
        let near = nodes[spot.cell].as_ref()?;
        let (mut pupil, mut pupil_by) = (DVec2::ZERO, [DVec2::ZERO; 2]);
        let none = lanes::<M, _>(|_| 0.0);
        let mut brightness = Brightness::<M> { middle: none, by: [none; 2] };
        let flat = |slide| Footprint { slide, at: DVec3::ZERO, by: [DVec3::ZERO; 2] };
        let mut footprints: ArrayVec<Footprint, SLIDES> = near.slides.iter().map(|at| flat(at.slide)).collect();
        for (node, weight, slope) in spot.nodes_with_slopes() {
            let node = nodes[node].as_ref()?;
            if node.slides.len() != near.slides.len() || (node.alone, node.trail) != (near.alone, near.trail) {
                return None;
            }
            let by = slope * cells;
            let place = node.pupil + node.pupil_by * off;
            pupil += weight * place;
            pupil_by[0] += by.x * place;
            pupil_by[1] += by.y * place;
            for lane in 0..M::LANES {
                let [by_x, by_y] = node.strength_by.map(|by| by[lane]);
                let strength = node.strength[lane] + by_x * off.x + by_y * off.y;
                brightness.middle[lane] += weight * strength;
                brightness.by[0][lane] += by.x * strength;
                brightness.by[1][lane] += by.y * strength;
            }
            for (footprint, crossing) in footprints.iter_mut().zip(&node.slides) {
                let at = crossing.local + crossing.by_lamp[0] * off.x + crossing.by_lamp[1] * off.y;
                footprint.at += weight * at;
                footprint.by[0] += by.x * at;
                footprint.by[1] += by.y * at;
            }
        }
        let pupil_reach = 0.5 * (pupil_by[0].length() + pupil_by[1].length());
        let (alone, trail, told) = (near.alone, near.trail, near.told);
        Some(OverPixel { pupil, pupil_reach, brightness, footprints, alone, trail, told })
    }

    /// What comes to a place within the pixel; none beside a slide's picture.
    pub(in crate::estimate::manifold) fn at(
        &self,
        (world, optics): (&World, &Optics<M>),
        within: DVec2,
    ) -> Option<M::Lanes<Light>> {
        let strength = self.brightness.at(within);
        let mut light = lanes::<M, _>(|lane| Light::ONE.scaled(strength[lane]));
        for footprint in &self.footprints {
            let map = &world.slides[footprint.slide];
            let s = optics.slide(map, footprint.place(within))?;
            for lane in 0..M::LANES {
                light[lane].cross(map.t_white(), map.transmittance(s[lane]), s[lane]);
            }
        }
        Some(light)
    }
}
