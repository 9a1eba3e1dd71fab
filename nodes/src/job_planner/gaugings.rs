//! What the gauge reads while a job runs whose runout is corrected, and how a stopped wheel pushes where its stiffness is measured.

use super::lock;
use camwright::cycle::Contact;
use camwright_msgs::camwright_msgs::msg::GaugeReading;
use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Readings by lobe, while they are wanted.
#[derive(Debug, Default)]
pub(super) struct Gaugings {
    heard: Mutex<Heard>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Heard {
    wanted: bool,
    /// Angle of the machine's first gauge behind the wheel (rad); a second one is not listened to.
    gauge_angle: f64,
    lobes: BTreeMap<String, Contact>,
}

impl Gaugings {
    /// Forgets everything and listens to the gauge at an angle behind the wheel (rad) from now on.
    pub(super) fn listen(&self, gauge_angle: f64) {
        *lock(&self.heard) = Heard { wanted: true, gauge_angle, ..Heard::default() };
    }

    /// Forgets everything and listens no more.
    pub(super) fn stop(&self) {
        *lock(&self.heard) = Heard::default();
    }

    pub(super) fn take(&self, reading: &GaugeReading) {
        let mut heard = lock(&self.heard);
        if !heard.wanted || (reading.gauge_angle - heard.gauge_angle).abs() > 1e-9 {
            return;
        }
        if !heard.lobes.contains_key(&reading.lobe) {
            heard.lobes.insert(reading.lobe.clone(), Contact::default());
        }
        if let Some(log) = heard.lobes.get_mut(&reading.lobe) {
            match reading.pushing {
                true => log.pushed.push(crate::planning::pushed(reading)),
                false => log.gauged.push(crate::planning::gauged(reading)),
            }
        }
        drop(heard);
        self.changed.notify_all();
    }

    /// Waits until every named lobe has been read up to where C comes to rest after it (rad), but for a little; else the first that has
    /// not after the timeout.
    pub(super) fn wait<'a>(&self, lobes: &[(&'a str, f64)], timeout: Duration) -> Result<Vec<Contact>, &'a str> {
        let end = Instant::now() + timeout;
        let mut heard = lock(&self.heard);
        loop {
            let is_read = |name: &str, until_rad: f64| {
                heard.lobes.get(name).and_then(|log| log.gauged.last()).is_some_and(|last| last.c_rad >= until_rad)
            };
            let Some((missing, _)) = lobes.iter().find(|(name, until_rad)| !is_read(name, *until_rad)) else {
                return Ok(lobes.iter().map(|(name, _)| heard.lobes.remove(*name).unwrap_or_default()).collect());
            };
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(missing);
            }
            heard = self.changed.wait_timeout(heard, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_wanted_gauge_is_heard_and_until_the_part_rests() {
        let gaugings = Gaugings::default();
        let reading = |tick: u64, spindle_angle: f64, gauge_angle: f64| GaugeReading {
            tick,
            lobe: "J1".into(),
            spindle_angle,
            gauge_angle,
            ..GaugeReading::default()
        };
        let wait = |until_rad: f64| gaugings.wait(&[("J1", until_rad)], Duration::from_millis(1));
        gaugings.take(&reading(1, 9.0, 1.0));
        assert_eq!(wait(1.0), Err("J1"), "nobody wanted it");
        gaugings.listen(1.0);
        gaugings.take(&reading(2, 1.0, 1.0));
        gaugings.take(&reading(2, 5.0, 2.0));
        assert_eq!(wait(2.0), Err("J1"));
        gaugings.take(&reading(3, 2.5, 1.0));
        assert_eq!(wait(2.0).map(|logs| logs[0].gauged.len()), Ok(2));
        gaugings.stop();
        gaugings.take(&reading(4, 9.0, 1.0));
        assert_eq!(wait(0.0), Err("J1"));
    }
}
