//! Which polygons make a face, and the triangles they are cut into.

use super::super::faces::Partition;
use super::super::polygons::{Corners, Polygons};
use super::super::triangulate::{self, Met};
use glam::DVec3;

/// The polygons of a face, in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Own {
    /// All of the mesh; those without a surface are to be left out.
    All,
    Some(Vec<u32>),
}

impl Own {
    /// Without holes and without polygons that have no surface.
    pub fn drawn<'a>(&'a self, polygons: &'a Polygons) -> impl Iterator<Item = usize> + 'a {
        let (all, some) = match self {
            Own::All => (0..polygons.corners.polygons(), &[][..]),
            Own::Some(own) => (0..0, own.as_slice()),
        };
        all.filter(|&polygon| polygons.is_drawn(polygon)).chain(some.iter().map(|&polygon| polygon as usize))
    }
    /// How many triangles they make: two fewer than corners each.
    pub fn triangles(&self, polygons: &Polygons) -> usize {
        if *self == Own::All && is_plain(polygons) {
            return polygons.corners.polygons();
        }
        self.drawn(polygons).map(|polygon| polygons.corners.span(polygon).len().saturating_sub(2)).sum()
    }
}

/// Whether the triangles of the file are the triangles of the mesh.
pub(super) fn is_plain(polygons: &Polygons) -> bool {
    matches!(polygons.corners, Corners::Triangles(_)) && polygons.holes.is_empty()
}

/// The polygons of each face of the partition.
pub(super) fn grouped(partition: &Partition, polygons: &Polygons) -> Vec<Own> {
    if partition.faces.len() == 1 && partition.of.is_empty() {
        return vec![Own::All];
    }
    let mut out = vec![Vec::new(); partition.faces.len()];
    for polygon in (0..polygons.corners.polygons()).filter(|&polygon| polygons.is_drawn(polygon)) {
        let face = partition.of.get(polygon).map_or(0, |&face| face as usize);
        if let Some(own) = out.get_mut(face) {
            own.push(polygon as u32);
        }
    }
    out.into_iter().map(Own::Some).collect()
}

/// Gives polygon and corners of each triangle, and how many polygons cross themselves.
pub(super) fn triangles(polygons: &Polygons, own: &Own, mut each: impl FnMut(usize, [usize; 3])) -> usize {
    let (mut outline, mut cut, mut ragged) = (Vec::new(), Vec::new(), 0usize);
    let mut turned = |polygon: usize, start: usize, [a, b, c]: [u32; 3]| {
        let three = if polygons.left_handed { [a, c, b] } else { [a, b, c] };
        each(polygon, three.map(|corner| start + corner as usize));
    };
    for polygon in own.drawn(polygons) {
        let span = polygons.corners.span(polygon);
        let start = span.start;
        if span.len() == 3 {
            turned(polygon, start, [0, 1, 2]);
            continue;
        }
        outline.clear();
        let points = polygons.corners.points().get(span).unwrap_or_default();
        outline.extend(points.iter().map(|&point| DVec3::from(polygons.position(point as usize).map(f64::from))));
        cut.clear();
        ragged += usize::from(triangulate::polygon(&outline, &mut cut) == Met::Ragged);
        cut.iter().for_each(|&three| turned(polygon, start, three));
    }
    ragged
}
