//! Broken copies of a file, the same ones for the same seed.

use eyebox::base::rng::{Rng, Stream};

/// What a number is replaced by.
const NUMBERS: [&str; 10] =
    ["-1", "0", "1e308", "4294967295", "9007199254740993", "3.5", "null", "[]", "\"x\"", "1e-320"];

/// `bytes` cut short, with some bytes changed, with a range overwritten, or with a number of its text replaced.
pub fn mutated(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut rng = Rng::new(seed, Stream::Check, 0, 0);
    let mut below = |count: usize| ((rng.uniform() * count as f64) as usize).min(count.saturating_sub(1));
    let kind = below(4);
    let mut out = bytes.to_vec();
    if bytes.is_empty() {
        return out;
    }
    // Half of the changes go to the beginning, where headers and texts are.
    let mut place = |length: usize| {
        let most = if below(2) == 0 { length.min(2048) } else { length };
        below(most)
    };
    match kind {
        0 => out.truncate(place(bytes.len())),
        1 => {
            for _ in 0..=place(8) {
                let at = place(out.len());
                out[at] ^= 1 << place(8);
            }
        }
        2 => {
            let (at, fill) = (place(out.len()), [0u8, 0xFF, 0x7F, b'0'][place(4)]);
            let end = (at + 1 + place(16)).min(out.len());
            out[at..end].fill(fill);
        }
        _ => {
            // The first number at or after a random place.
            let from = place(out.len());
            let digit = |byte: &u8| byte.is_ascii_digit();
            if let Some(start) = out[from..].iter().position(digit).map(|i| from + i) {
                let end = out[start..].iter().position(|byte| !digit(byte)).map_or(out.len(), |i| start + i);
                let mut new = NUMBERS[place(NUMBERS.len())].as_bytes().to_vec();
                // A .glb says how long its text is: the length stays.
                if bytes.starts_with(b"glTF") {
                    new.resize(end - start, b' ');
                }
                out.splice(start..end, new);
            }
        }
    }
    out
}
