use super::*;
use crate::exr::COLOR_INTEROP_ID;
use eyebox_film::frame::Meta;

fn picture(values: &[f32]) -> Frame {
    let mut frame = Frame::new(values.len(), 1);
    for name in ["R", "G", "B"] {
        frame.push(name, values.to_vec());
    }
    frame
}

fn greys(frame: &Frame, options: &ViewOptions) -> Vec<u8> {
    let (bytes, _) = render_view(frame, options).unwrap();
    bytes.as_chunks::<3>().0.iter().map(|[r, _, _]| *r).collect()
}

#[test]
fn default_tone_is_ward_at_the_mean_luminance() {
    let frame = picture(&[20.0, 40.0, 90.0]);
    let (bytes, info) = render_view(&frame, &ViewOptions::default()).unwrap();
    // The mean is 50, half of the display's 100: one to one, so 20 cd/m² is 0.2 of white, sRGB 124.
    assert!((info.adaptation_cd_m2.unwrap() - 50.0).abs() < 1e-9);
    assert!(info.exposure_stops.unwrap().abs() < 1e-9);
    assert_eq!(bytes[..3], [124; 3]);
    // A layer of the frame is adapted to the whole, not to itself.
    let mut frame = picture(&[5000.0; 4]);
    for component in ["R", "G", "B"] {
        frame.push(format!("forward.{component}"), vec![100.0, 0.0, 0.0, 0.0]);
    }
    let layer = ViewOptions { layer: Some("forward".into()), ..ViewOptions::default() };
    let (_, info) = render_view(&frame, &layer).unwrap();
    assert_eq!(info.adaptation_cd_m2, Some(5000.0));
    assert_eq!(greys(&frame, &layer)[0], srgb_code(100.0 * ward_scale(5000.0, 100.0)));
}

#[test]
fn the_reported_exposure_shows_the_same_picture() {
    let frame = picture(&[3.0, 800.0, 12_000.0, 0.0, 55.5]);
    let (auto, info) = render_view(&frame, &ViewOptions::default()).unwrap();
    let fixed = ViewOptions { exposure: info.exposure_stops, ..ViewOptions::default() };
    assert_eq!(render_view(&frame, &fixed).unwrap().0, auto);
    // An exposure is absolute: 2 stops up are a quarter of the luminance, whatever else is in the frame.
    let up = ViewOptions { exposure: Some(2.0), ..ViewOptions::default() };
    assert_eq!(
        greys(&picture(&[10.0, 7000.0]), &up)[0],
        greys(&picture(&[40.0, 0.0]), &ViewOptions { exposure: Some(0.0), ..up.clone() })[0]
    );
}

#[test]
fn colour_spaces_and_luminance_layers() {
    let neutral = |id: &str, white: [f32; 3]| {
        let mut frame = Frame::new(1, 1);
        for (name, value) in ["R", "G", "B"].iter().zip(white) {
            frame.push(*name, vec![value * 30.0]);
        }
        frame.push("stderr.Y", vec![30.0]);
        frame.meta.insert(COLOR_INTEROP_ID.into(), Meta::Text(id.into()));
        frame
    };
    let frames = [
        neutral("lin_rec709_scene", [1.0; 3]),
        neutral("lin_ap1_scene", [1.0; 3]),
        neutral("lin_ciexyzd65_scene", [0.950_456, 1.0, 1.089_058]),
    ];
    let want = srgb_code(30.0 * ward_scale(30.0, 100.0));
    for frame in &frames {
        let stderr = ViewOptions { layer: Some("stderr".into()), ..ViewOptions::default() };
        assert_eq!(render_view(frame, &ViewOptions::default()).unwrap().0, [want; 3]);
        assert_eq!(render_view(frame, &stderr).unwrap().0, [want; 3]);
    }
}

#[test]
fn data_layers_are_normalised() {
    let mut frame = picture(&[1.0; 4]);
    frame.push("Z.Z", vec![2.0, 4.0, 0.0, 3.0]);
    for (component, value) in ["X", "Y", "Z"].iter().zip([[0.28, 0.0], [0.0, 0.0], [-0.96, 0.0]]) {
        frame.push(format!("normal_seen.{component}"), vec![value[0], value[1], value[0], value[0]]);
    }
    frame.push("difference.V", vec![-2.0, 0.0, 1.0, f32::NAN]);
    for component in ["R", "G", "B"] {
        frame.push(format!("albedo.{component}"), vec![1.0, 0.5, 0.0, 0.18]);
    }
    let layer = |name: &str| ViewOptions { layer: Some(name.into()), ..ViewOptions::default() };
    assert_eq!(greys(&frame, &layer("Z")), [255, 20, 0, 138], "near is bright, a miss is black");
    assert_eq!(render_view(&frame, &layer("normal_seen")).unwrap().0[..6], [163, 128, 5, 0, 0, 0]);
    assert_eq!(greys(&frame, &layer("albedo")), [255, 188, 0, 118]);
    let (bytes, info) = render_view(&frame, &layer("difference")).unwrap();
    assert_eq!(bytes, [0, 0, 0, 128, 128, 128, 191, 191, 191, 255, 0, 255]);
    assert_eq!((info.nonfinite_pixels, info.range, info.shown), (1, Some([-2.0, 1.0]), Shown::Scalar));
    // One channel by its full name.
    assert_eq!(render_view(&frame, &layer("albedo.G")).unwrap().1.shown, Shown::Scalar);
    assert_eq!(
        [shown_by_name("eb_position"), shown_by_name("abnormal"), shown_by_name("seethrough")],
        [Shown::Vector, Shown::Picture, Shown::Fraction]
    );
}

#[test]
fn faults_name_the_layers() {
    let mut frame = picture(&[1.0]);
    frame.push("caustic.R", vec![0.0]);
    let misspelt = ViewOptions { layer: Some("caustc".into()), ..ViewOptions::default() };
    assert_eq!(
        render_view(&frame, &misspelt).unwrap_err().to_string(),
        "--layer caustc: the frame has no layer `caustc`; expected one of (default), caustic, or a channel's full name; \
         did you mean `caustic`?"
    );
    for options in [
        ViewOptions { exposure: Some(f64::NAN), ..ViewOptions::default() },
        ViewOptions { exposure: Some(1e9), ..ViewOptions::default() },
        ViewOptions { ldmax_cd_m2: 0.0, ..ViewOptions::default() },
    ] {
        assert!(render_view(&frame, &options).is_err(), "{options:?}");
    }
    frame.channels[0].data.clear();
    assert!(render_view(&frame, &ViewOptions::default()).is_err());
    assert!(render_view(&Frame::new(0, 0), &ViewOptions::default()).is_err());
}

#[test]
fn extreme_frames_are_shown_all_the_same() {
    for values in [vec![0.0; 3], vec![f32::MAX; 3], vec![f32::NAN, f32::INFINITY, -1.0], vec![f32::MIN_POSITIVE; 3]] {
        let (bytes, info) = render_view(&picture(&values), &ViewOptions::default()).unwrap();
        assert_eq!(bytes.len(), 9);
        assert!(info.exposure_stops.unwrap().is_finite(), "{values:?}");
    }
}

#[test]
fn the_png_holds_the_pixels() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("view.png");
    let frame = picture(&[0.0, 25.0, 100.0]);
    let options = ViewOptions { exposure: Some(0.0), ..ViewOptions::default() };
    write_view(&path, &frame, &options).unwrap();
    let image = image::open(&path).unwrap().into_rgb8();
    assert_eq!((image.width(), image.height()), (3, 1));
    assert_eq!(image.into_raw(), render_view(&frame, &options).unwrap().0);
    assert!(write_view(&path, &frame, &ViewOptions { layer: Some("no".into()), ..options }).is_err());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
}
