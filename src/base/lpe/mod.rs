//! Light path expressions in OSL's syntax, and whether one takes whole classes of paths.
//!
//! Syntax and letters: Open Shading Language, "Light Path Expressions" (github.com/AcademySoftwareFoundation/
//! OpenShadingLanguage, wiki): an event is `<type scattering 'label'>`, a single letter stands for any event of that type
//! or scattering.

mod automaton;
mod parse;
mod product;

pub use automaton::{Alphabet, Verdict};
pub use product::{LpeState, MOST, Product, Takes};

use super::path::{Class, Event};

/// What emits at the end of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// An emitting face: `O`, and `L`.
    Face,
    /// A lamp without a face: `L`.
    Light,
    /// The sky: `B`, and `L`.
    Sky,
}

/// One event of a path as an expression sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Letter {
    Camera,
    ReflectSpecular,
    ReflectGlossy,
    ReflectDiffuse,
    TransmitSpecular,
    /// Through a slide or a sheet, which bend nothing.
    TransmitStraight,
    TransmitGlossy,
    TransmitDiffuse,
    /// Through a slide of a scene that has several, by its number: for expressions a straight transmission as any other.
    CrossSlide(u8),
    Source(Source),
}

/// Slides that are told apart, most.
pub const MOST_SLIDES: usize = 8;

impl Letter {
    pub const ALL: [Letter; 11 + MOST_SLIDES] = [
        Letter::Camera,
        Letter::ReflectSpecular,
        Letter::ReflectGlossy,
        Letter::ReflectDiffuse,
        Letter::TransmitSpecular,
        Letter::TransmitStraight,
        Letter::TransmitGlossy,
        Letter::TransmitDiffuse,
        Letter::CrossSlide(0),
        Letter::CrossSlide(1),
        Letter::CrossSlide(2),
        Letter::CrossSlide(3),
        Letter::CrossSlide(4),
        Letter::CrossSlide(5),
        Letter::CrossSlide(6),
        Letter::CrossSlide(7),
        Letter::Source(Source::Face),
        Letter::Source(Source::Light),
        Letter::Source(Source::Sky),
    ];

    /// As it is written in an expression.
    pub fn symbol(self) -> &'static str {
        match self {
            Letter::Camera => "C",
            Letter::ReflectSpecular => "<RS>",
            Letter::ReflectGlossy => "<RG>",
            Letter::ReflectDiffuse => "<RD>",
            Letter::TransmitSpecular => "<TS>",
            Letter::TransmitStraight | Letter::CrossSlide(_) => "<Ts>",
            Letter::TransmitGlossy => "<TG>",
            Letter::TransmitDiffuse => "<TD>",
            Letter::Source(Source::Face) => "O",
            Letter::Source(Source::Light) => "L",
            Letter::Source(Source::Sky) => "B",
        }
    }

    /// What happens at a scatterer, or at a specular face that bends.
    pub fn of(event: Event, through: bool) -> Letter {
        match (event, through) {
            (Event::Specular, false) => Letter::ReflectSpecular,
            (Event::Glossy, false) => Letter::ReflectGlossy,
            (Event::Diffuse, false) => Letter::ReflectDiffuse,
            (Event::Specular, true) => Letter::TransmitSpecular,
            (Event::Glossy, true) => Letter::TransmitGlossy,
            (Event::Diffuse, true) => Letter::TransmitDiffuse,
        }
    }

    /// Place in [`Letter::ALL`].
    fn index(self) -> usize {
        Letter::ALL.iter().position(|letter| *letter == self).unwrap_or(0)
    }

    fn bit(self) -> Set {
        1 << self.index()
    }
}

/// Letters, a bit each.
type Set = u32;
/// Every letter.
const EVERY: Set = (1 << Letter::ALL.len()) - 1;

/// An expression that has been read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lpe {
    root: parse::Node,
}

impl Lpe {
    /// Errors: what is wrong with the expression, and where.
    pub fn parse(text: &str) -> Result<Lpe, String> {
        parse::parse(text).map(|root| Lpe { root })
    }

    /// Whether it says the name of this light group; all others are alike for it.
    pub fn names(&self, group: &str) -> bool {
        self.root.names(group)
    }

    /// Takes the paths that cross slide number `only` and no other one, however often; or those that cross none.
    pub fn crossing(only: Option<u8>) -> Lpe {
        Lpe { root: parse::Node::crossing(only) }
    }

    /// Takes the paths that cross this slide once, and another one once if there is one, and no third.
    pub fn crossing_once(slide: u8, other: Option<u8>) -> Lpe {
        Lpe { root: parse::Node::crossing_once(slide, other) }
    }

    /// For each class what the expression takes of its paths from the lamps of `group`, among those that the alphabet can
    /// spell. Errors: an expression with too many cases.
    pub fn takes(&self, alphabet: &Alphabet, group: &str) -> Result<[Verdict; Class::ALL.len()], String> {
        automaton::decide(&self.root, alphabet, group)
    }
}

#[cfg(test)]
mod tests;
