//! `eyebox-bench` as its user runs it.

use std::process::Command;

/// What is read by a program is a document that says who made it.
#[test]
fn json_says_who_made_it() {
    for arguments in [
        &["--stress", "--only", "critical"][..],
        &["--generate", "0..1", "--seconds", "0.1"],
        &["--help"],
        &["--version"],
    ] {
        let mut bench = Command::new(env!("CARGO_BIN_EXE_eyebox-bench"));
        let is_help = arguments.len() == 1;
        let run = bench.args(arguments).args(if is_help { &[][..] } else { &["--format", "json"] }).output();
        let run = run.expect("the program runs");
        if is_help {
            assert!(run.status.success() && String::from_utf8_lossy(&run.stdout).contains("bench"));
            continue;
        }
        let said: serde_json::Value = serde_json::from_slice(&run.stdout)
            .unwrap_or_else(|error| panic!("{arguments:?}: {error}: {}", String::from_utf8_lossy(&run.stderr)));
        assert_eq!(said["eyebox"], env!("CARGO_PKG_VERSION"), "{arguments:?}");
    }
    let wrong = Command::new(env!("CARGO_BIN_EXE_eyebox-bench")).arg("--strss").output().expect("the program runs");
    assert_eq!(wrong.status.code(), Some(2));
    assert_eq!(String::from_utf8_lossy(&wrong.stderr).lines().count(), 1);
}
