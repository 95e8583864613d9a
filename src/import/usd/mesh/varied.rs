//! What vertices carry, made ready for a subdivision surface and taken back from it.

use super::super::primvar::{Interpolation, Primvar};
use super::carried::{Carried, Held};
use std::rc::Rc;

/// The primvars of the faces of a mesh, each once. Constant ones stay as they are on any surface.
#[derive(Debug, Default)]
pub(super) struct Varied {
    pairs: Vec<Rc<Primvar<[f32; 2]>>>,
    colors: Vec<Rc<Primvar<[f32; 3]>>>,
    numbers: Vec<Rc<Primvar<f32>>>,
}

impl Varied {
    pub fn of(faces: &[Carried]) -> Self {
        let mut out = Varied::default();
        for face in faces {
            add(&mut out.pairs, &face.uvs);
            add(&mut out.pairs, &face.second_uvs);
            add(&mut out.colors, &face.color);
            add(&mut out.numbers, &face.opacity);
        }
        out
    }

    /// All of them as three numbers.
    pub fn channels(&self) -> Vec<Primvar<[f32; 3]>> {
        let pairs = self.pairs.iter().map(|pairs| pairs.map(|[u, v]| [u, v, 0.0]));
        let colors = self.colors.iter().map(|colors| colors.as_ref().clone());
        let numbers = self.numbers.iter().map(|numbers| numbers.map(|x| [x, 0.0, 0.0]));
        pairs.chain(colors).chain(numbers).collect()
    }

    /// Gives the faces what became of the [`channels`](Self::channels).
    pub fn replace(self, faces: &mut [Carried], fine: Vec<Primvar<[f32; 3]>>) {
        let mut fine = fine.into_iter();
        let pairs: Vec<_> = fine.by_ref().take(self.pairs.len()).map(|pairs| pairs.map(|[u, v, _]| [u, v])).collect();
        let colors: Vec<_> = fine.by_ref().take(self.colors.len()).collect();
        let numbers: Vec<_> = fine.map(|numbers| numbers.map(|[x, _, _]| x)).collect();
        let (pairs, colors, numbers) = (shared(pairs), shared(colors), shared(numbers));
        for face in faces {
            swap(&mut face.uvs, &self.pairs, &pairs);
            swap(&mut face.second_uvs, &self.pairs, &pairs);
            swap(&mut face.color, &self.colors, &colors);
            swap(&mut face.opacity, &self.numbers, &numbers);
        }
    }
}

fn shared<T>(all: Vec<Primvar<T>>) -> Vec<Rc<Primvar<T>>> {
    all.into_iter().map(Rc::new).collect()
}

fn place<T>(all: &[Rc<Primvar<T>>], one: &Rc<Primvar<T>>) -> Option<usize> {
    all.iter().position(|other| Rc::ptr_eq(other, one))
}

fn add<T>(all: &mut Vec<Rc<Primvar<T>>>, held: &Held<T>) {
    if let Some(held) = held
        && held.interpolation() != Interpolation::Constant
        && place(all, held).is_none()
    {
        all.push(Rc::clone(held));
    }
}

fn swap<T>(held: &mut Held<T>, cage: &[Rc<Primvar<T>>], fine: &[Rc<Primvar<T>>]) {
    let found = held.as_ref().and_then(|held| fine.get(place(cage, held)?));
    if let Some(found) = found.cloned() {
        *held = Some(found);
    }
}
