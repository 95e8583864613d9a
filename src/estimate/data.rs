//! Data layers: what the eye sees first, what it sees first behind specular faces, and how much of the world behind it
//! sees. One unrandomised ray per pixel for the data; for the see-through share, where an edge may be blurred into the pixel,
//! four more, or sixteen where those and the first do not agree.

use super::kernel_bias::{Edges, radius_px};
use super::ledger::Ledger;
pub use super::tuning::data::FAR_M;
use super::tuning::data::{ALIKE, BAND, FEW, MOSTLY, SIDE};
use super::walk::{Met, Travel, Vertex, Walker};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::Frame;
use eyebox_world::World;
use eyebox_world::eye::EyeLens;
use eyebox_world::geometry::{Hit, Ray};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Principled;
use eyebox_world::surface::Surface;
use glam::DVec3;

/// What a ray hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Distance along the viewing axis, m.
    pub z_m: f64,
    /// World, m.
    pub position: DVec3,
    /// World, towards the eye.
    pub normal: DVec3,
    /// Share of light falling straight on that is scattered, linear Rec.709, as textures have it there; 1 for specular faces, as
    /// denoisers want it.
    pub albedo: [f64; 3],
    /// Part number from 1; 0 where nothing is hit.
    pub part: u32,
    /// CAD face number from 0.
    pub face: u32,
    pub look: SeenLook,
}

/// What ordinary materials have there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenLook {
    /// World, towards the eye: of the face, without interpolation and maps.
    pub geometric: DVec3,
    /// First set of texture coordinates; 0 where there is none.
    pub uv: [f64; 2],
    /// Share of the face that is there.
    pub opacity: f64,
}

impl Seen {
    const NOTHING: Seen = Seen {
        z_m: FAR_M,
        position: DVec3::ZERO,
        normal: DVec3::ZERO,
        albedo: [0.0; 3],
        part: 0,
        face: 0,
        look: SeenLook { geometric: DVec3::ZERO, uv: [0.0; 2], opacity: 0.0 },
    };
}

/// Data of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelData {
    pub first: Seen,
    /// At the first hit that is not specular, going straight on where there is a choice.
    pub seen: Seen,
    /// Transmittance from the eye to the world behind all specular parts, 0–1.
    pub seethrough: f64,
}

/// What rays of all pixels hit, row-major, as it is stored.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenPixels {
    pub z_m: Vec<f32>,
    pub position: [Vec<f32>; 3],
    pub normal: [Vec<f32>; 3],
    pub albedo: Vec<f32>,
    /// Green and blue of the albedo, from the first pixel that is not grey on.
    pub tint: Option<[Vec<f32>; 2]>,
    pub part: Vec<f32>,
    pub face: Vec<f32>,
    /// Where the scene has ordinary materials.
    pub looks: Option<SeenLooks>,
}

/// [`SeenLook`] of all pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenLooks {
    pub geometric: [Vec<f32>; 3],
    pub uv: [Vec<f32>; 2],
    pub opacity: Vec<f32>,
}

impl SeenPixels {
    fn new(looks: bool) -> Self {
        SeenPixels { looks: looks.then(SeenLooks::default), ..SeenPixels::default() }
    }

    fn push(&mut self, seen: &Seen) {
        if let Some(looks) = &mut self.looks {
            let SeenLook { geometric, uv, opacity } = seen.look;
            looks.geometric.iter_mut().zip(geometric.to_array()).for_each(|(to, x)| to.push(x as f32));
            looks.uv.iter_mut().zip(uv).for_each(|(to, x)| to.push(x as f32));
            looks.opacity.push(opacity as f32);
        }
        self.z_m.push(seen.z_m as f32);
        let [r, g, b] = seen.albedo.map(|c| c as f32);
        if self.tint.is_none() && (r != g || r != b) {
            self.tint = Some([self.albedo.clone(), self.albedo.clone()]);
        }
        self.albedo.push(r);
        if let Some([green, blue]) = &mut self.tint {
            green.push(g);
            blue.push(b);
        }
        self.part.push(seen.part as f32);
        self.face.push(seen.face as f32);
        for axis in 0..3 {
            self.position[axis].push(seen.position[axis] as f32);
            self.normal[axis].push(seen.normal[axis] as f32);
        }
    }
}

/// Data of all pixels, row-major, as it is stored: what a large picture has of it is never held as anything wider.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Data {
    /// See [`PixelData`].
    pub first: SeenPixels,
    pub seen: SeenPixels,
    pub seethrough: Vec<f32>,
}

pub fn data_layers(world: &World, width: usize, height: usize) -> Data {
    let optics = Mono::<f64>::optics(world, 0, 0);
    let at = |ledger: &mut Ledger, pixel: usize, (jitter, lens): ([f64; 2], [f64; 2])| {
        look((world, &optics), world.eye.ray(pixel % width, pixel / width, jitter, lens), ledger)
    };
    let ledger = || Ledger::new(world.solids.len());
    let middle = |ledger: &mut Ledger, pixel: usize| at(ledger, pixel, ([0.5; 2], [0.5; 2]));
    let pixels = || SeenPixels::new(world.ordinary);
    let mut all = Data { first: pixels(), seen: pixels(), seethrough: Vec::new() };
    let mut edges = Edges::new(width, height);
    let mut above: Vec<PixelData> = Vec::new();
    for band in (0..height).step_by(BAND) {
        let first = band * width;
        let pixels = first..(band + BAND).min(height) * width;
        let data: Vec<PixelData> = parallel::map_init(pixels.len(), &ledger, &|ledger, k| middle(ledger, first + k));
        for (index, here) in data.iter().enumerate() {
            let pixel = first + index;
            let left = (!pixel.is_multiple_of(width)).then(|| (pixel - 1, &data[index - 1]));
            let over = index.checked_sub(width).map_or_else(|| above.get(index), |over| data.get(over));
            for (other, there) in left.into_iter().chain(over.map(|over| (pixel - width, over))) {
                there.edge_to(here, world).into_iter().for_each(|radius| edges.add([other, pixel], radius));
            }
            all.first.push(&here.first);
            all.seen.push(&here.seen);
            all.seethrough.push(here.seethrough as f32);
        }
        above = data[data.len() - width..].to_vec();
    }
    // There the middle is looked at again: few pixels are.
    let near = edges.near();
    let near: Vec<usize> = (0..width * height).filter(|pixel| near[*pixel]).collect();
    let of_near = |ledger: &mut Ledger, k: usize| {
        let data = middle(ledger, near[k]);
        share(&data, |i| at(ledger, near[k], place(i))) as f32
    };
    let shares = parallel::map_init(near.len(), &ledger, &of_near);
    near.iter().zip(shares).for_each(|(pixel, share)| all.seethrough[*pixel] = share);
    all
}

/// The see-through share of a pixel near an edge; `data`: of its middle; `through`: at one of its [places](place).
fn share(data: &PixelData, mut through: impl FnMut(usize) -> PixelData) -> f64 {
    let few = FEW.map(|i| (i, through(i)));
    let shares = few.iter().map(|(_, other)| other.seethrough).chain([data.seethrough]);
    let (least, most) = shares.fold((f64::INFINITY, 0.0f64), |(a, b), share| (a.min(share), b.max(share)));
    let same = |(_, other): &(usize, PixelData)| other.path() == data.path();
    let sum = |sum: f64, (_, other): &(usize, PixelData)| sum + other.seethrough;
    if most - least <= ALIKE * most && few.iter().all(same) {
        return few.iter().fold(0.0, sum) / few.len() as f64;
    }
    let others = (0..SIDE * SIDE).filter(|i| !FEW.contains(i)).map(|i| through(i).seethrough);
    (few.iter().fold(0.0, sum) + others.sum::<f64>()) / (SIDE * SIDE) as f64
}

/// Point `i` of 16 of a pixel (right, down) and of the pupil: rows and columns of the pixel, and a Latin arrangement in the
/// pupil, so that no two share a row or a column there.
pub(super) fn place(i: usize) -> ([f64; 2], [f64; 2]) {
    let jitter = [(i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5].map(|j| j / SIDE as f64);
    let lens = [((i * 5) % 16) as f64 + 0.5, ((i * 7 + 3) % 16) as f64 + 0.5].map(|l| l / 16.0);
    (jitter, lens)
}

impl PixelData {
    /// The surfaces seen first and behind specular faces.
    fn path(&self) -> [u32; 4] {
        [self.first.part, self.first.face, self.seen.part, self.seen.face]
    }

    /// The radius of the blur, in pixels, if there is an edge between this pixel and one beside it: that of the nearest
    /// surface that either sees.
    fn edge_to(&self, other: &PixelData, world: &World) -> Option<f64> {
        let (a, b) = (self.seethrough, other.seethrough);
        let alike = (a - b).abs() <= ALIKE * a.max(b) && self.path() == other.path();
        let depths = [self, other].into_iter().flat_map(|data| [data.first, data.seen]);
        let nearest = depths.filter(|seen| seen.part > 0).map(|seen| seen.z_m).fold(FAR_M, f64::min);
        (!alike).then(|| radius_px(&world.eye, nearest))
    }
}

/// Follows one ray; what it books in `ledger` is of no interest.
fn look((world, optics): (&World, &Optics<Mono>), (origin, dir): (DVec3, DVec3), ledger: &mut Ledger) -> PixelData {
    let mut data = PixelData { first: Seen::NOTHING, seen: Seen::NOTHING, seethrough: 0.0 };
    let (mut first, mut here) = (None, Seen::NOTHING);
    let end = go_straight((world, optics), (origin, dir), ledger, |vertex| {
        here = seen(world, vertex, &world.eye, origin);
        first = first.or(Some(here));
    });
    data.first = first.unwrap_or(Seen::NOTHING);
    match end {
        End::Outside(share) => data.seethrough = share,
        End::Seen => data.seen = here,
        End::Lost => {}
    }
    data
}

/// How a ray from the eye ends that goes straight on at specular faces.
pub enum End {
    /// In the world behind all parts, with this share of it.
    Outside(f64),
    /// On the last face that was met, which is not specular.
    Seen,
    /// Absorbed on the way, or not done after many faces.
    Lost,
}

/// Follows one ray and shows every face that it meets.
pub fn go_straight(
    tracing: (&World, &Optics<Mono>),
    ray: (DVec3, DVec3),
    ledger: &mut Ledger,
    met: impl FnMut(&Vertex),
) -> End {
    follow_straight(tracing, ray, ledger, met).0
}

/// The same with the direction that it has in the end.
pub fn follow_straight(
    (world, optics): (&World, &Optics<Mono>),
    (origin, dir): (DVec3, DVec3),
    ledger: &mut Ledger,
    mut met: impl FnMut(&Vertex),
) -> (End, DVec3) {
    const MOST_FACES: usize = 256;
    let ray = Ray { origin, dir, from: None };
    let rng = Rng::new(0, Stream::Check, 0, 0);
    let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
    for _ in 0..MOST_FACES {
        let vertex = match walker.advance(ledger) {
            Met::Sky => return (End::Outside(walker.beam.carried()), walker.ray.dir),
            Met::Pupil(_) | Met::Ended => return (End::Lost, walker.ray.dir),
            Met::Face(vertex) => vertex,
        };
        if let Some(principled) = principled_at(world, &vertex) {
            let look = vertex.point_of(principled, world).look(None);
            let wi = Frame::about(vertex.normal).to_local(-walker.ray.dir);
            let share = principled.passes(wi, &look);
            // What is cut out is not there.
            if look.opacity >= MOSTLY {
                met(&vertex);
                if share < MOSTLY {
                    return (End::Seen, walker.ray.dir);
                }
            }
            walker.beam.scale(share);
            walker.pass_through(&vertex);
            continue;
        }
        met(&vertex);
        if !walker.go_straight_on(&vertex, ledger) {
            return (End::Seen, walker.ray.dir);
        }
    }
    (End::Lost, walker.ray.dir)
}

fn principled_at<'w>(world: &'w World, vertex: &Vertex) -> Option<&'w Principled> {
    world.principled(vertex.hit.site)
}

fn seen(world: &World, vertex: &Vertex, eye: &EyeLens, from: DVec3) -> Seen {
    let hit: &Hit = &vertex.hit;
    let optics = &world.faces[hit.site.part as usize][hit.site.face as usize];
    let principled = principled_at(world, vertex);
    let geometric = if vertex.outside { hit.normal } else { -hit.normal };
    let look = SeenLook {
        geometric,
        uv: principled.map_or([0.0; 2], |principled| principled.uv(hit)),
        opacity: principled.map_or(1.0, |principled| vertex.point_of(principled, world).look(None).opacity),
    };
    let albedo = match &optics.surface {
        Surface::Absorber => [0.0; 3],
        Surface::Absent
        | Surface::Slide(_)
        | Surface::Sheet(_)
        | Surface::Splitter(_)
        | Surface::Grating(_)
        | Surface::Mirror(_)
        | Surface::Interface(_) => [1.0; 3],
        Surface::Scatter(scatter) => match scatter.principled() {
            Some(principled) => vertex.point_of(principled, world).albedo(principled),
            None => [scatter.specular() + scatter.albedo(1.0); 3],
        },
    };
    Seen {
        z_m: (hit.point - from).dot(eye.look()),
        position: hit.point + world.geometry.origin(),
        normal: vertex.normal,
        albedo,
        part: hit.site.part + 1,
        face: hit.site.face,
        look,
    }
}
