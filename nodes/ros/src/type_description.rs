// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `~/get_type_description`: what a type looks like, for those who only know its name.

use camwright_msgs::{by_type_name, type_description_interfaces::srv::GetTypeDescription};

use super::{
    error::RosError, node::Node, parameter_value::ParameterValue, parameters::START_TYPE_DESCRIPTION_SERVICE, qos::Qos,
};

pub(super) fn offer(node: &Node) -> Result<(), RosError> {
    if node.parameters().get(START_TYPE_DESCRIPTION_SERVICE) != Some(ParameterValue::Bool(true)) {
        return Ok(());
    }
    let service = node.builtin_service::<GetTypeDescription>("get_type_description", &Qos::services(), |request| {
        let mut response = <GetTypeDescription as camwright_msgs::Service>::Response::default();
        match by_type_name(&request.type_name) {
            None => response.failure_reason = format!("type {} is not known here", request.type_name),
            Some(info) if !request.type_hash.is_empty() && request.type_hash != info.type_hash => {
                response.failure_reason = format!("type {} has the hash {} here", request.type_name, info.type_hash);
            }
            Some(info) => {
                response.successful = true;
                response.type_description = info.type_description();
                if request.include_type_sources {
                    response.type_sources = info.type_sources();
                }
            }
        }
        response
    })?;
    node.retain(service);
    Ok(())
}
