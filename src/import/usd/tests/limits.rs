//! Assets that multiply inside composition end in a result or a fault, and soon.

use super::kit::{Folder, assembly};
use crate::Assembly;
use std::fmt::Write;
use std::time::{Duration, Instant};

const ROOT: &str = "(\n    defaultPrim = \"P0\"\n    metersPerUnit = 1\n)\n";

/// What reading says, in the time that every file has.
fn said(name: &str, files: &[(&str, &str)]) -> Result<usize, String> {
    let folder = Folder::new(files);
    let start = Instant::now();
    let found = folder.read(None).map(|assembly| assembly.nodes.len());
    assert!(start.elapsed() < Duration::from_secs(20), "{name} takes {:?}", start.elapsed());
    found
}

/// A chain of `count` arcs within a layer.
fn chain(arc: &str, count: usize) -> String {
    let mut out = ROOT.to_owned();
    for i in 0..count {
        writeln!(out, "def Xform \"P{i}\" ( {arc} = </P{}> ) {{ }}", i + 1).unwrap();
    }
    out + &format!("def Xform \"P{count}\" {{ }}\n")
}

/// Each of `levels` levels leads to all ten prims of the next.
fn product(arc: &str, levels: usize) -> String {
    let mut out = ROOT.replace("P0", "L0_0");
    for level in 0..levels {
        let targets: Vec<String> = (0..10).map(|i| format!("</L{}_{i}>", level + 1)).collect();
        for i in 0..if level == 0 { 1 } else { 10 } {
            let specifier = if level == 0 { "def" } else { "class" };
            writeln!(out, "{specifier} Xform \"L{level}_{i}\" ( {arc} = [{}] ) {{ }}", targets.join(", ")).unwrap();
        }
    }
    for i in 0..10 {
        writeln!(out, "class \"L{levels}_{i}\" {{ }}").unwrap();
    }
    out
}

#[test]
fn chains_of_arcs() {
    for arc in ["references", "payload", "inherits", "specializes"] {
        assert_eq!(said(arc, &[("a.usda", &chain(arc, 90))]), Ok(91), "{arc}");
        let fault = said(arc, &[("a.usda", &chain(arc, 5000))]).unwrap_err();
        assert!(fault.contains("a.usda</P0>: more than 400 references"), "{fault}");
    }
    let mut files: Vec<(String, String)> = (0..1000)
        .map(|i| (format!("{i}.usda"), format!("{ROOT}def Xform \"P0\" ( references = @{}.usda@ ) {{ }}\n", i + 1)))
        .collect();
    files.push(("1000.usda".to_owned(), format!("{ROOT}def Xform \"P0\" {{ }}\n")));
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    assert!(said("files", &files).unwrap_err().contains("in a chain; expected at most 400"));
}

#[test]
fn arcs_that_multiply() {
    for arc in ["references", "payload", "inherits", "specializes", "instanceable = true\n references"] {
        assert_eq!(said(arc, &[("a.usda", &product(arc, 2))]), Ok(1), "{arc}");
        for (levels, number) in [(4, "11111"), (30, "18446744073709551615")] {
            let fault = said(arc, &[("a.usda", &product(arc, levels))]).unwrap_err();
            let want = format!("</L0_0>: the prim is composed of {number} opinions");
            assert!(fault.contains(&want) && fault.ends_with("expected at most 2000"), "{arc}: {fault}");
        }
    }
    // Every prim refers to every other one: more ways round than atoms.
    let mut knot = ROOT.to_owned();
    for i in 0..30 {
        let others: Vec<String> = (0..30).filter(|&j| j != i).map(|j| format!("</P{j}>")).collect();
        writeln!(knot, "def Xform \"P{i}\" ( references = [{}] ) {{ }}", others.join(", ")).unwrap();
    }
    assert!(said("knot", &[("a.usda", &knot)]).unwrap_err().contains("opinions"));
}

#[test]
fn prims_and_variants_that_multiply() {
    let mut deep = ROOT.to_owned();
    let mut nested = ROOT.to_owned();
    for (out, instance) in [(&mut deep, ""), (&mut nested, "instanceable = true\n")] {
        for level in 0..40 {
            writeln!(out, "{} Xform \"P{level}\" {{", if level == 0 { "def" } else { "class" }).unwrap();
            for i in 0..10 {
                writeln!(out, "    def Xform \"c{i}\" ( {instance}references = </P{}> ) {{ }}", level + 1).unwrap();
            }
            *out += "}\n";
        }
        *out += "class Xform \"P40\" { def Sphere \"S\" { } }\n";
    }
    assert!(said("prims", &[("a.usda", &deep)]).is_err());
    assert!(said("instances", &[("a.usda", &nested)]).unwrap_err().contains("repeats itself"));
    let mut sets = format!("{ROOT}def Xform \"P0\" ( variantSets = [");
    let names: Vec<String> = (0..1000).map(|i| format!("\"v{i}\"")).collect();
    write!(sets, "{}]\n    variants = {{ ", names.join(", ")).unwrap();
    (0..1000).for_each(|i| writeln!(sets, "string v{i} = \"a\"").unwrap());
    sets += "} ) {\n";
    (0..1000).for_each(|i| writeln!(sets, "variantSet \"v{i}\" = {{ \"a\" {{ def Xform \"c{i}\" {{ }} }} }}").unwrap());
    sets += "}\n";
    assert!(said("variant sets", &[("a.usda", &sets)]).unwrap_err().contains("units of work"));
    // Only one of many variants is there.
    let mut one = format!(
        "{ROOT}def Xform \"P0\" ( variantSets = [\"v\"]\n variants = {{ string v = \"a7\" }} ) {{\nvariantSet \"v\" = {{\n"
    );
    (0..3000).for_each(|i| writeln!(one, "\"a{i}\" ( references = </P1> ) {{ }}").unwrap());
    one += "}\n}\nclass Xform \"P1\" { def Xform \"x\" { } }\n";
    assert_eq!(said("variants", &[("a.usda", &one)]), Ok(2));
}

#[test]
fn sublayers_that_multiply() {
    let mut files = Vec::new();
    for level in 0..20 {
        for i in 0..4 {
            let below: Vec<String> = (0..4).map(|j| format!("@l{}_{j}.usda@", level + 1)).collect();
            let below = if level < 19 { below.join(", ") } else { String::new() };
            let text = format!("(\n    subLayers = [{below}]\n)\nover \"P0\" {{ }}\n");
            files.push((format!("l{level}_{i}.usda"), text));
        }
    }
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let fault = said("sublayers", &files).unwrap_err();
    assert!(fault.contains("layers or more; expected at most 20000"), "{fault}");
    let root = format!("{ROOT}def Xform \"P0\" ( references = @l0_0.usda@</P0> ) {{ }}\n");
    let files = [&[("root.usda", root.as_str())][..], &files].concat();
    assert!(said("referenced", &files).unwrap_err().contains("root.usda</P0>: sublayers that name the same"));
    // Layers that go round are composition's to report.
    let round = "(\n    subLayers = [@b.usda@]\n)\ndef Xform \"P0\" { }\n";
    assert_eq!(said("round", &[("a.usda", round), ("b.usda", &round.replace("@b", "@a"))]), Ok(1));
}

#[test]
fn twenty_thousand_references_to_one_part_are_no_attack() {
    for part in ["def Sphere \"S\" { }", &format!("def Mesh \"S\" {{ {} }}", super::kit::SQUARE)] {
        let mut root = format!("{ROOT}def Xform \"P0\" {{\n");
        for i in 0..20_000 {
            writeln!(root, "    def Xform \"i{i}\" ( references = @part.usda@ ) {{ }}").unwrap();
        }
        root += "}\n";
        let part = format!("{ROOT}def Xform \"P0\" {{ {part} }}\n");
        assert_eq!(said("references", &[("a.usda", &root), ("part.usda", &part)]), Ok(40_001));
    }
}

/// Small cages of a small file become fine meshes all the same; of very many, each is less fine.
#[test]
fn subdivision_does_not_count_as_repeating() {
    let grid = |x: usize| {
        let points: Vec<String> = (0..81).map(|i| format!("({}, {}, {})", x + i % 9, i / 9, (i * x) % 7)).collect();
        let corners = |i: usize| format!("{i}, {}, {}, {}", i + 1, i + 10, i + 9);
        let quads: Vec<String> = (0..64).map(|i| corners(i / 8 * 9 + i % 8)).collect();
        let (points, quads, sizes) = (points.join(", "), quads.join(", "), vec!["4"; 64].join(", "));
        format!(
            "def Mesh \"M{x}\" {{ int[] faceVertexCounts = [{sizes}]\n int[] faceVertexIndices = [{quads}]\n \
             point3f[] points = [{points}] }}\n"
        )
    };
    let stage = |count: usize| -> String { (0..count).map(|x| grid(x + 1)).collect() };
    let levels = |assembly: &Assembly| -> Vec<usize> {
        assembly.meshes.iter().map(|source| source.mesh.triangles.len()).collect()
    };
    let few = assembly(&stage(4));
    assert_eq!(levels(&few), [131_072; 4]);
    // The same cage again is the same mesh, whatever came between.
    let again = assembly(&format!("{}def Xform \"X\" {{ {} }}\n", stage(2), stage(1)));
    assert_eq!(levels(&again), [131_072; 2]);
}
