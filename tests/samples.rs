//! The small samples (docs/gallery.md): each against its own oracle, and as it is planned against plain paths from the eye.

mod birdbath;
mod guide;
mod pancake;
mod waveguide;
mod windshield;

use crate::common::{block_z, image, mean, render, worst_z};
use eyebox::film::plan::Estimator;
use eyebox::import::{ImportOptions, Set, import};
use eyebox::plan::scan::light::{Level, LightAsked};
use eyebox::plan::scan::{Position, Scan, ScanAsked, scan};
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::Scene;
use std::path::{Path, PathBuf};
use std::process::Command;

fn sidecar(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("samples/{name}/{name}.optics.toml"))
}

/// A sample with these `--set`.
fn sample(name: &str, sets: &[&str]) -> Scene {
    let sets = sets.iter().map(|text| Set::parse(text).expect("a value")).collect();
    import(&sidecar(name), &ImportOptions { sets, ..ImportOptions::default() }).expect("the sample imports").scene
}

const PLANNED: Asked = Asked { choice: Choice::Auto, polarisation: Polarisation::Auto, guides: Guides::On };

/// The virtual image from a grid of positions, with luminances of the open display of so many passes.
fn scanned(scene: &Scene, positions: [usize; 2], size_m: [f64; 2], passes: Option<u64>) -> Scan {
    let light = passes.map(|passes| LightAsked { resolution: [48, 48], passes, seed: 3, asked: PLANNED });
    let asked = ScanAsked {
        positions,
        size_m: size_m.map(Some),
        ipd_m: 0.063,
        points: [3, 3],
        target: None,
        light,
        edges: false,
    };
    scan(scene, &asked, &|| false, |_| {}).expect("the sample can be scanned").expect("nobody stopped it")
}

/// Where a point of the grid lies on the picture, from its middle to the right and up, in the picture's sides.
fn place(cell: [usize; 2]) -> [f64; 2] {
    let [u, v] = cell.map(|i| 0.005 + 0.99 * i as f64 / 2.0 - 0.5);
    [u, -v]
}

/// Every point of the picture is seen where `want` says, tangents to the right and up of a place in metres, to 0.1′.
fn seen_at(found: &Scan, position: &Position, want: impl Fn([f64; 2]) -> [f64; 2]) {
    assert_eq!(position.seen, 1.0, "{:?}", position.why);
    for line in &position.points {
        let [x, y] = place(line.cell);
        let want = want([x * found.picture_m[0], y * found.picture_m[1]]).map(|tangent| tangent.atan().to_degrees());
        for (got, want) in line.direction_deg.expect("it is seen").into_iter().zip(want) {
            let off = 60.0 * (got - want);
            println!("at {} mm, {:?}: {got}°, want {want}°: {off}′", 1e3 * position.x_m, line.cell);
            assert!(off.abs() < 0.1, "{:?}: {got}°, want {want}°", line.cell);
        }
    }
}

/// A luminance is known to 0.2 % and right within that and 0.5 %, as the samples are meant to be.
fn bright(what: &str, got: Option<Level>, want: f64) {
    let Level { value, sigma } = got.expect("the picture's middle is seen");
    let sigma = sigma.expect("its error is known");
    println!("{what}: {value} ± {sigma}, want {want}");
    assert!(sigma < 2e-3 * want, "{what}: noise {sigma} of {want}");
    assert!((value - want).abs() < 5e-3 * want, "{what}: {value} ± {sigma}, want {want}");
}

/// Luminance of a display that is white all over, straight ahead of a pinhole.
fn straight_ahead(name: &str, eye: &str, (passes, noise): (u64, f64), want: f64) {
    let mut scene = sample(name, &["eye.pupil_diameter=0", "eye.fov_deg=0.4", "DISPLAY.contrast=1", eye]);
    scene.eye.resolution = [8, 8];
    let (got, sigma) = mean(&image(&render(&scene, PLANNED, passes, 3).0));
    println!("{name} {eye}: {got} ± {sigma}, want {want}");
    assert!(sigma < noise * want, "{eye}: noise {sigma} of {want}");
    assert!((got - want).abs() < 4.0 * sigma + 1e-3 * want, "{eye}: {got} ± {sigma}, want {want}");
}

/// As planned the picture is that of plain paths from the eye, in blocks within the Šidák bound of 3 sigma; and the program's
/// witness has nothing to say against it.
fn as_brute_force(name: &str, sets: &[&str], passes: [u64; 2]) {
    let mut scene = sample(name, sets);
    scene.eye.resolution = [48, 27];
    let of = |choice, passes, seed| {
        let (films, _) = render(&scene, Asked { choice, ..PLANNED }, passes, seed);
        for (_, _, ledger) in &films.films {
            // A ray that meets a face within the reach of contact (5e-5 of a face's diameter, 1.2 µm) of the end of a seam between
            // two solids may find itself in the other one. Of the guide's mirrors, 6 mm high, it meets three: 3·2·2·1.2 µm/6 mm.
            assert_eq!(ledger.invalid_paths, 0);
            assert!(ledger.mismatches <= ledger.paths / 400, "{} of {}", ledger.mismatches, ledger.paths);
        }
        image(&films)
    };
    let planned = of(Choice::Auto, passes[0], 1);
    let plain = of(Choice::Only(Estimator::Backward), passes[1], 2);
    let (worst, most) = worst_z(&block_z(&planned, &plain, 48, 9), 2.7e-3);
    println!("{name}: {:?} as planned, {:?} by brute force, worst z {worst} of {most}", mean(&planned), mean(&plain));
    for (light, noise) in [mean(&planned), mean(&plain)] {
        assert!(light > 0.0 && noise < 0.05 * light, "{name}: {light} ± {noise}");
    }
    assert!(worst < most, "{name}: {worst} sigma of {most}");
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    command.arg("render").arg(sidecar(name)).arg("-o").arg(folder.path().join("out.exr"));
    command.args(["--resolution", "48x27", "--samples", "8", "--format", "json"]);
    let out = command.args(sets.iter().flat_map(|set| ["--set", set])).output().expect("the program runs");
    let said = String::from_utf8_lossy(&out.stdout);
    assert!(out.status.success(), "{name}: {said}{}", String::from_utf8_lossy(&out.stderr));
    assert!(said.contains("\"witness\""), "{said}");
}
