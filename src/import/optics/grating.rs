//! `finish = { kind = "grating" }`: lines, and the shares of their orders.

use super::fields::Fields;
use super::wave_plate::word;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::{self, Noun};
use eyebox_scene::{Grating, Note, Order, Orders};
use glam::DVec3;

/// Orders of one grating: each is a way on that every ray weighs.
pub const MOST_ORDERS: usize = 64;

/// A grating, its table still to be read if there is one.
#[derive(Debug, Clone, PartialEq)]
pub struct GratingSpec {
    direction: DVec3,
    lines_per_mm: f64,
    rest_in_zero_order: bool,
    pub orders: OrdersSpec,
}

/// The shares of its orders.
#[derive(Debug, Clone, PartialEq)]
pub enum OrdersSpec {
    Given {
        orders: Vec<Order>,
        at: Where,
    },
    /// The file as it is written, and where.
    File {
        file: String,
        at: Where,
    },
}

impl OrdersSpec {
    fn at(&self) -> &Where {
        match self {
            OrdersSpec::Given { at, .. } | OrdersSpec::File { at, .. } => at,
        }
    }
}

impl GratingSpec {
    /// With its orders. Faults: orders twice, shares together above 1, order 0 beside `rest = "zero_order"`.
    pub fn with(&self, orders: Orders) -> Result<Grating> {
        let GratingSpec { direction, lines_per_mm, rest_in_zero_order, .. } = *self;
        let grating = Grating { direction, lines_per_mm, orders, rest_in_zero_order };
        let at = || self.orders.at().clone();
        if let Some(text) = grating.problem() {
            return Err(Error::new(at(), text).expected("each order once, order 0 only where the rest is absorbed"));
        }
        if let Some(total) = grating.gains() {
            return Err(Error::new(at(), format!("the orders of a grating have {total} of the light"))
                .expected("shares that together are at most 1")
                .code(Code::ScatterGainsEnergy));
        }
        Ok(grating)
    }
}

/// The grating of a finish. Faults: no shares, or two ways of saying them.
pub fn grating(fields: &Fields<'_>, notes: &mut Vec<Note>) -> Result<GratingSpec> {
    let direction = fields.need_direction("direction")?;
    let lines_per_mm = fields.need_number("lines_per_mm")?;
    let rest_in_zero_order = word(fields, "rest", ["absorbed", "zero_order"], Some(false))?;
    if !fields.has("rest") {
        notes.push(fields.defaulted("rest"));
    }
    let orders = match (fields.value("orders"), fields.value("efficiencies")) {
        (Some(value), None) => OrdersSpec::Given { orders: list(value)?, at: value.at.clone() },
        (None, Some(value)) => {
            OrdersSpec::File { file: fields.need_text("efficiencies")?.to_owned(), at: value.at.clone() }
        }
        (None, None) => {
            return Err(Error::new(fields.at().clone(), format!("{} has no `orders`", fields.what()))
                .expected("`orders = [{ order, T, R }, …]`, or a file of them in `efficiencies`"));
        }
        (Some(_), Some(value)) => {
            return Err(Error::new(value.at.clone(), format!("{} has `orders` and `efficiencies`", fields.what()))
                .expected("one of them"));
        }
    };
    Ok(GratingSpec { direction, lines_per_mm, rest_in_zero_order, orders })
}

fn list(value: &Value) -> Result<Vec<Order>> {
    let list = value.list().filter(|list| !list.is_empty()).ok_or_else(|| {
        Error::new(value.at.clone(), format!("`orders` is {} ({value})", value.kind()))
            .expected("a list of { order, T, R }")
    })?;
    if list.len() > MOST_ORDERS {
        return Err(Error::new(value.at.clone(), format!("a grating with {} orders", list.len()))
            .expected(format!("at most {MOST_ORDERS}: those that carry light")));
    }
    list.iter().map(order).collect()
}

fn order(value: &Value) -> Result<Order> {
    let own = Fields::of(Noun::Finish, "order", value, &attribute::ORDER)?;
    let number = own.need_number("order")?;
    let order = number as i32;
    if f64::from(order) != number {
        return Err(Error::new(value.at.clone(), format!("`order` is {number}")).expected("a whole number"));
    }
    Ok(Order { order, transmittance: own.number("T")?.unwrap_or(0.0), reflectance: own.number("R")?.unwrap_or(0.0) })
}
