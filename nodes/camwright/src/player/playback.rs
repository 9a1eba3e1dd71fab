// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plays the messages of a bag when they are due, and does what it is asked meanwhile.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use camwright_msgs::rosbag2_interfaces::msg::ReadSplitEvent;
use camwright_msgs::rosbag2_interfaces::srv::{
    BurstResponse, GetRateResponse, IsPausedResponse, PauseResponse, PlayNextResponse, PlayRequest, PlayResponse,
    ResumeResponse, SeekResponse, SetRateResponse, StopResponse, TogglePausedResponse,
};
use camwright_msgs::rosgraph_msgs::msg::Clock;
use indicatif::ProgressBar;

use super::PlaybackSummary;
use super::pace::PlaybackPace;
use super::services::PlayerCommand;
use camwright_bag::{Bag, BagError, BagMessage, Messages};
use camwright_ros::{Publisher, RawPublisher, from_time, to_time};

/// Messages that are published before it is looked again what is asked.
const BATCH: usize = 500;
/// Maximum wait of the player without a command; commands wake it.
const IDLE: Duration = Duration::from_secs(1);

/// One topic of the bag.
pub(super) struct Track {
    pub(super) publisher: Option<RawPublisher>,
    pub(super) is_latched: bool,
}

impl Track {
    pub(super) fn matched(&self) -> usize {
        self.publisher.as_ref().map_or(0, RawPublisher::matched)
    }
}

/// Outputs in addition to the bag's messages.
pub(super) struct PlayerOutlets {
    /// The bag's time, and how often.
    pub(super) clock: Option<(Publisher<Clock>, Duration)>,
    pub(super) splits: Publisher<ReadSplitEvent>,
    pub(super) node_name: String,
    pub(super) progress: ProgressBar,
}

/// Time range and options of a playback.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaybackRequest {
    /// From and to (ns since 1970).
    pub(super) span: (u64, u64),
    pub(super) rate: f64,
    pub(super) starts_paused: bool,
    pub(super) repeats: bool,
    /// Stays after the end, until it is asked to play again.
    pub(super) stays: bool,
    pub(super) delay: Duration,
}

/// A playback under way.
pub(super) struct Player<'a> {
    bag: &'a Bag,
    tracks: &'a [Track],
    outlets: PlayerOutlets,
    orders: mpsc::Receiver<PlayerCommand>,
    wish: PlaybackRequest,
    pace: PlaybackPace,
    /// None: the playback is over, or was stopped.
    messages: Option<Messages<'a>>,
    next: Option<BagMessage>,
    file: usize,
    next_clock: Instant,
    played: PlaybackSummary,
}

impl<'a> Player<'a> {
    pub(super) fn new(
        bag: &'a Bag,
        tracks: &'a [Track],
        outlets: PlayerOutlets,
        orders: mpsc::Receiver<PlayerCommand>,
        wish: PlaybackRequest,
    ) -> Self {
        Self {
            bag,
            tracks,
            outlets,
            orders,
            wish,
            pace: PlaybackPace::new(wish.span.0, wish.rate),
            messages: None,
            next: None,
            file: 0,
            next_clock: Instant::now(),
            played: PlaybackSummary::default(),
        }
    }

    /// Plays until the end of the bag, until it is stopped, or until the process is to end.
    pub(super) fn run(&mut self) -> Result<(), BagError> {
        self.begin(self.wish.span.0)?;
        if !self.wish.starts_paused {
            self.pace.resume(Instant::now() + self.wish.delay);
        }
        loop {
            match self.orders.recv_timeout(self.wait()) {
                Ok(PlayerCommand::End) => {
                    self.played.interrupted = self.messages.is_some();
                    return Ok(());
                }
                Ok(order) => self.obey(order)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            self.publish_time();
            self.play_due()?;
            if self.messages.is_some() && self.next.is_none() {
                self.end()?;
            }
            if self.messages.is_none() && !self.wish.stays {
                return Ok(());
            }
        }
    }

    pub(super) fn finish(self) -> PlaybackSummary {
        self.outlets.progress.finish_and_clear();
        self.played
    }

    /// Time until the next action.
    fn wait(&self) -> Duration {
        let now = Instant::now();
        let message = self.next.as_ref().and_then(|message| self.pace.due(message.log_time_ns));
        let clock = self.outlets.clock.as_ref().map(|_| self.next_clock);
        let due = message.into_iter().chain(clock).min();
        due.map_or(IDLE, |due| due.saturating_duration_since(now)).min(IDLE)
    }

    /// Goes to a moment of the bag: what is latched before it is played at once, so that listeners know what they would know.
    fn begin(&mut self, from_ns: u64) -> Result<(), BagError> {
        self.messages = Some(self.bag.messages());
        self.file = 0;
        self.pace.jump(Instant::now(), from_ns);
        loop {
            self.advance()?;
            match &self.next {
                Some(message) if message.log_time_ns < from_ns => {
                    if self.tracks.get(message.topic).is_some_and(|track| track.is_latched) {
                        self.publish_next();
                    }
                }
                _ => return Ok(()),
            }
        }
    }

    /// The last message has been played.
    fn end(&mut self) -> Result<(), BagError> {
        if self.wish.repeats {
            return self.begin(self.wish.span.0);
        }
        self.messages = None;
        Ok(())
    }

    /// Takes the next message of a topic that is played, within the span.
    fn advance(&mut self) -> Result<(), BagError> {
        self.next = None;
        let Some(messages) = &mut self.messages else { return Ok(()) };
        while let Some(message) = messages.next_message()? {
            if message.log_time_ns > self.wish.span.1 {
                break;
            }
            if self.tracks.get(message.topic).is_some_and(|track| track.publisher.is_some()) {
                self.next = Some(message);
                break;
            }
        }
        let file = messages.file();
        let name = |index: usize| self.bag.files().get(index).map(|file| file.path.display().to_string());
        while self.file < file {
            let event = ReadSplitEvent {
                closed_file: name(self.file).unwrap_or_default(),
                opened_file: name(self.file + 1).unwrap_or_default(),
                node_name: self.outlets.node_name.clone(),
            };
            self.file += 1;
            if let Err(error) = self.outlets.splits.publish(&event) {
                tracing::warn!("{error}");
            }
        }
        Ok(())
    }

    /// Publishes what is due, a batch at most.
    fn play_due(&mut self) -> Result<(), BagError> {
        for _ in 0..BATCH {
            let Some(message) = &self.next else { break };
            if self.pace.due(message.log_time_ns).is_none_or(|due| due > Instant::now()) {
                break;
            }
            self.publish_next();
            self.advance()?;
        }
        Ok(())
    }

    fn publish_next(&mut self) {
        let Some(message) = &self.next else { return };
        let publisher = self.tracks.get(message.topic).and_then(|track| track.publisher.as_ref());
        match publisher.map(|publisher| publisher.publish(&message.data)) {
            Some(Ok(())) => self.played.messages += 1,
            Some(Err(error)) => {
                self.played.failed += 1;
                if self.played.failed == 1 {
                    self.outlets.progress.suspend(|| tracing::warn!("{error}"));
                }
            }
            None => {}
        }
        self.outlets.progress.set_position(message.log_time_ns.saturating_sub(self.wish.span.0) / 1_000_000);
    }

    /// Publishes the bag's time when that is due.
    fn publish_time(&mut self) {
        let Some((publisher, period)) = &self.outlets.clock else { return };
        let now = Instant::now();
        if now < self.next_clock {
            return;
        }
        self.next_clock = (self.next_clock + *period).max(now);
        let bag_ns = self.pace.at(now).min(self.wish.span.1);
        let clock = Clock { clock: to_time(i64::try_from(bag_ns).unwrap_or(i64::MAX)) };
        if let Err(error) = publisher.publish(&clock) {
            tracing::warn!("{error}");
        }
    }

    /// Plays up to so many messages now, whatever their time; returns how many that were. Only while it stands still.
    fn step(&mut self, max: u64) -> Result<u64, BagError> {
        let mut count = 0;
        while self.pace.is_paused() && count < max {
            let Some(message) = &self.next else { break };
            self.pace.jump(Instant::now(), message.log_time_ns);
            self.publish_next();
            count += 1;
            self.advance()?;
        }
        Ok(count)
    }

    fn obey(&mut self, order: PlayerCommand) -> Result<(), BagError> {
        let now = Instant::now();
        match order {
            PlayerCommand::End => {}
            PlayerCommand::Stop(to) => {
                (self.messages, self.next) = (None, None);
                to.send(&StopResponse::default());
            }
            PlayerCommand::Pause(to) => {
                self.pace.pause(now);
                to.send(&PauseResponse::default());
            }
            PlayerCommand::Resume(to) => {
                self.pace.resume(now);
                to.send(&ResumeResponse::default());
            }
            PlayerCommand::TogglePaused(to) => {
                if self.pace.is_paused() {
                    self.pace.resume(now);
                } else {
                    self.pace.pause(now);
                }
                to.send(&TogglePausedResponse::default());
            }
            PlayerCommand::IsPaused(to) => to.send(&IsPausedResponse { paused: self.pace.is_paused() }),
            PlayerCommand::GetRate(to) => to.send(&GetRateResponse { rate: self.pace.rate() }),
            PlayerCommand::SetRate(rate, to) => {
                let success = rate > 0.0 && rate.is_finite();
                if success {
                    self.pace.set_rate(now, rate);
                }
                to.send(&SetRateResponse { success });
            }
            PlayerCommand::PlayNext(to) => to.send(&PlayNextResponse { success: self.step(1)? == 1 }),
            PlayerCommand::Burst(max, to) => {
                let max = if max == 0 { u64::MAX } else { max };
                to.send(&BurstResponse { actually_burst: self.step(max)? });
            }
            PlayerCommand::Seek(to_ns, to) => {
                let (from, until) = self.wish.span;
                let wanted =
                    u64::try_from(to_ns).ok().filter(|ns| self.messages.is_some() && (from..=until).contains(ns));
                if let Some(bag_ns) = wanted {
                    self.begin(bag_ns)?;
                }
                to.send(&SeekResponse { success: wanted.is_some() });
            }
            PlayerCommand::Play(request, to) => {
                let success = self.messages.is_none();
                if success {
                    self.play(&request)?;
                }
                to.send(&PlayResponse { success });
            }
        }
        Ok(())
    }

    /// Plays once more, with another span of the bag.
    fn play(&mut self, request: &PlayRequest) -> Result<(), BagError> {
        let Some((first_ns, last_ns)) = self.bag.log_times_ns() else { return Ok(()) };
        let unsigned = |ns: i64| u64::try_from(ns).unwrap_or(0);
        let start_ns = first_ns.saturating_add(unsigned(from_time(&request.start_offset)));
        let duration = &request.playback_duration;
        let duration_ns = i64::from(duration.sec) * 1_000_000_000 + i64::from(duration.nanosec);
        let until_ns = unsigned(from_time(&request.playback_until_timestamp));
        // Zero, or less, is no bound.
        let bounds = [
            (duration_ns > 0).then(|| start_ns.saturating_add(unsigned(duration_ns))),
            (until_ns > 0).then_some(until_ns),
        ];
        self.wish.span = (start_ns, bounds.into_iter().flatten().fold(last_ns, u64::min));
        self.pace = PlaybackPace::new(start_ns, self.pace.rate());
        self.begin(start_ns)?;
        self.pace.resume(Instant::now());
        Ok(())
    }
}
