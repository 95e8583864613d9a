//! Paths as linear `BasisCurves`: a prim for each end, a curve for each path, names in primvars.

use super::{End, Line, Space, by_end};
use std::collections::BTreeSet;
use std::fmt::Write;

/// The text of the layer.
pub fn text(lines: &[Line<'_>], space: &Space) -> String {
    let up = if space.z_up { "Z" } else { "Y" };
    let mut out = format!(
        "#usda 1.0\n(\n    defaultPrim = \"rays\"\n    metersPerUnit = {}\n    upAxis = \"{up}\"\n)\n\ndef Scope \"rays\"\n{{\n",
        space.unit_m
    );
    let mut taken = BTreeSet::new();
    let width = width(lines);
    for (end, lines) in by_end(lines) {
        let name = name(&end.text(), &mut taken);
        // Writing to a String does not fail.
        let _ = prim(&mut out, &name, end, &lines, width);
    }
    out.push_str("}\n");
    out
}

/// A name that is an identifier and its own.
fn name(text: &str, taken: &mut BTreeSet<String>) -> String {
    let plain: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let mut name = plain.clone();
    for k in 2.. {
        if taken.insert(name.clone()) {
            break;
        }
        name = format!("{plain}_{k}");
    }
    name
}

/// A line's width: a thousandth of all that is drawn.
fn width(lines: &[Line<'_>]) -> f32 {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in lines.iter().flat_map(|line| &line.points) {
        low = std::array::from_fn(|i| low[i].min(p[i]));
        high = std::array::from_fn(|i| high[i].max(p[i]));
    }
    let most = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
    if most.is_finite() { 1e-3 * most } else { 0.0 }
}

fn prim(out: &mut String, name: &str, end: &End, lines: &[&Line<'_>], width: f32) -> std::fmt::Result {
    let each = |of: &dyn Fn(&Line<'_>) -> String| lines.iter().map(|line| of(line)).collect::<Vec<_>>().join(", ");
    let point = |p: &[f32; 3]| format!("({}, {}, {})", p[0], p[1], p[2]);
    let points = |line: &Line<'_>| line.points.iter().map(point).collect::<Vec<_>>().join(", ");
    let all = || lines.iter().flat_map(|line| &line.points);
    let half = 0.5 * width;
    let low = all().fold([f32::INFINITY; 3], |b, p| std::array::from_fn(|i| b[i].min(p[i] - half)));
    let high = all().fold([f32::NEG_INFINITY; 3], |b, p| std::array::from_fn(|i| b[i].max(p[i] + half)));
    let [r, g, b] = end.colour();
    writeln!(out, "    def BasisCurves \"{name}\"\n    {{")?;
    writeln!(out, "        uniform token type = \"linear\"")?;
    writeln!(out, "        uniform token wrap = \"nonperiodic\"")?;
    writeln!(out, "        int[] curveVertexCounts = [{}]", each(&|line| line.points.len().to_string()))?;
    writeln!(out, "        point3f[] points = [{}]", each(&points))?;
    writeln!(out, "        float3[] extent = [{}, {}]", point(&low), point(&high))?;
    writeln!(out, "        float[] widths = [{width}] (\n            interpolation = \"constant\"\n        )")?;
    writeln!(
        out,
        "        color3f[] primvars:displayColor = [({r}, {g}, {b})] (\n            interpolation = \"constant\"\n        )"
    )?;
    let primvar = |out: &mut String, kind: &str, name: &str, values: String| {
        writeln!(
            out,
            "        {kind}[] primvars:{name} = [{values}] (\n            interpolation = \"uniform\"\n        )"
        )
    };
    primvar(out, "string", "fate", each(&|_| quoted(end.kind())))?;
    primvar(out, "string", "part", each(&|_| quoted(end.part().unwrap_or_default())))?;
    primvar(out, "string", "met", each(&|line| quoted(&line.strip.met.join(" → "))))?;
    primvar(out, "float", "power", each(&|line| (line.strip.power as f32).to_string()))?;
    writeln!(out, "    }}")
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
