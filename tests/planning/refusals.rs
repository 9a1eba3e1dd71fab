// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Impossible jobs are refused with one clear sentence that names file, line, value and bound: by `check`, by the planner's service, and by
//! its action as a rejection, with nothing moved.

use crate::cell;
use crate::support;

use camwright_msgs::camwright_msgs::msg::JobStatus;
use camwright_msgs::camwright_msgs::srv::{ValidateJob, ValidateJobRequest};
use cell::Cell;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::Folder;

fn params(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params").join(file);
    std::fs::read_to_string(path).expect("a file of params/")
}

/// Exit code and standard error of `camwright check`.
fn check(path: &Path) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_camwright")).args(["check", "--details"]).arg(path).output();
    let output = output.expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap_or(-1), text)
}

/// Text without the line breaks of an 80-column terminal.
fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The default job with one thing wrong.
struct BadJob {
    name: &'static str,
    job: String,
    intake: Vec<String>,
    /// Required texts of the refusal.
    expected: &'static [&'static str],
}

impl BadJob {
    /// Something is wrong in the job file.
    fn job(name: &'static str, change: impl Fn(String) -> String, expected: &'static [&'static str]) -> Self {
        let job = change(params("jobs/four_lobe_camshaft.yaml"));
        Self { name, job, intake: intake(), expected }
    }

    /// Something is wrong in its intake table.
    fn table(name: &'static str, change: impl Fn(&mut Vec<String>), expected: &'static [&'static str]) -> Self {
        let mut rows = intake();
        change(&mut rows);
        Self { name, job: params("jobs/four_lobe_camshaft.yaml"), intake: rows, expected }
    }

    /// Writes its files; the path of the job.
    fn write(&self, folder: &Folder) -> PathBuf {
        folder.write("intake.csv", &(self.intake.join("\n") + "\n"));
        folder.write("exhaust.csv", &params("lifts/exhaust.csv"));
        folder.write("job.yaml", &self.job)
    }

    fn is_reported_by(&self, who: &str, text: &str) {
        for part in self.expected {
            assert!(text.contains(part), "{}: {who} does not say {part:?}: {text}", self.name);
        }
    }

    /// `camwright check` refuses it.
    fn refused(&self) {
        let folder = Folder::new(&format!("refusals-{}", self.name));
        let (code, text) = check(&self.write(&folder));
        assert_eq!(code, 2, "{} must be refused: {text}", self.name);
        self.is_reported_by("check", &text);
    }
}

fn intake() -> Vec<String> {
    params("lifts/intake.csv").lines().map(str::to_owned).collect()
}

/// Row of a cam angle in tenths of a degree: two comment lines and the header stand above.
fn row(rows: &[String], tenths: usize) -> usize {
    let angle = format!("{}.{},", tenths / 10, tenths % 10);
    rows.iter().position(|row| row.starts_with(&angle)).expect("a row of the table")
}

/// Every row's angle and lift, changed.
fn change_rows(rows: &mut [String], change: impl Fn(f64, f64) -> (f64, f64)) {
    for row in rows.iter_mut().filter(|row| row.starts_with(|c: char| c.is_ascii_digit())) {
        let (angle, lift) = row.split_once(',').expect("two columns");
        let (angle, lift) = change(angle.parse().expect("an angle"), lift.parse().expect("a lift"));
        *row = format!("{angle:.1},{lift:.3}");
    }
}

fn duplicate_angle() -> BadJob {
    let change = |rows: &mut Vec<String>| {
        let at = row(rows, 1200);
        rows[at] = rows[at - 1].clone();
    };
    BadJob::table("duplicate", change, &["intake.csv:1204", "119.9", "1203"])
}

fn missing_block() -> BadJob {
    let change = |rows: &mut Vec<String>| drop(rows.remove(row(rows, 1200)));
    BadJob::table("missing", change, &["intake.csv:1204", "1 block", "120.0"])
}

fn nan() -> BadJob {
    let change = |rows: &mut Vec<String>| {
        let at = row(rows, 1200);
        rows[at] = "120.0,NaN".into();
    };
    BadJob::table("nan", change, &["intake.csv:1204", "NaN, not a finite number"])
}

fn crank_degrees() -> BadJob {
    let change = |rows: &mut Vec<String>| change_rows(rows, |angle, lift| (2.0 * angle, lift));
    BadJob::table("crank", change, &["intake.csv:1804", "720.00 deg", "360 deg", "crank degrees"])
}

/// Increments per block, as on the tape, of which one is a digit too large.
fn misclosure() -> BadJob {
    let change = |rows: &mut Vec<String>| {
        let lifts: Vec<f64> = rows
            .iter()
            .filter(|row| row.starts_with(|c: char| c.is_ascii_digit()))
            .map(|row| row.split(',').nth(1).expect("two columns").parse().expect("a lift"))
            .collect();
        let increment = |k: usize| lifts[(k + 1) % lifts.len()] - lifts[k] + if k == 1500 { 0.001 } else { 0.0 };
        let row = |k: usize| format!("{}.{},{:.3}", k / 10, k % 10, increment(k));
        *rows = [String::from("cam_angle_deg,increment_mm")].into_iter().chain((0..lifts.len()).map(row)).collect();
    };
    BadJob::table("misclosure", change, &["intake.csv:3601", "0.001 mm of lift remain", "less than 0.0005 mm"])
}

fn step() -> BadJob {
    let raise = |angle: f64, lift: f64| (angle, if (149.95..209.95).contains(&angle) { lift + 0.2 } else { lift });
    BadJob::table("step", |rows| change_rows(rows, raise), &["intake.csv:1504", "jumps 0.2000", "allowed: 0.005"])
}

fn undercut() -> BadJob {
    let mut bad = BadJob::job(
        "undercut",
        |text| {
            let text = text.replacen("radius_mm: 8.5", "radius_mm: 45.0", 1);
            text.replacen("base_radius_mm: 16.0", "base_radius_mm: 6.0", 1)
        },
        &["job.yaml:10", "undercut at cam angle 17", "curvature is -42.6", "it must be above 0"],
    );
    change_rows(&mut bad.intake, |angle, lift| (angle, 3.0 * lift));
    bad
}

fn unknown_key() -> BadJob {
    let change = |text: String| text.replace("work_speed_rpm:", "work_speed_rmp:");
    BadJob::job("unknown-key", change, &["job.yaml:32", "work_speed_rmp", "work_speed_rpm"])
}

fn two_lobes_on_one_station() -> BadJob {
    let change = |text: String| text.replace("station: LS2", "station: LS1");
    BadJob::job("one-station", change, &["job.yaml:21", "I1", "E1", "LS1", "one lobe"])
}

fn station_without_a_switch() -> BadJob {
    let change = |text: String| text.replace("station: LS4", "station: LS9");
    BadJob::job("no-switch", change, &["job.yaml:23", "E2", "LS9", "LS1, LS2, LS3, LS4"])
}

fn newer_schema() -> BadJob {
    let change = |text: String| text.replace("camwright/job/1", "camwright/job/9");
    BadJob::job("schema", change, &["job.yaml:3", "version 9", "up to version 1"])
}

fn infeed_of_broken_turns() -> BadJob {
    let change = |text: String| text.replace("total_mm: 0.36 ", "total_mm: 0.35 ");
    BadJob::job("infeed", change, &["job.yaml:29", "0.35", "0.324 or 0.36 mm", "0.009722222 or 0.010802469 um"])
}

const ALL: [fn() -> BadJob; 12] = [
    misclosure,
    duplicate_angle,
    missing_block,
    nan,
    crank_degrees,
    step,
    undercut,
    unknown_key,
    two_lobes_on_one_station,
    station_without_a_switch,
    newer_schema,
    infeed_of_broken_turns,
];

#[test]
fn a_duplicate_angle_is_refused() {
    duplicate_angle().refused();
}

#[test]
fn a_missing_block_is_refused() {
    missing_block().refused();
}

#[test]
fn a_nan_is_refused() {
    nan().refused();
}

#[test]
fn crank_degrees_where_cam_degrees_are_declared_are_refused() {
    crank_degrees().refused();
}

#[test]
fn increments_that_do_not_close_are_refused() {
    misclosure().refused();
}

#[test]
fn a_step_is_refused() {
    step().refused();
}

#[test]
fn an_undercut_lobe_is_refused() {
    undercut().refused();
}

#[test]
fn an_unknown_key_is_refused() {
    unknown_key().refused();
}

#[test]
fn two_lobes_on_one_station_are_refused() {
    two_lobes_on_one_station().refused();
}

#[test]
fn a_station_without_a_switch_is_refused() {
    station_without_a_switch().refused();
}

#[test]
fn a_newer_schema_is_refused() {
    newer_schema().refused();
}

#[test]
fn a_total_infeed_that_is_no_whole_number_of_turns_is_refused() {
    infeed_of_broken_turns().refused();
}

#[test]
fn the_default_job_is_clean() {
    let (code, text) = check(Path::new("four_lobe_camshaft"));
    assert_eq!(code, 0, "{text}");
}

/// A turning job with one thing wrong, in its own file or in the machine's, which both stand in the folder; `{line}` of what is expected is
/// that of the change.
fn turned_is_refused(name: &str, file: &str, (from, to): (&str, &str), expected: &[&str]) {
    let folder = Folder::new(&format!("refusals-turned-{name}"));
    let changed = |of: &str, path: &str| {
        let text = params(path);
        let is_changed = of == file;
        assert!(!is_changed || text.contains(from), "{from} is not in {path}");
        folder.write(of, &if is_changed { text.replacen(from, to, 1) } else { text })
    };
    changed("lathe.yaml", "machines/lathe.yaml");
    let job = changed("job.yaml", "jobs/turned_cam.yaml");
    let text = std::fs::read_to_string(folder.join(file)).expect("it was written");
    let line = text.lines().position(|line| line.contains(to)).expect("what was changed") + 1;
    let (code, output) = check(&job);
    assert_eq!(code, 2, "{name} must be refused: {output}");
    let place = format!("{file}:{line}: ");
    assert!(output.contains(&place), "{name}: {place} is not reported: {output}");
    for words in expected {
        assert!(output.contains(words), "{name}: {words:?} is not reported: {output}");
    }
}

#[test]
fn a_turning_job_that_cannot_be_made_is_refused_where_it_is_wrong() {
    for (name, change, expected) in [
        (
            "bar",
            ("bar_radius_mm: 24.6", "bar_radius_mm: 24.1"),
            &["the bar's radius (mm) is 24.1", "at least 24.5"][..],
        ),
        ("key", ("deepest_mm: 3.0", "deepest: 3.0"), &["deepest", "deepest_mm"]),
        ("passes", ("deepest_mm: 3.0", "deepest_mm: 0.001"), &["the number of roughing passes", "up to 1000"]),
        ("feed", ("finishing: {along_z_mm: 0.2}", "finishing: {}"), &["one of along_z_mm and along_curve_mm"]),
        ("spindle", ("law: fastest", "law: quickest"), &["quickest", "fastest"]),
        ("zero", ("part_zero_mm: 2.0 ", "part_zero_mm: 90.0 "), &["z_axis", "soft limits are -20 to 300 mm"]),
        ("profile", ("profile: low", "profile: lower"), &["there is no profile lower; the surface has high, low"]),
        ("kind", ("kind: cams", "kind: cam"), &["cams, cylinder, eccentric, elliptic_cone, lobed, grid, mesh"]),
        (
            "schema",
            ("turning_job/1", "turning/1"),
            &["must be one of camwright/job/1, camwright/turning_job/1", "did you mean camwright/turning_job/1?"],
        ),
        ("newer", ("turning_job/1", "turning_job/2"), &["version 2", "up to version 1"]),
        ("end", ("to_mm: 24.0", "to_mm: 19.0"), &["the part ends at z = 19 mm, it must end above z = 20 mm"]),
        ("machine", ("machine: lathe", "machine: cam_grinder"), &["the machine grinds with a wheel"]),
    ] {
        turned_is_refused(name, "job.yaml", change, expected);
    }
}

/// The insert at another height touches, scrapes or misses; the error names the angle of C, the position along the part, and a sufficient
/// value.
#[test]
fn an_insert_that_does_not_clear_the_part_is_refused_at_its_height() {
    for (name, height, words) in [
        ("centre", "height_mm: 0.0 ", "the flank clears the surface by"),
        ("above", "height_mm: 12.0 ", "the flank clears the surface by"),
        ("low", "height_mm: -19.9 ", "the surface lies at"),
        ("beside", "height_mm: -21.0 ", "the part has a radius of"),
    ] {
        let expected = [words, " deg", "z = ", "below centre it clears this surface, best"];
        turned_is_refused(name, "lathe.yaml", ("height_mm: -14.0 ", height), &expected);
    }
    turned_is_refused(
        "backwards",
        "lathe.yaml",
        ("rotation_sense: 1", "rotation_sense: -1"),
        &["rotation_sense is -1"],
    );
}

#[test]
fn the_default_turning_job_is_clean_and_reports_the_insert_clearance() {
    let (code, text) = check(Path::new("turned_cam"));
    assert_eq!(code, 0, "{text}");
    let text = unwrapped(&text);
    for words in ["turned_cam: 3 passes, ", "offset angle 44.4", "within the 40 to 60 deg", "heights from"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// A hollow that the insert bridges is reported as a warning; material is left in it.
#[test]
fn a_hollow_that_the_insert_bridges_is_a_warning() {
    let folder = Folder::new("refusals-turned-hollow");
    let job = params("jobs/turned_cam.yaml").replacen("from_mm: 20.0", "from_mm: 12.0", 1);
    let (code, text) = check(&folder.write("job.yaml", &job));
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("warning: ") && text.contains("job.yaml:9: the insert bridges a hollow: at C "), "{text}");
}

/// The reading of a mesh is reported; a broken one is refused with its file.
#[test]
fn a_mesh_is_described_or_refused_with_its_file() {
    let folder = Folder::new("refusals-turned-mesh");
    let corner = |i: u32, k: u32| {
        let (sin, cos) = (f64::from(i % 72) * std::f64::consts::TAU / 72.0).sin_cos();
        format!("vertex {} {} {}\n", 24.0 * cos, 24.0 * sin, 2.0 * f64::from(k))
    };
    let facet =
        |corners: [String; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.concat());
    let mut facets = Vec::new();
    for (i, k) in (0..72).flat_map(|i| (0..12).map(move |k| (i, k))) {
        facets.push(facet([corner(i, k), corner(i + 1, k), corner(i + 1, k + 1)]));
        facets.push(facet([corner(i, k), corner(i + 1, k + 1), corner(i, k + 1)]));
    }
    let at = |text: &str, from: &str| text.find(from).expect("a key");
    let job = params("jobs/turned_cam.yaml");
    let surface = "surface: {kind: mesh, file: part.stl, unit: mm}\n\n";
    let job = format!("{}{surface}{}", &job[..at(&job, "surface:")], &job[at(&job, "turned:")..]);
    let path = folder.write("job.yaml", &job);
    folder.write("part.stl", &format!("solid cylinder\n{}endsolid\n", facets.concat()));
    let (code, text) = check(&path);
    assert_eq!(code, 0, "{text}");
    // A chord of 5° is 24 (1 − cos 2.5°) = 22.8 µm inside at its middle, two thirds of that at the middle of a triangle.
    let text = unwrapped(&text);
    assert!(text.contains("part.stl: 1728 triangles") && text.contains("flat faces up to 20.3"), "{text}");
    facets.remove(100);
    folder.write("part.stl", &format!("solid cylinder\n{}endsolid\n", facets.concat()));
    let (code, text) = check(&path);
    assert!(code == 2 && text.contains("part.stl: the triangles cover 0.999421 of the turn"), "{text}");
}

/// The service says the same sentence as the rejected goal's status, and the cell has not stirred.
#[test]
fn the_service_and_the_action_refuse_the_same_with_nothing_moved() {
    let cell = Cell::start(&[]);
    for bad in ALL.map(|bad| bad()) {
        let folder = Folder::new(&format!("refusals-ros-{}", bad.name));
        let job = bad.write(&folder).display().to_string();
        let request = ValidateJobRequest { job: job.clone(), overrides: Vec::new() };
        let validated = cell.client.call::<ValidateJob>("job_planner/validate_job", &request);
        assert!(!validated.success, "{}", bad.name);
        bad.is_reported_by("the service", &validated.message);
        assert!(validated.findings[0].starts_with("error: "), "{:?}", validated.findings);
        let (goal, _) = cell.client.send(&job, &[]);
        assert!(!goal.accepted(), "{}", bad.name);
        let status = cell.client.status(&validated.message, |status| status.message.contains(&validated.message));
        assert_eq!(status.state, JobStatus::IDLE);
        assert!(status.message.contains("nothing moved"), "{}", status.message);
    }
    assert!(!cell.client.has_moved());
    cell.stop();
}
