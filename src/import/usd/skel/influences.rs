//! Which joints move a point, and by how much: `skel:jointIndices` and `skel:jointWeights`.

use super::super::attribute::PrimView;
use super::super::caches::Skeleton;
use super::super::reader::Reader;
use super::super::skel_binding::{Bound, Inherited, name_of};
use super::super::value;
use super::saying;
use super::skeleton::affine;
use eyebox_base::error::{Result, nearest_name};
use glam::DAffine3;

/// Of all points of a mesh.
#[derive(Debug)]
pub(super) struct Influences {
    /// Joints of the skeleton; none where the skeleton has no such joint.
    joints: Vec<Option<usize>>,
    weights: Vec<f64>,
    /// Influences of a point.
    each: usize,
    /// The same ones for all points.
    is_rigid: bool,
    /// Mesh → skeleton when it was bound.
    pub geom_bind: DAffine3,
}

impl Influences {
    /// None, with a warning, if their numbers do not fit the mesh: it is not bent then, as in USD.
    ///
    /// # Errors
    /// Values of other types than the schema's; joints that are out of range; weights that are negative or not finite.
    pub fn read(
        reader: &mut Reader,
        view: &PrimView,
        inherited: &Inherited,
        skeleton: &Skeleton,
        points: usize,
    ) -> Result<Option<Influences>> {
        let (Some(by), Some(weigher)) =
            (saying(reader, inherited, Bound::Indices)?, saying(reader, inherited, Bound::Weights)?)
        else {
            return Ok(None);
        };
        let (name, weights_name) = (name_of(Bound::Indices), name_of(Bound::Weights));
        let indices = by.read(name, "int[]", value::ints)?.unwrap_or_default();
        let weights = weigher.read(weights_name, "float[]", value::wide_numbers)?.unwrap_or_default();
        reader.charge(view.path(), indices.len() + weights.len(), 24)?;
        let each = by.property_number(name, "elementSize")?.unwrap_or(1).max(1);
        let is_rigid = by.property_text(name, "interpolation")?.as_deref().unwrap_or("constant") == "constant";
        let wanted = if is_rigid { Some(each) } else { each.checked_mul(points) };
        if Some(indices.len()) != wanted || weights.len() != indices.len() {
            let text = format!(
                "{} joints and {} weights for {points} points, {each} each: the mesh is not bent",
                indices.len(),
                weights.len()
            );
            reader.ledger.warn(by.at_property(name), text);
            return Ok(None);
        }
        method(reader, inherited)?;
        let order = order(reader, inherited, skeleton)?;
        let mut joints = Vec::with_capacity(indices.len());
        for (place, (&index, &weight)) in indices.iter().zip(&weights).enumerate() {
            let point = place / each;
            if !(weight >= 0.0 && weight.is_finite()) {
                let fault = weigher.fault_in(weights_name, format!("point {point} has a weight of {weight}"));
                return Err(fault.expected("finite weights from 0"));
            }
            let joint = usize::try_from(index).ok().and_then(|index| order.get(index));
            joints.push(match joint {
                Some(joint) => *joint,
                None if weight == 0.0 => None,
                None => {
                    let fault = by.fault_in(name, format!("point {point} names joint {index}"));
                    let most = order.len().saturating_sub(1);
                    return Err(fault.expected(format!("0 to {most}, the joints of the skeleton or of `skel:joints`")));
                }
            });
        }
        let geom_bind = match saying(reader, inherited, Bound::GeomBind)? {
            Some(by) => {
                let read = by.read(name_of(Bound::GeomBind), "a matrix4d", |found| value::matrix(&found))?;
                read.map_or(DAffine3::IDENTITY, |matrix| affine(&matrix))
            }
            None => DAffine3::IDENTITY,
        };
        Ok(Some(Influences { joints, weights, each, is_rigid, geom_bind }))
    }

    /// Joints and weights of a point.
    pub fn of(&self, point: usize) -> impl Iterator<Item = (usize, f64)> {
        let start = if self.is_rigid { 0 } else { point.saturating_mul(self.each) };
        let range = start..start.saturating_add(self.each);
        let joints = self.joints.get(range.clone()).unwrap_or_default();
        let weights = self.weights.get(range).unwrap_or_default();
        joints.iter().zip(weights).filter_map(|(joint, weight)| Some(((*joint)?, *weight)))
    }
}

/// The joints that indices count: those of `skel:joints`, else the skeleton's own.
fn order(reader: &mut Reader, inherited: &Inherited, skeleton: &Skeleton) -> Result<Vec<Option<usize>>> {
    let Some(by) = saying(reader, inherited, Bound::Joints)? else {
        return Ok((0..skeleton.joints.len()).map(Some).collect());
    };
    let name = name_of(Bound::Joints);
    let names = by.tokens(name)?.unwrap_or_default();
    let found: Vec<Option<usize>> = names.iter().map(|name| skeleton.by_path.get(name).copied()).collect();
    if let Some((missing, _)) = names.iter().zip(&found).find(|(_, found)| found.is_none()) {
        let near = nearest_name(missing, skeleton.joints.iter().take(1024).map(String::as_str));
        let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
        let text = format!("the skeleton has no joint `{}`: it moves nothing{near}", missing.escape_debug());
        reader.ledger.warn(by.at_property(name), text);
    }
    Ok(found)
}

/// Says what becomes of another way of skinning than ours.
fn method(reader: &mut Reader, inherited: &Inherited) -> Result<()> {
    let Some(by) = saying(reader, inherited, Bound::Method)? else { return Ok(()) };
    let name = name_of(Bound::Method);
    match by.token(name)?.as_deref() {
        None | Some("classicLinear") => {}
        Some("dualQuaternion") => {
            reader.ledger.warn(by.at_property(name), "`dualQuaternion` is not there yet: points are blended linearly");
        }
        Some(other) => {
            let known = ["classicLinear", "dualQuaternion"];
            let fault = by.fault_in(name, format!("the skinning method `{}`", other.escape_debug()));
            return Err(fault.expected("classicLinear or dualQuaternion").nearest(other, known));
        }
    }
    Ok(())
}
