//! Shards and checkpoints as a farm uses them: through the program.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

struct Farm {
    folder: tempfile::TempDir,
    asset: PathBuf,
    options: Vec<&'static str>,
}

impl Farm {
    fn new(asset: &str, options: &[&'static str]) -> Farm {
        let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join(asset);
        Farm { folder: tempfile::tempdir().unwrap(), asset, options: options.to_vec() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn render(&self, output: &str, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
        command
            .arg("render")
            .arg(&self.asset)
            .args(&self.options)
            .args(more)
            .arg("-q")
            .arg("-o")
            .arg(self.path(output));
        command
    }

    fn merge(&self, shards: &[&str], output: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
        command.arg("merge").args(shards.iter().map(|name| self.path(name))).arg("-o").arg(self.path(output));
        command.output().unwrap()
    }

    /// Runs until there is a checkpoint, and kills the run.
    fn until_checkpoint(&self, options: &[&str]) {
        let mut child = self.render("hud.exr", options).stderr(Stdio::null()).spawn().unwrap();
        while !self.path("hud.checkpoint.exr").exists() {
            assert!(child.try_wait().unwrap().is_none(), "ended before the first checkpoint");
            std::thread::sleep(Duration::from_millis(10));
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn shards(&self, count: usize) -> Vec<String> {
        let shard = |k: usize| {
            let name = format!("{k}.exr");
            done(self.render(&name, &["--shard", &format!("{k}/{count}")]));
            name
        };
        (1..=count).map(shard).collect()
    }
}

fn done(mut command: Command) {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn refused(output: &Output, names: &[&str]) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    names.iter().for_each(|name| assert!(said.contains(name), "{name}: {said}"));
}

const DIRECT: &str = "samples/hud-direct/hud.optics.toml";
const DIFFUSE: &str = "samples/hud-diffuse/hud.optics.toml";

/// Seven shards of unequal sizes in another order are the file of the whole, byte by byte: light tracing by scrambles,
/// connection and eye paths with polarisation, spread by diffraction.
#[test]
fn seven_shards_are_the_whole_file() {
    let farm = Farm::new(
        DIRECT,
        &["--resolution", "32x16", "--samples", "12", "--seed", "3", "--diffraction", "--cryptomatte"],
    );
    done(farm.render("whole.exr", &[]));
    let shards = farm.shards(7);
    let order = [3, 0, 6, 4, 1, 5, 2].map(|k| shards[k].as_str());
    let output = farm.merge(&order, "merged.exr");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(farm.bytes("merged.exr") == farm.bytes("whole.exr"));

    let without: Vec<&str> = order.into_iter().filter(|name| *name != "5.exr").collect();
    refused(&farm.merge(&without, "none.exr"), &["shard 5/7", "of 12 missing"]);
    refused(&farm.merge(&[order.as_slice(), &["5.exr"]].concat(), "none.exr"), &["5.exr", "has them"]);
    done(farm.render("other.exr", &["--shard", "5/7", "--set", "led.flux_lm=0.3"]));
    let with = |name: &'static str| [without.as_slice(), &[name]].concat();
    refused(&farm.merge(&with("other.exr"), "none.exr"), &["other.exr", "the scene"]);
    let whole = farm.bytes("5.exr");
    std::fs::write(farm.path("cut.exr"), &whole[..whole.len() * 2 / 3]).unwrap();
    refused(&farm.merge(&with("cut.exr"), "none.exr"), &["cut.exr"]);
    refused(&farm.merge(&with("whole.exr"), "none.exr"), &["whole.exr", "is no shard"]);
    refused(&farm.merge(&with("gone.exr"), "none.exr"), &["gone.exr"]);
    assert!(!farm.path("none.exr").exists());
}

/// The same with photon maps, in colour, and every layer's standard errors.
#[test]
fn photons_and_errors_of_layers_merge_too() {
    let farm = Farm::new(
        DIFFUSE,
        &[
            "--resolution",
            "24x12",
            "--samples",
            "5",
            "--stderr",
            "layers",
            "--set",
            "wavelengths=\"visible\"",
            "--aov",
            "all=C.*",
            "--variance",
            "--layer-prefix",
            "eb_",
            "--multi-part",
            "--color",
            "acescg",
        ],
    );
    done(farm.render("whole.exr", &["--threads", "1"]));
    let shards = farm.shards(3);
    let output = farm.merge(&[2, 0, 1].map(|k| shards[k].as_str()), "merged.exr");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(farm.bytes("merged.exr") == farm.bytes("whole.exr"));
}

/// Killed at twenty moments without a warning, a run goes on from its last checkpoint each time, never loses a pass that was
/// in one, never leaves half a file, and ends with the bytes of a run that nobody killed.
#[test]
fn a_killed_run_goes_on() {
    let farm = Farm::new(DIRECT, &["--resolution", "64x32", "--polarisation", "off"]);
    // A checkpoint is read to its end, and its sums are checked.
    let passes = |name: &str| eyebox::estimate::shard::load(&farm.path(name)).unwrap().0.passes;
    let options = ["--samples", "1000000", "--checkpoint", "50ms", "--resume"];
    let start = Instant::now();
    farm.until_checkpoint(&options);
    // Moments from the start of the program to well after it has begun to trace, on a machine of any speed.
    let most = start.elapsed().as_millis() as u64 * 3 / 2;
    let first = passes("hud.checkpoint.exr");
    let (mut last, mut rng) = (first, 0x2545_f491_4f6c_dd1d_u64);
    for _ in 0..20 {
        let mut child = farm.render("hud.exr", &options).stderr(Stdio::null()).spawn().unwrap();
        rng ^= rng << 13;
        rng ^= rng >> 7;
        rng ^= rng << 17;
        std::thread::sleep(Duration::from_millis(rng % most));
        // SIGKILL: nothing can be done about it.
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!farm.path("hud.exr").exists());
        let now = passes("hud.checkpoint.exr");
        assert!(now >= last, "{now} passes after {last}");
        last = now;
    }
    assert!(last > first, "{last} passes");
    let total = (last + 3).to_string();
    let options = ["--samples", &total, "--checkpoint", "50ms", "--resume"];
    done(farm.render("hud.exr", &options));
    assert!(!farm.path("hud.checkpoint.exr").exists());
    let left: Vec<_> = std::fs::read_dir(farm.folder.path()).unwrap().flatten().map(|file| file.file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().contains(".tmp")), "{left:?}");
    done(farm.render("whole.exr", &["--samples", &total]));
    assert!(farm.bytes("hud.exr") == farm.bytes("whole.exr"));

    // A checkpoint of another run is not gone on from.
    let options = ["--samples", "1000000", "--checkpoint", "50ms", "--resume"];
    farm.until_checkpoint(&options);
    refused(
        &farm.render("hud.exr", &[&options[..], &["--seed", "9"]].concat()).output().unwrap(),
        &["hud.checkpoint.exr", "the seed"],
    );
}

/// A shard's description is input like any other: absurd numbers in it are refused in one line.
#[test]
fn a_shard_that_lies_is_refused() {
    let farm = Farm::new(DIRECT, &["--resolution", "8x4", "--samples", "2", "--polarisation", "off"]);
    done(farm.render("1.exr", &["--shard", "1/2"]));
    let good = eyebox::output::exr::read_exr(&farm.path("1.exr")).unwrap();
    let text = good.text("shard").unwrap().to_owned();
    let most = u64::MAX.to_string();
    let lies = [
        ("\"first\":0", format!("\"first\":{most}")),
        ("\"total\":2", format!("\"total\":{most}")),
        ("\"of\":[1,2]", format!("\"of\":[{most},0]")),
        ("\"parts\":", format!("\"parts\":{most},\"was\":")),
        ("\"passes\":1", format!("\"passes\":{most}")),
        ("\"size\":[8,4]", "\"size\":[4,8]".to_owned()),
        ("\"group\":0", "\"group\":4000000000".to_owned()),
        // A plane twice: what is in which could not be told.
        ("\"planes\":[", format!("\"planes\":[{0},{0},", r#"{"layer":"direct","group":0}"#)),
    ];
    for (truth, lie) in lies {
        assert!(text.contains(truth), "{truth}: {text}");
        let mut bad = good.clone();
        bad.meta.insert("shard".to_owned(), eyebox::film::frame::Meta::Text(text.replace(truth, &lie)));
        eyebox::output::exr::write_exr(&farm.path("bad.exr"), &bad).unwrap();
        refused(&farm.merge(&["bad.exr"], "none.exr"), &["bad.exr"]);
    }
}
