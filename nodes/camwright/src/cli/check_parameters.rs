// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Check of ROS parameter files against the parameters that the four nodes declare. No node is started.

use camwright_axis_interpolator::AxisInterpolator;
use camwright_files::locate::{Located, locate};
use camwright_files::schema::nearest;
use camwright_files::yaml::{Document, YamlNode, YamlValue};
use camwright_files::{ConfigError, FileLocation};
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_planning::{CheckReport, Finding, Severity};
use camwright_ros::running::NodeError;
use camwright_ros::{NodeParameters, Parameters, RosArgs, parse_parameter_file};
use camwright_run_logger::RunLogger;
use std::path::Path;

/// Key below which the parameters of a node stand.
const PARAMETERS: &str = "ros__parameters";

/// The parameter file that a name or path leads to, if it leads to one.
pub(super) fn parameter_file(name: &str) -> Option<Located> {
    let located = locate("jobs", name, "yaml", None).ok()?;
    let has = |key: &str| located.text.lines().any(|line| line.trim_start().starts_with(&format!("{key}:")));
    (has(PARAMETERS) && !has("schema")).then_some(located)
}

/// Checks names, types and ranges of all parameters of a file.
pub(super) fn check(located: &Located) -> Result<CheckReport, NodeError> {
    let nodes = declared()?;
    let mut check = Check { file: &located.path, nodes: &nodes, findings: Vec::new() };
    let mut summary = None;
    match parse_parameter_file(&located.text) {
        Ok(groups) => {
            let lines = lines(located);
            let mut count = 0;
            for (index, group) in groups.iter().enumerate() {
                let lines = lines.get(index).map_or(&[][..], Vec::as_slice);
                check.group(group, lines);
                count += group.parameters().len();
            }
            summary = Some(format!("{}: {count} parameters of {} nodes", located.path.display(), groups.len()));
        }
        Err(reason) => check.report(Severity::Error, None, reason),
    }
    let findings = check.findings;
    let is_good = findings.iter().all(|finding| finding.severity == Severity::Warning);
    Ok(CheckReport { file: located.path.clone(), findings, summary: summary.filter(|_| is_good), notes: Vec::new() })
}

/// The four nodes with the parameters that they declare.
fn declared() -> Result<Vec<(String, Parameters)>, NodeError> {
    let args = RosArgs::default();
    let all = [
        RunLogger::options(&args),
        MachineSim::options(&args),
        AxisInterpolator::options(&args),
        JobPlanner::options(&args),
    ];
    all.iter().map(|options| Ok((options.name().to_owned(), options.declared()?))).collect()
}

/// Lines of the parameters of each group, in the order of the file; empty for text whose lines are unknown.
fn lines(located: &Located) -> Vec<Vec<u64>> {
    fn groups(node: &YamlNode, into: &mut Vec<Vec<u64>>) {
        let YamlValue::Map(entries) = &node.value else { return };
        for (key, value) in entries {
            if key == PARAMETERS {
                let mut group = Vec::new();
                parameters(value, &mut group);
                into.push(group);
            } else {
                groups(value, into);
            }
        }
    }
    fn parameters(node: &YamlNode, into: &mut Vec<u64>) {
        match &node.value {
            YamlValue::Map(entries) => entries.iter().for_each(|(_, value)| parameters(value, into)),
            _ => into.push(node.line),
        }
    }
    let mut all = Vec::new();
    if let Ok(document) = Document::with_overrides(located, &[]) {
        groups(&document.root, &mut all);
    }
    all
}

struct Check<'a> {
    file: &'a Path,
    nodes: &'a [(String, Parameters)],
    findings: Vec<Finding>,
}

impl Check<'_> {
    fn report(&mut self, severity: Severity, line: Option<u64>, message: String) {
        let place = line.map_or_else(|| FileLocation::file(self.file), |line| FileLocation::line(self.file, line));
        self.findings.push(Finding { severity, error: ConfigError::at(place, message) });
    }

    /// Checks the parameters of a node name, which may be a wildcard.
    fn group(&mut self, group: &NodeParameters, lines: &[u64]) {
        let name = group.pattern().rsplit('/').next().unwrap_or_default();
        let line = lines.iter().min().map(|line| line.saturating_sub(1));
        let nodes: Vec<&(String, Parameters)> =
            self.nodes.iter().filter(|(node, _)| name.starts_with('*') || node == name).collect();
        if nodes.is_empty() {
            let known: Vec<&str> = self.nodes.iter().map(|(node, _)| node.as_str()).collect();
            let message = match nearest(name, &known) {
                Some(nearest) => format!("node {name} is unknown; did you mean {nearest}?"),
                None => format!(
                    "node {name} is unknown and its parameters are not checked; camwright has {}",
                    known.join(", ")
                ),
            };
            let is_misspelt = nearest(name, &known).is_some();
            return self.report(if is_misspelt { Severity::Error } else { Severity::Warning }, line, message);
        }
        for (index, (parameter, value)) in group.parameters().iter().enumerate() {
            let line = lines.get(index).copied();
            let declarations: Vec<_> = nodes
                .iter()
                .filter_map(|(node, parameters)| Some((node, parameters.declaration(parameter)?)))
                .collect();
            if declarations.is_empty() {
                let names: Vec<String> = nodes.iter().flat_map(|(_, parameters)| parameters.names()).collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let hint = match nearest(parameter, &names) {
                    Some(nearest) => format!("did you mean {nearest}?"),
                    None => format!("`ros2 param list /{name}` lists those of a running node"),
                };
                self.report(Severity::Error, line, format!("{name} has no parameter {parameter}; {hint}"));
            }
            let refused = declarations.iter().find_map(|(node, declaration)| {
                let reason = declaration.check_given(value.clone()).err()?;
                Some(format!("parameter {parameter} of {node}: {reason}"))
            });
            if let Some(message) = refused {
                self.report(Severity::Error, line, message);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(text: &str) -> Vec<String> {
        let report = check(&Located::new("nodes.yaml", text)).expect("the nodes declare their parameters");
        report.findings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn the_shipped_parameter_file_is_clean() {
        let text = include_str!("../../../../params/nodes.yaml");
        assert_eq!(findings(text), [""; 0]);
        let found = parameter_file(concat!(env!("CARGO_MANIFEST_DIR"), "/../../params/nodes.yaml"));
        assert_eq!(found.expect("it is a parameter file").text, text);
        assert_eq!(parameter_file("four_lobe_camshaft"), None);
    }

    #[test]
    fn all_findings_of_a_file_are_reported_with_their_lines() {
        let text = "/**/run_logger:\n  ros__parameters:\n    split_mbb: 3\n    depth: 0\n    preset: fast\n    split_s: 1\n\
            /**/job_planer:\n  ros__parameters:\n    job: eccentric\n\
            /cell/move_group:\n  ros__parameters: {a: 1}\n\
            /**:\n  ros__parameters:\n    use_sim_time: 1\n";
        assert_eq!(
            findings(text),
            [
                "error: nodes.yaml:3: run_logger has no parameter split_mbb; did you mean split_mb?",
                "error: nodes.yaml:4: parameter depth of run_logger: 0 is outside 1 to 65536",
                "error: nodes.yaml:5: parameter preset of run_logger: is 'fast'; it must be one of default, zstd, zstd_fast, \
                 zstd_small, fastwrite",
                "error: nodes.yaml:8: node job_planer is unknown; did you mean job_planner?",
                "warning: nodes.yaml:10: node move_group is unknown and its parameters are not checked; camwright has run_logger, \
                 machine_sim, axis_interpolator, job_planner",
                "error: nodes.yaml:14: parameter use_sim_time of run_logger: has the type bool; it cannot be the integer 1",
            ]
        );
    }

    #[test]
    fn a_file_that_no_node_reads_is_one_error() {
        let found = findings("run_logger:\n  ros__parameters: 3\n");
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("'ros__parameters' is not a mapping"), "{found:?}");
    }
}
