//! Light of a face goes through its material: what is cut out sends none, what is blended its share, and a coat keeps what it
//! reflects. Closed forms: seen straight, as a texture, and by what it lights.

use super::{data, is_near, seen};
use crate::common::*;
use eyebox::base::Shared;
use eyebox::base::ids::SurfaceId;
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;
use eyebox::scene::texture::{Channel, Encoding, Filter, Texels, Wrap};
use eyebox::scene::*;
use glam::DVec3;
use std::sync::Arc;

const L: f64 = 1000.0;

/// As glTF has it: 0 or 1 by the cutoff, the alpha as a share of both.
#[test]
fn gltf_emission_sees_opacity() {
    let mask = seen(&data("mask.optics.toml"), &[], Choice::Auto, 8);
    assert!(is_near(mask, 100.0, 1e-3), "{mask:?} for the sky alone");
    let blend = seen(&data("blend.optics.toml"), &[], Choice::Auto, 64);
    assert!(is_near(blend, 0.75 * 100.0 + 0.25 * L, 1e-3), "{blend:?}");
}

fn black() -> StandardSurface {
    StandardSurface { base_color: Colour::new([0.0; 3]), specular: Scalar::new(0.0), ..StandardSurface::default() }
}

/// A texture of two columns, red on the left and on the right.
fn columns([left, right]: [f32; 2]) -> TextureInput {
    let texels = [left, right].map(|x| [x; 4]).to_vec();
    let texture = Texture { name: "columns".to_owned(), width: 2, height: 1, texels: Texels::Floats(Arc::new(texels)) };
    TextureInput {
        texture: Shared::from(texture),
        encoding: Encoding::Linear,
        wrap: [Wrap::Clamp; 2],
        filter: Filter::Nearest,
        set: 0,
        to_picture: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        channels: Channel::ALL,
        scale: [1.0; 4],
        bias: [0.0; 4],
        fallback: None,
    }
}

/// A square lamp of this material, about `at`, that shines along `a` × `b`; its texture coordinates are those of a square.
fn add_lamp(s: &mut Scene, surface: StandardSurface, (at, a, b): (DVec3, DVec3, DVec3)) {
    let group = add_group(s, "lamp");
    let mut square = mesh(&[quad(DVec3::ZERO, a, b)]);
    square.uvs = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let pattern = surface.emission.is_some();
    s.surfaces.push(surface.into());
    let id = SurfaceId::from_index(s.surfaces.len() - 1);
    let mut shining = face(Finish::Surface { surface: id });
    shining.emitter = lamp(group, L).map(|lamp| Emitter { pattern: pattern.then_some(id), ..lamp });
    add_part(s, "lamp", square, at, None, vec![shining]);
}

/// The picture of such a lamp that is seen under an angle, with a sky of 100 behind it.
fn seen_under(surface: StandardSurface, degrees: f64, passes: u64) -> (f64, f64) {
    let mut s = scene();
    (s.eye.fov_deg, s.eye.pupil_diameter_m) = (2.0, 0.0);
    uniform_sky(&mut s, 100.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    add_lamp(&mut s, surface, (DVec3::NEG_Z, DVec3::new(cos, 0.0, sin), DVec3::Y));
    mean(&image(&render(&s, Choice::Auto, passes, 3).0))
}

/// Fresnel's equations for unpolarised light.
fn reflectance(n: f64, degrees: f64) -> f64 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let inside = (1.0 - (sin / n).powi(2)).sqrt();
    let (s, p) = ((cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside));
    0.5 * (s * s + p * p)
}

#[test]
fn a_coat_keeps_what_it_reflects() {
    for degrees in [0.0, 60.0, 75.0] {
        let coat = StandardSurface { coat: Scalar::new(1.0), ..black() };
        let found = seen_under(coat, degrees, 32);
        // The sky in the coat is as bright as it reflects.
        let coat = reflectance(1.5, degrees);
        let want = (1.0 - coat) * L + coat * 100.0;
        assert!(is_near(found, want, 4e-3), "{degrees}°: {found:?} for {want}");
    }
}

/// Half of the lamp is cut out; of a picture that is white there alone, nothing is left.
#[test]
fn opacity_and_emission_may_both_be_pictures() {
    let cut = |alpha: [f32; 2], emission: Option<[f32; 2]>| StandardSurface {
        opacity: Opacity::Mask {
            alpha: Scalar { factor: 1.0, texture: Some((columns(alpha), Channel::Red)) },
            cutoff: 0.5,
        },
        emission: emission.map(columns),
        ..black()
    };
    for (surface, want) in [
        (cut([0.0, 1.0], None), 0.5 * (100.0 + L)),
        (cut([0.0, 1.0], Some([1.0, 0.0])), 0.5 * 100.0),
        (cut([0.0, 1.0], Some([1.0, 0.25])), 0.5 * (100.0 + 0.25 * L)),
        (cut([1.0, 1.0], Some([1.0, 0.25])), 0.5 * (L + 0.25 * L)),
    ] {
        let found = seen_under(surface, 0.0, 64);
        assert!(is_near(found, want, 2e-3), "{found:?} for {want}");
    }
}

/// A small lamp of half side a at a distance d from a white wall gives it E = L A/d²; the wall shows E/π.
#[test]
fn what_it_lights_has_as_much_less() {
    let (half, distance) = (0.02, 1.0);
    let wall = |surface: StandardSurface, choice: Choice, passes: u64| {
        let mut s = scene();
        (s.eye.fov_deg, s.eye.pupil_diameter_m) = (4.0, 0.0);
        s.eye.resolution = [4, 4];
        let matt = Finish::Lambert { reflectance: 1.0, transmittance: 0.0 };
        let white = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.04, DVec3::Y * 0.04)]);
        add_part(&mut s, "wall", white, DVec3::NEG_Z * 0.5, None, vec![face(matt)]);
        // Behind the eye, towards −z.
        let at = DVec3::new(0.0, 0.0, distance - 0.5);
        add_lamp(&mut s, surface, (at, DVec3::NEG_X * half, DVec3::Y * half));
        mean(&image(&render(&s, choice, passes, 5).0))
    };
    let want = L * (2.0 * half).powi(2) / (distance * distance) / std::f64::consts::PI;
    let blend = StandardSurface { opacity: Opacity::Blend { alpha: Scalar::new(0.25) }, ..black() };
    let coat = StandardSurface { coat: Scalar::new(1.0), ..black() };
    let cut = StandardSurface {
        opacity: Opacity::Blend { alpha: Scalar { factor: 1.0, texture: Some((columns([0.5, 0.0]), Channel::Red)) } },
        ..black()
    };
    for (surface, share) in [(blend, 0.25), (coat, 1.0 - reflectance(1.5, 0.0)), (cut, 0.25)] {
        for (choice, passes) in [(Choice::Only(Estimator::Backward), 64), (Choice::Only(Estimator::Photon), 16)] {
            let found = wall(surface.clone(), choice, passes);
            // The lamp is not quite a point, and photons are blurred by their kernel.
            assert!(is_near(found, share * want, 0.02), "{choice:?} {share}: {found:?} for {}", share * want);
        }
    }
}
