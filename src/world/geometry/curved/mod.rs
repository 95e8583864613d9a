//! Exact surfaces beyond quadrics of revolution: cylinders and tori as wholes, and heights over a plane.

mod height;
mod isolate;
mod number;
mod round;
mod sag;
mod spline;

#[cfg(test)]
mod tests;

use super::bound::Bounds;
use super::patch::Shear;
use eyebox_scene::Shape;
use glam::{DMat3, DVec3};
use height::{Height, orders};
use round::{Cylinder, Torus, signed_circle};
use sag::{Frame, Sag};
use spline::Spline;
use std::ops::ControlFlow;

/// A gradient and how it changes along the surface.
#[derive(Debug, Clone, Copy)]
pub struct Gradient {
    pub vector: DVec3,
    pub change: DMat3,
}

/// An exact surface and which of its points belong to which triangle of its face.
#[derive(Debug, Clone, PartialEq)]
pub struct Curved {
    form: Form,
    /// Lines along the axis share a height field out among the triangles; without them it is lines from the axis of a
    /// cylinder or the middle of a torus' tube.
    pub shear: Option<Shear>,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    Cylinder(Cylinder),
    Torus(Torus),
    Sag(Box<Sag>),
}

/// As [`Projection`](super::patch::Projection): height fields keep away from where a line along the axis grazes.
const MARGIN: f64 = 0.25;

impl Curved {
    /// The surface of a shape over the places of a face's vertices, mesh units. None for shapes that are a
    /// [`Quadric`](super::exact::Quadric) or the mesh. Faults in words: parameters that describe no surface, a face
    /// that reaches where the shape has no height.
    pub fn new(shape: &Shape, points: impl Iterator<Item = DVec3> + Clone) -> Result<Option<Curved>, String> {
        let none = || format!("{shape:?} is no surface");
        let frame = |vertex: &DVec3, axis: &DVec3, x: &DVec3| Frame::new(*vertex, *axis, *x).ok_or_else(none);
        let per = |radius: f64| Some(1.0 / radius).filter(|c| c.is_finite() && *c != 0.0).ok_or_else(none);
        let finite = |all: &[f64]| if all.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(none()) };
        let over = |frame: Frame, height: Height| -> Result<Option<Curved>, String> {
            let sag = Sag::new(frame, height, points.clone())?;
            Ok(Some(Curved { form: Form::Sag(Box::new(sag)), shear: Some(Shear::along(frame.axis)) }))
        };
        match shape {
            Shape::Mesh | Shape::Plane { .. } | Shape::Sphere { .. } | Shape::Conic { .. } => Ok(None),
            Shape::Asphere { vertex, axis, radius, conic, even } => {
                finite(&[*conic])?;
                finite(even)?;
                let x = Shape::default_x(axis.normalize_or(DVec3::Z));
                over(
                    frame(vertex, axis, &x)?,
                    Height::Even { curvature: per(*radius)?, conic: *conic, even: even.clone() },
                )
            }
            Shape::XyPoly { vertex, axis, x, radius, conic, coeffs } => {
                finite(&[*conic])?;
                finite(coeffs)?;
                let height = Height::Poly { curvature: per(*radius)?, conic: *conic, coeffs: coeffs.clone() };
                over(frame(vertex, axis, x)?, height)
            }
            Shape::Zernike { vertex, axis, x, radius, conic, norm_radius, coeffs } => {
                finite(&[*conic])?;
                finite(coeffs)?;
                let scale = per(*norm_radius)?;
                let height = Height::Zernike { curvature: per(*radius)?, conic: *conic, scale, orders: orders(coeffs) };
                over(frame(vertex, axis, x)?, height)
            }
            Shape::Bspline { vertex, axis, x, radius, conic, half, spans, coeffs } => {
                finite(&[*conic])?;
                finite(coeffs)?;
                let spline = Spline::new(*half, *spans, coeffs).ok_or_else(|| {
                    let [a, b] = spans.map(|n| u64::from(n) + 3);
                    format!("a bspline of {} coefficients; its spans take {a} x {b}", coeffs.len())
                })?;
                over(frame(vertex, axis, x)?, Height::Spline { curvature: per(*radius)?, conic: *conic, spline })
            }
            Shape::Cylinder { vertex, axis, x, radius } => {
                let cylinder = Cylinder { frame: frame(vertex, axis, x)?, curvature: per(*radius)? };
                let c = cylinder.curvature;
                let level = points.clone().all(|p| {
                    let q = cylinder.frame.local(p);
                    1.0 - c * q.z > MARGIN && 1.0 - c * c * q.y * q.y > MARGIN
                });
                let shear = level.then(|| Shear::along(cylinder.frame.axis));
                Ok(Some(Curved { form: Form::Cylinder(cylinder), shear }))
            }
            Shape::Toroid { vertex, axis, x, radius, tube_radius } => {
                let frame = frame(vertex, axis, x)?;
                let (c, tube) = (per(*radius)?, per(*tube_radius)?);
                let level = points.clone().all(|p| {
                    let q = frame.local(p);
                    let z = signed_circle(c, q.y, q.z) * 0.5;
                    let lift = 1.0 - c * z;
                    1.0 - c * q.z > MARGIN
                        && 1.0 - tube * z > MARGIN
                        && 1.0 - tube * tube * q.x * q.x > MARGIN
                        && lift * lift * (1.0 - MARGIN) > c * c * q.y * q.y
                });
                let torus = || Torus::new(frame, *radius, *tube_radius);
                let sag = if level { over(frame, Height::Torus { curvature: c, tube }) } else { Ok(None) };
                match (sag, torus()) {
                    (Ok(Some(found)), _) => Ok(Some(found)),
                    (_, Some(torus)) => Ok(Some(Curved { form: Form::Torus(torus), shear: None })),
                    (Err(why), None) => Err(why),
                    (Ok(None), None) => {
                        Err("the face reaches around a torus that crosses itself: |radius − tube_radius| \
                                             is not above |tube_radius|"
                            .to_owned())
                    }
                }
            }
        }
    }

    /// Whether two faces are parts of one surface, wherever they lie on it.
    pub fn same(&self, other: &Curved) -> bool {
        match (&self.form, &other.form) {
            (Form::Cylinder(a), Form::Cylinder(b)) => a == b,
            (Form::Torus(a), Form::Torus(b)) => a == b,
            (Form::Sag(a), Form::Sag(b)) => a.same(b),
            (Form::Cylinder(_) | Form::Torus(_) | Form::Sag(_), _) => false,
        }
    }

    /// Calls `visit` with t and the point of each place where the line origin + t·dir meets the surface (of a height
    /// field the part over the face) at 0 < t < reach, ascending, until it breaks. `from_surface`: the origin lies on
    /// the surface, that root is divided out.
    pub fn along(
        &self,
        origin: DVec3,
        dir: DVec3,
        from_surface: bool,
        reach: f64,
        visit: &mut impl FnMut(f64, DVec3) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match &self.form {
            Form::Sag(sag) => sag.along(origin, dir, from_surface, reach, visit),
            Form::Torus(torus) => torus.along(origin, dir, from_surface, reach, visit),
            Form::Cylinder(cylinder) => {
                for t in cylinder.intersect(origin, dir, from_surface) {
                    let at = origin + t * dir;
                    if t > 0.0 && t < reach && (self.shear.is_none() || cylinder.branch(at) > 0.0) {
                        visit(t, at)?;
                    }
                }
                ControlFlow::Continue(())
            }
        }
    }

    /// Whether the triangle is the one that the point of the surface belongs to.
    pub fn belongs(&self, at: DVec3, triangle: &[[f32; 3]; 3]) -> bool {
        // From the axis or the middle of the tube through the point: up to where the tube may be met again on the far
        // side of its ring, in units of the tube's radius 2·ring − 1, half of the way from 1.
        let (foot, most) = match (&self.shear, &self.form) {
            (Some(shear), _) => return shear.cross(triangle, at).is_some(),
            (None, Form::Sag(_)) => return false,
            (None, Form::Cylinder(cylinder)) => (cylinder.foot(at), f64::INFINITY),
            (None, Form::Torus(torus)) => (torus.foot(at), torus.ring() / torus.tube.abs()),
        };
        Shear::along(at - foot).cross(triangle, foot).is_some_and(|crossing| {
            // `crossing.t` counts lengths of a direction whose largest component is that of at − foot.
            crossing.t > 0.0 && crossing.t < most
        })
    }

    /// Unit normal at a point of the surface; it is the axis at the vertex.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        match &self.form {
            Form::Cylinder(cylinder) => cylinder.normal(p),
            Form::Torus(torus) => torus.normal(p),
            Form::Sag(sag) => sag.normal(p),
        }
    }

    /// A vector along the normal, and how it changes along the surface.
    pub fn gradient(&self, p: DVec3) -> Gradient {
        match &self.form {
            Form::Cylinder(cylinder) => cylinder.gradient(p),
            Form::Torus(torus) => torus.gradient(p),
            Form::Sag(sag) => sag.bending(p),
        }
    }

    /// The point of the surface nearest to one that is off by rounding.
    pub fn settle(&self, p: DVec3) -> DVec3 {
        match &self.form {
            Form::Cylinder(cylinder) => cylinder.settle(p),
            Form::Torus(torus) => torus.settle(p),
            Form::Sag(sag) => sag.settle(p),
        }
    }

    /// Distance of a point from the surface, of a height field to first order.
    pub fn distance(&self, p: DVec3) -> f64 {
        match &self.form {
            Form::Cylinder(cylinder) => cylinder.distance(p),
            Form::Torus(torus) => torus.distance(p),
            Form::Sag(sag) => sag.distance(p),
        }
    }

    /// A box of the patch that a triangle stands for.
    ///
    /// On cylinders and tori a point of the patch is as far from the triangle as the triangle is from the surface there:
    /// as its corners are, and the error h² M/6 of interpolating the distance, whose second derivative is at most twice
    /// the largest curvature near the surface. Along the axis of a flat cylinder the way is at most twice as long.
    /// Triangles that are coarse against the curvature take the whole tube.
    pub fn patch_box(&self, triangle: [DVec3; 3]) -> Bounds {
        let (sharpest, whole) = match &self.form {
            Form::Sag(sag) => return sag.patch_box(triangle),
            Form::Cylinder(cylinder) => (cylinder.curvature.abs(), 2.0 / cylinder.curvature.abs()),
            Form::Torus(torus) => (torus.sharpest(), 2.0 * torus.size()),
        };
        let around = Bounds::of(triangle);
        let edge2 = (0..3).map(|i| triangle[i].distance_squared(triangle[(i + 1) % 3])).fold(0.0, f64::max);
        let off = triangle.iter().map(|p| self.distance(*p)).fold(0.0, f64::max);
        let fine = sharpest * edge2.sqrt() < 0.5 && sharpest * off < 0.25;
        let pad = if fine { 2.0 * (off + sharpest * edge2 / 3.0) } else { whole + 2.0 * off };
        around.widen(DVec3::splat(pad + 1e-12 * around.reach()))
    }
}
