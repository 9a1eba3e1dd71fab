// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Python module `camwright`: checks, plans, simulates and studies jobs without ROS.
//!
//! The interpreter lock is released while a job is computed. `camwright.pyi` documents the module for its users.

mod check;
mod error;
mod overrides;
mod plan;
mod simulation;
mod study;
mod table;

#[pyo3::pymodule(name = "camwright")]
mod module {
    #[pymodule_export]
    use super::check::{PyCheckReport, PyFinding, check};
    #[pymodule_export]
    use super::error::{InputError, SimulationError};
    #[pymodule_export]
    use super::plan::{PyPlan, plan};
    #[pymodule_export]
    use super::simulation::{PySimulation, simulate};
    #[pymodule_export]
    use super::study::{plan_study, run_case};
    #[pymodule_export]
    use super::table::PyTable;

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "the name that Python expects")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
