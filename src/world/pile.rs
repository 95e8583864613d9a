//! What light meets at one place, one after the other: a film in glass, the surface of the glass, the film in the glass that touches it,
//! what covers it.

use super::World;
use super::contact::{Joint, Touching};
use super::geometry::{Geometry, Hit, Site};
use arrayvec::ArrayVec;
use glam::DVec3;

/// All that lies on each other where a ray arrives.
#[derive(Debug)]
pub struct Pile {
    /// In the order in which light that runs along the ray meets them; never empty.
    pub hits: ArrayVec<Hit, 4>,
    /// The interface of two solids among them, and the face of the second.
    joint: Option<(Site, Touching)>,
}

impl Pile {
    /// What lies at a hit of a ray along `dir`.
    pub fn at(world: &World, hit: &Hit, dir: DVec3) -> Pile {
        let geometry = &world.geometry;
        let hit = Hit { site: geometry.below_film(hit.site), ..*hit };
        let mut hits = ArrayVec::new();
        let mut push = |hit: Hit| {
            let _ = hits.try_push(hit);
        };
        let film_of = |glass: &Hit| geometry.film_at(glass.site).map(|site| Hit { site, ..*glass });
        // A film is on the inside of its face.
        let leaves = |glass: &Hit| dir.dot(glass.normal) > 0.0;
        let joint = match world.contacts.joint(geometry, &world.solids, &hit) {
            Some(Joint { hit, other, second }) => {
                let sides = [hit, second];
                sides.iter().filter(|side| leaves(side)).filter_map(film_of).for_each(&mut push);
                push(hit);
                sides.iter().filter(|side| !leaves(side)).filter_map(film_of).for_each(&mut push);
                Some((hit.site, other))
            }
            None => {
                let covered = world.contacts.covered(geometry, &hit, dir);
                for hit in covered.as_ref().map_or(std::slice::from_ref(&hit), |both| both.as_slice()) {
                    let film = film_of(hit);
                    film.filter(|_| leaves(hit)).into_iter().for_each(&mut push);
                    push(*hit);
                    film.filter(|_| !leaves(hit)).into_iter().for_each(&mut push);
                }
                None
            }
        };
        Pile { hits, joint }
    }

    /// The place in the pile of the face at a site; the first if it is none of them.
    pub fn place_of(&self, site: Site) -> usize {
        self.hits.iter().position(|hit| hit.site.is_on_face_of(site)).unwrap_or(0)
    }

    /// The second face of the interface of two solids, if that is at this place.
    pub fn touching_at(&self, place: usize) -> Option<Touching> {
        let (first, other) = self.joint.as_ref()?;
        self.hits.get(place).filter(|hit| hit.site == *first).map(|_| *other)
    }

    /// The other surface here that a ray which leaves must not meet again.
    pub fn beside(&self, geometry: &Geometry, place: usize) -> Option<Site> {
        let own = geometry.below_film(self.hits.get(place)?.site);
        let met = self.hits.iter().map(|hit| geometry.below_film(hit.site));
        let second = self.joint.as_ref().map(|(_, other)| other.site);
        met.chain(second).find(|site| !site.is_on_face_of(own))
    }
}
