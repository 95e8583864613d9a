//! What a path carries. The only thing that estimators do with it is to scale it and to ask for its light: how many
//! wavelengths there are, and whether they are polarised, is known here and in the vertex step alone.

use eyebox_film::accumulate::Light;
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::slide::SlideMap;
use eyebox_world::stokes::{Amount, Facets};
use glam::DVec3;

type Axis<M> = <<M as Mode>::Amount as Amount>::Axis;

/// How light that is kept is polarised; of no size where paths carry no polarisation.
#[derive(Debug, Clone, Copy)]
pub struct KeptPolarisation<M: Mode> {
    states: M::Lanes<<M::Amount as Amount>::State>,
    axis: Axis<M>,
}

/// Throughput of a path. The slides' factors are kept apart: decisions of the path (roulette) must not depend on the
/// contrast, so that pictures for two contrasts share every path.
#[derive(Debug, Clone, Copy)]
pub struct Throughput<M: Mode> {
    /// Everything but the slides.
    amounts: M::Lanes<M::Amount>,
    /// The reference direction of the amounts' polarisation.
    axis: Axis<M>,
    /// Product of the slides' transmittances, at their own contrast and as a polynomial.
    slides: M::Lanes<Light>,
    /// Dispersion has parted the lanes: the first stands for all.
    alone: bool,
}

impl<M: Mode> Throughput<M> {
    /// An unpolarised path along `dir`.
    pub fn new(weights: M::Lanes<f64>, dir: DVec3) -> Self {
        Throughput {
            amounts: lanes::<M, _>(|lane| M::Amount::plain(weights[lane])),
            axis: M::Amount::any_axis(dir),
            slides: lanes::<M, _>(|_| Light::ONE),
            alone: false,
        }
    }

    /// Lanes in use.
    #[inline]
    pub fn count(&self) -> usize {
        if self.alone { 1 } else { M::LANES }
    }

    /// Mean of a value over the lanes in use.
    #[inline]
    fn mean(&self, of_lane: impl Fn(usize) -> f64) -> f64 {
        let count = self.count();
        let sum: f64 = (0..count).map(of_lane).sum();
        if count == 1 { sum } else { sum / count as f64 }
    }

    /// Mean weight of the lanes, without the slides.
    #[inline]
    pub fn weight(&self) -> f64 {
        self.mean(|lane| self.amounts[lane].power())
    }

    /// What is carried at the scene's own contrast.
    #[inline]
    pub fn carried(&self) -> f64 {
        self.mean(|lane| self.amounts[lane].power() * self.slides[lane].value)
    }

    /// What would be carried with these weights.
    #[inline]
    pub fn carried_with(&self, weights: &M::Lanes<f64>) -> f64 {
        self.mean(|lane| weights[lane] * self.slides[lane].value)
    }

    #[inline]
    pub fn amount(&self, lane: usize) -> M::Amount {
        self.amounts[lane]
    }

    #[inline]
    pub fn axis(&self) -> Axis<M> {
        self.axis
    }

    #[inline]
    pub fn scale(&mut self, factor: f64) {
        self.amounts = lanes::<M, _>(|lane| self.amounts[lane].scaled(factor));
    }

    #[inline]
    pub fn scale_lanes(&mut self, factors: &M::Lanes<f64>) {
        self.amounts = lanes::<M, _>(|lane| self.amounts[lane].scaled(factors[lane]));
    }

    /// Goes on with other amounts.
    #[inline]
    pub fn replace(&mut self, amounts: M::Lanes<M::Amount>, axis: Axis<M>) {
        self.amounts = amounts;
        self.axis = axis;
    }

    /// Forgets all lanes but the first, which stands for all from now on.
    #[inline]
    pub fn part(&mut self) {
        self.alone = M::LANES > 1;
    }

    /// Forgets the polarisation: what a scatterer sends out along `dir` is unpolarised.
    #[inline]
    fn depolarise(&mut self, dir: DVec3) {
        if M::Amount::POLARISED {
            self.amounts = lanes::<M, _>(|lane| M::Amount::plain(self.amounts[lane].power()));
            self.axis = M::Amount::any_axis(dir);
        }
    }

    /// Goes on from a scatterer along `dirs[1]`, having come along `dirs[0]`: what its facets do to the polarisation, apart
    /// from how much they send; without facets there is none left. `from_eye`: the path started at the eye.
    pub fn scatter(&mut self, facets: Option<&M::Lanes<Facets>>, dirs: [DVec3; 2], from_eye: bool) {
        if !M::Amount::POLARISED {
            return;
        }
        let Some(facets) = facets else { return self.depolarise(dirs[1]) };
        // About the normal that mirrors one direction into the other.
        let axis = M::Amount::face_axis(self.axis, dirs[0], (dirs[1] - dirs[0]).normalize_or_zero());
        let old = *self;
        self.amounts =
            lanes::<M, _>(|lane| old.amounts[lane].turned(old.axis, axis, dirs[0]).scattered(&facets[lane], from_eye));
        self.axis = axis;
    }

    /// How what is carried is polarised.
    pub fn polarisation(&self) -> KeptPolarisation<M> {
        KeptPolarisation { states: lanes::<M, _>(|lane| self.amounts[lane].state()), axis: self.axis }
    }

    /// A path from the eye along `dir` where it meets light that is polarised so.
    #[must_use]
    pub fn meeting(mut self, light: &KeptPolarisation<M>, dir: DVec3) -> Self {
        let old = self.amounts;
        self.amounts = lanes::<M, _>(|lane| old[lane].meets(self.axis, dir, light.states[lane], light.axis));
        self
    }

    /// Light along `dir` that a lamp has polarised along `axis` to this degree; `from_eye`: the lamp is what a path from
    /// the eye ends at.
    #[must_use]
    pub fn polarised(mut self, (to, degree): (DVec3, f64), dir: DVec3, from_eye: bool) -> Self {
        if M::Amount::POLARISED {
            let axis = M::Amount::axis_along(self.axis, dir, to);
            let old = self;
            self.amounts = lanes::<M, _>(|lane| {
                old.amounts[lane].turned(old.axis, axis, dir).polarised_by_slide(degree, from_eye)
            });
            self.axis = axis;
        }
        self
    }

    /// Crosses a slide along `dir` where its picture has the values `s` per lane. `from_eye`: the path started at the eye.
    pub fn cross(
        &mut self,
        (slide, rank): (&SlideMap, f64),
        s: &M::Lanes<f64>,
        across: Option<DVec3>,
        dir: DVec3,
        from_eye: bool,
    ) {
        if M::Amount::POLARISED {
            // A slide's polarisers are part of its transmittance: what comes in counts by its power.
            let to = across.unwrap_or_else(|| dir.any_orthonormal_vector());
            *self = self.polarised((to, slide.polarisation_degree()), dir, from_eye);
        }
        self.show((slide, rank), s);
    }

    /// Light of a display that shows a slide, where the picture has the values `s` per lane: what the slide lets through of it.
    pub fn show(&mut self, (slide, rank): (&SlideMap, f64), s: &M::Lanes<f64>) {
        for lane in 0..M::LANES {
            self.slides[lane].cross(slide.t_white(), slide.transmittance(s[lane]), s[lane], rank);
        }
    }

    /// Adds the light of `amounts` per lane (luminance or flux) carried along this path to a plane's entries.
    #[inline]
    pub fn deposit(&self, optics: &Optics<M>, out: &mut [Light], amounts: &M::Lanes<f64>) {
        let light = lanes::<M, _>(|lane| self.slides[lane].scaled(self.amounts[lane].power() * amounts[lane]));
        M::deposit(optics, out, light, self.alone);
    }

    /// The light itself, for a photon that is stored; `alone`: only its first lane counts.
    pub fn stored(&self) -> (M::Lanes<Light>, bool) {
        (lanes::<M, _>(|lane| self.slides[lane].scaled(self.amounts[lane].power())), self.alone)
    }

    /// Adds the light of a lamp-side piece, scaled by `factors` and carried on along this path: slides on both pieces
    /// multiply at each contrast.
    pub fn join(
        &self,
        optics: &Optics<M>,
        out: &mut [Light],
        (flux, alone): (&M::Lanes<Light>, bool),
        factors: &M::Lanes<f64>,
    ) {
        let light = lanes::<M, _>(|lane| {
            self.slides[lane].times(flux[lane]).scaled(factors[lane] * self.amounts[lane].power())
        });
        M::deposit(optics, out, light, self.alone || alone);
    }
}
