//! A scene traced to one number, with what its ledger says.

use eyebox_base::Result;
use eyebox_check::check;
use eyebox_estimate::run::{Limits, run};
use eyebox_film::plan::{Estimator, Spectral};
use eyebox_film::rqmc_variance::Evenness;
use eyebox_plan::{Asked, Choice, Polarisation, plan};
use eyebox_scene::Scene;
use eyebox_world::World;

/// How a scene is traced.
#[derive(Debug, Clone, Copy)]
pub struct How {
    pub estimator: Estimator,
    /// None: as the plan decides.
    pub spectral: Option<Spectral>,
    pub polarised: bool,
    pub passes: u64,
    pub seed: u64,
}

impl How {
    /// From the eye.
    pub fn backward(passes: u64) -> How {
        How { estimator: Estimator::Backward, spectral: None, polarised: false, passes, seed: 1 }
    }

    pub fn polarised(self) -> How {
        How { polarised: true, ..self }
    }
}

/// What came of it.
#[derive(Debug, Clone, Copy)]
pub struct Measured {
    /// Mean luminance of the picture, cd/m².
    pub mean: f64,
    /// Its standard error.
    pub sigma: f64,
    /// Share of the emitted light that no fate accounts for; negative: light too much.
    pub loss: f64,
    /// Standard error of the loss that chance explains.
    pub loss_sigma: f64,
    /// Share that ended for reasons of numbers: too many events, the wrong side of a facet.
    pub cut: f64,
    /// Pixels and paths that are not a number.
    pub nan: u64,
    /// Share of hits that contradict the solids the path was in.
    pub mismatches: f64,
    /// Largest |R + T + A − 1|.
    pub vertex_error: f64,
}

/// Traces a scene. Faults: those of checking it and of preparing it for rays.
pub fn trace(scene: &Scene, how: How) -> Result<Measured> {
    let checked = check(scene)?;
    let world = World::freeze(scene)?;
    let polarisation = if how.polarised { Polarisation::On } else { Polarisation::Off };
    let mut plan = plan(&checked, &world, Asked { polarisation, ..Choice::Only(how.estimator).into() });
    if let Some(spectral) = how.spectral {
        plan.mode.spectral = spectral;
    }
    let limits = Limits { passes: Some(how.passes), ..Limits::default() };
    let films = run(&world, &plan, scene.groups.len(), scene.eye.resolution, how.seed, &limits, &mut ()).films;
    let pixels = scene.eye.resolution[0] * scene.eye.resolution[1];
    let count = pixels as f64;
    let (mut sum, mut of_mean, mut nan) = (0.0, 0.0, 0);
    for (_, film, _) in &films.films {
        let (mut variance, mut together) = (0.0, 0.0);
        for pixel in 0..pixels {
            let value: f64 = (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum();
            let noise = film.variance(pixel, film.planes.len());
            if !(value.is_finite() && noise.is_finite()) {
                nan += 1;
                continue;
            }
            sum += value;
            variance += noise;
            together += noise.sqrt();
        }
        // Pixels that share wavelengths may err together.
        of_mean += match film.evenness() {
            Some(Evenness::OfPasses) => (together / count).powi(2),
            Some(Evenness::OfPixels) | None => variance / (count * count),
        };
    }
    let mut out = Measured {
        mean: sum / count,
        sigma: of_mean.sqrt(),
        loss: 0.0,
        loss_sigma: 0.0,
        cut: 0.0,
        nan,
        mismatches: 0.0,
        vertex_error: 0.0,
    };
    if let Some(ledger) = films.ledger(how.estimator) {
        let share = |light: f64| if ledger.emitted > 0.0 { light / ledger.emitted } else { 0.0 };
        out.loss = share(ledger.imbalance());
        out.loss_sigma = share(ledger.imbalance_sigma());
        out.cut = share(ledger.cut + ledger.wrong_side);
        out.nan += ledger.invalid_paths;
        out.mismatches = ledger.mismatches as f64 / ledger.paths.max(1) as f64;
        out.vertex_error = ledger.vertex_error;
    }
    Ok(out)
}
