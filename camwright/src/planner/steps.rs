// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The steps that every cycle is made of, whatever the tool, with the time each is predicted to take.

use super::error::PlanError;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use crate::math::hermite::HermiteSpline;
use crate::math::units::{TURN_RAD, wrap_turn};
use crate::motion::path_stop::path_stop_s;
use crate::motion::plan::{AxisTarget, Phase, Plan, PlanCommand, Segment, SegmentKind};
use crate::motion::point_to_point::{MOVE_SHARE, MoveLaw, PointToPointError, rest_to_rest, velocity_ramp, whole_ticks};
use alloc::string::String;
use alloc::vec::Vec;

/// Turns in which the search for the origin must meet it: one, and a quarter for a start inside its window.
const HOMING_TURNS: f64 = 1.25;

/// Who a step is for.
#[derive(Clone, Copy)]
pub(super) struct StepSubject<'a> {
    pub(super) phase: Phase,
    pub(super) lobe: Option<(usize, &'a str)>,
    pub(super) stock_mm: f64,
}

impl<'a> StepSubject<'a> {
    pub(super) const fn lobe(phase: Phase, index: usize, name: &'a str) -> Self {
        Self { phase, lobe: Some((index, name)), stock_mm: 0.0 }
    }

    pub(super) const fn part(phase: Phase) -> Self {
        Self { phase, lobe: None, stock_mm: 0.0 }
    }
}

/// A plan in the making: its steps so far, where they leave the axes (counts), and how long they take.
pub(super) struct PlanSteps<'a> {
    pub(super) machine: &'a MachineDescription,
    pub(super) at: [i64; AXIS_COUNT],
    pub(super) ticks: u64,
    pub(super) plan: Plan,
}

impl PlanSteps<'_> {
    /// C on its origin, from where it stands, or half a turn away if unknown; then its keyway faces the tool.
    pub(super) fn home_headstock(&mut self, of: StepSubject<'_>, c_homed: bool) -> Result<(), PlanError> {
        let distance = if c_homed {
            wrap_turn(-self.machine.axis(Axis::C).scale.position(self.at[Axis::C.index()]))
        } else {
            0.5 * TURN_RAD
        };
        // The latch catches the index mark at the window's centre, where the keyway faces the wheel.
        self.search(of, Axis::C, "origin", HOMING_TURNS * TURN_RAD, distance, 0, "headstock to its origin")?;
        self.at[Axis::C.index()] = 0;
        self.command(of, PlanCommand::SetHome(Axis::C), "origin is zero");
        self.move_axis(of, Axis::C, 0, None, "key-way to the wheel")
    }

    /// Starts the mounted wheel, or a lathe's driven insert; a clamped insert has nothing to start.
    pub(super) fn start_wheel(&mut self, of: StepSubject<'_>) {
        if !self.machine.cuts_at_rest() {
            self.start_wheel_in(of, self.machine.wheel.spin_up_s);
        }
    }

    /// Starts a wheel that needs this time (s).
    pub(super) fn start_wheel_in(&mut self, of: StepSubject<'_>, spin_up_s: f64) {
        self.command(of, PlanCommand::WheelStart, "wheel start");
        let spin_up = whole_ticks(spin_up_s, self.machine.cycle_time_s());
        self.add(of, SegmentKind::Dwell, spin_up, 0, "wheel to its speed");
    }

    pub(super) fn counts(&self, axis: Axis, position: f64) -> i64 {
        self.machine.axis(axis).scale.counts(position)
    }

    /// Overtravel of an axis after an edge at a speed: until the edge is reported, and until the axis stands.
    pub(super) fn overshoot(&self, axis: Axis, speed: f64) -> f64 {
        let limits = self.machine.axis(axis).limits;
        let known_s = f64::from(self.machine.feedback_delay_ticks + 2) * self.machine.cycle_time_s();
        // A stop takes v/a + a/j at most, at half the speed in the mean; doubled for the share that moves leave unused.
        speed * known_s + speed * (speed / limits.acceleration + limits.acceleration / limits.jerk)
    }

    pub(super) fn add(&mut self, of: StepSubject<'_>, kind: SegmentKind, ticks: u64, stop_ticks: u64, label: &str) {
        let label = match of.lobe {
            Some((_, name)) => alloc::format!("{name}: {label}"),
            None => String::from(label),
        };
        self.ticks += ticks;
        self.plan.segments.push(Segment {
            kind,
            phase: of.phase,
            lobe: of.lobe.map(|(index, _)| index),
            label,
            ticks,
            stop_ticks,
            stock_mm: of.stock_mm,
        });
    }

    pub(super) fn command(&mut self, of: StepSubject<'_>, command: PlanCommand, label: &str) {
        // To the machine and back.
        let ticks = 2 * u64::from(self.machine.feedback_delay_ticks).max(1);
        self.add(of, SegmentKind::Command(command), ticks, 0, label);
    }

    pub(super) fn move_axis(
        &mut self,
        of: StepSubject<'_>,
        axis: Axis,
        target_counts: i64,
        speed: Option<f64>,
        label: &str,
    ) -> Result<(), PlanError> {
        let own = self.machine.axis(axis).limits;
        let limits = speed.map_or(own, |speed| own.at_most(speed));
        self.move_axes(of, alloc::vec![AxisTarget { axis, target_counts, limits }], label)
    }

    /// All axes start and arrive together.
    pub(super) fn move_axes(
        &mut self,
        of: StepSubject<'_>,
        targets: Vec<AxisTarget>,
        label: &str,
    ) -> Result<(), PlanError> {
        let (ticks, stop_ticks) = self.time_of_move(self.at, &targets, label)?;
        for target in &targets {
            self.at[target.axis.index()] = target.target_counts;
        }
        self.add(of, SegmentKind::Move(targets), ticks, stop_ticks, label);
        Ok(())
    }

    /// Length of a stop on a path that uses [`MOVE_SHARE`] of what every axis may do (ticks); the axis that leaves no room for any.
    pub(super) fn stop_ticks(&self) -> Result<u64, Axis> {
        let mut stop_s = 0.0_f64;
        for axis in Axis::ALL {
            let own = self.machine.axis(axis).limits;
            stop_s = stop_s.max(path_stop_s(&own.with_share(MOVE_SHARE), &own).ok_or(axis)?);
        }
        Ok(whole_ticks(stop_s, self.machine.cycle_time_s()).max(1))
    }

    fn time_of_move(&self, from: [i64; AXIS_COUNT], to: &[AxisTarget], label: &str) -> Result<(u64, u64), PlanError> {
        let wrong = |source| PlanError::Move { what: String::from(label), source };
        let law = MoveLaw::new(from, to, self.machine).map_err(wrong)?;
        let cycle_time_s = self.machine.cycle_time_s();
        let ticks = law.ticks(cycle_time_s);
        let ((velocity, acceleration), line) = (law.law().peaks(), law.limits());
        let peaks = MotionLimits { velocity, acceleration, jerk: line.jerk };
        let whole =
            MotionLimits { acceleration: line.acceleration / MOVE_SHARE, jerk: line.jerk / MOVE_SHARE, ..*line };
        // A law without room for a stop is stopped by letting it end.
        let stop_ticks = path_stop_s(&peaks, &whole).map_or(ticks, |stop_s| whole_ticks(stop_s, cycle_time_s));
        Ok((ticks, stop_ticks))
    }

    /// A search with the time it takes if the edge lies `distance` ahead (mm or rad).
    #[allow(clippy::too_many_arguments, reason = "each is one field of the search")]
    pub(super) fn search(
        &mut self,
        of: StepSubject<'_>,
        axis: Axis,
        input: &str,
        travel: f64,
        distance: f64,
        offset_counts: i64,
        label: &str,
    ) -> Result<(), PlanError> {
        let description = self.machine.axis(axis);
        let limits = description.limits.at_most(description.search_velocity);
        let travel_counts = self.counts(axis, travel + self.overshoot(axis, limits.velocity));
        let mut target = self.at;
        target[axis.index()] += travel_counts;
        let whole = AxisTarget { axis, target_counts: target[axis.index()], limits };
        let (_, stop_ticks) = self.time_of_move(self.at, &[whole], label)?;
        let offset = description.scale.position(offset_counts);
        let seconds = self
            .search_s(&limits, distance, offset)
            .map_err(|source| PlanError::Move { what: String::from(label), source })?;
        let kind = SegmentKind::Search { axis, input: String::from(input), travel_counts, offset_counts, limits };
        self.add(of, kind, whole_ticks(seconds, self.machine.cycle_time_s()), stop_ticks, label);
        Ok(())
    }

    /// Run to the edge, run on until it is known and the axis stands, back to the edge plus offset.
    fn search_s(&self, limits: &MotionLimits, distance: f64, offset: f64) -> Result<f64, PointToPointError> {
        let speed = limits.velocity;
        let ramp = velocity_ramp(0.0, speed, limits)?;
        let ramp_length = ramp.knots()[ramp.knots().len() - 1].value;
        let run_s = ramp.end() + (distance - ramp_length).max(0.0) / speed;
        let known_s = f64::from(self.machine.feedback_delay_ticks) * self.machine.cycle_time_s();
        let beyond = speed * known_s + ramp_length;
        let back = rest_to_rest(offset - beyond, limits)?;
        Ok(run_s + known_s + ramp.end() + back.end())
    }

    /// The plan, with its predicted duration.
    pub(super) fn done(mut self) -> Plan {
        let duration_s = self.ticks as f64 * self.machine.cycle_time_s();
        self.plan.duration_s = duration_s;
        self.plan
    }
}

/// Index of a law among those of the plan; a new one is added.
pub(super) fn shared(laws: &mut Vec<HermiteSpline>, law: &HermiteSpline) -> usize {
    laws.iter().position(|known| known == law).unwrap_or_else(|| {
        laws.push(law.clone());
        laws.len() - 1
    })
}
