// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright.check`.

use super::error::input_error;
use super::overrides::overrides;
use camwright_planning::{self as planning, Severity};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Finding of a check.
#[pyclass(name = "Finding", frozen, get_all, module = "camwright")]
#[derive(Debug, Clone)]
pub(crate) struct PyFinding {
    severity: String,
    file: String,
    line: Option<u64>,
    message: String,
}

impl From<&planning::Finding> for PyFinding {
    fn from(finding: &planning::Finding) -> Self {
        let (place, message) = (&finding.error.place, finding.error.message.clone());
        let file = place.file.display().to_string();
        Self { severity: finding.severity.to_string(), file, line: place.line, message }
    }
}

#[pymethods]
impl PyFinding {
    fn __str__(&self) -> String {
        let line = self.line.map_or_else(String::new, |line| format!(":{line}"));
        format!("{}: {}{line}: {}", self.severity, self.file, self.message)
    }

    fn __repr__(&self) -> String {
        format!("<Finding {}>", self.__str__())
    }
}

/// Findings of a file.
#[pyclass(name = "CheckReport", frozen, get_all, module = "camwright")]
#[derive(Debug)]
pub(crate) struct PyCheckReport {
    file: String,
    is_ok: bool,
    findings: Vec<PyFinding>,
    summary: Option<String>,
    notes: Vec<String>,
}

#[pymethods]
impl PyCheckReport {
    fn __repr__(&self) -> String {
        let (verdict, count) = (if self.is_ok { "ok" } else { "errors" }, self.findings.len());
        format!("<CheckReport of {}: {verdict}, {count} findings>", self.file)
    }
}

/// Checks a job, a machine, a study or a lift table, by name or path.
#[pyfunction]
#[pyo3(signature = (name, *, set=None))]
pub(crate) fn check(py: Python<'_>, name: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<PyCheckReport> {
    let (name, set) = (name.display().to_string(), overrides(set)?);
    let report = py.detach(|| planning::check_file(&name, &set)).map_err(|error| input_error(py, error))?;
    Ok(PyCheckReport {
        file: report.file.display().to_string(),
        is_ok: report.worst() != Some(Severity::Error),
        findings: report.findings.iter().map(PyFinding::from).collect(),
        summary: report.summary,
        notes: report.notes,
    })
}
