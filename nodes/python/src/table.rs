// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of numbers as NumPy arrays.

use camwright_planning as planning;
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList};

/// Columns of equal length by name, with their units.
#[pyclass(name = "Table", frozen, mapping, module = "camwright")]
#[derive(Debug)]
pub(crate) struct PyTable {
    columns: Py<PyDict>,
    #[pyo3(get)]
    units: Py<PyDict>,
}

impl PyTable {
    pub(crate) fn new(py: Python<'_>, table: planning::NumberTable) -> PyResult<Self> {
        let (columns, units) = (PyDict::new(py), PyDict::new(py));
        for column in table.into_columns() {
            units.set_item(column.name, column.unit)?;
            columns.set_item(column.name, PyArray1::from_vec(py, column.values))?;
        }
        Ok(Self { columns: columns.unbind(), units: units.unbind() })
    }
}

#[pymethods]
impl PyTable {
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let columns = self.columns.bind(py);
        columns.get_item(name)?.ok_or_else(|| {
            let names: Vec<String> = columns.keys().iter().map(|name| name.to_string()).collect();
            PyKeyError::new_err(format!("no column {name:?}; there are {}", names.join(", ")))
        })
    }

    fn __len__(&self, py: Python<'_>) -> usize {
        self.columns.bind(py).len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.columns.bind(py).keys().try_iter()
    }

    fn __contains__(&self, py: Python<'_>, name: &Bound<'_, PyAny>) -> PyResult<bool> {
        self.columns.bind(py).contains(name)
    }

    fn keys<'py>(&self, py: Python<'py>) -> Bound<'py, PyList> {
        self.columns.bind(py).keys()
    }

    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyList> {
        self.columns.bind(py).values()
    }

    fn items<'py>(&self, py: Python<'py>) -> Bound<'py, PyList> {
        self.columns.bind(py).items()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let columns = self.columns.bind(py);
        let rows = columns.values().iter().next().map_or(Ok(0), |values| values.len())?;
        let names: Vec<String> = columns.keys().iter().map(|name| name.to_string()).collect();
        Ok(format!("<Table of {rows} rows: {}>", names.join(", ")))
    }
}
