//! What a reader has to say, and how much work and memory the files may still ask for.

use crate::gltf::notes::Notes;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{Note, Severity};

/// A few bytes can ask for much: references that multiply, an instancer of instancers, compressed arrays. Everything
/// that can multiply is charged here before it is made.
#[derive(Debug)]
pub(super) struct Ledger {
    pub notes: Notes,
    memory: usize,
    /// Of `memory`, what fine meshes of subdivision surfaces may take whatever the files' size is.
    fine: usize,
    again: usize,
    prims: usize,
}

/// How much memory was taken at a moment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    memory: usize,
    fine: usize,
}

impl Ledger {
    /// Crate files are compressed: index arrays up to 16 times, other data by LZ4. An honest file stays far below this.
    const BYTES_PER_BYTE: usize = 256;
    const LEAST_BYTES: usize = 1 << 26;
    const MOST_BYTES: usize = 3 << 30;
    /// A cage of a few polygons honestly means a hundred thousand: facets on limit surfaces take this much together, and
    /// a mesh no more than a part of what is left.
    const MOST_FINE: usize = 2 << 30;
    const SHARE_OF_FINE: usize = 16;
    /// Meshes that were made and found to be there already, at about 1 GB/s.
    const MOST_AGAIN: usize = 10 << 30;
    /// A prim costs composition about 0.1 ms, and at least this many bytes of a file that does not repeat itself.
    const BYTES_PER_PRIM: usize = 8;
    const LEAST_PRIMS: usize = 50_000;

    pub fn new() -> Self {
        Ledger { notes: Notes::default(), memory: 0, fine: 0, again: 0, prims: 0 }
    }

    /// Takes memory for `count` things of `size` bytes each; `read` bytes of files were read so far.
    pub fn charge(&mut self, at: impl Fn() -> Where, read: usize, count: usize, size: usize) -> Result<()> {
        let most = read.saturating_mul(Self::BYTES_PER_BYTE).saturating_add(Self::LEAST_BYTES).min(Self::MOST_BYTES);
        let most = most.saturating_add(self.fine);
        self.memory = self.memory.saturating_add(count.saturating_mul(size));
        if self.memory <= most {
            return Ok(());
        }
        Err(Error::new(at(), "the asset repeats itself into more memory than it can honestly need")
            .expected(format!("at most {most} bytes for {read} bytes of files")))
    }

    /// What the next fine mesh may take.
    pub fn fine_share(&self) -> usize {
        Self::MOST_FINE.saturating_sub(self.fine) / Self::SHARE_OF_FINE
    }
    /// Allows a fine mesh of `bytes`, no more than its share.
    pub fn allow_fine(&mut self, bytes: usize) {
        self.fine = self.fine.saturating_add(bytes.min(self.fine_share()));
    }

    /// How much is taken, for [`give_back`](Self::give_back).
    pub fn taken(&self) -> Taken {
        Taken { memory: self.memory, fine: self.fine }
    }
    /// Gives back what was taken since [`taken`](Self::taken) said `mark`: it was made and thrown away.
    pub fn release(&mut self, mark: Taken) {
        self.memory = self.memory.min(mark.memory);
        self.fine = self.fine.min(mark.fine);
    }
    /// [`release`](Self::release) of what was made once more, which takes time.
    pub fn give_back(&mut self, at: impl Fn() -> Where, mark: Taken) -> Result<()> {
        self.again = self.again.saturating_add(self.memory.saturating_sub(mark.memory));
        self.release(mark);
        if self.again <= Self::MOST_AGAIN {
            return Ok(());
        }
        let most = Self::MOST_AGAIN;
        Err(Error::new(at(), format!("the asset repeats {} bytes of meshes that are the same", self.again))
            .expected(format!("at most {most}; `instanceable = true` on what repeats reads them once")))
    }

    /// Takes one composed prim.
    pub fn prim(&mut self, at: impl Fn() -> Where, read: usize) -> Result<()> {
        let most = (read / Self::BYTES_PER_PRIM).saturating_add(Self::LEAST_PRIMS);
        self.prims += 1;
        if self.prims <= most {
            return Ok(());
        }
        Err(Error::new(at(), "the asset repeats itself into more prims than it can honestly need")
            .expected(format!("at most {most} prims for {read} bytes of files")))
    }

    pub fn info(&mut self, at: Where, text: impl Into<String>) {
        self.notes.add_many(Severity::Info, at, text, 1);
    }
    pub fn warn(&mut self, at: Where, text: impl Into<String>) {
        self.notes.add_many(Severity::Warning, at, text, 1);
    }
    /// A warning that is about something.
    pub fn warn_of(&mut self, code: Code, at: Where, text: impl Into<String>) {
        self.notes.add(Note::warning(at, text).code(code), 1);
    }
}
