// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The time that was predicted before anything moved against the time that the machine took.

use super::{PreparedJob, lobe_times_s};
use camwright_msgs::camwright_msgs::msg::LobeResult;
use serde::Serialize;
use std::fmt;

/// One predicted time, and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeCompared {
    /// A lobe by its name, `outside the lobes`, or `job`.
    pub what: String,
    /// Before anything moved (s).
    pub predicted_s: f64,
    /// Actual time by the machine's ticks (s).
    pub actual_s: f64,
}

impl TimeCompared {
    /// Delay against the prediction (s).
    #[must_use]
    pub fn late_s(&self) -> f64 {
        self.actual_s - self.predicted_s
    }
}

impl fmt::Display for TimeCompared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:.3} s, predicted {:.3} s ({:+.3} s)", self.what, self.actual_s, self.predicted_s, self.late_s())
    }
}

/// Every lobe that was ground, then what lies outside the lobes, then the job. Searches differ: they end at an edge, and a plan
/// does not know where; the origin of C is predicted half a turn away. So does what an operator held or slowed down.
#[must_use]
pub fn compare_times(prepared: &PreparedJob, lobes: &[LobeResult], duration_s: f64) -> Vec<TimeCompared> {
    let of_visits_s = lobe_times_s(prepared);
    let mut times: Vec<TimeCompared> = prepared
        .finished_lobes()
        .filter_map(|(index, lobe)| {
            let name = &lobe.design.name;
            let visits = prepared.job.spec.visits_of(index);
            let predicted_s = visits.iter().filter_map(|visit| of_visits_s.get(*visit)).sum();
            let actual_s = lobes.iter().find(|lobe| lobe.name == *name)?.duration;
            Some(TimeCompared { what: name.clone(), predicted_s, actual_s })
        })
        .collect();
    let in_lobes = |of: fn(&TimeCompared) -> f64| times.iter().map(of).sum::<f64>();
    let predicted_s = prepared.duration_s();
    let outside = TimeCompared {
        what: "outside the lobes".into(),
        predicted_s: predicted_s - in_lobes(|time| time.predicted_s),
        actual_s: duration_s - in_lobes(|time| time.actual_s),
    };
    times.push(outside);
    times.push(TimeCompared { what: "job".into(), predicted_s, actual_s: duration_s });
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{prepare, simulate_job};

    #[test]
    fn what_lies_outside_the_lobes_is_the_rest_of_the_job() {
        let prepared = prepare("four_lobe_camshaft", &[], None).unwrap();
        let predicted = lobe_times_s(&prepared);
        let lobes: Vec<LobeResult> = (prepared.planned.plan.lobes.iter().zip(&predicted))
            .map(|(name, time)| LobeResult { name: name.clone(), duration: time + 0.25, ..LobeResult::default() })
            .collect();
        let times = compare_times(&prepared, &lobes, prepared.planned.plan.duration_s + 3.0);
        let late: Vec<f64> = times.iter().map(TimeCompared::late_s).collect();
        for (late, expected) in late.iter().zip([0.25, 0.25, 0.25, 0.25, 2.0, 3.0]) {
            assert!((late - expected).abs() < 1e-9, "{times:?}");
        }
        assert_eq!(times.len(), 6);
        let text = times[5].to_string();
        assert!(text.starts_with("job ") && text.ends_with("(+3.000 s)"), "{text}");
    }

    /// Predictions cannot foresee when a switch trips. This machine wakes up with C at 137.25°, so its origin lies 222.75° ahead and
    /// not half a turn: 42.75° at 20 rpm. The switch of each station is reported some ticks after it closes.
    #[test]
    fn a_job_takes_as_long_as_predicted_but_for_its_searches() {
        for job in ["four_lobe_camshaft", "rough_and_finish"] {
            let prepared = prepare(job, &[], None).unwrap();
            let (simulated, _) = simulate_job(&prepared, &[], |_, _| {}).unwrap();
            let actual_s = (simulated.last_tick - simulated.first_tick) as f64 * prepared.machine.cycle_time_s();
            let rest_s = actual_s - prepared.planned.plan.duration_s - 42.75 / 120.0;
            assert!((0.0..0.06).contains(&rest_s), "{job}: {rest_s} s");
        }
    }
}
