//! ROS time: the system clock, or `/clock` when `use_sim_time` is set.
//!
//! The crate below reads `/clock` as `builtin_interfaces/msg/Time`, which no ROS 2 publisher sends; this reads
//! `rosgraph_msgs/msg/Clock`.

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicBool, AtomicI64, Ordering},
};

use camwright_msgs::{builtin_interfaces::msg::Time, rosgraph_msgs::msg::Clock};

use super::error::RosError;
use super::node::Node;
use super::parameter_value::ParameterValue;
use super::qos::Qos;
use super::topics::Subscription;
use camwright_threads::system_time::system_time_ns;

/// Name of the parameter every node has.
pub(super) const USE_SIM_TIME: &str = "use_sim_time";

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

#[derive(Default)]
struct State {
    simulated: AtomicBool,
    clock_ns: AtomicI64,
    subscription: Mutex<Option<Subscription>>,
}

/// Time source of a node.
pub(super) struct TimeSource {
    state: Arc<State>,
}

impl TimeSource {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        let source = TimeSource { state: Arc::default() };
        let parameters = node.parameters();
        source.state.follow(node, parameters.bool(USE_SIM_TIME))?;
        let (state, weak) = (Arc::downgrade(&source.state), node.downgrade());
        parameters.on_change(move |changes| {
            for (name, value) in changes {
                if let (USE_SIM_TIME, ParameterValue::Bool(simulated)) = (name.as_str(), value)
                    && let (Some(state), Some(node)) = (state.upgrade(), weak.upgrade())
                    && let Err(error) = state.follow(&node, *simulated)
                {
                    node.logger().warn(&error.to_string());
                }
            }
        });
        Ok(source)
    }

    pub(super) fn now_ns(&self) -> i64 {
        if self.state.simulated.load(Ordering::Acquire) {
            self.state.clock_ns.load(Ordering::Acquire)
        } else {
            system_time_ns()
        }
    }
}

impl State {
    fn follow(self: &Arc<Self>, node: &Node, simulated: bool) -> Result<(), RosError> {
        let mut subscription = self.subscription.lock().unwrap_or_else(PoisonError::into_inner);
        if simulated && subscription.is_none() {
            let state = Arc::downgrade(self);
            let name = node.resolve_topic("/clock")?;
            *subscription = Some(node.reader(
                &name,
                super::names::dds_topic(&name),
                <Clock as camwright_msgs::Message>::DDS_TYPE_NAME,
                &Qos::clock(),
                false,
                move |message: Clock, _| {
                    if let Some(state) = state.upgrade() {
                        state.clock_ns.store(from_time(&message.clock), Ordering::Release);
                    }
                },
            )?);
        } else if !simulated {
            *subscription = None;
        }
        self.simulated.store(simulated, Ordering::Release);
        Ok(())
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
