// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Looks after the interpolator while a job runs: one that falls silent, or is started again, has ended the job.
//!
//! An interpolator that died makes the machine raise an alarm. Without one, the connection may be lost while the axes move: then the planner
//! waits longer than the interpolator waits for it, so that the plan is cancelled on both sides or on none.

use super::lock;
use camwright_ros::Guid;
use camwright_threads::silence::Silence;
use std::sync::Mutex;
use std::time::Duration;

/// Topic of its messages.
const STATE: &str = "axis_interpolator/state";
/// Additional time for the cancellation of the interpolator to arrive.
const ARRIVAL: Duration = Duration::from_secs(1);

/// The interpolator as it was received last.
#[derive(Debug, Clone, Copy)]
struct LastContact {
    participant: [u8; 12],
    silence: Silence,
    /// Silence after which the interpolator has cancelled a plan of a planner that it does not receive.
    separation: Silence,
}

/// Who executes the planner's plans.
#[derive(Debug)]
pub(super) struct InterpolatorPartner {
    limit: Duration,
    last_contact: Mutex<Option<LastContact>>,
}

/// The interpolator that a job has begun with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Identity(Option<[u8; 12]>);

impl InterpolatorPartner {
    pub(super) fn new(limit: Duration) -> Self {
        Self { limit, last_contact: Mutex::default() }
    }

    /// Records a message of the partner.
    pub(super) fn receive(&self, writer: Guid) {
        let mut participant = [0; 12];
        participant.copy_from_slice(&writer[..12]);
        let (silence, separation) = (Silence::new(self.limit), Silence::new(2 * self.limit + ARRIVAL));
        *lock(&self.last_contact) = Some(LastContact { participant, silence, separation });
    }

    /// The one that is there now.
    pub(super) fn identity(&self) -> Identity {
        Identity(lock(&self.last_contact).map(|last_contact| last_contact.participant))
    }

    /// Looks whether the one that a job has begun with is still there; why not, if it is not. `is_stopped`: the machine reports an alarm.
    pub(super) fn check(&self, begun: Identity, is_stopped: bool) -> Result<(), String> {
        let mut last_contact = lock(&self.last_contact);
        let Some(last_contact) = last_contact.as_mut() else { return Ok(()) };
        // One look among several threads is enough, and each counts a bounded time.
        last_contact.silence.poll();
        last_contact.separation.poll();
        let silence = if is_stopped { last_contact.silence } else { last_contact.separation };
        if silence.is_lost() {
            let limit_s = silence.limit_s();
            return Err(format!(
                "no message from the axis interpolator on {STATE} for {limit_s} s: its node or the network is lost"
            ));
        }
        match begun.0 {
            Some(participant) if participant != last_contact.participant => {
                Err("the axis interpolator was started again".to_owned())
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_interpolator_is_not_the_one_that_a_job_has_begun_with() {
        let interpolator = InterpolatorPartner::new(Duration::from_secs(1));
        let nobody = interpolator.identity();
        assert_eq!(interpolator.check(nobody, false), Ok(()), "it has not been heard of yet");
        interpolator.receive([1; 16]);
        let first = interpolator.identity();
        assert_eq!(interpolator.check(first, false), Ok(()));
        let mut endpoint = [1; 16];
        endpoint[15] = 7;
        interpolator.receive(endpoint);
        assert_eq!(interpolator.check(first, false), Ok(()), "another endpoint of the same participant");
        interpolator.receive([2; 16]);
        assert!(interpolator.check(first, false).expect_err("another participant").contains("started again"));
    }
    /// The interpolator cancels a plan after twice the limit; before, a planner that hears nothing does not give up.
    #[test]
    fn a_lost_connection_lasts_longer_than_the_patience_of_the_interpolator() {
        let limit = Duration::from_millis(100);
        let interpolator = InterpolatorPartner::new(limit);
        interpolator.receive([1; 16]);
        let begun = interpolator.identity();
        let mut now = lock(&interpolator.last_contact).expect("received").silence;
        let begin = std::time::Instant::now();
        while !now.check(std::time::Instant::now()) {
            assert_eq!(interpolator.check(begun, false), Ok(()));
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(interpolator.check(begun, true).expect_err("the machine has stopped").contains("for 0.1 s"));
        assert_eq!(interpolator.check(begun, false), Ok(()), "the connection may come back");
        let reason = loop {
            match interpolator.check(begun, false) {
                Ok(()) => std::thread::sleep(Duration::from_millis(5)),
                Err(reason) => break reason,
            }
        };
        assert!(begin.elapsed() > 2 * limit + ARRIVAL, "{:?}", begin.elapsed());
        assert!(
            reason.starts_with("no message from the axis interpolator on axis_interpolator/state for 1.2 s"),
            "{reason}"
        );
    }
}
