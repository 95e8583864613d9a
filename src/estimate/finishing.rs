//! What is made of films besides adding them up: everything that the frame takes from the scene and the command line, so
//! that shards of a run can carry it to where they are merged.

use super::aov;
use super::picture::{infos, keep_layers};
use super::render_vars::{self, Named};
use super::run::Films;
use super::slides::{self, Told};
use eyebox_base::colour::ColourSpace;
use eyebox_base::ids::GroupId;
use eyebox_base::{Error, Result, Where};
use eyebox_film::accumulate::Film;
use eyebox_film::aov::Aov;
use eyebox_film::crop::Crop;
use eyebox_film::diffraction::Diffraction;
use eyebox_film::finish::{Finished, GroupInfo, finish_through};
use eyebox_film::frame::{Channel, Frame, Meta};
use eyebox_film::layer::Layer;
use eyebox_film::plan::Plan;
use eyebox_film::variance;
use eyebox_output::exr::{COMPRESSION, HALF, LAYER_PREFIX, MULTI_PART};
use eyebox_scene::Scene;
use std::collections::HashSet;

/// How films become the frame that is written.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Finishing {
    /// Width and height, pixels.
    pub size: [usize; 2],
    pub groups: Vec<GroupInfo>,
    pub space: ColourSpace,
    pub diffraction: Option<Diffraction>,
    pub wanted: Wanted,
}

/// Which layers are written, and how.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Wanted {
    /// Layers to keep; all if empty.
    pub layers: Vec<String>,
    /// Layers to keep under other names.
    pub named: Vec<Named>,
    /// Only the layers of `named` are wanted, even if there are none.
    pub only_named: bool,
    /// Sums of shares under names of their own.
    pub aovs: Vec<Aov>,
    pub variance: bool,
    pub prefix: Option<String>,
    pub multi_part: bool,
    /// Pictures as half floats.
    #[serde(default)]
    pub half: bool,
    /// The name of a [`Packing`](eyebox_output::exr::Packing), if another than the usual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compression: Option<String>,
    /// The part of the picture that is traced and written; all of it without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<Crop>,
}

impl Finishing {
    pub fn new(scene: &Scene, plan: &Plan, space: ColourSpace, diffraction: Option<Diffraction>) -> Finishing {
        let (size, groups) = (scene.eye.resolution, infos(scene, plan));
        Finishing { size, groups, space, diffraction, wanted: Wanted::default() }
    }

    /// Splits light by the slide that it crosses, as paths tell of it.
    pub fn tell_slides_apart(&mut self, scene: &Scene, told: &Told) {
        for (index, group) in self.groups.iter_mut().enumerate() {
            group.slides = Some(slides::by_slide(scene, GroupId::from_index(index), told));
        }
    }

    /// The picture layers of films. Errors: NaN or infinite light, which is never coloured over.
    pub fn picture(&self, films: &Films) -> Result<Finished> {
        let films: Vec<&Film> = films.films.iter().map(|(_, film, _)| film).collect();
        let always = [Layer::Direct, Layer::Caustic, Layer::Forward];
        let (aovs, diffraction) = (&self.wanted.aovs, self.diffraction.as_ref());
        let finished = finish_through(self.size, &films, &self.groups, &always, aovs, self.space, diffraction);
        match finished.invalid.first() {
            Some(channel) => {
                let what = format!("NaN or infinite light in channel {channel}; nothing is written");
                Err(Error::new(Where::Nowhere, what))
            }
            None => Ok(finished),
        }
    }
}

impl Wanted {
    /// Whether a channel of a complete frame is made of films.
    pub fn is_light(&self, channel: &Channel) -> bool {
        is_light(channel) || self.aovs.iter().flat_map(Aov::layers).any(|layer| layer == channel.layer())
    }

    /// Leaves the part of the picture that is wanted, the last thing that is done to it.
    pub fn cut(&self, frame: &mut Frame) {
        if let Some(crop) = &self.crop {
            crop.cut(frame);
        }
    }

    /// Makes of a complete frame the one that was asked for.
    pub fn keep(&self, frame: &mut Frame) {
        if self.variance {
            variance::add(frame);
        }
        let (own, said) = aov::layers(frame, &self.aovs);
        // The shares of those that part classes stay, so that they can be summed up again.
        let names: HashSet<String> = self.aovs.iter().flat_map(Aov::layers).collect();
        let all = std::mem::take(&mut frame.channels);
        let (shares, others): (Vec<Channel>, Vec<Channel>) =
            all.into_iter().partition(|channel| names.contains(channel.layer()));
        frame.channels = others;
        keep_layers(frame, &self.layers);
        render_vars::rename(frame, &self.named, self.only_named);
        frame.channels.extend(own.into_iter().chain(shares));
        frame.meta.extend(said);
        frame.meta.extend(self.prefix.iter().map(|prefix| (LAYER_PREFIX.to_owned(), Meta::Text(prefix.clone()))));
        frame.meta.extend(self.multi_part.then(|| (MULTI_PART.to_owned(), Meta::Integer(1))));
        frame.meta.extend(self.half.then(|| (HALF.to_owned(), Meta::Integer(1))));
        frame.meta.extend(self.compression.iter().map(|name| (COMPRESSION.to_owned(), Meta::Text(name.clone()))));
    }
}

/// Whether a channel is made of films, those of light path expressions left out.
fn is_light(channel: &Channel) -> bool {
    let of = |layer: Layer| {
        channel.layer().strip_prefix(layer.name()).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    };
    match channel.layer() {
        "" => ["R", "G", "B"].contains(&channel.component()),
        "hybrid" | "stderr" => true,
        _ => Layer::SUM_ORDER.into_iter().any(of),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_told_from_data() {
        let channel = |name: &str| Channel { name: name.to_owned(), data: Vec::new().into() };
        let aov = Aov {
            name: "mine".into(),
            lpe: "C".into(),
            shares: vec!["mine_led".into()],
            part: Some(0),
            slides: Vec::new(),
        };
        let wanted = Wanted { aovs: vec![aov], ..Wanted::default() };
        for name in [
            "R",
            "hybrid.G",
            "stderr.R",
            "direct.B",
            "forward_led_open.R",
            "caustic_stderr.R",
            "mine_led_open.G",
            "mine.R",
        ] {
            assert!(wanted.is_light(&channel(name)), "{name}");
        }
        for name in ["Z", "normal.X", "seethrough.R", "id_seen.part", "forwardness.R", "mine_back.R", "CryptoPart00.R"]
        {
            assert!(!wanted.is_light(&channel(name)), "{name}");
        }
    }
}
