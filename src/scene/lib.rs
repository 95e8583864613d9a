//! Floor 1: the scene as plain data. Importers fill it through the builder of `eyebox-import`; after that nobody can
//! tell which format an assembly came from. Lengths of the world are metres; a mesh keeps the units of its file.

mod abg; // scatter of polished surfaces
pub mod angular; // how a face's light spreads
pub mod annotation; // a sidecar as rows of the asset itself
pub mod assembly; // what a format reader delivers
pub mod attribute;
pub mod coating;
pub mod dispersion;
pub mod efficiency_table; // of gratings
pub mod eye;
pub mod finish;
pub mod glass;
pub mod grating;
pub mod laminate; // films on glass become parts
pub mod lamp;
pub mod light_shapes; // meshes of the formats' round and flat lights
pub mod mesh;
pub mod motion; // how an assembly moves
pub mod note;
pub mod part;
pub mod profile; // measured intensity distributions
pub mod ray_set; // lamps as rays of a file
pub mod scatter_table;
pub mod sensor;
pub mod shape;
pub mod slide;
pub mod spectrum;
pub mod surface; // how ordinary materials look
pub mod texture;
pub mod user_property; // what authors say beside the format
pub mod value;
pub mod wave_plate;

pub use abg::AbgLaw;
pub use coating::{Coating, CoatingLaw, CoatingTable, FilmLayer};
pub use dispersion::{Dispersion, Formula, FormulaKind};
pub use efficiency_table::{Efficiency, EfficiencyGrid, EfficiencyTable};
pub use eye::{BinocularLimits, Eye};
pub use finish::{Finish, ProjectedAxis};
pub use grating::{Grating, Order, Orders};
pub use laminate::FilmBase;
pub use lamp::{Angular, Beacon, BeaconForm, Emitter, Photometry, PolarisedLight, Sky, SpotCone};
pub use mesh::{FaceRange, Mesh};
pub use note::{Known, Note, Residual, Severity};
pub use part::{Absorption, Face, Medium, Part};
pub use profile::LuminousProfile;
pub use ray_set::{LampRay, RaySet};
pub use scatter_table::ScatterTable;
pub use sensor::Sensor;
pub use shape::Shape;
pub use slide::{Polarisation, Slide};
pub use spectrum::{Led, PowerDistribution, Spectrum};
pub use surface::{Anisotropy, AnisotropyLaw, CoatNormal, Film, LEAST_ALPHA, Opacity, StandardSurface};
pub use texture::{Colour, Scalar, Texture, TextureInput};
pub use wave_plate::{Retardance, WavePlate};

use eyebox_base::Shared;
use eyebox_base::ids::{
    CoatingId, GratingId, GroupId, MediumId, MeshId, PartId, ScatterId, SlideId, SurfaceId, WavePlateId,
};

/// At which wavelengths the scene is defined.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wavelengths {
    /// One wavelength, nm.
    Mono { nm: f64 },
    /// The visible range, 360 to 830 nm.
    Visible,
}

impl Wavelengths {
    /// Peak of photopic vision (CIE 1931 V(λ)), nm.
    pub const VISIBLE_NM: f64 = 555.0;
    /// The wavelength that is traced, or at which optical constants are shown, nm.
    pub fn traced_nm(self) -> f64 {
        match self {
            Wavelengths::Mono { nm } => nm,
            Wavelengths::Visible => Self::VISIBLE_NM,
        }
    }
}

/// A light group: light that is stored in layers of its own.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Group {
    /// `[A-Za-z][A-Za-z0-9_]*`, part of layer names.
    pub name: String,
}

/// An assembly with its optical attributes, its lamps and its eye.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Scene {
    /// Name of the asset, for messages and the header.
    pub name: String,
    /// Metres per unit of the asset's coordinates (already contained in every `Part::to_world`).
    pub unit_m: f64,
    pub wavelengths: Wavelengths,
    pub meshes: Vec<Shared<Mesh>>,
    pub parts: Vec<Part>,
    pub media: Vec<Medium>,
    pub coatings: Vec<Coating>,
    pub slides: Vec<Slide>,
    /// Measured scattering that finishes refer to.
    pub scatters: Vec<ScatterTable>,
    /// Wave plates that finishes refer to.
    pub wave_plates: Vec<WavePlate>,
    /// Gratings that finishes refer to.
    pub gratings: Vec<Grating>,
    /// Standard surfaces that finishes refer to.
    pub surfaces: Vec<Shared<StandardSurface>>,
    pub groups: Vec<Group>,
    /// Measured intensity distributions that lamps refer to.
    pub profiles: Vec<LuminousProfile>,
    /// Lamps that are no faces.
    pub lights: Vec<Beacon>,
    pub sky: Option<Sky>,
    pub eye: Eye,
    /// What was found, repaired, defaulted or not understood on the way in.
    pub notes: Vec<Note>,
    /// Hash of every byte that the scene was made of (asset, sidecar, images, `--set`), hex.
    pub hash: String,
}

impl Scene {
    /// The spectrum of each group's light (none for a group without lamps), if all of its lamps have the same; else the
    /// name of a group where they differ. What says nothing shines like D65.
    pub fn spectra_of_groups(&self) -> Result<Vec<Option<Spectrum>>, String> {
        let mut groups: Vec<Option<Spectrum>> = vec![None; self.groups.len()];
        let faces = self.parts.iter().flat_map(|part| &part.faces).filter_map(|face| face.emitter.as_ref());
        let lamps = faces.map(|emitter| (emitter.group, emitter.spectrum.as_ref()));
        let lights = self.lights.iter().map(|light| (light.group, light.spectrum.as_ref()));
        let white = Spectrum::Rgb([1.0; 3]);
        let sky = self.sky.iter().map(|sky| (sky.group, Some(&white)));
        for (group, spectrum) in lamps.chain(lights).chain(sky) {
            let spectrum = spectrum.unwrap_or(&Spectrum::D65);
            match &mut groups[group.index()] {
                Some(known) if known != spectrum => return Err(self.group(group).name.clone()),
                Some(_) => {}
                unknown @ None => *unknown = Some(spectrum.clone()),
            }
        }
        Ok(groups)
    }
}

macro_rules! table {
    ($($method:ident: $id:ty => $field:ident: $item:ty),* $(,)?) => {
        impl Scene {
            $(pub fn $method(&self, id: $id) -> &$item { &self.$field[id.index()] })*
        }
    };
}
table! {
    mesh: MeshId => meshes: Mesh,
    part: PartId => parts: Part,
    medium: MediumId => media: Medium,
    coating: CoatingId => coatings: Coating,
    slide: SlideId => slides: Slide,
    scatter: ScatterId => scatters: ScatterTable,
    wave_plate: WavePlateId => wave_plates: WavePlate,
    grating: GratingId => gratings: Grating,
    surface: SurfaceId => surfaces: StandardSurface,
    group: GroupId => groups: Group,
}
