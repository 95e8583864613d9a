//! A file that is missing is one finding, however many places name it.

use super::refused;
use eyebox_base::relative_path::placed;
use eyebox_base::{Code, Error};
use eyebox_check::finding::Finding;
use eyebox_check::subject::{Needed, Refusal};
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

/// The list of what an asset needs, each file once however its name is spelt.
pub fn once(all: impl IntoIterator<Item = Needed>) -> Vec<Needed> {
    let (mut once, mut missing) = (Vec::<Needed>::new(), HashMap::new());
    for needed in all {
        let index =
            if needed.there { None } else { Some(*missing.entry(collapsed(&needed.file)).or_insert(once.len())) };
        match index.and_then(|index| once.get_mut(index)) {
            Some(other) => other.used |= needed.used,
            None => once.push(needed),
        }
    }
    once
}

/// A fault about a texture that is missing, by the name that the list has for it.
pub fn as_listed(mut fault: Box<Error>, needed: &[Needed]) -> Box<Error> {
    if let Some(file) = texture_of(&fault)
        && let Some(listed) = needed.iter().find(|needed| !needed.there && is_same(&needed.file, &file))
    {
        fault.what = fault.what.replace(&file.display().to_string(), &listed.file.display().to_string());
    }
    fault
}

/// The texture that a fault says to be missing.
pub fn texture_of(fault: &Error) -> Option<PathBuf> {
    let what =
        fault.what.strip_prefix("can't read the texture ").filter(|_| fault.code == Some(Code::TextureMissing))?;
    what.strip_suffix(": there is no such file").map(PathBuf::from)
}

/// Whether two names are of one file, by the folders that are there or by the names alone.
pub fn is_same(a: &Path, b: &Path) -> bool {
    a.file_name() == b.file_name() && (placed(a) == placed(b) || collapsed(a) == collapsed(b))
}

/// A path without `.`, and without `..` behind a folder, which need not be there.
fn collapsed(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for step in path.components() {
        match (step, out.components().next_back()) {
            (Component::ParentDir, Some(Component::Normal(_))) => drop(out.pop()),
            (Component::CurDir, _) => {}
            (Component::ParentDir | Component::Normal(_) | Component::RootDir | Component::Prefix(_), _) => {
                out.push(step);
            }
        }
    }
    out
}

/// The findings of what was refused: of a file that is missing, one, at the place that asked for it first. Textures in the list
/// of what the asset needs are left out: a rule has them from there.
pub fn findings(refusals: &[Refusal], needed: &[Needed]) -> Vec<Finding> {
    let mut found: Vec<(Finding, usize)> = Vec::new();
    for refusal in refusals.iter().filter(|refusal| !needed.iter().any(|needed| refusal.lacks(needed))) {
        let Some(finding) = refused(refusal) else { continue };
        let is_same = |other: &Finding| other.code == finding.code && other.text == finding.text;
        match found.iter_mut().find(|(other, _)| is_of_file(refusal) && is_same(other)) {
            Some((_, places)) => *places += 1,
            None => found.push((finding, 1)),
        }
    }
    let told = |(mut finding, places): (Finding, usize)| {
        if places > 1 {
            finding.text += &format!(" ({places} places, first here)");
        }
        finding
    };
    found.into_iter().map(told).collect()
}

/// Whether the fault is a file's and not that of the place that names it.
fn is_of_file(refusal: &Refusal) -> bool {
    matches!(refusal.code(), Code::FileMissing | Code::TextureMissing | Code::ProfileMissing | Code::SlideImageMissing)
}
