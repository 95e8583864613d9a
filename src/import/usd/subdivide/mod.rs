//! Subdivision surfaces: Catmull–Clark and Loop cages become fine meshes whose points lie on the limit surface, with its
//! normals. Refining is the crate's (a port of OpenSubdiv); how far, and the normals, are ours.

mod cage; // what the prim says of its cage
mod normals; // normals of the limit surface
mod refine; // the crate

#[cfg(test)]
mod tests;

use super::attribute::PrimView;
use super::polygons::{Corners, Polygons};
use super::primvar::Primvar;
use super::reader::Reader;
use cage::Cage;
use eyebox_base::error::Result;

/// How a cage is subdivided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scheme {
    CatmullClark,
    Loop,
}

impl Scheme {
    fn name(self) -> &'static str {
        match self {
            Scheme::CatmullClark => "catmullClark",
            Scheme::Loop => "loop",
        }
    }
}

/// A level more makes four times as many polygons. Levels are added while there are no more than this many, so that facets of
/// a small cage are as fine as those of a large one.
const MOST_POLYGONS: usize = 100_000;
/// A cage that is large already is refined this often all the same; and no cage more often than the second.
const LEVELS: std::ops::RangeInclusive<usize> = 1..=5;
/// A cage that is finer than any picture shows.
const TOO_MANY_POLYGONS: usize = 4_000_000;
/// Bytes that a polygon takes while it is refined: its corners and edges, all levels, positions; and for each primvar.
const POLYGON: usize = 600;
const PRIMVAR: usize = 150;
/// Bytes that are charged for it as part of the mesh, and for each primvar.
const KEPT: usize = 2 * (3 * 24 + 2 * 12);
const KEPT_PRIMVAR: usize = 2 * 3 * 16;

/// A mesh on the limit surface.
pub(super) struct Fine {
    pub polygons: Polygons,
    pub normals: Primvar<[f32; 3]>,
    /// Those of the cage, in the same order.
    pub primvars: Vec<Primvar<[f32; 3]>>,
    /// The polygon of the cage that each polygon came from.
    pub parents: Vec<u32>,
}

/// The scheme that a mesh says, and whether it says it: USD's fallback is Catmull–Clark. None for polygons.
///
/// # Errors
/// A scheme that USD does not know.
pub(super) fn scheme(view: &PrimView) -> Result<(Option<Scheme>, bool)> {
    let said = view.token("subdivisionScheme")?;
    let scheme = match said.as_deref() {
        Some("none" | "bilinear") => None,
        Some("catmullClark") | None => Some(Scheme::CatmullClark),
        Some("loop") => Some(Scheme::Loop),
        Some(other) => {
            let known = ["none", "catmullClark", "loop", "bilinear"];
            let fault = view.fault_in("subdivisionScheme", format!("the scheme `{}`", other.escape_debug()));
            return Err(fault.expected("none, catmullClark, loop or bilinear").nearest(other, known));
        }
    };
    Ok((scheme, said.is_some()))
}

/// The limit surface of a cage with its `primvars`; none, with a warning, if it has none: its polygons are then taken as they are.
///
/// # Errors
/// Values of other types than the schema's; more polygons than the file can honestly mean.
pub(super) fn limit(
    reader: &mut Reader,
    view: &PrimView,
    (scheme, is_said): (Scheme, bool),
    (polygons, has_normals): (&Polygons, bool),
    primvars: &[Primvar<[f32; 3]>],
) -> Result<Option<Fine>> {
    let cage = match Cage::read(reader, view, scheme, polygons)? {
        Ok(cage) => cage,
        Err(why) => return Ok(left_alone(reader, view, scheme, &why)),
    };
    let level = level(reader, &cage, scheme, primvars.len());
    let fine = count(&cage, level, scheme);
    if fine > TOO_MANY_POLYGONS {
        return Ok(left_alone(reader, view, scheme, &format!("it would have {fine} polygons after one level")));
    }
    let before = reader.ledger.taken();
    if fine > MOST_POLYGONS {
        reader.charge(view.path(), fine, POLYGON + PRIMVAR * primvars.len())?;
    }
    let refined = match refine::refined(&cage, scheme, level, polygons, primvars) {
        Ok(refined) => {
            reader.ledger.release(before);
            reader.ledger.allow_fine(kept(fine, primvars.len()));
            refined
        }
        Err(why) => return Ok(left_alone(reader, view, scheme, &why)),
    };
    let by =
        if is_said { "" } else { " (USD's fallback, nothing is said; `subdivisionScheme = \"none\"` keeps polygons)" };
    let text = format!(
        "a {} subdivision surface{by}: {level} levels, {} polygons on its limit surface",
        scheme.name(),
        refined.parents.len()
    );
    // Whoever writes normals means polygons, most of the time.
    if !is_said && has_normals {
        reader.ledger.warn(view.at(), format!("{text}; its normals are not taken, as in USD"));
    } else {
        reader.ledger.info(view.at(), text);
    }
    Ok(Some(refined))
}

fn left_alone(reader: &mut Reader, view: &PrimView, scheme: Scheme, why: &str) -> Option<Fine> {
    let name = scheme.name();
    let text =
        format!("a {name} subdivision surface cannot be made of this mesh ({why}): its polygons are taken as they are");
    reader.ledger.warn(view.at(), text);
    None
}

/// How often a cage is refined: less where the asset has many cages that are finer than their files.
fn level(reader: &Reader, cage: &Cage, scheme: Scheme, primvars: usize) -> usize {
    let share = reader.ledger.fine_share();
    let mut level = *LEVELS.start();
    while level < *LEVELS.end() {
        let next = count(cage, level + 1, scheme);
        if next > MOST_POLYGONS || kept(next, primvars) > share {
            break;
        }
        level += 1;
    }
    level
}

/// What is charged for a fine mesh that is kept, two triangles a polygon with vertices of their own; bytes.
fn kept(polygons: usize, primvars: usize) -> usize {
    polygons.saturating_mul(KEPT + KEPT_PRIMVAR * primvars)
}

/// Catmull–Clark makes a quad of each corner first, then four of each polygon; Loop four triangles of each.
fn at_level(corners: usize, polygons: usize, level: usize, scheme: Scheme) -> usize {
    let (first, more) = match scheme {
        Scheme::CatmullClark => (corners, level.saturating_sub(1)),
        Scheme::Loop => (polygons, level),
    };
    first.saturating_mul(4usize.saturating_pow(u32::try_from(more).unwrap_or(u32::MAX)))
}

fn count(cage: &Cage, level: usize, scheme: Scheme) -> usize {
    at_level(cage.sizes.iter().sum(), cage.sizes.len(), level, scheme)
}

/// Polygons of the fine mesh.
fn corners_of(scheme: Scheme, points: Vec<u32>) -> Corners {
    match scheme {
        Scheme::Loop => Corners::Triangles(points.as_chunks::<3>().0.to_vec()),
        Scheme::CatmullClark => {
            let starts = (0..=points.len() as u32 / 4).map(|polygon| 4 * polygon).collect();
            Corners::Mixed { points, starts }
        }
    }
}
