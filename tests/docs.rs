//! The documentation against the code: the attribute reference is generated, links lead somewhere, every dependency and
//! every layer has its line. `EYEBOX_BLESS=1 cargo verify --test all docs` rewrites what is generated.

use eyebox::film::layer::Layer;
use eyebox::scene::attribute::{Form, Kind, Noun, Range, Row, Support, kinds, named, rows};
use eyebox::scene::attribute::{KINDS, ROWS};
use eyebox::validate::{page, rules};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const NOUNS: [Noun; 11] = [
    Noun::Asset,
    Noun::Medium,
    Noun::Finish,
    Noun::Coating,
    Noun::Shape,
    Noun::Emitter,
    Noun::Slide,
    Noun::Sensor,
    Noun::Sky,
    Noun::Sun,
    Noun::Eye,
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Where the attributes of a noun are written in a sidecar.
fn place(noun: Noun) -> &'static str {
    match noun {
        Noun::Asset => "At the top of the sidecar.",
        Noun::Medium => {
            "The inside of a closed solid. In a `[[bind]]`, or in a `[medium.NAME]` that `medium = \"NAME\"` refers to."
        }
        Noun::Finish => {
            "What a face does with light. `finish = \"KIND\"`, or `finish = { kind = \"KIND\", PARAMETER = … }`."
        }
        Noun::Coating => "Thin films on a polished face. `[coating.NAME]`, then `coating = \"NAME\"` in a `[[bind]]`.",
        Noun::Shape => "The exact surface of a face. `shape = { kind = \"KIND\", … }`. The mesh says where it ends.",
        Noun::Emitter => "A face that emits. `emitter = { group = \"led\", flux_lm = 0.45 }` in a `[[bind]]`.",
        Noun::Slide => {
            "A thin transmissive picture on a face. `slide = { image = …, size = …, u = …, v = … }` in a `[[bind]]`."
        }
        Noun::Sensor => {
            "A map of the light that arrives at a face. `sensor = { pixels = [64, 32] }` in a `[[bind]]`; `eyebox sensor` measures it."
        }
        Noun::Sky => {
            "Light from everywhere. `[sky]`, with exactly one of `image`, `luminance_cd_m2`, `overcast_cd_m2` and `sun_sky`."
        }
        Noun::Sun => "Light from one direction: the sun through the combiner. `[sun]`.",
        Noun::Eye => "Who looks. `[eye]`.",
    }
}

/// Text in a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;").replace('*', "\\*")
}

/// What a value of this row looks like: form, range and unit.
fn value(row: &Row) -> String {
    let range = match row.range {
        Range::Any => String::new(),
        Range::AtLeast(_)
        | Range::AtLeastOrInfinite(_)
        | Range::Positive
        | Range::PositiveOrInfinite
        | Range::NonZero
        | Range::Within(..)
        | Range::Above(..)
        | Range::Between(..) => format!(", {}", row.range).replacen(", a number ", ", ", 1),
    };
    let form = match row.form {
        Form::Number => "number".to_owned(),
        Form::Integer => "whole number".to_owned(),
        Form::Text => "text".to_owned(),
        Form::File => "file name".to_owned(),
        Form::Length => "length with unit".to_owned(),
        Form::Numbers(count) => format!("{count} numbers"),
        Form::LengthOr(words) => format!("length with unit, or {}", words.join(", ")),
        Form::Place => "3 lengths with units".to_owned(),
        Form::Word(words) => words.join(", ").replacen(", ", " or ", usize::from(words.len() == 2)),
        Form::Integers(count) => format!("{count} whole numbers"),
        Form::Coefficients { least, most } => format!("{least} to {most} numbers"),
        Form::Rows(columns) => format!("rows of {}", columns.join(", ")),
        Form::NumberOrRows(columns) => format!("number, or rows of {}", columns.join(", ")),
        Form::Record(fields) => format!("table of {}", fields.join(", ")),
        Form::Records(fields) => format!("list of tables of {}", fields.join(", ")),
        Form::Thing(fields) => format!("name, or table of {}", fields.join(", ")),
        Form::Kind if named(row.noun) && row.name == row.noun.to_string() => "name, or kind, see below".to_owned(),
        Form::Kind => "kind, see below".to_owned(),
    };
    let unit = if row.unit.is_empty() { String::new() } else { format!(", {}", row.unit) };
    cell(&format!("{form}{unit}{range}"))
}

fn state(support: Support) -> &'static str {
    match support {
        Support::Rendered => "",
        Support::Kept => " (kept and reported; changes no picture yet)",
        Support::NotYet => " (not rendered yet: using it is an error)",
    }
}

fn kind_line(kind: &Kind) -> String {
    let parameters: Vec<String> = kind.parameters.iter().map(|name| format!("`{name}`")).collect();
    let state = if kind.rendered { "" } else { " (not rendered yet: using it is an error)" };
    format!("| `{}` | {} | {}{state} |\n", kind.name, parameters.join(", "), cell(kind.doc))
}

/// The whole of `docs/attributes.md`.
fn attributes() -> String {
    let mut out = "# Optical attributes\n\n\
        This page is generated from `src/scene/attribute/rows.rs` by `tests/docs.rs`. Do not edit it; run\n\
        `EYEBOX_BLESS=1 cargo verify --test all docs` after changing a row.\n\n\
        How to write them down is in [sidecar.md](sidecar.md). A value out of range, an unknown name or a misspelt one is\n\
        an error. *Mesh units* are the part's own units: they scale with the node and with `unit`. A length with a unit\n\
        (`\"4 mm\"`) never scales. An empty default means that the value must be said, or that nothing holds without it.\n\
        The laws of what scatters, with their normalisation, are in [scattering.md](scattering.md).\n"
        .to_owned();
    for noun in NOUNS {
        out += &format!(
            "\n## {noun}\n\n{}\n\n| attribute | value | default | meaning |\n|---|---|---|---|\n",
            place(noun)
        );
        for row in rows(noun) {
            let default = cell(row.default.unwrap_or(""));
            let doc = cell(row.doc);
            out += &format!("| `{}` | {} | {default} | {doc}{} |\n", row.name, value(row), state(row.support));
        }
        for row in rows(noun).filter(|row| row.form == Form::Kind) {
            out += &format!("\nKinds of `{}`:\n\n| kind | parameters | meaning |\n|---|---|---|\n", row.name);
            kinds(row.name).for_each(|kind| out += &kind_line(kind));
        }
    }
    out
}

#[test]
fn the_attribute_reference_is_up_to_date() {
    let (path, fresh) = (root().join("docs/attributes.md"), attributes());
    if blessing() {
        fs::write(&path, &fresh).expect("docs/attributes.md can be written");
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    // The first line that differs says more than two whole pages.
    let line = stored.lines().zip(fresh.lines()).position(|(a, b)| a != b).map_or(stored.lines().count(), |line| line);
    assert!(
        stored == fresh,
        "docs/attributes.md is stale from line {}; EYEBOX_BLESS=1 cargo verify --test all docs rewrites it",
        line + 1
    );
}

fn blessing() -> bool {
    std::env::var_os("EYEBOX_BLESS").is_some_and(|value| value == "1")
}

/// Each rule has its page, and no page is without a rule; the table of all rules stands in `docs/validate.md`.
#[test]
fn the_pages_of_the_rules_are_up_to_date() {
    let mut stale = Vec::new();
    let mut expect = |path: PathBuf, fresh: &str| {
        if blessing() {
            fs::write(&path, fresh).expect("docs can be written");
        }
        if fs::read_to_string(&path).unwrap_or_default() != fresh {
            stale.push(path.display().to_string());
        }
    };
    for rule in rules::all() {
        expect(root().join(format!("docs/rules/{}.md", rule.code)), &page::page(rule));
    }
    let index = read("docs/validate.md");
    let (before, rest) = index.split_once("<!-- rules -->\n").expect("the table's begin");
    let (_, after) = rest.split_once("<!-- /rules -->").expect("the table's end");
    let table = page::table("rules/");
    expect(root().join("docs/validate.md"), &format!("{before}<!-- rules -->\n\n{table}\n<!-- /rules -->{after}"));
    let pages = fs::read_dir(root().join("docs/rules")).expect("docs/rules is readable");
    let names = pages.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned());
    let orphans: Vec<String> =
        names.filter(|name| name.strip_suffix(".md").is_none_or(|code| rules::find(code).is_none())).collect();
    assert!(orphans.is_empty(), "pages without a rule: {orphans:?}");
    assert!(stale.is_empty(), "stale; EYEBOX_BLESS=1 cargo verify --test all docs rewrites {stale:?}");
}

#[test]
fn the_attribute_reference_holds_every_row_and_kind() {
    let text = attributes();
    for row in ROWS {
        assert!(NOUNS.contains(&row.noun), "{} has no section", row.noun);
    }
    let lines = |start: &str| text.lines().filter(|line| line.starts_with(start)).count();
    let headers = lines("| attribute") + lines("| kind ");
    assert_eq!(lines("| `"), ROWS.len() + KINDS.len(), "rows of the tables");
    assert_eq!(headers, NOUNS.len() + ROWS.iter().filter(|row| row.form == Form::Kind).count());
}

#[test]
fn every_layer_has_its_section() {
    let text = read("docs/layers.md");
    for layer in Layer::SUM_ORDER {
        assert!(text.contains(&format!("\n## `{}`\n", layer.name())), "{} is not in docs/layers.md", layer.name());
    }
}

#[test]
fn every_dependency_has_its_reason() {
    let manifest: toml::Table = read("Cargo.toml").parse().expect("Cargo.toml is TOML");
    // Floors take what they need from there.
    let all = manifest["workspace"]["dependencies"].as_table().expect("a table");
    let named: BTreeSet<String> = all.keys().filter(|name| !name.starts_with("eyebox")).cloned().collect();
    let text = read("docs/dependencies.md");
    let (text, _) = text.split_once("## Looked at and not taken").expect("the section on what was not taken");
    let told: BTreeSet<String> =
        text.lines().filter_map(|line| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned())).collect();
    assert_eq!(named, told, "Cargo.toml on the left, docs/dependencies.md on the right");
}

/// The targets of the links and pictures in a Markdown text.
fn links(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0)).collect()
}

/// What stands in backticks and looks like a path of this repository.
fn paths(text: &str) -> Vec<&str> {
    const TOP: [&str; 7] = ["src/", "tests/", "docs/", "benches/", "samples/", ".ci/", ".cargo/"];
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|code| TOP.iter().any(|top| code.starts_with(top)) && !code.contains(['<', '*', ' '])).collect()
}

/// The Markdown files of a folder.
fn pages_of(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).expect("the folder is readable");
    let files = entries.map(|entry| entry.expect("the folder is readable").path());
    files.filter(|file| file.extension().is_some_and(|extension| extension == "md")).collect()
}

/// The anchor that GitHub and mdBook give to a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// The anchors of all headings of a Markdown text.
fn anchors(text: &str) -> BTreeSet<String> {
    text.lines().filter(|line| line.starts_with('#')).map(|line| anchor(line.trim_start_matches('#'))).collect()
}

#[test]
fn links_and_paths_lead_somewhere() {
    let mut pages = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    pages.extend(pages_of("docs"));
    pages.extend(pages_of("benches"));
    assert!(pages.len() >= 4, "the documentation moved");
    let mut dead = Vec::new();
    for page in &pages {
        let text = fs::read_to_string(page).expect("readable");
        let beside = page.parent().unwrap_or(Path::new("."));
        for link in links(&text).into_iter().filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let path = if file.is_empty() { page.clone() } else { beside.join(file) };
            let headings = || anchors(&fs::read_to_string(&path).unwrap_or_default());
            if !path.exists() || !(heading.is_empty() || headings().contains(heading)) {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
        let named = paths(&text).into_iter().filter(|path| !root().join(path).exists());
        dead.extend(named.map(|path| format!("{}: {path}", page.display())));
    }
    assert!(dead.is_empty(), "dead links or paths:\n{}", dead.join("\n"));
}

/// The site has no page that is not in its table of contents, `docs/SUMMARY.md`; those of the rules stand below `validate.md`.
#[test]
fn every_page_is_in_the_site() {
    const ABOVE: &str = "- [Checking assets](validate.md)\n";
    let mut of_rules = String::new();
    for rule in rules::all() {
        let page = page::page(rule);
        let heading = page.lines().next().unwrap_or_default().trim_start_matches("# ");
        of_rules += &format!("  - [{heading}](rules/{}.md)\n", rule.code);
    }
    let stored = read("docs/SUMMARY.md");
    let others: String = stored.split_inclusive('\n').filter(|line| !line.starts_with("  - [EB")).collect();
    let (before, after) = others.split_once(ABOVE).expect("the line of validate.md");
    let fresh = format!("{before}{ABOVE}{of_rules}{after}");
    if blessing() {
        fs::write(root().join("docs/SUMMARY.md"), &fresh).expect("docs can be written");
    }
    assert!(
        stored == fresh || blessing(),
        "docs/SUMMARY.md is stale; EYEBOX_BLESS=1 cargo verify --test all docs rewrites it"
    );
    let names = pages_of("docs").into_iter().filter_map(|page| Some(page.file_name()?.to_string_lossy().into_owned()));
    let missing: Vec<String> =
        names.filter(|name| name != "SUMMARY.md" && !fresh.contains(&format!("]({name})"))).collect();
    assert!(missing.is_empty(), "not in docs/SUMMARY.md: {missing:?}");
}

/// A page is for one task. The reference of all attributes is generated, and as long as it has to be.
#[test]
fn pages_are_short() {
    let long = |page: &PathBuf| fs::read_to_string(page).expect("readable").lines().count() > 200;
    let long: Vec<PathBuf> =
        pages_of("docs").into_iter().filter(|page| !page.ends_with("attributes.md") && long(page)).collect();
    assert!(long.is_empty(), "more than 200 lines: {long:?}");
}

#[test]
fn the_link_test_finds_links_and_paths() {
    assert_eq!(links("see [a](b.md) and ![c](d/e.png)"), ["b.md", "d/e.png"]);
    assert_eq!(anchor(" Find a level: `--solve`"), "find-a-level---solve");
    assert_eq!(anchor(" Caustics: `E S* D S+ L`"), "caustics-e-s-d-s-l");
    assert_eq!(paths("`src/x.rs` and `cargo verify`, `tests/<name>.rs`, `docs/a.md`"), ["src/x.rs", "docs/a.md"]);
}
