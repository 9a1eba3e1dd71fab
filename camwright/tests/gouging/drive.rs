// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A plan through the real interpolator, with holds, overrides and cancels at any tick.

use crate::cams::SplitMix64;
use camwright::interpolator::{
    Interpolator, InterpolatorEvent, Motion, MotionOutcome, MotionRequest, Prepared, TickInputs,
};
use camwright::machine::alarm::AlarmSeverity;
use camwright::machine::description::Axis;
use camwright::motion::plan::{Plan, PlanCommand, Segment, SegmentKind};
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::{Machine, MachineCommand};
use std::sync::Arc;

/// Setpoints of one tick.
pub(crate) struct Tick<'a> {
    /// Angle of C (rad), once the headstock knows its zero in this plan.
    pub(crate) c_rad: Option<f64>,
    pub(crate) x_mm: f64,
    pub(crate) z_mm: f64,
    pub(crate) segment: &'a Segment,
    pub(crate) tick: u64,
    pub(crate) report: &'a TickReport,
}

/// Actions of an operator, by the ticks since the start: holds of any length and overrides, and at times a cancel.
pub(crate) fn requests(random: &mut SplitMix64, ticks: u64) -> Vec<(u64, MotionRequest)> {
    let mut requests = Vec::new();
    let count = random.next() % 6;
    let mut at = 0;
    for _ in 0..count {
        at += 1 + random.next() % (ticks / (count + 1)).max(1);
        match random.next() % 3 {
            0 => requests.push((at, MotionRequest::SetOverride(random.within(0.2, 1.0)))),
            _ => {
                requests.push((at, MotionRequest::Hold));
                at += 1 + random.next() % 2500;
                requests.push((at, MotionRequest::Unhold));
            }
        }
    }
    if random.next().is_multiple_of(8) {
        requests.push((1 + random.next() % ticks, MotionRequest::Cancel));
    }
    requests.sort_by_key(|(at, _)| *at);
    requests
}

/// Runs a plan to its end.
pub(crate) fn drive(
    plan: &Plan,
    interpolator: &mut Interpolator,
    machine: &mut Machine,
    requests: &[(u64, MotionRequest)],
    mut each: impl FnMut(&Tick<'_>),
) -> Result<MotionOutcome, String> {
    let description = machine.description().clone();
    let prepared = Prepared::new(Motion::Plan(Arc::new(plan.clone())), &description).map_err(|e| e.to_string())?;
    interpolator.resync(machine.setpoint().counts);
    interpolator.start(Box::new(prepared)).map_err(|(error, _)| error.to_string())?;
    let homes = |segment: &Segment| matches!(segment.kind, SegmentKind::Command(PlanCommand::SetHome(Axis::C)));
    let homed_after = plan.segments.iter().rposition(homes);
    let start = machine.tick();
    let planned: u64 = plan.segments.iter().map(|segment| segment.ticks).sum();
    let mut orders: Vec<(u64, MachineCommand)> = Vec::new();
    for tick in start + 1..start + 8 * planned + 200_000 {
        let now = requests.iter().filter(|(at, _)| start + *at == tick).map(|(_, request)| *request);
        let now: Vec<MotionRequest> = now.collect();
        let out = interpolator.step(&TickInputs { tick, requests: &now });
        orders.extend(out.orders.iter().map(|order| (order.tick, order.kind.into())));
        let due: Vec<MachineCommand> = orders.iter().filter(|(at, _)| *at == tick).map(|(_, order)| *order).collect();
        orders.retain(|(at, _)| *at > tick);
        let report = machine.step(Some(&out.setpoint), &due, &[]);
        if let Some(alarm) = report.raised.iter().find(|alarm| alarm.kind.entry().severity > AlarmSeverity::Warning) {
            return Err(format!("tick {}: alarm {}", tick - start, alarm.kind.entry().number));
        }
        report.latches.iter().for_each(|latch| {
            interpolator.feedback(latch);
        });
        let position = |axis: Axis| description.axis(axis).scale.position(out.setpoint.counts[axis.index()]);
        let index = out.status.segment.min(plan.segments.len() - 1);
        let knows_c = homed_after.is_none_or(|homed_after| index > homed_after);
        each(&Tick {
            c_rad: knows_c.then(|| position(Axis::C)),
            x_mm: position(Axis::X),
            z_mm: position(Axis::Z),
            segment: &plan.segments[index],
            tick: tick - start,
            report: &report,
        });
        let finished = out.events.iter().find_map(|event| match event {
            InterpolatorEvent::Finished(outcome) => Some(*outcome),
            _ => None,
        });
        if let Some(outcome) = finished {
            drop(interpolator.take_finished());
            for _ in 0..5000 {
                if machine.is_at_rest() {
                    break;
                }
                machine.step(None, &[], &[]);
            }
            return Ok(outcome);
        }
    }
    Err("it does not end".into())
}
