use super::*;
use crate::exr::{COLOR_INTEROP_ID, WHITE_LUMINANCE};
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::frame::Meta;

const WIDTH: usize = 32;
const HEIGHT: usize = 32;

/// A frame whose pixels are means of `passes` normal samples about `mean` with the standard deviation `sigma`, with the
/// errors that these samples show.
fn sampled(seed: u64, mean: impl Fn(usize) -> f64, sigma: f64, passes: usize) -> Frame {
    let mut frame = Frame::new(WIDTH, HEIGHT);
    let (mut light, mut error) = (Vec::new(), Vec::new());
    for pixel in 0..WIDTH * HEIGHT {
        let mut rng = Rng::new(seed, Stream::Check, 0, pixel as u64);
        let mut moments = eyebox_base::stats::Moments::default();
        for _ in 0..passes {
            // Box and Muller.
            let (a, b) = (1.0 - rng.uniform(), rng.uniform());
            moments.add(mean(pixel) + sigma * (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos());
        }
        light.push(moments.mean as f32);
        error.push(moments.stderr() as f32);
    }
    for (layer, data) in [("", light), ("stderr.", error)] {
        ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}{c}"), data.clone()));
    }
    frame.meta.insert("passes".into(), Meta::Text(passes.to_string()));
    frame.meta.insert("passes.backward".into(), Meta::Text(passes.to_string()));
    frame.meta.insert("seed".into(), Meta::Text(seed.to_string()));
    frame
}

/// Noise of few samples has the tails of Student's t: with them accounted for, noise alone is called different about as
/// rarely as it is said to be.
#[test]
fn noise_is_no_difference() {
    for passes in [4, 8, 32] {
        let mut alarms = 0;
        for seed in 0..12 {
            let found =
                compare(&sampled(2 * seed, |_| 10.0, 1.0, passes), &sampled(2 * seed + 1, |_| 10.0, 1.0, passes), 2.0);
            alarms += u32::from(found.different);
            let layer = &found.layers[0];
            if let Some([mean, expected]) = layer.mean_z2.filter(|_| passes > 4) {
                assert!((mean / expected - 1.0).abs() < 0.2, "{passes} passes: {mean} {expected}");
            }
            assert!((layer.relative_mse / layer.relative_mse_of_noise.unwrap() - 1.0).abs() < 0.25);
        }
        // 4.55 % each: of 12, more than 4 with a probability of 2e-4.
        assert!(alarms <= 4, "{passes} passes: {alarms} of 12");
    }
}

#[test]
fn a_bias_and_a_lone_pixel_are_found() {
    let reference = sampled(1, |_| 10.0, 1.0, 16);
    // 2 % everywhere: each pixel is within 0.6 sigma, the mean is 18 off.
    let found = compare(&reference, &sampled(2, |_| 10.2, 1.0, 16), 3.0);
    assert!(found.different && found.layers[0].because.contains("mean"), "{:?}", found.layers[0]);
    let layer = &found.layers[0];
    // The mean of 1024 pixels with √2·¼ each.
    assert!((layer.error_if_independent.unwrap() - 0.25 * (2.0f64 / 1024.0).sqrt()).abs() < 2e-4);
    assert!(layer.error_at_most.unwrap() > 25.0 * layer.error_if_independent.unwrap());
    let lone = |pixel: usize| if pixel == 777 { 15.0 } else { 10.0 };
    let found = compare(&reference, &sampled(3, lone, 1.0, 16), 3.0);
    let pair = found.layers[0].largest.unwrap();
    assert!(found.different && (pair.x, pair.y) == (777 % WIDTH, 777 / WIDTH), "{pair:?}");

    // Photons are shared by pixels: then the bias of the mean cannot be told from a common error, and isn't claimed.
    let shared = |seed: u64, mean: f64| {
        let mut frame = sampled(seed, |_| mean, 1.0, 16);
        frame.meta.insert("passes.photon".into(), Meta::Text("16".into()));
        frame
    };
    assert!(!compare(&shared(1, 10.0), &shared(2, 10.2), 3.0).different);
    assert!(compare(&shared(1, 10.0), &shared(2, 13.0), 3.0).different);
}

#[test]
fn frames_that_cannot_be_compared_say_why() {
    let frame = sampled(1, |_| 10.0, 1.0, 4);
    let with = |key: &str, value: Meta| {
        let mut other = frame.clone();
        other.meta.insert(key.into(), value);
        compare(&frame, &other, 3.0)
    };
    let space = with(COLOR_INTEROP_ID, Meta::Text("lin_ap1_scene".into()));
    assert_eq!(space.incomparable, ["colour space: lin_rec709_scene and lin_ap1_scene"]);
    assert!(space.different && space.layers.is_empty());
    assert!(with(WHITE_LUMINANCE, Meta::Number(100.0)).incomparable[0].contains("unit: whiteLuminance 1 and 100"));
    assert!(compare(&frame, &Frame::new(3, 3), 3.0).incomparable[0].contains("32 × 32 and 3 × 3"));
    let mut cut = frame.clone();
    cut.channels[0].data.pop();
    assert!(compare(&frame, &cut, 3.0).incomparable[0].contains("B has channels that do not fill it"));
    let seeds = with("seed", Meta::Text("5".into()));
    assert!(!seeds.different && seeds.notes.is_empty() && seeds.layers[0].verdict == Verdict::Identical);
    assert!(with("sceneHash", Meta::Text("x".into())).notes.iter().any(|note| note.contains("sceneHash: none and x")));
}

/// A content that is black but for the rounding of its sum has no error, and is no difference.
#[test]
fn the_rounding_of_black_is_no_difference() {
    let with = |seed: u64, value: f32| {
        let mut frame = sampled(seed, |_| 10.0, 1.0, 8);
        for (layer, data) in [("forward_led_content", value), ("forward_led_content_stderr", 0.0)] {
            for c in ["R", "G", "B"] {
                let mut values = vec![data; WIDTH * HEIGHT];
                values[0] = if layer.ends_with("stderr") { 0.1 } else { 1.0 };
                frame.push(format!("{layer}.{c}"), values);
            }
        }
        frame
    };
    assert!(!compare(&with(1, 0.0), &with(2, -2e-12), 3.0).different);
    assert!(compare(&with(1, 0.0), &with(2, -2e-9), 3.0).different);
}

#[test]
fn layers_by_their_kind() {
    let mut a = sampled(1, |_| 10.0, 1.0, 8);
    let mut b = sampled(2, |_| 10.0, 1.0, 8);
    let put = |frame: &mut Frame, name: &str, value: f32| frame.push(name, vec![value; WIDTH * HEIGHT]);
    for (frame, value) in [(&mut a, 1.0), (&mut b, 1.1)] {
        ["R", "G", "B"].iter().for_each(|c| put(frame, &format!("direct_sky.{c}"), value));
        put(frame, "Z", 2.0);
    }
    // Light without errors is not judged; a share that only one has is compared with black.
    ["R", "G", "B"].iter().for_each(|c| put(&mut b, &format!("caustic_led.{c}"), 1.0));
    let of = |found: &Comparison, name: &str| found.layers.iter().find(|layer| layer.layer == name).unwrap().clone();
    let found = compare(&a, &b, 3.0);
    assert_eq!(of(&found, "direct_sky").verdict, Verdict::Unjudged);
    assert_eq!(of(&found, "caustic_led").verdict, Verdict::Unjudged);
    assert_eq!(of(&found, "Z").verdict, Verdict::Identical);
    assert!(!found.different);
    // With errors it is: 1 ± 0.1 against nothing.
    ["R", "G", "B"].iter().for_each(|c| put(&mut b, &format!("caustic_led_stderr.{c}"), 0.01));
    assert_eq!(of(&compare(&a, &b, 3.0), "caustic_led").verdict, Verdict::Different);
    // Data have no noise.
    b.channels.iter_mut().find(|channel| channel.name == "Z").unwrap().data[70] = 2.1;
    let found = compare(&a, &b, 3.0);
    let depth = of(&found, "Z");
    assert_eq!((depth.verdict, depth.largest.map(|pair| (pair.x, pair.y))), (Verdict::Different, Some((6, 2))));
    // A picture of another name (`render --chain`, a USD render variable) has noise all the same.
    for (frame, value) in [(&mut a, 1.0), (&mut b, 2.0)] {
        ["R", "G", "B"].iter().for_each(|c| put(frame, &format!("ghost.{c}"), value));
    }
    assert_eq!(of(&compare(&a, &b, 3.0), "ghost").verdict, Verdict::Unjudged);
    put(&mut b, "id.part", 1.0);
    assert_eq!(compare(&a, &b, 3.0).only_in, [("id".to_owned(), 'B')]);
    // Values that are no numbers.
    a.channels[0].data[3] = f32::NAN;
    assert_eq!(of(&compare(&a, &b, 3.0), "").verdict, Verdict::Different);
    // One pass has no errors to judge by.
    let one = |seed| {
        let mut frame = sampled(seed, |_| 10.0, 1.0, 2);
        frame.channels.iter_mut().filter(|c| c.layer() == "stderr").for_each(|c| c.data.fill(0.0));
        frame
    };
    let found = compare(&one(1), &one(2), 3.0);
    assert_eq!((of(&found, "").verdict, found.verdict, found.different), (Verdict::Unjudged, Verdict::Unjudged, false));
    // A pixel that is no number in both says nothing, and the others are judged.
    let broken = |mean: f64, seed| {
        let mut frame = sampled(seed, |_| mean, 1.0, 8);
        frame.channels.iter_mut().for_each(|channel| channel.data[3] = f32::NAN);
        frame
    };
    let same = compare(&broken(10.0, 1), &broken(10.0, 2), 3.0);
    assert!(same.layers[0].because.ends_with("less 1 values that are no numbers in both"), "{:?}", same.layers[0]);
    assert_eq!((same.verdict, compare(&broken(10.0, 1), &broken(20.0, 2), 3.0).verdict), {
        (Verdict::Same, Verdict::Different)
    });
}

/// Rare light: a pixel is hit once in 200 samples, and has 16. Single pixels say "different" of two samples of the same light;
/// blocks of 16 × 16 have some twenty hits each, one of 32 × 32 some eighty, and knows the light to a ninth.
#[test]
fn blocks_judge_rare_light() {
    let rare = |seed: u64, light: f64| {
        let mut frame = sampled(seed, |_| 0.0, 0.0, 16);
        for pixel in 0..WIDTH * HEIGHT {
            let mut rng = Rng::new(seed, Stream::Check, 1, pixel as u64);
            let mut moments = eyebox_base::stats::Moments::default();
            (0..16).for_each(|_| moments.add(if rng.uniform() < 0.005 { 200.0 * light } else { 0.0 }));
            for channel in &mut frame.channels {
                let error = channel.name.starts_with("stderr");
                channel.data[pixel] = if error { moments.stderr() } else { moments.mean } as f32;
            }
        }
        frame
    };
    // Light tracing knows it well: 1 ± 0.001, with errors that pixels may share.
    let known = |seed: u64| {
        let mut frame = sampled(seed, |_| 1.0, 0.004, 16);
        frame.meta.insert("passes.forward".into(), Meta::Text("16".into()));
        frame
    };
    assert!(compare(&known(1), &rare(2, 1.0), 3.0).different, "pixels without a hit are 0 ± 0");
    let alarms = |light: f64, side: usize| {
        (0..20).filter(|seed| compare_blocks(&known(100), &rare(*seed, light), 3.0, side).different).count()
    };
    assert_eq!([alarms(1.0, 16), alarms(1.0, 32)], [0, 0]);
    assert_eq!(alarms(3.0, 32), 20);
    let found = compare_blocks(&known(100), &rare(1, 3.0), 3.0, 32);
    assert!(found.block == 32 && found.layers[0].because.contains("the block at ("), "{:?}", found.layers[0]);
    // Blocks of shared errors are not claimed to be better known than their pixels.
    let one = compare_blocks(&known(1), &known(2), 3.0, 32).layers[0].largest.unwrap();
    assert!(one.z.abs() < 0.2, "{one:?}");
}

#[test]
fn values_within_a_tolerance() {
    let a = sampled(1, |_| 10.0, 1.0, 4);
    let mut b = a.clone();
    b.channels[1].data[5] *= 1.00001;
    let found = within(&a, &b, 1e-6);
    let (layer, peak) =
        (&found.layers[0], f64::from(a.channels.iter().take(3).flat_map(|c| &c.data).fold(0.0f32, |p, v| p.max(*v))));
    assert!(found.different && found.layers.len() == 1, "errors are not compared: {found:?}");
    assert_eq!((layer.x, layer.y, layer.channel.as_str()), (5, 0, "G"));
    assert!((layer.relative - 1e-5 * layer.a / peak).abs() < 1e-7, "{layer:?}");
    assert!(!within(&a, &b, 1e-4).different);
    b.channels[0].data[1] = f32::NAN;
    assert!(within(&a, &b, 1e30).different && within(&a, &Frame::new(1, 1), 1e30).different);
    assert!(!within(&b, &b, 0.0).different);
    // Light is summed, with black for a share that one frame has not; data are those of the first; errors are left out.
    let mut c = a.clone();
    for (frame, depth) in [(&mut b, 2.0), (&mut c, 4.0)] {
        *frame = a.clone();
        frame.push("Z", vec![depth; WIDTH * HEIGHT]);
    }
    c.push("forward_led.R", vec![8.0; WIDTH * HEIGHT]);
    let sum = weighted_sum(&[b, c], &[0.25, -0.5]).unwrap();
    assert_eq!(sum.get("R").unwrap().data[7], -0.25 * a.get("R").unwrap().data[7]);
    assert_eq!((sum.get("Z").unwrap().data[0], sum.get("forward_led.R").unwrap().data[0]), (2.0, -4.0));
    assert!(sum.get("stderr.R").is_none());
    assert!(weighted_sum(&[a], &[f64::NAN]).is_err() && weighted_sum(&[], &[]).is_err());
}
