//! Scenes with several slides: what each is called in names of layers, and what tells the light of one from that of others.

use super::render_vars::plain;
use super::series::Once;
use eyebox_base::ids::GroupId;
use eyebox_base::lpe::MOST_SLIDES;
use eyebox_film::finish::slides::{BySlide, Shows, SlideInfo};
use eyebox_film::names;
use eyebox_scene::{Scene, Slide};

/// The contrast of all slides, if there are any and it is the same for all.
pub fn common_contrast(scene: &Scene) -> Option<f64> {
    let (first, others) = scene.slides.split_first()?;
    others.iter().all(|slide| slide.contrast == first.contrast).then_some(first.contrast)
}

/// What slides are called where there are several, in their order: as the last part of the path of the part that carries
/// them, with a number behind it where that is taken. None of a scene with fewer, or with more than are told apart.
pub fn names(scene: &Scene) -> Vec<String> {
    let mut names = Vec::new();
    if !(2..=MOST_SLIDES).contains(&scene.slides.len()) {
        return names;
    }
    let groups = || scene.groups.iter().map(|group| group.name.as_str());
    // Faults of the groups alone are told elsewhere.
    let sound = names::clash(groups(), &[]).is_none();
    for Slide { name, .. } in &scene.slides {
        let own = plain(name.rsplit('/').find(|step| !step.is_empty()).unwrap_or("slide"));
        let taken = |wanted: &String, names: &Vec<String>| {
            let with: Vec<String> = names.iter().chain([wanted]).cloned().collect();
            names.contains(wanted) || sound && names::clash(groups(), &with).is_some()
        };
        let numbered = (2..=scene.slides.len() + scene.groups.len() + 1).map(|number| format!("{own}{number}"));
        let free = [own.clone()].into_iter().chain(numbered).find(|wanted| !taken(wanted, &names));
        names.push(free.unwrap_or(own));
    }
    names
}

/// How paths tell which slides they cross.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Told {
    /// From which bit on they do.
    pub bit: u32,
    /// What of slides in series is told after the slides themselves.
    pub once: Vec<Once>,
}

/// How the light of a group is told apart.
pub(super) fn by_slide(scene: &Scene, group: GroupId, told: &Told) -> BySlide {
    let info = |(slide, name): (&Slide, String)| {
        let (part, contrast) = (slide.name.clone(), slide.contrast);
        SlideInfo { name, part, contrast }
    };
    let slides = scene.slides.iter().zip(names(scene)).map(info).collect();
    let once = told.once.iter().map(|(one, other)| (usize::from(*one), other.map(usize::from))).collect();
    BySlide { slides, bit: told.bit, shows: shows(scene, group), once }
}

/// Whose pictures the lamps of a group show.
fn shows(scene: &Scene, group: GroupId) -> Shows {
    let faces = scene.parts.iter().flat_map(|part| &part.faces);
    let faces = faces.filter(|face| face.emitter.as_ref().is_some_and(|emitter| emitter.group == group));
    let faces = faces.map(|face| face.slide.map(|slide| slide.index()));
    let lights = scene.lights.iter().filter(|light| light.group == group).map(|_| None);
    let sky = scene.sky.iter().filter(|sky| sky.group == group).map(|_| None);
    let mut all = faces.chain(lights).chain(sky);
    let Some(first) = all.next() else { return Shows::Nothing };
    match first {
        _ if all.any(|other| other != first) => Shows::Several,
        Some(slide) => Shows::Slide(slide),
        None => Shows::Nothing,
    }
}
