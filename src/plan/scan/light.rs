//! The luminance of the virtual image from one position, by a short rendering: with lamps imaged into the pupil or behind
//! a screen that scatters there is no ray whose luminance would be that of the whole pupil.

use super::Line;
use crate::base::colour::ColourSpace;
use crate::base::fault::Result;
use crate::check::check;
use crate::estimate::ShouldStop;
use crate::estimate::picture::{add_meta, picture};
use crate::estimate::run::{Films, Limits, Observer, Status, run};
use crate::film::detail::ErrorDetail;
use crate::film::frame::Frame;
use crate::output::average::{Image, Uncertain, mean, pixels_are_independent};
use crate::output::leak::{modulated, patch_pixels};
use crate::output::luminance::Luminance;
use crate::output::shares::{Rendering, luminance_of};
use crate::plan::{Asked, plan_unless};
use crate::scene::Scene;
use crate::world::World;
use glam::DVec2;

/// How luminances are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightAsked {
    /// Of the short rendering.
    pub resolution: [usize; 2],
    pub passes: u64,
    pub seed: u64,
    pub asked: Asked,
}

/// Luminances of the display with its slide fully open, cd/m², with one-sigma errors.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct White {
    /// At the middle of the picture, if it is seen.
    pub centre: Option<Level>,
    /// Over all points that are seen.
    pub mean: Option<Level>,
    /// Least over largest of nine points; none unless all nine are seen.
    pub uniformity: Option<Level>,
}

#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Level {
    pub value: f64,
    pub sigma: Option<f64>,
}

impl From<Uncertain> for Level {
    fn from(of: Uncertain) -> Self {
        Level { value: of.value, sigma: of.sigma }
    }
}

struct Stopping<'s>(&'s ShouldStop<'s>);

impl Observer for Stopping<'_> {
    fn block(&mut self, _: &Status, _: &Films) -> bool {
        !(self.0)()
    }
}

/// Renders from the position that `world` was made for and reads white at the directions of the points. None if `stop`
/// said true. Errors: a scene that cannot be planned, light that is not finite.
pub fn white(
    scene: &Scene,
    world: &World,
    light: &LightAsked,
    lines: &[Line],
    cells: [usize; 2],
    stop: &ShouldStop<'_>,
) -> Result<Option<White>> {
    let checked = check(scene)?;
    let Some(mut plan) = plan_unless(&checked, world, light.asked, stop) else { return Ok(None) };
    plan.errors = ErrorDetail::Layers;
    let limits = Limits { passes: Some(light.passes), ..Limits::default() };
    let size = scene.eye.resolution;
    let outcome = run(world, &plan, scene.groups.len(), size, light.seed, &limits, &mut Stopping(stop));
    if stop() {
        return Ok(None);
    }
    let finished = picture(scene, &plan, &outcome, ColourSpace::Rec709)?;
    let mut frame = finished.frame;
    add_meta(&mut frame, scene, &plan, &outcome, light.seed, &finished.splits);
    let image = display(&frame)?;
    let independent = pixels_are_independent(&frame);
    let side = patch_pixels(&frame).max(1);
    let at = |column: usize, row: usize| {
        let line = lines.iter().find(|line| line.cell == [column, row] && line.seen)?;
        let film = line.direction_deg?.map(|angle| angle.to_radians().tan());
        let pixel = world.eye.pixel_of(DVec2::from_array(film))?;
        mean(&image, &patch(pixel, side, size), independent)
    };
    let [columns, rows] = cells;
    let all: Vec<Uncertain> = (0..columns * rows).filter_map(|i| at(i % columns, i / columns)).collect();
    let nine: Vec<Uncertain> = (0..9)
        .filter_map(|i| {
            let cell = |count: usize, third: usize| ((count - 1) * (2 * third + 1) + 3) / 6;
            at(cell(columns, i % 3), cell(rows, i / 3))
        })
        .collect();
    let by_value = |a: &&Uncertain, b: &&Uncertain| a.value.total_cmp(&b.value);
    let extremes = nine.iter().min_by(by_value).zip(nine.iter().max_by(by_value)).filter(|_| nine.len() == 9);
    let sum = all.split_first().map(|(first, rest)| rest.iter().fold(*first, |sum, point| sum.plus(*point)));
    let count = all.len().max(1) as f64;
    Ok(Some(White {
        centre: at((columns - 1) / 2, (rows - 1) / 2).map(Level::from),
        mean: sum.map(|sum| Level { value: sum.value / count, sigma: sum.sigma.map(|sigma| sigma / count) }),
        uniformity: extremes.and_then(|(least, most)| least.over(*most)).map(Level::from),
    }))
}

/// The light of the group that the slide modulates with the slide fully open, or of all groups where there is none.
fn display(frame: &Frame) -> Result<Image> {
    let rendering = Rendering::of(frame)?;
    let weigh = Luminance::in_frame(frame);
    let pixels = frame.width * frame.height;
    let own = modulated(&rendering).ok();
    let mut values = vec![0.0; pixels];
    let mut variances = Some(vec![0.0; pixels]);
    for share in rendering.shares.iter().filter(|share| own.as_ref().is_none_or(|own| *own == share.group)) {
        let light = luminance_of(share, Some(1.0), &weigh, pixels);
        values.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
        let variance = |pixel: usize| match &share.split {
            Some(split) => split.variance(1.0, pixel),
            None => Some(share.error?.get(pixel).map_or(0.0, |error| f64::from(*error).powi(2))),
        };
        let own: Option<Vec<f64>> = (0..pixels).map(variance).collect();
        variances = variances.zip(own).map(|(sum, own)| sum.iter().zip(own).map(|(a, b)| a + b).collect());
    }
    let errors = variances.map(|all: Vec<f64>| all.into_iter().map(f64::sqrt).collect());
    Ok(Image { values, errors })
}

/// The pixels of a square about one, as far as they are in the picture.
fn patch(pixel: usize, side: usize, [width, height]: [usize; 2]) -> Vec<usize> {
    let (x, y) = (pixel % width.max(1), pixel / width.max(1));
    let range = |at: usize, size: usize| at.saturating_sub(side / 2)..(at - (side / 2).min(at) + side).min(size);
    let columns = range(x, width);
    range(y, height).flat_map(|y| columns.clone().map(move |x| y * width + x)).collect()
}

#[cfg(test)]
mod tests {
    use super::patch;

    #[test]
    fn patches_stay_in_the_picture() {
        assert_eq!(patch(5 * 8 + 3, 1, [8, 6]), [43]);
        assert_eq!(patch(0, 3, [8, 6]), [0, 1, 2, 8, 9, 10, 16, 17, 18]);
        assert_eq!(patch(47, 3, [8, 6]), [38, 39, 46, 47]);
    }
}
