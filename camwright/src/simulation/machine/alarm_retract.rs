// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Retract of the wheel after an alarm.
//!
//! ```text
//!  C and X work      the stream runs out on the path, X leaves it meanwhile       X = path + law of the retreat
//!  C does not        C brakes, X goes outwards by itself, faster than any part can follow
//!  X does not        C is stopped, a brake stops X, then a weight or spring draws it back
//! ```
//! The path is never cut short: a wheel that stood still while C turns on would go through the flank that comes. An X that
//! is on its way outwards of the path beside it never lies deeper than the path itself.

use super::workholding::PartClearance;
use crate::machine::description::{Axis, MachineDescription, MotionLimits};
use crate::math::hermite::Sample;
use crate::motion::point_to_point::{JerkLaw, solve, stop};
use crate::simulation::axis::{AxisSetpoint, AxisState, Span};
use crate::simulation::plausibility::DRIVE_HEADROOM;

const X: usize = Axis::X as usize;

/// Share of the limits of X that a retreat beside the path uses: what drives can do beyond them, which the path leaves.
const BESIDE_SHARE: f64 = DRIVE_HEADROOM - 1.0;

/// Distance from its end at which a wheelhead that is drawn back is braked for good (mm).
const DRAWN_MM: f64 = 0.05;

/// X on its way off the part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Retreat {
    /// Way (mm over s) since `since`.
    law: JerkLaw,
    /// The last tick before it.
    since: u64,
    /// Begin and end of a retreat that follows no path (counts, true).
    own: Option<(f64, f64)>,
}

crate::snapshot!(Retreat { law, since, own } on {});

/// A wheelhead that a weight or spring draws back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Draw {
    pull: f64,
    fastest: f64,
    end: f64,
}

crate::snapshot!(Draw { pull, fastest, end } on {});

/// The wheel on its way off the part: by its drive, or drawn back without power.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Retract {
    retreat: Option<Retreat>,
    draw: Option<Draw>,
}

snapshot_groups!(Retract { keep_motion(fields: retreat, draw) } on {});

impl Retract {
    pub(super) fn is_active(&self) -> bool {
        self.retreat.is_some()
    }

    /// The retreat begins after the end of this tick.
    pub(super) fn begins_after(&self, tick: u64) -> bool {
        self.retreat.is_some_and(|retreat| retreat.since > tick)
    }

    /// Sends X off a part that it is too near to, beside the path or by itself. `since` is the last tick before.
    pub(super) fn begin(
        &mut self,
        near: PartClearance,
        beside_path: bool,
        x_axis: &AxisState,
        machine: &MachineDescription,
        since: u64,
    ) {
        let (target, per_mm) = (*x_axis.target(), x_axis.counts_per_unit);
        let PartClearance { off_mm, nearest_mm } = near;
        let description = &machine.axes[X];
        let soft_max_mm = description.soft_limits.map_or(f64::INFINITY, |(_, max)| max);
        let whole = |mm: f64| libm::round(mm * per_mm) / per_mm;
        let limits = description.limits;
        let (law, own) = if beside_path {
            // The path may still go down to where the lobe is nearest.
            let way_mm = whole((off_mm - nearest_mm).min(soft_max_mm - (off_mm - nearest_mm) - nearest_mm).max(0.0));
            (solve(way_mm, 0.0, 0.0, 0.0, &limits.with_share(BESIDE_SHARE)), None)
        } else {
            let x_mm = target.position / per_mm;
            let (v0, a0) = (target.velocity / per_mm, target.acceleration / per_mm);
            let limits = MotionLimits {
                velocity: limits.velocity.max(v0.abs()),
                acceleration: limits.acceleration.max(a0.abs()),
                ..limits
            };
            let braking = stop(0.0, v0, a0, &limits);
            let min_mm = braking.sample(braking.duration()).value;
            let way_mm = (off_mm - x_mm).min(soft_max_mm - x_mm).max(min_mm);
            let end = libm::round(target.position + way_mm * per_mm);
            let way_mm = (end - target.position) / per_mm;
            (solve(way_mm, v0, a0, 0.0, &limits), Some((target.position, end)))
        };
        self.retreat = Some(Retreat { law, since, own });
    }

    /// Motion of the retreat at the end of a tick, and whether it is over.
    pub(super) fn sample(&self, tick: u64, cycle_time_s: f64) -> (Sample, bool) {
        let Some(retreat) = &self.retreat else { return (Sample::default(), true) };
        let at_s = (tick - retreat.since) as f64 * cycle_time_s;
        (retreat.law.sample(at_s), at_s >= retreat.law.duration())
    }

    /// Ends the retreat. Returns whether there was one.
    pub(super) fn end(&mut self) -> bool {
        self.retreat.take().is_some()
    }

    /// Ends a retreat beside a path that is not followed any more.
    pub(super) fn leave_path(&mut self) {
        self.retreat = self.retreat.filter(|retreat| retreat.own.is_some());
    }

    /// Target of X in a retreat that follows no path.
    pub(super) fn target(&self, tick: u64, cycle_time_s: f64, per_mm: f64) -> Option<AxisSetpoint> {
        let (from, end) = self.retreat?.own?;
        let (sample, is_over) = self.sample(tick, cycle_time_s);
        Some(if is_over {
            AxisSetpoint::resting(end)
        } else {
            AxisSetpoint {
                position: from + sample.value * per_mm,
                velocity: sample.first * per_mm,
                acceleration: sample.second * per_mm,
            }
        })
    }

    /// X loses its power: ends the retreat, and draws back a wheelhead that is too near to the part.
    pub(super) fn release(&mut self, near: Option<PartClearance>, x_axis: &AxisState, machine: &MachineDescription) {
        let per_mm = x_axis.counts_per_unit;
        let pull = machine.retract.drawback_mm_s2;
        let description = &machine.axes[X];
        // It stops within what its own speed needs; the soft limit is where the weight rests.
        let max_mm = description.soft_limits.map_or(f64::INFINITY, |(_, max)| max);
        self.retreat = None;
        self.draw = near.filter(|_| pull > 0.0).map(|PartClearance { off_mm, .. }| Draw {
            pull: pull * per_mm,
            fastest: description.limits.velocity * per_mm,
            end: libm::round(off_mm.min(max_mm) * per_mm),
        });
    }

    /// One servo step of an X without power.
    pub(super) fn coast(&self, x_axis: &mut AxisState, (index, count): (u32, u32), step_s: f64) -> Span {
        match self.draw {
            Some(draw) => x_axis.draw(draw.pull, draw.fastest, draw.end),
            None => x_axis.coast(index, count, step_s),
        }
    }

    /// The brake holds a wheelhead that has been drawn far enough.
    pub(super) fn end_draw(&mut self, x_axis: &AxisState) {
        let left_mm = |draw: Draw| (draw.end - x_axis.true_position()) / x_axis.counts_per_unit;
        if self.draw.is_some_and(|draw| left_mm(draw) < DRAWN_MM) {
            self.draw = None;
        }
    }

    pub(super) fn stop_drawing(&mut self) {
        self.draw = None;
    }
}
