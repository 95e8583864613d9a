//! `eye`: where the picture is seen from.

use super::fields::Fields;
use super::slide::ORTHOGONAL;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::Noun;
use eyebox_scene::{BinocularLimits, Note};
use glam::DVec3;

/// Where the search for the pupil of an adapted eye begins: that of an eye by day.
const ADAPTED_M: f64 = 4e-3;

/// Where an eye stands and looks, in its frame: metres from the frame's origin along its axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    pub position_m: DVec3,
    /// Unit, `up` orthogonal to `look`.
    pub look: DVec3,
    pub up: DVec3,
    /// A node, or none for the asset's world.
    pub frame: Option<(String, Where)>,
}

/// An eye as it is described; what isn't said is left open, since a camera of the asset may say it.
#[derive(Debug, Clone, PartialEq)]
pub struct EyeSpec {
    pub at: Where,
    /// None if neither position, look, up nor frame is said.
    pub pose: Option<Pose>,
    pub pupil_diameter_m: f64,
    /// The pupil follows from the picture.
    pub adapts: bool,
    pub focus_distance_m: f64,
    pub fov_deg: Option<f64>,
    pub resolution: Option<[usize; 2]>,
    pub age: f64,
    pub limits: BinocularLimits,
}

/// What a camera of the asset says of its lens, in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Lens {
    pub pupil_diameter_m: Option<f64>,
    pub focus_distance_m: Option<f64>,
}

/// `lens`: of the camera that stands for the eye if it does not say where it is.
pub fn eye(value: &Value, lens: Lens, notes: &mut Vec<Note>) -> Result<EyeSpec> {
    let fields = Fields::of(Noun::Eye, "eye", value, &[])?;
    let pose = if ["position", "look", "up", "frame"].iter().any(|name| fields.has(name)) {
        let (look, up) = (fields.need_direction("look")?, fields.need_direction("up")?);
        let cosine = look.dot(up);
        if cosine.abs() > ORTHOGONAL {
            let at = fields.value("up").map_or(&value.at, |value| &value.at);
            let across = up - cosine * look;
            let parallel = across.length() <= ORTHOGONAL;
            // No part of `up` is left to keep: any direction across will do.
            let across = if parallel { look.any_orthonormal_vector() } else { across.normalize() };
            // No −0 for people.
            let [x, y, z] = across.to_array().map(|x| if x.abs() < 5e-7 { 0.0 } else { x });
            let how = if parallel { "parallel" } else { "not orthogonal" };
            return Err(Error::new(at.clone(), format!("`up` of eye is {how} to `look`"))
                .expected(format!("a right angle, e.g. up = [{x:.6}, {y:.6}, {z:.6}]"))
                .code(Code::EyeImpossible));
        }
        Some(Pose {
            position_m: fields.place_m("position")?.ok_or_else(|| fields.missing("position"))?,
            look,
            up: (up - cosine * look).normalize(),
            frame: super::sky::frame(&fields, notes)?,
        })
    } else {
        None
    };
    let adapts = fields.value("pupil_diameter").and_then(|value| value.text()) == Some("auto");
    let pupil_diameter_m = if adapts { Some(ADAPTED_M) } else { fields.length_m("pupil_diameter")? };
    let lens = if pose.is_none() { lens } else { Lens::default() };
    let mut or = |given: Option<f64>, name: &str, default: f64| {
        given.unwrap_or_else(|| {
            notes.push(fields.defaulted(name));
            default
        })
    };
    let resolution = match fields.numbers::<2>("resolution")? {
        Some(pixels) if pixels.iter().all(|pixels| pixels.fract() == 0.0) => Some(pixels.map(|pixels| pixels as usize)),
        Some([w, h]) => {
            let at = fields.value("resolution").map_or(&value.at, |value| &value.at);
            return Err(Error::new(at.clone(), format!("`resolution` is {w} x {h}"))
                .expected("whole numbers of pixels")
                .code(Code::EyeImpossible));
        }
        None => None,
    };
    Ok(EyeSpec {
        at: value.at.clone(),
        pose,
        pupil_diameter_m: or(pupil_diameter_m.or(lens.pupil_diameter_m), "pupil_diameter", 4e-3),
        adapts,
        focus_distance_m: or(
            fields.length_m("focus_distance")?.or(lens.focus_distance_m),
            "focus_distance",
            f64::INFINITY,
        ),
        fov_deg: fields.number("fov_deg")?,
        resolution,
        age: or(fields.number("age")?, "age", 45.0),
        limits: limits(&fields)?,
    })
}

/// Limits of two eyes: those of the width need to know where the image is meant to be, and a place alone limits nothing.
fn limits(fields: &Fields<'_>) -> Result<BinocularLimits> {
    let out = BinocularLimits {
        convergence_mrad: fields.number("convergence_mrad")?,
        divergence_mrad: fields.number("divergence_mrad")?,
        dipvergence_mrad: fields.number("dipvergence_mrad")?,
        image_distance_m: fields.length_m("image_distance")?,
    };
    let across = ["convergence_mrad", "divergence_mrad"].into_iter().find(|name| fields.has(name));
    match (across, out.image_distance_m) {
        (Some(name), None) => {
            let at = fields.value(name).map_or(Where::Nowhere, |value| value.at.clone());
            Err(Error::new(
                at,
                format!("`{name}` of eye counts from where the image is meant to be, which is not said"),
            )
            .expected("image_distance, a length or \"inf\"")
            .code(Code::EyeImpossible))
        }
        (Some(_), Some(_)) | (None, _) => Ok(out),
    }
}
