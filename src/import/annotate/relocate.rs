//! File names inside attributes, rewritten for another folder.

use eyebox_base::Where;
use eyebox_base::relative_path::{folder_of, relocated};
use eyebox_scene::assembly::Assembly;
use eyebox_scene::attribute::{Form, ROWS};
use eyebox_scene::value::{Data, Value};
use std::path::Path;

/// Whether the text of an attribute is a file name; the sidecar's `asset` is that of the file that is written.
fn is_file(key: &str) -> bool {
    key != "asset" && ROWS.iter().any(|row| row.name == key && row.form == Form::File)
}

/// Rewrites every file name below `value`, which is relative to the file that the name stands in, for the folder `out`.
pub fn value(value: &mut Value, out: &Path) {
    match &mut value.data {
        Data::Bool(_) | Data::Number(_) | Data::Text(_) => {}
        Data::List(items) => items.iter_mut().for_each(|item| self::value(item, out)),
        Data::Table(entries) => {
            for (key, item) in entries {
                let folder = folder(&item.at).filter(|_| is_file(key));
                if let (Data::Text(name), Some(folder)) = (&mut item.data, folder) {
                    *name = relocated(name, &folder, out);
                } else {
                    self::value(item, out);
                }
            }
        }
    }
}

fn folder(at: &Where) -> Option<std::path::PathBuf> {
    match at {
        Where::File(file) | Where::Line { file, .. } | Where::Pointer { file, .. } | Where::Prim { file, .. } => {
            Some(folder_of(file))
        }
        Where::Nowhere | Where::Part { .. } | Where::Option(_) => None,
    }
}

/// Rewrites every file name in the attributes of `assembly`.
pub fn assembly(assembly: &mut Assembly, out: &Path) {
    let rows = assembly.optics.iter_mut();
    let rows = rows.chain(assembly.nodes.iter_mut().filter_map(|node| node.attributes.as_mut()));
    let rows = rows.chain(assembly.materials.iter_mut().filter_map(|material| material.attributes.as_mut()));
    let rows = rows.chain(assembly.meshes.iter_mut().flat_map(|mesh| mesh.attributes.iter_mut().flatten()));
    rows.chain(assembly.lights.iter_mut().filter_map(|light| light.attributes.as_mut()))
        .for_each(|row| value(row, out));
}
