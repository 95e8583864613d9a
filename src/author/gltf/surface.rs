//! How a material looks, as glTF's metallic-roughness model with the extensions that add layers to it: what
//! `import::gltf::standard` reads, the other way round. Sources: glTF 2.0, sections 3.9 and 5.19 to 5.24, and the extensions'
//! own pages.

use super::document::Document;
use super::texture::Reading;
use super::value;
use eyebox_scene::assembly::{Assembly, Material};
use eyebox_scene::texture::Channel;
use eyebox_scene::value::{Data, Value};
use eyebox_scene::{
    Anisotropy, AnisotropyLaw, CoatNormal, Colour, Film, Opacity, Scalar, StandardSurface, TextureInput,
};
use serde_json::{Map, Value as Json, json};

/// One material on its way into a document.
pub struct Looks<'a> {
    pub document: &'a mut Document,
    pub assembly: &'a Assembly,
    pub material: &'a Material,
    pub index: usize,
}

/// The fields of the material, and its extensions.
pub type Fields = Map<String, Json>;

impl Looks<'_> {
    /// Says all of `surface` but what the material's own fields have said already: index and transmission.
    pub fn write(&mut self, surface: &StandardSurface, out: &mut Fields, extensions: &mut Fields) {
        if self.is_glossy(surface) {
            let layer = self.specular_glossiness(surface);
            self.extend(extensions, "KHR_materials_pbrSpecularGlossiness", layer);
        } else {
            let pbr = self.metallic_roughness(surface);
            if !pbr.is_empty() {
                out.insert("pbrMetallicRoughness".into(), Json::Object(pbr));
            }
        }
        if let Some((input, strength)) = &surface.normal {
            out.extend(self.normal_texture(input, *strength).map(|texture| ("normalTexture".to_owned(), texture)));
        }
        match &surface.opacity {
            Opacity::Opaque => {}
            Opacity::Mask { cutoff, .. } => {
                out.insert("alphaMode".into(), Json::from("MASK"));
                if *cutoff != 0.5 {
                    out.insert("alphaCutoff".into(), value::number(*cutoff).unwrap_or_default());
                }
            }
            Opacity::Blend { .. } => drop(out.insert("alphaMode".into(), Json::from("BLEND"))),
        }
        if let Some(input) = &surface.emission {
            let colour = Colour { factor: [1.0; 3], texture: Some(input.clone()) };
            let (factor, texture) = self.colour(&colour, "emission", f64::INFINITY);
            out.extend(texture.map(|texture| ("emissiveTexture".to_owned(), texture)));
            if factor != [1.0; 3] {
                self.glow(factor, out, extensions);
            }
        }
        let unlit = |(key, value): &(String, Value)| key == "unlit" && matches!(value.data, Data::Bool(true));
        if self.material.looks.iter().any(unlit) {
            // No other layer may stand beside it.
            self.extend(extensions, "KHR_materials_unlit", Fields::new());
            return;
        }
        if !self.is_glossy(surface) {
            self.index_of_refraction(surface, extensions);
            self.specular(surface, extensions);
        }
        self.layers(surface, extensions);
    }

    /// Multiplies what the material emits: a factor of 0 to 1, the rest in the strength.
    fn glow(&mut self, by: [f64; 3], out: &mut Fields, extensions: &mut Fields) {
        const NAME: &str = "KHR_materials_emissive_strength";
        let Some(old) = out.get("emissiveFactor").and_then(Json::as_array) else { return };
        let old: Vec<f64> = old.iter().filter_map(Json::as_f64).collect();
        let [r, g, b] = old[..] else { return };
        let new = [r * by[0], g * by[1], b * by[2]];
        let most = new.iter().copied().fold(0.0, f64::max);
        if most > 0.0 {
            let strength = extensions.get(NAME).and_then(|own| own.get("emissiveStrength")).and_then(Json::as_f64);
            let strength = value::number(strength.unwrap_or(1.0) * most).unwrap_or_default();
            out.insert("emissiveFactor".into(), numbers(&new.map(|lane| lane / most)));
            self.extend(extensions, NAME, Fields::from_iter([("emissiveStrength".to_owned(), strength)]));
        } else {
            out.insert("emissiveFactor".into(), numbers(&[0.0; 3]));
        }
    }

    fn metallic_roughness(&mut self, surface: &StandardSurface) -> Fields {
        let mut pbr = Fields::new();
        let (colour, alpha, texture) = self.base(surface);
        let [r, g, b] = colour;
        if [r, g, b, alpha] != [1.0; 4] {
            pbr.insert("baseColorFactor".into(), numbers(&[r, g, b, alpha]));
        }
        pbr.extend(texture.map(|texture| ("baseColorTexture".to_owned(), texture)));
        let (metallic, roughness, texture) = self.both(surface);
        for (key, factor) in [("metallicFactor", metallic), ("roughnessFactor", roughness)] {
            if factor != 1.0 {
                pbr.insert(key.into(), value::number(factor).unwrap_or_default());
            }
        }
        pbr.extend(texture.map(|texture| ("metallicRoughnessTexture".to_owned(), texture)));
        pbr
    }

    /// Colour and alpha of the base, which are of one texture.
    fn base(&mut self, surface: &StandardSurface) -> ([f64; 3], f64, Option<Json>) {
        let (colour, texture) = self.colour(&surface.base_color, "base colour", 1.0);
        let alpha = match &surface.opacity {
            Opacity::Opaque => return (colour, 1.0, texture),
            Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => alpha,
        };
        let picture = surface.base_color.texture.as_ref().filter(|_| texture.is_some());
        let factor = match (&alpha.texture, picture) {
            (None, None) => alpha.factor,
            (None, Some(input)) => {
                if self.document.may_have_alpha(input) {
                    self.warn("opacity", "the alpha of the base colour's picture multiplies it in glTF");
                }
                alpha.factor
            }
            (Some((own, Channel::Alpha)), Some(input))
                if same_texels(own, input) && own.channels[3] == Channel::Alpha && own.bias[3] == 0.0 =>
            {
                alpha.factor * own.scale[3]
            }
            (Some((own, channel)), _) => {
                let why = "it is not the alpha of the base colour's, which glTF wants";
                let mean = self.mean_for(own, channel.pick(own.channels), "opacity", why);
                alpha.factor * (mean * channel.of(own.scale) + channel.of(own.bias))
            }
        };
        (colour, self.within(factor, "opacity", 1.0), texture)
    }

    /// Metallic and roughness, which are two channels of one texture: where they have two, or one of them a number, its mean
    /// stands for a picture.
    fn both(&mut self, surface: &StandardSurface) -> (f64, f64, Option<Json>) {
        let (mut metallic, mut of_metal) = self.read(&surface.metallic, Channel::Blue, "metallic");
        let (mut roughness, mut of_roughness) = self.read(&surface.roughness, Channel::Green, "roughness");
        let together = of_metal.zip(of_roughness).is_some_and(|(one, other)| same_place(one, other));
        // A number of 0 leaves the channel to the other.
        if let Some(input) = of_metal.filter(|_| !together && (of_roughness.is_some() || roughness != 0.0)) {
            metallic *=
                self.mean_for(input, Channel::Blue, "metallic", "glTF has one picture for it and the roughness");
            of_metal = None;
        }
        if let Some(input) = of_roughness.filter(|_| !together && (of_metal.is_some() || metallic != 0.0)) {
            roughness *=
                self.mean_for(input, Channel::Green, "roughness", "glTF has one picture for it and the metallic");
            of_roughness = None;
        }
        let texture = of_metal.or(of_roughness).and_then(|input| self.texture(input, "metallic and roughness"));
        (metallic, roughness, texture)
    }

    /// The mean of a picture that is not written, with a note.
    fn mean_for(&mut self, input: &TextureInput, channel: Channel, what: &str, why: &str) -> f64 {
        let mean = self.document.mean(input, channel);
        let name = &input.texture.name;
        self.warn(what, &format!("its picture `{name}` is not written: {why}; its mean, {mean:.3}, stands for it"));
        mean
    }

    fn index_of_refraction(&mut self, surface: &StandardSurface, extensions: &mut Fields) {
        const NAME: &str = "KHR_materials_ior";
        if extensions.contains_key(NAME) && surface.ior.is_finite() || surface.ior == 1.5 {
            return;
        }
        // An infinite index is 0 there.
        let ior = value::number(if surface.ior.is_finite() { surface.ior } else { 0.0 });
        self.extend(extensions, NAME, Fields::from_iter([("ior".to_owned(), ior.unwrap_or_default())]));
    }

    fn specular(&mut self, surface: &StandardSurface, extensions: &mut Fields) {
        let mut layer = Fields::new();
        let scalar = (&surface.specular, Channel::Alpha, "specular");
        self.put_scalar(&mut layer, scalar, ["specularFactor", "specularTexture"], 1.0);
        let colour = (&surface.specular_color, "specular colour", f64::INFINITY);
        self.put_colour(&mut layer, colour, ["specularColorFactor", "specularColorTexture"], [1.0; 3]);
        self.extend_said(extensions, "KHR_materials_specular", layer);
    }

    fn layers(&mut self, surface: &StandardSurface, extensions: &mut Fields) {
        let mut layer = Fields::new();
        let scalar = (&surface.transmission, Channel::Red, "transmission");
        self.put_scalar(&mut layer, scalar, ["transmissionFactor", "transmissionTexture"], 0.0);
        if extensions.get("KHR_materials_transmission").is_some_and(|own| own.get("transmissionFactor").is_some()) {
            layer.remove("transmissionFactor");
        }
        self.extend_said(extensions, "KHR_materials_transmission", layer);

        let mut layer = Fields::new();
        let scalar = (&surface.diffuse_transmission, Channel::Alpha, "diffuse transmission");
        self.put_scalar(&mut layer, scalar, ["diffuseTransmissionFactor", "diffuseTransmissionTexture"], 0.0);
        let colour = (&surface.diffuse_transmission_color, "colour of diffuse transmission", 1.0);
        let keys = ["diffuseTransmissionColorFactor", "diffuseTransmissionColorTexture"];
        self.put_colour(&mut layer, colour, keys, [1.0; 3]);
        self.extend_said(extensions, "KHR_materials_diffuse_transmission", layer);

        let mut layer = Fields::new();
        self.put_scalar(
            &mut layer,
            (&surface.coat, Channel::Red, "coat"),
            ["clearcoatFactor", "clearcoatTexture"],
            0.0,
        );
        let scalar = (&surface.coat_roughness, Channel::Green, "roughness of the coat");
        self.put_scalar(&mut layer, scalar, ["clearcoatRoughnessFactor", "clearcoatRoughnessTexture"], 0.0);
        let own = match &surface.coat_normal {
            CoatNormal::Map(input, strength) => Some((input, *strength)),
            // glTF's coat is smooth where nothing is said.
            CoatNormal::Base => surface.normal.as_ref().map(|(input, strength)| (input, *strength)),
            CoatNormal::Smooth => None,
        };
        if let Some((input, strength)) = own.filter(|_| surface.coat.factor > 0.0) {
            let texture = self.normal_texture(input, strength);
            layer.extend(texture.map(|texture| ("clearcoatNormalTexture".to_owned(), texture)));
        }
        self.extend_said(extensions, "KHR_materials_clearcoat", layer);
        if surface.coat.factor > 0.0 && (surface.coat_ior != 1.5 || surface.coat_color != Colour::new([1.0; 3])) {
            self.warn("coat", "its colour and its index have no form in glTF: it is clear, of index 1.5");
        }

        let mut layer = Fields::new();
        let colour = (&surface.sheen_color, "sheen", 1.0);
        self.put_colour(&mut layer, colour, ["sheenColorFactor", "sheenColorTexture"], [0.0; 3]);
        let scalar = (&surface.sheen_roughness, Channel::Alpha, "roughness of the sheen");
        self.put_scalar(&mut layer, scalar, ["sheenRoughnessFactor", "sheenRoughnessTexture"], 0.0);
        self.extend_said(extensions, "KHR_materials_sheen", layer);

        self.anisotropy(surface, extensions);
        self.film(surface, extensions);
        if surface.diffuse_roughness.factor > 0.0 {
            self.warn("roughness of the diffuse base", "glTF's diffuse base scatters as Lambert says: not written");
        }
        const WHITE: Colour = Colour::new([1.0; 3]);
        if surface.metallic.factor > 0.0 && surface.metal_edge != WHITE {
            self.warn(
                "edge of the metal",
                "glTF's metals have no colour of their own at grazing incidence: not written",
            );
        }
    }

    /// `KHR_materials_anisotropy`.
    fn anisotropy(&mut self, surface: &StandardSurface, extensions: &mut Fields) {
        let Some(Anisotropy { strength, law, rotation_rad, direction }) = &surface.anisotropy else { return };
        match law {
            AnisotropyLaw::Gltf => {}
            AnisotropyLaw::OpenPbr | AnisotropyLaw::MaterialX => {
                self.warn("anisotropy", "its strength means other facets in glTF: not written");
                return;
            }
        }
        let mut layer = Fields::new();
        let mut put = |key: &str, number: f64| layer.insert(key.into(), value::number(number).unwrap_or_default());
        put("anisotropyStrength", strength.factor);
        if *rotation_rad != 0.0 {
            put("anisotropyRotation", *rotation_rad);
        }
        let own = strength.texture.as_ref().filter(|(_, channel)| *channel == Channel::Blue).map(|(input, _)| input);
        if let (Some(own), Some(_)) = (own, direction) {
            layer.extend(self.texture(own, "anisotropy").map(|texture| ("anisotropyTexture".to_owned(), texture)));
        } else if strength.texture.is_some() || direction.is_some() {
            self.warn(
                "anisotropy",
                "its picture is not that of glTF, red and green direction, blue strength: not written",
            );
        }
        self.extend(extensions, "KHR_materials_anisotropy", layer);
    }

    /// `KHR_materials_iridescence`.
    fn film(&mut self, surface: &StandardSurface, extensions: &mut Fields) {
        let Some(Film { weight, ior, thickness_nm }) = &surface.film else { return };
        let mut layer = Fields::new();
        let scalar = (weight, Channel::Red, "film");
        self.put_scalar(&mut layer, scalar, ["iridescenceFactor", "iridescenceTexture"], 0.0);
        let ends = match &thickness_nm.texture {
            None => [thickness_nm.factor; 2],
            Some((input, channel)) => {
                if *channel == Channel::Green {
                    let texture = self.texture(input, "thickness of the film");
                    layer.extend(texture.map(|texture| ("iridescenceThicknessTexture".to_owned(), texture)));
                } else {
                    self.warn("thickness of the film", "its picture is not read in green, as glTF has it: not written");
                }
                let least = channel.of(input.bias);
                [least, least + channel.of(input.scale)].map(|end| end * thickness_nm.factor)
            }
        };
        let mut put = |key: &str, number: f64| layer.insert(key.into(), value::number(number).unwrap_or_default());
        put("iridescenceIor", *ior);
        put("iridescenceThicknessMinimum", ends[0]);
        put("iridescenceThicknessMaximum", ends[1]);
        self.extend(extensions, "KHR_materials_iridescence", layer);
    }

    /// Whether the surface is one of the older model, whose gloss is the alpha of its specular picture.
    fn is_glossy(&self, surface: &StandardSurface) -> bool {
        let gloss = surface.roughness.texture.as_ref().filter(|(input, channel)| {
            let alpha = *channel == Channel::Alpha && input.channels == Channel::ALL;
            alpha && input.scale[3] <= 0.0 && input.bias[3] == 1.0 && surface.roughness.factor == 1.0
        });
        let shown = surface.specular_color.texture.as_ref();
        surface.ior == f64::INFINITY && gloss.zip(shown).is_some_and(|((gloss, _), shown)| same_place(gloss, shown))
    }

    /// `KHR_materials_pbrSpecularGlossiness`: roughness = 1 − factor · texel.
    fn specular_glossiness(&mut self, surface: &StandardSurface) -> Fields {
        let mut out = Fields::new();
        let (colour, alpha, texture) = self.base(surface);
        let [r, g, b] = colour;
        if [r, g, b, alpha] != [1.0; 4] {
            out.insert("diffuseFactor".into(), numbers(&[r, g, b, alpha]));
        }
        out.extend(texture.map(|texture| ("diffuseTexture".to_owned(), texture)));
        let (factor, texture) = self.colour(&surface.specular_color, "specular colour", 1.0);
        if factor != [1.0; 3] {
            out.insert("specularFactor".into(), numbers(&factor));
        }
        out.extend(texture.map(|texture| ("specularGlossinessTexture".to_owned(), texture)));
        let gloss = surface.roughness.texture.as_ref().map_or(1.0, |(input, _)| -input.scale[3]);
        let gloss = self.within(gloss, "glossiness", 1.0);
        if gloss != 1.0 {
            out.insert("glossinessFactor".into(), value::number(gloss).unwrap_or_default());
        }
        out
    }

    fn put_scalar(
        &mut self,
        layer: &mut Fields,
        (scalar, channel, what): (&Scalar, Channel, &str),
        [factor_key, texture_key]: [&str; 2],
        unsaid: f64,
    ) {
        let (factor, input) = self.read(scalar, channel, what);
        let texture = input.and_then(|input| self.texture(input, what));
        if factor != unsaid {
            layer.insert(factor_key.into(), value::number(factor).unwrap_or_default());
        }
        layer.extend(texture.map(|texture| (texture_key.to_owned(), texture)));
    }

    fn put_colour(
        &mut self,
        layer: &mut Fields,
        (colour, what, most): (&Colour, &str, f64),
        [factor_key, texture_key]: [&str; 2],
        unsaid: [f64; 3],
    ) {
        let (factor, texture) = self.colour(colour, what, most);
        if factor != unsaid {
            layer.insert(factor_key.into(), numbers(&factor));
        }
        layer.extend(texture.map(|texture| (texture_key.to_owned(), texture)));
    }

    /// A number's factor, and its picture if it is what glTF wants: the one channel, as it is but for a factor.
    fn read<'s>(&mut self, scalar: &'s Scalar, channel: Channel, what: &str) -> (f64, Option<&'s TextureInput>) {
        let Some((input, own)) = &scalar.texture else { return (self.within(scalar.factor, what, 1.0), None) };
        // A texel's component that is scaled and moved as `own`.
        let component = own.pick(input.channels);
        let colours = [component, channel].iter().all(|channel| *channel != Channel::Alpha);
        let same = component == channel || colours && self.document.is_grey(input);
        let why = if !same {
            format!("from its {} channel; glTF reads {}", name(component), name(channel))
        } else if own.of(input.bias) != 0.0 {
            "with a bias, which glTF has not".to_owned()
        } else if channel != Channel::Alpha && self.document.is_srgb(input) {
            "with the curve of sRGB, which glTF does not apply there".to_owned()
        } else {
            return (self.within(scalar.factor * own.of(input.scale), what, 1.0), Some(input));
        };
        let mean = self.mean_for(input, component, what, &format!("it is read {why}"));
        let (scale, bias) = (own.of(input.scale), own.of(input.bias));
        (self.within(scalar.factor * (mean * scale + bias), what, 1.0), None)
    }

    fn colour(&mut self, colour: &Colour, what: &str, most: f64) -> ([f64; 3], Option<Json>) {
        let mut factor = colour.factor;
        let input = colour.texture.as_ref().filter(|input| {
            if !self.document.may_hold(input) {
                // It is said where it would be written.
                return true;
            }
            let [r, g, b, _] = input.bias;
            let swapped = input.channels[..3] != Channel::ALL[..3] && !self.document.is_grey(input);
            let why = if [r, g, b] != [0.0; 3] {
                "with a bias, which glTF has not"
            } else if swapped {
                "with its channels in another order, which glTF has not"
            } else if !self.document.is_srgb(input) {
                "without the curve of sRGB, which glTF applies there"
            } else {
                return true;
            };
            self.warn(what, &format!("its picture `{}` is read {why}: not written", input.texture.name));
            false
        });
        if let Some(input) = input {
            let [r, g, b, _] = input.scale;
            factor = [factor[0] * r, factor[1] * g, factor[2] * b];
        }
        let texture = input.and_then(|input| self.texture(input, what));
        if factor.iter().any(|lane| !(0.0..=most).contains(lane)) {
            self.warn(what, &format!("the factor {factor:?} is beyond the {} of glTF: brought there", range(most)));
            factor = factor.map(|lane| if lane.is_nan() { 0.0 } else { lane.clamp(0.0, most.min(f64::MAX)) });
        }
        (factor, texture)
    }

    /// A normal map, and by how much it stretches x and y itself.
    fn normal_texture(&mut self, input: &TextureInput, strength: f64) -> Option<Json> {
        let ([r, g, b, _], [x, y, z, _]) = (input.scale, input.bias);
        let plain = r == g && b == 2.0 && x == y && z == -1.0 && r == -2.0 * x && input.channels == Channel::ALL;
        if !plain || self.document.is_srgb(input) {
            let what = format!("its picture `{}` is not 2 · texel − 1: not written", input.texture.name);
            self.warn("normal", &what);
            return None;
        }
        let mut texture = self.texture(input, "normal")?;
        let scale = strength * (r / 2.0);
        if scale != 1.0 {
            texture["scale"] = value::number(scale).unwrap_or_default();
        }
        Some(texture)
    }

    fn texture(&mut self, input: &TextureInput, what: &str) -> Option<Json> {
        let what = format!("material `{}`, {what}", self.material.name);
        let reading = Reading { assembly: self.assembly, material: self.index, at: &self.material.at, what: &what };
        self.document.texture(input, reading)
    }

    /// A factor of 0 to `most`, with a note where it was not.
    fn within(&mut self, factor: f64, what: &str, most: f64) -> f64 {
        if (0.0..=most).contains(&factor) {
            return factor;
        }
        self.warn(what, &format!("the factor {factor} is beyond the {} of glTF: brought there", range(most)));
        if factor.is_nan() { 0.0 } else { factor.clamp(0.0, most) }
    }

    fn warn(&mut self, what: &str, text: &str) {
        let text = format!("material `{}`, {what}: {text}", self.material.name);
        self.document.note(&self.material.at, text);
    }

    fn extend(&mut self, extensions: &mut Fields, name: &str, layer: Fields) {
        self.document.uses(name);
        let entry = extensions.entry(name).or_insert_with(|| json!({}));
        if let Some(entry) = entry.as_object_mut() {
            entry.extend(layer);
        }
    }

    /// The same, unless the layer says nothing.
    fn extend_said(&mut self, extensions: &mut Fields, name: &str, layer: Fields) {
        if !layer.is_empty() {
            self.extend(extensions, name, layer);
        }
    }
}

/// Whether two parameters read the same texels.
fn same_place(a: &TextureInput, b: &TextureInput) -> bool {
    a.encoding == b.encoding && same_texels(a, b)
}

/// The same, whatever curve their colours have: alpha has none.
fn same_texels(a: &TextureInput, b: &TextureInput) -> bool {
    a.texture.texels == b.texture.texels
        && a.wrap == b.wrap
        && a.filter == b.filter
        && a.set == b.set
        && a.to_picture == b.to_picture
}

fn numbers(lanes: &[f64]) -> Json {
    lanes.iter().map(|lane| value::number(*lane).unwrap_or_default()).collect()
}

fn range(most: f64) -> String {
    if most.is_finite() { format!("0 to {most}") } else { "numbers from 0".to_owned() }
}

fn name(channel: Channel) -> &'static str {
    match channel {
        Channel::Red => "red",
        Channel::Green => "green",
        Channel::Blue => "blue",
        Channel::Alpha => "alpha",
    }
}
