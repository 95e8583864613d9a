//! The parts of a scene that need pictures: slides on faces, and the sky.

use super::build::{Builder, intern};
use super::measure::FaceMeasure;
use super::select::Candidate;
use super::value::Value;
use super::{files, optics, picture, place};
use crate::base::Fault;
use crate::base::fault::Result;
use crate::base::ids::{GroupId, SlideId};
use crate::scene::{Group, Note, Severity, Sky, Slide};
use std::sync::Arc;

impl Builder<'_> {
    /// The slide of a face: its picture read, placed in the plane of the face. None for `"none"`.
    pub(super) fn slide(&mut self, part: &Candidate, number: usize, value: &Value) -> Result<Option<SlideId>> {
        if value.text() == Some("none") {
            return Ok(None);
        }
        let value = self.sheet.slides.follow(value)?;
        let spec = optics::slide(value, &mut self.notes)?;
        let file = files::resolve(&spec.image, &spec.image_at);
        let (width, height, pixels) = match self.pictures.get(&file) {
            Some(known) => known.clone(),
            None => {
                let bytes = files::read(&file, &spec.image_at, "slide image")?;
                let read = picture::slide(&bytes, &file, &spec.image_at)?;
                if read.had_colour {
                    let text = format!(
                        "the slide image {} has colours; this version renders luminance: 0.2126 R + 0.7152 G + 0.0722 B",
                        spec.image
                    );
                    self.notes.push(Note { severity: Severity::Info, at: spec.image_at.clone(), text });
                }
                let known = (read.width, read.height, Arc::new(read.pixels));
                self.pictures.insert(file.clone(), known.clone());
                self.files.push(file);
                known
            }
        };
        let mesh = self.assembly.meshes.get(part.mesh).map(|source| &source.mesh);
        let at = |what: String| {
            Fault::new(spec.at.clone(), format!("the slide's face {number} of part {} {what}", part.path))
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
            centre,
            u,
            v: (v - v.dot(u) * u).normalize(),
            size: spec.size,
            transmittance: spec.transmittance,
            contrast: spec.contrast,
            polarisation: spec.polarisation,
        };
        Ok(Some(SlideId::from_index(intern(&mut self.slides, slide))))
    }

    /// The panorama as luminance in cd/m², and its axes.
    pub(super) fn sky(&mut self, value: &Value) -> Result<Sky> {
        let spec = optics::sky(value, &mut self.notes)?;
        let file = files::resolve(&spec.image, &spec.image_at);
        let bytes = files::read(&file, &spec.image_at, "sky image")?;
        let mut read = picture::panorama(&bytes, &file, &spec.image_at)?;
        self.files.push(file);
        for pixel in &mut read.pixels {
            *pixel = (f64::from(*pixel) * spec.scale_cd_m2) as f32;
        }
        if read.pixels.iter().any(|pixel| !pixel.is_finite()) {
            return Err(Fault::new(value.at.clone(), "the sky's luminance overflows").expected("a smaller scale_cd_m2"));
        }
        if read.width != 2 * read.height {
            let text =
                format!("the panorama has {} x {} pixels; twice as wide as high is usual", read.width, read.height);
            self.notes.push(Note { severity: Severity::Warning, at: spec.image_at.clone(), text });
        }
        let group = GroupId::from_index(intern(&mut self.groups, Group { name: spec.group }));
        let frame = place::frame_rotation(self.assembly, spec.frame.as_ref())?;
        Ok(Sky {
            group,
            width: read.width,
            height: read.height,
            luminance: Arc::new(read.pixels),
            to_world: frame * glam::DMat3::from_rotation_y(spec.rotation_deg.to_radians()),
            file: spec.image,
        })
    }
}
