// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Comments of the interface files in `msgs/`.

use super::support::repository;
use std::fmt::Write;

/// Parts of a file, by the number of separators before them.
const PARTS: [(&str, &[&str]); 3] =
    [("msg", &["Fields"]), ("srv", &["Request", "Response"]), ("action", &["Goal", "Result", "Feedback"])];

/// Longest line of a paragraph.
const MAX_LINE: usize = 140;

/// First line of the comment of a type of `camwright_msgs`.
pub(super) fn meaning(type_name: &str) -> Option<String> {
    let (kind, name) = type_name.strip_prefix("camwright_msgs/")?.split_once('/')?;
    let path = repository().join("msgs").join(kind).join(format!("{name}.{kind}"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let line = text.lines().next().and_then(|line| line.strip_prefix("# "));
    Some(line.unwrap_or_else(|| panic!("{} does not begin with a comment", path.display())).to_owned())
}

/// Text that is safe in a cell of a Markdown table.
pub(super) fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;").replace('*', "\\*")
}

/// Text in lines of at most [`MAX_LINE`] characters.
fn wrapped(text: &str) -> String {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > MAX_LINE {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines.join("\n")
}

/// A constant or a field: code before, comment behind the `#`.
fn row(line: &str) -> Option<(&str, &str, &str)> {
    let (code, comment) = line.split_once('#').unwrap_or((line, ""));
    let (type_name, name) = code.trim().split_once(char::is_whitespace)?;
    Some((type_name, name.trim(), comment.trim()))
}

fn table(head: &str, rows: &[String], page: &mut String) {
    if !rows.is_empty() {
        let bar = "|---".repeat(head.matches('|').count() - 1);
        write!(page, "\n{head}\n{bar}|\n{}", rows.concat()).expect("a string takes it");
    }
}

/// Sections of all files of a kind, in the order of their names.
fn sections(kind: &str, parts: &[&str], page: &mut String) {
    let folder = repository().join("msgs").join(kind);
    let mut files: Vec<_> =
        std::fs::read_dir(folder).expect("interface files").flatten().map(|file| file.path()).collect();
    files.sort();
    for path in files {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).expect("an interface file");
        let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("# ")).collect();
        let head = wrapped(&format!("`camwright_msgs/{kind}/{name}`: {}", cell(&comment.join(" "))));
        write!(page, "\n## {name}\n\n{head}\n").expect("a string takes it");
        for (title, part) in parts.iter().zip(text.split("---\n")) {
            let (mut constants, mut fields) = (Vec::new(), Vec::new());
            for (type_name, name, comment) in part.lines().filter_map(row) {
                match name.split_once('=') {
                    Some((name, value)) => {
                        constants.push(format!("| `{}` | {} | {} |\n", name.trim(), value.trim(), cell(comment)));
                    }
                    None => fields.push(format!("| `{name}` | `{type_name}` | {} |\n", cell(comment))),
                }
            }
            table("| constant | value | meaning |", &constants, page);
            table(&format!("| {} | type | meaning |", title.to_lowercase().trim_end_matches('s')), &fields, page);
        }
    }
}

/// Page of all types of `camwright_msgs`.
pub(super) fn page() -> String {
    let mut page = String::from(
        "# Types of `camwright_msgs`\n\nGenerated from the interface files in `msgs/`. Units are SI: m, rad, s, N. `ros2 interface show \
         camwright_msgs/msg/JobStatus`\nprints the same on the terminal.\n",
    );
    for (kind, parts) in PARTS {
        sections(kind, parts, &mut page);
    }
    page
}
