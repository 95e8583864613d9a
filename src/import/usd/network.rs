//! From an input of a shader through the nodes before it to what they come to: pictures, primvars, and arithmetic on
//! them (`nodes`).

use super::attribute::PrimView;
use super::fold::{Folded, Lanes};
use super::reader::Reader;
use super::reads::OfVertices;
use super::shader::{self, End};
use super::{coordinates, texture, value};
use eyebox_base::error::Result;

/// Nodes above one another.
const MOST_DEEP: usize = 64;

/// The kind of a node: `image` of `ND_image_color3`, `UsdPrimvarReader` of `UsdPrimvarReader_float2`.
pub(super) fn kind(id: &str) -> &str {
    let name = id.strip_prefix("ND_").unwrap_or(id);
    name.split('_').next().unwrap_or(name)
}

/// What an input (`inputs:…`) comes to; none if nothing is said, or nothing that is known: then there is a note.
///
/// # Errors
/// What the library cannot read.
pub(super) fn folded(reader: &mut Reader, view: &PrimView, name: &str) -> Result<Option<Folded>> {
    match shader::follow(reader, view, name)? {
        End::Value(found, _) => Ok(as_lanes(&found).map(Folded::constant)),
        End::Nothing => Ok(None),
        End::Node(node, output) => {
            let key = (node.path().as_str().to_owned(), output.clone());
            if let Some(known) = reader.folding.known.get(&key) {
                return Ok(known.clone());
            }
            if reader.folding.depth >= MOST_DEEP {
                reader.ledger.warn(node.at(), "nodes too deep in one another: not used");
                return Ok(None);
            }
            reader.folding.known.insert(key.clone(), None);
            reader.folding.depth += 1;
            let id = shader::id(&node)?;
            let found = Node { reader, view: &node, id: &id }.fold(&output);
            reader.folding.depth -= 1;
            let found = found?;
            reader.charge(node.path(), 1, size_of::<Folded>() + 512)?;
            reader.folding.known.insert(key, found.clone());
            Ok(found)
        }
    }
}

/// A number is in all lanes; the fourth of three is 1.
fn as_lanes(found: &openusd::sdf::Value) -> Option<Lanes> {
    let number = value::number(found).map(|x| [x; 4]);
    let lanes = number.or_else(|| value::four(found)).or_else(|| value::pair(found).map(|[u, v]| [u, v, 0.0, 1.0]));
    lanes.filter(|lanes| lanes.iter().all(|x| x.is_finite()))
}

/// The constant of an input of a node.
///
/// # Errors
/// What the library cannot read.
pub(super) fn lanes(reader: &mut Reader, node: &PrimView, name: &str, default: Lanes) -> Result<Lanes> {
    Ok(folded(reader, node, &format!("inputs:{name}"))?.and_then(|found| found.lanes()).unwrap_or(default))
}

/// See [`lanes`].
pub(super) fn number(reader: &mut Reader, node: &PrimView, name: &str, default: f64) -> Result<f64> {
    Ok(lanes(reader, node, name, [default; 4])?[0])
}

/// See [`lanes`].
pub(super) fn pair(reader: &mut Reader, node: &PrimView, name: &str, default: [f64; 2]) -> Result<[f64; 2]> {
    Ok(match shader::follow(reader, node, &format!("inputs:{name}"))? {
        End::Value(found, _) => coordinates::two(&found).unwrap_or(default),
        End::Node(..) => {
            let [u, v, _, _] = lanes(reader, node, name, [default[0], default[1], 0.0, 1.0])?;
            [u, v]
        }
        End::Nothing => default,
    })
}

/// The text of an input of a node.
///
/// # Errors
/// What the library cannot read.
pub(super) fn text(reader: &mut Reader, node: &PrimView, name: &str) -> Result<Option<String>> {
    Ok(match shader::follow(reader, node, &format!("inputs:{name}"))? {
        End::Value(found, _) => value::text(&found).map(str::to_owned),
        End::Node(..) | End::Nothing => None,
    })
}

/// One node on its way.
pub(super) struct Node<'a> {
    pub reader: &'a mut Reader,
    pub view: &'a PrimView,
    pub id: &'a str,
}

impl Node<'_> {
    fn fold(&mut self, output: &str) -> Result<Option<Folded>> {
        let kind = kind(self.id);
        let output = output.strip_prefix("outputs:").unwrap_or(output);
        if let Some(family) = texture::family(kind, self.id) {
            let found = texture::read(self.reader, self.view, family)?;
            let single = kind != "UsdUVTexture" && self.id.ends_with("_float");
            let lanes = if single { Some([0; 4]) } else { lane(output).map(|lane| [lane; 4]) };
            return Ok(match lanes {
                Some(lanes) => found.picked(lanes),
                None => Some(found),
            });
        }
        match kind {
            "UsdPrimvarReader" => self.primvar("varname", "fallback"),
            "geompropvalue" => self.primvar("geomprop", "default"),
            // The colours of the mesh; USD has one set of them.
            "geomcolor" => Ok(Some(Folded::of_vertices(self.of_vertices("displayColor".to_owned(), [1.0; 4])))),
            "extract" | "separate2" | "separate3" | "separate4" | "swizzle" | "combine2" | "combine3" | "combine4"
            | "convert" | "dot" => self.lanes_of(kind, output),
            "ifgreater" | "ifgreatereq" | "ifequal" | "switch" => self.choice(kind),
            _ => self.arithmetic(kind),
        }
    }

    /// An input, or what it is where nothing is said.
    pub fn input(&mut self, name: &str, default: f64) -> Result<Folded> {
        Ok(folded(self.reader, self.view, &format!("inputs:{name}"))?.unwrap_or(Folded::number(default)))
    }

    /// What becomes of a node whose result no surface knows: one of its inputs goes on, with a note.
    pub fn alone(&mut self, name: &str, found: Folded) -> Option<Folded> {
        let text = format!("what the node `{}` makes of its inputs is not used: `{name}` alone is taken", self.id);
        self.reader.ledger.warn(self.view.at(), text);
        Some(found)
    }

    fn primvar(&mut self, name: &str, fallback: &str) -> Result<Option<Folded>> {
        let fallback = lanes(self.reader, self.view, fallback, [0.0; 4])?;
        let Some(named) = text(self.reader, self.view, name)?.filter(|named| !named.is_empty()) else {
            self.reader.ledger.warn(self.view.at(), format!("`{}` without `{name}`: its fallback is taken", self.id));
            return Ok(Some(Folded::constant(fallback)));
        };
        Ok(Some(Folded::of_vertices(self.of_vertices(named, fallback))))
    }

    fn of_vertices(&self, name: String, fallback: Lanes) -> OfVertices {
        let [r, g, b, _] = fallback.map(|x| x as f32);
        // `float`, but not `float3`; `color3`, `vector3` and the rest are colours.
        OfVertices { name, fallback: [r, g, b], color: !self.id.ends_with("_float") }
    }
}

/// The lane that an output's name is of.
pub(super) fn lane(name: &str) -> Option<usize> {
    match name {
        "r" | "x" => Some(0),
        "g" | "y" => Some(1),
        "b" | "z" => Some(2),
        "a" | "w" => Some(3),
        _ => None,
    }
}
