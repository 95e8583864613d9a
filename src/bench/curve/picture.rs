//! The luminance of a picture with the variances of its pixels.

use super::cells::{Batches, Grid};
use eyebox_base::colour::ColourSpace;
use eyebox_base::{Error, Result, Where};
use eyebox_estimate::run::Films;
use eyebox_output::exr::read_exr;
use std::path::Path;

/// Luminance row by row, cd/m².
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub width: usize,
    /// Per pixel.
    pub values: Vec<f64>,
    /// Variance of each value.
    pub variances: Vec<f64>,
    pub height: usize,
    /// How the light of its cells came; without batches the pixels' variances tell what that is worth.
    pub batches: Batches,
}

impl Picture {
    /// What films of this size hold together; black if there are none.
    pub fn of_films(films: &Films, [width, height]: [usize; 2]) -> Picture {
        let (values, variances) = (vec![0.0; width * height], vec![0.0; width * height]);
        let mut picture = Picture { width, height, values, variances, batches: Batches::default() };
        for (_, film, _) in &films.films {
            let all = film.planes.len();
            for (pixel, (value, variance)) in picture.values.iter_mut().zip(&mut picture.variances).enumerate() {
                *value += (0..all).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
                *variance += film.variance(pixel, all);
            }
        }
        picture
    }

    /// The same of films that have just been added to, with the batches of what they held before.
    pub fn of_batches(films: &Films, size: [usize; 2], batches: &mut Batches) -> Picture {
        let picture = Picture::of_films(films, size);
        batches.add(films.passes, &picture.cells().sums(picture.values.iter().copied()));
        Picture { batches: batches.clone(), ..picture }
    }

    /// The cells of its pixels.
    pub fn cells(&self) -> Grid {
        Grid::new([self.width, self.height])
    }

    /// The default image of an EXR in linear Rec.709 (or grey), without variances.
    ///
    /// Errors: no EXR, another size, no default image, values that are no numbers.
    pub fn of_file(path: &Path, [width, height]: [usize; 2]) -> Result<Picture> {
        let frame = read_exr(path)?;
        let fault = |what: String| Error::new(Where::file(path), what);
        if (frame.width, frame.height) != (width, height) {
            return Err(fault(format!("is {} × {} pixels", frame.width, frame.height))
                .expected(format!("{width} × {height}, the size of the asset's picture; see --resolution")));
        }
        let Some([r, g, b]) = frame.rgb("") else {
            return Err(fault("has no default image".to_owned()).expected("channels R, G and B, or Y"));
        };
        let [wr, wg, wb] = ColourSpace::Rec709.luminance_weights();
        let values: Vec<f64> = r
            .iter()
            .zip(g)
            .zip(b)
            .map(|((r, g), b)| wr * f64::from(*r) + wg * f64::from(*g) + wb * f64::from(*b))
            .collect();
        match values.iter().position(|value| !value.is_finite()) {
            Some(pixel) => Err(fault(format!("pixel {} of row {} is no number", pixel % width, pixel / width))),
            None => {
                Ok(Picture { width, height, variances: vec![0.0; values.len()], values, batches: Batches::default() })
            }
        }
    }
}
