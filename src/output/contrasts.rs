//! For which contrasts of its slides a frame is mixed, and what a share of light is there.

use super::light_shares::{Rendering, Series, Share};

/// Contrasts that are changed; by default none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contrasts {
    /// That of the only slide, or of all alike where they were rendered with one contrast.
    all: Option<f64>,
    /// Of several slides, from what each was rendered with to what it is changed to.
    each: Vec<[f64; 2]>,
}

impl Contrasts {
    /// All slides at one contrast.
    pub fn of_all(rendering: &Rendering, contrast: f64) -> Contrasts {
        Contrasts::new(rendering, Some(contrast), &[])
    }

    /// All slides at `all` (as rendered if none) but those that are named.
    pub fn new(rendering: &Rendering, all: Option<f64>, named: &[(String, f64)]) -> Contrasts {
        let new =
            |slide: &str| named.iter().rev().find(|(name, _)| name == slide).map(|(_, contrast)| *contrast).or(all);
        let slides = rendering.slides.iter();
        let each: Vec<[f64; 2]> =
            slides.map(|slide| [slide.contrast, new(&slide.name).unwrap_or(slide.contrast)]).collect();
        let together = match each.split_first() {
            None => all,
            Some(([_, first], others)) => others.iter().all(|[_, to]| to == first).then_some(*first),
        };
        let all = together.filter(|to| rendering.contrast.is_some_and(|rendered| rendered != *to));
        Contrasts { all, each }
    }

    /// That of the only slide, or of all alike, if it is changed.
    pub fn all(&self) -> Option<f64> {
        self.all
    }

    /// What each of several slides is at.
    pub fn each(&self) -> impl Iterator<Item = f64> {
        self.each.iter().map(|[_, to]| *to)
    }

    /// The slides, by number, that are changed, each from and to which contrast.
    pub fn changed(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        self.each.iter().copied().enumerate().filter(|(_, [from, to])| from != to)
    }
}

impl Share<'_> {
    /// Whether its light is told for other contrasts.
    pub fn is_split(&self) -> bool {
        self.split.is_some() || !self.by_slide.is_empty() || !self.by_pair.is_empty()
    }

    /// Whether it is other light at these contrasts.
    pub fn follows(&self, contrasts: &Contrasts) -> bool {
        match (&self.split, contrasts.all) {
            (Some(_), Some(_)) => true,
            (_, _) => contrasts.changed().any(|(slide, _)| {
                self.of_slide(slide).is_some() || self.by_pair.iter().any(|(pair, _)| pair.contains(&slide))
            }),
        }
    }

    /// One channel at these contrasts, at one pixel.
    pub fn value(&self, contrasts: &Contrasts, channel: usize, pixel: usize) -> f64 {
        if let (Some(split), Some(contrast)) = (&self.split, contrasts.all) {
            return split.value(contrast, channel, pixel);
        }
        let rendered = self.picture[channel].get(pixel).map_or(0.0, |value| f64::from(*value));
        // Light through each slide alone, and through two.
        let change = |(slide, [from, to]): (usize, [f64; 2])| {
            let split = self.of_slide(slide)?;
            Some(split.value(to, channel, pixel) - split.value(from, channel, pixel))
        };
        let of_both = |(pair, series): &([usize; 2], Series)| {
            let [[from, to], [other_from, other_to]] =
                pair.map(|slide| contrasts.each.get(slide).copied().unwrap_or([1.0; 2]));
            if from == to && other_from == other_to {
                return 0.0;
            }
            series.value([to, other_to], channel, pixel) - series.value([from, other_from], channel, pixel)
        };
        rendered + contrasts.changed().filter_map(change).sum::<f64>() + self.by_pair.iter().map(of_both).sum::<f64>()
    }

    /// By how much its standard error grows at most where single slides among several change; none if the frame doesn't hold it. The
    /// light of a slide becomes (u′ − u)·(content − open) more, and the error of a sum is at most the sum of the errors. Light that
    /// crosses the slide more than once has no part in it.
    pub fn error_growth(&self, contrasts: &Contrasts, pixel: usize) -> Option<f64> {
        let in_series = |slide: usize| self.by_pair.iter().any(|(pair, _)| pair.contains(&slide));
        let mut sum = 0.0;
        for (slide, [from, to]) in contrasts.changed() {
            if in_series(slide) {
                return None;
            }
            let Some(split) = self.of_slide(slide) else { continue };
            let sigma = split.change_error?.get(pixel).map_or(0.0, |sigma| f64::from(*sigma));
            sum += (1.0 / from - 1.0 / to).abs() * sigma;
        }
        Some(sum)
    }

    /// Variance of its luminance at these contrasts; none if the frame doesn't hold it.
    pub fn variance(&self, contrasts: &Contrasts, pixel: usize) -> Option<f64> {
        match (&self.split, contrasts.all) {
            (Some(split), Some(contrast)) => split.variance(contrast, pixel),
            (_, _) if self.follows(contrasts) => None,
            (_, _) => Some(self.error?.get(pixel).map_or(0.0, |error| f64::from(*error).powi(2))),
        }
    }
}
