//! How a material looks, as OpenPBR in MaterialX' nodes, for what UsdPreviewSurface lacks: what `import::usd::standard` reads,
//! the other way round. Sources: OpenPBR Surface 1.1; the MaterialX Specification 1.39, Standard Nodes.

use super::layer::{Datum, Prim, Property};
use super::network::{Network, Output, Source, pair, set_name, single, triple};
use super::preview::Glow;
use eyebox_base::colour::luminance;
use eyebox_scene::texture::{Channel, Encoding, Filter, TextureInput, Wrap};
use eyebox_scene::{AnisotropyLaw, CoatNormal, Colour, Opacity, Scalar, StandardSurface};

/// What a material says beside its looks.
#[derive(Debug, Clone, Copy, Default)]
pub struct Optics {
    pub ior: Option<f64>,
    /// Luminous: the cd/m² of its primaries.
    pub glow: Option<Glow>,
    /// Whether light goes through it into a solid, and not through a sheet.
    pub solid: bool,
    /// Length in scene units, and what a solid lets through of it.
    pub attenuation: Option<(f64, [f64; 3])>,
    /// 20/V_d.
    pub dispersion: Option<f64>,
    /// Index, and thickness in nm.
    pub film: Option<(f64, f64)>,
}

/// Whether the surface says more than UsdPreviewSurface can.
pub fn is_needed(surface: &StandardSurface, optics: &Optics, vertices: Option<bool>) -> bool {
    const WHITE: Colour = Colour::new([1.0; 3]);
    let shown = surface.vertex_colors && vertices.is_some();
    let painted =
        shown && (surface.base_color != WHITE || through(surface).is_some_and(|alpha| *alpha != Scalar::new(1.0)));
    let inputs = || surface.textures().chain(&surface.emission);
    let nearest = inputs().any(|input| input.filter == Filter::Nearest);
    let colours = [&surface.base_color, &surface.specular_color, &surface.sheen_color];
    let pictures = colours.iter().filter_map(|colour| colour.texture.as_ref()).chain(&surface.emission);
    let swapped = pictures.into_iter().any(|input| input.channels[..3] != Channel::ALL[..3]);
    surface.specular != Scalar::new(1.0)
        || surface.ior.is_finite() && surface.specular_color != WHITE
        || surface.transmission != Scalar::new(0.0)
        || surface.sheen_color != Colour::new([0.0; 3])
        || optics.glow.is_some()
        || optics.film.is_some()
        || surface.film.is_some()
        || surface.anisotropy.is_some()
        || own_coat_normal(surface)
        || coat_is_stained(surface)
        || painted
        || nearest
        || swapped
}

/// Whether the coat has a colour or an index of its own.
fn coat_is_stained(surface: &StandardSurface) -> bool {
    surface.coat.factor > 0.0 && (surface.coat_ior != 1.5 || surface.coat_color != Colour::new([1.0; 3]))
}

/// Whether the coat has other normals than the base, which share those of UsdPreviewSurface.
fn own_coat_normal(surface: &StandardSurface) -> bool {
    surface.coat.factor > 0.0
        && match &surface.coat_normal {
            CoatNormal::Base => false,
            CoatNormal::Smooth => surface.normal.is_some(),
            CoatNormal::Map(..) => true,
        }
}

fn through(surface: &StandardSurface) -> Option<&Scalar> {
    match &surface.opacity {
        Opacity::Opaque => None,
        Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => Some(alpha),
    }
}

/// The surface while it is written.
struct Layers<'n, 'a> {
    network: &'n mut Network<'a>,
    out: Prim,
}

/// Adds the surface to `network` and returns its output.
pub fn write(network: &mut Network<'_>, surface: &StandardSurface, optics: &Optics) -> Output {
    let out = Prim::def(3, "Shader", network.name("OpenPBR"));
    let mut layers = Layers { network, out };
    layers.out.push(Property::new("info:id", Datum::Token("ND_open_pbr_surface_surfaceshader".to_owned())).uniform());
    layers.inputs(surface, optics);
    layers.optics(surface, optics);
    layers.out.push(Property::declared("outputs:out", "token"));
    let out = layers.out;
    let name = out.name.clone();
    network.place(out);
    format!("{}/{name}.outputs:out", network.path)
}

impl Layers<'_, '_> {
    fn inputs(&mut self, surface: &StandardSurface, optics: &Optics) {
        let paint =
            (surface.vertex_colors && self.network.vertices.is_some()).then(|| self.vertices("displayColor", "color3"));
        self.colour("base_color", &surface.base_color, paint, "base colour");
        if surface.diffuse_roughness != Scalar::new(0.0) {
            self.scalar("base_diffuse_roughness", &surface.diffuse_roughness, None, "roughness of the diffuse base");
        }
        self.scalar("base_metalness", &surface.metallic, None, "metallic");
        self.roughness(surface);
        if let Some(ior) = optics.ior {
            self.out.push(Property::new("inputs:specular_ior", single(ior)));
        }
        if surface.specular != Scalar::new(1.0) {
            self.scalar("specular_weight", &surface.specular, None, "specular");
        }
        if surface.metallic.factor > 0.0 && surface.metal_edge != surface.specular_color {
            self.network.warn(
                "specular colour",
                "OpenPBR has one for dielectrics and the edges of metals: the former is written",
            );
        }
        if surface.specular_color != Colour::new([1.0; 3]) {
            self.colour("specular_color", &surface.specular_color, None, "specular colour");
        }
        if surface.transmission != Scalar::new(0.0) {
            self.scalar("transmission_weight", &surface.transmission, None, "transmission");
        }
        self.scalar("coat_weight", &surface.coat, None, "coat");
        self.scalar("coat_roughness", &surface.coat_roughness, None, "roughness of the coat");
        if surface.coat.factor > 0.0 {
            self.out.push(Property::new("inputs:coat_ior", single(surface.coat_ior)));
            // What lies below is as bright as without.
            self.out.push(Property::new("inputs:coat_darkening", single(0.0)));
            if surface.coat_color != Colour::new([1.0; 3]) {
                self.colour("coat_color", &surface.coat_color, None, "colour of the coat");
            }
        }
        if surface.sheen_color != Colour::new([0.0; 3]) {
            self.out.push(Property::new("inputs:fuzz_weight", single(1.0)));
            self.colour("fuzz_color", &surface.sheen_color, None, "sheen");
        }
        self.scalar("fuzz_roughness", &surface.sheen_roughness, None, "roughness of the sheen");
        if let Some((input, strength)) = &surface.normal {
            self.normal("geometry_normal", input, *strength);
        }
        if surface.coat.factor > 0.0 {
            match (&surface.coat_normal, &surface.normal) {
                (CoatNormal::Map(input, strength), _) | (CoatNormal::Base, Some((input, strength))) => {
                    self.normal("geometry_coat_normal", input, *strength);
                }
                (CoatNormal::Base, None) | (CoatNormal::Smooth, _) => {}
            }
        }
        if let Some(film) = &surface.film {
            self.scalar("thin_film_weight", &film.weight, None, "film");
            self.out.push(Property::new("inputs:thin_film_ior", single(film.ior)));
            // In micrometres there.
            let factor = film.thickness_nm.factor / 1000.0;
            let thickness = Scalar { factor, ..film.thickness_nm.clone() };
            self.scalar("thin_film_thickness", &thickness, None, "thickness of the film");
        }
        if let Some(alpha) = through(surface) {
            let paint = (surface.vertex_colors && self.network.vertices == Some(true))
                .then(|| self.vertices("displayOpacity", "float"));
            self.scalar("geometry_opacity", alpha, paint, "opacity");
        }
    }

    /// Roughness, and facets longer one way, by the law of OpenPBR whatever theirs is.
    fn roughness(&mut self, surface: &StandardSurface) {
        let Some(anisotropy) = &surface.anisotropy else {
            self.scalar("specular_roughness", &surface.roughness, None, "roughness");
            return;
        };
        if anisotropy.rotation_rad != 0.0 || anisotropy.direction.is_some() {
            self.network.warn("anisotropy", "its direction is not written: it is that of the texture coordinates");
        }
        if anisotropy.law == AnisotropyLaw::OpenPbr {
            self.scalar("specular_roughness", &surface.roughness, None, "roughness");
            self.scalar("specular_roughness_anisotropy", &anisotropy.strength, None, "anisotropy");
            return;
        }
        if surface.roughness.texture.is_some() || anisotropy.strength.texture.is_some() {
            self.network.warn("anisotropy", "pictures of it mean other facets in OpenPBR: not written");
            self.scalar("specular_roughness", &surface.roughness, None, "roughness");
            return;
        }
        let alpha = surface.roughness.factor * surface.roughness.factor;
        let [along, across] = anisotropy.law.alphas(alpha, anisotropy.strength.factor);
        let ratio = across / along;
        let mean = along * ((1.0 + ratio * ratio) / 2.0).sqrt();
        self.out.push(Property::new("inputs:specular_roughness", single(mean.sqrt())));
        self.out.push(Property::new("inputs:specular_roughness_anisotropy", single(1.0 - ratio)));
    }

    fn optics(&mut self, surface: &StandardSurface, optics: &Optics) {
        let mut number = |name: &str, x: f64| self.out.push(Property::new(format!("inputs:{name}"), single(x)));
        if let Some((depth, color)) = optics.attenuation {
            number("transmission_depth", depth);
            self.out.push(Property::new("inputs:transmission_color", triple(color)).typed("color3f"));
        }
        let mut number = |name: &str, x: f64| self.out.push(Property::new(format!("inputs:{name}"), single(x)));
        if let Some(dispersion) = optics.dispersion {
            number("transmission_dispersion_scale", 1.0);
            number("transmission_dispersion_abbe_number", 20.0 / dispersion);
        }
        if let Some((n, thickness_nm)) = optics.film.filter(|_| surface.film.is_none()) {
            number("thin_film_weight", 1.0);
            number("thin_film_ior", n);
            number("thin_film_thickness", thickness_nm / 1000.0);
        }
        if surface.transmission != Scalar::new(0.0) && !optics.solid {
            self.out.push(Property::new("inputs:geometry_thin_walled", Datum::Bool(true)));
        }
        if let Some(glow) = optics.glow {
            // The colour from 0 to 1, how strong it is in the luminance.
            let most = glow.iter().copied().fold(0.0, f64::max);
            let color = glow.map(|lane| lane / most);
            let nit = luminance(glow) / luminance(color);
            self.out.push(Property::new("inputs:emission_luminance", single(nit)));
            let color = Colour { factor: color, texture: surface.emission.clone() };
            self.colour("emission_color", &color, None, "emission");
        }
    }

    /// The colours or alphas of the mesh's vertices.
    fn vertices(&mut self, name: &str, ty: &'static str) -> Output {
        let inputs = vec![
            ("geomprop", "string", Source::Value(Datum::Text(name.to_owned()))),
            ("default", usd_type(ty), Source::Value(all(ty, [1.0; 4]))),
        ];
        self.network.node(name, &format!("ND_geompropvalue_{ty}"), inputs, ("out", usd_type(ty)))
    }

    fn colour(&mut self, name: &str, colour: &Colour, paint: Option<Output>, what: &str) {
        let name = format!("inputs:{name}");
        let mut found = match &colour.texture {
            None => None,
            Some(input) if input.channels[..3] == Channel::ALL[..3] => self.image(input, "color3", what),
            Some(input) => self.combined(input, what),
        };
        if let (Some(output), Some(input)) = (&found, &colour.texture) {
            let [scale, bias] = [input.scale, input.bias].map(|four| [0, 1, 2].map(|i| four[i] * colour.factor[i]));
            found = Some(self.line(output.clone(), "color3", (scale, bias)));
        }
        self.put(&name, "color3", (triple(colour.factor), colour.factor == [1.0; 3]), [found, paint]);
    }

    fn scalar(&mut self, name: &str, scalar: &Scalar, paint: Option<Output>, what: &str) {
        let name = format!("inputs:{name}");
        let found = scalar.texture.as_ref().and_then(|(input, channel)| {
            let output = self.lane(input, channel.pick(input.channels), what)?;
            let by = scalar.factor;
            let (scale, bias) = (channel.of(input.scale) * by, channel.of(input.bias) * by);
            Some(self.line(output, "float", ([scale; 3], [bias; 3])))
        });
        self.put(&name, "float", (single(scalar.factor), scalar.factor == 1.0), [found, paint]);
    }

    /// An input: a picture, which has the factor already, or the factor, times what the vertices have.
    fn put(&mut self, name: &str, ty: &'static str, (factor, is_one): (Datum, bool), by: [Option<Output>; 2]) {
        let property = match by {
            [None, None] => Property::new(name, factor).typed(usd_type(ty)),
            [Some(only), None] => Property::connected(name, usd_type(ty), only),
            [None, Some(paint)] if is_one => Property::connected(name, usd_type(ty), paint),
            [None, Some(paint)] => {
                Property::connected(name, usd_type(ty), self.times(paint, Source::Value(factor), ty))
            }
            [Some(picture), Some(paint)] => {
                Property::connected(name, usd_type(ty), self.times(picture, Source::Node(paint), ty))
            }
        };
        self.out.push(property);
    }

    /// A colour of a picture's channels in another order.
    fn combined(&mut self, input: &TextureInput, what: &str) -> Option<Output> {
        let [r, g, b, _] = input.channels;
        let mut inputs = Vec::new();
        for (name, channel) in [("in1", r), ("in2", g), ("in3", b)] {
            inputs.push((name, "float", Source::Node(self.lane(input, channel, what)?)));
        }
        Some(self.network.node("Colour", "ND_combine3_color3", inputs, ("out", "color3f")))
    }

    /// One number of a picture.
    fn lane(&mut self, input: &TextureInput, channel: Channel, what: &str) -> Option<Output> {
        // Alpha is no colour, whatever the rest is.
        let ty = match (channel, input.encoding) {
            (Channel::Alpha, _) => "vector4",
            (Channel::Red | Channel::Green | Channel::Blue, Encoding::Srgb | Encoding::OfFile) => "color3",
            (Channel::Red | Channel::Green | Channel::Blue, Encoding::Linear) => "vector3",
        };
        let index = match channel {
            Channel::Red => 0,
            Channel::Green => 1,
            Channel::Blue => 2,
            Channel::Alpha => 3,
        };
        let image = self.image(input, ty, what)?;
        let inputs =
            vec![("in", usd_type(ty), Source::Node(image)), ("index", "int", Source::Value(Datum::Int(index)))];
        Some(self.network.node("Channel", &format!("ND_extract_{ty}"), inputs, ("out", "float")))
    }

    /// `normalmap` makes 2 · texel − 1 of its input and stretches x and y.
    fn normal(&mut self, name: &str, input: &TextureInput, strength: f64) {
        let Some(image) = self.image(input, "vector3", "normal") else { return };
        let lanes = [0, 1, 2];
        let texel = lanes.map(|i| input.scale[i] / 2.0);
        let moved = lanes.map(|i| (input.bias[i] + 1.0) / 2.0);
        let texels = self.line(image, "vector3", (texel, moved));
        let mut inputs = vec![("in", "float3", Source::Node(texels))];
        if strength != 1.0 {
            inputs.push(("scale", "float", Source::Value(single(strength))));
        }
        let output = self.network.node("Normal", "ND_normalmap_float", inputs, ("out", "float3"));
        self.out.push(Property::connected(format!("inputs:{name}"), "float3", output));
    }

    /// output · scale + bias.
    fn line(&mut self, output: Output, ty: &'static str, (scale, bias): ([f64; 3], [f64; 3])) -> Output {
        let lanes = if ty == "float" { 1 } else { 3 };
        let is = |list: [f64; 3], x: f64| list.iter().take(lanes).all(|own| *own == x);
        let mut output = output;
        let four = |[r, g, b]: [f64; 3]| [r, g, b, 0.0];
        if !is(scale, 1.0) {
            output = self.times(output, Source::Value(all(ty, four(scale))), ty);
        }
        if !is(bias, 0.0) {
            let by = Source::Value(all(ty, four(bias)));
            let inputs = vec![("in1", usd_type(ty), Source::Node(output)), ("in2", usd_type(ty), by)];
            output = self.network.node("Sum", &format!("ND_add_{ty}"), inputs, ("out", usd_type(ty)));
        }
        output
    }

    fn times(&mut self, output: Output, by: Source, ty: &'static str) -> Output {
        let inputs = vec![("in1", usd_type(ty), Source::Node(output)), ("in2", usd_type(ty), by)];
        self.network.node("Product", &format!("ND_multiply_{ty}"), inputs, ("out", usd_type(ty)))
    }

    /// A picture as it is.
    fn image(&mut self, input: &TextureInput, ty: &'static str, what: &str) -> Option<Output> {
        let file = self.network.file(input, what)?;
        let mut prim = Prim::def(3, "Shader", "");
        prim.push(Property::new("info:id", Datum::Token(format!("ND_image_{ty}"))).uniform());
        let mut file = Property::new("inputs:file", Datum::Asset(file));
        file.color_space = match (ty, input.encoding) {
            ("color3", Encoding::Srgb) => Some("srgb_texture"),
            ("color3", Encoding::Linear) => Some("lin_rec709"),
            // What the file says.
            ("color3", Encoding::OfFile) => None,
            _ => Some("raw"),
        };
        prim.push(file);
        let texcoord = self.coordinates(input);
        prim.push(Property::connected("inputs:texcoord", "float2", texcoord));
        for (name, wrap) in ["uaddressmode", "vaddressmode"].into_iter().zip(input.wrap) {
            let word = match wrap {
                Wrap::Repeat => "periodic",
                Wrap::Mirror => "mirror",
                Wrap::Clamp => "clamp",
                Wrap::Black => "constant",
            };
            prim.push(Property::new(format!("inputs:{name}"), Datum::Text(word.to_owned())));
        }
        match input.filter {
            Filter::Linear => {}
            Filter::Nearest => prim.push(Property::new("inputs:filtertype", Datum::Text("closest".to_owned()))),
        }
        prim.push(Property::declared("outputs:out", usd_type(ty)));
        Some(self.network.add("Image", prim, "out"))
    }

    /// The texture coordinates of a picture: scaled, turned, moved.
    fn coordinates(&mut self, input: &TextureInput) -> Output {
        let name = set_name(input.set);
        let inputs = vec![("geomprop", "string", Source::Value(Datum::Text(name.to_owned())))];
        let mut st =
            self.network.node(&format!("Coordinates_{name}"), "ND_geompropvalue_vector2", inputs, ("out", "float2"));
        let placed = self.network.placed(input, "texture coordinates");
        let two = |st: Output, by: [f64; 2]| {
            vec![("in1", "float2", Source::Node(st)), ("in2", "float2", Source::Value(pair(by)))]
        };
        if placed.scale != [1.0; 2] {
            st = self.network.node("Scaled", "ND_multiply_vector2", two(st, placed.scale), ("out", "float2"));
        }
        if placed.turn_deg != 0.0 {
            // A positive amount turns the coordinates with the clock.
            let inputs =
                vec![("in", "float2", Source::Node(st)), ("amount", "float", Source::Value(single(-placed.turn_deg)))];
            st = self.network.node("Turned", "ND_rotate2d_vector2", inputs, ("out", "float2"));
        }
        if placed.shift != [0.0; 2] {
            st = self.network.node("Moved", "ND_add_vector2", two(st, placed.shift), ("out", "float2"));
        }
        st
    }
}

/// The USD type of one of MaterialX.
fn usd_type(ty: &str) -> &'static str {
    match ty {
        "color3" => "color3f",
        "vector2" => "float2",
        "vector3" => "float3",
        "vector4" => "float4",
        _ => "float",
    }
}

/// A constant of a MaterialX type of one or three numbers.
fn all(ty: &str, [r, g, b, _]: [f64; 4]) -> Datum {
    if ty == "float" { single(r) } else { triple([r, g, b]) }
}
