//! Which material is bound to a prim: direct and collection bindings, of the prim itself and inherited, by the rules of
//! UsdShadeMaterialBindingAPI (checked against usd-core 26.11).

use super::attribute::{PrimView, one_line};
use super::material;
use super::reader::Reader;
use eyebox_base::error::Result;
use openusd::sdf::{self, Value};
use openusd::usd::{CollectionAPI, MembershipQuery};
use std::collections::HashMap;

const BINDING: &str = "material:binding";
const COLLECTION: &str = "material:binding:collection:";
/// The purposes that count for a picture, the stronger one first: `full`, and the one that all purposes fall back to.
const PURPOSES: [&str; 2] = ["full", ""];
/// More than this many bindings of collections are no asset; each is asked for each prim below it.
const MOST_COLLECTIONS: usize = 4096;
/// Collections that include collections.
const MOST_NESTED: usize = 64;

/// The collections that bindings name, by their path; none for one that does not exist.
#[derive(Debug, Default)]
pub(super) struct Collections {
    by_path: HashMap<String, Option<usize>>,
    queries: Vec<MembershipQuery>,
    bindings: usize,
}

/// The material is an index of `Assembly::materials` before they are sorted; none if the binding leads nowhere, which
/// hides what is inherited all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Binding {
    material: Option<usize>,
    /// `strongerThanDescendants`.
    stronger: bool,
}

/// What one prim binds for one purpose.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
struct Level {
    direct: Option<Binding>,
    /// Indices of [`Collections::queries`].
    collections: Vec<(usize, Binding)>,
}

/// What a prim hands down to the prims below it: bindings. Two instances of a prototype share their meshes only if they
/// hand down the same.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Inherited {
    /// By purpose; the topmost prim first.
    levels: [Vec<Level>; 2],
    /// The instance, where collections tell instances apart.
    within: Option<String>,
}

impl Inherited {
    /// With what `view` binds itself: for the prim and those below it.
    ///
    /// # Errors
    /// Too many collections.
    pub fn below(&self, reader: &mut Reader, view: &PrimView) -> Result<Inherited> {
        let mut own: Vec<&str> =
            view.property_names().iter().map(String::as_str).filter(|name| name.starts_with(BINDING)).collect();
        let mut out = self.clone();
        if own.is_empty() {
            return Ok(out);
        }
        // USD's native order, but for numbers inside of names.
        own.sort_unstable();
        for (levels, purpose) in out.levels.iter_mut().zip(PURPOSES) {
            let level = level(reader, view, &own, purpose)?;
            let plain = level.collections.is_empty();
            match (levels.last_mut(), &level.direct) {
                (_, None) if plain => {}
                // Without collections the nearest wins, or the topmost that is stronger.
                (Some(Level { direct: Some(above), collections }), Some(new)) if plain && collections.is_empty() => {
                    if !above.stronger {
                        *above = *new;
                    }
                }
                (Some(_) | None, _) => levels.push(level),
            }
        }
        Ok(out)
    }

    /// For the prims inside of the instance `view`.
    pub fn inside(&mut self, view: &PrimView) {
        if self.levels.iter().flatten().any(|level| !level.collections.is_empty()) {
            self.within = Some(view.path().as_str().to_owned());
        }
    }

    fn has_collections(&self) -> bool {
        self.levels.iter().flatten().any(|level| !level.collections.is_empty())
    }

    /// The material of the prim at `path`, which has `self` from itself and above.
    fn resolve(&self, known: &Collections, path: &sdf::Path) -> Option<usize> {
        self.levels.iter().find_map(|levels| strongest(levels, known, path))
    }
}

/// The binding that wins for one purpose, if it leads to a material.
fn strongest(levels: &[Level], known: &Collections, path: &sdf::Path) -> Option<usize> {
    let mut winner: Option<Binding> = None;
    for level in levels.iter().rev() {
        let mut own = false;
        if let Some(direct) = level.direct
            && (winner.is_none() || direct.stronger)
        {
            (winner, own) = (Some(direct), true);
        }
        let includes = |query: usize| known.queries.get(query).is_some_and(|query| query.is_path_included(path));
        // A collection goes before the direct binding of the same prim, the first before the others.
        let matching = level
            .collections
            .iter()
            .find(|(query, binding)| (winner.is_none() || own || binding.stronger) && includes(*query));
        if let Some((_, binding)) = matching {
            winner = Some(*binding);
        }
    }
    winner.and_then(|binding| binding.material)
}

/// What `view` binds for a purpose; `own` are its properties that bind anything.
fn level(reader: &mut Reader, view: &PrimView, own: &[&str], purpose: &str) -> Result<Level> {
    let mut level = Level::default();
    for &name in own {
        let Some(rest) = name.strip_prefix(COLLECTION) else {
            let bound = match name.strip_prefix(BINDING) {
                Some("") => "",
                Some(rest) => match rest.strip_prefix(':') {
                    Some(rest) => rest,
                    None => continue,
                },
                None => continue,
            };
            if bound == purpose {
                level.direct = direct(reader, view, name)?;
            } else if !PURPOSES.contains(&bound) && purpose.is_empty() {
                reader.ledger.info(view.at_property(name), format!("the material purpose `{bound}` is not used"));
            }
            continue;
        };
        // `NAME`, or `PURPOSE:NAME`.
        let of = match rest.split_once(':') {
            Some((of, name)) if !name.contains(':') => of,
            Some(_) | None => "",
        };
        if of == purpose {
            level.collections.extend(collection(reader, view, name)?);
        }
    }
    Ok(level)
}

/// A binding of one prim. Another number of targets binds nothing, as in USD.
fn direct(reader: &mut Reader, view: &PrimView, name: &str) -> Result<Option<Binding>> {
    let targets = view.targets(name)?;
    let [target] = targets.as_slice() else {
        if !targets.is_empty() {
            let text = format!("a binding of {} materials at once: not used", targets.len());
            reader.ledger.warn(view.at_property(name), text);
        }
        return Ok(None);
    };
    let material = material::at(reader, target)?;
    if material.is_none() {
        let text = format!("the binding leads to <{}>, which is no material", target.as_str());
        reader.ledger.warn(view.at_property(name), text);
    }
    Ok(Some(Binding { material, stronger: stronger(view, name)? }))
}

fn stronger(view: &PrimView, name: &str) -> Result<bool> {
    let found = view.prim.relationship(name).get_metadata::<Value>("bindMaterialAs");
    let found = found.map_err(|error| view.fault_in(name, one_line(&format!("cannot be read: {error}"))))?;
    Ok(found.as_ref().and_then(super::value::text) == Some("strongerThanDescendants"))
}

/// A binding of all prims of a collection.
fn collection(reader: &mut Reader, view: &PrimView, name: &str) -> Result<Option<(usize, Binding)>> {
    let targets = view.targets(name)?;
    let [collection, target] = targets.as_slice() else {
        let text = format!("a binding of a collection with {} targets: not used", targets.len());
        reader.ledger.warn(view.at_property(name), text);
        return Ok(None);
    };
    reader.materials.collections.bindings += 1;
    if reader.materials.collections.bindings > MOST_COLLECTIONS {
        let fault = view.fault_in(name, "too many bindings of collections");
        return Err(fault.expected(format!("at most {MOST_COLLECTIONS}")));
    }
    let query = match reader.materials.collections.by_path.get(collection.as_str()) {
        Some(known) => *known,
        None => {
            let query = query(reader, view, name, collection)?;
            let known = &mut reader.materials.collections;
            let index = query.map(|query| {
                known.queries.push(query);
                known.queries.len() - 1
            });
            known.by_path.insert(collection.as_str().to_owned(), index);
            index
        }
    };
    let Some(query) = query else {
        let text = format!("the binding is for <{}>, which is no collection", collection.as_str());
        reader.ledger.warn(view.at_property(name), text);
        return Ok(None);
    };
    let material = material::at(reader, target)?;
    Ok(Some((query, Binding { material, stronger: stronger(view, name)? })))
}

/// What a collection includes; `None` if there is no such collection.
fn query(reader: &mut Reader, view: &PrimView, name: &str, path: &sdf::Path) -> Result<Option<MembershipQuery>> {
    let failed = |error: openusd::Error| view.fault_in(name, one_line(&format!("cannot be read: {error}")));
    let mut find = |path: &sdf::Path| -> Result<Option<CollectionAPI>> {
        let Some((prim, property)) = path.split_property() else { return Ok(None) };
        let Some(own) = property.strip_prefix("collection:") else { return Ok(None) };
        let prim = reader.prim(&prim)?;
        let schemas = prim.api_schemas().map_err(failed)?;
        let applied = schemas.iter().any(|schema| schema.strip_prefix("CollectionAPI:") == Some(own));
        Ok(applied.then(|| CollectionAPI::from_prim_unchecked(prim, own)))
    };
    let Some(top) = find(path)? else { return Ok(None) };
    // The library follows collections inside of collections by recursion.
    let mut open = vec![path.clone()];
    let mut seen = std::collections::HashSet::new();
    for depth in 0.. {
        if depth > MOST_NESTED {
            let fault = view.fault_in(name, "collections that include collections too deep");
            return Err(fault.expected(format!("at most {MOST_NESTED} levels")));
        }
        let mut next = Vec::new();
        for path in open {
            let Some(collection) = find(&path)? else { continue };
            let included = collection.includes().map_err(failed)?;
            let inner = included.into_iter().filter(|path| path.split_property().is_some());
            next.extend(inner.filter(|path| seen.insert(path.as_str().to_owned())));
        }
        if next.is_empty() {
            break;
        }
        open = next;
    }
    top.compute_membership_query().map(Some).map_err(failed)
}

/// The material of a prim: an index of `Assembly::materials`. `inherited` has the prim's own bindings, too.
pub(super) fn bound(reader: &Reader, view: &PrimView, inherited: &Inherited) -> Option<usize> {
    inherited.resolve(&reader.materials.collections, view.path())
}

/// The material of a GeomSubset of a mesh that has `inherited`; none leaves its faces the mesh's.
///
/// # Errors
/// As [`Inherited::below`].
pub(super) fn bound_to_subset(
    reader: &mut Reader,
    mesh: &PrimView,
    subset: &PrimView,
    inherited: &Inherited,
) -> Result<Option<usize>> {
    let own = inherited.below(reader, subset)?;
    let found = bound(reader, subset, &own);
    let says = subset.property_names().iter().any(|name| name.starts_with(BINDING));
    Ok(found.filter(|_| says || own.has_collections() && found != bound(reader, mesh, inherited)))
}
