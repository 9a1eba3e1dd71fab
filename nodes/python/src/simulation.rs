// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright.simulate`.

use super::error::simulation_error;
use super::plan::PyPlan;
use super::table::PyTable;
use camwright_files::study_file::StudyResponse;
use camwright_studies::{SimulatedPart, simulate_part};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Part that the simulated machine made.
#[pyclass(name = "Simulation", frozen, module = "camwright")]
#[derive(Debug)]
pub(crate) struct PySimulation {
    #[pyo3(get)]
    job: String,
    part: SimulatedPart,
}

impl PySimulation {
    pub(crate) fn new(py: Python<'_>, plan: &PyPlan) -> PyResult<Self> {
        let prepared = plan.prepared();
        let part = py.detach(|| simulate_part(prepared)).map_err(|failed| simulation_error(py, &failed))?;
        Ok(Self { job: prepared.name().to_owned(), part })
    }
}

/// Results by name. A result that the job does not have is None.
pub(crate) fn results_dict<'py>(
    py: Python<'py>,
    responses: &[Option<f64>; StudyResponse::ALL.len()],
) -> PyResult<Bound<'py, PyDict>> {
    let results = PyDict::new(py);
    for (response, value) in StudyResponse::ALL.into_iter().zip(responses) {
        results.set_item(response.name(), value)?;
    }
    Ok(results)
}

#[pymethods]
impl PySimulation {
    #[getter]
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        results_dict(py, &self.part.responses)
    }

    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        for response in StudyResponse::ALL {
            units.set_item(response.name(), response.unit())?;
        }
        Ok(units)
    }

    #[getter]
    fn worst_lobe(&self) -> Option<&str> {
        self.part.worst_lobe.as_deref()
    }

    #[getter]
    fn lobes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let lobes = PyDict::new(py);
        for lobe in self.part.lobes() {
            let results = PyDict::new(py);
            for (name, value) in lobe.results() {
                results.set_item(name, value)?;
            }
            lobes.set_item(&lobe.result.name, results)?;
        }
        Ok(lobes)
    }

    #[pyo3(signature = (lobe=None))]
    fn form(&self, py: Python<'_>, lobe: Option<&str>) -> PyResult<PyTable> {
        let table = py.detach(|| self.part.form_table(lobe));
        table.map_or_else(
            || {
                let names: Vec<&str> = self.part.lobes().iter().map(|lobe| lobe.result.name.as_str()).collect();
                let message = match (names.is_empty(), lobe) {
                    (true, _) => format!("{} is one turned surface; call form() without a lobe", self.job),
                    (false, Some(lobe)) => format!("{} has no lobe {lobe:?}; there are {}", self.job, names.join(", ")),
                    (false, None) => format!("which lobe of {}? There are {}", self.job, names.join(", ")),
                };
                Err(PyKeyError::new_err(message))
            },
            |table| PyTable::new(py, table),
        )
    }

    fn __repr__(&self) -> String {
        let shown = StudyResponse::ALL
            .into_iter()
            .zip(&self.part.responses)
            .filter_map(|(response, value)| value.map(|value| format!("{} {value:.3}", response.name())));
        format!("<Simulation of {}: {}>", self.job, shown.collect::<Vec<_>>().join(", "))
    }
}

/// Plans a job, makes its part on the simulated machine and measures it. Takes a plan, or a job by name or path.
#[pyfunction]
#[pyo3(signature = (job, *, set=None))]
pub(crate) fn simulate(
    py: Python<'_>,
    job: &Bound<'_, PyAny>,
    set: Option<&Bound<'_, PyDict>>,
) -> PyResult<PySimulation> {
    match job.cast::<PyPlan>() {
        Ok(_) if set.is_some() => {
            Err(PyTypeError::new_err("a plan is complete; set keys where you plan: camwright.plan(job, set={...})"))
        }
        Ok(plan) => PySimulation::new(py, plan.get()),
        Err(_) => PySimulation::new(py, &PyPlan::new(py, job.extract::<PathBuf>()?, set)?),
    }
}
