// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Work by hand: one axis that is jogged, and the wheel.
//!
//! ```text
//! jog    by a distance, or towards the soft limit until released (a cancel); c_axis as long as that lasts
//!        an axis whose zero is not known: at its search speed at most, and until its limit switch stops it
//! wheel  the order · as long as it takes to come to its speed, or to rest
//! ```

use super::setup::{SetupError, counts, push_wheel, within};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::motion::plan::{AxisTarget, Plan};
use crate::motion::point_to_point::MoveLaw;
use alloc::string::String;

/// Distance of an unlimited jog (mm or rad): `c_axis` turns for hours.
const WITHOUT_END: f64 = 1e6;

/// Request of a jog.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JogRequest {
    pub axis: Axis,
    /// Speed (mm/s or rad/s); its sign is the direction where there is no distance.
    pub velocity: f64,
    /// Signed distance (mm or rad); `None`: until the button is released.
    pub distance: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jog {
    pub(super) target: AxisTarget,
    pub(super) knows_zero: bool,
}

impl Jog {
    /// A jog from where the axes rest (counts).
    ///
    /// # Errors
    /// A speed that the axis lacks, or not while its zero is unknown; a way of no length or beyond a soft limit.
    pub fn new(
        request: &JogRequest,
        from: [i64; AXIS_COUNT],
        knows_zero: bool,
        machine: &MachineDescription,
    ) -> Result<Self, SetupError> {
        let axis = request.axis;
        let (description, at) = (machine.axis(axis), from[axis.index()]);
        let (speed, max) = (request.velocity.abs(), description.limits.velocity);
        // Not a number is neither.
        if !(speed > 0.0 && speed <= max) {
            return Err(SetupError::Speed { axis, speed, max });
        }
        let slow = description.search_velocity;
        if !knows_zero && speed > slow {
            return Err(SetupError::Lost { axis, speed, max: slow });
        }
        let scale = description.scale;
        let bounds = description.soft_limits.filter(|_| knows_zero);
        let target_counts = match (request.distance, bounds) {
            (Some(distance), _) => at + counts(axis, scale, distance, "the distance")?,
            (None, Some((low, _))) if request.velocity < 0.0 => scale.counts(low),
            (None, Some((_, high))) => scale.counts(high),
            (None, None) => at + scale.counts(WITHOUT_END.copysign(request.velocity)),
        };
        if bounds.is_some() {
            within(machine, axis, target_counts, "the target")?;
        }
        // From beyond a soft limit the way to it would be against the direction that is wanted.
        let is_backwards = request.distance.is_none() && (target_counts - at).signum() != sign(request.velocity);
        if target_counts == at || is_backwards {
            return Err(SetupError::NoWay(axis));
        }
        let target = AxisTarget { axis, target_counts, limits: description.limits.at_most(speed) };
        MoveLaw::new(from, &[target], machine).map_err(|error| SetupError::Move { axis, error })?;
        Ok(Self { target, knows_zero })
    }
}

fn sign(velocity: f64) -> i64 {
    if velocity < 0.0 { -1 } else { 1 }
}

/// The wheel brought to its speed, or to rest, as a plan.
pub(super) fn wheel_plan(turns: bool, machine: &MachineDescription) -> Plan {
    let mut plan = Plan { job: String::from("wheel"), ..Plan::default() };
    push_wheel(&mut plan, turns, machine);
    plan
}
