//! Cryptomatte layers: coverages of known edges, identities of the manifest, roles of the sample, the same bits for any
//! number of threads, and that the attributes survive a file.

use crate::common::*;
use eyebox::check::check;
use eyebox::estimate::cryptomatte::{add, wanted};
use eyebox::estimate::data::data_layers;
use eyebox::film::cryptomatte::{Matte, RANKS, identity};
use eyebox::film::frame::Frame;
use eyebox::import::{ImportOptions, import};
use eyebox::output::exr::{read_exr, write_exr};
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

fn mattes(scene: &Scene, wanted: &[Matte]) -> Frame {
    check(scene).expect("a sound scene");
    let world = World::freeze(scene).expect("it can be traced");
    let [width, height] = scene.eye.resolution;
    let mut frame = Frame::new(width, height);
    add(&mut frame, scene, &world, wanted);
    frame
}

/// (identity, coverage) of the ranks of a pixel.
fn ranks(frame: &Frame, matte: Matte, pixel: usize) -> Vec<(u32, f32)> {
    let value = |rank: usize, second: bool| {
        let component = [["r", "g"], ["b", "a"]][rank % 2][usize::from(second)];
        let name = format!("{}{:02}.{component}", matte.name(), rank / 2);
        frame.get(&name).unwrap_or_else(|| panic!("no channel {name}")).data[pixel]
    };
    (0..RANKS).map(|rank| (value(rank, false).to_bits(), value(rank, true))).collect()
}

fn sample() -> Scene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.optics.toml");
    let mut scene = import(Path::new(path), &ImportOptions::default()).expect("the sample").scene;
    scene.eye.resolution = [48, 24];
    scene
}

/// A black card whose edge goes through the middle of a column of pixels, before a window, before a wall.
#[test]
fn coverages_of_an_edge() {
    let mut s = scene();
    s.eye.pupil_diameter_m = 0.0;
    let pixel = 2.0 * 10f64.to_radians().tan() / 8.0;
    let square = |half: f64| mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    // Right of the card's edge, half a pixel left of the middle, the window shows the wall.
    add_part(
        &mut s,
        "card",
        square(1.0),
        DVec3::new(-1.0 - 0.5 * pixel, 0.0, -1.0),
        None,
        vec![face(Finish::Absorber)],
    );
    let sides =
        [Finish::Absorber, Finish::Absorber, Finish::Absorber, Finish::Absorber, Finish::Polished, Finish::Polished];
    let window = mesh(&cuboid(DVec3::new(1.0, 1.0, 0.01)));
    add_part(&mut s, "window", window, DVec3::NEG_Z * 2.0, Some(1.5), sides.map(face).to_vec());
    let wall = face(Finish::Lambert { reflectance: 0.5, transmittance: 0.0 });
    add_part(&mut s, "wall", square(0.14), DVec3::NEG_Z * 3.0, None, vec![wall]);
    let frame = mattes(&s, &Matte::ALL);
    let nothing = (0, 0.0);
    let is = |matte: Matte, x: usize, want: &[(&str, f32)]| {
        let mut want: Vec<(u32, f32)> =
            want.iter().map(|(name, share)| (if name.is_empty() { 0 } else { identity(name) }, *share)).collect();
        want.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        want.resize(RANKS, nothing);
        assert_eq!(ranks(&frame, matte, 4 * 8 + x), want, "{matte:?} in column {x}");
    };
    is(Matte::Part, 2, &[("card", 1.0)]);
    is(Matte::Part, 3, &[("card", 0.5), ("window", 0.5)]);
    is(Matte::Part, 7, &[("window", 1.0)]);
    is(Matte::Role, 3, &[("absorber", 0.5), ("plate", 0.5)]);
    is(Matte::RoleSeen, 3, &[("absorber", 0.5), ("screen", 0.5)]);
    is(Matte::PartSeen, 4, &[("wall", 1.0)]);
    is(Matte::PartSeen, 7, &[("", 1.0)]);
}

#[test]
fn the_sample_by_part_and_role() {
    let scene = sample();
    let frame = mattes(&scene, &Matte::ALL);
    let world = World::freeze(&scene).expect("it can be traced");
    let data = data_layers(&world, 48, 24);
    for matte in Matte::ALL {
        let key = format!("{:08x}", identity(matte.name()));
        let at = |what: &str| frame.text(&format!("cryptomatte/{}/{what}", &key[..7])).expect("the attribute");
        assert_eq!([at("name"), at("hash"), at("conversion")], [matte.name(), "MurmurHash3_32", "uint32_to_float32"]);
        let manifest: BTreeMap<String, String> = serde_json::from_str(at("manifest")).expect("JSON");
        let names: BTreeMap<u32, &str> =
            manifest.iter().map(|(name, hex)| (u32::from_str_radix(hex, 16).expect("hex"), name.as_str())).collect();
        let mut shown = BTreeSet::new();
        for (pixel, seen) in data.seen.part.iter().enumerate() {
            let ranks = ranks(&frame, matte, pixel);
            assert_eq!(ranks.iter().map(|(_, share)| share).sum::<f32>(), 1.0, "{matte:?} at {pixel}");
            assert!(ranks.windows(2).all(|two| two[0].1 >= two[1].1), "{matte:?} at {pixel}");
            for (identity, _) in ranks.iter().filter(|(identity, share)| *identity != 0 && *share > 0.0) {
                shown.insert(*names.get(identity).unwrap_or_else(|| panic!("{identity:08x} is not in the manifest")));
            }
            // All looks at one part: so does the one through the middle.
            if let (Matte::PartSeen, (id, 1.0)) = (matte, ranks[0]) {
                let part = (*seen as u32).checked_sub(1).map(|part| scene.parts[part as usize].path.as_str());
                assert_eq!(part, names.get(&id).copied(), "at {pixel}");
            }
        }
        match matte {
            Matte::Part => assert!(shown.iter().any(|name| name.ends_with("COMBINER_PLATE_NBK7")), "{shown:?}"),
            Matte::Role => assert!(shown.contains("combiner"), "{shown:?}"),
            Matte::PartSeen => assert!(shown.iter().all(|name| !name.ends_with("COMBINER_PLATE_NBK7")), "{shown:?}"),
            Matte::RoleSeen => assert!(!shown.contains("lens") && !shown.contains("slide"), "{shown:?}"),
            Matte::Material => {
                let combiner = scene.parts.iter().find(|part| part.name == "COMBINER_PLATE_NBK7").expect("it is there");
                assert_eq!(combiner.materials.len(), combiner.faces.len());
                assert!(combiner.materials.iter().any(|name| shown.contains(name.as_str())), "{shown:?}");
            }
            Matte::MaterialSeen => {
                let all: BTreeSet<&str> = scene.parts.iter().flat_map(|part| &part.materials).map(|m| &**m).collect();
                assert!(shown.iter().all(|name| all.contains(name)), "{shown:?}");
            }
        }
    }
    let roles = eyebox::world::role::roles(&scene, &world);
    let of = |part: &str| -> BTreeSet<&str> {
        let index = scene.parts.iter().position(|p| p.name == part).unwrap_or_else(|| panic!("no part {part}"));
        roles[index].iter().flatten().map(|role| role.name()).collect()
    };
    assert_eq!(of("COMBINER_PLATE_NBK7"), BTreeSet::from(["absorber", "combiner"]));
    assert_eq!(of("LENS_02_NBK7"), BTreeSet::from(["absorber", "lens"]));
    assert_eq!(of("LCD_ACTIVE_AREA"), BTreeSet::from(["slide"]));
    assert_eq!(of("LED_DIE_5"), BTreeSet::from(["absorber", "lamp"]));
}

#[test]
fn any_number_of_threads_and_a_file_keep_the_bits() {
    let scene = sample();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| mattes(&scene, &[Matte::Part, Matte::RoleSeen]))
    };
    let frame = with(1);
    assert!(frame == with(5));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mattes.exr");
    write_exr(&path, &frame).expect("written");
    let bytes = std::fs::read(&path).expect("bytes");
    let own = b"cryptomatte/3201c4f/conversion\0string\0";
    assert!(bytes.windows(own.len()).any(|part| part == own), "the attribute's own name");
    let read = read_exr(&path).expect("read");
    let crypto = |frame: &Frame| -> Vec<_> {
        frame.meta.clone().into_iter().filter(|(key, _)| key.starts_with("cryptomatte/")).collect()
    };
    assert_eq!(crypto(&read), crypto(&frame));
    assert_eq!(crypto(&read).len(), 8);
    for channel in &frame.channels {
        let bits = |data: &[f32]| data.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read.get(&channel.name).expect("the channel").data), bits(&channel.data));
    }
}

#[test]
fn asked_for_by_name_or_all() {
    let names = ["direct".to_owned(), "CryptoRoleSeen".to_owned()];
    assert_eq!(wanted(false, names.iter()), [Matte::RoleSeen]);
    assert_eq!(wanted(true, [].iter()), Matte::ALL);
    assert!(wanted(false, names[..1].iter()).is_empty());
}
