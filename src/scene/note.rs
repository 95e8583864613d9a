//! What an importer has to say: nothing is repaired, defaulted or ignored silently.

use crate::base::Where;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// For the record: a default that was used, a fit and its residual.
    Info,
    /// Probably not what the author meant, or repaired.
    Warning,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Note {
    pub severity: Severity,
    pub at: Where,
    pub text: String,
}
