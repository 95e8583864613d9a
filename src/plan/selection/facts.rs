//! What the facts of a scene say of each pair of light group and path class: who owns it, and why.

pub(crate) use super::tuning::facts::OPEN;
use crate::Choice;
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_check::Checked;
use eyebox_film::plan::{Estimator, Row, Verdict};
use eyebox_world::World;

/// What facts say of every pair of light group and class.
pub(crate) fn rows(checked: &Checked, world: &World, choice: Choice) -> Vec<Row> {
    let scene = checked.scene();
    let row = |group: GroupId, class: Class| {
        if has_rays(world, group) {
            return Row { group, class, verdict: of_rays(checked, choice, class) };
        }
        let is_sky = scene.sky.as_ref().is_some_and(|sky| sky.group == group);
        let verdict = match choice {
            Choice::Auto => auto(checked, world, group, class, is_sky),
            Choice::Only(estimator) => only(checked, estimator, class, is_sky),
        };
        let verdict = uneven(world, group, verdict);
        Row { group, class, verdict: without_area(world, group, class, verdict) }
    };
    let groups = (0..scene.groups.len()).map(GroupId::from_index);
    groups.flat_map(|group| Class::ALL.map(|class| row(group, class))).collect()
}

/// Whether a lamp of a group is the rays of a file.
pub(crate) fn has_rays(world: &World, group: GroupId) -> bool {
    world.lights.all().iter().any(|light| light.group() == group && light.rays().is_some())
}

/// Who has the light of a group with rays of a file: no ray from the eye ever meets one, so its paths start on them, and with
/// them those of the group's other lamps.
fn of_rays(checked: &Checked, choice: Choice, class: Class) -> Verdict {
    let facts = checked.facts();
    let asked = match choice {
        Choice::Auto | Choice::Only(Estimator::Photon | Estimator::Manifold) => None,
        Choice::Only(Estimator::Forward) => Some(own(Estimator::Forward, "asked for")),
        Choice::Only(Estimator::Backward) => Some(skip(UNMET)),
    };
    match (class, asked) {
        (Class::Primary | Class::Caustic | Class::Secondary, _) if !facts.scatters => skip("no face scatters"),
        (Class::Caustic, _) if !facts.specular => skip("no face is specular"),
        (Class::Vision, None) | (_, Some(Verdict::Own { .. })) if facts.pinhole => {
            skip("the pupil is a point: no ray of a file arrives")
        }
        (_, Some(asked)) => asked,
        (_, None) if facts.pinhole => {
            emitted(format!("{UNMET}; what narrow lobes send to a point of a pupil is not seen"))
        }
        (_, None) => emitted(UNMET),
    }
}

/// Why paths from the eye are no use for the rays of a file.
const UNMET: &str = "no path from the eye meets the rays of a file";

/// Light groups of which the picture would be black for want of an estimator that follows the rays of their files.
pub(crate) fn unfollowed(world: &World, rows: &[Row]) -> Vec<GroupId> {
    let traced = |group: GroupId| {
        let of_group = rows.iter().filter(|row| row.group == group);
        of_group.clone().any(|row| !matches!(row.verdict, Verdict::Skip { .. }))
    };
    let groups: std::collections::BTreeSet<GroupId> = rows.iter().map(|row| row.group).collect();
    groups.into_iter().filter(|group| has_rays(world, *group) && !traced(*group)).collect()
}

/// What remains of a verdict for a group of lamps with emission textures or displays: the tables of connection take a lamp to
/// shine alike from all of its places.
fn uneven(world: &World, group: GroupId, verdict: Verdict) -> Verdict {
    let even = world.lamps.all().iter().filter(|lamp| lamp.group == group).all(|lamp| lamp.is_even());
    match verdict {
        Verdict::Connect { rest, because } if !even => {
            own(rest, format!("{because}; a lamp has a picture, which connection does not know"))
        }
        Verdict::Own { .. } | Verdict::Connect { .. } | Verdict::Emitted { .. } | Verdict::Skip { .. } => verdict,
    }
}

/// What remains of a verdict for a group of points and parallel light, which no ray meets by chance.
fn without_area(world: &World, group: GroupId, class: Class, verdict: Verdict) -> Verdict {
    let lights = || world.lights.all().iter().filter(|light| light.group() == group);
    let faces = world.lamps.all().iter().any(|lamp| lamp.group == group);
    if lights().next().is_none() {
        return verdict;
    }
    let disc = lights().any(|light| light.is_visible());
    match (&verdict, class) {
        (Verdict::Skip { .. }, _) => verdict,
        (Verdict::Own { .. } | Verdict::Connect { .. }, Class::Vision) if disc => {
            own(Estimator::Backward, "its disc is at infinity: rays from the eye meet it")
        }
        (Verdict::Own { .. } | Verdict::Connect { .. }, Class::Vision) if !faces => {
            skip("a point or parallel light has no luminance")
        }
        (Verdict::Own { owner: Estimator::Backward, .. }, Class::Caustic) if !faces && !disc => {
            skip("rays from the eye can't meet a point or parallel light through specular faces")
        }
        (
            Verdict::Own { .. } | Verdict::Connect { .. } | Verdict::Emitted { .. },
            Class::Vision | Class::Primary | Class::Caustic | Class::Secondary,
        ) => verdict,
    }
}

pub(crate) fn own(owner: Estimator, because: impl Into<String>) -> Verdict {
    Verdict::Own { owner, because: because.into() }
}

pub(crate) fn connect(rest: Estimator, because: impl Into<String>) -> Verdict {
    Verdict::Connect { rest, because: because.into() }
}

fn emitted(because: impl Into<String>) -> Verdict {
    Verdict::Emitted { because: because.into() }
}

pub(crate) fn skip(because: impl Into<String>) -> Verdict {
    Verdict::Skip { because: because.into() }
}

/// Whether connection has what it can.
pub(crate) fn is_connected(row: &Row) -> bool {
    matches!(row.verdict, Verdict::Connect { .. })
}

/// A verdict without its reason: owner, and whether connection has what it can.
pub(crate) fn kind(verdict: &Verdict) -> Option<(Estimator, bool)> {
    match verdict {
        Verdict::Own { owner, .. } => Some((*owner, false)),
        Verdict::Connect { rest, .. } => Some((*rest, true)),
        Verdict::Emitted { .. } => Some((Estimator::Forward, false)),
        Verdict::Skip { .. } => None,
    }
}

/// Etendue of lamps of this area, m², over the eye's.
pub(crate) fn lamps_over_eye(world: &World, area_m2: f64) -> f64 {
    std::f64::consts::PI * area_m2 / world.eye.etendue_m2_sr()
}

pub(crate) fn auto(checked: &Checked, world: &World, group: GroupId, class: Class, is_sky: bool) -> Verdict {
    let facts = checked.facts();
    if class != Class::Vision && !facts.scatters {
        return skip("no face scatters");
    }
    if is_sky {
        return own(Estimator::Backward, "the sky is all around: rays from the eye meet it");
    }
    match class {
        Class::Vision if !facts.specular => own(Estimator::Backward, "no specular face is between lamp and eye"),
        Class::Vision if facts.pinhole => own(Estimator::Backward, "the pupil is a point: no ray from a lamp arrives"),
        Class::Vision => {
            let lamps = world.lamps.all().iter().filter(|lamp| lamp.group == group);
            // Rays from the eye hit the lamps, and rays from the lamps the eye, in proportion to the other's etendue;
            // the margin is for light from the lamps that a housing stops.
            let ratio = lamps_over_eye(world, lamps.map(|lamp| lamp.area_m2).sum());
            if ratio <= 64.0 {
                connect(
                    Estimator::Forward,
                    format!(
                        "the lamps have {ratio:.3} times the eye's étendue: few rays lead from each of their points to the pupil"
                    ),
                )
            } else {
                own(
                    Estimator::Backward,
                    format!("the lamps have {ratio:.3e} times the eye's étendue: rays from the eye hit them often"),
                )
            }
        }
        Class::Primary => own(Estimator::Backward, "the lamp is sampled directly from the scatterer"),
        Class::Caustic if !facts.specular => skip("no face is specular"),
        Class::Caustic => connect(Estimator::Photon, "specular faces stand between lamp and scatterer"),
        Class::Secondary => own(Estimator::Photon, "photons carry the light from scatterer to scatterer"),
    }
}

fn only(checked: &Checked, estimator: Estimator, class: Class, is_sky: bool) -> Verdict {
    let facts = checked.facts();
    if class != Class::Vision && !facts.scatters {
        return skip("no face scatters");
    }
    match estimator {
        Estimator::Backward => own(Estimator::Backward, "asked for"),
        Estimator::Forward | Estimator::Photon if is_sky => {
            own(Estimator::Backward, "only rays from the eye meet the sky in this version")
        }
        Estimator::Forward if facts.pinhole => skip("the pupil is a point: no ray from a lamp arrives"),
        Estimator::Forward => own(Estimator::Forward, "asked for"),
        Estimator::Manifold if is_sky => own(Estimator::Backward, "no connection leads to the sky"),
        Estimator::Manifold => match class {
            Class::Vision if !facts.pinhole => connect(Estimator::Forward, "asked for"),
            Class::Caustic if facts.specular => connect(Estimator::Photon, "asked for"),
            Class::Vision | Class::Primary | Class::Caustic | Class::Secondary => {
                own(Estimator::Backward, "specular connection is for the eye and lamps")
            }
        },
        Estimator::Photon => match class {
            Class::Vision | Class::Primary => {
                own(Estimator::Backward, "a photon map holds no light that comes straight from the lamp")
            }
            Class::Caustic | Class::Secondary => own(Estimator::Photon, "asked for"),
        },
    }
}
