//! Chains: the sequence of specular faces between two ends of a light path, and what each did.

/// What a specular face did with a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Step {
    /// Refracted, or passed straight through (a slide, a sheet).
    Through,
    /// Reflected.
    Back,
}

/// One face of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct Link {
    pub part: u32,
    pub face: u32,
    pub step: Step,
    /// Of diffraction, in the axes of the grating: the same in both directions. 0 everywhere else.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub order: i32,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_zero(order: &i32) -> bool {
    *order == 0
}

/// The faces in the order in which a path met them.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Default, serde::Serialize, serde::Deserialize)]
pub struct Chain(pub Vec<Link>);

impl Chain {
    /// The same chain walked from the other end.
    #[must_use]
    pub fn reversed(&self) -> Chain {
        Chain(self.0.iter().rev().copied().collect())
    }

    /// How often it was reflected.
    pub fn reflections(&self) -> usize {
        self.0.iter().filter(|link| link.step == Step::Back).count()
    }
}
