// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Data exchanged between interpolator and machine, tick by tick.

use crate::machine::description::AXIS_COUNT;

/// Setpoint of every axis for one tick. Positions lie on encoder counts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setpoint {
    /// Positions (counts).
    pub counts: [i64; AXIS_COUNT],
    /// Velocities for feed-forward (mm/s or rad/s).
    pub velocity: [f64; AXIS_COUNT],
    /// Accelerations for feed-forward (mm/s² or rad/s²).
    pub acceleration: [f64; AXIS_COUNT],
}

crate::snapshot!(Setpoint { counts, velocity, acceleration } on {});

/// An input of the machine whose edges are caught.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Input {
    /// The origin detector of the headstock.
    #[default]
    Origin,
    /// The limit switch of a station, by its index in the machine description.
    Station(usize),
    /// The home switch of a slide.
    Home(crate::machine::description::Axis),
    /// The index marks of a slide's encoder.
    Index(crate::machine::description::Axis),
    /// The force monitor: the normal force has been the same over the last turn of C.
    SteadyForce,
    /// The gap detector of the wheelhead: closed while the wheel touches the part. It catches X.
    WheelContact,
    /// The switch that sees the part's keyway. It catches C.
    KeyWay,
    /// The in-process gauge has read its size: see [`crate::simulation::size_monitor`]. It catches C.
    SizeReached,
}

crate::snapshot_cases!(Input {
    0 Origin,
    1 Station(index),
    2 Home(axis),
    3 Index(axis),
    4 SteadyForce,
    5 WheelContact,
    6 KeyWay,
    7 SizeReached,
});

impl Input {
    /// Inputs that are no station and not the origin: what a machine may have in addition.
    pub const OTHERS: [Input; 5] = {
        use crate::machine::description::Axis;
        [Input::Home(Axis::X), Input::Home(Axis::Z), Input::SteadyForce, Input::WheelContact, Input::KeyWay]
    };

    /// Returns whether a machine has it.
    #[must_use]
    pub fn is_on(self, machine: &crate::machine::description::MachineDescription) -> bool {
        match self {
            Input::Origin | Input::SteadyForce => true,
            Input::Station(index) => index < machine.stations.len(),
            Input::Home(axis) => machine.axis(axis).homing.is_some(),
            Input::Index(axis) => machine.axis(axis).homing.is_some_and(|homing| homing.use_index),
            Input::WheelContact => machine.gap_detector.is_some(),
            Input::KeyWay => machine.key_way_probe.is_some(),
            Input::SizeReached => machine.gauge.is_some(),
        }
    }

    /// The axis whose position it catches.
    #[must_use]
    pub const fn axis(self) -> crate::machine::description::Axis {
        use crate::machine::description::Axis;
        match self {
            Input::Origin | Input::KeyWay | Input::SteadyForce | Input::SizeReached => Axis::C,
            Input::Station(_) => Axis::Z,
            Input::Home(axis) | Input::Index(axis) => axis,
            Input::WheelContact => Axis::X,
        }
    }
}

/// The position of an axis at the edge of an input, caught by the machine itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Latch {
    /// Tick within which the edge was seen.
    pub tick: u64,
    pub input: Input,
    /// The input closed; false: it opened.
    pub rising: bool,
    /// Axis whose position was caught.
    pub axis: crate::machine::description::Axis,
    /// Its position (counts).
    pub counts: i64,
}

crate::snapshot!(Latch { tick, input, rising, axis, counts } on {});

/// Encoder readings at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    pub tick: u64,
    /// Positions (counts).
    pub counts: [i64; AXIS_COUNT],
    /// Velocities (mm/s or rad/s).
    pub velocity: [f64; AXIS_COUNT],
}

/// A point of the stop that ends a chunk of setpoints: what the axes do if no further chunk comes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StopPoint {
    /// Ticks after the chunk's last setpoint.
    pub ticks: u32,
    /// Positions (mm or rad), not rounded to counts.
    pub position: [f64; AXIS_COUNT],
    /// Velocities (mm/s or rad/s).
    pub velocity: [f64; AXIS_COUNT],
    /// Accelerations (mm/s² or rad/s²).
    pub acceleration: [f64; AXIS_COUNT],
}
