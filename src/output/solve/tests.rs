use super::*;
use crate::leak::patch_pixels;
use crate::mix::mix;
use eyebox_film::frame::{Frame, Meta};

const WIDTH: usize = 24;
const HEIGHT: usize = 12;

/// A sky of 100 cd/m² and a display of 50 cd/m² in a quarter of the picture, at 50:1; fully open it is 50 cd/m² over a half.
fn frame() -> Frame {
    let mut frame = Frame::new(WIDTH, HEIGHT);
    frame.meta.insert("groups".into(), Meta::Text("[\"led\",\"sky\"]".into()));
    frame.meta.insert("contrast".into(), Meta::Number(50.0));
    let open = |pixel: usize| if pixel % WIDTH < WIDTH / 2 { 50.0 } else { 0.0 };
    let content = |pixel: usize| if pixel / WIDTH < HEIGHT / 2 { open(pixel) } else { 0.0 };
    let led = |pixel: usize| content(pixel) * 0.98 + open(pixel) * 0.02;
    let mut put = |layer: &str, value: &dyn Fn(usize) -> f64| {
        for component in ["R", "G", "B"] {
            let name = if layer.is_empty() { component.to_owned() } else { format!("{layer}.{component}") };
            frame.push(name, (0..WIDTH * HEIGHT).map(|pixel| value(pixel) as f32).collect());
        }
    };
    put("forward_led_open", &open);
    put("forward_led_content", &content);
    put("forward_led", &led);
    put("forward", &led);
    put("direct_sky", &|_| 100.0);
    put("direct", &|_| 100.0);
    put("", &|pixel| led(pixel) + 100.0);
    frame
}

fn solved(frame: &Frame, recipe: &Recipe, goal: Goal) -> Result<Solved> {
    solve(&Rendering::of(frame)?, recipe, &[], goal)
}

#[test]
fn contrast_in_closed_form() {
    let frame = frame();
    for contrast in [1.2, 1.5, 10.0] {
        let found = solved(&frame, &Recipe::default(), Goal::Contrast(contrast)).unwrap();
        // 100 + 50g = X·(100 + g) in the lit quarter.
        let want = 100.0 * (contrast - 1.0) / (50.0 - contrast);
        assert!((found.gain / want - 1.0).abs() < 1e-6, "{contrast}: {} {want}", found.gain);
        assert!((found.contrast - contrast).abs() < 1e-9);
        assert_eq!(found.groups, ["led"]);
        // The mixture with that gain has it.
        let recipe = Recipe { gains: vec![("led".into(), found.gain)], ..Recipe::default() };
        let mixed = mix(&Rendering::of(&frame).unwrap(), &recipe).unwrap().frame;
        let light = mixed.rgb("").unwrap()[1];
        let (lit, dark) = (f64::from(light[0]), f64::from(light[WIDTH * (HEIGHT - 1)]));
        assert!((lit / dark / contrast - 1.0).abs() < 1e-6, "{lit} over {dark}");
    }
    // A gain that is asked for beside it stays, and the slide's own contrast is the limit.
    let recipe =
        Recipe { gains: vec![("led".into(), 4.0), ("sky".into(), 0.5)], contrast: Some(100.0), ..Recipe::default() };
    let found = solved(&frame, &recipe, Goal::Contrast(2.0)).unwrap();
    assert!((found.gain / (50.0 / (200.0 - 2.0 * 2.0)) - 1.0).abs() < 1e-6, "{found:?}");
    let fault = solved(&frame, &Recipe::default(), Goal::Contrast(50.5)).unwrap_err().to_string();
    assert!(fault.contains("the slide's own contrast is 50.0"), "{fault}");
}

#[test]
fn the_leak_ends_at_the_threshold() {
    let frame = frame();
    let found = solved(&frame, &Recipe::default(), Goal::LeakHidden).unwrap();
    // Photopic: g·1 = 10^−1.255·(100 + g·12.75), mean of the display 50·(¼ + 0.02·¼).
    let weber = 10f64.powf(-1.255);
    let want = weber * 100.0 / (1.0 - weber * 12.75);
    assert!((found.gain / want - 1.0).abs() < 1e-5, "{} {want}", found.gain);
    assert!((found.visibility.factor - 1.0).abs() < 1e-9 && (found.leak_spot_cd_m2 - found.gain).abs() < 1e-4);
    // In the dark the curved part of the threshold decides.
    let night = Recipe { gains: vec![("sky".into(), 1e-3)], ..Recipe::default() };
    let found = solved(&frame, &night, Goal::LeakHidden).unwrap();
    let adaptation = 0.1 + 12.75 * found.gain;
    assert!((found.gain / threshold_ferwerda(adaptation) - 1.0).abs() < 1e-5, "{found:?}");
    let dark = Recipe { contrast: Some(f64::INFINITY), ..Recipe::default() };
    let found = solved(&frame, &dark, Goal::LeakHidden).unwrap();
    assert!(found.at_every_level && found.gain == 1.0 && !found.visibility.visible);
    assert_eq!(patch_pixels(&frame), 3);
}

#[test]
fn the_group_is_chosen_or_asked_for() {
    let frame = frame();
    let rendering = Rendering::of(&frame).unwrap();
    let with = |groups: &[&str]| {
        let groups: Vec<String> = groups.iter().map(|group| (*group).to_owned()).collect();
        solve(&rendering, &Recipe::default(), &groups, Goal::Contrast(1.5))
    };
    assert_eq!(with(&["led"]).unwrap(), with(&[]).unwrap());
    let fault = with(&["leds"]).unwrap_err().to_string();
    assert!(fault.ends_with("did you mean `led`?"), "{fault}");
    let mut bare = frame.clone();
    bare.channels.retain(|channel| !channel.name.starts_with("forward_led_"));
    let fault = solved(&bare, &Recipe::default(), Goal::LeakHidden).unwrap_err().to_string();
    assert!(fault.contains("no group's light depends on a slide; expected --solve-for GROUP,… of led, sky"), "{fault}");
    let black = Recipe { gains: vec![("led".into(), 0.0)], ..Recipe::default() };
    assert!(solved(&frame, &black, Goal::LeakHidden).unwrap_err().to_string().contains("no light of led"));
}

#[test]
fn goals_as_they_are_written() {
    assert_eq!(Goal::parse("contrast=1.5"), Ok(Goal::Contrast(1.5)));
    assert_eq!(Goal::parse("leak=hidden"), Ok(Goal::LeakHidden));
    for bad in ["contrast=1", "contrast=inf", "contrast=x", "leak", "leak=gone", "", "contrast=NaN"] {
        assert!(Goal::parse(bad).is_err(), "{bad}");
    }
}

#[test]
fn lit_pixels_of_two_levels() {
    assert_eq!(lit_pixels(&[0.1, 0.1, 9.0, 0.1, 10.0, 0.0]), [2, 4]);
    assert!(lit_pixels(&[0.0; 3]).is_empty() && lit_pixels(&[]).is_empty() && lit_pixels(&[f64::NAN]).is_empty());
}
