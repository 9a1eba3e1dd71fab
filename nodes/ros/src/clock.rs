// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! ROS time: the system clock, or the times that `/clock` reports.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::Instant;

use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_threads::system_time::system_time_ns;

const NS_PER_S: i64 = 1_000_000_000;

/// Splits ns since 1970 into a message. Times that a message cannot hold (after 2038) saturate.
pub fn to_time(ns: i64) -> Time {
    Time {
        sec: i32::try_from(ns.div_euclid(NS_PER_S)).unwrap_or(i32::MAX),
        nanosec: u32::try_from(ns.rem_euclid(NS_PER_S)).expect("a remainder of 1e9 fits 32 bits"),
    }
}

/// A message's time in ns.
pub fn from_time(time: &Time) -> i64 {
    i64::from(time.sec) * NS_PER_S + i64::from(time.nanosec)
}

/// Clock of a node.
#[derive(Debug, Default)]
pub(super) struct RosClock {
    simulated: AtomicBool,
    simulated_ns: AtomicI64,
}

impl RosClock {
    pub(super) fn now_ns(&self) -> i64 {
        if self.simulated.load(Ordering::Acquire) {
            self.simulated_ns.load(Ordering::Acquire)
        } else {
            system_time_ns()
        }
    }

    /// Simulated time, 0 before the first `/clock`; `None` while the system clock counts.
    fn simulated_ns(&self) -> Option<i64> {
        self.simulated.load(Ordering::Acquire).then(|| self.simulated_ns.load(Ordering::Acquire))
    }

    /// Switches between simulated time and the system clock.
    pub(super) fn simulate(&self, simulated: bool) {
        self.simulated.store(simulated, Ordering::Release);
    }

    /// Sets the simulated time.
    pub(super) fn set_simulated(&self, ns: i64) {
        self.simulated_ns.store(ns, Ordering::Release);
    }
}

/// Reading of the time that counts.
#[derive(Debug, Clone, Copy)]
enum Reading {
    /// Not the system clock, which can be set.
    Monotonic(Instant),
    Simulated(i64),
}

/// ROS time that has passed since its creation. It never decreases: a clock that is set back, the first `/clock` and a change of
/// `use_sim_time` add nothing.
#[derive(Debug)]
pub struct ElapsedTime {
    clock: Arc<RosClock>,
    last: Reading,
    elapsed_ns: i64,
}

impl ElapsedTime {
    pub(super) fn new(clock: &Arc<RosClock>) -> Self {
        let clock = Arc::clone(clock);
        Self { last: Self::read(&clock), clock, elapsed_ns: 0 }
    }

    fn read(clock: &RosClock) -> Reading {
        clock.simulated_ns().map_or_else(|| Reading::Monotonic(Instant::now()), Reading::Simulated)
    }

    /// The time that has passed (s).
    pub fn seconds(&mut self) -> f64 {
        let now = Self::read(&self.clock);
        let passed_ns = match (self.last, now) {
            (Reading::Monotonic(last), Reading::Monotonic(now)) => {
                i64::try_from(now.saturating_duration_since(last).as_nanos()).unwrap_or(i64::MAX)
            }
            (Reading::Simulated(last), Reading::Simulated(now)) if last != 0 => now.saturating_sub(last).max(0),
            _ => 0,
        };
        self.elapsed_ns = self.elapsed_ns.saturating_add(passed_ns);
        self.last = now;
        self.elapsed_ns as f64 / NS_PER_S as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elapsed_time_follows_the_simulated_clock_and_never_decreases() {
        let clock = Arc::<RosClock>::default();
        clock.simulate(true);
        let mut elapsed = ElapsedTime::new(&clock);
        let mut at = |ns: i64| {
            clock.set_simulated(ns);
            (elapsed.seconds() * 1000.0).round()
        };
        let begin = 1_790_000_000 * NS_PER_S;
        let times = [0, begin, begin + 2 * NS_PER_S, begin + NS_PER_S, begin + 4 * NS_PER_S].map(&mut at);
        assert_eq!(
            format!("{times:?}"),
            "[0.0, 0.0, 2000.0, 2000.0, 5000.0]",
            "the first clock and one that is set back add nothing"
        );
        clock.simulate(false);
        let switched = elapsed.seconds();
        assert!((switched - 5.0).abs() < 1e-12, "{switched}: the clock was changed");
        let later = Instant::now() + std::time::Duration::from_millis(5);
        while Instant::now() < later {
            std::hint::spin_loop();
        }
        assert!(elapsed.seconds() >= 5.005, "the system's time counts now");
    }

    #[test]
    fn nanoseconds_and_messages_are_the_same_time() {
        for ns in [0, 1, NS_PER_S - 1, NS_PER_S, 1_790_000_000_123_456_789, -1, -NS_PER_S] {
            assert_eq!(from_time(&to_time(ns)), ns);
            assert!(to_time(ns).nanosec < 1_000_000_000);
        }
    }
}
