//! Layers whose unit or up axis is another one than the root layer's. USD composes their numbers as they are, so whoever refers
//! to such a layer has to scale and turn the prim; where that is done there is nothing to say.

use super::attribute::Moment;
use super::notes::Ledger;
use super::stage::{Up, file_name, up};
use super::value;
use crate::assembly::Assembly;
use eyebox_base::Where;
use glam::DMat3;
use openusd::sdf::{self, Value};
use openusd::usd::Stage;

/// What a prim that refers to another layer does to it.
struct Reference {
    /// Of the file that is referred to.
    name: String,
    scale: Option<[f64; 3]>,
    turns: bool,
}

/// Adds a warning for each layer that nobody puts right.
pub(super) fn check(stage: &Stage, moment: &Moment, assembly: &Assembly, ledger: &mut Ledger) {
    let root = sdf::Path::abs_root();
    let root_is_z = assembly.axes != DMat3::IDENTITY;
    let references = references(stage);
    for identifier in stage.layer_identifiers() {
        let Some(layer) = stage.layer(&identifier) else { continue };
        let field = |key: &str| layer.data().try_field(&root, key).ok().flatten().map(|found| found.into_owned());
        let name = file_name(&identifier);
        let all = |is_right: &dyn Fn(&Reference) -> bool| {
            let mut own = references.iter().filter(|reference| reference.name == name).peekable();
            own.peek().is_some() && own.all(is_right)
        };
        if let Some(unit) = field("metersPerUnit").as_ref().and_then(value::number)
            && (unit - assembly.unit_m).abs() > 1e-9 * assembly.unit_m
        {
            let ours = assembly.unit_m;
            let is_right = |scale: f64| (scale * ours - unit).abs() <= 1e-6 * unit;
            if !all(&|reference| reference.scale.is_some_and(|scale| scale.into_iter().all(is_right))) {
                let text = format!(
                    "the layer {name} is in units of {unit} m, the root layer in {ours} m: USD does not rescale, so its lengths are taken as they are"
                );
                ledger.warn(Where::file(&moment.file), text);
            }
        }
        if let Some(axis) = field("upAxis").as_ref().and_then(value::text).and_then(up)
            && (axis == Up::Z) != root_is_z
            && !all(&|reference| reference.turns)
        {
            let text = format!("the layer {name} has another up axis than the root layer: USD does not turn it");
            ledger.warn(Where::file(&moment.file), text);
        }
    }
}

/// All references and payloads that lead to other layers.
fn references(stage: &Stage) -> Vec<Reference> {
    let mut out = Vec::new();
    for identifier in stage.layer_identifiers() {
        let Some(layer) = stage.layer(&identifier) else { continue };
        let data = layer.data();
        for spec in data.spec_paths().into_iter().filter(sdf::Path::is_prim_path) {
            let mut assets: Vec<String> = Vec::new();
            for field in ["references", "payload"] {
                let Ok(Some(found)) = data.try_field(&spec, field) else { continue };
                match &*found {
                    Value::ReferenceListOp(list) => assets.extend(list.iter().map(|one| one.asset_path.to_string())),
                    Value::PayloadListOp(list) => assets.extend(list.iter().map(|one| one.asset_path.to_string())),
                    Value::Payload(one) => assets.push(one.asset_path.to_string()),
                    // Of another type it is no arc.
                    _ => {}
                }
            }
            if assets.is_empty() {
                continue;
            }
            let op = |name: &str| {
                let property = spec.append_property(name).ok()?;
                data.try_field(&property, "default").ok().flatten().map(|found| found.into_owned())
            };
            let scale = op("xformOp:scale").as_ref().and_then(value::triple);
            let turns = ["xformOp:rotateX", "xformOp:rotateXYZ", "xformOp:orient", "xformOp:transform"];
            let turns = turns.into_iter().any(|name| op(name).is_some());
            let names = assets.iter().filter(|asset| !asset.is_empty());
            out.extend(names.map(|asset| Reference { name: file_name(asset).to_owned(), scale, turns }));
        }
    }
    out
}
