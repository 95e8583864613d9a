//! Which layers a stage asks for, and its camera.

use super::kit::{assembly, notes};

const RENDER: &str = r#"
def Camera "First" { }
def Camera "Meant" { }
def Scope "Render" {
    def RenderSettings "S" {
        rel products = </Render/P>
        rel camera = </Meant>
        uniform int2 resolution = (64, 32)
    }
    def RenderProduct "P" {
        rel orderedVars = [</Render/a>, </Render/b>, </Render/c>, </Render/d>, </Render/e>, </Render/nothing>]
    }
    def RenderVar "a" {
        uniform string sourceName = "direct"
    }
    def RenderVar "b" {
        uniform string sourceName = "C.*"
        uniform token sourceType = "lpe"
        string driver:parameters:aov:name = "all"
    }
    def RenderVar "c" {
        uniform string sourceName = "Z"
        string driver:parameters:aov:name = "far"
        string driver:parameters:aov:channel_prefix = "deep"
    }
    def RenderVar "d" {
        uniform string sourceName = "st"
        uniform token sourceType = "primvar"
    }
    def RenderVar "e" { }
}
"#;

#[test]
fn render_vars_are_wishes() {
    let found = assembly(RENDER);
    let wishes: Vec<_> =
        found.layers.iter().map(|wish| (wish.source.as_str(), wish.expression, wish.name.as_str())).collect();
    assert_eq!(wishes, [("direct", false, "a"), ("C.*", true, "all"), ("Z", false, "deep")]);
    let cameras: Vec<_> = found.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(cameras, ["Meant", "First"]);
    let notes = notes(&found);
    for what in ["primvar", "without `sourceName`", "</Render/nothing> is no RenderVar", "resolution"] {
        assert!(notes.contains(what), "{what}\n{notes}");
    }
}

#[test]
fn the_stage_says_which_settings() {
    let two = format!("{RENDER}def RenderSettings \"T\" {{ rel camera = </First> }}\n");
    let found = assembly(&two);
    assert!(found.layers.is_empty() && notes(&found).contains("several RenderSettings"));
    let named = assembly(&format!("(\n renderSettingsPrimPath = \"/T\"\n)\n{two}"));
    assert!(named.layers.is_empty());
    assert_eq!(named.cameras[0].name, "First");
    let named = assembly(&format!("(\n renderSettingsPrimPath = \"/Render/S\"\n)\n{two}"));
    assert_eq!((named.layers.len(), named.cameras[0].name.as_str()), (3, "Meant"));
    let wrong = assembly(&format!("(\n renderSettingsPrimPath = \"/First\"\n)\n{two}"));
    assert!(notes(&wrong).contains("no RenderSettings"));
}
