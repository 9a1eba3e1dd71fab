// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Authority over a node: decides which requests of others are executed.

use super::participant_entities::Guid;
use camwright_msgs::Service;
use serde_json::Value;
use std::any::Any;

/// Decides on requests to a node.
pub trait Authority: Send + Sync {
    /// Returns why a request is refused; none where it is executed. `sender` is the writer that sent it, whatever the request says.
    fn refusal(&self, service: &str, request: &dyn Any, sender: &Guid) -> Option<String>;
}

/// The response to a refused request: no success, and the reason where the type has a field for it.
///
/// Fields are found by name in the response as JSON, so that the hook needs no knowledge of single services.
pub(super) fn refused<S: Service>(request: &S::Request, reason: &str) -> S::Response {
    let fill = || -> Option<S::Response> {
        let mut response = serde_json::to_value(S::Response::default()).ok()?;
        let single = serde_json::json!({ "successful": false, "reason": reason });
        for (name, value) in response.as_object_mut()? {
            match (name.as_str(), &value) {
                ("message" | "reason", Value::String(_)) => *value = reason.into(),
                ("result", Value::Object(_)) if S::NAME == "SetParametersAtomically" => *value = single.clone(),
                // One for each parameter or level that was asked for.
                ("results", Value::Array(_)) => {
                    let request = serde_json::to_value(request).ok()?;
                    let asked = request.get("parameters").or(request.get("levels"))?.as_array()?.len();
                    *value = vec![single.clone(); asked].into();
                }
                _ => {}
            }
        }
        serde_json::from_value(response).ok()
    };
    fill().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_msgs::camwright_msgs::srv::{FindPhase, FindPhaseRequest};
    use camwright_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest};
    use camwright_msgs::rcl_interfaces::msg::Parameter;
    use camwright_msgs::rcl_interfaces::srv::{
        SetParameters, SetParametersAtomically, SetParametersAtomicallyRequest, SetParametersRequest,
    };
    use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};

    #[test]
    fn a_refusal_carries_its_reason() {
        let reason = "no client has command";
        assert_eq!(refused::<Trigger>(&TriggerRequest::default(), reason).message, reason);
        let response = refused::<FindPhase>(&FindPhaseRequest::default(), reason);
        assert!(!response.success && response.message == reason);
        let request = SetParametersRequest { parameters: vec![Parameter::default(); 3] };
        let response = refused::<SetParameters>(&request, reason);
        assert_eq!(response.results.len(), 3);
        assert!(response.results.iter().all(|result| !result.successful && result.reason == reason));
        let response = refused::<SetParametersAtomically>(&SetParametersAtomicallyRequest::default(), reason);
        assert_eq!(response.result.reason, reason);
        assert!(!refused::<ChangeState>(&ChangeStateRequest::default(), reason).success);
    }
}
