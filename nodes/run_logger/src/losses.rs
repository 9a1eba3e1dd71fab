// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lost messages, as rosbag2's recorder publishes them.

use std::collections::BTreeMap;

use camwright_bag::recording::TopicCounts;
use camwright_msgs::rosbag2_interfaces::msg::MessagesLostEventTopicStat;

/// Losses of each topic that were published: in transport and in the recorder.
#[derive(Debug, Default)]
pub(super) struct PublishedLosses(BTreeMap<String, (u64, u64)>);

impl PublishedLosses {
    /// Losses since the last call, for topics that have any. A message that came late takes its loss back: the next losses of its topic
    /// are fewer.
    pub(super) fn since_last(&mut self, topics: &[TopicCounts]) -> Vec<MessagesLostEventTopicStat> {
        let mut news = Vec::new();
        for topic in topics.iter().filter(|topic| topic.missed + topic.dropped > 0) {
            let (transport, recorder) = self.0.entry(topic.topic.clone()).or_default();
            let in_transport = topic.missed.saturating_sub(*transport);
            let in_recorder = topic.dropped.saturating_sub(*recorder);
            *transport += in_transport;
            *recorder += in_recorder;
            if in_transport + in_recorder > 0 {
                news.push(MessagesLostEventTopicStat {
                    topic_name: topic.topic.clone(),
                    messages_lost_in_transport: in_transport,
                    messages_lost_in_recorder: in_recorder,
                });
            }
        }
        news
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(name: &str, missed: u64, dropped: u64) -> TopicCounts {
        TopicCounts {
            topic: name.into(),
            type_name: "std_msgs/msg/String".into(),
            received: 100,
            written: 100 - dropped,
            dropped,
            passed: 0,
            missed,
        }
    }

    /// Each loss is published once; a loss that was taken back is set off against the next ones.
    #[test]
    fn losses_are_published_once() {
        let mut published = PublishedLosses::default();
        let mut news = |a: (u64, u64), b: (u64, u64)| {
            let news = published.since_last(&[topic("/a", a.0, a.1), topic("/b", b.0, b.1)]);
            let rows = news.into_iter();
            rows.map(|s| (s.topic_name, s.messages_lost_in_transport, s.messages_lost_in_recorder)).collect::<Vec<_>>()
        };
        assert_eq!(news((0, 0), (0, 0)), []);
        assert_eq!(news((5, 0), (0, 2)), [("/a".into(), 5, 0), ("/b".into(), 0, 2)]);
        assert_eq!(news((5, 0), (0, 2)), []);
        assert_eq!(news((4, 0), (0, 3)), [("/b".into(), 0, 1)]);
        assert_eq!(news((7, 1), (0, 3)), [("/a".into(), 2, 1)]);
    }
}
