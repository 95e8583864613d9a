//! Where an estimator puts the light of a path: the plan's ownership as a table.

use crate::base::ids::GroupId;
use crate::base::path::{Class, Event, Trail};
use crate::film::accumulate::PlaneKey;
use crate::film::layer::Layer;
use crate::film::plan::{Estimator, Plan};

/// The planes that one estimator fills, and which path goes where.
#[derive(Debug, Clone)]
pub struct Route {
    pub planes: Vec<PlaneKey>,
    /// `[group][class][has_broad]` → plane.
    table: Vec<Option<usize>>,
    groups: usize,
}

impl Route {
    pub fn new(plan: &Plan, groups: usize, estimator: Estimator) -> Self {
        let mut planes: Vec<PlaneKey> = Vec::new();
        let mut table = Vec::with_capacity(groups * Class::ALL.len() * 2);
        for group in (0..groups).map(GroupId::from_index) {
            for class in Class::ALL {
                for broad in [false, true] {
                    // Without a scatterer there is no broad one; the plan's answer must not open a plane for it.
                    let possible = !(broad && class == Class::Vision);
                    let plane = (possible && plan.computes(estimator, group, class, broad)).then(|| {
                        let key = PlaneKey { layer: Layer::of(class, estimator), group };
                        planes.iter().position(|&plane| plane == key).unwrap_or_else(|| {
                            planes.push(key);
                            planes.len() - 1
                        })
                    });
                    table.push(plane);
                }
            }
        }
        Route { planes, table, groups }
    }

    /// The plane for a complete path, or none if another estimator owns it.
    pub fn plane(&self, group: GroupId, class: Class, has_broad: bool) -> Option<usize> {
        self.table[(group.index() * Class::ALL.len() + class as usize) * 2 + usize::from(has_broad)]
    }

    /// The plane for a path walked from the eye.
    pub fn from_eye(&self, group: GroupId, trail: Trail) -> Option<usize> {
        self.plane(group, trail.class_from_eye(), trail.has_broad())
    }

    /// The plane for a path walked from the lamp.
    pub fn from_lamp(&self, group: GroupId, trail: Trail) -> Option<usize> {
        self.plane(group, trail.class_from_lamp(), trail.has_broad())
    }

    /// Whether any path that starts (from the eye) with `trail` and has at least one more vertex or ends now is ours.
    pub fn reachable_from_eye(&self, trail: Trail) -> bool {
        self.reachable(trail, |route, group, trail| route.from_eye(group, trail))
    }

    /// The same from the lamp of `group`.
    pub fn reachable_from_lamp(&self, trail: Trail, group: GroupId) -> bool {
        self.reachable(trail, |route, other, trail| if other == group { route.from_lamp(other, trail) } else { None })
    }

    fn reachable(&self, trail: Trail, plane: impl Fn(&Self, GroupId, Trail) -> Option<usize>) -> bool {
        // The automaton saturates: three more events reach every state that can be reached.
        const EVENTS: [Event; 3] = [Event::Specular, Event::Glossy, Event::Diffuse];
        let mut trails = vec![trail];
        let mut first = 0;
        for _ in 0..3 {
            let last = trails.len();
            for index in first..last {
                for event in EVENTS {
                    let next = trails[index].then(event);
                    if !trails.contains(&next) {
                        trails.push(next);
                    }
                }
            }
            first = last;
        }
        (0..self.groups)
            .map(GroupId::from_index)
            .any(|group| trails.iter().any(|&trail| plane(self, group, trail).is_some()))
    }
}

/// [`Route::reachable_from_eye`] for every state of the automaton, so that asking costs nothing per ray.
#[derive(Debug, Clone)]
pub struct Reach(Vec<bool>);

impl Reach {
    pub fn from_eye(route: &Route) -> Self {
        Reach(Trail::states().map(|trail| route.reachable_from_eye(trail)).collect())
    }
    pub fn from_lamp(route: &Route, group: GroupId) -> Self {
        Reach(Trail::states().map(|trail| route.reachable_from_lamp(trail, group)).collect())
    }
    pub fn allows(&self, trail: Trail) -> bool {
        self.0[trail.state()]
    }
}
