//! The corners of a primitive's triangles, and the vertices that they use.

use super::accessor::Document;
use super::at::At;
use super::notes::Ledger;
use super::primitive::{TRIANGLE, open};
use eyebox_base::error::Result;

/// How the corners make triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    List,
    Strip,
    Fan,
}

/// The vertex indices of each triangle (glTF 2.0, section 3.7.2.1), all below `vertices`. Triangles of strips and fans
/// that use a vertex twice only stitch and are left out.
pub(super) fn read(
    document: &Document<'_>,
    at: &At<'_>,
    shape: Shape,
    vertices: usize,
    ledger: &mut Ledger,
) -> Result<Vec<[u32; 3]>> {
    let indices = match at.get("indices")? {
        Some(reference) => Some(open(document, &reference, &[1], ledger)?),
        None => None,
    };
    if let Some(accessor) = indices.as_ref().filter(|accessor| !accessor.component.is_index()) {
        let fault = accessor.at.want("componentType")?.fault("indices of this component type");
        return Err(fault.expected("5121, 5123 or 5125 (unsigned)"));
    }
    if let Some(accessor) = indices.as_ref().filter(|accessor| !accessor.is_backed()) {
        ledger.notes.warn(&accessor.at, "indices without data in the asset: all of them are 0");
    }
    let count = indices.as_ref().map_or(vertices, |accessor| accessor.count);
    let place = indices.as_ref().map_or(at, |accessor| &accessor.at);
    let (triangles, left) = match shape {
        Shape::List => (count / 3, count % 3),
        Shape::Strip | Shape::Fan => (count.saturating_sub(2), if count < 3 { count } else { 0 }),
    };
    if left > 0 {
        ledger.notes.warn(place, format!("{count} corners do not make triangles: the last {left} are ignored"));
    }
    // The compaction below needs the corners once more and a table of up to four entries per corner.
    ledger.budget.charge(at, triangles, 5 * TRIANGLE)?;
    let vertex = |corner: usize| -> Result<u32> {
        let index = indices.as_ref().map_or(corner, |accessor| accessor.unsigned(corner) as usize);
        if index < vertices {
            return u32::try_from(index).map_err(|_| at.fault("more than 4294967295 vertices"));
        }
        let expected = format!("0 to {}", vertices - 1);
        Err(place.fault(format!("index {index} at position {corner} is not a vertex")).expected(expected))
    };
    let mut out = Vec::with_capacity(triangles);
    for i in 0..triangles {
        let [a, b, c] = match shape {
            Shape::List => [3 * i, 3 * i + 1, 3 * i + 2],
            Shape::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Shape::Fan => [i + 1, i + 2, 0],
        };
        let triangle = [vertex(a)?, vertex(b)?, vertex(c)?];
        let [a, b, c] = triangle;
        if shape == Shape::List || a != b && b != c && c != a {
            out.push(triangle);
        }
    }
    Ok(out)
}

/// The vertices that the corners use, in ascending order, and the corners counted in them.
pub(super) fn compact(mut corners: Vec<[u32; 3]>, vertices: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut used: Vec<u32>;
    // A table of all vertices is quicker; a small face in a large shared accessor is better sorted.
    if vertices / 4 <= corners.len() * 3 {
        let mut table = vec![u32::MAX; vertices];
        corners.iter().flatten().for_each(|&vertex| table[vertex as usize] = 0);
        used = (0..vertices as u32).filter(|&vertex| table[vertex as usize] == 0).collect();
        if used.len() == vertices {
            return (used, corners);
        }
        used.iter().enumerate().for_each(|(new, &vertex)| table[vertex as usize] = new as u32);
        corners.iter_mut().flatten().for_each(|vertex| *vertex = table[*vertex as usize]);
    } else {
        used = corners.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        corners.iter_mut().flatten().for_each(|vertex| *vertex = used.partition_point(|other| other < vertex) as u32);
    }
    (used, corners)
}
