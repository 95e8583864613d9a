//! What a frame measures as a display: luminances, contrast, leak, ghost, sharpness, colour, field of view. Definitions and
//! their sources are in `docs/measure.md`.

pub mod edge;
pub mod ghost;

use super::average::{Image, Uncertain, mean, pixels_are_independent, weighted};
use super::field::Field;
use super::leak::{Visibility, brightest, leak_luminance, modulated, patch_pixels};
use super::luminance::Luminance;
use super::shares::Rendering;
use super::solve::lit_pixels;
use super::tone::{Adaptation, adaptation_luminance};
use crate::base::fault::{Fault, Result, Where};
use crate::base::rng::{Rng, Stream};
use crate::base::stats::Moments;
use crate::film::frame::Frame;
use edge::{Region, response};

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
        return Err(Fault::new(Where::Option(format!("--display {unknown}")), format!("no light group `{unknown}`"))
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
const NO_ERRORS: &str = "no interval: the frame has no errors of its shares; render with --stderr layers";

/// What needs to know which light is the display's.
const DISPLAY: [(&str, &str); 8] = [
    ("white luminance, mean of 9 points", "cd/m²"),
    ("uniformity of 9 points", ""),
    ("contrast on/off", ""),
    ("see-through contrast", ""),
    ("leak spot", "cd/m²"),
    ("leak over threshold", ""),
    ("ghost over picture", ""),
    ("colour uniformity Δu′v′", ""),
];

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
                let missing = "no interval: the frame has no `stderr`";
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
        for share in self.rendering.shares.iter().filter(|share| takes(&share.group)) {
            let light = super::shares::luminance_of(share, contrast, &self.weigh, pixels);
            values.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
            let at = |pixel: usize| match (&share.split, contrast) {
                (Some(split), Some(contrast)) => split.variance(contrast, pixel),
                (_, _) => Some(share.error?.get(pixel).map_or(0.0, |e| f64::from(*e).powi(2))),
            };
            let own: Option<Vec<f64>> = (0..pixels).map(at).collect();
            // A plate has no noise.
            if share.layer == super::shares::PLATE {
                continue;
            }
            variances = variances.zip(own).map(|(sum, own)| sum.iter().zip(own).map(|(a, b)| a + b).collect());
        }
        let errors = variances.map(|variances: Vec<f64>| variances.into_iter().map(f64::sqrt).collect());
        Image { values, errors }
    }

    fn display(&self, groups: &[String], found: &mut Vec<Quantity>) {
        let frame = self.frame();
        let own = |group: &str| groups.iter().any(|name| name == group);
        let split = self.rendering.shares.iter().any(|share| own(&share.group) && share.split.is_some());
        let white = self.image(&own, split.then_some(1.0));
        let picture = self.image(&own, None);
        let background = self.image(&|group| !own(group), None);
        let window = window(&white.values, frame.width);
        let lit = lit_pixels(&picture.values);
        self.nine_points(&white, window, found);
        let contrast = self.rendering.contrast.unwrap_or(f64::INFINITY);
        let leak = Image { values: leak_luminance(&self.rendering, groups, contrast), errors: None };
        self.contrasts(&[&white, &picture, &background], &leak, &lit, found);
        self.leak(&leak, groups, contrast, found);
        self.ghost(&picture, found);
        self.colour(groups, split, window, found);
        if let (Some([x0, y0, x1, y1]), Some(field)) = (window, Field::of(frame)) {
            let (left, right) = (field.place_deg([x0 as f64, 0.0])[0], field.place_deg([x1 as f64, 0.0])[0]);
            let (up, down) = (field.place_deg([0.0, y0 as f64])[1], field.place_deg([0.0, y1 as f64])[1]);
            let note = "of the display: the box around what is brighter than half of its white; to a pixel";
            let pixel = field.pixel_deg();
            for (name, value) in [
                ("field of view of the display, width", right - left),
                ("field of view of the display, height", up - down),
            ] {
                let interval = Some([value - pixel, value + pixel]);
                found.push(Quantity { interval, note: note.to_owned(), ..plain(name, "°", value) });
            }
        }
    }

    fn nine_points(&self, white: &Image, window: Option<[usize; 4]>, found: &mut Vec<Quantity>) {
        let points = window.and_then(|window| nine(self.frame(), window)).unwrap_or_default();
        let means: Vec<Uncertain> = points.iter().filter_map(|pixels| mean(white, pixels, self.independent)).collect();
        let [(mean_name, mean_unit), (uniformity, none), ..] = DISPLAY;
        if means.len() != 9 {
            let why = "the display's light fills too few pixels for 9 points";
            found.push(unmeasured(mean_name, mean_unit, why.to_owned()));
            found.push(unmeasured(uniformity, none, why.to_owned()));
            return;
        }
        let sum = means.iter().skip(1).fold(means[0], |sum, point| sum.plus(*point));
        let average = Uncertain { value: sum.value / 9.0, sigma: sum.sigma.map(|sigma| sigma / 9.0) };
        let list: Vec<String> = means.iter().map(|point| format!("{:.1}", point.value)).collect();
        found.push(quantity(
            mean_name,
            mean_unit,
            average,
            &format!("slide fully open; rows from the top left: {}", list.join(" ")),
        ));
        let by_value = |a: &&Uncertain, b: &&Uncertain| a.value.total_cmp(&b.value);
        let extremes = means.iter().min_by(by_value).zip(means.iter().max_by(by_value));
        found.push(match extremes.and_then(|(least, most)| least.over(*most)) {
            Some(ratio) => quantity(uniformity, none, ratio, "least over largest; noise makes it too small"),
            None => unmeasured(uniformity, none, "the display is dark".to_owned()),
        });
    }

    fn contrasts(&self, images: &[&Image; 3], leak: &Image, lit: &[usize], found: &mut Vec<Quantity>) {
        let [white, picture, background] = images;
        let [_, _, (on_off, none), (see_through, _), ..] = DISPLAY;
        // Dark: within the display's window, and as dark as the slide gets.
        let open = lit_pixels(&white.values);
        let whites = mean(picture, lit, self.independent);
        let level = whites.map_or(0.0, |white| 0.1 * white.value);
        let dark: Vec<usize> =
            open.into_iter().filter(|pixel| picture.values.get(*pixel).is_some_and(|value| *value < level)).collect();
        let ratio = whites.zip(mean(picture, &dark, self.independent)).and_then(|(lit, dark)| lit.over(dark));
        found.push(match ratio {
            Some(ratio) => quantity(
                on_off,
                none,
                ratio,
                "mean of the lit over mean of the dark pixels (below a tenth of the lit) of the picture's window",
            ),
            None => {
                unmeasured(on_off, none, "the picture has no dark pixels inside its window, or no lit ones".to_owned())
            }
        });
        let of = |image: &Image| mean(image, lit, self.independent);
        // The leak is the white's share 1/C: it errs with it, by little.
        let exact = |of: Uncertain| Uncertain { sigma: Some(0.0), ..of };
        let ratio = of(picture)
            .zip(of(background))
            .zip(of(leak))
            .and_then(|((picture, background), leak)| background.plus(picture).over(background.plus(exact(leak))));
        found.push(match ratio {
            Some(ratio) => {
                quantity(see_through, none, ratio, "(background + picture)/(background + leak) over the lit pixels")
            }
            None => unmeasured(see_through, none, "there is no background and no leak behind the picture".to_owned()),
        });
    }

    fn leak(&self, leak: &Image, groups: &[String], contrast: f64, found: &mut Vec<Quantity>) {
        let [_, _, _, _, (spot_name, spot_unit), (visible, none), ..] = DISPLAY;
        let Some(spot) = brightest(self.frame(), &leak.values) else {
            for (name, unit) in [(spot_name, spot_unit), (visible, none)] {
                found.push(unmeasured(
                    name,
                    unit,
                    "no light of the display depends on a slide, or its black is perfect".to_owned(),
                ));
            }
            return;
        };
        // Errors of open/C over the patch.
        let own = |group: &str| groups.iter().any(|name| name == group);
        let open = self.image(&own, Some(1.0));
        let side = spot.patch_pixels;
        let corner = spot.at_pixel.map(|centre| (centre - 0.5 * side as f64).max(0.0) as usize);
        let width = self.frame().width;
        let pixels: Vec<usize> = (0..side * side)
            .map(|i| (corner[1] + i / side) * width + corner[0] + i % side)
            .filter(|pixel| *pixel < open.values.len())
            .collect();
        let sigma = mean(&open, &pixels, self.independent).and_then(|of| of.sigma).map(|sigma| sigma / contrast);
        let of = Uncertain { value: spot.cd_m2, sigma };
        let place = match spot.at_deg {
            Some([x, y]) => format!("at {x:+.2}°, {y:+.2}° (right, up)"),
            None => format!("at pixel {:.1}, {:.1}", spot.at_pixel[0], spot.at_pixel[1]),
        };
        let chosen = "the brightest patch: noise makes it too large";
        found.push(quantity(
            spot_name,
            spot_unit,
            of,
            &format!("{place}, patch of {side} pixels, C = {contrast}; {chosen}"),
        ));
        let adaptation = self.all.values.iter().sum::<f64>() / self.all.values.len().max(1) as f64;
        let seen = Visibility::of(spot.cd_m2, adaptation);
        let factor = Uncertain { value: seen.factor, sigma: sigma.map(|sigma| sigma / seen.threshold_cd_m2) };
        let word = if seen.visible { "visible" } else { "hidden" };
        let note = format!(
            "{word}: Ferwerda's threshold is {:.4} cd/m² at an adaptation to {adaptation:.2} cd/m²",
            seen.threshold_cd_m2
        );
        found.push(quantity(visible, none, factor, &note));
    }

    fn ghost(&self, picture: &Image, found: &mut Vec<Quantity>) {
        let frame = self.frame();
        let [_, _, _, _, _, _, (name, none), _] = DISPLAY;
        match ghost::echo(&picture.values, frame.width, frame.height) {
            Ok(echo) => {
                let [x, y] = echo.offset;
                let centre = [frame.width, frame.height].map(|size| 0.5 * size as f64);
                let angle = Field::of(frame).map(|field| {
                    let half = [0.5 * x as f64, 0.5 * y as f64];
                    field.angle_deg(
                        [centre[0] - half[0], centre[1] - half[1]],
                        [centre[0] + half[0], centre[1] + half[1]],
                    )
                });
                let note = "by the cepstrum; no interval: it is no linear function of the pixels";
                let far = angle.map_or(String::new(), |angle| format!(" = {:.3}°", angle));
                found.push(Quantity {
                    note: format!("separation {x:+}, {y:+} pixels (right, down){far}; {note}"),
                    ..plain(name, none, echo.ratio)
                });
            }
            Err(limit) => {
                found.push(unmeasured(
                    name,
                    none,
                    format!("none found; one above {limit:.3} of the picture would have been"),
                ));
            }
        }
    }

    fn colour(&self, groups: &[String], split: bool, window: Option<[usize; 4]>, found: &mut Vec<Quantity>) {
        let [.., (name, none)] = DISPLAY;
        let points = window.and_then(|window| nine(self.frame(), window)).unwrap_or_default();
        let xyz = |pixels: &Vec<usize>| {
            let mut sum = [0.0; 3];
            for share in self.rendering.shares.iter().filter(|share| groups.contains(&share.group)) {
                for pixel in pixels {
                    let colour = [0, 1, 2].map(|c| match &share.split {
                        Some(open) if split => open.value(1.0, c, *pixel),
                        Some(_) | None => share.picture[c].get(*pixel).map_or(0.0, |value| f64::from(*value)),
                    });
                    let xyz = self.weigh.space.to_xyz(colour);
                    sum.iter_mut().zip(xyz).for_each(|(sum, value)| *sum += value);
                }
            }
            sum
        };
        let places: Vec<[f64; 2]> = points.iter().map(xyz).filter_map(uv).collect();
        let grey = self.rendering.shares.iter().filter(|share| groups.contains(&share.group)).all(|share| {
            let [r, g, b] = share.picture;
            r == g && g == b
        });
        found.push(if grey && self.weigh.space == crate::base::colour::ColourSpace::Rec709 {
            unmeasured(name, none, "the light has one colour: one wavelength, or grey".to_owned())
        } else if places.len() != 9 {
            unmeasured(name, none, "the display's light fills too few pixels for 9 points".to_owned())
        } else {
            let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            let largest = places.iter().flat_map(|a| places.iter().map(move |b| apart(a, b))).fold(0.0, f64::max);
            Quantity {
                note: "largest distance of two of the 9 points; no interval: stderr is of luminance alone".to_owned(),
                ..plain(name, none, largest)
            }
        });
    }

    fn edge_response(&self, region: Option<[usize; 4]>) -> Result<Quantity> {
        const NAME: &str = "MTF50 of the slanted edge";
        let frame = self.frame();
        let Some([x, y, width, height]) = region else {
            return Ok(unmeasured(NAME, "cycles/°", "say where one edge is: --edge X,Y,WxH in pixels".to_owned()));
        };
        let inside = |at: usize, size: usize, most: usize| at.checked_add(size).is_some_and(|end| end <= most);
        if !inside(x, width, frame.width) || !inside(y, height, frame.height) {
            return Err(Fault::new(
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

/// The box around the lit pixels: left, top, right and bottom, the last two exclusive.
fn window(white: &[f64], width: usize) -> Option<[usize; 4]> {
    let lit = lit_pixels(white);
    let places = || lit.iter().map(|pixel| (pixel % width.max(1), pixel / width.max(1)));
    let (left, right) = (places().map(|(x, _)| x).min()?, places().map(|(x, _)| x).max()?);
    let (top, bottom) = (places().map(|(_, y)| y).min()?, places().map(|(_, y)| y).max()?);
    Some([left, top, right + 1, bottom + 1])
}

/// Pixels of the nine patches at 1/6, 3/6 and 5/6 of a window's width and height; none if it is too small.
fn nine(frame: &Frame, [left, top, right, bottom]: [usize; 4]) -> Option<Vec<Vec<usize>>> {
    let (width, height) = (right - left, bottom - top);
    if width < 9 || height < 9 {
        return None;
    }
    let side = patch_pixels(frame).min(width / 3).min(height / 3).max(1);
    let start = |from: usize, size: usize, i: usize| (from + size * (2 * i + 1) / 6).saturating_sub(side / 2);
    let patch = |i: usize| {
        let (x, y) = (start(left, width, i % 3), start(top, height, i / 3));
        (0..side * side)
            .map(|k| (y + k / side, x + k % side))
            .filter(|(y, x)| *x < frame.width && *y < frame.height)
            .map(|(y, x)| y * frame.width + x)
            .collect()
    };
    Some((0..9).map(patch).collect())
}

/// u′, v′ of CIE 1976 (CIE 15:2004, 8.2.1); none of black.
fn uv([x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
    let sum = x + 15.0 * y + 3.0 * z;
    (sum > 0.0).then(|| [4.0 * x / sum, 9.0 * y / sum])
}

#[cfg(test)]
mod tests;
