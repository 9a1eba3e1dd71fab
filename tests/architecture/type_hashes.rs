// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The type hashes of our generated types are those that the real rosidl computes, from the wheels where there is one and from our own
//! build of the interface files where there is none.

use crate::support::{self, RosDistribution};

use camwright_msgs::{Action, Message, Service};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Every type's hash in rosidl's descriptions (`share/<package>/{msg,srv,action}/*.json`), by full name.
fn hashes_of_rosidl(shares: &[impl AsRef<Path>]) -> BTreeMap<String, String> {
    let mut hashes = BTreeMap::new();
    let directories = shares.iter().flat_map(|share| std::fs::read_dir(share).expect("the environment is made"));
    for package in directories.flatten() {
        for kind in ["msg", "srv", "action"] {
            let Ok(files) = std::fs::read_dir(package.path().join(kind)) else { continue };
            for path in
                files.flatten().map(|file| file.path()).filter(|path| path.extension().is_some_and(|e| e == "json"))
            {
                let text = std::fs::read_to_string(&path).expect("rosidl's own file");
                let described: Value = serde_json::from_str(&text).expect("rosidl writes JSON");
                for entry in described["type_hashes"].as_array().expect("rosidl lists the hashes") {
                    let word = |key: &str| entry[key].as_str().expect("a text").to_owned();
                    hashes.insert(word("type_name"), word("hash_string"));
                }
            }
        }
    }
    hashes
}

/// Returns whether a distribution defines a type in another way than camwright: Kilted has more fields in the feedback of this action.
fn is_defined_otherwise(type_name: &str, distribution: RosDistribution) -> bool {
    let action = "control_msgs/action/FollowJointTrajectory";
    let names = [action.to_owned(), format!("{action}_Feedback"), format!("{action}_FeedbackMessage")];
    distribution == RosDistribution::Kilted && names.iter().any(|name| name == type_name)
}

#[test]
fn every_hash_equals_the_one_rosidl_computes() {
    let Some(env) = support::peer_env() else { return };
    let theirs = hashes_of_rosidl(&env.share_directories());
    let wrong: Vec<_> = camwright_msgs::ALL
        .iter()
        .filter(|info| {
            let equal = theirs.get(info.type_name).map(String::as_str) == Some(info.type_hash);
            equal == is_defined_otherwise(info.type_name, env.distribution)
        })
        .map(|info| format!("{}: ours {}, rosidl's {:?}", info.type_name, info.type_hash, theirs.get(info.type_name)))
        .collect();
    assert!(wrong.is_empty(), "{} of {} differ:\n{}", wrong.len(), camwright_msgs::ALL.len(), wrong.join("\n"));
}

#[test]
fn rosidl_knows_no_type_of_ours_that_we_do_not_have() {
    let Some(env) = support::peer_env() else { return };
    let [_, built] = env.share_directories();
    let built = hashes_of_rosidl(&[built]);
    assert!(built.keys().any(|name| name == "camwright_msgs/action/RunJob"), "camwright_msgs was built");
    let missing: Vec<_> = built.keys().filter(|name| camwright_msgs::by_type_name(name).is_none()).collect();
    assert!(missing.is_empty(), "not generated: {missing:?}");
}

#[test]
fn the_types_carry_the_hashes_of_the_registry() {
    use camwright_msgs::camwright_msgs::{action::RunJob, msg::MachineStream, srv::TouchOff};
    let registered = |name| camwright_msgs::by_type_name(name).expect("registered").type_hash;
    assert_eq!(MachineStream::TYPE_HASH, registered("camwright_msgs/msg/MachineStream"));
    assert_eq!(TouchOff::TYPE_HASH, registered("camwright_msgs/srv/TouchOff"));
    assert_eq!(RunJob::TYPE_HASH, registered("camwright_msgs/action/RunJob"));
}
