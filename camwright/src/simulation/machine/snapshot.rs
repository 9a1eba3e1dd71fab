//! The machine in a keyframe: all that its next tick depends on, but for its description.

use super::turning::Clamped;
use super::{Machine, Mode};
use crate::machine::alarm::AlarmKind;
use crate::math::snapshot::{Kept, Tape, TapeError};
use crate::simulation::turned_part::TurnedPart;
use crate::simulation::workpiece::CutRecord;

crate::kept_cases!(Mode { 0 Following, 1 Draining, 2 OwnStop, 3 Halted });

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

/// Fields, one after the other.
macro_rules! fields {
    ($tape:ident: $($field:ident),+ $(,)?) => { $( $tape.field(stringify!($field), |tape| $field.keep(tape))?; )+ };
}

/// What a machine has or has not got, as it is described.
macro_rules! equipment {
    ($tape:ident: $($field:ident),+ $(,)?) => {
        $( $tape.field(stringify!($field), |tape| $field.as_mut().map_or(Ok(()), |part| part.keep(tape)))?; )+
    };
}

impl Kept for Machine {
    /// What is read is taken up by a machine of the same description.
    #[rustfmt::skip]
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let Self {
            description,
            // What the description decides.
            plausibility: _, step_s: _, overtravel: _, warming: _,
            lasting, tick, axes, origin, stations, references, asked, beyond, wheel, wheel_phase_rad, part, turned, work_area,
            deflection, force_n, push_n, force_monitor, gauge, gap, key_way_rad, dressed_zero_mm, since_cut, ground, mode, followed,
            retreat, draw, dead, kill_due, mains_lost, buffered_j, shared, switch_watch, gauge_watch, readings, overspeed, wheel_late,
            drives_ordered, powered, power_off_due, estop, drive_faults, alarms, raised,
        } = self;
        fields!(tape: tick, lasting, axes, beyond, wheel, wheel_phase_rad, mode, followed, readings);
        tape.field("part", |tape| part.keep(tape, description.stations.len(), || CutRecord::of(description)))?;
        tape.field("turned", |tape| keep_clamped(turned, description.insert.is_some(), tape))?;
        fields!(tape: deflection, force_n, push_n, force_monitor, key_way_rad, dressed_zero_mm, since_cut, ground);
        equipment!(tape: work_area, gauge, gap);
        let (stations, switch_watch) = (stations.as_mut_slice(), switch_watch.as_mut_slice());
        fields!(tape: origin, stations, asked, shared, switch_watch, gauge_watch);
        for (index, references) in references.iter_mut().enumerate() {
            tape.item(index, |tape| { equipment!(tape: references); Ok(()) })?;
        }
        fields!(tape: retreat, draw, dead, kill_due, mains_lost, buffered_j, overspeed, wheel_late);
        fields!(tape: drives_ordered, powered, power_off_due, estop, drive_faults, alarms, raised);
        if ground.is_some_and(|lobe| lobe >= part.lobes().len()) {
            return Err(TapeError::Impossible("there is no such lobe"));
        }
        if retreat.is_some_and(|retreat| retreat.begins_after(*tick)) {
            return Err(TapeError::Impossible("a retreat begins in the future"));
        }
        Ok(())
    }
}

/// A part in a chuck: one that is read is made anew.
fn keep_clamped(clamped: &mut Option<Clamped>, is_lathe: bool, tape: &mut Tape<'_>) -> Result<(), TapeError> {
    let mut is_there = clamped.is_some();
    is_there.keep(tape)?;
    if is_there && !is_lathe {
        return Err(TapeError::Impossible("a machine that grinds turns nothing"));
    }
    if tape.is_reading() {
        *clamped = None;
        if is_there {
            let mut zero_mm = 0.0;
            tape.field("zero_mm", |tape| zero_mm.keep(tape))?;
            *clamped = Some(Clamped { part: tape.field("part", TurnedPart::read)?, zero_mm });
        }
        return Ok(());
    }
    let Some(Clamped { part, zero_mm }) = clamped else { return Ok(()) };
    fields!(tape: zero_mm, part);
    Ok(())
}
