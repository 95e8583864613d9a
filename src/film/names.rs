//! Every layer that a picture can have, by name, and what it is: the one list that `--layers`, layers by light path expression
//! and the check of light groups' names go by.

use super::aov::{CHANGE_ERROR, OF_SERIES};
use super::cryptomatte::Matte;
use super::layer::Layer;
use std::collections::{BTreeMap, BTreeSet};

/// Metadata: the relative error that a run states of its picture.
pub const STATED_ERROR: &str = "statedError";

/// What a share comes with beside its own picture, and what that is.
const OF_SHARE: [(&str, &str); 12] = [
    ("_open", "with the slide open"),
    ("_content", "of the slide's content"),
    ("_cross", "of light that crosses the slide twice"),
    ("_cross2", "of light that crosses the slide three times"),
    ("_cross3", "of light that crosses the slide four times"),
    ("_stderr", "as a standard error"),
    ("_open_stderr", "with the slide open, as a standard error"),
    ("_content_stderr", "of the slide's content, as a standard error"),
    ("_variance", "as a variance"),
    ("_open_variance", "with the slide open, as a variance"),
    ("_content_variance", "of the slide's content, as a variance"),
    ("_covariance", "as the covariance of its parts"),
];
/// The first so many come for each of several slides, too.
const SPLIT: usize = 5;
/// Layers that hold data of their own.
const DATA: [&str; 9] = ["Z", "normal", "position", "albedo", "id", "normal_geometric", "uv", "opacity", "motion"];

/// Layers that tell errors of others. Where passes are too few to tell them, they are NaN: unknown is not zero.
pub fn is_error(layer: &str) -> bool {
    layer == "stderr" || ["_stderr", "_variance", "_covariance"].iter().any(|suffix| layer.ends_with(suffix))
}

/// Whether a layer may hold a value: a finite one, or one that is unknown where it tells errors.
pub fn may_hold(layer: &str, value: f32) -> bool {
    value.is_finite() || value.is_nan() && is_error(layer)
}

/// Two things that would be written under one name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clash {
    pub layer: String,
    pub causes: [String; 2],
}

/// The layers that a picture with these light groups may have, and these slides if there are several.
pub fn possible<'g>(groups: impl Iterator<Item = &'g str> + Clone, slides: &[String]) -> BTreeSet<String> {
    of_groups(groups, slides).0.into_keys().collect()
}

/// A name that two of them have.
pub fn clash<'g>(groups: impl Iterator<Item = &'g str> + Clone, slides: &[String]) -> Option<Clash> {
    of_groups(groups, slides).1
}

/// All of them, each with what it is, and the first name that two have.
fn of_groups<'g>(
    groups: impl Iterator<Item = &'g str> + Clone,
    slides: &[String],
) -> (BTreeMap<String, String>, Option<Clash>) {
    let mut all = BTreeMap::<String, String>::new();
    let mut clash = None;
    let mut add = |layer: String, cause: String| {
        if let Some(other) = all.insert(layer.clone(), cause.clone())
            && clash.is_none()
        {
            clash = Some(Clash { layer, causes: [other, cause] });
        }
    };
    add("hybrid".to_owned(), "the picture".to_owned());
    add("stderr".to_owned(), "the picture's standard error".to_owned());
    add("hybrid_variance".to_owned(), "the picture's variance".to_owned());
    add("seethrough".to_owned(), "what shows the surroundings".to_owned());
    add("alpha".to_owned(), "what hides the surroundings".to_owned());
    add("work".to_owned(), "where the work went".to_owned());
    for data in DATA {
        add(data.to_owned(), "data of what is seen first".to_owned());
        add(format!("{data}_seen"), "data of what is seen over specular faces".to_owned());
    }
    for matte in Matte::ALL {
        add(matte.name().to_owned(), "a matte".to_owned());
    }
    for layer in Layer::SUM_ORDER.map(Layer::name) {
        add(layer.to_owned(), format!("the layer `{layer}`"));
        add(format!("{layer}_stderr"), format!("the standard error of the layer `{layer}`"));
        add(format!("{layer}_variance"), format!("the variance of the layer `{layer}`"));
        for group in groups.clone() {
            let share = format!("{layer}_{group}");
            add(share.clone(), format!("the light of group `{group}`"));
            for (suffix, what) in OF_SHARE {
                add(format!("{share}{suffix}"), format!("the light of group `{group}`, {what}"));
            }
            for slide in slides {
                for (suffix, what) in &OF_SHARE[..SPLIT] {
                    let cause = format!("the light of group `{group}` through `{slide}`, {what}");
                    add(format!("{share}_{slide}{suffix}"), cause);
                }
            }
            for slide in slides {
                for error in [CHANGE_ERROR, "_change_variance"] {
                    let cause = format!("the error of the light of group `{group}` through `{slide}`");
                    add(format!("{share}_{slide}{error}"), cause);
                }
            }
            for (k, one) in slides.iter().enumerate() {
                for other in &slides[k + 1..] {
                    let cause = format!("the light of group `{group}` through `{one}` and `{other}`");
                    for suffix in OF_SERIES {
                        add(format!("{share}_{one}_{other}{suffix}"), cause.clone());
                    }
                }
            }
        }
    }
    (all, clash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_are_called_like_what_comes_with_others() {
        for (groups, layer) in [
            (&["led", "stderr"][..], "direct_stderr"),
            (&["variance"], "direct_variance"),
            (&["led", "led_open"], "direct_led_open"),
            (&["sky_content", "led", "sky"], "direct_sky_content"),
            (&["a", "a_open_stderr"], "direct_a_open_stderr"),
            (&["a_open", "a"], "direct_a_open"),
        ] {
            let found = clash(groups.iter().copied(), &[]).unwrap_or_else(|| panic!("{groups:?} clash"));
            assert_eq!(found.layer, layer, "{groups:?}");
            assert_ne!(found.causes[0], found.causes[1], "{groups:?}");
        }
        for sound in [&["led", "sky"][..], &["open"], &["led_opened", "led"], &["LED_open", "led"], &["direct"]] {
            assert_eq!(clash(sound.iter().copied(), &[]), None, "{sound:?}");
        }
    }
}
