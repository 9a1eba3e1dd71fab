// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The types serialise to the bytes CDR prescribes, and back.

use byteorder::LittleEndian;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::{Latch, MachineStream};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_msgs::msg::Header;
use camwright_msgs::std_srvs::srv::TriggerRequest;
use camwright_msgs::unique_identifier_msgs::msg::UUID;
use camwright_msgs::{Message, action_msgs::msg::GoalInfo};

/// Writes a message, reads it back, and returns its bytes without the encapsulation header.
fn round_trip<M: Message>(message: &M) -> Vec<u8> {
    let bytes = cdr_encoding::to_vec::<M, LittleEndian>(message).expect("every message can be written");
    let (read, length) = cdr_encoding::from_bytes::<M, LittleEndian>(&bytes).expect("what was written can be read");
    assert_eq!((&read, length), (message, bytes.len()));
    bytes
}

/// Texts carry their length with the closing zero, sequences their number of elements, and every number stands at a
/// multiple of its own size.
#[test]
fn a_joint_state_is_written_by_hand() {
    let message = JointState {
        header: Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: String::new() },
        name: vec!["c".into()],
        position: vec![1.0],
        ..JointState::default()
    };
    let mut expected = vec![1, 0, 0, 0, 2, 0, 0, 0]; // stamp
    expected.extend([1, 0, 0, 0, 0, 0, 0, 0]); // frame_id: one byte, the zero; then padding
    expected.extend([1, 0, 0, 0, 2, 0, 0, 0, b'c', 0, 0, 0]); // one name of two bytes, padding
    expected.extend([1, 0, 0, 0]); // one position, which then stands at 32
    expected.extend(1.0_f64.to_le_bytes());
    expected.extend([0; 8]); // no velocity, no effort
    assert_eq!(round_trip(&message), expected);
}

/// A fixed array has no length in front.
#[test]
fn a_goal_id_is_sixteen_bytes() {
    let message = GoalInfo { goal_id: UUID { uuid: *b"0123456789abcdef" }, ..GoalInfo::default() };
    let bytes = round_trip(&message);
    assert_eq!(bytes.len(), 24);
    assert_eq!(bytes[..16], message.goal_id.uuid);
}

#[test]
fn an_empty_request_is_one_byte() {
    assert_eq!(round_trip(&TriggerRequest::default()), [0]);
}

#[test]
fn nested_messages_of_our_own_come_back() {
    let latch = Latch { tick: u64::MAX, input: "LS1".into(), rising: true, joint: "z_axis".into(), counts: i64::MIN };
    let message = MachineStream {
        tick: 9,
        holder: "Nockenwelle ß".into(),
        alarms: vec![1, 2, 3],
        setpoint_counts: vec![-1, 0, 1],
        latches: vec![latch.clone(), Latch::default(), latch],
        ..MachineStream::default()
    };
    round_trip(&message);
}
