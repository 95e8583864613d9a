//! Where the picture shows lamps, straight or over specular faces. Their outlines and their places are known, so they are looked
//! for before the first pass: paths from the eye that know nothing find a lamp of a tenth of a pixel once in many passes, or
//! never. What is found is followed by rays until these are all about the image (`glint_pilot/fit.rs`). It chooses where paths
//! start and no more: each counts by the density of all ways to choose it.

mod faces;
mod fit;
mod straight;

use super::tuning::glint_pilot::MOST_GLINTS;
use crate::pilots::chains::SEED;
use eyebox_base::chain::Chain;
use eyebox_estimate::ShouldStop;
use eyebox_film::glint::Glint;
use eyebox_film::unseen::Hidden;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};

/// A chain from the eye and a lamp.
pub type Way = (Chain, usize);

/// Whether a lamp is to be looked for.
pub type Wants<'w> = dyn Fn(usize) -> bool + Sync + 'w;

/// What is looked for.
#[derive(Clone, Copy)]
pub struct Search<'s> {
    /// Lamps of which all images are.
    pub wants: &'s Wants<'s>,
    /// Ways over which images are taken that rays meet, though they are not looked for: connection has most of what is seen of the
    /// lamp, or other pilots found no way to it.
    pub takes: &'s (dyn Fn(&Way) -> bool + Sync),
    /// Lamps may be seen over specular faces.
    pub over_faces: bool,
}

/// Small images of lamps, those over the shortest chains first, and what may be seen of lamps that something hides. Once `stop` says
/// true the rest is left out.
pub(crate) fn find(
    (world, scene): (&World, &Scene),
    search: Search<'_>,
    stop: &ShouldStop<'_>,
) -> (Vec<Glint>, Option<Hidden>) {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let straight = |lamp: usize| (search.wants)(lamp) || (search.takes)(&(Chain::default(), lamp));
    let (mut all, hidden) = straight::find((world, &optics), &straight, stop);
    if search.over_faces {
        all.extend(faces::find_by_way((world, scene), search, [0; 2], stop));
    }
    all.sort_by_key(|((chain, _), _)| chain.0.len());
    let mut found = Vec::new();
    for (_, glints) in all {
        if found.len() + glints.len() <= MOST_GLINTS {
            found.extend(glints);
        }
    }
    (found, hidden)
}

#[cfg(any(test, feature = "testing"))]
pub use faces::find_by_way;
