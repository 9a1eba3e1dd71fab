// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Result of `camwright run` for a turning job.

use super::output::{say, wrapped};
use super::run_report::{RunFiles, exit_code, or_dash, print_run_verdict, status_word};
use camwright::math::units::{deg_from_rad, um_from_mm};
use camwright_files::convert::{mm_from_m, um_from_m as um};
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::{FormMap, TurnedResult};
use camwright_planning::OtherLathe;
use camwright_ros::GoalStatus;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Duration;

/// Fields of the printed map, around and along the part.
const PRINTED: [usize; 2] = [8, 10];

/// Result of a turning job.
pub(super) struct TurnedReport<'a> {
    pub(super) job: &'a str,
    pub(super) status: GoalStatus,
    pub(super) result: &'a RunJobResult,
    /// Predicted duration (s), if known.
    pub(super) predicted_s: Option<f64>,
    pub(super) form_map: Option<FormMap>,
    /// Form errors of the same job on other machines.
    pub(super) causes: Vec<OtherLathe>,
    pub(super) files: RunFiles,
    pub(super) took: Duration,
}

impl TurnedReport<'_> {
    fn part(&self) -> Option<&TurnedResult> {
        self.result.turned.first()
    }

    fn is_good(&self) -> bool {
        self.status == GoalStatus::Succeeded
            && self.part().is_some_and(|part| part.form_error_max.abs() <= part.form_error_allowed)
    }

    pub(super) fn exit_code(&self) -> ExitCode {
        exit_code(self.status, self.is_good())
    }

    /// Prints the verdict, the part, the files and the next step; with `details` the map.
    pub(super) fn print(&self, details: bool) {
        let result = self.result;
        print_run_verdict(&self.verdict(), self.is_good());
        if let Some(part) = self.part() {
            say!("part         passes   turns       time     highest      lowest         rms");
            say!(
                "{:<12} {:>6} {:>7.1} {:>8.2} s {:>+8.3} um {:>+8.3} um {:>8.3} um",
                part.name,
                part.passes,
                part.turns,
                part.duration,
                um(part.form_error_highest),
                um(part.form_error_lowest),
                um(part.form_error_rms),
            );
        }
        if !result.message.is_empty() {
            say!("{}", wrapped(&format!("{}: {}", self.job, result.message), 2));
        }
        if details {
            self.print_details();
        }
        self.print_causes();
        if self.status == GoalStatus::Canceled {
            say!("part:   unfinished; its last pass is not complete");
        }
        self.files.print();
        if self.status == GoalStatus::Canceled {
            say!("next:   `camwright run {}` begins a new part", self.job);
        } else if !self.is_good() {
            let see = if self.files.report.is_some() { "open the report" } else { "run again with --details" };
            say!("next:   {see} for the worst position and its cause");
        }
    }

    fn print_details(&self) {
        say!("");
        if let Some(part) = self.part() {
            let allowed = part.form_error_allowed - part.cusp_height_theory;
            say!(
                "allowed {:.3} um: tolerance {:.3} um and cusps of the feed {:.3} um\ncusps  {} um",
                um(part.form_error_allowed),
                um(allowed),
                um(part.cusp_height_theory),
                or_dash(um(part.cusp_height), 0, 3),
            );
        }
        say!("computing time {:.1} s", self.took.as_secs_f64());
        let map = self.form_map.as_ref().map(map_text).unwrap_or_default();
        if !map.is_empty() {
            say!("\n{}", map.trim_end());
        }
        say!("");
    }

    fn print_causes(&self) {
        if !self.causes.is_empty() {
            say!("\nform error of the same job on another simulated machine (highest, lowest, rms):");
        }
        for cause in &self.causes {
            let [highest, lowest, rms] = [cause.highest_mm, cause.lowest_mm, cause.rms_mm].map(um_from_mm);
            say!("{}", wrapped(&format!("  {:<34} {highest:+.3} um, {lowest:+.3} um, {rms:.3} um", cause.name), 4));
        }
    }

    fn verdict(&self) -> String {
        match (self.part(), self.status) {
            (Some(part), GoalStatus::Succeeded) => format!(
                "{}: worst form error {:+.3} um at {:.1} deg, z {:.2} mm (allowed {:.3} um)",
                if self.is_good() { "GOOD" } else { "NOT GOOD" },
                um(part.form_error_max),
                deg_from_rad(part.form_error_max_azimuth),
                mm_from_m(part.form_error_max_z),
                um(part.form_error_allowed),
            ),
            _ => format!("NOT COMPLETE: {}, {}", self.job, status_word(self.status)),
        }
    }

    pub(super) fn print_json(&self) {
        let turned = self.part().map(|part| {
            json!({
                "name": part.name,
                "passes": part.passes,
                "turns": part.turns,
                "duration_s": part.duration,
                "form_error_max_um": um(part.form_error_max),
                "form_error_max_deg": deg_from_rad(part.form_error_max_azimuth),
                "form_error_max_z_mm": mm_from_m(part.form_error_max_z),
                "form_error_highest_um": um(part.form_error_highest),
                "form_error_lowest_um": um(part.form_error_lowest),
                "form_error_rms_um": um(part.form_error_rms),
                "form_error_allowed_um": um(part.form_error_allowed),
                "cusp_height_um": um(part.cusp_height),
                "cusp_height_theory_um": um(part.cusp_height_theory),
            })
        });
        let causes: serde_json::Map<String, Value> = (self.causes.iter())
            .map(|cause| {
                let [highest, lowest, rms] = [cause.highest_mm, cause.lowest_mm, cause.rms_mm].map(um_from_mm);
                (cause.name.clone(), json!({ "highest_um": highest, "lowest_um": lowest, "rms_um": rms }))
            })
            .collect();
        let report = json!({
            "job": self.job,
            "good": self.is_good(),
            "status": format!("{:?}", self.status),
            "message": self.result.message,
            "alarm": self.result.alarm,
            "plan_hash": self.result.plan_hash,
            "first_tick": self.result.first_tick,
            "last_tick": self.result.last_tick,
            "duration_s": self.result.duration,
            "predicted_s": self.predicted_s,
            "bag": self.files.bag,
            "report": self.files.report,
            "took_s": self.took.as_secs_f64(),
            "turned": turned,
            "form_map": self.form_map.as_ref().map(map_json),
            "form_error_instead": causes,
        });
        say!("{report}");
    }
}

fn size(count: u32) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

/// Largest deviation in each field of a coarser map (µm), all azimuths of the first column first; none for an invalid map.
fn farthest_um(map: &FormMap, azimuths: usize, columns: usize) -> Option<Vec<f64>> {
    let (round, along) = (size(map.azimuths), size(map.columns));
    let cells = round.checked_mul(along)?;
    if azimuths == 0
        || columns == 0
        || azimuths > round
        || columns > along
        || map.lowest.len() != cells
        || map.highest.len() != cells
    {
        return None;
    }
    let mut fields = Vec::with_capacity(azimuths * columns);
    for column in 0..columns {
        for azimuth in 0..azimuths {
            let mut farthest = 0.0_f64;
            for k in column * along / columns..(column + 1) * along / columns {
                for i in azimuth * round / azimuths..(azimuth + 1) * round / azimuths {
                    for deviation in [map.lowest[k * round + i], map.highest[k * round + i]].map(f64::from) {
                        farthest = if deviation.abs() > farthest.abs() { deviation } else { farthest };
                    }
                }
            }
            fields.push(um(farthest));
        }
    }
    Some(fields)
}

/// Map as a table: z downwards, azimuths to the right.
fn map_text(map: &FormMap) -> String {
    let [azimuths, columns] = [PRINTED[0].min(size(map.azimuths)), PRINTED[1].min(size(map.columns))];
    let Some(fields) = farthest_um(map, azimuths, columns) else { return String::new() };
    let mut text = String::from("largest form error (um) by z (mm) and azimuth from (deg):\n              ");
    for azimuth in 0..azimuths {
        let _infallible = write!(text, "{:>7.0}", 360.0 * azimuth as f64 / azimuths as f64);
    }
    text.push('\n');
    let [from_mm, to_mm] = [map.from_z, map.to_z].map(mm_from_m);
    let z = |column: usize| from_mm + (to_mm - from_mm) * column as f64 / columns as f64;
    for (column, row) in fields.chunks(azimuths).enumerate() {
        let _infallible = write!(text, "{:>6.2}-{:<6.2} ", z(column), z(column + 1));
        for deviation in row {
            let _infallible = write!(text, "{deviation:>+7.2}");
        }
        text.push('\n');
    }
    text
}

fn map_json(map: &FormMap) -> Value {
    let all_um = |values: &[f32]| values.iter().map(|value| um(f64::from(*value))).collect::<Vec<f64>>();
    json!({
        "azimuths": map.azimuths,
        "columns": map.columns,
        "from_z_mm": mm_from_m(map.from_z),
        "to_z_mm": mm_from_m(map.to_z),
        "lowest_um": all_um(&map.lowest),
        "highest_um": all_um(&map.highest),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 24 fields round, 20 along, each 1 nm; one of them 3 µm below.
    fn map() -> FormMap {
        let mut map = FormMap {
            azimuths: 24,
            columns: 20,
            from_z: 0.0,
            to_z: 0.02,
            lowest: vec![0.0; 480],
            highest: vec![1e-9; 480],
            ..FormMap::default()
        };
        map.lowest[13 * 24 + 7] = -3e-6;
        map
    }

    #[test]
    fn a_coarser_map_loses_no_extreme() {
        let fields = farthest_um(&map(), 12, 10).expect("a map");
        assert!((fields[6 * 12 + 3] + 3.0).abs() < 1e-6, "{fields:?}");
        let others = fields.iter().filter(|field| (**field - 1e-3).abs() < 1e-6).count();
        assert_eq!(others, 119);
        let text = map_text(&map());
        let row = text.lines().nth(8).expect("ten rows after two lines of heading");
        assert!(row.starts_with(" 12.00-14.00 ") && row.contains("  -3.00"), "{text}");
    }

    #[test]
    fn what_is_no_map_is_not_printed() {
        for wrong in [
            FormMap { lowest: vec![0.0; 3], ..map() },
            FormMap { azimuths: 0, ..map() },
            FormMap { azimuths: u32::MAX, columns: u32::MAX, ..map() },
        ] {
            assert_eq!(map_text(&wrong), "");
        }
        assert_eq!(farthest_um(&map(), 25, 10), None);
    }
}
