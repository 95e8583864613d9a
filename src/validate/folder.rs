//! What is validated where a folder is named: every sidecar in it, and every asset that none of these names.

use crate::base::{Fault, Result, Where};
use crate::import::{files, toml};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const SIDECAR: &str = ".optics.toml";
const ASSETS: [&str; 6] = ["glb", "gltf", "usd", "usda", "usdc", "usdz"];

/// Files as they are named, folders as what stands in them. Faults: a folder without any asset, or one that can't be
/// read.
pub fn expand(named: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut all = Vec::new();
    for path in named {
        if !path.is_dir() {
            all.push(path.clone());
            continue;
        }
        let found = inside(path)?;
        if found.is_empty() {
            return Err(Fault::new(Where::file(path), "there is no asset and no sidecar in this folder")
                .expected(format!("*{SIDECAR} or .{}", ASSETS.join(", ."))));
        }
        all.extend(found);
    }
    Ok(all)
}

fn inside(folder: &Path) -> Result<Vec<PathBuf>> {
    let (mut sidecars, mut assets) = (Vec::new(), Vec::new());
    let mut left = vec![folder.to_owned()];
    while let Some(next) = left.pop() {
        let fault = |error: std::io::Error| Fault::new(Where::file(&next), format!("cannot be read: {error}"));
        for entry in std::fs::read_dir(&next).map_err(fault)? {
            let entry = entry.map_err(fault)?;
            let name = entry.file_name().to_string_lossy().to_lowercase();
            // Another run's standard input is none of ours.
            if name.starts_with(super::stdin::PREFIX) {
                continue;
            }
            // Hidden folders belong to other programs; a link to a folder may lead back here.
            let kind = entry.file_type().map_err(fault)?;
            let path = if next == Path::new(".") { PathBuf::from(entry.file_name()) } else { entry.path() };
            if kind.is_dir() {
                if !name.starts_with('.') {
                    left.push(path);
                }
            } else if name.ends_with(SIDECAR) {
                sidecars.push(path);
            } else if path.extension().is_some_and(|e| ASSETS.iter().any(|known| e.eq_ignore_ascii_case(known))) {
                assets.push(path);
            }
        }
    }
    let mut taken = BTreeSet::new();
    sidecars.retain(|sidecar| match subject(sidecar) {
        Some(asset) => {
            taken.insert(real(&asset));
            true
        }
        // A sidecar that names no asset is read with the asset beside it, if there is one.
        None => !assets.iter().any(|asset| asset.with_extension("optics.toml") == *sidecar),
    });
    assets.retain(|asset| !taken.contains(&real(asset)));
    let mut all = [sidecars, assets].concat();
    all.sort();
    Ok(all)
}

/// The asset that a sidecar names; none if it can't be told.
fn subject(sidecar: &Path) -> Option<PathBuf> {
    let sheet = toml::read(sidecar).ok()?;
    let asset = sheet.get("asset")?;
    Some(files::resolve(asset.text()?, &asset.at))
}

fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_asset_comes_once_by_the_sidecar_that_names_it() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        std::fs::create_dir_all(at("sub/.git")).unwrap();
        std::fs::create_dir_all(at("empty")).unwrap();
        for (name, text) in [
            ("named.glb", ""),
            ("other.optics.toml", "asset = \"named.glb\""),
            ("night.optics.toml", "asset = \"sub/../named.glb\""),
            ("sub/own.usda", ""),
            ("sub/Beside.GLTF", ""),
            ("sub/Beside.optics.toml", "schema = 1"),
            ("sub/broken.optics.toml", "= ="),
            ("sub/notes.txt", ""),
            ("sub/.git/hidden.glb", ""),
            ("sub/.eyebox-stdin-a1b2c3.gltf", ""),
        ] {
            std::fs::write(at(name), text).unwrap();
        }
        let found = expand(&[root.path().to_owned(), at("named.glb")]).unwrap();
        let wanted = [
            "night.optics.toml",
            "other.optics.toml",
            "sub/Beside.GLTF",
            "sub/broken.optics.toml",
            "sub/own.usda",
            // Named outright: taken as it is.
            "named.glb",
        ];
        assert_eq!(found, wanted.map(at));
        let fault = expand(&[at("empty")]).unwrap_err().to_string();
        assert!(fault.contains("no asset and no sidecar"), "{fault}");
    }
}
