//! The node tree: which nodes are in the scene, in an order of parents before children.

use super::accessor::Document;
use super::at::At;
use crate::base::error::Result;

#[derive(Debug)]
pub(super) struct Tree<'a> {
    pub nodes: Vec<At<'a>>,
    pub parents: Vec<Option<usize>>,
    pub children: Vec<Vec<usize>>,
    /// The roots of the default scene, or all roots.
    pub roots: Vec<usize>,
}

/// Reads the tree and proves that it is one.
///
/// # Errors
/// A child that does not exist or has two parents, a cycle, a scene that lists a node twice or one that is no root.
pub(super) fn read<'a>(document: &Document<'a>) -> Result<Tree<'a>> {
    let nodes = document.root.list("nodes")?;
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    let mut children = Vec::with_capacity(nodes.len());
    for (index, node) in nodes.iter().enumerate() {
        let mut own = Vec::new();
        for reference in node.list("children")? {
            let child = reference.index(nodes.len(), "node")?;
            if let Some(other) = parents[child].replace(index) {
                let what = format!("node {child} is a child of node {other} already");
                return Err(reference.fault(what).expected("one parent for each node"));
            }
            own.push(child);
        }
        children.push(own);
    }
    // With one parent at most for each node, whatever cannot be reached from the parentless ones is on a cycle or below it.
    let all_roots: Vec<usize> = (0..nodes.len()).filter(|&node| parents[node].is_none()).collect();
    let mut reached = vec![false; nodes.len()];
    let mut stack = all_roots.clone();
    while let Some(node) = stack.pop() {
        reached[node] = true;
        stack.extend(&children[node]);
    }
    if let Some(lost) = reached.iter().position(|&reached| !reached) {
        // Walking up from it must end on the cycle.
        let (mut node, mut seen) = (lost, vec![false; nodes.len()]);
        while !std::mem::replace(&mut seen[node], true) {
            node = parents[node].unwrap_or(node);
        }
        return Err(nodes[node].fault(format!("node {node} is its own ancestor")).expected("a tree of nodes"));
    }
    let roots = match document.root.get("scene")? {
        Some(reference) => {
            let scene = document.find("scenes", "scene", &reference)?;
            let mut roots = Vec::new();
            for reference in scene.list("nodes")? {
                let root = reference.index(nodes.len(), "node")?;
                if let Some(parent) = parents[root] {
                    let what = format!("node {root} is no root: it is a child of node {parent}");
                    return Err(reference.fault(what).expected("root nodes in a scene"));
                }
                if !std::mem::replace(&mut reached[root], false) {
                    return Err(reference.fault(format!("the scene lists node {root} twice")));
                }
                roots.push(root);
            }
            roots
        }
        None => all_roots,
    };
    Ok(Tree { nodes, parents, children, roots })
}
