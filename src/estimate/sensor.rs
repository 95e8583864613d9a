//! Light that arrives at a sensor's face, on either side: traced from the lamps, whose paths a guide aims, or from the face
//! back to the sky and to what of the lamps is large enough to be found so.

mod arrivals;
mod backward;
mod tuning;

pub use arrivals::Forward;
pub use backward::Backward;

use eyebox_base::ids::GroupId;
use eyebox_film::accumulate::Light;
use eyebox_film::plan::Spectral;
use eyebox_world::mode::{LaneArray, Mode, components};
use eyebox_world::optics::Optics;
use eyebox_world::sensor::Side;
use tuning::sensor::{FEWEST, PER_PIXEL};

/// Flux that one path brought to a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Caught {
    pub pixel: u32,
    pub side: Side,
    pub group: GroupId,
    pub lumens: f64,
    /// From 360 to 830 nm; 0 where nothing tells it.
    pub watts: f64,
}

/// Paths in a pass for a map of so many pixels.
pub fn paths_of_pass(pixels: [usize; 2]) -> u64 {
    ((pixels[0] * pixels[1]) as u64).saturating_mul(PER_PIXEL).max(FEWEST)
}

/// Light per lane, or of the first alone, in lumens and in watts; `watts_per_lumen`: where wavelengths are not traced.
fn measured<M: Mode>(optics: &Optics<M>, (light, alone): (M::Lanes<Light>, bool), watts_per_lumen: f64) -> (f64, f64) {
    let mut out = [Light::default(); 3];
    M::deposit(optics, &mut out[..M::COMPONENTS], light, alone);
    let lumens = components::<M>().luminance_value(&out[..M::COMPONENTS]);
    let watts = match M::SPECTRAL {
        Spectral::Mono | Spectral::Rgb => lumens * watts_per_lumen,
        // A lane's light is its power over the density of its wavelength (`world::mode`).
        Spectral::Hero => {
            let count = if alone { 1 } else { M::LANES };
            light.as_slice().iter().take(count).map(|light| light.value).sum::<f64>() / count as f64
        }
    };
    (lumens, watts)
}
