//! Whose a path is that a photon has come by. Photons are gathered about where they land, and where cells that are connected
//! border on others kernels reach from one into the other: so that nothing is lost or doubled there, the point that gathers is
//! asked, not the place where a photon landed. In cells that connection leaves to photons all photons are gathered, those
//! from beyond the border, too, if the light that they stand for comes here; in cells that are connected none of them is.

use super::connect::{Connector, Entry, Solution};
use super::table::{Cell, ReceiverTable};
use super::tuning::ownership::KNOWN;
use super::{ABOUT_SAME, FORETOLD, MOST_SHEETS, Receivers, SAME};
use crate::ledger::cost;
use crate::manifold::solver::bicubic::Spot;
use crate::manifold::solver::newton::Target;
use arrayvec::ArrayVec;
use eyebox_base::chain::Chain;
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;
use glam::DVec3;

/// Branches of a train for one lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Branches {
    lit: u16,
    entry: u16,
    /// A bit for each sheet.
    sheets: u8,
}

/// Whether connection has the path of a photon, where it may be gathered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// Nowhere.
    Free,
    /// Everywhere.
    Connected,
    /// Near a border: where cells say so. `here`: where it landed.
    Bordering { branches: Branches, here: bool },
}

impl Claim {
    /// It is connected where it landed.
    pub fn here(self) -> bool {
        match self {
            Claim::Free => false,
            Claim::Connected => true,
            Claim::Bordering { here, .. } => here,
        }
    }
}

/// How many of a sheet's cells within reach of a place are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Within {
    All,
    Some,
    None,
}

/// Where something lies in a face's map, or beside it.
#[derive(Debug, Clone, Copy)]
struct Place {
    point: DVec3,
    site: Site,
    /// The nearest that there is in the map.
    spot: Spot,
    inside: bool,
}

impl Place {
    /// None where the map is not within `reach`, m.
    fn new<M: Mode>(lit: &Connector<M>, (point, site): (DVec3, Site), reach: f64) -> Option<Place> {
        let spot = lit.map.spot(point);
        let inside = spot.is_some();
        Some(Place { point, site, spot: spot.or_else(|| lit.map.spot_beside(point, reach))?, inside })
    }
}

impl<M: Mode> Receivers<M> {
    /// Whose the path from a point of `lamp` over `chain` (from the lamp) is that arrives at a point of a face along `dir`, for
    /// points that gather it within `reach`, m. Connection's is what [`Receivers::gather`] finds for the same ends. Adds to the
    /// counted work.
    pub fn claim(
        &self,
        tracing: (&World, &Optics<M>),
        chain: &Chain,
        (lamp, target): (usize, &Target),
        (point, site, dir): (DVec3, Site, DVec3),
        reach: f64,
        work: &mut u64,
    ) -> Claim {
        const { assert!(MOST_SHEETS <= u8::BITS as usize) };
        let face = |lit: &Connector<M>| (lit.map.part, lit.map.face) == (site.part, site.face) && lit.chain == *chain;
        // There is one for each group of lamps at most.
        for (number, lit) in self.lit().enumerate().filter(|(_, lit)| face(lit)) {
            let Some(place) = Place::new(lit, (point, site), reach) else { continue };
            for (index, entry) in lit.entries.iter().enumerate().filter(|(_, entry)| entry.lamp == lamp) {
                let (mut sheets, mut here, mut whole) = (0, false, false);
                for (bit, sheet) in entry.sheets.iter().enumerate() {
                    let within = lit.within(sheet, &place, reach);
                    if within == Within::None
                        || !lit.is_of(tracing, (entry, sheet), (&place, reach), (target, dir), work)
                    {
                        continue;
                    }
                    sheets |= 1 << bit;
                    here |= lit.is_connected(sheet, &place);
                    whole |= within == Within::All;
                }
                match (sheets, whole, u16::try_from(number), u16::try_from(index)) {
                    (0, ..) => {}
                    (_, false, Ok(lit), Ok(entry)) => {
                        return Claim::Bordering { branches: Branches { lit, entry, sheets }, here };
                    }
                    _ => return if here { Claim::Connected } else { Claim::Free },
                }
            }
        }
        Claim::Free
    }

    /// To be asked for the photons that a point of a face gathers within `reach`, m.
    pub fn asked_at<'s>(&'s self, tracing: (&'s World, &'s Optics<M>), at: (DVec3, Site), reach: f64) -> Asked<'s, M> {
        Asked { screens: self, tracing, at, reach, place: None, light: ArrayVec::new(), work: 0 }
    }
}

impl<M: Mode> Connector<M> {
    fn is_connected(&self, sheet: &ReceiverTable<M>, place: &Place) -> bool {
        match sheet.cell(&self.map, &place.spot) {
            Cell::Nothing | Cell::Rim => false,
            Cell::Interpolated | Cell::Solved => place.inside,
        }
    }

    /// How many of a sheet's cells within `reach` of a place are connected; beyond the map none is.
    fn within(&self, sheet: &ReceiverTable<M>, place: &Place, reach: f64) -> Within {
        let (mut some, mut all) = (false, place.inside && self.map.is_inside(&place.spot, reach));
        for cell in self.map.cells_within(&place.spot, reach) {
            match sheet.cells[cell] {
                Cell::Interpolated | Cell::Solved => some = true,
                Cell::Nothing => all = false,
                // A part of it is.
                Cell::Rim => (some, all) = (true, false),
            }
        }
        match (some, all) {
            (false, _) => Within::None,
            (true, false) => Within::Some,
            (true, true) => Within::All,
        }
    }

    /// Whether a path that arrives along `dir` came by a sheet.
    fn is_of(
        &self,
        tracing: (&World, &Optics<M>),
        (entry, sheet): (&Entry<M>, &ReceiverTable<M>),
        (place, reach): (&Place, f64),
        (target, dir): (&Target, DVec3),
        work: &mut u64,
    ) -> bool {
        if place.inside && sheet.cell(&self.map, &place.spot) == Cell::Interpolated {
            *work += cost::READ;
            let off = entry.middle.local(target.point - entry.middle.point);
            let incoming = sheet.interpolate(tracing, (place.spot.cell, &place.spot.rows()), entry.lamp, off);
            return incoming.is_some_and(|incoming| incoming.dir.distance(-dir) <= ABOUT_SAME);
        }
        let found = self.solve_about(tracing, (entry, sheet), (place, reach), target, work);
        found.is_some_and(|found| found.dir.distance(-dir) <= SAME)
    }

    /// Solves where a sheet may have no cell, from the nearest node within `reach`.
    fn solve_about(
        &self,
        tracing: (&World, &Optics<M>),
        (entry, sheet): (&Entry<M>, &ReceiverTable<M>),
        (place, reach): (&Place, f64),
        target: &Target,
        work: &mut u64,
    ) -> Option<Solution> {
        *work += cost::SOLVED * self.chain.0.len() as u64;
        let Place { point, site, spot, .. } = place;
        if self.is_connected(sheet, place) {
            return self.solve(tracing, entry, sheet, spot, (*point, *site), target);
        }
        let far = |node: usize| self.map.offset_of(node, spot).length();
        let about = self.map.cells_within(spot, reach).flat_map(|cell| self.map.nodes.corners(cell));
        let known = spot.nodes().map(|(node, _)| node).chain(about).filter(|node| sheet.nodes[*node].is_some());
        let nearest = known.min_by(|a, b| far(*a).total_cmp(&far(*b)))?;
        let (start, change) = self.foretell_from(entry, sheet, nearest, spot, target)?;
        let found = self.newton(tracing, entry, (*point, *site), start, target)?;
        let cells = (far(nearest) / self.map.cell_size()).max(1.0);
        (found.dir.distance(start) <= FORETOLD * change * cells).then_some(found)
    }
}

/// What a point that gathers knows of claims.
pub struct Asked<'s, M: Mode> {
    screens: &'s Receivers<M>,
    tracing: (&'s World, &'s Optics<M>),
    at: (DVec3, Site),
    reach: f64,
    /// Of the face and train last asked for, where the point lies in its map.
    place: Option<(u16, Option<Place>)>,
    /// Whether branches' light comes here.
    light: ArrayVec<(Branches, bool), KNOWN>,
    /// Counted.
    pub work: u64,
}

impl<M: Mode> Asked<'_, M> {
    /// Whether a photon is not gathered here: connection has what it stands for, or its light ends on the way here.
    pub fn leaves_out(&mut self, claim: Claim) -> bool {
        let (branches, here) = match claim {
            Claim::Free => return false,
            Claim::Connected => return true,
            Claim::Bordering { branches, here } => (branches, here),
        };
        let Some(lit) = self.screens.levels.get(usize::from(branches.lit)).map(|level| &*level.lit) else {
            return here;
        };
        if self.place.is_none_or(|(of, _)| of != branches.lit) {
            self.place = Some((branches.lit, Place::new(lit, self.at, self.reach)));
        }
        let (Some((_, Some(place))), Some(entry)) = (self.place, lit.entries.get(usize::from(branches.entry))) else {
            return here;
        };
        let of = |(bit, _): &(usize, &ReceiverTable<M>)| branches.sheets >> bit & 1 == 1;
        let sheets = || entry.sheets.iter().enumerate().filter(of).map(|(_, sheet)| sheet);
        if sheets().any(|sheet| lit.is_connected(sheet, &place)) {
            return true;
        }
        if !here {
            return false;
        }
        if let Some((_, comes)) = self.light.iter().find(|(known, _)| *known == branches) {
            return !comes;
        }
        // The middle of the lamp stands for all of it.
        let comes = sheets().any(|sheet| {
            let from = (&place, self.reach);
            let found = lit.solve_about(self.tracing, (entry, sheet), from, &entry.middle, &mut self.work);
            self.work += cost::STEP * lit.chain.0.len() as u64;
            found.is_some_and(|found| lit.probe(self.tracing, entry.lamp, self.at, found.dir).is_some())
        });
        if self.light.is_full() {
            self.light.remove(0);
        }
        self.light.push((branches, comes));
        !comes
    }
}
