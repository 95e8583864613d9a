use clap::{Args, FromArgMatches};

use super::*;
use crate::film::frame::Meta;

fn parse(words: &[&str]) -> std::result::Result<MixArgs, clap::Error> {
    let command = MixArgs::augment_args(clap::Command::new("mix"));
    command.try_get_matches_from(words).map(|matches| MixArgs::from_arg_matches(&matches).unwrap())
}

#[test]
fn mixes_files_and_records_it() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (source, out, png, plate) = (path("f.exr"), path("o.exr"), path("o.png"), path("plate.exr"));
    let mut frame = Frame::new(2, 1);
    frame.meta.insert("groups".into(), Meta::Text("[\"led\"]".into()));
    for layer in ["", "hybrid.", "forward.", "forward_led.", "seethrough."] {
        let value = if layer == "seethrough." { 0.5 } else { 40.0 };
        ["R", "G", "B"].iter().for_each(|c| frame.push(format!("{layer}{c}"), vec![value; 2]));
    }
    write_exr(Path::new(&source), &frame).unwrap();
    let mut behind = Frame::new(2, 1);
    ["R", "G", "B"].iter().for_each(|c| behind.push(*c, vec![10.0, 20.0]));
    write_exr(Path::new(&plate), &behind).unwrap();

    let words = ["mix", &source, "--gain", "led=0.5", "--plate", &plate, "-o", &out];
    let (json, text) = mixed(&parse(&words).unwrap()).unwrap();
    assert!(text.contains("led × 0.5, plate "), "{text}");
    assert_eq!(json["mix"]["gains"], serde_json::json!([["led", 0.5]]));
    let written = read_exr(Path::new(&out)).unwrap();
    assert_eq!(written.rgb("").unwrap()[0], [25.0, 30.0]);
    assert!(written.layer_names().contains(&"plate"));
    // Mixed again: the header tells both steps.
    mixed(&parse(&["mix", &out, "--gain", "plate=0", "-o", &out]).unwrap()).unwrap();
    let again = read_exr(Path::new(&out)).unwrap();
    assert_eq!(again.rgb("").unwrap()[0], [20.0, 20.0]);
    let records: serde_json::Value = serde_json::from_str(again.text("mix").unwrap()).unwrap();
    assert_eq!(records.as_array().unwrap().len(), 2);
    assert_eq!(records[1]["gains"][0][0], "plate");
    // As a PNG: the view of the mixture. 40 cd/m² all over is what the display adapts to.
    let (json, _) = mixed(&parse(&["mix", &source, "-o", &png]).unwrap()).unwrap();
    assert_eq!(json["view"]["adaptation_cd_m2"], 40.0);
    assert_eq!(image::open(&png).unwrap().into_rgb8().dimensions(), (2, 1));

    let fault = |words: &[&str]| mixed(&parse(words).unwrap()).unwrap_err().to_string();
    assert!(fault(&["mix", &source, "--gain", "leed=2", "-o", &out]).ends_with("did you mean `led`?"));
    assert!(fault(&["mix", &source, "-o", &path("o.tif")]).contains(".exr or .png"));
    assert!(fault(&["mix", &source, "--contrast", "9", "-o", &out]).contains("no slide"));
    assert!(fault(&["mix", &plate, "-o", &out]).contains("plate.exr: the header has no list of light groups"));
    assert!(fault(&["mix", &source, &source, "-o", &out]).contains("frame 2 has light in `forward_led`"));
}

#[test]
fn usage() {
    for bad in [
        &["mix", "-o", "o.exr"][..],
        &["mix", "f.exr"],
        &["mix", "f.exr", "-o", "o.exr", "--gain", "led"],
        &["mix", "f.exr", "-o", "o.exr", "--gain", "led=x"],
        &["mix", "f.exr", "-o", "o.exr", "--solve", "contrast=0"],
        &["mix", "f.exr", "-o", "o.exr", "--solve-for", "led"],
    ] {
        assert!(parse(bad).is_err(), "{bad:?}");
    }
    assert_eq!(parse_contrast("300:1"), Ok((None, 300.0)));
    assert_eq!(parse_contrast("inf"), Ok((None, f64::INFINITY)));
    assert_eq!(parse_contrast("lcd = 20:1"), Ok((Some("lcd".to_owned()), 20.0)));
    assert!(parse_contrast("1000:2").unwrap_err().contains("write e.g. 300, 300:1, inf or lcd=300"));
    assert_eq!(parse_gain("a=b=2"), Ok(("a=b".to_owned(), 2.0)));
    let help = MixArgs::augment_args(clap::Command::new("mix")).render_long_help().to_string();
    assert!(help.contains("eyebox mix hud.exr --gain led=0.25 --contrast 1000 -o dim.exr"), "{help}");
}
