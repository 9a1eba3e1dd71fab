// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The description of a machine, as it publishes it.

use super::{m_from_mm, si_from_core};
use crate::machine_file;
use camwright::machine::description::{Axis, AxisScale, MachineDescription, MagazineWheel, WheelChanger};
use camwright::machine::persistent_state::PersistentState;
use camwright_msgs::camwright_msgs::msg::{
    AxisDescription, MachineDescription as DescriptionMessage, StationDescription, WheelState,
};

/// Joint name of the wheel spindle.
pub const WHEEL_JOINT: &str = "wheel_spindle";

/// Description message of a machine file and its persistent state.
#[must_use]
pub fn description_message(file: &machine_file::MachineConfig, lasting: &PersistentState) -> DescriptionMessage {
    let machine = &file.description;
    let changer = machine.wheel_changer.as_ref();
    let mounted = changer.and_then(|changer| changer.wheels.get(lasting.mounted_wheel()));
    let wheel = mounted.map_or(&machine.wheel, |mounted| &mounted.wheel);
    DescriptionMessage {
        name: machine.name.clone(),
        hash: machine.hash.clone(),
        source: file.source.clone(),
        cycle_time_ns: machine.cycle_time_ns,
        feedback_delay_ticks: machine.feedback_delay_ticks,
        axes: Axis::ALL.iter().map(|axis| axis_message(machine, *axis)).collect(),
        stations: machine
            .stations
            .iter()
            .map(|station| StationDescription {
                name: station.switch.clone(),
                table_position: m_from_mm(station.position_mm),
            })
            .collect(),
        wheel_joint: WHEEL_JOINT.to_owned(),
        wheel_radius: m_from_mm(lasting.wheel_radius_mm),
        wheel_wear: m_from_mm(lasting.wheel_wear_mm),
        lobes_since_dress: lasting.lobes_since_dress,
        parts_since_dress: lasting.parts_since_dress,
        dress_count: lasting.dress_count,
        wheel_width: m_from_mm(wheel.width_mm),
        wheel_surface_speed: wheel.surface_speed_m_s,
        rotation_sense: machine.rotation_sense,
        wheel: mounted.map(|mounted| mounted.name.clone()).unwrap_or_default(),
        wheels: changer.map(|changer| wheel_messages(changer, lasting)).unwrap_or_default(),
    }
}

fn wheel_messages(changer: &WheelChanger, lasting: &PersistentState) -> Vec<WheelState> {
    let wheels = changer.wheels.iter().enumerate();
    let message = |(position, wheel): (usize, &MagazineWheel)| {
        let state = lasting.wheel_at(position)?;
        Some(WheelState {
            name: wheel.name.clone(),
            mounted: position == lasting.mounted_wheel(),
            radius: m_from_mm(state.radius_mm),
            wear: m_from_mm(state.wear_mm),
            width: m_from_mm(wheel.wheel.width_mm),
            lobes_since_dress: state.lobes_since_dress,
            parts_since_dress: state.parts_since_dress,
            dress_count: state.dress_count,
        })
    };
    wheels.filter_map(message).collect()
}

fn axis_message(machine: &MachineDescription, axis: Axis) -> AxisDescription {
    let own = machine.axis(axis);
    let (numerator, denominator) = match own.scale {
        AxisScale::Linear { counts_per_mm } => (counts_per_mm, 1000),
        AxisScale::Rotary { counts_per_turn } => (counts_per_turn, 1),
    };
    let (low, high) = own.soft_limits.unwrap_or((0.0, 0.0));
    AxisDescription {
        joint: axis.joint().to_owned(),
        linear: matches!(own.scale, AxisScale::Linear { .. }),
        counts_per_unit_numerator: numerator,
        counts_per_unit_denominator: denominator,
        has_soft_limits: own.soft_limits.is_some(),
        soft_min: si_from_core(axis, low),
        soft_max: si_from_core(axis, high),
        max_velocity: si_from_core(axis, own.limits.velocity),
        max_acceleration: si_from_core(axis, own.limits.acceleration),
        max_jerk: si_from_core(axis, own.limits.jerk),
        max_following_error: si_from_core(axis, own.max_following_error),
        needs_homing: own.needs_homing,
    }
}
