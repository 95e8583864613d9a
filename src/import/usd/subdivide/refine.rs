//! Refining with the crate: values go from level to level in f64, then onto the limit surface.

use super::super::polygons::{Corners, Polygons};
use super::super::primvar::{Interpolation, Primvar};
use super::cage::Cage;
use super::normals::Rings;
use super::{Fine, Scheme, corners_of};
use opensubdiv_rs::far::{
    FVarChannelDescriptor, PrimvarRefiner, TopologyDescriptor, TopologyRefiner, TopologyRefinerFactory, UniformOptions,
};
use opensubdiv_rs::sdc::{FVarLinearInterpolation, Options, SchemeType};
use std::collections::HashMap;

/// A primvar by corners, each different value of a point once.
#[derive(Debug, Default)]
struct Channel {
    values: Vec<[f64; 3]>,
    indices: Vec<u32>,
}

/// The cage at `level`, on its limit surface; or why there is none.
pub(super) fn refined(
    cage: &Cage,
    scheme: Scheme,
    level: usize,
    polygons: &Polygons,
    primvars: &[Primvar<[f32; 3]>],
) -> Result<Fine, String> {
    let of = |kind: Interpolation| -> Vec<Channel> {
        let all = primvars.iter().filter(|primvar| primvar.interpolation() == kind);
        all.map(|primvar| channel(cage, polygons, primvar)).collect()
    };
    let cornered = of(Interpolation::FaceVarying);
    let refiner = refiner(cage, scheme, level, polygons, cage.options, &cornered)?;
    let points: Vec<[f64; 3]> = polygons.points.iter().map(|p| p.map(f64::from)).collect();
    let control = last(&refiner, points);
    let limit = onto_limit(&refiner, &control);
    let drawn = drawn(&refiner, cage);
    let rings = Rings::new(&refiner, scheme, &control, &limit);
    let (normals, normal_indices) = rings.normals(&drawn, polygons.left_handed);
    let top = refiner.level(refiner.max_level());
    let corners = drawn.iter().flat_map(|(face, _)| top.face_vertices(*face).iter().copied());
    let parents: Vec<u32> = drawn.iter().map(|(_, parent)| *parent).collect();

    let mut cornered = last_channels(&refiner, cornered, &drawn).into_iter();
    let mut mixed = linearly(cage, scheme, level, polygons, of(Interpolation::Varying), &drawn)?.into_iter();
    let primvars = primvars.iter().filter_map(|primvar| match primvar.interpolation() {
        Interpolation::Constant => Some(primvar.clone()),
        Interpolation::Uniform => {
            let values = parents.iter().map(|parent| primvar.at(*parent as usize, 0, 0).unwrap_or_default());
            Some(Primvar::new(values.collect(), None, Interpolation::Uniform))
        }
        // As the points themselves; all others have seams of their own.
        Interpolation::Vertex => {
            let points = (0..polygons.points.len()).map(|point| primvar.at(0, 0, point).unwrap_or_default());
            let control = last(&refiner, points.map(|value| value.map(f64::from)).collect());
            Some(Primvar::new(narrow(onto_limit(&refiner, &control)), None, Interpolation::Vertex))
        }
        Interpolation::Varying => mixed.next(),
        Interpolation::FaceVarying => cornered.next(),
    });
    let primvars = primvars.collect();
    let fine: Corners = corners_of(scheme, corners.collect());
    Ok(Fine {
        polygons: Polygons {
            points: narrow(limit),
            corners: fine,
            holes: Vec::new(),
            left_handed: polygons.left_handed,
        },
        normals: Primvar::new(normals, Some(normal_indices), Interpolation::FaceVarying),
        primvars,
        parents,
    })
}

/// All levels of the cage by the rules of `options`.
fn refiner(
    cage: &Cage,
    scheme: Scheme,
    level: usize,
    polygons: &Polygons,
    options: Options,
    channels: &[Channel],
) -> Result<TopologyRefiner, String> {
    let described = channels.iter().map(|own| FVarChannelDescriptor::new(own.values.len(), &own.indices));
    let described: Vec<FVarChannelDescriptor<'_>> = described.collect();
    let descriptor = TopologyDescriptor::new(polygons.points.len(), &cage.sizes, &cage.corners)
        .with_creases(&cage.creases, &cage.crease_weights)
        .with_corners(&cage.pinned, &cage.pinned_weights)
        .with_fvar_channels(&described);
    let kind = match scheme {
        Scheme::CatmullClark => SchemeType::Catmark,
        Scheme::Loop => SchemeType::Loop,
    };
    let mut refiner = TopologyRefinerFactory::create(descriptor, kind, options).map_err(|error| error.to_string())?;
    refiner.refine_uniform(UniformOptions::new(level));
    Ok(refiner)
}

/// Channels that are mixed linearly everywhere. The rule is a refiner's, not a channel's, so they have one of their own,
/// which numbers the same faces alike.
fn linearly(
    cage: &Cage,
    scheme: Scheme,
    level: usize,
    polygons: &Polygons,
    channels: Vec<Channel>,
    drawn: &[(usize, u32)],
) -> Result<Vec<Primvar<[f32; 3]>>, String> {
    if channels.is_empty() {
        return Ok(Vec::new());
    }
    let options = cage.options.with_fvar_linear_interpolation(FVarLinearInterpolation::All);
    let refiner = refiner(cage, scheme, level, polygons, options, &channels)?;
    Ok(last_channels(&refiner, channels, drawn))
}

fn narrow(values: Vec<[f64; 3]>) -> Vec<[f32; 3]> {
    values.into_iter().map(|value| value.map(|x| x as f32)).collect()
}

/// Values of the cage's points at the last level.
fn last(refiner: &TopologyRefiner, mut values: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let interpolator = PrimvarRefiner::new(refiner);
    for level in 1..=refiner.max_level() {
        let mut finer = vec![[0.0; 3]; refiner.level(level).num_vertices()];
        interpolator.interpolate(level, &values, &mut finer);
        values = finer;
    }
    values
}

fn onto_limit(refiner: &TopologyRefiner, control: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut limit = control.to_vec();
    PrimvarRefiner::new(refiner).limit(control, &mut limit);
    limit
}

/// The faces of the last level that are drawn, each with the polygon of the file that it came from.
fn drawn(refiner: &TopologyRefiner, cage: &Cage) -> Vec<(usize, u32)> {
    let count = refiner.level(refiner.max_level()).num_faces();
    let parent = |face: usize| {
        let mut face = face;
        for level in (1..=refiner.max_level()).rev() {
            face = refiner.refinement(level).child_face_parent_face(face) as usize;
        }
        cage.kept.get(face).copied().unwrap_or(0)
    };
    let all = (0..count).map(|face| (face, parent(face)));
    all.filter(|(_, parent)| cage.undrawn.binary_search(parent).is_err()).collect()
}

/// Equal values at a point are one: a file that repeats them has no seam there.
fn channel(cage: &Cage, polygons: &Polygons, primvar: &Primvar<[f32; 3]>) -> Channel {
    let mut out = Channel::default();
    let mut known: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for polygon in &cage.kept {
        for corner in polygons.corners.span(*polygon as usize) {
            let point = polygons.corners.points().get(corner).copied().unwrap_or(0);
            let value = primvar.at(*polygon as usize, corner, point as usize).unwrap_or_default();
            let index = *known.entry((point, value.map(f32::to_bits))).or_insert_with(|| {
                out.values.push(value.map(f64::from));
                out.values.len() as u32 - 1
            });
            out.indices.push(index);
        }
    }
    out
}

/// The values of the refiner's channels on the limit surface, by the corners of the faces that are drawn.
fn last_channels(refiner: &TopologyRefiner, channels: Vec<Channel>, drawn: &[(usize, u32)]) -> Vec<Primvar<[f32; 3]>> {
    let interpolator = PrimvarRefiner::new(refiner);
    let top = refiner.level(refiner.max_level());
    let one = |(number, channel): (usize, Channel)| {
        let mut values = channel.values;
        for level in 1..=refiner.max_level() {
            let mut finer = vec![[0.0; 3]; refiner.level(level).num_fvar_values(number)];
            interpolator.interpolate_face_varying(level, number, &values, &mut finer);
            values = finer;
        }
        let mut limit = values.clone();
        interpolator.limit_face_varying(number, &values, &mut limit);
        let indices = drawn.iter().flat_map(|(face, _)| top.face_fvar_values(*face, number)).map(|index| *index as i32);
        Primvar::new(narrow(limit), Some(indices.collect()), Interpolation::FaceVarying)
    };
    channels.into_iter().enumerate().map(one).collect()
}
