//! Little-endian numbers at places of a file.

use eyebox_base::{Code, Error, Where};
use std::path::Path;

/// The bytes of a file, for faults with its name.
pub(super) struct Fields<'a> {
    file: &'a Path,
    pub(super) bytes: &'a [u8],
}

impl<'a> Fields<'a> {
    pub(super) fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        Fields { file, bytes }
    }

    pub(super) fn fault(&self, what: String) -> Box<Error> {
        Error::new(Where::file(self.file), format!("the ray file {what}")).code(Code::ProfileMalformed)
    }

    pub(super) fn cut_off(&self, wanted: u128) -> Box<Error> {
        self.fault(format!("is cut off: it has {} bytes", self.bytes.len())).expected(format!("{wanted} bytes"))
    }

    fn at<const N: usize>(&self, place: usize) -> eyebox_base::Result<[u8; N]> {
        let there = self.bytes.get(place..).and_then(|rest| rest.first_chunk::<N>());
        there.copied().ok_or_else(|| self.cut_off((place + N) as u128))
    }

    pub(super) fn i32(&self, place: usize) -> eyebox_base::Result<i32> {
        self.at(place).map(i32::from_le_bytes)
    }

    pub(super) fn u32(&self, place: usize) -> eyebox_base::Result<u32> {
        self.at(place).map(u32::from_le_bytes)
    }

    pub(super) fn u64(&self, place: usize) -> eyebox_base::Result<u64> {
        self.at(place).map(u64::from_le_bytes)
    }

    pub(super) fn f32(&self, place: usize) -> eyebox_base::Result<f32> {
        self.at(place).map(f32::from_le_bytes)
    }
}

/// The number in column `column` of a record; none beyond its end.
pub(super) fn column(record: &[u8], column: usize) -> Option<f32> {
    record.get(4 * column..)?.first_chunk::<4>().map(|bytes| f32::from_le_bytes(*bytes))
}
