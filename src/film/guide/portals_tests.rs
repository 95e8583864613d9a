//! Windows as a density of directions, and what a plan's file may say of them.

use super::*;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::Moments;
use eyebox_base::warp::sphere;

/// Learned from light that comes through a square of the upper z side into the middle of the box, and some of a low x one.
fn learned() -> Portals {
    let mut rng = Rng::new(1, Stream::Check, 0, 0);
    let entry = |k: usize| {
        let [a, b] = rng.pair();
        let to = DVec3::new(0.4, 1.0, 0.7);
        let on = if k < 1600 { DVec3::new(1.0 + 0.3 * a, 0.5 + 0.3 * b, 1.0) } else { DVec3::new(0.0, a, b) };
        Entry { to, from: (on - to).normalize(), weight: 1.0 }
    };
    let entries: Vec<Entry> = (0..2000).map(entry).collect();
    Portals::learn((DVec3::ZERO, DVec3::new(2.0, 1.5, 1.0)), 0.5, &entries).unwrap()
}

const POINTS: [DVec3; 3] = [DVec3::new(0.4, 1.0, 0.7), DVec3::new(1.9, 0.1, 0.0), DVec3::new(1.1, 0.6, 0.99)];

#[test]
fn the_density_is_that_of_what_is_drawn() {
    let windows = learned();
    for (index, point) in POINTS.into_iter().enumerate() {
        let mut rng = Rng::new(2, Stream::Check, 0, index as u64);
        let [mut whole, mut by_draws, mut by_chance] = [Moments::default(); 3];
        // An integrand with a shape, by directions of its own and by uniform ones.
        let shape = |dir: DVec3| 1.0 + dir.x + 2.0 * dir.z * dir.y;
        for _ in 0..400_000 {
            let dir = sphere(rng.pair());
            let pdf = windows.pdf(point, dir);
            whole.add(pdf * 4.0 * std::f64::consts::PI);
            by_chance.add(pdf * shape(dir) * 4.0 * std::f64::consts::PI);
            let own = windows.direction(point, rng.pair());
            assert!(windows.pdf(point, own) > 0.0, "{point} {own}");
            by_draws.add(shape(own));
        }
        assert!((whole.mean - 1.0).abs() < 4.5 * whole.stderr(), "{point}: {} ± {}", whole.mean, whole.stderr());
        let error = by_draws.stderr().hypot(by_chance.stderr());
        assert!((by_draws.mean - by_chance.mean).abs() < 4.5 * error, "{point}: {by_draws:?} {by_chance:?}");
    }
}

#[test]
fn it_goes_where_light_came_from() {
    let windows = learned();
    let mut rng = Rng::new(3, Stream::Check, 0, 0);
    let through = |point: DVec3, dir: DVec3| {
        let on = point + dir * ((1.0 - point.z) / dir.z);
        dir.z > 0.0 && (0.95..1.35).contains(&on.x) && (0.45..0.85).contains(&on.y)
    };
    let hits = (0..1000).filter(|_| through(POINTS[1], windows.direction(POINTS[1], rng.pair()))).count();
    assert!((700..900).contains(&hits), "{hits}");
    // From outside nothing is aimed at.
    let outside = DVec3::new(3.0, 0.5, 0.5);
    assert_eq!((windows.aimed_from(outside), windows.among(outside, DVec3::X, 0.3)), (0.0, 0.3));
    assert_eq!(windows.pdf(outside, -DVec3::X), 0.0);
}

#[test]
fn little_light_teaches_nothing() {
    let entry = Entry { to: POINTS[0], from: DVec3::Z, weight: 1.0 };
    let bounds = (DVec3::ZERO, DVec3::ONE * 2.0);
    assert!(Portals::learn(bounds, 0.5, &[entry; FEWEST - 1]).is_none());
    assert!(Portals::learn(bounds, 0.5, &[entry; FEWEST]).is_some());
    let bad =
        [Entry { weight: f64::NAN, ..entry }, Entry { from: DVec3::NAN, ..entry }, Entry { to: DVec3::NAN, ..entry }];
    assert!(Portals::learn(bounds, 0.5, &bad.repeat(FEWEST)).is_none());
    // A scene without room has no windows.
    assert!(Portals::learn((DVec3::ZERO, DVec3::ZERO), 0.5, &[Entry { to: DVec3::ZERO, ..entry }; FEWEST]).is_none());
}

#[test]
fn what_cannot_be_is_refused() {
    let windows = learned();
    let text = serde_json::to_value(&windows).unwrap();
    assert_eq!(serde_json::from_value::<Portals>(text.clone()).unwrap(), windows);
    let said = |pointer: &str, value: serde_json::Value| {
        let mut other = text.clone();
        *other.pointer_mut(pointer).unwrap() = value;
        serde_json::from_value::<Portals>(other).unwrap_err().to_string()
    };
    assert!(said("/low/0", 5.0.into()).contains("has a box"));
    assert!(said("/high/1", 1e200.into()).contains("has a box"));
    for aimed in [0.0, 1.0, -1.0] {
        assert!(said("/aimed", aimed.into()).contains("of the directions"));
    }
    assert!(said("/shares/0", (-0.1).into()).contains("shares"));
    assert!(said("/shares/5", 1.5.into()).contains("shares"));
    assert!(said("/trees", serde_json::json!([])).contains("trees"));
    // A cut across the first axis, which is no place on a side.
    let cut = serde_json::json!({"axes": [0, 4, 4], "cuts": [[0.5, 0.25]]});
    assert!(said("/trees/2", cut).contains("no side"));
}
