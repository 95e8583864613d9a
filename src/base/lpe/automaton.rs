//! What an expression takes of each class: both are automata, and their product is walked over every pair of states that
//! some path reaches, so the answer is no sample but a proof.

use super::parse::Node;
use super::{Letter, Set, Source};
use crate::path::{Class, Event, Trail};
use std::collections::{HashMap, VecDeque};

/// Most states of an expression's automaton.
const MOST_STATES: usize = 1000;
/// Most pairs of states that are walked.
const MOST_PAIRS: usize = 5000;

/// The events that paths of a scene can have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alphabet {
    /// Between eye and lamp; sources are left out.
    pub events: Vec<Letter>,
    /// How the group's lamps emit.
    pub sources: Vec<Source>,
}

/// What an expression takes of a class.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The scene has no such path.
    Impossible,
    Nothing,
    All,
    /// Some: a shortest path that it takes, and one that it leaves.
    Some {
        takes: String,
        leaves: String,
    },
}

/// Thompson's construction: states with empty moves and moves on letters.
#[derive(Default)]
pub(super) struct Machine {
    empty: Vec<Vec<usize>>,
    pub(super) on: Vec<Option<(Set, usize)>>,
}

impl Machine {
    pub(super) fn state(&mut self) -> Result<usize, String> {
        if self.on.len() >= MOST_STATES {
            return Err(format!("has more than {MOST_STATES} states"));
        }
        self.empty.push(Vec::new());
        self.on.push(None);
        Ok(self.on.len() - 1)
    }

    /// Adds `node` after the state `from`; tells the state behind it.
    pub(super) fn add(&mut self, node: &Node, from: usize, group: &str) -> Result<usize, String> {
        match node {
            Node::Empty => Ok(from),
            Node::Event(choices) => {
                let letters = choices.iter().fold(super::EVERY, |all, choice| all & choice.of_group(group));
                let (start, to) = (self.state()?, self.state()?);
                self.empty[from].push(start);
                self.on[start] = Some((letters, to));
                Ok(to)
            }
            Node::Sequence(all) => all.iter().try_fold(from, |at, node| self.add(node, at, group)),
            Node::Either(all) => {
                let to = self.state()?;
                for node in all {
                    let start = self.state()?;
                    self.empty[from].push(start);
                    let end = self.add(node, start, group)?;
                    self.empty[end].push(to);
                }
                Ok(to)
            }
            Node::Repeat(node, least, most) => {
                let mut at = from;
                for _ in 0..*least {
                    at = self.add(node, at, group)?;
                }
                let to = self.state()?;
                match most {
                    None => {
                        let start = self.state()?;
                        self.empty[at].push(start);
                        self.empty[start].push(to);
                        let end = self.add(node, start, group)?;
                        self.empty[end].push(start);
                    }
                    Some(most) => {
                        for _ in *least..*most {
                            self.empty[at].push(to);
                            // A state of its own, so that leaving early is no way back in.
                            let start = self.state()?;
                            self.empty[at].push(start);
                            at = self.add(node, start, group)?;
                        }
                        self.empty[at].push(to);
                    }
                }
                Ok(to)
            }
        }
    }

    /// The states that can be reached from these without an event, sorted.
    pub(super) fn closed(&self, states: Vec<usize>) -> Vec<usize> {
        let mut found = vec![false; self.on.len()];
        let mut open = states;
        let mut all = Vec::new();
        while let Some(state) = open.pop() {
            if !std::mem::replace(&mut found[state], true) {
                all.push(state);
                open.extend(&self.empty[state]);
            }
        }
        all.sort_unstable();
        all
    }

    fn after(&self, states: &[usize], letter: Letter) -> Vec<usize> {
        let bit = letter.bit();
        let moves = states.iter().filter_map(|state| self.on[*state]);
        self.closed(moves.filter(|(letters, _)| letters & bit != 0).map(|(_, to)| to).collect())
    }
}

/// The event of a path's trail that a letter is; none of a camera or a source.
pub(super) fn event(letter: Letter) -> Option<Event> {
    match letter {
        Letter::ReflectSpecular | Letter::TransmitSpecular | Letter::TransmitStraight | Letter::CrossSlide(_) => {
            Some(Event::Specular)
        }
        Letter::ReflectGlossy | Letter::TransmitGlossy => Some(Event::Glossy),
        Letter::ReflectDiffuse | Letter::TransmitDiffuse => Some(Event::Diffuse),
        Letter::Camera | Letter::Source(_) => None,
    }
}

pub fn decide(root: &Node, alphabet: &Alphabet, group: &str) -> Result<[Verdict; Class::ALL.len()], String> {
    let mut machine = Machine::default();
    let start = machine.state()?;
    let end = machine.add(root, start, group)?;
    let accepts = |states: &[usize]| states.binary_search(&end).is_ok();
    // A shortest path that is taken and one that is left, by class.
    let mut seen: [[Option<String>; 2]; Class::ALL.len()] = Default::default();
    let first = (machine.after(&machine.closed(vec![start]), Letter::Camera), Trail::START);
    let mut words: Vec<(usize, Letter)> = vec![(0, Letter::Camera)];
    let mut known = HashMap::from([(first.clone(), 0usize)]);
    let mut open = VecDeque::from([(first, 0usize)]);
    while let Some(((states, trail), word)) = open.pop_front() {
        for source in &alphabet.sources {
            let taken = accepts(&machine.after(&states, Letter::Source(*source)));
            let place = &mut seen[trail.class_from_eye() as usize][usize::from(!taken)];
            if place.is_none() {
                *place = Some(spell(&words, word, *source));
            }
        }
        for letter in &alphabet.events {
            let Some(event) = event(*letter) else { continue };
            let next = (machine.after(&states, *letter), trail.then(event));
            if known.contains_key(&next) {
                continue;
            }
            if known.len() >= MOST_PAIRS {
                return Err(format!("has more than {MOST_PAIRS} cases"));
            }
            words.push((word, *letter));
            known.insert(next.clone(), words.len() - 1);
            open.push_back((next, words.len() - 1));
        }
    }
    Ok(seen.map(|[takes, leaves]| match (takes, leaves) {
        (None, None) => Verdict::Impossible,
        (Some(_), None) => Verdict::All,
        (None, Some(_)) => Verdict::Nothing,
        (Some(takes), Some(leaves)) => Verdict::Some { takes, leaves },
    }))
}

fn spell(words: &[(usize, Letter)], mut word: usize, source: Source) -> String {
    let mut letters = vec![Letter::Source(source)];
    while word != 0 {
        let (before, letter) = words[word];
        letters.push(letter);
        word = before;
    }
    letters.push(Letter::Camera);
    letters.iter().rev().map(|letter| letter.symbol()).collect()
}
