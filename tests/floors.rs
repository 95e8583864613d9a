//! The architecture as a test: a module imports only from lower floors, and siblings on one floor don't import each
//! other. Parses the sources, `use` trees and inline paths alike.

#[path = "floors/rooms.rs"]
mod rooms;
mod tuning;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

const FLOORS: [(&str, u32); 15] = [
    ("base", 0),
    ("scene", 1),
    ("film", 1),
    ("import", 2),
    ("author", 2),
    ("check", 2),
    ("output", 2),
    ("world", 3),
    ("estimate", 4),
    ("plan", 5),
    ("bench", 6),
    ("validate", 6),
    ("cmd", 7),
    ("prelude", 7),
    // The crate's own name stands for an import from outside, which the program's `main` may do.
    ("eyebox", 8),
];

fn floor(module: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == module).map(|(_, floor)| *floor)
}

/// Collects the first module after `crate::` of every path in a file.
#[derive(Default)]
struct Imports(BTreeSet<String>);

impl Imports {
    fn tree(&mut self, tree: &syn::UseTree, depth: usize) {
        match tree {
            syn::UseTree::Path(path) if depth == 0 => {
                if path.ident == "crate" {
                    self.tree(&path.tree, 1);
                }
            }
            syn::UseTree::Path(path) => drop(self.0.insert(path.ident.to_string())),
            syn::UseTree::Name(name) if depth == 1 => drop(self.0.insert(name.ident.to_string())),
            syn::UseTree::Rename(name) if depth == 1 => drop(self.0.insert(name.ident.to_string())),
            syn::UseTree::Group(group) => group.items.iter().for_each(|item| self.tree(item, depth)),
            syn::UseTree::Name(_) | syn::UseTree::Rename(_) | syn::UseTree::Glob(_) => {}
        }
    }
}

impl<'a> Visit<'a> for Imports {
    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        self.tree(&item.tree, 0);
    }
    fn visit_path(&mut self, path: &'a syn::Path) {
        let mut segments = path.segments.iter();
        if segments.next().is_some_and(|first| first.ident == "crate")
            && let Some(second) = segments.next()
        {
            self.0.insert(second.ident.to_string());
        }
        visit::visit_path(self, path);
    }
    fn visit_macro(&mut self, mac: &'a syn::Macro) {
        // Paths inside macro calls are plain tokens.
        let tokens: Vec<String> = mac.tokens.clone().into_iter().map(|token| token.to_string()).collect();
        for window in tokens.windows(4) {
            if window[0] == "crate" && window[1] == ":" && window[2] == ":" {
                self.0.insert(window[3].clone());
            }
        }
    }
}

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("src is readable") {
        let path = entry.expect("src is readable").path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// The wrong arrows of one source text that lives in `module`.
fn wrong_arrows(module: &str, text: &str) -> Vec<String> {
    let own = floor(module).unwrap_or_else(|| panic!("module `{module}` is on no floor"));
    let file = syn::parse_file(text).expect("our sources parse");
    let mut imports = Imports::default();
    imports.visit_file(&file);
    imports
        .0
        .into_iter()
        .filter(|other| other != module)
        .filter(|other| floor(other).is_none_or(|floor| floor >= own))
        .collect()
}

#[test]
fn modules_import_only_from_lower_floors() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    assert!(files.len() > 30, "the sources moved");
    let mut wrong = Vec::new();
    for file in files {
        let relative = file.strip_prefix(&src).expect("under src");
        let first = relative.components().next().expect("a file").as_os_str().to_string_lossy().into_owned();
        if first == "main.rs" || first == "lib.rs" {
            continue;
        }
        let module = first.trim_end_matches(".rs");
        let text = std::fs::read_to_string(&file).expect("readable");
        for other in wrong_arrows(module, &text) {
            wrong.push(format!("{} imports crate::{other}", relative.display()));
        }
    }
    assert!(wrong.is_empty(), "arrows that point up or sideways:\n{}", wrong.join("\n"));
}

#[test]
fn the_test_finds_planted_arrows() {
    assert_eq!(wrong_arrows("world", "use crate::{base::Error, estimate::walk};"), ["estimate"]);
    assert_eq!(wrong_arrows("scene", "fn f() { let x = crate::film::plan::Plan; }"), ["film"]);
    assert_eq!(wrong_arrows("import", "fn f() { println!(\"{}\", crate::output::X); }"), ["output"]);
    assert!(wrong_arrows("cmd", "use crate::estimate::run; use crate::base::Error;").is_empty());
}
