//! Normal maps: what they do to diffuse light is a cosine, however steep they are and from wherever they are seen; and the directions
//! that they are told in are the mesh's own where it has any.

use super::{data, is_near, seen};
use crate::common::*;
use eyebox::base::Shared;
use eyebox::base::ids::SurfaceId;
use eyebox::plan::Choice;
use eyebox::scene::texture::{Channel, Encoding, Filter, Texels, Wrap};
use eyebox::scene::*;
use glam::DVec3;
use std::sync::Arc;

/// A map of 30° (as its bytes have it: tan = 0.5746) at twice its strength.
#[test]
fn a_steep_map_is_as_steep_as_it_is() {
    let found = seen(&data("steep.optics.toml"), &[], Choice::Auto, 64);
    assert!(is_near(found, 656.4, 3e-3), "{found:?}");
}

/// `TANGENT` says +y where texture coordinates say +x; then the map's y, 1/255 of its bytes, is along z × y = −x (glTF 2.0, section
/// 3.7.2.1). The sun stands at 45° towards +x.
#[test]
fn tangents_of_gltf_count() {
    let [x, y, z] = [191.0, 128.0, 238.0].map(|byte: f64| 2.0 * byte / 255.0 - 1.0);
    let want = 1000.0 * (z - y) / (2.0 * (x * x + y * y + z * z)).sqrt();
    let found = seen(&data("rot90.optics.toml"), &[], Choice::Auto, 64);
    assert!(is_near(found, want, 1e-3), "{found:?} for {want}");
}

/// A square whose map leans by `lean` degrees along +x, lit by `lit` and seen from `from` degrees off its normal towards +x, by
/// 1000 π lx: it shows the cosine, where coordinates say nothing and tangents all.
fn leaning(lean: f64, lit: f64, from: f64) -> (f64, f64) {
    let mut s = scene();
    let along = |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    s.eye.position = along(from);
    s.eye.look = -along(from);
    (s.eye.fov_deg, s.eye.pupil_diameter_m) = (1.0, 0.0);
    s.eye.resolution = [2, 2];
    let normal = along(lean);
    let texel = [normal.x, normal.y, normal.z, 1.0].map(|x| x as f32);
    let texels = Texels::Floats(Arc::new(vec![texel]));
    let map = TextureInput {
        texture: Shared::from(Texture { name: "lean".to_owned(), width: 1, height: 1, texels }),
        encoding: Encoding::Linear,
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Nearest,
        set: 0,
        to_picture: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        channels: Channel::ALL,
        scale: [1.0; 4],
        bias: [0.0; 4],
        fallback: None,
    };
    let surface =
        StandardSurface { specular: Scalar::new(0.0), normal: Some((map, 1.0)), ..StandardSurface::default() };
    s.surfaces.push(surface.into());
    let mut square = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
    square.uvs = vec![[0.5; 2]; 4];
    square.tangents = vec![[1.0, 0.0, 0.0, 1.0]; 4];
    let finish = Finish::Surface { surface: SurfaceId::from_index(0) };
    add_part(&mut s, "square", square, DVec3::ZERO, None, vec![face(finish)]);
    let group = add_group(&mut s, "sun");
    let illuminance_lx = 1000.0 * std::f64::consts::PI;
    let form = BeaconForm::Distant { dir: -along(lit), illuminance_lx, angle_rad: 0.0 };
    s.lights.push(Beacon { name: "sun".to_owned(), group, form, spectrum: None });
    mean(&image(&render(&s, Choice::Auto, 16, 1).0))
}

#[test]
fn diffuse_light_sees_the_map_alone() {
    for (lean, lit, from) in [
        (30.0, 0.0, 0.0),
        (60.0, 0.0, 0.0),
        (60.0, 60.0, 0.0),
        (60.0, 20.0, -70.0),
        (45.0, 45.0, -60.0),
        (70.0, 30.0, 80.0),
    ] {
        let want = 1000.0 * f64::to_radians(lean - lit).cos();
        let found = leaning(lean, lit, from);
        assert!(is_near(found, want, 1e-3), "{lean}° lit from {lit}° seen from {from}°: {found:?} for {want}");
    }
}
