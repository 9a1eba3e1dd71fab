// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reports of the machine as messages, and the names of its inputs.

use super::{j_m3_from_j_mm3, si_from_core, si_from_counts};
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::setpoint::{Input, Latch as CoreLatch};
use camwright::simulation::tick_report::{IoState, MotionState, TickReport};
use camwright::simulation::workpiece::CutRecord;
use camwright_msgs::camwright_msgs::msg::{Latch, MachineIo, MachineStream, PartLobe};
use camwright_msgs::sensor_msgs::msg::JointState;

/// Positions, velocities and efforts of a tick, of the axes and then of the wheel.
pub fn joint_values(machine: &MachineDescription, report: &TickReport) -> JointState {
    let axis = |axis: Axis| &report.axes[axis.index()];
    let mut message = JointState::default();
    for each in Axis::ALL {
        message.position.push(si_from_counts(machine.axis(each).scale, axis(each).counts));
        message.velocity.push(si_from_core(each, axis(each).velocity));
        message.effort.push(axis(each).effort);
    }
    // The wheel's angle means nothing; its speed does.
    message.position.push(0.0);
    message.velocity.push(report.wheel_rad_s);
    message.effort.push(0.0);
    message
}

/// Process values at every degree of a lobe over the common width (mm), as a message.
pub fn cut_of(cut: &CutRecord, common_mm: f64) -> PartLobe {
    let degrees = cut.degrees();
    PartLobe {
        power: degrees.iter().map(|at| at.power_w_mm * common_mm).collect(),
        specific_energy: degrees.iter().map(|at| j_m3_from_j_mm3(at.specific_energy_j_mm3)).collect(),
        burn_index: degrees.iter().map(|at| at.burn_index).collect(),
        normal_force: cut.forces_n().to_vec(),
        ..PartLobe::default()
    }
}

pub fn motion_number(motion: MotionState) -> u8 {
    match motion {
        MotionState::Off => MachineStream::MOTION_OFF,
        MotionState::Standstill => MachineStream::MOTION_STANDSTILL,
        MotionState::Running => MachineStream::MOTION_RUNNING,
        MotionState::Stopping => MachineStream::MOTION_STOPPING,
        MotionState::Fault => MachineStream::MOTION_FAULT,
    }
}

pub fn latch_message(latch: &CoreLatch, description: &MachineDescription) -> Latch {
    Latch {
        tick: latch.tick,
        input: input_name(latch.input, description).to_owned(),
        rising: latch.rising,
        joint: latch.axis.joint().to_owned(),
        counts: latch.counts,
    }
}

/// Names of the home switch and of the index of an axis.
const fn home_inputs(axis: Axis) -> [&'static str; 2] {
    match axis {
        Axis::C => ["c_axis home", "c_axis index"],
        Axis::X => ["x_axis home", "x_axis index"],
        Axis::Z => ["z_axis home", "z_axis index"],
    }
}

/// The input with this name.
pub fn input_named(name: &str, description: &MachineDescription) -> Option<Input> {
    let of_homing = || {
        Axis::ALL.into_iter().find_map(|axis| {
            let [home, index] = home_inputs(axis);
            if name == home { Some(Input::Home(axis)) } else { (name == index).then_some(Input::Index(axis)) }
        })
    };
    let of_station = || description.stations.iter().position(|station| station.switch == name).map(Input::Station);
    let single = [Input::Origin, Input::SteadyForce, Input::WheelContact, Input::KeyWay, Input::SizeReached];
    let of_name = |input: &Input| input_name(*input, description) == name;
    single.into_iter().find(of_name).or_else(of_homing).or_else(of_station)
}

/// Name of an input as plans and latches have it.
pub fn input_name(input: Input, description: &MachineDescription) -> &str {
    match input {
        Input::Origin => "origin",
        Input::SteadyForce => "steady_force",
        Input::WheelContact => "wheel_contact",
        Input::KeyWay => "key_way",
        Input::SizeReached => "size_reached",
        Input::Home(axis) => home_inputs(axis)[0],
        Input::Index(axis) => home_inputs(axis)[1],
        Input::Station(index) => description.stations.get(index).map_or("", |station| station.switch.as_str()),
    }
}

/// Inputs and outputs as a message, without its time.
pub fn io_message(io: &IoState, machine: &MachineDescription) -> MachineIo {
    let stations = &machine.stations;
    let others = || Input::OTHERS.iter().enumerate().filter(|(_, input)| input.is_on(machine));
    MachineIo {
        origin: io.origin,
        station_switches: stations.iter().map(|station| station.switch.clone()).collect(),
        station_states: (0..stations.len()).map(|index| io.station(index)).collect(),
        other_inputs: others().map(|(_, input)| input_name(*input, machine).to_owned()).collect(),
        other_states: others().map(|(index, _)| io.other(index)).collect(),
        overtravel_x_min: io.overtravel_x_min,
        overtravel_x_max: io.overtravel_x_max,
        overtravel_z_min: io.overtravel_z_min,
        overtravel_z_max: io.overtravel_z_max,
        estop: io.estop,
        drives_on: io.drives_on,
        wheel_running: io.wheel_running,
        part_present: io.part_present,
        ..MachineIo::default()
    }
}
