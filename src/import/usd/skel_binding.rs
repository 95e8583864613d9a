//! Which prims say what UsdSkelBindingAPI hands down.

use super::attribute::PrimView;
use openusd::sdf;

/// The properties of UsdSkelBindingAPI that are inherited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bound {
    Skeleton,
    Animation,
    Joints,
    Indices,
    Weights,
    GeomBind,
    Method,
    BlendShapes,
    BlendShapeTargets,
}

const BOUND: [(Bound, &str); 9] = [
    (Bound::Skeleton, "skel:skeleton"),
    (Bound::Animation, "skel:animationSource"),
    (Bound::Joints, "skel:joints"),
    (Bound::Indices, "primvars:skel:jointIndices"),
    (Bound::Weights, "primvars:skel:jointWeights"),
    (Bound::GeomBind, "primvars:skel:geomBindTransform"),
    (Bound::Method, "primvars:skel:skinningMethod"),
    (Bound::BlendShapes, "skel:blendShapes"),
    (Bound::BlendShapeTargets, "skel:blendShapeTargets"),
];

/// What a prim hands down: which prim says each property. Two instances of a prototype share their meshes only if they hand
/// down the same.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Inherited {
    /// Whether a SkelRoot is above: without one nothing is bent.
    pub is_rooted: bool,
    pub by: [Option<sdf::Path>; BOUND.len()],
    /// The instance, where what is bound is outside of it.
    pub within: Option<sdf::Path>,
}

impl Inherited {
    /// With what `view` says itself: for the prim and those below it.
    pub fn below(&self, view: &PrimView, type_name: &str) -> Inherited {
        let mut out = self.clone();
        out.is_rooted |= type_name == "SkelRoot";
        if view.property_names().iter().any(|name| name.contains("skel:")) {
            for ((_, name), by) in BOUND.iter().zip(&mut out.by) {
                if view.has(name) {
                    *by = Some(view.path().clone());
                }
            }
        }
        out
    }

    /// For the prims inside of the instance `view`.
    pub fn inside(&mut self, view: &PrimView) {
        if self.by.iter().any(Option::is_some) {
            self.within = Some(view.path().clone());
        }
    }

    /// The prim that says a property.
    pub fn by(&self, bound: Bound) -> Option<&sdf::Path> {
        let place = BOUND.iter().position(|(known, _)| *known == bound)?;
        self.by.get(place)?.as_ref()
    }
}

pub(super) fn name_of(bound: Bound) -> &'static str {
    BOUND.iter().find(|(known, _)| *known == bound).map_or("", |(_, name)| name)
}
