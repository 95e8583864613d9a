//! Final gathering (H. W. Jensen, "Global illumination using photon maps", EGWR 1996): where the eye meets a face that asks
//! for it, paths go on, and what other broad scatterers send there is gathered at those.
//!
//! So each path from lamp to eye is gathered at one of its broad scatterers: at the first seen from the eye, or at the
//! second where the first asks for final gathering and there is a second. Photons tell: one that a broad scatterer has sent
//! would be met again by the paths that go on, any other would not.

use super::tuning::final_gather::COPIES;
use eyebox_base::path::Trail;

/// Whether a path from the eye goes on from a broad scatterer; `asks`: the face asks for final gathering.
pub fn goes_on(eye: Trail, asks: bool) -> bool {
    asks && !eye.has_broad()
}

/// Whether photons that came this way are gathered at a broad scatterer that paths go on from, or end at.
pub fn gathers(goes_on: bool, photon: Trail) -> bool {
    !(goes_on && photon.has_broad())
}

/// How many go on in place of a path that has this share of what it started with.
pub fn copies(share: f64) -> u32 {
    (COPIES * share).ceil().max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::path::Event;

    /// A vertex between eye and lamp: what happens there, and whether the face asks for final gathering.
    const VERTICES: [(Event, bool); 4] =
        [(Event::Specular, false), (Event::Glossy, false), (Event::Diffuse, false), (Event::Diffuse, true)];

    /// How often the photon estimator counts a path: walked from the eye as it walks, with what came from the lamp at each
    /// vertex as a photon.
    fn counted(path: &[(Event, bool)]) -> usize {
        let (mut eye, mut count) = (Trail::START, 0);
        for (index, &(event, asks)) in path.iter().enumerate() {
            if event == Event::Diffuse {
                let photon = path[index + 1..].iter().rev().fold(Trail::START, |trail, &(event, _)| trail.then(event));
                count += usize::from(gathers(goes_on(eye, asks), photon));
                if !goes_on(eye, asks) {
                    break;
                }
            }
            eye = eye.then(event);
        }
        count
    }

    #[test]
    fn every_path_with_a_broad_scatterer_is_gathered_once() {
        for length in 0..=9u32 {
            for code in 0..4usize.pow(length) {
                let path: Vec<_> = (0..length).map(|k| VERTICES[code / 4usize.pow(k) % 4]).collect();
                let broad = path.iter().any(|(event, _)| *event == Event::Diffuse);
                assert_eq!(counted(&path), usize::from(broad), "{path:?}");
            }
        }
    }
}
