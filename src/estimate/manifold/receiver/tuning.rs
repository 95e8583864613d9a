//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `build.rs`
/// - `EVEN`: `be4eada` (Photons of two radii that know where faces end)
/// - `UNEVEN`: `b5eec8d` (Folds are left to photons)
/// - `ASIDE`: `73d3e8a` (Specular connection)
/// - `BESIDE`: `193b03a` (Screens: tables ask single rays where they asked the solver)
pub(super) mod build {
    /// Largest difference of the mean over a lamp from its middle, as a share, that is let pass.
    pub const EVEN: f64 = 2e-3;
    /// The same of any of its points from its middle; beyond it photons do better.
    pub const UNEVEN: f64 = 0.25;
    /// Where a lamp's points are tried, of its radius: corners of a square are a little farther out.
    pub const ASIDE: f64 = 0.7;
    /// How far from there a ray may meet the lamp instead, of that.
    pub const BESIDE: f64 = 0.1;
}

/// `mod.rs`
/// - `TOLERANCE`, `SAME`, `ABOUT_SAME`, `MOST_SHEETS`: `73d3e8a` (Specular connection)
/// - `MOST_SLACK`, `NEARLY_SAME`, `FEWEST_LAMPS`: `abfdbf4` (Diffuse: lens ghosts are found by photons that part, connected
///   where they matter, and seen without spikes)
/// - `FORETOLD`: `be4eada` (Photons of two radii that know where faces end)
/// - `WORTH_EVERY_LAMP`: `9c1ba64` (Screens: finer maps of lit faces wait for the passes that pay for them; weak trains ask
///   fewer lamps)
pub(super) mod receiver {
    /// Largest error of an interpolated strength or direction (radians) that is let pass, for a train that has all light of a
    /// face; one with less may err more, but no more than `MOST_SLACK` times as much.
    pub const TOLERANCE: f64 = 3e-4;
    pub const MOST_SLACK: f64 = 10.0;
    /// Directions nearer than this, in radians, are the same solution.
    pub const SAME: f64 = 1e-6;
    /// The same where one is interpolated for the same point of the lamp, in tolerances, and for another point.
    pub const NEARLY_SAME: f64 = 3.0;
    pub const ABOUT_SAME: f64 = 1e-2;
    /// How far a solution may lie from where it is foretold, in what the direction changes by over a cell: farther off it is another
    /// branch's.
    pub const FORETOLD: f64 = 0.5;
    /// What a train brings of a face's light, times what the eye sees of that, from which on every lamp is asked. Of less it
    /// is some of them, one at least, and what they bring stands for all.
    pub const WORTH_EVERY_LAMP: f64 = 2e-2;
    pub const FEWEST_LAMPS: f64 = 1.0 / 16.0;
    /// Sheets of one train and lamp.
    pub const MOST_SHEETS: usize = 4;
}

/// `ownership.rs`
/// - `4951ede` (Mends a fresh reader asked for)
pub(super) mod ownership {
    /// Branches whose light about a point is known at once.
    pub const KNOWN: usize = 64;
}

/// `resolution.rs`
/// - `CELLS`, `CELL`, `ORDER`: `76c22d1` (Screens: maps of faces are as fine as pays)
/// - `COARSE`: `be4eada` (Photons of two radii that know where faces end)
/// - `RUN`: `9c1ba64` (Screens: finer maps of lit faces wait for the passes that pay for them; weak trains ask fewer lamps)
pub(super) mod resolution {
    /// Cells along the longer side of a face's map.
    pub const CELLS: [usize; 4] = [16, 24, 32, 48];
    /// Of a pilot, and first of a train with little of the light.
    pub const COARSE: usize = 8;
    /// What a cell costs to fill and to try, in connections that are solved for.
    pub const CELL: f64 = 2.0;
    /// Passes of a run, in each of which a pixel asks for a connection. What pays for so many is not far from the best for a
    /// half or twice of them.
    pub const RUN: f64 = 32.0;
    /// How much is saved where what errs is interpolated between nodes half as far from each other: by cubics.
    pub const ORDER: i32 = 4;
}

/// `surface_param.rs`
/// - `INSIDE`: `73d3e8a` (Specular connection)
/// - `RING`: `9075b73` (Screens: the edge of a display is connected, too; what is blended lies close together)
/// - `BEYOND`: `91246b4` (Connections with the eye are read from tables, which a few solutions correct)
pub(super) mod surface_param {
    /// The box of what a pilot found is a little smaller than what is lit; the grid within the ring stays this share inside of it,
    /// so that its nodes have solutions.
    pub const INSIDE: f64 = 2e-3;
    /// Cells about that on each side, for what is lit there: there the tables tell where it ends.
    pub const RING: usize = 1;
    /// How far into the ring connections are tried where tables do not know where the light ends, cells: it is a sliver, and
    /// most of what is tried is dark.
    pub const BEYOND: f64 = 0.04;
}

/// `table.rs`
/// - `SLIDES`: `91246b4` (Connections with the eye are read from tables, which a few solutions correct)
/// - `QUADS`: `193b03a` (Screens: tables ask single rays where they asked the solver)
pub(super) mod table {
    /// Slides that a train may cross to be interpolated.
    pub const SLIDES: usize = 2;
    /// Most quads of a node's numbers that are blended with others: direction, strength per lane, places on slides.
    pub const QUADS: usize = 4;
}
