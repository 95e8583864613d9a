use super::planes::tests::decode;
use super::*;
use eyebox_film::frame::Meta;

/// A group's name that would be markup, in a file that anyone may have made.
const HOSTILE: &str = "</script><img src=x onerror=pwned=1>";

/// Two groups; the second passes a slide. 6 × 4 pixels, no noise but a stated one of 1 %.
fn frame() -> Frame {
    let mut frame = Frame::new(6, 4);
    let picture = |scale: f32| -> Vec<f32> { (0..24).map(|pixel| scale * (1.0 + pixel as f32)).collect() };
    let contrast = 10.0f32;
    let (open, content) = (picture(50.0), picture(7.0));
    let led: Vec<f32> = open.iter().zip(&content).map(|(o, c)| c * (1.0 - 1.0 / contrast) + o / contrast).collect();
    let sum: Vec<f32> = led.iter().zip(picture(3.0)).map(|(a, b)| a + b).collect();
    let noise = sum.iter().map(|value| 0.01 * value).collect();
    let mut push = |layer: &str, data: &Vec<f32>| {
        for (component, scale) in [("R", 1.0), ("G", 1.0), ("B", 1.0)] {
            let name = if layer.is_empty() { component.to_owned() } else { format!("{layer}.{component}") };
            frame.push(name, data.iter().map(|value| scale * value).collect());
        }
    };
    push("", &sum);
    push("hybrid", &sum);
    push("direct", &picture(3.0));
    push(&format!("direct_{HOSTILE}"), &picture(3.0));
    push("forward", &led);
    push("forward_led", &led);
    push("forward_led_open", &open);
    push("forward_led_content", &content);
    frame.push("stderr.Y", noise);
    frame.push("Z.Z", picture(0.1));
    frame.push("CryptoPart00.R", vec![f32::NAN; 24]);
    let mut put = |key: &str, value: Meta| frame.meta.insert(key.to_owned(), value);
    put("groups", Meta::Text(serde_json::json!([HOSTILE, "led"]).to_string()));
    put("contrast", Meta::Number(f64::from(contrast)));
    put("scene", Meta::Text("a scene".to_owned()));
    put("passes", Meta::Text("16".to_owned()));
    put("planReadable", Meta::Text("led vision: forward because it is small\nnote: none".to_owned()));
    put("parts", Meta::Text("[\"A\",\"B\"]".to_owned()));
    let ledger =
        serde_json::json!({ "paths": 9, "emitted": 32.0, "arrived": 8.0, "escaped": 4.0, "absorbed": [16.0, 4.0] });
    put("ledger.forward", Meta::Text(ledger.to_string()));
    put("convergence", Meta::Text("[[2,0.03],[4,0.02],[8,0.015],[16,0.01],[0,1],[3,null]]".to_owned()));
    frame
}

fn named(frame: &Frame) -> Vec<(String, &Frame)> {
    vec![("f.exr".to_owned(), frame)]
}

fn data_of(html: &str) -> Value {
    let block = html.split("id=\"frame\">").nth(1).unwrap().split("</script>").next().unwrap();
    serde_json::from_str(block).unwrap()
}

#[test]
fn the_data_are_those_of_the_frame() {
    let mut frame = frame();
    frame.channels.retain(|channel| !channel.name.starts_with("Crypto"));
    let made = page(&named(&frame)).unwrap();
    let data = data_of(&made.html);
    assert_eq!((made.size, made.factor, made.unmixed), ([6, 4], 1, None));
    // Equal planes are stored once: sum, direct, led, open, content, stderr, Z.
    assert_eq!(data["planes"].as_array().unwrap().len(), 7);
    let planes: Vec<Vec<f32>> =
        data["planes"].as_array().unwrap().iter().map(|plane| decode(plane.as_str().unwrap())).collect();
    for layer in data["layers"].as_array().unwrap() {
        let name = layer["name"].as_str().unwrap();
        let want = frame.rgb(name).map_or_else(|| &frame.component(name, "Z").unwrap().data[..], |rgb| rgb[0]);
        let got = &planes[usize::try_from(layer["planes"][0].as_i64().unwrap()).unwrap()];
        assert!(want.iter().zip(got).all(|(a, b)| (a - b).abs() <= a.abs() * 2f32.powi(-16)), "{name}");
    }
    assert_eq!(data["layers"][0]["name"], "hybrid");
    assert_eq!(data["groups"], serde_json::json!([HOSTILE, "led"]));
    assert_eq!(data["shares"][1]["split"]["cross"], serde_json::json!([null, null, null]));
    assert_eq!(data["plan"], serde_json::json!([["led vision: forward", "it is small"], ["note: none", ""]]));
    // The ledger's lumens are those of a pass.
    let ledger = &data["ledgers"][0];
    assert_eq!((&ledger["unit"], &ledger["rows"][0]["amount"]), (&Value::from("lm"), &Value::from(2.0)));
    let balance =
        ledger["rows"].as_array().unwrap().iter().find(|row| row["name"].as_str().unwrap().starts_with("balance"));
    assert_eq!(balance.unwrap()["amount"], 0.0);
    assert_eq!(ledger["parts"][0], serde_json::json!({ "name": "A", "amount": 1.0, "share": 0.5 }));
    assert!(data["metrics"].as_array().unwrap().len() > 10);
}

#[test]
fn hostile_names_stay_texts() {
    let made = page(&named(&frame())).unwrap();
    assert!(!made.html.contains("<img"));
    assert_eq!(made.unmixed, None, "what a matte holds says nothing of light");
    let data = data_of(&made.html);
    assert!(data["layers"].as_array().unwrap().iter().all(|layer| layer["name"] != "CryptoPart00"));
    assert!(!data["shares"].as_array().unwrap().is_empty());
}

#[test]
fn convergence_and_other_frames() {
    let first = frame();
    let mut second = frame();
    second.meta.insert("passes".into(), Meta::Text("64".into()));
    second.meta.remove("convergence");
    second
        .channels
        .iter_mut()
        .filter(|c| c.layer() == "stderr")
        .for_each(|c| c.data.iter_mut().for_each(|v| *v /= 2.0));
    // A list with anything but pairs of numbers is no list.
    let broken = page(&[("a.exr".to_owned(), &first)]).unwrap();
    assert_eq!(data_of(&broken.html)["convergence"].as_array().unwrap().len(), 1);
    let mut listed = first.clone();
    listed.meta.insert("convergence".into(), Meta::Text("[[2,0.03],[4,0.02],[8,0.015],[16,0.012],[0,1]]".into()));
    let made = page(&[("a.exr".to_owned(), &listed), ("b.exr".to_owned(), &second)]).unwrap();
    let points = data_of(&made.html)["convergence"].clone();
    let passes: Vec<f64> = points.as_array().unwrap().iter().map(|p| p["passes"].as_f64().unwrap()).collect();
    assert_eq!(passes, [2.0, 4.0, 8.0, 16.0, 64.0]);
    // The header says more than the noise, which is 0.01.
    assert!((points[3]["error"].as_f64().unwrap() - 0.012).abs() < 1e-6 && points[3]["from"] == "header of a.exr");
    assert!((points[4]["error"].as_f64().unwrap() - 0.005).abs() < 1e-6);
    // 0.8 of the light is noise, 0.64 of its squares: 4/3 of what is left of them. More, and nothing is.
    for (scale, want) in [(160.0, Some(4.0 / 3.0)), (201.0, None)] {
        let mut noisy = second.clone();
        let stderr = noisy.channels.iter_mut().filter(|c| c.layer() == "stderr");
        stderr.for_each(|c| c.data.iter_mut().for_each(|v| *v *= scale));
        let noise = convergence::relative_noise(&noisy);
        assert!(
            noise.is_some() == want.is_some() && noise.zip(want).is_none_or(|(a, b)| (a / b - 1.0).abs() < 1e-4),
            "{noise:?}"
        );
    }
    second.meta.insert("sceneHash".into(), Meta::Text("other".into()));
    let fault = page(&[("a.exr".to_owned(), &first), ("b.exr".to_owned(), &second)]).unwrap_err().to_string();
    assert!(fault.contains("b.exr is of another scene (other)"), "{fault}");
}

#[test]
fn paths_lead_to_layers() {
    let mut frame = frame();
    let rows = serde_json::json!({ "rows": [
        { "path": "led → eye", "flux_lm": 2e-6, "share": 0.75, "kind": "main", "group": "led" },
        { "name": "ghost", "share": 0.25, "layer": "chain.forward_led" },
        { "name": "nowhere", "layer": "absent" }, { "share": 1 }, 7,
    ]});
    frame.meta.insert("paths".into(), Meta::Text(rows.to_string()));
    frame.meta.insert("chain.direct".into(), Meta::Text("led → eye".into()));
    let data = data_of(&page(&named(&frame)).unwrap().html);
    let found: Vec<(&str, Option<&str>)> = data["paths"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| (row["name"].as_str().unwrap(), row["layer"].as_str()))
        .collect();
    assert_eq!(found, [("led → eye", Some("direct")), ("ghost", Some("forward_led")), ("nowhere", None)]);
    assert_eq!((&data["paths"][0]["amount"], &data["paths"][0]["said"]), (&2e-6.into(), &"led, main".into()));
}

#[test]
fn frames_without_much() {
    assert!(page(&[]).is_err());
    assert!(page(&named(&Frame::new(2, 2))).unwrap_err().to_string().contains("no layer to show"));
    let mut bare = Frame::new(2, 1);
    bare.push("Z", vec![1.0, f32::INFINITY]);
    let made = page(&named(&bare)).unwrap();
    assert!(made.unmixed.unwrap().contains("no list of light groups"));
    let mut torn = bare.clone();
    torn.push("A", vec![1.0]);
    assert!(page(&named(&torn)).unwrap_err().to_string().contains("expected 2 × 1"));
}

/// Two slides, the light of each alone and through both: the mean of the picture at any contrast of one by the formulas of
/// `docs/mix.md`. Where light of one is not told apart, that is said.
#[test]
fn what_the_contrast_of_each_slide_does() {
    let mut frame = Frame::new(2, 1);
    let mut push = |layer: &str, data: [f32; 2]| {
        for component in ["R", "G", "B"] {
            let name = if layer.is_empty() { component.to_owned() } else { format!("{layer}.{component}") };
            frame.push(name, data.to_vec());
        }
    };
    // Contrasts of 4 and 2: 64/4 + 8·¾ = 22 alone; through both ½·(¼·a + ¾·b) of 32, 16, 8, 4.
    push("direct_led_near_open", [64.0, 32.0]);
    push("direct_led_near_content", [8.0, 0.0]);
    for (suffix, value) in
        [("open_open", 32.0), ("content_open", 16.0), ("open_content", 8.0), ("content_content", 4.0)]
    {
        push(&format!("direct_led_near_far_{suffix}"), [value; 2]);
    }
    // ½·(32/4 + 16·¾) + ½·(8/4 + 4·¾) = 12.5
    for layer in ["", "hybrid", "direct", "direct_led"] {
        push(layer, [22.0 + 12.5, 8.0 + 12.5]);
    }
    let mut put = |key: &str, value: Value| frame.meta.insert(key.to_owned(), Meta::Text(value.to_string()));
    put("groups", json!(["led"]));
    let slide = |name: &str, contrast: &str| json!({ "name": name, "part": name, "contrast": contrast });
    put("slides", json!([slide("near", "4"), slide("far", "2")]));
    let rows = slides::rows(&Rendering::of(&frame).expect("complete"));
    // Of `near` open: means of 48 and ½·32 + ½·8; black: 4 and ½·16 + ½·4. Of `far`: 15 and 20 open, 5 black.
    let want = [
        [
            "contrast of near",
            "4: the picture's mean is 27.5000 cd/m²; 68.0000 with it open, 14.0000 with a perfect black of it",
        ],
        [
            "contrast of far",
            "2: the picture's mean is 27.5000 cd/m²; 35.0000 with it open, 20.0000 with a perfect black of it",
        ],
    ];
    assert_eq!(rows, want.map(|row| row.map(str::to_owned)));
    let shown = data_of(&page(&named(&frame)).expect("a page").html)["facts"].to_string();
    assert!(want.iter().flatten().all(|text| shown.contains(text)), "{shown}");
    let refused =
        json!([{ "layer": "direct", "group": "led", "slide": "far", "written": false, "because": "of three" }]);
    frame.meta.insert("splits".to_owned(), Meta::Text(refused.to_string()));
    let rows = slides::rows(&Rendering::of(&frame).expect("complete"));
    assert_eq!(rows[1][1], "2: its light is not told apart: of three");
    assert_eq!(rows[0][1], want[0][1]);
}
