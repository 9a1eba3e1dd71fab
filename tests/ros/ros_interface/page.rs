// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The pages as Markdown.

use super::collect::{Call, Interface, Topic, split_common};
use super::interface_files::{self, cell};
use super::texts;
use camwright_authority::{Access, access};
use camwright_ros::{Durability, History, Parameter, ParameterValue, Qos, Reliability};
use std::collections::BTreeMap;

/// Units that descriptions of parameters name in parentheses.
const UNITS: [&str; 20] = [
    "s",
    "ms",
    "Hz",
    "m",
    "mm",
    "um",
    "rad",
    "deg",
    "rpm",
    "MB",
    "mm/s",
    "m/s or rad/s",
    "mm/s²",
    "mm²/s",
    "W/mm",
    "J/mm³",
    "N/mm²",
    "µm",
    "m or rad",
    "mm³/(mm s)",
];

/// End of the description of a parameter that overrides a key of the job file.
const FROM_JOB: &str = "; not set: the value of the job file";

/// Reliability, durability and depth.
fn qos(qos: &Qos) -> String {
    let reliability = match qos.reliability {
        Reliability::Reliable => "reliable",
        Reliability::BestEffort => "best effort",
    };
    let durability = match qos.durability {
        Durability::TransientLocal => "transient local",
        Durability::Volatile => "volatile",
    };
    match qos.history {
        History::KeepLast(depth) => format!("{reliability}, {durability}, {depth}"),
        History::KeepAll => format!("{reliability}, {durability}, all"),
    }
}

fn linked(type_name: &str) -> String {
    match type_name.strip_prefix("camwright_msgs/").and_then(|rest| rest.split_once('/')) {
        Some((_, name)) => format!("[{type_name}](types.md#{})", name.to_lowercase()),
        None => type_name.to_owned(),
    }
}

fn meaning(name: &str, type_name: &str, only_with: Option<&str>) -> String {
    let text = cell(&texts::meaning(name, type_name).unwrap_or_default());
    only_with.map_or_else(|| text.clone(), |equipment| format!("{} (only {equipment}).", text.trim_end_matches('.')))
}

fn access_of_service(name: &str, has_authority: bool) -> String {
    match access(name) {
        _ if !has_authority => "open".into(),
        Access::Open => "open".into(),
        Access::OpenFor(requests) => format!("open for {requests}; else needs command"),
        Access::Command => "needs command".into(),
    }
}

/// Title with a table below; nothing without rows.
fn section(title: &str, head: &str, rows: &[String]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let bar = "|---".repeat(head.matches('|').count() - 1);
    format!("\n## {title}\n\n{head}\n{bar}|\n{}", rows.concat())
}

fn published(topics: &[Topic]) -> String {
    let row = |Topic { name, type_name, qos: profile, only_with }: &Topic| {
        format!("| `{name}` | {} | {} | {} |\n", linked(type_name), qos(profile), meaning(name, type_name, *only_with))
    };
    let rows: Vec<String> = topics.iter().map(row).collect();
    section("Published topics", "| topic | type | QoS | meaning |", &rows)
}

fn subscribed(topics: &[Topic]) -> String {
    let row = |Topic { name, type_name, qos: profile, only_with }: &Topic| {
        let sender = texts::sender(name).unwrap_or_default();
        let meaning = meaning(name, type_name, *only_with);
        format!("| `{name}` | {} | {} | {sender} | {meaning} |\n", linked(type_name), qos(profile))
    };
    let rows: Vec<String> = topics.iter().map(row).collect();
    section("Subscribed topics", "| topic | type | QoS | accepted from | meaning |", &rows)
}

fn services(calls: &[Call], has_authority: bool) -> String {
    let row = |Call { name, type_name, only_with }: &Call| {
        let (access, meaning) = (access_of_service(name, has_authority), meaning(name, type_name, *only_with));
        format!("| `{name}` | {} | {access} | {meaning} |\n", linked(type_name))
    };
    let rows: Vec<String> = calls.iter().map(row).collect();
    section("Services", "| service | type | access | meaning |", &rows)
}

fn actions(calls: &[Call], has_authority: bool) -> String {
    let row = |Call { name, type_name, only_with }: &Call| {
        let access = |part: &str| access_of_service(&format!("{name}/_action/{part}"), has_authority);
        let (goal, cancel) = (access("send_goal"), access("cancel_goal"));
        let meaning = meaning(name, type_name, *only_with);
        format!("| `{name}` | {} | goal: {goal}; cancel: {cancel} | {meaning} |\n", linked(type_name))
    };
    let rows: Vec<String> = calls.iter().map(row).collect();
    section("Actions", "| action | type | access | meaning |", &rows)
}

fn value(value: &ParameterValue) -> String {
    let list = |texts: Vec<String>| format!("`[{}]`", texts.join(", "));
    match value {
        ParameterValue::NotSet => "not set".into(),
        ParameterValue::Double(value) => format!("`{value:?}`"),
        ParameterValue::String(text) => format!("`'{text}'`"),
        ParameterValue::StringArray(texts) => list(texts.iter().map(|text| format!("'{text}'")).collect()),
        ParameterValue::DoubleArray(values) => list(values.iter().map(|value| format!("{value:?}")).collect()),
        ParameterValue::IntegerArray(values) => list(values.iter().map(ToString::to_string).collect()),
        other => format!("`{other}`"),
    }
}

/// Unit that a description names in parentheses.
fn unit(description: &str) -> &str {
    let parts = description.split('(').skip(1).filter_map(|rest| rest.split(')').next());
    parts.filter_map(|part| part.split(',').next()).find(|part| UNITS.contains(part)).unwrap_or_default()
}

fn parameters(parameters: &[Parameter]) -> String {
    let row = |parameter: &Parameter| {
        let name = parameter.name();
        let allowed = parameter.allowed().unwrap_or_else(|| parameter.constraint_text().to_owned());
        let change = if parameter.is_read_only() { "at start" } else { "any time" };
        let description = parameter.description();
        let (default, description) = match description.strip_suffix(FROM_JOB) {
            Some(description) => ("from the job file".to_owned(), description),
            None => (value(parameter.default_value()), description),
        };
        let (allowed, text, unit) = (cell(&allowed), cell(description), unit(description));
        format!("| `{name}` | {} | {default} | {allowed} | {unit} | {change} | {text} |\n", parameter.type_name())
    };
    let rows: Vec<String> = parameters.iter().map(row).collect();
    section("Parameters", "| parameter | type | default | allowed | unit | set | meaning |", &rows)
}

fn called(calls: &[Call]) -> String {
    let names: Vec<String> = calls.iter().map(|call| format!("`{}`", call.name)).collect();
    if names.is_empty() { String::new() } else { format!("\nIt calls the action {}.\n", names.join(", ")) }
}

fn body(interface: &Interface) -> String {
    let Interface { has_authority, .. } = *interface;
    [
        published(&interface.published),
        subscribed(&interface.subscribed),
        services(&interface.services, has_authority),
        actions(&interface.actions, has_authority),
        parameters(&interface.parameters),
    ]
    .concat()
}

fn node_page(interface: &Interface) -> String {
    let (node, purpose) = (&interface.node, texts::purpose(&interface.node));
    let lease = if interface.has_authority {
        ""
    } else {
        "\nThe lease of command does not apply to this node: every client may use it.\n"
    };
    format!(
        "# `{node}`\n\nGenerated from the running node. {purpose}\n{}{lease}\nNames are relative to the namespace; `~/` stands for `{node}/`. \
         [Overview](overview.md) explains QoS and access and lists the elements of\nevery node.\n{}",
        called(&interface.called_actions),
        body(interface)
    )
}

/// Text of every page by its file name.
pub(super) fn all(interfaces: &[Interface]) -> BTreeMap<String, String> {
    let mut interfaces = interfaces.to_vec();
    let common = split_common(&mut interfaces);
    let mut pages: BTreeMap<String, String> =
        interfaces.iter().map(|interface| (format!("{}.md", interface.node), node_page(interface))).collect();
    let row = |interface: &Interface| {
        let Interface { node, published, subscribed, services, actions, .. } = interface;
        format!(
            "| [`{node}`]({node}.md) | {} | {} / {} | {} | {} |\n",
            cell(texts::purpose(node).trim_end_matches('.')),
            published.len(),
            subscribed.len(),
            services.len(),
            actions.len()
        )
    };
    let rows: String = interfaces.iter().map(row).collect();
    let open: Vec<String> =
        interfaces.iter().filter(|node| !node.has_authority).map(|node| format!("`{}`", node.node)).collect();
    let open = if open.is_empty() { String::new() } else { format!(" All of them are open on {}.", open.join(", ")) };
    let every_node = body(&common).replace("\n## ", "\n### ");
    let text = [texts::HEAD, &rows, texts::EVERY_NODE, &open, "\n", &every_node].concat();
    pages.insert("overview.md".into(), text);
    pages.insert("types.md".into(), interface_files::page());
    pages
}
