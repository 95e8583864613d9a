//! What the vertices of a face carry beside position and normal: the texture coordinates and colours that its material
//! reads, by the names of primvars.

use super::super::attribute::PrimView;
use super::super::notes::Ledger;
use super::super::paint::Painted;
use super::super::primvar::{self, Primvar, Sizes};
use super::super::reads::{Coordinates, OfVertices, Reads, Set};
use eyebox_base::error::{Result, nearest_name};
use std::collections::HashMap;
use std::rc::Rc;

/// One primvar, perhaps of several faces.
pub(super) type Held<T> = Option<Rc<Primvar<T>>>;

#[derive(Debug, Clone, Default)]
pub(in crate::usd) struct Carried {
    pub uvs: Held<[f32; 2]>,
    pub second_uvs: Held<[f32; 2]>,
    pub color: Held<[f32; 3]>,
    pub opacity: Held<f32>,
}

impl Carried {
    pub fn follows_points(&self) -> bool {
        let uvs = [&self.uvs, &self.second_uvs].into_iter().flatten().all(|uvs| uvs.follows_points());
        uvs && self.color.as_ref().is_none_or(|color| color.follows_points())
            && self.opacity.as_ref().is_none_or(|opacity| opacity.follows_points())
    }
    pub fn has_colors(&self) -> bool {
        self.color.is_some() || self.opacity.is_some()
    }
    /// Linear Rec.709 with alpha; what is not said is 1.
    pub fn colour(&self, polygon: usize, corner: usize, point: usize) -> [f32; 4] {
        let color = self.color.as_ref().map_or(Some([1.0; 3]), |color| color.at(polygon, corner, point));
        let opacity = self.opacity.as_ref().map_or(Some(1.0), |opacity| opacity.at(polygon, corner, point));
        let [r, g, b] = color.unwrap_or_default();
        [r, g, b, opacity.unwrap_or_default()]
    }
    /// Bytes that each vertex has of it.
    pub fn bytes(&self) -> usize {
        8 * usize::from(self.uvs.is_some())
            + 8 * usize::from(self.second_uvs.is_some())
            + 16 * usize::from(self.has_colors())
    }
}

/// The primvars of a mesh that were read so far: its faces may share them.
pub(super) struct Shelf<'a> {
    view: &'a PrimView,
    sizes: Sizes,
    painted: Painted,
    uvs: HashMap<Set, Held<[f32; 2]>>,
    colors: HashMap<String, Held<[f32; 3]>>,
    numbers: HashMap<String, Held<f32>>,
}

impl<'a> Shelf<'a> {
    pub fn new(view: &'a PrimView, sizes: Sizes, painted: Painted) -> Self {
        let (uvs, colors, numbers) = (HashMap::new(), HashMap::new(), HashMap::new());
        Shelf { view, sizes, painted, uvs, colors, numbers }
    }

    /// For a face whose material reads this; none is a face without a look, which shows the colours that the mesh has.
    ///
    /// # Errors
    /// Primvars with an interpolation that there is none of.
    pub fn face(&mut self, reads: Option<&Reads>, ledger: &mut Ledger) -> Result<Carried> {
        let mut out = Carried::default();
        let sets = reads.map_or(&[][..], |reads| reads.sets.as_slice());
        // What no picture asks for is kept for writers.
        out.uvs = match sets.first() {
            Some(first) => self.coordinates(first, ledger)?,
            None => self.set(&Set::Numbered(0), ledger)?,
        };
        if let Some(second) = sets.get(1) {
            out.second_uvs = self.coordinates(second, ledger)?;
        }
        match reads {
            Some(reads) => {
                out.color = self.wanted_color(reads.color.as_ref(), ledger)?;
                out.opacity = self.wanted_number(reads.opacity.as_ref(), ledger)?;
            }
            None => {
                out.color = self.color("displayColor", ledger)?;
                out.opacity = self.number("displayOpacity", ledger)?;
                if out.color.is_none() && out.opacity.is_some() {
                    // As grey as faces of which nothing is said.
                    out.color = Some(Rc::new(Primvar::constant([0.8; 3])));
                }
            }
        }
        Ok(out)
    }

    fn set(&mut self, set: &Set, ledger: &mut Ledger) -> Result<Held<[f32; 2]>> {
        if let Some(known) = self.uvs.get(set) {
            return Ok(known.clone());
        }
        let found = match set {
            Set::Named(name) => primvar::pairs(self.view, name, self.sizes, ledger)?,
            Set::Numbered(number) => primvar::uvs(self.view, *number as usize, self.sizes, ledger)?,
        };
        let found = found.map(Rc::new);
        self.uvs.insert(set.clone(), found.clone());
        Ok(found)
    }

    fn coordinates(&mut self, wanted: &Coordinates, ledger: &mut Ledger) -> Result<Held<[f32; 2]>> {
        if let Some(found) = self.set(&wanted.set, ledger)? {
            return Ok(Some(found));
        }
        let what = match &wanted.set {
            Set::Named(name) => format!("the texture coordinates `{name}`{}", self.near(name)),
            Set::Numbered(number) => format!("a set of texture coordinates number {number}"),
        };
        let [u, v] = wanted.fallback;
        let text = format!("the material reads {what}, which the mesh does not have: ({u}, {v}) all over");
        ledger.warn(self.view.at(), text);
        Ok(Some(Rc::new(Primvar::constant(wanted.fallback))))
    }

    /// The name of a primvar that may be meant.
    fn near(&self, name: &str) -> String {
        let names = self.view.property_names().iter().filter_map(|name| name.strip_prefix("primvars:"));
        let names = names.filter(|name| !name.ends_with(":indices"));
        nearest_name(name, names).map_or_else(String::new, |near| format!(" (the mesh has `{near}`)"))
    }

    fn color(&mut self, name: &str, ledger: &mut Ledger) -> Result<Held<[f32; 3]>> {
        if let Some(known) = self.colors.get(name) {
            return Ok(known.clone());
        }
        let own = primvar::colors(self.view, name, self.sizes, ledger)?;
        let found = own.or_else(|| self.painted.color(name).map(Primvar::constant)).map(Rc::new);
        self.colors.insert(name.to_owned(), found.clone());
        Ok(found)
    }

    fn number(&mut self, name: &str, ledger: &mut Ledger) -> Result<Held<f32>> {
        if let Some(known) = self.numbers.get(name) {
            return Ok(known.clone());
        }
        let own = primvar::numbers(self.view, name, self.sizes, ledger)?;
        let found = own.or_else(|| self.painted.opacity(name).map(Primvar::constant)).map(Rc::new);
        self.numbers.insert(name.to_owned(), found.clone());
        Ok(found)
    }

    fn wanted_color(&mut self, wanted: Option<&OfVertices>, ledger: &mut Ledger) -> Result<Held<[f32; 3]>> {
        let Some(OfVertices { name, fallback, .. }) = wanted else { return Ok(None) };
        if let Some(found) = self.color(name, ledger)? {
            return Ok(Some(found));
        }
        let (near, [r, g, b]) = (self.near(name), *fallback);
        let text =
            format!("the material reads the colours `{name}`{near}, which the mesh does not have: ({r}, {g}, {b})");
        ledger.warn(self.view.at(), text);
        Ok(Some(Rc::new(Primvar::constant(*fallback))))
    }

    fn wanted_number(&mut self, wanted: Option<&OfVertices>, ledger: &mut Ledger) -> Result<Held<f32>> {
        let Some(OfVertices { name, fallback: [fallback, ..], .. }) = wanted else { return Ok(None) };
        if let Some(found) = self.number(name, ledger)? {
            return Ok(Some(found));
        }
        let near = self.near(name);
        let text = format!("the material reads the opacities `{name}`{near}, which the mesh does not have: {fallback}");
        ledger.warn(self.view.at(), text);
        Ok(Some(Rc::new(Primvar::constant(*fallback))))
    }
}
