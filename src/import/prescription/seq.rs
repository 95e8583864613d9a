//! Sequences of CODE V: commands one after the other, several a line behind semicolons; those between two S commands are of the
//! surface that the first one began. A command may name its surface instead (`THI S3 5`).

mod axes;
mod private;
mod words;

use super::{After, Aperture, Heights, Prescription, Profile, Surface};
use axes::{Raw, Return, spread};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::Note;
use private::Private;
use std::path::Path;
use words::{commands, glass, qualifier};

/// Commands that bend light or turn axes in ways that are not read.
const REFUSED: [&str; 15] =
    ["SPS", "XTO", "YTO", "AAS", "CYL", "DIF", "HOE", "HCT", "GRT", "NSS", "GLB", "FRN", "UDS", "MOD", "RET"];

/// The prescription in `text`, the file at `path`.
pub(super) fn read(text: &str, path: &Path) -> Result<Prescription> {
    let mut out = Prescription { unit_m: 1e-3, ..Prescription::default() };
    let (mut raws, mut radii, mut reference) = (Vec::<Raw>::new(), false, 1usize);
    let (mut waves, mut fields, mut zoomed, mut heights) = (Vec::new(), [0.0f64; 2], false, None);
    // Whether this is between PRV and END, where the file's own glasses are.
    let (mut private, mut known) = (false, Private::default());
    for (line, command) in commands(text) {
        let at = || Where::Line { file: path.to_owned(), line };
        let mut words: Vec<&str> = command.split_whitespace().collect();
        let Some(key) = words.first().map(|word| word.to_uppercase()) else { continue };
        match key.as_str() {
            "PRV" => private = true,
            "END" => private = false,
            _ if private => known.take(&key, words.get(1..).unwrap_or(&[])),
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
            "FNO" => out.aperture = Some(Aperture::Ratio(number(0)?)),
            "NA" => out.aperture = Some(Aperture::ImageNa(number(0)?)),
            "NAO" => out.aperture = Some(Aperture::ObjectNa(number(0)?)),
            "WL" => waves = (0..words.len()).map(number).collect::<Result<Vec<f64>>>()?,
            "REF" => reference = number(0)?.max(1.0) as usize,
            "XAN" | "YAN" | "XOB" | "YOB" | "XIM" | "YIM" | "XRI" | "YRI" => {
                let values = (0..words.len()).map(number).collect::<Result<Vec<f64>>>()?;
                let side = usize::from(key.starts_with('Y'));
                fields[side] = values.iter().fold(0.0, |most, value| value.abs().max(most));
                heights = match &key[1..] {
                    "OB" => Some(Heights::Object as fn([f64; 2]) -> Heights),
                    "IM" | "RI" => Some(Heights::Image as fn([f64; 2]) -> Heights),
                    _ => None,
                };
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
                    outline: None,
                    hole: 0.0,
                    dark: None,
                    stop: false,
                };
                raws.push(Raw {
                    surface,
                    shift: [0.0; 3],
                    tilt_deg: [0.0; 3],
                    back: Return::Stay,
                    even: [0.0; 10],
                    rectangle: [0.0; 2],
                    ellipse: [0.0; 2],
                    middle: [0.0; 2],
                });
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
                    "CIR" | "REX" | "REY" | "ELX" | "ELY" => {
                        let kind = words.first().map(|word| word.to_uppercase());
                        let value = match kind.as_deref() {
                            Some(kind @ ("OBS" | "HOL")) => {
                                if kind == "HOL" && key == "CIR" {
                                    raw.surface.hole = number(words.len() - 1)?.abs();
                                } else {
                                    let text = format!("`{command}` is not taken over: nothing stops light there");
                                    out.notes.push(Note::info(at(), text));
                                }
                                continue;
                            }
                            Some(_) => number(words.len() - 1)?.abs(),
                            None => 0.0,
                        };
                        raw.surface.semi_diameter = raw.surface.semi_diameter.max(value);
                        let side = usize::from(key.ends_with('Y'));
                        match key.as_str() {
                            "REX" | "REY" => raw.rectangle[side] = raw.rectangle[side].max(value),
                            "ELX" | "ELY" => raw.ellipse[side] = raw.ellipse[side].max(value),
                            _ => {}
                        }
                    }
                    "ADX" => raw.middle[0] = number(words.len().saturating_sub(1))?,
                    "ADY" => raw.middle[1] = number(words.len().saturating_sub(1))?,
                    "XDE" => raw.shift[0] = number(0)?,
                    "YDE" => raw.shift[1] = number(0)?,
                    "ZDE" => raw.shift[2] = number(0)?,
                    // Those about x and y are left-handed (so are LightTools', whose manual says that they are CODE V's).
                    "ADE" => raw.tilt_deg[0] = -number(0)?,
                    "BDE" => raw.tilt_deg[1] = -number(0)?,
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
    if fields != [0.0; 2] {
        match heights {
            Some(heights) => out.heights = Some(heights(fields)),
            None => out.field_deg = Some(fields),
        }
    }
    out.wavelength_nm = waves.get(reference - 1).or(waves.first()).copied();
    Ok(out)
}
