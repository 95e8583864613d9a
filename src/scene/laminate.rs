//! Thin films on faces of solids: a polariser, a retarder or a picture that is laminated to glass.
//!
//! Such a face is two things: the surface of the glass, which refracts, and the film, which does not. So the face becomes a polished one,
//! and the film a part of its own that [lies in](FilmBase) the glass, just below that surface. What stands on the other side of the face
//! (air, or a solid that touches it) then decides how light is refracted, and the film acts on light that runs in the glass, as one does
//! that is glued between.

use super::{Face, Finish, Mesh, Part, Scene};
use eyebox_base::error::Result;
use eyebox_base::ids::MeshId;
use eyebox_base::{Error, Shared, Where};

/// The face of a solid in which a film lies: the film has the same points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct FilmBase {
    /// Number of the solid in the scene, and of its face.
    pub part: usize,
    pub face: usize,
}

/// What a finish is on the face of a solid.
enum OnGlass {
    /// What it says: the surface itself.
    Surface,
    /// A film in a polished face.
    Film,
    /// It scatters about the direction in which light arrives, and knows no other one behind the face.
    Unbent,
    /// Light comes back from it.
    Mirror,
}

impl Scene {
    /// Parts films from the solids that they are laminated to. Errors: what would have to refract and cannot.
    pub fn laminate(&mut self) -> Result<()> {
        for part in 0..self.parts.len() {
            let is_solid = self.parts[part].medium.is_some();
            let is_glass = is_solid && self.parts[part].faces.iter().any(refracts);
            for face in 0..self.parts[part].faces.len() {
                let own = &self.parts[part].faces[face];
                let fault = |what: &str| {
                    let at = Where::Part { path: self.parts[part].path.clone(), face: Some(face) };
                    Error::new(at, what)
                };
                match (own.is_slide(), self.on_glass(&own.finish)) {
                    (true, OnGlass::Mirror) => {
                        return Err(fault("a slide on a mirror: light would cross the picture and not come back")
                            .expected("a slide on a sheet or on glass, or a mirror alone"));
                    }
                    (true, OnGlass::Surface | OnGlass::Film | OnGlass::Unbent) | (false, OnGlass::Film) if is_solid => {
                        self.part_film(part, face);
                    }
                    (false, OnGlass::Unbent) if is_glass => {
                        return Err(fault(
                            "this finish lets light through and does not refract it, on a solid that does",
                        )
                        .expected("`rough` (ground glass) or `polished`, or a part of its own without a medium"));
                    }
                    (true | false, OnGlass::Surface | OnGlass::Film | OnGlass::Mirror | OnGlass::Unbent) => {}
                }
            }
        }
        Ok(())
    }

    /// Lays films where the faces that they lie in are now: parts and faces of a scene may be moved.
    pub fn realign_films(&mut self) {
        for film in 0..self.parts.len() {
            let Some(FilmBase { part, face }) = self.parts[film].film_in else { continue };
            let (Some(base), Some(own)) = (self.parts.get(part), self.parts.get(film)) else { continue };
            let (to_world, shape) = (base.to_world, base.faces.get(face).map(|face| face.shape.clone()));
            let mesh = self.meshes.get(base.mesh.index()).and_then(|mesh| of_face(mesh, face));
            let mesh = mesh.filter(|mesh| self.meshes.get(own.mesh.index()).is_none_or(|own| **own != *mesh));
            let mesh = mesh.map(|mesh| {
                self.meshes.push(Shared::from(mesh));
                MeshId::from_index(self.meshes.len() - 1)
            });
            let own = &mut self.parts[film];
            (own.to_world, own.mesh) = (to_world, mesh.unwrap_or(own.mesh));
            own.faces.iter_mut().zip(shape).for_each(|(face, shape)| face.shape = shape);
        }
    }

    fn on_glass(&self, finish: &Finish) -> OnGlass {
        match *finish {
            Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. }
            | Finish::ReflectivePolariser { .. } => OnGlass::Film,
            Finish::Gauss { transmittance, .. } | Finish::CosM { transmittance, .. } if transmittance > 0.0 => {
                OnGlass::Unbent
            }
            Finish::Surface { surface } if self.surfaces[surface.index()].transmission.factor > 0.0 => OnGlass::Unbent,
            Finish::MirrorMetal { .. } | Finish::MirrorIdeal { .. } => OnGlass::Mirror,
            Finish::None
            | Finish::Polished
            | Finish::Rough { .. }
            | Finish::Lambert { .. }
            | Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Abg { .. }
            | Finish::Measured { .. }
            | Finish::Grating { .. }
            | Finish::Surface { .. }
            | Finish::Absorber => OnGlass::Surface,
        }
    }

    /// Makes the film on a face a part of its own.
    fn part_film(&mut self, part: usize, face: usize) {
        let Some(own) = self.meshes.get(self.parts[part].mesh.index()).and_then(|mesh| of_face(mesh, face)) else {
            return;
        };
        let mesh = MeshId::from_index(self.meshes.len());
        self.meshes.push(Shared::from(own));
        let base = &mut self.parts[part];
        let glass = &mut base.faces[face];
        let slide = glass.slide.filter(|_| glass.emitter.is_none());
        let film = Face { coating: None, tint: None, sensor: None, emitter: None, slide, ..glass.clone() };
        // A picture lies on what the face is beside it, if that lets light through.
        let below = if film.slide.is_some() && refracts(glass) { glass.finish } else { Finish::Polished };
        (glass.finish, glass.slide) = (below, glass.slide.filter(|_| slide.is_none()));
        let named = |of: &str| format!("{of}.faces[{face}]");
        let film = Part {
            name: named(&base.name),
            path: named(&base.path),
            mesh,
            to_world: base.to_world,
            medium: None,
            priority: base.priority,
            faces: vec![film],
            materials: base.materials.get(face).cloned().into_iter().collect(),
            film_in: Some(FilmBase { part, face }),
        };
        self.parts.push(film);
    }
}

/// Whether light that goes through a face is refracted there.
fn refracts(face: &Face) -> bool {
    match face.finish {
        Finish::Polished | Finish::Rough { .. } | Finish::Grating { .. } => true,
        Finish::None
        | Finish::MirrorMetal { .. }
        | Finish::MirrorIdeal { .. }
        | Finish::Lambert { .. }
        | Finish::Gauss { .. }
        | Finish::CosM { .. }
        | Finish::Abg { .. }
        | Finish::Measured { .. }
        | Finish::Polariser { .. }
        | Finish::Retarder { .. }
        | Finish::WavePlate { .. }
        | Finish::CircularPolariser { .. }
        | Finish::ReflectivePolariser { .. }
        | Finish::Surface { .. }
        | Finish::Absorber => false,
    }
}

/// The mesh of one face, its triangles in the same order; none if there is no such face.
fn of_face(mesh: &Mesh, face: usize) -> Option<Mesh> {
    let triangles = mesh.triangles.get(mesh.faces.get(face)?.triangles())?;
    let mut kept: Vec<u32> = triangles.as_flattened().to_vec();
    kept.sort_unstable();
    kept.dedup();
    let new = |old: &u32| kept.partition_point(|k| k < old) as u32;
    fn pick<T: Copy>(all: &[T], kept: &[u32]) -> Vec<T> {
        kept.iter().filter_map(|old| all.get(*old as usize).copied()).collect()
    }
    Some(Mesh {
        name: mesh.name.clone(),
        positions: pick(&mesh.positions, &kept),
        normals: pick(&mesh.normals, &kept),
        uvs: pick(&mesh.uvs, &kept),
        second_uvs: pick(&mesh.second_uvs, &kept),
        tangents: pick(&mesh.tangents, &kept),
        colors: pick(&mesh.colors, &kept),
        triangles: triangles.iter().map(|corners| corners.each_ref().map(new)).collect(),
        faces: vec![super::FaceRange { first: 0, count: triangles.len() as u32 }],
    })
}
