//! Faces: what each is optically, with photometry in both directions.

use super::look::LookReport;
use eyebox_base::Where;
use eyebox_scene::angular::Spread;
use eyebox_scene::{
    Angular, Coating, Emitter, Face, Finish, Grating, Part, Polarisation, PolarisedLight, Residual, Scene, Sensor,
    Shape, Spectrum, WavePlate,
};
use glam::DVec3;

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FaceReport {
    pub number: usize,
    pub finish: Finish,
    /// Of a finish that is an ordinary material.
    pub look: Option<LookReport>,
    /// Of a finish that is a grating or a wave plate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grating: Option<Grating>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wave_plate: Option<WavePlate>,
    /// Share of the light that gets through a polished face beside what else says it, linear Rec.709.
    pub tint: Option<[f64; 3]>,
    pub coating: Option<Coating>,
    /// In mesh units.
    pub shape: Shape,
    /// Metres per mesh unit.
    pub unit_m: f64,
    /// What was noted of this face, e.g. how well the shape fits its points.
    pub notes: Vec<String>,
    /// How well a recovered shape fits its points; `notes` say it in words.
    #[serde(skip)]
    pub fit: Option<Residual>,
    pub emitter: Option<EmitterReport>,
    pub slide: Option<SlideReport>,
    /// A map of the light that arrives is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Sensor>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EmitterReport {
    pub group: String,
    pub flux_lm: f64,
    /// Along the normal.
    pub luminance_cd_m2: f64,
    /// The greatest intensity of all its light, were it flat.
    pub peak_cd: f64,
    /// From the normal up to where the intensity is half of the peak; none for a profile of type A or B.
    pub half_angle_deg: Option<f64>,
    /// Of the face's triangles.
    pub area_m2: f64,
    pub angular: Angular,
    /// File of a measured distribution.
    pub profile: Option<String>,
    pub spectrum: Option<String>,
    pub polarisation: Option<PolarisedLight>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SlideReport {
    pub file: String,
    pub pixels: [usize; 2],
    pub size_m: [f64; 2],
    pub transmittance: f64,
    pub contrast: f64,
    pub polarisation: Option<Polarisation>,
    /// Mean transmittance of the picture, T_black included.
    pub mean_transmittance: f64,
}

/// What was noted of a face, and how well its shape fits.
type Said = (Vec<String>, Option<Residual>);

pub fn faces(scene: &Scene, part: &Part) -> Vec<FaceReport> {
    let unit_m = part.to_world.matrix3.determinant().abs().cbrt();
    let mut said: Vec<Said> = vec![Said::default(); part.faces.len()];
    for note in &scene.notes {
        if let Where::Part { path, face: Some(face) } = &note.at
            && *path == part.path
            && let Some((notes, fit)) = said.get_mut(*face)
        {
            notes.push(note.text.clone());
            *fit = fit.or(note.residual);
        }
    }
    let report = |(number, (face, (notes, fit))): (usize, (&Face, Said))| FaceReport {
        number,
        finish: face.finish,
        look: look(scene, part, face.finish),
        grating: face.finish.grating().map(|id| scene.grating(id).clone()),
        wave_plate: face.finish.wave_plate().map(|id| scene.wave_plate(id).clone()),
        tint: face.tint,
        coating: face.coating.and_then(|id| scene.coatings.get(id.index())).cloned(),
        shape: face.shape.clone(),
        unit_m,
        notes,
        fit,
        emitter: face.emitter.as_ref().map(|emitter| self::emitter(scene, emitter, area(scene, part, number))),
        sensor: face.sensor,
        slide: face.slide.and_then(|id| scene.slides.get(id.index())).map(|slide| {
            let mean = slide.pixels.iter().map(|s| f64::from(*s)).sum::<f64>() / slide.pixels.len().max(1) as f64;
            let black = slide.transmittance / slide.contrast;
            SlideReport {
                file: slide.file.clone(),
                pixels: [slide.width, slide.height],
                size_m: slide.size.map(|length| length * unit_m),
                transmittance: slide.transmittance,
                contrast: slide.contrast,
                polarisation: slide.polarisation,
                mean_transmittance: black + mean * (slide.transmittance - black),
            }
        }),
    };
    part.faces.iter().zip(said).enumerate().map(report).collect()
}

fn look(scene: &Scene, part: &Part, finish: Finish) -> Option<LookReport> {
    let colors = scene.meshes.get(part.mesh.index()).is_some_and(|mesh| !mesh.colors.is_empty());
    let surface = scene.surfaces.get(finish.surface()?.index())?;
    Some(LookReport::new(surface, colors))
}

fn emitter(scene: &Scene, emitter: &Emitter, area_m2: f64) -> EmitterReport {
    let spread = emitter.angular.spread(&scene.profiles);
    let unit = spread.map_or(f64::NAN, |spread| emitter.unit_cd(&spread, area_m2));
    let of = |value: fn(&Spread) -> f64| spread.as_ref().map_or(f64::NAN, |spread| unit * value(spread));
    let profile = match emitter.angular {
        Angular::Profile { profile, .. } => scene.profiles.get(profile.index()).map(|profile| profile.file.clone()),
        Angular::Lambert | Angular::CosN { .. } | Angular::Gauss { .. } => None,
    };
    EmitterReport {
        group: scene.groups.get(emitter.group.index()).map_or_else(String::new, |group| group.name.clone()),
        flux_lm: of(|spread| spread.whole),
        luminance_cd_m2: of(|spread| spread.normal) / area_m2,
        peak_cd: of(|spread| spread.peak),
        half_angle_deg: spread.and_then(|spread| spread.half_angle_rad).map(f64::to_degrees),
        area_m2,
        angular: emitter.angular,
        profile,
        spectrum: emitter.spectrum.as_ref().map(Spectrum::to_string),
        polarisation: emitter.polarisation,
    }
}

/// World area of a face's triangles, m².
pub fn area(scene: &Scene, part: &Part, face: usize) -> f64 {
    let Some(mesh) = scene.meshes.get(part.mesh.index()) else { return 0.0 };
    let triangles = mesh.faces.get(face).and_then(|range| {
        let end = range.first.checked_add(range.count)?;
        mesh.triangles.get(range.first as usize..end as usize)
    });
    let world = |index: u32| {
        let point = mesh.positions.get(index as usize)?;
        Some(part.to_world.transform_point3(DVec3::from_array(point.map(f64::from))))
    };
    let one = |&[a, b, c]: &[u32; 3]| Some((world(b)? - world(a)?).cross(world(c)? - world(a)?).length() / 2.0);
    triangles.unwrap_or_default().iter().filter_map(one).sum()
}
