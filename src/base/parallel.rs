//! Loops over all cores, with one body for whatever they do: generic in what is made, not in how it is made.
//!
//! Rayon's own iterators are compiled anew for each closure, and closures in code that is generic over six spectral modes are six. That was
//! a third of the machine code of the estimators. Here the closure is called through a pointer, which is nothing beside a ray.
//! Results are in the order of the numbers, whatever thread made them.

use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Runs `of` for every number below `count`, in any order: the one loop that Rayon drives.
fn run(count: usize, of: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(of);
}

/// Numbers that a thread takes at once: one where there are few, which are large.
fn at_once(count: usize) -> usize {
    (count / 1024).clamp(1, 256)
}

/// What `of` makes of numbers of each piece in turn, all pieces one after the other.
fn gather<T: Send>(count: usize, of: &(dyn Fn(std::ops::Range<usize>) -> Vec<T> + Sync)) -> Vec<T> {
    let at_once = at_once(count);
    let pieces: Vec<Mutex<Vec<T>>> = (0..count.div_ceil(at_once)).map(|_| Mutex::default()).collect();
    run(pieces.len(), &|piece| {
        let made = of(piece * at_once..count.min((piece + 1) * at_once));
        *pieces[piece].lock().unwrap_or_else(PoisonError::into_inner) = made;
    });
    pieces.into_iter().flat_map(|piece| piece.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// What `of` makes of every number below `count`, in order.
pub fn map<T: Send>(count: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    gather(count, &|numbers| numbers.map(of).collect())
}

/// [`map`] over what is given.
pub fn map_all<I: Sync, T: Send>(items: &[I], of: &(dyn Fn(&I) -> T + Sync)) -> Vec<T> {
    map(items.len(), &|index| of(&items[index]))
}

/// [`map_all`] over what may be changed.
pub fn map_mut<I: Send, T: Send>(items: &mut [I], of: &(dyn Fn(&mut I) -> T + Sync)) -> Vec<T> {
    let items: Vec<Mutex<&mut I>> = items.iter_mut().map(Mutex::new).collect();
    map_all(&items, &|item| of(&mut item.lock().unwrap_or_else(PoisonError::into_inner)))
}

/// [`map`] where what `of` makes is only worth keeping now and then.
pub fn filter_map<T: Send>(count: u64, of: &(dyn Fn(u64) -> Option<T> + Sync)) -> Vec<T> {
    gather(count as usize, &|numbers| numbers.filter_map(|number| of(number as u64)).collect())
}

/// [`map`] where `of` adds any number of things to a list.
pub fn flat_map<T: Send>(count: u64, of: &(dyn Fn(u64, &mut Vec<T>) + Sync)) -> Vec<T> {
    gather(count as usize, &|numbers| {
        let mut out = Vec::new();
        numbers.for_each(|number| of(number as u64, &mut out));
        out
    })
}

/// Whether `is` is true of any number below `count`; the others are left out once one is found.
pub fn any(count: u64, is: &(dyn Fn(u64) -> bool + Sync)) -> bool {
    (0..count).into_par_iter().any(is)
}

/// [`map`] with something at hand that `init` makes, one for many numbers: what `of` makes must not depend on what it held before.
pub fn map_init<S, T: Send>(
    count: usize,
    init: &(dyn Fn() -> S + Sync),
    of: &(dyn Fn(&mut S, usize) -> T + Sync),
) -> Vec<T> {
    gather(count, &|numbers| {
        let mut state = init();
        numbers.map(|number| of(&mut state, number)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_there_in_order() {
        for count in [0usize, 1, 255, 256, 257, 1000, 5000] {
            let wanted: Vec<usize> = (0..count).map(|n| n * n).collect();
            assert_eq!(map(count, &|n| n * n), wanted);
            assert_eq!(map_init(count, &|| 0, &|calls, n| (*calls += 1, n * n).1), wanted);
            let mut numbers: Vec<usize> = (0..count).collect();
            assert_eq!(map_all(&numbers, &|n| n * n), wanted);
            map_mut(&mut numbers, &|n| *n *= *n);
            assert_eq!(numbers, wanted);
            let odd: Vec<u64> = (0..count as u64).filter(|n| n % 2 == 1).collect();
            assert_eq!(filter_map(count as u64, &|n| (n % 2 == 1).then_some(n)), odd);
            assert_eq!(any(count as u64, &|n| n == 256), count > 256);
            let twice: Vec<u64> = (0..count as u64).flat_map(|n| [n, n]).collect();
            assert_eq!(flat_map(count as u64, &|n, out| out.extend([n, n])), twice);
        }
    }
}
