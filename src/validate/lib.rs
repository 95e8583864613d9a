//! Floor 6: `eyebox validate`: the rules over an asset, and reports of what they find.
//!
//! `path ─read→ Examined ─rules→ Finding… ─locate→ Located… ─config, baseline→ Report ─report→ text`. Rules that only look
//! stand in `check/rules`, those that trace in `validate/rules`.

pub mod baseline; // findings that are known
pub mod config; // eyebox.toml
pub mod fingerprint; // what makes a finding the same one tomorrow
pub mod folder; // what a folder stands for
mod heal; // going on past a fault
pub mod locate; // lines and columns
mod missing; // files that several places name
pub mod page; // the documentation of a rule
mod read; // an asset as far as it can be read
pub mod report; // the formats
pub mod rules; // the registry of all rules
pub mod stdin; // an asset on standard input

use baseline::Known;
use config::Config;
use eyebox_base::relative_path::{relative, slashed};
use eyebox_base::{Code, Error, Result};
use eyebox_check::finding::{Finding, Level};
use eyebox_check::geometry::EdgesOfMeshes;
use eyebox_check::rule::Rule;
use eyebox_check::subject::{Refusal, Stage, Subject};
use eyebox_import::ReadOptions;
use eyebox_scene::{Note, Scene, Severity};
use eyebox_world::World;
use eyebox_world::eye::EyeLens;
use eyebox_world::geometry::Geometry;
use fingerprint::Named;
use locate::{Locator, Place};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use stdin::Piped;

/// A finding with its place in a file, as reports show it.
#[derive(Debug, Clone)]
pub struct Located {
    /// Index of the asset in which it was found first.
    pub asset: usize,
    pub rule: &'static Rule,
    pub level: Level,
    pub text: String,
    /// The same with files named from the asset's folder, wherever the program runs.
    pub lasting: String,
    pub place: Place,
    /// Hex; the same for the same finding in a later version of the asset, whatever lines were added above it.
    pub fingerprint: String,
}

/// What validation found.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// What was validated, as it was named.
    pub assets: Vec<PathBuf>,
    /// Files of folders that are not among them because they are layers of others.
    pub layers: usize,
    /// By asset, file, line and code.
    pub findings: Vec<Located>,
    /// Findings that the baseline knows.
    pub known: usize,
    /// Findings beyond `max_findings`.
    pub cut: usize,
}

impl Report {
    /// Errors, warnings and notes.
    pub fn counts(&self) -> [usize; 3] {
        [Level::Error, Level::Warning, Level::Note]
            .map(|level| self.findings.iter().filter(|f| f.level == level).count())
    }
    /// Whether there is nothing worse than a note.
    pub fn is_clean(&self) -> bool {
        self.cut == 0 && self.findings.iter().all(|finding| finding.level == Level::Note)
    }
}

/// Validates `assets`, files and folders of them. `known`: what the baseline knows.
///
/// # Errors
/// An asset that is not there or no regular file, a folder without assets. Whatever is wrong inside one is a finding.
pub fn validate(assets: &[PathBuf], config: &Config, known: &Known) -> Result<Report> {
    validate_with(assets, None, config, known, &ReadOptions::default())
}

/// The same with standard input, if it was read, where `-` stands among `assets`, and assets as `reading` has them.
///
/// # Errors
/// Those of [`validate`].
pub fn validate_with(
    assets: &[PathBuf],
    piped: Option<&Piped>,
    config: &Config,
    known: &Known,
    reading: &ReadOptions,
) -> Result<Report> {
    let folder::Expanded { files: assets, layers } = folder::expand(assets)?;
    let of = |asset: &Path| piped.filter(|_| asset == Path::new(stdin::NAMED));
    let named = |asset: &PathBuf| if of(asset).is_some() { PathBuf::from(stdin::SHOWN) } else { asset.clone() };
    for asset in assets.iter().filter(|asset| of(asset).is_none()) {
        read::check_there(asset)?;
    }
    let mut report = Report { assets: assets.iter().map(named).collect(), layers, ..Report::default() };
    for (index, asset) in assets.iter().enumerate() {
        for mut finding in located(asset, of(asset), config, reading) {
            finding.asset = index;
            // Two sidecars over one asset find the same in it.
            if report.findings.iter().any(|other| other.fingerprint == finding.fingerprint) {
                continue;
            }
            report.findings.push(finding);
        }
    }
    let before = report.findings.len();
    let mut new = known.unknown(&report.findings).into_iter();
    report.findings.retain(|_| new.next().unwrap_or(true));
    report.known = before - report.findings.len();
    if let Some(most) = config.max_findings {
        report.cut = report.findings.len().saturating_sub(most);
        report.findings.truncate(most);
    }
    Ok(report)
}

/// The findings about one asset, which may be standard input, that the configuration lets through, each at its place.
fn located(asset: &Path, piped: Option<&Piped>, config: &Config, reading: &ReadOptions) -> Vec<Located> {
    // By an absolute name, so that files in texts are told from names that stand in the asset.
    let named = Named::of(asset);
    let asset = piped.map_or(named.whole.as_path(), Piped::path);
    let said = |text: &str| piped.map_or_else(|| named.shown(text), |piped| piped.unnamed(text));
    let examined = read::examine(asset, reading);
    let mut found = examined.findings();
    let mut locator = Locator::new(asset, examined.assembly.as_ref());
    // A place is looked up once for a finding, so that sorting is by what is shown.
    let mut all: Vec<Located> = Vec::new();
    let mut seen = BTreeSet::new();
    found.retain(|finding| seen.insert((finding.code, finding.at.to_string(), finding.text.clone())));
    for finding in found {
        let Some(rule) = rules::find(finding.code) else { continue };
        let place = locator.place(&finding.at, &finding.text);
        let place = Place {
            file: said(&place.file),
            logical: place.logical.as_deref().map(said),
            part: place.part.as_deref().map(said),
            ..place
        };
        let Some(level) = config.level(rule, &place.file, finding.level) else { continue };
        let text = printable(&said(&finding.text));
        let lasting = piped.map_or_else(|| printable(&named.lasting(&finding.text)), |_| text.clone());
        all.push(Located { asset: 0, rule, level, text, lasting, place, fingerprint: String::new() });
    }
    all.sort_by(|a, b| {
        let key =
            |f: &Located| (f.place.file.clone(), f.place.line, f.rule.code, f.place.logical.clone(), f.text.clone());
        key(a).cmp(&key(b))
    });
    fingerprint::stamp(&mut all);
    all
}

/// The findings about one asset as rules make them, in the order of the registry; no configuration, no places in text.
pub fn findings(asset: &Path) -> Vec<Finding> {
    read::examine(asset, &ReadOptions::default()).findings()
}

impl read::Examined {
    fn findings(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        let empty = eyebox_scene::assembly::Assembly { file: self.file.clone(), ..Default::default() };
        let assembly = self.assembly.as_ref().unwrap_or(&empty);
        // Without a scene, rules that look at the asset's own lists still can.
        let nothing = read::no_scene();
        let subject = Subject {
            file: &self.file,
            assembly,
            sheet: self.sheet.as_ref(),
            scene: self.scene.as_ref().unwrap_or(&nothing),
            whole: self.scene.is_some() && self.refusals.is_empty(),
            needed: &self.needed,
            refusals: &self.refusals,
            edges: &EdgesOfMeshes::default(),
        };
        found.extend(missing::findings(&self.refusals, &self.needed));
        let notes = self.scene.as_ref().map_or(&assembly.notes, |scene| &scene.notes);
        for note in notes {
            let Some(rule) = rule_of(note) else { continue };
            let level = (rule.grade)(rule, &subject, note);
            found.push(Finding { level, ..rule.at(note.at.clone(), note.text.clone()) });
        }
        for rule in eyebox_check::rules::RULES {
            found.extend((rule.find)(&subject));
        }
        if subject.whole {
            found.extend(traced(&subject));
        }
        found
    }
}

/// What the rules that trace find, or why nothing can be traced.
fn traced(subject: &Subject<'_>) -> Vec<Finding> {
    let refuse = |fault| refused(&Refusal { stage: Stage::Freeze, fault }).into_iter().collect();
    let checked = match eyebox_check::check(subject.scene) {
        Ok(checked) => checked,
        Err(fault) => return refuse(fault),
    };
    // A tree over millions of triangles takes longer than all else: it is built for rules that will look at it.
    if !rules::concern(subject.scene) {
        return refused_geometry(subject.scene).map_or_else(Vec::new, refuse);
    }
    let world = match World::freeze(subject.scene) {
        Ok(world) => world,
        Err(fault) => return refuse(fault),
    };
    let frozen = rules::Frozen { subject, checked: &checked, world: &world };
    rules::TRACED.iter().flat_map(|traced| (traced.find)(&frozen)).collect()
}

/// Why a scene without optics cannot be traced, if it cannot.
fn refused_geometry(scene: &Scene) -> Option<Box<Error>> {
    let eye = |()| EyeLens::build(&scene.eye, scene.eye.position).map(|_| ());
    Geometry::check(scene).and_then(eye).err()
}

/// The finding of a fault of the importer.
fn refused(refusal: &Refusal) -> Option<Finding> {
    let fault = &refusal.fault;
    let rule = rules::find(refusal.code().rule())?;
    let mut text = fault.what.clone();
    if let Some(expected) = &fault.expected {
        text += &format!("; expected {expected}");
    }
    if let Some(nearest) = &fault.nearest {
        text += &format!("; did you mean `{nearest}`?");
    }
    // Whatever the rule says of milder cases: this keeps the asset from rendering.
    Some(Finding { level: Level::Error, ..rule.at(fault.at.clone(), text) })
}

/// The rule whose finding a note of the importer is. Of those that say nothing of what they are about, only warnings are
/// one.
fn rule_of(note: &Note) -> Option<&'static Rule> {
    if note.code == Some(Code::TextureMissing) {
        // The rule has it from the list of files that the asset needs.
        return None;
    }
    let code = note.code.or(match note.severity {
        Severity::Warning => Some(Code::LeftOut),
        Severity::Info => None,
    })?;
    rules::find(code.rule())
}

/// Text without control characters, which a hostile name may have.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// A file as reports name it: relative to the working directory, with forward slashes.
pub fn shown(file: &Path) -> String {
    let relative = relative(Path::new("."), file);
    printable(&if relative.as_os_str().is_empty() { slashed(file) } else { slashed(&relative) })
}
