//! Lens files of design programs, as scenes, against rays that rayoptics traced through the same files
//! (`tests/data/prescriptions`, by `tests/python/prescription_rays.py`).

use eyebox::import::prescription::{After, Prescription, make, read};
use eyebox::import::{build, toml};
use eyebox::scene::glass;
use eyebox::world::World;
use eyebox::world::geometry::Ray;
use glam::DVec3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

const NM: f64 = 550.0;

/// A surface that a ray meets, where, and its direction behind it.
type Met = (usize, DVec3, DVec3);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/prescriptions")
}

fn world(file: &Path) -> World {
    let made = make(file, "x.glb").unwrap_or_else(|fault| panic!("{fault}"));
    let sheet = toml::parse(&made.text, Path::new("x.optics.toml")).unwrap();
    let scene = build(made.assembly, Some(&sheet), &[]).unwrap_or_else(|fault| panic!("{fault}\n{}", made.text)).scene;
    World::freeze(&scene).unwrap()
}

/// Index behind each surface.
fn indices(prescription: &Prescription) -> Vec<f64> {
    let mut n = 1.0;
    let behind = |surface: &eyebox::import::prescription::Surface| {
        match &surface.after {
            After::Glass { name, .. } => {
                let name = name.rsplit_once('_').map_or(name.clone(), |(name, maker)| format!("{maker} {name}"));
                n = glass::find(&name).unwrap().dispersion.index(NM).re;
            }
            After::Air if surface.turn.is_none() => n = 1.0,
            // Of n_d and V_d alone every program makes another dispersion.
            After::Model(_) | After::Private(_) => n = f64::NAN,
            After::Air | After::Mirror => {}
        }
        n
    };
    prescription.surfaces.iter().map(behind).collect()
}

/// Places to 1e-9 mm; the law of refraction or reflection holds to 1e-9 for our normals, our indices and their directions.
#[test]
fn rays_meet_the_surfaces_where_rayoptics_says() {
    let text = std::fs::read_to_string(folder().join("rays.csv")).unwrap();
    let mut rays: BTreeMap<(String, String), Vec<Met>> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        let v = |i: usize| DVec3::from_array([0, 1, 2].map(|k| cells[i + k].parse().unwrap()));
        let ray = rays.entry((cells[0].to_owned(), cells[1].to_owned())).or_default();
        ray.push((cells[2].parse().unwrap(), v(3), v(6)));
    }
    assert_eq!(rays.len(), 6 * 8);
    let (mut worlds, mut count, mut worst) = (BTreeMap::new(), 0, [0.0f64; 2]);
    for ((file, ray), hits) in &rays {
        let path = folder().join(file);
        let (world, prescription) = worlds.entry(file).or_insert_with(|| (world(&path), read(&path).unwrap()));
        let n = indices(prescription);
        // Zemax counts the planes at which axes turn among the surfaces, CODE V does not.
        let met = |index: &usize| file.ends_with(".zmx") || prescription.surfaces[*index].turn.is_none();
        let own: Vec<usize> = (0..prescription.surfaces.len()).filter(met).collect();
        let mut before = hits[0];
        for hit in &hits[1..] {
            let (surface, point, dir) = (own[hit.0], hit.1, hit.2);
            // Planes at which axes turn are not there, and a stop has a hole.
            let here = &prescription.surfaces[surface];
            let nothing = n[own[before.0]] == n[surface] && here.after == After::Air && *hit != hits[hits.len() - 1];
            if here.turn.is_some() || nothing {
                continue;
            }
            let (from, way) = (before.1.lerp(point, 0.3), before.2);
            let origin = from * 1e-3 - world.geometry.origin();
            let met = world
                .geometry
                .intersect(&Ray { origin, dir: way * (point - from).dot(way).signum(), from: None }, f64::INFINITY);
            let met = met.unwrap_or_else(|| panic!("{file}, ray {ray}: surface {surface} is not met"));
            let there = (met.point + world.geometry.origin()) * 1e3;
            worst[0] = worst[0].max(there.distance(point));
            assert!(there.distance(point) < 1e-9, "{file}, ray {ray}, surface {surface}: {there}, not {point}");
            let (n1, n2) = (n[own[before.0]], n[surface]);
            let bent = way * n1 - dir * n2;
            let off = bent.cross(met.normal).length();
            worst[1] = worst[1].max(off);
            assert!(off < 1e-9 || off.is_nan(), "{file}, ray {ray}, surface {surface}: off by {off}");
            before = *hit;
            count += 1;
        }
    }
    println!("{count} hits, worst {worst:?}");
    assert!(count > 100);
}

/// Through the program: the files that it writes are a scene that renders.
#[test]
fn a_lens_file_becomes_a_picture() {
    let folder_of_this = tempfile::tempdir().unwrap();
    let [sidecar, picture] = ["lens.optics.toml", "lens.exr"].map(|name| folder_of_this.path().join(name));
    let eyebox = |words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_eyebox")).args(words).output().unwrap();
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let (file, sidecar) = (folder().join("folded.zmx"), sidecar.to_str().unwrap().to_owned());
    let said = eyebox(&["init", file.to_str().unwrap(), "-o", &sidecar]);
    assert!(said.contains("lens.glb: 3 parts") && said.contains("can be imported as it is"), "{said}");
    eyebox(&["validate", &sidecar]);
    let picture = picture.to_str().unwrap();
    eyebox(&["render", &sidecar, "-q", "--resolution", "24x12", "--samples", "8", "-o", picture]);
    let frame = eyebox::film::exr::read_exr(Path::new(picture)).unwrap();
    // The image stands where the lens has it in focus for no one; but its light comes through lens and mirror.
    assert!(frame.component("", "G").unwrap().data.iter().any(|value| *value > 50.0));
}
