use super::*;
use crate::base::rng::{Rng, Stream};
use crate::base::stats::{Moments, sidak_z};
use crate::base::warp::Frame;

fn incoming(theta_deg: f64) -> DVec3 {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    DVec3::new(sin * 0.6, sin * 0.8, -cos)
}

fn all() -> Vec<(Scatter, f64)> {
    let mut all = vec![(
        Scatter::from_finish(&Finish::Lambert { reflectance: 0.5, transmittance: 0.3 }).unwrap(),
        60f64.to_radians(),
    )];
    for sigma_deg in [0.1f64, 6.0, 20.0, 60.0] {
        let finish = Finish::Gauss { sigma_deg, reflectance: 0.25, transmittance: 0.7 };
        all.push((Scatter::from_finish(&finish).unwrap(), sigma_deg.to_radians()));
    }
    all
}

/// Cells of (angle, azimuth) about the axis of each side; what lands nowhere is a cell too. The expectation is
/// the pdf summed over 64 × 64 points of each cell.
#[test]
fn samples_follow_the_pdf() {
    const RINGS: usize = 12;
    const SECTORS: usize = 12;
    const FINE: usize = 64;
    let count = 200_000;
    for (scatter, sigma) in all() {
        for theta in [0.0, 45.0, 85.0] {
            let d_in = incoming(theta);
            let widest = (4.0 * sigma).min(PI);
            let edge = |k: f64| widest * k / RINGS as f64;
            let cell = |axis: DVec3, dir: DVec3| {
                let local = Frame::about(axis).to_local(dir);
                let t = 2.0 * (0.5 * (dir - axis).length()).min(1.0).asin();
                let phi = local.y.atan2(local.x).rem_euclid(2.0 * PI);
                let sector = ((phi / (2.0 * PI) * SECTORS as f64) as usize).min(SECTORS - 1);
                (t < widest).then(|| ((t / widest * RINGS as f64) as usize).min(RINGS - 1) * SECTORS + sector)
            };
            let (mut seen, mut want) = (vec![0.0; 2 * RINGS * SECTORS + 1], vec![0.0; 2 * RINGS * SECTORS + 1]);
            for (side, axis) in [mirrored(d_in), d_in].into_iter().enumerate() {
                let frame = Frame::about(axis);
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
                            want[side * RINGS * SECTORS + index] += scatter.pdf(d_in, dir) * area;
                        }
                    }
                }
            }
            let last = want.len() - 1;
            want[last] = 1.0 - want[..last].iter().sum::<f64>();
            let mut rng = Rng::new(11, Stream::Check, theta as u64, sigma.to_bits());
            for _ in 0..count {
                let u = [rng.uniform(), rng.uniform(), rng.uniform()];
                let index = scatter.sample(d_in, u).and_then(|s| {
                    let cos = s.dir.z.abs();
                    let weight = scatter.eval(d_in, s.dir) * cos / s.pdf;
                    assert!((s.weight / weight - 1.0).abs() < 1e-6, "{} {weight}", s.weight);
                    assert!((s.pdf / scatter.pdf(d_in, s.dir) - 1.0).abs() < 1e-12);
                    let axis = if s.dir.z > 0.0 { mirrored(d_in) } else { d_in };
                    let side = usize::from(s.dir.z < 0.0);
                    cell(axis, s.dir).map(|c| side * RINGS * SECTORS + c)
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
            assert!(z < sidak_z(0.001, 15), "σ {sigma} θ {theta}: chi² {chi2} of {k}, z {z}");
        }
    }
}

#[test]
fn reciprocal() {
    let mut rng = Rng::new(12, Stream::Check, 0, 0);
    for (scatter, _) in all() {
        let mut positive = 0;
        for _ in 0..2000 {
            let d_in = -warp::cosine_hemisphere(rng.pair());
            let Some(s) = scatter.sample(d_in, [rng.uniform(), rng.uniform(), rng.uniform()]) else { continue };
            // Back along the leaving direction; arriving from the other side turns the frame about x.
            let turn = |d: DVec3| if s.dir.z < 0.0 { DVec3::new(d.x, -d.y, -d.z) } else { d };
            let (there, back) = (scatter.eval(d_in, s.dir), scatter.eval(turn(-s.dir), turn(-d_in)));
            assert!((there / back - 1.0).abs() < 1e-9, "{there} {back}");
            positive += usize::from(there > 0.0);
        }
        assert!(positive > 1000);
    }
}

/// In a furnace of luminance 1 a face shows its albedo, which is never above R + T.
#[test]
fn mean_weight_is_the_albedo() {
    let count = 200_000;
    for (scatter, sigma) in all() {
        for theta in [0.0f64, 45.0, 85.0, 89.9] {
            let d_in = incoming(theta);
            let want = scatter.albedo(-d_in.z);
            let mut rng = Rng::new(13, Stream::Check, theta as u64, sigma.to_bits());
            let mut got = [Moments::default(); 2];
            for _ in 0..count {
                let s = scatter.sample(d_in, [rng.uniform(), rng.uniform(), rng.uniform()]);
                let weight = |up: bool| s.map_or(0.0, |s| if (s.dir.z > 0.0) == up { s.weight } else { 0.0 });
                got[0].add(weight(true));
                got[1].add(weight(false));
            }
            for side in 0..2 {
                let z = (got[side].mean - want[side]) / got[side].stderr();
                assert!(z.abs() < sidak_z(0.001, 40), "σ {sigma} θ {theta}: {} {}", got[side].mean, want[side]);
                assert!(want[side] <= scatter.shares()[side] + 1e-9);
            }
        }
    }
}

#[test]
fn narrowness_and_refusals() {
    let gauss = |sigma_deg| Scatter::from_finish(&Finish::Gauss { sigma_deg, reflectance: 0.0, transmittance: 0.9 });
    assert!(gauss(0.99).unwrap().is_narrow() && !gauss(1.0).unwrap().is_narrow());
    assert_eq!(gauss(0.0), None);
    assert_eq!(gauss(f64::NAN), None);
    assert_eq!(Scatter::from_finish(&Finish::Polished), None);
    assert_eq!(Scatter::from_finish(&Finish::Lambert { reflectance: f64::NAN, transmittance: 0.0 }), None);
    let black = Scatter::from_finish(&Finish::Lambert { reflectance: 0.0, transmittance: 0.0 }).unwrap();
    assert_eq!(black.sample(DVec3::NEG_Z, [0.5; 3]), None);
    assert_eq!(black.pdf(DVec3::NEG_Z, DVec3::Z), 0.0);
    let white = Scatter::from_finish(&Finish::Lambert { reflectance: 1.0, transmittance: 0.0 }).unwrap();
    assert_eq!(white.eval(DVec3::Z, DVec3::Z), 0.0, "a ray that does not arrive");
    assert_eq!(white.sample(DVec3::X, [0.5; 3]), None);
}
