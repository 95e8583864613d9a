//! Rays are checked and put together by their spectra.

use super::Bundle;
use super::fields::Fields;
use eyebox_base::colour::{FIRST_NM, K_M, LAST_NM, cmf};
use eyebox_base::error::Result;
use eyebox_scene::{LampRay, Spectrum};
use glam::Vec3;
use std::collections::BTreeMap;

/// Which spectrum a ray has.
#[derive(Debug, Clone, Copy)]
pub(super) enum Colour {
    /// The file's of this number.
    Table(u32),
    /// One wavelength, nm.
    Line(f32),
}

/// A ray as a file has it.
pub(super) struct Given {
    pub place_mm: Vec3,
    pub dir: Vec3,
    pub watts: Option<f32>,
    pub lumens: Option<f32>,
    pub colour: Colour,
}

/// Rays whose wavelengths lie within this many nm of each other make one bundle, whose light is spread evenly from the
/// shortest to the longest of them.
const LINES_NM: f32 = 10.0;
/// How far a direction's length may be from 1; what is off less is single precision or decimals, and is put right.
const LENGTH: f32 = 0.01;

/// By how much of it a header's flux may be off from the sum of the rays before that is worth a warning.
const OFF: f64 = 0.01;

#[derive(Default)]
struct Gathered {
    rays: Vec<LampRay>,
    lumens: f64,
    watts: f64,
    by_wavelength: f64,
    /// Shortest and longest wavelength, nm.
    nm: Option<[f32; 2]>,
}

/// What of the rays was put right or left out.
#[derive(Default)]
pub(super) struct Bundles {
    all: BTreeMap<u32, Gathered>,
    dark: u64,
    unseen: u64,
    turned: u64,
    count: u64,
    columns: [bool; 2],
    /// W and lm of all rays, also of those that are left out.
    sums: [f64; 2],
}

impl Bundles {
    /// Adds the next ray.
    pub(super) fn add(&mut self, fields: &Fields<'_>, ray: &Given) -> Result<()> {
        let number = self.count;
        self.count += 1;
        let fault = |what: String| fields.fault(format!("has in ray {number} {what}"));
        if !ray.place_mm.is_finite() {
            return Err(fault(format!("the place {}", ray.place_mm)).expected("finite numbers"));
        }
        let length = ray.dir.length();
        if !(1.0 - LENGTH..=1.0 + LENGTH).contains(&length) {
            return Err(fault(format!("a direction of length {length}")).expected("unit directions"));
        }
        self.turned += u64::from((length - 1.0).abs() > 1e-4);
        for (flux, unit) in [(ray.watts, "W"), (ray.lumens, "lm")] {
            if let Some(flux) = flux.filter(|flux| !(*flux >= 0.0 && flux.is_finite())) {
                return Err(fault(format!("a flux of {flux} {unit}")).expected("0 or more, and finite"));
            }
        }
        let number = |flux: Option<f32>| f64::from(flux.unwrap_or(0.0));
        self.sums = [self.sums[0] + number(ray.watts), self.sums[1] + number(ray.lumens)];
        self.columns = [ray.watts.is_some(), ray.lumens.is_some()];
        // What is seen of a ray is its luminous flux, where the file has both.
        let flux = ray.lumens.or(ray.watts).unwrap_or(0.0);
        if flux == 0.0 {
            self.dark += 1;
            return Ok(());
        }
        let key = match ray.colour {
            Colour::Table(number) => number,
            Colour::Line(nm) => {
                if !(nm > 0.0 && nm.is_finite()) {
                    return Err(fault(format!("a wavelength of {nm} nm")).expected("a number > 0"));
                }
                if !(FIRST_NM as f32..=LAST_NM as f32).contains(&nm) {
                    self.unseen += 1;
                    return Ok(());
                }
                (nm / LINES_NM) as u32
            }
        };
        let own = self.all.entry(key).or_default();
        own.rays.push(LampRay { place_mm: ray.place_mm, dir: ray.dir / length, flux });
        own.lumens += f64::from(ray.lumens.unwrap_or(0.0));
        own.watts += f64::from(ray.watts.unwrap_or(0.0));
        if let Colour::Line(nm) = ray.colour {
            own.by_wavelength += f64::from(flux) * K_M * cmf(f64::from(nm))[1];
            let [low, high] = own.nm.unwrap_or([nm, nm]);
            own.nm = Some([low.min(nm), high.max(nm)]);
        }
        Ok(())
    }

    /// All bundles, and what is to be said of them. `stated`: of all rays together by the header, W and lm, where it states it:
    /// the flux of the rays is scaled to it. `spectra`: of the file's, by their numbers.
    pub(super) fn end(
        self,
        fields: &Fields<'_>,
        stated: [Option<f64>; 2],
        spectra: impl Fn(u32) -> Option<Spectrum>,
    ) -> Result<(Vec<Bundle>, Vec<String>)> {
        let mut remarks = Vec::new();
        let mut say = |count: u64, what: &str| {
            if count > 0 {
                remarks.push(format!("{count} of its {} rays {what}", self.count));
            }
        };
        say(self.dark, "have no flux: left out");
        say(self.unseen, "have wavelengths outside 360 to 830 nm: left out");
        say(self.turned, "have directions that are not unit: taken as if they were");
        let [watts, lumens] = self.columns;
        // What is seen of a ray is its luminous flux, where the file has both.
        let (has, stated, unit) = if lumens { (self.sums[1], stated[1], "lm") } else { (self.sums[0], stated[0], "W") };
        let factor = stated.filter(|_| has > 0.0).map_or(1.0, |stated| stated / has);
        if (factor - 1.0).abs() > OFF {
            remarks.push(format!(
                "its rays have {has:.6} {unit} and its header states {:.6} {unit}, which holds",
                factor * has
            ));
        }
        let bundle = |(key, own): (u32, Gathered)| {
            let spectrum = own.nm.map_or_else(|| spectra(key), |nm| Some(between(nm)));
            let seen = match &spectrum {
                Some(Spectrum::Table(rows)) => visible_share(rows),
                Some(_) | None => 1.0,
            };
            Bundle {
                spectrum,
                rays: own.rays,
                lumens: lumens.then_some(factor * own.lumens),
                watts: watts.then_some(factor * seen * own.watts),
                by_wavelength: own.nm.map(|_| factor * own.by_wavelength),
            }
        };
        let bundles: Vec<Bundle> = self.all.into_iter().map(bundle).collect();
        if bundles.is_empty() {
            return Err(fields.fault(format!("has no light: {} rays", self.count)).expected("rays with visible flux"));
        }
        Ok((bundles, remarks))
    }
}

/// Light spread evenly between two wavelengths; a line where they are less than 1 nm apart.
fn between([low, high]: [f32; 2]) -> Spectrum {
    let [low, high] = [f64::from(low), f64::from(high)];
    if high - low < 1.0 {
        return Spectrum::Table(vec![(0.5 * (low + high), 1.0)]);
    }
    Spectrum::Table(vec![(low, 1.0), (high, 1.0)])
}

/// The share of a spectrum's power, linear between its rows, from 360 to 830 nm.
fn visible_share(rows: &[(f64, f64)]) -> f64 {
    let [first, last] = [FIRST_NM as f64, LAST_NM as f64];
    let power = |low: f64, high: f64| {
        let of = |pair: &[(f64, f64)]| {
            let [(a, at_a), (b, at_b)] = [pair[0], pair[1]];
            let (from, to) = (a.max(low), b.min(high));
            let at = |nm: f64| at_a + (at_b - at_a) * (nm - a) / (b - a);
            if from < to { 0.5 * (to - from) * (at(from) + at(to)) } else { 0.0 }
        };
        rows.windows(2).map(of).sum::<f64>()
    };
    let all = power(f64::NEG_INFINITY, f64::INFINITY);
    if all > 0.0 { power(first, last) / all } else { 1.0 }
}
