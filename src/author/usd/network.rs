//! Nodes of a material's networks, below its prim: UsdPreviewSurface's own and MaterialX'.

use super::layer::{Datum, Prim, Property};
use super::name::Siblings;
use super::picture::Pictures;
use eyebox_scene::TextureInput;
use eyebox_scene::assembly::{Assembly, Material};
use eyebox_scene::texture::Encoding;

/// The nodes of one material so far.
pub struct Network<'a> {
    pub assembly: &'a Assembly,
    pub material: &'a Material,
    /// The path of the material.
    pub path: &'a str,
    /// Whether a mesh with this material has colours at its vertices, and whether some of those let light through.
    pub vertices: Option<bool>,
    pub pictures: &'a mut Pictures,
    names: Siblings,
    nodes: Vec<Prim>,
}

/// An output of a node.
pub type Output = String;

/// What an input of a node is.
#[derive(Debug, Clone)]
pub enum Source {
    Value(Datum),
    Node(Output),
}

impl<'a> Network<'a> {
    pub fn new(
        assembly: &'a Assembly,
        (material, path): (&'a Material, &'a str),
        vertices: Option<bool>,
        pictures: &'a mut Pictures,
    ) -> Self {
        Network { assembly, material, path, vertices, pictures, names: Siblings::default(), nodes: Vec::new() }
    }

    /// A free name of a node.
    pub fn name(&mut self, wanted: &str) -> String {
        self.names.name(wanted, "Node")
    }

    /// Adds a node with one output; one like it that is there already serves again. Inputs are (name, type, value).
    pub fn node(
        &mut self,
        name: &str,
        id: &str,
        inputs: Vec<(&str, &'static str, Source)>,
        output: (&str, &'static str),
    ) -> Output {
        let mut prim = Prim::def(3, "Shader", "");
        prim.push(Property::new("info:id", Datum::Token(id.to_owned())).uniform());
        for (name, type_name, source) in inputs {
            prim.push(match source {
                Source::Value(value) => Property::new(format!("inputs:{name}"), value).typed(type_name),
                Source::Node(output) => Property::connected(format!("inputs:{name}"), type_name, output),
            });
        }
        prim.push(Property::declared(format!("outputs:{}", output.0), output.1));
        self.add(name, prim, output.0)
    }

    /// Adds a node as it is, without its name.
    pub fn add(&mut self, name: &str, mut prim: Prim, output: &str) -> Output {
        let known = self.nodes.iter().find(|known| known.properties == prim.properties);
        let name = match known {
            Some(known) => known.name.clone(),
            None => {
                prim.name = self.name(name);
                let name = prim.name.clone();
                self.nodes.push(prim);
                name
            }
        };
        format!("{}/{name}.outputs:{output}", self.path)
    }

    /// Adds a node that has its name already.
    pub fn place(&mut self, prim: Prim) {
        self.nodes.push(prim);
    }

    pub fn finish(self) -> Vec<Prim> {
        self.nodes
    }

    pub fn warn(&mut self, what: &str, text: &str) {
        let text = format!("material `{}`, {what}: {text}", self.material.name);
        self.pictures.warn(&self.material.at, text);
    }

    /// How the layer names the picture that `input` reads.
    pub fn file(&mut self, input: &TextureInput, what: &str) -> Option<String> {
        let what = format!("material `{}`, {what}", self.material.name);
        self.pictures.path(&input.texture, &self.material.at, &what)
    }

    /// What becomes of `st` on its way to the picture, both with their second coordinate upwards: scaled, turned against the
    /// clock by degrees, moved. A map that slants is written without that, with a note.
    pub fn placed(&mut self, input: &TextureInput, what: &str) -> Placed {
        let [[a, b, x], [c, d, y]] = upwards(input, self.assembly.st_runs_up());
        if b == 0.0 && c == 0.0 {
            return Placed { scale: [a, d], turn_deg: 0.0, shift: [x, y] };
        }
        // The map is [cos · sx, −sin · sy; sin · sx, cos · sy].
        let (across, other) = (a.hypot(c), b.hypot(d));
        let (sin, cos) = if across > 0.0 { (c / across, a / across) } else { (-b / other, d / other) };
        let up = d * cos - b * sin;
        if (b + sin * up).hypot(d - cos * up) > 1e-6 * (across + up.abs()) {
            self.warn(what, "a slanted map of texture coordinates has no form in USD: written square");
        }
        Placed { scale: [across, up], turn_deg: sin.atan2(cos).to_degrees(), shift: [x, y] }
    }
}

/// See [`Network::placed`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    pub scale: [f64; 2],
    pub turn_deg: f64,
    pub shift: [f64; 2],
}

/// The map of `input` as one from the `st` that is written to a picture whose second coordinate grows from its bottom row.
fn upwards(input: &TextureInput, up: bool) -> [[f64; 3]; 2] {
    let [[a, b, c], [d, e, f]] = input.to_picture;
    let [first, second] = if up { [[a, b, c], [d, e, f]] } else { [[a, -b, c + b], [d, -e, f + e]] };
    [first, [-second[0], -second[1], 1.0 - second[2]]]
}

/// The primvar of a set of texture coordinates.
pub fn set_name(set: u32) -> &'static str {
    if set > 0 { "st1" } else { "st" }
}

/// What UsdUVTexture calls an encoding.
pub fn space(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Srgb => "sRGB",
        Encoding::Linear => "raw",
        Encoding::OfFile => "auto",
    }
}

pub fn single(x: f64) -> Datum {
    Datum::Float(x as f32)
}

pub fn pair(pair: [f64; 2]) -> Datum {
    Datum::Float2(pair.map(|x| x as f32))
}

pub fn triple(lanes: [f64; 3]) -> Datum {
    Datum::Float3(lanes.map(|x| x as f32))
}
