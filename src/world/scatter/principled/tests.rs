use super::super::tests::{Case, are_reciprocal, samples_follow};
use super::super::{Scatter, Sides};
use super::look::lacks;
use super::trials::{brushed, film, furnace, incoming, principled};
use super::*;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::Moments;
use eyebox_scene::{AnisotropyLaw, Colour, Scalar};

fn case(name: &str, surface: StandardSurface) -> Case {
    let (principled, look) = principled(surface);
    let n = Sides { here: 1.0, beyond: 1.0, look: Some(Box::leak(Box::new(look))) };
    Case {
        name: name.to_owned(),
        scatter: Scatter::Principled(Box::new(principled)),
        n,
        width: std::f64::consts::FRAC_PI_4,
    }
}

fn some() -> Vec<Case> {
    let grey = |c: f64| Colour::new([c; 3]);
    let plain = StandardSurface { roughness: Scalar::new(0.5), base_color: grey(0.6), ..StandardSurface::default() };
    let with = |change: &dyn Fn(&mut StandardSurface)| {
        let mut surface = plain.clone();
        change(&mut surface);
        surface
    };
    vec![
        case("plastic", plain.clone()),
        case(
            "dust",
            with(&|s| {
                (s.diffuse_roughness, s.specular) = (Scalar::new(0.9), Scalar::new(0.7));
                (s.coat, s.coat_roughness) = (Scalar::new(0.3), Scalar::new(0.5));
            }),
        ),
        case("metal", with(&|s| s.metallic = Scalar::new(1.0))),
        case("half metal", with(&|s| (s.metallic, s.roughness) = (Scalar::new(0.5), Scalar::new(0.8)))),
        case("paper", with(&|s| (s.diffuse_transmission, s.specular) = (Scalar::new(0.4), Scalar::new(0.5)))),
        case("varnish", with(&|s| (s.coat, s.coat_roughness) = (Scalar::new(0.8), Scalar::new(0.4)))),
        case("cloth", with(&|s| (s.sheen_color, s.sheen_roughness) = (grey(0.7), Scalar::new(0.5)))),
        case("rough sheet", with(&|s| s.transmission = Scalar::new(0.5))),
        case("brushed", with(&|s| (s.metallic, s.anisotropy) = (Scalar::new(1.0), brushed(0.6, AnisotropyLaw::Gltf)))),
        case("grooved", with(&|s| s.anisotropy = brushed(0.7, AnisotropyLaw::OpenPbr))),
        case("bubble", with(&|s| s.film = film(0.7, 1.33, 350.0))),
        case("anodised", with(&|s| (s.metallic, s.film) = (Scalar::new(1.0), film(1.0, 1.8, 200.0)))),
        case("copper", with(&|s| (s.metallic, s.metal_edge) = (Scalar::new(1.0), grey(0.4)))),
    ]
}

/// A coat whose normals are not those of the base, and brushed facets that are turned, by places of their own.
fn turned() -> Vec<Case> {
    let bumpy = StandardSurface {
        coat: Scalar::new(0.9),
        coat_roughness: Scalar::new(0.5),
        roughness: Scalar::new(0.6),
        base_color: Colour::new([0.5; 3]),
        anisotropy: brushed(0.8, AnisotropyLaw::MaterialX),
        ..StandardSurface::default()
    };
    let (principled, mut look) = principled(bumpy);
    look.coat_normal = Some(DVec3::new(0.3, -0.2, 1.0).normalize());
    if let Some(stretch) = &mut look.stretch {
        stretch.turn = [0.6, 0.8];
    }
    let n = Sides { here: 1.0, beyond: 1.0, look: Some(Box::leak(Box::new(look))) };
    let scatter = Scatter::Principled(Box::new(principled));
    vec![Case { name: "turned".to_owned(), scatter, n, width: std::f64::consts::FRAC_PI_4 }]
}

/// The furnace of surfaces that are not alike all round, from all sides.
#[test]
fn turned_furnace() {
    for case in turned() {
        for turn in 0..8 {
            let mut rng = Rng::new(25, Stream::Check, 0, turn);
            let (sin, cos) = (0.7 * turn as f64).sin_cos();
            let d_in = DVec3::new(0.9 * cos, 0.9 * sin, -(1.0f64 - 0.81).sqrt());
            let mut all = Moments::default();
            for _ in 0..1 << 14 {
                let sampled = case.scatter.sample(d_in, case.n, [rng.uniform(), rng.uniform(), rng.uniform()]);
                all.add(sampled.map_or(0.0, |s| s.weight));
            }
            assert!(all.mean < 1.0 + 3.0 * all.stderr(), "{turn}: {} ± {}", all.mean, all.stderr());
        }
    }
}

/// OpenPBR 1.1: the reflectance of a metal at 82° is Schlick's times the colour of its edge.
#[test]
fn edges_of_metals() {
    for (base, edge) in [(0.9, 0.5), (0.3, 0.0), (1.0, 0.8)] {
        let cos = 1.0f64 / 7.0;
        let got = super::look::schlick(base, cos) - lacks(base, edge) * super::energy::edge(cos);
        let want = edge * super::look::schlick(base, cos);
        assert!((got - want).abs() < 1e-12, "{got} for {want}");
    }
}

#[test]
fn chi_squared_turned() {
    samples_follow(&turned());
}

#[test]
fn reciprocity_turned() {
    are_reciprocal(&turned());
}

#[test]
fn chi_squared() {
    samples_follow(&some());
}

#[test]
fn reciprocity() {
    are_reciprocal(&some());
}

/// A few surfaces; `cargo verify-long` tries 200.
#[test]
fn furnaces() {
    super::trials::furnaces(12);
}

/// Fibres give no more than they get, however light grazes them.
#[test]
fn grazed_fibres() {
    for roughness in [0.0, 0.1, 0.2, 0.35, 0.7, 1.0] {
        let cloth = StandardSurface {
            base_color: Colour::new([0.0; 3]),
            specular: Scalar::new(0.0),
            sheen_color: Colour::new([1.0; 3]),
            sheen_roughness: Scalar::new(roughness),
            ..StandardSurface::default()
        };
        let mut rng = Rng::new(26, Stream::Check, 0, 0);
        for theta in [80.0, 86.0, 88.0, 89.0, 89.7] {
            let all = furnace(&cloth, theta, 1 << 15, &mut rng);
            assert!(all.mean < 1.01 + 4.0 * all.stderr(), "{roughness}, {theta}°: {} ± {}", all.mean, all.stderr());
        }
    }
}

/// The furnace sees a lobe that is a hundredth too strong.
#[test]
fn the_furnace_bites() {
    let surface = StandardSurface { roughness: Scalar::new(0.7), ..StandardSurface::default() };
    let mut rng = Rng::new(22, Stream::Check, 0, 0);
    let all = furnace(&surface, 50.0, 1 << 16, &mut rng);
    assert!((all.mean - 1.0).abs() < 3.0 * all.stderr() + 2e-3, "{} ± {}", all.mean, all.stderr());
    assert!(1.01 * all.mean - 1.0 > 3.0 * all.stderr() + 2e-3, "{} ± {}", all.mean, all.stderr());
}

/// What a face under a coat keeps is what the model takes away between two directions: no more than that of its facets.
#[test]
fn coats_keep_the_body() {
    let coated = StandardSurface { coat: Scalar::new(1.0), specular: Scalar::new(0.0), ..StandardSurface::default() };
    let mut rng = Rng::new(23, Stream::Check, 0, 0);
    for theta in [0.0, 60.0, 80.0] {
        let all = furnace(&coated, theta, 1 << 16, &mut rng);
        assert!((all.mean - 1.0).abs() < 3.0 * all.stderr() + 2e-3, "{theta}: {} ± {}", all.mean, all.stderr());
    }
}

/// glTF 2.0, appendix B: a smooth metal of base colour c reflects c + (1 − c)(1 − cos)⁵.
#[test]
fn smooth_metals_show_their_colour() {
    for (theta, base) in [(0.0f64, 0.336), (60.0, 0.336), (85.0, 0.336), (0.0, 1.0), (85.0, 0.766)] {
        let surface = StandardSurface {
            base_color: Colour::new([base; 3]),
            metallic: Scalar::new(1.0),
            roughness: Scalar::new(0.0),
            ..StandardSurface::default()
        };
        let want = base + (1.0 - base) * (1.0 - theta.to_radians().cos()).powi(5);
        let all = furnace(&surface, theta, 64, &mut Rng::new(24, Stream::Check, 0, 0));
        assert!((all.mean - want).abs() < 3e-3, "{theta}: {} for {want}", all.mean);
    }
}

/// EON (Portsmouth, Kutz and Hill 2025, equations 7 to 22), which a bare body has to be: its value between some directions,
/// and its albedo by quadrature.
#[test]
fn a_bare_rough_body_is_eon() {
    use std::f64::consts::PI;
    for (roughness, rho) in [(0.3, 0.2), (0.7, 0.8), (1.0, 0.95)] {
        let (principled, look) = principled(StandardSurface {
            base_color: Colour::new([rho; 3]),
            diffuse_roughness: Scalar::new(roughness),
            specular: Scalar::new(0.0),
            ..StandardSurface::default()
        });
        let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        let albedo = |cos: f64| {
            let sin = (1.0 - cos * cos).sqrt();
            let g = sin * (cos.acos() - sin * cos) + 2.0 / 3.0 * (sin / cos * (1.0 - sin.powi(3)) - sin);
            a + roughness * a * g / PI
        };
        let mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
        let many = rho * rho * mean / (1.0 - rho * (1.0 - mean)) / (PI * (1.0 - mean));
        for (theta, other, turn) in
            [(10.0f64, 70.0f64, 0.0f64), (60.0, 60.0, 180.0), (45.0, 20.0, 100.0), (80.0, 75.0, 30.0)]
        {
            let d_in = incoming(theta);
            let turned = turn.to_radians();
            let sin = other.to_radians().sin();
            let wo = DVec3::new(sin * turned.cos(), sin * turned.sin(), other.to_radians().cos());
            let s = -d_in.dot(wo) - wo.z * -d_in.z;
            let t = if s > 0.0 { wo.z.max(-d_in.z) } else { 1.0 };
            let once = rho / PI * a * (1.0 + roughness * s / t);
            let want = once + many * (1.0 - albedo(wo.z)) * (1.0 - albedo(-d_in.z));
            let got = principled.eval(d_in, wo, &look);
            assert!((got - want).abs() < 2e-3 * want, "{theta} {other}: {got} for {want}");
        }
    }
}

/// What facets reflect is no more than all that is scattered, all of it where there is nothing else, and s and p as Fresnel's
/// equations have them (Born and Wolf, 1.5.2) about the facet: none of p at Brewster's angle.
#[test]
fn facets_part_polarisations() {
    let black = StandardSurface {
        base_color: Colour::new([0.0; 3]),
        roughness: Scalar::new(0.6),
        ..StandardSurface::default()
    };
    let (principled, look) = principled(black);
    for (theta, other, turn) in
        [(20.0f64, 50.0f64, 0.3f64), (56.309_932_474_02, 56.309_932_474_02, 0.0), (80.0, 30.0, 2.0)]
    {
        let d_in = incoming(theta);
        let across = DVec3::Z.cross(d_in).normalize_or_zero();
        let forward = DVec3::new(d_in.x, d_in.y, 0.0).normalize_or_zero();
        let sin = other.to_radians().sin();
        let wo = forward * (sin * turn.cos()) + across * (sin * turn.sin()) + DVec3::Z * other.to_radians().cos();
        let facets = principled.polarises(d_in, wo, &look);
        let all = principled.eval(d_in, wo, &look);
        let cos = -d_in.dot((wo - d_in).normalize());
        let inside = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
        let (s, p) = ((cos - 1.5 * inside) / (cos + 1.5 * inside), (1.5 * cos - inside) / (1.5 * cos + inside));
        assert!((facets.s + facets.p - 2.0 * all).abs() < 1e-12 * all, "{facets:?} of {all}");
        assert!((facets.s * p * p - facets.p * s * s).abs() < 1e-12 * facets.s, "{facets:?}: {s} {p}");
        assert!((facets.cross.norm_sq() - facets.s * facets.p).abs() < 1e-12 * facets.s * facets.s, "{facets:?}");
    }
}
