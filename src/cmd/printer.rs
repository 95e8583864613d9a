//! The one writer to standard output: what can't be written is a failure, what nobody reads any more is none.

use super::Format;
use crate::base::document::document;
use crate::base::{Error, Result, Where};
use serde_json::Value;
use std::io::{ErrorKind, Write};

/// Prints a command's result: text lines, or one JSON [`document`]. Errors: as [`print_text`].
pub fn print(format: Format, text: impl FnOnce() -> String, json: impl FnOnce() -> Value) -> Result<()> {
    print_text(match format {
        Format::Text => text(),
        Format::Json => document(json()),
    })
}

/// Prints whole lines. Errors: standard output can't be written (a full disk); a closed pipe is none.
pub fn print_text(out: impl Into<String>) -> Result<()> {
    write(&mut std::io::stdout().lock(), &out.into())
}

/// The same with colours where they are wanted: on terminals without `NO_COLOR`.
pub fn print_coloured(out: impl Into<String>) -> Result<()> {
    write(&mut anstream::stdout().lock(), &out.into())
}

fn write(to: &mut dyn Write, out: &str) -> Result<()> {
    let end = if out.ends_with('\n') { "" } else { "\n" };
    judged(to.write_all(out.as_bytes()).and_then(|()| to.write_all(end.as_bytes())).and_then(|()| to.flush()))
}

/// What has become of printing.
pub fn judged(written: std::io::Result<()>) -> Result<()> {
    match written {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Error::new(Where::Nowhere, format!("standard output can't be written: {error}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_a_failure_and_a_closed_pipe_is_none() {
        assert!(write(&mut Broken(ErrorKind::BrokenPipe), "text").is_ok());
        let full = write(&mut Broken(ErrorKind::StorageFull), "text").expect_err("nothing was written");
        assert!(full.to_string().contains("standard output"), "{full}");
    }
}
