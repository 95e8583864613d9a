//! Light by way of a scatterer: flux that paths from the lamps leave there is gathered where paths from the eye arrive, so
//! that each pair of ways (lamp to scatterer, scatterer to eye) gets its flux.

use super::eye_paths::End;
use super::lamp_paths::{Source, Way};
use super::part_sequence::Visits;
use super::tuning::scattered::SPLIT_FROM;
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Emission, Origin, Shots, Visitor};
use eyebox_estimate::manifold::receiver::Claim;
use eyebox_estimate::photon::on_side;
use eyebox_estimate::photon_map::{Photon, PhotonMap};
use eyebox_estimate::walk::{Vertex, Walker};
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::geometry::Site;
use eyebox_world::mode::{Mode, components, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};

struct Stored<M: Mode> {
    found: Vec<(Photon<M>, Chain)>,
}

impl<M: Mode> Visitor<M> for Stored<M> {
    fn split_from(&self, _: &Walker<'_, M>) -> Option<f64> {
        Some(SPLIT_FROM)
    }
    fn records(&self) -> bool {
        true
    }
    fn pupil(&mut self, _: &Walker<'_, M>, _: Origin, _: &Arrival) {}
    fn scatterer(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex, _: &Scatter) {
        // A path that is scattered for ever counts for little.
        const MOST: usize = 64;
        if self.found.len() >= MOST {
            return;
        }
        let photon = Photon::new(walker, vertex, from.group, Claim::Free);
        self.found.push((photon, walker.chain().cloned().unwrap_or_default()));
    }
}

/// How light came to a scatterer.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Origins {
    group: GroupId,
    source: Source,
    again: bool,
    before: Visits,
}

/// The flux at scatterers in one pass.
pub struct Deposits<M: Mode> {
    map: PhotonMap<M>,
    origins: Vec<Origins>,
}

impl<M: Mode> Deposits<M> {
    /// Traces one pass from the lamps. `eyes`: points where paths from the eye end, for the size of the neighbourhood that
    /// light is gathered from.
    pub fn new(
        (world, optics): (&World, &Optics<M>),
        (emission, sources): (&Emission, &[Source]),
        shots: Shots,
        eyes: &[(DVec3, Site)],
        stop: &ShouldStop<'_>,
    ) -> Self {
        let visitor = || Stored { found: Vec::new() };
        let stored = emission.survey((world, optics), shots, stop, visitor, |lamp, _, _, stored: Stored<M>| {
            let source = *sources.get(lamp)?;
            let with = |(photon, chain): (Photon<M>, Chain)| {
                let again = photon.trail.has_scatter();
                let before = Source::visits((!again).then_some(source), world, &chain);
                let origins = Origins { group: photon.group, source, again, before };
                (photon, origins)
            };
            Some(stored.found.into_iter().map(with).collect::<Vec<_>>())
        });
        let (mut origins, mut known) = (Vec::new(), HashMap::new());
        let mut photons = Vec::new();
        for (mut photon, from) in stored.into_iter().flatten() {
            let index = *known.entry(from).or_insert_with_key(|from| {
                origins.push(from.clone());
                origins.len() - 1
            });
            // In this map the group of a photon is its place in the list of origins.
            photon.group = GroupId(u32::try_from(index).unwrap_or(u32::MAX));
            photons.push(photon);
        }
        let radius = radius_m(&photons, eyes).unwrap_or(f64::MIN_POSITIVE);
        Deposits { map: PhotonMap::new(photons, radius), origins }
    }

    /// Luminance that a scatterer sends along a path to the eye, by origin.
    pub fn gather(&self, end: &End<'_, '_, M>, each: &mut dyn FnMut(GroupId, Source, Way, f64)) {
        let End { walker, vertex, scatter, frame, chain } = end;
        let d_in = frame.to_local(walker.ray.dir);
        let sides = walker.sides(vertex, scatter);
        let mut sums: BTreeMap<u32, [Light; 3]> = BTreeMap::new();
        self.map.gather(vertex.hit.point, vertex.hit.site, |photon, _, [density, _]| {
            let through = photon.outside != vertex.outside;
            let d_out = on_side(frame.to_local(-photon.dir), through);
            let (index, _) = walker.beyond(vertex, through, 0.0);
            let (values, alone) = sides.eval(scatter, d_in, d_out);
            let factors = lanes::<M, _>(|lane| values[lane] * density / (index[lane] * index[lane]));
            let out = sums.entry(photon.group.0).or_default();
            let flux = (&photon.flux, photon.alone || alone);
            let facets = sides.facets(scatter, (d_in, d_out), &values);
            let beam = walker.beam.gathering(facets.as_ref(), walker.ray.dir, photon);
            beam.join(walker.optics, &mut out[..M::COMPONENTS], flux, &factors);
        });
        for (index, out) in sums {
            let Some(from) = self.origins.get(index as usize) else { continue };
            let at = vertex.hit.site.part;
            let way = Way::Scattered { again: from.again, before: from.before.clone(), at, after: chain.clone() };
            each(from.group, from.source, way, components::<M>().luminance_value(&out[..M::COMPONENTS]));
        }
    }
}

/// The median over places of the distance to the eighth photon on the same face: few paths, a wide neighbourhood.
fn radius_m<M: Mode>(photons: &[Photon<M>], eyes: &[(DVec3, Site)]) -> Option<f64> {
    const NEIGHBOUR: usize = 8;
    let mut distances: Vec<f64> = eyes
        .iter()
        .filter_map(|(point, site)| {
            let same = |photon: &&Photon<M>| photon.site.is_on_face_of(*site);
            let mut squares: Vec<f64> =
                photons.iter().filter(same).map(|photon| photon.position.distance_squared(*point)).collect();
            let k = NEIGHBOUR.min(squares.len()).checked_sub(1)?;
            let (_, nth, _) = squares.select_nth_unstable_by(k, f64::total_cmp);
            Some(nth.sqrt())
        })
        .filter(|distance| *distance > 0.0)
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied()
}
