//! Lights as UsdLux, the camera as UsdGeomCamera. Their numbers are single precision in USD; `customData["eyebox"]`
//! has those that are not.

use super::layer::{Datum, Prim, Property};
use super::name::Siblings;
use super::optics;
use super::stage::{Writing, matrix, named};
use eyebox_base::error::Result;
use eyebox_scene::assembly::{Camera, Film, Frustum, LightForm, LightSource, ProfileSource};

/// The focal length of a lens for film of 36 mm × 24 mm that everybody knows, m.
const USUAL_M: f64 = 0.05;

/// Appends a light below the node that holds it.
///
/// A point is a sphere with `treatAsPoint` and `normalize`: a sphere of radius r and luminance L has the intensity
/// π r² L, and normalising divides by its area 4π r² (UsdLuxLightAPI, `inputs:normalize`), so that an intensity I takes
/// `inputs:intensity` = 4 I, whatever the radius, with the area in metres: 4 I / unit² in scene units.
pub(super) fn write(
    writing: &Writing<'_>,
    source: &LightSource,
    depth: usize,
    siblings: &mut Siblings,
    prims: &mut Vec<Prim>,
) -> Result<()> {
    let mut inputs: Vec<Property> = Vec::new();
    let mut number = |name: &str, x: f64| inputs.push(Property::new(format!("inputs:{name}"), Datum::Float(x as f32)));
    let mut exact: Vec<(&'static str, f64)> = Vec::new();
    let unit = optics::unit(writing.assembly);
    let mut image = None;
    let mut spot = false;
    let type_name = match &source.form {
        LightForm::Point { intensity_cd, cone } => {
            // With a profile that says how strong it is, a factor of its candela.
            let measured = source.profile.as_ref().is_some_and(|profile| !profile.normalize);
            number("intensity", if measured { *intensity_cd } else { 4.0 * intensity_cd / (unit * unit) });
            number("radius", 0.0);
            exact.push(("intensity_cd", *intensity_cd));
            if let Some((inner, outer)) = cone {
                spot = true;
                number("shaping:cone:angle", outer.to_degrees());
                number("shaping:cone:softness", if *outer > 0.0 { 1.0 - inner / outer } else { 0.0 });
                exact.extend([("cone_inner", *inner), ("cone_outer", *outer)]);
            }
            "SphereLight"
        }
        LightForm::Distant { illuminance_lx, angle } => {
            number("intensity", *illuminance_lx);
            number("angle", angle.to_degrees());
            exact.extend([("illuminance_lx", *illuminance_lx), ("angle", *angle)]);
            "DistantLight"
        }
        LightForm::Rect { luminance_cd_m2, width, height } => {
            number("intensity", *luminance_cd_m2);
            number("width", *width);
            number("height", *height);
            exact.extend([("luminance_cd_m2", *luminance_cd_m2), ("width", *width), ("height", *height)]);
            "RectLight"
        }
        LightForm::Disk { luminance_cd_m2, radius } => {
            number("intensity", *luminance_cd_m2);
            number("radius", *radius);
            exact.extend([("luminance_cd_m2", *luminance_cd_m2), ("radius", *radius)]);
            "DiskLight"
        }
        LightForm::Sphere { luminance_cd_m2, radius } => {
            number("intensity", *luminance_cd_m2);
            number("radius", *radius);
            exact.extend([("luminance_cd_m2", *luminance_cd_m2), ("radius", *radius)]);
            "SphereLight"
        }
        LightForm::Cylinder { luminance_cd_m2, radius, length } => {
            number("intensity", *luminance_cd_m2);
            number("radius", *radius);
            number("length", *length);
            exact.extend([("luminance_cd_m2", *luminance_cd_m2), ("radius", *radius), ("length", *length)]);
            "CylinderLight"
        }
        LightForm::Dome { scale_cd_m2, image: file } => {
            number("intensity", *scale_cd_m2);
            exact.push(("scale_cd_m2", *scale_cd_m2));
            image.clone_from(file);
            "DomeLight"
        }
    };
    let mut prim = Prim::def(depth, type_name, siblings.name(&source.name, "Light"));
    named(&mut prim, &source.name);
    prim.marks.push(("part", Datum::Bool(true)));
    prim.marks.extend(exact.into_iter().map(|(key, x)| (key, Datum::Double(x))));
    prim.properties = inputs;
    match source.kelvin {
        // The reader makes the colour of it.
        Some(kelvin) => {
            prim.push(Property::new("inputs:enableColorTemperature", Datum::Bool(true)));
            prim.push(Property::new("inputs:colorTemperature", Datum::Float(kelvin as f32)));
        }
        None => {
            prim.marks.push(("color", Datum::Double3(source.color)));
            let color = Datum::Float3(source.color.map(|lane| lane as f32));
            prim.push(Property::new("inputs:color", color).typed("color3f"));
        }
    }
    match &source.form {
        LightForm::Point { .. } => {
            prim.push(Property::new("inputs:normalize", Datum::Bool(true)));
            prim.push(Property::new("treatAsPoint", Datum::Bool(true)));
        }
        LightForm::Distant { .. } => prim.push(Property::new("inputs:normalize", Datum::Bool(true))),
        LightForm::Rect { .. }
        | LightForm::Disk { .. }
        | LightForm::Sphere { .. }
        | LightForm::Cylinder { .. }
        | LightForm::Dome { .. } => {}
    }
    if let Some(image) = image {
        prim.push(Property::new("inputs:texture:file", Datum::Asset(optics::asset_path(writing.folder, &image)?)));
    }
    if let Some(profile) = &source.profile {
        match &profile.source {
            ProfileSource::File(file) => prim.push(Property::new(
                "inputs:shaping:ies:file",
                Datum::Asset(optics::asset_path(writing.folder, file)?),
            )),
            ProfileSource::Embedded(_) => {
                let what = format!("light `{}` has its profile inside the asset, which USD cannot hold", source.name);
                return Err(writing.fault(&source.at, what));
            }
        }
        prim.marks.push(("profile_factor", Datum::Double(profile.factor)));
        if profile.angle_scale != 0.0 {
            prim.push(Property::new("inputs:shaping:ies:angleScale", Datum::Float(profile.angle_scale as f32)));
        }
        if profile.normalize {
            prim.push(Property::new("inputs:shaping:ies:normalize", Datum::Bool(true)));
        }
        if !spot {
            // The schema's own is 90, which would cut half of the profile off.
            prim.push(Property::new("inputs:shaping:cone:angle", Datum::Float(180.0)));
        }
    }
    if spot || source.profile.is_some() {
        prim.apply("ShapingAPI");
    }
    if let Some(attributes) = &source.attributes {
        optics::apply(writing, attributes, &mut prim)?;
    }
    prims.push(prim);
    Ok(())
}

/// Appends the cameras that are on no node below the default prim, each where it stands in the asset's world.
pub(super) fn cameras(writing: &Writing<'_>, siblings: &mut Siblings, prims: &mut Vec<Prim>) -> Result<()> {
    let nodes = writing.assembly.nodes.len();
    for own in writing.assembly.cameras.iter().filter(|camera| camera.node.is_none_or(|node| node >= nodes)) {
        camera(writing, (own, false), 1, siblings, prims)?;
    }
    Ok(())
}

/// Appends a camera: in the axes of the prim above it, which `is_held` says is its node, or in the asset's world.
pub(super) fn camera(
    writing: &Writing<'_>,
    (camera, is_held): (&Camera, bool),
    depth: usize,
    siblings: &mut Siblings,
    prims: &mut Vec<Prim>,
) -> Result<()> {
    if !camera.to_world.is_finite() {
        let what = format!("the place of camera `{}` is not finite", camera.name);
        return Err(writing.fault(&eyebox_base::Where::Nowhere, what));
    }
    let mut prim = Prim::def(depth, "Camera", siblings.name(&camera.name, "Camera"));
    named(&mut prim, &camera.name);
    prim.marks.push(("part", Datum::Bool(true)));
    // Aperture and focal length are in tenths of a unit (UsdGeomCamera, "Units of Measure for Camera Properties").
    let Frustum { near, far, film, shutter, half } = camera.frustum;
    match camera.yfov {
        Some(yfov) => {
            // One without a film has a lens of 50 mm.
            let own = film.unwrap_or_else(|| {
                let focal = USUAL_M / optics::unit(writing.assembly);
                let tall = 2.0 * focal * (0.5 * yfov).tan();
                Film { focal, size: [tall * camera.aspect.unwrap_or(1.0), tall], offset: [0.0; 2] }
            });
            if film.is_none() {
                prim.marks.push(("no_film", Datum::Bool(true)));
            }
            let tenths = |length: f64| Datum::Float((10.0 * length) as f32);
            prim.marks.push(("yfov", Datum::Double(yfov)));
            prim.marks.extend(camera.aspect.map(|aspect| ("aspect", Datum::Double(aspect))));
            prim.push(Property::new("focalLength", tenths(own.focal)));
            for (name, length) in ["horizontalAperture", "verticalAperture"].into_iter().zip(own.size) {
                prim.push(Property::new(name, tenths(length)));
            }
            let offsets = ["horizontalApertureOffset", "verticalApertureOffset"].into_iter().zip(own.offset);
            for (name, length) in offsets.filter(|(_, length)| *length != 0.0) {
                prim.push(Property::new(name, tenths(length)));
            }
            if let Some(pupil) = camera.pupil {
                prim.marks.push(("pupil", Datum::Double(pupil)));
                prim.push(Property::new("fStop", Datum::Float((own.focal / pupil) as f32)));
            }
            if let Some(focus) = camera.focus {
                prim.marks.push(("focus", Datum::Double(focus)));
                prim.push(Property::new("focusDistance", Datum::Float(focus as f32)));
            }
        }
        None => {
            prim.push(Property::new("projection", Datum::Token("orthographic".to_owned())));
            if let Some([x, y]) = half {
                prim.marks.extend([("half_width", Datum::Double(x)), ("half_height", Datum::Double(y))]);
                prim.push(Property::new("horizontalAperture", Datum::Float((20.0 * x) as f32)));
                prim.push(Property::new("verticalAperture", Datum::Float((20.0 * y) as f32)));
            }
        }
    }
    for (name, time) in ["shutter:open", "shutter:close"].into_iter().zip(shutter.into_iter().flatten()) {
        prim.push(Property::new(name, Datum::Double(time)));
    }
    if near.is_some() || far.is_some() {
        prim.marks.extend(near.map(|near| ("near", Datum::Double(near))));
        prim.marks.extend(far.map(|far| ("far", Datum::Double(far))));
        // The schema's own near end; a far end that no scene reaches.
        let range = [near.unwrap_or(1.0), far.unwrap_or(1e30)].map(|x| x as f32);
        prim.push(Property::new("clippingRange", Datum::Float2(range)));
    }
    if !is_held {
        prim.push(Property::new("xformOp:transform", matrix(camera.to_world)));
        let order = vec!["!resetXformStack!".to_owned(), "xformOp:transform".to_owned()];
        prim.push(Property::new("xformOpOrder", Datum::Tokens(order)).uniform());
    }
    prims.push(prim);
    Ok(())
}
