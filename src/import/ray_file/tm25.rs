//! IES TM-25-13: a header of 36288 bytes, spectra, names of further columns, a text, and the rays.
//!
//! Layout: <https://github.com/JuliusMuschaweck/TM25RaySetTools>, `TM25.h` and `TM25_impl.h`, whose fields bear the numbers of
//! the standard's clauses, and <https://github.com/LarryBoxler/IESTM25RayFiles>, `IESTM25File.cs` (both Unlicense). All numbers
//! are little-endian. Of polarised rays the first has six columns, the second three: the length of the file tells.

use super::RayFile;
use super::bundles::{Bundles, Colour, Given};
use super::fields::{Fields, column};
use eyebox_base::error::Result;
use eyebox_scene::Spectrum;
use glam::Vec3;

// Clauses 4.7.1.2, 4, 5, 6, 9, 10, 13, 14, 15; 4.7.2; 4.7.4.
const VERSION_AT: usize = 4;
const LUMENS_AT: usize = 12;
const WATTS_AT: usize = 16;
const RAYS_AT: usize = 20;
const SPECTRAL_AT: usize = 60;
const WAVELENGTH_AT: usize = 64;
const SPECTRA_AT: usize = 76;
const FURTHER_AT: usize = 80;
const TEXT_AT: usize = 84;
const FLAGS_AT: usize = 256;
const TABLES_AT: usize = 36_288;
/// Bytes of the name of a further column, and what the block of spectra is filled up to.
const NAME: u128 = 512;
const FILLED: usize = 32;

/// Which columns a ray has (clause 4.7.2), beside its place and direction.
struct Flags {
    watts: bool,
    wavelength: bool,
    lumens: bool,
    stokes: bool,
    tristimulus: bool,
    index: bool,
}

impl Flags {
    fn read(fields: &Fields<'_>) -> Result<Flags> {
        let mut flags = [false; 8];
        for (number, flag) in flags.iter_mut().enumerate() {
            *flag = match fields.i32(FLAGS_AT + 4 * number)? {
                0 => false,
                1 => true,
                other => {
                    return Err(fields
                        .fault(format!("has the flag {other} of data {}", number + 1))
                        .expected("0 or 1"));
                }
            };
        }
        let [place, direction, watts, wavelength, lumens, stokes, tristimulus, index] = flags;
        if !(place && direction && (watts || lumens)) {
            return Err(fields
                .fault("has rays without a place, a direction or a flux".to_owned())
                .expected("the flags of place and direction, and of radiant or luminous flux"));
        }
        Ok(Flags { watts, wavelength, lumens, stokes, tristimulus, index })
    }
}

/// What the spectrum of the rays is (clause 4.7.1.9).
enum Spectral {
    Unsaid,
    Line(f32),
    OfRay,
    Shared,
    Indexed,
}

pub(super) fn read(fields: &Fields<'_>) -> Result<RayFile> {
    if fields.bytes.len() < TABLES_AT {
        return Err(fields.cut_off(TABLES_AT as u128));
    }
    let version = fields.i32(VERSION_AT)?;
    if version != 2013 {
        return Err(fields.fault(format!("is of version {version} of TM-25")).expected("2013"));
    }
    let count = fields.u64(RAYS_AT)?;
    if count == 0 {
        return Err(fields.fault("has no rays".to_owned()).expected("at least one"));
    }
    let flags = Flags::read(fields)?;
    let (spectra, ends) = spectra(fields)?;
    let spectral = spectral(fields, &flags, spectra.len())?;
    let of_count = |place: usize, what: &str| {
        let number = fields.i32(place)?;
        let bad = || fields.fault(format!("has {number} {what}")).expected("0 or more");
        u32::try_from(number).map_err(|_| bad())
    };
    let further = of_count(FURTHER_AT, "further columns")?;
    let text = of_count(TEXT_AT, "bytes of text")?;
    let (start, stokes) = layout(fields, &flags, (ends, u128::from(further), u128::from(text)), count)?;
    let own = [flags.watts, flags.wavelength, flags.lumens].map(usize::from);
    let [watts_at, nm_at, lumens_at] = [6, 6 + own[0], 6 + own[0] + own[1]];
    let index_at = 6 + own.iter().sum::<usize>() + stokes + 2 * usize::from(flags.tristimulus);
    let columns = index_at + usize::from(flags.index) + further as usize;
    let mut bundles = Bundles::default();
    for (number, record) in fields.bytes.get(start..).unwrap_or_default().chunks_exact(4 * columns).enumerate() {
        let at = |index: usize| column(record, index).unwrap_or(f32::NAN);
        let colour = match spectral {
            Spectral::Unsaid | Spectral::Line(_) | Spectral::Shared => Colour::Table(0),
            Spectral::OfRay => Colour::Line(at(nm_at)),
            Spectral::Indexed => {
                let index = at(index_at);
                if !(index >= 1.0 && index <= spectra.len() as f32 && index.fract() == 0.0) {
                    return Err(fields
                        .fault(format!("has in ray {number} the spectrum {index}"))
                        .expected(format!("1 to {}", spectra.len())));
                }
                Colour::Table(index as u32 - 1)
            }
        };
        bundles.add(
            fields,
            &Given {
                place_mm: Vec3::new(at(0), at(1), at(2)),
                dir: Vec3::new(at(3), at(4), at(5)),
                watts: flags.watts.then(|| at(watts_at)),
                lumens: flags.lumens.then(|| at(lumens_at)),
                colour,
            },
        )?;
    }
    let spectrum_of = |number: u32| match spectral {
        Spectral::Unsaid | Spectral::OfRay => None,
        Spectral::Line(nm) => Some(Spectrum::Table(vec![(f64::from(nm), 1.0)])),
        Spectral::Shared | Spectral::Indexed => spectra.get(number as usize).cloned().map(Spectrum::Table),
    };
    let stated = |place: usize| -> Result<Option<f64>> {
        let flux = f64::from(fields.f32(place)?);
        Ok((flux > 0.0 && flux.is_finite()).then_some(flux))
    };
    let [watts, lumens]: [Option<f64>; 2] = [stated(WATTS_AT)?, stated(LUMENS_AT)?];
    let (bundles, mut remarks) = bundles.end(fields, [watts, lumens], spectrum_of)?;
    let unused = [
        (flags.stokes, "the polarisation of its rays is not used: they are unpolarised"),
        (flags.tristimulus, "the colours of its rays (tristimulus X and Z) are not used"),
        (flags.wavelength && !matches!(spectral, Spectral::OfRay), "the wavelengths of its rays are not used"),
        (further > 0, "further columns of its rays are not used"),
    ];
    remarks.extend(unused.into_iter().filter(|(there, _)| *there).map(|(_, what)| what.to_owned()));
    Ok(RayFile { format: "IES TM-25-13", bundles, lumens, remarks })
}

fn spectral(fields: &Fields<'_>, flags: &Flags, spectra: usize) -> Result<Spectral> {
    let identifier = fields.i32(SPECTRAL_AT)?;
    let lacks = |what: &str| fields.fault(format!("says spectral data {identifier} and lacks {what}"));
    match identifier {
        0 => Ok(Spectral::Unsaid),
        1 => {
            let nm = fields.f32(WAVELENGTH_AT)?;
            let bad = || fields.fault(format!("has a wavelength of {nm} nm")).expected("a number > 0");
            if nm > 0.0 && nm.is_finite() { Ok(Spectral::Line(nm)) } else { Err(bad()) }
        }
        2 if !flags.wavelength || !flags.watts => Err(lacks("a wavelength or the radiant flux of each ray")),
        2 if flags.lumens => Err(fields
            .fault("has rays with wavelengths and luminous flux".to_owned())
            .expected("radiant flux alone, of which the wavelengths tell the luminous flux")),
        2 => Ok(Spectral::OfRay),
        3 if spectra == 0 => Err(lacks("a spectrum")),
        3 => Ok(Spectral::Shared),
        4 if !flags.index || spectra == 0 => Err(lacks("spectra or their number in each ray")),
        4 => Ok(Spectral::Indexed),
        other => Err(fields.fault(format!("says spectral data {other}")).expected("0 to 4")),
    }
}

/// A spectrum: nm and relative power.
type Rows = Vec<(f64, f64)>;

/// The spectra (clause 4.7.4), and where they end.
fn spectra(fields: &Fields<'_>) -> Result<(Vec<Rows>, usize)> {
    let count = fields.i32(SPECTRA_AT)?;
    let count =
        usize::try_from(count).map_err(|_| fields.fault(format!("has {count} spectra")).expected("0 or more"))?;
    let mut at = TABLES_AT;
    let mut all = Vec::new();
    for number in 1..=count {
        let pairs = fields.i32(at)?;
        let bad = |what: String| fields.fault(format!("has in spectrum {number} {what}"));
        let pairs = usize::try_from(pairs).ok().filter(|pairs| *pairs > 0);
        let pairs = pairs.ok_or_else(|| bad("no rows".to_owned()).expected("at least one"))?;
        at += 4;
        let mut rows = Rows::new();
        for _ in 0..pairs {
            let (nm, power) = (f64::from(fields.f32(at)?), f64::from(fields.f32(at + 4)?));
            if !(nm > rows.last().map_or(0.0, |last| last.0) && nm.is_finite() && power >= 0.0 && power.is_finite()) {
                return Err(bad(format!("the row {nm} nm, {power}")).expected("rising wavelengths, powers >= 0"));
            }
            rows.push((nm, power));
            at += 8;
        }
        all.push(rows);
    }
    Ok((all, at))
}

/// Where the rays start, and how many columns are of their polarisation: what the file's length allows. `after`: where the
/// spectra end, how many further columns are named, and the bytes of the text.
fn layout(
    fields: &Fields<'_>,
    flags: &Flags,
    (ends, further, text): (usize, u128, u128),
    count: u64,
) -> Result<(usize, usize)> {
    let others = [flags.watts, flags.wavelength, flags.lumens, flags.tristimulus, flags.tristimulus, flags.index];
    let columns = 6 + others.into_iter().filter(|flag| *flag).count() as u128 + further;
    let filled = TABLES_AT + (ends - TABLES_AT).next_multiple_of(FILLED);
    let has = fields.bytes.len() as u128;
    let stokes: &[usize] = if flags.stokes { &[6, 3] } else { &[0] };
    // The standard fills the block of spectra up.
    let all = [filled, ends].into_iter().flat_map(|start| stokes.iter().map(move |stokes| (start, *stokes)));
    let with = all.map(|(start, stokes)| {
        let start = start as u128 + NAME * further + text;
        (start, stokes, start + u128::from(count) * 4 * (columns + stokes as u128))
    });
    let with: Vec<(u128, usize, u128)> = with.collect();
    if let Some((start, stokes, _)) = with.iter().find(|(.., wanted)| *wanted == has) {
        return Ok((*start as usize, *stokes));
    }
    let wanted = with.first().map_or(0, |(.., wanted)| *wanted);
    if has < wanted {
        return Err(fields.cut_off(wanted));
    }
    Err(fields.fault(format!("has {has} bytes, and {count} rays")).expected(format!("{wanted} bytes")))
}
