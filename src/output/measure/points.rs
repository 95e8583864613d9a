//! Where on a display is measured, and colours in u′, v′.

use crate::leak::patch_pixels;
use crate::solve::lit_pixels;
use eyebox_film::frame::Frame;

/// The box around the lit pixels: left, top, right and bottom, the last two exclusive.
pub fn window(white: &[f64], width: usize) -> Option<[usize; 4]> {
    let lit = lit_pixels(white);
    let places = || lit.iter().map(|pixel| (pixel % width.max(1), pixel / width.max(1)));
    let (left, right) = (places().map(|(x, _)| x).min()?, places().map(|(x, _)| x).max()?);
    let (top, bottom) = (places().map(|(_, y)| y).min()?, places().map(|(_, y)| y).max()?);
    Some([left, top, right + 1, bottom + 1])
}

/// Pixels of the nine patches at 1/6, 3/6 and 5/6 of a window's width and height; none if it is too small.
pub fn nine(frame: &Frame, [left, top, right, bottom]: [usize; 4]) -> Option<Vec<Vec<usize>>> {
    let (width, height) = (right - left, bottom - top);
    if width < 9 || height < 9 {
        return None;
    }
    let side = patch_pixels(frame).min(width / 3).min(height / 3).max(1);
    let start = |from: usize, size: usize, i: usize| (from + size * (2 * i + 1) / 6).saturating_sub(side / 2);
    let patch = |i: usize| {
        let (x, y) = (start(left, width, i % 3), start(top, height, i / 3));
        (0..side * side)
            .map(|k| (y + k / side, x + k % side))
            .filter(|(y, x)| *x < frame.width && *y < frame.height)
            .map(|(y, x)| y * frame.width + x)
            .collect()
    };
    Some((0..9).map(patch).collect())
}

/// u′, v′ of CIE 1976 (CIE 15:2004, 8.2.1); none of black.
pub fn uv([x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
    let sum = x + 15.0 * y + 3.0 * z;
    (sum > 0.0).then(|| [4.0 * x / sum, 9.0 * y / sum])
}
