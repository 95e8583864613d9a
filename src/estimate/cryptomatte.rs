//! Cryptomatte layers of a scene: 16 fixed looks per pixel, the same for every pass, seed and shard.

use super::data::{End, go_straight, place};
use super::ledger::Ledger;
use eyebox_base::parallel;
use eyebox_film::cryptomatte::{self, Matte, MatteBy, NOTHING, POINTS, Ranked, identity, rank};
use eyebox_film::frame::Frame;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::role::{Role, roles};

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
    /// Part, face; nothing where the asset names no material.
    materials: Vec<Vec<u32>>,
}

impl Identities {
    fn new(scene: &Scene, world: &World) -> Self {
        let of_role = |role: Option<Role>| role.map(|role| identity(role.name()));
        let of_part = |faces: Vec<Option<Role>>| faces.into_iter().map(of_role).collect();
        Identities {
            parts: scene.parts.iter().map(|part| identity(&part.path)).collect(),
            roles: roles(scene, world).into_iter().map(of_part).collect(),
            materials: scene
                .parts
                .iter()
                .map(|part| part.materials.iter().map(|name| identity(name)).collect())
                .collect(),
        }
    }

    fn of(&self, matte: Matte, site: Option<Site>) -> u32 {
        let Some(Site { part, face, .. }) = site else { return NOTHING };
        let (part, face) = (part as usize, face as usize);
        let found = match matte.by() {
            MatteBy::Role => self.roles.get(part).and_then(|faces| faces.get(face).copied().flatten()),
            MatteBy::Material => self.materials.get(part).and_then(|faces| faces.get(face).copied()),
            MatteBy::Part => self.parts.get(part).copied(),
        };
        found.unwrap_or(NOTHING)
    }

    fn is_there(&self, site: Site) -> bool {
        self.of(Matte::Role, Some(site)) != NOTHING
    }
}

/// Adds the layers of `mattes` and their attributes. A part is called by its path, a role as [`Role::name`] says, a material as
/// in the asset; what has none is called `none`. The first
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
    let pixels: Vec<Vec<Ranked>> = parallel::map_init(width * height, &|| Ledger::new(world.solids.len()), &pixel);
    let parts: Vec<&str> = scene.parts.iter().map(|part| part.path.as_str()).collect();
    let roles = Role::ALL.map(Role::name);
    let mut materials: Vec<&str> =
        scene.parts.iter().flat_map(|part| part.materials.iter().map(|name| &**name)).collect();
    materials.sort_unstable();
    materials.dedup();
    for (index, matte) in mattes.iter().enumerate() {
        let of_matte: Vec<Ranked> = pixels.iter().filter_map(|pixel| pixel.get(index).copied()).collect();
        let names: &[&str] = match matte.by() {
            MatteBy::Part => &parts,
            MatteBy::Role => &roles,
            MatteBy::Material => &materials,
        };
        cryptomatte::add(frame, *matte, &of_matte, names);
    }
}
