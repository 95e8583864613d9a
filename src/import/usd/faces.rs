//! GeomSubsets: which polygon belongs to which CAD face, and to which material.

use super::attribute::PrimView;
use super::notes::Ledger;
use super::reader::Reader;
use super::value;
use eyebox_base::error::Result;
use std::collections::HashMap;

const MATERIALS: &str = "materialBind";
/// What a converter of CAD data calls the family of a solid's faces.
const CAD: &str = "cadFace";

/// A face of the mesh: the subsets that its polygons belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Face {
    /// Index into [`Partition::subsets`].
    pub cad: Option<usize>,
    /// Index into [`Partition::bindings`].
    pub binding: Option<usize>,
}

pub(super) struct Partition {
    pub subsets: Vec<PrimView>,
    /// Subsets of the family that binds materials.
    pub bindings: Vec<PrimView>,
    /// In order; not empty.
    pub faces: Vec<Face>,
    /// The face of each polygon; empty if there is only one.
    pub of: Vec<u32>,
}

/// Faces in the order of the subsets; what none covers is one more, the last.
pub(super) fn partition(reader: &mut Reader, view: &PrimView, polygons: usize) -> Result<Partition> {
    let mut subsets: Vec<(PrimView, String)> = Vec::new();
    for child in view.children()? {
        let child = PrimView::new(child, &view.moment)?;
        if child.type_name()? != "GeomSubset" {
            continue;
        }
        let Reader { ledger, opened, .. } = &mut *reader;
        ledger.prim(|| child.at(), opened.bytes())?;
        match child.token("elementType")?.as_deref() {
            None | Some("face") => {
                let family = child.token("familyName")?.unwrap_or_default();
                subsets.push((child, family));
            }
            Some(other) => ledger.warn(child.at(), format!("subsets of elements of type {other} are not used")),
        }
    }
    let is_binding = |family: &str| family == MATERIALS;
    let chosen = match subsets.iter().any(|(_, family)| family == CAD) {
        true => Some(CAD.to_owned()),
        false => subsets.iter().find(|(_, family)| !is_binding(family)).map(|(_, family)| family.clone()),
    };
    let (mut cad, mut bindings) = (Vec::new(), Vec::new());
    for (subset, family) in subsets {
        if is_binding(&family) {
            bindings.push(subset);
        } else if Some(&family) == chosen.as_ref() {
            cad.push(subset);
        } else {
            let text = format!("subsets of the family `{family}` are not used: the faces are another family's");
            reader.ledger.info(subset.at(), text);
        }
    }
    if cad.is_empty() && bindings.is_empty() {
        let faces = vec![Face { cad: None, binding: None }];
        return Ok(Partition { subsets: cad, bindings, faces, of: Vec::new() });
    }
    let by_cad = owners(&cad, polygons, &mut reader.ledger)?;
    let by_binding = owners(&bindings, polygons, &mut reader.ledger)?;
    Ok(merge(reader, view, cad, bindings, &by_cad, &by_binding))
}

const NOBODY: u32 = u32::MAX;

/// The subset of each polygon; empty if there are no subsets.
fn owners(subsets: &[PrimView], polygons: usize, ledger: &mut Ledger) -> Result<Vec<u32>> {
    if subsets.is_empty() {
        return Ok(Vec::new());
    }
    let mut out = vec![NOBODY; polygons];
    for (number, subset) in subsets.iter().enumerate() {
        let indices = subset.read("indices", "int[]", value::ints)?.unwrap_or_default();
        let (mut outside, mut twice) = (0usize, 0usize);
        for index in indices {
            match usize::try_from(index).ok().and_then(|index| out.get_mut(index)) {
                Some(owner) if *owner == NOBODY => *owner = number as u32,
                Some(owner) if *owner == number as u32 => {}
                Some(_) => twice += 1,
                None => outside += 1,
            }
        }
        if outside > 0 {
            ledger.warn(subset.at(), format!("{outside} indices name no polygon: left out"));
        }
        if twice > 0 {
            let text =
                format!("{twice} polygons belong to an earlier subset of the family, too: the earlier one has them");
            ledger.warn(subset.at(), text);
        }
    }
    Ok(out)
}

/// One face per CAD face, cut where materials change inside it.
fn merge(
    reader: &mut Reader,
    view: &PrimView,
    subsets: Vec<PrimView>,
    bindings: Vec<PrimView>,
    by_cad: &[u32],
    by_binding: &[u32],
) -> Partition {
    let polygons = by_cad.len().max(by_binding.len());
    let owner = |owners: &[u32], polygon: usize| owners.get(polygon).copied().unwrap_or(NOBODY);
    let key = |polygon: usize| (owner(by_cad, polygon), owner(by_binding, polygon));
    // `NOBODY` sorts last: what no subset covers comes last. Empty subsets keep their number, if there is no other way
    // to count.
    let mut keys: Vec<(u32, u32)> = (0..polygons).map(key).collect();
    keys.sort_unstable();
    keys.dedup();
    let main = if subsets.is_empty() { bindings.len() } else { subsets.len() };
    for number in 0..main as u32 {
        let own = |key: &(u32, u32)| if subsets.is_empty() { key.1 } else { key.0 };
        if !keys.iter().any(|key| own(key) == number) {
            keys.push(if subsets.is_empty() { (NOBODY, number) } else { (number, NOBODY) });
        }
    }
    keys.sort_unstable();
    let place: HashMap<(u32, u32), u32> = keys.iter().enumerate().map(|(i, key)| (*key, i as u32)).collect();
    let some = |number: u32| (number != NOBODY).then_some(number as usize);
    let faces: Vec<Face> = keys.iter().map(|&(cad, binding)| Face { cad: some(cad), binding: some(binding) }).collect();
    if !subsets.is_empty() && faces.iter().any(|face| face.cad.is_none()) {
        reader.ledger.info(view.at(), "polygons outside all subsets: they make the last face");
    }
    if !subsets.is_empty() && keys.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        let text = "materials change inside a CAD face: it is cut into several, and the faces are counted anew";
        reader.ledger.info(view.at(), text);
    }
    let of = (0..polygons).map(|polygon| place.get(&key(polygon)).copied().unwrap_or(0)).collect();
    Partition { subsets, bindings, faces, of }
}
