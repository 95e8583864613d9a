//! What is validated where a folder is named: every sidecar in it, and every asset that none of these names and that is no
//! layer of another. A layer that only holds materials is no asset, and whatever is wrong in it is found through the asset
//! that it belongs to.

use eyebox_base::{Error, Result, Where};
use eyebox_import::{files, toml};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const SIDECAR: &str = ".optics.toml";
const ASSETS: [&str; 6] = ["glb", "gltf", "usd", "usda", "usdc", "usdz"];

/// What is to be validated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expanded {
    pub files: Vec<PathBuf>,
    /// Files of folders that are left out because they are layers of others.
    pub layers: usize,
}

/// Files as they are named, folders as what stands in them. Faults: a folder without any asset, or one that can't be
/// read.
pub fn expand(named: &[PathBuf]) -> Result<Expanded> {
    let mut all = Expanded::default();
    for path in named {
        if !path.is_dir() {
            all.files.push(path.clone());
            continue;
        }
        let found = inside(path)?;
        if found.files.is_empty() {
            return Err(Error::new(Where::file(path), "there is no asset and no sidecar in this folder")
                .expected(format!("*{SIDECAR} or .{}", ASSETS.join(", ."))));
        }
        all.files.extend(found.files);
        all.layers += found.layers;
    }
    Ok(all)
}

fn inside(folder: &Path) -> Result<Expanded> {
    let (mut sidecars, mut assets) = (Vec::new(), Vec::new());
    let mut left = vec![folder.to_owned()];
    while let Some(next) = left.pop() {
        let fault = |error: std::io::Error| Error::new(Where::file(&next), format!("cannot be read: {error}"));
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
    let (subjects, mut assets): (Vec<PathBuf>, Vec<PathBuf>) =
        assets.into_iter().partition(|asset| taken.contains(&real(asset)));
    let found = assets.len();
    assets.sort();
    let assets = without_layers(&subjects, assets);
    let layers = found - assets.len();
    let mut files = [sidecars, assets].concat();
    files.sort();
    Ok(Expanded { files, layers })
}

/// Of `assets`, sorted, those that are no layer of another or of one of the `subjects` of sidecars. Of layers that name
/// each other and that nothing else names, the first stays.
fn without_layers(subjects: &[PathBuf], assets: Vec<PathBuf>) -> Vec<PathBuf> {
    // Nothing but USD is made of other assets, and reading it takes its time.
    if subjects.iter().chain(&assets).filter(|asset| is_usd(asset)).count() < 2 {
        return assets;
    }
    let below: Vec<BTreeSet<PathBuf>> = assets.iter().map(|asset| layers(asset)).collect();
    let places: Vec<PathBuf> = assets.iter().map(|asset| real(asset)).collect();
    let mut known: BTreeSet<PathBuf> = subjects.iter().flat_map(|subject| layers(subject)).collect();
    let mut stays = vec![false; assets.len()];
    // First what nothing names, then what is left: rings.
    for is_ring in [false, true] {
        for (index, place) in places.iter().enumerate() {
            let is_named = || below.iter().enumerate().any(|(other, names)| other != index && names.contains(place));
            if known.contains(place) || stays[index] || (!is_ring && is_named()) {
                continue;
            }
            stays[index] = true;
            // What a layer names is its asset's too, whether or not composition got there.
            let mut left = vec![index];
            while let Some(next) = left.pop() {
                let new =
                    |at: &usize| *at != index && below[next].contains(&places[*at]) && !known.contains(&places[*at]);
                let new: Vec<usize> = (0..places.len()).filter(new).collect();
                known.extend(new.iter().map(|at| places[*at].clone()));
                left.extend(new);
            }
        }
    }
    let mut stays = stays.into_iter();
    assets.into_iter().filter(|_| stays.next().unwrap_or(true)).collect()
}

fn is_usd(path: &Path) -> bool {
    path.extension().is_some_and(|own| own.to_string_lossy().to_lowercase().starts_with("usd"))
}

/// The other files that a stage is composed of; none if it can't be read, or is none.
fn layers(asset: &Path) -> BTreeSet<PathBuf> {
    if !is_usd(asset) {
        return BTreeSet::new();
    }
    let own = real(asset);
    let named = eyebox_import::asset(asset).map(|assembly| assembly.dependencies).unwrap_or_default();
    named.iter().map(|file| real(file)).filter(|file| *file != own).collect()
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
        assert_eq!((found.files, found.layers), (wanted.map(at).to_vec(), 0));
        let fault = expand(&[at("empty")]).unwrap_err().to_string();
        assert!(fault.contains("no asset and no sidecar"), "{fault}");
    }

    /// A layer with this above its prims; a mesh in it if it is a whole asset.
    fn layer(metadata: &str, prims: &str) -> String {
        format!("#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n{metadata})\n\n{prims}\n")
    }

    #[test]
    fn layers_are_read_through_the_asset_that_names_them() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        let write = |name: &str, text: String| std::fs::write(at(name), text).unwrap();
        let found = || {
            let found = expand(&[root.path().to_owned()]).unwrap();
            let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
            (found.files.iter().map(name).collect::<Vec<_>>(), found.layers)
        };
        write("looks.usda", layer("", "def Scope \"Looks\"\n{\n}"));
        write("lens.usda", layer("    defaultPrim = \"L\"\n    subLayers = [@looks.usda@]\n", "def Xform \"L\"\n{\n}"));
        write("far.usda", layer("    defaultPrim = \"F\"\n", "def Xform \"F\"\n{\n}"));
        let arcs = "def \"A\" (\n    references = @lens.usda@\n)\n{\n}\ndef \"B\" (\n    payload = @far.usda@\n)\n{\n}";
        write("all.usda", layer("", arcs));
        write("alone.usda", layer("", "def Xform \"X\"\n{\n}"));
        assert_eq!(found(), (vec!["all.usda".to_owned(), "alone.usda".to_owned()], 3));
        // Named outright it is an asset; a sidecar's asset has layers as well.
        assert_eq!(expand(&[at("looks.usda")]).unwrap(), Expanded { files: vec![at("looks.usda")], layers: 0 });
        write("hud.optics.toml", "asset = \"all.usda\"".to_owned());
        assert_eq!(found(), (vec!["alone.usda".to_owned(), "hud.optics.toml".to_owned()], 3));
        // What can't be read names nothing; what names each other is not lost.
        write("all.usda", "#usda 1.0\n(".to_owned());
        write("far.usda", layer("    subLayers = [@alone.usda@]\n", ""));
        write("alone.usda", layer("    subLayers = [@far.usda@]\n", ""));
        assert_eq!(found(), (["alone.usda", "hud.optics.toml", "lens.usda"].map(str::to_owned).to_vec(), 2));
    }
}
