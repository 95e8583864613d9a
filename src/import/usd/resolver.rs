//! How layers are found and opened: by the library's default rules, but only regular files, with what was opened
//! recorded, and text layers brought into the form that the library's parser knows.

use super::{clips, guard, normalise};
use openusd::ar::{Asset, AssetBuffer, AssetInfo, DefaultResolver, ResolvedPath, Resolver};
use std::borrow::Cow;
use std::io::{Cursor, Error, ErrorKind, Result};
use std::path::{Path, PathBuf};
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

pub(super) struct Normalising {
    inner: DefaultResolver,
    opened: Opened,
}

impl Normalising {
    /// The largest single file; a number that keeps a layer and its values in the memory of one machine.
    const MOST_BYTES: u64 = 4 << 30;

    pub fn new(opened: Opened) -> Self {
        Normalising { inner: DefaultResolver::new(), opened }
    }
}

/// The file itself of `PACKAGE[ENTRY]`.
fn on_disk(path: &str) -> &str {
    let package = path.split_once('[').filter(|_| path.ends_with(']'));
    package.map_or(path, |(package, _)| package)
}

impl Resolver for Normalising {
    fn open_asset(&self, resolved: &ResolvedPath) -> Result<Box<dyn Asset>> {
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
        let asset = self.inner.open_asset(resolved)?;
        self.opened.add(disk, usize::try_from(metadata.len()).unwrap_or(usize::MAX));
        let buffer = asset.into_buffer()?;
        if buffer.starts_with(b"PXR-USDC") || buffer.starts_with(b"PK") {
            let view = buffer.into_shared();
            guard::check(&view).map_err(|what| Error::new(ErrorKind::InvalidData, what))?;
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
        self.inner.create_identifier(asset_path, anchor)
    }
    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.inner.resolve(asset_path)
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
