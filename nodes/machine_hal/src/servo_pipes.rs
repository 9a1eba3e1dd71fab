// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Pipes to `halstreamer` and from `halsampler`: one setpoint for every sample.

use crate::sample::{PinScale, ServoSample};
use camwright::machine::description::{AXIS_COUNT, MachineDescription};
use camwright::simulation::measured::{DriveOrders, Measurement};
use camwright_files::hal_file::HalConfig;
use camwright_machine_cycle::servo_bus::{BusPeriod, ServoBus};
use camwright_ros::Node;
use camwright_ros::running::NodeError;
use camwright_threads::ring::{Receiver, Waker, ring};
use std::io::{BufRead as _, BufReader, BufWriter, Write as _};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

/// Samples that may wait for the cyclic thread.
const RING: usize = 8192;
/// Time for which the axes stand still before the start.
const QUIET: Duration = Duration::from_millis(100);
/// Longest wait for the first samples.
const FIRST_SAMPLES: Duration = Duration::from_secs(5);

/// A process that ends with its owner.
#[derive(Debug)]
struct HalProcess(Child);

impl HalProcess {
    fn start(command: &mut Command) -> Result<Self, NodeError> {
        let name = command.get_program().to_string_lossy().into_owned();
        let child = command.spawn().map_err(|error| {
            NodeError::Parameter(format!("{name} does not start: {error}; install the package linuxcnc-uspace"))
        })?;
        Ok(Self(child))
    }

    fn has_ended(&mut self) -> bool {
        self.0.try_wait().is_ok_and(|status| status.is_some())
    }
}

impl Drop for HalProcess {
    fn drop(&mut self) {
        let _has_ended_already = self.0.kill();
        let _status = self.0.wait();
    }
}

/// Old samples that waited in HAL when the node started: they come faster than HAL's clock, and are not the present.
#[derive(Debug)]
struct Backlog {
    since: Instant,
    samples: u64,
    is_over: bool,
}

impl Backlog {
    /// A sample has come.
    fn see(&mut self, now: Instant, quiet_periods: u64) {
        self.samples += 1;
        if now.duration_since(self.since) >= QUIET {
            *self = Self { since: now, samples: 0, is_over: self.samples <= quiet_periods + quiet_periods / 2 };
        }
    }
}

/// Agreement of the setpoints that are sent with the samples that come.
#[derive(Debug, Clone, Copy, PartialEq)]
enum QueueState {
    /// The queue of HAL is empty; it is filled once the newest sample has come.
    Empty,
    /// It is filled; the setpoint with this number is the first of it.
    Filled(u32),
    /// Each sample shows the next setpoint, and one more is sent for it.
    Following,
}

/// The two programs of LinuxCNC between this machine and HAL.
#[derive(Debug)]
pub(crate) struct ServoPipes {
    streamer: HalProcess,
    sampler: HalProcess,
    orders: BufWriter<ChildStdin>,
    samples: Receiver<Result<ServoSample, String>>,
    scale: PinScale,
    /// Number of the setpoint that was sent last.
    sequence: u32,
    last: Option<ServoSample>,
    link: QueueState,
    /// Orders of the last tick, sent or not.
    last_orders: DriveOrders,
    /// When the last sample was taken.
    taken: Instant,
    fifo_ticks: u32,
    /// Time in which the queue of HAL runs empty.
    fifo_time: Duration,
    line: String,
    failure: Option<String>,
}

impl ServoPipes {
    /// Starts both programs and waits until the axes rest.
    ///
    /// # Errors
    /// Programs that do not start, samples that do not come, axes that move.
    pub(crate) fn open(
        node: &Node,
        hal: &HalConfig,
        machine: &MachineDescription,
        waker: &Waker,
    ) -> Result<(Self, Measurement), NodeError> {
        let scale = PinScale::new(hal, machine);
        // Through a pipe, halsampler would print 4 kB at a time: a tenth of a second.
        let mut sampler = HalProcess::start(
            Command::new("stdbuf").args(["-oL", "halsampler", "-t"]).stdin(Stdio::null()).stdout(Stdio::piped()),
        )?;
        let mut streamer = HalProcess::start(Command::new("halstreamer").stdin(Stdio::piped()).stdout(Stdio::null()))?;
        let (Some(output), Some(input)) = (sampler.0.stdout.take(), streamer.0.stdin.take()) else {
            return Err(NodeError::Parameter("the pipes of halsampler and halstreamer are missing".to_owned()));
        };
        let (mut sender, samples) = ring(RING, waker);
        let _reader = node.supervisor().spawn("HAL samples", move || {
            for line in BufReader::new(output).lines() {
                // The numbers of the periods show what is missing; what was lost before the start is not.
                if line.as_ref().is_ok_and(|line| line.trim() == "overrun") {
                    continue;
                }
                let sample = line.map_err(|error| error.to_string()).and_then(|line| scale.read(&line));
                let is_last = sample.is_err();
                // A full ring means that the cyclic thread has ended.
                if sender.send(sample).is_err() || is_last {
                    return;
                }
            }
            let _ended = sender.send(Err("halsampler has ended".to_owned()));
        })?;
        let mut pipes = Self {
            streamer,
            sampler,
            orders: BufWriter::new(input),
            samples,
            scale,
            sequence: 0,
            last: None,
            link: QueueState::Empty,
            last_orders: DriveOrders::default(),
            taken: Instant::now(),
            fifo_ticks: hal.fifo_ticks,
            fifo_time: Duration::from_nanos(u64::from(machine.cycle_time_ns) * u64::from(hal.fifo_ticks)),
            line: String::new(),
            failure: None,
        };
        let at_rest = pipes.wait_for_rest(hal.rest_window_counts, machine, waker)?;
        pipes.sequence = at_rest.sequence;
        let positions = core::array::from_fn(|i| at_rest.measurement.counts[i] as f64);
        pipes.last_orders = DriveOrders { positions, ..DriveOrders::default() };
        pipes.last = Some(at_rest);
        Ok((pipes, at_rest.measurement))
    }

    /// Fills the empty queue of HAL with the orders of the axes at rest.
    fn fill(&mut self) {
        self.link = QueueState::Filled(self.sequence.wrapping_add(1));
        for _ in 0..self.fifo_ticks {
            self.write();
        }
    }

    /// Sends the last orders.
    fn write(&mut self) {
        self.sequence = self.sequence.wrapping_add(1);
        self.scale.write(self.sequence, &self.last_orders, &mut self.line);
        let sent = self.orders.write_all(self.line.as_bytes()).and_then(|()| self.orders.flush());
        if let Err(error) = sent {
            self.failure = Some(format!("halstreamer takes no setpoints: {error}"));
        }
    }

    /// Compares a sample with the one before it. Returns whether setpoints were missing.
    fn compare(&mut self, sample: &ServoSample, last: &ServoSample) -> bool {
        match self.link {
            QueueState::Following => {
                // A pause longer than the queue: whatever the samples that wait show, the drives have stopped meanwhile.
                let is_late = self.taken.elapsed() > self.fifo_time;
                let is_starved = is_late || sample.sequence != last.sequence.wrapping_add(1);
                if is_starved {
                    self.link = QueueState::Empty;
                }
                is_starved
            }
            QueueState::Empty if self.samples.is_empty() && sample.queued == 0 => {
                self.fill();
                false
            }
            QueueState::Filled(first) if sample.sequence == first => {
                self.link = QueueState::Following;
                false
            }
            QueueState::Empty | QueueState::Filled(_) => false,
        }
    }

    /// The newest sample, once the axes have stood still for a while.
    fn wait_for_rest(
        &mut self,
        window_counts: f64,
        machine: &MachineDescription,
        waker: &Waker,
    ) -> Result<ServoSample, NodeError> {
        let refuse = |reason: String| Err(NodeError::Parameter(reason));
        let quiet_periods = u64::from(QUIET.subsec_nanos() / machine.cycle_time_ns);
        let begun = Instant::now();
        let mut backlog = Backlog { since: begun, samples: 0, is_over: false };
        waker.adopt_current_thread();
        let (mut first, mut quiet): (Option<ServoSample>, u64) = (None, 0);
        while begun.elapsed() < FIRST_SAMPLES {
            match self.samples.receive() {
                Some(Ok(sample)) => {
                    backlog.see(Instant::now(), quiet_periods);
                    let is_near = |before: &ServoSample| {
                        (0..AXIS_COUNT).all(|i| {
                            let moved = sample.measurement.counts[i].abs_diff(before.measurement.counts[i]);
                            moved as f64 <= window_counts
                        })
                    };
                    quiet = if first.as_ref().is_some_and(is_near) { quiet + 1 } else { 0 };
                    first = if quiet == 0 { Some(sample) } else { first };
                    let is_quiet = quiet >= quiet_periods && sample.queued == 0;
                    if is_quiet && backlog.is_over && self.samples.is_empty() {
                        return Ok(sample);
                    }
                }
                Some(Err(reason)) => return refuse(reason),
                None => {
                    let _woken = waker.wait(FIRST_SAMPLES);
                }
            }
        }
        match first {
            None => refuse(format!("no sample from HAL within {} s: is its thread started?", FIRST_SAMPLES.as_secs())),
            Some(_) => refuse(
                "the axes move, or setpoints of another program wait in HAL: the node starts only at rest".to_owned(),
            ),
        }
    }
}

impl ServoBus for ServoPipes {
    fn name(&self) -> &'static str {
        "hal"
    }

    fn queue_ticks(&self) -> u32 {
        self.fifo_ticks
    }

    fn next_period(&mut self) -> Result<Option<BusPeriod>, String> {
        if let Some(reason) = self.failure.take() {
            return Err(reason);
        }
        let sample = match self.samples.receive() {
            Some(sample) => sample?,
            None if self.sampler.has_ended() => return Err("halsampler has ended".to_owned()),
            None if self.streamer.has_ended() => return Err("halstreamer has ended".to_owned()),
            None => return Ok(None),
        };
        let last = self.last.replace(sample).unwrap_or(sample);
        let missing = sample.period.wrapping_sub(last.period).saturating_sub(1);
        if missing > 0 {
            return Err(format!("{missing} samples of HAL are missing: this program was stopped for too long"));
        }
        let is_starved = self.compare(&sample, &last);
        self.taken = Instant::now();
        Ok(Some(BusPeriod {
            measurement: sample.measurement,
            is_estop: sample.is_estop,
            drive_faults: sample.drive_faults,
            is_starved,
            is_following: self.link == QueueState::Following,
            queued: sample.queued,
            jitter_ns: sample.jitter_ns,
        }))
    }

    fn send(&mut self, orders: &DriveOrders) {
        self.last_orders = *orders;
        if self.link == QueueState::Following {
            self.write();
        }
    }
}
