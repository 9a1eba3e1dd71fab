// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stream of setpoints as the machine follows it.

use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::Setpoint;
use crate::simulation::axis::AxisState;
use crate::simulation::plausibility::{Plausibility, PlausibilityFault};

/// The last setpoint of the stream and the check of the next one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SetpointStream {
    plausibility: Plausibility,
    /// The setpoint of the stream that was followed last, without what an alarm adds to it.
    followed: Setpoint,
}

snapshot_groups!(SetpointStream { keep_followed(fields: followed) } on { plausibility });

impl SetpointStream {
    /// A stream that continues from a setpoint.
    pub(super) fn new(description: &MachineDescription, from: Setpoint) -> Self {
        Self { plausibility: Plausibility::new(description), followed: from }
    }

    pub(super) fn followed(&self) -> &Setpoint {
        &self.followed
    }

    pub(super) fn follow(&mut self, setpoint: Setpoint) {
        self.followed = setpoint;
    }

    /// The stream rests where it is.
    pub(super) fn rest(&mut self) {
        self.followed = Setpoint { counts: self.followed.counts, ..Setpoint::default() };
    }

    /// The reading `counts` of this axis is 0 from now on.
    pub(super) fn set_home(&mut self, axis: Axis, counts: i64) {
        let followed = &mut self.followed.counts[axis.index()];
        *followed = followed.saturating_sub(counts);
    }

    /// The stream has not come to rest.
    pub(super) fn moves(&self) -> bool {
        self.followed.velocity.iter().any(|velocity| *velocity != 0.0)
    }

    /// A setpoint moves away from the last one.
    pub(super) fn moves_to(&self, setpoint: &Setpoint) -> bool {
        setpoint.counts != self.followed.counts || setpoint.velocity.iter().any(|speed| *speed != 0.0)
    }

    /// Returns why a setpoint cannot be followed: the alarm with its value and bound.
    pub(super) fn refusal(
        &self,
        setpoint: &Setpoint,
        axes: &[AxisState; AXIS_COUNT],
        description: &MachineDescription,
    ) -> Option<(AlarmKind, f64, f64)> {
        let last = self.followed;
        if let Some(misfit) = self.plausibility.misfit(&last, setpoint) {
            let kind = match misfit.what {
                PlausibilityFault::Velocity => AlarmKind::SetpointVelocity(misfit.axis),
                PlausibilityFault::Acceleration => AlarmKind::SetpointAcceleration(misfit.axis),
                PlausibilityFault::Jump => AlarmKind::SetpointJump(misfit.axis),
            };
            return Some((kind, misfit.value, misfit.bound));
        }
        for axis in Axis::ALL {
            let i = axis.index();
            let description = &description.axes[i];
            let Some((min, max)) = description.soft_limits.filter(|_| axes[i].homed) else { continue };
            let (min_counts, max_counts) = (description.scale.counts(min), description.scale.counts(max));
            let (now, next) = (last.counts[i], setpoint.counts[i]);
            // An axis that stands outside may come back, never go farther out.
            let (below, above) = (next < min_counts && next < now, next > max_counts && next > now);
            if below || above {
                let bound = if below { min } else { max };
                return Some((AlarmKind::SoftLimit(axis), description.scale.position(next), bound));
            }
        }
        None
    }
}
