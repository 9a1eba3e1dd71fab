// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Keys of a file that the caller sets.

use camwright_files::yaml::{YamlNode, YamlValue};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

/// Overrides as `key=value`, from a dict of keys and values, or none.
pub(crate) fn overrides(set: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<String>> {
    let Some(set) = set else { return Ok(Vec::new()) };
    let text = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key = key_text(&key)?;
        Ok(format!("{key}={}", yaml_value(&key, &value)?.to_flow()))
    };
    set.iter().map(text).collect()
}

fn key_text(key: &Bound<'_, PyAny>) -> PyResult<String> {
    let text = key.extract::<String>();
    text.map_err(|_| PyTypeError::new_err(format!("key {key} is no text; write keys such as \"infeed.total_mm\"")))
}

/// Value of a key: None, bool, int, float, str, or a list or dict of them; numbers of NumPy too.
fn yaml_value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<YamlValue> {
    let node = |value| YamlNode { line: 0, value };
    if value.is_none() {
        return Ok(YamlValue::Null);
    }
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(YamlValue::Bool(value.is_true()));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(YamlValue::Text(value.extract()?));
    }
    if let Ok(map) = value.cast::<PyDict>() {
        let entry = |(inner, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let inner = key_text(&inner)?;
            let value = yaml_value(&format!("{key}.{inner}"), &value)?;
            Ok((inner, node(value)))
        };
        return map.iter().map(entry).collect::<PyResult<_>>().map(YamlValue::Map);
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(YamlValue::Integer(whole));
    }
    if let Ok(number) = value.extract::<f64>() {
        return match number.is_finite() {
            true => Ok(YamlValue::Float(number)),
            false => Err(PyValueError::new_err(format!("{key} is {number}; a finite number is needed"))),
        };
    }
    if let Ok(items) = value.try_iter() {
        let items = items.map(|item| yaml_value(key, &item?).map(node));
        return items.collect::<PyResult<_>>().map(YamlValue::List);
    }
    let kind = value.get_type().name()?;
    Err(PyTypeError::new_err(format!("{key} is a {kind}; use a number, str, bool, None, or a list or dict of them")))
}
