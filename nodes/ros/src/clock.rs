//! ROS time: the system clock, or the times that `/clock` reports.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};

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

    /// Switches between simulated time and the system clock.
    pub(super) fn simulate(&self, simulated: bool) {
        self.simulated.store(simulated, Ordering::Release);
    }

    /// Sets the simulated time.
    pub(super) fn set_simulated(&self, ns: i64) {
        self.simulated_ns.store(ns, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nanoseconds_and_messages_are_the_same_time() {
        for ns in [0, 1, NS_PER_S - 1, NS_PER_S, 1_790_000_000_123_456_789, -1, -NS_PER_S] {
            assert_eq!(from_time(&to_time(ns)), ns);
            assert!(to_time(ns).nanosec < 1_000_000_000);
        }
    }
}
