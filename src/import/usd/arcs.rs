//! The arcs that a stack of layers spells out: references, payloads, inherits, specializes, and variants to choose
//! from. Only where they lead, for counting.

use super::resolver::Normalising;
use openusd::ar::{ResolvedPath, Resolver};
use openusd::sdf::{self, AbstractData, Path, Value};
use std::collections::HashMap;

/// Where an arc leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Arc {
    /// A prim of the same stack of layers.
    Inside(Path),
    /// A prim, or the default prim, of another stack, by the identifier of its root layer.
    Outside(String, Option<Path>),
}

/// Ways of which one is taken: the variants of a set, or the one way of arcs that always hold.
#[derive(Debug, Default)]
pub(super) struct Choice {
    pub is_variant: bool,
    pub ways: HashMap<String, Vec<Arc>>,
}

/// The arcs of one stack of layers, by the prim (without variants) that has them.
#[derive(Debug, Default)]
pub(super) struct Stack {
    pub layers: u64,
    pub default_prim: Option<Path>,
    /// There are inherits or specializes.
    pub has_class: bool,
    pub arcs: HashMap<Path, HashMap<String, Choice>>,
}

const FIELDS: [&str; 4] = ["references", "payload", "inheritPaths", "specializes"];

/// Whether a text can have arcs at all.
pub(super) fn may_be_in(text: &[u8]) -> bool {
    const WORDS: [&[u8]; 5] = [b"references", b"payload", b"inherits", b"specializes", b"variantSet"];
    // All that is looked at closely are the four letters that the words begin with.
    let mut rest = text;
    while let Some(at) = rest.iter().position(|byte| matches!(byte, b'r' | b'p' | b'i' | b's' | b'v')) {
        rest = rest.get(at..).unwrap_or_default();
        if WORDS.iter().any(|word| rest.starts_with(word)) {
            return true;
        }
        rest = rest.get(1..).unwrap_or_default();
    }
    false
}

impl Stack {
    /// Adds the arcs of one layer, whose relative names are relative to `anchor`.
    pub fn add(
        &mut self,
        data: &dyn AbstractData,
        anchor: &str,
        resolver: &Normalising,
        vars: &HashMap<String, Value>,
    ) {
        let anchor = ResolvedPath::new(anchor);
        let outside = |asset: &str, path: &Path| {
            let asset = sdf::expr::evaluate_string(asset, vars).value?;
            let path = (!path.is_empty()).then(|| path.clone());
            Some(Arc::Outside(resolver.create_identifier(&asset, Some(&anchor)), path))
        };
        let mut has_class = false;
        for spec in data.spec_paths() {
            let is_variant = spec.is_prim_variant_selection_path();
            if !is_variant && !spec.is_prim_path() {
                continue;
            }
            let host = spec.strip_all_variant_selections();
            let arc = |asset: &str, path: &Path| match asset {
                "" => Some(if path.is_empty() {
                    Arc::Inside(self.default_prim.clone()?)
                } else {
                    Arc::Inside(path.clone())
                }),
                _ => outside(asset, path),
            };
            let mut found: Vec<Arc> = Vec::new();
            for field in FIELDS {
                let Ok(Some(value)) = data.try_field(&spec, field) else { continue };
                match &*value {
                    Value::ReferenceListOp(list) => {
                        found.extend(list.iter().filter_map(|one| arc(&one.asset_path, &one.prim_path)));
                    }
                    Value::PayloadListOp(list) => {
                        found.extend(list.iter().filter_map(|one| arc(&one.asset_path, &one.prim_path)));
                    }
                    Value::Payload(one) => found.extend(arc(&one.asset_path, &one.prim_path)),
                    Value::PathListOp(list) => {
                        has_class = true;
                        found.extend(list.iter().map(|path| Arc::Inside(host.make_absolute(path))))
                    }
                    // Of another type it is no arc.
                    _ => {}
                }
            }
            if found.is_empty() && !is_variant {
                continue;
            }
            let (set, way) = variant(spec.as_str());
            let choice = self.arcs.entry(host).or_default().entry(set.to_owned()).or_default();
            choice.is_variant = !set.is_empty();
            choice.ways.entry(way.to_owned()).or_default().append(&mut found);
        }
        self.has_class |= has_class;
    }
}

/// `/A{set=` and `way` of `/A{set=way}B`; both empty outside of variants.
fn variant(path: &str) -> (&str, &str) {
    let split = path.rfind('{').and_then(|open| Some(open + path.get(open..)?.find('=')? + 1));
    let Some((set, rest)) = split.and_then(|at| path.split_at_checked(at)) else { return ("", "") };
    (set, rest.split('}').next().unwrap_or_default())
}
