//! Where an estimator puts the light of a path: the plan's ownership as a table.

use eyebox_base::ids::GroupId;
use eyebox_base::lpe::{LpeState, Product, Source, Takes};
use eyebox_base::path::{Class, Event, Trail};
use eyebox_film::accumulate::PlaneKey;
use eyebox_film::plan::{Estimator, Plan, Verdict};
use std::sync::Arc;

/// The planes that one estimator fills, and which path goes where.
#[derive(Debug, Clone)]
pub struct Ownership {
    pub planes: Vec<PlaneKey>,
    /// `[group][class][has_broad]` → share: a group's light in a layer.
    table: Vec<Option<usize>>,
    groups: usize,
    /// Per group: of its vision paths we have what connection leaves, or are connection.
    connected: Vec<bool>,
    /// How light path expressions part shares; none: a share is a plane.
    parted: Option<Parted>,
}

#[derive(Debug, Clone)]
struct Parted {
    sieve: Arc<Product>,
    /// Share → what is taken of it, and the planes that hold it.
    planes: Vec<Vec<(Takes, usize)>>,
}

impl Ownership {
    pub fn new(plan: &Plan, groups: usize, estimator: Estimator) -> Self {
        let connected = |group| matches!(plan.row(group, Class::Vision).verdict, Verdict::Connect { .. });
        let connected = (0..groups).map(|group| connected(GroupId::from_index(group))).collect();
        let key = |group: GroupId, class: Class, broad: bool| {
            let layer = plan.layer(estimator, group, class, broad);
            plan.computes(estimator, group, class, broad).then_some(PlaneKey { layer, group, takes: 0 })
        };
        Ownership { connected, ..Ownership::by(groups, &key) }
    }

    /// The plane that `key` names for the paths of each group and class, with a broad scatterer among them or not. Nothing
    /// of it is connected.
    pub fn by(groups: usize, key: &dyn Fn(GroupId, Class, bool) -> Option<PlaneKey>) -> Self {
        let mut planes: Vec<PlaneKey> = Vec::new();
        let mut table = Vec::with_capacity(groups * Class::ALL.len() * 2);
        for group in (0..groups).map(GroupId::from_index) {
            for class in Class::ALL {
                for broad in [false, true] {
                    // Without a scatterer there is no broad one; the answer must not open a plane for it.
                    let possible = !(broad && class == Class::Vision);
                    let plane = possible.then(|| key(group, class, broad)).flatten().map(|key| {
                        planes.iter().position(|&plane| plane == key).unwrap_or_else(|| {
                            planes.push(key);
                            planes.len() - 1
                        })
                    });
                    table.push(plane);
                }
            }
        }
        Ownership { planes, table, groups, connected: vec![false; groups], parted: None }
    }

    /// Whether connection has the vision paths of a group that it can solve for.
    pub fn is_connected(&self, group: GroupId) -> bool {
        self.connected[group.index()]
    }

    /// The same with a plane for whatever the expressions of `sieve` take of a share.
    #[must_use]
    pub fn parted_by(self, sieve: Option<&Arc<Product>>) -> Ownership {
        let Some(sieve) = sieve else { return self };
        let (mut planes, mut parts) = (Vec::new(), vec![Vec::new(); self.planes.len()]);
        for group in 0..self.groups {
            for class in Class::ALL {
                for broad in [false, true] {
                    let Some(share) = self.share(GroupId::from_index(group), class, broad) else { continue };
                    for takes in sieve.possible(group, class, broad) {
                        if !parts[share].iter().any(|(own, _)| *own == takes) {
                            parts[share].push((takes, planes.len()));
                            planes.push(PlaneKey { takes, ..self.planes[share] });
                        }
                    }
                }
            }
        }
        // A share that no path of the scene has keeps its plane.
        for (part, key) in parts.iter_mut().zip(&self.planes).filter(|(part, _)| part.is_empty()) {
            part.push((0, planes.len()));
            planes.push(*key);
        }
        Ownership { planes, parted: Some(Parted { sieve: sieve.clone(), planes: parts }), ..self }
    }

    /// The plane of a share's path of which expressions take what `takes` says.
    #[inline]
    pub fn plane(&self, share: usize, takes: impl FnOnce(&Product) -> Takes) -> usize {
        let Some(Parted { sieve, planes }) = &self.parted else { return share };
        let takes = takes(sieve);
        let parts = &planes[share];
        let plane = parts.iter().find(|(own, _)| *own == takes).or(parts.first());
        debug_assert!(parts.iter().any(|(own, _)| *own == takes), "events that the scene cannot cause");
        plane.map_or(0, |(_, plane)| *plane)
    }

    /// The plane of a path from the eye that has met a lamp of a group.
    #[inline]
    pub fn plane_from_eye(&self, share: usize, told: LpeState, group: GroupId, source: Source) -> usize {
        self.plane(share, |sieve| sieve.takes(told, sieve.lamp(group.index(), source)))
    }

    /// The share of a complete path, or none if another estimator owns it.
    pub fn share(&self, group: GroupId, class: Class, has_broad: bool) -> Option<usize> {
        self.table[(group.index() * Class::ALL.len() + class as usize) * 2 + usize::from(has_broad)]
    }

    /// The share of a path walked from the eye.
    pub fn from_eye(&self, group: GroupId, trail: Trail) -> Option<usize> {
        self.share(group, trail.class_from_eye(), trail.has_broad())
    }

    /// The share of a path walked from the lamp.
    pub fn from_lamp(&self, group: GroupId, trail: Trail) -> Option<usize> {
        self.share(group, trail.class_from_lamp(), trail.has_broad())
    }

    /// Whether any path that starts (from the eye) with `trail` and has at least one more vertex or ends now is ours.
    pub fn reachable_from_eye(&self, trail: Trail) -> bool {
        self.reachable(trail, |route, group, trail| route.from_eye(group, trail))
    }

    /// The same from the lamp of `group`.
    pub fn reachable_from_lamp(&self, trail: Trail, group: GroupId) -> bool {
        self.reachable(trail, |route, other, trail| if other == group { route.from_lamp(other, trail) } else { None })
    }

    fn reachable(&self, trail: Trail, share: impl Fn(&Self, GroupId, Trail) -> Option<usize>) -> bool {
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
            .any(|group| trails.iter().any(|&trail| share(self, group, trail).is_some()))
    }
}

/// [`Ownership::reachable_from_eye`] for every state of the automaton, so that asking costs nothing per ray.
#[derive(Debug, Clone)]
pub struct Reach(Vec<bool>);

impl Reach {
    pub fn from_eye(route: &Ownership) -> Self {
        Reach(Trail::states().map(|trail| route.reachable_from_eye(trail)).collect())
    }
    pub fn from_lamp(route: &Ownership, group: GroupId) -> Self {
        Reach(Trail::states().map(|trail| route.reachable_from_lamp(trail, group)).collect())
    }
    pub fn allows(&self, trail: Trail) -> bool {
        self.0[trail.state()]
    }
}
