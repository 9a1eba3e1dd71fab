//! The machine in a keyframe: all that its next tick depends on, except its description.
//!
//! The parts declare what of them is state. [`Machine`] states the order of their groups of fields, which recorded keyframes fix.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::math::snapshot::{Kept, Tape, TapeError};

/// Fields, one after the other.
macro_rules! fields {
    ($tape:ident: $($field:ident),+ $(,)?) => { $( $tape.field(stringify!($field), |tape| $field.keep(tape))?; )+ };
}

/// Optional equipment, present or absent by description.
macro_rules! equipment {
    ($tape:ident: $($field:ident),+ $(,)?) => {
        $( $tape.field(stringify!($field), |tape| $field.as_mut().map_or(Ok(()), |part| part.keep(tape)))?; )+
    };
}

/// Declares the state of a part of the machine: one method for each group of fields that a keyframe holds side by side. Every field
/// stands in one group or, if the description decides it, behind `on`.
macro_rules! kept_groups {
    ($part:ident { $($group:ident($walk:ident: $($field:ident),+)),+ $(,)? } on { $($basis:ident),* $(,)? }) => {
        const _: fn(&$part) = |$part { $($($field: _,)+)+ $($basis: _,)* }| {};

        impl $part { $(
            pub(super) fn $group(
                &mut self,
                tape: &mut $crate::math::snapshot::Tape<'_>,
            ) -> Result<(), $crate::math::snapshot::TapeError> {
                use $crate::math::snapshot::Kept;
                let Self { $($field,)+ .. } = self;
                $walk!(tape: $($field),+);
                Ok(())
            }
        )+ }
    };
}

impl Kept for AlarmKind {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let mut number = self.entry().number;
        number.keep(tape)?;
        if tape.is_reading() {
            *self = AlarmKind::from_number(number).ok_or(TapeError::Impossible("no alarm has this number"))?;
        }
        Ok(())
    }
}

impl Kept for Machine {
    /// A keyframe is read into a machine of the same description.
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
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
            power,
            stream,
            retract,
            work_area,
        } = self;
        fields!(tape: tick, lasting, axes);
        axis_watch.keep_beyond(tape)?;
        wheel.keep_rotation(tape)?;
        supervision.keep_mode(tape)?;
        stream.keep_followed(tape)?;
        axis_watch.keep_readings(tape)?;
        workholding.keep_parts(description, tape)?;
        contact.keep_force(tape)?;
        workholding.keep_key_way(tape)?;
        wheel.keep_cut(tape)?;
        equipment!(tape: work_area);
        gauging.keep_gauge(tape)?;
        contact.keep_gap(tape)?;
        inputs.keep_switches(tape)?;
        gauging.keep_watch(tape)?;
        inputs.keep_references(tape)?;
        retract.keep_motion(tape)?;
        power.keep_dead(tape)?;
        supervision.keep_kill(tape)?;
        power.keep_mains(tape)?;
        wheel.keep_speed(tape)?;
        power.keep_orders(tape)?;
        supervision.keep_alarms(tape)?;
        if wheel.ground().is_some_and(|lobe| lobe >= workholding.lobes().len()) {
            return Err(TapeError::Impossible("there is no such lobe"));
        }
        if retract.begins_after(*tick) {
            return Err(TapeError::Impossible("a retreat begins in the future"));
        }
        Ok(())
    }
}
