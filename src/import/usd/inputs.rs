//! The inputs of a surface shader as parameters of a [`StandardSurface`](eyebox_scene::StandardSurface).

use super::attribute::PrimView;
use super::fold::{Folded, Lanes, Reading};
use super::network;
use super::reader::Reader;
use super::reads::{Coordinates, OfVertices, Reads};
use super::shader::{self, End};
use eyebox_base::error::Result;
use eyebox_scene::texture::Channel;
use eyebox_scene::{Colour, Scalar, TextureInput};

/// The inputs of one shader.
pub(super) struct Shader<'a> {
    pub reader: &'a mut Reader,
    pub view: &'a PrimView,
}

/// A name and what it is where nothing is said.
type Named<'a, T> = (&'a str, T);

impl Shader<'_> {
    fn folded(&mut self, name: &str) -> Result<Option<Folded>> {
        network::folded(self.reader, self.view, &format!("inputs:{name}"))
    }

    fn warn(&mut self, name: &str, text: String) {
        let at = self.view.at_property(&format!("inputs:{name}"));
        self.reader.ledger.warn(at, text);
    }

    /// Says that an input is not applied, and why.
    pub fn unapplied(&mut self, name: &str, why: &str) {
        self.warn(name, format!("`{name}` of a surface is not used: {why}"));
    }

    /// Whether an input is said and is not this, all over.
    pub fn differs(&mut self, name: &str, neutral: f64) -> Result<bool> {
        if !self.view.has(&format!("inputs:{name}")) {
            return Ok(false);
        }
        // What says nothing is neutral, what comes to no constant is not.
        let End::Nothing = shader::follow(self.reader, self.view, &format!("inputs:{name}"))? else {
            let lanes = self.folded(name)?.and_then(|found| found.lanes());
            return Ok(lanes.is_none_or(|[r, g, b, _]| [r, g, b] != [neutral; 3]));
        };
        Ok(false)
    }

    /// A number that is no picture.
    pub fn plain(&mut self, name: &str, default: f64) -> Result<f64> {
        let Some(found) = self.folded(name)? else { return Ok(default) };
        if found.lanes().is_none() {
            self.warn(name, format!("a picture as `{name}` of a surface is not used: {default}"));
        }
        Ok(found.lanes().map_or(default, |[x, ..]| x))
    }

    pub fn scalar(&mut self, name: &str, default: f64) -> Result<Scalar> {
        let found = self.folded(name)?.unwrap_or(Folded::number(default));
        let found = self.without_vertices(name, found);
        Ok(self.as_scalar(name, found))
    }

    /// An opacity, and whether what the vertices have is a factor of it.
    pub fn alpha(&mut self, name: &str) -> Result<(Scalar, bool)> {
        let mut found = self.folded(name)?.unwrap_or(Folded::number(1.0));
        let own = found.vertices.take_if(|vertices| !vertices.color);
        let by_vertices = own.is_some();
        self.reader.folding.reads.opacity = own;
        let found = self.without_vertices(name, found);
        Ok((self.as_scalar(name, found), by_vertices))
    }

    pub fn colour(&mut self, name: &str, default: [f64; 3]) -> Result<Colour> {
        let found = self.folded(name)?.unwrap_or(constant(default));
        let found = self.without_vertices(name, found);
        Ok(self.as_colour(name, found))
    }

    /// The base colour, perhaps by a weight, and whether the colours of the vertices are a factor of it.
    pub fn base(&mut self, weight: Option<Named<'_, f64>>, color: Named<'_, [f64; 3]>) -> Result<(Colour, bool)> {
        let mut found = self.weighted(weight, color)?;
        let own = found.vertices.take_if(|vertices| vertices.color);
        let by_vertices = own.is_some();
        self.reader.folding.reads.color = own;
        let found = self.without_vertices(color.0, found);
        Ok((self.as_colour(color.0, found), by_vertices))
    }

    /// A colour by a weight.
    pub fn product(&mut self, weight: Named<'_, f64>, color: Named<'_, [f64; 3]>) -> Result<Colour> {
        let found = self.weighted(Some(weight), color)?;
        let found = self.without_vertices(color.0, found);
        Ok(self.as_colour(color.0, found))
    }

    fn weighted(&mut self, weight: Option<Named<'_, f64>>, color: Named<'_, [f64; 3]>) -> Result<Folded> {
        let own = self.folded(color.0)?.unwrap_or(constant(color.1));
        let Some((name, default)) = weight else { return Ok(own) };
        let weight = self.folded(name)?.unwrap_or(Folded::number(default));
        if let Some(product) = own.clone().times(weight) {
            return Ok(product);
        }
        self.warn(name, format!("a picture as `{name}` of a surface beside one as `{}` is not used: 1", color.0));
        Ok(own)
    }

    /// What a face emits: the colour of its light by a weight, and the picture that it shines through, if any, whose white is that
    /// colour. None where something is said that is no light, with a note.
    pub fn light(
        &mut self,
        weight: Option<Named<'_, f64>>,
        color: Named<'_, [f64; 3]>,
    ) -> Result<Option<([f64; 3], Option<TextureInput>)>> {
        let found = self.weighted(weight, color)?;
        let found = self.without_vertices(color.0, found);
        if let Reading::Constant([r, g, b, _]) = found.what {
            let sound = [r, g, b].iter().all(|lane| *lane >= 0.0 && lane.is_finite());
            if !sound {
                self.warn(color.0, format!("a value of `{}` that is none it can have: ignored", color.0));
            }
            return Ok(sound.then_some(([r, g, b], None)));
        }
        let Colour { factor, texture } = self.as_colour(color.0, found);
        let Some(mut input) = texture else { return Ok(Some((factor, None))) };
        let [r, g, b, _] = input.scale;
        let scaled = input.bias[..3] == [0.0; 3] && [r, g, b].iter().all(|scale| *scale >= 0.0 && scale.is_finite());
        if !scaled {
            return Ok(Some(([1.0; 3], Some(input))));
        }
        // Its scale is the light's, as other formats have it.
        input.scale = [1.0, 1.0, 1.0, input.scale[3]];
        Ok(Some(([r, g, b], Some(input))))
    }

    /// Tangent-space normals, each component −1 to 1.
    pub fn normal(&mut self, name: &str) -> Result<Option<(TextureInput, f64)>> {
        let property = format!("inputs:{name}");
        let End::Node(node, _) = shader::follow(self.reader, self.view, &property)? else { return Ok(None) };
        // MaterialX has a node that makes normals of texels of 0 to 1, and stretches them.
        let map = network::kind(&shader::id(&node)?) == "normalmap";
        let (found, strength) = if map {
            let strength = network::number(self.reader, &node, "scale", 1.0)?;
            if network::text(self.reader, &node, "space")?.is_some_and(|space| space != "tangent") {
                self.warn(name, "normals that are not in tangent space are not used".to_owned());
                return Ok(None);
            }
            let found = network::folded(self.reader, &node, "inputs:in")?;
            (found.and_then(|found| found.scaled([2.0, 2.0, 2.0, 1.0]).moved([-1.0, -1.0, -1.0, 0.0])), strength)
        } else {
            (self.folded(name)?, 1.0)
        };
        let Some(found) = found else { return Ok(None) };
        let found = self.without_vertices(name, found);
        let Reading::Picture(mut input, coordinates) = found.what else { return Ok(None) };
        if !map && input.bias[..3] == [0.0; 3] {
            let text =
                "a normal map without `scale` 2 and `bias` -1, which UsdPreviewSurface asks for: taken with them";
            self.warn(name, text.to_owned());
            (input.scale, input.bias) = ([2.0, 2.0, 2.0, 1.0], [-1.0, -1.0, -1.0, 0.0]);
        }
        Ok(Some((self.placed(name, *input, &coordinates), strength)))
    }

    /// Notes that the shape of a surface is not changed.
    pub fn moved(&mut self, name: &str) -> Result<()> {
        let Some(found) = self.folded(name)? else { return Ok(()) };
        if found.lanes().is_none_or(|lanes| lanes[0] != 0.0) {
            self.warn(name, format!("`{name}` of a surface is not used: its mesh is as it is"));
        }
        Ok(())
    }

    /// What cannot be multiplied by what vertices have, is by the fallback of the reader; with a note.
    fn without_vertices(&mut self, name: &str, mut found: Folded) -> Folded {
        let Some(OfVertices { name: primvar, fallback, color }) = found.vertices.take() else { return found };
        let what = if color { "the colours" } else { "the numbers" };
        let text = format!(
            "{what} of the primvar `{primvar}` as `{name}` of a surface are not used: the fallback of their reader"
        );
        self.warn(name, text);
        let [r, g, b] = fallback.map(f64::from);
        found.scaled(if color { [r, g, b, 1.0] } else { [r; 4] })
    }

    fn as_scalar(&mut self, name: &str, found: Folded) -> Scalar {
        match found.what {
            Reading::Constant([r, g, b, _]) => {
                // An opacity of MaterialX' is a colour.
                let mean = if r == g && g == b { r } else { (r + g + b) / 3.0 };
                Scalar::new(mean.clamp(0.0, 1.0))
            }
            Reading::Picture(mut input, coordinates) => {
                let channel = input.channels[0];
                let (scale, bias) = (input.scale[0], input.bias[0]);
                input.channels = Channel::ALL;
                let lane = Channel::ALL.iter().position(|known| *known == channel).unwrap_or(0);
                let only = |x: f64, rest: f64| -> Lanes { std::array::from_fn(|i| if i == lane { x } else { rest }) };
                // Of what is read as it is, all is; else the other lanes say nothing.
                if (scale, bias) == (1.0, 0.0) {
                    (input.scale, input.bias) = ([1.0; 4], [0.0; 4]);
                } else {
                    (input.scale, input.bias) = (only(scale, 1.0), only(bias, 0.0));
                }
                Scalar { factor: 1.0, texture: Some((self.placed(name, *input, &coordinates), channel)) }
            }
        }
    }

    fn as_colour(&mut self, name: &str, found: Folded) -> Colour {
        match found.what {
            Reading::Constant([r, g, b, _]) => Colour::new([r, g, b].map(|c| c.max(0.0))),
            Reading::Picture(input, coordinates) => {
                Colour { factor: [1.0; 3], texture: Some(self.placed(name, *input, &coordinates)) }
            }
        }
    }

    /// A picture with the number of its set of texture coordinates.
    fn placed(&mut self, name: &str, input: TextureInput, coordinates: &Coordinates) -> TextureInput {
        let set = match self.reader.folding.reads.number(coordinates) {
            Some(set) => set,
            None => {
                let most = Reads::SETS;
                self.warn(
                    name,
                    format!("a material that reads more than {most} sets of texture coordinates: the last is taken"),
                );
                most as u32 - 1
            }
        };
        TextureInput { set, ..input }
    }
}

fn constant([r, g, b]: [f64; 3]) -> Folded {
    Folded::constant([r, g, b, 1.0])
}
