//! From which side the light of each group is found, and where paths from the lamps start.

use super::PHOTONS;
use super::chain_sampling::All;
use super::discover::{Start, discover};
use super::lamp_paths::{self, Source, Split};
use super::learn::Looks;
use crate::pilots::{self, pilot_cache::PilotCache};
use crate::selection::facts::{auto, has_rays, skip};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::Emission;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::photon::visible_receivers::VisibleReceivers;
use eyebox_film::guide::Guide;
use eyebox_film::plan::{Estimator, PathMode, Plan, Row, Spectral, Verdict};
use eyebox_world::World;

/// From which side the light of each group is found.
pub(super) struct Sides {
    /// Groups whose light over specular faces is found from the eye.
    pub from_eye: Vec<bool>,
    /// Paths from the lamps, for light over specular faces and for light at scatterers.
    pub lamps: Option<Lamps>,
    pub photons: Option<Lamps>,
    /// Chains from the lamps with paths of their own.
    pub directed: All,
    pub notes: Vec<String>,
}

pub(super) struct Lamps {
    pub emission: Emission,
    pub sources: Vec<Source>,
}

impl Lamps {
    fn new(world: &World, plan: &Plan, groups: usize, estimator: Estimator, guide: &Guide) -> Option<Lamps> {
        let given = |group: GroupId| Class::ALL.iter().any(|class| owned(plan, group, *class, estimator));
        let sources = lamp_paths::sources(world, given);
        let emission = Emission::new(world, &Ownership::new(plan, groups, estimator), groups, Some(guide));
        (!sources.is_empty() && sources.len() == emission.flux().len()).then_some(Lamps { emission, sources })
    }
}

fn owned(plan: &Plan, group: GroupId, class: Class, estimator: Estimator) -> bool {
    matches!(plan.row(group, class).verdict, Verdict::Own { owner, .. } if owner == estimator)
}

impl Sides {
    /// `least`: share of all light from which chains get paths of their own.
    pub fn new(
        checked: &Checked,
        world: &World,
        mode: &PathMode,
        (split, least): (Split, f64),
        stop: &ShouldStop<'_>,
    ) -> Sides {
        let scene = checked.scene();
        let facts = checked.facts();
        let groups = scene.groups.len();
        let mut notes = Vec::new();
        let is_sky = |group: GroupId| scene.sky.as_ref().is_some_and(|sky| sky.group == group);
        let has_lamp = |group: GroupId| world.lamps.all().iter().any(|lamp| lamp.group == group);
        // As the plan would have it for vision, so that the better side is taken.
        let from_eye: Vec<bool> = (0..groups)
            .map(GroupId::from_index)
            .map(|group| {
                if has_rays(world, group) {
                    return false;
                }
                let verdict = auto(checked, world, group, Class::Vision, is_sky(group));
                !has_lamp(group) || matches!(verdict, Verdict::Own { owner: Estimator::Backward, .. })
            })
            .collect();
        let mut sides = Sides { from_eye, lamps: None, photons: None, directed: All::default(), notes: Vec::new() };
        let mut route = None;
        while sides.from_eye.contains(&false) && !stop() {
            let vision = |group: GroupId, class: Class| {
                class == Class::Vision && sides.from_eye.get(group.index()) == Some(&false)
            };
            let plan = plan_of(groups, Estimator::Forward, mode, vision);
            let pilot = learn(world, &plan, groups, split, stop);
            let lost = pilots::without_arrivals(&pilot);
            let lost: Vec<GroupId> =
                lost.into_iter().filter(|group| sides.from_eye.get(group.index()) == Some(&false)).collect();
            if lost.is_empty() {
                sides.lamps = Lamps::new(world, &plan, groups, Estimator::Forward, &pilot.guide);
                route = Some(Ownership::new(&plan, groups, Estimator::Forward));
                break;
            }
            for group in lost {
                if let Some(from_eye) = sides.from_eye.get_mut(group.index()) {
                    *from_eye = true;
                }
            }
        }
        // What nobody starts on has no route.
        let route = route.unwrap_or_else(|| {
            Ownership::new(&plan_of(groups, Estimator::Forward, mode, |_, _| false), groups, Estimator::Forward)
        });
        let (lamps, eye) = (sides.lamps.as_ref(), sides.from_eye.as_slice());
        sides.directed = discover(Start { world, route: &route, groups, lamps, eye }, split, least, stop);
        if facts.scatters && !stop() {
            let plan =
                plan_of(groups, Estimator::Photon, mode, |group, class| class != Class::Vision && !is_sky(group));
            let pixel_m = pilots::pixel_m(world, scene.eye.resolution);
            let seen = VisibleReceivers::look(world, pixel_m, stop);
            let pilot = pilots::photon(world, &plan, groups, (pixel_m, &seen), &PilotCache::default(), stop);
            sides.photons = Lamps::new(world, &plan, groups, Estimator::Photon, &pilot.guide);
            if scene.sky.is_some() {
                notes.push("what scatters the light of the sky is not in the table".to_owned());
            }
        }
        if facts.pinhole {
            notes.push("the pupil is a point: no lumen gets in, and rows are ranked by luminance".to_owned());
        }
        if mode.spectral != Spectral::Mono {
            notes.push(format!(
                "traced at {} nm alone: coatings and glass differ at other wavelengths",
                world.wavelength_nm
            ));
        }
        sides.notes = notes;
        sides
    }

    /// Paths from the lamps for each that is asked for.
    pub fn starts(&self) -> u64 {
        u64::from(self.lamps.is_some()) + if self.photons.is_some() { PHOTONS } else { 0 }
    }

    /// Whether paths from the eye are needed.
    pub fn looks(&self) -> bool {
        self.from_eye.contains(&true) || self.photons.is_some()
    }
}

/// Learns where paths have to start that end in the picture.
fn learn(world: &World, plan: &Plan, groups: usize, split: Split, stop: &ShouldStop<'_>) -> pilots::ForwardPilot {
    let given = |group: GroupId| owned(plan, group, Class::Vision, Estimator::Forward);
    let sources = lamp_paths::sources(world, given);
    let split = Split { least: split.least.max(Looks::LEAST) };
    let with = |guide: Option<&Guide>, paths: u64| {
        let emission = Emission::new(world, &Ownership::new(plan, groups, Estimator::Forward), groups, guide);
        Looks { world, emission, sources: &sources, paths, split }
    };
    pilots::pilot(with, || true, groups, stop)
}

/// A plan in which `estimator` owns what `owns` says and nobody anything else.
fn plan_of(groups: usize, estimator: Estimator, mode: &PathMode, owns: impl Fn(GroupId, Class) -> bool) -> Plan {
    let row = |group: GroupId, class: Class| {
        let verdict = match owns(group, class) {
            true => Verdict::Own { owner: estimator, because: String::new() },
            false => skip("not asked for"),
        };
        Row { group, class, verdict }
    };
    let groups = (0..groups).map(GroupId::from_index);
    Plan::of(groups.flat_map(|group| Class::ALL.map(|class| row(group, class))).collect(), mode.clone())
}
