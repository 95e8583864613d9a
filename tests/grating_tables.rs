//! Gratings with tables of efficiencies: a volume hologram by Kogelnik's closed form, polarisation, sides, estimators, carriers.

use crate::common::*;
use eyebox::base::chain::{Link, Step};
use eyebox::base::ids::GratingId;
use eyebox::base::rng::{Rng, Stream};
use eyebox::estimate::ledger::Ledger;
use eyebox::estimate::walk::{Travel, Walker};
use eyebox::film::plan::Estimator;
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::*;
use eyebox::world::World;
use eyebox::world::geometry::Ray;
use eyebox::world::interior::Interior;
use eyebox::world::mode::{Mode, Mono, MonoStokes};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// A volume hologram: lossless, its planes at right angles to the film.
struct Hologram {
    index: f64,
    modulation: f64,
    thickness_nm: f64,
    period_nm: f64,
}

const HOLOGRAM: Hologram = Hologram { index: 1.5, modulation: 0.02, thickness_nm: 10_000.0, period_nm: 1000.0 };

impl Hologram {
    /// Efficiency of order ±1 for light at `angle` outside of the film, of s and of p: H. Kogelnik, "Coupled wave theory for thick
    /// hologram gratings", Bell Syst. Tech. J. 48 (1969) 2909, eqs. 17, 42, 43 and 89. `angle` is above 0 where light travels
    /// towards where order +1 is turned.
    fn first_order(&self, order: f64, nm: f64, angle: f64) -> [f64; 2] {
        let beta = 2.0 * PI * self.index / nm;
        let grating = order * 2.0 * PI / self.period_nm;
        let sine = angle.sin() / self.index;
        let cosine = (1.0 - sine * sine).sqrt();
        let dephasing = -(grating * sine + grating * grating / (2.0 * beta));
        let xi = dephasing * self.thickness_nm / (2.0 * cosine);
        // Of p by the cosine of the angle between the fields, which is that between the directions.
        [1.0, (2.0 * sine.asin()).cos()].map(|between| {
            let nu = PI * self.modulation * self.thickness_nm / (nm * cosine) * between;
            nu.hypot(xi).sin().powi(2) / (1.0 + (xi / nu).powi(2))
        })
    }

    /// As a file, the angles in steps of a tenth of a degree.
    fn table(&self) -> String {
        let mut text = "wavelength_nm,angle_deg,order,T_s,T_p\n".to_owned();
        for nm in (500..=600).step_by(10) {
            for tenth in -400..=400 {
                let (nm, degrees) = (f64::from(nm), f64::from(tenth) / 10.0);
                let [up, down] = [1.0, -1.0].map(|order| self.first_order(order, nm, degrees.to_radians()));
                let straight = [0, 1].map(|k| (1.0 - up[k] - down[k]).max(0.0));
                for (order, [s, p]) in [(-1, down), (0, straight), (1, up)] {
                    // Two waves each: both orders at once are a little too much between their angles.
                    let [s, p] = [(s, 0), (p, 1)].map(|(share, k)| share / (up[k] + down[k]).max(1.0));
                    writeln!(text, "{nm},{degrees},{order},{s},{p}").unwrap();
                }
            }
        }
        text
    }
}

/// Parts of a folder: an asset with one square of 2 m across z at 0 and this said of it.
fn asset(folder: &Path, finish: &str, files: &[(&str, &str)]) -> std::path::PathBuf {
    let at = |name: &str| folder.join(name);
    let positions: Vec<u8> = [-1f32, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(at("pane.bin"), [positions, indices].concat()).unwrap();
    let gltf = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "PANE" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [{ "uri": "pane.bin", "byteLength": 60 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 12 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
    });
    std::fs::write(at("pane.gltf"), gltf.to_string()).unwrap();
    for (name, text) in files {
        std::fs::write(at(name), text).unwrap();
    }
    std::fs::write(
        at("pane.optics.toml"),
        format!(
            "schema = 1\nasset = \"pane.gltf\"\nwavelengths = {{ mono_nm = 550 }}\n[[bind]]\npath = \"PANE\"\n\
             finish = {{ kind = \"grating\", direction = [0, 1, 0], lines_per_mm = 1000, rest = \"absorbed\", {finish} }}\n\
             [sky]\nluminance_cd_m2 = 1000\n\
             [eye]\nposition = [0, 0, \"0.3 m\"]\nlook = [0, 0, -1]\nup = [0, 1, 0]\npupil_diameter = \"4 mm\"\nfov_deg = 10\n"
        ),
    )
    .unwrap();
    at("pane.optics.toml")
}

/// The share that one order of the first face met has of light along `dir`, and where it goes; from the eye: of light that comes
/// back along the path.
fn followed<M: Mode>(world: &World, travel: Travel, dir: DVec3, orders: &[(Step, i32)]) -> Option<(f64, DVec3)> {
    let optics = M::optics(world, 0, 0);
    let origin = -0.4 * dir - world.geometry.origin();
    let rng = Rng::new(0, Stream::Check, 0, 0);
    let ray = Ray { origin, dir, from: None };
    let mut walker = Walker::<M>::new((world, &optics), travel, ray, 1.0, Interior::default(), rng);
    let mut ledger = Ledger::new(world.solids.len());
    let links = orders.iter().enumerate().map(|(part, (step, order))| Link {
        part: part as u32,
        face: 0,
        step: *step,
        order: *order,
    });
    walker.follow(links, &mut ledger, |_, _, _| {}).then(|| (walker.beam.weight(), walker.ray.dir))
}

fn towards(degrees: f64) -> DVec3 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    DVec3::new(0.0, sine, -cosine)
}

/// Light through the hologram, and paths from the eye the other way, at angles between those of the file and at its wavelengths and
/// between them: as the closed form has it, to what linear interpolation leaves. It is selective: what goes up at −θ does not at θ.
#[test]
fn a_volume_hologram_is_kogelniks() {
    let folder = tempfile::tempdir().unwrap();
    let sidecar = asset(folder.path(), "efficiencies = \"hologram.csv\"", &[("hologram.csv", &HOLOGRAM.table())]);
    let mut scene = import(&sidecar, &ImportOptions::default()).unwrap().scene;
    let (mut most, mut least_of_peaks) = (0f64, 1f64);
    for nm in [500.0, 532.0, 550.0, 577.0, 600.0] {
        scene.wavelengths = Wavelengths::Mono { nm };
        let world = World::freeze(&scene).unwrap();
        let bragg = (nm / (2.0 * HOLOGRAM.period_nm)).asin().to_degrees();
        for step in -70..=70 {
            let degrees = 0.517 * f64::from(step);
            for order in [1, -1] {
                let dir = towards(degrees);
                let link = [(Step::Through, order)];
                let want = HOLOGRAM.first_order(f64::from(order), nm, degrees.to_radians());
                let Some((light, onward)) = followed::<Mono>(&world, Travel::FromLamp, dir, &link) else { continue };
                most = most.max((light - 0.5 * (want[0] + want[1])).abs());
                // n sin θ' = n sin θ + m λ/d.
                let sine = dir.y + f64::from(order) * nm / HOLOGRAM.period_nm;
                assert!((onward.y - sine).abs() < 1e-12 && onward.z < 0.0);
                let eye = followed::<Mono>(&world, Travel::FromEye, -onward, &link).expect("the way back");
                assert!((eye.0 - light).abs() < 1e-9 && eye.1.distance(-dir) < 1e-9, "{eye:?} {light}");
            }
        }
        let [at, beside] = [-bragg, bragg].map(|degrees| {
            followed::<Mono>(&world, Travel::FromLamp, towards(degrees), &[(Step::Through, 1)]).unwrap().0
        });
        least_of_peaks = least_of_peaks.min(at);
        assert!(beside < 0.06 && at > 10.0 * beside, "{nm} nm: {at} at the Bragg angle, {beside} on the other side");
    }
    println!("off by up to {most:.2e}, peaks of {least_of_peaks} at least");
    assert!(most < 3e-3 && least_of_peaks > 0.7, "{most} {least_of_peaks}");
}

fn grid(values: Vec<Efficiency>) -> EfficiencyGrid {
    EfficiencyGrid { nm: vec![550.0], angle: vec![0.0], conical: vec![0.0], values }
}

fn table(orders: Vec<i32>, front: EfficiencyGrid, back: Option<EfficiencyGrid>) -> Orders {
    Orders::Table(EfficiencyTable { file: "made.csv".to_owned(), orders, front, back }.into())
}

fn sp(s: f64, p: f64) -> Efficiency {
    Efficiency { transmittance: [s, p], reflectance: [0.0; 2] }
}

fn pane(s: &mut Scene, z: f64, direction: DVec3, lines_per_mm: f64, orders: Orders, rest_in_zero_order: bool) {
    s.gratings.push(Grating { direction, lines_per_mm, orders, rest_in_zero_order });
    let finish = Finish::Grating { grating: GratingId::from_index(s.gratings.len() - 1) };
    let wide = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
    add_part(s, &format!("pane at {z}"), wide, DVec3::new(0.0, 0.0, z), None, vec![face(finish)]);
}

/// Two gratings one after the other: where their lines are parallel each polarisation meets its own share twice, where they are
/// crossed both; without polarisation the means are multiplied. The rest of a grating is that of each polarisation, too.
#[test]
fn polarisations_have_their_own_shares() {
    let [s, p] = [0.6, 0.2];
    for (across, order, rest, want) in [
        (DVec3::Y, 0, false, 0.5 * (s * s + p * p)),
        (DVec3::X, 0, false, s * p),
        (DVec3::new(1.0, 1.0, 0.0), 0, false, 0.25 * (s + p) * (s + p)),
        (DVec3::Y, 1, true, 0.5 * ((1.0 - s) * (1.0 - s) + (1.0 - p) * (1.0 - p))),
        (DVec3::X, 1, true, (1.0 - s) * (1.0 - p)),
    ] {
        let mut scene = scene();
        for (z, direction) in [(0.0, DVec3::Y), (-0.1, across)] {
            pane(&mut scene, z, direction, 300.0, table(vec![order], grid(vec![sp(s, p)]), None), rest);
        }
        let world = World::freeze(&scene).unwrap();
        let links = [(Step::Through, 0), (Step::Through, 0)];
        for travel in [Travel::FromLamp, Travel::FromEye] {
            let of = |got: Option<(f64, DVec3)>| got.expect("it goes straight on").0;
            let polarised = of(followed::<MonoStokes>(&world, travel, DVec3::NEG_Z, &links));
            let plain = of(followed::<Mono>(&world, travel, DVec3::NEG_Z, &links));
            let mean = if rest { 1.0 - 0.5 * (s + p) } else { 0.5 * (s + p) };
            assert!((polarised - want).abs() < 1e-12, "{across} {order} {travel:?}: {polarised}, want {want}");
            assert!((plain - mean * mean).abs() < 1e-12, "{plain}");
        }
        let asked = Asked { choice: Choice::Auto, polarisation: Polarisation::Auto, guides: Guides::On };
        uniform_sky(&mut scene, 1.0);
        assert!(render(&scene, asked, 1, 1).1.mode.polarised, "the plan follows polarisation");
    }
}

/// Light from the front, from the back, and both seen from the eye: the side is where the light arrives.
#[test]
fn sides_are_where_the_light_arrives() {
    let mut scene = scene();
    let even = |share: f64, back: f64| Efficiency::even(share, back);
    let (front, back) = (grid(vec![even(0.5, 0.25)]), grid(vec![even(0.125, 0.0625)]));
    pane(&mut scene, 0.0, DVec3::Y, 300.0, table(vec![0], front, Some(back)), false);
    let world = World::freeze(&scene).unwrap();
    for (dir, through, reflected) in [(DVec3::NEG_Z, 0.5, 0.25), (DVec3::Z, 0.125, 0.0625)] {
        let of =
            |travel: Travel, dir: DVec3, step: Step| followed::<Mono>(&world, travel, dir, &[(step, 0)]).unwrap().0;
        assert_eq!(of(Travel::FromLamp, dir, Step::Through), through);
        assert_eq!(of(Travel::FromLamp, dir, Step::Back), reflected);
        assert_eq!(of(Travel::FromEye, -dir, Step::Through), through);
        assert_eq!(of(Travel::FromEye, dir, Step::Back), reflected);
    }
}

/// Light tracing, connection and whatever the plan chooses see a lamp through a table that tells angles, sides and polarisations
/// apart as rays from the eye see it.
#[test]
fn estimators_agree_about_a_table() {
    let mut s = scene();
    (s.eye.fov_deg, s.eye.resolution, s.eye.pupil_diameter_m) = (8.0, [8, 8], 0.06);
    let angles = 9;
    let axis = |k: usize| (k as f64 / (angles - 1) as f64 - 0.5) * PI;
    let of_side = |turn: f64| {
        let one = |k: usize, order: f64| {
            let bump = (-(axis(k) + order * 0.4 + turn).powi(2) / 0.1).exp();
            Efficiency { transmittance: [0.4 * bump, 0.25 * bump], reflectance: [0.05, 0.1] }
        };
        let values = [1.0, -1.0].iter().flat_map(|order| (0..angles).map(move |k| one(k, *order))).collect();
        EfficiencyGrid { nm: vec![550.0], angle: (0..angles).map(axis).collect(), conical: vec![0.0], values }
    };
    let start = DVec3::new(0.0, 0.0, -0.3);
    pane(&mut s, start.z, DVec3::Y, 0.5 / 550e-6, table(vec![1, -1], of_side(0.0), Some(of_side(0.2))), true);
    // A second one straight behind the first leaves polarised light at what the first left so.
    pane(&mut s, start.z - 0.02, DVec3::Y, 100.0, table(vec![0], grid(vec![sp(0.9, 0.5)]), None), false);
    let group = add_group(&mut s, "panel");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, 1000.0);
    let dir = DVec3::new(0.0, 0.5, -0.75f64.sqrt());
    let across = (-dir).cross(DVec3::X);
    let part = add_part(
        &mut s,
        "panel",
        mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, across * 0.02)]),
        DVec3::ZERO,
        None,
        vec![shining],
    );
    s.parts[part].to_world = DAffine3::from_translation(start + 0.2 * dir);
    let seen = |choice: Choice, passes: u64, seed: u64| {
        let asked = Asked { choice, polarisation: Polarisation::Auto, guides: Guides::On };
        let (films, plan) = render(&s, asked, passes, seed);
        assert!(plan.mode.polarised);
        for (_, _, ledger) in &films.films {
            assert_eq!((ledger.invalid_paths, ledger.mismatches), (0, 0));
        }
        mean(&image(&films))
    };
    let (want, sigma) = seen(Choice::Only(Estimator::Backward), 1024, 3);
    assert!(sigma < 0.02 * want, "noise {sigma} of {want}");
    let asked =
        [(Choice::Only(Estimator::Forward), 512), (Choice::Only(Estimator::Manifold), 256), (Choice::Auto, 256)];
    for (choice, passes) in asked {
        let (got, noise) = seen(choice, passes, 7);
        println!("{choice:?}: {got} ± {noise}, want {want} ± {sigma}");
        assert!(noise < 0.05 * want, "noise {noise} of {want}");
        assert!((got - want).abs() < 3.0 * noise.hypot(sigma), "{choice:?}: {got} ± {noise}, want {want} ± {sigma}");
    }
}

fn eyebox(arguments: &[&Path]) -> (Option<i32>, String, String) {
    let out = Command::new(env!("CARGO_BIN_EXE_eyebox")).args(arguments).output().expect("the program runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (out.status.code(), text(out.stdout), text(out.stderr))
}

/// A table goes with its asset into glTF and USD, and says the same there.
#[test]
fn tables_are_carried() {
    const TABLE: &str = "wavelength_nm,angle_deg,order,T_s,T_p,R\n500,0,1,0.5,0.25,0.1\n600,0,1,0.7,0.1,0\n";
    let folder = tempfile::tempdir().unwrap();
    let sidecar = asset(folder.path(), "efficiencies = \"tables/a.csv\"", &[]);
    std::fs::create_dir(folder.path().join("tables")).unwrap();
    std::fs::write(folder.path().join("tables/a.csv"), TABLE).unwrap();
    let of = |file: &Path| match import(file, &ImportOptions::default()).unwrap().scene.gratings.as_slice() {
        [Grating { orders: Orders::Table(table), .. }] => {
            EfficiencyTable { file: String::new(), ..EfficiencyTable::clone(table) }
        }
        other => panic!("{}: {other:?}", file.display()),
    };
    let want = of(&sidecar);
    assert_eq!(want.front.values[1].transmittance, [0.7, 0.1]);
    let elsewhere = tempfile::tempdir().unwrap();
    for name in ["a.glb", "a.gltf", "a.usda", "a.usdc", "a.usdz"] {
        let to = elsewhere.path().join(name);
        let (code, _, said) = eyebox(&[Path::new("convert"), &sidecar, &to]);
        assert_eq!((code, said.as_str()), (Some(0), ""), "{name}");
        assert_eq!(of(&to), want, "{name}");
        let (code, listed, _) = eyebox(&[Path::new("inspect"), &to]);
        assert_eq!(code, Some(0));
        assert!(
            listed.contains("orders +1 by ") && listed.contains("(2 wavelengths x 1 angles, both sides alike)"),
            "{listed}"
        );
    }
}

/// Files that are not what they should be end the program with one line that names the file; `validate` finds them, too.
#[test]
fn broken_tables_are_one_line() {
    const GOOD: &str = "wavelength_nm,angle_deg,order,T\n550,-10,1,0.5\n550,10,1,0.5\n550,-10,-1,0.5\n550,10,-1,0.5\n";
    let folder = tempfile::tempdir().unwrap();
    let sidecar = asset(folder.path(), "efficiencies = \"a.csv\"", &[("a.csv", GOOD)]);
    assert_eq!(eyebox(&[Path::new("inspect"), &sidecar]).0, Some(0));
    for (bad, what) in [
        (
            GOOD.replacen("0.5", "0.6", 1),
            "a.csv:4: the orders together have 1.1 of s-polarised light of 550 nm at -10°",
        ),
        (GOOD.replacen("550,10,1,0.5\n", "", 1), "a.csv: no line for order 1, 550 nm, 10°"),
        (GOOD.replacen("angle_deg", "angle", 1), "a.csv:1: `angle` is no column of efficiencies"),
        (GOOD[..GOOD.len() - 5].to_owned(), "a.csv:5: "),
        ("\0\u{1}".to_owned(), "a.csv:1: "),
        (String::new(), "a.csv: the table of efficiencies is empty"),
    ] {
        std::fs::write(folder.path().join("a.csv"), &bad).unwrap();
        let (code, _, said) = eyebox(&[Path::new("inspect"), &sidecar]);
        assert!(code == Some(2) && said.trim_end().lines().count() == 1 && said.contains(what), "{code:?}: {said}");
        let (code, found, _) = eyebox(&[Path::new("validate"), &sidecar]);
        let (file, text) = what.split_once(": ").expect("a place and a fault");
        assert!(code == Some(1) && found.contains(file) && found.contains(text), "{code:?}: {found}");
    }
    std::fs::remove_file(folder.path().join("a.csv")).unwrap();
    let (code, _, said) = eyebox(&[Path::new("inspect"), &sidecar]);
    assert!(code == Some(2) && said.contains("a.csv: there is no such file"), "{said}");
    for (finish, what) in [
        (
            "efficiencies = \"a.csv\", orders = [{ order = 1, T = 1 }]",
            "has `orders` and `efficiencies`; expected one of them",
        ),
        ("transmittance = 1", "expected one of direction, lines_per_mm, orders, efficiencies"),
    ] {
        let (code, _, said) = eyebox(&[Path::new("inspect"), &asset(folder.path(), finish, &[])]);
        assert!(code == Some(2) && said.trim_end().lines().count() == 1 && said.contains(what), "{code:?}: {said}");
    }
    let rest = asset(folder.path(), "efficiencies = \"a.csv\"", &[("a.csv", &GOOD.replace(",-1,", ",0,"))]);
    let text = std::fs::read_to_string(&rest).unwrap().replace("\"absorbed\"", "\"zero_order\"");
    std::fs::write(&rest, text).unwrap();
    let (code, _, said) = eyebox(&[Path::new("inspect"), &rest]);
    assert!(code == Some(2) && said.contains("order 0 has the rest: it has no shares of its own"), "{said}");
}
