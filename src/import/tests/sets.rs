//! `--set`.

use super::{built, check};
use eyebox_scene::{Angular, Dispersion, Finish, Photometry, Wavelengths};

const LIT: &str = "[[bind]]\npath = \"LED_*\"\nnormal = \"+z\"\nemitter = { group = \"led\", flux_lm = 0.45, angular = \"lambert\" }\n\
                   [[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = \"ar\"\nmedium = \"glass\"\n\
                   [[bind]]\npath = \"LENS\"\nfaces = [0, 1]\nshape = { kind = \"sphere\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 9 }\n\
                   [coating.ar]\nstack = [{ n = 1.38, thickness_nm = 99.638 }]\n[medium.glass]\nglass = \"PMMA\"\npriority = 2\n";

#[test]
fn sets_are_the_strongest_binding() {
    let sets = [
        "led.flux_lm=0.5",
        "LED_2.emitter.angular={ cos_n = { n = 3 } }",
        "LED_2.luminance_cd_m2=7",
        "LENS.glass=N-SK16",
        "LENS.faces[0].shape.radius=50",
        "coating.ar.stack[0].thickness_nm=110",
        "eye.pupil_diameter=3.6 mm",
        "eye.resolution=[720, 360]",
        "wavelengths.mono_nm=600",
        "unit=0.001",
        "L*D.finish={ kind = \"gauss\", sigma_deg = 6, transmittance = 0.9, reflectance = 0 }",
        "LCD.finish.sigma_deg=5",
    ];
    let built = built(LIT, &sets).unwrap();
    let scene = &built.scene;
    let part = |name: &str| scene.parts.iter().find(|part| part.name == name).unwrap();
    let lamp = |name: &str| part(name).faces[5].emitter.clone().unwrap();
    assert_eq!((lamp("LED_1").photometry, lamp("LED_1").angular), (Photometry::FluxLm(0.5), Angular::Lambert));
    assert_eq!(lamp("LED_2").photometry, Photometry::LuminanceCdM2(7.0));
    assert_eq!(lamp("LED_2").angular, Angular::CosN { n: 3.0 });
    assert_eq!(scene.groups.len(), 1);
    let lens = part("LENS");
    assert_eq!((scene.medium(lens.medium.unwrap()).name.as_str(), lens.priority), ("N-SK16", 2));
    let radius = |face: usize| match lens.faces[face].shape {
        eyebox_scene::Shape::Sphere { radius, .. } => radius,
        ref other => panic!("{other:?}"),
    };
    assert_eq!((radius(0), radius(1)), (50.0, 9.0));
    assert_eq!(scene.coatings[0].films()[0].thickness_nm, 110.0);
    assert_eq!((scene.eye.pupil_diameter_m, scene.eye.resolution), (3.6 * 1e-3, [720, 360]));
    assert_eq!((scene.wavelengths, scene.unit_m), (Wavelengths::Mono { nm: 600.0 }, 0.001));
    assert_eq!(part("LCD").faces[0].finish, Finish::Gauss { sigma_deg: 5.0, reflectance: 0.0, transmittance: 0.9 });
}

#[test]
fn sets_reach_into_a_parts_medium() {
    let own = "[[bind]]\npath = \"LENS\"\nmedium = \"a\"\n[[bind]]\npath = \"LCD\"\nmedium = \"a\"\n[medium.a]\n\
               sellmeier = { b = [1.0, 0.2], c_um2 = [0.01, 0.02] }\nabsorption_per_m = [[500, 1], [600, 3]]\n";
    let medium = |sets: &[&str], part: &str| {
        let scene = built(own, sets).unwrap().scene;
        let part = scene.parts.iter().find(|found| found.name == part).unwrap();
        (scene.medium(part.medium.unwrap()).clone(), part.priority)
    };
    let law = |b0: f64| Dispersion::Sellmeier { b: [b0, 0.2, 0.0], c_um2: [0.01, 0.02, 0.0] };
    for set in ["LENS.sellmeier.b[0]=1.2", "LENS.medium.sellmeier.b[0]=1.2"] {
        assert_eq!(medium(&[set], "LENS").0.index, law(1.2), "{set}");
        // The other part keeps what the two shared.
        assert_eq!(medium(&[set], "LCD").0.index, law(1.0), "{set}");
    }
    assert_eq!(medium(&["LENS.medium.ior=1.7"], "LENS").0.index, Dispersion::Constant(1.7));
    assert_eq!(medium(&["LENS.medium.priority=4"], "LENS").1, 4);
    assert_eq!(medium(&[], "LENS").0.absorption.per_m(550.0), 2.0);
    assert_eq!(medium(&["LENS.absorption_per_m=7"], "LENS").0.absorption.per_m(550.0), 7.0);
    assert_eq!(medium(&["LENS.medium.absorption_per_m[0][1]=2"], "LENS").0.absorption.per_m(550.0), 2.5);
    assert_eq!(medium(&["L*.medium.ior=1.6"], "LCD").0.index, Dispersion::Constant(1.6));
}

#[test]
fn a_set_changes_the_hash_and_a_later_one_wins() {
    let with = |sets: &[&str]| built(LIT, sets).unwrap().scene;
    let (a, b) = (with(&["led.flux_lm=0.5"]), with(&["led.flux_lm=0.6", "led.flux_lm=0.5"]));
    assert_eq!(a.parts, b.parts);
    assert_ne!(a.hash, with(&[]).hash);
    assert_eq!(a.hash, with(&["led.flux_lm=0.5"]).hash);
}

#[test]
fn sets_that_mean_nothing_are_faults() {
    check(ROWS);
}

const ROWS: &[(&str, &[&str], &str)] = &[
    (
        LIT,
        &["led.flux_lm"],
        "--set led.flux_lm: there is no `=`; expected TARGET.attribute=VALUE, e.g. led.flux_lm=0.5",
    ),
    (
        LIT,
        &["led.flux_lm="],
        "--set led.flux_lm=: one side of the `=` is empty; expected TARGET.attribute=VALUE, e.g. led.flux_lm=0.5",
    ),
    (
        LIT,
        &["flux=3"],
        "--set flux=3: `flux` names no attribute; expected TARGET.attribute=VALUE with a part, a light group, eye, sky, sun, default, unit, wavelengths, coating.NAME or medium.NAME",
    ),
    (LIT, &["led.flux_lm=-1"], "--set led.flux_lm=-1: `flux_lm` is -1; expected a number from 0 to 1e12 in lm"),
    (
        LIT,
        &["led.flux_lm=1e300"],
        "--set led.flux_lm=1e300: `flux_lm` is 1000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000; expected a number from 0 to 1e12 in lm",
    ),
    (
        LIT,
        &["led.flux_lum=1"],
        "--set led.flux_lum=1: unknown attribute `flux_lum` of light group `led`; expected one of name, group, flux_lm, luminance_cd_m2, primaries_cd_m2, intensity_cd, illuminance_lx, radiant_flux_w, sides, angular, spectrum, u, polarisation, image, layer, size, v, centre, contrast; did you mean `flux_lm`?",
    ),
    (
        LIT,
        &["leds.flux_lm=1"],
        "--set leds.flux_lm=1: `leds` is neither a part nor a light group; expected TARGET.attribute=VALUE with a part, a light group, eye, sky, sun, default, unit, wavelengths, coating.NAME or medium.NAME; did you mean `led`?",
    ),
    (
        LIT,
        &["LENZ.glass=PMMA"],
        "--set LENZ.glass=PMMA: `LENZ` is neither a part nor a light group; expected TARGET.attribute=VALUE with a part, a light group, eye, sky, sun, default, unit, wavelengths, coating.NAME or medium.NAME; did you mean `LENS`?",
    ),
    (
        LIT,
        &["LENS.glass=PNMA"],
        "--set LENS.glass=PNMA: unknown glass `PNMA`; expected a name of the catalogue; did you mean `PMMA`?",
    ),
    (
        LIT,
        &["LENS.colour=3"],
        "--set LENS.colour=3: unknown attribute `colour` of a part; expected one of medium, ior, glass, sellmeier, cauchy, abbe, index_table, absorption_per_m, priority, finish, coating, shape, emitter, slide, sensor, or an attribute of its emitter or slide",
    ),
    (
        LIT,
        &["LENS.contrast=3"],
        "--set LENS.contrast=3: `LENS` has no slide whose attributes can be set; expected a part with a slide = { … }",
    ),
    (
        LIT,
        &["LENS.shape.radius=3"],
        "--set LENS.shape.radius=3: several faces of `LENS` have a shape; expected one face, e.g. LENS.faces[0].shape.radius=VALUE",
    ),
    (
        LIT,
        &["LENS.faces[9].finish=none"],
        "--set LENS.faces[9].finish=none: part ROOT/LENS has no face 9; expected a face below 6",
    ),
    (
        LIT,
        &["LENS.faces[0].glass=PMMA"],
        "--set LENS.faces[0].glass=PMMA: `glass` fills a whole part, not a face; expected LENS.glass=VALUE",
    ),
    (
        LIT,
        &["LENS.faces[0].shape.radius=0"],
        "--set LENS.faces[0].shape.radius=0: `radius` is 0; expected a finite number other than 0 in mesh units",
    ),
    (
        LIT,
        &["LENS.glass.x=3"],
        "--set LENS.glass.x=3: `glass` of `LENS` is a text (\"PMMA\") and set as a whole; expected LENS.glass=VALUE",
    ),
    (
        LIT,
        &["LENS.sellmeier.b[0]=1.2"],
        "--set LENS.sellmeier.b[0]=1.2: `LENS` has no `sellmeier` to change: its index comes from `glass` (hud.optics.toml:18); expected LENS.sellmeier=VALUE",
    ),
    (
        LIT,
        &["LCD.index_table[0]=[550, 1.5, 0]"],
        "--set LCD.index_table[0]=[550, 1.5, 0]: `LCD` has no `index_table` to change; expected LCD.index_table=VALUE",
    ),
    (
        LIT,
        &["LENS.medium.iro=1.5"],
        "--set LENS.medium.iro=1.5: unknown attribute `iro` of the medium of `LENS`; expected one of ior, glass, sellmeier, cauchy, abbe, index_table, absorption_per_m, priority",
    ),
    (LIT, &["LENS.medium.ior=0.5"], "--set LENS.medium.ior=0.5: `ior` is 0.5; expected a number >= 1"),
    (
        LIT,
        &["LENS.faces[x].finish=none"],
        "--set LENS.faces[x].finish=none: can't read `faces[x].finish`; expected names and numbers, e.g. faces[0].shape.radius",
    ),
    (
        LIT,
        &["coating.arr.stack[0].n=2"],
        "--set coating.arr.stack[0].n=2: there is no coating `arr.stack[0].n`; expected coating.NAME.attribute with one of ar; did you mean `ar`?",
    ),
    (
        LIT,
        &["coating.ar.stack[1].n=2"],
        "--set coating.ar.stack[1].n=2: there is no item 1 in [{ n = 1.38, thickness_nm = 99.638 }]; expected an item below 1",
    ),
    (
        LIT,
        &["coating.ar.stack[0].m=2"],
        "--set coating.ar.stack[0].m=2: unknown attribute `m` of film; expected one of n, k, material, thickness_nm",
    ),
    (
        LIT,
        &["coating.ar.stack.n=2"],
        "--set coating.ar.stack.n=2: [{ n = 1.38, thickness_nm = 99.638 }] has no `n` to set",
    ),
    (LIT, &["eye=3"], "--set eye=3: `eye` is no attribute; expected eye.attribute=VALUE"),
    (
        LIT,
        &["eye.pupil=3"],
        "--set eye.pupil=3: unknown attribute `pupil` of eye; expected one of position, look, up, frame, pupil_diameter, focus_distance, fov_deg, resolution, age, convergence_mrad, divergence_mrad, dipvergence_mrad, image_distance; did you mean `pupil_diameter`?",
    ),
    (
        LIT,
        &["eye.pupil_diameter=4"],
        "--set eye.pupil_diameter=4: `pupil_diameter` is 4 without a unit; expected a length with its unit, e.g. \"4 mm\", or \"auto\"",
    ),
    (
        LIT,
        &["sky.rotation_deg=3"],
        "--set sky.rotation_deg=3: the sky does not say what it is; expected one of image, luminance_cd_m2, overcast_cd_m2, sun_sky",
    ),
    (
        LIT,
        &["LED_1.flux_lm=x"],
        "--set LED_1.flux_lm=x: `flux_lm` is a text (\"x\"); expected a number from 0 to 1e12 in lm",
    ),
    (LIT, &["unit=-1"], "--set unit=-1: `unit` is -1; expected a number > 0 in m"),
    (
        LIT,
        &["LENS.medium=glas"],
        "--set LENS.medium=glas: unknown medium `glas`; expected the name of a [medium.NAME], or \"none\"; a catalogue glass is `glass = …`; did you mean `glass`?",
    ),
    (
        LIT,
        &["default.finish=polisht"],
        "--set default.finish=polisht: unknown finish `polisht`; expected one of none, polished, rough, lambert, surface, material, gauss, cos_m, abg, measured, mirror, polariser, reflective_polariser, retarder, grating, circular_polariser, absorber; did you mean `polished`?",
    ),
];
