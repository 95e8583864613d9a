//! Scenes from seeds: small displays and rooms, and assemblies as the field builds them, so that no estimator is the right
//! one for all. A scene depends on its family and its seed alone.

mod build; // parts of an assembly
mod cabin;
mod combiner;
mod families; // which families seeds take turns over
mod glasses;
mod panels;
mod patch; // curved faces as meshes
mod samples;
mod train; // mirrors in a row
mod windshield;

use super::kit;
use eyebox_base::rng::{Rng, Stream};
use eyebox_scene::Scene;
pub use families::Families;
pub use samples::{lens, plate};

/// What a scene is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// LEDs imaged into the pupil by a lens, through a slide.
    Direct,
    /// The same with a diffuser behind the slide.
    Diffuser,
    /// A panorama, seen plainly, through glass and on a matt floor.
    Panorama,
    /// The direct display behind a tilted plate that shows a panorama.
    Both,
    /// LEDs behind a rough pane.
    RoughGlass,
    /// LEDs over a matt floor.
    NoLens,
    /// A room with matt walls and a window to a panorama.
    Room,
    /// A backlit slide over a fold mirror, a freeform mirror and a curved windshield.
    Windshield,
    /// A display over a beam splitter at 45° and a concave half mirror, before the world.
    Birdbath,
    /// A slide over a concave mirror and a plane combiner.
    Combiner,
    /// A light guide with a row of partial mirrors inside, into which a collimated display is coupled.
    LightGuide,
    /// An array of microlenses before emitters or a diffuser.
    Microlenses,
    /// Two slides in a row before a backlight.
    TwoSlides,
    /// The inside of a car in daylight.
    Cabin,
}

impl Family {
    pub const ALL: [Family; 14] = [
        Family::Direct,
        Family::Diffuser,
        Family::Panorama,
        Family::Both,
        Family::RoughGlass,
        Family::NoLens,
        Family::Room,
        Family::Windshield,
        Family::Birdbath,
        Family::Combiner,
        Family::LightGuide,
        Family::Microlenses,
        Family::TwoSlides,
        Family::Cabin,
    ];

    /// The family of a seed among the first seven.
    pub fn of_seed(seed: u64) -> Family {
        Families::first().of_seed(seed)
    }

    pub fn name(self) -> &'static str {
        match self {
            Family::Direct => "direct",
            Family::Diffuser => "diffuser",
            Family::Panorama => "panorama",
            Family::Both => "both",
            Family::RoughGlass => "rough glass",
            Family::NoLens => "no lens",
            Family::Room => "room",
            Family::Windshield => "windshield",
            Family::Birdbath => "birdbath",
            Family::Combiner => "combiner",
            Family::LightGuide => "light guide",
            Family::Microlenses => "microlenses",
            Family::TwoSlides => "two slides",
            Family::Cabin => "cabin",
        }
    }

    /// The name as an option takes it.
    fn key(self) -> String {
        self.name().replace(' ', "-")
    }
}

/// Random choices of one scene.
struct Dice(Rng);

impl Dice {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }
    fn whole(&mut self, low: u64, high: u64) -> u64 {
        low + self.0.next_u64() % (high - low + 1)
    }
    fn coin(&mut self) -> bool {
        self.0.uniform() < 0.5
    }
}

const GLASS: f64 = 1.5168;

/// The scene of a seed among the first seven families: 32 × 24 pixels, metres, the eye at the origin looking along −z.
pub fn scene(seed: u64) -> Scene {
    scene_of(Family::of_seed(seed), seed)
}

/// The scene of a seed in a family, in metres.
pub fn scene_of(family: Family, seed: u64) -> Scene {
    let mut dice = Dice(Rng::new(seed, Stream::Check, 0, 0));
    let dice = &mut dice;
    let mut made = kit::scene(20.0, 1);
    let scene = &mut made;
    scene.name = format!("generated {seed} ({})", family.name());
    scene.eye.resolution = [32, 24];
    scene.eye.pupil_diameter_m = dice.within(2e-3, 6e-3);
    match family {
        Family::Direct => samples::display(scene, dice, false),
        Family::Diffuser => samples::display(scene, dice, true),
        Family::Panorama => samples::panorama(scene, dice),
        Family::Both => samples::both(scene, dice),
        Family::RoughGlass => samples::rough_glass(scene, dice),
        Family::NoLens => samples::no_lens(scene, dice),
        Family::Room => samples::room(scene, dice),
        Family::Windshield => windshield::build(scene, dice),
        Family::Birdbath => glasses::birdbath(scene, dice),
        Family::Combiner => combiner::build(scene, dice),
        Family::LightGuide => glasses::light_guide(scene, dice),
        Family::Microlenses => panels::microlenses(scene, dice),
        Family::TwoSlides => panels::two_slides(scene, dice),
        Family::Cabin => cabin::build(scene, dice),
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_check::check;
    use eyebox_scene::Face;
    use eyebox_world::World;

    #[test]
    fn scenes_are_sound_and_depend_on_the_seed_alone() {
        for seed in 0..14 {
            let one = scene(seed);
            check(&one).unwrap_or_else(|fault| panic!("{seed}: {fault}"));
            World::freeze(&one).unwrap_or_else(|fault| panic!("{seed}: {fault}"));
            assert_eq!(format!("{one:?}"), format!("{:?}", scene(seed)));
            assert_ne!(format!("{one:?}"), format!("{:?}", scene(seed + 7)));
        }
    }

    /// Both ends of what the LEDs may be: alone, and many.
    #[test]
    fn leds_are_one_to_forty_five() {
        let count = |seed| {
            let is_lamp = |face: &&Face| face.emitter.is_some();
            scene(seed).parts.iter().flat_map(|part| part.faces.iter().filter(is_lamp).collect::<Vec<_>>()).count()
        };
        let counts: Vec<usize> = (0..60).map(|i| count(7 * i)).collect();
        assert!(counts.iter().all(|n| (1..=45).contains(n)), "{counts:?}");
        assert!(counts.contains(&1) && counts.iter().any(|n| *n > 30), "{counts:?}");
        assert_eq!((count(2), count(6)), (0, 0));
    }
}
