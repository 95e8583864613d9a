//! Synthetic freeforms with f32 vertices in turned frames: the oracle is the closed form that made the points.

use crate::fit::{Fit, FitError, Fitted, Kind, fit};
use glam::{DQuat, DVec3, EulerRot};

/// A mesh of (nu + 1) × (nv + 1) points over a rectangle of half sizes, squeezed into its ellipse for `disc`.
struct Patch<'a> {
    height: &'a dyn Fn(f64, f64) -> f64,
    half: [f64; 2],
    counts: [u32; 2],
    disc: bool,
    turn: DQuat,
    shift: DVec3,
}

impl Patch<'_> {
    fn new(height: &dyn Fn(f64, f64) -> f64, half: [f64; 2], counts: [u32; 2]) -> Patch<'_> {
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.7, -1.9, 2.6);
        Patch { height, half, counts, disc: false, turn, shift: DVec3::new(312.0, -150.0, -730.0) }
    }

    fn place(&self, s: f64, t: f64) -> [f64; 2] {
        let round = |s: f64, t: f64| if self.disc { s * (1.0 - t * t / 2.0).sqrt() } else { s };
        [self.half[0] * round(s, t), self.half[1] * round(t, s)]
    }

    fn point(&self, x: f64, y: f64, off: f64) -> DVec3 {
        self.turn * DVec3::new(x, y, (self.height)(x, y) + off) + self.shift
    }

    /// `off(x, y, on the rim, number)` moves points along the axis.
    fn mesh(&self, off: impl Fn(f64, f64, bool, u32) -> f64) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let [nu, nv] = self.counts;
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for j in 0..=nv {
            for i in 0..=nu {
                let to = |k: u32, n: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
                let [x, y] = self.place(to(i, nu), to(j, nv));
                let rim = i == 0 || j == 0 || i == nu || j == nv;
                points.push(self.point(x, y, off(x, y, rim, j * (nu + 1) + i)).as_vec3().to_array());
            }
        }
        for j in 0..nv {
            for i in 0..nu {
                let a = j * (nu + 1) + i;
                triangles.extend([[a, a + 1, a + nu + 2], [a, a + nu + 2, a + nu + 1]]);
            }
        }
        (points, triangles)
    }

    /// How far the surface is off at 30 × 30 places inside: root mean square and most of the distance (mesh units) and of
    /// the slope.
    fn errors(&self, fit: &Fit) -> [[f64; 2]; 2] {
        let mut out = [[0.0f64; 2]; 2];
        let n = 30;
        for i in 0..n {
            for j in 0..n {
                let to = |k: i32| 0.97 * (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0);
                let [x, y] = self.place(to(i), to(j));
                let h = 1e-3 * self.half[1];
                let off = |x: f64, y: f64| distance(&fit.surface, self.point(x, y, 0.0));
                let slope = (off(x + h, y) - off(x - h, y)).hypot(off(x, y + h) - off(x, y - h)) / (2.0 * h);
                for (slot, e) in out.iter_mut().zip([off(x, y), slope]) {
                    *slot = [slot[0] + e * e, slot[1].max(e.abs())];
                }
            }
        }
        out.map(|[sum, most]| [(sum / f64::from(n * n)).sqrt(), most])
    }
}

/// Distance to first order from the surface that the numbers name, by the formulas of the reference.
fn distance(surface: &Fitted, p: DVec3) -> f64 {
    let (vertex, axis, x) = match surface {
        Fitted::Asphere { vertex, axis, .. } => (*vertex, *axis, axis.any_orthonormal_vector()),
        Fitted::XyPoly { vertex, axis, x, .. }
        | Fitted::Zernike { vertex, axis, x, .. }
        | Fitted::Bspline { vertex, axis, x, .. } => (*vertex, *axis, *x),
        Fitted::Plane { .. }
        | Fitted::Sphere { .. }
        | Fitted::Conic { .. }
        | Fitted::Cylinder { .. }
        | Fitted::Toroid { .. } => panic!("no freeform: {surface:?}"),
    };
    let (q, y) = (p - vertex, axis.cross(x));
    let (u, v) = (q.dot(x), q.dot(y));
    let h = 1e-4;
    let at = |u: f64, v: f64| sag(surface, u, v);
    let slope = (at(u + h, v) - at(u - h, v)).hypot(at(u, v + h) - at(u, v - h)) / (2.0 * h);
    (q.dot(axis) - at(u, v)) / slope.hypot(1.0)
}

fn conic_sag(radius: f64, k: f64, r2: f64) -> f64 {
    let c = 1.0 / radius;
    c * r2 / (1.0 + (1.0 - (1.0 + k) * c * c * r2).sqrt())
}

fn sag(surface: &Fitted, x: f64, y: f64) -> f64 {
    let r2 = x * x + y * y;
    match surface {
        Fitted::Asphere { radius, conic, even, .. } => {
            let powers = even.iter().enumerate().map(|(i, a)| a * r2.powi(i as i32 + 1));
            conic_sag(*radius, *conic, r2) + powers.sum::<f64>()
        }
        Fitted::XyPoly { radius, conic, coeffs, .. } => conic_sag(*radius, *conic, r2) + xy(coeffs, x, y),
        Fitted::Zernike { radius, conic, norm_radius, coeffs, .. } => {
            conic_sag(*radius, *conic, r2) + zernikes(coeffs, x / norm_radius, y / norm_radius)
        }
        Fitted::Bspline { radius, conic, half, spans, coeffs, .. } => {
            conic_sag(*radius, *conic, r2) + spline(*half, spans.map(|n| n as usize), coeffs, x, y)
        }
        Fitted::Plane { .. }
        | Fitted::Sphere { .. }
        | Fitted::Conic { .. }
        | Fitted::Cylinder { .. }
        | Fitted::Toroid { .. } => f64::NAN,
    }
}

fn xy(coeffs: &[f64], x: f64, y: f64) -> f64 {
    let (mut i, mut j, mut sum) = (0, 0, 0.0);
    for c in coeffs {
        sum += c * x.powi(i) * y.powi(j);
        (i, j) = if i == 0 { (j + 1, 0) } else { (i - 1, j + 1) };
    }
    sum
}

/// By the sum over factorials (Born and Wolf, section 9.2.1), OSA/ANSI order and norm.
fn zernikes(coeffs: &[f64], x: f64, y: f64) -> f64 {
    let f = |k: i32| (1..=k).map(f64::from).product::<f64>();
    let (rho, phi) = (x.hypot(y), y.atan2(x));
    let (mut n, mut m, mut sum) = (0i32, 0i32, 0.0);
    for c in coeffs {
        let a = m.abs();
        let radial: f64 = (0..=(n - a) / 2)
            .map(|k| {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                sign * f(n - k) / (f(k) * f((n + a) / 2 - k) * f((n - a) / 2 - k)) * rho.powi(n - 2 * k)
            })
            .sum();
        let norm = (f64::from(2 * n + 2) / if m == 0 { 2.0 } else { 1.0 }).sqrt();
        let angle = f64::from(a) * phi;
        sum += c * norm * radial * if m < 0 { angle.sin() } else { angle.cos() };
        (n, m) = if m == n { (n + 1, -n - 1) } else { (n, m + 2) };
    }
    sum
}

/// By the fourth differences of cubes cut off (I. Schoenberg 1946).
fn spline(half: [f64; 2], spans: [usize; 2], coeffs: &[f64], x: f64, y: f64) -> f64 {
    let cut = |x: f64| x.max(0.0).powi(3);
    let cubic = |t: f64| (cut(t) - 4.0 * cut(t - 1.0) + 6.0 * cut(t - 2.0) - 4.0 * cut(t - 3.0) + cut(t - 4.0)) / 6.0;
    let [u, v] = [0, 1].map(|i| ([x, y][i] + half[i]) * spans[i] as f64 / (2.0 * half[i]));
    let width = spans[1] + 3;
    let term = |(n, c): (usize, &f64)| c * cubic(u + 3.0 - (n / width) as f64) * cubic(v + 3.0 - (n % width) as f64);
    coeffs.iter().enumerate().map(term).sum()
}

/// A repeatable number in −1…1.
fn chance(i: usize) -> f64 {
    2.0 * (i as f64 * 0.754_877_666_246_692_7 + 0.3).fract() - 1.0
}

/// Fits, prints, and holds the errors against what the fit says of itself. Millimetres; errors in µm.
fn honest(name: &str, patch: &Patch<'_>, kind: Option<Kind>, want: Kind) -> Fit {
    let (points, triangles) = patch.mesh(|_, _, _, _| 0.0);
    let found = fit(&points, &triangles, kind, 2e-4).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(found.surface.kind(), want, "{name}: {found:?}");
    let [height, slope] = patch.errors(&found);
    let open = found.open.expect("a freeform says what is open");
    println!(
        "{name}: rms {:.2e} max {:.2e} | off {:.2e} of {:.2e}, {:.2e} at most, slope {:.1e} of {:.1e} | {:?}",
        found.rms,
        found.max_residual,
        height[0],
        open.height[0],
        height[1],
        slope[0],
        open.slope[0],
        text(&found)
    );
    // Coordinates to 1024 mm are rounded to 2⁻¹⁴ mm, half of it at most: what remains is less than a third of that.
    assert!(height[0] < 1e-5 && height[1] < 4e-5, "{name}: {height:?}");
    assert!(height[0] < 3.0 * open.height[0] && slope[0] < 3.0 * open.slope[0], "{name}: {height:?} {open:?}");
    assert_eq!(open.set_aside, 0, "{name}");
    found
}

fn text(fit: &Fit) -> String {
    match &fit.surface {
        Fitted::Asphere { radius, conic, even, .. } => format!("R {radius} k {conic} {} terms", even.len()),
        Fitted::XyPoly { radius, coeffs, .. } | Fitted::Zernike { radius, coeffs, .. } => {
            format!("R {radius} {} terms", coeffs.len())
        }
        Fitted::Bspline { spans, .. } => format!("{spans:?}"),
        Fitted::Plane { .. }
        | Fitted::Sphere { .. }
        | Fitted::Conic { .. }
        | Fitted::Cylinder { .. }
        | Fitted::Toroid { .. } => String::new(),
    }
}

#[test]
fn even_aspheres() {
    let lens = |x: f64, y: f64| {
        let r2 = x * x + y * y;
        conic_sag(35.0, -0.7, r2) + 4e-6 * r2.powi(2) - 3e-9 * r2.powi(3) + 2e-12 * r2.powi(4)
    };
    let patch = Patch { disc: true, ..Patch::new(&lens, [14.0, 14.0], [24, 24]) };
    for kind in [None, Some(Kind::Asphere)] {
        let found = honest("asphere", &patch, kind, Kind::Asphere);
        let Fitted::Asphere { vertex, axis, radius, .. } = found.surface else { panic!() };
        assert!((radius / 35.0 - 1.0).abs() < 1e-3, "{radius}");
        assert!(axis.dot(patch.turn * DVec3::Z) > 1.0 - 1e-7 && vertex.distance(patch.shift) < 2e-3, "{axis} {vertex}");
    }
    // A gull wing, which no conic is near to.
    let wing = |x: f64, y: f64| {
        let r2 = x * x + y * y;
        r2 / 600.0 - 6e-6 * r2.powi(2) + 8e-9 * r2.powi(3)
    };
    honest("gull wing", &Patch { disc: true, ..Patch::new(&wing, [18.0, 18.0], [30, 30]) }, None, Kind::Asphere);
}

#[test]
fn polynomials_on_conics_and_off_their_middle() {
    for (order, conic, off, half, counts) in [
        (4, 0.0, [0.0, 0.0], [120.0, 50.0], [18, 8]),
        (6, -1.0, [0.0, 30.0], [90.0, 60.0], [24, 16]),
        (8, 0.6, [40.0, -20.0], [70.0, 70.0], [30, 30]),
    ] {
        let reach: f64 = 100.0;
        let coeffs: Vec<f64> = (0..=order)
            .flat_map(|d| (0..=d).map(move |j| (d, j)))
            .map(|(d, j)| if d < 2 { 0.0 } else { 0.4 * chance(17 * d + j + order) / reach.powi(d as i32) })
            .collect();
        let height = |x: f64, y: f64| {
            let (x, y) = (x + off[0], y + off[1]);
            conic_sag(-700.0, conic, x * x + y * y) + xy(&coeffs, x, y)
        };
        let patch = Patch::new(&height, half, counts);
        for kind in [None, Some(Kind::XyPoly)] {
            honest(&format!("order {order}"), &patch, kind, Kind::XyPoly);
        }
    }
}

#[test]
fn zernike_mixes() {
    let coeffs: Vec<f64> = (0..28).map(|i| if i < 3 { 0.0 } else { 0.03 * chance(i) }).collect();
    let height = |x: f64, y: f64| conic_sag(400.0, -0.5, x * x + y * y) + zernikes(&coeffs, x / 60.0, y / 60.0);
    let patch = Patch { disc: true, ..Patch::new(&height, [55.0, 55.0], [26, 26]) };
    let zernike = honest("zernike", &patch, Some(Kind::Zernike), Kind::Zernike);
    let poly = honest("zernike as xy_poly", &patch, None, Kind::XyPoly);
    assert_eq!(zernike.max_residual, poly.max_residual, "two names of one surface");
}

#[test]
fn splines_that_are_no_polynomial() {
    let coeffs: Vec<f64> = (0..10 * 8).map(|i| 0.03 * chance(i)).collect();
    let base = |x: f64, y: f64| conic_sag(2500.0, 0.0, x * x + y * y);
    // Knots that divide the face, and knots that are not where the fit puts its own.
    let own = |x: f64, y: f64| base(x, y) + spline([150.0, 120.0], [7, 5], &coeffs, x, y);
    let patch = Patch::new(&own, [150.0, 120.0], [36, 28]);
    let found = honest("own knots", &patch, None, Kind::Bspline);
    assert!(matches!(found.surface, Fitted::Bspline { spans: [7, 5], .. }), "{}", text(&found));
    let (points, triangles) = patch.mesh(|_, _, _, _| 0.0);
    let refused = fit(&points, &triangles, Some(Kind::XyPoly), 2e-4).expect_err("not of any degree");
    assert!(matches!(refused, FitError::Misses { .. }), "{refused}");
    let other = |x: f64, y: f64| base(x, y) + spline([163.0, 131.0], [7, 5], &coeffs, x + 4.0, y - 3.0);
    // Finer grids come near it, as far as the points reach.
    let patch = Patch::new(&other, [150.0, 120.0], [22, 17]);
    let (points, triangles) = patch.mesh(|_, _, _, _| 0.0);
    let found = fit(&points, &triangles, Some(Kind::Bspline), 1e-2).unwrap_or_else(|e| panic!("{e}"));
    let [height, slope] = patch.errors(&found);
    println!("spline: {} max {:.1e} off {height:?} slope {slope:?} {:?}", text(&found), found.max_residual, found.open);
    assert!(height[0] < 1e-2 && height[0] < 3.0 * found.open.map_or(0.0, |open| open.left_out), "{height:?}");
}

#[test]
fn loose_rims_and_strays_count_little() {
    let coeffs: Vec<f64> = (0..21).map(|i| if i < 3 { 0.0 } else { 0.3 * chance(i) }).collect();
    let height = |x: f64, y: f64| conic_sag(900.0, 0.0, x * x + y * y) + xy(&coeffs, x / 120.0, y / 120.0);
    let patch = Patch::new(&height, [120.0, 50.0], [40, 18]);
    let inside = |mesh: (Vec<[f32; 3]>, Vec<[u32; 3]>)| {
        let found = fit(&mesh.0, &mesh.1, Some(Kind::XyPoly), 2e-3).unwrap_or_else(|e| panic!("{e}"));
        (patch.errors(&found)[0], found)
    };
    // The rim's points are off by up to 0.5 µm, as edges of a CAD model are.
    let (height, rim) = inside(patch.mesh(|_, _, rim, i| if rim { 5e-4 * chance(i as usize) } else { 0.0 }));
    println!("rim: off {height:?}, {:?}", rim.open);
    assert!(height[0] < 6e-6, "{height:?}");
    // Three strays of 1.5 µm.
    let stray = |i: u32| if [150, 333, 601].contains(&i) { 1.5e-3 } else { 0.0 };
    let (height, strays) = inside(patch.mesh(|_, _, _, i| stray(i)));
    println!("strays: off {height:?}, {:?}", strays.open);
    assert!(height[0] < 6e-6 && strays.open.is_some_and(|open| open.set_aside == 3), "{height:?}");
    assert!((strays.max_residual / 1.5e-3 - 1.0).abs() < 0.1, "{}", strays.max_residual);
}

#[test]
fn misses_say_where_and_few_points_are_too_few() {
    let height = |x: f64, y: f64| conic_sag(900.0, 0.0, x * x + y * y) + 1e-5 * x * x + 1e-7 * x * x * y;
    let patch = Patch::new(&height, [120.0, 50.0], [30, 14]);
    let dent = |x: f64, y: f64| -0.02 * (-((x - 60.0).powi(2) + (y + 20.0).powi(2)) / 18.0).exp();
    let (points, triangles) = patch.mesh(|x, y, _, _| dent(x, y));
    for kind in [Some(Kind::XyPoly), Some(Kind::Bspline), None] {
        let error = fit(&points, &triangles, kind, 1e-4).expect_err("20 µm of dent");
        println!("{error}");
        match error {
            FitError::Misses { worst, max, .. } => {
                let worst = patch.turn.inverse() * (worst - patch.shift);
                assert!((worst.x - 60.0).hypot(worst.y + 20.0) < 12.0 && max > 5e-4, "{worst} {max}");
            }
            FitError::Open { left_out, .. } => assert!(left_out > 1e-4),
            other @ (FitError::NotFinite { .. }
            | FitError::BadIndex { .. }
            | FitError::TooFew { .. }
            | FitError::Undetermined { .. }) => panic!("{other}"),
        }
    }
    let few = Patch::new(&height, [120.0, 50.0], [2, 2]);
    let (points, triangles) = few.mesh(|_, _, _, _| 0.0);
    for kind in [Kind::Asphere, Kind::XyPoly, Kind::Zernike, Kind::Bspline] {
        assert!(matches!(fit(&points, &triangles, Some(kind), 1e-4), Err(FitError::TooFew { .. })), "{kind}");
    }
    // A whole ball is no height over a plane; neither ends in a panic, nor does what has no width.
    let (nu, nv) = (20, 10);
    let ball = |i: u32| {
        let (a, b) = (f64::from(i % nu) * 0.314, f64::from(i / nu) * 0.314);
        [9.0 * a.cos() * b.sin(), 8.0 * a.sin() * b.sin(), 7.0 * b.cos()].map(|x| x as f32)
    };
    let points: Vec<[f32; 3]> = (0..nu * (nv + 1)).map(ball).collect();
    let triangles: Vec<[u32; 3]> =
        (0..nu * nv - 1).flat_map(|a| [[a, a + 1, a + nu + 1], [a, a + nu + 1, a + nu]]).collect();
    let line: Vec<[f32; 3]> = (0..50).map(|i| [i as f32, 2.0 * i as f32, -i as f32]).collect();
    for kind in [Kind::Asphere, Kind::XyPoly, Kind::Zernike, Kind::Bspline] {
        assert!(fit(&points, &triangles, Some(kind), 1e-4).is_err(), "{kind}");
        let _ = fit(&line, &[], Some(kind), 1.0);
        let _ = fit(&[[f32::MAX; 3], [f32::MIN; 3], [0.0; 3], [1e-40; 3]], &[], Some(kind), 1.0);
    }
}
