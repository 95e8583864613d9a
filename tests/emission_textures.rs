//! Lamps that shine through a texture, seen straight, in a mirror, through a plate: closed forms, and plain sampling that leaves
//! the texture's detail to chance.

use crate::common::pixels::{Both, add_mirror, add_plate, draws, mean_drawn, over_disc, over_square, traced};
use crate::common::*;
use eyebox::base::Shared;
use eyebox::base::ids::{SlideId, SurfaceId};
use eyebox::film::plan::Spectral;
use eyebox::plan::Polarisation;
use eyebox::scene::texture::{Channel, Encoding, Filter, Texels, Wrap};
use eyebox::scene::*;
use eyebox::world::World;
use eyebox::world::lamp::LampPoint;
use eyebox::world::mode::{Mode, Rgb};
use eyebox::world::slide::footprint::{Brightness, Lines, mean_of};
use eyebox::world::slide::texels;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

const WHITE: f64 = 800.0;

/// Columns of texels, and all of them row by row.
fn picture(width: usize, texels: Vec<[f32; 3]>, filter: Filter, wrap: [Wrap; 2]) -> TextureInput {
    let texture = Texture {
        name: "screen".to_owned(),
        width,
        height: texels.len() / width,
        texels: Texels::Floats(Arc::new(texels.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())),
    };
    TextureInput {
        texture: Shared::from(texture),
        encoding: Encoding::Linear,
        wrap,
        filter,
        set: 0,
        to_picture: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        channels: Channel::ALL,
        scale: [1.0; 4],
        bias: [0.0; 4],
        fallback: None,
    }
}

/// A corner of a triangle with its texture coordinates.
type Corner = (DVec3, [f64; 2]);

/// One face that shines through a texture.
fn add_screen(s: &mut Scene, triangles: &[[Corner; 3]], input: TextureInput) {
    let group = add_group(s, "screen");
    let mut screen = Mesh { name: "screen".to_owned(), ..Mesh::default() };
    for triangle in triangles {
        let normal = (triangle[1].0 - triangle[0].0).cross(triangle[2].0 - triangle[0].0).normalize();
        let first = screen.positions.len() as u32;
        for (place, uv) in triangle {
            screen.positions.push(place.as_vec3().to_array());
            screen.normals.push(normal.as_vec3().to_array());
            screen.uvs.push(uv.map(|x| x as f32));
        }
        screen.triangles.push([first, first + 1, first + 2]);
    }
    screen.faces.push(FaceRange { first: 0, count: triangles.len() as u32 });
    let surface = StandardSurface { emission: Some(input), ..StandardSurface::default() };
    s.surfaces.push(surface.into());
    let mut shining = face(Finish::Absorber);
    shining.emitter =
        lamp(group, WHITE).map(|lamp| Emitter { pattern: Some(SurfaceId::from_index(s.surfaces.len() - 1)), ..lamp });
    add_part(s, "screen", screen, DVec3::ZERO, None, vec![shining]);
}

/// Two triangles, whose corners have the coordinates of a square.
fn rectangle([a, b, c, d]: [DVec3; 4]) -> Vec<[Corner; 3]> {
    let [a, b, c, d] = [(a, [0.0, 0.0]), (b, [1.0, 0.0]), (c, [1.0, 1.0]), (d, [0.0, 1.0])];
    vec![[a, b, c], [a, c, d]]
}

/// From the eye to the screen, m.
const FAR: f64 = 0.5;
const PIXELS: [usize; 2] = [16, 12];
/// Of a pixel on the screen, m.
const PIXEL: f64 = 1e-3;
/// Half of the screen's side, m, a number that the mesh holds exactly.
const HALF: f64 = 0.3125;

/// Black and white texels side by side, their border `PIXEL` · `at` from the middle of the picture, white on the side of the angle's
/// direction.
#[derive(Clone, Copy)]
struct Edge {
    angle: f64,
    at: f64,
    /// Of the ramp between the two, pixels; 0 for none, where texels are not filtered.
    ramp: f64,
    pupil_m: f64,
    focus_m: f64,
    in_mirror: bool,
}

impl Edge {
    fn scene(&self) -> Scene {
        let mut s = scene();
        // Texels are half of the picture wide, their middles half of it apart.
        let wide = if self.ramp > 0.0 { 2.0 * self.ramp * PIXEL } else { 1.0 };
        let filter = if self.ramp > 0.0 { Filter::Linear } else { Filter::Nearest };
        let (cos, sin) = (self.angle.cos() / wide, self.angle.sin() / wide);
        let start = -HALF * (cos + sin) - self.at * PIXEL / wide + 0.5;
        let to_picture = [[2.0 * HALF * cos, 2.0 * HALF * sin, start], [0.0, 0.0, 0.5]];
        let input = picture(2, vec![[0.0; 3], [1.0; 3]], filter, [Wrap::Clamp; 2]);
        // Where the screen, or its image, has a place, seen from the front.
        let corners = [[-HALF, -HALF], [HALF, -HALF], [HALF, HALF], [-HALF, HALF]];
        let mut triangles = rectangle(corners.map(|[x, y]| DVec3::new(x, y, -FAR)));
        if self.in_mirror {
            // The mirror turns the look from −z to +x, 0.2 m before the eye.
            let behind = |place: DVec3| DVec3::new(FAR - 0.2, place.y, -0.2 - place.x);
            let turned = |[a, b, c]: [Corner; 3]| [a, c, b].map(|(place, uv)| (behind(place), uv));
            triangles = triangles.into_iter().map(turned).collect();
            let mirror = quad(DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1);
            let finish = Finish::MirrorIdeal { reflectance: 1.0 };
            let part = add_part(&mut s, "mirror", mesh(&[mirror]), DVec3::NEG_Z * 0.2, None, vec![face(finish)]);
            s.parts[part].to_world.matrix3 = DMat3::from_rotation_y(PI / 4.0);
        }
        add_screen(&mut s, &triangles, TextureInput { to_picture, ..input });
        s.eye.focus_distance_m = self.focus_m;
        s.eye.pupil_diameter_m = self.pupil_m;
        s.eye.fov_deg = 2.0 * (0.5 * PIXELS[0] as f64 * PIXEL / FAR).atan().to_degrees();
        s.eye.resolution = PIXELS;
        s
    }

    /// White share of a pixel. Across the edge a square is the convolution of two boxes, and the ramp is one of the edge and a third, so
    /// it is a difference of that order of powers; through a disc of the pupil the edge moves by a chord's length at a time.
    fn share(&self, pixel: usize) -> f64 {
        let middle = DVec2::new(
            (pixel % PIXELS[0]) as f64 + 0.5 - 0.5 * PIXELS[0] as f64,
            0.5 * PIXELS[1] as f64 - (pixel / PIXELS[0]) as f64 - 0.5,
        );
        let normal = DVec2::from_angle(self.angle);
        let beyond = |x: f64| {
            if self.ramp == 0.0 {
                return over_square(normal, x, |x| x * x / 2.0);
            }
            let cubes = |x: f64| over_square(normal, x, |x| x * x * x / 6.0);
            (cubes(x + 0.5 * self.ramp) - cubes(x - 0.5 * self.ramp)) / self.ramp
        };
        let inside = middle.dot(normal) - self.at;
        let blur = 0.5 * self.pupil_m * (1.0 - FAR / self.focus_m).abs() / PIXEL;
        over_disc(blur, |moved| beyond(inside + moved))
    }

    /// By how much each pixel is off after so many passes, as a share of white.
    fn off(&self, passes: u64, seed: u64, plain: bool) -> Vec<f64> {
        let image = image(&traced(&self.scene(), Polarisation::Off, (passes, seed), plain).0);
        image.iter().enumerate().map(|(pixel, (value, _))| value / WHITE - self.share(pixel)).collect()
    }
}

#[test]
fn each_pixel_has_its_share_of_white_after_one_pass() {
    // Where the picture moves by half a pixel from the middle of the pupil to its rim, a pass's places of the pupil are felt.
    let pupils = [(0.0, FAR, 1e-5), (4e-3, FAR, 1e-5), (4e-3, 0.48, 1e-3), (4e-3, 0.7, 2e-3)];
    let edges = [(0.35, 0.3, 0.0), (1.2, -1.7, 2.6), (-2.8, 2.2, 0.7)];
    for in_mirror in [false, true] {
        for (pupil_m, focus_m, most) in pupils {
            for (angle, at, ramp) in edges {
                let edge = Edge { angle, at, ramp, pupil_m, focus_m, in_mirror };
                let greys = (0..PIXELS[0] * PIXELS[1]).filter(|pixel| (0.02..0.98).contains(&edge.share(*pixel)));
                let grey = greys.count();
                assert!(grey >= PIXELS[1], "{grey}");
                let [ours, chance] = [false, true].map(|plain| {
                    let off = edge.off(1, 3, plain);
                    (off.iter().map(|off| off * off).sum::<f64>() / grey as f64).sqrt()
                });
                println!(
                    "mirror {in_mirror}, pupil {pupil_m}, focus {focus_m}, {angle} {at} {ramp}: rms of {grey} grey ones {ours:.2e}, \
                     by chance {chance:.2e}"
                );
                assert!(ours < most && ours < 0.2 * chance, "{ours} {most} {chance}");
            }
        }
    }
}

/// Over designs and seeds that are drawn the differences have no mean.
#[test]
fn there_is_no_bias() {
    let draw = draws(13);
    let runs = 120;
    let means: Vec<f64> = (0..runs)
        .map(|k| {
            let edge = Edge {
                angle: 2.0 * PI * draw(k, 0) + 0.01,
                at: 5.0 * (draw(k, 1) - 0.5),
                ramp: if k % 2 == 0 { 0.0 } else { 0.2 + 3.0 * draw(k, 4) },
                pupil_m: 5e-3 * draw(k, 2),
                focus_m: 0.4 + 0.4 * draw(k, 3),
                in_mirror: k % 3 == 0,
            };
            let off = edge.off(1, k as u64, false);
            off.iter().sum::<f64>() / off.len() as f64
        })
        .collect();
    let (mean, sigma) = mean_drawn(&means);
    println!("{mean:.2e} ± {sigma:.2e}");
    assert!(sigma < 1e-4, "too noisy to tell: {sigma}");
    assert!(mean.abs() < 4.0 * sigma, "{mean} ± {sigma}");
}

/// The integral over a square is the mean of what paths read at its points, however the picture is filtered, goes on and lies.
#[test]
fn squares_have_the_mean_of_what_their_points_read() {
    let texels: Vec<[f32; 3]> = (0..15).map(|k| [0, 1, 2].map(|c| ((k * 7 + c * 5) % 11) as f32 / 10.0)).collect();
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp, Wrap::Black];
    for (k, filter) in [Filter::Nearest, Filter::Linear].into_iter().flat_map(|own| [own; 4]).enumerate() {
        let wrap = [wraps[k % 4], wraps[(k + k / 4) % 4]];
        let mut input = picture(5, texels.clone(), filter, wrap);
        // Turned, three times as wide as the picture, not above it; and not the texel's own components.
        input.to_picture = [[2.6, 1.1, -1.2], [-0.7, 2.1, -0.3]];
        (input.channels, input.scale, input.bias) = ([Channel::Blue; 4], [0.7, 1.3, 0.5, 1.0], [0.1, 0.0, 0.2, 0.0]);
        let mut s = scene();
        s.wavelengths = Wavelengths::Visible;
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, -2.0));
        add_screen(&mut s, &rectangle(corners), input);
        let world = World::freeze(&s).expect("the scene can be traced");
        let optics = <Rgb as Mode>::optics(&world, 0, 0);
        let screen = &world.lamps.all()[0];
        // Where in the texture the screen's middle lies, and how fast that moves. All of it is one chart.
        let at = |x: f64, y: f64| {
            let (position, triangle) = (screen.around().0 + DVec3::new(x, y, 0.0), u32::from(y > x));
            let place = LampPoint { position, normal: DVec3::Z, triangle };
            (screen.in_texture(triangle, position).unwrap(), screen.glow(&place, DVec3::Z).unwrap())
        };
        let (middle, right, up) = (at(0.0, 0.0).0, at(0.5, 0.0).0, at(0.0, 0.5).0);
        let (right, up) = (2.0 * (right - middle), 2.0 * (up - middle));
        for (x, y, size) in [(0.1, -0.2, 0.05), (-0.3, 0.4, 0.5), (0.0, 0.0, 1.8), (0.62, 0.55, 0.3)] {
            let start = middle + right * x + up * y;
            let lines = [0, 1].map(|way| Lines { first: start[way], by: DVec2::new(right[way], up[way]) * size });
            let brightness = Brightness::<Rgb> { middle: [2.0, 1.0, 3.0], by: [[0.5, -0.3, 0.0], [0.2, 0.0, 1.0]] };
            let texels = texels::Texels { lamp: 0, at: lines };
            let (got, _) = mean_of((&world, &optics), (&brightness, Some(&texels)), (&[], &[])).unwrap();
            let side = 300;
            let mut want = [0.0; 3];
            for k in 0..side * side {
                let point = DVec2::new((k % side) as f64 + 0.5, (k / side) as f64 + 0.5) / side as f64 - 0.5;
                let (_, glow) = at(x + size * point.x, y + size * point.y);
                let (bright, factor) = (brightness.at(point), texels.factor((&world, &optics), point));
                for lane in 0..3 {
                    want[lane] += bright[lane] * glow[lane] / (side * side) as f64;
                    assert!(
                        (factor[lane] - glow[lane]).abs() < 1e-5 || filter == Filter::Nearest,
                        "{factor:?} {glow:?}"
                    );
                }
            }
            let off = (0..3).map(|lane| (got[lane].open() - want[lane]).abs() / want[lane]).fold(0.0, f64::max);
            assert!(off < 5e-3, "{filter:?} {wrap:?} {x} {y} {size}: {off:.1e}");
        }
        // Far finer than the square it is left alone, and so is what is nowhere.
        let fine = |by: f64| texels::Texels { lamp: 0, at: [Lines { first: 0.0, by: DVec2::splat(by) }; 2] };
        let brightness = Brightness::<Rgb> { middle: [1.0; 3], by: [[0.0; 3]; 2] };
        for by in [1e3, 1e18, f64::INFINITY, f64::NAN] {
            assert!(mean_of((&world, &optics), (&brightness, Some(&fine(by))), (&[], &[])).is_none(), "{by}");
        }
    }
}

/// What is seen of a screen by 16 × 12 pixels.
struct Case {
    what: &'static str,
    filter: Filter,
    wrap: [Wrap; 2],
    /// Texels are so many times finer than about a pixel.
    finer: f64,
    pupil_m: f64,
    colour: bool,
    polarised: bool,
    screen: Screen,
    before: Option<Before>,
    mode: Spectral,
    /// After so many passes the squared error has to be so many times less.
    passes: u64,
    gain: f64,
}

#[derive(Clone, Copy)]
enum Screen {
    Flat,
    /// A part of a cylinder of so many strips.
    Curved(usize),
    /// Its two triangles show the texture at places of their own.
    TwoCharts,
}

enum Before {
    Plate(Dispersion),
    Mirror,
    Slide,
}

impl Screen {
    fn triangles(self) -> Vec<[Corner; 3]> {
        let corner = |x: f64, y: f64| DVec3::new(0.25 * x, 0.2 * y, -1.0 + 0.05 * x - 0.08 * y);
        let flat = || rectangle([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        match self {
            Screen::Flat => flat(),
            Screen::Curved(strips) => (0..strips)
                .flat_map(|k| {
                    let at = |k: usize, y: f64| {
                        let u = k as f64 / strips as f64;
                        let (sin, cos) = (u - 0.5).sin_cos();
                        (DVec3::new(0.5 * sin, 0.2 * y, -0.6 - 0.5 * cos), [u, 0.5 + 0.5 * y])
                    };
                    let (a, b, c, d) = (at(k, -1.0), at(k + 1, -1.0), at(k + 1, 1.0), at(k, 1.0));
                    [[a, b, c], [a, c, d]]
                })
                .collect(),
            Screen::TwoCharts => {
                let mut two = flat();
                for (_, [u, v]) in &mut two[1] {
                    (*u, *v) = (0.3 + 0.6 * *v, 0.1 - 0.9 * *u);
                }
                two
            }
        }
    }
}

impl Case {
    fn scene(&self) -> Scene {
        let mut s = scene();
        let value = |x: usize, y: usize, c: usize| match (self.colour, (x * 5 + (c + 2) * y + c + x * y) % 4) {
            (true, k) => [0.02, 0.3, 0.6, 1.0][k],
            (false, _) => [0.02, 1.0, 0.3][(x * 2 + y * y) % 3],
        };
        let texels = (0..21 * 13).map(|k| [0, 1, 2].map(|c| value(k % 21, k / 21, c))).collect();
        let mut input = picture(21, texels, self.filter, self.wrap);
        input.to_picture = [[1.3, 0.2, -0.31], [-0.15, 1.2, 0.17]].map(|[a, b, c]| [a * self.finer, b * self.finer, c]);
        if self.colour {
            s.wavelengths = Wavelengths::Visible;
        }
        let mut triangles = self.screen.triangles();
        match &self.before {
            None | Some(Before::Slide) => {}
            Some(Before::Plate(index)) => add_plate(&mut s, 0.3, index),
            Some(Before::Mirror) => {
                add_mirror(&mut s, 0.3, PI / 4.0);
                let behind = |place: DVec3| DVec3::new(-0.3 - place.z, place.y, -0.3 - place.x);
                let turned = |[a, b, c]: [Corner; 3]| [a, c, b].map(|(place, uv)| (behind(place), uv));
                triangles = triangles.into_iter().map(turned).collect();
            }
        }
        if let Some(Before::Slide) = &self.before {
            s.slides.push(mottled_slide(100.0));
            let mut slide = face(Finish::None);
            slide.slide = Some(SlideId::from_index(0));
            let square = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1)]);
            add_part(&mut s, "slide", square, DVec3::NEG_Z * 0.4, None, vec![slide]);
        }
        add_screen(&mut s, &triangles, input);
        s.eye =
            Eye { pupil_diameter_m: self.pupil_m, focus_distance_m: 0.8, fov_deg: 22.0, resolution: PIXELS, ..s.eye };
        s
    }

    fn holds(&self) {
        let Case { what, polarised, mode, .. } = *self;
        let gain = Both { what, scene: self.scene(), polarised, mode, passes: [64, 16, self.passes] }.gain();
        assert!(gain > self.gain, "{what}: {gain}");
    }
}

const STRAIGHT: Case = Case {
    what: "straight",
    filter: Filter::Nearest,
    wrap: [Wrap::Repeat; 2],
    finer: 1.0,
    pupil_m: 0.0,
    colour: false,
    polarised: false,
    screen: Screen::Flat,
    before: None,
    mode: Spectral::Mono,
    passes: 2,
    gain: 10.0,
};

#[test]
fn straight() {
    STRAIGHT.holds();
    let mirrored = [Wrap::Mirror, Wrap::Clamp];
    Case { what: "filtered", filter: Filter::Linear, wrap: mirrored, ..STRAIGHT }.holds();
    Case { what: "through a pupil", filter: Filter::Linear, pupil_m: 4e-3, ..STRAIGHT }.holds();
    Case { what: "in colour", colour: true, mode: Spectral::Rgb, ..STRAIGHT }.holds();
}

/// What is much finer than a pixel, or nothing but one place of the texture, is for rays alone, to the bit.
#[test]
fn where_there_is_nothing_to_cut() {
    for finer in [0.0, 60.0, 1e18, 1e300] {
        let s = Case { finer, ..STRAIGHT }.scene();
        let [ours, plain] = [false, true].map(|plain| image(&traced(&s, Polarisation::Off, (2, 5), plain).0));
        assert_eq!(ours, plain, "{finer}");
        assert!(ours.iter().all(|(value, _)| *value > 0.0));
    }
}

#[test]
fn behind_a_slide() {
    Case { what: "slide", filter: Filter::Linear, before: Some(Before::Slide), ..STRAIGHT }.holds();
}

/// Of strips with a chart each, and of charts that don't go together: what is not linear is left to rays.
#[test]
fn by_several_charts() {
    Case { what: "curved", screen: Screen::Curved(40), pupil_m: 3e-3, ..STRAIGHT }.holds();
    Case { what: "curved, filtered", filter: Filter::Linear, screen: Screen::Curved(5), ..STRAIGHT }.holds();
    Case { what: "two charts", screen: Screen::TwoCharts, gain: 2.0, ..STRAIGHT }.holds();
}

#[test]
fn by_a_mirror() {
    Case { what: "mirror", before: Some(Before::Mirror), pupil_m: 4e-3, ..STRAIGHT }.holds();
}

#[test]
fn through_a_plate() {
    let plate = || Some(Before::Plate(Dispersion::Constant(1.5)));
    Case { what: "plate", before: plate(), ..STRAIGHT }.holds();
    Case { what: "plate, polarised", before: plate(), polarised: true, filter: Filter::Linear, ..STRAIGHT }.holds();
    Case { what: "plate in colour", before: plate(), colour: true, mode: Spectral::Rgb, ..STRAIGHT }.holds();
}

/// Wavelengths are new in each pass; four colours leave noise of their own.
#[test]
fn where_wavelengths_change() {
    let glass = Dispersion::Cauchy([1.5, 0.005, 0.0]);
    let (before, mode) = (Some(Before::Plate(glass)), Spectral::Hero);
    Case { what: "glass", before, colour: true, mode, passes: 16, gain: 2.0, ..STRAIGHT }.holds();
}
