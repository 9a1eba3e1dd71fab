// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! States, modes and commands of PackML (ISA-TR88.00.02), with its numbers: which command leads from where to where.
//!
//! ```text
//!  STOPPED ─RESET─► resetting ─► IDLE ─START─► starting ─► EXECUTE ─► completing ─► COMPLETE ─RESET─► resetting
//!                                                            │ ▲
//!     HOLD, from EXECUTE and SUSPENDED ─► holding ─► HELD ─UNHOLD─► unholding ─┤
//!     SUSPEND ─► suspending ─► SUSPENDED ─UNSUSPEND─► unsuspending ────────────┘
//!  STOP, from all but those on the way to a stop or at one ─► stopping ─► STOPPED
//!  ABORT, from all ─► aborting ─► ABORTED ─CLEAR─► clearing ─► STOPPED
//! ```
//! What is written small is acted on and ends by itself, EXECUTE too. Held is for a reason within the cell, suspended for one outside.
//! HOLD out of SUSPENDED is the extension that OPC 30050 calls optional: who wants to look at a part does not wait for a robot.

use core::fmt;
use thiserror::Error;

/// Number of states, and one for what is none of them.
pub const STATES: usize = 18;

/// A state of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum PackmlState {
    Clearing = 1,
    #[default]
    Stopped = 2,
    Starting = 3,
    Idle = 4,
    Suspended = 5,
    Execute = 6,
    Stopping = 7,
    Aborting = 8,
    Aborted = 9,
    Holding = 10,
    Held = 11,
    Unholding = 12,
    Suspending = 13,
    Unsuspending = 14,
    Resetting = 15,
    Completing = 16,
    Complete = 17,
}

/// Permitted automatic starts of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Mode {
    /// Production: part after part.
    #[default]
    Automatic = 1,
    SetUp = 2,
    /// Nothing but what is asked for axis by axis.
    Manual = 3,
    /// The one part that was put in by hand.
    SemiAutomatic = 4,
}

/// A command to the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Command {
    Reset = 1,
    Start = 2,
    Stop = 3,
    Hold = 4,
    Unhold = 5,
    Suspend = 6,
    Unsuspend = 7,
    Abort = 8,
    Clear = 9,
}

/// Why a command or a mode was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CommandRefused {
    /// The command does not lead anywhere from this state.
    #[error("{command} is not taken in state {state}; {}", AcceptedCommands(*.state))]
    State { command: Command, state: PackmlState },
    /// The mode does not produce.
    #[error("START is not taken in {mode} mode; it is in automatic and semi-automatic mode")]
    Mode { mode: Mode },
    /// The mode changes only at rest.
    #[error("the mode is {mode} and cannot be changed in state {state}; it can in STOPPED, IDLE, COMPLETE and ABORTED")]
    ModeInState {
        /// The mode that stays.
        mode: Mode,
        state: PackmlState,
    },
}

impl PackmlState {
    /// Every state, in the order of the numbers.
    pub const ALL: [PackmlState; STATES - 1] = [
        PackmlState::Clearing,
        PackmlState::Stopped,
        PackmlState::Starting,
        PackmlState::Idle,
        PackmlState::Suspended,
        PackmlState::Execute,
        PackmlState::Stopping,
        PackmlState::Aborting,
        PackmlState::Aborted,
        PackmlState::Holding,
        PackmlState::Held,
        PackmlState::Unholding,
        PackmlState::Suspending,
        PackmlState::Unsuspending,
        PackmlState::Resetting,
        PackmlState::Completing,
        PackmlState::Complete,
    ];

    /// Its name in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            PackmlState::Clearing => "CLEARING",
            PackmlState::Stopped => "STOPPED",
            PackmlState::Starting => "STARTING",
            PackmlState::Idle => "IDLE",
            PackmlState::Suspended => "SUSPENDED",
            PackmlState::Execute => "EXECUTE",
            PackmlState::Stopping => "STOPPING",
            PackmlState::Aborting => "ABORTING",
            PackmlState::Aborted => "ABORTED",
            PackmlState::Holding => "HOLDING",
            PackmlState::Held => "HELD",
            PackmlState::Unholding => "UNHOLDING",
            PackmlState::Suspending => "SUSPENDING",
            PackmlState::Unsuspending => "UNSUSPENDING",
            PackmlState::Resetting => "RESETTING",
            PackmlState::Completing => "COMPLETING",
            PackmlState::Complete => "COMPLETE",
        }
    }

    /// Next state after the work of this state; `None`: it waits for a command.
    #[must_use]
    pub const fn completes(self) -> Option<PackmlState> {
        Some(match self {
            PackmlState::Clearing | PackmlState::Stopping => PackmlState::Stopped,
            PackmlState::Resetting => PackmlState::Idle,
            PackmlState::Starting | PackmlState::Unholding | PackmlState::Unsuspending => PackmlState::Execute,
            PackmlState::Execute => PackmlState::Completing,
            PackmlState::Completing => PackmlState::Complete,
            PackmlState::Holding => PackmlState::Held,
            PackmlState::Suspending => PackmlState::Suspended,
            PackmlState::Aborting => PackmlState::Aborted,
            PackmlState::Stopped
            | PackmlState::Idle
            | PackmlState::Suspended
            | PackmlState::Aborted
            | PackmlState::Held
            | PackmlState::Complete => {
                return None;
            }
        })
    }

    /// Next state after a command; `None`: the command is refused.
    #[must_use]
    pub const fn commanded(self, command: Command) -> Option<PackmlState> {
        Some(match (command, self) {
            (Command::Reset, PackmlState::Stopped | PackmlState::Complete) => PackmlState::Resetting,
            (Command::Start, PackmlState::Idle) => PackmlState::Starting,
            (Command::Hold, PackmlState::Execute | PackmlState::Suspended) => PackmlState::Holding,
            (Command::Unhold, PackmlState::Held) => PackmlState::Unholding,
            (Command::Suspend, PackmlState::Execute) => PackmlState::Suspending,
            (Command::Unsuspend, PackmlState::Suspended) => PackmlState::Unsuspending,
            (Command::Clear, PackmlState::Aborted) => PackmlState::Clearing,
            (Command::Abort, PackmlState::Aborting | PackmlState::Aborted) => return None,
            (Command::Abort, _) => PackmlState::Aborting,
            (
                Command::Stop,
                PackmlState::Stopped
                | PackmlState::Stopping
                | PackmlState::Aborting
                | PackmlState::Aborted
                | PackmlState::Clearing,
            ) => {
                return None;
            }
            (Command::Stop, _) => PackmlState::Stopping,
            _ => return None,
        })
    }

    /// Returns whether the cell is at rest in it and available.
    #[must_use]
    pub const fn is_idle(self) -> bool {
        matches!(self, PackmlState::Stopped | PackmlState::Idle | PackmlState::Complete | PackmlState::Aborted)
    }
}

impl Mode {
    /// Every mode, in the order of the numbers.
    pub const ALL: [Mode; 4] = [Mode::Automatic, Mode::SetUp, Mode::Manual, Mode::SemiAutomatic];

    /// The mode with this number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Mode> {
        Mode::ALL.into_iter().find(|mode| *mode as u8 == number)
    }

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Mode::Automatic => "automatic",
            Mode::SetUp => "set-up",
            Mode::Manual => "manual",
            Mode::SemiAutomatic => "semi-automatic",
        }
    }

    /// Returns whether jobs run in it.
    #[must_use]
    pub const fn produces(self) -> bool {
        matches!(self, Mode::Automatic | Mode::SemiAutomatic)
    }
}

impl Command {
    /// Every command, in the order of the numbers.
    pub const ALL: [Command; 9] = [
        Command::Reset,
        Command::Start,
        Command::Stop,
        Command::Hold,
        Command::Unhold,
        Command::Suspend,
        Command::Unsuspend,
        Command::Abort,
        Command::Clear,
    ];

    /// The command with this number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Command> {
        Command::ALL.into_iter().find(|command| *command as u8 == number)
    }

    /// Its name in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Command::Reset => "RESET",
            Command::Start => "START",
            Command::Stop => "STOP",
            Command::Hold => "HOLD",
            Command::Unhold => "UNHOLD",
            Command::Suspend => "SUSPEND",
            Command::Unsuspend => "UNSUSPEND",
            Command::Abort => "ABORT",
            Command::Clear => "CLEAR",
        }
    }
}

impl fmt::Display for PackmlState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Commands accepted in a state, for the operator.
struct AcceptedCommands(PackmlState);

impl fmt::Display for AcceptedCommands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut taken = Command::ALL.into_iter().filter(|command| self.0.commanded(*command).is_some());
        match taken.next() {
            None => f.write_str("it ends by itself"),
            Some(first) => {
                write!(f, "it takes {first}")?;
                taken.try_for_each(|command| write!(f, ", {command}"))
            }
        }
    }
}

/// The cell: its state, its mode, and how long it was in which state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    state: PackmlState,
    mode: Mode,
    /// When it began, when the state was entered, and how far times are counted (s).
    began_s: f64,
    since_s: f64,
    counted_s: f64,
    accumulated_s: [f64; STATES],
}

impl Unit {
    /// A cell at rest, from this time on (s, of whatever clock).
    #[must_use]
    pub fn new(now_s: f64) -> Self {
        let (state, mode) = (PackmlState::default(), Mode::default());
        Self { state, mode, began_s: now_s, since_s: now_s, counted_s: now_s, accumulated_s: [0.0; STATES] }
    }

    #[must_use]
    pub const fn state(&self) -> PackmlState {
        self.state
    }

    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Since when it has been in its state (s).
    #[must_use]
    pub fn time_in_state_s(&self, now_s: f64) -> f64 {
        (now_s - self.since_s).max(0.0)
    }

    /// Accumulated time in each state, by number (s); index 0: since the start.
    #[must_use]
    pub fn accumulated_s(&self, now_s: f64) -> [f64; STATES] {
        let mut times_s = self.accumulated_s;
        times_s[self.state as usize] += (now_s - self.counted_s).max(0.0);
        times_s[0] = (now_s - self.began_s).max(0.0);
        times_s
    }

    fn enter(&mut self, state: PackmlState, now_s: f64) {
        self.accumulated_s = self.accumulated_s(now_s);
        (self.state, self.since_s, self.counted_s) = (state, now_s, now_s);
    }

    /// Takes a command.
    ///
    /// # Errors
    /// It leads nowhere from here, or not in this mode; nothing has changed then.
    pub fn command(&mut self, command: Command, now_s: f64) -> Result<PackmlState, CommandRefused> {
        self.would(command)?;
        if let Some(state) = self.state.commanded(command) {
            self.enter(state, now_s);
        }
        Ok(self.state)
    }

    /// Checks whether a command would be accepted.
    ///
    /// # Errors
    /// As [`Unit::command`].
    pub fn would(&self, command: Command) -> Result<(), CommandRefused> {
        if self.state.commanded(command).is_none() {
            return Err(CommandRefused::State { command, state: self.state });
        }
        match command == Command::Start && !self.mode.produces() {
            true => Err(CommandRefused::Mode { mode: self.mode }),
            false => Ok(()),
        }
    }

    /// Ends the work of this state; returns false if the state has none.
    pub fn complete(&mut self, now_s: f64) -> bool {
        match self.state.completes() {
            Some(next) => {
                self.enter(next, now_s);
                true
            }
            None => false,
        }
    }

    /// Selects a mode.
    ///
    /// # Errors
    /// The cell is not at rest; the mode stays.
    pub fn select(&mut self, mode: Mode) -> Result<(), CommandRefused> {
        if !self.state.is_idle() {
            return Err(CommandRefused::ModeInState { mode: self.mode, state: self.state });
        }
        self.mode = mode;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
