//! A part of a picture: what is rendered of it, and where that lies in the whole.

use super::frame::{Frame, Samples};

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Crop {
    /// Of its first column and row in the picture.
    pub corner: [usize; 2],
    /// Width and height, at least 1.
    pub size: [usize; 2],
}

/// Where a frame lies in the picture that it is a part of: EXR's data window in its display window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Of the frame's top left pixel in the picture.
    pub corner: [i32; 2],
    /// Width and height of the picture.
    pub picture: [usize; 2],
}

impl Crop {
    /// `X,Y,WxH`: column and row of the top left pixel, counted from 0, width and height.
    pub fn parse(text: &str) -> Result<Crop, String> {
        let bad = || {
            format!("`{text}` is no part of a picture; write X,Y,WxH in pixels from the top left, e.g. 120,80,64x48")
        };
        let mut words = text.splitn(3, ',').map(str::trim);
        let (Some(x), Some(y), Some(size)) = (words.next(), words.next(), words.next()) else { return Err(bad()) };
        let (width, height) = size.split_once(['x', 'X', '×']).ok_or_else(bad)?;
        let number = |word: &str| word.trim().parse::<usize>().map_err(|_| bad());
        let crop = Crop { corner: [number(x)?, number(y)?], size: [number(width)?, number(height)?] };
        if crop.size.contains(&0) { Err(bad()) } else { Ok(crop) }
    }

    pub fn holds(&self, [x, y]: [usize; 2]) -> bool {
        let along = |at: usize, c: usize| at.checked_sub(self.corner[c]).is_some_and(|off| off < self.size[c]);
        along(x, 0) && along(y, 1)
    }

    /// Whether all of it lies in a picture of this size.
    pub fn fits(&self, size: [usize; 2]) -> bool {
        (0..2).all(|c| self.corner[c].checked_add(self.size[c]).is_some_and(|end| end <= size[c]))
    }

    /// Leaves of a whole picture this part. What is no picture of that size stays.
    pub fn cut(&self, frame: &mut Frame) {
        let (width, height) = (frame.width, frame.height);
        let [Ok(left), Ok(top)] = self.corner.map(i32::try_from) else { return };
        if !self.fits([width, height]) {
            return;
        }
        for channel in frame.channels.iter_mut().filter(|channel| channel.data.len() == width * height) {
            let rows = channel.data.chunks(width).skip(self.corner[1]).take(self.size[1]);
            let kept: Samples = rows.flat_map(|row| &row[self.corner[0]..][..self.size[0]]).copied().collect();
            channel.data = kept;
        }
        [frame.width, frame.height] = self.size;
        frame.window = Some(Window { corner: [left, top], picture: [width, height] });
    }
}

impl std::fmt::Display for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([x, y], [width, height]) = (self.corner, self.size);
        write!(f, "{x},{y},{width}x{height}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn said_and_read_back() {
        let crop = Crop::parse("12, 3,64x48").unwrap();
        assert_eq!((crop, crop.to_string().as_str()), (Crop { corner: [12, 3], size: [64, 48] }, "12,3,64x48"));
        for bad in ["", "1,2", "1,2,3", "1,2,0x4", "-1,2,3x4", "1,2,3x4,5", "a,b,cxd"] {
            assert!(Crop::parse(bad).is_err(), "{bad}");
        }
        assert!(crop.fits([76, 51]) && !crop.fits([75, 51]) && !crop.fits([76, 50]));
        assert!(!Crop { corner: [usize::MAX, 0], size: [1, 1] }.fits([4, 4]));
        assert!(crop.holds([12, 3]) && crop.holds([75, 50]) && !crop.holds([76, 50]) && !crop.holds([11, 3]));
    }

    #[test]
    fn a_part_is_cut_out() {
        let mut frame = Frame::new(4, 3);
        frame.push("R", (0..12).map(|i| i as f32).collect());
        Crop { corner: [1, 1], size: [2, 2] }.cut(&mut frame);
        assert_eq!((frame.width, frame.height), (2, 2));
        assert_eq!(frame.channels[0].data, [5.0, 6.0, 9.0, 10.0]);
        assert_eq!(frame.window, Some(Window { corner: [1, 1], picture: [4, 3] }));
    }
}
