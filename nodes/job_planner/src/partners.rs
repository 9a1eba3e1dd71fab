//! Looks after the interpolator while a job runs: one that falls silent, or is started again, has ended the job.

use super::lock;
use camwright_ros::Guid;
use camwright_threads::silence::Silence;
use std::sync::Mutex;
use std::time::Duration;

/// The interpolator as it was received last.
#[derive(Debug, Clone, Copy)]
struct LastContact {
    participant: [u8; 12],
    silence: Silence,
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
        *lock(&self.last_contact) = Some(LastContact { participant, silence: Silence::new(self.limit) });
    }

    /// The one that is there now.
    pub(super) fn identity(&self) -> Identity {
        Identity(lock(&self.last_contact).map(|last_contact| last_contact.participant))
    }

    /// Looks whether the one that a job has begun with is still there; why not, if it is not.
    pub(super) fn check(&self, begun: Identity) -> Result<(), String> {
        let mut last_contact = lock(&self.last_contact);
        let Some(last_contact) = last_contact.as_mut() else { return Ok(()) };
        // One look among several threads is enough, and each counts a bounded time.
        last_contact.silence.poll();
        if last_contact.silence.is_lost() {
            return Err(format!("the axis interpolator has been silent for {} s", last_contact.silence.limit_s()));
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
        assert_eq!(interpolator.check(nobody), Ok(()), "it has not been heard of yet");
        interpolator.receive([1; 16]);
        let first = interpolator.identity();
        assert_eq!(interpolator.check(first), Ok(()));
        let mut endpoint = [1; 16];
        endpoint[15] = 7;
        interpolator.receive(endpoint);
        assert_eq!(interpolator.check(first), Ok(()), "another endpoint of the same participant");
        interpolator.receive([2; 16]);
        assert!(interpolator.check(first).expect_err("another participant").contains("started again"));
    }
}
