//! What a face is for, in one word, from what it does with light: for mattes by role.

use super::World;
use super::films::Films;
use super::scatter::Scatter;
use super::surface::{FaceOptics, Surface};
use eyebox_scene::{FaceRange, Mesh, Part, Scene, Shape};
use glam::Vec3;

/// The optical role of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Role {
    /// Emits.
    Lamp,
    /// Carries a picture that light crosses.
    Slide,
    /// Scatters: a diffuser, a wall.
    Screen,
    /// Acts on polarisation.
    Polariser,
    /// Reflects, and lets nearly nothing through.
    Mirror,
    /// A polished face of a part of which a coated face reflects and transmits a good share each.
    Combiner,
    /// A polished face of a part that has a curved one.
    Lens,
    /// A polished face of a part with plane ones alone: a plate, a window, a prism.
    Plate,
    /// Gives hardly any light back.
    Absorber,
}

impl Role {
    pub const ALL: [Role; 9] = [
        Role::Lamp,
        Role::Slide,
        Role::Screen,
        Role::Polariser,
        Role::Mirror,
        Role::Combiner,
        Role::Lens,
        Role::Plate,
        Role::Absorber,
    ];

    /// The name in mattes.
    pub fn name(self) -> &'static str {
        match self {
            Role::Lamp => "lamp",
            Role::Slide => "slide",
            Role::Screen => "screen",
            Role::Polariser => "polariser",
            Role::Mirror => "mirror",
            Role::Combiner => "combiner",
            Role::Lens => "lens",
            Role::Plate => "plate",
            Role::Absorber => "absorber",
        }
    }
}

/// A share of light that counts as much: below it a scatterer is black, a coating against reflections, a mirror opaque.
/// Bare glass of index 1.9 reflects a tenth.
const MUCH: f64 = 0.1;

/// The role of every face, by part; none of faces that are not there for light.
pub fn roles(scene: &Scene, world: &World) -> Vec<Vec<Option<Role>>> {
    scene.parts.iter().zip(0..).map(|(part, index)| of_part(scene, world, part, index)).collect()
}

fn of_part(scene: &Scene, world: &World, part: &Part, index: usize) -> Vec<Option<Role>> {
    let Some(faces) = world.faces.get(index) else { return Vec::new() };
    let glass = world.media_of_parts.get(index).and_then(Option::as_ref);
    let n = glass.map_or(1.0, |medium| medium.index.index(world.wavelength_nm).re);
    // Reflectance and transmittance of a coated face for light that falls straight on.
    let coated = |coating: usize| {
        let coating = coating.checked_sub(1).and_then(|index| world.coatings.get(index))?;
        let power = Films::at(Some(coating), world.wavelength_nm);
        let power = power.turning::<f64>(1.0, n, 1.0, true, world.wavelength_nm).power;
        Some((power.reflectance(), power.transmittance()))
    };
    let splits = |(r, t): (f64, f64)| r >= MUCH && t >= MUCH;
    let interfaces = || {
        faces.iter().filter_map(|face| match &face.surface {
            Surface::Interface(coating) => Some(*coating),
            Surface::Absent
            | Surface::Absorber
            | Surface::Slide(_)
            | Surface::Mirror(_)
            | Surface::Sheet(_)
            | Surface::Splitter(_)
            | Surface::Grating(_)
            | Surface::Scatter(_) => None,
        })
    };
    let glass_role = if interfaces().filter_map(coated).any(splits) {
        Role::Combiner
    } else if is_lens(scene, world, part, index) {
        Role::Lens
    } else {
        Role::Plate
    };
    let unlit = |surface: &Surface| match surface {
        Surface::Absent => None,
        Surface::Absorber => Some(Role::Absorber),
        Surface::Slide(_) => Some(Role::Slide),
        Surface::Mirror(_) => Some(Role::Mirror),
        Surface::Grating(_) => Some(Role::Combiner),
        Surface::Sheet(_) | Surface::Splitter(_) => Some(Role::Polariser),
        Surface::Interface(coating) => match coated(*coating) {
            Some((r, t)) if r >= MUCH && t < MUCH => Some(Role::Mirror),
            Some(_) | None => Some(glass_role),
        },
        Surface::Scatter(scatter) => Some(of_scatter(scatter)),
    };
    let one = |face: &FaceOptics| if face.lamp { Some(Role::Lamp) } else { unlit(&face.surface) };
    faces.iter().map(one).collect()
}

fn of_scatter(scatter: &Scatter) -> Role {
    let specular = scatter.specular();
    let all = specular + scatter.albedo(1.0);
    if all < MUCH {
        Role::Absorber
    } else if specular >= 0.5 * all {
        Role::Mirror
    } else {
        Role::Screen
    }
}

/// Whether a polished face of the part is curved.
fn is_lens(scene: &Scene, world: &World, part: &Part, index: usize) -> bool {
    let Some(faces) = world.faces.get(index) else { return false };
    let mesh = scene.mesh(part.mesh);
    faces.iter().zip(&part.faces).enumerate().any(|(number, (face, known))| {
        let curved = || match known.shape {
            Shape::Plane { .. } => false,
            Shape::Mesh => mesh.faces.get(number).is_some_and(|range| is_curved(mesh, range)),
            Shape::Sphere { .. }
            | Shape::Conic { .. }
            | Shape::Asphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Toroid { .. }
            | Shape::XyPoly { .. }
            | Shape::Zernike { .. }
            | Shape::Bspline { .. } => true,
        };
        matches!(face.surface, Surface::Interface(_)) && curved()
    })
}

/// Whether the normals of a face turn by more than f32 and the rounding of exporters (0.8 arcmin) do.
fn is_curved(mesh: &Mesh, range: &FaceRange) -> bool {
    const TURN: f32 = 1e-6;
    let start = range.first as usize;
    let triangles = mesh.triangles.iter().skip(start).take(range.count as usize).flatten();
    let mut normals = triangles.filter_map(|vertex| mesh.normals.get(*vertex as usize)).map(|n| Vec3::from_array(*n));
    let Some(first) = normals.next() else { return false };
    normals.any(|normal| first.dot(normal) < (1.0 - TURN) * first.length() * normal.length())
}
