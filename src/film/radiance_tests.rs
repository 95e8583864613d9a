//! Headers, runs and orientations by their definitions.

use super::*;

/// 250/256 · 2⁹ = 500.
const TEXEL: [u8; 4] = [250, 250, 250, 137];

fn file(head: &str, size: &str, texels: &[u8]) -> Vec<u8> {
    [format!("{head}\n\n{size}\n").as_bytes(), texels].concat()
}

fn rgb(bytes: &[u8]) -> Vec<[f32; 3]> {
    match Still::of_radiance(bytes).expect("a picture").light {
        Light::Rgb(rgb) => rgb,
        Light::Grey(_) => panic!("it has colours"),
    }
}

const FORMAT: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe";

/// A file says what its values were multiplied by, line by line: 500 at EXPOSURE=5 is 100, and twice that is 20.
#[test]
fn what_multiplied_the_values_is_divided_out() {
    let of = |more: &str| rgb(&file(&format!("{FORMAT}{more}"), "-Y 1 +X 1", &TEXEL))[0];
    assert_eq!(of(""), [500.0; 3]);
    assert_eq!(of("\nEXPOSURE=5"), [100.0; 3]);
    assert_eq!(of("\nEXPOSURE= 5.0\npfilt -1\nEXPOSURE=5"), [20.0; 3]);
    assert_eq!(of("\nCOLORCORR=1 2 4\nEXPOSURE=0.5"), [1000.0, 500.0, 250.0]);
    let still = Still::of_radiance(&file(&format!("{FORMAT}\nEXPOSURE=5"), "-Y 1 +X 1", &TEXEL)).unwrap();
    assert!(still.remarks[0].text.contains("multiplied by 5"), "{:?}", still.remarks);
}

/// Other programs' names, ends of lines, XYZ and primaries. Luminance is Y, and that of green of Rec.2020 0.678.
#[test]
fn variants_of_the_header() {
    for head in ["#?RGBE\nFORMAT=32-bit_rle_rgbe", "#?RADIANCE", "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r"] {
        let crlf = file(head, "-Y 1 +X 1", &TEXEL);
        let crlf = if head.contains('\r') { [b"#?X\r\n\r\n-Y 1 +X 1\r\n", &TEXEL[..]].concat() } else { crlf };
        assert_eq!(rgb(&crlf), [[500.0; 3]], "{head:?}");
    }
    let luminance = |rgb: [f32; 3]| eyebox_base::colour::luminance(rgb.map(f64::from));
    let xyz = rgb(&file("#?RADIANCE\nFORMAT=32-bit_rle_xyze", "-Y 1 +X 1", &[64, 128, 32, 137]));
    assert!((luminance(xyz[0]) / 256.0 - 1.0).abs() < 1e-6, "{xyz:?}");
    let wide = "PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290";
    let green = rgb(&file(&format!("{FORMAT}\n{wide}"), "-Y 1 +X 1", &[0, 128, 0, 129]));
    assert!((luminance(green[0]) - 0.677_998).abs() < 2e-5, "{green:?}");
}

/// Six texels 1 to 6 in eight orientations are the same picture of 3 × 2 when they are put so.
#[test]
fn all_orientations() {
    for (size, order) in [
        ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
        ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
        ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
        ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
        ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
        ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
        ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
    ] {
        let texels: Vec<u8> = order.iter().flat_map(|value| [*value, 0, 0, 136]).collect();
        let read = rgb(&file(FORMAT, size, &texels));
        assert_eq!(read.iter().map(|rgb| rgb[0]).collect::<Vec<_>>(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{size}");
    }
}

#[test]
fn both_kinds_of_runs() {
    // Four texels, 300 times the last: (1, 1, 1, 44) and (1, 1, 1, 1) are 44 + 256.
    let older = [[8, 8, 8, 136].as_slice(), &[1, 1, 1, 44], &[1, 1, 1, 1], &[2, 3, 4, 136]].concat();
    let read = rgb(&file(FORMAT, "-Y 1 +X 302", &older));
    assert_eq!((read[0], read[300], read[301]), ([8.0; 3], [8.0; 3], [2.0, 3.0, 4.0]));
    // Ten texels of the newer kind: runs, and plain bytes.
    let plain = [10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10];
    let newer = [&[2, 2, 0, 10][..], &plain, &[138, 7], &[128 + 4, 1, 6, 2, 2, 2, 2, 2, 2], &[138, 136]].concat();
    let read = rgb(&file(FORMAT, "-Y 1 +X 10", &newer));
    assert_eq!((read[0], read[9]), ([1.0, 7.0, 1.0], [10.0, 7.0, 2.0]));
}

/// No prefix of a file and no damage ends in anything but a line.
#[test]
fn damage_is_one_line() {
    let whole = file(FORMAT, "-Y 2 +X 10", &[&[2, 2, 0, 10, 138, 7, 138, 7, 138, 7, 138, 136][..]; 2].concat());
    assert_eq!(rgb(&whole).len(), 20);
    for length in 0..whole.len() {
        let fault = Still::of_radiance(&whole[..length]).expect_err("it is cut");
        assert!(!fault.contains('\n') && fault.contains("ends"), "{length}: {fault}");
    }
    for at in 0..whole.len() {
        for byte in [0, 1, 2, 127, 128, 129, 255] {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            let _ = Still::of_radiance(&bytes);
        }
    }
    let said = |head: &str, size: &str| Still::of_radiance(&file(head, size, &TEXEL)).unwrap_err();
    assert!(said(&format!("{FORMAT}\nEXPOSURE=0"), "-Y 1 +X 1").contains("its EXPOSURE is 0; expected 1 above 0"));
    assert!(said(&format!("{FORMAT}\nPRIMARIES=1 2"), "-Y 1 +X 1").contains("its PRIMARIES are 1 2; expected x and y"));
    assert!(said("#?X\nFORMAT=8-bit", "-Y 1 +X 1").contains("expected 32-bit_rle_rgbe"));
    assert!(said(FORMAT, "-Y 60000 +X 50000").contains("claims 50000 × 60000 pixels"));
    assert!(said(FORMAT, "1 by 1").contains("its size is `1 by 1`"));
    assert!(said(FORMAT, "-Y 0 +X 0").contains("no pixels"));
}
