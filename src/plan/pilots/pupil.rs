//! A pilot that finds where in the pupil the light of each group arrives: the sharpness that diffraction allows.

use super::tuning::pupil::{OWN, PATHS, SPLIT_FROM};
use super::{forward, pupil_guide::lit};
use crate::selection::facts::{auto, skip};
use crate::{Asked, Choice, Guides};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::rng::Stream;
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Emission, Origin, Shots, Starts, Visitor};
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::walk::{Vertex, Walker};
use eyebox_film::guide::{ApertureGuide, Guide};
use eyebox_film::plan::{Estimator, Plan, Verdict};
use eyebox_film::pupil::{Aperture, Crossing, Pupil};
use eyebox_film::sharpness::GroupPupil;
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::scatter::Scatter;
use std::collections::BTreeMap;

/// Pilots have a seed of their own: what they find is a function of the scene alone.
const SEED: u64 = 0x9d1f;

/// Crossings of the pupil by the light of one path.
struct Arrivals<'r> {
    route: &'r Ownership,
    group: Option<GroupId>,
    crossings: Vec<Crossing>,
}

impl Visitor<Mono> for Arrivals<'_> {
    fn split_from(&self, _: &Walker<'_, Mono>) -> Option<f64> {
        Some(SPLIT_FROM)
    }

    fn pupil(&mut self, walker: &Walker<'_, Mono>, from: Origin, arrival: &Arrival) {
        let class = walker.trail.class_from_lamp();
        if !from.visible || class != Class::Vision || self.route.from_lamp(from.group, walker.trail).is_none() {
            return;
        }
        let light = walker.beam.carried() * arrival.luminance_per_lumen;
        if let Some(pixel) = arrival.pixel
            && light > 0.0
            && light.is_finite()
        {
            let [width, height] = walker.world.eye.size();
            let field = [(pixel % width) as f64 / width as f64, (pixel / width) as f64 / height as f64];
            let at = walker.world.eye.on_pupil(walker.ray.origin + walker.ray.dir * arrival.t);
            self.group = Some(from.group);
            let open = walker.beam.weight() * arrival.luminance_per_lumen;
            self.crossings.push(Crossing { at, field, light, open });
        }
    }

    fn scatterer(&mut self, _: &Walker<'_, Mono>, _: Origin, _: &Vertex, _: &Scatter) {}
}

/// What was found of the pupil.
pub struct Surveyed {
    /// What each light group has of it.
    pub pupils: Vec<GroupPupil>,
    /// Through which part of it each part of the picture sees lamps; none where that is not known.
    pub guide: Option<ApertureGuide>,
}

/// What each light group has of the pupil. Light that is traced from the eye, and all that scatters, is taken to fill
/// the pupil. Once `stop` says true the rest is left out, and the result is worthless.
pub fn survey(checked: &Checked, world: &World, asked: Asked, plan: &Plan, stop: &ShouldStop<'_>) -> Surveyed {
    let scene = checked.scene();
    let full = Pupil::full(scene.eye.pupil_diameter_m);
    let mut found: Vec<GroupPupil> = scene
        .groups
        .iter()
        .map(|group| GroupPupil {
            group: group.name.clone(),
            pupil: full.clone(),
            because: match &full {
                Pupil::Point => "the pupil is a point".to_owned(),
                Pupil::Disc { .. } | Pupil::Lit(_) => String::new(),
            },
        })
        .collect();
    if full == Pupil::Point {
        return Surveyed { pupils: found, guide: None };
    }
    // Vision as it would be owned if nothing were asked for: where a group is lit does not depend on who traces it.
    let mut own = plan.clone();
    for row in &mut own.rows {
        let is_sky = scene.sky.as_ref().is_some_and(|sky| sky.group == row.group);
        row.verdict = match (row.class, asked.choice) {
            (Class::Vision, Choice::Auto) => row.verdict.clone(),
            (Class::Vision, Choice::Only(_)) => auto(checked, world, row.group, row.class, is_sky),
            (Class::Primary | Class::Caustic | Class::Secondary, _) => skip("no vision"),
        };
        if row.class != Class::Vision {
            continue;
        }
        if let (
            Verdict::Own { owner: Estimator::Backward | Estimator::Photon | Estimator::Manifold, because }
            | Verdict::Skip { because },
            Some(of),
        ) = (&row.verdict, found.get_mut(row.group.index()))
        {
            of.because = format!("taken to fill the pupil: {because}");
        }
    }
    if !own.runs(Estimator::Forward) || stop() {
        return Surveyed { pupils: found, guide: None };
    }
    let groups = scene.groups.len();
    let guide = match (asked.choice, &plan.forward_guide) {
        (Choice::Auto, Some(guide)) => guide.clone(),
        (Choice::Auto | Choice::Only(_), _) => forward(world, &own, groups, stop).guide,
    };
    let lamps = crossings(world, &own, groups, &guide, PATHS, stop);
    for (index, of) in found.iter_mut().enumerate() {
        let group = GroupId::from_index(index);
        let vision = own.row(group, Class::Vision);
        if !matches!(
            vision.verdict,
            Verdict::Own { owner: Estimator::Forward, .. }
                | Verdict::Connect { rest: Estimator::Forward, .. }
                | Verdict::Emitted { .. }
        ) {
            continue;
        }
        let of_group = lamps.range((group, 0)..=(group, usize::MAX)).map(|(_, crossings)| crossings);
        let count: usize = of_group.clone().map(Vec::len).sum();
        match regions(of_group) {
            Some(regions) => {
                let own = regions.len();
                of.because = format!(
                    "measured by {count} of {PATHS} paths from the lamps: {own} region{}",
                    if own == 1 { "" } else { "s" }
                );
                of.pupil = Pupil::Lit(regions);
            }
            None => {
                of.because =
                    format!("taken to fill the pupil: {count} of {PATHS} paths from the lamps arrived, too few")
            }
        }
    }
    let guide =
        (asked.guides == Guides::On).then(|| ApertureGuide::learn(&lit(&lamps, world.eye.pupil_radius_m()))).flatten();
    Surveyed { pupils: found, guide }
}

/// Where light that `own` leaves to `forward` crosses the pupil, by group and lamp.
pub(crate) fn crossings(
    world: &World,
    own: &Plan,
    groups: usize,
    guide: &Guide,
    paths: u64,
    stop: &ShouldStop<'_>,
) -> BTreeMap<(GroupId, usize), Vec<Crossing>> {
    let route = Ownership::new(own, groups, Estimator::Forward);
    let emission = Emission::new(world, &route, groups, Some(guide));
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let shots = Shots { seed: SEED, stream: Stream::Pilot, pass: 0, paths, starts: Starts::OfPass };
    let visitor = || Arrivals { route: &route, group: None, crossings: Vec::new() };
    let arrived = emission.survey((world, &optics), shots, stop, visitor, |lamp, _, _, arrivals: Arrivals<'_>| {
        Some((arrivals.group?, lamp, arrivals.crossings))
    });
    let mut lamps: BTreeMap<(GroupId, usize), Vec<Crossing>> = BTreeMap::new();
    for (group, lamp, crossings) in arrived {
        lamps.entry((group, lamp)).or_default().extend(crossings);
    }
    lamps
}

/// The regions of a group's lamps with their shares of the light; none if too few paths arrived.
fn regions<'c>(lamps: impl Iterator<Item = &'c Vec<Crossing>> + Clone) -> Option<Vec<(f64, Aperture)>> {
    let light = |crossings: &[Crossing]| crossings.iter().map(|crossing| crossing.light).sum::<f64>();
    let mut found = Vec::new();
    let mut rest: Vec<Crossing> = Vec::new();
    for crossings in lamps {
        match if crossings.len() >= OWN { Aperture::of(crossings) } else { None } {
            Some(region) => found.push((light(crossings), region)),
            None => rest.extend(crossings),
        }
    }
    if let Some(region) = Aperture::of(&rest) {
        found.push((light(&rest), region));
    }
    let total: f64 = found.iter().map(|(light, _)| light).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    found.iter_mut().for_each(|(share, _)| *share /= total);
    Some(found)
}
