//! The outline of a face as light that goes through it meets it: seen along the normal of the loop of its edges, on which side
//! of the nearest edge a point lies.

use super::rim::{Edge, Rim};
use glam::{DVec2, DVec3};

/// The edges of a face in a plane.
#[derive(Debug)]
pub struct Outline {
    plane: [DVec3; 2],
    /// In the plane, z = 0; the face is on the left.
    rim: Rim,
    size_m: f64,
}

impl Outline {
    /// None where a face has no edges, or they enclose nothing seen from any side.
    pub fn new(edges: &[Edge]) -> Option<Outline> {
        let first = edges.first()?.0[0];
        let area = edges.iter().map(|Edge([a, b])| (*a - first).cross(*b - first)).sum::<DVec3>();
        let normal = area.try_normalize()?;
        let plane = normal.any_orthonormal_pair();
        let outline = Outline { plane: [plane.0, plane.1], rim: Rim::new(Vec::new()), size_m: area.length().sqrt() };
        let flat = |at: DVec3| outline.flat(at).extend(0.0);
        let rim = Rim::new(edges.iter().map(|Edge(ends)| Edge(ends.map(flat))).collect());
        Some(Outline { rim, ..outline })
    }

    /// The side of a square of some such area, m.
    pub fn size_m(&self) -> f64 {
        self.size_m
    }

    /// A place or a direction in the plane.
    pub fn flat(&self, at: DVec3) -> DVec2 {
        DVec2::new(at.dot(self.plane[0]), at.dot(self.plane[1]))
    }

    /// The line of the edge nearest to a place of the plane, as a point of it and the unit direction to the inside; none where no
    /// edge is within `reach`, m.
    pub fn nearest(&self, place: DVec2, reach: f64) -> Option<(DVec2, DVec2)> {
        let mut nearest: Option<([f64; 2], DVec2, DVec2)> = None;
        let mut within = reach;
        self.rim.nearer(place.extend(0.0), reach, |Edge([a, b])| {
            let (a, b) = (a.truncate(), b.truncate());
            let Some(along) = (b - a).try_normalize() else { return within };
            let off = place - a;
            let end = off - along * off.dot(along).clamp(0.0, a.distance(b));
            let inwards = along.perp();
            // At a corner both edges are equally near: the one whose line is farther tells the side.
            let order = [end.length_squared(), -off.dot(inwards).abs()];
            if order[0] <= reach * reach && nearest.is_none_or(|(known, ..)| order < known) {
                nearest = Some((order, a, inwards));
                // Rounding must not part the two edges of a corner.
                within = reach.min(end.length() * (1.0 + 1e-9));
            }
            within
        });
        nearest.map(|(_, a, inwards)| (a, inwards))
    }

    /// How far inside of the nearest edge a point lies, m; negative outside. None where no edge is within `reach`.
    pub fn inside(&self, point: DVec3, reach: f64) -> Option<f64> {
        let place = self.flat(point);
        self.nearest(place, reach).map(|(a, inwards)| (place - a).dot(inwards))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(corners: &[[f64; 2]]) -> Outline {
        let at = |[x, y]: [f64; 2]| DVec3::new(x, 7.0, -y);
        let next = corners.iter().cycle().skip(1);
        let edges: Vec<Edge> = corners.iter().zip(next).map(|(a, b)| Edge([at(*a), at(*b)])).collect();
        Outline::new(&edges).expect("it encloses something")
    }

    /// A square with a notch, in a plane of the world: distances to its lines, and the sides of its corners.
    #[test]
    fn sides_and_distances_of_a_notched_square() {
        let notched = outline(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0], [2.0, 2.0], [1.0, 4.0], [0.0, 4.0]]);
        let inside = |x: f64, y: f64| notched.inside(DVec3::new(x, 1.0, -y), 9.0).expect("edges are near");
        for (place, want) in [([2.0, 0.5], 0.5), ([2.0, -0.5], -0.5), ([-1.0, -0.1], -1.0), ([3.9, 2.0], 0.1)] {
            assert!((inside(place[0], place[1]) - want).abs() < 1e-12, "{place:?}");
        }
        // Above and below the notch's tip, which points inwards.
        assert!(inside(2.0, 2.1) < 0.0 && inside(2.0, 1.9) > 0.0);
        assert!(inside(4.1, 4.2) < 0.0 && inside(-0.2, -0.1) < 0.0);
        assert_eq!(notched.inside(DVec3::new(2.0, 1.0, 9.0), 1.0), None);
    }

    /// All points of a many-cornered circle.
    #[test]
    fn a_circle_of_short_edges() {
        let corners: Vec<[f64; 2]> =
            (0..128).map(|k| f64::from(k) * std::f64::consts::TAU / 128.0).map(|t| [t.cos(), t.sin()]).collect();
        let circle = outline(&corners);
        for k in 0..1000 {
            let (t, r) = (0.37 * f64::from(k), 0.8 + 0.4 * f64::from(k) / 1000.0);
            let got = circle.inside(DVec3::new(r * t.cos(), 7.0, -r * t.sin()), 1.0).expect("edges are near");
            // A chord of 1/128 of a circle is up to 1 − cos π/128 inside of it; beside a corner its line is that share nearer.
            let inside = 1.0 - (std::f64::consts::PI / 128.0).cos();
            let most = 1.0 - r + inside * (r - 1.0).abs();
            assert!(got <= most + 1e-12 && got >= 1.0 - r - inside - 1e-12, "{r} {got}");
        }
    }

    #[test]
    fn nothing_encloses_nothing() {
        assert!(Outline::new(&[]).is_none());
        assert!(Outline::new(&[Edge([DVec3::ZERO, DVec3::X]), Edge([DVec3::X, DVec3::ZERO])]).is_none());
    }
}
