// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables as Apache Parquet: each column with its type, values in groups of rows.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::BagError;
use super::columns::{Column, ColumnType};
use super::values::FieldValue;

/// Size of a row group, in values of eight bytes: 64 MiB.
const GROUP_VALUES: usize = 8 << 20;

/// A table under way.
pub(super) struct ParquetFile {
    writer: SerializedFileWriter<File>,
    columns: Vec<ColumnGroup>,
    values: usize,
}

/// The values of a column since the last group, with what Parquet calls their levels: whether there is one, and whether it begins a row.
struct ColumnGroup {
    values: Values,
    definitions: Vec<i16>,
    repetitions: Vec<i16>,
    is_list: bool,
}

enum Values {
    Bool(Vec<bool>),
    Int32(Vec<i32>),
    Int64(Vec<i64>),
    Float32(Vec<f32>),
    Float64(Vec<f64>),
    Text(Vec<ByteArray>),
}

impl ParquetFile {
    pub(super) fn create(path: &Path, columns: &[Column]) -> Result<Self, BagError> {
        let failed = |source| BagError::Table { path: path.to_owned(), source };
        let schema = schema(columns).map_err(failed)?;
        let file = File::create_new(path).map_err(|e| BagError::io("create", path, e))?;
        let properties = WriterProperties::builder()
            .set_created_by(concat!("camwright ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_compression(Compression::SNAPPY)
            .build();
        let writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(failed)?;
        let times = [ColumnType::Signed(64), ColumnType::Signed(64)];
        let columns = times.iter().chain(columns.iter().map(|column| &column.kind)).map(ColumnGroup::new).collect();
        Ok(Self { writer, columns, values: 0 })
    }

    pub(super) fn row(&mut self, path: &Path, times_ns: [u64; 2], row: &[Option<FieldValue>]) -> Result<(), BagError> {
        // A time that does not fit is later than the year 2262, and stays empty.
        let times = times_ns.map(|time| i64::try_from(time).ok().map(|time| FieldValue::Signed(time, 64)));
        for (column, value) in self.columns.iter_mut().zip(times.iter().chain(row)) {
            self.values += column.push(value.as_ref());
        }
        if self.values >= GROUP_VALUES { self.write_group(path) } else { Ok(()) }
    }

    pub(super) fn finish(mut self, path: &Path) -> Result<(), BagError> {
        self.write_group(path)?;
        self.writer.close().map(drop).map_err(|source| BagError::Table { path: path.to_owned(), source })
    }

    fn write_group(&mut self, path: &Path) -> Result<(), BagError> {
        self.values = 0;
        self.group().map_err(|source| BagError::Table { path: path.to_owned(), source })
    }

    fn group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for column in &mut self.columns {
            let Some(mut writer) = group.next_column()? else { break };
            column.write(writer.untyped())?;
            writer.close()?;
        }
        group.close().map(drop)
    }
}

impl ColumnGroup {
    fn new(kind: &ColumnType) -> Self {
        let (element, is_list) = match kind {
            ColumnType::List(element) => (element.as_ref(), true),
            other => (other, false),
        };
        let values = match element {
            ColumnType::Bool => Values::Bool(Vec::new()),
            ColumnType::Signed(64) | ColumnType::Unsigned(64) => Values::Int64(Vec::new()),
            ColumnType::Signed(_) | ColumnType::Unsigned(_) => Values::Int32(Vec::new()),
            ColumnType::Float32 => Values::Float32(Vec::new()),
            ColumnType::Float64 => Values::Float64(Vec::new()),
            ColumnType::Text | ColumnType::List(_) => Values::Text(Vec::new()),
        };
        Self { values, definitions: Vec::new(), repetitions: Vec::new(), is_list }
    }

    /// Takes the value of a row, or that there is none; returns how many values of eight bytes that makes.
    fn push(&mut self, value: Option<&FieldValue>) -> usize {
        let elements = match value {
            Some(FieldValue::List(elements)) if self.is_list => elements.as_slice(),
            Some(value) => std::slice::from_ref(value),
            None => &[],
        };
        // Of a list there are two levels: the list, and its elements.
        let whole = if self.is_list { 2 } else { 1 };
        let mut taken = 0;
        for (place, element) in elements.iter().enumerate() {
            if self.values.push(element) {
                self.definitions.push(whole);
                self.repetitions.push(i16::from(place > 0));
                taken += 1 + if let FieldValue::Text(text) = element { text.len() / 8 } else { 0 };
            }
        }
        if taken == 0 {
            self.definitions.push(0);
            self.repetitions.push(0);
        }
        taken.max(1)
    }

    fn write(&mut self, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
        let levels = (Some(&self.definitions[..]), self.is_list.then_some(&self.repetitions[..]));
        match &mut self.values {
            Values::Bool(values) => batch::<BoolType>(writer, values, levels),
            Values::Int32(values) => batch::<Int32Type>(writer, values, levels),
            Values::Int64(values) => batch::<Int64Type>(writer, values, levels),
            Values::Float32(values) => batch::<FloatType>(writer, values, levels),
            Values::Float64(values) => batch::<DoubleType>(writer, values, levels),
            Values::Text(values) => batch::<ByteArrayType>(writer, values, levels),
        }?;
        self.definitions.clear();
        self.repetitions.clear();
        Ok(())
    }
}

/// Definition levels (a value is present) and repetition levels (it begins a row).
type Levels<'a> = (Option<&'a [i16]>, Option<&'a [i16]>);

/// Writes the values of a column, which are gone then.
fn batch<T: DataType>(
    writer: &mut ColumnWriter<'_>,
    values: &mut Vec<T::T>,
    (definitions, repetitions): Levels<'_>,
) -> Result<(), ParquetError> {
    let writer = T::get_column_writer_mut(writer)
        .ok_or_else(|| ParquetError::General("a column is of another type than its values".into()))?;
    writer.write_batch(values, definitions, repetitions)?;
    values.clear();
    Ok(())
}

impl Values {
    /// Adds a value, if it is of this type.
    fn push(&mut self, value: &FieldValue) -> bool {
        match (self, value) {
            (Self::Bool(values), FieldValue::Bool(value)) => values.push(*value),
            (Self::Int64(values), FieldValue::Signed(value, _)) => values.push(*value),
            // Parquet has unsigned numbers as a reading of the same bits.
            (Self::Int64(values), FieldValue::Unsigned(value, _)) => values.push(value.cast_signed()),
            (Self::Int32(values), FieldValue::Signed(value, _)) => match i32::try_from(*value) {
                Ok(value) => values.push(value),
                Err(_) => return false,
            },
            (Self::Int32(values), FieldValue::Unsigned(value, _)) => match u32::try_from(*value) {
                Ok(value) => values.push(value.cast_signed()),
                Err(_) => return false,
            },
            (Self::Float32(values), FieldValue::Float32(value)) => values.push(*value),
            (Self::Float64(values), FieldValue::Float64(value)) => values.push(*value),
            (Self::Text(values), FieldValue::Text(value)) => values.push(ByteArray::from(value.as_str())),
            _ => return false,
        }
        true
    }
}

fn schema(columns: &[Column]) -> Result<TypePtr, ParquetError> {
    let mut fields = Vec::new();
    for name in ["log_time", "publish_time"] {
        let time = LogicalType::timestamp(true, TimeUnit::NANOS);
        let field = Type::primitive_type_builder(name, Physical::INT64).with_logical_type(Some(time));
        fields.push(Arc::new(field.with_repetition(Repetition::OPTIONAL).build()?));
    }
    for Column { name, kind } in columns {
        fields.push(match kind {
            ColumnType::List(element) => {
                let element = primitive("element", element, Repetition::REQUIRED)?;
                let list = Type::group_type_builder("list").with_repetition(Repetition::REPEATED);
                let list = list.with_fields(vec![element]).build()?;
                let group = Type::group_type_builder(name).with_repetition(Repetition::OPTIONAL);
                Arc::new(group.with_logical_type(Some(LogicalType::List)).with_fields(vec![Arc::new(list)]).build()?)
            }
            kind => primitive(name, kind, Repetition::OPTIONAL)?,
        });
    }
    Type::group_type_builder("message").with_fields(fields).build().map(Arc::new)
}

fn primitive(name: &str, kind: &ColumnType, repetition: Repetition) -> Result<TypePtr, ParquetError> {
    let integer = |bits: u8, is_signed| {
        let physical = if bits == 64 { Physical::INT64 } else { Physical::INT32 };
        (physical, Some(LogicalType::integer(i8::try_from(bits).unwrap_or(64), is_signed)))
    };
    let (physical, logical) = match kind {
        ColumnType::Bool => (Physical::BOOLEAN, None),
        ColumnType::Signed(bits) => integer(*bits, true),
        ColumnType::Unsigned(bits) => integer(*bits, false),
        ColumnType::Float32 => (Physical::FLOAT, None),
        ColumnType::Float64 => (Physical::DOUBLE, None),
        ColumnType::Text | ColumnType::List(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let builder = Type::primitive_type_builder(name, physical).with_logical_type(logical);
    builder.with_repetition(repetition).build().map(Arc::new)
}
