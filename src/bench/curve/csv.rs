//! The curves for programs that read tables.

use super::Report;

/// One row per point of a curve, with a head. Numbers are given to full precision; an empty field: there is none.
pub fn csv(report: &Report) -> String {
    let mut out = String::from(
        "asset,estimator,passes,setup_s,trace_s,paths,relmse,relmse_trimmed,relmse_flat,relmse_edges,energy,energy_sigma,\
         worst_sigma,resolution\n",
    );
    for asset in &report.assets {
        let name = format!("\"{}\"", asset.asset.replace('"', "\"\""));
        for curve in &asset.curves {
            for point in &curve.points {
                let error = point.error;
                let [flat, edges] = [error.flat, error.edges].map(|of| of.map_or(String::new(), |of| of.to_string()));
                out += &format!(
                    "{name},{},{},{},{},{},{},{},{flat},{edges},{},{},{},{}\n",
                    curve.estimator,
                    point.passes,
                    curve.setup_seconds,
                    point.seconds,
                    point.paths,
                    error.relmse,
                    error.trimmed,
                    error.energy,
                    error.energy_sigma,
                    error.worst_sigma,
                    asset.reference.resolution
                );
            }
        }
    }
    out
}
