//! Sensors as text.

use super::{Level, SensorMap};

/// With six digits.
fn number(value: f64) -> String {
    format!("{value:.*}", digits(value))
}

/// Decimals that show six digits.
fn digits(value: f64) -> usize {
    if value == 0.0 { 0 } else { (5 - value.abs().log10().floor() as i64).clamp(0, 12) as usize }
}

fn level(of: &Level, unit: &str) -> String {
    let error = of.stderr.map_or_else(|| "error unknown".to_owned(), |error| format!("± {}", short(error)));
    format!("{} {error} {unit}", number(of.value))
}

/// With two digits.
fn short(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.*}", digits(value).saturating_sub(4)) }
}

/// The lines of a table: a head for each sensor, then its sides, then their light groups.
pub fn lines(maps: &[SensorMap]) -> Vec<String> {
    maps.iter().flat_map(of_map).collect()
}

fn of_map(map: &SensorMap) -> Vec<String> {
    let ([width, height], [columns, rows]) = (map.size_m.map(|m| 1e3 * m), map.pixels);
    let error = map.error.map_or("unknown".to_owned(), |error| format!("{:.2} %", 100.0 * error));
    let mut lines = vec![format!(
        "{} face {}: {} x {} mm, {columns} x {rows} pixels, error of a pixel {error} ({} passes, {} paths)",
        map.part,
        map.face,
        number(width),
        number(height),
        map.passes,
        map.paths,
    )];
    for side in &map.sides {
        let name = side.side.name();
        let Some(peak) = side.peak else {
            lines.push(format!("  {name}: no light arrived"));
            continue;
        };
        let watts = side.mean_w_m2.map_or(String::new(), |of| format!(", {}", level(&of, "W/m²")));
        let [right, up] = peak.place_m.map(|m| 1e3 * m);
        let at = Level { value: peak.value, stderr: peak.stderr };
        lines.push(format!(
            "  {name}: mean {}{watts}; peak {} at {} mm right, {} mm up; {}",
            level(&side.mean_lx, "lx"),
            level(&at, "lx"),
            number(right),
            number(up),
            level(&side.flux_lm, "lm"),
        ));
        if side.groups.len() > 1 {
            for share in &side.groups {
                let watts = share.mean_w_m2.map_or(String::new(), |of| format!(", {}", level(&of, "W/m²")));
                lines.push(format!("    {}: mean {}{watts}", share.group, level(&share.mean_lx, "lx")));
            }
        }
    }
    lines
}
