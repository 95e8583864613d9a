//! The second step of a rendering: who traces what, what of it becomes a layer, and where the run begins.

use super::Run;
use super::opened::Opened;
use crate::base::{Error, Result, Where};
use crate::check::{Checked, check};
use crate::cmd::chains::Chains;
use crate::cmd::shards::{checkpoint_of, resume};
use crate::estimate::aov::{self, Granted};
use crate::estimate::finishing::Finishing;
use crate::estimate::render_vars;
use crate::estimate::run::{Films, Start};
use crate::estimate::shard::Head;
use crate::estimate::slides;
use crate::film::aov::Aov;
use crate::film::diffraction::{Diffraction, PRIMARIES_NM};
use crate::film::guide::ApertureGuide;
use crate::film::plan::Plan;
use crate::film::pupil::Pupil;
use crate::film::sharpness::{GroupPupil, Sharpness};
use crate::plan::pilots::pupil::{Surveyed, survey};
use crate::plan::plan_file::PlanFile;
use crate::plan::{follows_rays, plan_unless};
use crate::scene::{Scene, Wavelengths};
use crate::world::World;

/// What was planned.
pub struct Planned {
    pub plan: Plan,
    pub frozen: PlanFile,
    pub head: Head,
    pub start: Start,
    pub sharpness: Sharpness,
    /// Through where the witness looks.
    pub guide: Option<ApertureGuide>,
    pub chains: Chains,
}

impl Run<'_> {
    /// None if a signal came.
    pub fn plan(&self, opened: &mut Opened) -> Result<Option<Planned>> {
        let args = &self.args;
        let Opened { scene, world, own, wishes, asked, .. } = opened;
        let (asked, stop) = (*asked, || self.is_stopped());
        let checked = check(scene)?;
        follows_rays(&checked, world, asked)?;
        let behind = if args.resume { resume(&args.output, &|head| args.is_mine(head, scene))? } else { None };
        let plan = match (&args.plan, &behind) {
            (Some(path), _) => Some(PlanFile::read(path, scene, asked)?.plan),
            (None, Some((head, _))) => {
                Some(PlanFile::of_value(&head.plan, &checkpoint_of(&args.output), scene, asked)?.plan)
            }
            (None, None) => self.pool.install(|| plan_unless(&checked, world, asked, &stop)),
        };
        let Some(mut plan) = plan else { return Ok(None) };
        let Surveyed { pupils, guide } = self.pool.install(|| survey(&checked, world, asked, &plan, &stop));
        if stop() {
            return Ok(None);
        }
        let sharpness = Sharpness::new(&pupils, scene.wavelengths.traced_nm(), world.eye.pixel());
        let diffraction = args.diffraction.then(|| spread_by(scene, &checked, world, &pupils));
        let frozen = PlanFile::new(scene, asked, &plan);
        let (named_layers, ungranted) = render_vars::granted(wishes, (&scene.groups, &slides::names(scene)));
        let Granted { aovs, notes: refused, sieve, slides_told } =
            aov::granted(&args.aovs, (wishes, &named_layers), scene, world, &plan)?;
        let names: Vec<String> =
            named_layers.iter().map(|own| own.name.clone()).chain(aovs.iter().flat_map(Aov::layers)).collect();
        let Some(chains) = self.pool.install(|| Chains::find(args, (scene, *own), &names, &stop))? else {
            return Ok(None);
        };
        scene.notes.extend(ungranted.into_iter().chain(refused));
        world.sieve = sieve;
        plan.errors = args.errors(&named_layers);
        // Only now: plan and pilots are those of the whole picture, so that the part has its bits.
        world.eye.crop = args.crop;
        let mut finishing = Finishing::new(scene, &plan, args.color.space(), diffraction);
        if let Some(told) = slides_told {
            finishing.tell_slides_apart(scene, &told);
        }
        finishing.wanted = args.wanted(named_layers, aovs);
        let head = args.head(scene, &frozen, finishing);
        let start = self.start_of(behind, &head)?;
        Ok(Some(Planned { plan, frozen, head, start, sharpness, guide, chains }))
    }

    /// After what a checkpoint has.
    fn start_of(&self, behind: Option<(Head, Films)>, head: &Head) -> Result<Start> {
        match behind {
            Some((kept, _)) if kept.plan_hash != head.plan_hash => {
                let at = Where::file(&checkpoint_of(&self.args.output));
                Err(Error::new(at, "is of another plan").expected(&head.plan_hash))
            }
            Some((_, films)) => Ok(Start::Films(Box::new(films))),
            None => Ok(Start::Pass(head.first)),
        }
    }
}

/// What the picture's light is spread by.
fn spread_by(scene: &Scene, checked: &Checked, world: &World, pupils: &[GroupPupil]) -> Diffraction {
    let wavelengths_nm = match scene.wavelengths {
        Wavelengths::Mono { nm } => [nm; 3],
        Wavelengths::Visible => PRIMARIES_NM,
    };
    Diffraction {
        pixel: world.eye.pixel(),
        wavelengths_nm,
        pupils: pupils.to_vec(),
        full: Pupil::full(scene.eye.pupil_diameter_m),
        only_vision: !checked.facts().scatters,
    }
}
