//! Templates of value clips name a file for every step of time. The library below writes all of the names down, so a
//! step that is absurdly short against the span is refused before it is asked.

/// How many files a template may name; a day of film has two million frames.
const MOST_FILES: f64 = 4e6;

/// Looks at all templates of a text layer together: the longest span of time against the shortest stride.
///
/// # Errors
/// More files than any set of clips has.
pub(super) fn check(text: &[u8]) -> Result<(), String> {
    let (mut low, mut high, mut stride) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
    for (name, time) in [(&b"templateStartTime"[..], true), (b"templateEndTime", true), (b"templateStride", false)] {
        for number in numbers(text, name) {
            if time {
                (low, high) = (low.min(number), high.max(number));
            } else {
                stride = stride.min(number.abs());
            }
        }
    }
    let files = (high - low) / stride;
    // Without a template there is nothing to compare: −∞.
    if files > MOST_FILES || stride == 0.0 {
        return Err(format!("a clip template names {files:.0} files; expected at most {MOST_FILES:.0}"));
    }
    Ok(())
}

/// The numbers that are said as `name = number`. Anything else that is said is the parser's business.
fn numbers<'a>(text: &'a [u8], name: &'a [u8]) -> impl Iterator<Item = f64> + 'a {
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            let found = rest.windows(name.len()).position(|window| window == name)?;
            rest = &rest[found + name.len()..];
            let line = &rest[..rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len())];
            let value = std::str::from_utf8(line).ok().and_then(|line| line.trim_start().strip_prefix('='));
            let number = value.and_then(|value| value.split([',', ';', '}', '#']).next()?.trim().parse::<f64>().ok());
            if number.is_some_and(|number| !number.is_nan()) {
                return number;
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn a_template_of_too_many_files_is_refused() {
        let layer = |start: &str, end: &str, stride: &str| {
            format!(
                "double templateEndTime = {end}\ndouble templateStartTime = {start}\ndouble templateStride={stride}; x"
            )
        };
        assert!(check(layer("101", "104", "1").as_bytes()).is_ok());
        assert!(check(b"#usda 1.0\n").is_ok());
        assert!(check(b"double templateEndTime = 5e9\n").is_ok(), "without a stride there is no template");
        for (start, end, stride) in
            [("101", "4294967295", "1"), ("0", "100", "1e-9"), ("0", "1", "0"), ("-1e308", "1e308", "1")]
        {
            let fault = check(layer(start, end, stride).as_bytes()).unwrap_err();
            assert!(fault.contains("files; expected at most 4000000"), "{fault}");
        }
    }
}
