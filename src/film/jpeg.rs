//! Whether a JPEG ends before its picture does. Decoders make grey of what is missing and say nothing.

/// Start of scan, after which coded data come; end of image (ITU-T T.81, table B.1).
const START_OF_SCAN: u8 = 0xDA;
const END_OF_IMAGE: u8 = 0xD9;
/// Markers without a length: TEM and RST.
const ALONE: u8 = 0x01;
const FIRST_RESTART: u8 = 0xD0;
const LAST_RESTART: u8 = 0xD7;

/// No end after the first scan. Segments before it are stepped over by their lengths: they may hold small pictures with ends of
/// their own. In coded data an FF is followed by 00, by a restart or by a marker that counts (T.81, B.1.1.5).
pub fn is_cut_short(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some([mark, kind, high, low]) = bytes.get(at..at + 4) {
        // Fill bytes, and what stands between segments and means nothing.
        if *mark != 0xFF || matches!(*kind, 0x00 | 0xFF) {
            at += 1;
            continue;
        }
        if matches!(*kind, ALONE | FIRST_RESTART..=LAST_RESTART) {
            at += 2;
            continue;
        }
        at += 2 + usize::from(u16::from_be_bytes([*high, *low]));
        if *kind == START_OF_SCAN {
            let coded = bytes.get(at..).unwrap_or_default();
            return !coded.windows(2).any(|pair| pair == [0xFF, END_OF_IMAGE]);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn every_cut_is_told() {
        let mut bytes = Vec::new();
        let noise =
            image::RgbImage::from_fn(33, 17, |x, y| image::Rgb([(x * y * 7) as u8, (x * 31) as u8, (y * 57) as u8]));
        noise.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Jpeg).unwrap();
        assert!(!is_cut_short(&bytes));
        assert!((0..bytes.len()).all(|end| is_cut_short(&bytes[..end])));
        // A small picture within a segment has an end that is not the file's; what follows the end does not matter.
        let small = bytes.clone();
        let mut with = vec![0xFF, 0xD8, 0xFF, 0xE1];
        with.extend(((small.len() + 2) as u16).to_be_bytes());
        with.extend(&small);
        with.extend(&bytes[2..]);
        assert!(!is_cut_short(&with) && is_cut_short(&with[..with.len() - 2]));
        with.extend([0; 9]);
        assert!(!is_cut_short(&with));
        // Bytes of no meaning between the segments.
        let stray = [&bytes[..2], &[0, 7, 0xFF, 0x01], &bytes[2..]].concat();
        assert!(!is_cut_short(&stray) && is_cut_short(&stray[..stray.len() - 2]));
    }
}
