// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! With which quality of service a topic is played.

use camwright_bag::qos as recorded;
use camwright_bag::{QosProfile, Topic};
use camwright_ros::Qos;

/// Depth of what is played to a subscriber that is slow (messages).
const DEPTH: u32 = 1000;

/// The quality of service to publish a recorded topic with: at least what each of its publishers offered, so that a client that could
/// listen then can listen now. `message_count` is the number of its messages in the bag.
///
/// Bags seldom know the depth of a publisher. A latched topic keeps all its messages then, up to [`DEPTH`]: a plan's pages are
/// worthless unless a late subscriber gets every one of them.
pub(super) fn offered_qos(topic: &Topic, message_count: u64) -> Qos {
    let offers = &topic.offered_qos;
    let any = |test: fn(&QosProfile) -> bool| offers.iter().any(test);
    let mut qos = Qos::default_topic().keep_last(DEPTH);
    if !offers.is_empty() && !any(|o| o.reliability != recorded::Reliability::BestEffort) {
        qos = qos.best_effort();
    }
    if topic.is_latched() {
        let known = offers.iter().map(|o| o.depth).max().filter(|&depth| depth > 0);
        let depth = known.unwrap_or(message_count).clamp(1, u64::from(DEPTH));
        qos = qos.transient_local().keep_last(u32::try_from(depth).unwrap_or(DEPTH));
    }
    // A deadline or a lifespan of the recording would be broken by another rate, so neither is offered again.
    qos
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_ros::{Durability, Reliability};

    fn topic(offered_qos: Vec<QosProfile>) -> Topic {
        Topic {
            name: "/a".into(),
            type_name: "std_msgs/msg/String".into(),
            type_hash: String::new(),
            definition: String::new(),
            offered_qos,
        }
    }

    #[test]
    fn a_topic_is_played_as_strongly_as_any_of_its_publishers_offered_it() {
        use recorded::{Durability as D, Reliability as R};
        let plain = QosProfile::discovered(R::Reliable, D::Volatile);
        let sensor = QosProfile::discovered(R::BestEffort, D::Volatile);
        let latched = QosProfile::discovered(R::Reliable, D::TransientLocal);
        assert_eq!(offered_qos(&topic(vec![]), 5), Qos::default_topic().keep_last(DEPTH));
        assert_eq!(offered_qos(&topic(vec![plain.clone()]), 5), Qos::default_topic().keep_last(DEPTH));
        assert_eq!(offered_qos(&topic(vec![sensor.clone()]), 5).reliability, Reliability::BestEffort);
        let mixed = offered_qos(&topic(vec![sensor, latched.clone()]), 5);
        assert_eq!((mixed.reliability, mixed.durability), (Reliability::Reliable, Durability::TransientLocal));
        assert_eq!(mixed.depth(), 5, "every page of a plan");
        let known = QosProfile { depth: 3, history: recorded::History::KeepLast, ..latched };
        assert_eq!(offered_qos(&topic(vec![known]), 5).depth(), 3);
    }
}
