// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One trajectory after another without a stop between: the engine says where the axes will be, and waits there for what comes next.

use super::engine::Engine;
use super::engine_messages::{FromEngine, MotionForecast, PreparedMotion};
use super::next_trajectory::NextTrajectory;
use camwright::interpolator::{StartError, StateForecast};

impl Engine {
    /// Takes the request for a forecast. A trajectory in command that waits for axes at rest is forecast once it has begun.
    pub(super) fn foresee(&mut self, soonest: u64) {
        self.next_trajectory = NextTrajectory::Requested(soonest);
        self.answer_forecast();
    }

    /// Answers the request for a forecast, unless the trajectory in command has not begun.
    pub(super) fn answer_forecast(&mut self) {
        let NextTrajectory::Requested(soonest) = self.next_trajectory else { return };
        let Some(foresight) = self.forecast(soonest) else { return };
        self.next_trajectory = match foresight {
            MotionForecast::At(tick, _) => NextTrajectory::Awaited(tick),
            MotionForecast::Over | MotionForecast::Disturbed => NextTrajectory::None,
        };
        self.send(FromEngine::Foreseen(foresight));
    }

    /// Looks ahead as far as it takes to make the trajectory that comes next; if it takes longer, what was sent still ends in a stop.
    /// `None`: the motion has not begun.
    fn forecast(&self, soonest: u64) -> Option<MotionForecast> {
        if self.has_waiting() {
            return None;
        }
        let tick = (self.next_tick + self.machine.stream_period_ticks()).max(soonest);
        match self.running {
            Some(running) if running.outcome.is_none() => match self.interpolator.foresee(tick) {
                StateForecast::At(start) => Some(MotionForecast::At(tick, start)),
                StateForecast::NotBegun => None,
                StateForecast::Over => Some(MotionForecast::Over),
                StateForecast::Held => Some(MotionForecast::Disturbed),
            },
            _ => Some(MotionForecast::Over),
        }
    }

    /// Takes what was made for the tick that was foreseen.
    pub(super) fn take_successor(&mut self, made: PreparedMotion) {
        match self.next_trajectory {
            NextTrajectory::Awaited(tick) => self.next_trajectory = NextTrajectory::Ready(tick, made),
            // The motion before it has ended otherwise meanwhile.
            _ => self.send(FromEngine::NotSpliced(StartError::MovesOtherwise, made)),
        }
    }

    /// At the tick that was foreseen the one takes the place of the other.
    pub(super) fn succeed(&mut self) {
        let due = matches!(&self.next_trajectory, NextTrajectory::Ready(tick, _) if *tick == self.next_tick);
        if !due {
            return;
        }
        let NextTrajectory::Ready(tick, made) = std::mem::take(&mut self.next_trajectory) else { return };
        let PreparedMotion { motion, record } = made;
        // A hold or a cancel that came meanwhile means the one in execution.
        let outcome = if self.is_disturbed() {
            Err((StartError::MovesOtherwise, motion))
        } else {
            self.interpolator.splice(tick, motion)
        };
        self.send(match outcome {
            Ok(()) => FromEngine::Spliced { tick, record },
            Err((error, motion)) => FromEngine::NotSpliced(error, PreparedMotion { motion, record }),
        });
        if let Some(finished) = self.interpolator.take_finished() {
            self.send(FromEngine::Done(finished));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine_messages::{Ended, JobEnds, MachineFeedback, ToEngine};
    use camwright::interpolator::join::StartTolerance;
    use camwright::interpolator::tolerance::{FollowingTolerances, Tolerance};
    use camwright::interpolator::trajectory::{TrajectoryPoint, TrajectoryStart};
    use camwright::interpolator::{MotionOutcome, MotionRequest};
    use camwright::machine::alarm::AlarmKind;
    use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
    use camwright::machine::reference::cam_grinder;
    use camwright::machine::setpoint::Measured;
    use camwright_files::convert::motion_record::{MotionRecord, MoveRecord};
    use camwright_threads::ring::{Receiver, Sender, Waker, ring};
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    const Z: usize = Axis::Z.index();

    /// An engine without its threads, and a machine that reports when the test wants it.
    struct EngineBench {
        engine: Engine,
        inlet: Sender<ToEngine>,
        reports: Receiver<FromEngine>,
        machine: MachineDescription,
        tick: u64,
        is_realtime: bool,
        commands_received: u32,
        /// Reports except chunks, orders, status and inputs.
        received: Vec<FromEngine>,
    }

    impl EngineBench {
        fn new(is_realtime: bool) -> Self {
            let machine = cam_grinder();
            let (inlet, inbox) = ring(256, &Waker::default());
            let (outbox, reports) = ring(4096, &Waker::default());
            let engine = Engine::new(&machine, inbox, outbox, Arc::new(AtomicBool::new(false)));
            Self {
                engine,
                inlet,
                reports,
                machine,
                tick: 1000,
                is_realtime,
                commands_received: 0,
                received: Vec::new(),
            }
        }

        fn send(&mut self, message: ToEngine) {
            self.inlet.send(message).expect("room");
        }

        /// Report of the machine's tick; `behind_counts` is the following error of Z.
        fn report(&self, is_standstill: bool, behind_counts: i64, alarms: &[u16]) -> ToEngine {
            let (tick, interpolator) = (self.tick, &self.engine.interpolator);
            let mut counts = interpolator.desired_at(tick).map_or([0; AXIS_COUNT], |setpoint| setpoint.counts);
            counts[Z] -= behind_counts;
            ToEngine::News(Box::new(MachineFeedback {
                tick,
                credit_tick: tick + u64::from(self.machine.feedback_delay_ticks),
                is_standstill,
                is_realtime: self.is_realtime,
                commands_received: self.commands_received,
                alarms: alarms.to_vec(),
                setpoint_counts: interpolator.setpoint().counts,
                measured: Some(Measured { tick, counts, velocity: [0.0; AXIS_COUNT] }),
                latches: Vec::new(),
            }))
        }

        /// The machine's next report.
        fn feedback(&mut self, is_standstill: bool, behind_counts: i64) {
            self.tick += self.machine.stream_period_ticks();
            let report = self.report(is_standstill, behind_counts, &[]);
            self.send(report);
        }

        fn cycle(&mut self) {
            self.engine.cycle();
            while let Some(report) = self.reports.receive() {
                match report {
                    FromEngine::Chunk(mut chunk) => {
                        chunk.clear();
                        self.send(ToEngine::Chunk(chunk));
                    }
                    FromEngine::Command { sequence, .. } => self.commands_received = sequence,
                    FromEngine::Status { .. }
                    | FromEngine::Applied { .. }
                    | FromEngine::Event { .. }
                    | FromEngine::Tracking(_)
                    | FromEngine::Used(_)
                    | FromEngine::Done(_) => {}
                    report => self.received.push(report),
                }
            }
        }

        /// A machine that moves or settles, and one that stands still.
        fn moves(&mut self) {
            self.feedback(false, 0);
            self.cycle();
        }

        fn stands(&mut self) {
            self.feedback(true, 0);
            self.cycle();
        }

        fn to(&self, z_mm: f64, time_s: f64, start: &TrajectoryStart) -> PreparedMotion {
            let points = [TrajectoryPoint { time_s, positions: vec![z_mm], ..TrajectoryPoint::default() }];
            let mut tolerances = FollowingTolerances::default();
            tolerances.path[Z] = Tolerance { position: Some(1.0), ..Tolerance::default() };
            let with = (&tolerances, &StartTolerance::default());
            let record = MotionRecord::trajectory(&[Axis::Z], &points, start, with, None);
            PreparedMotion::new(record, None, &self.machine).expect("within limits")
        }

        fn start(&mut self, z_mm: f64, time_s: f64) {
            let counts = self.engine.interpolator.setpoint().counts;
            let at = |axis: Axis| self.machine.axis(axis).scale.position(counts[axis.index()]);
            let made = self.to(z_mm, time_s, &TrajectoryStart::at_rest(Axis::ALL.map(at)));
            self.send(ToEngine::Start { made, job: JobEnds::default() });
        }

        fn start_move(&mut self) {
            let moves = vec![MoveRecord { joint: Axis::Z.joint().into(), position: 5.0, relative: true }];
            let from = self.engine.interpolator.setpoint().counts;
            let record = MotionRecord::Move { moves, from, speed_factor: 1.0 };
            let made = PreparedMotion::new(record, None, &self.machine).expect("within limits");
            self.send(ToEngine::Start { made, job: JobEnds::default() });
        }

        /// Reports until the motion is over; it stands still with `stands`.
        fn end(&mut self, stands: bool, behind_counts: i64) -> Ended {
            for _ in 0..3000 {
                let has_ended = |report: &FromEngine| matches!(report, FromEngine::Ended(_));
                if let Some(index) = self.received.iter().position(has_ended)
                    && let FromEngine::Ended(ended) = self.received.swap_remove(index)
                {
                    self.received.clear();
                    return ended;
                }
                let is_over = self.engine.running.is_some_and(|running| running.outcome.is_some());
                self.feedback(is_over && stands, behind_counts);
                self.cycle();
            }
            panic!("it does not end: {:?}", self.received);
        }

        fn forecast(&self) -> Option<MotionForecast> {
            self.received.iter().find_map(|report| match report {
                FromEngine::Foreseen(forecast) => Some(*forecast),
                _ => None,
            })
        }

        /// The slow trajectory is replaced by a fast one, which ends in time.
        fn replace(&mut self, after: &str, z_mm: f64) {
            let Some(MotionForecast::At(tick, start)) = self.forecast() else {
                panic!("after {after}: {:?}", self.received)
            };
            self.received.clear();
            let fast = self.to(z_mm, 2.0, &start);
            self.send(ToEngine::Splice(fast));
            while self.tick < tick {
                self.moves();
            }
            let spliced = self
                .received
                .iter()
                .any(|report| matches!(report, FromEngine::Spliced { tick: at, .. } if *at == tick));
            assert!(spliced, "after {after}: {:?}", self.received);
            self.received.clear();
        }
    }

    /// Runs what comes before the slow trajectory, up to its end: axes still settle after a trajectory.
    fn run_before(bench: &mut EngineBench, before: &str) {
        bench.stands();
        match before {
            "nothing" => return,
            "a move" => bench.start_move(),
            _ => bench.start(20.0, 1.0),
        }
        for _ in 0..3 {
            bench.stands();
        }
        assert!(bench.engine.running.is_some(), "{before}: {:?}", bench.received);
        for _ in 0..30 {
            bench.moves();
        }
        let (behind_counts, wanted) = match before {
            "a cancelled one" => {
                bench.send(ToEngine::Request(MotionRequest::Cancel));
                (0, "Cancelled")
            }
            "an aborted one" => (bench.machine.axis(Axis::Z).scale.counts(2.0), "OutOfTolerance"),
            _ => (0, "Completed"),
        };
        let ended = bench.end(before == "a move", behind_counts);
        assert!(format!("{:?}", ended.outcome).starts_with(wanted), "{before}: {ended:?}");
    }

    const BEFORE: [&str; 5] = ["nothing", "a complete one", "a cancelled one", "an aborted one", "a move"];

    /// A trajectory is reported while its motion still waits for axes at rest; one that arrives then replaces it all the same.
    #[test]
    fn a_trajectory_that_waits_for_axes_at_rest_is_replaced_once_it_has_begun() {
        for (before, is_realtime) in BEFORE.into_iter().flat_map(|before| [(before, false), (before, true)]) {
            let mut bench = EngineBench::new(is_realtime);
            run_before(&mut bench, before);
            bench.start(100.0, 3600.0);
            bench.send(ToEngine::Foresee { soonest: 0 });
            bench.cycle();
            assert!(bench.received.is_empty() || is_realtime, "{before}: it has not begun: {:?}", bench.received);
            bench.moves();
            for _ in 0..3 {
                bench.stands();
            }
            bench.replace(before, 50.0);
            // And another takes the place of that one.
            bench.moves();
            bench.send(ToEngine::Foresee { soonest: 0 });
            bench.cycle();
            bench.replace(before, 40.0);
            let ended = bench.end(false, 0);
            assert_eq!(ended.outcome, MotionOutcome::Completed, "{before}");
            assert!(ended.last_tick - ended.first_tick < 3000, "{before}: {ended:?}");
            let stands = bench.engine.interpolator.setpoint().counts[Z];
            assert_eq!(stands, bench.machine.axis(Axis::Z).scale.counts(40.0), "{before}");
        }
    }

    /// The request for a forecast comes after the start and before the first tick.
    #[test]
    fn a_trajectory_before_its_first_tick_is_replaced_once_it_has_begun() {
        let mut bench = EngineBench::new(true);
        bench.stands();
        bench.start(100.0, 3600.0);
        bench.cycle();
        bench.feedback(true, 0);
        bench.send(ToEngine::Foresee { soonest: 0 });
        bench.cycle();
        bench.replace("its start", 50.0);
        assert_eq!(bench.end(false, 0).outcome, MotionOutcome::Completed);
    }

    type EndOfWait<'a> = &'a dyn Fn(&EngineBench) -> ToEngine;

    /// A cancel, an alarm or a lost machine ends the wait of the trajectory in command, and then that of its successor.
    #[test]
    fn a_forecast_is_answered_when_the_trajectory_does_not_begin() {
        let alarm = AlarmKind::FollowingError(Axis::Z).entry().number;
        let cancel = |_: &EngineBench| ToEngine::Request(MotionRequest::Cancel);
        let lost = |_: &EngineBench| ToEngine::MachineLost;
        let raised = |bench: &EngineBench| bench.report(false, 0, &[alarm]);
        let cases: [(EndOfWait<'_>, StartError); 3] =
            [(&cancel, StartError::Cancelled), (&raised, StartError::Fault), (&lost, StartError::MachineLost)];
        for (end, wanted) in cases {
            let mut bench = EngineBench::new(false);
            run_before(&mut bench, "a complete one");
            bench.moves();
            bench.start(100.0, 3600.0);
            bench.send(ToEngine::Foresee { soonest: 0 });
            bench.cycle();
            assert!(bench.received.is_empty(), "{:?}", bench.received);
            bench.tick += bench.machine.stream_period_ticks();
            let message = end(&bench);
            bench.send(message);
            bench.cycle();
            let [FromEngine::NotStarted(error, _), FromEngine::Foreseen(MotionForecast::Over)] = &bench.received[..]
            else {
                panic!("{wanted:?}: {:?}", bench.received);
            };
            assert_eq!(*error, wanted);
        }
    }

    /// A hold is answered with success while a motion has command, so it applies to a motion that has not begun.
    #[test]
    fn a_hold_before_the_first_tick_holds_the_motion() {
        for is_realtime in [false, true] {
            let mut bench = EngineBench::new(is_realtime);
            run_before(&mut bench, "a move");
            let stood = bench.engine.interpolator.setpoint().counts;
            bench.start(40.0, 1.0);
            bench.moves();
            bench.send(ToEngine::Request(MotionRequest::Hold));
            bench.moves();
            assert!(bench.engine.has_waiting());
            (0..300).for_each(|_| bench.stands());
            assert!(bench.engine.running.is_some());
            let held = bench.engine.interpolator.setpoint().counts;
            (0..300).for_each(|_| bench.stands());
            assert_eq!(bench.engine.interpolator.setpoint().counts, held, "realtime {is_realtime}: it rests");
            bench.send(ToEngine::Request(MotionRequest::Unhold));
            assert_eq!(bench.end(true, 0).outcome, MotionOutcome::Completed);
            let [done, whole] = [held, bench.engine.interpolator.setpoint().counts].map(|at| at[Z] - stood[Z]);
            assert!(whole > 0 && 100 * done.abs() < whole, "held after {done} of {whole} counts");
        }
    }

    #[test]
    fn a_hold_of_a_motion_that_is_over_does_not_hold_the_next_one() {
        let mut bench = EngineBench::new(true);
        bench.stands();
        bench.start(20.0, 1.0);
        bench.stands();
        bench.stands();
        // The last setpoint is computed before the machine executes it.
        let is_computed = |engine: &Engine| engine.running.is_some_and(|running| running.outcome.is_some());
        let cycles = (0..3000).find(|_| {
            bench.moves();
            is_computed(&bench.engine)
        });
        assert!(cycles.is_some());
        bench.send(ToEngine::Request(MotionRequest::Hold));
        assert_eq!(bench.end(true, 0).outcome, MotionOutcome::Completed);
        let stood = bench.engine.interpolator.setpoint().counts;
        bench.start(40.0, 1.0);
        bench.stands();
        bench.stands();
        assert_eq!(bench.end(true, 0).outcome, MotionOutcome::Completed);
        assert_ne!(bench.engine.interpolator.setpoint().counts, stood);
    }
}
