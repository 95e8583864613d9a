//! Extensions: which we use, which have no bearing on light, and which must not be passed over in silence.

use super::at::At;
use super::notes::Notes;
use super::variants;
use crate::json::step;
use eyebox_base::{Code, Where, error::Result, error::nearest_name};
use eyebox_scene::{Note, Severity};
use serde_json::Value as Json;
use std::collections::HashMap;

pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";
/// The same under its later name, with codecs added.
pub(super) const MESHOPT_KHR: &str = "KHR_meshopt_compression";
pub(super) const VISIBILITY: &str = "KHR_node_visibility";

/// What becomes of an extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    /// Read and applied.
    Applied,
    /// About other encodings of textures, metadata or playback: nothing of light is lost without it, or what is lost is said where
    /// it is met.
    NoBearing,
    /// Changes what is seen and is not applied: said where it is there, refused where the asset requires it.
    Refused,
}

/// All extensions that are known.
const KNOWN: [(&str, Standing); 38] = {
    use Standing::{Applied, NoBearing, Refused};
    [
        ("EYEBOX_optics", Applied),
        ("KHR_materials_ior", Applied),
        ("KHR_materials_dispersion", Applied),
        ("KHR_materials_transmission", Applied),
        ("KHR_materials_volume", Applied),
        ("KHR_materials_emissive_strength", Applied),
        ("KHR_materials_iridescence", Applied),
        ("KHR_materials_diffuse_transmission", Applied),
        ("KHR_materials_clearcoat", Applied),
        ("KHR_materials_sheen", Applied),
        ("KHR_materials_anisotropy", Applied),
        ("KHR_materials_specular", Applied),
        ("KHR_materials_unlit", Applied),
        ("KHR_materials_pbrSpecularGlossiness", Applied),
        ("KHR_texture_transform", Applied),
        ("EXT_texture_webp", Applied),
        ("KHR_lights_punctual", Applied),
        ("EXT_lights_ies", Applied),
        ("KHR_mesh_quantization", Applied),
        ("EXT_mesh_gpu_instancing", Applied),
        (DRACO, Applied),
        (MESHOPT, Applied),
        (MESHOPT_KHR, Applied),
        (VISIBILITY, Applied),
        ("KHR_xmp", NoBearing),
        ("KHR_xmp_json_ld", NoBearing),
        ("KHR_animation_pointer", NoBearing),
        ("KHR_interactivity", NoBearing),
        ("KHR_node_hoverability", NoBearing),
        ("KHR_node_selectability", NoBearing),
        ("EXT_mesh_features", NoBearing),
        ("EXT_mesh_manifold", NoBearing),
        ("EXT_structural_metadata", NoBearing),
        ("KHR_materials_variants", Applied),
        ("EXT_lights_image_based", Refused),
        ("KHR_materials_subsurface", Refused),
        ("KHR_materials_volume_scatter", Refused),
        ("MSFT_lod", Refused),
    ]
};

/// None for an extension that is not known. Whatever is about textures has no bearing, from whichever vendor: the second
/// word of a name says what it is about (glTF 2.0, extension naming).
fn standing(name: &str) -> Option<Standing> {
    let known = KNOWN.iter().find(|(own, _)| *own == name).map(|(_, standing)| *standing);
    known.or_else(|| (name.split('_').nth(1) == Some("texture")).then_some(Standing::NoBearing))
}

/// Refuses what the asset says it cannot be read without.
///
/// # Errors
/// A required extension that is not known, or known and not applied though it bears on light.
pub(super) fn check_required(root: &At<'_>) -> Result<()> {
    for at in root.list("extensionsRequired")? {
        let name = at.text()?;
        match standing(name) {
            Some(Standing::Applied | Standing::NoBearing) => {}
            Some(Standing::Refused) => {
                let what = format!("the asset requires `{name}`, which bears on light and is not applied here");
                return Err(at
                    .fault(what)
                    .expected("an asset that can be read without it")
                    .code(Code::RequiredExtensionUnknown));
            }
            None => {
                let what = format!("the asset requires an extension that is not known here: {}", name.escape_debug());
                return Err(at
                    .fault(what)
                    .nearest(name, KNOWN.iter().map(|(own, _)| *own))
                    .code(Code::RequiredExtensionUnknown));
            }
        }
    }
    Ok(())
}

/// Whether `KHR_node_visibility` hides a node, and with it whatever is below: meshes and lights, but not cameras.
///
/// # Errors
/// A `visible` that is neither true nor false.
pub(super) fn hides(node: &At<'_>) -> Result<bool> {
    let Some(extension) = node.extension(VISIBILITY)? else { return Ok(false) };
    let visible = extension.get("visible")?.map_or(Ok(true), |visible| visible.flag())?;
    Ok(!visible)
}

/// A note if an animation switches the visibility of nodes.
fn note_switched(root: &At<'_>, notes: &mut Notes) {
    let channels = root.json.get("animations").and_then(Json::as_array).into_iter().flatten();
    let channels = channels.filter_map(|animation| animation.get("channels")?.as_array()).flatten();
    let pointers = channels.filter_map(|channel| {
        channel.get("target")?.get("extensions")?.get("KHR_animation_pointer")?.get("pointer")?.as_str()
    });
    let end = format!("/extensions/{VISIBILITY}/visible");
    let count = pointers.filter(|pointer| pointer.ends_with(&end)).count();
    if count > 0 {
        let at = Where::Pointer { file: root.file.to_owned(), pointer: "/animations".to_owned() };
        let text = "an animation shows or hides nodes: `visible` holds as it is written";
        notes.add_many(Severity::Warning, at, text, count);
    }
}

/// One note per extension that is there and not used, with its count and its first place. `varied`: a variant was asked for.
pub(super) fn note_unused(root: &At<'_>, varied: bool, notes: &mut Notes) -> Result<()> {
    let mut found = Found::default();
    found.walk(root.json, &mut Vec::new());
    for (name, first, count) in found.list {
        let at = Where::Pointer { file: root.file.to_owned(), pointer: first };
        let text = if name == "EYEBOX_optics" {
            "`EYEBOX_optics` means nothing here: ignored".to_owned()
        } else if name == "KHR_materials_variants" && !varied {
            let names = variants::names(root)?;
            format!(
                "`KHR_materials_variants`: the default materials are used; --variant takes one of {}",
                names.join(", ")
            )
        } else {
            match standing(name) {
                Some(Standing::Refused) => format!("`{name}` bears on what is seen but is not used"),
                Some(Standing::Applied | Standing::NoBearing) => continue,
                None => {
                    let near = nearest_name(name, ["EYEBOX_optics"]);
                    let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                    format!("the extension `{}` is not known and was ignored{near}", name.escape_debug())
                }
            }
        };
        notes.add(Note::warning(at, text).code(Code::ExtensionUnused), count);
    }
    note_switched(root, notes);
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
