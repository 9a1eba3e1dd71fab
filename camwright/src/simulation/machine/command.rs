// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Commands of the machine in addition to setpoints, and reasons for refusing a reset.

use crate::machine::description::Axis;
use crate::machine::setpoint::Input;
use crate::simulation::work_area::AccessRefusal;
use thiserror::Error;

/// Orders that take effect at the tick they are given to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MachineCommand {
    /// The reading `counts` of this axis is its zero from now on; setpoints from this tick on are in the new reading.
    SetHome {
        axis: Axis,
        /// The reading that becomes 0 (counts).
        counts: i64,
    },
    /// Bring the wheel to its surface speed.
    WheelStart,
    /// Let the wheel come to rest.
    #[default]
    WheelStop,
    /// Query of an input: if it is closed, an edge reports it in this tick.
    Ask { input: Input },
    /// The wheel must have this radius, within [`WHEEL_TOLERANCE_MM`](crate::machine::WHEEL_TOLERANCE_MM); else an alarm.
    ExpectWheel {
        /// The radius (nm).
        radius_nm: i64,
    },
    /// The zero of this axis is not known any more. If its home switch is closed, an edge says so in this tick.
    LoseHome { axis: Axis },
    /// The wheel, which does not turn, may press on the part with so much (N), until it is started; 0: not any more.
    Push {
        /// The most (N).
        max_n: i64,
    },
    /// The force monitor watches for a normal force that differs by so much over a turn of C at most (N); 0: not any more.
    WatchForce {
        /// The most (N).
        max_n: i64,
    },
    /// The size monitor watches for this diameter on the gauge; 0: no longer.
    WatchSize {
        /// Mean diameter over a turn (nm).
        diameter_nm: i64,
    },
    /// An alarm found by the interpolator, by its number; the interpolator publishes its text.
    Raise { number: u16 },
    /// The changer mounts this wheel; refused with an alarm where the wheel turns, X is not clear, or there is no such wheel.
    ChangeWheel {
        /// Position of the wheel in the changer.
        wheel: u32,
    },
    /// The wheel is dressed to this radius; refused with an alarm where it does not stand at the dresser, or would not
    /// touch it.
    Dress {
        /// The radius (nm).
        radius_nm: i64,
    },
}

crate::snapshot_cases!(MachineCommand {
    0 SetHome { axis, counts },
    1 WheelStart,
    2 WheelStop,
    3 Ask { input },
    4 ExpectWheel { radius_nm },
    5 LoseHome { axis },
    6 Push { max_n },
    7 WatchForce { max_n },
    8 Raise { number },
    9 Dress { radius_nm },
    10 WatchSize { diameter_nm },
    11 ChangeWheel { wheel },
});

/// Why a reset was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ResetRefused {
    /// The emergency stop is still pressed.
    #[error("the emergency stop is pressed; release it (`camwright estop --release`)")]
    EStopPressed,
    /// The mains are not back.
    #[error("mains power lost; restore it (`camwright fault power_loss --clear`)")]
    PowerLost,
    /// A drive still reports its fault.
    #[error("the drive of {axis} still reports a fault; clear it (`camwright fault drive_fault {axis} --clear`)", axis = .0.joint())]
    DriveFault(Axis),
    /// A person is in the work area.
    #[error(
        "a person or the loader is in the work area; clear it (an injected person: `camwright fault person --clear`)"
    )]
    Entered,
    /// Door or chuck is not closed, and the wheel runs down: the alarm would come again at once.
    #[error("the wheel still turns, and {}", .0.text())]
    WheelTurns(AccessRefusal),
    /// An axis is not at rest yet.
    #[error("{} is not at rest yet", .0.joint())]
    Moving(Axis),
}
