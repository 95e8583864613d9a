//! `eyebox render` under SIGTERM, SIGINT and SIGHUP: it ends soon, with a whole file or with none.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn start(output: &Path, resolution: &str) -> Child {
    let sidecar = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-diffuse/hud.optics.toml");
    Command::new(env!("CARGO_BIN_EXE_eyebox"))
        .args(["render", "--time", "300s", "--quiet", "--threads", "1", "--resolution", resolution, "-o"])
        .arg(output)
        .arg(sidecar)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs")
}

fn signal(child: &Child, name: &str) {
    // The shell's own: a program of that name is not on every machine.
    let sent = Command::new("sh").args(["-c", "kill -s \"$0\" \"$1\"", name, &child.id().to_string()]).status();
    let sent = sent.expect("sh runs");
    assert!(sent.success());
}

/// Exit code, and seconds that the end took.
fn end(child: Child) -> (Option<i32>, String, f64) {
    let start = Instant::now();
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), start.elapsed().as_secs_f64())
}

/// Under `nohup` the program, which is started by this one, goes on after SIGHUP, as it should.
fn hup_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).map(str::trim);
    mask.and_then(|mask| u64::from_str_radix(mask, 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

#[test]
fn a_signal_at_any_time_leaves_a_whole_file_or_none() {
    let all = [("TERM", 143), ("INT", 130), ("HUP", 129)];
    for (name, code) in all.into_iter().filter(|(name, _)| *name != "HUP" || !hup_is_ignored()) {
        // From the import through the pilots to the first passes.
        for wait_ms in [150, 700, 1500, 3000, 6000] {
            let folder = tempfile::tempdir().expect("a folder");
            let output = folder.path().join("a.exr");
            let child = start(&output, "64x32");
            std::thread::sleep(Duration::from_millis(wait_ms));
            signal(&child, name);
            let (ended, said, seconds) = end(child);
            assert_eq!(ended, Some(code), "{name} after {wait_ms} ms: {said}");
            assert!(seconds < 10.0, "{name} after {wait_ms} ms took {seconds} s");
            let files: Vec<_> = std::fs::read_dir(folder.path()).expect("it is there").collect();
            if output.exists() {
                assert_eq!(files.len(), 1);
                let frame = eyebox::output::exr::read_exr(&output).expect("a whole file");
                assert!(frame.integer("passes").is_some_and(|passes| passes >= 1));
            } else {
                assert_eq!(files.len(), 0);
                assert!(said.contains("stopped before the first pass") && said.contains("was not written"), "{said}");
            }
        }
    }
}

/// Two passes to `output`, telling of their progress every second and at the end.
fn short(output: &Path, before: &str) -> Child {
    let sidecar = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-diffuse/hud.optics.toml");
    Command::new("sh")
        .args(["-c", &format!("{before} exec \"$@\""), "sh", env!("CARGO_BIN_EXE_eyebox")])
        .args(["render", "--samples", "2", "--progress", "openjd", "--threads", "1", "--resolution", "64x32", "-o"])
        .arg(output)
        .arg(sidecar)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs")
}

fn has_passes(output: &Path) -> Option<i64> {
    eyebox::output::exr::read_exr(output).expect("a whole file").integer("passes")
}

/// `nohup` has the signal ignored: that must stay so.
#[test]
fn a_run_that_ignores_hanging_up_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("a.exr");
    let child = short(&output, "trap '' HUP;");
    std::thread::sleep(Duration::from_millis(700));
    signal(&child, "HUP");
    let (ended, said, _) = end(child);
    assert_eq!((ended, has_passes(&output)), (Some(0), Some(2)), "{said}");
}

/// A connection that drops takes the reader of the progress away too: that is no reason to lose the picture.
#[test]
fn a_run_that_nobody_reads_any_more_writes_its_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("a.exr");
    let mut child = short(&output, "");
    drop(child.stderr.take());
    let (ended, ..) = end(child);
    assert_eq!((ended, has_passes(&output)), (Some(0), Some(2)));
}
