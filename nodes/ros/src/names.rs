// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names in the graph: rules, expansion of `~` and `{node}`, remapping, and their form on the wire.
//!
//! The crate below takes a relative name in a root-namespace node to `rt//rel` and knows neither `~` nor remapping, so every
//! name is made absolute here before the crate sees it.

/// Longest topic or service name that still fits the DDS limit of 255 with ROS 2's prefix and suffix (rmw).
const MAX_NAME_LENGTH: usize = 247;

/// A name that breaks the ROS 2 naming rules.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("name '{name}': {reason}")]
pub struct NameError {
    /// The name as given.
    pub name: String,
    /// The rule it breaks.
    pub reason: String,
}

fn refuse<T>(name: &str, reason: impl Into<String>) -> Result<T, NameError> {
    Err(NameError { name: name.to_string(), reason: reason.into() })
}

/// One token between slashes: `[A-Za-z_][A-Za-z0-9_]*` without `__`.
fn check_token(whole: &str, token: &str) -> Result<(), NameError> {
    let Some(first) = token.chars().next() else {
        return refuse(whole, "has an empty part between slashes");
    };
    if first.is_ascii_digit() {
        return refuse(whole, format!("part '{token}' starts with a digit"));
    }
    if let Some(bad) = token.chars().find(|c| !(c.is_ascii_alphanumeric() || *c == '_')) {
        return refuse(whole, format!("character '{bad}' is not allowed"));
    }
    if token.contains("__") {
        return refuse(whole, "has two underscores in a row");
    }
    Ok(())
}

/// Checks a base node name.
pub(super) fn check_node_name(name: &str) -> Result<(), NameError> {
    if name.is_empty() {
        return refuse(name, "a node name must not be empty");
    }
    if name.len() > 255 {
        return refuse(name, "a node name has at most 255 characters");
    }
    check_token(name, name)
}

/// Checks an absolute namespace, `/` or `/a/b`.
pub(super) fn check_namespace(namespace: &str) -> Result<(), NameError> {
    if namespace == "/" {
        return Ok(());
    }
    check_absolute(namespace)
}

/// Checks a fully qualified name such as `/cell/machine/stream`.
pub(super) fn check_absolute(name: &str) -> Result<(), NameError> {
    let Some(rest) = name.strip_prefix('/') else {
        return refuse(name, "must begin with a slash");
    };
    if name.len() > MAX_NAME_LENGTH {
        return refuse(name, format!("is longer than {MAX_NAME_LENGTH} characters"));
    }
    rest.split('/').try_for_each(|token| check_token(name, token))
}

/// Joins a namespace and a relative name.
pub(super) fn join(namespace: &str, name: &str) -> String {
    if namespace == "/" { format!("/{name}") } else { format!("{namespace}/{name}") }
}

/// Makes a name absolute: `~` and `~/x` belong to the node, `{node}`, `{ns}` and `{namespace}` are replaced, anything else that
/// does not begin with a slash belongs to the namespace.
pub(super) fn expand(name: &str, node: &str, namespace: &str) -> Result<String, NameError> {
    if name.is_empty() {
        return refuse(name, "must not be empty");
    }
    let mut text = String::with_capacity(name.len());
    let mut rest = name;
    while let Some(open) = rest.find(['{', '}']) {
        if rest.as_bytes()[open] == b'}' {
            return refuse(name, "has an unbalanced '}'");
        }
        text.push_str(&rest[..open]);
        let Some(close) = rest[open..].find('}') else {
            return refuse(name, "has an unbalanced '{'");
        };
        match &rest[open + 1..open + close] {
            "node" => text.push_str(node),
            "ns" | "namespace" => text.push_str(namespace),
            other => return refuse(name, format!("'{{{other}}}' is not a known substitution")),
        }
        rest = &rest[open + close + 1..];
    }
    text.push_str(rest);
    let absolute = if text == "~" {
        join(namespace, node)
    } else if let Some(private) = text.strip_prefix("~/") {
        join(&join(namespace, node), private)
    } else if text.starts_with('/') {
        text
    } else if text.starts_with('~') {
        return refuse(name, "'~' must be followed by a slash");
    } else {
        join(namespace, &text)
    };
    check_absolute(&absolute).map_err(|error| NameError { name: name.to_string(), reason: error.reason })?;
    Ok(absolute)
}

/// Topics and services have rules of their own (`rostopic://`, `rosservice://`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NameKind {
    Topic,
    /// A service (also one of those an action is made of).
    Service,
}

/// Kind of name that a remapping rule changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum RemapTarget {
    /// `__node:=name`.
    NodeName,
    /// `__ns:=/namespace`.
    Namespace,
    /// `from:=to`, for topics, services or both.
    Name {
        /// Only this kind; `None` is both.
        kind: Option<NameKind>,
        /// The left side, as written.
        from: String,
    },
}

/// One `-r` rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RemapRule {
    /// Only for the node of this name.
    pub(super) node: Option<String>,
    pub(super) target: RemapTarget,
    /// The right side, as written.
    pub(super) to: String,
}

impl RemapRule {
    fn is_for(&self, node: &str) -> bool {
        self.node.as_deref().is_none_or(|only| only == node)
    }
}

/// The resolved identity of a node and the rules that apply to its names.
#[derive(Debug, Clone)]
pub(super) struct NodeNames {
    node: String,
    namespace: String,
    rules: Vec<RemapRule>,
}

impl NodeNames {
    /// Applies the node and namespace rules (the first matching rule wins) to a default identity.
    pub(super) fn new(default_node: &str, default_namespace: &str, rules: &[RemapRule]) -> Result<Self, NameError> {
        let first = |wanted: &RemapTarget, node: &str| {
            let mut rules = rules.iter().filter(|rule| rule.is_for(node));
            rules.find(|rule| rule.target == *wanted).map(|rule| rule.to.clone())
        };
        let node = first(&RemapTarget::NodeName, default_node).unwrap_or_else(|| default_node.to_string());
        // All rules but that for the name itself know a node by the name that it has got.
        let namespace = first(&RemapTarget::Namespace, &node).unwrap_or_else(|| default_namespace.to_string());
        let rules = rules.iter().filter(|rule| rule.is_for(&node)).cloned().collect();
        check_node_name(&node)?;
        check_namespace(&namespace)?;
        Ok(NodeNames { node, namespace, rules })
    }

    /// Base name of the node.
    pub(super) fn node(&self) -> &str {
        &self.node
    }

    /// Namespace, `/` or `/a/b`.
    pub(super) fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Namespace and name, `/a/b/node`.
    pub(super) fn fully_qualified(&self) -> String {
        join(&self.namespace, &self.node)
    }

    /// Name of the node's logger, `a.b.node`.
    pub(super) fn logger(&self) -> String {
        self.fully_qualified().trim_start_matches('/').replace('/', ".")
    }

    /// Expands a name and applies the first rule that matches it.
    pub(super) fn resolve(&self, name: &str, kind: NameKind) -> Result<String, NameError> {
        let absolute = expand(name, &self.node, &self.namespace)?;
        for rule in &self.rules {
            let RemapTarget::Name { kind: only, from } = &rule.target else { continue };
            if only.is_some_and(|only| only != kind) {
                continue;
            }
            if expand(from, &self.node, &self.namespace)? == absolute {
                return expand(&rule.to, &self.node, &self.namespace);
            }
        }
        Ok(absolute)
    }
}

/// DDS name of a topic.
pub(super) fn dds_topic(absolute: &str) -> String {
    format!("rt{absolute}")
}

/// DDS names of a service: request and reply topic.
pub(super) fn dds_service(absolute: &str) -> (String, String) {
    (format!("rq{absolute}Request"), format!("rr{absolute}Reply"))
}

/// ROS name of a DDS topic, if it is one.
pub(super) fn ros_topic(dds: &str) -> Option<&str> {
    dds.strip_prefix("rt").filter(|rest| rest.starts_with('/'))
}

/// ROS name of the service whose requests travel on a DDS topic.
pub(super) fn ros_service(dds: &str) -> Option<&str> {
    dds.strip_prefix("rq")?.strip_suffix("Request").filter(|name| name.starts_with('/'))
}

/// `pkg/msg/Type` to `pkg::msg::dds_::Type_`.
pub(super) fn dds_type(ros: &str) -> Option<String> {
    let mut parts = ros.split('/');
    match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(package), Some(kind), Some(name), None) if !package.is_empty() && !name.is_empty() => {
            Some(format!("{package}::{kind}::dds_::{name}_"))
        }
        _ => None,
    }
}

/// `pkg::msg::dds_::Type_` to `pkg/msg/Type`; a type that is not ROS's stays as it is.
pub(super) fn ros_type(dds: &str) -> String {
    match dds.split_once("::dds_::").and_then(|(scope, name)| Some((scope, name.strip_suffix('_')?))) {
        Some((scope, name)) => format!("{}/{name}", scope.replace("::", "/")),
        None => dds.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(from: &str, to: &str) -> RemapRule {
        RemapRule { node: None, target: RemapTarget::Name { kind: None, from: from.to_string() }, to: to.to_string() }
    }

    #[test]
    fn relative_private_and_absolute_names_expand() {
        for (name, namespace, expected) in [
            ("joint_states", "/", "/joint_states"),
            ("joint_states", "/cell", "/cell/joint_states"),
            ("~/state", "/", "/node/state"),
            ("~/state", "/a/b", "/a/b/node/state"),
            ("~", "/a", "/a/node"),
            ("/rosout", "/a", "/rosout"),
            ("{node}/x", "/a", "/a/node/x"),
            ("{ns}/x", "/a", "/a/x"),
            ("~/_action/feedback", "/", "/node/_action/feedback"),
        ] {
            assert_eq!(expand(name, "node", namespace).as_deref(), Ok(expected), "{name} in {namespace}");
        }
    }

    #[test]
    fn names_that_break_the_rules_are_refused() {
        for name in
            ["", "a b", "1a", "a//b", "a/", "/", "~a", "{nod}/x", "a{", "a}", "a__b", "a/2b", "a-b", "~/", "/a/", "é"]
        {
            assert!(expand(name, "node", "/ns").is_err(), "'{name}' was accepted");
        }
        assert!(expand(&format!("/{}", "a".repeat(MAX_NAME_LENGTH)), "node", "/").is_err());
        for node in ["", "a/b", "9a", "a b", "a__b"] {
            assert!(check_node_name(node).is_err(), "node name '{node}' was accepted");
        }
        for namespace in ["", "a", "/a/", "//"] {
            assert!(check_namespace(namespace).is_err(), "namespace '{namespace}' was accepted");
        }
    }

    #[test]
    fn the_first_matching_rule_wins_and_both_sides_are_expanded() {
        let names = NodeNames::new("node", "/ns", &[rule("~/a", "b"), rule("/ns/node/a", "/never"), rule("c", "~/d")])
            .expect("valid");
        assert_eq!(names.resolve("~/a", NameKind::Topic).as_deref(), Ok("/ns/b"));
        assert_eq!(names.resolve("/ns/c", NameKind::Service).as_deref(), Ok("/ns/node/d"));
        assert_eq!(names.resolve("e", NameKind::Topic).as_deref(), Ok("/ns/e"));
    }

    #[test]
    fn a_rule_for_one_kind_or_another_node_leaves_the_rest_alone() {
        let mut topics_only = rule("a", "b");
        topics_only.target = RemapTarget::Name { kind: Some(NameKind::Topic), from: "a".into() };
        let mut other_node = rule("c", "d");
        other_node.node = Some("other".into());
        let names = NodeNames::new("node", "/", &[topics_only, other_node]).expect("valid");
        assert_eq!(names.resolve("a", NameKind::Topic).as_deref(), Ok("/b"));
        assert_eq!(names.resolve("a", NameKind::Service).as_deref(), Ok("/a"));
        assert_eq!(names.resolve("c", NameKind::Topic).as_deref(), Ok("/c"));
    }

    #[test]
    fn wire_names_and_types_go_both_ways() {
        assert_eq!(dds_topic("/a/b"), "rt/a/b");
        assert_eq!(ros_topic("rt/a/b"), Some("/a/b"));
        assert_eq!(ros_topic("ros_discovery_info"), None);
        assert_eq!(dds_service("/a/s"), ("rq/a/sRequest".to_string(), "rr/a/sReply".to_string()));
        assert_eq!(dds_type("std_msgs/msg/String").as_deref(), Some("std_msgs::msg::dds_::String_"));
        assert_eq!(dds_type("String"), None);
        assert_eq!(ros_type("std_msgs::msg::dds_::String_"), "std_msgs/msg/String");
        assert_eq!(ros_type("odd"), "odd");
    }

    #[test]
    fn node_and_namespace_rules_make_the_identity() {
        let rules = [
            RemapRule { node: Some("other".into()), target: RemapTarget::NodeName, to: "x".into() },
            RemapRule { node: None, target: RemapTarget::NodeName, to: "renamed".into() },
            RemapRule { node: None, target: RemapTarget::Namespace, to: "/cell1".into() },
            RemapRule { node: None, target: RemapTarget::Namespace, to: "/cell2".into() },
        ];
        let names = NodeNames::new("node", "/", &rules).expect("valid");
        assert_eq!(names.fully_qualified(), "/cell1/renamed");
        assert_eq!(names.logger(), "cell1.renamed");
    }
}
