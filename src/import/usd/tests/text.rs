//! What usd-core 26.11 takes and the library's parser does not; each line was tried there.

use super::kit::{assembly, fault};
use crate::usd::normalise::layer;

fn normalised(text: &str) -> String {
    String::from_utf8(layer(text.as_bytes()).unwrap().into_owned()).unwrap()
}

#[test]
fn values_in_the_parsers_own_form() {
    for (given, want) in [
        ("double a = .5", "double a = 0.5"),
        ("double a = 5.", "double a = 5.0"),
        ("double a = -.5", "double a = -0.5"),
        ("float a = 1.e3", "float a = 1.0e3"),
        ("float3 a = (.5, 1., -.25)", "float3 a = (0.5, 1.0, -0.25)"),
        ("asset a = \"x.png\"", "asset a = @x.png@"),
        ("asset[] a = [\"x\", @y@]", "asset[] a = [@x@, @y@]"),
        ("bool a = True", "bool a = true"),
        ("bool a = yes (doc = \"no\")", "bool a = true (doc = \"no\")"),
        ("bool a = 5", "bool a = true"),
        ("bool a = \"true\"", "bool a = true"),
        ("int a = 5.5", "int a = 5"),
        ("int[] a = [1.0, 2, 3.]", "int[] a = [1, 2, 3]"),
        ("int a = 1e3", "int a = 1000"),
        ("int a.timeSamples = { .5: 1., 2: 3 }", "int a.timeSamples = { 0.5: 1, 2: 3 }"),
        ("int a = 1 (hidden = True)", "int a = 1 (hidden = true)"),
        ("token a = </B.c>", "token a = \"/B.c\""),
        ("config token a = \"b\"", " token a = \"b\""),
        ("asset a = 'x.png'", "asset a = @x.png@"),
        ("asset a = 'c:\\\\it\\'s.png'", "asset a = @c:\\it's.png@"),
        ("asset a = 'x@2.png'", "asset a = @@@x@2.png@@@"),
        ("asset a = @@@a\\@@@b.pdf@@@", "asset a = @@@a\u{fdd0}b.pdf@@@"),
        ("doc = \"\"\"a \\\"\"\" b\"\"\"", "doc = \"\"\"a \\x22\"\" b\"\"\""),
        ("string a = '''one \\''' \n two'''\ndouble b = 1.", "string a = '''one \\x27'' \n two'''\ndouble b = 1.0"),
        (
            "def Xform \"A\" ( active = 1 ) { double active = 1 }",
            "def Xform \"A\" ( active = true ) { double active = 1 }",
        ),
        (
            "(\n instanceable = no\n hidden = 2\n active = 'yes'\n)",
            "(\n instanceable = false\n hidden = true\n active = true\n)",
        ),
        ("int a = 1 // b = 2.\nint c = 3.", "int a = 1 \nint c = 3"),
        ("int a = 1 /* 2.\n */\nint c = 3.", "int a = 1 \n\nint c = 3"),
        ("int[] a = [\n 1., # 2.\n 3.\n]\ndouble b = 4.", "int[] a = [\n 1, # 2.\n 3\n]\ndouble b = 4.0"),
    ] {
        assert_eq!(normalised(given), want);
    }
}

#[test]
fn all_else_stays_as_it_is() {
    for text in [
        "string a = \".5 True\"",
        "token a = \"yes\"",
        "token a.connect = </B.c>",
        "float config = 1.5",
        "double a = 0.5e-3",
        "# .5 True\ndouble a = 1",
        "string s = \"\"\"\n .5 \"\" ' .7\"\"\"",
        "string s = \"\"\"a\\\\\"\"\"",
        "double active = 5",
        "string s = \"active = 1\"",
        "rel r = </a.b>",
        "prepend references = @./x.5.usda@</A>",
        "double a.timeSamples = { 1: 2, }",
        "def Xform \"True\" { }",
        "float a = inf",
        "asset a = @@@a@b@@@",
        "token[] xformOpOrder = [\"xformOp:translate\"]",
    ] {
        assert_eq!(normalised(text), text);
    }
}

/// Files re-made from public bug reports; each opens in usd-core 26.11 as one sphere of 1 mm radius.
#[test]
fn layers_of_bug_reports_open() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/data/usda_text");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "usda") {
            let found = crate::usd::read(&file, &crate::ReadOptions::default());
            let found = found.unwrap_or_else(|fault| panic!("{fault}"));
            let wide = found.meshes.iter().flat_map(|own| &own.mesh.positions).fold(0f32, |wide, at| wide.max(at[0]));
            assert_eq!((super::kit::paths(&found), wide, found.unit_m), (vec!["s"], 1.0, 0.001), "{}", file.display());
            let said = super::kit::notes(&found).contains("`visibility` is no token: not said, as in USD");
            assert_eq!(said, file.ends_with("q5_bool_visibility.usda"), "{}", super::kit::notes(&found));
            seen += 1;
        }
    }
    assert_eq!(seen, 6);
}

/// Three signs in the name of a file.
#[test]
fn escaped_signs_name_their_file() {
    let root = "def \"A\" ( references = @@@b\\@@@c.usda@@@ ) { }\n";
    let part = "( defaultPrim = \"P\" )\ndef Xform \"P\" { def Xform \"Q\" { } }\n";
    let found = super::kit::Folder::new(&[("a.usda", root), ("b@@@c.usda", part)]).read(None).unwrap();
    assert_eq!(super::kit::paths(&found), ["A", "A/Q"], "{}", super::kit::notes(&found));
}

#[test]
fn lines_of_errors_stay_right() {
    let text = fault("def Xform \"A\"\n{\n    double a = .5\n    bool b = True\n    float c = \"1\" ???\n}\n");
    assert!(text.contains("a.usda:6"), "{text}");
}

#[test]
fn nesting_is_bounded() {
    let deep = format!("{}{}", "def \"a\" {\n".repeat(5000), "}\n".repeat(5000));
    assert!(fault(&deep).contains("nested"));
    let wide: String = (0..2000).map(|i| format!("def Xform \"a{i}\" {{ }}\n")).collect();
    assert_eq!(assembly(&wide).nodes.len(), 2000);
}
