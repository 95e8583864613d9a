//! The energy ledger: every emitted lumen (lamp side) or unit of importance (eye side), event by event. No entry is a
//! remainder; each is counted where it happens, so the balance is a test.

use eyebox_base::double_double::Sum;

/// What the steps of tracing cost, in sixteenths of a ray: a fixed table, so that counted work is the same on any machine.
///
/// Fitted by least squares to the CPU seconds that each estimator took on the scenes of `eyebox bench --generate 0..6`
/// (one thread of an Intel Xeon; 79 runs of 0.05 to 8 s) and to how often each made which step. With these numbers a
/// sixteenth took 37 ns in the median: 35 of backward, 36 of manifold, 40 of forward and photon; extremes were 26 and 55.
pub mod cost {
    /// Following a path to the next face and turning there.
    pub const STEP: u64 = 16;
    /// Asking whether a lamp is seen from a scatterer.
    pub const SHADOW: u64 = 12;
    /// Keeping a photon for gathering.
    pub const STORED: u64 = 2;
    /// Gathering a photon within reach, with looking at those that are not.
    pub const GATHERED: u64 = 12;
    /// Solving for a specular connection, per face of its train.
    pub const SOLVED: u64 = 16;
    /// Reading one off a table.
    pub const READ: u64 = 5;
    /// Cutting a piece of a slide's picture out of a pixel's footprint.
    pub const CUT: u64 = 1;
    /// Adding a pixel's light of a pass to the film.
    pub const KEPT: u64 = 5;
}

/// Where light went. Lamp side in lm, eye side in units of importance.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Ledger {
    /// Paths started.
    pub paths: u64,
    /// Counted work, see [`cost`].
    #[serde(skip)]
    pub work: u64,
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
    /// What rounding left of merged sums, in the order of [`Ledger::books`]; empty before the first merge.
    #[serde(skip)]
    low: Vec<f64>,
}

/// A ledger as it is stored: its sums in two doubles.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Books {
    paths: u64,
    #[serde(default)]
    work: u64,
    invalid_paths: u64,
    mismatches: u64,
    vertex_error: f64,
    sums: Vec<Sum>,
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

    /// Adds the entries of another ledger of the same scene. What rounding leaves is carried on, so that the sums do not
    /// depend on the pieces that a run was cut into.
    pub fn merge(&mut self, other: &Ledger) {
        self.paths = self.paths.saturating_add(other.paths);
        self.work = self.work.saturating_add(other.work);
        self.invalid_paths = self.invalid_paths.saturating_add(other.invalid_paths);
        self.mismatches = self.mismatches.saturating_add(other.mismatches);
        self.vertex_error = self.vertex_error.max(other.vertex_error);
        let mut books = self.books();
        let theirs = other.books();
        if books.sums.len() < theirs.sums.len() {
            books.sums.resize(theirs.sums.len(), Sum::ZERO);
        }
        books.sums.iter_mut().zip(&theirs.sums).for_each(|(sum, more)| sum.merge(*more));
        self.take(&books.sums);
    }

    /// Everything in it, to be stored.
    pub fn books(&self) -> Books {
        let own = [
            self.emitted,
            self.arrived,
            self.escaped,
            self.absorbed_in_all,
            self.roulette_lost,
            self.roulette_gained,
            self.not_owned,
            self.wrong_side,
            self.cut,
            self.imbalance2,
        ];
        let low = |k: usize| self.low.get(k).copied().unwrap_or(0.0);
        let all = own.into_iter().chain(self.absorbed.iter().copied());
        Books {
            paths: self.paths,
            work: self.work,
            invalid_paths: self.invalid_paths,
            mismatches: self.mismatches,
            vertex_error: self.vertex_error,
            sums: all.enumerate().map(|(k, high)| Sum { high, low: low(k) }).collect(),
        }
    }

    /// The ledger of a scene of `parts` parts that these books tell of; none if they are of another scene.
    pub fn of_books(books: &Books, parts: usize) -> Option<Ledger> {
        let mut ledger = Ledger {
            paths: books.paths,
            work: books.work,
            invalid_paths: books.invalid_paths,
            mismatches: books.mismatches,
            vertex_error: books.vertex_error,
            ..Ledger::default()
        };
        ledger.take(&books.sums);
        (books.sums.len().checked_sub(Self::AMOUNTS) == Some(parts)).then_some(ledger)
    }

    /// Sums that are not of one part.
    const AMOUNTS: usize = 10;

    fn take(&mut self, sums: &[Sum]) {
        let mut high = sums.iter().map(|sum| sum.high);
        for amount in [
            &mut self.emitted,
            &mut self.arrived,
            &mut self.escaped,
            &mut self.absorbed_in_all,
            &mut self.roulette_lost,
            &mut self.roulette_gained,
            &mut self.not_owned,
            &mut self.wrong_side,
            &mut self.cut,
            &mut self.imbalance2,
        ] {
            *amount = high.next().unwrap_or(0.0);
        }
        self.absorbed = high.collect();
        self.low = sums.iter().map(|sum| sum.low).collect();
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
