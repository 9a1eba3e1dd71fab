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

/// Maximum age of the oldest datagram of a socket; beyond it the reader has stopped. A busy computer delays a thread by much less.
const STANDSTILL: Duration = Duration::from_secs(10);

/// Receiver of the alarm text.
type AlarmCallback = Box<dyn Fn(&str) + Send>;

struct WatchedLoop {
    id: u64,
    vitals: Vitals,
    /// The oldest unread datagram of each socket, and since when.
    unread: Vec<Option<(Vec<u8>, Instant)>>,
    alarm: AlarmCallback,
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
    loop {
        let mut ward = ward();
        while ward.patients.is_empty() {
            ward = ADMITTED.wait(ward).unwrap_or_else(PoisonError::into_inner);
        }
        let now = Instant::now();
        let mut index = 0;
        let mut alarms = Vec::new();
        while index < ward.patients.len() {
            match ward.patients[index].examine(now) {
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
    fn examine(&mut self, now: Instant) -> Option<String> {
        if let Some(thread) = self.vitals.threads.iter().find(|thread| !is_rustdds(**thread)) {
            return Some(format!("thread {thread} of RustDDS has ended"));
        }
        for (socket, unread) in self.vitals.readers.iter().zip(&mut self.unread) {
            let oldest = socket.oldest_unread();
            match (oldest, unread.as_ref()) {
                (None, _) => *unread = None,
                (Some(oldest), Some((same, since))) if oldest == *same => {
                    if now.duration_since(*since) >= STANDSTILL {
                        let waited_s = STANDSTILL.as_secs();
                        return Some(format!("RustDDS has read no datagram for {waited_s} s though one is waiting"));
                    }
                }
                (Some(oldest), _) => *unread = Some((oldest, now)),
            }
        }
        None
    }
}
