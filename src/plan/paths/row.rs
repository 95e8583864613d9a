//! Rows of the table: rank, names, kinds, and how they are printed.

use super::lamp_paths::{Source, Way};
use super::part_sequence::{Visits, part_name};
use super::tally::{Footprint, Tally};
use super::{Rows, source_name};
use eyebox_base::ids::GroupId;
use eyebox_scene::Scene;
use eyebox_world::World;
use std::collections::{BTreeMap, BTreeSet};

/// What a row is to the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The most light of its group over specular faces.
    Main,
    /// Over the parts of the main path alone and through the same slides: another image of the same thing.
    Ghost,
    /// Over specular faces, by other parts or past a slide.
    Stray,
    /// By way of a scatterer.
    Scattered,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Main => "main",
            Kind::Ghost => "ghost",
            Kind::Stray => "stray",
            Kind::Scattered => "scattered",
        }
    }
}

/// One way from lamps to the eye.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Row {
    /// From 1, most light first.
    pub number: usize,
    pub group: String,
    pub kind: Kind,
    /// `led → LENS_01 → LCD → COMBINER back → eye`
    pub path: String,
    /// lm into the pupil within the field of view, and its one-sigma error.
    pub flux_lm: f64,
    pub flux_stderr_lm: f64,
    /// One-sigma error of the flux over the flux; of luminance where the pupil is a point.
    pub relative_stderr: f64,
    /// Of all light that was found.
    pub share: f64,
    /// Of the main row of the same group, if there is one.
    pub of_main: Option<f64>,
    /// Luminance where it arrives, cd/m².
    pub mean_cd_m2: f64,
    pub peak_cd_m2: f64,
    /// Luminance over the whole picture, cd/m².
    pub picture_mean_cd_m2: f64,
    pub footprint: Footprint,
    /// Names of the lamps whose light it is.
    pub lamps: Vec<String>,
    /// Arrivals that were found.
    pub arrivals: u64,
    pub parts: Vec<Step>,
    #[serde(skip)]
    pub of: (GroupId, Way),
}

/// What happens at one part.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Step {
    pub part: String,
    /// `through`, `mirror`, `front`, `back`, `inside`, `scattered`.
    pub how: &'static str,
}

pub(super) struct Ranking<'a> {
    pub scene: &'a Scene,
    pub world: &'a World,
    pub passes: u64,
    pub per_pass: u64,
    /// Per group: its light over specular faces was found from the eye.
    pub from_eye: &'a [bool],
    /// No lumen gets into a point: ways count by luminance.
    pub pinhole: bool,
}

pub(super) struct Ranked {
    pub rows: Vec<Row>,
    pub flux_lm: f64,
    pub left_out: (usize, f64),
}

impl Ranking<'_> {
    /// Most light first; rows with less than `least` of it are left out.
    pub fn rank(&self, found: Rows, least: f64) -> Ranked {
        let total = |of: &dyn Fn(&Tally) -> f64| found.values().map(of).sum::<f64>();
        let weight = |tally: &Tally| tally.mean(self.passes);
        let all = total(&weight);
        let lumens = |amount: f64| if self.pinhole { 0.0 } else { amount };
        let mut ranked: Vec<(&(GroupId, Way), &Tally)> = found.iter().collect();
        // Equals stay in the order of their names.
        ranked.sort_by(|(_, a), (_, b)| weight(b).total_cmp(&weight(a)));
        let mut main: BTreeMap<GroupId, (&Visits, f64)> = BTreeMap::new();
        for ((group, way), tally) in &ranked {
            if let Way::Vision(visits) = way {
                main.entry(*group).or_insert((visits, weight(tally)));
            }
        }
        let slides = self.slides();
        let mut rows = Vec::new();
        let mut left_out = (0, 0.0);
        for (of, tally) in ranked {
            let share = if all > 0.0 { weight(tally) / all } else { 0.0 };
            if share.is_nan() || share < least {
                left_out = (left_out.0 + 1, left_out.1 + share);
                continue;
            }
            let (group, way) = of;
            let of_main = main.get(group).map(|(_, of_main)| weight(tally) / of_main);
            let kind = match (way, main.get(group)) {
                (Way::Scattered { .. }, _) => Kind::Scattered,
                (Way::Vision(visits), Some((main, _))) if visits == *main => Kind::Main,
                (Way::Vision(visits), Some((main, _))) => {
                    let slides = main.passes(&slides).is_subset(&visits.passes(&slides));
                    let image = slides && visits.parts().is_subset(&main.parts());
                    if image { Kind::Ghost } else { Kind::Stray }
                }
                (Way::Vision(_), None) => Kind::Stray,
            };
            let by_eye = match way {
                Way::Scattered { .. } => true,
                Way::Vision(_) => self.from_eye.get(group.index()) == Some(&true),
            };
            let looked = (by_eye && !tally.is_even()).then_some(self.passes * self.per_pass);
            let (footprint, mean_cd_m2, peak_cd_m2) = tally.footprint(&self.world.eye, self.passes, looked);
            let [width, height] = self.world.eye.size();
            let stderr = tally.stderr(self.passes, self.per_pass);
            rows.push(Row {
                number: rows.len() + 1,
                group: self.scene.groups.get(group.index()).map_or_else(String::new, |group| group.name.clone()),
                kind,
                path: self.path(*group, way, &tally.sources),
                flux_lm: lumens(weight(tally)),
                flux_stderr_lm: lumens(stderr),
                relative_stderr: stderr / weight(tally),
                share,
                of_main,
                mean_cd_m2,
                peak_cd_m2,
                picture_mean_cd_m2: tally.luminance / self.passes as f64 / (width * height) as f64,
                footprint,
                lamps: tally.sources.iter().map(|source| source_name(self.scene, self.world, *source)).collect(),
                arrivals: tally.count,
                parts: self.steps(way),
                of: of.clone(),
            });
        }
        Ranked { rows, flux_lm: lumens(all), left_out }
    }

    /// Parts with a slide.
    fn slides(&self) -> BTreeSet<u32> {
        let parts = self.scene.parts.iter().enumerate();
        let with = parts.filter(|(_, part)| part.faces.iter().any(|face| face.slide.is_some()));
        with.filter_map(|(index, _)| u32::try_from(index).ok()).collect()
    }

    fn path(&self, group: GroupId, way: &Way, sources: &BTreeSet<Source>) -> String {
        let from = self.lamps(group, sources);
        let words = |visits: &Visits| visits.words(self.scene);
        match way {
            Way::Vision(visits) => [vec![from], words(visits), vec!["eye".to_owned()]].concat().join(" → "),
            Way::Scattered { again, before, at, after } => {
                let at = part_name(self.scene, *at);
                let from = if *again { vec![from, "… scattered".to_owned()] } else { vec![from] };
                let before = [from, words(before), vec![at.clone()]].concat().join(" → ");
                let after = [vec![at], words(after), vec!["eye".to_owned()]].concat().join(" → ");
                format!("{before} | {after}")
            }
        }
    }

    /// What the lamps have in common: the name of one, the start of their names, or their group.
    fn lamps(&self, group: GroupId, sources: &BTreeSet<Source>) -> String {
        let names: Vec<String> = sources.iter().map(|source| source_name(self.scene, self.world, *source)).collect();
        let group = || self.scene.groups.get(group.index()).map_or_else(String::new, |group| group.name.clone());
        let Some((first, rest)) = names.split_first() else { return group() };
        if rest.iter().all(|name| name == first) && !first.is_empty() {
            return first.clone();
        }
        let common = rest.iter().fold(first.as_str(), |common, name| {
            let same = common.chars().zip(name.chars()).take_while(|(a, b)| a == b).map(|(a, _)| a.len_utf8()).sum();
            common.get(..same).unwrap_or_default()
        });
        let common = common.trim_end_matches(|c: char| c.is_ascii_digit() || "_-. #/".contains(c));
        if common.len() < 2 { group() } else { common.to_owned() }
    }

    fn steps(&self, way: &Way) -> Vec<Step> {
        let steps = |visits: &Visits| -> Vec<Step> {
            let step = |visit: &super::Visit| Step { part: part_name(self.scene, visit.part), how: visit.how.word() };
            visits.all.iter().map(step).collect()
        };
        match way {
            Way::Vision(visits) => steps(visits),
            Way::Scattered { before, at, after, .. } => {
                let at = Step { part: part_name(self.scene, *at), how: "scattered" };
                [steps(before), vec![at], steps(after)].concat()
            }
        }
    }
}
