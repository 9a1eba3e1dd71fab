// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Columns of a table, whatever the format of its file.

use super::values::FieldValue;

/// Type of the values of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ColumnType {
    Bool,
    /// With the width (bits).
    Signed(u8),
    Unsigned(u8),
    Float32,
    Float64,
    Text,
    List(Box<ColumnType>),
}

/// A column, named by the path of its value in the message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) kind: ColumnType,
}

impl ColumnType {
    pub(super) fn from_value(value: &FieldValue) -> Self {
        match value {
            FieldValue::Bool(_) => Self::Bool,
            FieldValue::Signed(_, bits) => Self::Signed(*bits),
            FieldValue::Unsigned(_, bits) => Self::Unsigned(*bits),
            FieldValue::Float32(_) => Self::Float32,
            FieldValue::Float64(_) => Self::Float64,
            FieldValue::Text(_) => Self::Text,
            FieldValue::List(values) => Self::List(Box::new(values.first().map_or(Self::Text, Self::from_value))),
        }
    }
}
