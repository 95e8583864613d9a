//! The luminance of the virtual image from one position, by a short rendering: with lamps imaged into the pupil or behind
//! a screen that scatters there is no ray whose luminance would be that of the whole pupil.

use super::patch::{Patches, weights};
use super::places::{Places, looking_at};
use crate::{Asked, follows_rays, plan_unless};
use eyebox_base::colour::ColourSpace;
use eyebox_base::error::Result;
use eyebox_check::check;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::picture::{add_meta, picture};
use eyebox_estimate::run::{Films, Limits, Observer, Status, run};
use eyebox_film::crop::Crop;
use eyebox_film::error_detail::ErrorDetail;
use eyebox_film::frame::Frame;
use eyebox_output::average::{Image, Uncertain, pixels_are_independent, weighted};
use eyebox_output::contrasts::Contrasts;
use eyebox_output::leak::modulated;
use eyebox_output::light_shares::{Rendering, luminance_of};
use eyebox_output::luminance::Luminance;
use eyebox_scene::Scene;
use eyebox_world::World;
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

/// Luminances of the display with its slide fully open, cd/m², with one-sigma errors, of patches that lie wholly inside of
/// what is seen of the picture.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct White {
    /// In the middle of the picture, if a patch there is inside.
    pub centre: Option<Level>,
    /// Over the middles of as many equal cells of the picture as there are points.
    pub mean: Option<Level>,
    /// Least over largest of nine points; none unless all nine are inside.
    pub uniformity: Option<Level>,
    /// How many patches `mean` is of.
    pub patches: usize,
    /// Side of each of them, degrees where the eye looks straight ahead.
    #[serde(default)]
    pub patch_deg: f64,
    /// Lamps are on, and no light came from anywhere in the picture.
    pub black: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
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

/// Renders from the eye of `scene`, with a field of view that holds what is seen of the picture, and reads white there. `blur`: radius of
/// the spot that the pupil makes of a point, tangents. None
/// if `stop` said true, or nothing of the picture is seen. Errors: a scene that cannot be planned, light that is not finite.
pub fn white(
    scene: &mut Scene,
    light: &LightAsked,
    (places, blur): (&Places, f64),
    [columns, rows]: [usize; 2],
    stop: &ShouldStop<'_>,
) -> Result<Option<White>> {
    let Some([low, high]) = places.bounds() else { return Ok(None) };
    let own = scene.eye.clone();
    let patches = Patches::over(&looking_at(&own, [low, high]), [low, high], blur);
    scene.eye = patches.eye.clone();
    let seen = rendered(scene, light, Some(patches.crop), stop);
    scene.eye = own;
    let Some((frame, world)) = seen? else { return Ok(None) };
    let image = display(&frame)?;
    let independent = pixels_are_independent(&frame);
    let (size, pixel) = ([frame.width, frame.height], DVec2::from_array(world.eye.pixel()));
    let at = |u: f64, v: f64| {
        let film = places.film([u, v])?;
        // Of a pixel on its rim it has light from all of it.
        let reach = (0.5 * patches.pixels as f64 + 1.0) * pixel + blur;
        if !places.holds([film - reach, film + reach]) {
            return None;
        }
        let place = 0.5 * DVec2::new(size[0] as f64, size[1] as f64) + DVec2::new(film.x, -film.y) / pixel;
        weighted(&image, &weights(place, patches.pixels, size)?, independent)
    };
    let cell = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let all: Vec<Uncertain> =
        (0..columns * rows).filter_map(|i| at(cell(i % columns, columns), cell(i / columns, rows))).collect();
    let nine: Vec<Uncertain> = (0..9).filter_map(|i| at(cell(i % 3, 3), cell(i / 3, 3))).collect();
    let by_value = |a: &&Uncertain, b: &&Uncertain| a.value.total_cmp(&b.value);
    let extremes = nine.iter().min_by(by_value).zip(nine.iter().max_by(by_value)).filter(|_| nine.len() == 9);
    let sum = all.split_first().map(|(first, rest)| rest.iter().fold(*first, |sum, point| sum.plus(*point)));
    let count = all.len().max(1) as f64;
    let lit = if all.is_empty() {
        image.values.iter().any(|value| *value > 0.0)
    } else {
        all.iter().any(|patch| patch.value > 0.0)
    };
    let on = world.lamps.total_flux_lm() > 0.0 || !scene.lights.is_empty();
    Ok(Some(White {
        centre: at(0.5, 0.5).map(Level::from),
        mean: sum.map(|sum| Level { value: sum.value / count, sigma: sum.sigma.map(|sigma| sigma / count) }),
        uniformity: extremes.and_then(|(least, most)| least.over(*most)).map(Level::from),
        patches: all.len(),
        patch_deg: patches.side_deg(),
        black: on && !lit,
    }))
}

/// The frame of a short rendering, of which only `crop` is rendered if there is one, and its world. None if `stop` said true.
pub(crate) fn rendered(
    scene: &Scene,
    light: &LightAsked,
    crop: Option<Crop>,
    stop: &ShouldStop<'_>,
) -> Result<Option<(Frame, World)>> {
    let (checked, mut world) = (check(scene)?, World::freeze(scene)?);
    world.eye.crop = crop;
    follows_rays(&checked, &world, light.asked)?;
    let Some(mut plan) = plan_unless(&checked, &world, light.asked, stop) else { return Ok(None) };
    plan.errors = ErrorDetail::Layers;
    let limits = Limits { passes: Some(light.passes), ..Limits::default() };
    let size = scene.eye.resolution;
    let outcome = run(&world, &plan, scene.groups.len(), size, light.seed, &limits, &mut Stopping(stop));
    if stop() {
        return Ok(None);
    }
    let finished = picture(scene, &plan, &outcome, ColourSpace::Rec709)?;
    let mut frame = finished.frame;
    add_meta(&mut frame, scene, &plan, &outcome, light.seed, &finished.splits);
    Ok(Some((frame, world)))
}

/// The light of the group that the slide modulates with the slide fully open, or of all groups where there is none.
fn display(frame: &Frame) -> Result<Image> {
    let rendering = Rendering::of(frame)?;
    let weigh = Luminance::in_frame(frame);
    let pixels = frame.width * frame.height;
    let slides = rendering.shares.iter().any(|share| share.is_split());
    let own = match modulated(&rendering) {
        Ok(group) => Some(group),
        // A slide that no light comes through makes a black picture, whatever else shines.
        Err(groups) if groups.is_empty() && slides => return Ok(Image { values: vec![0.0; pixels], errors: None }),
        Err(_) => None,
    };
    let open = Contrasts::of_all(&rendering, 1.0);
    let mut values = vec![0.0; pixels];
    let mut variances = Some(vec![0.0; pixels]);
    for share in rendering.shares.iter().filter(|share| own.as_ref().is_none_or(|own| *own == share.group)) {
        let light = luminance_of(share, &open, &weigh, pixels);
        values.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
        let own: Option<Vec<f64>> = (0..pixels).map(|pixel| share.variance(&open, pixel)).collect();
        variances = variances.zip(own).map(|(sum, own)| sum.iter().zip(own).map(|(a, b)| a + b).collect());
    }
    let errors = variances.map(|all: Vec<f64>| all.into_iter().map(f64::sqrt).collect());
    Ok(Image { values, errors })
}
