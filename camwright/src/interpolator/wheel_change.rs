// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A wheel change that no job asks for, as a plan of its own.

use super::setup::{push_step, push_wheel};
use crate::machine::description::{Axis, MachineDescription, WheelsNow};
use crate::machine::wheel_state::nm_from_mm;
use crate::motion::plan::{AxisTarget, Half, Phase, Plan, PlanCommand, SegmentKind};
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use thiserror::Error;

/// Why the wheel is not changed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WheelChangeError {
    /// There is one wheel.
    #[error("machine {machine} has no wheel_changer")]
    NoChanger { machine: String },
    /// No wheel has this name.
    #[error("there is no wheel {name:?}; machine {machine} has {known}")]
    UnknownWheel { name: String, machine: String, known: String },
    /// The wheel is on the spindle already.
    #[error("wheel {name} is mounted already")]
    Mounted { name: String },
}

/// Plan that mounts the wheel with this name: X to the far end of its travel, the wheel to rest, the change.
///
/// # Errors
/// No changer, an unknown wheel, or one that is mounted.
pub fn plan_wheel_change(
    machine: &MachineDescription,
    wheels: &WheelsNow,
    name: &str,
) -> Result<Plan, WheelChangeError> {
    let Some(changer) = &machine.wheel_changer else {
        return Err(WheelChangeError::NoChanger { machine: machine.name.clone() });
    };
    let Some(position) = changer.position(name) else {
        let known: Vec<&str> = changer.wheels.iter().map(|wheel| wheel.name.as_str()).collect();
        let (name, machine) = (name.to_string(), machine.name.clone());
        return Err(WheelChangeError::UnknownWheel { name, machine, known: known.join(", ") });
    };
    if position == machine.mounted_wheel() {
        return Err(WheelChangeError::Mounted { name: name.to_string() });
    }
    let mut plan = Plan { job: String::from("change_wheel"), half: Half::NoPart, ..Plan::default() };
    let x = machine.axis(Axis::X);
    let clear_mm = x.soft_limits.map_or(changer.min_x_mm, |(_, high_mm)| high_mm);
    let clear = AxisTarget { axis: Axis::X, target_counts: x.scale.counts(clear_mm), limits: x.limits };
    let order_s = 2.0 * f64::from(machine.feedback_delay_ticks) * machine.cycle_time_s();
    let expect = |radius_mm: f64| SegmentKind::Command(PlanCommand::ExpectWheel { radius_nm: nm_from_mm(radius_mm) });
    push_step(&mut plan, expect(wheels.mounted.radius_mm), Phase::WheelChange, order_s, "mounted wheel", machine);
    push_step(
        &mut plan,
        SegmentKind::Move(alloc::vec![clear]),
        Phase::WheelChange,
        0.0,
        "wheel clear of the part",
        machine,
    );
    push_wheel(&mut plan, false, machine);
    let wheel = u32::try_from(position).unwrap_or(u32::MAX);
    let change = SegmentKind::Command(PlanCommand::ChangeWheel { wheel });
    push_step(&mut plan, change, Phase::WheelChange, order_s, "change the wheel", machine);
    push_step(&mut plan, SegmentKind::Dwell, Phase::WheelChange, changer.change_s, "changer", machine);
    let radius_mm = wheels.wheel(machine, position).radius_mm;
    push_step(&mut plan, expect(radius_mm), Phase::WheelChange, order_s, "new wheel", machine);
    let ticks: u64 = plan.segments.iter().map(|segment| segment.ticks).sum();
    plan.duration_s = ticks as f64 * machine.cycle_time_s();
    plan.duration_with_indexing_s = plan.duration_s;
    Ok(plan)
}
