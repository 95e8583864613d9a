//! Floor 3: what is traced. [`World::freeze`] turns a checked scene into tables made for rays; parts that a scene does
//! not need (a sky table, slides) are never built.

pub mod beam;
pub mod cdf;
pub mod contact;
pub mod eye;
pub mod films;
pub mod fresnel;
pub mod gauss;
pub mod geometry;
mod glow;
pub mod grating;
pub mod interior;
pub mod lamp;
pub mod light;
pub mod mode;
pub mod optics;
pub mod outline;
pub mod pile; // what lies on each other at one place
pub mod ray_lamp;
pub mod rim;
pub mod role;
pub mod scatter;
pub mod seam;
pub mod sensor;
pub mod sheet;
pub mod sky;
pub mod slide;
pub mod stokes;
pub mod surface;
pub mod texture;
pub mod thinfilm;
pub mod tint;
mod veil;
pub mod wavelengths;
pub mod web;

use contact::Contacts;
use eye::EyeLens;
use eyebox_base::Result;
use eyebox_base::lpe::{Letter, MOST_SLIDES, Product};
use eyebox_scene::{BeaconForm, Coating, Eye, Medium, Scene};
use geometry::{Geometry, Hit, Ray, Site};
use glam::DVec3;
use interior::{Interior, Solid};
use lamp::Lamps;
use light::Lights;
use rim::Rims;
use scatter::Principled;
use sky::SkyLight;
use slide::SlideMap;
use std::sync::Arc;
use surface::{FaceOptics, Surface};
use tint::Tints;

/// Everything that a ray can meet, in a frame whose origin is the middle of the scene (so that an assembly 10 km from
/// the world's origin renders the same). What is large is shared by the [same world seen otherwise](World::seen_by).
pub struct World {
    pub geometry: Arc<Geometry>,
    /// Per part, per face: what it does with light.
    pub faces: Arc<Vec<Vec<FaceOptics>>>,
    /// Per part: where it stands among nested ones, if it is a solid.
    pub solids: Vec<Option<Solid>>,
    /// Where faces that scatter end, or are crossed by others.
    pub rims: Arc<Rims>,
    /// Faces of solids that touch.
    pub contacts: Arc<Contacts>,
    /// Per part: the medium it is filled with, if it is a solid.
    pub media_of_parts: Arc<Vec<Option<Medium>>>,
    pub coatings: Arc<Vec<Coating>>,
    pub lamps: Arc<Lamps>,
    /// Solids that contain each lamp's surface: where its light starts.
    pub lamp_interiors: Vec<Interior>,
    pub lights: Lights,
    /// Solids that each light is inside of.
    pub light_interiors: Vec<Interior>,
    pub sky: Option<Arc<SkyLight>>,
    pub eye: EyeLens,
    pub slides: Arc<Vec<SlideMap>>,
    /// Some face is an ordinary material.
    pub ordinary: bool,
    /// Light of one wavelength goes other ways than that of another.
    pub disperses: bool,
    pub tints: Tints,
    /// The wavelength of [`mode::Mono`], nm.
    pub wavelength_nm: f64,
    /// The light path expressions that paths are told to, if any was asked for that parts classes.
    pub sieve: Option<Arc<Product>>,
    /// Rays from the eye leave the pictures of slides, of lamps and of the sky to chance: none is cut by a pixel's footprint. To try
    /// the others by.
    pub plain: bool,
    /// A fault that a test plants in the walk, to see that the balances find it.
    #[cfg(any(test, feature = "testing"))]
    pub planted: Planted,
}

/// What a test breaks on purpose.
#[cfg(any(test, feature = "testing"))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Planted {
    #[default]
    Nothing,
    /// This part's faces lose a hundredth of the light that is reflected or transmitted, and book it nowhere.
    Leak { part: u32 },
    /// What this part absorbs is not booked.
    Unbooked { part: u32 },
    /// What leaves the scene is not booked.
    UnbookedEscape,
}

impl World {
    /// Refractive index of what fills each part at a wavelength in nm; of air for those that are not filled.
    pub fn indices_at(&self, nm: f64) -> Vec<f64> {
        let index = |medium: &Option<Medium>| medium.as_ref().map_or(1.0, |medium| medium.index.index(nm).re);
        self.media_of_parts.iter().map(index).collect()
    }

    /// What crossing a slide is to light path expressions: where there are several, these can tell them apart.
    pub fn slide_letter(&self, slide: usize) -> Letter {
        let several = (2..=MOST_SLIDES).contains(&self.slides.len());
        u8::try_from(slide).ok().filter(|_| several).map_or(Letter::TransmitStraight, Letter::CrossSlide)
    }

    /// What tells the light of a slide from that of others in series with it; 0 where nobody wants to know.
    pub fn rank(&self, slide: usize) -> f64 {
        if self.sieve.as_ref().is_some_and(|sieve| sieve.parts_series()) { slide as f64 } else { 0.0 }
    }

    /// Builds the tables for a scene. Errors: geometry that cannot be traced, a zero-area emitter, an eye inside glass.
    pub fn freeze(scene: &Scene) -> Result<World> {
        let wavelength_nm = scene.wavelengths.traced_nm();
        let geometry = Geometry::build(scene)?;
        let solids: Vec<Option<Solid>> =
            scene.parts.iter().map(|part| part.medium.map(|_| Solid { priority: part.priority })).collect();
        let media_of_parts = scene.parts.iter().map(|part| part.medium.map(|id| scene.medium(id).clone())).collect();
        let faces = surface::optics_of(scene)?;
        let contacts = Contacts::find(scene, &geometry, &faces, &solids);
        let lamps = Lamps::build(scene, &|part| geometry.part_to_world(u32::try_from(part).unwrap_or(u32::MAX)))?;
        let lamp_interiors = lamps
            .all()
            .iter()
            .map(|lamp| {
                let start = lamp.sample_point([0.5, 0.5]);
                let site = Site { part: lamp.part as u32, face: lamp.face as u32, triangle: start.triangle };
                // Where it lies on glass it is outside of that, on whichever side rounding puts its points.
                let under = contacts.under(&geometry, site, [start.position, start.normal, start.normal]);
                let out = [Some(site.part), under.map(|(glass, _)| glass.site.part)];
                let around = geometry.solids_containing(start.position);
                Interior::of(around.into_iter().filter(|part| !out.contains(&Some(*part))))
            })
            .collect();
        let emitters = lamps.all().iter().map(|lamp| scene.parts[lamp.part].faces[lamp.face].emitter.as_ref());
        let tints = Tints::build(scene, emitters.map(|emitter| emitter.and_then(|e| e.spectrum.as_ref())))?;
        let eye = EyeLens::build(&scene.eye, geometry.origin())?;
        let around_eye = geometry.solids_containing(scene.eye.position - geometry.origin());
        if let Some(part) = around_eye.first() {
            let path = &scene.parts[*part as usize].path;
            return Err(eyebox_base::Error::new(
                eyebox_base::Where::part(path),
                format!("the eye is inside this solid (pupil centre at {} m)", scene.eye.position),
            )
            .expected("an eye in air")
            .code(eyebox_base::Code::EyeInSolid));
        }
        let lights = Lights::build(scene, geometry.origin(), reach(&geometry, &eye, scene.eye.pupil_diameter_m))?;
        // A distant lamp starts outside of everything.
        let light_interiors = scene
            .lights
            .iter()
            .zip(lights.all())
            .map(|(light, made)| match light.form {
                BeaconForm::Point { position, .. } | BeaconForm::Profile { position, .. } => {
                    Interior::of(geometry.solids_containing(position - geometry.origin()))
                }
                BeaconForm::Distant { .. } => Interior::default(),
                // Each ray has its own ([`World::start_of_light`]); this is that of one in their middle.
                BeaconForm::Rays { .. } => {
                    let part = made.rays().map(|rays| rays.part());
                    Interior::of(geometry.solids_around(made.emit([0.5; 2], [0.5; 2]).0, part))
                }
            })
            .collect();
        let is_ordinary = |face: &FaceOptics| matches!(&face.surface, Surface::Scatter(s) if s.principled().is_some());
        Ok(World {
            ordinary: faces.iter().flatten().any(is_ordinary),
            disperses: disperses(scene),
            rims: Arc::new(Rims::find(scene, &geometry, &faces)),
            faces: Arc::new(faces),
            solids,
            contacts: Arc::new(contacts),
            media_of_parts: Arc::new(media_of_parts),
            coatings: Arc::new(scene.coatings.clone()),
            lamps: Arc::new(lamps),
            lamp_interiors,
            lights,
            light_interiors,
            sky: scene.sky.as_ref().map(SkyLight::build).transpose()?.map(Arc::new),
            eye,
            slides: Arc::new(scene.slides.iter().map(SlideMap::build).collect::<Result<_>>()?),
            tints,
            geometry: Arc::new(geometry),
            wavelength_nm,
            sieve: None,
            plain: false,
            #[cfg(any(test, feature = "testing"))]
            planted: Planted::Nothing,
        })
    }

    /// Whether rays pass a face as if it were not there.
    pub fn is_absent(&self, site: Site) -> bool {
        matches!(self.faces[site.part as usize][site.face as usize].surface, Surface::Absent)
    }

    /// The normal for optics where a ray along `dir` has met a face, in the hemisphere of the face's own. An ordinary material
    /// may have a normal map; and its interpolated normals never turn away from the ray, which would see nothing there.
    #[inline]
    pub fn shading(&self, hit: &Hit, dir: DVec3) -> DVec3 {
        if !self.ordinary {
            return hit.shading;
        }
        match self.principled(hit.site) {
            Some(principled) => principled.shading(hit, dir, &self.geometry.part_to_world(hit.site.part)),
            None => hit.shading,
        }
    }

    /// The ordinary material of a face, if it has one.
    pub fn principled(&self, site: Site) -> Option<&Principled> {
        match &self.faces[site.part as usize][site.face as usize].surface {
            Surface::Scatter(scatter) => scatter.principled(),
            Surface::Absent
            | Surface::Absorber
            | Surface::Slide(_)
            | Surface::Mirror(_)
            | Surface::Sheet(_)
            | Surface::Splitter(_)
            | Surface::Grating(_)
            | Surface::Interface(_) => None,
        }
    }

    /// How a path starts on a light that is no face, and what it starts inside of: [`light::Light::emit`], and of the rays
    /// of a file [`ray_lamp::RayLamp::leaving`].
    pub fn start_of_light(&self, index: usize, other: [f64; 2], uv: [f64; 2]) -> (Ray, Interior) {
        let light = &self.lights.all()[index];
        let (origin, dir) = light.emit(other, uv);
        match light.rays() {
            None => (Ray { origin, dir, from: None }, self.light_interiors[index]),
            Some(rays) => {
                let around = self.geometry.solids_around(origin, Some(rays.part()));
                (rays.leaving(&self.geometry, (origin, dir)), Interior::of(around))
            }
        }
    }

    /// The same world in a picture of another size. Errors: a picture without pixels.
    pub fn seen_by(&self, eye: &Eye) -> Result<World> {
        Ok(World {
            geometry: self.geometry.clone(),
            faces: self.faces.clone(),
            solids: self.solids.clone(),
            rims: self.rims.clone(),
            contacts: self.contacts.clone(),
            media_of_parts: self.media_of_parts.clone(),
            coatings: self.coatings.clone(),
            lamps: self.lamps.clone(),
            lamp_interiors: self.lamp_interiors.clone(),
            lights: self.lights.clone(),
            light_interiors: self.light_interiors.clone(),
            sky: self.sky.clone(),
            eye: EyeLens::build(eye, self.geometry.origin())?,
            slides: self.slides.clone(),
            ordinary: self.ordinary,
            disperses: self.disperses,
            tints: self.tints.clone(),
            wavelength_nm: self.wavelength_nm,
            sieve: self.sieve.clone(),
            plain: self.plain,
            #[cfg(any(test, feature = "testing"))]
            planted: self.planted,
        })
    }
}

/// Whether light of one wavelength may go other ways than that of another.
fn disperses(scene: &Scene) -> bool {
    let media = scene.parts.iter().filter_map(|part| part.medium.map(|id| scene.medium(id)));
    !scene.gratings.is_empty() || media.into_iter().any(|medium| !medium.index.is_constant())
}

/// Centre and radius of a sphere about the geometry and the pupil, a little larger than it need be.
fn reach(geometry: &Geometry, eye: &EyeLens, pupil_diameter_m: f64) -> (glam::DVec3, f64) {
    const MARGIN: f64 = 1.0 + 1e-9;
    let pupil = glam::DVec3::splat(pupil_diameter_m / 2.0);
    let (low, high) = geometry.bounds();
    let (near, far) = (eye.position() - pupil, eye.position() + pupil);
    let (low, high) = if low.cmple(high).all() { (low.min(near), high.max(far)) } else { (near, far) };
    (0.5 * (low + high), 0.5 * (high - low).length() * MARGIN)
}
