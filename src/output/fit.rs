//! Pictures of another size on a frame: how they are laid over it, and by which filter their pixels are made.

use eyebox_film::still::{Light, Still};

/// How a picture of another size is laid over a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// All of it, as large as it goes; black beside it.
    Contain,
    /// All of the frame, with what hangs over cut off.
    Cover,
    /// To the frame's width and height, whatever that does to its shape.
    Stretch,
    /// In the middle, pixel for pixel.
    Centre,
}

impl Fit {
    pub const ALL: [Fit; 4] = [Fit::Contain, Fit::Cover, Fit::Stretch, Fit::Centre];

    pub fn name(self) -> &'static str {
        match self {
            Fit::Contain => "contain",
            Fit::Cover => "cover",
            Fit::Stretch => "stretch",
            Fit::Centre => "centre",
        }
    }

    /// Width and height that a picture is resized to.
    fn size(self, from: [usize; 2], to: [usize; 2]) -> [usize; 2] {
        let scales = [0, 1].map(|axis| to[axis] as f64 / from[axis].max(1) as f64);
        let scale = match self {
            Fit::Contain => scales[0].min(scales[1]),
            Fit::Cover => scales[0].max(scales[1]),
            Fit::Stretch => return to,
            Fit::Centre => return from,
        };
        from.map(|n| ((n as f64 * scale).round() as usize).max(1))
    }
}

/// What a resized picture's pixels are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resize {
    /// The mean over the area of each pixel: keeps light, and repeats pixels where it enlarges.
    Area,
    /// A tent over two of the coarser pixels: smooth where it enlarges.
    Linear,
}

impl Resize {
    pub const ALL: [Resize; 2] = [Resize::Area, Resize::Linear];

    pub fn name(self) -> &'static str {
        match self {
            Resize::Area => "area",
            Resize::Linear => "linear",
        }
    }

    /// For each of `to` pixels, the first of `from` that it is made of and their weights, which add up to 1.
    fn weights(self, from: usize, to: usize) -> Vec<(usize, Vec<f64>)> {
        let step = from as f64 / to.max(1) as f64;
        let of = |i: usize| {
            let weight = |j: usize| match self {
                Resize::Area => {
                    let (low, high) = (i as f64 * step, (i + 1) as f64 * step);
                    (high.min(j as f64 + 1.0) - low.max(j as f64)).max(0.0)
                }
                Resize::Linear => {
                    let centre = (i as f64 + 0.5) * step - 0.5;
                    (1.0 - (j as f64 - centre).abs() / step.max(1.0)).max(0.0)
                }
            };
            let reach = step.max(1.0) + 1.0;
            let middle = (i as f64 + 0.5) * step - 0.5;
            let first = (middle - reach).floor().max(0.0) as usize;
            let last = ((middle + reach).ceil().max(0.0) as usize).min(from.saturating_sub(1));
            let all: Vec<f64> = (first..=last).map(weight).collect();
            let sum: f64 = all.iter().sum();
            (first, all.into_iter().map(|weight| weight / sum).collect())
        };
        (0..to).map(of).collect()
    }
}

/// A picture as large as a frame of this width and height.
pub fn fitted(still: &Still, size: [usize; 2], fit: Fit, resize: Resize) -> Still {
    let from = [still.width, still.height];
    let resized = fit.size(from, size);
    let light = match &still.light {
        Light::Grey(values) => {
            let of = |pixel: usize| [f64::from(values[pixel])];
            Light::Grey(laid(&made(of, from, resized, resize), resized, size).into_iter().map(|[v]| v as f32).collect())
        }
        Light::Rgb(values) => {
            let of = |pixel: usize| values[pixel].map(f64::from);
            let all = laid(&made(of, from, resized, resize), resized, size);
            Light::Rgb(all.into_iter().map(|rgb| rgb.map(|value| value as f32)).collect())
        }
    };
    Still { width: size[0], height: size[1], light, white_cd_m2: still.white_cd_m2, remarks: Vec::new() }
}

/// The pixels of a picture at another size: rows first, then columns.
fn made<const N: usize>(
    of: impl Fn(usize) -> [f64; N],
    from: [usize; 2],
    to: [usize; 2],
    resize: Resize,
) -> Vec<[f64; N]> {
    if from == to {
        return (0..from[0] * from[1]).map(of).collect();
    }
    let [across, down] = [0, 1].map(|axis| resize.weights(from[axis], to[axis]));
    let sum = |(first, weights): &(usize, Vec<f64>), at: &dyn Fn(usize) -> [f64; N]| {
        weights.iter().enumerate().fold([0.0; N], |sum, (k, weight)| {
            let value = at(first + k);
            std::array::from_fn(|c| sum[c] + weight * value[c])
        })
    };
    let rows: Vec<[f64; N]> = (0..from[1])
        .flat_map(|y| across.iter().map(move |weights| (y, weights)))
        .map(|(y, weights)| sum(weights, &|x| of(y * from[0] + x)))
        .collect();
    let columns = down.iter().flat_map(|weights| (0..to[0]).map(move |x| (x, weights)));
    columns.map(|(x, weights)| sum(weights, &|y| rows[y * to[0] + x])).collect()
}

/// A picture in the middle of another size: cut, or with black about it.
fn laid<const N: usize>(pixels: &[[f64; N]], from: [usize; 2], to: [usize; 2]) -> Vec<[f64; N]> {
    let source = |at: usize, axis: usize| {
        let shift = (from[axis] as i64 - to[axis] as i64).div_euclid(2);
        usize::try_from(at as i64 + shift).ok().filter(|at| *at < from[axis])
    };
    let at = |pixel: usize| {
        let (x, y) = (source(pixel % to[0], 0), source(pixel / to[0], 1));
        x.zip(y).map_or([0.0; N], |(x, y)| pixels[y * from[0] + x])
    };
    (0..to[0] * to[1]).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: usize, height: usize, values: Vec<f32>) -> Still {
        Still { width, height, light: Light::Grey(values), white_cd_m2: None, remarks: Vec::new() }
    }

    fn of(still: &Still, size: [usize; 2], fit: Fit, resize: Resize) -> Vec<f32> {
        match fitted(still, size, fit, resize).light {
            Light::Grey(values) => values,
            Light::Rgb(_) => panic!("grey stays grey"),
        }
    }

    #[test]
    fn laid_over_a_frame() {
        let wide = grey(4, 2, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(of(&wide, [2, 1], Fit::Stretch, Resize::Area), [3.5, 5.5]);
        assert_eq!(of(&wide, [2, 2], Fit::Centre, Resize::Area), [2.0, 3.0, 6.0, 7.0]);
        assert_eq!(of(&wide, [2, 2], Fit::Cover, Resize::Area), [2.0, 3.0, 6.0, 7.0]);
        assert_eq!(of(&wide, [2, 3], Fit::Contain, Resize::Area), [0.0, 0.0, 3.5, 5.5, 0.0, 0.0]);
        assert_eq!(of(&wide, [6, 2], Fit::Centre, Resize::Linear)[..6], [0.0, 1.0, 2.0, 3.0, 4.0, 0.0]);
    }

    /// Whatever is done to it, an even picture is as bright as before; values below 0 and above 1 stay what they are.
    #[test]
    fn light_is_kept() {
        for resize in Resize::ALL {
            for size in [[3, 5], [7, 2], [16, 9], [1, 1]] {
                for value in of(&grey(5, 4, vec![500.0; 20]), size, Fit::Stretch, resize) {
                    assert!((value - 500.0).abs() < 1e-3, "{resize:?} {size:?}: {value}");
                }
            }
            let edge = of(&grey(2, 1, vec![-1.0, 3.0]), [1, 1], Fit::Stretch, resize);
            assert_eq!(edge, [1.0], "{resize:?}");
        }
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
        let ramp: Vec<f32> = (0..60).map(|n| n as f32).collect();
        let shrunk = of(&grey(10, 6, ramp.clone()), [7, 5], Fit::Stretch, Resize::Area);
        assert!((mean(&shrunk) - mean(&ramp)).abs() < 1e-4);
        assert_eq!(of(&grey(2, 1, vec![0.0, 4.0]), [4, 1], Fit::Stretch, Resize::Linear), [0.0, 1.0, 3.0, 4.0]);
    }
}
