//! Random assemblies through the writer and the reader of glTF: nothing is lost and no bit changes.

use eyebox::base::Where;
use eyebox::import::asset;
use eyebox::scene::assembly::{Assembly, Camera, LightForm, LightSource, Material, MeshSource, Node};
use eyebox::scene::value::{Data, Value};
use eyebox::scene::{FaceRange, Mesh};
use glam::{DAffine3, DMat3, Vec3};
use proptest::prelude::*;

fn leaf() -> impl Strategy<Value = Data> {
    let number = prop_oneof![
        prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
        (-1000i32..1000).prop_map(f64::from),
        Just(-0.0)
    ];
    prop_oneof![any::<bool>().prop_map(Data::Bool), number.prop_map(Data::Number), ".{0,8}".prop_map(Data::Text)]
}

fn data() -> impl Strategy<Value = Data> {
    let value = |data| Value::new(data, Where::Nowhere);
    leaf().prop_recursive(3, 16, 4, move |inner| {
        let list = prop::collection::vec(inner.clone(), 0..4);
        let table = prop::collection::btree_map(".{0,6}", inner, 0..4);
        prop_oneof![
            list.prop_map(move |items| Data::List(items.into_iter().map(value).collect())),
            table.prop_map(move |rows| Data::Table(rows.into_iter().map(|(k, v)| (k, value(v))).collect())),
        ]
    })
}

/// What an object of ours may carry: a table.
fn attributes() -> impl Strategy<Value = Option<Value>> {
    let table = prop::collection::btree_map("[a-z_]{1,8}", data(), 0..4);
    let value = |data| Value::new(data, Where::Nowhere);
    prop::option::of(
        table.prop_map(move |rows| value(Data::Table(rows.into_iter().map(|(k, v)| (k, value(v))).collect()))),
    )
}

/// Faces of triangles with vertices and normals of their own; `corners` says how many triangles each face has.
fn mesh(seed: u32, corners: &[usize], materials: usize, rows: Vec<Option<Value>>) -> MeshSource {
    let mut mesh = Mesh { name: format!("mesh {seed}"), ..Mesh::default() };
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        (state >> 8) as f32 / 1000.0 - 8000.0
    };
    for count in corners {
        mesh.faces.push(FaceRange { first: mesh.triangles.len() as u32, count: *count as u32 });
        for _ in 0..*count {
            let [a, b, c] = std::array::from_fn(|_| Vec3::new(random(), random(), random()));
            let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize().as_vec3().to_array();
            let first = mesh.positions.len() as u32;
            mesh.triangles.push([first + 1, first + 2, first]);
            mesh.positions.extend([a, b, c].map(|p| p.to_array()));
            mesh.normals.extend([normal; 3]);
            if seed.is_multiple_of(2) {
                mesh.uvs.extend([[random(), 0.5], [0.0, random()], [1.0, -0.0]]);
            }
        }
    }
    let faces = mesh.faces.len();
    let material = |face: usize| (!face.is_multiple_of(3)).then_some((seed as usize + face) % materials);
    let mut attributes = rows;
    attributes.resize(faces, None);
    MeshSource {
        mesh: mesh.into(),
        materials: (0..faces).map(material).collect(),
        attributes,
        rig: None,
        implicit: None,
        at: Where::Nowhere,
    }
}

prop_compose! {
    fn affine()(entries in prop::array::uniform12(-1e3f64..1e3), plain in any::<bool>()) -> DAffine3 {
        if plain { DAffine3::IDENTITY } else { DAffine3::from_cols_array(&entries) }
    }
}

prop_compose! {
    fn assembly()(
        locals in prop::collection::vec((affine(), 0usize..9, prop::option::of(0usize..3), attributes()), 1..8),
        faces in prop::collection::vec((prop::collection::vec(0usize..4, 1..5), prop::collection::vec(attributes(), 0..2), 1u32..1000), 3),
        materials in prop::collection::vec((prop::array::uniform6(0.0f64..1.0), attributes(), any::<u8>()), 1..4),
        (optics, turned, unit) in (attributes(), any::<bool>(), prop_oneof![Just(1.0), Just(0.001), Just(0.0254), Just(1.0 / 3.0)]),
        (yfov, aspect, strength) in (0.01f64..3.0, prop::option::of(0.1f64..9.0), 0.0f64..1e6),
    ) -> Assembly {
        let mut all = Assembly { file: "random.usda".into(), unit_m: unit, optics, ..Assembly::default() };
        if turned {
            all.axes = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0]);
        }
        // An optical unit would hold instead.
        if let Some(Value { data: Data::Table(rows), .. }) = &mut all.optics {
            rows.retain(|(key, _)| key != "unit");
        }
        for (index, (local, above, mesh, attributes)) in locals.into_iter().enumerate() {
            // Depth first: the parent is the node before, or one above it.
            let mut parent = index.checked_sub(1);
            for _ in 0..above % 4 {
                parent = parent.and_then(|node: usize| all.nodes[node].parent);
            }
            let name = format!("N{index}/ü \"{}\"", above % 2);
            let (prefix, frame) = parent.map_or((String::new(), DAffine3::IDENTITY), |parent| {
                (format!("{}/", all.nodes[parent].path), all.nodes[parent].to_world)
            });
            let path = format!("{prefix}{name}");
            all.nodes.push(Node { name, path, parent, local, to_world: frame * local, mesh, attributes, user: Vec::new(), at: Where::Nowhere });
        }
        let number = |x: f64| Value::new(Data::Number(x), Where::Nowhere);
        for (index, (numbers, attributes, which)) in materials.into_iter().enumerate() {
            let [ior, dispersion, transmission, thickness, distance, luminance] = numbers;
            let color = Value::new(Data::List(vec![number(distance), number(ior), number(luminance)]), Where::Nowhere);
            let rows = [
                ("ior", number(1.0 + ior)),
                ("dispersion", number(dispersion)),
                ("transmission", number(transmission)),
                ("thickness", number(thickness)),
                ("attenuation_distance", number(0.1 + distance)),
                ("attenuation_color", color.clone()),
                ("luminance_cd_m2", number(1e-3 + luminance)),
            ];
            let mapped = rows.into_iter().enumerate().filter(|(i, _)| which >> i & 1 == 1);
            let mapped = mapped.map(|(_, (key, value))| (key.to_owned(), value)).collect();
            let looks = vec![("base_color".to_owned(), color), ("roughness".to_owned(), number(ior))];
            let (name, at) = (format!("M{index}"), Where::Nowhere);
            all.materials.push(Material { name, mapped, attributes, looks, surface: None, user: Vec::new(), at });
        }
        let count = all.materials.len();
        all.meshes = faces.into_iter().map(|(corners, rows, seed)| {
            let rows = rows.into_iter().take(corners.len()).collect();
            mesh(seed, &corners, count, rows)
        }).collect();
        let last = all.nodes.len() - 1;
        all.cameras.push(Camera { name: "C".into(), node: Some(last), to_world: all.nodes[last].to_world, yfov: Some(yfov), aspect, pupil: None, focus: None, frustum: Default::default() });
        all.lights.push(LightSource {
            name: "L".into(), node: last, form: LightForm::Point { intensity_cd: strength, cone: None },
            color: [1.0; 3], kelvin: None, profile: None, attributes: None, at: Where::Nowhere,
        });
        all
    }
}

/// Compares everything that is written.
fn check(a: &Assembly, b: &Assembly) -> Result<(), TestCaseError> {
    let same = |a: &Option<Value>, b: &Option<Value>| match (a, b) {
        (Some(a), Some(b)) => a.same(b) && a.to_string().len() == b.to_string().len(),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    let bits = |affine: &DAffine3| affine.to_cols_array().map(f64::to_bits);
    prop_assert_eq!(a.unit_m.to_bits(), b.unit_m.to_bits());
    prop_assert_eq!(a.axes, b.axes);
    prop_assert!(same(&a.optics, &b.optics), "{:?} {:?}", a.optics, b.optics);
    prop_assert_eq!(a.nodes.len(), b.nodes.len());
    for (a, b) in a.nodes.iter().zip(&b.nodes) {
        prop_assert_eq!((&a.name, &a.path, a.parent, a.mesh), (&b.name, &b.path, b.parent, b.mesh));
        prop_assert_eq!((bits(&a.local), bits(&a.to_world)), (bits(&b.local), bits(&b.to_world)));
        prop_assert!(same(&a.attributes, &b.attributes), "{:?} {:?}", a.attributes, b.attributes);
    }
    prop_assert_eq!(a.meshes.len(), b.meshes.len());
    for (a, b) in a.meshes.iter().zip(&b.meshes) {
        prop_assert_eq!(&a.mesh, &b.mesh);
        prop_assert_eq!(&a.materials, &b.materials);
        prop_assert!(a.attributes.iter().zip(&b.attributes).all(|(a, b)| same(a, b)));
    }
    prop_assert_eq!(a.materials.len(), b.materials.len());
    for (a, b) in a.materials.iter().zip(&b.materials) {
        prop_assert_eq!(&a.name, &b.name);
        prop_assert_eq!(a.mapped.len(), b.mapped.len());
        for (key, value) in &a.mapped {
            let found = b.mapped.iter().find(|(own, _)| own == key).map(|(_, value)| value);
            prop_assert!(found.is_some_and(|found| found.same(value)), "{} {:?} {:?}", key, value, found);
        }
        prop_assert!(same(&a.attributes, &b.attributes));
    }
    prop_assert_eq!(a.cameras.len(), b.cameras.len());
    for (a, b) in a.cameras.iter().zip(&b.cameras) {
        prop_assert_eq!((&a.name, a.yfov, a.aspect, bits(&a.to_world)), (&b.name, b.yfov, b.aspect, bits(&b.to_world)));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn written_and_read_again_an_assembly_is_the_same(assembly in assembly()) {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.glb", "a b.gltf"] {
            let out = folder.path().join(name);
            let written = eyebox::author::convert(&assembly, &out).expect("it can be written");
            prop_assert_eq!(&written.notes, &[]);
            let again = asset(&out).unwrap_or_else(|fault| panic!("{fault}"));
            check(&assembly, &again)?;
        }
    }
}
