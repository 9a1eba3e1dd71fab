// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A table of each topic of a bag: a row for each message, a column for each value.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::columns::{Column, ColumnType};
use super::csv::CsvFile;
use super::definition::TypeDefinition;
use super::exported::Exported;
use super::parquet_file::ParquetFile;
use super::values::{FieldValue, read};
use super::{Bag, BagError, BagMessage};
use crate::progress::bar_over;

/// Columns of a table at most: far more than any message has, and few enough for every row to have a place for each.
const MAX_COLUMNS: usize = 10_000;

/// Format of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableFormat {
    /// Text, RFC 4180.
    Csv,
    /// Apache Parquet, each column with its type.
    Parquet,
}

/// The table of one topic.
struct TopicTable {
    definition: TypeDefinition,
    path: PathBuf,
    columns: Vec<Column>,
    numbers: BTreeMap<String, usize>,
    file: Option<TableFile>,
}

enum TableFile {
    Csv(CsvFile),
    Parquet(Box<ParquetFile>),
}

/// A table of each topic of `bag`, in the new directory `into`: a row for each message with its log time and publication time (ns since 1970) and each of its
/// values, in the units of the message. Elements of arrays have a column each, up to `longest`; longer ones are one text, or one list where the format has
/// lists. Numbers read back to the same bits.
///
/// # Errors
/// The bag cannot be read, or the directory is there already or cannot be written; then none is left.
pub fn to_tables(bag: &Bag, into: &Path, format: TableFormat, longest: usize) -> Result<Exported, BagError> {
    match fs::create_dir(into) {
        Ok(()) => {}
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
            return Err(BagError::Exists { path: into.to_owned() });
        }
        Err(e) => return Err(BagError::io("create", into, e)),
    }
    let outcome = tables(bag, into, format, longest);
    if outcome.is_err() {
        // Ours, made a moment ago, and half done.
        drop(fs::remove_dir_all(into));
    }
    outcome
}

fn tables(bag: &Bag, into: &Path, format: TableFormat, longest: usize) -> Result<Exported, BagError> {
    let mut exported = Exported::default();
    let mut tables: Vec<Option<TopicTable>> = Vec::new();
    for (topic, &count) in bag.topics().iter().zip(bag.message_counts()) {
        let table = match TypeDefinition::parse(&topic.type_name, &topic.definition) {
            Ok(definition) => Some(TopicTable::new(definition, into, &topic.name, format)),
            Err(reason) => {
                exported.left_out.push((topic.name.clone(), reason));
                None
            }
        };
        tables.push(table.filter(|_| count > 0));
    }
    // Once for the columns, which the longest array of the bag decides, and once for the rows.
    let progress = bar_over(bag, 2);
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message()? {
        progress.inc(1);
        let Some(place) = tables.get_mut(message.topic) else { continue };
        let Some(table) = place else { continue };
        if let Err(reason) = table.find_columns(&message, longest) {
            let topic = &bag.topics()[message.topic].name;
            exported.left_out.push((topic.clone(), format!("message {}: {reason}", message.sequence)));
            *place = None;
        }
    }
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message()? {
        progress.inc(1);
        let Some(Some(table)) = tables.get_mut(message.topic) else { continue };
        table.write(&message, format, longest)?;
        exported.messages += 1;
    }
    for table in tables.into_iter().flatten() {
        match table.file {
            Some(TableFile::Csv(file)) => file.finish(&table.path)?,
            Some(TableFile::Parquet(file)) => file.finish(&table.path)?,
            None => continue,
        }
        exported.paths.push(table.path);
    }
    progress.finish_and_clear();
    Ok(exported)
}

impl TopicTable {
    fn new(definition: TypeDefinition, into: &Path, topic: &str, format: TableFormat) -> Self {
        let extension = match format {
            TableFormat::Csv => "csv",
            TableFormat::Parquet => "parquet",
        };
        // A topic's name has no point in it, so no two have the same file.
        let name = format!("{}.{extension}", topic.trim_start_matches('/').replace('/', "."));
        Self { definition, path: into.join(name), columns: Vec::new(), numbers: BTreeMap::new(), file: None }
    }

    /// Adds the columns that a message needs.
    fn find_columns(&mut self, message: &BagMessage, longest: usize) -> Result<(), String> {
        let Self { definition, columns, numbers, .. } = self;
        let mut is_too_wide = false;
        read(definition, &message.data, longest, &mut |path, value| {
            if numbers.contains_key(path) {
                return;
            }
            if columns.len() < MAX_COLUMNS {
                numbers.insert(path.to_owned(), columns.len());
                columns.push(Column { name: path.to_owned(), kind: ColumnType::from_value(&value) });
            } else {
                is_too_wide = true;
            }
        })?;
        if is_too_wide {
            return Err(format!("it needs more than {MAX_COLUMNS} columns; --longest makes fewer"));
        }
        Ok(())
    }

    /// Writes a message as a row.
    fn write(&mut self, message: &BagMessage, format: TableFormat, longest: usize) -> Result<(), BagError> {
        let mut row: Vec<Option<FieldValue>> = vec![None; self.columns.len()];
        // It was read once, and is read alike again.
        let _ = read(&self.definition, &message.data, longest, &mut |path, value| {
            if let Some(place) = self.numbers.get(path).and_then(|&number| row.get_mut(number)) {
                *place = Some(value);
            }
        });
        let mut file = match (self.file.take(), format) {
            (Some(file), _) => file,
            (None, TableFormat::Csv) => TableFile::Csv(CsvFile::create(&self.path, &self.columns)?),
            (None, TableFormat::Parquet) => {
                TableFile::Parquet(Box::new(ParquetFile::create(&self.path, &self.columns)?))
            }
        };
        let times_ns = [message.log_time_ns, message.publish_time_ns];
        match &mut file {
            TableFile::Csv(file) => file.row(&self.path, times_ns, &row)?,
            TableFile::Parquet(file) => file.row(&self.path, times_ns, &row)?,
        }
        self.file = Some(file);
        Ok(())
    }
}
