//! The pictures of a scene: slides on faces, and what panoramas need to become skies.

use super::build::{Builder, intern};
use super::image::Picture;
use super::measure::FaceMeasure;
use super::optics::SlideSpec;
use super::select::Candidate;
use super::{files, image, optics};
use eyebox_base::colour::{ColourSpace, luminance};
use eyebox_base::error::Result;
use eyebox_base::ids::SlideId;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{Note, Slide, Wavelengths};
use std::sync::Arc;

impl Builder<'_> {
    /// The slide of a face, a display's own picture among them: read, placed in the plane of the face.
    pub(super) fn slide(&mut self, part: &Candidate, number: usize, spec: &SlideSpec) -> Result<SlideId> {
        let file = files::resolve(&spec.image, &spec.image_at);
        // What red, green and blue count for.
        let weights = spec.primaries.filter(|own| own.iter().sum::<f64>() > 0.0);
        let weights = weights
            .map_or_else(|| ColourSpace::Rec709.luminance_weights(), |own| own.map(|c| c / own.iter().sum::<f64>()));
        let key = (file.clone(), spec.layer.clone(), weights.map(f64::to_bits));
        let (width, height, pixels, rgb) = match self.pictures.get(&key) {
            Some(known) => known.clone(),
            None => {
                let bytes = files::read(&file, &spec.image_at, "slide image")
                    .map_err(|fault| fault.code(Code::SlideImageMissing))?;
                let mut read = image::slide(&bytes, spec.layer.as_deref(), &file, &spec.image_at)
                    .map_err(|fault| fault.code(Code::SlideImageMissing))?;
                self.notes.extend(read.notes(&spec.image, &spec.image_at));
                if read.rgb.is_some() && !self.coloured() {
                    let [r, g, b] = weights;
                    let text = format!(
                        "the slide image {} has colours; at one wavelength their luminance counts: \
                         {r:.4} R + {g:.4} G + {b:.4} B",
                        spec.image
                    );
                    self.notes.push(Note::info(spec.image_at.clone(), text));
                }
                if let (Some(rgb), Some(_)) = (&read.rgb, spec.primaries) {
                    let light = |rgb: &[f32; 3]| (0..3).map(|c| weights[c] * f64::from(rgb[c])).sum::<f64>();
                    read.pixels = rgb.iter().map(|rgb| light(rgb).min(1.0) as f32).collect();
                }
                let rgb = read.rgb.filter(|_| self.coloured()).map(Arc::new);
                let known = (read.width, read.height, Arc::new(read.pixels), rgb);
                self.pictures.insert(key, known.clone());
                self.files.push(file);
                known
            }
        };
        let mesh = self.assembly.meshes.get(part.mesh).map(|source| &source.mesh);
        let at = |what: String| {
            Error::new(spec.at.clone(), format!("the slide's face {number} of part {} {what}", part.path))
        };
        let measure = mesh.and_then(|mesh| FaceMeasure::new(mesh, number).map(|measure| (mesh, measure)));
        let Some((mesh, measure)) = measure else { return Err(at("has no triangles".into())) };
        let normal = measure.normal().ok_or_else(|| at("has no side".into()).expected("a plane face"))?;
        if let Err(off) = measure.flat(mesh, number, normal) {
            return Err(
                at(format!("is not flat: {off:.3e} of {:.3e} mesh units", measure.extent())).expected("a plane face")
            );
        }
        for (name, direction) in [("u", spec.u), ("v", spec.v)] {
            if normal.dot(direction).abs() > optics::ORTHOGONAL {
                let [x, y, z] = direction.to_array();
                return Err(at(format!("doesn't contain `{name}` = [{x}, {y}, {z}]")).expected(format!(
                    "a direction along the face, whose normal is [{:.3}, {:.3}, {:.3}]",
                    normal.x, normal.y, normal.z
                )));
            }
        }
        let mut centre = measure.centre();
        if let Some(given) = spec.centre {
            let off = normal.dot(given - centre);
            if off.abs() > 1e-3 * measure.extent() {
                return Err(at(format!("doesn't contain `centre`: it is {off:.3e} mesh units off"))
                    .expected("a point of the face's plane"));
            }
            centre = given - off * normal;
        }
        // The picture's axes exactly in the face's plane and at a right angle.
        let u = (spec.u - spec.u.dot(normal) * normal).normalize();
        let v = spec.v - spec.v.dot(normal) * normal;
        let slide = Slide {
            name: part.path.clone(),
            file: spec.image.clone(),
            width,
            height,
            pixels,
            rgb,
            centre,
            u,
            v: (v - v.dot(u) * u).normalize(),
            size: spec.size,
            transmittance: spec.transmittance,
            contrast: spec.contrast,
            polarisation: spec.polarisation,
            primaries: spec.primaries.and_then(optics::white_of).filter(|_| self.coloured()),
        };
        Ok(SlideId::from_index(intern(&mut self.slides, slide)))
    }

    /// Whether colour is traced.
    pub(super) fn coloured(&self) -> bool {
        match self.wavelengths {
            Wavelengths::Mono { .. } => false,
            Wavelengths::Visible => true,
        }
    }

    /// Scales the pixels of a panorama by red, green and blue; returns the colours, if it has any and they are wanted.
    pub(super) fn scaled(&mut self, read: &mut Picture, scale: [f64; 3], at: &Where) -> Option<Vec<[f32; 3]>> {
        if read.clipped > 0 && self.coloured() {
            let text = format!(
                "{} pixels have colours outside Rec.709: their negative components are taken as 0, with the same luminance",
                read.clipped
            );
            self.notes.push(Note::warning(at.clone(), text));
        }
        let grey = scale[0] == scale[1] && scale[1] == scale[2];
        let mut rgb = read.rgb.take();
        if rgb.is_none() && !grey {
            rgb = Some(read.pixels.iter().map(|pixel| [*pixel; 3]).collect());
        }
        if grey {
            for pixel in &mut read.pixels {
                *pixel = (f64::from(*pixel) * scale[0]) as f32;
            }
        }
        for (i, colour) in rgb.iter_mut().flatten().enumerate() {
            let scaled: [f64; 3] = std::array::from_fn(|c| f64::from(colour[c]) * scale[c]);
            *colour = scaled.map(|c| c as f32);
            if let (false, Some(pixel)) = (grey, read.pixels.get_mut(i)) {
                *pixel = luminance(scaled) as f32;
            }
        }
        rgb.filter(|_| self.coloured())
    }
}

/// Whether all values are 0 or more and finite.
pub(super) fn finite(pixels: &[f32], rgb: Option<&[[f32; 3]]>) -> bool {
    let fine = |value: &f32| *value >= 0.0 && value.is_finite();
    pixels.iter().all(fine) && rgb.unwrap_or(&[]).iter().flatten().all(fine)
}
