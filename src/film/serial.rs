//! A film as columns of numbers: how shards and checkpoints carry it, and how films of different passes are added up.

use super::accumulate::Film;
use super::replicates::Replicates;
use super::rqmc_variance::RqmcVariance;
use super::sample_map::SampleMap;
use super::tiles::Tiles;
use eyebox_base::double_double::Sum;

/// The name of the table of [turns](super::turns).
const TURNS: &str = "turns";
/// That of the passes of each pixel, made and wanted, where they are not the same for all.
const PASSES: &str = "passes";

/// A kind of sum that a film holds.
pub struct Table<'f> {
    /// What the sums are of: `light`, `squares`, `scrambles` …
    pub name: &'static str,
    sums: Sums<'f>,
}

enum Sums<'f> {
    Tiles(&'f Tiles),
    RqmcVariance(&'f RqmcVariance),
    Passes(&'f SampleMap),
}

/// The same, to be filled.
pub struct TableMut<'f> {
    pub name: &'static str,
    sums: SumsMut<'f>,
}

enum SumsMut<'f> {
    Tiles(&'f mut Tiles),
    RqmcVariance(&'f mut RqmcVariance),
    Passes(&'f mut SampleMap),
}

impl Table<'_> {
    /// Sums per pixel.
    pub fn stride(&self) -> usize {
        match &self.sums {
            Sums::Tiles(tiles) => tiles.stride(),
            Sums::RqmcVariance(turns) => turns.evenness().per_pixel(),
            Sums::Passes(_) => 2,
        }
    }

    /// One of the sums of a pixel.
    pub fn sum(&self, pixel: usize, column: usize) -> Sum {
        match &self.sums {
            Sums::Tiles(tiles) => tiles.sum(pixel, column),
            Sums::RqmcVariance(turns) => turns.sum(pixel, column),
            Sums::Passes(map) => {
                let passes = if column == 0 { map.made(pixel) } else { map.wanted(pixel) };
                Sum { high: passes as f64, low: 0.0 }
            }
        }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        match &self.sums {
            Sums::Tiles(tiles) => tiles.bytes(),
            Sums::RqmcVariance(turns) => turns.bytes(),
            Sums::Passes(map) => map.bytes(),
        }
    }

    fn first_invalid(&self) -> Option<usize> {
        match &self.sums {
            Sums::Tiles(tiles) => tiles.first_invalid(),
            Sums::RqmcVariance(turns) => turns.first_invalid(),
            Sums::Passes(_) => None,
        }
    }
}

impl TableMut<'_> {
    /// Sums per pixel.
    pub fn stride(&self) -> usize {
        match &self.sums {
            SumsMut::Tiles(tiles) => tiles.stride(),
            SumsMut::RqmcVariance(turns) => turns.evenness().per_pixel(),
            SumsMut::Passes(_) => 2,
        }
    }

    /// Sets all sums of a pixel of an empty film. False if the film keeps none of it, and they are not zero.
    pub fn put(&mut self, pixel: usize, sums: &[Sum]) -> bool {
        match &mut self.sums {
            SumsMut::Tiles(tiles) => tiles.put(pixel, sums),
            SumsMut::RqmcVariance(turns) => return turns.put(pixel, sums),
            SumsMut::Passes(map) => {
                let [made, wanted] = [0, 1].map(|at| sums.get(at).map_or(0.0, |sum| sum.value()));
                let whole = |passes: f64| passes >= 0.0 && passes.fract() == 0.0;
                return whole(made) && whole(wanted) && map.put(pixel, made as u64, wanted as u64);
            }
        }
        true
    }
}

impl Film {
    /// All sums of the film, those of kinds that it does not keep left out.
    pub fn tables(&self) -> Vec<Table<'_>> {
        let scrambles = self.scrambles.as_ref();
        let mixed = scrambles.and_then(|s| s.mixed.as_ref());
        // Where scrambles tell, detail is no more than a list.
        let detail = self.detail.as_ref().filter(|_| scrambles.is_none());
        let tiles = [
            ("light", Some(&self.sums)),
            ("squares", self.squares.as_ref()),
            ("scrambles", scrambles.map(|s| &s.value)),
            ("scramble_squares", scrambles.map(|s| &s.squares)),
            ("scramble_open", mixed.map(|[open, _]| open)),
            ("scramble_content", mixed.map(|[_, content]| content)),
            ("mixed_squares", detail.map(|d| &d.mixed)),
            ("layer_squares", detail.map(|d| &d.squares)),
            ("change_squares", detail.and_then(|d| d.changes.as_ref())),
            ("blur", self.blur.as_ref().map(|b| &b.sums)),
            ("control", self.control.as_ref().map(|c| &c.products)),
        ];
        let tiles = tiles.into_iter().filter_map(|(name, tiles)| Some(Table { name, sums: Sums::Tiles(tiles?) }));
        let turns = self.turns.as_ref().map(|turns| Table { name: TURNS, sums: Sums::RqmcVariance(turns) });
        let passes = self.map.as_ref().map(|map| Table { name: PASSES, sums: Sums::Passes(map) });
        tiles.chain(turns).chain(passes).collect()
    }

    /// The same, to be filled.
    pub fn tables_mut(&mut self) -> Vec<TableMut<'_>> {
        let told = self.scrambles.is_some();
        let [value, squares, open, content] = match &mut self.scrambles {
            Some(Replicates { value, squares, mixed: Some([open, content]), .. }) => {
                [value, squares, open, content].map(Some)
            }
            Some(Replicates { value, squares, mixed: None, .. }) => [Some(value), Some(squares), None, None],
            None => [None, None, None, None],
        };
        let [mixed, layers, changes] = match &mut self.detail {
            Some(detail) if !told => [Some(&mut detail.mixed), Some(&mut detail.squares), detail.changes.as_mut()],
            Some(_) | None => [None, None, None],
        };
        let tiles = [
            ("light", Some(&mut self.sums)),
            ("squares", self.squares.as_mut()),
            ("scrambles", value),
            ("scramble_squares", squares),
            ("scramble_open", open),
            ("scramble_content", content),
            ("mixed_squares", mixed),
            ("layer_squares", layers),
            ("change_squares", changes),
            ("blur", self.blur.as_mut().map(|b| &mut b.sums)),
            ("control", self.control.as_mut().map(|c| &mut c.products)),
        ];
        let tiles = tiles.into_iter().filter_map(|(name, tiles)| Some(TableMut { name, sums: SumsMut::Tiles(tiles?) }));
        let turns = self.turns.as_mut().map(|turns| TableMut { name: TURNS, sums: SumsMut::RqmcVariance(turns) });
        let passes = self.map.as_mut().map(|map| TableMut { name: PASSES, sums: SumsMut::Passes(map) });
        tiles.chain(turns).chain(passes).collect()
    }

    /// What its passes count in each of its [turns](super::rqmc_variance); nothing if it has none.
    pub fn surplus(&self) -> &[i64] {
        self.turns.as_ref().map_or(&[], RqmcVariance::surplus)
    }

    /// False if that is of another kind of film.
    pub fn set_surplus(&mut self, surplus: Vec<i64>) -> bool {
        match &mut self.turns {
            Some(turns) if turns.surplus.len() == surplus.len() => turns.surplus = surplus,
            Some(_) => return false,
            None => return surplus.is_empty(),
        }
        true
    }

    /// Adds the passes of another film of the same picture. False, and nothing done, if it is of another kind. A film whose
    /// pixels have passes of their own can only be added to an empty one.
    pub fn merge(&mut self, other: &Film) -> bool {
        if other.map.is_some() && self.passes == 0 && self.map.is_none() {
            self.sample_map_mut();
        }
        let alike = (self.width, self.height, &self.planes, self.components, self.sampling)
            == (other.width, other.height, &other.planes, other.components, other.sampling);
        let theirs = other.tables();
        let mut own = self.tables_mut();
        if !alike || !own.iter().map(|t| (t.name, t.stride())).eq(theirs.iter().map(|t| (t.name, t.stride()))) {
            return false;
        }
        for (own, theirs) in own.iter_mut().zip(&theirs) {
            match (&mut own.sums, &theirs.sums) {
                (SumsMut::Tiles(own), Sums::Tiles(more)) => own.merge(more),
                (SumsMut::RqmcVariance(own), Sums::RqmcVariance(more)) => own.merge(more),
                (SumsMut::Passes(own), Sums::Passes(more)) if own.range() == [0; 2] => **own = (*more).clone(),
                // Tables of one name are of one kind.
                (SumsMut::Passes(_) | SumsMut::Tiles(_) | SumsMut::RqmcVariance(_), _) => return false,
            }
        }
        self.know(other.known().iter().copied());
        self.totals.merge(&other.totals);
        self.passes += other.passes;
        self.wanted = self.wanted.max(other.wanted);
        self.settle();
        true
    }

    /// The first sum that is NaN or infinite: the name of its table and its pixel.
    pub fn first_invalid(&self) -> Option<(&'static str, usize)> {
        self.tables().into_iter().find_map(|table| Some((table.name, table.first_invalid()?)))
    }
}

#[cfg(test)]
mod tests {
    use crate::accumulate::{Components, Film, Light, PlaneKey, Sampling, Together};
    use crate::layer::Layer;
    use eyebox_base::ids::GroupId;

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
            light.cross(0.9, 0.3, 0.1 * k as f64, (k % 3) as f64);
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
