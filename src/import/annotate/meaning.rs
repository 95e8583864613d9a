//! What the values that hold for a part mean, however they are written: to compare an annotated asset with the asset and
//! its sidecar.

use super::super::asset_attributes::AssetAttributes;
use super::super::binding_slots::{Rank, Slot, Slots};
use super::super::optics;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};
use eyebox_scene::Finish;
use eyebox_scene::value::{Data, Value};

/// The meaning of a slot; none where nothing is said, or in so many words that there is nothing.
#[derive(Debug, Clone)]
pub struct Meaning {
    key: String,
    value: Value,
    label: Option<String>,
}

impl Meaning {
    fn same(&self, other: &Meaning) -> bool {
        self.key == other.key && self.value.same(&other.value) && self.label == other.label
    }
}

/// Whether two slots mean the same.
pub fn same(a: &Option<Meaning>, b: &Option<Meaning>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.same(b),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    }
}

/// What `slot` of `slots` means. Faults: a coating bound to a face that isn't polished; references that lead nowhere.
pub fn of(slots: &Slots, slot: Slot, sheet: &AssetAttributes) -> Result<Option<Meaning>> {
    let Some(won) = slots.get(slot) else { return Ok(None) };
    let entry = &won.entry;
    let value = sheet.followed(slot, &entry.value)?;
    let nothing = match slot {
        Slot::Index => entry.key == "medium",
        Slot::Absorption | Slot::Priority => value.number() == Some(0.0),
        Slot::Coating => value.text() == Some("none") || !acts(slots)?,
        Slot::Shape => value.text() == Some("mesh"),
        Slot::Emitter | Slot::Slide => value.text() == Some("none"),
        Slot::Finish | Slot::Sensor => false,
    };
    if nothing {
        return Ok(None);
    }
    // The names of coatings and media show in the scene; a glass goes by its own.
    let label = if slot == Slot::Coating {
        Some(value.get("name").and_then(Value::text).or(entry.value.text()).unwrap_or("inline").to_owned())
    } else {
        entry.label.clone().filter(|_| slot == Slot::Index && entry.key != "glass")
    };
    Ok(Some(Meaning { key: entry.key.clone(), value: unnamed(value, slot), label }))
}

/// Whether the coating of a face acts: it does nothing on a face that a stronger binding made other than polished.
pub fn acts(slots: &Slots) -> Result<bool> {
    let Some(coating) = slots.get(Slot::Coating) else { return Ok(false) };
    let Some((finish, rank)) = slots.finish() else { return Ok(true) };
    // A finish that can't be read (yet) stays beside the coating as it is.
    if !optics::finish(&finish.value, &mut Vec::new())
        .is_ok_and(|finish| finish != optics::FinishSpec::Given(Finish::Polished))
    {
        return Ok(true);
    }
    if coating.rank >= rank && coating.rank > Rank::Mapped {
        return Err(Error::new(coating.entry.at.clone(), "a coating acts on polished faces, and this face is not one")
            .expected("finish = \"polished\" there, or no coating")
            .code(Code::CoatingNotPolished));
    }
    Ok(false)
}

/// The value without the name that it goes by in the root's array.
fn unnamed(value: &Value, slot: Slot) -> Value {
    let Some(table) = value.table().filter(|_| slot == Slot::Coating) else { return value.clone() };
    let rows = table.iter().filter(|(key, _)| key != "name").cloned().collect();
    Value::new(Data::Table(rows), value.at.clone())
}
