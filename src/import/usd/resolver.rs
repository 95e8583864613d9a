//! How layers are found and opened: by the library's default rules, but only regular files, with what was opened
//! recorded, and text layers brought into the form that the library's parser knows.

use super::texture::TILE;
use super::xml::Element;
use super::{clips, crate_limits, mtlx, normalise, xml};
use eyebox_base::package;
use openusd::ar::{Asset, AssetBuffer, AssetInfo, DefaultResolver, ResolvedPath, Resolver};
use std::borrow::Cow;
use std::io::{Cursor, Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

/// What was opened so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Opened(Arc<Mutex<Record>>);

#[derive(Debug, Default)]
struct Record {
    files: Vec<PathBuf>,
    bytes: usize,
}

impl Opened {
    /// Bytes of all files so far.
    pub fn bytes(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).bytes
    }
    /// The files in the order of their first opening.
    pub fn files(&self) -> Vec<PathBuf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).files.clone()
    }
    fn add(&self, path: &Path, bytes: usize) {
        let mut record = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !record.files.iter().any(|known| known == path) {
            record.files.push(path.to_owned());
            record.bytes = record.bytes.saturating_add(bytes);
        }
    }
}

#[derive(Clone)]
pub(super) struct Normalising {
    inner: Rc<DefaultResolver>,
    opened: Opened,
}

impl Normalising {
    /// The largest single file; a number that keeps a layer and its values in the memory of one machine.
    const MOST_BYTES: u64 = 4 << 30;

    pub fn new(opened: Opened) -> Self {
        Normalising { inner: Rc::new(DefaultResolver::new()), opened }
    }

    /// The name of the package that is the first file of a package.
    fn first_package(&self, resolved: &ResolvedPath) -> Option<String> {
        let path = resolved.to_string_lossy();
        let is_package = |name: &str| name.trim_end_matches(']').to_ascii_lowercase().ends_with(".usdz");
        if !is_package(&path) || !std::fs::metadata(on_disk(&path)).is_ok_and(|found| found.is_file()) {
            return None;
        }
        // The first local header of a ZIP file (APPNOTE.TXT 4.3.7): the name's length is at 26, the name at 30.
        let mut asset = self.inner.open_asset(resolved).ok()?;
        let mut header = [0; 30];
        asset.read_exact(&mut header).ok()?;
        if !header.starts_with(b"PK\x03\x04") {
            return None;
        }
        let mut name = vec![0; usize::from(u16::from_le_bytes([header[26], header[27]]))];
        asset.read_exact(&mut name).ok()?;
        let name = String::from_utf8(name).ok()?;
        (is_package(&name) && !name.contains(['[', ']'])).then_some(name)
    }

    /// A MaterialX file with what it includes (XInclude 1.0, of whole files).
    fn materialx(&self, bytes: &[u8], own: &ResolvedPath, depth: usize) -> std::result::Result<Element, String> {
        // Files that include files.
        const MOST_DEEP: usize = 8;
        let text = std::str::from_utf8(bytes).map_err(|_| "it is no UTF-8".to_owned())?;
        let mut root = xml::parse(text)?;
        let includes: Vec<Element> = root.children.extract_if(.., |child| child.name == "xi:include").collect();
        for include in includes {
            let href = include.attribute("href").unwrap_or_default();
            if depth >= MOST_DEEP {
                return Err(format!("it includes files more than {MOST_DEEP} deep: {href}"));
            }
            let found = self.inner.resolve(&self.inner.create_identifier(href, Some(own)));
            let found = found.ok_or_else(|| format!("the file {href} that it includes is not there"))?;
            let bytes = self.raw(&found).map_err(|error| format!("the file {href} that it includes: {error}"))?;
            let inner = self.materialx(&bytes, &found, depth + 1).map_err(|what| format!("{href}: {what}"))?;
            root.children.extend(inner.children);
        }
        Ok(root)
    }

    /// The bytes of a file as they are.
    ///
    /// # Errors
    /// What is no regular file, or too large.
    pub fn raw(&self, resolved: &ResolvedPath) -> Result<AssetBuffer> {
        let own = mtlx_of(resolved);
        let resolved = own.as_ref().unwrap_or(resolved);
        let path = resolved.to_string_lossy();
        let disk = Path::new(on_disk(&path));
        // A device or a pipe has no end.
        let metadata = std::fs::metadata(disk)?;
        if !metadata.is_file() {
            return Err(Error::new(ErrorKind::InvalidInput, "this is no regular file"));
        }
        if metadata.len() > Self::MOST_BYTES {
            return Err(Error::new(ErrorKind::InvalidInput, "the file is larger than 4 GiB"));
        }
        let buffer = self.inner.open_asset(resolved)?.into_buffer()?;
        self.opened.add(disk, usize::try_from(metadata.len()).unwrap_or(usize::MAX));
        Ok(buffer)
    }
}

/// What the library takes a MaterialX file for: it chooses formats by the ends of names.
const AS_LAYER: &str = ".usda";

/// The name under which a MaterialX file is opened as a layer; none of other files. The end goes before the brackets of
/// packages.
fn as_layer(resolved: &ResolvedPath) -> Option<ResolvedPath> {
    let path = resolved.to_str()?;
    let own = path.trim_end_matches(']');
    let is_one = own.len() > MTLX.len() && own.get(own.len() - MTLX.len()..)?.eq_ignore_ascii_case(MTLX);
    is_one.then(|| ResolvedPath::new(format!("{own}{AS_LAYER}{}", path.get(own.len()..).unwrap_or_default())))
}

const MTLX: &str = ".mtlx";

/// The MaterialX file that is opened under this name.
fn mtlx_of(resolved: &ResolvedPath) -> Option<ResolvedPath> {
    let path = resolved.to_str()?;
    let outer = path.trim_end_matches(']');
    let own = ResolvedPath::new(format!("{}{}", outer.strip_suffix(AS_LAYER)?, path.get(outer.len()..)?));
    as_layer(&own).is_some().then_some(own)
}

/// The file itself of `PACKAGE[ENTRY]`.
fn on_disk(path: &str) -> &str {
    let package = path.split_once('[').filter(|_| path.ends_with(']'));
    package.map_or(path, |(package, _)| package)
}

impl Resolver for Normalising {
    fn open_asset(&self, resolved: &ResolvedPath) -> Result<Box<dyn Asset>> {
        let buffer = self.raw(resolved)?;
        if let Some(own) = mtlx_of(resolved) {
            let invalid = |what| Error::new(ErrorKind::InvalidData, what);
            let root = self.materialx(&buffer, &own, 0).map_err(invalid)?;
            return Ok(Box::new(Cursor::new(AssetBuffer::from(mtlx::layer(&root).map_err(invalid)?.into_bytes()))));
        }
        if buffer.starts_with(b"PXR-USDC") || buffer.starts_with(b"PK") {
            let named = package::with_names_in_utf8(&buffer);
            let view = named.map_or(buffer, AssetBuffer::from).into_shared();
            crate_limits::check(&view).map_err(|what| Error::new(ErrorKind::InvalidData, what))?;
            return Ok(Box::new(Cursor::new(AssetBuffer::Shared(view))));
        }
        if !buffer.starts_with(b"#usda") && !buffer.starts_with(b"#sdf") {
            return Ok(Box::new(Cursor::new(buffer)));
        }
        clips::check(&buffer).map_err(|what| Error::new(ErrorKind::InvalidData, what))?;
        match normalise::layer(&buffer).map_err(|what| Error::new(ErrorKind::InvalidData, what))? {
            Cow::Borrowed(_) => Ok(Box::new(Cursor::new(buffer))),
            Cow::Owned(text) => Ok(Box::new(Cursor::new(AssetBuffer::from(text)))),
        }
    }

    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.inner.create_identifier(&normalise::meant(asset_path), anchor)
    }
    /// A package whose first file is a package stands for that one, as in usd-core.
    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        if asset_path.matches('[').count() > package::MOST_NESTED {
            return None;
        }
        let meant = normalise::meant(asset_path);
        if meant.contains(TILE) {
            // Where the first of the tiles is; the name keeps standing for all.
            let tiles = (1001..=1100).map(|number: u32| (number.to_string(), meant.replace(TILE, &number.to_string())));
            let found = tiles.into_iter().find_map(|(number, tile)| Some((number, self.inner.resolve(&tile)?)));
            let (number, found) = found?;
            let path = found.to_str()?;
            let (before, after) = path.rsplit_once(&number)?;
            return Some(ResolvedPath::new(format!("{before}{TILE}{after}")));
        }
        let mut found = self.inner.resolve(&meant)?;
        for _ in 0..package::MOST_NESTED {
            let Some(inner) = self.first_package(&found) else { return Some(as_layer(&found).unwrap_or(found)) };
            let path = found.to_string_lossy();
            let outer = path.trim_end_matches(']');
            let closing = path.get(outer.len()..).unwrap_or_default();
            found = ResolvedPath::new(format!("{outer}[{inner}]{closing}"));
        }
        None
    }
    /// Nothing is written here.
    fn resolve_for_new_asset(&self, _asset_path: &str) -> Option<ResolvedPath> {
        None
    }
    fn get_extension<'a>(&self, asset_path: &'a str) -> &'a str {
        self.inner.get_extension(asset_path)
    }
    fn is_context_dependent_path(&self, asset_path: &str) -> bool {
        self.inner.is_context_dependent_path(asset_path)
    }
    fn in_memory_identifier<'a>(&self, asset_path: &'a str) -> Cow<'a, str> {
        self.inner.in_memory_identifier(asset_path)
    }
    fn get_asset_info(&self, asset_path: &str, resolved: &ResolvedPath) -> AssetInfo {
        self.inner.get_asset_info(asset_path, resolved)
    }
    fn get_modification_timestamp(&self, asset_path: &str, resolved: &ResolvedPath) -> Option<SystemTime> {
        self.inner.get_modification_timestamp(asset_path, resolved)
    }
    fn identity(&self) -> String {
        self.inner.identity()
    }
    fn cache_id(&self) -> Option<u64> {
        self.inner.cache_id()
    }
}
