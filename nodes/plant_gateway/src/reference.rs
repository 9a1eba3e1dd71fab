// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of the data items and of the OPC UA nodes in the reference.

use crate::items::ITEMS;
use crate::ua::table_rows;

const HEAD: &str = "| id | component | type | unit | from | value |\n";
const UA_HEAD: &str = "| node | model | type | from | value |\n";

/// Table of all OPC UA nodes in Markdown, as the reference has it.
#[must_use]
pub fn ua_table() -> String {
    let mut table = format!("{UA_HEAD}|---|---|---|---|---|\n");
    for [path, model, kind, topic, rule] in table_rows() {
        table.push_str(&format!("| `{path}` | {model} | {kind} | {topic} | {rule} |\n"));
    }
    table
}

/// Table of all data items in Markdown, as the reference has it.
#[must_use]
pub fn table() -> String {
    let mut table = format!("{HEAD}|---|---|---|---|---|---|\n");
    for item in ITEMS {
        let kind = match item.sub_type {
            Some(sub_type) => format!("`{}` {sub_type}", item.kind),
            None => format!("`{}`", item.kind),
        };
        let (element, name) = (item.component.element(), item.component.name());
        let component =
            if element.eq_ignore_ascii_case(name) { element.to_owned() } else { format!("{element} {name}") };
        let (id, units, topic, rule) = (item.id, item.units.unwrap_or(item.category.name()), item.topic, item.rule);
        table.push_str(&format!("| `{id}` | {component} | {kind} | {units} | {topic} | {rule} |\n"));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::{HEAD, UA_HEAD, table, ua_table};
    use std::path::Path;

    /// Environment variable that makes the test write the tables.
    const WRITE: &str = "CAMWRIGHT_WRITE_REFERENCE";
    const PAGE: &str = "docs/reference/mtconnect_and_umati.md";

    /// The page with a table in place of the one with this head. A table ends with the first empty line.
    fn with_table(page: &str, head: &str, table: &str) -> String {
        let (before, rest) = page.split_once(head).expect("the page has the table");
        let (_, after) = rest.split_once("\n\n").expect("an empty line");
        format!("{before}{table}\n{after}")
    }

    #[test]
    fn the_table_of_data_items_is_that_of_the_code() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(PAGE);
        let text = std::fs::read_to_string(&path).expect("the page");
        let page = with_table(&with_table(&text, HEAD, &table()), UA_HEAD, &ua_table());
        if std::env::var_os(WRITE).is_some() {
            std::fs::write(&path, &page).expect("the repository is writable");
            return;
        }
        assert!(
            text == page,
            "{PAGE} is out of date; write it with {WRITE}=1 cargo test -p camwright_plant_gateway table_of_data_items"
        );
    }
}
