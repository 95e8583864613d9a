//! The rows of one part: which of its values the asset must say, and the node's table that says them.

use super::super::binding_slots::{PartBound, Rank, Slot, Slots, Won};
use super::meaning;
use super::root::{Root, Row, row};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::assembly::Node;
use eyebox_scene::value::{Data, Value};
use std::collections::BTreeSet;

/// How much of a part's medium must be said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Extent {
    Nothing,
    /// What holds.
    Held,
    /// Also that nothing is there.
    Explicit,
}

/// What a part must say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    medium: Extent,
    /// By place in [`Slot::FACE`]: the faces of which it must be said.
    faces: [BTreeSet<usize>; Slot::FACE.len()],
    /// Whether it must be said face by face, even if it is the same for all.
    narrow: [bool; Slot::FACE.len()],
}

impl Asked {
    /// What the sidecar won.
    pub fn by_the_sidecar(bound: &PartBound) -> Self {
        let medium = bound.part.all().any(|won| won.rank > Rank::NodeFaces);
        let mut faces: [BTreeSet<usize>; Slot::FACE.len()] = Default::default();
        for (number, slots) in bound.faces.iter().enumerate() {
            for (slot, faces) in Slot::FACE.into_iter().zip(&mut faces) {
                if holds(slots, slot).is_some_and(|won| won.rank > Rank::NodeFaces) {
                    faces.insert(number);
                }
            }
        }
        Asked { medium: if medium { Extent::Held } else { Extent::Nothing }, faces, narrow: [false; Slot::FACE.len()] }
    }

    pub fn anything(&self) -> bool {
        self.medium != Extent::Nothing || self.faces.iter().any(|faces| !faces.is_empty())
    }

    /// Asks for a value that came out wrong: first at all, then more strongly.
    pub fn more(&mut self, slot: Slot, face: Option<usize>) {
        let Some(face) = face else {
            self.medium = if self.medium == Extent::Nothing { Extent::Held } else { Extent::Explicit };
            return;
        };
        // A coating that came out wrong may be the finish's doing.
        let both = [Slot::Coating, Slot::Finish];
        for (place, own) in Slot::FACE.into_iter().enumerate() {
            if own == slot && !self.faces[place].insert(face)
                || own != slot && both.contains(&own) && both.contains(&slot)
            {
                self.narrow[place] = true;
            }
        }
    }
}

/// The new table of the part's node; none if it would be empty.
pub fn of_part(root: &mut Root<'_>, node: &Node, bound: &PartBound, asked: &Asked) -> Result<Option<Value>> {
    let old = node.attributes.as_ref().and_then(Value::table).unwrap_or(&[]);
    let at = node.attributes.as_ref().map_or(&node.at, |value| &value.at);
    let touched = |slot: Slot| match Slot::FACE.into_iter().position(|own| own == slot) {
        None => asked.medium != Extent::Nothing,
        Some(place) => !asked.faces[place].is_empty(),
    };
    let keeps = |(key, _): &&Row| Slot::of(key).is_none_or(|slot| !touched(slot));
    let mut whole: Vec<Row> = old.iter().filter(|(key, _)| key != "faces").filter(keeps).cloned().collect();
    let old_rows = node.attributes.as_ref().and_then(|value| value.get("faces")).and_then(Value::list).unwrap_or(&[]);
    let mut rows: Vec<Value> = Vec::new();
    for old in old_rows {
        let kept: Vec<Row> = old.table().unwrap_or(&[]).iter().filter(keeps).cloned().collect();
        if kept.iter().any(|(key, _)| Slot::of(key).is_some()) {
            rows.push(Value::new(Data::Table(kept), old.at.clone()));
        }
    }
    if asked.medium != Extent::Nothing {
        let get = |slot| bound.part.get(slot);
        let explicit = asked.medium == Extent::Explicit;
        whole.extend(root.medium(get(Slot::Index), [get(Slot::Absorption), get(Slot::Priority)], explicit));
    }
    // The rest by face: (what it says, which faces say so).
    let mut groups: Vec<(Vec<Row>, Vec<usize>)> = Vec::new();
    let mut by_face: Vec<Vec<Row>> = vec![Vec::new(); bound.faces.len()];
    for (place, slot) in Slot::FACE.into_iter().enumerate() {
        let mut faces = asked.faces[place].clone();
        if faces.is_empty() {
            continue;
        }
        // What this table said of the slot is gone: whatever it won must be said again.
        let won = |rank: Rank| rank == Rank::Node || rank == Rank::NodeFaces;
        let numbered = bound.faces.iter().enumerate();
        faces.extend(numbered.filter(|(_, s)| holds(s, slot).is_some_and(|w| won(w.rank))).map(|(number, _)| number));
        let mut said: Vec<(usize, Row)> = Vec::new();
        for face in &faces {
            let value = match bound.faces.get(*face).and_then(|slots| holds(slots, slot)) {
                Some(won) => root.refer(slot, &won.entry.value)?,
                None => match nothing(slot) {
                    Some(text) => Value::new(Data::Text(text.to_owned()), Where::Nowhere),
                    None => continue,
                },
            };
            said.push((*face, (slot.key().to_owned(), value)));
        }
        match said.first() {
            Some((_, first))
                if !asked.narrow[place]
                    && said.len() == bound.faces.len()
                    && said.iter().all(|(_, row)| row.1.same(&first.1)) =>
            {
                whole.push(first.clone());
            }
            Some(_) | None => {
                for (face, row) in said {
                    if let Some(rows) = by_face.get_mut(face) {
                        rows.push(row);
                    }
                }
            }
        }
    }
    for (face, rows) in by_face.into_iter().enumerate().filter(|(_, rows)| !rows.is_empty()) {
        let same = |other: &Vec<Row>| {
            other.len() == rows.len() && other.iter().zip(&rows).all(|(a, b)| a.0 == b.0 && a.1.same(&b.1))
        };
        match groups.iter_mut().find(|(other, _)| same(other)) {
            Some((_, faces)) => faces.push(face),
            None => groups.push((rows, vec![face])),
        }
    }
    for (entries, faces) in groups {
        let numbers = faces.iter().map(|face| Value::new(Data::Number(*face as f64), at.clone())).collect();
        let table = std::iter::once(row("faces", Data::List(numbers), at)).chain(entries).collect();
        rows.push(Value::new(Data::Table(table), at.clone()));
    }
    if !rows.is_empty() {
        whole.push(row("faces", Data::List(rows), at));
    }
    Ok((!whole.is_empty() || node.attributes.is_some()).then(|| Value::new(Data::Table(whole), at.clone())))
}

/// The value that holds and does something: a coating that a stronger finish put out of action does not.
fn holds(slots: &Slots, slot: Slot) -> Option<&Won> {
    slots.get(slot).filter(|_| slot != Slot::Coating || meaning::acts(slots).unwrap_or(true))
}

/// What says that nothing is there.
fn nothing(slot: Slot) -> Option<&'static str> {
    match slot {
        Slot::Coating | Slot::Emitter | Slot::Slide => Some("none"),
        Slot::Shape => Some("mesh"),
        Slot::Finish | Slot::Sensor | Slot::Index | Slot::Absorption | Slot::Priority => None,
    }
}
