//! Rays from the pupil's middle over the field of view, and what they and their ways on meet that may be a picture.

use super::subject::Kind;
use super::tuning::subject::LOOKS;
use super::ways::{Effort, follow};
use eyebox_base::chain::Chain;
use eyebox_base::parallel;
use eyebox_film::specular_chain::SpecularChain;
use eyebox_world::World;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Light from the eye that met a face.
pub(super) struct Landed {
    /// Tangents.
    pub film: DVec2,
    pub place: DVec3,
    pub normal: DVec3,
    pub dir: DVec3,
    pub carried: f64,
    pub train: SpecularChain,
}

/// What rays met, by kind, part, face and chain.
pub(super) type Found = BTreeMap<Key, Vec<Landed>>;

/// Kind of the picture, part, face, and the chain that leads there.
pub(super) type Key = (Kind, u32, u32, Chain);

/// A look over a part of the field of view.
pub(super) struct Look {
    pub found: Found,
    /// The largest share of a ray's light whose ways were not followed to their end.
    pub left_out: f64,
    /// From one ray to the next, tangents.
    pub cell: DVec2,
}

/// Sends rays from the pupil's middle through the middles of cells between two corners of the field of view (tangents).
/// `wanted`: the part that is looked for, or any; `effort`: how far ways on are followed.
pub(super) fn look_around(
    tracing: (&World, &Optics<Mono>),
    [low, high]: [DVec2; 2],
    (wanted, effort): (Option<u32>, Effort),
) -> Look {
    let world = tracing.0;
    let ray = |look: usize| {
        let share = |i: usize| (i as f64 + 0.5) / LOOKS as f64;
        let film = low + (high - low) * DVec2::new(share(look % LOOKS), share(look / LOOKS));
        let (origin, (_, dir), ..) = world.eye.ray_of(film, DVec2::ZERO);
        let mut landed: Vec<(Key, Landed)> = Vec::new();
        let left_out = follow(tracing, (origin, dir), effort, |kind, vertex, walker, train| {
            let site = vertex.hit.site;
            if wanted.is_none_or(|part| part == site.part) {
                let place = vertex.hit.point + world.geometry.origin();
                let (normal, carried, train) = (vertex.hit.normal, walker.beam.weight(), train.clone());
                let key = (kind, site.part, site.face, train.chain());
                landed.push((key, Landed { film, place, normal, dir, carried, train }));
            }
        });
        (landed, left_out)
    };
    let rays: Vec<_> = parallel::map(LOOKS * LOOKS, &ray);
    let (mut found, mut most) = (Found::new(), 0f64);
    for (landed, left_out) in rays {
        most = most.max(left_out);
        for (key, hit) in landed {
            found.entry(key).or_default().push(hit);
        }
    }
    Look { found, left_out: most, cell: (high - low) / LOOKS as f64 }
}
