//! A camera in words that other programs show: its focal length, film, f-number and shutter come out as they went in, from USD to
//! USD and by way of glTF, whatever the unit.

use super::kit::eyebox;
use std::path::Path;

const STAGE: &str = r#"#usda 1.0
(
    defaultPrim = "w"
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Xform "w"
{
    def Camera "cam"
    {
        float focalLength = 35
        float horizontalAperture = 36
        float verticalAperture = 20.25
        float horizontalApertureOffset = 3
        float fStop = 2.8
        float focusDistance = 300
        float2 clippingRange = (1, 10000)
        double shutter:open = -0.25
        double shutter:close = 0.25
        double3 xformOp:translate = (0, 50, 300)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Sphere "s"
    {
        double radius = 50
    }
    def DomeLight "d"
    {
        float inputs:intensity = 1
    }
}
"#;

pub fn convert(folder: &Path, from: &str, to: &str) -> String {
    let [from, to] = [from, to].map(|name| folder.join(name));
    let (code, _, errors) = eyebox(&[Path::new("convert"), &from, &to]);
    assert_eq!(code, Some(0), "{errors}");
    std::fs::read_to_string(&to).unwrap_or_default()
}

/// The number behind a property's name.
fn number(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find(|line| line.contains(&format!(" {name} = ")))?;
    line.rsplit(" = ").next()?.trim().parse().ok()
}

#[test]
fn a_camera_keeps_its_lens_and_film() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("in.usda"), STAGE).unwrap();
    let direct = convert(place.path(), "in.usda", "out.usda");
    convert(place.path(), "in.usda", "way.gltf");
    let way = convert(place.path(), "way.gltf", "back.usda");
    for text in [&direct, &way] {
        for (name, want) in [
            ("focalLength", 35.0),
            ("horizontalAperture", 36.0),
            ("verticalAperture", 20.25),
            ("horizontalApertureOffset", 3.0),
            ("fStop", 2.8),
            ("focusDistance", 300.0),
            ("shutter:open", -0.25),
            ("shutter:close", 0.25),
        ] {
            let got = number(text, name).unwrap_or_else(|| panic!("no {name} in\n{text}"));
            assert!((got - want).abs() <= 1e-6 * want.abs(), "{name}: {got} for {want}");
        }
    }
}

/// glTF's cameras have no film: they get the lens of 50 mm that everybody knows, in whatever unit.
#[test]
fn a_camera_without_a_film_gets_one_of_usual_size() {
    let place = tempfile::tempdir().unwrap();
    let gltf = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "c", "camera": 0 }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1 } }] }"#;
    std::fs::write(place.path().join("in.gltf"), gltf).unwrap();
    let out = convert(place.path(), "in.gltf", "out.usda");
    // Tenths of metres.
    let focal = number(&out, "focalLength").expect("a lens");
    assert!((focal - 0.5).abs() < 1e-7, "{focal}");
    let tall = number(&out, "verticalAperture").expect("a film");
    assert!((tall - focal * 2.0 * 0.25f64.tan()).abs() < 1e-6, "{tall}");
    convert(place.path(), "out.usda", "back.gltf");
    let back = convert(place.path(), "back.gltf", "again.usda");
    assert_eq!(number(&back, "verticalAperture"), Some(tall));
    let text = std::fs::read_to_string(place.path().join("back.gltf")).unwrap();
    assert!(!text.contains("eyebox_film_m"), "nobody said one: {text}");
}
