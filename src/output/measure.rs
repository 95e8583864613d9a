//! What a frame measures as a display: luminances, contrast, leak, ghost, sharpness, colour, field of view. Definitions and
//! their sources are in `docs/measure.md`.

mod display;
pub mod edge;
pub mod ghost;
mod likeness;
mod points;

use super::average::{Image, Uncertain, pixels_are_independent, weighted};
use super::contrasts::Contrasts;
use super::field::Field;
use super::leak::modulated;
use super::light_shares::Rendering;
use super::luminance::Luminance;
use super::tone::{Adaptation, adaptation_luminance};
use display::DISPLAY;
use edge::{Region, response};
use eyebox_base::error::{Error, Result, Where};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::Moments;
use eyebox_film::frame::Frame;

/// Half the width of an interval of 95 % in standard errors.
const NORMAL_95: f64 = 1.959_964;
/// Repetitions with noise added, for the interval of the edge's response.
const REPETITIONS: u64 = 40;

/// One result: a value with its interval, or a sentence why there is none.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Quantity {
    pub name: String,
    pub value: Option<f64>,
    pub unit: &'static str,
    /// 95 %.
    pub interval: Option<[f64; 2]>,
    /// Where, how, or why not.
    pub note: String,
}

/// What to measure on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Target {
    /// The display's light groups; the group that the slide modulates if empty.
    pub groups: Vec<String>,
    /// x, y, width, height in pixels of a region with one slanted edge.
    pub edge: Option<[usize; 4]>,
}

/// Measures a frame.
/// Errors: those of [`Rendering::of`], unknown groups, an edge region outside the picture.
pub fn measure(frame: &Frame, target: &Target) -> Result<Vec<Quantity>> {
    let rendering = Rendering::of(frame)?;
    if let Some(unknown) = target.groups.iter().find(|group| !rendering.groups.contains(group)) {
        return Err(Error::new(Where::Option(format!("--display {unknown}")), format!("no light group `{unknown}`"))
            .expected(format!("one of {}", rendering.groups.join(", ")))
            .nearest(unknown, rendering.groups.iter().map(String::as_str)));
    }
    let groups = if target.groups.is_empty() {
        modulated(&rendering).map(|group| vec![group]).map_err(|many| {
            if many.is_empty() {
                "no light group depends on a slide: name the display's with --display".to_owned()
            } else {
                format!("the slide modulates {}: name the display's with --display", many.join(", "))
            }
        })
    } else {
        Ok(target.groups.clone())
    };
    let of = Measurer::new(rendering);
    let mut found = of.adaptations();
    match &groups {
        Ok(groups) => of.display(groups, &mut found),
        Err(why) => {
            for (name, unit) in DISPLAY {
                found.push(unmeasured(name, unit, why.clone()));
            }
        }
    }
    found.push(of.edge_response(target.edge)?);
    let field = Field::of(frame);
    for (axis, name) in ["field of view, width", "field of view, height"].into_iter().enumerate() {
        found.push(match field {
            Some(field) => Quantity {
                interval: None,
                note: "of the picture, from the header: exact".to_owned(),
                ..plain(name, "°", field.extent_deg()[axis])
            },
            None => unmeasured(name, "°", NO_EYE.to_owned()),
        });
    }
    Ok(found)
}

const NO_EYE: &str = "the header does not say how wide the eye looks (`eyebox.eye`)";
const NO_ERRORS: &str =
    "no interval: the frame tells no errors of its shares; render two passes or more with --stderr layers";

fn plain(name: &str, unit: &'static str, value: f64) -> Quantity {
    Quantity { name: name.to_owned(), value: Some(value), unit, interval: None, note: String::new() }
}

fn unmeasured(name: &str, unit: &'static str, why: String) -> Quantity {
    Quantity { name: name.to_owned(), value: None, unit, interval: None, note: why }
}

fn quantity(name: &str, unit: &'static str, of: Uncertain, note: &str) -> Quantity {
    let interval = of.sigma.map(|sigma| [of.value - NORMAL_95 * sigma, of.value + NORMAL_95 * sigma]);
    let note = match (interval, note) {
        (Some(_), note) => note.to_owned(),
        (None, "") => NO_ERRORS.to_owned(),
        (None, note) => format!("{note}; {NO_ERRORS}"),
    };
    Quantity { interval, note, ..plain(name, unit, of.value) }
}

struct Measurer<'f> {
    rendering: Rendering<'f>,
    weigh: Luminance,
    /// The whole picture.
    all: Image,
    independent: bool,
}

impl<'f> Measurer<'f> {
    fn new(rendering: Rendering<'f>) -> Self {
        let frame = rendering.frame;
        let weigh = Luminance::in_frame(frame);
        let values = frame.rgb("").map(|channels| weigh.image(channels)).unwrap_or_default();
        let errors = frame.rgb("stderr").map(|[error, ..]| error.iter().map(|e| f64::from(*e)).collect());
        Measurer { weigh, all: Image { values, errors }, independent: pixels_are_independent(frame), rendering }
    }

    fn frame(&self) -> &'f Frame {
        self.rendering.frame
    }

    fn adaptations(&self) -> Vec<Quantity> {
        let frame = self.frame();
        Adaptation::ALL
            .into_iter()
            .map(|kind| {
                let name = format!("adaptation luminance, {}", kind.name());
                let Some((value, weights)) = adaptation_luminance(kind, &self.all.values, frame) else {
                    let why = match kind {
                        Adaptation::Foveal => NO_EYE,
                        Adaptation::Arithmetic | Adaptation::Log => "no pixel has light",
                    };
                    return unmeasured(&name, "cd/m²", why.to_owned());
                };
                let of = weighted(&self.all, &weights, self.independent);
                let missing = "no interval: the frame has no `stderr`, or too few passes to tell it";
                let sigma = of.and_then(|of| of.sigma);
                let note = if sigma.is_some() { kind.doc().to_owned() } else { format!("{}; {missing}", kind.doc()) };
                let interval = sigma.map(|sigma| [value - NORMAL_95 * sigma, value + NORMAL_95 * sigma]);
                Quantity { interval, note, ..plain(&name, "cd/m²", value) }
            })
            .collect()
    }

    /// Light of some groups at a contrast (as rendered if none), with errors if all their shares have them.
    fn image(&self, takes: &dyn Fn(&str) -> bool, contrast: Option<f64>) -> Image {
        let pixels = self.all.values.len();
        let (mut values, mut variances) = (vec![0.0; pixels], Some(vec![0.0; pixels]));
        let contrasts = Contrasts::new(&self.rendering, contrast, &[]);
        for share in self.rendering.shares.iter().filter(|share| takes(&share.group)) {
            let light = super::light_shares::luminance_of(share, &contrasts, &self.weigh, pixels);
            values.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
            let own: Option<Vec<f64>> = (0..pixels).map(|pixel| share.variance(&contrasts, pixel)).collect();
            // A plate has no noise.
            if share.layer == super::light_shares::PLATE {
                continue;
            }
            variances = variances.zip(own).map(|(sum, own)| sum.iter().zip(own).map(|(a, b)| a + b).collect());
        }
        let errors = variances.map(|variances: Vec<f64>| variances.into_iter().map(f64::sqrt).collect());
        Image { values, errors }
    }

    fn edge_response(&self, region: Option<[usize; 4]>) -> Result<Quantity> {
        const NAME: &str = "MTF50 of the slanted edge";
        let frame = self.frame();
        let Some([x, y, width, height]) = region else {
            return Ok(unmeasured(NAME, "cycles/°", "say where one edge is: --edge X,Y,WxH in pixels".to_owned()));
        };
        let inside = |at: usize, size: usize, most: usize| at.checked_add(size).is_some_and(|end| end <= most);
        if !inside(x, width, frame.width) || !inside(y, height, frame.height) {
            return Err(Error::new(
                Where::Option(format!("--edge {x},{y},{width}x{height}")),
                "not inside the picture",
            )
            .expected(format!("a region of {} × {} pixels", frame.width, frame.height)));
        }
        let cut = |data: &[f64]| -> Vec<f64> {
            (0..width * height)
                .filter_map(|i| data.get((y + i / width) * frame.width + x + i % width))
                .copied()
                .collect()
        };
        let values = cut(&self.all.values);
        let found = match response(&Region { width, height, values: values.clone() }) {
            Ok(found) => found,
            Err(why) => return Ok(unmeasured(NAME, "cycles/°", why.to_owned())),
        };
        let Some(half) = found.falls_to(0.5) else {
            return Ok(unmeasured(
                NAME,
                "cycles/°",
                "the modulation stays above a half: sharper than the pixels".to_owned(),
            ));
        };
        let (scale, unit) = match Field::of(frame) {
            Some(field) => (1.0 / field.pixel_deg(), "cycles/°"),
            None => (1.0, "cycles/pixel"),
        };
        // The edge again and again with noise of the stated size on it.
        let sigma = self.all.errors.as_ref().map(|errors| {
            let errors = cut(errors);
            let mut moments = Moments::default();
            for repetition in 0..REPETITIONS {
                let mut rng = Rng::new(0, Stream::Check, 1, repetition);
                let noisy = values.iter().zip(&errors).map(|(value, error)| {
                    // Box and Muller 1958.
                    let (a, b) = (1.0 - rng.uniform(), rng.uniform());
                    value + error * (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
                });
                let region = Region { width, height, values: noisy.collect() };
                if let Some(half) = response(&region).ok().and_then(|found| found.falls_to(0.5)) {
                    moments.add(half);
                }
            }
            moments.variance().sqrt()
        });
        let sigma = sigma.filter(|sigma| sigma.is_finite()).map(|sigma| sigma * scale);
        let nyquist = found.at(0.5).unwrap_or(0.0);
        let note = format!(
            "slant {:.2}°; {half:.4} cycles/pixel; modulation {nyquist:.3} at half a cycle per pixel; the interval takes \
             pixels as independent",
            found.slant_deg
        );
        Ok(quantity(NAME, unit, Uncertain { value: half * scale, sigma }, &note))
    }
}

#[cfg(test)]
mod tests;
