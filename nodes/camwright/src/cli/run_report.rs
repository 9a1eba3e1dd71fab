//! What `camwright run` says at its end.

use super::batch::Batch;
use super::output::say;
use camwright::math::units::{deg_from_rad, mm_from_um, um_from_mm};
use camwright_analysis::report::{BURNT, burnt};
use camwright_files::convert::{j_mm3_from_j_m3, m_from_mm, mm_from_m, um_from_m as um};
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::LobeResult;
use camwright_planning::{Causes, FORM_TOLERANCE_MM, TimeCompared};
use camwright_ros::GoalStatus;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// A stiffness for people (N/µm) from a message (N/m): they differ as µm and m do, the other way round.
fn n_um(n_m: f64) -> f64 {
    mm_from_um(m_from_mm(n_m))
}

/// The state of a goal for people.
pub(super) const fn status_word(status: GoalStatus) -> &'static str {
    match status {
        GoalStatus::Unknown => "its end is not known",
        GoalStatus::Accepted => "accepted, not begun",
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

/// A predicted time with what came on top of it.
fn predicted(time: &TimeCompared) -> String {
    format!("{:.2} s {:+.2} s", time.predicted_s, time.late_s())
}

/// The largest form error of each lobe (µm).
fn errors_um(lobes: &[LobeResult]) -> serde_json::Value {
    lobes.iter().map(|lobe| um(lobe.form_error_max)).collect::<Vec<f64>>().into()
}

/// What is printed at the end.
pub(super) struct Report<'a> {
    pub(super) job: &'a str,
    /// Nothing was to be cut.
    pub(super) dry_run: bool,
    pub(super) status: GoalStatus,
    pub(super) result: &'a RunJobResult,
    /// Every lobe, the rest, the job; empty where what was predicted is not known here.
    pub(super) times: Vec<TimeCompared>,
    /// What the same job leaves on other machines.
    pub(super) causes: Causes,
    /// All parts, where there were several; everything else is about the last one.
    pub(super) batch: Option<Batch>,
    pub(super) bag: Option<&'a PathBuf>,
    /// The page that reports it.
    pub(super) page: Option<PathBuf>,
    pub(super) took: Duration,
    /// Stiffness was measured and no more.
    pub(super) identifies: bool,
}

impl Report<'_> {
    fn time(&self, what: &str) -> Option<&TimeCompared> {
        self.times.iter().find(|time| time.what == what)
    }

    fn worst(&self) -> Option<&LobeResult> {
        self.result.lobes.iter().max_by(|a, b| a.form_error_max.abs().total_cmp(&b.form_error_max.abs()))
    }

    /// In tolerance, and not burnt.
    fn is_good(&self) -> bool {
        self.has_good_form() && burnt(&self.result.lobes).is_none()
    }

    fn has_good_form(&self) -> bool {
        if self.identifies {
            let measured = self.result.lobes.iter().all(|lobe| lobe.machine_stiffness > 0.0);
            return self.status == GoalStatus::Succeeded && self.result.success && measured;
        }
        self.status == GoalStatus::Succeeded
            && self.result.success
            && self.batch.as_ref().is_none_or(Batch::is_good)
            && (self.dry_run
                || self.worst().is_some_and(|lobe| mm_from_m(lobe.form_error_max.abs()) <= FORM_TOLERANCE_MM))
    }

    pub(super) fn exit_code(&self) -> ExitCode {
        exit_code(self.status, self.is_good())
    }

    pub(super) fn print(&self) {
        self.print_form();
        self.print_power();
        self.print_stiffness();
        self.print_runout();
        self.print_times();
        self.print_causes();
        if let Some(batch) = &self.batch {
            batch.print();
        }
        self.print_machine_time();
        if !self.result.message.is_empty() {
            say!("{}", self.result.message);
        }
        self.print_files();
        say!("{}", self.verdict());
    }

    /// Table of the lobes.
    fn print_form(&self) {
        if !self.result.lobes.is_empty() {
            say!(
                "lobe  station  start      turns   time     predicted         form error max          rms       lift p-v"
            );
        }
        for lobe in &self.result.lobes {
            say!(
                "{:<5} {:<8} {:>5.1} deg  {:>5.1}  {:>6.2} s {:>18}  {:>+7.3} um at {:>5.1} deg  {:>6.3} um  {:>6.3} um",
                lobe.name,
                lobe.station,
                deg_from_rad(lobe.start_angle),
                lobe.turns,
                lobe.duration,
                self.time(&lobe.name).map_or_else(String::new, predicted),
                um(lobe.form_error_max),
                deg_from_rad(lobe.form_error_max_angle),
                um(lobe.form_error_rms),
                um(lobe.lift_error),
            );
        }
    }

    /// Peak power of the wheel and burn index of each lobe.
    fn print_power(&self) {
        for lobe in self.result.lobes.iter().filter(|lobe| lobe.power_max > 0.0) {
            say!(
                "{:<5} took {:.0} W at most, {:.0} J/mm3, at {:.0} deg; hottest at {:.0} deg, {:.2} of what burns",
                lobe.name,
                lobe.power_max,
                j_mm3_from_j_m3(lobe.specific_energy),
                deg_from_rad(lobe.power_max_angle),
                deg_from_rad(lobe.burn_index_max_angle),
                lobe.burn_index_max,
            );
        }
    }

    /// Measured stiffness of machine and cut at each journal.
    fn print_stiffness(&self) {
        for lobe in self.result.lobes.iter().filter(|lobe| lobe.machine_stiffness > 0.0) {
            say!(
                "{:<5} machine {:.3} +- {:.3} N/um, grinding {:.1} +- {:.1} N/um and {:.0} +- {:.0} N to begin, their ratio {:.4} +- {:.4} by the \
                 decay of the dwell",
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

    /// Runout of each journal before and after its correction.
    fn print_runout(&self) {
        for lobe in self.result.lobes.iter().filter(|lobe| lobe.runout_before > 0.0) {
            say!(
                "{:<5} ran out by {:.2} um when it was measured; one turn left {:.3} um, sparking out would have taken {:.0} turns",
                lobe.name,
                um(lobe.runout_before),
                um(lobe.runout),
                lobe.spark_out_turns.ceil(),
            );
        }
    }

    /// Actual and predicted time of everything between the lobes.
    fn print_times(&self) {
        for time in self.times.iter().skip(self.result.lobes.len()) {
            say!("{:<32} {:>6.2} s {:>18}", time.what, time.actual_s, predicted(time));
        }
    }

    /// Machine time, and the time saved over rotary indexing.
    fn print_machine_time(&self) {
        let result = self.result;
        if result.duration > 0.0 {
            say!(
                "machine time {:.2} s; with rotary indexing before each lobe {:.2} s, saved {:.2} s; took {:.1} s",
                result.duration,
                result.duration_with_indexing,
                result.duration_with_indexing - result.duration,
                self.took.as_secs_f64(),
            );
        }
    }

    /// Paths of the bag and the report.
    fn print_files(&self) {
        if let Some(bag) = self.bag {
            say!("bag: {}", bag.display());
        }
        if let Some(page) = &self.page {
            say!("report: {}", page.display());
        }
    }

    /// Breaks the form error down by cause: errors of the same job with one effect removed, or on a better machine.
    fn print_causes(&self) {
        let line = |name: &str, lobes: &[LobeResult]| {
            let error = |lobe: &LobeResult| {
                let [max, rms, lift] = [lobe.form_error_max, lobe.form_error_rms, lobe.lift_error].map(um);
                format!("{} {max:+.3} um ({rms:.3}, {lift:.3})", lobe.name)
            };
            say!("  {name:<34} {}", lobes.iter().map(error).collect::<Vec<_>>().join(", "));
        };
        if !self.causes.without.is_empty() {
            say!("form error max of the same job on a simulated machine without (in brackets rms, and lift p-v):");
        }
        for without in &self.causes.without {
            line(&without.name(), &without.lobes);
        }
        if !self.causes.with.is_empty() {
            say!("form error max of the same job (in brackets rms, and lift p-v) with:");
            line("ordinary drives", &self.result.lobes);
        }
        for with in &self.causes.with {
            line(with.name, &with.lobes);
        }
    }

    fn verdict(&self) -> String {
        match (self.worst(), self.status) {
            (Some(_), GoalStatus::Succeeded) if self.identifies => format!(
                "{}: {}, stiffness at {} of {} journals",
                if self.is_good() { "MEASURED" } else { "NOT MEASURED" },
                self.job,
                self.result.lobes.iter().filter(|lobe| lobe.machine_stiffness > 0.0).count(),
                self.result.lobes.len(),
            ),
            (Some(worst), GoalStatus::Succeeded) => format!(
                "{}: {}, worst form error {:.3} um on lobe {} (tolerance {} um)",
                match (self.has_good_form(), burnt(&self.result.lobes)) {
                    (true, None) => "GOOD",
                    (true, Some(_)) => BURNT,
                    (false, _) => "NOT GOOD",
                },
                self.job,
                um(worst.form_error_max.abs()),
                worst.name,
                um_from_mm(FORM_TOLERANCE_MM),
            ),
            (None, GoalStatus::Succeeded) if self.dry_run => {
                format!("DRY RUN COMPLETE: {}, nothing was cut", self.job)
            }
            _ => format!("NOT COMPLETE: {}, {}", self.job, status_word(self.status)),
        }
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
                    "form_error_rms_um": um(lobe.form_error_rms),
                    "lift_error_pv_um": um(lobe.lift_error),
                    "runout_um": um(lobe.runout),
                    "runout_before_um": um(lobe.runout_before),
                    "spark_out_turns": lobe.spark_out_turns,
                    "power_max_w": lobe.power_max,
                    "power_max_deg": deg_from_rad(lobe.power_max_angle),
                    "specific_energy_j_mm3": j_mm3_from_j_m3(lobe.specific_energy),
                    "burn_index_max": lobe.burn_index_max,
                    "burn_index_max_deg": deg_from_rad(lobe.burn_index_max_angle),
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
            "bag": self.bag,
            "report": self.page,
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
