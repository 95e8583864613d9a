//! What authors have said beside the format: custom attributes, those that are of no USD name in `userProperties:`, where Blender and
//! others show them.
//!
//! | `customData["eyebox"]` | means |
//! |---|---|
//! | `userNames` | the name of an attribute, the name that it should have had, and so on |
//! | `userJson` | attributes whose text is JSON, for values that USD has no type for |

use super::layer::{Datum, Prim, Property};
use super::name::identifier;
use super::stage::Writing;
use eyebox_base::relative_path::{folder_of, relocated};
use eyebox_scene::user_property::{UserProperty, UserValue};
use std::collections::{HashMap, HashSet};

const SPACE: &str = "userProperties:";

/// Says the properties on a prim.
pub(super) fn say(writing: &Writing<'_>, user: &[UserProperty], prim: &mut Prim) {
    let (mut names, mut texts) = (Vec::new(), Vec::new());
    let (mut taken, mut next) = (HashSet::new(), HashMap::new());
    for own in user {
        let bare = own.usd.is_some_and(|usd| usd.bare);
        // Namespaces stay. Readers of text take letters of ASCII alone in names of properties.
        let ascii: String = own.name.chars().map(|c| if c.is_ascii() { c } else { '_' }).collect();
        let steps: Vec<String> = ascii.split(':').map(|step| identifier(step, "_")).collect();
        let plain = if bare { steps.join(":") } else { format!("{SPACE}{}", steps.join(":")) };
        // The next number to try for a name that is taken.
        let number = next.entry(plain.clone()).or_insert(0_usize);
        let name = loop {
            let candidate = if *number == 0 { plain.clone() } else { format!("{plain}_{number}") };
            *number += 1;
            if taken.insert(candidate.clone()) {
                break candidate;
            }
        };
        let (value, role) = match datum(writing, own) {
            Some((value, role)) => (value, role),
            None => {
                texts.push(name.clone());
                (Datum::Text(own.value.json().to_string()), None)
            }
        };
        if name.strip_prefix(SPACE).filter(|_| !bare).unwrap_or(&name) != own.name {
            names.extend([name.clone(), own.name.clone()]);
        }
        let mut property = Property::new(name, value);
        property.custom = true;
        prim.push(match role {
            Some(role) => property.typed(role),
            None => property,
        });
    }
    for (key, list) in [("userNames", names), ("userJson", texts)] {
        if !list.is_empty() {
            prim.marks.push((key, Datum::Texts(list)));
        }
    }
}

/// The value in the type that it has in USD, or that goes with it, and its role; none if there is none.
fn datum(writing: &Writing<'_>, own: &UserProperty) -> Option<(Datum, Option<&'static str>)> {
    if let Some(usd) = own.usd
        && let Some(found) = typed(writing, &own.value, usd.type_name)
    {
        return Some((found, Some(usd.type_name)));
    }
    let plain = match &own.value {
        UserValue::Bool(flag) => Datum::Bool(*flag),
        UserValue::Integer(whole) => Datum::Int(i32::try_from(*whole).ok()?),
        UserValue::Number(number) => Datum::Double(*number),
        UserValue::Text(text) => Datum::Text(text.clone()),
        UserValue::List(items) => list(items)?,
        UserValue::Nothing | UserValue::Table(_) => return None,
    };
    Some((plain, None))
}

/// A list of whole numbers, of numbers that all have a point, or of texts: what comes back as it was.
fn list(items: &[UserValue]) -> Option<Datum> {
    if items.is_empty() {
        return None;
    }
    let whole = items.iter().map(|item| match item {
        UserValue::Integer(whole) => i32::try_from(*whole).ok(),
        UserValue::Nothing
        | UserValue::Bool(_)
        | UserValue::Number(_)
        | UserValue::Text(_)
        | UserValue::List(_)
        | UserValue::Table(_) => None,
    });
    let pointed = items.iter().map(|item| match item {
        UserValue::Number(number) => Some(*number),
        UserValue::Nothing
        | UserValue::Bool(_)
        | UserValue::Integer(_)
        | UserValue::Text(_)
        | UserValue::List(_)
        | UserValue::Table(_) => None,
    });
    whole
        .collect::<Option<_>>()
        .map(Datum::Ints)
        .or_else(|| pointed.collect::<Option<_>>().map(Datum::Doubles))
        .or_else(|| texts(items).map(Datum::Texts))
}

fn texts(items: &[UserValue]) -> Option<Vec<String>> {
    items.iter().map(|item| text(item).map(str::to_owned)).collect()
}

fn text(value: &UserValue) -> Option<&str> {
    match value {
        UserValue::Text(text) => Some(text),
        UserValue::Nothing
        | UserValue::Bool(_)
        | UserValue::Integer(_)
        | UserValue::Number(_)
        | UserValue::List(_)
        | UserValue::Table(_) => None,
    }
}

fn items(value: &UserValue) -> Option<&[UserValue]> {
    match value {
        UserValue::List(items) => Some(items),
        UserValue::Nothing
        | UserValue::Bool(_)
        | UserValue::Integer(_)
        | UserValue::Number(_)
        | UserValue::Text(_)
        | UserValue::Table(_) => None,
    }
}

fn numbers<const N: usize>(value: &UserValue) -> Option<[f64; N]> {
    let all: Option<Vec<f64>> = items(value)?.iter().map(UserValue::number).collect();
    <[f64; N]>::try_from(all?).ok()
}

/// The value in a type; none if it does not have that form, or if the type is one that is not written.
fn typed(writing: &Writing<'_>, value: &UserValue, type_name: &str) -> Option<Datum> {
    fn each<T>(value: &UserValue, one: impl Fn(&UserValue) -> Option<T>) -> Option<Vec<T>> {
        items(value)?.iter().map(one).collect()
    }
    let whole = |value: &UserValue| match value {
        UserValue::Integer(whole) => i32::try_from(*whole).ok(),
        UserValue::Nothing
        | UserValue::Bool(_)
        | UserValue::Number(_)
        | UserValue::Text(_)
        | UserValue::List(_)
        | UserValue::Table(_) => None,
    };
    fn single<const N: usize>(value: &UserValue) -> Option<[f32; N]> {
        numbers::<N>(value).map(|all| all.map(|x| x as f32))
    }
    let (plain, many) = type_name.strip_suffix("[]").map_or((type_name, false), |plain| (plain, true));
    let lanes = plain.trim_end_matches(['f', 'd']).trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let is_double = plain.starts_with("double") || plain.len() > 1 && plain.ends_with('d');
    Some(match (plain, many) {
        ("int", false) => Datum::Int(whole(value)?),
        ("int", true) => Datum::Ints(each(value, whole)?),
        ("float", false) => Datum::Float(value.number()? as f32),
        ("float", true) => Datum::Floats(each(value, |own| own.number().map(|x| x as f32))?),
        ("double", false) => Datum::Double(value.number()?),
        ("double", true) => Datum::Doubles(each(value, UserValue::number)?),
        ("string", false) => Datum::Text(text(value)?.to_owned()),
        ("string", true) => Datum::Texts(texts(items(value)?)?),
        ("token", false) => Datum::Token(text(value)?.to_owned()),
        ("token", true) => Datum::Tokens(texts(items(value)?)?),
        ("asset", false) => {
            let path = text(value)?;
            // What is looked for in search paths stays as it is.
            let is_beside = path.starts_with("./") || path.starts_with("../");
            let moved = || relocated(path, &folder_of(&writing.assembly.file), writing.folder);
            let named = if is_beside { moved() } else { path.to_owned() };
            Datum::Asset(if is_beside && !named.starts_with('.') { format!("./{named}") } else { named })
        }
        ("int2", false) => {
            let [x, y] = <[i32; 2]>::try_from(each(value, whole)?).ok()?;
            Datum::Int2([x, y])
        }
        _ => match (lanes, is_double, many) {
            ("2", false, false) => Datum::Float2(single(value)?),
            ("2", false, true) => Datum::Float2s(each(value, single::<2>)?),
            ("2", true, false) => Datum::Double2(numbers(value)?),
            ("2", true, true) => Datum::Double2s(each(value, numbers::<2>)?),
            ("3", false, false) => Datum::Float3(single(value)?),
            ("3", false, true) => Datum::Float3s(each(value, single::<3>)?),
            ("3", true, false) => Datum::Double3(numbers(value)?),
            ("3", true, true) => Datum::Double3s(each(value, numbers::<3>)?),
            ("4", false, false) => Datum::Float4(single(value)?),
            _ => return None,
        },
    })
}
