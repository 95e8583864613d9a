//! A surface as its commands leave it, with the axes before and behind it and where it ends.

use crate::prescription::profile::Form;
use crate::prescription::{After, Outline, Profile, Surface, Turn};

/// How the axes of a surface go on behind it.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Return {
    /// They stay turned.
    Stay,
    /// Back to those before it (DAR, RET to itself).
    Back,
    /// Turned once more by the same tilts (BEN): as light is by a mirror.
    Bend,
    /// Turned by the inverse, behind it alone (REV).
    Reverse,
}

pub(super) struct Raw {
    pub surface: Surface,
    pub shift: [f64; 3],
    pub tilt_deg: [f64; 3],
    pub back: Return,
    pub even: [f64; 10],
    /// Half sizes of a rectangular aperture and of an elliptical one, and where its middle is.
    pub rectangle: [f64; 2],
    pub ellipse: [f64; 2],
    pub middle: [f64; 2],
}

/// A surface with the turns before and behind it.
pub(super) fn spread(raw: Raw, last: bool, out: &mut Vec<Surface>) {
    let Raw { mut surface, mut shift, tilt_deg, back, even, rectangle, ellipse, middle } = raw;
    let round = [surface.semi_diameter; 2];
    let kinds = [(rectangle, true), (ellipse, false), (if middle == [0.0; 2] { [0.0; 2] } else { round }, false)];
    surface.outline = kinds
        .into_iter()
        .find(|(half, _)| half.iter().all(|half| *half > 0.0))
        .map(|(half, corners)| Outline { centre: middle, half, corners });
    if let Some(end) = even.iter().rposition(|a| *a != 0.0) {
        surface.profile.form = Form::Even(even[..=end].to_vec());
    }
    if last {
        // How far the image is out of focus.
        let defocus = std::mem::take(&mut surface.thickness);
        shift[2] += if defocus.is_finite() { defocus } else { 0.0 };
    }
    if shift == [0.0; 3] && tilt_deg == [0.0; 3] {
        out.push(surface);
        return;
    }
    let line = surface.line;
    let turn = |turn: Turn, thickness: f64| Surface {
        line,
        comment: String::new(),
        turn: Some(turn),
        profile: Profile::PLANE,
        grating: None,
        thickness,
        after: After::Air,
        semi_diameter: 0.0,
        outline: None,
        hole: 0.0,
        dark: None,
        stop: false,
    };
    let whole = Turn { shift, tilt_deg, ..Turn::default() };
    let (before, behind) = match back {
        Return::Stay => (Some(whole), None),
        Return::Back => (Some(whole), Some(Turn { inverse: true, ..whole })),
        Return::Bend => (Some(whole), Some(Turn { shift: [0.0; 3], ..whole })),
        Return::Reverse => (None, Some(Turn { inverse: true, ..whole })),
    };
    out.extend(before.map(|before| turn(before, 0.0)));
    match behind {
        None => out.push(surface),
        Some(behind) => {
            let thickness = std::mem::take(&mut surface.thickness);
            out.push(surface);
            out.push(turn(behind, thickness));
        }
    }
}
