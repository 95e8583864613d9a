//! Sequences of CODE V: commands one after the other, several a line behind semicolons; those between two S commands are of the
//! surface that the first one began. A command may name its surface instead (`THI S3 5`).

mod words;

use super::profile::Form;
use super::{After, Prescription, Profile, Surface, Turn};
use crate::base::error::Result;
use crate::base::{Error, Where};
use crate::scene::Note;
use std::collections::BTreeMap;
use std::path::Path;
use words::{bare, commands, glass, qualifier};

/// How the axes of a surface go on behind it.
#[derive(Clone, Copy, PartialEq)]
enum Return {
    /// They stay turned.
    Stay,
    /// Back to those before it (DAR, RET to itself).
    Back,
    /// Turned once more by the same tilts (BEN): as light is by a mirror.
    Bend,
    /// Turned by the inverse, behind it alone (REV).
    Reverse,
}

struct Raw {
    surface: Surface,
    shift: [f64; 3],
    tilt_deg: [f64; 3],
    back: Return,
    even: [f64; 10],
}

/// Commands that bend light or turn axes in ways that are not read.
const REFUSED: [&str; 14] =
    ["SPS", "XTO", "YTO", "AAS", "CYL", "DIF", "HOE", "HCT", "GRT", "NSS", "GLB", "FRN", "UDS", "MOD"];

/// The prescription in `text`, the file at `path`.
pub(super) fn read(text: &str, path: &Path) -> Result<Prescription> {
    let mut out = Prescription { unit_m: 1e-3, ..Prescription::default() };
    let (mut raws, mut radii, mut reference) = (Vec::<Raw>::new(), false, 1usize);
    let (mut waves, mut fields, mut zoomed) = (Vec::new(), [0.0f64; 2], false);
    // Glasses of the file's own, between PRV and END, and the wavelengths of their indices.
    let (mut private, mut known, mut at_nm) = (false, BTreeMap::<String, Vec<[f64; 2]>>::new(), Vec::<f64>::new());
    for (line, command) in commands(text) {
        let at = || Where::Line { file: path.to_owned(), line };
        let mut words: Vec<&str> = command.split_whitespace().collect();
        let Some(key) = words.first().map(|word| word.to_uppercase()) else { continue };
        match key.as_str() {
            "PRV" => private = true,
            "END" => private = false,
            _ if private => {
                let numbers =
                    words.iter().skip(1).filter_map(|word| word.parse::<f64>().ok()).filter(|n| n.is_finite());
                if key == "PWL" {
                    at_nm = numbers.collect();
                } else {
                    let mut rows: Vec<[f64; 2]> = at_nm.iter().zip(numbers).map(|(nm, n)| [*nm, n]).collect();
                    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
                    rows.dedup_by(|b, a| a[0] == b[0]);
                    known.insert(bare(&key), rows);
                }
            }
            _ => {}
        }
        if private {
            continue;
        }
        words.remove(0);
        // Whose command it is, where it says so.
        let last = raws.len().wrapping_sub(1);
        let mut whose = last;
        if let Some(index) = words.first().and_then(|word| qualifier(word, raws.len()))
            && !matches!(key.as_str(), "S" | "SO" | "SI")
        {
            whose = index;
            words.remove(0);
        }
        let number = |i: usize| -> Result<f64> {
            match words.get(i).map(|word| word.parse::<f64>()) {
                Some(Ok(number)) if number.is_finite() => Ok(number),
                None => Ok(0.0),
                Some(_) => {
                    Err(Error::new(at(), format!("`{command}` is no command of {key}")).expected("numbers after it"))
                }
            }
        };
        if REFUSED.contains(&key.as_str()) {
            return Err(Error::new(at(), format!("surfaces of kind {key} are not read"))
                .expected("spheres, conics and aspheres"));
        }
        match key.as_str() {
            "DIM" => {
                out.unit_m = match words.first().map(|word| word.to_uppercase()).as_deref() {
                    Some("M" | "MM") | None => 1e-3,
                    Some("C" | "CM") => 1e-2,
                    Some("I" | "IN") => 0.0254,
                    Some(other) => {
                        return Err(Error::new(at(), format!("unknown unit `{other}`")).expected("M, C or I"));
                    }
                }
            }
            "RDM" => radii = !words.first().is_some_and(|word| word.to_uppercase().starts_with('N')),
            "CUM" => radii = false,
            "EPD" => out.pupil = Some(number(0)?).filter(|pupil| *pupil > 0.0),
            "FNO" => out.f_number = Some(number(0)?).filter(|ratio| *ratio > 0.0),
            "WL" => waves = (0..words.len()).map(number).collect::<Result<Vec<f64>>>()?,
            "REF" => reference = number(0)?.max(1.0) as usize,
            "XAN" | "YAN" => {
                let angles = (0..words.len()).map(number).collect::<Result<Vec<f64>>>()?;
                fields[usize::from(key == "YAN")] = angles.iter().fold(0.0, |most, angle| angle.abs().max(most));
            }
            "ZOO" => zoomed = true,
            "SO" | "S" | "SI" => {
                let curve = number(0)?;
                let curvature = if !radii {
                    curve
                } else if curve == 0.0 {
                    0.0
                } else {
                    1.0 / curve
                };
                // A distance that stands for infinity.
                let endless = words.get(1).is_some_and(|word| word.to_uppercase().starts_with("INF"));
                let thickness = if endless { f64::INFINITY } else { number(1)? };
                let thickness = if thickness.abs() >= 1e10 { f64::INFINITY } else { thickness };
                let after = words.get(2).map_or(Ok(After::Air), |word| glass(word, &known, &at()))?;
                let surface = Surface {
                    line,
                    comment: String::new(),
                    turn: None,
                    profile: Profile { curvature, ..Profile::PLANE },
                    grating: None,
                    thickness,
                    after,
                    semi_diameter: 0.0,
                    stop: false,
                };
                raws.push(Raw { surface, shift: [0.0; 3], tilt_deg: [0.0; 3], back: Return::Stay, even: [0.0; 10] });
            }
            _ => {
                let Some(raw) = raws.get_mut(whose) else { continue };
                match key.as_str() {
                    "STO" | "STOP" => raw.surface.stop = true,
                    "CUY" => raw.surface.profile.curvature = number(0)?,
                    "RDY" => raw.surface.profile.curvature = if number(0)? == 0.0 { 0.0 } else { 1.0 / number(0)? },
                    "THI" => raw.surface.thickness = number(0)?,
                    "GLA" | "GL1" => {
                        raw.surface.after = words.first().map_or(Ok(After::Air), |word| glass(word, &known, &at()))?
                    }
                    "REFL" => raw.surface.after = After::Mirror,
                    "RMD" if words.first().is_some_and(|word| word.to_uppercase().starts_with("REFL")) => {
                        raw.surface.after = After::Mirror;
                    }
                    "K" => raw.surface.profile.conic = number(0)?,
                    "A" | "B" | "C" | "D" | "E" | "F" | "G" | "H" | "J" => {
                        // A is of r⁴.
                        let place = "ABCDEFGHJ".find(key.as_str()).unwrap_or(0);
                        raw.even[place + 1] = number(0)?;
                    }
                    "SLB" => raw.surface.comment = words.join(" ").replace(['"', '\''], ""),
                    "CIR" | "REX" | "REY" => {
                        let kind = words.first().map(|word| word.to_uppercase());
                        let value = match kind.as_deref() {
                            Some("OBS" | "HOL") => continue,
                            Some("EDG" | "CLR") => number(1)?,
                            Some(_) | None => number(0)?,
                        };
                        raw.surface.semi_diameter = raw.surface.semi_diameter.max(value.abs());
                    }
                    "XDE" => raw.shift[0] = number(0)?,
                    "YDE" => raw.shift[1] = number(0)?,
                    "ZDE" => raw.shift[2] = number(0)?,
                    "ADE" => raw.tilt_deg[0] = number(0)?,
                    "BDE" => raw.tilt_deg[1] = number(0)?,
                    "CDE" => raw.tilt_deg[2] = number(0)?,
                    "DAR" => raw.back = Return::Back,
                    "BEN" => raw.back = Return::Bend,
                    "REV" => raw.back = Return::Reverse,
                    "COA" | "MLT" => {
                        out.notes.push(Note::info(at(), format!("`{command}` is not taken over: the surface is bare")));
                    }
                    _ => {}
                }
            }
        }
    }
    if raws.len() < 3 {
        return Err(Error::new(Where::file(path), "holds no lens").expected("SO, S and SI commands"));
    }
    if zoomed {
        out.notes.push(Note::info(Where::file(path), "the first zoom position counts"));
    }
    let last = raws.len() - 1;
    for (index, raw) in raws.into_iter().enumerate() {
        spread(raw, index == last, &mut out.surfaces);
    }
    out.field_deg = Some(fields).filter(|[x, y]| x.max(*y) > 0.0);
    out.wavelength_nm = waves.get(reference - 1).or(waves.first()).copied();
    Ok(out)
}

/// A surface with the turns before and behind it.
fn spread(raw: Raw, last: bool, out: &mut Vec<Surface>) {
    let Raw { mut surface, mut shift, tilt_deg, back, even } = raw;
    if let Some(end) = even.iter().rposition(|a| *a != 0.0) {
        surface.profile.form = Form::Even(even[..=end].to_vec());
    }
    if last {
        // How far the image is out of focus.
        let defocus = std::mem::take(&mut surface.thickness);
        shift[2] += if defocus.is_finite() { defocus } else { 0.0 };
    }
    if shift == [0.0; 3] && tilt_deg == [0.0; 3] {
        out.push(surface);
        return;
    }
    let line = surface.line;
    let turn = |turn: Turn, thickness: f64| Surface {
        line,
        comment: String::new(),
        turn: Some(turn),
        profile: Profile::PLANE,
        grating: None,
        thickness,
        after: After::Air,
        semi_diameter: 0.0,
        stop: false,
    };
    let whole = Turn { shift, tilt_deg, ..Turn::default() };
    let (before, behind) = match back {
        Return::Stay => (Some(whole), None),
        Return::Back => (Some(whole), Some(Turn { inverse: true, ..whole })),
        Return::Bend => (Some(whole), Some(Turn { shift: [0.0; 3], ..whole })),
        Return::Reverse => (None, Some(Turn { inverse: true, ..whole })),
    };
    out.extend(before.map(|before| turn(before, 0.0)));
    match behind {
        None => out.push(surface),
        Some(behind) => {
            let thickness = std::mem::take(&mut surface.thickness);
            out.push(surface);
            out.push(turn(behind, thickness));
        }
    }
}
