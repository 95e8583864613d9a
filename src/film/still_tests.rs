//! Windows and colours of files that another library wrote.

use super::*;
use ::exr::prelude::*;

/// An EXR whose data begin at `start` and have these reds, row by row; green and blue are 0.
fn file(data: [usize; 2], start: [i32; 2], display: ([i32; 2], [usize; 2]), reds: &[f32], chroma: bool) -> Vec<u8> {
    let at = |values: Vec<f32>, name: &str| AnyChannel::new(name, FlatSamples::F32(values));
    let zero = vec![0.0; reds.len()];
    let channels = [at(reds.to_vec(), "R"), at(zero.clone(), "G"), at(zero, "B")];
    let mut layer = Layer::new(
        (data[0], data[1]),
        LayerAttributes { layer_position: Vec2(start[0], start[1]), ..LayerAttributes::default() },
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    layer.attributes.layer_name = None;
    let ([left, top], [width, height]) = display;
    let window = IntegerBounds::new((left, top), (width, height));
    let mut image = Image::new(ImageAttributes::new(window), layer);
    // SMPTE ST 2065-1: the primaries of ACES2065-1.
    image.attributes.chromaticities = chroma.then_some(attribute::Chromaticities {
        red: Vec2(0.7347, 0.2653),
        green: Vec2(0.0, 1.0),
        blue: Vec2(0.0001, -0.077),
        white: Vec2(0.32168, 0.33767),
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).expect("written");
    bytes.into_inner()
}

fn reds(still: &Still) -> Vec<f32> {
    match &still.light {
        Light::Grey(values) => values.clone(),
        Light::Rgb(values) => values.iter().map(|rgb| rgb[0]).collect(),
    }
}

/// A crop of 2 × 1 pixels in a picture of 4 × 2: black around it, and it is said.
#[test]
fn a_crop_stands_where_it_was_cut() {
    let still = Still::of_exr(&file([2, 1], [1, 1], ([0, 0], [4, 2]), &[5.0, 7.0], false), None).expect("a picture");
    assert_eq!((still.width, still.height), (4, 2));
    assert_eq!(reds(&still), [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 7.0, 0.0]);
    let [remark] = still.remarks.as_slice() else { panic!("{:?}", still.remarks) };
    assert!(remark.warns && remark.text.contains("black where there are none"), "{remark:?}");
}

/// Overscan is cut off, wherever the display window begins.
#[test]
fn overscan_is_cut_off() {
    let all: Vec<f32> = (0..12).map(|value| value as f32).collect();
    for corner in [[0, 0], [-7, 3], [1000, -20]] {
        let start = [corner[0] - 1, corner[1] - 1];
        let still = Still::of_exr(&file([4, 3], start, (corner, [2, 1]), &all, false), None).expect("a picture");
        assert_eq!((still.width, still.height, reds(&still)), (2, 1, vec![5.0, 6.0]), "{corner:?}");
        let [remark] = still.remarks.as_slice() else { panic!("{:?}", still.remarks) };
        assert!(!remark.warns && remark.text.contains("the overscan is cut off"), "{remark:?}");
    }
}

/// A crop that hangs over one side of the display window.
#[test]
fn what_hangs_over_is_half_there() {
    let still = Still::of_exr(&file([2, 1], [-1, 0], ([0, 0], [2, 1]), &[5.0, 7.0], false), None).expect("a picture");
    assert_eq!((reds(&still), still.remarks[0].warns), (vec![7.0, 0.0], true));
}

/// A window of a million pixels a side around one pixel is a broken header.
#[test]
fn windows_without_measure_are_refused() {
    let huge = file([1, 1], [0, 0], ([0, 0], [1_000_000, 1_000_000]), &[1.0], false);
    assert!(Still::of_exr(&huge, None).is_err_and(|what| what.contains("1000000 × 1000000")));
}

/// The red of ACES2065-1 in linear Rec.709, as OpenColorIO's ACES configuration has it (Bradford adaptation).
#[test]
fn chromaticities_count() {
    let still = Still::of_exr(&file([1, 1], [0, 0], ([0, 0], [1, 1]), &[1.0], true), None).expect("a picture");
    let Light::Rgb(light) = &still.light else { panic!("colours") };
    for (got, want) in light[0].iter().zip([2.521_686, -0.276_480, -0.015_378]) {
        assert!((got - want).abs() < 1e-5, "{light:?}");
    }
    assert!(still.remarks.iter().any(|remark| remark.text.contains("`chromaticities`")), "{:?}", still.remarks);
}

/// A picture of linear values is not read as if it were encoded, and what is cut off is no picture.
#[test]
fn only_what_is_encoded_is_taken_as_srgb() {
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81";
    assert_eq!(Still::of_srgb(hdr), Err("it is hdr".to_owned()));
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_raw(1, 1, vec![188, 255, 0]).unwrap().write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let Light::Rgb(light) = Still::of_srgb(&png).expect("a PNG").light else { panic!("colours") };
    // IEC 61966-2-1: 188/255 is 0.502886 of white.
    assert!((light[0][0] - 0.502_886).abs() < 1e-5 && light[0][1..] == [1.0, 0.0], "{light:?}");
    assert!((0..png.len() - 12).all(|length| Still::of_srgb(&png[..length]).is_err()));
}

/// A file with the channels BY, RY, Y of this sample type, whose chroma has a sample for 2 × 2 pixels: blocks of so many rows
/// with these bytes (OpenEXR file layout).
fn luminance_chroma_file(
    [width, height]: [i32; 2],
    (compression, sample): (u8, i32),
    rows: i32,
    blocks: &[Vec<u8>],
) -> Vec<u8> {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut put = |name: &str, kind: &str, value: &[u8]| {
        file.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
        file.extend((value.len() as i32).to_le_bytes());
        file.extend(value);
    };
    let numbers = |all: &[i32]| all.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let mut channels = Vec::new();
    for (name, step) in [("BY", 2), ("RY", 2), ("Y", 1)] {
        channels.extend(name.bytes().chain([0]));
        channels.extend(numbers(&[sample, 0, step, step]));
    }
    channels.push(0);
    put("channels", "chlist", &channels);
    put("compression", "compression", &[compression]);
    let window = numbers(&[0, 0, width - 1, height - 1]);
    put("dataWindow", "box2i", &window);
    put("displayWindow", "box2i", &window);
    put("lineOrder", "lineOrder", &[0]);
    put("pixelAspectRatio", "float", &1f32.to_le_bytes());
    put("screenWindowCenter", "v2f", &[0; 8]);
    put("screenWindowWidth", "float", &1f32.to_le_bytes());
    file.push(0);
    let chunk = |(row, data): (i32, &Vec<u8>)| [numbers(&[row, data.len() as i32]), data.clone()].concat();
    let chunks: Vec<Vec<u8>> = (0..).step_by(rows as usize).zip(blocks).map(chunk).collect();
    let mut offset = file.len() + 8 * chunks.len();
    for chunk in &chunks {
        file.extend((offset as u64).to_le_bytes());
        offset += chunk.len();
    }
    chunks.iter().for_each(|chunk| file.extend(chunk));
    file
}

/// The same in B44 compression: chroma without a hue, of one cell a channel, and luminances in four cells; one of them has
/// steps from sample to sample, and ten rows need a second one below it, cut at the edge.
#[test]
fn luminance_and_chroma_in_b44() {
    // Half floats: 0x3c00 is 1, the next ones 1/1024 apart.
    let alike = |bits: u16| [(bits | 0x8000).to_be_bytes().to_vec(), vec![0xfc]].concat();
    // Along each row 0, 1, 2, 3 steps up: the first column as it is, each next difference 1 over the bias of 32.
    let steps: [u8; 14] = {
        let (down, across) = (0x20u32, 0x21u32);
        let head = [0xbc, 0x00, (down >> 4) as u8, (down << 4 | down >> 2) as u8, (down << 6 | down) as u8];
        let three =
            [(across << 2 | across >> 4) as u8, (across << 4 | across >> 2) as u8, (across << 6 | across) as u8];
        [&head[..], &three, &three, &three].concat().try_into().expect("14 bytes")
    };
    let none = [0x80, 0x00, 0xfc].to_vec();
    let lower = [alike(0x3800), alike(0x3400)].concat();
    // Chroma has 4 × 5 samples of 8 × 10 pixels: two cells a channel.
    let block = [none.clone(), none.clone(), none.clone(), none.clone(), steps.to_vec(), alike(0x4000)].concat();
    let block = [block, lower.clone(), lower].concat();
    let file = luminance_chroma_file([8, 10], (6, 1), 32, &[block]);
    let still = Still::of_exr(&file, None).expect("a picture");
    let Light::Rgb(pixels) = &still.light else { panic!("it has colours") };
    for (index, pixel) in pixels.iter().enumerate() {
        let (x, y) = (index % 8, index / 8);
        let want = match (x < 4, y < 4) {
            (true, true) => 1.0 + x as f32 / 1024.0,
            (false, true) => 2.0,
            (true, false) => 0.5,
            (false, false) => 0.25,
        };
        assert!(pixel.iter().all(|lane| (lane - want).abs() < 1e-6), "{x} {y}: {pixel:?} for {want}");
    }
    assert!((0..file.len()).all(|length| Still::of_exr(&file[..length], None).is_err()));
}

/// A file of luminance and chroma as the format's description has it, not compressed: BY and RY have a sample for 2 × 2 pixels,
/// odd lines have none of them. The chroma is that of (1, 0.5, 0.25) everywhere, the luminance doubles from pixel to pixel.
#[test]
fn luminance_and_chroma() {
    const COLOUR: [f32; 3] = [1.0, 0.5, 0.25];
    // IEC 61966-2-1.
    let y = 0.2126 * COLOUR[0] + 0.7152 * COLOUR[1] + 0.0722 * COLOUR[2];
    let (width, height) = (4i32, 4i32);
    let lines: Vec<Vec<u8>> = (0..height)
        .map(|row| {
            let mut samples = Vec::new();
            if row % 2 == 0 {
                samples.extend([(COLOUR[2] - y) / y; 2]);
                samples.extend([(COLOUR[0] - y) / y; 2]);
            }
            samples.extend((0..width).map(|column| y * 2f32.powi(column + row)));
            samples.iter().flat_map(|sample| sample.to_le_bytes()).collect()
        })
        .collect();
    let mut file = luminance_chroma_file([width, height], (0, 2), 1, &lines);
    let still = Still::of_exr(&file, None).expect("a picture");
    let Light::Rgb(pixels) = &still.light else { panic!("it has colours") };
    for (index, pixel) in pixels.iter().enumerate() {
        let scale = 2f32.powi((index % 4 + index / 4) as i32);
        for (found, want) in pixel.iter().zip(COLOUR) {
            assert!((found / scale - want).abs() < 1e-4, "{index}: {pixel:?}");
        }
    }
    // A sampling of 0 is no reason to stumble.
    let at = file.windows(4).position(|four| four == [b'B', b'Y', 0, 2]).expect("the channel") + 11;
    file[at..at + 4].fill(0);
    assert!(Still::of_exr(&file, None).is_err());
}

/// A few bytes can be zeros for ever: what they claim is looked at before they are unpacked.
#[test]
fn sizes_that_no_picture_has() {
    let small = file([4, 2], [0, 0], ([0, 0], [4, 2]), &[0.0; 8], false);
    let window = |right: i32, bottom: i32| [0, 0, right, bottom].map(i32::to_le_bytes).concat();
    let claims = |right: i32, bottom: i32| {
        let mut bytes = small.clone();
        let starts: Vec<usize> = (0..bytes.len() - 16).filter(|at| bytes[*at..*at + 16] == window(3, 1)).collect();
        assert_eq!(starts.len(), 2);
        starts.iter().for_each(|at| bytes[*at..*at + 16].copy_from_slice(&window(right, bottom)));
        Still::of_exr(&bytes, None)
    };
    assert!(claims(3, 1).is_ok());
    assert_eq!(claims(20_000, 9_999), Err("it claims 20001 × 10000 pixels, more than a picture may have".to_owned()));
    assert!(claims(11, 1).is_err());
}
