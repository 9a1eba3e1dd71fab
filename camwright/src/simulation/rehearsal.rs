//! A rehearsal: interpolator and machine in one loop, tick by tick, with nothing in between. Since setpoints depend on
//! ticks alone, it gives the samples that the same motion gives over any network; and with other drives it tells what the
//! same setpoints would have ground.

use crate::interpolator::{Event, Interpolator, OrderKind, Outcome, Prepared, StartError, TickInputs};
use crate::machine::alarm::{Alarm, Severity};
use crate::machine::setpoint::Setpoint;
use crate::simulation::tick_report::TickReport;
use crate::simulation::{Machine, MachineCommand};
use alloc::boxed::Box;
use alloc::vec::Vec;
use thiserror::Error;

/// Ticks after the last setpoint in which every drive with a position loop has come to rest.
const SETTLING_TICKS: u64 = 60_000;

/// How a rehearsal ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rehearsed {
    /// How the motion ended.
    pub outcome: Outcome,
    /// First tick of the motion.
    pub first_tick: u64,
    /// Tick of its last setpoint.
    pub last_tick: u64,
}

/// Why a rehearsal did not come to its end.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RehearsalError {
    /// The motion does not start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The machine raised an alarm.
    #[error("alarm {}: {}", .0.kind.entry().number, .0)]
    Alarm(Alarm),
    /// The axes do not come to rest.
    #[error("the axes are not at rest {SETTLING_TICKS} ticks after the last setpoint")]
    NotSettled,
}

/// Executes a motion on a machine that rests, and tells every tick from the motion's first to its last. An interpolator of
/// the same machine may be used again and again, like the machine.
///
/// # Errors
/// See [`RehearsalError`].
pub fn rehearse(
    motion: Box<Prepared>,
    interpolator: &mut Interpolator,
    machine: &mut Machine,
    mut tell: impl FnMut(&Setpoint, &TickReport),
) -> Result<Rehearsed, RehearsalError> {
    let begins = motion.begins_job();
    interpolator.resync(machine.setpoint().counts);
    interpolator.start(motion).map_err(|(error, _)| error)?;
    let first_tick = machine.tick() + 1;
    if begins {
        machine.begin_job();
    }
    let mut orders: Vec<(u64, MachineCommand)> = Vec::new();
    let mut tick = first_tick;
    let outcome = loop {
        let out = interpolator.step(&TickInputs { tick, requests: &[] });
        orders.extend(out.orders.iter().map(|order| (order.tick, order.kind.into())));
        let due: Vec<MachineCommand> = orders.iter().filter(|(at, _)| *at == tick).map(|(_, order)| *order).collect();
        orders.retain(|(at, _)| *at > tick);
        let report = machine.step(Some(&out.setpoint), &due, &[]);
        if let Some(alarm) = stopping_alarm(&report) {
            return Err(RehearsalError::Alarm(alarm));
        }
        for latch in report.latches.iter() {
            interpolator.feedback(latch);
        }
        tell(&out.setpoint, &report);
        let finished = out.events.iter().find_map(|event| match event {
            Event::Finished(outcome) => Some(*outcome),
            Event::Segment(_) | Event::LeftOut { .. } | Event::Alarm(_) | Event::Probed(_) => None,
        });
        if let Some(outcome) = finished {
            break outcome;
        }
        tick += 1;
    };
    // The finished motion is not needed any more.
    drop(interpolator.take_finished());
    for _ in 0..SETTLING_TICKS {
        if machine.is_at_rest() {
            return Ok(Rehearsed { outcome, first_tick, last_tick: tick });
        }
        let report = machine.step(None, &[], &[]);
        if let Some(alarm) = stopping_alarm(&report) {
            return Err(RehearsalError::Alarm(alarm));
        }
    }
    Err(RehearsalError::NotSettled)
}

fn stopping_alarm(report: &TickReport) -> Option<Alarm> {
    report.raised.iter().find(|alarm| alarm.kind.entry().severity > Severity::Warning).copied()
}

impl From<OrderKind> for MachineCommand {
    fn from(order: OrderKind) -> Self {
        match order {
            OrderKind::SetHome { axis, counts } => MachineCommand::SetHome { axis, counts },
            OrderKind::LoseHome { axis } => MachineCommand::LoseHome { axis },
            OrderKind::Ask { input } => MachineCommand::Ask { input },
            OrderKind::WheelStart => MachineCommand::WheelStart,
            OrderKind::WheelStop => MachineCommand::WheelStop,
            OrderKind::ExpectWheel { radius_nm } => MachineCommand::ExpectWheel { radius_nm },
            OrderKind::Dress { radius_nm } => MachineCommand::Dress { radius_nm },
            OrderKind::Push { most_n } => MachineCommand::Push { most_n },
            OrderKind::WatchForce { most_n } => MachineCommand::WatchForce { most_n },
        }
    }
}
