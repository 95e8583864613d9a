//! Lights that the asset has as such: points, spots and distant lamps become lamps without faces, the others parts
//! that emit, a dome the sky.

use super::build::{Builder, intern};
use super::image::Picture;
use super::optics::{self, group_name};
use super::scene_images::finite;
use super::value::Value;
use super::{files, frames, image, photometric};
use eyebox_base::error::Result;
use eyebox_base::ids::{GroupId, MeshId};
use eyebox_base::{Error, Where};
use eyebox_scene::assembly::{LightForm, LightProfile, LightSource, ProfileSource};
use eyebox_scene::light_shapes::{cylinder, disk, rect, sphere};
use eyebox_scene::{
    Angular, Beacon, BeaconForm, Emitter, Face, Finish, Group, LuminousProfile, Mesh, Note, Part, Photometry, Shape,
    Sky, Spectrum, SpotCone,
};
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

/// What lights become.
#[derive(Default)]
pub(super) struct Made {
    pub lights: Vec<Beacon>,
    pub meshes: Vec<Mesh>,
    /// Their meshes are numbered from the end of the asset's.
    pub parts: Vec<Part>,
    pub dome: Option<Sky>,
}

impl Builder<'_> {
    /// Makes the asset's lights. `sky`: the light group of the sky that something else says, whose dome has no say; `eye`: where it
    /// is, world, m.
    pub(super) fn lights(&mut self, sky: Option<GroupId>, eye: DVec3) -> Result<Made> {
        let mut made = Made::default();
        let assembly = self.assembly;
        for light in &assembly.lights {
            let to_asset = assembly.nodes.get(light.node).map_or(DAffine3::IDENTITY, |node| node.to_world);
            let to_world = frames::in_metres(&to_asset, self.unit_m, &assembly.axes);
            let axis = || {
                (to_world.matrix3 * DVec3::NEG_Z).try_normalize().ok_or_else(|| {
                    Error::new(light.at.clone(), format!("light {} has no direction", light.name))
                        .expected("a node that is not scaled to nothing")
                })
            };
            let about_eye = || light.form.holds(to_world.inverse().transform_point3(eye));
            // A body whose outside shines has a flux of π · luminance · area, over 4π sr.
            let point = |luminance_cd_m2: f64, body: &Mesh| BeaconForm::Point {
                position: to_world.translation,
                intensity_cd: luminance_cd_m2 * area(body, &to_world) / 4.0,
                spot: None,
            };
            let form = match light.form {
                LightForm::Point { intensity_cd, cone } if light.profile.is_some() => {
                    if cone.is_some() {
                        self.warn(light, "its cone is not used beside a measured distribution");
                    }
                    self.web(light, 4.0 * PI * intensity_cd, &to_asset)?
                }
                LightForm::Point { intensity_cd, cone } => {
                    let spot = match cone {
                        Some((inner_rad, outer_rad)) => Some(SpotCone { axis: axis()?, inner_rad, outer_rad }),
                        None => None,
                    };
                    BeaconForm::Point { position: to_world.translation, intensity_cd, spot }
                }
                LightForm::Distant { illuminance_lx, angle } => {
                    if light.profile.is_some() {
                        self.warn(light, "a distant light has no intensity: its measured distribution is not used");
                    }
                    BeaconForm::Distant { dir: axis()?, illuminance_lx, angle_rad: angle }
                }
                LightForm::Dome { scale_cd_m2, ref image } => {
                    if sky.is_some() || made.dome.is_some() {
                        self.warn(light, "there is a sky already: this dome is left out");
                    } else {
                        made.dome = Some(self.dome(light, scale_cd_m2, image.as_deref(), &to_asset)?);
                    }
                    continue;
                }
                LightForm::Rect { luminance_cd_m2, width, height } => {
                    self.shine(light, luminance_cd_m2, rect(width, height), to_world, sky, &mut made)?;
                    continue;
                }
                LightForm::Disk { luminance_cd_m2, radius } => {
                    self.shine(light, luminance_cd_m2, disk(radius), to_world, sky, &mut made)?;
                    continue;
                }
                LightForm::Sphere { luminance_cd_m2, radius } if light.profile.is_some() => {
                    self.warn(light, "a sphere with a measured distribution becomes a point");
                    self.web(light, PI * luminance_cd_m2 * area(&sphere(radius), &to_world), &to_asset)?
                }
                LightForm::Cylinder { luminance_cd_m2, radius, length } if light.profile.is_some() => {
                    self.warn(light, "a cylinder with a measured distribution becomes a point");
                    self.web(light, PI * luminance_cd_m2 * area(&cylinder(radius, length), &to_world), &to_asset)?
                }
                LightForm::Sphere { luminance_cd_m2, radius } if about_eye() => {
                    self.warn(light, "the eye stands inside of the sphere, which becomes a point");
                    point(luminance_cd_m2, &sphere(radius))
                }
                LightForm::Cylinder { luminance_cd_m2, radius, length } if about_eye() => {
                    self.warn(light, "the eye stands inside of the cylinder, which becomes a point");
                    point(luminance_cd_m2, &cylinder(radius, length))
                }
                LightForm::Sphere { luminance_cd_m2, radius } => {
                    self.shine(light, luminance_cd_m2, sphere(radius), to_world, sky, &mut made)?;
                    continue;
                }
                LightForm::Cylinder { luminance_cd_m2, radius, length } => {
                    self.shine(light, luminance_cd_m2, cylinder(radius, length), to_world, sky, &mut made)?;
                    continue;
                }
            };
            let group = self.light_group(light, sky)?;
            let spectrum = self.light_spectrum(light)?;
            made.lights.push(Beacon { name: light.name.clone(), group, form, spectrum });
        }
        Ok(made)
    }

    fn warn(&mut self, light: &LightSource, text: &str) {
        let text = format!("light {}: {text}", light.name);
        self.notes.push(Note::warning(light.at.clone(), text));
    }

    /// The light's own attributes say the group, or its name does.
    fn light_group(&mut self, light: &LightSource, sky: Option<GroupId>) -> Result<GroupId> {
        let given = light
            .attributes
            .as_ref()
            .and_then(|own| own.get("group").or_else(|| own.get("emitter").and_then(|emitter| emitter.get("group"))));
        let name = match given {
            Some(value) => {
                let text = value.text().ok_or_else(|| {
                    Error::new(value.at.clone(), format!("`group` is {}", value.kind())).expected("a name")
                })?;
                group_name(text, &value.at)?
            }
            None => {
                let mut name = layer_name(&light.name);
                if sky.and_then(|sky| self.groups.get(sky.index())).is_some_and(|sky| sky.name == name) {
                    name.push_str("_light");
                }
                name
            }
        };
        Ok(GroupId::from_index(intern(&mut self.groups, Group { name })))
    }

    /// The light's own attributes say its spectrum, or its temperature or colour does; white is none.
    fn light_spectrum(&mut self, light: &LightSource) -> Result<Option<Spectrum>> {
        let emitter = |own: &'_ Value| own.get("emitter").and_then(|emitter| emitter.get("spectrum")).cloned();
        let given = light.attributes.as_ref().and_then(|own| own.get("spectrum").cloned().or_else(|| emitter(own)));
        let spectrum = match (given, light.kelvin) {
            (Some(value), _) => {
                let spec = optics::spectrum(&value)?;
                return self.spectrum(spec).map(Some);
            }
            (None, Some(kelvin)) => Spectrum::Cct(kelvin),
            (None, None) if light.color[0] == light.color[1] && light.color[1] == light.color[2] => return Ok(None),
            (None, None) => Spectrum::Rgb(light.color),
        };
        if let Some(problem) = spectrum.problem() {
            self.warn(light, &format!("its colour is not used: {problem}"));
            return Ok(None);
        }
        Ok(Some(spectrum))
    }

    fn shine(
        &mut self,
        light: &LightSource,
        luminance: f64,
        mesh: Mesh,
        to_world: DAffine3,
        sky: Option<GroupId>,
        made: &mut Made,
    ) -> Result<()> {
        let group = self.light_group(light, sky)?;
        let (photometry, angular) = match &light.profile {
            None => (Photometry::LuminanceCdM2(luminance), Angular::Lambert),
            Some(own) => {
                let profile = self.light_profile(light, own)?;
                self.behind(&profile, &light.at)?;
                let flux = own.normalize.then(|| PI * luminance * area(&mesh, &to_world));
                let photometry = flux.map_or(Photometry::AsMeasured, Photometry::FluxLm);
                (photometry, Angular::Profile { profile: self.profile(profile), c0: DVec3::X })
            }
        };
        let emitter = Emitter {
            group,
            photometry,
            angular,
            spectrum: self.light_spectrum(light)?,
            polarisation: None,
            both_sides: false,
            pattern: None,
        };
        let face = Face {
            finish: Finish::Absorber,
            coating: None,
            shape: Shape::Mesh,
            emitter: Some(emitter),
            tint: None,
            slide: None,
            sensor: None,
        };
        let node = self.assembly.nodes.get(light.node).map_or("", |node| node.path.as_str());
        made.parts.push(Part {
            name: light.name.clone(),
            path: if node.ends_with(light.name.as_str()) { node.to_owned() } else { format!("{node}/{}", light.name) },
            mesh: MeshId::from_index(self.assembly.meshes.len() + made.meshes.len()),
            to_world,
            medium: None,
            priority: 0,
            materials: Vec::new(),
            film_in: None,
            faces: vec![face],
        });
        made.meshes.push(Mesh { name: light.name.clone(), ..mesh });
        Ok(())
    }

    /// The profile of a light, scaled as the light says.
    fn light_profile(&mut self, light: &LightSource, own: &LightProfile) -> Result<LuminousProfile> {
        let measured = match &own.source {
            ProfileSource::File(file) => self.measured(file, &light.at)?,
            ProfileSource::Embedded(bytes) => {
                let name = Path::new("the light profile in the asset");
                let alone = |_: &Path, at: &Where| Err(Error::new(at.clone(), "an embedded profile names a file"));
                photometric::parse(name, bytes, &alone, &mut self.notes)?
            }
        };
        let scaled = measured.angle_scaled(own.angle_scale).ok_or_else(|| {
            let what = format!(
                "light {}: nothing of its profile is left at an angle scale of {}",
                light.name, own.angle_scale
            );
            Error::new(light.at.clone(), what).expected("a scale that keeps some light")
        })?;
        if own.normalize {
            return Ok(scaled);
        }
        if own.factor == 0.0 {
            return Err(Error::new(light.at.clone(), format!("light {} has a profile and no light", light.name))
                .expected("an intensity above 0"));
        }
        let scaled = scaled.times(own.factor);
        let flux = scaled.flux_lm();
        if flux > 0.0 && flux.is_finite() {
            Ok(scaled)
        } else {
            Err(Error::new(light.at.clone(), format!("light {} with its profile has {flux} lm", light.name))
                .expected("a finite flux"))
        }
    }

    /// A point with a profile; `flux_lm`: of the light without it, which stays where the profile only shapes.
    fn web(&mut self, light: &LightSource, flux_lm: f64, to_asset: &DAffine3) -> Result<BeaconForm> {
        let Some(own) = &light.profile else {
            return Err(Error::new(light.at.clone(), "a light without a profile"));
        };
        let profile = self.light_profile(light, own)?;
        let factor = if own.normalize { flux_lm / profile.flux_lm() } else { 1.0 };
        let position = frames::in_metres(to_asset, self.unit_m, &self.assembly.axes).translation;
        let axes = self.assembly.axes * rotation(&to_asset.matrix3, &light.at)?;
        Ok(BeaconForm::Profile { position, axes, profile: self.profile(profile), factor })
    }

    /// A uniform sky, or a panorama in the axes of the dome's node.
    fn dome(&mut self, light: &LightSource, scale: f64, image: Option<&Path>, to_asset: &DAffine3) -> Result<Sky> {
        let group = self.light_group(light, None)?;
        let (mut read, file) = match image.map(|file| (files::read(file, &light.at, "dome image"), file)) {
            None => (evenly_lit(), "uniform".to_owned()),
            Some((Ok(bytes), file)) => {
                let mut read = image::panorama(&bytes, None, file, &light.at)?;
                self.notes.extend(read.notes(&file.display().to_string(), &light.at));
                if let Some(white) = read.white_cd_m2.filter(|white| *white != 1.0) {
                    let text = format!(
                        "the picture of dome {} says that 1 is {white} cd/m² (`whiteLuminance`), which does not count: USD has \
                         its values times the intensity as cd/m²",
                        light.name
                    );
                    self.notes.push(Note::warning(light.at.clone(), text));
                }
                self.files.push(file.to_owned());
                (read, file.display().to_string())
            }
            // Without its picture an asset can still be looked at, as without those of its materials.
            Some((Err(fault), _)) => {
                let text = format!("{}; the dome {} lights evenly, in its own colour", fault.what, light.name);
                self.notes.push(Note::warning(fault.at.clone(), text));
                (evenly_lit(), "uniform".to_owned())
            }
        };
        // The strength has the luminance of the light's colour in it.
        let [r, g, b] = light.color;
        let scale = if r == g && g == b { [scale; 3] } else { light.color.map(|lane| scale * lane) };
        let rgb = self.scaled(&mut read, scale, &light.at);
        if !finite(&read.pixels, rgb.as_deref()) {
            let what = format!("the luminance of dome {} is negative or overflows", light.name);
            return Err(Error::new(light.at.clone(), what).expected("0 or more, and finite"));
        }
        let (luminance, rgb) = (Arc::new(read.pixels), rgb.map(Arc::new));
        let to_world = self.assembly.axes * rotation(&to_asset.matrix3, &light.at)?;
        Ok(Sky { group, width: read.width, height: read.height, luminance, rgb, to_world, file })
    }
}

/// A panorama of one pixel.
fn evenly_lit() -> Picture {
    Picture::grey(1, 1, vec![1.0])
}

/// The rotation in a node's axes; scale is taken off.
fn rotation(axes: &DMat3, at: &Where) -> Result<DMat3> {
    let bad = || Error::new(at.clone(), "the light's axes are not a rotation").expected("a node that is not mirrored");
    let x = axes.x_axis.try_normalize().ok_or_else(bad)?;
    let y = (axes.y_axis - x * axes.y_axis.dot(x)).try_normalize().ok_or_else(bad)?;
    let turned = DMat3::from_cols(x, y, x.cross(y));
    if turned.z_axis.dot(axes.z_axis) > 0.0 { Ok(turned) } else { Err(bad()) }
}

/// World area of a mesh, m².
fn area(mesh: &Mesh, to_world: &DAffine3) -> f64 {
    let corner = |index: u32| {
        let at = mesh.positions.get(index as usize).copied().unwrap_or_default();
        to_world.transform_point3(DVec3::from_array(at.map(f64::from)))
    };
    let one = |[a, b, c]: &[u32; 3]| (corner(*b) - corner(*a)).cross(corner(*c) - corner(*a)).length() / 2.0;
    mesh.triangles.iter().map(one).sum()
}

/// A name that layers can carry.
fn layer_name(name: &str) -> String {
    let clean: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if clean.starts_with(|c: char| c.is_ascii_alphabetic()) { clean } else { format!("light_{clean}") }
}
