//! Text files of optics programs, in whatever encoding they were saved.

/// The text of `bytes`: UTF-16 by its byte-order mark or by the zeros of its Latin letters, UTF-8, or else Latin-1.
pub fn decoded(bytes: &[u8]) -> String {
    let units = |bytes: &[u8], unit: fn([u8; 2]) -> u16| -> String {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => units(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => units(rest, u16::from_be_bytes),
        [first, 0, ..] if *first != 0 => units(bytes, u16::from_le_bytes),
        [0, second, ..] if *second != 0 => units(bytes, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => text.to_owned(),
                Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
            }
        }
    }
}

/// What may part the cells of a table, for messages.
pub const SEPARATORS: &str = "commas, semicolons, tabs or blanks between them";

/// The cells of a table's line: between commas, semicolons or tabs, or, where it has none of these, between blanks.
pub fn cells(line: &str) -> Vec<&str> {
    if line.contains([',', ';', '\t']) {
        line.split([',', ';', '\t']).map(str::trim).collect()
    } else {
        line.split_whitespace().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_every_spelling() {
        for line in ["R,10, 20", "R;10;20", "R\t10\t20", "  R 10   20 "] {
            assert_eq!(cells(line), ["R", "10", "20"], "{line:?}");
        }
        assert_eq!(cells("R,,20"), ["R", "", "20"]);
        assert!(cells("").is_empty());
    }

    #[test]
    fn encodings_are_told_apart() {
        let little: Vec<u8> = "VERS µ".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = "VERS µ".encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [
            "VERS µ".as_bytes().to_vec(),
            [b"\xef\xbb\xbf".as_slice(), "VERS µ".as_bytes()].concat(),
            b"VERS \xb5".to_vec(),
            [b"\xff\xfe".as_slice(), &little].concat(),
            [b"\xfe\xff".as_slice(), &big].concat(),
            little,
            big,
        ] {
            assert_eq!(decoded(&bytes), "VERS µ", "{bytes:?}");
        }
        for odd in [b"".as_slice(), b"\0", b"\xff\xfe\0", b"a\0b"] {
            let _ = decoded(odd);
        }
    }
}
