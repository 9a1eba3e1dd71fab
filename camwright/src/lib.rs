// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plans, executes and simulates the grinding and turning of parts that are not round: cams, eccentrics, grooves and
//! the journals between them.
//!
//! The rooms stand in the order in which data flows through them. A room imports only from the rooms above it;
//! `tests/rooms.rs` checks that.
//!
//! | room | contents |
//! |---|---|
//! | [`math`] | splines, roots, banded solvers, units, snapshots of state |
//! | [`machine`] | description of a machine: axes, drives, wheel, insert, alarms, setpoints |
//! | [`cam`] | lift law, follower, contour, surface, form error, compensation |
//! | [`toolpath`] | path of a wheel, a cutter or an insert along a contour |
//! | [`gauging`] | runout and stiffness from gauge readings |
//! | [`job`] | specification of a grinding, milling or turning job |
//! | [`motion`] | plan as data, moves from point to point, speed along a path |
//! | [`gcode`] | programs for other controls: writer, post-processor, reader |
//! | [`planner`] | job to plan, with checks of the finished plan |
//! | [`interpolator`] | plan to setpoints, tick by tick |
//! | [`simulation`] | simulated machine: drives, sensors, wheel in the part, faults |
//! | [`cell`] | states of a production cell and its part loading |
//!
//! Units are mm, rad, s and N; a name with another unit says so (`_deg`, `_rpm`). Time is a tick number.
//!
//! The crate knows no ROS, file, clock or thread. The same inputs give the same bits on every computer.
//!
//! # Example
//!
//! A lobe is ground from its lift law on the simulated machine. The result is the form error of the part.
//!
//! ```
//! use camwright::cam::{follower::Follower, form::Form, form_tolerance::FormTolerance, lift::LiftLaw};
//! use camwright::interpolator::{Motion, Prepared};
//! use camwright::job::grinding::{HomePosition, InfeedCourse, InfeedDirection, JobSpec, LobeSpec, PassSpec, ProfileSpec, SpeedLaw};
//! use camwright::machine::{persistent_state::PersistentState, reference::cam_grinder};
//! use camwright::simulation::{Machine, closed_loop::ClosedLoop};
//!
//! let profile = ProfileSpec {
//!     name: "cam".into(),
//!     lift: LiftLaw::from_fn(|cam_angle| 1.5 * (1.0 - cam_angle.cos()))?,
//!     follower: Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 },
//!     base_radius_mm: 16.0,
//!     throw_mm: 0.0,
//!     is_bore: false,
//! };
//! let tolerance = FormTolerance::uniform(0.005);
//! let lobe = LobeSpec { name: "E1".into(), station: "LS1".into(), phase_rad: 0.5, profile: 0, width_mm: 15.0, tolerance, plunge: None, visit: None, axial: None };
//! let finish = PassSpec {
//!     name: "finish".into(),
//!     total_infeed_mm: 0.036,
//!     infeed_per_block_mm: 0.000_05,
//!     infeed_of_turns_mm: Vec::new(),
//!     air_mm: 0.0,
//!     infeed_course: InfeedCourse::PerAngle,
//!     infeed_direction: InfeedDirection::X,
//!     spark_out_turns: 1,
//!     spark_out_until_n: None,
//!     gauge_size: None,
//!     speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 3.0 },
//! };
//! let job = JobSpec {
//!     profiles: vec![profile],
//!     lobes: vec![lobe],
//!     blocks_per_turn: 360,
//!     rapid_advance_mm: 30.0,
//!     stock_mm: 0.02,
//!     passes: vec![finish],
//!     retract_clearance_mm: 1.0,
//!     home: HomePosition { x_mm: 120.0, z_mm: 0.0 },
//!     ..JobSpec::without_lobes("one lobe", 120.0, 100.0)
//! };
//!
//! let description = cam_grinder();
//! let planned = camwright::planner::plan_job(&job, &description, 60.0, None)?;
//! let design = &planned.lobes[0].design;
//! let mut machine = Machine::new(description.clone(), PersistentState::new(&description))?;
//! machine.load_lobe("E1", "LS1", 15.0, vec![20.0; 3600])?;
//!
//! let motion = Prepared::new(Motion::Plan(planned.plan.into()), &description)?;
//! let mut closed_loop = ClosedLoop::direct(machine);
//! closed_loop.simulate(motion.into(), |_, _| {})?;
//! let ground = closed_loop.machine().part().lobe("E1").expect("loaded above");
//! let form = Form::measure(ground.radii_mm(), &design.contour, design.phase_rad)?;
//! assert!(form.largest.deviation_mm.abs() < 0.005, "{} mm", form.largest.deviation_mm);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
extern crate alloc;

pub mod math;

pub mod machine;

pub mod cam;

pub mod toolpath;

pub mod gauging;

pub mod job;

pub mod motion;

pub mod gcode;

pub mod planner;

pub mod interpolator;

pub mod simulation;

pub mod cell;
