//! The sums of a sensor's passes, and the map that is made of them.

use super::Setting;
use super::tuning::map::COVERED;
use eyebox_base::error::Result;
use eyebox_base::stats::Moments;
use eyebox_base::{Error, Where};
use eyebox_estimate::sensor::Caught;
use eyebox_world::sensor::{SensorFace, Side};
use glam::DVec3;

/// A value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Level {
    pub value: f64,
    /// None with fewer than two passes.
    pub stderr: Option<f64>,
}

/// What a light group gives to a side.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Share {
    pub group: String,
    /// Over the face, lx.
    pub mean_lx: Level,
    /// W/m² from 360 to 830 nm, where spectra are told.
    pub mean_w_m2: Option<Level>,
}

/// The brightest pixel of a side.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Peak {
    /// lx
    pub value: f64,
    pub stderr: Option<f64>,
    /// Column and row, from 0 at the upper left.
    pub pixel: [usize; 2],
    /// Of its middle from that of the map, to the right and up, m.
    pub place_m: [f64; 2],
}

/// The light on one side of a face.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SideMap {
    pub side: Side,
    /// Over the face, lx.
    pub mean_lx: Level,
    pub mean_w_m2: Option<Level>,
    /// lm
    pub flux_lm: Level,
    /// None where no light arrived.
    pub peak: Option<Peak>,
    pub groups: Vec<Share>,
    /// Per pixel, row by row from the upper left: lx, its standard error (NaN where it is unknown), W/m². 0 where the face is not.
    #[serde(skip)]
    pub illuminance_lx: Vec<f64>,
    #[serde(skip)]
    pub stderr_lx: Vec<f64>,
    #[serde(skip)]
    pub irradiance_w_m2: Option<Vec<f64>>,
}

/// What a sensor measured. Places and directions are those of the scene's world (+y up), m.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SensorMap {
    pub part: String,
    pub face: usize,
    /// Columns and rows.
    pub pixels: [usize; 2],
    /// Width and height of the map.
    pub size_m: [f64; 2],
    /// Its middle.
    pub centre_m: [f64; 3],
    /// Unit, to the right, up, and out of the front.
    pub u: [f64; 3],
    pub v: [f64; 3],
    pub normal: [f64; 3],
    /// Of the face.
    pub area_m2: f64,
    pub sides: Vec<SideMap>,
    /// The root of the mean square of the pixels' standard errors over that of their illuminances, both sides together; none
    /// where no light arrived or one pass alone was made.
    pub error: Option<f64>,
    pub passes: u64,
    pub paths: u64,
    /// Share of each pixel's area that the face has.
    #[serde(skip)]
    pub coverage: Vec<f64>,
}

/// Sums over passes.
pub(super) struct Sums {
    passes: u64,
    /// `[side][pixel]`: of illuminances, lx.
    pixels: [Vec<Moments>; 2],
    /// `[side][pixel]`: sums of fluxes, W.
    watts: [Vec<f64>; 2],
    /// `[side][group]`: fluxes, lm and W; the last is of all groups.
    shares: [Vec<[Moments; 2]>; 2],
    /// `[side][pixel]`: of the pass, lm.
    pass: [Vec<f64>; 2],
}

impl Sums {
    pub(super) fn new(sensor: &SensorFace, groups: usize) -> Sums {
        let count = sensor.areas_m2().len();
        let two = |_| vec![0.0; count];
        Sums {
            passes: 0,
            pixels: [0, 1].map(|_| vec![Moments::default(); count]),
            watts: [0, 1].map(two),
            shares: [0, 1].map(|_| vec![<[Moments; 2]>::default(); groups + 1]),
            pass: [0, 1].map(two),
        }
    }

    pub(super) fn passes(&self) -> u64 {
        self.passes
    }

    /// Adds what a pass has caught.
    pub(super) fn add(&mut self, sensor: &SensorFace, caught: impl Iterator<Item = Caught>) {
        let groups = self.shares[0].len();
        let mut shares = [0, 1].map(|_| vec![[0.0; 2]; groups]);
        self.pass.iter_mut().for_each(|pass| pass.fill(0.0));
        for one in caught {
            let (side, pixel) = (one.side as usize, one.pixel as usize);
            self.pass[side][pixel] += one.lumens;
            self.watts[side][pixel] += one.watts;
            for group in [one.group.index(), groups - 1] {
                shares[side][group][0] += one.lumens;
                shares[side][group][1] += one.watts;
            }
        }
        for (side, shares) in shares.iter().enumerate() {
            for ((sum, lumens), area) in self.pixels[side].iter_mut().zip(&self.pass[side]).zip(sensor.areas_m2()) {
                sum.add(if *area > 0.0 { lumens / area } else { 0.0 });
            }
            for (sums, share) in self.shares[side].iter_mut().zip(shares) {
                sums.iter_mut().zip(share).for_each(|(sum, flux)| sum.add(*flux));
            }
        }
        self.passes += 1;
    }

    pub(super) fn is_black(&self) -> bool {
        self.shares.iter().flatten().flatten().all(|sum| sum.mean == 0.0)
    }

    /// [`SensorMap::error`].
    pub(super) fn error(&self, sensor: &SensorFace) -> Option<f64> {
        let sum = |of: &dyn Fn(&Moments) -> f64| -> f64 {
            let side = |pixels: &Vec<Moments>| -> f64 {
                pixels.iter().zip(sensor.areas_m2()).map(|(pixel, area)| area * of(pixel).powi(2)).sum()
            };
            self.pixels.iter().map(side).sum()
        };
        let light = sum(&|pixel| pixel.mean);
        (light > 0.0 && self.passes > 1).then(|| (sum(&|pixel| pixel.stderr()) / light).sqrt())
    }

    /// Errors: light that is not finite.
    pub(super) fn map(&self, setting: &Setting<'_>, sensor: &SensorFace, paths: u64) -> Result<SensorMap> {
        let owner = &setting.scene.parts[sensor.part as usize];
        let finite = self.shares.iter().flatten().flatten().all(|sum| sum.mean.is_finite());
        if !finite {
            let at = Where::Part { path: owner.path.clone(), face: Some(sensor.face as usize) };
            return Err(Error::new(at, "the light at the sensor is not finite"));
        }
        let place = sensor.centre() + setting.world.geometry.origin();
        let [u, v, normal] = sensor.axes();
        let whole = sensor.pixel_area_m2();
        let coverage: Vec<f64> =
            sensor.areas_m2().iter().map(|area| if whole > 0.0 { area / whole } else { 0.0 }).collect();
        Ok(SensorMap {
            part: owner.path.clone(),
            face: sensor.face as usize,
            pixels: sensor.pixels,
            size_m: sensor.size_m(),
            centre_m: place.to_array(),
            u: DVec3::to_array(&u),
            v: v.to_array(),
            normal: normal.to_array(),
            area_m2: sensor.area_m2(),
            sides: Side::BOTH.into_iter().map(|side| self.side(setting, (sensor, &coverage), side)).collect(),
            error: self.error(sensor),
            passes: self.passes,
            paths,
            coverage,
        })
    }

    fn side(&self, setting: &Setting<'_>, (sensor, coverage): (&SensorFace, &[f64]), side: Side) -> SideMap {
        let stderr = |sum: &Moments| (self.passes > 1).then(|| sum.stderr());
        let level = |sum: &Moments, over: f64| Level { value: sum.mean / over, stderr: stderr(sum).map(|e| e / over) };
        let area = sensor.area_m2();
        let watts = |sum: &Moments| setting.tells_watts.then(|| level(sum, area));
        let (shares, pixels) = (&self.shares[side as usize], &self.pixels[side as usize]);
        let of_group = |(group, [lumens, power]): (&eyebox_scene::Group, &[Moments; 2])| Share {
            group: group.name.clone(),
            mean_lx: level(lumens, area),
            mean_w_m2: watts(power),
        };
        let [all, power] = shares[shares.len() - 1];
        let most = coverage.iter().copied().fold(0.0, f64::max);
        let counts = |pixel: usize| coverage[pixel] >= COVERED * most.min(1.0) && pixels[pixel].mean > 0.0;
        let brighter = |a: usize, b: usize| if pixels[b].mean > pixels[a].mean { b } else { a };
        let peak = (0..pixels.len()).filter(|pixel| counts(*pixel)).reduce(brighter).map(|pixel| {
            let [columns, rows] = sensor.pixels;
            let at = [pixel % columns, pixel / columns];
            let [width, height] = sensor.size_m();
            let right = ((at[0] as f64 + 0.5) / columns as f64 - 0.5) * width;
            let up = (0.5 - (at[1] as f64 + 0.5) / rows as f64) * height;
            let of = &pixels[pixel];
            Peak { value: of.mean, stderr: stderr(of), pixel: at, place_m: [right, up] }
        });
        let count = self.passes.max(1) as f64;
        let per_area = |(watts, area): (&f64, &f64)| if *area > 0.0 { watts / (area * count) } else { 0.0 };
        SideMap {
            side,
            mean_lx: level(&all, area),
            mean_w_m2: watts(&power),
            flux_lm: level(&all, 1.0),
            peak,
            groups: setting.scene.groups.iter().zip(shares).map(of_group).filter(|of| of.mean_lx.value > 0.0).collect(),
            illuminance_lx: pixels.iter().map(|of| of.mean).collect(),
            stderr_lx: pixels.iter().map(|of| stderr(of).unwrap_or(f64::NAN)).collect(),
            irradiance_w_m2: setting
                .tells_watts
                .then(|| self.watts[side as usize].iter().zip(sensor.areas_m2()).map(per_area).collect()),
        }
    }
}
