//! The curves as a picture: relMSE over CPU seconds, both logarithmic, one panel per asset.

use super::{AssetReport, Curve, Report};

/// Of a panel with its margins, in pixels.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 420.0;
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [64.0, 40.0, 24.0, 48.0];
/// Line colours that people with any colour vision tell apart (Okabe and Ito, "Color universal design", 2008).
const COLOURS: [&str; 7] = ["#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// Decades from 10^low to 10^high.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Axis {
    low: i32,
    high: i32,
}

impl Axis {
    /// Whole decades around positive numbers; 1 to 10 if there are none.
    fn around(numbers: impl Iterator<Item = f64>) -> Axis {
        let (low, high) = numbers
            .filter(|x| *x > 0.0 && x.is_finite())
            .map(f64::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if low > high {
            return Axis { low: 0, high: 1 };
        }
        let low = low.floor() as i32;
        Axis { low, high: (high.ceil() as i32).max(low + 1) }
    }

    /// 0 at the low end, 1 at the high end.
    fn share(self, x: f64) -> f64 {
        (x.log10() - f64::from(self.low)) / f64::from(self.high - self.low)
    }
}

fn escape(text: &str) -> String {
    // A control character has no place in XML, escaped or not.
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    clean.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The picture as an SVG document.
pub fn svg(report: &Report) -> String {
    let height = HEIGHT * report.assets.len().max(1) as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    for (index, asset) in report.assets.iter().enumerate() {
        out += &format!("<g transform=\"translate(0 {})\">\n{}</g>\n", HEIGHT * index as f64, panel(asset));
    }
    out + "</svg>\n"
}

/// (CPU seconds with setup, relMSE) of the points that can be drawn; an error below what the references tell is drawn
/// there.
fn points(curve: &Curve, resolution: f64) -> impl Iterator<Item = [f64; 2]> {
    curve
        .points
        .iter()
        .map(move |point| [curve.setup_seconds + point.seconds, point.error.relmse.max(resolution)])
        .filter(|[seconds, error]| *seconds > 0.0 && *error > 0.0 && error.is_finite())
}

fn panel(asset: &AssetReport) -> String {
    let [left, top, right, bottom] = MARGIN;
    let (inner_width, inner_height) = (WIDTH - left - right, HEIGHT - top - bottom);
    let resolution = asset.reference.resolution;
    let all = || asset.curves.iter().flat_map(|curve| points(curve, resolution));
    let x_axis = Axis::around(all().map(|p| p[0]));
    let y_axis = Axis::around(all().map(|p| p[1]).chain(std::iter::once(resolution)));
    let x = |seconds: f64| left + inner_width * x_axis.share(seconds);
    let y = |error: f64| top + inner_height * (1.0 - y_axis.share(error));
    let (base, end) = (top + inner_height, left + inner_width);
    let mut out = format!(
        "<text x=\"{left}\" y=\"24\" font-size=\"14\">{}, {} × {} pixels</text>\n",
        escape(&asset.asset),
        asset.resolution[0],
        asset.resolution[1]
    );
    for decade in x_axis.low..=x_axis.high {
        let at = x(10f64.powi(decade));
        out += &format!("<path d=\"M{at:.1} {top}V{base}\" stroke=\"#dddddd\"/>\n");
        out +=
            &format!("<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n", base + 18.0, tick(decade));
    }
    for decade in y_axis.low..=y_axis.high {
        let at = y(10f64.powi(decade));
        out += &format!("<path d=\"M{left} {at:.1}H{end}\" stroke=\"#dddddd\"/>\n");
        out += &format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
            left - 6.0,
            at + 4.0,
            tick(decade)
        );
    }
    out += &format!(
        "<rect x=\"{left}\" y=\"{top}\" width=\"{inner_width}\" height=\"{inner_height}\" fill=\"none\" stroke=\"#444444\"/>\n\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">CPU seconds, import and plan included</text>\n\
         <text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">relMSE</text>\n",
        left + 0.5 * inner_width,
        base + 38.0,
        top + 0.5 * inner_height,
    );
    if resolution > 0.0 && resolution.is_finite() {
        let at = y(resolution);
        out += &format!("<path d=\"M{left} {at:.1}H{end}\" stroke=\"#888888\" stroke-dasharray=\"2 4\"/>\n");
        out += &format!("<text x=\"{:.1}\" y=\"{:.1}\" fill=\"#666666\">references</text>\n", left + 6.0, at - 4.0);
    }
    // The first, the automatic choice, lies on top of the one that it chose.
    for (index, curve) in asset.curves.iter().enumerate().rev() {
        let colour = COLOURS[index % COLOURS.len()];
        let places: Vec<[f64; 2]> = points(curve, resolution).map(|[s, e]| [x(s), y(e)]).collect();
        let line: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        if !line.is_empty() {
            out += &format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n",
                line.join(" ")
            );
        }
        for [x, y] in &places {
            out += &format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>\n");
        }
        let slope = match (curve.points.is_empty(), curve.slope) {
            (true, _) => "has no work".to_owned(),
            (false, Some(slope)) => format!("slope {slope:.2}"),
            (false, None) => "no slope".to_owned(),
        };
        let (at, right) = (top + 18.0 + 18.0 * index as f64, end - 12.0);
        out += &format!(
            "<path d=\"M{:.1} {:.1}H{right:.1}\" stroke=\"{colour}\" stroke-width=\"2\"/>\n\
             <text x=\"{:.1}\" y=\"{at:.1}\" text-anchor=\"end\">{}, {slope}</text>\n",
            right - 20.0,
            at - 4.0,
            right - 26.0,
            curve.estimator,
        );
    }
    out
}

/// 0.01, 1, 100, and powers of ten beyond.
fn tick(decade: i32) -> String {
    match decade {
        -2..=4 => format!("{}", 10f64.powi(decade)),
        _ => format!("1e{decade}"),
    }
}
