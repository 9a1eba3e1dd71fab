// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of numbers: columns with names and units, written as CSV by `camwright plan` and returned as arrays in Python.

use std::io::{self, Write};

/// Column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberColumn {
    /// Name, which ends in the unit.
    pub name: &'static str,
    /// Unit, empty for a number.
    pub unit: &'static str,
    pub values: Vec<f64>,
}

/// Columns of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberTable(Vec<NumberColumn>);

impl NumberTable {
    /// Creates a table from the names and units of its columns, and its rows.
    #[must_use]
    pub fn from_rows<const N: usize>(
        columns: [(&'static str, &'static str); N],
        rows: impl IntoIterator<Item = [f64; N]>,
    ) -> Self {
        let mut columns = columns.map(|(name, unit)| NumberColumn { name, unit, values: Vec::new() });
        for row in rows {
            for (column, value) in columns.iter_mut().zip(row) {
                column.values.push(value);
            }
        }
        Self(columns.into())
    }

    #[must_use]
    pub fn columns(&self) -> &[NumberColumn] {
        &self.0
    }

    /// Columns without the table.
    #[must_use]
    pub fn into_columns(self) -> Vec<NumberColumn> {
        self.0
    }

    /// Writes the table with a header; numbers with the digits that give the same number back.
    pub(crate) fn write_csv(&self, to: &mut dyn Write) -> io::Result<()> {
        let names: Vec<&str> = self.0.iter().map(|column| column.name).collect();
        writeln!(to, "{}", names.join(","))?;
        let rows = self.0.first().map_or(0, |column| column.values.len());
        for row in 0..rows {
            for (index, column) in self.0.iter().enumerate() {
                let separator = if index == 0 { "" } else { "," };
                write!(to, "{separator}{}", column.values[row])?;
            }
            writeln!(to)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_written_with_header_and_exact_numbers() {
        let table = NumberTable::from_rows([("c_deg", "deg"), ("pass", "")], [[0.1, 1.0], [1.0 / 3.0, 2.0]]);
        let mut text = Vec::new();
        table.write_csv(&mut text).unwrap();
        assert_eq!(String::from_utf8(text).unwrap(), "c_deg,pass\n0.1,1\n0.3333333333333333,2\n");
    }
}
