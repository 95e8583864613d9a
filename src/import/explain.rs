//! Which line won, for `inspect --explain PART`.

use super::binding_slots::{Entry, PartBound, Rank, Slots};
use super::select::{Candidate, is_glob, listed};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};

/// For every part what was bound to it, in part order.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Explained {
    pub parts: Vec<ExplainedPart>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ExplainedPart {
    pub name: String,
    pub path: String,
    pub rows: Vec<Explanation>,
}

/// One attribute of a part or of one of its faces.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Explanation {
    /// None for what belongs to the whole part.
    pub face: Option<usize>,
    pub attribute: String,
    pub value: String,
    pub rank: Rank,
    pub at: Where,
    pub beaten: Vec<Beaten>,
}

/// A value that did not hold, the strongest first.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Beaten {
    pub attribute: String,
    pub value: String,
    pub rank: Rank,
    pub at: Where,
}

impl Explained {
    pub(super) fn new(parts: &[Candidate], bound: &[PartBound]) -> Self {
        let part = |(part, bound): (&Candidate, &PartBound)| {
            let faces = bound.faces.iter().enumerate().map(|(number, face)| (Some(number), face));
            let rows = std::iter::once((None, &bound.part)).chain(faces).flat_map(|(face, slots)| rows(face, slots));
            ExplainedPart { name: part.name.clone(), path: part.path.clone(), rows: rows.collect() }
        };
        Explained { parts: parts.iter().zip(bound).map(part).collect() }
    }

    /// The parts called `name` or with that path (patterns too). Faults: none is, with the nearest name.
    pub fn find(&self, name: &str) -> Result<Vec<&ExplainedPart>> {
        let is = |text: &str| if is_glob(name) { super::select::glob(name, text) } else { text == name };
        let ends = |path: &str| path.split_once('/').is_some_and(|(_, rest)| is(rest));
        let found: Vec<_> =
            self.parts.iter().filter(|part| is(&part.path) || is(&part.name) || ends(&part.path)).collect();
        if !found.is_empty() {
            return Ok(found);
        }
        let names = || self.parts.iter().map(|part| part.name.as_str());
        Err(Error::new(Where::Nowhere, format!("there is no part `{name}`"))
            .expected(format!("one of {}", listed(names())))
            .nearest(name, names()))
    }
}

impl ExplainedPart {
    /// For people: every attribute with the line that won and those that lost; faces that say the same on one line.
    pub fn text(&self) -> String {
        let mut faces: Vec<Option<usize>> = self.rows.iter().map(|row| row.face).collect();
        faces.dedup();
        let mut blocks: Vec<(Vec<usize>, String)> = Vec::new();
        let mut out = format!("{}\n", printable(&self.path));
        for face in faces {
            let lines: String = self.rows.iter().filter(|row| row.face == face).map(Explanation::text).collect();
            match (face, blocks.iter_mut().find(|(_, other)| *other == lines)) {
                (None, _) => out += &lines,
                (Some(face), Some((same, _))) => same.push(face),
                (Some(face), None) => blocks.push((vec![face], lines)),
            }
        }
        for (faces, lines) in blocks {
            let numbers: Vec<String> = faces.iter().map(usize::to_string).collect();
            let noun = if faces.len() == 1 { "face" } else { "faces" };
            out += &format!(" {noun} {}\n{lines}", numbers.join(", "));
        }
        if self.rows.is_empty() {
            out += "  nothing binds it\n";
        }
        out
    }
}

impl Explanation {
    fn text(&self) -> String {
        let line = |attribute: &str, value: &str, at: &Where, rank: Rank| {
            format!("{} = {}  {at} ({})", printable(attribute), printable(value), rank.words())
        };
        let mut out = format!("  {}\n", line(&self.attribute, &self.value, &self.at, self.rank));
        for beaten in &self.beaten {
            out += &format!("    beats {}\n", line(&beaten.attribute, &beaten.value, &beaten.at, beaten.rank));
        }
        out
    }
}

/// Names come from files: no control characters reach a terminal.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

impl Rank {
    /// Whose line it is.
    fn words(self) -> &'static str {
        match self {
            Rank::Default => "[default]",
            Rank::Mapped => "the material's own fields",
            Rank::Material => "the material's EYEBOX_optics",
            Rank::Node => "the node's EYEBOX_optics",
            Rank::Primitive => "the face's EYEBOX_optics",
            Rank::NodeFaces => "the node's EYEBOX_optics for that face",
            Rank::Glob => "[[bind]] of several parts",
            Rank::Exact => "[[bind]] of this part",
            Rank::FaceGlob => "[[bind]] of faces of several parts",
            Rank::FaceExact => "[[bind]] of faces of this part",
            Rank::Set => "--set",
        }
    }
}

fn rows(face: Option<usize>, slots: &Slots) -> Vec<Explanation> {
    let shown = |entry: &Entry| match &entry.label {
        Some(label) => format!("{} (medium `{label}`)", entry.value),
        None => entry.value.to_string(),
    };
    let all = slots.all().map(|won| {
        let mut beaten: Vec<Beaten> = won
            .beaten
            .iter()
            .map(|(entry, rank)| Beaten {
                attribute: entry.key.clone(),
                value: shown(entry),
                rank: *rank,
                at: entry.at.clone(),
            })
            .collect();
        beaten.sort_by_key(|row| std::cmp::Reverse(row.rank));
        let (attribute, value) = (won.entry.key.clone(), shown(&won.entry));
        Explanation { face, attribute, value, rank: won.rank, at: won.entry.at.clone(), beaten }
    });
    all.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ImportOptions, Set, import};
    use std::path::Path;

    #[test]
    fn the_line_that_won_is_named_with_those_it_beat() {
        let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples/hud-direct/hud.optics.toml");
        let text = std::fs::read_to_string(&file).expect("the sample is there");
        let line = |start: &str| 1 + text.lines().position(|line| line.starts_with(start)).expect("such a line");
        let sets = vec![Set::parse("LENS_01_PMMA.glass=F2").expect("a set")];
        let built = import(&file, &ImportOptions { sets, ..ImportOptions::default() }).expect("the sample imports");
        let parts = built.explained.find("LENS_01_PMMA").expect("the lens is there");
        let [lens] = parts.as_slice() else { panic!("{} parts", parts.len()) };
        let row = |face, attribute: &str| {
            lens.rows.iter().find(|row| row.face == face && row.attribute == attribute).expect("such a row")
        };
        let at = |line| Where::Line { file: file.clone(), line };
        let finish = row(Some(0), "finish");
        // The `finish` below `faces = [0, 2]`, not that of [default].
        assert_eq!((&finish.at, finish.rank), (&at(line("faces = [0, 2]") + 1), Rank::FaceGlob));
        assert_eq!(finish.beaten.iter().map(|row| &row.at).collect::<Vec<_>>(), [&at(line("finish = \"absorber\""))]);
        assert_eq!(row(Some(1), "finish").rank, Rank::Default);
        assert_eq!(row(None, "glass").at, Where::Option("--set LENS_01_PMMA.glass=F2".into()));
        let shown = lens.text();
        let expected =
            format!("  finish = \"polished\"  {} ([[bind]] of faces of several parts)\n    beats finish", finish.at);
        assert!(shown.contains(&expected) && shown.contains(" faces 0, 2\n"), "{shown}");
        assert!(
            built.explained.find("LENS_01_PMA").expect_err("no such part").nearest.as_deref() == Some("LENS_01_PMMA")
        );
    }
}
