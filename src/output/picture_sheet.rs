//! Several frames side by side, each toned for its own adaptation, with captions.

use super::canvas::{Canvas, STEP};
use super::view::{ViewOptions, shown};
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::frame::Frame;

/// Pictures are no wider than this, pixels.
const WIDEST: usize = 480;
/// Between pictures, pixels.
const GAP: usize = 6;
/// Size of the letters, and lines of a caption at most.
const LETTER: usize = 2;
const MOST_LINES: usize = 6;
/// Most pixels of a sheet.
const MOST_PIXELS: usize = 1 << 28;

/// Frames as `eyebox view` shows each alone, in rows of `columns`, with a caption under each; a caption's lines are broken
/// at spaces.
///
/// Errors: those of showing a frame; no frames, or too many for one sheet.
pub fn picture_sheet(frames: &[(Frame, String)], columns: usize, options: &ViewOptions) -> Result<Canvas> {
    let mut cells = Vec::with_capacity(frames.len());
    for (frame, caption) in frames {
        let (picture, _) = shown(frame, options)?;
        cells.push((picture.reduced(picture.width.div_ceil(WIDEST).max(1)), caption));
    }
    let width = cells.iter().map(|(picture, _)| picture.width).max().unwrap_or(0).max(8 * STEP[0] * LETTER);
    let captions: Vec<Vec<String>> = cells.iter().map(|(_, text)| lines(text, width / (LETTER * STEP[0]))).collect();
    let columns = columns.clamp(1, cells.len().max(1));
    // Rows are as high as their highest cell.
    let heights: Vec<usize> = cells
        .chunks(columns)
        .zip(captions.chunks(columns))
        .map(|(cells, captions)| {
            let picture = cells.iter().map(|(picture, _)| picture.height).max().unwrap_or(0);
            let text = captions.iter().map(Vec::len).max().unwrap_or(0);
            picture + text * (LETTER * STEP[1] + 2) + 2 * GAP
        })
        .collect();
    let size = [columns.saturating_mul(width + GAP) + GAP, heights.iter().sum::<usize>() + GAP];
    if cells.is_empty() || size[0].saturating_mul(size[1]) > MOST_PIXELS {
        let what = format!("{} pictures make a sheet of {} × {} pixels", cells.len(), size[0], size[1]);
        return Err(Error::new(Where::Nowhere, what).expected(format!("1 to {MOST_PIXELS} pixels")));
    }
    let mut sheet = Canvas::new(size[0], size[1], [24; 3]);
    let mut top = GAP;
    for (row, height) in heights.iter().enumerate() {
        let place = row * columns;
        for (column, ((picture, _), caption)) in cells.iter().zip(&captions).skip(place).take(columns).enumerate() {
            let left = GAP + column * (width + GAP);
            sheet.paste([left, top], picture);
            for (line, text) in caption.iter().enumerate() {
                let at = [left, top + picture.height + 4 + line * (LETTER * STEP[1] + 2)];
                sheet.text(at, text, LETTER, [230; 3]);
            }
        }
        top += height;
    }
    Ok(sheet)
}

/// A caption in lines of at most `most` letters.
fn lines(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let word: String = word.chars().take(most).collect();
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= most => {
                line.push(' ');
                line.push_str(&word);
            }
            Some(_) | None => lines.push(word),
        }
    }
    lines.truncate(MOST_LINES);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captions_break_at_spaces() {
        assert_eq!(lines("a figure of two words", 8), ["a figure", "of two", "words"]);
        assert_eq!(lines("", 8), Vec::<String>::new());
        assert_eq!(lines("unbreakable", 4), ["unbr"]);
    }

    #[test]
    fn every_frame_has_its_own_tone() {
        let frame = |value: f32| {
            let mut frame = Frame::new(60, 10);
            ["R", "G", "B"].iter().for_each(|c| frame.push(*c, vec![value; 600]));
            frame
        };
        let frames = [(frame(50.0), "a".to_owned()), (frame(5000.0), String::new()), (frame(50.0), String::new())];
        let sheet = picture_sheet(&frames, 2, &ViewOptions::default()).unwrap();
        let at = |x: usize, y: usize| sheet.bytes[3 * (y * sheet.width + x)];
        assert_eq!(sheet.width, 2 * 70 + 6);
        // Toned for itself 50 cd/m² is a linear ½ of a display of 100; the brighter frame is not white either.
        assert_eq!(at(10, 10), 188);
        assert!(at(80, 10) > 188 && at(80, 10) < 255, "{}", at(80, 10));
        let second = sheet.height - 10 - 2 * GAP;
        assert_eq!(at(10, second), 188);
        // At one exposure of a display of 100 cd/m² the bright one is white.
        let same = ViewOptions { exposure: Some(0.0), ..ViewOptions::default() };
        let sheet = picture_sheet(&frames, 2, &same).unwrap();
        assert_eq!(sheet.bytes[3 * (10 * sheet.width + 80)], 255);
        assert!(picture_sheet(&[], 2, &same).is_err());
    }
}
