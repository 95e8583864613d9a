//! Extensions: which we use, which have no bearing on light, and which must not be passed over in silence.

use super::at::At;
use super::notes::Notes;
use crate::base::{Code, Where, fault::Result, fault::nearest_name};
use crate::import::json::step;
use crate::scene::{Note, Severity};
use serde_json::Value as Json;
use std::collections::HashMap;

/// Read by this reader.
const USED: [&str; 15] = [
    "EYEBOX_optics",
    "KHR_materials_ior",
    "KHR_materials_dispersion",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_emissive_strength",
    "KHR_materials_iridescence",
    "KHR_materials_diffuse_transmission",
    "KHR_lights_punctual",
    "EXT_lights_ies",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    DRACO,
    MESHOPT,
    MESHOPT_KHR,
];

/// About textures (which are not used), metadata or playback.
const NO_BEARING: [&str; 11] = [
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
];
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";
/// The same under its later name, with codecs added.
pub(super) const MESHOPT_KHR: &str = "KHR_meshopt_compression";

/// They change what is seen, and are not used.
const BEARING: [&str; 12] = [
    "EXT_lights_image_based",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_subsurface",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume_scatter",
    "KHR_node_visibility",
    "MSFT_lod",
];

/// Refuses what the asset says it cannot be read without.
///
/// # Errors
/// A required extension that is not known.
pub(super) fn check_required(root: &At<'_>) -> Result<()> {
    for at in root.list("extensionsRequired")? {
        let name = at.text()?;
        if !USED.contains(&name) && !NO_BEARING.contains(&name) && !BEARING.contains(&name) {
            let fault = at.fault("the asset requires an extension that is not known here");
            return Err(fault.nearest(name, USED.into_iter().chain(BEARING)).code(Code::RequiredExtensionUnknown));
        }
    }
    Ok(())
}

/// One note per extension that is there and not used, with its count and its first place.
pub(super) fn note_unused(root: &At<'_>, notes: &mut Notes) -> Result<()> {
    let mut found = Found::default();
    found.walk(root.json, &mut Vec::new());
    for (name, first, count) in found.list {
        let at = Where::Pointer { file: root.file.to_owned(), pointer: first };
        let text = if name == "EYEBOX_optics" {
            "`EYEBOX_optics` means nothing here: ignored".to_owned()
        } else if name == "KHR_materials_variants" {
            "`KHR_materials_variants`: the default materials are used".to_owned()
        } else if name == "KHR_texture_transform" {
            let text = "`KHR_texture_transform` moves nothing: textures are not used";
            notes.add_many(Severity::Info, at, text, count);
            continue;
        } else if BEARING.contains(&name) {
            format!("`{name}` bears on what is seen but is not used")
        } else if USED.contains(&name) || NO_BEARING.contains(&name) {
            continue;
        } else {
            let near = nearest_name(name, ["EYEBOX_optics"]);
            let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            format!("the extension `{}` is not known and was ignored{near}", name.escape_debug())
        };
        notes.add(Note::warning(at, text).code(Code::ExtensionUnused), count);
    }
    if let Some(animation) = root.list("animations")?.first() {
        notes.info(animation, "animations are ignored: nodes stand as they are written");
    }
    Ok(())
}

/// The extensions of a document: name, first pointer, count.
#[derive(Default)]
struct Found<'a> {
    list: Vec<(&'a str, String, usize)>,
    index: HashMap<&'a str, usize>,
}

/// A step of a JSON pointer. Pointers are only written out for what is kept: keys can be long and what is below many.
enum Step<'a> {
    Key(&'a str),
    Item(usize),
}

impl<'a> Found<'a> {
    /// Finds every extension object, except inside our own and inside `extras`. The depth is bounded: the JSON reader
    /// allows 128 levels.
    fn walk(&mut self, json: &'a Json, path: &mut Vec<Step<'a>>) {
        match json {
            Json::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    path.push(Step::Item(i));
                    self.walk(item, path);
                    path.pop();
                }
            }
            Json::Object(entries) => {
                let inside = matches!(path.last(), Some(Step::Key("extensions")));
                for (key, entry) in entries.iter().filter(|(key, _)| *key != "extras") {
                    if inside {
                        self.add(key, path);
                    }
                    if !inside || key != "EYEBOX_optics" {
                        path.push(Step::Key(key));
                        self.walk(entry, path);
                        path.pop();
                    }
                }
            }
            Json::Null | Json::Bool(_) | Json::Number(_) | Json::String(_) => {}
        }
    }

    fn add(&mut self, name: &'a str, path: &[Step<'a>]) {
        if name == "EYEBOX_optics" && carries_optics(path) {
            return;
        }
        if let Some((_, _, count)) = self.index.get(name).and_then(|&i| self.list.get_mut(i)) {
            *count += 1;
            return;
        }
        let pointer = path.iter().fold(String::new(), |pointer, next| match next {
            Step::Key(key) => step(&pointer, key),
            Step::Item(i) => format!("{pointer}/{i}"),
        });
        self.index.insert(name, self.list.len());
        self.list.push((name, step(&pointer, name), 1));
    }
}

/// Whether our attributes are read at this place: in the extensions of the root, a material, a node or a primitive.
fn carries_optics(path: &[Step<'_>]) -> bool {
    use Step::{Item, Key};
    match path {
        [Key(_)] => true,
        [Key(list), Item(_), Key(_)] => *list == "materials" || *list == "nodes",
        [Key("meshes"), Item(_), Key("primitives"), Item(_), Key(_)] => true,
        _ => false,
    }
}
