// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Progress of the plan in execution, and which lobes it has finished.

use camwright::motion::plan::{Plan, SegmentKind};
use camwright_msgs::camwright_msgs::action::ExecutePlanFeedback;

/// Segments that the interpolator has begun, and cuts whose turns are done, with their ticks.
#[derive(Debug, Default)]
pub(super) struct PlanProgress {
    begun: Vec<(usize, u64)>,
    done: Vec<(usize, u64)>,
}

impl PlanProgress {
    pub(super) fn note(&mut self, feedback: &ExecutePlanFeedback) {
        let Ok(segment) = usize::try_from(feedback.segment) else { return };
        let is_new = |list: &[(usize, u64)]| list.last().is_none_or(|(last, _)| *last < segment);
        if is_new(&self.begun) {
            self.begun.push((segment, feedback.tick));
        }
        if feedback.turns > 0.0 && feedback.turn >= feedback.turns && is_new(&self.done) {
            self.done.push((segment, feedback.tick));
        }
    }

    /// Tick at which a segment was done, as far as is known.
    fn done_at(&self, segment: usize) -> Option<u64> {
        let next = self.begun.iter().find(|(begun, _)| *begun > segment).map(|(_, tick)| *tick);
        let all_turns = self.done.iter().find(|(done, _)| *done == segment).map(|(_, tick)| *tick);
        all_turns.into_iter().chain(next).min()
    }

    /// Lobes that were finished up to a tick, with the tick of the last one. `last_cuts` are those of the plan.
    pub(super) fn finished(&self, last_cuts: &[Option<usize>], until_tick: u64) -> (Vec<usize>, u64) {
        let done_at = |last: &Option<usize>| last.and_then(|segment| self.done_at(segment));
        let done: Vec<(usize, u64)> = last_cuts
            .iter()
            .enumerate()
            .filter_map(|(lobe, last)| done_at(last).map(|tick| (lobe, tick)))
            .filter(|(_, tick)| *tick <= until_tick)
            .collect();
        let last_tick = done.iter().map(|(_, tick)| *tick).max().unwrap_or_default();
        (done.into_iter().map(|(lobe, _)| lobe).collect(), last_tick)
    }
}

/// Index of the last cut of each lobe; empty for a plan that finishes no part.
pub(super) fn last_cuts(plan: &Plan) -> Vec<Option<usize>> {
    if !plan.half.ends() {
        return Vec::new();
    }
    let is_cut_of = |lobe: usize| {
        plan.segments
            .iter()
            .rposition(|segment| segment.lobe == Some(lobe) && matches!(segment.kind, SegmentKind::Cut(_)))
    };
    (0..plan.lobes.len()).map(is_cut_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(feedback: &[(u32, u64, f64)]) -> PlanProgress {
        let mut progress = PlanProgress::default();
        for (segment, tick, turn) in feedback {
            let feedback = ExecutePlanFeedback {
                segment: *segment,
                tick: *tick,
                turn: *turn,
                turns: if *turn > 0.0 { 3.0 } else { 0.0 },
                ..ExecutePlanFeedback::default()
            };
            progress.note(&feedback);
        }
        progress
    }

    #[test]
    fn a_lobe_is_finished_once_its_last_cut_is_over() {
        // Two lobes with their last cuts in the segments 3 and 7; a third one is not reached.
        let last_cuts = [Some(3), Some(7), Some(11)];
        let progress =
            progress(&[(0, 0, 0.0), (3, 100, 1.0), (3, 150, 2.5), (4, 200, 0.0), (7, 300, 0.5), (7, 350, 1.5)]);
        assert_eq!(progress.finished(&last_cuts, u64::MAX), (vec![0], 200));
        assert_eq!(progress.finished(&last_cuts, 199), (vec![], 0), "an alarm came before its end");
        assert_eq!(progress.finished(&[], u64::MAX), (vec![], 0), "the first half of a job finishes nothing");
    }

    #[test]
    fn a_lobe_whose_turns_are_done_is_finished_before_its_retraction() {
        let last_cuts = [Some(3), Some(7)];
        let progress = progress(&[(3, 100, 1.0), (4, 200, 0.0), (7, 300, 2.9), (7, 320, 3.0), (7, 330, 3.0)]);
        assert_eq!(progress.finished(&last_cuts, u64::MAX), (vec![0, 1], 320));
        assert_eq!(progress.finished(&[None, Some(7)], u64::MAX), (vec![1], 320), "a lobe without a cut");
    }
}
