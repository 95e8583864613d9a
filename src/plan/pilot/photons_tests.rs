//! The guide of photons that part: for the light that connection leaves.

use super::photons::pixel_m;
use super::{LAST, SEED};
use crate::check::check;
use crate::estimate::manifold::screens::Screens;
use crate::estimate::photon::PhotonMapper;
use crate::estimate::route::Route;
use crate::estimate::seen::Seen;
use crate::film::guide::{Even, Guide, Sample};
use crate::film::plan::Estimator;
use crate::import::{ImportOptions, import};
use crate::plan::{Choice, plan};
use crate::world::World;
use crate::world::mode::{Mode, Mono};
use std::path::Path;
use std::sync::Arc;

/// Of the diffuse HUD connection leaves 10⁻⁴, mostly ghosts. What a photon brings of that has less than half the variance that it
/// has with a guide for all light of the face, from as many paths as the pilot's; and its mean is the same.
#[test]
fn photons_that_part_start_where_light_is_left() {
    const PATHS: u64 = 1 << 12;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-diffuse/hud.optics.toml");
    let scene = import(&path, &ImportOptions::default()).unwrap().scene;
    let (checked, world) = (check(&scene).unwrap(), &World::freeze(&scene).unwrap());
    let (plan, groups) = (plan(&checked, world, Choice::Auto), scene.groups.len());
    assert!(plan.photons_part);
    let seen = Seen::look(world, pixel_m(world, scene.eye.resolution), &|| false);
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let connected = Arc::new(Screens::coarse(world, &optics, &plan.screens));
    let nothing = Arc::new(Screens::new(world, &optics, &[]));
    let with = |guide: &Guide, paths: u64, screens: &Arc<Screens<Mono>>| {
        let route = Route::new(&plan, groups, Estimator::Photon);
        PhotonMapper::new(world, route, groups, paths, Some(guide), plan.photon_radii_m, screens.clone(), SEED)
    };
    let of_rest = plan.photon_guide.as_ref().unwrap();
    let of_all = {
        let wide = with(of_rest, 2 * PATHS, &nothing);
        let light = |sample: Sample| Sample { weight: sample.weight / wide.density(sample.lamp, &sample.x), ..sample };
        let found: Vec<Sample> = wide.probe(LAST, &seen, &|| false).into_iter().map(light).collect();
        Guide::learn(wide.flux(), &found, Even::MANY)
    };
    // Mean and variance of what paths bring. One in ten thousand is a main path that no table has, and brings more than all
    // others: those are left out on both sides.
    let brought = |guide: &Guide| {
        let landed = with(guide, PATHS, &connected).parting(true).landings(LAST + 1, &|| false);
        let of_path = |landings: &[_]| landings.iter().map(|landing| seen.shown(world, landing).1).sum::<f64>();
        let mut rests: Vec<f64> = landed.iter().map(|path| of_path(&path.landings) * PATHS as f64).collect();
        rests.sort_by(f64::total_cmp);
        rests.truncate(rests.len() - 3);
        let mean = rests.iter().sum::<f64>() / PATHS as f64;
        let squares = rests.iter().map(|rest| rest * rest).sum::<f64>() / PATHS as f64;
        (mean, squares - mean * mean)
    };
    let ((all, spread_of_all), (rest, spread_of_rest)) = (brought(&of_all), brought(of_rest));
    let sigma = ((spread_of_all + spread_of_rest) / PATHS as f64).sqrt();
    assert!((all - rest).abs() < 5.0 * sigma, "{all} and {rest} by {sigma}");
    assert!(spread_of_rest < 0.5 * spread_of_all, "{spread_of_rest} and {spread_of_all} about {rest}");
}
