//! The tree as text. Paths make the branches; what is alike is folded. No recursion: a hostile path can be deep.

use super::words;
use super::{AssemblyTree, PartReport};
use eyebox_base::Where;
use eyebox_scene::{Note, Severity, Wavelengths};
use std::collections::HashMap;
use std::fmt::Write;

pub fn text(tree: &AssemblyTree) -> String {
    let mut out = head(tree);
    out.push('\n');
    branches(tree, &mut out);
    lamps_and_eye(tree, &mut out);
    notes(tree, &mut out);
    out
}

fn head(tree: &AssemblyTree) -> String {
    let shared = tree.parts.iter().filter(|part| part.instances > 1).count();
    let triangles: usize = tree.parts.iter().map(|part| part.triangles).fold(0, usize::saturating_add);
    let mut out = format!(
        "{}: {} parts, {} meshes, {triangles} triangles, unit {} m, ",
        words::name(&tree.name),
        tree.parts.len(),
        tree.meshes,
        tree.unit_m
    );
    if shared > 0 {
        let _ = write!(out, "{shared} parts share meshes, ");
    }
    out += &match tree.wavelengths {
        Wavelengths::Mono { nm } => format!("{nm} nm\n"),
        Wavelengths::Visible => format!("visible range; indices are those at {} nm\n", tree.traced_nm),
    };
    if let Some(bounds) = tree.bounds {
        let (extent, size) = (bounds.size_m().max_element(), words::size(bounds.size_m()));
        let (low, high) = (words::place(bounds.min_m, extent), words::place(bounds.max_m, extent));
        let _ = writeln!(out, "bounds {size}, from {low} to {high} mm");
    }
    if let Some(fault) = &tree.fault {
        let _ = writeln!(out, "its optics can't be used: {fault}");
    }
    out
}

/// A segment of the paths. `parts`: those that end here.
#[derive(Default)]
struct Node<'a> {
    name: &'a str,
    parts: Vec<usize>,
    children: Vec<usize>,
}

/// A line of the tree: a branch, or parts that are alike.
struct Item {
    node: usize,
    /// The first of them is described; none for a mere branch.
    alike: Vec<usize>,
    root: bool,
    last: bool,
    /// What stands before the lines of this level.
    indent: String,
}

fn branches(tree: &AssemblyTree, out: &mut String) {
    let nodes = nodes(&tree.parts);
    let extent = tree.bounds.map_or(0.0, |bounds| bounds.size_m().max_element());
    let bodies: Vec<(String, Vec<(String, String)>)> =
        tree.parts.iter().map(|part| body(part, tree.traced_nm)).collect();
    let mut stack = Vec::new();
    push_children(tree, &nodes, &bodies, 0, "", &mut stack);
    while let Some(item) = stack.pop() {
        let node = nodes.get(item.node);
        let (fork, below) = match (item.root, item.last) {
            (true, _) => ("", ""),
            (false, true) => ("└─ ", "   "),
            (false, false) => ("├─ ", "│  "),
        };
        let indent = format!("{}{below}", item.indent);
        let open = item.alike.len() == 1 && node.is_some_and(|node| !node.children.is_empty());
        let first = item.alike.first().and_then(|index| Some((tree.parts.get(*index)?, bodies.get(*index)?)));
        match first {
            None => {
                let _ = writeln!(out, "{}{fork}{}", item.indent, words::name(node.map_or("", |node| node.name)));
            }
            Some((part, (what, faces))) => {
                let name = alike_names(tree, &item.alike);
                let at = match (item.alike.as_slice(), part.bounds) {
                    ([_], Some(bounds)) => format!(", at {}", words::place(bounds.centre_m(), extent)),
                    (_, _) => String::new(),
                };
                let _ = writeln!(out, "{}{fork}{name}: {what}{at}", item.indent);
                let bar = if open { "│    " } else { "     " };
                for (face, fit) in faces {
                    let _ = writeln!(out, "{indent}{bar}{face}{fit}");
                }
            }
        }
        if item.alike.len() <= 1 {
            push_children(tree, &nodes, &bodies, item.node, &indent, &mut stack);
        }
    }
}

fn nodes(parts: &[PartReport]) -> Vec<Node<'_>> {
    let mut nodes = vec![Node::default()];
    let mut known: HashMap<(usize, &str), usize> = HashMap::new();
    for (index, part) in parts.iter().enumerate() {
        let mut at = 0;
        for segment in part.path.split('/') {
            at = *known.entry((at, segment)).or_insert_with(|| {
                nodes.push(Node { name: segment, ..Node::default() });
                let new = nodes.len() - 1;
                if let Some(parent) = nodes.get_mut(at) {
                    parent.children.push(new);
                }
                new
            });
        }
        if let Some(node) = nodes.get_mut(at) {
            node.parts.push(index);
        }
    }
    nodes
}

/// Puts the lines below `node` onto the stack, the first on top. Leaves that say the same and whose names differ only
/// in their last number become one.
fn push_children(
    tree: &AssemblyTree,
    nodes: &[Node<'_>],
    bodies: &[(String, Vec<(String, String)>)],
    node: usize,
    indent: &str,
    stack: &mut Vec<Item>,
) {
    let mut items: Vec<Item> = Vec::new();
    let mut alike: HashMap<(&str, &str, String, Vec<&str>), usize> = HashMap::new();
    for &child in nodes.get(node).map_or(&[][..], |node| &node.children) {
        let Some(below) = nodes.get(child) else { continue };
        let item = |alike| Item { node: child, alike, root: node == 0, last: false, indent: indent.to_owned() };
        if below.parts.is_empty() {
            items.push(item(Vec::new()));
            continue;
        }
        for (nth, &part) in below.parts.iter().enumerate() {
            let (Some(report), Some((what, faces))) = (tree.parts.get(part), bodies.get(part)) else { continue };
            if !below.children.is_empty() {
                // Its children hang below the first of parts with the same path.
                items.push(item(vec![part]));
                if nth > 0
                    && let Some(item) = items.last_mut()
                {
                    item.node = usize::MAX;
                }
                continue;
            }
            let stem = report.name.trim_end_matches(|c: char| c.is_ascii_digit());
            let area = words::number(report.area_m2, 4);
            let key = (stem, what.as_str(), area, faces.iter().map(|(face, _)| face.as_str()).collect());
            let slot = *alike.entry(key).or_insert(items.len());
            match items.get_mut(slot) {
                Some(item) => item.alike.push(part),
                None => items.push(item(vec![part])),
            }
        }
    }
    if let Some(last) = items.last_mut() {
        last.last = true;
    }
    stack.extend(items.into_iter().rev());
}

/// `LED_1`; `LED_1, LED_2 (2 alike)`; `LED_1 … LED_9 (9 alike)`.
fn alike_names(tree: &AssemblyTree, alike: &[usize]) -> String {
    let name = |index: Option<&usize>| {
        index.and_then(|index| tree.parts.get(*index)).map_or_else(String::new, |part| words::name(&part.name))
    };
    match alike {
        [first, second] => format!("{}, {} (2 alike)", name(Some(first)), name(Some(second))),
        [_, .., _] => format!("{} … {} ({} alike)", name(alike.first()), name(alike.last()), alike.len()),
        [] | [_] => name(alike.first()),
    }
}

/// What a part is, and its faces: those that say the same on one line, with how well the first one's shape fits.
fn body(part: &PartReport, traced_nm: f64) -> (String, Vec<(String, String)>) {
    let mut what: Vec<String> = part.medium.iter().map(words::medium).collect();
    what.push(part.size_m.map_or_else(|| "no geometry".to_owned(), words::size));
    if part.priority != 0 {
        what.push(format!("priority {}", part.priority));
    }
    if part.instances > 1 {
        what.push(format!("one of {} instances of mesh {}", part.instances, words::name(&part.mesh)));
    }
    let mut lines: Vec<(String, Vec<usize>, String)> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for face in &part.faces {
        let text = words::face(face, traced_nm);
        let slot = *known.entry(text.clone()).or_insert(lines.len());
        match lines.get_mut(slot) {
            Some((_, numbers, _)) => numbers.push(face.number),
            None => {
                let fit = face.fit.map(|residual| format!(" (fit: {residual})"));
                lines.push((text, vec![face.number], fit.unwrap_or_default()));
            }
        }
    }
    if part.faces.is_empty() {
        what.push(format!("{} faces", part.face_count));
    }
    if let ([(text, _, fit)], None) = (lines.as_slice(), &part.medium) {
        what.push(format!("{text}{fit}"));
        return (what.join(", "), Vec::new());
    }
    let line = |(text, numbers, fit): (String, Vec<usize>, String)| {
        let faces = if numbers.len() == 1 { "face" } else { "faces" };
        (format!("{faces} {}: {text}", words::ranges(&numbers)), fit)
    };
    (what.join(", "), lines.into_iter().map(line).collect())
}

fn lamps_and_eye(tree: &AssemblyTree, out: &mut String) {
    let Some(optics) = &tree.optics else { return };
    let _ = writeln!(out, "\nlamps");
    if optics.groups.is_empty() && optics.sky.is_none() {
        let _ = writeln!(out, "  none");
    }
    for group in &optics.groups {
        let count = |number: usize, what: &str| match number {
            0 => None,
            1 => Some(format!("1 {what}")),
            _ => Some(format!("{number} {what}s")),
        };
        let number = |x: f64| words::number(x, 4);
        let range = |[low, high]: [f64; 2], unit: &str| {
            let (low, high) = (number(low), number(high));
            if low == high { format!("{low} {unit}") } else { format!("{low} to {high} {unit}") }
        };
        let all: Vec<String> = [count(group.faces, "face"), count(group.lights, "light")]
            .into_iter()
            .flatten()
            .chain((group.peak_cd.is_some() || group.flux_lm > 0.0).then(|| format!("{} lm", number(group.flux_lm))))
            .chain(group.peak_cd.map(|peak| format!("peak {} cd", number(peak))))
            .chain(group.illuminance_lx.map(|lux| format!("{} lx", number(lux))))
            .chain(group.luminance_cd_m2.map(|luminance| range(luminance, "cd/m²")))
            .chain(group.half_angle_deg.map(|half| format!("half angle {}", range(half, "deg"))))
            .collect();
        let _ = writeln!(out, "  {}: {}", words::name(&group.name), all.join(", "));
    }
    if let Some(sky) = &optics.sky {
        let [least, mean, greatest] =
            [sky.least_cd_m2, sky.mean_cd_m2, sky.greatest_cd_m2].map(|x| words::number(x, 4));
        let _ = writeln!(
            out,
            "  {}: sky {}, {} x {} pixels, {least} to {greatest} cd/m², mean {mean} cd/m²",
            words::name(&sky.group),
            words::name(&sky.file),
            sky.size[0],
            sky.size[1]
        );
    }
    let eye = &optics.eye;
    let extent = tree.bounds.map_or(0.0, |bounds| bounds.size_m().max_element());
    let focus = if eye.focus_distance_m.is_finite() {
        format!("{} mm", words::mm(eye.focus_distance_m))
    } else {
        "infinity".to_owned()
    };
    let [_, half] = eye.half_tangents();
    let _ = writeln!(
        out,
        "\neye\n  at {} mm, looks along {}, up {}\n  pupil {}, focus at {focus}, field {} x {} deg, {} x {} pixels, age {}",
        words::place(eye.position, extent),
        words::direction(eye.look),
        words::direction(eye.up),
        if eye.adapts {
            "adapted to the picture".to_owned()
        } else {
            format!("{} mm", words::mm(eye.pupil_diameter_m))
        },
        words::number(eye.fov_deg, 4),
        words::number(2.0 * half.atan().to_degrees(), 4),
        eye.resolution[0],
        eye.resolution[1],
        words::number(eye.age, 4)
    );
    let limits = &eye.limits;
    let mrad = |name: &str, mrad: Option<f64>| mrad.map(|mrad| format!("{name} {} mrad", words::number(mrad, 4)));
    let distance = limits.image_distance_m.map(|m| match m.is_finite() {
        true => format!("the image at {} mm", words::mm(m)),
        false => "the image at infinity".to_owned(),
    });
    let said = [
        mrad("convergence", limits.convergence_mrad),
        mrad("divergence", limits.divergence_mrad),
        mrad("dipvergence", limits.dipvergence_mrad),
        distance,
    ];
    let said: Vec<String> = said.into_iter().flatten().collect();
    if !said.is_empty() {
        let _ = writeln!(out, "  limits of two eyes: {}", said.join(", "));
    }
}

/// Fits stand at their faces already.
fn notes(tree: &AssemblyTree, out: &mut String) {
    let at_a_face = |note: &&Note| {
        tree.optics.is_some() && note.residual.is_some() && matches!(note.at, Where::Part { face: Some(_), .. })
    };
    let rest: Vec<&Note> = tree.notes.iter().filter(|note| !at_a_face(note)).collect();
    if rest.is_empty() {
        return;
    }
    let _ = writeln!(out, "\nnotes");
    for note in rest {
        let severity = match note.severity {
            Severity::Warning => "warning",
            Severity::Info => "info",
        };
        let at = words::name(&note.at.to_string());
        let at = if at.is_empty() { at } else { format!(" {at}:") };
        let _ = writeln!(out, "  {severity}:{at} {}", words::name(&note.text));
    }
}
