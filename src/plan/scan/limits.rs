//! Limits on what two eyes have to do: which positions of the eyebox show points of the picture beyond them. `docs/scan.md` has the
//! sources of those that have names.

use super::{Position, Scan};
use eyebox_estimate::virtual_image::image::disparity;
use glam::DVec3;

/// What is limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The eyes turn further towards each other than for the image where it is meant to be.
    Convergence,
    /// Less so, or apart.
    Divergence,
    /// One eye higher than the other.
    Dipvergence,
}

impl Kind {
    pub const ALL: [Kind; 3] = [Kind::Convergence, Kind::Divergence, Kind::Dipvergence];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Convergence => "convergence",
            Kind::Divergence => "divergence",
            Kind::Dipvergence => "dipvergence",
        }
    }
}

/// Limits, rad, in the order of [`Kind::ALL`], above 0; none where nothing is limited.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Limits {
    pub convergence_rad: Option<f64>,
    pub divergence_rad: Option<f64>,
    pub dipvergence_rad: Option<f64>,
    /// 1/distance at which the image is meant to be, 1/m: convergence and divergence count from a point there.
    pub image_per_m: f64,
}

/// Limits with a source.
pub const NAMED: [(&str, Limits); 2] = [
    // Median thresholds of observers of head-up displays behind a canopy, recommended as the largest disparities: 1.2 mrad negative,
    // 2.6 mrad positive (L. V. Genco, Optical interactions of aircraft windscreens and HUDs producing diplopia, 1983, DTIC ADP003159).
    ("genco-1983", Limits { convergence_rad: Some(2.6e-3), divergence_rad: Some(1.2e-3), ..NOTHING }),
    // What the design of a car's head-up display was held to (L. Gu et al., Applied Optics 59, 4893, 2020).
    (
        "gu-2020",
        Limits {
            convergence_rad: Some(3.5e-3),
            divergence_rad: Some(1.5e-3),
            dipvergence_rad: Some(2.0e-3),
            ..NOTHING
        },
    ),
];

const NOTHING: Limits = Limits { convergence_rad: None, divergence_rad: None, dipvergence_rad: None, image_per_m: 0.0 };

impl Limits {
    pub fn of(&self, kind: Kind) -> Option<f64> {
        match kind {
            Kind::Convergence => self.convergence_rad,
            Kind::Divergence => self.divergence_rad,
            Kind::Dipvergence => self.dipvergence_rad,
        }
    }

    /// Limits one more.
    pub fn set(&mut self, kind: Kind, rad: f64) {
        match kind {
            Kind::Convergence => self.convergence_rad = Some(rad),
            Kind::Divergence => self.divergence_rad = Some(rad),
            Kind::Dipvergence => self.dipvergence_rad = Some(rad),
        }
    }
}

/// The point of a position's picture that is farthest beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Beyond {
    pub kind: Kind,
    /// The position, m.
    pub x_m: f64,
    pub y_m: f64,
    /// Column and row of the point.
    pub cell: [usize; 2],
    pub value_rad: f64,
    pub limit_rad: f64,
}

/// All positions from which a limit is not kept, by the points that both eyes see. Of each kind the worst point.
pub fn beyond(scan: &Scan, limits: &Limits) -> Vec<Beyond> {
    let of = |position: &Position, kind: Kind| {
        let limit_rad = limits.of(kind)?;
        let values = position.points.iter().filter_map(|line| {
            let own = line.disparity?;
            let value = match kind {
                Kind::Convergence => own.convergence_rad - meant(line.direction_deg?, limits.image_per_m, scan.ipd_m),
                Kind::Divergence => meant(line.direction_deg?, limits.image_per_m, scan.ipd_m) - own.convergence_rad,
                Kind::Dipvergence => own.dipvergence_rad.abs(),
            };
            Some((line.cell, value))
        });
        let (cell, value_rad) = values.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let found = Beyond { kind, x_m: position.x_m, y_m: position.y_m, cell, value_rad, limit_rad };
        (value_rad > limit_rad).then_some(found)
    };
    scan.positions
        .iter()
        .flat_map(|position| Kind::ALL.into_iter().filter_map(move |kind| of(position, kind)))
        .collect()
}

/// Convergence for a point in this direction at the distance where the image is meant to be, rad.
fn meant([right, up]: [f64; 2], per_m: f64, ipd_m: f64) -> f64 {
    let dir = DVec3::new(right.to_radians().tan(), up.to_radians().tan(), 1.0).normalize();
    // From each eye to the point, over its distance: at infinity both look alike.
    let from = |side: f64| (dir - DVec3::X * (0.5 * side * ipd_m * per_m)).normalize();
    disparity(from(-1.0), from(1.0), [DVec3::X, DVec3::Y, DVec3::Z]).convergence_rad
}

/// Positions from which both eyes see some point: only these are held to anything.
pub fn held(scan: &Scan) -> usize {
    scan.positions.iter().filter(|position| position.disparity.is_some()).count()
}

/// For people.
pub fn lines(limits: &Limits, scan: &Scan, found: &[Beyond]) -> Vec<String> {
    let said: Vec<String> = Kind::ALL
        .into_iter()
        .filter_map(|kind| Some(format!("{} {:.3} mrad", kind.name(), 1e3 * limits.of(kind)?)))
        .collect();
    let place = match limits.image_per_m {
        0.0 => "at infinity".to_owned(),
        per_m => format!("{:.3} m away", 1.0 / per_m),
    };
    let (held, all) = (held(scan), scan.positions.len());
    let result = match held {
        0 => "not tested".to_owned(),
        _ if found.is_empty() => format!("kept from all {held} of {all} positions from which both eyes see some of it"),
        _ => "not kept".to_owned(),
    };
    let mut out = vec![format!("limits: {}, of an image meant to be {place}: {result}", said.join(", "))];
    if held == 0 {
        out.push("warning: no point of the picture is seen by both eyes: nothing was held to the limits".to_owned());
    }
    out.extend(found.iter().map(|at| {
        format!(
            "warning: from x {:.2} mm, y {:.2} mm the {} at column {}, row {} is {:.3} mrad; at most {:.3}",
            1e3 * at.x_m,
            1e3 * at.y_m,
            at.kind.name(),
            at.cell[0],
            at.cell[1],
            1e3 * at.value_rad,
            1e3 * at.limit_rad
        )
    }));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point straight ahead at s has 2·atan(ipd/2s); at infinity nothing.
    #[test]
    fn what_is_meant() {
        for (s, ipd) in [(2.2_f64, 0.063_f64), (0.5, 0.065), (10.0, 0.058)] {
            assert!((meant([0.0, 0.0], 1.0 / s, ipd) - 2.0 * (ipd / (2.0 * s)).atan()).abs() < 1e-15);
            // A point aside, by the angle between both lines of sight in the plane through the eyes.
            let [x, y, z] = [0.3_f64.sin(), 0.0, 0.3_f64.cos()].map(|part| s * part);
            let want = (x + 0.5 * ipd).atan2(y.hypot(z)) - (x - 0.5 * ipd).atan2(y.hypot(z));
            assert!((meant([0.3_f64.to_degrees(), 0.0], 1.0 / s, ipd) - want).abs() < 1e-14);
        }
        assert_eq!(meant([5.0, -3.0], 0.0, 0.063), 0.0);
    }
}
