// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Motion of the axes: the whole job in columns, and single turns tick by tick for figures.

use super::columns::Columns;
use super::error::ReportError;
use super::gather::RecordedRun;
use camwright::math::units::rpm_from_rad_s;
use camwright_bag::Bag;
use camwright_files::convert::time::ns_from_time;
use camwright_files::convert::{mm_from_m, setpoints};
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use std::collections::BTreeMap;

/// Columns of the figures over time.
const TIME_COLUMNS: usize = 480;

/// The axes at a tick, in the order C, X, Z (rad, m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MotionSample {
    pub(super) tick: u64,
    pub(super) position: [f64; 3],
    pub(super) velocity: [f64; 3],
    /// Motor of X, positive outwards (N).
    pub(super) force_x_n: f64,
}

/// Motion read from the ticks.
#[derive(Debug)]
pub(super) struct RecordedMotion {
    pub(super) samples: Vec<MotionSample>,
    /// Setpoints within the windows (rad, m).
    pub(super) setpoints: BTreeMap<u64, [f64; 3]>,
    /// Over the time since the job's first tick (s).
    pub(super) c_rpm: Columns,
    pub(super) x_mm: Columns,
    pub(super) z_mm: Columns,
    /// Ticks of the job, and how many of them have no sample.
    pub(super) ticks: u64,
    pub(super) missing: u64,
}

impl RecordedMotion {
    /// Reads the job's ticks; `windows` are first and last ticks of what is kept as it is.
    pub(super) fn from_recorded(
        bag: &Bag,
        recorded: &RecordedRun,
        job: (u64, u64),
        windows: &[(u64, u64)],
    ) -> Result<Option<Self>, ReportError> {
        let Some((clock, cycle_s)) = recorded.clock.zip(recorded.cycle_s()) else { return Ok(None) };
        let seconds = |ticks: u64| ticks as f64 * cycle_s;
        let columns = || Columns::new(0.0, seconds(job.1 - job.0).max(cycle_s), TIME_COLUMNS);
        let mut motion = Self {
            samples: Vec::new(),
            setpoints: BTreeMap::new(),
            c_rpm: columns(),
            x_mm: columns(),
            z_mm: columns(),
            ticks: job.1 - job.0 + 1,
            missing: 0,
        };
        let [states, chunks] = ["joint_states", "machine/setpoints"].map(|name| format!("{}{name}", recorded.prefix));
        let is = |index: usize, name: &str| bag.topics().get(index).is_some_and(|topic| topic.name == name);
        let is_kept = |tick: u64| windows.iter().any(|(from, to)| (*from..=*to).contains(&tick));
        let (mut seen, mut newest) = (0, None);
        let mut messages = bag.messages();
        while let Some(message) = messages.next_message()? {
            if is(message.topic, &states) {
                let Some((stamp, mut sample)) = sample(&message.data) else { continue };
                let Some(tick) = clock.nearest_tick(stamp).filter(|tick| (job.0..=job.1).contains(tick)) else {
                    continue;
                };
                sample.tick = tick;
                seen += u64::from(newest.is_none_or(|newest| tick > newest));
                newest = newest.max(Some(tick));
                let at_s = seconds(tick - job.0);
                motion.c_rpm.add(at_s, rpm_from_rad_s(sample.velocity[0]));
                motion.x_mm.add(at_s, mm_from_m(sample.position[1]));
                motion.z_mm.add(at_s, mm_from_m(sample.position[2]));
                if is_kept(tick) {
                    motion.samples.push(sample);
                }
            } else if is(message.topic, &chunks)
                && let Ok(chunk) = message_from_sample::<JointTrajectory>(&message.data)
                && chunk.joint_names == setpoints::joint_names()
            {
                let start_ns = ns_from_time(&chunk.header.stamp);
                for point in &chunk.points {
                    let ns = start_ns
                        .saturating_add(camwright_files::convert::time::ns_from_duration(&point.time_from_start));
                    if let (Some(tick), &[c, x, z]) = (clock.nearest_tick(ns), point.positions.as_slice())
                        && is_kept(tick)
                    {
                        // A chunk replaces what the one before said of its ticks.
                        motion.setpoints.insert(tick, [c, x, z]);
                    }
                }
            }
        }
        motion.missing = motion.ticks.saturating_sub(seen);
        motion.samples.sort_by_key(|sample| sample.tick);
        Ok((seen > 0).then_some(motion))
    }

    /// Some ticks and nothing else.
    #[cfg(test)]
    pub(super) fn made_of(samples: &[MotionSample], setpoints: BTreeMap<u64, [f64; 3]>) -> Self {
        let columns = || Columns::new(0.0, 2.0, 10);
        Self {
            samples: samples.to_vec(),
            setpoints,
            c_rpm: columns(),
            x_mm: columns(),
            z_mm: columns(),
            ticks: samples.len() as u64,
            missing: 0,
        }
    }

    /// The samples of some ticks.
    pub(super) fn within(&self, (from, to): (u64, u64)) -> &[MotionSample] {
        let start = self.samples.partition_point(|sample| sample.tick < from);
        let end = self.samples.partition_point(|sample| sample.tick <= to);
        &self.samples[start..end.max(start)]
    }

    /// The last whole turn of C within some ticks.
    pub(super) fn last_turn(&self, within: (u64, u64)) -> &[MotionSample] {
        let samples = self.within(within);
        let Some(last) = samples.last() else { return samples };
        let turn = camwright::math::units::TURN_RAD;
        let start = samples.iter().rposition(|sample| (last.position[0] - sample.position[0]).abs() > turn);
        &samples[start.unwrap_or(0)..]
    }
}

/// A sample and its stamp (ns), with the joints where a machine of ours has them.
fn sample(data: &[u8]) -> Option<(i64, MotionSample)> {
    let state: JointState = message_from_sample(data).ok()?;
    let at = |joint: &str| state.name.iter().position(|name| name == joint);
    let places = [at("c_axis")?, at("x_axis")?, at("z_axis")?];
    let of = |values: &[f64]| {
        let mut found = [0.0; 3];
        for (value, place) in found.iter_mut().zip(places) {
            *value = *values.get(place)?;
        }
        Some(found)
    };
    let sample = MotionSample {
        tick: 0,
        position: of(&state.position)?,
        velocity: of(&state.velocity)?,
        force_x_n: of(&state.effort).map_or(f64::NAN, |effort| effort[1]),
    };
    Some((ns_from_time(&state.header.stamp), sample))
}
