//! Sums of light per pixel, layer and group. A film belongs to one estimator; films are added up when the frame is made.

use super::detail::{Detail, DetailRow};
use super::layer::Layer;
use super::scrambles::Scrambles;
use crate::base::colour::ColourSpace;
use crate::base::ids::GroupId;
use crate::base::lpe::Takes;
use crate::base::twofold::Sum;

/// Light of one path or pixel, cd/m² (or lm before it is measured), as it depends on the slide's contrast.
///
/// With u = 1 − 1/C a slide transmits T_white·(1 − u·(1 − s)): the light of a path that crosses it n times is a
/// polynomial of degree n in u, and so is any sum. Of light that crosses more often than [`Light::DEGREE`] times `powers`
/// has a polynomial of that degree that is the same at C = 1, at C = ∞ and, unless the crossings lie on both pieces of a
/// joined path, at the scene's own contrast; the frame's maker measures what the last costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// At the scene's own contrast.
    pub value: f64,
    /// Coefficients of 1, u, u², …
    pub powers: [f64; Light::DEGREE + 1],
}

impl Light {
    pub const DEGREE: usize = 4;
    /// One, at every contrast.
    pub const ONE: Light = Light { value: 1.0, powers: [1.0, 0.0, 0.0, 0.0, 0.0] };

    /// With the slide fully open, C = 1.
    pub fn open(self) -> f64 {
        self.powers[0]
    }
    /// At C = ∞.
    pub fn content(self) -> f64 {
        self.powers.iter().sum()
    }
    pub fn add(&mut self, other: Light) {
        self.value += other.value;
        self.powers.iter_mut().zip(other.powers).for_each(|(a, b)| *a += b);
    }
    #[must_use]
    pub fn scaled(self, factor: f64) -> Light {
        Light { value: self.value * factor, powers: self.powers.map(|p| p * factor) }
    }
    /// Crosses a slide: transmittance `t_white` when open, `value` at its contrast, picture value `s`.
    pub fn cross(&mut self, t_white: f64, value: f64, s: f64) {
        const D: usize = Light::DEGREE;
        self.value *= value;
        // Coefficient of −u^(D + 1).
        let beyond = t_white * (1.0 - s) * self.powers[D];
        for k in (0..=Self::DEGREE).rev() {
            let below = if k > 0 { self.powers[k - 1] } else { 0.0 };
            self.powers[k] = t_white * (self.powers[k] - (1.0 - s) * below);
        }
        if beyond != 0.0 {
            // With u₀ = 1 − 1/C of the slide, u^(D + 1) is (1 + u₀)·u^D − u₀·u^(D − 1) at 0, u₀ and 1.
            let own = ((t_white - value) / (t_white * (1.0 - s))).clamp(0.0, 1.0);
            self.powers[D] -= (1.0 + own) * beyond;
            self.powers[D - 1] += own * beyond;
        }
    }
    /// Two pieces of a path one after the other.
    #[must_use]
    pub fn times(self, other: Light) -> Light {
        let mut powers = [0.0; Self::DEGREE + 1];
        // Most pieces cross no slide.
        for (i, a) in self.powers.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            for (j, b) in other.powers.iter().enumerate() {
                powers[(i + j).min(Self::DEGREE)] += a * b;
            }
        }
        Light { value: self.value * other.value, powers }
    }
    pub fn is_finite(self) -> bool {
        (self.value + self.content()).is_finite()
    }
}

/// Sums of [`Light`]: of its `value`, then of its `powers`.
pub(super) type LightSum = [Sum; Light::DEGREE + 2];

fn add(sum: &mut LightSum, light: &Light) {
    let [value, powers @ ..] = sum;
    value.add(light.value);
    powers.iter_mut().zip(light.powers).for_each(|(sum, power)| sum.add(power));
}

fn value_of([value, powers @ ..]: &LightSum) -> Light {
    Light { value: value.value(), powers: powers.map(Sum::value) }
}

/// Which light a plane of a film holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct PlaneKey {
    pub layer: Layer,
    pub group: GroupId,
    /// Which light path expressions take it, of those that part classes: bit [`Aov::part`](super::aov::Aov::part).
    #[serde(default, skip_serializing_if = "is_none_taken")]
    pub takes: Takes,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde asks for it
fn is_none_taken(takes: &Takes) -> bool {
    *takes == 0
}

/// Planes whose light is one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Together {
    Layer(Layer),
    /// A light group's share of a layer.
    Share(Layer, GroupId),
    /// What the light path expression of this bit takes.
    Taken(u32),
}

impl Together {
    pub fn has(self, key: &PlaneKey) -> bool {
        match self {
            Together::Layer(layer) => key.layer == layer,
            Together::Share(layer, group) => (key.layer, key.group) == (layer, group),
            Together::Taken(bit) => key.takes.checked_shr(bit).unwrap_or(0) & 1 == 1,
        }
    }
}

/// How the samples of a film are counted, for its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Each pass gives one independent value per pixel.
    PerPass,
    /// A pass is `paths` paths dealt to independent scrambles, see [`Scrambles`].
    PerScramble { paths: u64 },
}

/// What a plane of a film holds per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Components {
    Luminance,
    /// Linear Rec.709, whose luminance is Y.
    Rec709,
}

impl Components {
    pub fn count(self) -> usize {
        match self {
            Components::Luminance => 1,
            Components::Rec709 => 3,
        }
    }

    /// The luminance of one plane's entries.
    pub fn luminance(self, entries: &[Light]) -> Light {
        match (self, entries) {
            (Components::Rec709, [r, g, b]) => {
                let [wr, wg, wb] = ColourSpace::Rec709.luminance_weights();
                let mut sum = r.scaled(wr);
                sum.add(g.scaled(wg));
                sum.add(b.scaled(wb));
                sum
            }
            (Components::Luminance | Components::Rec709, entries) => entries.first().copied().unwrap_or_default(),
        }
    }
}

/// Sums over passes, pixel-major so that a row is one contiguous piece.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    pub width: usize,
    pub height: usize,
    pub planes: Vec<PlaneKey>,
    /// Values per plane: luminance alone, or linear Rec.709.
    pub components: Components,
    pub sampling: Sampling,
    /// Passes added so far.
    pub passes: u64,
    /// `[pixel][plane][component]`
    pub(super) sums: Vec<LightSum>,
    /// `[pixel][plane]`, then one more for the sum over planes: squares of the luminance. Empty where scrambles tell.
    pub(super) squares: Vec<Sum>,
    pub(super) scrambles: Option<Scrambles>,
    /// Kept on request.
    pub(super) detail: Option<Detail>,
}

/// One row of a film, for the thread that owns it.
pub struct Row<'f> {
    planes: usize,
    components: Components,
    sums: &'f mut [LightSum],
    squares: &'f mut [Sum],
    detail: Option<DetailRow<'f>>,
}

/// Variances and covariance of the mean `open` and `content` of a pixel's light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MixError {
    pub open: f64,
    pub content: f64,
    pub covariance: f64,
}

impl Film {
    pub fn new(width: usize, height: usize, planes: Vec<PlaneKey>, components: Components, sampling: Sampling) -> Self {
        let (pixels, count) = (width * height, planes.len());
        let (squares, scrambles) = match sampling {
            Sampling::PerPass => (vec![Sum::ZERO; pixels * (count + 1)], None),
            Sampling::PerScramble { paths } => (Vec::new(), Some(Scrambles::new(pixels, count, paths))),
        };
        Film {
            width,
            height,
            planes,
            components,
            sampling,
            passes: 0,
            sums: vec![LightSum::default(); pixels * count * components.count()],
            squares,
            scrambles,
            detail: None,
        }
    }

    /// Keeps what standard errors per layer, and of mixtures of `open` and `content`, need.
    #[must_use]
    pub fn with_detail(mut self) -> Self {
        // With scrambles only the list of layers is needed.
        let pixels = if self.scrambles.is_some() { 0 } else { self.width * self.height };
        self.detail = Some(Detail::new(pixels, &self.planes));
        if let Some(scrambles) = &mut self.scrambles {
            scrambles.keep_mixed();
        }
        self
    }

    /// The further sums, if they are kept.
    pub fn detail(&self) -> Option<&Detail> {
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
        let width = self.width;
        let mut details = self.detail.as_mut().map(|detail| detail.rows(width));
        self.sums
            .chunks_mut((width * planes * components.count()).max(1))
            .zip(self.squares.chunks_mut(width * (planes + 1)))
            .map(move |(sums, squares)| Row {
                planes,
                components,
                sums,
                squares,
                detail: details.as_mut().and_then(Iterator::next),
            })
            .enumerate()
    }

    /// Adds the light of one path of a scramble that landed in `pixel`: the entries of one plane.
    pub fn splat(&mut self, pixel: usize, plane: usize, scramble: usize, entries: &[Light]) {
        let entry = pixel * self.planes.len() + plane;
        let at = self.entries_at(pixel, plane);
        self.sums[at].iter_mut().zip(entries).for_each(|(sum, light)| add(sum, light));
        let light = self.components.luminance(entries);
        if let Some(scrambles) = &mut self.scrambles {
            scrambles.add(entry, scramble, light);
        }
    }

    /// To be called after splats, before variances are asked for: a pixel's leans on what the whole plane tells.
    pub fn settle(&mut self) {
        if let Some(scrambles) = &mut self.scrambles {
            scrambles.settle();
        }
    }

    fn entries_at(&self, pixel: usize, plane: usize) -> std::ops::Range<usize> {
        let count = self.components.count();
        let first = (pixel * self.planes.len() + plane) * count;
        first..first + count
    }

    /// Sum of the luminance of a pixel in a plane.
    fn sum(&self, pixel: usize, plane: usize) -> Light {
        let mut entries = [Light::default(); 3];
        let sums = &self.sums[self.entries_at(pixel, plane)];
        entries.iter_mut().zip(sums).for_each(|(entry, sum)| *entry = value_of(sum));
        self.components.luminance(&entries[..sums.len().min(3)])
    }

    /// Mean luminance of a pixel in a plane.
    pub fn mean(&self, pixel: usize, plane: usize) -> Light {
        self.sum(pixel, plane).scaled(1.0 / self.passes.max(1) as f64)
    }

    /// Mean light of a pixel in a plane, one entry per component.
    pub fn mean_entries(&self, pixel: usize, plane: usize) -> impl Iterator<Item = Light> {
        let factor = 1.0 / self.passes.max(1) as f64;
        self.sums[self.entries_at(pixel, plane)].iter().map(move |sum| value_of(sum).scaled(factor))
    }

    /// Variance of the mean `value` of a pixel: of one plane, or of the sum over planes (`plane == planes.len()`).
    /// Zero when there are not yet two samples.
    pub fn variance(&self, pixel: usize, plane: usize) -> f64 {
        let planes = self.planes.len();
        if let Some(scrambles) = &self.scrambles {
            let own = if plane < planes { plane..plane + 1 } else { 0..planes };
            return scrambles.variance(pixel, own) * self.per_pass2();
        }
        let sum: f64 = if plane < planes {
            self.sum(pixel, plane).value
        } else {
            (0..planes).map(|plane| self.sum(pixel, plane).value).sum()
        };
        self.covariance_of_means(sum, sum, self.squares[pixel * (planes + 1) + plane].value()).max(0.0)
    }

    /// Variance of the mean `value` of some of a pixel's planes together; none if it is not kept or the film has none of
    /// them.
    pub fn variance_of(&self, pixel: usize, together: Together) -> Option<f64> {
        let detail = self.detail.as_ref()?;
        let planes = || self.planes_of(together);
        let first = planes().next()?;
        if let Some(scrambles) = &self.scrambles {
            return Some(scrambles.variance(pixel, planes()) * self.per_pass2());
        }
        match detail.square(pixel, together) {
            Some(square) => {
                let sum: f64 = planes().map(|plane| self.sum(pixel, plane).value).sum();
                Some(self.covariance_of_means(sum, sum, square).max(0.0))
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
            let per = self.per_pass2();
            return Some(MixError { open: open * per, content: content * per, covariance: covariance * per });
        }
        let mixed = self.detail.as_ref()?.mixed(pixel, (layer, group))?;
        let mut sum = Light::default();
        planes().for_each(|plane| sum.add(self.sum(pixel, plane)));
        let (open, content) = (sum.open(), sum.content());
        Some(MixError {
            open: self.covariance_of_means(open, open, mixed.open2).max(0.0),
            content: self.covariance_of_means(content, content, mixed.content2).max(0.0),
            covariance: self.covariance_of_means(open, content, mixed.open_content),
        })
    }

    /// Covariance of two means over the passes from the sums over samples of the two and of their product.
    fn covariance_of_means(&self, a: f64, b: f64, product: f64) -> f64 {
        let passes = self.passes as f64;
        if passes < 2.0 {
            return 0.0;
        }
        let of_sum = (product - a * b / passes) * passes / (passes - 1.0);
        of_sum * self.per_pass2()
    }

    /// From the variance of a sum over passes to that of their mean.
    fn per_pass2(&self) -> f64 {
        let passes = self.passes.max(1) as f64;
        1.0 / (passes * passes)
    }
}

impl Row<'_> {
    /// Adds one pass's light of pixel `x`: the entries of each plane in turn.
    pub fn add_pass(&mut self, x: usize, pass: &[Light]) {
        let count = self.components.count();
        let own = x * self.planes * count..(x + 1) * self.planes * count;
        self.sums[own].iter_mut().zip(pass).for_each(|(sum, light)| add(sum, light));
        let mut total = 0.0;
        for plane in 0..self.planes {
            let light = self.components.luminance(&pass[plane * count..(plane + 1) * count]);
            self.squares[x * (self.planes + 1) + plane].add(light.value * light.value);
            total += light.value;
            if let Some(detail) = &mut self.detail {
                detail.add(plane, light);
            }
        }
        self.squares[x * (self.planes + 1) + self.planes].add(total * total);
        if let Some(detail) = &mut self.detail {
            detail.close(x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: PlaneKey = PlaneKey { layer: Layer::Direct, group: GroupId(0), takes: 0 };

    fn light(value: f64) -> Light {
        Light::ONE.scaled(value)
    }

    /// The polynomial of up to four crossings equals the product of the slide's transmittances at any contrast.
    #[test]
    fn crossings_are_a_polynomial_in_the_contrast() {
        let crossings = [(0.9, 0.0), (0.9, 1.0), (0.9, 0.3), (0.9, 0.75)];
        for count in 0..=4 {
            let mut light = Light::ONE;
            crossings[..count].iter().for_each(|(t, s)| light.cross(*t, 0.5, *s));
            for contrast in [1.0, 2.0, 50.0, 300.0, f64::INFINITY] {
                let u: f64 = 1.0 - 1.0 / contrast;
                let want: f64 = crossings[..count].iter().map(|(t, s)| t * (1.0 - u * (1.0 - s))).product();
                let got: f64 = light.powers.iter().rev().fold(0.0, |sum, p| sum * u + p);
                assert!((got - want).abs() < 1e-14, "{count} crossings at {contrast}: {got} {want}");
            }
            assert_eq!(light.times(light).open(), light.open().powi(2));
        }
    }

    /// Light that crosses more often is right where it matters: open, at the slide's own contrast and at none of its light.
    #[test]
    fn many_crossings_are_right_at_three_contrasts() {
        const CONTRAST: f64 = 300.0;
        let at = |contrast: f64, t: f64, s: f64| t * (1.0 - (1.0 - 1.0 / contrast) * (1.0 - s));
        for places in
            [vec![(0.9, 0.0); 5], vec![(0.9, 1.0), (0.8, 0.3), (0.9, 0.75), (0.9, 0.0), (0.7, 0.2), (0.9, 0.5)]]
        {
            let mut light = Light::ONE;
            places.iter().for_each(|(t, s)| light.cross(*t, at(CONTRAST, *t, *s), *s));
            for contrast in [1.0, CONTRAST, f64::INFINITY] {
                let u = 1.0 - 1.0 / contrast;
                let want: f64 = places.iter().map(|(t, s)| at(contrast, *t, *s)).product();
                let got: f64 = light.powers.iter().rev().fold(0.0, |sum, p| sum * u + p);
                assert!((got - want).abs() < 1e-14, "{} crossings at {contrast}: {got} {want}", places.len());
            }
        }
    }

    #[test]
    fn mean_and_variance_per_pass() {
        let mut film = Film::new(1, 1, vec![KEY], Components::Luminance, Sampling::PerPass);
        for x in [1.0, 2.0, 4.0, 5.0] {
            film.rows().for_each(|(_, mut row)| row.add_pass(0, &[light(x)]));
            film.passes += 1;
        }
        assert_eq!(film.mean(0, 0).value, 3.0);
        // Unbiased variance 10/3 of one value, /4 for the mean.
        assert!((film.variance(0, 0) - 10.0 / 12.0).abs() < 1e-15);
        assert_eq!(film.variance(0, 0), film.variance(0, 1));
    }

    /// Two pixels with alike paths lean on each other, and the variance of both together stays what the scrambles say.
    #[test]
    fn pixels_lean_on_their_plane() {
        let mut film = Film::new(2, 1, vec![KEY], Components::Luminance, Sampling::PerScramble { paths: 64 });
        (0..8).for_each(|s| film.splat(0, 0, s, &[light(1.0)]));
        (0..4).for_each(|s| (0..2).for_each(|_| film.splat(1, 0, s, &[light(1.0)])));
        film.passes = 1;
        let alone = [0, 1].map(|pixel| film.variance(pixel, 0));
        assert!(alone[0] < 1e-12 && (alone[1] - 64.0 / 7.0).abs() < 1e-12, "{alone:?}");
        film.settle();
        let [quiet, loud] = [0, 1].map(|pixel| film.variance(pixel, 0));
        assert!((quiet + loud - alone[1]).abs() < 1e-12 && (quiet - 0.375 * alone[1]).abs() < 1e-12);
    }

    /// Eight scrambles that brought 0 to 7 in one pass: their sum has the variance 8·6, and the last counts twice if it has
    /// two of nine paths.
    #[test]
    fn variance_by_scrambles() {
        let mut film = Film::new(1, 1, vec![KEY], Components::Luminance, Sampling::PerScramble { paths: 64 });
        (0..8).for_each(|s| film.splat(0, 0, s, &[light(s as f64)]));
        film.passes = 1;
        assert_eq!(film.mean(0, 0).value, 28.0);
        assert!((film.variance(0, 0) - 8.0 * 6.0).abs() < 1e-12);
        assert_eq!(film.variance(0, 0), film.variance(0, 1));
        film.passes = 2;
        assert!((film.variance(0, 0) - 2.0 * 6.0).abs() < 1e-12);
        let mut even = Film::new(1, 1, vec![KEY], Components::Luminance, Sampling::PerScramble { paths: 9 });
        (0..8).for_each(|s| even.splat(0, 0, s, &[light(if s == 0 { 2.0 } else { 1.0 })]));
        even.passes = 1;
        assert!(even.variance(0, 0) < 1e-12);
    }
}
