//! The layer `work`: where the work of tracing went, if pixels got passes of their own.

use super::run::Films;
use eyebox_film::frame::{Channel, Frame, Samples};

/// The name of the layer.
pub const WORK: &str = "work";

/// The counted work of each pixel over that of the picture's mean pixel; none where all pixels got alike. A pass of an estimator
/// counts as the mean of its passes does.
pub fn work(films: &Films) -> Option<Samples> {
    let own = films.films.iter().filter_map(|(_, film, ledger)| Some((film.sample_map()?, ledger.work as f64)));
    let own: Vec<_> = own.map(|(map, work)| (map, work, work / map.mean().max(f64::MIN_POSITIVE))).collect();
    let (first, all) = (own.first()?, films.films.iter().map(|(_, _, ledger)| ledger.work as f64).sum::<f64>());
    // What is traced for the whole picture at once is shared by its pixels.
    let shared = all - own.iter().map(|(_, work, _)| work).sum::<f64>();
    let of_pixel = |pixel: usize| {
        let mapped = own.iter().map(|(map, _, per_pass)| per_pass * map.made(pixel) as f64).sum::<f64>();
        ((shared + mapped) / all.max(1.0)) as f32
    };
    Some((0..first.0.pixels()).map(of_pixel).collect())
}

/// Adds it, grey.
pub fn add_work(frame: &mut Frame, work: Samples) {
    // Grey is stored three times, and held once.
    let channel = |name| Channel { name: format!("{WORK}.{name}"), data: work.clone() };
    frame.channels.extend(["R", "G", "B"].map(channel));
}
