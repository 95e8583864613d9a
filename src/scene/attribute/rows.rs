//! The rows themselves. Keep each on its lines: this is the vocabulary that people read.

use super::{Form, Kind, Noun, Range, Row, Support};
use Form::{
    Coefficients, File, Integer, Integers, Length, LengthOr, Number, NumberOrRows, Numbers, Place, Record, Records,
    Rows, Text, Thing, Word,
};
use Noun::{Asset, Coating, Emitter, Eye, Finish, Medium, Sensor, Shape, Sky, Slide, Sun};
use Range::{Above, Any, AtLeast, AtLeastOrInfinite, Between, NonZero, Positive, PositiveOrInfinite, Within};
use Support::Rendered;

#[rustfmt::skip]
const fn new(noun: Noun, name: &'static str, form: Form, unit: &'static str, range: Range, doc: &'static str) -> Row {
    Row { noun, name, form, unit, range, default: None, support: Rendered, doc }
}
impl Row {
    const fn or(mut self, default: &'static str) -> Self {
        self.default = Some(default);
        self
    }
}

/// Far above any lamp (lighthouses: 1e6 cd; the sun: 2e9 cd/m²), and far below where squares leave the range of f32.
const MOST_LIGHT: Range = Within(0.0, 1e12);
const MOST_LUMINANCE: Range = Within(0.0, 1e15);

/// The attributes of a medium's table, which a node may also have without the table around them.
pub const MEDIUM: [&str; 9] =
    ["name", "ior", "glass", "sellmeier", "cauchy", "abbe", "index_table", "absorption_per_m", "priority"];
/// The attributes of an emitter's table.
pub const EMITTER: [&str; 19] = [
    "name",
    "group",
    "flux_lm",
    "luminance_cd_m2",
    "primaries_cd_m2",
    "intensity_cd",
    "illuminance_lx",
    "radiant_flux_w",
    "sides",
    "angular",
    "spectrum",
    "u",
    "polarisation",
    "image",
    "layer",
    "size",
    "v",
    "centre",
    "contrast",
];
/// Those of them that say where a display's picture lies and what it is.
pub const PICTURE: [&str; 6] = ["image", "layer", "size", "v", "centre", "contrast"];
/// The attributes of a slide's table.
pub const SLIDE: [&str; 10] =
    ["name", "image", "layer", "size", "u", "v", "centre", "transmittance", "contrast", "polarisation"];
/// The parameters of an ordinary material.
const SURFACE: [&str; 40] = [
    "base_color",
    "base_color_texture",
    "diffuse_roughness",
    "diffuse_roughness_texture",
    "metallic",
    "metallic_texture",
    "roughness",
    "roughness_texture",
    "ior",
    "specular",
    "specular_texture",
    "specular_color",
    "specular_color_texture",
    "transmission",
    "transmission_texture",
    "diffuse_transmission",
    "diffuse_transmission_texture",
    "diffuse_transmission_color",
    "diffuse_transmission_color_texture",
    "anisotropy",
    "anisotropy_texture",
    "anisotropy_rotation_deg",
    "film",
    "film_texture",
    "film_ior",
    "film_thickness_nm",
    "coat",
    "coat_texture",
    "coat_roughness",
    "coat_roughness_texture",
    "sheen_color",
    "sheen_color_texture",
    "sheen_roughness",
    "sheen_roughness_texture",
    "normal_texture",
    "opacity",
    "opacity_texture",
    "opacity_cutoff",
    "texture_set",
    "texture_scale",
];
/// A film of a coating.
pub const FILM: [&str; 4] = ["n", "k", "material", "thickness_nm"];
/// An order of a grating.
pub const ORDER: [&str; 3] = ["order", "T", "R"];
/// A line of a measured coating.
pub const MEASURED: [&str; 7] = ["wavelength_nm", "angle_deg", "R_s", "R_p", "T_s", "T_p", "side"];

/// What a sky is made of, of which it has exactly one, and what goes with each beside what goes with all.
pub const SKIES: [(&str, &[&str]); 4] = [
    ("image", &["layer", "scale_cd_m2", "rotation_deg", "up", "frame"]),
    ("luminance_cd_m2", &["rgb"]),
    ("overcast_cd_m2", &["ground_reflectance", "up", "frame"]),
    ("sun_sky", &["ground_reflectance", "up", "frame"]),
];
/// The attributes of a clear sky with its sun.
pub const SUN_SKY: [&str; 4] = ["elevation_deg", "azimuth_deg", "turbidity", "sun_group"];

/// Every attribute.
#[rustfmt::skip]
pub const ROWS: &[Row] = &[
    // What fills a closed solid.
    new(Medium, "medium", Thing(&MEDIUM), "", Any, "name of a [medium.NAME], \"none\", or a table of medium attributes"),
    new(Medium, "name", Text, "", Any, "name of a medium of the asset"),
    new(Medium, "ior", Number, "", AtLeast(1.0), "constant refractive index"),
    new(Medium, "glass", Text, "", Any, "name of a glass (`eyebox glass` lists them), e.g. N-BK7, \"OHARA S-LAH79\", or vendor.agf#K8 of a catalogue file"),
    new(Medium, "sellmeier", Record(&["b", "c_um2"]), "", Any, "{ b = [B1, B2, B3], c_um2 = [C1, C2, C3] }: n² = 1 + Σ B λ²/(λ² − C), λ in µm"),
    new(Medium, "b", Coefficients { least: 1, most: 3 }, "", Any, "B of a Sellmeier formula; those left out are 0"),
    new(Medium, "c_um2", Coefficients { least: 1, most: 3 }, "µm²", Any, "C of a Sellmeier formula; those left out are 0"),
    new(Medium, "cauchy", Coefficients { least: 1, most: 3 }, "µm", Any, "[A, B, C]: n = A + B/λ² + C/λ⁴, λ in µm"),
    new(Medium, "abbe", Numbers(2), "", Positive, "[n_d, V_d]: index at 587.6 nm and Abbe number"),
    new(Medium, "index_table", Rows(&["λ in nm", "n", "k"]), "", AtLeast(0.0), "[[λ in nm, n, k], …] with rising λ, linear between the rows; k >= 0 absorbs"),
    new(Medium, "absorption_per_m", NumberOrRows(&["λ in nm", "1/m"]), "1/m", AtLeast(0.0), "a number >= 0 in 1/m, or [[λ in nm, 1/m], …] with rising λ: exp(−a·length)").or("0"),
    new(Medium, "priority", Integer, "", Any, "where solids overlap or touch, the higher priority wins, of equals the first in the asset, and its coating holds at the shared face; faces closer than 5e-5 of the smaller one's diameter touch").or("0"),
    // What a face does with light.
    new(Finish, "finish", Form::Kind, "", Any, "what the face does with light"),
    new(Finish, "alpha", Number, "", Within(1e-4, 1.0), "roughness of a microfacet surface: slope where its distribution, of Trowbridge and Reitz (GGX), has fallen to a quarter"),
    new(Finish, "reflectance", Number, "", Within(0.0, 1.0), "reflected share; of abg what stays specular").or("0"),
    new(Finish, "transmittance", Number, "", Within(0.0, 1.0), "transmitted share").or("0"),
    new(Finish, "sigma_deg", Number, "deg", Above(0.0, 90.0), "standard deviation of the lobe's angle"),
    new(Finish, "m", Number, "", Within(0.0, 1e8), "exponent of cosᵐ"),
    new(Finish, "a", Number, "1/sr", AtLeast(0.0), "A of A/(B + |β − β₀|^g), β the direction of scattered light projected on the face, β₀ that of the specular ray"),
    new(Finish, "b", Number, "", Positive, "B of that law"),
    new(Finish, "g", Number, "", AtLeast(0.0), "g of that law"),
    new(Finish, "other_file", File, "", Any, "the other side of what `file` has one side of, as Zemax' files do").or("none"),
    new(Finish, "file", File, "", Any, "measured scattering: a Zemax .bsdf, a matrix of WINDOW or Radiance (.xml), or lines of side (R or T), angle of incidence, leaving angle, azimuth (deg; 0 onwards in the plane of incidence) and 1/sr that fill a grid; linear between the angles, constant beyond them; both sides of the face scatter alike, and the mean of both directions of light is taken"),
    new(Finish, "n", Number, "", Positive, "real part of a metal's index"),
    new(Finish, "k", Number, "", AtLeast(0.0), "imaginary part of a metal's index"),
    new(Finish, "axis", Numbers(3), "mesh units", Any, "direction of polarisation along the face, not zero"),
    new(Finish, "extinction", Number, "", Within(0.0, 1.0), "share of the other polarisation that is let through").or("0"),
    new(Finish, "transmittance_leak", Number, "", Within(0.0, 1.0), "share of the polarisation across the axis, which is reflected, that is let through; with reflectance at most 1").or("0"),
    new(Finish, "reflectance_leak", Number, "", Within(0.0, 1.0), "share of the polarisation along the axis, which is let through, that is reflected; with transmittance at most 1").or("0"),
    new(Finish, "retardance_nm", NumberOrRows(&["λ in nm", "nm"]), "nm", Any, "path by which light polarised along the axis lags behind, straight on: a number, or [[λ in nm, nm], …] with rising λ, linear between the rows and constant beyond"),
    new(Finish, "retardance_waves", NumberOrRows(&["λ in nm", "waves"]), "waves", Any, "the same in wavelengths; a number holds at every wavelength (0.25: an achromatic quarter)"),
    new(Finish, "ordinary_index", Number, "", AtLeast(1.0), "with extraordinary_index: the retardance changes with the angle as that of a tilted uniaxial plate whose optic axis is the axis, d·(√(n_e² − s_y² − (n_e/n_o)²·s_x²) − √(n_o² − s²)), s = n·sin θ, x along the axis (Yeh and Gu, extended Jones matrices); without, it is the same at every angle"),
    new(Finish, "extraordinary_index", Number, "", AtLeast(1.0), "another one than the ordinary, larger where the retardance is positive"),
    new(Finish, "direction", Numbers(3), "mesh units", Any, "across the lines of a grating, not zero: planes at right angles to it cut the face into lines, so that its part along the face counts; order m turns light towards it by m λ/d"),
    new(Finish, "lines_per_mm", Number, "1/mm", Any, "planes of a grating per millimetre of the world along direction; below 0, order m is that of −m"),
    new(Finish, "orders", Records(&ORDER), "", Any, "list of { order, T, R }: shares of light that arrives from either side, together at most 1; an order that cannot propagate there carries nothing, and its share goes where rest says"),
    new(Finish, "order", Number, "", Any, "order of diffraction m, a whole number: n' t' = n t + m λ/d along the face"),
    new(Finish, "T", Number, "", Within(0.0, 1.0), "share of an order on the other side of the face").or("0"),
    new(Finish, "R", Number, "", Within(0.0, 1.0), "share of an order on the side where the light arrives").or("0"),
    new(Finish, "rest", Word(&["absorbed", "zero_order"]), "", Any, "where the light goes that the orders leave: nowhere, or straight on and back as at a bare interface of the part's medium").or("absorbed"),
    new(Finish, "handedness", Word(&["left", "right"]), "", Any, "of the light that a circular polariser sends out on the side of its wave plate, and that alone gets through from there; right: the field turns clockwise for those who look against the light"),
    new(Finish, "polariser_side", Word(&["front", "back"]), "", Any, "side of the face where the polariser of a circular polariser is; the wave plate is on the other").or("front"),
    // An ordinary material, in layers.
    new(Finish, "color", Numbers(3), "", Within(0.0, 1.0), "what the reflectance of lambert is multiplied by, linear Rec.709").or("[1, 1, 1]"),
    new(Finish, "color_texture", File, "", Any, "picture that multiplies color, sRGB").or("no picture"),
    new(Finish, "base_color", Numbers(3), "", Within(0.0, 1.0), "albedo of the body, or reflectance of the metal straight on, linear Rec.709").or("[0.8, 0.8, 0.8], or white where there is a texture"),
    new(Finish, "base_color_texture", File, "", Any, "picture that multiplies base_color, sRGB").or("no picture"),
    new(Finish, "diffuse_roughness", Number, "", Within(0.0, 1.0), "of the diffuse base: 0 scatters as Lambert says, 1 as dust does (EON)").or("0"),
    new(Finish, "diffuse_roughness_texture", File, "", Any, "picture whose red multiplies diffuse_roughness, linear").or("no picture"),
    new(Finish, "metallic", Number, "", Within(0.0, 1.0), "0 dielectric to 1 metal").or("0"),
    new(Finish, "metallic_texture", File, "", Any, "picture whose red multiplies metallic, linear").or("no picture"),
    new(Finish, "roughness", Number, "", Within(0.0, 1.0), "its square is the alpha of the facets, after Trowbridge and Reitz (GGX)").or("0.3, or 1 where there is a texture"),
    new(Finish, "roughness_texture", File, "", Any, "picture whose red multiplies roughness, linear").or("no picture"),
    new(Finish, "ior", Number, "", AtLeast(1.0), "index of the dielectric's boundary").or("1.5"),
    new(Finish, "specular", Number, "", Within(0.0, 1.0), "weight of the dielectric's reflection").or("1"),
    new(Finish, "specular_texture", File, "", Any, "picture whose red multiplies specular, linear").or("no picture"),
    new(Finish, "specular_color", Numbers(3), "", AtLeast(0.0), "colour of the dielectric's reflection straight on, linear Rec.709").or("[1, 1, 1]"),
    new(Finish, "specular_color_texture", File, "", Any, "picture that multiplies specular_color, sRGB").or("no picture"),
    new(Finish, "transmission", Number, "", Within(0.0, 1.0), "share of what enters that goes through the sheet, tinted by base_color; a solid is `polished` or `rough` with a medium").or("0"),
    new(Finish, "transmission_texture", File, "", Any, "picture whose red multiplies transmission, linear").or("no picture"),
    new(Finish, "diffuse_transmission", Number, "", Within(0.0, 1.0), "share of what is scattered that leaves on the other side").or("0"),
    new(Finish, "diffuse_transmission_texture", File, "", Any, "picture whose red multiplies diffuse_transmission, linear").or("no picture"),
    new(Finish, "diffuse_transmission_color", Numbers(3), "", Within(0.0, 1.0), "colour of what leaves on the other side, linear Rec.709").or("[1, 1, 1]"),
    new(Finish, "diffuse_transmission_color_texture", File, "", Any, "picture that multiplies diffuse_transmission_color, sRGB").or("no picture"),
    new(Finish, "anisotropy", Number, "", Within(0.0, 1.0), "facets longer along the texture's columns: alpha there is alpha + (1 − alpha)·anisotropy²").or("0"),
    new(Finish, "anisotropy_texture", File, "", Any, "picture whose red multiplies anisotropy, linear").or("no picture"),
    new(Finish, "anisotropy_rotation_deg", Number, "deg", Any, "turns that direction, counter-clockwise").or("0"),
    new(Finish, "film", Number, "", Within(0.0, 1.0), "share of the surface that is under a thin film").or("0"),
    new(Finish, "film_texture", File, "", Any, "picture whose red multiplies film, linear").or("no picture"),
    new(Finish, "film_ior", Number, "", AtLeast(1.0), "index of the film").or("1.4"),
    new(Finish, "film_thickness_nm", Number, "nm", AtLeast(0.0), "thickness of the film").or("500"),
    new(Finish, "coat", Number, "", Within(0.0, 1.0), "weight of a clear coat of index 1.5").or("0"),
    new(Finish, "coat_texture", File, "", Any, "picture whose red multiplies coat, linear").or("no picture"),
    new(Finish, "coat_roughness", Number, "", Within(0.0, 1.0), "of the coat, as roughness").or("0"),
    new(Finish, "coat_roughness_texture", File, "", Any, "picture whose red multiplies coat_roughness, linear").or("no picture"),
    new(Finish, "sheen_color", Numbers(3), "", Within(0.0, 1.0), "reflectance of fibres at grazing incidence, linear Rec.709").or("[0, 0, 0]"),
    new(Finish, "sheen_color_texture", File, "", Any, "picture that multiplies sheen_color, sRGB").or("no picture"),
    new(Finish, "sheen_roughness", Number, "", Within(0.0, 1.0), "of the fibres").or("0.3"),
    new(Finish, "sheen_roughness_texture", File, "", Any, "picture whose red multiplies sheen_roughness, linear").or("no picture"),
    new(Finish, "normal_texture", File, "", Any, "normals in the frame of the texture, 2·texel − 1, linear").or("no picture"),
    new(Finish, "opacity", Number, "", Within(0.0, 1.0), "share of the face that is there; light passes the rest unbent").or("1"),
    new(Finish, "opacity_texture", File, "", Any, "picture whose red multiplies opacity, linear").or("no picture"),
    new(Finish, "opacity_cutoff", Number, "", Within(0.0, 1.0), "the face is there where its opacity is at least this, and not elsewhere").or("none: opacity is a share"),
    new(Finish, "texture_set", Word(&["first", "second"]), "", Any, "set of texture coordinates that the pictures lie on").or("first"),
    new(Finish, "texture_scale", Numbers(2), "", NonZero, "how often the pictures lie across and down a unit of the texture coordinates").or("[1, 1]"),
    // Thin films on a polished face.
    new(Coating, "coating", Form::Kind, "", Any, "thin films on a polished face; also the name of a [coating.NAME]"),
    new(Coating, "name", Text, "", Any, "name of a coating of the asset"),
    new(Coating, "stack", Records(&FILM), "", Any, "a list of films { n, k or material, thickness_nm } from outside the solid inwards"),
    new(Coating, "n", Number, "", Positive, "real part of a film's index"),
    new(Coating, "k", Number, "", AtLeast(0.0), "imaginary part of a film's index").or("0"),
    new(Coating, "material", Text, "", Any, "name of a film's material (`eyebox glass` lists them)"),
    new(Coating, "thickness_nm", Number, "nm", AtLeast(0.0), "physical thickness of a film"),
    new(Coating, "table", Records(&MEASURED), "", Any, "measured shares, a list of { wavelength_nm, angle_deg, R_s, R_p, T_s, T_p } that fills a grid: linear in wavelength and angle, constant beyond them; R + T at most 1. Measured with light from outside the solid: what arrives from inside under the angle of refraction is transmitted and reflected alike (the same share is absorbed), beyond the critical angle all of it comes back; lines with side = \"inside\" give R there instead. s and p are reflected with the phase π between them, transmitted with 0"),
    new(Coating, "wavelength_nm", Number, "nm", Positive, "of a measured line"),
    new(Coating, "angle_deg", Number, "deg", Within(0.0, 90.0), "of a measured line, to the normal, in the medium where the light arrives"),
    new(Coating, "R_s", Number, "", Within(0.0, 1.0), "reflected share of a measured line, s-polarised"),
    new(Coating, "R_p", Number, "", Within(0.0, 1.0), "reflected share of a measured line, p-polarised"),
    new(Coating, "T_s", Number, "", Within(0.0, 1.0), "transmitted share of a measured line, s-polarised; not read where side is inside"),
    new(Coating, "T_p", Number, "", Within(0.0, 1.0), "transmitted share of a measured line, p-polarised; not read where side is inside"),
    new(Coating, "side", Text, "", Any, "where the light of a measured line arrives: outside or inside the solid").or("outside"),
    new(Coating, "R", Number, "", Within(0.0, 1.0), "reflected share at every angle, from both sides").or("0"),
    new(Coating, "T", Number, "", Within(0.0, 1.0), "transmitted share at every angle, from both sides; reflected where light cannot go through").or("0"),
    // The exact surface that a meshed face approximates.
    new(Shape, "shape", Form::Kind, "", Any, "the exact surface that the mesh approximates").or("the mesh itself"),
    new(Shape, "vertex", Numbers(3), "mesh units", Any, "vertex of the surface"),
    new(Shape, "axis", Numbers(3), "", Any, "normal of the surface at its vertex, not zero; heights are along it"),
    new(Shape, "x", Numbers(3), "", Any, "direction of x, laid at right angles to the axis, not along it; y = axis × x").or("the mesh's +x laid at right angles to the axis; its +y where the axis is within 25.8° of x (abs(axis·x) > 0.9)"),
    new(Shape, "radius", Number, "mesh units", NonZero, "radius of curvature; > 0: centre at vertex + radius·axis; of a cylinder or toroid in the plane of y and the axis, about a line along x"),
    new(Shape, "conic", Number, "", Any, "conic constant: 0 sphere, −1 paraboloid"),
    new(Shape, "even", Coefficients { least: 1, most: 32 }, "mesh units", Any, "heights of r², r⁴, r⁶, … that are added to the conic's"),
    new(Shape, "tube_radius", Number, "mesh units", NonZero, "radius of curvature of a toroid in the plane of x and the axis: a circle about vertex + tube_radius·axis, turned about the line along x through vertex + radius·axis"),
    new(Shape, "coeffs", Coefficients { least: 1, most: 1024 }, "mesh units", Any, "heights that are added to the conic's. xy_poly: of x^(d−j)·y^j at index d(d+1)/2 + j (1, x, y, x², xy, y², x³, …); zernike: of N·R(n,|m|)(r/norm_radius)·cos(mφ), or sin(|m|φ) for m < 0, at OSA/ANSI index (n(n+2) + m)/2, N = √((2n+2)/(1+δ(m,0))), φ from x towards y; bspline: of B_i(x)·B_j(y) at index i·(spans[1] + 3) + j, (spans[0] + 3)·(spans[1] + 3) of them"),
    new(Shape, "half", Numbers(2), "mesh units", Positive, "half the sides along x and y of the rectangle about the vertex that the knots of a bspline divide"),
    new(Shape, "spans", Integers(2), "", Within(1.0, 1024.0), "into how many equal spans along x and y"),
    new(Shape, "norm_radius", Number, "mesh units", Positive, "normalisation radius: r where the Zernike polynomials' ρ is 1"),
    new(Shape, "surface", Word(&["plane", "sphere", "cylinder", "conic", "toroid", "asphere", "xy_poly", "zernike", "bspline"]), "", Any, "which surface to fit; of freeforms as many terms as the points tell").or("the first of plane, sphere, cylinder, conic, toroid, asphere, xy_poly, bspline that fits"),
    new(Shape, "tolerance_um", Number, "µm", Positive, "greatest distance of a point of the face from the fitted surface"),
    // A face that emits.
    new(Emitter, "emitter", Thing(&EMITTER), "", Any, "{ group, flux_lm or luminance_cd_m2 or intensity_cd, angular, spectrum }, of a display with its picture: image, size, u, v, contrast; with a measured distribution (angular profile) and no strength the file's own candela hold"),
    new(Emitter, "name", Text, "", Any, "name of an emitter of the asset"),
    new(Emitter, "group", Text, "", Any, "light group, part of layer names: letters, digits and _, a letter first").or("lamp"),
    new(Emitter, "flux_lm", Number, "lm", MOST_LIGHT, "luminous flux of each face it is bound to; scales a measured distribution to it"),
    new(Emitter, "luminance_cd_m2", Number, "cd/m²", MOST_LUMINANCE, "luminance (along the normal); scales a measured distribution to it"),
    new(Emitter, "primaries_cd_m2", Numbers(3), "cd/m²", MOST_LUMINANCE, "luminances of red, green and blue (Rec.709's) at full, whose sum is white's; says the colour of white, too, so that no spectrum stands beside it"),
    new(Emitter, "intensity_cd", Number, "cd", MOST_LIGHT, "luminous intensity along the normal of each face it is bound to; scales a measured distribution to it"),
    new(Emitter, "illuminance_lx", Number, "lx", AtLeast(0.0), "of a distant source, which is no face: say it in sun"),
    new(Emitter, "radiant_flux_w", Number, "W", MOST_LIGHT, "radiant flux from 360 to 830 nm of each face it is bound to; the spectrum, which must be said, or the scene's one wavelength turns it into lumens"),
    new(Emitter, "angular", Form::Kind, "", Any, "how the intensity falls with the angle to the normal").or("lambert"),
    // Exponents are bounded where cosⁿ is a beam of 0.1 mrad: a typing error, not a lamp.
    new(Emitter, "n", Number, "", Within(0.0, 1e8), "exponent of cosⁿ"),
    new(Emitter, "fwhm_deg", Number, "deg", Between(0.0, 180.0), "full width at half maximum of the intensity"),
    new(Emitter, "file", File, "", Any, "luminous intensity distribution, IES LM-63 (.ies) or EULUMDAT (.ldt); its direction (0, 0) is the face's normal, its plane C0 lies along u, and C turns counter-clockwise as seen from behind the face; what it has behind the face is left out"),
    new(Emitter, "sides", Word(&["front", "both"]), "", Any, "which sides of the face shine; both share its flux, and each has its luminance").or("front"),
    new(Emitter, "spectrum", Form::Kind, "", Any, "colour of the light, from 360 to 830 nm").or("D65"),
    new(Emitter, "cct", Number, "K", Within(1000.0, 25_000.0), "correlated colour temperature: a black body below 4000 K, CIE daylight from there on"),
    new(Emitter, "rgb", Numbers(3), "", AtLeast(0.0), "linear Rec.709, of which only the hue and saturation count"),
    new(Emitter, "table", Rows(&["λ in nm", "W"]), "", AtLeast(0.0), "[[λ in nm, relative power], …] with rising λ, linear between the rows and 0 outside"),
    new(Emitter, "csv", File, "", Any, "text file with lines of λ in nm and relative power"),
    new(Emitter, "u", Numbers(3), "", Any, "direction along the face, in the part's axes: the plane C0 of a measured distribution, 0 degrees of polarisation, and to the right in a picture, which needs it").or("+x, or +y where the face's normal is within 45 degrees of x"),
    new(Emitter, "polarisation", Record(&["angle_deg", "degree"]), "", Any, "{ angle_deg, degree } of the light that leaves; without it, unpolarised"),
    new(Emitter, "angle_deg", Number, "deg", Any, "direction of polarisation, from u, counter-clockwise as seen from the front"),
    new(Emitter, "degree", Number, "", Within(0.0, 1.0), "degree of polarisation"),
    new(Emitter, "image", File, "", Any, "picture that a display shows, with linear values, PNG of 8 or 16 bits or EXR; the strength is that of white, and around the picture it is dark"),
    new(Emitter, "layer", Text, "", Any, "layer of an EXR file that has several").or("the default image"),
    new(Emitter, "size", Numbers(2), "mesh units", Positive, "width and height of the picture"),
    new(Emitter, "v", Numbers(3), "", Any, "direction up in the picture, along the face"),
    new(Emitter, "centre", Numbers(3), "mesh units", Any, "centre of the picture").or("centre of the face's bounds"),
    new(Emitter, "contrast", Number, "", AtLeastOrInfinite(1.0), "luminance of white over that of black").or("inf"),
    // A thin transmissive picture on a face.
    new(Slide, "slide", Thing(&SLIDE), "", Any, "{ image, size, u, v, centre, transmittance, contrast }; on a face with an emitter, the picture of a display"),
    new(Slide, "name", Text, "", Any, "name of a slide of the asset"),
    new(Slide, "image", File, "", Any, "picture with linear values, PNG of 8 or 16 bits or EXR"),
    new(Slide, "layer", Text, "", Any, "layer of an EXR file that has several").or("the default image"),
    new(Slide, "size", Numbers(2), "mesh units", Positive, "width and height of the picture"),
    new(Slide, "u", Numbers(3), "", Any, "direction to the right in the picture, along the face"),
    new(Slide, "v", Numbers(3), "", Any, "direction up in the picture, along the face"),
    new(Slide, "centre", Numbers(3), "mesh units", Any, "centre of the picture").or("centre of the face's bounds"),
    new(Slide, "transmittance", Number, "", Within(0.0, 1.0), "of white").or("1"),
    new(Slide, "contrast", Number, "", AtLeastOrInfinite(1.0), "transmittance of white over that of black").or("inf"),
    new(Slide, "polarisation", Record(&["angle_deg", "degree"]), "", Any, "{ angle_deg, degree } of the light that leaves"),
    new(Slide, "angle_deg", Number, "deg", Any, "direction of polarisation, from u towards v"),
    new(Slide, "degree", Number, "", Within(0.0, 1.0), "degree of polarisation"),
    // What measures the light that arrives at a face.
    new(Sensor, "sensor", Record(&["pixels", "u"]), "", Any, "{ pixels, u }: `eyebox sensor` maps the illuminance on both sides of the face; it changes no light"),
    new(Sensor, "pixels", Integers(2), "pixels", Within(1.0, 2048.0), "columns and rows of the map, which is the rectangle about the face in its mean plane"),
    new(Sensor, "u", Numbers(3), "", Any, "direction to the right in the map, in the part's axes, not along the normal; up is the normal × u").or("along the longer side of the smallest rectangle about the face"),
    // Light from everywhere: a picture, a number, or a model.
    new(Sky, "image", File, "", Any, "latitude-longitude panorama, EXR or HDR"),
    new(Sky, "layer", Text, "", Any, "layer of an EXR file that has several").or("the default image"),
    new(Sky, "scale_cd_m2", Number, "cd/m²", MOST_LUMINANCE, "luminance of a pixel of value 1").or("1"),
    new(Sky, "rotation_deg", Number, "deg", Any, "of an image about up, counter-clockwise as seen from above").or("0"),
    new(Sky, "luminance_cd_m2", Number, "cd/m²", MOST_LUMINANCE, "of a uniform sky, which is all around, below as above"),
    new(Sky, "rgb", Numbers(3), "", AtLeast(0.0), "colour of a uniform sky: linear Rec.709, of which only the hue and saturation count").or("white, D65"),
    new(Sky, "overcast_cd_m2", Number, "cd/m²", MOST_LUMINANCE, "the CIE's standard overcast sky: luminance of the uniform sky that lights a horizontal plane as much, which is 7/9 of the zenith's and 7/3 of the horizon's"),
    new(Sky, "sun_sky", Record(&SUN_SKY), "", Any, "{ elevation_deg, azimuth_deg, turbidity, sun_group }: a clear sky with its sun by the formulas of Preetham, Shirley and Smits (1999), in absolute luminance and colour"),
    new(Sky, "elevation_deg", Number, "deg", Within(0.0, 90.0), "of the sun's middle above the horizon"),
    new(Sky, "azimuth_deg", Number, "deg", Any, "of the sun about up, counter-clockwise as seen from above, from the frame's +z (with up = \"z\" its −y), so that 90 is its +x").or("0"),
    // The formulas were fitted from 2 to 6. Below 1.6 the luminance near the zenith gets negative.
    new(Sky, "turbidity", Number, "", Within(2.0, 10.0), "optical thickness of the air with its haze over that of air alone: 2 very clear, 3 clear, 6 moist, 10 hazy"),
    new(Sky, "sun_group", Text, "", Any, "light group of the sun, another one than the sky's").or("sun"),
    new(Sky, "ground_reflectance", Number, "", Within(0.0, 1.0), "of the grey ground below the horizon of overcast_cd_m2 and sun_sky, which light it").or("0.2"),
    new(Sky, "group", Text, "", Any, "light group").or("sky"),
    new(Sky, "up", Word(&["y", "z"]), "", Any, "axis of the frame that points to the zenith").or("y with an image, else what is up in the asset: y in glTF, upAxis in USD"),
    new(Sky, "frame", Text, "", Any, "\"asset\", or the node whose axes the sky follows").or("asset"),
    // The worst day of a head-up display.
    new(Sun, "direction", Numbers(3), "", Any, "towards the sun, not zero"),
    new(Sun, "illuminance_lx", Number, "lx", MOST_LIGHT, "on a plane across its light").or("100000"),
    new(Sun, "angle_deg", Number, "deg", Within(0.0, 179.0), "full angle of its disc, uniformly bright; 0 is parallel light that nobody sees").or("0.533"),
    new(Sun, "group", Text, "", Any, "light group").or("sun"),
    new(Sun, "frame", Text, "", Any, "\"asset\", or the node in whose axes direction is given").or("asset"),
    // The eye.
    new(Eye, "position", Place, "", Any, "centre of the pupil"),
    new(Eye, "look", Numbers(3), "", Any, "viewing direction, not zero"),
    new(Eye, "up", Numbers(3), "", Any, "up direction, orthogonal to look"),
    new(Eye, "frame", Text, "", Any, "\"asset\", or the node in whose axes position, look and up are given").or("asset"),
    new(Eye, "pupil_diameter", LengthOr(&["auto"]), "", AtLeast(0.0), "diameter of the pupil; 0 is a pinhole, auto what an eye of this age has that is adapted to the picture").or("4 mm"),
    new(Eye, "focus_distance", Length, "", PositiveOrInfinite, "distance of the plane of focus").or("inf"),
    new(Eye, "fov_deg", Number, "deg", Between(0.0, 180.0), "full horizontal field of view"),
    new(Eye, "resolution", Integers(2), "pixels", Within(1.0, 65536.0), "width and height of the picture").or("360 x 180"),
    new(Eye, "age", Number, "years", Within(1.0, 120.0), "for glare and the adaptive pupil").or("45"),
    // The whole asset.
    new(Asset, "schema", Integer, "", Any, "version of this vocabulary, 1"),
    new(Asset, "version", Integer, "", Any, "version of the asset's own vocabulary, 1"),
    new(Asset, "asset", File, "", Any, "the asset that a sidecar belongs to"),
    new(Asset, "unit", Number, "m", Positive, "metres per unit of the asset").or("what the asset declares"),
    new(Asset, "wavelengths", Form::Kind, "", Any, "{ mono_nm = 550 } or \"visible\"").or("visible"),
    // CIE photometry is tabulated from 360 to 830 nm.
    new(Asset, "mono_nm", Number, "nm", Within(360.0, 830.0), "the one wavelength of the scene"),
];

const fn kind(
    attribute: &'static str,
    name: &'static str,
    parameters: &'static [&'static str],
    doc: &'static str,
) -> Kind {
    Kind { attribute, name, parameters, rendered: true, doc }
}
/// Every kind of the attributes that have kinds.
#[rustfmt::skip]
pub const KINDS: &[Kind] = &[
    kind("finish", "none", &[], "not there for light: the sides of a thin CAD sheet"),
    kind("finish", "polished", &[], "refracts and reflects by Fresnel's equations or by its coating"),
    kind("finish", "rough", &["alpha"], "refracts and reflects at microfacets, from both sides, and absorbs nothing; acts on the faces of a medium"),
    kind("finish", "lambert", &["reflectance", "transmittance", "color", "color_texture", "texture_set", "texture_scale"], "scatters diffusely"),
    kind("finish", "surface", &SURFACE, "an ordinary material, in layers, as glTF 2.0 and OpenPBR have it: a body or a metal under facets, a film, a coat and fibres; each number or colour times its texture"),
    kind("finish", "material", &[], "as the face's own material says, as where nothing is bound"),
    kind("finish", "gauss", &["sigma_deg", "reflectance", "transmittance"], "Gaussian lobe about the specular directions"),
    kind("finish", "cos_m", &["m", "reflectance", "transmittance"], "lobe cosᵐ about the specular directions: share·(m + 2)/2π·cosᵐ of light that falls straight on"),
    kind("finish", "abg", &["a", "b", "g", "reflectance"], "ABg (Harvey–Shack) scatter of polish or blackened metal about what it reflects specularly; absorbs the rest"),
    kind("finish", "measured", &["file", "other_file"], "measured scattering"),
    kind("finish", "mirror", &["n", "k", "reflectance"], "a metal n + ik, or a reflectance at every angle"),
    kind("finish", "polariser", &["axis", "transmittance", "extinction"], "thin linear polariser: transmittance of light along the axis (1 if not said)"),
    kind("finish", "reflective_polariser", &["axis", "transmittance", "transmittance_leak", "reflectance", "reflectance_leak"], "thin sheet that lets polarisation along the axis through (transmittance, what reflectance_leak leaves of 1 if not said) and reflects the other one specularly (reflectance, what transmittance_leak leaves if not said); absorbs the rest"),
    kind("finish", "retarder", &["axis", "retardance_nm", "retardance_waves", "ordinary_index", "extraordinary_index"], "thin wave plate; exactly one of retardance_nm and retardance_waves"),
    kind("finish", "grating", &["direction", "lines_per_mm", "orders", "rest"], "diffraction grating or holographic combiner, on a thin sheet or on a face of glass: every order in the direction that the phases of its lines give, by wavelength and the media on both sides"),
    kind("finish", "circular_polariser", &["axis", "handedness", "polariser_side", "transmittance", "extinction", "retardance_nm", "retardance_waves", "ordinary_index", "extraordinary_index"], "thin polariser with its pass axis along axis (transmittance, 1 if not said) on a wave plate at 45 degrees to it (a quarter of every wavelength if not said)"),
    kind("finish", "absorber", &[], "takes everything"),
    kind("coating", "none", &[], "no coating"),
    kind("coating", "stack", &["name", "stack"], "films by the transfer-matrix method"),
    kind("coating", "table", &["name", "table"], "measured"),
    kind("coating", "ideal", &["name", "R", "T"], "fixed shares, the rest is absorbed"),
    kind("shape", "mesh", &[], "the triangles, shaded with their normals"),
    kind("shape", "plane", &["vertex", "axis"], "plane"),
    kind("shape", "sphere", &["vertex", "axis", "radius"], "sphere"),
    kind("shape", "conic", &["vertex", "axis", "radius", "conic"], "conic of revolution"),
    kind("shape", "asphere", &["vertex", "axis", "radius", "conic", "even"], "conic + even[0]·r² + even[1]·r⁴ + …"),
    kind("shape", "cylinder", &["vertex", "axis", "x", "radius"], "cylinder about the line along x through vertex + radius·axis"),
    kind("shape", "toroid", &["vertex", "axis", "x", "radius", "tube_radius"], "torus about the line along x through vertex + radius·axis"),
    kind("shape", "xy_poly", &["vertex", "axis", "x", "radius", "conic", "coeffs"], "conic + polynomial in x and y"),
    kind("shape", "zernike", &["vertex", "axis", "x", "radius", "conic", "norm_radius", "coeffs"], "conic + Zernike polynomials"),
    kind("shape", "bspline", &["vertex", "axis", "x", "radius", "conic", "half", "spans", "coeffs"], "conic + uniform bicubic B-splines"),
    kind("shape", "fit", &["surface", "tolerance_um", "radius", "conic", "tube_radius"], "recovered from the face's points; radius, conic and tube_radius replace what was found, but of freeforms"),
    kind("angular", "lambert", &[], "I ∝ cos θ"),
    kind("angular", "cos_n", &["n"], "I ∝ cosⁿ θ"),
    kind("angular", "gauss", &["fwhm_deg"], "I ∝ exp(−4 ln 2 (θ/fwhm)²)"),
    kind("angular", "profile", &["file"], "measured: bilinear between the file's angles"),
    kind("spectrum", "D65", &[], "CIE standard illuminant D65"),
    kind("spectrum", "A", &[], "CIE standard illuminant A"),
    kind("spectrum", "equal", &[], "equal power at every wavelength"),
    kind("spectrum", "cct", &["cct"], "daylight or a black body of this colour temperature"),
    kind("spectrum", "rgb", &["rgb"], "smooth spectrum of a colour"),
    kind("spectrum", "led_b1", &[], "CIE 015:2018 LED-B1, a phosphor LED of 2733 K"),
    kind("spectrum", "led_b2", &[], "CIE 015:2018 LED-B2, a phosphor LED of 2998 K"),
    kind("spectrum", "led_b3", &[], "CIE 015:2018 LED-B3, a phosphor LED of 4103 K"),
    kind("spectrum", "led_b4", &[], "CIE 015:2018 LED-B4, a phosphor LED of 5109 K"),
    kind("spectrum", "led_b5", &[], "CIE 015:2018 LED-B5, a phosphor LED of 6598 K"),
    kind("spectrum", "led_bh1", &[], "CIE 015:2018 LED-BH1, blue pump with red"),
    kind("spectrum", "led_rgb1", &[], "CIE 015:2018 LED-RGB1, three LEDs"),
    kind("spectrum", "led_v1", &[], "CIE 015:2018 LED-V1, violet pump, 2724 K"),
    kind("spectrum", "led_v2", &[], "CIE 015:2018 LED-V2, violet pump, 4070 K"),
    kind("spectrum", "table", &["table"], "measured"),
    kind("spectrum", "csv", &["csv"], "measured, in a file"),
    kind("wavelengths", "mono_nm", &["mono_nm"], "one wavelength"),
    kind("wavelengths", "visible", &[], "the visible range"),
];
