// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The hashes are those that rosidl computes.

use std::collections::BTreeMap;

use camwright_msgs::{ALL, Message, by_type_name};

/// Packages without a wheel on the package index: their hashes are compared with a build by rosidl in the tests of
/// the whole, and here as far as another source is known.
const WITHOUT_WHEEL: [&str; 4] = ["camwright_msgs", "control_msgs", "rosbag2_interfaces", "tf2_msgs"];

/// Made by `golden_hashes.py` from the wheels of ROS 2 Jazzy.
fn golden() -> BTreeMap<&'static str, &'static str> {
    include_str!("golden_hashes.txt").lines().filter_map(|line| line.split_once(' ')).collect()
}

#[test]
fn every_standard_type_has_the_hash_rosidl_gives_it() {
    let golden = golden();
    let mut compared = 0;
    for info in ALL {
        let package = info.type_name.split('/').next().expect("split yields at least one part");
        if WITHOUT_WHEEL.contains(&package) {
            continue;
        }
        let expected = golden.get(info.type_name).unwrap_or_else(|| panic!("{} has no golden hash", info.type_name));
        assert_eq!(info.type_hash, *expected, "{}", info.type_name);
        compared += 1;
    }
    assert!(compared > 140, "only {compared} types compared");
}

/// From bags that ROS 2 Jazzy recorded.
#[test]
fn tf_messages_have_the_hash_seen_in_bags() {
    assert_eq!(
        camwright_msgs::tf2_msgs::msg::TFMessage::TYPE_HASH,
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
    );
}

#[test]
fn all_types_stand_in_order_and_are_found_by_name() {
    assert!(ALL.windows(2).all(|pair| pair[0].type_name < pair[1].type_name));
    for info in ALL {
        assert_eq!(by_type_name(info.type_name), Some(*info));
        for name in info.referenced {
            assert!(by_type_name(name).is_some(), "{name} in {}", info.type_name);
        }
    }
    assert_eq!(by_type_name("std_msgs/String"), None);
}
