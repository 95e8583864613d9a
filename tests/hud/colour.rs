//! Lateral colour of the direct HUD: where the eye's chief ray meets the slide at F and at C.

use super::kit::hud;
use eyebox::base::rng::{Rng, Stream};
use eyebox::estimate::ledger::Ledger;
use eyebox::estimate::walk::{Met, Travel, Walker};
use eyebox::scene::Wavelengths;
use eyebox::world::World;
use eyebox::world::geometry::Ray;
use eyebox::world::interior::Interior;
use eyebox::world::mode::{Mode, Mono};

/// Where the ray from the pupil's centre at `degrees` to the right, reflected by the combiner's front, meets the slide, in
/// mesh units along the picture's u.
fn on_slide(nm: f64, degrees: f64) -> f64 {
    let mut scene = hud("direct", &[]);
    scene.wavelengths = Wavelengths::Mono { nm };
    let world = World::freeze(&scene).expect("the sample can be traced");
    let optics = Mono::<f64>::optics(&world, 0, 0);
    let eye = &scene.eye;
    let dir = (eye.look + eye.right() * degrees.to_radians().tan()).normalize();
    let ray = Ray { origin: world.eye.position(), dir, from: None };
    let rng = Rng::new(0, Stream::Check, 0, 0);
    let mut ledger = Ledger::new(scene.parts.len());
    let start = (&world, &optics);
    let mut walker = Walker::<Mono>::new(start, Travel::FromEye, ray, 1.0, Interior::default(), rng);
    for _ in 0..64 {
        let Met::Face(vertex) = walker.advance(&mut ledger) else { panic!("the ray left at {nm} nm, {degrees}°") };
        let part = &scene.parts[vertex.hit.site.part as usize];
        if part.faces[vertex.hit.site.face as usize].slide.is_some() {
            return vertex.hit.local.dot(scene.slides[0].u);
        }
        if part.name.starts_with("COMBINER") {
            walker = walker.split(&vertex, 0.0, u8::MAX, &mut ledger).expect("a combiner reflects");
        } else {
            assert!(walker.go_straight_on(&vertex, &mut ledger), "{} stops the ray", part.name);
        }
    }
    panic!("no slide at {nm} nm, {degrees}°")
}

/// 3.8′ between F and C at 4° (the figure, from the prescription).
#[test]
fn lateral_colour_of_the_direct_hud() {
    const F: f64 = 486.1327;
    const C: f64 = 656.2725;
    let per_degree = (on_slide(550.0, 4.05) - on_slide(550.0, 3.95)) / 0.1;
    let arcmin = |degrees: f64| 60.0 * (on_slide(F, degrees) - on_slide(C, degrees)) / per_degree;
    let (at_4, at_2) = (arcmin(4.0), arcmin(2.0));
    println!("lateral colour {at_4:.3}′ at 4°, {at_2:.3}′ at 2°");
    assert!((at_4.abs() - 3.8).abs() < 0.1, "{at_4}");
    assert!((at_2.abs() - 1.9).abs() < 0.15, "{at_2}");
}
