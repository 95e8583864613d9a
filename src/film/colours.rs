//! How the numbers of a frame's pictures are to be read, for every reader: by its `colorInteropID`, else by its `chromaticities`,
//! else as linear Rec.709, as EXR has it.

use super::frame::{Frame, Meta};
use eyebox_base::colour::{Chromaticities, ColourSpace, FileSpace, Rgb, Xyz};

/// The attribute that names the colour space of the pictures.
pub const COLOR_INTEROP_ID: &str = "colorInteropID";
/// Its primaries and white, as eight numbers in words: kept in the metadata where no known `colorInteropID` says them.
pub const CHROMATICITIES: &str = "chromaticities";

/// The space of a frame's pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colours {
    /// One that we write.
    Own(ColourSpace),
    /// Of another program.
    Foreign(FileSpace),
}

impl Colours {
    /// As the frame's header says.
    pub fn of(frame: &Frame) -> Colours {
        let space = file_space(frame);
        own(space).map_or(Colours::Foreign(space), Colours::Own)
    }

    /// Linear Rec.709 of three stored values.
    pub fn to_rec709(self, stored: Rgb) -> Rgb {
        match self {
            Colours::Own(space) => space.to_rec709(stored),
            Colours::Foreign(space) => space.to_rec709(stored),
        }
    }

    /// CIE XYZ of three stored values, white that of D65.
    pub fn to_xyz(self, stored: Rgb) -> Xyz {
        match self {
            Colours::Own(space) => space.to_xyz(stored),
            Colours::Foreign(space) => ColourSpace::Rec709.to_xyz(space.to_rec709(stored)),
        }
    }

    /// The luminance of three stored values; that of white is 1.
    pub fn luminance(self, stored: Rgb) -> f64 {
        match self {
            Colours::Own(space) => space.luminance(stored),
            Colours::Foreign(space) => eyebox_base::colour::luminance(space.to_rec709(stored)),
        }
    }

    /// What a header calls it.
    pub fn name(self, frame: &Frame) -> String {
        match (self, frame.text(COLOR_INTEROP_ID), frame.text(CHROMATICITIES)) {
            (Colours::Own(space), _, _) => space.interop_id().to_owned(),
            (Colours::Foreign(_), Some(id), _) if FileSpace::of_interop_id(id).is_some() => id.to_owned(),
            (Colours::Foreign(_), _, Some(own)) => format!("{CHROMATICITIES} {own}"),
            (Colours::Foreign(_), _, None) => "an unknown one".to_owned(),
        }
    }
}

/// How a file's numbers become linear Rec.709.
pub(super) fn file_space(frame: &Frame) -> FileSpace {
    let named = frame.text(COLOR_INTEROP_ID).and_then(FileSpace::of_interop_id);
    let space = named.or_else(|| kept(frame).and_then(|own| FileSpace::linear(&own)));
    space.unwrap_or(FileSpace::LINEAR_REC709)
}

/// Which of the spaces that we write it is.
fn own(space: FileSpace) -> Option<ColourSpace> {
    ColourSpace::ALL.into_iter().find(|own| FileSpace::linear(own.chromaticities()) == Some(space))
}

/// Primaries and white, for the header of a frame.
pub fn chromaticities(frame: &Frame) -> Option<Chromaticities> {
    match Colours::of(frame) {
        Colours::Own(space) => Some(*space.chromaticities()),
        Colours::Foreign(_) => kept(frame),
    }
}

/// Keeps what a file says of its primaries where that tells more than its `colorInteropID`.
pub(super) fn keep(frame: &mut Frame, primaries: &Chromaticities) {
    let named = frame.text(COLOR_INTEROP_ID).and_then(FileSpace::of_interop_id);
    if named.and_then(own).is_some() || FileSpace::linear(primaries) == Some(FileSpace::LINEAR_REC709) {
        return;
    }
    let words: Vec<String> = primaries.iter().flatten().map(|x| ((x * 1e7).round() / 1e7).to_string()).collect();
    frame.meta.insert(CHROMATICITIES.to_owned(), Meta::Text(words.join(" ")));
}

fn kept(frame: &Frame) -> Option<Chromaticities> {
    let numbers = frame.text(CHROMATICITIES)?.split(' ').map(|word| word.parse::<f64>().ok());
    let numbers: Vec<f64> = numbers.collect::<Option<_>>()?;
    let (pairs, []) = numbers.as_chunks::<2>() else { return None };
    <Chromaticities>::try_from(pairs).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(id: Option<&str>, own: Option<&Chromaticities>) -> Frame {
        let mut frame = Frame::new(1, 1);
        if let Some(id) = id {
            frame.meta.insert(COLOR_INTEROP_ID.to_owned(), Meta::Text(id.to_owned()));
        }
        if let Some(own) = own {
            keep(&mut frame, own);
        }
        frame
    }

    /// A name goes before primaries, primaries before nothing, and rounded ones are those that they are rounded from.
    #[test]
    fn every_reader_asks_here() {
        use eyebox_base::colour::{AP1, REC709};
        let single = AP1.map(|pair| pair.map(|x| f64::from(x as f32)));
        assert_eq!(Colours::of(&frame(None, Some(&single))), Colours::Own(ColourSpace::AcesCg));
        assert_eq!(Colours::of(&frame(Some("lin_rec709_scene"), Some(&AP1))), Colours::Own(ColourSpace::Rec709));
        assert_eq!(Colours::of(&frame(Some("unheard"), Some(&AP1))), Colours::Own(ColourSpace::AcesCg));
        assert_eq!(Colours::of(&frame(None, None)), Colours::Own(ColourSpace::Rec709));
        assert_eq!(Colours::of(&frame(None, Some(&REC709))), Colours::Own(ColourSpace::Rec709));
        assert_eq!(Colours::of(&frame(None, Some(&[[0.3; 2]; 4]))), Colours::Own(ColourSpace::Rec709));
        // The oracle's matrix from AP0 to Rec.709 by Bradford's transform (ACES, `ACES2065-1 to linear Rec.709`), first column.
        let ap0 = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]];
        let found = Colours::of(&frame(None, Some(&ap0)));
        assert_eq!(found, Colours::of(&frame(Some("lin_ap0_scene"), None)));
        assert!((found.luminance([1.0; 3]) - 1.0).abs() < 1e-12);
        let red = eyebox_base::colour::luminance([2.521_686, -0.276_480, -0.015_378]);
        assert!((found.luminance([1.0, 0.0, 0.0]) - red).abs() < 1e-5, "{}", found.luminance([1.0, 0.0, 0.0]));
        assert_eq!(chromaticities(&frame(None, Some(&ap0))), Some(ap0));
    }
}
