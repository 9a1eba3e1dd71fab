// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The lobes on the machine, as it last reported them.

use super::{lock, wait_for};
use camwright_msgs::camwright_msgs::msg::PartLobe;
use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex};
use std::time::Duration;

#[derive(Debug, Default)]
pub struct Parts {
    lobes: Mutex<BTreeMap<String, PartLobe>>,
    changed: Condvar,
}

impl Parts {
    pub fn add(&self, lobe: PartLobe) {
        lock(&self.lobes).insert(lobe.name.clone(), lobe);
        self.changed.notify_all();
    }

    /// The part is taken out: another comes.
    pub(crate) fn clear(&self) {
        lock(&self.lobes).clear();
    }

    /// Some lobe has been put in or reported: a part is between the centres.
    pub(crate) fn is_there(&self) -> bool {
        !lock(&self.lobes).is_empty()
    }

    /// A lobe as it was reported last, or put in after that.
    pub(crate) fn lobe(&self, name: &str) -> Option<PartLobe> {
        lock(&self.lobes).get(name).cloned()
    }

    /// Waits until every named lobe is reported finished at or after a tick; the first that is missing after the timeout.
    pub fn wait_finished<'a>(
        &self,
        names: &[&'a str],
        since_tick: u64,
        timeout: Duration,
    ) -> Result<Vec<PartLobe>, &'a str> {
        self.wait(names, timeout, |lobe| lobe.finished && lobe.tick >= since_tick)
    }

    /// Waits until every named lobe is reported at or after a tick, on a part whose job may not have come to its end.
    pub(crate) fn wait_reported<'a>(
        &self,
        names: &[&'a str],
        since_tick: u64,
        timeout: Duration,
    ) -> Result<Vec<PartLobe>, &'a str> {
        self.wait(names, timeout, |lobe| lobe.tick >= since_tick)
    }

    fn wait<'a>(
        &self,
        names: &[&'a str],
        timeout: Duration,
        is_wanted: impl Fn(&PartLobe) -> bool,
    ) -> Result<Vec<PartLobe>, &'a str> {
        wait_for(&self.lobes, &self.changed, timeout, |lobes| {
            match names.iter().find(|name| !lobes.get(**name).is_some_and(&is_wanted)) {
                Some(missing) => Err(*missing),
                None => Ok(names.iter().filter_map(|name| lobes.get(*name).cloned()).collect()),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_of_an_earlier_job_is_not_the_finished_part() {
        let parts = Parts::default();
        let lobe = |tick, finished| PartLobe { name: "I1".into(), tick, finished, ..PartLobe::default() };
        let wait = |since| parts.wait_finished(&["I1"], since, Duration::from_millis(1)).map(|lobes| lobes[0].tick);
        assert_eq!(wait(0), Err("I1"));
        parts.add(lobe(100, true));
        assert_eq!(wait(50), Ok(100));
        assert_eq!(wait(101), Err("I1"), "that was the part before");
        parts.add(lobe(200, false));
        assert_eq!(wait(101), Err("I1"), "a blank");
        let reported = |since| parts.wait_reported(&["I1"], since, Duration::from_millis(1)).map(|lobes| lobes[0].tick);
        assert_eq!((reported(101), reported(201)), (Ok(200), Err("I1")), "the part of a job that was stopped");
        parts.add(lobe(300, true));
        assert_eq!(wait(101), Ok(300));
    }
}
