//! No import circle leads from one room into another and back: each room can be read, and moved, for itself.
//!
//! A room is a folder one or two levels below a floor; the file or `mod.rs` of the same name, of a floor `lib.rs`, is its front. A room holds the
//! rooms below it, so that front and contents may name each other. Circles within one room are allowed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use syn::visit::{self, Visit};

/// A module, from the floor down.
type Module = Vec<String>;

/// Floors that are modules of the root crate.
const OF_PROGRAM: [&str; 4] = ["cmd", "prelude", "lib", "main"];

/// What one file names, as paths from the crate's root, and the modules that only tests have.
struct Names {
    here: Module,
    paths: BTreeSet<Module>,
    of_tests: BTreeSet<Module>,
}

impl Names {
    fn add(&mut self, path: &[String]) {
        let ups = path.iter().take_while(|part| *part == "super").count();
        let (from, rest) = match path.first().map(String::as_str) {
            // Each floor is a crate, but for those of the program, which sees the others as its own modules.
            Some("crate") if OF_PROGRAM.contains(&self.here[0].as_str()) => (Vec::new(), path.get(1..)),
            Some("crate") => (self.here[..1].to_vec(), path.get(1..)),
            Some(floor) if floor.starts_with("eyebox_") => {
                (vec![floor.trim_start_matches("eyebox_").to_owned()], path.get(1..))
            }
            Some("super") => (self.here[..self.here.len().saturating_sub(ups)].to_vec(), path.get(ups..)),
            Some("self") => (self.here.clone(), path.get(1..)),
            Some(_) => (self.here.clone(), Some(path)),
            None => return,
        };
        self.paths.insert([from.as_slice(), rest.unwrap_or_default()].concat());
    }

    fn tree(&mut self, tree: &syn::UseTree, before: &[String]) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.tree(&path.tree, &with(&path.ident)),
            syn::UseTree::Name(name) => self.add(&with(&name.ident)),
            syn::UseTree::Rename(name) => self.add(&with(&name.ident)),
            syn::UseTree::Glob(_) => self.add(before),
            syn::UseTree::Group(group) => group.items.iter().for_each(|item| self.tree(item, before)),
        }
    }
}

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && matches!(&attribute.meta, syn::Meta::List(list) if list.tokens.to_string().contains("test"))
    })
}

impl<'a> Visit<'a> for Names {
    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        let inner = [self.here.as_slice(), &[item.ident.to_string()]].concat();
        if is_for_tests(&item.attrs) {
            self.of_tests.insert(inner);
            return;
        }
        let outer = std::mem::replace(&mut self.here, inner);
        visit::visit_item_mod(self, item);
        self.here = outer;
    }
    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        self.tree(&item.tree, &[]);
    }
    fn visit_path(&mut self, path: &'a syn::Path) {
        let parts: Module = path.segments.iter().map(|part| part.ident.to_string()).collect();
        if parts.len() > 1 {
            self.add(&parts);
        }
        visit::visit_path(self, path);
    }
}

fn names(module: &[String], text: &str) -> Names {
    let mut names = Names { here: module.to_vec(), paths: BTreeSet::new(), of_tests: BTreeSet::new() };
    names.visit_file(&syn::parse_file(text).expect("our sources parse"));
    names
}

/// Which modules each module imports; those of tests, and what lies above or below a module, left out.
fn imports(sources: &BTreeMap<Module, String>) -> BTreeMap<Module, BTreeSet<Module>> {
    let told: Vec<(&Module, Names)> = sources.iter().map(|(module, text)| (module, names(module, text))).collect();
    let of_tests: BTreeSet<&Module> = told.iter().flat_map(|(_, names)| &names.of_tests).collect();
    let is_ours = |module: &Module| !of_tests.iter().any(|test| module.starts_with(test));
    let target = |path: &Module| (1..=path.len()).rev().map(|n| path[..n].to_vec()).find(|m| sources.contains_key(m));
    let ours = told.iter().filter(|(module, _)| is_ours(module));
    ours.map(|(module, names)| {
        let to = names.paths.iter().filter_map(target).filter(is_ours);
        ((*module).clone(), to.filter(|other| !other.starts_with(module) && !module.starts_with(other)).collect())
    })
    .collect()
}

/// All modules that a module leads to.
fn reach<'m>(from: &'m Module, imports: &'m BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<&'m Module> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(module) = open.pop() {
        open.extend(imports.get(module).into_iter().flatten().filter(|next| seen.insert(*next)));
    }
    seen
}

/// The rooms of each circle that leads through several.
fn circles(imports: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<String> {
    let is_front = |module: &Module| imports.keys().any(|m| m.len() > module.len() && m.starts_with(module));
    let room = |module: &Module| {
        let folder = if is_front(module) { module.len() } else { module.len() - 1 };
        module[..folder.min(3)].join("/")
    };
    let reached: BTreeMap<&Module, BTreeSet<&Module>> = imports.keys().map(|m| (m, reach(m, imports))).collect();
    let mut out = BTreeSet::new();
    for (module, to) in &reached {
        let back = to.iter().filter(|other| reached.get(*other).is_some_and(|to| to.contains(module)));
        let rooms: BTreeSet<String> = back.map(|other| room(other)).collect();
        if rooms.len() > 1 {
            out.insert(rooms.into_iter().collect::<Vec<_>>().join(" "));
        }
    }
    out
}

fn module_of(relative: &Path) -> Module {
    let mut parts: Module =
        relative.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|last| last == "mod") || (parts.len() == 2 && parts[1] == "lib") {
        parts.pop();
    }
    parts
}

#[test]
fn no_circle_leads_through_several_rooms() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    super::sources(&src, &mut files);
    let sources = files.iter().map(|file| {
        let text = std::fs::read_to_string(file).expect("readable");
        (module_of(file.strip_prefix(&src).expect("under src")), text)
    });
    let found = circles(&imports(&sources.collect()));
    assert!(found.is_empty(), "rooms that import each other: {found:?}");
}

#[test]
fn the_test_finds_a_planted_circle() {
    let files = |texts: &[(&str, &str)]| {
        texts.iter().map(|(path, text)| (module_of(Path::new(path)), (*text).to_owned())).collect()
    };
    let there = ("plan/a/mod.rs", "pub mod x;");
    let from = ("plan/a/x.rs", "use crate::b::{y::Y};");
    let planted = files(&[there, from, ("plan/b.rs", "mod y;"), ("plan/b/y.rs", "fn f() { super::super::a::x::g() }")]);
    assert_eq!(circles(&imports(&planted)), BTreeSet::from(["plan/a plan/b".to_owned()]));
    let only_tests = "#[cfg(test)] mod tests { use crate::a::x; }";
    let open = files(&[there, from, ("plan/b.rs", "mod y;"), ("plan/b/y.rs", only_tests)]);
    assert!(circles(&imports(&open)).is_empty());
}
