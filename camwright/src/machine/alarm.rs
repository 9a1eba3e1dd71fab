//! The numbered alarms of the cell: what happened, how bad it is, what to do about it.
//!
//! Alarms are data: they travel to the operator and into the recording. They are latched; a reset clears them once
//! their cause is gone, and never restarts motion.

use crate::machine::description::Axis;
use crate::math::units::deg_from_rad;
use core::fmt;

/// What an alarm does to the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Severity {
    /// Told; motion goes on.
    Warning = 1,
    /// The axes are brought to rest within their limits, the wheel is taken off the part; needs a reset.
    Stop = 2,
    /// The same, and then the drives lose their power; a drive that cannot bring its axis to rest loses it at once.
    PowerOff = 3,
}

/// The kinds of alarm, those of the machine and those that a node raises itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum AlarmKind {
    /// Emergency stop pressed (a simulation of one; not a safety function).
    #[default]
    EStop,
    /// The mains are lost; the axes come to rest and the wheel leaves the part from the buffered energy.
    PowerLoss,
    /// An axis ran onto its hard limit switch. Value and bound: position (mm).
    Overtravel(Axis),
    /// A setpoint beyond a soft limit. Value and bound: position (mm or rad).
    SoftLimit(Axis),
    /// Setpoint minus actual is too large. Value and bound: following error (mm or rad).
    FollowingError(Axis),
    /// The drive of an axis reports a fault.
    DriveFault(Axis),
    /// The reading of an encoder jumped farther than the axis can. Value and bound: jump (mm or rad).
    EncoderJump(Axis),
    /// A setpoint faster than the axis. Value and bound: speed (mm/s or rad/s).
    SetpointVelocity(Axis),
    /// Setpoints that change speed faster than the axis. Value and bound: acceleration (mm/s² or rad/s²).
    SetpointAcceleration(Axis),
    /// Two setpoints whose distance does not fit their speeds. Value and bound: misfit (mm or rad).
    SetpointJump(Axis),
    /// Setpoints did not arrive in time.
    Underrun,
    /// A command arrived after the tick it was meant for. Value: ticks late.
    LateCommand,
    /// Commands are missing. Value: number received, bound: number expected.
    CommandGap,
    /// A second sender of setpoints was refused.
    SecondWriter,
    /// A chunk of setpoints was refused. Value: its first tick, [`NO_TICK`] where what came is no chunk.
    ChunkRefused,
    /// Setpoints between two chunks are missing. Value: first tick received, bound: first tick expected.
    SetpointsLost,
    /// A request, command or setpoint was refused: its sender has no command of the cell, or a field is out of bounds.
    NoAuthority,
    /// A search for the origin, a home switch or an index ended without its edge.
    HomingFailed,
    /// A station was searched for and its switch did not close.
    StationNotFound,
    /// The origin detector did not signal where it must, or signalled where it must not. Value: angle off its mark (rad).
    OriginDetector,
    /// A limit switch does not show what the table's position says. Value: number of its station, from 1.
    LimitSwitch,
    /// A limit switch closes and opens again and again. Value: number of its station, from 1.
    SwitchBounces,
    /// The wheel lost its speed while it was cutting.
    WheelStoppedInCut,
    /// The wheel touched the part without running. Value: depth (mm).
    WheelContact,
    /// The wheel is smaller than its smallest usable radius. Value and bound: radius (mm).
    WheelWorn,
    /// The wheel would turn faster than it may and was not started. Value and bound: speed (rpm).
    WheelTooFast,
    /// The plan was made for another wheel. Value: radius mounted, bound: radius wanted (mm).
    OtherWheel,
    /// A dress was not made. Value: radius wanted, bound: radius of the worn wheel (mm).
    NotDressed,
    /// The wheel lost its speed out of the cut, or does not reach it.
    WheelStopped,
    /// The wheel turns faster than ordered. Value and bound: speed (rpm).
    WheelOverspeed,
    /// A motion asks for a position of an axis whose zero is not known.
    NotHomed(Axis),
    /// A cut begins where the axis is not. Value: where it is, bound: where it should be (mm or rad).
    NotAtStart(Axis),
    /// A segment of a plan cannot be executed. Value: its index.
    BadSegment,
    /// The gauge gives no number.
    GaugeInvalid,
    /// The gauge gives the same reading again and again while it must change. Value: how often.
    GaugeStuck,
    /// The door was opened, or is open, while axes or wheel move.
    DoorOpened,
    /// Somebody entered the work area, or is in there, while axes or wheel move.
    WorkAreaEntered,
    /// The chuck let go, or is open, while axes or wheel move.
    ChuckOpened,
    /// The door does not come to its end.
    DoorStuck,
    /// The chuck does not come to its end.
    ChuckStuck,
    /// The loader went silent while it was in the work area.
    LoaderLost,
    /// The sender of setpoints fell silent while the machine waited for it. Value: longest silence allowed (s).
    SenderLost,
    /// The machine fell silent, or was started again, while a motion was executed. Value: longest silence allowed (s).
    MachineLost,
    /// The machine was deactivated, or its node ended, while a motion was executed.
    MachineDeactivated,
    /// The recorder fell silent or fell behind while it recorded. Value: longest silence allowed (s).
    RecordingLost,
    /// The job planner fell silent while its plan was executed. Value: longest silence allowed (s).
    PlannerLost,
    /// The machine could not send its feedback. Value: how long it tried (s).
    FeedbackBlocked,
}

/// One row of the alarm table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlarmEntry {
    /// Number; for alarms of an axis the last digit is 1 for C, 2 for X, 3 for Z.
    pub number: u16,
    pub name: &'static str,
    /// What it does to the motion.
    pub severity: Severity,
    /// What to do about it.
    pub remedy: &'static str,
}

/// Number of kinds, those of an axis counted once per axis; no more alarms than this are ever active.
pub const ALARM_KINDS: usize = 67;

impl AlarmKind {
    /// Every kind, in the order of the numbers.
    pub const ALL: [AlarmKind; ALARM_KINDS] = [
        AlarmKind::EStop,
        AlarmKind::PowerLoss,
        AlarmKind::Overtravel(Axis::C),
        AlarmKind::Overtravel(Axis::X),
        AlarmKind::Overtravel(Axis::Z),
        AlarmKind::SoftLimit(Axis::C),
        AlarmKind::SoftLimit(Axis::X),
        AlarmKind::SoftLimit(Axis::Z),
        AlarmKind::FollowingError(Axis::C),
        AlarmKind::FollowingError(Axis::X),
        AlarmKind::FollowingError(Axis::Z),
        AlarmKind::DriveFault(Axis::C),
        AlarmKind::DriveFault(Axis::X),
        AlarmKind::DriveFault(Axis::Z),
        AlarmKind::EncoderJump(Axis::C),
        AlarmKind::EncoderJump(Axis::X),
        AlarmKind::EncoderJump(Axis::Z),
        AlarmKind::SetpointVelocity(Axis::C),
        AlarmKind::SetpointVelocity(Axis::X),
        AlarmKind::SetpointVelocity(Axis::Z),
        AlarmKind::SetpointAcceleration(Axis::C),
        AlarmKind::SetpointAcceleration(Axis::X),
        AlarmKind::SetpointAcceleration(Axis::Z),
        AlarmKind::SetpointJump(Axis::C),
        AlarmKind::SetpointJump(Axis::X),
        AlarmKind::SetpointJump(Axis::Z),
        AlarmKind::Underrun,
        AlarmKind::LateCommand,
        AlarmKind::CommandGap,
        AlarmKind::SecondWriter,
        AlarmKind::ChunkRefused,
        AlarmKind::SetpointsLost,
        AlarmKind::NoAuthority,
        AlarmKind::HomingFailed,
        AlarmKind::StationNotFound,
        AlarmKind::OriginDetector,
        AlarmKind::LimitSwitch,
        AlarmKind::SwitchBounces,
        AlarmKind::WheelStoppedInCut,
        AlarmKind::WheelContact,
        AlarmKind::WheelWorn,
        AlarmKind::WheelTooFast,
        AlarmKind::OtherWheel,
        AlarmKind::NotDressed,
        AlarmKind::WheelStopped,
        AlarmKind::WheelOverspeed,
        AlarmKind::NotHomed(Axis::C),
        AlarmKind::NotHomed(Axis::X),
        AlarmKind::NotHomed(Axis::Z),
        AlarmKind::NotAtStart(Axis::C),
        AlarmKind::NotAtStart(Axis::X),
        AlarmKind::NotAtStart(Axis::Z),
        AlarmKind::BadSegment,
        AlarmKind::GaugeInvalid,
        AlarmKind::GaugeStuck,
        AlarmKind::DoorOpened,
        AlarmKind::WorkAreaEntered,
        AlarmKind::ChuckOpened,
        AlarmKind::DoorStuck,
        AlarmKind::ChuckStuck,
        AlarmKind::LoaderLost,
        AlarmKind::SenderLost,
        AlarmKind::MachineLost,
        AlarmKind::MachineDeactivated,
        AlarmKind::RecordingLost,
        AlarmKind::PlannerLost,
        AlarmKind::FeedbackBlocked,
    ];

    /// The axis it is about.
    #[must_use]
    pub const fn axis(self) -> Option<Axis> {
        match self {
            AlarmKind::Overtravel(axis)
            | AlarmKind::SoftLimit(axis)
            | AlarmKind::FollowingError(axis)
            | AlarmKind::DriveFault(axis)
            | AlarmKind::EncoderJump(axis)
            | AlarmKind::SetpointVelocity(axis)
            | AlarmKind::SetpointAcceleration(axis)
            | AlarmKind::SetpointJump(axis)
            | AlarmKind::NotHomed(axis)
            | AlarmKind::NotAtStart(axis) => Some(axis),
            _ => None,
        }
    }

    /// Its row of the alarm table.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "an axis index is 0, 1 or 2")]
    pub const fn entry(self) -> AlarmEntry {
        use Severity::{PowerOff, Stop, Warning};
        let digit = match self.axis() {
            Some(axis) => axis.index() as u16 + 1,
            None => 0,
        };
        let (number, name, severity, remedy) = match self {
            AlarmKind::EStop => (1, "emergency stop", PowerOff, "release the emergency stop, then reset"),
            AlarmKind::PowerLoss => {
                (2, "power loss", PowerOff, "restore the mains, look where the axes stand, then reset")
            }
            AlarmKind::Overtravel(_) => (
                10 + digit,
                "overtravel",
                PowerOff,
                "reset, then move the axis back off its limit switch; check the soft limits",
            ),
            AlarmKind::SoftLimit(_) => {
                (20 + digit, "soft limit", Stop, "reset; send only positions between the soft limits")
            }
            AlarmKind::FollowingError(_) => (
                30 + digit,
                "following error",
                PowerOff,
                "look for a blocked axis, a drive without gain or an encoder that slips, then reset",
            ),
            AlarmKind::DriveFault(_) => {
                (40 + digit, "drive fault", PowerOff, "clear the fault at the drive, then reset")
            }
            AlarmKind::EncoderJump(_) => (
                43 + digit,
                "encoder jump",
                PowerOff,
                "look at the encoder and its cable, then reset and home the axis",
            ),
            AlarmKind::SetpointVelocity(_) => {
                (50 + digit, "setpoint too fast", Stop, "reset; the sender must keep the machine's speed limits")
            }
            AlarmKind::SetpointAcceleration(_) => (
                60 + digit,
                "setpoint acceleration",
                Stop,
                "reset; the sender must keep the machine's acceleration limits",
            ),
            AlarmKind::SetpointJump(_) => (
                70 + digit,
                "setpoint jump",
                Stop,
                "reset; the sender must continue from the machine's last setpoint, with speeds that fit its positions",
            ),
            AlarmKind::Underrun => (
                80,
                "underrun",
                Stop,
                "reset and start again; if it happens again, relieve the computer or run at pace fast",
            ),
            AlarmKind::LateCommand => (81, "late command", Stop, "reset; commands must arrive before their tick"),
            AlarmKind::CommandGap => (82, "command gap", Stop, "reset; look for lost messages between the nodes"),
            AlarmKind::SecondWriter => {
                (83, "second writer refused", Warning, "let the holder of command finish, or stop it first")
            }
            AlarmKind::ChunkRefused => {
                (84, "setpoints refused", Stop, "reset; the sender must continue from the machine's last setpoint")
            }
            AlarmKind::SetpointsLost => {
                (85, "setpoints lost", Stop, "reset and start again; look for lost messages between the nodes")
            }
            AlarmKind::NoAuthority => (
                86,
                "command refused: no authority",
                Warning,
                "take command of the cell (machine/take_command); the log names the sender",
            ),
            AlarmKind::HomingFailed => (
                90,
                "homing failed",
                Stop,
                "look at the origin detector, the home switch or their marks, then reset and home again",
            ),
            AlarmKind::StationNotFound => {
                (91, "station not found", Stop, "look at the station's limit switch and the dog, then reset")
            }
            AlarmKind::OriginDetector => (
                92,
                "origin detector",
                Stop,
                "look at the origin detector, its mark and its cable, then reset and home C again",
            ),
            AlarmKind::LimitSwitch => {
                (93, "limit switch", Stop, "look at the limit switch, its dog and its cable, then reset")
            }
            AlarmKind::SwitchBounces => {
                (94, "switch bounces", Stop, "mount a new limit switch, or fix its cable, then reset")
            }
            AlarmKind::WheelStoppedInCut => {
                (100, "wheel stopped in the cut", Stop, "reset, retract the wheel, find out why it lost its speed")
            }
            AlarmKind::WheelContact => (
                101,
                "wheel contact",
                PowerOff,
                "reset, retract the wheel, look at the part; start the wheel before the advance",
            ),
            AlarmKind::WheelWorn => (102, "wheel worn", Warning, "mount a new wheel"),
            AlarmKind::WheelTooFast => {
                (103, "wheel too fast", Stop, "reset; mount a larger wheel or lower the machine's wheel surface speed")
            }
            AlarmKind::OtherWheel => {
                (104, "other wheel", Stop, "reset and plan the job again: the wheel is not the one it was planned for")
            }
            AlarmKind::NotDressed => (
                105,
                "not dressed",
                Stop,
                "reset; the wheel must run, stand at the dresser and be larger than wanted by no more than a dress may take",
            ),
            AlarmKind::WheelStopped => (106, "wheel stopped", Stop, "find out why the wheel has no speed, then reset"),
            AlarmKind::WheelOverspeed => {
                (107, "wheel overspeed", Stop, "look at the wheel and at the drive of its spindle, then reset")
            }
            AlarmKind::NotHomed(_) => (110 + digit, "not homed", Stop, "reset and home the axis"),
            AlarmKind::NotAtStart(_) => {
                (120 + digit, "not at start", Stop, "reset and start the job from its beginning")
            }
            AlarmKind::BadSegment => (130, "bad segment", Stop, "reset and plan the job again"),
            AlarmKind::GaugeInvalid => (140, "gauge invalid", Stop, "look at the gauge and its cable, then reset"),
            AlarmKind::GaugeStuck => {
                (141, "gauge stuck", Stop, "look whether the gauge's contacts touch and move, then reset")
            }
            AlarmKind::DoorOpened => {
                (150, "door opened", PowerOff, "find out who opened the door, close it, then reset")
            }
            AlarmKind::WorkAreaEntered => {
                (151, "work area entered", PowerOff, "let whoever is inside leave, look at the part, then reset")
            }
            AlarmKind::ChuckOpened => (152, "chuck opened", Stop, "look at the part and at the chuck, then reset"),
            AlarmKind::DoorStuck => (153, "door stuck", Stop, "look what keeps the door from its end, then reset"),
            AlarmKind::ChuckStuck => (154, "chuck stuck", Stop, "look what keeps the chuck from its end, then reset"),
            AlarmKind::LoaderLost => {
                (155, "loader lost", Stop, "look at the loader, bring it out of the work area, then reset")
            }
            AlarmKind::SenderLost => {
                (160, "sender lost", Stop, "check the axis interpolator, start it again if it has ended, then reset")
            }
            AlarmKind::MachineLost => {
                (161, "machine lost", Stop, "check the machine, start it again if it has ended, then reset")
            }
            AlarmKind::MachineDeactivated => {
                (162, "machine deactivated", Stop, "activate the machine, inspect the part, then reset")
            }
            AlarmKind::RecordingLost => {
                (163, "recording lost", Warning, "check run_logger and its disk; the job goes on without a recording")
            }
            AlarmKind::PlannerLost => (
                164,
                "planner lost",
                Stop,
                "check the job planner, start it again if it has ended, then run the job again",
            ),
            AlarmKind::FeedbackBlocked => (
                165,
                "feedback blocked",
                Stop,
                "end the subscriber that does not acknowledge, or wait 50 s, then reset",
            ),
        };
        AlarmEntry { number, name, severity, remedy }
    }

    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u16) -> Option<AlarmKind> {
        AlarmKind::ALL.into_iter().find(|kind| kind.entry().number == number)
    }
}

/// In the place of the first tick of a chunk that has none.
pub const NO_TICK: f64 = -1.0;

/// An alarm that was raised. Its text is made by [`fmt::Display`], outside the cyclic path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alarm {
    pub kind: AlarmKind,
    /// Tick at which it was raised.
    pub tick: u64,
    /// How much; see [`AlarmKind`] for quantity and unit, 0 where the kind has none, not a number where another node knows it.
    pub value: f64,
    /// How much is allowed; see [`AlarmKind`], 0 where the kind has none.
    pub bound: f64,
}

crate::kept!(Alarm { kind, tick, value, bound } on {});

/// A position or a derivative of one, for people: mm for slides, degrees for the headstock.
struct Quantity(Axis, f64, &'static str);

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Axis::C => write!(f, "{:.4} deg{}", deg_from_rad(self.1), self.2),
            Axis::X | Axis::Z => write!(f, "{:.4} mm{}", self.1, self.2),
        }
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let allowed = |f: &mut fmt::Formatter<'_>, axis: Axis, what: &str, per: &'static str| {
            let (value, bound) = (Quantity(axis, self.value, per), Quantity(axis, self.bound, per));
            write!(f, "{}: {what} {value}, allowed {bound}", axis.joint())
        };
        if self.value.is_nan() {
            return write!(f, "{}: found by the axis interpolator, which says more", self.kind.entry().name);
        }
        match self.kind {
            AlarmKind::EStop => f.write_str("emergency stop pressed"),
            AlarmKind::PowerLoss => f.write_str("the mains are lost"),
            AlarmKind::Overtravel(axis) => allowed(f, axis, "hard limit switch reached at", ""),
            AlarmKind::SoftLimit(axis) => allowed(f, axis, "setpoint beyond the soft limit at", ""),
            AlarmKind::FollowingError(axis) => allowed(f, axis, "following error", ""),
            AlarmKind::DriveFault(axis) => write!(f, "{}: the drive reports a fault", axis.joint()),
            AlarmKind::EncoderJump(axis) => allowed(f, axis, "the encoder's reading jumped by", ""),
            AlarmKind::SetpointVelocity(axis) => allowed(f, axis, "setpoint speed", "/s"),
            AlarmKind::SetpointAcceleration(axis) => allowed(f, axis, "setpoint acceleration", "/s^2"),
            AlarmKind::SetpointJump(axis) => allowed(f, axis, "distance and speeds of two setpoints disagree by", ""),
            AlarmKind::Underrun => f.write_str("setpoints did not arrive in time: stopped on the path"),
            AlarmKind::LateCommand => write!(f, "a command arrived {} ticks after its tick", self.value),
            AlarmKind::CommandGap => {
                write!(f, "commands are missing: received number {}, expected {}", self.value, self.bound)
            }
            AlarmKind::SecondWriter => f.write_str("a second sender of setpoints was refused"),
            AlarmKind::ChunkRefused if self.value < 0.0 => {
                f.write_str("what came as setpoints is no chunk: other joints, no tick, or points that do not make one")
            }
            AlarmKind::ChunkRefused => write!(f, "the setpoints from tick {} on were refused", self.value),
            AlarmKind::SetpointsLost => {
                write!(f, "setpoints from tick {} on came, those from tick {} on are missing", self.value, self.bound)
            }
            AlarmKind::NoAuthority => f.write_str("a sender without command of the cell was refused"),
            AlarmKind::HomingFailed => f.write_str("a reference was not found within the search travel"),
            AlarmKind::StationNotFound => {
                f.write_str("the station's limit switch was not found within the search travel")
            }
            AlarmKind::OriginDetector if self.value.abs() < f64::MIN_POSITIVE => {
                f.write_str("the origin detector did not signal at its mark")
            }
            AlarmKind::OriginDetector => write!(
                f,
                "the origin detector signalled {:.2} deg from its mark, allowed {:.2} deg",
                deg_from_rad(self.value),
                deg_from_rad(self.bound)
            ),
            AlarmKind::LimitSwitch => {
                write!(f, "the limit switch of station {} does not fit the table's position", self.value)
            }
            AlarmKind::SwitchBounces => write!(f, "the limit switch of station {} bounces", self.value),
            AlarmKind::WheelStoppedInCut => f.write_str("the wheel lost its speed while it was cutting"),
            AlarmKind::WheelContact => {
                write!(f, "the wheel touched the part without running, {:.4} mm deep", self.value)
            }
            AlarmKind::WheelStopped => f.write_str("the wheel has no speed though it is to run"),
            AlarmKind::WheelOverspeed => {
                write!(f, "the wheel turns at {:.1} rpm, allowed are {:.1} rpm", self.value, self.bound)
            }
            AlarmKind::GaugeInvalid => f.write_str("the gauge gives no number"),
            AlarmKind::GaugeStuck => write!(f, "the gauge gave the same reading {} times", self.value),
            AlarmKind::NotHomed(axis) => write!(f, "{}: its zero is not known", axis.joint()),
            AlarmKind::NotAtStart(axis) => {
                let (is, wanted) = (Quantity(axis, self.value, ""), Quantity(axis, self.bound, ""));
                write!(f, "{}: the cut begins at {wanted}, the axis is at {is}", axis.joint())
            }
            AlarmKind::BadSegment => write!(f, "segment {} cannot be executed", self.value),
            AlarmKind::WheelTooFast => {
                write!(f, "the wheel would turn at {:.1} rpm, allowed are {:.1} rpm", self.value, self.bound)
            }
            AlarmKind::OtherWheel => {
                write!(f, "wheel radius {:.4} mm, the plan is for {:.4} mm", self.value, self.bound)
            }
            AlarmKind::NotDressed => {
                write!(f, "the wheel of radius {:.4} mm was not dressed to {:.4} mm", self.bound, self.value)
            }
            AlarmKind::WheelWorn => {
                write!(f, "wheel radius {:.3} mm, smallest usable {:.3} mm", self.value, self.bound)
            }
            AlarmKind::DoorOpened => f.write_str("the door is open while axes or wheel move"),
            AlarmKind::WorkAreaEntered => f.write_str("somebody is in the work area while axes or wheel move"),
            AlarmKind::ChuckOpened => f.write_str("the chuck is open while axes or wheel move"),
            AlarmKind::DoorStuck => f.write_str("the door does not come to its end"),
            AlarmKind::ChuckStuck => f.write_str("the chuck does not come to its end"),
            AlarmKind::LoaderLost => f.write_str("the loader went silent while it was in the work area"),
            AlarmKind::SenderLost => {
                write!(f, "the sender of setpoints has been silent for {} s: stopped on the path", self.value)
            }
            AlarmKind::MachineLost => {
                write!(f, "the machine has been silent for {} s, or was started again", self.value)
            }
            AlarmKind::MachineDeactivated => {
                f.write_str("the machine was deactivated while a motion was executed: stopped on the path")
            }
            AlarmKind::RecordingLost => write!(f, "the recorder has been silent or behind for {} s", self.value),
            AlarmKind::PlannerLost => {
                write!(f, "the job planner has been silent for {} s: its plan is cancelled", self.value)
            }
            AlarmKind::FeedbackBlocked => {
                write!(f, "the machine could not send its feedback for {} s: stopped on the path", self.value)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::format;

    #[test]
    fn numbers_increase_so_each_names_one_kind() {
        for pair in AlarmKind::ALL.windows(2) {
            assert!(pair[0].entry().number < pair[1].entry().number, "{pair:?}");
        }
        for kind in AlarmKind::ALL {
            assert_eq!(AlarmKind::from_number(kind.entry().number), Some(kind));
            let entry = kind.entry();
            assert!(!entry.name.is_empty() && !entry.remedy.is_empty());
        }
    }

    #[test]
    fn the_text_says_what_how_much_and_how_much_is_allowed() {
        let alarm = Alarm { kind: AlarmKind::FollowingError(Axis::X), tick: 5, value: 0.25, bound: 0.1 };
        assert_eq!(format!("{alarm}"), "x_axis: following error 0.2500 mm, allowed 0.1000 mm");
    }
}
