//! UsdLux lights: luminance = intensity · 2^exposure · colour, in nit; divided by the surface in world space where
//! `normalize` says so (UsdLuxLightAPI).

use super::attribute::{PrimView, resolved};
use super::reader::Reader;
use super::round_trip::{RoundTrip, refined};
use super::{normalise, shape, value};
use crate::assembly::{LightForm, LightSource, Node};
use crate::value::{Data, Value};
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;
use glam::{DAffine3, DMat3};
use openusd::sdf;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Appends the light of a prim whose type is one, for `node` of the assembly.
///
/// | type | form | strength |
/// |---|---|---|
/// | Rect, Disk, Sphere, Cylinder | the same | luminance L |
/// | Sphere with `treatAsPoint` or radius 0 | `Point` | π r² L |
/// | Distant | `Distant` | illuminance; L × π sin²(angle/2), which `normalize` divides by |
/// | Dome, Dome_1 | `Dome` | factor of the picture |
///
/// # Errors
/// Values of the wrong type. Lights of kinds that are not known, and values out of range, are notes.
pub(super) fn read(reader: &mut Reader, view: &PrimView, node: usize, type_name: &str) -> Result<()> {
    let Some(to_world) = reader.assembly.nodes.get(node).map(|node| node.to_world) else { return Ok(()) };
    let fallback = if type_name == "DistantLight" { 50_000.0 } else { 1.0 };
    let Some(Strength { strength, color, kelvin }) = strength(reader, view, fallback)? else { return Ok(()) };
    let marks = RoundTrip::of(view)?;
    let light = Lit { view, marks: &marks, to_world, strength, normal: flag(view, "inputs:normalize")? };
    let mut holder = node;
    let form = match type_name {
        "RectLight" => light.rect(reader)?,
        "DiskLight" => light.disk(reader)?,
        "SphereLight" => light.sphere(reader)?,
        "CylinderLight" => light.cylinder(reader)?,
        "DistantLight" => light.distant(reader)?,
        "DomeLight" | "DomeLight_1" => {
            let form = light.dome(reader)?;
            if form.is_some() && type_name == "DomeLight_1" && pole_is_z(reader, view)? {
                holder = turned(reader, view, node)?;
            }
            form
        }
        other => {
            reader.ledger.warn(view.at(), format!("lights of type {other} are not used"));
            None
        }
    };
    let Some(form) = form else { return Ok(()) };
    let profile = shape::profile(reader, view, strength, &marks)?;
    let form = match &profile {
        Some(profile) if !profile.normalize => as_measured(form, profile.factor),
        Some(_) | None => form,
    };
    // A profile that is not normalised says how strong the point is, whatever its radius.
    if let LightForm::Point { intensity_cd: 0.0, .. } = form
        && strength > 0.0
    {
        reader.ledger.warn(view.at(), "a point without `normalize` has no light");
    }
    shape::unused(reader, view, &form)?;
    reader.charge(view.path(), 1, size_of::<LightSource>() + 2 * view.path().as_str().len())?;
    let color = marks.triple("color").map_or(color, |exact| {
        let mut lanes = color;
        lanes.iter_mut().zip(exact).for_each(|(lane, exact)| *lane = refined(Some(exact), *lane));
        lanes
    });
    let attributes = reader.assembly.nodes.get_mut(node).and_then(|node| node.attributes.take());
    reader.assembly.lights.push(LightSource {
        name: marks.text("name").unwrap_or(view.name()).to_owned(),
        node: holder,
        form,
        color,
        kelvin,
        profile,
        attributes,
        at: view.at(),
    });
    Ok(())
}

/// The form of a light whose profile says how strong it is: its own strength is the profile's factor.
fn as_measured(mut form: LightForm, factor: f64) -> LightForm {
    match &mut form {
        LightForm::Point { intensity_cd: strength, .. }
        | LightForm::Rect { luminance_cd_m2: strength, .. }
        | LightForm::Disk { luminance_cd_m2: strength, .. }
        | LightForm::Sphere { luminance_cd_m2: strength, .. }
        | LightForm::Cylinder { luminance_cd_m2: strength, .. } => *strength = factor,
        LightForm::Distant { .. } | LightForm::Dome { .. } => {}
    }
    form
}

/// A mesh that is a light (MeshLightAPI): a lamp of ours, unless its attributes say what it emits.
///
/// # Errors
/// Values of the wrong type.
pub(super) fn of_mesh(reader: &mut Reader, view: &PrimView, node: usize) -> Result<()> {
    // Asking the schemas of every mesh costs more than its names.
    if !view.property_names().iter().any(|name| name.starts_with("inputs:") || name.starts_with("light:")) {
        return Ok(());
    }
    let schemas = view.prim.api_schemas().map_err(|error| view.moment.failed(view.path(), error))?;
    if !schemas.iter().any(|schema| schema.as_str() == "MeshLightAPI") {
        return Ok(());
    }
    let Some(Strength { strength, color, kelvin }) = strength(reader, view, 1.0)? else { return Ok(()) };
    if flag(view, "inputs:normalize")? {
        reader.ledger.warn(view.at(), "a mesh light that is normalised by its area: not used");
        return Ok(());
    }
    let at = view.at_property("inputs:intensity");
    let luminance = ("luminance_cd_m2".to_owned(), Value::new(Data::Number(strength), at.clone()));
    let number = |x: f64| Value::new(Data::Number(x), at.clone());
    let hue = match kelvin {
        Some(kelvin) => Some(("cct".to_owned(), number(kelvin))),
        None if color[0] == color[1] && color[1] == color[2] => None,
        None => Some(("rgb".to_owned(), Value::new(Data::List(color.map(number).to_vec()), at.clone()))),
    };
    let spectrum = hue.map(|hue| ("spectrum".to_owned(), Value::new(Data::Table(vec![hue]), at.clone())));
    let said = [luminance].into_iter().chain(spectrum).collect();
    let row = ("emitter".to_owned(), Value::new(Data::Table(said), at.clone()));
    let Some(node) = reader.assembly.nodes.get_mut(node) else { return Ok(()) };
    match &mut node.attributes {
        Some(Value { data: Data::Table(rows), .. }) if rows.iter().all(|(key, _)| key != "emitter") => rows.push(row),
        Some(_) => {}
        None => node.attributes = Some(Value::new(Data::Table(vec![row]), at)),
    }
    Ok(())
}

/// How strong a light is, and which colour it has.
struct Strength {
    /// With the colour's luminance in it.
    strength: f64,
    /// At luminance 1.
    color: [f64; 3],
    /// The colour temperature, if nothing but it makes the colour.
    kelvin: Option<f64>,
}

/// `None` for a light that cannot be used.
fn strength(reader: &mut Reader, view: &PrimView, fallback: f64) -> Result<Option<Strength>> {
    let intensity = view.number("inputs:intensity")?.unwrap_or(fallback);
    let exposure = view.number("inputs:exposure")?.unwrap_or(0.0);
    let triple = |found: sdf::Value| value::triple(&found);
    let mut color = view.read("inputs:color", "a colour", triple)?.unwrap_or([1.0; 3]);
    let mut temperature = None;
    if flag(view, "inputs:enableColorTemperature")? {
        let kelvin = view.number("inputs:colorTemperature")?.unwrap_or(6500.0);
        if !(COLDEST..=HOTTEST).contains(&kelvin) {
            let text = format!("a colour temperature outside {COLDEST} to {HOTTEST} K: the nearer end is taken");
            reader.ledger.warn(view.at_property("inputs:colorTemperature"), text);
        }
        let kelvin = kelvin.clamp(COLDEST, HOTTEST);
        let tint = blackbody(kelvin);
        temperature = (color[0] == color[1] && color[1] == color[2]).then_some(kelvin);
        color.iter_mut().zip(tint).for_each(|(lane, tint)| *lane *= tint);
    }
    let own = luminance(color);
    let strength = intensity * exposure.exp2() * own;
    if color.iter().any(|lane| lane.is_nan() || *lane < 0.0) || !strength.is_finite() || strength < 0.0 {
        reader.ledger.warn(view.at(), "a light whose strength or colour is negative or not finite: left out");
        return Ok(None);
    }
    if own == 0.0 {
        reader.ledger.warn(view.at(), "a black light");
        return Ok(Some(Strength { strength: 0.0, color: [1.0; 3], kelvin: None }));
    }
    let color = color.map(|lane| lane / own);
    let color = if color.iter().all(|lane| lane.is_finite()) { color } else { [1.0; 3] };
    Ok(Some(Strength { strength, color, kelvin: temperature }))
}

/// Where the fit of [`blackbody`] holds, K.
const COLDEST: f64 = 1000.0;
const HOTTEST: f64 = 15000.0;

/// Linear Rec.709 of a black body at luminance 1, from [`COLDEST`] to [`HOTTEST`]: the Planckian locus in CIE 1960 (u, v) by
/// Krystek, Color Res. Appl. 10 (1985) 38, within 8e-5.
fn blackbody(kelvin: f64) -> [f64; 3] {
    let t = kelvin;
    let u =
        (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) / (1.0 + 8.42420235e-4 * t + 7.08145163e-7 * t * t);
    let v =
        (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) / (1.0 - 2.89741816e-5 * t + 1.61456053e-7 * t * t);
    // CIE 15: x = 3u / (2u − 8v + 4), y = 2v / (2u − 8v + 4); X = x/y, Y = 1, Z = (1 − x − y)/y.
    let (x, y) = (3.0 * u / (2.0 * u - 8.0 * v + 4.0), 2.0 * v / (2.0 * u - 8.0 * v + 4.0));
    let (x, z) = (x / y, (1.0 - x - y) / y);
    // IEC 61966-2-1, its inverse matrix.
    let lanes = [
        3.2406255 * x - 1.537208 - 0.4986286 * z,
        -0.9689307 * x + 1.8757561 + 0.0415175 * z,
        0.0557101 * x - 0.2040211 + 1.0569959 * z,
    ];
    let lanes = lanes.map(|lane: f64| lane.max(0.0));
    let own = luminance(lanes);
    lanes.map(|lane| lane / own)
}

pub(super) fn flag(view: &PrimView, name: &str) -> Result<bool> {
    Ok(view.read(name, "true or false", |found| value::flag(&found))?.unwrap_or(false))
}

/// One light on its way.
struct Lit<'a> {
    view: &'a PrimView,
    marks: &'a RoundTrip,
    to_world: DAffine3,
    strength: f64,
    /// `inputs:normalize`.
    normal: bool,
}

impl Lit<'_> {
    fn size(&self, name: &str, fallback: f64) -> Result<f64> {
        let exact = self.marks.number(name);
        Ok(refined(exact, self.view.length(&format!("inputs:{name}"))?.unwrap_or(fallback)))
    }
    /// Lengths of the light's axes in the world.
    fn axes(&self) -> [f64; 3] {
        let m = self.to_world.matrix3;
        [m.x_axis.length(), m.y_axis.length(), m.z_axis.length()]
    }
    /// The luminance of a surface of `area` scene units² in the world; `None` for none that can be used.
    fn luminance(&self, reader: &mut Reader, area: f64) -> Option<f64> {
        let luminance = if self.normal { self.strength / area } else { self.strength };
        if luminance.is_finite() && area > 0.0 {
            return Some(refined(self.marks.number("luminance_cd_m2"), luminance));
        }
        reader.ledger.warn(self.view.at(), "a light without surface: left out");
        None
    }

    fn rect(&self, reader: &mut Reader) -> Result<Option<LightForm>> {
        let (width, height) = (self.size("width", 1.0)?, self.size("height", 1.0)?);
        let m = self.to_world.matrix3;
        let area = width * height * m.x_axis.cross(m.y_axis).length();
        if self.view.has("inputs:texture:file") {
            let at = self.view.at_property("inputs:texture:file");
            reader.ledger.warn(at, "the picture of a rectangular light is not used: it shines evenly");
        }
        Ok(self.luminance(reader, area).map(|luminance_cd_m2| LightForm::Rect { luminance_cd_m2, width, height }))
    }
    fn disk(&self, reader: &mut Reader) -> Result<Option<LightForm>> {
        let radius = self.size("radius", 0.5)?;
        let m = self.to_world.matrix3;
        let area = PI * radius * radius * m.x_axis.cross(m.y_axis).length();
        Ok(self.luminance(reader, area).map(|luminance_cd_m2| LightForm::Disk { luminance_cd_m2, radius }))
    }
    fn sphere(&self, reader: &mut Reader) -> Result<Option<LightForm>> {
        let radius = self.size("radius", 0.5)?;
        let semi = self.axes().map(|scale| radius * scale);
        if !flag(self.view, "treatAsPoint")? && radius > 0.0 {
            let area = radius * radius * stretched_sphere(&self.to_world.matrix3);
            return Ok(self
                .luminance(reader, area)
                .map(|luminance_cd_m2| LightForm::Sphere { luminance_cd_m2, radius }));
        }
        // A sphere shows π r² from everywhere; `normalize` divides by 4 π r², whatever r.
        let shown = if self.normal { 0.25 } else { PI * (semi[0] * semi[1] * semi[2]).cbrt().powi(2) };
        let intensity = self.strength * shown * reader.assembly.unit_m * reader.assembly.unit_m;
        if !intensity.is_finite() {
            reader.ledger.warn(self.view.at(), "a light that overflows: left out");
            return Ok(None);
        }
        let intensity_cd = refined(self.marks.number("intensity_cd"), intensity);
        Ok(Some(LightForm::Point { intensity_cd, cone: shape::cone(self.view, self.marks)? }))
    }
    fn cylinder(&self, reader: &mut Reader) -> Result<Option<LightForm>> {
        let (radius, length) = (self.size("radius", 0.5)?, self.size("length", 1.0)?);
        if flag(self.view, "treatAsLine")? {
            reader.ledger.info(self.view.at_property("treatAsLine"), "a cylinder keeps its radius here");
        }
        let area = radius * length * stretched_tube(&self.to_world.matrix3);
        Ok(self.luminance(reader, area).map(|luminance_cd_m2| LightForm::Cylinder { luminance_cd_m2, radius, length }))
    }
    fn distant(&self, reader: &mut Reader) -> Result<Option<LightForm>> {
        let said = self.view.length("inputs:angle")?.unwrap_or(0.53).to_radians();
        let mut angle = said.min(PI);
        if said > PI {
            reader
                .ledger
                .warn(self.view.at_property("inputs:angle"), "wider than half of all directions: taken as 180°");
        }
        angle = refined(self.marks.number("angle"), angle);
        // The schema counts a disc without extent as 1, and beyond half of all directions the light from behind, too.
        let disc = if angle > 0.0 { PI * (0.5 * angle).sin().powi(2) } else { 1.0 };
        let all = if said > PI { PI * (2.0 - (0.5 * said.min(2.0 * PI)).sin().powi(2)) } else { disc };
        let illuminance = self.strength * if self.normal { disc / all } else { disc };
        let illuminance_lx = refined(self.marks.number("illuminance_lx"), illuminance);
        Ok(Some(LightForm::Distant { illuminance_lx, angle }))
    }
    fn dome(&self, reader: &mut Reader) -> Result<Option<LightForm>> {
        let format = self.view.token("inputs:texture:format")?;
        if !matches!(format.as_deref(), None | Some("automatic" | "latlong")) {
            let text = format!("a dome's picture in the format {} is not used", format.unwrap_or_default());
            reader.ledger.warn(self.view.at_property("inputs:texture:format"), text);
            return Ok(None);
        }
        let image = file(self.view, "inputs:texture:file")?;
        let scale_cd_m2 = refined(self.marks.number("scale_cd_m2"), self.strength);
        Ok(Some(LightForm::Dome { scale_cd_m2, image }))
    }
}

/// A file that an attribute names, as the library finds it, else beside the asset.
pub(super) fn file(view: &PrimView, name: &str) -> Result<Option<PathBuf>> {
    let asset = |found| match found {
        sdf::Value::AssetPath(path) => Some(path),
        _ => None,
    };
    let Some(path) = view.read(name, "an asset path", asset)? else { return Ok(None) };
    Ok(located(view, &path))
}

/// Where the file of an asset path is; none of an empty one.
pub(super) fn located(view: &PrimView, path: &sdf::AssetPath) -> Option<PathBuf> {
    if path.as_str().is_empty() {
        return None;
    }
    let folder = view.moment.file.parent().unwrap_or(Path::new(""));
    Some(match resolved(path) {
        Some(found) => {
            // Named as the asset is named, so that messages and files do not depend on where it lies.
            let home = if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.canonicalize().ok();
            let below = home.and_then(|home| Some(found.strip_prefix(home).ok()?.to_owned()));
            below.map_or_else(|| found.to_owned(), |rest| folder.join(rest))
        }
        None => folder.join(&*normalise::meant(path.as_str())),
    })
}

/// Whether the top of a DomeLight_1 is +z; the stage's up axis where it says `scene`.
fn pole_is_z(reader: &mut Reader, view: &PrimView) -> Result<bool> {
    Ok(match view.token("poleAxis")?.as_deref() {
        None | Some("scene") => reader.assembly.axes != DMat3::IDENTITY,
        Some("Z") => true,
        Some("Y") => false,
        Some(other) => {
            reader.ledger.warn(view.at_property("poleAxis"), format!("the axis `{other}` is none: taken as Y"));
            false
        }
    })
}

/// A node below `node` whose +y is the z of it: +90° about x, as UsdImaging turns such domes.
fn turned(reader: &mut Reader, view: &PrimView, node: usize) -> Result<usize> {
    let Some(own) = reader.assembly.nodes.get(node) else { return Ok(node) };
    let local = DAffine3::from_mat3(DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0]));
    let (name, to_world) = ("pole".to_owned(), own.to_world * local);
    let path = format!("{}/{name}", own.path);
    reader.charge(view.path(), 1, size_of::<Node>() + 2 * path.len())?;
    let at = view.at();
    reader.assembly.nodes.push(Node {
        name,
        path,
        parent: Some(node),
        local,
        to_world,
        mesh: None,
        attributes: None,
        user: Vec::new(),
        at,
    });
    Ok(reader.assembly.nodes.len() - 1)
}

/// Steps in longitude: the midpoint rule converges faster than any power on a circle.
const AROUND: usize = 256;

fn circle() -> impl Iterator<Item = (f64, f64)> {
    (0..AROUND).map(|k| (2.0 * PI * (k as f64 + 0.5) / AROUND as f64).sin_cos())
}

/// Surface of what `m` makes of the unit sphere: ∫ |cof(m) n| dω, since cofactors turn and stretch elements of surface.
/// Exact for a similarity, to
/// 1e-4 for axes of 1 : 100.
fn stretched_sphere(m: &DMat3) -> f64 {
    let [x, y, z] = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
    let ring = |(cos, weight): (f64, f64)| {
        let sin = (1.0 - cos * cos).sqrt();
        let mean: f64 = circle().map(|(s, c)| (sin * (c * x + s * y) + cos * z).length()).sum();
        weight * mean / AROUND as f64
    };
    2.0 * PI * gauss_legendre().map(ring).sum::<f64>()
}

/// Surface of what `m` makes of a tube of radius and length 1 about x.
fn stretched_tube(m: &DMat3) -> f64 {
    let mean: f64 = circle().map(|(s, c)| m.x_axis.cross(c * m.z_axis - s * m.y_axis).length()).sum();
    2.0 * PI * mean / AROUND as f64
}

/// Nodes and weights on −1 … 1, by Newton's method from the asymptotic roots (Abramowitz and Stegun 22.16.6, 25.4.29).
fn gauss_legendre() -> impl Iterator<Item = (f64, f64)> {
    const NODES: usize = 96;
    (1..=NODES).map(|k| {
        let mut x = (PI * (k as f64 - 0.25) / (NODES as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut p) = (1.0, x);
            for n in 2..=NODES {
                let n = n as f64;
                (before, p) = (p, ((2.0 * n - 1.0) * x * p - (n - 1.0) * before) / n);
            }
            slope = NODES as f64 * (before - x * p) / (1.0 - x * x);
            x -= p / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}
