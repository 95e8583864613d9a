//! How a material looks, as UsdPreviewSurface: what `import::usd::standard` reads, the other way round. Source: the
//! UsdPreviewSurface specification 2.6.

use super::layer::{Datum, Prim, Property};
use super::network::{Network, Source, pair, set_name, single, space, triple};
use eyebox_scene::texture::{Channel, Filter, TextureInput, Wrap};
use eyebox_scene::{Colour, Opacity, Scalar, StandardSurface};

/// Which of the four lanes of a picture are read, and how: texel · scale + bias.
type Lanes = [Option<(f64, f64)>; 4];

/// A picture that some inputs read, until all of them are known.
struct Read<'s> {
    input: &'s TextureInput,
    lanes: Lanes,
    name: String,
    file: String,
}

/// The surface while it is written.
struct Preview<'n, 'a, 's> {
    network: &'n mut Network<'a>,
    reads: Vec<Read<'s>>,
    out: Prim,
}

/// What a material emits: the cd/m² of its three primaries' factor.
pub type Glow = [f64; 3];

/// Adds the surface to `network` and returns its output.
pub fn write(network: &mut Network<'_>, surface: &StandardSurface, ior: Option<f64>, glow: Option<Glow>) -> String {
    let out = Prim::def(3, "Shader", network.name("Surface"));
    let mut preview = Preview { network, reads: Vec::new(), out };
    preview.out.push(Property::new("info:id", Datum::Token("UsdPreviewSurface".to_owned())).uniform());
    preview.inputs(surface, ior, glow);
    preview.out.push(Property::declared("outputs:surface", "token"));
    let Preview { reads, out, .. } = preview;
    let name = out.name.clone();
    let pictures = reads.into_iter().map(|read| texture(network, read)).collect::<Vec<_>>();
    network.place(out);
    pictures.into_iter().for_each(|prim| network.place(prim));
    format!("{}/{name}.outputs:surface", network.path)
}

impl<'s> Preview<'_, '_, 's> {
    fn inputs(&mut self, surface: &'s StandardSurface, ior: Option<f64>, glow: Option<Glow>) {
        self.base(surface);
        if let Some(glow) = glow {
            let colour = (glow, surface.emission.as_ref());
            self.colour("emissiveColor", colour, "emission");
        }
        if surface.ior == f64::INFINITY {
            self.out.push(Property::new("inputs:useSpecularWorkflow", Datum::Int(1)));
            self.colour_of("specularColor", &surface.specular_color, "specular colour");
        } else {
            self.scalar("metallic", &surface.metallic, "metallic");
        }
        self.scalar("roughness", &surface.roughness, "roughness");
        if let Some(ior) = ior {
            self.out.push(Property::new("inputs:ior", single(ior)));
        }
        self.scalar("clearcoat", &surface.coat, "coat");
        self.scalar("clearcoatRoughness", &surface.coat_roughness, "roughness of the coat");
        match &surface.opacity {
            Opacity::Opaque => {}
            Opacity::Mask { alpha, cutoff } => {
                self.alpha(alpha);
                self.out.push(Property::new("inputs:opacityThreshold", single(*cutoff)));
                if *cutoff as f32 <= 0.0 {
                    self.network.warn("opacity", "a mask that cuts nothing off has no form in USD: written as a share");
                }
            }
            Opacity::Blend { alpha } => {
                // A share of what is there, not glass.
                self.out.push(Property::new("inputs:opacityMode", Datum::Token("presence".to_owned())));
                self.alpha(alpha);
            }
        }
        if let Some((input, strength)) = &surface.normal {
            let scale = |lane: usize| input.scale[lane] * if lane < 2 { *strength } else { 1.0 };
            let bias = |lane: usize| input.bias[lane] * if lane < 2 { *strength } else { 1.0 };
            let lanes =
                [Some((scale(0), bias(0))), Some((scale(1), bias(1))), Some((scale(2), bias(2))), Some((1.0, 0.0))];
            if let Some(output) = self.read(input, lanes, "rgb", "normal") {
                self.out.push(Property::connected("inputs:normal", "normal3f", output));
            }
        }
    }

    /// The base colour; the colours of vertices where nothing else has a part in it: there is no node that multiplies.
    fn base(&mut self, surface: &'s StandardSurface) {
        let plain = surface.base_color.texture.is_none() && surface.base_color.factor == [1.0; 3];
        if surface.vertex_colors && self.network.vertices.is_some() && plain {
            let inputs = vec![
                ("varname", "string", Source::Value(Datum::Text("displayColor".to_owned()))),
                ("fallback", "float3", Source::Value(triple([1.0; 3]))),
            ];
            let output = self.network.node("displayColor", "UsdPrimvarReader_float3", inputs, ("result", "float3"));
            self.out.push(Property::connected("inputs:diffuseColor", "color3f", output));
            return;
        }
        self.colour_of("diffuseColor", &surface.base_color, "base colour");
    }

    fn alpha(&mut self, alpha: &'s Scalar) {
        let plain = alpha.texture.is_none() && alpha.factor == 1.0;
        if plain && self.network.vertices == Some(true) {
            let inputs = vec![
                ("varname", "string", Source::Value(Datum::Text("displayOpacity".to_owned()))),
                ("fallback", "float", Source::Value(single(1.0))),
            ];
            let output = self.network.node("displayOpacity", "UsdPrimvarReader_float", inputs, ("result", "float"));
            self.out.push(Property::connected("inputs:opacity", "float", output));
            return;
        }
        self.scalar("opacity", alpha, "opacity");
    }

    fn colour_of(&mut self, name: &str, colour: &'s Colour, what: &str) {
        self.colour(name, (colour.factor, colour.texture.as_ref()), what);
    }

    fn colour(&mut self, name: &str, (factor, texture): ([f64; 3], Option<&'s TextureInput>), what: &str) {
        let name = format!("inputs:{name}");
        // What is in another order has nodes in MaterialX alone.
        let ordered = texture.filter(|input| input.channels[..3] == Channel::ALL[..3]);
        let output = ordered.and_then(|input| {
            let lane = |lane: usize| Some((factor[lane] * input.scale[lane], factor[lane] * input.bias[lane]));
            self.read(input, [lane(0), lane(1), lane(2), None], "rgb", what)
        });
        self.out.push(match output {
            Some(output) => Property::connected(name, "color3f", output),
            None => Property::new(name, triple(factor)).typed("color3f"),
        });
    }

    fn scalar(&mut self, name: &str, scalar: &'s Scalar, what: &str) {
        let name = format!("inputs:{name}");
        let output = scalar.texture.as_ref().and_then(|(input, channel)| {
            let (lane, output) = lane_of(channel.pick(input.channels));
            let mut lanes = Lanes::default();
            let by = scalar.factor;
            lanes[lane] = Some((by * channel.of(input.scale), by * channel.of(input.bias)));
            self.read(input, lanes, output, what)
        });
        self.out.push(match output {
            Some(output) => Property::connected(name, "float", output),
            None => Property::new(name, single(scalar.factor)),
        });
    }

    /// The output of the picture's node; one that reads the same picture serves again where its lanes are free.
    fn read(&mut self, input: &'s TextureInput, lanes: Lanes, output: &str, what: &str) -> Option<String> {
        let file = self.network.file(input, what)?;
        let fits = |read: &Read<'_>| {
            let lanes = read.lanes.iter().zip(&lanes).all(|(own, new)| own.is_none() || new.is_none() || own == new);
            let place = (read.input.encoding, read.input.wrap, read.input.set, read.input.to_picture);
            lanes && read.file == file && place == (input.encoding, input.wrap, input.set, input.to_picture)
        };
        let index = match self.reads.iter().position(fits) {
            Some(index) => index,
            None => {
                let name = self.network.name("Picture");
                self.reads.push(Read { input, lanes, name, file });
                self.reads.len() - 1
            }
        };
        let read = self.reads.get_mut(index)?;
        for (own, new) in read.lanes.iter_mut().zip(lanes) {
            *own = own.or(new);
        }
        Some(format!("{}/{}.outputs:{output}", self.network.path, read.name))
    }
}

/// The node of a picture.
fn texture(network: &mut Network<'_>, read: Read<'_>) -> Prim {
    let Read { input, lanes, name, file } = read;
    let mut prim = Prim::def(3, "Shader", name);
    prim.push(Property::new("info:id", Datum::Token("UsdUVTexture".to_owned())).uniform());
    prim.push(Property::new("inputs:file", Datum::Asset(file)));
    prim.push(Property::new("inputs:sourceColorSpace", Datum::Token(space(input.encoding).to_owned())));
    let st = coordinates(network, input);
    prim.push(Property::connected("inputs:st", "float2", st));
    for (name, wrap) in ["wrapS", "wrapT"].into_iter().zip(input.wrap) {
        let word = match wrap {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
            Wrap::Black => "black",
        };
        prim.push(Property::new(format!("inputs:{name}"), Datum::Token(word.to_owned())));
    }
    match input.filter {
        Filter::Linear => {}
        Filter::Nearest => {
            let text = format!(
                "UsdUVTexture filters the picture `{}`; the nearest texel has no form there",
                input.texture.name
            );
            network.warn("UsdPreviewSurface", &text);
        }
    }
    let scale: [f64; 4] = lanes.map(|lane| lane.map_or(1.0, |(scale, _)| scale));
    let bias: [f64; 4] = lanes.map(|lane| lane.map_or(0.0, |(_, bias)| bias));
    if scale != [1.0; 4] {
        prim.push(Property::new("inputs:scale", Datum::Float4(scale.map(|x| x as f32))));
    }
    if bias != [0.0; 4] {
        prim.push(Property::new("inputs:bias", Datum::Float4(bias.map(|x| x as f32))));
    }
    if let Some(texel) = input.fallback {
        let value: [f64; 4] = std::array::from_fn(|lane| texel[lane] * scale[lane] + bias[lane]);
        if value != [0.0, 0.0, 0.0, 1.0] {
            prim.push(Property::new("inputs:fallback", Datum::Float4(value.map(|x| x as f32))));
        }
    }
    for (lane, output) in [(0, "r"), (1, "g"), (2, "b"), (3, "a")] {
        if lanes[lane].is_some() {
            prim.push(Property::declared(format!("outputs:{output}"), "float"));
        }
    }
    if lanes.iter().take(3).all(Option::is_some) {
        prim.push(Property::declared("outputs:rgb", "float3"));
    }
    prim
}

/// The texture coordinates of a picture.
fn coordinates(network: &mut Network<'_>, input: &TextureInput) -> String {
    let name = set_name(input.set);
    let inputs = vec![("varname", "string", Source::Value(Datum::Text(name.to_owned())))];
    let st = network.node(name, "UsdPrimvarReader_float2", inputs, ("result", "float2"));
    let placed = network.placed(input, "texture coordinates");
    let mut inputs = vec![("in", "float2", Source::Node(st.clone()))];
    if placed.scale != [1.0; 2] {
        inputs.push(("scale", "float2", Source::Value(pair(placed.scale))));
    }
    if placed.turn_deg != 0.0 {
        inputs.push(("rotation", "float", Source::Value(single(placed.turn_deg))));
    }
    if placed.shift != [0.0; 2] {
        inputs.push(("translation", "float2", Source::Value(pair(placed.shift))));
    }
    if inputs.len() == 1 {
        return st;
    }
    network.node("Place", "UsdTransform2d", inputs, ("result", "float2"))
}

/// The number of a channel, and its output of a picture's node.
fn lane_of(channel: Channel) -> (usize, &'static str) {
    match channel {
        Channel::Red => (0, "r"),
        Channel::Green => (1, "g"),
        Channel::Blue => (2, "b"),
        Channel::Alpha => (3, "a"),
    }
}
