//! Colours of lamps, skies and slides arrive as spectra and as RGB, their luminance as it was.

use super::{BASE, built_on, fault};
use crate::testing::assembly;
use crate::{Assembly, Built, build, toml};
use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};
use eyebox_base::Where;
use eyebox_base::colour::luminance;
use eyebox_scene::assembly::{LightForm, LightSource};
use eyebox_scene::{Led, Photometry, Severity, Spectrum};
use std::path::Path;

const LAMP: &str = "[[bind]]\npath = \"LED_1\"\nemitter = { group = \"led\", flux_lm = 2, angular = \"lambert\"";

/// In colour.
fn visible() -> String {
    BASE.replace("{ mono_nm = 550 }", "\"visible\"")
}

fn built_in(folder: &Path, assembly: Assembly, text: &str) -> Result<Built, String> {
    let sidecar = toml::parse(text, &folder.join("hud.optics.toml")).unwrap();
    let folder = format!("{}/", folder.display());
    build(assembly, Some(&sidecar), &[]).map_err(|fault| fault.to_string().replace(&folder, ""))
}

fn spectrum(said: &str) -> Result<Option<Spectrum>, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("led.csv"), "nm,W\n500,1\n600,3\n").unwrap();
    std::fs::write(folder.path().join("bad.csv"), "500,1\n600,three\n").unwrap();
    let text = format!("{}{LAMP}{said} }}\n", visible());
    let built = built_in(folder.path(), assembly(&["LENS", "LED_1"]), &text)?;
    let read = built.scene.notes.iter().any(|note| note.text == "`spectrum` of emitter is not said: D65");
    assert_eq!(read, said.is_empty());
    Ok(built.scene.parts[1].faces[0].emitter.as_ref().unwrap().spectrum.clone())
}

#[test]
fn emitters_have_spectra() {
    let table = Spectrum::Table(vec![(500.0, 1.0), (600.0, 3.0)]);
    for (said, want) in [
        ("", None),
        (", spectrum = \"D65\"", Some(Spectrum::D65)),
        (", spectrum = \"A\"", Some(Spectrum::A)),
        (", spectrum = \"equal\"", Some(Spectrum::Equal)),
        (", spectrum = \"led_bh1\"", Some(Spectrum::Led(Led::Bh1))),
        (", spectrum = { cct = 3000 }", Some(Spectrum::Cct(3000.0))),
        (", spectrum = { rgb = [1, 0.5, 0] }", Some(Spectrum::Rgb([1.0, 0.5, 0.0]))),
        (", spectrum = { table = [[500, 1], [600, 3]] }", Some(table.clone())),
        (", spectrum = { csv = \"led.csv\" }", Some(table.clone())),
        (", spectrum = { kind = \"csv\", csv = \"led.csv\" }", Some(table)),
    ] {
        assert_eq!(spectrum(said).unwrap(), want, "{said}");
    }
    for (said, want) in [
        (", spectrum = \"led_b6\"", "hud.optics.toml:12: unknown spectrum `led_b6`; expected one of D65, A, equal"),
        (", spectrum = { cct = 500 }", "hud.optics.toml:12: `cct` is 500; expected a number from 1000 to 25000 in K"),
        (", spectrum = { rgb = [0, 0, 0] }", "hud.optics.toml:12: `spectrum`: the colour is black; expected power"),
        (", spectrum = { rgb = [1, -1, 0] }", "hud.optics.toml:12: `rgb` is -1; expected a number >= 0"),
        (
            ", spectrum = { table = [[900, 1], [950, 1]] }",
            "hud.optics.toml:12: `spectrum`: the spectrum has no visible",
        ),
        (", spectrum = { table = [[500, 1], [500, 1]] }", "hud.optics.toml:12: `spectrum`: the wavelengths of the"),
        (", spectrum = { csv = \"bad.csv\" }", "bad.csv:2: `600,three` is no line of a spectrum"),
        (
            ", spectrum = { csv = \"no.csv\" }",
            "hud.optics.toml:12: can't read the spectrum no.csv: there is no such file",
        ),
    ] {
        let got = spectrum(said).unwrap_err();
        assert!(got.starts_with(want), "{said}: {got}");
    }
    assert!(fault(&format!("{LAMP}, spectrum = \"led_b\" }}\n"), &[]).contains("did you mean `led_b"));
}

#[test]
fn every_led_of_the_vocabulary_is_one() {
    for kind in eyebox_scene::attribute::kinds("spectrum").filter(|kind| kind.name.starts_with("led_")) {
        assert!(Led::from_name(kind.name).is_some(), "{}", kind.name);
    }
    assert!(Led::ALL.iter().all(|led| eyebox_scene::attribute::kinds("spectrum").any(|kind| kind.name == led.name())));
}

fn light(form: LightForm, color: [f64; 3], kelvin: Option<f64>) -> LightSource {
    let own = luminance(color);
    let color = color.map(|lane| lane / own);
    let (name, at) = ("L".to_owned(), Where::Nowhere);
    LightSource { name, node: 0, form, color, kelvin, profile: None, attributes: None, at }
}

#[test]
fn lights_of_the_asset_keep_their_hue() {
    let with = |color, kelvin| {
        let mut asset = assembly(&["LENS"]);
        asset.lights.push(light(LightForm::Point { intensity_cd: 3.0, cone: None }, color, kelvin));
        asset.lights.push(light(LightForm::Disk { luminance_cd_m2: 7.0, radius: 1.0 }, color, kelvin));
        let scene = built_on(asset, &visible(), &[]).unwrap().scene;
        let face = scene.parts[1].faces[0].emitter.clone().unwrap();
        assert_eq!(face.photometry, Photometry::LuminanceCdM2(7.0));
        assert_eq!(face.spectrum, scene.lights[0].spectrum);
        face.spectrum
    };
    assert_eq!(with([0.3; 3], None), None);
    assert_eq!(with([1.0, 0.8, 0.5], Some(2700.0)), Some(Spectrum::Cct(2700.0)));
    let Some(Spectrum::Rgb(rgb)) = with([1.0, 0.5, 0.25], None) else { panic!() };
    assert!((rgb[0] / rgb[1] - 2.0).abs() < 1e-12 && (rgb[0] / rgb[2] - 4.0).abs() < 1e-12);
    let back = Spectrum::Rgb(rgb).resolve().unwrap().rec709_per_lumen();
    assert!(back.iter().zip(rgb).all(|(back, rgb)| (back - rgb).abs() < 1e-9), "{back:?}");
}

/// A folder with a coloured slide and a coloured panorama.
fn pictures() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let slide = image::RgbImage::from_raw(2, 1, vec![255, 0, 51, 102, 102, 102]).unwrap();
    slide.save(folder.path().join("slide.png")).unwrap();
    let sky = SpecificChannels::rgb(|Vec2(x, y)| (x as f32, 1.0, if y == 0 { -0.5 } else { 0.5 }));
    Image::from_channels((4, 2), sky).write().to_file(folder.path().join("sky.exr")).unwrap();
    folder
}

#[test]
fn slides_and_skies_keep_their_colours_where_colour_is_traced() {
    let folder = pictures();
    let text = "[sky]\nimage = \"sky.exr\"\nscale_cd_m2 = 10\n[[bind]]\npath = \"LCD\"\nfaces = [4]\n\
                slide = { image = \"slide.png\", size = [4, 2], u = [1, 0, 0], v = [0, 1, 0] }\n";
    let both = [visible(), BASE.to_owned()]
        .map(|base| built_in(folder.path(), assembly(&["LCD"]), &format!("{base}{text}")).unwrap().scene);
    let [colour, mono] = &both;
    for scene in &both {
        let sky = scene.sky.as_ref().unwrap();
        // Row 0 has a negative blue, whose luminance counts.
        for (i, want) in [(5, luminance([10.0, 10.0, 5.0])), (1, luminance([10.0, 10.0, -5.0]))] {
            assert!((f64::from(sky.luminance[i]) / want - 1.0).abs() < 1e-6, "{i}: {}", sky.luminance[i]);
        }
        let want = luminance([1.0, 0.0, 0.2]);
        assert!((f64::from(scene.slides[0].pixels[0]) / want - 1.0).abs() < 1e-6 && scene.slides[0].pixels[1] == 0.4);
    }
    let sky = colour.sky.as_ref().unwrap();
    let rgb = sky.rgb.as_ref().unwrap();
    assert_eq!(rgb[6], [20.0, 10.0, 5.0]);
    for (rgb, own) in rgb.iter().zip(sky.luminance.iter()) {
        assert!(rgb.iter().all(|lane| *lane >= 0.0));
        assert!((luminance(rgb.map(f64::from)) / f64::from(*own) - 1.0).abs() < 1e-6, "{rgb:?} {own}");
    }
    assert_eq!(colour.slides[0].rgb.as_ref().map(|rgb| rgb[0]), Some([1.0, 0.0, 0.2]));
    let clipped = |note: &eyebox_scene::Note| note.text.starts_with("4 pixels have colours outside Rec.709");
    assert!(colour.notes.iter().any(clipped) && !mono.notes.iter().any(clipped));
    assert!(mono.notes.iter().any(|note| note.text.contains("at one wavelength their luminance counts")));
    assert!(mono.sky.as_ref().unwrap().rgb.is_none() && mono.slides[0].rgb.is_none());
}

#[test]
fn a_tinted_dome_tints_its_picture() {
    let folder = pictures();
    let image = Some(folder.path().join("sky.exr"));
    let tinted = |image, color: [f64; 3]| {
        let mut asset = assembly(&["LENS"]);
        asset.lights.push(light(LightForm::Dome { scale_cd_m2: 4.0, image }, color, None));
        built_on(asset, &visible(), &[]).unwrap().scene.sky.unwrap()
    };
    // A uniform dome has the strength's luminance and the colour's hue.
    let sky = tinted(None, [1.0, 0.5, 0.5]);
    let [r, g, b] = sky.rgb.as_ref().unwrap()[0];
    assert!((sky.luminance[0] - 4.0).abs() < 1e-6 && (r / g - 2.0).abs() < 1e-6 && g == b);
    assert!(tinted(None, [0.2; 3]).rgb.is_none());
    assert_eq!(tinted(None, [0.2; 3]).luminance[0], 4.0);
    // A picture is multiplied lane by lane: a red dome shows what is red.
    let red = 4.0 / luminance([1.0, 0.0, 0.0]);
    let sky = tinted(image, [1.0, 0.0, 0.0]);
    let rgb = sky.rgb.as_ref().unwrap()[6];
    assert!((f64::from(rgb[0]) / (2.0 * red) - 1.0).abs() < 1e-6 && rgb[1..] == [0.0, 0.0], "{rgb:?}");
    assert!((f64::from(sky.luminance[6]) / 8.0 - 1.0).abs() < 1e-6);
}

/// An asset is looked at without its dome's picture, as without those of its materials; a broken one stays an error.
#[test]
fn a_dome_without_its_picture_lights_evenly() {
    let folder = pictures();
    let domed = |name: &str| {
        let mut asset = assembly(&["LENS"]);
        let image = Some(folder.path().join(name));
        asset.lights.push(light(LightForm::Dome { scale_cd_m2: 4.0, image }, [1.0, 0.5, 0.5], None));
        built_on(asset, &visible(), &[])
    };
    let built = domed("lost.hdr").unwrap();
    let warned = |note: &&eyebox_scene::Note| note.severity == Severity::Warning && note.text.contains("lost.hdr");
    let note = built.scene.notes.iter().find(warned).unwrap();
    assert!(note.text.contains("no such file") && note.text.contains("lights evenly"), "{}", note.text);
    let sky = built.scene.sky.unwrap();
    assert!((sky.luminance[0] - 4.0).abs() < 1e-6 && sky.luminance.len() == 1);
    std::fs::write(folder.path().join("broken.hdr"), b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X 9\n").unwrap();
    assert!(domed("broken.hdr").is_err());
}

#[test]
fn glasses_beyond_their_range_are_warned_of_once() {
    let text = "[[bind]]\npath = \"LED_*\"\nglass = \"PMMA\"\n[[bind]]\npath = \"LENS\"\nglass = \"N-SF6\"\nfinish = \"polished\"\n\
                coating = { stack = [{ material = \"TiO2\", thickness_nm = 10 }, { material = \"PMMA_Beadie\", thickness_nm = 9 }] }\n";
    let warned = |base: &str| {
        let built = built_on(assembly(&["LENS", "LED_1", "LED_2"]), &format!("{base}{text}"), &[]).unwrap();
        let mut all: Vec<String> = built
            .scene
            .notes
            .into_iter()
            .filter(|note| note.severity == Severity::Warning && note.text.contains("extrapolated"))
            .map(|note| format!("{}: {}", note.at, note.text))
            .collect();
        all.sort();
        all
    };
    assert_eq!(
        warned(&visible()),
        [
            "hud.optics.toml:12: PMMA: its index is known from 436.8 to 1052 nm and extrapolated for 400 to 700 nm",
            "hud.optics.toml:17: PMMA_Beadie: its index is known from 420 to 1620 nm and extrapolated for 400 to 700 nm",
        ]
    );
    assert!(warned(BASE).is_empty());
    assert_eq!(warned(&BASE.replace("550", "430")).len(), 1);
}

/// A picture of 64 × 64 texels of 4 bytes that the sidecar alone names, in memory for 4 KiB.
#[test]
fn pictures_of_the_sidecar_count_for_the_memory_of_textures() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbaImage::new(64, 64).save(folder.path().join("paint.png")).unwrap();
    let text = format!(
        "{BASE}[[bind]]\npath = \"LCD\"\nfinish = {{ kind = \"surface\", base_color_texture = \"paint.png\" }}\n"
    );
    let sidecar = toml::parse(&text, &folder.path().join("a.optics.toml")).unwrap();
    let read = |bytes| {
        let scene = crate::build::build_within(assembly(&["LCD"]), Some(&sidecar), &[], bytes).unwrap().scene;
        let size = scene.surfaces[0].base_color.texture.as_ref().map(|input| input.texture.width);
        (size, scene.notes.iter().any(|note| note.text.contains("`--texture-memory` allows more")))
    };
    assert_eq!((read(1 << 14), read(1 << 12)), ((Some(64), false), (Some(32), true)));
}

/// Skies that say what their values are: 500 at EXPOSURE=5 in a Radiance picture, 2 at a `whiteLuminance` of 50 in an EXR, unless
/// the sidecar says it. A cube map is none of latitudes and longitudes.
#[test]
fn calibrated_skies() {
    use exr::prelude::{Encoding, Layer, LayerAttributes, attribute::EnvironmentMap};
    let folder = tempfile::tempdir().unwrap();
    let hdr = b"#?RGBE\r\nEXPOSURE=5\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 2\r\n\xfa\xfa\xfa\x89\xfa\xfa\xfa\x89";
    std::fs::write(folder.path().join("sky.hdr"), hdr).unwrap();
    let write = |name: &str, envmap| {
        let values = exr::prelude::FlatSamples::F32(vec![2.0; 2]);
        let channels =
            exr::prelude::AnyChannels::sort(std::iter::once(exr::prelude::AnyChannel::new("Y", values)).collect());
        let own =
            LayerAttributes { white_luminance: Some(50.0), environment_map: envmap, ..LayerAttributes::default() };
        let image = Image::from_layer(Layer::new((2, 1), own, Encoding::UNCOMPRESSED, channels));
        image.write().to_file(folder.path().join(name)).unwrap();
    };
    write("sky.exr", Some(EnvironmentMap::LatitudeLongitude));
    write("cube.exr", Some(EnvironmentMap::Cube));
    let built = |sky: &str| built_in(folder.path(), assembly(&["LENS"]), &format!("{}[sky]\n{sky}\n", visible()));
    for (sky, want) in [
        ("image = \"sky.hdr\"", 100.0),
        ("image = \"sky.hdr\"\nscale_cd_m2 = 3", 300.0),
        ("image = \"sky.exr\"", 100.0),
        ("image = \"sky.exr\"\nscale_cd_m2 = 3", 6.0),
    ] {
        let scene = built(sky).unwrap().scene;
        assert_eq!(scene.sky.as_ref().map(|sky| sky.luminance[0]), Some(want), "{sky}");
        let says =
            scene.notes.iter().any(|note| note.text.contains("EXPOSURE") || note.text.contains("whiteLuminance"));
        assert_eq!(says, sky != "image = \"sky.exr\"\nscale_cd_m2 = 3", "{sky}");
    }
    assert!(built("image = \"cube.exr\"").unwrap_err().contains("it is a cube map by its `envmap`"));
}
