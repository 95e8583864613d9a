//! A slide as the tracer asks it: how open is it here?

pub mod edges;
pub mod footprint;
pub mod jump;
pub mod texels;

use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::Slide;
use glam::DVec3;
use std::sync::Arc;

/// Picture of a slide over its face: T = T_black + s·(T_white − T_black).
#[derive(Debug, Clone)]
pub struct SlideMap {
    width: usize,
    height: usize,
    pixels: Arc<Vec<f32>>,
    rgb: Option<Arc<Vec<[f32; 3]>>>,
    /// How many pixels from each on to the right are equal to it, itself among them, or that many at least.
    alike: Arc<Vec<u16>>,
    centre: DVec3,
    /// Picture axes divided by its size, 1/mesh units: right, and down.
    across: DVec3,
    down: DVec3,
    t_white: f64,
    contrast: f64,
    /// Direction of the electric field in mesh units, and the polarised share, of the light that leaves.
    polarisation: Option<(DVec3, f64)>,
    /// Of a display: red, green and blue of its white.
    primaries: Option<[f64; 3]>,
}

impl SlideMap {
    /// Errors: a picture without pixels, without size or with values outside 0–1; transmittance or contrast outside
    /// their ranges.
    pub fn build(slide: &Slide) -> Result<SlideMap> {
        let fault = |what: String| Error::new(Where::File(slide.file.clone().into()), what);
        let (width, height) = (slide.width, slide.height);
        if width == 0 || height == 0 || width.checked_mul(height) != Some(slide.pixels.len()) {
            let what =
                format!("slide `{}` has {} values for {width} × {height} pixels", slide.name, slide.pixels.len());
            return Err(fault(what).expected("one value per pixel"));
        }
        if let Some(index) = slide.pixels.iter().position(|s| !(0.0..=1.0).contains(s)) {
            let what = format!(
                "slide `{}`: pixel ({}, {}) is {}",
                slide.name,
                index % width,
                index / width,
                slide.pixels[index]
            );
            return Err(fault(what).expected("0 to 1"));
        }
        if let Some(rgb) = &slide.rgb
            && (rgb.len() != slide.pixels.len() || !rgb.iter().flatten().all(|s| (0.0..=1.0).contains(s)))
        {
            return Err(fault(format!("slide `{}`: its colours do not go with its pixels", slide.name))
                .expected("three values of 0 to 1 per pixel"));
        }
        if !(0.0..=1.0).contains(&slide.transmittance) {
            let what = format!("slide `{}`: the transmittance is {}", slide.name, slide.transmittance);
            return Err(fault(what).expected("0 to 1"));
        }
        if slide.contrast.is_nan() || slide.contrast < 1.0 {
            let what = format!("slide `{}`: the contrast is {}", slide.name, slide.contrast);
            return Err(fault(what).expected("1 or more"));
        }
        if let Some(polarisation) = slide.polarisation
            && !((0.0..=1.0).contains(&polarisation.degree) && polarisation.angle_deg.is_finite())
        {
            let what = format!("slide `{}`: the polarisation is {polarisation:?}", slide.name);
            return Err(fault(what).expected("a finite angle and a degree of 0 to 1"));
        }
        let [across, down] = [slide.u / slide.size[0], -slide.v / slide.size[1]];
        let sized = slide.size.iter().all(|size| *size > 0.0 && size.is_finite());
        if !(sized && across.is_finite() && down.is_finite() && slide.centre.is_finite()) {
            let what = format!("slide `{}` is {} × {} mesh units", slide.name, slide.size[0], slide.size[1]);
            return Err(fault(what).expected("a positive, finite size").code(Code::SlideWithoutSize));
        }
        Ok(SlideMap {
            width,
            height,
            pixels: slide.pixels.clone(),
            rgb: slide.rgb.clone(),
            alike: Arc::new(alike(width, &slide.pixels, slide.rgb.as_ref().map(|rgb| rgb.as_slice()))),
            centre: slide.centre,
            across,
            down,
            t_white: slide.transmittance,
            contrast: slide.contrast,
            polarisation: slide.polarisation.map(|polarisation| {
                let (sin, cos) = polarisation.angle_deg.to_radians().sin_cos();
                (slide.u * cos + slide.v * sin, polarisation.degree)
            }),
            primaries: slide.primaries,
        })
    }

    /// The longer side, mesh units.
    pub fn size(&self) -> f64 {
        (1.0 / self.across.length()).max(1.0 / self.down.length())
    }

    /// T_white, 0–1.
    pub fn t_white(&self) -> f64 {
        self.t_white
    }
    /// T_black = T_white/C.
    pub fn t_black(&self) -> f64 {
        self.t_white / self.contrast
    }
    /// C = T_white/T_black, at least 1; may be infinite.
    /// What the slide lets through where its picture is `s`, 0–1.
    pub fn transmittance(&self, s: f64) -> f64 {
        let dark = 1.0 / self.contrast;
        self.t_white * (dark + s * (1.0 - dark))
    }
    pub fn contrast(&self) -> f64 {
        self.contrast
    }

    /// Direction of the electric field of the light that leaves, in mesh units.
    pub fn polarisation_axis(&self) -> Option<DVec3> {
        self.polarisation.map(|(axis, _)| axis)
    }
    /// Polarised share of the light that leaves, 0–1.
    pub fn polarisation_degree(&self) -> f64 {
        self.polarisation.map_or(0.0, |(_, degree)| degree)
    }

    /// s of the pixel at a point in mesh units, 0–1; none outside the picture, where the slide is opaque.
    pub fn s(&self, local: DVec3) -> Option<f64> {
        Some(self.s_of(self.pixel(local)?))
    }

    /// How far a point lies from the picture's rim, as a share of the longer side; inside and outside alike.
    pub fn to_rim(&self, local: DVec3) -> f64 {
        let beyond = |axis: DVec3| (axis.dot(local - self.centre).abs() - 0.5) / axis.length();
        beyond(self.across).max(beyond(self.down)).abs() / self.size()
    }

    /// s for red, green and blue.
    pub fn rgb(&self, local: DVec3) -> Option<[f64; 3]> {
        Some(self.rgb_of(self.pixel(local)?))
    }

    /// s of a pixel by its row-major index, for red, green and blue where it is coloured; 0 beyond them.
    pub fn s_of(&self, index: usize) -> f64 {
        self.pixels.get(index).map_or(0.0, |s| f64::from(*s))
    }

    pub fn rgb_of(&self, index: usize) -> [f64; 3] {
        match &self.rgb {
            Some(rgb) => rgb.get(index).map_or([0.0; 3], |rgb| rgb.map(f64::from)),
            None => [self.s_of(index); 3],
        }
    }

    /// Whether two pixels show the same.
    fn same(&self, a: usize, b: usize) -> bool {
        self.s_of(a) == self.s_of(b) && self.rgb.as_ref().is_none_or(|rgb| rgb.get(a) == rgb.get(b))
    }

    /// Red, green and blue of a display's white, if it has primaries of its own.
    pub fn primaries(&self) -> Option<[f64; 3]> {
        self.primaries
    }

    /// Whether any of it is coloured.
    pub fn is_coloured(&self) -> bool {
        self.rgb.is_some()
    }

    /// The row-major index of the pixel at a point in mesh units; none outside the picture.
    pub fn pixel(&self, local: DVec3) -> Option<usize> {
        let cell = |axis: DVec3, count: usize| {
            let x = axis.dot(local - self.centre) + 0.5;
            (0.0..=1.0).contains(&x).then(|| ((x * count as f64) as usize).min(count - 1))
        };
        let (x, y) = (cell(self.across, self.width)?, cell(self.down, self.height)?);
        Some(y * self.width + x)
    }
}

/// See [`SlideMap::alike`].
fn alike(width: usize, pixels: &[f32], rgb: Option<&[[f32; 3]]>) -> Vec<u16> {
    let same = |a: usize, b: usize| pixels[a] == pixels[b] && rgb.is_none_or(|rgb| rgb[a] == rgb[b]);
    let mut alike = vec![1u16; pixels.len()];
    for at in (0..pixels.len()).rev().filter(|at| (at + 1) % width != 0) {
        if same(at, at + 1) {
            alike[at] = alike[at + 1].saturating_add(1);
        }
    }
    alike
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 × 2 pixels of 2.5 × 3 units about (10, 20, 30), right along +z, up along −x.
    fn slide() -> Slide {
        Slide {
            name: "lcd".into(),
            file: "lcd.png".into(),
            width: 4,
            height: 2,
            pixels: Arc::new((0..8).map(|k| k as f32 / 8.0).collect()),
            rgb: None,
            centre: DVec3::new(10.0, 20.0, 30.0),
            u: DVec3::Z,
            v: DVec3::NEG_X,
            size: [10.0, 6.0],
            transmittance: 0.06,
            contrast: 300.0,
            polarisation: None,
            primaries: None,
        }
    }

    #[test]
    fn pixels_lie_where_they_were_authored() {
        let map = SlideMap::build(&slide()).unwrap();
        for y in 0..2 {
            for x in 0..4 {
                for (dx, dy) in [(0.01, 0.01), (0.5, 0.5), (0.99, 0.99)] {
                    let right = (x as f64 + dx) * 2.5 - 5.0;
                    let up = 3.0 - (y as f64 + dy) * 3.0;
                    // The distance from the slide's plane (y) does not matter.
                    let point = DVec3::new(10.0 - up, 20.3, 30.0 + right);
                    assert_eq!(map.s(point), Some((y * 4 + x) as f64 / 8.0), "{x} {y}");
                }
            }
        }
        for (x, z) in [(13.01, 30.0), (6.99, 30.0), (10.0, 35.01), (10.0, 24.99), (f64::NAN, 30.0)] {
            assert_eq!(map.s(DVec3::new(x, 20.0, z)), None);
        }
        // The rim belongs to the picture.
        assert_eq!(map.s(DVec3::new(13.0, 20.0, 35.0)), Some(7.0 / 8.0));
        assert_eq!((map.t_white(), map.contrast()), (0.06, 300.0));
        assert!((map.t_black() - 2e-4).abs() < 1e-18);
        assert_eq!(SlideMap::build(&Slide { contrast: f64::INFINITY, ..slide() }).unwrap().t_black(), 0.0);
    }

    #[test]
    fn broken_slides_are_faults() {
        let broken = [
            Slide { width: 3, ..slide() },
            Slide { width: 0, height: 0, pixels: Arc::new(vec![]), ..slide() },
            Slide { pixels: Arc::new(vec![f32::NAN; 8]), ..slide() },
            Slide { pixels: Arc::new(vec![1.5; 8]), ..slide() },
            Slide { transmittance: 1.1, ..slide() },
            Slide { contrast: 0.5, ..slide() },
            Slide { contrast: f64::NAN, ..slide() },
            Slide { size: [0.0, 1.0], ..slide() },
            Slide { size: [1.0, f64::INFINITY], ..slide() },
        ];
        for slide in broken {
            let text = SlideMap::build(&slide).unwrap_err().to_string();
            assert!(text.starts_with("lcd.png: slide `lcd`") && text.contains("expected"), "{text}");
        }
    }
}
