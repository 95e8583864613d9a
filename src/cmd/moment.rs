//! Which of the things that one asset can be is meant: `--frame`, what it means for formats that count in seconds, `--variant`.

use crate::import::{LightUnits, ReadOptions, Rigs, VariantChoice};
use clap::Args;

// No doc comment: clap would take it for the description of every command that has these arguments.
#[derive(Args, Debug, Clone, Default)]
pub struct Moment {
    /// The moment at which an animated asset is taken: a time code of USD, a frame of glTF (see --fps). If not said, USD's own
    /// values without time, else the earliest; glTF's nodes as they are written.
    #[arg(long, value_name = "TIME", value_parser = super::parse_frame, allow_negative_numbers = true)]
    pub frame: Option<f64>,
    /// Frames a second of a glTF animation, which counts in seconds [default: 24]
    #[arg(long, value_name = "FPS", value_parser = parse_fps)]
    pub fps: Option<f64>,
    /// Which animation of a glTF asset, by its name or from 0; all of them at once if not said.
    #[arg(long, value_name = "NAME|N")]
    pub animation: Option<String>,
    /// Take this variant of a USD prim, e.g. /car{paint=red} (several may be given), or the variant of a glTF asset's materials with
    /// this name.
    #[arg(long = "variant", value_name = "PRIM{SET=NAME}|NAME", value_parser = VariantChoice::parse)]
    pub variants: Vec<VariantChoice>,
    /// What the strengths of the asset's own lights (UsdLux, KHR_lights_punctual) count in: nit, with candela and lux, as these formats
    /// say, or watt, as programs for films count and some write: 683 lm/W [default: nit]
    #[arg(long, value_name = "nit|watt", value_parser = LightUnits::parse)]
    pub light_units: Option<LightUnits>,
}

impl Moment {
    pub fn reading(&self) -> ReadOptions {
        ReadOptions {
            frame: self.frame,
            fps: self.fps,
            animation: self.animation.clone(),
            variants: self.variants.clone(),
            light_units: self.light_units.unwrap_or_default(),
            rigs: Rigs::No,
        }
    }
}

fn parse_fps(text: &str) -> std::result::Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(fps) if fps > 0.0 && fps.is_finite() => Ok(fps),
        Ok(_) | Err(_) => Err(format!("`{text}` is no number of frames a second; write e.g. 24 or 29.97")),
    }
}
