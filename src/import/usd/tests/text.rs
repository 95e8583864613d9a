//! What usd-core 26.11 takes and the library's parser does not; each line was tried there.

use super::kit::{assembly, fault};
use crate::import::usd::normalise::layer;

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
        "string s = \"\"\"\n .5 \\\"\"\" .7\"\"\"",
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
