//! What an ordinary material leaves of the light of a face that emits: nothing where it is cut out, a share where it is blended,
//! and what a coat and a sheen above it do not keep (KHR_materials_clearcoat, OpenPBR 1.1: emission lies below both).

use super::geometry::{Hit, Site};
use super::glow::{Glow, places};
use super::lamp::LampPoint;
use super::scatter::Principled;
use eyebox_base::colour::luminance;
use eyebox_base::ids::SurfaceId;
use eyebox_base::warp::Frame;
use eyebox_scene::{Opacity, Part, Scene, StandardSurface};
use glam::{DAffine3, DMat3, DVec3};

/// The least mean of an opacity that is not the same everywhere: a hole too small for all the places that are looked at still
/// lets light out.
const LEAST: f64 = 1e-4;

/// The material of a face that emits.
#[derive(Debug, Clone)]
pub struct Veil {
    principled: Principled,
    part: u32,
    face: u32,
    to_world: DAffine3,
    to_local: DAffine3,
    /// Of normals.
    turn: DMat3,
    /// 1 for the front, −1 for the back.
    side: f64,
    /// Share of the light that its opacity leaves.
    mean: f64,
    /// Its opacity is not the same everywhere.
    is_cut: bool,
    /// A coat or a sheen lies over the light.
    is_covered: bool,
    /// Anything of it is not the same everywhere.
    is_patterned: bool,
}

/// Whether a coat or a sheen may keep some of the light from below.
fn covers(surface: &StandardSurface) -> bool {
    surface.coat.factor > 0.0 || surface.sheen_color.factor.iter().any(|c| *c > 0.0)
}

impl Veil {
    /// Of a face with the finish of an ordinary material; none where that lets out all light. `glow`: the texture that the light
    /// shines through, if any.
    pub fn build(
        scene: &Scene,
        (index, face): (usize, usize),
        (to_world, side): (DAffine3, f64),
        glow: Option<&Glow>,
        (triangles, areas): (&[u32], &[f64]),
    ) -> Option<Box<Veil>> {
        let part: &Part = scene.parts.get(index)?;
        let surface: SurfaceId = part.faces.get(face)?.finish.surface()?;
        let surface = scene.surfaces.get(surface.index())?.clone();
        let is_covered = covers(&surface);
        if surface.opacity == Opacity::Opaque && !is_covered {
            return None;
        }
        let mesh = scene.meshes.get(part.mesh.index())?.clone();
        let by_vertices = surface.vertex_colors && mesh.colors.iter().any(|[.., alpha]| *alpha != 1.0);
        let is_cut = match &surface.opacity {
            Opacity::Opaque => false,
            Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => alpha.texture.is_some() || by_vertices,
        };
        let over = [&surface.coat, &surface.coat_roughness, &surface.sheen_roughness];
        let is_patterned = is_cut
            || is_covered
                && (over.iter().any(|scalar| scalar.texture.is_some())
                    || [&surface.sheen_color, &surface.coat_color].iter().any(|colour| colour.texture.is_some())
                    || surface.coat_normal.map().is_some()
                    || surface.normal.is_some());
        let mut veil = Veil {
            principled: Principled::new(surface, mesh),
            part: u32::try_from(index).ok()?,
            face: u32::try_from(face).ok()?,
            to_world,
            to_local: to_world.inverse(),
            turn: to_world.matrix3.inverse().transpose(),
            side,
            mean: 1.0,
            is_cut,
            is_covered,
            is_patterned,
        };
        veil.mean = veil.mean_of(glow, (triangles, areas));
        Some(Box::new(veil))
    }

    /// Share of the light of all triangles that the opacity leaves.
    fn mean_of(&self, glow: Option<&Glow>, (triangles, areas): (&[u32], &[f64])) -> f64 {
        if !self.is_cut {
            return self.principled.plain_opacity();
        }
        let (mut sum, mut whole) = (0.0, 0.0);
        for (at, weights, area) in places(areas) {
            let [r, g, b] = glow.map_or([1.0; 3], |glow| glow.at(at, weights));
            let bright = area * luminance([r, g, b]);
            let opacity = triangles.get(at).map_or(0.0, |triangle| self.principled.opacity_at(*triangle, weights));
            (sum, whole) = (sum + bright * opacity, whole + bright);
        }
        let mean = if whole > 0.0 { sum / whole } else { 0.0 };
        mean.max(LEAST)
    }

    /// Share of the light of the whole that its opacity leaves.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Whether it leaves the same share of the light of all places in all directions.
    pub fn is_even(&self) -> bool {
        !self.is_cut && !self.is_covered
    }

    /// Whether it has a pattern of its own.
    pub fn is_patterned(&self) -> bool {
        self.is_patterned
    }

    /// What it leaves of the light of a place along a unit direction, linear Rec.709, over the mean of its opacity.
    pub fn at(&self, place: &LampPoint, dir: DVec3) -> [f64; 3] {
        let site = Site { part: self.part, face: self.face, triangle: place.triangle };
        let local = self.to_local.transform_point3(place.position);
        let outward = place.normal * self.side;
        let mut hit = Hit { t: 0.0, site, point: place.position, local, normal: outward, shading: outward };
        if let Some(smooth) = self.principled.interpolated(&hit)
            && let Some(normal) = (self.turn * smooth).try_normalize()
        {
            hit.shading = if normal.dot(hit.normal) < 0.0 { -normal } else { normal };
        }
        let point = self.principled.at(&hit, &self.to_world);
        let share = if self.mean > 0.0 { point.look(None).opacity / self.mean } else { 0.0 };
        if !self.is_covered {
            return [share; 3];
        }
        let normal = self.principled.shading(&hit, dir, &self.to_world) * self.side;
        let (point, w) = (point.seen_about(normal), Frame::about(normal).to_local(dir));
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|lane| share * self.principled.lets_out(w, &point.look(Some(lane))))
    }
}
