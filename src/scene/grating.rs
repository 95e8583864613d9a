//! Diffraction gratings: parallel planes that cut a face into lines, and the share of light that each order gets.

use glam::DVec3;

/// Lines on a face where planes across `direction` cut it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Grating {
    /// Mesh units, not zero: across the lines. Its part along the face counts.
    pub direction: DVec3,
    /// Planes per millimetre along `direction`; below 0: order m is that of −m.
    pub lines_per_mm: f64,
    pub orders: Vec<Order>,
    /// What the orders leave goes on in order 0 as at a bare interface; else it is absorbed.
    pub rest_in_zero_order: bool,
}

/// Shares (0–1) of the light that arrives, from both sides alike.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Order {
    pub order: i32,
    pub transmittance: f64,
    pub reflectance: f64,
}

impl Grating {
    /// What is wrong with the numbers, in plain words, if anything is.
    pub fn problem(&self) -> Option<String> {
        if self.direction.try_normalize().is_none() || !self.lines_per_mm.is_finite() {
            return Some(format!("a grating of {} lines/mm across {}", self.lines_per_mm, self.direction));
        }
        for (k, order) in self.orders.iter().enumerate() {
            if ![order.transmittance, order.reflectance].iter().all(|share| (0.0..=1.0).contains(share)) {
                return Some(format!(
                    "order {} has T {} and R {}",
                    order.order, order.transmittance, order.reflectance
                ));
            }
            if order.order == 0 && self.rest_in_zero_order {
                return Some("order 0 has the rest: it has no shares of its own".to_owned());
            }
            if self.orders[..k].iter().any(|other| other.order == order.order) {
                return Some(format!("order {} is said twice", order.order));
            }
        }
        None
    }

    /// The shares of all orders together.
    pub fn total(&self) -> f64 {
        self.orders.iter().map(|order| order.transmittance + order.reflectance).sum()
    }
}
