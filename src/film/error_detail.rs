//! How much a run tells of its standard errors.

/// Whose standard errors a run keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorDetail {
    /// Of `hybrid` alone.
    #[default]
    Picture,
    /// Of every layer, of every group's share, and of its `open` and `content`.
    Layers,
}
