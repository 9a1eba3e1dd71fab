// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The grammar of `--ros-args`: a table of command lines with what real rcl makes of them (`args_table.json`; that it still does is
//! asked in `tests/interoperability/parameters.rs`), and what the table cannot show.

use super::*;
use crate::names::NodeNames;
use serde_json::{Map, Value, json};

fn parse(args: &[&str]) -> Result<(RosArgs, Vec<String>), ArgsError> {
    let args: Vec<String> = args.iter().map(ToString::to_string).collect();
    RosArgs::parse_with(&args, |_| None)
}

fn parse_env(variables: &[(&str, &str)]) -> Result<RosArgs, ArgsError> {
    let find = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.to_string());
    RosArgs::parse_with(&[], find).map(|(args, _)| args)
}

#[test]
fn an_error_names_the_flag_and_the_file() {
    for flag in ["-r", "--remap", "-p", "--param", "--params-file", "-e", "--log-level"] {
        assert_eq!(parse(&["--ros-args", flag]), Err(ArgsError::MissingValue { flag: flag.into() }));
    }
    let refused = parse(&["--ros-args", "-p", "foo:=[1, a]"]).expect_err("two types").to_string();
    assert!(refused.contains("-p foo:=[1, a]: ") && refused.contains("one type"), "{refused}");
    let refused = parse(&["--ros-args", "--params-file", "/nonexistent.yaml"]).expect_err("no file").to_string();
    assert!(refused.contains("/nonexistent.yaml"), "{refused}");
}

#[test]
fn scopes_open_and_close_and_the_rest_is_the_programs() {
    let (args, rest) = parse(&[
        "run",
        "--ros-args",
        "-r",
        "a:=b",
        "--",
        "job.yaml",
        "--ros-args",
        "--ros-args",
        "-p",
        "x:=1",
        "--",
        "--",
    ])
    .expect("valid");
    assert_eq!(rest, ["run", "job.yaml", "--"]);
    assert_eq!(args.remap_rules().len(), 1);
    assert_eq!(args.overrides.len(), 1);
    let (args, rest) = parse(&["--ros-args"]).expect("an empty scope is allowed");
    assert_eq!((args, rest), (RosArgs::default(), vec![]));
    let (args, _) = parse(&["--ros-args", "stray", "foo:=bar", "--unknown"]).expect("unknown tokens are left");
    assert_eq!(args.unparsed(), ["stray", "foo:=bar", "--unknown"]);
}

/// Every line that rclpy refuses as unknown is refused by programs, with the token and what may stand there.
#[test]
fn programs_refuse_unknown_tokens() {
    let words = |line: &Value| -> Vec<String> {
        line["args"].as_array().expect("a list").iter().filter_map(Value::as_str).map(str::to_owned).collect()
    };
    let table: Vec<Value> = serde_json::from_str(include_str!("args_table.json")).expect("the table is JSON");
    let unknown: Vec<_> = table.iter().filter(|line| line["rcl"] == "unknown").map(words).collect();
    assert!(unknown.len() >= 20, "{} lines", unknown.len());
    for args in unknown {
        let refused = RosArgs::parse(&args).map(drop);
        assert!(matches!(refused, Err(ArgsError::Unknown { .. })), "{args:?}: {refused:?}");
    }
    let text = |args: &[&str]| {
        let args: Vec<String> = args.iter().map(ToString::to_string).collect();
        RosArgs::parse(&args).expect_err("an unknown token").to_string()
    };
    let stray = text(&["run", "--ros-args", "-r", "a:=b", "--unknown"]);
    assert!(stray.starts_with("unknown ROS argument \"--unknown\"; after `--ros-args`: -r FROM:=TO"), "{stray}");
    let bare = text(&["--ros-args", "pace:=fast"]);
    assert!(bare.contains("did you mean `-r pace:=fast` or `-p pace:=fast`?"), "{bare}");
}

#[test]
fn log_levels_are_by_logger_and_the_last_wins() {
    let (args, _) = parse(&[
        "--ros-args",
        "--log-level",
        "WARN",
        "--log-level",
        "cell:=debug",
        "--log-level",
        "cell.machine:=Error",
        "--log-level",
        "cell.machine:=fatal",
    ])
    .expect("valid");
    assert_eq!(args.level_of("other"), Level::Warn);
    assert_eq!(args.level_of("cell"), Level::Debug);
    assert_eq!(args.level_of("cell.planner"), Level::Debug);
    assert_eq!(args.level_of("cellar"), Level::Warn);
    assert_eq!(args.level_of("cell.machine.axis"), Level::Fatal);
    for bad in ["foo", "", "node:=", ":=info", "node:=loud"] {
        assert!(parse(&["--ros-args", "--log-level", bad]).is_err(), "'{bad}' was accepted");
    }
}

#[test]
fn enclave_and_log_flags_are_read() {
    let (args, _) = parse(&[
        "--ros-args",
        "-e",
        "/foo/bar",
        "--disable-stdout-logs",
        "--disable-rosout-logs",
        "--enable-rosout-logs",
        "--disable-external-lib-logs",
        "--log-file-name",
        "x",
        "--log-config-file",
        "y",
    ])
    .expect("valid");
    assert_eq!(args.enclave(), Some("/foo/bar"));
    assert!(args.console().is_none() && args.rosout());
    assert!(args.unparsed().is_empty());
    assert!(parse(&["--ros-args", "-e", "relative"]).is_err());
    assert!(parse(&["--ros-args", "--enclave"]).is_err());
}

#[test]
fn the_environment_sets_domain_range_and_namespace() {
    assert_eq!(parse_env(&[]).expect("valid").discovery_range(), DiscoveryRange::Localhost);
    let args =
        parse_env(&[("ROS_DOMAIN_ID", "42"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_NAMESPACE", "cell1")])
            .expect("valid");
    assert_eq!((args.domain_id(), args.discovery_range()), (42, DiscoveryRange::Subnet));
    assert_eq!(args.default_namespace(), "/cell1");
    let args = parse_env(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_LOCALHOST_ONLY", "1")]).expect("valid");
    assert_eq!(args.discovery_range(), DiscoveryRange::Localhost);
    for bad in [
        ("ROS_DOMAIN_ID", "233"),
        ("ROS_DOMAIN_ID", "-1"),
        ("ROS_DOMAIN_ID", "x"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "HOST"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        ("ROS_LOCALHOST_ONLY", "yes"),
        ("ROS_NAMESPACE", "a b"),
    ] {
        assert!(parse_env(&[bad]).is_err(), "{bad:?} was accepted");
    }
}

#[test]
fn overrides_keep_the_order_of_the_command_line_and_their_node() {
    let (args, _) =
        parse(&["--ros-args", "-p", "x:=1", "-p", "other:x:=2", "-p", "x:=3", "-p", "me:y:=4"]).expect("valid");
    let found: Vec<(String, bool)> = args
        .overrides_for("me", "/ns/me")
        .into_iter()
        .map(|o| (format!("{}={:?}", o.name, o.value), o.explicit))
        .collect();
    assert_eq!(
        found,
        [("x=Integer(1)".to_string(), false), ("x=Integer(3)".to_string(), false), ("y=Integer(4)".to_string(), true)]
    );
}

/// Verdict of this crate on a command line, in the words of the table.
fn verdict(args: &[&str]) -> Value {
    let Ok((args, _)) = parse(args) else { return json!("refused") };
    if !args.unparsed().is_empty() {
        return json!("unknown");
    }
    let Ok(names) = NodeNames::new("talker", args.default_namespace(), args.remap_rules()) else {
        return json!("refused");
    };
    let changed = |kind: NameKind, names_before: &[(&str, &str)]| -> Value {
        let after = |name: &str| names.resolve(name, kind).unwrap_or_else(|error| error.to_string());
        let changed = names_before.iter().filter(|(name, before)| after(name) != **before);
        changed.map(|(name, _)| (name.to_string(), json!(after(name)))).collect::<Map<_, _>>().into()
    };
    let topics = changed(
        NameKind::Topic,
        &[("foo", "/foo"), ("/foo/bar", "/foo/bar"), ("~/foo", "/talker/foo"), ("chatter", "/chatter")],
    );
    let services = changed(NameKind::Service, &[("foo", "/foo"), ("~/foo", "/talker/foo")]);
    let overrides = args.overrides_for(names.node(), &names.fully_qualified());
    let parameters: Map<_, _> = overrides.into_iter().map(|given| (given.name, plain(&given.value))).collect();
    let all = [("node", json!(names.fully_qualified())), ("topics", topics), ("services", services)];
    let has_rule = |value: &Value| *value != json!({}) && *value != json!("/talker");
    let all = all.into_iter().chain([("parameters", parameters.into())]).filter(|(_, value)| has_rule(value));
    all.map(|(name, value)| (name.to_string(), value)).collect::<Map<_, _>>().into()
}

fn plain(value: &ParameterValue) -> Value {
    fn double(value: f64) -> Value {
        let text = if value.abs() >= 1e16 { format!("{value:e}").replace('e', "e+") } else { format!("{value:?}") };
        json!(format!("double {}", text.to_lowercase()))
    }
    match value {
        ParameterValue::NotSet => Value::Null,
        ParameterValue::Bool(value) => json!(value),
        ParameterValue::Integer(value) => json!(value),
        ParameterValue::Double(value) => double(*value),
        ParameterValue::String(value) => json!(value),
        ParameterValue::ByteArray(values) => json!(values),
        ParameterValue::BoolArray(values) => json!(values),
        ParameterValue::IntegerArray(values) => json!(values),
        ParameterValue::DoubleArray(values) => values.iter().map(|value| double(*value)).collect(),
        ParameterValue::StringArray(values) => json!(values),
    }
}

#[test]
fn command_lines_mean_what_they_mean_to_rcl() {
    let table: Vec<Value> = serde_json::from_str(include_str!("args_table.json")).expect("the table is JSON");
    assert!(table.len() > 300, "{} lines", table.len());
    let mut wrong = Vec::new();
    for line in &table {
        let args: Vec<&str> = line["args"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
        let (expected, found) = (line.get("ours").unwrap_or(&line["rcl"]), verdict(&args));
        if found != *expected {
            wrong.push(format!("{args:?}: {found} instead of {expected}"));
        }
        let deviates = line.get("ours").is_some_and(|ours| *ours != line["rcl"]);
        assert_eq!(deviates, line["because"].is_string(), "a deviation has a reason, and a reason a deviation: {line}");
    }
    assert!(wrong.is_empty(), "{} of {} lines:\n{}", wrong.len(), table.len(), wrong.join("\n"));
}

#[test]
fn a_quiet_console_shows_warnings_unless_a_level_is_asked_for() {
    let args = |words: &[&str]| parse(words).expect("arguments").0.with_console_level(Level::Warn);
    assert_eq!(args(&[]).console(), Some(Level::Warn));
    assert_eq!(args(&["--ros-args", "--log-level", "debug"]).console(), Some(Level::Unset));
    assert!(args(&[]).rosout(), "the bag holds every line");
}
