//! Floor 5: decides who owns which (light group, path class), with reasons, and how much work a pass is; scans an eyebox.

pub mod adaptation;
pub mod forecast;
mod mode;
pub mod paths;
pub mod pilots;
pub mod plan_file;
mod planner;
pub mod scan;
pub mod selection;
pub mod sensor;
pub mod tolerance;
mod tuning;

use eyebox_base::{Error, Result, Where};
use eyebox_check::Checked;
use eyebox_estimate::ShouldStop;
use eyebox_film::plan::{Estimator, Plan, Verdict};
use eyebox_world::World;
use pilots::pilot_cache::PilotCache;
use planner::Planner;
use selection::{Handicap, facts};

/// Which estimators may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Choice {
    #[default]
    Auto,
    Only(Estimator),
}

/// Whether paths carry their polarisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Polarisation {
    /// Where a pilot finds that it matters.
    #[default]
    Auto,
    On,
    Off,
}

/// Whether what a pilot finds tells where paths start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Guides {
    #[default]
    On,
    /// Paths are aimed at nothing: what each way of tracing is by itself.
    Off,
}

/// What is asked of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Asked {
    pub choice: Choice,
    pub polarisation: Polarisation,
    #[serde(default)]
    pub guides: Guides,
}

impl From<Choice> for Asked {
    fn from(choice: Choice) -> Self {
        Asked { choice, ..Asked::default() }
    }
}

/// Makes the plan: facts decide who owns what, and pilots where facts do not tell.
pub fn plan(checked: &Checked, world: &World, asked: impl Into<Asked>) -> Plan {
    make(checked, world, asked.into(), &|| false, &Handicap::default())
}

/// The same; none if `stop` says true (Ctrl-C) before the pilots are through. It is asked before each path of a pilot.
pub fn plan_unless(checked: &Checked, world: &World, asked: Asked, stop: &ShouldStop<'_>) -> Option<Plan> {
    let plan = make(checked, world, asked, stop, &Handicap::default());
    (!stop()).then_some(plan)
}

/// The plan of the automatic choice if its pilot saw some estimators' work or noise multiplied: for tests that want to see
/// it change.
pub fn plan_handicapped(checked: &Checked, world: &World, handicap: &Handicap) -> Plan {
    make(checked, world, Choice::Auto.into(), &|| false, handicap)
}

/// Refuses what would be black: rays of a file where only paths from the eye may be traced, which never meet one; and a
/// picture that has no light but theirs and gets none of it.
pub fn follows_rays(checked: &Checked, world: &World, asked: Asked) -> Result<()> {
    let rows = facts::rows(checked, world, asked.choice);
    let groups = facts::unfollowed(world, &rows);
    let Some(first) = groups.first() else { return Ok(()) };
    let name = &checked.scene().group(*first).name;
    if asked.choice == Choice::Only(Estimator::Backward) {
        let what = format!("no path from the eye meets the rays of a file, and light group {name} has some");
        return Err(
            Error::new(Where::Option("--estimator".to_owned()), what).expected("auto, forward, photon or manifold")
        );
    }
    if rows.iter().all(|row| matches!(row.verdict, Verdict::Skip { .. })) {
        let what = format!(
            "no light of group {name}, rays of a file, can get into the picture: the pupil is a point, and nothing scatters"
        );
        return Err(Error::new(Where::Nowhere, what).expected("a pupil_diameter above 0"));
    }
    Ok(())
}

fn make(checked: &Checked, world: &World, asked: Asked, stop: &ShouldStop<'_>, handicap: &Handicap) -> Plan {
    let mode = mode::decide(checked, world, asked.polarisation, stop);
    let making = Planner { checked, world, asked, mode, stop, made: PilotCache::default() };
    let mut plan = making.plan_of(facts::rows(checked, world, asked.choice), None);
    if asked.choice == Choice::Auto {
        plan = selection::settle(&making, plan, handicap);
    }
    making.remarks(&mut plan);
    plan
}
