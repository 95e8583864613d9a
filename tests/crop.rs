//! A part of a picture has the bits of the whole: through the program, for estimators from both ends, whole runs and shards.

use eyebox::film::crop::Window;
use eyebox::film::exr::read_exr;
use eyebox::film::frame::{Channel, Frame};
use std::path::Path;
use std::process::Command;

/// Columns, rows: the part, of 36 × 18 pixels.
const CORNER: [usize; 2] = [13, 5];
const SIZE: [usize; 2] = [11, 7];

fn eyebox(words: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_eyebox")).args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn render(asset: &str, options: &[&str], output: &Path) {
    let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join(asset);
    let (asset, output) = (asset.to_str().unwrap(), output.to_str().unwrap());
    let always = ["render", asset, "-q", "--no-witness", "--resolution", "36x18", "-o", output];
    eyebox(&[&always, options].concat());
}

/// Every channel of the part is that of the whole, to the bit, but for stated errors: what even points spare is pooled over what
/// is traced.
fn assert_part(whole: &Frame, part: &Frame) {
    assert_eq!([part.width, part.height], SIZE);
    let corner = CORNER.map(|at| i32::try_from(at).unwrap());
    assert_eq!(part.window, Some(Window { corner, picture: [whole.width, whole.height] }));
    assert!(part.channels.iter().all(|mine| whole.get(&mine.name).is_some()));
    let mut light = 0.0;
    for all in &whole.channels {
        // A layer that has no light here is not written.
        let none = Channel { name: all.name.clone(), data: vec![0.0; SIZE[0] * SIZE[1]].into() };
        let mine = part.get(&all.name).unwrap_or(&none);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let there = all.data[(y + CORNER[1]) * whole.width + x + CORNER[0]];
                let here = mine.data[y * SIZE[0] + x];
                if mine.layer().contains("stderr") {
                    continue;
                }
                assert_eq!(here.to_bits(), there.to_bits(), "{} at {x}, {y}: {here} and {there}", mine.name);
                light += f64::from(here.abs());
            }
        }
    }
    assert!(light > 0.0);
}

long! {
#[test]
fn a_part_has_the_bits_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (asset, options) in [
        ("samples/hud-direct/hud.optics.toml", vec!["--estimator", "auto", "--samples", "4"]),
        ("samples/hud-direct/hud.optics.toml", vec!["--estimator", "backward", "--samples", "4"]),
        ("samples/hud-direct/hud.optics.toml", vec!["--estimator", "forward", "--samples", "4"]),
        ("samples/hud-diffuse/hud.optics.toml", vec!["--estimator", "photon", "--samples", "2"]),
    ] {
        render(asset, &options, &path("whole.exr"));
        render(asset, &[options.as_slice(), &["--crop", "13,5,11x7"]].concat(), &path("part.exr"));
        let [whole, part] = ["whole.exr", "part.exr"].map(|name| read_exr(&path(name)).unwrap());
        assert_part(&whole, &part);
    }
}
}

/// Shards of a part make up the part.
#[test]
fn shards_of_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let options = ["--samples", "4", "--crop", "13,5,11x7"];
    render("samples/hud-direct/hud.optics.toml", &options, &path("part.exr"));
    for shard in ["1/2", "2/2"] {
        let output = path(&format!("{}.exr", &shard[..1]));
        render("samples/hud-direct/hud.optics.toml", &[options.as_slice(), &["--shard", shard]].concat(), &output);
    }
    let [a, b, merged] = ["1.exr", "2.exr", "merged.exr"].map(path);
    eyebox(&["merge", a.to_str().unwrap(), b.to_str().unwrap(), "-o", merged.to_str().unwrap()]);
    let [part, merged] = [path("part.exr"), merged].map(|file| read_exr(&file).unwrap());
    assert_eq!((merged.window, &merged.channels), (part.window, &part.channels));
}

#[test]
fn a_part_lies_in_the_picture() {
    let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.optics.toml");
    let words = ["--resolution", "36x18", "--crop", "30,5,11x7", "-o", "never.exr"];
    let output = Command::new(env!("CARGO_BIN_EXE_eyebox")).arg("render").arg(asset).args(words).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("--crop 30,5,11x7: reaches out of the picture; expected a part of 36 x 18 pixels"), "{said}");
}
