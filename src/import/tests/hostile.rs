//! Whatever a sidecar or a `--set` says, the answer is a scene or a fault.

use super::built_on;
use crate::testing::assembly;

const SAMPLE: &str = include_str!("../../../samples/hud-direct/hud.optics.toml");
const PARTS: [&str; 6] =
    ["LENS_01_PMMA", "LENS_02_NBK7", "LCD_ACTIVE_AREA", "COMBINER_PLATE_NBK7", "LED_DIE_1", "LED_DIE_2"];
const WORDS: [&str; 24] = [
    "nan",
    "-inf",
    "inf",
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "99999999999999",
    "\"\"",
    "\"none\"",
    "\"**\"",
    "[]",
    "[[]]",
    "{}",
    "true",
    "{ kind = 3 }",
    "[0, 5, 9999999999]",
    "\"inf\"",
    "\"1e400 mm\"",
    "\"lambert\"",
    "[1, 1, 1]",
    "{ fit = {} }",
    "\"fit\"",
    "1.5",
];

/// xorshift: any sequence will do, but always the same.
struct Dice(u64);
impl Dice {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % count as u64) as usize
    }
}

/// The sample without pictures (none are beside a file that does not exist), for the hand-made assembly: it builds.
fn plain() -> String {
    let (before, sky) = SAMPLE.split_once("[sky]").unwrap();
    let (_, after) = sky.split_once("\n\n").unwrap();
    let slide = before.lines().find(|line| line.starts_with("slide =")).unwrap();
    format!("{before}{after}").replace(slide, "emitter = \"none\"").replace("HUD_B", "ROOT")
}

#[test]
fn spoilt_sidecars_are_scenes_or_faults() {
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    let (plain, whole) = (plain(), SAMPLE.replace("HUD_B", "ROOT"));
    let (plain, whole): (Vec<&str>, Vec<&str>) = (plain.lines().collect(), whole.lines().collect());
    let (mut scenes, mut faults) = (0, 0);
    for round in 0..4000 {
        let mut lines: Vec<String> =
            if round % 2 == 0 { &plain } else { &whole }.iter().map(|l| (*l).to_owned()).collect();
        for _ in 0..=dice.below(2) {
            let at = dice.below(lines.len());
            match dice.below(4) {
                0 => drop(lines.remove(at)),
                1 => lines[at] = lines[dice.below(lines.len())].clone(),
                2 => {
                    let word = WORDS[dice.below(WORDS.len())];
                    if let Some((key, _)) = lines[at].split_once('=') {
                        lines[at] = format!("{key}= {word}");
                    }
                }
                _ => {
                    // One value inside a line.
                    let numbers: Vec<usize> =
                        lines[at].match_indices(|c: char| c.is_ascii_digit()).map(|(i, _)| i).collect();
                    if !numbers.is_empty() {
                        let digit = numbers[dice.below(numbers.len())];
                        lines[at].replace_range(digit..=digit, WORDS[dice.below(WORDS.len())]);
                    }
                }
            }
        }
        match built_on(assembly(&PARTS), &lines.join("\n"), &[]) {
            Ok(built) => {
                scenes += 1;
                assert!(built.scene.eye.position.is_finite());
            }
            Err(fault) => {
                faults += 1;
                assert!(!fault.to_string().contains('\n'), "{fault}");
            }
        }
    }
    // Both must occur, or nothing was tried.
    assert!(scenes > 100 && faults > 1000, "{scenes} {faults}");
}

#[test]
fn spoilt_sets_are_scenes_or_faults() {
    let mut dice = Dice(42);
    let text = plain();
    assert!(built_on(assembly(&PARTS), &text, &[]).is_ok());
    let heads = [
        "led",
        "LENS_01_PMMA",
        "LENS_*",
        "**",
        "eye",
        "sky",
        "unit",
        "wavelengths",
        "default",
        "coating.ar",
        "medium",
        "LED_DIE_1.faces[0]",
        "HUD",
        "slide:LCD*",
        "LENS_02_NBK7.faces[99999999999999999999]",
    ];
    let tails = [
        "",
        ".",
        ".flux_lm",
        ".glass",
        ".finish",
        ".finish.sigma_deg",
        ".shape.radius",
        ".stack[0].n",
        ".stack[9]",
        ".stack",
        ".coating.stack[0]",
        ".faces[0].shape",
        ".medium",
        ".emitter",
        ".contrast",
        ".[",
        ".a[",
        ".a[0",
        ".mono_nm",
        ".position[1]",
        ".fov_deg",
        "..",
        ".ä",
        ".kind",
    ];
    for _ in 0..1500 {
        let mut one = || {
            format!(
                "{}{}={}",
                heads[dice.below(heads.len())],
                tails[dice.below(tails.len())],
                WORDS[dice.below(WORDS.len())]
            )
        };
        let sets = [one(), one()];
        if let Err(fault) = built_on(assembly(&PARTS), &text, &[&sets[0], &sets[1]]) {
            assert!(!fault.to_string().contains('\n'), "{sets:?}: {fault}");
        }
    }
}
