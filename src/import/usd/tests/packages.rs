//! Packages, packages inside of packages, and the pictures in them.

use super::kit::{notes, paths};
use crate::ReadOptions;
use crate::usd::read;
use eyebox_base::package;
use eyebox_scene::assembly::LightForm;
use openusd::usdz::ArchiveWriter;
use std::io::Cursor;

fn pack(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ArchiveWriter::new(Cursor::new(Vec::new()));
    entries.iter().for_each(|(name, bytes)| archive.add_layer(name, bytes).unwrap());
    archive.finish().unwrap().into_inner()
}

const HEAD: &str = "#usda 1.0\n(\n    defaultPrim = \"P\"\n    metersPerUnit = 1\n)\n";

#[test]
fn a_package_may_begin_with_a_package() {
    let folder = tempfile::tempdir().unwrap();
    let part = format!("{HEAD}def Xform \"P\" {{ def Sphere \"S\" {{ }} }}\n");
    let other = pack(&[("first.usda", HEAD.as_bytes()), ("sub/part.usda", part.as_bytes())]);
    let root = format!(
        "{HEAD}def Xform \"P\" {{\n    def \"a\" ( references = @./other.usdz[sub/part.usda]@ ) {{ }}\n    def \"b\" ( references = @./parts.usdz@ ) {{ }}\n}}\n"
    );
    let parts = pack(&[("inner.usdz", &pack(&[("part.usda", part.as_bytes())]))]);
    let inner = pack(&[("root.usda", root.as_bytes()), ("other.usdz", &other), ("parts.usdz", &parts)]);
    let mut outer = pack(&[("inner.usdz", &inner)]);
    let file = folder.path().join("a.usdz");
    std::fs::write(&file, &outer).unwrap();
    let found = read(&file, &ReadOptions::default()).unwrap();
    assert_eq!(paths(&found), ["P", "P/a", "P/a/S", "P/b", "P/b/S"], "{}", notes(&found));
    assert_eq!(found.dependencies, std::slice::from_ref(&file));
    // A package that never ends.
    for _ in 0..2 * package::MOST_NESTED {
        outer = pack(&[("inner.usdz", &outer)]);
    }
    std::fs::write(&file, &outer).unwrap();
    assert!(read(&file, &ReadOptions::default()).is_err());
    std::fs::write(&file, &inner[..inner.len() - 40]).unwrap();
    assert!(read(&file, &ReadOptions::default()).is_err());
}

#[test]
fn pictures_in_packages_are_named_by_their_entry() {
    let folder = tempfile::tempdir().unwrap();
    let root = format!(
        r#"{HEAD}def Xform "P" {{
    def DomeLight "sky" {{ asset inputs:texture:file = @./maps/sky.hdr@ }}
    def Material "M" {{
        token outputs:surface.connect = </P/M/S.outputs:surface>
        def Shader "S" {{ uniform token info:id = "UsdPreviewSurface" }}
        def Shader "T" {{ uniform token info:id = "UsdUVTexture"
            asset inputs:file = @maps/wood.png@ }}
    }}
    def Xform "A" {{ asset eyebox:slide:image = @./maps/slide.png@
        double2 eyebox:slide:size = (1, 1) }}
}}
"#
    );
    let files: [(&str, &[u8]); 4] = [
        ("root.usda", root.as_bytes()),
        ("maps/sky.hdr", b"sky"),
        ("maps/wood.png", b"wood"),
        ("maps/slide.png", b"slide"),
    ];
    let file = folder.path().join("a.usdz");
    std::fs::write(&file, pack(&files)).unwrap();
    let found = read(&file, &ReadOptions::default()).unwrap();
    let entry = |name: &str| folder.path().join(format!("a.usdz[maps/{name}]"));
    let LightForm::Dome { image: Some(image), .. } = &found.lights[0].form else { panic!("no dome") };
    assert_eq!((image, package::read(image).unwrap()), (&entry("sky.hdr"), b"sky".to_vec()));
    assert_eq!(found.textures.iter().map(|(file, _)| file).collect::<Vec<_>>(), [&entry("wood.png")]);
    let all = crate::dependencies(&file, &ReadOptions::default()).unwrap();
    let all: Vec<_> = all.iter().map(|one| (one.file.clone(), one.role.as_str(), one.there)).collect();
    let want = [
        (file.clone(), "asset", true),
        (entry("slide.png"), "image", true),
        (entry("wood.png"), "texture", true),
        (entry("sky.hdr"), "image", true),
    ];
    assert_eq!(all, want);
    // The same asset as a folder.
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let all = crate::dependencies(
        &folder.path().join("root.usda"),
        &ReadOptions { frame: Some(1.0), ..ReadOptions::default() },
    )
    .unwrap();
    assert!(all.iter().any(|one| one.file == folder.path().join("maps/wood.png") && !one.used && one.there));
}

/// usd-core writes names in UTF-8 without the mark that says so.
#[test]
fn names_need_no_mark() {
    let folder = tempfile::tempdir().unwrap();
    let root = format!("{HEAD}def Xform \"P\" {{ def Sphere \"S\" {{ }} }}\n");
    let marked = pack(&[("größe-レンズ.usda", root.as_bytes())]);
    let mut plain = marked.clone();
    for start in [&b"PK\x01\x02"[..], b"PK\x03\x04"] {
        let at = plain.windows(4).position(|four| four == start).unwrap();
        let flags = at + if start[2] == 1 { 9 } else { 7 };
        assert_eq!(plain[flags] & 8, 8);
        plain[flags] &= !8;
    }
    for (name, bytes) in [("marked.usdz", &marked), ("plain.usdz", &plain)] {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        let found = read(&file, &ReadOptions::default()).unwrap_or_else(|fault| panic!("{fault}"));
        assert_eq!(paths(&found), ["P", "P/S"], "{name}");
    }
    assert_eq!(package::with_names_in_utf8(&marked), None);
    for length in 0..plain.len() {
        let _ = package::with_names_in_utf8(&plain[..length]);
    }
}
