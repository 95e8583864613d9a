//! Floor 2: what others read of ours — the published schemas of the attribute vocabulary.

pub mod schema; // JSON and USD schemas from the attribute table
