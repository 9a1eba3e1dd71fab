//! How an alarm brings the axes to rest and takes the wheel off the part.
//!
//! ```text
//!  C and X work      the stream runs out on the path, X leaves it meanwhile       X = path + law of the retreat
//!  C does not        C brakes, X goes outwards by itself, faster than any part can follow
//!  X does not        C is stopped, a brake stops X, then a weight or spring draws it back
//! ```
//! The path is never cut short: a wheel that stood still while C turns on would go through the flank that comes. An X that
//! is on its way outwards of the path beside it never lies deeper than the path itself.

use super::{Machine, Mode};
use crate::machine::alarm::{AlarmKind, Severity};
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::math::hermite::Sample;
use crate::motion::point_to_point::{JerkLaw, solve, stop};
use crate::simulation::axis::{AxisState, Span, Target};
use crate::simulation::plausibility::DRIVE_HEADROOM;

const X: usize = Axis::X as usize;

/// Share of the limits of X that a retreat beside the path uses: what drives can do beyond them, which the path leaves.
const BESIDE_SHARE: f64 = DRIVE_HEADROOM - 1.0;

/// How far from its end a wheelhead that is drawn back is braked for good (mm).
const DRAWN_MM: f64 = 0.05;

/// X on its way off the part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Retreat {
    /// Way (mm over s) since `since`.
    law: JerkLaw,
    /// The last tick before it.
    since: u64,
    /// Where a retreat that follows no path begins and ends (counts, true).
    own: Option<(f64, f64)>,
}

crate::kept!(Retreat { law, since, own } on {});

impl Retreat {
    /// Not before this tick is over.
    pub(super) fn begins_after(&self, tick: u64) -> bool {
        self.since > tick
    }
}

/// A wheelhead that a weight or spring draws back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Draw {
    pull: f64,
    fastest: f64,
    end: f64,
}

crate::kept!(Draw { pull, fastest, end } on {});

impl Machine {
    /// How far X must be for the wheel to be off the lobe in front of it, and how near the axis the lobe comes (mm); none
    /// where it is off, or nothing is in front. Of a lathe the same for the insert's centre.
    fn too_near(&self, x_mm: f64) -> Option<(f64, f64)> {
        if self.description.is_lathe() {
            let (off_mm, nearest_mm) = self.turned_off_mm()?;
            let off_mm = off_mm + self.description.retract.clearance_mm;
            return (x_mm < off_mm).then_some((off_mm, nearest_mm.min(x_mm)));
        }
        let lobe = &self.part.lobes()[self.lobe_in_front()?];
        let off_mm = lobe.reach_mm() + self.description.retract.clearance_mm;
        let nearest_mm = lobe.radii_mm().iter().fold(lobe.reach_mm(), |least, radius| least.min(*radius));
        (x_mm < off_mm).then_some((off_mm, nearest_mm.min(x_mm)))
    }

    /// Sends X off the part if it is too near and its drive works.
    pub(super) fn begin_retreat(&mut self) {
        if self.retreat.is_some() || self.dead[X] {
            return;
        }
        let (axis, target) = (&self.axes[X], *self.axes[X].target());
        let per_mm = axis.counts_per_unit;
        let x_mm = target.position / per_mm;
        let Some((off_mm, nearest_mm)) = self.too_near(x_mm) else { return };
        let description = &self.description.axes[X];
        let soft_max_mm = description.soft_limits.map_or(f64::INFINITY, |(_, max)| max);
        let whole = |mm: f64| libm::round(mm * per_mm) / per_mm;
        let limits = description.limits;
        let (law, own) = if self.mode == Mode::Draining {
            // The path may still go down to where the lobe is nearest.
            let way_mm = whole((off_mm - nearest_mm).min(soft_max_mm - (off_mm - nearest_mm) - nearest_mm).max(0.0));
            (solve(way_mm, 0.0, 0.0, 0.0, &limits.with_share(BESIDE_SHARE)), None)
        } else {
            let (v0, a0) = (target.velocity / per_mm, target.acceleration / per_mm);
            let limits = crate::machine::description::MotionLimits {
                velocity: limits.velocity.max(v0.abs()),
                acceleration: limits.acceleration.max(a0.abs()),
                ..limits
            };
            let braking = stop(0.0, v0, a0, &limits);
            let least_mm = braking.sample(braking.duration()).value;
            let way_mm = (off_mm - x_mm).min(soft_max_mm - x_mm).max(least_mm);
            let end = libm::round(target.position + way_mm * per_mm);
            let way_mm = (end - target.position) / per_mm;
            (solve(way_mm, v0, a0, 0.0, &limits), Some((target.position, end)))
        };
        self.retreat = Some(Retreat { law, since: self.tick - 1, own });
    }

    /// Where the retreat is at the end of this tick, and whether it is over.
    fn retreating(&self) -> (Sample, bool) {
        let Some(retreat) = &self.retreat else { return (Sample::default(), true) };
        let at_s = (self.tick - retreat.since) as f64 * self.description.cycle_time_s();
        (retreat.law.sample(at_s), at_s >= retreat.law.duration())
    }

    /// Follows a setpoint of the stream, beside it where the wheel is on its way off the part.
    pub(super) fn follow(&mut self) {
        let (beside, _) = self.retreating();
        let followed = self.followed;
        for i in 0..AXIS_COUNT {
            let (counts, velocity, acceleration) = (followed.counts[i], followed.velocity[i], followed.acceleration[i]);
            if self.dead[i] {
                continue;
            }
            if i == X && self.retreat.is_some() {
                self.axes[i].follow_beside(counts, velocity, acceleration, &beside);
            } else {
                self.axes[i].follow(counts, velocity, acceleration);
            }
        }
    }

    /// The stream has come to rest: the axes halt once the wheel is off. The path may have gone deeper than the lobe was at the
    /// alarm, by what was still to be fed and by what wheel and part give way: then X goes the rest of the way by itself.
    pub(super) fn end_draining(&mut self) {
        if self.stream_moves() || !self.retreating().1 {
            return;
        }
        let retreats = self.retreat.take().is_some();
        if retreats {
            let end = libm::round(self.axes[X].target().position);
            self.axes[X].go(Target::resting(end));
        }
        let is_near =
            retreats && self.too_near(self.axes[X].target().position / self.axes[X].counts_per_unit).is_some();
        self.mode = if is_near { Mode::OwnStop } else { Mode::Halted };
    }

    /// Every axis decelerates at its limit, X goes off the part first.
    pub(super) fn stop_by_itself(&mut self) {
        let cycle_time_s = self.description.cycle_time_s();
        if self.retreat.is_some_and(|retreat| retreat.own.is_none()) {
            // It was beside a path that is not followed any more.
            self.retreat = None;
        }
        self.begin_retreat();
        let (sample, is_over) = self.retreating();
        for i in 0..AXIS_COUNT {
            if self.dead[i] {
                continue;
            }
            let axis = &mut self.axes[i];
            match self.retreat.and_then(|retreat| retreat.own).filter(|_| i == X) {
                Some((_, end)) if is_over => axis.go(Target::resting(end)),
                Some((from, _)) => axis.go(Target {
                    position: from + sample.value * axis.counts_per_unit,
                    velocity: sample.first * axis.counts_per_unit,
                    acceleration: sample.second * axis.counts_per_unit,
                }),
                None => axis.decelerate(cycle_time_s),
            }
        }
        if is_over && !self.setpoint_moves() {
            self.retreat = None;
            self.mode = Mode::Halted;
        }
    }

    /// Does what alarms ask for: drives that cannot go on lose their power now, the others once the axes rest.
    pub(super) fn react(&mut self) {
        for axis in Axis::ALL {
            let i = axis.index();
            if core::mem::take(&mut self.kill_due[i]) && !self.dead[i] {
                self.release(axis);
                // Without one of the two there is no path any more; the table's place is of no interest to it.
                if axis != Axis::Z && self.mode != Mode::Halted {
                    self.mode = Mode::OwnStop;
                }
            }
        }
        let off = self.alarms.iter().any(|alarm| alarm.kind.entry().severity == Severity::PowerOff);
        let rests = self.mode == Mode::Halted && self.retreat.is_none() && self.is_at_rest();
        if core::mem::take(&mut self.power_off_due) || (off && rests) {
            self.cut_power();
        }
    }

    /// No drive has power any more; what moves brakes.
    pub(super) fn cut_power(&mut self) {
        if !self.powered {
            return;
        }
        self.powered = false;
        self.mode = Mode::Halted;
        Axis::ALL.into_iter().for_each(|axis| self.release(axis));
    }

    fn release(&mut self, axis: Axis) {
        let i = axis.index();
        if self.dead[i] {
            return;
        }
        if axis == Axis::X {
            self.retreat = None;
            let state = &self.axes[i];
            let per_mm = state.counts_per_unit;
            let pull = self.description.retract.drawback_mm_s2;
            let near = self.too_near(state.true_position() / per_mm).filter(|_| pull > 0.0);
            // It stops within what its own speed needs; the soft limit is where the weight rests.
            let most_mm = self.description.axes[i].soft_limits.map_or(f64::INFINITY, |(_, max)| max);
            self.draw = near.map(|(off_mm, _)| Draw {
                pull: pull * per_mm,
                fastest: self.description.axes[i].limits.velocity * per_mm,
                end: libm::round(off_mm.min(most_mm) * per_mm),
            });
        }
        self.axes[i].release();
        self.dead[i] = true;
    }

    /// One servo step of every axis.
    pub(super) fn servo_step(&mut self, index: u32) -> [Span; AXIS_COUNT] {
        let (count, step_s, dead, draw) = (self.description.servo_steps_per_tick, self.step_s, self.dead, self.draw);
        let forces = self.cutting_forces();
        core::array::from_fn(|i| match draw.filter(|_| i == X && dead[i]) {
            _ if !dead[i] => self.axes[i].step(index, count, step_s, forces[i]),
            Some(draw) => self.axes[i].draw(draw.pull, draw.fastest, draw.end),
            None => self.axes[i].coast(),
        })
    }

    /// A wheelhead that has been drawn far enough is held by its brake; a buffer that is empty takes the power away.
    pub(super) fn end_of_retreat(&mut self) {
        let axis = &self.axes[X];
        let left_mm = |draw: Draw| (draw.end - axis.true_position()) / axis.counts_per_unit;
        if self.draw.is_some_and(|draw| left_mm(draw) < DRAWN_MM) {
            self.draw = None;
        }
        if self.mains_lost && self.powered {
            let cycle_time_s = self.description.cycle_time_s();
            let moving: f64 = self.axes.iter().map(|axis: &AxisState| axis.power_w(cycle_time_s).max(0.0)).sum();
            self.buffered_j -= (moving + self.description.retract.standby_w) * cycle_time_s;
            if self.buffered_j <= 0.0 {
                self.cut_power();
            }
        }
    }

    /// Axes whose drives an alarm takes the power from at once.
    pub(super) fn note_kill(&mut self, kind: AlarmKind) {
        if let AlarmKind::FollowingError(axis) | AlarmKind::DriveFault(axis) | AlarmKind::EncoderJump(axis) = kind {
            self.kill_due[axis.index()] = true;
        }
    }
}
