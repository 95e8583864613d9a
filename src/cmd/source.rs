//! The asset that a command looks at, as `--set` and `--frame` change it: the same arguments and the same import for all.

use super::moment::Moment;
use crate::base::{Result, Where};
use crate::check::facets;
use crate::check::rules::eb0103;
use crate::estimate::ShouldStop;
use crate::import::{Built, ImportOptions, ReadOptions, Set, import};
use crate::plan::adaptation::{Adapted, adapt};
use crate::plan::{Asked, Polarisation};
use crate::scene::{Note, Scene, Severity};
use clap::Args;
use std::path::PathBuf;

// No doc comment: clap would take it for the description of every command that has these arguments.
#[derive(Args, Debug, Clone)]
pub struct Source {
    /// Sidecar (*.optics.toml) or asset (.glb, .gltf, .usda, .usdc, .usdz).
    pub asset: PathBuf,
    /// Change an attribute: PART-OR-GROUP.ATTRIBUTE=VALUE, e.g. led.flux_lm=0.5, eye.pupil_diameter="3 mm".
    #[arg(long = "set", value_name = "TARGET.ATTRIBUTE=VALUE")]
    pub sets: Vec<String>,
    #[command(flatten)]
    pub moment: Moment,
    /// Memory for textures: where they would take more, all are read at a half, a quarter, … of their width and height,
    /// with a warning. Default 4096.
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..))]
    pub texture_memory: Option<u32>,
}

impl Source {
    /// The asset with its optics, changed as asked, and with a warning for each face whose facets an eye will see and each solid that is inside out. Faults: of a `--set` that cannot be read, and those of [`import`].
    pub fn import(&self) -> Result<Built> {
        let mut built = import(&self.asset, &self.options()?)?;
        built.scene.notes.extend(facets::warnings(&built.scene));
        built.scene.notes.extend(eb0103::warnings(&built.scene));
        Ok(built)
    }

    /// Gives an eye that adapts the pupil that its picture asks for, which a note says: of the resolution that is traced, with as
    /// much polarisation as is asked for. Once `stop` says true the search is left, and what is then traced is worthless.
    /// Faults: of a scene that cannot be traced.
    pub fn adapt_eye(&self, scene: &mut Scene, polarisation: Polarisation, stop: &ShouldStop<'_>) -> Result<()> {
        if !scene.eye.adapts {
            return Ok(());
        }
        let asked = Asked { polarisation, ..Asked::default() };
        if let Some(Adapted { diameter_m, luminance_cd_m2, field_deg2, age }) = adapt(scene, asked, stop)? {
            let text = format!(
                "pupil of {:.2} mm: both eyes, {age} years old, are adapted to the picture's mean of {luminance_cd_m2:.4} cd/m² \
                 over {field_deg2:.4} deg² (Watson and Yellott 2012)",
                1e3 * diameter_m
            );
            scene.notes.push(Note::assumed(Where::file(&self.asset), text));
        }
        Ok(())
    }

    fn options(&self) -> Result<ImportOptions> {
        let texture_bytes = self.texture_memory.map(|mib| u64::from(mib) << 20);
        Ok(ImportOptions { sets: sets(&self.sets)?, reading: self.reading(), texture_bytes })
    }

    /// How the asset is read where its optics are not asked for.
    pub fn reading(&self) -> ReadOptions {
        self.moment.reading()
    }
}

/// What nobody who looks at a result should miss of its scene: warnings, and what was assumed.
pub fn told(scene: &Scene) -> Vec<String> {
    let is_warning = |note: &&Note| note.severity == Severity::Warning;
    let warnings = scene.notes.iter().filter(is_warning).map(|note| format!("warning: {}: {}", note.at, note.text));
    let assumed =
        scene.notes.iter().filter(|note| note.assumed).map(|note| format!("note: {}: {}", note.at, note.text));
    warnings.chain(assumed).collect()
}

/// What `--set` asks for, in order.
pub fn sets(texts: &[String]) -> Result<Vec<Set>> {
    texts.iter().map(|text| Set::parse(text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser, Debug)]
    struct Line {
        #[command(flatten)]
        source: Source,
    }

    fn of(words: &[&str]) -> Source {
        Line::try_parse_from([&["eyebox"], words].concat()).unwrap().source
    }

    /// A bare asset is traced with an eye and a light that nobody has said: everybody is told.
    #[test]
    fn what_is_assumed_is_told() {
        let bare = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud_direct.glb");
        let scene = of(&[bare]).import().unwrap().scene;
        let lines = told(&scene);
        for said in ["there is no eye: a pinhole", "there is no light: an overcast sky"] {
            assert!(lines.iter().any(|line| line.starts_with("note: ") && line.contains(said)), "{said}: {lines:?}");
        }
        // A default of a row is for the record alone.
        assert!(lines.iter().all(|line| !line.contains("is not said")), "{lines:?}");
    }

    #[test]
    fn sets_and_frame_reach_the_scene() {
        let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.usda");
        let plain = of(&[sample]).import().unwrap().scene;
        let changed = of(&[sample, "--set", "eye.fov_deg=20", "--frame", "-3"]);
        assert_eq!(changed.reading().frame, Some(-3.0));
        let changed = changed.import().unwrap().scene;
        assert_ne!(plain.eye, changed.eye);
        assert_ne!(plain.hash, changed.hash);
        let fault = of(&[sample, "--set", "eye.fov_deg"]).import().unwrap_err().to_string();
        assert!(fault.contains("--set"), "{fault}");
        assert!(Line::try_parse_from(["eyebox", sample, "--frame", "inf"]).is_err());
    }
}

#[cfg(test)]
mod turned_tests {
    use crate::check::rules::eb0103;
    use crate::import::testing::assembly;
    use crate::import::{Assembly, build, toml};
    use crate::scene::Scene;
    use std::path::Path;

    const GLASS: &str = "schema = 1
wavelengths = { mono_nm = 550 }
[eye]
position = [\"0 mm\", \"0 mm\", \"0 mm\"]
look = [0, 0, -1]
up = [0, 1, 0]
fov_deg = 12
[default]
finish = \"polished\"
ior = 1.5
";

    fn built(assembly: Assembly) -> Scene {
        let sheet = toml::parse(GLASS, Path::new("a.optics.toml")).unwrap();
        build(assembly, Some(&sheet), &[]).unwrap().scene
    }

    /// A box of glass is said to be inside out if its triangles are turned round, and only then.
    #[test]
    fn a_solid_that_is_inside_out_is_said_before_it_is_traced() {
        assert_eq!(eb0103::warnings(&built(assembly(&["LENS"]))), []);
        let mut turned = assembly(&["LENS"]);
        turned.meshes[0].mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        let found = eb0103::warnings(&built(turned));
        assert!(found.len() == 1 && found[0].text.contains("they look inwards"), "{found:?}");
    }
}
