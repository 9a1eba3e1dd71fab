// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Table of results as Apache Parquet, with one row group.

use super::StudyError;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Values of a column, none where a row has no value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ColumnData {
    Whole(Vec<Option<i64>>),
    Number(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
}

/// Columns with their names.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ResultTable {
    pub(crate) columns: Vec<(String, ColumnData)>,
}

impl ResultTable {
    /// Writes the table as Parquet.
    pub(crate) fn write_parquet(&self, path: &Path, file: impl Write + Send) -> Result<(), StudyError> {
        self.parquet(file).map_err(|source| StudyError::Table { path: path.to_path_buf(), source })
    }

    fn parquet(&self, file: impl Write + Send) -> Result<(), ParquetError> {
        let field = |(name, data): &(String, ColumnData)| {
            let (kind, logical) = match data {
                ColumnData::Whole(_) => (Physical::INT64, None),
                ColumnData::Number(_) => (Physical::DOUBLE, None),
                ColumnData::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let builder = Type::primitive_type_builder(name, kind).with_logical_type(logical);
            builder.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
        };
        let fields = self.columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("study").with_fields(fields).build()?);
        let properties = WriterProperties::builder()
            .set_created_by(concat!("camwright ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_compression(Compression::SNAPPY)
            .build();
        let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
        let mut group = writer.next_row_group()?;
        for (_, data) in &self.columns {
            match data {
                ColumnData::Whole(values) => write::<Int64Type, _, _>(&mut group, values, |value| *value)?,
                ColumnData::Number(values) => write::<DoubleType, _, _>(&mut group, values, |value| *value)?,
                ColumnData::Text(values) => {
                    write::<ByteArrayType, _, _>(&mut group, values, |text| ByteArray::from(text.as_str()))?;
                }
            }
        }
        group.close()?;
        writer.close().map(drop)
    }
}

fn write<T: DataType, V, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[Option<V>],
    convert: impl Fn(&V) -> T::T,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Ok(()) };
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = values.iter().flatten().map(convert).collect();
    column.typed::<T>().write_batch(&present, Some(&levels), None)?;
    column.close()
}
