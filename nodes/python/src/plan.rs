// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright.plan`.

use super::check::PyFinding;
use super::error::input_error;
use super::overrides::overrides;
use super::simulation::PySimulation;
use super::table::PyTable;
use camwright_planning::{self as planning, AnyPrepared};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Planned job.
#[pyclass(name = "Plan", frozen, module = "camwright")]
#[derive(Debug)]
pub(crate) struct PyPlan(AnyPrepared);

impl PyPlan {
    /// Finds, reads and plans a job.
    pub(crate) fn new(py: Python<'_>, job: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let (job, set) = (job.display().to_string(), overrides(set)?);
        let planned = py.detach(|| planning::prepare_any(&job, &set, None));
        planned.map(Self).map_err(|error| input_error(py, error))
    }

    pub(crate) fn prepared(&self) -> &AnyPrepared {
        &self.0
    }
}

#[pymethods]
impl PyPlan {
    #[getter]
    fn job(&self) -> &str {
        self.0.name()
    }

    #[getter]
    fn machine(&self) -> &str {
        &self.0.machine().name
    }

    #[getter]
    fn source(&self) -> &str {
        self.0.source()
    }

    #[getter]
    fn plan_hash(&self) -> &str {
        self.0.plan_hash()
    }

    #[getter]
    fn job_hash(&self) -> &str {
        self.0.job_hash()
    }

    #[getter]
    fn duration_s(&self) -> f64 {
        self.0.duration_s()
    }

    #[getter]
    fn lobes(&self) -> Vec<String> {
        self.0.lobes().to_vec()
    }

    #[getter]
    fn warnings(&self, py: Python<'_>) -> Vec<PyFinding> {
        py.detach(|| self.0.warnings().iter().map(PyFinding::from).collect())
    }

    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = py.detach(|| self.0.summary_json()).map_err(|error| input_error(py, error))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    #[getter]
    fn table_names(&self) -> Vec<String> {
        self.0.table_names()
    }

    fn table(&self, py: Python<'_>, name: &str) -> PyResult<PyTable> {
        match py.detach(|| self.0.table(name)).map_err(|error| input_error(py, error))? {
            Some(table) => PyTable::new(py, table),
            None => {
                let names = self.0.table_names().join(", ");
                Err(PyKeyError::new_err(format!("{} has no table {name:?}; there are {names}", self.0.name())))
            }
        }
    }

    #[pyo3(signature = (folder, *, plots=false))]
    fn write(&self, py: Python<'_>, folder: PathBuf, plots: bool) -> PyResult<Vec<PathBuf>> {
        let mut files = Vec::new();
        let written = py.detach(|| match &self.0 {
            AnyPrepared::Ground(prepared) => {
                planning::write(prepared, &folder, plots, |path| files.push(path.to_path_buf())).map(drop)
            }
            AnyPrepared::Turned(prepared) => {
                planning::write_turning(prepared, &folder, plots, |path| files.push(path.to_path_buf())).map(drop)
            }
        });
        written.map(|()| files).map_err(|error| input_error(py, error))
    }

    fn simulate(&self, py: Python<'_>) -> PyResult<PySimulation> {
        PySimulation::new(py, self)
    }

    fn __repr__(&self) -> String {
        format!("<Plan of {}>", self.0.summary())
    }
}

/// Plans a job, by name or path.
#[pyfunction]
#[pyo3(signature = (job, *, set=None))]
pub(crate) fn plan(py: Python<'_>, job: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<PyPlan> {
    PyPlan::new(py, job, set)
}
