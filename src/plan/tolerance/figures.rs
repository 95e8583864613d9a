//! What is read off a design as it is made: figures of the virtual image from the scene's own eye.

use super::parameter::{Change, Parameter};
use crate::scan::ghosts::{self, Named};
use crate::scan::{self, Position};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_estimate::virtual_image::aim::{aim_over, carried_along};
use eyebox_estimate::virtual_image::subject::{Point, Subject};
use eyebox_scene::Scene;
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono, MonoStokes};
use eyebox_world::optics::Optics;
use glam::DAffine3;

const LUMINANCE: &str = "luminance";

/// A number that is read off each draw.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Figure {
    pub name: String,
    pub unit: &'static str,
}

/// What the nominal design shows, by which the others are looked at.
pub struct Nominal {
    subject: Subject,
    ghosts: Vec<Named>,
    /// Of the part that is looked at.
    to_world: DAffine3,
    /// The part and face that carry the picture: of a film, those that it lies in.
    carrier: (usize, usize),
    ipd_m: f64,
    pub figures: Vec<Figure>,
    /// Of the design itself, in the order of `figures`.
    pub values: Vec<f64>,
    /// The parts between picture and eye, and the picture's own.
    pub by: String,
    pub part: String,
    light: f64,
}

impl Nominal {
    /// Finds what the scene's eye looks at. `points`: columns and rows; `target`: as for a scan.
    /// Errors: nothing to look at, a scene that cannot be traced, a picture whose middle is not seen.
    pub fn new(scene: &Scene, points: [usize; 2], target: Option<&str>, ipd_m: f64) -> Result<Nominal> {
        let world = World::freeze(scene)?;
        let optics = Mono::<f64>::optics(&world, 0, 0);
        let subject = Subject::find(scene, (&world, &optics), target, points)?;
        let subject = subject.polarised((&world, &optics)).stitched((&world, &optics));
        let (ghosts, _) = ghosts::trains(scene, (&world, &optics), &subject);
        let by = ghosts::name(scene, &world, &subject);
        let part = &scene.parts[subject.part as usize];
        let figure = |name: &str, unit| Figure { name: name.to_owned(), unit };
        let mut figures = vec![
            figure("direction right", "arcmin"),
            figure("direction up", "arcmin"),
            figure("1/distance", "1/m"),
            figure("astigmatism, largest", "1/m"),
            figure("distortion, rms", "arcmin"),
            figure("distortion, largest", "arcmin"),
            figure("convergence, mean", "arcmin"),
            figure("dipvergence, largest", "arcmin"),
            figure(LUMINANCE, "of the design's"),
            figure("seen", "of the picture"),
        ];
        for ghost in &ghosts {
            figures.push(Figure { name: format!("ghost right: {}", ghost.by), unit: "arcmin" });
            figures.push(Figure { name: format!("ghost up: {}", ghost.by), unit: "arcmin" });
            figures.push(Figure { name: format!("ghost ratio: {}", ghost.by), unit: "of the main image" });
        }
        let own = (subject.part as usize, subject.face as usize);
        let carrier = part.film_in.map_or(own, |base| (base.part, base.face));
        let (to_world, part) = (part.to_world, part.path.clone());
        let values = Vec::new();
        let mut nominal = Nominal { subject, ghosts, to_world, carrier, ipd_m, figures, values, by, part, light: 1.0 };
        let values = nominal.of(scene)?;
        let luminance = nominal.figures.iter().position(|figure| figure.name == LUMINANCE).unwrap_or(0);
        let Some(light) = values.get(luminance).copied().filter(|light| *light > 0.0) else {
            let at = Where::part(&nominal.part);
            return Err(Error::new(at, "the picture's middle is not seen").expected("a design whose eye sees it"));
        };
        (nominal.light, nominal.values) = (light, values);
        if let Some(own) = nominal.values.get_mut(luminance) {
            *own = 1.0;
        }
        Ok(nominal)
    }

    /// Whether a parameter moves the face of the picture within its part: the picture would not go along.
    pub fn is_moved_within(&self, parameter: &Parameter) -> bool {
        let face = match parameter.change {
            Change::Thickness { face } | Change::Wedge { face, .. } => face,
            Change::Decenter { .. } | Change::Tilt { .. } | Change::Radius { .. } | Change::Index => return false,
        };
        face == self.carrier.1 && parameter.parts.contains(&self.carrier.0)
    }

    /// The figures of a design that was changed; NaN where there is none, as of a ghost that is not seen.
    /// Errors: a scene that cannot be traced.
    pub fn of(&self, scene: &Scene) -> Result<Vec<f64>> {
        let world = World::freeze(scene)?;
        let optics = Mono::<f64>::optics(&world, 0, 0);
        let motion = scene.parts[self.subject.part as usize].to_world * self.to_world.inverse();
        let subject = self.subject.moved(&motion);
        let mut position = Position::nowhere();
        scan::lines::fill(&mut position, (&world, &optics), &scene.eye, &subject, self.ipd_m);
        let middle = subject.middle();
        let line = middle.and_then(|point| position.points.iter().find(|line| line.cell == point.cell));
        let direction = line.and_then(|line| line.direction_deg);
        let arcmin = |axis: usize| direction.map(|deg| 60.0 * deg[axis]);
        let light = middle.and_then(|point| light(&world, scene, (&optics, &subject), point));
        let mut out: Vec<f64> = [
            arcmin(0),
            arcmin(1),
            line.and_then(|line| line.vergence).map(|v| v.mean_per_m()),
            position.distance.map(|d| d.astigmatism_per_m),
            position.distortion.map(|d| d.rms_arcmin),
            position.distortion.map(|d| d.max_arcmin),
            position.disparity.map(|d| d.mean_convergence_arcmin),
            position.disparity.map(|d| d.dipvergence_arcmin),
            light.map(|light| light / self.light),
            Some(position.seen),
        ]
        .map(|value| value.unwrap_or(f64::NAN))
        .to_vec();
        let moved: Vec<Named> = self.ghosts.iter().map(|ghost| ghost.moved(&motion)).collect();
        let seen = ghosts::seen((&world, &optics), &subject, &moved, &scene.eye);
        for ghost in &self.ghosts {
            let found = seen.iter().find(|other| other.by == ghost.by);
            let point =
                found.zip(middle).and_then(|(found, middle)| found.points.iter().find(|p| p.cell == middle.cell));
            let [right, up] = point.map_or([f64::NAN; 2], |point| point.separation_arcmin);
            out.extend([right, up, point.map_or(f64::NAN, |point| point.ratio)]);
        }
        Ok(out)
    }
}

/// The share of the picture's light that a ray through the middle takes up.
fn light(world: &World, scene: &Scene, (optics, subject): (&Optics<Mono>, &Subject), point: &Point) -> Option<f64> {
    let eye = scene.eye.position;
    let (sight, way) = aim_over((world, optics), subject, point, (subject.from, point.near), eye);
    let dir = sight.seen()?;
    let polarised = MonoStokes::optics(world, 0, 0);
    carried_along((world, &polarised), way, point, eye, dir)
}
