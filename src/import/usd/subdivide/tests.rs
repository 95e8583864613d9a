//! Subdivision against closed forms: B-splines of quadratics, the cube's limit, creases that leave a cube a cube. And the
//! normals against themselves: those of a point of the cage are the same from every level.

use super::super::polygons::{Corners, Polygons};
use super::super::primvar::{Interpolation, Primvar};
use super::super::tests::kit::{assembly, fault, notes};
use super::cage::Cage;
use super::{Fine, Scheme, refine};
use crate::Assembly;
use glam::DVec3;
use opensubdiv_rs::sdc::{Options, VtxBoundaryInterpolation};

/// Positions of a grid of `n` × `n` quads about the origin, one apart.
fn grid(n: i32, height: impl Fn(f64, f64) -> f64) -> (Vec<[f32; 3]>, Vec<i32>, Vec<i32>) {
    let at = |i: i32| f64::from(i) - f64::from(n) / 2.0;
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let points = points.map(|(i, j)| [at(i) as f32, at(j) as f32, height(at(i), at(j)) as f32]).collect();
    let quads = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let indices: Vec<i32> = quads.flat_map(|first| [first, first + 1, first + n + 2, first + n + 1]).collect();
    (points, vec![4; (n * n) as usize], indices)
}

const CUBE: [[f32; 3]; 8] = [
    [-1., -1., -1.],
    [1., -1., -1.],
    [-1., 1., -1.],
    [1., 1., -1.],
    [-1., -1., 1.],
    [1., -1., 1.],
    [-1., 1., 1.],
    [1., 1., 1.],
];
const FACES: [i32; 24] = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];

fn cage(points: &[[f32; 3]], counts: Vec<i32>, indices: Vec<i32>) -> (Cage, Polygons) {
    let corners = Corners::mixed(counts, indices).unwrap();
    let polygons = Polygons { points: points.to_vec(), corners, holes: Vec::new(), left_handed: false };
    let sizes: Vec<usize> = (0..polygons.corners.polygons()).map(|i| polygons.corners.span(i).len()).collect();
    let cage = Cage {
        kept: (0..sizes.len() as u32).collect(),
        sizes,
        corners: polygons.corners.points().to_vec(),
        undrawn: Vec::new(),
        creases: Vec::new(),
        crease_weights: Vec::new(),
        pinned: Vec::new(),
        pinned_weights: Vec::new(),
        options: Options::new().with_vtx_boundary_interpolation(VtxBoundaryInterpolation::EdgeAndCorner),
    };
    (cage, polygons)
}

/// Positions and normals of all corners.
fn corners(fine: &Fine) -> Vec<(DVec3, DVec3)> {
    let wide = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let points = fine.polygons.corners.points().iter().enumerate();
    points.map(|(i, &p)| (wide(fine.polygons.position(p as usize)), wide(fine.normals.at(0, i, 0).unwrap()))).collect()
}

/// Cubic B-splines and box splines with control values x² are x² and a constant; its normal is (−2x, 0, 1).
#[test]
fn a_parabola_stays_one() {
    let (points, counts, quads) = grid(8, |x, _| x * x);
    let (own, polygons) = cage(&points, counts, quads.clone());
    let fine = refine::refined(&own, Scheme::CatmullClark, 3, &polygons, &[]).unwrap();
    let triangles: Vec<i32> = quads.chunks(4).flat_map(|q| [q[0], q[1], q[2], q[0], q[2], q[3]]).collect();
    let (own, polygons) = cage(&points, vec![3; triangles.len() / 3], triangles);
    let loops = refine::refined(&own, Scheme::Loop, 3, &polygons, &[]).unwrap();
    // The second moment of the cubic B-spline is 1/3; of the box spline on this lattice, along x, too.
    for fine in [fine, loops] {
        let mut seen = 0;
        for (at, normal) in corners(&fine) {
            // Two rings of the boundary follow other rules.
            if at.x.abs() > 2.0 || at.y.abs() > 2.0 {
                continue;
            }
            seen += 1;
            assert!((at.z - at.x * at.x - 1.0 / 3.0).abs() < 2e-6, "{at}");
            let want = DVec3::new(-2.0 * at.x, 0.0, 1.0).normalize();
            assert!((normal - want).length() < 2e-6, "{at}: {normal} {want}");
        }
        assert!(seen > 1000);
    }
}

#[test]
fn the_limit_of_a_cube() {
    let (own, polygons) = cage(&CUBE, vec![4; 6], FACES.to_vec());
    for level in 1..=3 {
        let fine = refine::refined(&own, Scheme::CatmullClark, level, &polygons, &[]).unwrap();
        assert_eq!(fine.parents.len(), 6 * 4usize.pow(level as u32));
        let all = corners(&fine);
        // A corner goes to (9 · 1 + 4 · 1 − 1) / 24 of itself (Halstead et al.: n² v + 4 Σ e + Σ f over n (n + 5)), and looks
        // along the diagonal.
        let (corner, normal) = all.iter().find(|(at, _)| (*at - DVec3::splat(0.5)).length() < 1e-6).unwrap();
        assert!((*normal - DVec3::ONE.normalize()).length() < 1e-6, "{corner} {normal}");
        // The middle of a face: its ring after one step is (0, 0, 1), edges (0, ¾, ¾) and corners 5/9, as a bicubic B-spline.
        let middle = (16.0 + 4.0 * 4.0 * 0.75 + 4.0 * 5.0 / 9.0) / 36.0;
        let top = all.iter().find(|(at, _)| (*at - DVec3::new(0., 0., middle)).length() < 1e-6).unwrap();
        assert!((top.1 - DVec3::Z).length() < 1e-6, "{}", top.1);
        // Like a ball, and nowhere inside out.
        for (at, normal) in &all {
            assert!(at.length() > 0.8 && at.length() < 0.88 && normal.dot(at.normalize()) > 0.97, "{at} {normal}");
        }
    }
}

/// A cage without any symmetry: a boundary, points of three to six edges, a crease through it, a corner.
fn bumpy(scheme: Scheme) -> (Cage, Polygons) {
    let (mut points, _, quads) = grid(4, |x, y| 0.3 * (1.7 * x + 0.4).sin() + 0.2 * (2.1 * y - x).cos());
    for (i, p) in points.iter_mut().enumerate() {
        let wobble = |seed: f64| (0.15 * ((i as f64 + 1.0) * seed).sin()) as f32;
        *p = [p[0] + wobble(12.9898), p[1] + wobble(78.233), p[2] + wobble(37.719)];
    }
    let mut counts = Vec::new();
    let mut indices = Vec::new();
    for (i, q) in quads.chunks(4).enumerate() {
        if scheme == Scheme::Loop || [5, 6, 9].contains(&i) {
            let flip = i % 3 == 0;
            let [a, b, c, d] = [q[0], q[1], q[2], q[3]];
            indices.extend(if flip { [a, b, d, b, c, d] } else { [a, b, c, a, c, d] });
            counts.extend([3, 3]);
        } else {
            indices.extend(q);
            counts.push(4);
        }
    }
    let (mut own, polygons) = cage(&points, counts, indices);
    own.creases = vec![[5, 6], [6, 7], [7, 8], [8, 9]];
    own.crease_weights = vec![10.0; 4];
    (own.pinned, own.pinned_weights) = (vec![18], vec![10.0]);
    (own, polygons)
}

/// The pinned point and its surroundings: the tip of a spike, which has no tangent plane.
fn is_tip(at: DVec3, near: f64) -> bool {
    let (_, polygons) = bumpy(Scheme::CatmullClark);
    (at - DVec3::from(polygons.position(18).map(f64::from))).length() < near
}

/// Tangents are eigenvectors of the subdivision about a point: each level has the same, and the same limit.
#[test]
fn points_and_normals_of_the_cage_do_not_depend_on_the_level() {
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        let (own, polygons) = bumpy(scheme);
        let coarse = corners(&refine::refined(&own, scheme, 2, &polygons, &[]).unwrap());
        let fine = corners(&refine::refined(&own, scheme, 4, &polygons, &[]).unwrap());
        let mut compared = 0;
        for (at, normal) in &coarse {
            let beside: Vec<&DVec3> =
                fine.iter().filter(|(other, _)| (*other - *at).length() < 2e-6).map(|(_, normal)| normal).collect();
            assert!(!beside.is_empty(), "{scheme:?} {at}: no such point");
            if is_tip(*at, 1e-5) {
                continue;
            }
            let near = beside.iter().map(|other| (**other - *normal).length()).fold(f64::INFINITY, f64::min);
            // In a corner with several faces each face has a tangent plane of its own, which comes nearer with each level.
            let is_corner = near > 1e-4;
            compared += usize::from(!is_corner);
            assert!(!is_corner || near < 0.3, "{scheme:?} {at}: {near}");
        }
        assert!(compared * 100 > coarse.len() * 97, "{scheme:?}: {compared} of {}", coarse.len());
    }
}

/// Normals are upright on what was refined much further, everywhere.
#[test]
fn normals_are_those_of_fine_facets() {
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        let (own, polygons) = bumpy(scheme);
        let fine = refine::refined(&own, scheme, 5, &polygons, &[]).unwrap();
        let all = corners(&fine);
        let size = if scheme == Scheme::Loop { 3 } else { 4 };
        for face in all.chunks(size) {
            let area = (face[1].0 - face[0].0).cross(face[2].0 - face[0].0).normalize();
            for (at, normal) in face {
                assert!(area.dot(*normal) > 0.9 || is_tip(*at, 0.2), "{scheme:?} {at}: {normal} {area}");
            }
        }
    }
}

fn cube(more: &str) -> Assembly {
    assembly(&format!("def Mesh \"M\" {{ {} {more} }}", text()))
}

fn text() -> String {
    let points: Vec<String> = CUBE.iter().map(|[x, y, z]| format!("({x}, {y}, {z})")).collect();
    format!(
        "point3f[] points = [{}]\nint[] faceVertexCounts = [4, 4, 4, 4, 4, 4]\nint[] faceVertexIndices = {FACES:?}\n",
        points.join(", ")
    )
}

#[test]
fn creases_and_corners_keep_a_cube_a_cube() {
    let found = cube(
        "int[] creaseIndices = [0, 1, 3, 2, 0, 4, 5, 7, 6, 4, 0, 4, 1, 5, 3, 7, 2, 6]
        int[] creaseLengths = [5, 5, 2, 2, 2, 2]
        float[] creaseSharpnesses = [10, 10, 10, 10, 10, 10]
        int[] cornerIndices = [0, 99]
        float[] cornerSharpnesses = [10, 10]",
    );
    let mesh = &found.meshes[0].mesh;
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let (p, n) = (DVec3::from(p.map(f64::from)), DVec3::from(n.map(f64::from)));
        assert!((p.abs().max_element() - 1.0).abs() < 1e-6 && (n.abs().max_element() - 1.0).abs() < 1e-6);
        assert!((p.dot(n) - 1.0).abs() < 1e-6, "{p} {n}");
    }
    assert!(
        notes(&found).contains("1 corners are no points") && notes(&found).contains("5 levels"),
        "{}",
        notes(&found)
    );
    // Half sharp is between the ball and the cube.
    let far = |found: &Assembly| {
        found.meshes[0].mesh.positions.iter().map(|p| DVec3::from(p.map(f64::from)).length()).fold(0.0, f64::max)
    };
    let half =
        cube("int[] creaseIndices = [0, 1, 3, 2, 0]\nint[] creaseLengths = [5]\nfloat[] creaseSharpnesses = [1.5]");
    assert!(far(&half) > far(&cube("")) + 0.01 && far(&half) < far(&found) - 0.1);
    let apart = cube("int[] creaseIndices = [0, 7]\nint[] creaseLengths = [2]\nfloat[] creaseSharpnesses = [10]");
    assert!(notes(&apart).contains("1 creases are between points that no edge joins"));
    let wrong = cube("int[] creaseIndices = [0, 1]\nint[] creaseLengths = [3]\nfloat[] creaseSharpnesses = [10]");
    assert!(notes(&wrong).contains("do not fit each other"));
}

#[test]
fn holes_faces_and_orientation_are_the_cages() {
    let whole = cube("");
    let subset = "def GeomSubset \"top\" { uniform token elementType = \"face\"
        uniform token familyName = \"cadFace\"
        int[] indices = [1] }";
    let found = cube(&format!("int[] holeIndices = [0]\n{subset}"));
    let all = whole.meshes[0].mesh.triangles.len();
    let mesh = &found.meshes[0].mesh;
    assert_eq!((mesh.triangles.len(), mesh.faces.len()), (all / 6 * 5, 2));
    assert_eq!(mesh.faces[0].count as usize, all / 6);
    let top = mesh.faces[0].triangles().flat_map(|i| mesh.triangles[i]);
    assert!(top.map(|i| mesh.positions[i as usize][2]).all(|z| z > 0.3));
    let turned = cube("uniform token orientation = \"leftHanded\"");
    let (a, b) = (&whole.meshes[0].mesh, &turned.meshes[0].mesh);
    assert_eq!(a.normals[0].map(|x| -x), b.normals[0]);
    let [p, q, r] = a.triangles[0].map(|i| a.positions[i as usize]);
    assert_eq!([p, r, q], b.triangles[0].map(|i| b.positions[i as usize]));
}

/// Values that are linear stay so, by every rule; seams stay where they are. All kinds at once.
#[test]
fn primvars_follow() {
    let (points, counts, quads) = grid(4, |x, y| 0.1 * x * y);
    let (own, polygons) = cage(&points, counts, quads.clone());
    let of = |point: usize| [points[point][0], points[point][1], 0.5];
    let by_point = |kind: Interpolation| Primvar::new((0..points.len()).map(of).collect(), None, kind);
    let primvars = [
        by_point(Interpolation::Varying),
        Primvar::new(quads.iter().map(|&point| of(point as usize)).collect(), None, Interpolation::FaceVarying),
        Primvar::new((0..16).map(|i| [i as f32, 0.5, 0.0]).collect(), None, Interpolation::Uniform),
        by_point(Interpolation::Vertex),
        Primvar::constant([1.0, 2.0, 3.0]),
        // A seam at every edge.
        Primvar::new((0..64).map(|i| [(i / 4) as f32; 3]).collect(), None, Interpolation::FaceVarying),
    ];
    let fine = refine::refined(&own, Scheme::CatmullClark, 2, &polygons, &primvars).unwrap();
    let [varying, cornered, uniform, vertex, constant, apart] = fine.primvars.as_slice() else { panic!() };
    for (polygon, &parent) in fine.parents.iter().enumerate() {
        for corner in fine.polygons.corners.span(polygon) {
            let point = fine.polygons.corners.points()[corner] as usize;
            let at = fine.polygons.position(point);
            // Linearly mixed ones do not follow the curve of the boundary.
            for (primvar, near) in [(varying, 0.2), (cornered, 2e-6), (vertex, 2e-6)] {
                let found = primvar.at(polygon, corner, point).unwrap();
                assert!((at[0] - found[0]).abs() < near && (at[1] - found[1]).abs() < near, "{at:?} {found:?}");
                assert_eq!(found[2], 0.5);
            }
            assert_eq!(uniform.at(polygon, corner, point), Some([parent as f32, 0.5, 0.0]));
            assert_eq!(constant.at(polygon, corner, point), Some([1.0, 2.0, 3.0]));
            let found = apart.at(polygon, corner, point).unwrap();
            assert!(found.iter().all(|x| (x - parent as f32).abs() < 1e-5), "{found:?} {parent}");
        }
    }
}

#[test]
fn what_cannot_be_subdivided_is_said() {
    let said = |found: &Assembly| notes(found);
    assert!(said(&cube("uniform token subdivisionScheme = \"loop\"")).contains("polygon 0 is no triangle"));
    let wrong = fault(&format!("def Mesh \"M\" {{ {} uniform token subdivisionScheme = \"catmulClark\" }}", text()));
    assert!(wrong.contains("did you mean `catmullClark`?"), "{wrong}");
    let wrong = fault(&format!("def Mesh \"M\" {{ {} uniform token interpolateBoundary = \"edge\" }}", text()));
    assert!(wrong.contains("interpolateBoundary"), "{wrong}");
    // Twice the same point in a polygon; three polygons at an edge; a point that no polygon has; a bow tie.
    let mesh = |counts: &str, indices: &str| {
        let points =
            "point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (5, 5, 5)]";
        assembly(&format!(
            "def Mesh \"M\" {{ {points}\nint[] faceVertexCounts = [{counts}]\nint[] faceVertexIndices = [{indices}] }}"
        ))
    };
    assert!(said(&mesh("4", "0, 1, 1, 2")).contains("its polygons are taken as they are"));
    for (counts, indices) in [("3, 3, 3", "0, 1, 2, 1, 0, 4, 0, 1, 5"), ("3, 3", "0, 1, 2, 0, 4, 5"), ("3", "0, 1, 2")]
    {
        let found = mesh(counts, indices);
        let mesh = &found.meshes[0].mesh;
        assert!(mesh.positions.iter().chain(&mesh.normals).flatten().all(|x| x.is_finite()), "{counts}");
        assert!(said(&found).contains("on its limit surface"));
    }
    // Without rules for the boundary, what touches it is not drawn.
    let open = cube("uniform token interpolateBoundary = \"none\"");
    assert!(open.meshes[0].mesh.triangles.len() > 1000);
}
