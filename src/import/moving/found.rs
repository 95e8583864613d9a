//! What differs between an asset without a frame and at one frame after the other.

use super::pairs::{self, is_same, is_same_camera, is_same_light, is_same_material};
use super::tracks::{Room, Tracks};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::Note;
use eyebox_scene::assembly::{Assembly, MeshSource};
use eyebox_scene::motion::{MeshMotion, Motion, NodeMotion, Pose, RigMotion, Vertices};
use glam::DAffine3;
use std::collections::{BTreeSet, HashSet};

/// What differed so far.
#[derive(Debug)]
pub(super) struct Found {
    room: Room,
    nodes: Tracks<DAffine3>,
    /// Of meshes that no rig bends.
    meshes: Tracks<Vertices>,
    rigs: Tracks<Pose>,
    /// Meshes whose rig does not say all of it.
    pub broken: BTreeSet<usize>,
    /// What changes and is not carried, each once.
    left: Vec<Note>,
    said: HashSet<String>,
}

impl Found {
    pub fn new(frames: usize) -> Found {
        Found {
            room: Room::new(frames),
            nodes: Tracks::default(),
            meshes: Tracks::default(),
            rigs: Tracks::default(),
            broken: BTreeSet::new(),
            left: Vec::new(),
            said: HashSet::new(),
        }
    }

    fn leave(&mut self, at: &Where, text: String) {
        if !self.said.contains(&text) {
            self.left.push(Note::warning(at.clone(), text.clone()));
            self.said.insert(text);
        }
    }

    /// Frame number `number`: `now`, of what is written as `still`.
    ///
    /// # Errors
    /// More memory than there is.
    pub fn compare(&mut self, still: &Assembly, now: &Assembly, number: usize) -> Result<()> {
        let nodes = pairs::nodes(still, now);
        let meshes = pairs::meshes(still, now, &nodes);
        if let Some(new) = nodes.new.first().and_then(|index| now.nodes.get(*index)) {
            self.leave(&new.at, "parts that appear in time, and are not there without a frame, are not written".into());
        }
        for (index, was) in still.nodes.iter().enumerate() {
            let is = nodes.of(index).and_then(|index| now.nodes.get(index));
            let above = |parent: Option<usize>| parent.map(|parent| nodes.of(parent));
            let is = is.filter(|is| above(was.parent) == is.parent.map(Some));
            if is.is_none() {
                let text = "parts that vanish in time: they stay, and stand then as they do without a frame";
                self.leave(&was.at, text.to_owned());
            }
            let local = is.map(|is| is.local).filter(|local| *local != was.local);
            self.nodes.follow(&mut self.room, (index, number, &was.at), || was.local, local)?;
            let Some(is) = is else { continue };
            if was.mesh.map(|mesh| meshes.get(mesh).copied().flatten()) != is.mesh.map(Some) {
                self.leave(&was.at, "a part that is another mesh at times: it keeps its own".to_owned());
            }
            if !is_same(was.attributes.as_ref(), is.attributes.as_ref()) {
                let text = format!("attributes of `{}` change in time: they are as without a frame", was.path);
                self.leave(&was.at, text);
            }
        }
        self.lights(still, now);
        self.cameras(still, now);
        let materials = pairs::materials(still, now);
        for (was, is) in still.materials.iter().zip(&materials.of) {
            // One that is not there has gone with its part.
            let is = is.and_then(|index| now.materials.get(index));
            if is.is_some_and(|is| !is_same_material(was, is)) {
                let text = format!("material `{}` changes in time: it is written as it is without a frame", was.name);
                self.leave(&was.at, text);
            }
        }
        for (index, was) in still.meshes.iter().enumerate() {
            let is = meshes.get(index).copied().flatten().and_then(|index| now.meshes.get(index));
            let bound = |face: &Option<usize>| face.map(|index| materials.of(index));
            let other = |is: &MeshSource| {
                was.materials.len() == is.materials.len()
                    && !was.materials.iter().map(bound).eq(is.materials.iter().map(|face| face.map(Some)))
            };
            if is.is_some_and(other) {
                let text = format!("faces of mesh `{}` have other materials at times: they keep theirs", was.mesh.name);
                self.leave(&was.at, text);
            }
            self.mesh(index, was, is, number)?;
        }
        Ok(())
    }

    fn lights(&mut self, still: &Assembly, now: &Assembly) {
        let pairs = pairs::lights(still, now);
        for (was, is) in still.lights.iter().zip(&pairs.of) {
            let is = is.and_then(|index| now.lights.get(index));
            if is.is_none_or(|is| !is_same_light(was, is)) {
                let text = format!("light `{}` changes in time: it is written as it is without a frame", was.name);
                self.leave(&was.at, text);
            }
        }
        for new in pairs.new.iter().filter_map(|index| now.lights.get(*index)) {
            self.leave(&new.at, format!("light `{}` is not there without a frame: it is not written", new.name));
        }
    }

    fn cameras(&mut self, still: &Assembly, now: &Assembly) {
        let pairs = pairs::cameras(still, now);
        let at = |assembly: &Assembly, node: Option<usize>| {
            let node = node.and_then(|node| assembly.nodes.get(node));
            node.map_or_else(|| Where::file(&assembly.file), |node| node.at.clone())
        };
        for (was, is) in still.cameras.iter().zip(&pairs.of) {
            let what = match is.and_then(|index| now.cameras.get(index)) {
                Some(is) if is_same_camera(was, is) => continue,
                Some(_) => "the lens of camera",
                None => "the presence of camera",
            };
            let text = format!("{what} `{}` changes in time: only its place moves", was.name);
            self.leave(&at(still, was.node), text);
        }
        for new in pairs.new.iter().filter_map(|index| now.cameras.get(*index)) {
            let text = format!("camera `{}` is not there without a frame: it is not written", new.name);
            self.leave(&at(now, new.node), text);
        }
    }

    /// Mesh number `index`; `is` none where it is not there.
    ///
    /// # Errors
    /// More memory than there is.
    pub fn mesh(&mut self, index: usize, was: &MeshSource, is: Option<&MeshSource>, number: usize) -> Result<()> {
        let as_was = is.is_none_or(|is| self.is_as_cut(was, is));
        let place = (index, number, &was.at);
        let Some(own) = &was.rig else {
            let moved = is.filter(|is| {
                as_was && (was.mesh.positions != is.mesh.positions || was.mesh.normals != is.mesh.normals)
            });
            return self.meshes.follow(&mut self.room, place, || vertices(was), moved.map(vertices));
        };
        // Triangles say nothing of what bends a mesh.
        let pose = match is.map(|is| &is.rig) {
            Some(Some(rig))
                if rig.is_pose() || rig.rest == own.rest && rig.targets == own.targets && rig.skin == own.skin =>
            {
                Some(&rig.pose)
            }
            Some(_) => {
                self.broken.insert(index);
                None
            }
            None => None,
        };
        let moved = pose.filter(|pose| **pose != own.pose).cloned();
        self.rigs.follow(&mut self.room, place, || own.pose.clone(), moved)
    }

    /// Whether vertices can be told from each other by their places in the list; and says what does not move of the rest.
    fn is_as_cut(&mut self, was: &MeshSource, is: &MeshSource) -> bool {
        let (a, b) = (&was.mesh, &is.mesh);
        // Joints that mirror turn triangles round, wherever their mesh is read.
        let turned = |(a, b): (&[u32; 3], &[u32; 3])| a == b || was.rig.is_some() && [a[0], a[2], a[1]] == *b;
        let same_triangles = a.triangles.len() == b.triangles.len() && a.triangles.iter().zip(&b.triangles).all(turned);
        let as_was = same_triangles && a.positions.len() == b.positions.len() && a.normals.len() == b.normals.len();
        if !as_was {
            // Under what bends it, normals that differ at rest may fall together, and their vertices with them.
            let rigs = was.rig.is_some() && is.rig.is_some();
            let welded = rigs && a.triangles.len() == b.triangles.len() && a.positions.len() != b.positions.len();
            let what = match was.rig {
                Some(_) => "it keeps its own, and what bends it bends them",
                None => "it stands then as it does without a frame",
            };
            if !welded {
                self.leave(&was.at, format!("mesh `{}` has other triangles at times: {what}", a.name));
            }
        } else if a.uvs != b.uvs || a.second_uvs != b.second_uvs || a.colors != b.colors {
            let text = format!("texture coordinates or colours of mesh `{}` change in time: they stay", a.name);
            self.leave(&was.at, text);
        }
        let faces = was.attributes.iter().zip(&is.attributes);
        if as_was && !faces.clone().all(|(a, b)| is_same(a.as_ref(), b.as_ref())) {
            let text = format!("attributes of faces of mesh `{}` change in time: they are as without a frame", a.name);
            self.leave(&was.at, text);
        }
        as_was
    }

    /// How nodes and rigs move: what says whether the rigs can be written.
    pub fn settle(&mut self, motion: &mut Motion) {
        let (nodes, rigs) = (std::mem::take(&mut self.nodes), std::mem::take(&mut self.rigs));
        motion.nodes = nodes.into_all().map(|(node, locals)| NodeMotion { node, locals }).collect();
        motion.rigs = rigs.into_all().map(|(mesh, poses)| RigMotion { mesh, poses }).collect();
    }

    /// The vertices that move by themselves, and what is not carried.
    pub fn finish(self) -> (Vec<MeshMotion>, Vec<Note>) {
        (self.meshes.into_all().map(|(mesh, shapes)| MeshMotion { mesh, shapes }).collect(), self.left)
    }
}

fn vertices(source: &MeshSource) -> Vertices {
    Vertices { positions: source.mesh.positions.clone(), normals: source.mesh.normals.clone() }
}
