//! Numbers of this room that no formula gives, file by file. The commits that are named chose them: their messages tell on
//! which scenes, and what was measured.

/// `run.rs`
/// - `1de0e15` (A stated error covers runs of which few pixels have most of the error)
pub(super) mod run {
    /// How much larger than `Films::relative_error` a true error may be.
    pub const LEEWAY: f64 = 1.2;
    /// Of the error that is asked for, so much may be light that no ray has met.
    pub const MISSED: f64 = 0.5;
}

/// `adaptive.rs` and `drive.rs`: chosen when passes came to go to where the error is.
pub(super) mod adaptive {
    /// Passes of all pixels before any gets passes of its own: fewer tell no variance.
    pub const BASE: u64 = 2;
    /// No pixel has fewer passes than this share of the mean, and no estimator less of the work.
    pub const FLOOR: f64 = 0.125;
    pub const FLOOR_OF_WORK: f64 = 1.0 / 16.0;
    /// A round may cost so much of the work before it.
    pub const SHARE_OF_WORK: f64 = 0.5;
    /// Of the squared error that is asked for, so much is aimed at, or a further round is needed as often as not.
    pub const AIM: f64 = 0.95;
    /// What exceeds the mean of its eight neighbours so many times is not foreseen by them: the end of a line has one of them.
    pub const FORESEEN: f64 = 9.0;
    /// Pixels of a block, along each side, over which that is spread.
    pub const BLOCK: usize = 16;
    /// Fewer of them than this in a block foresee nothing.
    pub const ALONE: f64 = 4.0;
    /// How many times more passes pixels are drawn for in which the plan has rays aimed at lamps.
    pub const AIMED: f64 = 32.0;
    /// What a pixel is taken to have at the least when pixels are drawn, of the mean of what is foreseen.
    pub const LEAST_DRAWN: f64 = 0.05;
}

/// `outlook.rs`. A second of one thread is some 2.7·10⁷ units of counted work (`ledger.rs`).
pub(super) mod outlook {
    /// Before so much work nothing is foretold: a minute or two.
    pub const LEAST_WORK: f64 = 2e9;
    /// More than this is not done for an error alone: ten minutes.
    pub const MOST_WORK: f64 = 1.6e10;
    /// How the error falls is told by what it was when this many times less work had been done.
    pub const SPAN: f64 = 4.0;
    /// Errors are taken to fall with this power of the work at least.
    pub const LEAST: f64 = 0.02;
}
