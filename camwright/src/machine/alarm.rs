// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Numbered alarms of the cell: cause, reaction, remedy. `alarms!` is their table.
//!
//! Alarms are data: they travel to the operator and into the recording. They are latched; a reset clears them once
//! their cause is gone, and never restarts motion.

use crate::machine::description::Axis;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::math::units::deg_from_rad;
use core::fmt;

/// Reaction of the motion to an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum AlarmSeverity {
    /// Reported; motion goes on.
    Warning = 1,
    /// The axes come to rest within their limits and the wheel leaves the part; needs a reset.
    Stop = 2,
    /// The same, and then the drives lose their power; a drive that cannot bring its axis to rest loses it at once.
    PowerOff = 3,
}

/// One row of the alarm table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlarmEntry {
    /// Number; for alarms of an axis the last digit is 1 for C, 2 for X, 3 for Z.
    pub number: u16,
    pub name: &'static str,
    pub severity: AlarmSeverity,
    pub remedy: &'static str,
}

/// Text of an alarm, with `{axis}`, `{value}` and `{bound}` in it.
struct Template {
    text: &'static str,
    quantity: Quantity,
    /// A value that means something else, and the text for it.
    exception: Option<(f64, &'static str)>,
}

/// Quantity and unit of an alarm's value and bound, as its text shows them.
#[derive(Clone, Copy)]
enum Quantity {
    /// Plain number without a unit.
    Plain,
    /// mm, on C degrees (held in rad).
    Position,
    /// mm/s, on C deg/s.
    Velocity,
    /// mm/s², on C deg/s².
    Acceleration,
    /// Degrees (held in rad).
    Angle,
    Rpm,
    /// mm, with this number of decimals.
    Length(usize),
}

/// Kinds of an alarm family: one, or one for each axis.
macro_rules! kinds {
    ($kind:ident) => {
        [AlarmKind::$kind]
    };
    ($kind:ident $axis:ty) => {
        [AlarmKind::$kind(Axis::C), AlarmKind::$kind(Axis::X), AlarmKind::$kind(Axis::Z)]
    };
}

macro_rules! quantity {
    () => {
        Quantity::Plain
    };
    ($quantity:expr) => {
        $quantity
    };
}

/// Declares the alarms, each with its kind, number (of an axis: the number before that of C), severity, name, text and remedy.
macro_rules! alarms {
    ($(
        $(#[$attribute:meta])*
        $kind:ident $(($axis:ty))? = $number:literal $severity:ident $name:literal:
            $text:literal $(in $quantity:expr)?, $(except $exception:expr => $other_text:literal,)?
            remedy $remedy:literal;
    )+) => {
        /// Kind of an alarm, of the machine or of a node.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        pub enum AlarmKind {
            $($(#[$attribute])* $kind $(($axis))?,)+
        }

        const FAMILIES: &[&[AlarmKind]] = &[$(&kinds!($kind $($axis)?)),+];

        impl AlarmKind {
            /// The axis that the alarm concerns.
            #[must_use]
            pub const fn axis(self) -> Option<Axis> {
                match self {
                    $($(AlarmKind::$kind(axis) => Some::<$axis>(axis),)?)+
                    _ => None,
                }
            }

            /// Row of this kind in the alarm table.
            #[must_use]
            #[allow(clippy::cast_possible_truncation, reason = "an axis index is 0, 1 or 2")]
            pub const fn entry(self) -> AlarmEntry {
                let digit = match self.axis() {
                    Some(axis) => axis.index() as u16 + 1,
                    None => 0,
                };
                let (number, name, severity, remedy) = match self {
                    $(AlarmKind::$kind { .. } => ($number, $name, AlarmSeverity::$severity, $remedy),)+
                };
                AlarmEntry { number: number + digit, name, severity, remedy }
            }

            const fn template(self) -> Template {
                match self {
                    $(AlarmKind::$kind { .. } => Template {
                        text: $text,
                        quantity: quantity!($($quantity)?),
                        exception: [$(Some(($exception, $other_text)),)? None][0],
                    },)+
                }
            }
        }
    };
}

alarms! {
    /// Emergency stop pressed (a simulation of one; not a safety function).
    #[default]
    EStop = 1 PowerOff "emergency stop":
        "emergency stop pressed",
        remedy "release the emergency stop, then reset";
    /// The mains are lost; the axes come to rest and the wheel leaves the part from the buffered energy.
    PowerLoss = 2 PowerOff "power loss":
        "mains power lost",
        remedy "restore the mains, check the positions of the axes, then reset";
    /// An axis ran onto its hard limit switch. Value and bound: position (mm).
    Overtravel(Axis) = 10 PowerOff "overtravel":
        "{axis}: hard limit switch reached at {value}, allowed {bound}" in Quantity::Position,
        remedy "reset, then move the axis back off its limit switch; check the soft limits";
    /// A setpoint beyond a soft limit. Value and bound: position (mm or rad).
    SoftLimit(Axis) = 20 Stop "soft limit":
        "{axis}: setpoint beyond the soft limit at {value}, allowed {bound}" in Quantity::Position,
        remedy "reset; send only positions between the soft limits";
    /// Setpoint minus actual is too large. Value and bound: following error (mm or rad).
    FollowingError(Axis) = 30 PowerOff "following error":
        "{axis}: following error {value}, allowed {bound}" in Quantity::Position,
        remedy "check for a blocked axis, a drive without gain or a slipping encoder, then reset";
    /// The drive of an axis reports a fault.
    DriveFault(Axis) = 40 PowerOff "drive fault":
        "{axis}: the drive reports a fault",
        remedy "clear the fault at the drive, then reset";
    /// The reading of an encoder jumped farther than the axis can. Value and bound: jump (mm or rad).
    EncoderJump(Axis) = 43 PowerOff "encoder jump":
        "{axis}: the encoder's reading jumped by {value}, allowed {bound}" in Quantity::Position,
        remedy "inspect the encoder and its cable, then reset and home the axis";
    /// A setpoint faster than the axis. Value and bound: speed (mm/s or rad/s).
    SetpointVelocity(Axis) = 50 Stop "setpoint too fast":
        "{axis}: setpoint speed {value}, allowed {bound}" in Quantity::Velocity,
        remedy "reset; the sender must keep the machine's speed limits";
    /// Setpoints that change speed faster than the axis. Value and bound: acceleration (mm/s² or rad/s²).
    SetpointAcceleration(Axis) = 60 Stop "setpoint acceleration":
        "{axis}: setpoint acceleration {value}, allowed {bound}" in Quantity::Acceleration,
        remedy "reset; the sender must keep the machine's acceleration limits";
    /// Two setpoints whose distance does not fit their speeds. Value and bound: misfit (mm or rad).
    SetpointJump(Axis) = 70 Stop "setpoint jump":
        "{axis}: distance and speeds of two setpoints disagree by {value}, allowed {bound}" in Quantity::Position,
        remedy "reset; the sender must continue from the machine's last setpoint, with speeds that fit its positions";
    /// Setpoints did not arrive in time.
    Underrun = 80 Stop "underrun":
        "setpoints did not arrive in time: stopped on the path",
        remedy "reset and start again; if it happens again, reduce the load of the computer or run at pace fast";
    /// A command arrived after the tick it was meant for. Value: ticks late.
    LateCommand = 81 Stop "late command":
        "a command arrived {value} ticks after its tick",
        remedy "reset; commands must arrive before their tick";
    /// Commands are missing. Value: number received, bound: number expected.
    CommandGap = 82 Stop "command gap":
        "commands are missing: received number {value}, expected {bound}",
        remedy "reset; check for lost messages between the nodes";
    /// A second sender of setpoints was refused.
    SecondWriter = 83 Warning "second writer refused":
        "a second sender of setpoints was refused",
        remedy "let the holder of command finish, or stop it first";
    /// A chunk of setpoints was refused. Value: its first tick, [`NO_TICK`] where what came is no chunk.
    ChunkRefused = 84 Stop "setpoints refused":
        "the setpoints from tick {value} on were refused",
        except NO_TICK => "malformed setpoints: other joints, no tick, or points that do not form a chunk",
        remedy "reset; the sender must continue from the machine's last setpoint";
    /// Setpoints between two chunks are missing. Value: first tick received, bound: first tick expected.
    SetpointsLost = 85 Stop "setpoints lost":
        "setpoints from tick {value} arrived, those from tick {bound} are missing",
        remedy "reset and start again; check for lost messages between the nodes";
    /// A request, command or setpoint was refused: its sender has no command of the cell, or a field is out of bounds.
    NoAuthority = 86 Warning "command refused: no authority":
        "a sender without command of the cell was refused",
        remedy "take command of the cell (machine/take_command); the log names the sender";
    /// A search for the origin, a home switch or an index ended without its edge.
    HomingFailed = 90 Stop "homing failed":
        "a reference was not found within the search travel",
        remedy "inspect the origin detector, the home switch or their marks, then reset and home again";
    /// A station was searched for and its switch did not close.
    StationNotFound = 91 Stop "station not found":
        "the station's limit switch was not found within the search travel",
        remedy "inspect the station's limit switch and the dog, then reset";
    /// The origin detector did not signal where it must, or signalled where it must not. Value: angle off its mark (rad).
    OriginDetector = 92 Stop "origin detector":
        "the origin detector signalled {value} from its mark, allowed {bound}" in Quantity::Angle,
        except 0.0 => "the origin detector did not signal at its mark",
        remedy "inspect the origin detector, its mark and its cable, then reset and home C again";
    /// A limit switch does not show what the table's position says. Value: number of its station, from 1.
    LimitSwitch = 93 Stop "limit switch":
        "the limit switch of station {value} does not fit the table's position",
        remedy "inspect the limit switch, its dog and its cable, then reset";
    /// A limit switch closes and opens again and again. Value: number of its station, from 1.
    SwitchBounces = 94 Stop "switch bounces":
        "the limit switch of station {value} bounces",
        remedy "replace the limit switch or its cable, then reset";
    /// The wheel lost its speed while it was cutting.
    WheelStoppedInCut = 100 Stop "wheel stopped in the cut":
        "the wheel lost its speed while it was cutting",
        remedy "reset, retract the wheel, find out why it lost its speed";
    /// The wheel touched the part without running. Value: depth (mm).
    WheelContact = 101 PowerOff "wheel contact":
        "the wheel touched the part without running, {value} deep" in Quantity::Length(4),
        remedy "reset, retract the wheel, inspect the part; start the wheel before the advance";
    /// The wheel is smaller than its smallest usable radius. Value and bound: radius (mm).
    WheelWorn = 102 Warning "wheel worn":
        "wheel radius {value}, smallest usable {bound}" in Quantity::Length(3),
        remedy "mount a new wheel";
    /// The wheel would turn faster than it may and was not started. Value and bound: speed (rpm).
    WheelTooFast = 103 Stop "wheel too fast":
        "the wheel would turn at {value}, allowed {bound}" in Quantity::Rpm,
        remedy "reset; mount a larger wheel or lower the machine's wheel surface speed";
    /// The plan was made for another wheel. Value: radius mounted, bound: radius wanted (mm).
    OtherWheel = 104 Stop "other wheel":
        "wheel radius {value}, the plan is for {bound}" in Quantity::Length(4),
        remedy "reset and plan the job again: the wheel is not the one it was planned for";
    /// A dress was not made. Value: radius wanted, bound: radius of the worn wheel (mm).
    NotDressed = 105 Stop "not dressed":
        "the wheel of radius {bound} was not dressed to {value}" in Quantity::Length(4),
        remedy "reset; the wheel must run, stand at the dresser and exceed the target radius by at most one dressing depth";
    /// The wheel lost its speed out of the cut, or does not reach it.
    WheelStopped = 106 Stop "wheel stopped":
        "the wheel is commanded to run but has no speed",
        remedy "find out why the wheel has no speed, then reset";
    /// The wheel turns faster than ordered. Value and bound: speed (rpm).
    WheelOverspeed = 107 Stop "wheel overspeed":
        "the wheel turns at {value}, allowed {bound}" in Quantity::Rpm,
        remedy "inspect the wheel and the drive of its spindle, then reset";
    /// A change of the wheel did not begin, or is disturbed. Value and bound: position of `x_axis` (mm).
    WheelNotChanged = 108 Stop "wheel not changed":
        "a change of the wheel needs the wheel at rest and x_axis at {bound} or more; it is at {value}" in Quantity::Length(3),
        remedy "reset; stop the wheel, move x_axis clear of the changer and wait until a change has ended before the next order";
    /// The changer has no such wheel. Value: position asked for, bound: number of wheels.
    NoSuchWheel = 109 Stop "no such wheel":
        "wheel {value} was asked for, the machine has {bound}",
        remedy "reset and plan the job again for the wheels of this machine";
    /// A motion asks for a position of an axis whose zero is not known.
    NotHomed(Axis) = 110 Stop "not homed":
        "{axis}: its zero is not known",
        remedy "reset and home the axis";
    /// A cut begins where the axis is not. Value: where it is, bound: where it should be (mm or rad).
    NotAtStart(Axis) = 120 Stop "not at start":
        "{axis}: the cut begins at {bound}, the axis is at {value}" in Quantity::Position,
        remedy "reset and start the job from its beginning";
    /// A segment of a plan cannot be executed. Value: its index.
    BadSegment = 130 Stop "bad segment":
        "segment {value} cannot be executed",
        remedy "reset and plan the job again";
    /// The gauge gives no number.
    GaugeInvalid = 140 Stop "gauge invalid":
        "the gauge gives no number",
        remedy "inspect the gauge and its cable, then reset";
    /// The gauge gives the same reading again and again while it must change. Value: how often.
    GaugeStuck = 141 Stop "gauge stuck":
        "the gauge gave the same reading {value} times",
        remedy "check that the gauge's contacts touch and move, then reset";
    /// The whole infeed was driven and the gauge has not read the size. The interpolator says which.
    SizeNotReached = 142 Stop "size not reached":
        "the infeed is over and the gauge has not read the size",
        remedy "reset; check wheel radius and gauge zero, or dress the wheel; raise infeed.gauge_size.beyond_um if the wheel wears as expected";
    /// The door was opened, or is open, while axes or wheel move.
    DoorOpened = 150 PowerOff "door opened":
        "the door is open while axes or wheel move",
        remedy "find out who opened the door, close it, then reset";
    /// A person enters or is in the work area while axes or wheel move.
    WorkAreaEntered = 151 PowerOff "work area entered":
        "a person is in the work area while axes or wheel move",
        remedy "clear the work area, inspect the part, then reset";
    /// The chuck let go, or is open, while axes or wheel move.
    ChuckOpened = 152 Stop "chuck opened":
        "the chuck is open while axes or wheel move",
        remedy "inspect the part and the chuck, then reset";
    /// The door does not come to its end.
    DoorStuck = 153 Stop "door stuck":
        "the door did not reach its end position",
        remedy "find what blocks the door, then reset";
    /// The chuck does not come to its end.
    ChuckStuck = 154 Stop "chuck stuck":
        "the chuck did not reach its end position",
        remedy "find what blocks the chuck, then reset";
    /// The loader went silent while it was in the work area.
    LoaderLost = 155 Stop "loader lost":
        "no message from the loader while it was in the work area",
        remedy "inspect the loader, move it out of the work area, then reset";
    /// The sender of setpoints fell silent while the machine waited for it. Value: longest silence allowed (s).
    SenderLost = 160 Stop "sender lost":
        "the sender of setpoints has been silent for {value} s: stopped on the path",
        remedy "check the axis interpolator, start it again if it has ended, then reset";
    /// The machine fell silent, or was started again, while a motion was executed. Value: longest silence allowed (s).
    MachineLost = 161 Stop "machine lost":
        "the machine has been silent for {value} s, or was started again",
        remedy "check the machine, start it again if it has ended, then reset";
    /// The machine was deactivated, or its node ended, while a motion was executed.
    MachineDeactivated = 162 Stop "machine deactivated":
        "the machine was deactivated while a motion was executed: stopped on the path",
        remedy "activate the machine, inspect the part, then reset";
    /// The recorder fell silent or fell behind while it recorded. Value: longest silence allowed (s).
    RecordingLost = 163 Warning "recording lost":
        "the recorder has been silent or behind for {value} s",
        remedy "check run_logger and its disk; the job goes on without a recording";
    /// The job planner fell silent while its plan was executed. Value: longest silence allowed (s).
    PlannerLost = 164 Stop "planner lost":
        "the job planner has been silent for {value} s: its plan is cancelled",
        remedy "check the job planner, start it again if it has ended, then run the job again";
    /// The machine could not send its feedback. Value: how long it tried (s).
    FeedbackBlocked = 165 Stop "feedback blocked":
        "the machine could not send its feedback for {value} s: stopped on the path",
        remedy "end the subscriber that does not acknowledge, or wait 50 s, then reset";
    /// The bus to real drives is silent, or its programs have ended. It comes again after every reset until the node is started again.
    DrivesLost = 166 PowerOff "drives lost":
        "the bus to the drives does not answer; nobody knows whether the axes rest",
        remedy "read the log of the machine's node, start HAL again if it has ended, then start the node again";
}

/// Number of kinds, those of an axis counted once per axis; no more alarms than this are ever active.
pub const ALARM_KINDS: usize = {
    let (mut count, mut family) = (0, 0);
    while family < FAMILIES.len() {
        count += FAMILIES[family].len();
        family += 1;
    }
    count
};

impl AlarmKind {
    /// Every kind, in the order of the numbers.
    pub const ALL: [AlarmKind; ALARM_KINDS] = {
        let mut all = [AlarmKind::EStop; ALARM_KINDS];
        let (mut count, mut family) = (0, 0);
        while family < FAMILIES.len() {
            let mut member = 0;
            while member < FAMILIES[family].len() {
                all[count] = FAMILIES[family][member];
                count += 1;
                member += 1;
            }
            family += 1;
        }
        all
    };

    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u16) -> Option<AlarmKind> {
        AlarmKind::ALL.into_iter().find(|kind| kind.entry().number == number)
    }
}

/// Value of a refused chunk that has no first tick.
pub const NO_TICK: f64 = -1.0;

/// An alarm that was raised. [`fmt::Display`] gives its text; the cyclic path does not format it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alarm {
    pub kind: AlarmKind,
    /// Tick at which it was raised.
    pub tick: u64,
    /// Measured value; see [`AlarmKind`] for quantity and unit. 0 where the kind has none, NaN where another node knows it.
    pub value: f64,
    /// Allowed value; see [`AlarmKind`], 0 where the kind has none.
    pub bound: f64,
}

impl Snapshot for Alarm {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        codec.field("kind", |codec| self.kind.snapshot(codec))?;
        codec.field("tick", |codec| self.tick.snapshot(codec))?;
        codec.field("value", |codec| codec.measured(&mut self.value))?;
        codec.field("bound", |codec| codec.measured(&mut self.bound))
    }
}

impl Quantity {
    fn write(self, f: &mut fmt::Formatter<'_>, axis: Option<Axis>, value: f64) -> fmt::Result {
        let of_axis = |f: &mut fmt::Formatter<'_>, per: &str| match axis {
            Some(Axis::C) => write!(f, "{:.4} deg{per}", deg_from_rad(value)),
            Some(Axis::X | Axis::Z) | None => write!(f, "{value:.4} mm{per}"),
        };
        match self {
            Quantity::Plain => write!(f, "{value}"),
            Quantity::Position => of_axis(f, ""),
            Quantity::Velocity => of_axis(f, "/s"),
            Quantity::Acceleration => of_axis(f, "/s^2"),
            Quantity::Angle => write!(f, "{:.2} deg", deg_from_rad(value)),
            Quantity::Rpm => write!(f, "{value:.1} rpm"),
            Quantity::Length(decimals) => write!(f, "{value:.decimals$} mm"),
        }
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.value.is_nan() {
            return write!(f, "{}: found by the axis interpolator, which says more", self.kind.entry().name);
        }
        let Template { text, quantity, exception } = self.kind.template();
        if let Some((_, text)) = exception.filter(|(value, _)| (value - self.value).abs() < f64::MIN_POSITIVE) {
            return f.write_str(text);
        }
        let mut rest = text;
        while let Some((before, field_and_rest)) = rest.split_once('{') {
            let (field, after) = field_and_rest.split_once('}').unwrap_or((field_and_rest, ""));
            f.write_str(before)?;
            match field {
                "axis" => f.write_str(self.kind.axis().map_or("", Axis::joint))?,
                "value" => quantity.write(f, self.kind.axis(), self.value)?,
                "bound" => quantity.write(f, self.kind.axis(), self.bound)?,
                other => write!(f, "{{{other}}}")?,
            }
            rest = after;
        }
        f.write_str(rest)
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
    fn the_text_states_value_and_limit() {
        let alarm = |kind, value, bound| format!("{}", Alarm { kind, tick: 5, value, bound });
        assert_eq!(
            alarm(AlarmKind::FollowingError(Axis::X), 0.25, 0.1),
            "x_axis: following error 0.2500 mm, allowed 0.1000 mm"
        );
        assert_eq!(
            alarm(AlarmKind::SetpointVelocity(Axis::C), 1.0, 0.5),
            "c_axis: setpoint speed 57.2958 deg/s, allowed 28.6479 deg/s"
        );
        assert_eq!(alarm(AlarmKind::ChunkRefused, 7.0, 0.0), "the setpoints from tick 7 on were refused");
        assert!(alarm(AlarmKind::ChunkRefused, NO_TICK, 0.0).starts_with("malformed setpoints"));
        assert_eq!(alarm(AlarmKind::WheelWorn, 44.5, 45.0), "wheel radius 44.500 mm, smallest usable 45.000 mm");
    }

    /// Of an alarm of another node the values are not known. A machine with such an alarm has keyframes, too.
    #[test]
    fn an_alarm_without_values_is_kept_in_a_keyframe() {
        let mut alarm = Alarm { kind: AlarmKind::Underrun, tick: 5, value: f64::NAN, bound: f64::NAN };
        let mut octets = alloc::vec![0; 64];
        let mut codec = SnapshotCodec::writing(&mut octets);
        alarm.snapshot(&mut codec).expect("there is room");
        let written = codec.octets();
        let mut read = Alarm::default();
        read.snapshot(&mut SnapshotCodec::reading(&octets[..written])).expect("an alarm");
        assert!((read.kind, read.tick) == (alarm.kind, 5) && read.value.is_nan() && read.bound.is_nan(), "{read:?}");
        let end = written - 16;
        octets[end..end + 8].copy_from_slice(&f64::INFINITY.to_le_bytes());
        assert!(read.snapshot(&mut SnapshotCodec::reading(&octets[..written])).is_err());
    }

    #[test]
    fn every_text_has_only_fields_that_its_kind_has() {
        for kind in AlarmKind::ALL {
            let text = format!("{}", Alarm { kind, tick: 5, value: 1.5, bound: 2.5 });
            assert!(!text.contains(['{', '}']), "{text}");
            assert_eq!(text.contains("_axis: "), kind.axis().is_some(), "{text}");
        }
    }
}
