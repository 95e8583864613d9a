//! `sky`: light from everywhere, as a picture, a number or a model.

use super::emitter::group_name;
use super::fields::Fields;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::Note;
use eyebox_scene::attribute::{Noun, SKIES, SUN_SKY, own_rows};

/// A sky before its picture is read or made, and turned.
#[derive(Debug, Clone, PartialEq)]
pub struct SkySpec {
    pub at: Where,
    pub kind: SkyKind,
    pub group: String,
    /// Which axis of the frame points to the zenith; none if it isn't said.
    pub up: Option<Up>,
    /// The node whose axes it follows, or none for the asset's world.
    pub frame: Option<(String, Where)>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum SkyKind {
    Image {
        image: String,
        at: Where,
        /// Of an EXR file.
        layer: Option<String>,
        /// None: what the picture says of itself.
        scale_cd_m2: Option<f64>,
        rotation_deg: f64,
    },
    Uniform {
        luminance_cd_m2: f64,
        /// None: white.
        rgb: Option<[f64; 3]>,
    },
    Overcast {
        /// Of the uniform sky that lights a horizontal plane as much.
        level_cd_m2: f64,
        ground_reflectance: f64,
    },
    Clear {
        elevation_deg: f64,
        azimuth_deg: f64,
        turbidity: f64,
        sun_group: String,
        ground_reflectance: f64,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Up {
    Y,
    Z,
}

/// Whether `name` has a meaning in a sky of this kind, one of [`SKIES`].
pub fn goes_with(kind: &str, name: &str) -> bool {
    let beside = SKIES.iter().find(|(own, _)| *own == kind).map_or(&[][..], |(_, beside)| beside);
    name == kind || name == "group" || beside.contains(&name)
}

/// The first of [`SKIES`] that is said, if any is.
pub fn kind_of<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<&'static str> {
    names.find_map(|name| SKIES.iter().map(|(kind, _)| *kind).find(|kind| *kind == name))
}

pub fn sky(value: &Value, notes: &mut Vec<Note>) -> Result<SkySpec> {
    let own: Vec<&str> = own_rows(Noun::Sky).map(|row| row.name).collect();
    let fields = Fields::of(Noun::Sky, "sky", value, &own)?;
    let name = kind(&fields)?;
    let group = fields.text("group")?.unwrap_or("sky");
    let group = group_name(group, place(&fields, "group"))?;
    let ground = |notes: &mut Vec<Note>| fields.number_or("ground_reflectance", 0.2, notes);
    let kind = match name {
        "image" => SkyKind::Image {
            image: fields.need_text(name)?.to_owned(),
            at: place(&fields, name).clone(),
            layer: fields.text("layer")?.map(str::to_owned),
            scale_cd_m2: fields.number("scale_cd_m2")?,
            rotation_deg: fields.number_or("rotation_deg", 0.0, notes)?,
        },
        "luminance_cd_m2" => {
            let rgb = fields.numbers::<3>("rgb")?;
            if rgb == Some([0.0; 3]) {
                return Err(Error::new(place(&fields, "rgb").clone(), "`rgb` of sky is black")
                    .expected("a number above 0 among its three; a sky without light has luminance_cd_m2 = 0"));
            }
            SkyKind::Uniform { luminance_cd_m2: fields.need_number(name)?, rgb }
        }
        "overcast_cd_m2" => {
            SkyKind::Overcast { level_cd_m2: fields.need_number(name)?, ground_reflectance: ground(notes)? }
        }
        _ => clear(fields.value(name).unwrap_or(value), ground(notes)?, notes)?,
    };
    let up = match fields.text("up")? {
        None => None,
        Some("y") => Some(Up::Y),
        Some("z") => Some(Up::Z),
        Some(other) => {
            return Err(
                Error::new(place(&fields, "up").clone(), format!("`up` of sky is \"{other}\"")).expected("one of y, z")
            );
        }
    };
    let frame = if goes_with(name, "frame") { frame(&fields, notes)? } else { None };
    Ok(SkySpec { at: value.at.clone(), kind, group, up, frame })
}

/// Which of [`SKIES`] it is. Faults: none, several, or what another one takes.
fn kind(fields: &Fields<'_>) -> Result<&'static str> {
    let kinds = SKIES.map(|(kind, _)| kind);
    let given: Vec<&str> = kinds.into_iter().filter(|kind| fields.has(kind)).collect();
    let one_of = || format!("one of {}", kinds.join(", "));
    let [kind] = given.as_slice() else {
        let (at, what) = match given.as_slice() {
            [first, second, ..] => (place(fields, second), format!("the sky has {first} and {second}")),
            [] | [_] => (fields.at(), "the sky does not say what it is".to_owned()),
        };
        return Err(Error::new(at.clone(), what).expected(one_of()));
    };
    let kind = kinds.into_iter().find(|own| own == kind).unwrap_or("image");
    for row in own_rows(Noun::Sky) {
        let Some(value) = fields.value(row.name).filter(|_| !goes_with(kind, row.name)) else { continue };
        let others: Vec<&str> = kinds.into_iter().filter(|other| goes_with(other, row.name)).collect();
        return Err(Error::new(value.at.clone(), format!("`{}` means nothing to a sky of {kind}", row.name))
            .expected(format!("it beside {}", others.join(" or "))));
    }
    Ok(kind)
}

fn clear(value: &Value, ground_reflectance: f64, notes: &mut Vec<Note>) -> Result<SkyKind> {
    let fields = Fields::of(Noun::Sky, "sun_sky", value, &SUN_SKY)?;
    let group = fields.text("sun_group")?.unwrap_or("sun");
    Ok(SkyKind::Clear {
        elevation_deg: fields.need_number("elevation_deg")?,
        azimuth_deg: fields.number_or("azimuth_deg", 0.0, notes)?,
        turbidity: fields.need_number("turbidity")?,
        sun_group: group_name(group, place(&fields, "sun_group"))?,
        ground_reflectance,
    })
}

/// Where an attribute stands, or else the table.
fn place<'a>(fields: &Fields<'a>, name: &str) -> &'a Where {
    fields.value(name).map_or(fields.at(), |value| &value.at)
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
