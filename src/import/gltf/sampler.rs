//! The curves of animations: values between key frames (glTF 2.0, section 3.11 and appendix C).

use super::accessor::{Accessor, Component, Document};
use super::at::At;
use super::notes::Ledger;
use super::primitive::open;
use eyebox_base::error::Result;
use glam::DVec4;
use std::collections::HashSet;

/// How values follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// What a curve is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Three numbers that are mixed one by one.
    Vector,
    /// Quaternions, mixed along the shorter way round.
    Rotation,
    /// Numbers of morph targets, each an element of its own.
    Weights,
}

impl Kind {
    /// Numbers of an element.
    fn lanes(self) -> usize {
        match self {
            Kind::Vector => 3,
            Kind::Rotation => 4,
            Kind::Weights => 1,
        }
    }
}

/// Where the moment is among the keys.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Key(usize),
    /// After this key, by this share of the way to the next, which is so many seconds.
    After(usize, f64, f64),
}

/// The times of samplers that were looked through already: samplers share them.
#[derive(Debug, Default)]
pub(super) struct Checked(HashSet<String>);

/// `width` numbers of the sampler `at` at `time_s`; before its first key and after its last, those of that key.
///
/// # Errors
/// Times that do not increase; values of another type or number; what is not finite.
pub(super) fn value(
    document: &Document<'_>,
    at: &At<'_>,
    (kind, width, time_s): (Kind, usize, f64),
    checked: &mut Checked,
    ledger: &mut Ledger,
) -> Result<Vec<f64>> {
    let interpolation = match at.get("interpolation")? {
        None => Interpolation::Linear,
        Some(name) => match name.text()? {
            "STEP" => Interpolation::Step,
            "LINEAR" => Interpolation::Linear,
            "CUBICSPLINE" => Interpolation::CubicSpline,
            other => {
                let names = ["STEP", "LINEAR", "CUBICSPLINE"];
                return Err(name.fault("unknown interpolation").expected(names.join(", ")).nearest(other, names));
            }
        },
    };
    let times = times(document, &at.want("input")?, checked, ledger)?;
    let output = at.want("output")?;
    let values = open(document, &output, &[kind.lanes()], ledger)?;
    if values.component != Component::F32 && !values.normalized {
        let fault = values.at.want("componentType")?.fault("animated values of this component type");
        return Err(fault.expected("5126 (float), or normalised integers"));
    }
    let elements = width / kind.lanes();
    let rows = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let wanted = times.count.checked_mul(rows).and_then(|rows| rows.checked_mul(elements));
    if wanted != Some(values.count) {
        let what = format!("{} values for {} keys", values.count, times.count);
        return Err(output.fault(what).expected(format!("{} for each", rows * elements)));
    }
    ledger.budget.charge(&output, width, 4 * size_of::<f64>())?;
    let row = |row: usize| -> Result<Vec<f64>> {
        let mut out = Vec::with_capacity(width);
        for element in row * elements..(row + 1) * elements {
            let lanes: [f32; 4] = values.floats(element);
            out.extend(lanes.into_iter().take(values.lanes).map(f64::from));
        }
        if out.iter().all(|x| x.is_finite()) {
            return Ok(out);
        }
        Err(values.at.fault(format!("an animated value that is not finite, in row {row}")).expected("finite numbers"))
    };
    match (interpolation, place(&times, time_s)) {
        (Interpolation::Step | Interpolation::Linear, Place::Key(key)) => row(key),
        (Interpolation::CubicSpline, Place::Key(key)) => row(3 * key + 1),
        (Interpolation::Step, Place::After(key, ..)) => row(key),
        (Interpolation::Linear, Place::After(key, share, _)) => {
            let (from, to) = (row(key)?, row(key + 1)?);
            Ok(match kind {
                Kind::Vector | Kind::Weights => {
                    from.iter().zip(&to).map(|(a, b)| a * (1.0 - share) + b * share).collect()
                }
                Kind::Rotation => slerp(&from, &to, share),
            })
        }
        (Interpolation::CubicSpline, Place::After(key, share, seconds)) => {
            let (from, leaving) = (row(3 * key + 1)?, row(3 * key + 2)?);
            let (arriving, to) = (row(3 * key + 3)?, row(3 * key + 4)?);
            let weights = hermite(share, seconds);
            let mixed = |i: usize| {
                let of = |row: &[f64]| row.get(i).copied().unwrap_or(0.0);
                let [a, b, c, d] = weights;
                a * of(&from) + b * of(&leaving) + c * of(&to) + d * of(&arriving)
            };
            Ok((0..width).map(mixed).collect())
        }
    }
}

/// The times of the keys of a sampler, seconds; of one with steps also the last moments before them.
///
/// # Errors
/// As [`value`].
pub(super) fn moments(document: &Document<'_>, at: &At<'_>, ledger: &mut Ledger) -> Result<Vec<f64>> {
    let times = times(document, &at.want("input")?, &mut Checked::default(), ledger)?;
    ledger.budget.charge(at, times.count, 4 * size_of::<f64>())?;
    let steps = at.get("interpolation")?.is_some_and(|name| name.json == "STEP");
    let mut out = Vec::with_capacity(if steps { 2 * times.count } else { times.count });
    for key in 0..times.count {
        let [time] = times.floats::<1>(key);
        if steps && key > 0 {
            // The next number of single precision, which glTF's times are of.
            out.push(f64::from(time.next_down()));
        }
        out.push(f64::from(time));
    }
    // Exporters write the same value for every frame of a range: one of them says all.
    if is_constant(document, at, times.count, ledger)? {
        out.truncate(1);
    }
    Ok(out)
}

/// Whether a curve of straight pieces or steps has one value at all of its `count` keys.
fn is_constant(document: &Document<'_>, at: &At<'_>, count: usize, ledger: &mut Ledger) -> Result<bool> {
    if at.get("interpolation")?.is_some_and(|name| !["STEP", "LINEAR"].iter().any(|plain| name.json == plain)) {
        return Ok(false);
    }
    let output = open(document, &at.want("output")?, &[1, 3, 4], ledger)?;
    let width = output.count / count.max(1);
    let alike = |a: usize, b: usize| match output.lanes {
        1 => output.floats::<1>(a) == output.floats::<1>(b),
        3 => output.floats::<3>(a) == output.floats::<3>(b),
        _ => output.floats::<4>(a) == output.floats::<4>(b),
    };
    Ok(width > 0 && output.count == width * count && (width..output.count).all(|index| alike(index, index % width)))
}

/// The times of a sampler, seconds.
fn times<'d>(
    document: &'d Document<'_>,
    reference: &At<'_>,
    checked: &mut Checked,
    ledger: &mut Ledger,
) -> Result<Accessor<'d>> {
    let times = open(document, reference, &[1], ledger)?;
    if times.component != Component::F32 {
        let fault = times.at.want("componentType")?.fault("times of this component type");
        return Err(fault.expected("5126 (float)"));
    }
    if !checked.0.insert(times.at.pointer.clone()) {
        return Ok(times);
    }
    ledger.budget.charge(reference, 1, times.at.pointer.len())?;
    let mut before = f32::NEG_INFINITY;
    for key in 0..times.count {
        let [time] = times.floats::<1>(key);
        if !(time > before && time.is_finite()) {
            let what = format!("key {key} is at {time} s, the one before it at {before} s");
            return Err(times.at.fault(what).expected("finite times, each after the one before it"));
        }
        before = time;
    }
    Ok(times)
}

fn place(times: &Accessor<'_>, time_s: f64) -> Place {
    let time = |key: usize| f64::from(times.floats::<1>(key)[0]);
    let last = times.count.saturating_sub(1);
    if time_s <= time(0) {
        return Place::Key(0);
    }
    if time_s >= time(last) {
        return Place::Key(last);
    }
    // The last key that is not after the moment.
    let (mut low, mut high) = (0, last);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if time(middle) <= time_s {
            low = middle;
        } else {
            high = middle;
        }
    }
    let seconds = time(high) - time(low);
    match (time_s - time(low)) / seconds {
        0.0 => Place::Key(low),
        share => Place::After(low, share, seconds),
    }
}

/// What a key, the tangent that leaves it, the next key and the tangent that arrives there count for (appendix C.5).
fn hermite(t: f64, seconds: f64) -> [f64; 4] {
    let (square, cube) = (t * t, t * t * t);
    [
        2.0 * cube - 3.0 * square + 1.0,
        seconds * (cube - 2.0 * square + t),
        3.0 * square - 2.0 * cube,
        seconds * (cube - square),
    ]
}

/// Spherical linear interpolation along the shorter of the two ways (appendix C.4).
fn slerp(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    let four = |x: &[f64]| DVec4::from_slice(&[x, &[0.0; 4]].concat()).normalize_or_zero();
    let (from, to) = (four(from), four(to));
    // q and −q are the same rotation.
    let to = if from.dot(to) < 0.0 { -to } else { to };
    // By both the sum and the difference, the angle is exact for small ones and for large ones.
    let angle = 2.0 * (to - from).length().atan2((to + from).length());
    let sine = angle.sin();
    let mixed = if sine > 0.0 {
        from * (((1.0 - share) * angle).sin() / sine) + to * ((share * angle).sin() / sine)
    } else {
        from
    };
    mixed.to_array().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn by 80° about z, taken by a quarter: 20°; from the other sign of the same rotation, too.
    #[test]
    fn slerp_turns_evenly_and_the_short_way() {
        let turn = |degrees: f64| {
            let (sine, cosine) = (degrees.to_radians() / 2.0).sin_cos();
            [0.0, 0.0, sine, cosine]
        };
        let want = turn(20.0);
        for end in [turn(80.0), turn(80.0).map(|x| -x)] {
            let found = slerp(&turn(0.0), &end, 0.25);
            assert!(found.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?} {want:?}");
        }
        assert_eq!(slerp(&turn(0.0), &turn(0.0), 0.3), turn(0.0));
        // Much less than what a cosine can tell from 1.
        let found = slerp(&turn(0.0), &turn(1e-10), 0.5);
        assert!((found[2] / turn(5e-11)[2] - 1.0).abs() < 1e-12);
    }

    /// Tangents of the curve t³ at its ends give t³ back, on a span of two seconds.
    #[test]
    fn a_spline_through_a_cubic_is_the_cubic() {
        let [a, b, c, d] = hermite(0.25, 2.0);
        let cubic = |x: f64| x * x * x;
        let slope = |x: f64| 3.0 * x * x;
        let found = a * cubic(1.0) + b * slope(1.0) + c * cubic(3.0) + d * slope(3.0);
        assert!((found - cubic(1.5)).abs() < 1e-13, "{found}");
    }
}
