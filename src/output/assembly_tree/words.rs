//! What things are, in words. All numbers to a few significant digits: people read them.

use super::face::{EmitterReport, FaceReport, SlideReport};
use super::look::LookReport;
use super::parts::MediumReport;
pub use eyebox_base::units::significant as number;
use eyebox_scene::{
    Angular, Coating, CoatingLaw, EfficiencyGrid, Finish, Grating, Order, Orders, ProjectedAxis, Shape, WavePlate,
};
use glam::DVec3;

/// Metres as mm.
pub fn mm(metres: f64) -> String {
    number(metres * 1e3, 6)
}

/// A point in mm; what is rounding of the assembly's `extent_m` is 0.
pub fn place(point: DVec3, extent_m: f64) -> String {
    let one = |x: f64| if x.abs() <= 1e-9 * extent_m { "0".to_owned() } else { mm(x) };
    format!("({}, {}, {})", one(point.x), one(point.y), one(point.z))
}

/// A direction; a tilt of less than a microradian, as fits leave, is 0.
pub fn direction(v: DVec3) -> String {
    let one = |x: f64| if x.abs() < 1e-6 { "0".to_owned() } else { number(x, 5) };
    format!("({}, {}, {})", one(v.x), one(v.y), one(v.z))
}

/// `12 x 8 x 3 mm`.
pub fn size(size: DVec3) -> String {
    let one = |x: f64| if x <= 1e-9 * size.max_element() { "0".to_owned() } else { number(x * 1e3, 4) };
    format!("{} x {} x {} mm", one(size.x), one(size.y), one(size.z))
}

/// Names come from files: no control characters reach a terminal.
pub fn name(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

pub fn medium(medium: &MediumReport) -> String {
    let mut text = format!("{}, n {}", name(&medium.name), number(medium.n, 6));
    if medium.k > 0.0 {
        text += &format!(", k {}", number(medium.k, 4));
    }
    if medium.absorption_per_m > 0.0 {
        text += &format!(", absorbs {}/m", number(medium.absorption_per_m, 4));
    }
    text
}

/// A face in one line, without how well its shape fits.
pub fn face(face: &FaceReport, traced_nm: f64) -> String {
    let mut all = Vec::new();
    if let Some(slide) = &face.slide {
        all.push(self::slide(slide));
    }
    // A face with a slide transmits straight through, whatever its finish, unless it is a display that shows it.
    if face.slide.is_none() || face.emitter.is_some() {
        all.push(face.look.as_ref().map_or_else(|| finish(face.finish), LookReport::text));
        all.extend(face.grating.as_ref().map(grating));
        all.extend(face.wave_plate.as_ref().map(|plate| wave_plate(plate, traced_nm)));
    }
    if let Some(tint) = face.tint {
        let [r, g, b] = tint.map(|c| number(c, 3));
        all.push(format!("tinted ({r}, {g}, {b})"));
    }
    all.extend(face.coating.as_ref().map(|coating| self::coating(coating, traced_nm)));
    all.extend(shape(face));
    all.extend(face.emitter.as_ref().map(emitter));
    all.extend(face.sensor.map(|sensor| format!("sensor of {} x {} pixels", sensor.pixels[0], sensor.pixels[1])));
    all.join(", ")
}

fn grating(grating: &Grating) -> String {
    let orders = match &grating.orders {
        Orders::Even(orders) => {
            let one = |order: &Order| {
                format!("{:+} R {} T {}", order.order, number(order.reflectance, 4), number(order.transmittance, 4))
            };
            orders.iter().map(one).collect::<Vec<_>>().join("; ")
        }
        Orders::Table(table) => {
            let orders: Vec<String> = table.orders.iter().map(|order| format!("{order:+}")).collect();
            let EfficiencyGrid { nm, angle, conical, .. } = &table.front;
            let cones = if conical.len() > 1 { format!(" x {} conical angles", conical.len()) } else { String::new() };
            let sides = if table.back.is_some() { "each side by itself" } else { "both sides alike" };
            let size = format!("{} wavelengths x {} angles{cones}", nm.len(), angle.len());
            format!("{} by {} ({size}, {sides})", orders.join(" "), table.file)
        }
    };
    let lines = number(grating.lines_per_mm, 6);
    let rest = if grating.rest_in_zero_order { "goes on in order 0" } else { "is absorbed" };
    format!("{lines} lines/mm across {}, orders {orders}; the rest {rest}", direction(grating.direction))
}

fn wave_plate(plate: &WavePlate, traced_nm: f64) -> String {
    let mut text = format!("{} waves at {traced_nm} nm", number(plate.retardance.waves(traced_nm), 5));
    if let Some([ordinary, extraordinary]) = plate.indices {
        text += &format!(", by the angle with indices {} and {}", number(ordinary, 6), number(extraordinary, 6));
    }
    text
}

fn finish(finish: Finish) -> String {
    let shares = |r: f64, t: f64| format!("R {}, T {}", number(r, 4), number(t, 4));
    match finish {
        Finish::None => "not there for light".to_owned(),
        Finish::Polished => "polished".to_owned(),
        Finish::MirrorMetal { n, k } => format!("mirror, metal n {} + {}i", number(n, 4), number(k, 4)),
        Finish::MirrorIdeal { reflectance } => format!("mirror, R {}", number(reflectance, 4)),
        Finish::Lambert { reflectance, transmittance } => format!("lambert, {}", shares(reflectance, transmittance)),
        Finish::Gauss { sigma_deg, reflectance, transmittance } => {
            format!("gauss, sigma {} deg, {}", number(sigma_deg, 4), shares(reflectance, transmittance))
        }
        Finish::CosM { m, reflectance, transmittance } => {
            format!("cos^{} lobe, {}", number(m, 4), shares(reflectance, transmittance))
        }
        Finish::Rough { alpha } => format!("rough, alpha {}", number(alpha, 4)),
        Finish::Abg { a, b, g, reflectance } => {
            let [a, b, g, r] = [a, b, g, reflectance].map(|x| number(x, 4));
            format!("abg, A {a} B {b} g {g}, specular R {r}")
        }
        Finish::Measured { .. } => "measured scattering".to_owned(),
        Finish::Polariser { axis, projected_axis, transmittance, extinction } => {
            let (along, other) = (number(transmittance, 4), number(transmittance * extinction, 3));
            format!("polariser about {}, T {along} and {other}{}", direction(axis), projected(projected_axis))
        }
        Finish::Retarder { axis, retardance_nm } => {
            format!("retarder about {}, {} nm", direction(axis), number(retardance_nm, 5))
        }
        Finish::Grating { .. } => "grating".to_owned(),
        Finish::WavePlate { axis, .. } => format!("retarder about {}", direction(axis)),
        Finish::CircularPolariser { axis, projected_axis, transmittance, extinction, right, front, .. } => {
            let (hand, side) = (if right { "right" } else { "left" }, if front { "front" } else { "back" });
            let (along, other) = (number(transmittance, 4), number(transmittance * extinction, 3));
            format!(
                "{hand} circular polariser about {}, polariser at the {side}, T {along} and {other}{}",
                direction(axis),
                projected(projected_axis)
            )
        }
        Finish::ReflectivePolariser {
            axis,
            projected_axis,
            transmittance,
            transmittance_leak,
            reflectance,
            reflectance_leak,
        } => {
            let [t, t_leak, r, r_leak] =
                [transmittance, transmittance_leak, reflectance, reflectance_leak].map(|share| number(share, 4));
            format!(
                "reflective polariser about {}, along T {t} R {r_leak}, across T {t_leak} R {r}{}",
                direction(axis),
                projected(projected_axis)
            )
        }
        Finish::Surface { surface } => format!("surface {}", surface.0),
        Finish::Absorber => "absorber".to_owned(),
    }
}

fn projected(axis: ProjectedAxis) -> &'static str {
    match axis {
        ProjectedAxis::Absorption => "",
        ProjectedAxis::Pass => ", pass axis projected",
    }
}

fn coating(coating: &Coating, traced_nm: f64) -> String {
    let film = |film: &eyebox_scene::FilmLayer| {
        let index = film.index.index(traced_nm);
        let k = if index.im > 0.0 { format!(" + {}i", number(index.im, 4)) } else { String::new() };
        format!("n {}{k} {} nm", number(index.re, 5), number(film.thickness_nm, 6))
    };
    match &coating.law {
        CoatingLaw::Stack(_) => {}
        CoatingLaw::Ideal { reflectance, transmittance } => {
            let (r, t) = (number(*reflectance, 4), number(*transmittance, 4));
            return format!("coating {} [R {r}, T {t}]", name(&coating.name));
        }
        CoatingLaw::Table(table) => {
            let (nms, angles) = (table.outside.nm.len(), table.outside.angle.len());
            return format!("coating {} [table of {nms} wavelengths x {angles} angles]", name(&coating.name));
        }
    }
    const SHOWN: usize = 4;
    let films: Vec<String> = coating.films().iter().take(SHOWN).map(film).collect();
    let more = coating.films().len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more films") } else { String::new() };
    format!("coating {} [{}{more}]", name(&coating.name), films.join(" | "))
}

/// The exact surface with its axis in the part's own frame (radius > 0: the centre lies that way); the mesh is worth a word only where its facets bend light.
fn shape(face: &FaceReport) -> Option<String> {
    let curve = |radius: f64, axis| format!("R {} mm about {}", mm(radius * face.unit_m), direction(axis));
    match &face.shape {
        Shape::Mesh => match face.finish {
            Finish::Polished
            | Finish::Rough { .. }
            | Finish::Abg { .. }
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Grating { .. }
            | Finish::ReflectivePolariser { .. } => Some("as meshed".to_owned()),
            Finish::None
            | Finish::Lambert { .. }
            | Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Measured { .. }
            | Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. }
            | Finish::Surface { .. }
            | Finish::Absorber => None,
        },
        Shape::Plane { .. } => Some("plane".to_owned()),
        Shape::Sphere { radius, axis, .. } => Some(format!("sphere {}", curve(*radius, *axis))),
        Shape::Conic { radius, axis, conic, .. } => {
            Some(format!("conic k {} {}", number(*conic, 6), curve(*radius, *axis)))
        }
        Shape::Asphere { radius, axis, conic, even, .. } => {
            Some(format!("asphere k {} {} with {} even terms", number(*conic, 6), curve(*radius, *axis), even.len()))
        }
        Shape::Cylinder { radius, axis, x, .. } => {
            Some(format!("cylinder {} along {}", curve(*radius, *axis), direction(*x)))
        }
        Shape::Toroid { radius, tube_radius, axis, x, .. } => Some(format!(
            "toroid {}, tube R {} mm along {}",
            curve(*radius, *axis),
            mm(tube_radius * face.unit_m),
            direction(*x)
        )),
        Shape::XyPoly { radius, axis, conic, coeffs, .. } => {
            Some(format!("xy_poly k {} {} with {} terms", number(*conic, 6), curve(*radius, *axis), coeffs.len()))
        }
        Shape::Zernike { radius, axis, conic, norm_radius, coeffs, .. } => Some(format!(
            "zernike k {} {} with {} terms over {} mm",
            number(*conic, 6),
            curve(*radius, *axis),
            coeffs.len(),
            mm(norm_radius * face.unit_m)
        )),
        Shape::Bspline { radius, axis, conic, half, spans, .. } => Some(format!(
            "bspline k {} {} with {} x {} spans over {} x {} mm",
            number(*conic, 6),
            curve(*radius, *axis),
            spans[0],
            spans[1],
            mm(2.0 * half[0] * face.unit_m),
            mm(2.0 * half[1] * face.unit_m)
        )),
    }
}

pub fn emitter(emitter: &EmitterReport) -> String {
    let mut text = format!(
        "emits {} lm, {} cd, {} cd/m² into group {}, {}",
        number(emitter.flux_lm, 4),
        number(emitter.peak_cd, 4),
        number(emitter.luminance_cd_m2, 4),
        name(&emitter.group),
        match emitter.angular {
            Angular::Lambert => "lambert".to_owned(),
            Angular::CosN { n } => format!("cos^{}", number(n, 4)),
            Angular::Gauss { fwhm_deg } => format!("gauss, full width {} deg", number(fwhm_deg, 4)),
            Angular::Profile { .. } => format!("profile {}", name(emitter.profile.as_deref().unwrap_or(""))),
        }
    );
    if let Some(half) = emitter.half_angle_deg {
        text += &format!(", half angle {} deg", number(half, 4));
    }
    if let Some(polarisation) = &emitter.polarisation {
        text += &format!(", {} polarised along {}", number(polarisation.degree, 4), direction(polarisation.axis));
    }
    if let Some(spectrum) = &emitter.spectrum {
        text += &format!(", spectrum {}", name(spectrum));
    }
    text
}

fn slide(slide: &SlideReport) -> String {
    let polarised = slide.polarisation.map_or_else(String::new, |polarisation| {
        format!(", {} % polarised at {}°", number(100.0 * polarisation.degree, 4), number(polarisation.angle_deg, 4))
    });
    format!(
        "slide {} {} x {} pixels, {} x {} mm, T {}, contrast {}, mean T {}{polarised}",
        name(&slide.file),
        slide.pixels[0],
        slide.pixels[1],
        mm(slide.size_m[0]),
        mm(slide.size_m[1]),
        number(slide.transmittance, 4),
        number(slide.contrast, 6),
        number(slide.mean_transmittance, 3)
    )
}

/// `0-4, 7` for rising numbers.
pub fn ranges(numbers: &[usize]) -> String {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if last.checked_add(1) == Some(number) => *last = number,
            Some(_) | None => runs.push((number, number)),
        }
    }
    let text = |&(first, last): &(usize, usize)| match last - first {
        0 => format!("{first}"),
        1 => format!("{first}, {last}"),
        _ => format!("{first}-{last}"),
    };
    runs.iter().map(text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_short_and_names_are_safe() {
        assert_eq!(ranges(&[0, 1, 2, 4, 6, 7]), "0-2, 4, 6, 7");
        assert_eq!(name("a\u{1b}[31m\n"), "a\u{fffd}[31m\u{fffd}");
    }
}
