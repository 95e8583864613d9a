//! The estimators that a plan asks for, each with its film, and what they need before the first pass.

use super::{Dealt, Films, Start, Tracing, adaptive};
use crate::backward::Backward;
use crate::forward::Forward;
use crate::ledger::Ledger;
use crate::manifold::eye_table::EyeTable;
use crate::manifold::film_grid::FilmGrid;
use crate::manifold::film_table::FilmTables;
use crate::manifold::receiver::Receivers;
use crate::manifold::seeds::bands::Bands;
use crate::manifold::seeds::connections::Connections;
use crate::manifold::vision::Manifold;
use crate::ownership::Ownership;
use crate::photon::PhotonMapper;
use crate::vision::Hints;
use crate::witness::Witness;
use eyebox_film::accumulate::{Film, Sampling};
use eyebox_film::error_detail::ErrorDetail;
use eyebox_film::guide::ApertureGuide;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_film::rqmc_variance::Evenness;
use eyebox_film::sample_map::COARSE;
use eyebox_world::World;
use eyebox_world::mode::{Hero, Mode, Mono, Rgb, Spectral, components, wavelengths_change};
use eyebox_world::optics::Optics;
use eyebox_world::stokes::Stokes;
use std::collections::BTreeMap;
use std::sync::Arc;

enum Engine<'w, M: Mode> {
    Backward(Box<Backward<'w, M>>),
    Forward(Forward<'w, M>),
    Photon(PhotonMapper<'w, M>),
    Manifold(Manifold<'w, M>),
}

impl<M: Mode> Engine<'_, M> {
    fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        match self {
            Engine::Backward(e) => e.run(film, first, count),
            Engine::Forward(e) => e.run(film, first, count),
            Engine::Photon(e) => e.run(film, first, count),
            Engine::Manifold(e) => e.run(film, first, count),
        }
    }
}

struct Engines<'w, M: Mode> {
    engines: Vec<Engine<'w, M>>,
    films: Films,
    witness: Option<Witness<'w, M>>,
    /// What a witness has to know.
    world: &'w World,
    plan: Plan,
    groups: usize,
    seed: u64,
}

impl<M: Mode> Engines<'_, M> {
    /// Has the witness look beside whole passes.
    fn attend(&mut self) {
        let mut works: BTreeMap<u64, u64> = BTreeMap::new();
        for (pass, work) in self.films.films.iter_mut().flat_map(|(_, film, _)| film.take_works()) {
            *works.entry(pass).or_default() += work;
        }
        self.films.dealt.attended = self.films.first + self.films.passes;
        self.attend_beside(&works.into_iter().collect::<Vec<_>>());
    }

    /// The same beside passes of these numbers and counted work.
    fn attend_beside(&mut self, works: &[(u64, u64)]) {
        if let Some(witness) = self.witness.as_mut().filter(|_| !works.is_empty()) {
            witness.attend(works);
            self.films.witness = Some(witness.record.clone());
        }
    }
}

impl<M: Mode> Tracing for Engines<'_, M> {
    fn step(&mut self, count: u64) {
        for (engine, (_, film, ledger)) in self.engines.iter().zip(&mut self.films.films) {
            ledger.merge(&engine.run(film, self.films.first + self.films.passes, count));
        }
        self.films.passes += count;
        self.attend();
    }
    fn sweep(&mut self, part: usize) -> usize {
        // Tables for the wavelengths of a pass are made anew for each part.
        let side = if wavelengths_change::<M>() { 2 } else { COARSE };
        for (estimator, film, _) in &mut self.films.films {
            if adaptive::has_own_sequences(*estimator, film) {
                film.want_first(|pixel| adaptive::part_of(pixel, side) == part);
            } else if part == 0 {
                film.wanted = 1;
            }
        }
        while self.missing().is_some() {
            self.fill(1);
        }
        let left = side * side - 1 - part;
        if left == 0 {
            self.attend();
        }
        left
    }
    fn aim(&mut self, error: Option<f64>) {
        let traced = |pixel: usize| self.world.eye.wants_index(pixel);
        adaptive::aim(&mut self.films, &traced, error, self.seed);
        self.films.dealt.rounds += 1;
    }
    fn missing(&self) -> Option<u64> {
        self.films.films.iter().find_map(|(_, film, _)| film.missing()).map(|passes| passes.end - passes.start)
    }
    fn fill(&mut self, count: u64) {
        let films = self.engines.iter().zip(&mut self.films.films);
        let next = films.filter_map(|(engine, own)| Some((engine, own.1.missing()?, own))).next();
        let Some((engine, passes, (_, film, ledger))) = next else { return };
        ledger.merge(&engine.run(film, passes.start, count.min(passes.end - passes.start)));
        // The works of a first pass in parts are known when it is whole.
        let mut works = if self.films.dealt.rounds > 0 { film.take_works() } else { Vec::new() };
        // Between what pixels of few and of many passes are to get there may be passes of none; which of them a block holds
        // is the clock's doing, and a witness must not know.
        works.retain(|(_, work)| *work > 0);
        self.films.passes = self.films.films.iter().map(|(_, film, _)| film.most_passes()).max().unwrap_or(0);
        let first = self.films.dealt.attended;
        self.films.dealt.attended += works.len() as u64;
        // Films and rounds make passes of one number more than once; a witness looks elsewhere each time.
        let numbered: Vec<(u64, u64)> = (first..).zip(works.into_iter().map(|(_, work)| work)).collect();
        self.attend_beside(&numbered);
    }
    fn watch(&mut self, guide: Option<&ApertureGuide>) {
        let Some((_, film, _)) = self.films.films.first() else { return };
        let size = [film.width, film.height];
        self.witness = Witness::new(self.world, &self.plan, self.groups, (size, guide), self.seed);
        self.films.witness = self.witness.as_ref().map(|witness| witness.record.clone());
    }
    fn films(&self) -> &Films {
        &self.films
    }
    fn start(&mut self, from: Start) -> bool {
        let films = match from {
            Start::Pass(first) => {
                self.films.first = first;
                return true;
            }
            Start::Films(films) => *films,
        };
        let own = self.films.films.iter().map(|(estimator, _, _)| *estimator);
        let alike = own.eq(films.films.iter().map(|(estimator, _, _)| *estimator));
        self.films.first = films.first;
        self.films.passes = films.passes;
        self.films.dealt = Dealt { attended: films.dealt.attended.max(films.first + films.passes), ..films.dealt };
        // Of films without a witness none can be made up.
        let seen = match (&mut self.witness, &films.witness) {
            (Some(own), Some(more)) => own.record.merge(more),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        self.films.witness = self.witness.as_ref().map(|witness| witness.record.clone());
        // Films that fit are taken over by adding them to empty ones.
        let own = self.films.films.iter_mut().zip(&films.films);
        alike
            && seen
            && own.fold(true, |fits, ((_, film, ledger), (_, more, books))| {
                ledger.merge(books);
                film.merge(more) && fits
            })
    }
    fn into_films(self: Box<Self>) -> Films {
        self.films
    }
}

/// The estimators that `plan` asks for, before the first pass. `groups`: number of light groups; `size`: picture in
/// pixels. Without an owner of any path there are no films.
pub fn begin<'w>(world: &'w World, plan: &Plan, groups: usize, size: [usize; 2], seed: u64) -> Box<dyn Tracing + 'w> {
    let begin = match (plan.mode.spectral, plan.mode.polarised) {
        (Spectral::Mono, false) => begin_in::<Mono<f64>>,
        (Spectral::Mono, true) => begin_in::<Mono<Stokes>>,
        (Spectral::Rgb, false) => begin_in::<Rgb<f64>>,
        (Spectral::Rgb, true) => begin_in::<Rgb<Stokes>>,
        (Spectral::Hero, false) => begin_in::<Hero<f64>>,
        (Spectral::Hero, true) => begin_in::<Hero<Stokes>>,
    };
    begin(world, plan, groups, size, seed)
}

/// The same for a pilot's small picture of a larger one, whose longer side has `longer` pixels: at one wavelength and
/// without polarisation. `joined`: the connections and coarse tables of the plan.
pub fn begin_trial<'w>(
    world: &'w World,
    plan: &Plan,
    groups: usize,
    (size, longer): ([usize; 2], usize),
    seed: u64,
    (connections, screens): (Arc<Connections>, Receivers<Mono>),
) -> Box<dyn Tracing + 'w> {
    let optics = Mono::<f64>::optics(world, seed, 0);
    let connections = Arc::new(Bands::from(connections));
    let kept = Kept::new((world, &optics), connections, screens, FilmGrid::coarse(world, longer));
    begin_with::<Mono<f64>>(world, plan, groups, size, seed, kept)
}

fn begin_in<'w, M: Mode + 'w>(
    world: &'w World,
    plan: &Plan,
    groups: usize,
    size: [usize; 2],
    seed: u64,
) -> Box<dyn Tracing + 'w> {
    let optics = M::optics(world, seed, 0);
    let connections = Arc::new(Bands::new(world, &optics, &plan.connections));
    let screens = Receivers::new(world, &optics, &plan.screens);
    let kept = Kept::new((world, &optics), connections, screens, FilmGrid::new(world));
    begin_with::<M>(world, plan, groups, size, seed, kept)
}

/// What specular connection knows before the first pass.
struct Kept<M: Mode> {
    connections: Arc<Bands>,
    tables: Option<FilmTables<M>>,
    screens: Arc<Receivers<M>>,
    glances: Option<Arc<EyeTable<M>>>,
}

impl<M: Mode> Kept<M> {
    /// `over`: the grid of tables over the picture, if they pay.
    fn new(
        (world, optics): (&World, &Optics<M>),
        connections: Arc<Bands>,
        screens: Receivers<M>,
        over: Option<FilmGrid>,
    ) -> Self {
        Kept {
            tables: over.and_then(|over| FilmTables::new(world, optics, connections.of(optics), over)),
            glances: over.and_then(|over| EyeTable::new(world, optics, &screens, over)).map(Arc::new),
            screens: Arc::new(screens),
            connections,
        }
    }
}

fn begin_with<'w, M: Mode + 'w>(
    world: &'w World,
    plan: &Plan,
    groups: usize,
    size: [usize; 2],
    seed: u64,
    Kept { connections, mut tables, screens, glances }: Kept<M>,
) -> Box<dyn Tracing + 'w> {
    let mut engines: Vec<Engine<'_, M>> = Vec::new();
    let mut films = Films { films: Vec::new(), first: 0, passes: 0, dealt: Dealt::default(), witness: None };
    for estimator in Estimator::ALL {
        let route = Ownership::new(plan, groups, estimator);
        if route.planes.is_empty() {
            continue;
        }
        let route = route.parted_by(world.sieve.as_ref());
        let sampling = match estimator {
            Estimator::Forward => Sampling::PerScramble { paths: plan.forward_paths },
            Estimator::Backward | Estimator::Photon | Estimator::Manifold => Sampling::PerPass,
        };
        let film = Film::new(size[0], size[1], route.planes.clone(), components::<M>(), sampling);
        let film = if wavelengths_change::<M>() { film.with_evenness(Evenness::OfPasses) } else { film };
        let film = match plan.errors {
            ErrorDetail::Picture => film,
            ErrorDetail::Layers => film.with_detail(),
        };
        let film = if estimator == Estimator::Photon { film.with_blur() } else { film };
        engines.push(match estimator {
            Estimator::Backward => {
                // What connection leaves is lamps over specular faces alone.
                let paths = if plan.owns(estimator) { plan.backward_paths } else { 0 };
                let backward = Backward::new(world, route, (paths, plan.backward_share), Hints::of(plan), seed);
                let backward = backward.beside(connections.clone(), plan.unknown_share);
                Engine::Backward(Box::new(backward.branching(plan.faintest_branch).cutting_pictures()))
            }
            Estimator::Forward => Engine::Forward(Forward::new(
                world,
                route,
                groups,
                plan.forward_paths,
                plan.forward_guide.as_ref(),
                connections.clone(),
                seed,
            )),
            Estimator::Manifold => {
                let (from_eye, lit) = ((connections.clone(), tables.take()), (screens.clone(), glances.clone()));
                Engine::Manifold(Manifold::new(world, route, from_eye, lit, seed))
            }
            Estimator::Photon => {
                let mapper = PhotonMapper::new(
                    world,
                    route,
                    groups,
                    plan.photons,
                    plan.photon_guide.as_ref(),
                    plan.photon_radii_m,
                    screens.clone(),
                    seed,
                );
                Engine::Photon(mapper.parting(plan.photons_part).glancing(glances.clone()))
            }
        });
        let unseen = match engines.last() {
            Some(Engine::Backward(backward)) => backward.unseen(),
            Some(Engine::Forward(_) | Engine::Photon(_) | Engine::Manifold(_)) | None => None,
        };
        films.films.push((estimator, film.with_unseen(unseen), Ledger::new(world.solids.len())));
    }
    Box::new(Engines { engines, films, witness: None, world, plan: plan.clone(), groups, seed })
}
