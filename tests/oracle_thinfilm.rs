//! Thin-film stacks against 40-digit values (oracle set 02_thinfilm; copies with their headers in tests/data).

use eyebox::base::Complex;
use eyebox::world::thinfilm::{Film, stack};
use serde_json::Value;
use std::collections::BTreeMap;

/// The stack definitions, resolved at a wavelength.
struct Designs(Value);

impl Designs {
    fn index(&self, entry: &Value, wavelength_nm: f64) -> Complex {
        match entry {
            Value::Number(n) => Complex::real(n.as_f64().expect("n")),
            Value::Array(nk) => Complex::new(nk[0].as_f64().expect("n"), nk[1].as_f64().expect("k")),
            Value::String(name) => {
                let grid = self.0["wavelengths_nm"].as_array().expect("grid");
                let i = grid.iter().position(|w| w.as_f64() == Some(wavelength_nm)).expect("wavelength of the table");
                let at = |key: &str| self.0["materials"][name][key][i].as_f64().expect("n, k");
                Complex::new(at("n"), at("k"))
            }
            other => panic!("index {other}"),
        }
    }

    fn get(&self, id: &str, wavelength_nm: f64) -> (f64, Vec<Film>, f64) {
        let design = self.0["stacks"].as_array().expect("stacks").iter().find(|s| s["id"] == id).expect("stack");
        let layers = design["layers"].as_array().expect("layers").iter();
        let films = layers.map(|layer| Film {
            n: self.index(&layer["n"], wavelength_nm),
            thickness_nm: layer["d_nm"].as_f64().expect("d_nm"),
        });
        let outer = |key: &str| self.index(&design[key], wavelength_nm).re;
        (outer("front"), films.collect(), outer("back"))
    }
}

#[test]
fn every_row() {
    let designs = Designs(serde_json::from_str(include_str!("data/stacks.json")).expect("stacks.json"));
    let mut worst: BTreeMap<String, f64> = BTreeMap::new();
    let mut count = 0;
    for line in include_str!("data/thinfilm.csv").lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().expect("number");
        let (wavelength, theta) = (number(2), number(3).to_radians());
        let (front, mut films, back) = designs.get(cells[0], wavelength);
        let (n_in, n_out) = match cells[1] {
            "front" => (front, back),
            "back" => {
                films.reverse();
                (back, front)
            }
            side => panic!("side {side}"),
        };
        let got = stack(n_in, &films, Complex::real(n_out), theta.cos(), wavelength);
        let tolerance = if cells[0] == "THICK" { 1e-7 } else { 1e-10 };
        let (a_s, a_p) = (1.0 - got.r_s - got.t_s, 1.0 - got.r_p - got.t_p);
        let mean = [got.reflectance(), got.transmittance(), got.absorptance()];
        let values = [got.r_s, got.r_p, got.t_s, got.t_p, a_s, a_p, mean[0], mean[1], mean[2]];
        for (i, value) in values.into_iter().enumerate() {
            let error = (value - number(4 + i)).abs();
            assert!(error <= tolerance, "{line}\n column {}: {value}, off by {error:e}", 4 + i);
            let worst = worst.entry(cells[0].to_owned()).or_default();
            *worst = worst.max(error);
        }
        count += 1;
    }
    assert_eq!(count, 2002);
    println!("worst error per stack: {worst:?}");
}
