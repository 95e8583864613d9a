//! Polished faces of two solids that touch: a cemented doublet, a prism on a plate. CAD leaves the two faces on top of
//! each other, or a rounding apart, or a rounding into each other; which one a ray meets first is then chance, and the
//! air between them, of a nanometre, would reflect like two faces of glass although no light wave sees it.
//!
//! So faces that look at each other from no more than [`TOUCHING`] of the smaller one's diameter are one interface, from
//! the one solid straight into the other, wherever both are there; and flush ones, of a solid inside of another, are
//! entered and left at once. The rule has no unit: it is a share of the faces.
//!
//! Anything else that lies on a polished face to rounding (a black ring, a screen, a lamp) covers it: it is on the
//! outside of the solid, and both are met, one after the other.

use super::geometry::{Geometry, Hit, Site};
use super::interior::{Solid, outranks};
use super::surface::{FaceOptics, Surface};
use eyebox_scene::Scene;
use glam::DVec3;
use std::ops::ControlFlow;

/// Distance of two faces, over the diameter of the smaller one, up to which they touch: 1.25 µm for lenses of 25 mm.
/// CAD kernels and f32 files err by less; the air gaps that prisms are made with (5 µm and more on 40 mm) are larger.
pub const TOUCHING: f64 = 5e-5;

/// Faces looked for on a face; more than a ray can be inside of would not be followed.
const MOST: usize = super::interior::Interior::DEPTH;
/// Places where a face is compared with its neighbours; on a part of very many faces there are fewer on each.
const PLACES: usize = 256;
const PLACES_OF_PART: usize = 1 << 17;
/// With more solids all are taken to have neighbours.
const MANY: usize = 4096;

/// A face of another solid that touches a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    pub part: u32,
    pub face: u32,
    /// How far off it may be, m.
    pub reach: f64,
    /// It lies on a polished face as its cover.
    covers: bool,
}

/// The contacts of all faces.
#[derive(Debug, Default)]
pub struct Contacts {
    /// Per part and face; empty where nothing in the scene touches.
    faces: Table,
    /// The same of polished faces and what covers them.
    covers: Table,
}

type Table = Vec<Vec<Vec<Contact>>>;

/// The face of another solid at a hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touching {
    pub site: Site,
    /// It looks the same way: both solids end here. Else the one begins where the other ends.
    pub flush: bool,
}

/// Two faces that are one interface.
#[derive(Debug, Clone, Copy)]
pub struct Joint {
    /// Of the solid that fills the space before the other: its coating holds.
    pub hit: Hit,
    pub other: Touching,
    /// Where the other one is met.
    pub second: Hit,
}

impl Contacts {
    /// Compares the polished faces of solids with those near them.
    pub fn find(scene: &Scene, geometry: &Geometry, optics: &[Vec<FaceOptics>], solids: &[Option<Solid>]) -> Contacts {
        let diameters: Vec<Vec<f64>> = (0..scene.parts.len()).map(|part| diameters(scene, geometry, part)).collect();
        let can_touch = |part: usize, face: usize| {
            let face = optics.get(part).and_then(|faces| faces.get(face));
            let polished = face.is_some_and(|face| !face.lamp && matches!(face.surface, Surface::Interface(_)));
            polished && solids.get(part).is_some_and(Option::is_some)
        };
        let can_cover = |part: usize, face: usize| {
            let face = optics.get(part).and_then(|faces| faces.get(face));
            face.is_some_and(|face| face.lamp || !matches!(face.surface, Surface::Absent))
        };
        let filled = solids.iter().flatten().count();
        let mut contacts = Contacts::default();
        if filled == 0 || scene.parts.len() < 2 {
            return contacts;
        }
        let empty: Table = diameters.iter().map(|of| vec![Vec::new(); of.len()]).collect();
        let (mut faces, mut covers) = (empty.clone(), empty);
        let grain = grain(geometry);
        for part in 0..scene.parts.len() {
            let widest = diameters[part].iter().copied().fold(0.0, f64::max) * TOUCHING + grain;
            let polished = (0..diameters[part].len()).any(|face| can_touch(part, face));
            if !polished || (scene.parts.len() <= MANY && !geometry.has_neighbours(part as u32, widest)) {
                continue;
            }
            for face in (0..diameters[part].len()).filter(|face| can_touch(part, *face)) {
                let own = diameters[part][face];
                for (p, normal) in places(scene, geometry, part, face) {
                    geometry.all_beside(part as u32, p, normal, own * TOUCHING + grain, |hit| {
                        let (other, its) = (hit.site.part as usize, hit.site.face as usize);
                        let distance = (hit.point - p).length();
                        let reach = own.min(diameters[other][its]) * TOUCHING + grain;
                        if can_touch(other, its) && distance <= reach {
                            note(&mut faces, [part, face], [other, its], reach, false);
                            note(&mut faces, [other, its], [part, face], reach, false);
                        } else if can_cover(other, its) && distance <= grain {
                            cover(&mut covers, [part, face], [other, its], grain);
                        }
                        let full = faces[part][face].len() + covers[part][face].len() >= MOST;
                        if full { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                    });
                    if faces[part][face].len() + covers[part][face].len() >= MOST {
                        break;
                    }
                }
            }
        }
        // A small cover lies between the places of a large face: it is asked about its own.
        let is_glass = |part: &usize| (0..diameters[*part].len()).any(|face| can_touch(*part, face));
        let glass: Vec<u32> = (0..scene.parts.len()).filter(is_glass).map(|part| part as u32).collect();
        let many = scene.parts.len() > MANY;
        for (part, own) in diameters.iter().enumerate() {
            let is_near = |other: &u32| many || geometry.are_near([part as u32, *other], grain);
            let near: Vec<u32> = glass.iter().copied().filter(is_near).collect();
            let own = if near.is_empty() { 0 } else { own.len() };
            let own = if scene.parts[part].film_in.is_some() { 0 } else { own };
            for face in (0..own).filter(|face| can_cover(part, *face) && !can_touch(part, *face)) {
                let is_near = |other: &u32| geometry.is_near(*other, corners(scene, geometry, part, face), grain);
                if !many && !near.iter().any(is_near) {
                    continue;
                }
                for (p, normal) in places(scene, geometry, part, face) {
                    geometry.all_beside(part as u32, p, normal, grain, |hit| {
                        let under = [hit.site.part as usize, hit.site.face as usize];
                        if can_touch(under[0], under[1]) {
                            cover(&mut covers, under, [part, face], grain);
                        }
                        ControlFlow::Continue(())
                    });
                }
            }
        }
        let some =
            |table: Table| if table.iter().flatten().any(|list| !list.is_empty()) { table } else { Table::new() };
        (contacts.faces, contacts.covers) = (some(faces), some(covers));
        contacts
    }

    /// Pairs of polished faces that touch, and of covers and what they cover.
    pub fn pairs(&self) -> [usize; 2] {
        [&self.faces, &self.covers].map(|table| table.iter().flatten().map(Vec::len).sum::<usize>() / 2)
    }

    /// Every polished face that touches one of another solid, as [part, face] and [part, face], from both sides.
    pub fn touching(&self) -> impl Iterator<Item = ([usize; 2], [usize; 2])> {
        let faces = self.faces.iter().enumerate().flat_map(|(part, faces)| {
            faces.iter().enumerate().flat_map(move |(face, near)| near.iter().map(move |other| ([part, face], other)))
        });
        faces.map(|(own, other)| (own, [other.part as usize, other.face as usize]))
    }

    /// The interface of two solids that `hit` is a part of, if another face touches there.
    #[inline]
    pub fn joint(&self, geometry: &Geometry, solids: &[Option<Solid>], hit: &Hit) -> Option<Joint> {
        let near = listed(&self.faces, hit.site);
        if near.is_empty() {
            return None;
        }
        let touching = near.iter().filter_map(|contact| {
            let other = geometry.beside(contact.part, hit.point, hit.normal, contact.reach)?;
            (other.site.face == contact.face).then_some(other)
        });
        // Of several, the solid that fills the space.
        let best = touching.reduce(|a, b| if outranks(solids, b.site.part, a.site.part) { b } else { a })?;
        let flush = best.normal.dot(hit.normal) > 0.0;
        Some(if outranks(solids, best.site.part, hit.site.part) {
            Joint { hit: Hit { t: hit.t, ..best }, other: Touching { site: hit.site, flush }, second: *hit }
        } else {
            Joint { hit: *hit, other: Touching { site: best.site, flush }, second: best }
        })
    }
}

impl Contacts {
    /// The polished face and its cover of which `hit` is one, in the order in which light that runs along `dir` meets
    /// them: the cover is outside.
    #[inline]
    pub fn covered(&self, geometry: &Geometry, hit: &Hit, dir: DVec3) -> Option<[Hit; 2]> {
        listed(&self.covers, hit.site).iter().find_map(|contact| {
            let other = geometry.beside(contact.part, hit.point, hit.normal, contact.reach)?;
            if other.site.face != contact.face {
                return None;
            }
            let other = Hit { t: hit.t, ..other };
            let (glass, cover) = if contact.covers { (*hit, other) } else { (other, *hit) };
            Some(if dir.dot(glass.normal) > 0.0 { [glass, cover] } else { [cover, glass] })
        })
    }

    /// The polished face that a place on a cover, with its normal, lies on; of two that hold it, the one that light which
    /// leaves along `dir` goes into. And how far off it may be, m.
    #[inline]
    pub fn under(&self, geometry: &Geometry, site: Site, [point, normal, dir]: [DVec3; 3]) -> Option<(Hit, f64)> {
        let held = listed(&self.covers, site).iter().filter(|contact| !contact.covers);
        let held = held.filter_map(|contact| {
            let glass = geometry.beside(contact.part, point, normal, contact.reach)?;
            (glass.site.face == contact.face).then_some((glass, contact.reach))
        });
        held.reduce(|a, b| if dir.dot(a.0.normal) < 0.0 { a } else { b })
    }

    /// Whether a face lies on a polished one of another solid, or such a one under it.
    pub fn is_cover_or_covered(&self, part: u32, face: u32) -> bool {
        !listed(&self.covers, Site { part, face, triangle: 0 }).is_empty()
    }
}

#[inline]
fn listed(table: &Table, site: Site) -> &[Contact] {
    match table.get(site.part as usize) {
        None => &[],
        Some(faces) => faces.get(site.face as usize).map_or(&[], Vec::as_slice),
    }
}

/// Lists a face as a contact of another, once.
fn note(table: &mut Table, of: [usize; 2], face: [usize; 2], reach: f64, covers: bool) {
    let list = &mut table[of[0]][of[1]];
    let [part, face] = face.map(|index| index as u32);
    if !list.iter().any(|known| (known.part, known.face) == (part, face)) {
        list.push(Contact { part, face, reach, covers });
    }
}

/// Lists a face as the cover of a polished one.
fn cover(covers: &mut Table, polished: [usize; 2], face: [usize; 2], reach: f64) {
    note(covers, polished, face, reach, true);
    note(covers, face, polished, reach, false);
}

/// What f64 may be off by, m.
pub(super) fn grain(geometry: &Geometry) -> f64 {
    let (low, high) = geometry.bounds();
    64.0 * f64::EPSILON * low.abs().max(high.abs()).max_element()
}

/// The corners of a face's triangles, in the world.
fn corners(scene: &Scene, geometry: &Geometry, part: usize, face: usize) -> impl Iterator<Item = DVec3> + Clone {
    let mesh = scene.mesh(scene.parts[part].mesh);
    let to_world = geometry.part_to_world(part as u32);
    let range = mesh.faces.get(face).map_or(0..0, |range| range.triangles());
    mesh.triangles.get(range).unwrap_or(&[]).iter().flatten().filter_map(move |v| {
        let [x, y, z] = *mesh.positions.get(*v as usize)?;
        Some(to_world.transform_point3(DVec3::new(f64::from(x), f64::from(y), f64::from(z))))
    })
}

/// Diameter of each face of a part about the mean of its corners, m.
fn diameters(scene: &Scene, geometry: &Geometry, part: usize) -> Vec<f64> {
    let diameter = |face: usize| {
        let corners = corners(scene, geometry, part, face);
        let count = corners.clone().count().max(1) as f64;
        let middle = corners.clone().sum::<DVec3>() / count;
        2.0 * corners.map(|p| p.distance(middle)).fold(0.0, f64::max)
    };
    (0..scene.parts[part].faces.len()).map(diameter).collect()
}

/// Places spread over the triangles of a face, on its exact surface, with their outward normals.
fn places(scene: &Scene, geometry: &Geometry, part: usize, face: usize) -> Vec<(DVec3, DVec3)> {
    let mesh = scene.mesh(scene.parts[part].mesh);
    let to_world = geometry.part_to_world(part as u32);
    let range = mesh.faces.get(face).map_or(0..0, |range| range.triangles());
    let triangles = mesh.triangles.get(range).unwrap_or(&[]);
    let most = (PLACES_OF_PART / scene.parts[part].faces.len().max(1)).clamp(1, PLACES);
    let stride = triangles.len().div_ceil(4 * most).max(1);
    // Each triangle is cut into k² alike.
    let k = ((most as f64 / triangles.len().max(1) as f64).sqrt().ceil() as usize).max(1);
    let mut out = Vec::new();
    for triangle in triangles.iter().step_by(stride) {
        let corner = |i: usize| {
            let [x, y, z] = mesh.positions.get(triangle[i] as usize).copied().unwrap_or([f32::NAN; 3]);
            to_world.transform_point3(DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
        };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        let mirrored = to_world.matrix3.determinant() < 0.0;
        let winding = (b - a).cross(c - a) * if mirrored { -1.0 } else { 1.0 };
        let Some(normal) = winding.try_normalize() else { continue };
        let size = (b - a).length().max((c - a).length());
        for (i, j) in (0..k).flat_map(|i| (0..k - i).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|n| (n as f64 + 1.0 / 3.0) / k as f64);
            let p = a + (b - a) * u + (c - a) * v;
            let hit = geometry.on_face(part as u32, face as u32, p, normal, 0.5 * size);
            out.extend(hit.map(|hit| (hit.point, hit.normal)));
        }
    }
    out
}
