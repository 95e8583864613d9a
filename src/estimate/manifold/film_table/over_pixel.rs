//! What a table says of all of a pixel, for one point of the lamp: linear in the place within the pixel, so that its mean over
//! the pixel is known exactly, the slides' pictures with it. What is not linear, the solved connections make good.

use super::masks::{MASKS, MovingEdge};
use super::{Node, SLIDES, Spot};
use arrayvec::ArrayVec;
use eyebox_base::lpe::LpeState;
use eyebox_base::path::Trail;
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::slide::footprint::{self, Brightness, Edge, Footprint};
use glam::{DMat2, DVec2, DVec3};

/// A branch over a pixel; places within it are from its middle, in pixels to the right and down.
pub(in crate::manifold) struct OverPixel<M: Mode> {
    /// Place in the pupil of the light that comes to the middle, m.
    pub(in crate::manifold) pupil: DVec2,
    /// From one pixel to the next.
    pupil_by: [DVec2; 2],
    /// cd/m², with the slides open.
    pub(in crate::manifold) brightness: Brightness<M>,
    pub(in crate::manifold) footprints: ArrayVec<Footprint, SLIDES>,
    /// What of the pixel sees the lamp past the outlines of the train's faces.
    pub(in crate::manifold) edges: ArrayVec<Edge, MASKS>,
    pub(in crate::manifold) alone: bool,
    pub(in crate::manifold) trail: Trail,
    pub(in crate::manifold) told: LpeState,
}

/// Where light that comes to a pixel crosses the pupil, m, and how that moves.
pub(super) struct Crossed {
    middle: DVec2,
    by_lamp: DMat2,
    by_pixel: [DVec2; 2],
}

impl Crossed {
    /// None where a node is missing. `cells`: from one pixel to the next.
    pub(super) fn read<M: Mode>(nodes: &[Option<Node<M>>], spot: &Spot, cells: DVec2) -> Option<Crossed> {
        let (mut middle, mut by_lamp, mut by_pixel) = (DVec2::ZERO, DMat2::ZERO, [DVec2::ZERO; 2]);
        for (node, weight, slope) in spot.nodes_with_slopes() {
            let node = nodes[node].as_ref()?;
            let by = slope * cells;
            middle += weight * node.pupil;
            by_lamp += weight * node.pupil_by;
            by_pixel[0] += by.x * node.pupil;
            by_pixel[1] += by.y * node.pupil;
        }
        Some(Crossed { middle, by_lamp, by_pixel })
    }

    /// For the middle of the lamp.
    pub(super) fn middle(&self) -> DVec2 {
        self.middle
    }

    /// For a point of the lamp.
    pub(super) fn at(&self, off: DVec2) -> DVec2 {
        self.middle + self.by_lamp * off
    }

    /// How far from there that of other places of the pixel may lie.
    pub(super) fn reach(&self) -> f64 {
        0.5 * (self.by_pixel[0].length() + self.by_pixel[1].length())
    }

    /// How far from the middle that of any point of the lamp may lie.
    pub(super) fn spread(&self, size_m: f64) -> f64 {
        size_m * (self.by_lamp.x_axis.length() + self.by_lamp.y_axis.length())
    }
}

impl<M: Mode> OverPixel<M> {
    /// None where a node is missing or they do not cross the same slides. `cells`: from one pixel to the next.
    pub(super) fn read(
        nodes: &[Option<Node<M>>],
        crossed: &Crossed,
        (spot, cells): (&Spot, DVec2),
        off: DVec2,
    ) -> Option<OverPixel<M>> {
        let near = nodes[spot.cell].as_ref()?;
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
            for lane in 0..M::LANES {
                let [by_x, by_y] = node.strength_by.map(|by| by[lane]);
                let strength = node.strength[lane] + by_x * off.x + by_y * off.y;
                brightness.middle[lane] += weight * strength;
                brightness.by[0][lane] += by.x * strength;
                brightness.by[1][lane] += by.y * strength;
            }
            for (footprint, crossing) in footprints.iter_mut().zip(&node.slides) {
                let at = crossing.at(off);
                footprint.at += weight * at;
                footprint.by[0] += by.x * at;
                footprint.by[1] += by.y * at;
            }
        }
        let pupil = crossed.at(off);
        let (alone, trail, told) = (near.alone, near.trail, near.told);
        let pupil_by = crossed.by_pixel;
        Some(OverPixel { pupil, pupil_by, brightness, footprints, edges: ArrayVec::new(), alone, trail, told })
    }

    /// How far inside of the pupil's rim light from places of the pixel crosses it, m; none where it comes through the middle.
    pub(in crate::manifold) fn to_rim_of_pupil(&self, radius_m: f64) -> Option<Edge> {
        let outwards = self.pupil.try_normalize()?;
        let by = -DVec2::from_array(self.pupil_by.map(|by| by.dot(outwards)));
        Some(Edge { first: radius_m - self.pupil.length(), by })
    }

    /// What comes to a place within the pixel; none beside a slide's picture.
    pub(in crate::manifold) fn at(
        &self,
        (world, optics): (&World, &Optics<M>),
        within: DVec2,
    ) -> Option<M::Lanes<Light>> {
        footprint::at((world, optics), &self.brightness, (&self.edges, &self.footprints), within)
    }
}

/// A branch over a pixel for every point of the lamp, in which all of it is linear.
pub(in crate::manifold) struct OverLamp<M: Mode> {
    middle: OverPixel<M>,
    /// One size of the lamp aside along both axes.
    aside: [OverPixel<M>; 2],
    edges: ArrayVec<MovingEdge, MASKS>,
    size_m: f64,
}

impl<M: Mode> OverLamp<M> {
    /// `at`: a branch for a point of the lamp that is so far from its middle, m.
    pub(super) fn read(
        at: impl Fn(DVec2) -> Option<OverPixel<M>>,
        edges: ArrayVec<MovingEdge, MASKS>,
        size_m: f64,
    ) -> Option<OverLamp<M>> {
        let aside = [at(DVec2::X * size_m)?, at(DVec2::Y * size_m)?];
        Some(OverLamp { middle: at(DVec2::ZERO)?, aside, edges, size_m })
    }

    /// Whether outlines let any of the pixel see the lamp's point.
    pub(in crate::manifold) fn is_seen(&self, off: DVec2) -> bool {
        self.edges
            .iter()
            .map(|edge| edge.at(off))
            .all(|edge| edge.first + 0.5 * (edge.by.x.abs() + edge.by.y.abs()) >= 0.0)
    }

    pub(in crate::manifold) fn at(&self, off: DVec2) -> OverPixel<M> {
        let (OverLamp { middle, aside: [a, b], edges, size_m }, [x, y]) = (self, (off / self.size_m).to_array());
        let number = |of: &dyn Fn(&OverPixel<M>) -> f64| (1.0 - x - y) * of(middle) + x * of(a) + y * of(b);
        let three = |of: &dyn Fn(&OverPixel<M>) -> DVec3| (1.0 - x - y) * of(middle) + x * of(a) + y * of(b);
        debug_assert!(*size_m > 0.0);
        let brightness = Brightness {
            middle: lanes::<M, _>(|lane| number(&|over| over.brightness.middle[lane])),
            by: [0, 1].map(|axis| lanes::<M, _>(|lane| number(&|over| over.brightness.by[axis][lane]))),
        };
        let footprint = |k: usize| Footprint {
            slide: middle.footprints[k].slide,
            at: three(&|over| over.footprints[k].at),
            by: [0, 1].map(|axis| three(&|over| over.footprints[k].by[axis])),
        };
        OverPixel {
            pupil: (1.0 - x - y) * middle.pupil + x * a.pupil + y * b.pupil,
            pupil_by: middle.pupil_by,
            brightness,
            footprints: (0..middle.footprints.len()).map(footprint).collect(),
            edges: edges.iter().map(|edge| edge.at(off)).collect(),
            alone: middle.alone,
            trail: middle.trail,
            told: middle.told,
        }
    }
}
