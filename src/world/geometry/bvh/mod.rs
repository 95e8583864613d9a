//! The f32 hierarchy over boxes: a binary tree (by `obvhs`, or by our own splits where there are many), nodes of eight that are
//! made of it, and the walk through those.

pub mod build; // the binary tree
pub mod collapse; // which of its subtrees a node takes up
pub mod huge_pages;
pub mod node; // eight boxes, and which of them a ray enters
pub mod pack; // the triangles of a leaf
pub mod split; // the binary tree of many boxes
mod stack;
pub mod top; // over parts
pub mod tree; // in unit coordinates, padded
pub mod wide; // the walk
