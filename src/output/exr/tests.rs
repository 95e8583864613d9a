use std::io::Cursor;
use std::path::Path;

use ::exr::prelude::*;

use super::{read_exr, warnings, write_exr};
use eyebox_film::exr::decode;
use eyebox_film::frame::{Frame, Meta};

/// A generator of test values; any will do (constants of Knuth's MMIX).
struct Values(u64);

impl Values {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }
}

fn sample() -> Frame {
    let mut frame = Frame::new(67, 45);
    let mut values = Values(1);
    // In an order that is not EXR's.
    for name in ["R", "G", "B", "forward.R", "forward.G", "forward.B", "direct.B", "Z.Z", "normal_seen.X"] {
        // Six decades and more, both signs, as light and data have.
        let value = |_| (values.next() as f32 - 1e9) * (values.next() as f32).powi(3);
        frame.push(name, (0..67 * 45).map(value).collect());
    }
    frame.channels[7].data[5] = f32::MAX;
    frame.channels[7].data[6] = f32::MIN_POSITIVE / 4.0;
    let meta = [
        ("colorInteropID", Meta::Text("lin_rec709_scene".into())),
        ("whiteLuminance", Meta::Number(1.0)),
        ("plan", Meta::Text("{\"skip\": \"no face scatters — cd/m²\"}".into())),
        ("seed", Meta::Integer(-7)),
        ("rays", Meta::Integer(9_007_199_254_740_993)),
        ("pupil_mm", Meta::Number(0.1)),
        ("empty", Meta::Text(String::new())),
        ("a_rather_long_name_of_an_attribute", Meta::Number(f64::MAX)),
    ];
    frame.meta = meta.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    frame
}

fn bytes_of(frame: &Frame) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("frame.exr");
    write_exr(&path, frame).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn round_trip_keeps_every_bit_and_all_metadata() {
    let frame = sample();
    let back = decode(&bytes_of(&frame)).unwrap();
    assert_eq!((back.width, back.height, back.channels.len()), (frame.width, frame.height, frame.channels.len()));
    for channel in &frame.channels {
        let bits = |data: &[f32]| data.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back.get(&channel.name).unwrap().data), bits(&channel.data), "{}", channel.name);
    }
    // What does not fit 32 bits travels as text and is read back by the same accessor.
    assert_eq!(back.integer("rays"), frame.integer("rays"));
    for (key, value) in frame.meta.iter().filter(|(key, _)| *key != "rays") {
        assert_eq!(back.meta.get(key), Some(value), "{key}");
    }
    assert_eq!(back.meta.len(), frame.meta.len());
    let plain = decode(&bytes_of(&Frame { meta: Default::default(), ..frame })).unwrap();
    assert_eq!((plain.text("colorInteropID"), plain.number("whiteLuminance")), (Some("lin_rec709_scene"), Some(1.0)));
}

/// Layers with a prefix, in parts of their own, or both: in the file as asked, in the frame as ever.
#[test]
fn prefix_and_parts_are_the_files_own_business() {
    let mut plain = sample();
    plain.push("Z", vec![1.5; 67 * 45]);
    eyebox_film::cryptomatte::add(
        &mut plain,
        eyebox_film::cryptomatte::Matte::Part,
        &vec![Default::default(); 67 * 45],
        &["p"],
    );
    let by_name = |frame: &Frame| {
        let mut all: Vec<(String, Vec<u32>)> =
            frame.channels.iter().map(|c| (c.name.clone(), c.data.iter().map(|v| v.to_bits()).collect())).collect();
        all.sort();
        all
    };
    let contains = |bytes: &[u8], text: &str| bytes.windows(text.len()).any(|part| part == text.as_bytes());
    for (prefix, several) in [(None, false), (Some("eb_"), false), (None, true), (Some("eb_"), true)] {
        let mut frame = plain.clone();
        frame.meta.extend(prefix.map(|prefix| ("layerPrefix".to_owned(), Meta::Text(prefix.into()))));
        frame.meta.extend(several.then(|| ("multiPart".to_owned(), Meta::Integer(1))));
        let bytes = bytes_of(&frame);
        assert_eq!(contains(&bytes, "eb_forward.R"), prefix.is_some());
        assert_eq!(contains(&bytes, "eb_CryptoPart01.r"), prefix.is_some());
        assert!(!contains(&bytes, "eb_R") && !contains(&bytes, "eb_Z\0"));
        // The specification's key: seven digits of the hash of the name that the layers have in the file.
        let stored = format!("{}CryptoPart", prefix.unwrap_or(""));
        let key =
            format!("cryptomatte/{}/name\0", &format!("{:08x}", eyebox_film::cryptomatte::identity(&stored))[..7]);
        assert!(contains(&bytes, &key) && contains(&bytes, "cryptomatte/3201c4f/") == prefix.is_none(), "{key}");
        let back = decode(&bytes).unwrap();
        assert_eq!(by_name(&back), by_name(&frame), "{prefix:?} {several}");
        assert_eq!(back.text("cryptomatte/3201c4f/name"), Some("CryptoPart"));
        assert_eq!(back.meta.len(), frame.meta.len());
        // Written again as it was read: the same file.
        assert!(bytes_of(&back) == bytes);
        let headers = ::exr::meta::MetaData::read_from_buffered(Cursor::new(&bytes), true).unwrap().headers;
        let names: Vec<String> =
            headers.iter().filter_map(|h| Some(h.own_attributes.layer_name.as_ref()?.to_string())).collect();
        if several {
            let p = prefix.unwrap_or("");
            let crypto = ["00", "01", "02"].map(|level| format!("{p}CryptoPart{level}"));
            let rest =
                ["Z", "direct", "forward", "normal_seen"].map(|n| format!("{}{n}", if n == "Z" { "" } else { p }));
            // `Z.Z` is a layer, `Z` has no dot.
            let layer_z = prefix.map(|prefix| format!("{prefix}Z"));
            let mut want: Vec<String> = crypto.into_iter().chain(rest).chain(layer_z).collect();
            let mut got = names[1..].to_vec();
            want.sort();
            got.sort();
            assert_eq!((names[0].as_str(), got), ("picture", want));
            let colour = |part: usize| headers[part].own_attributes.other.get(&Text::from("colorInteropID")).cloned();
            let at = |name: &str| names.iter().position(|own| *own == format!("{p}{name}")).unwrap();
            assert_eq!(colour(at("normal_seen")), Some(AttributeValue::Text(Text::from("data"))));
            assert_eq!(colour(at("forward")), Some(AttributeValue::Text(Text::from("lin_rec709_scene"))));
        } else {
            assert!(headers.len() == 1 && names.is_empty());
        }
        for cut in (0..bytes.len()).step_by(61) {
            assert!(decode(&bytes[..cut]).is_err(), "cut at {cut}");
        }
    }
    let mut bad = plain;
    bad.meta.insert("layerPrefix".to_owned(), Meta::Text("1_".into()));
    let fault = write_exr(&std::env::temp_dir().join("never.exr"), &bad).unwrap_err().to_string();
    assert!(fault.contains("`1_` cannot begin a layer's name"), "{fault}");
}

/// A header may say a prefix that would make two names one.
#[test]
fn a_hostile_prefix_loses_nothing() {
    let mut frame = Frame::new(1, 1);
    for (name, value) in [("R", 0.0), ("a_R.R", 1.0), ("R.R", 2.0), ("a_1.R", 3.0), ("a_.R", 4.0)] {
        frame.push(name, vec![value]);
    }
    let plain = bytes_of(&frame);
    let mut back = decode(&plain).unwrap();
    back.meta.insert("layerPrefix".to_owned(), Meta::Text("a_".into()));
    eyebox_film::exr::without_prefix(&mut back);
    assert_eq!(back.layer_names(), ["", "R", "a_", "a_1", "a_R"]);
}

#[test]
fn same_frame_same_bytes_twenty_times() {
    let frame = sample();
    let first = bytes_of(&frame);
    for time in 1..20 {
        assert!(bytes_of(&frame) == first, "differs at time {time}");
    }
    let mut shuffled = frame;
    shuffled.channels.reverse();
    assert!(bytes_of(&shuffled) == first, "the order of the channels in the frame must not matter");
}

#[test]
fn same_frame_same_bytes_in_other_processes() {
    const OUT: &str = "EYEBOX_TEST_WRITE_FRAME_TO";
    if let Some(path) = std::env::var_os(OUT) {
        write_exr(Path::new(&path), &sample()).unwrap();
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let here = bytes_of(&sample());
    for child in 0..4 {
        let path = directory.path().join(format!("{child}.exr"));
        let status = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "exr::tests::same_frame_same_bytes_in_other_processes"])
            .env(OUT, &path)
            .env("RAYON_NUM_THREADS", (child + 1).to_string())
            .stdout(std::process::Stdio::null())
            .status()
            .unwrap();
        assert!(status.success());
        assert!(std::fs::read(&path).unwrap() == here, "process {child} wrote other bytes");
    }
}

#[test]
fn refuses_what_must_not_be_written_and_leaves_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("frame.exr");
    let refused = |change: &dyn Fn(&mut Frame)| {
        let mut frame = sample();
        change(&mut frame);
        let fault = write_exr(&path, &frame).unwrap_err().to_string();
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0, "{fault}");
        fault
    };
    let fault = refused(&|frame| frame.channels[4].data[67 * 2 + 3] = f32::NAN);
    assert!(fault.contains("`forward.G` is NaN at pixel (3, 2)"), "{fault}");
    let fault = refused(&|frame| frame.channels[0].data[0] = f32::INFINITY);
    assert!(fault.contains("`R` is inf at pixel (0, 0)"), "{fault}");
    for name in ["direct.left.R", "1st.R", ".R", "R.", "", "a b", "Größe", "_x", &"x".repeat(256)] {
        let fault = refused(&|frame| frame.channels[0].name = name.into());
        assert!(fault.contains("cannot name a channel"), "{name}: {fault}");
    }
    assert!(refused(&|frame| frame.channels[0].name = "G".into()).contains("`G` is there twice"));
    assert!(refused(&|frame| frame.channels[1].data.truncate(9)).contains("`G` has 9 values"));
    assert!(refused(&|frame| frame.channels.clear()).contains("no channel"));
    assert!(refused(&|frame| frame.width = 0).contains("0 × 45"));
    assert!(refused(&|frame| frame.width = usize::MAX).contains("cannot be written"));
    for key in ["", "two words", "Größe", "nul\0", &"k".repeat(250)] {
        let fault = refused(&|frame| drop(frame.meta.insert(key.into(), Meta::Integer(1))));
        assert!(fault.contains("cannot name an attribute"), "{key}: {fault}");
    }
    assert!(refused(&|frame| drop(frame.meta.insert("whiteLuminance".into(), Meta::Number(0.0)))).contains("positive"));
}

#[test]
fn an_older_file_survives_a_refusal() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("frame.exr");
    let mut frame = sample();
    write_exr(&path, &frame).unwrap();
    let before = std::fs::read(&path).unwrap();
    frame.channels[0].data[0] = f32::NAN;
    write_exr(&path, &frame).unwrap_err();
    assert!(std::fs::read(&path).unwrap() == before);
}

#[test]
fn long_names_are_declared() {
    let name = format!("hybrid_{}_open.R", "led_array_of_the_passenger_side".repeat(3));
    let mut frame = Frame::new(1, 1);
    frame.push("R", vec![1.0]);
    // Bit 10 of the little-endian version field at byte 4.
    assert_eq!(bytes_of(&frame)[5] & 4, 0, "short names need no flag");
    frame.push(&name, vec![2.0]);
    let bytes = bytes_of(&frame);
    assert_eq!(bytes[5] & 4, 4);
    assert_eq!(decode(&bytes).unwrap().get(&name).unwrap().data, [2.0]);
}

#[test]
fn many_channels_are_warned_about() {
    let mut frame = Frame::new(1, 1);
    frame.channels =
        (0..501).map(|i| eyebox_film::frame::Channel { name: format!("g{i}.R"), data: vec![0.0].into() }).collect();
    assert!(warnings(&frame)[0].starts_with("501 channels"));
    frame.channels.pop();
    assert!(warnings(&frame).is_empty());
}

/// Writes with the `exr` crate directly: what other programs may hand us.
fn foreign(
    name: &str,
    size: (usize, usize),
    encoding: Encoding,
    samples: FlatSamples,
) -> Layer<AnyChannels<FlatSamples>> {
    let channels = AnyChannels::sort([AnyChannel::new("Y", samples)].into_iter().collect());
    Layer::new(size, LayerAttributes::named(name), encoding, channels)
}

fn encoded<L>(image: Image<L>) -> Vec<u8>
where
    for<'s> L: ::exr::image::write::layers::WritableLayers<'s>,
{
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn reads_tiles_half_and_integers_of_any_lossless_compression() {
    let (width, height) = (37, 21);
    let ramp: Vec<f32> = (0..width * height).map(|i| i as f32).collect();
    let half = FlatSamples::F16(ramp.iter().map(|v| f16::from_f32(*v)).collect());
    let float = FlatSamples::F32(ramp.clone());
    let integer = FlatSamples::U32(ramp.iter().map(|v| *v as u32).collect());
    for compression in
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
    {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))] {
            for samples in [&half, &float, &integer] {
                let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
                let image = Image::from_layer(foreign("sky", (width, height), encoding, samples.clone()));
                let frame = decode(&encoded(image)).unwrap();
                assert_eq!((frame.width, frame.height), (width, height));
                assert_eq!(frame.rgb("").unwrap(), [ramp.as_slice(); 3], "{encoding:?}");
            }
        }
    }
}

#[test]
fn reads_several_parts_of_one_size() {
    let part = |name: &str, value: f32, size: (usize, usize)| {
        foreign(name, size, Encoding::FAST_LOSSLESS, FlatSamples::F32(vec![value; size.0 * size.1]))
    };
    let image = |parts: Vec<Layer<AnyChannels<FlatSamples>>>| {
        encoded(Image::from_layers(ImageAttributes::with_size((8, 4)), parts.into_iter().collect::<Layers<_>>()))
    };
    let frame = decode(&image(vec![part("first", 1.0, (8, 4)), part("depth", 2.0, (8, 4))])).unwrap();
    let names: Vec<_> = frame.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["Y", "depth.Y"]);
    assert_eq!((frame.get("Y").unwrap().data[31], frame.get("depth.Y").unwrap().data[31]), (1.0, 2.0));
    let both = [part("left", 1.0, (8, 4)), part("right", 2.0, (8, 4))].map(|mut part| {
        part.channel_data.list[0].name = "direct.R".into();
        part
    });
    let frame = decode(&image(both.into())).unwrap();
    assert_eq!((frame.get("direct.R").unwrap().data[0], frame.get("right.direct.R").unwrap().data[0]), (1.0, 2.0));
    let fault = decode(&image(vec![part("first", 1.0, (8, 4)), part("small", 2.0, (4, 4))])).unwrap_err();
    assert!(fault.contains("parts of different sizes, 8 × 4 and 4 × 4"), "{fault}");
}

#[test]
fn truncated_files_are_faults() {
    let bytes = bytes_of(&sample());
    assert!(bytes.len() > 50 * 997, "{} bytes are too few to cut", bytes.len());
    for cut in (0..bytes.len()).step_by(997).chain(bytes.len() - 3..bytes.len()).chain(0..600) {
        assert!(decode(&bytes[..cut]).is_err(), "cut at {cut} of {}", bytes.len());
    }
}

#[test]
fn damaged_files_are_faults_or_frames() {
    let encoding =
        |compression| Encoding { compression, blocks: Blocks::Tiles(Vec2(16, 16)), line_order: LineOrder::Unspecified };
    let samples = || FlatSamples::F32((0..40 * 40).map(|i| (i as f32).sin()).collect());
    let mut files = vec![bytes_of(&sample())];
    for compression in [Compression::PIZ, Compression::B44, Compression::PXR24, Compression::RLE] {
        files.push(encoded(Image::from_layer(foreign("x", (40, 40), encoding(compression), samples()))));
    }
    let mut values = Values(2);
    for file in files {
        // Half of the damage goes to the header and the offsets, where it hurts most.
        for round in 0..1500 {
            let mut damaged = file.clone();
            for _ in 0..1 + round % 4 {
                let reach = if round % 2 == 0 { damaged.len().min(700) } else { damaged.len() };
                let at = values.next() as usize % reach;
                damaged[at] = values.next() as u8;
            }
            if let Ok(frame) = decode(&damaged) {
                assert!(frame.channels.iter().all(|channel| channel.data.len() == frame.width * frame.height));
            }
        }
    }
}

#[test]
fn a_header_that_claims_too_much_is_not_believed() {
    let frame = sample();
    let mut bytes = bytes_of(&frame);
    // The data window's upper corner, i32 x and y after two zeros, in the attribute `dataWindow` of type `box2i`.
    let at = bytes.windows(16).position(|window| window == b"dataWindow\0box2i").unwrap() + 17 + 4 + 8;
    let mut claim = |x: i32, y: i32| {
        bytes[at..at + 4].copy_from_slice(&x.to_le_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&y.to_le_bytes());
        decode(&bytes)
    };
    assert!(claim(66, 44).is_ok(), "this is the true size");
    // 43 GB of f32 from as many rows, hence chunks, as the file has.
    let fault = claim((1 << 25) - 1, 44).unwrap_err();
    assert!(fault.contains("claims 33554432 × 45 pixels, which its"), "{fault}");
    // More rows than chunks.
    assert!(claim(66, (1 << 29) - 1).is_err());
}

#[test]
fn offsets_that_point_at_one_chunk_are_noticed() {
    let mut frame = Frame::new(4, 64);
    frame.push("Y", (0..256).map(|i| i as f32).collect());
    let bytes = bytes_of(&frame);
    // The table of 4 offsets is the only place where four increasing u64 start right behind the header.
    let first = (0..bytes.len() - 8)
        .find(|&at| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) == at as u64 + 32)
        .unwrap();
    for second in [[0_u8; 8], bytes[first..first + 8].try_into().unwrap()] {
        let mut damaged = bytes.clone();
        damaged[first + 8..first + 16].copy_from_slice(&second);
        assert!(decode(&damaged).is_err());
    }
}

#[test]
fn what_is_no_file_is_a_fault_with_its_place() {
    let directory = tempfile::tempdir().unwrap();
    let text = directory.path().join("text.exr");
    std::fs::write(&text, "no picture").unwrap();
    for path in [directory.path(), &directory.path().join("absent.exr"), &text] {
        let fault = read_exr(path).unwrap_err().to_string();
        assert!(fault.starts_with(&path.display().to_string()), "{fault}");
    }
}
