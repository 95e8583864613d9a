//! `finish = { kind = "grating" }`: lines, and the shares of their orders.

use super::fields::Fields;
use super::wave_plate::word;
use crate::base::error::Result;
use crate::base::{Code, Error};
use crate::import::value::Value;
use crate::scene::attribute::{self, Noun};
use crate::scene::{Grating, Note, Order};

/// Orders of one grating: each is a way on that every ray weighs.
const MOST_ORDERS: usize = 64;

/// The grating of a finish. Faults: orders twice, shares together above 1, order 0 beside `rest = "zero_order"`.
pub fn grating(fields: &Fields<'_>, notes: &mut Vec<Note>) -> Result<Grating> {
    let direction = fields.need_direction("direction")?;
    let lines_per_mm = fields.need_number("lines_per_mm")?;
    let rest_in_zero_order = word(fields, "rest", ["absorbed", "zero_order"], Some(false))?;
    if !fields.has("rest") {
        notes.push(fields.defaulted("rest"));
    }
    let Some(value) = fields.value("orders") else { return Err(fields.missing("orders")) };
    let list = value.list().filter(|list| !list.is_empty()).ok_or_else(|| {
        Error::new(value.at.clone(), format!("`orders` is {} ({value})", value.kind()))
            .expected("a list of { order, T, R }")
    })?;
    if list.len() > MOST_ORDERS {
        return Err(Error::new(value.at.clone(), format!("a grating with {} orders", list.len()))
            .expected(format!("at most {MOST_ORDERS}: those that carry light")));
    }
    let orders = list.iter().map(order).collect::<Result<_>>()?;
    let grating = Grating { direction, lines_per_mm, orders, rest_in_zero_order };
    if let Some(text) = grating.problem() {
        return Err(
            Error::new(value.at.clone(), text).expected("each order once, order 0 only where the rest is absorbed")
        );
    }
    if grating.total() > 1.0 + 1e-12 {
        return Err(Error::new(
            value.at.clone(),
            format!("the orders of a grating have {} of the light", grating.total()),
        )
        .expected("shares that together are at most 1")
        .code(Code::ScatterGainsEnergy));
    }
    Ok(grating)
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
