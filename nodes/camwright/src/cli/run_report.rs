// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Result of `camwright run`: verdict first, one line a lobe, then the files.

use super::batch::Batch;
use super::output::{VerdictLevel, print_verdict, say, wrapped};
use super::run_part::PartProgress;
use camwright::machine::alarm::{AlarmEntry, AlarmKind};
use camwright::math::units::{deg_from_rad, mm_from_um, um_from_mm};
use camwright_analysis::report::{BURNT, burnt};
use camwright_files::convert::{j_mm3_from_j_m3, kw_from_w, m_from_mm, mm_from_m, um_from_m as um};
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::LobeResult;
use camwright_planning::{Causes, TimeCompared, tolerance_text};
use camwright_ros::GoalStatus;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Stiffness in N/µm from N/m. The factor is that of µm and m, inverted.
fn n_um(n_m: f64) -> f64 {
    mm_from_um(m_from_mm(n_m))
}

/// A measured value, or a dash where nothing was measured.
pub(super) fn or_dash(value: f64, width: usize, digits: usize) -> String {
    if value.is_nan() { format!("{:>width$}", "-") } else { format!("{value:>width$.digits$}") }
}

/// Stiffness was measured on this journal.
fn is_measured(lobe: &LobeResult) -> bool {
    lobe.machine_stiffness > 0.0
}

/// State of a goal in words.
pub(super) const fn status_word(status: GoalStatus) -> &'static str {
    match status {
        GoalStatus::Unknown => "unknown end",
        GoalStatus::Accepted => "accepted, not started",
        GoalStatus::Executing => "still running",
        GoalStatus::Canceling => "being cancelled",
        GoalStatus::Succeeded => "complete",
        GoalStatus::Canceled => "cancelled",
        GoalStatus::Aborted => "aborted",
    }
}

/// 0: complete and good; 4: complete, but out of tolerance or burnt; 3: not complete.
pub(super) fn exit_code(status: GoalStatus, is_good: bool) -> ExitCode {
    match status {
        GoalStatus::Succeeded if is_good => ExitCode::SUCCESS,
        GoalStatus::Succeeded => ExitCode::from(4),
        _ => ExitCode::from(3),
    }
}

/// Largest form error of each lobe (µm).
fn errors_um(lobes: &[LobeResult]) -> serde_json::Value {
    lobes.iter().map(|lobe| um(lobe.form_error_max)).collect::<Vec<f64>>().into()
}

/// Files of a run.
#[derive(Debug, Clone, Default)]
pub(super) struct RunFiles {
    /// The bag, if this process recorded one.
    pub(super) bag: Option<PathBuf>,
    /// The HTML report, if it was written.
    pub(super) report: Option<PathBuf>,
}

impl RunFiles {
    pub(super) fn print(&self) {
        for (name, path) in [("bag:", &self.bag), ("report:", &self.report)] {
            if let Some(path) = path {
                say!("{name:<7} {}", path.display());
            }
        }
    }
}

/// Prints the verdict of a run.
pub(super) fn print_run_verdict(verdict: &str, is_good: bool) {
    print_verdict(if is_good { VerdictLevel::Good } else { VerdictLevel::Bad }, &wrapped(verdict, 2));
}

/// Result of a grinding job.
pub(super) struct Report<'a> {
    pub(super) job: &'a str,
    /// True for a job without a cut.
    pub(super) dry_run: bool,
    pub(super) status: GoalStatus,
    pub(super) result: &'a RunJobResult,
    /// Every lobe, the rest, the job; empty if the predicted times are unknown.
    pub(super) times: Vec<TimeCompared>,
    /// Form errors of the same job on other machines.
    pub(super) causes: Causes,
    /// All parts of a batch; every other field is about the last part.
    pub(super) batch: Option<Batch>,
    /// State of the part if the job is not complete.
    pub(super) part: PartProgress,
    pub(super) files: RunFiles,
    pub(super) took: Duration,
    /// True if the job only measured stiffness.
    pub(super) identifies: bool,
}

impl Report<'_> {
    fn time(&self, what: &str) -> Option<&TimeCompared> {
        self.times.iter().find(|time| time.what == what)
    }

    fn worst(&self) -> Option<&LobeResult> {
        let used = |lobe: &LobeResult| lobe.form_error_max.abs() / lobe.form_error_allowed;
        self.result.lobes.iter().max_by(|a, b| used(a).total_cmp(&used(b)))
    }

    /// In tolerance, and not burnt.
    pub(super) fn is_good(&self) -> bool {
        self.has_good_form() && burnt(&self.result.lobes).is_none()
    }

    fn has_good_form(&self) -> bool {
        if self.identifies {
            let measured = self.result.lobes.iter().all(is_measured);
            return self.is_complete() && measured;
        }
        self.is_complete()
            && self.batch.as_ref().is_none_or(Batch::is_good)
            && (self.dry_run || self.worst().is_some_and(|lobe| lobe.form_error_max.abs() <= lobe.form_error_allowed))
    }

    pub(super) fn exit_code(&self) -> ExitCode {
        exit_code(self.status, self.is_good())
    }

    /// Prints the verdict, one line a lobe, the files and the next step; with `details` everything else between.
    pub(super) fn print(&self, details: bool) {
        print_run_verdict(&self.verdict(), self.is_good());
        self.print_lobes();
        self.print_stiffness();
        if let Some(batch) = &self.batch {
            batch.print(details);
        }
        if !self.result.message.is_empty() {
            say!("{}", wrapped(&format!("{}: {}", self.job, self.result.message), 2));
        }
        if details {
            self.print_details();
        }
        self.print_causes();
        if !self.is_complete() && !self.dry_run {
            say!("{}", wrapped(&format!("part:   {}", self.part.text()), 8));
        }
        self.files.print();
        self.print_next_step(details);
    }

    /// Table of the lobes.
    fn print_lobes(&self) {
        let lobes: Vec<&LobeResult> =
            self.result.lobes.iter().filter(|lobe| !self.identifies || !is_measured(lobe)).collect();
        let width = lobes.iter().map(|lobe| lobe.name.chars().count()).max().unwrap_or(0).max(5);
        if !lobes.is_empty() {
            say!("{:<width$}  form error max           rms        lift p-v   time     burn index", "lobe");
        }
        for lobe in lobes {
            say!(
                "{:<width$} {:>+7.3} um at {:>5.1} deg  {:>6.3} um  {} um  {:>6.2} s  {}",
                lobe.name,
                um(lobe.form_error_max),
                deg_from_rad(lobe.form_error_max_angle),
                um(lobe.form_error_rms),
                or_dash(um(lobe.lift_error), 6, 3),
                lobe.duration,
                or_dash(lobe.burn_index_max, 9, 2),
            );
        }
    }

    /// Measured stiffness of machine and cut at each journal.
    fn print_stiffness(&self) {
        let journals: Vec<&LobeResult> = self.result.lobes.iter().filter(|lobe| is_measured(lobe)).collect();
        let width = journals.iter().map(|lobe| lobe.name.chars().count()).max().unwrap_or(0).max(7);
        if !journals.is_empty() {
            say!("{:<width$}  machine N/um      grinding N/um   threshold N   stiffness ratio", "journal");
        }
        for lobe in journals {
            say!(
                "{:<width$} {:>6.3} +- {:.3}  {:>6.1} +- {:.1}  {:>6.0} +- {:.0}  {:>8.4} +- {:.4}",
                lobe.name,
                n_um(lobe.machine_stiffness),
                n_um(lobe.machine_stiffness_uncertainty),
                n_um(lobe.grinding_stiffness),
                n_um(lobe.grinding_stiffness_uncertainty),
                lobe.threshold_force,
                lobe.threshold_force_uncertainty,
                lobe.stiffness_ratio,
                lobe.stiffness_ratio_uncertainty,
            );
        }
    }

    fn print_details(&self) {
        say!("");
        self.print_times();
        self.print_power();
        self.print_runout();
        say!("");
    }

    /// Station, start angle, and actual and predicted time of each lobe and of everything between them.
    fn print_times(&self) {
        if !self.times.is_empty() {
            say!("time               actual   predicted    late   station   start      turns");
        }
        for (index, time) in self.times.iter().enumerate() {
            let lobe = self.result.lobes.get(index).map_or_else(String::new, |lobe| {
                format!("   {:<8} {:>5.1} deg  {:>5.1}", lobe.station, deg_from_rad(lobe.start_angle), lobe.turns)
            });
            say!(
                "{:<17} {:>6.2} s  {:>8.2} s {:>+6.2} s{lobe}",
                time.what,
                time.actual_s,
                time.predicted_s,
                time.late_s()
            );
        }
        say!("computing time     {:.1} s", self.took.as_secs_f64());
    }

    /// Peak power of the wheel and burn index of each lobe.
    fn print_power(&self) {
        let lobes: Vec<&LobeResult> = self.result.lobes.iter().filter(|lobe| lobe.power_max > 0.0).collect();
        if !lobes.is_empty() {
            say!("\npower   peak             energy       burn index (burnt above 1)");
        }
        for lobe in lobes {
            say!(
                "{:<5} {:>5.1} kW at {:>3.0} deg  {:>3.0} J/mm3  {:>6.2} at {:>3.0} deg",
                lobe.name,
                kw_from_w(lobe.power_max),
                deg_from_rad(lobe.power_max_angle),
                j_mm3_from_j_m3(lobe.specific_energy),
                lobe.burn_index_max,
                deg_from_rad(lobe.burn_index_max_angle),
            );
        }
    }

    /// Runout of each journal before and after its correction.
    fn print_runout(&self) {
        let journals: Vec<&LobeResult> = self.result.lobes.iter().filter(|lobe| lobe.runout_before > 0.0).collect();
        if !journals.is_empty() {
            say!("\nrunout   measured   expected (95 % below)   after the correction   spark-out turns");
        }
        for lobe in journals {
            let expected = if lobe.runout_limit > 0.0 {
                format!("{:.2} ({:.2}) um", um(lobe.runout_expected), um(lobe.runout_limit))
            } else {
                "not known".to_owned()
            };
            say!(
                "{:<5} {:>8.2} um {expected:>23} {:>19.3} um {}",
                lobe.name,
                um(lobe.runout_before),
                um(lobe.runout),
                or_dash(lobe.spark_out_turns.ceil(), 17, 0),
            );
        }
    }

    /// Breaks the form error down by cause: errors of the same job with one effect removed, or on a better machine.
    fn print_causes(&self) {
        let line = |name: &str, lobes: &[LobeResult]| {
            let error = |lobe: &LobeResult| {
                let [max, rms, lift] = [lobe.form_error_max, lobe.form_error_rms, lobe.lift_error].map(um);
                format!("{} {max:+.3} ({rms:.3}, {})", lobe.name, or_dash(lift, 0, 3))
            };
            say!("  {name}");
            say!("{}", wrapped(&format!("    {}", lobes.iter().map(error).collect::<Vec<_>>().join(", ")), 4));
        };
        if !self.causes.without.is_empty() {
            say!("\nform error max in um (rms, lift p-v) of the same job simulated without:");
        }
        for without in &self.causes.without {
            line(&without.name(), &without.lobes);
        }
        if !self.causes.with.is_empty() {
            say!("\nform error max in um (rms, lift p-v) of the same job simulated with:");
            line("ordinary drives", &self.result.lobes);
        }
        for with in &self.causes.with {
            line(with.name, &with.lobes);
        }
    }

    /// The effect without which the worst form error is smallest.
    fn largest_cause(&self) -> Option<String> {
        let largest = |lobes: &[LobeResult]| lobes.iter().map(|lobe| um(lobe.form_error_max.abs())).fold(0.0, f64::max);
        let single = self.causes.without.iter().filter(|without| without.effects.len() == 1);
        let (without, left_um) = single
            .map(|without| (without, largest(&without.lobes)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, left_um)| *left_um < largest(&self.result.lobes))?;
        Some(format!("cause:  {}; without it the worst form error is {left_um:.3} um", without.name()))
    }

    /// The next step after an alarm: its remedy, unless the message has it, and the reset of a cell that goes on running.
    fn next_after_stop(&self, see: &str) -> String {
        let Some(kind) = AlarmKind::from_number(self.result.alarm) else {
            return format!("next:   {see}; `camwright list alarms` lists all alarms with remedies");
        };
        let AlarmEntry { number, name, remedy, .. } = kind.entry();
        let remedy = Some(remedy).filter(|remedy| !self.result.message.contains(remedy));
        let reset = self.files.bag.is_none().then_some("`camwright reset` clears it");
        let steps: Vec<&str> = [remedy, reset, Some(see)].into_iter().flatten().collect();
        format!("next:   alarm {number}, {name}: {}", steps.join("; "))
    }

    /// The next step after a bad verdict.
    fn print_next_step(&self, details: bool) {
        if self.is_good() {
            return;
        }
        let see = match (&self.files.report, details) {
            (Some(_), _) => "open the report",
            (None, false) => "run again with --details",
            (None, true) => "see the alarms in `camwright status`",
        };
        let next = if self.status == GoalStatus::Canceled {
            self.next_after_cancel()
        } else if !self.is_complete() {
            self.next_after_stop(see)
        } else if !self.has_good_form() {
            if let Some(cause) = self.largest_cause() {
                say!("{}", wrapped(&cause, 8));
            }
            let simulated = match self.causes.without.is_empty() {
                true => "; `camwright run --causes` simulates the job without each effect of the machine",
                false => "",
            };
            format!("next:   {see} for the causes of the form error{simulated}")
        } else {
            format!("next:   {see}, then reduce the infeed per turn or work_speed_rpm")
        };
        say!("{}", wrapped(&next, 8));
    }

    fn is_complete(&self) -> bool {
        self.status == GoalStatus::Succeeded
    }

    /// The next step after a cancelled job. The part of an own cell has gone with its simulated machine.
    fn next_after_cancel(&self) -> String {
        let job = self.job;
        match self.part.next_lobe() {
            Some(lobe) if self.files.bag.is_none() => {
                format!("next:   `camwright run {job} --attach --start-at {lobe}` continues on this part")
            }
            _ if self.files.bag.is_none() => format!("next:   `camwright run {job} --attach` begins again"),
            _ => format!("next:   `camwright run {job}` begins a new part; the cell of this run has ended"),
        }
    }

    fn verdict(&self) -> String {
        if self.status != GoalStatus::Succeeded {
            return format!("NOT COMPLETE: {}, {}", self.job, status_word(self.status));
        }
        let Some(worst) = self.worst() else {
            return match self.dry_run {
                true => format!("DRY RUN COMPLETE: {}, nothing was cut", self.job),
                false => format!("NOT COMPLETE: {}, no lobe was measured", self.job),
            };
        };
        if self.identifies {
            let measured = self.result.lobes.iter().filter(|lobe| is_measured(lobe)).count();
            let word = if self.is_good() { "MEASURED" } else { "NOT MEASURED" };
            return format!("{word}: stiffness at {measured} of {} journals", self.result.lobes.len());
        }
        let word = match (self.has_good_form(), burnt(&self.result.lobes)) {
            (true, None) => "GOOD",
            (true, Some(lobe)) => {
                return format!(
                    "{BURNT}: lobe {}, burn index {:.2} at {:.1} deg (limit 1)",
                    lobe.name,
                    lobe.burn_index_max,
                    deg_from_rad(lobe.burn_index_max_angle)
                );
            }
            (false, _) => "NOT GOOD",
        };
        if let Some((part, lobe)) = self.batch.as_ref().and_then(Batch::worst) {
            return format!(
                "{word}: worst form error {:+.3} um on lobe {} of part {part} (tolerance {} um)",
                um_from_mm(lobe.form_mm),
                lobe.name,
                tolerance_text(lobe.allowed_mm)
            );
        }
        format!(
            "{word}: worst form error {:+.3} um on lobe {} at {:.1} deg (tolerance {} um)",
            um(worst.form_error_max),
            worst.name,
            deg_from_rad(worst.form_error_max_angle),
            tolerance_text(mm_from_m(worst.form_error_allowed)),
        )
    }

    /// Measured taper and crown of a lobe that has them; `null` of any other.
    fn shape_json(&self, lobe: &str) -> Option<serde_json::Value> {
        let shape = self.result.shapes.iter().find(|shape| shape.name == lobe)?;
        Some(serde_json::json!({
            "taper_um": um(shape.taper),
            "taper_design_um": um(shape.taper_design),
            "crown_um": um(shape.crown),
            "crown_design_um": um(shape.crown_design),
            "form_error_of_sections_um": shape.form_error.iter().map(|error| um(*error)).collect::<Vec<_>>(),
        }))
    }

    pub(super) fn print_json(&self) {
        let lobes: Vec<serde_json::Value> = self
            .result
            .lobes
            .iter()
            .map(|lobe| {
                serde_json::json!({
                    "name": lobe.name,
                    "station": lobe.station,
                    "start_deg": deg_from_rad(lobe.start_angle),
                    "turns": lobe.turns,
                    "duration_s": lobe.duration,
                    "predicted_s": self.time(&lobe.name).map(|time| time.predicted_s),
                    "form_error_max_um": um(lobe.form_error_max),
                    "form_error_max_deg": deg_from_rad(lobe.form_error_max_angle),
                    "form_error_allowed_um": um(lobe.form_error_allowed),
                    "form_error_rms_um": um(lobe.form_error_rms),
                    "lift_error_pv_um": um(lobe.lift_error),
                    "runout_um": um(lobe.runout),
                    "runout_before_um": um(lobe.runout_before),
                    "runout_expected_um": um(lobe.runout_expected),
                    "runout_limit_um": um(lobe.runout_limit),
                    "spark_out_turns": lobe.spark_out_turns,
                    "power_max_w": lobe.power_max,
                    "power_max_deg": deg_from_rad(lobe.power_max_angle),
                    "specific_energy_j_mm3": j_mm3_from_j_m3(lobe.specific_energy),
                    "burn_index_max": lobe.burn_index_max,
                    "burn_index_max_deg": deg_from_rad(lobe.burn_index_max_angle),
                    "shape": self.shape_json(&lobe.name),
                    "machine_stiffness_n_um": n_um(lobe.machine_stiffness),
                    "machine_stiffness_uncertainty_n_um": n_um(lobe.machine_stiffness_uncertainty),
                    "grinding_stiffness_n_um": n_um(lobe.grinding_stiffness),
                    "grinding_stiffness_uncertainty_n_um": n_um(lobe.grinding_stiffness_uncertainty),
                    "threshold_force_n": lobe.threshold_force,
                    "threshold_force_uncertainty_n": lobe.threshold_force_uncertainty,
                })
            })
            .collect();
        let report = serde_json::json!({
            "job": self.job,
            "good": self.is_good(),
            "dry_run": self.dry_run,
            "status": format!("{:?}", self.status),
            "message": self.result.message,
            "alarm": self.result.alarm,
            "plan_hash": self.result.plan_hash,
            "first_tick": self.result.first_tick,
            "last_tick": self.result.last_tick,
            "duration_s": self.result.duration,
            "predicted_s": self.time("job").map(|time| time.predicted_s),
            "duration_with_indexing_s": self.result.duration_with_indexing,
            "bag": self.files.bag,
            "report": self.files.report,
            "part": (!self.is_complete()).then(|| self.part.json()),
            "took_s": self.took.as_secs_f64(),
            "lobes": lobes,
            "batch": self.batch.as_ref().map(Batch::json),
            "form_error_max_um_without": self.causes.without.iter().map(|without| {
                (without.name(), errors_um(&without.lobes))
            }).collect::<serde_json::Map<String, serde_json::Value>>(),
            "form_error_max_um_with": self.causes.with.iter().map(|with| {
                (with.name.to_owned(), errors_um(&with.lobes))
            }).collect::<serde_json::Map<String, serde_json::Value>>(),
        });
        say!("{report}");
    }
}
