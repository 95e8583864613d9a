//! The lines of sight of one position, and what they say.

use super::{
    DVec3, Disparities, Disparity, Distances, Eye, Line, Mono, Optics, Point, Position, Sight, Subject, Vergence,
    World, aim, aim_alone, aim_over, arcmin, disparity, distortion, step_m, vergence,
};

/// Fills in what geometry says of a position, that of `eye`.
pub fn fill(position: &mut Position, tracing: (&World, &Optics<Mono>), eye: &Eye, subject: &Subject, ipd_m: f64) {
    let (right, at) = (eye.right(), eye.position);
    let step = step_m(eye);
    let mut seen = Vec::with_capacity(subject.points.len());
    for point in &subject.points {
        let (sight, way) = aim_over(tracing, subject, point, (subject.from, point.near), at);
        let from_here = |shift: DVec3| {
            let known = if std::ptr::eq(way, subject) {
                (at, sight.direction().unwrap_or(point.near))
            } else {
                (subject.from, point.near)
            };
            aim(tracing, subject, point, known, at + shift)
        };
        // How a wave spreads is a matter of one way.
        let alone = |dir: DVec3, shift: DVec3| aim_alone(tracing, way, point, (at, dir), at + shift);
        let line = Line {
            cell: point.cell,
            seen: sight.seen().is_some(),
            direction_deg: sight.direction().map(|dir| angles(dir, eye)),
            vergence: sight.seen().and_then(|dir| {
                let cross = [right, eye.up].map(|axis| [-step, step].map(|shift| alone(dir, axis * shift).seen()));
                let [[Some(left), Some(right_of)], [Some(below), Some(above)]] = cross else { return None };
                vergence(dir, [[left, right_of], [below, above]], [right, eye.up], step)
            }),
            disparity: both(sight, from_here, ipd_m, eye),
        };
        if let Some(dir) = sight.seen() {
            seen.push((point, dir));
        }
        position.points.push(line);
    }
    position.seen = seen.len() as f64 / subject.points.len().max(1) as f64;
    let nearest = seen.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    position.distortion = nearest.and_then(|(_, middle)| {
        let places: Vec<_> = seen.iter().map(|(point, dir)| (point.picture, *dir)).collect();
        distortion(&places, *middle, right)
    });
    position.distance = distances(&position.points, subject);
    position.disparity = disparities(&position.points);
}

fn off(point: &Point) -> f64 {
    point.picture.length()
}

/// What both eyes see of a point; none unless both do.
fn both(sight: Sight, from_here: impl Fn(DVec3) -> Sight, ipd_m: f64, eye: &Eye) -> Option<Disparity> {
    // From nowhere there is no way to either eye.
    sight.direction()?;
    let half = eye.right() * (0.5 * ipd_m);
    let (left, right) = (from_here(-half).seen()?, from_here(half).seen()?);
    Some(disparity(left, right, [eye.right(), eye.up, eye.look]))
}

/// Angles to the right and up of the viewing axis, as a picture has them: atan of the tangents.
fn angles(dir: DVec3, eye: &Eye) -> [f64; 2] {
    let ahead = dir.dot(eye.look);
    [dir.dot(eye.right()), dir.dot(eye.up)].map(|side| side.atan2(ahead).to_degrees())
}

fn distances(lines: &[Line], subject: &Subject) -> Option<Distances> {
    let all = || lines.iter().filter_map(|line| line.vergence);
    let count = all().count();
    if count == 0 {
        return None;
    }
    let middle = subject.points.iter().zip(lines).min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    let means = || all().map(Vergence::mean_per_m);
    Some(Distances {
        centre_per_m: middle.and_then(|(_, line)| line.vergence).map(Vergence::mean_per_m),
        mean_per_m: means().sum::<f64>() / count as f64,
        least_per_m: means().fold(f64::INFINITY, f64::min),
        most_per_m: means().fold(f64::NEG_INFINITY, f64::max),
        astigmatism_per_m: all().map(|v| (v.horizontal_per_m - v.vertical_per_m).abs()).fold(0.0, f64::max),
    })
}

fn disparities(lines: &[Line]) -> Option<Disparities> {
    let all = || lines.iter().filter_map(|line| line.disparity);
    let count = all().count();
    if count == 0 {
        return None;
    }
    let convergences = || all().map(|d| arcmin(d.convergence_rad));
    Some(Disparities {
        seen: count as f64 / lines.len() as f64,
        mean_convergence_arcmin: convergences().sum::<f64>() / count as f64,
        least_convergence_arcmin: convergences().fold(f64::INFINITY, f64::min),
        most_convergence_arcmin: convergences().fold(f64::NEG_INFINITY, f64::max),
        dipvergence_arcmin: all().map(|d| arcmin(d.dipvergence_rad.abs())).fold(0.0, f64::max),
    })
}
