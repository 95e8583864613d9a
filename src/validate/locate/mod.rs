//! Places as people and their tools want them: the file, the line and column where there are lines, the byte where there
//! are none, and the name of the thing in it.

mod json; // JSON pointer → byte
mod usda; // prim → byte

use super::shown;
use eyebox_base::{Where, package};
use eyebox_scene::assembly::Assembly;
use serde::Serialize;
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Where something stands.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default, Serialize)]
pub struct Place {
    /// Relative to the working directory, with forward slashes; absolute if it is under another root.
    pub file: String,
    /// From 1; none in binary files and where only the file is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// From 1, in characters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// In a .glb, of the JSON value in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_offset: Option<usize>,
    /// A JSON pointer or the path of a prim.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub logical: Option<String>,
    /// A part of the assembly, root-relative, with its face.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
}

impl Place {
    /// As compilers write it: `file:line:column`, then what is there.
    pub fn text(&self) -> String {
        let mut out = self.file.clone();
        match (self.line, self.column) {
            (Some(line), Some(column)) => out += &format!(":{line}:{column}"),
            (Some(line), None) => out += &format!(":{line}"),
            (None, _) => {}
        }
        match (&self.part, &self.logical) {
            (Some(part), _) => out += &format!(" ({part})"),
            (None, Some(logical)) if logical.starts_with('/') => out += &format!(" ({logical})"),
            (None, Some(_) | None) => {}
        }
        out
    }
}

/// Looks places up, each file once.
pub struct Locator<'a> {
    asset: &'a Path,
    assembly: Option<&'a Assembly>,
    files: HashMap<PathBuf, Option<Text>>,
}

/// A file, and the text in it.
struct Text {
    bytes: Vec<u8>,
    /// The text: the JSON of a .glb, or everything.
    range: Range<usize>,
    is_binary: bool,
}

impl<'a> Locator<'a> {
    pub fn new(asset: &'a Path, assembly: Option<&'a Assembly>) -> Self {
        Locator { asset, assembly, files: HashMap::new() }
    }

    /// The place of `at`; `text`, which says what is wrong there, tells the column by the first name in backticks.
    pub fn place(&mut self, at: &Where, text: &str) -> Place {
        let own = |file: &Path| Place { file: shown(file), ..Place::default() };
        match at {
            Where::Nowhere => own(self.asset),
            Where::Option(option) => Place { logical: Some(option.clone()), ..own(self.asset) },
            Where::File(file) => own(file),
            Where::Line { file, line } => {
                let column = self.line(file, *line).map(|found| column_of(&found, text));
                Place { line: Some(*line), column, ..own(file) }
            }
            Where::Pointer { file, pointer } => {
                let found = self.offset(file, |bytes| json::find(bytes, pointer));
                Place { logical: Some(pointer.clone()), ..self.placed(file, found) }
            }
            Where::Prim { file, prim } => self.prim(file, prim),
            Where::Part { path, face } => {
                let named = match face {
                    Some(face) => format!("{path} face {face}"),
                    None => path.clone(),
                };
                let node = self.assembly.and_then(|assembly| assembly.nodes.iter().find(|node| node.path == *path));
                let place = match node.map(|node| node.at.clone()) {
                    Some(Where::Part { .. }) | None => own(self.assembly.map_or(self.asset, |assembly| &assembly.file)),
                    Some(at) => self.place(&at, text),
                };
                Place { part: Some(named), ..place }
            }
        }
    }

    /// A prim in the root layer, else in a layer below it, else the nearest one above it in the root layer.
    fn prim(&mut self, file: &Path, prim: &str) -> Place {
        let mut layers = vec![file.to_owned()];
        let below = self.assembly.map_or(&[][..], |assembly| &assembly.dependencies);
        let is_usd = |file: &&PathBuf| file.to_string_lossy().to_lowercase().contains(".usd");
        layers.extend(below.iter().filter(is_usd).filter(|other| other.as_path() != file).cloned());
        for layer in &layers {
            let found = self.offset(layer, |bytes| usda::find(bytes, prim));
            if found.is_some() {
                return Place { logical: Some(prim.to_owned()), ..self.placed(layer, found) };
            }
        }
        let mut above = prim;
        while let Some((outer, _)) = above.rsplit_once(['/', '.']).filter(|(outer, _)| !outer.is_empty()) {
            above = outer;
            let found = self.offset(file, |bytes| usda::find(bytes, above));
            if found.is_some() {
                return Place { logical: Some(prim.to_owned()), ..self.placed(file, found) };
            }
        }
        Place { file: shown(file), logical: Some(prim.to_owned()), ..Place::default() }
    }

    fn text(&mut self, file: &Path) -> Option<&Text> {
        let read = || {
            let bytes = package::read(file).ok()?;
            let is_glb = bytes.starts_with(b"glTF");
            let range = if is_glb { json_of_glb(&bytes)? } else { 0..bytes.len() };
            Some(Text { is_binary: is_glb || bytes.starts_with(b"PXR-USDC"), range, bytes })
        };
        self.files.entry(file.to_owned()).or_insert_with(read).as_ref()
    }

    /// Byte of the file at which something stands in its text.
    fn offset(&mut self, file: &Path, find: impl FnOnce(&[u8]) -> Option<usize>) -> Option<usize> {
        let text = self.text(file)?;
        find(text.bytes.get(text.range.clone())?).map(|offset| offset + text.range.start)
    }

    fn placed(&mut self, file: &Path, offset: Option<usize>) -> Place {
        let place = Place { file: shown(file), ..Place::default() };
        let (Some(offset), Some(text)) = (offset, self.text(file)) else { return place };
        if text.is_binary {
            return Place { byte_offset: Some(offset), ..place };
        }
        let before = text.bytes.get(..offset).unwrap_or_default();
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        let start = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let column = String::from_utf8_lossy(before.get(start..).unwrap_or_default()).chars().count() + 1;
        Place { line: Some(line), column: Some(column), ..place }
    }

    fn line(&mut self, file: &Path, line: usize) -> Option<String> {
        let text = self.text(file)?;
        let found = text.bytes.split(|byte| *byte == b'\n').nth(line.checked_sub(1)?)?;
        Some(String::from_utf8_lossy(found).into_owned())
    }
}

/// Bytes of the JSON chunk of a .glb (glTF 2.0 §4.4), as far as there are any.
fn json_of_glb(bytes: &[u8]) -> Option<Range<usize>> {
    let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?);
    let end = 20usize.checked_add(usize::try_from(length).ok()?)?;
    Some(20..end.min(bytes.len()))
}

/// Column of the first name in backticks that the line has, else of its first character.
fn column_of(line: &str, text: &str) -> usize {
    let named = text.split('`').skip(1).step_by(2).filter(|name| !name.is_empty());
    let found = named.filter_map(|name| line.find(name)).next();
    let byte = found.unwrap_or_else(|| line.len() - line.trim_start().len());
    line.get(..byte).map_or(0, |before| before.chars().count()) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_of_the_name_that_is_wrong() {
        assert_eq!(column_of("  path = \"LENZ\"", "path `LENZ` matches no part"), 11);
        assert_eq!(column_of("µµ glass = \"N-BK8\"", "unknown glass `N-BK8`"), 13);
        assert_eq!(column_of("    [[bind]]", "says nothing"), 5);
        assert_eq!(column_of("", "says nothing"), 1);
    }

    #[test]
    fn places_in_text_and_in_binary_files() {
        let folder = tempfile::tempdir().unwrap();
        let json = "{\n \"nodes\": [\n  { \"name\": \"µ\", \"mesh\": 7 }\n ]\n}";
        let file = folder.path().join("a.gltf");
        std::fs::write(&file, json).unwrap();
        let at = Where::Pointer { file: file.clone(), pointer: "/nodes/0/mesh".into() };
        let place = Locator::new(&file, None).place(&at, "");
        assert_eq!((place.line, place.column, place.byte_offset), (Some(3), Some(26), None));
        let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        glb.extend((json.len() as u32).to_le_bytes());
        glb.extend(b"JSON");
        glb.extend(json.as_bytes());
        let file = folder.path().join("a.glb");
        std::fs::write(&file, &glb).unwrap();
        let at = Where::Pointer { file: file.clone(), pointer: "/nodes/0/mesh".into() };
        let place = Locator::new(&file, None).place(&at, "");
        assert_eq!(place.line, None);
        assert_eq!(glb.get(place.byte_offset.unwrap()), Some(&b'7'));
        // Cut off anywhere: no panic.
        for end in 0..glb.len() {
            std::fs::write(&file, &glb[..end]).unwrap();
            let _ = Locator::new(&file, None).place(&at, "");
        }
    }
}
