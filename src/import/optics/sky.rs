//! `sky`: a panorama that lights the scene from everywhere.

use super::emitter::group_name;
use super::fields::Fields;
use crate::base::Where;
use crate::base::fault::Result;
use crate::import::value::Value;
use crate::scene::Note;
use crate::scene::attribute::Noun;

/// A sky before its picture is read and turned.
#[derive(Debug, Clone, PartialEq)]
pub struct SkySpec {
    pub image: String,
    pub image_at: Where,
    /// Of an EXR file.
    pub layer: Option<String>,
    pub scale_cd_m2: f64,
    pub rotation_deg: f64,
    pub group: String,
    /// The node whose axes it follows, or none for the asset's world.
    pub frame: Option<(String, Where)>,
}

pub fn sky(value: &Value, notes: &mut Vec<Note>) -> Result<SkySpec> {
    let fields = Fields::of(Noun::Sky, "sky", value, &[])?;
    let group = fields.text("group")?.unwrap_or("sky");
    Ok(SkySpec {
        image: fields.need_text("image")?.to_owned(),
        image_at: fields.value("image").map_or_else(|| value.at.clone(), |value| value.at.clone()),
        layer: fields.text("layer")?.map(str::to_owned),
        scale_cd_m2: fields.number_or("scale_cd_m2", 1.0, notes)?,
        rotation_deg: fields.number_or("rotation_deg", 0.0, notes)?,
        group: group_name(group, fields.value("group").map_or(&value.at, |value| &value.at))?,
        frame: frame(&fields, notes)?,
    })
}

/// The `frame` of a sky or an eye.
pub(super) fn frame(fields: &Fields<'_>, notes: &mut Vec<Note>) -> Result<Option<(String, Where)>> {
    Ok(match (fields.text("frame")?, fields.value("frame")) {
        (Some("asset"), _) => None,
        (Some(name), Some(value)) => Some((name.to_owned(), value.at.clone())),
        (Some(_), None) | (None, _) => {
            notes.push(fields.defaulted("frame"));
            None
        }
    })
}
