//! What rays from the eye may not have met. Passes that met nothing have no variance, and neither have those that all met the
//! same: nothing seen is not nothing there. Two bounds say what may be, and stand in the stated error.
//!
//! - Light that no ray has met: of a place in picture and pupil that has the share p of a pixel's rays, n rays miss all with
//!   probability (1 − p)ⁿ < e^(−np), so they hardly ever miss one with p above 8/n, and it is no brighter than a lamp is.
//! - A pixel that differs from all around it but one, as a lamp in it does: its rays may all have met that, or all missed it, though
//!   it covers but a part.

use std::f64::consts::LN_10;

/// Of four stated errors: n rays miss what has 4·`NEVER`/n of them once in e⁸ = 2981.
const NEVER: f64 = 2.0;
/// Of four stated errors: n rays all meet what has 1 − 4·`ALL`/n of them once in 1000.
const ALL: f64 = 3.0 * LN_10 / 4.0;

/// A lamp within the picture of which no point was seen from the pupil.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Hidden {
    /// cd/m²
    pub luminance: f64,
    /// Ways to it that were tried, per pixel of its image.
    pub looks: f64,
}

impl Hidden {
    /// The one of which more may be missed, of luminances and looks that may be of different lamps.
    #[must_use]
    pub fn or(self, other: Hidden) -> Hidden {
        Hidden { luminance: self.luminance.max(other.luminance), looks: self.looks.min(other.looks) }
    }

    /// What may be in a file.
    pub fn is_valid(&self) -> bool {
        [self.luminance, self.looks].iter().all(|x| x.is_finite() && *x >= 0.0)
    }
}

/// What a plan knows of what rays from the eye may miss.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Doubts {
    /// Luminance, cd/m²: a share of that of the brightest lamp, since images of lamps were looked for. None: nobody has looked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brightest: Option<f64>,
    /// Lamps within the picture that something hides, perhaps not all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hidden: Option<Hidden>,
    /// Share of a lamp's luminance that may be missed where paths meet it behind a scatterer by chance alone: less than 1 where
    /// pilots have compared these paths with others, 0 where no face sends light on in a bundle.
    pub of_caustics: f64,
    /// Pixels all over the picture that a pilot looked at as a pass does, and found no light.
    pub glances: u64,
}

impl Default for Doubts {
    fn default() -> Self {
        Doubts { brightest: None, hidden: None, of_caustics: 1.0, glances: 0 }
    }
}

impl Doubts {
    /// Nobody has looked.
    pub fn is_none(&self) -> bool {
        *self == Doubts::default()
    }

    /// What may be in a file.
    pub fn is_valid(&self) -> bool {
        self.brightest.is_none_or(|brightest| brightest >= 0.0 && brightest.is_finite())
            && self.hidden.is_none_or(|hidden| hidden.is_valid())
            && (0.0..=1.0).contains(&self.of_caustics)
    }
}

/// What is known of the rays of a film that look for lamps.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Unseen {
    /// Luminance of the brightest lamp that they look for, cd/m²; 0 where pilots have seen that there is no way to one.
    pub brightest: f64,
    /// Rays in a pixel and pass.
    pub looks: f64,
    /// Rays of a pilot in a pixel.
    #[serde(default)]
    before: f64,
    /// Lamps that something hides, perhaps not all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hidden: Option<Hidden>,
    /// How many pixels in a row are known only by rays, and how many after these by more: lamps' images that are looked for, edges
    /// that are cut. And so on, row by row.
    known: Vec<u32>,
    /// Pixels by number in which rays are aimed at small images of lamps, ascending: a plan knows that they need many.
    aimed: Vec<u32>,
}

impl Unseen {
    /// `known`: by pixel; `aimed`: numbers of pixels.
    pub fn new(brightest: f64, looks: f64, known: &[bool], mut aimed: Vec<u32>) -> Unseen {
        aimed.sort_unstable();
        let mut runs = vec![0u32];
        let mut last = false;
        for own in known {
            if *own != last {
                (last, _) = (*own, runs.push(0));
            }
            if let Some(run) = runs.last_mut() {
                *run += 1;
            }
        }
        Unseen { brightest, looks, before: 0.0, hidden: None, known: runs, aimed }
    }

    /// And lamps that something hides, perhaps not all of them.
    #[must_use]
    pub fn beside(self, hidden: Option<Hidden>) -> Unseen {
        Unseen { hidden, ..self }
    }

    /// After so many rays of a pilot in a pixel, which found nothing.
    #[must_use]
    pub fn after(self, before: f64) -> Unseen {
        Unseen { before, ..self }
    }

    /// Whether the numbers of a file fit so many pixels.
    pub fn is_valid(&self, pixels: usize) -> bool {
        let known = self.known.iter().map(|run| u64::from(*run)).sum::<u64>();
        let sound = |x: &f64| x.is_finite() && *x >= 0.0;
        let ascends = self.aimed.is_sorted_by(|a, b| a < b);
        let hidden = self.hidden.is_none_or(|hidden| hidden.is_valid());
        hidden
            && [self.brightest, self.looks, self.before].iter().all(sound)
            && self.looks > 0.0
            && known == pixels as u64
            && ascends
    }

    /// Whether rays are aimed in a pixel by number.
    pub fn is_aimed(&self, pixel: usize) -> bool {
        u32::try_from(pixel).is_ok_and(|pixel| self.aimed.binary_search(&pixel).is_ok())
    }

    /// Sum over pixels of the luminance, cd/m², that rays have missed at the most, a quarter of it (so that four stated errors
    /// cover it). `passes`: the fewest of a pixel.
    pub fn light(&self, passes: u64) -> f64 {
        let looks = self.before + self.looks * passes as f64;
        let hidden = self.hidden.map_or(0.0, |hidden| hidden.luminance / (hidden.looks + looks));
        if self.brightest > 0.0 || hidden > 0.0 { NEVER * hidden.max(self.brightest / looks) } else { 0.0 }
    }

    /// Passes of every pixel with which that is no more than so much light.
    pub fn passes_for(&self, light: f64) -> u64 {
        let looks = NEVER * self.brightest / light;
        let for_hidden = self.hidden.map_or(0.0, |hidden| NEVER * hidden.luminance / light - hidden.looks);
        ((looks.max(for_hidden) - self.before) / self.looks).max(0.0).ceil() as u64
    }

    /// Per pixel, in rows of `width`: the variance that its mean has at least, (cd/m²)². `means`: luminance; `passes`: of a pixel.
    pub fn doubts(&self, width: usize, means: &[f64], passes: impl Fn(usize) -> u64) -> Vec<f64> {
        let mut doubts = vec![0.0; means.len()];
        let (mut pixel, mut by_more) = (0, false);
        for run in &self.known {
            let end = (pixel + *run as usize).min(means.len());
            if !by_more {
                for (own, doubt) in (pixel..end).zip(&mut doubts[pixel..end]) {
                    let share = (ALL / (self.looks * passes(own) as f64)).min(1.0);
                    *doubt = (share * alone(width, means, own)).powi(2);
                }
            }
            (pixel, by_more) = (end, !by_more);
        }
        doubts
    }
}

/// By how much a pixel is brighter, or darker, than all of its neighbours but one: an edge goes on from pixel to pixel.
fn alone(width: usize, means: &[f64], pixel: usize) -> f64 {
    let own = means[pixel];
    let (x, y) = (pixel % width, pixel / width);
    let (mut high, mut low) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
    for row in y.saturating_sub(1)..(y + 2).min(means.len() / width) {
        for column in x.saturating_sub(1)..(x + 2).min(width) {
            let at = row * width + column;
            if at != pixel {
                high = [high[0].max(means[at]), high[1].max(high[0].min(means[at]))];
                low = [low[0].min(means[at]), low[1].min(low[0].max(means[at]))];
            }
        }
    }
    if high[1].is_finite() { (own - high[1]).max(low[1] - own).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};

    /// Whatever share of its pixels' rays a light has, what it brings to the sum is within four stated errors of what n rays each have
    /// found but in one of a thousand runs.
    #[test]
    fn what_is_missed_is_covered() {
        const RUNS: u64 = 100_000;
        for (looks, passes) in [(4.0, 2), (4.0, 16), (0.25, 64)] {
            let unseen = Unseen::new(1e6, looks, &[false], Vec::new());
            let rays = looks * passes as f64;
            let mut worst = 0.0f64;
            for share in [0.1, 0.5, 1.0, 2.0, 4.0, 7.0, 7.9].map(|expected: f64| (expected / rays).min(1.0)) {
                let missed = (1.0 - share).powf(rays);
                let error = 1e6 * share;
                if error > 4.0 * unseen.light(passes) {
                    worst = worst.max(missed);
                }
            }
            assert!(worst < 1e-3, "{looks} {passes}: {worst}");
            // And the bound is no larger than it has to be.
            assert!(4.0 * unseen.light(passes) < 1e6 * 10.0 / rays);
        }
        let mut rng = Rng::new(1, Stream::Check, 0, 0);
        for share in [0.5, 0.8, 0.95, 0.99] {
            let (mut off, passes, looks) = (0, 2, 4);
            for _ in 0..RUNS {
                let met = (0..passes * looks).filter(|_| rng.uniform() < share).count() as f64;
                let mean = met / (passes * looks) as f64;
                // A pixel of light in nine of none.
                let mut means = vec![0.0; 9];
                means[4] = mean;
                let doubt =
                    Unseen::new(1.0, looks as f64, &[false; 9], Vec::new()).doubts(3, &means, |_| passes as u64)[4];
                let all_met = mean == 1.0;
                off += u32::from(all_met && (mean - share).abs() > 4.0 * doubt.sqrt());
            }
            assert!(f64::from(off) < 1e-3 * RUNS as f64 + 40.0, "{share}: {off}");
        }
    }

    #[test]
    fn passes_follow_from_light() {
        let unseen = Unseen::new(3e5, 4.0, &[false, true], Vec::new());
        let passes = unseen.passes_for(12.0);
        assert!(unseen.light(passes) <= 12.0 && unseen.light(passes - 1) > 12.0);
        // What a pilot has looked at counts, and may be enough.
        let looked = unseen.clone().after(4.0 * 100.0);
        assert_eq!((looked.passes_for(12.0), looked.light(1)), (passes - 100, unseen.light(101)));
        assert_eq!(unseen.clone().after(1e6).passes_for(12.0), 0);
        let hidden = Unseen { brightest: 0.0, hidden: Some(Hidden { luminance: 3e5, looks: 1e4 }), ..unseen };
        let passes = hidden.passes_for(12.0);
        assert!(hidden.light(passes) <= 12.0 && hidden.light(passes - 1) > 12.0, "{passes}");
    }

    /// Edges go on from pixel to pixel, and what is known by more than rays is left out.
    #[test]
    fn doubts_are_of_single_pixels() {
        let mut means = vec![1.0; 25];
        (0..25).filter(|pixel| pixel % 5 == 2).for_each(|pixel| means[pixel] = 7.0);
        let unseen = Unseen::new(1.0, 4.0, &[false; 25], Vec::new());
        // Where it ends at the picture's rim it has but one neighbour.
        let within = |unseen: &Unseen, means: &[f64]| unseen.doubts(5, means, |_| 2)[5..20].to_vec();
        assert!(within(&unseen, &means).iter().all(|doubt| *doubt == 0.0));
        means[10] = 20.0;
        let doubts = within(&unseen, &means);
        assert_eq!(doubts.iter().filter(|doubt| **doubt > 0.0).count(), 1);
        assert!((doubts[5].sqrt() - 19.0 * ALL / 8.0).abs() < 1e-12, "{}", doubts[5].sqrt());
        let mut known = [false; 25];
        known[10] = true;
        let unseen = Unseen::new(1.0, 4.0, &known, Vec::new());
        assert!(unseen.is_valid(25) && !unseen.is_valid(24));
        assert!(within(&unseen, &means).iter().all(|doubt| *doubt == 0.0));
    }
}
