//! The steps of a plan as messages, and back.

use super::plan::{SplinePlace, count};
use super::{core_from_si, m_from_mm, mm_from_m, si_from_core};
use camwright::machine::description::{Axis, MachineDescription, MotionLimits};
use camwright::motion::plan::{AxisTarget, Command, CutSegment, Phase, Plan, Segment, SegmentKind, SpiralSegment};
use camwright_msgs::camwright_msgs::msg::{MachineCommand, PlanSegment, PlanSpline};

/// A step as a message.
pub(super) fn segment_to(plan: &Plan, index: u32, segment: &Segment) -> PlanSegment {
    let base = PlanSegment {
        index,
        phase: segment.phase as u8,
        lobe: segment.lobe.and_then(|lobe| i32::try_from(lobe).ok()).unwrap_or(-1),
        label: segment.label.clone(),
        ticks: segment.ticks,
        stop_ticks: segment.stop_ticks,
        stock_at_start: m_from_mm(segment.stock_mm),
        ..PlanSegment::default()
    };
    let ratios_at = plan.paths.len();
    let laws_at = ratios_at + plan.ratios.len();
    let angle_laws_at = laws_at + plan.time_laws.len();
    match &segment.kind {
        SegmentKind::Move(targets) => PlanSegment {
            kind: PlanSegment::MOVE,
            joints: targets.iter().map(|target| target.axis.joint().to_owned()).collect(),
            target_counts: targets.iter().map(|target| target.target_counts).collect(),
            velocity: targets.iter().map(|t| si_from_core(t.axis, t.limits.velocity)).collect(),
            acceleration: targets.iter().map(|t| si_from_core(t.axis, t.limits.acceleration)).collect(),
            jerk: targets.iter().map(|t| si_from_core(t.axis, t.limits.jerk)).collect(),
            ..base
        },
        SegmentKind::Search { axis, input, travel_counts, offset_counts, limits } => PlanSegment {
            kind: PlanSegment::SEARCH,
            joints: vec![axis.joint().to_owned()],
            target_counts: vec![*travel_counts, *offset_counts],
            velocity: vec![si_from_core(*axis, limits.velocity)],
            acceleration: vec![si_from_core(*axis, limits.acceleration)],
            jerk: vec![si_from_core(*axis, limits.jerk)],
            input: input.clone(),
            ..base
        },
        // No plan of a job has one; a receiver refuses it.
        SegmentKind::Home(_) => PlanSegment { kind: 0, ..base },
        SegmentKind::Cut(cut) => PlanSegment {
            kind: PlanSegment::CUT,
            path: count(cut.path),
            speed: count(laws_at + cut.speed),
            infeed: count(angle_laws_at + cut.infeed),
            ratio: cut.ratio.and_then(|ratio| i32::try_from(ratios_at + ratio).ok()).unwrap_or(-1),
            lead: cut.lead.and_then(|lead| i32::try_from(laws_at + lead).ok()).unwrap_or(-1),
            start_counts: cut.start_counts,
            path_start: cut.path_start_rad,
            turns: f64::from(cut.turns),
            infeed_turns: f64::from(cut.infeed_turns),
            plateau_start: cut.plateau_s.0,
            plateau_end: cut.plateau_s.1,
            turn_time: cut.turn_s,
            retract: m_from_mm(cut.retract_mm),
            hold: m_from_mm(cut.hold_mm),
            until_steady: cut.until_steady_n.map_or(0.0, f64::from),
            ..base
        },
        SegmentKind::Spiral(spiral) => PlanSegment {
            kind: PlanSegment::SPIRAL,
            path: count(angle_laws_at + spiral.path),
            speed: count(laws_at + spiral.speed),
            infeed: count(angle_laws_at + spiral.advance),
            start_counts: spiral.start_counts,
            ..base
        },
        SegmentKind::Dwell => PlanSegment { kind: PlanSegment::DWELL, ..base },
        SegmentKind::Wait => PlanSegment { kind: PlanSegment::WAIT, ..base },
        SegmentKind::Command(command) => PlanSegment {
            kind: PlanSegment::COMMAND,
            command: match command {
                Command::SetHome(_) => MachineCommand::SET_HOME,
                Command::WheelStart => MachineCommand::WHEEL_START,
                Command::WheelStop => MachineCommand::WHEEL_STOP,
                Command::ExpectWheel { .. } => MachineCommand::EXPECT_WHEEL,
                Command::Dress { .. } => MachineCommand::DRESS,
                Command::Push { .. } => MachineCommand::PUSH,
                Command::WatchForce { .. } => MachineCommand::WATCH_FORCE,
            },
            target: match command {
                Command::SetHome(axis) => axis.joint().to_owned(),
                _ => String::new(),
            },
            target_counts: match command {
                Command::ExpectWheel { radius_nm } | Command::Dress { radius_nm } => vec![*radius_nm],
                Command::Push { most_n } | Command::WatchForce { most_n } => vec![*most_n],
                _ => Vec::new(),
            },
            ..base
        },
    }
}

/// The step that a message means; `place` tells where the splines of the plan's pages went.
pub(super) fn segment_from(
    message: &PlanSegment,
    place: &[SplinePlace],
    plan: &Plan,
    machine: &MachineDescription,
) -> Result<Segment, String> {
    let lobe = usize::try_from(message.lobe).ok();
    if let Some(lobe) = lobe.filter(|lobe| *lobe >= plan.lobes.len()) {
        return Err(format!("lobe {lobe} of {} lobes", plan.lobes.len()));
    }
    Ok(Segment {
        kind: kind_from(message, place, machine)?,
        phase: phase_from(message.phase).ok_or_else(|| format!("its phase is {}", message.phase))?,
        lobe,
        label: message.label.clone(),
        ticks: message.ticks,
        stop_ticks: message.stop_ticks,
        stock_mm: mm_from_m(finite("stock_at_start", message.stock_at_start)?),
    })
}

fn finite(name: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{name} is {value}")) }
}

/// The phase with this number.
#[must_use]
pub fn phase_from(number: u8) -> Option<Phase> {
    use Phase::{Approach, Cut, Dress, Home, Index, Position, Retract, Return, RotaryIndex, SparkOut};
    [Home, Index, Position, Approach, Cut, SparkOut, Retract, Return, RotaryIndex, Dress]
        .into_iter()
        .find(|phase| *phase as u8 == number)
}

/// A phase in the words of the shop.
#[must_use]
pub fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Home => "home",
        Phase::Index => "index",
        Phase::Position => "position",
        Phase::Approach => "approach",
        Phase::Cut => "cut",
        Phase::SparkOut => "spark-out",
        Phase::Retract => "retract",
        Phase::Return => "return",
        Phase::RotaryIndex => "rotary index",
        Phase::Dress => "dress",
    }
}

fn kind_from(
    message: &PlanSegment,
    place: &[SplinePlace],
    machine: &MachineDescription,
) -> Result<SegmentKind, String> {
    let axis = |index: usize| -> Result<Axis, String> {
        let joint = message.joints.get(index).ok_or("joints are missing")?;
        Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}"))
    };
    let limits = |index: usize, axis: Axis| -> Result<MotionLimits, String> {
        let own = machine.axis(axis).limits;
        let value = |name: &str, values: &[f64], most: f64| {
            let value = *values.get(index).ok_or_else(|| format!("{name} of {} is missing", axis.joint()))?;
            let value = core_from_si(axis, value);
            // The way through metres may cost the last bit.
            if value > 0.0 && value <= most * (1.0 + 1e-12) {
                Ok(value.min(most))
            } else {
                Err(format!("{name} of {} is {value}, the machine allows {most}", axis.joint()))
            }
        };
        Ok(MotionLimits {
            velocity: value("velocity", &message.velocity, own.velocity)?,
            acceleration: value("acceleration", &message.acceleration, own.acceleration)?,
            jerk: value("jerk", &message.jerk, own.jerk)?,
        })
    };
    let target = |index: usize| message.target_counts.get(index).copied().ok_or("target_counts are missing");
    let spline = |id: u32, kind: u8| match place.get(id as usize) {
        Some((found, index)) if *found == kind => Ok(*index),
        _ => Err(format!("there is no spline {id} of kind {kind}")),
    };
    match message.kind {
        PlanSegment::MOVE => (0..message.joints.len())
            .map(|index| {
                let axis = axis(index)?;
                Ok(AxisTarget { axis, target_counts: target(index)?, limits: limits(index, axis)? })
            })
            .collect::<Result<_, String>>()
            .map(SegmentKind::Move),
        PlanSegment::SEARCH => {
            let axis = axis(0)?;
            Ok(SegmentKind::Search {
                axis,
                input: message.input.clone(),
                travel_counts: target(0)?,
                offset_counts: target(1)?,
                limits: limits(0, axis)?,
            })
        }
        PlanSegment::CUT => Ok(SegmentKind::Cut(CutSegment {
            path: spline(message.path, PlanSpline::PERIODIC_PATH)?,
            speed: spline(message.speed, PlanSpline::TIME_LAW)?,
            infeed: spline(message.infeed, PlanSpline::ANGLE_LAW)?,
            ratio: match u32::try_from(message.ratio) {
                Ok(ratio) => Some(spline(ratio, PlanSpline::PERIODIC_RATIO)?),
                Err(_) => None,
            },
            lead: match u32::try_from(message.lead) {
                Ok(lead) => Some(spline(lead, PlanSpline::TIME_LAW)?),
                Err(_) => None,
            },
            start_counts: message.start_counts,
            path_start_rad: finite("path_start", message.path_start)?,
            turns: whole("turns", message.turns)?,
            infeed_turns: whole("infeed_turns", message.infeed_turns)?,
            plateau_s: (finite("plateau_start", message.plateau_start)?, finite("plateau_end", message.plateau_end)?),
            turn_s: finite("turn_time", message.turn_time)?,
            retract_mm: mm_from_m(finite("retract", message.retract)?),
            hold_mm: mm_from_m(finite("hold", message.hold)?),
            until_steady_n: Some(whole("until_steady", message.until_steady)?).filter(|most_n| *most_n > 0),
        })),
        PlanSegment::SPIRAL => Ok(SegmentKind::Spiral(SpiralSegment {
            path: spline(message.path, PlanSpline::ANGLE_LAW)?,
            advance: spline(message.infeed, PlanSpline::ANGLE_LAW)?,
            speed: spline(message.speed, PlanSpline::TIME_LAW)?,
            start_counts: message.start_counts,
        })),
        PlanSegment::DWELL => Ok(SegmentKind::Dwell),
        PlanSegment::WAIT => Ok(SegmentKind::Wait),
        PlanSegment::COMMAND => match message.command {
            MachineCommand::SET_HOME => Axis::from_joint(&message.target)
                .map(|axis| SegmentKind::Command(Command::SetHome(axis)))
                .ok_or_else(|| format!("there is no joint {:?} to home", message.target)),
            MachineCommand::WHEEL_START => Ok(SegmentKind::Command(Command::WheelStart)),
            MachineCommand::WHEEL_STOP => Ok(SegmentKind::Command(Command::WheelStop)),
            MachineCommand::EXPECT_WHEEL => {
                Ok(SegmentKind::Command(Command::ExpectWheel { radius_nm: radius_nm(target(0)?)? }))
            }
            MachineCommand::DRESS => Ok(SegmentKind::Command(Command::Dress { radius_nm: radius_nm(target(0)?)? })),
            MachineCommand::PUSH => Ok(SegmentKind::Command(Command::Push { most_n: force_n(target(0)?)? })),
            MachineCommand::WATCH_FORCE => {
                Ok(SegmentKind::Command(Command::WatchForce { most_n: force_n(target(0)?)? }))
            }
            other => Err(format!("its command is {other}")),
        },
        other => Err(format!("its kind is {other}")),
    }
}

/// A force of up to 100 kN: what is larger was not meant.
fn force_n(most_n: i64) -> Result<i64, String> {
    if (0..=100_000).contains(&most_n) { Ok(most_n) } else { Err(format!("its force is {most_n} N")) }
}

/// A wheel of up to 10 m: what is larger was not meant.
fn radius_nm(radius_nm: i64) -> Result<i64, String> {
    if (1..=10_000_000_000).contains(&radius_nm) {
        Ok(radius_nm)
    } else {
        Err(format!("its wheel has a radius of {radius_nm} nm"))
    }
}

fn whole(name: &str, value: f64) -> Result<u32, String> {
    #[allow(clippy::cast_possible_truncation, reason = "checked to be whole and in range")]
    if value.fract().abs() < f64::EPSILON && (0.0..=1e9).contains(&value) {
        Ok(value as u32)
    } else {
        Err(format!("{name} is {value}, not a whole number"))
    }
}
