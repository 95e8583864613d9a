//! Text → tree. Expressions come from files: lengths and depths are bounded.

use super::{EVERY, Letter, MOST_SLIDES, Set, Source};

/// Most characters of an expression.
const LONGEST: usize = 4096;
/// Most brackets inside each other.
const DEEPEST: usize = 64;
/// Most repetitions that may be asked for by number.
const MOST_REPEATS: u32 = 64;
/// Most signs of repetition after one event.
const MOST_SIGNS: usize = 8;

/// An expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Node {
    /// Nothing at all.
    Empty,
    /// One event that all of these match.
    Event(Vec<Choice>),
    Sequence(Vec<Node>),
    Either(Vec<Node>),
    /// At least so often, and at most (none: any number).
    Repeat(Box<Node>, u32, Option<u32>),
}

/// Letters, or sources of a light group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    letters: Set,
    labels: Vec<String>,
    negated: bool,
}

impl Node {
    /// See [`Lpe::crossing`](super::Lpe::crossing).
    pub fn crossing(only: Option<u8>) -> Node {
        let event = |letters: Set| Node::Event(vec![Choice::letters(letters)]);
        let any = |letters: Set| Node::Repeat(Box::new(event(letters)), 0, None);
        let others = EVERY & !(SOURCES | SLIDES | set(&[Letter::Camera]));
        let mut all = vec![event(set(&[Letter::Camera])), any(others)];
        if let Some(only) = only {
            let own = set(&[Letter::CrossSlide(only)]);
            all.extend([event(own), any(others | own)]);
        }
        all.push(event(SOURCES));
        Node::Sequence(all)
    }

    /// See [`Lpe::crossing_once`](super::Lpe::crossing_once).
    pub fn crossing_once(slide: u8, other: Option<u8>) -> Node {
        let event = |letters: Set| Node::Event(vec![Choice::letters(letters)]);
        let rest = || Node::Repeat(Box::new(event(EVERY & !(SOURCES | SLIDES | set(&[Letter::Camera])))), 0, None);
        let cross = |slide: u8| event(set(&[Letter::CrossSlide(slide)]));
        let both = |first: u8, then: u8| Node::Sequence(vec![cross(first), rest(), cross(then)]);
        let crossed = match other {
            None => cross(slide),
            Some(other) => Node::Either(vec![both(slide, other), both(other, slide)]),
        };
        Node::Sequence(vec![event(set(&[Letter::Camera])), rest(), crossed, rest(), event(SOURCES)])
    }

    /// Whether it says the name of this light group.
    pub fn names(&self, group: &str) -> bool {
        match self {
            Node::Empty => false,
            Node::Event(all) => all.iter().flat_map(|choice| &choice.labels).any(|label| label == group),
            Node::Sequence(all) | Node::Either(all) => all.iter().any(|node| node.names(group)),
            Node::Repeat(node, ..) => node.names(group),
        }
    }
}

impl Choice {
    fn letters(letters: Set) -> Self {
        Choice { letters, labels: Vec::new(), negated: false }
    }

    /// The letters that match where the sources are those of `group`.
    pub fn of_group(&self, group: &str) -> Set {
        let named = self.labels.iter().any(|label| label == group);
        let letters = self.letters | if named { SOURCES } else { 0 };
        if self.negated { EVERY & !letters } else { letters }
    }
}

fn set(letters: &[Letter]) -> Set {
    letters.iter().fold(0, |set, letter| set | letter.bit())
}

/// The three last of [`Letter::ALL`].
const SOURCES: Set = 0b111 << (Letter::ALL.len() - 3);
/// Those before them.
const SLIDES: Set = ((1 << MOST_SLIDES) - 1) << (Letter::ALL.len() - 3 - MOST_SLIDES);

/// What a single letter of an expression stands for: events of this type, or of this scattering. None: no letter of ours.
fn meaning(letter: char) -> Option<Set> {
    use Letter::*;
    Some(match letter {
        'C' | 'E' => set(&[Camera]),
        'R' => set(&[ReflectSpecular, ReflectGlossy, ReflectDiffuse]),
        'T' => set(&[TransmitSpecular, TransmitStraight, TransmitGlossy, TransmitDiffuse]) | SLIDES,
        // No medium scatters.
        'V' => 0,
        'L' => SOURCES,
        'O' => set(&[Source(self::Source::Face)]),
        'B' => set(&[Source(self::Source::Sky)]),
        'S' => set(&[ReflectSpecular, TransmitSpecular]),
        's' => set(&[TransmitStraight]) | SLIDES,
        'G' => set(&[ReflectGlossy, TransmitGlossy]),
        'D' => set(&[ReflectDiffuse, TransmitDiffuse]),
        '.' => EVERY,
        _ => return None,
    })
}

struct Reader<'t> {
    rest: std::iter::Peekable<std::str::CharIndices<'t>>,
    depth: usize,
}

/// Reads a whole expression. Blanks do not count outside of labels.
pub fn parse(text: &str) -> Result<Node, String> {
    if text.chars().count() > LONGEST {
        return Err(format!("is longer than {LONGEST} characters"));
    }
    let mut reader = Reader { rest: text.char_indices().peekable(), depth: 0 };
    let node = reader.either()?;
    match reader.peek() {
        None if node == Node::Empty => Err("is empty".to_owned()),
        None => Ok(node),
        Some(letter) => Err(reader.wrong(&format!("`{letter}` closes nothing"))),
    }
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<char> {
        while self.rest.next_if(|(_, letter)| letter.is_whitespace()).is_some() {}
        self.rest.peek().map(|(_, letter)| *letter)
    }
    fn next(&mut self) -> Option<char> {
        self.peek();
        self.rest.next().map(|(_, letter)| letter)
    }
    fn take(&mut self, letter: char) -> bool {
        let is = self.peek() == Some(letter);
        if is {
            self.rest.next();
        }
        is
    }
    fn wrong(&mut self, what: &str) -> String {
        match self.rest.peek() {
            Some((at, _)) => format!("{what}, at byte {at}"),
            None => format!("{what}, at its end"),
        }
    }

    fn either(&mut self) -> Result<Node, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("has more than {DEEPEST} brackets inside each other"));
        }
        let mut cases = vec![self.sequence()?];
        while self.take('|') {
            cases.push(self.sequence()?);
        }
        self.depth -= 1;
        Ok(if cases.len() == 1 { cases.remove(0) } else { Node::Either(cases) })
    }

    fn sequence(&mut self) -> Result<Node, String> {
        let mut all = Vec::new();
        while let Some(letter) = self.peek() {
            if matches!(letter, '|' | ')') {
                break;
            }
            let one = self.one()?;
            all.push(self.repeated(one)?);
        }
        Ok(match all.len() {
            0 => Node::Empty,
            1 => all.remove(0),
            _ => Node::Sequence(all),
        })
    }

    fn one(&mut self) -> Result<Node, String> {
        if self.take('(') {
            let inner = self.either()?;
            return if self.take(')') { Ok(inner) } else { Err(self.wrong("`)` is missing")) };
        }
        if self.take('<') {
            let mut all = Vec::new();
            while !self.take('>') {
                if self.peek().is_none() {
                    return Err(self.wrong("`>` is missing"));
                }
                all.push(self.choice()?);
            }
            if all.is_empty() {
                return Err(self.wrong("`<>` says nothing"));
            }
            return Ok(Node::Event(all));
        }
        Ok(Node::Event(vec![self.choice()?]))
    }

    /// A letter, a label, or several in square brackets.
    fn choice(&mut self) -> Result<Choice, String> {
        if !self.take('[') {
            let mut choice = Choice::letters(0);
            self.member(&mut choice)?;
            return Ok(choice);
        }
        let mut choice = Choice { letters: 0, labels: Vec::new(), negated: self.take('^') };
        while !self.take(']') {
            if self.peek().is_none() {
                return Err(self.wrong("`]` is missing"));
            }
            self.member(&mut choice)?;
        }
        Ok(choice)
    }

    fn member(&mut self, choice: &mut Choice) -> Result<(), String> {
        if self.take('\'') {
            let mut label = String::new();
            loop {
                match self.rest.next() {
                    Some((_, '\'')) => break,
                    Some((_, letter)) => label.push(letter),
                    None => return Err(self.wrong("a label has no closing quote")),
                }
            }
            choice.labels.push(label);
            return Ok(());
        }
        let letter = self.peek();
        match letter.and_then(meaning) {
            Some(letters) => {
                self.rest.next();
                choice.letters |= letters;
                Ok(())
            }
            None => {
                let what = letter.map_or("an event is missing".to_owned(), |letter| {
                    format!("`{letter}` is no event; there are C R T L O B V, S s G D, . and 'light group'")
                });
                Err(self.wrong(&what))
            }
        }
    }

    fn repeated(&mut self, mut node: Node) -> Result<Node, String> {
        for _ in 0..=MOST_SIGNS {
            let (least, most) = if self.take('*') {
                (0, None)
            } else if self.take('+') {
                (1, None)
            } else if self.take('?') {
                (0, Some(1))
            } else if self.take('{') {
                self.counts()?
            } else {
                return Ok(node);
            };
            node = Node::Repeat(Box::new(node), least, most);
        }
        Err(self.wrong(&format!("more than {MOST_SIGNS} signs of repetition follow each other")))
    }

    fn counts(&mut self) -> Result<(u32, Option<u32>), String> {
        let least = self.number()?;
        let most = if !self.take(',') {
            Some(least)
        } else if self.peek() == Some('}') {
            None
        } else {
            Some(self.number()?)
        };
        if !self.take('}') {
            return Err(self.wrong("`}` is missing"));
        }
        if most.is_some_and(|most| most < least) {
            return Err(self.wrong("repeats at least more often than at most"));
        }
        Ok((least, most))
    }

    fn number(&mut self) -> Result<u32, String> {
        let mut digits = String::new();
        while let Some(digit) = self.peek().filter(char::is_ascii_digit) {
            digits.push(digit);
            self.next();
        }
        match digits.parse::<u32>() {
            Ok(number) if number <= MOST_REPEATS => Ok(number),
            Ok(_) | Err(_) => Err(self.wrong(&format!("a number from 0 to {MOST_REPEATS} is missing"))),
        }
    }
}
