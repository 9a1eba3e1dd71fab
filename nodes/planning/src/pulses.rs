// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Number and frequency of the pulses of C and X, step by step of C, for a control that moves its axes by pulses.
//!
//! A pulse is counted where a position passes the middle between two multiples of the pulse weight: the pulses of a step are the difference of
//! two rounded positions. So their sum is the rounded travel, however many steps there are.

use super::PreparedJob;
use super::error_location;
use super::finding::{Finding, warning};
use super::table::NumberTable;
use camwright::machine::description::Axis;
use camwright::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use camwright_files::pulse_file::PulseSettings;

/// Pulses of one step of C.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PulseStep {
    /// Angle of C at the end of the step (deg).
    c_deg: f64,
    /// Time since the cut began at the end of the step (s).
    t_s: f64,
    /// Time of the step (s).
    step_s: f64,
    /// Pulses of C and X, positive in the direction of the axis.
    pulses: [f64; 2],
}

impl PulseStep {
    /// Pulse frequencies of C and X (Hz).
    fn frequencies_hz(&self) -> [f64; 2] {
        self.pulses.map(|pulses| pulses.abs() / self.step_s)
    }
}

/// Steps of a pass over a lobe, from the begin of its first turn to the end of the last.
fn steps(prepared: &PreparedJob, lobe: usize, pass: usize, settings: &PulseSettings) -> Vec<PulseStep> {
    let plan = &prepared.planned.plan;
    let Some(cut) = plan.cuts_of(lobe).nth(pass) else { return Vec::new() };
    let Some(motion) = plan.motion_of(cut) else { return Vec::new() };
    let start_deg = deg_from_rad(prepared.machine.axis(Axis::C).scale.position(cut.start_counts));
    let begins_s = motion.time_of(0.0);
    let at = |step: u32| {
        let turns = f64::from(step) / f64::from(settings.steps_per_turn);
        let angle_rad = turns * TURN_RAD;
        let turned_deg = 360.0 * turns;
        let x_mm = motion.over_angle(angle_rad).value;
        let pulses = [(turned_deg / settings.c_deg).round(), (x_mm / settings.x_mm).round()];
        (start_deg + turned_deg, motion.time_of(angle_rad) - begins_s, pulses)
    };
    let count = cut.turns * settings.steps_per_turn;
    let mut before = at(0);
    let step = |number: u32| {
        let now = at(number);
        let pulses = [now.2[0] - before.2[0], now.2[1] - before.2[1]];
        let found = PulseStep { c_deg: now.0, t_s: now.1, step_s: now.1 - before.1, pulses };
        before = now;
        found
    };
    (1..=count).map(step).collect()
}

/// Table of a lobe: one row per step of every pass; angle and time are those at the end of the step.
pub(super) fn table(prepared: &PreparedJob, lobe: usize, settings: &PulseSettings) -> NumberTable {
    let passes = prepared.planned.plan.cuts_of(lobe).count();
    let rows = (0..passes).flat_map(|pass| {
        steps(prepared, lobe, pass, settings).into_iter().map(move |step| {
            let ([c, x], [c_hz, x_hz]) = (step.pulses, step.frequencies_hz());
            [(pass + 1) as f64, step.c_deg, step.t_s, step.step_s, c, x, c_hz, x_hz]
        })
    });
    let columns = [
        ("pass", ""),
        ("c_deg", "deg"),
        ("t_s", "s"),
        ("step_s", "s"),
        ("c_pulses", ""),
        ("x_pulses", ""),
        ("c_frequency_hz", "Hz"),
        ("x_frequency_hz", "Hz"),
    ];
    NumberTable::from_rows(columns, rows)
}

/// Pulse frequencies above the limit of the control, the highest of each axis.
pub(super) fn warnings(prepared: &PreparedJob) -> Vec<Finding> {
    let Some(settings) = &prepared.job.pulses else { return Vec::new() };
    let Some(max_hz) = settings.max_frequency_hz else { return Vec::new() };
    let spec = &prepared.job.spec;
    let passes = &spec.passes;
    let of_pass = |lobe: usize, pass: usize| {
        steps(prepared, lobe, pass, settings).into_iter().map(move |step| (lobe, pass, step))
    };
    let all: Vec<(usize, usize, PulseStep)> = (0..prepared.planned.lobes.len())
        .flat_map(|lobe| (0..passes.len()).filter_map(move |pass| Some((lobe, spec.pass_of(lobe, pass)?))))
        .flat_map(|(lobe, pass)| of_pass(lobe, pass))
        .collect();
    let highest = |axis: usize| {
        let hz = |found: &(usize, usize, PulseStep)| found.2.frequencies_hz()[axis];
        let highest = all.iter().max_by(|a, b| hz(a).total_cmp(&hz(b)))?;
        (hz(highest) > max_hz).then_some((highest, hz(highest)))
    };
    let weights = [("c_deg", settings.c_deg, "deg"), ("x_um", um_from_mm(settings.x_mm), "um")];
    let warn = |(axis, (key, weight, unit)): (usize, (&str, f64, &str))| {
        let ((lobe, pass, step), hz) = highest(axis)?;
        let name = &prepared.planned.lobes.get(*lobe)?.design.name;
        let joint = [Axis::C, Axis::X][axis].joint();
        let pass_name = &spec.passes_of(*lobe)[*pass].name;
        let speed = error_location::pass_key(&prepared.job, pass_name, "work_speed_rpm");
        let message = format!(
            "lobe {name}, pass {pass_name}: {joint} needs {hz:.0} pulses per second at C {:.2} deg, {:.3} s after the cut begins, above \
             pulses.max_frequency_hz {max_hz}; set pulses.{key} to {:.4} {unit} or more, or lower {speed} to {:.0} %",
            step.c_deg,
            step.t_s,
            weight * hz / max_hz,
            (100.0 * max_hz / hz).floor().max(1.0)
        );
        Some(warning(prepared.job.document.error("pulses.max_frequency_hz", message)))
    };
    weights.into_iter().enumerate().filter_map(warn).collect()
}

#[cfg(test)]
mod tests {
    use super::super::table::NumberColumn;
    use super::super::{AnyPrepared, prepare_any};

    fn prepared(set: &[&str]) -> AnyPrepared {
        let set: Vec<String> = set.iter().map(|pair| (*pair).to_owned()).collect();
        prepare_any("rough_and_finish", &set, None).expect("a plan")
    }

    #[allow(clippy::cast_possible_truncation, reason = "counts of pulses far below 2^53")]
    fn whole(pulses: f64) -> i64 {
        assert!(pulses.fract().abs() < 1e-12, "{pulses} pulses");
        pulses as i64
    }

    fn column<'a>(columns: &'a [NumberColumn], name: &str) -> &'a [f64] {
        &columns.iter().find(|column| column.name == name).expect("a column").values
    }

    /// Weights that divide neither a turn nor a step: the pulses of every axis sum to the rounded travel, and the running sum is never more
    /// than half a pulse off the position of the axis.
    #[test]
    fn pulses_sum_exactly_to_the_rounded_travel() {
        let any = prepared(&["pulses={c_deg: 0.0007, x_um: 0.3, step_deg: 0.25}"]);
        let table = any.table("I1/pulses").expect("no error").expect("the table");
        let columns = table.columns();
        let AnyPrepared::Ground(job) = &any else { panic!("a grinding job") };
        let plan = &job.planned.plan;
        for (number, cut) in plan.cuts_of(0).enumerate() {
            let motion = plan.motion_of(cut).expect("its splines");
            let of_pass: Vec<usize> = (0..columns[0].values.len())
                .filter(|row| (columns[0].values[*row] - (number + 1) as f64).abs() < 0.5)
                .collect();
            let values = |name: &str| of_pass.iter().map(|row| column(columns, name)[*row]).collect::<Vec<f64>>();
            let (c, x, step_s) = (values("c_pulses"), values("x_pulses"), values("step_s"));
            assert_eq!(of_pass.len(), 1440 * cut.turns as usize);
            assert_eq!(whole(c.iter().sum()), whole((f64::from(cut.turns) * 360.0 / 0.0007).round()));
            let x_at = |angle: f64| motion.over_angle(angle).value;
            let end_rad = f64::from(cut.turns) * std::f64::consts::TAU;
            let pulses = |mm: f64| (mm / 0.3e-3).round();
            assert_eq!(whole(x.iter().sum()), whole(pulses(x_at(end_rad)) - pulses(x_at(0.0))));
            let mut sum = pulses(x_at(0.0));
            for (step, pulses) in (1_u32..).zip(&x) {
                sum += pulses;
                let position = x_at(f64::from(step) * std::f64::consts::TAU / 1440.0) / 0.3e-3;
                assert!((sum - position).abs() <= 0.5 + 1e-6, "step {step}: {sum} pulses, X at {position}");
            }
            let cut_s = motion.time_of(end_rad) - motion.time_of(0.0);
            assert!((step_s.iter().sum::<f64>() - cut_s).abs() < 1e-9 * cut_s && step_s.iter().all(|s| *s > 0.0));
            // A number of pulses over its frequency is the time of the step, for both axes the same.
            for ((pulses, hz), step_s) in x.iter().zip(values("x_frequency_hz")).zip(&step_s) {
                assert!((pulses.abs() - hz * step_s).abs() < 1e-9);
            }
        }
    }

    /// At one work speed C turns 6 deg per second and rpm: 0.001 deg per pulse are 6000 Hz per rpm.
    #[test]
    fn a_pulse_frequency_above_the_limit_is_a_warning_with_the_weight_that_fits() {
        let law =
            ["speed={law: constant_work_speed}", "work_speed_rpm=30", "roughing.0.speed={law: constant_work_speed}"];
        let with = |pulses: &'static str| {
            let found = prepared(&[&law[..], &["roughing.0.work_speed_rpm=20", pulses]].concat());
            let AnyPrepared::Ground(job) = &found else { panic!("a grinding job") };
            super::warnings(job).iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let found = with("pulses={c_deg: 0.001, x_um: 10, max_frequency_hz: 100000}");
        assert_eq!(found.len(), 1, "{found:?}");
        for words in [
            "pass grind: c_axis needs 180000 pulses",
            "set pulses.c_deg to 0.0018 deg or more",
            "work_speed_rpm to 55 %",
        ] {
            assert!(found[0].contains(words), "{words}: {found:?}");
        }
        assert_eq!(with("pulses={c_deg: 0.001, x_um: 10, max_frequency_hz: 200000}"), Vec::<String>::new());
        assert_eq!(with("pulses={c_deg: 0.0001, x_um: 10}"), Vec::<String>::new());
    }

    #[test]
    fn without_the_key_there_is_no_table_of_pulses() {
        let any = prepared(&[]);
        assert!(any.table("I1/pulses").expect("no error").is_none());
        assert!(!any.table_names().iter().any(|name| name.ends_with("pulses")));
    }
}
