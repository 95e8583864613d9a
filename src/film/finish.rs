//! From films to a frame: means, layers per group, the contrast split, `hybrid`, standard errors.

mod maker;
pub mod slides;

use super::accumulate::light::COLUMNS;
use super::accumulate::{Components, Film, Light, PlaneKey, Together};
use super::aov::Aov;
use super::diffraction::Diffraction;
use super::frame::{Channel, Frame};
use super::layer::Layer;
use super::names;
use super::sharpness::Applied;
use eyebox_base::colour::ColourSpace;
use eyebox_base::ids::GroupId;
use maker::{Channels, Maker};
use slides::{BySlide, Crossed};
use std::collections::BTreeMap;

/// What the frame's maker knows of a light group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GroupInfo {
    pub name: String,
    /// Contrast C of the slide that the group's light crosses, or of all slides where they are alike, if its layers are to be split into `open` and `content`.
    #[serde(with = "optional_contrast")]
    pub contrast: Option<f64>,
    /// How its light is told apart by slides, in a scene that has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slides: Option<BySlide>,
    /// Linear Rec.709 of a unit of the group's luminance, where films hold luminance alone.
    pub tint: [f64; 3],
}

/// JSON has no infinity, and a contrast may be infinite.
mod optional_contrast {
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

/// The light of the planes of one key, pixel by pixel.
enum Plane<'f> {
    /// As films hold it, in the order in which they are added up.
    Films(Vec<Share<'f>>),
    /// As it was made of that.
    Stored(Vec<Coloured>),
}

/// A plane of a film.
struct Share<'f> {
    film: &'f Film,
    plane: usize,
    tint: [f64; 3],
    space: ColourSpace,
    /// Its light is the same in all channels.
    grey: bool,
}

impl Plane<'_> {
    fn is_grey(&self) -> bool {
        match self {
            Plane::Films(shares) => shares.iter().all(|share| share.grey),
            Plane::Stored(_) => false,
        }
    }

    /// The light of a pixel where it is grey.
    fn grey(&self, pixel: usize) -> Light {
        let mut sum = Light::default();
        if let Plane::Films(shares) = self {
            shares.iter().for_each(|share| sum.add(share.film.mean(pixel, share.plane)));
        }
        sum
    }

    fn coloured(&self, pixel: usize) -> Coloured {
        let mut sum = Coloured::default();
        match self {
            Plane::Films(shares) => {
                for share in shares {
                    let light = in_space(share.space, coloured(share.film, pixel, share.plane, share.tint));
                    sum.iter_mut().zip(light).for_each(|(sum, light)| sum.add(light));
                }
            }
            Plane::Stored(all) => sum = all[pixel],
        }
        sum
    }
}

/// Planes whose light is added up: it is worked out whenever it is asked for, since it takes six times the memory of what
/// is stored of it.
struct Sum<'p, 'f> {
    planes: Vec<&'p Plane<'f>>,
    pixels: usize,
    grey: bool,
}

impl Sum<'_, '_> {
    /// The light of a pixel, the same in all channels; for those that are [grey](Sum::grey).
    fn grey_light(&self, pixel: usize) -> Light {
        sum(self.planes.iter().map(|plane| plane.grey(pixel)), Light::add)
    }

    fn coloured_light(&self, pixel: usize) -> Coloured {
        let add = |sum: &mut Coloured, more: Coloured| sum.iter_mut().zip(more).for_each(|(sum, light)| sum.add(light));
        sum(self.planes.iter().map(|plane| plane.coloured(pixel)), add)
    }

    /// The light of all pixels and channels, once if it is the same in all of them.
    fn all(&self) -> impl Iterator<Item = Light> + '_ {
        (0..self.pixels).flat_map(|pixel| {
            let lights = if self.grey { [self.grey_light(pixel); 3] } else { self.coloured_light(pixel) };
            lights.into_iter().take(if self.grey { 1 } else { 3 })
        })
    }

    fn is_lit(&self) -> bool {
        self.all().any(|light| light.value != 0.0 || light.open() != 0.0)
    }
}

fn sum<L: Default>(mut lights: impl Iterator<Item = L>, add: impl Fn(&mut L, L)) -> L {
    let mut sum = lights.next().unwrap_or_default();
    lights.for_each(|light| add(&mut sum, light));
    sum
}

/// What was decided about splitting a group, for the header.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Split {
    /// The layer, or the name of a layer by light path expression.
    pub layer: String,
    pub group: String,
    /// Of several, the one that this is about.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slide: Option<String>,
    /// Of light through two in series, the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<String>,
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
        for (plane, key) in film.planes.iter().enumerate() {
            let tint = groups[key.group.index()].tint;
            // Red, green and blue are spread by different widths, so other spaces come after that.
            let space = if diffraction.is_some() { ColourSpace::Rec709 } else { space };
            let grey =
                tint == [1.0; 3] && matches!(film.components, Components::Luminance) && space == ColourSpace::Rec709;
            let share = Share { film, plane, tint, space, grey };
            match planes.entry(*key).or_insert_with(|| Plane::Films(Vec::new())) {
                Plane::Films(shares) => shares.push(share),
                Plane::Stored(_) => {}
            }
        }
    }
    let applied = diffraction.map(|diffraction| {
        let all = |plane: &Plane| (0..pixels).map(|pixel| plane.coloured(pixel)).collect();
        let mut colours: BTreeMap<PlaneKey, Vec<Coloured>> =
            planes.iter().map(|(key, plane)| (*key, all(plane))).collect();
        let applied = diffraction.spread([width, height], &mut colours);
        if space != ColourSpace::Rec709 {
            colours.values_mut().flatten().for_each(|light| *light = in_space(space, *light));
        }
        planes = colours.into_iter().map(|(key, plane)| (key, Plane::Stored(plane))).collect();
        applied
    });
    let mut out = Maker { frame: Frame { width, height, ..Frame::default() }, splits: Vec::new() };
    let mut hybrid = Channels::black(pixels);
    for layer in Layer::SUM_ORDER {
        let own = by_group(&planes, pixels, |key| key.layer == layer);
        if own.is_empty() && !always.contains(&layer) {
            continue;
        }
        let mut sum = Channels::black(pixels);
        for (group, plane) in own {
            let info = &groups[group.index()];
            let stored = out.group(layer.name(), info, &plane);
            let own = |key: &PlaneKey| (key.layer, key.group) == (layer, group);
            out.by_slide(layer.name(), info, &plane, &|crossed| crossing(&planes, pixels, (group, info), crossed, own));
            out.group_errors(films, (layer, group), info);
            out.slide_errors(films, (layer, group), info);
            sum.add(&stored);
        }
        hybrid.add(&sum);
        out.rgb(layer.name(), sum);
        out.errors(films, Together::Layer(layer), layer.name());
    }
    for (aov, bit) in aovs.iter().filter_map(|aov| Some((aov, aov.part?))) {
        let taken = Together::Taken(bit);
        for (group, plane) in by_group(&planes, pixels, |key| taken.has(key)) {
            let info = &groups[group.index()];
            out.group(&aov.name, info, &plane);
            let own = |key: &PlaneKey| taken.has(key) && key.group == group;
            out.by_slide(&aov.name, info, &plane, &|crossed| crossing(&planes, pixels, (group, info), crossed, own));
        }
        out.errors(films, taken, &aov.name);
    }
    out.rgb("hybrid", hybrid.clone());
    out.rgb("", hybrid);
    out.stderr(films, pixels);
    if let Some(by) = groups.iter().find_map(|group| group.slides.as_ref()) {
        out.frame.meta.insert(slides::KEY.to_owned(), by.listed());
    }
    let invalid = out.frame.channels.iter().filter_map(first_invalid).collect();
    Finished { frame: out.frame, splits: out.splits, invalid, applied }
}

/// The light of each group that has any in the planes of these keys.
fn by_group<'p, 'f>(
    planes: &'p BTreeMap<PlaneKey, Plane<'f>>,
    pixels: usize,
    has: impl Fn(&PlaneKey) -> bool,
) -> BTreeMap<GroupId, Sum<'p, 'f>> {
    let mut groups: BTreeMap<GroupId, Sum<'p, 'f>> = BTreeMap::new();
    for (key, plane) in planes.iter().filter(|(key, _)| has(key)) {
        let sum = groups.entry(key.group).or_insert_with(|| Sum { planes: Vec::new(), pixels, grey: true });
        sum.grey &= plane.is_grey();
        sum.planes.push(plane);
    }
    groups.retain(|_, sum| sum.is_lit());
    groups
}

/// The light of a group, among the planes of these keys, that crosses slides so.
fn crossing<'p, 'f>(
    planes: &'p BTreeMap<PlaneKey, Plane<'f>>,
    pixels: usize,
    (group, info): (GroupId, &GroupInfo),
    crossed: Crossed,
    has: impl Fn(&PlaneKey) -> bool,
) -> Option<Sum<'p, 'f>> {
    let by = info.slides.as_ref()?;
    by_group(planes, pixels, |key| has(key) && by.crossed(key.takes) == crossed).remove(&group)
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
    let columns = rgb.map(|light| light.columns());
    let columns: [[f64; 3]; COLUMNS] = std::array::from_fn(|k| space.from_rec709(columns.map(|light| light[k])));
    std::array::from_fn(|c| Light::of_columns(columns.map(|column| column[c])))
}

fn first_invalid(channel: &Channel) -> Option<String> {
    let pixel = channel.data.iter().position(|value| !names::may_hold(channel.layer(), *value))?;
    Some(format!("{} at pixel number {pixel}", channel.name))
}
