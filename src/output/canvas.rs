//! An 8-bit picture to draw on, with letters small enough for labels.

use eyebox_base::atomic::write_atomic;
use eyebox_base::error::{Error, Result, Where};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// sRGB, three bytes a pixel, row by row from the top left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pub bytes: Vec<u8>,
}

/// Columns and rows of a letter, without the gap.
const LETTER: [usize; 2] = [3, 5];
/// From a letter to the next and from a line to the next.
pub const STEP: [usize; 2] = [4, 7];

/// Letters as five rows of three bits each, the left column the highest bit.
const LETTERS: [(char, [u8; 5]); 43] = [
    ('0', [7, 5, 5, 5, 7]),
    ('1', [2, 6, 2, 2, 7]),
    ('2', [7, 1, 7, 4, 7]),
    ('3', [7, 1, 7, 1, 7]),
    ('4', [5, 5, 7, 1, 1]),
    ('5', [7, 4, 7, 1, 7]),
    ('6', [7, 4, 7, 5, 7]),
    ('7', [7, 1, 2, 2, 2]),
    ('8', [7, 5, 7, 5, 7]),
    ('9', [7, 5, 7, 1, 7]),
    ('a', [2, 5, 7, 5, 5]),
    ('b', [6, 5, 6, 5, 6]),
    ('c', [3, 4, 4, 4, 3]),
    ('d', [6, 5, 5, 5, 6]),
    ('e', [7, 4, 6, 4, 7]),
    ('f', [7, 4, 6, 4, 4]),
    ('g', [3, 4, 5, 5, 3]),
    ('h', [5, 5, 7, 5, 5]),
    ('i', [7, 2, 2, 2, 7]),
    ('j', [1, 1, 1, 5, 2]),
    ('k', [5, 5, 6, 5, 5]),
    ('l', [4, 4, 4, 4, 7]),
    ('m', [5, 7, 7, 5, 5]),
    ('n', [6, 5, 5, 5, 5]),
    ('o', [2, 5, 5, 5, 2]),
    ('p', [6, 5, 6, 4, 4]),
    ('q', [2, 5, 5, 7, 3]),
    ('r', [6, 5, 6, 5, 5]),
    ('s', [3, 4, 2, 1, 6]),
    ('t', [7, 2, 2, 2, 2]),
    ('u', [5, 5, 5, 5, 7]),
    ('v', [5, 5, 5, 5, 2]),
    ('w', [5, 5, 7, 7, 5]),
    ('x', [5, 5, 2, 5, 5]),
    ('y', [5, 5, 2, 2, 2]),
    ('z', [7, 1, 2, 4, 7]),
    ('_', [0, 0, 0, 0, 7]),
    ('.', [0, 0, 0, 0, 2]),
    ('-', [0, 0, 7, 0, 0]),
    ('+', [0, 2, 7, 2, 0]),
    ('/', [1, 1, 2, 4, 4]),
    (':', [0, 2, 0, 2, 0]),
    ('²', [6, 2, 4, 6, 0]),
];

impl Canvas {
    /// One colour all over.
    pub fn new(width: usize, height: usize, colour: [u8; 3]) -> Canvas {
        Canvas { width, height, bytes: colour.repeat(width.saturating_mul(height)) }
    }

    /// Colours a pixel; outside nothing happens.
    pub fn set(&mut self, x: usize, y: usize, colour: [u8; 3]) {
        if x < self.width
            && let Some(to) = self.bytes.get_mut(3 * (y * self.width + x)..3 * (y * self.width + x) + 3)
        {
            to.copy_from_slice(&colour);
        }
    }

    /// Colours a rectangle.
    pub fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], colour: [u8; 3]) {
        (y..y + height).for_each(|y| (x..x + width).for_each(|x| self.set(x, y, colour)));
    }

    /// Draws another on this one, its top left corner at a place.
    pub fn paste(&mut self, [x, y]: [usize; 2], other: &Canvas) {
        for (index, colour) in other.bytes.as_chunks::<3>().0.iter().enumerate() {
            self.set(x + index % other.width.max(1), y + index / other.width.max(1), *colour);
        }
    }

    /// Writes a line of letters from its top left corner; what there is no letter for is left blank.
    pub fn text(&mut self, [x, y]: [usize; 2], text: &str, scale: usize, colour: [u8; 3]) {
        for (place, letter) in text.to_lowercase().chars().enumerate() {
            let Some((_, rows)) = LETTERS.iter().find(|(known, _)| *known == letter) else { continue };
            for (row, bits) in rows.iter().enumerate() {
                for column in (0..LETTER[0]).filter(|column| bits >> (LETTER[0] - 1 - column) & 1 == 1) {
                    let at = [x + scale * (place * STEP[0] + column), y + scale * row];
                    self.fill(at, [scale; 2], colour);
                }
            }
        }
    }

    /// Means of blocks of `factor` × `factor` pixels, in sRGB codes: for thumbnails.
    pub fn reduced(&self, factor: usize) -> Canvas {
        let factor = factor.max(1);
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        let mut out = Canvas::new(width, height, [0; 3]);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut count) = ([0u32; 3], 0u32);
                for y in y * factor..((y + 1) * factor).min(self.height) {
                    for x in x * factor..((x + 1) * factor).min(self.width) {
                        let Some(colour) = self.bytes.get(3 * (y * self.width + x)..3 * (y * self.width + x) + 3)
                        else {
                            continue;
                        };
                        sum.iter_mut().zip(colour).for_each(|(sum, code)| *sum += u32::from(*code));
                        count += 1;
                    }
                }
                out.set(x, y, sum.map(|sum| u8::try_from(sum / count.max(1)).unwrap_or(u8::MAX)));
            }
        }
        out
    }

    /// Writes a PNG, completely or not at all.
    /// Errors: a picture too large for the format, a place that cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let unencodable = |why: String| Error::new(Where::file(path), format!("cannot be encoded as PNG: {why}"));
        let side =
            |length: usize| u32::try_from(length).map_err(|_| unencodable(format!("{length} pixels wide or high")));
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes)
            .write_image(&self.bytes, side(self.width)?, side(self.height)?, ExtendedColorType::Rgb8)
            .map_err(|error| unencodable(error.to_string()))?;
        write_atomic(path, &bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_and_thumbnails() {
        let mut raster = Canvas::new(8, 6, [0; 3]);
        raster.text([0, 0], "T?", 1, [255; 3]);
        let row = |raster: &Canvas, y: usize| -> Vec<u8> {
            raster.bytes[3 * y * raster.width..].chunks(3).take(raster.width).map(|c| c[0] / 255).collect()
        };
        assert_eq!(row(&raster, 0), [1, 1, 1, 0, 0, 0, 0, 0]);
        assert_eq!(row(&raster, 4), [0, 1, 0, 0, 0, 0, 0, 0]);
        raster.text([100, 100], "off", 2, [255; 3]);
        let small = raster.reduced(4);
        assert_eq!((small.width, small.height), (2, 2));
        // 3 + 1 + 1 + 1 of 16 pixels.
        assert_eq!(small.bytes[0], (6 * 255 / 16) as u8);
        let mut known: Vec<char> = LETTERS.iter().map(|(letter, _)| *letter).collect();
        known.dedup();
        assert_eq!(known.len(), LETTERS.len());
        assert!(LETTERS.iter().all(|(_, rows)| rows.iter().all(|row| *row < 8)));
    }
}
