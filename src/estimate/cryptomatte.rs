//! Cryptomatte layers of a scene: 16 fixed looks per pixel, the same for every pass, seed and shard.

use super::data::{End, go_straight, place};
use super::ledger::Ledger;
use crate::film::cryptomatte::{self, Matte, NOTHING, POINTS, Ranked, identity, rank};
use crate::film::frame::Frame;
use crate::scene::Scene;
use crate::world::World;
use crate::world::geometry::Site;
use crate::world::mode::{Mode, Mono};
use crate::world::role::{Role, roles};
use rayon::prelude::*;

/// The mattes to make: `all`, or those among the names of layers.
pub fn wanted<'n>(all: bool, layers: impl Iterator<Item = &'n String>) -> Vec<Matte> {
    let named: Vec<Matte> = layers.filter_map(|layer| Matte::of_layer(layer)).collect();
    Matte::ALL.into_iter().filter(|matte| all || named.contains(matte)).collect()
}

/// What the identities of faces are.
struct Identities {
    parts: Vec<u32>,
    /// Part, face.
    roles: Vec<Vec<Option<u32>>>,
}

impl Identities {
    fn new(scene: &Scene, world: &World) -> Self {
        let of_role = |role: Option<Role>| role.map(|role| identity(role.name()));
        let of_part = |faces: Vec<Option<Role>>| faces.into_iter().map(of_role).collect();
        Identities {
            parts: scene.parts.iter().map(|part| identity(&part.path)).collect(),
            roles: roles(scene, world).into_iter().map(of_part).collect(),
        }
    }

    fn of(&self, matte: Matte, site: Option<Site>) -> u32 {
        let Some(Site { part, face, .. }) = site else { return NOTHING };
        let found = if matte.by_role() {
            self.roles.get(part as usize).and_then(|faces| faces.get(face as usize).copied().flatten())
        } else {
            self.parts.get(part as usize).copied()
        };
        found.unwrap_or(NOTHING)
    }

    fn is_there(&self, site: Site) -> bool {
        self.of(Matte::Role, Some(site)) != NOTHING
    }
}

/// Adds the layers of `mattes` and their attributes. A part is called by its path, a role as [`Role::name`] says. The first
/// face of a look is the first that is there for light; behind specular faces a look goes on as the data layers do.
pub fn add(frame: &mut Frame, scene: &Scene, world: &World, mattes: &[Matte]) {
    if mattes.is_empty() {
        return;
    }
    let identities = Identities::new(scene, world);
    let optics = Mono::<f64>::optics(world, 0, 0);
    let [width, height] = world.eye.size();
    let pixel = |ledger: &mut Ledger, pixel: usize| -> Vec<Ranked> {
        let looks: [[Option<Site>; 2]; POINTS] = std::array::from_fn(|i| {
            let (jitter, lens) = place(i);
            let (mut first, mut last) = (None, None);
            let ray = world.eye.ray(pixel % width, pixel / width, jitter, lens);
            let end = go_straight((world, &optics), ray, ledger, |vertex| {
                last = Some(vertex.hit.site);
                first = first.or(last.filter(|site| identities.is_there(*site)));
            });
            match end {
                End::Seen => [first, last],
                End::Outside(_) | End::Lost => [first, None],
            }
        });
        let ranked = |matte: &Matte| rank(looks.map(|look| identities.of(*matte, look[usize::from(matte.is_seen())])));
        mattes.iter().map(ranked).collect()
    };
    let pixels: Vec<Vec<Ranked>> =
        (0..width * height).into_par_iter().map_init(|| Ledger::new(world.solids.len()), pixel).collect();
    let parts: Vec<&str> = scene.parts.iter().map(|part| part.path.as_str()).collect();
    let roles = Role::ALL.map(Role::name);
    for (index, matte) in mattes.iter().enumerate() {
        let of_matte: Vec<Ranked> = pixels.iter().filter_map(|pixel| pixel.get(index).copied()).collect();
        cryptomatte::add(frame, *matte, &of_matte, if matte.by_role() { &roles } else { &parts });
    }
}
