//! Random numbers that are a function of their key: (seed, stream, pass, sample) and the dimension within the sample.
//! Never of threads or time, so any thread count and any sharding gives the same bits.

/// What the numbers are for: two purposes never share numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    Backward,
    Forward,
    PhotonEmission,
    PhotonGather,
    Pilot,
    Check,
    Vision,
    /// Of the lattice on which paths from the eye start, see `estimate::pixel`.
    PixelShift,
    Wavelengths,
    Connection,
    ConnectionLook,
    ConnectionChoice,
    Looks,
    /// The scrambles of even points, see [`super::sobol`].
    Scramble,
    /// Of the lattice on which paths from the eye choose places on lamps.
    LampPoint,
    /// Of the points about the image of a lamp.
    Glint,
    /// Of the sequences by which paths from the eye scatter, see `estimate::even`.
    Bounce,
    FinalGather,
    /// Of a pilot that looks where light of the sky gets in.
    Daylight,
    /// Where photons are crowded and a pixel takes more rays than one.
    PhotonCrowd,
    /// Of the rays that tell where they are.
    PhotonMiddle,
    /// Where the boxes lie in which photons are counted.
    PhotonBoxes,
    /// Of the pixels that a witness looks at, and of how many times.
    Witness,
    /// Of the frames of a sequence, whose seeds it makes.
    Frame,
    /// Of the lattice of points of a lamp that connection's tables are asked about.
    ConnectionLamp,
    /// Of what is off in a design that is made.
    Tolerance,
    /// Of the pixels that get passes of their own by chance.
    Adaptive,
    /// Of light that is traced from lamps to a sensor, and of paths from the sensor to the sky.
    Sensor,
    SensorSky,
    /// Of the paths that look for edges of pictures in pixels.
    PictureEdges,
    /// Of those that look for pixels of the sky's picture, and of places of the pupil by which these are seen.
    SkyPixels,
    /// Of the lattice of places of the pixel, the pupil and lamps by which tables tell of edges on screens, and its choices.
    ConnectionMeans,
}

/// A counter-based generator: the key is mixed once, then each number is the mix of key and a counter.
///
/// Both steps use the 64-bit finaliser "variant 13" of D. Stafford ("Better bit mixing", 2011), the output function of
/// SplitMix64 (Steele, Lea, Flood 2014), on a Weyl sequence.
#[derive(Debug, Clone)]
pub struct Rng {
    key: u64,
    counter: u64,
}

pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

const WEYL: u64 = 0x9e37_79b9_7f4a_7c15;

impl Rng {
    /// The generator of sample `sample` in pass `pass`.
    pub fn new(seed: u64, stream: Stream, pass: u64, sample: u64) -> Self {
        let mut key = mix(seed.wrapping_add(WEYL));
        for word in [stream as u64 + 1, pass, sample] {
            key = mix(key ^ mix(word.wrapping_add(WEYL).wrapping_mul(0xd134_2543_de82_ef95)));
        }
        Rng { key, counter: 0 }
    }

    /// A generator with numbers of its own, for a path that branches off.
    pub fn fork(&mut self) -> Rng {
        Rng { key: mix(self.next_u64() ^ WEYL), counter: 0 }
    }

    pub fn next_u64(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(WEYL);
        mix(self.key ^ mix(self.counter.wrapping_add(self.key)))
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    pub fn pair(&mut self) -> [f64; 2] {
        [self.uniform(), self.uniform()]
    }

    pub fn triple(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_function_of_its_key() {
        let take = |seed, stream, pass, sample| {
            let mut rng = Rng::new(seed, stream, pass, sample);
            [rng.next_u64(), rng.next_u64()]
        };
        let base = take(1, Stream::Backward, 2, 3);
        assert_eq!(base, take(1, Stream::Backward, 2, 3));
        for other in [
            take(2, Stream::Backward, 2, 3),
            take(1, Stream::Forward, 2, 3),
            take(1, Stream::Backward, 3, 3),
            take(1, Stream::Backward, 2, 4),
            take(1, Stream::Backward, 3, 2),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn neighbouring_keys_give_independent_uniform_numbers() {
        // First numbers of neighbouring samples on a 16 × 16 grid of (first, second): chi-squared with 255 degrees of
        // freedom stays below its 0.9999 quantile (346).
        let mut cells = [0u32; 256];
        let count = 1 << 18;
        for sample in 0..count {
            let [a, b] = Rng::new(7, Stream::Forward, sample >> 9, sample & 511).pair();
            cells[(a * 16.0) as usize * 16 + (b * 16.0) as usize] += 1;
        }
        let want = count as f64 / 256.0;
        let chi2: f64 = cells.iter().map(|&n| (n as f64 - want).powi(2) / want).sum();
        assert!(chi2 < 346.0, "chi² = {chi2}");
    }
}
