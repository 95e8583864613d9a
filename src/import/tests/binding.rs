//! Which of several values holds.

use super::{BASE, built, built_on};
use crate::binding_slots::Rank;
use crate::testing::assembly;
use crate::value::{Data, Value};
use crate::{Built, Explained};
use eyebox_base::{Code, Where};
use eyebox_scene::{Finish, Part, StandardSurface};

fn part<'a>(built: &'a Built, name: &str) -> &'a Part {
    built.scene.parts.iter().find(|part| part.name == name).unwrap()
}

fn finishes(built: &Built, name: &str) -> Vec<Finish> {
    part(built, name).faces.iter().map(|face| face.finish).collect()
}

#[test]
fn the_more_specific_wins_in_any_order() {
    let rows = [
        "[[bind]]\npath = \"**\"\nfinish = \"none\"\n",
        "[[bind]]\npath = \"LED_1\"\nfinish = \"polished\"\n",
        "[[bind]]\npath = \"LED_*\"\nfaces = [4]\nfinish = { lambert = { reflectance = 0.5, transmittance = 0 } }\n",
        "[[bind]]\nname = \"LED_2\"\nnormal = \"-z\"\nfinish = { kind = \"mirror\", reflectance = 0.9 }\n",
    ];
    let lambert = Finish::Lambert { reflectance: 0.5, transmittance: 0.0 };
    for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1]] {
        let text: String = order.iter().map(|row| rows[*row]).collect();
        let built = built(&text, &[]).unwrap();
        assert_eq!(finishes(&built, "LENS"), [Finish::None; 6]);
        let one = [Finish::Polished, Finish::Polished, Finish::Polished, Finish::Polished, lambert, Finish::Polished];
        assert_eq!(finishes(&built, "LED_1"), one);
        assert_eq!(finishes(&built, "LED_2")[4], Finish::MirrorIdeal { reflectance: 0.9 });
        assert_eq!(finishes(&built, "LED_2")[3], Finish::None);
    }
    assert_eq!(finishes(&built("", &[]).unwrap(), "LCD"), [Finish::Absorber; 6]);
}

#[test]
fn a_tie_is_no_fault_if_it_agrees_or_if_something_stronger_decides() {
    let agree = "[[bind]]\npath = \"LED_*\"\nfinish = \"none\"\n[[bind]]\npath = \"*_1\"\nfinish = \"none\"\n";
    assert_eq!(finishes(&built(agree, &[]).unwrap(), "LED_1"), [Finish::None; 6]);
    let decided = "[[bind]]\npath = \"LED_*\"\nfinish = \"none\"\n[[bind]]\npath = \"*_1\"\nfinish = \"polished\"\n\
                   [[bind]]\npath = \"ROOT/LED_1\"\nfinish = \"absorber\"\n";
    let built = built(decided, &[]).unwrap();
    assert_eq!((finishes(&built, "LED_1")[0], finishes(&built, "LED_2")[0]), (Finish::Absorber, Finish::None));
}

#[test]
fn paths_match_with_and_without_the_one_root() {
    for path in ["LENS", "ROOT/LENS", "*/LENS", "**/LENS", "LEN*", "**"] {
        let text = format!("[[bind]]\npath = \"{path}\"\nfinish = \"polished\"\nglass = \"PMMA\"\n");
        assert_eq!(finishes(&built(&text, &[]).unwrap(), "LENS"), [Finish::Polished; 6], "{path}");
    }
}

#[test]
fn duplicates_are_listed() {
    let double = || assembly(&["LED", "LENS", "LED"]);
    let text = format!("{BASE}[[bind]]\npath = \"LED\"\nfinish = \"none\"\n");
    assert_eq!(
        built_on(double(), &text, &[]).unwrap_err().to_string(),
        "hud.optics.toml:11: path `LED` means 2 parts: ROOT/LED, ROOT/LED; expected the path of one part, or a pattern, \
         e.g. `**/NAME`, for all of them"
    );
    let text = format!("{BASE}[[bind]]\nname = \"LED\"\nfinish = \"none\"\n");
    let built = built_on(double(), &text, &[]).unwrap();
    assert!(built.scene.notes.iter().any(|note| note.text == "name `LED` means 2 parts: ROOT/LED, ROOT/LED"));
    assert_eq!(built.scene.parts[2].faces[0].finish, Finish::None);
    assert_eq!(
        built_on(double(), BASE, &["LED.finish=none"]).unwrap_err().to_string(),
        "--set LED.finish=none: `LED` means 2 parts: ROOT/LED, ROOT/LED; expected the path of one part, or a pattern for \
         all of them"
    );
}

#[test]
fn materials_and_meshes_select_too() {
    let mut two = assembly(&["A", "B"]);
    let mut black = two.materials[0].clone();
    black.name = "BLACK".into();
    two.materials.push(black);
    two.meshes[1].materials[3] = Some(1);
    let text = format!(
        "{BASE}[[bind]]\nmaterial = \"BLACK\"\nfinish = \"none\"\n[[bind]]\nmesh = \"A\"\nfinish = \"polished\"\n"
    );
    let built = built_on(two, &text, &[]).unwrap();
    assert_eq!(finishes(&built, "A"), [Finish::Polished; 6]);
    let mut expected = [Finish::Absorber; 6];
    expected[3] = Finish::None;
    assert_eq!(finishes(&built, "B"), expected);
}

fn table(entries: &[(&str, Data)], pointer: &str) -> Value {
    let at = Where::Pointer { file: "a.glb".into(), pointer: pointer.into() };
    let entry = |(key, data): &(&str, Data)| ((*key).to_owned(), Value::new(data.clone(), at.clone()));
    Value::new(Data::Table(entries.iter().map(entry).collect()), at.clone())
}

fn text(text: &str) -> Data {
    Data::Text(text.into())
}

#[test]
fn the_assets_own_attributes_bind_below_the_sidecar() {
    let carrying = || {
        let mut asset = assembly(&["A", "B"]);
        let list = |value: Value| Data::List(vec![value]);
        let film = table(&[("n", Data::Number(1.38)), ("thickness_nm", Data::Number(100.0))], "/f");
        asset.optics = Some(table(
            &[
                ("version", Data::Number(1.0)),
                ("unit", Data::Number(1e-3)),
                ("wavelengths", text("visible")),
                (
                    "media",
                    list(table(
                        &[("name", text("acryl")), ("cauchy", list(Value::new(Data::Number(1.49), Where::Nowhere)))],
                        "/m",
                    )),
                ),
                ("coatings", list(table(&[("name", text("ar")), ("stack", list(film))], "/c"))),
                ("emitters", list(table(&[("group", text("led")), ("flux_lm", Data::Number(2.0))], "/e"))),
                ("eye", table(&[("position", list(Value::new(text("0 mm"), Where::Nowhere)))], "/eye").clone().data),
            ],
            "/extensions/EYEBOX_optics",
        ));
        asset.materials[0].mapped = vec![
            ("finish".into(), Value::new(text("none"), Where::Nowhere)),
            ("emitter.luminance_cd_m2".into(), Value::new(Data::Number(7.0), Where::Nowhere)),
            ("emitter.group".into(), Value::new(text("glow"), Where::Nowhere)),
        ];
        asset.materials[0].attributes =
            Some(table(&[("finish", text("polished")), ("coating", Data::Number(0.0))], "/materials/0"));
        asset.nodes[1].attributes =
            Some(table(&[("medium", Data::Number(0.0)), ("emitter", Data::Number(0.0))], "/nodes/1"));
        let axis = [0.0, 0.0, 1.0].map(|x| Value::new(Data::Number(x), Where::Nowhere));
        let plane =
            [("kind", text("plane")), ("vertex", Data::List(axis.to_vec())), ("axis", Data::List(axis.to_vec()))];
        asset.meshes[0].attributes[5] = Some(table(&[("shape", table(&plane, "/s").data)], "/meshes/0/primitives/5"));
        asset
    };
    let eye = &BASE[..BASE.find("[default]").unwrap()];
    let built = built_on(carrying(), &eye.replace("wavelengths = { mono_nm = 550 }\n", ""), &[]).unwrap();
    let scene = &built.scene;
    assert_eq!(scene.unit_m, 1e-3);
    assert_eq!((scene.media[0].name.as_str(), scene.coatings[0].name.as_str()), ("acryl", "ar"));
    let (a, b) = (part(&built, "A"), part(&built, "B"));
    assert!(a.medium.is_some() && b.medium.is_none());
    assert_eq!((a.faces[0].finish, a.faces[0].coating.map(|id| id.0)), (Finish::Polished, Some(0)));
    assert_eq!(a.faces[5].shape, eyebox_scene::Shape::Plane { vertex: glam::DVec3::Z, axis: glam::DVec3::Z });
    let group = |part: &Part| scene.group(part.faces[1].emitter.as_ref().unwrap().group).name.clone();
    assert_eq!((group(a), group(b)), ("led".into(), "glow".into()));
    // The sidecar's weakest selector beats the asset; its [default] doesn't.
    let over = format!(
        "{eye}[default]\nfinish = \"none\"\n[[bind]]\npath = \"A\"\nfinish = \"absorber\"\ncoating = \"none\"\nmedium = \"none\"\n"
    );
    let built = built_on(carrying(), &over, &[]).unwrap();
    assert_eq!((part(&built, "A").faces[0].finish, part(&built, "A").medium), (Finish::Absorber, None));
    assert_eq!(part(&built, "B").faces[0].finish, Finish::Polished);
    let broken = |change: &dyn Fn(&mut crate::Assembly)| {
        let mut asset = carrying();
        change(&mut asset);
        built_on(asset, &over, &[]).unwrap_err().to_string()
    };
    assert_eq!(
        broken(&|asset| asset.nodes[2].attributes = Some(table(&[("emitter", Data::Number(1.0))], "/nodes/2"))),
        "a.glb#/nodes/2: emitter 1 does not exist; expected an index from 0 to 0"
    );
    assert_eq!(
        broken(&|asset| asset.meshes[0].attributes[1] = Some(table(&[("ior", Data::Number(1.5))], "/p"))),
        "a.glb#/p: `ior` is said of a face, but it fills a whole part; expected it on the node"
    );
    assert_eq!(
        broken(&|asset| asset.materials[0].attributes = Some(table(&[("finnish", text("none"))], "/materials/0"))),
        "a.glb#/materials/0: unknown attribute `finnish` in material `GLASS`; expected one of medium, ior, glass, sellmeier, \
         cauchy, abbe, index_table, absorption_per_m, priority, finish, coating, shape, emitter, slide, sensor; did you mean `finish`?"
    );
    assert_eq!(
        broken(&|asset| asset.nodes[1].mesh = Some(9)),
        "a.glb#/nodes/1: node `ROOT/A` has mesh 9, which does not exist; expected a mesh below 2"
    );
}

#[test]
fn a_node_speaks_for_the_parts_below_it_and_for_some_faces() {
    let number = |x: f64| Value::new(Data::Number(x), Where::Nowhere);
    let rows = |at: &str, face: f64, finish: &str| {
        let row = [("faces", Data::List(vec![number(face)])), ("finish", text(finish))];
        Data::List(vec![table(&row, at)])
    };
    let mut asset = assembly(&["A", "B"]);
    asset.nodes[0].attributes = Some(table(
        &[("ior", Data::Number(1.7)), ("finish", text("polished")), ("faces", rows("/r", 2.0, "lambert"))],
        "/nodes/0",
    ));
    asset.nodes[2].attributes =
        Some(table(&[("ior", Data::Number(1.4)), ("faces", rows("/b", 2.0, "none"))], "/nodes/2"));
    asset.optics = Some(table(
        &[("version", Data::Number(1.0)), ("default", table(&[("coating", text("none"))], "/d").data)],
        "/o",
    ));
    let eye = &BASE[..BASE.find("[default]").unwrap()];
    let built = built_on(asset.clone(), eye, &[]).unwrap();
    let (a, b) = (part(&built, "A"), part(&built, "B"));
    assert!(matches!(a.faces[2].finish, Finish::Lambert { .. }) && b.faces[2].finish == Finish::None);
    assert_eq!((a.faces[0].finish, b.faces[0].finish), (Finish::Polished, Finish::Polished));
    assert!(a.medium.is_some() && a.medium != b.medium);
    asset.nodes[0].attributes = Some(table(&[("faces", rows("/r", 9.0, "lambert"))], "/nodes/0"));
    let error = built_on(asset.clone(), eye, &[]).unwrap_err().to_string();
    assert_eq!(error, "a.glb#/r: part ROOT/A has no face 9; expected a face from 0 to 5");
    asset.nodes[0].attributes = Some(table(&[("faces", Data::Number(1.0))], "/nodes/0"));
    let error = built_on(asset, eye, &[]).unwrap_err().to_string();
    assert!(error.contains("`faces` of node `ROOT` is a number"), "{error}");
}

#[test]
fn a_part_goes_by_the_node_that_holds_nothing_else() {
    let mut asset = assembly(&["A", "B"]);
    // ROOT/A becomes a node above its mesh, as USD components are.
    let inner = crate::assembly::Node {
        name: "Body".into(),
        path: "ROOT/A/Body".into(),
        parent: Some(1),
        ..asset.nodes[1].clone()
    };
    asset.nodes[1].mesh = None;
    asset.nodes.push(inner);
    for selector in [
        "path = \"A\"",
        "path = \"ROOT/A/Body\"",
        "path = \"A/Body\"",
        "name = \"Body\"",
        "path = \"**/Body\"",
        "name = \"A\"",
    ] {
        let built = built_on(asset.clone(), &format!("{BASE}[[bind]]\n{selector}\nfinish = \"none\"\n"), &[]).unwrap();
        assert_eq!(part(&built, "A").faces[0].finish, Finish::None, "{selector}");
        assert_eq!(part(&built, "A").path, "ROOT/A");
    }
}

#[test]
fn explained_names_the_line_that_won_and_those_that_lost() {
    let built = built(
        "[[bind]]\npath = \"LE*\"\nfinish = \"none\"\n[[bind]]\npath = \"LENS\"\nglass = \"PMMA\"\nfinish = \"polished\"\n",
        &["LENS.faces[2].finish=absorber"],
    )
    .unwrap();
    let found = built.explained.find("LENS").unwrap();
    let row = |face: Option<usize>| found[0].rows.iter().find(|row| row.face == face).unwrap();
    assert_eq!((row(None).value.as_str(), row(None).at.to_string().as_str()), ("\"PMMA\"", "hud.optics.toml:15"));
    let finish = row(Some(2));
    assert_eq!((finish.rank, finish.at.to_string()), (Rank::Set, "--set LENS.faces[2].finish=absorber".into()));
    let beaten: Vec<_> = finish.beaten.iter().map(|lost| format!("{} {}", lost.value, lost.at)).collect();
    assert_eq!(
        beaten,
        ["\"polished\" hud.optics.toml:16", "\"none\" hud.optics.toml:12", "\"absorber\" hud.optics.toml:9"]
    );
    let nearest = |explained: &Explained, name: &str| explained.find(name).unwrap_err().to_string();
    assert_eq!(
        nearest(&built.explained, "LENZ"),
        "there is no part `LENZ`; expected one of LENS, LED_1, LED_2, LCD; did you mean `LENS`?"
    );
}

#[test]
fn names_that_nothing_uses_are_noted() {
    let text = "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\nmedium = \"a\"\ncoating = \"x\"\n\
                [medium.a]\nior = 1.5\n[medium.b]\nior = 1.6\n\
                [coating.x]\nstack = [{ n = 1.4, thickness_nm = 9 }]\n[coating.y]\nstack = [{ n = 1.3, thickness_nm = 9 }]\n";
    let unused = |sets: &[&str]| -> Vec<String> {
        let notes = super::built(text, sets).unwrap().scene.notes;
        notes.iter().filter(|note| note.text.contains("not used")).map(|note| note.text.clone()).collect()
    };
    assert_eq!(unused(&[]), ["[coating.y] is not used: no part names it", "[medium.b] is not used: no part names it"]);
    // What `--set` puts aside was used by a line of the sidecar.
    assert_eq!(unused(&["LENS.medium=b", "LENS.coating=y"]), [""; 0]);
}

/// One material has a look and is glass besides, the other has none.
#[test]
fn a_look_needs_no_finish_and_can_be_asked_for() {
    let asset = |looks: bool| {
        let mut asset = assembly(&["LENS", "BOX"]);
        asset.materials[0].mapped = vec![("finish".into(), Value::new(Data::Text("polished".into()), Where::Nowhere))];
        asset.materials.push(asset.materials[0].clone());
        asset.materials[1].mapped.clear();
        asset.materials[1].surface = looks.then(|| StandardSurface::default().into());
        asset.meshes[1].materials = vec![Some(1); 6];
        asset
    };
    let eye = &BASE[..BASE.find("[default]").unwrap()];
    let surface = |built: &Built, name| finishes(built, name).iter().all(|finish| finish.surface().is_some());
    let text = format!("{eye}[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\n");
    let unsaid = built_on(asset(true), &text, &[]).unwrap();
    let said = |built: &Built| built.scene.notes.iter().any(|note| note.text.contains("look as their materials say"));
    assert!(surface(&unsaid, "BOX") && said(&unsaid));
    assert!(unsaid.scene.notes.iter().all(|note| note.code.is_none()), "{:?}", unsaid.scene.notes);
    // What is asked for need not be said, and a stronger binding gives the look back.
    let asked = format!(
        "{eye}[default]\nfinish = \"absorber\"\n[[bind]]\npath = \"*\"\nfinish = \"material\"\nglass = \"PMMA\"\n"
    );
    let built = built_on(asset(true), &asked, &[]).unwrap();
    assert!(surface(&built, "BOX") && !said(&built));
    assert_eq!(finishes(&built, "LENS"), [Finish::Polished; 6]);
    for text in [&text, &asked] {
        let fault = built_on(asset(false), text, &[]).map(|_| ()).unwrap_err();
        assert_eq!(fault.code, Some(Code::PartUnbound), "{fault}");
    }
}
