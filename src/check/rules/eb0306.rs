//! A lamp face loses what its profile sends backwards.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0306",
    name: "profile-behind-face",
    level: Level::Warning,
    title: "A lamp face loses what its profile sends backwards",
    why: "A face emits to its front. A profile that was measured of a bulb sends light backwards, too, and that part is gone.",
    bad: Example::Words("The profile of a bare bulb on the face of a die."),
    good: Example::Words("The profile of the die, or a light that is no face."),
    find: nothing,
    grade: kept,
};
