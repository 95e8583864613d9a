//! What the stored layers promise: recombination at another contrast, and sums.

use super::kit::*;
use eyebox::estimate::picture::picture;
use eyebox::film::frame::Frame;
use eyebox::film::layer::Layer;
use eyebox::plan::Choice;
use eyebox::scene::Scene;

fn frame(scene: &Scene, passes: u64) -> Frame {
    let ready = Ready::new(scene, Choice::Auto);
    picture(scene, &ready.plan, &ready.run(passes, 7), Default::default()).expect("a sound picture").frame
}

fn channel<'f>(frame: &'f Frame, layer: &str) -> &'f [f32] {
    frame.component(layer, "R").unwrap_or_else(|| panic!("no {layer} in {:?}", frame.layer_names())).data.as_slice()
}

/// Same seed, contrast 300 and 50: each is the other's `open` and `content` recombined.
#[test]
fn another_contrast_is_open_and_content_recombined() {
    for (name, layer) in [("direct", "forward_led"), ("diffuse", "caustic_led")] {
        let render = |contrast: &str| {
            let set = format!("LCD_ACTIVE_AREA.contrast={contrast}");
            let mut scene = hud(name, &[&set]);
            scene.eye.resolution = [36, 18];
            frame(&scene, 4)
        };
        let high = render("300");
        let low = render("50");
        let (open, content) = (channel(&high, &format!("{layer}_open")), channel(&high, &format!("{layer}_content")));
        let crossings = ["cross", "cross2", "cross3"]
            .map(|order| high.component(&format!("{layer}_{order}"), "R").map(|c| c.data.as_slice()));
        let want = channel(&low, layer);
        let peak = want.iter().copied().fold(0.0, f32::max);
        let v = 1.0f64 / 50.0;
        let mut worst = 0.0f64;
        for pixel in 0..want.len() {
            // Light that crosses the slide more than once: u·v·(q₀ + q₁u + q₂u²), see docs/contrast.md.
            let u = 1.0 - v;
            let crossed: f64 =
                (0..3).map(|k| crossings[k].map_or(0.0, |q| f64::from(q[pixel]) * u.powi(k as i32))).sum();
            let made = f64::from(content[pixel]) * u + f64::from(open[pixel]) * v + crossed * u * v;
            worst = worst.max((made - f64::from(want[pixel])).abs() / f64::from(peak));
        }
        let moved = channel(&high, layer).iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        eprintln!("{name}: recombined misses {worst:.1e} of the peak {peak}; the contrast moved {moved}");
        assert!(worst < 1e-6, "{name}: {worst}");
        assert!(moved > 1e-3 * peak, "{name}: the contrast must matter");
    }
}

/// Σ groups = layer and Σ layers = `hybrid`, to the bit, with two light groups.
#[test]
fn layers_add_up_to_the_bit() {
    for name in ["direct", "diffuse"] {
        let mut scene = import_hud(name, &[]);
        scene.eye.resolution = [24, 12];
        let frame = frame(&scene, 4);
        let mut hybrid = vec![0f32; 24 * 12];
        let mut groups_seen = 0;
        for layer in Layer::SUM_ORDER {
            let Some(stored) = frame.component(layer.name(), "R") else { continue };
            let mut sum = vec![0f32; 24 * 12];
            for group in &scene.groups {
                let name = format!("{}_{}", layer.name(), group.name);
                if let Some(part) = frame.component(&name, "R") {
                    groups_seen += 1;
                    sum.iter_mut().zip(&part.data).for_each(|(a, b)| *a += b);
                }
            }
            assert_eq!(sum, stored.data, "{name} {}", layer.name());
            hybrid.iter_mut().zip(&stored.data).for_each(|(a, b)| *a += b);
        }
        assert!(groups_seen >= 2, "{name}: {:?}", frame.layer_names());
        assert_eq!(hybrid, channel(&frame, "hybrid"), "{name}");
        assert_eq!(hybrid, frame.get("R").expect("the default image").data, "{name}");
        assert!(hybrid.iter().all(|v| *v > 0.0), "{name}: the sky is behind every pixel");
    }
}
