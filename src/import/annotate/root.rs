//! The root table of an annotated asset, and the references into its arrays.

use super::super::asset_attributes::{AssetAttributes, Library};
use super::super::binding_slots::{Slot, Won};
use super::super::optics;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::value::{Data, Value};

/// The arrays of the root while it is written: the asset's own first, so that its indices stay.
#[derive(Debug)]
pub struct Root<'a> {
    sheet: &'a AssetAttributes,
    coatings: Vec<Value>,
    media: Vec<Value>,
    emitters: Vec<Value>,
    slides: Vec<Value>,
}

/// A row of a table: its key and its value.
pub type Row = (String, Value);

pub fn row(key: &str, data: Data, at: &Where) -> Row {
    (key.to_owned(), Value::new(data, at.clone()))
}

impl<'a> Root<'a> {
    /// The arrays of the asset with everything that the sidecar names, used or not.
    pub fn new(sheet: &'a AssetAttributes) -> Self {
        let mut root = Root {
            sheet,
            coatings: sheet.coatings.indexed.clone(),
            media: sheet.media.indexed.clone(),
            emitters: sheet.emitters.indexed.clone(),
            slides: sheet.slides.indexed.clone(),
        };
        for (name, value) in of_sidecar(&sheet.coatings) {
            let value = if value.get("name").is_none() { named(value, name) } else { value.clone() };
            intern(&mut root.coatings, value);
        }
        for (name, value) in of_sidecar(&sheet.media) {
            // A medium goes by the name it is called by.
            intern(&mut root.media, named(value, name));
        }
        root
    }

    /// A value of `slot` as the asset says it: names and tables of coatings, emitters and slides become indices.
    /// Faults: a name that nobody defined.
    pub fn refer(&mut self, slot: Slot, value: &Value) -> Result<Value> {
        let (library, array) = match slot {
            Slot::Coating => (&self.sheet.coatings, &mut self.coatings),
            Slot::Emitter => (&self.sheet.emitters, &mut self.emitters),
            Slot::Slide => (&self.sheet.slides, &mut self.slides),
            Slot::Index | Slot::Absorption | Slot::Priority | Slot::Finish | Slot::Shape | Slot::Sensor => {
                return Ok(value.clone());
            }
        };
        let (target, name) = match &value.data {
            // An index of the asset's own, which is what it was.
            Data::Number(_) => return library.follow(value).map(|_| value.clone()),
            Data::Text(name) => match library.by_name(name) {
                Some(target) => (target, Some(name)),
                None if name == "none" => return Ok(value.clone()),
                None if slot == Slot::Coating => return Err(optics::unknown_coating(name, value, library.names())),
                None => {
                    let what = format!("unknown {} `{name}`", library.noun);
                    return Err(Error::new(value.at.clone(), what)
                        .nearest(name, library.names())
                        .code(Code::NameUnknown));
                }
            },
            Data::Bool(_) | Data::List(_) | Data::Table(_) => (value, None),
        };
        if target.table().is_none() {
            return Ok(target.clone());
        }
        let target = match name.filter(|_| slot == Slot::Coating && target.get("name").is_none()) {
            Some(name) => named(target, name),
            None => target.clone(),
        };
        Ok(Value::new(Data::Number(intern(array, target) as f64), value.at.clone()))
    }

    /// What a part says of its medium, from the values that hold. A named medium is referred to with all that it says;
    /// `explicit` also says what is not there.
    pub fn medium(&mut self, index: Option<&Won>, rest: [Option<&Won>; 2], explicit: bool) -> Vec<Row> {
        let mut rows = Vec::new();
        let [absorption, priority] = rest;
        let own = |won: Option<&Won>, key: &str| won.map(|won| (key.to_owned(), won.entry.value.clone()));
        let beside: Vec<Row> =
            [own(absorption, "absorption_per_m"), own(priority, "priority")].into_iter().flatten().collect();
        let mut said_by_medium: Vec<String> = Vec::new();
        match index.map(|won| &won.entry) {
            Some(entry) => match entry.label.as_ref().filter(|_| entry.key != "medium") {
                Some(label) => {
                    let law = (entry.key.clone(), entry.value.clone());
                    let fits = |medium: &Value| {
                        let rows = medium.table().unwrap_or(&[]);
                        rows.iter().all(|(key, value)| match key.as_str() {
                            "name" => value.text() == Some(label),
                            key if key == law.0 => value.same(&law.1),
                            key => beside.iter().any(|(other, own)| key == other && own.same(value)),
                        }) && medium.get(&law.0).is_some()
                            && medium.get("name").is_some()
                    };
                    let place = self.media.iter().position(fits).unwrap_or_else(|| {
                        let name = row("name", Data::Text(label.clone()), &entry.at);
                        let table = [name, law.clone()].into_iter().chain(beside.iter().cloned()).collect();
                        self.media.push(Value::new(Data::Table(table), entry.at.clone()));
                        self.media.len() - 1
                    });
                    let table = self.media.get(place).and_then(Value::table).unwrap_or(&[]);
                    said_by_medium = table.iter().map(|(key, _)| key.clone()).collect();
                    rows.push(row("medium", Data::Number(place as f64), &entry.at));
                }
                None => rows.push((entry.key.clone(), entry.value.clone())),
            },
            None if explicit => rows.push(row("medium", Data::Text("none".into()), &Where::Nowhere)),
            None => {}
        }
        rows.extend(beside.into_iter().filter(|(key, _)| !said_by_medium.contains(key)));
        if explicit {
            for (key, won) in [("absorption_per_m", absorption), ("priority", priority)] {
                if won.is_none() {
                    rows.push(row(key, Data::Number(0.0), &Where::Nowhere));
                }
            }
        }
        rows
    }

    /// The whole root table; none if `before` says the same already.
    pub fn table(mut self, before: Option<&Value>, rows_below: bool) -> Result<Option<Value>> {
        let default = match &self.sheet.default {
            Some(value) => Some(self.default(value)?),
            None => None,
        };
        let at = before.map_or(Where::Nowhere, |before| before.at.clone());
        let mut rows: Vec<Row> = before.and_then(Value::table).unwrap_or(&[]).to_vec();
        let array = |items: Vec<Value>| (!items.is_empty()).then(|| Value::new(Data::List(items), at.clone()));
        let wanted = [
            ("unit", self.sheet.unit.clone()),
            ("wavelengths", self.sheet.wavelengths.clone()),
            ("default", default),
            ("media", array(self.media)),
            ("coatings", array(self.coatings)),
            ("emitters", array(self.emitters)),
            ("slides", array(self.slides)),
            ("sky", self.sheet.sky.clone()),
            ("sun", self.sheet.sun.clone()),
            ("eye", self.sheet.eye.clone()),
        ];
        for (key, value) in wanted {
            let Some(value) = value else { continue };
            match rows.iter_mut().find(|(own, _)| own == key) {
                Some((_, own)) if own.same(&value) => {}
                Some((_, own)) => *own = value,
                None => rows.push((key.to_owned(), value)),
            }
        }
        if rows.is_empty() && !rows_below {
            return Ok(None);
        }
        if !rows.iter().any(|(key, _)| key == "version") {
            rows.insert(0, row("version", Data::Number(1.0), &at));
        }
        let table = Value::new(Data::Table(rows), at);
        Ok(if before.is_some_and(|before| before.same(&table)) { None } else { Some(table) })
    }

    fn default(&mut self, value: &Value) -> Result<Value> {
        let mut rows = Vec::new();
        for (key, item) in value.table().unwrap_or(&[]) {
            let item = match (Slot::of(key), &item.data) {
                (Some(Slot::Index), Data::Text(name)) if key == "medium" && name != "none" => {
                    let target = self.sheet.media.by_name(name).map(|target| named(target, name));
                    match target {
                        Some(target) => {
                            Value::new(Data::Number(intern(&mut self.media, target) as f64), item.at.clone())
                        }
                        None => item.clone(),
                    }
                }
                (Some(slot), _) => self.refer(slot, item)?,
                (None, _) => item.clone(),
            };
            rows.push((key.clone(), item));
        }
        Ok(Value::new(Data::Table(rows), value.at.clone()))
    }
}

/// What only the sidecar names: the asset's own names come after it.
fn of_sidecar(library: &Library) -> impl Iterator<Item = &(String, Value)> {
    let own = library.indexed.iter().filter(|item| item.get("name").and_then(Value::text).is_some()).count();
    library.named.iter().take(library.named.len().saturating_sub(own)).filter(|(_, value)| value.table().is_some())
}

/// The table `value` with `name` as its name.
fn named(value: &Value, name: &str) -> Value {
    let Some(table) = value.table() else { return value.clone() };
    let others = table.iter().filter(|(key, _)| key != "name").cloned();
    let rows = std::iter::once(row("name", Data::Text(name.to_owned()), &value.at)).chain(others).collect();
    Value::new(Data::Table(rows), value.at.clone())
}

fn intern(array: &mut Vec<Value>, value: Value) -> usize {
    array.iter().position(|other| other.same(&value)).unwrap_or_else(|| {
        array.push(value);
        array.len() - 1
    })
}
