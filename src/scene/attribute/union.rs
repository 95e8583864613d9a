//! Values that are one of several kinds: every way of writing them, as kind and parameters.

use super::{Kind, kinds};
use crate::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};

/// A value of an attribute with kinds, taken apart.
#[derive(Debug, Clone)]
pub struct Split<'a> {
    /// As it is written.
    pub name: &'a str,
    /// Where the kind stands.
    pub at: &'a Where,
    /// None if there is no kind of that name.
    pub kind: Option<&'static Kind>,
    /// What is said beside the kind.
    pub parameters: Vec<(&'a str, &'a Value)>,
}

/// Takes `"polished"`, `{ kind = "gauss", sigma_deg = 6 }`, `{ gauss = { sigma_deg = 6 } }` or `{ stack = […] }` apart as
/// a value of `attribute`. Faults: a list, a number, a table that names no kind or two.
pub fn split<'a>(attribute: &str, value: &'a Value) -> Result<Split<'a>> {
    let find = |name: &str| kinds(attribute).find(|kind| kind.name == name);
    let (name, at, parameters) = match &value.data {
        Data::Text(name) => (name.as_str(), &value.at, Vec::new()),
        Data::Table(table) => {
            let all = || table.iter().map(|(key, value)| (key.as_str(), value));
            if let Some(tag) = value.get("kind") {
                let name = tag.text().ok_or_else(|| unknown(attribute, &tag.to_string(), &tag.at))?;
                (name, &tag.at, all().filter(|(key, _)| *key != "kind").collect())
            } else {
                let mut tags = all().filter(|(key, _)| find(key).is_some());
                match (tags.next(), tags.next()) {
                    (Some((name, inner)), None) => match &inner.data {
                        Data::Table(inner_table) => {
                            let beside = all().filter(|(key, _)| *key != name);
                            let inside = inner_table.iter().map(|(key, value)| (key.as_str(), value));
                            (name, &inner.at, beside.chain(inside).collect())
                        }
                        // The parameter itself names the kind.
                        Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::List(_) => {
                            (name, &inner.at, all().collect())
                        }
                    },
                    (Some((one, _)), Some((two, at))) => {
                        return Err(Error::new(at.at.clone(), format!("{attribute} is both `{one}` and `{two}`"))
                            .expected("one of them"));
                    }
                    (None, _) => {
                        let first = table.first().map_or("", |(key, _)| key.as_str());
                        return Err(Error::new(value.at.clone(), format!("{attribute} {value} has no kind"))
                            .expected(rendered(attribute))
                            .nearest(first, kinds(attribute).map(|kind| kind.name)));
                    }
                }
            }
        }
        Data::Bool(_) | Data::Number(_) | Data::List(_) => {
            return Err(Error::new(value.at.clone(), format!("{attribute} is {} ({value})", value.kind()))
                .expected(rendered(attribute)));
        }
    };
    Ok(Split { name, at, kind: find(name), parameters })
}

/// The fault of a kind that `attribute` doesn't have.
pub fn unknown(attribute: &str, name: &str, at: &Where) -> Box<Error> {
    // Coatings and spectra go by names, the others by words of the vocabulary.
    let code = if matches!(attribute, "coating" | "spectrum") { Code::NameUnknown } else { Code::AttributeUnknown };
    Error::new(at.clone(), format!("unknown {attribute} `{name}`"))
        .expected(rendered(attribute))
        .nearest(name, kinds(attribute).map(|kind| kind.name))
        .code(code)
}

fn rendered(attribute: &str) -> String {
    let names: Vec<&str> = kinds(attribute).filter(|kind| kind.rendered).map(|kind| kind.name).collect();
    format!("one of {}", names.join(", "))
}
