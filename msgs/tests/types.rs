// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The generated types are what the wire, a bag and a program need.

use camwright_msgs::action_msgs::msg::GoalStatus;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{PlanPage, PlanSegment};
use camwright_msgs::camwright_msgs::srv::ListJobsRequest;
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryResult};
use camwright_msgs::geometry_msgs::msg::Quaternion;
use camwright_msgs::rcl_interfaces::msg::{FloatingPointRange, ParameterDescriptor};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_msgs::type_description_interfaces::msg::FieldType;
use camwright_msgs::type_description_interfaces::srv::GetTypeDescriptionRequest;
use camwright_msgs::unique_identifier_msgs::msg::UUID;
use camwright_msgs::{ALL, Action, InterfaceKind, Message, Service, by_type_name};

/// Written by hand from the rules of rosbag2: the texts verbatim, dependencies after rules of 80 equals signs.
#[test]
fn the_schema_of_joint_states_is_what_a_bag_carries() {
    let expected = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
                    \n================================================================================\n\
                    MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
                    \n================================================================================\n\
                    MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
    assert_eq!(JointState::SCHEMA, expected);
}

#[test]
fn our_own_schemas_are_the_files_with_their_comments() {
    let file = include_str!("../msg/PlanPage.msg");
    assert!(PlanPage::SCHEMA.starts_with(file));
    assert!(PlanPage::SCHEMA.contains("\nMSG: camwright_msgs/PlanSegment\n# Segment of a plan.\n"));
}

#[test]
fn names_are_those_of_ros_and_of_the_wire() {
    assert_eq!((PlanPage::PACKAGE, PlanPage::NAME), ("camwright_msgs", "PlanPage"));
    assert_eq!(PlanPage::TYPE_NAME, "camwright_msgs/msg/PlanPage");
    assert_eq!(PlanPage::DDS_TYPE_NAME, "camwright_msgs::msg::dds_::PlanPage_");
    assert_eq!((Trigger::PACKAGE, Trigger::NAME, Trigger::TYPE_NAME), ("std_srvs", "Trigger", "std_srvs/srv/Trigger"));
    assert_eq!(Trigger::DDS_REQUEST_TYPE_NAME, "std_srvs::srv::dds_::Trigger_Request_");
    assert_eq!(Trigger::DDS_RESPONSE_TYPE_NAME, "std_srvs::srv::dds_::Trigger_Response_");
    assert_eq!(RunJob::TYPE_NAME, "camwright_msgs/action/RunJob");
    type SendGoal = <RunJob as Action>::SendGoal;
    assert_eq!(SendGoal::DDS_REQUEST_TYPE_NAME, "camwright_msgs::action::dds_::RunJob_SendGoal_Request_");
    type FeedbackMessage = <FollowJointTrajectory as Action>::FeedbackMessage;
    assert_eq!(FeedbackMessage::DDS_TYPE_NAME, "control_msgs::action::dds_::FollowJointTrajectory_FeedbackMessage_");
}

#[test]
fn defaults_and_constants_are_those_of_the_files() {
    assert_eq!(Quaternion::default(), Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
    assert!(GetTypeDescriptionRequest::default().include_type_sources);
    assert_eq!(FollowJointTrajectoryResult::GOAL_TOLERANCE_VIOLATED, -5);
    assert_eq!(PlanSegment::PHASE_ROTARY_INDEX, 9);
    assert_eq!(FieldType::FIELD_TYPE_NESTED_TYPE_UNBOUNDED_SEQUENCE, 145);
}

#[test]
fn an_interface_without_fields_travels_as_one_byte() {
    assert_eq!(TriggerRequest::default().structure_needs_at_least_one_member, 0);
    assert_eq!(ListJobsRequest::INFO.fields[0].name, "structure_needs_at_least_one_member");
}

#[test]
fn what_an_action_sends_comes_apart_again() {
    let id = UUID { uuid: [7; 16] };
    let goal = RunJobGoal { job: "four_lobes".into(), overrides: vec!["a=1".into()], start_lobe: "2".into() };
    let message = RunJob::send_goal_request(id.clone(), goal.clone());
    assert_eq!(RunJob::split_send_goal_request(message), (id.clone(), goal));
    let stamp = Time { sec: 3, nanosec: 4 };
    assert_eq!(RunJob::split_send_goal_response(RunJob::send_goal_response(true, stamp.clone())), (true, stamp));
    assert_eq!(RunJob::split_get_result_request(RunJob::get_result_request(id.clone())), id);
    let result = FollowJointTrajectoryResult { error_code: -4, error_string: "x_axis".into() };
    let message = FollowJointTrajectory::get_result_response(GoalStatus::STATUS_ABORTED, result.clone());
    assert_eq!(FollowJointTrajectory::split_get_result_response(message), (GoalStatus::STATUS_ABORTED, result));
    let message = RunJob::feedback_message(id.clone(), Default::default());
    assert_eq!(RunJob::split_feedback_message(message), (id, Default::default()));
}

/// A range is a sequence of at most one element; rosidl refuses to send a second.
#[test]
fn a_sequence_beyond_its_bound_is_named() {
    let mut descriptor = ParameterDescriptor::default();
    descriptor.floating_point_range.push(FloatingPointRange::default());
    assert_eq!(descriptor.check_bounds(), Ok(()));
    descriptor.floating_point_range.push(FloatingPointRange::default());
    let error = descriptor.check_bounds().expect_err("two ranges are too many");
    assert_eq!(
        error.to_string(),
        "rcl_interfaces/msg/ParameterDescriptor.floating_point_range has length 2, at most 1 are allowed"
    );
    let response = camwright_msgs::rcl_interfaces::srv::DescribeParametersResponse { descriptors: vec![descriptor] };
    assert_eq!(response.check_bounds(), Err(error));
}

#[test]
fn a_description_holds_the_type_and_all_it_is_made_of() {
    let description = JointState::INFO.type_description();
    assert_eq!(description.type_description.type_name, "sensor_msgs/msg/JointState");
    let position = &description.type_description.fields[2];
    assert_eq!(
        (position.name.as_str(), position.type_.type_id),
        ("position", FieldType::FIELD_TYPE_DOUBLE_UNBOUNDED_SEQUENCE)
    );
    let referenced: Vec<_> = description.referenced_type_descriptions.iter().map(|d| d.type_name.as_str()).collect();
    assert_eq!(referenced, ["builtin_interfaces/msg/Time", "std_msgs/msg/Header"]);
    let sources = JointState::INFO.type_sources();
    assert_eq!(sources.len(), 3);
    assert_eq!((sources[0].encoding.as_str(), sources[0].type_name.as_str()), ("msg", "sensor_msgs/msg/JointState"));
    assert!(sources[0].raw_file_contents.starts_with("std_msgs/Header header\n"));
}

/// Types that ROS derives have no file of their own.
#[test]
fn a_service_is_described_with_its_parts() {
    let info = by_type_name("std_srvs/srv/Trigger").expect("the service is known");
    assert_eq!(info.kind, InterfaceKind::Service);
    assert_eq!((info.type_hash, info.source_encoding), (Trigger::TYPE_HASH, "srv"));
    let request = by_type_name("std_srvs/srv/Trigger_Request").expect("its request is known");
    assert_eq!((request.source_encoding, request.source), ("implicit", ""));
    assert!(info.referenced.contains(&"std_srvs/srv/Trigger_Event"));
}

/// A reader of a bag finds every type a schema names within it.
#[test]
fn every_schema_is_complete() {
    let rule = format!("\n{}\nMSG: ", "=".repeat(80));
    for info in ALL.iter().filter(|info| info.kind == InterfaceKind::Message) {
        let parts: Vec<_> = info.schema.split(&rule).collect();
        assert_eq!(parts.len(), info.referenced.len() + 1, "{}", info.type_name);
        for part in &parts[1..] {
            let name = part.lines().next().expect("a definition begins with its name");
            let (package, name) = name.split_once('/').expect("the name has a package");
            let is_it = |full: &&&str| full.starts_with(&format!("{package}/")) && full.ends_with(&format!("/{name}"));
            assert!(
                info.referenced.iter().any(|full| is_it(&full)),
                "{} does not need {package}/{name}",
                info.type_name
            );
        }
    }
}

/// Colcon builds every own interface that the crate has, and no other.
#[test]
fn the_ros_package_lists_every_interface_file() {
    let cmake = include_str!("../CMakeLists.txt");
    let listed: Vec<_> = cmake.lines().filter_map(|line| line.trim().strip_prefix('"')?.strip_suffix('"')).collect();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = 0;
    for kind in ["msg", "srv", "action"] {
        for entry in std::fs::read_dir(root.join(kind)).expect("the folder is there") {
            let file = entry.expect("the entry is readable").file_name().into_string().expect("names are ASCII");
            assert!(listed.contains(&format!("{kind}/{file}").as_str()), "{kind}/{file} is not in CMakeLists.txt");
            found += 1;
        }
    }
    assert_eq!(listed.len(), found, "CMakeLists.txt lists a file that is not there");
}

/// Every line of a field of our own interfaces: its type, its text and the interface it stands in.
fn own_fields() -> Vec<(&'static str, &'static str, &'static str)> {
    let own = ALL.iter().filter(|info| info.type_name.starts_with("camwright_msgs/"));
    let lines = own.flat_map(|info| info.source.lines().map(|line| (info.type_name, line)));
    let fields = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#') && *line != "---");
    fields.map(|(name, line)| (line.split_whitespace().next().unwrap_or_default(), line, name)).collect()
}

/// A user who echoes a topic has no other information.
#[test]
fn every_field_of_our_own_has_a_comment() {
    let fields = own_fields();
    assert!(fields.len() > 200, "only {} fields", fields.len());
    for (_, line, interface) in fields {
        let comment = line.split_once('#').map(|(_, comment)| comment.trim()).unwrap_or_default();
        assert!(comment.len() > 2, "{interface}: {line} has no comment");
    }
}

/// A number with a fraction has its unit in brackets, or its range where it has none, or says what names the unit.
#[test]
fn every_quantity_of_our_own_has_a_unit() {
    let units = [
        "m", "rad", "s", "N", "N/m", "W", "J/m^3", "m/s", "rad/s", "m/s^2", "m/s^3", "counts", "ns", "Hz", "1", "0..1",
        "0..100", "whole",
    ];
    let says = |comment: &str| {
        let in_brackets = comment.split('(').skip(1).filter_map(|rest| rest.split(')').next());
        let named = |text: &str| text.split([' ', ',', ';']).any(|word| units.contains(&word));
        in_brackets.clone().any(named)
            || comment.contains("turns")
            || ["0..1", "see kind", "as `kind` says", "the unit of the list"]
                .iter()
                .any(|words| comment.contains(words))
    };
    let mut quantities = 0;
    for (kind, line, interface) in own_fields().into_iter().filter(|(kind, _, _)| kind.starts_with("float")) {
        quantities += 1;
        let comment = line.split_once('#').map(|(_, comment)| comment).unwrap_or_default();
        assert!(says(comment), "{interface}: {line}: {kind} without a unit");
    }
    assert!(quantities > 60, "only {quantities} quantities");
}
