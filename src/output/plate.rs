//! An artist's plate behind the optics: its luminance times the frame's `seethrough`.

use super::luminance::Luminance;
use super::mix::set_layer;
use super::shares::{PLATE, check_data};
use crate::base::fault::{Fault, Result, Where};
use crate::film::frame::Frame;

/// Adds the layer `plate` to a frame and its light to `hybrid` and the default image; a plate that is there already is
/// replaced. Plate and frame may be in different colour spaces; the plate's values are cd/m² (or what its
/// `whiteLuminance` says).
///
/// Returns a warning where the frame's own background fills all that the plate is seen through.
///
/// Errors: another size, a plate without colours or with values that are not finite, a frame without `seethrough`.
pub fn place(frame: &Frame, plate: &Frame) -> Result<(Frame, Option<String>)> {
    if (plate.width, plate.height) != (frame.width, frame.height) {
        let [wide, high] = [plate.width, plate.height];
        return Err(Fault::new(Where::Nowhere, format!("the plate has {wide} × {high} pixels"))
            .expected(format!("{} × {}, as the frame has", frame.width, frame.height)));
    }
    check_data(plate)?;
    let colours =
        plate.rgb("").ok_or_else(|| Fault::new(Where::Nowhere, "the plate has no channels R, G and B (or Y)"))?;
    let Some(through) = frame.rgb("seethrough") else {
        return Err(Fault::new(Where::Nowhere, "the frame has no layer `seethrough`, which a plate is seen through")
            .expected("a frame rendered without --layers, or with seethrough among them"));
    };
    let (from, to) = (Luminance::in_frame(plate), Luminance::in_frame(frame));
    let scale = from.white_cd_m2 / to.white_cd_m2;
    let mut behind: [Vec<f32>; 3] = std::array::from_fn(|_| Vec::with_capacity(through[0].len()));
    for pixel in 0..through[0].len() {
        let at = |data: &[f32]| data.get(pixel).map_or(0.0, |value| f64::from(*value));
        let colour = colours.map(at);
        // A luminance alone is a grey of this luminance.
        let grey = std::ptr::eq(colours[0], colours[1]);
        let colour = if from.space == to.space && !grey {
            colour
        } else {
            to.space.from_rec709(if grey { colour } else { from.space.to_rec709(colour) })
        };
        for ((behind, colour), through) in behind.iter_mut().zip(colour).zip(through) {
            behind.push((scale * colour * at(through)) as f32);
        }
    }
    let mut out = frame.clone();
    let old = frame.rgb(PLATE);
    for layer in ["hybrid", ""] {
        let Some(picture) = frame.rgb(layer) else { continue };
        let sum = [0, 1, 2].map(|c| {
            let old = |pixel: usize| old.and_then(|old| old[c].get(pixel)).copied().unwrap_or(0.0);
            picture[c].iter().zip(&behind[c]).enumerate().map(|(pixel, (own, new))| own - old(pixel) + new).collect()
        });
        set_layer(&mut out, layer, &sum);
    }
    if old.is_some() {
        set_layer(&mut out, PLATE, &behind);
    } else {
        for (component, data) in ["R", "G", "B"].into_iter().zip(behind) {
            out.push(format!("{PLATE}.{component}"), data);
        }
    }
    Ok((out, doubled(frame, through[0])))
}

/// Light that the eye traces directly and that is nearly everywhere where the plate can be seen is a sky.
fn doubled(frame: &Frame, through: &[f32]) -> Option<String> {
    let groups = super::shares::groups_of(frame).ok()?;
    let open = through.iter().filter(|share| **share > 0.0).count();
    let fills = |group: &&String| {
        let picture = frame.rgb(&format!("direct_{group}"));
        let lit = picture.map(|[_, g, _]| g.iter().zip(through).filter(|(g, t)| **t > 0.0 && **g > 0.0).count());
        open > 0 && lit.is_some_and(|lit| lit as f64 > 0.95 * open as f64)
    };
    let group = groups.iter().find(fills)?;
    Some(format!("light of `{group}` still shines behind the plate; --gain {group}=0 removes it"))
}
