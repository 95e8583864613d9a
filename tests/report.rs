//! The page of `eyebox report` works itself (`#selftest`), and what it finds is compared with the program: in an engine for
//! JavaScript in every run (`report/engine.rs`), and in a browser where there is one (`report/browser.rs`).

mod browser;
mod engine;

use eyebox::film::frame::{Frame, Meta};
use eyebox::output::exr::write_exr;
use eyebox::output::light_shares::Rendering;
use eyebox::output::luminance::layer_luminance;
use eyebox::output::mix::{Recipe, mix};
use eyebox::output::report::page;
use eyebox::output::view::{ViewOptions, render_view};
use serde_json::{Value, json};
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
    text("groups", &json!([group, "sky"]).to_string());
    text("scene", HOSTILE);
    text("passes", "4");
    text("planReadable", &format!("{HOSTILE} vision: forward because {HOSTILE}"));
    text("parts", &json!([HOSTILE]).to_string());
    text("ledger.forward", "{\"paths\":3,\"emitted\":8.0,\"arrived\":2.0,\"escaped\":2.0,\"absorbed\":[4.0]}");
    frame.meta.insert("contrast".to_owned(), Meta::Number(8.0));
    frame
}

fn report(arguments: &[&Path], output: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    command.arg("report").args(arguments).arg("-o").arg(output).output().expect("the program runs")
}

/// Ends the comparison with what is off.
macro_rules! ensure {
    ($holds:expr, $($why:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            return Err(format!($($why)+));
        }
    };
}

/// The numbers of a list; what is none, or no list at all, is equal to nothing.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect()
}

/// Whether two values are the same, and which of them is off.
fn same(what: &str, got: &Value, want: Value) -> Result<(), String> {
    ensure!(*got == want, "{what}: {got} instead of {want}");
    Ok(())
}

/// What the page found, against the program.
/// Errors: the first thing that is off, by its name.
fn compare(frame: &Frame, found: &Value) -> Result<(), String> {
    mixtures(frame, &found["mixtures"])?;
    readings(frame, found)?;
    canvas(frame, found)?;
    layers(frame, found)?;
    // Names are texts.
    same("markup", &found["markup"], json!([0, 0, 0, 0]))?;
    same("scripts", &found["scripts"], json!(2))?;
    same("pwned", &found["pwned"], Value::Null)?;
    let texts = found["texts"].as_str().unwrap_or_default();
    ensure!(texts.matches("<img src=x").count() >= 4, "texts: {texts}");
    same("fetched", &found["fetched"], json!(false))
}

/// Twelve mixtures, as `eyebox mix` makes them.
fn mixtures(frame: &Frame, found: &Value) -> Result<(), String> {
    let rendering = Rendering::of(frame).expect("complete");
    let mixtures = found.as_array().map_or(&[][..], Vec::as_slice);
    ensure!(mixtures.len() == 12, "mixtures: {} of them", mixtures.len());
    for mixture in mixtures {
        let contrast = mixture["contrast"].as_str().map(|text| text.parse().expect("a contrast"));
        let gain = mixture["gain"].as_f64().unwrap_or(f64::NAN);
        let recipe = Recipe { gains: vec![(HOSTILE.to_owned(), gain)], contrast, ..Recipe::default() };
        let want = layer_luminance(&mix(&rendering, &recipe).expect("mixed").frame, "").expect("a picture");
        let got = numbers(&mixture["luminances"]);
        ensure!(got.len() == PIXELS, "mixture: {} pixels", got.len());
        for (want, got) in want.iter().zip(&got) {
            ensure!((want - got).abs() < 2e-5 * want.abs(), "mixture: {recipe:?}: {got} instead of {want}");
        }
    }
    let command = mixtures[0]["command"].as_str().unwrap_or_default();
    ensure!(command.starts_with("eyebox mix 'it'\\''s.exr' --gain '</script>"), "command: {command}");
    Ok(())
}

/// The read-out, of the pixel beside the middle, and where keys and the pointer lead.
fn readings(frame: &Frame, found: &Value) -> Result<(), String> {
    same("pixel", &found["pixel"], json!([5, 2]))?;
    let light = layer_luminance(frame, "").expect("a picture")[2 * WIDTH + 5];
    let readout = found["readout"].as_str().unwrap_or_default();
    let said = readout.split("mixed picture").nth(1).and_then(|text| text.split(" cd/m²").next()?.parse::<f64>().ok());
    let near = said.is_some_and(|said| (said - light).abs() < 1e-4 * light);
    ensure!(near, "read-out: {readout} instead of {light}");
    same("pointer", &found["pointed"], json!([null, [1, 3], [2, 4], [2, 4], null]))
}

/// The canvas: the picture as `view` codes it, less what three bytes a value may round otherwise.
fn canvas(frame: &Frame, found: &Value) -> Result<(), String> {
    let near = |what: &str, codes: &Value, want: &[u8]| {
        let codes = numbers(codes);
        ensure!(codes.len() == 4 * PIXELS, "{what}: {} codes", codes.len());
        for (pixel, (got, want)) in codes.chunks(4).zip(want.chunks(3)).enumerate() {
            for (got, want) in got.iter().zip(want) {
                let off = (got - f64::from(*want)).abs();
                ensure!(off <= 1.0, "{what}: pixel {pixel}: {got} instead of {want}");
            }
        }
        Ok(())
    };
    let adapted = render_view(frame, &ViewOptions::default()).expect("shown").1.exposure_stops.expect("stops");
    let options = ViewOptions { exposure: Some((10.0 * adapted).round() / 10.0), ..ViewOptions::default() };
    near("codes", &found["codes"], &render_view(frame, &options).expect("shown").0)?;
    let luminance = layer_luminance(frame, "").expect("a picture");
    let ends = eyebox::output::false_colour::scale(&luminance);
    let colours: Vec<u8> =
        luminance.iter().flat_map(|value| eyebox::output::false_colour::colour(*value, ends)).collect();
    near("false colours", &found["falseCodes"], &colours)?;
    let legend = found["legend"].as_array().map_or(&[][..], Vec::as_slice);
    ensure!(legend.len() == 5, "legend: {legend:?}");
    same("legend", &legend[0], json!(format!("{} cd/m²", ends[0])))?;
    same("legend", &legend[4], json!(ends[1].to_string()))
}

/// A path leads to its layer, and layers hold what the frame does.
fn layers(frame: &Frame, found: &Value) -> Result<(), String> {
    let clicked = &found["clicked"];
    let layer = clicked[0].as_str().unwrap_or_default();
    ensure!(layer.starts_with("forward_</script>"), "path: {clicked}");
    same("path", clicked, json!([layer, layer, layer, "true"]))?;
    let depth = numbers(&found["layers"]["Z"]);
    let want = &frame.component("Z", "Z").expect("Z").data;
    let near = want.iter().zip(&depth).all(|(want, got)| (got - f64::from(*want)).abs() < 1e-4);
    ensure!(depth.len() == PIXELS && near, "depth: {depth:?} instead of {want:?}");
    Ok(())
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Our own writer refuses such names of layers; the page must stand them all the same.
fn hostile() -> (Frame, String) {
    let frame = frame(HOSTILE);
    let html = page(&[("it's.exr".to_owned(), &frame)]).expect("a page").html;
    (frame, html)
}

#[test]
fn the_page_mixes_shows_and_reads_as_the_program_does() {
    let (frame, html) = hostile();
    let found = engine::selftest(&html).unwrap_or_else(|fault| panic!("{fault}"));
    compare(&frame, &parsed(&found)).unwrap_or_else(|off| panic!("{off}"));
}

#[test]
fn the_page_does_so_in_a_browser_which_lets_nothing_be_loaded() {
    let (frame, html) = hostile();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("report.html");
    std::fs::write(&file, html).expect("written");
    let Some(found) = browser::selftest(&file) else { return };
    let found = parsed(&found);
    compare(&frame, &found).unwrap_or_else(|off| panic!("{off}"));
    assert_eq!(found["violations"], json!(["connect-src"]));
}

/// Faults planted in the page, and what the comparison says of each.
#[test]
fn a_page_that_is_wrong_is_found_out() {
    let (frame, html) = hostile();
    let faults = [
        ("crossings * u * v", "crossings * u", "mixture: "),
        ("crossings = crossings * u +", "crossings = crossings +", "mixture: "),
        ("sum[at] += gain * picture[at]", "sum[at] += picture[at]", "mixture: "),
        ("<< (24 - 8 * byte)", "<< (24 - 7 * byte)", "mixture: "),
        ("frame.weights[1] * data[1]", "frame.weights[1] * data[0]", "mixture: "),
        ("replaceAll(\"'\", \"'\\\\''\")", "replaceAll(\"'\", \"''\")", "command: "),
        ("ArrowRight: [1, 0]", "ArrowRight: [-1, 0]", "pixel: "),
        ("const at = y * width + x;\n    const block", "const at = x * height + y;\n    const block", "read-out: "),
        ("event.clientX - box.left", "event.clientX", "pointer: "),
        ("kept || at(event)", "at(event)", "pointer: "),
        ("value ** (1 / 2.4)", "value ** (1 / 2.2)", "codes: "),
        ("2 ** shown.exposure", "shown.exposure", "codes: "),
        ("Math.log(value / low)", "Math.log(value)", "false colours: "),
        ("\"click\", () => choose(path.layer)", "\"click\", () => {}", "path: "),
        // A browser would take this markup; here no node has such a property.
        (
            "properties);\n  element.append(...children)",
            "properties);\n  element.innerHTML = children.join()",
            "The page could",
        ),
    ];
    for (right, wrong, want) in faults {
        assert_eq!(html.matches(right).count(), 1, "{right}");
        let off = engine::selftest(&html.replace(right, wrong)).and_then(|found| compare(&frame, &parsed(&found)));
        assert!(off.as_ref().is_err_and(|off| off.starts_with(want)), "{wrong} instead of {right}: {off:?}");
    }
    // Names that are not escaped end the block of data, and what follows becomes elements.
    let off = engine::selftest(&html.replace("\\u003c", "<").replace("\\u003e", ">"));
    assert!(off.as_ref().is_err_and(|off| off.contains("JSON")), "{off:?}");
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

/// With a scan the page has its pictures; a file that is none ends the program with one line.
#[test]
fn a_scan_is_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let [exr, json, html] = ["frame.exr", "scan.json", "report.html"].map(|name| folder.path().join(name));
    write_exr(&exr, &frame("led")).expect("written");
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/windshield/windshield.optics.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    let fixed = ["--eyebox", "2x1", "--width", "60", "--no-luminance", "--points", "3x3", "--quiet", "-o"];
    let out = command.arg("scan").arg(&sample).args(fixed).arg(&json).output().expect("it runs");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let run = || report(&[&exr, Path::new("--scan"), &json], &html);
    let out = run();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let page = std::fs::read_to_string(&html).expect("the page");
    assert_eq!(page.matches("<svg class=\"chart\"").count(), 3);
    assert!(page.contains("FOLD_MIRROR, MIRROR_FREEFORM, WINDSHIELD back") && page.contains("-30.0, 0.0 mm"));
    let good = std::fs::read_to_string(&json).expect("the scan");
    for bad in ["", "{}", "{\"scan\": 3}", &good[..good.len() / 2], &good.replace("\"slide\"", "\"a\\nb\"")] {
        std::fs::write(&json, bad).expect("written");
        let out = run();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && said.trim_end().lines().count() == 1, "{bad:.40}: {said}");
        assert!(said.contains("scan.json"), "{said}");
    }
}
