//! The sky: a picture that is read, or a model's that is made, and put into the scene's axes.

use super::build::{Builder, intern};
use super::daylight::{self, DISC_DEG};
use super::image::Picture;
use super::optics::{self, SkyKind, SkySpec, Up};
use super::scene_images::finite;
use super::value::Value;
use super::{files, frames, image};
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;
use eyebox_base::ids::GroupId;
use eyebox_base::{Error, Where};
use eyebox_scene::{Beacon, BeaconForm, Group, Note, Sky};
use glam::{DMat3, DVec3};
use std::sync::Arc;

impl Builder<'_> {
    /// The sky and, of a clear one, its sun.
    pub(super) fn sky(&mut self, value: &Value) -> Result<(Sky, Option<Beacon>)> {
        let spec = optics::sky(value, &mut self.notes)?;
        let axes = self.sky_axes(&spec)?;
        Ok(match spec.kind {
            SkyKind::Image { image, at, layer, scale_cd_m2, rotation_deg } => {
                let read = self.panorama(&image, &at, layer.as_deref())?;
                let turned = axes * DMat3::from_rotation_y(rotation_deg.to_radians());
                let white = scale_cd_m2.or(read.white_cd_m2).unwrap_or_else(|| {
                    let text = "`scale_cd_m2` of sky is not said: 1";
                    self.notes.push(Note::info(spec.at.clone(), text));
                    1.0
                });
                if let (None, Some(own)) = (scale_cd_m2, read.white_cd_m2) {
                    let text = format!("the picture {image} says that 1 is {own} cd/m² (`whiteLuminance`)");
                    self.notes.push(Note::info(at.clone(), text));
                }
                let scale = ([white; 3], "a smaller scale_cd_m2");
                (self.sky_of(read, scale, (spec.group, image), turned, &spec.at, &at)?, None)
            }
            SkyKind::Uniform { luminance_cd_m2, rgb } => {
                let hue = rgb.unwrap_or([1.0; 3]);
                // Scaled first, so that neither overflow nor underflow changes the colour.
                let largest = hue.iter().fold(0.0, |a: f64, b| a.max(*b));
                let hue = hue.map(|c| c / largest);
                let scale = hue.map(|c| c * (luminance_cd_m2 / luminance(hue)));
                let scale = (scale, "a smaller luminance_cd_m2");
                let one = Picture::grey(1, 1, vec![1.0]);
                (self.sky_of(one, scale, (spec.group, "uniform".to_owned()), axes, &spec.at, &spec.at)?, None)
            }
            SkyKind::Overcast { level_cd_m2, ground_reflectance } => {
                let picture = daylight::overcast(level_cd_m2, ground_reflectance);
                let scale = ([1.0; 3], "a smaller overcast_cd_m2");
                (self.sky_of(picture, scale, (spec.group, "overcast".to_owned()), axes, &spec.at, &spec.at)?, None)
            }
            SkyKind::Clear { elevation_deg, azimuth_deg, turbidity, sun_group, ground_reflectance } => {
                let elevation = elevation_deg.to_radians();
                let day = daylight::clear(turbidity, elevation, ground_reflectance);
                let lx = day.sunlight.illuminance_lx();
                let text = format!(
                    "clear sky: a horizontal plane gets {:.0} lx from the sky and {:.0} lx from the sun, which brings {lx:.0} lx \
                     across its light",
                    day.sky_lx,
                    lx * elevation.sin()
                );
                self.notes.push(Note::info(spec.at.clone(), text));
                let turned = axes * DMat3::from_rotation_y(azimuth_deg.to_radians());
                let named = (spec.group, "sun_sky".to_owned());
                let sky = self.sky_of(day.picture, ([1.0; 3], "a sky"), named, turned, &spec.at, &spec.at)?;
                let form = BeaconForm::Distant {
                    dir: -(turned * DVec3::new(0.0, elevation.sin(), elevation.cos())),
                    illuminance_lx: lx,
                    angle_rad: DISC_DEG.to_radians(),
                };
                let group = GroupId::from_index(intern(&mut self.groups, Group { name: sun_group }));
                let spectrum = self.coloured().then_some(day.sunlight.spectrum);
                (sky, Some(Beacon { name: "sun".to_owned(), group, form, spectrum }))
            }
        })
    }

    /// Of an asset that says nothing of light: neutral, and brighter above. A sidecar says the same with `overcast_cd_m2`.
    pub(super) fn assumed_sky(&mut self, level_cd_m2: f64) -> Sky {
        let text = format!(
            "there is no light: an overcast sky of {level_cd_m2} cd/m², which lights a horizontal plane as a uniform one would"
        );
        self.notes.push(Note::assumed(Where::file(&self.assembly.file), text));
        let picture = daylight::overcast(level_cd_m2, 0.2);
        Sky {
            group: GroupId::from_index(intern(&mut self.groups, Group { name: "sky".to_owned() })),
            width: picture.width,
            height: picture.height,
            luminance: Arc::new(picture.pixels),
            rgb: None,
            to_world: DMat3::IDENTITY,
            file: "overcast".to_owned(),
        }
    }

    /// Axes of a sky about +y → world.
    fn sky_axes(&self, spec: &SkySpec) -> Result<DMat3> {
        let frame = frames::frame_rotation(self.assembly, spec.frame.as_ref())?;
        let picture = match spec.kind {
            SkyKind::Image { .. } => true,
            SkyKind::Uniform { .. } | SkyKind::Overcast { .. } | SkyKind::Clear { .. } => false,
        };
        let asset = if (self.assembly.axes * DVec3::Z).y > 0.5 { Up::Z } else { Up::Y };
        Ok(match spec.up.unwrap_or(if picture { Up::Y } else { asset }) {
            Up::Y => frame,
            // 90° about x: y becomes z, and z −y.
            Up::Z => frame * DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
        })
    }

    fn panorama(&mut self, name: &str, at: &Where, layer: Option<&str>) -> Result<Picture> {
        let file = files::resolve(name, at);
        let bytes = files::read(&file, at, "sky image")?;
        let mut read = image::panorama(&bytes, layer, &file, at)?;
        self.notes.extend(read.notes(name, at));
        self.files.push(file);
        if read.width != 2 * read.height {
            let text =
                format!("the panorama has {} x {} pixels; twice as wide as high is usual", read.width, read.height);
            self.notes.push(Note::warning(at.clone(), text));
        }
        Ok(read)
    }

    /// The picture as luminance in cd/m². `scale`: of its red, green and blue, and what would be in the range.
    fn sky_of(
        &mut self,
        mut picture: Picture,
        (scale, expected): ([f64; 3], &str),
        (group, file): (String, String),
        to_world: DMat3,
        at: &Where,
        picture_at: &Where,
    ) -> Result<Sky> {
        let rgb = self.scaled(&mut picture, scale, picture_at);
        if !finite(&picture.pixels, rgb.as_deref()) {
            return Err(Error::new(at.clone(), "the sky's luminance overflows").expected(expected));
        }
        Ok(Sky {
            group: GroupId::from_index(intern(&mut self.groups, Group { name: group })),
            width: picture.width,
            height: picture.height,
            luminance: Arc::new(picture.pixels),
            rgb: rgb.map(Arc::new),
            to_world,
            file,
        })
    }
}
