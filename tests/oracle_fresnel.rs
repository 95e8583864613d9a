//! Fresnel against 50-digit values (oracle set 01_fresnel; copies with their headers in tests/data).

use eyebox::base::Complex;
use eyebox::world::fresnel::fresnel;

/// Rows of a CSV by column name; `#` lines are comments.
fn rows(text: &'static str) -> impl Iterator<Item = impl Fn(&str) -> &'static str> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().expect("header").split(',').collect();
    lines.map(move |line| {
        let (header, cells): (_, Vec<&str>) = (header.clone(), line.split(',').collect());
        assert_eq!(cells.len(), header.len(), "{line}");
        move |name: &str| cells[header.iter().position(|h| *h == name).expect("column")]
    })
}

#[test]
fn every_row_to_eight_times_its_unavoidable_error() {
    let mut count = 0;
    let mut worst = (0.0, String::new());
    for row in rows(include_str!("data/fresnel.csv")) {
        let number = |name: &str| row(name).parse::<f64>().expect("number");
        let got = fresnel(number("n1"), Complex::new(number("n2"), number("k2")), number("cos_i"));
        let tolerance = (8.0 * number("err64")).max(1e-13);
        for (name, value) in [
            ("Rs", got.r_s),
            ("Rp", got.r_p),
            ("Ts", got.t_s),
            ("Tp", got.t_p),
            ("R", got.reflectance()),
            ("T", got.transmittance()),
        ] {
            let error = (value - number(name)).abs() / tolerance;
            let what =
                format!("row {} {} {} {name}: {value} instead of {}", row("id"), row("pair"), row("tag"), row(name));
            assert!(error <= 1.0, "{what}, {error:.2} tolerances");
            if error > worst.0 {
                worst = (error, what);
            }
        }
        if row("tir") == "1" && row("tag") != "critical" {
            assert_eq!((got.r_s, got.r_p, got.t_s, got.t_p), (1.0, 1.0, 0.0, 0.0), "row {}", row("id"));
        }
        count += 1;
    }
    assert_eq!(count, 240);
    println!("worst: {:.3} tolerances at {}", worst.0, worst.1);
}

/// ∫ over 0..1 by tanh-sinh, which does not mind the square-root kink at the critical angle when it lies at an end.
fn integrate(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let half_pi = std::f64::consts::FRAC_PI_2;
    let h = 1.0 / 64.0;
    let terms = (-256..=256).map(|i| {
        let t = f64::from(i) * h;
        let u = half_pi * t.sinh();
        let weight = half_pi * t.cosh() / u.cosh().powi(2);
        let x = (a + b) / 2.0 + (b - a) / 2.0 * u.tanh();
        weight * f(x)
    });
    (b - a) / 2.0 * h * terms.sum::<f64>()
}

#[test]
fn diffuse_reflectance() {
    let mut count = 0;
    for row in rows(include_str!("data/fresnel_hemispherical.csv")) {
        let number = |name: &str| row(name).parse::<f64>().expect("number");
        let (n1, n2) = (number("n1"), number("n2"));
        let critical = (1.0 - (n2 / n1).min(1.0).powi(2)).sqrt();
        let integrand = |mu: f64| 2.0 * mu * fresnel(n1, Complex::real(n2), mu).reflectance();
        let got = integrate(0.0, critical, integrand) + integrate(critical, 1.0, integrand);
        assert!((got - number("R_diffuse")).abs() < 1e-9, "{n1} {n2}: {got} instead of {}", number("R_diffuse"));
        count += 1;
    }
    assert_eq!(count, 8);
}
