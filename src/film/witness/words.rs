//! What a witness says, for people.

use super::sent::FEWEST;
use super::{Judged, Judgement, Off};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;

/// `led vision`, `led caustic + secondary`.
fn named(group: &str, classes: &[Class]) -> String {
    let classes: Vec<&str> = classes.iter().map(|class| class.name()).collect();
    format!("{group} {}", classes.join(" + "))
}

/// So many digits that the last two are uncertain.
fn with_error([value, error]: [f64; 2]) -> String {
    let digits =
        if error > 0.0 && error.is_finite() { (1.0 - error.log10().floor()).clamp(0.0, 5.0) as usize } else { 3 };
    if error.is_finite() { format!("{value:.digits$} ± {error:.digits$}") } else { format!("{value:.2} ± ?") }
}

fn number(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (3.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize };
    format!("{value:.digits$}")
}

impl Off {
    fn place(&self) -> String {
        match (self.columns, self.rows) {
            (Some([left, right]), Some([top, bottom])) => {
                format!("in columns {left} to {right}, rows {top} to {bottom}")
            }
            (_, _) => "over the whole picture".to_owned(),
        }
    }

    /// Which way, where and by how much.
    pub fn text(&self, from_lamps: bool) -> String {
        let which = if self.sigmas > 0.0 { "bright" } else { "dark" };
        let open = if self.open { ", with the slides open" } else { "" };
        let sigmas = if self.sigmas.is_finite() { format!("{:.1}", self.sigmas.abs()) } else { "∞".to_owned() };
        let [run, seen, error] = [self.run, self.witness, self.error].map(number);
        let by = if from_lamps { "followed from the lamps" } else { "of brute force" };
        format!("too {which} {}: {run} cd/m² for {seen} {by}, ± {error}, {sigmas} σ{open}", self.place())
    }
}

/// Standard errors by which a picture is brighter than what was followed from the lamps where there is more light than that.
const BEYOND: f64 = 4.0;

impl Judged {
    /// The light, for people: `led vision`. `group`: its name.
    pub fn name(&self, group: &str) -> String {
        named(group, &self.classes)
    }

    fn line(&self, group: &str) -> String {
        let what = named(group, &self.classes);
        if self.from_lamps {
            return match self.ratio {
                Some([ratio, error]) if ratio - 1.0 > BEYOND * error => {
                    let percent = 100.0 / ratio;
                    format!(
                        "witness: {what}: {percent:.0} % of it was followed from the lamps and is there, the rest comes another way"
                    )
                }
                Some(ratio) => format!("witness: {what} {} of what was followed from the lamps", with_error(ratio)),
                None if self.looks < FEWEST => {
                    format!("witness: {what}: too little work to follow light from the lamps")
                }
                None => format!(
                    "witness: {what}: none of the light that was followed from the lamps came straight to the eye"
                ),
            };
        }
        match self.ratio {
            Some(ratio) => format!("witness: {what} {} of brute force", with_error(ratio)),
            None if self.looks == 0 => format!("witness: {what}: too little work for a look"),
            None => format!("witness: {what}: none of {} looks of brute force met it", self.looks),
        }
    }
}

impl Judgement {
    /// One line per kind of light. `name`: of a light group.
    pub fn lines(&self, name: &dyn Fn(GroupId) -> String) -> Vec<String> {
        let judged = self.judged.iter().map(|judged| judged.line(&name(judged.group)));
        let unwatched = self.unwatched.iter().map(|own| {
            let what = named(&name(own.group), &[own.class]);
            format!("witness: {what}: nobody looked, {}", own.because)
        });
        judged.chain(unwatched).collect()
    }

    /// One line per kind of light that is off.
    pub fn warnings(&self, name: &dyn Fn(GroupId) -> String) -> Vec<String> {
        let off = |judged: &Judged| {
            let what = named(&name(judged.group), &judged.classes);
            judged.off.as_ref().map(|off| format!("witness: {what} is {}", off.text(judged.from_lamps)))
        };
        self.judged.iter().filter_map(off).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_tell_the_digits() {
        assert_eq!(with_error([0.998, 0.011]), "0.998 ± 0.011");
        assert_eq!(with_error([0.5, 0.25]), "0.50 ± 0.25");
        assert_eq!(with_error([1.00012, 0.00009]), "1.00012 ± 0.00009");
        assert_eq!(with_error([1.0, f64::INFINITY]), "1.00 ± ?");
        assert_eq!(number(833.26), "833.3");
        assert_eq!(number(0.0), "0");
    }
}
