//! A height over a plane as an exact surface: aspheres, toroids, polynomials and Zernike surfaces.

use super::Gradient;
use super::height::Height;
use super::isolate::{Bent, roots};
use super::number::{InPlane, Interval, Num, Series, Slope};
use crate::geometry::bound::Bounds;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Axes of a surface at its vertex: unit, orthogonal, right-handed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    pub vertex: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub axis: DVec3,
}

impl Frame {
    /// None if the axis is zero or x is along it.
    pub fn new(vertex: DVec3, axis: DVec3, x: DVec3) -> Option<Frame> {
        let axis = axis.try_normalize()?;
        let x = x.try_normalize()?;
        let across = x - x.dot(axis) * axis;
        // Beyond the rounding of f32 files the direction is known.
        let x = (across.length() > 1e-6).then(|| across.normalize())?;
        vertex.is_finite().then_some(Frame { vertex, x, y: axis.cross(x), axis })
    }
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.turned(p - self.vertex)
    }
    pub fn turned(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.axis))
    }
    /// Frame → mesh directions.
    pub fn turn(&self) -> DMat3 {
        DMat3::from_cols(self.x, self.y, self.axis)
    }
    pub fn back(&self, v: DVec3) -> DVec3 {
        v.x * self.x + v.y * self.y + v.z * self.axis
    }
}

/// Where a face lies on its surface, and how strongly it bends there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    /// Around the face in the frame.
    bounds: Bounds,
    /// Squared distance of the face's farthest point from the axis.
    reach2: f64,
    /// Bounds of the first, second and third derivative along any unit vector of the plane.
    slope: f64,
    bend: f64,
    twist: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Sag {
    pub frame: Frame,
    height: Height,
    window: Window,
}

/// Steeper faces than about 100 (base conic) are refused: there the height says nothing about the surface.
const LEAST_UNDER_ROOT: f64 = 1e-4;

impl Sag {
    /// The surface over the places of `points` (of the face, mesh units). Faults in words: a height that is not defined
    /// or not finite everywhere over the box of the points, within their largest distance from the axis.
    pub fn new(frame: Frame, height: Height, points: impl Iterator<Item = DVec3>) -> Result<Sag, String> {
        let (mut lo, mut hi, mut reach2) = (DVec2::INFINITY, DVec2::NEG_INFINITY, 0.0f64);
        for p in points {
            let q = frame.local(p).truncate();
            (lo, hi, reach2) = (lo.min(q), hi.max(q), reach2.max(q.length_squared()));
        }
        // More than the rounding of points that are put on the face.
        let pad = 1e-9 * (hi - lo).max_element() + 1e-13 * lo.abs().max(hi.abs()).max_element();
        let (lo, hi) = (lo - pad, hi + pad);
        let reach = reach2.sqrt() + pad;
        let reach2 = reach * reach;
        let edge = height.under_root(reach2);
        if !(lo.is_finite() && hi.is_finite() && edge >= LEAST_UNDER_ROOT) {
            return Err(format!("the face reaches {reach:e} from the axis, where its shape has no height"));
        }
        let window = bounded(&height, lo, hi, reach2)
            .ok_or_else(|| "its shape has no finite height and slope on all of the face".to_owned())?;
        Ok(Sag { frame, height, window })
    }

    pub fn same(&self, other: &Sag) -> bool {
        self.frame == other.frame && self.height == other.height
    }

    /// Height, and its derivatives along x and y.
    fn gradient(&self, q: DVec3) -> (f64, f64, f64) {
        let InPlane { value, by } =
            self.height.at(InPlane { value: q.x, by: DVec2::X }, InPlane { value: q.y, by: DVec2::Y });
        (value, by.x, by.y)
    }

    /// (−h_x, −h_y, 1), and by how much it changes: minus the second derivatives of the height.
    pub fn bending(&self, p: DVec3) -> Gradient {
        let q = self.frame.local(p);
        let along =
            |dx: f64, dy: f64| self.height.at(Series::<f64, 3>::line(q.x, dx), Series::<f64, 3>::line(q.y, dy)).0;
        let ([_, x, xx], [_, y, yy], [_, _, both]) = (along(1.0, 0.0), along(0.0, 1.0), along(1.0, 1.0));
        // The second coefficient along (1, 1) is (h_xx + 2 h_xy + h_yy)/2.
        let mixed = both - xx - yy;
        let change =
            DMat3::from_cols(DVec3::new(-2.0 * xx, -mixed, 0.0), DVec3::new(-mixed, -2.0 * yy, 0.0), DVec3::ZERO);
        let turn = self.frame.turn();
        Gradient { vector: self.frame.back(DVec3::new(-x, -y, 1.0)), change: turn * change * turn.transpose() }
    }

    /// Unit normal at a point of the surface, on the side of the axis.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        let (_, x, y) = self.gradient(self.frame.local(p));
        self.frame.back(DVec3::new(-x, -y, 1.0)).normalize_or(self.frame.axis)
    }

    /// The point of the surface nearest to one that is off by rounding.
    pub fn settle(&self, p: DVec3) -> DVec3 {
        let q = self.frame.local(p);
        let (z, x, y) = self.gradient(q);
        let n = DVec3::new(-x, -y, 1.0);
        let settled = p - self.frame.back(n * ((q.z - z) / n.length_squared()));
        if settled.is_finite() { settled } else { p }
    }

    /// Distance of a point from the surface to first order.
    pub fn distance(&self, p: DVec3) -> f64 {
        let q = self.frame.local(p);
        let (z, x, y) = self.gradient(q);
        (q.z - z).abs() / DVec3::new(-x, -y, 1.0).length()
    }

    /// A box around what lies over a triangle: see `bound::patch_box` for the error of interpolation.
    pub fn patch_box(&self, triangle: [DVec3; 3]) -> Bounds {
        let on = triangle.map(|p| {
            let q = self.frame.local(p);
            self.frame.vertex + self.frame.back(q.truncate().extend(self.height.at(q.x, q.y)))
        });
        let flat = triangle.map(|p| self.frame.local(p).truncate());
        let edge2 = (0..3).map(|i| flat[i].distance_squared(flat[(i + 1) % 3])).fold(0.0, f64::max);
        let around = Bounds::of(on);
        let error = self.window.bend * edge2 / 6.0;
        around.widen(error * self.frame.axis.abs() + DVec3::splat(1e-12 * around.reach()))
    }

    /// Calls `visit` with t and the point of every place over the face where the line origin + t·dir meets the surface
    /// at 0 < t < reach, ascending, until it breaks. `from_surface`: the origin lies on the surface, that root is
    /// divided out.
    pub fn along(
        &self,
        origin: DVec3,
        dir: DVec3,
        from_surface: bool,
        reach: f64,
        visit: &mut impl FnMut(f64, DVec3) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (o, d) = (self.frame.local(origin), self.frame.turned(dir));
        let Some((near, far)) = self.clip(o, d).filter(|(near, _)| *near < reach) else {
            return ControlFlow::Continue(());
        };
        // What is searched does not depend on the reach, so that every question gets the same bits.
        let mut met = |t: f64, at: DVec3| match t > 0.0 {
            true if t >= reach => ControlFlow::Break(()),
            true => visit(t, at),
            false => ControlFlow::Continue(()),
        };
        let flat2 = d.x * d.x + d.y * d.y;
        let noise = 4.0 * f64::EPSILON * (1.0 + self.window.slope);
        let size = self.window.bounds.reach();
        // Started elsewhere on the surface, the face has no root to divide out; started over it, all of the way is.
        if from_surface && near == 0.0 {
            // Values are slopes, of which the second derivative is a third of the third of the height at most.
            let bend = self.window.twist * flat2 * flat2.sqrt() / 3.0;
            // At the start it is that of the surface itself, from which it moves by half of what that bends at most.
            let start = d.z - self.height.at(Series([o.x, d.x]), Series([o.y, d.y])).0[1];
            if start.abs() > 0.5 * self.window.bend * flat2 * far * (1.0 + 1e-9) + noise {
                return ControlFlow::Continue(());
            }
            let ray = Left { sag: self, o, d, bend, noise };
            return roots(&ray, 0.0, far, &mut |t| met(t, origin + t * dir));
        }
        // Near the face a distant origin costs no more digits.
        let base = origin + near * dir;
        let ray =
            Met { sag: self, o: self.frame.local(base), d, bend: self.window.bend * flat2, noise: noise * size, size };
        roots(&ray, 0.0, far - near, &mut |s| met(near + s, base + s * dir))
    }

    /// Between which parameters ≥ 0 the line is in the face's box and no farther from the axis than the face.
    fn clip(&self, o: DVec3, d: DVec3) -> Option<(f64, f64)> {
        let (mut near, mut far) = self.window.bounds.clip(o, d.recip())?;
        let (o, d) = (o.truncate(), d.truncate());
        let (a, b) = (d.length_squared(), o.dot(d));
        // About the point that is nearest to the axis, where nothing cancels.
        let foot = o - (b / a) * d;
        let under = (self.window.reach2 - foot.length_squared()) / a;
        if under.is_finite() && a > 0.0 {
            let half = under.max(0.0).sqrt();
            (near, far) = (near.max(-b / a - half), far.min(-b / a + half));
            if under < 0.0 {
                return None;
            }
        }
        (near < far).then_some((near, far))
    }
}

/// Height of a line over the surface.
struct Met<'a> {
    sag: &'a Sag,
    o: DVec3,
    d: DVec3,
    bend: f64,
    noise: f64,
    size: f64,
}

impl Bent for Met<'_> {
    #[inline]
    fn at(&self, t: f64) -> (f64, f64) {
        let p = self.o + t * self.d;
        let [z, slope] = self.sag.height.at(Series([p.x, self.d.x]), Series([p.y, self.d.y])).0;
        (p.z - z, self.d.z - slope)
    }
    fn bend(&self) -> f64 {
        self.bend
    }
    fn noise(&self) -> f64 {
        self.noise
    }
    fn grain(&self, t: f64) -> f64 {
        0.25 * f64::EPSILON * (t.abs() + self.size)
    }
}

/// The same over t, for a line that starts on the surface.
struct Left<'a> {
    sag: &'a Sag,
    o: DVec3,
    d: DVec3,
    bend: f64,
    noise: f64,
}

impl Bent for Left<'_> {
    #[inline]
    fn at(&self, t: f64) -> (f64, f64) {
        let p = self.o + t * self.d;
        let line =
            |start: f64, at: f64, slope: f64| Slope { start, at: Series([at, slope]), slope: Series([slope, 0.0]) };
        let z = self.sag.height.at(line(self.o.x, p.x, self.d.x), line(self.o.y, p.y, self.d.y));
        let [slope, change] = z.slope.0;
        (self.d.z - slope, -change)
    }
    fn bend(&self) -> f64 {
        self.bend
    }
    fn noise(&self) -> f64 {
        self.noise
    }
    fn grain(&self, t: f64) -> f64 {
        f64::EPSILON * t.abs()
    }
}

/// Cells along each side of the box that heights are bounded over.
const CELLS: u32 = 16;
/// Directions in half a turn along which derivatives are bounded.
const DIRECTIONS: u32 = 8;
/// How often a cell is cut in four where a height is not defined on all of it.
const FINER: u32 = 8;

/// Bounds over the part of the box that is within the reach; none if there is a place without.
fn bounded(height: &Height, lo: DVec2, hi: DVec2, reach2: f64) -> Option<Window> {
    let cells = if height.terms() > 100 { CELLS / 2 } else { CELLS };
    let side = (hi - lo) / f64::from(cells);
    let mut open: Vec<(DVec2, DVec2, u32)> = Vec::new();
    for i in 0..cells {
        for j in 0..cells {
            let corner = lo + side * DVec2::new(f64::from(i), f64::from(j));
            open.push((corner, corner + side, 0));
        }
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut most = [0.0f64; 3];
    while let Some((a, b, depth)) = open.pop() {
        if DVec2::ZERO.clamp(a, b).length_squared() > reach2 {
            continue;
        }
        match over_cell(height, a, b) {
            Some((z, derivatives)) => {
                (low, high) = (low.min(z.lo), high.max(z.hi));
                most = std::array::from_fn(|k| most[k].max(derivatives[k]));
            }
            None if depth < FINER => {
                let middle = 0.5 * (a + b);
                for (from, to) in [
                    (a, middle),
                    (middle, b),
                    (DVec2::new(middle.x, a.y), DVec2::new(b.x, middle.y)),
                    (DVec2::new(a.x, middle.y), DVec2::new(middle.x, b.y)),
                ] {
                    open.push((from, to, depth + 1));
                }
            }
            None => return None,
        }
    }
    let pad = 1e-9 * ((high - low) + (hi - lo).max_element()) + 1e-12 * low.abs().max(high.abs());
    let bounds = Bounds { lo: lo.extend(low - pad), hi: hi.extend(high + pad) };
    // A trigonometric polynomial of degree k sampled at n places of a whole turn is at most 1/cos(kπ/n) times the
    // largest sample (H. Ehlich and K. Zeller, Math. Z. 86, 1964).
    let between = |k: f64| 1.0 / (k * PI / f64::from(2 * DIRECTIONS)).cos() * (1.0 + 1e-9);
    let [slope, bend, twist] = [most[0] * between(1.0), most[1] * between(2.0), most[2] * between(3.0)];
    let finite = bounds.is_finite() && slope.is_finite() && bend.is_finite() && twist.is_finite();
    finite.then_some(Window { bounds, reach2, slope, bend, twist })
}

/// The range of the height over a cell, and the largest derivatives along the directions; none if not all are finite.
fn over_cell(height: &Height, a: DVec2, b: DVec2) -> Option<(Interval, [f64; 3])> {
    let (x, y) = (Interval { lo: a.x, hi: b.x }, Interval { lo: a.y, hi: b.y });
    let mut most = [0.0f64; 3];
    let mut range = Interval::NONE;
    for k in 0..DIRECTIONS {
        let (sin, cos) = (PI * f64::from(k) / f64::from(DIRECTIONS)).sin_cos();
        let along = |at: Interval, by: f64| Series::<Interval, 4>::line(at, Interval::of(by));
        let z = height.at(along(x, cos), along(y, sin)).0;
        if !z.iter().all(|z| z.is_finite()) {
            return None;
        }
        range = z[0];
        most =
            [most[0].max(z[1].magnitude()), most[1].max(2.0 * z[2].magnitude()), most[2].max(6.0 * z[3].magnitude())];
    }
    Some((range, most))
}
