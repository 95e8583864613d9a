//! A film as columns of numbers: how shards and checkpoints carry it, and how films of different passes are added up.

use super::accumulate::Film;
use super::turns::PER_PIXEL;
use crate::base::twofold::Sum;

/// A kind of sum that a film holds: `stride` sums per pixel, pixel after pixel.
pub struct Table<S> {
    /// What the sums are of: `light`, `squares`, `scrambles` …
    pub name: &'static str,
    pub stride: usize,
    pub sums: S,
}

const NAMES: [&str; COUNT] = [
    "light",
    "squares",
    "scrambles",
    "scramble_squares",
    "scramble_open",
    "scramble_content",
    "mixed_squares",
    "layer_squares",
    "turns",
    "blur",
];
const COUNT: usize = 10;

impl Film {
    /// All sums of the film, those of kinds that it does not keep left out.
    pub fn tables(&self) -> Vec<Table<&[Sum]>> {
        let scrambles = self.scrambles.as_ref();
        let detail = self.detail.as_ref();
        let all: [&[Sum]; COUNT] = [
            self.sums.as_flattened(),
            &self.squares,
            scrambles.map_or(&[], |s| s.value.as_flattened()),
            scrambles.map_or(&[], |s| &s.squares),
            scrambles.map_or(&[], |s| s.open.as_flattened()),
            scrambles.map_or(&[], |s| s.content.as_flattened()),
            detail.map_or(&[], |d| d.mixed.as_flattened()),
            detail.map_or(&[], |d| &d.squares),
            self.turns.as_ref().map_or(&[], |t| t.sums.as_flattened()),
            self.blur.as_ref().map_or(&[], |b| b.sums.as_flattened()),
        ];
        self.named(all, |sums| sums.len())
    }

    /// The same, to be filled.
    pub fn tables_mut(&mut self) -> Vec<Table<&mut [Sum]>> {
        let pixels = self.pixels();
        let (value, squares, open, content): (&mut [Sum], &mut [Sum], &mut [Sum], &mut [Sum]) = match &mut self
            .scrambles
        {
            Some(s) => {
                (s.value.as_flattened_mut(), &mut s.squares, s.open.as_flattened_mut(), s.content.as_flattened_mut())
            }
            None => (&mut [], &mut [], &mut [], &mut []),
        };
        let (mixed, layers): (&mut [Sum], &mut [Sum]) = match &mut self.detail {
            Some(d) => (d.mixed.as_flattened_mut(), &mut d.squares),
            None => (&mut [], &mut []),
        };
        let turns: &mut [Sum] = self.turns.as_mut().map_or(&mut [], |t| t.sums.as_flattened_mut());
        let blur: &mut [Sum] = self.blur.as_mut().map_or(&mut [], |b| b.sums.as_flattened_mut());
        let light = self.sums.as_flattened_mut();
        let all = [light, &mut self.squares, value, squares, open, content, mixed, layers, turns, blur];
        named(pixels, all, |sums| sums.len())
    }

    fn pixels(&self) -> usize {
        self.width * self.height
    }

    fn named<S>(&self, all: [S; COUNT], length: impl Fn(&S) -> usize) -> Vec<Table<S>> {
        named(self.pixels(), all, length)
    }

    /// Passes for, less passes against, of its [turns](crate::film::turns); zeros if it has none.
    pub fn surplus(&self) -> [i64; PER_PIXEL] {
        self.turns.as_ref().map_or([0; PER_PIXEL], |turns| turns.surplus)
    }

    pub fn set_surplus(&mut self, surplus: [i64; PER_PIXEL]) {
        if let Some(turns) = &mut self.turns {
            turns.surplus = surplus;
        }
    }

    /// Adds the passes of another film of the same picture. False, and nothing done, if it is of another kind.
    pub fn merge(&mut self, other: &Film) -> bool {
        let alike = (self.width, self.height, &self.planes, self.components, self.sampling)
            == (other.width, other.height, &other.planes, other.components, other.sampling);
        let theirs = other.tables();
        let mut own = self.tables_mut();
        if !alike || !own.iter().map(|t| (t.name, t.stride)).eq(theirs.iter().map(|t| (t.name, t.stride))) {
            return false;
        }
        for (own, theirs) in own.iter_mut().zip(&theirs) {
            own.sums.iter_mut().zip(theirs.sums).for_each(|(sum, more)| sum.merge(*more));
        }
        self.passes += other.passes;
        if let (Some(own), Some(theirs)) = (&mut self.turns, &other.turns) {
            own.surplus.iter_mut().zip(theirs.surplus).for_each(|(own, more)| *own = own.saturating_add(more));
        }
        self.settle();
        true
    }

    /// The first sum that is NaN or infinite: the name of its table and its pixel.
    pub fn first_invalid(&self) -> Option<(&'static str, usize)> {
        self.tables().into_iter().find_map(|table| {
            let at = table.sums.iter().position(|sum| !sum.is_finite())?;
            Some((table.name, at / table.stride.max(1)))
        })
    }
}

fn named<S>(pixels: usize, all: [S; COUNT], length: impl Fn(&S) -> usize) -> Vec<Table<S>> {
    let strides = |sums: &S| length(sums).checked_div(pixels).unwrap_or(0);
    let tables = NAMES.into_iter().zip(all).map(|(name, sums)| Table { name, stride: strides(&sums), sums });
    tables.filter(|table| table.stride > 0).collect()
}

#[cfg(test)]
mod tests {
    use crate::base::ids::GroupId;
    use crate::film::accumulate::{Components, Film, Light, PlaneKey, Sampling, Together};
    use crate::film::layer::Layer;

    const PLANES: [PlaneKey; 2] = [
        PlaneKey { layer: Layer::Direct, group: GroupId(0), takes: 0 },
        PlaneKey { layer: Layer::Forward, group: GroupId(1), takes: 0 },
    ];

    fn film(sampling: Sampling) -> Film {
        let film = Film::new(3, 2, PLANES.to_vec(), Components::Rec709, sampling).with_detail();
        if sampling == Sampling::PerPass { film.with_blur() } else { film }
    }

    /// Light of pass `pass` in every entry of a pixel: thirds, so that every sum is rounded.
    fn light(pixel: usize, pass: u64) -> Vec<Light> {
        let light = |k: usize| {
            let mut light = Light::ONE.scaled((1.0 + pixel as f64 + 7.0 * k as f64) / (3.0 + pass as f64));
            light.cross(0.9, 0.3, 0.1 * k as f64);
            light
        };
        (0..6).map(light).collect()
    }

    fn run(film: &mut Film, passes: std::ops::Range<u64>) {
        for pass in passes {
            match film.sampling {
                Sampling::PerPass => film.rows().for_each(|(y, mut row)| {
                    for x in 0..3 {
                        let light = light(3 * y + x, pass);
                        row.add_pass(x, pass, &light);
                        row.add_blur(x, light[0].value - 0.3);
                    }
                }),
                Sampling::PerScramble { .. } => (0..6).for_each(|pixel| {
                    let all = light(pixel, pass);
                    (0..2).for_each(|plane| film.splat(pixel, plane, (pass % 8) as usize, &all[3 * plane..][..3]));
                }),
            }
            film.close(pass, 1);
        }
        film.settle();
    }

    /// Passes in three pieces, added in another order, are the film of all passes to the last bit of every mean and
    /// variance.
    #[test]
    fn pieces_make_the_film() {
        for sampling in [Sampling::PerPass, Sampling::PerScramble { paths: 64 }] {
            let mut whole = film(sampling);
            run(&mut whole, 0..100);
            let mut pieces = [film(sampling), film(sampling), film(sampling)];
            pieces.iter_mut().zip([40..100, 0..7, 7..40]).for_each(|(piece, passes)| run(piece, passes));
            let [mut sum, second, third] = pieces;
            assert!(sum.merge(&second) && sum.merge(&third));
            assert_eq!(sum.passes, 100);
            for pixel in 0..6 {
                for (plane, key) in PLANES.iter().enumerate() {
                    assert_eq!(sum.mean(pixel, plane), whole.mean(pixel, plane));
                    let share = (key.layer, key.group);
                    assert_eq!(sum.mix_error(pixel, share), whole.mix_error(pixel, share));
                    assert!(sum.mean_entries(pixel, plane).eq(whole.mean_entries(pixel, plane)));
                    let layer = Together::Layer(key.layer);
                    assert_eq!(sum.variance_of(pixel, layer), whole.variance_of(pixel, layer));
                }
                assert_eq!(sum.variance(pixel, 2), whole.variance(pixel, 2));
                assert!(whole.variance(pixel, 2) > 0.0);
                assert_eq!(sum.blur2(pixel), whole.blur2(pixel));
                assert_eq!(whole.blur2(pixel) != 0.0, sampling == Sampling::PerPass);
            }
            assert_eq!(sum.saved_by_evenness(), whole.saved_by_evenness());
            assert_eq!(sum.turns, whole.turns);
        }
    }

    #[test]
    fn refuses_films_of_another_kind_and_finds_nan() {
        let mut own = film(Sampling::PerPass);
        run(&mut own, 0..3);
        let before = own.clone();
        assert!(!own.merge(&film(Sampling::PerScramble { paths: 64 })));
        assert!(!own.merge(&Film::new(3, 2, PLANES.to_vec(), Components::Rec709, Sampling::PerPass)));
        assert!(!own.merge(&Film::new(2, 3, PLANES.to_vec(), Components::Rec709, Sampling::PerPass).with_detail()));
        let without_blur = Film::new(3, 2, PLANES.to_vec(), Components::Rec709, Sampling::PerPass).with_detail();
        assert!(!own.merge(&without_blur));
        assert_eq!(own, before);
        assert_eq!(own.first_invalid(), None);
        own.rows()
            .for_each(|(y, mut row)| row.add_pass(1, 3, &[Light::ONE.scaled(if y == 1 { f64::NAN } else { 1.0 }); 6]));
        assert_eq!(own.first_invalid(), Some(("light", 4)));
    }
}
