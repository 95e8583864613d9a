//! What is made of films besides adding them up: everything that the frame takes from the scene and the command line, so
//! that shards of a run can carry it to where they are merged.

use super::aov;
use super::picture::{infos, keep_layers};
use super::run::Films;
use super::wish::{self, Named};
use crate::base::colour::ColourSpace;
use crate::base::{Fault, Result, Where};
use crate::film::accumulate::Film;
use crate::film::aov::Aov;
use crate::film::diffraction::Diffraction;
use crate::film::finish::{Finished, GroupInfo, finish_through};
use crate::film::frame::{Frame, Meta};
use crate::film::layer::Layer;
use crate::film::plan::Plan;
use crate::film::variance;
use crate::output::exr::{LAYER_PREFIX, MULTI_PART};
use crate::scene::Scene;

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
}

impl Finishing {
    pub fn new(scene: &Scene, plan: &Plan, space: ColourSpace, diffraction: Option<Diffraction>) -> Finishing {
        let (size, groups) = (scene.eye.resolution, infos(scene, plan));
        Finishing { size, groups, space, diffraction, wanted: Wanted::default() }
    }

    /// The picture layers of films. Errors: NaN or infinite light, which is never coloured over.
    pub fn picture(&self, films: &Films) -> Result<Finished> {
        let films: Vec<&Film> = films.films.iter().map(|(_, film, _)| film).collect();
        let always = [Layer::Direct, Layer::Caustic, Layer::Forward];
        let finished = finish_through(self.size, &films, &self.groups, &always, self.space, self.diffraction.as_ref());
        match finished.invalid.first() {
            Some(channel) => {
                let what = format!("NaN or infinite light in channel {channel}; nothing is written");
                Err(Fault::new(Where::Nowhere, what))
            }
            None => Ok(finished),
        }
    }
}

impl Wanted {
    /// Makes of a complete frame the one that was asked for.
    pub fn keep(&self, frame: &mut Frame) {
        if self.variance {
            variance::add(frame);
        }
        let (own, said) = aov::layers(frame, &self.aovs);
        keep_layers(frame, &self.layers);
        wish::rename(frame, &self.named, self.only_named);
        frame.channels.extend(own);
        frame.meta.extend(said);
        frame.meta.extend(self.prefix.iter().map(|prefix| (LAYER_PREFIX.to_owned(), Meta::Text(prefix.clone()))));
        frame.meta.extend(self.multi_part.then(|| (MULTI_PART.to_owned(), Meta::Integer(1))));
    }
}
