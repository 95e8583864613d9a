//! The node tree: which nodes are in the scene, in an order of parents before children.

use super::accessor::Document;
use super::at::At;
use super::notes::Notes;
use eyebox_base::error::Result;

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
/// A child that does not exist or has two parents, a cycle.
pub(super) fn read<'a>(document: &Document<'a>, notes: &mut Notes) -> Result<Tree<'a>> {
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
            let mut listed = vec![false; nodes.len()];
            for reference in scene.list("nodes")? {
                let root = reference.index(nodes.len(), "node")?;
                if std::mem::replace(&mut listed[root], true) {
                    notes.warn(&reference, "the scene lists a node twice: it is there once");
                } else {
                    roots.push((root, reference));
                }
            }
            below(roots, &listed, (&mut parents, &mut children), notes)
        }
        None => all_roots,
    };
    Ok(Tree { nodes, parents, children, roots })
}

/// The roots of a scene. Some exporters list nodes that have a parent: what is above them is not in the scene, unless it is listed,
/// too, so that they are there already.
fn below(
    listed: Vec<(usize, At<'_>)>,
    is_listed: &[bool],
    (parents, children): (&mut [Option<usize>], &mut [Vec<usize>]),
    notes: &mut Notes,
) -> Vec<usize> {
    let mut roots = Vec::new();
    // What is cut loose from its parent is no child of what is above that, so the tree is asked as the file has it.
    let above = parents.to_vec();
    // Whether a node is listed or below one that is, for those that somebody has asked about.
    let mut known = vec![None; above.len()];
    for (root, reference) in listed {
        let Some(parent) = above[root] else {
            roots.push(root);
            continue;
        };
        let (mut way, mut node) = (Vec::new(), Some(parent));
        let mut is_there = false;
        while let Some(at) = node {
            if let Some(found) = known[at] {
                is_there = found;
                break;
            }
            way.push(at);
            if is_listed[at] {
                is_there = true;
                break;
            }
            node = above[at];
        }
        way.into_iter().for_each(|at| known[at] = Some(is_there));
        if is_there {
            notes.warn(&reference, "the scene lists a node and one below it: that is there once");
            continue;
        }
        notes.warn(&reference, "the scene lists a node that has a parent: a root, without what is above it");
        parents[root] = None;
        roots.push(root);
    }
    for own in children {
        own.retain(|child| above[*child].is_none() || parents[*child].is_some());
    }
    roots
}
