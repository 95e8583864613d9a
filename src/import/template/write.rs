//! The text of a skeleton.

use super::guess::Role;
use super::kinds::{FaceFacts, Kind};
use super::{TOLERANCE_UM, around};
use crate::Assembly;
use crate::fit::{FitError, Fitted};
use crate::select::Faces;
use eyebox_base::Where;
use eyebox_base::units::significant;
use glam::DVec3;
use std::fmt::Write;
use std::path::Path;

/// What stands at the top.
#[derive(Debug)]
pub struct Head<'a> {
    /// As the sidecar names it.
    pub asset: &'a str,
    pub sidecar: &'a Path,
    pub unit_m: f64,
    /// The unit is a guess: the asset looks like millimetres.
    pub millimetres: bool,
}

#[derive(Debug, Default)]
pub struct Written {
    pub text: String,
    pub todos: Vec<String>,
}

impl Written {
    pub(super) fn line(&mut self, text: &str) {
        self.text += text;
        self.text.push('\n');
    }
    /// A line that the author has to look at.
    pub(super) fn todo(&mut self, line: &str, what: &str) {
        self.line(&format!("{line:<39} # TODO {what}"));
    }
    pub(super) fn note(&mut self, what: String) {
        self.todos.push(clean(&what));
    }
}

/// Faces of a part that are listed at most.
const LISTED: usize = 16;

pub fn write(assembly: &Assembly, kinds: &[Kind], head: &Head<'_>) -> Written {
    let mut out = Written::default();
    top(assembly, head, &mut out);
    for kind in kinds.iter().filter(|kind| kind.role != Role::Mechanics) {
        listed(kind, &mut out);
        optical(assembly, kind, &mut out);
    }
    if kinds.iter().any(|kind| kind.role == Role::Mechanics) {
        out.line(
            "\n# What nothing here binds: [default] holds. ------------------------------------------------------",
        );
        kinds.iter().filter(|kind| kind.role == Role::Mechanics).for_each(|kind| listed(kind, &mut out));
    }
    around::around(assembly, &mut out);
    out
}

fn top(assembly: &Assembly, head: &Head<'_>, out: &mut Written) {
    let sidecar = head.sidecar.file_name().map_or_else(|| "SIDECAR".into(), |name| name.to_string_lossy());
    out.line(&format!("# Optical attributes of {}, begun by `eyebox init`.", clean(head.asset)));
    out.line("# TODO marks what geometry can't tell; stand-ins are filled in, so that the file can be imported from the start:");
    out.line(&format!("#   eyebox inspect {}", clean(&sidecar)));
    if assembly.optics.is_some() {
        out.line("# The asset carries optical attributes of its own: what is bound here takes their place.");
    }
    out.line("\nschema = 1");
    out.line(&format!("asset = {}", quoted(head.asset)));
    if head.millimetres {
        out.todo(&format!("unit = {}", head.unit_m), "check: taken as metres, the asset is too large for a display");
        out.note(format!("check unit = {}: the asset looks like millimetres", head.unit_m));
    } else {
        out.line(&format!("# unit = {}  # metres per unit, as the asset declares", head.unit_m));
    }
    out.todo("wavelengths = { mono_nm = 550 }", "or \"visible\"");
    out.line("\n[default]");
    out.line("finish = \"absorber\"                     # mechanics, rims and edges are black");
    out.line("\n# Coatings of polished faces: films from outside the solid inwards.");
    out.line("# [coating.ar]                          # a quarter wave of MgF2 at 550 nm");
    out.line("# stack = [{ n = 1.38, thickness_nm = 99.638 }]");
}

/// A part and its faces as comments.
pub(super) fn listed(kind: &Kind, out: &mut Written) {
    let names: Vec<&str> = kind.members.iter().map(|part| part.name.as_str()).collect();
    let name = match names.as_slice() {
        [first, .., last] => format!("{} ... {} ({} alike)", clean(first), clean(last), names.len()),
        [] | [_] => clean(names.first().copied().unwrap_or("")),
    };
    let mm = kind.metres * 1e3;
    let size = kind.size.map_or_else(
        || "no geometry".to_owned(),
        |size| {
            let [x, y, z] = (size * mm).to_array().map(|x| significant(x, 4));
            format!("{x} x {y} x {z} mm")
        },
    );
    let faces = if kind.faces.len() == 1 { "face" } else { "faces" };
    out.line(&format!("\n# {name}: {} {faces}, {size}", kind.faces.len()));
    for (number, face) in kind.faces.iter().enumerate().take(LISTED) {
        out.line(&format!("#   face {number}: {}", facts(face, kind.metres)));
    }
    if let Some(more @ 1..) = kind.faces.len().checked_sub(LISTED) {
        out.line(&format!("#   and {more} more"));
    }
}

fn facts(face: &FaceFacts, metres: f64) -> String {
    let Some(measure) = face.measure else { return "no triangles".to_owned() };
    let mm = metres * 1e3;
    let side =
        measure.normal().map_or_else(|| "no prevailing side".to_owned(), |n| format!("towards {}", direction(n)));
    let surface = match &face.fit {
        None => "no exact shape: scaled differently along its axes".to_owned(),
        // What freeforms were tried for says by how much the best misses.
        Some(Err(error @ (FitError::Misses { kind, .. } | FitError::Open { kind, .. }))) if kind.is_freeform() => {
            format!("no exact shape to {TOLERANCE_UM} um: {}", error.text(metres).replace('µ', "u"))
        }
        Some(Err(_)) => format!("not a plane, sphere, cylinder, conic or toroid to {TOLERANCE_UM} um"),
        Some(Ok(fit)) => {
            let off = format!("{} um at most off", significant(fit.max_residual * metres * 1e6, 2));
            match fit.surface {
                Fitted::Plane { .. } => format!("plane, {off}"),
                Fitted::Sphere { radius, axis, .. } => {
                    format!(
                        "sphere R {} mm, centre towards {}, {off}",
                        significant(radius * mm, 6),
                        direction(axis * radius.signum())
                    )
                }
                Fitted::Cylinder { radius, x, .. } => {
                    format!("cylinder R {} mm along {}, {off}", significant(radius * mm, 6), direction(x))
                }
                Fitted::Toroid { radius, tube_radius, x, .. } => format!(
                    "toroid R {} mm about {}, tube R {} mm, {off}",
                    significant(radius * mm, 6),
                    direction(x),
                    significant(tube_radius * mm, 6)
                ),
                Fitted::Asphere { radius, conic, .. } => {
                    format!("asphere R {} mm k {}, {off}", significant(radius * mm, 6), significant(conic, 6))
                }
                Fitted::XyPoly { radius, ref coeffs, .. } => {
                    format!("xy_poly of {} terms on R {} mm, {off}", coeffs.len(), significant(radius * mm, 6))
                }
                Fitted::Zernike { radius, ref coeffs, .. } => {
                    format!("zernike of {} terms on R {} mm, {off}", coeffs.len(), significant(radius * mm, 6))
                }
                Fitted::Bspline { radius, spans: [a, b], .. } => {
                    format!("bspline of {a} x {b} spans on R {} mm, {off}", significant(radius * mm, 6))
                }
                Fitted::Conic { radius, conic, axis, .. } => format!(
                    "conic R {} mm k {}, centre towards {}, {off}",
                    significant(radius * mm, 6),
                    significant(conic, 6),
                    direction(axis * radius.signum())
                ),
            }
        }
    };
    format!("{} mm2, {side}, {surface}", significant(measure.area * mm * mm, 5))
}

fn direction(v: DVec3) -> String {
    let one = |x: f64| if x.abs() < 1e-6 { "0".to_owned() } else { significant(x, 4) };
    format!("({}, {}, {})", one(v.x), one(v.y), one(v.z))
}

/// The binds of a part that is more than black.
fn optical(assembly: &Assembly, kind: &Kind, out: &mut Written) {
    let Some(path) = &kind.path else {
        out.line("# No path selects this part alone: give it a name of its own in the CAD file.");
        out.note(format!("a name of its own for {}", kind.members.first().map_or("", |part| part.path.as_str())));
        return;
    };
    let bind = format!("\n[[bind]]\npath = {}", quoted(path));
    match kind.role {
        Role::Lens(glass) | Role::Plate(glass) => {
            out.line(bind.trim_start());
            match glass {
                Some(glass) => out.line(&format!("{:<40}# from the name", format!("glass = {}", quoted(glass)))),
                None => {
                    out.todo("glass = \"N-BK7\"", "which glass? or ior = 1.5");
                    out.note(format!("glass of {path}"));
                }
            }
            let (faces, exact) = polished(kind);
            if faces.is_empty() {
                out.todo("# faces = []", "none looks polished: which are?");
                out.note(format!("polished faces of {path}"));
                return;
            }
            out.line(&bind);
            out.line(&format!("faces = {faces:?}"));
            out.line("finish = \"polished\"");
            out.todo("# coating = \"ar\"", "a coating?");
            if exact {
                out.line(&format!("shape = {{ kind = \"fit\", tolerance_um = {TOLERANCE_UM} }}"));
            }
        }
        Role::Lamp => match lit(assembly, kind) {
            Some(selector) => {
                out.line(bind.trim_start());
                out.line(&selector);
                out.todo("emitter = { group = \"led\", flux_lm = 1, angular = \"lambert\" }", "flux of each face");
                out.note(format!("flux_lm of {path}"));
            }
            None => out.todo("# emitter", "no face looks along +z and none is plane: which one emits?"),
        },
        Role::Slide => sheet(kind, &bind, out, |face, out| {
            out.line("finish = \"none\"                         # TODO replace by the slide: its picture, directions, contrast");
            out.line(&format!(
                "# slide = {{ image = \"PICTURE.png\", {}, transmittance = 1, contrast = 300 }}",
                picture(kind, face)
            ));
            out.note(format!("slide on {path}"));
        }),
        Role::Diffuser => sheet(kind, &bind, out, |_, out| {
            out.todo(
                "finish = { kind = \"gauss\", sigma_deg = 6, transmittance = 0.9, reflectance = 0 }",
                "how does it scatter?",
            );
            out.note(format!("scattering of {path}"));
        }),
        Role::Mirror => {
            let Some(face) = largest(kind, |_| true) else { return };
            out.line(bind.trim_start());
            out.line(&format!("faces = [{face}]"));
            out.todo("finish = { kind = \"mirror\", reflectance = 0.9 }", "how much does it reflect?");
            if kind.faces.get(face).is_some_and(|face| face.fitted().is_some()) {
                out.line(&format!("shape = {{ kind = \"fit\", tolerance_um = {TOLERANCE_UM} }}"));
            }
            out.note(format!("reflectance of {path}"));
        }
        Role::Mechanics => {}
    }
}

/// A thin sheet that CAD made a solid: it isn't there for light but for one face.
fn sheet(kind: &Kind, bind: &str, out: &mut Written, says: impl FnOnce(usize, &mut Written)) {
    let Some(face) = front(kind) else {
        out.todo("# faces = []", "no face is plane: which is the sheet?");
        return;
    };
    out.line(bind.trim_start());
    out.line("finish = \"none\"                         # a thin sheet: of the solid only one face counts");
    out.line(bind);
    out.line(&format!("{:<40}# the large face next to the local origin", format!("faces = [{face}]")));
    says(face, out);
}

/// The faces that look polished, and whether all of them are exact surfaces: the large ones, which leaves out rims and
/// edges.
fn polished(kind: &Kind) -> (Vec<usize>, bool) {
    const SHARE: f64 = 0.3;
    let pick = |is: &dyn Fn(&FaceFacts) -> bool| -> Vec<usize> {
        let most = kind.faces.iter().filter(|face| is(face)).map(FaceFacts::area).fold(0.0, f64::max);
        let large = |face: &FaceFacts| is(face) && face.area() >= SHARE * most && most > 0.0;
        kind.faces.iter().enumerate().filter(|(_, face)| large(face)).map(|(number, _)| number).collect()
    };
    let exact = pick(&|face| face.fitted().is_some());
    if exact.is_empty() { (pick(&|face| face.normal().is_some()), false) } else { (exact, true) }
}

fn largest(kind: &Kind, is: impl Fn(&FaceFacts) -> bool) -> Option<usize> {
    let faces = kind.faces.iter().enumerate().filter(|(_, face)| is(face) && face.area() > 0.0);
    faces.max_by(|a, b| a.1.area().total_cmp(&b.1.area())).map(|(number, _)| number)
}

/// Which face emits: that along +z, or else the largest plane one.
fn lit(assembly: &Assembly, kind: &Kind) -> Option<String> {
    let up = Faces::Normal(DVec3::Z);
    let all = |part| up.of(part, assembly, &Where::Nowhere).is_ok_and(|faces| !faces.is_empty());
    if kind.members.iter().all(all) {
        return Some(format!("{:<40}# only the top emits", "normal = \"+z\""));
    }
    largest(kind, FaceFacts::is_plane).map(|face| format!("faces = [{face}]"))
}

/// Of the large plane faces the one nearest to the local origin.
fn front(kind: &Kind) -> Option<usize> {
    let most = largest(kind, FaceFacts::is_plane)?;
    let most = kind.faces.get(most).map_or(0.0, FaceFacts::area);
    let offset = |face: &FaceFacts| {
        face.measure.zip(face.normal()).map_or(f64::INFINITY, |(measure, normal)| normal.dot(measure.centre()).abs())
    };
    let large = kind.faces.iter().enumerate().filter(|(_, face)| face.is_plane() && face.area() >= 0.99 * most);
    large.min_by(|a, b| offset(a.1).total_cmp(&offset(b.1))).map(|(number, _)| number)
}

/// Size and directions of a picture that fills `face`, whose sides are taken along the mesh's axes.
fn picture(kind: &Kind, face: usize) -> String {
    let Some((measure, normal)) = kind.faces.get(face).and_then(|face| face.measure.zip(face.normal())) else {
        return "size = [1, 1], u = [1, 0, 0], v = [0, 1, 0]".to_owned();
    };
    let mut axes = [(DVec3::X, "[1, 0, 0]"), (DVec3::Y, "[0, 1, 0]"), (DVec3::Z, "[0, 0, 1]")];
    axes.sort_by(|a, b| normal.dot(a.0).abs().total_cmp(&normal.dot(b.0).abs()));
    let extent = |axis: DVec3| (measure.max - measure.min).dot(axis);
    let [(a, a_name), (b, b_name), _] = axes;
    let (u, v) = if extent(a) >= extent(b) { ((a, a_name), (b, b_name)) } else { ((b, b_name), (a, a_name)) };
    let [w, h] = [extent(u.0), extent(v.0)].map(|x| significant(x, 6));
    format!("size = [{w}, {h}], u = {}, v = {}", u.1, v.1)
}

/// A TOML string.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => drop(write!(out, "\\u{:04X}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// For comments and messages: no line breaks or other control characters.
pub(super) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
