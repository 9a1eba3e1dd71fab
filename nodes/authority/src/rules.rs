// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Endpoints that are open to everybody. Everything else needs command.

use camwright_msgs::camwright_msgs::srv::CellCommandRequest;
use camwright_msgs::lifecycle_msgs::msg::Transition;
use camwright_msgs::lifecycle_msgs::srv::ChangeStateRequest;
use camwright_msgs::std_srvs::srv::SetBoolRequest;
use std::any::Any;

/// Services that only read, or that make the cell stop: the last part of their names.
const OPEN: &[&str] = &[
    // Parameters, life cycle, types and logs.
    "describe_parameters",
    "get_available_states",
    "get_available_transitions",
    "get_logger_levels",
    "get_parameter_types",
    "get_parameters",
    "get_state",
    "get_transition_graph",
    "get_type_description",
    "list_parameters",
    // Of the planner and the interpolator.
    "get_stiffness",
    "list_jobs",
    "preview_job",
    "query_state",
    "validate_job",
    // Stops.
    "cancel_goal",
    "get_result",
    "stop",
    // Command itself.
    "join_command",
    "take_command",
];

/// Access to a service of a node that the lease guards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Open to every client.
    Open,
    /// Open to every client for the named requests; others need command.
    OpenFor(&'static str),
    /// Only for the holder of command.
    Command,
}

/// Access to a service by its name.
pub fn access(service: &str) -> Access {
    let name = service.rsplit('/').next().unwrap_or_default();
    match name {
        "estop" => Access::OpenFor("true"),
        "feed_hold" => Access::OpenFor("hold"),
        "change_state" => Access::OpenFor("deactivate"),
        "cell_command" => Access::OpenFor("STOP, HOLD, ABORT"),
        name if OPEN.contains(&name) => Access::Open,
        _ => Access::Command,
    }
}

/// Returns true where a request to a service needs no command.
pub(super) fn is_open(service: &str, request: &dyn Any) -> bool {
    let name = service.rsplit('/').next().unwrap_or_default();
    match name {
        "estop" | "feed_hold" => request.downcast_ref::<SetBoolRequest>().is_some_and(|request| request.data),
        "change_state" => request.downcast_ref::<ChangeStateRequest>().is_some_and(stops),
        "cell_command" => request.downcast_ref::<CellCommandRequest>().is_some_and(halts),
        name => OPEN.contains(&name),
    }
}

/// Deactivation brings axes and jobs to rest.
fn stops(request: &ChangeStateRequest) -> bool {
    let Transition { id, label } = &request.transition;
    *id == Transition::TRANSITION_DEACTIVATE && (label.is_empty() || label == "deactivate")
}

fn halts(request: &CellCommandRequest) -> bool {
    [CellCommandRequest::STOP, CellCommandRequest::HOLD, CellCommandRequest::ABORT].contains(&request.command)
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_msgs::std_srvs::srv::TriggerRequest;

    #[test]
    fn stops_are_open_and_their_release_is_not() {
        assert!(is_open("/machine/estop", &SetBoolRequest { data: true }));
        assert!(!is_open("/machine/estop", &SetBoolRequest { data: false }));
        assert!(is_open("/cell/axis_interpolator/feed_hold", &SetBoolRequest { data: true }));
        assert!(!is_open("/cell/axis_interpolator/feed_hold", &SetBoolRequest { data: false }));
        let change = |id| ChangeStateRequest { transition: Transition { id, ..Transition::default() } };
        assert!(is_open("/machine_sim/change_state", &change(Transition::TRANSITION_DEACTIVATE)));
        assert!(!is_open("/machine_sim/change_state", &change(Transition::TRANSITION_ACTIVATE)));
        for command in 0..=255 {
            let open = is_open("/p/cell_command", &CellCommandRequest { command, ..CellCommandRequest::default() });
            assert_eq!(open, [3, 4, 8].contains(&command), "{command}");
        }
    }

    #[test]
    fn documented_access_is_the_access_of_requests() {
        let open_for = |name: &str| matches!(access(name), Access::OpenFor(_));
        for name in ["/machine/estop", "/axis_interpolator/feed_hold", "/n/change_state", "/job_planner/cell_command"] {
            assert!(open_for(name), "{name}");
        }
        let request = TriggerRequest::default();
        for name in OPEN.iter().copied().chain(["reset", "send_goal", "set_parameters", "take_commands"]) {
            let documented = access(&format!("/node/{name}"));
            assert_eq!(documented == Access::Open, is_open(name, &request), "{name}");
            assert!(!open_for(name), "{name}");
        }
    }

    #[test]
    fn what_is_not_listed_is_closed() {
        let request = TriggerRequest::default();
        for service in ["/machine/reset", "/machine/reset_shift", "/p/open_chuck", "/new", "", "/p/_action/send_goal"] {
            assert!(!is_open(service, &request), "{service}");
        }
        for service in ["/p/stop", "/p/list_jobs", "/i/jog/_action/cancel_goal"] {
            assert!(is_open(service, &request), "{service}");
        }
    }
}
