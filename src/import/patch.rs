//! Changing a value in place: paths into it, and what stands there afterwards.

use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::attribute;

/// A step into a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    Key(String),
    Index(usize),
}

/// `faces[0].shape.radius` → steps.
pub fn steps(text: &str, at: &Where) -> Result<Vec<Step>> {
    let wrong = || {
        Error::new(at.clone(), format!("can't read `{text}`")).expected("names and numbers, e.g. faces[0].shape.radius")
    };
    let mut all = Vec::new();
    for segment in text.split('.').filter(|_| !text.is_empty()) {
        let (key, mut rest) = segment.split_at(segment.find('[').unwrap_or(segment.len()));
        if key.is_empty() {
            return Err(wrong());
        }
        all.push(Step::Key(key.to_owned()));
        while !rest.is_empty() {
            let (index, after) = rest.strip_prefix('[').and_then(|rest| rest.split_once(']')).ok_or_else(wrong)?;
            all.push(Step::Index(index.trim().parse().map_err(|_| wrong())?));
            rest = after;
        }
    }
    Ok(all)
}

/// Puts `new` where `steps` lead in `value`; missing keys of tables are added.
pub fn patch(value: &mut Value, steps: &[Step], new: &Value) -> Result<()> {
    let Some((step, rest)) = steps.split_first() else {
        *value = new.clone();
        return Ok(());
    };
    let what = value.to_string();
    match (step, &mut value.data) {
        (Step::Key(key), Data::Table(table)) => {
            let found = table.iter().position(|(own, _)| own == key);
            let index = found.unwrap_or_else(|| {
                table.push((key.clone(), Value::new(Data::Table(Vec::new()), new.at.clone())));
                table.len() - 1
            });
            match table.get_mut(index) {
                Some((_, inner)) => patch(inner, rest, new),
                None => Ok(()),
            }
        }
        (Step::Index(index), Data::List(list)) => {
            let count = list.len();
            match list.get_mut(*index) {
                Some(inner) => patch(inner, rest, new),
                None => Err(Error::new(new.at.clone(), format!("there is no item {index} in {what}"))
                    .expected(format!("an item below {count}"))),
            }
        }
        (Step::Key(key), Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::List(_)) => {
            Err(Error::new(new.at.clone(), format!("{what} has no `{key}` to set")))
        }
        (Step::Index(index), Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::Table(_)) => {
            Err(Error::new(new.at.clone(), format!("{what} has no item {index} to set")))
        }
    }
}

/// Patches a parameter: in `{ gauss = { sigma_deg = 6 } }` they stand one level down.
pub fn patch_parameter(value: &mut Value, steps: &[Step], new: &Value) -> Result<()> {
    if let Data::Table(table) = &mut value.data
        && let [(kind, inner)] = table.as_mut_slice()
        && inner.table().is_some()
        && attribute::KINDS.iter().any(|row| row.name == kind)
    {
        return patch(inner, steps, new);
    }
    patch(value, steps, new)
}
