//! Where things stand: units, frames of reference, the eye, and exact surfaces fitted to faces.

use super::assembly::{Assembly, Camera};
use super::defaults;
use super::enclosed::Bodies;
use super::fit::{self, Fitted};
use super::optics::{self, EyeSpec, Lens, Pose};
use super::select;
use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{Eye, Mesh, Note, Residual, Shape};
use glam::{DAffine3, DMat3, DVec3};

/// Node → world in metres.
pub fn in_metres(to_world: &DAffine3, unit_m: f64, axes: &DMat3) -> DAffine3 {
    DAffine3 { matrix3: *axes * (to_world.matrix3 * unit_m), translation: *axes * (to_world.translation * unit_m) }
}

/// The scale of a similarity; none if axes are scaled differently or not orthogonal (beyond 1e-6, what f32 files round).
pub fn uniform_scale(to_world: &DAffine3) -> Option<f64> {
    let m = to_world.matrix3;
    let scale = m.determinant().abs().cbrt();
    let product = m.transpose() * m;
    let square = scale * scale;
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * square;
    let axes = [product.x_axis, product.y_axis, product.z_axis];
    let ok = (0..3).all(|i| (0..3).all(|j| near(axes[i][j], if i == j { square } else { 0.0 })));
    (ok && scale > 0.0 && scale.is_finite()).then_some(scale)
}

/// Axes of a frame → world: a rotation. Faults: no such node, or its axes are skewed or mirrored.
pub fn frame_rotation(assembly: &Assembly, frame: Option<&(String, Where)>) -> Result<DMat3> {
    Ok(frame_of(assembly, frame)?.matrix3)
}

fn frame_of(assembly: &Assembly, frame: Option<&(String, Where)>) -> Result<DAffine3> {
    let Some((name, at)) = frame else { return Ok(DAffine3::from_mat3(assembly.axes)) };
    let index = select::node(assembly, name, at)?;
    let Some(node) = assembly.nodes.get(index) else { return Ok(DAffine3::from_mat3(assembly.axes)) };
    let m = node.to_world.matrix3;
    let axes =
        DMat3::from_cols(m.x_axis.normalize_or_zero(), m.y_axis.normalize_or_zero(), m.z_axis.normalize_or_zero());
    let orthogonal = (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() <= 1e-6);
    if !orthogonal || axes.determinant() < 0.0 {
        return Err(Error::new(at.clone(), format!("the axes of frame `{name}` are skewed, mirrored or flat"))
            .expected("a node that is moved, rotated and scaled only"));
    }
    Ok(DAffine3 { matrix3: assembly.axes * axes, translation: assembly.axes * node.to_world.translation })
}

/// The eye that `value` and the asset's camera describe; none if neither does.
/// Faults: incomplete or contradictory descriptions.
/// `bare`: nobody has said what parts are optically, so that cameras are pinholes and pictures larger; and cameras that stand
/// inside of something without light are passed over.
pub fn eye(bodies: &Bodies, value: Option<&Value>, bare: bool, notes: &mut Vec<Note>) -> Result<Option<Eye>> {
    let Bodies { assembly, unit_m, .. } = *bodies;
    let usable = |camera: &&Camera| {
        let hidden = || bodies.about(assembly.axes * camera.to_world.translation * unit_m);
        let dark = if bare && camera.yfov.is_some() { hidden() } else { None };
        notes.extend(dark.map(|part| {
            let text =
                format!("the asset's camera `{}` stands inside of {part}, where no light comes: not used", camera.name);
            Note::warning(Where::file(&assembly.file), text)
        }));
        camera.yfov.is_some() && dark.is_none()
    };
    let cameras: Vec<&Camera> = assembly.cameras.iter().filter(usable).collect();
    let camera = cameras.first().copied();
    let empty = Value::new(Data::Table(Vec::new()), Where::file(&assembly.file));
    let value = match (value, camera) {
        (Some(value), _) => value,
        (None, Some(_)) => &empty,
        (None, None) => return Ok(None),
    };
    let lens = camera.map_or(Lens::default(), |camera| Lens {
        pupil_diameter_m: camera.pupil.map(|pupil| pupil * unit_m).or(bare.then_some(0.0)),
        focus_distance_m: camera.focus.map(|focus| focus * unit_m),
    });
    let assumes = bare && camera.is_none();
    let lens = if assumes { Lens { pupil_diameter_m: Some(0.0), ..lens } } else { lens };
    let spec = optics::eye(value, lens, notes)?;
    if assumes && spec.pose.is_none() {
        // Somebody has said how large the picture is, or how wide, and leaves the rest to us.
        let resolution = spec.resolution.unwrap_or(defaults::RESOLUTION);
        let fov_deg = spec.fov_deg.unwrap_or(defaults::FOV_DEG);
        if let Some((eye, note)) = defaults::eye(assembly, unit_m, resolution, fov_deg) {
            notes.push(note);
            let EyeSpec { pupil_diameter_m, adapts, focus_distance_m, age, limits, .. } = spec;
            return Ok(Some(Eye { pupil_diameter_m, adapts, focus_distance_m, age, limits, ..eye }));
        }
    }
    // A camera gives what the eye leaves open only if the eye says nothing of where it stands.
    let camera = camera.filter(|_| spec.pose.is_none());
    let resolution = match (spec.resolution, camera.and_then(|camera| camera.aspect)) {
        (Some(given), _) => given,
        (None, aspect) => {
            let [width, height] = if bare { defaults::RESOLUTION } else { [360, 180] };
            let height = aspect.map_or(height as f64, |aspect| (width as f64 / aspect).round().clamp(1.0, 65536.0));
            let text = format!("`resolution` of eye is not said: {width} x {height}");
            notes.push(Note::info(spec.at.clone(), text));
            [width, height as usize]
        }
    };
    let (position, look, up) = match (&spec.pose, camera) {
        (Some(Pose { position_m, look, up, frame }), _) => {
            let frame = frame_of(assembly, frame.as_ref())?;
            (frame.translation * unit_m + frame.matrix3 * *position_m, frame.matrix3 * *look, frame.matrix3 * *up)
        }
        (None, Some(camera)) => {
            let m = assembly.axes * camera.to_world.matrix3;
            let look = (-m.z_axis).normalize_or_zero();
            let up = (m.y_axis - m.y_axis.dot(look) * look).normalize_or_zero();
            if look == DVec3::ZERO || up == DVec3::ZERO {
                return Err(Error::new(spec.at.clone(), format!("camera `{}` has no direction", camera.name))
                    .code(Code::EyeImpossible));
            }
            let more = if cameras.len() > 1 { ", the first of several" } else { "" };
            let text = format!("the eye is the asset's camera `{}`{more}", camera.name);
            notes.push(Note::info(spec.at.clone(), text));
            (assembly.axes * camera.to_world.translation * unit_m, look, up)
        }
        (None, None) => {
            return Err(Error::new(
                spec.at.clone(),
                "eye has no `position`, `look` and `up`, and the asset has no perspective camera",
            )
            .expected("position = [\"0 mm\", \"0 mm\", \"0 mm\"], look = [0, 0, -1], up = [0, 1, 0]")
            .code(Code::EyeImpossible));
        }
    };
    let [width, height] = resolution.map(|pixels| pixels as f64);
    let fov_deg = match (spec.fov_deg, camera.and_then(|camera| camera.yfov)) {
        (Some(given), _) => given,
        // The camera's is vertical.
        (None, Some(yfov)) => (2.0 * (width / height * (yfov / 2.0).tan()).atan()).to_degrees(),
        (None, None) => {
            return Err(Error::new(spec.at.clone(), "eye has no `fov_deg`")
                .expected("the full horizontal field of view, a number above 0 and below 180 in deg")
                .code(Code::EyeImpossible));
        }
    };
    if !(fov_deg > 0.0 && fov_deg < 180.0 && position.is_finite()) {
        return Err(Error::new(spec.at.clone(), format!("the camera's field of view of {fov_deg}° can't be used"))
            .expected("a number above 0 and below 180 in deg")
            .code(Code::EyeImpossible));
    }
    Ok(Some(Eye {
        position,
        look: look.normalize(),
        up: up.normalize(),
        pupil_diameter_m: spec.pupil_diameter_m,
        adapts: spec.adapts,
        focus_distance_m: spec.focus_distance_m,
        fov_deg,
        resolution,
        age: spec.age,
        limits: spec.limits,
    }))
}

/// Which face a fit is for, and where it is asked for.
#[derive(Debug, Clone, Copy)]
pub struct FacePlace<'a> {
    pub part: &'a str,
    pub number: usize,
    pub at: &'a Where,
}

/// How a face is to be fitted.
#[derive(Debug, Clone, Copy)]
pub struct FitOrder {
    pub surface: Option<fit::Kind>,
    /// Largest distance of a point, µm.
    pub tolerance_um: f64,
    /// Replace what was found; the radii in mesh units.
    pub radius: Option<f64>,
    pub conic: Option<f64>,
    pub tube_radius: Option<f64>,
}

/// Fits the surface of a face; `metres` is the length of a mesh unit. The fit and its residual are noted.
/// Faults: the points can't be fitted, or the surface misses the tolerance.
pub fn fitted(mesh: &Mesh, place: FacePlace<'_>, order: FitOrder, metres: f64, notes: &mut Vec<Note>) -> Result<Shape> {
    let range = mesh.faces.get(place.number).copied();
    let end = range.and_then(|range| range.first.checked_add(range.count));
    let triangles = range.zip(end).and_then(|(range, end)| mesh.triangles.get(range.first as usize..end as usize));
    let Some(triangles) = triangles.filter(|triangles| !triangles.is_empty()) else {
        let what = format!("part {} face {} has no triangles to fit", place.part, place.number);
        return Err(Error::new(place.at.clone(), what));
    };
    // The tolerance is physical, the mesh has its own unit.
    let tolerance = order.tolerance_um * 1e-6 / metres;
    let found = fit::fit(&mesh.positions, triangles, order.surface, tolerance).map_err(|error| {
        let mut fault = error.fault(place.at.clone(), metres);
        fault.what = format!("part {} face {}: {}", place.part, place.number, fault.what);
        fault
    })?;
    // Which side the centre lies on is the mesh's business: the magnitude counts.
    let signed = |found: f64, given: Option<f64>| given.map_or(found, |given| found.signum() * given.abs());
    let stray = |what: &str| {
        let kind = found.surface.kind();
        Error::new(
            place.at.clone(),
            format!("part {} face {} is a {kind}; it has no {what} to replace", place.part, place.number),
        )
    };
    let (shape, text) = match found.surface.clone() {
        Fitted::Plane { vertex, axis } => {
            if order.radius.is_some() || order.conic.is_some() {
                return Err(stray("radius or conic"));
            }
            (Shape::Plane { vertex, axis }, "plane".to_owned())
        }
        Fitted::Sphere { vertex, axis, radius } => {
            let radius = signed(radius, order.radius);
            match order.conic {
                None => (Shape::Sphere { vertex, axis, radius }, format!("sphere of radius {radius}")),
                Some(conic) => (
                    Shape::Conic { vertex, axis, radius, conic },
                    format!("conic of radius {radius}, conic constant {conic}"),
                ),
            }
        }
        Fitted::Conic { vertex, axis, radius, conic } => {
            let (radius, conic) = (signed(radius, order.radius), order.conic.unwrap_or(conic));
            (Shape::Conic { vertex, axis, radius, conic }, format!("conic of radius {radius}, conic constant {conic}"))
        }
        Fitted::Cylinder { vertex, axis, x, radius } => {
            let radius = signed(radius, order.radius);
            (Shape::Cylinder { vertex, axis, x, radius }, format!("cylinder of radius {radius}"))
        }
        Fitted::Toroid { vertex, axis, x, radius, tube_radius } => {
            let (radius, tube_radius) = (signed(radius, order.radius), signed(tube_radius, order.tube_radius));
            let text = format!("toroid of radius {radius}, tube radius {tube_radius}");
            (Shape::Toroid { vertex, axis, x, radius, tube_radius }, text)
        }
        Fitted::Asphere { .. } | Fitted::XyPoly { .. } | Fitted::Zernike { .. } | Fitted::Bspline { .. } => {
            if order.radius.is_some() || order.conic.is_some() || order.tube_radius.is_some() {
                // Its terms hold with the base that was found only.
                return Err(stray("radius, conic or tube_radius"));
            }
            (found.surface.shape(), terms(&found))
        }
    };
    match shape {
        Shape::Toroid { .. } if order.conic.is_some() => return Err(stray("conic")),
        Shape::Cylinder { .. } if order.conic.is_some() => return Err(stray("conic")),
        Shape::Toroid { .. } => {}
        Shape::Mesh
        | Shape::Plane { .. }
        | Shape::Sphere { .. }
        | Shape::Conic { .. }
        | Shape::Asphere { .. }
        | Shape::Cylinder { .. }
        | Shape::XyPoly { .. }
        | Shape::Zernike { .. }
        | Shape::Bspline { .. } => {
            if order.tube_radius.is_some() {
                return Err(stray("tube_radius"));
            }
        }
    }
    let um = metres * 1e6;
    let replaced = if order.radius.is_some() || order.conic.is_some() || order.tube_radius.is_some() {
        " (partly replaced)"
    } else {
        ""
    };
    let residual = Residual {
        points: found.points,
        rms_um: found.rms * um,
        greatest_um: found.max_residual * um,
        known: found.open.map(|open| open.known(metres)),
    };
    let at = Where::Part { path: place.part.to_owned(), face: Some(place.number) };
    notes.push(Note::fitted(at, &format!("{text}{replaced}"), residual));
    Ok(shape)
}

/// Number and kind of a freeform's terms.
fn terms(found: &fit::Fit) -> String {
    match &found.surface {
        Fitted::Asphere { radius, conic, even, .. } => {
            format!("asphere of radius {radius}, conic constant {conic}, {} even terms", even.len())
        }
        Fitted::XyPoly { radius, coeffs, .. } => format!("xy_poly of {} terms on a radius of {radius}", coeffs.len()),
        Fitted::Zernike { radius, coeffs, .. } => format!("zernike of {} terms on a radius of {radius}", coeffs.len()),
        Fitted::Bspline { radius, spans: [a, b], .. } => format!("bspline of {a} x {b} spans on a radius of {radius}"),
        Fitted::Plane { .. }
        | Fitted::Sphere { .. }
        | Fitted::Conic { .. }
        | Fitted::Cylinder { .. }
        | Fitted::Toroid { .. } => found.surface.kind().to_string(),
    }
}
