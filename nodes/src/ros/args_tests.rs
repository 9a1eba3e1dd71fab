//! The grammar of `--ros-args`, after rcl's own table of valid and invalid forms.

use super::*;

fn parse(args: &[&str]) -> Result<(RosArgs, Vec<String>), ArgsError> {
    let args: Vec<String> = args.iter().map(ToString::to_string).collect();
    RosArgs::parse_with(&args, |_| None)
}

fn parse_env(variables: &[(&str, &str)]) -> Result<RosArgs, ArgsError> {
    let find = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.to_string());
    RosArgs::parse_with(&[], find).map(|(args, _)| args)
}

#[test]
fn valid_remap_rules_are_accepted() {
    for rule in [
        "__node:=node_name",
        "__name:=node_name",
        "old_name:__node:=node_name",
        "old_name:__node:=nodename123",
        "__node:=nodename123",
        "__ns:=/foo/bar",
        "__ns:=/",
        "_:__ns:=/",
        "nodename:__ns:=/foobar",
        "foo:=bar",
        "~/foo:=~/bar",
        "/foo/bar:=bar",
        "foo:=/bar",
        "/foo123:=/bar123",
        "node:/foo123:=/bar123",
        "rostopic:/foo/bar:=baz",
        "rosservice:baz:=foo",
        "rostopic://rostopic:=rosservice",
        "rostopic:///rosservice:=rostopic",
        "rostopic:///foo/bar:=baz",
        "rosservice://foo:=bar",
        "node:rostopic://foo:=bar",
        "{node}/foo:=/{ns}bar",
    ] {
        if rule.ends_with("{ns}bar") {
            // `{ns}` begins with a slash, so this doubles it.
            assert!(parse(&["--ros-args", "-r", rule]).is_err(), "{rule}");
            continue;
        }
        for flag in ["-r", "--remap"] {
            let (args, rest) = parse(&["--ros-args", flag, rule]).unwrap_or_else(|error| panic!("{rule}: {error}"));
            assert_eq!(args.remap_rules().len(), 1, "{rule}");
            assert!(rest.is_empty() && args.unparsed().is_empty());
        }
    }
}

#[test]
fn malformed_remap_rules_are_hard_errors() {
    for rule in [
        ":=",
        "foo:=",
        ":=bar",
        "__ns:=",
        "__node:=",
        "__node:=/foo/bar",
        "__ns:=foo",
        ":__node:=nodename",
        "~:__node:=nodename",
        "}foo:=/bar",
        "f oo:=/bar",
        "foo:=/b ar",
        "f{oo:=/bar",
        "foo:=/b}ar",
        "rostopic://:=rosservice",
        "rostopic::=rosservice",
        "foo",
        "foo=bar",
        "foo:bar",
        "/foo/*:=/bar",
        "/foo/**:=/bar",
        r"foo:=/bar\1",
        "foo/:=bar",
        "foo:=bar/",
        "foo:=rostopic://bar",
        "1foo:=bar",
        "foo//bar:=baz",
        "__ns:=/foo/",
        "__node:=9",
    ] {
        assert!(parse(&["--ros-args", "-r", rule]).is_err(), "'{rule}' was accepted");
    }
    assert_eq!(parse(&["--ros-args", "-r"]), Err(ArgsError::MissingValue { flag: "-r".into() }));
}

#[test]
fn valid_parameter_rules_carry_yaml_values() {
    use ParameterValue as V;
    let expected: [(&str, Option<&str>, &str, V); 12] = [
        ("foo:=bar", None, "foo", V::String("bar".into())),
        ("foo:=true", None, "foo", V::Bool(true)),
        ("foo.bar:=1", None, "foo.bar", V::Integer(1)),
        ("foo:=1.0", None, "foo", V::Double(1.0)),
        ("foo:=1e-3", None, "foo", V::Double(1e-3)),
        ("node:foo:=bar", Some("node"), "foo", V::String("bar".into())),
        ("foo:=[1, 2]", None, "foo", V::IntegerArray(vec![1, 2])),
        ("foo:=[1.0, 2.5]", None, "foo", V::DoubleArray(vec![1.0, 2.5])),
        ("foo:=[a, 'b c']", None, "foo", V::StringArray(vec!["a".into(), "b c".into()])),
        ("foo:=\"12\"", None, "foo", V::String("12".into())),
        ("foo:=a:=b", None, "foo", V::String("a:=b".into())),
        (
            "qos_overrides./foo/bar.publisher.history:=keep_last",
            None,
            "qos_overrides./foo/bar.publisher.history",
            V::String("keep_last".into()),
        ),
    ];
    for (rule, node, name, value) in expected {
        let (args, _) = parse(&["--ros-args", "-p", rule]).unwrap_or_else(|error| panic!("{rule}: {error}"));
        let item = Override::One { node: node.map(str::to_string), name: name.into(), value };
        assert_eq!(args.overrides, vec![item], "{rule}");
    }
}

#[test]
fn malformed_parameter_rules_are_hard_errors() {
    for rule in [
        ":=",
        "foo:=",
        ":=bar",
        "foo",
        "__ns:=/x",
        "__node:=x",
        "}foo:=1",
        "f oo:=1",
        "~node:foo:=1",
        ":foo:=1",
        "a:b:c:=1",
        "foo:=[1, a]",
        "foo:=[1",
        "foo:={a: 1}",
        "1a:=1",
    ] {
        assert!(parse(&["--ros-args", "-p", rule]).is_err(), "'{rule}' was accepted");
    }
    assert!(parse(&["--ros-args", "--param"]).is_err());
    assert!(parse(&["--ros-args", "--params-file"]).is_err());
    assert!(matches!(parse(&["--ros-args", "--params-file", "/nonexistent.yaml"]), Err(ArgsError::ParamsFile { .. })));
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
    assert!(!args.console() && args.rosout());
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
