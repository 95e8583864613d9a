//! Diffraction gratings: parallel planes that cut a face into lines, and the share of light that each order gets.

use super::efficiency_table::{Efficiency, EfficiencyTable, Incidence};
use eyebox_base::shared::Shared;
use glam::DVec3;

/// Lines on a face where planes across `direction` cut it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Grating {
    /// Mesh units, not zero: across the lines. Its part along the face counts.
    pub direction: DVec3,
    /// Planes per millimetre along `direction`; below 0: order m is that of −m.
    pub lines_per_mm: f64,
    pub orders: Orders,
    /// What the orders leave goes on in order 0 as at a bare interface; else it is absorbed.
    pub rest_in_zero_order: bool,
}

/// The orders of a grating that have a share of the light that arrives.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Orders {
    /// The same shares at every wavelength and angle.
    Even(Vec<Order>),
    Table(Shared<EfficiencyTable>),
}

/// Shares (0–1) of the light that arrives, from both sides alike.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Order {
    pub order: i32,
    pub transmittance: f64,
    pub reflectance: f64,
}

impl Orders {
    pub fn count(&self) -> usize {
        match self {
            Orders::Even(orders) => orders.len(),
            Orders::Table(table) => table.orders.len(),
        }
    }

    /// The number of each.
    pub fn numbers(&self) -> impl Iterator<Item = i32> {
        let (even, table): (&[Order], &[i32]) = match self {
            Orders::Even(orders) => (orders, &[]),
            Orders::Table(table) => (&[], &table.orders),
        };
        even.iter().map(|order| order.order).chain(table.iter().copied())
    }

    /// What the order at this place of [`Orders::numbers`] has of light that arrives so.
    pub fn efficiency(&self, place: usize, incidence: &Incidence) -> Efficiency {
        match self {
            Orders::Even(orders) => orders
                .get(place)
                .map_or(Efficiency::NONE, |order| Efficiency::even(order.transmittance, order.reflectance)),
            Orders::Table(table) => table.at(place, incidence),
        }
    }

    /// Whether s and p differ anywhere.
    pub fn part_polarisations(&self) -> bool {
        match self {
            Orders::Even(_) => false,
            Orders::Table(table) => table.parts_polarisations(),
        }
    }
}

impl From<Vec<Order>> for Orders {
    fn from(orders: Vec<Order>) -> Self {
        Orders::Even(orders)
    }
}

impl Grating {
    /// What is wrong with the numbers, in plain words, if anything is.
    pub fn problem(&self) -> Option<String> {
        if self.direction.try_normalize().is_none() || !self.lines_per_mm.is_finite() {
            return Some(format!("a grating of {} lines/mm across {}", self.lines_per_mm, self.direction));
        }
        match &self.orders {
            Orders::Even(orders) => {
                let possible = |share: &f64| (0.0..=1.0).contains(share);
                for Order { order, transmittance, reflectance } in orders {
                    if ![*transmittance, *reflectance].iter().all(possible) {
                        return Some(format!("order {order} has T {transmittance} and R {reflectance}"));
                    }
                }
            }
            Orders::Table(table) => {
                if let Some(text) = table.problem() {
                    return Some(text);
                }
            }
        }
        let numbers: Vec<i32> = self.orders.numbers().collect();
        for (k, order) in numbers.iter().enumerate() {
            if *order == 0 && self.rest_in_zero_order {
                return Some("order 0 has the rest: it has no shares of its own".to_owned());
            }
            if numbers[..k].contains(order) {
                return Some(format!("order {order} is said twice"));
            }
        }
        None
    }

    /// The shares of all orders together, or the most that they are anywhere of one polarisation, if that is more than there is.
    pub fn gains(&self) -> Option<f64> {
        let total = match &self.orders {
            Orders::Even(orders) => orders.iter().map(|order| order.transmittance + order.reflectance).sum(),
            Orders::Table(table) => table.most(),
        };
        (total > 1.0 + Self::ROUNDED).then_some(total)
    }

    /// What measured or typed shares may add up to beyond 1: a rounding of theirs.
    pub const ROUNDED: f64 = 1e-9;
}
