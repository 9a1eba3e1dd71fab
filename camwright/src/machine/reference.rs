// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A typical cam grinding machine and a lathe, for tests and examples. The machine of a cell comes from its machine file.

use crate::machine::axial_profile::AxialProfile;
use crate::machine::description::{
    AlarmRetract, Axis, AxisDescription, AxisScale, DriveSettings, InsertDescription, InsertRotation, InsertSpindle,
    MachineDescription, MotionLimits, Station, WheelDescription,
};
use crate::math::units::{TURN_RAD, rad_from_deg, rad_s_from_rpm};
use alloc::string::String;
use alloc::vec;

/// Ordinary drives: gain and feed-forward in the middle of what shops use (engineering figures, not a maker's).
pub const ORDINARY_DRIVE: DriveSettings = DriveSettings {
    kv_1_s: 200.0,
    velocity_feed_forward: 0.99,
    acceleration_feed_forward: 0.95,
    velocity_loop_rad_s: Some(100.0 * TURN_RAD),
    ..DriveSettings::IDEAL
};

/// A cam grinder with four stations, as in JPS6156064B2, with the figures of a linear-motor machine of today.
#[must_use]
pub fn cam_grinder() -> MachineDescription {
    let station = |switch: &str, position_mm: f64| Station { switch: String::from(switch), position_mm };
    MachineDescription {
        name: String::from("reference cam grinder"),
        hash: String::new(),
        cycle_time_ns: 1_000_000,
        feedback_delay_ticks: 20,
        servo_steps_per_tick: 4,
        axes: [headstock(), wheelhead(), table()],
        stations: vec![station("LS1", 60.0), station("LS2", 110.0), station("LS3", 160.0), station("LS4", 210.0)],
        dog_length_mm: 8.0,
        switch_hysteresis_mm: 0.5,
        origin_half_window_rad: rad_from_deg(0.5),
        wheel: grinding_wheel(),
        insert: None,
        wheel_changer: None,
        contact: None,
        workholding: None,
        thermal: None,
        gauge: None,
        gap_detector: None,
        key_way_probe: None,
        loading: None,
        process: None,
        retract: AlarmRetract::default(),
        dresser: None,
        headstock: None,
        tailstock: None,
        rotation_sense: 1,
    }
}

fn headstock() -> AxisDescription {
    AxisDescription {
        axis: Axis::C,
        scale: AxisScale::Rotary { counts_per_turn: 3_600_000 },
        limits: MotionLimits { velocity: rad_s_from_rpm(300.0), acceleration: 300.0, jerk: 3.0e4 },
        soft_limits: None,
        overtravel: None,
        max_following_error: 0.2,
        min_following_error: 0.01,
        needs_homing: true,
        homing: None,
        search_velocity: rad_s_from_rpm(20.0),
        drive: ORDINARY_DRIVE,
        good_drive: None,
        inertia: 0.05,
        power_up_position: rad_from_deg(217.3),
    }
}

fn wheelhead() -> AxisDescription {
    AxisDescription {
        axis: Axis::X,
        scale: AxisScale::Linear { counts_per_mm: 100_000 },
        limits: MotionLimits { velocity: 500.0, acceleration: 1.0e4, jerk: 1.0e6 },
        soft_limits: Some((5.0, 250.0)),
        overtravel: Some((3.0, 255.0)),
        max_following_error: 4.0,
        min_following_error: 0.2,
        needs_homing: false,
        homing: None,
        search_velocity: 20.0,
        drive: ORDINARY_DRIVE,
        good_drive: None,
        inertia: 400.0,
        power_up_position: 120.0,
    }
}

fn table() -> AxisDescription {
    AxisDescription {
        axis: Axis::Z,
        scale: AxisScale::Linear { counts_per_mm: 10_000 },
        limits: MotionLimits { velocity: 300.0, acceleration: 3.0e3, jerk: 1.0e5 },
        soft_limits: Some((-20.0, 400.0)),
        overtravel: Some((-30.0, 410.0)),
        max_following_error: 3.0,
        min_following_error: 0.2,
        needs_homing: false,
        homing: None,
        search_velocity: 50.0,
        drive: ORDINARY_DRIVE,
        good_drive: None,
        inertia: 600.0,
        power_up_position: 0.0,
    }
}

fn grinding_wheel() -> WheelDescription {
    WheelDescription {
        new_radius_mm: 60.0,
        min_radius_mm: 45.0,
        width_mm: 20.0,
        surface_speed_m_s: 100.0,
        spin_up_s: 2.0,
        max_surface_speed_m_s: None,
        max_speed_rad_s: None,
        grinding_ratio: None,
        unbalance_mm: 0.0,
        rim: AxialProfile::default(),
    }
}

/// A lathe with a light tool slide on a linear motor, the chuck on the Z slide and a round, driven insert 14 mm below the axis, as
/// JP2012-71381A has it; with the same ordinary drives. The figures are engineering memory, not a maker's.
#[must_use]
pub fn lathe() -> MachineDescription {
    let grinder = cam_grinder();
    let [c, x, z] = grinder.axes;
    let insert = InsertDescription {
        radius_mm: 8.0,
        height_mm: -14.0,
        height_range_mm: (-30.0, 30.0),
        relief_rad: rad_from_deg(7.0),
        edge: None,
        spindle: Some(InsertSpindle {
            surface_speed_m_s: 2.0,
            spin_up_s: 1.0,
            max_speed_rad_s: Some(rad_s_from_rpm(6000.0)),
            rotation: InsertRotation::Clockwise,
        }),
    };
    MachineDescription {
        name: String::from("reference lathe"),
        axes: [
            AxisDescription {
                limits: MotionLimits { velocity: rad_s_from_rpm(600.0), acceleration: 600.0, jerk: 6.0e4 },
                inertia: 0.02,
                ..c
            },
            AxisDescription {
                limits: MotionLimits { velocity: 1000.0, acceleration: 2.0e4, jerk: 4.0e6 },
                soft_limits: Some((8.5, 120.0)),
                overtravel: Some((8.2, 122.0)),
                inertia: 25.0,
                power_up_position: 100.0,
                ..x
            },
            AxisDescription {
                limits: MotionLimits { velocity: 250.0, acceleration: 2.0e3, jerk: 1.0e5 },
                inertia: 150.0,
                ..z
            },
        ],
        stations: vec![],
        wheel: insert.tool(),
        insert: Some(insert),
        ..grinder
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::description::DescriptionError;

    #[test]
    fn the_reference_machine_is_one_and_each_broken_figure_is_named() {
        assert_eq!(cam_grinder().validate(), Ok(()));
        let mut machine = cam_grinder();
        machine.axes[1].soft_limits = Some((9.0, 5.0));
        assert_eq!(machine.validate(), Err(DescriptionError::NotOrdered { what: "soft limits", low: 9.0, high: 5.0 }));
        let mut machine = cam_grinder();
        machine.rotation_sense = 0;
        assert_eq!(machine.validate(), Err(DescriptionError::RotationSense { sense: 0 }));
        let mut machine = cam_grinder();
        machine.servo_steps_per_tick = 0;
        assert_eq!(machine.validate(), Err(DescriptionError::NotPositive { what: "servo steps per tick", value: 0.0 }));
    }

    #[test]
    fn a_lathe_has_an_insert_and_nothing_that_only_a_grinder_has() {
        assert_eq!(lathe().validate(), Ok(()));
        assert!(lathe().is_lathe() && !cam_grinder().is_lathe());
        let growing = MachineDescription { wheel: cam_grinder().wheel, ..lathe() };
        assert_eq!(growing.validate(), Err(DescriptionError::OnlyOfAGrinder { what: "a wheel" }));
        let dresser = crate::machine::fixture::Dresser {
            x_mm: 50.0,
            z_mm: 10.0,
            width_mm: 5.0,
            infeed_speed_mm_s: 1.0,
            traverse_speed_mm_s: 1.0,
            dwell_s: 0.1,
            max_depth_mm: 0.1,
        };
        let dressed = MachineDescription { dresser: Some(dresser), ..lathe() };
        assert_eq!(dressed.validate(), Err(DescriptionError::OnlyOfAGrinder { what: "a dresser" }));
    }

    #[test]
    fn a_rake_face_goes_where_the_tool_can_be_set_only() {
        let height = |machine: MachineDescription| machine.insert.map(|insert| insert.height_mm);
        assert_eq!(lathe().with_rake_height(5.0).map(height), Ok(Some(5.0)));
        assert!(matches!(lathe().with_rake_height(31.0), Err(DescriptionError::Outside { value: 31.0, .. })));
        assert!(lathe().with_rake_height(f64::NAN).is_err());
        assert_eq!(cam_grinder().with_rake_height(0.0), Err(DescriptionError::NotALathe));
        let mut machine = lathe();
        machine.insert.as_mut().expect("a lathe").relief_rad = 2.0;
        assert!(matches!(machine.validate(), Err(DescriptionError::Outside { .. })));
    }
}
