//! Films that lie in faces of solids. They have the points of those faces, so rays meet them there, and no tree holds them.

use super::{Geometry, Site};
use eyebox_scene::{Part, Scene};
use std::collections::BTreeMap;

/// The face in which a film lies.
#[derive(Debug, Clone, Copy)]
pub struct Base {
    part: u32,
    face: u32,
    /// The face's first triangle in its mesh; it is the film's first in its own.
    first: u32,
}

/// The films of a scene.
#[derive(Debug, Default)]
pub struct Films {
    /// By the part that a film is.
    bases: BTreeMap<u32, Base>,
    /// By part and face of what a film lies in.
    films: BTreeMap<(u32, u32), u32>,
}

impl Films {
    pub fn of(scene: &Scene) -> Films {
        let of_part = |(part, film): (usize, &Part)| {
            let base = film.film_in?;
            let first = scene.mesh(scene.parts.get(base.part)?.mesh).faces.get(base.face)?.first;
            Some((part as u32, Base { part: base.part as u32, face: base.face as u32, first }))
        };
        let bases: BTreeMap<u32, Base> = scene.parts.iter().enumerate().filter_map(of_part).collect();
        let films = bases.iter().map(|(film, base)| ((base.part, base.face), *film)).collect();
        Films { bases, films }
    }

    pub fn is_empty(&self) -> bool {
        self.bases.is_empty()
    }

    pub fn base(&self, part: u32) -> Option<&Base> {
        self.bases.get(&part)
    }

    /// The place that a ray meets, of one on a film; else the place itself.
    pub fn met(&self, site: Site) -> Site {
        self.base(site.part).map_or(site, |base| {
            let triangle = base.first.saturating_add(site.triangle);
            Site { part: base.part, face: base.face, triangle }
        })
    }

    fn at(&self, site: Site) -> Option<Site> {
        let film = *self.films.get(&(site.part, site.face))?;
        Some(Site { part: film, face: 0, triangle: site.triangle.checked_sub(self.base(film)?.first)? })
    }
}

impl Geometry {
    /// Whether no part is a film in another.
    #[inline]
    pub fn has_no_films(&self) -> bool {
        self.films.is_empty()
    }

    /// The place of the film that lies in a face there, if one does.
    pub fn film_at(&self, site: Site) -> Option<Site> {
        self.films.at(site)
    }

    /// The place in the face that a film lies in, of one on that film; else the place itself.
    pub fn below_film(&self, site: Site) -> Site {
        self.films.met(site)
    }
}
