//! From films to a frame: means, layers per group, the contrast split, `hybrid`, standard errors.

use super::accumulate::{Components, Film, Light, MixError, PlaneKey, Together};
use super::aov::Aov;
use super::diffraction::Diffraction;
use super::frame::{Channel, Frame};
use super::layer::Layer;
use super::sharpness::Applied;
use crate::base::colour::ColourSpace;
use crate::base::ids::GroupId;
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

/// The largest share of a layer's peak by which recombining `open` and `content` may miss the layer.
const SPLIT_TOLERANCE: f64 = 1e-7;

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

/// Three channels as they are stored.
#[derive(Clone)]
struct Channels([Vec<f32>; 3]);

impl Channels {
    fn black(pixels: usize) -> Self {
        Channels(std::array::from_fn(|_| vec![0f32; pixels]))
    }
    fn of(plane: &Plane, value: impl Fn(&Light) -> f64) -> Self {
        if plane.grey {
            let all: Vec<f32> = plane.light.iter().map(|light| value(light) as f32).collect();
            return Channels([all.clone(), all.clone(), all]);
        }
        let channel = |c: usize| plane.light.iter().skip(c).step_by(3).map(|light| value(light) as f32).collect();
        Channels(std::array::from_fn(channel))
    }
    /// The f32 sum: `hybrid` is the sum of what is stored.
    fn add(&mut self, other: &Channels) {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        }
    }
}

fn first_invalid(channel: &Channel) -> Option<String> {
    let pixel = channel.data.iter().position(|v| !v.is_finite())?;
    Some(format!("{} at pixel number {pixel}", channel.name))
}

struct Maker {
    frame: Frame,
    splits: Vec<Split>,
}

impl Maker {
    /// Adds a layer; the empty name is the default image.
    fn rgb(&mut self, layer: &str, Channels(data): Channels) {
        for (channel, data) in ["R", "G", "B"].into_iter().zip(data) {
            let name = if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") };
            self.frame.channels.push(Channel { name, data });
        }
    }

    /// Adds a layer that is no light, the same in all channels.
    fn grey(&mut self, layer: &str, data: Vec<f32>) {
        self.rgb(layer, Channels([data.clone(), data.clone(), data]));
    }

    /// Adds the layers of one group; returns what was stored for the group itself.
    fn group(&mut self, layer: &str, group: &GroupInfo, plane: &Plane) -> Channels {
        let name = format!("{layer}_{}", group.name);
        if let Some(contrast) = group.contrast {
            self.split(layer, group, &name, contrast, plane);
        }
        let stored = Channels::of(plane, |light| light.value);
        self.rgb(&name, stored.clone());
        stored
    }

    fn split(&mut self, layer: &str, group: &GroupInfo, name: &str, contrast: f64, plane: &Plane) {
        // Light that crossed no slide does not depend on the contrast: there is nothing to split.
        let all = || plane.light.iter();
        if all().all(|l| l.powers[1..].iter().all(|p| *p == 0.0)) {
            return;
        }
        let (u, v) = (1.0 - 1.0 / contrast, 1.0 / contrast);
        // Σ aₖuᵏ = content·u + open·(1 − u) + u(1 − u)·(q₀ + q₁u + q₂u²) with qⱼ = −Σ aₖ over k > j + 1.
        let cross = |l: &Light, j: usize| -l.powers[j + 2..].iter().sum::<f64>();
        let orders = Light::DEGREE - 1;
        let recombined = |l: &Light| {
            let crossings: f64 = (0..orders).rev().fold(0.0, |sum, j| sum * u + cross(l, j));
            l.content() * u + l.open() * v + crossings * u * v
        };
        let peak = all().fold(0.0f64, |peak, l| peak.max(l.value.abs()));
        let miss = all().map(|l| (recombined(l) - l.value).abs()).fold(0.0f64, f64::max);
        let written = miss <= SPLIT_TOLERANCE * peak;
        let because = if written {
            format!("recombining misses by {:.1e} of the peak", miss / peak.max(f64::MIN_POSITIVE))
        } else {
            let share = miss / peak;
            let most = Light::DEGREE;
            format!("light that crosses the slide more than {most} times makes up to {share:.1e} of the peak")
        };
        self.splits.push(Split { layer: layer.to_owned(), group: group.name.clone(), written, because });
        if !written {
            return;
        }
        self.rgb(&format!("{name}_open"), Channels::of(plane, |l| l.open()));
        self.rgb(&format!("{name}_content"), Channels::of(plane, |l| l.content()));
        for (order, suffix) in ["_cross", "_cross2", "_cross3"].into_iter().enumerate().take(orders) {
            if all().any(|l| cross(l, order) != 0.0) {
                self.rgb(&format!("{name}{suffix}"), Channels::of(plane, |l| cross(l, order)));
            }
        }
    }

    /// `NAME_stderr` of planes together, if it was kept. Films of different estimators are independent, here and below.
    fn errors(&mut self, films: &[&Film], together: Together, name: &str) {
        if films.iter().any(|film| film.detail().is_none()) {
            return;
        }
        let variance = |pixel: usize| films.iter().filter_map(|film| film.variance_of(pixel, together)).sum::<f64>();
        self.sigma(&format!("{name}_stderr"), variance);
    }

    /// `LAYER_GROUP_stderr`, and where the group's light was split `…_open_stderr`, `…_content_stderr` and their
    /// `…_covariance` in (cd/m²)²: the picture for contrast C has the variance u²·content² + v²·open² +
    /// 2uv·covariance with u = 1 − 1/C and v = 1/C.
    fn group_errors(&mut self, films: &[&Film], (layer, of): (Layer, GroupId), group: &GroupInfo) {
        let share = Together::Share(layer, of);
        let own: Vec<&Film> = films.iter().copied().filter(|film| film.planes_of(share).next().is_some()).collect();
        if own.iter().any(|film| film.detail().is_none()) {
            return;
        }
        let name = format!("{}_{}", layer.name(), group.name);
        self.sigma(&format!("{name}_stderr"), |pixel| {
            own.iter().filter_map(|film| film.variance_of(pixel, share)).sum()
        });
        if !self.frame.channels.iter().any(|channel| channel.name == format!("{name}_open.R")) {
            return;
        }
        let mix = |pixel: usize| {
            own.iter().filter_map(|film| film.mix_error(pixel, (layer, of))).fold(MixError::default(), |sum, one| {
                let MixError { open, content, covariance } = one;
                MixError {
                    open: sum.open + open,
                    content: sum.content + content,
                    covariance: sum.covariance + covariance,
                }
            })
        };
        self.sigma(&format!("{name}_open_stderr"), |pixel| mix(pixel).open);
        self.sigma(&format!("{name}_content_stderr"), |pixel| mix(pixel).content);
        let pixels = self.frame.width * self.frame.height;
        self.grey(&format!("{name}_covariance"), (0..pixels).map(|pixel| mix(pixel).covariance as f32).collect());
    }

    fn sigma(&mut self, name: &str, variance: impl Fn(usize) -> f64) {
        let pixels = self.frame.width * self.frame.height;
        self.grey(name, (0..pixels).map(|pixel| variance(pixel).sqrt() as f32).collect());
    }

    /// `stderr`: one sigma of `hybrid`. Films of different estimators are independent.
    fn stderr(&mut self, films: &[&Film], pixels: usize) {
        let mut total = vec![0f64; pixels];
        for film in films {
            total.iter_mut().enumerate().for_each(|(pixel, sum)| *sum += film.variance(pixel, film.planes.len()));
        }
        self.grey("stderr", total.iter().map(|v| v.sqrt() as f32).collect());
    }
}
