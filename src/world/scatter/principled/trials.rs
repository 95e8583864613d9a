//! White and coloured furnaces for surfaces by chance, for tests.

use super::*;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::{Moments, sidak_z};
use eyebox_scene::{Anisotropy, AnisotropyLaw, Colour, Film, Scalar};

pub(in crate::scatter) fn incoming(theta_deg: f64) -> DVec3 {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    DVec3::new(sin * 0.6, sin * 0.8, -cos)
}

pub(super) fn principled(surface: StandardSurface) -> (Principled, Look) {
    let principled = Principled::new(surface.into(), Mesh::default().into());
    let look = Point::plain(&principled.surface).look(None);
    (principled, look)
}

pub(super) fn brushed(strength: f64, law: AnisotropyLaw) -> Option<Anisotropy> {
    Some(Anisotropy { strength: Scalar::new(strength), law, rotation_rad: 0.0, direction: None })
}

pub(super) fn film(weight: f64, ior: f64, nm: f64) -> Option<Film> {
    Some(Film { weight: Scalar::new(weight), ior, thickness_nm: Scalar::new(nm) })
}

/// A surface by chance; `white`: nothing of it absorbs.
fn random(rng: &mut Rng, white: bool) -> StandardSurface {
    // Ends of the range are as common as what lies between.
    let mut share = || match rng.uniform() {
        x if x < 0.25 => Scalar::new(0.0),
        x if x < 0.5 => Scalar::new(1.0),
        x => Scalar::new(2.0 * x - 1.0),
    };
    let mut out = StandardSurface {
        metallic: share(),
        roughness: share(),
        ior: 1.0 + 1.5 * share().factor,
        specular: share(),
        transmission: share(),
        diffuse_transmission: share(),
        ..StandardSurface::default()
    };
    out.diffuse_roughness = share();
    if share().factor > 0.5 {
        let laws = [AnisotropyLaw::Gltf, AnisotropyLaw::OpenPbr, AnisotropyLaw::MaterialX];
        // Strengths have tables of their own: few of them.
        let strength = [0.3, 0.6, 0.9][(share().factor * 2.99) as usize];
        out.anisotropy = brushed(strength, laws[(share().factor * 2.99) as usize]);
    } else if share().factor > 0.5 {
        out.film = film(share().factor, 1.0 + share().factor, 100.0 + 500.0 * share().factor);
    }
    if !white {
        out.metal_edge = Colour::new([share().factor; 3]);
        (out.coat, out.coat_roughness, out.sheen_roughness) = (share(), share(), share());
        let mut colour = || Colour::new([share().factor; 3]);
        out.base_color = colour();
        out.specular_color = colour();
        out.diffuse_transmission_color = colour();
        out.sheen_color = colour();
    }
    out
}

/// What a surface shows of a furnace of luminance 1, scattered and straight through.
pub(super) fn furnace(surface: &StandardSurface, theta_deg: f64, count: u32, rng: &mut Rng) -> Moments {
    let (principled, look) = principled(surface.clone());
    let d_in = incoming(theta_deg);
    let through = principled.passes(-d_in, &look);
    let mut all = Moments::default();
    for _ in 0..count {
        let scattered = principled.sample(d_in, &look, [rng.uniform(), rng.uniform(), rng.uniform()]);
        all.add(through + scattered.map_or(0.0, |s| s.weight));
    }
    all
}

/// No surface gives more than it gets, whatever its parameters; and those of which nothing absorbs give all of it.
pub fn furnaces(sets: usize) {
    const TABLES: f64 = 2e-3;
    let limit = sidak_z(0.001, 3 * sets);
    let mut worst = (0.0, String::new());
    for white in [false, true] {
        for set in 0..sets {
            let mut rng = Rng::new(21, Stream::Check, u64::from(white), set as u64);
            let surface = random(&mut rng, white);
            for theta in [0.0, 50.0, 80.0] {
                let all = furnace(&surface, theta, 1 << 14, &mut rng);
                let (over, error) = (all.mean - 1.0, limit * all.stderr() + TABLES);
                assert!(over < error, "θ {theta}: {} ± {}: {surface:?}", all.mean, all.stderr());
                if white {
                    assert!(over > -error, "θ {theta}: {} ± {}: {surface:?}", all.mean, all.stderr());
                    if over.abs() > worst.0 {
                        worst = (over.abs(), format!("θ {theta} {} ± {}", all.mean, all.stderr()));
                    }
                }
            }
        }
    }
    println!("worst {}", worst.1);
}
