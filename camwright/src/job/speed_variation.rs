// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Work speed that differs from turn to turn.

/// Variation of the work speed against chatter: for half of each period C turns slower than planned.
///
/// ```text
///  speed   planned ──────.         .──────.          each change takes the time of a stop, within all limits
///                         \       /        \
///           slower         '─────'          '───
///                  |<------ period ------>|          in turns of C since the cut began
/// ```
/// It scales path time, as an override does, so the path stays and every axis keeps its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedVariation {
    /// Part of the planned speed that is missing in the slower half, 0 to below 1.
    pub slower: f64,
    /// Turns of C in one period.
    pub period_turns: f64,
}

impl SpeedVariation {
    /// Speed over the planned one in the slower half.
    #[must_use]
    pub fn slow_rate(&self) -> f64 {
        1.0 - self.slower
    }

    /// Returns whether C turns slower after so many turns.
    #[must_use]
    pub fn is_slow(&self, turns: f64) -> bool {
        let periods = turns / self.period_turns;
        periods - libm::floor(periods) >= 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_each_period_is_slow() {
        let variation = SpeedVariation { slower: 0.3, period_turns: 2.5 };
        let slow = [0.0, 1.2, 1.25, 2.4, 2.5, 3.8].map(|turns| variation.is_slow(turns));
        assert_eq!(slow, [false, false, true, true, false, true]);
        assert!((variation.slow_rate() - 0.7).abs() < 1e-15);
    }
}
