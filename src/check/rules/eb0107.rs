//! The exact shape does not lie on its mesh.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0107",
    name: "shape-off-mesh",
    level: Level::Error,
    title: "The exact shape does not lie on its mesh",
    why: "The shape says where light is bent, the mesh where the surface ends. If they are not the same surface, one of them is that of another part, or another unit.",
    bad: Example::Code(
        "toml",
        r#"shape = { kind = "sphere", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 6 }   # of a mesh with radius 60"#,
    ),
    good: Example::Code("toml", r#"shape = { kind = "fit", tolerance_um = 0.05 }"#),
    find: nothing,
    grade: kept,
};
