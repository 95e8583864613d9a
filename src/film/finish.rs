//! From films to a frame: means, layers per group, the contrast split, `hybrid`, standard errors.

mod maker;

use super::accumulate::{Components, Film, Light, PlaneKey, Together};
use super::aov::Aov;
use super::diffraction::Diffraction;
use super::frame::{Channel, Frame};
use super::layer::Layer;
use super::sharpness::Applied;
use crate::base::colour::ColourSpace;
use crate::base::ids::GroupId;
use maker::{Channels, Maker};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// What the frame's maker knows of a light group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GroupInfo {
    pub name: String,
    /// Contrast C of the slide that the group's light crosses, if its layers are to be split into `open` and `content`.
    #[serde(with = "contrast")]
    pub contrast: Option<f64>,
    /// Linear Rec.709 of a unit of the group's luminance, where films hold luminance alone.
    pub tint: [f64; 3],
}

/// JSON has no infinity, and a contrast may be infinite.
mod contrast {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(contrast: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        contrast.map(|contrast| contrast.to_string()).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
        let text = Option::<String>::deserialize(from)?;
        text.map(|text| text.parse::<f64>().map_err(D::Error::custom)).transpose()
    }
}

/// The light of a pixel in the three channels.
type Coloured = [Light; 3];

/// The light of all pixels: of each in the three channels one after the other, or once if it is the same in all of them.
#[derive(Clone)]
struct Plane {
    light: Vec<Light>,
    grey: bool,
}

impl Plane {
    fn black(pixels: usize, grey: bool) -> Self {
        Plane { light: vec![Light::default(); if grey { pixels } else { 3 * pixels }], grey }
    }

    /// Each channel is there by itself.
    fn colour(&mut self) {
        if self.grey {
            self.light = self.light.iter().flat_map(|light| [*light; 3]).collect();
            self.grey = false;
        }
    }

    fn add(&mut self, other: &Plane) {
        if self.grey != other.grey {
            self.colour();
            let mut other = other.clone();
            other.colour();
            return self.add(&other);
        }
        self.light.iter_mut().zip(&other.light).for_each(|(sum, light)| sum.add(*light));
    }
}

/// What was decided about splitting a group, for the header.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Split {
    /// The layer, or the name of a layer by light path expression.
    pub layer: String,
    pub group: String,
    pub written: bool,
    pub because: String,
}

/// The picture layers of a set of films (of different estimators) and what was decided about splits.
pub struct Finished {
    pub frame: Frame,
    pub splits: Vec<Split>,
    /// Channels that hold NaN or infinity, with the first pixel: none in a sound run.
    pub invalid: Vec<String>,
    /// How the light was spread by diffraction, if it was.
    pub applied: Option<Applied>,
}

/// Makes the picture layers of films of `size` pixels; without a film they are black. `always`: layers that are written
/// even if no estimator filled them.
pub fn finish(
    [width, height]: [usize; 2],
    films: &[&Film],
    groups: &[GroupInfo],
    always: &[Layer],
    space: ColourSpace,
) -> Finished {
    finish_through([width, height], films, groups, always, &[], space, None)
}

/// The same with the light of each plane spread by diffraction first, and with the light groups' shares of those `aovs` that
/// part classes, and their errors.
pub fn finish_through(
    [width, height]: [usize; 2],
    films: &[&Film],
    groups: &[GroupInfo],
    always: &[Layer],
    aovs: &[Aov],
    space: ColourSpace,
    diffraction: Option<&Diffraction>,
) -> Finished {
    let pixels = width * height;
    let mut planes: BTreeMap<PlaneKey, Plane> = BTreeMap::new();
    for film in films {
        for (index, key) in film.planes.iter().enumerate() {
            let tint = groups[key.group.index()].tint;
            let grey = tint == [1.0; 3]
                && matches!(film.components, Components::Luminance)
                && diffraction.is_none()
                && space == ColourSpace::Rec709;
            let plane = planes.entry(*key).or_insert_with(|| Plane::black(pixels, grey));
            if grey && plane.grey {
                plane.light.iter_mut().enumerate().for_each(|(pixel, sum)| sum.add(film.mean(pixel, index)));
                continue;
            }
            plane.colour();
            for (pixel, sums) in plane.light.chunks_exact_mut(3).enumerate() {
                let light = coloured(film, pixel, index, tint);
                let light = if diffraction.is_some() { light } else { in_space(space, light) };
                sums.iter_mut().zip(light).for_each(|(sum, light)| sum.add(light));
            }
        }
    }
    // Red, green and blue are spread by different widths, so other spaces come after that.
    let applied = diffraction.map(|diffraction| {
        let split = |plane: Plane| plane.light.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
        let mut colours: BTreeMap<PlaneKey, Vec<Coloured>> =
            std::mem::take(&mut planes).into_iter().map(|(key, plane)| (key, split(plane))).collect();
        let applied = diffraction.spread([width, height], &mut colours);
        if space != ColourSpace::Rec709 {
            colours.values_mut().flatten().for_each(|light| *light = in_space(space, *light));
        }
        let joined = |plane: Vec<Coloured>| Plane { light: plane.into_flattened(), grey: false };
        planes = colours.into_iter().map(|(key, plane)| (key, joined(plane))).collect();
        applied
    });
    let mut out = Maker { frame: Frame { width, height, ..Frame::default() }, splits: Vec::new() };
    let mut hybrid = Channels::black(pixels);
    for layer in Layer::SUM_ORDER {
        let own = by_group(&planes, |key| key.layer == layer);
        let filled = own.values().any(|plane| lit(plane));
        if !filled && !always.contains(&layer) {
            continue;
        }
        let mut sum = Channels::black(pixels);
        for (group, plane) in own.into_iter().filter(|(_, plane)| lit(plane)) {
            let info = &groups[group.index()];
            let stored = out.group(layer.name(), info, &plane);
            out.group_errors(films, (layer, group), info);
            sum.add(&stored);
        }
        hybrid.add(&sum);
        out.rgb(layer.name(), sum);
        out.errors(films, Together::Layer(layer), layer.name());
    }
    for (aov, bit) in aovs.iter().filter_map(|aov| Some((aov, aov.part?))) {
        let taken = Together::Taken(bit);
        for (group, plane) in by_group(&planes, |key| taken.has(key)).into_iter().filter(|(_, plane)| lit(plane)) {
            out.group(&aov.name, &groups[group.index()], &plane);
        }
        out.errors(films, taken, &aov.name);
    }
    out.rgb("hybrid", hybrid.clone());
    out.rgb("", hybrid);
    out.stderr(films, pixels);
    let invalid = out.frame.channels.iter().filter_map(first_invalid).collect();
    Finished { frame: out.frame, splits: out.splits, invalid, applied }
}

fn lit(plane: &Plane) -> bool {
    plane.light.iter().any(|l| l.value != 0.0 || l.open() != 0.0)
}

/// The light of each group in the planes of these keys.
fn by_group(planes: &BTreeMap<PlaneKey, Plane>, has: impl Fn(&PlaneKey) -> bool) -> BTreeMap<GroupId, Cow<'_, Plane>> {
    let mut groups: BTreeMap<GroupId, Cow<'_, Plane>> = BTreeMap::new();
    for (key, plane) in planes.iter().filter(|(key, _)| has(key)) {
        match groups.entry(key.group) {
            Entry::Vacant(first) => {
                first.insert(Cow::Borrowed(plane));
            }
            Entry::Occupied(mut sum) => sum.get_mut().to_mut().add(plane),
        }
    }
    groups
}

/// The mean light of a pixel in a plane: luminance times the group's tint, or what the film holds.
fn coloured(film: &Film, pixel: usize, plane: usize, tint: [f64; 3]) -> Coloured {
    match film.components {
        Components::Luminance => {
            let light = film.mean(pixel, plane);
            tint.map(|share| if share == 1.0 { light } else { light.scaled(share) })
        }
        Components::Rec709 => {
            let mut entries = film.mean_entries(pixel, plane);
            std::array::from_fn(|_| entries.next().unwrap_or_default())
        }
    }
}

/// Linear Rec.709 in another linear space.
fn in_space(space: ColourSpace, rgb: Coloured) -> Coloured {
    if space == ColourSpace::Rec709 {
        return rgb;
    }
    let value = space.from_rec709(rgb.map(|light| light.value));
    let powers: [[f64; 3]; Light::DEGREE + 1] =
        std::array::from_fn(|k| space.from_rec709(rgb.map(|light| light.powers[k])));
    std::array::from_fn(|c| Light { value: value[c], powers: powers.map(|power| power[c]) })
}

fn first_invalid(channel: &Channel) -> Option<String> {
    let pixel = channel.data.iter().position(|v| !v.is_finite())?;
    Some(format!("{} at pixel number {pixel}", channel.name))
}
