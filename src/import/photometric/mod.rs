//! Photometric files → [`LuminousProfile`]: IES LM-63 and EULUMDAT, with the candela that they state.
//!
//! Written here because no crate did (searched in 2026): `lidrs` 0.2.1 (2022) gave 0 cd for a valid file, `eulumdat` 0.7
//! is under the AGPL, leaves out ballast factors and turns Isym 3 round.

mod ies;
mod ldt;
mod planes;
#[cfg(test)]
mod tests;
mod text;

use crate::files;
use eyebox_base::error::Result;
use eyebox_base::{Code, Where};
use eyebox_scene::Note;
use eyebox_scene::profile::{LuminousProfile, ProfileFacts};
use glam::DMat3;
use std::path::{Path, PathBuf};

/// Reads a file that a photometric file names.
pub type Files<'a> = &'a dyn Fn(&Path, &Where) -> Result<Vec<u8>>;

/// The most bytes of a photometric file: real ones have some kilobytes, at 0.1° some megabytes.
const MOST_BYTES: u64 = 1 << 26;

/// The profile in `file`, named at `at`: EULUMDAT if it is called so (`.ldt`, `.eul`), else LM-63.
///
/// # Errors
/// A file that is not there, too large or not a photometric file, by the line that is wrong.
pub fn profile(file: &Path, at: &Where, notes: &mut Vec<Note>) -> Result<LuminousProfile> {
    parse(file, &small(file, at)?, &small, notes)
}

/// The profile in these bytes of `file`; `files` reads what it names in turn (a TILT file).
///
/// # Errors
/// As [`profile`].
pub fn parse(file: &Path, bytes: &[u8], files: Files<'_>, notes: &mut Vec<Note>) -> Result<LuminousProfile> {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("ldt" | "eul") => ldt::read(file, bytes),
        Some(_) | None => ies::read(file, bytes, files, notes),
    }
}

/// The file that a profile names for its lamps' tilt, if it does: for lists of what is needed.
pub fn tilt_file(file: &Path) -> Option<PathBuf> {
    let bytes = small(file, &Where::Nowhere).ok()?;
    let lines = text::Lines::new(file, &bytes);
    let name = lines.iter().find_map(|(_, line)| text::tilt(line).map(str::to_owned))?;
    let own = !name.is_empty() && !["NONE", "INCLUDE"].contains(&name.to_ascii_uppercase().as_str());
    own.then(|| file.parent().unwrap_or(Path::new("")).join(name))
}

/// The bytes of a regular file of reasonable size.
fn small(file: &Path, at: &Where) -> Result<Vec<u8>> {
    files::read_at_most(file, at, "light profile", (MOST_BYTES, Code::ProfileMissing))
}

/// The grid of planes (deg, candela); none if it is dark or not finite.
fn grid(
    file: &Path,
    axes: DMat3,
    planes: Vec<(f64, Vec<f64>)>,
    gamma_deg: &[f64],
    facts: ProfileFacts,
) -> Option<LuminousProfile> {
    let profile = LuminousProfile {
        file: file.display().to_string(),
        axes,
        c_rad: planes.iter().map(|(c, _)| c.to_radians()).collect(),
        gamma_rad: gamma_deg.iter().map(|gamma| gamma.to_radians()).collect(),
        candela: planes.into_iter().flat_map(|(_, row)| row).collect(),
        facts,
    };
    let flux = profile.flux_lm();
    (flux > 0.0 && flux.is_finite()).then_some(profile)
}
