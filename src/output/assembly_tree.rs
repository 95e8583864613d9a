//! An assembly as `inspect` reports it: what each part is optically, where it is, what shines, and what was noted.

mod face;
mod lamp;
mod look;
mod parts;
mod text;
mod words;

#[cfg(test)]
mod tests;

pub use face::{EmitterReport, FaceReport, SlideReport};
pub use lamp::LampReport;
pub use look::{LookReport, TextureReport};
pub use parts::{Bounds, MediumReport, PartReport};

use eyebox_base::Error;
use eyebox_scene::{Eye, Note, Scene, Severity, Sky, Wavelengths};

/// The report. Lengths of the world in metres, shapes in mesh units as in the scene. In JSON an infinite number is null.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct AssemblyTree {
    pub name: String,
    /// Metres per unit of the asset.
    pub unit_m: f64,
    pub wavelengths: Wavelengths,
    pub traced_nm: f64,
    pub bounds: Option<Bounds>,
    pub meshes: usize,
    /// In the order of the file; the tree is in their paths.
    pub parts: Vec<PartReport>,
    /// None where the optical attributes could not be used: see `fault`.
    pub optics: Option<OpticsReport>,
    /// Why there are no optics.
    pub fault: Option<Error>,
    /// Warnings first.
    pub notes: Vec<Note>,
}

/// What belongs to the whole scene.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct OpticsReport {
    pub groups: Vec<GroupReport>,
    /// Every lamp: faces in the order of their parts, then lights, then the sky.
    pub lamps: Vec<LampReport>,
    pub sky: Option<SkyReport>,
    pub eye: Eye,
}

/// The emitting faces and the lights of one light group.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct GroupReport {
    pub name: String,
    pub faces: usize,
    /// Lamps that are no faces.
    pub lights: usize,
    /// Of the faces and of points; a distant lamp's depends on what it shines on.
    pub flux_lm: f64,
    /// The greatest intensity of a face or a point.
    pub peak_cd: Option<f64>,
    /// Across the light of its distant lamps together.
    pub illuminance_lx: Option<f64>,
    /// Least and greatest luminance along the normal, cd/m².
    pub luminance_cd_m2: Option<[f64; 2]>,
    /// Least and greatest half angle at half of the peak.
    pub half_angle_deg: Option<[f64; 2]>,
}

impl GroupReport {
    fn add(&mut self, lamp: &LampReport) {
        self.flux_lm += lamp.flux_lm.unwrap_or(0.0);
        self.peak_cd = self.peak_cd.into_iter().chain(lamp.peak_cd).reduce(f64::max);
        self.illuminance_lx = self.illuminance_lx.into_iter().chain(lamp.illuminance_lx).reduce(|a, b| a + b);
        for (range, value) in
            [(&mut self.luminance_cd_m2, lamp.luminance_cd_m2), (&mut self.half_angle_deg, lamp.half_angle_deg)]
        {
            let Some(value) = value else { continue };
            let [least, greatest] = range.unwrap_or([value, value]);
            *range = Some([least.min(value), greatest.max(value)]);
        }
    }
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SkyReport {
    pub group: String,
    pub file: String,
    pub size: [usize; 2],
    /// Least, mean over the sphere, and greatest luminance, cd/m².
    pub least_cd_m2: f64,
    pub mean_cd_m2: f64,
    pub greatest_cd_m2: f64,
}

impl AssemblyTree {
    /// The report of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut tree = Self::geometry(scene);
        for (report, part) in tree.parts.iter_mut().zip(&scene.parts) {
            report.medium = parts::medium(scene, part);
            report.faces = face::faces(scene, part);
        }
        let mut groups: Vec<GroupReport> = (scene.groups.iter())
            .map(|group| GroupReport {
                name: group.name.clone(),
                faces: 0,
                lights: 0,
                flux_lm: 0.0,
                peak_cd: None,
                illuminance_lx: None,
                luminance_cd_m2: None,
                half_angle_deg: None,
            })
            .collect();
        let mut lamps = Vec::new();
        for (report, part) in tree.parts.iter().zip(&scene.parts) {
            for (found, face) in report.faces.iter().zip(&part.faces) {
                let (Some(emits), Some(emitter)) = (&found.emitter, &face.emitter) else { continue };
                let Some(group) = groups.get_mut(emitter.group.index()) else { continue };
                let lamp = lamp::of_face(&part.path, found.number, emits);
                group.faces += 1;
                group.add(&lamp);
                lamps.push(lamp);
            }
        }
        for light in &scene.lights {
            let lamp = lamp::of_light(scene, light);
            if let Some(group) = groups.get_mut(light.group.index()) {
                group.lights += 1;
                group.add(&lamp);
            }
            lamps.push(lamp);
        }
        // The sky's group has no faces unless a lamp shares it.
        let sky_group = scene.sky.as_ref().map(|sky| sky.group.index());
        let mut index = 0..;
        groups.retain(|group| index.next() != sky_group || group.faces + group.lights > 0);
        let sky = scene.sky.as_ref().map(|sky| self::sky(scene, sky));
        if let Some(sky) = &sky {
            lamps.push(LampReport {
                group: sky.group.clone(),
                name: sky.file.clone(),
                kind: "sky",
                flux_lm: None,
                peak_cd: None,
                luminance_cd_m2: Some(sky.greatest_cd_m2),
                half_angle_deg: None,
                illuminance_lx: None,
            });
        }
        tree.optics = Some(OpticsReport { groups, lamps, sky, eye: scene.eye.clone() });
        tree
    }

    /// Only what the geometry says, since `fault` forbids more.
    pub fn without_optics(scene: &Scene, fault: &Error) -> Self {
        AssemblyTree { fault: Some(fault.clone()), ..Self::geometry(scene) }
    }

    fn geometry(scene: &Scene) -> Self {
        let parts = parts::parts(scene);
        let bounds = parts.iter().filter_map(|part| part.bounds).reduce(Bounds::with);
        let mut notes = scene.notes.clone();
        // Stable: in each severity the order of the import.
        notes.sort_by_key(|note| std::cmp::Reverse(note.severity));
        AssemblyTree {
            name: scene.name.clone(),
            unit_m: scene.unit_m,
            wavelengths: scene.wavelengths,
            traced_nm: scene.wavelengths.traced_nm(),
            bounds,
            meshes: scene.meshes.len(),
            parts,
            optics: None,
            fault: None,
            notes,
        }
    }

    pub fn warnings(&self) -> usize {
        self.notes.iter().filter(|note| note.severity == Severity::Warning).count()
    }

    /// The tree for people; parts and faces that are alike take one line with their count.
    pub fn text(&self) -> String {
        text::text(self)
    }
}

/// Mean over the sphere: rows weigh by the sine of their distance from the pole.
fn sky(scene: &Scene, sky: &Sky) -> SkyReport {
    let (mut least, mut greatest, mut sum, mut weights) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0);
    for (row, pixels) in sky.luminance.chunks(sky.width.max(1)).enumerate() {
        let weight = ((row as f64 + 0.5) / sky.height.max(1) as f64 * std::f64::consts::PI).sin();
        for &pixel in pixels {
            let luminance = f64::from(pixel);
            (least, greatest) = (least.min(luminance), greatest.max(luminance));
            sum += weight * luminance;
            weights += weight;
        }
    }
    SkyReport {
        group: scene.groups.get(sky.group.index()).map_or_else(String::new, |group| group.name.clone()),
        file: sky.file.clone(),
        size: [sky.width, sky.height],
        least_cd_m2: least,
        mean_cd_m2: sum / weights,
        greatest_cd_m2: greatest,
    }
}
