// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine in a keyframe: all that its next tick depends on, except its description.
//!
//! The parts declare what of them is state. [`Machine`] states the order of their groups of fields, which recorded keyframes fix.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};

/// Fields, one after the other.
macro_rules! fields {
    ($codec:ident: $($field:ident),+ $(,)?) => { $( $codec.field(stringify!($field), |codec| $field.snapshot(codec))?; )+ };
}

/// Optional equipment, present or absent by description.
macro_rules! equipment {
    ($codec:ident: $($field:ident),+ $(,)?) => {
        $( $codec.field(stringify!($field), |codec| $field.as_mut().map_or(Ok(()), |part| part.snapshot(codec)))?; )+
    };
}

/// Declares the state of a part of the machine: one method for each group of fields that a keyframe holds side by side. Every field
/// stands in one group or, if the description decides it, behind `on`.
macro_rules! snapshot_groups {
    ($part:ident { $($group:ident($walk:ident: $($field:ident),+)),+ $(,)? } on { $($basis:ident),* $(,)? }) => {
        const _: fn(&$part) = |$part { $($($field: _,)+)+ $($basis: _,)* }| {};

        impl $part { $(
            pub(super) fn $group(
                &mut self,
                codec: &mut $crate::math::snapshot::SnapshotCodec<'_>,
            ) -> Result<(), $crate::math::snapshot::SnapshotError> {
                use $crate::math::snapshot::Snapshot;
                let Self { $($field,)+ .. } = self;
                $walk!(codec: $($field),+);
                Ok(())
            }
        )+ }
    };
}

impl Snapshot for AlarmKind {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let mut number = self.entry().number;
        number.snapshot(codec)?;
        if codec.is_reading() {
            *self = AlarmKind::from_number(number).ok_or(SnapshotError::Impossible("no alarm has this number"))?;
        }
        Ok(())
    }
}

impl Machine {
    /// Walks through the state of the size monitor, which stands at the end of a keyframe and only while the monitor watches.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn snapshot_size_monitor(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        codec.field("size_monitor", |codec| self.gauging.snapshot_size_monitor(codec))
    }
}

impl Snapshot for Machine {
    /// A keyframe is read into a machine of the same description. The size monitor is walked separately: see
    /// [`Machine::snapshot_size_monitor`].
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self {
            description,
            lasting,
            tick,
            step_s: _,
            axes,
            supervision,
            axis_watch,
            inputs,
            gauging,
            workholding,
            contact,
            wheel,
            changer,
            power,
            stream,
            retract,
            work_area,
            lag_ticks: _,
            pending_asks: _,
        } = self;
        fields!(codec: tick, lasting);
        if let Some(arm) = changer {
            codec.field("changer", |codec| arm.snapshot(description, lasting, codec))?;
            if codec.is_reading() {
                wheel.prepare_reading(description);
            }
        }
        fields!(codec: axes);
        axis_watch.keep_beyond(codec)?;
        wheel.keep_rotation(codec)?;
        supervision.keep_mode(codec)?;
        stream.keep_followed(codec)?;
        axis_watch.keep_readings(codec)?;
        workholding.snapshot_parts(description, codec)?;
        contact.keep_force(codec)?;
        workholding.snapshot_keyway(codec)?;
        // Keyframes have held it here since before there were changers.
        codec.field("dressed_zero_mm", |codec| lasting.wheel_zero_error_mm.snapshot(codec))?;
        wheel.keep_cut(codec)?;
        equipment!(codec: work_area);
        gauging.keep_gauge(codec)?;
        contact.keep_gap(codec)?;
        contact.keep_modes(codec)?;
        inputs.keep_switches(codec)?;
        gauging.keep_watch(codec)?;
        inputs.keep_references(codec)?;
        retract.keep_motion(codec)?;
        power.keep_dead(codec)?;
        supervision.keep_kill(codec)?;
        power.keep_mains(codec)?;
        wheel.keep_speed(codec)?;
        power.keep_orders(codec)?;
        supervision.keep_alarms(codec)?;
        if wheel.ground().is_some_and(|lobe| lobe >= workholding.lobes().len()) {
            return Err(SnapshotError::Impossible("there is no such lobe"));
        }
        if retract.begins_after(*tick) {
            return Err(SnapshotError::Impossible("a retreat begins in the future"));
        }
        Ok(())
    }
}
