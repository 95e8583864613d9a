//! From cd/m² to what a display shows: the adaptation luminance, Ward's visibility matching, sRGB codes.

use super::field::Field;
use eyebox_film::frame::Frame;

/// Radius of the part of the field that the fovea sees, degrees: the 2° field of CIE 1931.
const FOVEA_DEG: f64 = 1.0;

/// What an eye that looks at a picture is taken to be adapted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Adaptation {
    /// The mean luminance of the picture.
    #[default]
    Arithmetic,
    /// The mean of its logarithms (Ward 1994).
    Log,
    /// The mean around the line of sight.
    Foveal,
}

impl Adaptation {
    pub const ALL: [Adaptation; 3] = [Adaptation::Arithmetic, Adaptation::Log, Adaptation::Foveal];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Adaptation::Arithmetic => "arithmetic",
            Adaptation::Log => "log",
            Adaptation::Foveal => "foveal",
        }
    }

    pub fn doc(self) -> &'static str {
        match self {
            Adaptation::Arithmetic => "mean of all pixels",
            Adaptation::Log => "exponential of the mean logarithm of the pixels above 0",
            Adaptation::Foveal => "mean within 1° of the middle",
        }
    }
}

/// The adaptation luminance of a picture, cd/m², and what each pixel adds to it when it changes (pixel, derivative).
/// Pixels that are not finite are left out. None for `Foveal` without the eye in the header, and where no pixel counts.
pub fn adaptation_luminance(kind: Adaptation, luminance: &[f64], frame: &Frame) -> Option<(f64, Vec<(usize, f64)>)> {
    let field = Field::of(frame);
    let middle = [0.5 * frame.width as f64, 0.5 * frame.height as f64];
    let counts = |pixel: usize, value: f64| match kind {
        Adaptation::Arithmetic => true,
        Adaptation::Log => value > 0.0,
        Adaptation::Foveal => field.is_some_and(|field| {
            let place = [(pixel % frame.width.max(1)) as f64 + 0.5, (pixel / frame.width.max(1)) as f64 + 0.5];
            field.angle_deg(middle, place) <= FOVEA_DEG.max(0.75 * field.pixel_deg())
        }),
    };
    let finite = luminance.iter().copied().enumerate().filter(|(_, value)| value.is_finite());
    let used: Vec<(usize, f64)> = finite.filter(|(pixel, value)| counts(*pixel, *value)).collect();
    if used.is_empty() {
        return None;
    }
    let weight = 1.0 / used.len() as f64;
    Some(match kind {
        Adaptation::Arithmetic | Adaptation::Foveal => {
            let sum: f64 = used.iter().map(|(_, value)| value).sum();
            (sum * weight, used.iter().map(|(pixel, _)| (*pixel, weight)).collect())
        }
        Adaptation::Log => {
            let mean = (used.iter().map(|(_, value)| value.ln()).sum::<f64>() * weight).exp();
            (mean, used.iter().map(|(pixel, value)| (*pixel, mean * weight / value)).collect())
        }
    })
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
    fn three_kinds_of_adaptation() {
        use eyebox_film::frame::Meta;
        let mut frame = Frame::new(9, 1);
        // 9 pixels over 18°: the middle one is the fovea's.
        frame.meta.insert("eye".into(), Meta::Text("{\"fov_deg\":18.0}".into()));
        let luminance = [1.0, 1.0, 1.0, 1.0, 100.0, 1.0, 1.0, 0.0, f64::NAN];
        let of = |kind| adaptation_luminance(kind, &luminance, &frame).unwrap();
        assert_eq!(of(Adaptation::Arithmetic).0, 106.0 / 8.0);
        let (log, weights) = of(Adaptation::Log);
        assert!((log - 100f64.powf(1.0 / 7.0)).abs() < 1e-12);
        // dM/dL = M/(n·L).
        assert_eq!(weights[4], (4, log / 7.0 / 100.0));
        assert_eq!(of(Adaptation::Foveal), (100.0, vec![(4, 1.0)]));
        assert_eq!(adaptation_luminance(Adaptation::Foveal, &luminance, &Frame::new(9, 1)), None);
        assert_eq!(adaptation_luminance(Adaptation::Log, &[0.0], &frame), None);
    }

    #[test]
    fn srgb_codes() {
        // 0.5 → 187.5, 0.18 → 117.6, the knee → 10.3: from the formula of the standard.
        assert_eq!([0.0, 0.003_130_8, 0.18, 0.5, 1.0, 7.0, -1.0].map(srgb_code), [0, 10, 118, 188, 255, 255, 0]);
        assert_eq!([srgb_code(f64::NAN), code(0.5)], [0, 128]);
    }
}
