//! Which of several expressions take a path, told event by event from either end.
//!
//! An expression is a machine whose states can be several at once. From the eye a path stands at the states that its
//! events so far lead to, from the lamp at those from which the rest leads to the end: the expression takes the path if
//! the two have a state in common where the ways meet. Both sets are numbered beforehand, for all expressions together,
//! so a path carries one small number, and where it ends or two pieces meet the answer is read from a table.

use super::automaton::{Machine, event};
use super::{Letter, Lpe, MOST_SLIDES, Source};
use crate::path::{Class, Trail};
use std::collections::{BTreeSet, HashMap, HashSet};

/// Which expressions take a path: a bit each.
pub type Takes = u32;
/// Most expressions.
pub const MOST: usize = Takes::BITS as usize;
/// Most numbered sets on either side, and most pairs of both.
const MOST_SETS: usize = 1 << 12;
const MOST_PAIRS: usize = 1 << 21;

/// What a path has told so far: the number of a set of states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct LpeState(u16);

/// The events between eye and lamp: all letters but the camera and the sources.
const EVENTS: [Letter; 7 + MOST_SLIDES] = {
    let [_, events @ .., _, _, _] = Letter::ALL;
    events
};
const SOURCES: [Source; 3] = [Source::Face, Source::Light, Source::Sky];

type Moves = Vec<[LpeState; EVENTS.len()]>;
/// What is taken of a class, without and with a broad scatterer.
type Possible = [[BTreeSet<Takes>; 2]; Class::ALL.len()];

/// Expressions, ready to be told paths of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    from_eye: Moves,
    from_lamp: Moves,
    /// Per light group and source.
    lamps: Vec<[LpeState; SOURCES.len()]>,
    /// `[told from the eye][told from the lamp]`
    takes: Vec<Takes>,
    /// Per light group.
    possible: Vec<Possible>,
    /// Some of the expressions take what crosses two slides once each.
    parts_series: bool,
}

/// A set of states, a bit each.
type States = Vec<u64>;

fn with(states: &mut States, state: usize) {
    states[state / 64] |= 1 << (state % 64);
}

fn of(states: &States) -> impl Iterator<Item = usize> {
    let bits = |word: u64| (0..64).filter(move |bit| word >> bit & 1 == 1);
    states.iter().enumerate().flat_map(move |(index, word)| bits(*word).map(move |bit| 64 * index + bit))
}

/// The machines of all expressions, side by side, as the lamps of one group see them.
struct Net {
    machine: Machine,
    /// Per expression, and where its states begin.
    starts: Vec<usize>,
    ends: Vec<usize>,
    /// Per state: those that it reaches without an event, and those that reach it.
    onward: Vec<States>,
    back: Vec<States>,
}

/// Where events lead, the sets by number, and the numbers of sets.
type Numbered = (Moves, Vec<States>, HashMap<States, LpeState>);

impl Net {
    fn new(expressions: &[Lpe], group: &str) -> Result<Net, String> {
        let mut machine = Machine::default();
        let (mut starts, mut ends) = (Vec::new(), Vec::new());
        for lpe in expressions {
            let start = machine.state()?;
            starts.push(start);
            ends.push(machine.add(&lpe.root, start, group)?);
        }
        let count = machine.on.len();
        let none = vec![0u64; count.div_ceil(64)];
        let (mut onward, mut back) = (vec![none.clone(); count], vec![none; count]);
        for (state, onward) in onward.iter_mut().enumerate() {
            for reached in machine.closed(vec![state]) {
                with(onward, reached);
                with(&mut back[reached], state);
            }
        }
        Ok(Net { machine, starts, ends, onward, back })
    }

    fn none(&self) -> States {
        vec![0; self.machine.on.len().div_ceil(64)]
    }

    /// From states along an event, towards the lamp or towards the eye.
    fn step(&self, states: &States, letter: Letter, onward: bool) -> States {
        let bit = letter.bit();
        let mut next = self.none();
        let mut add = |more: &States| next.iter_mut().zip(more).for_each(|(own, more)| *own |= more);
        for (from, on) in self.machine.on.iter().enumerate() {
            let Some((_, to)) = on.filter(|(letters, _)| letters & bit != 0) else { continue };
            let (at, reached) = if onward { (from, &self.onward[to]) } else { (to, &self.back[from]) };
            if states[at / 64] >> (at % 64) & 1 == 1 {
                add(reached);
            }
        }
        next
    }

    /// Where paths from the eye begin.
    fn eye(&self) -> States {
        let mut states = self.none();
        self.starts.iter().flat_map(|start| of(&self.onward[*start])).for_each(|state| with(&mut states, state));
        self.step(&states, Letter::Camera, true)
    }

    /// Where paths from a source begin.
    fn lamp(&self, source: Source) -> States {
        let mut states = self.none();
        self.ends.iter().flat_map(|end| of(&self.back[*end])).for_each(|state| with(&mut states, state));
        self.step(&states, Letter::Source(source), false)
    }

    /// All sets that events lead to from `first`, numbered in the order in which they are found, `first` before others.
    fn number(&self, first: Vec<States>, onward: bool) -> Result<Numbered, String> {
        let mut known: HashMap<States, LpeState> = HashMap::new();
        let (mut sets, mut moves): (Vec<States>, Moves) = (Vec::new(), Vec::new());
        let mut number = |states: States, sets: &mut Vec<States>| -> Result<LpeState, String> {
            if let Some(told) = known.get(&states) {
                return Ok(*told);
            }
            let next = u16::try_from(sets.len()).ok().filter(|next| usize::from(*next) < MOST_SETS);
            let told = LpeState(next.ok_or_else(|| format!("has more than {MOST_SETS} cases"))?);
            known.insert(states.clone(), told);
            sets.push(states);
            Ok(told)
        };
        for states in first {
            number(states, &mut sets)?;
        }
        while moves.len() < sets.len() {
            let from = sets[moves.len()].clone();
            let mut row = [LpeState::default(); EVENTS.len()];
            for (to, letter) in row.iter_mut().zip(EVENTS) {
                *to = number(self.step(&from, letter, onward), &mut sets)?;
            }
            moves.push(row);
        }
        Ok((moves, sets, known))
    }
}

impl Product {
    /// `groups`: the names of the light groups and how their lamps emit; `events`: what can happen on the scene's faces.
    /// Errors: too many expressions, or too many cases of them together.
    pub fn new(expressions: &[Lpe], groups: &[(&str, Vec<Source>)], events: &[Letter]) -> Result<Product, String> {
        if expressions.len() > MOST {
            return Err(format!("is one more than {MOST} that part classes of paths"));
        }
        // Labels change what sources match, and nothing else: the states are the same for all groups.
        let nets = groups.iter().map(|(name, _)| Net::new(expressions, name)).collect::<Result<Vec<Net>, String>>()?;
        let net = Net::new(expressions, "")?;
        let (from_eye, eyes, _) = net.number(vec![net.eye()], true)?;
        let first: Vec<[States; 3]> = nets.iter().map(|net| SOURCES.map(|source| net.lamp(source))).collect();
        let (from_lamp, ends, known) = net.number(first.as_flattened().to_vec(), false)?;
        if eyes.len() * ends.len() > MOST_PAIRS {
            return Err(format!("has more than {MOST_PAIRS} cases"));
        }
        let told = |states: &States| known.get(states).copied().unwrap_or_default();
        let lamps = first.iter().map(|states| states.each_ref().map(told)).collect();
        let spans: Vec<States> = (0..expressions.len())
            .map(|k| {
                let mut span = net.none();
                let end = net.starts.get(k + 1).copied().unwrap_or(net.machine.on.len());
                (net.starts[k]..end).for_each(|state| with(&mut span, state));
                span
            })
            .collect();
        let meet = |eye: &States, lamp: &States| {
            let in_span = |span: &States| span.iter().zip(eye).zip(lamp).any(|((a, b), c)| a & b & c != 0);
            spans.iter().enumerate().fold(0, |takes, (k, span)| takes | Takes::from(in_span(span)) << k)
        };
        let takes = eyes.iter().flat_map(|eye| ends.iter().map(move |lamp| (eye, lamp))).map(|(a, b)| meet(a, b));
        let mut sieve =
            Product { from_eye, from_lamp, lamps, takes: takes.collect(), possible: Vec::new(), parts_series: false };
        sieve.possible = sieve.find_possible(groups, events);
        Ok(sieve)
    }

    /// Walks every pair of what is told and class that some path of the scene reaches.
    fn find_possible(&self, groups: &[(&str, Vec<Source>)], events: &[Letter]) -> Vec<Possible> {
        let mut possible = vec![Possible::default(); groups.len()];
        let first = (self.eye(), Trail::START);
        let (mut open, mut known) = (vec![first], HashSet::from([first]));
        while let Some((told, trail)) = open.pop() {
            for (group, (possible, (_, sources))) in possible.iter_mut().zip(groups).enumerate() {
                let of_class = &mut possible[trail.class_from_eye() as usize][usize::from(trail.has_broad())];
                let lamps = self.lamps[group];
                of_class.extend(sources.iter().map(|source| self.takes(told, lamps[*source as usize])));
            }
            for letter in events {
                let Some(event) = event(*letter) else { continue };
                let next = (self.after(told, *letter), trail.then(event));
                if known.insert(next) {
                    open.push(next);
                }
            }
        }
        possible
    }

    /// The same, which tells light through slides in series: that of each is to be told apart.
    #[must_use]
    pub fn parting_series(self) -> Product {
        Product { parts_series: true, ..self }
    }

    /// Whether light through slides in series is told.
    pub fn parts_series(&self) -> bool {
        self.parts_series
    }

    /// Of a path that has just left the eye.
    pub fn eye(&self) -> LpeState {
        LpeState(0)
    }

    /// Of a path that has just left a lamp of a light group.
    pub fn lamp(&self, group: usize, source: Source) -> LpeState {
        self.lamps.get(group).map_or(LpeState(0), |lamps| lamps[source as usize])
    }

    /// Of a path from the eye after one more event.
    pub fn after(&self, told: LpeState, letter: Letter) -> LpeState {
        moved(&self.from_eye, told, letter)
    }

    /// Of a path from a lamp after one more event.
    pub fn before(&self, told: LpeState, letter: Letter) -> LpeState {
        moved(&self.from_lamp, told, letter)
    }

    /// What is taken of a path whose pieces from the eye and from the lamp are these, every event in one of them.
    pub fn takes(&self, eye: LpeState, lamp: LpeState) -> Takes {
        self.takes.get(usize::from(eye.0) * self.from_lamp.len() + usize::from(lamp.0)).copied().unwrap_or(0)
    }

    /// All that can be taken of the paths of a light group and class, with or without a broad scatterer, in rising order.
    pub fn possible(&self, group: usize, class: Class, broad: bool) -> impl Iterator<Item = Takes> {
        let of_class = self.possible.get(group).map(|possible| &possible[class as usize][usize::from(broad)]);
        of_class.into_iter().flatten().copied()
    }
}

fn moved(moves: &Moves, told: LpeState, letter: Letter) -> LpeState {
    let row = moves.get(usize::from(told.0));
    // Events are the letters after the camera's.
    row.and_then(|row| row.get(letter.index().checked_sub(1)?)).copied().unwrap_or(told)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What paths of scenes without several slides can do.
    const PLAIN: [Letter; 7] = {
        let [events @ .., _, _, _, _, _, _, _, _] = EVENTS;
        events
    };

    fn words(letters: &[Letter], length: usize) -> Vec<Vec<Letter>> {
        (0..letters.len().pow(length as u32))
            .map(|mut code| {
                (0..length)
                    .map(|_| {
                        let letter = letters[code % letters.len()];
                        code /= letters.len();
                        letter
                    })
                    .collect()
            })
            .collect()
    }

    /// Every path of up to four events is taken by the same expressions from either end and joined anywhere, and they are
    /// those whose regular expression over one character an event matches it.
    #[test]
    fn both_ends_and_every_joint_agree() {
        // Characters: r g d reflected, t s n x transmitted (specular, straight, narrow, broad); O B a face or the sky of
        // `led`, in lower case of `sun`.
        let cases = [
            ("C<RS>.*L", "^r.*$"),
            ("C<T.>*<RS><TS>+<L.'led'>", "^[tsnx]*rt+[OB]$"),
            ("C(<R.>|<TS>{2})*<.D>?[^B]", "^([rgd]|tt)*[dx]?[Oo]$"),
            ("C.*<.[^S]>[^'led']", "^.*[gdsnx][ob]$"),
            ("C<R.>?<.s>{1,2}.*<RD>O", "^[rgd]?s{1,2}.*d[Oo]$"),
        ];
        let lpes = cases.map(|(text, _)| Lpe::parse(text).unwrap_or_else(|fault| panic!("{text} {fault}")));
        let want = cases.map(|(_, text)| regex::Regex::new(text).expect("a sound expression"));
        let both = vec![Source::Face, Source::Sky];
        let groups = [("led", both.clone()), ("sun", both)];
        let sieve = Product::new(&lpes, &groups, &PLAIN).expect("few cases");
        let symbol = |letter: &Letter| match letter {
            Letter::ReflectSpecular => 'r',
            Letter::ReflectGlossy => 'g',
            Letter::ReflectDiffuse => 'd',
            Letter::TransmitSpecular => 't',
            Letter::TransmitStraight => 's',
            Letter::TransmitGlossy => 'n',
            Letter::TransmitDiffuse => 'x',
            Letter::Camera | Letter::CrossSlide(_) | Letter::Source(_) => panic!("no event"),
        };
        let ends = [(0, Source::Face, 'O'), (0, Source::Sky, 'B'), (1, Source::Face, 'o'), (1, Source::Sky, 'b')];
        for word in (0..=4).flat_map(|length| words(&PLAIN, length)) {
            for (group, source, last) in ends {
                let text: String = word.iter().map(symbol).chain([last]).collect();
                let matches = |(k, want): (usize, &regex::Regex)| Takes::from(want.is_match(&text)) << k;
                let want: Takes = want.iter().enumerate().map(matches).sum();
                for cut in 0..=word.len() {
                    let eye = word[..cut].iter().fold(sieve.eye(), |told, letter| sieve.after(told, *letter));
                    let lamp = sieve.lamp(group, source);
                    let lamp = word[cut..].iter().rev().fold(lamp, |told, letter| sieve.before(told, *letter));
                    assert_eq!(sieve.takes(eye, lamp), want, "{text} cut at {cut}");
                }
                let trail = word.iter().filter_map(|letter| event(*letter)).fold(Trail::START, Trail::then);
                let (class, broad) = (trail.class_from_eye(), trail.has_broad());
                assert!(sieve.possible(group, class, broad).any(|takes| takes == want), "{text}");
            }
        }
    }

    #[test]
    fn what_has_too_many_cases_is_refused() {
        let lpe = Lpe::parse("C.*<RS>.{14}L").expect("an expression");
        let said = Product::new(&[lpe], &[("led", vec![Source::Face])], &EVENTS).unwrap_err();
        assert!(said.contains("cases"), "{said}");
    }

    /// Paths through one of several slides, through none and through two are told apart from either end and joined anywhere;
    /// for other expressions a slide is a straight transmission.
    #[test]
    fn slides_are_told_apart() {
        let slide = Letter::CrossSlide;
        let letters = [Letter::ReflectDiffuse, Letter::TransmitStraight, slide(0), slide(1), slide(2)];
        let straight = Lpe::parse("C<.s>+L").unwrap();
        let crossing = [None, Some(0), Some(1), Some(2)].map(Lpe::crossing);
        let once = [(0, Some(2)), (1, Some(2)), (1, None)];
        let all: Vec<Lpe> =
            [straight].into_iter().chain(crossing).chain(once.map(|(a, b)| Lpe::crossing_once(a, b))).collect();
        let groups = [("led", vec![Source::Face])];
        let sieve = Product::new(&all, &groups, &letters).expect("few cases");
        for word in (0..=4).flat_map(|length| words(&letters, length)) {
            let crossed_by = |letter: &Letter| match letter {
                Letter::CrossSlide(slide) => Some(*slide),
                _ => None,
            };
            let crossed: BTreeSet<u8> = word.iter().filter_map(crossed_by).collect();
            let by_slide = match crossed.len() {
                0 => 0b10,
                1 => 0b100 << crossed.first().expect("one"),
                _ => 0,
            };
            let mut crossings: Vec<u8> = word.iter().filter_map(crossed_by).collect();
            crossings.sort_unstable();
            let is = |(a, b): (u8, Option<u8>)| crossings.iter().copied().eq([a].into_iter().chain(b));
            let once = once.into_iter().enumerate().filter(|(_, slides)| is(*slides));
            let once = once.fold(0, |takes: Takes, (k, _)| takes | 0b10_0000 << k);
            let want = Takes::from(!word.is_empty() && !word.contains(&Letter::ReflectDiffuse)) | by_slide | once;
            for cut in 0..=word.len() {
                let eye = word[..cut].iter().fold(sieve.eye(), |told, letter| sieve.after(told, *letter));
                let lamp = sieve.lamp(0, Source::Face);
                let lamp = word[cut..].iter().rev().fold(lamp, |told, letter| sieve.before(told, *letter));
                assert_eq!(sieve.takes(eye, lamp), want, "{word:?} cut at {cut}");
            }
        }
    }
}
