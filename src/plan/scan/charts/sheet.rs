//! Panels in the grid of the eyebox, all of the same window of directions.

use super::super::Scan;
use super::super::tuning::charts::{GAP, LABEL, MARGIN, PANEL, WIDEST};
use super::{columns, escaped, seen};

/// Where panels lie, and how directions become places in them.
pub struct Sheet {
    columns: usize,
    rows: usize,
    /// Lower left corner of the window, degrees, and its sides.
    low: [f64; 2],
    sides: [f64; 2],
    /// Pixels per degree.
    pub scale: f64,
    body: String,
}

impl Sheet {
    /// Of all directions that are seen, with a margin. None where nothing is.
    pub fn new(scan: &Scan) -> Option<Sheet> {
        let all = || scan.positions.iter().flat_map(seen);
        let first = all().next()?;
        let (low, high) = all().fold((first, first), |(low, high), at| {
            ([0, 1].map(|axis| low[axis].min(at[axis])), [0, 1].map(|axis| high[axis].max(at[axis])))
        });
        let wide = [0, 1].map(|axis| high[axis] - low[axis]);
        // A picture of one point has a window all the same.
        let margin = MARGIN * Some(wide[0].max(wide[1])).filter(|side| *side > 0.0).unwrap_or(1.0);
        let sides = wide.map(|side| side + 2.0 * margin);
        let columns = columns(scan);
        let panel = PANEL.min(WIDEST / columns as f64);
        Some(Sheet {
            columns,
            rows: scan.positions.len().div_ceil(columns),
            low: low.map(|low| low - margin),
            sides,
            scale: panel / sides[0],
            body: String::new(),
        })
    }

    /// Width and height of the window, degrees.
    pub fn window(&self) -> [f64; 2] {
        self.sides
    }

    fn panel(&self) -> [f64; 2] {
        self.sides.map(|side| self.scale * side)
    }

    /// Begins the panel of a position; what was drawn there comes between it and `end`.
    pub fn begin(&mut self, index: usize, scan: &Scan) {
        let [width, height] = self.panel();
        let (column, row) = (index % self.columns, index / self.columns);
        let (x, y) = (column as f64 * (width + GAP), row as f64 * (height + LABEL + GAP));
        let Some(position) = scan.positions.get(index) else { return };
        self.body += &format!(
            "<g transform=\"translate({x:.2} {:.2})\"><text x=\"0\" y=\"-4\">{:.1}, {:.1} mm</text><rect class=\"axis\" width=\"{width:.2}\" \
             height=\"{height:.2}\"/>\n",
            y + LABEL,
            1e3 * position.x_m,
            1e3 * position.y_m
        );
    }

    pub fn end(&mut self) {
        self.body += "</g>\n";
    }

    /// Where a direction lies in its panel, pixels to the right and down.
    pub fn place(&self, deg: [f64; 2]) -> [f64; 2] {
        let [right, up] = [0, 1].map(|axis| self.scale * (deg[axis] - self.low[axis]));
        [right, self.panel()[1] - up]
    }

    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: &str, width: f64) {
        let ([a, b], [c, d]) = (self.place(from), self.place(to));
        self.body += &format!(
            "<line x1=\"{a:.3}\" y1=\"{b:.3}\" x2=\"{c:.3}\" y2=\"{d:.3}\" stroke=\"{colour}\" stroke-width=\"{width:.2}\"/>\n"
        );
    }

    /// A disc of a radius in pixels; `says` is shown where the pointer rests.
    pub fn disc(&mut self, at: [f64; 2], radius: f64, colour: &str, says: &str) {
        let [x, y] = self.place(at);
        self.body += &format!(
            "<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{radius:.2}\" fill=\"{colour}\"><title>{}</title></circle>\n",
            escaped(says)
        );
    }

    /// The whole picture. `says`: what it is, for those who cannot see it.
    pub fn svg(&self, says: &str) -> String {
        let [width, height] = self.panel();
        let (columns, rows) = (self.columns as f64, self.rows as f64);
        format!(
            "<svg class=\"chart\" viewBox=\"-1 0 {:.1} {:.1}\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n",
            columns * (width + GAP) + 2.0,
            rows * (height + LABEL + GAP) + 1.0,
            escaped(says),
            self.body
        )
    }
}
