//! Materials and lights of random strengths, as any format says them, through USD and back: to the bit.

use eyebox::author;
use eyebox::base::Where;
use eyebox::import::{self, Assembly};
use eyebox::scene::assembly::{LightForm, LightSource, Material, Node};
use eyebox::scene::value::{Data, Value};
use glam::{DAffine3, DMat3};
use proptest::prelude::*;

fn identical(a: &Value, b: &Value) -> bool {
    match (&a.data, &b.data) {
        (Data::Number(a), Data::Number(b)) => a.to_bits() == b.to_bits(),
        (Data::List(a), Data::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| identical(a, b)),
        (Data::Table(a), Data::Table(other)) => {
            a.len() == other.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| identical(a, b)))
        }
        (a, b) => a == b,
    }
}

fn value(data: Data) -> Value {
    Value::new(data, Where::Nowhere)
}
fn number(x: f64) -> Value {
    value(Data::Number(x))
}
fn positive() -> BoxedStrategy<f64> {
    (-9.0..9.0).prop_map(|power: f64| 10f64.powf(power)).boxed()
}
fn unit() -> BoxedStrategy<f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..1.0].boxed()
}
fn color() -> BoxedStrategy<Value> {
    [unit(), unit(), unit()].prop_map(|lanes| value(Data::List(lanes.map(number).to_vec()))).boxed()
}

type Rows = Vec<(String, Value)>;

fn some(rows: Vec<(&'static str, BoxedStrategy<Value>)>) -> BoxedStrategy<Rows> {
    let each: Vec<_> = rows
        .into_iter()
        .map(|(key, value)| proptest::option::of(value.prop_map(move |value| (key.to_owned(), value))))
        .collect();
    each.prop_map(|rows| rows.into_iter().flatten().collect()).boxed()
}

fn material() -> impl Strategy<Value = Material> {
    let film = (1.0..3.0, positive()).prop_map(|(n, thickness)| {
        let layer = vec![("n".to_owned(), number(n)), ("thickness_nm".to_owned(), number(thickness))];
        let stack = value(Data::List(vec![value(Data::Table(layer))]));
        value(Data::Table(vec![("stack".to_owned(), stack)]))
    });
    let distance = prop_oneof![Just(f64::INFINITY), positive()];
    let mapped = some(vec![
        ("ior", (1.0..4.0).prop_map(number).boxed()),
        ("dispersion", positive().prop_map(number).boxed()),
        ("transmission", unit().prop_map(number).boxed()),
        ("thickness", positive().prop_map(number).boxed()),
        ("attenuation_distance", distance.prop_map(number).boxed()),
        ("attenuation_color", color()),
        ("luminance_cd_m2", positive().prop_map(number).boxed()),
        ("coating", film.boxed()),
    ]);
    let looks = some(vec![
        ("base_color", color()),
        ("opacity", unit().prop_map(number).boxed()),
        ("metallic", unit().prop_map(number).boxed()),
        ("roughness", unit().prop_map(number).boxed()),
    ]);
    ("[a-zA-Z /]{0,8}", mapped, looks).prop_map(|(name, mapped, looks)| Material {
        surface: None,
        user: Vec::new(),
        name,
        mapped,
        attributes: None,
        looks,
        at: Where::Nowhere,
    })
}

fn form() -> impl Strategy<Value = LightForm> {
    let cone = proptest::option::of((0.01..1.5, 0.0..0.999).prop_map(|(outer, part)| (outer * part, outer)));
    prop_oneof![
        (positive(), cone).prop_map(|(intensity_cd, cone)| LightForm::Point { intensity_cd, cone }),
        (positive(), 0.0..1.0).prop_map(|(illuminance_lx, angle)| LightForm::Distant { illuminance_lx, angle }),
        (positive(), positive(), positive()).prop_map(|(luminance_cd_m2, width, height)| LightForm::Rect {
            luminance_cd_m2,
            width,
            height
        }),
        (positive(), positive()).prop_map(|(luminance_cd_m2, radius)| LightForm::Disk { luminance_cd_m2, radius }),
        (positive(), positive()).prop_map(|(luminance_cd_m2, radius)| LightForm::Sphere { luminance_cd_m2, radius }),
        (positive(), positive(), positive()).prop_map(|(luminance_cd_m2, radius, length)| LightForm::Cylinder {
            luminance_cd_m2,
            radius,
            length
        }),
        positive().prop_map(|scale_cd_m2| LightForm::Dome { scale_cd_m2, image: None }),
    ]
}

fn light() -> impl Strategy<Value = LightSource> {
    let tint = [0.05..1.0, 0.05..1.0, 0.05..1.0].prop_map(|[r, g, b]: [f64; 3]| {
        let own = eyebox::base::colour::luminance([r, g, b]);
        [r / own, g / own, b / own]
    });
    ("[a-zA-Z /]{0,8}", form(), tint).prop_map(|(name, form, color)| LightSource {
        name,
        node: 0,
        form,
        color,
        kelvin: None,
        profile: None,
        attributes: None,
        at: Where::Nowhere,
    })
}

fn same_rows(a: &Rows, b: &Rows) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|((k, a), (l, b))| k == l && identical(a, b))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..Default::default() })]

    /// To the bit, and through the reader of USD itself.
    #[test]
    fn materials_and_lights_survive(
        materials in proptest::collection::vec(material(), 1..4),
        lights in proptest::collection::vec(light(), 0..4),
        unit_m in prop_oneof![Just(1.0), Just(0.001), Just(0.01)],
    ) {
        let folder = tempfile::tempdir().unwrap();
        let mut a = Assembly { unit_m, ..Assembly::default() };
        let turned = DAffine3::from_mat3(DMat3::from_rotation_x(0.1));
        let node = Node {
                name: "root".into(),
                path: "root".into(),
                parent: None,
                local: turned,
                to_world: turned,
                mesh: None,
                attributes: None,
                user: Vec::new(),
                at: Where::Nowhere,
            };
            a.nodes.push(node);
            let root = 0;
        a.lights = lights.into_iter().map(|light| LightSource { node: root, ..light }).collect();
        a.materials = materials;
        for kind in ["usda", "usdc"] {
            let path = folder.path().join(format!("x.{kind}"));
            author::convert(&a, &path).unwrap();
            let back = import::usd::read(&path, &Default::default()).unwrap();
            prop_assert_eq!(a.materials.len(), back.materials.len());
            for (x, y) in a.materials.iter().zip(&back.materials) {
                prop_assert_eq!(&x.name, &y.name);
                prop_assert!(same_rows(&x.mapped, &y.mapped), "{:?}\n{:?}", x.mapped, y.mapped);
                prop_assert!(same_rows(&x.looks, &y.looks), "{:?}\n{:?}", x.looks, y.looks);
            }
            prop_assert_eq!(a.lights.len(), back.lights.len());
            for (x, y) in a.lights.iter().zip(&back.lights) {
                prop_assert_eq!(&x.name, &y.name);
                prop_assert_eq!(&x.form, &y.form);
                prop_assert_eq!(x.color, y.color);
                prop_assert_eq!(y.node, root);
            }
        }
    }
}

/// A colour temperature stays one.
#[test]
fn temperatures_survive() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let lights = "#usda 1.0\ndef RectLight \"W\" {\n bool inputs:enableColorTemperature = 1\n \
                  float inputs:colorTemperature = 3000\n}\ndef RectLight \"T\" {\n \
                  bool inputs:enableColorTemperature = 1\n float inputs:colorTemperature = 3000\n \
                  color3f inputs:color = (1, 0.5, 0.5)\n}\n";
    std::fs::write(path("a.usda"), lights).unwrap();
    let a = import::usd::read(&path("a.usda"), &Default::default()).unwrap();
    assert_eq!([a.lights[0].kelvin, a.lights[1].kelvin], [Some(3000.0), None]);
    author::convert(&a, &path("b.usda")).unwrap();
    let b = import::usd::read(&path("b.usda"), &Default::default()).unwrap();
    for (x, y) in a.lights.iter().zip(&b.lights) {
        assert_eq!((x.kelvin, &x.form, x.color), (y.kelvin, &y.form, y.color));
    }
}
