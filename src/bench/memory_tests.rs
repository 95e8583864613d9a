//! How much memory a pixel of a picture takes, in the samples: one light group beside the sky.

use eyebox_check::check;
use eyebox_estimate::data::data_layers;
use eyebox_estimate::picture::{add_data_layers, picture};
use eyebox_estimate::run::{Films, Limits, run};
use eyebox_film::frame::{Frame, Samples};
use eyebox_film::serial::Table;
use eyebox_import::{ImportOptions, import};
use eyebox_plan::{Choice, plan};
use eyebox_world::World;
use std::path::Path;

/// Bytes per pixel that a picture may take, so that one of 3840 × 2160 fits into 3 GiB with the scene.
const MOST: usize = 300;
/// Of any picture's sums that tell what evenness saves, bytes: more pixels are not asked.
const TURNS: usize = 1 << 23;

/// Bytes of a frame's values, those that channels share counted once.
fn bytes(frame: &Frame) -> usize {
    let mut seen: Vec<&Samples> = Vec::new();
    for channel in &frame.channels {
        if !seen.iter().any(|other| other.is_shared_with(&channel.data)) {
            seen.push(&channel.data);
        }
    }
    seen.iter().map(|data| size_of_val(data.as_slice())).sum()
}

/// Bytes per pixel of the sums, by films and tables, but for those that do not grow with the picture.
fn of_sums(films: &Films) -> Vec<(&'static str, usize)> {
    let all = films.films.iter().flat_map(|(_, film, _)| {
        let pixels = film.width * film.height;
        film.tables().into_iter().map(move |table| (table.name, table.bytes() / pixels))
    });
    all.filter(|(name, _)| *name != "turns").collect()
}

/// While paths are traced, while light is made into layers, and while the data layers are made after the films are gone.
#[test]
fn a_pixel_takes_three_hundred_bytes() {
    for name in ["direct", "diffuse"] {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
            .join(format!("samples/hud-{name}/hud.optics.toml"));
        let mut scene = import(&path, &ImportOptions::default()).expect("the sample is sound").scene;
        let size @ [width, height] = [96, 72];
        scene.eye.resolution = size;
        let checked = check(&scene).expect("the scene is sound");
        let world = World::freeze(&scene).expect("the scene can be traced");
        let plan = plan(&checked, &world, Choice::Auto);
        let limits = Limits { passes: Some(8), ..Limits::default() };
        let mut outcome = run(&world, &plan, scene.groups.len(), size, 1, &limits, &mut ());
        let sum = |tables: &[(&str, usize)]| tables.iter().map(|(_, bytes)| bytes).sum::<usize>();
        let traced = of_sums(&outcome.films);
        let before = picture(&scene, &plan, &outcome, Default::default()).expect("a sound picture").frame;
        outcome.films.condense();
        let condensed = of_sums(&outcome.films);
        let variances = outcome.films.films.len() * size_of::<f64>();
        let mut frame = picture(&scene, &plan, &outcome, Default::default()).expect("a sound picture").frame;
        assert_eq!(frame, before, "{name}: what is given back is not needed");
        let light = bytes(&frame) / (width * height);
        add_data_layers(&mut frame, data_layers(&world, width, height));
        let all = bytes(&frame) / (width * height);
        eprintln!("hud-{name}: {traced:?}, then {condensed:?} + {variances} + {light} of light; {all} of all layers");
        let [traced, condensed] = [sum(&traced), sum(&condensed) + variances + light];
        assert!(traced.max(condensed).max(all) <= MOST, "{name}: {traced}, {condensed}, {all}");
        // Two channels and more of each grey layer are the first one's memory.
        assert!(all * 5 < frame.channels.len() * size_of::<f32>() * 3, "{name}: {all}");
    }
}

/// Sums that only many pixels tell are kept for as many as tell enough.
#[test]
fn turns_do_not_grow_with_the_picture() {
    use eyebox_base::ids::GroupId;
    use eyebox_film::accumulate::{Components, Film, PlaneKey, Sampling};
    use eyebox_film::layer::Layer;
    let key = PlaneKey { layer: Layer::Direct, group: GroupId(0), takes: 0 };
    for [width, height] in [[1024, 768], [3840, 2160], [2160, 3840]] {
        let film = Film::new(width, height, vec![key], Components::Luminance, Sampling::PerPass);
        let of = |turns: bool| -> usize {
            film.tables().iter().filter(|table| (table.name == "turns") == turns).map(Table::bytes).sum()
        };
        assert!(of(true) <= TURNS && of(true) > TURNS / 4, "{}", of(true));
        assert!(of(false) <= 2 * width * height, "what is dark takes next to nothing: {}", of(false));
    }
}
