//! The last step before writing: films, data layers and the record of the run become one frame.

use super::data::{Data, SeenLooks, SeenPixels};
use super::finishing::Finishing;
use super::run::{Films, Outcome, Stop};
use super::slides;
use eyebox_base::colour::ColourSpace;
use eyebox_base::{Error, Result, Where};
use eyebox_film::cryptomatte::Matte;
use eyebox_film::diffraction::Diffraction;
use eyebox_film::finish::{Finished, GroupInfo, Split};
use eyebox_film::frame::{Channel, Frame, Meta, Samples};
use eyebox_film::names;
use eyebox_film::plan::{Plan, Spectral, Verdict};
use eyebox_film::sharpness::Sharpness;
use eyebox_film::witness::Judgement;
use eyebox_scene::{Group, Scene, Spectrum, Wavelengths};
use std::collections::BTreeSet;

/// The picture layers of a run. `direct`, `caustic` and `forward` are always there; `secondary` only if there is any.
/// Errors: NaN or infinite light, which is never coloured over.
pub fn picture(scene: &Scene, plan: &Plan, outcome: &Outcome, space: ColourSpace) -> Result<Finished> {
    picture_through(scene, plan, outcome, space, None)
}

/// The same, spread by diffraction if asked for.
pub fn picture_through(
    scene: &Scene,
    plan: &Plan,
    outcome: &Outcome,
    space: ColourSpace,
    diffraction: Option<&Diffraction>,
) -> Result<Finished> {
    Finishing::new(scene, plan, space, diffraction.cloned()).picture(&outcome.films)
}

/// What the frame's maker has to know of each light group.
pub(super) fn infos(scene: &Scene, plan: &Plan) -> Vec<GroupInfo> {
    let tints = tints(scene, plan);
    scene
        .groups
        .iter()
        .zip(tints)
        .map(|(group, tint)| GroupInfo {
            name: group.name.clone(),
            contrast: slides::common_contrast(scene),
            slides: None,
            tint,
        })
        .collect()
}

/// Linear Rec.709 of a unit of each group's luminance: grey at one wavelength, and where films hold colours.
fn tints(scene: &Scene, plan: &Plan) -> Vec<[f64; 3]> {
    const GREY: [f64; 3] = [1.0; 3];
    let spectra = match (plan.mode.spectral, scene.wavelengths) {
        (Spectral::Mono, Wavelengths::Visible) => scene.spectra_of_groups().unwrap_or_default(),
        (Spectral::Mono | Spectral::Rgb | Spectral::Hero, _) => Vec::new(),
    };
    let tint = |spectrum: &Spectrum| spectrum.resolve().map_or(GREY, |power| power.rec709_per_lumen());
    (0..scene.groups.len())
        .map(|group| match spectra.get(group) {
            // A group without lamps, and the white of a panorama.
            None | Some(None) => GREY,
            Some(Some(Spectrum::Rgb([r, g, b]))) if r == g && g == b => GREY,
            Some(Some(spectrum)) => tint(spectrum),
        })
        .collect()
}

/// Adds `Z`, `normal`, `albedo`, `position`, `id` at the first hit, where there are ordinary materials also `normal_geometric`, `uv`
/// and `opacity`, the same `_seen` behind specular faces, `seethrough`, and `alpha`, what that leaves of 1.
pub fn add_data_layers(frame: &mut Frame, data: Data) {
    let mut add = |name: String, data: Vec<f32>| frame.push(name, data);
    let Data { first, seen, seethrough } = data;
    let mut greys: Vec<(String, Samples)> = Vec::new();
    for (suffix, depth, SeenPixels { z_m, position, normal, albedo, tint, part, face, looks }) in
        [("", "Z", first), ("_seen", "Z_seen.Z", seen)]
    {
        add(depth.to_owned(), z_m);
        for ((name, normal), position) in ["X", "Y", "Z"].into_iter().zip(normal).zip(position) {
            add(format!("normal{suffix}.{name}"), normal);
            add(format!("position{suffix}.{name}"), position);
        }
        add(format!("id{suffix}.part"), part);
        add(format!("id{suffix}.face"), face);
        if let Some(SeenLooks { geometric, uv, opacity }) = looks {
            for (name, data) in ["X", "Y", "Z"].into_iter().zip(geometric) {
                add(format!("normal_geometric{suffix}.{name}"), data);
            }
            for (name, data) in ["u", "v"].into_iter().zip(uv) {
                add(format!("uv{suffix}.{name}"), data);
            }
            add(format!("opacity{suffix}.A"), opacity);
        }
        match tint {
            None => greys.push((format!("albedo{suffix}"), albedo.into())),
            Some([green, blue]) => {
                for (name, data) in ["R", "G", "B"].into_iter().zip([albedo, green, blue]) {
                    add(format!("albedo{suffix}.{name}"), data);
                }
            }
        }
    }
    add("alpha.A".to_owned(), seethrough.iter().map(|through| 1.0 - through).collect());
    greys.push(("seethrough".to_owned(), seethrough.into()));
    for (layer, data) in greys {
        // Grey is stored three times, and held once.
        let channel = |name| Channel { name: format!("{layer}.{name}"), data: data.clone() };
        frame.channels.extend(["R", "G", "B"].map(channel));
    }
}

/// Writes the record of the run into the header: what was rendered, how, and what was decided.
pub fn add_meta(frame: &mut Frame, scene: &Scene, plan: &Plan, outcome: &Outcome, seed: u64, splits: &[Split]) {
    let mut put = |name: &str, value: Meta| {
        frame.meta.insert(name.to_owned(), value);
    };
    let text = |value: &dyn erased::Json| Meta::Text(value.json());
    put("version", Meta::Text(env!("CARGO_PKG_VERSION").to_owned()));
    put("scene", Meta::Text(scene.name.clone()));
    put("sceneHash", Meta::Text(scene.hash.clone()));
    put("seed", Meta::Text(seed.to_string()));
    put("plan", text(plan));
    put("planReadable", Meta::Text(plan_lines(scene, plan).join("\n")));
    put("groups", text(&scene.groups.iter().map(|g| g.name.as_str()).collect::<Vec<_>>()));
    put("parts", text(&scene.parts.iter().map(|p| p.path.as_str()).collect::<Vec<_>>()));
    put("wavelengths", text(&scene.wavelengths));
    put("pupilDiameter_m", Meta::Number(scene.eye.pupil_diameter_m));
    put("eye", text(&scene.eye));
    if let Some(contrast) = slides::common_contrast(scene) {
        put("contrast", Meta::Number(contrast));
    }
    add_sums(frame, &outcome.films, outcome.stop, splits);
}

/// The part of the record that tells of the passes that were made.
pub fn add_sums(frame: &mut Frame, films: &Films, stop: Stop, splits: &[Split]) {
    let mut put = |name: &str, value: Meta| {
        frame.meta.insert(name.to_owned(), value);
    };
    let text = |value: &dyn erased::Json| Meta::Text(value.json());
    put("passes", Meta::Text(films.passes.to_string()));
    for (estimator, film, ledger) in &films.films {
        let name = estimator.name();
        put(&format!("passes.{name}"), Meta::Text(film.most_passes().to_string()));
        if films.dealt.rounds > 0 {
            put(&format!("passesMean.{name}"), Meta::Number(film.mean_passes()));
        }
        put(&format!("paths.{name}"), Meta::Text(ledger.paths.to_string()));
        put(&format!("ledger.{name}"), text(ledger));
    }
    put("stop", text(&stop));
    put("splits", text(&splits.to_vec()));
}

/// Writes into the header the relative error that a run states, asked of its films while they still knew it.
pub fn add_stated_error(frame: &mut Frame, error: Option<f64>) {
    match error.filter(|error| error.is_finite()) {
        Some(error) => frame.meta.insert(names::STATED_ERROR.to_owned(), Meta::Number(error)),
        None => frame.meta.remove(names::STATED_ERROR),
    };
}

/// Writes into the header how sharp diffraction lets the picture be, and whether it was applied.
pub fn add_sharpness(frame: &mut Frame, sharpness: &Sharpness) {
    frame.meta.insert(Sharpness::KEY.to_owned(), Meta::Text(erased::Json::json(sharpness)));
    frame.meta.insert(format!("{}Readable", Sharpness::KEY), Meta::Text(sharpness.lines().join("\n")));
}

/// Writes what a witness saw into the header. `asked`: it was not switched off. `lines`: the same for people.
pub fn add_witness(frame: &mut Frame, judgement: Option<&Judgement>, asked: bool, lines: &[String]) {
    let said = match (judgement, asked) {
        (Some(judgement), _) => (erased::Json::json(judgement), lines.join("\n")),
        (None, true) => ("null".to_owned(), "naive paths have traced all light themselves".to_owned()),
        (None, false) => ("null".to_owned(), "switched off".to_owned()),
    };
    frame.meta.insert("witness".to_owned(), Meta::Text(said.0));
    frame.meta.insert("witnessReadable".to_owned(), Meta::Text(said.1));
}

mod erased {
    /// Anything that serialises, for a header that holds texts.
    pub trait Json {
        fn json(&self) -> String;
    }
    impl<T: serde::Serialize> Json for T {
        fn json(&self) -> String {
            serde_json::to_string(self).unwrap_or_else(|error| format!("\"{error}\""))
        }
    }
}

/// The plan, one line per row, for people.
pub fn plan_lines(scene: &Scene, plan: &Plan) -> Vec<String> {
    let mut lines: Vec<String> = plan
        .rows
        .iter()
        .map(|row| {
            let group = &scene.group(row.group).name;
            let class = row.class.name();
            match &row.verdict {
                Verdict::Own { owner, because } => format!("{group} {class}: {} because {because}", owner.name()),
                Verdict::Connect { rest, because } => {
                    format!("{group} {class}: manifold because {because}; the rest: {}", rest.name())
                }
                Verdict::Emitted { because } => {
                    format!("{group} {class}: photon and forward because {because}")
                }
                Verdict::Skip { because } => format!("{group} {class}: skipped because {because}"),
            }
        })
        .collect();
    let mode = &plan.mode;
    lines.push(format!("wavelengths: {} because {}", mode.spectral.name(), mode.spectral_because));
    let on = if mode.polarised { "traced" } else { "not traced" };
    lines.push(format!("polarisation: {on} because {}", mode.polarised_because));
    lines.extend(plan.notes.iter().map(|note| format!("note: {note}")));
    lines
}

/// Every layer that a picture with these groups may have, and with these slides if there are several.
pub fn possible_layers(groups: &[Group], slides: &[String]) -> BTreeSet<String> {
    names::possible(groups.iter().map(|group| group.name.as_str()), slides)
}

/// Checks the names of layers that are asked for, before anything is traced. Errors: a layer that no picture of this
/// scene can have, with the nearest one.
pub fn check_layers(layers: &[String], groups: &[Group], slides: &[String]) -> Result<()> {
    let possible = possible_layers(groups, slides);
    match layers.iter().find(|layer| !possible.contains(*layer)) {
        None => Ok(()),
        Some(layer) => Err(Error::new(Where::Option("--layers".to_owned()), format!("there is no layer `{layer}`"))
            .expected("direct, caustic, secondary, forward, hybrid, LAYER_GROUP, stderr, Z, normal, position, albedo, id, seethrough, work or CryptoPart")
            .nearest(layer, possible.iter().map(String::as_str))),
    }
}

/// Keeps only the layers named in `layers` (all if empty) and the default image. A layer without light is not there.
pub fn keep_layers(frame: &mut Frame, layers: &[String]) {
    if layers.is_empty() {
        return;
    }
    frame.channels.retain(|channel| {
        let layer = match channel.name.split_once('.') {
            Some((layer, _)) => layer,
            None if ["R", "G", "B"].contains(&channel.name.as_str()) => return true,
            None => &channel.name,
        };
        let matte = Matte::of_layer(layer).map(Matte::name);
        layers.iter().any(|wanted| wanted == layer || Some(wanted.as_str()) == matte)
    });
}
