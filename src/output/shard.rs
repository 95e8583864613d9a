//! A shard or a checkpoint as an EXR: the picture of its passes, and beside it the sums of its films to the last bit.
//!
//! A float channel holds whole numbers below 2²⁴ exactly, so an f64 is three of them: `sums.f0_light_3_a` … `_c` are the
//! bits of the upper double of the third kind of light sum of film 0, `_d` … `_f` those of the lower. Columns of zeros are
//! left out. The attribute `eyebox.shard` says in JSON what the films are and whatever the writer wants to know again.

use crate::exr::{read_exr, write_exr};
use eyebox_base::double_double::Sum;
use eyebox_base::error::{Error, Result, Where};
use eyebox_base::lpe;
use eyebox_film::accumulate::{Components, Film, Light, PlaneKey, Sampling};
use eyebox_film::control_variates::{self, Known};
use eyebox_film::frame::{Channel, Frame, Meta, Samples};
use eyebox_film::kernel_bias;
use eyebox_film::rqmc_variance::Evenness;
use eyebox_film::unseen::Unseen;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// The attribute that makes an EXR a shard.
const KEY: &str = "shard";
/// What the sums mean; another number when they come to mean something else. Programs before there was one wrote none.
const FORMAT: u32 = 8;
/// The layer of the sums.
const SUMS: &str = "sums";
const BITS: u32 = 24;
const PARTS: [char; 6] = ['a', 'b', 'c', 'd', 'e', 'f'];
/// More films than there are estimators.
const MOST_FILMS: usize = 16;
/// What is believed of films however short the file is, bytes; and how many times its length. Columns of zeros are left
/// out, and deflate does not expand more than 1032-fold.
const ALWAYS_ALLOWED: u64 = 1 << 28;
const EXPANSION: u64 = 1100;
/// More planes than any picture has: light groups times layers.
const MOST_PLANES: usize = 1 << 14;

/// What a shard holds.
pub struct Shard<H> {
    pub head: H,
    pub films: Vec<Film>,
    /// The picture of the shard's own passes, with all its metadata; no channels in a checkpoint.
    pub picture: Frame,
}

/// How a film is made again.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
struct Kind {
    planes: Vec<PlaneKey>,
    components: Components,
    sampling: Sampling,
    passes: u64,
    /// Passes that it was to have, where those are more.
    #[serde(default, skip_serializing_if = "is_none")]
    wanted: u64,
    /// What its passes count in each of the sums of [`eyebox_film::rqmc_variance`], which says what these are.
    surplus: Vec<i64>,
    detail: bool,
    blur: bool,
    /// Pixels have passes of their own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    adaptive: bool,
    /// Whole passes and their squares, see [`eyebox_film::totals`].
    totals: Vec<[Sum; 2]>,
    /// What is known of passes that share wavelengths, see [`eyebox_film::control_variates`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    known: Vec<(u64, Known)>,
    /// What rays from the eye may not have met.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unseen: Option<Unseen>,
}

impl Kind {
    /// At most as many bytes as a film of this kind needs; none if that is no number.
    fn bytes(&self, pixels: u64) -> Option<u64> {
        // Its value, its powers, and how it parts between two slides.
        let light = (Light::DEGREE + 3) as u64 * self.components.count() as u64;
        let further = match self.sampling {
            Sampling::PerPass => {
                8 + (self.surplus.len() + control_variates::COUNT) as u64
                    + if self.blur { kernel_bias::PER_PIXEL as u64 } else { 0 }
            }
            Sampling::PerScramble { .. } => 9 + if self.detail { 16 } else { 0 },
        };
        let sums = (light + further).checked_mul(self.planes.len() as u64 + 1)?;
        let sums = sums.checked_add(if self.detail { 1 + lpe::MOST as u64 } else { 0 })?;
        let map = if self.adaptive { 1 } else { 0 };
        pixels.checked_mul(sums.checked_add(map)?)?.checked_mul(size_of::<Sum>() as u64)
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_none(passes: &u64) -> bool {
    *passes == 0
}

#[derive(serde::Serialize, serde::Deserialize)]
struct Stored<H> {
    format: u32,
    films: Vec<Kind>,
    head: H,
}

/// All of it that every program can read.
#[derive(serde::Deserialize)]
struct Format {
    #[serde(default)]
    format: u32,
}

/// Writes a shard. `picture`: of the films' size; `films` may be none. Errors: those of [`write_exr`].
pub fn write_shard<H: Serialize>(path: &Path, head: &H, films: &[&Film], picture: &Frame) -> Result<()> {
    let kind = |film: &&Film| Kind {
        planes: film.planes.clone(),
        components: film.components,
        sampling: film.sampling,
        passes: film.passes,
        wanted: film.wanted,
        surplus: film.surplus().to_vec(),
        detail: film.detail().is_some(),
        blur: film.has_blur(),
        adaptive: film.sample_map().is_some(),
        totals: film.totals().sums().to_vec(),
        known: film.known().to_vec(),
        unseen: film.unseen().cloned(),
    };
    let stored = Stored { format: FORMAT, films: films.iter().map(kind).collect(), head };
    let text = serde_json::to_string(&stored)
        .map_err(|error| Error::new(Where::file(path), format!("cannot be described: {error}")))?;
    let mut frame = picture.clone();
    frame.meta.insert(KEY.to_owned(), Meta::Text(text));
    for (number, film) in films.iter().enumerate() {
        for table in film.tables() {
            for column in 0..table.stride() {
                let own: Vec<Sum> = (0..film.width * film.height).map(|pixel| table.sum(pixel, column)).collect();
                for (part, letter) in PARTS.into_iter().enumerate() {
                    let data: Vec<f32> = own.iter().map(|sum| piece(*sum, part)).collect();
                    if data.iter().any(|value| *value != 0.0) {
                        frame.push(channel(number, table.name, column, letter), data);
                    }
                }
            }
        }
    }
    if frame.channels.is_empty() {
        // A file has to have one.
        frame.push(format!("{SUMS}.none"), vec![0.0; picture.width * picture.height]);
    }
    write_exr(path, &frame).map(drop)
}

/// Reads a shard. Errors: those of [`read_exr`]; an EXR that is none, or whose sums are not what it says they are.
pub fn read_shard<H: DeserializeOwned>(path: &Path) -> Result<Shard<H>> {
    let mut frame = read_exr(path)?;
    let fault =
        |what: String| Error::new(Where::file(path), what).expected("what `render --shard` or `--checkpoint` writes");
    let text = frame.text(KEY).ok_or_else(|| fault("is no shard".to_owned()))?;
    let no_shard = |error: serde_json::Error| fault(format!("is no shard: {error}"));
    let Format { format } = serde_json::from_str(text).map_err(no_shard)?;
    if format != FORMAT {
        return Err(fault(format!("is of another version of the program (format {format}, this one has {FORMAT})")));
    }
    let Stored { films: kinds, head, .. } = serde_json::from_str::<Stored<H>>(text).map_err(no_shard)?;
    frame.meta.remove(KEY);
    let (sums, picture) = std::mem::take(&mut frame.channels).into_iter().partition(|c: &Channel| c.layer() == SUMS);
    frame.channels = picture;
    let mut sums: HashMap<String, Samples> = sums.into_iter().map(|c| (c.name, c.data)).collect();
    let length = std::fs::metadata(path).map_or(0, |data| data.len());
    let pixels = (frame.width * frame.height) as u64;
    let bytes = kinds.iter().try_fold(0u64, |sum, kind| sum.checked_add(kind.bytes(pixels)?));
    let most = length.saturating_mul(EXPANSION).max(ALWAYS_ALLOWED);
    if kinds.len() > MOST_FILMS || bytes.is_none_or(|bytes| bytes > most) {
        return Err(fault(format!("tells of {} films that its {length} bytes cannot hold", kinds.len())));
    }
    let mut films = Vec::new();
    for (number, kind) in kinds.into_iter().enumerate() {
        let different: HashSet<PlaneKey> = kind.planes.iter().copied().collect();
        if different.is_empty() || different.len() < kind.planes.len() || different.len() > MOST_PLANES {
            return Err(fault(format!("film {number} has {} planes", kind.planes.len())));
        }
        films.push(filled(&frame, number, kind, &mut sums).map_err(fault)?);
    }
    sums.remove(&format!("{SUMS}.none"));
    match sums.keys().min() {
        None => Ok(Shard { head, films, picture: frame }),
        Some(name) => Err(fault(format!("channel `{name}` belongs to no film"))),
    }
}

fn channel(film: usize, table: &str, column: usize, part: char) -> String {
    format!("{SUMS}.f{film}_{table}_{column}_{part}")
}

fn filled(frame: &Frame, number: usize, kind: Kind, sums: &mut HashMap<String, Samples>) -> Result<Film, String> {
    let film = Film::new(frame.width, frame.height, kind.planes, kind.components, kind.sampling);
    let film = if kind.detail { film.with_detail() } else { film };
    let film = if kind.blur { film.with_blur() } else { film };
    if kind.unseen.as_ref().is_some_and(|unseen| !unseen.is_valid(frame.width * frame.height)) {
        return Err(format!("film {number} says of what its rays may have missed what cannot be"));
    }
    let film = film.with_unseen(kind.unseen);
    let shared = kind.surplus.len() == Evenness::OfPasses.per_pixel();
    let mut film = if shared { film.with_evenness(Evenness::OfPasses) } else { film };
    if kind.adaptive {
        film.sample_map_mut();
    }
    (film.passes, film.wanted) = (kind.passes, kind.wanted);
    if kind.surplus.iter().any(|surplus| surplus.unsigned_abs() > kind.passes) {
        return Err(format!("film {number} has a surplus of {:?} of its {} passes", kind.surplus, kind.passes));
    }
    if !film.set_surplus(kind.surplus) {
        return Err(format!("film {number} has the surplus of another kind of film"));
    }
    if !(film.keeps_known() || kind.known.is_empty()) || !kind.known.is_sorted_by(|a, b| a.0 < b.0) {
        return Err(format!("what film {number} knows of its passes is no list of these"));
    }
    if !film.know(kind.known) {
        return Err(format!("what film {number} knows of its passes is no number"));
    }
    if !film.put_totals(kind.totals) {
        return Err(format!("film {number} has totals of another kind of film"));
    }
    let pixels = film.width * film.height;
    for mut table in film.tables_mut() {
        let name = table.name;
        let mut columns = Vec::new();
        for column in 0..table.stride() {
            let parts = PARTS.map(|part| sums.remove(&channel(number, name, column, part)));
            if parts.iter().any(Option::is_some) {
                columns.push((column, parts));
            }
        }
        let mut own = vec![Sum::ZERO; table.stride()];
        for pixel in 0..pixels {
            for (column, parts) in &columns {
                let at = |part: usize| parts[part].as_ref().and_then(|data| data.get(pixel)).copied().unwrap_or(0.0);
                own[*column] = joined(std::array::from_fn(at)).ok_or_else(|| {
                    format!("the sums of film {number}, {name} {column}, are damaged at pixel {pixel}")
                })?;
            }
            if !columns.is_empty() && !table.put(pixel, &own) {
                return Err(format!("film {number} keeps no {name} at pixel {pixel}, but the file has some"));
            }
        }
    }
    if film.known().len() as u64 > film.most_passes() {
        return Err(format!("film {number} knows of more passes than it has"));
    }
    film.settle();
    Ok(film)
}

/// Bits `24·(part mod 3)` and up of the upper (parts 0–2) or the lower double.
fn piece(sum: Sum, part: usize) -> f32 {
    let bits = if part < 3 { sum.high } else { sum.low }.to_bits();
    (bits >> (BITS * (part as u32 % 3)) & ((1 << BITS) - 1)) as f32
}

fn joined(parts: [f32; 6]) -> Option<Sum> {
    let whole = |value: f32| {
        let limit = 2f32.powi(BITS as i32);
        ((0.0..limit).contains(&value) && value.fract() == 0.0).then_some(value as u64)
    };
    let double = |of: &[f32]| {
        let mut bits = 0u64;
        for (k, value) in of.iter().enumerate() {
            bits |= whole(*value)?.checked_shl(BITS * k as u32)?;
        }
        Some(f64::from_bits(bits))
    };
    Some(Sum { high: double(&parts[..3])?, low: double(&parts[3..])? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::ids::GroupId;
    use eyebox_film::layer::Layer;

    fn film(sampling: Sampling) -> Film {
        let planes = [0, 1].map(|group| PlaneKey { layer: Layer::Forward, group: GroupId(group), takes: 0 });
        let film = Film::new(3, 2, planes.to_vec(), Components::Luminance, sampling).with_detail();
        let mut film = if sampling == Sampling::PerPass { film.with_blur() } else { film };
        for pass in 0..5u64 {
            let light =
                |pixel: usize| Light::ONE.scaled((1.0 + pixel as f64) / (3.0 + pass as f64) * 1e9f64.powf(pass as f64));
            match sampling {
                Sampling::PerPass => film.rows().for_each(|(y, mut row)| {
                    for x in 0..3 {
                        row.add_pass(x, pass, &[light(3 * y + x), Light::default()]);
                        row.add_blur(x, -light(3 * y + x).value);
                    }
                }),
                Sampling::PerScramble { .. } => {
                    (0..6).for_each(|pixel| film.splat(pixel, pixel % 2, pass as usize, &[light(pixel)]));
                }
            }
            film.close(pass, 1);
        }
        film.settle();
        film
    }

    #[test]
    fn films_come_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shard.exr");
        let films = [film(Sampling::PerPass), film(Sampling::PerScramble { paths: 64 })];
        let mut picture = Frame::new(3, 2);
        picture.push("direct.R", vec![0.5; 6]);
        picture.meta.insert("passes".to_owned(), Meta::Text("5".to_owned()));
        write_shard(&path, &"head", &films.each_ref(), &picture).unwrap();
        let back: Shard<String> = read_shard(&path).unwrap();
        assert_eq!(back.head, "head");
        assert_eq!(back.films, films);
        assert_eq!(back.picture.channels, picture.channels);
        assert_eq!(back.picture.text("passes"), Some("5"));
        write_shard(&path, &7, &[], &Frame::new(1, 1)).unwrap();
        assert!(read_shard::<i32>(&path).unwrap().films.is_empty());
    }

    #[test]
    fn what_is_no_shard_or_damaged_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shard.exr");
        let said = |frame: &Frame| {
            write_exr(&path, frame).unwrap();
            read_shard::<i32>(&path).map(|_| ()).unwrap_err().to_string()
        };
        let mut frame = Frame::new(3, 2);
        frame.push("R", vec![0.0; 6]);
        assert!(said(&frame).contains("shard.exr: is no shard"));
        let own = film(Sampling::PerPass);
        write_shard(&path, &1, &[&own], &frame).unwrap();
        let mut good = read_exr(&path).unwrap();
        let at = good.channels.iter().position(|c| c.name == "sums.f0_light_0_c").unwrap();
        let before = good.channels[at].data[4];
        for bad in [0.5, -1.0, 16_777_216.0] {
            good.channels[at].data[4] = bad;
            assert!(said(&good).contains("damaged at pixel 4"));
        }
        good.channels[at].data[4] = before;
        good.push("sums.f1_light_0_a", vec![1.0; 6]);
        assert!(said(&good).contains("belongs to no film"));
        for (text, why) in [("{}", "another version of the program (format 0,"), (r#"{"format":9}"#, "(format 9,")] {
            good.meta.insert(KEY.to_owned(), Meta::Text(text.to_owned()));
            assert!(said(&good).contains(why));
        }
        good.meta.insert(KEY.to_owned(), Meta::Text(format!(r#"{{"format":{FORMAT},"head":1}}"#)));
        assert!(said(&good).contains("is no shard: missing field `films`"));
    }
}
