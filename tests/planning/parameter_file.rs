// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `params/nodes.yaml` names every parameter of the four nodes, and what it sets are their defaults.

use crate::support;

use camwright_axis_interpolator::AxisInterpolator;
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_ros::{Node, ParameterValue, RosArgs};
use camwright_run_logger::RunLogger;
use std::collections::BTreeMap;
use support::{Domain, repository};

/// Values of every parameter of the four nodes, by node and name, in a cell that is not started.
fn parameters(file: Option<&str>) -> BTreeMap<(String, String), ParameterValue> {
    let domain = Domain::reserve();
    let mut words = vec!["--ros-args", "-r", "__ns:=/cell"];
    words.extend(file.iter().flat_map(|file| ["--params-file", file]));
    // The last word counts: no node begins by itself, and nothing is recorded.
    words.extend(["-p", "autostart:=false"]);
    let words: Vec<String> = words.into_iter().map(String::from).collect();
    let (args, _) = RosArgs::parse(&words).expect("good arguments");
    let args = args.with_domain_id(domain.id());
    let logger = RunLogger::start(&args).expect("run_logger");
    let machine = MachineSim::start(&args).expect("machine_sim");
    let interpolator = AxisInterpolator::start(&args).expect("axis_interpolator");
    let planner = JobPlanner::start(&args).expect("job_planner");
    let of = |node: &Node| -> Vec<_> {
        let value = |name: &String| node.parameters().get(name).unwrap_or(ParameterValue::NotSet);
        let names = node.parameters().names();
        names.iter().map(|name| ((node.name().to_owned(), name.clone()), value(name))).collect()
    };
    let found = [logger.node(), machine.node(), interpolator.node(), planner.node()].into_iter().flat_map(of).collect();
    planner.stop();
    interpolator.stop();
    machine.stop();
    logger.stop();
    found
}

#[test]
fn the_shipped_parameter_file_names_every_parameter_and_sets_its_default() {
    let path = repository().join("params/nodes.yaml");
    let text = std::fs::read_to_string(&path).expect("the file");
    let defaults = parameters(None);
    for (node, name) in defaults.keys() {
        let section = text.split("/**/").find(|section| section.starts_with(node.as_str())).expect("a node's section");
        let names_it = |line: &str| line.trim_start_matches([' ', '#']).starts_with(&format!("{name}:"));
        assert!(section.lines().any(names_it), "{node}: {name} is not in params/nodes.yaml");
    }
    let with_file = parameters(Some(&path.display().to_string()));
    assert_eq!(with_file, defaults);

    // And with every line switched on, which shows that each is a parameter and a value that it takes.
    let lines = text.lines().filter(|line| !line.contains("Defaults: values of the job file"));
    let switched = lines.map(|line| line.strip_prefix("    # ").map_or(line.to_owned(), |rest| format!("    {rest}")));
    let all = switched.collect::<Vec<_>>().join("\n");
    let switched_on =
        std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("nodes-{}.yaml", std::process::id()));
    std::fs::write(&switched_on, all).expect("a file under target/tmp");
    let set = parameters(Some(&switched_on.display().to_string()));
    let unset: Vec<_> = set.iter().filter(|(_, value)| **value == ParameterValue::NotSet).map(|(key, _)| key).collect();
    assert!(unset.is_empty(), "not taken from the file: {unset:?}");
    let key = ("job_planner".to_owned(), "phases_deg".to_owned());
    assert_eq!(set[&key], ParameterValue::DoubleArray(vec![210.0, 312.0, 30.0, 72.0]));
    std::fs::remove_file(switched_on).expect("it is ours");
}
