//! Layers of a frame as they are stored: of light, of a group with its contrast split, of standard errors.

use super::slides::{Crossed, Shows, SlideInfo};
use super::{GroupInfo, Split, Sum};
use crate::accumulate::light::Corners;
use crate::accumulate::{Film, Light, MixError, Together};
use crate::aov::{CHANGE_ERROR, OF_SERIES};
use crate::frame::{Channel, Frame, Samples};
use crate::layer::Layer;
use eyebox_base::ids::GroupId;

/// The largest share of a layer's peak by which recombining `open` and `content` may miss the layer.
const SPLIT_TOLERANCE: f64 = 1e-7;

/// Three channels as they are stored; of grey light one memory.
#[derive(Clone)]
pub(super) struct Channels([Samples; 3]);

impl Channels {
    pub(super) fn black(pixels: usize) -> Self {
        Channels::grey(vec![0f32; pixels].into())
    }
    fn grey(data: Samples) -> Self {
        Channels([data.clone(), data.clone(), data])
    }
    pub(super) fn of(plane: &Sum, value: impl Fn(&Light) -> f64) -> Self {
        if plane.grey {
            return Channels::grey((0..plane.pixels).map(|pixel| value(&plane.grey_light(pixel)) as f32).collect());
        }
        let mut channels: [Vec<f32>; 3] = std::array::from_fn(|_| Vec::with_capacity(plane.pixels));
        for pixel in 0..plane.pixels {
            let light = plane.coloured_light(pixel);
            channels.iter_mut().zip(&light).for_each(|(channel, light)| channel.push(value(light) as f32));
        }
        Channels(channels.map(Samples::from))
    }
    fn is_grey(&self) -> bool {
        let [red, others @ ..] = &self.0;
        others.iter().all(|other| other.is_shared_with(red))
    }
    /// The f32 sum: `hybrid` is the sum of what is stored.
    pub(super) fn add(&mut self, other: &Channels) {
        let add = |own: &mut Samples, other: &Samples| own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        if self.is_grey() && other.is_grey() {
            // Alone, so that it is changed where it is.
            let [mut sum, ..] = std::mem::take(&mut self.0);
            add(&mut sum, &other.0[0]);
            *self = Channels::grey(sum);
        } else {
            self.0.iter_mut().zip(&other.0).for_each(|(own, other)| add(own, other));
        }
    }
}

pub(super) struct Maker {
    pub(super) frame: Frame,
    pub(super) splits: Vec<Split>,
}

impl Maker {
    /// Adds a layer; the empty name is the default image.
    pub(super) fn rgb(&mut self, layer: &str, Channels(data): Channels) {
        for (channel, data) in ["R", "G", "B"].into_iter().zip(data) {
            let name = if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") };
            self.frame.channels.push(Channel { name, data });
        }
    }

    /// Adds a layer that is no light, the same in all channels.
    fn grey(&mut self, layer: &str, data: Samples) {
        self.rgb(layer, Channels::grey(data));
    }

    /// Adds the layers of one group; returns what was stored for the group itself.
    pub(super) fn group(&mut self, layer: &str, group: &GroupInfo, plane: &Sum) -> Channels {
        let name = format!("{layer}_{}", group.name);
        if let Some(contrast) = group.contrast {
            self.split((layer, group, None), &name, contrast, plane);
        }
        let stored = Channels::of(plane, |light| light.value);
        self.rgb(&name, stored.clone());
        stored
    }

    /// Adds what tells how a group's light depends on each of several slides: of the light that crosses one of them and no
    /// other what [`Maker::split`] makes of it. `of`: the part of `whole` that crosses slides so.
    pub(super) fn by_slide<'p, 'f: 'p>(
        &mut self,
        layer: &str,
        group: &GroupInfo,
        whole: &Sum<'p, 'f>,
        of: &dyn Fn(Crossed) -> Option<Sum<'p, 'f>>,
    ) {
        let Some(by) = &group.slides else { return };
        let most =
            |sum: &Sum| sum.all().fold(0.0f64, |most, light| most.max(light.open().abs().max(light.value.abs())));
        let several = of(Crossed::Several).map_or(0.0, |sum| most(&sum) / most(whole));
        for (index, slide) in by.slides.iter().enumerate() {
            if several > SPLIT_TOLERANCE {
                let because = match by.shows {
                    Shows::Several => {
                        "its lamps show several pictures, or some show none: give each a light group of its own"
                            .to_owned()
                    }
                    Shows::Nothing | Shows::Slide(_) => {
                        let what = match by.pairs().next() {
                            Some(_) => {
                                "three slides or more, one after the other, or one of two twice, or two that no path of a look before the first pass crossed"
                            }
                            None => "two slides or more, one after the other",
                        };
                        format!(
                            "light that crosses {what}, makes up to {several:.1e} of the peak with all of them open"
                        )
                    }
                };
                let (layer, group) = (layer.to_owned(), group.name.clone());
                self.splits.push(Split {
                    layer,
                    group,
                    slide: Some(slide.name.clone()),
                    with: None,
                    written: false,
                    because,
                });
            } else if let Some(own) = of(Crossed::One(index)) {
                let name = format!("{layer}_{}_{}", group.name, slide.name);
                self.split((layer, group, Some(&slide.name)), &name, slide.contrast, &own);
            }
        }
        if several <= SPLIT_TOLERANCE {
            for pair in by.pairs() {
                if let Some(own) = of(Crossed::Both(pair)) {
                    self.split_both((layer, group), pair.map(|slide| &by.slides[slide]), pair, &own);
                }
            }
        }
    }

    /// Adds the light that crosses two slides once each with each of them open or at C = ∞.
    fn split_both(
        &mut self,
        (layer, group): (&str, &GroupInfo),
        slides: [&SlideInfo; 2],
        numbers: [usize; 2],
        plane: &Sum,
    ) {
        let ranks = numbers.map(|slide| slide as f64);
        let contrasts = slides.map(|slide| slide.contrast);
        let (mut peak, mut miss) = (0.0f64, 0.0f64);
        for light in plane.all() {
            peak = peak.max(light.value.abs());
            miss = miss.max((light.corners(ranks).at(contrasts) - light.value).abs());
        }
        let written = miss <= SPLIT_TOLERANCE * peak;
        let because = format!("recombining misses by {:.1e} of the peak", miss / peak.max(f64::MIN_POSITIVE));
        let name = slides.map(|slide| slide.name.as_str()).join("_");
        let [slide, with] = slides.map(|slide| Some(slide.name.clone()));
        self.splits.push(Split { layer: layer.to_owned(), group: group.name.clone(), slide, with, written, because });
        if !written {
            return;
        }
        let corners: [fn(Corners) -> f64; 4] =
            [|c| c.open_open, |c| c.content_open, |c| c.open_content, |c| c.content_content];
        for (suffix, corner) in OF_SERIES.into_iter().zip(corners) {
            let layer = format!("{layer}_{}_{name}{suffix}", group.name);
            self.rgb(&layer, Channels::of(plane, |light| corner(light.corners(ranks))));
        }
    }

    fn split(
        &mut self,
        (layer, group, slide): (&str, &GroupInfo, Option<&String>),
        name: &str,
        contrast: f64,
        plane: &Sum,
    ) {
        // Light that crossed no slide does not depend on the contrast: there is nothing to split.
        if plane.all().all(|l| l.powers[1..].iter().all(|p| *p == 0.0)) {
            return;
        }
        let (u, v) = (1.0 - 1.0 / contrast, 1.0 / contrast);
        // Σ aₖuᵏ = content·u + open·(1 − u) + u(1 − u)·(q₀ + q₁u + q₂u²) with qⱼ = −Σ aₖ over k > j + 1.
        const ORDERS: usize = Light::DEGREE - 1;
        let cross = |l: &Light, j: usize| -l.powers[j + 2..].iter().sum::<f64>();
        let recombined = |l: &Light| {
            let crossings: f64 = (0..ORDERS).rev().fold(0.0, |sum, j| sum * u + cross(l, j));
            l.content() * u + l.open() * v + crossings * u * v
        };
        let (mut peak, mut miss, mut crosses) = (0.0f64, 0.0f64, [false; ORDERS]);
        for light in plane.all() {
            peak = peak.max(light.value.abs());
            miss = miss.max((recombined(&light) - light.value).abs());
            crosses.iter_mut().enumerate().for_each(|(order, any)| *any |= cross(&light, order) != 0.0);
        }
        let written = miss <= SPLIT_TOLERANCE * peak;
        let because = if written {
            format!("recombining misses by {:.1e} of the peak", miss / peak.max(f64::MIN_POSITIVE))
        } else {
            let share = miss / peak;
            let most = Light::DEGREE;
            format!("light that crosses the slide more than {most} times makes up to {share:.1e} of the peak")
        };
        let (layer, group) = (layer.to_owned(), group.name.clone());
        self.splits.push(Split { layer, group, slide: slide.cloned(), with: None, written, because });
        if !written {
            return;
        }
        self.rgb(&format!("{name}_open"), Channels::of(plane, |l| l.open()));
        self.rgb(&format!("{name}_content"), Channels::of(plane, |l| l.content()));
        for (order, suffix) in ["_cross", "_cross2", "_cross3"].into_iter().enumerate().take(ORDERS) {
            if crosses[order] {
                self.rgb(&format!("{name}{suffix}"), Channels::of(plane, |l| cross(l, order)));
            }
        }
    }

    /// `NAME_stderr` of planes together, if it was kept. Films of different estimators are independent, here and below.
    pub(super) fn errors(&mut self, films: &[&Film], together: Together, name: &str) {
        if films.iter().any(|film| film.detail().is_none()) {
            return;
        }
        let own: Vec<&Film> = films.iter().copied().filter(|film| film.planes_of(together).next().is_some()).collect();
        let variance = |pixel: usize| own.iter().filter_map(|film| film.variance_of(pixel, together)).sum::<f64>();
        self.sigma(&format!("{name}_stderr"), told(&own, variance));
    }

    /// `LAYER_GROUP_stderr`, and where the group's light was split `…_open_stderr`, `…_content_stderr` and their
    /// `…_covariance` in (cd/m²)²: the picture for contrast C has the variance u²·content² + v²·open² +
    /// 2uv·covariance with u = 1 − 1/C and v = 1/C.
    pub(super) fn group_errors(&mut self, films: &[&Film], (layer, of): (Layer, GroupId), group: &GroupInfo) {
        let share = Together::Share(layer, of);
        let own: Vec<&Film> = films.iter().copied().filter(|film| film.planes_of(share).next().is_some()).collect();
        if own.iter().any(|film| film.detail().is_none()) {
            return;
        }
        let name = format!("{}_{}", layer.name(), group.name);
        let variance = |pixel: usize| own.iter().filter_map(|film| film.variance_of(pixel, share)).sum::<f64>();
        self.sigma(&format!("{name}_stderr"), told(&own, variance));
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
        self.sigma(&format!("{name}_open_stderr"), told(&own, |pixel| mix(pixel).open));
        self.sigma(&format!("{name}_content_stderr"), told(&own, |pixel| mix(pixel).content));
        let pixels = self.frame.width * self.frame.height;
        let covariance = told(&own, |pixel| mix(pixel).covariance);
        self.grey(&format!("{name}_covariance"), (0..pixels).map(|pixel| covariance(pixel) as f32).collect());
    }

    /// `LAYER_GROUP_SLIDE_change_stderr` of every slide whose light was split. What several planes hold of it is not known to lean
    /// on each other: their errors are added up.
    pub(super) fn slide_errors(&mut self, films: &[&Film], (layer, of): (Layer, GroupId), group: &GroupInfo) {
        let Some(by) = &group.slides else { return };
        for (index, slide) in by.slides.iter().enumerate() {
            let name = format!("{}_{}_{}", layer.name(), group.name, slide.name);
            if !self.frame.channels.iter().any(|channel| channel.name == format!("{name}_open.R")) {
                continue;
            }
            let is_own = |plane: &usize, film: &Film| by.crossed(film.planes[*plane].takes) == Crossed::One(index);
            let share = Together::Share(layer, of);
            let planes =
                |film: &Film| film.planes_of(share).filter(|plane| is_own(plane, film)).collect::<Vec<usize>>();
            let own: Vec<(&Film, Vec<usize>)> = films.iter().map(|film| (*film, planes(film))).collect();
            let own: Vec<(&Film, Vec<usize>)> = own.into_iter().filter(|(_, planes)| !planes.is_empty()).collect();
            if own.iter().any(|(film, _)| film.detail().is_none()) {
                continue;
            }
            let variance = |pixel: usize| {
                let of_film = |(film, planes): &(&Film, Vec<usize>)| {
                    let sigmas = planes.iter().filter_map(|plane| film.change_variance(pixel, *plane)).map(f64::sqrt);
                    sigmas.sum::<f64>().powi(2)
                };
                own.iter().map(of_film).sum::<f64>()
            };
            let films: Vec<&Film> = own.iter().map(|(film, _)| *film).collect();
            self.sigma(&format!("{name}{CHANGE_ERROR}"), told(&films, variance));
        }
    }

    fn sigma(&mut self, name: &str, variance: impl Fn(usize) -> f64) {
        let pixels = self.frame.width * self.frame.height;
        self.grey(name, (0..pixels).map(|pixel| variance(pixel).sqrt() as f32).collect());
    }

    /// `stderr`: one sigma of `hybrid`. Films of different estimators are independent.
    pub(super) fn stderr(&mut self, films: &[&Film], pixels: usize) {
        let doubts: Vec<Option<Vec<f64>>> = films.iter().map(|film| film.doubts()).collect();
        let of_film = |(film, doubts): (&&Film, &Option<Vec<f64>>), pixel: usize| {
            let doubt = doubts.as_ref().map_or(0.0, |doubts| doubts[pixel]);
            film.variance(pixel, film.planes.len()).max(doubt)
        };
        let variance = |pixel: usize| films.iter().zip(&doubts).map(|film| of_film(film, pixel)).sum::<f64>();
        let variance = told(films, variance);
        self.grey("stderr", (0..pixels).map(|pixel| variance(pixel).sqrt() as f32).collect());
    }
}

/// The same, or NaN where a film has too few samples to tell a variance: unknown is not zero.
fn told<'f>(films: &[&'f Film], variance: impl Fn(usize) -> f64 + 'f) -> impl Fn(usize) -> f64 {
    let unknown = films.iter().any(|film| film.samples() < 2);
    move |pixel| if unknown { f64::NAN } else { variance(pixel) }
}
