// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables as text (RFC 4180).

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::BagError;
use super::columns::Column;
use super::values::{FieldValue, plain};

/// A table under way.
pub(super) struct CsvFile(BufWriter<File>);

impl CsvFile {
    pub(super) fn create(path: &Path, columns: &[Column]) -> Result<Self, BagError> {
        let mut file = File::create_new(path).map(BufWriter::new).map_err(|e| BagError::io("create", path, e))?;
        let times = ["log_time_ns", "publish_time_ns"].map(String::from);
        let names = columns.iter().map(|column| column.name.clone());
        line(&mut file, times.into_iter().chain(names)).map_err(|e| BagError::io("write", path, e))?;
        Ok(Self(file))
    }

    pub(super) fn row(&mut self, path: &Path, times_ns: [u64; 2], row: &[Option<FieldValue>]) -> Result<(), BagError> {
        let times = times_ns.iter().map(u64::to_string);
        let values = row.iter().map(|value| value.as_ref().map_or_else(String::new, plain));
        line(&mut self.0, times.chain(values)).map_err(|e| BagError::io("write", path, e))
    }

    pub(super) fn finish(mut self, path: &Path) -> Result<(), BagError> {
        self.0.flush().map_err(|e| BagError::io("write", path, e))
    }
}

/// One line of a table; what has a comma, a quotation mark or a line end in it is quoted.
fn line(file: &mut impl Write, values: impl Iterator<Item = String>) -> std::io::Result<()> {
    let quoted = |value: String| {
        if value.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", value.replace('"', "\"\"")) } else { value }
    };
    let values: Vec<String> = values.map(quoted).collect();
    file.write_all(values.join(",").as_bytes())?;
    file.write_all(b"\r\n")
}
