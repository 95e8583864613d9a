//! The energy ledger: every emitted lumen (lamp side) or unit of importance (eye side), event by event. No entry is a
//! remainder; each is counted where it happens, so the balance is a test.

/// Where light went. Lamp side in lm, eye side in units of importance.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Ledger {
    /// Paths started.
    pub paths: u64,
    pub emitted: f64,
    /// Arrived in the pupil.
    pub arrived: f64,
    /// Left the scene.
    pub escaped: f64,
    /// Taken by a part: its faces' absorption, its coating's, its slide's, its medium's.
    pub absorbed: Vec<f64>,
    /// Sum of `absorbed`, kept as it grows: each path asks for it twice.
    #[serde(skip)]
    absorbed_in_all: f64,
    /// Ended by roulette, or lost by the choice of a wavelength.
    pub roulette_lost: f64,
    /// Added to the survivors of roulette, or of the choice of a wavelength.
    pub roulette_gained: f64,
    /// Met a lamp and stopped there because only its light was asked for, or left the classes that the estimator owns.
    pub not_owned: f64,
    /// A refracted or reflected ray that the interpolated normal of a mesh sends to the wrong side.
    pub wrong_side: f64,
    /// Ended after [`Ledger::MOST_EVENTS`] events.
    pub cut: f64,
    /// Paths that turned NaN or infinite: a fate that is counted, never coloured over.
    pub invalid_paths: u64,
    /// Hits that contradict the solids the path was thought to be in: a crack or an open solid.
    pub mismatches: u64,
    /// Largest |R + T + A − 1| of all specular vertices met, the three computed apart.
    pub vertex_error: f64,
    /// Sum over paths of (emitted − fates)², for the error of the balance.
    imbalance2: f64,
}

impl Ledger {
    /// No path is followed further; roulette has made the carried weight negligible long before.
    pub const MOST_EVENTS: u32 = 1_000_000;

    pub fn new(parts: usize) -> Self {
        Ledger { absorbed: vec![0.0; parts], ..Ledger::default() }
    }

    pub fn absorb(&mut self, part: u32, amount: f64) {
        self.absorbed[part as usize] += amount;
        self.absorbed_in_all += amount;
    }

    /// Notes by how much the shares reflected, transmitted and absorbed at a vertex miss 1.
    pub fn check_vertex(&mut self, error: f64) {
        self.vertex_error = self.vertex_error.max(error);
    }

    /// Books what a random choice added (or took, below 0) on the average of nothing.
    pub fn by_chance(&mut self, amount: f64) {
        if amount > 0.0 {
            self.roulette_gained += amount;
        } else {
            self.roulette_lost -= amount;
        }
    }

    /// Adds the entries of another ledger of the same scene.
    pub fn merge(&mut self, other: &Ledger) {
        self.paths += other.paths;
        self.emitted += other.emitted;
        self.arrived += other.arrived;
        self.absorbed_in_all += other.absorbed_in_all;
        self.escaped += other.escaped;
        self.roulette_lost += other.roulette_lost;
        self.roulette_gained += other.roulette_gained;
        self.not_owned += other.not_owned;
        self.wrong_side += other.wrong_side;
        self.cut += other.cut;
        self.invalid_paths += other.invalid_paths;
        self.mismatches += other.mismatches;
        self.vertex_error = self.vertex_error.max(other.vertex_error);
        self.imbalance2 += other.imbalance2;
        if self.absorbed.len() < other.absorbed.len() {
            self.absorbed.resize(other.absorbed.len(), 0.0);
        }
        self.absorbed.iter_mut().zip(&other.absorbed).for_each(|(a, b)| *a += b);
    }

    /// Sum of all fates minus what roulette added.
    pub fn accounted(&self) -> f64 {
        self.arrived
            + self.escaped
            + self.absorbed_in_all
            + self.roulette_lost
            + self.not_owned
            + self.wrong_side
            + self.cut
            - self.roulette_gained
    }

    /// emitted − accounted.
    pub fn imbalance(&self) -> f64 {
        self.emitted - self.accounted()
    }

    /// Closes one path: `before` is [`Ledger::imbalance`] at its start.
    pub fn close_path(&mut self, before: f64) {
        let own = self.imbalance() - before;
        self.imbalance2 += own * own;
    }

    /// One-sigma error that [`Ledger::imbalance`] should have: scattering weights fluctuate about the albedo.
    pub fn imbalance_sigma(&self) -> f64 {
        self.imbalance2.sqrt()
    }
}
