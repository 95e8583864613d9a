//! UsdLux against its own formulas.

use super::kit::{assembly, notes};
use crate::Assembly;
use eyebox_scene::assembly::LightForm;
use glam::DVec3;
use std::f64::consts::PI;

const MM: &str = "(\n metersPerUnit = 0.001\n upAxis = \"Z\"\n)\n";

fn light(kind: &str, inputs: &str) -> Assembly {
    assembly(&format!("{MM}def {kind} \"L\" {{\n{inputs}\n}}\n"))
}

fn form(kind: &str, inputs: &str) -> LightForm {
    let found = light(kind, inputs);
    assert_eq!(found.lights.len(), 1, "{}", notes(&found));
    found.lights[0].form.clone()
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-6 * b.abs(), "{a} {b}");
}

#[test]
fn strengths_are_in_nit() {
    assert_eq!(form("RectLight", ""), LightForm::Rect { luminance_cd_m2: 1.0, width: 1.0, height: 1.0 });
    let bright = "float inputs:intensity = 3\nfloat inputs:exposure = 4";
    assert_eq!(form("DiskLight", bright), LightForm::Disk { luminance_cd_m2: 48.0, radius: 0.5 });
    let found = light("SphereLight", "color3f inputs:color = (0, 2, 0)\nfloat inputs:radius = 2");
    let LightForm::Sphere { luminance_cd_m2, radius } = found.lights[0].form else { panic!() };
    close(luminance_cd_m2, 2.0 * 0.715_168_678_767_755_9);
    close(found.lights[0].color[1], 1.0 / 0.715_168_678_767_755_9);
    assert_eq!(radius, 2.0);
}

#[test]
fn normalised_lights_keep_their_power() {
    let scaled = "uniform token[] xformOpOrder = [\"xformOp:scale\"]\ndouble3 xformOp:scale = (2, 2, 2)\nbool inputs:normalize = 1\nfloat inputs:intensity = 60\n";
    let LightForm::Rect { luminance_cd_m2, .. } =
        form("RectLight", &format!("{scaled}float inputs:width = 3\nfloat inputs:height = 5"))
    else {
        panic!()
    };
    close(luminance_cd_m2, 1.0);
    let LightForm::Disk { luminance_cd_m2, .. } = form("DiskLight", scaled) else { panic!() };
    close(luminance_cd_m2, 60.0 / PI);
    let LightForm::Sphere { luminance_cd_m2, .. } = form("SphereLight", scaled) else { panic!() };
    close(luminance_cd_m2, 60.0 / (4.0 * PI));
    let LightForm::Cylinder { luminance_cd_m2, radius, length } = form("CylinderLight", scaled) else { panic!() };
    close(luminance_cd_m2, 60.0 / (2.0 * PI * 2.0));
    assert_eq!((radius, length), (0.5, 1.0));
}

/// A point is what a small sphere is from afar: I = π r² L.
#[test]
fn points_are_small_spheres() {
    let point = form("SphereLight", "bool treatAsPoint = 1\nfloat inputs:intensity = 7\nfloat inputs:radius = 3");
    let LightForm::Point { intensity_cd, cone: None } = point else { panic!() };
    close(intensity_cd, PI * 0.003 * 0.003 * 7.0);
    let normal =
        "bool inputs:normalize = 1\nbool treatAsPoint = 1\nfloat inputs:intensity = 4e6\nfloat inputs:radius = 0";
    let spot = "\nfloat inputs:shaping:cone:angle = 30\nfloat inputs:shaping:cone:softness = 0.5";
    let LightForm::Point { intensity_cd, cone } = form("SphereLight", &format!("{normal}{spot}")) else { panic!() };
    close(intensity_cd, 1.0);
    let (inner, outer) = cone.unwrap();
    close(outer, PI / 6.0);
    close(inner, PI / 12.0);
}

/// A profile that is not normalised says how strong a point is; without one, a point of radius 0 is dark.
#[test]
fn points_of_no_radius_shine_by_their_profile() {
    let profile = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/ies_quirks/bom.ies");
    let point = "bool treatAsPoint = 1\nfloat inputs:radius = 0\n";
    let measured = format!("{point}asset inputs:shaping:ies:file = @{profile}@\n");
    let found = light("SphereLight", &measured);
    assert!(!notes(&found).contains("has no light"), "{}", notes(&found));
    let LightForm::Point { intensity_cd, .. } = found.lights[0].form else { panic!() };
    close(intensity_cd, 1.0);
    for dark in [point, &format!("{measured}bool inputs:shaping:ies:normalize = 1\n")] {
        let found = light("SphereLight", dark);
        assert!(notes(&found).contains("a point without `normalize` has no light"), "{}", notes(&found));
    }
}

#[test]
fn distant_lights_are_in_lux() {
    let LightForm::Distant { illuminance_lx, angle } = form("DistantLight", "bool inputs:normalize = 1") else {
        panic!()
    };
    close(illuminance_lx, 50_000.0);
    close(angle, 0.53_f64.to_radians());
    let LightForm::Distant { illuminance_lx, .. } = form("DistantLight", "float inputs:intensity = 1e6") else {
        panic!()
    };
    close(illuminance_lx, 1e6 * PI * (0.265_f64.to_radians()).sin().powi(2));
}

/// Beyond half of all directions the schema's size is π (2 − sin²), and only the front half meets a surface.
#[test]
fn distant_lights_wider_than_half_of_all() {
    let half = form("DistantLight", "float inputs:angle = 180\nfloat inputs:intensity = 2");
    assert_eq!(half, LightForm::Distant { illuminance_lx: 2.0 * PI, angle: PI });
    let wide = form("DistantLight", "float inputs:angle = 240\nfloat inputs:intensity = 5\nbool inputs:normalize = 1");
    let LightForm::Distant { illuminance_lx, angle } = wide else { panic!() };
    close(illuminance_lx, 5.0 / (2.0 - 0.75));
    assert_eq!(angle, PI);
}

/// A prolate spheroid's surface is 2πa² + 2πac asin(e)/e with e² = 1 − a²/c², an oblate one's with atanh; a tube's the
/// circumference of an ellipse, 9.688448220547675 for semi-axes 1 and 2.
#[test]
fn stretched_lights_are_divided_by_their_surface() {
    let scaled = |x: f64, y: f64, z: f64| {
        format!(
            "uniform token[] xformOpOrder = [\"xformOp:scale\"]\ndouble3 xformOp:scale = ({x}, {y}, {z})\nbool inputs:normalize = 1\nfloat inputs:intensity = 60\nfloat inputs:radius = 1\n"
        )
    };
    for (a, c) in [(1.0_f64, 3.0_f64), (3.0, 1.0), (1.0, 100.0), (100.0, 1.0)] {
        let area = if c > a {
            let e = (1.0 - a * a / (c * c)).sqrt();
            2.0 * PI * (a * a + a * c * e.asin() / e)
        } else {
            let e = (1.0 - c * c / (a * a)).sqrt();
            2.0 * PI * (a * a + c * c * e.atanh() / e)
        };
        let LightForm::Sphere { luminance_cd_m2, .. } = form("SphereLight", &scaled(a, a, c)) else { panic!() };
        let limit = if a.max(c) > 10.0 { 1e-4 } else { 1e-7 };
        assert!((luminance_cd_m2 * area / 60.0 - 1.0).abs() < limit, "{a} {c}: {}", luminance_cd_m2 * area / 60.0);
    }
    let LightForm::Cylinder { luminance_cd_m2, .. } = form("CylinderLight", &scaled(5.0, 1.0, 2.0)) else { panic!() };
    close(luminance_cd_m2, 60.0 / (5.0 * 9.688_448_220_547_675));
}

/// ShapingAPI's own cone is half of all directions; 180° is none.
#[test]
fn cones_have_the_schemas_default() {
    let light = |inputs: &str| {
        assembly(&format!(
            "{MM}def SphereLight \"L\" (prepend apiSchemas = [\"ShapingAPI\"]) {{ {inputs}\n float inputs:radius = 1 }}"
        ))
    };
    let cone = |inputs: &str| match light(&format!("bool treatAsPoint = 1\n{inputs}")).lights[0].form {
        LightForm::Point { cone, .. } => cone,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(cone(""), Some((PI / 2.0, PI / 2.0)));
    assert_eq!(cone("float inputs:shaping:cone:angle = 180"), None);
    assert!(notes(&light("")).contains("the cone of a light"));
    assert!(!notes(&light("float inputs:shaping:cone:angle = 180")).contains("the cone of a light"));
}

#[test]
fn domes_stand_on_their_pole() {
    let found = light("DomeLight", "asset inputs:texture:file = @./sky.exr@\nfloat inputs:intensity = 2");
    let LightForm::Dome { scale_cd_m2, image } = &found.lights[0].form else { panic!() };
    assert_eq!(*scale_cd_m2, 2.0);
    assert!(image.as_ref().unwrap().ends_with("sky.exr"));
    let up = |found: &Assembly| (found.nodes[found.lights[0].node].to_world.matrix3 * DVec3::Y).round();
    assert_eq!(up(&found), DVec3::Y);
    assert_eq!(up(&light("DomeLight_1", "")), DVec3::Z);
    assert_eq!(up(&light("DomeLight_1", "uniform token poleAxis = \"Y\"")), DVec3::Y);
    let ball = light("DomeLight", "token inputs:texture:format = \"mirroredBall\"");
    assert!(ball.lights.is_empty() && notes(&ball).contains("mirroredBall"));
}

/// From UsdLux.BlackbodyTemperatureAsRgb of usd-core 26.11, which is a spline of its own.
#[test]
fn temperatures_are_colours() {
    for (kelvin, want) in [
        (2000, [2.520_566_2, 0.646_888_26, 0.020_403_985]),
        (3000, [1.771_028_4, 0.844_293_53, 0.272_031_75]),
        (5000, [1.213_508_6, 0.960_544_3, 0.762_144_15]),
        (6500, [1.043_333_4, 0.983_624_46, 1.034_613_3]),
        (10000, [0.871_841_3, 0.994_687_9, 1.429_995_9]),
    ] {
        let inputs = format!("bool inputs:enableColorTemperature = 1\nfloat inputs:colorTemperature = {kelvin}");
        let found = light("RectLight", &inputs);
        let LightForm::Rect { luminance_cd_m2, .. } = found.lights[0].form else { panic!() };
        close(luminance_cd_m2, 1.0);
        for (own, want) in found.lights[0].color.iter().zip(want) {
            assert!((own - want).abs() < 0.02, "{kelvin} {:?}", found.lights[0].color);
        }
    }
}

/// Intensity, exposure and colour are a factor of the file's candela, whatever the size of the light.
#[test]
fn profiles_take_the_lights_strength_as_a_factor() {
    let ies = "asset inputs:shaping:ies:file = @./a.ies@\nfloat inputs:intensity = 3\nfloat inputs:exposure = 1\n";
    for (kind, more) in
        [("DiskLight", "float inputs:radius = 4"), ("SphereLight", "bool treatAsPoint = 1\nbool inputs:normalize = 1")]
    {
        let found = light(kind, &format!("{ies}{more}"));
        let profile = found.lights[0].profile.as_ref().unwrap();
        assert_eq!((profile.factor, profile.normalize, profile.angle_scale), (6.0, false, 0.0));
        match found.lights[0].form {
            LightForm::Disk { luminance_cd_m2: own, .. } | LightForm::Point { intensity_cd: own, .. } => {
                close(own, 6.0)
            }
            ref other => panic!("{other:?}"),
        }
    }
    let more = "bool inputs:shaping:ies:normalize = 1\nfloat inputs:shaping:ies:angleScale = 0.5";
    let found = light("DiskLight", &format!("{ies}{more}"));
    let profile = found.lights[0].profile.as_ref().unwrap();
    assert!(profile.normalize && profile.angle_scale == 0.5 && !notes(&found).contains("is not used"));
}

#[test]
fn what_is_not_used_is_said() {
    let found = light(
        "RectLight",
        "asset inputs:texture:file = @a.png@\nasset inputs:shaping:ies:file = @./a.ies@\nfloat inputs:shaping:cone:angle = 20\nfloat inputs:shaping:focus = 2\nrel light:filters = </F>\nrel collection:lightLink:includes = </F>",
    );
    let said = notes(&found);
    for what in ["picture of a rectangular", "the cone of a light", "focus", "filters", "lightLink"] {
        assert!(said.contains(what), "{what}\n{said}");
    }
    assert!(found.lights[0].profile.as_ref().unwrap().source.file().unwrap().ends_with("a.ies"));
    let odd = light("PortalLight", "");
    assert!(odd.lights.is_empty() && notes(&odd).contains("PortalLight"));
    let negative = light("RectLight", "float inputs:intensity = -1");
    assert!(negative.lights.is_empty() && notes(&negative).contains("negative"));
    let flat = light("RectLight", "bool inputs:normalize = 1\nfloat inputs:width = 0");
    assert!(flat.lights.is_empty() && notes(&flat).contains("without surface"));
}

#[test]
fn meshes_that_are_lights_emit() {
    let square = super::kit::SQUARE;
    let found = assembly(&format!(
        "def Mesh \"A\" (prepend apiSchemas = [\"MeshLightAPI\"]) {{ {square}\n float inputs:intensity = 8\n}}\n"
    ));
    assert_eq!(found.nodes[0].attributes.as_ref().unwrap().to_string(), "{ emitter = { luminance_cd_m2 = 8 } }");
}
