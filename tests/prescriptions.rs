//! Lens files of design programs, as scenes, against rays that rayoptics and optiland traced through the same files
//! (`tests/data/prescriptions`, by `tests/python/prescription_rays.py`).

use eyebox::import::prescription::{After, Prescription, make, read};
use eyebox::import::{build, toml};
use eyebox::scene::glass;
use eyebox::world::World;
use eyebox::world::geometry::Ray;
use eyebox::world::grating::diffract;
use glam::DVec3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Farther than this from where it should meet a surface, mm, a ray has gone past the rim of it.
const PAST: f64 = 1e-2;

/// Where a ray meets a surface of the file, its direction and the index behind.
#[derive(Clone, Copy)]
struct Met {
    surface: usize,
    point: DVec3,
    way: DVec3,
    n: f64,
}

/// What came of the rays of a program through a file.
#[derive(Default)]
struct Outcome {
    rays: usize,
    hits: usize,
    /// Rays that went past a rim, of the image or before it.
    past: usize,
    worst_mm: f64,
    worst_index: f64,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/prescriptions")
}

fn world(file: &Path) -> eyebox::base::Result<(World, Prescription)> {
    let made = make(file, "x.glb")?;
    let sheet = toml::parse(&made.text, Path::new("x.optics.toml"))?;
    let scene = build(made.assembly, Some(&sheet), &[])?.scene;
    Ok((World::freeze(&scene)?, read(file)?))
}

/// What the rays of `folder` are compared with: file and program, wavelength, rays.
type Traced = BTreeMap<(String, String), (f64, BTreeMap<usize, Vec<Met>>)>;

fn traced(folder: &Path) -> Traced {
    let text = std::fs::read_to_string(folder.join("rays.csv")).unwrap();
    let mut out = Traced::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        let place = |i: usize| DVec3::new(number(i), number(i + 1), number(i + 2));
        let (_, rays) =
            out.entry((cells[0].to_owned(), cells[1].to_owned())).or_insert_with(|| (number(3), BTreeMap::new()));
        let met = Met { surface: number(4) as usize, point: place(5), way: place(8), n: number(11) };
        rays.entry(cells[2].parse().unwrap()).or_default().push(met);
    }
    out
}

/// Follows rays from their starts through our surfaces, which bend them by the other program's indices: a place is as far off as
/// all surfaces before it make it.
fn follow(world: &World, file: &Prescription, nm: f64, rays: &BTreeMap<usize, Vec<Met>>) -> Outcome {
    let mut out = Outcome { rays: rays.len(), ..Outcome::default() };
    let own: Vec<_> = file.surfaces.iter().filter(|surface| surface.turn.is_none()).collect();
    let origin = world.geometry.origin();
    'rays: for mets in rays.values() {
        let (mut at, mut way, mut n) = (mets[0].point, mets[0].way, mets[0].n);
        for (place, met) in mets.iter().enumerate().skip(1) {
            let (surface, last) = (own[met.surface], place + 1 == mets.len());
            if let After::Glass { name, .. } = &surface.after {
                let name = name.rsplit_once('_').map_or(name.clone(), |(name, maker)| format!("{maker} {name}"));
                let found = glass::find(&name).filter(|_| !last);
                let off = found.map_or(0.0, |glass| (glass.dispersion.index(nm).re - met.n).abs());
                out.worst_index = out.worst_index.max(off);
            }
            let behind = if last { n } else { met.n };
            let is_mirror = surface.after == After::Mirror;
            // Nothing is where nothing changes, and an image may have no size.
            if !is_mirror && behind == n && surface.grating.is_none() && !(last && surface.semi_diameter > 0.0) {
                continue;
            }
            let along = way * (met.point - at).dot(way).signum();
            let start = at + along * (0.3 * at.distance(met.point));
            let mut ray = Ray { origin: start * file.unit_m - origin, dir: along, from: None };
            // Another solid may be in between, which no ray of a sequence meets.
            let mut nearest: Option<(f64, DVec3, DVec3)> = None;
            for _ in 0..32 {
                let Some(hit) = world.geometry.intersect(&ray, f64::INFINITY) else { break };
                let there = (hit.point + origin) / file.unit_m;
                let off = there.distance(met.point) * file.unit_m * 1e3;
                if nearest.is_none_or(|(least, ..)| off < least) {
                    nearest = Some((off, there, hit.normal));
                }
                ray = Ray { origin: hit.point, from: Some(hit.site), ..ray };
            }
            let Some((off, there, normal)) = nearest.filter(|(off, ..)| *off < PAST) else {
                out.past += 1;
                continue 'rays;
            };
            out.worst_mm = out.worst_mm.max(off);
            out.hits += 1;
            let against = if normal.dot(way) > 0.0 { -normal } else { normal };
            let (cos, ratio) = (-against.dot(way), n / behind);
            way = if surface.grating.is_some() {
                met.way
            } else if is_mirror {
                way + 2.0 * cos * against
            } else {
                let through = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
                ratio * way + (ratio * cos - through) * against
            };
            (at, way, n) = (there, way.normalize(), behind);
        }
    }
    out
}

/// Places to 1e-9 mm, from the first surface to the image. `EYEBOX_LENS_FILES` names a further folder, of which a table is made.
#[test]
fn rays_meet_the_surfaces_where_others_say() {
    let mut hits = 0;
    let known = traced(&folder());
    assert_eq!(known.len(), 8);
    for ((file, program), (nm, rays)) in &known {
        let (world, prescription) = world(&folder().join(file)).unwrap_or_else(|fault| panic!("{fault}"));
        let out = follow(&world, &prescription, *nm, rays);
        assert!(out.rays >= 4 && out.past == 0, "{file} by {program}: {} of {} past a rim", out.past, out.rays);
        assert!(out.worst_mm < 1e-9, "{file} by {program}: {} mm off", out.worst_mm);
        assert!(out.worst_index < 1e-9, "{file} by {program}: an index {} off", out.worst_index);
        hits += out.hits;
    }
    assert!(hits > 200, "{hits}");
    let Some(further) = std::env::var_os("EYEBOX_LENS_FILES").map(PathBuf::from) else { return };
    for ((file, program), (nm, rays)) in traced(&further) {
        match world(&further.join(&file)) {
            Err(fault) => {
                println!("{file}\t{program}\trefused\t{}", fault.to_string().rsplit(": ").next().unwrap_or_default())
            }
            Ok((world, prescription)) => {
                let out = follow(&world, &prescription, nm, &rays);
                let Outcome { rays, hits, past, worst_mm, worst_index } = out;
                println!("{file}\t{program}\t{rays}\t{past}\t{hits}\t{worst_mm:.1e}\t{worst_index:.1e}");
            }
        }
    }
}

/// A grating on the back of a curved glass, and on a curved mirror: the orders of the file bend light to where optiland 0.6.3 has it
/// (its `tests/test_grating.py`; on the axis of the pupil's rim; y and z of the direction).
#[test]
fn orders_of_gratings_go_where_optiland_says() {
    let file = |curve: f64, conic: f64, order: i32, glass: &str, back: &str| {
        format!(
            "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 15\nWAVM 1 0.587 1\nSURF 0\n  DISZ INFINITY\n{glass}SURF 2\n  STOP\n  TYPE DGRATING\n  \
             CURV {curve}\n  CONI {conic}\n  PARM 1 0.2\n  PARM 2 {order}\n  DISZ 30\n  DIAM 10\n{back}SURF 3\n  DIAM 20\n"
        )
    };
    let plate = "SURF 1\n  DISZ 5\n  GLAS N-BK7\n  DIAM 10\n";
    let n = glass::find("SCHOTT N-BK7").unwrap().dispersion.index(587.0).re;
    for (text, indices, want) in [
        (file(0.02, 1.0, -1, plate, ""), (n, 1.0), [-0.0379603895, 0.9992792447]),
        // It gives directions behind mirrors the other sign.
        (file(1.0 / 70.0, 0.0, 1, "", "  GLAS MIRROR\n"), (1.0, 1.0), [0.3270019379746, -0.9450236677252]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.zmx");
        std::fs::write(&path, &text).unwrap();
        let (world, prescription) = world(&path).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
        let surface = prescription.surfaces.iter().find(|surface| surface.grating.is_some()).unwrap();
        let made = make(&path, "x.glb").unwrap();
        assert!(made.text.contains("kind = \"grating\", direction = [0, 1, 0]"), "{}", made.text);
        let is_mirror = surface.after == After::Mirror;
        // From within the glass, where there is one.
        let start = DVec3::new(0.0, 7.5, if is_mirror { -5.0 } else { 4.0 }) * 1e-3 - world.geometry.origin();
        let hit = world.geometry.intersect(&Ray { origin: start, dir: DVec3::Z, from: None }, f64::INFINITY).unwrap();
        let against = if hit.normal.z > 0.0 { -hit.normal } else { hit.normal };
        let [lines, order] = surface.grating.unwrap();
        let shift = DVec3::Y * (order * lines * 1e-6 * 587.0);
        let got = diffract(DVec3::Z, against, indices, shift, !is_mirror).unwrap();
        assert!((got.y - want[0]).abs() < 2e-9 && (got.z - want[1]).abs() < 2e-9, "{got} for {want:?}");
    }
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
    assert!(said.contains("lens.glb: 4 parts") && said.contains("can be imported as it is"), "{said}");
    eyebox(&["validate", &sidecar]);
    let picture = picture.to_str().unwrap();
    eyebox(&["render", &sidecar, "-q", "--resolution", "24x12", "--samples", "8", "-o", picture]);
    let frame = eyebox::film::exr::read_exr(Path::new(picture)).unwrap();
    // The image stands where the lens has it in focus for no one; but its light comes through lens and mirror.
    assert!(frame.component("", "G").unwrap().data.iter().any(|value| *value > 50.0));
}
