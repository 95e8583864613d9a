//! A frame's layer as a picture to look at: 8-bit sRGB, PNG.

use std::path::Path;

use crate::canvas::Canvas;
use crate::false_colour::{draw, scale};
use crate::field::Field;
use crate::glare::{PIGMENT, spread};
use crate::luminance::Luminance;
use crate::tone::{Adaptation, adaptation_luminance, code, srgb_code, ward_scale};
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::colours::Colours;
use eyebox_film::frame::{Channel, Frame};
use eyebox_film::sharpness::Sharpness;
use glam::DVec3;

/// The pixel where a value is not a number or infinite: a colour that no luminance gets by accident.
const NOT_FINITE: [u8; 3] = [255, 0, 255];
/// Beyond this f64 scales run out of range long after any display has.
const MOST_STOPS: f64 = 200.0;

#[derive(Debug, Clone, PartialEq)]
pub struct ViewOptions {
    /// A layer's name, or a channel's full name; the default image if `None` (the first layer if there is none).
    pub layer: Option<String>,
    /// Stops. A picture is shown as `2^exposure × L / ldmax`: 0 shows each luminance as it is on a display of
    /// `ldmax_cd_m2`, so frames shown with one exposure can be compared. `None`: the scale of Ward's visibility
    /// matching, adapted to the mean luminance of the default image, the same for every layer of a frame.
    pub exposure: Option<f64>,
    /// Luminance of the display's white, cd/m².
    pub ldmax_cd_m2: f64,
    /// Which mean the eye is adapted to.
    pub adaptation: Adaptation,
    /// Pictures as they fall on the retina: with the light that the eye scatters.
    pub glare: bool,
    /// Pictures as colours on a scale of luminance, with its legend.
    pub false_colour: bool,
}

impl Default for ViewOptions {
    fn default() -> Self {
        ViewOptions {
            layer: None,
            exposure: None,
            ldmax_cd_m2: 100.0,
            adaptation: Adaptation::Arithmetic,
            glare: false,
            false_colour: false,
        }
    }
}

/// How a layer is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shown {
    /// Luminances, toned for the display.
    Picture,
    /// Transmittances and reflectances: 1 is white.
    Fraction,
    /// Signed triples (normal, position): grey is 0, the longest vector ends the scale; a miss is black.
    Vector,
    /// One number per pixel: brightest where smallest, 0 (a miss) is black; signed numbers as in `Vector`.
    Scalar,
}

/// What was shown, and the scale, so that another frame can be shown alike.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ViewInfo {
    /// Empty for the default image.
    pub layer: String,
    pub shown: Shown,
    pub width: usize,
    pub height: usize,
    /// Mean luminance of the default image (of this layer if there is none), cd/m²; for toned pictures.
    pub adaptation_cd_m2: Option<f64>,
    /// For pictures, if the header says it: how sharp diffraction lets the picture be.
    pub diffraction: Option<Sharpness>,
    /// For pictures and fractions: giving this number as the exposure shows the same picture again.
    pub exposure_stops: Option<f64>,
    /// For data: the smallest and the largest value (for `Vector` of all components). For false colours: the ends of the
    /// scale, cd/m².
    pub range: Option<[f64; 2]>,
    /// Pixels with a value that is not finite, shown magenta.
    pub nonfinite_pixels: usize,
}

/// Writes the layer as an 8-bit sRGB PNG, completely or not at all.
/// Errors: those of [`render_view`], and a place that cannot be written.
pub fn write_view(path: &Path, frame: &Frame, options: &ViewOptions) -> Result<ViewInfo> {
    let (raster, info) = shown(frame, options)?;
    raster.write_png(path)?;
    Ok(info)
}

/// The layer as it is written: with the legend, if there is one.
/// Errors: those of [`render_view`]; false colours of what is no luminance.
pub fn shown(frame: &Frame, options: &ViewOptions) -> Result<(Canvas, ViewInfo)> {
    if !options.false_colour {
        let (bytes, info) = render_view(frame, options)?;
        return Ok((Canvas { width: frame.width, height: frame.height, bytes }, info));
    }
    check(frame, options)?;
    let (layer, kind, channels) = choose(frame, options.layer.as_deref())?;
    if kind != Shown::Picture {
        return Err(Error::new(Where::Option("--false-colour".to_owned()), format!("`{layer}` is no luminance"))
            .expected("a picture layer"));
    }
    let glared = glared(frame, options, channels)?;
    let channels = glared.as_ref().map_or(channels, |planes| planes.each_ref().map(Vec::as_slice));
    let luminance = Luminance::in_frame(frame).image(channels);
    let info = ViewInfo {
        layer,
        shown: kind,
        width: frame.width,
        height: frame.height,
        adaptation_cd_m2: None,
        diffraction: None,
        exposure_stops: None,
        range: Some(scale(&luminance)),
        nonfinite_pixels: luminance.iter().filter(|value| !value.is_finite()).count(),
    };
    Ok((draw(&luminance, frame.width, frame.height), info))
}

/// The channels with the light that the eye scatters, if that is asked for.
/// Errors: a frame that does not say how wide the eye looks.
fn glared(frame: &Frame, options: &ViewOptions, channels: [&[f32]; 3]) -> Result<Option<[Vec<f32>; 3]>> {
    if !options.glare {
        return Ok(None);
    }
    let field = Field::of(frame).ok_or_else(|| no_eye("--glare"))?;
    let planes = spread(channels, [frame.width, frame.height], &field, PIGMENT);
    Ok(Some(planes.map(|plane| plane.into_iter().map(|value| value as f32).collect())))
}

fn no_eye(option: &str) -> Box<Error> {
    Error::new(Where::Option(option.to_owned()), "the header does not say how wide the eye looks (`eyebox.eye`)")
        .expected("a frame that `eyebox render` wrote")
}

/// The layer as 8-bit sRGB, three bytes a pixel, row by row from the top left.
///
/// Errors: an unknown layer (with the nearest name and all of them), an exposure or a display luminance that is not a
/// usable number, channels whose data do not fill the frame.
pub fn render_view(frame: &Frame, options: &ViewOptions) -> Result<(Vec<u8>, ViewInfo)> {
    check(frame, options)?;
    let (layer, shown, channels) = choose(frame, options.layer.as_deref())?;
    // One channel shown three times is a luminance: no colour space applies to it.
    let grey = std::ptr::eq(channels[0], channels[1]);
    let glared = if shown == Shown::Picture { glared(frame, options, channels)? } else { None };
    let seen = glared.as_ref().map_or(channels, |planes| planes.each_ref().map(Vec::as_slice));
    let mut info = ViewInfo {
        layer,
        shown,
        width: frame.width,
        height: frame.height,
        adaptation_cd_m2: None,
        diffraction: None,
        exposure_stops: None,
        range: None,
        nonfinite_pixels: 0,
    };
    let pixel: Box<dyn Fn(DVec3) -> [u8; 3]> = match shown {
        Shown::Picture => {
            let space = Colours::of(frame);
            let adapted = frame.rgb("").unwrap_or(channels);
            let luminance = Luminance { space, white_cd_m2: 1.0 }.image(adapted);
            let mean = match adaptation_luminance(options.adaptation, &luminance, frame) {
                Some((mean, _)) => mean,
                None if options.adaptation == Adaptation::Foveal && Field::of(frame).is_none() => {
                    return Err(no_eye("--adaptation foveal"));
                }
                // Nothing that can be seen.
                None => 0.0,
            };
            let stops = options
                .exposure
                .unwrap_or_else(|| (ward_scale(mean, options.ldmax_cd_m2) * options.ldmax_cd_m2).log2());
            let scale = stops.exp2() / options.ldmax_cd_m2;
            (info.adaptation_cd_m2, info.exposure_stops) = (Some(mean), Some(stops));
            // A header of another version, or of another program, says nothing.
            info.diffraction = frame.text(Sharpness::KEY).and_then(|json| serde_json::from_str(json).ok());
            Box::new(move |color| {
                let color = (color * scale).to_array();
                (if grey { color } else { space.to_rec709(color) }).map(srgb_code)
            })
        }
        Shown::Fraction => {
            let stops = options.exposure.unwrap_or(0.0);
            info.exposure_stops = Some(stops);
            Box::new(move |color| (color * stops.exp2()).to_array().map(srgb_code))
        }
        Shown::Vector => {
            let [low, high] = range(channels.into_iter().flatten(), |_| true);
            info.range = Some([low, high]);
            // f32 components cannot overflow a length in f64.
            let lengths = triples(channels).map(DVec3::length).filter(|length| length.is_finite());
            let scale = lengths.fold(0.0, f64::max);
            Box::new(
                move |vector| {
                    if vector == DVec3::ZERO { [0; 3] } else { (vector / scale * 0.5 + 0.5).to_array().map(code) }
                },
            )
        }
        Shown::Scalar => {
            let [low, high] = range(channels[0], |value| value != 0.0);
            info.range = Some([low, high]);
            Box::new(move |value| [scalar_code(value.x, low, high); 3])
        }
    };
    let mut bytes = Vec::with_capacity(channels[0].len().saturating_mul(3));
    for color in triples(seen) {
        if color.is_finite() {
            bytes.extend(pixel(color));
        } else {
            info.nonfinite_pixels += 1;
            bytes.extend(NOT_FINITE);
        }
    }
    Ok((bytes, info))
}

fn check(frame: &Frame, options: &ViewOptions) -> Result<()> {
    let option = |text: String| Where::Option(text);
    if let Some(stops) = options.exposure
        && (stops.is_nan() || stops.abs() > MOST_STOPS)
    {
        return Err(Error::new(option(format!("--exposure {stops}")), "not a usable exposure")
            .expected(format!("{} to {MOST_STOPS} stops", -MOST_STOPS)));
    }
    let display = options.ldmax_cd_m2;
    if !(display > 0.0 && display.is_finite()) {
        return Err(
            Error::new(Where::Nowhere, format!("a display of {display} cd/m²")).expected("a positive luminance")
        );
    }
    let pixels = frame.width.checked_mul(frame.height).filter(|pixels| *pixels > 0);
    match frame.channels.iter().find(|channel| Some(channel.data.len()) != pixels) {
        Some(channel) => {
            Err(Error::new(Where::Nowhere, format!("channel `{}` has {} values", channel.name, channel.data.len()))
                .expected(format!("{} × {}", frame.width, frame.height)))
        }
        None if frame.channels.is_empty() => Err(Error::new(Where::Nowhere, "the frame has no channel")),
        None => Ok(()),
    }
}

/// The layer's name, how it is shown, and its three channels (the same one three times if it has one).
pub(super) fn choose<'f>(frame: &'f Frame, asked: Option<&str>) -> Result<(String, Shown, [&'f [f32]; 3])> {
    let names = frame.layer_names();
    let layer = match asked {
        Some(asked) => asked,
        None if frame.rgb("").is_some() => "",
        None => names.first().copied().unwrap_or_default(),
    };
    let one = |name: &str| frame.component(layer, name).map(|channel| channel.data.as_slice());
    let found = if let (Some(x), Some(y), Some(z)) = (one("X"), one("Y"), one("Z")) {
        // Pictures in XYZ are stored as R, G, B, so X, Y, Z are always coordinates.
        Some((Shown::Vector, [x, y, z]))
    } else if let Some(channels) = frame.rgb(layer) {
        Some((shown_by_name(layer), channels))
    } else {
        let by_layer = frame.channels.iter().find(|channel| channel.layer() == layer);
        // Asking for the default image of a frame that has only data there is no question of a channel's name.
        by_layer.or_else(|| frame.get(layer)).map(|channel| (Shown::Scalar, [channel.data.as_slice(); 3]))
    };
    let (shown, channels) = found.ok_or_else(|| unknown_layer(frame, layer, &names))?;
    Ok((layer.to_owned(), shown, channels))
}

/// Data layers may be stored as R, G, B too; `…_seen` is the same at the first hit that is not specular, and a prefix
/// may stand before (`design/layers.md`).
fn shown_by_name(layer: &str) -> Shown {
    let base = layer.strip_suffix("_seen").unwrap_or(layer);
    let is = |name: &str| base == name || base.strip_suffix(name).is_some_and(|before| before.ends_with('_'));
    if is("normal") || is("normal_geometric") || is("position") {
        Shown::Vector
    } else if is("albedo") || is("seethrough") {
        Shown::Fraction
    } else if is("work") {
        Shown::Scalar
    } else {
        Shown::Picture
    }
}

fn unknown_layer(frame: &Frame, layer: &str, names: &[&str]) -> Box<Error> {
    let listed: Vec<&str> = names.iter().map(|name| if name.is_empty() { "(default)" } else { name }).collect();
    let channels = frame.channels.iter().map(|channel: &Channel| channel.name.as_str());
    let valid: Vec<&str> = names.iter().copied().filter(|name| !name.is_empty()).chain(channels).collect();
    Error::new(Where::Option(format!("--layer {layer}")), format!("the frame has no layer `{layer}`"))
        .expected(format!("one of {}, or a channel's full name", listed.join(", ")))
        .nearest(layer, valid)
}

fn triples<'f>(channels: [&'f [f32]; 3]) -> impl Iterator<Item = DVec3> + 'f {
    let [r, g, b] = channels;
    r.iter().zip(g).zip(b).map(|((r, g), b)| DVec3::new(f64::from(*r), f64::from(*g), f64::from(*b)))
}

/// Smallest and largest finite value that counts; 0, 0 if none does.
fn range<'f>(values: impl IntoIterator<Item = &'f f32>, counts: impl Fn(f64) -> bool) -> [f64; 2] {
    let values = values.into_iter().map(|value| f64::from(*value)).filter(|value| value.is_finite() && counts(*value));
    values
        .fold(None, |range: Option<[f64; 2]>, value| {
            Some(range.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
        })
        .unwrap_or_default()
}

/// Distances and such: the nearest is white, the farthest a dark grey that still differs from a miss.
fn scalar_code(value: f64, low: f64, high: f64) -> u8 {
    if low < 0.0 {
        code(value / low.abs().max(high.abs()) * 0.5 + 0.5)
    } else if value == 0.0 {
        0
    } else if high > low {
        code(1.0 - 0.92 * (value - low) / (high - low))
    } else {
        code(1.0)
    }
}

#[cfg(test)]
mod tests;
