//! What a witness says of the films of a run: for each kind of light, how much of what naive paths find is there, over the
//! picture and over parts of it, and whether they differ by more than the errors of both.
//!
//! Each pixel that was looked at counts by its own difference (looks less picture), so neither what the picture shows nor
//! the noise of single pixels has to be known: both are in how far the differences scatter. Three things are not in it.
//! *What pixels share*: photons gathered by many of them, wavelengths of a pass. Films say how far the totals of their passes
//! scatter. *What looks have not met yet*: a lamp that a naive path hits once in 10⁴ times leaves their mean low and their scatter
//! small. So where they find less than the picture, the variance is at least that of light that comes in lumps as large as
//! those met elsewhere, and tails are those of sums of bounded terms (S. Bernstein's inequality): the chance to miss it all is
//! e^−λ for λ lumps to be expected, not that of a Gaussian. *What is known to be off*: blur and tables say by how much.

use super::{Unwatched, Witness, pixels, sent};
use crate::accumulate::{Components, Film};
use crate::layer::Layer;
use crate::totals::{ACROSS, DOWN, PARTS, part_of};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::stats::{normal_tail, sidak_z};

/// Standard deviations beyond which a run is off, if there were but one thing to hold against it.
const SIGMAS: f64 = 4.0;
/// Times in a run that a witness is asked, at most: at doubling numbers of passes, the later of which know the earlier.
const CHECKS: usize = 4;
/// Fewer pixels, or looks, of a part don't tell how far differences scatter.
const FEWEST: usize = 16;
/// So many looks that brought light, and so many of these among the brightest, tell how bright a look may be: twice the brightest.
const TELLING: u64 = 64;
const BRIGHT: u64 = 16;
/// By how much tables of light on scatterers may be off, see `docs/estimators.md`.
const OF_TABLES: f64 = 2e-3;

/// A part of the picture that is off.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Off {
    /// Columns and rows of pixels, first and last of each, from 0; none: the whole picture.
    pub columns: Option<[usize; 2]>,
    pub rows: Option<[usize; 2]>,
    /// With all slides open.
    pub open: bool,
    /// Mean luminance of the run and of the witness, and the standard error of their difference, cd/m².
    pub run: f64,
    pub witness: f64,
    pub error: f64,
    /// Standard deviations, as unlikely as this is; above 0 the run is too bright.
    pub sigmas: f64,
}

/// What is said of one kind of light.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Judged {
    pub layer: Layer,
    pub group: GroupId,
    pub classes: Vec<Class>,
    /// It was looked for from the lamps: what was found is the least that there is. Else by rays from the eye.
    #[serde(default)]
    pub from_lamps: bool,
    /// Looks, or samples of what lamps send.
    pub looks: u64,
    /// Those that brought light, with all slides open.
    pub lit: u64,
    /// The run's light over that of the witness, and its standard error; none where the witness saw none.
    pub ratio: Option<[f64; 2]>,
    /// The same with all slides open.
    pub open: Option<[f64; 2]>,
    /// The part of the picture that is most surely off, if any is.
    pub off: Option<Off>,
}

/// What a witness says of a run.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Judgement {
    pub judged: Vec<Judged>,
    pub unwatched: Vec<Unwatched>,
    /// Standard deviations beyond which the whole picture is off, and a part of it, so many being asked.
    pub limits: [f64; 2],
    /// Counted work of the looks over that of the run.
    pub share: f64,
}

impl Judgement {
    /// Whether light is off that rays from the eye can trace in the place of who has it.
    pub fn asks_for_others(&self) -> bool {
        self.judged.iter().any(|judged| judged.off.is_some() && !judged.from_lamps)
    }

    /// Whether any light is off.
    pub fn is_off(&self) -> bool {
        self.judged.iter().any(|judged| judged.off.is_some())
    }
}

/// A difference that was tested.
struct Tested {
    run: f64,
    witness: f64,
    error: f64,
    sigmas: f64,
}

/// What the films have of one kind of light.
struct Light {
    /// `[pixel that is looked at]`: as the slides are, and open.
    pixels: Vec<[f64; 2]>,
    /// `[part]`: standard deviation of what pixels share, and what is known to be off: of the mean luminance.
    shared: Vec<f64>,
    allowed: Vec<f64>,
}

/// Holds films against what a witness saw. They are those of the same run, not condensed.
pub fn judge(witness: &Witness, films: &[&Film]) -> Judgement {
    let places = pixels(witness.size, witness.seed);
    // Half of what may be by chance for the whole picture, which is told best, half for its parts.
    let tests = (witness.watched.len() + witness.sent.len()) * 2 * CHECKS;
    let limits = [tests, tests * (PARTS - 1)].map(|tests| sidak_z(normal_tail(SIGMAS), tests));
    let part_of_slot = |slot: usize| {
        let (pixel, [width, _]) = (places[slot] as usize, witness.size);
        part_of([pixel % width, pixel / width], witness.size)
    };
    let parts: Vec<usize> = (0..places.len()).map(part_of_slot).collect();
    let judged = |(row, watched): (usize, &super::Watched)| {
        let light = light_of(witness, films, &places, row);
        let test = |part: usize, kind: usize| {
            let slots = (0..places.len()).filter(|slot| part == 0 || parts[*slot] == part);
            tested(witness, (row, kind), slots, &light, part)
        };
        let offs = (0..PARTS).flat_map(|part| [0, 1].map(|kind| (part, kind))).filter_map(|(part, kind)| {
            let Tested { run, witness: seen, error, sigmas } = test(part, kind)?;
            let [columns, rows] = span(part, witness.size);
            (sigmas.abs() > limits[usize::from(part > 0)]).then_some(Off {
                columns,
                rows,
                open: kind == 1,
                run,
                witness: seen,
                error,
                sigmas,
            })
        });
        let worst = |a: Off, b: Off| if b.sigmas.abs() > a.sigmas.abs() { b } else { a };
        let ratio = |kind: usize| {
            test(0, kind).filter(|all| all.witness > 0.0).map(|Tested { run, witness, error, .. }| {
                let ratio = run / witness;
                // Of the difference, relative to the larger: either may be all but nothing.
                [ratio, error / witness * ratio.max(1.0)]
            })
        };
        Judged {
            layer: watched.layer,
            group: watched.group,
            classes: watched.classes.clone(),
            from_lamps: false,
            looks: witness.looks(),
            lit: witness.tally(row)[1].lit,
            ratio: ratio(0),
            open: ratio(1),
            off: offs.reduce(worst),
        }
    };
    let looked = witness.watched.iter().enumerate().map(judged);
    Judgement {
        judged: looked.chain(sent::judge(witness, films, limits)).collect(),
        unwatched: witness.unwatched.clone(),
        limits,
        share: witness.work as f64 / witness.beside.max(1) as f64,
    }
}

/// Columns and rows of a part; none of the whole.
pub(super) fn span(part: usize, [width, height]: [usize; 2]) -> [Option<[usize; 2]>; 2] {
    let Some(part) = part.checked_sub(1) else { return [None; 2] };
    let along = |index: usize, of: usize, count: usize| {
        let first = |index: usize| (index * count).div_ceil(of);
        [first(index), first(index + 1).saturating_sub(1)]
    };
    [Some(along(part % ACROSS, ACROSS, width)), Some(along(part / ACROSS, DOWN, height))]
}

fn light_of(witness: &Witness, films: &[&Film], places: &[u32], row: usize) -> Light {
    let (watched, [width, height]) = (&witness.watched[row], witness.size);
    let (layer, group) = (watched.layer, watched.group);
    let mut light = Light { pixels: vec![[0.0; 2]; places.len()], shared: vec![0.0; PARTS], allowed: vec![0.0; PARTS] };
    let mut sizes = [0.0f64; PARTS];
    for pixel in 0..width * height {
        let part = part_of([pixel % width, pixel / width], witness.size);
        sizes[0] += 1.0;
        sizes[part] += 1.0;
    }
    for film in films {
        let planes: Vec<usize> = (0..film.planes.len())
            .filter(|plane| (film.planes[*plane].layer, film.planes[*plane].group) == (layer, group))
            .collect();
        if planes.is_empty() {
            continue;
        }
        for (own, pixel) in light.pixels.iter_mut().zip(places) {
            for plane in &planes {
                let mean = film.mean(*pixel as usize, *plane);
                *own = [own[0] + mean.value, own[1] + mean.open()];
            }
        }
        let passes = film.passes;
        if film.has_blur() || film.components == Components::Rec709 {
            for (part, shared) in light.shared.iter_mut().enumerate() {
                // Planes that expressions part one light into may swing together.
                let apart: f64 = planes.iter().map(|plane| film.totals().variance(*plane, part, passes).sqrt()).sum();
                let own = apart / sizes[part].max(1.0) * of_student(passes.saturating_sub(1) as f64);
                *shared = shared.hypot(own);
            }
        }
        if film.has_blur() {
            let mut squares = [0.0; PARTS];
            for pixel in 0..width * height {
                let blur2 = film.blur2(pixel);
                squares[0] += blur2;
                squares[part_of([pixel % width, pixel / width], witness.size)] += blur2;
            }
            // All pixels of a part may be off the same way.
            let own = squares.iter().zip(&sizes).map(|(square, size)| (square.max(0.0) / f64::max(*size, 1.0)).sqrt());
            light.allowed.iter_mut().zip(own).for_each(|(allowed, own)| *allowed += own);
        }
    }
    light
}

/// How many times further than four standard deviations of a Gaussian those of Student's distribution are as unlikely
/// (D. L. Wallace, Ann. Math. Stat. 30, 1959, solved for t).
pub(super) fn of_student(freedom: f64) -> f64 {
    if freedom < 1.0 {
        return f64::INFINITY;
    }
    let z = SIGMAS * (8.0 * freedom + 3.0) / (8.0 * freedom + 1.0);
    (freedom * ((z * z / freedom).exp() - 1.0)).sqrt() / SIGMAS
}

/// The z of a Gaussian that is as unlikely as a t of Student's distribution (the same).
pub(super) fn as_normal(t: f64, freedom: f64) -> f64 {
    (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) * (freedom * (t * t / freedom).ln_1p()).sqrt()
}

/// `kind`: 0 as the slides are, 1 with all of them open. None where there is too little to tell.
fn tested(
    witness: &Witness,
    (row, kind): (usize, usize),
    slots: impl Iterator<Item = usize>,
    light: &Light,
    part: usize,
) -> Option<Tested> {
    let slots: Vec<usize> = slots.filter(|slot| witness.looks_at(*slot) > 0).collect();
    let looks: f64 = slots.iter().map(|slot| witness.looks_at(*slot) as f64).sum();
    if slots.len() < FEWEST || looks < FEWEST as f64 {
        return None;
    }
    let times = |slot: usize| witness.looks_at(slot) as f64;
    let difference = |slot: usize| witness.sum(slot, row)[kind] / times(slot) - light.pixels[slot][kind];
    let run = slots.iter().map(|slot| times(*slot) * light.pixels[*slot][kind]).sum::<f64>() / looks;
    let seen = slots.iter().map(|slot| witness.sum(*slot, row)[kind]).sum::<f64>() / looks;
    let off = seen - run;
    let scatter: f64 = slots.iter().map(|slot| (times(*slot) * (difference(*slot) - off)).powi(2)).sum();
    let count = slots.len() as f64;
    let mut variance = scatter / (looks * looks) * count / (count - 1.0);
    let tally = &witness.tally(row)[kind];
    let watched = &witness.watched[row];
    let tells = watched.aimed && tally.lit >= TELLING && tally.among_the_brightest() >= BRIGHT;
    let brightest = if tells { 2.0 * tally.greatest } else { watched.brightest.max(tally.greatest) };
    if off < 0.0 {
        let all: f64 = (0..light.pixels.len()).map(|slot| witness.sum(slot, row)[kind]).sum();
        let lump = if tells && all > 0.0 { tally.squares.value() / all } else { brightest };
        variance = variance.max(run * lump / looks);
    }
    // Met so seldom that it shows neither in the mean nor in the scatter.
    let missed = if off < 0.0 && tells { watched.missed * run.abs() } else { 0.0 };
    let tables = if watched.classes.contains(&Class::Caustic) { OF_TABLES * run.abs() } else { 0.0 };
    let excess = (off.abs() - light.allowed[part] - tables - missed).max(0.0);
    let variance = variance + light.shared[part].powi(2);
    if variance == 0.0 || !variance.is_finite() {
        // Without any scatter there is nothing on either side, or the same everywhere.
        let sure = variance == 0.0 && excess > 1e-9 * run.abs().max(seen.abs());
        let sigmas = if sure { f64::INFINITY.copysign(-off) } else { 0.0 };
        return Some(Tested { run, witness: seen, error: variance.sqrt(), sigmas });
    }
    let step = brightest / looks;
    let unlikely = if off < 0.0 && excess > variance / step {
        (2.0 * excess / step - variance / (step * step)).sqrt()
    } else {
        excess / variance.sqrt()
    };
    let sigmas = as_normal(unlikely, count - 1.0).copysign(-off);
    Some(Tested { run, witness: seen, error: variance.sqrt(), sigmas })
}
