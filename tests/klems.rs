//! Films measured as WINDOW and Radiance have them (LBNL's XML): what is sampled against the file's own matrix, a Lambertian film in a
//! uniform sky, files that are not what they should be.

use crate::common::{add_part, face, image, mean, mesh, quad, render, scene, uniform_sky};
use eyebox::base::Where;
use eyebox::base::ids::ScatterId;
use eyebox::base::rng::{Rng, Stream};
use eyebox::import::optics::{MeasuredFile, scatter_table};
use eyebox::plan::Choice;
use eyebox::scene::{Finish, Note, ScatterTable};
use eyebox::world::scatter::{Measured, Scatter, Sides};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

/// The full basis: where rings begin, degrees, and their patches.
const RINGS: [(f64, usize); 9] =
    [(0.0, 1), (5.0, 8), (15.0, 16), (25.0, 20), (35.0, 24), (45.0, 24), (55.0, 24), (65.0, 16), (75.0, 12)];

fn ring_of(mut patch: usize) -> usize {
    let mut ring = 0;
    while patch >= RINGS[ring].1 {
        patch -= RINGS[ring].1;
        ring += 1;
    }
    ring
}

fn bounds(ring: usize) -> [f64; 2] {
    [RINGS[ring].0, RINGS.get(ring + 1).map_or(90.0, |next| next.0)].map(f64::to_radians)
}

/// A value by the rings of incidence and leaving.
type Value<'v> = &'v dyn Fn(usize, usize) -> f64;

/// A file of blocks, their values by the rings of incidence and leaving.
fn file(blocks: &[(&str, Value<'_>)]) -> String {
    let mut out =
        "<?xml version=\"1.0\"?>\n<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns\
                   </IncidentDataStructure></DataDefinition><WavelengthData><Wavelength>Visible</Wavelength>\n"
            .to_owned();
    for (direction, value) in blocks {
        let numbers: Vec<String> =
            (0..145 * 145).map(|k| format!("{:.9}", value(ring_of(k % 145), ring_of(k / 145)))).collect();
        out += &format!(
            "<WavelengthDataBlock><WavelengthDataDirection>{direction}</WavelengthDataDirection><ColumnAngleBasis>LBNL/Klems Full\
             </ColumnAngleBasis><RowAngleBasis>LBNL/Klems Full</RowAngleBasis><ScatteringData>\n{}\n</ScatteringData>\
             </WavelengthDataBlock>\n",
            numbers.join(", ")
        );
    }
    out + "</WavelengthData></Layer></Optical></WindowElement>\n"
}

fn table(text: &str, notes: &mut Vec<Note>) -> ScatterTable {
    let source = MeasuredFile { bytes: text.as_bytes().to_vec(), file: Path::new("a.xml"), at: &Where::Nowhere };
    scatter_table(&[source], notes).expect("a film")
}

/// Light that is sampled lands in each ring and octant as the file's row says: chi² of the weighted counts.
#[test]
fn light_goes_where_the_matrix_says() {
    let near = |share: f64| move |a: usize, b: usize| share * (-(a as f64 - b as f64).powi(2) / 6.0).exp();
    let (reflected, transmitted) = (near(0.05), near(0.18));
    let mut notes = Vec::new();
    let table = table(&file(&[("Reflection Front", &reflected), ("Transmission Front", &transmitted)]), &mut notes);
    assert_eq!(notes, [], "sums of rows are those of the file");
    let scatter = Scatter::Measured(Arc::new(Measured::new(&table)));
    let count = 200_000;
    for from in [1, 3, 6] {
        let [low, high] = bounds(from);
        let (sin, cos) = (0.5 * (low + high)).sin_cos();
        let d_in = DVec3::new(sin * 0.6, sin * 0.8, -cos);
        let mut rng = Rng::new(5, Stream::Check, from as u64, 0);
        let mut sums = vec![[0.0; 2]; 2 * 9 * 8];
        for _ in 0..count {
            let u = [rng.uniform(), rng.uniform(), rng.uniform()];
            let Some(sampled) = scatter.sample(d_in, Sides::AIR, u) else { continue };
            let theta = sampled.dir.z.abs().acos();
            let ring = (0..9).rev().find(|ring| bounds(*ring)[0] <= theta).expect("a ring");
            let octant = ((sampled.dir.y.atan2(sampled.dir.x).rem_euclid(TAU) / TAU * 8.0) as usize).min(7);
            let cell = &mut sums[(usize::from(sampled.dir.z < 0.0) * 9 + ring) * 8 + octant];
            cell[0] += sampled.weight;
            cell[1] += sampled.weight * sampled.weight;
        }
        let (mut chi2, mut cells, mut all) = (0.0, 0.0, 0.0);
        for (index, [sum, squares]) in sums.iter().enumerate() {
            let (side, ring) = (index / 72, index / 8 % 9);
            let [low, high] = bounds(ring);
            let value = if side == 0 { reflected(from, ring) } else { transmitted(from, ring) };
            let want = value * PI * (high.sin().powi(2) - low.sin().powi(2)) / 8.0;
            let n = f64::from(count);
            let mean = sum / n;
            all += want;
            // Cells that few samples meet tell nothing.
            if want * n > 200.0 {
                let variance = (squares / n - mean * mean) / n;
                chi2 += (mean - want).powi(2) / variance;
                cells += 1.0;
            }
        }
        assert!(cells > 40.0 && all < 1.0, "{cells} {all}");
        // Wilson and Hilferty's normal approximation of chi-squared.
        let z = ((chi2 / cells).cbrt() - (1.0 - 2.0 / (9.0 * cells))) / (2.0_f64 / (9.0 * cells)).sqrt();
        println!("ring {from}: chi² {chi2:.1} of {cells}, z {z:.2}");
        assert!(z < 3.5, "ring {from}: chi² {chi2} of {cells}, z {z}");
    }
}

/// A Lambertian film before a uniform sky sends on the shares that it has, from wherever it is looked at.
#[test]
fn a_lambertian_film_in_a_uniform_sky() {
    let (reflectance, transmittance, sky) = (0.3, 0.6, 100.0);
    let blocks: [(&str, Value<'_>); 2] =
        [("Reflection Back", &|_, _| reflectance / PI), ("Transmission Back", &|_, _| transmittance / PI)];
    let mut scene = scene();
    uniform_sky(&mut scene, sky as f32);
    scene.scatters.push(table(&file(&blocks), &mut Vec::new()));
    let film = mesh(&[quad(DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0)]);
    let finish = Finish::Measured { table: ScatterId::from_index(0) };
    add_part(&mut scene, "film", film, DVec3::new(0.0, 0.0, -0.5), None, vec![face(finish)]);
    scene.eye.resolution = [8, 8];
    let (films, _) = render(&scene, Choice::Auto, 64, 1);
    let (got, sigma) = mean(&image(&films));
    let want = sky * (reflectance + transmittance);
    println!("{got} ± {sigma}, want {want}");
    assert!((got - want).abs() < 4.0 * sigma + 1e-4 * want && sigma < 0.01 * want, "{got} ± {sigma}, want {want}");
}

/// Files that are not what they should be end the program with one line and exit code 2.
#[test]
fn broken_files_are_one_line() {
    let good = file(&[("Transmission Front", &|_, _| 0.1)]);
    let dir = tempfile::tempdir().expect("a folder");
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud_direct.glb");
    std::fs::copy(sample, dir.path().join("hud.glb")).expect("the sample");
    let sidecar = dir.path().join("hud.optics.toml");
    std::fs::write(
        &sidecar,
        "schema = 1\nasset = \"hud.glb\"\nunit = 0.001\n[default]\nfinish = { kind = \"measured\", file = \"a.xml\" }\n\
         [eye]\nposition = [0, 0, 0]\nlook = [0, 0, -1]\nup = [0, 1, 0]\npupil_diameter = \"4 mm\"\nfov_deg = 10\n",
    )
    .expect("written");
    let run = |text: &str| {
        std::fs::write(dir.path().join("a.xml"), text).expect("written");
        let out = Command::new(env!("CARGO_BIN_EXE_eyebox")).arg("inspect").arg(&sidecar).output().expect("it runs");
        (out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())
    };
    let (code, said) = run(&good);
    assert_eq!(code, Some(0), "{said}");
    let energy = file(&[("Transmission Front", &|_, _| 0.4)]);
    for bad in [
        good[..good.len() / 2].to_owned(),
        good.replacen("0.100000000", "much", 1),
        good.replacen("0.100000000", "1e300", 1),
        good.replacen("Columns", "TensorTree3", 1),
        good.replacen("Transmission Front", "Trans\n\nmission", 1),
        good.replacen("</Layer>", "</Lair>", 1),
        "<WindowElement/>".to_owned(),
        energy,
    ] {
        let (code, said) = run(&bad);
        assert!(code == Some(2) && said.trim_end().lines().count() == 1 && said.contains("a.xml"), "{code:?}: {said}");
    }
}
