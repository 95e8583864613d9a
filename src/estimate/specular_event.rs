//! What happens at a specular face: shares and amounts per lane for both ways on, the choice between them, and the
//! splitting of a path that follows both.

use super::ledger::Ledger;
use super::walk::{Meeting, Travel, Vertex, Walker};
use eyebox_base::chain::Step;
use eyebox_base::lpe::Letter;
use eyebox_base::path::Event;
#[cfg(test)]
use eyebox_world::Planted;
use eyebox_world::fresnel::{reflect, refract};
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::sheet::{Incidence, ReflectivePolariser, Sheet, passed};
use eyebox_world::stokes::{Amount, Parted, Turning};
use eyebox_world::surface::{Mirror, Surface};
use glam::DVec3;

/// One of the ways on from a specular face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    Reflected,
    Refracted,
    /// Back, and there is no other way: what does not go there is absorbed.
    Only,
}

/// How a path's faint branches are followed.
#[derive(Debug, Clone, Copy)]
pub struct Faint {
    /// What the path started with.
    pub whole: f64,
    /// How much more often than their share they are, and count less.
    pub often: f64,
}

impl Faint {
    /// Less of the whole than this is followed as often as its share says: there are ever more of them.
    const LEAST: f64 = 1e-6;

    /// Branches of a path with this share of what it started with and more are followed for certain, fainter ones as much
    /// less often.
    pub fn down_to<M: Mode>(share: f64, walker: &Walker<'_, M>) -> Faint {
        Faint { whole: walker.start_weight(), often: (walker.share() / share).max(1.0) }
    }
}

/// What a face makes of the amounts that a path carries.
#[derive(Debug, Clone, Copy)]
pub struct SpecularEvent<M: Mode> {
    reflected: M::Lanes<M::Amount>,
    transmitted: M::Lanes<M::Amount>,
    /// Power per lane that stays at the face.
    absorbed: M::Lanes<f64>,
    /// Power by which what is reflected departs from what it would be without polarisation.
    departs: M::Lanes<f64>,
    /// Largest |R + T + A − 1| of the lanes.
    error: f64,
    /// Reference direction of the amounts, s, and that of those which are reflected: s, too, but at a sheet.
    axis: <M::Amount as Amount>::Axis,
    back: <M::Amount as Amount>::Axis,
    /// Where the first lane's transmitted light goes; none if there is none.
    refracted: Option<DVec3>,
    /// The other lanes' light goes elsewhere.
    disperses: bool,
    /// Goes straight on through a thin sheet.
    straight: bool,
}

impl<M: Mode> SpecularEvent<M> {
    /// Whether there is transmitted light to follow.
    pub fn refracts(&self) -> bool {
        self.refracted.is_some()
    }

    /// Power of the two ways on, as what goes on stands for it: the first lane alone where the others part from it.
    pub(super) fn powers(&self, walker: &Walker<'_, M>) -> [f64; 2] {
        let count = walker.beam.count();
        let mean = |amounts: &M::Lanes<M::Amount>, count: usize| {
            let sum: f64 = amounts.as_slice()[..count].iter().map(|amount| amount.power()).sum();
            if count == 1 { sum } else { sum / count as f64 }
        };
        [mean(&self.reflected, count), mean(&self.transmitted, if self.disperses { 1 } else { count })]
    }
}

impl<'w, M: Mode> Walker<'w, M> {
    /// What the interface at `vertex` does, in the solids that are around the ray now.
    pub(super) fn turn(&self, vertex: &Vertex, coating: usize) -> SpecularEvent<M> {
        let (n1, n2) = (self.index_here(), self.index_beyond(vertex));
        let (dir, normal) = (self.ray.dir, vertex.normal);
        let cos_i = -dir.dot(normal);
        let axis = M::Amount::face_axis(self.beam.axis(), dir, normal);
        let refracted = refract(dir, normal, n1[0] / n2[0]);
        let used = self.beam.count();
        let disperses = (1..used).any(|lane| n1[lane] * n2[0] != n1[0] * n2[lane]);
        let mut error = 0f64;
        let parted = lanes::<M, Parted<M::Amount>>(|lane| {
            if lane >= used {
                return nothing::<M>();
            }
            let films = self.optics.films(coating, lane);
            let turning = films.turning::<M::Amount>(n1[lane], n2[lane], cos_i, vertex.outside, self.optics.nm(lane));
            let parted = self.part(vertex, lane, axis, &turning);
            let parted = match self.face(vertex).tint {
                None => parted,
                Some(tint) => parted.stained(self.optics.reflected(tint, lane)),
            };
            error = error.max((parted.shares.iter().sum::<f64>() - 1.0).abs());
            let way = if lane == 0 || !disperses { refracted } else { refract(dir, normal, n1[lane] / n2[lane]) };
            if way.is_some() && parted.shares[1] > 0.0 {
                return parted;
            }
            // Rounding at the critical angle may leave power to a direction that does not exist.
            let [r, t, a] = parted.shares;
            let reflected = if r > 0.0 { parted.reflected.scaled((r + t) / r) } else { parted.reflected };
            Parted { shares: [r + t, 0.0, a], reflected, transmitted: M::Amount::plain(0.0), departs: parted.departs }
        });
        let crosses = parted[0].shares[1] > 0.0;
        SpecularEvent { refracted: refracted.filter(|_| crosses), disperses, ..self.collect(parted, axis, error) }
    }

    /// What a mirror at `vertex` does.
    pub(super) fn turn_at_mirror(&self, vertex: &Vertex, mirror: Mirror) -> SpecularEvent<M> {
        let n1 = self.index_here();
        let cos_i = -self.ray.dir.dot(vertex.normal);
        let axis = M::Amount::face_axis(self.beam.axis(), self.ray.dir, vertex.normal);
        let mut error = 0f64;
        let parted = lanes::<M, Parted<M::Amount>>(|lane| {
            let parted = self.part(vertex, lane, axis, &mirror.turning::<M::Amount>(n1[lane], cos_i));
            error = error.max((parted.shares.iter().sum::<f64>() - 1.0).abs());
            parted
        });
        self.collect(parted, axis, error)
    }

    /// What a reflective polariser at `vertex` does.
    pub(super) fn turn_at_splitter(&self, vertex: &Vertex, sheet: &ReflectivePolariser) -> SpecularEvent<M> {
        let dir = self.ray.dir;
        let to = self.world.geometry.part_to_world(vertex.hit.site.part).transform_vector3(sheet.axis);
        let axis =
            M::Amount::axis_along(self.beam.axis(), dir, passed((to, sheet.projected_axis), dir, vertex.hit.normal));
        let turning = sheet.turning();
        let mut error = 0f64;
        let parted = lanes::<M, Parted<M::Amount>>(|lane| {
            let parted = self.part(vertex, lane, axis, &turning);
            error = error.max((parted.shares.iter().sum::<f64>() - 1.0).abs());
            parted
        });
        let crosses = (0..self.beam.count()).any(|lane| parted[lane].shares[1] > 0.0);
        SpecularEvent {
            back: M::Amount::mirrored(axis, vertex.normal),
            refracted: crosses.then_some(dir),
            straight: true,
            ..self.collect(parted, axis, error)
        }
    }

    /// By how much polarisation changes the power that the face at `vertex` reflects.
    pub fn departure(&self, vertex: &Vertex) -> f64 {
        let turn = match &self.face(vertex).surface {
            Surface::Mirror(mirror) => self.turn_at_mirror(vertex, *mirror),
            Surface::Interface(coating) => self.turn(vertex, *coating),
            Surface::Splitter(sheet) => self.turn_at_splitter(vertex, sheet),
            Surface::Absent
            | Surface::Absorber
            | Surface::Slide(_)
            | Surface::Sheet(_)
            | Surface::Grating(_)
            | Surface::Scatter(_) => return 0.0,
        };
        (0..self.beam.count()).map(|lane| turn.departs[lane]).fold(0.0, f64::max)
    }

    pub(super) fn part(
        &self,
        vertex: &Vertex,
        lane: usize,
        axis: <M::Amount as Amount>::Axis,
        turning: &Turning,
    ) -> Parted<M::Amount> {
        self.part_of(vertex, self.beam.amount(lane).turned(self.beam.axis(), axis, self.ray.dir), turning)
    }

    /// The same of an amount that is given with respect to s.
    pub(super) fn part_of(&self, _vertex: &Vertex, amount: M::Amount, turning: &Turning) -> Parted<M::Amount> {
        let parted = amount.part(turning, self.travel == Travel::FromEye);
        #[cfg(test)]
        if self.world.planted == (Planted::Leak { part: _vertex.hit.site.part }) {
            let [r, t, a] = parted.shares;
            return Parted {
                shares: [0.99 * r, 0.99 * t, a],
                reflected: parted.reflected.scaled(0.99),
                transmitted: parted.transmitted.scaled(0.99),
                departs: parted.departs,
            };
        }
        parted
    }

    /// Goes straight through a sheet; what it takes is booked.
    pub(super) fn go_through(&mut self, vertex: &Vertex, sheet: &Sheet, ledger: &mut Ledger) {
        let part = vertex.hit.site.part;
        let before = self.beam.carried();
        let at = Incidence { dir: self.ray.dir, normal: vertex.hit.normal, index: self.index_here()[0] };
        let to_world = self.world.geometry.part_to_world(part);
        let count = sheet.films.len();
        for k in 0..count {
            // In the order in which the ray meets them.
            let film = &sheet.films[if vertex.outside { k } else { count - 1 - k }];
            let of_sheet = to_world.transform_vector3(film.axis);
            let axis = M::Amount::axis_along(self.beam.axis(), at.dir, film.axis_for(of_sheet, &at));
            let amounts = lanes::<M, _>(|lane| {
                let turning = film.turning(self.optics.nm(lane), of_sheet, &at);
                self.part(vertex, lane, axis, &turning).transmitted
            });
            self.beam.replace(amounts, axis);
        }
        self.absorb(part, before - self.beam.carried(), ledger);
    }

    fn collect(
        &self,
        parted: M::Lanes<Parted<M::Amount>>,
        axis: <M::Amount as Amount>::Axis,
        error: f64,
    ) -> SpecularEvent<M> {
        SpecularEvent {
            reflected: lanes::<M, _>(|lane| parted[lane].reflected),
            transmitted: lanes::<M, _>(|lane| parted[lane].transmitted),
            absorbed: lanes::<M, _>(|lane| parted[lane].shares[2] * self.beam.amount(lane).power()),
            departs: lanes::<M, _>(|lane| parted[lane].departs),
            error,
            axis,
            back: axis,
            refracted: None,
            disperses: false,
            straight: false,
        }
    }

    /// Goes one way on from a specular face: the `forced` one, or one by chance in proportion to what it carries.
    pub(super) fn take_branch(
        &mut self,
        vertex: &Vertex,
        turn: &SpecularEvent<M>,
        forced: Option<Branch>,
        ledger: &mut Ledger,
    ) -> Meeting<'w> {
        ledger.check_vertex(turn.error);
        let [reflected, transmitted] = turn.powers(self);
        let both = reflected + transmitted;
        let (branch, factor, share_of_absorbed) = match forced {
            // The absorbed share is booked by the refracted branch alone.
            Some(Branch::Reflected) => (Branch::Reflected, 1.0, 0.0),
            Some(branch @ (Branch::Refracted | Branch::Only)) => (branch, 1.0, 1.0),
            None => {
                let share = if both > 0.0 { reflected / both } else { 0.0 };
                // Total reflection, and nothing reflected, leave no choice.
                let open = turn.refracts() && share > 0.0 && share < 1.0;
                let chance = if open { share.clamp(self.least_chance, 1.0 - self.least_chance) } else { share };
                let refracted = self.rng.uniform() >= chance;
                if refracted {
                    (Branch::Refracted, 1.0 / (1.0 - chance), 1.0)
                } else {
                    (Branch::Reflected, 1.0 / chance, 1.0)
                }
            }
        };
        let before = self.beam.carried();
        let absorbed = share_of_absorbed * self.beam.carried_with(&turn.absorbed);
        self.absorb(vertex.hit.site.part, absorbed, ledger);
        let (amounts, axis, dir) = match (branch, turn.refracted) {
            (Branch::Refracted, Some(dir)) => (&turn.transmitted, turn.axis, Some(dir)),
            (Branch::Refracted | Branch::Reflected | Branch::Only, _) => (&turn.reflected, turn.back, None),
        };
        self.beam.replace(*amounts, axis);
        if factor != 1.0 {
            self.beam.scale(factor);
        }
        let expected = if forced.is_none() { before - absorbed } else { self.beam.carried() };
        if dir.is_some() && turn.disperses {
            self.beam.part();
        }
        if M::LANES > 1 || self.least_chance > 0.0 {
            // The lanes are not alike: what one choice for all of them makes of the sum is chance.
            ledger.by_chance(self.beam.carried() - expected);
        }
        let straight = turn.straight && dir.is_some();
        self.tell(if straight { Letter::TransmitStraight } else { Letter::of(Event::Specular, dir.is_some()) });
        self.link(vertex, if dir.is_some() { Step::Through } else { Step::Back });
        match dir {
            Some(dir) => self.go(vertex, dir, true, ledger),
            None => self.go(vertex, reflect(self.ray.dir, vertex.normal), false, ledger),
        }
    }

    /// Splits a path at an interface where both ways carry at least `least` of the power: the returned path has been
    /// reflected there with its share, this one will be refracted when it [meets](Walker::meet) the vertex. Through a
    /// combiner the eye sees two worlds, and what is faint in one of them (a lamp's glint) should not wait for a rare
    /// choice. At most `most` times on one path.
    pub fn split(&mut self, vertex: &Vertex, least: f64, most: u8, ledger: &mut Ledger) -> Option<Walker<'w, M>> {
        if self.splits >= most {
            return None;
        }
        let turn = self.look_ahead(vertex, ledger)?;
        let [reflected, transmitted] = turn.powers(self);
        if reflected.min(transmitted) < least * self.beam.weight() {
            return None;
        }
        turn.refracted?;
        self.splits += 1;
        self.forced = Some(Branch::Refracted);
        self.reflected(vertex, ledger)
    }

    /// What the interface between two media at `vertex` will do, kept for [`Walker::meet`]; none if nothing parts there.
    pub(super) fn look_ahead(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> Option<SpecularEvent<M>> {
        let turn = match &self.face(vertex).surface {
            Surface::Interface(coating) => {
                if self.is_behind(vertex) {
                    return None;
                }
                self.heal(vertex, ledger);
                // Between equal media films part light, as a mirror embedded in glass does, and nothing else.
                let alike = self.index_here().as_slice() == self.index_beyond(vertex).as_slice();
                if alike && self.optics.films(*coating, 0).is_bare() {
                    return None;
                }
                self.turn(vertex, *coating)
            }
            Surface::Splitter(sheet) => {
                if self.is_behind(vertex) || self.heal(vertex, ledger) && self.is_outranked(vertex) {
                    return None;
                }
                self.turn_at_splitter(vertex, sheet)
            }
            Surface::Absent
            | Surface::Absorber
            | Surface::Slide(_)
            | Surface::Mirror(_)
            | Surface::Sheet(_)
            | Surface::Grating(_)
            | Surface::Scatter(_) => return None,
        };
        self.ahead = Some(turn);
        Some(turn)
    }

    /// A path like this one that is reflected at `vertex`; none if it ends there.
    fn reflected(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> Option<Walker<'w, M>> {
        let mut reflected = self.clone();
        reflected.rng = self.rng.fork();
        reflected.forced = Some(Branch::Reflected);
        match reflected.meet(vertex, ledger) {
            Meeting::Went => Some(reflected),
            Meeting::Ended | Meeting::Scatter(..) => None,
        }
    }

    /// At an interface that reflects little the path goes on through it for certain, and the reflection is followed by the
    /// returned path, as seldom as it carries little or as `faint` says: what is seen through a lens is not left to a choice
    /// that now and then goes elsewhere. Where both ways carry much of the light, as at a combiner's coating, both are
    /// followed, unless it is little of what the path started with. None where no path is to be followed; this one then
    /// [meets](Walker::meet) the vertex as ever.
    pub fn spare(&mut self, vertex: &Vertex, faint: Faint, ledger: &mut Ledger) -> Option<Walker<'w, M>> {
        /// Shares below this are little: paths are a tenth more at most.
        const LITTLE: f64 = 0.1;
        /// Less of the whole than this is not worth a path of its own: the ghost of an uncoated plate has some hundredths.
        const NOT_WORTH: f64 = 1.0 / 512.0;
        if self.least_chance > 0.0 || self.forced.is_some() {
            return None;
        }
        let turn = self.look_ahead(vertex, ledger)?;
        let [reflected, transmitted] = turn.powers(self);
        let chance = if reflected > 0.0 { reflected / (reflected + transmitted) } else { 0.0 };
        if !turn.refracts() || chance == 0.0 {
            return None;
        }
        if chance > LITTLE {
            if reflected.min(transmitted) < NOT_WORTH * faint.whole {
                return None;
            }
            self.splits = self.splits.saturating_add(1);
            self.forced = Some(Branch::Refracted);
            return self.reflected(vertex, ledger);
        }
        self.forced = Some(Branch::Refracted);
        let chance = if reflected > Faint::LEAST * faint.whole { (chance * faint.often).min(1.0) } else { chance };
        if self.rng.uniform() >= chance {
            let powers = lanes::<M, _>(|lane| turn.reflected[lane].power());
            ledger.by_chance(-self.beam.carried_with(&powers));
            return None;
        }
        let mut other = self.reflected(vertex, ledger)?;
        let before = other.beam.carried();
        other.beam.scale(1.0 / chance);
        ledger.by_chance(other.beam.carried() - before);
        Some(other)
    }

    /// Whether the path has been split before: it is past a combiner's first face.
    pub fn was_split(&self) -> bool {
        self.splits > 0
    }
}

/// A lane that is not in use.
fn nothing<M: Mode>() -> Parted<M::Amount> {
    let nothing = M::Amount::plain(0.0);
    Parted { shares: [1.0, 0.0, 0.0], reflected: nothing, transmitted: nothing, departs: 0.0 }
}
