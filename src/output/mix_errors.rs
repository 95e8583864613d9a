//! Standard errors of a mixed frame.
//!
//! A sum of shares with gains gᵢ has the variance Σᵢⱼ gᵢgⱼ·covᵢⱼ. A frame holds the variances of the shares and of their
//! sum, so the sum of all covariances is known, and for two shares that is the only one. For more it is spread over the
//! pairs as one correlation ρ = (V − Σσᵢ²)/Σᵢ≠ⱼ σᵢσⱼ: exact for two shares, and where all gains are alike.
//!
//! Of single slides among several only the errors of what their contrasts change are held. Errors of sums are at most sums of errors.

use super::contrasts::Contrasts;
use super::light_shares::{PLATE, Rendering, Share, not_negative};
use super::mix::{Errors, Recipe, is_lit, set_layer};
use eyebox_film::frame::Frame;
use eyebox_film::layer::Layer;

/// Sets the errors in `out`, the frame with the new light; removes those that cannot be known.
pub fn carry(rendering: &Rendering, recipe: &Recipe, contrasts: &Contrasts, out: &mut Frame) -> Errors {
    let frame = rendering.frame;
    let pixels = frame.width * frame.height;
    let lit: Vec<&Share> = rendering.shares.iter().filter(|share| share.layer != PLATE && is_lit(share)).collect();
    for share in &rendering.shares {
        let name = format!("{}_stderr", share.name);
        match Terms::of(share, recipe, contrasts) {
            Some(terms) => {
                let sigma = (0..pixels).map(|pixel| terms.after(pixel) as f32).collect();
                set_layer(out, &name, &same(sigma));
            }
            None => {
                let grown = |(pixel, sigma): (usize, &f32)| {
                    let growth = if share.follows(contrasts) {
                        // All contrasts together are no sum over the slides.
                        share.error_growth(contrasts, pixel).filter(|_| contrasts.all().is_none())?
                    } else {
                        0.0
                    };
                    Some((recipe.gain(&share.group) * (f64::from(*sigma) + growth)) as f32)
                };
                match share.error.and_then(|error| error.iter().enumerate().map(grown).collect::<Option<Vec<f32>>>()) {
                    Some(sigma) => set_layer(out, &name, &same(sigma)),
                    None => out.channels.retain(|channel| channel.layer() != name),
                }
            }
        }
    }
    for layer in Layer::SUM_ORDER.map(Layer::name) {
        let own: Vec<&Share> = lit.iter().copied().filter(|share| share.layer == layer).collect();
        sum(frame, recipe, contrasts, &own, &format!("{layer}_stderr"), out);
    }
    let mut aovs: Vec<&str> = rendering.taken.iter().map(|share| share.layer.as_str()).collect();
    aovs.dedup();
    for aov in aovs {
        let own: Vec<&Share> = rendering.taken.iter().filter(|share| share.layer == aov && is_lit(share)).collect();
        sum(frame, recipe, contrasts, &own, &format!("{aov}_stderr"), out);
    }
    sum(frame, recipe, contrasts, &lit, "stderr", out)
}

/// The errors of a sum of shares, whose rendered ones are the layer `name`.
fn sum(
    frame: &Frame,
    recipe: &Recipe,
    contrasts: &Contrasts,
    shares: &[&Share],
    name: &str,
    out: &mut Frame,
) -> Errors {
    let Some([stored, ..]) = frame.rgb(name) else { return Errors::Absent };
    let new_contrast = |share: &Share| share.follows(contrasts);
    let grows = |share: &Share| contrasts.all().is_none() && share.error_growth(contrasts, 0).is_some();
    let gains: Vec<f64> = shares.iter().map(|share| recipe.gain(&share.group)).collect();
    let [first, ..] = gains.as_slice() else { return Errors::Exact };
    let alike = gains.iter().all(|gain| gain == first) && !shares.iter().any(|share| new_contrast(share));
    let terms: Option<Vec<Terms>> = shares.iter().map(|share| Terms::of(share, recipe, contrasts)).collect();
    let (sigma, errors): (Vec<f32>, Errors) = if alike {
        (stored.iter().map(|sigma| (f64::from(*sigma) * first) as f32).collect(), Errors::Exact)
    } else if let Some(terms) = terms {
        let at = |(pixel, sigma): (usize, &f32)| combined(f64::from(*sigma).powi(2), &terms, pixel).sqrt() as f32;
        let exact = terms.len() <= 2 && !shares.iter().any(|share| new_contrast(share));
        (stored.iter().enumerate().map(at).collect(), if exact { Errors::Exact } else { Errors::FromShares })
    } else if shares.iter().all(|share| !new_contrast(share) || grows(share)) {
        let largest = |pixel: usize| {
            let own = shares.iter().zip(&gains).filter(|(share, _)| {
                share.picture.iter().any(|data| data.get(pixel).is_some_and(|value| *value != 0.0))
            });
            let largest = own.map(|(_, gain)| *gain).fold(f64::NEG_INFINITY, f64::max);
            if largest.is_finite() { largest } else { gains.iter().copied().fold(0.0, f64::max) }
        };
        let growth = |pixel: usize| -> f64 {
            let own = shares.iter().zip(&gains);
            own.filter_map(|(share, gain)| Some(gain * share.error_growth(contrasts, pixel)?)).sum()
        };
        let at = |(pixel, sigma): (usize, &f32)| (f64::from(*sigma) * largest(pixel) + growth(pixel)) as f32;
        let changed = shares.iter().any(|share| new_contrast(share));
        let errors = if changed { Errors::AtMostOfSlides } else { Errors::AtMost };
        (stored.iter().enumerate().map(at).collect(), errors)
    } else {
        out.channels.retain(|channel| channel.layer() != name);
        return Errors::Unknown;
    };
    set_layer(out, name, &same(sigma));
    errors
}

/// The variance after of a sum that had the variance `before`.
fn combined(before: f64, terms: &[Terms], pixel: usize) -> f64 {
    let moments = |sigma: &dyn Fn(&Terms) -> f64| {
        let (sum, squares) = terms.iter().fold((0.0, 0.0), |(sum, squares), term| {
            let sigma = sigma(term);
            (sum + sigma, squares + sigma * sigma)
        });
        // Σ over pairs i ≠ j of σᵢσⱼ.
        (squares, (sum * sum - squares).max(0.0))
    };
    let (squares, pairs) = moments(&|term| term.before(pixel));
    let correlation = if pairs > 0.0 { ((before - squares) / pairs).clamp(-1.0, 1.0) } else { 0.0 };
    let (squares, pairs) = moments(&|term| term.after(pixel));
    not_negative(squares + correlation * pairs)
}

/// What the error of one share is made of.
struct Terms<'s, 'f> {
    share: &'s Share<'f>,
    before: &'f [f32],
    gain: f64,
    contrasts: &'s Contrasts,
}

impl<'s, 'f> Terms<'s, 'f> {
    /// None if the frame doesn't hold them.
    fn of(share: &'s Share<'f>, recipe: &Recipe, contrasts: &'s Contrasts) -> Option<Self> {
        share.variance(contrasts, 0)?;
        Some(Terms { share, before: share.error?, gain: recipe.gain(&share.group), contrasts })
    }

    fn before(&self, pixel: usize) -> f64 {
        self.before.get(pixel).map_or(0.0, |sigma| f64::from(*sigma))
    }

    fn after(&self, pixel: usize) -> f64 {
        if !self.share.follows(self.contrasts) {
            return self.gain * self.before(pixel);
        }
        self.gain * self.share.variance(self.contrasts, pixel).map_or(self.before(pixel), f64::sqrt)
    }
}

fn same(data: Vec<f32>) -> [Vec<f32>; 3] {
    [data.clone(), data.clone(), data]
}
