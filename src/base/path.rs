//! Event strings of light paths and the automaton that classifies them (`design/layers.md`).
//!
//! Read from the eye: `E` eye, `S` specular (delta) reflection or transmission, `G` a narrow lobe, `D` a broad lobe,
//! `L` a lamp. Every estimator uses this automaton, so a path has one class whoever computes it.

/// What happened at a vertex between the eye and the lamp. The declared finish decides, never a sampled width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Event {
    /// Exactly delta: a polished face, a mirror, a slide.
    Specular,
    /// Scattering in a lobe too narrow to gather photons at; for the layers it counts as scattering.
    Glossy,
    /// Scattering in a broad lobe.
    Diffuse,
}

/// The layer class of a complete path. Disjoint and complete over all event strings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// `E S* L`: direct vision of a source.
    Vision,
    /// `E S* D L`: a scatterer lit directly.
    Primary,
    /// `E S* D S+ L`
    Caustic,
    /// `E S* D … D … L`
    Secondary,
}

impl Class {
    pub const ALL: [Class; 4] = [Class::Vision, Class::Primary, Class::Caustic, Class::Secondary];
    pub fn name(self) -> &'static str {
        match self {
            Class::Vision => "vision",
            Class::Primary => "primary",
            Class::Caustic => "caustic",
            Class::Secondary => "secondary",
        }
    }
}

/// State of the automaton. It can be fed from the eye ([`Trail::START`]) or from the lamp, and an eye-side and a
/// lamp-side piece can be [joined](Trail::join); the class is the same either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Trail {
    /// Scattering vertices so far, saturating at 2.
    scatters: u8,
    /// Specular events since the last scattering vertex (or the end the trail started from), saturating at 1.
    specular_after: u8,
    /// Specular events before the first scattering vertex, saturating at 1.
    specular_before: u8,
    /// A broad lobe was among the scattering vertices.
    broad: bool,
}

impl Trail {
    /// The empty trail, at the eye or at the lamp.
    pub const START: Trail = Trail { scatters: 0, specular_after: 0, specular_before: 0, broad: false };

    /// The trail after one more event.
    #[must_use]
    pub fn then(self, event: Event) -> Trail {
        match event {
            Event::Specular if self.scatters == 0 => Trail { specular_before: 1, specular_after: 1, ..self },
            Event::Specular => Trail { specular_after: 1, ..self },
            Event::Glossy => Trail { scatters: (self.scatters + 1).min(2), specular_after: 0, ..self },
            Event::Diffuse => Trail { scatters: (self.scatters + 1).min(2), specular_after: 0, broad: true, ..self },
        }
    }

    /// The class of the complete path when this trail was walked from the eye and has met a lamp.
    pub fn class_from_eye(self) -> Class {
        match (self.scatters, self.specular_after) {
            (0, _) => Class::Vision,
            (1, 0) => Class::Primary,
            (1, _) => Class::Caustic,
            (_, _) => Class::Secondary,
        }
    }

    /// The class of the complete path when this trail was walked from the lamp and has met the eye.
    pub fn class_from_lamp(self) -> Class {
        match (self.scatters, self.specular_before) {
            (0, _) => Class::Vision,
            (1, 0) => Class::Primary,
            (1, _) => Class::Caustic,
            (_, _) => Class::Secondary,
        }
    }

    /// The trail (as seen from the eye) of an eye-side piece and a lamp-side piece that meet at a vertex where
    /// `event` happens; neither piece contains that vertex.
    #[must_use]
    pub fn join(eye: Trail, event: Event, lamp: Trail) -> Trail {
        let middle = eye.then(event);
        if lamp.scatters == 0 {
            return if lamp.specular_after > 0 { middle.then(Event::Specular) } else { middle };
        }
        Trail {
            scatters: (middle.scatters + lamp.scatters).min(2),
            specular_before: if middle.scatters == 0 {
                middle.specular_before | lamp.specular_after
            } else {
                middle.specular_before
            },
            // From the eye the lamp-side piece ends with what it had before its first scattering vertex.
            specular_after: lamp.specular_before,
            broad: middle.broad || lamp.broad,
        }
    }

    /// A number for this state, below the number of [`Trail::states`].
    pub fn state(self) -> usize {
        ((self.scatters as usize * 2 + self.specular_after as usize) * 2 + self.specular_before as usize) * 2
            + usize::from(self.broad)
    }

    /// Every state of the automaton, in the order of [`Trail::state`] (some can't be reached).
    pub fn states() -> impl Iterator<Item = Trail> {
        (0..24u8).map(|code| Trail {
            scatters: code / 8,
            specular_after: code / 4 % 2,
            specular_before: code / 2 % 2,
            broad: code % 2 == 1,
        })
    }

    /// Whether a broad scattering vertex is on the trail: the photon map can own the path.
    pub fn has_broad(self) -> bool {
        self.broad
    }
    /// Whether any scattering vertex, broad or narrow, is on the trail.
    pub fn has_scatter(self) -> bool {
        self.scatters > 0
    }
    /// Whether nothing at all has happened yet.
    pub fn is_empty(self) -> bool {
        self == Trail::START
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition of the classes as regular expressions over `S`, `G`, `D` between eye and lamp.
    fn expressions() -> [(Class, regex::Regex); 4] {
        let expression = |text: &str| regex::Regex::new(text).expect("a sound expression");
        [
            (Class::Vision, expression("^S*$")),
            (Class::Primary, expression("^S*[GD]$")),
            (Class::Caustic, expression("^S*[GD]S+$")),
            (Class::Secondary, expression("^S*[GD].*[GD].*$")),
        ]
    }

    fn letters(string: &[Event]) -> String {
        let letter = |event: &Event| match event {
            Event::Specular => 'S',
            Event::Glossy => 'G',
            Event::Diffuse => 'D',
        };
        string.iter().map(letter).collect()
    }

    fn strings(length: usize) -> impl Iterator<Item = Vec<Event>> {
        const LETTERS: [Event; 3] = [Event::Specular, Event::Glossy, Event::Diffuse];
        (0..3usize.pow(length as u32)).map(move |mut code| {
            (0..length)
                .map(|_| {
                    let letter = LETTERS[code % 3];
                    code /= 3;
                    letter
                })
                .collect()
        })
    }

    /// Every string up to 12 events has exactly one class, the same from both ends, joined anywhere or not.
    #[test]
    fn every_string_has_one_class_from_either_end() {
        let expressions = expressions();
        for length in 0..=12 {
            for string in strings(length) {
                let text = letters(&string);
                let matching: Vec<Class> =
                    expressions.iter().filter(|(_, e)| e.is_match(&text)).map(|(class, _)| *class).collect();
                let [want] = matching[..] else { panic!("{text} is in {matching:?}") };
                let eye = string.iter().fold(Trail::START, |t, &e| t.then(e));
                let lamp = string.iter().rev().fold(Trail::START, |t, &e| t.then(e));
                assert_eq!(eye.class_from_eye(), want, "{text}");
                assert_eq!(lamp.class_from_lamp(), want, "{text}");
                for cut in 0..length.min(9) {
                    let head = string[..cut].iter().fold(Trail::START, |t, &e| t.then(e));
                    let tail = string[cut + 1..].iter().rev().fold(Trail::START, |t, &e| t.then(e));
                    let joined = Trail::join(head, string[cut], tail);
                    assert_eq!(joined.class_from_eye(), want, "{text} cut at {cut}");
                    assert_eq!(joined.has_broad(), text.contains('D'), "{text}");
                }
            }
        }
    }
}
