//! A scan as pictures for a page: from each eye position the distortion grid, the map of 1/distance and the ghosts, as inline SVG.

mod distortion;
mod ghosts;
mod sheet;
mod vergence;

use super::tuning::charts::MOST_DRAWN;
use super::{Position, Scan};
use eyebox_base::error::{Error, Result, Where};

/// Colours that people with any colour vision tell apart (Okabe and Ito, "Color universal design", 2008).
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#888888"];

/// The section of a page: headings and pictures, with the names of parts escaped.
///
/// # Errors
/// A scan with more points than a page can show, numbers that are not finite, positions that are no grid.
pub fn section(scan: &Scan) -> Result<String> {
    checked(scan)?;
    let [width, height] = scan.eyebox_m.map(|m| 1e3 * m);
    let window = sheet::Sheet::new(scan).map_or("nothing is seen".to_owned(), |sheet| {
        let [wide, high] = sheet.window();
        format!("all panels show the same window, {wide:.2}° × {high:.2}°")
    });
    let mut out = format!(
        "<section aria-labelledby=\"scan-head\">\n<h2 id=\"scan-head\">Virtual image over the eyebox</h2>\n<p class=\"note\">{} seen \
         by {}, from {} positions over {width:.1} × {height:.1} mm, drawn as they lie: the upper left one as the eye looks from \
         there; {window}.</p>\n",
        escaped(&scan.part),
        escaped(if scan.by.is_empty() { "the bare eye" } else { &scan.by }),
        scan.positions.len(),
    );
    for chart in [distortion::chart(scan), vergence::chart(scan), ghosts::chart(scan)].into_iter().flatten() {
        out += &format!("<h3>{}</h3>\n<p class=\"note\">{}</p>\n{}", chart.title, chart.note, chart.svg);
    }
    Ok(out + "</section>\n")
}

/// One kind of picture.
struct Chart {
    title: &'static str,
    /// What it shows, escaped.
    note: String,
    svg: String,
}

fn checked(scan: &Scan) -> Result<()> {
    let fault = |what: String| Error::new(Where::Nowhere, what);
    let count: usize = scan.positions.iter().map(|position| position.points.len()).sum();
    if count > MOST_DRAWN {
        return Err(fault(format!("the scan has {count} points over all positions"))
            .expected(format!("at most {MOST_DRAWN}: fewer positions, or fewer --points")));
    }
    if scan.positions.is_empty() {
        return Err(fault("the scan has no positions".to_owned()));
    }
    let near = |deg: [f64; 2]| deg.iter().all(|angle| angle.abs() < 90.0);
    let odd =
        scan.positions.iter().flat_map(|position| &position.points).find(|line| !line.direction_deg.is_none_or(near));
    if let Some(line) = odd {
        let [column, row] = line.cell;
        return Err(fault(format!("the point at column {column}, row {row} is not ahead")).expected("angles below 90°"));
    }
    Ok(())
}

/// Columns of the eyebox's grid: as many as there are positions of one height in its first row.
fn columns(scan: &Scan) -> usize {
    let first = scan.positions.first().map_or(0.0, |position| position.y_m);
    scan.positions.iter().take_while(|position| position.y_m == first).count().max(1)
}

/// Directions that are seen from a position.
fn seen(position: &Position) -> impl Iterator<Item = [f64; 2]> {
    position.points.iter().filter(|line| line.seen).filter_map(|line| line.direction_deg)
}

/// The least distance between neighbouring points that are seen, degrees; infinite where there are none.
fn step(scan: &Scan) -> f64 {
    let of = |position: &Position| {
        let pairs = position.points.windows(2).filter(|pair| pair.iter().all(|line| line.seen));
        let far = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).hypot(b - d);
        let steps = pairs.filter_map(|pair| Some(far(pair[0].direction_deg?, pair[1].direction_deg?)));
        steps.fold(f64::INFINITY, f64::min)
    };
    let across = scan.positions.iter().map(of).fold(f64::INFINITY, f64::min);
    let turned = |position: &Position| {
        let mut points = position.points.clone();
        points.sort_by_key(|line| line.cell);
        Position { points, ..Position::nowhere() }
    };
    scan.positions.iter().map(|position| of(&turned(position))).fold(across, f64::min)
}

/// The largest of 1, 2, 5 times a power of ten that is not above a number above 0, and never below 1.
fn round_down(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let step = [5.0, 2.0, 1.0].into_iter().find(|step| step * power <= value).unwrap_or(1.0);
    Some(step * power).filter(|round| round.is_finite()).map_or(1.0, |round| round.max(1.0))
}

/// A text between tags or in a quoted attribute.
fn escaped(text: &str) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // Braces are the page's own: none of a file's may look like a place to fill in.
    let marks = [('&', "&amp;"), ('<', "&lt;"), ('>', "&gt;"), ('"', "&quot;"), ('\'', "&#39;"), ('{', "&#123;")];
    marks.into_iter().fold(clean, |text, (mark, name)| text.replace(mark, name))
}

#[cfg(test)]
mod tests;
