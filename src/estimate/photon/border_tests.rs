//! Photons where cells that connection leaves to them border on connected ones.

use super::{PhotonMapper, radii_of_pass};
use crate::base::rng::Stream;
use crate::check::check;
use crate::estimate::manifold::screens::{Claim, Screens};
use crate::estimate::photon_map::Photon;
use crate::estimate::route::Route;
use crate::film::plan::Estimator;
use crate::import::{ImportOptions, import};
use crate::plan::{Choice, plan};
use crate::world::World;
use crate::world::geometry::Site;
use crate::world::mode::{Mode, Mono};
use std::path::Path;
use std::sync::Arc;

/// About photons that landed in connected cells near a border: where many others of their kind land they are gathered if the
/// cell is not connected, and where none does they are not, though their kernels reach there. What lands where says that.
#[test]
fn photons_are_gathered_beyond_a_border_where_their_light_goes_on() {
    const PATHS: u64 = 1 << 19;
    const MANY: usize = 8;
    /// Of the kernels' radius.
    const NEAR: f64 = 0.25;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/peers/a1/a1.optics.toml");
    let scene = import(&path, &ImportOptions::default()).unwrap().scene;
    let (checked, world) = (check(&scene).unwrap(), &World::freeze(&scene).unwrap());
    let plan = plan(&checked, world, Choice::Only(Estimator::Manifold));
    let optics = Mono::<f64>::optics(world, 0, 0);
    let screens = Arc::new(Screens::new(world, &optics, &plan.screens));
    let route = Route::new(&plan, scene.groups.len(), Estimator::Photon);
    let mapper =
        PhotonMapper::new(world, route, scene.groups.len(), PATHS, None, plan.photon_radii_m, screens.clone(), 1);
    let reach = radii_of_pass(plan.photon_radii_m, 0).caustic;
    let (photons, _) = mapper.emit(mapper.shots(Stream::PhotonEmission, 0), &optics, (&screens, reach));
    let bordering = |photon: &&Photon<Mono>| matches!(photon.claim, Claim::Bordering { here: true, .. });
    let bordering: Vec<&Photon<Mono>> = photons.iter().filter(bordering).collect();
    // Of places in the dark, left to photons, and connected: how many there are, and at how many the photon is gathered.
    let [mut dark, mut left, mut connected] = [[0; 2]; 3];
    for photon in bordering.iter().step_by(bordering.len() / 1000) {
        let like: Vec<_> = photons.iter().filter(|other| is_like(photon, other)).collect();
        let [a, b] = [1, 2].map(|k| like[like.len() * k / 3].position - like[0].position);
        let across = a.normalize();
        let up = a.cross(b).normalize().cross(across);
        for aside in [across, -across, up, -up] {
            let at = photon.position + 0.7 * reach * aside;
            let near = || like.iter().filter(|other| other.position.distance(at) < NEAR * reach);
            let sum = match (near().count(), near().filter(|other| other.claim.here()).count()) {
                (0, _) => &mut dark,
                (MANY.., 0) => &mut left,
                (all @ MANY.., here) if here == all => &mut connected,
                _ => continue,
            };
            let site = Site { triangle: u32::MAX, ..photon.site };
            let has = screens.asked_at((world, &optics), (at, site)).has(photon.claim);
            *sum = [sum[0] + 1, sum[1] + i32::from(!has)];
        }
    }
    let told = [dark, left, connected].iter().all(|[all, _]| *all > 50);
    assert!(told && left[1] == left[0] && connected[1] == 0, "{dark:?} {left:?} {connected:?}");
    // The middle of the lamp stands for all of it: light ends some of its width later.
    assert!(4 * dark[1] < dark[0], "{dark:?}");
}

/// Whether two came over like faces to the same one.
fn is_like(one: &Photon<Mono>, other: &Photon<Mono>) -> bool {
    one.trail == other.trail && other.site.is_on_face_of(one.site)
}
