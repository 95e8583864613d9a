use super::points::uv;
use super::*;
use eyebox_film::frame::Meta;

const WIDTH: usize = 60;
const HEIGHT: usize = 30;

/// A display over the inner 40 × 20 pixels of a picture 12° wide, 100 cd/m² at the left of its white and 80 at the right, at
/// 200:1, showing its upper half; a sky of 50 cd/m². Every error is 1 % of the light.
fn frame() -> Frame {
    let mut frame = Frame::new(WIDTH, HEIGHT);
    frame.meta.insert("groups".into(), Meta::Text("[\"led\",\"sky\"]".into()));
    frame.meta.insert("contrast".into(), Meta::Number(200.0));
    frame.meta.insert("eye".into(), Meta::Text("{\"fov_deg\":12.0}".into()));
    frame.meta.insert("passes.backward".into(), Meta::Text("16".into()));
    let open = |pixel: usize| {
        let (x, y) = (pixel % WIDTH, pixel / WIDTH);
        if (10..50).contains(&x) && (5..25).contains(&y) { 100.0 - 20.0 * (x as f64 - 9.5) / 40.0 } else { 0.0 }
    };
    let content = |pixel: usize| if pixel / WIDTH < 15 { open(pixel) } else { 0.0 };
    let led = |pixel: usize| content(pixel) * (1.0 - 1.0 / 200.0) + open(pixel) / 200.0;
    let mut put = |layer: &str, value: &dyn Fn(usize) -> f64| {
        for component in ["R", "G", "B"] {
            let name = if layer.is_empty() { component.to_owned() } else { format!("{layer}.{component}") };
            frame.push(name, (0..WIDTH * HEIGHT).map(|pixel| value(pixel) as f32).collect());
        }
    };
    put("forward_led_open", &open);
    put("forward_led_content", &content);
    put("forward_led_open_stderr", &|p| 0.01 * open(p));
    put("forward_led_content_stderr", &|p| 0.01 * content(p));
    put("forward_led_covariance", &|_| 0.0);
    put("forward_led", &led);
    put("forward_led_stderr", &|p| 0.01 * led(p));
    put("forward", &led);
    put("direct_sky", &|_| 50.0);
    put("direct_sky_stderr", &|_| 0.5);
    put("direct", &|_| 50.0);
    put("", &|pixel| led(pixel) + 50.0);
    put("stderr", &|pixel| 0.01 * (led(pixel) + 50.0));
    frame
}

fn named(found: &[Quantity], name: &str) -> Quantity {
    found.iter().find(|quantity| quantity.name.starts_with(name)).unwrap_or_else(|| panic!("no {name}")).clone()
}

#[test]
fn a_display_in_closed_form() {
    let found = measure(&frame(), &Target::default()).unwrap();
    let value = |name: &str| named(&found, name).value.unwrap_or_else(|| panic!("{:?}", named(&found, name)));
    // 400 pixels of 90 on average at full level, as many at 1/200 of it.
    let led = 90.0 * 400.0 * (1.0 + 1.0 / 200.0) / 1800.0;
    assert!((value("adaptation luminance, arithmetic") - 50.0 - led).abs() < 1e-3);
    assert!(value("adaptation luminance, log") < value("adaptation luminance, arithmetic"));
    assert!((value("adaptation luminance, foveal") - 50.0 - 45.0).abs() < 1.0, "half of the fovea sees the lit half");
    // The nine points are 3 pixels wide, at 1/6, 1/2 and 5/6 of 40 columns: 100 − 20·x/40.
    assert!((value("white luminance") - 90.0).abs() < 0.5);
    let uniformity = value("uniformity");
    assert!((uniformity - (100.0 - 20.0 * 33.5 / 40.0) / (100.0 - 20.0 * 6.5 / 40.0)).abs() < 0.01, "{uniformity}");
    assert!((value("contrast on/off") - 200.0).abs() < 0.5);
    let through = (50.0 + 90.0) / (50.0 + 90.0 / 200.0);
    assert!((value("see-through contrast") / through - 1.0).abs() < 1e-3);
    assert!((value("leak spot") - 0.5).abs() < 0.01);
    // 70 cd/m² is in the curved piece of Ferwerda's threshold.
    let threshold = 10f64.powf((0.249 * (50.0 + led).log10() + 0.65).powf(2.7) - 0.72);
    assert!((value("leak over threshold") - value("leak spot") / threshold).abs() < 1e-4);
    assert!(named(&found, "leak over threshold").note.starts_with("hidden"));
    // 40 of 60 pixels of 2·tan 6°.
    let width = 2.0 * ((2.0 / 3.0) * 6f64.to_radians().tan()).atan().to_degrees();
    assert!((value("field of view of the display, width") - width).abs() < 1e-9);
    assert!((value("field of view, width") - 12.0).abs() < 1e-12);
    assert!(named(&found, "colour uniformity").note.contains("one colour"));
    assert!(named(&found, "MTF50").note.contains("--edge"));
}

/// Path tracing from the eye: the mean of n pixels with errors σ is known to σ/√n.
#[test]
fn intervals_are_those_of_the_errors() {
    let of = |frame: &Frame| named(&measure(frame, &Target::default()).unwrap(), "adaptation luminance, arithmetic");
    let half = |quantity: &Quantity| quantity.interval.map(|[low, high]| 0.5 * (high - low)).unwrap();
    let mut frame = frame();
    let all = of(&frame);
    // Errors of 0.5 to 1.5 cd/m²: their root mean square over √1800.
    assert!(half(&all) > 1.96 * 0.5 / 1800f64.sqrt() && half(&all) < 1.96 * 1.5 / 1800f64.sqrt(), "{all:?}");
    frame.meta.insert("passes.photon".into(), Meta::Text("16".into()));
    assert!(half(&of(&frame)) > 1.96 * 0.5, "pixels that share photons may err together");
    frame.channels.retain(|channel| channel.layer() != "stderr" && channel.layer() != "forward_led_open_stderr");
    assert!(of(&frame).interval.is_none() && of(&frame).note.contains("no `stderr`"));
    let found = measure(&frame, &Target::default()).unwrap();
    assert!(named(&found, "white").note.contains("with --stderr layers"));
}

#[test]
fn colours_of_nine_points() {
    let mut frame = frame();
    // Red doubles towards the right in all that the display gives; layers follow.
    for name in ["forward_led_open", "forward_led_content", "forward_led", "forward", ""] {
        let channel = if name.is_empty() { "R".to_owned() } else { format!("{name}.R") };
        let sky = if name.is_empty() { 50.0 } else { 0.0 };
        let data = &mut frame.channels.iter_mut().find(|c| c.name == channel).unwrap().data;
        data.iter_mut().enumerate().for_each(|(i, v)| *v = sky + (*v - sky) * (1.0 + (i % WIDTH) as f32 / 60.0));
    }
    let found = measure(&frame, &Target::default()).unwrap();
    // White against (1.73, 1.28…): by hand from the matrix, points at x = 16.5 and 43.5.
    let uv_of = |red: f64| uv(eyebox_base::colour::ColourSpace::Rec709.to_xyz([red, 1.0, 1.0])).unwrap();
    let (a, b) = (uv_of(1.0 + 16.0 / 60.0), uv_of(1.0 + 43.0 / 60.0));
    let want = (a[0] - b[0]).hypot(a[1] - b[1]);
    let got = named(&found, "colour uniformity").value.unwrap();
    assert!((got / want - 1.0).abs() < 0.08, "{got} {want}");
}

#[test]
fn hostile_frames_are_faults_or_sentences() {
    assert!(measure(&Frame::new(0, 0), &Target::default()).is_err());
    let mut small = Frame::new(1, 1);
    small.meta.insert("groups".into(), Meta::Text("[]".into()));
    ["R", "G", "B"].iter().for_each(|c| small.push(*c, vec![0.0]));
    let found = measure(&small, &Target { edge: Some([0, 0, 1, 1]), ..Target::default() }).unwrap();
    assert!(named(&found, "MTF50").value.is_none() && named(&found, "leak spot").value.is_none());
    let target = Target { edge: Some([usize::MAX, 0, 2, 1]), ..Target::default() };
    assert!(measure(&small, &target).unwrap_err().to_string().contains("not inside the picture"));
    let black = {
        let mut black = frame();
        black.channels.iter_mut().for_each(|channel| channel.data.fill(0.0));
        black
    };
    assert!(measure(&black, &Target::default()).unwrap().iter().filter(|q| q.value.is_none()).count() > 5);
    assert!(measure(&black, &Target { groups: vec!["sky".into()], edge: None }).is_ok());
}
