//! All layers of a frame side by side, each with its name.

use super::canvas::{Canvas, STEP};
use super::view::{ViewOptions, shown};
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::frame::Frame;
use std::path::Path;

/// Thumbnails are no wider than this, pixels.
const WIDEST: usize = 320;
/// Between thumbnails, pixels.
const GAP: usize = 6;
/// Size of the letters.
const LETTER: usize = 2;

/// Every layer as `eyebox view` shows it, reduced: pictures with one exposure, so that they can be compared. The layer of the
/// options has no part in it.
///
/// Errors: those of showing a layer; a frame without layers.
pub fn contact_sheet(frame: &Frame, options: &ViewOptions) -> Result<Canvas> {
    // False colours have a scale per picture, and their legends would not be read at this size.
    let plain = ViewOptions { false_colour: false, layer: None, ..options.clone() };
    let lone = |name: &&str| !name.contains('.') && !["R", "G", "B"].contains(name);
    let channels = frame.channels.iter().map(|channel| channel.name.as_str()).filter(lone);
    let layers = frame.layer_names().into_iter().filter(|layer| !layer.is_empty() || frame.rgb("").is_some());
    let names: Vec<&str> = layers.chain(channels).collect();
    let (count, factor) = (names.len(), frame.width.div_ceil(WIDEST).max(1));
    if count == 0 {
        return Err(Error::new(Where::Nowhere, "the frame has no layer to show"));
    }
    let cell = [
        frame.width.div_ceil(factor).max(8 * LETTER * STEP[0]) + GAP,
        frame.height.div_ceil(factor) + LETTER * STEP[1] + GAP,
    ];
    // About as wide as high.
    let columns = ((count * cell[1]) as f64 / cell[0] as f64).sqrt().ceil().max(1.0) as usize;
    let columns = columns.min(count);
    let rows = count.div_ceil(columns);
    let mut sheet = Canvas::new(columns * cell[0] + GAP, rows * cell[1] + GAP, [24; 3]);
    for (index, name) in names.into_iter().enumerate() {
        let corner = [GAP + index % columns * cell[0], GAP + index / columns * cell[1]];
        let (picture, _) = shown(frame, &ViewOptions { layer: Some(name.to_owned()), ..plain.clone() })?;
        sheet.paste(corner, &picture.reduced(factor));
        let label = if name.is_empty() { "default" } else { name };
        let fits = (cell[0] - GAP) / (LETTER * STEP[0]);
        let scale = if label.chars().count() > fits { 1 } else { LETTER };
        let at = [corner[0], corner[1] + picture.height.div_ceil(factor) + 2];
        let label: String = label.chars().take((cell[0] - GAP) / (scale * STEP[0])).collect();
        sheet.text(at, &label, scale, [230; 3]);
    }
    Ok(sheet)
}

/// Writes the sheet as a PNG; returns how many pixels it has.
/// Errors: those of [`contact_sheet`], and a place that cannot be written.
pub fn write_contact_sheet(path: &Path, frame: &Frame, options: &ViewOptions) -> Result<[usize; 2]> {
    let sheet = contact_sheet(frame, options)?;
    sheet.write_png(path)?;
    Ok([sheet.width, sheet.height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layer_has_its_place() {
        let mut frame = Frame::new(40, 20);
        for (layer, value) in [("", 50.0), ("caustic.", 100.0), ("stderr.", 0.0)] {
            ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}{c}"), vec![value; 800]));
        }
        frame.push("Z", vec![1.0; 800]);
        let sheet = contact_sheet(&frame, &ViewOptions { false_colour: true, ..ViewOptions::default() }).unwrap();
        // Four cells of (8·8 + 6) × (20 + 14 + 6): two columns.
        assert_eq!([sheet.width, sheet.height], [2 * 70 + 6, 2 * 40 + 6]);
        let at = |x: usize, y: usize| sheet.bytes[3 * (y * sheet.width + x)];
        // Adapted to 50 cd/m² of a display of 100: linear ½ and 1; no error is black; the nearest depth is white.
        assert_eq!([at(8, 8), at(78, 8), at(8, 48), at(78, 48)], [188, 255, 0, 255]);
        assert!(contact_sheet(&Frame::new(2, 2), &ViewOptions::default()).is_err());
    }
}
