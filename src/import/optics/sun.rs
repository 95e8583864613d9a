//! `sun`: light from one direction.

use super::emitter::group_name;
use super::fields::Fields;
use super::sky::frame;
use crate::value::Value;
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::Note;
use eyebox_scene::attribute::Noun;
use glam::DVec3;

/// A sun before its direction is turned into the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SunSpec {
    /// Unit, towards the sun.
    pub direction: DVec3,
    pub illuminance_lx: f64,
    pub angle_deg: f64,
    pub group: String,
    /// The node whose axes `direction` is given in, or none for the asset's world.
    pub frame: Option<(String, Where)>,
}

pub fn sun(value: &Value, notes: &mut Vec<Note>) -> Result<SunSpec> {
    let fields = Fields::of(Noun::Sun, "sun", value, &[])?;
    let group = fields.text("group")?.unwrap_or("sun");
    Ok(SunSpec {
        direction: fields.need_direction("direction")?,
        illuminance_lx: fields.number_or("illuminance_lx", 100_000.0, notes)?,
        angle_deg: fields.number_or("angle_deg", 0.533, notes)?,
        group: group_name(group, fields.value("group").map_or(&value.at, |value| &value.at))?,
        frame: frame(&fields, notes)?,
    })
}
