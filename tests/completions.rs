//! What `eyebox completions` prints, in the shell itself.

use std::io::Write;
use std::process::Command;

#[test]
fn bash_completes_commands_options_and_values() {
    if Command::new("bash").arg("--version").output().is_err() {
        // Not on every machine, but wherever `.ci/run` runs, which is written in it.
        writeln!(std::io::stderr(), "no bash: what it completes was not tested").expect("stderr is open");
        return;
    }
    let script = Command::new(env!("CARGO_BIN_EXE_eyebox")).args(["completions", "bash"]).output().expect("it runs");
    assert!(script.status.success());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("eyebox.bash");
    std::fs::write(&path, &script.stdout).expect("written");
    let bash = |line: &str| {
        let output = Command::new("bash").arg("-c").arg(line).arg("bash").arg(&path).output().expect("bash runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert_eq!(bash("bash -n \"$1\""), "");
    let offers = |words: &str| {
        let last = words.split(' ').count();
        bash(&format!(
            "source \"$1\"; COMP_WORDS=({words} ''); COMP_CWORD={last}; _eyebox eyebox '' \"${{COMP_WORDS[COMP_CWORD-1]}}\"; \
             printf '%s\\n' \"${{COMPREPLY[@]}}\""
        ))
    };
    assert!(offers("eyebox").lines().any(|line| line == "report"));
    assert!(offers("eyebox render").lines().any(|line| line == "--samples"));
    assert_eq!(
        offers("eyebox render --estimator").split_whitespace().collect::<Vec<_>>(),
        ["auto", "backward", "forward", "photon", "manifold"]
    );
}
