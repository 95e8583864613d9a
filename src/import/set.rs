//! `--set TARGET.attribute=VALUE`: the strongest binding. Targets are `eye`, `sky`, `sun`, `default`, `unit`, `wavelengths`,
//! `coating.NAME`, `medium.NAME`, a light group, or parts by name, path or pattern (`LENS_01.faces[0].shape.radius=50`).

use super::asset_attributes::AssetAttributes;
use super::bind::{BINDABLE, said};
use super::binding_slots::{Entry, PartBound, Slot};
use super::optics::{self, EMITTER, SLIDE, STRENGTHS};
use super::patch::{Step, patch, patch_parameter, steps};
use super::select::{Candidate, is_glob, listed};
use super::toml::parse_value;
use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use std::rc::Rc;

/// One `--set`.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// As it was written, without `--set`.
    pub text: String,
    /// What stands left of the `=`.
    left: String,
    value: Value,
}

const TOP: [&str; 8] = ["eye", "sky", "sun", "default", "unit", "wavelengths", "coating", "medium"];

impl Set {
    /// Parses `TARGET.attribute=VALUE`; VALUE is a TOML value or a bare text.
    pub fn parse(text: &str) -> Result<Set> {
        let at = Where::Option(format!("--set {text}"));
        let form = "TARGET.attribute=VALUE, e.g. led.flux_lm=0.5";
        let Some((left, right)) = text.split_once('=') else {
            return Err(Error::new(at, "there is no `=`").expected(form));
        };
        let (left, right) = (left.trim(), right.trim());
        if left.is_empty() || right.is_empty() {
            return Err(Error::new(at, "one side of the `=` is empty").expected(form));
        }
        Ok(Set { text: text.to_owned(), left: left.to_owned(), value: parse_value(right, &at) })
    }

    fn at(&self) -> &Where {
        &self.value.at
    }

    /// Whether it changes something at the top level; then it is applied to the sheet, before anything is bound.
    pub(super) fn apply_to_sheet(&self, sheet: &mut AssetAttributes) -> Result<bool> {
        let (head, tail) = self.left.split_once('.').unwrap_or((&self.left, ""));
        let Some(top) = TOP.into_iter().find(|top| *top == head) else { return Ok(false) };
        let (target, steps) = match top {
            "coating" | "medium" => {
                let library = if top == "coating" { &mut sheet.coatings } else { &mut sheet.media };
                let names: Vec<String> = library.names().map(str::to_owned).collect();
                // The longest name that fits: names may hold dots.
                let own = library
                    .named
                    .iter_mut()
                    .filter(|(name, _)| {
                        tail == name || tail.strip_prefix(name.as_str()).is_some_and(|t| t.starts_with('.'))
                    })
                    .max_by_key(|(name, _)| name.len());
                let Some((name, value)) = own else {
                    return Err(Error::new(self.at().clone(), format!("there is no {top} `{tail}`"))
                        .expected(format!("{top}.NAME.attribute with one of {}", names.join(", ")))
                        .nearest(tail.split('.').next().unwrap_or(tail), names.iter().map(String::as_str)));
                };
                let steps = steps(tail[name.len()..].trim_start_matches('.'), self.at())?;
                (value, steps)
            }
            _ => {
                let place = match top {
                    "eye" => &mut sheet.eye,
                    "sky" => &mut sheet.sky,
                    "sun" => &mut sheet.sun,
                    "default" => &mut sheet.default,
                    "unit" => &mut sheet.unit,
                    _ => &mut sheet.wavelengths,
                };
                let steps = steps(tail, self.at())?;
                let empty = || Value::new(Data::Table(Vec::new()), self.at().clone());
                (place.get_or_insert_with(empty), steps)
            }
        };
        if steps.is_empty() && matches!(top, "eye" | "sky" | "sun" | "default") {
            return Err(Error::new(self.at().clone(), format!("`{top}` is no attribute"))
                .expected(format!("{top}.attribute=VALUE")));
        }
        // `wavelengths.mono_nm` over "visible": a new table.
        if matches!(target.data, Data::Text(_)) && !steps.is_empty() {
            target.data = Data::Table(Vec::new());
        }
        if let ("sky", Some(Step::Key(key)), Data::Table(table)) = (top, steps.first(), &mut target.data)
            && let Some(kind) = optics::kind_of_sky(std::iter::once(key.as_str()))
        {
            // Another kind of sky replaces the one that is there.
            table.retain(|(other, _)| optics::goes_with_sky(kind, other));
        }
        if let (Slot::Index, Some(Step::Key(key)), Data::Table(table)) =
            (top_slot(&steps), steps.first(), &mut target.data)
        {
            // Another law replaces the one that is there.
            table.retain(|(other, _)| other == key || Slot::of(other) != Some(Slot::Index));
        }
        patch(target, &steps, &self.value)?;
        Ok(true)
    }

    /// Applies it to what is bound. Faults: nobody is called so, or has such an attribute.
    pub(super) fn apply(&self, sheet: &AssetAttributes, parts: &[Candidate], bound: &mut [PartBound]) -> Result<()> {
        for (dot, _) in self.left.rmatch_indices('.') {
            let (target, tail) = (&self.left[..dot], &self.left[dot + 1..]);
            let target_part = target.strip_prefix("slide:").unwrap_or(target);
            let matches = |part: &Candidate| part.has_path(target_part) || part.has_name(target_part);
            let chosen: Vec<usize> = (0..parts.len()).filter(|index| matches(&parts[*index])).collect();
            let group = in_group(target, sheet, bound);
            match (chosen.as_slice(), group.is_empty()) {
                ([], true) => {}
                ([], false) => return self.apply_to_group(target, tail, group, sheet, bound),
                (_, true) => {
                    if chosen.len() > 1 && !is_glob(target_part) {
                        let paths = listed(chosen.iter().map(|index| parts[*index].path.as_str()));
                        return Err(Error::new(
                            self.at().clone(),
                            format!("`{target}` means {} parts: {paths}", chosen.len()),
                        )
                        .expected("the path of one part, or a pattern for all of them"));
                    }
                    return self.apply_to_parts(target, tail, &chosen, sheet, parts, bound);
                }
                (_, false) => {
                    let path = chosen.first().map_or("", |index| parts[*index].path.as_str());
                    return Err(Error::new(self.at().clone(), format!("`{target}` is a part and a light group"))
                        .expected(format!("the part's path `{path}`, or another name for the group")));
                }
            }
        }
        let target = self.left.split('.').next().unwrap_or("");
        let groups = groups(sheet, bound);
        let names = || {
            let parts = parts.iter().flat_map(|part| [part.name.as_str(), part.path.as_str()]);
            parts.chain(groups.iter().map(String::as_str)).chain(TOP)
        };
        let what = if self.left.contains('.') { "is neither a part nor a light group" } else { "names no attribute" };
        Err(Error::new(self.at().clone(), format!("`{target}` {what}"))
            .expected("TARGET.attribute=VALUE with a part, a light group, eye, sky, sun, default, unit, wavelengths, coating.NAME or medium.NAME")
            .nearest(target, names()))
    }

    fn apply_to_group(
        &self,
        group: &str,
        tail: &str,
        members: Vec<(usize, usize)>,
        sheet: &AssetAttributes,
        bound: &mut [PartBound],
    ) -> Result<()> {
        let steps = steps(tail, self.at())?;
        self.known(&steps, &format!("light group `{group}`"))?;
        for (part, face) in members {
            self.patch_face(bound, part, face, Slot::Emitter, &steps, sheet)?;
        }
        Ok(())
    }

    /// Checks that the first step is an attribute of an emitter.
    fn known(&self, steps: &[Step], what: &str) -> Result<()> {
        match steps.first() {
            Some(Step::Key(key)) if EMITTER.contains(&key.as_str()) => Ok(()),
            Some(Step::Key(key)) => Err(Error::new(self.at().clone(), format!("unknown attribute `{key}` of {what}"))
                .expected(format!("one of {}", EMITTER.join(", ")))
                .nearest(key, EMITTER)),
            Some(Step::Index(_)) | None => {
                Err(Error::new(self.at().clone(), format!("no attribute of {what} is named"))
                    .expected("TARGET.attribute=VALUE"))
            }
        }
    }

    fn apply_to_parts(
        &self,
        target: &str,
        tail: &str,
        chosen: &[usize],
        sheet: &AssetAttributes,
        parts: &[Candidate],
        bound: &mut [PartBound],
    ) -> Result<()> {
        let all = steps(tail, self.at())?;
        let (only, steps) = match all.as_slice() {
            [Step::Key(faces), Step::Index(face), rest @ ..] if faces == "faces" => (Some(*face), rest),
            rest => (None, rest),
        };
        // `LENS.medium.ior` is `LENS.ior`: a part's medium is taken apart when it is bound.
        let steps = match steps {
            [Step::Key(medium), inner @ ..] if medium == "medium" && !inner.is_empty() => {
                self.known_of_medium(inner, target)?;
                inner
            }
            all => all,
        };
        let Some(Step::Key(key)) = steps.first() else {
            return Err(Error::new(self.at().clone(), format!("no attribute of `{target}` is named"))
                .expected("TARGET.attribute=VALUE or TARGET.faces[N].attribute=VALUE"));
        };
        // `LED.flux_lm` is short for `LED.emitter.flux_lm`, `LCD.contrast` for `LCD.slide.contrast`.
        // What both have is the slide's where there is one, as it was before emitters had it.
        let mut short = [(&EMITTER[..], Slot::Emitter), (&SLIDE[..], Slot::Slide)];
        let own = |index: &usize| bound.get(*index).map_or(&[][..], |part| &part.faces);
        let has = |slot: Slot| chosen.iter().flat_map(own).any(|slots| slots.get(slot).is_some());
        if key != "name" && (has(Slot::Slide) || !has(Slot::Emitter)) {
            short.reverse();
        }
        let short = short.into_iter().find(|(names, _)| names.contains(&key.as_str()));
        let (slot, inner) = match (Slot::of(key), short) {
            (Some(slot), _) => (slot, &steps[1..]),
            (None, Some((_, slot))) => (slot, steps),
            (None, None) => {
                let rows = EMITTER.into_iter().chain(SLIDE);
                return Err(Error::new(self.at().clone(), format!("unknown attribute `{key}` of a part"))
                    .expected(format!("one of {}, or an attribute of its emitter or slide", BINDABLE.join(", ")))
                    .nearest(key, BINDABLE.into_iter().chain(rows)));
            }
        };
        if let (true, Some(_)) = (slot.of_part(), only) {
            return Err(Error::new(self.at().clone(), format!("`{key}` fills a whole part, not a face"))
                .expected(format!("{target}.{key}=VALUE")));
        }
        if let Some((face, part)) = only.zip(chosen.iter().map(|i| &parts[*i]).find(|part| only >= Some(part.faces))) {
            return Err(Error::new(self.at().clone(), format!("part {} has no face {face}", part.path))
                .expected(format!("a face below {}", part.faces)));
        }
        if inner.is_empty() {
            let entries = said(&[(key.clone(), self.value.clone())], sheet, "`--set`", &[])?;
            for index in chosen {
                let Some(part) = bound.get_mut(*index) else { continue };
                for entry in &entries {
                    if entry.slot.of_part() {
                        part.part.set(entry.clone());
                    } else {
                        let faces =
                            part.faces.iter_mut().enumerate().filter(|(face, _)| only.is_none_or(|o| o == *face));
                        faces.for_each(|(_, face)| face.set(entry.clone()));
                    }
                }
            }
            return Ok(());
        }
        if slot.of_part() {
            for index in chosen {
                let Some(part) = bound.get_mut(*index) else { continue };
                self.patch_part(part, target, key, slot, inner)?;
            }
            return Ok(());
        }
        let mut members = Vec::new();
        for index in chosen {
            let Some(part) = bound.get(*index) else { continue };
            for (face, slots) in part.faces.iter().enumerate() {
                let table = slots.get(slot).map(|won| sheet.followed(slot, &won.entry.value)).transpose()?;
                if only.is_none_or(|only| only == face) && table.is_some_and(|value| value.table().is_some()) {
                    members.push((*index, face));
                }
            }
        }
        let noun = slot.key();
        if members.is_empty() {
            return Err(Error::new(self.at().clone(), format!("`{target}` has no {noun} whose attributes can be set"))
                .expected(format!("a part with {} {noun} = {{ … }}", if noun == "emitter" { "an" } else { "a" })));
        }
        if slot == Slot::Shape && members.len() > chosen.len() {
            return Err(Error::new(self.at().clone(), format!("several faces of `{target}` have a shape"))
                .expected(format!("one face, e.g. {target}.faces[0].{tail}=VALUE")));
        }
        for (part, face) in members {
            self.patch_face(bound, part, face, slot, inner, sheet)?;
        }
        Ok(())
    }

    /// Checks that the first step is an attribute of a medium.
    fn known_of_medium(&self, steps: &[Step], target: &str) -> Result<()> {
        let own = || BINDABLE.into_iter().filter(|key| *key != "medium" && Slot::of(key).is_some_and(Slot::of_part));
        match steps.first() {
            Some(Step::Key(key)) if own().any(|name| name == key) => Ok(()),
            Some(Step::Key(key)) => {
                let what = format!("unknown attribute `{key}` of the medium of `{target}`");
                let expected = format!("one of {}", own().collect::<Vec<_>>().join(", "));
                Err(Error::new(self.at().clone(), what).expected(expected).nearest(key, own()))
            }
            Some(Step::Index(_)) | None => {
                Err(Error::new(self.at().clone(), format!("no attribute of the medium of `{target}` is named"))
                    .expected(format!("{target}.medium.attribute=VALUE")))
            }
        }
    }

    /// Patches a part's index or absorption: `LENS.sellmeier.b[0]`.
    fn patch_part(&self, part: &mut PartBound, target: &str, key: &str, slot: Slot, steps: &[Step]) -> Result<()> {
        let fault = |what: String| Error::new(self.at().clone(), what).expected(format!("{target}.{key}=VALUE"));
        let Some(won) = part.part.get(slot) else { return Err(fault(format!("`{target}` has no `{key}` to change"))) };
        let entry = &won.entry;
        if entry.key != key {
            let own = &entry.key;
            return Err(fault(format!(
                "`{target}` has no `{key}` to change: its index comes from `{own}` ({})",
                entry.at
            )));
        }
        let mut value = entry.value.clone();
        if value.table().is_none() && value.list().is_none() {
            return Err(fault(format!("`{key}` of `{target}` is {} ({value}) and set as a whole", value.kind())));
        }
        patch(&mut value, steps, &self.value)?;
        let entry = Entry { value, at: self.at().clone(), ..(**entry).clone() };
        part.part.set(Rc::new(entry));
        Ok(())
    }

    /// Patches the value that holds for a face.
    fn patch_face(
        &self,
        bound: &mut [PartBound],
        part: usize,
        face: usize,
        slot: Slot,
        steps: &[Step],
        sheet: &AssetAttributes,
    ) -> Result<()> {
        let Some(slots) = bound.get_mut(part).and_then(|part| part.faces.get_mut(face)) else { return Ok(()) };
        let Some(won) = slots.get(slot) else { return Ok(()) };
        let mut value = sheet.followed(slot, &won.entry.value)?.clone();
        if let Some(Step::Key(key)) = steps.first() {
            // One strength replaces the other.
            if let (true, Data::Table(table)) = (STRENGTHS.contains(&key.as_str()), &mut value.data) {
                table.retain(|(other, _)| other == key || !STRENGTHS.contains(&other.as_str()));
            }
        }
        patch_parameter(&mut value, steps, &self.value)?;
        let entry = Entry { value, at: self.at().clone(), ..(*won.entry).clone() };
        slots.set(Rc::new(entry));
        Ok(())
    }
}

fn top_slot(steps: &[Step]) -> Slot {
    match steps.first() {
        Some(Step::Key(key)) => Slot::of(key).unwrap_or(Slot::Finish),
        Some(Step::Index(_)) | None => Slot::Finish,
    }
}

/// The faces that emit in `group`.
fn in_group(group: &str, sheet: &AssetAttributes, bound: &[PartBound]) -> Vec<(usize, usize)> {
    members(sheet, bound).filter(|(_, own)| own == group).map(|(member, _)| member).collect()
}

fn groups(sheet: &AssetAttributes, bound: &[PartBound]) -> Vec<String> {
    let mut all: Vec<String> = members(sheet, bound).map(|(_, group)| group).collect();
    all.sort();
    all.dedup();
    all
}

fn members(sheet: &AssetAttributes, bound: &[PartBound]) -> impl Iterator<Item = ((usize, usize), String)> {
    bound.iter().enumerate().flat_map(move |(part, bound)| {
        bound.faces.iter().enumerate().filter_map(move |(face, slots)| {
            let value = sheet.followed(Slot::Emitter, &slots.get(Slot::Emitter)?.entry.value).ok()?;
            value.table()?;
            let group = value.get("group").and_then(Value::text).unwrap_or("lamp");
            Some(((part, face), group.to_owned()))
        })
    })
}
