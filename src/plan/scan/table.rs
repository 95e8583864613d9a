//! A scan as text and as CSV.

use super::edges::{Edge, Edges, Extent};
use super::ghosts::Ghost;
use super::light::Level;
use super::{Position, Scan};
use eyebox_estimate::virtual_image::subject::{Kind, is_too_much};

/// A column of the table of positions: name with unit, and value.
type Column = (&'static str, fn(&Position) -> Option<f64>);

const COLUMNS: [Column; 24] = [
    ("x_mm", |p| Some(1e3 * p.x_m)),
    ("y_mm", |p| Some(1e3 * p.y_m)),
    ("seen", |p| Some(p.seen)),
    ("cut_off", |p| Some(p.cut)),
    ("centre_cd_m2", |p| Some(p.luminance?.centre?.value)),
    ("centre_sigma_cd_m2", |p| p.luminance?.centre?.sigma),
    ("mean_cd_m2", |p| Some(p.luminance?.mean?.value)),
    ("mean_sigma_cd_m2", |p| p.luminance?.mean?.sigma),
    ("patches", |p| Some(p.luminance?.patches as f64)),
    ("uniformity", |p| Some(p.luminance?.uniformity?.value)),
    ("distortion_max_percent", |p| Some(p.distortion?.max_percent)),
    ("distortion_rms_percent", |p| Some(p.distortion?.rms_percent)),
    ("distortion_max_arcmin", |p| Some(p.distortion?.max_arcmin)),
    ("distortion_rms_arcmin", |p| Some(p.distortion?.rms_arcmin)),
    ("vergence_centre_per_m", |p| p.distance?.centre_per_m),
    ("vergence_mean_per_m", |p| Some(p.distance?.mean_per_m)),
    ("vergence_least_per_m", |p| Some(p.distance?.least_per_m)),
    ("vergence_most_per_m", |p| Some(p.distance?.most_per_m)),
    ("astigmatism_per_m", |p| Some(p.distance?.astigmatism_per_m)),
    ("seen_by_both", |p| Some(p.disparity.map_or(0.0, |d| d.seen))),
    ("convergence_mean_arcmin", |p| Some(p.disparity?.mean_convergence_arcmin)),
    ("convergence_least_arcmin", |p| Some(p.disparity?.least_convergence_arcmin)),
    ("convergence_most_arcmin", |p| Some(p.disparity?.most_convergence_arcmin)),
    ("dipvergence_most_arcmin", |p| Some(p.disparity?.dipvergence_arcmin)),
];

/// One line per position after a line of names; what there is none of is empty.
pub fn csv(scan: &Scan) -> String {
    let mut out = COLUMNS.map(|(name, _)| name).join(",");
    out.push('\n');
    for position in &scan.positions {
        let cell = |(_, value): &Column| value(position).map_or(String::new(), |value| format!("{value:.9}"));
        out.push_str(&COLUMNS.iter().map(cell).collect::<Vec<_>>().join(","));
        out.push('\n');
    }
    out
}

/// One line per position, ghost and point, after a line of names.
pub fn ghosts_csv(scan: &Scan) -> String {
    let mut out = "x_mm,y_mm,ghost,column,row,right_deg,up_deg,right_arcmin,up_arcmin,ratio\n".to_owned();
    for position in &scan.positions {
        for ghost in &position.ghosts {
            for point in &ghost.points {
                let main = position.points.iter().find(|line| line.cell == point.cell);
                let Some([right, up]) = main.and_then(|line| line.direction_deg) else { continue };
                let ([column, row], [to_right, to_up]) = (point.cell, point.separation_arcmin);
                let (x, y) = (1e3 * position.x_m, 1e3 * position.y_m);
                // Parts may have commas and quotes in their names.
                let by = ghost.by.replace('"', "\"\"");
                out.push_str(&format!(
                    "{x:.9},{y:.9},\"{by}\",{column},{row},{right:.9},{up:.9},{to_right:.9},{to_up:.9},{:.9}\n",
                    point.ratio
                ));
            }
        }
    }
    out
}

/// One line per figure and way out, after a line of names; lengths in mm.
pub fn edges_csv(edges: &Edges) -> String {
    let mut out =
        "figure,left_mm,right_mm,down_mm,up_mm,width_mm,height_mm,left_sigma_mm,right_sigma_mm,down_sigma_mm,\
                   up_sigma_mm\n"
            .to_owned();
    let cell = |m: Option<f64>| m.map_or(String::new(), |m| format!("{:.9}", 1e3 * m));
    for extent in &edges.figures {
        let ways = ways(extent);
        let distances = ways.map(|edge| cell(edge.map(|edge| edge.distance_m)));
        let sigmas = ways.map(|edge| cell(edge.and_then(|edge| edge.sigma_m)));
        let sides = [extent.width_m(), extent.height_m()].map(cell);
        let name = extent.figure.name();
        out.push_str(&format!("\"{name}\",{},{},{}\n", distances.join(","), sides.join(","), sigmas.join(",")));
    }
    out
}

fn ways(extent: &Extent) -> [Option<Edge>; 4] {
    [extent.left, extent.right, extent.down, extent.up]
}

/// Where the eyebox ends.
fn edges(edges: &Edges) -> Vec<String> {
    let [across, upwards] = edges.reach_m.map(|m| 1e3 * m);
    if edges.figures.is_empty() {
        return vec!["eyebox edges: none: nothing of the picture is seen from its middle".to_owned()];
    }
    let mut out = vec![format!(
        "eyebox edges, where less than half of what its middle has is left, mm from there (looked as far as {across:.0} and \
         {upwards:.0} mm):"
    )];
    let head = ["left", "right", "down", "up", "width", "height"].map(|name| format!("{name:>18}"));
    out.push(format!("  {:<24}{}", "", head.concat()));
    let length = |m: Option<f64>, sigma: Option<f64>| {
        let text = m.map_or("beyond".to_owned(), |m| format!("{:.3}", 1e3 * m));
        let text = sigma.map_or(text.clone(), |sigma| format!("{text} ± {:.3}", 1e3 * sigma));
        format!("{text:>18}")
    };
    out.extend(edges.figures.iter().map(|extent| {
        let ways =
            ways(extent).map(|edge| length(edge.map(|edge| edge.distance_m), edge.and_then(|edge| edge.sigma_m)));
        let sides = [extent.width_m(), extent.height_m()].map(|side| length(side, None));
        format!("  {:<24}{}{}", extent.figure.name(), ways.concat(), sides.concat())
    }));
    out
}

/// Each second image over the whole eyebox, those with most light first.
fn ghosts(scan: &Scan) -> Vec<String> {
    let mut rows: Vec<(&str, Vec<&Ghost>)> = Vec::new();
    for ghost in scan.positions.iter().flat_map(|position| &position.ghosts) {
        match rows.iter_mut().find(|(by, _)| *by == ghost.by) {
            Some((_, all)) => all.push(ghost),
            None => rows.push((&ghost.by, vec![ghost])),
        }
    }
    let most = |all: &[&Ghost], of: fn(&Ghost) -> f64| all.iter().map(|ghost| of(ghost)).fold(0.0, f64::max);
    rows.sort_by(|a, b| most(&b.1, |g| g.most_ratio).total_cmp(&most(&a.1, |g| g.most_ratio)));
    let mut out = vec![match rows.len() {
        0 => "ghosts: none".to_owned(),
        _ => {
            // What shines through a slide may be brighter towards one train than towards another.
            let what = match scan.kind {
                Kind::Slide => "light carried over its own",
                Kind::Image | Kind::Object => "luminance over its own",
            };
            format!("ghosts beside the image by {}:  {what}, largest    arcmin, largest", scan.by)
        }
    }];
    out.extend(rows.iter().map(|(by, all)| {
        let (ratio, arcmin) = (most(all, |g| g.most_ratio), most(all, |g| g.most_arcmin));
        format!("  {ratio:8.5} {arcmin:9.3}   {by}, {} positions", all.len())
    }));
    out
}

/// For people.
pub fn lines(scan: &Scan) -> Vec<String> {
    let mm = |m: f64| 1e3 * m;
    let mut out = vec![
        format!(
            "picture: {} face {}, {:.2} × {:.2} mm; eyebox {:.1} × {:.1} mm, {} positions",
            scan.part,
            scan.face,
            mm(scan.picture_m[0]),
            mm(scan.picture_m[1]),
            mm(scan.eyebox_m[0]),
            mm(scan.eyebox_m[1]),
            scan.positions.len()
        ),
        "     x mm     y mm   seen   centre cd/m²     mean  uniform  distortion %  arcmin  1/distance 1/m  (least … most)"
            .to_owned(),
    ];
    out.extend(scan.positions.iter().map(line));
    let over = |what: &str, unit: &str, value: &dyn Fn(&Position) -> Option<f64>| {
        let values: Vec<f64> = scan.positions.iter().filter_map(value).collect();
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        if values.is_empty() {
            format!("{what} over the eyebox: none")
        } else {
            format!("{what} over the eyebox: {low:.4} to {high:.4} {unit}, {} positions", values.len())
        }
    };
    if scan.positions.iter().any(|p| p.luminance.is_some()) {
        let level = |of: Option<Level>| of.map(|level| level.value);
        out.push(over("luminance, centre", "cd/m²", &|p| level(p.luminance?.centre)));
        out.push(over("luminance, mean", "cd/m²", &|p| level(p.luminance?.mean)));
        out.push(over("uniformity of 9 points", "(least over largest)", &|p| level(p.luminance?.uniformity)));
    }
    out.push(over("distortion, largest", "% of half the diagonal", &|p| Some(p.distortion?.max_percent)));
    out.push(over("distortion, largest", "arcmin", &|p| Some(p.distortion?.max_arcmin)));
    out.push(over("1/distance, mean of the picture", "1/m (0 is infinity, below 0 converging)", &|p| {
        Some(p.distance?.mean_per_m)
    }));
    out.push(over("astigmatism, largest", "1/m", &|p| Some(p.distance?.astigmatism_per_m)));
    out.extend(scan.positions.iter().filter(|p| p.cut > 0.0).map(|p| {
        format!(
            "note: from x {:.2} mm, y {:.2} mm the eye's own field of view cuts {:.0} % of the picture off; scan looks at all of it",
            mm(p.x_m),
            mm(p.y_m),
            100.0 * p.cut
        )
    }));
    let ipd = mm(scan.ipd_m);
    if scan.positions.iter().all(|p| p.disparity.is_none()) {
        out.push(format!("binocular disparity: none: no point of the picture is seen by both eyes, {ipd:.1} mm apart"));
    } else {
        out.push(over("convergence, mean of the picture", "arcmin", &|p| Some(p.disparity?.mean_convergence_arcmin)));
        out.push(over("dipvergence, largest", "arcmin", &|p| Some(p.disparity?.dipvergence_arcmin)));
    }
    out.extend(scan.edges.iter().flat_map(edges));
    out.extend(ghosts(scan));
    out.extend(left_out(scan));
    out.extend(scan.positions.iter().filter_map(|p| Some(format!("warning: {}", p.warning.as_ref()?))));
    out
}

/// Light whose ways were not followed, where that is more than may be left out.
fn left_out(scan: &Scan) -> Vec<String> {
    let most = scan.positions.iter().map(|p| p.left_out).fold(0.0, f64::max);
    let picture = is_too_much(most).then(|| {
        format!(
            "note: ways that were not followed, there are so many, have up to {:.1} % of the light that the picture has: points of it \
             may be seen over them, too",
            100.0 * most
        )
    });
    let ghosts = (scan.ghosts_left_out > 0.0).then(|| {
        format!(
            "note: ways that were not followed, there are so many, have up to {:.1} % of a ray's light: there may be more ghosts",
            100.0 * scan.ghosts_left_out
        )
    });
    picture.into_iter().chain(ghosts).collect()
}

fn line(p: &Position) -> String {
    let place = format!("{:9.2}{:9.2}", 1e3 * p.x_m, 1e3 * p.y_m);
    if let Some(why) = &p.why {
        return format!("{place}   {why}");
    }
    if p.seen == 0.0 {
        return format!("{place}   nothing of the picture is seen (vignetted)");
    }
    let number = |value: Option<f64>, width: usize, digits: usize| match value {
        Some(value) => format!("{value:width$.digits$}"),
        None => format!("{:>width$}", "-"),
    };
    let range = p.distance.map_or(String::new(), |d| format!("  ({:.4} … {:.4})", d.least_per_m, d.most_per_m));
    format!(
        "{place}{:6.0}%{}{}{}{}{}{}{range}",
        100.0 * p.seen,
        number(p.luminance.and_then(|l| Some(l.centre?.value)), 15, 1),
        number(p.luminance.and_then(|l| Some(l.mean?.value)), 9, 1),
        number(p.luminance.and_then(|l| Some(l.uniformity?.value)), 9, 3),
        number(p.distortion.map(|d| d.max_percent), 14, 4),
        number(p.distortion.map(|d| d.max_arcmin), 8, 3),
        number(p.distance.map(|d| d.mean_per_m), 16, 4),
    )
}
