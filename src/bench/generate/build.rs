//! Parts that assemblies are built of: plates, backlit slides, displays.

use super::Dice;
use super::patch::{Patch, mesh};
use crate::kit;
use eyebox_base::ids::{CoatingId, GroupId, SlideId};
use eyebox_scene::{Angular, Coating, CoatingLaw, Emitter, Face, Finish, Photometry, Scene, Slide};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::sync::Arc;

/// Adds a part of this name, filled with a medium of this index if there is one.
pub fn part(
    scene: &mut Scene,
    name: &str,
    place: DAffine3,
    index: Option<f64>,
    (patches, faces): (Vec<Patch>, Vec<Face>),
) {
    let added = kit::add(scene, mesh(&patches), place, index, faces);
    let part = &mut scene.parts[added];
    name.clone_into(&mut part.name);
    name.clone_into(&mut part.path);
}

/// Axes with z along `z`, x as near to the world's x as that leaves.
pub fn frame(origin: DVec3, z: DVec3) -> DAffine3 {
    let x = (DVec3::X - DVec3::X.dot(z) * z).normalize_or(DVec3::Y);
    DAffine3 { matrix3: DMat3::from_cols(x, z.cross(x), z), translation: origin }
}

/// Puts the eye at `from` with its view towards `to` and the world's y up.
pub fn look(scene: &mut Scene, from: DVec3, to: DVec3) {
    let look = (to - from).normalize_or(DVec3::NEG_Z);
    scene.eye.position = from;
    scene.eye.look = look;
    scene.eye.up = look.cross(DVec3::Y).normalize_or(DVec3::X).cross(look).normalize_or(DVec3::Y);
}

pub fn black() -> Face {
    kit::face(Finish::Absorber)
}

pub fn polished() -> Face {
    kit::face(Finish::Polished)
}

/// A partly reflecting coating.
pub fn partial(scene: &mut Scene, name: &str, reflectance: f64, transmittance: f64) -> CoatingId {
    scene.coatings.push(Coating { name: name.to_owned(), law: CoatingLaw::Ideal { reflectance, transmittance } });
    CoatingId::from_index(scene.coatings.len() - 1)
}

pub fn coated(coating: Option<CoatingId>) -> Face {
    Face { coating, ..polished() }
}

/// A plate: its front in the plane z = 0, facing +z, the rest below.
pub fn plate(
    scene: &mut Scene,
    name: &str,
    place: DAffine3,
    (half, thickness): (DVec2, f64),
    (front, index): (Face, f64),
) {
    let back = Patch::flat(half).moved(DAffine3::from_translation(DVec3::Z * -thickness));
    let patches = Patch::body(Patch::flat(half), back, [1, 1]);
    part(scene, name, place, Some(index), (patches, vec![front, polished(), black()]));
}

/// How a lamp's light spreads: as from a matt face, or mostly into 20° to 40°.
pub fn lobe(dice: &mut Dice) -> Angular {
    let narrow = dice.within(20.0, 40.0);
    match dice.whole(0, 2) {
        0 => Angular::Gauss { fwhm_deg: narrow },
        // cosⁿ falls to one half at half of the width.
        1 => Angular::CosN { n: 0.5f64.ln() / (0.5 * narrow).to_radians().cos().ln() },
        _ => Angular::Lambert,
    }
}

pub fn lamp(group: GroupId, luminance: f64, angular: Angular) -> Face {
    let photometry = Photometry::LuminanceCdM2(luminance);
    Face {
        emitter: Some(Emitter {
            group,
            photometry,
            angular,
            spectrum: None,
            polarisation: None,
            both_sides: false,
            pattern: None,
        }),
        ..black()
    }
}

/// A picture of square pixels: bars, a sparse symbol or a ramp.
fn pixels(dice: &mut Dice, [nx, ny]: [usize; 2]) -> Vec<f32> {
    let kind = dice.whole(0, 2);
    let grid = (0..nx * ny).map(|i| (i % nx, i / nx));
    grid.map(|(x, y)| match kind {
        0 => f32::from(u8::from(x % 3 != 1 || y % 4 == 2)),
        1 => f32::from(u8::from(dice.within(0.0, 1.0) < 0.3)),
        _ => (x + 1) as f32 / nx as f32,
    })
    .collect()
}

/// An LCD in the plane z = 0 of `place`, seen from +z, as wide as `half` says and with these pixels, square ones; around it a
/// black bezel of this width.
pub fn lcd(
    scene: &mut Scene,
    dice: &mut Dice,
    name: &str,
    place: DAffine3,
    (half_width, [nx, ny], bezel): (f64, [usize; 2], f64),
) {
    let half = DVec2::new(half_width, half_width * ny as f64 / nx as f64);
    scene.slides.push(Slide {
        name: name.to_lowercase(),
        file: "made in code".to_owned(),
        width: nx,
        height: ny,
        pixels: Arc::new(pixels(dice, [nx, ny])),
        rgb: None,
        centre: DVec3::ZERO,
        u: DVec3::X,
        v: DVec3::Y,
        size: [2.0 * half.x, 2.0 * half.y],
        transmittance: dice.within(0.05, 0.4),
        contrast: dice.within(30.0, 2000.0),
        polarisation: None,
        primaries: None,
    });
    let face = Face { slide: Some(SlideId::from_index(scene.slides.len() - 1)), ..kit::face(Finish::None) };
    part(scene, name, place, None, (vec![Patch::flat(half)], vec![face]));
    frame_around(scene, &format!("{name}_BEZEL"), place, half, bezel);
}

/// A black frame of this width around a rectangle of the plane z = 0.
pub fn frame_around(scene: &mut Scene, name: &str, place: DAffine3, half: DVec2, width: f64) {
    let rim = |z: f64, half: DVec2| {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|sign| (DVec2::from(sign) * half).extend(z))
    };
    let (inner, outer) = (rim(0.0, half), rim(0.0, half + DVec2::splat(width)));
    let sides = (0..4).map(|i| Patch::polygon(vec![outer[i], outer[(i + 1) % 4], inner[(i + 1) % 4], inner[i]]));
    let sides: Vec<Patch> = sides.collect();
    let faces = vec![black(); sides.len()];
    part(scene, name, place, None, (sides, faces));
}

/// Four black walls around a rectangle from z = −`depth` to 0, to be seen from inside.
pub fn tube(scene: &mut Scene, name: &str, place: DAffine3, half: DVec2, depth: f64) {
    let rim = |z: f64| [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|s| (DVec2::from(s) * half).extend(z));
    let wall = Patch::wall(&rim(-depth), &rim(0.0)).flipped();
    part(scene, name, place, None, (vec![wall], vec![black()]));
}

/// A backlight `gap` behind an LCD that is `half` wide and high.
pub fn backlight(scene: &mut Scene, dice: &mut Dice, place: DAffine3, half: DVec2, gap: f64) {
    let group = kit::group(scene, "backlight");
    let (luminance, angular) = (dice.within(2e4, 5e5), lobe(dice));
    let patch = Patch::flat(half).moved(DAffine3::from_translation(DVec3::Z * -gap));
    part(scene, "BACKLIGHT", place, None, (vec![patch], vec![lamp(group, luminance, angular)]));
}

/// A display that shines by itself in the plane z = 0 of `place`, towards +z: one face for each of nx × ny cells, some
/// of them dark.
pub fn panel(scene: &mut Scene, dice: &mut Dice, place: DAffine3, half: DVec2, [nx, ny]: [usize; 2]) {
    let group = kit::group(scene, "display");
    let (bright, angular) = (dice.within(500.0, 2e4), lobe(dice));
    let cell = half / DVec2::new(nx as f64, ny as f64);
    let (mut patches, mut faces) = (Vec::new(), Vec::new());
    for i in 0..nx * ny {
        let (x, y) = ((2 * (i % nx) + 1) as f64, (2 * (i / nx) + 1) as f64);
        let centre = cell * DVec2::new(x, y) - half;
        patches.push(Patch::flat(cell).moved(DAffine3::from_translation(centre.extend(0.0))));
        // The first is never dark, so that there is light.
        let is_dark = i > 0 && dice.within(0.0, 1.0) < 0.4;
        let luminance = bright * dice.within(0.1, 1.0);
        faces.push(if is_dark { black() } else { lamp(group, luminance, angular) });
    }
    part(scene, "DISPLAY", place, None, (patches, faces));
}
