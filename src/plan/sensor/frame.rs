//! A sensor's map as a picture of data layers.

use super::SensorMap;
use eyebox_film::exr::COLOR_INTEROP_ID;
use eyebox_film::frame::{Frame, Meta};

/// The map as a frame: `illuminance_SIDE.Y` (lx), `illuminance_SIDE_stderr.Y`, `irradiance_SIDE.Y` (W/m², where spectra are
/// told) of both sides, `coverage.Y`, and as the default image the front's illuminance. Metadata say where the map lies.
pub fn frame(map: &SensorMap, seed: u64) -> Frame {
    let mut frame = Frame::new(map.pixels[0], map.pixels[1]);
    let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect::<Vec<f32>>();
    if let Some(front) = map.sides.first() {
        ["R", "G", "B"].iter().for_each(|channel| frame.push(*channel, single(&front.illuminance_lx)));
    }
    for side in &map.sides {
        let name = side.side.name();
        frame.push(format!("illuminance_{name}.Y"), single(&side.illuminance_lx));
        frame.push(format!("illuminance_{name}_stderr.Y"), single(&side.stderr_lx));
        if let Some(watts) = &side.irradiance_w_m2 {
            frame.push(format!("irradiance_{name}.Y"), single(watts));
        }
    }
    frame.push("coverage.Y", single(&map.coverage));
    let mut say = |key: &str, value: Meta| drop(frame.meta.insert(key.to_owned(), value));
    say(COLOR_INTEROP_ID, Meta::Text("data".to_owned()));
    say("version", Meta::Text(env!("CARGO_PKG_VERSION").to_owned()));
    say("seed", Meta::Integer(i64::try_from(seed).unwrap_or(i64::MAX)));
    say("passes", Meta::Integer(i64::try_from(map.passes).unwrap_or(i64::MAX)));
    // What is told of the sensor, as `--format json` tells it.
    say("sensor", Meta::Text(serde_json::json!(map).to_string()));
    frame
}
