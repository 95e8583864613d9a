//! A design as it would be made: one value for each parameter.

use super::parameter::{Change, Parameter};
use super::tuning::apply::UPRIGHT;
use eyebox_base::Error;
use eyebox_base::Shared;
use eyebox_base::error::Result;
use eyebox_base::ids::{MediumId, MeshId};
use eyebox_scene::{Dispersion, Mesh, Part, Scene};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::HashSet;

/// Changes a scene by the parameters' values (m, rad, a share of the radius, index), in their order.
/// Errors: a change that leaves nothing sensible (an index of 0, a radius of 0), with the parameter.
pub fn apply(scene: &mut Scene, parameters: &[Parameter], values: &[f64]) -> Result<()> {
    // Faces first, in the axes of the design: parts take them along.
    let (parts, faces): (Vec<_>, Vec<_>) = parameters
        .iter()
        .zip(values)
        .filter(|(_, value)| **value != 0.0)
        .partition(|(parameter, _)| matches!(parameter.change, Change::Decenter { .. } | Change::Tilt { .. }));
    for (parameter, value) in faces.into_iter().chain(parts) {
        match parameter.change {
            Change::Decenter { axis } => {
                let shift = DVec3::AXES[axis] * *value;
                displace(scene, &parameter.parts, DAffine3::from_translation(shift));
            }
            Change::Tilt { axis, about } => {
                let turn = DQuat::from_axis_angle(DVec3::AXES[axis], *value);
                displace(scene, &parameter.parts, about_point(turn, about));
            }
            Change::Index => index(scene, parameter, *value)?,
            Change::Radius { face } => {
                let shape =
                    of(scene, parameter, face).and_then(|(part, _)| part.faces[face].shape.with_radius(1.0 + value));
                let shape = shape.filter(|_| 1.0 + value > 0.0).ok_or_else(|| nonsense(parameter, *value))?;
                for part in &parameter.parts {
                    scene.parts[*part].faces[face].shape = shape.clone();
                }
            }
            Change::Thickness { face } => {
                let motion = of(scene, parameter, face).and_then(|(part, mesh)| {
                    let (_, normal) = face_frame(part, mesh, face)?;
                    Some(DAffine3::from_translation(normal * *value))
                });
                move_face(scene, parameter, face, motion.ok_or_else(|| nonsense(parameter, *value))?);
            }
            Change::Wedge { face, axis } => {
                let motion = of(scene, parameter, face).and_then(|(part, mesh)| {
                    let (middle, normal) = face_frame(part, mesh, face)?;
                    let level = DVec3::Y.cross(normal);
                    // Of a face that looks up or down there is no horizontal but by rounding.
                    let level = if level.length() < UPRIGHT { DVec3::X - normal * normal.x } else { level };
                    let level = level.try_normalize()?;
                    let about = [level, normal.cross(level)][axis];
                    Some(about_point(DQuat::from_axis_angle(about, *value), middle))
                });
                move_face(scene, parameter, face, motion.ok_or_else(|| nonsense(parameter, *value))?);
            }
        }
    }
    scene.realign_films();
    Ok(())
}

fn nonsense(parameter: &Parameter, value: f64) -> Box<Error> {
    Error::new(parameter.at.clone(), format!("{} of {value} leaves nothing", parameter.name))
        .expected("a smaller tolerance")
}

fn about_point(turn: DQuat, point: DVec3) -> DAffine3 {
    DAffine3::from_translation(point) * DAffine3::from_quat(turn) * DAffine3::from_translation(-point)
}

/// Moves parts together, each as it now stands.
fn displace(scene: &mut Scene, parts: &[usize], motion: DAffine3) {
    for part in parts {
        let part = &mut scene.parts[*part];
        part.to_world = motion * part.to_world;
    }
}

fn of<'s>(scene: &'s Scene, parameter: &Parameter, face: usize) -> Option<(&'s Part, &'s Mesh)> {
    let part = scene.parts.get(*parameter.parts.first()?)?;
    part.faces.get(face)?;
    Some((part, scene.meshes.get(part.mesh.index())?))
}

/// Middle of a face and its mean normal (unit), world.
fn face_frame(part: &Part, mesh: &Mesh, face: usize) -> Option<(DVec3, DVec3)> {
    let at = |vertex: u32| {
        let position = mesh.positions.get(vertex as usize)?;
        Some(part.to_world.transform_point3(DVec3::from_array(position.map(f64::from))))
    };
    let (mut middle, mut normal, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for triangle in mesh.triangles.get(mesh.faces.get(face)?.triangles())? {
        let [a, b, c] = [at(triangle[0])?, at(triangle[1])?, at(triangle[2])?];
        let across = (b - a).cross(c - a);
        middle += across.length() * (a + b + c) / 3.0;
        normal += across;
        area += across.length();
    }
    // A mirrored part has its triangles the other way around.
    let side = part.to_world.matrix3.determinant().signum();
    Some((Some(middle / area).filter(|at| at.is_finite())?, normal.try_normalize()? * side))
}

/// Moves a face of a part (world motion), with the corners that it shares with others: the solid stays closed.
fn move_face(scene: &mut Scene, parameter: &Parameter, face: usize, motion: DAffine3) {
    for &index in &parameter.parts {
        let own = scene.parts[index].to_world;
        let motion = own.inverse() * motion * own;
        let Some(mesh) = scene.meshes.get(scene.parts[index].mesh.index()) else { continue };
        let mut mesh = Mesh::clone(mesh);
        let triangles = mesh.faces.get(face).map(|range| range.triangles()).and_then(|range| mesh.triangles.get(range));
        let bits = |position: &[f32; 3]| position.map(f32::to_bits);
        let vertices: HashSet<u32> = triangles.into_iter().flatten().flatten().copied().collect();
        let places: HashSet<[u32; 3]> =
            vertices.iter().filter_map(|v| Some(bits(mesh.positions.get(*v as usize)?))).collect();
        for (vertex, position) in mesh.positions.iter_mut().enumerate() {
            if places.contains(&bits(position)) {
                let moved = motion.transform_point3(DVec3::from_array(position.map(f64::from)));
                *position = moved.to_array().map(|x| x as f32);
                if u32::try_from(vertex).is_ok_and(|v| vertices.contains(&v))
                    && let Some(normal) = mesh.normals.get_mut(vertex)
                {
                    let turned = motion.matrix3 * DVec3::from_array(normal.map(f64::from));
                    *normal = turned.normalize_or_zero().to_array().map(|x| x as f32);
                }
            }
        }
        let id = MeshId::from_index(scene.meshes.len());
        scene.meshes.push(Shared::from(mesh));
        let part = &mut scene.parts[index];
        part.mesh = id;
        part.faces[face].shape = part.faces[face].shape.moved(&motion);
    }
}

fn index(scene: &mut Scene, parameter: &Parameter, by: f64) -> Result<()> {
    let nm = scene.wavelengths.traced_nm();
    for &part in &parameter.parts {
        let Some(id) = scene.parts[part].medium else { continue };
        let Some(medium) = scene.media.get(id.index()) else { continue };
        let mut medium = medium.clone();
        let was = medium.index.index(nm).re;
        if was + by <= 0.0 {
            return Err(nonsense(parameter, by));
        }
        medium.index = Dispersion::Offset { law: Box::new(medium.index), by };
        scene.parts[part].medium = Some(MediumId::from_index(scene.media.len()));
        scene.media.push(medium);
    }
    Ok(())
}
