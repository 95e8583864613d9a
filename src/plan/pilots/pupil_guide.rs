//! Through which part of the pupil each part of the picture sees lamps over specular faces: rays from the eye then start
//! there. No ray from the eye tells, but light from the lamps does.

use super::pupil;
use super::tuning::pupil_guide::{LOOK, MOST_LAMPS, OF_LAMP, PATHS, WORTH};
use crate::Planner;
use crate::selection::facts::{OPEN, connect, kind, lamps_over_eye, skip};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::warp::disk_inverse;
use eyebox_film::guide::{ApertureGuide, Lit};
use eyebox_film::plan::{Estimator, Plan, Row};
use eyebox_film::pupil::Crossing;
use glam::DVec2;
use std::collections::BTreeMap;

/// What rays from the eye need to know to find the lamps that the plan leaves to them in rows that `asks` says true of. None
/// if it leaves none to them, no light of theirs arrives, or it fills the pupil. `known`: a plan of other owners.
pub(crate) fn learn(
    making: &Planner<'_>,
    plan: &Plan,
    asks: impl Fn(&Row) -> bool,
    known: Option<&Plan>,
) -> Option<ApertureGuide> {
    let facts = making.checked.facts();
    if !facts.specular || facts.pinhole || making.stopped() {
        return None;
    }
    let (world, groups) = (making.world, making.groups());
    let small = |group: GroupId| {
        let area = world.lamps.all().iter().filter(|lamp| lamp.group == group).map(|lamp| lamp.area_m2).sum();
        area > 0.0 && lamps_over_eye(world, area) <= OPEN[1]
    };
    // The same paths, but from the lamps.
    let mut own = plan.clone();
    for row in &mut own.rows {
        let ours = row.class == Class::Vision && kind(&row.verdict) == Some((Estimator::Backward, false)) && asks(row);
        row.verdict = if ours && small(row.group) { connect(Estimator::Forward, "pilot") } else { skip("pilot") };
    }
    if !own.runs(Estimator::Forward) {
        return None;
    }
    let of_known = known.filter(|known| {
        let pairs = own.rows.iter().zip(&known.rows).filter(|(row, _)| row.class == Class::Vision);
        pairs.into_iter().all(|(row, known)| kind(&row.verdict) == kind(&known.verdict))
    });
    let guide = match of_known.and_then(|known| known.forward_guide.clone()) {
        Some(guide) => guide,
        None => {
            let pilot = making.made.forward(world, &own, groups, making.stop);
            if pilot.arrived.iter().all(|count| *count == 0) {
                return None;
            }
            pilot.guide.clone()
        }
    };
    let look = |paths: u64| {
        let lit = lit(&pupil::crossings(world, &own, groups, &guide, paths, making.stop), world.eye.pupil_radius_m());
        ApertureGuide::learn(&lit).filter(|learned| learned.gain(&lit) >= WORTH)
    };
    look(LOOK).and_then(|_| look(PATHS))
}

/// For each of the groups `of` that connection sees, how dense the light of one lamp is in the pupil for a place in the
/// picture, over that of light that fills it: the mean over the lamps.
pub(crate) fn densities(making: &Planner<'_>, plan: &Plan, of: &[bool]) -> Vec<Option<f64>> {
    let (world, groups) = (making.world, making.groups());
    let connected = |row: &Row| {
        let kind = kind(&row.verdict);
        row.class == Class::Vision && of[row.group.index()] && kind == Some((Estimator::Forward, true))
    };
    let asked = plan.rows.iter().any(connected) && !making.stopped();
    let Some(guide) = plan.forward_guide.as_ref().filter(|_| asked) else { return vec![None; groups] };
    let paths = LOOK.max(OF_LAMP * world.lamps.all().len().min(MOST_LAMPS) as u64);
    let by_lamp = pupil::crossings(world, plan, groups, guide, paths, making.stop);
    let density = |group: GroupId| {
        let lamps = by_lamp.range((group, 0)..=(group, usize::MAX)).filter(|_| of[group.index()]).take(MOST_LAMPS);
        let known = lamps.filter_map(|(lamp, crossings)| {
            let lit = lit(&BTreeMap::from([(*lamp, crossings.clone())]), world.eye.pupil_radius_m());
            Some(ApertureGuide::learn(&lit)?.gain(&lit))
        });
        let (sum, count) = known.fold((0.0, 0u32), |(sum, count), density| (sum + density, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    };
    (0..groups).map(GroupId::from_index).map(density).collect()
}

/// Every light group is as important as any other, whatever it adds to the picture.
pub(crate) fn lit(by_lamp: &BTreeMap<(GroupId, usize), Vec<Crossing>>, radius_m: f64) -> Vec<Lit> {
    let mut of_group: BTreeMap<GroupId, f64> = BTreeMap::new();
    for ((group, _), crossings) in by_lamp {
        *of_group.entry(*group).or_default() += crossings.iter().map(|crossing| crossing.open).sum::<f64>();
    }
    let lit = |crossing: &Crossing, light: f64| Lit {
        field: crossing.field,
        pupil: disk_inverse(DVec2::from_array(crossing.at) / radius_m),
        weight: crossing.open / light,
    };
    let of_lamp = |((group, _), crossings): (&(GroupId, usize), &'_ Vec<Crossing>)| {
        let light = of_group[group];
        crossings.iter().map(|crossing| lit(crossing, light)).collect::<Vec<_>>()
    };
    by_lamp.iter().flat_map(of_lamp).collect()
}
