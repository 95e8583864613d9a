//! Ray intersection with everything that light can meet: f32 hierarchies propose candidates, f64 decides on exact
//! surfaces or triangles.
//!
//! Two levels: a tree over parts in the world, and per distinct mesh a tree in its own coordinates. The world's origin
//! is moved to the middle of the scene, so an assembly 10 km away is traced like one at the origin. There are no
//! absolute epsilons: a ray that starts on a plane leaves it out, one that starts on a curved exact surface divides the
//! known root out, and only on a faceted one rounding decides how near is too near.

mod bound;
pub mod bvh; // boxes of eight to a node, and the walk through them
mod cast;
mod closest_hit;
mod coverage;
pub mod curved;
pub mod exact;
mod films;
mod grid;
mod instance;
pub mod interface_derivatives;
mod local_ray;
mod patch;
mod prepare;
mod solid;
mod surface;
mod touching;
mod triangle;

#[cfg(test)]
mod brute_tests;
#[cfg(test)]
mod hostile_tests;
#[cfg(test)]
mod leave_tests;
#[cfg(test)]
mod plain_tests;
#[cfg(any(test, feature = "testing"))]
pub mod scenes;
#[cfg(test)]
mod tests;

use bound::Bounds;
use bvh::top::Top;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{Mesh, Part, Scene};
use films::Films;
use glam::{DAffine3, DVec3};
use instance::Instance;
use solid::Solid;
use std::collections::HashMap;

/// A ray in the recentred world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// m.
    pub origin: DVec3,
    /// Unit.
    pub dir: DVec3,
    /// The surface that the origin lies on.
    pub from: Option<Site>,
}

/// A place of the scene's surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Site {
    pub part: u32,
    /// Face of the part.
    pub face: u32,
    /// Triangle of the part's mesh; of an exact face any.
    pub triangle: u32,
}

impl Site {
    /// Both lie on one face.
    pub fn is_on_face_of(self, other: Site) -> bool {
        (self.part, self.face) == (other.part, other.face)
    }
}

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// m along the ray.
    pub t: f64,
    pub site: Site,
    /// In the recentred world, m.
    pub point: DVec3,
    /// In mesh units, on the exact surface.
    pub local: DVec3,
    /// Unit normal of the surface, outward of the solid by the mesh's winding, world.
    pub normal: DVec3,
    /// Unit normal for optics, in the hemisphere of `normal`: the same on exact surfaces, interpolated on meshes.
    pub shading: DVec3,
}

/// All surfaces of a scene, ready for rays.
#[derive(Debug)]
pub struct Geometry {
    origin: DVec3,
    /// Of all parts, mesh → recentred world.
    to_world: Vec<DAffine3>,
    solids: Vec<Solid>,
    /// In the order of the slots of `top`; films after them.
    instances: Vec<Instance>,
    /// Per part: its slot, `u32::MAX` for a part that is not there.
    slots: Vec<u32>,
    films: Films,
    top: Top,
}

/// What was made of the scene's parts, where those stand, and a box around all of it and the eye.
struct Placed<T> {
    made: Vec<T>,
    /// Parts that are there, and what of `made` they are.
    placed: Vec<(u32, usize)>,
    spread: Bounds,
}

/// Makes something of each part that is there, once for those that are alike. `bounds`: of what is made, mesh units.
fn place<T>(
    scene: &Scene,
    make: impl Fn(&Mesh, &Part, &[prepare::Traced]) -> Result<Option<T>>,
    bounds: impl Fn(&T) -> Bounds,
) -> Result<Placed<T>> {
    let mut made: Vec<T> = Vec::new();
    let mut known: HashMap<Vec<u64>, Option<usize>> = HashMap::new();
    let mut placed: Vec<(u32, usize)> = Vec::new();
    for (index, part) in scene.parts.iter().enumerate() {
        let fault = |what: String| Error::new(Where::part(&part.path), what);
        let mesh = scene.meshes.get(part.mesh.index());
        let mesh = mesh.ok_or_else(|| fault(format!("mesh {} of {}", part.mesh.0, scene.meshes.len())))?;
        if part.faces.len() != mesh.faces.len() {
            return Err(fault(format!("{} faces for a mesh with {}", part.faces.len(), mesh.faces.len())));
        }
        let faces = prepare::traced(part);
        instance::check(part, &faces)?;
        let key = prepare::key(part.mesh.index(), &faces);
        let own = match known.get(&key) {
            Some(own) => *own,
            None => {
                let own = make(mesh, part, &faces)?.map(|own| {
                    made.push(own);
                    made.len() - 1
                });
                known.insert(key, own);
                own
            }
        };
        placed.extend(own.map(|own| (index as u32, own)));
    }
    if placed.is_empty() {
        return Err(Error::new(Where::Nowhere, "nothing in the scene has a surface that light meets")
            .expected("at least one face with a finish, an emitter or a slide")
            .code(Code::NothingToTrace));
    }
    if !scene.eye.position.is_finite() {
        return Err(
            Error::new(Where::Nowhere, format!("the eye is at {}", scene.eye.position)).code(Code::EyeImpossible)
        );
    }
    let spread = placed.iter().fold(Bounds::of([scene.eye.position]), |all, (part, own)| {
        all.join(bounds(&made[*own]).map(&scene.parts[*part as usize].to_world))
    });
    if !spread.is_finite() || !spread.half().is_finite() {
        return Err(Error::new(Where::Nowhere, "the scene is too large to be traced"));
    }
    Ok(Placed { made, placed, spread })
}

impl Geometry {
    /// Prepares a scene. Faults: a transform that is not finite or flattens its part, an exact face of a part that is
    /// scaled unevenly, a shape that misses its mesh, indices out of range, vertices that are not finite, nothing to
    /// trace at all.
    pub fn build(scene: &Scene) -> Result<Geometry> {
        let Placed { made: solids, placed, spread } = place(scene, prepare::solid, |solid| solid.bounds)?;
        let origin = spread.centre();
        let recentre = |to_world: DAffine3| DAffine3 { translation: to_world.translation - origin, ..to_world };
        let to_world: Vec<DAffine3> = scene.parts.iter().map(|part| recentre(part.to_world)).collect();
        let instances: Vec<Instance> = placed
            .iter()
            .map(|(part, solid)| {
                let solid_bounds = solids[*solid].bounds;
                let medium = scene.parts[*part as usize].medium.is_some();
                Instance::new(
                    *part,
                    *solid,
                    medium,
                    to_world[*part as usize],
                    solid_bounds,
                    spread.half().max_element(),
                )
            })
            .collect();
        // Rays meet films at the surface of what they lie in.
        let films = Films::of(scene);
        let (unmet, met) = instances.into_iter().partition::<Vec<_>, _>(|i| films.base(i.part).is_some());
        let boxes: Vec<Bounds> = met.iter().map(|i| i.bounds).collect();
        let many = || Error::new(Where::Nowhere, "the scene has too many parts").expected("less than 2^32");
        let (top, order) = Top::build(&boxes).ok_or_else(many)?;
        let met = order.iter().filter_map(|i| met.get(*i as usize).cloned());
        let instances: Vec<Instance> = met.chain(unmet).collect();
        let mut slots = vec![u32::MAX; scene.parts.len()];
        for (slot, instance) in instances.iter().enumerate() {
            slots[instance.part as usize] = slot as u32;
        }
        Ok(Geometry { origin, to_world, solids, instances, slots, films, top })
    }

    /// The faults of [`Geometry::build`], without what makes it large: no triangle is copied and no tree is built.
    pub fn check(scene: &Scene) -> Result<()> {
        place(scene, prepare::check, |bounds| *bounds).map(|_| ())
    }

    /// The point of the scene's world that is (0, 0, 0) here: the middle of its parts and the eye.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Mesh units → recentred world of a part.
    ///
    /// # Panics
    /// If the scene has no such part.
    pub fn part_to_world(&self, part: u32) -> DAffine3 {
        self.to_world[part as usize]
    }

    /// Lower and upper corner of a box around all surfaces, recentred world.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let bounds = self.top.bounds();
        (bounds.lo, bounds.hi)
    }

    /// The parts with a medium that the point is inside of, ascending. A part contains the point if most of several
    /// rays meet it from inside first, so a missing side or a hit on a seam does not turn it.
    pub fn solids_containing(&self, p: DVec3) -> Vec<u32> {
        self.solids_around(p, None)
    }

    /// The same if a part were not there.
    pub fn solids_around(&self, p: DVec3, without: Option<u32>) -> Vec<u32> {
        let mut parts: Vec<u32> = self
            .instances
            .iter()
            .filter(|instance| instance.medium && instance.bounds.contains(p) && Some(instance.part) != without)
            .filter(|instance| instance.contains(&self.solids[instance.solid], p))
            .map(|instance| instance.part)
            .collect();
        parts.sort_unstable();
        parts
    }
}
