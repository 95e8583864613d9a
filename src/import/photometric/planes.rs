//! Stored half planes → the whole turn, by the symmetry that a file declares.

/// Which half planes a type C file stores, deg.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    /// One plane holds for all.
    Axial,
    /// 0 … 90, mirrored at both planes.
    Quadrant,
    /// 0 … 180, mirrored at C0–C180.
    Half,
    /// 90 … 270, or 270 … 0 … 90, mirrored at C90–C270.
    Across,
    /// 0 … 360.
    Whole,
}

/// The planes (deg, values) over 0 … 360, both ends stored. `stored` rises from 0 (`Across`: from 90 or −90) over the
/// range of its symmetry; none if it has not that range.
pub fn expand(stored: Vec<(f64, Vec<f64>)>, symmetry: Symmetry) -> Option<Vec<(f64, Vec<f64>)>> {
    let (first, last) = (stored.first()?.0, stored.last()?.0);
    let spans = |from: f64, to: f64| first == from && last == to;
    let mirrored = |planes: Vec<(f64, Vec<f64>)>, about: f64| {
        let mut all = planes;
        let more: Vec<_> = all.iter().rev().skip(1).map(|(c, row)| (2.0 * about - c, row.clone())).collect();
        all.extend(more);
        all
    };
    match symmetry {
        Symmetry::Axial => {
            let row = stored.into_iter().next()?.1;
            Some(vec![(0.0, row.clone()), (360.0, row)])
        }
        Symmetry::Quadrant => spans(0.0, 90.0).then(|| mirrored(mirrored(stored, 90.0), 180.0)),
        Symmetry::Half => spans(0.0, 180.0).then(|| mirrored(stored, 180.0)),
        Symmetry::Across => {
            let turn = if spans(90.0, 270.0) {
                mirrored(stored, 270.0)
            } else if spans(-90.0, 90.0) {
                mirrored(stored, 90.0)
            } else {
                return None;
            };
            Some(from_zero(turn))
        }
        Symmetry::Whole => spans(0.0, 360.0).then_some(stored),
    }
}

/// A closed turn that starts anywhere, from 0 to 360. Its first and last plane are the same one.
fn from_zero(turn: Vec<(f64, Vec<f64>)>) -> Vec<(f64, Vec<f64>)> {
    let mut all: Vec<(f64, Vec<f64>)> = turn.into_iter().skip(1).map(|(c, row)| (c.rem_euclid(360.0), row)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    if all.first().is_some_and(|(c, _)| *c > 0.0)
        && let (Some((a, low)), Some((b, high))) = (all.first(), all.last())
    {
        // No plane at 0: what lies there between its neighbours.
        let t = (360.0 - b) / (360.0 - b + a);
        let row = low.iter().zip(high).map(|(low, high)| high * (1.0 - t) + low * t).collect();
        all.insert(0, (0.0, row));
    }
    if let Some((_, row)) = all.first().cloned() {
        all.push((360.0, row));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(angles: &[f64]) -> Vec<(f64, Vec<f64>)> {
        angles.iter().enumerate().map(|(k, c)| (*c, vec![k as f64])).collect()
    }
    fn shown(stored: &[f64], symmetry: Symmetry) -> Vec<(f64, f64)> {
        expand(planes(stored), symmetry).unwrap().into_iter().map(|(c, row)| (c, row[0])).collect()
    }

    #[test]
    fn every_symmetry_gives_a_closed_turn() {
        assert_eq!(shown(&[7.0], Symmetry::Axial), [(0.0, 0.0), (360.0, 0.0)]);
        assert_eq!(
            shown(&[0.0, 30.0, 90.0], Symmetry::Quadrant),
            [
                (0.0, 0.0),
                (30.0, 1.0),
                (90.0, 2.0),
                (150.0, 1.0),
                (180.0, 0.0),
                (210.0, 1.0),
                (270.0, 2.0),
                (330.0, 1.0),
                (360.0, 0.0)
            ]
        );
        assert_eq!(
            shown(&[0.0, 60.0, 180.0], Symmetry::Half),
            [(0.0, 0.0), (60.0, 1.0), (180.0, 2.0), (300.0, 1.0), (360.0, 0.0)]
        );
        let across = [(0.0, 1.0), (90.0, 0.0), (180.0, 1.0), (270.0, 2.0), (360.0, 1.0)];
        assert_eq!(shown(&[90.0, 180.0, 270.0], Symmetry::Across), across);
        let across = [(0.0, 1.0), (90.0, 2.0), (180.0, 1.0), (270.0, 0.0), (360.0, 1.0)];
        assert_eq!(shown(&[-90.0, 0.0, 90.0], Symmetry::Across), across);
        // No plane at 0 or 180: between 30 and −30.
        let turn = shown(&[-90.0, -30.0, 30.0, 90.0], Symmetry::Across);
        assert_eq!((turn[0], turn.last().copied()), ((0.0, 1.5), Some((360.0, 1.5))));
        assert_eq!(expand(planes(&[0.0, 80.0]), Symmetry::Quadrant), None);
    }
}
