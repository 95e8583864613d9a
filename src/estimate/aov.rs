//! Layers by light path expression. What films keep is whole classes of paths per light group, so an expression becomes
//! a sum of stored shares, or is refused with the paths that it would part.

use super::picture::possible_layers;
use super::wish::{Named, plain};
use crate::base::lpe::{Alphabet, Letter, Lpe, Source, Verdict};
use crate::base::path::{Class, Event};
use crate::base::{Fault, Result, Where};
use crate::film::aov::Aov;
use crate::film::frame::{Channel, Frame, Meta};
use crate::film::layer::Layer;
use crate::film::matte::Matte;
use crate::film::plan::{Estimator, Plan};
use crate::scene::assembly::LayerWish;
use crate::scene::{Finish, Note, Scene, Severity};
use crate::world::World;
use crate::world::scatter::Scatter;
use crate::world::surface::Surface;
use std::collections::{BTreeSet, HashMap};

/// `NAME=LPE`. Errors: no name that can be a layer's.
pub fn parse_option(text: &str) -> std::result::Result<(String, String), String> {
    let bad = || format!("`{text}` is no layer; write NAME=LPE, e.g. glints='C<.[Ss]>*<.[DG]><.[Ss]>+L'");
    let (name, lpe) = text.split_once('=').ok_or_else(bad)?;
    let name = name.trim();
    if name.is_empty() || plain(name) != name || lpe.trim().is_empty() {
        return Err(bad());
    }
    Ok((name.to_owned(), lpe.trim().to_owned()))
}

/// The layers of `asked` (names and expressions of the command line) and of those `wishes` of the asset that are
/// expressions; a warning for each wish that cannot be had.
///
/// Errors: something asked that cannot be had, or a name that is a layer's already.
pub fn granted(
    asked: &[(String, String)],
    (wishes, named): (&[LayerWish], &[Named]),
    scene: &Scene,
    world: &World,
    plan: &Plan,
) -> Result<(Vec<Aov>, Vec<Note>)> {
    let (mut all, mut notes) = (Vec::<Aov>::new(), Vec::new());
    if asked.is_empty() && !wishes.iter().any(|wish| wish.expression) {
        return Ok((all, notes));
    }
    let maker = Maker::new(scene, world, plan);
    let mut taken = possible_layers(&scene.groups);
    taken.extend(named.iter().map(|own| own.name.clone()));
    for (name, lpe) in asked {
        let at = || Where::Option(format!("--aov {name}={lpe}"));
        if taken.contains(name) || Matte::of_layer(name).is_some() || all.iter().any(|other| other.name == *name) {
            return Err(Fault::new(at(), format!("there is a layer `{name}` already")).expected("a name of its own"));
        }
        let shares = maker.shares(lpe).map_err(|what| Fault::new(at(), format!("the expression {what}")))?;
        all.push(Aov { name: name.clone(), lpe: lpe.clone(), shares });
    }
    for wish in wishes.iter().filter(|wish| wish.expression) {
        let mut refused = |text: String| notes.push(Note { severity: Severity::Warning, at: wish.at.clone(), text });
        let name = plain(&wish.name);
        match maker.shares(&wish.source) {
            Ok(_) if all.iter().any(|other| other.name == name) || named.iter().any(|own| own.name == name) => {
                refused(format!("`{}` asks for the name `{name}`, which another has", wish.source));
            }
            Ok(shares) => all.push(Aov { name, lpe: wish.source.clone(), shares }),
            Err(what) => refused(format!("the light path expression `{}` {what}: not written", wish.source)),
        }
    }
    Ok((all, notes))
}

/// The channels of these layers, and what the header says of them.
pub fn layers(frame: &Frame, aovs: &[Aov]) -> (Vec<Channel>, Vec<(String, Meta)>) {
    let (channels, said): (Vec<Vec<Channel>>, Vec<(String, Meta)>) = aovs.iter().map(|aov| aov.written(frame)).unzip();
    (channels.into_iter().flatten().collect(), said)
}

struct Maker<'s> {
    scene: &'s Scene,
    plan: &'s Plan,
    events: Vec<Letter>,
    /// Per light group.
    sources: Vec<Vec<Source>>,
}

impl<'s> Maker<'s> {
    fn new(scene: &'s Scene, world: &World, plan: &'s Plan) -> Self {
        Maker { scene, plan, events: events(scene, world), sources: sources(scene) }
    }

    /// The shares that an expression is the sum of, or why it is none.
    fn shares(&self, text: &str) -> std::result::Result<Vec<String>, String> {
        let lpe = Lpe::parse(text)?;
        let mut found: BTreeSet<(usize, usize)> = BTreeSet::new();
        // Groups of the same lamps that the expression does not name are alike.
        let mut known: HashMap<(Option<&str>, &[Source]), [Verdict; Class::ALL.len()]> = HashMap::new();
        for (index, (group, sources)) in self.scene.groups.iter().zip(&self.sources).enumerate() {
            let name = group.name.as_str();
            let key = (lpe.names(name).then_some(name), sources.as_slice());
            let verdicts = match known.get(&key) {
                Some(verdicts) => verdicts.clone(),
                None => {
                    let alphabet = Alphabet { events: self.events.clone(), sources: sources.clone() };
                    let verdicts = lpe.takes(&alphabet, name)?;
                    known.insert(key, verdicts.clone());
                    verdicts
                }
            };
            let (mut taken, mut left) = (Vec::new(), Vec::new());
            for (class, verdict) in Class::ALL.into_iter().zip(verdicts) {
                let layers = self.layers(index, class);
                match verdict {
                    Verdict::Impossible => {}
                    Verdict::Nothing => left.extend(layers.into_iter().map(|layer| (layer, class))),
                    Verdict::All => taken.extend(layers.into_iter().map(|layer| (layer, class))),
                    Verdict::Some { .. } if layers.is_empty() => {}
                    Verdict::Some { takes, leaves } => {
                        return Err(format!(
                            "takes {takes} and leaves {leaves}, both {} paths of `{name}`: a layer can be any sum of whole \
                             classes (vision, primary, caustic, secondary) of light groups",
                            class.name()
                        ));
                    }
                }
            }
            for (layer, class) in &taken {
                if let Some((_, other)) = left.iter().find(|(own, _)| own == layer) {
                    return Err(format!(
                        "takes the {} paths of `{name}` and leaves the {} ones, which `{}_{name}` holds together in this \
                         plan: take both or none",
                        class.name(),
                        other.name(),
                        layer.name()
                    ));
                }
                found.extend(Layer::SUM_ORDER.iter().position(|own| own == layer).map(|layer| (layer, index)));
            }
        }
        if found.is_empty() {
            return Err("takes no path of this scene".to_owned());
        }
        let share = |(layer, group): (usize, usize)| {
            format!("{}_{}", Layer::SUM_ORDER[layer].name(), self.scene.groups[group].name)
        };
        Ok(found.into_iter().map(share).collect())
    }

    /// The layers that hold paths of this class from this group; none if nobody traces them.
    fn layers(&self, group: usize, class: Class) -> Vec<Layer> {
        let group = crate::base::ids::GroupId::from_index(group);
        let computes = |estimator: Estimator| {
            [false, true].iter().any(|broad| {
                let possible = !(*broad && class == Class::Vision);
                possible && self.plan.computes(estimator, group, class, *broad)
            })
        };
        let mut layers: Vec<Layer> =
            Estimator::ALL.into_iter().filter(|e| computes(*e)).map(|e| Layer::of(class, e)).collect();
        layers.sort_unstable();
        layers.dedup();
        layers
    }
}

/// How the lamps of each group emit.
fn sources(scene: &Scene) -> Vec<Vec<Source>> {
    let mut all: Vec<BTreeSet<Source>> = vec![BTreeSet::new(); scene.groups.len()];
    let faces = scene.parts.iter().flat_map(|part| &part.faces).filter_map(|face| face.emitter.as_ref());
    let faces = faces.map(|emitter| (emitter.group, Source::Face));
    let lights = scene.lights.iter().map(|light| (light.group, Source::Light));
    let sky = scene.sky.iter().map(|sky| (sky.group, Source::Sky));
    for (group, source) in faces.chain(lights).chain(sky) {
        all[group.index()].insert(source);
    }
    all.into_iter().map(|sources| sources.into_iter().collect()).collect()
}

/// What can happen on the faces of a scene; rather too much than too little.
fn events(scene: &Scene, world: &World) -> Vec<Letter> {
    let mut found = BTreeSet::new();
    for (part, faces) in scene.parts.iter().zip(&world.faces) {
        for (face, optics) in part.faces.iter().zip(faces) {
            match &optics.surface {
                Surface::Absent | Surface::Absorber => {}
                Surface::Slide(_) | Surface::Sheet(_) => found.extend([Letter::TransmitStraight]),
                Surface::Mirror(_) => found.extend([Letter::ReflectSpecular]),
                Surface::Interface(_) => found.extend([Letter::ReflectSpecular, Letter::TransmitSpecular]),
                Surface::Scatter(scatter) => found.extend(of_scatter(scatter, &face.finish)),
            }
        }
    }
    found.into_iter().collect()
}

fn of_scatter(scatter: &Scatter, finish: &Finish) -> Vec<Letter> {
    let (reflects, transmits) = match finish {
        Finish::Lambert { reflectance, transmittance }
        | Finish::Gauss { reflectance, transmittance, .. }
        | Finish::CosM { reflectance, transmittance, .. } => (*reflectance > 0.0, *transmittance > 0.0),
        Finish::Abg { .. } => (true, false),
        Finish::None
        | Finish::Polished
        | Finish::MirrorMetal { .. }
        | Finish::MirrorIdeal { .. }
        | Finish::Rough { .. }
        | Finish::Measured { .. }
        | Finish::Polariser { .. }
        | Finish::Retarder { .. }
        | Finish::Absorber => (true, true),
    };
    let [reflected, transmitted] = match scatter.event() {
        Event::Specular => [Letter::ReflectSpecular, Letter::TransmitSpecular],
        Event::Glossy => [Letter::ReflectGlossy, Letter::TransmitGlossy],
        Event::Diffuse => [Letter::ReflectDiffuse, Letter::TransmitDiffuse],
    };
    let specular = (scatter.specular() > 0.0).then_some(Letter::ReflectSpecular);
    let both = [(reflects, reflected), (transmits, transmitted)];
    both.into_iter().filter_map(|(does, letter)| does.then_some(letter)).chain(specular).collect()
}
