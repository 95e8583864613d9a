//! UsdGeomCamera. Apertures and focal length are in tenths of a scene unit, `focusDistance` in scene units.

use super::attribute::PrimView;
use super::notes::Ledger;
use super::round_trip::{RoundTrip, refined};
use super::value;
use crate::assembly::{Camera, Frustum};
use eyebox_base::error::Result;
use eyebox_scene::assembly::Film;
use glam::DAffine3;

/// Fallbacks of the schema: a 50 mm lens before a 35 mm full aperture, in tenths of a unit.
const FOCAL_LENGTH: f64 = 50.0;
const HORIZONTAL: f64 = 20.955;
const VERTICAL: f64 = 15.2908;
/// Scene units of a unit of focal length.
const TENTH: f64 = 0.1;

/// The far end of `clippingRange` where there is none.
const ENDLESS: f64 = 1e30;

/// # Errors
/// Apertures or a focal length that are not > 0.
pub(super) fn read(view: &PrimView, to_world: DAffine3, ledger: &mut Ledger) -> Result<Camera> {
    let positive = |name: &str, fallback: f64| -> Result<f64> {
        let x = view.number(name)?.unwrap_or(fallback);
        if x.is_finite() && x > 0.0 {
            return Ok(x);
        }
        Err(view.fault_in(name, format!("the value {x}")).expected("a finite number > 0"))
    };
    let marks = RoundTrip::of(view)?;
    let name = marks.text("name").unwrap_or(view.name()).to_owned();
    let mut frustum = clipping(view, &marks)?;
    if view.token("projection")?.as_deref() == Some("orthographic") {
        ledger.warn(view.at(), "an orthographic camera is no eye: not used");
        let half = |name: &str, mark: &str, fallback: f64| -> Result<f64> {
            Ok(refined(marks.number(mark), 0.5 * TENTH * positive(name, fallback)?))
        };
        let (x, y) =
            (half("horizontalAperture", "half_width", HORIZONTAL)?, half("verticalAperture", "half_height", VERTICAL)?);
        frustum.half = Some([x, y]);
        return Ok(Camera { name, node: None, to_world, yfov: None, aspect: None, pupil: None, focus: None, frustum });
    }
    let (width, height) = (positive("horizontalAperture", HORIZONTAL)?, positive("verticalAperture", VERTICAL)?);
    let focal = positive("focalLength", FOCAL_LENGTH)?;
    let mut offset = [0.0; 2];
    for (own, name) in offset.iter_mut().zip(["horizontalApertureOffset", "verticalApertureOffset"]) {
        *own = view.number(name)?.filter(|x| x.is_finite()).unwrap_or(0.0);
        if *own != 0.0 {
            ledger.warn(view.at_property(name), "a shifted aperture is not used");
        }
    }
    // Of a camera that was made from one without a film, the lens says nothing.
    if !marks.flag("no_film") {
        let size = [width, height].map(|x| TENTH * x);
        frustum.film = Some(Film { focal: TENTH * focal, size, offset: offset.map(|x| TENTH * x) });
    }
    // 0, the fallback of both, says nothing: no depth of field, no distance that is sharp.
    let said = |name: &str| -> Result<Option<f64>> { Ok(view.length(name)?.filter(|x| *x > 0.0)) };
    // f-number: focal length by diameter. A tenth: see above.
    let pupil = said("fStop")?.map(|number| focal * TENTH / number);
    Ok(Camera {
        name,
        node: None,
        to_world,
        yfov: Some(refined(marks.number("yfov"), 2.0 * (0.5 * height / focal).atan())),
        aspect: Some(refined(marks.number("aspect"), width / height)),
        pupil: pupil.map(|pupil| refined(marks.number("pupil"), pupil)),
        focus: said("focusDistance")?.map(|focus| refined(marks.number("focus"), focus)),
        frustum,
    })
}

/// `clippingRange`, in scene units.
fn clipping(view: &PrimView, marks: &RoundTrip) -> Result<Frustum> {
    let range = view.read("clippingRange", "two numbers", |found| value::pair(&found))?;
    let side = |lane: usize, mark: &str| {
        let own = range.map(|range| range[lane]).filter(|x| x.is_finite() && *x > 0.0);
        own.map(|x| refined(marks.number(mark), x))
    };
    // As good as endless, for our own writer: USD has no such thing.
    let far = side(1, "far").filter(|far| *far < ENDLESS);
    let time = |name: &str| view.number(name).map(|time| time.filter(|time| time.is_finite()));
    let shutter = [time("shutter:open")?, time("shutter:close")?];
    let shutter = (shutter != [None, None]).then(|| shutter.map(|time| time.unwrap_or(0.0)));
    Ok(Frustum { near: side(0, "near"), far, half: None, film: None, shutter })
}
