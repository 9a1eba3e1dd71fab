// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge readings during a measured job, and the pushes of a stopped wheel for its stiffness.

use super::{lock, wait_for};
use camwright::planner::JournalReadings;
use camwright_files::convert::gauge;
use camwright_msgs::camwright_msgs::msg::GaugeReading;
use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex};
use std::time::Duration;

/// Tolerance of an angle after its conversion in a message (rad).
const SAME_RAD: f64 = 1e-9;

/// Readings by lobe, while they are wanted.
#[derive(Debug, Default)]
pub(super) struct Gaugings {
    collected: Mutex<CollectedGaugings>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct CollectedGaugings {
    wanted: bool,
    /// Angles of the machine's gauges behind the wheel (rad).
    gauge_angle: f64,
    second_angle: Option<f64>,
    lobes: BTreeMap<String, JournalReadings>,
}

impl Gaugings {
    /// Forgets everything and listens from now on to the gauge, or the two, at these angles behind the wheel (rad).
    pub(super) fn listen(&self, gauge_angle: f64, second_angle: Option<f64>) {
        *lock(&self.collected) = CollectedGaugings { wanted: true, gauge_angle, second_angle, lobes: BTreeMap::new() };
    }

    /// Forgets everything and listens no more.
    pub(super) fn stop(&self) {
        *lock(&self.collected) = CollectedGaugings::default();
    }

    pub(super) fn add(&self, reading: &GaugeReading) {
        let mut collected = lock(&self.collected);
        let is_at = |angle: f64| (reading.gauge_angle - angle).abs() <= SAME_RAD;
        let (first, second) = (is_at(collected.gauge_angle), collected.second_angle.is_some_and(is_at));
        if !collected.wanted || !(first || second) {
            return;
        }
        gauge::log(collected.lobes.entry(reading.lobe.clone()).or_default(), reading, !first);
        drop(collected);
        self.changed.notify_all();
    }

    /// Waits until every named lobe has been read, by all gauges, up to an angle of C (rad); else the first that has not after the timeout.
    pub(super) fn wait<'a>(
        &self,
        lobes: &[(&'a str, f64)],
        timeout: Duration,
    ) -> Result<Vec<JournalReadings>, &'a str> {
        wait_for(&self.collected, &self.changed, timeout, |collected| {
            let two = collected.second_angle.is_some();
            let is_read = |name: &str, until_rad: f64| {
                let last = collected.lobes.get(name).and_then(|log| log.gauged.last());
                last.is_some_and(|last| last.c_rad >= until_rad && (!two || last.second_mm.is_some()))
            };
            match lobes.iter().find(|(name, until_rad)| !is_read(name, *until_rad)) {
                Some((missing, _)) => Err(*missing),
                None => Ok(lobes.iter().map(|(name, _)| collected.lobes.remove(*name).unwrap_or_default()).collect()),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_requested_gauge_is_collected_until_the_part_rests() {
        let gaugings = Gaugings::default();
        let reading = |tick: u64, spindle_angle: f64, gauge_angle: f64| GaugeReading {
            tick,
            lobe: "J1".into(),
            spindle_angle,
            gauge_angle,
            ..GaugeReading::default()
        };
        let wait = |until_rad: f64| gaugings.wait(&[("J1", until_rad)], Duration::from_millis(1));
        gaugings.add(&reading(1, 9.0, 1.0));
        assert_eq!(wait(1.0), Err("J1"), "nobody wanted it");
        gaugings.listen(1.0, None);
        gaugings.add(&reading(2, 1.0, 1.0));
        gaugings.add(&reading(2, 5.0, 2.0));
        assert_eq!(wait(2.0), Err("J1"));
        gaugings.add(&reading(3, 2.5, 1.0));
        assert_eq!(wait(2.0).map(|logs| logs[0].gauged.len()), Ok(2));
        gaugings.listen(1.0, Some(2.0));
        gaugings.add(&reading(4, 9.0, 1.0));
        assert_eq!(wait(9.0), Err("J1"), "the second has not read it yet");
        gaugings.add(&reading(4, 9.0, 2.0));
        assert_eq!(wait(9.0).map(|logs| logs[0].gauged[0].second_mm.is_some()), Ok(true));
        gaugings.stop();
        gaugings.add(&reading(4, 9.0, 1.0));
        assert_eq!(wait(0.0), Err("J1"));
    }
}
