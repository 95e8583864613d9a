//! The short tests of the crate from outside, one program: thirty programs would each link the whole of it.
//! `cargo verify --test all -- hud::` runs one file's.

// What only tests in `long!` use; there the compiler looks.
#![allow(dead_code, unused_imports)]

/// Tests that `cargo verify-long` runs alone.
macro_rules! long {
    ($($test:item)*) => {};
}

include!("modules.rs");
