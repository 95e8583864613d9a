//! Every class of fault with its whole message: place, what, what was expected, nearest name.

use super::{BASE, built_on, check};
use crate::testing::assembly;

#[test]
fn selectors_that_select_nothing_or_too_much() {
    check(&[
        (
            "[[bind]]\npath = \"LENZ\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:11: path `LENZ` matches no part; did you mean `LENS`?",
        ),
        (
            "[[bind]]\npath = \"ROOT/LED_*/*\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:11: path `ROOT/LED_*/*` matches no part; did you mean `ROOT/LED_2`?",
        ),
        (
            "[[bind]]\npath = \"ROOT\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:11: path `ROOT` is a node without geometry; expected a part; `ROOT/**` selects the parts below it",
        ),
        (
            "[[bind]]\nname = \"LED_3\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:11: name `LED_3` matches no part; did you mean `LED_2`?",
        ),
        (
            "[[bind]]\nmesh = \"LED_3\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:11: mesh `LED_3` matches no part; did you mean `LED_2`?",
        ),
        (
            "[[bind]]\nmaterial = \"GLAS\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:10: no face of the selected parts has material `GLAS`; did you mean `GLASS`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nname = \"LCD\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:10: no part matches both `path` and `name`",
        ),
        (
            "[[bind]]\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:10: this `[[bind]]` selects no parts; expected `path`, `name`, `material` or `mesh`; what holds for all parts goes to [default]",
        ),
        (
            "[[bind]]\npath = \"LENS\"\n",
            &[],
            "hud.optics.toml:10: this `[[bind]]` says nothing about its parts; expected one of medium, ior, glass, sellmeier, cauchy, abbe, index_table, absorption_per_m, priority, finish, coating, shape, emitter, slide, sensor",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfaces = [0, 6]\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:12: part ROOT/LENS has no face 6; expected a face from 0 to 5",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfaces = [0.5]\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:12: `faces` is a list ([0.5]); expected a list of face numbers, e.g. [0, 2]",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfaces = 0\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:12: `faces` is a number (0); expected a list of face numbers, e.g. [0, 2]",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nnormal = \"up\"\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:12: `normal` is \"up\"; expected one of \"+x\", \"-x\", \"+y\", \"-y\", \"+z\", \"-z\", in the part's local axes",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nnormal = \"+z\"\nfaces = [5]\nfinish = \"polished\"\n",
            &[],
            "hud.optics.toml:12: both `faces` and `normal`; expected one of them",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfaces = [5]\nglass = \"PMMA\"\n",
            &[],
            "hud.optics.toml:13: `glass` fills a whole part, not some of its faces; expected a [[bind]] of its own without `faces` and `normal`",
        ),
    ]);
}

#[test]
fn unknown_keys_and_names() {
    check(&[
        (
            "[binds]\nx = 1\n",
            &[],
            "hud.optics.toml:10: unknown key `binds` of a sidecar; expected one of schema, asset, unit, wavelengths, default, coating, medium, bind, sky, sun, eye; did you mean `bind`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinsh = \"polished\"\n",
            &[],
            "hud.optics.toml:12: unknown attribute `finsh` in `[[bind]]`; expected one of path, name, material, mesh, faces, normal, medium, ior, glass, sellmeier, cauchy, abbe, index_table, absorption_per_m, priority, finish, coating, shape, emitter, slide, sensor; did you mean `finish`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polisht\"\n",
            &[],
            "hud.optics.toml:12: unknown finish `polisht`; expected one of none, polished, rough, lambert, surface, material, gauss, cos_m, abg, measured, mirror, polariser, reflective_polariser, retarder, grating, circular_polariser, absorber; did you mean `polished`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"lambert\", reflectence = 0.5 }\n",
            &[],
            "hud.optics.toml:12: unknown attribute `reflectence` of finish `lambert`; expected one of reflectance, transmittance, color, color_texture, texture_set, texture_scale; did you mean `reflectance`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"polished\", reflectance = 0.5 }\n",
            &[],
            "hud.optics.toml:12: finish `polished` takes no `reflectance`",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { reflectance = 0.5 }\n",
            &[],
            "hud.optics.toml:12: finish { reflectance = 0.5 } has no kind; expected one of none, polished, rough, lambert, surface, material, gauss, cos_m, abg, measured, mirror, polariser, reflective_polariser, retarder, grating, circular_polariser, absorber",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { lambert = { reflectance = 0.5 }, gauss = { sigma_deg = 1 } }\n",
            &[],
            "hud.optics.toml:12: finish is both `lambert` and `gauss`; expected one of them",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = 3\n",
            &[],
            "hud.optics.toml:12: finish is a number (3); expected one of none, polished, rough, lambert, surface, material, gauss, cos_m, abg, measured, mirror, polariser, reflective_polariser, retarder, grating, circular_polariser, absorber",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = \"arr\"\n[coating.ar]\nstack = [{ n = 1.38, thickness_nm = 99.638 }]\n",
            &[],
            "hud.optics.toml:13: unknown coating `arr`; expected one of ar, none; did you mean `ar`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nglass = \"N-BK8\"\n",
            &[],
            "hud.optics.toml:12: unknown glass `N-BK8`; expected a name of the catalogue; did you mean `N-BK7`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nmedium = \"glas\"\n[medium.glass]\nior = 1.5\n",
            &[],
            "hud.optics.toml:12: unknown medium `glas`; expected the name of a [medium.NAME], or \"none\"; a catalogue glass is `glass = …`; did you mean `glass`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { group = \"led\", flux_lum = 0.45 }\n",
            &[],
            "hud.optics.toml:12: unknown attribute `flux_lum` of emitter; expected one of name, group, flux_lm, luminance_cd_m2, primaries_cd_m2, intensity_cd, illuminance_lx, radiant_flux_w, angular, sides, spectrum, u, polarisation, image, layer, size, v, centre, contrast; did you mean `flux_lm`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"sfere\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5 }\n",
            &[],
            "hud.optics.toml:12: unknown shape `sfere`; expected one of mesh, plane, sphere, conic, asphere, cylinder, toroid, xy_poly, zernike, bspline, fit; did you mean `sphere`?",
        ),
        (
            "[sky]\nimage = \"x.exr\"\nscale = 3\n",
            &[],
            "hud.optics.toml:12: unknown attribute `scale` of sky; expected one of image, layer, scale_cd_m2, rotation_deg, luminance_cd_m2, rgb, overcast_cd_m2, sun_sky, ground_reflectance, group, up, frame; did you mean `scale_cd_m2`?",
        ),
    ]);
}

#[test]
fn numbers_out_of_range_and_wrong_forms() {
    check(&[
        ("[[bind]]\npath = \"LENS\"\nior = 0.9\n", &[], "hud.optics.toml:12: `ior` is 0.9; expected a number >= 1"),
        ("[[bind]]\npath = \"LENS\"\nior = nan\n", &[], "hud.optics.toml:12: `ior` is NaN; expected a number >= 1"),
        (
            "[[bind]]\npath = \"LENS\"\nior = \"1.5\"\n",
            &[],
            "hud.optics.toml:12: `ior` is a text (\"1.5\"); expected a number >= 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\ncauchy = [0.5]\n",
            &[],
            "hud.optics.toml:12: impossible index: `cauchy` gives n = 0.5 at 550 nm; expected n from 1 to 10 and k >= 0",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nindex_table = [[500, 1.5, 0], [500, 1.6, 0]]\n",
            &[],
            "hud.optics.toml:12: `index_table`: the wavelengths of the index table do not rise after row 0; expected [[λ in nm, n, k], …] with rising λ, linear between the rows; k >= 0 absorbs",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nior = 1.5\nabsorption_per_m = [[600, 1], [700, 1]]\n",
            &[],
            "hud.optics.toml:13: `absorption_per_m` does not cover 550 nm; expected rows on both sides of it",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nior = 1.5\npriority = 0.5\n",
            &[],
            "hud.optics.toml:13: `priority` is a number (0.5); expected a whole number",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nsellmeier = { b = [1.0], C = [0.01] }\n",
            &[],
            "hud.optics.toml:12: unknown attribute `C` of sellmeier; expected b and c_um2; did you mean `c_um2`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"lambert\", reflectance = 0.5, transmittance = 0.6 }\n",
            &[],
            "hud.optics.toml:12: reflectance 0.5 + transmittance 0.6 is above 1; expected shares that together are at most 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"reflective_polariser\", axis = [1, 0, 0], reflectance = 0.9, transmittance_leak = 0.2 }\n",
            &[],
            "hud.optics.toml:12: reflectance 0.9 + transmittance_leak 0.2 is above 1; expected shares of one polarisation that together are at most 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"grating\", direction = [0, 1, 0], lines_per_mm = 500, rest = \"absorbed\", orders = [{ order = 1, T = 0.75 }, { order = -1, R = 0.5 }] }\n",
            &[],
            "hud.optics.toml:12: the orders of a grating have 1.25 of the light; expected shares that together are at most 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"circular_polariser\", axis = [1, 0, 0], handedness = \"rigth\" }\n",
            &[],
            "hud.optics.toml:12: `handedness` is \"rigth\"; expected \"left\" or \"right\"; did you mean `right`?",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"retarder\", axis = [1, 0, 0], retardance_nm = 100, retardance_waves = 0.25 }\n",
            &[],
            "hud.optics.toml:12: a wave plate has one retardance; expected `retardance_nm` or `retardance_waves`",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"gauss\", sigma_deg = 0, transmittance = 0.9 }\n",
            &[],
            "hud.optics.toml:12: `sigma_deg` is 0; expected a number above 0 and up to 90 in deg",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"gauss\", transmittance = 0.9 }\n",
            &[],
            "hud.optics.toml:12: finish `gauss` has no `sigma_deg`; expected a number above 0 and up to 90 in deg",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"mirror\", n = 1.2 }\n",
            &[],
            "hud.optics.toml:12: a mirror is a metal or a reflectance; expected both `n` and `k`, or `reflectance` alone",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { stack = [{ n = 1.38, thickness_nm = -1 }] }\n",
            &[],
            "hud.optics.toml:13: `thickness_nm` is -1; expected a number >= 0 in nm",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { stack = [] }\n",
            &[],
            "hud.optics.toml:13: `stack` is empty; expected at least one film, or coating = \"none\"",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { stack = [{ n = 1.38, material = \"PMMA\", thickness_nm = 1 }] }\n",
            &[],
            "hud.optics.toml:13: a film has an index or is of a material; expected `n` (with `k` if it absorbs), or `material`",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { group = \"led\" }\n",
            &[],
            "hud.optics.toml:12: the emitter has no strength; expected one of flux_lm, luminance_cd_m2, primaries_cd_m2, intensity_cd, radiant_flux_w",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { group = \"led\", flux_lm = -1 }\n",
            &[],
            "hud.optics.toml:12: `flux_lm` is -1; expected a number from 0 to 1e12 in lm",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { group = \"led\", flux_lm = 1, intensity_cd = 1 }\n",
            &[],
            "hud.optics.toml:12: the emitter has flux_lm and intensity_cd; expected one of flux_lm, luminance_cd_m2, primaries_cd_m2, intensity_cd, radiant_flux_w",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { primaries_cd_m2 = [1, 2, 1], luminance_cd_m2 = 4 }\n",
            &[],
            "hud.optics.toml:12: the emitter has luminance_cd_m2 and primaries_cd_m2; expected one of flux_lm, luminance_cd_m2, primaries_cd_m2, intensity_cd, radiant_flux_w",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { primaries_cd_m2 = [1, 2, 1], spectrum = \"A\" }\n",
            &[],
            "hud.optics.toml:12: the emitter has primaries_cd_m2 and spectrum; expected one of them: the primaries say the colour of white",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { luminance_cd_m2 = 4, contrast = 100 }\n",
            &[],
            "hud.optics.toml:12: `contrast` of emitter is that of a picture, and there is none; expected image = \"FILE\" beside it",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { luminance_cd_m2 = 4, image = \"a.png\", u = [1, 0, 0], v = [1, 1, 0], size = [1, 1] }\n",
            &[],
            "hud.optics.toml:12: `u` and `v` of emitter are not orthogonal; expected a right angle; it is 45.000°",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { luminance_cd_m2 = 4, image = \"a.png\", u = [1, 0, 0], v = [0, 1, 0], size = [1, 1] }\nslide = { image = \"a.png\", u = [1, 0, 0], v = [0, 1, 0], size = [1, 1] }\n",
            &[],
            "hud.optics.toml:13: part ROOT/LENS face 0 has a slide and an emitter with an image; expected one of them: a display's picture is said by its emitter or by a slide on its face",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nemitter = { group = \"1-led\", flux_lm = 1 }\n",
            &[],
            "hud.optics.toml:12: group `1-led` can't be part of a layer name; expected letters, digits and _, a letter first",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"sphere\", vertex = [0, 0, 0], axis = [0, 0, 0], radius = 5 }\n",
            &[],
            "hud.optics.toml:12: `axis` of shape `sphere` is the zero vector; expected a direction",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"sphere\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 0 }\n",
            &[],
            "hud.optics.toml:12: `radius` is 0; expected a finite number other than 0 in mesh units",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"sphere\", vertex = [0, 0], axis = [0, 0, 1], radius = 1 }\n",
            &[],
            "hud.optics.toml:12: `vertex` is a list ([0, 0]); expected a list of 3 numbers in mesh units",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"fit\" }\n",
            &[],
            "hud.optics.toml:12: shape `fit` has no `tolerance_um`; expected a number > 0 in µm",
        ),
    ]);
}

#[test]
fn shapes_out_of_range() {
    check(&[
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"asphere\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5, conic = 0 }\n",
            &[],
            "hud.optics.toml:12: shape `asphere` has no `even`; expected heights of r², r⁴, r⁶, … that are added to the conic's",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"asphere\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5, conic = 0, even = [] }\n",
            &[],
            "hud.optics.toml:12: `even` has 0 numbers; expected 1 to 32 numbers",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"asphere\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5, conic = 0, even = [nan] }\n",
            &[],
            "hud.optics.toml:12: `even` is NaN; expected a finite number in mesh units",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"cylinder\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 0 }\n",
            &[],
            "hud.optics.toml:12: `radius` is 0; expected a finite number other than 0 in mesh units",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"cylinder\", vertex = [0, 0, 0], axis = [0, 0, 1], x = [0, 0, -3], radius = 5 }\n",
            &[],
            "hud.optics.toml:12: `x` of shape is along its axis; expected a direction across the axis",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"toroid\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5, tube_radius = 0 }\n",
            &[],
            "hud.optics.toml:12: `tube_radius` is 0; expected a finite number other than 0 in mesh units",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"xy_poly\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5, conic = 0, even = [1] }\n",
            &[],
            "hud.optics.toml:12: unknown attribute `even` of shape `xy_poly`; expected one of vertex, axis, x, radius, conic, coeffs",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"zernike\", vertex = [0, 0, 0], axis = [0, 0, 1], radius = 5, conic = 0, norm_radius = 0, coeffs = [1] }\n",
            &[],
            "hud.optics.toml:12: `norm_radius` is 0; expected a number > 0 in mesh units",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nshape = { kind = \"fit\", surface = \"cylindre\", tolerance_um = 1 }\n",
            &[],
            "hud.optics.toml:12: can't fit the surface `cylindre`; expected one of plane, sphere, cylinder, conic, toroid, asphere, xy_poly, zernike, bspline; did you mean `cylinder`?",
        ),
    ]);
}

#[test]
fn scatter_and_coatings() {
    check(&[
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { kind = \"rough\", alpha = 0 }\n",
            &[],
            "hud.optics.toml:12: `alpha` is 0; expected a number from 0.0001 to 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = { measured = { file = \"x.csv\" } }\n",
            &[],
            "hud.optics.toml:12: can't read the measured scattering x.csv: there is no such file",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { ideal = { R = 0.5, T = 0.75 } }\n",
            &[],
            "hud.optics.toml:13: R 0.5 + T 0.75 of an ideal coating is above 1; expected shares that together are at most 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { table = [] }\n",
            &[],
            "hud.optics.toml:13: `table` is a list ([]); expected a list of { wavelength_nm, angle_deg, R_s, R_p, T_s, T_p }",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { table = [{ wavelength_nm = 550, angle_deg = 0, R_s = 0.5, R_p = 0.5, T_s = 0.5, T_p = 0.75 }] }\n",
            &[],
            "hud.optics.toml:13: R_p + T_p is 1.25 in line 0 of `table`; expected at most 1",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\ncoating = { table = [{ wavelength_nm = 550, angle_deg = 0, R_s = 0.5, R_p = 0.5, side = \"inside\" }] }\n",
            &[],
            "hud.optics.toml:13: `table` of a coating, outside: 0 lines do not fill a grid of 0 wavelengths × 0 angles; expected one line for every pair of a wavelength and an angle",
        ),
    ]);
}

#[test]
fn a_pupil_is_a_length_or_a_word() {
    check(&[(
        "",
        &["eye.pupil_diameter=wide"],
        "--set eye.pupil_diameter=wide: `pupil_diameter`: `wide` is not a length; write a number and a unit, e.g. `4 mm`; expected a length with its unit, e.g. \"4 mm\", or \"auto\"",
    )]);
}

#[test]
fn contradictions() {
    check(&[
        (
            "[[bind]]\npath = \"LENS\"\nior = 1.5\nglass = \"PMMA\"\n",
            &[],
            "hud.optics.toml:13: `[[bind]]` gives both `ior` and `glass`; expected one of them",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"polished\"\n[[bind]]\npath = \"LENS\"\nfinish = \"absorber\"\n",
            &[],
            "hud.optics.toml:15: `finish` of part ROOT/LENS face 0 is bound twice with the same precedence: \"polished\" (hud.optics.toml:12) and \"absorber\"; expected one of them, or a more specific selector for one",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nglass = \"PMMA\"\n[[bind]]\npath = \"LENS\"\nior = 1.5\n",
            &[],
            "hud.optics.toml:15: `glass` of part ROOT/LENS is bound twice with the same precedence: \"PMMA\" (hud.optics.toml:12) and `ior` 1.5; expected one of them, or a more specific selector for one",
        ),
        (
            "[[bind]]\npath = \"LED_*\"\nfinish = \"polished\"\n[[bind]]\npath = \"*_1\"\nfinish = \"none\"\n",
            &[],
            "hud.optics.toml:15: `finish` of part ROOT/LED_1 face 0 is bound twice with the same precedence: \"polished\" (hud.optics.toml:12) and \"none\"; expected one of them, or a more specific selector for one",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"absorber\"\ncoating = { stack = [{ n = 1.38, thickness_nm = 1 }] }\n",
            &[],
            "hud.optics.toml:13: a coating acts on polished faces; part ROOT/LENS face 0 is not; expected finish = \"polished\" there, or no coating",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nmedium = \"x\"\n[medium.x]\npriority = 1\n",
            &[],
            "hud.optics.toml:13: this medium has no index; expected one of ior, glass, sellmeier, cauchy, abbe, index_table",
        ),
    ]);
}

#[test]
fn slides_and_skies() {
    check(&[
        (
            "[[bind]]\npath = \"LCD\"\nnormal = \"-z\"\nslide = { image = \"no.png\", size = [4, 2], u = [1, 0, 0], v = [0, 1, 0] }\n",
            &[],
            "hud.optics.toml:13: can't read the slide image no.png: there is no such file",
        ),
        (
            "[[bind]]\npath = \"LCD\"\nnormal = \"-z\"\nslide = { image = \"no.png\", size = [4, 2], u = [1, 0, 0] }\n",
            &[],
            "hud.optics.toml:13: slide has no `v`; expected a list of 3 numbers",
        ),
        (
            "[[bind]]\npath = \"LCD\"\nnormal = \"-z\"\nslide = { image = \"no.png\", size = [4, 0], u = [1, 0, 0], v = [0, 1, 0] }\n",
            &[],
            "hud.optics.toml:13: `size` is 0; expected a number > 0 in mesh units",
        ),
        (
            "[[bind]]\npath = \"LCD\"\nnormal = \"-z\"\nslide = { image = \"no.png\", size = [4, 2], u = [1, 0, 0], v = [0.1, 1, 0] }\n",
            &[],
            "hud.optics.toml:13: `u` and `v` of slide are not orthogonal; expected a right angle; it is 84.289°",
        ),
        (
            "[[bind]]\npath = \"LCD\"\nnormal = \"-z\"\nslide = { image = \"no.png\", size = [4, 2], u = [1, 0, 0], v = [0, 1, 0], contrast = 0.5 }\n",
            &[],
            "hud.optics.toml:13: `contrast` is 0.5; expected a number >= 1, or inf",
        ),
        (
            "[sky]\nimage = \"no.exr\"\n",
            &[],
            "hud.optics.toml:11: can't read the sky image no.exr: there is no such file",
        ),
        (
            "[sky]\nimage = \"no.exr\"\nscale_cd_m2 = -1\n",
            &[],
            "hud.optics.toml:12: `scale_cd_m2` is -1; expected a number from 0 to 1e15 in cd/m²",
        ),
    ]);
}

/// Whole sidecars: eyes, versions, uncovered parts.
#[test]
fn sidecars_as_a_whole() {
    let eye = |change: (&str, &str)| BASE.replacen(change.0, change.1, 1);
    let rows = [
        (("schema = 1", "schema = 2"), "hud.optics.toml:1: schema 2 is newer than this program; expected schema = 1"),
        (("schema = 1\n", ""), "hud.optics.toml:1: `schema` is missing; expected schema = 1"),
        (
            ("mono_nm = 550", "mono_nm = 5500"),
            "hud.optics.toml:2: `mono_nm` is 5500; expected a number from 360 to 830 in nm",
        ),
        (
            ("{ mono_nm = 550 }", "\"visable\""),
            "hud.optics.toml:2: unknown wavelengths `visable`; expected one of mono_nm, visible; did you mean `visible`?",
        ),
        (("schema = 1", "schema = 1\nunit = 0"), "hud.optics.toml:2: `unit` is 0; expected a number > 0 in m"),
        (("[0, 0, -1]", "[0, 0, 0]"), "hud.optics.toml:5: `look` of eye is the zero vector; expected a direction"),
        (
            ("up = [0, 1, 0]", "up = [0, 1, 1]"),
            "hud.optics.toml:6: `up` of eye is not orthogonal to `look`; expected a right angle, e.g. up = [0.000000, 1.000000, 0.000000]",
        ),
        (
            ("fov_deg = 12\n", ""),
            "hud.optics.toml:3: eye has no `fov_deg`; expected the full horizontal field of view, a number above 0 and below 180 in deg",
        ),
        (
            ("fov_deg = 12", "fov_deg = 180"),
            "hud.optics.toml:7: `fov_deg` is 180; expected a number above 0 and below 180 in deg",
        ),
        (("look = [0, 0, -1]\n", ""), "hud.optics.toml:3: eye has no `look`; expected a list of 3 numbers"),
        (
            ("\"0 mm\", \"0 mm\", \"0 mm\"", "1, 2, 3"),
            "hud.optics.toml:4: `position` is 1 without a unit; expected a list of three lengths with their units, e.g. [\"0 mm\", \"0 mm\", \"120 mm\"]",
        ),
        (
            ("\"0 mm\", \"0 mm\", \"0 mm\"", "\"1 mn\", 0, 0"),
            "hud.optics.toml:4: `position`: unknown unit `mn` in `1 mn`; use nm, um, mm, cm, m, km or in; expected a list of three lengths with their units, e.g. [\"0 mm\", \"0 mm\", \"120 mm\"]",
        ),
        (
            ("fov_deg = 12", "fov_deg = 12\nframe = \"ROOD\""),
            "hud.optics.toml:8: frame `ROOD` is no node of the asset; expected \"asset\", or the name or path of a node; did you mean `ROOT`?",
        ),
        (
            ("fov_deg = 12", "fov_deg = 12\npupil_diameter = 4"),
            "hud.optics.toml:8: `pupil_diameter` is 4 without a unit; expected a length with its unit, e.g. \"4 mm\", or \"auto\"",
        ),
        (
            ("fov_deg = 12", "fov_deg = 12\npupil_diameter = \"-4 mm\""),
            "hud.optics.toml:8: `pupil_diameter` is \"-4 mm\"; expected a length with its unit: a number >= 0",
        ),
        (
            ("fov_deg = 12", "fov_deg = 12\nfocus_distance = \"0 m\""),
            "hud.optics.toml:8: `focus_distance` is \"0 m\"; expected a length with its unit: a number > 0, or inf",
        ),
        (
            ("fov_deg = 12", "fov_deg = 12\nresolution = [0.5, 10]"),
            "hud.optics.toml:8: `resolution` is 0.5; expected a number from 1 to 65536 in pixels",
        ),
        (
            ("fov_deg = 12", "fov_deg = 12\nresolution = [1.5, 10]"),
            "hud.optics.toml:8: `resolution` is 1.5 x 10; expected whole numbers of pixels",
        ),
        (
            ("finish = \"absorber\"", "priority = 0"),
            "a.glb: no optical attributes bind parts ROOT/LENS, ROOT/LED, ROOT/A, ROOT/B, ROOT/C and 1 more; expected a finish for every face: a [[bind]] or [default] finish = \"absorber\"",
        ),
        (
            ("[eye]", "[oculus]"),
            "hud.optics.toml:3: unknown key `oculus` of a sidecar; expected one of schema, asset, unit, wavelengths, default, coating, medium, bind, sky, sun, eye",
        ),
        (("schema = 1", "schema = 1\nbind = 3"), "hud.optics.toml:2: `bind` is a number; expected a list of tables"),
    ];
    let found = |change| {
        let text = eye(change);
        built_on(assembly(&["LENS", "LED", "A", "B", "C", "D"]), &text, &[])
            .map_or_else(|f| f.to_string(), |_| "no fault".into())
    };
    let wrong: Vec<String> = rows
        .into_iter()
        .filter(|(change, expected)| found(*change) != *expected)
        .map(|(change, expected)| format!("{change:?}\n  expected {expected}\n  found    {}", found(change)))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn parameters_beside_their_attribute_are_told_where_they_belong() {
    let lamp = |rest: &str| format!("[[bind]]\npath = \"LED_1\"\nemitter = {{ flux_lm = 1, {rest} }}\n");
    let (gauss, cos_n) = (lamp("angular = \"gauss\", fwhm_deg = 20"), lamp("angular = \"cos_n\", n = 4"));
    check(&[
        (
            &gauss,
            &[],
            "hud.optics.toml:12: `fwhm_deg` stands in emitter: it is a parameter of angular; expected angular = { kind = \"gauss\", fwhm_deg = … }",
        ),
        (
            &cos_n,
            &[],
            "hud.optics.toml:12: `n` stands in emitter: it is a parameter of angular; expected angular = { kind = \"cos_n\", n = … }",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nfinish = \"gauss\"\nsigma_deg = 6\n",
            &[],
            "hud.optics.toml:13: `sigma_deg` stands in `[[bind]]`: it is a parameter of finish; expected finish = { kind = \"gauss\", sigma_deg = … }",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nradius = 6\n",
            &[],
            "hud.optics.toml:12: `radius` stands in `[[bind]]`: it is a parameter of shape; expected shape = { kind = \"sphere\", radius = … }",
        ),
    ]);
}

#[test]
fn a_cell_of_a_table_is_named_with_its_own_unit() {
    check(&[
        (
            "[[bind]]\npath = \"LENS\"\nindex_table = [[500, 1.5, 0], [600, 1.5, -0.1]]\n",
            &[],
            "hud.optics.toml:12: k is -0.1 in row 1 of `index_table`; expected a number >= 0",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nindex_table = [[-500, 1.5, 0]]\n",
            &[],
            "hud.optics.toml:12: λ is -500 in row 0 of `index_table`; expected a number > 0 in nm",
        ),
        (
            "[[bind]]\npath = \"LENS\"\nior = 1.5\nabsorption_per_m = [[500, -1]]\n",
            &[],
            "hud.optics.toml:13: absorption is -1 in row 0 of `absorption_per_m`; expected a number >= 0 in 1/m",
        ),
    ]);
}

#[test]
fn an_up_along_look_gets_a_direction_that_can_be_used() {
    for (look, up) in [("[0, 0, -1]", "[0, 0, 1]"), ("[1, 1, 1]", "[2, 2, 2.0000001]"), ("[0, 1, 0]", "[0, 1, 0]")] {
        let text = |up: &str| {
            let base = BASE.replace("look = [0, 0, -1]", &format!("look = {look}"));
            base.replace("up = [0, 1, 0]\nfov", &format!("up = {up}\nfov"))
        };
        let fault = built_on(assembly(&["LENS"]), &text(up), &[]).unwrap_err().to_string();
        let (said, advice) = fault.split_once("e.g. up = ").expect("an example");
        assert!(said.contains("`up` of eye is parallel to `look`"), "{fault}");
        assert!(built_on(assembly(&["LENS"]), &text(advice), &[]).is_ok(), "{fault}");
    }
}

/// KHR_materials_ior allows any index from 1 up: it is refused where light gets into the part, and there alone.
#[test]
fn an_index_that_no_light_asks_for_may_be_impossible() {
    let ior = |finish: &str| super::built(&format!("[[bind]]\npath = \"LENS\"\nior = 1000\nfinish = {finish}\n"), &[]);
    for finish in
        ["\"absorber\"", "{ kind = \"lambert\", reflectance = 0.5 }", "{ kind = \"mirror\", reflectance = 0.9 }"]
    {
        let built = ior(finish).unwrap_or_else(|fault| panic!("{finish}: {fault}"));
        assert!(built.scene.parts.iter().all(|part| part.medium.is_none()), "{finish}");
        let said: Vec<_> =
            built.scene.notes.iter().filter(|note| note.text.contains("n = 1000 at 550 nm: not used")).collect();
        assert_eq!(said.len(), 1, "{finish}");
    }
    for finish in ["\"polished\"", "{ kind = \"lambert\", reflectance = 0.5, transmittance = 0.1 }"] {
        assert!(ior(finish).is_err_and(|fault| fault.to_string().contains("impossible index")), "{finish}");
    }
}

/// KHR_materials_transmission without a volume: a thin wall, which looks as its material says.
#[test]
fn thin_walls_of_an_asset_let_light_through() {
    use crate::value::{Data, Value};
    let mut clear = assembly(&["LENS"]);
    let one = Value::new(Data::Number(1.0), eyebox_base::Where::Nowhere);
    clear.materials[0].mapped.push(("transmission".to_owned(), one));
    let thin = built_on(clear.clone(), BASE, &[]).unwrap().scene;
    let finishes =
        |scene: &eyebox_scene::Scene| scene.parts[0].faces.iter().map(|face| face.finish).collect::<Vec<_>>();
    let look = eyebox_scene::Finish::Surface { surface: eyebox_base::ids::SurfaceId(0) };
    assert_eq!((finishes(&thin), thin.surfaces.len()), (vec![look; 6], 1));
    // With an index it is a solid.
    let solid = built_on(clear, &format!("{BASE}[[bind]]\npath = \"LENS\"\nior = 1.5\n"), &[]).unwrap().scene;
    assert_eq!(finishes(&solid), [eyebox_scene::Finish::Polished; 6]);
}
