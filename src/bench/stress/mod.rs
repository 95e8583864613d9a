//! The numerical stress suite: scenes at the limits of numbers, each with an answer that is known, traced and judged.

mod contacts;
mod films;
mod glass;
mod lamps;
mod meshes;
mod places;
pub mod table;

use super::measure::{How, Measured, trace};
use eyebox_base::stats::sidak_z;
use eyebox_scene::Scene;

/// What a case strains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Scale,
    Offset,
    Index,
    Grazing,
    Critical,
    Gap,
    Sliver,
    Coincident,
    Emitter,
    Sun,
    Guide,
    Coating,
    Mode,
}

impl Kind {
    pub const ALL: [Kind; 13] = [
        Kind::Scale,
        Kind::Offset,
        Kind::Index,
        Kind::Grazing,
        Kind::Critical,
        Kind::Gap,
        Kind::Sliver,
        Kind::Coincident,
        Kind::Emitter,
        Kind::Sun,
        Kind::Guide,
        Kind::Coating,
        Kind::Mode,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Scale => "scale",
            Kind::Offset => "offset",
            Kind::Index => "index",
            Kind::Grazing => "grazing",
            Kind::Critical => "critical",
            Kind::Gap => "gap",
            Kind::Sliver => "sliver",
            Kind::Coincident => "coincident",
            Kind::Emitter => "emitter",
            Kind::Sun => "sun",
            Kind::Guide => "guide",
            Kind::Coating => "coating",
            Kind::Mode => "mode",
        }
    }

    /// Its cases.
    pub fn cases(self) -> Vec<Case> {
        match self {
            Kind::Scale => places::scales(),
            Kind::Offset => places::offsets(),
            Kind::Index => glass::indices(),
            Kind::Grazing => glass::grazing(),
            Kind::Critical => glass::critical(),
            Kind::Gap => contacts::gaps(),
            Kind::Sliver => meshes::slivers(),
            Kind::Coincident => contacts::coincident(),
            Kind::Emitter => lamps::emitters(),
            Kind::Sun => lamps::suns(),
            Kind::Guide => glass::guides(),
            Kind::Coating => films::coatings(),
            Kind::Mode => films::modes(),
        }
    }
}

/// A scene and the mean luminance that its picture must have.
#[derive(Debug, Clone)]
pub struct Case {
    pub name: String,
    pub scene: Scene,
    pub how: How,
    /// cd/m².
    pub want: f64,
    /// Share of `want` (of 1 cd/m² if that is 0) by which roundings may move the answer.
    pub rounding: f64,
    /// Share of `want` that the standard error may be; more could hide a fault.
    pub noise: f64,
}

impl Case {
    /// A case without chance, or with little of it.
    pub fn new(name: String, scene: Scene, how: How, want: f64) -> Case {
        Case { name, scene, how, want, rounding: 1e-9, noise: 2e-3 }
    }
}

/// A case traced and judged.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Row {
    pub kind: Kind,
    pub case: String,
    /// cd/m².
    pub want: f64,
    pub mean: f64,
    pub sigma: f64,
    /// (mean − want) over what chance and rounding explain.
    pub bias: f64,
    /// Share of the light that no fate accounts for.
    pub loss: f64,
    /// Share that ended for reasons of numbers.
    pub cut: f64,
    pub nan: u64,
    /// What is out of limits.
    pub findings: Vec<String>,
}

/// All cases.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Report {
    pub rows: Vec<Row>,
    /// Limit of the bias in standard errors, so that one run in ten thousand has a false finding.
    pub most_sigma: f64,
}

impl Report {
    pub fn findings(&self) -> usize {
        self.rows.iter().map(|row| row.findings.len()).sum()
    }
}

/// Traces and judges all cases of some kinds; `each` sees every row as it comes.
pub fn run(kinds: &[Kind], each: &mut dyn FnMut(&Row)) -> Report {
    let cases: Vec<(Kind, Case)> =
        kinds.iter().flat_map(|kind| kind.cases().into_iter().map(move |case| (*kind, case))).collect();
    let most_sigma = sidak_z(1e-4, cases.len().max(1));
    let mut rows = Vec::with_capacity(cases.len());
    for (kind, case) in &cases {
        let row = judge(*kind, case, most_sigma);
        each(&row);
        rows.push(row);
    }
    Report { rows, most_sigma }
}

/// Traces one case; `most_sigma` is the limit of its bias.
pub fn judge(kind: Kind, case: &Case, most_sigma: f64) -> Row {
    match trace(&case.scene, case.how) {
        Ok(measured) => of_measured(kind, case, &measured, most_sigma),
        Err(fault) => Row {
            kind,
            case: case.name.clone(),
            want: case.want,
            mean: f64::NAN,
            sigma: f64::NAN,
            bias: f64::NAN,
            loss: f64::NAN,
            cut: f64::NAN,
            nan: 0,
            findings: vec![fault.to_string()],
        },
    }
}

/// Judges what was measured.
pub fn of_measured(kind: Kind, case: &Case, m: &Measured, most_sigma: f64) -> Row {
    let scale = if case.want == 0.0 { 1.0 } else { case.want.abs() };
    let bias = (m.mean - case.want) / m.sigma.hypot(case.rounding * scale);
    let mut findings = Vec::new();
    let mut find = |found: bool, what: String| {
        if found {
            findings.push(what);
        }
    };
    find(m.nan > 0, format!("{} values are no numbers", m.nan));
    // What is no number is not within a limit.
    let above = |x: f64, most: f64| x.is_nan() || x > most;
    find(above(bias.abs(), most_sigma), format!("a bias of {bias:.1} σ: {} for {}", m.mean, case.want));
    find(above(m.sigma, case.noise * scale), format!("a noise of {:.1e}, which could hide a fault", m.sigma / scale));
    find(
        above(m.loss.abs(), 1e-11 + most_sigma * m.loss_sigma) || above(m.loss_sigma, 1e-4),
        format!("{:.1e} of the light is lost", m.loss),
    );
    find(above(m.cut, 1e-6), format!("{:.1e} of the light is cut off", m.cut));
    find(above(m.vertex_error, 1e-12), format!("R + T + A misses 1 by {:.1e}", m.vertex_error));
    find(above(m.mismatches, 1e-4), format!("{:.1e} hits a path contradict the solids", m.mismatches));
    Row {
        kind,
        case: case.name.clone(),
        want: case.want,
        mean: m.mean,
        sigma: m.sigma,
        bias,
        loss: m.loss,
        cut: m.cut,
        nan: m.nan,
        findings,
    }
}
