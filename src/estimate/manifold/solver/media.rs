//! What the solver asks of the media that a train of faces leads through.

use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;

/// Indices, and the wavelength that gratings bend by.
pub trait Media {
    /// Refractive index of what fills a part's space, or of air.
    fn index(&self, part: Option<u32>) -> f64;
    /// In vacuum, nm. None: what a grating bends is not followed.
    fn nm(&self) -> Option<f64>;
    /// Whether flat faces go on beyond their rims, so that one knows where something would be seen.
    fn past_rims(&self) -> bool;
}

/// Paths of many wavelengths: each leaves a grating in another direction.
impl<F: Fn(Option<u32>) -> f64> Media for F {
    #[inline]
    fn index(&self, part: Option<u32>) -> f64 {
        self(part)
    }
    #[inline]
    fn nm(&self) -> Option<f64> {
        None
    }
    #[inline]
    fn past_rims(&self) -> bool {
        false
    }
}

/// Lines of sight at the wavelength of the first lane.
pub struct OneWavelength<'a, M: Mode>(pub &'a Optics<M>);

impl<M: Mode> Media for OneWavelength<'_, M> {
    fn index(&self, part: Option<u32>) -> f64 {
        self.0.index_in(part)[0]
    }
    fn nm(&self) -> Option<f64> {
        Some(self.0.nm(0))
    }
    fn past_rims(&self) -> bool {
        true
    }
}
