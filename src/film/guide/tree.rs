//! A density on the unit cube that is constant in boxes: a binary tree of cuts across one axis at a time. Sampling walks
//! down the cuts and stretches, at each, the one coordinate that it used, so that evenly spread points stay even.

use eyebox_base::warp::BELOW_ONE;
use serde::{Deserialize, Serialize};

/// Numbers that a path starts with beside the choice of its lamp: two for the place, two for the direction.
pub const AXES: usize = 4;
/// A point of the unit cube: place, then direction.
pub type Point = [f64; AXES];

/// Most cuts between the whole cube and a box.
pub const MOST_DEPTH: usize = 48;
/// The least probability on either side of a cut: nothing is ever out of reach.
const LEAST: f32 = 1.0 / (1 << 24) as f32;

/// A node of the tree: a box that is cut, or (no axis) a box of constant density.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    axis: Option<u8>,
    at: f32,
    /// Probability of the side below `at`, which is the next node.
    below: f32,
    /// Index of the other side.
    above: u32,
}

/// The density. As data: per node in pre-order the axis that it is cut across ([`AXES`]: not at all), and for those that
/// are cut, where and the probability below.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Data", into = "Data")]
pub struct Tree {
    nodes: Vec<Node>,
}

#[derive(Serialize, Deserialize)]
struct Data {
    axes: Vec<u8>,
    cuts: Vec<(f32, f32)>,
}

/// Builds a tree in pre-order.
#[derive(Default)]
pub struct Grower {
    nodes: Vec<Node>,
}

impl Grower {
    pub fn leaf(&mut self) {
        self.nodes.push(Node { axis: None, at: 0.0, below: 0.0, above: 0 });
    }

    /// A cut; its side below is grown next. Returns what [`Grower::above`] wants to know.
    pub fn cut(&mut self, axis: usize, at: f32, below: f64) -> usize {
        let below = (below as f32).clamp(LEAST, 1.0 - LEAST);
        self.nodes.push(Node { axis: Some(axis as u8), at, below, above: 0 });
        self.nodes.len() - 1
    }

    /// The side below `cut` is done; the one above is grown next.
    pub fn above(&mut self, cut: usize) {
        self.nodes[cut].above = self.nodes.len() as u32;
    }

    pub fn tree(self) -> Tree {
        Tree { nodes: self.nodes }
    }
}

impl Tree {
    /// The same density everywhere.
    pub fn uniform() -> Self {
        let mut grower = Grower::default();
        grower.leaf();
        grower.tree()
    }

    /// Whether any cut is across an axis before this one.
    pub fn is_cut_before(&self, axis: usize) -> bool {
        self.nodes.iter().any(|node| node.axis.is_some_and(|own| usize::from(own) < axis))
    }

    /// Boxes of constant density.
    pub fn leaves(&self) -> usize {
        self.nodes.iter().filter(|node| node.axis.is_none()).count()
    }

    /// The point that `u` in the unit cube becomes, and the density there.
    pub fn draw(&self, mut u: Point) -> (Point, f64) {
        let (mut low, mut high, mut density, mut index) = ([0.0; AXES], [1.0; AXES], 1.0, 0);
        loop {
            let node = &self.nodes[index];
            let Some(axis) = node.axis.map(usize::from) else { break };
            let (at, below) = (f64::from(node.at), f64::from(node.below));
            let share = (at - low[axis]) / (high[axis] - low[axis]);
            if u[axis] < below {
                u[axis] /= below;
                high[axis] = at;
                density *= below / share;
                index += 1;
            } else {
                u[axis] = (u[axis] - below) / (1.0 - below);
                low[axis] = at;
                density *= (1.0 - below) / (1.0 - share);
                index = node.above as usize;
            }
        }
        let x = std::array::from_fn(|k| (low[k] + u[k] * (high[k] - low[k])).min(BELOW_ONE));
        (x, density)
    }

    /// The density at a point.
    pub fn density(&self, x: &Point) -> f64 {
        let (mut low, mut high, mut density, mut index) = ([0.0; AXES], [1.0; AXES], 1.0, 0);
        loop {
            let node = &self.nodes[index];
            let Some(axis) = node.axis.map(usize::from) else { return density };
            let (at, below) = (f64::from(node.at), f64::from(node.below));
            let share = (at - low[axis]) / (high[axis] - low[axis]);
            if x[axis] < at {
                high[axis] = at;
                density *= below / share;
                index += 1;
            } else {
                low[axis] = at;
                density *= (1.0 - below) / (1.0 - share);
                index = node.above as usize;
            }
        }
    }

    /// Everything that the density depends on.
    pub fn bytes(&self) -> impl Iterator<Item = u8> {
        self.nodes.iter().flat_map(|node| {
            let head = [node.axis.unwrap_or(AXES as u8)];
            head.into_iter().chain(node.at.to_le_bytes()).chain(node.below.to_le_bytes())
        })
    }
}

impl From<Tree> for Data {
    fn from(tree: Tree) -> Data {
        let axes = tree.nodes.iter().map(|node| node.axis.unwrap_or(AXES as u8)).collect();
        let cut = tree.nodes.iter().filter(|node| node.axis.is_some());
        Data { axes, cuts: cut.map(|node| (node.at, node.below)).collect() }
    }
}

impl TryFrom<Data> for Tree {
    type Error = String;

    /// Errors: nodes that make no tree, cuts outside their box, probabilities that shut a side out.
    fn try_from(data: Data) -> Result<Tree, String> {
        let mut cuts = data.cuts.iter();
        let mut grower = Grower::default();
        // Boxes that wait for their upper side: the cut they belong to, and their bounds.
        let mut waiting: Vec<(usize, Point, Point)> = Vec::new();
        let mut now = Some(([0.0; AXES], [1.0; AXES]));
        for (index, &axis) in data.axes.iter().enumerate() {
            let Some((low, mut high)) = now else { return Err(format!("a guide's tree ends before node {index}")) };
            let axis = usize::from(axis);
            if axis < AXES {
                let Some(&(at, below)) = cuts.next() else { return Err(format!("node {index} of a guide has no cut")) };
                let inside = low[axis] < f64::from(at) && f64::from(at) < high[axis];
                if !(inside && (LEAST..=1.0 - LEAST).contains(&below)) {
                    return Err(format!("node {index} of a guide is cut at {at} with {below} below"));
                }
                if waiting.len() >= MOST_DEPTH {
                    return Err(format!("node {index} of a guide is more than {MOST_DEPTH} cuts deep"));
                }
                let cut = grower.cut(axis, at, f64::from(below));
                let mut above = low;
                above[axis] = f64::from(at);
                waiting.push((cut, above, high));
                high[axis] = f64::from(at);
                now = Some((low, high));
            } else {
                grower.leaf();
                now = waiting.pop().map(|(cut, low, high)| {
                    grower.above(cut);
                    (low, high)
                });
            }
        }
        if now.is_some() || cuts.next().is_some() {
            return Err("a guide's tree is not whole".to_owned());
        }
        Ok(grower.tree())
    }
}
