// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The six parameter services and `/parameter_events`.

use std::{collections::BTreeSet, sync::Arc};

use camwright_msgs::rcl_interfaces::{
    msg::{
        FloatingPointRange, IntegerRange, ListParametersResult, Parameter as ParameterMsg, ParameterDescriptor,
        ParameterEvent, ParameterValue as ValueMsg, SetParametersResult,
    },
    srv::{
        DescribeParameters, DescribeParametersResponse, GetParameterTypes, GetParameterTypesResponse, GetParameters,
        GetParametersResponse, ListParameters, ListParametersResponse, SetParameters, SetParametersAtomically,
        SetParametersAtomicallyResponse, SetParametersResponse,
    },
};

use super::{
    clock::{RosClock, to_time},
    error::RosError,
    logging::Logger,
    node::Node,
    parameter_value::ParameterValue,
    parameters::{Parameter, ParameterChanges, ParameterRange, Parameters},
    qos::Qos,
    topics::Publisher,
};

struct ParameterEvents {
    publisher: Publisher<ParameterEvent>,
    node: String,
    clock: Arc<RosClock>,
    logger: Logger,
}

impl ParameterEvents {
    fn publish(&self, declared: &ParameterChanges, changed: &ParameterChanges) {
        let list = |values: &ParameterChanges| {
            values.iter().map(|(name, value)| ParameterMsg { name: name.clone(), value: to_msg(value) }).collect()
        };
        let event = ParameterEvent {
            stamp: to_time(self.clock.now_ns()),
            node: self.node.clone(),
            new_parameters: list(declared),
            changed_parameters: list(changed),
            ..Default::default()
        };
        if let Err(error) = self.publisher.publish(&event) {
            self.logger.warn(&error.to_string());
        }
    }
}

/// Publishes the declared parameters, and every change from now on.
pub(super) fn publish_events(node: &Node) -> Result<(), RosError> {
    let events = ParameterEvents {
        publisher: node.publisher("/parameter_events", &Qos::parameter_events())?,
        node: node.fully_qualified_name(),
        clock: Arc::clone(node.clock()),
        logger: node.logger().clone(),
    };
    events.publish(&node.parameters().all(), &[]);
    node.parameters().publish_changes(move |changes| events.publish(&[], changes));
    Ok(())
}

fn to_msg(value: &ParameterValue) -> ValueMsg {
    let mut msg = ValueMsg { type_: value.type_id(), ..Default::default() };
    match value.clone() {
        ParameterValue::NotSet => {}
        ParameterValue::Bool(value) => msg.bool_value = value,
        ParameterValue::Integer(value) => msg.integer_value = value,
        ParameterValue::Double(value) => msg.double_value = value,
        ParameterValue::String(value) => msg.string_value = value,
        ParameterValue::ByteArray(values) => msg.byte_array_value = values,
        ParameterValue::BoolArray(values) => msg.bool_array_value = values,
        ParameterValue::IntegerArray(values) => msg.integer_array_value = values,
        ParameterValue::DoubleArray(values) => msg.double_array_value = values,
        ParameterValue::StringArray(values) => msg.string_array_value = values,
    }
    msg
}

/// The value of a message, or why it is none.
fn from_msg(name: &str, msg: ValueMsg) -> Result<ParameterValue, String> {
    Ok(match msg.type_ {
        0 => ParameterValue::NotSet,
        1 => ParameterValue::Bool(msg.bool_value),
        2 => ParameterValue::Integer(msg.integer_value),
        3 => ParameterValue::Double(msg.double_value),
        4 => ParameterValue::String(msg.string_value),
        5 => ParameterValue::ByteArray(msg.byte_array_value),
        6 => ParameterValue::BoolArray(msg.bool_array_value),
        7 => ParameterValue::IntegerArray(msg.integer_array_value),
        8 => ParameterValue::DoubleArray(msg.double_array_value),
        9 => ParameterValue::StringArray(msg.string_array_value),
        other => return Err(format!("parameter '{name}': {other} is not a parameter type")),
    })
}

fn descriptor(declaration: Parameter) -> ParameterDescriptor {
    let mut descriptor = ParameterDescriptor {
        type_: declaration.example.type_id(),
        dynamic_typing: declaration.is_optional(),
        name: declaration.name,
        description: declaration.description,
        additional_constraints: declaration.constraints,
        read_only: declaration.read_only,
        ..Default::default()
    };
    match declaration.range {
        None => {}
        Some(ParameterRange::Double { from, to, step }) => {
            descriptor.floating_point_range = vec![FloatingPointRange { from_value: from, to_value: to, step }];
        }
        Some(ParameterRange::Integer { from, to, step }) => {
            descriptor.integer_range = vec![IntegerRange { from_value: from, to_value: to, step }];
        }
    }
    descriptor
}

/// rclcpp's rule: names below one of the prefixes (or all), at most `depth` levels below it; 0 is without limit.
fn list(names: &[String], prefixes: &[String], depth: u64) -> ListParametersResult {
    let levels = |rest: &str| rest.matches('.').count() as u64;
    let wanted = |name: &str| {
        if prefixes.is_empty() {
            return depth == 0 || levels(name) < depth;
        }
        prefixes.iter().any(|prefix| match name.strip_prefix(prefix.as_str()) {
            Some("") => true,
            Some(rest) => rest.strip_prefix('.').is_some_and(|rest| depth == 0 || levels(rest) < depth),
            None => false,
        })
    };
    let names: Vec<String> = names.iter().filter(|name| wanted(name)).cloned().collect();
    let prefixes: BTreeSet<String> =
        names.iter().filter_map(|name| name.rsplit_once('.')).map(|(prefix, _)| prefix.to_string()).collect();
    ListParametersResult { names, prefixes: prefixes.into_iter().collect() }
}

fn set(parameters: &Parameters, wanted: Vec<ParameterMsg>) -> SetParametersResult {
    let changes =
        wanted.into_iter().map(|parameter| Ok((parameter.name.clone(), from_msg(&parameter.name, parameter.value)?)));
    let outcome = changes.collect::<Result<Vec<_>, String>>().and_then(|changes| parameters.set_all(changes));
    match outcome {
        Ok(()) => SetParametersResult { successful: true, reason: String::new() },
        Err(reason) => SetParametersResult { successful: false, reason },
    }
}

/// Offers the six services.
///
/// `list_parameters` leaves out optional parameters without a value. `ros2 param dump` writes a null for each, which neither
/// `ros2 param load` nor a node that is started with the file accepts.
pub(super) fn offer(node: &Node) -> Result<(), RosError> {
    let parameters = node.parameters();
    let qos = Qos::parameters();

    let store = parameters.clone();
    node.retain(node.builtin_service::<GetParameters>("get_parameters", &qos, move |request| {
        let values =
            request.names.iter().map(|name| store.get(name).as_ref().map(to_msg).unwrap_or_default()).collect();
        GetParametersResponse { values }
    })?);

    let store = parameters.clone();
    node.retain(node.builtin_service::<GetParameterTypes>("get_parameter_types", &qos, move |request| {
        let types = request.names.iter().map(|name| store.get(name).map_or(0, |value| value.type_id())).collect();
        GetParameterTypesResponse { types }
    })?);

    let store = parameters.clone();
    node.retain(node.builtin_service::<SetParameters>("set_parameters", &qos, move |request| {
        let results = request.parameters.into_iter().map(|parameter| set(&store, vec![parameter])).collect();
        SetParametersResponse { results }
    })?);

    let store = parameters.clone();
    node.retain(node.builtin_service::<SetParametersAtomically>(
        "set_parameters_atomically",
        &qos,
        move |request| SetParametersAtomicallyResponse { result: set(&store, request.parameters) },
    )?);

    let store = parameters.clone();
    node.retain(node.builtin_service::<DescribeParameters>("describe_parameters", &qos, move |request| {
        let unknown = |name: &String| ParameterDescriptor { name: name.clone(), ..Default::default() };
        let descriptors = request
            .names
            .iter()
            .map(|name| store.declaration(name).map_or_else(|| unknown(name), descriptor))
            .collect();
        DescribeParametersResponse { descriptors }
    })?);

    let store = parameters.clone();
    node.retain(node.builtin_service::<ListParameters>("list_parameters", &qos, move |request| {
        ListParametersResponse { result: list(&store.names_with_values(), &request.prefixes, request.depth) }
    })?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn listing_follows_prefixes_and_depth() {
        let names: Vec<String> = ["a", "b.c", "b.d.e", "bc.x"].iter().map(ToString::to_string).collect();
        let all = list(&names, &[], 0);
        assert_eq!(all.names, names);
        assert_eq!(all.prefixes, ["b", "b.d", "bc"]);
        assert_eq!(list(&names, &[], 1).names, ["a"]);
        assert_eq!(list(&names, &["b".into()], 0).names, ["b.c", "b.d.e"]);
        assert_eq!(list(&names, &["b".into()], 1).names, ["b.c"]);
        assert_eq!(list(&names, &["a".into()], 0).names, ["a"]);
        assert!(list(&names, &["c".into()], 0).names.is_empty());
    }

    #[test]
    fn values_survive_the_way_through_messages() {
        for value in [
            ParameterValue::NotSet,
            ParameterValue::Bool(true),
            ParameterValue::Integer(-3),
            ParameterValue::Double(0.1),
            ParameterValue::String("ä".into()),
            ParameterValue::ByteArray(vec![0, 255]),
            ParameterValue::BoolArray(vec![true]),
            ParameterValue::IntegerArray(vec![1, 2]),
            ParameterValue::DoubleArray(vec![0.5]),
            ParameterValue::StringArray(vec!["x".into()]),
        ] {
            assert_eq!(from_msg("p", to_msg(&value)), Ok(value));
        }
        assert_eq!(
            from_msg("p", ValueMsg::default()),
            Ok(ParameterValue::NotSet),
            "the store refuses it where it must"
        );
        assert!(from_msg("p", ValueMsg { type_: 10, ..Default::default() }).is_err());
    }
}
