//! From cd/m² to what a display shows: colour spaces, the adaptation luminance, Ward's visibility matching, sRGB codes.

use glam::{DMat3, DVec3};

/// The colour spaces a frame may be in, by `colorInteropID`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorSpace {
    /// `lin_rec709_scene`, and everything unnamed or unknown.
    Rec709,
    /// `lin_ap1_scene`
    AcesCg,
    /// `lin_ciexyzd65_scene`
    XyzD65,
}

impl ColorSpace {
    pub fn from_interop_id(id: Option<&str>) -> Self {
        match id {
            Some("lin_ap1_scene") => ColorSpace::AcesCg,
            Some("lin_ciexyzd65_scene") => ColorSpace::XyzD65,
            Some(_) | None => ColorSpace::Rec709,
        }
    }

    /// The weights that make a pixel's luminance, cd/m². Rec. 709 as in `design/layers.md`; ACEScg: S-2014-004.
    pub fn luminance_weights(self) -> DVec3 {
        match self {
            ColorSpace::Rec709 => DVec3::new(0.2126, 0.7152, 0.0722),
            ColorSpace::AcesCg => DVec3::new(0.272_228_716_8, 0.674_081_765_8, 0.053_689_517_4),
            ColorSpace::XyzD65 => DVec3::Y,
        }
    }

    /// To linear Rec. 709. Both matrices from the primaries in double precision; ACEScg with Bradford adaptation.
    pub fn to_rec709(self) -> DMat3 {
        match self {
            ColorSpace::Rec709 => DMat3::IDENTITY,
            ColorSpace::AcesCg => DMat3::from_cols(
                DVec3::new(0.613_097_402_401_2, 0.070_193_722_469_58, 0.020_615_592_882_23),
                DVec3::new(0.339_523_146_184_1, 0.916_353_879_057_3, 0.109_569_772_938_1),
                DVec3::new(0.047_379_451_414_71, 0.013_452_398_473_07, 0.869_814_634_179_6),
            )
            .inverse(),
            ColorSpace::XyzD65 => DMat3::from_cols(
                DVec3::new(3.240_969_941_905, -0.969_243_636_280_9, 0.055_630_079_696_99),
                DVec3::new(-1.537_383_177_57, 1.875_967_501_508, -0.203_976_958_889),
                DVec3::new(-0.498_610_760_293, 0.041_555_057_407_18, 1.056_971_514_243),
            ),
        }
    }
}

/// The adaptation luminance, cd/m²: the arithmetic mean of the pixels' luminances (`design/eye.md`). Values that are
/// not finite are left out; 0 if none is left.
pub fn adaptation(luminances: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = luminances
        .filter(|luminance| luminance.is_finite())
        .fold((0.0, 0_u64), |(sum, count), luminance| (sum + luminance, count + 1));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// Display value (0 to 1) per cd/m² of the scene, so that what is just visible there is just visible here:
/// m = ((1.219 + (Ldmax/2)^0.4) / (1.219 + Lwa^0.4))^2.5 / Ldmax.
/// Ward 1994, "A contrast-based scalefactor for luminance display", Graphics Gems IV.
/// `adaptation` (Lwa) and `display_max` (Ldmax) in cd/m²; a negative adaptation counts as 0.
pub fn ward_scale(adaptation: f64, display_max: f64) -> f64 {
    let visible = |luminance: f64| 1.219 + luminance.max(0.0).powf(0.4);
    (visible(display_max / 2.0) / visible(adaptation)).powf(2.5) / display_max
}

/// The 8-bit sRGB code of a linear value; values outside 0 to 1 are clipped. IEC 61966-2-1.
pub fn srgb_code(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    code(encoded)
}

/// The 8-bit code of a value that needs no transfer curve.
pub fn code(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ward_at_points_known_in_closed_form() {
        // Half the display's maximum is where the display itself is adapted to: one to one.
        assert!((ward_scale(50.0, 100.0) - 0.01).abs() < 1e-15);
        // In the dark (1 + 50^0.4/1.219)^2.5 / 100, by hand 0.5377.
        assert!((ward_scale(0.0, 100.0) - 0.537_66).abs() < 1e-4);
        assert_eq!(ward_scale(-3.0, 100.0), ward_scale(0.0, 100.0));
        // Far above, visibility follows Weber: the picture of the adaptation luminance tends to a constant.
        let picture = |luminance: f64| luminance * ward_scale(luminance, 100.0);
        assert!((picture(1e12) / picture(1e13) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn srgb_codes() {
        // 0.5 → 187.5, 0.18 → 117.6, the knee → 10.3: from the formula of the standard.
        assert_eq!([0.0, 0.003_130_8, 0.18, 0.5, 1.0, 7.0, -1.0].map(srgb_code), [0, 10, 118, 188, 255, 255, 0]);
        assert_eq!([srgb_code(f64::NAN), code(0.5)], [0, 128]);
    }

    #[test]
    fn white_is_white_and_luminance_keeps_in_every_space() {
        // The white of XYZ is D65, x = 0.3127, y = 0.3290, with Y = 1.
        let d65 = DVec3::new(0.3127 / 0.329, 1.0, (1.0 - 0.3127 - 0.329) / 0.329);
        for (space, white) in
            [(ColorSpace::Rec709, DVec3::ONE), (ColorSpace::AcesCg, DVec3::ONE), (ColorSpace::XyzD65, d65)]
        {
            assert!((space.to_rec709() * white - DVec3::ONE).abs().max_element() < 1e-9, "{space:?}");
            assert!((space.luminance_weights().dot(white) - 1.0).abs() < 1e-9, "{space:?}");
        }
        // XYZ → Rec. 709 → luminance gives Y back, to the four digits of the weights.
        let color = DVec3::new(0.3, 0.7, 0.4);
        let rgb = ColorSpace::XyzD65.to_rec709() * color;
        assert!((ColorSpace::Rec709.luminance_weights().dot(rgb) - 0.7).abs() < 1e-4);
    }

    #[test]
    fn adaptation_is_the_mean_of_finite_values() {
        assert_eq!(adaptation([1.0, f64::NAN, 3.0, f64::INFINITY].into_iter()), 2.0);
        assert_eq!(adaptation(std::iter::empty()), 0.0);
    }
}
