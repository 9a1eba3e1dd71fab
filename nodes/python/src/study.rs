// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Studies whose cases a scheduler spreads over many processes.

use super::error::{InputError, input_errors};
use super::overrides::overrides;
use super::simulation::results_dict;
use camwright_files::study_file::{self, Study};
use camwright_studies::{self as studies, SingleCaseError, StudyFolder};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

fn load(py: Python<'_>, file: &Path, set: Option<&Bound<'_, PyDict>>) -> PyResult<Study> {
    let (name, set) = (file.display().to_string(), overrides(set)?);
    py.detach(|| study_file::load(&name, &set)).map_err(|errors| input_errors(py, &errors))
}

/// Writes the plan of a study into a folder; returns the hashes of its cases.
#[pyfunction]
#[pyo3(signature = (file, folder, *, set=None))]
pub(crate) fn plan_study(
    py: Python<'_>,
    file: PathBuf,
    folder: PathBuf,
    set: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<String>> {
    let study = load(py, &file, set)?;
    let written = py.detach(|| {
        let cases = studies::cases(&study);
        StudyFolder::create(&folder)?.write_plan(&study, &cases)?;
        Ok::<_, studies::StudyError>(cases.into_iter().map(|case| case.hash).collect())
    });
    written.map_err(|error| PyOSError::new_err(error.to_string()))
}

/// Runs one case of a written plan and writes its files into the folder; a case that has them does not run again.
#[pyfunction]
#[pyo3(signature = (file, folder, case, *, set=None))]
pub(crate) fn run_case<'py>(
    py: Python<'py>,
    file: PathBuf,
    folder: PathBuf,
    case: &str,
    set: Option<&Bound<'_, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let study = load(py, &file, set)?;
    let single = py.detach(|| studies::run_single_case(&study, &StudyFolder::open(&folder), case));
    let single = single.map_err(|error| match error {
        SingleCaseError::Failed(error) => PyOSError::new_err(error.to_string()),
        refused => InputError::new_err(refused.to_string()),
    })?;
    let row = PyDict::new(py);
    row.set_item("case", single.case.number)?;
    row.set_item("hash", &single.case.hash)?;
    let outcome = single.outcome;
    row.set_item("status", outcome.status.name())?;
    row.set_item("reason", &outcome.reason)?;
    row.set_item("alarm", outcome.alarm)?;
    row.set_item("worst_lobe", &outcome.worst_lobe)?;
    row.update(results_dict(py, &outcome.responses)?.as_mapping())?;
    Ok(row)
}
