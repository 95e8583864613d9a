//! A coat has the colour and the index that are said of it.

use super::{data, is_near, read, warnings};
use crate::common::*;
use eyebox::base::ids::SurfaceId;
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;
use eyebox::scene::*;
use glam::DVec3;

/// Fresnel's equations for unpolarised light.
fn reflectance(n: f64, cos: f64) -> f64 {
    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let (s, p) = ((cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside));
    0.5 * (s * s + p * p)
}

/// A white body under a smooth coat in an even sky, seen straight: the coat reflects R of it; the body gives back what gets in and
/// out, T(i) T(o)/T̄, along ways of 1/cos through what absorbs.
fn furnace(n: f64, colour: f64) -> f64 {
    let left = |cos: f64| colour.powf(0.5 / (1.0 - (1.0 - cos * cos) / (n * n)).sqrt());
    let steps = 4000;
    let (mut open, mut through) = (0.0, 0.0);
    for k in 0..steps {
        let cos = (k as f64 + 0.5) / steps as f64;
        let weight = 2.0 * cos / steps as f64 * (1.0 - reflectance(n, cos));
        (open, through) = (open + weight, through + weight * left(cos));
    }
    let straight = reflectance(n, 1.0);
    straight + (1.0 - straight) * left(1.0) * through / open
}

#[test]
fn what_is_below_is_seen_through_its_colour_twice() {
    for (ior, colour) in [(1.5, 1.0), (1.5, 0.25), (2.0, 0.5), (1.3, 0.0)] {
        let mut s = scene();
        (s.eye.fov_deg, s.eye.pupil_diameter_m) = (2.0, 0.0);
        s.eye.resolution = [4, 4];
        uniform_sky(&mut s, 1000.0);
        let surface = StandardSurface {
            specular: Scalar::new(0.0),
            coat: Scalar::new(1.0),
            coat_ior: ior,
            coat_color: Colour::new([colour; 3]),
            ..StandardSurface::default()
        };
        s.surfaces.push(surface.into());
        let finish = Finish::Surface { surface: SurfaceId::from_index(0) };
        let square = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
        add_part(&mut s, "square", square, DVec3::NEG_Z, None, vec![face(finish)]);
        let found = mean(&image(&render(&s, Choice::Only(Estimator::Backward), 400, 2).0));
        let want = 1000.0 * furnace(ior, colour);
        assert!(is_near(found, want, 0.01), "{ior} {colour}: {found:?} for {want}");
    }
}

#[test]
fn its_parameters_are_read_or_said() {
    let surface = |path: &std::path::Path| {
        let built = read(path, &[]);
        let said = warnings(&built).join("\n");
        let id = built.scene.parts[0].faces[0].finish.surface().expect("a surface");
        (built.scene.surfaces[id.index()].clone(), said)
    };
    let (found, _) = surface(&data("X2_coat_color.usda"));
    assert_eq!(found.coat_ior, 1.6, "OpenPBR's own");
    assert!(found.coat_color.factor.iter().zip([0.9, 0.3, 0.2]).all(|(a, b)| (a - b).abs() < 1e-6));
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(data("X2_coat_color.usda")).expect("a text");
    let standard = text
        .replace("ND_open_pbr_surface_surfaceshader", "ND_standard_surface_surfaceshader")
        .replace("float inputs:coat_weight = 1", "float inputs:coat = 1\nfloat inputs:coat_IOR = 1.7\nfloat inputs:coat_anisotropy = 0.5\nfloat inputs:coat_affect_color = 1\nfloat inputs:coat_affect_roughness = 0.5\nfloat inputs:coat_roughness = 0.5\nfloat inputs:specular_roughness = 0.2\ncolor3f inputs:base_color = (0.5, 0.5, 0.5)");
    let asset = folder.path().join("standard.usda");
    std::fs::write(&asset, standard).expect("a file");
    let (found, said) = surface(&asset);
    assert!((found.coat_ior - 1.7).abs() < 1e-6);
    assert!((found.base_color.factor[0] - 0.25).abs() < 1e-6, "to the power of 2: {:?}", found.base_color);
    assert!((found.roughness.factor - (0.2 + 0.8 * 0.25)).abs() < 1e-6, "a quarter towards 1: {:?}", found.roughness);
    assert!(said.contains("`coat_anisotropy` of a surface is not used"), "{said}");
    // Without a coat nothing of it counts.
    let bare = text.replace("float inputs:coat_weight = 1", "float inputs:coat_darkening = 0.5");
    std::fs::write(&asset, bare).expect("a file");
    let (found, said) = surface(&asset);
    assert!(found.coat_color == Colour::new([1.0; 3]) && !said.contains("coat_darkening"), "{said}");
}
