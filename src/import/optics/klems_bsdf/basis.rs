//! The patches of a hemisphere that a matrix is measured between: rings about the normal, each of equal patches.

use super::{children, find, said};
use eyebox_base::Where;
use eyebox_base::error::{Error, Result};
use roxmltree::Node;
use std::f64::consts::{PI, TAU};

/// Most patches of a basis.
const MOST: usize = 1024;
/// Most rings: as many as a scatter table has angles for.
const MOST_RINGS: usize = 32;

/// Rings about the normal: where each begins and ends, rad, and its patches.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Basis {
    pub(super) rings: Vec<([f64; 2], usize)>,
}

impl Basis {
    /// `bounds`: where rings begin, degrees, the last one at 90.
    pub(super) fn new(bounds: &[f64], counts: &[usize]) -> Basis {
        let edge = |k: usize| bounds.get(k).copied().unwrap_or(90.0).to_radians();
        Basis { rings: counts.iter().enumerate().map(|(k, count)| ([edge(k), edge(k + 1)], *count)).collect() }
    }

    pub(super) fn named(name: &str) -> Option<Basis> {
        let is = |known: &str| name.eq_ignore_ascii_case(known);
        if is("LBNL/Klems Full") {
            let bounds = [0.0, 5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0];
            Some(Basis::new(&bounds, &[1, 8, 16, 20, 24, 24, 24, 16, 12]))
        } else if is("LBNL/Klems Half") {
            Some(Basis::new(&[0.0, 6.5, 19.5, 32.5, 46.5, 61.5, 76.5], &[1, 8, 12, 16, 20, 12, 4]))
        } else if is("LBNL/Klems Quarter") {
            Some(Basis::new(&[0.0, 9.0, 27.0, 46.0, 66.0], &[1, 8, 12, 12, 8]))
        } else {
            None
        }
    }

    pub(super) fn patches(&self) -> usize {
        self.rings.iter().map(|(_, count)| count).sum()
    }

    /// The first patch of a ring.
    pub(super) fn first(&self, ring: usize) -> usize {
        self.rings.iter().take(ring).map(|(_, count)| count).sum()
    }

    /// The patch of a ring at an azimuth: the first one is about 0.
    pub(super) fn at(&self, ring: usize, azimuth: f64) -> usize {
        let count = self.rings.get(ring).map_or(1, |(_, count)| *count);
        let turn = (azimuth / TAU).rem_euclid(1.0) * count as f64 + 0.5;
        self.first(ring) + turn as usize % count
    }

    /// Projected solid angle of a patch of a ring.
    pub(super) fn solid_angle(&self, ring: usize) -> f64 {
        let Some(([low, high], count)) = self.rings.get(ring) else { return 0.0 };
        PI * (high.sin().powi(2) - low.sin().powi(2)) / *count as f64
    }
}

/// A basis that the file defines.
pub(super) fn own_basis(node: Node<'_, '_>, at: &dyn Fn(Node<'_, '_>) -> Where) -> Result<Basis> {
    let (mut rings, mut from, mut patches) = (Vec::new(), 0.0, 0);
    for block in children(node, "AngleBasisBlock") {
        let number = |path: &[&'static str]| find(block, path).and_then(|own| said(own).parse::<f64>().ok());
        let to = number(&["ThetaBounds", "UpperTheta"]).filter(|to| *to > from && *to <= 90.0);
        let low = number(&["ThetaBounds", "LowerTheta"]).filter(|low| rings.is_empty() || (low - from).abs() < 1e-6);
        let count = number(&["nPhis"]).filter(|n| *n >= 1.0 && n.fract() == 0.0 && *n <= MOST as f64);
        let (Some(to), Some(_), Some(count)) = (to, low, count) else {
            return Err(Error::new(at(block), "this is no ring of patches")
                .expected("LowerTheta where the ring before ends, a larger UpperTheta up to 90, nPhis of 1 or more"));
        };
        patches += count as usize;
        if patches > MOST {
            return Err(Error::new(at(block), "the basis has too many patches").expected(format!("at most {MOST}")));
        }
        rings.push(([f64::to_radians(from), to.to_radians()], count as usize));
        from = to;
        if rings.len() > MOST_RINGS {
            return Err(Error::new(at(block), "the basis has too many rings").expected(format!("at most {MOST_RINGS}")));
        }
    }
    if from < 90.0 - 1e-6 {
        return Err(Error::new(at(node), format!("the angle basis ends at {from}°")).expected("rings up to 90°"));
    }
    Ok(Basis { rings })
}
