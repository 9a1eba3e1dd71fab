// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Quality of service, with ROS 2's profiles.
//!
//! The crate below defaults to best effort with depth 1, where ROS 2 has reliable with depth 10; here every endpoint states what it
//! wants.

use std::time::Duration;

use rustdds::{QosPolicies, QosPolicyBuilder, policy};

/// Maximum number of unread or unacknowledged samples of an endpoint beyond its history depth.
///
/// A reader's cache drops what its node has not read yet once it holds more than this many samples, and a reliable writer blocks
/// once this many are unacknowledged, which a peer that was killed makes happen for the 50 s of its lease. 1 kHz for a lease is
/// 50 000; a smaller figure stalls the publisher, a larger one costs memory with big messages.
const WRITER_WINDOW: i32 = 65_536;

/// Maximum number of unacknowledged samples of each writer of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WriterWindow {
    /// 65,536: 50 s at 1 kHz.
    #[default]
    Wide,
    /// 8192, the default of `RustDDS`, for a node that subscribes to its own topics. A writer's window is the limit of the reader's
    /// cache on the same topic too, which holds as many samples although they were read.
    Usual,
}

/// Longest time a reliable writer waits for room in its window before `publish` fails (Fast DDS's default).
const MAX_BLOCKING: rustdds::Duration = rustdds::Duration::from_millis(100);

/// Samples a `KeepAll` reader holds for its node. A cache keeps read samples too, so "all" cannot mean without bound.
const KEEP_ALL_DEPTH: i32 = 8192;

/// History policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum History {
    /// Keeps the last samples, up to this number.
    KeepLast(u32),
    /// Keeps all samples, within the resource limits.
    KeepAll,
}

/// Reliability policy; reliable writers repeat lost samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reliability {
    BestEffort,
    Reliable,
}

/// Durability policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Durability {
    Volatile,
    /// The history, as long as the publisher lives ("latched").
    TransientLocal,
}

/// Liveliness policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Liveliness {
    Automatic,
    /// The publisher asserts it by publishing.
    ManualByTopic,
}

/// A quality of service profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    pub history: History,
    pub reliability: Reliability,
    pub durability: Durability,
    /// Maximum time between samples; `None`: unlimited.
    pub deadline: Option<Duration>,
    /// Maximum age of a delivered sample; `None`: unlimited.
    pub lifespan: Option<Duration>,
    pub liveliness: Liveliness,
    /// Liveliness lease; `None`: unlimited.
    pub liveliness_lease: Option<Duration>,
}

impl Qos {
    const fn base(depth: u32, reliability: Reliability, durability: Durability) -> Self {
        Qos {
            history: History::KeepLast(depth),
            reliability,
            durability,
            deadline: None,
            lifespan: None,
            liveliness: Liveliness::Automatic,
            liveliness_lease: None,
        }
    }

    /// ROS 2's default for topics: keep last 10, reliable, volatile.
    pub const fn default_topic() -> Self {
        Self::base(10, Reliability::Reliable, Durability::Volatile)
    }

    /// `rmw_qos_profile_sensor_data`: keep last 5, best effort, volatile.
    pub const fn sensor_data() -> Self {
        Self::base(5, Reliability::BestEffort, Durability::Volatile)
    }

    /// `rmw_qos_profile_services_default`: keep last 10, reliable, volatile.
    pub const fn services() -> Self {
        Self::base(10, Reliability::Reliable, Durability::Volatile)
    }

    /// `rmw_qos_profile_parameters`: keep last 1000, reliable, volatile.
    pub const fn parameters() -> Self {
        Self::base(1000, Reliability::Reliable, Durability::Volatile)
    }

    /// `rmw_qos_profile_parameter_events`: keep last 1000, reliable, volatile.
    pub const fn parameter_events() -> Self {
        Self::base(1000, Reliability::Reliable, Durability::Volatile)
    }

    /// Keep last `depth`, reliable, transient local: what a late joiner must still learn. (`RustDDS` cuts a writer's history to its
    /// depth only every few seconds: a late joiner may see some older messages first, never the newest twice or too late.)
    pub const fn latched(depth: u32) -> Self {
        Self::base(depth, Reliability::Reliable, Durability::TransientLocal)
    }

    /// Status of an action: latched, depth 1 (`rcl_action_qos_profile_status_default`).
    pub const fn action_status() -> Self {
        Self::latched(1)
    }

    /// `/rosout`: keep last 1000, reliable, transient local, lifespan 10 s.
    pub const fn rosout() -> Self {
        let mut qos = Self::latched(1000);
        qos.lifespan = Some(Duration::from_secs(10));
        qos
    }

    /// A `/clock` subscription: keep last 1, best effort.
    pub const fn clock() -> Self {
        Self::base(1, Reliability::BestEffort, Durability::Volatile)
    }

    /// Keeps the last `depth` samples (at least one).
    #[must_use]
    pub const fn keep_last(mut self, depth: u32) -> Self {
        self.history = History::KeepLast(if depth == 0 { 1 } else { depth });
        self
    }

    /// Keeps all samples, within bounds (8192 for a reader).
    #[must_use]
    pub const fn keep_all(mut self) -> Self {
        self.history = History::KeepAll;
        self
    }

    /// Never sends a sample again.
    #[must_use]
    pub const fn best_effort(mut self) -> Self {
        self.reliability = Reliability::BestEffort;
        self
    }

    /// Sends again what was lost.
    #[must_use]
    pub const fn reliable(mut self) -> Self {
        self.reliability = Reliability::Reliable;
        self
    }

    /// Late joiners get nothing of the past.
    #[must_use]
    pub const fn volatile(mut self) -> Self {
        self.durability = Durability::Volatile;
        self
    }

    /// Late joiners get the history.
    #[must_use]
    pub const fn transient_local(mut self) -> Self {
        self.durability = Durability::TransientLocal;
        self
    }

    /// Sets the maximum time between samples.
    #[must_use]
    pub const fn deadline(mut self, period: Duration) -> Self {
        self.deadline = Some(period);
        self
    }

    /// Sets the maximum age of a delivered sample.
    #[must_use]
    pub const fn lifespan(mut self, lifespan: Duration) -> Self {
        self.lifespan = Some(lifespan);
        self
    }

    /// History depth; 0 is "all".
    pub const fn depth(&self) -> u32 {
        match self.history {
            History::KeepLast(depth) => depth,
            History::KeepAll => 0,
        }
    }

    fn builder(&self) -> QosPolicyBuilder {
        self.builder_with(MAX_BLOCKING)
    }

    fn builder_with(&self, max_blocking_time: rustdds::Duration) -> QosPolicyBuilder {
        let infinite_or = |limit: Option<Duration>| limit.map_or(rustdds::Duration::INFINITE, rustdds::Duration::from);
        QosPolicyBuilder::new()
            .reliability(match self.reliability {
                Reliability::BestEffort => policy::Reliability::BestEffort,
                Reliability::Reliable => policy::Reliability::Reliable { max_blocking_time },
            })
            .durability(match self.durability {
                Durability::Volatile => policy::Durability::Volatile,
                Durability::TransientLocal => policy::Durability::TransientLocal,
            })
            .history(match self.history {
                History::KeepLast(depth) => {
                    policy::History::KeepLast { depth: i32::try_from(depth).unwrap_or(i32::MAX) }
                }
                History::KeepAll => policy::History::KeepAll,
            })
            .deadline(policy::Deadline(infinite_or(self.deadline)))
            .lifespan(policy::Lifespan { duration: infinite_or(self.lifespan) })
            .liveliness(match self.liveliness {
                Liveliness::Automatic => {
                    policy::Liveliness::Automatic { lease_duration: infinite_or(self.liveliness_lease) }
                }
                Liveliness::ManualByTopic => {
                    policy::Liveliness::ManualByTopic { lease_duration: infinite_or(self.liveliness_lease) }
                }
            })
    }

    pub(super) fn writer_policies(&self, window: WriterWindow) -> QosPolicies {
        match window {
            WriterWindow::Wide => self.builder().resource_limits(limits(WRITER_WINDOW)).build(),
            WriterWindow::Usual => self.builder().build(),
        }
    }

    /// Those of a writer that does not wait for room.
    pub(super) fn impatient_writer_policies(&self) -> QosPolicies {
        self.builder_with(rustdds::Duration::ZERO).resource_limits(limits(WRITER_WINDOW)).build()
    }

    pub(super) fn reader_policies(&self) -> QosPolicies {
        match self.history {
            History::KeepLast(_) => self.builder().build(),
            History::KeepAll => self.builder().resource_limits(limits(KEEP_ALL_DEPTH)).build(),
        }
    }

    /// A reader whose cache holds at least `depth` samples, whatever the profile says: see [`super::reader_depth`].
    pub(super) fn reader_policies_of_depth(&self, depth: u32) -> QosPolicies {
        self.keep_last(depth).builder().resource_limits(limits(i32::try_from(depth).unwrap_or(i32::MAX))).build()
    }

    /// Profile of a discovered endpoint. DDS does not carry the history depth of a Fast DDS endpoint; then it reads as
    /// keep last 1.
    pub(super) fn from_policies(policies: &QosPolicies) -> Self {
        let finite =
            |duration: rustdds::Duration| (duration != rustdds::Duration::INFINITE).then(|| Duration::from(duration));
        let (liveliness, lease) = match policies.liveliness() {
            Some(policy::Liveliness::ManualByTopic { lease_duration }) => {
                (Liveliness::ManualByTopic, Some(lease_duration))
            }
            Some(
                policy::Liveliness::Automatic { lease_duration }
                | policy::Liveliness::ManualByParticipant { lease_duration },
            ) => (Liveliness::Automatic, Some(lease_duration)),
            None => (Liveliness::Automatic, None),
        };
        Qos {
            history: match policies.history() {
                Some(policy::History::KeepAll) => History::KeepAll,
                Some(policy::History::KeepLast { depth }) => {
                    History::KeepLast(u32::try_from(depth).unwrap_or(1).max(1))
                }
                None => History::KeepLast(1),
            },
            reliability: match policies.reliability() {
                Some(policy::Reliability::Reliable { .. }) => Reliability::Reliable,
                _ => Reliability::BestEffort,
            },
            durability: match policies.durability() {
                None | Some(policy::Durability::Volatile) => Durability::Volatile,
                Some(_) => Durability::TransientLocal,
            },
            deadline: policies.deadline().and_then(|deadline| finite(deadline.0)),
            lifespan: policies.lifespan().and_then(|lifespan| finite(lifespan.duration)),
            liveliness,
            liveliness_lease: lease.and_then(finite),
        }
    }
}

impl Default for Qos {
    fn default() -> Self {
        Self::default_topic()
    }
}

const fn limits(max_samples: i32) -> policy::ResourceLimits {
    policy::ResourceLimits { max_samples, max_instances: 1, max_samples_per_instance: max_samples }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_those_of_ros_2() {
        assert_eq!(Qos::default_topic().depth(), 10);
        assert_eq!(Qos::sensor_data().reliability, Reliability::BestEffort);
        assert_eq!(Qos::sensor_data().depth(), 5);
        assert_eq!(Qos::parameters().depth(), 1000);
        assert_eq!(Qos::rosout().durability, Durability::TransientLocal);
        assert_eq!(Qos::rosout().lifespan, Some(Duration::from_secs(10)));
        assert_eq!(Qos::clock().depth(), 1);
        assert_eq!(Qos::default_topic().keep_last(0).depth(), 1);
    }

    #[test]
    fn a_profile_survives_the_way_over_the_wire_types() {
        for qos in [
            Qos::default_topic(),
            Qos::sensor_data(),
            Qos::rosout(),
            Qos::clock(),
            Qos::latched(3).deadline(Duration::from_millis(500)),
            Qos::default_topic().keep_all(),
        ] {
            assert_eq!(Qos::from_policies(&qos.writer_policies(WriterWindow::Wide)), qos);
            assert_eq!(Qos::from_policies(&qos.writer_policies(WriterWindow::Usual)), qos);
            assert_eq!(Qos::from_policies(&qos.reader_policies()), qos);
            assert_eq!(Qos::from_policies(&qos.reader_policies_of_depth(77)), qos.keep_last(77));
        }
    }
}
