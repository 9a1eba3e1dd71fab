// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The steps of a plan from messages.

use super::phase::phase_from;
use super::plan_splines::SplineIndices;
use super::{core_from_si, mm_from_m};
use camwright::job::grinding::{SLOWER_SHARES, VARIATION_PERIODS_TURNS};
use camwright::job::speed_variation::SpeedVariation;
use camwright::machine::description::{Axis, MAX_WHEELS, MachineDescription, MotionLimits};
use camwright::motion::plan::{
    AxisTarget, CutSegment, GaugeSize, Plan, PlanCommand, Segment, SegmentKind, SpiralSegment,
};
use camwright_msgs::camwright_msgs::msg::{MachineCommand, PlanSegment, PlanSpline};

/// The step that a message means; `splines` are those of the plan's pages.
pub(super) fn segment_from(
    message: &PlanSegment,
    splines: &SplineIndices,
    plan: &Plan,
    machine: &MachineDescription,
) -> Result<Segment, String> {
    let lobe = usize::try_from(message.lobe).ok();
    if let Some(lobe) = lobe.filter(|lobe| *lobe >= plan.lobes.len()) {
        return Err(format!("lobe {lobe} of {} lobes", plan.lobes.len()));
    }
    Ok(Segment {
        kind: SegmentReader { message, splines, machine }.kind()?,
        phase: phase_from(message.phase).ok_or_else(|| format!("its phase is {}", message.phase))?,
        lobe,
        label: message.label.clone(),
        ticks: message.ticks,
        stop_ticks: message.stop_ticks,
        stock_mm: mm_from_m(finite("stock_at_start", message.stock_at_start)?),
    })
}

/// Reads what a step does from its message.
struct SegmentReader<'a> {
    message: &'a PlanSegment,
    splines: &'a SplineIndices,
    machine: &'a MachineDescription,
}

impl SegmentReader<'_> {
    fn kind(&self) -> Result<SegmentKind, String> {
        match self.message.kind {
            PlanSegment::MOVE => self.targets().map(SegmentKind::Move),
            PlanSegment::SEARCH => self.search(),
            PlanSegment::CUT => self.cut().map(SegmentKind::Cut),
            PlanSegment::SPIRAL => self.spiral().map(SegmentKind::Spiral),
            PlanSegment::DWELL => Ok(SegmentKind::Dwell),
            PlanSegment::WAIT => Ok(SegmentKind::Wait),
            PlanSegment::COMMAND => self.command().map(SegmentKind::Command),
            other => Err(format!("its kind is {other}")),
        }
    }

    fn targets(&self) -> Result<Vec<AxisTarget>, String> {
        let target = |index: usize| {
            let axis = self.axis(index)?;
            Ok(AxisTarget { axis, target_counts: self.target(index)?, limits: self.limits(index, axis)? })
        };
        (0..self.message.joints.len()).map(target).collect()
    }

    fn search(&self) -> Result<SegmentKind, String> {
        let axis = self.axis(0)?;
        Ok(SegmentKind::Search {
            axis,
            input: self.message.input.clone(),
            travel_counts: self.target(0)?,
            offset_counts: self.target(1)?,
            limits: self.limits(0, axis)?,
        })
    }

    fn cut(&self) -> Result<CutSegment, String> {
        let message = self.message;
        Ok(CutSegment {
            path: self.splines.find(message.path, PlanSpline::PERIODIC_PATH)?,
            speed: self.splines.find(message.speed, PlanSpline::TIME_LAW)?,
            infeed: self.splines.find(message.infeed, PlanSpline::ANGLE_LAW)?,
            ratio: self.optional_spline(message.ratio, PlanSpline::PERIODIC_RATIO)?,
            lead: self.optional_spline(message.lead, PlanSpline::TIME_LAW)?,
            start_counts: message.start_counts,
            path_start_rad: finite("path_start", message.path_start)?,
            turns: whole("turns", message.turns)?,
            infeed_turns: whole("infeed_turns", message.infeed_turns)?,
            plateau_s: (finite("plateau_start", message.plateau_start)?, finite("plateau_end", message.plateau_end)?),
            turn_s: finite("turn_time", message.turn_time)?,
            retract_mm: mm_from_m(finite("retract", message.retract)?),
            hold_mm: mm_from_m(finite("hold", message.hold)?),
            until_steady_n: Some(whole("until_steady", message.until_steady)?).filter(|max_n| *max_n > 0),
            variation: variation(&message.velocity)?,
        })
    }

    fn spiral(&self) -> Result<SpiralSegment, String> {
        let message = self.message;
        Ok(SpiralSegment {
            path: self.splines.find(message.path, PlanSpline::ANGLE_LAW)?,
            advance: self.splines.find(message.infeed, PlanSpline::ANGLE_LAW)?,
            speed: self.splines.find(message.speed, PlanSpline::TIME_LAW)?,
            start_counts: message.start_counts,
        })
    }

    fn command(&self) -> Result<PlanCommand, String> {
        Ok(match self.message.command {
            MachineCommand::SET_HOME => {
                let joint = &self.message.target;
                let axis = Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?} to home"))?;
                PlanCommand::SetHome(axis)
            }
            MachineCommand::WHEEL_START => PlanCommand::WheelStart,
            MachineCommand::WHEEL_STOP => PlanCommand::WheelStop,
            MachineCommand::EXPECT_WHEEL => PlanCommand::ExpectWheel { radius_nm: radius_nm(self.target(0)?)? },
            MachineCommand::CHANGE_WHEEL => PlanCommand::ChangeWheel { wheel: wheel(self.target(0)?)? },
            MachineCommand::DRESS => PlanCommand::Dress { radius_nm: radius_nm(self.target(0)?)? },
            MachineCommand::PUSH => PlanCommand::Push { max_n: force_n(self.target(0)?)? },
            MachineCommand::WATCH_FORCE => PlanCommand::WatchForce { max_n: force_n(self.target(0)?)? },
            MachineCommand::WATCH_SIZE => PlanCommand::WatchSize(GaugeSize {
                diameter_nm: size_nm("diameter", self.target(0)?)?,
                beyond_nm: size_nm("infeed beyond the size", self.target(1)?)?,
            }),
            other => return Err(format!("its command is {other}")),
        })
    }

    fn axis(&self, index: usize) -> Result<Axis, String> {
        let joint = self.message.joints.get(index).ok_or("joints are missing")?;
        Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}"))
    }

    fn target(&self, index: usize) -> Result<i64, String> {
        self.message.target_counts.get(index).copied().ok_or_else(|| "target_counts are missing".to_owned())
    }

    fn limits(&self, index: usize, axis: Axis) -> Result<MotionLimits, String> {
        let own = self.machine.axis(axis).limits;
        let value = |name: &str, values: &[f64], max: f64| {
            let value = *values.get(index).ok_or_else(|| format!("{name} of {} is missing", axis.joint()))?;
            let value = core_from_si(axis, value);
            // The way through metres may cost the last bit.
            if value > 0.0 && value <= max * (1.0 + 1e-12) {
                Ok(value.min(max))
            } else {
                Err(format!("{name} of {} is {value}, the machine allows {max}", axis.joint()))
            }
        };
        Ok(MotionLimits {
            velocity: value("velocity", &self.message.velocity, own.velocity)?,
            acceleration: value("acceleration", &self.message.acceleration, own.acceleration)?,
            jerk: value("jerk", &self.message.jerk, own.jerk)?,
        })
    }

    /// Index in the plan of a spline; a negative id is none.
    fn optional_spline(&self, id: i32, kind: u8) -> Result<Option<usize>, String> {
        u32::try_from(id).ok().map(|id| self.splines.find(id, kind)).transpose()
    }
}

fn finite(name: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{name} is {value}")) }
}

/// Slower part and period of a variation of the work speed; none without values.
fn variation(values: &[f64]) -> Result<Option<SpeedVariation>, String> {
    let is_within = |value: f64, (low, high): (f64, f64)| (low..=high).contains(&value);
    match *values {
        [] => Ok(None),
        [slower, period_turns]
            if is_within(slower, SLOWER_SHARES) && is_within(period_turns, VARIATION_PERIODS_TURNS) =>
        {
            Ok(Some(SpeedVariation { slower, period_turns }))
        }
        _ => Err(format!(
            "its variation of the work speed is {values:?}, not a part of {SLOWER_SHARES:?} and a period of {VARIATION_PERIODS_TURNS:?} turns"
        )),
    }
}

/// A force of up to 100 kN: what is larger was not meant.
fn force_n(max_n: i64) -> Result<i64, String> {
    if (0..=100_000).contains(&max_n) { Ok(max_n) } else { Err(format!("its force is {max_n} N")) }
}

fn wheel(wheel: i64) -> Result<u32, String> {
    let index = u32::try_from(wheel).ok().filter(|index| (*index as usize) < MAX_WHEELS);
    index.ok_or_else(|| format!("its wheel is {wheel}; a changer has wheels 0 to {}", MAX_WHEELS - 1))
}

/// A wheel of up to 10 m: what is larger was not meant.
fn radius_nm(radius_nm: i64) -> Result<i64, String> {
    if (1..=10_000_000_000).contains(&radius_nm) {
        Ok(radius_nm)
    } else {
        Err(format!("its wheel has a radius of {radius_nm} nm"))
    }
}

/// A length of up to 20 m: what is larger was not meant.
fn size_nm(name: &str, nm: i64) -> Result<i64, String> {
    if (0..=20_000_000_000).contains(&nm) { Ok(nm) } else { Err(format!("its {name} is {nm} nm")) }
}

fn whole(name: &str, value: f64) -> Result<u32, String> {
    #[allow(clippy::cast_possible_truncation, reason = "checked to be whole and in range")]
    if value.fract().abs() < f64::EPSILON && (0.0..=1e9).contains(&value) {
        Ok(value as u32)
    } else {
        Err(format!("{name} is {value}, not a whole number"))
    }
}
