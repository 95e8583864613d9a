//! Which solids a ray is inside of, and which of them fills the space: nested dielectrics by priority
//! (the rule of Schmidt and Budge, "Simple nested dielectrics in ray traced images", JGT 7(2), 2002).

/// A part that fills space with its medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    pub priority: i32,
}

/// Whether `part` fills the space where `other` is too: by priority, and among equals by the order of the asset.
pub fn outranks(solids: &[Option<Solid>], part: u32, other: u32) -> bool {
    let rank = |part: u32| solids.get(part as usize).and_then(|solid| solid.map(|solid| solid.priority));
    match (rank(part), rank(other)) {
        (Some(own), Some(its)) => own > its || (own == its && part < other),
        (own, _) => own.is_some(),
    }
}

/// The solids around a ray. Deeper nesting than [`Interior::DEPTH`] keeps the newest ones. Every path and every look behind
/// a face has a copy, so it is plain numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Interior {
    /// Zero beyond `count`.
    parts: [u32; Interior::DEPTH],
    count: u8,
}

impl Interior {
    pub const DEPTH: usize = 8;

    pub fn of(parts: impl IntoIterator<Item = u32>) -> Self {
        let mut interior = Interior::default();
        for (place, part) in interior.parts.iter_mut().zip(parts) {
            *place = part;
            interior.count += 1;
        }
        interior
    }

    fn parts(&self) -> &[u32] {
        self.parts.get(..usize::from(self.count)).unwrap_or(&self.parts)
    }

    /// The solid that fills the space here: the highest priority, and among equals the one listed first in the asset.
    pub fn top<'s>(&self, solids: &'s [Option<Solid>]) -> Option<(u32, &'s Solid)> {
        self.top_without(u32::MAX, solids)
    }

    /// [`Interior::top`] if `part` were not there.
    pub fn top_without<'s>(&self, part: u32, solids: &'s [Option<Solid>]) -> Option<(u32, &'s Solid)> {
        self.parts()
            .iter()
            .filter(|&&p| p != part)
            .filter_map(|&p| solids[p as usize].as_ref().map(|solid| (p, solid)))
            .max_by(|a, b| a.1.priority.cmp(&b.1.priority).then(b.0.cmp(&a.0)))
    }

    /// Whether `part` is around the ray.
    pub fn contains(&self, part: u32) -> bool {
        self.parts().contains(&part)
    }

    pub fn enter(&mut self, part: u32) {
        if self.contains(part) {
            return;
        }
        if usize::from(self.count) == Self::DEPTH {
            self.leave(self.parts[0]);
        }
        self.parts[usize::from(self.count)] = part;
        self.count += 1;
    }

    pub fn leave(&mut self, part: u32) {
        if let Some(at) = self.parts().iter().position(|p| *p == part) {
            self.parts.copy_within(at + 1.., at);
            self.parts[Self::DEPTH - 1] = 0;
            self.count -= 1;
        }
    }

    /// Makes the list agree with what a hit on `part` proves: a hit from behind means that the ray was inside.
    pub fn heal(&mut self, part: u32, was_inside: bool) {
        if was_inside { self.enter(part) } else { self.leave(part) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(priority: i32) -> Option<Solid> {
        Some(Solid { priority })
    }

    #[test]
    fn the_highest_priority_fills_the_overlap() {
        let solids = [solid(0), solid(1), solid(1), None];
        let mut inside = Interior::default();
        assert_eq!(inside.top(&solids), None);
        inside.enter(0);
        inside.enter(2);
        assert_eq!(inside.top(&solids).map(|(p, _)| p), Some(2));
        inside.enter(1);
        assert_eq!(inside.top(&solids).map(|(p, _)| p), Some(1), "equal priorities: first in the asset");
        assert_eq!(inside.top_without(1, &solids).map(|(p, _)| p), Some(2));
        inside.leave(1);
        inside.leave(2);
        assert_eq!(inside.top(&solids).map(|(p, _)| p), Some(0));
    }

    #[test]
    fn overfull_nesting_forgets_the_oldest() {
        let mut inside = Interior::default();
        (0..20).for_each(|p| inside.enter(p));
        assert!(inside.contains(19) && !inside.contains(0));
    }
}
