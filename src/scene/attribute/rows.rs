//! The rows themselves. Keep each on its lines: this is the vocabulary that people read.

use super::{Form, Kind, Noun, Range, Row, Support};
use Form::{File, Integer, Length, List, Number, Numbers, Place, Text};
use Noun::{Asset, Coating, Emitter, Eye, Finish, Medium, Shape, Sky, Slide};
use Range::{Above, Any, AtLeast, AtLeastOrInfinite, Between, NonZero, Positive, PositiveOrInfinite, Within};
use Support::{Kept, NotYet, Rendered};

#[rustfmt::skip]
const fn new(noun: Noun, name: &'static str, form: Form, unit: &'static str, range: Range, doc: &'static str) -> Row {
    Row { noun, name, form, unit, range, default: None, support: Rendered, doc }
}
impl Row {
    const fn or(mut self, default: &'static str) -> Self {
        self.default = Some(default);
        self
    }
    const fn is(mut self, support: Support) -> Self {
        self.support = support;
        self
    }
}

/// Far above any lamp (lighthouses: 1e6 cd; the sun: 2e9 cd/m²), and far below where squares leave the range of f32.
const MOST_LIGHT: Range = Within(0.0, 1e12);
const MOST_LUMINANCE: Range = Within(0.0, 1e15);

/// Every attribute.
#[rustfmt::skip]
pub const ROWS: &[Row] = &[
    // What fills a closed solid.
    new(Medium, "medium", Text, "", Any, "name of a [medium.NAME], \"none\", or a table of medium attributes"),
    new(Medium, "name", Text, "", Any, "name of a medium of the asset"),
    new(Medium, "ior", Number, "", AtLeast(1.0), "constant refractive index"),
    new(Medium, "glass", Text, "", Any, "name of a catalogue glass, e.g. N-BK7"),
    new(Medium, "sellmeier", List, "µm²", Any, "{ b = [B1, B2, B3], c_um2 = [C1, C2, C3] }: n² = 1 + Σ B λ²/(λ² − C), λ in µm"),
    new(Medium, "cauchy", List, "µm", Any, "[A, B, C]: n = A + B/λ² + C/λ⁴, λ in µm"),
    new(Medium, "abbe", Numbers(2), "", Positive, "[n_d, V_d]: index at 587.6 nm and Abbe number"),
    new(Medium, "index_table", List, "nm", AtLeast(0.0), "[[λ in nm, n, k], …] with rising λ, linear between the rows; k >= 0 absorbs"),
    new(Medium, "absorption_per_m", List, "1/m", AtLeast(0.0), "a number >= 0 in 1/m, or [[λ in nm, 1/m], …] with rising λ: exp(−a·length)").or("0"),
    new(Medium, "priority", Integer, "", Any, "where solids overlap or touch, the higher priority wins").or("0"),
    // What a face does with light.
    new(Finish, "finish", Form::Kind, "", Any, "what the face does with light"),
    new(Finish, "alpha", Number, "", Above(0.0, 1.0), "roughness of a microfacet surface").is(NotYet),
    new(Finish, "reflectance", Number, "", Within(0.0, 1.0), "reflected share").or("0"),
    new(Finish, "transmittance", Number, "", Within(0.0, 1.0), "transmitted share").or("0"),
    new(Finish, "sigma_deg", Number, "deg", Above(0.0, 90.0), "standard deviation of the lobe's angle"),
    new(Finish, "file", File, "", Any, "measured scattering").is(NotYet),
    new(Finish, "n", Number, "", Positive, "real part of a metal's index"),
    new(Finish, "k", Number, "", AtLeast(0.0), "imaginary part of a metal's index"),
    // Thin films on a polished face.
    new(Coating, "coating", Form::Kind, "", Any, "thin films on a polished face; also the name of a [coating.NAME]"),
    new(Coating, "name", Text, "", Any, "name of a coating of the asset"),
    new(Coating, "stack", List, "", Any, "a list of films { n, k or material, thickness_nm } from outside the solid inwards"),
    new(Coating, "n", Number, "", Positive, "real part of a film's index"),
    new(Coating, "k", Number, "", AtLeast(0.0), "imaginary part of a film's index").or("0"),
    new(Coating, "material", Text, "", Any, "catalogue name of a film's material"),
    new(Coating, "thickness_nm", Number, "nm", AtLeast(0.0), "physical thickness of a film"),
    new(Coating, "table", List, "", Any, "[{ λ, θ, R_s, R_p, T_s, T_p }, …] measured").is(NotYet),
    new(Coating, "ideal", List, "", Any, "{ R, T } at every angle").is(NotYet),
    // The exact surface that a meshed face approximates.
    new(Shape, "shape", Form::Kind, "", Any, "the exact surface that the mesh approximates").or("the mesh itself"),
    new(Shape, "vertex", Numbers(3), "mesh units", Any, "vertex of the surface"),
    new(Shape, "axis", Numbers(3), "", Any, "axis of the surface at its vertex, not zero"),
    new(Shape, "radius", Number, "mesh units", NonZero, "radius of curvature; > 0: centre at vertex + radius·axis"),
    new(Shape, "conic", Number, "", Any, "conic constant: 0 sphere, −1 paraboloid"),
    new(Shape, "even", List, "mesh units", Any, "even polynomial coefficients").is(NotYet),
    new(Shape, "tube_radius", Number, "mesh units", Positive, "radius of a toroid's tube").is(NotYet),
    new(Shape, "coeffs", List, "mesh units", Any, "polynomial coefficients").is(NotYet),
    new(Shape, "norm_radius", Number, "mesh units", Positive, "normalisation radius").is(NotYet),
    new(Shape, "surface", Text, "", Any, "which surface to fit: plane, sphere or conic").or("the simplest that fits"),
    new(Shape, "tolerance_um", Number, "µm", Positive, "greatest distance of a point of the face from the fitted surface"),
    // A face that emits.
    new(Emitter, "emitter", List, "", Any, "{ group, flux_lm or luminance_cd_m2 or intensity_cd, angular, spectrum }"),
    new(Emitter, "name", Text, "", Any, "name of an emitter of the asset"),
    new(Emitter, "group", Text, "", Any, "light group, part of layer names: letters, digits and _, a letter first").or("lamp"),
    new(Emitter, "flux_lm", Number, "lm", MOST_LIGHT, "luminous flux of each face it is bound to"),
    new(Emitter, "luminance_cd_m2", Number, "cd/m²", MOST_LUMINANCE, "luminance (along the normal)"),
    new(Emitter, "intensity_cd", Number, "cd", MOST_LIGHT, "luminous intensity along the normal of each face it is bound to"),
    new(Emitter, "illuminance_lx", Number, "lx", AtLeast(0.0), "of a distant source").is(NotYet),
    new(Emitter, "radiant_flux_w", Number, "W", AtLeast(0.0), "radiant flux, needs a spectrum").is(NotYet),
    new(Emitter, "angular", Form::Kind, "", Any, "how the intensity falls with the angle to the normal").or("lambert"),
    // Exponents are bounded where cosⁿ is a beam of 0.1 mrad: a typing error, not a lamp.
    new(Emitter, "n", Number, "", Within(0.0, 1e8), "exponent of cosⁿ"),
    new(Emitter, "fwhm_deg", Number, "deg", Between(0.0, 180.0), "full width at half maximum").is(NotYet),
    new(Emitter, "file", File, "", Any, "luminous intensity distribution, .ies or .ldt").is(NotYet),
    new(Emitter, "spectrum", List, "", Any, "D65, A, { cct = kelvin }, led_b1, … or a table").is(Kept),
    // A thin transmissive picture on a face.
    new(Slide, "slide", List, "", Any, "{ image, size, u, v, centre, transmittance, contrast }"),
    new(Slide, "name", Text, "", Any, "name of a slide of the asset"),
    new(Slide, "image", File, "", Any, "picture with linear values, PNG of 8 or 16 bits"),
    new(Slide, "size", Numbers(2), "mesh units", Positive, "width and height of the picture"),
    new(Slide, "u", Numbers(3), "", Any, "direction to the right in the picture, along the face"),
    new(Slide, "v", Numbers(3), "", Any, "direction up in the picture, along the face"),
    new(Slide, "centre", Numbers(3), "mesh units", Any, "centre of the picture").or("centre of the face's bounds"),
    new(Slide, "transmittance", Number, "", Within(0.0, 1.0), "of white").or("1"),
    new(Slide, "contrast", Number, "", AtLeastOrInfinite(1.0), "transmittance of white over that of black").or("inf"),
    new(Slide, "polarisation", List, "", Any, "{ angle_deg, degree }").is(NotYet),
    // Light from everywhere.
    new(Sky, "image", File, "", Any, "latitude-longitude panorama, EXR or HDR"),
    new(Sky, "scale_cd_m2", Number, "cd/m²", MOST_LUMINANCE, "luminance of a pixel of value 1").or("1"),
    new(Sky, "rotation_deg", Number, "deg", Any, "about the frame's +y").or("0"),
    new(Sky, "group", Text, "", Any, "light group").or("sky"),
    new(Sky, "frame", Text, "", Any, "\"asset\", or the node whose axes the panorama follows").or("asset"),
    // The eye.
    new(Eye, "position", Place, "", Any, "centre of the pupil"),
    new(Eye, "look", Numbers(3), "", Any, "viewing direction, not zero"),
    new(Eye, "up", Numbers(3), "", Any, "up direction, orthogonal to look"),
    new(Eye, "frame", Text, "", Any, "\"asset\", or the node in whose axes position, look and up are given").or("asset"),
    new(Eye, "pupil_diameter", Length, "", AtLeast(0.0), "diameter of the pupil; 0 is a pinhole").or("4 mm"),
    new(Eye, "focus_distance", Length, "", PositiveOrInfinite, "distance of the plane of focus").or("inf"),
    new(Eye, "fov_deg", Number, "deg", Between(0.0, 180.0), "full horizontal field of view"),
    new(Eye, "resolution", Numbers(2), "pixels", Within(1.0, 65536.0), "width and height of the picture").or("360 x 180"),
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
impl Kind {
    const fn not_yet(mut self) -> Self {
        self.rendered = false;
        self
    }
}

/// Every kind of the attributes that have kinds.
#[rustfmt::skip]
pub const KINDS: &[Kind] = &[
    kind("finish", "none", &[], "not there for light: the sides of a thin CAD sheet"),
    kind("finish", "polished", &[], "refracts and reflects by Fresnel's equations or by its coating"),
    kind("finish", "rough", &["alpha"], "microfacet refraction and reflection").not_yet(),
    kind("finish", "lambert", &["reflectance", "transmittance"], "scatters diffusely"),
    kind("finish", "gauss", &["sigma_deg", "reflectance", "transmittance"], "Gaussian lobe about the specular directions"),
    kind("finish", "measured", &["file"], "measured scattering").not_yet(),
    kind("finish", "mirror", &["n", "k", "reflectance"], "a metal n + ik, or a reflectance at every angle"),
    kind("finish", "absorber", &[], "takes everything"),
    kind("coating", "none", &[], "no coating"),
    kind("coating", "stack", &["name", "stack"], "films by the transfer-matrix method"),
    kind("coating", "table", &["name", "table"], "measured").not_yet(),
    kind("coating", "ideal", &["name", "ideal"], "fixed shares").not_yet(),
    kind("shape", "mesh", &[], "the triangles, shaded with their normals"),
    kind("shape", "plane", &["vertex", "axis"], "plane"),
    kind("shape", "sphere", &["vertex", "axis", "radius"], "sphere"),
    kind("shape", "conic", &["vertex", "axis", "radius", "conic"], "conic of revolution"),
    kind("shape", "asphere", &["vertex", "axis", "radius", "conic", "even"], "even asphere").not_yet(),
    kind("shape", "cylinder", &["vertex", "axis", "radius"], "cylinder").not_yet(),
    kind("shape", "toroid", &["vertex", "axis", "radius", "tube_radius"], "toroid").not_yet(),
    kind("shape", "xy_poly", &["vertex", "axis", "radius", "conic", "coeffs"], "polynomial in x and y").not_yet(),
    kind("shape", "zernike", &["vertex", "axis", "radius", "conic", "norm_radius", "coeffs"], "Zernike surface").not_yet(),
    kind("shape", "fit", &["surface", "tolerance_um", "radius", "conic"], "recovered from the face's points; radius and conic replace what was found"),
    kind("angular", "lambert", &[], "I ∝ cos θ"),
    kind("angular", "cos_n", &["n"], "I ∝ cosⁿ θ"),
    kind("angular", "gauss", &["fwhm_deg"], "Gaussian beam").not_yet(),
    kind("angular", "profile", &["file"], "measured").not_yet(),
    kind("wavelengths", "mono", &["mono_nm"], "one wavelength"),
    kind("wavelengths", "visible", &[], "the visible range"),
];
