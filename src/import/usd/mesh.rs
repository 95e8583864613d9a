//! UsdGeomMesh into a mesh with CAD faces. Which meshes are one and the same is decided here, too.

use super::attribute::PrimView;
use super::faces::{self, Partition};
use super::hierarchy::{self, Above};
use super::primvar::{self, Primvar, Sizes};
use super::reader::Reader;
use super::triangulate::{self, Met};
use super::{binding, optics, value};
use crate::base::fault::Result;
use crate::import::assembly::MeshSource;
use crate::import::gltf::mesh::append;
use crate::import::gltf::normals::{Settled, are_sound, flat_shaded, settle};
use crate::import::gltf::primitive::FaceMesh;
use crate::import::normals::repair;
use crate::import::value::Value;
use crate::scene::{Mesh, Severity};
use glam::DVec3;
use std::collections::HashMap;

/// Meshes by where they come from and by what they are.
#[derive(Debug, Default)]
pub(super) struct Known {
    by_source: HashMap<(String, binding::Inherited), Option<usize>>,
    by_content: HashMap<blake3::Hash, Vec<usize>>,
}

/// Bytes of a vertex with normal and texture coordinates, and of a triangle.
const VERTEX: usize = 32;
const TRIANGLE: usize = 12;

/// The mesh of a prim, an index of `Assembly::meshes`; none if it has no surface.
pub(super) fn of(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<Option<usize>> {
    shared(reader, view, below, build)
}

/// As [`of`], with another builder.
pub(super) fn shared(
    reader: &mut Reader,
    view: &PrimView,
    below: &Above,
    build: impl FnOnce(&mut Reader, &PrimView, &Above) -> Result<Option<MeshSource>>,
) -> Result<Option<usize>> {
    let key = (hierarchy::shared_path(view, below), below.handed.material.clone());
    if let Some(&known) = reader.meshes.by_source.get(&key) {
        return Ok(known);
    }
    let index = build(reader, view, below)?.map(|source| keep(reader, source));
    reader.meshes.by_source.insert(key, index);
    Ok(index)
}

/// Adds a mesh, or finds one that is the same to the last bit: references share nothing in USD, but they do here.
fn keep(reader: &mut Reader, source: MeshSource) -> usize {
    let mut hasher = blake3::Hasher::new();
    let mesh = &source.mesh;
    let mut floats = |values: &mut dyn Iterator<Item = f32>| {
        let mut block = Vec::with_capacity(1 << 12);
        for value in values {
            block.extend_from_slice(&value.to_bits().to_le_bytes());
            if block.len() >= 1 << 12 {
                hasher.update(&block);
                block.clear();
            }
        }
        hasher.update(&block);
    };
    floats(&mut mesh.positions.iter().flatten().copied());
    floats(&mut mesh.normals.iter().flatten().copied());
    let same = |other: &MeshSource| {
        let bits = |a: &[[f32; 3]], b: &[[f32; 3]]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits))
        };
        let attributes = |a: &Option<Value>, b: &Option<Value>| match (a, b) {
            (Some(a), Some(b)) => a.same(b),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        let (a, b) = (mesh, &other.mesh);
        a.name == b.name
            && a.triangles == b.triangles
            && a.faces == b.faces
            && bits(&a.positions, &b.positions)
            && bits(&a.normals, &b.normals)
            && a.uvs.len() == b.uvs.len()
            && a.uvs.iter().zip(&b.uvs).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits))
            && source.materials == other.materials
            && source.attributes.len() == other.attributes.len()
            && source.attributes.iter().zip(&other.attributes).all(|(a, b)| attributes(a, b))
    };
    let found = reader.meshes.by_content.entry(hasher.finalize()).or_default();
    // Looking at a few is enough: many with the same points that differ otherwise are no sharing case.
    if let Some(&known) = found.iter().take(16).find(|&&known| reader.assembly.meshes.get(known).is_some_and(same)) {
        return known;
    }
    let index = reader.assembly.meshes.len();
    found.push(index);
    reader.assembly.meshes.push(source);
    index
}

/// Polygons as the file has them, checked.
struct Polygons {
    points: Vec<[f32; 3]>,
    indices: Vec<i32>,
    /// First corner of each polygon, and the count of all corners at the end.
    starts: Vec<u32>,
    holes: Vec<i32>,
    left_handed: bool,
}

impl Polygons {
    fn sizes(&self) -> Sizes {
        Sizes { points: self.points.len(), polygons: self.starts.len() - 1, corners: self.indices.len() }
    }
    fn point(&self, corner: usize) -> usize {
        self.indices.get(corner).and_then(|&index| usize::try_from(index).ok()).unwrap_or(0)
    }
    fn position(&self, point: usize) -> [f32; 3] {
        self.points.get(point).copied().unwrap_or_default()
    }
}

fn build(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<Option<MeshSource>> {
    let Some(polygons) = polygons(reader, view)? else { return Ok(None) };
    let sizes = polygons.sizes();
    let normals = primvar::normals(view, sizes, &mut reader.ledger)?;
    let uvs = primvar::uvs(view, sizes, &mut reader.ledger)?;
    subdivision(reader, view, normals.is_some())?;
    let partition = faces::partition(reader, view, sizes.polygons)?;
    let whole = binding::bound(reader, view, &below.handed.material);
    let (mut materials, mut attributes) = (Vec::new(), Vec::new());
    let mut bindings = Vec::new();
    for binding in &partition.bindings {
        bindings.push(binding::bound_to_subset(reader, view, binding, &below.handed.material)?);
    }
    let mut cad = Vec::new();
    for subset in &partition.subsets {
        cad.push((
            binding::bound_to_subset(reader, view, subset, &below.handed.material)?,
            optics::face(reader, subset)?,
        ));
    }
    for face in &partition.faces {
        let (own, said) = face.cad.and_then(|index| cad.get(index).cloned()).unwrap_or_default();
        let bound = face.binding.and_then(|index| bindings.get(index).copied().flatten());
        materials.push(bound.or(own).or(whole));
        attributes.push(said);
    }
    let mut mesh = Mesh { name: view.name().to_owned(), ..Mesh::default() };
    let data = Data { polygons: &polygons, normals: normals.as_ref(), uvs: uvs.as_ref() };
    let mut scratch = Scratch::new();
    for (number, own) in grouped(&partition, &polygons).into_iter().enumerate() {
        let face = face(reader, view, &data, &own, number, &mut scratch)?;
        append(&mut mesh, face).ok_or_else(|| view.fault("the mesh has more than 4294967295 vertices or triangles"))?;
    }
    Ok(Some(MeshSource { mesh, materials, attributes, at: view.at() }))
}

/// Reads and checks the topology; none with a note if there is no surface.
fn polygons(reader: &mut Reader, view: &PrimView) -> Result<Option<Polygons>> {
    let points = match view.get("points")?.map(value::triples) {
        Some(Some(points)) => points,
        Some(None) => {
            reader
                .ledger
                .warn(view.at_property("points"), "a value of another type than point3f[]: taken as no points");
            Vec::new()
        }
        None => Vec::new(),
    };
    let counts = view.read("faceVertexCounts", "int[]", value::ints)?.unwrap_or_default();
    let indices = view.read("faceVertexIndices", "int[]", value::ints)?.unwrap_or_default();
    if points.is_empty() || counts.is_empty() {
        reader.ledger.info(view.at(), "a mesh without points or polygons");
        return Ok(None);
    }
    reader.charge(view.path(), points.len() + indices.len() + counts.len(), 16)?;
    if let Some(bad) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let [x, y, z] = points[bad];
        return Err(view.fault_in("points", format!("point {bad} is at ({x}, {y}, {z})")).expected("finite points"));
    }
    let mut starts = Vec::with_capacity(counts.len() + 1);
    let mut corner = 0u32;
    for (polygon, &count) in counts.iter().enumerate() {
        starts.push(corner);
        let count = u32::try_from(count).map_err(|_| {
            view.fault_in("faceVertexCounts", format!("polygon {polygon} has {count} corners")).expected("at least 3")
        })?;
        corner = corner.saturating_add(count);
    }
    starts.push(corner);
    if corner as usize != indices.len() {
        let what = format!("the polygons have {corner} corners, but there are {} indices", indices.len());
        return Err(view.fault_in("faceVertexIndices", what).expected("one index per corner"));
    }
    let inside = |&&index: &&i32| !usize::try_from(index).is_ok_and(|index| index < points.len());
    if let Some(bad) = indices.iter().find(inside) {
        let fault = view.fault_in("faceVertexIndices", format!("index {bad} is no point"));
        return Err(fault.expected(format!("0 to {}", points.len() - 1)));
    }
    let few = counts.iter().filter(|&&count| count < 3).count();
    if few > 0 {
        let text = "polygons with fewer than three corners have no surface: left out";
        reader.ledger.notes.add_many(Severity::Warning, view.at_property("faceVertexCounts"), text, few);
    }
    let mut holes = view.read("holeIndices", "int[]", value::ints)?.unwrap_or_default();
    holes.sort_unstable();
    let left_handed = match view.token("orientation")?.as_deref() {
        None | Some("rightHanded") => false,
        Some("leftHanded") => true,
        Some(other) => {
            let fault = view.fault_in("orientation", format!("the orientation `{other}`"));
            return Err(fault.expected("rightHanded or leftHanded"));
        }
    };
    Ok(Some(Polygons { points, indices, starts, holes, left_handed }))
}

/// Says what becomes of a subdivision surface: we take the polygons of its cage.
fn subdivision(reader: &mut Reader, view: &PrimView, has_normals: bool) -> Result<()> {
    let said = view.token("subdivisionScheme")?;
    let scheme = said.as_deref().unwrap_or("catmullClark");
    match scheme {
        "none" | "bilinear" => {}
        "catmullClark" | "loop" => {
            let by = if said.is_some() { "" } else { " (USD's fallback, nothing is said)" };
            let with = if has_normals { ", with the normals that are given" } else { ", flat" };
            let text = format!(
                "a {scheme} subdivision surface{by}: its polygons are taken as they are{with}; say `subdivisionScheme = \"none\"` if that is meant"
            );
            reader.ledger.warn(view.at(), text);
        }
        other => {
            let fault = view.fault_in("subdivisionScheme", format!("the scheme `{other}`"));
            return Err(fault.expected("none, catmullClark, loop or bilinear"));
        }
    }
    Ok(())
}

/// The polygons of each face, in order, without holes and without polygons that have no surface.
fn grouped(partition: &Partition, polygons: &Polygons) -> Vec<Vec<u32>> {
    let mut out = vec![Vec::new(); partition.faces.len()];
    for (polygon, ends) in polygons.starts.windows(2).enumerate() {
        if ends[1] - ends[0] < 3 || polygons.holes.binary_search(&(polygon as i32)).is_ok() {
            continue;
        }
        let face = partition.of.get(polygon).map_or(0, |&face| face as usize);
        if let Some(own) = out.get_mut(face) {
            own.push(polygon as u32);
        }
    }
    out
}

struct Data<'a> {
    polygons: &'a Polygons,
    normals: Option<&'a Primvar<[f32; 3]>>,
    uvs: Option<&'a Primvar<[f32; 2]>>,
}

/// Tables over all points, kept from face to face.
struct Scratch {
    /// Per point: the number of the face that last used it, and its first vertex there.
    used: Vec<(u32, u32)>,
    /// Per vertex: the next vertex of the same point.
    next: Vec<u32>,
}

impl Scratch {
    fn new() -> Self {
        Scratch { used: Vec::new(), next: Vec::new() }
    }
}

/// One CAD face.
fn face(
    reader: &mut Reader,
    view: &PrimView,
    data: &Data<'_>,
    own: &[u32],
    number: usize,
    scratch: &mut Scratch,
) -> Result<FaceMesh> {
    let polygons = data.polygons;
    let span = |polygon: u32| {
        let polygon = polygon as usize;
        let start = |polygon: usize| polygons.starts.get(polygon).map_or(0, |&start| start as usize);
        start(polygon)..start(polygon + 1)
    };
    let triangles: usize = own.iter().map(|&polygon| span(polygon).len() - 2).sum();
    // At most three vertices a triangle, and the tables of the repair.
    reader.charge(view.path(), triangles, 3 * VERTEX + 2 * TRIANGLE)?;
    // (polygon, its corners) of each triangle.
    let mut corners: Vec<(u32, [u32; 3])> = Vec::with_capacity(triangles);
    let (mut outline, mut cut, mut ragged) = (Vec::new(), Vec::new(), 0usize);
    for &polygon in own {
        let span = span(polygon);
        let start = span.start;
        cut.clear();
        if span.len() == 3 {
            cut.push([0, 1, 2]);
        } else {
            outline.clear();
            outline.extend(span.map(|corner| DVec3::from(polygons.position(polygons.point(corner)).map(f64::from))));
            ragged += usize::from(triangulate::polygon(&outline, &mut cut) == Met::Ragged);
        }
        for &[a, b, c] in &cut {
            let [a, b, c] = [a, b, c].map(|corner| start as u32 + corner);
            corners.push((polygon, if polygons.left_handed { [a, c, b] } else { [a, b, c] }));
        }
    }
    if ragged > 0 {
        let text = "a polygon that crosses itself: cut as a fan";
        reader.ledger.notes.add_many(Severity::Warning, view.at(), text, ragged);
    }
    let follows = data.normals.is_none_or(Primvar::follows_points) && data.uvs.is_none_or(Primvar::follows_points);
    let mut face = if follows { by_points(data, &corners) } else { by_corners(data, &corners, number as u32, scratch) };
    for uv in face.uvs.iter_mut().filter(|uv| !uv.iter().all(|x| x.is_finite())) {
        reader.ledger.warn(view.at(), "texture coordinates that are not finite: set to 0");
        *uv = [0.0; 2];
    }
    if data.normals.is_none() {
        reader.ledger.info(view.at(), "no normals: the faces are flat-shaded");
        let (flat, without_area) = flat_shaded(&face);
        if without_area > 0 {
            let text = "a triangle without area and without normals";
            reader.ledger.notes.add_many(Severity::Info, view.at(), text, without_area);
        }
        return Ok(flat);
    }
    mend(reader, view, &mut face, number);
    Ok(face)
}

/// Vertices are points, in the order of the points; those that no triangle uses are left out.
fn by_points(data: &Data<'_>, corners: &[(u32, [u32; 3])]) -> FaceMesh {
    let polygons = data.polygons;
    let point = |corner: u32| polygons.point(corner as usize) as u32;
    let all = polygons.points.len();
    let mut out = FaceMesh::default();
    // A table of all points is quicker; a small face of a large mesh is better sorted.
    let used: Vec<u32> = if all / 4 <= 3 * corners.len() {
        let mut table = vec![u32::MAX; all];
        corners.iter().for_each(|(_, three)| three.iter().for_each(|&corner| table[point(corner) as usize] = 0));
        let used: Vec<u32> = (0..all as u32).filter(|&point| table[point as usize] == 0).collect();
        used.iter().enumerate().for_each(|(new, &point)| table[point as usize] = new as u32);
        out.triangles = corners.iter().map(|(_, three)| three.map(|corner| table[point(corner) as usize])).collect();
        used
    } else {
        let mut used: Vec<u32> = corners.iter().flat_map(|(_, three)| three.map(point)).collect();
        used.sort_unstable();
        used.dedup();
        let place = |corner: u32| used.partition_point(|&other| other < point(corner)) as u32;
        out.triangles = corners.iter().map(|(_, three)| three.map(place)).collect();
        used
    };
    out.positions.reserve_exact(used.len());
    out.normals.reserve_exact(if data.normals.is_some() { used.len() } else { 0 });
    out.uvs.reserve_exact(if data.uvs.is_some() { used.len() } else { 0 });
    for point in used.iter().map(|&point| point as usize) {
        out.positions.push(polygons.position(point));
        // Values that follow points need neither polygon nor corner.
        out.normals.extend(data.normals.map(|normals| normals.at(0, 0, point).unwrap_or_default()));
        out.uvs.extend(data.uvs.map(|uvs| uvs.at(0, 0, point).unwrap_or_default()));
    }
    out
}

/// A vertex for each different (point, normal, texture coordinate), in the order of first use.
fn by_corners(data: &Data<'_>, corners: &[(u32, [u32; 3])], number: u32, scratch: &mut Scratch) -> FaceMesh {
    const NONE: u32 = u32::MAX;
    /// More different values at one point are not searched through: a hostile file could ask for all pairs.
    const MOST: usize = 64;
    let mut out = FaceMesh::default();
    scratch.next.clear();
    scratch.used.resize(data.polygons.points.len(), (NONE, 0));
    let vertex = |polygon: usize, corner: usize, out: &mut FaceMesh, scratch: &mut Scratch| -> u32 {
        let point = data.polygons.point(corner);
        let normal = data.normals.map(|normals| normals.at(polygon, corner, point).unwrap_or_default());
        let uv = data.uvs.map(|uvs| uvs.at(polygon, corner, point).unwrap_or_default());
        let (face, mut known) = scratch.used[point];
        if face != number {
            known = NONE;
        }
        let first = known;
        let mut last = NONE;
        for _ in 0..MOST {
            if known == NONE {
                break;
            }
            let at = known as usize;
            let same_normal = normal.is_none_or(|n| out.normals[at].map(f32::to_bits) == n.map(f32::to_bits));
            let same_uv = uv.is_none_or(|uv| out.uvs[at].map(f32::to_bits) == uv.map(f32::to_bits));
            if same_normal && same_uv {
                return known;
            }
            last = known;
            known = scratch.next[at];
        }
        let new = out.positions.len() as u32;
        out.positions.push(data.polygons.position(point));
        out.normals.extend(normal);
        out.uvs.extend(uv);
        scratch.next.push(NONE);
        if first == NONE {
            scratch.used[point] = (number, new);
        } else if known == NONE && last != NONE {
            scratch.next[last as usize] = new;
        }
        new
    };
    for &(polygon, three) in corners {
        let triangle = three.map(|corner| vertex(polygon as usize, corner as usize, &mut out, scratch));
        out.triangles.push(triangle);
    }
    out
}

/// Brings normals to unit length and mends those that contradict their triangles, and says so: as for glTF.
fn mend(reader: &mut Reader, view: &PrimView, face: &mut FaceMesh, number: usize) {
    let given = std::mem::take(&mut face.normals);
    let Settled { normals, off, broken } = settle(given, &face.positions, &face.triangles, 1e-3);
    face.normals = normals;
    let notes = &mut reader.ledger.notes;
    if off > 0 {
        notes.add_many(Severity::Info, view.at(), "normals that are not of unit length: normalised", off);
    }
    if broken > 0 {
        let text = "a normal that is zero or not finite: computed from the triangles around its vertex";
        notes.add_many(Severity::Warning, view.at(), text, broken);
    }
    if are_sound(&face.positions, &face.normals, &face.triangles) {
        return;
    }
    let found = repair(&face.positions, &mut face.normals, &face.triangles);
    if found.flipped + found.replaced > 0 {
        let (flipped, replaced, worst) = (found.flipped, found.replaced, found.worst_deg);
        let name = view.path().as_str().trim_start_matches('/');
        let text = format!(
            "{name} face {number}: normals contradict their triangles by up to {worst:.0}°: {flipped} turned round, {replaced} replaced"
        );
        reader.ledger.warn(view.at(), text);
    }
    if found.inverted {
        let text = "the normals of a face point into the side that its winding calls the inside: kept as they are";
        reader.ledger.warn(view.at(), text);
    }
}
