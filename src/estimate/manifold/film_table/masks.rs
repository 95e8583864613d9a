//! Where the picture ends at the outline of a face of the train: a lens's rim, the edge of a mirror. Tables know where the face
//! is met, beyond its outline by what they know inside, so the outline cuts a pixel's footprint as the pixels of a slide do.

pub(super) use super::tuning::masks::MASKS;
use super::tuning::masks::NEAR;
use super::{Node, Spot};
use arrayvec::ArrayVec;
use eyebox_film::specular_chain::SpecularChain;
use eyebox_world::World;
use eyebox_world::mode::Mode;
use eyebox_world::outline::Outline;
use eyebox_world::slide::footprint::Edge;
use glam::{DVec2, DVec3};

/// A face whose outline ends the picture, as (part, face).
pub(super) type Mask = (u32, u32);

/// Which faces of a train (by their number in it) the missing nodes lie beyond, by what their neighbours foretell. `places`:
/// where nodes meet each face of the train; `lines`: of nodes beside a missing one.
pub(super) fn of_train(
    world: &World,
    train: &SpecularChain,
    places: &[Option<Vec<DVec3>>],
    lines: impl Fn(usize) -> [Option<[usize; 4]>; 4],
) -> ArrayVec<usize, MASKS> {
    let mut votes = vec![0u32; train.0.len()];
    for missing in (0..places.len()).filter(|node| places[*node].is_none()) {
        for line in lines(missing).into_iter().flatten() {
            let [Some(a), Some(b), Some(c), Some(d)] = line.map(|node| places[node].as_ref()) else { continue };
            for (k, (lens, vote)) in train.0.iter().zip(&mut votes).enumerate() {
                let Some(outline) = world.rims.outline(lens.link.part, lens.link.face) else { continue };
                let (Some(a), Some(b), Some(c), Some(d)) = (a.get(k), b.get(k), c.get(k), d.get(k)) else { continue };
                let beyond = 4.0 * *a - 6.0 * *b + 4.0 * *c - *d;
                *vote += u32::from(outline.inside(beyond, outline.size_m()).is_some_and(|inside| inside < 0.0));
            }
        }
    }
    let mut voted: Vec<usize> = (0..votes.len()).filter(|k| votes[*k] > 0).collect();
    voted.sort_by_key(|k| std::cmp::Reverse(votes[*k]));
    voted.into_iter().take(MASKS).collect()
}

/// How far inside of all outlines places lie, m, and none where one is beyond `reach` of them: then it is far.
pub(super) fn inside(world: &World, masks: &[Mask], places: &[DVec3], reach: f64) -> Option<f64> {
    let of_mask = |((part, face), place): (&Mask, &DVec3)| {
        let outline = world.rims.outline(*part, *face)?;
        outline.inside(*place, if reach > 0.0 { reach } else { outline.size_m() })
    };
    masks.iter().zip(places).filter_map(of_mask).min_by(f64::total_cmp)
}

/// An edge across a pixel, and how it moves with the place on the lamp, per metre.
#[derive(Debug, Clone, Copy)]
pub(super) struct MovingEdge {
    edge: Edge,
    by_lamp: DVec2,
}

impl MovingEdge {
    pub(super) fn at(&self, off: DVec2) -> Edge {
        Edge { first: self.edge.first + self.by_lamp.dot(off), ..self.edge }
    }
}

/// What outlines hide of a pixel from the points of a lamp.
pub(super) enum Hidden {
    All,
    /// What lies beyond these edges; nothing without any.
    Beyond(ArrayVec<MovingEdge, MASKS>),
}

/// How the outlines of masks cut a pixel whose middle is at a spot. None where the nodes do not know.
pub(super) fn cut<M: Mode>(
    world: &World,
    nodes: &[Option<Node<M>>],
    (masks, reach): (&[Mask], &[f64; MASKS]),
    (spot, cells): (&Spot, DVec2),
    lamp_size: f64,
) -> Option<Hidden> {
    let mut edges = ArrayVec::new();
    for (k, (part, face)) in masks.iter().enumerate().filter(|(k, _)| reach[*k] > 0.0) {
        let outline: &Outline = world.rims.outline(*part, *face)?;
        let (mut middle, mut by_pixel, mut by_lamp) = (DVec3::ZERO, [DVec3::ZERO; 2], [DVec3::ZERO; 2]);
        for (node, weight, slope) in spot.nodes_with_slopes() {
            let at = nodes[node].as_ref()?.masks.get(k)?;
            let slope = slope * cells;
            middle += weight * at.local;
            by_pixel[0] += slope.x * at.local;
            by_pixel[1] += slope.y * at.local;
            by_lamp[0] += weight * at.by_lamp[0];
            by_lamp[1] += weight * at.by_lamp[1];
        }
        let middle = outline.flat(middle);
        let [right, down, by_x, by_y] = [by_pixel[0], by_pixel[1], by_lamp[0], by_lamp[1]].map(|by| outline.flat(by));
        let extent = 0.5 * (right.length() + down.length());
        let blur = lamp_size * (by_x.length() + by_y.length());
        let Some((at, inwards)) = outline.nearest(middle, reach[k] + extent + blur) else { continue };
        let along = |x: DVec2, y: DVec2| DVec2::new(x.dot(inwards), y.dot(inwards));
        let edge = Edge { first: (middle - at).dot(inwards), by: along(right, down) };
        let margin = (1.0 + NEAR) * extent + blur;
        if edge.first < -margin {
            return Some(Hidden::All);
        }
        if edge.first <= margin {
            edges.push(MovingEdge { edge, by_lamp: along(by_x, by_y) });
        }
    }
    Some(Hidden::Beyond(edges))
}
