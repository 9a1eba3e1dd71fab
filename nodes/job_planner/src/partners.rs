//! Looks after the interpolator while a job runs: one that falls silent, or is started again, has ended the job.

use super::lock;
use camwright_ros::Guid;
use camwright_threads::silence::Silence;
use std::sync::Mutex;
use std::time::Duration;

/// The interpolator as it was heard last.
#[derive(Debug, Clone, Copy)]
struct LastContact {
    participant: [u8; 12],
    silence: Silence,
}

/// Who executes the planner's plans.
#[derive(Debug)]
pub(super) struct Interpolator {
    limit: Duration,
    heard: Mutex<Option<LastContact>>,
}

/// The interpolator that a job has begun with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Identity(Option<[u8; 12]>);

impl Interpolator {
    pub(super) fn new(limit: Duration) -> Self {
        Self { limit, heard: Mutex::default() }
    }

    /// Records a message of the partner.
    pub(super) fn receive(&self, writer: Guid) {
        let mut participant = [0; 12];
        participant.copy_from_slice(&writer[..12]);
        *lock(&self.heard) = Some(LastContact { participant, silence: Silence::new(self.limit) });
    }

    /// The one that is there now.
    pub(super) fn identity(&self) -> Identity {
        Identity(lock(&self.heard).map(|heard| heard.participant))
    }

    /// Looks whether the one that a job has begun with is still there; why not, if it is not.
    pub(super) fn look(&self, begun: Identity) -> Result<(), String> {
        let mut heard = lock(&self.heard);
        let Some(heard) = heard.as_mut() else { return Ok(()) };
        // One look among several threads is enough, and each counts a bounded time.
        heard.silence.look();
        if heard.silence.is_lost() {
            return Err(format!("the axis interpolator has been silent for {} s", heard.silence.limit_s()));
        }
        match begun.0 {
            Some(participant) if participant != heard.participant => {
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
        let interpolator = Interpolator::new(Duration::from_secs(1));
        let nobody = interpolator.identity();
        assert_eq!(interpolator.look(nobody), Ok(()), "it has not been heard of yet");
        interpolator.receive([1; 16]);
        let first = interpolator.identity();
        assert_eq!(interpolator.look(first), Ok(()));
        let mut endpoint = [1; 16];
        endpoint[15] = 7;
        interpolator.receive(endpoint);
        assert_eq!(interpolator.look(first), Ok(()), "another endpoint of the same participant");
        interpolator.receive([2; 16]);
        assert!(interpolator.look(first).expect_err("another participant").contains("started again"));
    }
}
