// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Homing as a motion: the steps of every axis, in their sequence. The first step that fails ends it all; what was not
//! reached stays as it was, the axis that failed is not homed.

use super::PrepareError;
use crate::machine::description::{Axis, AxisScale, Homing, HomingKind, MachineDescription};
use crate::machine::setpoint::Input;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{AxisTarget, HomeStep, Phase, Plan, PlanCommand, SearchSignal, Segment, SegmentKind};
use crate::motion::point_to_point::whole_ticks;
use alloc::string::ToString;
use alloc::vec::Vec;

/// Search distance of a slide relative to its travel.
const SEARCH_SHARE: f64 = 1.1;

/// Every step for these axes: slides by their sequence, then the headstock, with the wheel out of its way. Axes that know their
/// zero by themselves are passed over.
pub(super) fn homing_plan(axes: &[Axis], machine: &MachineDescription) -> Result<Plan, PrepareError> {
    let mut plan = Plan { job: "home".to_string(), ..Plan::default() };
    let mut order: Vec<Axis> =
        Axis::ALL.into_iter().filter(|axis| axes.contains(axis) && machine.axis(*axis).needs_homing).collect();
    order.sort_by_key(|axis| match &machine.axis(*axis).homing {
        Some(homing) => (homing.sequence, axis.index()),
        None => (u32::MAX, axis.index()),
    });
    for axis in order {
        let mut steps = SearchPlan { plan: &mut plan, machine, axis };
        match machine.axis(axis).homing {
            Some(homing) => steps.slide(&homing),
            None => steps.headstock()?,
        }
    }
    Ok(plan)
}

struct SearchPlan<'a> {
    plan: &'a mut Plan,
    machine: &'a MachineDescription,
    axis: Axis,
}

impl SearchPlan<'_> {
    fn push(&mut self, kind: SegmentKind, label: &str, seconds: f64) {
        self.plan.segments.push(Segment {
            kind,
            phase: Phase::Home,
            lobe: None,
            label: label.to_string(),
            ticks: whole_ticks(seconds, self.machine.cycle_time_s()),
            stop_ticks: 1,
            stock_mm: 0.0,
        });
    }

    fn command_s(&self) -> f64 {
        2.0 * f64::from(self.machine.feedback_delay_ticks) * self.machine.cycle_time_s()
    }

    fn forget(&mut self) {
        self.push(SegmentKind::Home(HomeStep::Forget(self.axis)), "forget the zero", self.command_s());
    }

    fn set(&mut self) {
        self.push(SegmentKind::Command(PlanCommand::SetHome(self.axis)), "set the zero", self.command_s());
    }

    fn headstock(&mut self) -> Result<(), PrepareError> {
        let description = self.machine.axis(self.axis);
        let (Axis::C, AxisScale::Rotary { counts_per_turn }) = (self.axis, description.scale) else {
            return Err(PrepareError::NoReference { axis: self.axis });
        };
        let limits = description.limits.at_most(description.search_velocity);
        self.forget();
        let search = SegmentKind::Search {
            axis: self.axis,
            input: "origin".to_string(),
            travel_counts: counts_per_turn + counts_per_turn / 4,
            // The latch catches the index mark at the window's centre, which is the zero.
            offset_counts: 0,
            limits,
        };
        // On average half a turn; at the longest, a start just inside the window, a whole one.
        self.push(search, "search the origin", 0.5 * TURN_RAD / limits.velocity);
        self.set();
        Ok(())
    }

    fn seek(&mut self, input: Input, sought: SearchSignal, velocity_mm_s: f64, travel_mm: f64, label: &str) {
        let description = self.machine.axis(self.axis);
        let travel_counts = description.scale.counts(libm::copysign(travel_mm, velocity_mm_s));
        let zero_counts = description
            .homing
            .map_or(0, |homing| description.scale.counts(homing.offset_mm(self.machine.switch_hysteresis_mm)));
        let limits = description.limits.at_most(velocity_mm_s.abs());
        let step = HomeStep::Seek { axis: self.axis, input, sought, travel_counts, zero_counts, limits };
        // The position of the switch is unknown: half the travel.
        self.push(SegmentKind::Home(step), label, 0.5 * travel_mm / velocity_mm_s.abs());
    }

    fn slide(&mut self, homing: &Homing) {
        let description = self.machine.axis(self.axis);
        let (low, high) = description.overtravel.or(description.soft_limits).unwrap_or((0.0, 1000.0));
        let travel_mm = SEARCH_SHARE * (high - low);
        let (switch, index) = (Input::Home(self.axis), Input::Index(self.axis));
        let (search, latch) = (homing.search_mm_s, homing.latch_mm_s);
        let Some(kind) = homing.kind() else { return };
        self.forget();
        if kind.has_switch() {
            self.seek(switch, SearchSignal::OpeningIfClosed, -search, travel_mm, "back off the switch");
            self.seek(switch, SearchSignal::Closing, search, travel_mm, "search the switch");
            if homing.latches_closing() {
                self.seek(switch, SearchSignal::Opening, -search, travel_mm, "back off the switch");
                self.seek(switch, SearchSignal::Closing, latch, travel_mm, "latch where the switch closes");
            } else {
                self.seek(switch, SearchSignal::Opening, latch, travel_mm, "latch where the switch opens");
            }
        }
        if homing.use_index {
            self.seek(index, SearchSignal::Closing, latch, 1.5 * homing.index_pitch_mm, "latch the index");
        }
        if kind == HomingKind::Immediate {
            let counts = description.scale.counts(homing.offset_mm(self.machine.switch_hysteresis_mm));
            self.push(SegmentKind::Home(HomeStep::Here { axis: self.axis, counts }), "where it stands", 0.0);
        }
        self.set();
        let target = AxisTarget {
            axis: self.axis,
            target_counts: description.scale.counts(homing.home_mm),
            limits: description.limits.at_most(homing.final_mm_s),
        };
        self.push(SegmentKind::Move(alloc::vec![target]), "to the home position", 1.0);
    }
}
