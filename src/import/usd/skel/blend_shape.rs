//! Blend shapes: weighted offsets of points and normals, through the shapes in between (UsdSkelBlendShape).

use super::super::attribute::PrimView;
use super::super::caches::Skeleton;
use super::super::reader::Reader;
use super::super::skel_binding::{Bound, Inherited, name_of};
use super::super::value;
use super::{saying, view_at};
use eyebox_base::error::Result;
use glam::DVec3;

const INBETWEEN: &str = "inbetweens:";
const NORMALS: &str = ":normalOffsets";

/// One shape on the way from nothing to the full one.
struct Step {
    weight: f64,
    offsets: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
}

/// Adds the offsets of all shapes with a weight to the points; the offsets of the normals of the points, if there are any.
///
/// # Errors
/// Values of other types than the schema's.
pub(super) fn apply(
    reader: &mut Reader,
    view: &PrimView,
    inherited: &Inherited,
    skeleton: &Skeleton,
    points: &mut [DVec3],
) -> Result<Option<Vec<DVec3>>> {
    let (Some(by), Some(led)) =
        (saying(reader, inherited, Bound::BlendShapes)?, saying(reader, inherited, Bound::BlendShapeTargets)?)
    else {
        return Ok(None);
    };
    let names = by.tokens(name_of(Bound::BlendShapes))?.unwrap_or_default();
    let targets = led.targets(name_of(Bound::BlendShapeTargets))?;
    if names.len() != targets.len() {
        let text = format!("{} targets for {} blend shapes: not used, as in USD", targets.len(), names.len());
        reader.ledger.warn(led.at_property(name_of(Bound::BlendShapeTargets)), text);
        return Ok(None);
    }
    let mut normals: Option<Vec<DVec3>> = None;
    for (name, path) in names.iter().zip(&targets) {
        let Some(weight) = skeleton.shapes.get(name).copied().filter(|weight| *weight != 0.0) else { continue };
        if !weight.is_finite() {
            let text = format!("the weight of the blend shape `{}` is not finite: not used", name.escape_debug());
            reader.ledger.warn(view.at(), text);
            continue;
        }
        let Some(shape) = view_at(reader, &led, name_of(Bound::BlendShapeTargets), path)? else { continue };
        let indices = shape.read("pointIndices", "int[]", value::integers)?;
        let steps = steps(reader, &shape)?;
        let Some((upper, share)) = about(&steps, weight) else { continue };
        let (Some(from), Some(to)) = (steps.get(upper - 1), steps.get(upper)) else { continue };
        for (step, factor) in [(from, 1.0 - share), (to, share)] {
            add(reader, &shape, (&step.offsets, "offsets"), indices.as_deref(), factor, points)?;
            if !step.normals.is_empty() {
                let all = normals.get_or_insert_with(|| vec![DVec3::ZERO; points.len()]);
                add(reader, &shape, (&step.normals, "normalOffsets"), indices.as_deref(), factor, all)?;
            }
        }
    }
    Ok(normals)
}

/// Offsets of all points, with what they count at the moment.
pub(super) struct Whole {
    pub name: String,
    pub weight: f64,
    pub points: Vec<DVec3>,
    pub normals: Vec<DVec3>,
}

/// All blend shapes, those in between as shapes of their own; empty where they are not used.
///
/// # Errors
/// As [`apply`].
pub(super) fn whole(
    reader: &mut Reader,
    inherited: &Inherited,
    skeleton: &Skeleton,
    count: usize,
) -> Result<Vec<Whole>> {
    let (Some(by), Some(led)) =
        (saying(reader, inherited, Bound::BlendShapes)?, saying(reader, inherited, Bound::BlendShapeTargets)?)
    else {
        return Ok(Vec::new());
    };
    let names = by.tokens(name_of(Bound::BlendShapes))?.unwrap_or_default();
    let targets = led.targets(name_of(Bound::BlendShapeTargets))?;
    let mut out = Vec::new();
    if names.len() != targets.len() {
        return Ok(out);
    }
    for (name, path) in names.iter().zip(&targets) {
        let weight = skeleton.shapes.get(name).copied().filter(|weight| weight.is_finite()).unwrap_or(0.0);
        let Some(shape) = view_at(reader, &led, name_of(Bound::BlendShapeTargets), path)? else { continue };
        let indices = shape.read("pointIndices", "int[]", value::integers)?;
        let steps = steps(reader, &shape)?;
        let Some((upper, share)) = about(&steps, weight) else { continue };
        for (number, step) in steps.iter().enumerate().filter(|(_, step)| step.weight != 0.0) {
            reader.charge(shape.path(), count, 2 * size_of::<DVec3>())?;
            let mut own = Whole {
                name: if step.weight == 1.0 { name.clone() } else { format!("{name}_{}", step.weight) },
                weight: if number == upper {
                    share
                } else if number + 1 == upper {
                    1.0 - share
                } else {
                    0.0
                },
                points: vec![DVec3::ZERO; count],
                normals: vec![DVec3::ZERO; count],
            };
            add(reader, &shape, (&step.offsets, "offsets"), indices.as_deref(), 1.0, &mut own.points)?;
            add(reader, &shape, (&step.normals, "normalOffsets"), indices.as_deref(), 1.0, &mut own.normals)?;
            out.push(own);
        }
    }
    Ok(out)
}

/// The upper of the two shapes on either side of a weight, and how much it counts against the one below; beyond the last one
/// the line through the last two goes on.
fn about(steps: &[Step], weight: f64) -> Option<(usize, f64)> {
    let upper = steps
        .partition_point(|step| step.weight <= weight)
        .clamp(1, steps.len().checked_sub(1).filter(|last| *last > 0)?);
    let (from, to) = (steps.get(upper - 1)?, steps.get(upper)?);
    Some((upper, (weight - from.weight) / (to.weight - from.weight)))
}

/// The shapes of one blend shape by their weights: nothing at 0, the full one at 1, those in between.
fn steps(reader: &mut Reader, shape: &PrimView) -> Result<Vec<Step>> {
    let read = |name: &str| shape.read(name, "vector3f[]", value::wide_triples).map(Option::unwrap_or_default);
    let mut out = vec![
        Step { weight: 0.0, offsets: Vec::new(), normals: Vec::new() },
        Step { weight: 1.0, offsets: read("offsets")?, normals: read("normalOffsets")? },
    ];
    let names = shape.property_names().iter().filter(|name| name.starts_with(INBETWEEN) && !name.ends_with(NORMALS));
    for name in names {
        let weight = shape.property_value(name, "weight")?.as_ref().and_then(value::number);
        let Some(weight) = weight.filter(|weight| weight.is_finite() && out.iter().all(|step| step.weight != *weight))
        else {
            let text = "a shape in between without a weight of its own: not used, as in USD";
            reader.ledger.warn(shape.at_property(name), text);
            continue;
        };
        let step = Step { weight, offsets: read(name)?, normals: read(&format!("{name}{NORMALS}"))? };
        reader.charge(shape.path(), step.offsets.len() + step.normals.len(), 24)?;
        out.push(step);
    }
    out.sort_by(|a, b| a.weight.total_cmp(&b.weight));
    Ok(out)
}

/// Adds `factor` times the offsets to all points, or to those that `indices` name.
fn add(
    reader: &mut Reader,
    shape: &PrimView,
    (offsets, name): (&[[f64; 3]], &str),
    indices: Option<&[i64]>,
    factor: f64,
    points: &mut [DVec3],
) -> Result<()> {
    if factor == 0.0 || offsets.is_empty() {
        return Ok(());
    }
    // Time more than memory: all shapes of a mesh may be one and the same.
    reader.charge(shape.path(), offsets.len(), 1)?;
    let indices = indices.filter(|indices| !indices.is_empty());
    let wanted = indices.map_or(points.len(), <[i64]>::len);
    if offsets.len() != wanted {
        let text = format!("{} {name} for {wanted} points: not used, as in USD", offsets.len());
        reader.ledger.warn(shape.at(), text);
        return Ok(());
    }
    let mut outside = 0usize;
    for (place, &offset) in offsets.iter().enumerate() {
        let point = indices.map_or(Some(place), |indices| usize::try_from(*indices.get(place)?).ok());
        match point.and_then(|point| points.get_mut(point)) {
            Some(point) => *point += DVec3::from(offset) * factor,
            None => outside += 1,
        }
    }
    if outside > 0 {
        let text = format!("{outside} `pointIndices` name no point: left out");
        reader.ledger.warn(shape.at_property("pointIndices"), text);
    }
    Ok(())
}
