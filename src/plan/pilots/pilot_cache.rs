//! What pilots have made for one plan, for the next that differs from it in something else.

use super::glint_pilot::{self, Search};
use super::split_threshold::{self, Branches};
use super::{ForwardPilot, SEED, forward, starts_paths};
use crate::Planner;
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::manifold::receiver::Receivers;
use eyebox_estimate::manifold::seeds::connections::{Connections, index_of};
use eyebox_estimate::manifold::solver::grid::Grid;
use eyebox_film::glint::Glint;
use eyebox_film::plan::{Estimator, Plan, Row};
use eyebox_film::specular_chain::{Connection, Screen};
use eyebox_film::unseen::Hidden;
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

/// Things with what they were made from.
type Known<K, V> = RefCell<Vec<(K, V)>>;

/// The faces over which connection joins the lamps of light groups with the eye.
type Trains = Vec<(GroupId, Chain)>;

/// What [`glint_pilot::find`] finds.
type Images = (Vec<Glint>, Option<Hidden>);

/// Made for one scene, at one wavelength.
#[derive(Default)]
pub(crate) struct PilotCache {
    /// By the rows whose paths start at the lamps.
    forward: Known<Vec<bool>, Rc<ForwardPilot>>,
    connections: Known<(Vec<Connection>, Grid), Arc<Connections>>,
    screens: Known<Screen, Arc<Receivers<Mono>>>,
    /// By the paths from the eye, as [`Plan::computes`] tells them.
    branching: Known<Vec<bool>, Branches>,
    /// By the light groups whose lamps rays from the eye look for, or have what others leave of, and the trains that connection has.
    glints: Known<(Vec<[bool; 2]>, Trains), Images>,
}

impl PilotCache {
    /// [`forward`].
    pub fn forward(&self, world: &World, plan: &Plan, groups: usize, stop: &ShouldStop<'_>) -> Rc<ForwardPilot> {
        let rows = plan.rows.iter().map(starts_paths).collect();
        known(&self.forward, rows, |_| Rc::new(forward(world, plan, groups, stop)))
    }

    /// [`split_threshold::learn`].
    pub(crate) fn branching(&self, making: &Planner<'_>, plan: &Plan) -> Branches {
        let broad = |row: &Row| [false, true].map(|b| plan.computes(Estimator::Backward, row.group, row.class, b));
        let key = plan.rows.iter().flat_map(broad).collect();
        known(&self.branching, key, |_| split_threshold::learn(making, plan))
    }

    /// [`glint_pilot::find`], for the lamps that the plan leaves to rays from the eye, and for ways that it leaves to them of others.
    pub(crate) fn glints(&self, making: &Planner<'_>, plan: &Plan) -> Images {
        let group_of = |lamp: usize| making.world.lamps.all()[lamp].group;
        let by_eye = |group| plan.owner(group, Class::Vision, false) == Some(Estimator::Backward);
        // Where other pilots found no way from the eye to a lamp nothing is looked for.
        let hope = plan.vision_share >= 1.0;
        let left = |group| plan.computes(Estimator::Backward, group, Class::Vision, false);
        let groups = || (0..making.groups()).map(GroupId::from_index);
        let over: Trains = plan.connections.iter().map(|own| (own.group, own.train.chain())).collect();
        let kinds = groups().map(|group| [by_eye(group) && hope, left(group)]).collect();
        known(&self.glints, (kinds, over), |(_, over)| {
            let wants = |lamp: usize| hope && by_eye(group_of(lamp));
            let is_connected = |(chain, lamp): &(Chain, usize)| {
                over.iter().any(|(group, known)| *group == group_of(*lamp) && known == chain)
            };
            let takes = |way: &(Chain, usize)| left(group_of(way.1)) && !is_connected(way);
            let over_faces = making.checked.facts().specular;
            let search = Search { wants: &wants, takes: &takes, over_faces };
            glint_pilot::find((making.world, making.checked.scene()), search, making.stop)
        })
    }

    /// The connections of a plan.
    pub fn connections(&self, world: &World, plan: &Plan) -> Arc<Connections> {
        known(&self.connections, (plan.connections.clone(), Grid::of(world)), |(connections, _)| {
            Arc::new(Connections::new(world, &index_of(&Mono::<f64>::optics(world, SEED, 0)), connections))
        })
    }

    /// Coarse tables of these screens.
    pub fn screens(&self, world: &World, screens: &[Screen]) -> Receivers<Mono> {
        let optics = Mono::<f64>::optics(world, SEED, 0);
        let none = Receivers::coarse(world, &optics, &[]);
        screens.iter().fold(none, |all, screen| {
            let one = known(&self.screens, screen.clone(), |screen| {
                Arc::new(Receivers::coarse(world, &optics, std::slice::from_ref(screen)))
            });
            all.and(&one)
        })
    }
}

/// What was made from `key`, now or before.
fn known<K: PartialEq, V: Clone>(all: &Known<K, V>, key: K, make: impl FnOnce(&K) -> V) -> V {
    let before = all.borrow().iter().find(|(known, _)| *known == key).map(|(_, value)| value.clone());
    before.unwrap_or_else(|| {
        let value = make(&key);
        all.borrow_mut().push((key, value.clone()));
        value
    })
}
