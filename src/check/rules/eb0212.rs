//! The coefficients of a glass contradict its index.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0212",
    name: "index-contradicted",
    level: Level::Warning,
    title: "The coefficients of a glass contradict its index",
    why: "A catalogue has n_d of a glass beside the formula that gives it: if they differ by more than melts do, 5e-4, one of them is wrong.",
    bad: Example::Code("text", "NM SF11 1 785258 1.784721 25.83\nCD 3.127487 -0.06374660 -9.890957E-4 0.01363913"),
    good: Example::Code(
        "text",
        "NM SF11 1 785258 1.784721 25.83\nCD 3.127487 -0.06374660 -9.890957E-4 0.01363913 -1.588824E-3 9.646333E-5",
    ),
    find: nothing,
    grade: kept,
};
