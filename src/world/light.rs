//! Lamps that are no faces: points, spots and distant lamps, sampled from both ends, and rays of files, from theirs alone.

use super::ray_lamp::RayLamp;
use super::web::Web;
use eyebox_base::error::Result;
use eyebox_base::ids::GroupId;
use eyebox_base::warp::{self, Frame};
use eyebox_base::{Error, Where};
use eyebox_scene::{Beacon, BeaconForm, Scene};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// A lamp without a face.
#[derive(Debug, Clone)]
pub struct Light {
    group: GroupId,
    form: Form,
    flux_lm: f64,
}

#[derive(Debug, Clone)]
enum Form {
    Point {
        position: DVec3,
        intensity_cd: f64,
        spot: Option<Spot>,
    },
    /// `axes`: photometric frame → world.
    Profile {
        position: DVec3,
        axes: DMat3,
        web: Box<Web>,
        factor: f64,
    },
    Distant {
        dir: DVec3,
        illuminance_lx: f64,
        disc: Option<Disc>,
        centre: DVec3,
        radius: f64,
    },
    Rays(RayLamp),
}

/// I(θ) = I₀ x² with x = (cos θ − `edge`)/`width` within 0 … 1 (KHR_lights_punctual, "Inner and Outer Cone Angles").
#[derive(Debug, Clone, Copy)]
struct Spot {
    axis: DVec3,
    /// Cosine of the outer half angle.
    edge: f64,
    width: f64,
}

/// The uniform disc of a distant lamp in the sky.
#[derive(Debug, Clone, Copy)]
struct Disc {
    /// 1 − cosine of the half angle, which keeps its digits for the sun.
    versine: f64,
    luminance: f64,
}

/// Light from a lamp at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toward {
    /// Unit direction to the lamp.
    pub dir: DVec3,
    /// m; infinite for a distant lamp.
    pub distance: f64,
    pub light: Strength,
}

/// What comes along that direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// Illuminance across the direction, lx: no sampled direction can find this lamp.
    Delta(f64),
    /// Luminance in cd/m² and the density of the direction in 1/sr.
    Area(f64, f64),
}

impl Spot {
    /// The narrowest edge, in cosines: KHR_lights_punctual divides by no less.
    const NARROWEST: f64 = 1e-3;

    fn new(axis: DVec3, (inner, outer): (f64, f64)) -> Self {
        let edge = outer.cos();
        Spot { axis, edge, width: (inner.cos() - edge).max(Self::NARROWEST) }
    }

    fn share(&self, cos: f64) -> f64 {
        ((cos - self.edge) / self.width).clamp(0.0, 1.0).powi(2)
    }

    /// Solid angles, weighted by the intensity's share, of the full cone and of its edge.
    fn weights(&self) -> [f64; 2] {
        let full = (1.0 - self.edge - self.width).max(0.0);
        let x = ((1.0 - self.edge) / self.width).min(1.0);
        [2.0 * PI * full, 2.0 * PI * self.width * x.powi(3) / 3.0]
    }

    /// A direction with density ∝ intensity.
    fn sample(&self, [a, b]: [f64; 2]) -> DVec3 {
        let [full, edge] = self.weights();
        let place = a * (full + edge);
        let cos = if place < full {
            1.0 - place / (2.0 * PI)
        } else {
            let x = ((1.0 - self.edge) / self.width).min(1.0);
            self.edge + self.width * x * ((place - full) / edge).min(1.0).cbrt()
        };
        about(self.axis, 1.0 - cos, b)
    }
}

/// The direction at 1 − cos θ = `versine` from `axis`, turned by `turn` of a revolution.
fn about(axis: DVec3, versine: f64, turn: f64) -> DVec3 {
    let versine = versine.clamp(0.0, 2.0);
    let sin = (versine * (2.0 - versine)).sqrt();
    let (y, x) = (2.0 * PI * turn).sin_cos();
    Frame::about(axis).to_world(DVec3::new(sin * x, sin * y, 1.0 - versine)).normalize()
}

impl Light {
    /// `centre` and `radius` of a sphere about all that light can reach, recentred frame whose origin is `origin`, m.
    fn build(light: &Beacon, scene: &Scene, origin: DVec3, (centre, radius): (DVec3, f64)) -> Result<Light> {
        let fault = |what: &str, value: f64, range: &str| {
            Error::new(Where::part(&light.name), format!("the light's {what} is {value}")).expected(range)
        };
        let strength = |what: &str, value: f64| {
            if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(fault(what, value, "0 or more, and finite")) }
        };
        let axis = |axis: DVec3| {
            axis.try_normalize().ok_or_else(|| fault("direction", axis.length(), "a direction of positive length"))
        };
        let (form, flux_lm) = match light.form {
            BeaconForm::Rays { ref rays, part, flux_lm } => {
                strength("flux in lm", flux_lm)?;
                (Form::Rays(RayLamp::build(scene, (rays, part.index()), origin)?), flux_lm)
            }
            BeaconForm::Point { position, intensity_cd, spot } => {
                strength("intensity in cd", intensity_cd)?;
                if !position.is_finite() {
                    return Err(fault("distance from the origin", position.length(), "finite"));
                }
                let spot = match spot {
                    Some(cone) => {
                        let (inner, outer) = (cone.inner_rad, cone.outer_rad);
                        if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= PI) {
                            return Err(fault(
                                "outer cone angle",
                                outer,
                                "more than 0, at most π, not below the inner",
                            ));
                        }
                        Some(Spot::new(axis(cone.axis)?, (inner, outer)))
                    }
                    None => None,
                };
                let solid_angle = spot.map_or(4.0 * PI, |spot| spot.weights().iter().sum());
                (Form::Point { position: position - origin, intensity_cd, spot }, intensity_cd * solid_angle)
            }
            BeaconForm::Profile { position, axes, profile, factor } => {
                strength("factor of its profile", factor)?;
                if !position.is_finite() {
                    return Err(fault("distance from the origin", position.length(), "finite"));
                }
                let off = (axes.transpose() * axes - DMat3::IDENTITY)
                    .to_cols_array()
                    .into_iter()
                    .fold(0.0, |most: f64, x| most.max(x.abs()));
                if off.is_nan() || off > 1e-9 {
                    return Err(fault("frame is no rotation: it", off, "orthogonal axes"));
                }
                let profile = scene.profiles.get(profile.index()).cloned();
                let web = profile.and_then(Web::new).ok_or_else(|| fault("profile's flux", 0.0, "light"))?;
                let flux = factor * web.flux_lm();
                (Form::Profile { position: position - origin, axes, web: Box::new(web), factor }, flux)
            }
            BeaconForm::Distant { dir, illuminance_lx, angle_rad } => {
                strength("illuminance in lx", illuminance_lx)?;
                if !(0.0..=PI).contains(&angle_rad) {
                    return Err(fault("full angle", angle_rad, "0 to π"));
                }
                let half = angle_rad / 2.0;
                // E = ∫ L cos θ dω = π L sin² of the half angle.
                let disc = (angle_rad > 0.0).then(|| Disc {
                    versine: 2.0 * (half / 2.0).sin().powi(2),
                    luminance: illuminance_lx / (PI * half.sin().powi(2)),
                });
                let across = disc.map_or(illuminance_lx, |disc| 2.0 * PI * disc.versine * disc.luminance);
                let flux = across * PI * radius * radius;
                (Form::Distant { dir: axis(dir)?, illuminance_lx, disc, centre, radius }, flux)
            }
        };
        if !flux_lm.is_finite() {
            return Err(fault("flux in lm", flux_lm, "a finite number"));
        }
        Ok(Light { group: light.group, form, flux_lm })
    }

    pub fn group(&self) -> GroupId {
        self.group
    }

    /// Flux of the lamp, of a distant one through the scene, lm.
    pub fn flux_lm(&self) -> f64 {
        self.flux_lm
    }

    /// Has a luminance, so that a ray may find it.
    pub fn is_visible(&self) -> bool {
        match &self.form {
            Form::Point { .. } | Form::Profile { .. } | Form::Rays(_) => false,
            Form::Distant { disc, .. } => disc.is_some(),
        }
    }

    /// The rays of a file, which only paths that start on them follow.
    pub fn rays(&self) -> Option<&RayLamp> {
        match &self.form {
            Form::Rays(rays) => Some(rays),
            Form::Point { .. } | Form::Profile { .. } | Form::Distant { .. } => None,
        }
    }

    /// What paths from the lamp bring straight to the pupil has a luminance: that of a point or of parallel light has none.
    pub fn has_luminance(&self) -> bool {
        self.is_visible() || self.rays().is_some()
    }

    /// Where a path starts and its direction, with density ∝ intensity: every path carries `flux_lm`/N. `uv` is what a
    /// guide learns: the direction of a point's path, and where it passes the scene for a distant lamp.
    pub fn emit(&self, other: [f64; 2], uv: [f64; 2]) -> (DVec3, DVec3) {
        match &self.form {
            Form::Point { position, spot, .. } => {
                (*position, spot.map_or_else(|| warp::sphere(uv), |spot| spot.sample(uv)))
            }
            Form::Profile { position, axes, web, .. } => (*position, (*axes * web.sample(uv)).normalize()),
            Form::Rays(rays) => rays.emit(uv[0]),
            Form::Distant { dir, disc, centre, radius, .. } => {
                let dir = disc.map_or(*dir, |disc| about(*dir, other[0] * disc.versine, other[1]));
                let frame = Frame::about(dir);
                let place = warp::disk(uv) * *radius;
                (*centre + frame.to_world(DVec3::new(place.x, place.y, -*radius)), dir)
            }
        }
    }

    /// What [`Light::emit`] takes as `uv` for light that passes a point, if that tells where light starts: of a distant lamp.
    pub fn passing(&self, point: DVec3) -> Option<[f64; 2]> {
        match &self.form {
            Form::Point { .. } | Form::Profile { .. } | Form::Rays(_) => None,
            Form::Distant { dir, centre, radius, .. } => {
                let across = Frame::about(*dir).to_local(point - *centre).truncate() / *radius;
                (across.length_squared() <= 1.0).then(|| warp::disk_inverse(across))
            }
        }
    }

    /// The direction that the light of a distant lamp travels in.
    pub fn direction(&self) -> Option<DVec3> {
        match &self.form {
            Form::Point { .. } | Form::Profile { .. } | Form::Rays(_) => None,
            Form::Distant { dir, .. } => Some(*dir),
        }
    }

    /// Illuminance that the lamp may give at a point, lx: what it is chosen by.
    fn importance(&self, at: DVec3) -> f64 {
        match &self.form {
            Form::Point { position, intensity_cd, spot } => {
                let away = at - *position;
                let share = spot.map_or(1.0, |spot| spot.share(away.normalize_or_zero().dot(spot.axis)));
                let importance = intensity_cd * share / away.length_squared();
                if importance.is_finite() { importance } else { 0.0 }
            }
            Form::Profile { position, axes, web, factor } => {
                let away = at - *position;
                let intensity = factor * web.intensity(axes.transpose() * away.normalize_or_zero());
                let importance = intensity / away.length_squared();
                if importance.is_finite() { importance } else { 0.0 }
            }
            Form::Distant { illuminance_lx, .. } => *illuminance_lx,
            // No ray meets one of them.
            Form::Rays(_) => 0.0,
        }
    }

    /// The lamp as seen from a point.
    fn toward(&self, at: DVec3, uv: [f64; 2]) -> Option<Toward> {
        match &self.form {
            Form::Rays(_) => None,
            Form::Point { position, .. } | Form::Profile { position, .. } => {
                let distance = at.distance(*position);
                let dir = ((*position - at) / distance).try_normalize()?;
                Some(Toward { dir, distance, light: Strength::Delta(self.importance(at)) })
            }
            Form::Distant { dir, illuminance_lx, disc, .. } => {
                let (dir, light) = match disc {
                    None => (-*dir, Strength::Delta(*illuminance_lx)),
                    Some(disc) => {
                        let dir = about(-*dir, uv[0] * disc.versine, uv[1]);
                        (dir, Strength::Area(disc.luminance, disc.density()))
                    }
                };
                Some(Toward { dir, distance: f64::INFINITY, light })
            }
        }
    }

    /// Luminance of the disc that a ray which leaves the scene along `dir` meets, and its density of sampling.
    fn met(&self, ray: DVec3) -> Option<(f64, f64)> {
        match &self.form {
            Form::Point { .. } | Form::Profile { .. } | Form::Rays(_) => None,
            Form::Distant { dir, disc, .. } => {
                let disc = (*disc)?;
                // 1 − cos θ = |a − b|²/2 for unit vectors.
                let versine = (ray + *dir).length_squared() / 2.0;
                (versine <= disc.versine).then(|| (disc.luminance, disc.density()))
            }
        }
    }
}

impl Disc {
    fn density(&self) -> f64 {
        1.0 / (2.0 * PI * self.versine)
    }
}

/// All lamps without faces.
#[derive(Debug, Clone, Default)]
pub struct Lights {
    lights: Vec<Light>,
}

impl Lights {
    /// `bounds`: sphere about all that light can reach, in the recentred frame.
    /// Errors: strengths, directions or angles outside their ranges, named by the light.
    pub fn build(scene: &Scene, origin: DVec3, bounds: (DVec3, f64)) -> Result<Lights> {
        Ok(Lights {
            lights: scene.lights.iter().map(|l| Light::build(l, scene, origin, bounds)).collect::<Result<_>>()?,
        })
    }

    pub fn all(&self) -> &[Light] {
        &self.lights
    }

    /// The index of a lamp by what it may give at a point, its probability, and how it is seen from there.
    pub fn sample(&self, at: DVec3, pick: f64, uv: [f64; 2]) -> Option<(usize, f64, Toward)> {
        let total = self.total(at);
        let mut rest = pick * total;
        let mut chosen = None;
        for (index, light) in self.lights.iter().enumerate() {
            let importance = light.importance(at);
            if importance > 0.0 {
                chosen = Some((index, importance / total));
                if rest < importance {
                    break;
                }
                rest -= importance;
            }
        }
        let (index, probability) = chosen?;
        Some((index, probability, self.lights[index].toward(at, uv)?))
    }

    /// Discs that a ray which leaves the scene along `dir` meets: index, luminance, and the density in 1/sr with which
    /// [`Lights::sample`] would have taken the direction in which the ray has left the point, both in `from`.
    pub fn met(&self, dir: DVec3, from: Option<(DVec3, DVec3)>) -> impl Iterator<Item = (usize, f64, f64)> {
        self.lights.iter().enumerate().filter_map(move |(index, light)| {
            let (luminance, _) = light.met(dir)?;
            let taken = from.and_then(|(at, dir)| Some(light.met(dir)?.1 * light.importance(at) / self.total(at)));
            Some((index, luminance, taken.unwrap_or(0.0)))
        })
    }

    /// Luminance that a ray which leaves the scene along `dir` sees of the disc of a light.
    pub fn luminance(&self, index: usize, dir: DVec3) -> f64 {
        self.lights.get(index).and_then(|light| light.met(dir)).map_or(0.0, |(luminance, _)| luminance)
    }

    fn total(&self, at: DVec3) -> f64 {
        self.lights.iter().map(|light| light.importance(at)).sum()
    }
}
