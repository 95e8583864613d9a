//! From a mesh and the shapes of its faces to a [`Solid`].

use super::bound::{Bounds, patch_box, triangle_box};
use super::bvh::huge_pages;
use super::bvh::pack::Pack;
use super::bvh::tree::Tree;
use super::bvh::wide::{LEAF_SIZE, Leaf};
use super::curved::Curved;
use super::exact::Quadric;
use super::grid::Grid;
use super::patch::{Projection, vertex};
use super::solid::Solid;
use super::surface::{Sheet, Surface};
use super::triangle::{Triangle, winding};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::{FaceRange, Finish, Mesh, Part, Shape};
use glam::DVec3;
use std::ops::Range;

/// The shape that a face of a part is traced as; none if light never meets it.
pub type Traced = Option<Shape>;

/// How each face of a part is traced. Lamps are sampled on their triangles, so an emitting face is its triangles.
pub fn traced(part: &Part) -> Vec<Traced> {
    let shape = |face: &eyebox_scene::Face| match (face.finish, &face.emitter, face.slide) {
        (_, Some(_), _) => Some(Shape::Mesh),
        (Finish::None, None, None) => None,
        (
            Finish::None
            | Finish::Polished
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Lambert { .. }
            | Finish::Gauss { .. }
            | Finish::CosM { .. }
            | Finish::Rough { .. }
            | Finish::Abg { .. }
            | Finish::Measured { .. }
            | Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. }
            | Finish::ReflectivePolariser { .. }
            | Finish::Grating { .. }
            | Finish::Surface { .. }
            | Finish::Absorber,
            None,
            _,
        ) => Some(face.shape.clone()),
    };
    part.faces.iter().map(shape).collect()
}

/// Two parts with the same key share a solid.
pub fn key(mesh: usize, faces: &[Traced]) -> Vec<u64> {
    let mut key = vec![mesh as u64];
    for face in faces {
        let grid: [f64; 6];
        let (tag, places, numbers): (u64, &[&DVec3], &[&[f64]]) = match face {
            None => (0, &[], &[]),
            Some(Shape::Mesh) => (1, &[], &[]),
            Some(Shape::Plane { vertex, axis }) => (2, &[vertex, axis], &[]),
            Some(Shape::Sphere { vertex, axis, radius }) => (3, &[vertex, axis], &[&[*radius]]),
            Some(Shape::Conic { vertex, axis, radius, conic }) => (4, &[vertex, axis], &[&[*radius, *conic]]),
            Some(Shape::Asphere { vertex, axis, radius, conic, even }) => {
                (5, &[vertex, axis], &[&[*radius, *conic], even])
            }
            Some(Shape::Cylinder { vertex, axis, x, radius }) => (6, &[vertex, axis, x], &[&[*radius]]),
            Some(Shape::Toroid { vertex, axis, x, radius, tube_radius }) => {
                (7, &[vertex, axis, x], &[&[*radius, *tube_radius]])
            }
            Some(Shape::XyPoly { vertex, axis, x, radius, conic, coeffs }) => {
                (8, &[vertex, axis, x], &[&[*radius, *conic], coeffs])
            }
            Some(Shape::Zernike { vertex, axis, x, radius, conic, norm_radius, coeffs }) => {
                (9, &[vertex, axis, x], &[&[*radius, *conic, *norm_radius], coeffs])
            }
            Some(Shape::Bspline { vertex, axis, x, radius, conic, half, spans, coeffs }) => {
                grid = [*radius, *conic, half[0], half[1], f64::from(spans[0]), f64::from(spans[1])];
                (10, &[vertex, axis, x], &[&grid, coeffs])
            }
        };
        let count = numbers.iter().map(|list| list.len() as u64).sum::<u64>();
        key.extend([tag, count]);
        key.extend(places.iter().flat_map(|p| p.to_array()).map(f64::to_bits));
        key.extend(numbers.iter().copied().flatten().map(|x| x.to_bits()));
    }
    key
}

/// What [`solid`] would refuse, and a box around the triangles that have an area, mesh units; none if no face is there.
pub fn check(mesh: &Mesh, part: &Part, faces: &[Traced]) -> Result<Option<Bounds>> {
    let mut bounds = Bounds::EMPTY;
    let (mut triangles, mut normals) = (Vec::new(), Vec::new());
    let mut any = false;
    for (index, (range, shape)) in mesh.faces.iter().zip(faces).enumerate() {
        let at = || Where::Part { path: part.path.clone(), face: Some(index) };
        let Some(shape) = shape else { continue };
        if *shape == Shape::Mesh {
            for corners in corners_of(mesh, *range).map_err(|what| Error::new(at(), what))? {
                let (_, positions) = corners.map_err(|what| Error::new(at(), what))?;
                if has_area(&positions) {
                    bounds = bounds.join(triangle_box(&positions));
                    any = true;
                }
            }
        } else {
            triangles.clear();
            normals.clear();
            gather(mesh, *range, index as u32, &mut triangles, &mut normals).map_err(|what| Error::new(at(), what))?;
            refused_shape(exact(shape, &triangles), at)?;
            bounds = triangles.iter().fold(bounds, |all, t| all.join(triangle_box(&t.corners)));
            any |= !triangles.is_empty();
        }
    }
    Ok(any.then_some(bounds))
}

/// The fault of a face that is not of its shape.
fn refused_shape(made: Result<Surface, String>, at: impl Fn() -> Where) -> Result<Surface> {
    made.map_err(|what| {
        Error::new(at(), what).expected("the shape of this face in mesh units, or shape mesh").code(Code::ShapeOffMesh)
    })
}

/// Builds the solid of a part; none if no face of it is there.
pub fn solid(mesh: &Mesh, part: &Part, faces: &[Traced]) -> Result<Option<Solid>> {
    let mut triangles = Vec::new();
    let mut normals = Vec::new();
    let mut boxes = Vec::new();
    let mut sheets = Vec::with_capacity(faces.len());
    for (index, (range, shape)) in mesh.faces.iter().zip(faces).enumerate() {
        let at = || Where::Part { path: part.path.clone(), face: Some(index) };
        let face = index as u32;
        let Some(shape) = shape else {
            sheets.push(Sheet { identity: face, surface: Surface::Absent });
            continue;
        };
        let first = triangles.len();
        gather(mesh, *range, face, &mut triangles, &mut normals).map_err(|what| Error::new(at(), what))?;
        let own = &triangles[first..];
        let surface = match shape {
            Shape::Mesh => triangles_alone(own),
            Shape::Plane { .. }
            | Shape::Sphere { .. }
            | Shape::Conic { .. }
            | Shape::Asphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Toroid { .. }
            | Shape::XyPoly { .. }
            | Shape::Zernike { .. }
            | Shape::Bspline { .. } => refused_shape(exact(shape, own), at)?,
        };
        boxes.extend(own.iter().map(|t| match &surface {
            Surface::Absent | Surface::Flat | Surface::Faceted => triangle_box(&t.corners),
            Surface::Exact { quadric, projection, .. } => patch_box(&t.corners, quadric, projection),
            Surface::Curved { curved, .. } => curved.patch_box(t.corners.map(vertex)),
        }));
        let same = |other: &&Sheet| match (&other.surface, &surface) {
            (Surface::Exact { quadric: a, .. }, Surface::Exact { quadric: b, .. }) => a == b,
            (Surface::Curved { curved: a, .. }, Surface::Curved { curved: b, .. }) => a.same(b),
            (
                Surface::Exact { .. } | Surface::Curved { .. } | Surface::Absent | Surface::Flat | Surface::Faceted,
                _,
            ) => false,
        };
        let identity = sheets.iter().find(same).map_or(face, |sheet| sheet.identity);
        sheets.push(Sheet { identity, surface });
    }
    if triangles.is_empty() {
        return Ok(None);
    }
    let bounds = boxes.iter().fold(Bounds::EMPTY, |all, b| all.join(*b));
    if !bounds.is_finite() {
        return Err(Error::new(Where::part(&part.path), "its surfaces have no finite bounds"));
    }
    let (order, tree, grids) = arrange(&triangles, &boxes, &sheets)
        .ok_or_else(|| Error::new(Where::part(&part.path), "it has too many triangles").expected("less than 2^32"))?;
    let triangles: Vec<Triangle> = order.iter().filter_map(|i| triangles.get(*i as usize).copied()).collect();
    let of_leaf = |leaf: &Leaf| triangles.get(leaf.first as usize..)?.get(..leaf.count as usize);
    let plain = |t: &Triangle| matches!(sheets[t.face as usize].surface, Surface::Flat | Surface::Faceted);
    let packs = if tree.leaves().iter().filter_map(of_leaf).flatten().all(plain) {
        huge_pages::settle(tree.leaves().iter().map(|leaf| Pack::new(*leaf, of_leaf(leaf).unwrap_or(&[]))).collect())
    } else {
        Vec::new()
    };
    Ok(Some(Solid {
        bounds: bounds.widen(DVec3::splat(1e-6 * bounds.half().max_element() + 1e-12 * bounds.reach())),
        tree,
        grids,
        packs,
        triangles,
        normals: huge_pages::settle(order.iter().filter_map(|i| normals.get(*i as usize).copied()).collect()),
        faces: sheets,
    }))
}

/// Triangles by slot, the tree over the first of them, the grids of faces over the rest.
type Arranged = (Vec<u32>, Tree, Vec<(u32, Grid)>);

/// Decides which triangles go into the tree and which into grids.
fn arrange(triangles: &[Triangle], boxes: &[Bounds], sheets: &[Sheet]) -> Option<Arranged> {
    // Faces' triangles follow each other.
    let mut own = vec![0..0; sheets.len()];
    for (i, t) in triangles.iter().enumerate() {
        let range = own.get_mut(t.face as usize)?;
        *range = if range.start == range.end { i..i + 1 } else { range.start..i + 1 };
    }
    let corners = |range: &Range<usize>| triangles[range.clone()].iter().map(|t| t.corners).collect::<Vec<_>>();
    let grid = |face: usize| match sheets[face].surface.shear() {
        Some(shear) if !own[face].is_empty() => {
            let base = boxes[own[face].start].centre();
            Grid::build(&corners(&own[face]), shear, base)
        }
        Some(_) | None => None,
    };
    // Many exact faces on one part would be tried one after the other.
    let is_exact = |sheet: &&Sheet| matches!(sheet.surface, Surface::Exact { .. } | Surface::Curved { .. });
    let few = sheets.iter().filter(is_exact).count() <= MOST_GRIDS;
    let found: Vec<Option<Grid>> = (0..sheets.len()).map(|face| if few { grid(face) } else { None }).collect();
    let has_no_grid = |i: &u32| found[triangles[*i as usize].face as usize].is_none();
    let in_tree: Vec<u32> = (0..u32::try_from(triangles.len()).ok()?).filter(has_no_grid).collect();
    let (tree, slots) = Tree::build(&in_tree.iter().map(|i| boxes[*i as usize]).collect::<Vec<_>>(), LEAF_SIZE)?;
    let mut order: Vec<u32> = slots.iter().filter_map(|slot| in_tree.get(*slot as usize).copied()).collect();
    let mut grids = Vec::new();
    for (face, grid) in found.into_iter().enumerate() {
        if let Some(mut grid) = grid {
            grid.move_slots(order.len() as u32);
            grids.push((face as u32, grid));
            order.extend(own[face].clone().map(|i| i as u32));
        }
    }
    Some((order, tree, grids))
}

/// Up to this many exact faces of a part are looked up one after the other.
const MOST_GRIDS: usize = 6;

/// A triangle's number in its mesh, and its corners.
type Numbered = (usize, [[f32; 3]; 3]);

/// The triangles of a face with their numbers: where their corners are, or what is wrong with one.
fn corners_of(mesh: &Mesh, range: FaceRange) -> Result<impl Iterator<Item = Result<Numbered, String>>, String> {
    let Some(own) = mesh.triangles.get(range.triangles()) else {
        return Err(format!(
            "triangles {} to {} of mesh {} which has {}",
            range.first,
            range.triangles().end,
            mesh.name,
            mesh.triangles.len()
        ));
    };
    Ok(range.triangles().zip(own).map(move |(index, corners)| {
        let mut positions = [[0.0f32; 3]; 3];
        for (k, v) in corners.iter().enumerate() {
            match mesh.positions.get(*v as usize) {
                Some(p) if p.iter().all(|x| x.is_finite()) => positions[k] = *p,
                Some(p) => return Err(format!("triangle {index} has a vertex at {p:?}")),
                None => return Err(format!("triangle {index} names vertex {v} of {}", mesh.positions.len())),
            }
        }
        Ok((index, positions))
    }))
}

fn has_area(corners: &[[f32; 3]; 3]) -> bool {
    winding(corners).length_squared() > 0.0
}

/// Adds the triangles of a face that have an area.
fn gather(
    mesh: &Mesh,
    range: FaceRange,
    face: u32,
    triangles: &mut Vec<Triangle>,
    normals: &mut Vec<[[f32; 3]; 3]>,
) -> Result<(), String> {
    for found in corners_of(mesh, range)? {
        let (index, corners) = found?;
        if has_area(&corners) {
            triangles.push(Triangle { corners, face, index: index as u32 });
            normals.push(mesh.triangles[index].map(|v| mesh.normals.get(v as usize).copied().unwrap_or_default()));
        }
    }
    Ok(())
}

/// Flat if every vertex is in one plane to the rounding of its f32 coordinates (half a unit in the last place each, once
/// for the vertex and about as much for the plane).
fn triangles_alone(own: &[Triangle]) -> Surface {
    let area = |t: &&Triangle| winding(&t.corners).length_squared();
    let Some(largest) = own.iter().max_by(|a, b| area(a).total_cmp(&area(b))) else { return Surface::Absent };
    let normal = winding(&largest.corners).normalize_or_zero();
    let base = vertex(largest.corners[0]);
    let corners = || own.iter().flat_map(|t| t.corners).map(vertex);
    let tolerance = 4.0 * f64::from(f32::EPSILON) * Bounds::of(corners()).reach();
    if corners().all(|p| (p - base).dot(normal).abs() <= tolerance) { Surface::Flat } else { Surface::Faceted }
}

/// A vertex farther from the exact surface than this share of the face's diagonal means that the shape is not this
/// face's. Tessellations put vertices on the surface to f32 rounding, fits to 1e-6 of the diagonal.
const MISS: f64 = 0.01;

fn exact(shape: &Shape, own: &[Triangle]) -> Result<Surface, String> {
    let corners = || own.iter().flat_map(|t| t.corners).map(vertex);
    let diagonal = 2.0 * Bounds::of(corners()).half().length();
    let far = |distance: &dyn Fn(DVec3) -> f64| {
        // A distance that is not a number misses, too.
        let met = |p: &DVec3| distance(*p) <= MISS * diagonal;
        corners()
            .find(|p| !met(p))
            .map_or(Ok(()), |p| Err(format!("the shape misses its mesh: vertex {p} is {:.3e} from it", distance(p))))
    };
    // The side that the triangles face: +1 along the surface's own normal.
    let outward = |normal: &dyn Fn(DVec3) -> DVec3| {
        let along = |t: &Triangle| {
            let [a, b, c] = t.corners.map(vertex);
            winding(&t.corners).dot(normal((a + b + c) / 3.0))
        };
        if own.iter().map(along).sum::<f64>() < 0.0 { -1.0 } else { 1.0 }
    };
    if own.is_empty() {
        return Ok(Surface::Absent);
    }
    if let Some(curved) = Curved::new(shape, corners())? {
        far(&|p| curved.distance(p))?;
        let outward = outward(&|p| curved.normal(p));
        return Ok(Surface::Curved { curved: Box::new(curved), outward });
    }
    let quadric = Quadric::from_shape(shape).ok_or_else(|| format!("{shape:?} is no surface"))?;
    far(&|p| quadric.distance(p))?;
    let projection = Projection::choose(&quadric, corners())
        .ok_or_else(|| "the shape misses its mesh, which is on the other sheet of the hyperboloid".to_owned())?;
    Ok(Surface::Exact { quadric, projection, outward: outward(&|p| quadric.normal(p)) })
}
