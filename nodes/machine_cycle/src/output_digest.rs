// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The digest of what a machine puts out, tick by tick: two runs that are the same have the same digests.
//!
//! A job begins it anew and counts ticks from its own first, so that the digests of a job do not depend on when it was started.

use super::stream_state::StreamState;
use camwright::machine::setpoint::{Input, Setpoint};
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::setpoints::ChunkBuffer;
use camwright_files::digest::Digest;

/// Ticks between two published digests: one second at 1 ms.
const PERIOD_TICKS: u64 = 1000;

/// Published digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RangeDigest {
    /// The last tick in it.
    pub tick: u64,
    /// Ticks of the job in it; 0 where no job runs.
    pub job_ticks: u64,
    pub digest: u64,
}

/// The digest of the ticks so far, of the job or, where none runs, since the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OutputDigest {
    digest: Digest,
    /// First tick of the job; 0 where none runs.
    job_tick: u64,
}

impl OutputDigest {
    /// Adds a tick. Published are a job's first digest, its last when it is over, and that of every second.
    pub fn add(&mut self, report: &TickReport, state: &StreamState) -> [Option<RangeDigest>; 2] {
        let mut over = None;
        if state.job_tick != self.job_tick {
            if self.job_tick != 0 {
                over = Some(self.range_digest(report.tick - 1));
            }
            *self = Self { digest: Digest::default(), job_tick: state.job_tick };
        }
        self.add_report(report);
        let digest = self.range_digest(report.tick);
        let count = if digest.job_ticks > 0 { digest.job_ticks } else { digest.tick };
        let is_due = count.is_multiple_of(PERIOD_TICKS) || digest.job_ticks == 1;
        [over, is_due.then_some(digest)]
    }

    /// The digest that goes on from a keyframe: its value, and the first tick of the job, 0 where none runs.
    pub const fn from(value: u64, job_tick: u64) -> Self {
        Self { digest: Digest::from_value(value), job_tick }
    }

    /// Its value, and the first tick of the job.
    pub const fn parts(&self) -> (u64, u64) {
        (self.digest.value(), self.job_tick)
    }

    fn range_digest(&self, tick: u64) -> RangeDigest {
        let job_ticks = if self.job_tick == 0 { 0 } else { tick + 1 - self.job_tick };
        RangeDigest { tick, job_ticks, digest: self.digest.value() }
    }

    /// Ticks are counted from the job's first, where there is one: also what an alarm says of its tick is the same in another run.
    fn relative(&self, tick: u64) -> u64 {
        tick.wrapping_sub(self.job_tick)
    }

    fn add_report(&mut self, report: &TickReport) {
        let digest = &mut self.digest;
        for axis in &report.axes {
            digest.word(axis.setpoint_counts.cast_unsigned());
            digest.word(axis.counts.cast_unsigned());
            for number in [axis.position, axis.velocity, axis.effort, axis.following_error] {
                digest.number(number);
            }
            digest.word(bits(&[axis.is_at_rest, axis.is_homed, axis.is_powered]));
        }
        let io = &report.io;
        digest.word(io.stations);
        digest.word(u64::from(io.others));
        let flags = [io.origin, io.overtravel_x_min, io.overtravel_x_max, io.overtravel_z_min, io.overtravel_z_max];
        digest.word(bits(&flags));
        digest.word(bits(&[io.estop, io.drives_on, io.wheel_running, io.part_present]));
        digest.word(report.motion as u64);
        digest.word(report.lobe.map_or(u64::MAX, |lobe| lobe as u64));
        for number in
            [report.removal.area_mm2, report.removal.depth_mm, report.turned.volume_mm3, report.turned.depth_mm]
        {
            digest.number(number);
        }
        digest.number(report.normal_force_n);
        digest.number(report.wheel_rad_s);
        for reading in report.gauge_mm {
            digest.word(u64::from(reading.is_some()));
            digest.number(reading.unwrap_or_default());
        }
        if let Some(area) = &report.work_area {
            digest.word(bits(&[area.part_present, area.entered, area.is_safe, area.hindrance.is_some()]));
            digest.word(area.door as u64);
            digest.word(area.chuck as u64);
        }
        self.add_events(report);
    }

    fn add_events(&mut self, report: &TickReport) {
        for latch in report.latches.iter() {
            let words = [self.relative(latch.tick), input_word(latch.input), u64::from(latch.rising)];
            words.into_iter().for_each(|word| self.digest.word(word));
            self.digest.word(latch.axis.index() as u64);
            self.digest.word(latch.counts.cast_unsigned());
        }
        for alarm in report.raised.iter() {
            self.digest.word(u64::from(alarm.kind.entry().number));
            let since = self.relative(alarm.tick);
            self.digest.word(since);
        }
    }
}

fn bits(flags: &[bool]) -> u64 {
    flags.iter().fold(0, |word, flag| word << 1 | u64::from(*flag))
}

fn input_word(input: Input) -> u64 {
    match input {
        Input::Origin => 0,
        Input::SteadyForce => 1,
        Input::WheelContact => 2,
        Input::KeyWay => 3,
        Input::SizeReached => 4,
        Input::Home(axis) => 10 + axis.index() as u64,
        Input::Index(axis) => 20 + axis.index() as u64,
        Input::Station(index) => 100 + index as u64,
    }
}

/// The digest of a chunk's points, by which the chunk that the machine took is found among those that were sent.
pub fn chunk_digest(chunk: &ChunkBuffer) -> u64 {
    let mut digest = Digest::default();
    let mut add = |setpoint: &Setpoint| {
        setpoint.counts.iter().for_each(|counts| digest.word(counts.cast_unsigned()));
        setpoint.velocity.iter().chain(&setpoint.acceleration).for_each(|number| digest.number(*number));
    };
    chunk.dense.iter().for_each(&mut add);
    chunk.tail.iter().for_each(|point| add(&point.setpoint));
    chunk.tail.iter().for_each(|point| digest.word(point.tick));
    for word in [chunk.first_tick, chunk.dense.len() as u64, chunk.tail.len() as u64, u64::from(chunk.is_final)] {
        digest.word(word);
    }
    digest.value()
}
