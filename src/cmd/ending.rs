//! How a run ended: what has to be said of its light before anybody trusts it, and whether that is a finding.

use crate::base::ids::GroupId;
use crate::estimate::run::Films;
use crate::film::witness::Judgement;

/// What was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ending {
    /// What the witness says.
    pub lines: Vec<String>,
    pub warnings: Vec<String>,
    /// Exit code 1.
    pub finding: bool,
}

/// What is said where nobody looks beside a run.
pub const NO_WITNESS: &str = "witness: none, for rays from the eye trace all of the light and nobody else looks for it";

impl Ending {
    /// The error that was asked for was not reached: what holds it up. `given_up`: it would have taken too much work.
    pub fn fell_short(&mut self, films: &Films, [stated, wanted]: [f64; 2], given_up: bool) {
        let why = films.hold_up().map_or_else(String::new, |hold_up| {
            let size = films.films.first().map_or([1; 2], |(_, film, _)| [film.width, film.height]);
            format!(": {}", hold_up.text(size))
        });
        let on = if given_up { "; --time lets it go on" } else { "" };
        self.warnings.push(format!("the error is {:.2} %, not {:.2} %{why}{on}", 100.0 * stated, 100.0 * wanted));
    }
}

/// `name`: of a light group. `error`: what the run states. `one_pass`: it was asked for no more than one pass, of which no error
/// can be told. `lit`: lamps are on.
pub fn ending(
    films: &Films,
    judgement: Option<&Judgement>,
    name: &dyn Fn(GroupId) -> String,
    error: Option<f64>,
    (one_pass, lit): (bool, bool),
) -> Ending {
    let mut out = Ending::default();
    if let Some(judgement) = judgement {
        out.lines = judgement.lines(name);
        out.warnings = judgement.warnings(name);
        out.finding = judgement.is_off();
    }
    let traced = films.films.iter().map(|(_, film, _)| film.traced_share()).fold(1.0, f64::min);
    if traced < 1.0 {
        let percent = 100.0 * traced;
        out.warnings
            .push(format!("{percent:.0} % of the pixels were traced in time; the others show the nearest of these"));
    }
    if is_black(films) && lit {
        out.warnings
            .push("the picture is black, though lamps are on: no path of any estimator brought light".to_owned());
        out.finding = true;
    } else if lit && error.is_none() && !one_pass {
        out.warnings.push(format!("no error is stated: {}", why_unknown(films)));
        out.finding = true;
    }
    out
}

/// The error that a run states, for people.
pub fn stated(error: Option<f64>, passes: u64) -> String {
    match error {
        Some(error) => format!("error {:.2} %", 100.0 * error),
        None if passes == 1 => "error not known: it takes two passes to tell".to_owned(),
        None => "error not known".to_owned(),
    }
}

/// Whether all pixels of all films are 0.
pub fn is_black(films: &Films) -> bool {
    films.films.iter().all(|(_, film, _)| {
        (0..film.width * film.height).all(|pixel| {
            (0..film.planes.len()).all(|plane| film.mean_entries(pixel, plane).all(|light| light.value == 0.0))
        })
    })
}

fn why_unknown(films: &Films) -> &'static str {
    match films.passes {
        0 => "no pass was made",
        1 => "the run ended after one pass, and it takes two to tell how far they differ",
        _ if is_black(films) => "the picture is black",
        _ => "what was found is nothing but noise yet, hardly any pixel was hit twice",
    }
}
