//! What a network of shaders comes to, as far as a surface knows it: a constant, or a picture whose texels are scaled and
//! moved; either perhaps times what the vertices of the mesh have. Arithmetic on these stays among them, or is none.

use super::reads::{Coordinates, OfVertices};
use eyebox_scene::TextureInput;
use eyebox_scene::texture::Channel;

/// Red, green, blue, alpha; a number has it in all four.
pub(super) type Lanes = [f64; 4];

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Folded {
    pub what: Reading,
    /// What it is multiplied by.
    pub vertices: Option<OfVertices>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Reading {
    Constant(Lanes),
    /// Its set of texture coordinates has no number yet.
    Picture(Box<TextureInput>, Coordinates),
}

/// a · b or a + b, by lane.
fn each(a: Lanes, b: Lanes, op: impl Fn(f64, f64) -> f64) -> Lanes {
    std::array::from_fn(|lane| op(a[lane], b[lane]))
}

impl Folded {
    pub fn constant(lanes: Lanes) -> Self {
        Folded { what: Reading::Constant(lanes), vertices: None }
    }
    pub fn number(x: f64) -> Self {
        Folded::constant([x; 4])
    }
    pub fn of_vertices(vertices: OfVertices) -> Self {
        Folded { vertices: Some(vertices), ..Folded::number(1.0) }
    }
    pub fn picture(input: TextureInput, coordinates: Coordinates) -> Self {
        Folded { what: Reading::Picture(Box::new(input), coordinates), vertices: None }
    }

    /// Its lanes, if they are the same everywhere.
    pub fn lanes(&self) -> Option<Lanes> {
        match (&self.what, &self.vertices) {
            (Reading::Constant(lanes), None) => Some(*lanes),
            (Reading::Constant(_), Some(_)) | (Reading::Picture(..), _) => None,
        }
    }

    pub fn scaled(mut self, by: Lanes) -> Self {
        match &mut self.what {
            Reading::Constant(lanes) => *lanes = each(*lanes, by, |a, b| a * b),
            Reading::Picture(input, _) => {
                input.scale = each(input.scale, by, |a, b| a * b);
                input.bias = each(input.bias, by, |a, b| a * b);
            }
        }
        self
    }

    /// None of what vertices multiply: the sum would be theirs, too.
    pub fn moved(mut self, by: Lanes) -> Option<Self> {
        match &mut self.what {
            _ if by == [0.0; 4] => {}
            _ if self.vertices.is_some() => return None,
            Reading::Constant(lanes) => *lanes = each(*lanes, by, |a, b| a + b),
            Reading::Picture(input, _) => input.bias = each(input.bias, by, |a, b| a + b),
        }
        Some(self)
    }

    pub fn times(self, other: Self) -> Option<Self> {
        let vertices = match (self.vertices, other.vertices) {
            (None, found) | (found, None) => found,
            (Some(_), Some(_)) => return None,
        };
        let plain = |what: Reading| Folded { what, vertices: None };
        let what = match (self.what, other.what) {
            (Reading::Constant(by), what) | (what, Reading::Constant(by)) => plain(what).scaled(by).what,
            (Reading::Picture(..), Reading::Picture(..)) => return None,
        };
        Some(Folded { what, vertices })
    }

    pub fn plus(self, other: Self) -> Option<Self> {
        match (self.lanes(), other.lanes()) {
            (_, Some(by)) => self.moved(by),
            (Some(by), None) => other.moved(by),
            (None, None) => None,
        }
    }

    /// `share` of `self`, the rest of `other`.
    pub fn over(self, other: Self, share: Self) -> Option<Self> {
        match (share.lanes(), self.lanes(), other.lanes()) {
            // What has no share must not stop the other.
            (Some(share), ..) if share == [0.0; 4] => Some(other),
            (Some(share), ..) if share == [1.0; 4] => Some(self),
            (Some(share), ..) => self.scaled(share).plus(other.scaled(share.map(|x| 1.0 - x))),
            (None, Some(top), Some(below)) => share.scaled(each(top, below, |a, b| a - b)).moved(below),
            (None, ..) => None,
        }
    }

    /// With the lanes of these numbers; 4 and 5 are the constants 0 and 1.
    pub fn picked(mut self, from: [usize; 4]) -> Option<Self> {
        const CONSTANTS: usize = 4;
        let moves = self.vertices.as_ref().is_some_and(OfVertices::is_colour) && from[..3] != [0, 1, 2];
        if moves {
            return None;
        }
        let constant = |place: usize| (place >= CONSTANTS).then(|| (place - CONSTANTS) as f64);
        match &mut self.what {
            Reading::Constant(lanes) => {
                *lanes = from.map(|place| constant(place).unwrap_or_else(|| lanes[place]));
            }
            Reading::Picture(input, _) => {
                let old = input.clone();
                for (lane, place) in from.into_iter().enumerate() {
                    match constant(place) {
                        Some(x) => (input.scale[lane], input.bias[lane]) = (0.0, x),
                        None => {
                            input.channels[lane] = old.channels[place];
                            (input.scale[lane], input.bias[lane]) = (old.scale[place], old.bias[place]);
                        }
                    }
                }
            }
        }
        Some(self)
    }

    /// The first lane of each: numbers of one picture and constants, put together.
    pub fn joined(parts: &[Folded]) -> Option<Self> {
        if parts.iter().any(|part| part.vertices.is_some()) {
            return None;
        }
        let base = parts.iter().find(|part| matches!(part.what, Reading::Picture(..)));
        let mut out = base.cloned().unwrap_or(Folded::constant([0.0, 0.0, 0.0, 1.0]));
        for (lane, part) in parts.iter().enumerate().take(4) {
            match (&mut out.what, &part.what) {
                (Reading::Constant(lanes), Reading::Constant(own)) => lanes[lane] = own[0],
                (Reading::Picture(input, _), Reading::Constant(own)) => {
                    (input.scale[lane], input.bias[lane]) = (0.0, own[0]);
                }
                (Reading::Picture(input, coordinates), Reading::Picture(own, placed)) => {
                    let plain = |input: &TextureInput| TextureInput {
                        channels: Channel::ALL,
                        scale: [1.0; 4],
                        bias: [0.0; 4],
                        ..input.clone()
                    };
                    if plain(input) != plain(own) || coordinates != placed {
                        return None;
                    }
                    input.channels[lane] = own.channels[0];
                    (input.scale[lane], input.bias[lane]) = (own.scale[0], own.bias[0]);
                }
                (Reading::Constant(_), Reading::Picture(..)) => return None,
            }
        }
        Some(out)
    }
}
