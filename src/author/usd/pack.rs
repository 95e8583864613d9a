//! The files that a layer names, for a package that is to hold them.

use super::layer::{Body, Datum, Layer};
use super::picture::TILE;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where, package};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Renames the files that `layer`, a layer of the file `at`, names to entries `./textures/NAME` of a package; those
/// entries with their bytes, each file once. `known` has the bytes of some that the layer names, whatever is on disk.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn take(
    layer: &mut Layer,
    at: &Path,
    known: &HashMap<String, Arc<Vec<u8>>>,
) -> Result<Vec<(String, Vec<u8>)>> {
    let folder = eyebox_base::relative_path::folder_of(at);
    let mut taken = Taken { known, entries: Vec::new(), by_file: HashMap::new(), names: HashSet::new() };
    for property in layer.prims.iter_mut().flat_map(|prim| &mut prim.properties) {
        match &mut property.body {
            Body::Attribute { value: Some(Datum::Asset(path)), .. } => taken.take(path, &folder, at)?,
            Body::Attribute { value: Some(Datum::Assets(paths)), .. } => {
                for path in paths {
                    taken.take(path, &folder, at)?;
                }
            }
            Body::Attribute { .. } | Body::Connected { .. } | Body::Relationship { .. } => {}
        }
    }
    Ok(taken.entries)
}

struct Taken<'a> {
    known: &'a HashMap<String, Arc<Vec<u8>>>,
    entries: Vec<(String, Vec<u8>)>,
    by_file: HashMap<PathBuf, String>,
    names: HashSet<String>,
}

impl Taken<'_> {
    fn take(&mut self, path: &mut String, folder: &Path, at: &Path) -> Result<()> {
        if path.is_empty() {
            return Ok(());
        }
        if let Some((before, after)) = path.split_once(TILE) {
            *path = self.tiles(before, after);
            return Ok(());
        }
        let file = folder.join(path.as_str());
        // One file may be named in several ways.
        let real = file.canonicalize().unwrap_or_else(|_| file.clone());
        let entry = match (self.by_file.get(&real), self.known.get(path)) {
            (Some(known), _) => known.clone(),
            (None, Some(bytes)) => {
                let entry = self.free(path);
                self.entries.push((entry.clone(), bytes.to_vec()));
                self.by_file.insert(real, entry.clone());
                entry
            }
            (None, None) => {
                let bytes = package::read(&file).map_err(|error| {
                    let what = format!("the package is to hold {}, which cannot be read: {error}", file.display());
                    Error::new(Where::file(at), what)
                })?;
                let entry = self.free(path);
                self.entries.push((entry.clone(), bytes));
                self.by_file.insert(real, entry.clone());
                entry
            }
        };
        *path = format!("./{entry}");
        Ok(())
    }

    /// Takes all tiles of a picture; their names are free already.
    fn tiles(&mut self, before: &str, after: &str) -> String {
        let last = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
        let mut tiles: Vec<_> =
            self.known.iter().filter(|(own, _)| own.starts_with(before) && own.ends_with(after)).collect();
        tiles.sort();
        for (own, bytes) in tiles {
            let entry = format!("textures/{}", last(own));
            if self.names.insert(entry.to_ascii_lowercase()) {
                self.entries.push((entry, bytes.to_vec()));
            }
        }
        format!("./textures/{}{TILE}{after}", last(before))
    }

    /// A name of an entry that no other has, in the letters that travel everywhere.
    fn free(&mut self, path: &str) -> String {
        let last = path.trim_end_matches(']').rsplit(['/', '\\', '[']).next().unwrap_or_default();
        let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
        let last: String = last.trim_start_matches('.').chars().map(plain).collect();
        let last = if last.is_empty() { "file".to_owned() } else { last };
        let mut name = format!("textures/{last}");
        // Some file systems do not tell cases apart.
        let mut number = 1;
        while !self.names.insert(name.to_ascii_lowercase()) {
            number += 1;
            name = format!("textures/{number}_{last}");
        }
        name
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::add;
    use super::super::write;
    use eyebox_base::Where;
    use eyebox_scene::assembly::{Assembly, LightForm, LightSource};
    use eyebox_scene::value::{Data, Value};
    use glam::DAffine3;
    use openusd::sdf::{AbstractData, Path as SdfPath, Value as V};

    /// Two domes and a slide, with two pictures of one name and one that is named twice.
    fn assembly(pictures: [&std::path::Path; 3]) -> Assembly {
        let mut a = Assembly::default();
        for (name, file) in ["a", "b"].into_iter().zip(pictures) {
            let node = add(&mut a, None, name, DAffine3::IDENTITY, None);
            a.lights.push(LightSource {
                name: name.into(),
                node,
                form: LightForm::Dome { scale_cd_m2: 1.0, image: Some(file.to_owned()) },
                kelvin: None,
                color: [1.0; 3],
                profile: None,
                attributes: None,
                at: Where::Nowhere,
            });
        }
        let node = add(&mut a, None, "c", DAffine3::IDENTITY, None);
        let text = Value::new(Data::Text(pictures[2].display().to_string()), Where::Nowhere);
        let slide = Value::new(Data::Table(vec![("image".into(), text)]), Where::Nowhere);
        a.nodes[node].attributes = Some(Value::new(Data::Table(vec![("slide".into(), slide)]), Where::Nowhere));
        a
    }

    #[test]
    fn pictures_are_packed_and_aligned() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two) = (folder.path().join("x y.png"), folder.path().join("sub/x y.png"));
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        std::fs::write(&one, b"the first of the pictures").unwrap();
        std::fs::write(&two, b"the second of the pictures").unwrap();
        let out = folder.path().join("new/a.usdz");
        std::fs::create_dir(folder.path().join("new")).unwrap();
        write(&assembly([&one, &two, &one]), &out).unwrap();
        let bytes = std::fs::read(&out).unwrap();
        for text in ["the first of the pictures", "the second of the pictures"] {
            let places: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(text.as_bytes())).collect();
            assert!(places.len() == 1 && places[0].is_multiple_of(64), "{places:?}");
        }
        let mut archive = openusd::usdz::Archive::open(&out).unwrap();
        assert_eq!(archive.first_layer_name().as_deref(), Some("a.usdc"));
        let data = archive.read("a.usdc").unwrap();
        let mut named: Vec<String> = Vec::new();
        for path in data.spec_paths() {
            if let Ok(Some(V::AssetPath(name))) = data
                .try_field(&SdfPath::new(path.as_str()).unwrap(), "default")
                .map(|found| found.map(|f| f.into_owned()))
            {
                assert!(archive.contains(name.as_str().trim_start_matches("./")), "{}", name.as_str());
                named.push(name.as_str().to_owned());
            }
        }
        named.sort();
        assert_eq!(named, ["./textures/2_x_y.png", "./textures/x_y.png", "./textures/x_y.png"]);
        // From one package into another.
        let entry = folder.path().join("new/a.usdz[textures/x_y.png]");
        let again = folder.path().join("b.usdz");
        write(&assembly([&entry, &two, &entry]), &again).unwrap();
        let mut archive = openusd::usdz::Archive::open(&again).unwrap();
        assert_eq!(&archive.entry("textures/x_y.png").unwrap()[..], b"the first of the pictures");
        std::fs::remove_file(&two).unwrap();
        let fault = write(&assembly([&one, &two, &one]), &out).unwrap_err().to_string();
        assert!(fault.contains("the package is to hold") && fault.contains("x y.png"), "{fault}");
    }
}
