//! The display's own light: white at nine points, contrast, leak, ghost, colour.

use super::points::{nine, uv, window};
use super::{Measurer, Quantity, ghost, plain, quantity, unmeasured};
use crate::average::{Image, Uncertain, mean};
use crate::contrasts::Contrasts;
use crate::field::Field;
use crate::leak::{Visibility, brightest, leak_luminance};
use crate::solve::lit_pixels;
use eyebox_base::colour::ColourSpace;
use eyebox_film::colours::Colours;

/// What needs to know which light is the display's.
pub const DISPLAY: [(&str, &str); 8] = [
    ("white luminance, mean of 9 points", "cd/m²"),
    ("uniformity of 9 points", ""),
    ("contrast on/off", ""),
    ("see-through contrast", ""),
    ("leak spot", "cd/m²"),
    ("leak over threshold", ""),
    ("ghost over picture", ""),
    ("colour uniformity Δu′v′", ""),
];

impl Measurer<'_> {
    /// Everything that needs to know which light is the display's, appended in the order of [`DISPLAY`], and its field of view.
    pub fn display(&self, groups: &[String], found: &mut Vec<Quantity>) {
        let frame = self.frame();
        let own = |group: &str| groups.iter().any(|name| name == group);
        let split = self.rendering.shares.iter().any(|share| own(&share.group) && share.is_split());
        let white = self.image(&own, split.then_some(1.0));
        let picture = self.image(&own, None);
        let background = self.image(&|group| !own(group), None);
        let window = window(&white.values, frame.width);
        let lit = lit_pixels(&picture.values);
        self.nine_points(&white, window, found);
        let leak = Image { values: leak_luminance(&self.rendering, groups, &Contrasts::default()), errors: None };
        self.contrasts(&[&white, &picture, &background], &leak, &lit, found);
        self.leak(&leak, groups, found);
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

    fn leak(&self, leak: &Image, groups: &[String], found: &mut Vec<Quantity>) {
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
        // Where slides of several contrasts make it up, or two in series, only the light of each knows its error, and that is not kept.
        let in_series = self.rendering.shares.iter().any(|share| own(&share.group) && !share.by_pair.is_empty());
        let contrast = match (self.rendering.contrast, self.rendering.slides.is_empty()) {
            (Some(contrast), _) if !in_series => Some(contrast),
            (None, true) => Some(f64::INFINITY),
            (Some(_), _) | (None, false) => None,
        };
        let sigma = mean(&open, &pixels, self.independent).and_then(|of| Some(of.sigma? / contrast?));
        let of = Uncertain { value: spot.cd_m2, sigma };
        let place = match spot.at_deg {
            Some([x, y]) => format!("at {x:+.2}°, {y:+.2}° (right, up)"),
            None => format!("at pixel {:.1}, {:.1}", spot.at_pixel[0], spot.at_pixel[1]),
        };
        let each = || self.rendering.slides.iter().map(|slide| format!("{} of `{}`", slide.contrast, slide.name));
        let said = contrast.map_or_else(|| each().collect::<Vec<_>>().join(", "), |contrast| contrast.to_string());
        let chosen = "the brightest patch: noise makes it too large";
        found.push(quantity(
            spot_name,
            spot_unit,
            of,
            &format!("{place}, patch of {side} pixels, C = {said}; {chosen}"),
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
        let from_asset = "`eyebox paths` finds the ghosts of the asset itself, with their light, and `eyebox render --chain` their picture";
        found.push(match ghost::echo(&picture.values, [frame.width, frame.height]) {
            Ok(echo) => {
                let half = 0.5 * echo.offset;
                let centre = [frame.width, frame.height].map(|size| 0.5 * size as f64);
                let angle = Field::of(frame).map(|field| {
                    let ends = [-1.0, 1.0].map(|sign| [centre[0] + sign * half.x, centre[1] + sign * half.y]);
                    field.angle_deg(ends[0], ends[1])
                });
                let far = angle.map_or(String::new(), |angle| format!(" = {angle:.3}°"));
                let note = format!(
                    "separation {:+.1}, {:+.1} pixels (right, down){far}; by the least edges; the interval is by parts of the \
                     picture. A picture that shows a thing twice, once dimmer, reads the same: {from_asset}",
                    echo.offset.x, echo.offset.y
                );
                quantity(name, none, Uncertain { value: echo.ratio, sigma: Some(echo.sigma) }, &note)
            }
            Err(ghost::Missing::None) => unmeasured(
                name,
                none,
                format!(
                    "none found: no shift of 5 pixels and more makes the picture simpler. One as far away as what is shown is \
                     wide can hide: {from_asset}"
                ),
            ),
            Err(ghost::Missing::Repeats([a, b])) => unmeasured(
                name,
                none,
                format!(
                    "cannot be told from this picture: it repeats itself, and ghosts at {:+.1}, {:+.1} and {:+.1}, {:+.1} pixels \
                     (right, down) explain it about equally well; take an isolated square, or {from_asset}",
                    a.x, a.y, b.x, b.y
                ),
            ),
            Err(ghost::Missing::Empty) => unmeasured(name, none, "the display's light has no edges".to_owned()),
        });
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
        found.push(if grey && self.weigh.space == Colours::Own(ColourSpace::Rec709) {
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
}
