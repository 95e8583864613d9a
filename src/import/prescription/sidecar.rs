//! The sidecar of a prescription: glasses, exact surfaces, mirrors, an eye at the stop, light at the image.

use super::solids::{Design, Kind, LensPart};
use super::{After, Prescription};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::glass;
use glam::{DAffine3, DVec3};
use std::fmt::Write;
use std::path::Path;

/// Luminance of what stands at the image, cd/m².
const IMAGE_CD_M2: f64 = 100.0;
/// The pupil where the file has none, m; that of an eye by room light.
const PUPIL_M: f64 = 4e-3;
/// Full field where the file has none, degrees.
pub(super) const FIELD_DEG: f64 = 20.0;

pub(super) fn write(
    prescription: &Prescription,
    design: &Design,
    frames: &[DAffine3],
    (path, asset): (&Path, &str),
) -> Result<String> {
    let mut out = format!(
        "# Made from {} by eyebox init: solids of the spaces of glass, with their exact surfaces.\n\n\
         schema = 1\nasset = {asset:?}\nunit = {}\n",
        path.file_name().unwrap_or_default().to_string_lossy(),
        prescription.unit_m
    );
    match prescription.wavelength_nm.map(|nm| (nm * 1e6).round() / 1e6) {
        Some(nm) if (360.0..=830.0).contains(&nm) => {
            let _ = writeln!(out, "wavelengths = {{ mono_nm = {nm} }}");
        }
        Some(nm) => {
            let _ = writeln!(out, "# Designed for {nm} nm, which no eye sees: traced at 555 nm.");
        }
        None => {}
    }
    out += "\n# Rims and the stop.\n[default]\nfinish = \"absorber\"\n";
    for part in &design.parts {
        self::part(&mut out, prescription, frames, part, path)?;
    }
    let wide = prescription.field_deg.map_or(FIELD_DEG, |[x, y]| 2.0 * x.max(y)).clamp(0.1, 170.0);
    let pupil = prescription.pupil.map_or(PUPIL_M, |pupil| pupil * prescription.unit_m);
    let at = design.eye_at * prescription.unit_m;
    let _ = write!(
        out,
        "\n# At the stop where light meets that first, else before the first surface.\n[eye]\n\
         position = [\"{} m\", \"{} m\", \"{} m\"]\nlook = [0, 0, 1]\nup = [0, 1, 0]\npupil_diameter = \"{pupil} m\"\n\
         focus_distance = \"inf\"\nfov_deg = {wide}\nresolution = [360, 180]\n",
        at.x, at.y, at.z
    );
    Ok(out)
}

fn part(
    out: &mut String,
    prescription: &Prescription,
    frames: &[DAffine3],
    part: &LensPart,
    path: &Path,
) -> Result<()> {
    let LensPart { name, kind, faces, frame } = part;
    let own = frames[*frame].inverse();
    let shape = |surface: usize| {
        let to_part = own * frames[surface];
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_part.transform_vector3(axis));
        prescription.surfaces[surface].profile.words(to_part.translation, axes)
    };
    let bind = |out: &mut String| {
        let _ = write!(out, "\n[[bind]]\npath = {name:?}\n");
    };
    if let Kind::Glass(surface) = kind {
        bind(out);
        *out += &medium(prescription, *surface, path)?;
    }
    for (face, surface) in faces.iter().enumerate() {
        let Some(surface) = surface else { continue };
        bind(out);
        let is_mirror = prescription.surfaces[*surface].after == After::Mirror;
        let _ =
            writeln!(out, "faces = [{face}]                          # line {}", prescription.surfaces[*surface].line);
        if let Some([lines, order]) = prescription.surfaces[*surface].grating {
            let [x, y, z] = (own * frames[*surface]).transform_vector3(DVec3::Y).to_array();
            let way = if is_mirror { "R" } else { "T" };
            let _ = writeln!(
                out,
                "finish = {{ kind = \"grating\", direction = [{x}, {y}, {z}], lines_per_mm = {lines}, \
                 orders = [{{ order = {order}, {way} = 1 }}] }}"
            );
            let _ = writeln!(out, "shape = {}", shape(*surface));
            continue;
        }
        let finish = match kind {
            Kind::Mirror => "finish = { kind = \"mirror\", reflectance = 1 }\n",
            Kind::Glass(_) if is_mirror => "finish = { kind = \"mirror\", reflectance = 1 }\n",
            Kind::Glass(_) => "finish = \"polished\"\n",
            Kind::Stop | Kind::Obscuration | Kind::Image => "finish = \"absorber\"\n",
        };
        *out += finish;
        match kind {
            Kind::Glass(_) | Kind::Mirror => {
                let _ = writeln!(out, "shape = {}", shape(*surface));
            }
            Kind::Stop | Kind::Obscuration => {}
            Kind::Image => {
                let _ = writeln!(out, "emitter = {{ group = \"image\", luminance_cd_m2 = {IMAGE_CD_M2} }}");
            }
        }
    }
    Ok(())
}

/// The line of a part's glass.
fn medium(prescription: &Prescription, surface: usize, path: &Path) -> Result<String> {
    let line = prescription.surfaces[surface].line;
    match &prescription.surfaces[surface].after {
        After::Model([n, 0.0]) => Ok(format!("ior = {n}\n")),
        After::Model([n, v]) => Ok(format!("abbe = [{n}, {v}]\n")),
        After::Glass { name, model } => match (find(name, &prescription.catalogues), model) {
            (Some(found), _) => Ok(format!("glass = {found:?}\n")),
            (None, Some([n, v])) => {
                Ok(format!("abbe = [{n}, {v}]                    # {name}, which no catalogue here has\n"))
            }
            (None, None) => {
                Err(Error::new(Where::Line { file: path.to_owned(), line }, format!("unknown glass `{name}`"))
                    .expected("a name that `eyebox glass` knows")
                    .nearest(name, glass::names())
                    .code(Code::NameUnknown))
            }
        },
        After::Private(rows) => {
            let rows: Vec<String> = rows.iter().map(|[nm, n]| format!("[{nm}, {n}, 0]")).collect();
            Ok(format!("index_table = [{}]\n", rows.join(", ")))
        }
        After::Air | After::Mirror => Ok(String::new()),
    }
}

/// What a glass is called here: of the makers that the file names, of any, or by what replaced it.
pub(super) fn find(name: &str, catalogues: &[String]) -> Option<&'static str> {
    // CODE V writes the maker behind the name.
    if let Some((own, maker)) = name.rsplit_once('_')
        && let Some(found) = glass::find(&format!("{maker} {own}"))
    {
        return Some(found.name);
    }
    // Lytkarino's glasses have the maker before the name.
    if let Some(own) = name.strip_prefix("LZ_")
        && let Some(found) = glass::find(&format!("LZOS {own}"))
    {
        return Some(found.name);
    }
    // Moulded glass has the melt's name, and lens files have short names for two materials.
    let name = name.strip_suffix("_MOLD").or(name.strip_suffix("_MOLD2014")).unwrap_or(name);
    let name = match name {
        // The last is Corning's code of it (HPFS 7980).
        "SILICA" | "F_SILICA" | "C79-80" => "fused silica",
        "ACRYLIC" => "PMMA",
        "POLYCARB" => "polycarbonate",
        "CAF2" => "CaF2",
        "MGF2" => "MgF2",
        "WATER" | "SEAWATER" => "water",
        other => other,
    };
    let maker =
        |catalogue: &String| catalogue.split('_').next().and_then(|maker| glass::find(&format!("{maker} {name}")));
    // The rows that were chosen by hand have no absorption, as rays in a design program have none.
    let own = glass::find(name).filter(|found| !found.name.contains(' ') && !found.name.contains('/'));
    let any = || glass::find(name).filter(|found| found.solid);
    let older =
        || glass::find(&format!("popular_glass/{name}/SCHOTT")).or_else(|| glass::find(&format!("SCHOTT N-{name}")));
    own.or_else(|| catalogues.iter().find_map(maker)).or_else(any).or_else(older).map(|found| found.name)
}
