//! How far what a pixel shows behind specular faces moves in the picture until the next frame: where in that a ray has to start,
//! so that the same faces send it to the point that the ray through the middle of the pixel meets now.

use super::data::{End, follow_straight};
use super::ledger::Ledger;
use super::motion::moved;
use eyebox_base::parallel;
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::geometry::Hit;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use glam::{DMat2, DVec2, DVec3};
use std::collections::HashMap;

/// A moment of a scene, and what traces it.
#[derive(Clone, Copy)]
pub struct Frozen<'s> {
    pub world: &'s World,
    pub scene: &'s Scene,
}

/// The way of a ray straight on, as long as faces are specular.
struct Way {
    /// The specular faces.
    chain: Vec<(u32, u32)>,
    /// Where its last piece starts, absolute, and its direction.
    from: DVec3,
    dir: DVec3,
    /// What it ends on; the world behind all parts without one.
    seen: Option<Hit>,
}

/// What has to be met again.
enum Target {
    /// Absolute, m.
    Point(DVec3),
    Direction(DVec3),
}

/// Pixels to the right and up, row-major. 0 where the next frame has no such part, or other faces before it.
pub fn motion_seen(now: Frozen<'_>, next: Frozen<'_>) -> [Vec<f32>; 2] {
    let [width, height] = now.scene.eye.resolution;
    let later: HashMap<&str, usize> =
        next.scene.parts.iter().enumerate().map(|(index, part)| (part.path.as_str(), index)).collect();
    let optics = [now, next].map(|frozen| Mono::<f64>::optics(frozen.world, 0, 0));
    let of = |ledgers: &mut [Ledger; 2], pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let found = || {
            let middle = now.world.eye.film_of(x, y, [0.5; 2]);
            let way = follow((now.world, &optics[0]), middle, &mut ledgers[0])?;
            let target = match &way.seen {
                Some(hit) => {
                    let origin = now.world.geometry.origin();
                    Target::Point(moved(hit, origin, (now.scene, next.scene), &later)? + origin)
                }
                None => Target::Direction(way.dir),
            };
            let same = |(part, face): &(u32, u32)| {
                let part = now.scene.parts.get(*part as usize)?;
                Some((u32::try_from(*later.get(part.path.as_str())?).ok()?, *face))
            };
            let chain: Vec<(u32, u32)> = way.chain.iter().map(same).collect::<Option<_>>()?;
            let search = Search { world: next.world, optics: &optics[1], chain, target };
            let start = next.world.eye.film_of(x, y, [0.5; 2]);
            search.find(start, &mut ledgers[1]).map(|film| film - start)
        };
        let [right, up] = next.world.eye.pixel();
        let film: DVec2 = { found }().unwrap_or(DVec2::ZERO);
        [film.x / right, film.y / up].map(|pixels| pixels as f32)
    };
    let ledgers = || [now, next].map(|frozen| Ledger::new(frozen.world.solids.len()));
    let both: Vec<[f32; 2]> = parallel::map_init(width * height, &ledgers, &of);
    [0, 1].map(|axis| both.iter().map(|pixel| pixel[axis]).collect())
}

/// The way of the ray through a place of the picture and the middle of the pupil; none that is lost.
fn follow((world, optics): (&World, &Optics<Mono>), film: DVec2, ledger: &mut Ledger) -> Option<Way> {
    let (origin, (_, dir), ..) = world.eye.ray_of(film, DVec2::ZERO);
    let mut hits: Vec<Hit> = Vec::new();
    let (end, dir) = follow_straight((world, optics), (origin, dir), ledger, |vertex| hits.push(vertex.hit));
    let seen = match end {
        End::Seen => Some(hits.pop()?),
        End::Outside(_) => None,
        End::Lost => return None,
    };
    let from = hits.last().map_or(origin, |hit| hit.point);
    let dir = seen.as_ref().map_or(Some(dir), |hit| (hit.point - from).try_normalize())?;
    let chain = hits.iter().map(|hit| (hit.site.part, hit.site.face)).collect();
    Some(Way { chain, from: from + world.geometry.origin(), dir, seen })
}

/// Looks for the place of the next picture that shows the target over the same faces.
struct Search<'s> {
    world: &'s World,
    optics: &'s Optics<Mono>,
    chain: Vec<(u32, u32)>,
    target: Target,
}

impl Search<'_> {
    /// How far the ray through a place passes the target, across its last piece; none over other faces.
    fn passes(&self, film: DVec2, ledger: &mut Ledger) -> Option<DVec3> {
        let way = follow((self.world, self.optics), film, ledger)?;
        if way.chain != self.chain {
            return None;
        }
        Some(match self.target {
            Target::Point(point) => (point - way.from).reject_from_normalized(way.dir),
            Target::Direction(dir) => dir - way.dir,
        })
    }

    /// Newton's method with differences over a quarter of a pixel.
    fn find(&self, start: DVec2, ledger: &mut Ledger) -> Option<DVec2> {
        const MOST_STEPS: usize = 16;
        /// Of a pixel: that near, it is found.
        const NEAR: f64 = 1e-4;
        let pixel = DVec2::from_array(self.world.eye.pixel());
        let mut film = start;
        let mut off = self.passes(film, ledger)?;
        for _ in 0..MOST_STEPS {
            let step = 0.25 * pixel;
            let by = |axis: DVec2, ledger: &mut Ledger| {
                let to = |side: f64, ledger: &mut Ledger| Some((self.passes(film + side * axis, ledger)? - off) / side);
                to(1.0, ledger).or_else(|| to(-1.0, ledger))
            };
            let along = [by(DVec2::new(step.x, 0.0), ledger)?, by(DVec2::new(0.0, step.y), ledger)?];
            // What passes across is of two dimensions, in whatever axes: the least squares are exact.
            let normal = DMat2::from_cols(
                DVec2::new(along[0].dot(along[0]), along[0].dot(along[1])),
                DVec2::new(along[0].dot(along[1]), along[1].dot(along[1])),
            );
            let move_by = normal.inverse() * DVec2::new(along[0].dot(off), along[1].dot(off));
            if !move_by.is_finite() {
                return None;
            }
            let mut share = 1.0;
            let (new, new_off) = loop {
                let new = film - share * move_by * step;
                match self.passes(new, ledger) {
                    Some(off) => break (new, off),
                    // Over the edge of a face.
                    None if share > 0.1 => share *= 0.5,
                    None => return None,
                }
            };
            (film, off) = (new, new_off);
            if share == 1.0 && (0.25 * move_by).length() < NEAR {
                return Some(film);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_import::{ImportOptions, ReadOptions, import};

    /// An eye at z = 10 that looks along −z at a mirror of 6 m at z = 0, with 100 pixels a unit of tangent, and a wide plate behind it
    /// at z = 20, which is seen 30 m away. What moves at the next frame.
    fn seen(mirror: &str, plate: &str) -> [Vec<f32>; 2] {
        let square = |name: &str, half: f64, from: &str, to: &str| {
            format!(
                "def Mesh \"{name}\" {{\n uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [4]\n\
                 int[] faceVertexIndices = [0, 1, 2, 3]\n\
                 point3f[] points = [(-{half}, -{half}, 0), ({half}, -{half}, 0), ({half}, {half}, 0), (-{half}, {half}, 0)]\n\
                 double3 xformOp:translate.timeSamples = {{ 3: {from}, 4: {to} }}\n\
                 uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n"
            )
        };
        let stage = format!(
            "#usda 1.0\n(\n metersPerUnit = 1\n upAxis = \"Y\"\n)\ndef DomeLight \"sky\" {{ float inputs:intensity = 100 }}\n\
             def Camera \"eye\" {{\n float horizontalAperture = 40\n float verticalAperture = 10\n float focalLength = 100\n\
             double3 xformOp:translate = (0, 0, 10)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n{}{}",
            square("mirror", 3.0, "(0, 0, 0)", mirror),
            square("plate", 40.0, "(0, 0, 20)", plate),
        );
        let folder = tempfile::tempdir().unwrap();
        let sheet = "schema = 1\nasset = \"a.usda\"\n[default]\nfinish = { kind = \"lambert\", reflectance = 0.5 }\n[[bind]]\npath = \"mirror\"\n\
                     finish = { kind = \"mirror\", reflectance = 0.9 }\n";
        std::fs::write(folder.path().join("a.usda"), stage).unwrap();
        let file = folder.path().join("a.optics.toml");
        std::fs::write(&file, sheet).unwrap();
        let at = |frame: f64| {
            let reading = ReadOptions { frame: Some(frame), ..ReadOptions::default() };
            let mut scene = import(&file, &ImportOptions { reading, ..ImportOptions::default() }).unwrap().scene;
            scene.eye.resolution = [40, 10];
            scene
        };
        let scenes = [at(3.0), at(4.0)];
        let [now, next] = [&scenes[0], &scenes[1]].map(|scene| (World::freeze(scene).unwrap(), scene));
        motion_seen(Frozen { world: &now.0, scene: now.1 }, Frozen { world: &next.0, scene: next.1 })
    }

    /// Pixels to the right and up from the middle → motion.
    fn check(found: &[Vec<f32>; 2], want: impl Fn(f64, f64) -> [f64; 2]) {
        for pixel in 0..400 {
            let (x, y) = (f64::from(pixel % 40) - 19.5, 4.5 - f64::from(pixel / 40));
            let want = want(x, y);
            for axis in 0..2 {
                let found = f64::from(found[axis][pixel as usize]);
                assert!((found - want[axis]).abs() < 1e-3, "{x} {y}: {found} instead of {}", want[axis]);
            }
        }
    }

    /// A plane mirror at z = m shows what is at z at 2m − z.
    #[test]
    fn what_a_mirror_shows_moves_with_both() {
        check(&seen("(0, 0, 0)", "(0.3, 0.15, 20)"), |_, _| [1.0, 0.5]);
        check(&seen("(0, 0, 0)", "(0, 0, 17)"), |x, y| [x * (30.0 / 27.0 - 1.0), y * (30.0 / 27.0 - 1.0)]);
        check(&seen("(0, 0, 1)", "(0, 0, 20)"), |x, y| [x * (30.0 / 28.0 - 1.0), y * (30.0 / 28.0 - 1.0)]);
        // Along itself a mirror changes nothing.
        check(&seen("(0.5, 0.25, 0)", "(0, 0, 20)"), |_, _| [0.0, 0.0]);
    }
}
