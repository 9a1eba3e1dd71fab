// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cell at work: jobs, set-up, loading, trajectories, the machine contract.

#[path = "../../nodes/camwright/examples/trajectory_controller_bridge.rs"]
mod bridge;
#[path = "../support/cell.rs"]
mod cell;
#[path = "../support/chromium.rs"]
mod chromium;
#[path = "../../nodes/camwright/examples/loader_robot.rs"]
mod loader_robot;
#[path = "../support/mod.rs"]
mod support;
#[path = "../support/viewer_files.rs"]
mod viewer_files;
#[path = "../support/watched.rs"]
mod watched;

mod alarms_over_hal;
mod axis_interpolator;
mod batch;
mod bores;
mod contract_over_hal;
mod crank_pins;
mod fleet;
mod gateway;
mod gauge;
mod gauge_size;
mod hal;
mod interrupted;
mod job_planner;
mod joint_trajectory;
mod journals;
mod journals_over_hal;
mod loader;
mod loss_over_hal;
mod machine_contract;
mod machine_view;
mod opcua;
mod operate;
mod operator_page;
mod setup_over_hal;
mod setup_work;
mod shutdown_over_hal;
mod status_watch;
mod steady_rest;
mod tapered_lobes;
mod trajectory_controller_bridge;
mod turned_job;
mod tutorial_over_hal;
mod two_cells;
mod two_wheels;
mod wheel;
mod wide_lobes;
