//! What an assembly says of its looks, whatever the format says it in: factors and scales of pictures are one number, texture
//! coordinates are where in the picture a corner is.

use eyebox::base::package;
use eyebox::import::Assembly;
use eyebox::scene::texture::{Channel, PictureSource, Texels};
use eyebox::scene::{Colour, Opacity, Scalar, StandardSurface, TextureInput};

/// Names, and numbers that may be off by a rounding.
pub type Said = Vec<(String, Vec<f64>)>;

pub fn assert_same(wanted: &Said, found: &Said, what: &str) {
    let labels =
        |said: &Said| said.iter().map(|(label, numbers)| format!("{label} {}", numbers.len())).collect::<Vec<_>>();
    assert_eq!(labels(wanted), labels(found), "{what}");
    for ((label, a), (_, b)) in wanted.iter().zip(found) {
        let off = a.iter().zip(b).any(|(a, b)| (a - b).abs() > 2e-6 * a.abs().max(1.0));
        assert!(!off, "{what}: {label}\n{a:?}\n{b:?}");
    }
}

pub fn said(assembly: &Assembly) -> Said {
    let mut out = Said::new();
    for (index, material) in assembly.materials.iter().enumerate() {
        let mut mapped: Vec<_> = material.mapped.iter().map(|(key, value)| format!("{key} {value}")).collect();
        mapped.sort();
        // Which of them is the tint of a picture, and which the light's colour, is not said.
        mapped.retain(|row| !row.starts_with("luminance") && !row.starts_with("emitter"));
        out.push((format!("{} {mapped:?}", material.name), Vec::new()));
        let surface = material.surface.as_ref().expect("a surface");
        let mut saying = Saying { assembly, index, out: &mut out };
        saying.surface(surface);
        saying.emission(surface);
    }
    out
}

struct Saying<'a> {
    assembly: &'a Assembly,
    index: usize,
    out: &'a mut Said,
}

impl Saying<'_> {
    fn surface(&mut self, surface: &StandardSurface) {
        self.colour("base", &surface.base_color);
        self.colour("specular colour", &surface.specular_color);
        self.colour("sheen", &surface.sheen_color);
        self.colour("through colour", &surface.diffuse_transmission_color);
        for (name, scalar) in [
            ("metallic", &surface.metallic),
            ("roughness", &surface.roughness),
            ("specular", &surface.specular),
            ("transmission", &surface.transmission),
            ("through", &surface.diffuse_transmission),
            ("coat", &surface.coat),
            ("coat roughness", &surface.coat_roughness),
        ] {
            self.scalar(name, scalar);
        }
        if let Some(film) = &surface.film {
            self.scalar("film", &film.weight);
            self.scalar("thickness of the film", &film.thickness_nm);
            self.out.push(("index of the film".to_owned(), vec![film.ior]));
        }
        if surface.sheen_color != Colour::new([0.0; 3]) {
            self.scalar("sheen roughness", &surface.sheen_roughness);
        }
        self.out.push(("ior".into(), vec![surface.ior]));
        match &surface.opacity {
            Opacity::Opaque => self.out.push(("opaque".into(), vec![])),
            Opacity::Mask { alpha, cutoff } => {
                self.scalar("mask", alpha);
                self.out.push(("cutoff".into(), vec![*cutoff]));
            }
            Opacity::Blend { alpha } => self.scalar("blend", alpha),
        }
        if let Some((input, strength)) = &surface.normal {
            let lanes = |four: [f64; 4]| vec![four[0] * strength, four[1] * strength, four[2]];
            self.out.push(("normal".into(), [lanes(input.scale), lanes(input.bias)].concat()));
            self.input(input, true);
        }
        if surface.vertex_colors {
            for source in self.assembly.meshes.iter().filter(|source| source.materials.contains(&Some(self.index))) {
                let colors: Vec<f64> = source.mesh.colors.iter().flatten().map(|x| f64::from(*x)).collect();
                if !colors.is_empty() {
                    self.out.push(("colours".into(), colors));
                }
            }
        }
    }

    /// cd/m² of the three primaries.
    fn emission(&mut self, surface: &StandardSurface) {
        let find = |name: &str| {
            let mapped = &self.assembly.materials.get(self.index).expect("it is there").mapped;
            mapped.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone())
        };
        let nit = find("luminance_cd_m2").and_then(|value| value.number()).unwrap_or(0.0);
        let lanes = find("emitter.spectrum").map_or(vec![1.0; 3], |spectrum| {
            spectrum.get("rgb").expect("rgb").list().expect("a list").iter().map(|x| x.number().expect("one")).collect()
        });
        let own = eyebox::base::colour::luminance([lanes[0], lanes[1], lanes[2]]);
        let scale = surface.emission.as_ref().map_or([1.0; 4], |input| input.scale);
        let glow = (0..3).map(|i| nit * lanes[i] / own * scale[i]).collect();
        self.out.push(("emission".into(), glow));
        if let Some(input) = &surface.emission {
            self.input(input, true);
        }
    }

    fn colour(&mut self, name: &str, colour: &Colour) {
        let by = colour.texture.as_ref().map_or([1.0; 4], |input| input.scale);
        let bias = colour.texture.as_ref().map_or([0.0; 4], |input| input.bias);
        let numbers = (0..3).map(|i| colour.factor[i] * by[i]).chain((0..3).map(|i| colour.factor[i] * bias[i]));
        self.out.push((name.into(), numbers.collect()));
        if let Some(input) = &colour.texture {
            self.input(input, true);
        }
    }

    fn scalar(&mut self, name: &str, scalar: &Scalar) {
        match &scalar.texture {
            None => self.out.push((name.into(), vec![scalar.factor])),
            Some((input, channel)) => {
                let numbers = [input.scale, input.bias].map(|four| scalar.factor * channel.of(four)).to_vec();
                let component = channel.pick(input.channels);
                self.out.push((format!("{name} {component:?}"), numbers));
                self.input(input, component != Channel::Alpha);
            }
        }
    }

    fn input(&mut self, input: &TextureInput, encoded: bool) {
        let bytes = match &input.texture.texels {
            Texels::Encoded(PictureSource::File(file)) => package::read(file).expect("the picture is there"),
            Texels::Encoded(PictureSource::Embedded(bytes)) => bytes.to_vec(),
            Texels::Encoded(PictureSource::Tiles(_)) => panic!("it is one picture"),
            Texels::Bytes(_) | Texels::Floats(_) => panic!("it is not read yet"),
        };
        let texels = image::load_from_memory(&bytes).expect("a picture").into_rgba8().into_raw();
        let encoding = if encoded { format!("{:?}", input.encoding) } else { String::new() };
        self.out.push((
            format!("{encoding} {:?} {:?}", input.wrap, input.filter),
            texels.iter().map(|x| f64::from(*x)).collect(),
        ));
        for source in self.assembly.meshes.iter().filter(|source| source.materials.contains(&Some(self.index))) {
            let set = if input.set > 0 { &source.mesh.second_uvs } else { &source.mesh.uvs };
            let places = set.iter().flat_map(|uv| {
                let [u, v] = uv.map(f64::from);
                input.to_picture.map(|[a, b, c]| a * u + b * v + c)
            });
            self.out.push(("places".into(), places.collect()));
        }
    }
}
