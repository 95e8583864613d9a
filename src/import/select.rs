//! Which parts and faces a `[[bind]]` (or the target of `--set`) selects.

use super::assembly::Assembly;
use super::measure::FaceMeasure;
use super::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use glam::DVec3;

/// A node with geometry, as selectors see it.
///
/// Where a node holds nothing but one part somewhere below it (USD's component `LENS_01` with its mesh `Body`), the part
/// goes by that node's name and path; its own still select it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// Index of the node.
    pub node: usize,
    pub mesh: usize,
    pub name: String,
    pub path: String,
    /// The path without the root's name, if the asset has one root.
    pub short: Option<String>,
    pub faces: usize,
    /// Names and paths (with and without the root's name) of the nodes between, the part's own first.
    inner: Vec<(String, String, Option<String>)>,
}

/// The parts of an assembly in node order. Faults: a node with a mesh that doesn't exist.
pub fn candidates(assembly: &Assembly) -> Result<Vec<Candidate>> {
    let prefix = root_prefix(assembly);
    let counts = parts_below(assembly);
    let mut all = Vec::new();
    for (index, node) in assembly.nodes.iter().enumerate() {
        let Some(mesh) = node.mesh else { continue };
        let Some(source) = assembly.meshes.get(mesh) else {
            return Err(Error::new(
                node.at.clone(),
                format!("node `{}` has mesh {mesh}, which does not exist", node.path),
            )
            .expected(format!("a mesh below {}", assembly.meshes.len())));
        };
        let (mut outer, mut inner) = (node, Vec::new());
        while let Some((parent, above)) = outer.parent.and_then(|parent| Some((parent, assembly.nodes.get(parent)?)))
            && above.mesh.is_none()
            && above.parent.is_some_and(|grandparent| grandparent < parent)
            && counts.get(parent) == Some(&1)
        {
            inner.push((outer.name.clone(), outer.path.clone(), short(&outer.path, prefix.as_deref())));
            outer = above;
        }
        all.push(Candidate {
            node: index,
            mesh,
            name: outer.name.clone(),
            path: outer.path.clone(),
            short: short(&outer.path, prefix.as_deref()),
            faces: source.mesh.faces.len(),
            inner,
        });
    }
    Ok(all)
}

/// How many parts there are at and below each node.
fn parts_below(assembly: &Assembly) -> Vec<usize> {
    let mut counts: Vec<usize> = assembly.nodes.iter().map(|node| usize::from(node.mesh.is_some())).collect();
    for (index, node) in assembly.nodes.iter().enumerate().rev() {
        if let Some(parent) = node.parent.filter(|parent| *parent < index) {
            counts[parent] += counts[index];
        }
    }
    counts
}

/// `NAME/` of the root, if there is exactly one.
fn root_prefix(assembly: &Assembly) -> Option<String> {
    let mut roots = assembly.nodes.iter().filter(|node| node.parent.is_none());
    match (roots.next(), roots.next()) {
        (Some(root), None) => Some(format!("{}/", root.path)),
        (Some(_), Some(_)) | (None, _) => None,
    }
}

fn short(path: &str, prefix: Option<&str>) -> Option<String> {
    prefix.and_then(|prefix| path.strip_prefix(prefix)).map(str::to_owned)
}

/// The one node that `name` (a path or a name) means, for a `frame`.
pub fn node(assembly: &Assembly, name: &str, at: &Where) -> Result<usize> {
    let prefix = root_prefix(assembly);
    let is = |path: &str| path == name || short(path, prefix.as_deref()).as_deref() == Some(name);
    let find = |test: &dyn Fn(&super::assembly::Node) -> bool| -> Vec<usize> {
        assembly.nodes.iter().enumerate().filter(|(_, node)| test(node)).map(|(index, _)| index).collect()
    };
    let mut found = find(&|node| is(&node.path));
    if found.is_empty() {
        found = find(&|node| node.name == name);
    }
    match found.as_slice() {
        [one] => Ok(*one),
        [] => {
            let path =
                |node: &super::assembly::Node| if name.contains('/') { node.path.clone() } else { node.name.clone() };
            let names: Vec<String> = assembly.nodes.iter().map(path).collect();
            Err(Error::new(at.clone(), format!("frame `{name}` is no node of the asset"))
                .expected("\"asset\", or the name or path of a node")
                .nearest(name, names.iter().map(String::as_str).chain(["asset"]))
                .code(Code::SelectsNothing))
        }
        several => {
            let paths = several.iter().filter_map(|index| assembly.nodes.get(*index)).map(|node| node.path.as_str());
            Err(Error::new(at.clone(), format!("frame `{name}` means {} nodes: {}", several.len(), listed(paths)))
                .expected("a path that only one node has")
                .code(Code::NameAmbiguous))
        }
    }
}

/// Up to five, then how many more.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let all: Vec<&str> = names.collect();
    let mut text = all.iter().take(5).copied().collect::<Vec<_>>().join(", ");
    if all.len() > 5 {
        text += &format!(" and {} more", all.len() - 5);
    }
    text
}

/// `*` stands for any characters but `/`, `**` for any at all; `**/` also for nothing.
pub fn glob(pattern: &str, text: &str) -> bool {
    // Positions in the text that the pattern read so far can end at.
    let text: Vec<char> = text.chars().collect();
    let mut reached = vec![false; text.len() + 1];
    reached[0] = true;
    let mut rest: Vec<char> = pattern.chars().collect();
    while !rest.is_empty() {
        let (read, next) = if rest.starts_with(&['*', '*', '/']) {
            // Nothing, or anything that ends with `/`.
            let mut open = false;
            let next = (0..=text.len())
                .map(|i| {
                    let after_slash = open && i > 0 && text[i - 1] == '/';
                    open |= reached[i];
                    reached[i] || after_slash
                })
                .collect();
            (3, next)
        } else if rest.starts_with(&['*', '*']) {
            let mut open = false;
            (
                2,
                (0..=text.len())
                    .map(|i| {
                        open |= reached[i];
                        open
                    })
                    .collect(),
            )
        } else if rest.starts_with(&['*']) {
            let mut open = false;
            let next = (0..=text.len())
                .map(|i| {
                    open = reached[i] || (open && i > 0 && text[i - 1] != '/');
                    open
                })
                .collect();
            (1, next)
        } else {
            let literal = rest[0];
            (1, (0..=text.len()).map(|i| i > 0 && reached[i - 1] && text[i - 1] == literal).collect())
        };
        reached = next;
        rest.drain(..read);
    }
    reached[text.len()]
}

pub fn is_glob(pattern: &str) -> bool {
    pattern.contains('*')
}

impl Candidate {
    pub fn has_path(&self, pattern: &str) -> bool {
        let matches = |path: &str| if is_glob(pattern) { glob(pattern, path) } else { pattern == path };
        matches(&self.path)
            || self.short.as_deref().is_some_and(matches)
            || self.inner.iter().any(|(_, path, short)| matches(path) || short.as_deref().is_some_and(matches))
    }
    pub fn has_name(&self, pattern: &str) -> bool {
        let matches = |name: &str| if is_glob(pattern) { glob(pattern, name) } else { pattern == name };
        matches(&self.name) || self.inner.iter().any(|(name, _, _)| matches(name))
    }
}

/// The faces of a part that a selector wants.
#[derive(Debug, Clone, PartialEq)]
pub enum Faces {
    All,
    Numbers(Vec<usize>),
    /// Area-weighted normal within 1° of this direction, local.
    Normal(DVec3),
}

impl Faces {
    /// Reads `faces = [0, 2]` and `normal = "+z"` of a bind; giving both is a fault.
    pub fn read(faces: Option<&Value>, normal: Option<&Value>) -> Result<Self> {
        const AXES: [(&str, DVec3); 6] = [
            ("+x", DVec3::X),
            ("-x", DVec3::NEG_X),
            ("+y", DVec3::Y),
            ("-y", DVec3::NEG_Y),
            ("+z", DVec3::Z),
            ("-z", DVec3::NEG_Z),
        ];
        match (faces, normal) {
            (None, None) => Ok(Faces::All),
            (Some(_), Some(normal)) => Err(Error::new(normal.at.clone(), "both `faces` and `normal`")
                .expected("one of them")
                .code(Code::SaidTwice)),
            (Some(value), None) => {
                let wrong = || {
                    Error::new(value.at.clone(), format!("`faces` is {} ({value})", value.kind()))
                        .expected("a list of face numbers, e.g. [0, 2]")
                };
                let list = value.list().filter(|list| !list.is_empty()).ok_or_else(wrong)?;
                let number = |item: &Value| {
                    let number = item.number().ok_or_else(wrong)?;
                    let whole = number as usize;
                    if whole as f64 == number { Ok(whole) } else { Err(wrong()) }
                };
                Ok(Faces::Numbers(list.iter().map(number).collect::<Result<_>>()?))
            }
            (None, Some(value)) => {
                let token = AXES.iter().find(|(name, _)| value.text() == Some(name)).map(|(_, axis)| *axis);
                token.map(Faces::Normal).ok_or_else(|| {
                    Error::new(value.at.clone(), format!("`normal` is {value}"))
                        .expected("one of \"+x\", \"-x\", \"+y\", \"-y\", \"+z\", \"-z\", in the part's local axes")
                })
            }
        }
    }

    /// The faces of `part`. Faults: a number that the part doesn't have.
    pub fn of(&self, part: &Candidate, assembly: &Assembly, at: &Where) -> Result<Vec<usize>> {
        match self {
            Faces::All => Ok((0..part.faces).collect()),
            Faces::Numbers(numbers) => {
                if let Some(number) = numbers.iter().find(|number| **number >= part.faces) {
                    let expected = match part.faces {
                        0 => "no face at all: the part has none".to_owned(),
                        count => format!("a face from 0 to {}", count - 1),
                    };
                    return Err(Error::new(at.clone(), format!("part {} has no face {number}", part.path))
                        .expected(expected)
                        .code(Code::SelectsNothing));
                }
                Ok(numbers.clone())
            }
            Faces::Normal(axis) => {
                let Some(source) = assembly.meshes.get(part.mesh) else { return Ok(Vec::new()) };
                let near = |face: &usize| {
                    let normal = FaceMeasure::new(&source.mesh, *face).and_then(|measure| measure.normal());
                    normal.is_some_and(|normal| normal.dot(*axis) >= 1f64.to_radians().cos())
                };
                Ok((0..part.faces).filter(near).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::glob;

    #[test]
    fn one_star_stops_at_a_slash_and_two_cross_it() {
        for (pattern, text, expected) in [
            ("A", "A", true),
            ("A", "AB", false),
            ("LED_*", "LED_1", true),
            ("LED_*", "LED_", true),
            ("LED_*", "LED_1/X", false),
            ("*", "A/B", false),
            ("**", "A/B", true),
            ("**", "", true),
            ("A/**", "A/B/C", true),
            ("**/C", "A/B/C", true),
            ("**/C", "C", true),
            ("**/C", "XC", false),
            ("A/**/C", "A/C", true),
            ("A/**/C", "A/X/Y/C", true),
            ("A/*/C", "A/X/Y/C", false),
            ("*_*_1", "LED_DIE_1", true),
            ("*a*b*c", "xaybzc", true),
            ("*a*b*c", "xaybz", false),
            ("Ä*", "Äö", true),
        ] {
            assert_eq!(glob(pattern, text), expected, "{pattern} {text}");
        }
        // No pattern may take exponential time.
        assert!(!glob(&"*a".repeat(200), &"a".repeat(199)));
    }
}
