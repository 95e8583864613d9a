//! An artist's plate behind the optics: its luminance times the frame's `seethrough`.

use super::fit::Fit;
use super::light_shares::{PLATE, groups_of};
use super::luminance::Luminance;
use super::mix::set_layer;
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::aov;
use eyebox_film::colours::Colours;
use eyebox_film::frame::Frame;
use eyebox_film::still::{Light, Still};

/// Adds the layer `plate` to a frame and its light to `hybrid` and the default image; a plate that is there already is
/// replaced. The plate's values are cd/m², or `white_cd_m2` for 1.
///
/// Returns the light group that fills all that the plate is seen through as well, if one does.
///
/// Errors: another size, a frame without `seethrough`, one that calls something else `plate`.
pub fn place(frame: &Frame, plate: &Still, white_cd_m2: f64) -> Result<(Frame, Option<String>)> {
    if (plate.width, plate.height) != (frame.width, frame.height) {
        let [wide, high] = [plate.width, plate.height];
        return Err(Error::new(Where::Nowhere, format!("the plate has {wide} × {high} pixels")).expected(format!(
            "{} × {}, as the frame has, or --fit with one of {}",
            frame.width,
            frame.height,
            Fit::ALL.map(Fit::name).join(", ")
        )));
    }
    if let Some(cause) = named_alike(frame) {
        let what = format!("`{PLATE}` would be the layer of --plate and {cause}");
        return Err(Error::new(Where::Nowhere, what).expected("another name for the asset's own, and a new rendering"));
    }
    let Some(through) = frame.rgb("seethrough") else {
        return Err(Error::new(Where::Nowhere, "the frame has no layer `seethrough`, which a plate is seen through")
            .expected("a frame rendered without --layers, or with seethrough among them"));
    };
    let to = Luminance::in_frame(frame);
    let Colours::Own(space) = to.space else {
        return Err(Error::new(Where::Nowhere, format!("the frame's colours are in {}", to.space.name(frame)))
            .expected("a frame of `eyebox render`"));
    };
    let scale = white_cd_m2 / to.white_cd_m2;
    let mut behind: [Vec<f32>; 3] = std::array::from_fn(|_| Vec::with_capacity(through[0].len()));
    for pixel in 0..through[0].len() {
        let at = |data: &[f32]| data.get(pixel).map_or(0.0, |value| f64::from(*value));
        let colour = space.from_rec709(match &plate.light {
            // A luminance alone is a grey of this luminance.
            Light::Grey(values) => [at(values); 3],
            Light::Rgb(values) => values.get(pixel).map_or([0.0; 3], |rgb| rgb.map(f64::from)),
        });
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

/// What else of a frame has the plate's name.
fn named_alike(frame: &Frame) -> Option<&'static str> {
    if groups_of(frame).is_ok_and(|groups| groups.iter().any(|group| group == PLATE)) {
        return Some("a light group of the frame");
    }
    aov::listed(frame).iter().any(|aov| aov.name == PLATE).then_some("a layer that the asset asks for")
}

/// Light that the eye traces directly and that is nearly everywhere where the plate can be seen is a sky.
fn doubled(frame: &Frame, through: &[f32]) -> Option<String> {
    let groups = groups_of(frame).ok()?;
    let open = through.iter().filter(|share| **share > 0.0).count();
    let fills = |group: &&String| {
        let picture = frame.rgb(&format!("direct_{group}"));
        let lit = picture.map(|[_, g, _]| g.iter().zip(through).filter(|(g, t)| **t > 0.0 && **g > 0.0).count());
        open > 0 && lit.is_some_and(|lit| lit as f64 > 0.95 * open as f64)
    };
    groups.iter().find(fills).cloned()
}
