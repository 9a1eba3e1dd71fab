// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Table of results as CSV (RFC 4180, lines end with a newline).

use super::table::{ColumnData, ResultTable};

impl ResultTable {
    /// The table as CSV with a header; an empty cell is a missing value.
    pub(crate) fn to_csv(&self) -> String {
        let rows = self.columns.first().map_or(0, |(_, data)| data.len());
        let header: Vec<String> = self.columns.iter().map(|(name, _)| quoted(name)).collect();
        let mut text = header.join(",") + "\n";
        for row in 0..rows {
            let cells: Vec<String> = self.columns.iter().map(|(_, data)| data.cell(row)).collect();
            text += &(cells.join(",") + "\n");
        }
        text
    }
}

impl ColumnData {
    const fn len(&self) -> usize {
        match self {
            Self::Whole(values) => values.len(),
            Self::Number(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    fn cell(&self, row: usize) -> String {
        let text = match self {
            Self::Whole(values) => values[row].map(|value| value.to_string()),
            // The shortest digits that are read back as the same bits.
            Self::Number(values) => values[row].map(|value| value.to_string()),
            Self::Text(values) => values[row].as_deref().map(quoted),
        };
        text.unwrap_or_default()
    }
}

/// A text in quotes where commas, quotes or lines need them.
fn quoted(text: &str) -> String {
    let needs_quotes = text.contains([',', '"', '\n', '\r']);
    if needs_quotes { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_and_missing_values_are_empty() {
        let table = ResultTable {
            columns: vec![
                ("case".into(), ColumnData::Whole(vec![Some(1), None])),
                ("a,b".into(), ColumnData::Number(vec![Some(0.1), None])),
                ("reason".into(), ColumnData::Text(vec![Some("a \"b\"\nc".into()), Some("plain".into())])),
            ],
        };
        assert_eq!(table.to_csv(), "case,\"a,b\",reason\n1,0.1,\"a \"\"b\"\"\nc\"\n,,plain\n");
    }
}
