//! USD out and in again: what `convert` writes is what was there, what `annotate` writes means what the sidecar means.
//! Pixar's USD has its say in tests/python/usd_check.py.

use crate::common::{block_z, image, mean, render, worst_z};
use eyebox::author;
use eyebox::import::{self, Assembly};
use eyebox::plan::Choice;
use eyebox::scene::value::Value;
use std::path::{Path, PathBuf};

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(name)
}

fn read(path: &Path) -> Assembly {
    import::asset(path).unwrap_or_else(|fault| panic!("{fault}"))
}

fn same_value(a: &Option<Value>, b: &Option<Value>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.same(b),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    }
}

fn bits<const N: usize>(list: &[[f32; N]]) -> Vec<[u32; N]> {
    list.iter().map(|p| p.map(f32::to_bits)).collect()
}

/// Hierarchy, names, transforms, meshes: to the last bit.
fn assert_same(a: &Assembly, b: &Assembly) {
    let names = |a: &Assembly| a.nodes.iter().map(|node| node.path.clone()).collect::<Vec<_>>();
    assert_eq!(names(a), names(b));
    for (x, y) in a.nodes.iter().zip(&b.nodes) {
        assert_eq!(x.parent, y.parent, "{}", x.path);
        assert_eq!(x.local.to_cols_array().map(f64::to_bits), y.local.to_cols_array().map(f64::to_bits), "{}", x.path);
        assert_eq!(x.to_world, y.to_world, "{}", x.path);
        assert!(same_value(&x.attributes, &y.attributes), "{}: {:?} {:?}", x.path, x.attributes, y.attributes);
        assert_eq!(x.mesh.is_some(), y.mesh.is_some(), "{}", x.path);
        let (Some(x), Some(y)) = (x.mesh, y.mesh) else { continue };
        let (x, y) = (&a.meshes[x].mesh, &b.meshes[y].mesh);
        assert_eq!(x.name, y.name);
        assert_eq!(x.triangles, y.triangles, "{}", x.name);
        assert_eq!(x.faces, y.faces, "{}", x.name);
        assert!(bits(&x.positions) == bits(&y.positions), "{}", x.name);
        assert!(bits(&x.normals) == bits(&y.normals), "{}", x.name);
        assert!(bits(&x.uvs) == bits(&y.uvs), "{}", x.name);
    }
}

#[test]
fn both_huds_go_to_usd_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    for asset in ["hud-direct/hud_direct.glb", "hud-diffuse/hud_diffuse.glb"] {
        let original = read(&sample(asset));
        for kind in ["usda", "usdc", "usdz"] {
            let out = folder.path().join(format!("hud.{kind}"));
            author::convert(&original, &out).unwrap_or_else(|fault| panic!("{fault}"));
            let back = read(&out);
            assert_same(&original, &back);
            // Of the same name: a package's only layer is named after it.
            let again = folder.path().join("again").join(format!("hud.{kind}"));
            std::fs::create_dir_all(again.parent().unwrap()).unwrap();
            author::convert(&back, &again).unwrap_or_else(|fault| panic!("{fault}"));
            assert!(
                std::fs::read(&out).unwrap() == std::fs::read(&again).unwrap(),
                "{asset} {kind}: not the same file"
            );
        }
    }
}

/// With its sidecar's rows, as the asset itself would carry them.
fn annotated(asset: &Path, sidecar: &str, out: &Path) -> Assembly {
    let mut assembly = read(asset);
    let sidecar = import::toml::read(&sample(sidecar)).unwrap_or_else(|fault| panic!("{fault}"));
    let rows = import::annotate::annotate(&assembly, Some(&sidecar), out).unwrap_or_else(|fault| panic!("{fault}"));
    rows.apply(&mut assembly);
    assembly
}

fn scene(path: &Path) -> eyebox::scene::Scene {
    let built = import::import(path, &import::ImportOptions::default());
    built.unwrap_or_else(|fault| panic!("{}: {fault}", path.display())).scene
}

/// All of a scene but its name and the files that it came from.
fn print(scene: &eyebox::scene::Scene) -> String {
    let mut scene = scene.clone();
    scene.name.clear();
    // Notes say where things stand, and the hash is of the files.
    scene.notes.clear();
    scene.hash.clear();
    let text = serde_json::to_string_pretty(&scene).expect("a scene is JSON");
    text.lines().filter(|line| !line.trim_start().starts_with("\"file\":")).collect::<Vec<_>>().join("\n")
}

/// A picture of few pixels, to the bit.
fn picture(scene: &eyebox::scene::Scene) -> Vec<(u64, u64)> {
    let mut scene = scene.clone();
    scene.eye.resolution = [12, 6];
    let (films, _) = render(&scene, Choice::Auto, 2, 7);
    let pixels = image(&films);
    assert!(mean(&pixels).0 > 0.0);
    pixels.into_iter().map(|(value, variance)| (value.to_bits(), variance.to_bits())).collect()
}

/// The first line that differs.
fn assert_equal_text(a: &str, b: &str, what: &str) {
    let text = a;
    if let Some((number, (a, b))) = a.lines().zip(b.lines()).enumerate().find(|(_, (a, b))| a != b) {
        let before: Vec<&str> = text.lines().take(number).skip(number.saturating_sub(12)).collect();
        panic!("{what}, line {number}:\n{a}\n{b}\nafter\n{}", before.join("\n"));
    }
    assert_eq!(a.lines().count(), b.lines().count(), "{what}");
}

/// glTF → USD → glTF and USD → glTF → USD, with all attributes: the same scene, the same picture.
#[test]
fn a_converted_hud_is_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["direct", "diffuse"] {
        for (format, first, second) in [("glb", "usda", "glb"), ("glb", "usdc", "gltf"), ("usda", "glb", "usdc")] {
            let twin = if format == "glb" { "" } else { "_usd" };
            let sidecar = format!("hud-{kind}/hud{twin}.optics.toml");
            let asset = sample(&format!("hud-{kind}/hud_{kind}.{format}"));
            let original = scene(&sample(&sidecar));
            let rich = annotated(&asset, &sidecar, folder.path());
            let out = folder.path().join(format!("{kind}_{format}.{first}"));
            author::convert(&rich, &out).unwrap_or_else(|fault| panic!("{fault}"));
            let back = folder.path().join(format!("{kind}_{format}_{first}.{second}"));
            author::convert(&annotated_by_itself(&out), &back).unwrap_or_else(|fault| panic!("{fault}"));
            let wanted = picture(&original);
            for file in [&out, &back] {
                let what = format!("{kind} {format} {}", file.display());
                let new = scene(file);
                assert_equal_text(&print(&original), &print(&new), &what);
                assert!(picture(&new) == wanted, "{what}");
            }
        }
    }
}

/// What `convert` makes of an asset without a sidecar.
fn annotated_by_itself(asset: &Path) -> Assembly {
    let mut assembly = read(asset);
    let rows = import::annotate::annotate(&assembly, None, asset.parent().unwrap());
    rows.unwrap_or_else(|fault| panic!("{fault}")).apply(&mut assembly);
    assembly
}

/// The two versions of each HUD, which come from different exporters, give the same picture.
#[test]
fn twins_give_the_same_picture() {
    for kind in ["direct", "diffuse"] {
        let of = |file: &str, seed: u64| {
            let mut scene = scene(&sample(&format!("hud-{kind}/{file}")));
            scene.eye.resolution = [24, 12];
            let (films, _) = render(&scene, Choice::Auto, 24, seed);
            image(&films)
        };
        let (gltf, usd) = (of("hud.optics.toml", 1), of("hud.usda", 2));
        let (worst, bound) = worst_z(&block_z(&gltf, &usd, 24, 4), 1e-3);
        eprintln!("{kind}: {:?} {:?}, worst z {worst:.2} of {bound:.2}", mean(&gltf), mean(&usd));
        assert!(worst < bound, "{kind}: {worst} of {bound}");
        let biased: Vec<(f64, f64)> = usd.iter().map(|p| (p.0 * 1.1, p.1)).collect();
        let (worst, bound) = worst_z(&block_z(&gltf, &biased, 24, 4), 1e-3);
        assert!(worst > bound, "{kind}: a bias of 10 % must be found: {worst} of {bound}");
    }
}

/// Copies a folder with what is below it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let (old, new) = (entry.path(), to.join(entry.file_name()));
        if old.is_dir() {
            copy(&old, &new);
        } else {
            // Not the permissions: in a source tree that is read-only no copy could be written over.
            std::fs::write(&new, std::fs::read(&old).unwrap()).unwrap();
        }
    }
}

/// `EYEBOX_BLESS=1` rewrites the samples' layers.
#[test]
fn the_samples_layers_are_what_annotate_writes() {
    for kind in ["direct", "diffuse"] {
        let home = sample(&format!("hud-{kind}"));
        let folder = tempfile::tempdir().unwrap();
        copy(&home, folder.path());
        let assembly = read(&folder.path().join(format!("hud_{kind}.usda")));
        let sidecar = import::toml::read(&folder.path().join("hud_usd.optics.toml")).unwrap();
        let rows = import::annotate::annotate(&assembly, Some(&sidecar), folder.path());
        let rows = rows.unwrap_or_else(|fault| panic!("{fault}"));
        let out = folder.path().join("hud.usda");
        author::annotate(&assembly, &rows, &out).unwrap_or_else(|fault| panic!("{fault}"));
        let with = scene(&folder.path().join("hud_usd.optics.toml"));
        assert_equal_text(&print(&with), &print(&scene(&out)), kind);
        if std::env::var_os("EYEBOX_BLESS").is_some() {
            std::fs::copy(&out, home.join("hud.usda")).unwrap();
        }
        let (new, old) = (std::fs::read_to_string(&out), std::fs::read_to_string(home.join("hud.usda")));
        assert_equal_text(&new.unwrap(), &old.unwrap_or_default(), kind);
    }
}

#[test]
fn an_empty_annotation_is_a_layer_that_changes_nothing() {
    let asset = sample("hud-direct/hud_direct.usda");
    let assembly = read(&asset);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("thin.usda");
    author::annotate(&assembly, &Default::default(), &out).unwrap_or_else(|fault| panic!("{fault}"));
    let text = std::fs::read_to_string(&out).unwrap();
    assert!(!text.contains("over"), "{text}");
    let mut back = read(&out);
    assert_eq!((back.unit_m, back.axes, back.stage.clone()), (assembly.unit_m, assembly.axes, assembly.stage.clone()));
    back.nodes.iter_mut().for_each(|node| node.at = Default::default());
    assert_same(&assembly, &back);
}
