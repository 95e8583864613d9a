//! The layers below a layer, before anything is composed: sublayers that name sublayers multiply, and the library
//! below lists every occurrence.

use super::normalise;
use super::resolver::Normalising;
use openusd::ar::{ResolvedPath, Resolver};
use openusd::sdf::{self, AbstractData, Value};
use openusd::usda;
use std::collections::HashMap;

/// Layers of one stack; productions have tens. A chain of 5000 takes the library 2.3 s, quadratic in the number.
const MOST_LAYERS: usize = 4000;
/// Occurrences of layers in one stack: 111 000 take the library 1.7 s, and they grow as the product of all levels.
const MOST_OCCURRENCES: u64 = 20_000;
/// How far sublayers are followed from each layer when occurrences are counted; those that go round go on forever.
const ROUNDS: usize = 100;

/// The identifiers of the layer `root` and of all below it, each once.
///
/// # Errors
/// More than any stack of layers has.
pub(super) fn gather(resolver: &Normalising, root: &str) -> Result<Vec<String>, String> {
    let mut order = vec![root.to_owned()];
    let mut places = HashMap::from([(root.to_owned(), 0)]);
    let mut below: Vec<Vec<usize>> = Vec::new();
    while let Some(identifier) = order.get(below.len()).cloned() {
        let mut own = Vec::new();
        for found in of(resolver, &identifier) {
            let next = order.len();
            let place = *places.entry(found.clone()).or_insert(next);
            if place == next {
                order.push(found);
            }
            own.push(place);
        }
        below.push(own);
        if order.len() > MOST_LAYERS {
            return Err(format!("more than {MOST_LAYERS} sublayers in one stack of layers"));
        }
    }
    let mut counts = vec![1u64; order.len()];
    for _ in 0..ROUNDS {
        let count = |own: &Vec<usize>| {
            own.iter().filter_map(|&place| counts.get(place)).fold(1u64, |sum, &more| sum.saturating_add(more))
        };
        let next: Vec<u64> = below.iter().map(count).collect();
        let most = next.iter().copied().max().unwrap_or(1);
        if most > MOST_OCCURRENCES {
            return Err(format!(
                "sublayers that name the same sublayers make {most} layers or more; expected at most {MOST_OCCURRENCES}"
            ));
        }
        if next == counts {
            break;
        }
        counts = next;
    }
    Ok(order)
}

/// The identifiers of a layer's own sublayers; none of what cannot be read, which is composition's to report.
fn of(resolver: &Normalising, identifier: &str) -> Vec<String> {
    let Some(resolved) = resolver.resolve(identifier) else { return Vec::new() };
    let Ok(raw) = resolver.raw(&resolved) else { return Vec::new() };
    if raw.starts_with(b"#usda") || raw.starts_with(b"#sdf") {
        let Some(header) = header(&raw) else { return Vec::new() };
        let Ok(header) = normalise::layer(header) else { return Vec::new() };
        let data = std::str::from_utf8(&header).ok().and_then(|text| usda::parse(text).ok());
        return data.map_or_else(Vec::new, |data| named(resolver, &data, &data, &resolved));
    }
    let Ok(layer) = sdf::Layer::open_with(resolver.clone(), identifier) else { return Vec::new() };
    let place = ResolvedPath::new(layer.resolved_path().unwrap_or(identifier));
    named(resolver, layer.data(), layer.data(), &place)
}

fn named(
    resolver: &Normalising,
    data: &dyn AbstractData,
    root: &dyn AbstractData,
    anchor: &ResolvedPath,
) -> Vec<String> {
    let variables = sdf::expr::stack_expression_variables(root, &HashMap::new()).unwrap_or_default();
    let names = match data.try_field(&sdf::Path::abs_root(), "subLayers") {
        Ok(Some(found)) => match found.into_owned() {
            Value::StringVec(names) => names,
            _ => Vec::new(),
        },
        Ok(None) | Err(_) => Vec::new(),
    };
    let evaluated = names.iter().filter_map(|name| sdf::expr::evaluate_string(name, &variables).value);
    evaluated.map(|name| resolver.create_identifier(&name, Some(anchor))).collect()
}

/// The text up to the end of the layer's own metadata.
fn header(text: &[u8]) -> Option<&[u8]> {
    let mut at = text.iter().position(|&byte| byte == b'\n')?;
    let mut depth = 0usize;
    while let Some(&byte) = text.get(at) {
        let rest = text.get(at..)?;
        // What is to be skipped in one go.
        let length = match byte {
            b'#' => rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len()),
            b'/' if rest.starts_with(b"//") => rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len()),
            b'/' if rest.starts_with(b"/*") => until(rest, 2, b"*/"),
            b'"' | b'\'' | b'@' => {
                let triple = [byte; 3];
                if rest.starts_with(&triple) { until(rest, 3, &triple) } else { until(rest, 1, &[byte]) }
            }
            b'(' | b'[' | b'{' => {
                depth += 1;
                1
            }
            b')' | b']' | b'}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return text.get(..=at);
                }
                1
            }
            _ if depth == 0 && !byte.is_ascii_whitespace() => return None,
            _ => 1,
        };
        at += length;
    }
    None
}

/// Past the next `end` that is not escaped.
fn until(rest: &[u8], from: usize, end: &[u8]) -> usize {
    let mut at = from;
    while let Some(&byte) = rest.get(at) {
        if byte == b'\\' {
            at += 2;
        } else if rest.get(at..).is_some_and(|rest| rest.starts_with(end)) {
            return at + end.len();
        } else {
            at += 1;
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::header;

    #[test]
    fn headers_end_where_the_metadata_does() {
        let text =
            b"#usda 1.0\n# (\n( /* ) */ doc = \"a ) \\\" )\"\n subLayers = [@b).usda@, @@@c).usda@@@] )\ndef \"A\" ()";
        let found = header(text).unwrap();
        assert!(found.ends_with(b"@@@] )"), "{}", String::from_utf8_lossy(found));
        assert_eq!(header(b"#usda 1.0\ndef \"A\" ( )\n"), None);
        assert_eq!(header(b"#usda 1.0\n( never closed"), None);
    }
}
