//! Sums of light per pixel, layer and group. A film belongs to one estimator; films are added up when the frame is made.

pub mod light;
pub mod plane;

use super::control_variates::{self, ControlVariates, ControlVariatesRow};
use super::kernel_bias::{self, KernelBias};
use super::layer::Layer;
use super::layer_moments::{LayerMoments, LayerMomentsRow};
use super::replicates::{REPLICATES, Replicates};
use super::rqmc_variance::{Evenness, PixelMean, RqmcVariance, RqmcVarianceRow};
use super::sample_map::{SampleMap, SampleMapRow};
use super::tiles::{Tiles, TilesRow};
use super::totals::{Totals, TotalsRow};
use super::unseen::Unseen;
use eyebox_base::double_double::Sum;
use eyebox_base::ids::GroupId;
use light::{COLUMNS, add, depth, value_of};
pub use light::{Light, MixError};
pub use plane::{Components, PlaneKey, Together};
use rayon::prelude::*;
use std::ops::Range;

/// How the samples of a film are counted, for its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Each pass gives one independent value per pixel.
    PerPass,
    /// A pass is `paths` paths dealt to independent scrambles, see [`Replicates`].
    PerScramble { paths: u64 },
}

/// What evenness leaves of a variance: of 1, by number of passes.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved(Vec<(u64, f64)>);

impl Saved {
    pub const NOTHING: Saved = Saved(Vec::new());

    /// For pixels of so many passes.
    pub fn of(&self, passes: u64) -> f64 {
        self.0.binary_search_by_key(&passes, |(own, _)| *own).map_or(1.0, |at| self.0[at].1)
    }
}

/// Sums over passes. They take memory where there is light; a row's are apart from those of others.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    pub width: usize,
    pub height: usize,
    pub planes: Vec<PlaneKey>,
    /// Values per plane: luminance alone, or linear Rec.709.
    pub components: Components,
    pub sampling: Sampling,
    /// Passes of all pixels added so far.
    pub passes: u64,
    /// Passes that all pixels are to have, if those are more.
    pub wanted: u64,
    /// Passes of each pixel, where some have more than that.
    pub(super) map: Option<SampleMap>,
    /// The first pass is being made, a part of the pixels after the other.
    coarse: bool,
    /// `[pixel][plane][component]`
    pub(super) sums: Tiles,
    /// `[pixel][plane]`, and if there are several one more for the sum over planes: squares of the luminance. None where
    /// scrambles tell.
    pub(super) squares: Option<Tiles>,
    pub(super) scrambles: Option<Replicates>,
    /// None where scrambles tell.
    pub(super) turns: Option<RqmcVariance>,
    /// Of films whose passes share wavelengths.
    pub(super) control: Option<ControlVariates>,
    /// Kept on request.
    pub(super) detail: Option<LayerMoments>,
    /// Of films whose light is gathered within a radius.
    pub(super) blur: Option<KernelBias>,
    /// Of films of rays from the eye.
    unseen: Option<Unseen>,
    /// `[pixel]`: variances of the sum over planes, of a [condensed](Film::condense) film.
    variances: Option<Vec<f64>>,
    pub(super) totals: Totals,
}

/// One row of a film, for the thread that owns it.
pub struct Row<'f> {
    planes: usize,
    components: Components,
    sums: TilesRow<'f>,
    squares: TilesRow<'f>,
    turns: Option<RqmcVarianceRow<'f>>,
    control: Option<ControlVariatesRow<'f>>,
    detail: Option<LayerMomentsRow<'f>>,
    blur: Option<TilesRow<'f>>,
    totals: Option<TotalsRow<'f>>,
    map: Option<SampleMapRow<'f>>,
    coarse: bool,
}

impl Film {
    pub fn new(width: usize, height: usize, planes: Vec<PlaneKey>, components: Components, sampling: Sampling) -> Self {
        let (size, count) = ([width, height], planes.len());
        let (squares, turns, scrambles) = match sampling {
            Sampling::PerPass => {
                let squares = Tiles::new(size, total_of(count) + 1, 1);
                (Some(squares), Some(RqmcVariance::new(size, Evenness::OfPixels)), None)
            }
            Sampling::PerScramble { paths } => (None, None, Some(Replicates::new(size, count, paths))),
        };
        Film {
            width,
            height,
            planes,
            components,
            sampling,
            passes: 0,
            wanted: 0,
            map: None,
            coarse: false,
            sums: Tiles::new(size, count * components.count(), COLUMNS).with_first_for_second(),
            squares,
            scrambles,
            turns,
            control: None,
            detail: None,
            blur: None,
            unseen: None,
            variances: None,
            totals: Totals::new([width, height], count),
        }
    }

    /// Keeps what tells how far gathering within a radius errs.
    #[must_use]
    pub fn with_blur(mut self) -> Self {
        self.blur = Some(KernelBias::new([self.width, self.height]));
        self
    }

    /// Says what its rays may not have met.
    #[must_use]
    pub fn with_unseen(self, unseen: Option<Unseen>) -> Self {
        Film { unseen, ..self }
    }

    /// What its rays may not have met.
    pub fn unseen(&self) -> Option<&Unseen> {
        self.unseen.as_ref()
    }

    /// Per pixel: the variance that its mean luminance has at least, (cd/m²)², whatever its passes say. None of a film that knows no such.
    pub fn doubts(&self) -> Option<Vec<f64>> {
        let unseen = self.unseen.as_ref()?;
        let total = |pixel: usize| (0..self.planes.len()).map(|plane| self.sum(pixel, plane).value).sum::<f64>();
        let mean = |pixel: usize| total(pixel) / self.passes_of(pixel).max(1) as f64;
        let means: Vec<f64> = (0..self.width * self.height).into_par_iter().map(mean).collect();
        Some(unseen.doubts(self.width, &means, |pixel| self.passes_of(pixel).max(1)))
    }

    /// Of the light of all pixels, cd/m², what its rays have missed at the most, a quarter of it.
    pub fn missed(&self) -> f64 {
        let passes = self.map.as_ref().map_or(self.passes, |map| map.range()[0]);
        self.unseen.as_ref().map_or(0.0, |unseen| unseen.light(passes.max(1)))
    }

    /// Says of what its passes are even.
    #[must_use]
    pub fn with_evenness(mut self, evenness: Evenness) -> Self {
        let size = [self.width, self.height];
        self.turns = self.turns.map(|_| RqmcVariance::new(size, evenness));
        self.control = match evenness {
            Evenness::OfPixels => None,
            Evenness::OfPasses => self.turns.is_some().then(|| ControlVariates::new(size)),
        };
        self
    }

    /// To be called before rows get passes that share wavelengths: what is known of these.
    pub fn know(&mut self, passes: impl IntoIterator<Item = (u64, control_variates::Known)>) -> bool {
        self.control.as_mut().is_none_or(|control| control.know(passes))
    }

    /// Whether it keeps that.
    pub fn keeps_known(&self) -> bool {
        self.control.is_some()
    }

    /// What is known of passes that share wavelengths.
    pub fn known(&self) -> &[(u64, control_variates::Known)] {
        self.control.as_ref().map_or(&[], ControlVariates::known)
    }

    /// Of what its passes are even; none where scrambles tell.
    pub fn evenness(&self) -> Option<Evenness> {
        self.turns.as_ref().map(RqmcVariance::evenness)
    }

    /// Whether that is kept.
    pub fn has_blur(&self) -> bool {
        self.blur.is_some()
    }

    /// The square of what gathering within a radius makes the mean of a pixel err by, (cd/m²)²: see [`KernelBias::square`].
    pub fn blur2(&self, pixel: usize) -> f64 {
        self.blur.as_ref().map_or(0.0, |blur| blur.square(pixel, self.passes_of(pixel)))
    }

    /// Keeps what standard errors per layer, and of mixtures of `open` and `content`, need.
    #[must_use]
    pub fn with_detail(mut self) -> Self {
        // With scrambles only the list of layers is needed.
        let size = if self.scrambles.is_some() { [0; 2] } else { [self.width, self.height] };
        self.detail = Some(LayerMoments::new(size, &self.planes));
        if let Some(scrambles) = &mut self.scrambles {
            scrambles.keep_mixed();
        }
        self
    }

    /// After the last pass: gives the memory of all sums back that no picture needs, but for those that were asked for.
    /// Variances of one plane among several are unknown then, infinite.
    pub fn condense(&mut self) {
        if self.detail.is_some() {
            return;
        }
        let all = self.planes.len();
        self.variances = Some((0..self.width * self.height).map(|pixel| self.variance(pixel, all)).collect());
        (self.squares, self.scrambles, self.turns, self.control, self.blur) = (None, None, None, None, None);
    }

    /// The further sums, if they are kept.
    pub fn detail(&self) -> Option<&LayerMoments> {
        self.detail.as_ref()
    }

    /// The planes that make up something.
    pub fn planes_of(&self, together: Together) -> impl Iterator<Item = usize> {
        self.planes.iter().enumerate().filter(move |(_, key)| together.has(key)).map(|(plane, _)| plane)
    }

    /// The rows, top to bottom, to be filled in parallel; for films that are sampled per pass.
    pub fn rows(&mut self) -> impl Iterator<Item = (usize, Row<'_>)> {
        let planes = self.planes.len();
        let components = self.components;
        let mut details = self.detail.as_mut().map(LayerMoments::rows);
        let mut turns = self.turns.as_mut().map(RqmcVariance::rows);
        let mut control = self.control.as_mut().map(ControlVariates::rows);
        let mut blur = self.blur.as_mut().map(KernelBias::rows);
        let mut totals = self.totals.rows();
        let mut map = self.map.as_ref().map(SampleMap::rows);
        let coarse = self.coarse;
        self.sums
            .rows()
            .zip(self.squares.iter_mut().flat_map(Tiles::rows))
            .map(move |(sums, squares)| Row {
                planes,
                components,
                sums,
                squares,
                turns: turns.as_mut().and_then(Iterator::next),
                control: control.as_mut().and_then(Iterator::next),
                detail: details.as_mut().and_then(Iterator::next),
                blur: blur.as_mut().and_then(Iterator::next),
                totals: totals.next(),
                map: map.as_mut().and_then(Iterator::next),
                coarse,
            })
            .enumerate()
    }

    /// To be called when rows have passes `first .. first + count` in them.
    pub fn close(&mut self, first: u64, count: u64) {
        if let Some(map) = &mut self.map {
            map.close(first..first.saturating_add(count));
            if !(self.coarse && map.range() == [1; 2]) {
                // A pass that is not whole has no total yet.
                if !self.coarse {
                    self.totals.close();
                }
                return;
            }
            (self.map, self.coarse) = (None, false);
        }
        self.totals.close();
        self.passes += count;
        if let Some(turns) = &mut self.turns {
            turns.close(first, count);
        }
    }

    /// Adds what a pass has cost beside its rows: counted work.
    pub fn add_work(&mut self, pass: u64, work: u64) {
        self.totals.add_work(pass, work);
    }

    /// Number and counted work of the closed passes since this was asked last.
    pub fn take_works(&mut self) -> Vec<(u64, u64)> {
        self.totals.take_works()
    }

    /// The sums of whole passes.
    pub fn totals(&self) -> &Totals {
        &self.totals
    }

    /// Puts sums of whole passes that were stored; false if they are of another kind of film.
    pub fn put_totals(&mut self, sums: Vec<[Sum; 2]>) -> bool {
        self.totals.put(sums)
    }

    /// How many times smaller the variance of the whole picture is than those of its pixels say together, for pixels of each
    /// number of passes: see [`RqmcVariance`]. For films whose pixels have sequences of their own.
    pub fn saved_by_evenness(&self) -> Saved {
        let all = self.planes.len();
        let of_pixel = |pixel: usize| {
            let [sum, square] = self.moments(pixel, all);
            let spread = self.covariance_of_means(pixel, sum, sum, square).max(0.0);
            PixelMean { mean: sum / self.passes_of(pixel).max(1) as f64, spread, variance: self.variance(pixel, all) }
        };
        let Some(turns) = &self.turns else { return Saved::NOTHING };
        match &self.map {
            None => Saved(vec![(self.passes, turns.saved((self.passes, turns.surplus()), |_| true, of_pixel))]),
            Some(map) => {
                let of_count = |passes: u64| {
                    let own = |pixel: usize| map.made(pixel) == passes;
                    (passes, turns.saved((passes, &turns.evenness().surplus_of(passes)), own, of_pixel))
                };
                Saved(map.counts().into_iter().map(of_count).collect())
            }
        }
    }

    /// Adds the light of one path of a scramble that landed in `pixel`: the entries of one plane.
    pub fn splat(&mut self, pixel: usize, plane: usize, scramble: usize, entries: &[Light]) {
        for (entry, light) in self.entries_of(plane).zip(entries) {
            add(self.sums.grown(pixel, entry, depth(light)), light);
        }
        let light = self.components.luminance(entries);
        if let Some(scrambles) = &mut self.scrambles {
            scrambles.add((pixel, plane), scramble, light);
        }
    }

    /// To be called after splats, before variances are asked for: a pixel's leans on what the whole plane tells.
    pub fn settle(&mut self) {
        if let Some(scrambles) = &mut self.scrambles {
            scrambles.settle();
        }
    }

    fn entries_of(&self, plane: usize) -> Range<usize> {
        let count = self.components.count();
        plane * count..(plane + 1) * count
    }

    /// Sum of the luminance of a pixel in a plane.
    fn sum(&self, pixel: usize, plane: usize) -> Light {
        let light = |entry: usize| value_of(self.sums.stored(pixel, entry));
        match self.components {
            Components::Luminance => light(plane),
            Components::Rec709 => self.components.luminance(&[0, 1, 2].map(|c| light(3 * plane + c))),
        }
    }

    /// Sums over the passes of the luminance of a pixel, in a plane or in all together (`plane == planes.len()`), and of its square.
    fn moments(&self, pixel: usize, plane: usize) -> [f64; 2] {
        let planes = self.planes.len();
        let sum = if plane < planes {
            self.sum(pixel, plane).value
        } else {
            (0..planes).map(|plane| self.sum(pixel, plane).value).sum()
        };
        let square = |squares: &Tiles| squares.sum(pixel, plane.min(total_of(planes))).value();
        [sum, self.squares.as_ref().map_or(0.0, square)]
    }

    /// By what the variance of all planes together is regressed. Where parts of the picture state their errors, too, all of them are
    /// by the spread: mixtures compare them.
    fn regressed(&self) -> Option<&ControlVariates> {
        self.control.as_ref().filter(|_| self.detail.is_none())
    }

    /// Passes that a pixel has.
    pub fn passes_of(&self, pixel: usize) -> u64 {
        self.map.as_ref().map_or(self.passes, |map| map.made(pixel))
    }

    /// Passes of each pixel, where they are not the same for all.
    pub fn sample_map(&self) -> Option<&SampleMap> {
        self.map.as_ref()
    }

    /// The same, for pixels to get passes of their own; from now on passes of all pixels are no more. Only where each pixel
    /// has a sequence of its own.
    pub fn sample_map_mut(&mut self) -> &mut SampleMap {
        self.map.get_or_insert_with(|| SampleMap::new([self.width, self.height], self.passes))
    }

    /// The passes that all pixels, or some, are still to get.
    pub fn missing(&self) -> Option<Range<u64>> {
        match &self.map {
            Some(map) => map.missing(),
            None => Some(self.passes..self.wanted).filter(|passes| !passes.is_empty()),
        }
    }

    /// The passes that a pixel is to have.
    pub fn wanted_of(&self, pixel: usize) -> u64 {
        self.map.as_ref().map_or(self.wanted.max(self.passes), |map| map.wanted(pixel))
    }

    /// Has the first pass begin with some of the pixels, those for which `first` says so; asked again it goes on with others.
    /// Meanwhile a pixel without any shows its neighbour in the direction of the first ([`SampleMap::shown`]).
    pub fn want_first(&mut self, first: impl Fn([usize; 2]) -> bool) {
        if self.passes > 0 {
            return;
        }
        self.coarse = true;
        let width = self.width.max(1);
        let map = self.sample_map_mut();
        (0..map.pixels()).filter(|pixel| first([pixel % width, pixel / width])).for_each(|pixel| map.want(pixel, 1));
    }

    /// The share of the pixels that have been traced.
    pub fn traced_share(&self) -> f64 {
        self.map.as_ref().filter(|_| self.coarse).map_or(1.0, SampleMap::mean)
    }

    /// The pixel whose light is shown at a pixel.
    fn shown(&self, pixel: usize) -> usize {
        self.map.as_ref().filter(|_| self.coarse).map_or(pixel, |map| map.shown(pixel))
    }

    /// The most passes that a pixel has.
    pub fn most_passes(&self) -> u64 {
        self.map.as_ref().map_or(self.passes, |map| map.range()[1])
    }

    /// The passes that a pixel has on average.
    pub fn mean_passes(&self) -> f64 {
        self.map.as_ref().map_or(self.passes as f64, |map| map.mean())
    }

    /// Gives the memory of all sums back: what was counted stays, and no light.
    pub fn forget_light(&mut self) {
        let empty = Film::new(0, 0, Vec::new(), self.components, self.sampling);
        let counted = std::mem::replace(self, empty);
        (self.passes, self.map, self.coarse) = (counted.passes, counted.map, counted.coarse);
    }

    /// Independent values of a pixel that tell its variance.
    pub fn samples_of(&self, pixel: usize) -> u64 {
        match self.sampling {
            Sampling::PerPass => self.passes_of(pixel),
            Sampling::PerScramble { .. } => REPLICATES as u64,
        }
    }

    /// By how many of them its stated variance is told: one less, and what [is known](ControlVariates) of passes takes.
    pub fn freedom_of(&self, pixel: usize) -> u64 {
        let spent = self.regressed().map_or(0, |control| control.spent(self.passes_of(pixel)));
        self.samples_of(pixel).saturating_sub(1 + spent).max(1)
    }

    /// The least of them.
    pub fn samples(&self) -> u64 {
        match self.sampling {
            Sampling::PerPass => self.passes,
            Sampling::PerScramble { .. } => REPLICATES as u64,
        }
    }

    /// Mean luminance of a pixel in a plane.
    pub fn mean(&self, pixel: usize, plane: usize) -> Light {
        let pixel = self.shown(pixel);
        self.sum(pixel, plane).scaled(1.0 / self.passes_of(pixel).max(1) as f64)
    }

    /// Mean light of a pixel in a plane, one entry per component.
    pub fn mean_entries(&self, pixel: usize, plane: usize) -> impl Iterator<Item = Light> {
        let pixel = self.shown(pixel);
        let factor = 1.0 / self.passes_of(pixel).max(1) as f64;
        self.entries_of(plane).map(move |entry| value_of(self.sums.stored(pixel, entry)).scaled(factor))
    }

    /// Variance of the mean `value` of a pixel: of one plane, or of the sum over planes (`plane == planes.len()`).
    /// Zero when there are not yet two samples.
    pub fn variance(&self, pixel: usize, plane: usize) -> f64 {
        let planes = self.planes.len();
        if let Some(variances) = &self.variances {
            return if plane == planes || planes == 1 { variances[pixel] } else { f64::INFINITY };
        }
        if let Some(scrambles) = &self.scrambles {
            let own = if plane < planes { plane..plane + 1 } else { 0..planes };
            return scrambles.variance(pixel, own) * self.per_pass2(pixel);
        }
        let [sum, square] = self.moments(pixel, plane);
        let of_all = self.regressed().filter(|_| plane == planes || planes == 1);
        let left = of_all.and_then(|control| control.variance(pixel, self.passes_of(pixel), sum, square));
        left.unwrap_or_else(|| self.covariance_of_means(pixel, sum, sum, square).max(0.0))
    }

    /// Variance of the mean `value` of some of a pixel's planes together; none if it is not kept or the film has none of
    /// them.
    pub fn variance_of(&self, pixel: usize, together: Together) -> Option<f64> {
        let detail = self.detail.as_ref()?;
        let planes = || self.planes_of(together);
        let first = planes().next()?;
        if let Some(scrambles) = &self.scrambles {
            return Some(scrambles.variance(pixel, planes()) * self.per_pass2(pixel));
        }
        match detail.square(pixel, together) {
            Some(square) => {
                let sum: f64 = planes().map(|plane| self.sum(pixel, plane).value).sum();
                Some(self.covariance_of_means(pixel, sum, sum, square).max(0.0))
            }
            None => Some(self.variance(pixel, first)),
        }
    }

    /// What a mixture of `open` and `content` of a light group's share of a layer needs for its standard error; none if it
    /// is not kept.
    pub fn mix_error(&self, pixel: usize, (layer, group): (Layer, GroupId)) -> Option<MixError> {
        let planes = || self.planes_of(Together::Share(layer, group));
        if let Some(scrambles) = &self.scrambles {
            let MixError { open, content, covariance } = scrambles.mix_error(pixel, planes())?;
            let per = self.per_pass2(pixel);
            return Some(MixError { open: open * per, content: content * per, covariance: covariance * per });
        }
        let mixed = self.detail.as_ref()?.mixed(pixel, (layer, group))?;
        let mut sum = Light::default();
        planes().for_each(|plane| sum.add(self.sum(pixel, plane)));
        let (open, content) = (sum.open(), sum.content());
        Some(MixError {
            open: self.covariance_of_means(pixel, open, open, mixed.open2).max(0.0),
            content: self.covariance_of_means(pixel, content, content, mixed.content2).max(0.0),
            covariance: self.covariance_of_means(pixel, open, content, mixed.open_content),
        })
    }

    /// Variance of the mean of `content` − `open` in a plane among several of its share: what another contrast of the one slide that
    /// its light crosses makes of it is in proportion to that. None if it is not kept.
    pub fn change_variance(&self, pixel: usize, plane: usize) -> Option<f64> {
        if let Some(scrambles) = &self.scrambles {
            return Some(scrambles.change_variance(pixel, plane)? * self.per_pass2(pixel));
        }
        let light = self.sum(pixel, plane);
        let change = light.content() - light.open();
        let Some(squares) = self.detail.as_ref()?.change2(pixel, plane) else {
            // The plane is all of its share.
            let PlaneKey { layer, group, .. } = self.planes[plane];
            let MixError { open, content, covariance } = self.mix_error(pixel, (layer, group))?;
            return Some((open + content - 2.0 * covariance).max(0.0));
        };
        Some(self.covariance_of_means(pixel, change, change, squares).max(0.0))
    }

    /// Covariance of two means over the passes from the sums over samples of the two and of their product.
    fn covariance_of_means(&self, pixel: usize, a: f64, b: f64, product: f64) -> f64 {
        let passes = self.passes_of(pixel) as f64;
        if passes < 2.0 {
            return 0.0;
        }
        let of_sum = (product - a * b / passes) * passes / (passes - 1.0);
        of_sum * self.per_pass2(pixel)
    }

    /// From the variance of a sum over passes to that of their mean.
    fn per_pass2(&self, pixel: usize) -> f64 {
        let passes = self.passes_of(pixel).max(1) as f64;
        1.0 / (passes * passes)
    }
}

/// Where the squares of the sum over so many planes are: those of one plane are its own.
fn total_of(planes: usize) -> usize {
    if planes > 1 { planes } else { 0 }
}

impl Row<'_> {
    /// Adds what pixel `x` has in a pass beyond what a quarter of the kernel's area brings, cd/m².
    pub fn add_blur(&mut self, x: usize, beyond: f64) {
        if let Some(blur) = &mut self.blur {
            kernel_bias::add(blur, x, beyond);
        }
    }

    /// Whether pixel `x` is still to get the pass of this number.
    pub fn wants(&self, x: usize, pass: u64) -> bool {
        self.map.is_none_or(|map| map.wants(x, pass))
    }

    /// Adds the counted work of this row in a pass.
    pub fn add_work(&mut self, pass: u64, work: u64) {
        if let Some(totals) = &mut self.totals {
            totals.add_work(pass, work);
        }
    }

    /// Adds the light of pixel `x` in the pass of this number: the entries of each plane in turn.
    pub fn add_pass(&mut self, x: usize, number: u64, pass: &[Light]) {
        let count = self.components.count();
        for (entry, light) in pass.iter().enumerate() {
            add(self.sums.grown(x, entry, depth(light)), light);
        }
        let mut total = 0.0;
        for plane in 0..self.planes {
            let light = self.components.luminance(&pass[plane * count..(plane + 1) * count]);
            if light.value != 0.0 {
                self.squares.grown(x, plane, 1)[0].add(light.value * light.value);
            }
            total += light.value;
            // Of passes that some pixels have not had there is no total.
            if let Some(totals) = self.totals.as_mut().filter(|_| self.map.is_none() || self.coarse) {
                totals.add((x, plane), number, light);
            }
            if let Some(detail) = &mut self.detail {
                detail.add((x, plane), light);
            }
        }
        let all = total_of(self.planes);
        if all > 0 && total != 0.0 {
            self.squares.grown(x, all, 1)[0].add(total * total);
        }
        if let Some(turns) = &mut self.turns {
            turns.add(x, number, total);
        }
        if let Some(control) = &mut self.control {
            control.add(x, number, total);
        }
        if let Some(detail) = &mut self.detail {
            detail.close(x);
        }
    }
}

#[cfg(test)]
#[path = "accumulate_tests.rs"]
mod tests;
