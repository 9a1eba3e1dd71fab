// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Ticks as stamps: stamp = epoch + tick · cycle time, in integers.

use camwright_msgs::builtin_interfaces::msg::{Duration, Time};

/// Nanoseconds since the epoch of ROS time.
#[must_use]
pub fn ns_from_time(time: &Time) -> i64 {
    i64::from(time.sec) * 1_000_000_000 + i64::from(time.nanosec)
}

/// A stamp; times beyond 2038 keep their nanoseconds and saturate in seconds, as the 32-bit field demands.
#[must_use]
pub fn time_from_ns(ns: i64) -> Time {
    let sec = ns.div_euclid(1_000_000_000);
    Time {
        sec: i32::try_from(sec).unwrap_or(if sec < 0 { i32::MIN } else { i32::MAX }),
        nanosec: u32::try_from(ns.rem_euclid(1_000_000_000)).unwrap_or(0),
    }
}

#[must_use]
pub fn duration_from_ns(ns: i64) -> Duration {
    let time = time_from_ns(ns);
    Duration { sec: time.sec, nanosec: time.nanosec }
}

/// Nanoseconds of a duration.
#[must_use]
pub fn ns_from_duration(duration: &Duration) -> i64 {
    i64::from(duration.sec) * 1_000_000_000 + i64::from(duration.nanosec)
}

/// The clock of a machine: where its tick 0 lies and how long a tick is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TickClock {
    /// Time of tick 0 (ns).
    pub epoch_ns: i64,
    /// Interpolation period (ns).
    pub cycle_time_ns: u32,
}

impl TickClock {
    /// Time of a tick (ns).
    #[must_use]
    pub fn ns(self, tick: u64) -> i64 {
        let ticks = i64::try_from(tick).unwrap_or(i64::MAX);
        self.epoch_ns.saturating_add(ticks.saturating_mul(i64::from(self.cycle_time_ns)))
    }

    /// Stamp of a tick.
    #[must_use]
    pub fn stamp(self, tick: u64) -> Time {
        time_from_ns(self.ns(tick))
    }

    /// The tick nearest to a time (ns); `None` for a time before the epoch.
    #[must_use]
    pub fn nearest_tick(self, ns: i64) -> Option<u64> {
        let cycle = i64::from(self.cycle_time_ns);
        let since = ns.checked_sub(self.epoch_ns)?.checked_add(cycle / 2)?;
        u64::try_from(since.checked_div(cycle)?).ok()
    }

    /// The tick whose stamp this is; `None` for a stamp before the epoch or between two ticks.
    #[must_use]
    pub fn tick(self, stamp: &Time) -> Option<u64> {
        let since = ns_from_time(stamp).checked_sub(self.epoch_ns)?;
        let cycle = i64::from(self.cycle_time_ns);
        if cycle == 0 || since.rem_euclid(cycle) != 0 {
            return None;
        }
        u64::try_from(since / cycle).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_is_its_tick() {
        let clock = TickClock { epoch_ns: 1_795_000_000_123_456_789, cycle_time_ns: 1_000_000 };
        for tick in [0, 1, 999, 1_000, 123_456_789] {
            assert_eq!(clock.tick(&clock.stamp(tick)), Some(tick));
        }
        assert_eq!(clock.tick(&time_from_ns(clock.epoch_ns + 500)), None, "between two ticks");
        assert_eq!(clock.tick(&time_from_ns(clock.epoch_ns - 1_000_000)), None, "before the epoch");
    }
}
