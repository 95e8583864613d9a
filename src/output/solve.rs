//! The lamp level that reaches a goal: the picture's contrast against its background, or a leak that is not seen.

use super::leak::{Visibility, brightest, leak_luminance, modulated};
use super::light_shares::{Rendering, luminance_of};
use super::luminance::Luminance;
use super::mix::Recipe;
use eyebox_base::error::{Error, Result, Where};
use eyebox_base::vision::threshold_ferwerda;

/// Gains are looked for below this.
const MOST_GAIN: f64 = 1e9;

/// What is to be reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// (background + picture)/(background + leak), over the lit part of the picture.
    Contrast(f64),
    /// The brightest level at which the brightest patch of the leak is at Ferwerda's threshold.
    LeakHidden,
}

impl Goal {
    /// `contrast=1.5` or `leak=hidden`.
    pub fn parse(text: &str) -> std::result::Result<Goal, String> {
        let bad = || format!("`{text}` is no goal; write contrast=1.5 or leak=hidden");
        match text.split_once('=').ok_or_else(bad)? {
            ("contrast", number) => match number.trim().parse::<f64>() {
                Ok(contrast) if contrast > 1.0 && contrast.is_finite() => Ok(Goal::Contrast(contrast)),
                Ok(_) | Err(_) => Err(format!("`{number}` is no contrast to solve for; expected more than 1, finite")),
            },
            ("leak", "hidden") => Ok(Goal::LeakHidden),
            (_, _) => Err(bad()),
        }
    }
}

/// The answer. Luminances are at the solved level, cd/m².
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Solved {
    pub goal: String,
    pub groups: Vec<String>,
    /// Factor of these groups, on top of the gains that were asked for.
    pub gain: f64,
    /// The goal holds at every level, so nothing was changed.
    pub at_every_level: bool,
    /// Of the lit part of the picture, without background.
    pub picture_cd_m2: f64,
    /// Of all other light, over the same pixels.
    pub background_cd_m2: f64,
    /// Of the leak, over the same pixels.
    pub leak_cd_m2: f64,
    /// (background + picture)/(background + leak).
    pub contrast: f64,
    /// Mean luminance of the brightest patch of the leak, and whether it is seen at the adaptation to the whole picture.
    pub leak_spot_cd_m2: f64,
    pub visibility: Visibility,
}

/// What of the picture scales with the groups' gain, and what does not.
struct Levels {
    picture: f64,
    background: f64,
    leak: f64,
    spot: f64,
    /// Mean over the whole frame of the groups' light, and of the other light.
    mean_own: f64,
    mean_other: f64,
}

impl Levels {
    fn at(&self, goal: String, groups: Vec<String>, gain: f64) -> Solved {
        let (picture_cd_m2, leak_cd_m2) = (gain * self.picture, gain * self.leak);
        Solved {
            goal,
            groups,
            gain,
            at_every_level: false,
            picture_cd_m2,
            background_cd_m2: self.background,
            leak_cd_m2,
            contrast: (self.background + picture_cd_m2) / (self.background + leak_cd_m2),
            leak_spot_cd_m2: gain * self.spot,
            visibility: Visibility::of(gain * self.spot, self.mean_other + gain * self.mean_own),
        }
    }
}

/// The gain of `groups` (of the group that the slide modulates most, if none are named) that reaches the goal, with the
/// gains and the contrast of `recipe`.
///
/// A leak that no level makes visible leaves the lamps as they are.
///
/// Errors: unknown groups, a slide that modulates several groups alike, a picture without light, a contrast that no gain
/// reaches.
pub fn solve(rendering: &Rendering, recipe: &Recipe, groups: &[String], goal: Goal) -> Result<Solved> {
    recipe.check(rendering)?;
    let groups = chosen(rendering, groups)?;
    let levels = measured(rendering, recipe, &groups)?;
    let said = match goal {
        Goal::Contrast(contrast) => format!("contrast={contrast}"),
        Goal::LeakHidden => "leak=hidden".to_owned(),
    };
    let unreached = |what: String| Error::new(Where::Option(format!("--solve {said}")), what);
    let gain = match goal {
        Goal::Contrast(contrast) => {
            // B + g·W = X(B + g·K).
            let slope = levels.picture - contrast * levels.leak;
            if slope.is_nan() || slope <= 0.0 {
                let most = levels.picture / levels.leak;
                return Err(unreached(format!("no lamp level reaches it: the slide's own contrast is {most:.4}"))
                    .expected("less than that"));
            }
            (contrast - 1.0) * levels.background / slope
        }
        Goal::LeakHidden => match brightest_hidden(&levels) {
            Some(gain) => gain,
            None => return Ok(Solved { at_every_level: true, ..levels.at(said, groups, 1.0) }),
        },
    };
    if !(gain > 0.0 && gain < MOST_GAIN) {
        return Err(unreached(format!("it would need a gain of {gain:.3e}"))
            .expected("a background and a picture with light in them"));
    }
    Ok(levels.at(said, groups, gain))
}

/// The least gain above which the leak shows. None: it never does.
fn brightest_hidden(levels: &Levels) -> Option<f64> {
    let hidden = |gain: f64| gain * levels.spot <= threshold_ferwerda(levels.mean_other + gain * levels.mean_own);
    // In the dark every threshold is above zero, so the smallest gains hide; up from there in steps, then by halves.
    let mut low = 1.0 / MOST_GAIN;
    let mut high = low;
    while hidden(high) {
        low = high;
        high *= 1.05;
        if high > MOST_GAIN {
            return None;
        }
    }
    for _ in 0..100 {
        let middle = (low * high).sqrt();
        if hidden(middle) { low = middle } else { high = middle }
    }
    Some(low)
}

fn chosen(rendering: &Rendering, groups: &[String]) -> Result<Vec<String>> {
    let at = |group: &str| Where::Option(format!("--solve-for {group}"));
    if let Some(unknown) = groups.iter().find(|group| !rendering.groups.contains(group)) {
        return Err(Error::new(at(unknown), format!("the frame has no light group `{unknown}`"))
            .expected(format!("one of {}", rendering.groups.join(", ")))
            .nearest(unknown, rendering.groups.iter().map(String::as_str)));
    }
    if !groups.is_empty() {
        return Ok(groups.to_vec());
    }
    modulated(rendering).map(|group| vec![group]).map_err(|candidates| {
        let (what, of) = if candidates.is_empty() {
            ("no group's light depends on a slide", rendering.groups.join(", "))
        } else {
            ("the slide modulates several groups", candidates.join(", "))
        };
        Error::new(Where::Option("--solve".to_owned()), what).expected(format!("--solve-for GROUP,… of {of}"))
    })
}

fn measured(rendering: &Rendering, recipe: &Recipe, groups: &[String]) -> Result<Levels> {
    let frame = rendering.frame;
    let pixels = frame.width * frame.height;
    let weigh = Luminance::in_frame(frame);
    let contrasts = recipe.contrasts(rendering);
    let (mut own, mut other) = (vec![0.0; pixels], vec![0.0; pixels]);
    for share in &rendering.shares {
        let to = if groups.contains(&share.group) { &mut own } else { &mut other };
        let gain = recipe.gain(&share.group);
        let light = luminance_of(share, &contrasts, &weigh, pixels);
        to.iter_mut().zip(light).for_each(|(sum, light)| *sum += gain * light);
    }
    let mut leak = vec![0.0; pixels];
    for group in groups {
        let gain = recipe.gain(group);
        let light = leak_luminance(rendering, std::slice::from_ref(group), &contrasts);
        leak.iter_mut().zip(light).for_each(|(sum, light)| *sum += gain * light);
    }
    let lit = lit_pixels(&own);
    if lit.is_empty() {
        let what = format!("there is no light of {} in the frame", groups.join(", "));
        return Err(Error::new(Where::Option("--solve".to_owned()), what).expected("a group with light"));
    }
    let over_lit = |data: &[f64]| mean(lit.iter().filter_map(|pixel| data.get(*pixel)));
    Ok(Levels {
        picture: over_lit(&own),
        background: over_lit(&other),
        leak: over_lit(&leak),
        spot: brightest(frame, &leak).map_or(0.0, |spot| spot.cd_m2),
        mean_own: mean(own.iter()),
        mean_other: mean(other.iter()),
    })
}

/// The pixels of a picture brighter than half of ΣL²/ΣL: of a picture of two levels, bright and dark, the bright ones,
/// however few they are.
pub fn lit_pixels(luminance: &[f64]) -> Vec<usize> {
    let (sum, squares) = luminance.iter().fold((0.0, 0.0), |(sum, squares), l| (sum + l, squares + l * l));
    let level = 0.5 * squares / sum;
    if !(sum > 0.0 && level.is_finite()) {
        return Vec::new();
    }
    luminance.iter().enumerate().filter(|(_, l)| **l > level).map(|(pixel, _)| pixel).collect()
}

/// 0 of nothing.
pub fn mean<'v>(values: impl Iterator<Item = &'v f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u64), |(sum, count), value| (sum + value, count + 1));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

#[cfg(test)]
mod tests;
