//! What a part probably is, from the words of its name.

use eyebox_scene::glass;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Lens or prism, with its glass if the name says it.
    Lens(Option<&'static str>),
    /// A plate of glass that light passes or is reflected by.
    Plate(Option<&'static str>),
    Slide,
    Lamp,
    Diffuser,
    Mirror,
    /// Whatever holds and shields: black.
    Mechanics,
}

const MECHANICS: [&str; 24] = [
    "HOUSING", "TUBE", "BAFFLE", "BEZEL", "FRAME", "PCB", "BOARD", "MOUNT", "HOLDER", "BARREL", "SCREW", "HEATSINK",
    "CASE", "SPACER", "RETAINER", "RING", "BRACKET", "STOP", "APERTURE", "SHIELD", "CLAMP", "COVER", "BASE", "RIM",
];
const LAMP: [&str; 7] = ["LED", "DIE", "EMITTER", "LAMP", "CHIP", "OLED", "LASER"];
const SLIDE: [&str; 6] = ["LCD", "SLIDE", "DISPLAY", "PANEL", "SLM", "RETICLE"];
const DIFFUSER: [&str; 2] = ["DIFFUSER", "SCREEN"];
const MIRROR: [&str; 2] = ["MIRROR", "REFLECTOR"];
const PLATE: [&str; 7] = ["COMBINER", "PLATE", "WINDOW", "WINDSHIELD", "WINDSCREEN", "BEAMSPLITTER", "SPLITTER"];
const LENS: [&str; 8] = ["LENS", "PRISM", "DOUBLET", "COLLIMATOR", "CONDENSER", "OBJECTIVE", "BALL", "SINGLET"];

/// The role that `name` suggests. What holds a thing is named after it (`LED_PCB`, `LCD_BEZEL`), so mechanics come first.
pub fn role(name: &str) -> Role {
    let upper = name.to_uppercase();
    let words: Vec<&str> = upper.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let any = |list: &[&str]| {
        words.iter().any(|word| {
            let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
            list.contains(&stem) || stem.strip_suffix('S').is_some_and(|one| list.contains(&one))
        })
    };
    let glass = glass_in(&words, any(&LENS) || any(&PLATE));
    if any(&MECHANICS) {
        Role::Mechanics
    } else if any(&LAMP) {
        Role::Lamp
    } else if any(&SLIDE) {
        Role::Slide
    } else if any(&DIFFUSER) {
        Role::Diffuser
    } else if any(&MIRROR) {
        Role::Mirror
    } else if any(&PLATE) {
        Role::Plate(glass)
    } else if any(&LENS) || glass.is_some() {
        Role::Lens(glass)
    } else {
        Role::Mechanics
    }
}

/// A catalogue glass among the words, or spelt by two that follow each other (`N_BK7`).
fn glass_in(words: &[&str], sure: bool) -> Option<&'static str> {
    let pairs = words.windows(2).map(|pair| pair.concat());
    let singles = words.iter().map(|word| (*word).to_owned());
    // Pairs first: `N_F2` is no F2.
    let solid = |word: String| glass::body_in_words(&word, sure);
    pairs.chain(singles).find_map(solid).map(|glass| glass.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_roles_and_glasses() {
        for (name, expected) in [
            ("LENS_01_PMMA", Role::Lens(Some("PMMA"))),
            ("LENS_04_F2", Role::Lens(Some("F2"))),
            ("lens 3 n-bk7", Role::Lens(Some("N-BK7"))),
            ("lens_n_sk16", Role::Lens(Some("N-SK16"))),
            ("lens_N-LAK9", Role::Lens(Some("SCHOTT N-LAK9"))),
            ("bracket N-LAK9", Role::Mechanics),
            ("Lens1", Role::Lens(None)),
            ("COMBINER_PLATE_NBK7", Role::Plate(Some("N-BK7"))),
            ("LED_DIE_3", Role::Lamp),
            ("LED_PCB", Role::Mechanics),
            ("LCD_ACTIVE_AREA", Role::Slide),
            ("LCD_BEZEL", Role::Mechanics),
            ("DIFFUSER_SHEET", Role::Diffuser),
            ("fold_mirror2", Role::Mirror),
            ("Körper 7", Role::Mechanics),
            ("", Role::Mechanics),
        ] {
            assert_eq!(role(name), expected, "{name}");
        }
    }
}
