//! What makes a finding the same one in a later version of the asset: its rule, its file, the thing in the file, and what
//! is said of it; not its line, which moves with every line above it.

use super::Located;
use eyebox_base::relative_path::{folder_of, placed, relative, slashed};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Stamps all findings about one asset.
pub fn stamp(all: &mut [Located]) {
    let stamps = stamps(all, |finding| finding.place.file.clone());
    for (finding, stamp) in all.iter_mut().zip(stamps) {
        finding.fingerprint = stamp;
    }
}

/// The fingerprints of these findings if files are named as seen from `folder`: the same from any working directory.
pub fn seen_from(folder: &Path, all: &[Located]) -> Vec<String> {
    stamps(all, |finding| file_from(folder, finding))
}

/// The file of a finding as seen from `folder`.
pub fn file_from(folder: &Path, finding: &Located) -> String {
    slashed(&relative(folder, Path::new(&finding.place.file)))
}

/// Equal findings are told apart by their order.
fn stamps(all: &[Located], file_of: impl Fn(&Located) -> String) -> Vec<String> {
    let mut counts = HashMap::<String, usize>::new();
    let stamp = |finding: &Located| {
        let (place, file) = (&finding.place, file_of(finding));
        let mut key = String::new();
        for piece in [
            finding.rule.code,
            &file,
            place.part.as_deref().unwrap_or_default(),
            place.logical.as_deref().unwrap_or_default(),
            &finding.lasting,
        ] {
            // Lengths, so that pieces can't run into each other.
            key += &format!("{}:{piece};", piece.len());
        }
        let count = counts.entry(key.clone()).or_default();
        key += &count.to_string();
        *count += 1;
        // 16 bytes are more than enough to tell some thousands apart.
        blake3::hash(key.as_bytes()).to_hex().chars().take(32).collect()
    };
    all.iter().map(stamp).collect()
}

/// An asset by the names that texts about it may use.
pub struct Named {
    /// Its absolute name.
    pub whole: PathBuf,
    /// Its folder as it was named, with a slash behind it; empty for the working directory.
    folder: String,
    /// Its folder in texts, the longest first.
    folders: Vec<String>,
}

impl Named {
    pub fn of(asset: &Path) -> Named {
        let whole = std::path::absolute(asset).unwrap_or_else(|_| asset.to_owned());
        let ended = |folder: &Path| format!("{}/", folder.display()).replace("//", "/");
        let folder = match asset.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => ended(parent),
            Some(_) | None => String::new(),
        };
        let mut folders = [folder_of(&whole), folder_of(&placed(asset))].map(|folder| ended(&folder)).to_vec();
        // Nobody's file is named from the root.
        folders.retain(|folder| folder != "/");
        folders.sort_by_key(|folder| std::cmp::Reverse(folder.len()));
        Named { whole, folder, folders }
    }

    /// A text with files named as the asset was.
    pub fn shown(&self, text: &str) -> String {
        self.with(text, &self.folder)
    }

    /// A text with files named from the asset's folder.
    pub fn lasting(&self, text: &str) -> String {
        self.with(text, "")
    }

    fn with(&self, text: &str, folder: &str) -> String {
        let mut out = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(next) = rest.chars().next() {
            let before = &text[..text.len() - rest.len()];
            let begins = !before.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '/' | '.' | '_' | '-'));
            let own = self.folders.iter().filter(|_| begins).find_map(|own| rest.strip_prefix(own.as_str()));
            if let Some(after) = own {
                out.push_str(folder);
                rest = after;
            } else {
                out.push(next);
                rest = &rest[next.len_utf8()..];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_name_files_from_the_assets_folder() {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().canonicalize().unwrap();
        std::fs::create_dir_all(root.join("a/b")).unwrap();
        let named = Named::of(&root.join("a/b/../hud.gltf"));
        let at = root.display();
        let text = format!("can't read {at}/a/b/../t.png: `../t.png`, nor {at}/a/u.png (x{at}/a/u.png)");
        assert_eq!(named.lasting(&text), format!("can't read t.png: `../t.png`, nor u.png (x{at}/a/u.png)"));
        assert_eq!(
            named.shown(&text),
            format!("can't read {at}/a/b/../t.png: `../t.png`, nor {at}/a/b/../u.png (x{at}/a/u.png)")
        );
        let here = Named::of(Path::new("hud.gltf"));
        assert_eq!(here.shown(&format!("no {}", std::path::absolute("t.png").unwrap().display())), "no t.png");
        let up = Named::of(Path::new("../hud.gltf"));
        assert_eq!(up.shown(&format!("no {}", std::path::absolute("../t.png").unwrap().display())), "no ../t.png");
    }
}
