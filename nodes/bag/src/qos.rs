// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The quality of service a publisher offered, in the words of rosbag2's metadata version 9.

use super::yaml::YamlWriter;
use serde::Deserialize;
use std::time::Duration;

/// Value that rosbag2 writes for an infinite duration: the largest signed 64-bit number of nanoseconds.
const INFINITE_S: u64 = 9_223_372_036;
const INFINITE_NS: u64 = 854_775_807;

/// An enumeration with its word in a bag and, for bags before version 9, its number in `rmw/types.h`.
macro_rules! vocabulary {
    ($(#[$meta:meta])* $name:ident { $($(#[$item_meta:meta])* $item:ident = $word:literal $number:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$item_meta])* $item,)+ }

        impl $name {
            /// The word in a bag.
            #[must_use]
            pub fn word(self) -> &'static str {
                match self { $(Self::$item => $word,)+ }
            }

            fn from_word(word: &str) -> Option<Self> {
                match word { $($word => Some(Self::$item),)+ _ => None }
            }

            fn from_number(number: i64) -> Option<Self> {
                match number { $($number => Some(Self::$item),)+ _ => None }
            }
        }
    };
}

vocabulary! {
    /// Number of samples that a publisher keeps.
    History {
        /// Left to the vendor.
        SystemDefault = "system_default" 0,
        /// The last `depth` samples.
        KeepLast = "keep_last" 1,
        KeepAll = "keep_all" 2,
        /// Not known: discovery does not carry it.
        Unknown = "unknown" 3,
    }
}

vocabulary! {
    /// Retransmission of lost samples.
    Reliability {
        /// Left to the vendor.
        SystemDefault = "system_default" 0,
        /// Sent again until received.
        Reliable = "reliable" 1,
        BestEffort = "best_effort" 2,
        Unknown = "unknown" 3,
    }
}

vocabulary! {
    /// Delivery of earlier samples to a late subscriber.
    Durability {
        /// Left to the vendor.
        SystemDefault = "system_default" 0,
        /// It does, up to the publisher's depth.
        TransientLocal = "transient_local" 1,
        Volatile = "volatile" 2,
        Unknown = "unknown" 3,
    }
}

vocabulary! {
    /// Method by which a publisher shows that it is alive.
    Liveliness {
        /// Left to the vendor.
        SystemDefault = "system_default" 0,
        /// The middleware does it.
        Automatic = "automatic" 1,
        /// The publisher does it for each topic.
        ManualByTopic = "manual_by_topic" 3,
        Unknown = "unknown" 4,
    }
}

/// Offered quality of service of one publisher.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct QosProfile {
    /// Number of samples it keeps; `Unknown` in most bags, since discovery does not carry it.
    pub history: History,
    /// Samples kept with `KeepLast`; 0 when unknown.
    pub depth: u64,
    /// Retransmission of lost samples.
    pub reliability: Reliability,
    /// Delivery of earlier samples to late subscribers.
    pub durability: Durability,
    /// Longest time between samples; `None` is without end.
    pub deadline: Option<Duration>,
    /// Age at which a sample expires; `None`: never.
    pub lifespan: Option<Duration>,
    /// Sign of life of the publisher.
    pub liveliness: Liveliness,
    /// Maximum silence; `None`: no limit.
    pub liveliness_lease: Option<Duration>,
    /// The DDS topic has no `rt/` in front.
    pub avoid_ros_namespace_conventions: bool,
}

impl QosProfile {
    /// Quality of service of a publisher as discovery shows it, with only reliability and durability set.
    #[must_use]
    pub fn discovered(reliability: Reliability, durability: Durability) -> Self {
        Self {
            history: History::Unknown,
            depth: 0,
            reliability,
            durability,
            deadline: None,
            lifespan: None,
            liveliness: Liveliness::Automatic,
            liveliness_lease: None,
            avoid_ros_namespace_conventions: false,
        }
    }

    /// The same for every other policy than history and depth, which a subscriber need not agree with.
    #[must_use]
    pub fn agrees_with(&self, other: &Self) -> bool {
        self.reliability == other.reliability
            && self.durability == other.durability
            && self.deadline == other.deadline
            && self.lifespan == other.lifespan
            && self.liveliness == other.liveliness
            && self.liveliness_lease == other.liveliness_lease
    }
}

/// Writes one profile, in the order of rosbag2's encoder.
pub(super) fn write(yaml: &mut YamlWriter, profile: &QosProfile) {
    yaml.value("history", profile.history.word());
    yaml.value("depth", profile.depth);
    yaml.value("reliability", profile.reliability.word());
    yaml.value("durability", profile.durability.word());
    write_time(yaml, "deadline", profile.deadline);
    write_time(yaml, "lifespan", profile.lifespan);
    yaml.value("liveliness", profile.liveliness.word());
    write_time(yaml, "liveliness_lease_duration", profile.liveliness_lease);
    yaml.value("avoid_ros_namespace_conventions", profile.avoid_ros_namespace_conventions);
}

fn write_time(yaml: &mut YamlWriter, key: &str, duration: Option<Duration>) {
    let (sec, nsec) = duration.map_or((INFINITE_S, INFINITE_NS), |d| (d.as_secs(), u64::from(d.subsec_nanos())));
    yaml.map(key, |yaml| {
        yaml.value("sec", sec);
        yaml.value("nsec", nsec);
    });
}

/// The YAML list of `profiles`, each line after `indent` spaces, byte for byte as rosbag2 writes it. No profiles: `[]`.
#[must_use]
pub fn to_yaml(profiles: &[QosProfile], indent: usize) -> String {
    if profiles.is_empty() {
        return "[]".to_owned();
    }
    let mut yaml = YamlWriter::new(indent);
    yaml.items(profiles, write);
    yaml.finish()
}

/// Reads what [`to_yaml`] writes, and the numbers of bags before version 9.
///
/// # Errors
/// One sentence when the text is no YAML list of profiles or uses a word that is not in the vocabulary.
pub fn from_yaml(text: &str) -> Result<Vec<QosProfile>, String> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    let raw: Vec<RawProfile> = serde_saphyr::from_str(text).map_err(|e| format!("QoS profiles: {e}"))?;
    raw.into_iter().map(RawProfile::parsed).collect()
}

/// Returns whether readable profiles have numbers instead of words, as before metadata version 9.
#[must_use]
pub fn is_of_old_form(text: &str) -> bool {
    let raw: Vec<RawProfile> = serde_saphyr::from_str(text).unwrap_or_default();
    let is_number = |policy: &WordOrNumber| matches!(policy, WordOrNumber::Number(_));
    raw.iter().any(|p| [&p.history, &p.reliability, &p.durability, &p.liveliness].into_iter().any(is_number))
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum WordOrNumber {
    Number(i64),
    Word(String),
}

#[derive(Debug, Clone, Deserialize)]
struct RawTime {
    sec: u64,
    nsec: u64,
}

/// A profile as it stands in the YAML text.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct RawProfile {
    history: WordOrNumber,
    depth: u64,
    reliability: WordOrNumber,
    durability: WordOrNumber,
    deadline: RawTime,
    lifespan: RawTime,
    liveliness: WordOrNumber,
    liveliness_lease_duration: RawTime,
    avoid_ros_namespace_conventions: bool,
}

impl RawProfile {
    /// The profile this text means, or the word that means nothing.
    pub(super) fn parsed(self) -> Result<QosProfile, String> {
        fn known<T>(
            raw: &WordOrNumber,
            key: &str,
            word: impl Fn(&str) -> Option<T>,
            number: impl Fn(i64) -> Option<T>,
        ) -> Result<T, String> {
            match raw {
                WordOrNumber::Word(w) => word(w).ok_or_else(|| format!("QoS profiles: {key} '{w}' is not known")),
                WordOrNumber::Number(n) => number(*n).ok_or_else(|| format!("QoS profiles: {key} {n} is not known")),
            }
        }
        fn time(raw: &RawTime) -> Option<Duration> {
            // Some middlewares write their own infinity, all of them larger than any real deadline.
            (raw.sec < i32::MAX as u64).then(|| Duration::from_secs(raw.sec) + Duration::from_nanos(raw.nsec))
        }
        Ok(QosProfile {
            history: known(&self.history, "history", History::from_word, History::from_number)?,
            depth: self.depth,
            reliability: known(&self.reliability, "reliability", Reliability::from_word, Reliability::from_number)?,
            durability: known(&self.durability, "durability", Durability::from_word, Durability::from_number)?,
            deadline: time(&self.deadline),
            lifespan: time(&self.lifespan),
            liveliness: known(&self.liveliness, "liveliness", Liveliness::from_word, Liveliness::from_number)?,
            liveliness_lease: time(&self.liveliness_lease_duration),
            avoid_ros_namespace_conventions: self.avoid_ros_namespace_conventions,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text of RECORDING section 1.4, as rosbag2's encoder writes it.
    const REFERENCE: &str = "\
- history: unknown
  depth: 0
  reliability: reliable
  durability: volatile
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: automatic
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false";

    #[test]
    fn a_discovered_profile_is_written_as_rosbag2_writes_it() {
        let profile = QosProfile::discovered(Reliability::Reliable, Durability::Volatile);
        assert_eq!(to_yaml(&[profile], 0), REFERENCE);
        assert_eq!(to_yaml(&[], 0), "[]");
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut second = QosProfile::discovered(Reliability::BestEffort, Durability::TransientLocal);
        second.history = History::KeepLast;
        second.depth = 7;
        second.deadline = Some(Duration::new(1, 500_000_000));
        second.liveliness = Liveliness::ManualByTopic;
        let profiles = vec![QosProfile::discovered(Reliability::Reliable, Durability::Volatile), second];
        assert_eq!(from_yaml(&to_yaml(&profiles, 0)), Ok(profiles.clone()));
        assert_eq!(from_yaml(&to_yaml(&profiles, 10)), Ok(profiles));
        assert_eq!(from_yaml("[]"), Ok(Vec::new()));
        assert_eq!(from_yaml(""), Ok(Vec::new()));
    }

    #[test]
    fn numbers_of_older_bags_are_understood() {
        let text = REFERENCE
            .replace("history: unknown", "history: 3")
            .replace("reliability: reliable", "reliability: 1")
            .replace("durability: volatile", "durability: 2")
            .replace("liveliness: automatic", "liveliness: 1");
        let expected = QosProfile::discovered(Reliability::Reliable, Durability::Volatile);
        assert_eq!(from_yaml(&text), Ok(vec![expected]));
    }

    #[test]
    fn an_unknown_word_is_refused_by_name() {
        let error = from_yaml(&REFERENCE.replace("volatile", "eternal")).expect_err("no such durability");
        assert!(error.contains("durability 'eternal'"), "{error}");
    }
}
