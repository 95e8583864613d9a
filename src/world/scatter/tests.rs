use super::principled::trials::incoming;
use super::*;
use crate::fresnel::refract;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::{Moments, sidak_z};
use eyebox_base::warp::{self, Frame};
use eyebox_scene::ScatterTable;
use eyebox_scene::scatter_table::Measurement;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// A scatterer between two media, with a width of its lobes in rad.
pub(super) struct Case {
    pub name: String,
    pub scatter: Scatter,
    pub n: Sides<'static>,
    pub width: f64,
}

impl Case {
    /// What the lobe of a side lies about.
    fn axis(&self, d_in: DVec3, side: usize) -> DVec3 {
        match side {
            0 => mirrored(d_in),
            _ if self.scatter.refracts() => refract(d_in, DVec3::Z, self.n.here / self.n.beyond).unwrap_or(d_in),
            _ => d_in,
        }
    }
}

const INTO_GLASS: Sides<'static> = Sides::between(1.0, 1.5);

fn rough(alpha: f64, ratios: &[f64]) -> Scatter {
    let ratios: Vec<[f64; 2]> = ratios.iter().map(|x| [*x, *x]).collect();
    Scatter::Rough(Rough::new(Arc::new(Lost::new(alpha, &ratios))))
}

/// A lobe by hand: exp(−(sin_i − sin_o)²/0.1)(1.2 − φ/π), and half of it through.
fn measured() -> Scatter {
    let theta: Vec<f64> = (0..=18).map(|k| FRAC_PI_2 * f64::from(k) / 18.0).collect();
    let phi: Vec<f64> = (0..=6).map(|k| PI * f64::from(k) / 6.0).collect();
    let mut values = Vec::new();
    for i in &theta {
        for o in &theta {
            let near = (-(i.sin() - o.sin()).powi(2) / 0.1).exp();
            values.extend(phi.iter().map(|p| 0.15 * near * (1.2 - p / PI)));
        }
    }
    let side = |share: f64| Measurement {
        theta_in: theta.clone(),
        theta_out: theta.clone(),
        phi: phi.clone(),
        values: values.iter().map(|v| v * share).collect(),
    };
    let table = ScatterTable::new("lobe", &[Some(side(1.0)), Some(side(0.5))]).unwrap();
    Scatter::Measured(Arc::new(Measured::new(&table)))
}

fn all() -> Vec<Case> {
    let mut all = Vec::new();
    let mut add = |name: &str, scatter: Scatter, n: Sides<'static>, width: f64| {
        all.push(Case { name: name.to_owned(), scatter, n, width });
    };
    let of = |finish: Finish| Scatter::from_finish(&finish).unwrap();
    add("lambert", of(Finish::Lambert { reflectance: 0.5, transmittance: 0.3 }), Sides::AIR, 60f64.to_radians());
    for sigma_deg in [0.1f64, 6.0, 20.0, 60.0] {
        let gauss = of(Finish::Gauss { sigma_deg, reflectance: 0.25, transmittance: 0.7 });
        add(&format!("gauss {sigma_deg}"), gauss, Sides::AIR, sigma_deg.to_radians());
    }
    add("cos_m", of(Finish::CosM { m: 12.0, reflectance: 0.3, transmittance: 0.6 }), Sides::AIR, 0.29);
    for alpha in [0.05, 0.3, 1.0] {
        let face = rough(alpha, &[1.5]);
        add(&format!("rough {alpha} from air"), face.clone(), INTO_GLASS, 0.7 * alpha);
        add(&format!("rough {alpha} from glass"), face, INTO_GLASS.swapped(), alpha);
    }
    add("abg", of(Finish::Abg { a: 0.01, b: 0.01, g: 2.0, reflectance: 0.5 }), Sides::AIR, 0.2);
    add("abg 1.3", of(Finish::Abg { a: 0.02, b: 1e-4, g: 1.3, reflectance: 0.0 }), Sides::AIR, 0.1);
    add("measured", measured(), Sides::AIR, 40f64.to_radians());
    all
}

#[test]
fn samples_follow_the_pdf() {
    samples_follow(&all());
}

/// Cells of (angle, azimuth) about the axis of each side; what lands nowhere is a cell too. The expectation is
/// the pdf summed over 64 × 64 points of each cell.
pub(super) fn samples_follow(cases: &[Case]) {
    const RINGS: usize = 12;
    const SECTORS: usize = 12;
    const FINE: usize = 64;
    let count = 200_000;
    for (number, case) in cases.iter().enumerate() {
        let (scatter, n) = (&case.scatter, case.n);
        for theta in [0.0, 45.0, 85.0] {
            let d_in = incoming(theta);
            let widest = (4.0 * case.width).min(PI);
            let edge = |k: f64| widest * k / RINGS as f64;
            let cell = |axis: DVec3, dir: DVec3| {
                let local = Frame::about(axis).to_local(dir);
                let t = 2.0 * (0.5 * (dir - axis).length()).min(1.0).asin();
                let phi = local.y.atan2(local.x).rem_euclid(2.0 * PI);
                let sector = ((phi / (2.0 * PI) * SECTORS as f64) as usize).min(SECTORS - 1);
                (t < widest).then(|| ((t / widest * RINGS as f64) as usize).min(RINGS - 1) * SECTORS + sector)
            };
            let (mut seen, mut want) = (vec![0.0; 2 * RINGS * SECTORS + 1], vec![0.0; 2 * RINGS * SECTORS + 1]);
            for side in 0..2 {
                let frame = Frame::about(case.axis(d_in, side));
                for index in 0..RINGS * SECTORS {
                    let (ring, sector) = (index / SECTORS, index % SECTORS);
                    for fine in 0..FINE * FINE {
                        let t = edge(ring as f64 + ((fine / FINE) as f64 + 0.5) / FINE as f64);
                        let phi =
                            2.0 * PI / SECTORS as f64 * (sector as f64 + ((fine % FINE) as f64 + 0.5) / FINE as f64);
                        let local = DVec3::new(t.sin() * phi.cos(), t.sin() * phi.sin(), t.cos());
                        let dir = frame.to_world(local);
                        if (dir.z > 0.0) == (side == 0) {
                            let area = t.sin() * edge(1.0) * 2.0 * PI / (SECTORS * FINE * FINE) as f64;
                            want[side * RINGS * SECTORS + index] += scatter.pdf(d_in, dir, n) * area;
                        }
                    }
                }
            }
            let last = want.len() - 1;
            want[last] = 1.0 - want[..last].iter().sum::<f64>();
            let mut rng = Rng::new(11, Stream::Check, theta as u64, number as u64);
            for _ in 0..count {
                let u = [rng.uniform(), rng.uniform(), rng.uniform()];
                let index = scatter.sample(d_in, n, u).and_then(|s| {
                    let weight = scatter.eval(d_in, s.dir, n) * s.dir.z.abs() / s.pdf;
                    assert!((s.weight - weight).abs() <= 1e-6 * weight, "{}: {} {weight}", case.name, s.weight);
                    assert!((s.pdf / scatter.pdf(d_in, s.dir, n) - 1.0).abs() < 1e-12);
                    let side = usize::from(s.dir.z < 0.0);
                    cell(case.axis(d_in, side), s.dir).map(|c| side * RINGS * SECTORS + c)
                });
                seen[index.unwrap_or(last)] += 1.0;
            }
            // Cells with few expected samples are merged into one.
            let (mut chi2, mut cells, mut few) = (0.0, 0.0, [0.0, 0.0]);
            for (n, p) in seen.iter().zip(&want) {
                let e = p * count as f64;
                if e < 25.0 {
                    few = [few[0] + n, few[1] + e];
                } else {
                    chi2 += (n - e).powi(2) / e;
                    cells += 1.0;
                }
            }
            if few[1] > 25.0 {
                chi2 += (few[0] - few[1]).powi(2) / few[1];
                cells += 1.0;
            }
            // Wilson and Hilferty's normal approximation of chi-squared.
            let k: f64 = cells - 1.0;
            let z = ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
            let limit = sidak_z(0.001, 3 * cases.len());
            assert!(z < limit, "{} θ {theta}: chi² {chi2} of {k}, z {z}", case.name);
        }
    }
}

#[test]
fn reciprocal() {
    are_reciprocal(&all());
}

/// value(1→2)/n₂² = value(2→1)/n₁².
pub(super) fn are_reciprocal(cases: &[Case]) {
    let mut rng = Rng::new(12, Stream::Check, 0, 0);
    for Case { name, scatter, n, .. } in cases {
        let n = *n;
        let mut positive = 0;
        for _ in 0..2000 {
            let d_in = -warp::cosine_hemisphere(rng.pair());
            let Some(s) = scatter.sample(d_in, n, [rng.uniform(), rng.uniform(), rng.uniform()]) else { continue };
            // Back along the leaving direction; arriving from the other side turns the frame about x.
            let through = s.dir.z < 0.0;
            let turn = |d: DVec3| if through { DVec3::new(d.x, -d.y, -d.z) } else { d };
            let (back_n, scale) = if through { (n.swapped(), (n.here / n.beyond).powi(2)) } else { (n, 1.0) };
            let there = scatter.eval(d_in, s.dir, n) * scale;
            let back = scatter.eval(turn(-s.dir), turn(-d_in), back_n);
            assert!((there / back - 1.0).abs() < 1e-8, "{name}: {there} {back}");
            positive += usize::from(there > 0.0);
        }
        assert!(positive > 700, "{name}: {positive}");
    }
}

/// In a furnace of luminance 1 a face shows its albedo, which is never above 1.
#[test]
fn mean_weight_is_the_albedo() {
    let count = 200_000;
    let cases = all();
    for (number, case) in cases.iter().enumerate() {
        for theta in [0.0f64, 45.0, 85.0, 89.9] {
            let d_in = incoming(theta);
            let want = case.scatter.albedo(-d_in.z);
            let mut rng = Rng::new(13, Stream::Check, theta as u64, number as u64);
            let mut got = Moments::default();
            for _ in 0..count {
                let u = [rng.uniform(), rng.uniform(), rng.uniform()];
                got.add(case.scatter.sample(d_in, case.n, u).map_or(0.0, |s| s.weight));
            }
            // The tables' own error besides.
            let (z, limit) = ((got.mean - want) / (got.stderr() + 1e-4 * want), sidak_z(0.001, 4 * cases.len()));
            assert!(z.abs() < limit, "{} θ {theta}: {} ± {}, {want}", case.name, got.mean, got.stderr());
            assert!(want + case.scatter.specular() <= 1.0 + 1e-6, "{}", case.name);
        }
    }
}

/// Rough dielectrics in a white furnace: what one bounce leaves, by a rule of its own (points of a lattice), and what the
/// tables hand back add up to everything, between the tables' points, too.
#[test]
fn rough_faces_keep_all_light() {
    let mut worst = (0f64, String::new());
    for alpha in [1e-3, 0.01, 0.1, 0.25, 0.5, 1.0] {
        let lost = Lost::new(alpha, &[[1.45, 1.55]]);
        for ratio in [1.45, 1.517] {
            for n in [Sides::between(1.0, ratio), Sides::between(ratio, 1.0)] {
                for theta in [0.0f64, 30.0, 43.0, 50.0, 75.0, 88.0, 89.9] {
                    let wi = -incoming(theta);
                    let count = 1 << 18;
                    let mut sum = 0.0;
                    for k in 0..count {
                        // Steps by the powers of the root of x³ = x + 1 (M. Roberts 2018).
                        const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
                        let at = STEPS.map(|step| (0.5 + step * f64::from(k)).fract());
                        sum += lost.facets().bounce(wi, n, at).iter().sum::<f64>();
                    }
                    let handed = lost.at(&lost.split(n), false, wi.z);
                    let error = sum / f64::from(count) + handed - 1.0;
                    if error.abs() > worst.0 {
                        worst = (error.abs(), format!("α {alpha} n {n:?} θ {theta}: {error:e}"));
                    }
                }
            }
        }
    }
    println!("worst {}", worst.1);
    assert!(worst.0 < 5e-4, "worst {}", worst.1);
}

/// The same by chance: no further from 1 than three standard errors and what the tables are good for.
#[test]
fn furnace_of_rough_faces() {
    let count = 1 << 20;
    for (alpha, theta) in [(0.2, 60.0), (0.6, 20.0), (1.0, 80.0)] {
        for n in [INTO_GLASS, INTO_GLASS.swapped()] {
            let scatter = rough(alpha, &[1.5]);
            let d_in = incoming(theta);
            let mut rng = Rng::new(17, Stream::Check, theta as u64, n.here.to_bits());
            let mut all = Moments::default();
            for _ in 0..count {
                let u = [rng.uniform(), rng.uniform(), rng.uniform()];
                all.add(scatter.sample(d_in, n, u).map_or(0.0, |s| s.weight));
            }
            let error = all.mean - 1.0;
            println!("α {alpha} {n:?} θ {theta}: {error:e} ± {:e}", all.stderr());
            assert!(error.abs() < 3.0 * all.stderr() + 1e-4, "α {alpha} {n:?}: {error:e} ± {:e}", all.stderr());
        }
    }
}

#[test]
fn narrowness_and_refusals() {
    let gauss = |sigma_deg| Scatter::from_finish(&Finish::Gauss { sigma_deg, reflectance: 0.0, transmittance: 0.9 });
    assert!(gauss(0.99).unwrap().is_narrow() && !gauss(1.0).unwrap().is_narrow());
    assert!(rough(0.015, &[1.5]).is_narrow() && !rough(0.02, &[1.5]).is_narrow());
    assert_eq!(gauss(0.0), None);
    assert_eq!(gauss(f64::NAN), None);
    assert_eq!(Scatter::from_finish(&Finish::Polished), None);
    assert_eq!(Scatter::from_finish(&Finish::Lambert { reflectance: f64::NAN, transmittance: 0.0 }), None);
    let black = Scatter::from_finish(&Finish::Lambert { reflectance: 0.0, transmittance: 0.0 }).unwrap();
    assert_eq!(black.sample(DVec3::NEG_Z, Sides::AIR, [0.5; 3]), None);
    assert_eq!(black.pdf(DVec3::NEG_Z, DVec3::Z, Sides::AIR), 0.0);
    let white = Scatter::from_finish(&Finish::Lambert { reflectance: 1.0, transmittance: 0.0 }).unwrap();
    assert_eq!(white.eval(DVec3::Z, DVec3::Z, Sides::AIR), 0.0, "a ray that does not arrive");
    assert_eq!(white.sample(DVec3::X, Sides::AIR, [0.5; 3]), None);
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-0.1..1.1f64, any::<f64>(), Just(1.0), Just(1e-4), Just(f64::MIN_POSITIVE)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Hostile numbers give a scatterer that stays finite, or none.
    #[test]
    fn numbers_of_any_kind(x in [number(), number(), number(), number()], ratio in 0.1..10.0f64, cos in 1e-12..1.0f64,
                           u in [0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64]) {
        let [a, b, c, d] = x;
        let mut scatters: Vec<Scatter> = [
            Finish::Lambert { reflectance: a, transmittance: b },
            Finish::Gauss { sigma_deg: c, reflectance: a, transmittance: b },
            Finish::CosM { m: c, reflectance: a, transmittance: b },
            Finish::Abg { a, b, g: c, reflectance: d },
        ].iter().filter_map(Scatter::from_finish).collect();
        if (1e-4..=1.0).contains(&a) {
            scatters.push(rough(a, &[ratio]));
        }
        let d_in = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, -cos);
        for scatter in scatters {
            let n = Sides::between(1.0, ratio);
            let albedo = scatter.albedo(cos);
            prop_assert!(albedo >= 0.0 && albedo.is_finite(), "{scatter:?}");
            if let Some(s) = scatter.sample(d_in, n, u) {
                prop_assert!(s.dir.is_normalized() && s.weight >= 0.0 && s.weight.is_finite() && s.pdf > 0.0);
                prop_assert!(scatter.eval(d_in, s.dir, n).is_finite());
            }
        }
    }
}
