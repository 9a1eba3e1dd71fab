// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! When each lobe of a job that runs began and ended.

/// First and last tick of each lobe, as the interpolator reported them.
#[derive(Debug, Default)]
pub(super) struct LobeTicks {
    current: Option<usize>,
    spans: Vec<(u64, Option<u64>)>,
    /// Duration of the lobes in the previous half (ticks).
    before: Vec<u64>,
}

impl LobeTicks {
    /// The lobes come once more: the half before is over.
    pub(super) fn next_half(&mut self) {
        let last = self.spans.iter().filter_map(|(_, end)| *end).max().unwrap_or_default();
        self.before = (0..self.spans.len()).filter_map(|lobe| self.first_tick(lobe, last)).collect();
        (self.current, self.spans) = (None, Vec::new());
    }

    pub(super) fn note(&mut self, lobe: Option<usize>, tick: u64) {
        if lobe == self.current {
            return;
        }
        if let Some(span) = self.current.and_then(|index| self.spans.get_mut(index)) {
            span.1 = Some(tick);
        }
        // Lobes come in the order of the plan; one that is missed leaves those after it without a time.
        if lobe == Some(self.spans.len()) {
            self.spans.push((tick, None));
        }
        self.current = lobe;
    }

    /// Ticks of a lobe; the last one may end with the job.
    pub(super) fn first_tick(&self, lobe: usize, last_tick: u64) -> Option<u64> {
        let (begin, end) = self.spans.get(lobe)?;
        let before = self.before.get(lobe).copied().unwrap_or_default();
        Some(before + end.unwrap_or(last_tick).saturating_sub(*begin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lobe_lasts_from_its_first_tick_to_the_next_one_that_is_not_its() {
        let mut ticks = LobeTicks::default();
        for (lobe, tick) in [(None, 0), (Some(0), 100), (Some(0), 150), (Some(1), 300), (None, 450), (None, 500)] {
            ticks.note(lobe, tick);
        }
        assert_eq!(
            (ticks.first_tick(0, 600), ticks.first_tick(1, 600), ticks.first_tick(2, 600)),
            (Some(200), Some(150), None)
        );
    }

    #[test]
    fn a_lobe_that_comes_twice_lasts_as_long_as_both_times() {
        let mut ticks = LobeTicks::default();
        for (lobe, tick) in [(None, 0), (Some(0), 100), (Some(1), 300), (None, 450)] {
            ticks.note(lobe, tick);
        }
        ticks.next_half();
        for (lobe, tick) in [(Some(0), 1000), (Some(1), 1040), (None, 1090)] {
            ticks.note(lobe, tick);
        }
        assert_eq!((ticks.first_tick(0, 1100), ticks.first_tick(1, 1100)), (Some(240), Some(200)));
    }

    #[test]
    fn the_last_lobe_may_end_with_the_job() {
        let mut ticks = LobeTicks::default();
        ticks.note(Some(0), 10);
        assert_eq!(ticks.first_tick(0, 60), Some(50));
    }
}
