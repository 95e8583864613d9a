//! Physical quantities with their units, as written by people: `"4 mm"`, `"12 deg"`.

/// Photometric luminous efficacy at 555 nm, lm/W.
pub const LUMINOUS_EFFICACY: f64 = 683.0;

/// One arcminute in radians.
pub const ARCMIN: f64 = std::f64::consts::PI / 10_800.0;

/// Parses a length with a unit (`"4 mm"`, `"0.12 m"`, `"68 nm"`, `"inf"`) into metres.
/// Errors: a text that says what is wrong.
pub fn parse_length_m(text: &str) -> Result<f64, String> {
    let text = text.trim();
    if matches!(text, "inf" | "infinity" | "∞") {
        return Ok(f64::INFINITY);
    }
    let split = text.find(|c: char| c.is_alphabetic() && c != 'e' && c != 'E' || c == 'µ').unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let value: f64 = number
        .trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a length; write a number and a unit, e.g. `4 mm`"))?;
    let metres = match unit.trim() {
        "nm" => 1e-9,
        "um" | "µm" | "μm" => 1e-6,
        "mm" => 1e-3,
        "cm" => 1e-2,
        "m" => 1.0,
        "km" => 1e3,
        "in" => 0.0254,
        "" => return Err(format!("`{text}` has no unit; write e.g. `{text} mm`")),
        other => return Err(format!("unknown unit `{other}` in `{text}`; use nm, um, mm, cm, m, km or in")),
    };
    Ok(value * metres)
}

/// `digits` significant digits, without trailing zeros; an exponent only for the very large and very small.
pub fn significant(x: f64, digits: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".to_owned() } else { format!("{x}") };
    }
    // Of the rounded number: 9.9999 has one digit more than it seems.
    let rounded: f64 = format!("{x:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(x);
    let exponent = rounded.abs().log10().floor();
    if !(-4.0..7.0).contains(&exponent) {
        let text = format!("{x:.*e}", (digits - 1).max(0) as usize);
        let Some((mantissa, power)) = text.split_once('e') else { return text };
        return format!("{}e{power}", trimmed(mantissa));
    }
    let places = (f64::from(digits) - 1.0 - exponent).max(0.0) as usize;
    trimmed(&format!("{rounded:.places$}")).to_owned()
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths() {
        assert_eq!(parse_length_m("4 mm"), Ok(0.004));
        assert_eq!(parse_length_m("2e-1m"), Ok(0.2));
        assert_eq!(parse_length_m("inf"), Ok(f64::INFINITY));
        assert!(parse_length_m("4").unwrap_err().contains("no unit"));
        assert!(parse_length_m("4 furlong").unwrap_err().contains("unknown unit"));
        assert!(parse_length_m("").is_err());
    }

    #[test]
    fn numbers_are_short_and_right() {
        for (x, digits, text) in [
            (0.0, 4, "0"),
            (103.70448, 6, "103.704"),
            (99.638, 6, "99.638"),
            (9.99999, 4, "10"),
            (-2.22781837, 6, "-2.22782"),
            (143_239.4, 4, "143200"),
            (3.6e9, 4, "3.6e9"),
            (1.5e-7, 4, "1.5e-7"),
            (100.0, 2, "100"),
            (f64::INFINITY, 4, "inf"),
        ] {
            assert_eq!(significant(x, digits), text);
        }
    }
}
