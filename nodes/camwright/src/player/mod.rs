// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright replay`: plays a bag to the graph, with the services of rosbag2's player.
//!
//! ```text
//!   ~/pause, ~/seek … ──orders──► Player ──► every topic as it was offered, /clock, events/read_split
//!   Bag ──────────────messages──►   │
//!                                  Pace: which moment of the bag it is
//! ```

mod live_cell;
mod pace;
mod plan;
mod playback;
mod services;

use std::path::PathBuf;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use camwright_msgs::rosgraph_msgs::msg::Clock;

use indicatif::ProgressBar;

use camwright_bag::progress;
use camwright_bag::{Bag, BagError};
use camwright_ros::{Node, NodeOptions, Qos, RosArgs, RosError, Shutdown};
use camwright_run_logger::{Selection, TopicFilter, regex};
use playback::{PlaybackRequest, Player, PlayerOutlets, Track};
use services::PlayerCommand;

/// Time without a new subscriber before the first message is published. A running peer finds a new publisher within 0.2 s (measured
/// with Fast DDS on one machine).
const QUIET: Duration = Duration::from_millis(500);
/// Time for the last messages to reach reliable subscribers.
const FAREWELL: Duration = Duration::from_millis(300);

/// Arguments of `camwright replay`.
#[derive(Debug, Clone, clap::Args)]
pub struct ReplayArgs {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// Playback rate, relative to the recording
    #[arg(long, short, default_value_t = 1.0, value_parser = positive)]
    pub rate: f64,
    /// Play only these topics; `*` matches anything
    #[arg(long, num_args = 1.., value_name = "TOPIC")]
    pub topics: Vec<String>,
    /// Play only topics that match this expression (added to --topics)
    #[arg(long, short = 'e', default_value = "", value_name = "REGEX")]
    pub regex: String,
    /// Exclude these topics; `*` matches anything
    #[arg(long, num_args = 1.., value_name = "TOPIC")]
    pub exclude: Vec<String>,
    /// Exclude topics that match this regular expression
    #[arg(long, short = 'x', default_value = "", value_name = "REGEX")]
    pub exclude_regex: String,
    /// Start this long after the first message; earlier latched messages are sent at once
    #[arg(long, default_value_t = 0.0, value_parser = not_negative, value_name = "SECONDS")]
    pub start_offset: f64,
    /// Stop after this time of the bag
    #[arg(long, value_parser = not_negative, value_name = "SECONDS")]
    pub playback_duration: Option<f64>,
    /// Stop at this time of the bag (s since 1970)
    #[arg(long, value_parser = not_negative, value_name = "SECONDS")]
    pub playback_until_sec: Option<f64>,
    /// Wait this long before the first message
    #[arg(long, short = 'd', default_value_t = 0.0, value_parser = not_negative, value_name = "SECONDS")]
    pub delay: f64,
    /// Start paused, until `~/resume`, `~/play_next` or `~/burst` is called
    #[arg(long, short = 'p')]
    pub start_paused: bool,
    /// Repeat until interrupted
    #[arg(long = "loop", short = 'l')]
    pub repeat: bool,
    /// Stay after the end and after `~/stop`; `~/play` plays again
    #[arg(long)]
    pub stay: bool,
    /// Publish the time of the bag on /clock at this rate, instead of the recorded clock
    #[arg(long, value_parser = positive, value_name = "HZ", num_args = 0..=1, default_missing_value = "40")]
    pub clock: Option<f64>,
    /// Play the topics of a cell although a live cell has them
    #[arg(long)]
    pub onto_live_cell: bool,
    /// Maximum time to wait for subscribers
    #[arg(long, default_value_t = 2.0, value_parser = not_negative, value_name = "SECONDS")]
    pub wait: f64,
}

fn not_negative(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number, for example 0.5"))?;
    // A billion seconds are 31 years; NaN is in no range.
    if (0.0..1e9).contains(&value) { Ok(value) } else { Err("must be a number from 0 to 1e9".into()) }
}

fn positive(text: &str) -> Result<f64, String> {
    not_negative(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("must be greater than 0".into()) })
}

/// Why a bag was not played.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The bag cannot be read.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// The graph refused.
    #[error(transparent)]
    Ros(#[from] RosError),
    /// The selection of topics or times is invalid.
    #[error("{reason}")]
    Regex {
        /// Description of the error.
        reason: String,
    },
    /// There is nothing to play.
    #[error("{bag} has no message on the selected topics; `camwright bag info` lists its topics")]
    Nothing {
        /// The bag.
        bag: String,
    },
    /// The nodes of a live cell would take the messages for those of their partners.
    #[error(
        "nothing is played: {node} belongs to a live cell, which has topics of this bag ({topics}); play in another domain \
         (ROS_DOMAIN_ID=7), rename them (--ros-args -r /joint_states:=/old/joint_states) or leave them out (--exclude \
         '/machine/*'); --onto-live-cell plays them all the same"
    )]
    LiveCell {
        /// Node that shows that the cell is live.
        node: String,
        /// Topics of the bag that the cell has.
        topics: String,
    },
}

/// Result of a playback.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PlaybackSummary {
    /// Messages published.
    pub messages: u64,
    /// Messages that could not be published.
    pub failed: u64,
    /// Topics that had a subscriber when the first message went out.
    pub matched_topics: usize,
    /// Topics played.
    pub topics: usize,
    /// The end was asked for before the bag's.
    pub interrupted: bool,
}

/// Plays a bag to the graph from the node `bag_player`, which offers the services of rosbag2's player, until the bag's end or until
/// shutdown is requested.
///
/// # Errors
/// When the bag cannot be read or the graph refuses the node.
pub fn play(args: &ReplayArgs, ros: &RosArgs, shutdown: &Shutdown) -> Result<PlaybackSummary, ReplayError> {
    let bag = Bag::open(&args.bag)?;
    let nothing = || ReplayError::Nothing { bag: args.bag.display().to_string() };
    let selection = args.selection()?;
    let wish = args.wish(bag.log_times_ns().ok_or_else(nothing)?);
    let node = Node::new(NodeOptions::new("bag_player", ros))?;
    let spinning = node.spin_in_thread()?;
    if !args.onto_live_cell {
        refuse_live_cell(&node, &bag, &selection)?;
    }
    let mut tracks = Vec::with_capacity(bag.topics().len());
    for (topic, &count) in bag.topics().iter().zip(bag.message_counts()) {
        let publisher = if count > 0 && selection.selects(&topic.name, &topic.type_name) {
            Some(node.raw_publisher(&topic.name, &topic.type_name, &plan::offered_qos(topic, count))?)
        } else {
            None
        };
        tracks.push(Track { publisher, is_latched: topic.is_latched() });
    }
    let topics = tracks.iter().filter(|t| t.publisher.is_some()).count();
    if topics == 0 {
        return Err(nothing());
    }
    let (sender, orders) = mpsc::channel();
    let clock = |hertz: f64| {
        let period = Duration::from_secs_f64(1.0 / hertz);
        node.publisher::<Clock>("/clock", &Qos::default_topic()).map(|publisher| (publisher, period))
    };
    let outlets = PlayerOutlets {
        clock: args.clock.map(clock).transpose()?,
        splits: node.publisher("events/read_split", &Qos::default_topic())?,
        node_name: node.fully_qualified_name().to_owned(),
        progress: bar(&wish),
    };
    let services = services::offer(&node, &sender)?;
    let _end = shutdown.on_request(move || drop(sender.send(PlayerCommand::End)));
    wait_for_subscribers(&tracks, Duration::from_secs_f64(args.wait), shutdown);
    let matched_topics = tracks.iter().filter(|t| t.matched() > 0).count();
    let mut player = Player::new(&bag, &tracks, outlets, orders, wish);
    let outcome = player.run();
    let played = player.finish();
    drop(services);
    outcome?;
    // Even after Ctrl-C: what was published is to arrive.
    std::thread::sleep(FAREWELL);
    spinning.stop();
    node.shutdown();
    Ok(PlaybackSummary { topics, matched_topics, ..played })
}

/// Refuses a bag with selected topics of a cell that is live.
fn refuse_live_cell(node: &Node, bag: &Bag, selection: &Selection) -> Result<(), ReplayError> {
    let played = bag.topics().iter().zip(bag.message_counts());
    let played = played.filter(|(topic, count)| **count > 0 && selection.selects(&topic.name, &topic.type_name));
    let topics = played.map(|(topic, _)| node.resolve_topic(&topic.name)).collect::<Result<Vec<_>, _>>()?;
    match live_cell::find(node, &topics) {
        None => Ok(()),
        Some(live_cell::LiveCell { node, topics }) => {
            Err(ReplayError::LiveCell { node, topics: live_cell::listed(&topics) })
        }
    }
}

impl ReplayArgs {
    fn selection(&self) -> Result<Selection, ReplayError> {
        let filter = |names: &[String], text: &str| {
            let regex = regex(text).map_err(|reason| ReplayError::Regex { reason })?;
            Ok::<_, ReplayError>(TopicFilter { names: names.to_vec(), regex, types: Vec::new() })
        };
        let mut exclude = filter(&self.exclude, &self.exclude_regex)?;
        if self.clock.is_some() {
            // Two clocks would contradict each other.
            exclude.types.push("rosgraph_msgs/msg/Clock".into());
        }
        Ok(Selection::new("/", filter(&self.topics, &self.regex)?, exclude))
    }

    /// `times_ns`: of the first and the last message.
    fn wish(&self, times_ns: (u64, u64)) -> PlaybackRequest {
        let ns = |seconds: f64| u64::try_from(Duration::from_secs_f64(seconds).as_nanos()).unwrap_or(u64::MAX);
        let start_ns = times_ns.0.saturating_add(ns(self.start_offset));
        let bounds = [self.playback_duration.map(|s| start_ns.saturating_add(ns(s))), self.playback_until_sec.map(ns)];
        PlaybackRequest {
            span: (start_ns, bounds.into_iter().flatten().fold(times_ns.1, u64::min)),
            rate: self.rate,
            starts_paused: self.start_paused,
            repeats: self.repeat,
            stays: self.stay,
            delay: Duration::from_secs_f64(self.delay),
        }
    }
}

/// Waits until there are subscribers and no more turn up, or for so long.
fn wait_for_subscribers(tracks: &[Track], longest: Duration, shutdown: &Shutdown) {
    let begin = Instant::now();
    let (mut matched, mut since) = (0, begin);
    while begin.elapsed() < longest {
        let now: usize = tracks.iter().map(Track::matched).sum();
        if now != matched {
            (matched, since) = (now, Instant::now());
        }
        if matched > 0 && since.elapsed() >= QUIET {
            return;
        }
        if shutdown.wait_timeout(Duration::from_millis(20)) {
            return;
        }
    }
}

/// A bar in milliseconds of the bag.
fn bar(wish: &PlaybackRequest) -> ProgressBar {
    let milliseconds = wish.span.1.saturating_sub(wish.span.0) / 1_000_000;
    let bar = progress::bar(milliseconds, "{bar:40} {msg} {elapsed_precise} (eta {eta})");
    bar.set_message(format!("playing at {} times", wish.rate));
    bar
}
