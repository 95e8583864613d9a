use super::*;
use crate::plate::place;
use crate::sum_frames::join;
use eyebox_film::frame::Meta;
use eyebox_film::still::{Light, Still};

/// Two pixels of a frame with two groups: `led` crosses the slide (once and twice), `sky` does not. Values are exact in
/// f32, so that sums are too.
pub fn frame() -> Frame {
    let mut frame = Frame::new(2, 1);
    frame.meta.insert("groups".into(), Meta::Text("[\"led\",\"sky\"]".into()));
    frame.meta.insert("contrast".into(), Meta::Number(4.0));
    let mut put = |layer: &str, data: [f32; 2]| {
        for component in ["R", "G", "B"] {
            let name = if layer.is_empty() { component.to_owned() } else { format!("{layer}.{component}") };
            frame.push(name, data.to_vec());
        }
    };
    // content·¾ + open/4 + cross·3/16
    put("forward_led_open", [64.0, 32.0]);
    put("forward_led_content", [64.0, 0.0]);
    put("forward_led_cross", [-16.0, -16.0]);
    put("forward_led", [61.0, 5.0]);
    put("forward", [61.0, 5.0]);
    put("direct_sky", [10.0, 20.0]);
    put("direct", [10.0, 20.0]);
    put("hybrid", [71.0, 25.0]);
    put("", [71.0, 25.0]);
    put("seethrough", [0.5, 0.25]);
    frame
}

fn with_errors() -> Frame {
    let mut frame = frame();
    let mut put = |layer: &str, data: [f32; 2]| {
        ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}.{c}"), data.to_vec()));
    };
    put("forward_led_open_stderr", [4.0, 2.0]);
    put("forward_led_content_stderr", [3.0, 0.0]);
    put("forward_led_covariance", [6.0, 0.0]);
    put("forward_led_stderr", [3.0, 0.5]);
    put("forward_stderr", [3.0, 0.5]);
    put("direct_sky_stderr", [4.0, 1.0]);
    put("direct_stderr", [4.0, 1.0]);
    // 3² + 4² + 2·2·…: the two lean on each other by a covariance of 12 in the first pixel, by none in the second.
    put("stderr", [7.0, 1.25f32.sqrt()]);
    frame
}

fn mixed(frame: &Frame, recipe: &Recipe) -> Mixed {
    mix(&Rendering::of(frame).unwrap(), recipe).unwrap()
}

fn red<'f>(frame: &'f Frame, layer: &str) -> &'f [f32] {
    frame.rgb(layer).unwrap_or_else(|| panic!("no layer {layer}"))[0]
}

fn gains(list: &[(&str, f64)]) -> Recipe {
    Recipe { gains: list.iter().map(|(group, gain)| ((*group).to_owned(), *gain)).collect(), ..Recipe::default() }
}

#[test]
fn nothing_changed_keeps_every_bit() {
    for frame in [frame(), with_errors()] {
        for recipe in [Recipe::default(), Recipe { contrast: Some(4.0), ..gains(&[("led", 1.0)]) }] {
            assert_eq!(mixed(&frame, &recipe).frame, frame);
        }
    }
}

#[test]
fn gains_act_on_shares_and_sums() {
    let got = mixed(&frame(), &gains(&[("led", 0.5), ("sky", 3.0), ("sky", 2.0)])).frame;
    assert_eq!(red(&got, "forward_led"), [30.5, 2.5]);
    assert_eq!(red(&got, "forward_led_open"), [32.0, 16.0], "a mixture can be mixed again");
    assert_eq!(red(&got, "direct"), [60.0, 120.0]);
    assert_eq!(red(&got, "hybrid"), [90.5, 122.5]);
    assert_eq!(red(&got, ""), red(&got, "hybrid"));
    assert_eq!(red(&got, "seethrough"), [0.5, 0.25], "no light");
    let names = |frame: &Frame| frame.channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&got), names(&frame()));
}

#[test]
fn layers_of_chains_are_left_out_when_light_changes() {
    let mut frame = frame();
    ["R", "G", "B"].iter().for_each(|c| frame.push(format!("ghost.{c}"), vec![1.0; 2]));
    frame.meta.insert("chain.ghost".into(), Meta::Text("row 3".into()));
    frame.meta.insert("paths".into(), Meta::Text("[]".into()));
    assert_eq!(mixed(&frame, &Recipe::default()).frame, frame);
    let Mixed { frame: out, left_out, .. } = mixed(&frame, &gains(&[("led", 0.5)]));
    assert_eq!((left_out, out.rgb("ghost"), out.text("chain.ghost")), (vec!["ghost".to_owned()], None, None));
    assert_eq!(out.text("paths"), None);
}

#[test]
fn contrast_is_the_polynomial_of_the_layers() {
    for (contrast, want) in
        [(f64::INFINITY, [64.0, 0.0]), (1.0, [64.0, 32.0]), (2.0, [64.0 - 4.0, 16.0 - 4.0]), (4.0, [61.0, 5.0])]
    {
        let got = mixed(&frame(), &Recipe { contrast: Some(contrast), ..gains(&[("led", 2.0)]) }).frame;
        assert_eq!(red(&got, "forward_led"), want.map(|v| 2.0 * v as f32), "C = {contrast}");
        assert_eq!(red(&got, ""), [2.0 * want[0] as f32 + 10.0, 2.0 * want[1] as f32 + 20.0]);
        assert_eq!(got.number("contrast"), Some(contrast));
        // There and back again.
        let back = mixed(&got, &Recipe { contrast: Some(4.0), ..gains(&[("led", 0.5)]) }).frame;
        assert_eq!(back, frame());
    }
}

#[test]
fn errors_are_carried_where_they_are_known() {
    let after = |recipe: &Recipe| mixed(&with_errors(), recipe);
    // All light by one factor.
    let Mixed { frame, errors, .. } = after(&gains(&[("led", 3.0), ("sky", 3.0)]));
    assert_eq!((red(&frame, "stderr")[0], errors), (21.0, Errors::Exact));
    // Two shares: √(9·2² + 16 + 2·2·12) = 10; in the second pixel √(0.25·4 + 1).
    let Mixed { frame, errors, .. } = after(&gains(&[("led", 2.0)]));
    assert_eq!((red(&frame, "stderr")[0], errors), (10.0, Errors::Exact));
    assert!((red(&frame, "stderr")[1] - 2f32.sqrt()).abs() < 1e-6);
    assert_eq!(red(&frame, "forward_led_covariance"), [24.0, 0.0], "a covariance has the square of the gain");
    assert_eq!((red(&frame, "forward_stderr"), red(&frame, "direct_stderr")), (&[6.0, 1.0][..], &[4.0, 1.0][..]));
    // C = 2: (3/2)² + (4/2)² + 2·6/4 = 9.25 for the LED, whose correlation with the sky stays 1.
    let Mixed { frame, errors, .. } = after(&Recipe { contrast: Some(2.0), ..Recipe::default() });
    assert_eq!(errors, Errors::FromShares);
    assert!((red(&frame, "forward_led_stderr")[0] - 9.25f32.sqrt()).abs() < 1e-6);
    assert!((red(&frame, "stderr")[0] - (9.25f32.sqrt() + 4.0)).abs() < 1e-5);
}

#[test]
fn errors_that_are_not_known_are_bounded_or_left_out() {
    let mut frame = frame();
    ["R", "G", "B"].iter().for_each(|c| frame.push(format!("stderr.{c}"), vec![2.0, 1.0]));
    let Mixed { frame: out, errors, .. } = mixed(&frame, &gains(&[("led", 3.0)]));
    assert_eq!((red(&out, "stderr"), errors), (&[6.0, 3.0][..], Errors::AtMost));
    let Mixed { frame: out, errors, .. } = mixed(&frame, &Recipe { contrast: Some(9.0), ..Recipe::default() });
    assert_eq!((out.rgb("stderr"), errors), (None, Errors::Unknown));
    assert_eq!(mixed(&frame, &gains(&[("led", 2.0), ("sky", 2.0)])).errors, Errors::Exact);
}

fn still(width: usize, light: Light) -> Still {
    Still { width, height: 1, light, white_cd_m2: None, remarks: Vec::new() }
}

#[test]
fn a_plate_is_dimmed_by_what_it_is_seen_through() {
    let plate = still(2, Light::Rgb(vec![[8.0, 16.0, 32.0], [16.0, 32.0, 64.0]]));
    let (placed, group) = place(&frame(), &plate, 1.0).unwrap();
    assert_eq!(group.as_deref(), Some("sky"));
    assert_eq!(placed.rgb("plate").unwrap().map(<[f32]>::to_vec), [[4.0, 4.0], [8.0, 8.0], [16.0, 16.0]]);
    assert_eq!(placed.rgb("").unwrap()[2], [71.0 + 16.0, 25.0 + 16.0]);
    // It is a group of its own, and a new plate takes the place of the old one.
    let got = mixed(&placed, &gains(&[("plate", 0.25), ("sky", 0.0)])).frame;
    assert_eq!(got.rgb("").unwrap()[2], [61.0 + 4.0, 5.0 + 4.0]);
    assert_eq!(place(&placed, &plate, 1.0).unwrap().0, placed);
    // As a luminance, and with a white of its own.
    let grey = still(2, Light::Grey(vec![8.0, 16.0]));
    assert_eq!(red(&place(&frame(), &grey, 1.0).unwrap().0, "plate"), [4.0, 4.0]);
    assert_eq!(red(&place(&frame(), &grey, 80.0).unwrap().0, "plate"), [320.0, 320.0]);

    let fault = |frame: &Frame, plate: &Still| place(frame, plate, 1.0).unwrap_err().to_string();
    let mut alike = frame();
    alike.meta.insert("groups".into(), Meta::Text("[\"led\",\"plate\"]".into()));
    assert_eq!(
        fault(&alike, &plate),
        "`plate` would be the layer of --plate and a light group of the frame; expected another name for the asset's own, \
         and a new rendering"
    );
    assert_eq!(
        fault(&frame(), &still(3, Light::Grey(vec![1.0; 3]))),
        "the plate has 3 × 1 pixels; expected 2 × 1, as the frame has, or --fit with one of contain, cover, stretch, centre"
    );
    let mut bare = frame();
    bare.channels.retain(|channel| channel.layer() != "seethrough");
    assert!(fault(&bare, &grey).contains("no layer `seethrough`"));
}

/// One pass of rays from the eye tells no error, so no mixture has one either.
#[test]
fn unknown_errors_stay_unknown() {
    let mut frame = with_errors();
    let unknown = |channel: &&mut eyebox_film::frame::Channel| eyebox_film::names::is_error(channel.layer());
    frame.channels.iter_mut().filter(unknown).for_each(|channel| channel.data = vec![f32::NAN; 2].into());
    let rendering = Rendering::of(&frame).expect("an unknown error is no damage");
    for recipe in [gains(&[("led", 2.0)]), Recipe { contrast: Some(2.0), ..Recipe::default() }] {
        let Mixed { frame, errors, .. } = mix(&rendering, &recipe).unwrap();
        assert_eq!(errors, Errors::Untold);
        for layer in ["stderr", "forward_led_stderr", "forward_stderr"] {
            assert!(red(&frame, layer).iter().all(|sigma| sigma.is_nan()), "{layer}");
        }
    }
}

#[test]
fn frames_of_different_lamps_add_up() {
    let (mut led, mut sky) = (with_errors(), with_errors());
    let keep = |frame: &mut Frame, gone: &str, group: &str, hybrid: [f32; 2], error: [f32; 2]| {
        frame.channels.retain(|channel| !channel.name.starts_with(&gone[..gone.len() - 1]));
        frame.meta.insert("groups".into(), Meta::Text(format!("[\"{group}\"]")));
        for channel in &mut frame.channels {
            match channel.layer() {
                "" | "hybrid" => channel.data = hybrid.to_vec().into(),
                "stderr" => channel.data = error.to_vec().into(),
                _ => {}
            }
        }
    };
    keep(&mut led, "directX", "led", [61.0, 5.0], [3.0, 0.5]);
    keep(&mut sky, "forwardX", "sky", [10.0, 20.0], [4.0, 1.0]);
    let sum = join(&[led.clone(), sky.clone()]).unwrap();
    assert_eq!(red(&sum, ""), [71.0, 25.0]);
    assert_eq!(red(&sum, "stderr")[0], 5.0, "errors of two runs are independent");
    let got = mixed(&sum, &gains(&[("led", 2.0), ("sky", 0.5)])).frame;
    assert_eq!(red(&got, "hybrid"), [127.0, 20.0]);
    assert!((red(&got, "stderr")[0] - 40f32.sqrt()).abs() < 1e-5);

    let fault = |frames: &[Frame]| join(frames).unwrap_err().to_string();
    assert!(fault(&[led.clone(), led.clone()]).contains("light in `forward_led`, as another has"));
    assert!(fault(&[led.clone(), Frame::new(4, 4)]).contains("size 4 × 4; expected 2 × 1"));
    sky.meta.insert("contrast".into(), Meta::Number(5.0));
    assert!(fault(&[led, sky]).contains("the contrast 5; expected 4"));
}

#[test]
fn faults_name_what_is_wrong() {
    let fault = |recipe: &Recipe| mix(&Rendering::of(&frame()).unwrap(), recipe).unwrap_err().to_string();
    assert_eq!(
        fault(&gains(&[("lad", 2.0)])),
        "--gain lad=2: the frame has no light group `lad`; expected one of led, sky; did you mean `led`?"
    );
    for gain in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(fault(&gains(&[("led", gain)])).contains("expected 0 or more, finite"));
    }
    for contrast in [0.5, -3.0, f64::NAN] {
        let recipe = Recipe { contrast: Some(contrast), ..Recipe::default() };
        assert!(fault(&recipe).contains("expected 1 or more; `inf` is allowed"), "{contrast}");
    }

    let broken = |change: &dyn Fn(&mut Frame)| {
        let mut frame = frame();
        change(&mut frame);
        let recipe = Recipe { contrast: Some(9.0), ..Recipe::default() };
        Rendering::of(&frame).and_then(|r| mix(&r, &recipe).map(|_| ())).unwrap_err().to_string()
    };
    let without = |layer: &'static str| broken(&move |f| f.channels.retain(|channel| channel.layer() != layer));
    assert!(
        without("direct_sky").contains("do not add up to `direct`; expected all shares"),
        "{}",
        without("direct_sky")
    );
    assert!(without("direct_sky").contains("`direct_led` or `direct_sky`"));
    assert!(without("forward_led_cross").contains("do not give `forward_led` at the rendered contrast 4"));
    assert!(broken(&|f| f.channels[12].data[1] = f32::INFINITY).contains("`forward.R` is inf at pixel (1, 0)"));
    assert!(broken(&|f| f.channels[12].data.clear()).contains("`forward.R` has 0 values"));
    assert!(broken(&|f| drop(f.meta.remove("groups"))).contains("no list of light groups"));
    assert!(broken(&|f| drop(f.meta.remove("contrast"))).contains("no slide whose contrast"));
    let splits = |written: bool| {
        let json = format!(
            "[{{\"layer\":\"forward\",\"group\":\"led\",\"written\":{written},\"because\":\"five crossings\"}}]"
        );
        broken(&move |f| {
            f.channels.retain(|channel| !channel.name.starts_with("forward_led_"));
            f.meta.insert("splits".into(), Meta::Text(json.clone()));
        })
    };
    assert!(splits(false).contains("`forward_led` is not split by contrast: five crossings"));
    assert!(splits(true).contains("its layers were left out"));
}
