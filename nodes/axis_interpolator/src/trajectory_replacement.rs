//! One trajectory after another without a stop between: the engine says where the axes will be, and waits there for what comes next.

use super::engine::Engine;
use super::engine_messages::{FromEngine, MotionForecast, PreparedMotion};
use super::next_trajectory::NextTrajectory;
use camwright::interpolator::{StartError, StateForecast};

impl Engine {
    /// Looks ahead as far as it takes to make the trajectory that comes next; if it takes longer, what was sent still ends in a stop.
    pub(super) fn foresee(&mut self, soonest: u64) {
        let tick = (self.next_tick + self.machine.stream_period_ticks()).max(soonest);
        let foresight = match self.running {
            Some(running) if running.outcome.is_none() => match self.interpolator.foresee(tick) {
                StateForecast::At(start) => MotionForecast::At(tick, start),
                StateForecast::Over => MotionForecast::Over,
                StateForecast::Held => MotionForecast::Disturbed,
            },
            _ => MotionForecast::Over,
        };
        if let MotionForecast::At(tick, _) = foresight {
            self.next_trajectory = NextTrajectory::Awaited(tick);
        }
        self.send(FromEngine::Foreseen(foresight));
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
