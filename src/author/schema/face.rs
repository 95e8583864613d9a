//! Which attributes stand together.

use eyebox_scene::attribute::{self, MEDIUM, Noun, Row};

/// The attributes of a face, by the nouns that have a row of their own name.
pub const FACE: [Noun; 6] = [Noun::Finish, Noun::Coating, Noun::Shape, Noun::Emitter, Noun::Slide, Noun::Sensor];

/// The row that holds a whole noun, or none.
pub fn holder(noun: Noun) -> Option<&'static Row> {
    attribute::row(noun, &noun.to_string())
}

/// The attributes of a medium as they stand on a node, and the medium as a whole.
pub fn medium() -> impl Iterator<Item = &'static Row> {
    let bare = MEDIUM.iter().filter(|name| **name != "name");
    holder(Noun::Medium).into_iter().chain(bare.filter_map(|name| attribute::row(Noun::Medium, name)))
}

/// The rows of all faces' attributes.
pub fn faces() -> impl Iterator<Item = &'static Row> {
    FACE.into_iter().filter_map(holder)
}

/// The list of the asset's root that holds the things of a noun.
pub fn list(noun: Noun) -> Option<&'static str> {
    match noun {
        Noun::Medium => Some("media"),
        Noun::Coating => Some("coatings"),
        Noun::Emitter => Some("emitters"),
        Noun::Slide => Some("slides"),
        Noun::Finish | Noun::Shape | Noun::Sensor | Noun::Sky | Noun::Sun | Noun::Eye | Noun::Asset => None,
    }
}
