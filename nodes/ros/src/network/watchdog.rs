// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Notices when `RustDDS` has died or stands still.
//!
//! A panic ends its thread and nothing else: the node keeps running, deaf and mute. An endless loop leaves even the thread. So one thread of
//! this process looks every half second whether the threads of each participant live, and whether its sockets are read.

use std::{
    sync::{Condvar, Mutex, MutexGuard, Once, PoisonError},
    time::{Duration, Instant},
};

use super::vitals::{Vitals, is_rustdds};

const PERIOD: Duration = Duration::from_millis(500);

/// Maximum age of the oldest datagram of a socket; beyond it the reader has stopped. Time in which the reader could not run does not count.
const STANDSTILL: Duration = Duration::from_secs(10);

/// Receiver of the alarm text.
type AlarmCallback = Box<dyn Fn(&str) + Send>;

struct WatchedLoop {
    id: u64,
    vitals: Vitals,
    /// The oldest unread datagram of each socket.
    unread: Vec<Option<UnreadDatagram>>,
    alarm: AlarmCallback,
}

struct UnreadDatagram {
    octets: Vec<u8>,
    /// Time for which the reader has left it.
    left: Duration,
    /// Time for which the threads of the participant had waited for a processor at the last look.
    waited: Duration,
}

impl UnreadDatagram {
    /// It is still there after this time. A round that is late was held up by what may have held up the reader too.
    fn is_there_after(&mut self, round: Duration, waited: Duration) {
        self.left += round.min(2 * PERIOD).saturating_sub(waited.saturating_sub(self.waited));
        self.waited = waited;
    }
}

#[derive(Default)]
struct WatchedLoops {
    patients: Vec<WatchedLoop>,
    next_id: u64,
}

static WARD: Mutex<WatchedLoops> = Mutex::new(WatchedLoops { patients: Vec::new(), next_id: 0 });
static ADMITTED: Condvar = Condvar::new();

fn ward() -> MutexGuard<'static, WatchedLoops> {
    WARD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a participant under watch until it is dropped, which must happen before the participant is.
#[derive(Debug)]
#[must_use = "dropping it ends the watch"]
pub(crate) struct ParticipantWatch(u64);

/// Watches a participant; `alarm` is called once, with the reason.
///
/// # Errors
/// The operating system refuses a thread.
pub(crate) fn watch(vitals: Vitals, alarm: impl Fn(&str) + Send + 'static) -> std::io::Result<ParticipantWatch> {
    static STARTED: Once = Once::new();
    let mut started = Ok(());
    STARTED.call_once(|| {
        started = std::thread::Builder::new().name("dds watchdog".into()).spawn(make_rounds).map(drop);
    });
    started?;
    let mut ward = ward();
    ward.next_id += 1;
    let id = ward.next_id;
    let unread = vitals.readers.iter().map(|_| None).collect();
    ward.patients.push(WatchedLoop { id, vitals, unread, alarm: Box::new(alarm) });
    drop(ward);
    ADMITTED.notify_one();
    Ok(ParticipantWatch(id))
}

impl Drop for ParticipantWatch {
    fn drop(&mut self) {
        ward().patients.retain(|patient| patient.id != self.0);
    }
}

fn make_rounds() {
    let mut last = Instant::now();
    loop {
        let mut ward = ward();
        while ward.patients.is_empty() {
            ward = ADMITTED.wait(ward).unwrap_or_else(PoisonError::into_inner);
        }
        let now = Instant::now();
        let round = now.duration_since(last);
        last = now;
        let mut index = 0;
        let mut alarms = Vec::new();
        while index < ward.patients.len() {
            match ward.patients[index].examine(round) {
                None => index += 1,
                Some(reason) => alarms.push((ward.patients.swap_remove(index).alarm, reason)),
            }
        }
        // An alarm may end the watch of others.
        drop(ward);
        for (alarm, reason) in alarms {
            alarm(&reason);
        }
        std::thread::park_timeout(PERIOD);
    }
}

impl WatchedLoop {
    /// Looks at it after the time since the last look.
    fn examine(&mut self, round: Duration) -> Option<String> {
        if let Some(thread) = self.vitals.threads.iter().find(|thread| !is_rustdds(**thread)) {
            return Some(format!("thread {thread} of RustDDS has ended"));
        }
        let waited = self.vitals.waited_for_processor();
        for (socket, unread) in self.vitals.readers.iter().zip(&mut self.unread) {
            match (socket.oldest_unread(), unread.as_mut()) {
                (None, _) => *unread = None,
                (Some(oldest), Some(same)) if oldest == same.octets => {
                    same.is_there_after(round, waited);
                    if same.left >= STANDSTILL {
                        let waited_s = STANDSTILL.as_secs();
                        return Some(format!("RustDDS has read no datagram for {waited_s} s though one is waiting"));
                    }
                }
                (Some(octets), _) => *unread = Some(UnreadDatagram { octets, left: Duration::ZERO, waited }),
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader may wait for a processor, or its process be stopped, for longer than it may stand still.
    #[test]
    fn a_reader_that_cannot_run_does_not_stand_still() {
        let (second, waited) = (Duration::from_secs(1), Duration::from_secs(100));
        let unread = || UnreadDatagram { octets: vec![1], left: Duration::ZERO, waited };
        let mut standing = unread();
        (0..20).for_each(|_| standing.is_there_after(PERIOD, waited));
        assert_eq!(standing.left, STANDSTILL);

        let mut starved = unread();
        (1..=40).for_each(|round| starved.is_there_after(PERIOD, waited + round * PERIOD / 2));
        assert_eq!(starved.left, STANDSTILL);

        let mut stopped = unread();
        stopped.is_there_after(60 * second, waited);
        // Several threads may have waited for longer than the time that went by.
        stopped.is_there_after(PERIOD, waited + 3 * second);
        assert_eq!(stopped.left, second);
    }
}
