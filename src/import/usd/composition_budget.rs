//! How much composing a prim will cost, before the library composes it. Arcs are followed as the library will follow
//! them, but only counted, each site once: a few hundred bytes can ask for 10^20 opinions.
//!
//! Work is counted in units of at most about 0.3 µs, measured with openusd 0.8 on one core of 2026 (seconds of the
//! processor), for N sites in the index of a prim P levels deep: lists of references on root prims N = 1111: 0.1 s,
//! 11 111: 10 s, as N²; references at every level of a hierarchy P = N up to 100, 300 prims: 1.2 s, as P N²; chains of 60
//! to 300 inherits: 0.6 s for all, and for specializes 1.3 s, as N³; a prim in 1000 sublayers: 2 ms.

use super::arcs::{self, Arc, Stack};
use super::attribute::Moment;
use super::resolver::{Normalising, Opened};
use super::sublayers;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use openusd::ar::Resolver;
use openusd::sdf::{self, Path, Value};
use openusd::usd::Stage;
use std::collections::{HashMap, HashSet};

/// Sites in the index of one prim; productions have tens.
const MOST_SITES: u64 = 2000;
/// Arcs after one another; the library itself gives up at 100.
const MOST_CHAINED: usize = 400;
/// Work that the index of a prim may take without being counted, and what all others may take together.
const FREE: u64 = 200;
const MOST_WORK: u64 = 6_000_000;
const LAYER: u64 = 12;
/// For ten pairs of sites: always, by each level above the prim, and with inherits or specializes.
const PAIRS: u64 = 2;
const PAIRS_LEVEL: u64 = 1;
const PAIRS_CLASS: u64 = 10;
/// Sites that are looked at, all together.
const MOST_VISITED: usize = 2_000_000;
/// How often sites that lead back to themselves are added up again: the depth at which the library gives up.
const ROUNDS: usize = 100;

/// A prim in a stack of layers.
type Site = (usize, Path);
/// What the site's choices lead to.
type Edges = Vec<(bool, Vec<Vec<Site>>)>;

/// What composing a site takes: sites, and layers of all sites.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Work {
    sites: u64,
    layers: u64,
    /// Some arc is an inherit or specialize.
    has_class: bool,
}

impl Work {
    const NONE: Work = Work { sites: 0, layers: 0, has_class: false };
    const ONE: Work = Work { sites: 1, ..Work::NONE };
    fn plus(self, other: Work) -> Work {
        Work {
            sites: self.sites.saturating_add(other.sites),
            layers: self.layers.saturating_add(other.layers),
            has_class: self.has_class || other.has_class,
        }
    }
    fn max(self, other: Work) -> Work {
        Work {
            sites: self.sites.max(other.sites),
            layers: self.layers.max(other.layers),
            has_class: self.has_class || other.has_class,
        }
    }
    fn units(self, levels: u64) -> u64 {
        let pair = PAIRS + levels.saturating_mul(PAIRS_LEVEL) + if self.has_class { PAIRS_CLASS } else { 0 };
        let pairs = self.sites.saturating_mul(self.sites).saturating_mul(pair) / 10;
        pairs.saturating_add(self.layers.saturating_mul(LAYER))
    }
}

pub(super) struct CompositionBudget {
    resolver: Normalising,
    variables: HashMap<String, Value>,
    stacks: Vec<Stack>,
    by_name: HashMap<String, usize>,
    known: HashMap<Site, Work>,
    charged: HashSet<Path>,
    spent: u64,
    visited: usize,
}

impl CompositionBudget {
    pub fn new(stage: &Stage, opened: &Opened) -> Self {
        let resolver = Normalising::new(opened.clone());
        let variables = {
            let root = stage.root_layer();
            sdf::expr::stack_expression_variables(root.data(), &HashMap::new()).unwrap_or_default()
        };
        let mut own = Stack { default_prim: default_prim(stage.root_layer().data()), ..Stack::default() };
        let mut root_name = String::new();
        for name in stage.layer_stack() {
            let Some(layer) = stage.layer(&name) else { continue };
            own.layers += 1;
            own.add(layer.data(), layer.resolved_path().unwrap_or(&name), &resolver, &variables);
            if root_name.is_empty() {
                root_name = name;
            }
        }
        CompositionBudget {
            resolver,
            variables,
            stacks: vec![own],
            by_name: HashMap::from([(root_name, 0)]),
            known: HashMap::new(),
            charged: HashSet::new(),
            spent: 0,
            visited: 0,
        }
    }

    /// Takes the work of composing the prim of the stage at `path`.
    ///
    /// # Errors
    /// More than any asset needs.
    pub fn check(&mut self, moment: &Moment, path: &Path) -> Result<()> {
        let has_none = self.stacks.first().is_some_and(|own| own.arcs.is_empty() && own.layers * LAYER <= FREE);
        if has_none || !path.is_prim_path() || self.charged.contains(path) {
            return Ok(());
        }
        self.charged.insert(path.clone());
        let refuse = |what: String, expected: String| {
            Error::new(Where::Prim { file: moment.file.clone(), prim: path.as_str().to_owned() }, what)
                .expected(expected)
        };
        let work = self.work((0, path.clone())).map_err(|(what, most)| refuse(what, most))?;
        if work.sites > MOST_SITES {
            let what = format!("the prim is composed of {} opinions: its arcs and variants multiply", work.sites);
            return Err(refuse(what, format!("at most {MOST_SITES}")));
        }
        let units = work.units(path.element_count() as u64);
        if units > FREE {
            self.spent = self.spent.saturating_add(units);
        }
        if self.spent > MOST_WORK {
            let what =
                format!("composing the prims up to here takes {} units of work: arcs or layers multiply", self.spent);
            return Err(refuse(what, format!("at most {MOST_WORK}")));
        }
        Ok(())
    }

    fn work(&mut self, start: Site) -> std::result::Result<Work, (String, String)> {
        struct Frame {
            site: Site,
            edges: Edges,
            pending: Vec<Site>,
        }
        let flat = |edges: &Edges| edges.iter().flat_map(|(_, ways)| ways).flatten().cloned().collect::<Vec<Site>>();
        if let Some(&known) = self.known.get(&start) {
            return Ok(known);
        }
        let edges = self.edges(&start)?;
        let mut open = HashSet::from([start.clone()]);
        let mut frames = vec![Frame { site: start.clone(), pending: flat(&edges), edges }];
        let mut done: Vec<(Site, Edges)> = Vec::new();
        let mut goes_round = false;
        while let Some(frame) = frames.last_mut() {
            if let Some(next) = frame.pending.pop() {
                if self.known.contains_key(&next) {
                    continue;
                }
                if open.contains(&next) {
                    goes_round = true;
                    continue;
                }
                if frames.len() > MOST_CHAINED {
                    let what =
                        format!("more than {MOST_CHAINED} references, payloads, inherits or specializes in a chain");
                    return Err((what, format!("at most {MOST_CHAINED}")));
                }
                let edges = self.edges(&next)?;
                open.insert(next.clone());
                frames.push(Frame { pending: flat(&edges), site: next, edges });
                continue;
            }
            let Some(Frame { site, edges, .. }) = frames.pop() else { break };
            let sum = self.sum(&site, &edges);
            open.remove(&site);
            self.known.insert(site.clone(), sum);
            done.push((site, edges));
        }
        for _ in 0..if goes_round { ROUNDS } else { 0 } {
            let mut is_settled = true;
            for (site, edges) in &done {
                let sum = self.sum(site, edges);
                is_settled &= self.known.insert(site.clone(), sum) == Some(sum);
            }
            if is_settled || self.known.get(&start).is_some_and(|work| work.sites > MOST_SITES) {
                break;
            }
        }
        Ok(self.known.get(&start).copied().unwrap_or(Work::ONE))
    }

    /// A site that is not known yet is one that leads back here: itself alone.
    fn sum(&self, site: &Site, edges: &Edges) -> Work {
        let stack = self.stacks.get(site.0);
        let layers = stack.map_or(1, |stack| stack.layers);
        let has_class = stack.is_some_and(|stack| stack.has_class);
        let own = Work { sites: 1, layers, has_class };
        let mut sum = own;
        for (is_variant, ways) in edges {
            let mut most = Work::NONE;
            for way in ways {
                let start = if *is_variant { own } else { Work::NONE };
                let all =
                    way.iter().fold(start, |sum, next| sum.plus(self.known.get(next).copied().unwrap_or(Work::ONE)));
                most = most.max(all);
            }
            sum = sum.plus(most);
        }
        sum
    }

    /// Where a site's own arcs lead, and those of the prims above it, which lead to what is as far below their targets.
    fn edges(&mut self, site: &Site) -> std::result::Result<Edges, (String, String)> {
        self.visited += 1;
        if self.visited > MOST_VISITED {
            let what = format!("the arcs of the asset lead to more than {MOST_VISITED} places");
            return Err((what, format!("at most {MOST_VISITED}")));
        }
        let (stack, path) = site;
        // Per set of choices: whether it is a variant set, and the arcs of each choice.
        type Choices = (bool, Vec<Vec<(Arc, Path)>>);
        let mut found: Vec<Choices> = Vec::new();
        let Some(own) = self.stacks.get(*stack) else { return Ok(Vec::new()) };
        if own.arcs.is_empty() {
            return Ok(Vec::new());
        }
        for above in path.ancestors_below_root() {
            let Some(choices) = own.arcs.get(&above) else { continue };
            for choice in choices.values() {
                let ways = choice.ways.values();
                let ways = ways.map(|way| way.iter().map(|arc| (arc.clone(), above.clone())).collect()).collect();
                found.push((choice.is_variant, ways));
            }
        }
        let mut edges = Edges::new();
        for (is_variant, ways) in found {
            let mut own = Vec::new();
            for way in ways {
                let mut targets = Vec::new();
                for (arc, above) in way {
                    let (to, target) = match arc {
                        Arc::Inside(target) => (*stack, Some(target)),
                        Arc::Outside(name, target) => {
                            let to = self.stack(&name)?;
                            let default = self.stacks.get(to).and_then(|stack| stack.default_prim.clone());
                            (to, target.or(default))
                        }
                    };
                    // Without arcs one place is as good as another.
                    let is_plain = self.stacks.get(to).is_none_or(|stack| stack.arcs.is_empty());
                    if is_plain {
                        targets.push((to, Path::abs_root()));
                        continue;
                    }
                    let Some(target) = target.and_then(|target| path.replace_prefix(&above, &target)) else { continue };
                    // The library takes such an arc for one that goes round.
                    if to != *stack || !target.is_nested_with(path) {
                        targets.push((to, target));
                    }
                }
                own.push(targets);
            }
            edges.push((is_variant, own));
        }
        Ok(edges)
    }

    /// The stack of layers whose root is called `name`.
    fn stack(&mut self, name: &str) -> std::result::Result<usize, (String, String)> {
        if let Some(&known) = self.by_name.get(name) {
            return Ok(known);
        }
        let mut own = Stack::default();
        for (i, name) in
            sublayers::gather(&self.resolver, name).map_err(|what| (what, "fewer".to_owned()))?.iter().enumerate()
        {
            own.layers += 1;
            // A text without arcs need not be parsed twice.
            let resolved = self.resolver.resolve(name);
            let raw = resolved.and_then(|resolved| self.resolver.raw(&resolved).ok());
            if raw.is_some_and(|raw| raw.starts_with(b"#") && !arcs::may_be_in(&raw)) {
                continue;
            }
            let Ok(layer) = sdf::Layer::open_with(self.resolver.clone(), name) else { continue };
            if i == 0 {
                own.default_prim = default_prim(layer.data());
            }
            let overrides = &self.variables;
            let variables = sdf::expr::stack_expression_variables(layer.data(), overrides).unwrap_or_default();
            own.add(layer.data(), layer.resolved_path().unwrap_or(name), &self.resolver, &variables);
        }
        let index = self.stacks.len();
        self.stacks.push(own);
        self.by_name.insert(name.to_owned(), index);
        Ok(index)
    }
}

fn default_prim(data: &dyn sdf::AbstractData) -> Option<Path> {
    let found = data.try_field(&Path::abs_root(), "defaultPrim").ok()??;
    super::value::text(&found).and_then(sdf::default_prim_path)
}
