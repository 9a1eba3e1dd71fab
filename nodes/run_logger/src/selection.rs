// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which topics are recorded, and how they are subscribed to.

use regex_lite::Regex;

use camwright_bag::QosProfile;
use camwright_bag::qos as recorded;
use camwright_ros::{Durability, History, Liveliness, Qos, Reliability};

/// Filter of topics: by name with `*` and `?`, by regular expression on the name, by type.
#[derive(Debug, Clone, Default)]
pub struct TopicFilter {
    /// Names, in which `*` stands for anything and `?` for one character.
    pub names: Vec<String>,
    /// Matches anywhere in a name.
    pub regex: Option<Regex>,
    /// Types, `package/msg/Type`, in which `*` and `?` mean the same.
    pub types: Vec<String>,
}

impl TopicFilter {
    fn says_nothing(&self) -> bool {
        self.names.is_empty() && self.regex.is_none() && self.types.is_empty()
    }

    fn selects(&self, topic: &str, type_name: &str) -> bool {
        self.names.iter().any(|pattern| matches(pattern.as_bytes(), topic.as_bytes()))
            || self.regex.as_ref().is_some_and(|regex| regex.is_match(topic))
            || self.types.iter().any(|pattern| matches(pattern.as_bytes(), type_name.as_bytes()))
    }
}

/// A regular expression, or a sentence about what is wrong with it. Empty: none.
pub fn regex(text: &str) -> Result<Option<Regex>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    Regex::new(text).map(Some).map_err(|error| format!("'{text}' is no regular expression: {error}"))
}

/// Which of the topics of the graph a recording takes, or a player plays.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Namespace of the recorder with a `/` at its end: its cell.
    cell: String,
    /// Topics to record; an empty filter selects all of the cell and all that belong to no cell.
    include: TopicFilter,
    /// Topics to exclude.
    exclude: TopicFilter,
}

impl Selection {
    /// `namespace` is that of the node; an `include` that says nothing takes all. Names that do not begin with `/` are relative to it.
    #[must_use]
    pub fn new(namespace: &str, include: TopicFilter, exclude: TopicFilter) -> Self {
        let cell = if namespace.ends_with('/') { namespace.to_owned() } else { format!("{namespace}/") };
        let absolute = |filter: TopicFilter| {
            let is_relative = |name: &String| !name.starts_with(['/', '*']);
            let names = filter.names.into_iter();
            TopicFilter {
                names: names.map(|n| if is_relative(&n) { format!("{cell}{n}") } else { n }).collect(),
                ..filter
            }
        };
        Self { include: absolute(include), exclude: absolute(exclude), cell }
    }

    /// Returns whether the topic with this absolute name and this type is recorded.
    #[must_use]
    pub fn selects(&self, topic: &str, type_name: &str) -> bool {
        let is_wanted = if self.include.says_nothing() {
            // `/rosout`, `/clock`, `/tf`: without a namespace they are everybody's.
            topic.starts_with(&self.cell) || !topic[1.min(topic.len())..].contains('/')
        } else {
            self.include.selects(topic, type_name)
        };
        is_wanted && !self.exclude.selects(topic, type_name)
    }
}

/// Returns whether `text` has the form of `pattern`, in which `*` stands for anything and `?` for one byte.
fn matches(pattern: &[u8], text: &[u8]) -> bool {
    // The last `*` seen: where it stands, and how much of the text it takes.
    let (mut p, mut t) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while t < text.len() {
        if p < pattern.len() && pattern[p] == b'*' {
            star = Some((p, t));
            p += 1;
        } else if p < pattern.len() && (pattern[p] == b'?' || pattern[p] == text[t]) {
            p += 1;
            t += 1;
        } else if let Some((at, taken)) = star {
            star = Some((at, taken + 1));
            p = at + 1;
            t = taken + 1;
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|&b| b == b'*')
}

/// Returns whether a type is a message, not a part of a service or an action.
pub(super) fn is_message_type(type_name: &str) -> bool {
    type_name.contains("/msg/")
}

/// Returns whether a topic has the events of calls of a service (`pkg/srv/Name_Event`) or of a service of an action.
pub(super) fn is_service_event(topic: &str, type_name: &str) -> bool {
    topic.ends_with("/_service_event") && type_name.ends_with("_Event")
}

/// Quality of service of a subscription that matches every publisher and misses none of its retained messages: as strong as all of them offer.
pub(super) fn subscription_qos(offers: &[Qos], depth: u32) -> Qos {
    let mut qos = Qos::default_topic().keep_last(depth);
    if !offers.iter().all(|o| o.reliability == Reliability::Reliable) {
        qos = qos.best_effort();
    }
    if !offers.is_empty() && offers.iter().all(|o| o.durability == Durability::TransientLocal) {
        qos = qos.transient_local();
    }
    qos
}

/// Quality of service of a publisher as recorded in a bag.
pub(super) fn recorded_qos(offer: &Qos) -> QosProfile {
    let (history, depth) = match offer.history {
        // Also what a publisher looks like whose discovery does not carry its history.
        History::KeepLast(0 | 1) => (recorded::History::Unknown, 0),
        History::KeepLast(depth) => (recorded::History::KeepLast, u64::from(depth)),
        History::KeepAll => (recorded::History::KeepAll, 0),
    };
    QosProfile {
        history,
        depth,
        reliability: match offer.reliability {
            Reliability::Reliable => recorded::Reliability::Reliable,
            Reliability::BestEffort => recorded::Reliability::BestEffort,
        },
        durability: match offer.durability {
            Durability::TransientLocal => recorded::Durability::TransientLocal,
            Durability::Volatile => recorded::Durability::Volatile,
        },
        deadline: offer.deadline,
        lifespan: offer.lifespan,
        liveliness: match offer.liveliness {
            Liveliness::Automatic => recorded::Liveliness::Automatic,
            Liveliness::ManualByTopic => recorded::Liveliness::ManualByTopic,
        },
        liveliness_lease: offer.liveliness_lease,
        avoid_ros_namespace_conventions: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(patterns: &[&str]) -> Vec<String> {
        patterns.iter().map(|&p| p.to_owned()).collect()
    }

    fn names(patterns: &[&str]) -> TopicFilter {
        TopicFilter { names: owned(patterns), ..TopicFilter::default() }
    }

    #[test]
    fn a_recorder_takes_its_cell_and_what_belongs_to_none() {
        let all = |namespace| Selection::new(namespace, TopicFilter::default(), TopicFilter::default());
        let selects = |selection: &Selection, topic| selection.selects(topic, "std_msgs/msg/String");
        for topic in ["/cell1/joint_states", "/cell1/machine/stream", "/rosout", "/clock"] {
            assert!(selects(&all("/cell1"), topic), "{topic}");
        }
        for topic in ["/cell10/joint_states", "/cell2/joint_states", "/other/a/b"] {
            assert!(!selects(&all("/cell1"), topic), "{topic}");
        }
        assert!(selects(&all("/"), "/joint_states") && selects(&all("/"), "/cell2/joint_states"));
    }

    #[test]
    fn names_regular_expressions_and_types_choose_and_exclude() {
        let some = Selection::new("/cell1", names(&["machine/*", "/ros?ut"]), names(&["*stream"]));
        let selects = |topic| some.selects(topic, "std_msgs/msg/String");
        assert!(selects("/cell1/machine/io") && selects("/rosout"));
        assert!(!selects("/cell1/machine/stream") && !selects("/cell1/joint_states"));
        let include = TopicFilter {
            regex: regex("^/(a|b)/").expect("it is one"),
            types: owned(&["sensor_msgs/*"]),
            ..names(&["/x"])
        };
        let exclude = TopicFilter {
            regex: regex("raw$").expect("it is one"),
            types: owned(&["*/Image"]),
            ..TopicFilter::default()
        };
        let both = Selection::new("/", include, exclude);
        for (topic, type_name, is_taken) in [
            ("/x", "std_msgs/msg/String", true),
            ("/a/c", "std_msgs/msg/String", true),
            ("/c/a/", "std_msgs/msg/String", false),
            ("/joints", "sensor_msgs/msg/JointState", true),
            ("/camera", "sensor_msgs/msg/Image", false),
            ("/b/raw", "std_msgs/msg/String", false),
        ] {
            assert_eq!(both.selects(topic, type_name), is_taken, "{topic}");
        }
        assert!(regex("(").expect_err("it is none").starts_with("'(' is no regular expression"));
        assert!(matches(b"*", b"") && matches(b"a*b*c", b"aXbYbZc") && !matches(b"a*b", b"abc") && !matches(b"?", b""));
    }

    #[test]
    fn events_of_services_are_known_by_topic_and_type() {
        for (topic, type_name, is_event) in [
            ("/node/flip/_service_event", "std_srvs/srv/SetBool_Event", true),
            ("/home/_action/send_goal/_service_event", "camwright_msgs/action/Home_SendGoal_Event", true),
            ("/home/_action/feedback", "camwright_msgs/action/Home_FeedbackMessage", false),
            ("/node/transition_event", "lifecycle_msgs/msg/TransitionEvent", false),
            ("/node/_service_event", "std_msgs/msg/String", false),
        ] {
            assert_eq!(is_service_event(topic, type_name), is_event, "{topic}");
        }
        let exclude = TopicFilter { types: owned(&["*_Event"]), ..TopicFilter::default() };
        let without = Selection::new("/", TopicFilter::default(), exclude);
        assert!(!without.selects("/node/flip/_service_event", "std_srvs/srv/SetBool_Event"));
        assert!(without.selects("/node/transition_event", "lifecycle_msgs/msg/TransitionEvent"));
    }

    #[test]
    fn a_subscription_asks_for_no_more_than_all_publishers_offer() {
        let (latched, plain, sensor) = (Qos::latched(1), Qos::default_topic(), Qos::sensor_data());
        assert_eq!(subscription_qos(&[latched], 5000), Qos::latched(5000));
        assert_eq!(subscription_qos(&[latched, plain], 5000), Qos::default_topic().keep_last(5000));
        assert_eq!(subscription_qos(&[plain, sensor], 7), Qos::default_topic().keep_last(7).best_effort());
        assert_eq!(subscription_qos(&[], 7), Qos::default_topic().keep_last(7));
    }
}
