//! `sensor`: a map of the light that arrives at a face.

use super::fields::Fields;
use crate::value::Value;
use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::Sensor;
use eyebox_scene::attribute::Noun;

/// Faults: attributes that are missing, of the wrong form or out of range, pixels that are no whole numbers.
pub fn sensor(value: &Value) -> Result<Sensor> {
    let fields = Fields::of(Noun::Sensor, "sensor", value, &["pixels", "u"])?;
    let pixels = fields.need_numbers::<2>("pixels")?;
    if pixels.iter().any(|n| n.fract() != 0.0) {
        let at = fields.value("pixels").map_or(fields.at(), |value| &value.at);
        let what = format!("`pixels` of sensor is {} x {}", pixels[0], pixels[1]);
        return Err(Error::new(at.clone(), what).expected("two whole numbers from 1 to 2048"));
    }
    Ok(Sensor { pixels: pixels.map(|n| n as u32), u: fields.direction("u")? })
}
