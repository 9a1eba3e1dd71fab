//! Which topics are recorded, and how they are subscribed to.

use crate::bag::QosProfile;
use crate::bag::qos as recorded;
use crate::ros::{Durability, History, Liveliness, Qos, Reliability};

/// Which of the topics of the graph a recording takes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// Namespace of the recorder with a `/` at its end: its cell.
    cell: String,
    /// Patterns of topics to take; empty takes all of the cell and all that belong to no cell.
    topics: Vec<String>,
    /// Patterns of topics to leave out.
    exclude: Vec<String>,
}

impl Selection {
    /// `namespace` is that of the node; an empty `topics` takes all. Patterns that do not begin with `/` are relative to it.
    #[must_use]
    pub fn new(namespace: &str, topics: &[String], exclude: &[String]) -> Self {
        let cell = if namespace.ends_with('/') { namespace.to_owned() } else { format!("{namespace}/") };
        let absolute = |patterns: &[String]| {
            patterns.iter().map(|p| if p.starts_with('/') { p.clone() } else { format!("{cell}{p}") }).collect()
        };
        Self { topics: absolute(topics), exclude: absolute(exclude), cell }
    }

    /// Whether the topic with this absolute name is wanted.
    #[must_use]
    pub fn takes(&self, topic: &str) -> bool {
        let is_wanted = if self.topics.is_empty() {
            // `/rosout`, `/clock`, `/tf`: without a namespace they are everybody's.
            topic.starts_with(&self.cell) || !topic[1.min(topic.len())..].contains('/')
        } else {
            self.topics.iter().any(|p| matches(p.as_bytes(), topic.as_bytes()))
        };
        is_wanted && !self.exclude.iter().any(|p| matches(p.as_bytes(), topic.as_bytes()))
    }
}

/// Whether `text` has the form of `pattern`, in which `*` stands for anything and `?` for one byte.
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

/// How to subscribe so that every publisher matches and none of what it keeps is missed: as strong as all of them offer.
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

/// What a bag says of a publisher.
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

    #[test]
    fn a_recorder_takes_its_cell_and_what_belongs_to_none() {
        let cell = Selection::new("/cell1", &[], &[]);
        for topic in ["/cell1/joint_states", "/cell1/machine/stream", "/rosout", "/clock"] {
            assert!(cell.takes(topic), "{topic}");
        }
        for topic in ["/cell10/joint_states", "/cell2/joint_states", "/other/a/b"] {
            assert!(!cell.takes(topic), "{topic}");
        }
        let root = Selection::new("/", &[], &[]);
        assert!(root.takes("/joint_states") && root.takes("/cell2/joint_states"));
    }

    #[test]
    fn patterns_choose_and_exclude() {
        let some = Selection::new("/cell1", &owned(&["machine/*", "/ros?ut"]), &owned(&["*stream"]));
        assert!(some.takes("/cell1/machine/io") && some.takes("/rosout"));
        assert!(!some.takes("/cell1/machine/stream") && !some.takes("/cell1/joint_states"));
        assert!(matches(b"*", b"") && matches(b"a*b*c", b"aXbYbZc") && !matches(b"a*b", b"abc") && !matches(b"?", b""));
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
