//! `eyebox report` in a browser: the page works itself (`#selftest`) and what it finds is compared with the program. Needs
//! Chromium; `.ci/run` installs it, `EYEBOX_CHROMIUM` names another one.

use eyebox::film::frame::{Frame, Meta};
use eyebox::output::exr::write_exr;
use eyebox::output::light_shares::Rendering;
use eyebox::output::luminance::layer_luminance;
use eyebox::output::mix::{Recipe, mix};
use eyebox::output::report::page;
use eyebox::output::view::{ViewOptions, render_view};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

const HOSTILE: &str = "</script><img src=x onerror=\"pwned=1\">'";
const WIDTH: usize = 9;
const HEIGHT: usize = 5;
const PIXELS: usize = WIDTH * HEIGHT;

/// A smooth picture with colours.
fn picture(seed: f32) -> [Vec<f32>; 3] {
    let value = |pixel: usize, channel: usize| 20.0 + 15.0 * (seed * pixel as f32 + channel as f32).sin();
    [0, 1, 2].map(|channel| (0..PIXELS).map(|pixel| value(pixel, channel)).collect())
}

/// Light that passes a slide of contrast 8 once, twice and three times, and light that does not.
fn frame(group: &str) -> Frame {
    let mut frame = Frame::new(WIDTH, HEIGHT);
    let (open, content, cross, cross2, sky) = (picture(0.3), picture(0.7), picture(1.1), picture(1.3), picture(0.1));
    let (u, v) = (1.0 - 1.0 / 8.0, 1.0 / 8.0f64);
    let at = |picture: &[Vec<f32>; 3], channel: usize, pixel: usize| f64::from(picture[channel][pixel]);
    let share = [0, 1, 2].map(|c| -> Vec<f32> {
        let value =
            |p| at(&content, c, p) * u + at(&open, c, p) * v + (at(&cross, c, p) + u * at(&cross2, c, p)) * u * v;
        (0..PIXELS).map(|pixel| value(pixel) as f32).collect()
    });
    let sum = [0, 1, 2].map(|c| -> Vec<f32> { sky[c].iter().zip(&share[c]).map(|(a, b)| a + b).collect() });
    let layers = [
        ("".to_owned(), &sum),
        ("hybrid".to_owned(), &sum),
        ("direct".to_owned(), &sky),
        ("direct_sky".to_owned(), &sky),
        ("forward".to_owned(), &share),
        (format!("forward_{group}"), &share),
        (format!("forward_{group}_open"), &open),
        (format!("forward_{group}_content"), &content),
        (format!("forward_{group}_cross"), &cross),
        (format!("forward_{group}_cross2"), &cross2),
    ];
    for (layer, picture) in layers {
        for (component, data) in ["R", "G", "B"].into_iter().zip(picture) {
            let dot = if layer.is_empty() { "" } else { "." };
            frame.push(format!("{layer}{dot}{component}"), data.clone());
        }
    }
    frame.push("stderr.Y", vec![0.1; PIXELS]);
    frame.push("Z.Z", (0..PIXELS).map(|pixel| pixel as f32 / 7.0).collect());
    let mut text = |key: &str, value: &str| frame.meta.insert(key.to_owned(), Meta::Text(value.to_owned()));
    text("groups", &serde_json::json!([group, "sky"]).to_string());
    text("scene", HOSTILE);
    text("passes", "4");
    text("planReadable", &format!("{HOSTILE} vision: forward because {HOSTILE}"));
    text("parts", &serde_json::json!([HOSTILE]).to_string());
    text("ledger.forward", "{\"paths\":3,\"emitted\":8.0,\"arrived\":2.0,\"escaped\":2.0,\"absorbed\":[4.0]}");
    frame.meta.insert("contrast".to_owned(), Meta::Number(8.0));
    frame
}

fn report(arguments: &[&Path], output: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    command.arg("report").args(arguments).arg("-o").arg(output).output().expect("the program runs")
}

/// The document after the page has worked itself.
fn browse(page: &Path) -> String {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let own = std::env::var("EYEBOX_CHROMIUM").ok();
    let found =
        own.as_deref().into_iter().chain(names).find(|name| Command::new(name).arg("--version").output().is_ok());
    let Some(browser) = found else {
        panic!("no Chromium: install it (Debian: apt-get install chromium) or say where it is with EYEBOX_CHROMIUM");
    };
    let profile = tempfile::tempdir().expect("a folder");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(["--virtual-time-budget=20000", "--timeout=60000", "--dump-dom"])
        .arg(format!("file://{}#selftest", page.display()))
        .output()
        .expect("Chromium runs");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What the page wrote into `<pre id="selftest">`.
fn selftest(document: &str) -> Value {
    let text = document.split("<pre id=\"selftest\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let fault = document.split("id=\"fault\"").nth(1).and_then(|rest| rest.get(..300)).unwrap_or("");
    let text = text.unwrap_or_else(|| panic!("the page did not get to its end: {fault}\n{} bytes", document.len()));
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect()
}

#[test]
fn the_page_mixes_shows_and_reads_as_the_program_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let html = folder.path().join("report.html");
    // Our own writer refuses such names of layers; the page must stand them all the same.
    let frame = frame(HOSTILE);
    let made = page(&[("it's.exr".to_owned(), &frame)]).expect("a page");
    std::fs::write(&html, made.html).expect("written");
    let found = selftest(&browse(&html));

    // Twelve mixtures, as `eyebox mix` makes them.
    let rendering = Rendering::of(&frame).expect("complete");
    let mixtures = found["mixtures"].as_array().expect("a list");
    assert_eq!(mixtures.len(), 12);
    for mixture in mixtures {
        let contrast = mixture["contrast"].as_str().map(|text| text.parse().expect("a contrast"));
        let gain = mixture["gain"].as_f64().expect("a gain");
        let recipe = Recipe { gains: vec![(HOSTILE.to_owned(), gain)], contrast };
        let want = layer_luminance(&mix(&rendering, &recipe).expect("mixed").frame, "").expect("a picture");
        let got = numbers(&mixture["luminances"]);
        assert_eq!(got.len(), PIXELS);
        for (want, got) in want.iter().zip(&got) {
            assert!((want - got).abs() < 2e-5 * want.abs(), "{recipe:?}: {got} instead of {want}");
        }
    }
    let command = mixtures[0]["command"].as_str().expect("a command");
    assert!(command.starts_with("eyebox mix 'it'\\''s.exr' --gain '</script>"), "{command}");

    // The read-out: the pixel beside the middle.
    assert_eq!(found["pixel"], serde_json::json!([5, 2]));
    let light = layer_luminance(&frame, "").expect("a picture")[2 * WIDTH + 5];
    let readout = found["readout"].as_str().expect("a text");
    let said: f64 = readout
        .split("mixed picture")
        .nth(1)
        .and_then(|t| t.split(" cd/m²").next())
        .expect("a value")
        .parse()
        .expect("a number");
    assert!((said - light).abs() < 1e-4 * light, "{readout}: {light}");

    // The canvas: the picture as `view` codes it, less what three bytes a value may round otherwise.
    let near = |codes: &Value, want: &[u8]| {
        let codes = numbers(codes);
        assert_eq!(codes.len(), 4 * PIXELS);
        for (pixel, (got, want)) in codes.chunks(4).zip(want.chunks(3)).enumerate() {
            for (got, want) in got.iter().zip(want) {
                assert!((got - f64::from(*want)).abs() <= 1.0, "pixel {pixel}: {got} instead of {want}");
            }
        }
    };
    let exposure =
        (10.0 * render_view(&frame, &ViewOptions::default()).expect("shown").1.exposure_stops.expect("stops")).round()
            / 10.0;
    let options = ViewOptions { exposure: Some(exposure), ..ViewOptions::default() };
    near(&found["codes"], &render_view(&frame, &options).expect("shown").0);
    let luminance = layer_luminance(&frame, "").expect("a picture");
    let ends = eyebox::output::false_colour::scale(&luminance);
    let colours: Vec<u8> =
        luminance.iter().flat_map(|value| eyebox::output::false_colour::colour(*value, ends)).collect();
    near(&found["falseCodes"], &colours);
    assert_eq!(found["legend"].as_array().expect("labels").len(), 5);
    assert_eq!(
        (&found["legend"][0], &found["legend"][4]),
        (&format!("{} cd/m²", ends[0]).into(), &ends[1].to_string().into())
    );

    // A path leads to its layer.
    let clicked = found["clicked"].as_array().expect("a list");
    assert!(clicked[0].as_str().is_some_and(|layer| layer.starts_with("forward_</script>")), "{clicked:?}");
    assert_eq!((&clicked[1], &clicked[2], &clicked[3]), (&clicked[0], &clicked[0], &Value::from("true")));
    let depth = numbers(&found["layers"]["Z"]);
    assert!(
        depth.iter().zip(&frame.component("Z", "Z").expect("Z").data).all(|(a, b)| (a - f64::from(*b)).abs() < 1e-4)
    );

    // Names are texts, and nothing may be loaded.
    assert_eq!(found["markup"], serde_json::json!([0, 0, 0, 0]));
    assert_eq!((&found["pwned"], &found["scripts"]), (&Value::Null, &Value::from(2)));
    assert!(found["texts"].as_str().is_some_and(|text| text.matches("<img src=x").count() >= 4));
    assert_eq!((&found["fetched"], &found["violations"]), (&Value::from(false), &serde_json::json!(["connect-src"])));
}

#[test]
fn usage() {
    let folder = tempfile::tempdir().expect("a folder");
    let exr = folder.path().join("f.exr");
    write_exr(&exr, &frame("led")).expect("written");
    let html = folder.path().join("made.html");
    let made = report(&[&exr], &html);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let said = String::from_utf8_lossy(&made.stdout).into_owned();
    assert!(said.contains("9 × 5 pixels, 11 layers"), "{said}");
    let page = std::fs::read_to_string(&html).expect("readable");
    assert!(page.contains("default-src 'none'") && !page.contains("<img"));
    let fault = |arguments: &[&Path], output: &Path| {
        let made = report(arguments, output);
        assert_eq!(made.status.code(), Some(2));
        String::from_utf8_lossy(&made.stderr).into_owned()
    };
    assert!(fault(&[&exr], &folder.path().join("page.pdf")).contains("a name that ends in .html"));
    assert!(fault(&[&folder.path().join("absent.exr")], &folder.path().join("p.html")).contains("absent.exr"));
    assert!(!folder.path().join("p.html").exists());
}

#[test]
fn bash_completes_commands_options_and_values() {
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
