// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! When the next tick is due at pace realtime: stamps follow the system clock, and a slip is made up for or reported.
//!
//! The time of tick k is epoch + k · cycle for as long as the node lives, so ticks have to follow the system clock:
//!
//! ```text
//! on time ──(more than 50 cycles late)──► behind ──(at rest, 200 quiet cycles without credit)──► making up ─► on time
//!                                            └──(in motion: 10 % faster while setpoints are ahead)──────────►┘
//! ```
//! A machine that is behind executes no burst of ticks while setpoints for them may still arrive: it
//! withdraws its credit first, so that no motion begins, waits for what is under way, and only then executes the ticks
//! that are missing. Nothing moves in them. A clock that is set back makes the ticks 10 % slower until it has caught up.

use camwright_files::convert::time::TickClock;
use std::time::Duration;

/// Ticks that are made up for at once, in motion too: fewer than setpoints are sent ahead.
const SLIP_TICKS: i64 = 50;
/// Ticks that a resting machine executes at one wake-up: a wake-up of the cycle costs more than a tick.
pub const REST_BATCH_TICKS: u64 = 5;
/// Ticks without credit and without a message before ticks are made up for: longer than a message is under way.
const QUIET_TICKS: u32 = 200;

/// Pace of the ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// With the wall clock; a missing setpoint is an underrun.
    Realtime,
    /// With the setpoints; a missing one is waited for.
    Fast,
}

/// State of the clock and of the inputs before a tick.
#[derive(Debug, Clone, Copy)]
pub struct CycleTime {
    /// Monotonic time (ns).
    pub monotonic_ns: i64,
    /// Time of the system clock since 1970 (ns).
    pub system_ns: i64,
    /// Last tick that was executed.
    pub tick: u64,
    /// The axes rest, and nothing waits to be executed.
    pub is_idle: bool,
    /// Setpoints for more than half of the credit are there.
    pub has_room: bool,
    /// The ticks up to the next message can only repeat the last one.
    pub rests: bool,
}

/// Next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PacingStep {
    /// Execute the next tick, which is so late (ns).
    Tick(i64),
    /// Nothing is due for so long.
    Wait(Duration),
}

/// A slip of the machine's time against the system clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slip {
    /// The cycle was kept from executing ticks for so long (ns).
    Stalled(i64),
    /// The node was inactive for so long (ns).
    Inactive(i64),
    /// The system clock was set back by so much (ns).
    ClockSetBack(i64),
    /// All ticks up to now are executed; so much had to be made up for (ns).
    MadeUp(i64),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PacingMode {
    OnTime,
    Behind {
        quiet_ticks: u32,
        max_ns: i64,
    },
    MakingUp {
        max_ns: i64,
    },
    /// The clock was set back; its ticks are yet to come.
    Ahead,
}

/// Decides when ticks are executed.
#[derive(Debug)]
pub struct Pacing {
    clock: TickClock,
    mode: PacingMode,
    /// When a tick of a machine that is behind is due, and when the last one was executed (monotonic, ns).
    deadline_ns: i64,
    last_ns: i64,
    /// The node has just become active.
    resumes: bool,
    slip: Option<Slip>,
}

impl Pacing {
    pub fn new(clock: TickClock) -> Self {
        Self { clock, mode: PacingMode::OnTime, deadline_ns: 0, last_ns: 0, resumes: true, slip: None }
    }

    /// The node is inactive.
    pub fn suspend(&mut self) {
        self.resumes = true;
    }

    /// No motion may begin now.
    pub fn withholds_credit(&self) -> bool {
        matches!(self.mode, PacingMode::MakingUp { .. } | PacingMode::Behind { quiet_ticks: 1.., .. })
    }

    /// A slip since it was last asked for.
    pub fn take_slip(&mut self) -> Option<Slip> {
        self.slip.take()
    }

    /// Lateness of the next wake-up against the system clock (ns); negative: it is not due yet.
    pub fn behind_ns(&self, moment: &CycleTime) -> i64 {
        let next = moment.tick.saturating_add(1);
        let is_batch = moment.rests && self.mode == PacingMode::OnTime;
        let due = if is_batch { next.next_multiple_of(REST_BATCH_TICKS) } else { next };
        self.behind_tick_ns(due, moment.system_ns)
    }

    /// Time of the system clock since a tick was due (ns).
    pub fn behind_tick_ns(&self, tick: u64, system_ns: i64) -> i64 {
        system_ns.saturating_sub(self.clock.ns(tick))
    }

    pub fn next(&mut self, moment: &CycleTime) -> PacingStep {
        let cycle_ns = i64::from(self.clock.cycle_time_ns);
        let behind_ns = self.behind_ns(moment);
        let resumes = std::mem::take(&mut self.resumes);
        self.judge(moment, behind_ns, resumes);
        let step = match self.mode {
            PacingMode::OnTime | PacingMode::MakingUp { .. } if behind_ns >= 0 => PacingStep::Tick(behind_ns),
            PacingMode::OnTime if moment.rests => wait(-behind_ns),
            PacingMode::OnTime | PacingMode::MakingUp { .. } | PacingMode::Ahead => {
                let slow_ns = (self.last_ns + cycle_ns + cycle_ns / 10).saturating_sub(moment.monotonic_ns);
                let wait_ns = slow_ns.min(behind_ns.saturating_neg());
                if wait_ns <= 0 { PacingStep::Tick(0) } else { wait(wait_ns) }
            }
            PacingMode::Behind { .. } => {
                let late_ns = moment.monotonic_ns - self.deadline_ns;
                if late_ns >= 0 { PacingStep::Tick(late_ns) } else { wait(-late_ns) }
            }
        };
        if matches!(step, PacingStep::Tick(_)) {
            self.executed(moment, cycle_ns);
        }
        step
    }

    /// Goes from one mode to another.
    fn judge(&mut self, moment: &CycleTime, behind_ns: i64, resumes: bool) {
        let slip_ns = SLIP_TICKS * i64::from(self.clock.cycle_time_ns);
        let is_late = behind_ns > slip_ns;
        self.mode = match self.mode {
            // No tick has been published yet.
            _ if moment.tick == 0 && is_late => PacingMode::MakingUp { max_ns: 0 },
            PacingMode::OnTime | PacingMode::Ahead if is_late => {
                self.slip = Some(if resumes { Slip::Inactive(behind_ns) } else { Slip::Stalled(behind_ns) });
                self.deadline_ns = moment.monotonic_ns;
                PacingMode::Behind { quiet_ticks: 0, max_ns: behind_ns }
            }
            PacingMode::OnTime if behind_ns < -slip_ns => {
                self.slip = Some(Slip::ClockSetBack(-behind_ns));
                PacingMode::Ahead
            }
            PacingMode::Ahead if behind_ns >= -i64::from(self.clock.cycle_time_ns) => PacingMode::OnTime,
            PacingMode::Behind { quiet_ticks, max_ns } if is_late => {
                let max_ns = max_ns.max(behind_ns);
                match (moment.is_idle, quiet_ticks) {
                    (false, _) => PacingMode::Behind { quiet_ticks: 0, max_ns },
                    (true, QUIET_TICKS..) => PacingMode::MakingUp { max_ns },
                    (true, 0) => PacingMode::Behind { quiet_ticks: 1, max_ns },
                    (true, _) => PacingMode::Behind { quiet_ticks, max_ns },
                }
            }
            PacingMode::MakingUp { max_ns } if is_late && !moment.is_idle => {
                self.deadline_ns = moment.monotonic_ns;
                PacingMode::Behind { quiet_ticks: 0, max_ns }
            }
            PacingMode::Behind { max_ns, .. } if !is_late => self.made_up(max_ns),
            PacingMode::MakingUp { max_ns } if behind_ns < 0 => self.made_up(max_ns),
            mode => mode,
        };
    }

    fn made_up(&mut self, max_ns: i64) -> PacingMode {
        if max_ns > 0 {
            self.slip = Some(Slip::MadeUp(max_ns));
        }
        PacingMode::OnTime
    }

    /// A tick is about to be executed.
    fn executed(&mut self, moment: &CycleTime, cycle_ns: i64) {
        self.last_ns = moment.monotonic_ns;
        if let PacingMode::Behind { quiet_ticks, .. } = &mut self.mode {
            if *quiet_ticks > 0 {
                *quiet_ticks += 1;
            }
            let period_ns = if moment.has_room { cycle_ns * 9 / 10 } else { cycle_ns };
            self.deadline_ns = (self.deadline_ns + period_ns).max(moment.monotonic_ns - SLIP_TICKS * cycle_ns);
        }
    }
}

fn wait(ns: i64) -> PacingStep {
    PacingStep::Wait(Duration::from_nanos(u64::try_from(ns).unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;
    const EPOCH_NS: i64 = 1_795_000_000_123_000_000;

    /// A cycle whose clocks go on as it waits, with the ticks that it executed and the slips that it reported.
    struct PacingBench {
        pacing: Pacing,
        moment: CycleTime,
        slips: Vec<Slip>,
        withheld: u32,
    }

    impl PacingBench {
        fn new() -> Self {
            let clock = TickClock { epoch_ns: EPOCH_NS, cycle_time_ns: 1_000_000 };
            let moment = CycleTime {
                monotonic_ns: 0,
                system_ns: EPOCH_NS,
                tick: 0,
                is_idle: true,
                has_room: false,
                rests: false,
            };
            Self { pacing: Pacing::new(clock), moment, slips: Vec::new(), withheld: 0 }
        }

        fn pass(&mut self, ns: i64) {
            self.moment.monotonic_ns += ns;
            self.moment.system_ns += ns;
        }

        /// Runs for a time of the monotonic clock; every tick takes 5 µs.
        fn run(&mut self, ns: i64) {
            let end_ns = self.moment.monotonic_ns + ns;
            while self.moment.monotonic_ns < end_ns {
                match self.pacing.next(&self.moment) {
                    PacingStep::Tick(_) => {
                        self.moment.tick += 1;
                        self.pass(5_000);
                    }
                    PacingStep::Wait(time) => self.pass(i64::try_from(time.as_nanos()).expect("short").min(MS)),
                }
                self.slips.extend(self.pacing.take_slip());
                self.withheld += u32::from(self.pacing.withholds_credit());
            }
        }

        fn behind_ms(&self) -> f64 {
            self.pacing.behind_ns(&self.moment) as f64 / MS as f64
        }
    }

    #[test]
    fn ticks_follow_the_system_clock_from_the_first_on() {
        let mut bench = PacingBench::new();
        // What starting takes.
        bench.pass(1_300 * MS);
        bench.run(100 * MS);
        assert!(bench.behind_ms().abs() <= 1.0 && bench.slips.is_empty(), "{}", bench.behind_ms());
        // The system clock goes 100 ppm faster than the other for 10 minutes.
        for _ in 0..600 {
            bench.run(1_000 * MS);
            bench.moment.system_ns += MS / 10;
            assert!(bench.behind_ms() <= 0.2, "{}", bench.behind_ms());
        }
        assert!(bench.slips.is_empty(), "{:?}", bench.slips);
    }

    #[test]
    fn a_resting_machine_wakes_once_for_five_ticks_and_its_batches_end_on_time() {
        let mut bench = PacingBench::new();
        bench.run(100 * MS);
        bench.moment.rests = true;
        let (mut wakes, before) = (0_u64, bench.moment.tick);
        for _ in 0..2_000 {
            match bench.pacing.next(&bench.moment) {
                PacingStep::Tick(late_ns) => {
                    assert!(late_ns < MS / 2, "{late_ns} ns late");
                    bench.moment.tick += 1;
                    bench.pass(5_000);
                }
                PacingStep::Wait(time) => {
                    assert!(wakes == 0 || bench.moment.tick.is_multiple_of(REST_BATCH_TICKS), "waits within a batch");
                    wakes += 1;
                    bench.pass(i64::try_from(time.as_nanos()).expect("short"));
                }
            }
        }
        let ticks = bench.moment.tick - before;
        assert!(ticks > 1_000 && wakes <= ticks / REST_BATCH_TICKS + 1, "{wakes} wake-ups for {ticks} ticks");
        // A message came: its tick does not wait for the end of a batch.
        bench.moment.rests = false;
        bench.pass(2 * MS);
        bench.run(MS);
        assert!(bench.behind_ms() <= 0.0 && bench.slips.is_empty(), "{}", bench.behind_ms());
    }

    #[test]
    fn a_stall_at_rest_is_reported_and_made_up_for_without_credit() {
        let mut bench = PacingBench::new();
        bench.run(1_000 * MS);
        bench.pass(2_600 * MS);
        bench.run(100 * MS);
        assert!(matches!(bench.slips[..], [Slip::Stalled(ns)] if ns > 2_590 * MS), "{:?}", bench.slips);
        assert!(bench.behind_ms() > 2_500.0, "no burst before what is under way has come");
        assert!(bench.withheld > 0);
        bench.run(1_000 * MS);
        assert!(bench.behind_ms().abs() <= 1.0, "{}", bench.behind_ms());
        assert!(matches!(bench.slips[..], [_, Slip::MadeUp(_)]), "{:?}", bench.slips);
        assert!(!bench.pacing.withholds_credit());
    }

    #[test]
    fn in_motion_a_stall_is_made_up_for_slowly_where_setpoints_are_ahead_and_never_in_a_burst() {
        let mut bench = PacingBench::new();
        bench.run(1_000 * MS);
        bench.moment.is_idle = false;
        bench.pass(500 * MS);
        let before = bench.moment.tick;
        bench.run(1_000 * MS);
        let executed = bench.moment.tick - before;
        assert!((995..=1_005).contains(&executed), "{executed} ticks in a second without room");
        bench.moment.has_room = true;
        bench.run(6_000 * MS);
        assert!(bench.behind_ms() < 51.0, "{}", bench.behind_ms());
        assert_eq!(bench.withheld, 0, "what moves keeps its credit");
    }

    #[test]
    fn a_message_that_was_under_way_ends_the_quiet_time() {
        let mut bench = PacingBench::new();
        bench.run(1_000 * MS);
        bench.pass(500 * MS);
        bench.run(100 * MS);
        bench.moment.is_idle = false;
        bench.run(300 * MS);
        assert!(bench.behind_ms() > 400.0 && !bench.pacing.withholds_credit());
        bench.moment.is_idle = true;
        bench.run(300 * MS);
        assert!(bench.behind_ms() <= 1.0);
    }

    #[test]
    fn after_an_inactive_time_the_slip_is_of_its_length() {
        let mut bench = PacingBench::new();
        bench.run(1_000 * MS);
        bench.pacing.suspend();
        bench.pass(10_000 * MS);
        bench.run(1_000 * MS);
        assert!(matches!(bench.slips[..], [Slip::Inactive(ns), Slip::MadeUp(_)] if ns > 9_990 * MS));
        assert!(bench.behind_ms().abs() <= 1.0);
    }

    #[test]
    fn a_clock_that_is_set_back_slows_the_ticks_and_a_clock_set_forward_is_a_slip() {
        let mut bench = PacingBench::new();
        bench.run(1_000 * MS);
        bench.moment.system_ns -= 1_000 * MS;
        let before = bench.moment.tick;
        bench.run(1_000 * MS);
        let executed = bench.moment.tick - before;
        assert!((890..=930).contains(&executed), "{executed} ticks in a second");
        assert!(matches!(bench.slips[..], [Slip::ClockSetBack(_)]));
        bench.run(11_000 * MS);
        assert!(bench.behind_ms().abs() <= 1.1, "{}", bench.behind_ms());
        bench.moment.system_ns += 3_000 * MS;
        bench.run(1_000 * MS);
        assert!(matches!(bench.slips[1..], [Slip::Stalled(_), Slip::MadeUp(_)]));
        assert!(bench.behind_ms().abs() <= 1.0);
    }
}
