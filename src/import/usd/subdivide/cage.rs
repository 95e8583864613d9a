//! What a mesh says of its cage: which edges and corners are sharp, what is a hole, how boundaries and texture coordinates
//! are taken (UsdGeomMesh, "Subdivision").

use super::super::attribute::PrimView;
use super::super::polygons::Polygons;
use super::super::reader::Reader;
use super::super::value;
use super::Scheme;
use eyebox_base::error::Result;
use opensubdiv_rs::sdc::{FVarLinearInterpolation, Options, TriangleSubdivision, VtxBoundaryInterpolation};
use std::collections::{HashMap, HashSet};

/// A cage as the crate takes it.
#[derive(Debug)]
pub(super) struct Cage {
    /// Corners of each polygon.
    pub sizes: Vec<usize>,
    /// The points of all corners.
    pub corners: Vec<u32>,
    /// The polygon of the file that each polygon is.
    pub kept: Vec<u32>,
    /// Polygons (of the file) that are not drawn, sorted.
    pub undrawn: Vec<u32>,
    pub creases: Vec<[u32; 2]>,
    pub crease_weights: Vec<f32>,
    pub pinned: Vec<u32>,
    pub pinned_weights: Vec<f32>,
    pub options: Options,
}

/// The crate looks at all pairs of corners of a polygon.
const MOST_CORNERS: usize = 4096;

impl Cage {
    /// The cage; or why there is none.
    ///
    /// # Errors
    /// Values of other types than the schema's.
    pub fn read(
        reader: &mut Reader,
        view: &PrimView,
        scheme: Scheme,
        polygons: &Polygons,
    ) -> Result<std::result::Result<Cage, String>> {
        let mut cage = Cage {
            sizes: Vec::new(),
            corners: Vec::new(),
            kept: Vec::new(),
            undrawn: Vec::new(),
            creases: Vec::new(),
            crease_weights: Vec::new(),
            pinned: Vec::new(),
            pinned_weights: Vec::new(),
            options: options(view)?,
        };
        for polygon in 0..polygons.corners.polygons() {
            let points = polygons.corners.points().get(polygons.corners.span(polygon)).unwrap_or_default();
            match (points.len(), scheme) {
                (0..=2, _) => continue,
                (count, _) if count > MOST_CORNERS => return Ok(Err(format!("polygon {polygon} has {count} corners"))),
                (4.., Scheme::Loop) => return Ok(Err(format!("polygon {polygon} is no triangle"))),
                (_, Scheme::Loop | Scheme::CatmullClark) => {}
            }
            cage.sizes.push(points.len());
            cage.corners.extend_from_slice(points);
            cage.kept.push(polygon as u32);
            if !polygons.is_drawn(polygon) {
                cage.undrawn.push(polygon as u32);
            }
        }
        if cage.sizes.is_empty() {
            return Ok(Err("it has no polygons".to_owned()));
        }
        reader.charge(view.path(), cage.corners.len(), 48)?;
        let edges = Edges::of(&cage);
        if cage.options.vtx_boundary_interpolation == VtxBoundaryInterpolation::None {
            cage.leave_out_boundary(&edges);
        }
        cage.read_creases(reader, view, &edges)?;
        cage.read_corners(reader, view, polygons.points.len())?;
        Ok(Ok(cage))
    }

    /// Without rules for the boundary there is no surface beside it: the polygons that touch it only hold the others.
    fn leave_out_boundary(&mut self, edges: &Edges) {
        let border: HashSet<u32> =
            edges.faces.iter().filter(|(_, count)| **count == 1).flat_map(|(ends, _)| *ends).collect();
        let mut start = 0;
        for (size, polygon) in self.sizes.iter().zip(&self.kept) {
            let points = self.corners.get(start..start + size).unwrap_or_default();
            if points.iter().any(|point| border.contains(point)) {
                self.undrawn.push(*polygon);
            }
            start += size;
        }
        self.undrawn.sort_unstable();
        self.undrawn.dedup();
    }

    /// `creaseIndices`, `creaseLengths`, `creaseSharpnesses`: chains of edges, with a sharpness for each or for each edge.
    fn read_creases(&mut self, reader: &mut Reader, view: &PrimView, edges: &Edges) -> Result<()> {
        let indices = view.read("creaseIndices", "int[]", value::ints)?.unwrap_or_default();
        let lengths = view.read("creaseLengths", "int[]", value::ints)?.unwrap_or_default();
        let weights = view.read("creaseSharpnesses", "float[]", value::wide_numbers)?.unwrap_or_default();
        if indices.is_empty() && lengths.is_empty() {
            return Ok(());
        }
        reader.charge(view.path(), indices.len(), 32)?;
        let chains: Option<Vec<usize>> = lengths.iter().map(|length| usize::try_from(*length).ok()).collect();
        let chains = chains.unwrap_or_default();
        let segments: usize = chains.iter().map(|length| length.saturating_sub(1)).fold(0, usize::saturating_add);
        let total = chains.iter().copied().fold(0, usize::saturating_add);
        let per_edge = weights.len() == segments && segments != chains.len();
        if total != indices.len() || !per_edge && weights.len() != chains.len() {
            let text = format!(
                "creases of {total} points, {} indices and {} sharpnesses do not fit each other: no creases",
                indices.len(),
                weights.len()
            );
            reader.ledger.warn(view.at_property("creaseLengths"), text);
            return Ok(());
        }
        let (mut start, mut segment, mut work) = (0, 0, 0usize);
        let mut lost = 0usize;
        for (chain, length) in chains.iter().enumerate() {
            for pair in indices.get(start..start + length).unwrap_or_default().windows(2) {
                let &[a, b] = pair else { continue };
                let weight = weights.get(if per_edge { segment } else { chain }).copied().unwrap_or(0.0);
                segment += 1;
                let ends = [a as u32, b as u32];
                if !edges.faces.contains_key(&sorted(ends)) {
                    lost += 1;
                    continue;
                }
                work = work.saturating_add(edges.around.get(&ends[0]).copied().unwrap_or(0));
                self.creases.push(ends);
                self.crease_weights.push(weight as f32);
            }
            start += length;
        }
        // The crate looks for a crease among all edges of its first point.
        reader.charge(view.path(), work, 1)?;
        if lost > 0 {
            let text = format!("{lost} creases are between points that no edge joins: left out");
            reader.ledger.warn(view.at_property("creaseIndices"), text);
        }
        Ok(())
    }

    /// `cornerIndices` and `cornerSharpnesses`.
    fn read_corners(&mut self, reader: &mut Reader, view: &PrimView, points: usize) -> Result<()> {
        let indices = view.read("cornerIndices", "int[]", value::ints)?.unwrap_or_default();
        let weights = view.read("cornerSharpnesses", "float[]", value::wide_numbers)?.unwrap_or_default();
        if indices.len() != weights.len() {
            let text = format!("{} corners and {} sharpnesses: no corners", indices.len(), weights.len());
            reader.ledger.warn(view.at_property("cornerIndices"), text);
            return Ok(());
        }
        let mut lost = 0usize;
        for (index, weight) in indices.into_iter().zip(weights) {
            if usize::try_from(index).is_ok_and(|index| index < points) {
                self.pinned.push(index as u32);
                self.pinned_weights.push(weight as f32);
            } else {
                lost += 1;
            }
        }
        if lost > 0 {
            reader.ledger.warn(view.at_property("cornerIndices"), format!("{lost} corners are no points: left out"));
        }
        Ok(())
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The edges of a cage.
struct Edges {
    /// Polygons at an edge, by its ends.
    faces: HashMap<[u32; 2], u32>,
    /// Edges at a point.
    around: HashMap<u32, usize>,
}

impl Edges {
    fn of(cage: &Cage) -> Edges {
        let mut out = Edges { faces: HashMap::new(), around: HashMap::new() };
        let mut start = 0;
        for size in &cage.sizes {
            let points = cage.corners.get(start..start + size).unwrap_or_default();
            for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
                let count = out.faces.entry(sorted([*a, *b])).or_insert(0);
                *count += 1;
                if *count == 1 {
                    *out.around.entry(*a).or_insert(0) += 1;
                    *out.around.entry(*b).or_insert(0) += 1;
                }
            }
            start += size;
        }
        out
    }
}

/// The rules that a mesh asks for; what is not said is as UsdGeomMesh has it.
fn options(view: &PrimView) -> Result<Options> {
    let boundary = match view.token("interpolateBoundary")?.as_deref() {
        None | Some("edgeAndCorner") => VtxBoundaryInterpolation::EdgeAndCorner,
        Some("edgeOnly") => VtxBoundaryInterpolation::EdgeOnly,
        Some("none") => VtxBoundaryInterpolation::None,
        Some(other) => return Err(unknown(view, "interpolateBoundary", other, &["none", "edgeOnly", "edgeAndCorner"])),
    };
    let linear = match view.token("faceVaryingLinearInterpolation")?.as_deref() {
        None | Some("cornersPlus1") => FVarLinearInterpolation::CornersPlus1,
        Some("none") => FVarLinearInterpolation::None,
        Some("cornersOnly") => FVarLinearInterpolation::CornersOnly,
        Some("cornersPlus2") => FVarLinearInterpolation::CornersPlus2,
        Some("boundaries") => FVarLinearInterpolation::Boundaries,
        Some("all") => FVarLinearInterpolation::All,
        Some(other) => {
            let known = ["none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"];
            return Err(unknown(view, "faceVaryingLinearInterpolation", other, &known));
        }
    };
    let triangles = match view.token("triangleSubdivisionRule")?.as_deref() {
        None | Some("catmullClark") => TriangleSubdivision::Catmark,
        Some("smooth") => TriangleSubdivision::Smooth,
        Some(other) => return Err(unknown(view, "triangleSubdivisionRule", other, &["catmullClark", "smooth"])),
    };
    let options = Options::new().with_vtx_boundary_interpolation(boundary).with_triangle_subdivision(triangles);
    Ok(options.with_fvar_linear_interpolation(linear))
}

fn unknown(view: &PrimView, name: &str, given: &str, known: &[&str]) -> Box<eyebox_base::Error> {
    let fault = view.fault_in(name, format!("the value `{}`", given.escape_debug()));
    fault.expected(known.join(", ")).nearest(given, known.iter().copied())
}
