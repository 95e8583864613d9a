//! Lens files of Zemax OpticStudio: lines of a keyword and what it takes; those of a surface are indented under its SURF.

mod terms;

use super::profile::Form;
use super::{After, Aperture, Heights, Outline, Prescription, Profile, Surface, Turn};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::Note;
use std::path::Path;
use terms::{fringe, noll, polynomial, rotational, zernike};

#[derive(Clone, Copy, PartialEq)]
enum Obscuration {
    Ring,
    Rectangle,
    Ellipse,
}

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
    /// Of a circular aperture: where it begins and ends.
    clear: [f64; 2],
    /// Half sizes of a rectangular or elliptical one.
    half: Option<([f64; 2], bool)>,
    centre: [f64; 2],
    /// What an obscuration covers: the numbers of OBSC (from and to which radius), or of SQOB and ELOB (half sizes).
    dark: Option<(Obscuration, [f64; 2])>,
    stop: bool,
    /// Turned and shifted by itself: the line, and the numbers there.
    own_turn: Option<(usize, Vec<f64>)>,
    parm: Vec<(usize, f64)>,
    xdat: Vec<(usize, f64)>,
}

/// The prescription in `text`, the file at `path`.
pub(super) fn read(text: &str, path: &Path) -> Result<Prescription> {
    let mut out = Prescription { unit_m: 1e-3, ..Prescription::default() };
    let mut raws: Vec<Raw> = Vec::new();
    let mut waves: Vec<f64> = Vec::new();
    let (mut primary, mut fields, mut kind) = (1usize, [0.0f64; 2], 0.0);
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
            // The second number says whether the ratio is a working one.
            "FNUM" if value(1) == Some(1.0) => out.aperture = Some(Aperture::WorkingRatio(need(0)?)),
            "FNUM" => out.aperture = Some(Aperture::Ratio(need(0)?)),
            // Of object space; the second number says whether it is an angle, in degrees.
            "OBNA" if value(1) == Some(1.0) => {
                out.aperture = Some(Aperture::ObjectNa(need(0)?.to_radians().sin()));
            }
            "OBNA" => out.aperture = Some(Aperture::ObjectNa(need(0)?)),
            "FLOA" => out.aperture = Some(Aperture::Stop),
            "GCAT" => out.catalogues = words.iter().map(|word| (*word).to_owned()).collect(),
            "FTYP" => kind = need(0)?,
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
                    "CLAP" | "FLAP" => raw.clear = [need(0)?, need(1)?],
                    "SQAP" | "ELAP" => raw.half = Some(([need(0)?, need(1)?], key == "SQAP")),
                    "OBDC" => raw.centre = [need(0)?, need(1)?],
                    "OBSC" => raw.dark = Some((Obscuration::Ring, [need(0)?, need(1)?])),
                    "SQOB" => raw.dark = Some((Obscuration::Rectangle, [need(0)?, need(1)?])),
                    "ELOB" => raw.dark = Some((Obscuration::Ellipse, [need(0)?, need(1)?])),
                    "SPID" | "USAP" | "USOB" => {
                        let text =
                            format!("the aperture `{}` is not taken over: nothing stops light there", line.trim());
                        out.notes.push(Note::info(at(), text));
                    }
                    "SCBD" if (3..words.len()).any(|i| value(i) != Some(0.0)) => {
                        let numbers = (0..words.len()).map(need).collect::<Result<Vec<f64>>>()?;
                        raw.own_turn = Some((line_no, numbers));
                    }
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
    for (index, mut raw) in raws.into_iter().enumerate() {
        match raw.own_turn.take() {
            // Before the image, which nothing comes after; what the first numbers mean elsewhere is written nowhere.
            Some((line, numbers)) if index == last && matches!(numbers.as_slice(), [1.0, 0.0, 0.0, _, _, _, _, _]) => {
                let turn = [(1, numbers[3]), (2, numbers[4]), (3, numbers[5]), (4, numbers[6]), (5, numbers[7])];
                let own = Raw { line, kind: "COORDBRK".to_owned(), parm: turn.to_vec(), ..Raw::default() };
                out.surfaces.push(surface(own, false, path)?);
            }
            Some((line, _)) => {
                let at = Where::Line { file: path.to_owned(), line };
                return Err(Error::new(at, "a surface that is tilted or decentred by itself is not read")
                    .expected("a coordinate break (COORDBRK) before it"));
            }
            None => {}
        }
        // What the object is like is of no meaning to the parts.
        let raw = if index < first { Raw { kind: "STANDARD".to_owned(), parm: Vec::new(), ..raw } } else { raw };
        out.surfaces.push(surface(raw, index == last, path)?);
    }
    if fields != [0.0; 2] {
        // Angles, heights of the object, heights of the image by paraxial or by real rays, angles of a theodolite.
        match kind {
            1.0 => out.heights = Some(Heights::Object(fields)),
            2.0 | 3.0 => out.heights = Some(Heights::Image(fields)),
            _ => out.field_deg = Some(fields),
        }
    }
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
        // Even powers of the place over the norm radius: number 1 says how many, number 2 the radius.
        "XASPHERE" => {
            let norm_radius = Some(of(&raw.xdat, 2)).filter(|radius| *radius > 0.0).unwrap_or(1.0);
            if raw.parm.iter().any(|(_, value)| *value != 0.0) {
                return refuse("XASPHERE with numbers beside its own terms cannot be traced".to_owned());
            }
            let given = coefficients(&raw.xdat, 3).into_iter().take(of(&raw.xdat, 1) as usize);
            let even: Vec<f64> = given.zip(1..).map(|(c, i)| c / norm_radius.powi(2 * i)).collect();
            if even.iter().any(|c| !c.is_finite()) {
                return refuse(format!("terms over a norm radius of {norm_radius} are no numbers"));
            }
            if even.is_empty() { Form::Conic } else { Form::Even(even) }
        }
        // Powers 1, 2, 3, … of the radius.
        "ODDASPHE" => {
            let given = coefficients(&raw.parm, 1);
            if let Some(power) = (1..).step_by(2).zip(given.iter().step_by(2)).find(|(_, c)| **c != 0.0) {
                return refuse(format!("an asphere with the power {} of the radius cannot be traced", power.0));
            }
            let even: Vec<f64> = given.into_iter().skip(1).step_by(2).collect();
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
            // Parameter 0 of Zernike sags says whether they go on beyond the norm radius; 1 to 8 are those of even aspheres.
            let most = if raw.kind == "XPOLYNOM" { 0 } else { 8 };
            if raw.parm.iter().any(|(number, value)| *number > most && *value != 0.0) {
                return refuse(format!("{} with numbers beside its own terms cannot be traced", raw.kind));
            }
            let numbered = || given.iter().enumerate();
            let even = (1..=8).map(|i| (i, parm(i))).filter(|(_, c)| *c != 0.0);
            let even = even.flat_map(|(i, c)| rotational(i, c * norm_radius.powi(2 * i as i32)));
            match raw.kind.as_str() {
                "XPOLYNOM" => polynomial(&given, norm_radius),
                "SZERNSAG" => zernike(numbered().map(|(index, c)| (noll(index + 1), *c)).chain(even), norm_radius),
                _ => zernike(numbered().map(|(index, c)| fringe(index + 1, *c)).chain(even), norm_radius),
            }
        }
        other => return refuse(format!("surfaces of type {other} are not read")),
    };
    let grating = (raw.kind == "DGRATING" && parm(1) != 0.0 && parm(2) != 0.0).then(|| [1e3 * parm(1), parm(2)]);
    let after = match raw.glass {
        None => After::Air,
        Some((name, _)) if name == "MIRROR" => After::Mirror,
        Some((name, model)) if name == "___BLANK" => match model {
            [n, v] if n >= 1.0 && v >= 0.0 => After::Model(model),
            [..] => {
                return Err(Error::new(at, "a model glass without n_d and V_d")
                    .expected("n_d of 1 and more, V_d of 0 and more"));
            }
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
    let [hole, clear] = raw.clear;
    let semi_diameter = if clear > 0.0 { clear.max(raw.semi_diameter) } else { raw.semi_diameter };
    let semi_diameter = if semi_diameter.is_finite() { semi_diameter.abs() } else { 0.0 };
    // An aperture that is shifted ends the surface where it does, a round one about the axis has room around it.
    let round = if clear > 0.0 { clear } else { semi_diameter };
    let shifted = (raw.centre != [0.0; 2] && raw.dark.is_none()).then_some(([round; 2], false));
    let dark = raw.dark.and_then(|(kind, [a, b])| {
        let (half, inner) = match kind {
            Obscuration::Ring => ([b; 2], a / b),
            Obscuration::Rectangle | Obscuration::Ellipse => ([a, b], 0.0),
        };
        let outline = Outline { centre: raw.centre, half, corners: kind == Obscuration::Rectangle };
        (half.iter().all(|half| *half > 0.0) && inner < 1.0).then_some((outline, inner.max(0.0)))
    });
    let outline = raw.half.or(shifted).filter(|(half, _)| half.iter().all(|half| *half > 0.0));
    Ok(Surface {
        line: raw.line,
        comment: raw.comment,
        turn,
        profile: Profile { curvature: raw.curvature, conic: raw.conic, form },
        grating,
        thickness: if last { 0.0 } else { raw.thickness },
        after: if turn.is_some() { After::Air } else { after },
        semi_diameter,
        outline: outline.map(|(half, corners)| Outline { centre: raw.centre, half, corners }),
        hole: hole.max(0.0),
        dark,
        stop: raw.stop,
    })
}
