//! How many paths there are, and the guide of photons that part: for the light that connection leaves.

use super::photons::pixel_m;
use super::{LAST, Look, Looks, SEED, forward_paths};
use crate::{Choice, plan};
use eyebox_base::ids::GroupId;
use eyebox_check::check;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::manifold::receiver::Receivers;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::photon::PhotonMapper;
use eyebox_estimate::photon::visible_receivers::VisibleReceivers;
use eyebox_film::guide::{Even, Guide, Point, Sample};
use eyebox_film::plan::Estimator;
use eyebox_import::{ImportOptions, import};
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};
use std::path::Path;
use std::sync::Arc;

/// Of the diffuse HUD connection leaves 10⁻⁴, mostly ghosts. What a photon brings of that has less than half the variance that it
/// has with a guide for all light of the face, learned from half as many paths as the pilot's; and its mean is the same.
#[test]
fn photons_that_part_start_where_light_is_left() {
    const PATHS: u64 = 1 << 12;
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples/hud-diffuse/hud.optics.toml");
    let scene = import(&path, &ImportOptions::default()).unwrap().scene;
    let (checked, world) = (check(&scene).unwrap(), &World::freeze(&scene).unwrap());
    let (plan, groups) = (plan(&checked, world, Choice::Auto), scene.groups.len());
    assert!(plan.photons_part);
    let seen = VisibleReceivers::look(world, pixel_m(world, scene.eye.resolution), &|| false);
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let connected = Arc::new(Receivers::coarse(world, &optics, &plan.screens));
    let nothing = Arc::new(Receivers::new(world, &optics, &[]));
    let with = |guide: &Guide, paths: u64, screens: &Arc<Receivers<Mono>>| {
        let route = Ownership::new(&plan, groups, Estimator::Photon);
        PhotonMapper::new(world, route, groups, paths, Some(guide), plan.photon_radii_m, screens.clone(), SEED)
    };
    let of_rest = plan.photon_guide.as_ref().unwrap();
    let of_all = {
        let wide = with(of_rest, 2 * PATHS, &nothing);
        let light = |sample: Sample| Sample { weight: sample.weight / wide.density(sample.lamp, &sample.x), ..sample };
        let found: Vec<Sample> = wide.probe(LAST, &seen, &|| false).into_iter().map(light).collect();
        Guide::learn(wide.flux(), &found, Even::MANY)
    };
    // Mean and variance of what paths bring, and the variance without the brightest three: one in ten thousand is a main path
    // that no table has, and brings more than all others.
    let brought = |guide: &Guide| {
        let landed = with(guide, PATHS, &connected).parting(true).landings(LAST + 1, &|| false);
        let of_path = |landings: &[_]| landings.iter().map(|landing| seen.shown(world, landing).1).sum::<f64>();
        let mut rests: Vec<f64> = landed.iter().map(|path| of_path(&path.landings) * PATHS as f64).collect();
        rests.sort_by(f64::total_cmp);
        let moments = |rests: &[f64]| {
            let mean = rests.iter().sum::<f64>() / PATHS as f64;
            (mean, rests.iter().map(|rest| rest * rest).sum::<f64>() / PATHS as f64 - mean * mean)
        };
        let (mean, variance) = moments(&rests);
        (mean, variance, moments(&rests[..rests.len().saturating_sub(3)]).1)
    };
    let ((all, of_all, spread_of_all), (rest, of_rest, spread_of_rest)) = (brought(&of_all), brought(of_rest));
    let sigma = ((of_all + of_rest) / PATHS as f64).sqrt();
    assert!((all - rest).abs() < 4.0 * sigma, "{all} and {rest} by {sigma}");
    assert!(spread_of_rest < 0.5 * spread_of_all, "{spread_of_rest} and {spread_of_all} about {rest}");
}

/// Paths of nobody, with one lamp.
struct Nobody;

impl Look for Nobody {
    fn probe(&self, _: u64, _: &ShouldStop<'_>) -> Vec<Sample> {
        (0..100).map(|k| Sample { lamp: 0, x: [k as f64 / 100.0; 4], weight: 1.0 }).collect()
    }
    fn density(&self, _: usize, _: &Point) -> f64 {
        1.0
    }
    fn flux(&self) -> &[f64] {
        &[1.0]
    }
    fn group_of(&self, _: usize) -> GroupId {
        GroupId::from_index(0)
    }
}

/// One path that brings more than all others, or a handful, say nothing of where light is left.
#[test]
fn little_is_not_learned_from() {
    let mut looks = Looks::new(1);
    looks.take(Nobody, 100, &|| false);
    let rest = |count: usize, heaviest: f64| -> Vec<Sample> {
        let weight = |k: usize| if k == 0 { heaviest } else { 1.0 };
        (0..count).map(|k| Sample { lamp: 0, x: [0.5; 4], weight: weight(k) }).collect()
    };
    let learned =
        [(0, 1.0), (10, 1.0), (200, 1e4), (200, 1.0)].map(|(n, heaviest)| looks.learn_rest(&rest(n, heaviest)));
    assert_eq!(learned.map(|guide| guide.is_some()), [false, false, false, true]);
}

#[test]
fn more_light_has_more_paths() {
    let of = |share: f64| forward_paths(share, 64_800);
    assert_eq!([0.0, 1e-3, 0.25, 1.0].map(of), [16_200, 16_200, 129_600, 259_200]);
    assert_eq!([0.0, 0.02, 0.04].map(|share| forward_paths(share, 100)), [128, 128, 4096]);
}
