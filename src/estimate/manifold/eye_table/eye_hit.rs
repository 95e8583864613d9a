//! Where rays from the eye land, at nodes over the picture and the pupil, and what lies between.

pub(super) use super::tuning::eye_hit::OVER_PUPIL;
use super::tuning::eye_hit::QUADS;
use crate::manifold::solver::bicubic::Rows;
use crate::manifold::solver::simd_nodes::{Quad, SimdNodes, filled};
use eyebox_world::mode::{LaneArray, Mode, lanes};
use glam::DVec3;
use std::marker::PhantomData;

/// Where a ray lands.
#[derive(Debug, Clone, Copy)]
pub(super) struct EyeHit<M: Mode> {
    /// Recentred world, m.
    pub(super) point: DVec3,
    pub(super) dir: DVec3,
    /// Of what the ray starts with, per lane.
    pub(super) weight: M::Lanes<f64>,
}

impl<M: Mode> EyeHit<M> {
    /// So many hold its numbers.
    const QUADS: usize = {
        assert!(6 + M::LANES <= 4 * QUADS);
        (6 + M::LANES).div_ceil(4)
    };

    fn numbers(&self) -> impl Iterator<Item = f64> {
        let places = self.point.to_array().into_iter().chain(self.dir.to_array());
        places.chain(self.weight.as_slice().iter().copied())
    }

    fn of(numbers: &[f64]) -> EyeHit<M> {
        let [point, dir] = [0, 3].map(|at| DVec3::from_slice(&numbers[at..at + 3]));
        EyeHit { point, dir, weight: lanes::<M, _>(|lane| numbers[6 + lane]) }
    }
}

/// Per node over the picture one landing for each over the pupil; none where not all rays land.
pub(super) struct EyeHits<M: Mode> {
    known: Vec<bool>,
    /// NaN where they are not known.
    lean: SimdNodes,
    mode: PhantomData<M>,
}

impl<M: Mode> EyeHits<M> {
    pub(super) fn new(nodes: &[Option<Vec<EyeHit<M>>>]) -> Self {
        let quads = EyeHit::<M>::QUADS;
        let mut lean = SimdNodes::new(nodes.len(), quads * OVER_PUPIL, f64::NAN);
        for (landings, numbers) in nodes.iter().zip(lean.nodes_mut()) {
            for (landing, numbers) in landings.iter().flatten().zip(numbers.chunks_exact_mut(4 * quads)) {
                numbers.iter_mut().zip(landing.numbers()).for_each(|(to, from)| *to = from);
            }
        }
        EyeHits { known: nodes.iter().map(Option::is_some).collect(), lean, mode: PhantomData }
    }

    /// Whether all rays of a node land.
    pub(super) fn has(&self, node: usize) -> bool {
        self.known.get(node).is_some_and(|known| *known)
    }

    /// Where the ray through the middle of the pupil lands.
    pub(super) fn middle(&self, node: usize) -> Option<EyeHit<M>> {
        let first = 4 * EyeHit::<M>::QUADS * (OVER_PUPIL / 2);
        let numbers = self.lean.at(node).get(first..).filter(|_| self.has(node))?;
        Some(EyeHit::of(numbers))
    }

    /// Where a ray between the nodes lands; none where some of them are not known. `pupil`: weights of the nodes over it.
    pub(super) fn blend(&self, rows: &Rows, pupil: &[f64; OVER_PUPIL]) -> Option<EyeHit<M>> {
        let quads: [Quad; QUADS] = match EyeHit::<M>::QUADS {
            2 => self.lean.blend_grids::<2, OVER_PUPIL>(rows, pupil).map(filled),
            _ => self.lean.blend_grids(rows, pupil),
        }?;
        let landing = EyeHit::of(quads.as_flattened());
        (!landing.point.x.is_nan()).then_some(landing)
    }
}
