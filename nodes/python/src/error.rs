// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Exceptions of the module.

use camwright_files::ConfigError;
use camwright_planning::SimulationFailed;
use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(camwright, InputError, PyValueError, "A job, machine, study or table that cannot be used.");
create_exception!(camwright, SimulationError, PyRuntimeError, "A simulated job that made no part.");

/// Exception for files with errors. Its attributes `file`, `line` and `message` are those of the first error, its text has all.
pub(crate) fn input_errors(py: Python<'_>, errors: &[ConfigError]) -> PyErr {
    let text: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let exception = InputError::new_err(text.join("\n"));
    let Some(first) = errors.first() else { return exception };
    let set = || -> PyResult<()> {
        let value = exception.value(py);
        value.setattr("file", first.place.file.display().to_string())?;
        value.setattr("line", first.place.line)?;
        value.setattr("message", &first.message)
    };
    set().err().unwrap_or(exception)
}

/// Exception for a file with an error.
pub(crate) fn input_error(py: Python<'_>, error: ConfigError) -> PyErr {
    input_errors(py, &[error])
}

/// Exception with the attributes `job`, `reason` and `alarm`.
pub(crate) fn simulation_error(py: Python<'_>, failed: &SimulationFailed) -> PyErr {
    let exception = SimulationError::new_err(failed.to_string());
    let set = || -> PyResult<()> {
        let value = exception.value(py);
        value.setattr("job", &failed.job)?;
        value.setattr("reason", &failed.reason)?;
        value.setattr("alarm", failed.alarm)
    };
    set().err().unwrap_or(exception)
}
