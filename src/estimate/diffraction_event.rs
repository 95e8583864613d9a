//! What happens at a grating: the orders that leave it, and the choice between them.

use super::ledger::Ledger;
use super::tuning::diffraction_event::MOST_MORE;
use super::walk::{Meeting, Travel, Vertex, Walker};
use eyebox_base::chain::Step;
use eyebox_base::lpe::Letter;
use eyebox_base::path::Event;
use eyebox_world::grating::{Grating, diffract};
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::stokes::{Amount, Turning};
use eyebox_world::surface::Surface;
use glam::DVec3;

/// One way on from a grating.
struct Way<M: Mode> {
    order: i32,
    through: bool,
    dir: DVec3,
    amounts: M::Lanes<M::Amount>,
    axis: <M::Amount as Amount>::Axis,
}

impl<M: Mode> Way<M> {
    fn step(&self) -> Step {
        if self.through { Step::Through } else { Step::Back }
    }
}

impl<'w, M: Mode> Walker<'w, M> {
    /// Goes on in one order of a grating: the asked one, or one by chance in proportion to what it carries. What no order has is
    /// absorbed. Wavelengths part here.
    pub(super) fn diffract(&mut self, vertex: &Vertex, grating: &Grating, ledger: &mut Ledger) -> Meeting<'w> {
        let asked = self.order.take();
        self.part_wavelengths(ledger);
        let ways = self.orders(vertex, grating);
        let powers: Vec<f64> = ways.iter().map(|way| self.mean_power(&way.amounts)).collect();
        let total: f64 = powers.iter().sum();
        let before = self.beam.carried();
        let chosen = match asked {
            Some((step, order)) => {
                let wanted = |way: &Way<M>| (way.step(), way.order) == (step, order);
                ways.iter().position(wanted).map(|index| (index, 1.0))
            }
            None => {
                let mut left = self.rng.uniform() * total;
                let hit = powers.iter().position(|power| {
                    left -= power;
                    left < 0.0
                });
                // Rounding may leave a little.
                let last = powers.iter().rposition(|power| *power > 0.0);
                hit.or(last).map(|index| (index, total / powers[index]))
            }
        };
        let weight = self.beam.weight();
        let lost = if weight > 0.0 { before * (1.0 - total / weight) } else { 0.0 };
        let Some((index, factor)) = chosen else {
            self.absorb(vertex.hit.site.part, before, ledger);
            return Meeting::Ended;
        };
        if asked.is_none() {
            self.lose(vertex, lost, ledger);
        }
        if asked.is_none() && weight > 0.0 {
            ledger.by_chance(before * powers[index] * factor / weight - (before - lost));
        }
        self.take_way(vertex, &ways[index], factor, ledger)
    }

    /// Where two orders of a grating or more carry at least `least` of the power each: paths that have gone on in every such order,
    /// the brightest first, and one in an order by chance among the fainter ones, of which it is as likely as their power is of
    /// `least`. They have the light of this path, which has ended. None elsewhere, and where far more would go on than has arrived,
    /// as by a table that no grating has (shares of light that comes the other way may be more than 1 together): this path [meets](Walker::meet) the vertex as ever.
    pub fn split_orders(&mut self, vertex: &Vertex, least: f64, ledger: &mut Ledger) -> Option<Vec<Walker<'w, M>>> {
        let Surface::Grating(grating) = &self.face(vertex).surface else { return None };
        if self.events + 1 >= Ledger::MOST_EVENTS || self.is_passed(vertex, ledger) {
            return None;
        }
        self.part_wavelengths(ledger);
        let weight = self.beam.weight();
        let ways = self.orders(vertex, grating).into_iter();
        let mut ways: Vec<(f64, Way<M>)> = ways.map(|way| (self.mean_power(&way.amounts), way)).collect();
        ways.retain(|(power, _)| *power > 0.0);
        ways.sort_by(|a, b| b.0.total_cmp(&a.0));
        let strong = ways.iter().take_while(|(power, _)| *power >= least * weight).count();
        let sum = |ways: &[(f64, Way<M>)]| ways.iter().map(|(power, _)| power).sum::<f64>();
        if strong < 2 || sum(&ways) > MOST_MORE * weight {
            return None;
        }
        self.events += 1;
        self.ahead = None;
        self.trail = self.trail.then(Event::Specular);
        let (strong, faint) = ways.split_at(strong);
        let carried = self.beam.carried() / weight;
        self.lose(vertex, carried * (weight - sum(&ways)), ledger);
        let mut went = Vec::with_capacity(strong.len() + 1);
        for (_, way) in strong {
            went.extend(self.branch(vertex, (way, 1.0), ledger));
        }
        let of_faint = sum(faint);
        let chance = (of_faint / (least * weight)).min(1.0);
        let mut left = self.rng.uniform() * of_faint / chance;
        let chosen = faint.iter().find(|(power, _)| {
            left -= power;
            left < 0.0
        });
        match chosen {
            Some((power, way)) => {
                let factor = of_faint / (power * chance);
                ledger.by_chance(carried * (power * factor - of_faint));
                went.extend(self.branch(vertex, (way, factor), ledger));
            }
            None => ledger.by_chance(-carried * of_faint),
        }
        Some(went)
    }

    /// A path like this one that has gone on in one order.
    fn branch(&mut self, vertex: &Vertex, (way, factor): (&Way<M>, f64), ledger: &mut Ledger) -> Option<Walker<'w, M>> {
        let mut own = self.clone();
        own.rng = self.rng.fork();
        matches!(own.take_way(vertex, way, factor, ledger), Meeting::Went).then_some(own)
    }

    /// Goes on in one order, which counts `factor` times.
    fn take_way(&mut self, vertex: &Vertex, way: &Way<M>, factor: f64, ledger: &mut Ledger) -> Meeting<'w> {
        self.beam.replace(way.amounts, way.axis);
        self.beam.scale(factor);
        self.tell(Letter::of(Event::Specular, way.through));
        self.link_order(vertex, way.step(), way.order);
        self.go(vertex, way.dir, way.through, ledger)
    }

    /// Books what no order has; below 0 what a table that is not the same both ways has too much.
    fn lose(&mut self, vertex: &Vertex, carried: f64, ledger: &mut Ledger) {
        self.absorb(vertex.hit.site.part, carried.max(0.0), ledger);
        ledger.by_chance((-carried).max(0.0));
    }

    fn part_wavelengths(&mut self, ledger: &mut Ledger) {
        if (1..self.beam.count()).any(|lane| self.optics.nm(lane) != self.optics.nm(0)) {
            let before = self.beam.carried();
            self.beam.part();
            ledger.by_chance(self.beam.carried() - before);
        }
    }

    fn mean_power(&self, amounts: &M::Lanes<M::Amount>) -> f64 {
        let count = self.beam.count();
        amounts.as_slice()[..count].iter().map(|amount| amount.power()).sum::<f64>() / count as f64
    }

    /// Shares belong to light: on the way from the eye those of light that arrives the way that the path leaves.
    fn orders(&self, vertex: &Vertex, grating: &Grating) -> Vec<Way<M>> {
        let (n1, n2) = (self.index_here(), self.index_beyond(vertex));
        let (dir, normal) = (self.ray.dir, vertex.normal);
        let across = self.world.geometry.part_to_world(vertex.hit.site.part).transform_vector3(grating.direction);
        let grooves = normal.cross(across);
        let from_eye = self.travel == Travel::FromEye;
        // How the light arrives that goes on, or has come, that way.
        let incidence = |onward: DVec3, through: bool| {
            let (dir, front) = if from_eye { (-onward, vertex.outside != through) } else { (dir, vertex.outside) };
            Grating::incidence(across, normal, (dir, front), self.optics.nm(0))
        };
        let mut ways = Vec::with_capacity(2 * grating.orders.count() + 2);
        for (place, order) in grating.orders.numbers().enumerate() {
            for through in [false, true] {
                let shift = grating.shift(across, self.optics.nm(0)) * f64::from(order);
                let Some(onward) = diffract(dir, normal, (n1[0], n2[0]), shift, through) else { continue };
                let own = grating.orders.efficiency(place, &incidence(onward, through));
                let shares = if through { own.transmittance } else { own.reflectance };
                if shares == [0.0; 2] {
                    continue;
                }
                let axis = M::Amount::axis_along(self.beam.axis(), dir, grooves);
                let turning = Turning::one_way(shares, through);
                let amounts = lanes::<M, _>(|lane| {
                    let parted = self.part(vertex, lane, axis, &turning);
                    if through { parted.transmitted } else { parted.reflected }
                });
                let axis = M::Amount::axis_along(axis, onward, grooves);
                ways.push(Way { order, through, dir: onward, amounts, axis });
            }
        }
        if grating.rest_in_zero_order {
            let axis = M::Amount::face_axis(self.beam.axis(), dir, normal);
            let cos = -dir.dot(normal);
            for through in [false, true] {
                let Some(onward) = diffract(dir, normal, (n1[0], n2[0]), DVec3::ZERO, through) else { continue };
                let arrives = incidence(onward, through);
                let amounts = lanes::<M, _>(|lane| {
                    let (a, b) = (n1[lane], n2[lane]);
                    let films = self.optics.films(0, lane);
                    let turning = films.turning::<M::Amount>(a, b, cos, vertex.outside, self.optics.nm(lane));
                    let along = a * (dir + normal * cos);
                    let (along, sides) = match (from_eye, through) {
                        (false, _) => (along, (a, b)),
                        (true, false) => (-along, (a, b)),
                        (true, true) => (-along, (b, a)),
                    };
                    let rest =
                        grating.rest(&arrives, along, grating.shift(across, self.optics.nm(lane)), normal, sides);
                    let left = |amount: M::Amount, axis, dir| self.left(vertex, (amount, axis, dir), grooves, rest);
                    let own = self.beam.amount(lane).turned(self.beam.axis(), axis, dir);
                    let own = if from_eye { own } else { left(own, axis, dir) };
                    let parted = self.part_of(vertex, own, &turning);
                    let own = if through { parted.transmitted } else { parted.reflected };
                    if from_eye { left(own, axis, onward) } else { own }
                });
                ways.push(Way { order: 0, through, dir: onward, amounts, axis });
            }
        }
        ways
    }

    /// What the orders leave of an amount along `dir`: shares of what is polarised along the lines and across them.
    fn left(
        &self,
        vertex: &Vertex,
        (amount, axis, dir): (M::Amount, <M::Amount as Amount>::Axis, DVec3),
        grooves: DVec3,
        rest: [f64; 2],
    ) -> M::Amount {
        if rest[0] == rest[1] {
            return amount.scaled(rest[0]);
        }
        let lines = M::Amount::axis_along(axis, dir, grooves);
        let parted = self.part_of(vertex, amount.turned(axis, lines, dir), &Turning::one_way(rest, true));
        parted.transmitted.turned(lines, axis, dir)
    }
}
