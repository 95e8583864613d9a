//! Lights and cameras, which hang on nodes.

use super::document::Document;
use super::value;
use eyebox_base::error::Result;
use eyebox_base::relative_path::{folder_of, relative, slashed};
use eyebox_scene::assembly::{Assembly, Camera, Film, Frustum, LightForm, LightSource};
use eyebox_scene::value::{Data, Value};
use serde_json::{Value as Json, json};
use std::path::Path;

pub const PUNCTUAL: &str = "KHR_lights_punctual";

/// Entries of a camera's `extras`.
const PUPIL: &str = "eyebox_pupil_m";
const FOCUS: &str = "eyebox_focus_m";
/// Focal length, width and height of the film, how far its middle is to the right and up.
const FILM: &str = "eyebox_film_m";
const SHUTTER: &str = "eyebox_shutter_frames";

/// The light of `KHR_lights_punctual` that `light` is; none, with a note, for a form that glTF has not.
pub fn light(document: &mut Document, light: &LightSource) -> Option<Json> {
    let name = &light.name;
    let (kind, strength, cone) = match light.form {
        LightForm::Point { intensity_cd, cone: None } => ("point", intensity_cd, None),
        LightForm::Point { intensity_cd, cone: Some(cone) } => ("spot", intensity_cd, Some(cone)),
        LightForm::Distant { illuminance_lx, angle } => {
            if angle > 0.0 {
                document.note(&light.at, format!("light `{name}`: its disc of {angle} rad becomes parallel light"));
            }
            ("directional", illuminance_lx, None)
        }
        // See `lamp`.
        LightForm::Dome { .. }
        | LightForm::Rect { .. }
        | LightForm::Disk { .. }
        | LightForm::Sphere { .. }
        | LightForm::Cylinder { .. } => return None,
    };
    if light.profile.is_some() {
        document.note(&light.at, format!("light `{name}`: its intensity distribution is not written"));
    }
    // Lanes from 0 to 1; luminance 1 is taken back into the strength.
    let most = light.color.iter().copied().fold(0.0, f64::max);
    let (scale, color) = if most > 1.0 { (most, light.color.map(|lane| lane / most)) } else { (1.0, light.color) };
    let intensity = value::number(strength * scale)?;
    let mut json = json!({ "name": name, "type": kind, "intensity": intensity });
    if color != [1.0; 3] {
        json["color"] = json!(color);
    }
    if let Some((inner, outer)) = cone {
        json["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
    }
    Some(json)
}

/// The sky that a dome light is, if nothing else says a sky.
pub fn sky(document: &mut Document, assembly: &Assembly, out: &Path) -> Option<Value> {
    if assembly.optics.as_ref().is_some_and(|optics| optics.get("sky").is_some()) {
        return None;
    }
    let mut domes = assembly.lights.iter().filter_map(|light| match &light.form {
        LightForm::Dome { scale_cd_m2, image } => Some((light, *scale_cd_m2, image.as_ref())),
        LightForm::Point { .. }
        | LightForm::Distant { .. }
        | LightForm::Rect { .. }
        | LightForm::Disk { .. }
        | LightForm::Sphere { .. }
        | LightForm::Cylinder { .. } => None,
    });
    let (light, scale, image) = domes.next()?;
    if domes.next().is_some() {
        document.note(&light.at, "of several dome lights only the first becomes the sky".into());
    }
    let row = |key: &str, data: Data| (key.to_owned(), Value::new(data, light.at.clone()));
    let [r, g, b] = light.color;
    if r != g || g != b {
        document.note(&light.at, format!("the colour of the dome light `{}` is not written", light.name));
    }
    let Some(image) = image else {
        let rows = vec![row("luminance_cd_m2", Data::Number(scale))];
        return Some(Value::new(Data::Table(rows), light.at.clone()));
    };
    let name = if image.is_absolute() {
        image.to_string_lossy().into_owned()
    } else {
        let file = image.file_name().map(Path::new).unwrap_or(image);
        slashed(&relative(&folder_of(out), &folder_of(image)).join(file))
    };
    let frame = assembly.nodes.get(light.node)?.path.clone();
    let rows =
        vec![row("image", Data::Text(name)), row("scale_cd_m2", Data::Number(scale)), row("frame", Data::Text(frame))];
    Some(Value::new(Data::Table(rows), light.at.clone()))
}

/// The glTF camera; `unit_m`: metres per unit of the asset. Distances of clipping, which glTF wants, mean nothing to light: where
/// nobody says them, they are wide.
pub fn camera(camera: &Camera, unit_m: f64) -> Result<Json> {
    let name = &camera.name;
    let Frustum { near, far, half, film, shutter } = camera.frustum;
    let near = near.map_or(0.01, |near| near * unit_m);
    let mut out = match camera.yfov {
        Some(yfov) => {
            let mut lens = json!({ "yfov": yfov, "znear": near });
            if let Some(aspect) = camera.aspect {
                lens["aspectRatio"] = json!(aspect);
            }
            if let Some(far) = far {
                lens["zfar"] = json!(far * unit_m);
            }
            let mut out = json!({ "name": name, "type": "perspective", "perspective": lens });
            // glTF's cameras are pinholes: what makes ours a lens, our reader takes from here, m.
            for (key, length) in [(PUPIL, camera.pupil), (FOCUS, camera.focus)] {
                if let Some(length) = length {
                    out["extras"][key] = json!(length * unit_m);
                }
            }
            out
        }
        None => {
            let [x, y] = half.map_or([1.0; 2], |half| half.map(|x| x * unit_m));
            let far = far.map_or(near + 1000.0, |far| far * unit_m);
            json!({
                "name": name, "type": "orthographic",
                "orthographic": { "xmag": x, "ymag": y, "zfar": far, "znear": near },
            })
        }
    };
    if let Some(Film { focal, size: [wide, high], offset: [right, up] }) = film {
        out["extras"][FILM] = json!([focal, wide, high, right, up].map(|length| length * unit_m));
    }
    if let Some(times) = shutter {
        out["extras"][SHUTTER] = json!(times);
    }
    Ok(out)
}
