//! The quick ways through against the general one, and that against a plain one, on small random meshes.

use super::super::polygons::{Corners, Polygons, Wrong};
use super::super::primvar::{Interpolation, Primvar, Sizes};
use super::super::tests::kit::assembly;
use super::super::triangulate;
use super::carried::{Carried, Held};
use super::cut::Own;
use super::vertices::{self, Data, Scratch};
use crate::gltf::primitive::FaceMesh;
use glam::DVec3;
use proptest::prelude::*;
use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

const INTERPOLATIONS: [Interpolation; 4] =
    [Interpolation::Constant, Interpolation::Uniform, Interpolation::Vertex, Interpolation::FaceVarying];

/// Everything of a face, to the last bit.
type Bits = (Vec<[u32; 3]>, Vec<[u32; 3]>, [Vec<[u32; 2]>; 2], Vec<[u32; 4]>, Vec<[u32; 3]>);

fn bits(face: &FaceMesh) -> Bits {
    let three = |all: &[[f32; 3]]| all.iter().map(|x| x.map(f32::to_bits)).collect();
    let two = |all: &[[f32; 2]]| all.iter().map(|x| x.map(f32::to_bits)).collect();
    let colors = face.colors.iter().map(|x| x.map(f32::to_bits)).collect();
    let uvs = [two(&face.uvs), two(&face.second_uvs)];
    (three(&face.positions), three(&face.normals), uvs, colors, face.triangles.clone())
}

/// Numbers that are used up one after the other.
struct Dice<'a>(std::slice::Iter<'a, u32>);

impl Dice<'_> {
    fn below(&mut self, bound: usize) -> usize {
        self.0.next().map_or(0, |&x| x as usize % bound.max(1))
    }
    /// A few values only, so that many are the same; −0 and NaN among them.
    fn number(&mut self) -> f32 {
        [0.0, -0.0, 1.0, 0.5, -1.0, f32::NAN][self.below(6)]
    }
    fn primvar<T: Copy>(&mut self, sizes: Sizes, make: impl Fn(&mut Self) -> T) -> Option<Primvar<T>> {
        let interpolation = *INTERPOLATIONS.get(self.below(5))?;
        let count = interpolation.count(sizes);
        if self.below(2) == 0 {
            return Some(Primvar::new((0..count).map(|_| make(self)).collect(), None, interpolation));
        }
        let values: Vec<T> = (0..1 + self.below(4)).map(|_| make(self)).collect();
        let indices = (0..count).map(|_| self.below(values.len()) as i32).collect();
        Some(Primvar::new(values, Some(indices), interpolation))
    }
}

/// Points, counts, indices and the rest of a sound mesh; of triangles only, or of all kinds of polygons.
fn mesh(dice: &mut Dice, triangles: bool) -> (Data, Data) {
    let points: Vec<[f32; 3]> = (0..1 + dice.below(12)).map(|_| [0; 3].map(|_| dice.below(7) as f32 - 3.0)).collect();
    let count = dice.below(10);
    let counts: Vec<i32> = (0..count).map(|_| if triangles { 3 } else { dice.below(7) as i32 }).collect();
    let corners = counts.iter().sum::<i32>() as usize;
    let indices: Vec<i32> = (0..corners).map(|_| dice.below(points.len()) as i32).collect();
    let sizes = Sizes { points: points.len(), polygons: count, corners };
    let normals = dice.primvar(sizes, |dice| [0; 3].map(|_| dice.number()));
    let uvs = dice.primvar(sizes, |dice| [0; 2].map(|_| dice.number())).map(Rc::new);
    let second_uvs = dice.primvar(sizes, |dice| [0; 2].map(|_| dice.number())).map(Rc::new);
    let color = dice.primvar(sizes, |dice| [0; 3].map(|_| dice.number())).map(Rc::new);
    let opacity = dice.primvar(sizes, |dice| dice.number()).map(Rc::new);
    let carried = Carried { uvs, second_uvs, color, opacity };
    let mut holes: Vec<i32> = (0..[0, 0, 3][dice.below(3)]).map(|_| dice.below(12) as i32 - 1).collect();
    holes.sort_unstable();
    let left_handed = dice.below(2) == 0;
    let data = |corners: Corners| Data {
        polygons: Polygons { points: points.clone(), corners, holes: holes.clone(), left_handed },
        normals: normals.clone(),
        carried: carried.clone(),
        is_traced: false,
    };
    let quick = data(Corners::new(counts.clone(), indices.clone()).unwrap());
    let mixed = data(Corners::mixed(counts, indices).unwrap());
    (quick, mixed)
}

fn build(data: &Data, own: &Own, alone: bool) -> (Bits, usize) {
    let triangles = own.triangles(&data.polygons);
    let (face, ragged) = vertices::face(&mut data.clone(), own, alone, 0, triangles, &mut Scratch::default());
    assert_eq!(face.triangles.len(), triangles);
    (bits(&face), ragged)
}

/// As the documentation says it, with maps.
fn plainly(data: &Data) -> Bits {
    let Data { polygons, normals, carried, .. } = data;
    let points = polygons.corners.points();
    let mut corners = Vec::new();
    for polygon in (0..polygons.corners.polygons()).filter(|&polygon| !polygons.holes.contains(&(polygon as i32))) {
        let span = polygons.corners.span(polygon);
        let outline: Vec<DVec3> =
            span.clone().map(|corner| DVec3::from(polygons.points[points[corner] as usize].map(f64::from))).collect();
        let mut cut = Vec::new();
        triangulate::polygon(&outline, &mut cut);
        for [a, b, c] in cut {
            let three = if polygons.left_handed { [a, c, b] } else { [a, b, c] };
            corners.extend(three.map(|corner| (polygon, span.start + corner as usize)));
        }
    }
    let follows = normals.as_ref().is_none_or(Primvar::follows_points) && carried.follows_points();
    let key = |&(polygon, corner): &(usize, usize)| {
        let point = points[corner] as usize;
        let normal = normals.as_ref().map(|all| all.at(polygon, corner, point).unwrap().map(f32::to_bits));
        let uv = |all: &Held<[f32; 2]>| Some(all.as_ref()?.at(polygon, corner, point).unwrap().map(f32::to_bits));
        let color = carried.has_colors().then(|| carried.colour(polygon, corner, point).map(f32::to_bits));
        (point, normal, uv(&carried.uvs), uv(&carried.second_uvs), color)
    };
    let mut order: Vec<_> = Vec::new();
    if follows {
        order.extend(corners.iter().map(key).collect::<BTreeSet<_>>());
    } else {
        let mut met = BTreeSet::new();
        order.extend(corners.iter().map(key).filter(|key| met.insert(*key)));
    }
    let place: HashMap<_, u32> = order.iter().enumerate().map(|(i, key)| (*key, i as u32)).collect();
    let all: Vec<u32> = corners.iter().map(|corner| place[&key(corner)]).collect();
    let positions = order.iter().map(|key| polygons.points[key.0].map(f32::to_bits)).collect();
    let normals = order.iter().filter_map(|key| key.1).collect();
    let uvs = [order.iter().filter_map(|key| key.2).collect(), order.iter().filter_map(|key| key.3).collect()];
    let colors = order.iter().filter_map(|key| key.4).collect();
    (positions, normals, uvs, colors, all.as_chunks().0.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(4000) })]

    #[test]
    fn all_ways_lead_to_the_same_face(rolls in prop::collection::vec(any::<u32>(), 300), triangles: bool) {
        let (quick, mixed) = mesh(&mut Dice(rolls.iter()), triangles);
        let listed = Own::Some(Own::All.drawn(&mixed.polygons).map(|polygon| polygon as u32).collect());
        let wanted = build(&mixed, &listed, false);
        prop_assert_eq!(&wanted.0, &plainly(&mixed));
        for data in [&quick, &mixed] {
            for alone in [true, false] {
                prop_assert_eq!(&build(data, &Own::All, alone), &wanted);
                prop_assert_eq!(&build(data, &listed, alone), &wanted);
            }
        }
        prop_assert!(matches!(quick.polygons.corners, Corners::Triangles(_)) || !triangles);
    }

    /// Counts and indices that fit neither each other nor the points.
    #[test]
    fn broken_arrays_are_refused_alike(
        counts in prop::collection::vec(prop_oneof![8 => Just(3), 1 => -2..6, 1 => any::<i32>()], 0..6),
        indices in prop::collection::vec(prop_oneof![20 => 0..6, 1 => any::<i32>()], 0..19),
        points in 0..7usize,
    ) {
        let quick = Corners::new(counts.clone(), indices.clone());
        let mixed = Corners::mixed(counts.clone(), indices.clone());
        prop_assert_eq!(quick.as_ref().err(), mixed.as_ref().err());
        let negative = counts.iter().position(|&count| count < 0);
        let counted = counts.iter().map(|&count| i64::from(count)).sum::<i64>().min(i64::from(u32::MAX)) as u32;
        let wanted = match negative {
            Some(polygon) => Some(Wrong::Negative { polygon, count: counts[polygon] }),
            None if counted as usize != indices.len() => Some(Wrong::Corners { counted, indices: indices.len() }),
            None => None,
        };
        prop_assert_eq!(quick.as_ref().err().copied(), wanted);
        if let (Ok(quick), Ok(mixed)) = (quick, mixed) {
            let bad = indices.iter().copied().find(|&index| index < 0 || index as usize >= points);
            prop_assert_eq!((quick.outside(points), mixed.outside(points)), (bad, bad));
            prop_assert_eq!((quick.polygons(), quick.points()), (mixed.polygons(), mixed.points()));
            for polygon in 0..quick.polygons() {
                prop_assert_eq!(quick.span(polygon), mixed.span(polygon));
            }
        }
    }
}

/// The first mesh of a size is hashed only when a second one comes.
#[test]
fn meshes_are_shared_whatever_comes_between() {
    let mesh = |parent: &str, z: &str, more: &str| {
        format!(
            r#"def Xform "{parent}" {{ def Mesh "M" {{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3{more}]
    int[] faceVertexIndices = [0, 1, 2{}]
    point3f[] points = [(0, 0, {z}), (1, 0, 0), (0, 1, 0)]
    normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1)]
}} }}
"#,
            if more.is_empty() { "" } else { ", 2, 1, 0" }
        )
    };
    let parts =
        [("A", "0", ""), ("B", "0", ", 3"), ("C", "0.1", ""), ("D", "0", ""), ("E", "0.1", ""), ("F", "-0", "")];
    let found = assembly(&parts.map(|(parent, z, more)| mesh(parent, z, more)).concat());
    let of: Vec<usize> = found.nodes.iter().filter_map(|node| node.mesh).collect();
    assert_eq!((of, found.meshes.len()), (vec![0, 1, 2, 0, 2, 3], 4));
}
