// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright list`: names that other commands accept, with their meaning.

use super::output::{print_error, say, wrapped};
use crate::bag_size;
use camwright::machine::alarm::{AlarmKind, AlarmSeverity};
use camwright::simulation::fault::FAULTS;
use camwright_files::ConfigError;
use camwright_files::any_job;
use camwright_files::lift_file;
use camwright_files::locate::{list, locate};
use camwright_files::machine_file;
use camwright_files::study_file;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value};
use std::process::ExitCode;

/// End of the list of faults.
const FAULT_EXAMPLES: &str = "
now:      camwright fault drive_fault x_axis    (remove it: --clear)
in a job: faults: [{kind: drive_fault, target: x_axis, at_s: 3}]";

/// End of the list of jobs.
const JOB_EXAMPLES: &str = "
run one:     camwright run NAME
NC program:  camwright post NAME    (the only way for milling jobs)";

/// Maximum width of a column; a longer cell moves the cells behind it.
const MAX_COLUMN: usize = 34;

/// Lists that can be printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Subject {
    /// Jobs, by name.
    Jobs,
    /// Machines, by name.
    Machines,
    /// Studies, by name.
    Studies,
    /// Lift tables, by name.
    Lifts,
    /// Faults of `camwright fault`, `machine/inject_fault` and the key `faults`.
    Faults,
    /// Topics of a cell that a run records.
    Topics,
    /// Alarms with their remedies.
    Alarms,
}

/// Arguments of `camwright list`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::LIST)]
pub(super) struct ListArgs {
    /// Subject of the list.
    #[arg(value_enum)]
    subject: Subject,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// Rows under the names of their columns.
struct Table {
    columns: &'static [&'static str],
    rows: Vec<Vec<String>>,
}

/// Exit code 0: printed; 1: a file of params cannot be read.
pub(super) fn main(args: &ListArgs) -> ExitCode {
    let table = match table(args.subject) {
        Ok(table) => table,
        Err(error) => {
            print_error("camwright list", &error);
            return ExitCode::from(1);
        }
    };
    if args.json {
        say!("{:#}", table.json());
    } else {
        say!("{}", wrapped(table.text().trim_end(), 4));
        match args.subject {
            Subject::Jobs => say!("{JOB_EXAMPLES}"),
            Subject::Faults => say!("{FAULT_EXAMPLES}"),
            _ => {}
        }
    }
    ExitCode::SUCCESS
}

fn table(subject: Subject) -> Result<Table, ConfigError> {
    Ok(match subject {
        Subject::Jobs => Table {
            columns: &["name", "title"],
            rows: any_job::list().into_iter().map(|(name, title, _)| vec![name, title]).collect(),
        },
        Subject::Machines => Table {
            columns: &["name", "kind", "travel"],
            rows: list("machines").iter().map(|name| machine(name)).collect(),
        },
        Subject::Studies => Table {
            columns: &["name", "title"],
            rows: study_file::list().into_iter().map(|(name, title)| vec![name, title]).collect(),
        },
        Subject::Lifts => {
            Table { columns: &["name", "rows", "lift"], rows: list("lifts").iter().map(|name| lift(name)).collect() }
        }
        Subject::Faults => Table {
            columns: &["name", "target", "value"],
            rows: FAULTS.iter().map(|fault| [fault.name, fault.target, fault.value].map(or_dash).to_vec()).collect(),
        },
        Subject::Topics => {
            let located = locate("machines", "machines/cam_grinder", "yaml", None)?;
            let machine = machine_file::parse(&located.path, &located.text, &[])?;
            let topics = bag_size::recorded_topics(&machine.description).into_iter();
            Table {
                columns: &["topic", "type"],
                rows: topics.map(|(topic, type_name)| vec![topic.to_owned(), type_name.to_owned()]).collect(),
            }
        }
        Subject::Alarms => Table {
            columns: &["number", "severity", "text", "remedy"],
            rows: AlarmKind::ALL.into_iter().map(alarm).collect(),
        },
    })
}

fn or_dash(text: &str) -> String {
    if text.is_empty() || text == "none" { "-".to_owned() } else { text.to_owned() }
}

fn machine(name: &str) -> Vec<String> {
    let read = locate("machines", name, "yaml", None)
        .and_then(|located| machine_file::parse(&located.path, &located.text, &[]));
    match read {
        Ok(machine) => vec![name.to_owned(), machine.kind().to_owned(), machine.travel()],
        Err(error) => vec![name.to_owned(), "refused".to_owned(), error.to_string()],
    }
}

fn lift(name: &str) -> Vec<String> {
    let read = locate("lifts", name, "csv", None).map_err(|error| vec![error]);
    match read.and_then(|located| lift_file::read_alone(&located, &[])) {
        Ok(lift) => {
            let facts = lift.table.map(|table| (table.blocks().to_string(), format!("{:.3} mm", table.max_lift_mm())));
            let (rows, height) = facts.unwrap_or_else(|| ("-".to_owned(), "-".to_owned()));
            vec![name.to_owned(), rows, height]
        }
        // A half table and a table in other units need keys of a job.
        Err(_) => vec![name.to_owned(), "-".to_owned(), format!("needs keys of a job: `camwright check {name}`")],
    }
}

fn alarm(kind: AlarmKind) -> Vec<String> {
    let entry = kind.entry();
    let severity = match entry.severity {
        AlarmSeverity::Warning => "warning",
        AlarmSeverity::Stop => "stop",
        AlarmSeverity::PowerOff => "power off",
    };
    let axis = kind.axis().map_or_else(String::new, |axis| format!("{}: ", axis.joint()));
    vec![entry.number.to_string(), severity.to_owned(), format!("{axis}{}", entry.name), entry.remedy.to_owned()]
}

impl Table {
    fn json(&self) -> Value {
        let object = |row: &Vec<String>| {
            let entries = self.columns.iter().zip(row);
            entries.map(|(name, text)| ((*name).to_owned(), Value::from(text.as_str()))).collect::<Map<_, _>>()
        };
        self.rows.iter().map(object).map(Value::Object).collect()
    }

    /// One line for each row, in columns.
    fn text(&self) -> String {
        let longest = |column: usize| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let width = |column: usize| longest(column).min(MAX_COLUMN);
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).map(|(text, width)| format!("{text:<width$}"));
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
        };
        self.rows.iter().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn rows(subject: Subject) -> Vec<Vec<String>> {
        table(subject).expect("the shipped files are good").rows
    }

    #[test]
    fn every_list_has_a_row_for_each_name() {
        let has = |subject, row: &[&str]| {
            let rows = rows(subject);
            assert!(rows.iter().any(|found| found == row), "{row:?} is not in {rows:?}");
        };
        has(Subject::Jobs, &["eccentric", "Eccentric disc, E 4.2 mm, D 38 mm, tool R 15 mm"]);
        has(Subject::Machines, &["cam_grinder", "grinder", "x_axis 5 to 180 mm, z_axis -20 to 600 mm"]);
        has(Subject::Studies, &["speed_and_infeed", "Time against form error of the default job"]);
        has(Subject::Faults, &["estop", "-", "-"]);
        has(Subject::Topics, &["joint_states", "sensor_msgs/msg/JointState"]);
        assert_eq!(rows(Subject::Faults).len(), FAULTS.len());
        assert_eq!(rows(Subject::Alarms).len(), AlarmKind::ALL.len());
        let lifts = rows(Subject::Lifts);
        assert!(lifts.iter().any(|row| row[..2] == ["intake", "3600"]), "{lifts:?}");
        assert!(lifts.iter().all(|row| row[0] != "make_lifts"), "{lifts:?}");
    }

    /// The listed topics are those of the reference, with the same types.
    #[test]
    fn every_topic_is_in_the_reference() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/ros");
        let pages = std::fs::read_dir(folder).expect("pages").flatten().map(|entry| entry.path());
        let pages: String = pages.filter_map(|page| std::fs::read_to_string(page).ok()).collect();
        for row in rows(Subject::Topics) {
            if row[0].contains("_action/") {
                continue;
            }
            let name = row[0].rsplit('/').next().unwrap_or_default();
            let is_row =
                |line: &&str| line.starts_with("| `") && line.split('`').nth(1).is_some_and(|t| t.ends_with(name));
            let line = pages.lines().find(|line| is_row(line) && line.contains(row[1].as_str()));
            assert!(line.is_some(), "{row:?} is not in docs/reference/ros");
        }
    }

    #[test]
    fn json_and_text_hold_the_same() {
        let table = table(Subject::Faults).expect("no file is needed");
        let json = table.json();
        assert_eq!(json[0]["name"], "estop");
        assert_eq!(json.as_array().map(Vec::len), Some(table.text().lines().count()));
    }
}
