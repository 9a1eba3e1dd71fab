//! `camwright.plan`.

use super::check::Finding;
use super::error::input_error;
use super::overrides::overrides;
use super::simulation::Simulation;
use super::table::Table;
use camwright_planning::{self as planning, AnyPrepared};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Planned job.
#[pyclass(frozen, module = "camwright")]
#[derive(Debug)]
pub(crate) struct Plan(AnyPrepared);

impl Plan {
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
impl Plan {
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
    fn warnings(&self, py: Python<'_>) -> Vec<Finding> {
        py.detach(|| self.0.warnings().iter().map(Finding::from).collect())
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

    fn table(&self, py: Python<'_>, name: &str) -> PyResult<Table> {
        match py.detach(|| self.0.table(name)).map_err(|error| input_error(py, error))? {
            Some(table) => Table::new(py, table),
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

    fn simulate(&self, py: Python<'_>) -> PyResult<Simulation> {
        Simulation::new(py, self)
    }

    fn __repr__(&self) -> String {
        format!("<Plan of {}>", self.0.summary())
    }
}

/// Plans a job, by name or path.
#[pyfunction]
#[pyo3(signature = (job, *, set=None))]
pub(crate) fn plan(py: Python<'_>, job: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<Plan> {
    Plan::new(py, job, set)
}
