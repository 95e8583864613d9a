//! Sequential tracing through systems of planes, conics, aspheres, polynomial and Zernike surfaces against 30-digit
//! results (`tests/data/lens_*`).

use eyebox::scene::Shape;
use eyebox::world::geometry::curved::Curved;
use eyebox::world::geometry::exact::Quadric;
use glam::{DMat3, DVec3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

enum Exact {
    Quadric(Quadric),
    Curved(Curved),
}

impl Exact {
    /// Where the line meets the sheet that is meant, t > 0 ascending.
    fn ahead(&self, origin: DVec3, dir: DVec3, from_surface: bool) -> Vec<f64> {
        match self {
            Exact::Quadric(quadric) => {
                let roots = quadric.intersect(origin, dir, from_surface);
                let ahead = |t: &f64| t.is_finite() && *t > 0.0 && quadric.branch(origin + *t * dir) > 0.0;
                roots.into_iter().filter(ahead).collect()
            }
            Exact::Curved(curved) => {
                let mut roots = Vec::new();
                let _ = curved.along(origin, dir, from_surface, f64::INFINITY, &mut |t, _| {
                    roots.push(t);
                    ControlFlow::Continue(())
                });
                roots
            }
        }
    }
    fn normal(&self, p: DVec3) -> DVec3 {
        match self {
            Exact::Quadric(quadric) => quadric.normal(p),
            Exact::Curved(curved) => curved.normal(p),
        }
    }
    fn distance(&self, p: DVec3) -> f64 {
        match self {
            Exact::Quadric(quadric) => quadric.distance(p),
            Exact::Curved(curved) => curved.distance(p),
        }
    }
}

struct Surface {
    exact: Exact,
    reflects: bool,
    n_after: Vec<f64>,
}

struct Row {
    point: DVec3,
    dir: DVec3,
    status: String,
}

fn read(name: &str) -> String {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn vector(value: &Value) -> DVec3 {
    let number = |i: usize| value[i].as_f64().expect("a number");
    DVec3::new(number(0), number(1), number(2))
}

/// Per system: wavelengths and surfaces.
fn systems() -> BTreeMap<String, (Vec<f64>, Vec<Surface>)> {
    let numbers = |value: &Value| value.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect::<Vec<_>>();
    let surface = |value: &Value| {
        let rows = &value["rotation_local_to_global"];
        let turn = DMat3::from_cols(vector(&rows[0]), vector(&rows[1]), vector(&rows[2])).transpose();
        let (vertex, axis) = (vector(&value["vertex"]), turn * DVec3::Z);
        let x = turn * DVec3::X;
        let number = |name: &str| value[name].as_f64().unwrap();
        // Entries [i, j, c] to the index of a list.
        let listed = |index: &dyn Fn(i64, i64) -> i64| {
            let mut list = Vec::new();
            for entry in value["c"].as_array().unwrap() {
                let at = index(entry[0].as_i64().unwrap(), entry[1].as_i64().unwrap()) as usize;
                list.resize(list.len().max(at + 1), 0.0);
                list[at] = entry[2].as_f64().unwrap();
            }
            list
        };
        let shape = match value["type"].as_str().unwrap() {
            "plane" => Shape::Plane { vertex, axis },
            "conic" => Shape::Conic { vertex, axis, radius: number("R"), conic: number("k") },
            "even" => {
                Shape::Asphere { vertex, axis, radius: number("R"), conic: number("k"), even: numbers(&value["a"]) }
            }
            "xy" => {
                let coeffs = listed(&|i, j| (i + j) * (i + j + 1) / 2 + j);
                Shape::XyPoly { vertex, axis, x, radius: number("R"), conic: number("k"), coeffs }
            }
            "zernike" => {
                let coeffs = listed(&|n, m| (n * (n + 2) + m) / 2);
                let (radius, conic, norm_radius) = (number("R"), number("k"), number("rnorm"));
                Shape::Zernike { vertex, axis, x, radius, conic, norm_radius, coeffs }
            }
            other => panic!("surface type {other}"),
        };
        // The corners of a face that covers every ray, as a mesh would.
        let extent = numbers(&value["hit_extent_local_xmin_xmax_ymin_ymax"]);
        let corners = [0, 1].into_iter().flat_map(|i| [2, 3].map(|j| DVec3::new(extent[i], extent[j], 0.0)));
        let corners = corners.map(|p| vertex + turn * (1.01 * p));
        let exact = match Curved::new(&shape, corners).expect("a surface") {
            Some(curved) => Exact::Curved(curved),
            None => Exact::Quadric(Quadric::from_shape(&shape).expect("a surface")),
        };
        Surface { exact, reflects: value["mode"] == "reflect", n_after: numbers(&value["n_after"]) }
    };
    let all: Value = serde_json::from_str(&read("lens_systems.json")).unwrap();
    let system = |value: &Value| {
        let surfaces = value["surfaces"].as_array().unwrap().iter().map(surface).collect();
        (value["id"].as_str().unwrap().to_owned(), (numbers(&value["wavelengths_nm"]), surfaces))
    };
    all["systems"].as_array().unwrap().iter().map(system).collect()
}

/// Per system and ray: wavelength and rows from the start on.
fn rays() -> BTreeMap<(String, u32), (f64, Vec<Row>)> {
    let mut rays: BTreeMap<(String, u32), (f64, Vec<Row>)> = BTreeMap::new();
    for line in read("lens_rays.csv").lines().filter(|l| !l.starts_with('#') && !l.starts_with("system,")) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        let key = (cells[0].to_owned(), cells[1].parse().unwrap());
        let ray = rays.entry(key).or_insert_with(|| (number(2), Vec::new()));
        assert_eq!(cells[4].parse::<usize>().unwrap(), ray.1.len(), "rows in order: {line}");
        ray.1.push(Row {
            point: DVec3::new(number(5), number(6), number(7)),
            dir: DVec3::new(number(8), number(9), number(10)),
            status: cells[13].to_owned(),
        });
    }
    rays
}

/// Snell's law in vector form (`design/formulas.md` section 4); none under total reflection.
fn refract(d: DVec3, normal: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
    let normal = if d.dot(normal) < 0.0 { -normal } else { normal };
    let cos = d.dot(normal);
    let beyond = n2 * n2 - n1 * n1 * (1.0 - cos * cos);
    (beyond >= 0.0).then(|| (n1 * d + (beyond.sqrt() - n1 * cos) * normal) / n2)
}

#[test]
fn rays_through_lenses_mirrors_and_prisms() {
    let systems = systems();
    let rays = rays();
    assert_eq!((systems.len(), rays.len()), (10, 255));
    let (mut most_point, mut most_dir, mut ends) = (0.0f64, 0.0f64, BTreeMap::new());
    for ((system, ray), (wavelength, rows)) in &rays {
        let (wavelengths, surfaces) = &systems[system];
        let color = wavelengths.iter().position(|w| w == wavelength).expect("a wavelength of the system");
        let (mut point, mut dir, mut n) = (rows[0].point, rows[0].dir, 1.0);
        let mut status = "ok";
        for (index, surface) in surfaces.iter().enumerate() {
            let roots = surface.exact.ahead(point, dir, false);
            let Some(row) = rows.get(index + 1) else {
                assert!(roots.is_empty() || status != "ok", "{system} {ray}: no row {}", index + 1);
                break;
            };
            let t = roots.first().unwrap_or_else(|| panic!("{system} {ray} misses surface {}", index + 1));
            point += *t * dir;
            let normal = surface.exact.normal(point);
            let after = surface.n_after[color];
            if surface.reflects {
                dir -= 2.0 * dir.dot(normal) * normal;
            } else if let Some(refracted) = refract(dir, normal, n, after) {
                (dir, n) = (refracted, after);
            } else {
                status = "tir";
            }
            most_point = most_point.max((point - row.point).length());
            most_dir = most_dir.max((dir - row.dir).length());
            assert!((point - row.point).length() < 1e-9, "{system} {ray} at {}: {point} {}", index + 1, row.point);
            assert!((dir - row.dir).length() < 1e-11, "{system} {ray} at {}: {dir} {}", index + 1, row.dir);
            assert_eq!(row.status, status, "{system} {ray} at {}", index + 1);
        }
        *ends.entry(status).or_insert(0) += 1;
        // From each surface that was left, the deflated root is the surface's other point.
        let (first, row) = (&surfaces[0], &rows[1]);
        for t in first.exact.ahead(row.point, row.dir, true) {
            let other = row.point + t * row.dir;
            assert!(first.exact.distance(other) < 1e-12 * (1.0 + t.abs()), "{system} {ray}: {t}");
        }
    }
    assert_eq!(ends, BTreeMap::from([("ok", 247), ("tir", 8)]));
    println!("largest deviations: {most_point:.2e} mm, {most_dir:.2e} in direction");
}
