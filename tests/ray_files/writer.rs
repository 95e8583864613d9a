//! Writers of ray files, from the facts of the formats: <https://github.com/JuliusMuschaweck/TM25RaySetTools> (`TM25_impl.h`,
//! `WriteHeader`; `ZemaxBinary.h`).

/// A ray: place in mm, direction, flux.
pub type Ray = ([f64; 3], [f64; 3], f64);

/// What a TM-25 file has beside its rays' places and directions, each a further number of every ray in the file's order.
#[derive(Debug, Clone, Default)]
pub struct Tm25 {
    pub version: Option<i32>,
    pub lumens: f32,
    pub watts: f32,
    pub spectral: i32,
    pub line_nm: f32,
    pub spectra: Vec<Vec<(f32, f32)>>,
    /// Of radiant flux, wavelength, luminous flux, Stokes parameters, tristimulus values, spectrum.
    pub flags: [bool; 6],
    pub names: usize,
    pub text: usize,
}

pub fn tm25(head: &Tm25, rays: &[Vec<f32>]) -> Vec<u8> {
    let mut out = b"TM25".to_vec();
    out.extend(head.version.unwrap_or(2013).to_le_bytes());
    out.extend(1i32.to_le_bytes());
    out.extend(head.lumens.to_le_bytes());
    out.extend(head.watts.to_le_bytes());
    out.extend((rays.len() as u64).to_le_bytes());
    let mut date = b"2026-11-29T05:30:00+00:00".to_vec();
    date.resize(28, 0);
    out.extend(date);
    out.extend(0i32.to_le_bytes());
    out.extend(head.spectral.to_le_bytes());
    [head.line_nm, f32::NAN, f32::NAN].iter().for_each(|x| out.extend(x.to_le_bytes()));
    for count in [head.spectra.len(), head.names, head.text] {
        out.extend((count as i32).to_le_bytes());
    }
    out.resize(256, 0);
    let flags = [true, true].into_iter().chain(head.flags);
    flags.for_each(|flag| out.extend(i32::from(flag).to_le_bytes()));
    out.resize(288 + 9 * 4000, 0);
    let start = out.len();
    for rows in &head.spectra {
        out.extend((rows.len() as i32).to_le_bytes());
        rows.iter().for_each(|(nm, power)| [nm, power].iter().for_each(|x| out.extend(x.to_le_bytes())));
    }
    out.resize(start + (out.len() - start).next_multiple_of(32), 0);
    out.resize(out.len() + 512 * head.names + head.text, b' ');
    rays.iter().flatten().for_each(|x| out.extend(x.to_le_bytes()));
    out
}

/// The first six numbers of a ray and what follows.
pub fn row((place, dir, _): &Ray, rest: &[f32]) -> Vec<f32> {
    place.iter().chain(dir).map(|x| *x as f32).chain(rest.iter().copied()).collect()
}

/// A file of rays with luminous flux alone.
pub fn luminous(rays: &[Ray]) -> Vec<u8> {
    let lumens = rays.iter().map(|ray| ray.2).sum::<f64>() as f32;
    let head = Tm25 { lumens, flags: [false, false, true, false, false, false], ..Tm25::default() };
    let rows: Vec<Vec<f32>> = rays.iter().map(|ray| row(ray, &[ray.2 as f32])).collect();
    tm25(&head, &rows)
}

/// `unit`: 0 m, 1 in, 2 cm, 3 ft, 4 mm; `format`: 0 or 2; `flux`: 0 W, 1 lm.
pub fn zemax([unit, format, flux]: [i32; 3], rays: &[Vec<f32>]) -> Vec<u8> {
    let mut out = 1010i32.to_le_bytes().to_vec();
    out.extend((rays.len() as u32).to_le_bytes());
    out.resize(136, 0);
    out.extend(unit.to_le_bytes());
    out.resize(192, 0);
    out.extend(format.to_le_bytes());
    out.extend(flux.to_le_bytes());
    out.resize(208, 0);
    rays.iter().flatten().for_each(|x| out.extend(x.to_le_bytes()));
    out
}

/// `count` rays of a Lambertian square of half side `half_mm` in z = 0 that shines along +z: places and directions of a
/// lattice of rank one with the plastic number's kin (Roberts' sequence) for four dimensions.
pub fn lambertian(count: usize, half_mm: f64, lumens: f64) -> Vec<Ray> {
    // The root of x⁵ = x + 1.
    let root: f64 = 1.167_303_978_261_418_7;
    (0..count)
        .map(|k| {
            let [a, b, u, v] = [1, 2, 3, 4].map(|i| (0.5 + (k + 1) as f64 / root.powi(i)).fract());
            let place = [half_mm * (2.0 * a - 1.0), half_mm * (2.0 * b - 1.0), 0.0];
            let (sin, (y, x)) = (u.sqrt(), (std::f64::consts::TAU * v).sin_cos());
            (place, [sin * x, sin * y, (1.0 - u).sqrt()], lumens / count as f64)
        })
        .collect()
}
