//! The page in headless Chromium, which alone can say what the page's policy forbids. A machine without one has the engine's
//! run; `EYEBOX_BROWSER=required`, as in `.ci/run`, makes its absence a failure.

use std::io::Write;
use std::path::Path;
use std::process::Command;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// The text that the page writes at its end; none where there is no browser, which is said even where the output of tests is
/// not shown.
pub fn selftest(page: &Path) -> Option<String> {
    let Some(browser) = browser() else {
        let why =
            "no Chromium: the page of `eyebox report` was tested in the engine alone (EYEBOX_CHROMIUM names a browser)";
        writeln!(std::io::stderr(), "{why}").expect("stderr is open");
        return None;
    };
    let profile = tempfile::tempdir().expect("a folder");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(["--virtual-time-budget=20000", "--timeout=60000", "--dump-dom"])
        .arg(format!("file://{}#selftest", page.display()))
        .output()
        .expect("Chromium runs");
    Some(said(&String::from_utf8_lossy(&output.stdout)))
}

/// The first of the usual names that runs, or the one that was named, which must.
fn browser() -> Option<String> {
    let runs = |name: &str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let required = std::env::var("EYEBOX_BROWSER").ok().is_some_and(|value| {
        assert_eq!(value, "required", "EYEBOX_BROWSER is unset, or `required`");
        true
    });
    if let Ok(own) = std::env::var("EYEBOX_CHROMIUM") {
        assert!(runs(&own), "EYEBOX_CHROMIUM: {own} does not run");
        return Some(own);
    }
    let found = NAMES.into_iter().find(|name| runs(name)).map(str::to_owned);
    assert!(
        found.is_some() || !required,
        "no Chromium: install it (Debian: apt-get install chromium) or say where it is with EYEBOX_CHROMIUM"
    );
    found
}

/// What stands in `<pre id="selftest">`.
fn said(document: &str) -> String {
    let text = document.split("<pre id=\"selftest\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let fault = document.split("id=\"fault\"").nth(1).and_then(|rest| rest.get(..300)).unwrap_or("");
    let text = text.unwrap_or_else(|| panic!("the page did not get to its end: {fault}\n{} bytes", document.len()));
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&")
}
