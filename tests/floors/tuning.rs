//! The chosen numbers of the estimators and of the planner are in their room's `tuning.rs`, each with what it was chosen by.

use std::path::Path;
use syn::{Expr, Item, Type};

/// Not chosen: keys of random numbers and what mathematics gives.
const GIVEN: [&str; 4] = ["SEED", "GOLDEN", "Z_OF_98", "NONE"];

fn is_number(kind: &Type) -> bool {
    match kind {
        Type::Path(path) => path.path.segments.last().is_some_and(|last| {
            ["f64", "f32", "u64", "u32", "u16", "u8", "usize", "i64", "i32"].iter().any(|name| last.ident == name)
        }),
        Type::Tuple(tuple) => !tuple.elems.is_empty() && tuple.elems.iter().all(is_number),
        _ => false,
    }
}

/// Constants of a file that somebody chose, by name. Tables and what follows from other constants are not choices.
fn chosen(text: &str) -> Vec<String> {
    let file = syn::parse_file(text).expect("our sources parse");
    let constants = file.items.into_iter().filter_map(|item| match item {
        Item::Const(constant) => Some(constant),
        _ => None,
    });
    let by_hand = constants.filter(|c| is_number(&c.ty) && !matches!(&*c.expr, Expr::Path(_)));
    by_hand.map(|c| c.ident.to_string()).filter(|name| !GIVEN.contains(&name.as_str())).collect()
}

#[test]
fn chosen_numbers_are_in_their_rooms_tuning() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    for floor in ["estimate", "plan"] {
        super::sources(&src.join(floor), &mut files);
    }
    let mut elsewhere = Vec::new();
    for file in files {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if name != "tuning.rs" && !name.contains("test") {
            let text = std::fs::read_to_string(&file).expect("readable");
            elsewhere.extend(chosen(&text).into_iter().map(|number| format!("{}: {number}", file.display())));
        }
    }
    assert!(elsewhere.is_empty(), "belongs into tuning.rs beside it: {elsewhere:#?}");
}

#[test]
fn the_test_finds_a_planted_number() {
    let text = "const A: f64 = 2.0; const SEED: u64 = 1; pub const B: (f64, f64) = (1.0, 2.0); const C: Kind = Kind::D; fn f() { const E: u8 = 1; }";
    assert_eq!(chosen(text), ["A", "B"]);
}
