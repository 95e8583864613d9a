//! Tables of where rays from the eye land: as far as a display is seen, not only where it is seen all about a place.

use super::curve::race::Ready;
use eyebox_base::stats::{Moments, sidak_z};
use eyebox_base::students_t::as_normal;
use eyebox_estimate::manifold::eye_table::EyeTable;
use eyebox_estimate::manifold::film_grid::FilmGrid;
use eyebox_estimate::manifold::receiver::Receivers;
use eyebox_estimate::manifold::seeds::bands::Bands;
use eyebox_estimate::manifold::vision::Manifold;
use eyebox_estimate::ownership::Ownership;
use eyebox_film::accumulate::{Film, Sampling};
use eyebox_film::plan::Estimator;
use eyebox_import::{ImportOptions, import};
use eyebox_plan::{Choice, plan};
use eyebox_world::mode::{Mode, Mono, components};
use std::path::Path;
use std::sync::Arc;

const SIZE: [usize; 2] = [160, 80];
/// Few, for Student's t: a pass of all rays takes a second.
const PASSES: u64 = 16;
/// Blocks along both sides.
const BLOCKS: [usize; 2] = [8, 4];

/// The diffuse HUD's picture has corners that its last lens darkens. With tables few rays are followed, there too, and block by
/// block the picture is that of all rays followed: both take the same ones, so what is left of the difference is small but at the
/// slide's edges, which tables cut by the pixel's footprint and followed rays sample.
#[test]
fn tables_reach_to_where_the_display_ends() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples/hud-diffuse/hud.optics.toml");
    let mut scene = import(&path, &ImportOptions::default()).unwrap().scene;
    scene.eye.resolution = SIZE;
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let world = &ready.world;
    let optics = Mono::<f64>::optics(world, 0, 0);
    let screens = Arc::new(Receivers::<Mono>::new(world, &optics, &plan.screens));
    let glances = FilmGrid::new(world).and_then(|over| EyeTable::new(world, &optics, &screens, over)).map(Arc::new);
    assert!(glances.is_some());
    let [width, height] = SIZE;
    let route = Ownership::new(&plan, ready.checked.scene().groups.len(), Estimator::Manifold);
    let manifold = |glances: Option<Arc<EyeTable<Mono>>>| {
        let none = Arc::new(Bands::default());
        Manifold::new(world, route.clone(), (none, None), (screens.clone(), glances), 1)
    };
    let pass = |manifold: &Manifold<'_, Mono>, pass: u64| {
        let mut film = Film::new(width, height, route.planes.clone(), components::<Mono>(), Sampling::PerPass);
        let ledger = manifold.run(&mut film, pass, 1);
        let mut blocks = vec![0.0; BLOCKS[0] * BLOCKS[1]];
        for pixel in 0..width * height {
            let (x, y) = (pixel % width * BLOCKS[0] / width, pixel / width * BLOCKS[1] / height);
            blocks[y * BLOCKS[0] + x] += (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
        }
        (blocks, ledger.paths as f64 / (2 * width * height) as f64)
    };
    let (all, read) = (manifold(None), manifold(glances));
    let mut off = vec![Moments::default(); BLOCKS[0] * BLOCKS[1]];
    let mut light = 0.0;
    for k in 0..PASSES {
        let ((all, every), (read, some)) = (pass(&all, k), pass(&read, k));
        // Without nodes aside of a cell's it was 0.42.
        assert!(every == 1.0 && some < 0.3, "{every} {some}");
        light += all.iter().sum::<f64>() / (PASSES * off.len() as u64) as f64;
        off.iter_mut().zip(all.iter().zip(&read)).for_each(|(off, (all, read))| off.add(read - all));
    }
    let limit = sidak_z(1e-4, off.len());
    for (k, off) in off.iter().enumerate() {
        let sigmas = as_normal(off.mean / off.stderr(), (PASSES - 1) as f64);
        assert!(sigmas.abs() < limit && off.stderr() < 0.01 * light, "block {k}: {off:?} of {light}");
    }
}
