//! A machine run offline, as fast as it goes: what the same setpoints would have ground on other drives.

use crate::machine::alarm::Alarm;
use crate::machine::description::AXIS_COUNT;
use crate::machine::setpoint::Setpoint;
use crate::simulation::machine::{Machine, MachineCommand};
use crate::simulation::workpiece::Removal;

/// What a run came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Ticks executed, settling included.
    pub ticks: u64,
    /// What was removed: total volume per width, largest depth in one tick.
    pub removal: Removal,
    /// Largest following error of each axis (mm or rad).
    pub largest_following_error: [f64; AXIS_COUNT],
    /// The first alarm that stopped the run.
    pub stopped_by: Option<Alarm>,
}

/// Runs a machine through ticks, each with its setpoint and commands, and then until its axes are at rest.
///
/// The machine starts where it stands; see [`Machine::place`]. An alarm that needs a reset ends the run.
pub fn run<'a, I>(machine: &mut Machine, ticks: I) -> Run
where
    I: IntoIterator<Item = (Option<Setpoint>, &'a [MachineCommand])>,
{
    let mut run =
        Run { ticks: 0, removal: Removal::default(), largest_following_error: [0.0; AXIS_COUNT], stopped_by: None };
    for (setpoint, commands) in ticks {
        if run.stopped_by.is_some() {
            break;
        }
        one_tick(machine, setpoint.as_ref(), commands, &mut run);
    }
    // Every drive with a position loop comes to rest in far less than this; one without would wait for ever.
    let longest = run.ticks + 60_000;
    while run.stopped_by.is_none() && !machine.is_at_rest() && run.ticks < longest {
        one_tick(machine, None, &[], &mut run);
    }
    run
}

fn one_tick(machine: &mut Machine, setpoint: Option<&Setpoint>, commands: &[MachineCommand], run: &mut Run) {
    let report = machine.step(setpoint, commands, &[]);
    run.ticks += 1;
    run.removal = run.removal.and(report.removal);
    for (largest, axis) in run.largest_following_error.iter_mut().zip(&report.axes) {
        *largest = largest.max(axis.following_error.abs());
    }
    let stops = |alarm: &&Alarm| alarm.kind.entry().severity > crate::machine::alarm::Severity::Warning;
    run.stopped_by = report.raised.iter().find(stops).copied();
}
