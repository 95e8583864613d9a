use super::super::fresnel::{fresnel, fresnel_turning, reflect, refract};
use super::super::thinfilm::{Film, stack, stack_turning};
use super::*;
use proptest::prelude::*;

fn unit() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(|(z, phi)| {
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    })
}

/// A face of a chain: the normal, the index beyond, whether the light is reflected there.
fn faces() -> impl Strategy<Value = Vec<(DVec3, Complex, bool)>> {
    let beyond = prop_oneof![
        (1.0..2.2f64).prop_map(Complex::real),
        (0.1..3.0f64, 0.5..6.0f64).prop_map(|(n, k)| Complex::new(n, k)),
    ];
    prop::collection::vec((unit(), beyond, any::<bool>()), 1..6)
}

/// Complex field in space: E = re + i im.
#[derive(Clone, Copy)]
struct Field {
    re: DVec3,
    im: DVec3,
}

impl Field {
    fn along(self, axis: DVec3) -> Complex {
        Complex::new(self.re.dot(axis), self.im.dot(axis))
    }
    fn power(self) -> f64 {
        self.re.length_squared() + self.im.length_squared()
    }
}

/// One step of a chain: where the light comes from and goes, and the power-normalised amplitudes.
struct Step {
    dir: DVec3,
    out: DVec3,
    normal: DVec3,
    turning: Turning,
    reflects: bool,
    a_s: Complex,
    a_p: Complex,
}

/// Light that starts in a medium of index 1.5 along `dir`. The amplitudes are the textbook's, without factoring.
fn chain(dir: DVec3, faces: &[(DVec3, Complex, bool)]) -> Vec<Step> {
    let (mut dir, mut n1) = (dir, 1.5);
    let mut steps = Vec::new();
    for &(normal, n2, reflects) in faces {
        let normal = if dir.dot(normal) > 0.0 { -normal } else { normal };
        let c = -dir.dot(normal);
        if c < 0.02 {
            break;
        }
        let turning = fresnel_turning(n1, n2, c);
        let refracted = if n2.im == 0.0 { refract(dir, normal, n1 / n2.re) } else { None };
        let through = !reflects && refracted.is_some() && turning.power.t_s > 0.0;
        let q1 = Complex::real(n1 * c);
        let n2_sq = n2 * n2;
        let q2 = (n2_sq - Complex::real(n1 * n1 * (1.0 - c * c))).sqrt();
        let (sum_s, sum_p) = (q1 + q2, n2_sq * q1 + q2 * (n1 * n1));
        let (a_s, a_p) = if through {
            let power = (q2.re / q1.re).sqrt();
            (q1 * (2.0 * power) / sum_s, q1 * n2 * (2.0 * n1 * power) / sum_p)
        } else {
            ((q1 - q2) / sum_s, (n2_sq * q1 - q2 * (n1 * n1)) / sum_p)
        };
        let out = match refracted {
            Some(out) if through => out,
            Some(_) | None => reflect(dir, normal),
        };
        steps.push(Step { dir, out, normal, turning, reflects: !through, a_s, a_p });
        if through {
            n1 = n2.re;
        }
        dir = out;
    }
    steps
}

proptest! {
    /// The power of a linearly polarised wave through a chain of faces, by its field in space (Chipman, Lam and Young,
    /// "Polarized Light and Optical Systems", chapter 9), by Stokes vectors from the lamp, and by importance from the eye.
    #[test]
    fn stokes_vectors_follow_the_field(dir in unit(), turn in 0.0..6.3f64, faces in faces()) {
        let steps = chain(dir, &faces);
        prop_assume!(!steps.is_empty());
        let first = dir.any_orthonormal_vector();
        let start = first * turn.cos() + dir.cross(first) * turn.sin();

        let mut field = Field { re: start, im: DVec3::ZERO };
        for step in &steps {
            let s = step.normal.cross(step.dir).normalize();
            let (e_s, e_p) = (step.a_s * field.along(s), step.a_p * field.along(step.dir.cross(s)));
            let p = step.out.cross(s);
            field = Field { re: s * e_s.re + p * e_p.re, im: s * e_s.im + p * e_p.im };
        }

        let go = |amount: Stokes, step: &Step, axis: DVec3, dir: DVec3, normal: DVec3, from_eye: bool| {
            let s = Stokes::face_axis(axis, dir, normal);
            let turned = amount.turned(axis, s, dir);
            let parted = turned.part(&step.turning, from_eye);
            if step.reflects {
                // One facet that reflects all that is scattered does the same.
                let mut facets = Facets::NONE;
                let all = step.turning.power.reflectance();
                facets.add(1.0, &step.turning);
                return (turned.scattered(&facets, from_eye).scaled(all), s);
            }
            (parted.transmitted, s)
        };
        let (mut light, mut axis) = (Stokes([1.0, 1.0, 0.0, 0.0]), start);
        let mut between = vec![(light, axis)];
        for step in &steps {
            (light, axis) = go(light, step, axis, step.dir, step.normal, false);
            between.push((light, axis));
            prop_assert!(light.degree() < 1.0 + 1e-9, "{light:?}");
        }
        let (mut seen, mut axis_back) = (Stokes::plain(1.0), Stokes::any_axis(-steps[steps.len() - 1].out));
        for step in steps.iter().rev() {
            // The other way round: refracted light meets the face from behind.
            let normal = if step.reflects { step.normal } else { -step.normal };
            // Where importance meets the light, wherever that is, they have the power that arrives.
            let met = |(seen, axis): (Stokes, DVec3), dir: DVec3, (light, of_light): (Stokes, DVec3)| {
                seen.meets(axis, dir, light.state(), of_light).power() * light.power()
            };
            let (after, before) = (between.pop().expect("one a step"), between[between.len() - 1]);
            let on = met((seen, axis_back), -step.out, after);
            (seen, axis_back) = go(seen, step, axis_back, -step.out, normal, true);
            let back = met((seen, axis_back), -step.dir, before);
            prop_assert!((on - field.power()).abs() < 1e-10 && (back - field.power()).abs() < 1e-10, "{on} {back}");
        }
        let met = seen.turned(axis_back, start, -dir).polarised_by_slide(1.0, true).power();
        let want = field.power();
        prop_assert!((light.power() - want).abs() < 1e-10 * (1.0 + want), "lamp {} field {want}", light.power());
        prop_assert!((met - want).abs() < 1e-10 * (1.0 + want), "eye {met} field {want}");
        let _ = axis;
    }

    /// A stack of no films, and films of the medium before or behind them, have the phases of the bare interface.
    #[test]
    fn phases_of_films_that_are_not_there(n in 1.0..2.2f64, k in 0.0..4.0f64, c in 0.05..1.0f64, nm in 1.0..400.0f64) {
        let n2 = Complex::new(n, if k < 1.0 { 0.0 } else { k });
        let bare = fresnel_turning(1.3, n2, c);
        prop_assume!(bare.power.r_s > 1e-6 && bare.power.r_p > 1e-6);
        let same = stack_turning(1.3, &[Film { n: n2, thickness_nm: nm }], n2, c, 550.0);
        prop_assert!((same.reflected - bare.reflected).norm_sq() < 1e-12, "{same:?} {bare:?}");
        // A film of the near medium delays both polarisations alike.
        let before = stack_turning(1.3, &[Film { n: Complex::real(1.3), thickness_nm: nm }], n2, c, 550.0);
        prop_assert!((before.reflected - bare.reflected).norm_sq() < 1e-12, "{before:?} {bare:?}");
    }

    /// Shares of every amount add up, and a polarised amount averages to the unpolarised one.
    #[test]
    fn shares_add_up(i in 0.1..2.0f64, q in -1.0..1.0f64, c in 0.0..1.0f64, n in 0.3..3.0f64, k in 0.0..3.0f64) {
        let n2 = Complex::new(n, k);
        let film = [Film { n: Complex::new(2.0, 0.1), thickness_nm: 80.0 }];
        for turning in [fresnel_turning(1.2, n2, c), stack_turning(1.2, &film, n2, c, 500.0)] {
            let [r, t, a] = Stokes([i, q * i, 0.0, 0.0]).part(&turning, false).shares;
            prop_assert!((r + t + a - 1.0).abs() < 1e-12);
            let [r0, t0, a0] = 1.0f64.part(&turning, false).shares;
            let [r1, t1, a1] = Stokes([i, -q * i, 0.0, 0.0]).part(&turning, false).shares;
            prop_assert!((r + r1 - 2.0 * r0).abs() + (t + t1 - 2.0 * t0).abs() + (a + a1 - 2.0 * a0).abs() < 1e-12);
        }
        prop_assert_eq!(fresnel_turning(1.2, n2, c).power, fresnel(1.2, n2, c));
        prop_assert_eq!(stack_turning(1.2, &film, n2, c, 500.0).power, stack(1.2, &film, n2, c, 500.0));
    }

    /// Turning the reference direction keeps power and degree, and there and back is the identity.
    #[test]
    fn turning_the_axis(dir in unit(), a in 0.0..6.3f64, b in 0.0..6.3f64, q in -1.0..1.0f64, u in -1.0..1.0f64) {
        let x = dir.any_orthonormal_vector();
        let axis = |angle: f64| x * angle.cos() + dir.cross(x) * angle.sin();
        let start = Stokes([2.0, q, u, 0.3]);
        let turned = start.turned(axis(a), axis(b), dir);
        prop_assert!((turned.degree() - start.degree()).abs() < 1e-12);
        let back = turned.turned(axis(b), axis(a), dir);
        prop_assert!((0..4).all(|k| (back.0[k] - start.0[k]).abs() < 1e-12));
        // Malus: through a polariser at an angle to linearly polarised light.
        let linear = Stokes([1.0, 1.0, 0.0, 0.0]).turned(axis(a), axis(b), dir);
        prop_assert!(((linear.0[0] + linear.0[1]) / 2.0 - (b - a).cos().powi(2)).abs() < 1e-12);
    }
}

/// A quarter-wave: a Fresnel rhomb of n = 1.51 turns linear light at 45° into circular light (Born and Wolf, section
/// 1.5.4: two total reflections at 54°37′).
#[test]
fn fresnel_rhomb() {
    let angle = (54.0 + 37.0 / 60.0f64).to_radians();
    let turning = fresnel_turning(1.51, Complex::ONE, angle.cos());
    let once = Stokes([1.0, 0.0, 1.0, 0.0]).part(&turning, false).reflected;
    let twice = once.part(&turning, false).reflected;
    assert!((twice.0[3].abs() - 1.0).abs() < 1e-4, "{twice:?}");
    assert!((twice.degree() - 1.0).abs() < 1e-12);
}
