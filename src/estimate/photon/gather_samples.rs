//! How many rays a pixel takes in a pass. Where photons are crowded light changes within a pixel, and one ray shows one place
//! of many: the more crowded they are about what the middle of a pixel sees, the more rays it takes. Middles do not depend
//! on where rays start, so that is no bias.

pub(super) use super::tuning::gather_samples::MOST_RAYS;
use crate::photon::visible_receivers::{Place, follow};
use crate::photon_map::{PhotonMap, adaptive_kernel};
use crate::walk::{Travel, Walker};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use glam::DVec3;

/// By how often the radius of photons about a middle is halved, begun ones counted.
const RAYS: [u64; adaptive_kernel::HALVINGS + 1] = [1, 2, 8, MOST_RAYS];

/// Where the ray through the middle of a pixel, or a branch of it, meets its first scatterer, if that is a broad one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Middle {
    site: Site,
    /// Recentred world, m.
    point: DVec3,
    /// How far around it the pixel sees, m.
    reach: f64,
}

/// Those of a picture.
#[derive(Debug)]
pub(super) struct GatherSamples {
    of_pixel: Vec<Box<[Middle]>>,
}

impl GatherSamples {
    pub(super) fn new(world: &World, [width, height]: [usize; 2]) -> GatherSamples {
        let optics = Mono::<f64>::optics(world, 0, 0);
        let look = |pixel: usize| {
            let (origin, dir) = world.eye.ray(pixel % width, pixel / width, [0.5; 2], [0.5; 2]);
            let rng = Rng::new(0, Stream::PhotonMiddle, 0, pixel as u64);
            let ray = Ray { origin, dir, from: None };
            let walker = Walker::new((world, &optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
            let mut found = Vec::new();
            follow(walker, (), &mut |Place { vertex, scatter, .. }, ()| {
                if !scatter.is_narrow() {
                    found.push(Middle { site: vertex.hit.site, point: vertex.hit.point, reach: 0.0 });
                }
                false
            });
            found.into_boxed_slice()
        };
        let mut of_pixel: Vec<Box<[Middle]>> = parallel::map(width * height, &look);
        // A pixel sees as far as its corners lie: 1/√2 of the way to its neighbours.
        let to = |middle: &Middle, neighbour: usize| {
            let there = of_pixel[neighbour].iter().filter(|other| other.site.is_on_face_of(middle.site));
            there.map(|other| other.point.distance(middle.point)).min_by(f64::total_cmp)
        };
        let reach = |pixel: usize, middle: &Middle| {
            let (x, y) = (pixel % width, pixel / width);
            let beside = [(x > 0).then(|| pixel - 1), (x + 1 < width).then(|| pixel + 1)];
            let above = [(y > 0).then(|| pixel - width), (y + 1 < height).then(|| pixel + width)];
            let neighbours = beside.into_iter().chain(above).flatten();
            let farthest = neighbours.filter_map(|other| to(middle, other)).max_by(f64::total_cmp);
            farthest.map_or(f64::INFINITY, |farthest| farthest * std::f64::consts::FRAC_1_SQRT_2)
        };
        let of = |pixel: usize| of_pixel[pixel].iter().map(|middle| reach(pixel, middle)).collect();
        let reaches: Vec<Box<[f64]>> = parallel::map(of_pixel.len(), &of);
        for (middle, reach) in of_pixel.iter_mut().flatten().zip(reaches.into_iter().flatten()) {
            middle.reach = reach;
        }
        GatherSamples { of_pixel }
    }

    /// How many rays a pixel takes where these photons lie.
    pub(super) fn rays<M: Mode>(&self, pixel: usize, map: &PhotonMap<M>) -> u64 {
        let halved = |middle: &Middle| map.most_halved((middle.point, middle.site), middle.reach);
        RAYS[self.of_pixel[pixel].iter().map(halved).max().unwrap_or(0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon_map::tests::photon;
    use eyebox_scene::{Eye, Finish};
    use eyebox_world::geometry::scenes;
    use glam::DAffine3;

    const SIZE: [usize; 2] = [8, 6];

    /// Of a wall a metre away that fills the picture.
    fn middles(size: [usize; 2]) -> GatherSamples {
        let mut scene = scenes::scene(Vec::new(), Vec::new());
        let finish = Finish::Lambert { reflectance: 0.5, transmittance: 0.0 };
        scenes::add_square(&mut scene, (1.0, 1.0, DVec3::NEG_Z), finish, DAffine3::IDENTITY);
        scene.eye = Eye {
            position: DVec3::ZERO,
            look: DVec3::Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg: 20.0,
            resolution: size,
            ..scene.eye
        };
        GatherSamples::new(&World::freeze(&scene).unwrap(), size)
    }

    /// 500 photons in one place.
    fn map(at: DVec3, face: u32, enough: f64) -> PhotonMap<Mono> {
        PhotonMap::crowded(vec![photon(at, face); 500], 0.2, enough, DVec3::splat(0.3))
    }

    #[test]
    fn a_pixel_takes_more_rays_where_photons_are_crowded() {
        let middles = middles(SIZE);
        let Middle { point, reach, .. } = middles.of_pixel[0][0];
        assert!(point.y > 0.0, "{point}");
        let to_next = middles.of_pixel[1][0].point - point;
        let pixel = to_next.length();
        assert!((reach / pixel - 0.5f64.sqrt()).abs() < 0.1, "{reach} of {pixel}");
        let aside = point + 0.6 * to_next;
        for (photons, rays) in [
            (map(point, 0, 4.0), [MOST_RAYS, 1]),
            (map(aside, 0, 4.0), [MOST_RAYS, MOST_RAYS]),
            (map(point, 0, 500.0), [1, 1]),
            (map(point, 1, 4.0), [1, 1]),
        ] {
            assert_eq!([0, 1].map(|pixel| middles.rays(pixel, &photons)), rays);
        }
    }

    #[test]
    fn a_picture_of_one_pixel_sees_all_about_it() {
        let middles = middles([1, 1]);
        let at = middles.of_pixel[0][0].point + DVec3::X * 0.15;
        assert_eq!(middles.rays(0, &map(at, 0, 4.0)), MOST_RAYS);
    }
}
