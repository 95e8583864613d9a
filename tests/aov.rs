//! Layers by light path expression: sums of stored shares, or a refusal that says which paths it would part.

mod common;

use common::*;
use eyebox::base::Where;
use eyebox::base::colour::ColourSpace;
use eyebox::check::check;
use eyebox::estimate::aov::{granted, layers, parse_option};
use eyebox::estimate::picture::picture;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::frame::Frame;
use eyebox::film::plan::{Estimator, Plan};
use eyebox::plan::{Choice, plan};
use eyebox::scene::assembly::LayerWish;
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;

/// A white wall beside a mirror, lit by a lamp that is seen and by a dim one that is not.
fn room() -> Scene {
    let mut s = scene();
    let (led, back) = (add_group(&mut s, "led"), add_group(&mut s, "back"));
    let square = |half: f64| mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    let wall = face(Finish::Lambert { reflectance: 0.5, transmittance: 0.0 });
    add_part(&mut s, "wall", square(0.4), DVec3::NEG_Z * 2.0, None, vec![wall]);
    let turned = mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.3, DVec3::Z * 0.3)]);
    let mirror = face(Finish::MirrorIdeal { reflectance: 0.9 });
    add_part(&mut s, "mirror", turned, DVec3::new(-0.3, 0.0, -1.5), None, vec![mirror]);
    for (group, place) in [(led, DVec3::new(0.1, 0.0, -1.0)), (back, DVec3::new(0.2, 0.3, 0.5))] {
        let mut panel = face(Finish::Absorber);
        panel.emitter = lamp(group, 100.0);
        let away = mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.08, DVec3::X * 0.08)]);
        add_part(&mut s, "panel", away, place, None, vec![panel]);
    }
    s
}

fn with<T>(f: impl FnOnce(&Scene, &World, &Plan) -> T) -> T {
    let s = room();
    let checked = check(&s).expect("sound");
    let world = World::freeze(&s).expect("traceable");
    let plan = plan(&checked, &world, Choice::Only(Estimator::Backward));
    f(&s, &world, &plan)
}

fn asked(name: &str, lpe: &str) -> Vec<(String, String)> {
    vec![(name.to_owned(), lpe.to_owned())]
}

#[test]
fn sums_of_shares_with_their_bits() {
    let (frame, caustic, led, all) = with(|s, world, plan| {
        let limits = Limits { passes: Some(64), ..Limits::default() };
        let outcome = run(world, plan, 2, s.eye.resolution, 0, &limits, &mut ());
        let frame: Frame = picture(s, plan, &outcome, ColourSpace::Rec709).expect("a picture").frame;
        let one = |lpe: &str| {
            let (aovs, notes) = granted(&asked("mine", lpe), (&[], &[]), s, world, plan).expect(lpe);
            assert!(notes.is_empty());
            let (channels, said) = layers(&frame, &aovs);
            assert_eq!(said[0].0, "aov.mine");
            (aovs[0].shares.clone(), channels[0].data.clone())
        };
        (frame.clone(), one("C<.[Ss]>*<.[DG]><.[Ss]>+[LOB]"), one("C.*<O.'led'>"), one("C.*"))
    });
    let red = |layer: &str| frame.rgb(layer).unwrap_or_else(|| panic!("no {layer}"))[0].to_vec();
    assert!(red("caustic").iter().any(|value| *value > 0.0), "the mirror sends light to the wall");
    assert_eq!(caustic.0, ["caustic_led", "caustic_back"]);
    assert_eq!(caustic.1, red("caustic"));
    assert_eq!(all.1, red("hybrid"));
    assert_eq!(
        led.0,
        ["direct_led", "caustic_led", "secondary_led"].map(str::to_owned).to_vec(),
        "the wall's light comes back by the mirror"
    );
}

#[test]
fn refusals_name_the_paths() {
    with(|s, world, plan| {
        let refused = |lpe: &str| granted(&asked("mine", lpe), (&[], &[]), s, world, plan).unwrap_err().to_string();
        let fault = refused("C<RS>L");
        assert!(fault.contains("takes C<RS>O and leaves CO, both vision paths of `led`"), "{fault}");
        let fault = refused("C<.[Ss]>*L");
        assert!(
            fault.contains("takes the vision paths of `led` and leaves the primary ones, which `direct_led` holds"),
            "{fault}"
        );
        assert!(refused("C.*B").contains("takes no path of this scene"));
        assert!(refused("C(").contains("`)` is missing"));
        // The wall only reflects, and there is no glass.
        let (aovs, _) = granted(&asked("mine", "C<R.>*L"), (&[], &[]), s, world, plan).expect("all that there is");
        assert_eq!(aovs[0].shares.len(), 6);
        let fault = granted(&asked("caustic_led", "C.*"), (&[], &[]), s, world, plan).unwrap_err().to_string();
        assert!(fault.contains("there is a layer `caustic_led` already"), "{fault}");
    });
}

/// What an asset wishes is written or noted, never a fault.
#[test]
fn wishes_of_an_asset() {
    with(|s, world, plan| {
        let wish = |source: &str, expression: bool| LayerWish {
            source: source.to_owned(),
            expression,
            name: "1 mine".to_owned(),
            at: Where::Nowhere,
        };
        let wishes = [wish("C.*", true), wish("C<RS>L", true), wish("Ci", false), wish("C.*L", true)];
        let (aovs, notes) = granted(&[], (&wishes, &[]), s, world, plan).expect("no fault");
        assert_eq!(aovs.iter().map(|aov| aov.name.as_str()).collect::<Vec<_>>(), ["layer_1_mine"]);
        assert_eq!(notes.len(), 2);
    });
    assert_eq!(parse_option("a = C.*L"), Ok(("a".to_owned(), "C.*L".to_owned())));
    assert!(parse_option("1=C.*").is_err() && parse_option("a").is_err() && parse_option("a=").is_err());
}
