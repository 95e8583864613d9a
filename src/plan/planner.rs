//! Fills a plan of verdicts with what pilots find: guides, connections, how many paths a pass has; and hands on what a pilot
//! gives up.

use super::pilots::pilot_cache::PilotCache;
use super::pilots::{chains, pupil_guide, reached, shared_faces, sky_guide, split_threshold};
use super::selection::facts::{is_connected, own};
use super::tuning::planner::{ARRIVED, FEWEST_LOOKS, LOOKS, MANY_LOOKS, MISSED, SELDOM, SELDOM_UNKNOWN, UNKNOWN};
use super::{Asked, Choice, Guides, pilots};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::backward::Backward;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::photon::visible_receivers::VisibleReceivers;
use eyebox_estimate::vision::Hints;
use eyebox_film::plan::{Estimator, PathMode, Plan, Row, Verdict};
use eyebox_film::specular_chain::Screen;
use eyebox_world::World;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::Mono;
use eyebox_world::surface::Surface;
use std::collections::{BTreeMap, BTreeSet};

/// What the pilots are run with.
pub(super) struct Planner<'m> {
    pub(super) checked: &'m Checked<'m>,
    pub(super) world: &'m World,
    pub(super) asked: Asked,
    pub(super) mode: PathMode,
    pub(super) stop: &'m ShouldStop<'m>,
    pub(super) made: PilotCache,
}

impl Planner<'_> {
    /// A plan of these rows with what pilots say of it; `known`: another whose pilots hold for the classes that it has
    /// the same verdicts for.
    pub(super) fn plan_of(&self, rows: Vec<Row>, known: Option<&Plan>) -> Plan {
        let same = |classes: &[Class]| {
            known.filter(|known| {
                let pairs = known.rows.iter().zip(&rows);
                pairs.filter(|(row, _)| classes.contains(&row.class)).all(|(a, b)| a.verdict == b.verdict)
            })
        };
        let (vision, scattered) = (same(&[Class::Vision]), same(&[Class::Caustic, Class::Secondary]));
        let mut plan = Plan::of(rows, self.mode.clone());
        match vision {
            Some(known) => {
                plan.forward_guide.clone_from(&known.forward_guide);
                plan.connections.clone_from(&known.connections);
                (plan.unknown_share, plan.vision_share) = (known.unknown_share, known.vision_share);
                plan.forward_paths = known.forward_paths;
                plan.pupil_guide.clone_from(&known.pupil_guide);
            }
            None => {
                let rows = plan.rows.clone();
                self.light_paths(&mut plan);
                // What a pilot has given up, another would not find either.
                let kept = |row: &Row| rows.iter().any(|asked| asked == row);
                if self.asked.guides == Guides::On {
                    plan.pupil_guide = pupil_guide::learn(self, &plan, kept, known);
                }
            }
        }
        match scattered {
            Some(known) => {
                plan.screens.clone_from(&known.screens);
                plan.photon_guide.clone_from(&known.photon_guide);
                (plan.photons, plan.photons_part) = (known.photons, known.photons_part);
                plan.photon_radii_m = known.photon_radii_m;
            }
            None => self.photons(&mut plan),
        }
        if self.asked.guides == Guides::On {
            self.windows(&mut plan, known);
        }
        self.eye_paths(&mut plan);
        if self.asked.guides == Guides::Off {
            (plan.forward_guide, plan.photon_guide) = (None, None);
        }
        plan
    }

    pub(super) fn groups(&self) -> usize {
        self.checked.scene().groups.len()
    }
    fn pixels(&self) -> u64 {
        let [width, height] = self.checked.scene().eye.resolution;
        (width * height) as u64
    }
    pub(super) fn stopped(&self) -> bool {
        (self.stop)()
    }

    /// Light tracing and the connections of lamps with the pupil.
    fn light_paths(&self, plan: &mut Plan) {
        while plan.runs(Estimator::Forward) && !self.stopped() {
            let pilot = self.made.forward(self.world, plan, self.groups(), self.stop);
            if self.asked.choice == Choice::Auto && self.gives_up(plan, &pilot) {
                // The guide belongs to the lamps that are left.
                continue;
            }
            if plan.rows.iter().any(|row| row.class == Class::Vision && is_connected(row)) {
                let found = chains::find(self.world, plan, self.groups(), Some(&pilot.guide), self.stop);
                plan.connections = found.connections;
                let least = SELDOM_UNKNOWN.max(FEWEST_LOOKS / self.pixels().max(1) as f64).min(1.0);
                let made = self.made.connections(self.world, plan);
                let left = reached::left_to_eye(self.world, plan, self.groups(), &made, self.stop).max(found.left);
                plan.unknown_share = (UNKNOWN * left).clamp(least, 1.0);
            }
            let before = plan.rows.iter().filter(|row| pilots::starts_paths(row)).count();
            leave_unconnected(plan, Class::Vision, Some(&pilot.arrived));
            if !plan.runs(Estimator::Forward) {
                break;
            }
            if plan.rows.iter().filter(|row| pilots::starts_paths(row)).count() < before {
                // Of fewer lamps the guide is another.
                continue;
            }
            // What specular connection leaves is not the light that the pilot has found most of.
            let leaves = |row: &Row| matches!(row.verdict, Verdict::Connect { rest: Estimator::Forward, .. });
            let owns = |row: &Row| {
                matches!(row.verdict, Verdict::Own { owner: Estimator::Forward, .. } | Verdict::Emitted { .. })
            };
            // Where the rest is nobody knows.
            let rest = if plan.rows.iter().any(owns) {
                1.0
            } else {
                let connections = self.made.connections(self.world, plan);
                pilots::left(self.world, plan, self.groups(), &pilot, connections, self.stop)
            };
            plan.forward_paths = pilots::forward_paths(rest, self.pixels());
            plan.forward_guide = Some(if plan.rows.iter().any(leaves) { pilot.guide.clone() } else { pilot.sure() });
            break;
        }
    }

    /// Whether light tracing leaves groups to rays from the eye. Where there is no hope for those either, they look seldom.
    fn gives_up(&self, plan: &mut Plan, pilot: &pilots::ForwardPilot) -> bool {
        let given_up = give_up_forward(plan, &pilots::without_arrivals(pilot), pilot.traced);
        let has_lamps = |row: &Row| self.world.lamps.all().iter().any(|lamp| lamp.group == row.group);
        let is_dark = |row: &Row| match row.verdict {
            Verdict::Skip { .. } => true,
            Verdict::Emitted { .. } => false,
            Verdict::Own { .. } | Verdict::Connect { .. } => given_up.contains(&row.group) || !has_lamps(row),
        };
        let vision = |row: &&Row| row.class == Class::Vision;
        let hopeless = !given_up.is_empty() && pilot.is_hopeless() && plan.rows.iter().filter(vision).all(is_dark);
        if hopeless && !shared_faces::in_plain_sight(self.world, self.stop) {
            plan.vision_share = SELDOM;
        }
        !given_up.is_empty()
    }

    /// Whether what a face scatters depends on how light is polarised.
    fn polarises(&self, part: u32, face: u32) -> bool {
        let found = self.world.faces.get(part as usize).and_then(|faces| faces.get(face as usize));
        let Some(Surface::Scatter(scatter)) = found.map(|face| &face.surface) else { return false };
        scatter.principled().is_some_and(|principled| principled.has_facets())
    }

    /// Photons and the connections of lamps with faces that scatter.
    fn photons(&self, plan: &mut Plan) {
        let caustics = plan.rows.iter().any(|row| row.class == Class::Caustic && is_connected(row));
        if !(caustics || plan.runs(Estimator::Photon)) || self.stopped() {
            return;
        }
        let pixel_m = pilots::pixel_m(self.world, self.checked.scene().eye.resolution);
        let seen = VisibleReceivers::look(self.world, pixel_m, self.stop);
        if caustics {
            let mut faces = seen.faces();
            if plan.mode.polarised {
                // A connection knows the power of its light alone.
                faces.retain(|(part, face)| !self.polarises(*part, *face));
            }
            plan.screens = chains::screens(self.world, plan, self.groups(), &faces, None, self.stop);
            // What follows sees the light of a train as connected where a coarse table has it; so where that has nothing, the
            // train is the photons'. Of weak ones that is not worth finding out.
            let joined = |screen: &Screen| !self.made.screens(self.world, std::slice::from_ref(screen)).is_empty();
            plan.screens.retain(|screen| !pilots::is_strong(screen) || joined(screen));
            leave_unconnected(plan, Class::Caustic, None);
        }
        if plan.runs(Estimator::Photon) {
            let pilot = pilots::photon(self.world, plan, self.groups(), (pixel_m, &seen), &self.made, self.stop);
            (plan.photons, plan.photons_part) = (pilot.photons, pilot.part);
            plan.photon_radii_m = pilot.radii_m;
            if !pilot.part {
                (plan.screens, _) = pilots::by_light(&plan.screens);
            }
            plan.photon_guide = Some(pilot.guide);
        }
    }

    /// Windows to the sky, whose light is always for paths from the eye: what one plan has learned of them holds for others.
    fn windows(&self, plan: &mut Plan, known: Option<&Plan>) {
        match known {
            Some(known) => plan.sky_guide.clone_from(&known.sky_guide),
            None => plan.sky_guide = sky_guide::learn(self, plan),
        }
        if plan.sky_guide.is_some() {
            plan.notes
                .push("backward aims at the windows through which a pilot saw the sky's light come in".to_owned());
        }
    }

    /// Paths from the eye.
    fn eye_paths(&self, plan: &mut Plan) {
        let guided = self.asked.guides == Guides::On;
        if guided && plan.runs(Estimator::Backward) && !self.stopped() {
            (plan.glints, plan.doubts.hidden) = self.made.glints(self, plan);
            let by_eye = |lamp: &&Lamp| plan.owner(lamp.group, Class::Vision, false) == Some(Estimator::Backward);
            let brightest = self.world.lamps.all().iter().filter(by_eye).map(Lamp::brightest).fold(0.0, f64::max);
            plan.doubts.brightest = Some(MISSED * brightest);
            if self.asked.choice == Choice::Auto {
                plan.doubts.of_caustics = MISSED;
            }
            if !plan.glints.is_empty() {
                plan.notes.push(format!(
                    "backward sends more rays to {} places of the picture where a pilot saw small images of lamps",
                    plan.glints.len()
                ));
            }
        }
        if !self.checked.facts().bundles {
            plan.doubts.of_caustics = 0.0;
        }
        if plan.pupil_guide.is_some() {
            plan.notes.push(
                "backward looks for lamps through the parts of the pupil that they light in a pilot run".to_owned(),
            );
        }
        if self.asked.choice == Choice::Auto
            && plan.owns(Estimator::Backward)
            && plan.glints.is_empty()
            && !self.stopped()
        {
            let route = Ownership::new(plan, self.groups(), Estimator::Backward);
            let backward = Backward::<Mono>::new(self.world, route, (1, 1.0), Hints::of(plan), pilots::SEED);
            // Where a bright lamp could be, few looks say little.
            let may_miss = backward.unseen().is_some_and(|unseen| unseen.light(1) > 0.0);
            let looks = if may_miss { MANY_LOOKS } else { LOOKS };
            if !(backward.finds_light(LOOKS, self.stop) || may_miss && backward.finds_light(looks, self.stop)) {
                plan.backward_share = SELDOM;
                plan.doubts.glances = looks;
                plan.notes.push(format!(
                    "backward traces 1 pixel in {:.0} per pass: {looks} pilot paths found none of the light that it has to find",
                    1.0 / SELDOM
                ));
                return;
            }
        }
        // Where backward looks at few pixels for anything, that has been said.
        if plan.vision_share < 1.0 {
            plan.notes.push(format!(
                "backward looks for lamps over specular faces in 1 pixel in {:.0} per pass: pilots found no way to them",
                1.0 / plan.vision_share
            ));
        }
        let found =
            (guided && plan.owns(Estimator::Backward) && !self.stopped()).then(|| self.made.branching(self, plan));
        if let Some(found) = &found {
            plan.faintest_branch = found.faintest;
            plan.notes.extend(found.note());
        }
        if plan.runs(Estimator::Photon) || plan.runs(Estimator::Manifold) {
            plan.backward_paths = found.map_or(split_threshold::MOST, |found| found.paths);
        }
    }

    /// Light groups with rays of files, and how many those are.
    fn ray_files(&self) -> BTreeMap<GroupId, usize> {
        let mut counts = BTreeMap::new();
        for light in self.world.lights.all() {
            if let Some(rays) = light.rays() {
                *counts.entry(light.group()).or_default() += rays.count();
            }
        }
        counts
    }

    /// What a reader of the plan should know.
    pub(super) fn remarks(&self, plan: &mut Plan) {
        if plan.rows.iter().any(|row| row.class == Class::Vision && is_connected(row)) {
            plan.notes.push(format!(
                "backward looks for lamps over chains that connection does not know in 1 pixel in {:.0} per pass",
                1.0 / plan.unknown_share
            ));
        }
        for (group, count) in self.ray_files() {
            plan.notes.push(format!(
                "group {}: {count} rays of files: a picture of these lamps has no more points than rays arrive, and the stated error takes the files as exact",
                self.checked.scene().group(group).name
            ));
        }
        let sightless = self.world.lights.all().iter().filter(|light| !light.has_luminance());
        let sightless: BTreeSet<GroupId> = sightless.map(|light| light.group()).collect();
        plan.notes.extend(sightless.into_iter().map(|group| {
            format!(
                "group {}: points and parallel light have no luminance: the picture shows what they light, not themselves or their reflections",
                self.checked.scene().group(group).name
            )
        }));
        if plan.photons_part {
            plan.notes.push("photons follow both reflection and transmission at interfaces: connection leaves them only faint light".to_owned());
        }
        let idle: Vec<Estimator> = Estimator::ALL.into_iter().filter(|estimator| !plan.runs(*estimator)).collect();
        plan.notes.extend(
            idle.iter().map(|estimator| format!("{} does not run: the plan gives it no light", estimator.name())),
        );
        if self.checked.facts().no_light {
            plan.notes.push("nothing emits: the picture is black".to_owned());
        } else if idle.len() == Estimator::ALL.len() {
            plan.notes.push("no estimator can bring this scene's light to the eye: the picture is black".to_owned());
        }
    }
}

/// Leaves the vision paths of groups for which no train was found to the estimator that would have kept the rest. `arrived`: by light group,
/// paths of a pilot from the lamps that found the pupil.
fn leave_unconnected(plan: &mut Plan, class: Class, arrived: Option<&[u64]>) {
    for row in plan.rows.iter_mut().filter(|row| row.class == class) {
        let Verdict::Connect { rest, .. } = row.verdict else { continue };
        let (found, between) = match class {
            Class::Vision => (plan.connections.iter().any(|c| c.group == row.group), "lamp to eye"),
            Class::Primary | Class::Caustic | Class::Secondary => {
                (plan.screens.iter().any(|s| s.group == row.group), "lamp to scatterer")
            }
        };
        if found {
            continue;
        }
        // What few paths from the lamps bring is missing from nearly every picture: rays from the eye look for it.
        let few = arrived.is_some_and(|arrived| arrived[row.group.index()] < ARRIVED);
        row.verdict = match rest {
            Estimator::Forward if few => own(
                Estimator::Backward,
                format!(
                    "a pilot found no chain of specular faces from {between} that could be connected, and few paths from the lamps find the pupil"
                ),
            ),
            Estimator::Forward | Estimator::Backward | Estimator::Photon | Estimator::Manifold => {
                own(rest, format!("a pilot found no chain of specular faces from {between} that could be connected"))
            }
        };
    }
}

/// Hands the vision paths of groups that no lamp path of the pilot brought over to the rays from the eye: whatever there
/// is, they find it without bias. Returns the groups that were handed over.
fn give_up_forward(plan: &mut Plan, groups: &[GroupId], traced: u64) -> Vec<GroupId> {
    let mut given_up = Vec::new();
    for row in &mut plan.rows {
        let forward = matches!(
            row.verdict,
            Verdict::Own { owner: Estimator::Forward, .. } | Verdict::Connect { rest: Estimator::Forward, .. }
        );
        if forward && groups.contains(&row.group) {
            row.verdict =
                own(Estimator::Backward, format!("none of {traced} pilot paths from the lamps reached the pupil"));
            given_up.push(row.group);
        }
    }
    given_up
}
