//! `render --shard`, `--checkpoint` and `--resume`: a part of a run, and a run that survives its end.

use super::progress::Progress;
use crate::base::{Error, Result, Where};
use crate::estimate::run::{Films, Observer, Status};
use crate::estimate::shard::{Head, load, save};
use crate::film::frame::Frame;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// I/N of `--shard`.
pub fn parse_shard(text: &str) -> std::result::Result<[u64; 2], String> {
    let bad = || format!("`{text}` is no shard; write I/N with I from 1 to N, e.g. 3/7");
    let (index, count) = text.split_once('/').ok_or_else(bad)?;
    match (index.trim().parse(), count.trim().parse()) {
        (Ok(index), Ok(count)) if index >= 1 && index <= count => Ok([index, count]),
        (_, _) => Err(bad()),
    }
}

/// Where the checkpoint of `hud.exr` lies: `hud.checkpoint.exr`.
pub fn checkpoint_of(output: &Path) -> PathBuf {
    output.with_extension("checkpoint.exr")
}

/// What a checkpoint has, if there is one. Errors: a file that is no checkpoint, or one of another run.
pub fn resume(output: &Path, mine: &dyn Fn(&Head) -> Result<(), String>) -> Result<Option<(Head, Films)>> {
    let path = checkpoint_of(output);
    remove_halves(&path);
    remove_halves(output);
    if !path.exists() {
        return Ok(None);
    }
    let (head, films, _) = load(&path)?;
    mine(&head).map_err(|what| {
        Error::new(Where::file(&path), format!("is of another run: {what}"))
            .expected("the same asset and options, or no file of this name")
    })?;
    Ok(Some((head, films)))
}

/// A process that was killed while it wrote leaves a file under a temporary name.
fn remove_halves(path: &Path) {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let prefix = format!("{}.tmp", name.to_string_lossy());
    let Ok(files) = std::fs::read_dir(folder) else { return };
    for file in files.flatten().filter(|file| file.file_name().to_string_lossy().starts_with(&prefix)) {
        // What cannot be removed does no harm.
        let _ = std::fs::remove_file(file.path());
    }
}

/// Shows progress and writes a checkpoint every now and then.
pub struct Saver<'p> {
    pub progress: &'p mut Progress,
    pub head: Head,
    pub path: PathBuf,
    pub every: Option<Duration>,
    pub last: Instant,
}

impl Saver<'_> {
    fn save(&mut self, films: &Films) {
        let [width, height] = self.head.finishing.size;
        if let Err(fault) = save(&self.path, &self.head, films, &Frame::new(width, height)) {
            tell!("eyebox: warning: {fault}; the last checkpoint stays");
        }
        self.last = Instant::now();
    }

    /// A run that was interrupted keeps its last passes.
    pub fn interrupted(&mut self, films: &Films) {
        if self.every.is_some() {
            self.save(films);
        }
    }
}

impl Observer for Saver<'_> {
    fn block(&mut self, status: &Status, films: &Films) -> bool {
        if self.every.is_some_and(|every| self.last.elapsed() >= every) {
            self.save(films);
        }
        self.progress.block(status, films)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_named_from_one() {
        assert_eq!(parse_shard("3/7"), Ok([3, 7]));
        assert_eq!(parse_shard(" 1 / 1 "), Ok([1, 1]));
        for bad in ["0/7", "8/7", "3", "3/0", "a/b", "-1/2", "1/2/3", ""] {
            assert!(parse_shard(bad).unwrap_err().contains("e.g. 3/7"), "{bad}");
        }
        assert_eq!(checkpoint_of(Path::new("a/hud.0012.exr")), Path::new("a/hud.0012.checkpoint.exr"));
    }
}
