//! `camwright replay`: plays a bag to the graph.

mod plan;

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::bag::{Bag, BagError};
use crate::ros::{Node, NodeOptions, RawPublisher, RosArgs, RosError, Shutdown};
use crate::run_logger::Selection;

/// How long no further subscriber may turn up before the first message goes out. A peer that is already running finds a new
/// publisher within 0.2 s (measured with Fast DDS on one machine).
const QUIET: Duration = Duration::from_millis(500);
/// How long the last messages have to reach reliable subscribers.
const FAREWELL: Duration = Duration::from_millis(300);

/// Arguments of `camwright replay`.
#[derive(Debug, Clone, clap::Args)]
pub struct ReplayArgs {
    /// Directory of the bag, or one MCAP file
    pub bag: PathBuf,
    /// How many seconds of the bag are played in one second
    #[arg(long, short, default_value_t = 1.0, value_parser = positive)]
    pub rate: f64,
    /// Only these topics; `*` stands for anything
    #[arg(long, num_args = 1.., value_name = "TOPIC")]
    pub topics: Vec<String>,
    /// Not these topics; `*` stands for anything
    #[arg(long, num_args = 1.., value_name = "TOPIC")]
    pub exclude: Vec<String>,
    /// Begin so many seconds after the first message; latched messages before that are played at once
    #[arg(long, default_value_t = 0.0, value_parser = not_negative, value_name = "SECONDS")]
    pub start_offset: f64,
    /// Begin again at the end, until interrupted
    #[arg(long = "loop", short = 'l')]
    pub repeat: bool,
    /// Wait at most so many seconds for subscribers before the first message
    #[arg(long, default_value_t = 2.0, value_parser = not_negative, value_name = "SECONDS")]
    pub wait: f64,
}

fn not_negative(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    // A billion seconds are 31 years; NaN is in no range.
    if (0.0..1e9).contains(&value) { Ok(value) } else { Err("it must be a number from 0 on".into()) }
}

fn positive(text: &str) -> Result<f64, String> {
    not_negative(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("it must be greater than 0".into()) })
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
    /// There is nothing to play.
    #[error("{bag} has no message on the topics asked for")]
    Nothing {
        /// The bag.
        bag: String,
    },
}

/// What was played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Played {
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

/// Runs `camwright replay`. Exit code 0: played, or ended by Ctrl-C; 2: it could not be.
#[must_use]
pub fn run(args: &ReplayArgs, ros: &RosArgs) -> ExitCode {
    let played = Shutdown::on_signals().map_err(ReplayError::from).and_then(|shutdown| play(args, ros, &shutdown));
    let (text, code) = match played {
        Ok(played) => {
            let cut = if played.interrupted { ", interrupted" } else { "" };
            let failed =
                if played.failed > 0 { format!(", {} could not be sent", played.failed) } else { String::new() };
            let (n, topics, matched) = (played.messages, played.topics, played.matched_topics);
            (format!("played {n} messages on {topics} topics, {matched} with subscribers at the start{failed}{cut}"), 0)
        }
        Err(error) => (format!("error: {error}"), 2),
    };
    // A terminal that went away is no failure of ours.
    let _ = writeln!(io::stderr(), "{text}");
    ExitCode::from(code)
}

/// Plays a bag to the graph from a node of its own, until its end or until shutdown is requested.
///
/// # Errors
/// When the bag cannot be read or the graph refuses the node.
pub fn play(args: &ReplayArgs, ros: &RosArgs, shutdown: &Shutdown) -> Result<Played, ReplayError> {
    let bag = Bag::open(&args.bag)?;
    let selection = Selection::new("/", &args.topics, &args.exclude);
    let nothing = || ReplayError::Nothing { bag: args.bag.display().to_string() };
    let (first_ns, last_ns) = bag.log_times_ns().ok_or_else(nothing)?;

    let node = Node::new(NodeOptions::new("bag_player", ros))?;
    let spinning = node.spin_in_thread()?;
    let mut tracks = Vec::with_capacity(bag.topics().len());
    for (topic, &count) in bag.topics().iter().zip(bag.message_counts()) {
        let publisher = if count > 0 && selection.takes(&topic.name) {
            Some(node.raw_publisher(&topic.name, &topic.type_name, &plan::offered_qos(topic, count))?)
        } else {
            None
        };
        tracks.push(Track { publisher, is_latched: topic.is_latched() });
    }
    let mut played = Played { topics: tracks.iter().filter(|t| t.publisher.is_some()).count(), ..Played::default() };
    if played.topics == 0 {
        return Err(nothing());
    }
    wait_for_subscribers(&tracks, Duration::from_secs_f64(args.wait), shutdown);
    played.matched_topics = tracks.iter().filter(|t| t.matched() > 0).count();

    let offset_ns = u64::try_from(Duration::from_secs_f64(args.start_offset).as_nanos()).unwrap_or(u64::MAX);
    let span = Span { start_ns: first_ns.saturating_add(offset_ns), last_ns, rate: args.rate };
    while !played.interrupted {
        play_once(&bag, &tracks, &span, shutdown, &mut played)?;
        if !args.repeat {
            break;
        }
    }
    // Even after Ctrl-C: what was published is to arrive.
    std::thread::sleep(FAREWELL);
    spinning.stop();
    node.shutdown();
    Ok(played)
}

/// One topic of the bag.
struct Track {
    publisher: Option<RawPublisher>,
    is_latched: bool,
}

impl Track {
    fn matched(&self) -> usize {
        self.publisher.as_ref().map_or(0, RawPublisher::matched)
    }
}

/// From where to where, and how fast.
struct Span {
    start_ns: u64,
    last_ns: u64,
    rate: f64,
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

fn play_once(
    bag: &Bag,
    tracks: &[Track],
    span: &Span,
    shutdown: &Shutdown,
    played: &mut Played,
) -> Result<(), ReplayError> {
    let progress = progress(span);
    let mut messages = bag.messages();
    let begin = Instant::now();
    while let Some(message) = messages.next_message()? {
        let Some(track) = tracks.get(message.topic) else { continue };
        let Some(publisher) = &track.publisher else { continue };
        if message.log_time_ns < span.start_ns && !track.is_latched {
            continue;
        }
        let due = begin + Duration::from_nanos(plan::due_ns(message.log_time_ns, span.start_ns, span.rate));
        let wait = due.saturating_duration_since(Instant::now());
        if shutdown.is_requested() || (!wait.is_zero() && shutdown.wait_timeout(wait)) {
            played.interrupted = true;
            break;
        }
        match publisher.publish(&message.data) {
            Ok(()) => played.messages += 1,
            Err(error) => {
                played.failed += 1;
                if played.failed == 1 {
                    progress.suspend(|| tracing::warn!("{error}"));
                }
            }
        }
        progress.set_position(message.log_time_ns.saturating_sub(span.start_ns) / 1_000_000);
    }
    progress.finish_and_clear();
    Ok(())
}

/// A bar in milliseconds of the bag; hidden unless a person looks on.
fn progress(span: &Span) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {msg} {elapsed_precise} (eta {eta})");
    let bar = ProgressBar::with_draw_target(
        Some(span.last_ns.saturating_sub(span.start_ns) / 1_000_000),
        ProgressDrawTarget::stderr_with_hz(10),
    );
    bar.set_message(format!("playing at {} times", span.rate));
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
