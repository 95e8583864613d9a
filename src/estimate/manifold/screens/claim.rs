//! Whose a path is that a photon has come by. Photons are gathered about where they land, and where cells that are connected
//! border on others kernels reach from one into the other: so that nothing is lost or doubled there, the point that gathers is
//! asked, not the place where a photon landed. In cells that connection leaves to photons all photons are gathered, those
//! from beyond the border, too, if the light that they stand for comes here; in cells that are connected none of them is.

use super::lit::{Entry, Lit};
use super::sheet::{Cell, Sheet};
use super::{ABOUT_SAME, SAME, Screens};
use crate::base::chain::Chain;
use crate::estimate::ledger::cost;
use crate::estimate::manifold::nodes::Spot;
use crate::estimate::manifold::solve::Target;
use crate::world::World;
use crate::world::geometry::Site;
use crate::world::mode::Mode;
use crate::world::optics::Optics;
use arrayvec::ArrayVec;
use glam::DVec3;

/// Branches whose light about a point is known at once.
const KNOWN: usize = 8;

/// Branches of a train for one lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Branches {
    lit: u16,
    entry: u16,
    /// A bit for each sheet.
    sheets: u8,
}

/// Whether connection has the path of a photon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// Nowhere.
    Free,
    /// Wherever it is gathered.
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

/// What a branch's cells are within reach of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    All,
    Some,
    None,
}

impl<M: Mode> Screens<M> {
    /// Whose the path from a point of `lamp` over `chain` (from the lamp) is that arrives at a point of a face along `dir`, for
    /// points that gather it within `reach`, m. Connection's is what [`Screens::gather`] finds for the same ends. Adds to the
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
        let face = |lit: &Lit<M>| (lit.map.part, lit.map.face) == (site.part, site.face) && lit.chain == *chain;
        for (number, lit) in self.lit().enumerate().filter(|(_, lit)| face(lit)) {
            let Some(spot) = lit.map.spot(point) else { continue };
            for (index, entry) in lit.entries.iter().enumerate().filter(|(_, entry)| entry.lamp == lamp) {
                let (mut sheets, mut here, mut whole) = (0, false, false);
                for (bit, sheet) in entry.sheets.iter().enumerate() {
                    let about = lit.within(sheet, &spot, reach);
                    if about == Reach::None
                        || !lit.is_of(tracing, (entry, sheet), (&spot, point, site), (target, dir), work)
                    {
                        continue;
                    }
                    sheets |= 1 << bit;
                    here |= is_connected(sheet.cell(&lit.map, &spot));
                    whole |= about == Reach::All;
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

    /// To be asked for photons that a point of a face gathers.
    pub fn asked_at<'s>(&'s self, tracing: (&'s World, &'s Optics<M>), at: (DVec3, Site)) -> Asked<'s, M> {
        Asked { screens: self, tracing, at, spot: None, light: ArrayVec::new(), work: 0 }
    }
}

fn is_connected(cell: Cell) -> bool {
    match cell {
        Cell::Nothing | Cell::Rim => false,
        Cell::Interpolated | Cell::Solved => true,
    }
}

impl<M: Mode> Lit<M> {
    /// How a sheet's cells within `reach` of a spot are connected.
    fn within(&self, sheet: &Sheet<M>, spot: &Spot, reach: f64) -> Reach {
        let (mut some, mut all) = (false, true);
        for cell in self.map.cells_within(spot, reach) {
            match sheet.cells[cell] {
                Cell::Interpolated | Cell::Solved => some = true,
                Cell::Nothing => all = false,
                // A part of it is.
                Cell::Rim => (some, all) = (true, false),
            }
        }
        match (some, all) {
            (false, _) => Reach::None,
            (true, false) => Reach::Some,
            (true, true) => Reach::All,
        }
    }

    /// Whether a path that arrives along `dir` came by a sheet.
    fn is_of(
        &self,
        tracing: (&World, &Optics<M>),
        (entry, sheet): (&Entry<M>, &Sheet<M>),
        (spot, point, site): (&Spot, DVec3, Site),
        (target, dir): (&Target, DVec3),
        work: &mut u64,
    ) -> bool {
        if sheet.cell(&self.map, spot) == Cell::Interpolated {
            *work += cost::READ;
            let off = entry.middle.local(target.point - entry.middle.point);
            let incoming = sheet.interpolate(tracing, (spot.cell, &spot.rows()), entry.lamp, off);
            return incoming.is_some_and(|incoming| incoming.dir.distance(-dir) <= ABOUT_SAME);
        }
        *work += cost::SOLVED * self.chain.0.len() as u64;
        let found = self.solve(tracing, entry, sheet, spot, (point, site), target);
        found.is_some_and(|found| found.dir.distance(-dir) <= SAME)
    }
}

/// What a point that gathers knows of claims.
pub struct Asked<'s, M: Mode> {
    screens: &'s Screens<M>,
    tracing: (&'s World, &'s Optics<M>),
    at: (DVec3, Site),
    /// Of the face and train last asked for, where the point lies in its map.
    spot: Option<(u16, Option<Spot>)>,
    /// Whether branches' light comes here.
    light: ArrayVec<(Branches, bool), KNOWN>,
    /// Counted.
    pub work: u64,
}

impl<M: Mode> Asked<'_, M> {
    /// Whether a photon is not gathered here: connection has what it stands for, or its light ends on the way here.
    pub fn has(&mut self, claim: Claim) -> bool {
        let (branches, here) = match claim {
            Claim::Free => return false,
            Claim::Connected => return true,
            Claim::Bordering { branches, here } => (branches, here),
        };
        let Some(lit) = self.screens.levels.get(usize::from(branches.lit)).map(|level| &*level.lit) else {
            return here;
        };
        if self.spot.is_none_or(|(of, _)| of != branches.lit) {
            self.spot = Some((branches.lit, lit.map.spot(self.at.0)));
        }
        let (Some((_, Some(spot))), Some(entry)) = (self.spot, lit.entries.get(usize::from(branches.entry))) else {
            return here;
        };
        let of = |(bit, _): &(usize, &Sheet<M>)| branches.sheets >> bit & 1 == 1;
        let sheets = || entry.sheets.iter().enumerate().filter(of).map(|(_, sheet)| sheet);
        if sheets().any(|sheet| is_connected(sheet.cell(&lit.map, &spot))) {
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
            self.work += cost::SOLVED * lit.chain.0.len() as u64;
            let found = lit.solve(self.tracing, entry, sheet, &spot, self.at, &entry.middle);
            found.is_some_and(|found| lit.probe(self.tracing, entry.lamp, self.at, found.dir).is_some())
        });
        if self.light.is_full() {
            self.light.remove(0);
        }
        self.light.push((branches, comes));
        !comes
    }
}
