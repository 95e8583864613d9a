//! The picture's second images from one position, named by the parts that make them.

use super::tuning::ghosts::{FAINT, LEAST, MOST};
use crate::paths::Visits;
use eyebox_estimate::virtual_image::ghosts::{self, GhostPoint, Trains, find, shows_the_same};
use eyebox_estimate::virtual_image::subject::Subject;
use eyebox_scene::{Eye, Scene};
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono, MonoStokes};
use eyebox_world::optics::Optics;
use glam::DAffine3;

/// A second image of the picture, seen from one position.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ghost {
    /// The parts on its way from the picture to the eye, as `eyebox paths` names them.
    pub by: String,
    /// Over the points where it and the main image are seen.
    pub mean_ratio: f64,
    pub most_ratio: f64,
    /// Largest distance from the main image, arcmin.
    pub most_arcmin: f64,
    pub points: Vec<GhostPoint>,
}

/// What may be seen twice: a train with its name.
pub struct Named {
    pub by: String,
    subject: Subject,
}

impl Named {
    /// After the picture's part has moved (world, m).
    #[must_use]
    pub fn moved(&self, motion: &DAffine3) -> Named {
        Named { by: self.by.clone(), subject: self.subject.moved(motion) }
    }
}

/// The name of a train that leads from the eye to the picture.
pub fn name(scene: &Scene, world: &World, subject: &Subject) -> String {
    let solid = |part: u32| world.solids.get(part as usize).is_some_and(Option::is_some);
    let chain = subject.train.chain().reversed();
    let parts = Visits::of(&chain, solid, |_| false).words(scene).join(", ");
    let orders: Vec<String> =
        chain.0.iter().filter(|link| link.order != 0).map(|link| format!("{:+}", link.order)).collect();
    if orders.is_empty() { parts } else { format!("{parts}; orders {}", orders.join(", ")) }
}

/// The picture's other images from the middle of the eyebox, most light first, and the largest share of a ray's light whose ways were
/// not followed though they carry enough.
pub fn trains(scene: &Scene, tracing: (&World, &Optics<Mono>), main: &Subject) -> (Vec<Named>, f64) {
    let mut names: Vec<Named> = Vec::new();
    let Trains { images, left_out } = find(tracing, main, LEAST * main.light.clamp(FAINT, 1.0));
    let other_images = images.into_iter().filter(|other| !shows_the_same(main, other));
    for subject in other_images.take(MOST) {
        let by = name(scene, tracing.0, &subject);
        // Faces of one part are not told apart by its name.
        let alike = names.iter().filter(|other| other.by == by || other.by.starts_with(&format!("{by} #"))).count();
        let by = if alike == 0 { by } else { format!("{by} #{}", alike + 1) };
        names.push(Named { by, subject });
    }
    (names, left_out)
}

/// All of them that are seen from `eye`, with their largest first.
pub fn seen(tracing: (&World, &Optics<Mono>), main: &Subject, named: &[Named], eye: &Eye) -> Vec<Ghost> {
    let polarised = MonoStokes::optics(tracing.0, 0, 0);
    let images = |subject: &Subject| ghosts::seen(tracing, &polarised, subject, eye.position);
    let own = if named.is_empty() { Vec::new() } else { images(main) };
    let mut out: Vec<Ghost> = named
        .iter()
        .filter_map(|ghost| {
            let points = ghosts::beside(main, &own, &images(&ghost.subject), eye.right());
            let count = points.len();
            (count > 0).then(|| Ghost {
                by: ghost.by.clone(),
                mean_ratio: points.iter().map(|point| point.ratio).sum::<f64>() / count as f64,
                most_ratio: points.iter().map(|point| point.ratio).fold(0.0, f64::max),
                most_arcmin: points.iter().map(|point| length(point.separation_arcmin)).fold(0.0, f64::max),
                points,
            })
        })
        .collect();
    out.sort_by(|a, b| b.mean_ratio.total_cmp(&a.mean_ratio));
    out
}

fn length([right, up]: [f64; 2]) -> f64 {
    right.hypot(up)
}
