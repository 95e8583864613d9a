//! From cd/m² to what a display shows: the adaptation luminance, Ward's visibility matching, sRGB codes.

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
    fn adaptation_is_the_mean_of_finite_values() {
        assert_eq!(adaptation([1.0, f64::NAN, 3.0, f64::INFINITY].into_iter()), 2.0);
        assert_eq!(adaptation(std::iter::empty()), 0.0);
    }
}
