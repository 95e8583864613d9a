//! The topology of a mesh: points, and the polygons over them, read in an order that holds few arrays at a time.

use super::attribute::PrimView;
use super::primvar::Sizes;
use super::reader::Reader;
use super::value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};
use eyebox_scene::Severity;

/// Polygons as the file has them, checked.
#[derive(Debug, Clone)]
pub(super) struct Polygons {
    pub points: Vec<[f32; 3]>,
    pub corners: Corners,
    /// Sorted.
    pub holes: Vec<i32>,
    pub left_handed: bool,
}

/// The points of all corners, polygon by polygon.
#[derive(Debug, Clone)]
pub(super) enum Corners {
    /// Nothing but triangles: the array that the scene gets in the end, if all goes well.
    Triangles(Vec<[u32; 3]>),
    Mixed {
        points: Vec<u32>,
        /// First corner of each polygon, and the count of all corners at the end.
        starts: Vec<u32>,
    },
}

/// What is wrong with counts and indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wrong {
    Negative { polygon: usize, count: i32 },
    Corners { counted: u32, indices: usize },
}

impl Wrong {
    fn fault(self, view: &PrimView) -> Box<Error> {
        match self {
            Wrong::Negative { polygon, count } => view
                .fault_in("faceVertexCounts", format!("polygon {polygon} has {count} corners"))
                .expected("at least 3"),
            Wrong::Corners { counted, indices } => {
                let what = format!("the polygons have {counted} corners, but there are {indices} indices");
                view.fault_in("faceVertexIndices", what).expected("one index per corner")
            }
        }
    }
}

impl Corners {
    /// Indices are taken bit for bit: negative ones become large, and no point has their number.
    pub fn new(counts: Vec<i32>, indices: Vec<i32>) -> std::result::Result<Self, Wrong> {
        let (threes, rest) = indices.as_chunks::<3>();
        if threes.len() == counts.len() && rest.is_empty() && counts.iter().all(|&count| count == 3) {
            drop(counts);
            return Ok(Corners::Triangles(threes.iter().map(|three| three.map(|index| index as u32)).collect()));
        }
        Self::mixed(counts, indices)
    }

    /// As [`new`](Self::new), for polygons of any kind.
    pub fn mixed(counts: Vec<i32>, indices: Vec<i32>) -> std::result::Result<Self, Wrong> {
        let mut starts = Vec::with_capacity(counts.len() + 1);
        let mut corner = 0u32;
        for (polygon, &count) in counts.iter().enumerate() {
            starts.push(corner);
            let count = u32::try_from(count).map_err(|_| Wrong::Negative { polygon, count })?;
            corner = corner.saturating_add(count);
        }
        starts.push(corner);
        if corner as usize != indices.len() {
            return Err(Wrong::Corners { counted: corner, indices: indices.len() });
        }
        Ok(Corners::Mixed { points: indices.into_iter().map(|index| index as u32).collect(), starts })
    }

    /// The points of the corners, all in a row.
    pub fn points(&self) -> &[u32] {
        match self {
            Corners::Triangles(triangles) => triangles.as_flattened(),
            Corners::Mixed { points, .. } => points,
        }
    }
    pub fn polygons(&self) -> usize {
        match self {
            Corners::Triangles(triangles) => triangles.len(),
            Corners::Mixed { starts, .. } => starts.len().saturating_sub(1),
        }
    }
    /// The corners of a polygon that there is.
    pub fn span(&self, polygon: usize) -> std::ops::Range<usize> {
        match self {
            Corners::Triangles(_) => 3 * polygon..3 * polygon + 3,
            Corners::Mixed { starts, .. } => {
                let start = |polygon: usize| starts.get(polygon).map_or(0, |&start| start as usize);
                start(polygon)..start(polygon + 1)
            }
        }
    }
    /// The first index that is no point of `points`.
    pub fn outside(&self, points: usize) -> Option<i32> {
        let bound = u32::try_from(points).unwrap_or(u32::MAX).min(1 << 31);
        // All of them at once is quicker than one after the other.
        let worst = self.points().iter().fold(0, |worst, &point| worst.max(point));
        if worst < bound {
            return None;
        }
        self.points().iter().find(|&&point| point >= bound).map(|&point| point as i32)
    }
}

impl Polygons {
    pub fn sizes(&self) -> Sizes {
        Sizes { points: self.points.len(), polygons: self.corners.polygons(), corners: self.corners.points().len() }
    }
    pub fn position(&self, point: usize) -> [f32; 3] {
        self.points.get(point).copied().unwrap_or_default()
    }
    /// Whether a polygon has a surface.
    pub fn is_drawn(&self, polygon: usize) -> bool {
        self.corners.span(polygon).len() >= 3
            && (self.holes.is_empty() || self.holes.binary_search(&(polygon as i32)).is_err())
    }
}

/// Reads and checks the topology; none with a note if there is no surface.
pub(super) fn read(reader: &mut Reader, view: &PrimView) -> Result<Option<Polygons>> {
    let counts = view.read("faceVertexCounts", "int[]", value::ints)?.unwrap_or_default();
    let indices = view.read("faceVertexIndices", "int[]", value::ints)?.unwrap_or_default();
    let (polygons, entries) = (counts.len(), counts.len() + indices.len());
    let few = counts.iter().filter(|&&count| count < 3).count();
    // The two arrays go before the points come: of a file that packs them well, they are the larger part of the memory.
    let corners = Corners::new(counts, indices);
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
    if points.is_empty() || polygons == 0 {
        reader.ledger.info(view.at(), "a mesh without points or polygons");
        return Ok(None);
    }
    reader.charge(view.path(), points.len() + entries, 16)?;
    if let Some(bad) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let [x, y, z] = points.get(bad).copied().unwrap_or_default();
        return Err(view
            .fault_in("points", format!("point {bad} is at ({x}, {y}, {z})"))
            .expected("finite points")
            .code(Code::DataNotFinite));
    }
    let corners = corners.map_err(|wrong| wrong.fault(view))?;
    if let Some(bad) = corners.outside(points.len()) {
        let fault = view.fault_in("faceVertexIndices", format!("index {bad} is no point"));
        return Err(fault.expected(format!("0 to {}", points.len() - 1)));
    }
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
    Ok(Some(Polygons { points, corners, holes, left_handed }))
}
