//! Light that a dark slide lets through, and whether an adapted eye sees it.

use super::contrasts::Contrasts;
use super::field::Field;
use super::light_shares::{Rendering, luminance_of};
use super::luminance::Luminance;
use eyebox_base::vision::threshold_ferwerda;
use eyebox_film::frame::Frame;

/// Side of the square patch that a leak is averaged over, degrees: small against a head-up display, large against noise.
const PATCH_DEG: f64 = 0.5;
/// Its least side in pixels.
const PATCH_PIXELS: usize = 3;
/// Share of a picture's width where the header does not say how wide the eye looks.
const PATCH_SHARE: f64 = 1.0 / 24.0;

/// The brightest patch of a picture.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Spot {
    /// Centre in pixels from the top left, to the right and down.
    pub at_pixel: [f64; 2],
    /// Degrees to the right and up of the line of sight, if the header says how wide the eye looks.
    pub at_deg: Option<[f64; 2]>,
    /// Side of the patch, pixels.
    pub patch_pixels: usize,
    /// Mean luminance of the patch.
    pub cd_m2: f64,
}

/// A leak against the eye's threshold.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Visibility {
    /// The eye is adapted to this.
    pub adaptation_cd_m2: f64,
    /// Ferwerda's photopic threshold there.
    pub threshold_cd_m2: f64,
    /// Leak over threshold: above 1 it is seen.
    pub factor: f64,
    pub visible: bool,
}

impl Visibility {
    pub fn of(leak_cd_m2: f64, adaptation_cd_m2: f64) -> Visibility {
        let threshold_cd_m2 = threshold_ferwerda(adaptation_cd_m2);
        let factor = leak_cd_m2 / threshold_cd_m2;
        Visibility { adaptation_cd_m2, threshold_cd_m2, factor, visible: factor > 1.0 }
    }
}

/// The groups whose light the slide modulates: the one with the largest Σ|open − content|, and none beside it unless it has
/// less than a tenth of that. The error lists the candidates.
pub fn modulated(rendering: &Rendering) -> Result<String, Vec<String>> {
    let weigh = Luminance::in_frame(rendering.frame);
    let mut weights: Vec<(f64, &str)> = Vec::new();
    for share in &rendering.shares {
        if !share.is_split() {
            continue;
        }
        let weight: f64 = share
            .split
            .iter()
            .chain(share.by_slide.iter().map(|(_, split)| split))
            .map(|split| [split.open, split.content])
            .chain(share.by_pair.iter().map(|(_, series)| [series.open_open, series.content_content]))
            .map(|[open, content]| {
                let (open, content) = (weigh.image(open), weigh.image(content));
                open.iter().zip(&content).map(|(open, content)| (open - content).abs()).sum::<f64>()
            })
            .sum();
        match weights.iter_mut().find(|(_, group)| *group == share.group) {
            Some((sum, _)) => *sum += weight,
            None => weights.push((weight, share.group.as_str())),
        }
    }
    weights.retain(|(weight, _)| *weight > 0.0);
    weights.sort_by(|a, b| b.0.total_cmp(&a.0));
    match weights.as_slice() {
        [(_, only)] => Ok((*only).to_owned()),
        [(most, first), (next, _), ..] if *next < 0.1 * most => Ok((*first).to_owned()),
        many => Err(many.iter().map(|(_, group)| (*group).to_owned()).collect()),
    }
}

/// open/C of these groups' shares that slides modulate, cd/m² of luminance per pixel, and of light through two slides
/// open/(C·C′): for the contrasts that are asked for, or that were rendered.
pub fn leak_luminance(rendering: &Rendering, groups: &[String], contrasts: &Contrasts) -> Vec<f64> {
    let pixels = rendering.frame.width * rendering.frame.height;
    let weigh = Luminance::in_frame(rendering.frame);
    let mut sum = vec![0.0; pixels];
    let mut add =
        |open: Vec<f64>, contrast: f64| sum.iter_mut().zip(open).for_each(|(sum, open)| *sum += open / contrast);
    for share in rendering.shares.iter().filter(|share| groups.contains(&share.group)) {
        let contrast_of = |slide: usize| {
            let rendered = || rendering.slides.get(slide).map(|slide| slide.contrast);
            contrasts.each().nth(slide).or_else(rendered).unwrap_or(f64::INFINITY)
        };
        if share.by_slide.is_empty() && share.by_pair.is_empty() && share.split.is_some() {
            // The share with the slide open is the share for C = 1.
            let open = luminance_of(share, &Contrasts::of_all(rendering, 1.0), &weigh, pixels);
            add(open, contrasts.all().or(rendering.contrast).unwrap_or(f64::INFINITY));
        }
        for (slide, split) in &share.by_slide {
            add(weigh.image(split.open).to_vec(), contrast_of(*slide));
        }
        // Where both are dark.
        for ([one, other], series) in &share.by_pair {
            add(weigh.image(series.open_open).to_vec(), contrast_of(*one) * contrast_of(*other));
        }
    }
    sum
}

/// Side of the patch of [`brightest`], pixels: half a degree, three pixels at least, within the picture.
pub fn patch_pixels(frame: &Frame) -> usize {
    let side = match Field::of(frame) {
        Some(field) => PATCH_DEG / field.pixel_deg(),
        None => PATCH_SHARE * frame.width as f64,
    };
    (side.round() as usize).max(PATCH_PIXELS).min(frame.width).min(frame.height).max(1)
}

/// The square patch with the largest mean; none for a picture that is black or smaller than the patch.
pub fn brightest(frame: &Frame, luminance: &[f64]) -> Option<Spot> {
    let (width, height, side) = (frame.width, frame.height, patch_pixels(frame));
    if luminance.len() != width * height || side > width || side > height {
        return None;
    }
    // Sums over all pixels above and to the left.
    let mut table = vec![0.0; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0.0;
        for x in 0..width {
            row += luminance[y * width + x];
            table[(y + 1) * (width + 1) + x + 1] = table[y * (width + 1) + x + 1] + row;
        }
    }
    let at = |x: usize, y: usize| table[y * (width + 1) + x];
    let mut best: Option<(f64, usize, usize)> = None;
    for y in 0..=height - side {
        for x in 0..=width - side {
            let sum = at(x + side, y + side) - at(x, y + side) - at(x + side, y) + at(x, y);
            if sum > best.map_or(0.0, |(sum, ..)| sum) {
                best = Some((sum, x, y));
            }
        }
    }
    let (sum, x, y) = best?;
    let at_pixel = [x, y].map(|corner| corner as f64 + 0.5 * side as f64);
    let at_deg = Field::of(frame).map(|field| field.place_deg(at_pixel));
    Some(Spot { at_pixel, at_deg, patch_pixels: side, cd_m2: sum / (side * side) as f64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brightest_patch_is_found() {
        let mut frame = Frame::new(48, 20);
        let spot = |i: usize| if (i % 48).abs_diff(30) <= 1 && (i / 48).abs_diff(7) <= 1 { 9.0 } else { 1.0 };
        let picture: Vec<f64> = (0..48 * 20).map(spot).collect();
        let found = brightest(&frame, &picture).unwrap();
        assert_eq!((found.patch_pixels, found.at_pixel, found.at_deg), (3, [30.5, 7.5], None));
        assert!((found.cd_m2 - 9.0).abs() < 1e-12);
        frame.height = 0;
        assert_eq!(brightest(&frame, &[]), None);
    }

    /// The paper's own numbers: 10000 and 1600 cd/m² at 300:1, adapted to 234 and 142 cd/m² (`design/eye.md`).
    #[test]
    fn visibility_as_in_figures_8_and_9() {
        let (seen, hidden) = (Visibility::of(10_000.0 / 300.0, 234.0), Visibility::of(1600.0 / 300.0, 142.0));
        assert!((seen.factor - 2.56).abs() < 0.005 && seen.visible, "{seen:?}");
        assert!((hidden.factor - 0.68).abs() < 0.005 && !hidden.visible, "{hidden:?}");
    }
}
