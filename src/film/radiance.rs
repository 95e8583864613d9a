//! Radiance pictures (`.hdr`, `.pic`). The header's lines, what multiplied the values (EXPOSURE, COLORCORR), the primaries, both kinds
//! of run lengths and all eight orientations: G. Ward, "Real Pixels", Graphics Gems II (1991), and "The RADIANCE Picture File
//! Format" in the Radiance reference manual (radiance-online.org/refer/filefmts.pdf, "Picture Files").

use super::still::{Light, MAX_PIXELS, Remark, Still};
use eyebox_base::colour::{Chromaticities, FileSpace, XYZ};

/// Longer lines are no header.
const LONGEST_LINE: usize = 1 << 16;
/// Scanlines of the newer run lengths are at least and less than so long; others are of the older kind.
const NEWER: std::ops::Range<usize> = 8..0x8000;

/// Whether a file begins as Radiance pictures do: `#?RADIANCE`, or `#?` and the name of another program.
pub fn is_radiance(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// What stands before the scanlines.
#[derive(Debug, Clone, PartialEq)]
struct Header {
    /// X, Y and Z in place of red, green and blue.
    xyz: bool,
    /// What each component was multiplied by.
    factors: [f64; 3],
    primaries: Option<Chromaticities>,
    /// Of the picture as it is looked at.
    width: usize,
    height: usize,
    /// Scanlines are columns.
    columns: bool,
    /// From the right to the left, from the bottom to the top.
    mirrored: [bool; 2],
}

/// Width and height; none where the beginning of a file does not tell them.
pub fn size(bytes: &[u8]) -> Option<[usize; 2]> {
    header(&mut &*bytes).ok().map(|header| [header.width, header.height])
}

impl Still {
    /// A Radiance picture, in the unit that it had before any EXPOSURE and COLORCORR. Errors: what is wrong with the file.
    pub fn of_radiance(mut bytes: &[u8]) -> Result<Still, String> {
        let from = &mut bytes;
        let header = header(from)?;
        let (width, height) = (header.width, header.height);
        if width == 0 || height == 0 {
            return Err("it has no pixels".to_owned());
        }
        if width.checked_mul(height).is_none_or(|pixels| pixels > MAX_PIXELS) {
            return Err(format!("it claims {width} × {height} pixels, more than a picture may have"));
        }
        let (lines, length) = if header.columns { (width, height) } else { (height, width) };
        // A file that ends early has filled no memory for what is missing.
        let mut stored = Vec::new();
        for line in 0..lines {
            let short = |what: &str| format!("{what} in scanline {} of {lines}", line + 1);
            scanline(from, length, &mut stored).map_err(|what| short(&what))?;
        }
        let (space, by) = header.space()?;
        let mut rgb = vec![[0.0f32; 3]; width * height];
        for (at, texel) in stored.into_iter().enumerate() {
            let (line, along) = (at / length, at % length);
            let (x, y) = if header.columns { (line, along) } else { (along, line) };
            let x = if header.mirrored[0] { width - 1 - x } else { x };
            let y = if header.mirrored[1] { height - 1 - y } else { y };
            let linear = values(texel, header.factors);
            let own = if space.is_linear_rec709() { linear } else { space.to_rec709(linear) };
            if let Some(to) = rgb.get_mut(y * width + x) {
                *to = own.map(|value| value as f32);
            }
        }
        let mut remarks = Vec::new();
        if header.factors != [1.0; 3] {
            let [r, g, b] = header.factors;
            let factors = if r == g && g == b { format!("{r}") } else { format!("({r}, {g}, {b})") };
            remarks.push(Remark::info(format!(
                "has values that EXPOSURE and COLORCORR of its header multiplied by {factors}: they are divided by it"
            )));
        }
        if !space.is_linear_rec709() {
            remarks.push(Remark::info(format!("is converted to linear Rec.709 by its {by}")));
        }
        Ok(Still { width, height, light: Light::Rgb(rgb), white_cd_m2: None, remarks })
    }
}

impl Header {
    /// How the components are to be read, and what says so. Without PRIMARIES they are those of Rec.709, as everybody writes
    /// them. Errors: primaries that span no colours.
    fn space(&self) -> Result<(FileSpace, &'static str), String> {
        let (primaries, by) = match (&self.primaries, self.xyz) {
            (_, true) => (&XYZ, "FORMAT"),
            (Some(own), false) => (own, "PRIMARIES"),
            (None, false) => return Ok((FileSpace::LINEAR_REC709, "FORMAT")),
        };
        let space = FileSpace::linear(primaries).ok_or("its PRIMARIES span no colours; expected x and y of four")?;
        Ok((space, by))
    }
}

/// A line without its end, be that LF or CR and LF.
fn line<'f>(from: &mut &'f [u8]) -> Result<&'f [u8], String> {
    let end = from.iter().take(LONGEST_LINE).position(|byte| *byte == b'\n').ok_or("it ends in its header")?;
    let (line, rest) = from.split_at(end);
    *from = rest.get(1..).unwrap_or(&[]);
    Ok(line.strip_suffix(b"\r").unwrap_or(line))
}

fn header(from: &mut &[u8]) -> Result<Header, String> {
    let mut header = Header {
        xyz: false,
        factors: [1.0; 3],
        primaries: None,
        width: 0,
        height: 0,
        columns: false,
        mirrored: [false; 2],
    };
    loop {
        let line = String::from_utf8_lossy(line(from)?).into_owned();
        if line.trim().is_empty() {
            break;
        }
        let Some((key, said)) = line.split_once('=') else { continue };
        let said = said.trim();
        match key.trim() {
            "FORMAT" => {
                header.xyz = match said {
                    "32-bit_rle_rgbe" => false,
                    "32-bit_rle_xyze" => true,
                    other => {
                        return Err(format!("its FORMAT is {other}; expected 32-bit_rle_rgbe or 32-bit_rle_xyze"));
                    }
                }
            }
            // Each program that multiplied the values left a line of its own.
            key @ "EXPOSURE" => {
                let [factor] = numbers(key, said)?;
                header.factors = header.factors.map(|own| own * factor);
            }
            key @ "COLORCORR" => {
                let factors: [f64; 3] = numbers(key, said)?;
                header.factors.iter_mut().zip(factors).for_each(|(own, factor)| *own *= factor);
            }
            "PRIMARIES" => {
                let all: Vec<f64> = said.split_whitespace().filter_map(|word| word.parse().ok()).collect();
                let pairs: Option<[[f64; 2]; 4]> = all.as_chunks::<2>().0.try_into().ok().filter(|_| all.len() == 8);
                header.primaries = Some(pairs.ok_or_else(|| {
                    format!("its PRIMARIES are {said}; expected x and y of red, green, blue and white")
                })?);
            }
            _ => {}
        }
    }
    if header.factors.iter().any(|factor| !(factor.is_finite() && *factor > 0.0)) {
        return Err("its EXPOSURE and COLORCORR have no finite product above 0".to_owned());
    }
    resolution(&String::from_utf8_lossy(line(from)?), &mut header)?;
    Ok(header)
}

fn numbers<const N: usize>(key: &str, said: &str) -> Result<[f64; N], String> {
    let all: Vec<f64> = said.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let sound = |number: &f64| *number > 0.0 && number.is_finite();
    let all = <[f64; N]>::try_from(all).ok().filter(|all| all.iter().all(sound));
    all.ok_or_else(|| format!("its {key} is {said}; expected {N} above 0"))
}

/// `-Y 32 +X 64`: the first axis is that of the scanlines' order, the second goes along each; `-Y` is from the top.
fn resolution(said: &str, header: &mut Header) -> Result<(), String> {
    let words: Vec<&str> = said.split_whitespace().collect();
    let bad = || format!("its size is `{}`; expected e.g. -Y 512 +X 1024", said.trim());
    let &[first, of_first, second, of_second] = words.as_slice() else { return Err(bad()) };
    let sizes = [of_first, of_second].map(|word| word.parse::<usize>().ok());
    let [Some(of_first), Some(of_second)] = sizes else { return Err(bad()) };
    header.columns = match (first, second) {
        ("-Y" | "+Y", "-X" | "+X") => false,
        ("-X" | "+X", "-Y" | "+Y") => true,
        (_, _) => return Err(bad()),
    };
    header.mirrored = [[first, second].contains(&"-X"), [first, second].contains(&"+Y")];
    (header.width, header.height) = if header.columns { (of_first, of_second) } else { (of_second, of_first) };
    Ok(())
}

fn take<'f, const N: usize>(from: &mut &'f [u8]) -> Result<&'f [u8; N], String> {
    let (taken, rest) = from.split_first_chunk::<N>().ok_or("it ends")?;
    *from = rest;
    Ok(taken)
}

/// Appends the texels of a scanline.
fn scanline(from: &mut &[u8], length: usize, to: &mut Vec<[u8; 4]>) -> Result<(), String> {
    let newer = NEWER.contains(&length)
        && matches!(from.first_chunk::<4>(), Some(&[2, 2, high, low]) if high < 0x80 && usize::from(u16::from_be_bytes([high, low])) == length);
    let start = to.len();
    if !newer {
        return older(from, start + length, to);
    }
    take::<4>(from)?;
    to.resize(start + length, [0; 4]);
    for component in 0..4 {
        let mut at = start;
        while at < start + length {
            let [code] = *take(from)?;
            let count = usize::from(if code > 128 { code - 128 } else { code });
            let run = to.get_mut(at..at + count).filter(|run| !run.is_empty()).ok_or("a run leaves its line")?;
            if code > 128 {
                let [value] = *take(from)?;
                run.iter_mut().for_each(|texel| texel[component] = value);
            } else {
                for texel in run {
                    let [value] = *take(from)?;
                    texel[component] = value;
                }
            }
            at += count;
        }
    }
    Ok(())
}

/// Plain texels, and (1, 1, 1, n) for n times the one before; such texels one after the other are the digits of n to the base
/// of 256, the lowest first.
fn older(from: &mut &[u8], end: usize, to: &mut Vec<[u8; 4]>) -> Result<(), String> {
    let start = to.len();
    let mut shift = 0u32;
    while to.len() < end {
        let texel = *take::<4>(from)?;
        if let [1, 1, 1, count] = texel {
            let last = to.get(start..).and_then(<[_]>::last).copied().ok_or("a run repeats nothing")?;
            let count = usize::from(count).checked_shl(shift).filter(|_| shift < 32).unwrap_or(usize::MAX);
            let whole = to.len().checked_add(count).filter(|whole| *whole <= end).ok_or("a run leaves its line")?;
            to.resize(whole, last);
            shift += 8;
        } else {
            to.push(texel);
            shift = 0;
        }
    }
    Ok(())
}

/// The mantissas times 2 to the exponent less 136; an exponent of 0 is black.
fn values([r, g, b, exponent]: [u8; 4], factors: [f64; 3]) -> [f64; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    let scale = f64::from(i32::from(exponent) - 136).exp2();
    let [r, g, b] = [r, g, b].map(|mantissa| f64::from(mantissa) * scale);
    [r / factors[0], g / factors[1], b / factors[2]]
}

#[cfg(test)]
#[path = "radiance_tests.rs"]
mod tests;
