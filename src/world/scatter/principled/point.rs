//! The parameters of a standard surface at a place: textures and colours of vertices are read there.

use super::Principled;
use super::energy;
use super::film::FilmLook;
use super::lobe::Stretch;
use super::look::{Look, Tint, facets};
use super::sheen::sheen_alpha;
use crate::geometry::Hit;
use crate::texture::{Coordinates, colour_at, scalar_at};
use eyebox_base::warp::Frame;
use eyebox_scene::{CoatNormal, Mesh, Opacity, StandardSurface};
use glam::{DAffine3, DVec3};

/// A standard surface at a place: its colours in linear Rec.709, its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    pub base: [f64; 3],
    pub specular_color: [f64; 3],
    pub through: [f64; 3],
    pub sheen: [f64; 3],
    pub coat: [f64; 3],
    pub edge: [f64; 3],
    /// What its facets are longer along, and the coat's normal where it has its own: world.
    along: Option<DVec3>,
    coat_normal: Option<DVec3>,
    /// The normal of the body, as the map has it, and the outward one of the face: world.
    body_normal: Option<[DVec3; 2]>,
    rest: Look,
}

/// Shares of the corners of a triangle.
pub(super) type Weights = [f64; 3];

impl Principled {
    /// The surface where a ray has met it.
    pub fn at(&self, hit: &Hit, to_world: &DAffine3) -> Point {
        let coloured = self.surface.vertex_colors && !self.mesh.colors.is_empty();
        let asks = coloured || self.surface.is_textured() || self.surface.anisotropy.is_some();
        let corners = if asks { corners(&self.mesh, hit) } else { None };
        let mut point = match corners {
            None => Point::plain(&self.surface),
            Some((corners, weights)) => {
                let uv = coordinates(&self.mesh, corners, weights);
                let colour = if coloured { of_vertices(&self.mesh, corners, weights) } else { [1.0; 4] };
                let mut point = Point::new(&self.surface, &uv, colour);
                if let Some(anisotropy) = &self.surface.anisotropy {
                    point.along = self.along(anisotropy, (hit, (corners, weights)), to_world, &uv);
                }
                point
            }
        };
        point.body_normal = Some([self.bent_normal(hit, to_world).unwrap_or(hit.shading), hit.normal]);
        if point.rest.coat > 0.0 {
            point.coat_normal = match &self.surface.coat_normal {
                CoatNormal::Base => None,
                CoatNormal::Smooth => self.surface.normal.as_ref().map(|_| hit.shading),
                CoatNormal::Map(input, strength) => {
                    Some(self.mapped(input, *strength, hit, to_world).unwrap_or(hit.shading))
                }
            };
        }
        point
    }

    /// The first set of texture coordinates where a ray has met it; 0 without one.
    pub fn uv(&self, hit: &Hit) -> [f64; 2] {
        corners(&self.mesh, hit).map_or([0.0; 2], |(corners, weights)| coordinates(&self.mesh, corners, weights)[0])
    }
}

/// The triangle that a ray has met, and where in it.
pub(super) fn corners(mesh: &Mesh, hit: &Hit) -> Option<([usize; 3], Weights)> {
    let corners = mesh.triangles.get(hit.site.triangle as usize)?.map(|corner| corner as usize);
    let [a, b, c] = positions(mesh, corners)?;
    // Shares of the area, seen along the triangle's normal.
    let normal = (b - a).cross(c - a);
    let whole = normal.length_squared();
    let share = |p: DVec3, q: DVec3| (p - hit.local).cross(q - hit.local).dot(normal) / whole;
    let weights = [share(b, c), share(c, a), share(a, b)];
    weights.iter().all(|weight| weight.is_finite()).then_some((corners, weights))
}

pub(super) fn positions(mesh: &Mesh, corners: [usize; 3]) -> Option<[DVec3; 3]> {
    let at = |corner: usize| mesh.positions.get(corner).map(|p| DVec3::from(p.map(f64::from)));
    let [a, b, c] = corners.map(at);
    Some([a?, b?, c?])
}

/// What is said at the corners, between them.
pub(super) fn between<const N: usize>(all: &[[f32; N]], corners: [usize; 3], weights: Weights) -> Option<[f64; N]> {
    let [a, b, c] = corners.map(|corner| all.get(corner));
    let (a, b, c) = (a?, b?, c?);
    Some(std::array::from_fn(|i| {
        weights[0] * f64::from(a[i]) + weights[1] * f64::from(b[i]) + weights[2] * f64::from(c[i])
    }))
}

pub(super) fn coordinates(mesh: &Mesh, corners: [usize; 3], weights: Weights) -> Coordinates {
    [&mesh.uvs, &mesh.second_uvs].map(|set| between(set, corners, weights).unwrap_or_default())
}

pub(super) fn of_vertices(mesh: &Mesh, corners: [usize; 3], weights: Weights) -> [f64; 4] {
    between(&mesh.colors, corners, weights).unwrap_or([1.0; 4])
}

impl Point {
    /// Where no texture says anything.
    pub fn plain(surface: &StandardSurface) -> Point {
        // Factors alone: a texture counts as white.
        let strip = |scalar: &eyebox_scene::Scalar| scalar.factor;
        let alpha = match &surface.opacity {
            Opacity::Opaque => 1.0,
            Opacity::Mask { alpha, cutoff } => f64::from(alpha.factor >= *cutoff),
            Opacity::Blend { alpha } => alpha.factor,
        };
        Point::of(surface, &|scalar| strip(scalar), &|colour| colour.factor, [1.0; 4], alpha)
    }

    pub(super) fn new(surface: &StandardSurface, uv: &Coordinates, colour: [f64; 4]) -> Point {
        let alpha = match &surface.opacity {
            Opacity::Opaque => 1.0,
            Opacity::Mask { alpha, cutoff } => f64::from(scalar_at(alpha, uv) * colour[3] >= *cutoff),
            Opacity::Blend { alpha } => scalar_at(alpha, uv) * colour[3],
        };
        Point::of(surface, &|scalar| scalar_at(scalar, uv), &|found| colour_at(found, uv), colour, alpha)
    }

    fn of(
        surface: &StandardSurface,
        number: &dyn Fn(&eyebox_scene::Scalar) -> f64,
        colour: &dyn Fn(&eyebox_scene::Colour) -> [f64; 3],
        [r, g, b, _]: [f64; 4],
        alpha: f64,
    ) -> Point {
        let share = |scalar: &eyebox_scene::Scalar| number(scalar).clamp(0.0, 1.0);
        let shares = |found: &eyebox_scene::Colour| colour(found).map(|c| c.clamp(0.0, 1.0));
        let base = colour(&surface.base_color);
        let white = Tint { base: 1.0, specular: 1.0, through: 1.0, sheen: 1.0, coat: 1.0, edge: 1.0 };
        let alpha_of_facets = facets(share(&surface.roughness));
        let stretch = surface.anisotropy.as_ref().and_then(|anisotropy| {
            let strength = share(&anisotropy.strength);
            let alphas = anisotropy.law.alphas(alpha_of_facets, strength);
            (strength > 0.0).then_some(Stretch { turn: [1.0, 0.0], alphas, strength })
        });
        let film = surface.film.as_ref().and_then(|film| {
            let weight = share(&film.weight);
            let thickness_nm = number(&film.thickness_nm).max(0.0);
            (weight > 0.0).then_some(FilmLook { weight, thickness_nm, lane: [1.0 / 3.0; 3] })
        });
        let sheen = shares(&surface.sheen_color);
        let base = [base[0] * r, base[1] * g, base[2] * b].map(|c| c.clamp(0.0, 1.0));
        Point {
            base,
            // More than 1 is allowed: what it makes of the index ends at 1.
            specular_color: colour(&surface.specular_color).map(|c| c.max(0.0)),
            through: shares(&surface.diffuse_transmission_color),
            sheen,
            coat: shares(&surface.coat_color),
            edge: shares(&surface.metal_edge),
            along: None,
            coat_normal: None,
            body_normal: None,
            rest: Look {
                tint: white,
                mean: white,
                metallic: share(&surface.metallic),
                diffuse_roughness: share(&surface.diffuse_roughness),
                alpha: alpha_of_facets,
                stretch,
                film,
                straight: energy::normal_reflectance(surface.ior),
                specular: share(&surface.specular),
                transmission: share(&surface.transmission),
                diffuse_transmission: share(&surface.diffuse_transmission),
                coat: share(&surface.coat),
                coat_alpha: facets(share(&surface.coat_roughness)),
                coat_normal: None,
                body_normal: None,
                sheen_alpha: sheen_alpha(share(&surface.sheen_roughness)),
                most_sheen: sheen.into_iter().fold(0.0, f64::max),
                opacity: alpha.clamp(0.0, 1.0),
            },
        }
    }

    /// The look in a lane that has these shares of red, green and blue; without any, in the mean of the three.
    pub fn look(&self, lane: Option<[f64; 3]>) -> Look {
        let mixed = |rgb: [f64; 3], shares: [f64; 3]| rgb[0] * shares[0] + rgb[1] * shares[1] + rgb[2] * shares[2];
        let tint = |shares: [f64; 3]| Tint {
            base: mixed(self.base, shares),
            specular: mixed(self.specular_color, shares),
            through: mixed(self.through, shares),
            sheen: mixed(self.sheen, shares),
            coat: mixed(self.coat, shares),
            edge: mixed(self.edge, shares),
        };
        const ALIKE: [f64; 3] = [1.0 / 3.0; 3];
        let mean = tint(ALIKE);
        let film = self.rest.film.map(|film| FilmLook { lane: lane.unwrap_or(ALIKE), ..film });
        Look { tint: lane.map_or(mean, tint), mean, film, ..self.rest }
    }

    /// Turned into the local frame about this normal.
    #[must_use]
    pub fn seen_about(&self, normal: DVec3) -> Point {
        let mut out = *self;
        // What a ray sees its facets about is pulled up for it; what scatters below them is not.
        let body = self.body_normal.map(|[body, face]| if normal.dot(face) < 0.0 { -body } else { body });
        let body = body.filter(|body| *body != normal);
        if self.along.is_none() && self.coat_normal.is_none() && body.is_none() {
            return out;
        }
        let frame = Frame::about(normal);
        if let (Some(along), Some(stretch)) = (self.along, &mut out.rest.stretch) {
            let local = frame.to_local(along);
            let length = local.x.hypot(local.y);
            if length > 0.0 {
                stretch.turn = [local.x / length, local.y / length];
            }
        }
        out.rest.body_normal = body.map(|body| frame.to_local(body));
        // On the side that is looked at.
        out.rest.coat_normal = self.coat_normal.map(|coat| {
            let local = frame.to_local(coat);
            if local.z < 0.0 { -local } else { local }
        });
        out
    }

    /// Share of light falling straight on that is scattered, linear Rec.709.
    pub fn albedo(&self, principled: &Principled) -> [f64; 3] {
        let primaries = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        primaries.map(|lane| principled.scatters(DVec3::Z, &self.look(Some(lane))))
    }
}
