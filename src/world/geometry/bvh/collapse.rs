//! From halves of halves to a tree of eight children to a node: which subtrees a node takes up as its children, and which
//! end as leaves, so that the area of all nodes and leaves, weighted by what looking at one costs, is least (dynamic
//! programming over the binary tree: H. Ylitie, T. Karras and S. Laine, "Efficient incoherent ray traversal on GPUs through
//! compressed wide BVHs", HPG 2017).

use super::build;
use super::split::{Extent, Item, halve, split};
use arrayvec::ArrayVec;
use glam::Vec3;
use obvhs::bvh2::Bvh2;
use std::ops::Range;

/// Children of a node.
const WIDTH: usize = 8;
/// Levels of halves that are parted by area. Sets that nest at every scale would make chains; below these levels each
/// halves the number of items, of which there are at most 2³².
const BY_AREA: usize = 40;
/// Levels of a tree: each of them leaves at most seven entries on the stack.
pub const DEEPEST: usize = BY_AREA + 32;
/// What looking at a leaf costs where looking at a node costs 1: from 0.7 to 1.5 rays are as fast within 1 %.
const OF_LEAF: f32 = 1.0;

/// A set of items that lie in a row, and its halves.
struct Half {
    lo: Vec3,
    hi: Vec3,
    first: u32,
    count: u32,
    /// The first of its two halves, which lie beside each other; 0, which is nobody's half, for a single item.
    halves: u32,
    /// The least cost of standing as at most 1, 2 … 7 children of a node.
    costs: [f32; WIDTH - 1],
    /// As one child: it is a leaf.
    is_leaf: bool,
}

impl Half {
    fn new(items: &[Item], first: usize) -> Half {
        let Extent { lo, hi } = Extent::of(items);
        let (first, count) = (first as u32, items.len() as u32);
        let costs = [f32::INFINITY; WIDTH - 1];
        Half { lo: lo.into(), hi: hi.into(), first, count, halves: 0, costs, is_leaf: false }
    }

    fn items(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    fn extent(&self) -> Extent {
        Extent { lo: self.lo.into(), hi: self.hi.into() }
    }

    fn halves(&self) -> Option<usize> {
        (self.halves > 0).then_some(self.halves as usize)
    }
}

/// A binary tree down to single items, which knows how it is best stood up in nodes of eight.
pub struct Halves(Vec<Half>);

impl Halves {
    /// Sorts items, fewer than 2³¹, of which a leaf holds at most so many.
    pub fn new(items: &mut [Item], most: usize) -> Halves {
        let mut all = Vec::with_capacity(2 * items.len());
        all.push(Half::new(items, 0));
        let mut open = vec![(0usize, 0usize)];
        while let Some((index, level)) = open.pop() {
            let range = all[index].items();
            if range.len() < 2 {
                continue;
            }
            let own = &mut items[range.clone()];
            let middle = range.start + if level < BY_AREA { split(own, most) } else { halve(own) };
            let first = all.len();
            all[index].halves = first as u32;
            for (child, range) in [range.start..middle, middle..range.end].into_iter().enumerate() {
                all.push(Half::new(&items[range.clone()], range.start));
                open.push((first + child, level + 1));
            }
        }
        let mut all = Halves(all);
        all.weigh(most);
        all
    }

    /// Of the two trees the one that rays go through faster, of those that a walk can keep count of.
    pub fn best(items: &mut [Item], most: usize) -> Halves {
        let joined = (items.len() <= build::MOST).then(|| Halves::of_tree(&build::binary(items), items, most));
        joined.filter(Halves::fits_the_stack).unwrap_or_else(|| Halves::new(items, most))
    }

    /// Of a binary tree over the items, which are sorted as its leaves follow each other.
    pub fn of_tree(tree: &Bvh2, items: &mut [Item], most: usize) -> Halves {
        let half = |node: u32| {
            let aabb = tree.nodes[node as usize].aabb;
            let costs = [f32::INFINITY; WIDTH - 1];
            Half { lo: aabb.min.into(), hi: aabb.max.into(), first: 0, count: 0, halves: 0, costs, is_leaf: false }
        };
        let mut all = Vec::with_capacity(2 * items.len());
        let mut sorted = Vec::with_capacity(items.len());
        all.push(half(0));
        let mut open = vec![(0u32, 0usize)];
        while let Some((node, index)) = open.pop() {
            let node = &tree.nodes[node as usize];
            if node.is_leaf() {
                let own = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                (all[index].first, all[index].count) = (sorted.len() as u32, node.prim_count);
                sorted.extend(tree.primitive_indices[own].iter().map(|item| items[*item as usize]));
            } else {
                let first = all.len();
                all[index].halves = first as u32;
                all.extend([half(node.first_index), half(node.first_index + 1)]);
                open.extend([(node.first_index + 1, first + 1), (node.first_index, first)]);
            }
        }
        items.copy_from_slice(&sorted);
        for index in (0..all.len()).rev() {
            if let Some(first) = all[index].halves() {
                (all[index].first, all[index].count) = (all[first].first, all[first].count + all[first + 1].count);
            }
        }
        let mut all = Halves(all);
        all.weigh(most);
        all
    }

    /// Whether no node is deeper than a walk can keep count of: sets that nest at every scale are joined in chains.
    pub fn fits_the_stack(&self) -> bool {
        let mut open = vec![(0usize, 0usize)];
        while let Some((index, level)) = open.pop() {
            if level >= DEEPEST {
                return false;
            }
            let inner = self.children(index).into_iter().filter(|child| self.leaf(*child).is_none());
            open.extend(inner.map(|child| (child, level + 1)));
        }
        true
    }

    /// From single items up: halves come behind what they are halves of.
    fn weigh(&mut self, most: usize) {
        for index in (0..self.0.len()).rev() {
            let half = &self.0[index];
            let area = half.extent().area();
            let fits = half.count as usize <= most;
            let as_leaf = if fits { OF_LEAF * area } else { f32::INFINITY };
            let mut costs = [as_leaf; WIDTH - 1];
            let mut is_leaf = fits;
            if let Some(first) = half.halves() {
                let [a, b] = [self.0[first].costs, self.0[first + 1].costs];
                let shared =
                    |among: usize| (1..among).map(|i| a[i - 1] + b[among - i - 1]).fold(f32::INFINITY, f32::min);
                let as_node = area + shared(WIDTH);
                is_leaf = fits && as_leaf <= as_node;
                costs[0] = as_leaf.min(as_node);
                for among in 2..WIDTH {
                    costs[among - 1] = costs[among - 2].min(shared(among));
                }
            }
            (self.0[index].costs, self.0[index].is_leaf) = (costs, is_leaf);
        }
    }

    /// The children of a node that stands for a set of more than a leaf holds.
    pub fn children(&self, index: usize) -> ArrayVec<usize, WIDTH> {
        let mut children = ArrayVec::new();
        // Sets, among how many children each is shared out, the first at the top.
        let mut open: ArrayVec<(usize, usize), WIDTH> = ArrayVec::new();
        open.push((index, WIDTH));
        while let Some((index, among)) = open.pop() {
            let half = &self.0[index];
            let cost = |index: usize, among: usize| self.0[index].costs[among - 1];
            // As few as do.
            let fewest = || (1..among).find(|fewer| cost(index, *fewer) <= cost(index, among)).unwrap_or(among);
            let among = if among < WIDTH { fewest() } else { among };
            match half.halves() {
                Some(first) if among > 1 => {
                    let shared = |i: usize| cost(first, i) + cost(first + 1, among - i);
                    let best = (1..among).fold(1, |best, i| if shared(i) < shared(best) { i } else { best });
                    open.push((first + 1, among - best));
                    open.push((first, best));
                }
                Some(_) | None => children.push(index),
            }
        }
        children
    }

    pub fn extent(&self, index: usize) -> Extent {
        self.0[index].extent()
    }

    /// The items of a set that ends as a leaf.
    pub fn leaf(&self, index: usize) -> Option<Range<usize>> {
        self.0[index].is_leaf.then(|| self.0[index].items())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use glam::Vec3A;
    use std::collections::HashMap;

    fn boxes(seed: u64, count: u32) -> Vec<Item> {
        let mut rng = Rng::new(seed, Stream::Check, 0, 0);
        let mut place = |size: f64| Vec3A::from_array([(); 3].map(|()| (size * rng.uniform()) as f32));
        let item = |index| {
            let lo = place(1.0);
            Item { lo, hi: lo + place(0.3), index }
        };
        (0..count).map(item).collect()
    }

    /// The least cost of a set as one child, every way to stand it up tried; `known`: of sets that have been.
    fn least(halves: &Halves, index: usize, most: usize, known: &mut HashMap<usize, f64>) -> f64 {
        if let Some(cost) = known.get(&index) {
            return *cost;
        }
        let half = &halves.0[index];
        let area = f64::from(half.extent().area());
        let as_leaf = if half.items().len() <= most { f64::from(OF_LEAF) * area } else { f64::INFINITY };
        let ways = ways(halves, index);
        let as_node = ways
            .iter()
            .filter(|way| way.len() > 1 && way.len() <= WIDTH)
            .map(|way| area + way.iter().map(|child| least(halves, *child, most, known)).sum::<f64>());
        let cost = as_node.fold(as_leaf, f64::min);
        known.insert(index, cost);
        cost
    }

    /// All ways to share out a set among subtrees of it.
    fn ways(halves: &Halves, index: usize) -> Vec<Vec<usize>> {
        let mut all = vec![vec![index]];
        if let Some(first) = halves.0[index].halves() {
            for a in ways(halves, first) {
                all.extend(ways(halves, first + 1).into_iter().map(|b| [a.clone(), b].concat()));
            }
        }
        all
    }

    /// What a tree costs as it stands.
    fn stands(halves: &Halves, (index, level): (usize, usize), seen: &mut Vec<usize>, most: usize) -> f64 {
        let area = f64::from(halves.extent(index).area());
        match halves.leaf(index) {
            Some(items) => {
                assert!(!items.is_empty() && items.len() <= most);
                seen.extend(items);
                f64::from(OF_LEAF) * area
            }
            None => {
                assert!(level < DEEPEST, "{level}");
                let children = halves.children(index);
                assert!(children.len() > 1, "{index}: {children:?}");
                let below = children.into_iter().map(|child| stands(halves, (child, level + 1), seen, most));
                area + below.sum::<f64>()
            }
        }
    }

    fn joined(items: &mut [Item], most: usize) -> Halves {
        Halves::of_tree(&build::binary(items), items, most)
    }

    /// By splits, and of a tree that is given.
    const KINDS: [fn(&mut [Item], usize) -> Halves; 2] = [Halves::new, joined];

    /// Of leaves of two, and of single items in clusters, where nodes below the first are full, too.
    #[test]
    fn no_tree_costs_less() {
        for kind in KINDS {
            least_of(kind);
        }
    }

    fn least_of(kind: fn(&mut [Item], usize) -> Halves) {
        for seed in 0..6 {
            for (count, most) in [(11, 2), (18, 1)] {
                let mut items = boxes(seed, count);
                for item in items.iter_mut().filter(|item| most == 1 && item.index < 12) {
                    (item.lo, item.hi) = (5.0 + 0.1 * item.lo, 5.0 + 0.1 * item.hi);
                }
                let halves = kind(&mut items, most);
                let least = least(&halves, 0, most, &mut HashMap::new());
                let cost = stands(&halves, (0, 0), &mut Vec::new(), most);
                assert!((cost / least - 1.0).abs() < 1e-5, "{cost} for {least}");
            }
        }
    }

    /// Boxes that nothing tells apart are joined one after the other: a walk gets splits instead.
    #[test]
    fn joining_the_same_makes_chains() {
        let alike = boxes(9, 1)[0];
        let mut items: Vec<Item> = (0..1000).map(|index| Item { index, ..alike }).collect();
        assert!(!joined(&mut items.clone(), 4).fits_the_stack());
        assert!(Halves::best(&mut items, 4).fits_the_stack());
    }

    /// Boxes that nest at every scale make no chain, and what has no box is in a leaf like all else.
    #[test]
    fn no_tree_is_too_deep() {
        let mut items: Vec<Item> = (0..3000)
            .map(|index| {
                let half = Vec3A::splat(1.02f32.powi(-(index as i32)).max(1e-20));
                Item { lo: -half, hi: half * if index % 2 == 0 { 1.0 } else { 1.5 }, index }
            })
            .collect();
        (items[7].lo, items[7].hi) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        let halves = Halves::new(&mut items, 4);
        let mut seen = Vec::new();
        stands(&halves, (0, 0), &mut seen, 4);
        assert_eq!(seen.len(), items.len());
        assert!(halves.fits_the_stack());
    }

    /// Nodes of a chain, each of a single item and the rest, are deeper than a walk can follow.
    #[test]
    fn chains_are_told() {
        let boxes = boxes(3, 1000);
        let chain = |count: usize| {
            let mut all = vec![Half::new(&boxes[..count], 0)];
            for first in 1..count {
                // The rest, whose halves follow it, then the item that it is parted from.
                let place = all.len();
                all[if first == 1 { 0 } else { place - 2 }].halves = place as u32;
                all.extend([Half::new(&boxes[first..count], first), Half::new(&boxes[first - 1..first], first - 1)]);
            }
            let mut all = Halves(all);
            all.weigh(1);
            all.fits_the_stack()
        };
        assert!(chain(20) && !chain(1000));
    }

    #[test]
    fn every_item_is_in_one_leaf() {
        for (count, most) in [(2, 1), (5, 4), (300, 1), (3000, 4)] {
            let mut items = boxes(9, count);
            // Some that nothing tells apart.
            let alike = items[0];
            items.iter_mut().step_by(3).for_each(|item| *item = Item { index: item.index, ..alike });
            for kind in [Halves::new, Halves::best] {
                let mut items = items.clone();
                let halves = kind(&mut items, most);
                let mut seen = Vec::new();
                stands(&halves, (0, 0), &mut seen, most);
                seen.sort_unstable();
                assert_eq!(seen, (0..count as usize).collect::<Vec<_>>());
                let mut whose: Vec<u32> = items.iter().map(|item| item.index).collect();
                whose.sort_unstable();
                assert_eq!(whose, (0..count).collect::<Vec<_>>());
            }
        }
    }
}
