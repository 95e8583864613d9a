//! The places that values are offered for, and the rule by which one wins.

use super::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use std::rc::Rc;

/// How specific a binding is: the greatest wins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rank {
    /// `[default]` of the sidecar.
    Default,
    /// What a format's own fields of a material map to.
    Mapped,
    /// The asset's own attributes of a material, of a node, of a mesh primitive.
    Material,
    Node,
    Primitive,
    /// What a node says of some faces of the parts at or below it: of this instance, where a primitive is shared.
    NodeFaces,
    /// A `[[bind]]` for many parts: a pattern, a material, a mesh.
    Glob,
    /// A `[[bind]]` with the exact path or name.
    Exact,
    /// The same for some faces only.
    FaceGlob,
    FaceExact,
    /// `--set`.
    Set,
}

/// The attributes that one thing can have once. Several attributes give a medium's index; one of them holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    Index,
    Absorption,
    Priority,
    Finish,
    Coating,
    Shape,
    Emitter,
    Slide,
    Sensor,
}

impl Slot {
    pub const PART: [Slot; 3] = [Slot::Index, Slot::Absorption, Slot::Priority];
    pub const FACE: [Slot; 6] = [Slot::Finish, Slot::Coating, Slot::Shape, Slot::Emitter, Slot::Slide, Slot::Sensor];
    const COUNT: usize = 9;

    pub fn of(key: &str) -> Option<Slot> {
        Some(match key {
            "ior" | "glass" | "sellmeier" | "cauchy" | "abbe" | "index_table" | "medium" => Slot::Index,
            "absorption_per_m" => Slot::Absorption,
            "priority" => Slot::Priority,
            "finish" => Slot::Finish,
            "coating" => Slot::Coating,
            "shape" => Slot::Shape,
            "emitter" => Slot::Emitter,
            "slide" => Slot::Slide,
            "sensor" => Slot::Sensor,
            _ => return None,
        })
    }
    /// The attribute that it goes by; an index goes by several.
    pub fn key(self) -> &'static str {
        match self {
            Slot::Index => "medium",
            Slot::Absorption => "absorption_per_m",
            Slot::Priority => "priority",
            Slot::Finish => "finish",
            Slot::Coating => "coating",
            Slot::Shape => "shape",
            Slot::Emitter => "emitter",
            Slot::Slide => "slide",
            Slot::Sensor => "sensor",
        }
    }
    /// Whether it belongs to the whole part.
    pub fn of_part(self) -> bool {
        match self {
            Slot::Index | Slot::Absorption | Slot::Priority => true,
            Slot::Finish | Slot::Coating | Slot::Shape | Slot::Emitter | Slot::Slide | Slot::Sensor => false,
        }
    }
}

/// An attribute as somebody says it.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub slot: Slot,
    pub key: String,
    pub value: Value,
    /// Name of the `[medium.NAME]` it came through.
    pub label: Option<String>,
    /// Where it is bound: not always where its value stands.
    pub at: Where,
}

impl Entry {
    /// Whether it leaves the finish to the face's material.
    pub fn is_material(&self) -> bool {
        self.slot == Slot::Finish
            && (self.value.text() == Some("material")
                || self.value.get("kind").is_some_and(|kind| kind.text() == Some("material")))
    }
}

/// The value that holds, and what it won against.
#[derive(Debug, Clone)]
pub struct Won {
    pub entry: Rc<Entry>,
    pub rank: Rank,
    pub beaten: Vec<(Rc<Entry>, Rank)>,
    /// Another value with the same right.
    conflict: Option<Rc<Entry>>,
}

/// What holds for a part or for a face.
#[derive(Debug, Clone, Default)]
pub struct Slots([Option<Won>; Slot::COUNT]);

impl Slots {
    pub fn get(&self, slot: Slot) -> Option<&Won> {
        self.0[slot as usize].as_ref()
    }

    /// The finish, unless the face's own material is to say it: then what that maps to, if anything.
    pub fn finish(&self) -> Option<(&Entry, Rank)> {
        let won = self.get(Slot::Finish)?;
        if !won.entry.is_material() {
            return Some((&won.entry, won.rank));
        }
        let mapped = won.beaten.iter().find(|(_, rank)| *rank == Rank::Mapped);
        mapped.map(|(entry, rank)| (&**entry, *rank))
    }

    /// Everything that holds, in the order of the slots.
    pub fn all(&self) -> impl Iterator<Item = &Won> {
        self.0.iter().flatten()
    }

    pub(super) fn offer(&mut self, entry: &Rc<Entry>, rank: Rank) {
        let place = &mut self.0[entry.slot as usize];
        let Some(won) = place else {
            *place = Some(Won { entry: entry.clone(), rank, beaten: Vec::new(), conflict: None });
            return;
        };
        if rank < won.rank {
            won.beaten.push((entry.clone(), rank));
        } else if rank > won.rank {
            let beaten = std::mem::replace(&mut won.entry, entry.clone());
            won.beaten.push((beaten, won.rank));
            (won.rank, won.conflict) = (rank, None);
        } else if !(won.entry.key == entry.key && won.entry.value.same(&entry.value)) {
            won.conflict.get_or_insert_with(|| entry.clone());
        }
    }

    /// Replaces what holds, whatever its rank: for `--set`, where the later wins.
    pub fn set(&mut self, entry: Rc<Entry>) {
        let place = &mut self.0[entry.slot as usize];
        let mut beaten = Vec::new();
        if let Some(won) = place.take() {
            beaten = won.beaten;
            beaten.push((won.entry, won.rank));
        }
        *place = Some(Won { entry, rank: Rank::Set, beaten, conflict: None });
    }

    /// Error: two values have the same right to a slot.
    pub(super) fn settled(&self, place: &dyn Fn() -> String) -> Result<()> {
        for won in self.0.iter().flatten() {
            let Some(other) = &won.conflict else { continue };
            let (key, first) = (&won.entry.key, &won.entry.value);
            let same_key = if other.key == *key { String::new() } else { format!("`{}` ", other.key) };
            let what = format!(
                "`{key}` of {} is bound twice with the same precedence: {first} ({}) and {same_key}{}",
                place(),
                won.entry.at,
                other.value
            );
            return Err(Error::new(other.at.clone(), what)
                .expected("one of them, or a more specific selector for one")
                .code(Code::BoundTwice));
        }
        Ok(())
    }
}

/// What holds for a part.
#[derive(Debug, Clone, Default)]
pub struct PartBound {
    pub part: Slots,
    pub faces: Vec<Slots>,
}
