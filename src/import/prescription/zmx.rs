//! Lens files of Zemax OpticStudio: lines of a keyword and what it takes; those of a surface are indented under its SURF.

use super::profile::Form;
use super::{After, Prescription, Profile, Surface, Turn};
use crate::base::error::Result;
use crate::base::{Error, Where};
use crate::scene::Note;
use std::path::Path;

/// A surface as it is read: its kind and the numbered parameters come before it is known what they mean.
#[derive(Default)]
struct Raw {
    line: usize,
    kind: String,
    comment: String,
    curvature: f64,
    conic: f64,
    thickness: f64,
    glass: Option<(String, [f64; 2])>,
    semi_diameter: f64,
    clear: f64,
    stop: bool,
    parm: Vec<(usize, f64)>,
    xdat: Vec<(usize, f64)>,
}

/// The prescription in `text`, the file at `path`.
pub(super) fn read(text: &str, path: &Path) -> Result<Prescription> {
    let mut out = Prescription { unit_m: 1e-3, ..Prescription::default() };
    let mut raws: Vec<Raw> = Vec::new();
    let mut waves: Vec<f64> = Vec::new();
    let (mut primary, mut fields, mut in_angles) = (1usize, [0.0f64; 2], false);
    for (number, line) in text.lines().enumerate() {
        let line_no = number + 1;
        let at = || Where::Line { file: path.to_owned(), line: line_no };
        let mut words = line.split_whitespace();
        let Some(key) = words.next() else { continue };
        let words: Vec<&str> = words.collect();
        let value = |i: usize| words.get(i).map(|word| word.parse::<f64>().unwrap_or(f64::NAN));
        let need = |i: usize| match value(i) {
            Some(number) if number.is_finite() => Ok(number),
            Some(_) | None => {
                Err(Error::new(at(), format!("`{}` is no line of {key}", line.trim())).expected("numbers after it"))
            }
        };
        match key {
            "MODE" if words.first() != Some(&"SEQ") => {
                return Err(Error::new(at(), "this design is not sequential").expected("MODE SEQ"));
            }
            "UNIT" => {
                out.unit_m = match words.first().copied() {
                    Some("MM") | None => 1e-3,
                    Some("CM") => 1e-2,
                    Some("IN") => 0.0254,
                    Some("METER" | "M") => 1.0,
                    Some(other) => {
                        return Err(Error::new(at(), format!("unknown unit `{other}`")).expected("MM, CM, IN or METER"));
                    }
                }
            }
            "ENPD" => out.pupil = Some(need(0)?).filter(|pupil| *pupil > 0.0),
            "FNUM" => out.f_number = Some(need(0)?).filter(|ratio| *ratio > 0.0),
            "GCAT" => out.catalogues = words.iter().map(|word| (*word).to_owned()).collect(),
            "FTYP" => in_angles = value(0) == Some(0.0),
            "XFLN" | "YFLN" => {
                let largest = (0..words.len()).filter_map(value).map(f64::abs).fold(0.0, f64::max);
                fields[usize::from(key == "YFLN")] = largest;
            }
            "WAVM" if value(2).unwrap_or(1.0) > 0.0 => waves.push(need(1)?),
            "WAVL" => waves = (0..words.len()).filter_map(value).filter(|um| um.is_finite()).collect(),
            "PWAV" => primary = value(0).map_or(1, |number| number as usize),
            "SURF" => raws.push(Raw { line: line_no, kind: "STANDARD".to_owned(), ..Raw::default() }),
            _ => {
                let Some(raw) = raws.last_mut().filter(|_| line.starts_with([' ', '\t'])) else { continue };
                match key {
                    "TYPE" => raw.kind = words.first().copied().unwrap_or("").to_owned(),
                    "COMM" => raw.comment = words.join(" "),
                    "CURV" => raw.curvature = need(0)?,
                    "CONI" => raw.conic = need(0)?,
                    "DISZ" => raw.thickness = if words.first() == Some(&"INFINITY") { f64::INFINITY } else { need(0)? },
                    "GLAS" => {
                        let model = [3, 4].map(|i| value(i).unwrap_or(f64::NAN));
                        raw.glass = words.first().map(|name| ((*name).to_owned(), model));
                    }
                    "DIAM" => raw.semi_diameter = need(0)?,
                    "CLAP" | "FLAP" => raw.clear = need(1)?,
                    "STOP" => raw.stop = true,
                    "COAT" => {
                        let text = format!("the coating {} is not taken over: the surface is bare", words.join(" "));
                        out.notes.push(Note::info(at(), text));
                    }
                    "PARM" => raw.parm.push((need(0)? as usize, need(1)?)),
                    "XDAT" => raw.xdat.push((need(0)? as usize, need(1)?)),
                    _ => {}
                }
            }
        }
    }
    if raws.len() < 3 {
        return Err(Error::new(Where::file(path), "holds no lens").expected("SURF lines of object, surfaces and image"));
    }
    let (first, last) = (1, raws.len() - 1);
    for (index, raw) in raws.into_iter().enumerate() {
        // What the object is like is of no meaning to the parts.
        let raw = if index < first { Raw { kind: "STANDARD".to_owned(), parm: Vec::new(), ..raw } } else { raw };
        out.surfaces.push(surface(raw, index == last, path)?);
    }
    out.field_deg = Some(fields).filter(|[x, y]| in_angles && x.max(*y) > 0.0);
    out.wavelength_nm = waves.get(primary.max(1) - 1).or(waves.first()).map(|um| um * 1e3);
    Ok(out)
}

fn surface(raw: Raw, last: bool, path: &Path) -> Result<Surface> {
    let at = Where::Line { file: path.to_owned(), line: raw.line };
    let of =
        |list: &[(usize, f64)], number: usize| list.iter().rev().find(|(own, _)| *own == number).map_or(0.0, |p| p.1);
    let parm = |number: usize| of(&raw.parm, number);
    let coefficients = |list: &[(usize, f64)], from: usize| -> Vec<f64> {
        let end = list.iter().filter(|(_, value)| *value != 0.0).map(|(number, _)| *number + 1).max().unwrap_or(from);
        (from..end.min(from + 1000)).map(|number| of(list, number)).collect()
    };
    let refuse = |what: String| Err(Error::new(at.clone(), what).expected("a surface of another type"));
    let mut turn = None;
    let form = match raw.kind.as_str() {
        // Of a grating the first number is of lines per µm, the second the order.
        "STANDARD" | "DGRATING" => Form::Conic,
        "EVENASPH" => {
            let even = coefficients(&raw.parm, 1);
            if even.is_empty() { Form::Conic } else { Form::Even(even) }
        }
        "COORDBRK" => {
            turn = Some(Turn {
                shift: [parm(1), parm(2), 0.0],
                tilt_deg: [parm(3), parm(4), parm(5)],
                tilts_first: parm(6) != 0.0,
                inverse: false,
            });
            Form::Conic
        }
        "TOROIDAL" => {
            if raw.conic != 0.0 || raw.parm.iter().any(|(number, value)| *number > 1 && *value != 0.0) {
                return refuse("a toroid whose curve is no circle cannot be traced".to_owned());
            }
            Form::Toroid { across: if parm(1) == 0.0 { 0.0 } else { 1.0 / parm(1) } }
        }
        "XPOLYNOM" | "SZERNSAG" | "FZERNSAG" => {
            let norm_radius = Some(of(&raw.xdat, 2)).filter(|radius| *radius > 0.0).unwrap_or(1.0);
            let count = of(&raw.xdat, 1) as usize;
            let given: Vec<f64> = coefficients(&raw.xdat, 3).into_iter().take(count).collect();
            if raw.parm.iter().any(|(_, value)| *value != 0.0) {
                return refuse(format!("{} with aspheric terms beside its own cannot be traced", raw.kind));
            }
            match raw.kind.as_str() {
                "XPOLYNOM" => polynomial(&given, norm_radius),
                "SZERNSAG" => zernike(given.iter().enumerate().map(|(index, c)| (noll(index + 1), *c)), norm_radius),
                _ => zernike(given.iter().enumerate().map(|(index, c)| fringe(index + 1, *c)), norm_radius),
            }
        }
        other => return refuse(format!("surfaces of type {other} are not read")),
    };
    let grating = (raw.kind == "DGRATING" && parm(1) != 0.0 && parm(2) != 0.0).then(|| [1e3 * parm(1), parm(2)]);
    let after = match raw.glass {
        None => After::Air,
        Some((name, _)) if name == "MIRROR" => After::Mirror,
        Some((name, model)) if name == "___BLANK" => match model {
            [n, v] if n >= 1.0 && v > 0.0 => After::Model(model),
            [..] => return Err(Error::new(at, "a model glass without n_d and V_d").expected("numbers of it")),
        },
        // The file's own numbers are the program's stand-ins unless they are those of a glass.
        Some((name, model)) => {
            let own = (model[0] > 1.0 && model[1] > 0.0 && model != [1.5, 40.0]).then_some(model);
            After::Glass { name, model: own }
        }
    };
    if !last && !raw.thickness.is_finite() && raw.line > 0 && turn.is_some() {
        return Err(Error::new(at, "a coordinate break at infinity").expected("a finite DISZ"));
    }
    let semi_diameter = if raw.clear > 0.0 { raw.clear.max(raw.semi_diameter) } else { raw.semi_diameter };
    Ok(Surface {
        line: raw.line,
        comment: raw.comment,
        turn,
        profile: Profile { curvature: raw.curvature, conic: raw.conic, form },
        grating,
        thickness: if last { 0.0 } else { raw.thickness },
        after: if turn.is_some() { After::Air } else { after },
        semi_diameter: if semi_diameter.is_finite() { semi_diameter.abs() } else { 0.0 },
        stop: raw.stop,
    })
}

/// Coefficients of x, y, x², xy, … of the places over the norm radius.
fn polynomial(given: &[f64], norm_radius: f64) -> Form {
    let mut coeffs = vec![0.0];
    for degree in 1.. {
        for _ in 0..=degree {
            let Some(c) = given.get(coeffs.len() - 1) else { return Form::Polynomial(coeffs) };
            coeffs.push(c / norm_radius.powi(degree));
        }
    }
    Form::Polynomial(coeffs)
}

/// Coefficients by n and m (below 0: sines) of polynomials whose mean square is 1.
fn zernike(given: impl Iterator<Item = ([i64; 2], f64)>, norm_radius: f64) -> Form {
    let mut coeffs = Vec::new();
    for ([n, m], c) in given.filter(|(_, c)| *c != 0.0) {
        let Ok(j) = usize::try_from((n * (n + 2) + m) / 2) else { continue };
        if coeffs.len() <= j {
            coeffs.resize(j + 1, 0.0);
        }
        coeffs[j] += c;
    }
    if coeffs.is_empty() { Form::Conic } else { Form::Zernike { norm_radius, coeffs } }
}

/// Standard Zernike coefficients are numbered as Noll does (J. Opt. Soc. Am. 66, 207, 1976): within an order by rising |m|,
/// even numbers are cosines.
fn noll(number: usize) -> [i64; 2] {
    let n = (0..).find(|n| (n + 1) * (n + 2) / 2 >= number).unwrap_or(0);
    let k = number - n * (n + 1) / 2 - 1;
    let size = if n % 2 == 0 { 2 * k.div_ceil(2) } else { 2 * (k / 2) + 1 };
    [n as i64, if number.is_multiple_of(2) { size as i64 } else { -(size as i64) }]
}

/// Fringe coefficients go by rising n + |m| and within that by falling |m|, cosine before sine, and their polynomials are 1 at
/// the rim (Wyant and Creath, "Basic Wavefront Aberration Theory", 1992, table III); the thirty-seventh is that of n = 12.
fn fringe(number: usize, c: f64) -> ([i64; 2], f64) {
    let side = (1..).find(|side| side * side >= number).unwrap_or(1);
    let behind = side * side - number;
    let m = behind.div_ceil(2) as i64;
    let n = 2 * (side as i64 - 1) - m;
    let [n, m] = if number == 37 { [12, 0] } else { [n, if behind.is_multiple_of(2) { m } else { -m }] };
    let norm = ((2 * n + 2) as f64 / if m == 0 { 2.0 } else { 1.0 }).sqrt();
    ([n, m], c / norm)
}
