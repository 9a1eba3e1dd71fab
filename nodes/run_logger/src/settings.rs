// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The recorder's parameters.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use super::retention::Retention;
use super::selection::{TopicFilter, regex};
use camwright_bag::info::utc;
use camwright_bag::recording::RecordingOptions;
use camwright_bag::{Preset, SnapshotOptions, SplitLimits, WriterOptions};
use camwright_files::convert::bytes_from_mb;
use camwright_ros::{Parameter, ParameterChanges, ParameterValue, Parameters};

/// Settings of one recording.
#[derive(Debug, Clone)]
pub(super) struct RecorderSettings {
    /// Directory of the bag.
    pub(super) bag_dir: PathBuf,
    /// Which topics to take; saying nothing takes all.
    pub(super) include: TopicFilter,
    /// Which topics to leave out.
    pub(super) exclude: TopicFilter,
    /// Take topics of actions' own types too.
    pub(super) include_feedback: bool,
    pub(super) start_paused: bool,
    /// Ticks after which the machine hears how far the bag is, in addition to ten times a second.
    pub(super) credit_ticks: u64,
    /// Unread messages that a subscription may hold.
    pub(super) depth: u32,
    /// Delay of a snapshot after an alarm, if only snapshots are written.
    pub(super) snapshot_delay: Duration,
    /// Retention of older runs.
    pub(super) retention: Retention,
    /// Stamp with `/clock`.
    pub(super) use_sim_time: bool,
    /// Options of the bag.
    pub(super) recording: RecordingOptions,
}

/// Default of the free space kept on the disk (MB).
pub const MIN_FREE_MB: u64 = 100;

pub(super) fn parameters() -> Vec<Parameter> {
    vec![
        Parameter::string("bag_dir", "")
            .describe("directory of the next bag, which must not exist; empty: bags/run_<UTC time>"),
        Parameter::string("run_id", "").describe("name of the run, written into the bag"),
        Parameter::string_array("custom_data", &[])
            .describe("additional metadata of the run, each entry as key=value")
            .constraints("each entry has the form key=value"),
        Parameter::string("preset", "default")
            .describe("storage preset of rosbag2")
            .choices(&Preset::NAMES.map(|(name, _)| name)),
        Parameter::string_array("topics", &[])
            .describe("topics to record, with wildcard '*'; topics, regex and types empty: all topics of the cell"),
        Parameter::string("regex", "").describe("also records topics whose name contains this regular expression"),
        Parameter::string_array("types", &[]).describe("also records topics of these types, with wildcard '*'"),
        Parameter::string_array("exclude", &[]).describe("topics to exclude, with wildcard '*'"),
        Parameter::string("exclude_regex", "").describe("excludes topics whose name contains this regular expression"),
        Parameter::string_array("exclude_types", &[]).describe("types to exclude, with wildcard '*'"),
        Parameter::bool("include_feedback", false)
            .describe("also records the feedback of actions; rosbags and mcap-ros2-support cannot decode their types"),
        Parameter::bool("start_on_activate", true)
            .describe("records from activation on; false: paused until ~/resume"),
        camwright_ros::running::autostart::parameter(),
        Parameter::integer("credit_ticks", 100)
            .describe("machine ticks between two messages on ~/status, in addition to ten messages a second")
            .integer_range(1, 1_000_000),
        Parameter::integer("depth", 20_000)
            .describe("maximum number of unread messages of a topic, at most 16 MB")
            .integer_range(1, 65_536),
        Parameter::integer("queue_mb", 256)
            .describe("maximum size of the queue to the disk (MB); excess messages are dropped and counted")
            .integer_range(1, 65_536),
        Parameter::integer("split_mb", 0)
            .describe("maximum size of a file of the bag (MB); 0: unlimited")
            .integer_range(0, 1_000_000),
        Parameter::double("split_s", 0.0)
            .describe("maximum duration of a file of the bag (s); 0: unlimited")
            .range(0.0, 1e7),
        Parameter::integer("max_bag_files", 0)
            .describe("number of files of the bag to retain; a split deletes the oldest; 0: all")
            .integer_range(0, 1_000_000),
        Parameter::double("snapshot_s", 0.0)
            .describe("duration of a snapshot (s): messages stay in memory until ~/snapshot or an alarm; 0: records all messages")
            .range(0.0, 3600.0),
        Parameter::integer("snapshot_mb", 256)
            .describe("maximum memory of a snapshot (MB); the oldest messages are dropped first")
            .integer_range(1, 65_536),
        Parameter::double("snapshot_delay_s", 1.0)
            .describe("delay of a snapshot after an alarm (s)")
            .range(0.0, 60.0),
        Parameter::integer("min_free_mb", MIN_FREE_MB.cast_signed())
            .describe("minimum free space of the disk (MB); below it no recording starts and a running one is closed")
            .integer_range(0, 1_000_000),
        Parameter::integer("keep_runs", 0)
            .describe("number of runs to retain beside the next bag, which counts too; the oldest are deleted; 0: all")
            .integer_range(0, 1_000_000),
        Parameter::integer("keep_mb", 0)
            .describe("size of runs to retain beside the next bag (MB); the oldest are deleted; 0: unlimited")
            .integer_range(0, 1_000_000_000),
        Parameter::double("flush_interval_s", 0.1)
            .describe("maximum time until a message is written (s)")
            .range(0.01, 10.0),
        Parameter::double("sync_interval_s", 1.0)
            .describe("maximum time until a message is synchronised to the disk (s)")
            .range(0.1, 60.0),
    ]
}

/// Refuses what a recording could not begin with.
pub(super) fn check(changes: &ParameterChanges) -> Result<(), String> {
    for (name, value) in changes {
        match (name.as_str(), value) {
            ("preset", ParameterValue::String(preset)) => {
                parse_preset(preset)?;
            }
            ("regex" | "exclude_regex", ParameterValue::String(text)) => {
                regex(text)?;
            }
            ("custom_data", ParameterValue::StringArray(entries)) => {
                parse_custom_data(entries)?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn parse_preset(name: &str) -> Result<Preset, String> {
    Preset::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Preset::NAMES.iter().map(|(known, _)| *known).collect();
        format!("preset '{name}' is none of {}", known.join(", "))
    })
}

fn parse_custom_data(entries: &[String]) -> Result<BTreeMap<String, String>, String> {
    entries
        .iter()
        .map(|entry| match entry.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().to_owned(), value.to_owned())),
            _ => Err(format!("custom_data entry '{entry}' is not key=value")),
        })
        .collect()
}

impl RecorderSettings {
    /// The parameters as they are now. `now_ns` (ns since 1970, system clock) names a bag without a name.
    ///
    /// # Errors
    /// One sentence about the parameter that is wrong.
    pub(super) fn read(parameters: &Parameters, now_ns: u64) -> Result<Self, String> {
        let started = utc(now_ns);
        let mut custom_data = parse_custom_data(&parameters.string_array("custom_data"))?;
        let run_id = parameters.string("run_id");
        if !run_id.is_empty() {
            custom_data.insert("camwright.run_id".into(), run_id);
        }
        custom_data.insert("camwright.wall_start_utc".into(), started.clone());
        let bag_dir = match parameters.string("bag_dir") {
            // To the second, and without the colons that some file systems refuse.
            dir if dir.is_empty() => PathBuf::from(format!("bags/run_{}Z", started[..19].replace(':', "-"))),
            dir => PathBuf::from(dir),
        };
        let count = |name: &str| u64::try_from(parameters.integer(name)).map_err(|_| format!("{name} is negative"));
        let megabytes = |name: &str| Ok::<_, String>(bytes_from_mb(count(name)?));
        let seconds = |name: &str| Duration::from_secs_f64(parameters.double(name));
        let wanted = |name: &str| Some(seconds(name)).filter(|time| !time.is_zero());
        let split_bytes = megabytes("split_mb")?;
        let snapshot_bytes = megabytes("snapshot_mb")?;
        Ok(Self {
            bag_dir,
            include: TopicFilter {
                names: parameters.string_array("topics"),
                regex: regex(&parameters.string("regex"))?,
                types: parameters.string_array("types"),
            },
            exclude: TopicFilter {
                names: parameters.string_array("exclude"),
                regex: regex(&parameters.string("exclude_regex"))?,
                types: parameters.string_array("exclude_types"),
            },
            include_feedback: parameters.bool("include_feedback"),
            start_paused: !parameters.bool("start_on_activate"),
            credit_ticks: count("credit_ticks")?,
            depth: u32::try_from(count("depth")?).map_err(|_| "depth is too large".to_owned())?,
            snapshot_delay: seconds("snapshot_delay_s"),
            retention: Retention { runs: count("keep_runs")?, bytes: megabytes("keep_mb")? },
            use_sim_time: parameters.bool("use_sim_time"),
            recording: RecordingOptions {
                writer: WriterOptions {
                    preset: parse_preset(&parameters.string("preset"))?,
                    split: SplitLimits {
                        bytes: (split_bytes > 0).then_some(split_bytes),
                        duration: wanted("split_s"),
                        files: usize::try_from(count("max_bag_files")?).ok().filter(|&files| files > 0),
                    },
                    custom_data,
                },
                flush_interval: seconds("flush_interval_s"),
                sync_interval: seconds("sync_interval_s"),
                min_free_bytes: megabytes("min_free_mb")?,
                snapshot: wanted("snapshot_s").map(|keep| SnapshotOptions { keep, bytes: snapshot_bytes }),
                queue_bytes: megabytes("queue_mb")?,
                ..RecordingOptions::default()
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn custom_data_is_pairs_and_a_preset_has_a_name() {
        let entries = ["a=1".to_owned(), "b = x=y".to_owned()];
        let pairs = parse_custom_data(&entries).expect("they are pairs");
        assert_eq!(pairs, BTreeMap::from([("a".into(), "1".into()), ("b".into(), " x=y".into())]));
        assert_eq!(parse_custom_data(&["=1".into()]), Err("custom_data entry '=1' is not key=value".into()));
        let change = [("preset".to_owned(), ParameterValue::String("lz4".into()))];
        assert_eq!(
            check(&change),
            Err("preset 'lz4' is none of default, zstd, zstd_fast, zstd_small, fastwrite".into())
        );
        assert_eq!(check(&[("preset".to_owned(), ParameterValue::String("zstd".into()))]), Ok(()));
    }
}
