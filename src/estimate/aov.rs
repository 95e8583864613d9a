//! Layers by light path expression. What films keep is whole classes of paths per light group, so an expression becomes a
//! sum of stored shares if it takes all or nothing of each. Others part classes: the paths of a run are told to them, and
//! what they take has planes of its own.

use super::picture::possible_layers;
use super::render_vars::{Named, plain};
use super::series;
use super::slides::{self, Told};
use eyebox_base::lpe::{Alphabet, Letter, Lpe, MOST_SLIDES, Product, Source, Verdict};
use eyebox_base::path::{Class, Event};
use eyebox_base::{Error, Result, Where};
use eyebox_film::aov::Aov;
use eyebox_film::cryptomatte::Matte;
use eyebox_film::frame::{Channel, Frame, Meta};
use eyebox_film::layer::Layer;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_scene::assembly::RequestedLayer;
use eyebox_scene::{Finish, Note, Scene};
use eyebox_world::World;
use eyebox_world::scatter::Scatter;
use eyebox_world::surface::Surface;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

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

/// What can be had of layers that were asked for.
#[derive(Debug, Clone, Default)]
pub struct Granted {
    pub aovs: Vec<Aov>,
    /// A warning for each wish that cannot be had.
    pub notes: Vec<Note>,
    /// For [`World::sieve`]: the expressions that part classes.
    pub sieve: Option<Arc<Product>>,
    /// Of a scene with several slides: how paths tell which of them they cross, for
    /// [`Finishing::tell_slides_apart`](super::finishing::Finishing::tell_slides_apart).
    pub slides_told: Option<Told>,
}

/// The layers of `asked` (names and expressions of the command line) and of those `wishes` of the asset that are
/// expressions.
///
/// Errors: something asked that cannot be had, or a name that is a layer's already.
pub fn granted(
    asked: &[(String, String)],
    (wishes, named): (&[RequestedLayer], &[Named]),
    scene: &Scene,
    world: &World,
    plan: &Plan,
) -> Result<Granted> {
    let mut granted = Granted::default();
    let slides = scene.slides.len();
    if asked.is_empty() && slides < 2 && !wishes.iter().any(|wish| wish.expression) {
        return Ok(granted);
    }
    let mut maker = Maker::new(scene, world, plan);
    maker.taken.extend(named.iter().map(|own| own.name.clone()));
    for (name, lpe) in asked {
        let at = || Where::Option(format!("--aov {name}={lpe}"));
        granted.aovs.push(maker.aov(name.clone(), lpe).map_err(|refused| match refused {
            Refused::Name(layer) => {
                Error::new(at(), format!("there is a layer `{layer}` already")).expected("a name of its own")
            }
            Refused::Expression(what) => Error::new(at(), format!("the expression {what}")),
        })?);
    }
    for wish in wishes.iter().filter(|wish| wish.expression) {
        let text = match maker.aov(plain(&wish.name), &wish.source) {
            Ok(aov) => {
                granted.aovs.push(aov);
                continue;
            }
            Err(Refused::Name(layer)) => {
                format!("`{}` asks for the name `{layer}`, which another has", wish.source)
            }
            Err(Refused::Expression(what)) => {
                format!("the light path expression `{}` {what}: not written", wish.source)
            }
        };
        granted.notes.push(Note::warning(wish.at.clone(), text));
    }
    if slides > 1 {
        match maker.tell_slides_apart(slides, world) {
            Ok((told, in_series)) => {
                granted.slides_told = Some(told);
                granted.notes.extend(in_series.map(|because| {
                    let text = format!("light through slides in series is not told apart: a path {because}");
                    Note::warning(Where::File(scene.name.clone().into()), text)
                }));
            }
            Err(because) => {
                granted.aovs.iter_mut().for_each(|aov| aov.slides.clear());
                let at = Where::File(scene.name.clone().into());
                let text = format!("light is not split by the contrasts of its {slides} slides: {because}");
                granted.notes.push(Note::warning(at, text));
            }
        }
    }
    granted.sieve = maker.sieve.map(Arc::new);
    Ok(granted)
}

/// The channels of these layers, and what the header says of them.
pub fn layers(frame: &Frame, aovs: &[Aov]) -> (Vec<Channel>, Vec<(String, Meta)>) {
    let (channels, said): (Vec<Vec<Channel>>, Vec<(String, Meta)>) = aovs.iter().map(|aov| aov.written(frame)).unzip();
    (channels.into_iter().flatten().collect(), said)
}

/// Why a layer cannot be had.
enum Refused {
    /// A layer of this name is there.
    Name(String),
    Expression(String),
}

/// What an expression is among what films keep.
enum Kind {
    Shares(Vec<String>),
    Parts,
}

struct Maker<'s> {
    scene: &'s Scene,
    plan: &'s Plan,
    events: Vec<Letter>,
    /// Per light group.
    sources: Vec<Vec<Source>>,
    /// Names of layers.
    taken: BTreeSet<String>,
    /// The expressions that part classes, so far.
    parting: Vec<Lpe>,
    sieve: Option<Product>,
}

impl<'s> Maker<'s> {
    fn new(scene: &'s Scene, world: &World, plan: &'s Plan) -> Self {
        Maker {
            scene,
            plan,
            events: events(scene, world),
            sources: sources(scene),
            taken: possible_layers(&scene.groups, &slides::names(scene)),
            parting: Vec::new(),
            sieve: None,
        }
    }

    /// The layer of an expression.
    fn aov(&mut self, name: String, text: &str) -> std::result::Result<Aov, Refused> {
        if self.is_taken(&name) {
            return Err(Refused::Name(name));
        }
        let lpe = Lpe::parse(text).map_err(Refused::Expression)?;
        let aov = match self.kind(&lpe).map_err(Refused::Expression)? {
            Kind::Shares(shares) => Aov { name, lpe: text.to_owned(), shares, part: None, slides: Vec::new() },
            Kind::Parts => {
                let all: Vec<Lpe> = self.parting.iter().cloned().chain([lpe]).collect();
                let groups = self.groups();
                let sieve = Product::new(&all, &groups, &self.events).map_err(Refused::Expression)?;
                let bit = self.parting.len();
                let takes = |group: usize| {
                    Class::ALL.into_iter().any(|class| {
                        let broad = |broad| sieve.possible(group, class, broad).any(|takes| takes >> bit & 1 == 1);
                        !self.layers(group, class).is_empty() && [false, true].into_iter().any(broad)
                    })
                };
                let taken = (0..groups.len()).filter(|group| takes(*group));
                let shares = taken.map(|group| format!("{name}_{}", groups[group].0)).collect();
                let aov = Aov {
                    name,
                    lpe: text.to_owned(),
                    shares,
                    part: u32::try_from(bit).ok(),
                    slides: slides::names(self.scene),
                };
                if let Some(layer) = aov.layers().find(|layer| self.is_taken(layer)) {
                    return Err(Refused::Name(layer));
                }
                (self.parting, self.sieve) = (all, Some(sieve));
                aov
            }
        };
        self.taken.extend(aov.layers());
        Ok(aov)
    }

    fn groups(&self) -> Vec<(&'s str, Vec<Source>)> {
        let names = self.scene.groups.iter().map(|group| group.name.as_str());
        names.zip(self.sources.iter().cloned()).collect()
    }

    /// Has paths tell which slide they cross, and which two where light crosses one after the other; where those two cannot be
    /// told, says why. Errors: why none can.
    fn tell_slides_apart(
        &mut self,
        count: usize,
        world: &World,
    ) -> std::result::Result<(Told, Option<String>), String> {
        if count > MOST_SLIDES {
            return Err(format!("no more than {MOST_SLIDES} are told apart"));
        }
        let bit = u32::try_from(self.parting.len()).map_err(|fault| fault.to_string())?;
        let slides = (0..count).filter_map(|slide| u8::try_from(slide).ok()).map(Some);
        let crossing = [None].into_iter().chain(slides).map(Lpe::crossing);
        let all: Vec<Lpe> = self.parting.iter().cloned().chain(crossing).collect();
        let mut in_series = None;
        let once = series::find(world, self.scene.groups.len());
        if !once.is_empty() {
            let crossing = once.iter().map(|(slide, other)| Lpe::crossing_once(*slide, *other));
            let with: Vec<Lpe> = all.iter().cloned().chain(crossing).collect();
            match Product::new(&with, &self.groups(), &self.events) {
                Ok(sieve) => {
                    self.sieve = Some(sieve.parting_series());
                    return Ok((Told { bit, once }, None));
                }
                Err(what) => in_series = Some(what),
            }
        }
        let sieve = Product::new(&all, &self.groups(), &self.events);
        self.sieve = Some(sieve.map_err(|what| format!("with layers by light path expression, a path {what}"))?);
        Ok((Told { bit, once: Vec::new() }, in_series))
    }

    fn is_taken(&self, layer: &str) -> bool {
        self.taken.contains(layer) || Matte::of_layer(layer).is_some()
    }

    /// The shares that an expression is the sum of, or that it is none; why not if it takes nothing.
    fn kind(&self, lpe: &Lpe) -> std::result::Result<Kind, String> {
        let (mut found, mut parts) = (BTreeSet::<(usize, usize)>::new(), false);
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
            let (mut taken, mut left) = (BTreeSet::new(), BTreeSet::new());
            for (class, verdict) in Class::ALL.into_iter().zip(verdicts) {
                let layers = self.layers(index, class);
                match verdict {
                    Verdict::Impossible => {}
                    Verdict::Nothing => left.extend(layers),
                    Verdict::All => taken.extend(layers),
                    Verdict::Some { .. } => parts |= !layers.is_empty(),
                }
            }
            parts |= !taken.is_disjoint(&left);
            let place = |layer| Layer::SUM_ORDER.iter().position(|own| *own == layer);
            found.extend(taken.into_iter().filter_map(place).map(|layer| (layer, index)));
        }
        if parts {
            return Ok(Kind::Parts);
        }
        if found.is_empty() {
            return Err("takes no path of this scene".to_owned());
        }
        let share = |(layer, group): (usize, usize)| {
            format!("{}_{}", Layer::SUM_ORDER[layer].name(), self.scene.groups[group].name)
        };
        Ok(Kind::Shares(found.into_iter().map(share).collect()))
    }

    /// The layers that hold paths of this class from this group; none if nobody traces them.
    fn layers(&self, group: usize, class: Class) -> Vec<Layer> {
        let group = eyebox_base::ids::GroupId::from_index(group);
        let broads = [false, true].into_iter().filter(|broad| !(*broad && class == Class::Vision));
        let of = |broad: bool| {
            let computes = move |e: &Estimator| self.plan.computes(*e, group, class, broad);
            Estimator::ALL.into_iter().filter(computes).map(move |e| self.plan.layer(e, group, class, broad))
        };
        let mut layers: Vec<Layer> = broads.flat_map(of).collect();
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
    for (part, faces) in scene.parts.iter().zip(world.faces.iter()) {
        for (face, optics) in part.faces.iter().zip(faces) {
            match &optics.surface {
                Surface::Absent | Surface::Absorber => {}
                Surface::Slide(slide) => found.extend([world.slide_letter(*slide)]),
                Surface::Sheet(_) => found.extend([Letter::TransmitStraight]),
                Surface::Splitter(_) => found.extend([Letter::ReflectSpecular, Letter::TransmitStraight]),
                Surface::Mirror(_) => found.extend([Letter::ReflectSpecular]),
                Surface::Grating(_) => found.extend([Letter::ReflectSpecular, Letter::TransmitSpecular]),
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
        | Finish::WavePlate { .. }
        | Finish::CircularPolariser { .. }
        | Finish::ReflectivePolariser { .. }
        | Finish::Grating { .. }
        | Finish::Surface { .. }
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
