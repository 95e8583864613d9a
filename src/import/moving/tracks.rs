//! Values at one frame after the other, kept from the first frame on at which one of them moves.

use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::motion::{Pose, Vertices};
use glam::DAffine3;
use std::collections::BTreeMap;

/// Memory for all that moves.
#[derive(Debug)]
pub(super) struct Room {
    left: usize,
    frames: usize,
}

impl Room {
    /// Bytes of everything that moves, at all frames: 1000 frames of 130 000 vertices with normals.
    const MOST_BYTES: usize = 3 << 30;

    pub fn new(frames: usize) -> Room {
        Room { left: Self::MOST_BYTES, frames }
    }

    /// Takes memory for a thing that needs so many bytes at each frame.
    fn charge(&mut self, at: &Where, bytes: usize) -> Result<()> {
        let left = bytes.checked_mul(self.frames).and_then(|bytes| self.left.checked_sub(bytes));
        self.left = left.ok_or_else(|| {
            let what =
                format!("moves in more memory than there is for motion: {bytes} bytes at {} frames", self.frames);
            Error::new(at.clone(), what)
                .expected(format!("at most {} bytes for all that moves; `--frame` writes one moment", Self::MOST_BYTES))
        })?;
        Ok(())
    }
}

/// What has a value at each frame.
pub(super) trait Held: Clone {
    fn bytes(&self) -> usize;
}

impl Held for DAffine3 {
    fn bytes(&self) -> usize {
        size_of::<DAffine3>()
    }
}

impl Held for Vertices {
    fn bytes(&self) -> usize {
        (self.positions.len() + self.normals.len()) * size_of::<[f32; 3]>()
    }
}

impl Held for Pose {
    fn bytes(&self) -> usize {
        self.weights.len() * size_of::<f64>() + self.joints.len() * size_of::<DAffine3>()
    }
}

/// By index of the thing: what it is at each frame so far.
#[derive(Debug)]
pub(super) struct Tracks<T>(BTreeMap<usize, Vec<T>>);

impl<T> Default for Tracks<T> {
    fn default() -> Self {
        Tracks(BTreeMap::new())
    }
}

impl<T: Held> Tracks<T> {
    /// Notes what thing number `index`, which stands at `at`, `is` at frame number `number`; none, if it is what it `was`.
    ///
    /// # Errors
    /// No room.
    pub fn follow(
        &mut self,
        room: &mut Room,
        (index, number, at): (usize, usize, &Where),
        was: impl Fn() -> T,
        is: Option<T>,
    ) -> Result<()> {
        if let Some(own) = self.0.get_mut(&index) {
            own.push(is.unwrap_or_else(was));
        } else if let Some(is) = is {
            let still = was();
            room.charge(at, still.bytes())?;
            let mut own = Vec::with_capacity(room.frames);
            own.resize_with(number, || still.clone());
            own.push(is);
            self.0.insert(index, own);
        }
        Ok(())
    }

    pub fn into_all(self) -> impl Iterator<Item = (usize, Vec<T>)> {
        self.0.into_iter()
    }
}
