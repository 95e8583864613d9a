//! The last step of a rendering: what is said of it.

use super::Run;
use super::opened::Opened;
use super::planned::Planned;
use super::traced::Traced;
use crate::base::Result;
use crate::cmd::ending::stated;
use crate::cmd::print;
use crate::cmd::source::told;
use crate::estimate::picture::plan_lines;

impl Run<'_> {
    pub fn tell(&self, opened: &Opened, planned: &Planned, traced: &Traced) -> Result<()> {
        let args = &self.args;
        if args.quiet {
            return Ok(());
        }
        let Opened { scene, .. } = opened;
        let Planned { plan, sharpness, .. } = planned;
        let Traced { outcome, judgement, error, ending, .. } = traced;
        // What a pipe of the result should not hold.
        told(scene).iter().for_each(|line| tell!("{line}"));
        ending.warnings.iter().for_each(|warning| tell!("warning: {warning}"));
        let text = || {
            let mut lines = plan_lines(scene, plan);
            lines.extend(sharpness.lines());
            lines.extend(ending.lines.iter().cloned());
            let error = stated(*error, outcome.films.passes);
            let seconds = outcome.elapsed.as_secs_f64();
            let passes = outcome.films.passes;
            lines.push(format!("{}: {passes} passes in {seconds:.1} s, {error}", args.output.display()));
            lines.join("\n")
        };
        let json = || {
            serde_json::json!({
                "output": args.output,
                "scene": scene.name,
                "scene_hash": scene.hash,
                "seed": args.seed_of_passes(),
                "passes": outcome.films.passes,
                "seconds": outcome.elapsed.as_secs_f64(),
                "stop": outcome.stop,
                "relative_error": error,
                "plan": plan,
                "diffraction": sharpness,
                "ledgers": outcome.films.films.iter().map(|(e, _, l)| (e.name(), l)).collect::<Vec<_>>(),
                "notes": scene.notes,
                "witness": judgement,
                "warnings": ending.warnings,
            })
        };
        print(args.format, text, json)
    }
}
