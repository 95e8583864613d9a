//! What the asset says of itself: attributes of materials, nodes and faces, offered to the parts that they hold for.

use super::assembly::Assembly;
use super::asset_attributes::{AssetAttributes, entries};
use super::bind::{offer, said};
use super::binding_slots::{Entry, PartBound, Rank, Slot};
use super::material_mapping::mapped;
use super::select::{Candidate, Faces};
use super::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};
use eyebox_scene::Note;
use std::rc::Rc;

/// What one node says: of whole parts, and of some of their faces.
#[derive(Default)]
struct NodeSaid<'a> {
    whole: Vec<Rc<Entry>>,
    faces: Vec<(Faces, &'a Value, Vec<Rc<Entry>>)>,
}

/// Offers everything that the asset carries to `parts`. A node's attributes hold for all parts at and below it, unless
/// a node nearer to the part says otherwise.
///
/// Faults: unknown attributes, a face number that a part lacks, a part's attribute on a face. A note for a node with
/// attributes and no part.
pub fn offer_all(
    sheet: &AssetAttributes,
    assembly: &Assembly,
    parts: &[Candidate],
    bound: &mut [PartBound],
    notes: &mut Vec<Note>,
) -> Result<()> {
    let table = |value: &Option<Value>, what: &str| -> Result<Vec<Rc<Entry>>> {
        match value {
            Some(value) => said(entries(value, what)?, sheet, what, &[]),
            None => Ok(Vec::new()),
        }
    };
    let mut materials = Vec::with_capacity(assembly.materials.len());
    for material in &assembly.materials {
        let what = format!("material `{}`", material.name);
        materials.push((said(&mapped(material, notes)?, sheet, &what, &[])?, table(&material.attributes, &what)?));
    }
    let mut nodes = Vec::with_capacity(assembly.nodes.len());
    for node in &assembly.nodes {
        nodes.push(match &node.attributes {
            Some(value) => Some(of_node(value, sheet, &format!("node `{}`", node.path))?),
            None => None,
        });
    }
    let mut heard = vec![false; nodes.len()];
    for (part, candidate) in bound.iter_mut().zip(parts) {
        let Some(source) = assembly.meshes.get(candidate.mesh) else { continue };
        let mut nearer = Nearer::default();
        let mut above = Some(candidate.node);
        while let Some(index) = above {
            if let Some(Some(said)) = nodes.get(index) {
                heard[index] = true;
                let own = index == candidate.node;
                // A node with a mesh numbers the faces of that mesh: a part below it may have fewer.
                let numbered = !own && assembly.nodes.get(index).is_some_and(|node| node.mesh.is_some());
                nearer.hear(said, part, candidate, assembly, numbered)?;
            }
            // Parents stand before their children, so that this ends.
            above = assembly.nodes.get(index).and_then(|node| node.parent).filter(|parent| *parent < index);
        }
        for face in 0..candidate.faces {
            let material = source.materials.get(face).copied().flatten();
            if let Some((mapped, own)) = material.and_then(|material| materials.get(material)) {
                offer(part, mapped, Rank::Mapped, Some(&[face]));
                offer(part, own, Rank::Material, Some(&[face]));
            }
            if let Some(attributes) = source.attributes.get(face) {
                let said = table(attributes, &format!("face {face} of mesh `{}`", source.mesh.name))?;
                only_faces(&said, "on the node")?;
                offer(part, &said, Rank::Primitive, Some(&[face]));
            }
        }
    }
    for (node, _) in
        assembly.nodes.iter().zip(nodes.iter().zip(heard)).filter(|(_, (said, heard))| said.is_some() && !heard)
    {
        let at = node.attributes.as_ref().map_or(&node.at, |value| &value.at).clone();
        let text = format!("node `{}` has optical attributes, but there is no part at or below it", node.path);
        notes.push(Note::warning(at, text).code(Code::AttributesOnNothing));
    }
    Ok(())
}

/// Reads a node's table: attributes, and `faces` = [{ faces or normal, attributes }, …].
fn of_node<'a>(value: &'a Value, sheet: &AssetAttributes, what: &str) -> Result<NodeSaid<'a>> {
    let whole = said(entries(value, what)?, sheet, what, &["faces"])?;
    let mut faces = Vec::new();
    if let Some(rows) = value.get("faces") {
        let list = rows.list().ok_or_else(|| {
            Error::new(rows.at.clone(), format!("`faces` of {what} is {}", rows.kind()))
                .expected("a list of tables, each with `faces` or `normal` and attributes of those faces")
        })?;
        for row in list {
            let what = format!("`faces` of {what}");
            let which = Faces::read(row.get("faces"), row.get("normal"))?;
            let said = said(entries(row, &what)?, sheet, &what, &["faces", "normal"])?;
            if which == Faces::All {
                return Err(Error::new(row.at.clone(), format!("a row of {what} selects no faces"))
                    .expected("`faces = [0, 2]` or `normal = \"+z\"`"));
            }
            only_faces(&said, "beside `faces`")?;
            faces.push((which, row, said));
        }
    }
    Ok(NodeSaid { whole, faces })
}

fn only_faces(said: &[Rc<Entry>], instead: &str) -> Result<()> {
    match said.iter().find(|entry| entry.slot.of_part()) {
        Some(entry) => {
            let what = format!("`{}` is said of a face, but it fills a whole part", entry.key);
            Err(Error::new(entry.at.clone(), what).expected(format!("it {instead}")))
        }
        None => Ok(()),
    }
}

/// What the nodes nearer to a part have said already.
#[derive(Default)]
struct Nearer {
    whole: Vec<Slot>,
    faces: Vec<(Slot, usize)>,
}

impl Nearer {
    fn hear(
        &mut self,
        said: &NodeSaid<'_>,
        part: &mut PartBound,
        candidate: &Candidate,
        assembly: &Assembly,
        numbered: bool,
    ) -> Result<()> {
        let new: Vec<Rc<Entry>> =
            said.whole.iter().filter(|entry| !self.whole.contains(&entry.slot)).cloned().collect();
        offer(part, &new, Rank::Node, None);
        // What a node says of some faces, it means over what a node above it says of them.
        let mut now = Vec::new();
        for (which, row, entries) in &said.faces {
            let at = row.get("faces").or(row.get("normal")).map_or(&row.at, |value| &value.at);
            let faces = match which {
                Faces::Numbers(numbers) if numbered => {
                    numbers.iter().copied().filter(|number| *number < candidate.faces).collect()
                }
                which => which.of(candidate, assembly, at)?,
            };
            for face in faces {
                for entry in entries.iter().filter(|entry| !self.faces.contains(&(entry.slot, face))) {
                    offer(part, std::slice::from_ref(entry), Rank::NodeFaces, Some(&[face]));
                    now.push((entry.slot, face));
                }
            }
        }
        self.whole.extend(new.iter().map(|entry| entry.slot));
        self.faces.extend(now);
        Ok(())
    }
}
