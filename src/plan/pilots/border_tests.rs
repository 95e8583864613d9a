//! Photons where cells that connection leaves to them border on connected ones.

use crate::{Choice, plan};
use eyebox_check::check;
use eyebox_estimate::manifold::receiver::{Claim, Receivers};
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::photon::{PhotonMapper, radii_of_pass};
use eyebox_estimate::photon_map::Photon;
use eyebox_film::plan::Estimator;
use eyebox_import::{ImportOptions, import};
use eyebox_scene::{Eye, Finish, Group, Scene, Shape};
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::geometry::scenes;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use glam::{DAffine3, DVec3};
use std::path::Path;
use std::sync::Arc;

const PATHS: u64 = 1 << 18;

/// Connected as far as it goes, with the photons of a pass that are gathered within `reach`, m.
fn emit(
    scene: &Scene,
    world: &World,
    optics: &Optics<Mono>,
    reach: Option<f64>,
) -> (Arc<Receivers<Mono>>, f64, Vec<Photon<Mono>>) {
    let plan = plan(&check(scene).unwrap(), world, Choice::Only(Estimator::Manifold));
    let screens = Arc::new(Receivers::new(world, optics, &plan.screens));
    let (route, groups) = (Ownership::new(&plan, scene.groups.len(), Estimator::Photon), scene.groups.len());
    let reach = reach.unwrap_or(radii_of_pass(plan.photon_radii_m, 0).caustic);
    let mapper = PhotonMapper::new(world, route, groups, PATHS, None, plan.photon_radii_m, screens.clone(), 1);
    let (photons, _) = mapper.emit((0, optics), (&screens, reach));
    (screens, reach, photons)
}

/// About photons near a border: where many others of their kind land they are gathered if the cell is not connected, wherever
/// they landed themselves, and not at all if it is. What lands where says that.
#[test]
fn photons_are_gathered_on_one_side_of_a_border() {
    const MANY: usize = 8;
    /// Of the kernels' radius.
    const NEAR: f64 = 0.25;
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples/peers/a1/a1.optics.toml");
    let scene = import(&path, &ImportOptions::default()).unwrap().scene;
    let world = &World::freeze(&scene).unwrap();
    let optics = Mono::<f64>::optics(world, 0, 0);
    let (screens, reach, photons) = emit(&scene, world, &optics, None);
    // Of places left to photons and connected ones: how many there are, and at how many the photon is gathered.
    let count = |landed: bool| {
        let [mut left, mut connected] = [[0; 2]; 2];
        let bordering = bordering(&photons, landed);
        for photon in bordering.iter().step_by((bordering.len() / 1000).max(1)) {
            let like: Vec<_> = photons.iter().filter(|other| is_like(photon, other)).collect();
            let [a, b] = [1, 2].map(|k| like[like.len() * k / 3].position - like[0].position);
            let across = a.normalize();
            let up = a.cross(b).normalize().cross(across);
            for aside in [across, -across, up, -up] {
                let at = photon.position + 0.7 * reach * aside;
                let near = || like.iter().filter(|other| other.position.distance(at) < NEAR * reach);
                let sum = match (near().count(), near().filter(|other| other.claim.here()).count()) {
                    (MANY.., 0) => &mut left,
                    (all @ MANY.., here) if here == all => &mut connected,
                    _ => continue,
                };
                let site = Site { triangle: u32::MAX, ..photon.site };
                let leaves_out = screens.asked_at((world, &optics), (at, site), reach).leaves_out(photon.claim);
                *sum = [sum[0] + 1, sum[1] + i32::from(!leaves_out)];
            }
        }
        [left, connected]
    };
    for landed in [true, false] {
        let [left, connected] = count(landed);
        assert!(left[0] > 50 && left[1] == left[0], "{left:?}");
        assert!(connected[0] > 50 && connected[1] == 0, "{connected:?}");
    }
}

/// m
const HALF_WALL: f64 = 0.04;
/// Unit, across the edge.
const ACROSS: [f64; 2] = [0.8, 0.6];

/// A pane lights a wall as far as its edge lets it.
fn half_a_pane() -> Scene {
    let mm = DAffine3::from_scale(DVec3::splat(1e-3));
    let pane = scenes::cuboid(DVec3::new(0.0, -100.0, 50.0), DVec3::new(100.0, 100.0, 52.0));
    let turn = DAffine3::from_rotation_z(f64::atan2(ACROSS[1], ACROSS[0]));
    let mut scene = scenes::scene(vec![pane], vec![scenes::part(0, &vec![Shape::Mesh; 6], turn * mm)]);
    scenes::add_square(&mut scene, (0.2, 0.0, DVec3::Z), Finish::Absorber, mm);
    let matt = Finish::Lambert { reflectance: 0.8, transmittance: 0.0 };
    scenes::add_square(&mut scene, (1e3 * HALF_WALL, 100.0, DVec3::NEG_Z), matt, mm);
    scene.parts[1].faces[0].emitter = Some(scenes::emitter());
    scene.groups = vec![Group { name: "light".to_owned() }];
    scene.eye = Eye {
        position: DVec3::new(0.0, 0.15, 0.06),
        look: DVec3::new(0.0, -0.96, 0.28),
        up: DVec3::new(0.0, 0.28, 0.96),
        pupil_diameter_m: 2e-3,
        adapts: false,
        limits: eyebox_scene::BinocularLimits::default(),
        fov_deg: 60.0,
        resolution: [64, 64],
        ..scene.eye
    };
    scene
}

/// What landed on connected cells is not blurred to where light over the same faces ends, though cells there are not connected.
#[test]
fn light_is_not_blurred_beyond_its_own_edge() {
    const REACH: f64 = 2e-3;
    let scene = half_a_pane();
    let world = &World::freeze(&scene).unwrap();
    let optics = Mono::<f64>::optics(world, 0, 0);
    let (screens, reach, photons) = emit(&scene, world, &optics, Some(REACH));
    let [edge, wall] = [0, 2].map(|part| world.geometry.part_to_world(part).translation);
    let across = DVec3::new(ACROSS[0], ACROSS[1], 0.0);
    // Of places beyond the edge and before it that are not connected: how many there are, and at how many photons are
    // gathered.
    let [mut dark, mut light] = [[0; 2]; 2];
    for photon in bordering(&photons, true) {
        let Claim::Bordering { branches, .. } = photon.claim else { continue };
        // What went in by the pane's edge goes another way.
        if photon.dir.dot(across).abs() > 0.1 {
            continue;
        }
        for aside in [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y] {
            let at = photon.position + 0.7 * reach * aside;
            let site = Site { triangle: u32::MAX, ..photon.site };
            let mut asked = screens.asked_at((world, &optics), (at, site), reach);
            let beyond = across.dot(edge - at);
            // The lamp's half diagonal is 0.3 mm.
            let sum = if beyond > 4e-4 {
                &mut dark
            } else if beyond < -4e-4 && (at - wall).truncate().abs().max_element() < HALF_WALL {
                &mut light
            } else {
                continue;
            };
            if !asked.leaves_out(Claim::Bordering { branches, here: false }) {
                *sum = [sum[0] + 1, sum[1] + i32::from(!asked.leaves_out(photon.claim))];
            }
        }
    }
    assert!(dark[0] > 50 && dark[1] == 0, "{dark:?}");
    assert!(light[0] > 50 && light[1] == light[0], "{light:?}");
}

/// Photons near a border, by whether they landed on a connected cell.
fn bordering(photons: &[Photon<Mono>], landed: bool) -> Vec<&Photon<Mono>> {
    let of = |photon: &&Photon<Mono>| matches!(photon.claim, Claim::Bordering { here, .. } if here == landed);
    photons.iter().filter(of).collect()
}

/// Whether two came over like faces to the same one.
fn is_like(one: &Photon<Mono>, other: &Photon<Mono>) -> bool {
    one.trail == other.trail && other.site.is_on_face_of(one.site)
}
