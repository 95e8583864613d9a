//! Emitting faces: how bright they are, and points and directions sampled on them.

use super::beam::Beam;
use super::cdf::Cdf;
use super::glow::Glow;
use super::veil::Veil;
use eyebox_base::error::Result;
use eyebox_base::ids::GroupId;
use eyebox_base::warp;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::angular::GaussBeam;
use eyebox_scene::{Angular, Emitter, Part, Photometry, Scene};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Directions in which the brightest of a measured beam is looked for.
const POLAR: u32 = 360;
const AROUND: u32 = 72;
/// Share of [`Lamps::pick_for_point`]'s choices that go by flux alone, so that no lamp is ever starved.
const DEFENSIVE: f64 = 0.1;

/// One emitting face. Every element of its area emits dI = I(direction) dA/A about its own normal, so flux is exact on
/// curved faces too, while I is the face's intensity only where it is flat.
#[derive(Debug, Clone)]
pub struct Lamp {
    /// Index of the part and of its face.
    pub part: usize,
    pub face: usize,
    /// Of a face that shines from both sides, this is the back.
    pub back: bool,
    pub group: GroupId,
    /// Area of the face's triangles, m².
    pub area_m2: f64,
    /// Luminous flux of the face, lm.
    pub flux_lm: f64,
    /// Intensity along the normal, cd.
    pub intensity_cd: f64,
    beam: Beam,
    /// What the beam's own unit of intensity is worth, cd.
    unit_cd: f64,
    /// Direction of the electric field (world) and polarised share of its light.
    pub polarisation: Option<(DVec3, f64)>,
    /// The slide that it shines through, if it is a display that shows a picture: flux, intensity and luminance are white's.
    pub shown: Option<Shown>,
    /// The texture that it shines through, if any: flux, intensity and luminance are the mean's.
    glow: Option<Box<Glow>>,
    /// What the material of its face leaves of its light, if not all: flux, intensity and luminance are what the opacity leaves on
    /// average, before coat and sheen.
    veil: Option<Box<Veil>>,
    triangles: Vec<Triangle>,
    by_area: Cdf,
    /// Sphere about the face: centre, and radius squared.
    centre: DVec3,
    radius2: f64,
}

/// The picture of a display.
#[derive(Debug, Clone, Copy)]
pub struct Shown {
    /// Index among the world's slides.
    pub slide: usize,
    /// From the recentred world to the slide's own mesh units.
    to_local: DAffine3,
}

impl Shown {
    /// A point of the display, where the slide's picture is asked.
    pub fn local(&self, position: DVec3) -> DVec3 {
        self.to_local.transform_point3(position)
    }
}

/// A triangle of a face in the recentred world, m; its normal is unit and outward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) origin: DVec3,
    pub(super) edges: [DVec3; 2],
    pub(super) normal: DVec3,
    /// Among those of the mesh.
    pub(super) index: u32,
}

/// A point on a lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LampPoint {
    /// Recentred world frame, m.
    pub position: DVec3,
    /// Unit normal of the triangle on the side that emits.
    pub normal: DVec3,
    /// Index into the mesh's triangles.
    pub triangle: u32,
}

impl Lamp {
    /// `side`: 1 for the front, −1 for the back.
    fn build(
        scene: &Scene,
        (part, face): (usize, usize),
        emitter: &Emitter,
        to_world: DAffine3,
        side: f64,
    ) -> Result<Lamp> {
        let owner = &scene.parts[part];
        let at = || Where::Part { path: owner.path.clone(), face: Some(face) };
        let mut triangles = world_triangles(scene, owner, face, to_world)
            .ok_or_else(|| Error::new(at(), "an emitting face refers to triangles or vertices that its mesh lacks"))?;
        triangles.iter_mut().for_each(|triangle| triangle.normal *= side);
        let areas: Vec<f64> = triangles.iter().map(|t| 0.5 * t.edges[0].cross(t.edges[1]).length()).collect();
        let by_area = Cdf::new(areas.iter().copied()).ok_or_else(|| {
            Error::new(at(), "an emitting face has no area")
                .expected("a face with a positive, finite area")
                .code(Code::EmitterWithoutArea)
        })?;
        let area_m2 = by_area.total();
        let (what, value) = match emitter.photometry {
            Photometry::FluxLm(flux) => ("flux in lm", flux),
            Photometry::LuminanceCdM2(luminance) => ("luminance in cd/m²", luminance),
            Photometry::IntensityCd(intensity) => ("intensity in cd", intensity),
            Photometry::AsMeasured => ("factor of its profile", 1.0),
        };
        let beam = match emitter.angular {
            Angular::Lambert => Beam::CosN(1.0),
            Angular::CosN { n } => {
                if !(n >= 0.0 && n.is_finite()) {
                    return Err(
                        Error::new(at(), format!("the emitter's exponent of cosine is {n}")).expected("0 or more")
                    );
                }
                Beam::CosN(n)
            }
            Angular::Gauss { fwhm_deg } => {
                if !(fwhm_deg > 0.0 && fwhm_deg.is_finite()) {
                    return Err(
                        Error::new(at(), format!("the emitter's beam is {fwhm_deg} deg wide")).expected("more than 0")
                    );
                }
                Beam::Gauss(Box::new(GaussBeam::new(fwhm_deg)))
            }
            Angular::Profile { profile, c0 } => {
                let profile = scene.profiles.get(profile.index());
                let c0 = to_world.matrix3 * c0;
                profile.and_then(|profile| Beam::of_profile(profile, c0)).ok_or_else(|| {
                    Error::new(at(), "the emitter's profile has no light in front of the face")
                        .expected("a profile that shines along its axis")
                        .code(Code::ProfileBehindFace)
                })?
            }
        };
        let dark = || Error::new(at(), "the emitter's angular distribution is unknown");
        let spread = emitter.angular.spread(&scene.profiles).ok_or_else(dark)?;
        // Both sides share a flux.
        let share = match emitter.photometry {
            Photometry::FluxLm(_) if emitter.both_sides => 0.5,
            Photometry::FluxLm(_)
            | Photometry::LuminanceCdM2(_)
            | Photometry::IntensityCd(_)
            | Photometry::AsMeasured => 1.0,
        };
        let indices: Vec<u32> = triangles.iter().map(|triangle| triangle.index).collect();
        let glow = Glow::build(scene, owner, emitter, indices.iter().copied());
        let veil = Veil::build(scene, (part, face), (to_world, side), glow.as_deref(), (&indices, &areas));
        let mean = glow.as_ref().map_or(1.0, |glow| glow.mean()) * veil.as_ref().map_or(1.0, |veil| veil.mean());
        let unit_cd = share * mean * emitter.unit_cd(&spread, area_m2);
        let (flux_lm, intensity_cd) = (unit_cd * beam.whole(), unit_cd * spread.normal);
        let brightest = unit_cd * spread.peak / area_m2;
        if !(value >= 0.0 && unit_cd >= 0.0 && flux_lm.is_finite() && brightest.is_finite()) {
            return Err(Error::new(at(), format!("the emitter's {what} is {value}")).expected("0 or more, and finite"));
        }
        // What is beyond reach of f32 lanes and their squares in f64 would come out as NaN hours later.
        const BRIGHTEST: f64 = 1e30;
        if brightest > BRIGHTEST {
            let text = format!("the emitter's {what} of {value} makes {brightest:.3e} cd/m² on its {area_m2:.3e} m²");
            return Err(Error::new(at(), text)
                .expected(format!("at most {BRIGHTEST:e} cd/m²"))
                .code(Code::LuminanceImplausible));
        }
        let corners = || triangles.iter().flat_map(|t| [t.origin, t.origin + t.edges[0], t.origin + t.edges[1]]);
        let (low, high) = corners()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| (low.min(corner), high.max(corner)));
        let centre = 0.5 * (low + high);
        let radius2 = corners().map(|corner| corner.distance_squared(centre)).fold(0.0, f64::max);
        let group = emitter.group;
        let slide = owner.faces.get(face).and_then(|face| face.slide);
        let shown = slide.map(|slide| Shown { slide: slide.index(), to_local: to_world.inverse() });
        // A slide that says how its light is polarised says it of the display.
        let by_slide = slide.and_then(|slide| {
            let slide = scene.slide(slide);
            let polarisation = slide.polarisation?;
            let (sin, cos) = polarisation.angle_deg.to_radians().sin_cos();
            Some((slide.u * cos + slide.v * sin, polarisation.degree))
        });
        let own = || emitter.polarisation.map(|light| (light.axis, light.degree));
        Ok(Lamp {
            part,
            face,
            back: side < 0.0,
            group,
            area_m2,
            flux_lm,
            intensity_cd,
            beam,
            unit_cd,
            polarisation: by_slide.or_else(own).map(|(axis, degree)| (to_world.transform_vector3(axis), degree)),
            shown,
            glow,
            veil,
            triangles,
            by_area,
            centre,
            radius2,
        })
    }

    /// Luminance along the unit direction `dir` from a point with this unit normal, cd/m²; 0 behind the face.
    pub fn luminance_along(&self, normal: DVec3, dir: DVec3) -> f64 {
        let cos = normal.dot(dir);
        if cos.is_nan() || cos <= 0.0 {
            return 0.0;
        }
        let unit = self.unit_cd / self.area_m2;
        match &self.beam {
            Beam::CosN(n) if *n == 1.0 => unit,
            Beam::CosN(n) => unit * cos.powf(*n - 1.0),
            Beam::Gauss(_) | Beam::Profile { .. } => unit * self.beam.intensity(normal, dir, cos) / cos,
        }
    }

    /// What a place has of the mean light along a unit direction, linear Rec.709, whose luminance is 1 on average before coat and
    /// sheen; none of a lamp that shines evenly.
    pub fn glow(&self, place: &LampPoint, dir: DVec3) -> Option<[f64; 3]> {
        let own = self.glow.as_ref().and_then(|glow| {
            let (at, weights) = self.weights(place.triangle, place.position)?;
            Some(glow.at(at, weights))
        });
        match (own, self.veiled(place, dir)) {
            (Some(own), Some(veiled)) => Some([0, 1, 2].map(|c| own[c] * veiled[c])),
            (found, None) | (None, found) => found,
        }
    }

    /// The same without the texture that the lamp shines through.
    pub fn veiled(&self, place: &LampPoint, dir: DVec3) -> Option<[f64; 3]> {
        let veil = self.veil.as_ref().filter(|veil| !veil.is_even())?;
        Some(veil.at(place, dir))
    }

    /// Whether the material of its face leaves more of its light here than there.
    pub fn is_patterned(&self) -> bool {
        self.veil.as_ref().is_some_and(|veil| veil.is_patterned())
    }

    /// The texture that it shines through, if any.
    pub fn texture(&self) -> Option<&Glow> {
        self.glow.as_deref()
    }

    /// Where in that texture a place lies, in columns and rows of its texels.
    pub fn in_texture(&self, triangle: u32, position: DVec3) -> Option<DVec2> {
        let glow = self.glow.as_ref()?;
        let (at, weights) = self.weights(triangle, position)?;
        Some(glow.place(at, weights))
    }

    /// The place of a triangle among the lamp's, and the shares that its corners have in a point of it.
    fn weights(&self, triangle: u32, position: DVec3) -> Option<(usize, [f64; 3])> {
        let at = self.place_of(triangle)?;
        let Triangle { origin, edges: [e, f], .. } = self.triangles[at];
        // Shares of the corners, seen along the normal.
        let normal = e.cross(f);
        let (off, whole) = (position - origin, normal.length_squared());
        let (v, w) = (off.cross(f).dot(normal) / whole, e.cross(off).dot(normal) / whole);
        Some((at, [1.0 - v - w, v, w]))
    }

    /// The place of a triangle among the lamp's.
    fn place_of(&self, triangle: u32) -> Option<usize> {
        // A lamp often has all triangles from its first one on.
        let is_at = |place: &usize| self.triangles.get(*place).is_some_and(|found| found.index == triangle);
        let guess = triangle.checked_sub(self.triangles.first()?.index)? as usize;
        let search = || self.triangles.binary_search_by_key(&triangle, |found| found.index).ok();
        Some(guess).filter(is_at).or_else(search)
    }

    /// Whether it shines alike from all of its places, whatever lies over it.
    pub fn is_even(&self) -> bool {
        self.glow.is_none() && self.shown.is_none() && self.veil.as_ref().is_none_or(|veil| veil.is_even())
    }

    /// [`Lamp::luminance_along`] a direction at `cos_theta` to the normal; for a profile, the one in its plane C0.
    pub fn luminance(&self, cos_theta: f64) -> f64 {
        let sin = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let x = match &self.beam {
            Beam::CosN(n) if *n == 1.0 => return if cos_theta > 0.0 { self.unit_cd / self.area_m2 } else { 0.0 },
            Beam::CosN(_) | Beam::Gauss(_) => DVec3::X,
            Beam::Profile { c0, .. } => super::beam::photometric(DVec3::Z, *c0).x_axis,
        };
        self.luminance_along(DVec3::Z, DVec3::Z * cos_theta + x * sin)
    }

    /// The largest of its luminances, in any direction, cd/m²: of the mean of a texture.
    pub fn brightest(&self) -> f64 {
        match (&self.beam, self.triangles.first()) {
            // A measured beam may have a narrow peak anywhere.
            (Beam::Profile { .. }, Some(triangle)) => {
                let (a, b) = triangle.normal.any_orthonormal_pair();
                let along = |polar: f64, around: f64| {
                    let across = a * around.cos() + b * around.sin();
                    self.luminance_along(triangle.normal, triangle.normal * polar.cos() + across * polar.sin())
                };
                let of = |k: u32| {
                    let polar = (f64::from(k) + 0.5) / f64::from(POLAR) * FRAC_PI_2;
                    (0..AROUND).map(|j| along(polar, f64::from(j) / f64::from(AROUND) * TAU)).fold(0.0, f64::max)
                };
                (0..POLAR).map(of).fold(along(0.0, 0.0), f64::max)
            }
            (Beam::CosN(_) | Beam::Gauss(_) | Beam::Profile { .. }, _) => {
                (0..=32).map(|k| self.luminance(f64::from(k) / 32.0)).fold(0.0, f64::max)
            }
        }
    }

    /// A point uniform over the area: density 1/`area_m2`.
    pub fn sample_point(&self, [a, b]: [f64; 2]) -> LampPoint {
        let (index, a) = self.by_area.sample(a);
        let triangle = &self.triangles[index];
        let [u, v, _] = warp::triangle([a, b]);
        let position = triangle.origin + triangle.edges[0] * u + triangle.edges[1] * v;
        LampPoint { position, normal: triangle.normal, triangle: triangle.index }
    }

    /// Corners of the triangles that [`Lamp::sample_point`] chooses by first numbers of a range, and how many those are.
    pub fn corners_of(&self, [from, to]: [f64; 2]) -> (usize, impl Iterator<Item = DVec3>) {
        let (first, last) = (self.by_area.sample(from).0, self.by_area.sample(to).0);
        let triangles = self.triangles.get(first..=last).unwrap_or_default();
        let corners = triangles.iter().flat_map(|t| [t.origin, t.origin + t.edges[0], t.origin + t.edges[1]]);
        (triangles.len(), corners)
    }

    /// Centre and radius, m, of a sphere about the face.
    pub fn around(&self) -> (DVec3, f64) {
        (self.centre, self.radius2.sqrt())
    }

    /// A unit direction with density ∝ intensity: every path that is emitted at a sampled point carries `flux_lm`/N.
    pub fn sample_direction(&self, normal: DVec3, uv: [f64; 2]) -> DVec3 {
        self.beam.sample(normal, uv)
    }

    /// Density of [`Lamp::sample_direction`], 1/sr.
    pub fn density_along(&self, normal: DVec3, dir: DVec3) -> f64 {
        let cos = normal.dot(dir);
        if cos > 0.0 { self.beam.intensity(normal, dir, cos) / self.beam.whole() } else { 0.0 }
    }

    /// [`Lamp::density_along`] a direction at `cos_theta` to the normal, of beams that are the same all round.
    pub fn direction_pdf(&self, cos_theta: f64) -> f64 {
        let sin = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        self.density_along(DVec3::Z, DVec3::new(sin, 0.0, cos_theta))
    }

    /// How much a point may expect of this lamp, up to a common factor: flux over distance², which the extent of the
    /// lamp keeps finite.
    fn importance(&self, point: DVec3) -> f64 {
        if self.flux_lm > 0.0 { self.flux_lm / (point.distance_squared(self.centre) + self.radius2) } else { 0.0 }
    }
}

/// Triangles of a face in the world, degenerate ones left out; none if the mesh is inconsistent.
pub(super) fn world_triangles(scene: &Scene, part: &Part, face: usize, to_world: DAffine3) -> Option<Vec<Triangle>> {
    let mesh = scene.meshes.get(part.mesh.index())?;
    let range = mesh.faces.get(face)?;
    // A mirroring transform turns the winding round, but not what is outside.
    let side = if to_world.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    let mut out = Vec::new();
    for index in range.first..range.first.checked_add(range.count)? {
        let mut corners = [DVec3::ZERO; 3];
        for (corner, vertex) in corners.iter_mut().zip(mesh.triangles.get(index as usize)?) {
            let [x, y, z] = *mesh.positions.get(*vertex as usize)?;
            *corner = to_world.transform_point3(DVec3::new(x.into(), y.into(), z.into()));
        }
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        if let Some(normal) = edges[0].cross(edges[1]).try_normalize() {
            out.push(Triangle { origin: corners[0], edges, normal: normal * side, index });
        }
    }
    Some(out)
}

/// All emitting faces of a scene.
#[derive(Debug, Clone, Default)]
pub struct Lamps {
    lamps: Vec<Lamp>,
    /// Per part and face: the lamp.
    of_face: Vec<Vec<Option<u32>>>,
    by_flux: Option<Cdf>,
}

impl Lamps {
    /// `part_to_world`: mesh units of a part → metres in the recentred world frame.
    /// Errors: an emitting face without area or with impossible photometry, named by its part.
    pub fn build(scene: &Scene, part_to_world: &dyn Fn(usize) -> DAffine3) -> Result<Lamps> {
        let mut out = Lamps::default();
        for (index, part) in scene.parts.iter().enumerate() {
            let mut of_face = Vec::new();
            for (face, optics) in part.faces.iter().enumerate() {
                let Some(emitter) = &optics.emitter else { continue };
                of_face.resize(face + 1, None);
                of_face[face] = u32::try_from(out.lamps.len()).ok();
                // The back follows its front.
                let sides: &[f64] = if emitter.both_sides { &[1.0, -1.0] } else { &[1.0] };
                for side in sides {
                    out.lamps.push(Lamp::build(scene, (index, face), emitter, part_to_world(index), *side)?);
                }
            }
            out.of_face.push(of_face);
        }
        out.by_flux = Cdf::new(out.lamps.iter().map(|lamp| lamp.flux_lm));
        if out.by_flux.is_none() && out.lamps.iter().any(|lamp| lamp.flux_lm > 0.0) {
            return Err(Error::new(Where::Nowhere, "the flux of all emitters together is not a finite number"));
        }
        Ok(out)
    }

    pub fn all(&self) -> &[Lamp] {
        &self.lamps
    }
    pub fn get(&self, index: usize) -> Option<&Lamp> {
        self.lamps.get(index)
    }
    /// The lamp that is the back of a face whose front is this one.
    pub fn back_of(&self, front: usize) -> Option<usize> {
        let back = front.checked_add(1)?;
        self.lamps.get(back).is_some_and(|lamp| lamp.back).then_some(back)
    }
    /// The lamp that a face of a part is, or that its front is.
    pub fn of_face(&self, part: usize, face: usize) -> Option<usize> {
        (*self.of_face.get(part)?.get(face)?).map(|index| index as usize)
    }
    /// Flux of all lamps, lm.
    pub fn total_flux_lm(&self) -> f64 {
        self.by_flux.as_ref().map_or(0.0, Cdf::total)
    }

    /// A lamp by its flux, and its probability; none if no lamp has any.
    pub fn pick_by_flux(&self, u: f64) -> Option<(usize, f64)> {
        let by_flux = self.by_flux.as_ref()?;
        let (index, _) = by_flux.sample(u);
        Some((index, by_flux.probability(index)))
    }

    /// A lamp by what it may give to a point, and its probability there; none if no lamp has any flux.
    pub fn pick_for_point(&self, point: DVec3, u: f64) -> Option<(usize, f64)> {
        let by_flux = self.by_flux.as_ref()?;
        let total = self.total_importance(point);
        let index = match total {
            Some(total) if u >= DEFENSIVE => {
                let mut rest = (u - DEFENSIVE) / (1.0 - DEFENSIVE) * total;
                let mut chosen = None;
                for (index, importance) in self.lamps.iter().map(|lamp| lamp.importance(point)).enumerate() {
                    if importance > 0.0 {
                        chosen = Some(index);
                        if rest < importance {
                            break;
                        }
                        rest -= importance;
                    }
                }
                chosen?
            }
            Some(_) => by_flux.sample(u / DEFENSIVE).0,
            None => by_flux.sample(u).0,
        };
        Some((index, self.probability(point, index, total)))
    }

    /// Probability with which [`Lamps::pick_for_point`] picks `index` at `point`.
    pub fn pick_pdf(&self, point: DVec3, index: usize) -> f64 {
        self.probability(point, index, self.total_importance(point))
    }

    /// None where importance cannot be used: a point at infinity, or beyond the range of numbers.
    fn total_importance(&self, point: DVec3) -> Option<f64> {
        let total: f64 = self.lamps.iter().map(|lamp| lamp.importance(point)).sum();
        (total > 0.0 && total.is_finite()).then_some(total)
    }

    fn probability(&self, point: DVec3, index: usize, total: Option<f64>) -> f64 {
        let (Some(by_flux), Some(lamp)) = (&self.by_flux, self.lamps.get(index)) else { return 0.0 };
        let floor = by_flux.probability(index);
        match total {
            Some(total) => DEFENSIVE * floor + (1.0 - DEFENSIVE) * lamp.importance(point) / total,
            None => floor,
        }
    }
}

#[cfg(test)]
#[path = "lamp_tests.rs"]
mod tests;
