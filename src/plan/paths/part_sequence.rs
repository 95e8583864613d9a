//! What a light path does at the parts that it meets, part by part: a chain of faces as people read it.

use eyebox_base::chain::{Chain, Link, Step};
use eyebox_scene::Scene;
use std::collections::BTreeSet;

/// What a path does at one part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// Passes: into a solid and out of it, or through a slide or a sheet.
    Through,
    /// Is reflected by what has no inside: a mirror.
    Mirror,
    /// Is reflected where it meets a solid from outside.
    Front,
    /// Goes into a solid, is reflected once, and leaves by the face that it came in by.
    Back,
    /// Is reflected inside a solid this often (a last number of [`How::MANY`]: or more) and leaves.
    Inside(u8),
}

impl How {
    /// Reflections inside a solid are counted up to here: a light guide is one thing, however long.
    pub const MANY: u8 = 4;

    /// The word of patterns and of JSON.
    pub fn word(self) -> &'static str {
        match self {
            How::Through => "through",
            How::Mirror => "mirror",
            How::Front => "front",
            How::Back => "back",
            How::Inside(_) => "inside",
        }
    }

    pub const WORDS: [&'static str; 5] = ["through", "mirror", "front", "back", "inside"];
}

/// A part on the way and what happens there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Visit {
    pub part: u32,
    pub how: How,
}

/// The parts that a path meets, from the lamp to the eye. CAD faces of one part are not told apart, only its two sides.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Visits {
    pub all: Vec<Visit>,
    /// More than [`Visits::MOST`] followed.
    pub cut: bool,
}

impl Visits {
    pub const MOST: usize = 64;

    /// Reads a chain that runs from lamp to eye. `solid`: a part has an inside; `around`: the path starts inside of it.
    pub fn of(chain: &Chain, solid: impl Fn(u32) -> bool, around: impl Fn(u32) -> bool) -> Visits {
        let mut visits = Visits::default();
        // Parts that the path is inside of although it has met others since.
        let mut open: BTreeSet<u32> = BTreeSet::new();
        let mut met: BTreeSet<u32> = BTreeSet::new();
        for run in chain.0.chunk_by(|a, b| a.part == b.part) {
            let Some(part) = run.first().map(|link| link.part) else { continue };
            if !solid(part) {
                let how = |link: &Link| if link.step == Step::Back { How::Mirror } else { How::Through };
                run.iter().for_each(|link| visits.push(part, how(link)));
                continue;
            }
            let inside = open.contains(&part) || (met.insert(part) && around(part));
            if visits.solid(part, run, inside) {
                open.insert(part);
            } else {
                open.remove(&part);
            }
        }
        visits
    }

    /// Adds what happens on a run of faces of one solid; returns whether it ends inside.
    fn solid(&mut self, part: u32, run: &[Link], mut inside: bool) -> bool {
        let (mut entry, mut backs, mut pending) = (None, 0u8, inside);
        for link in run {
            match (link.step, inside) {
                (Step::Back, false) => self.push(part, How::Front),
                (Step::Back, true) => (backs, pending) = (backs.saturating_add(1), true),
                (Step::Through, false) => (inside, entry, backs, pending) = (true, Some(link.face), 0, true),
                (Step::Through, true) => {
                    inside = false;
                    pending = false;
                    self.push(part, inner(backs, entry == Some(link.face)));
                }
            }
        }
        if pending {
            self.push(part, inner(backs, false));
        }
        inside
    }

    fn push(&mut self, part: u32, how: How) {
        let visit = Visit { part, how };
        if self.all.last() == Some(&visit) && how == How::Through {
            return;
        }
        if self.all.len() < Self::MOST {
            self.all.push(visit);
        } else {
            self.cut = true;
        }
    }

    /// Parts that the path passes without being reflected, and that are in `parts`.
    pub fn passes(&self, parts: &BTreeSet<u32>) -> BTreeSet<u32> {
        let through = self.all.iter().filter(|visit| visit.how == How::Through && parts.contains(&visit.part));
        through.map(|visit| visit.part).collect()
    }

    /// The parts that are met.
    pub fn parts(&self) -> BTreeSet<u32> {
        self.all.iter().map(|visit| visit.part).collect()
    }

    /// The parts' names and what is not plain passing, in order.
    pub fn words(&self, scene: &Scene) -> Vec<String> {
        let mut words: Vec<String> = self.all.iter().map(|visit| word(scene, *visit)).collect();
        words.dedup();
        if self.cut {
            words.push("…".to_owned());
        }
        words
    }
}

fn inner(backs: u8, same_face: bool) -> How {
    match backs {
        0 => How::Through,
        1 if same_face => How::Back,
        many => How::Inside(many.min(How::MANY)),
    }
}

fn word(scene: &Scene, Visit { part, how }: Visit) -> String {
    let name = part_name(scene, part);
    match how {
        How::Through | How::Mirror => name,
        How::Front => format!("{name} front"),
        How::Back => format!("{name} back"),
        How::Inside(0 | 1) => format!("inside {name}"),
        How::Inside(How::MANY..) => format!("inside {name} ×{} or more", How::MANY),
        How::Inside(many) => format!("inside {name} ×{many}"),
    }
}

/// A part's name, or its path where the name is not its own.
pub fn part_name(scene: &Scene, part: u32) -> String {
    let Some(own) = scene.parts.get(part as usize) else { return String::new() };
    let alone = scene.parts.iter().filter(|other| other.name == own.name).count() == 1;
    if alone { own.name.clone() } else { own.path.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Part, face, and `t` or `b`.
    fn visits(links: &[(u32, u32, char)], around: Option<u32>) -> Vec<(u32, How)> {
        let step = |c: char| if c == 'b' { Step::Back } else { Step::Through };
        let chain = Chain(links.iter().map(|&(part, face, c)| Link { part, face, step: step(c), order: 0 }).collect());
        // Parts from 10 on have no inside.
        let visits = Visits::of(&chain, |part| part < 10, |part| Some(part) == around);
        visits.all.iter().map(|visit| (visit.part, visit.how)).collect()
    }

    #[test]
    fn chains_are_read_part_by_part() {
        use How::{Back, Front, Inside, Mirror, Through};
        // A lens, a slide, a mirror, a plate's front.
        let main = [(0, 0, 't'), (0, 1, 't'), (10, 0, 't'), (11, 0, 'b'), (1, 0, 'b')];
        assert_eq!(visits(&main, None), [(0, Through), (10, Through), (11, Mirror), (1, Front)]);
        // In by the front, back, out by the front; and a prism, which is left by another face.
        assert_eq!(visits(&[(1, 0, 't'), (1, 1, 'b'), (1, 0, 't')], None), [(1, Back)]);
        assert_eq!(visits(&[(1, 0, 't'), (1, 1, 'b'), (1, 2, 't')], None), [(1, Inside(1))]);
        // Twice inside a lens, and a light guide.
        assert_eq!(visits(&[(0, 0, 't'), (0, 1, 'b'), (0, 0, 'b'), (0, 1, 't')], None), [(0, Inside(2))]);
        let mut guide = vec![(0, 0, 't')];
        guide.extend((0..900).map(|k| (0, 1 + k % 2, 'b')));
        guide.push((0, 3, 't'));
        assert_eq!(visits(&guide, None), [(0, Inside(How::MANY))]);
        // A lamp inside a solid, whose light is reflected there before it leaves.
        assert_eq!(visits(&[(0, 1, 'b'), (0, 2, 't')], Some(0)), [(0, Inside(1))]);
        // A ball inside a block: the block's far side is met from inside.
        let nested = [(0, 0, 't'), (1, 0, 't'), (1, 0, 't'), (0, 1, 'b'), (0, 0, 't')];
        assert_eq!(visits(&nested, None), [(0, Through), (1, Through), (0, Inside(1))]);
        // Back and forth between two lenses.
        let between = [(0, 0, 't'), (0, 1, 't'), (1, 0, 'b'), (0, 1, 'b'), (1, 0, 't'), (1, 1, 't')];
        assert_eq!(visits(&between, None), [(0, Through), (1, Front), (0, Front), (1, Through)]);
    }

    #[test]
    fn long_chains_are_cut() {
        let links: Vec<_> = (0..1000).map(|k| (10 + k % 2, 0, 't')).collect();
        let chain =
            Chain(links.iter().map(|&(part, face, _)| Link { part, face, step: Step::Back, order: 0 }).collect());
        let visits = Visits::of(&chain, |_| false, |_| false);
        assert_eq!((visits.all.len(), visits.cut), (Visits::MOST, true));
    }
}
