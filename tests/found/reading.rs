//! Honest files that were refused, or read in silence as something else.

use super::{data, read, warnings};

/// Unity's exporter lists nodes that have a parent.
#[test]
fn a_scene_may_list_what_is_no_root() {
    let built = read(&data("not_a_root.gltf"), &[]);
    assert_eq!(built.scene.parts.len(), 1);
    assert!(
        warnings(&built).iter().any(|text| text.contains("lists a node that has a parent")),
        "{:?}",
        built.scene.notes
    );
    let text = std::fs::read_to_string(data("not_a_root.gltf")).expect("a text");
    let folder = tempfile::tempdir().expect("a folder");
    let asset = folder.path().join("a.gltf");
    // What is above stays out, unless it is listed, too; and what is listed twice is there once.
    let moved = text.replace(r#"{"name": "tmpParent","#, r#"{"name": "tmpParent", "translation": [5, 0, 0],"#);
    for (nodes, shift) in [("[1]", 0.0), ("[0, 1]", 5.0), ("[1, 0]", 5.0), ("[1, 1]", 0.0), ("[0]", 5.0)] {
        std::fs::write(&asset, moved.replace(r#""nodes": [1]"#, &format!(r#""nodes": {nodes}"#))).expect("a file");
        let built = read(&asset, &[]);
        assert_eq!(built.scene.parts.len(), 1, "{nodes}");
        assert_eq!(built.scene.parts[0].to_world.translation.x, shift, "{nodes}");
        assert_eq!(warnings(&built).is_empty(), nodes == "[0]", "{nodes}: {:?}", built.scene.notes);
    }
}
