//! What the contrast of each of several slides does to the picture.

use super::facts::round;
use crate::contrasts::Contrasts;
use crate::light_shares::{Rendering, luminance_of};
use crate::luminance::Luminance;

/// Name and what it does, a row for each slide in the header's order; none for a scene with one slide.
pub fn rows(rendering: &Rendering) -> Vec<[String; 2]> {
    let weigh = Luminance::in_frame(rendering.frame);
    let pixels = rendering.frame.width * rendering.frame.height;
    let mean = |contrasts: &Contrasts| -> f64 {
        let of = |share| luminance_of(share, contrasts, &weigh, pixels).iter().sum::<f64>() / pixels.max(1) as f64;
        rendering.shares.iter().map(of).sum()
    };
    let row = |slide: &eyebox_film::finish::slides::SlideInfo| {
        let name = &slide.name;
        let because = rendering.shares.iter().flat_map(|share| &share.refused_by_slide).find(|(own, _)| own == name);
        let said = match because {
            Some((_, because)) => format!("its light is not told apart: {because}"),
            None => {
                let at = |contrast: f64| mean(&Contrasts::new(rendering, None, &[(name.clone(), contrast)]));
                let [open, rendered, black] = [1.0, slide.contrast, f64::INFINITY].map(at);
                let [open, rendered, black] = [open, rendered, black].map(|value| format!("{value:.4}"));
                format!(
                    "the picture's mean is {rendered} cd/m²; {open} with it open, {black} with a perfect black of it"
                )
            }
        };
        [format!("contrast of {name}"), format!("{}: {said}", round(slide.contrast))]
    };
    rendering.slides.iter().map(row).collect()
}
