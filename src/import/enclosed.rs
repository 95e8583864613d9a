//! Cameras in the midst of a body, and in that of a light: assets that nobody has looked at have them at the origin, where the
//! geometry is.

use super::assembly::{Assembly, LightForm, LightSource};
use super::frames;
use eyebox_base::Shared;
use eyebox_scene::{Finish, Mesh, Part, StandardSurface};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// What an asset brings before its lights are made.
pub struct Bodies<'a> {
    pub assembly: &'a Assembly,
    pub unit_m: f64,
    /// Their meshes are the asset's.
    pub parts: &'a [Part],
    pub surfaces: &'a [Shared<StandardSurface>],
}

impl Bodies<'_> {
    /// The part that closes a point (world, m) off from all light: no face lets light through or shines, and no lamp is inside.
    pub fn about(&self, point: DVec3) -> Option<&str> {
        let dark = |part: &&Part| {
            let holds = |point: DVec3| {
                let mesh = self.assembly.meshes.get(part.mesh.index()).map(|source| &source.mesh);
                mesh.is_some_and(|mesh| encloses(mesh, &part.to_world, point))
            };
            self.is_opaque(part) && holds(point) && !self.lamps().any(holds)
        };
        self.parts.iter().find(dark).map(|part| part.path.as_str())
    }

    /// Whether none of its faces lets light through or shines, as ordinary materials say.
    fn is_opaque(&self, part: &Part) -> bool {
        let surface =
            |finish: &Finish| finish.surface().and_then(|id| self.surfaces.get(id.index()).map(|look| &**look));
        let opaque = |look: &StandardSurface| {
            !(look.lets_through() || look.diffuse_transmission.factor > 0.0) && look.emission.is_none()
        };
        part.faces.iter().all(|face| face.emitter.is_none() && surface(&face.finish).is_some_and(opaque))
    }

    /// A point of each lamp that stands somewhere, world, m.
    fn lamps(&self) -> impl Iterator<Item = DVec3> + '_ {
        let stands = |light: &&LightSource| !matches!(light.form, LightForm::Distant { .. } | LightForm::Dome { .. });
        let lights = self.assembly.lights.iter().filter(stands).filter_map(|light| {
            let node = self.assembly.nodes.get(light.node)?;
            Some(frames::in_metres(&node.to_world, self.unit_m, &self.assembly.axes).translation)
        });
        let shining = self.parts.iter().filter(|part| part.faces.iter().any(|face| face.emitter.is_some()));
        let glowing = shining.filter_map(|part| {
            let source = self.assembly.meshes.get(part.mesh.index())?;
            let vertex = source.mesh.positions.first()?;
            Some(part.to_world.transform_point3(DVec3::from_array(vertex.map(f64::from))))
        });
        lights.chain(glowing)
    }
}

/// Whether a point lies within a closed mesh: its triangles cover at least half of all directions once more from the one side than
/// from the other (generalised winding number, A. Jacobson et al., ACM Trans. Graph. 32, 2013).
fn encloses(mesh: &Mesh, to_world: &DAffine3, point: DVec3) -> bool {
    let local = to_world.inverse().transform_point3(point);
    let place = |vertex: &[f32; 3]| DVec3::from_array(vertex.map(f64::from));
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let grown = |(low, high): (DVec3, DVec3), vertex: &[f32; 3]| (low.min(place(vertex)), high.max(place(vertex)));
    let (low, high) = mesh.positions.iter().fold(start, grown);
    if !(local.cmpge(low).all() && local.cmple(high).all()) {
        return false;
    }
    let corner = |index: u32| mesh.positions.get(index as usize).map(|vertex| place(vertex) - local);
    let seen = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(corner);
        Some(solid_angle([a?, b?, c?]))
    };
    let all: f64 = mesh.triangles.iter().filter_map(seen).sum();
    all.abs() >= 2.0 * PI
}

/// Of a triangle from the origin, signed, sr (A. Van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30, 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_scene::light_shapes::sphere;

    #[test]
    fn a_closed_body_holds_what_lies_within_whatever_its_frame() {
        let to_world = DAffine3::from_scale(DVec3::new(1.0, -2.0, 3.0));
        let mesh = sphere(1.0);
        let holds = |at: [f64; 3]| encloses(&mesh, &to_world, DVec3::from_array(at));
        assert!(holds([0.0; 3]) && holds([0.5, -1.0, 1.5]) && holds([0.0, 1.9, 0.0]));
        assert!(!holds([0.7, -1.4, 2.1]) && !holds([0.0, 2.1, 0.0]) && !holds([f64::NAN; 3]));
        // Half of a sphere does not close the middle off, nor does what its triangles are turned to both sides of.
        let mut half = mesh.clone();
        half.triangles.truncate(half.triangles.len() / 2 - 96);
        assert!(!encloses(&half, &DAffine3::IDENTITY, DVec3::ZERO));
        // A matrix that flattens holds nothing.
        assert!(!encloses(&mesh, &DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)), DVec3::ZERO));
    }
}
