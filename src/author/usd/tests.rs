use super::*;
use eyebox_scene::assembly::{Camera, LightForm, LightSource, Material, MeshSource, Node};
use eyebox_scene::attribute::arbitrary;
use eyebox_scene::attribute::usd::{UsdProperty, UsdValue, gather};
use eyebox_scene::value::{Data, Value};
use eyebox_scene::{FaceRange, Mesh};
use glam::{DAffine3, DMat3, DVec3};

fn triangle(name: &str, faces: u32) -> MeshSource {
    let positions: Vec<[f32; 3]> =
        (0..3 * faces).map(|i| [i as f32 * 0.1, if i % 3 == 1 { 1.0 } else { -0.0 }, 1e-7]).collect();
    let mesh = Mesh {
        name: name.into(),
        normals: vec![[-0.0, 0.0, 1.0]; positions.len()],
        uvs: positions.iter().map(|p| [p[0], p[1]]).collect(),
        second_uvs: Vec::new(),
        tangents: Vec::new(),
        colors: Vec::new(),
        triangles: (0..faces).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        faces: (0..faces).map(|first| FaceRange { first, count: 1 }).collect(),
        positions,
    };
    let faces = faces as usize;
    MeshSource {
        mesh: mesh.into(),
        materials: vec![None; faces],
        attributes: vec![None; faces],
        rig: None,
        implicit: None,
        at: Where::Nowhere,
    }
}

/// A node below `parent`.
pub fn add(assembly: &mut Assembly, parent: Option<usize>, name: &str, local: DAffine3, mesh: Option<usize>) -> usize {
    let above = parent.map(|parent| &assembly.nodes[parent]);
    let path = above.map_or_else(|| name.to_owned(), |above| format!("{}/{name}", above.path));
    let to_world = above.map_or(local, |above| above.to_world * local);
    let node = Node {
        name: name.into(),
        path,
        parent,
        local,
        to_world,
        mesh,
        attributes: None,
        user: Vec::new(),
        at: Where::Nowhere,
    };
    assembly.nodes.push(node);
    assembly.nodes.len() - 1
}

/// One of everything: odd names, shared meshes on leaves and not, a light, a camera, materials per face.
fn one_of_everything() -> Assembly {
    let mut a = Assembly { unit_m: 0.001, ..Assembly::default() };
    let number = |x: f64| Value::new(Data::Number(x), Where::Nowhere);
    for (name, ior) in [("Glas/klar", 1.517), ("Glas/klar", 1.4), ("", 2.0)] {
        a.materials.push(Material {
            surface: None,
            user: Vec::new(),
            name: name.into(),
            mapped: vec![("ior".into(), number(ior))],
            attributes: None,
            looks: vec![("opacity".into(), number(0.5))],
            at: Where::Nowhere,
        });
    }
    let mut many = triangle("viele", 3);
    many.materials = vec![Some(0), None, Some(2)];
    let mut one = triangle("", 2);
    one.materials = vec![Some(1); 2];
    a.meshes = vec![triangle("LED", 2), many, one];
    let turned = DAffine3::from_mat3_translation(
        DMat3::from_rotation_x(0.1),
        DVec3::new(-553.77865, 1e-300, f64::from_bits(0x3ff0_0000_0000_0001)),
    );
    let root = add(&mut a, None, "HUD B", turned, None);
    add(&mut a, Some(root), "2nd", turned, Some(0));
    add(&mut a, Some(root), "2nd", DAffine3::IDENTITY, Some(0));
    let holder = add(&mut a, Some(root), "", DAffine3::from_translation(DVec3::X), Some(0));
    add(&mut a, Some(holder), "Looks", turned, Some(1));
    let node = add(&mut a, Some(root), "Looks", DAffine3::IDENTITY, Some(2));
    a.lights.push(LightSource {
        name: "Lampe".into(),
        node,
        form: LightForm::Point { intensity_cd: 0.1, cone: Some((0.2, 0.5)) },
        color: [1.0; 3],
        kelvin: None,
        profile: None,
        attributes: None,
        at: Where::Nowhere,
    });
    a.cameras.push(Camera {
        name: "Auge".into(),
        node: None,
        to_world: turned,
        yfov: Some(0.3),
        aspect: Some(2.0),
        pupil: Some(0.25),
        focus: Some(8.0),
        frustum: Default::default(),
    });
    a
}

/// The text and the crate say the same, to the bit, to a parser that is not ours.
#[test]
fn the_text_and_the_crate_hold_the_same_layer() {
    use openusd::sdf::AbstractData;
    let a = one_of_everything();
    let text = String::from_utf8(encode(&a, Path::new("x.usda")).unwrap()).unwrap();
    let parsed = openusd::usda::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let bytes = encode(&a, Path::new("x.usdc")).unwrap();
    let binary = openusd::usdc::CrateData::open(bytes, true).unwrap();
    let (paths, other) = (parsed.spec_paths(), binary.spec_paths());
    assert!(paths.len() > 60, "{}", paths.len());
    assert_eq!(paths, other);
    for path in &paths {
        for field in parsed.list_fields(path).unwrap() {
            let (a, b) = (parsed.get_field(path, &field).unwrap(), binary.get_field(path, &field).unwrap());
            assert_eq!(a, b, "{path} {field}");
            // Debug tells −0 from 0; a dictionary's has no order.
            if field != "customData" {
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "{path} {field}");
            }
        }
    }
}

#[test]
fn wrong_assemblies_are_faults() {
    type Spoil = fn(&mut Assembly);
    let cases: [(&str, Spoil); 6] = [
        ("there is no mesh 9", |a| a.nodes[1].mesh = Some(9)),
        ("stands after it", |a| a.nodes[1].parent = Some(4)),
        ("there is no material 7", |a| a.meshes[1].materials = vec![Some(7); 3]),
        ("does not follow", |a| a.meshes[1].mesh.faces.swap(0, 1)),
        ("not finite", |a| a.meshes[1].mesh.positions[0][0] = f32::NAN),
        ("vertices that are not there", |a| a.meshes[1].mesh.triangles[0][0] = 99),
    ];
    for (what, spoil) in cases {
        let mut a = one_of_everything();
        spoil(&mut a);
        let fault = encode(&a, Path::new("x.usda")).unwrap_err().to_string();
        assert!(fault.contains(what), "{fault}");
    }
    let fault = encode(&one_of_everything(), Path::new("x.obj")).unwrap_err().to_string();
    assert!(fault.contains(".usdz"), "{fault}");
    let mut deep = Assembly::default();
    for level in 0..3000usize {
        add(&mut deep, level.checked_sub(1), "n", DAffine3::IDENTITY, None);
    }
    assert!(encode(&deep, Path::new("x.usda")).unwrap_err().to_string().contains("deep"));
}

/// What a parser that is not ours finds of our attributes on the root prim.
fn found(data: &dyn openusd::sdf::AbstractData) -> Vec<UsdProperty> {
    use openusd::sdf::Value as V;
    let mut out = Vec::new();
    for path in data.spec_paths() {
        let Some(name) = path.as_str().strip_prefix("/x.").filter(|name| name.starts_with("eyebox:")) else { continue };
        let value = match data.get_field(&path, "default").unwrap().into_owned() {
            V::Double(x) => UsdValue::Double(x),
            V::Vec2d(p) => UsdValue::Double2([p.x, p.y]),
            V::Vec3d(p) => UsdValue::Double3([p.x, p.y, p.z]),
            V::DoubleVec(x) => UsdValue::Doubles(x),
            V::Vec2dVec(x) => UsdValue::Double2s(x.into_iter().map(|p| [p.x, p.y]).collect()),
            V::Vec3dVec(x) => UsdValue::Double3s(x.into_iter().map(|p| [p.x, p.y, p.z]).collect()),
            V::Int(x) => UsdValue::Int(x),
            V::Vec2i(p) => UsdValue::Int2([p.x, p.y]),
            V::IntVec(x) => UsdValue::Ints(x),
            V::Token(x) => UsdValue::Token(x.as_str().to_owned()),
            V::TokenVec(x) => UsdValue::Tokens(x.iter().map(|token| token.as_str().to_owned()).collect()),
            V::AssetPath(x) => UsdValue::Asset(x.as_str().trim_start_matches("./").to_owned()),
            other => panic!("{name}: {other:?}"),
        };
        out.push(UsdProperty { name: name.to_owned(), value, at: Where::Nowhere });
    }
    out
}

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

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { cases: 300, ..Default::default() })]

    /// To the bit, through text and crate.
    #[test]
    fn every_attribute_survives(value in arbitrary::prim()) {
        let mut a = Assembly::default();
        let node = add(&mut a, None, "x", DAffine3::IDENTITY, None);
        a.nodes[node].attributes = Some(value.clone());
        let text = String::from_utf8(encode(&a, Path::new("x.usda")).unwrap()).unwrap();
        let parsed = openusd::usda::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let binary = openusd::usdc::CrateData::open(encode(&a, Path::new("x.usdc")).unwrap(), true).unwrap();
        for (data, kind) in [(&parsed as &dyn openusd::sdf::AbstractData, "usda"), (&binary, "usdc")] {
            let back = gather(&found(data)).unwrap().unwrap();
            proptest::prop_assert!(identical(&value, &back), "{kind}\n{value}\n{back}\n{text}");
        }
    }
}

#[test]
fn references_to_the_root_lists_are_written_out() {
    let text = |text: &str| Value::new(Data::Text(text.into()), Where::Nowhere);
    let number = |x: f64| Value::new(Data::Number(x), Where::Nowhere);
    let table = |rows: Vec<(&str, Value)>| {
        Value::new(Data::Table(rows.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()), Where::Nowhere)
    };
    let list = |items: Vec<Value>| Value::new(Data::List(items), Where::Nowhere);
    let film = table(vec![("n", number(1.38)), ("thickness_nm", number(99.6))]);
    let optics = Some(table(vec![
        ("version", number(1.0)),
        ("coatings", list(vec![table(vec![("name", text("ar")), ("stack", list(vec![film]))])])),
        ("media", list(vec![table(vec![("glass", text("PMMA"))])])),
    ]));
    let mut a = Assembly { optics, ..Assembly::default() };
    let node = add(&mut a, None, "x", DAffine3::IDENTITY, None);
    let row = table(vec![("faces", list(vec![number(2.0)])), ("coating", text("ar"))]);
    a.nodes[node].attributes = Some(table(vec![("medium", number(0.0)), ("faces", list(vec![row]))]));
    let text = String::from_utf8(encode(&a, Path::new("x.usda")).unwrap()).unwrap();
    for line in [
        "int eyebox:asset:version = 1",
        "token eyebox:medium:glass = \"PMMA\"",
        "token eyebox:face:f0:coating:name = \"ar\"",
        "double[] eyebox:face:f0:coating:stack:n = [1.38]",
        "prepend apiSchemas = [\"EyeboxAssetAPI_1\", \"EyeboxMediumAPI_1\", \"EyeboxFaceAPI_1:f0\"]",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
    // What holds where nothing else says anything is declared by no schema.
    a.optics = Some(table(vec![(
        "default",
        table(vec![("finish", Value::new(Data::Text("absorber".into()), Where::Nowhere))]),
    )]));
    a.nodes[node].attributes = None;
    let parsed = openusd::usda::parse(std::str::from_utf8(&encode(&a, Path::new("x.usda")).unwrap()).unwrap()).unwrap();
    let binary = openusd::usdc::CrateData::open(encode(&a, Path::new("x.usdc")).unwrap(), true).unwrap();
    for data in [&parsed as &dyn openusd::sdf::AbstractData, &binary] {
        let path = openusd::sdf::Path::new("/x.eyebox:default:finish").unwrap();
        let custom = data.try_field(&path, "custom").unwrap().map(|found| found.into_owned());
        assert_eq!(custom, Some(openusd::sdf::Value::Bool(true)));
    }
    // An index that leads nowhere is no silent nothing.
    a.nodes[node].attributes = Some(table(vec![("medium", number(3.0))]));
    assert!(encode(&a, Path::new("x.usda")).is_err());
}
