//! Binding, building and their faults on assemblies made by hand.

mod binding;
mod colour;
mod faults;
mod hostile;
mod lamps;
mod samples;
mod scenes;
mod sets;
mod skies;
mod table;

use super::testing::assembly;
use super::{Assembly, Built, Set, build, toml};
use eyebox_base::error::Result;
use std::path::Path;

/// A sidecar that builds; tests append to it, beginning with line 10.
pub const BASE: &str = "schema = 1
wavelengths = { mono_nm = 550 }
[eye]
position = [\"0 mm\", \"0 mm\", \"0 mm\"]
look = [0, 0, -1]
up = [0, 1, 0]
fov_deg = 12
[default]
finish = \"absorber\"
";

/// `text` appended to [`BASE`], for parts LENS, LED_1, LED_2 and LCD.
pub fn built(text: &str, sets: &[&str]) -> Result<Built> {
    built_on(assembly(&["LENS", "LED_1", "LED_2", "LCD"]), &format!("{BASE}{text}"), sets)
}

pub fn built_on(assembly: Assembly, text: &str, sets: &[&str]) -> Result<Built> {
    let sidecar = toml::parse(text, Path::new("hud.optics.toml"))?;
    let sets = sets.iter().map(|text| Set::parse(text)).collect::<Result<Vec<_>>>()?;
    build(assembly, Some(&sidecar), &sets)
}

/// The message of the fault that `text` appended to [`BASE`] is.
pub fn fault(text: &str, sets: &[&str]) -> String {
    match built(text, sets) {
        Ok(_) => "no fault".to_owned(),
        Err(fault) => fault.to_string(),
    }
}

/// Checks rows of (appended text, sets, message), all of them before it fails.
pub fn check(rows: &[(&str, &[&str], &str)]) {
    let wrong: Vec<String> = rows
        .iter()
        .filter_map(|(text, sets, expected)| {
            let found = fault(text, sets);
            (found != *expected).then(|| format!("{text} {sets:?}\n  expected {expected}\n  found    {found}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
