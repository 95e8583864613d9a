//! Planes of numbers inside the page: each a PNG in base64, which holds the first three bytes of every value.

use eyebox_base::error::{Error, Result, Where};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::collections::HashMap;

/// Values that a page holds at most: with 3 bytes each, and a third more in base64, 16 MB that cannot be compressed.
pub const MOST_VALUES: usize = 4_000_000;
/// What a plane that is 0 everywhere is called.
const BLACK: i64 = -1;

/// How a plane is made smaller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reduce {
    /// Light: the mean of a block.
    Mean,
    /// Names, places, directions: the block's first pixel.
    First,
}

/// The planes of a frame, each once, however many layers show it.
pub struct Planes<'f> {
    width: usize,
    height: usize,
    data: Vec<(&'f [f32], Reduce)>,
    known: HashMap<(blake3::Hash, Reduce), i64>,
}

impl<'f> Planes<'f> {
    pub fn new(width: usize, height: usize) -> Self {
        Planes { width, height, data: Vec::new(), known: HashMap::new() }
    }

    /// The index of a plane of width × height values, or −1 for one that is 0.
    pub fn index(&mut self, plane: &'f [f32], reduce: Reduce) -> i64 {
        if plane.iter().all(|value| *value == 0.0) {
            return BLACK;
        }
        let mut hasher = blake3::Hasher::new();
        for row in plane.chunks(4096) {
            let bytes: Vec<u8> = row.iter().flat_map(|value| value.to_le_bytes()).collect();
            hasher.update(&bytes);
        }
        let next = i64::try_from(self.data.len()).unwrap_or(BLACK);
        let index = *self.known.entry((hasher.finalize(), reduce)).or_insert(next);
        if index == next {
            self.data.push((plane, reduce));
        }
        index
    }

    /// Sides of the blocks that are taken together so that the page stays small: 1 for all pixels.
    pub fn factor(&self) -> usize {
        let values = |factor: usize| self.data.len() * self.width.div_ceil(factor) * self.height.div_ceil(factor);
        let most = self.width.max(self.height).max(1);
        (1..=most).find(|factor| values(*factor) <= MOST_VALUES).unwrap_or(most)
    }

    /// All planes as base64 of a PNG.
    /// Errors: a picture too large for the format.
    pub fn encode(&self, factor: usize) -> Result<Vec<String>> {
        let encode = |(plane, reduce): &(&[f32], Reduce)| {
            let small = reduced(plane, [self.width, self.height], factor, *reduce);
            png(&small, self.width.div_ceil(factor), self.height.div_ceil(factor)).map(|bytes| base64(&bytes))
        };
        self.data.iter().map(encode).collect()
    }
}

/// Blocks of `factor` × `factor` values as one; those at the right and lower edge may be smaller.
fn reduced(plane: &[f32], [width, height]: [usize; 2], factor: usize, reduce: Reduce) -> Vec<f32> {
    if factor <= 1 {
        return plane.to_vec();
    }
    let mut out = Vec::with_capacity(width.div_ceil(factor) * height.div_ceil(factor));
    for top in (0..height).step_by(factor) {
        for left in (0..width).step_by(factor) {
            let rows = top..(top + factor).min(height);
            let right = (left + factor).min(width);
            let block = rows.flat_map(|y| plane.get(y * width + left..y * width + right).unwrap_or_default());
            out.push(match reduce {
                Reduce::First => block.copied().next().unwrap_or(0.0),
                Reduce::Mean => {
                    let (sum, count) = block.fold((0.0, 0u32), |(sum, n), v| (sum + f64::from(*v), n + 1));
                    (sum / f64::from(count.max(1))) as f32
                }
            });
        }
    }
    out
}

/// The sign, the exponent and the first 15 bits of the mantissa, rounded: 2⁻¹⁶ of a value is lost at most.
pub fn three_bytes(value: f32) -> [u8; 3] {
    let bits = if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() };
    // Half a step more rounds; it may carry into the exponent, which is right, but not into infinity.
    let up = bits.wrapping_add(0x80) & !0xff;
    let bits = if value.is_finite() && f32::from_bits(up).is_finite() { up } else { bits };
    let [a, b, c, _] = bits.to_be_bytes();
    [a, b, c]
}

/// One grey byte a pixel, three pictures below each other; not filtered, so that a page can read it with little code.
fn png(values: &[f32], width: usize, height: usize) -> Result<Vec<u8>> {
    let too_large = |why: String| Error::new(Where::Nowhere, format!("cannot be put into a page: {why}"));
    let sides = (u32::try_from(width), u32::try_from(height.saturating_mul(3)));
    let (Ok(wide), Ok(high)) = sides else { return Err(too_large(format!("{width} × {height} pixels"))) };
    let split: Vec<[u8; 3]> = values.iter().map(|value| three_bytes(*value)).collect();
    let bytes: Vec<u8> = (0..3).flat_map(|byte| split.iter().map(move |of| of[byte])).collect();
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Default, FilterType::NoFilter)
        .write_image(&bytes, wide, high, ExtendedColorType::L8)
        .map_err(|error| too_large(error.to_string()))?;
    Ok(out)
}

/// RFC 4648, section 4.
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |index: usize| u32::from(three.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let letter = (bits >> (18 - 6 * place) & 63) as usize;
            out.push(if place <= three.len() { char::from(LETTERS[letter]) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The values of a plane, as the page reads them.
    pub fn decode(text: &str) -> Vec<f32> {
        let value = |letter: u8| match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            other => panic!("{other} in base64"),
        };
        let letters: Vec<u8> = text.bytes().filter(|letter| *letter != b'=').map(value).collect();
        let mut bits = letters.iter().flat_map(|six| (0..6).rev().map(move |bit| six >> bit & 1));
        let bytes: Vec<u8> = std::iter::from_fn(|| {
            let eight: Vec<u8> = bits.by_ref().take(8).collect();
            (eight.len() == 8).then(|| eight.iter().fold(0, |byte, bit| byte << 1 | bit))
        })
        .collect();
        let picture = image::load_from_memory(&bytes).expect("a PNG").into_luma8().into_raw();
        let (a, rest) = picture.split_at(picture.len() / 3);
        let (b, c) = rest.split_at(a.len());
        a.iter().zip(b).zip(c).map(|((a, b), c)| f32::from_be_bytes([*a, *b, *c, 0])).collect()
    }

    #[test]
    fn planes_come_back() {
        let values = [
            0.0,
            -0.0,
            1.0,
            1e-30,
            3.6e6,
            -7.123_456,
            f32::MAX,
            f32::MIN_POSITIVE,
            f32::INFINITY,
            f32::NAN,
            5e-42,
            2.5,
        ];
        let mut planes = Planes::new(4, 3);
        assert_eq!(planes.index(&values, Reduce::Mean), 0);
        let same = values;
        assert_eq!(planes.index(&same, Reduce::Mean), 0, "the same plane twice is one");
        assert_eq!(planes.index(&[0.0; 12], Reduce::Mean), BLACK);
        assert_eq!(planes.index(&[2.0; 12], Reduce::Mean), 1);
        assert_eq!(planes.factor(), 1);
        let found = decode(&planes.encode(1).unwrap()[0]);
        for (want, got) in values.iter().zip(&found) {
            let near = (want - got).abs() <= want.abs() * 2f32.powi(-16) || (want.abs() < 1e-38 && got.abs() < 1e-38);
            assert!(near || want == got || (want.is_nan() && got.is_nan()), "{want} came back as {got}");
        }
        assert_eq!(found.len(), 12);
    }

    #[test]
    fn large_frames_shrink() {
        let (width, height) = (3000, 2000);
        let plane: Vec<f32> = (0..width * height).map(|pixel| (pixel % width) as f32).collect();
        let mut planes = Planes::new(width, height);
        planes.index(&plane, Reduce::Mean);
        planes.index(&plane, Reduce::First);
        // 2 × 6 million values: blocks of 2 × 2 leave 3 million.
        assert_eq!(planes.factor(), 2);
        assert_eq!(reduced(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3, 2], 2, Reduce::Mean), [3.0, 4.5]);
        assert_eq!(reduced(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3, 2], 2, Reduce::First), [1.0, 3.0]);
    }

    #[test]
    fn base64_as_in_its_standard() {
        // RFC 4648, section 10.
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }
}
