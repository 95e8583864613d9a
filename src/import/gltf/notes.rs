//! What a reader has to say, once per kind with a count and the first place; and how much memory it may still use.

use super::at::At;
use eyebox_base::{Code, Error, Where, error::Result};
use eyebox_scene::{Note, Severity};
use std::collections::HashMap;

#[derive(Debug, Default)]
pub(crate) struct Notes {
    entries: Vec<(Note, usize)>,
    by_text: HashMap<String, usize>,
}

impl Notes {
    /// Adds `count` cases of `text`, the first of them at `at`.
    pub fn add_many(&mut self, severity: Severity, at: Where, text: impl Into<String>, count: usize) {
        self.add(Note::new(severity, at, text), count);
    }
    /// The same of a note that is made already.
    pub fn add(&mut self, note: Note, count: usize) {
        if let Some((_, total)) = self.by_text.get(&note.text).and_then(|&i| self.entries.get_mut(i)) {
            *total += count;
            return;
        }
        self.by_text.insert(note.text.clone(), self.entries.len());
        self.entries.push((note, count));
    }
    pub(super) fn info(&mut self, at: &At<'_>, text: impl Into<String>) {
        self.add_many(Severity::Info, at.place(), text, 1);
    }
    pub(super) fn warn(&mut self, at: &At<'_>, text: impl Into<String>) {
        self.add_many(Severity::Warning, at.place(), text, 1);
    }
    /// A warning that is about something.
    pub(super) fn warn_of(&mut self, code: Code, at: &At<'_>, text: impl Into<String>) {
        self.add(Note::warning(at.place(), text).code(code), 1);
    }
    /// All notes in the order of their first place.
    pub fn finish(self) -> Vec<Note> {
        let finish = |(note, count): (Note, usize)| match count {
            0 | 1 => note,
            _ => Note { text: format!("{} ({count} places, first here)", note.text), ..note },
        };
        self.entries.into_iter().map(finish).collect()
    }
}

/// A few bytes of a file can ask for much memory (ten thousand primitives over the same accessor, a chain of nodes
/// whose paths grow quadratically), so everything that can multiply is charged here before it is made.
#[derive(Debug)]
pub(super) struct Budget {
    left: usize,
}

impl Budget {
    /// An honest file makes about 2 to 20 bytes in memory per byte; one whose parts repeat the same geometry without
    /// sharing the mesh may make some dozens of copies of it.
    const BYTES_PER_BYTE: usize = 64;
    const FLOOR: usize = 1 << 24;

    /// The budget for an asset of `bytes` bytes, buffers included.
    pub fn new(bytes: usize) -> Self {
        Budget { left: bytes.saturating_mul(Self::BYTES_PER_BYTE).saturating_add(Self::FLOOR) }
    }
    /// Bytes that may still be used.
    pub fn left(&self) -> usize {
        self.left
    }
    /// Allows `bytes` more: what was decoded from the file is input, too.
    pub fn grow(&mut self, bytes: usize) {
        self.left = self.left.saturating_add(bytes);
    }
    /// Takes `count` things of `size` bytes each.
    pub fn charge(&mut self, at: &At<'_>, count: usize, size: usize) -> Result<()> {
        let left = count.checked_mul(size).and_then(|bytes| self.left.checked_sub(bytes));
        self.left = left.ok_or_else(|| -> Box<Error> {
            at.fault("the file repeats itself into more memory than it can honestly need")
                .expected(format!("at most {} bytes per byte of the file", Self::BYTES_PER_BYTE))
        })?;
        Ok(())
    }
}

/// What is collected while reading.
#[derive(Debug)]
pub(super) struct Ledger {
    pub notes: Notes,
    pub budget: Budget,
}
