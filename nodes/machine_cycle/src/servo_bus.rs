// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The bus to real drives: its clock is the clock of the machine, one tick for every servo period.

use super::cyclic_loop::CyclicLoop;
use super::messages::{CyclicInput, Outbound};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::Axis;
use camwright::simulation::fault::Fault;
use camwright::simulation::measured::{DriveOrders, Measurement};
use camwright_threads::ring::Waker;
use camwright_threads::system_time::system_time_ns;
use std::fmt::Debug;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Silence of the bus after which its drives count as lost.
const SILENCE: Duration = Duration::from_millis(500);
/// Longest wait for a servo period, so that messages are handled meanwhile.
const WAIT: Duration = Duration::from_millis(20);

/// Readings of a servo period, and what the bus reports about itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BusPeriod {
    pub measurement: Measurement,
    /// The emergency stop chain is open.
    pub is_estop: bool,
    /// Bit i: the drive of axis i reports a fault.
    pub drive_faults: u8,
    /// The queue was empty, so that the drives kept their last setpoint.
    pub is_starved: bool,
    /// The drives follow what is sent; otherwise the queue is being filled, and nothing may move.
    pub is_following: bool,
    /// Setpoints in the queue.
    pub queued: u32,
    /// Deviation of this servo period from its length (ns).
    pub jitter_ns: u32,
}

/// Drives that take one setpoint each servo period and report it.
pub trait ServoBus: Debug + Send {
    /// Name of the kind of bus in records.
    fn name(&self) -> &'static str;

    /// Setpoints that wait in its queue as a rule.
    fn queue_ticks(&self) -> u32;

    /// The next servo period, if it has come.
    ///
    /// # Errors
    /// Why there will be no further period.
    fn next_period(&mut self) -> Result<Option<BusPeriod>, String>;

    /// Takes the orders of a tick, and sends them while the drives follow. A bus that has failed reports it with the next period.
    fn send(&mut self, orders: &DriveOrders);
}

/// The bus, and its state as the loop knows it.
#[derive(Debug)]
pub(super) struct BusState {
    bus: Box<dyn ServoBus>,
    /// Readings of the period that is executed.
    pub(super) measurement: Measurement,
    is_estop: bool,
    drive_faults: u8,
    /// When the last servo period came.
    heard: Option<Instant>,
    is_lost: bool,
}

impl CyclicLoop {
    /// With real drives, whose clock takes the place of the pace.
    pub fn with_bus(mut self, bus: Box<dyn ServoBus>, at_rest: Measurement) -> Self {
        let (is_estop, drive_faults, heard, is_lost) = (false, 0, None, false);
        self.bounds.bus.queue_ticks.store(bus.queue_ticks().into(), Ordering::Relaxed);
        self.bounds.bus.min_queued.store(u64::MAX, Ordering::Relaxed);
        self.bus = Some(BusState { bus, measurement: at_rest, is_estop, drive_faults, heard, is_lost });
        self
    }

    /// Executes the servo periods that have come, or waits for one.
    pub(super) fn run_bus(&mut self, waker: &Waker) {
        let Some(state) = &mut self.bus else { return };
        if state.is_lost {
            let _woken = waker.wait(self.cycle);
            return self.tick_without_drives();
        }
        match state.bus.next_period() {
            Ok(Some(period)) => self.execute_period(&period),
            Ok(None) if state.heard.get_or_insert_with(Instant::now).elapsed() > SILENCE => {
                self.lose_drives(format!("no servo period for {} ms", SILENCE.as_millis()));
            }
            Ok(None) => {
                let _woken = waker.wait(WAIT);
            }
            Err(reason) => self.lose_drives(reason),
        }
    }

    fn execute_period(&mut self, period: &BusPeriod) {
        let Some(state) = &mut self.bus else { return };
        let pause = state.heard.replace(Instant::now()).map_or(Duration::ZERO, |heard| heard.elapsed());
        state.measurement = period.measurement;
        let (estop, faults) = (state.is_estop != period.is_estop, state.drive_faults ^ period.drive_faults);
        (state.is_estop, state.drive_faults) = (period.is_estop, period.drive_faults);
        if estop {
            self.faults.add(Fault::EStop(period.is_estop), 0);
        }
        for axis in Axis::ALL.into_iter().filter(|axis| faults >> axis.index() & 1 == 1) {
            let active = period.drive_faults >> axis.index() & 1 == 1;
            self.faults.add(Fault::DriveFault { axis, active }, 0);
        }
        if period.is_following {
            self.note_pause(pause.saturating_sub(self.cycle));
            self.bounds.bus.see(period.queued, period.jitter_ns);
        }
        if period.is_starved {
            self.bounds.bus.underruns.fetch_add(1, Ordering::Relaxed);
        }
        // What rests stays where it is, unless HAL has taken the power from the drives meanwhile.
        let rests = self.machine.is_at_rest() && !self.buffer.has_setpoints();
        if period.is_starved && !(rests && pause < SILENCE) {
            self.report_applied(CyclicInput::Alarm(AlarmKind::Underrun, 0.0));
            self.machine.starve();
            self.buffer.close();
            self.state.news = true;
        }
        self.withhold_credit(!period.is_following);
        self.tick();
        self.note_lag();
        self.stop_waiting_for_partners(Instant::now());
        let orders = self.machine.orders();
        if let Some(state) = &mut self.bus {
            state.bus.send(&orders);
        }
    }

    /// Notes how far the last reported tick is behind the system clock.
    fn note_lag(&self) {
        let tick = self.last_report.map_or(0, |report| report.tick);
        let behind_us = self.pacing.behind_tick_ns(tick, system_time_ns()) / 1000;
        self.bounds.behind_us.store(behind_us, Ordering::Relaxed);
    }

    fn lose_drives(&mut self, reason: String) {
        if let Some(state) = &mut self.bus {
            state.is_lost = true;
        }
        self.send(Outbound::DrivesLost(reason));
    }

    /// The drives do not answer any more. The alarm comes again after every reset, until the node is started again; ticks go on by the
    /// clock of the computer, so that it is seen.
    fn tick_without_drives(&mut self) {
        if !self.machine.alarms().iter().any(|alarm| alarm.kind == AlarmKind::DrivesLost) {
            self.raise_outside(AlarmKind::DrivesLost, 0.0);
        }
        self.tick();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Bounds;
    use crate::pacing::Pace;
    use camwright::machine::persistent_state::PersistentState;
    use camwright::machine::reference::cam_grinder;
    use camwright::simulation::Machine;
    use camwright_threads::ring::ring;
    use std::collections::VecDeque;
    use std::sync::Arc;

    /// Drives that stand still.
    #[derive(Debug)]
    struct StillBus(VecDeque<BusPeriod>);

    impl ServoBus for StillBus {
        fn name(&self) -> &'static str {
            "still"
        }

        fn queue_ticks(&self) -> u32 {
            150
        }

        fn next_period(&mut self) -> Result<Option<BusPeriod>, String> {
            self.0.pop_front().map(Some).ok_or_else(|| "no period is left".to_owned())
        }

        fn send(&mut self, _: &DriveOrders) {}
    }

    #[test]
    fn an_empty_queue_at_rest_is_counted_and_no_alarm_and_a_lost_bus_is_one() {
        let description = cam_grinder();
        let counts =
            Axis::ALL.map(|axis| description.axis(axis).scale.counts(description.axis(axis).power_up_position));
        let at_rest = Measurement { counts, ..Measurement::default() };
        let machine = Machine::real(&description, PersistentState::new(&description), (5, 2.0), &at_rest);
        let (waker, bounds) = (Waker::default(), Arc::new(Bounds::default()));
        let (_inlet, inbound) = ring(8, &waker);
        let (outbound, mut reports) = ring(256, &waker);
        let machine = machine.expect("the reference machine is valid");
        let cycle = CyclicLoop::new(machine, Pace::Realtime, inbound, outbound, Arc::clone(&bounds), 0);
        let following =
            BusPeriod { measurement: at_rest, is_following: true, queued: 149, jitter_ns: 800, ..BusPeriod::default() };
        let starved = BusPeriod { is_starved: true, is_following: false, queued: 0, ..following };
        let low = BusPeriod { queued: 20, ..following };
        let mut cycle = cycle.with_bus(Box::new(StillBus([following, starved, low, following].into())), at_rest);
        (0..4).for_each(|_| cycle.run_bus(&waker));
        let read = |value: &std::sync::atomic::AtomicU64| value.load(Ordering::Relaxed);
        assert_eq!((read(&bounds.bus.queue_ticks), read(&bounds.bus.queued)), (150, 149));
        assert_eq!((read(&bounds.bus.min_queued), read(&bounds.bus.max_jitter_ns)), (20, 800));
        assert_eq!((read(&bounds.bus.underruns), cycle.machine.alarms().len()), (1, 0));
        cycle.run_bus(&waker);
        let is_reason =
            |report: &Outbound| matches!(report, Outbound::DrivesLost(reason) if reason.contains("no period"));
        assert!(std::iter::from_fn(|| reports.receive()).any(|report| is_reason(&report)));
        cycle.run_bus(&waker);
        assert!(cycle.machine.alarms().iter().any(|alarm| alarm.kind == AlarmKind::DrivesLost));
    }
}
