//! Sensors: faces that measure the light that arrives at them.

use glam::DVec3;

/// What is to be measured at a face.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Sensor {
    /// Columns and rows of the map; 1 or more.
    pub pixels: [u32; 2],
    /// Direction to the right in the map, in the part's axes, unit; none: along the longer side of the smallest rectangle
    /// about the face.
    pub u: Option<DVec3>,
}
