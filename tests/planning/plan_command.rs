// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright plan` against what can be solved on paper, and its files against their contract.

use crate::support;

use std::f64::consts::TAU;
use std::path::Path;
use std::process::{Command, Output};
use support::Folder;

fn plan(job: &str, out: &Path, set: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(["plan", job, "--json", "--out"]).arg(out);
    for over in set {
        command.arg("--set").arg(over);
    }
    command.output().expect("camwright runs")
}

fn planned(job: &str, out: &Path, set: &[String]) -> serde_json::Value {
    let output = plan(job, out, set);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{job} {set:?}: {errors}");
    serde_json::from_slice(&output.stdout).expect("a summary in JSON")
}

/// A table as its header and its rows.
fn table(path: &Path) -> (String, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut lines = text.lines();
    let header = lines.next().expect("a header").to_owned();
    let rows = lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    (header, rows)
}

/// X(θ) = E cosθ + √((r + R)² − E² sin²θ), the distance of the wheel's centre from the spindle axis.
fn closed_form(e: f64, r: f64, wheel: f64, theta: f64) -> f64 {
    e * theta.cos() + ((r + wheel).powi(2) - (e * theta.sin()).powi(2)).sqrt()
}

fn settings(e: f64, r: f64, wheel: f64) -> Vec<String> {
    vec![
        format!("profiles.eccentric.lift.eccentric.eccentricity_mm={e}"),
        format!("profiles.eccentric.base_radius_mm={}", r - e),
        format!("wheel_radius_mm={wheel}"),
    ]
}

/// The eccentric of E 4.2, D 38 with a tool of R 15, and others, the lift given as a formula.
#[test]
fn an_eccentric_disc_is_planned_to_a_millionth_of_a_micrometre() {
    let folder = Folder::new("plan-formula");
    for (e, diameter, wheel) in [(4.2, 38.0, 15.0), (4.2, 38.0, 60.0), (0.75, 22.5, 40.0), (8.0, 50.0, 25.0)] {
        let r = diameter / 2.0;
        planned("eccentric", folder.path(), &settings(e, r, wheel));
        let (_, rows) = table(&folder.join("A/tool_path.csv"));
        assert_eq!(rows.len(), 3600);
        for row in &rows {
            let theta = row[0].to_radians();
            let exact = closed_form(e, r, wheel, theta);
            assert!((row[1] - exact).abs() < 1e-9, "E {e} r {r} R {wheel}: {} deg: {} {exact}", row[0], row[1]);
            assert!((row[4] - (exact - wheel)).abs() < 1e-9, "x_axis is one wheel radius nearer");
            // The wheel touches the disc where the line of centres crosses it.
            let (x, y) = (exact * theta.cos() - e, exact * theta.sin());
            let contact = (y * r / (r + wheel)).atan2(e + x * r / (r + wheel)).rem_euclid(TAU);
            let apart = (row[2].to_radians() - contact + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            assert!(apart.abs() < 1e-8, "contact at {} deg, {} expected", row[2], contact.to_degrees());
        }
    }
}

/// With phase α and cutting C the wheel line is at θ = C − α in the lobe's frame.
#[test]
fn the_phase_turns_the_path() {
    let folder = Folder::new("plan-phase");
    planned("eccentric", folder.path(), &["lobes.A.phase_deg=75".into()]);
    let (_, rows) = table(&folder.join("A/tool_path.csv"));
    for row in rows {
        let exact = closed_form(4.2, 19.0, 15.0, (row[0] - 75.0).to_radians());
        assert!((row[1] - exact).abs() < 1e-9, "{} deg", row[0]);
        let apart = (row[3] - (row[0] - 75.0) + 180.0).rem_euclid(360.0) - 180.0;
        assert!(apart.abs() < 1e-9, "{} deg: {}", row[0], row[3]);
    }
}

/// The same disc from a printed table: X lies within half a digit of the exact one.
#[test]
fn an_eccentric_disc_from_a_printed_table_is_planned_within_half_a_digit() {
    let folder = Folder::new("plan-table");
    for (name, digits, half_digit) in [("fine.csv", 3, 0.5e-3), ("coarse.csv", 2, 0.5e-2)] {
        let lift = |i: u32| 4.2 * (1.0 + (f64::from(i) * TAU / 3600.0).cos());
        let rows: Vec<String> = (0..3600).map(|i| format!("{:.1},{:.digits$}", f64::from(i) / 10.0, lift(i))).collect();
        std::fs::write(folder.join(name), format!("cam_angle_deg,lift_mm\n{}\n", rows.join("\n"))).expect("a table");
        let job =
            std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params/jobs/eccentric.yaml"))
                .expect("the eccentric job")
                .replace("lift: {eccentric: {eccentricity_mm: 4.2}}", &format!("lift: {{table: {name}}}"));
        let path = folder.join("job.yaml");
        std::fs::write(&path, job).expect("a job");
        let out = folder.join("out");
        let summary = planned(&path.display().to_string(), &out, &[]);
        let deviation = summary["lobes"][0]["lift_deviation_mm"].as_f64().expect("a table has a deviation");
        assert!(deviation <= half_digit * (1.0 + 1e-9), "{deviation}");
        let (_, rows) = table(&out.join("A/tool_path.csv"));
        let worst = rows
            .iter()
            .map(|row| (row[1] - closed_form(4.2, 19.0, 15.0, row[0].to_radians())).abs())
            .fold(0.0, f64::max);
        assert!(worst <= half_digit, "{name}: {worst} mm");
    }
}

/// The lifts of a shipped table in units of its last digit.
fn shipped_lift_um(name: &str) -> Vec<i64> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params/lifts").join(name);
    let text = std::fs::read_to_string(path).expect("a shipped table");
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    #[allow(clippy::cast_possible_truncation, reason = "some millimetres in um")]
    let um =
        |row: &str| (row.split(',').nth(1).expect("a lift").parse::<f64>().expect("a number") * 1e3).round() as i64;
    rows.map(um).collect()
}

fn four_lobes() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params/jobs/four_lobe_camshaft.yaml");
    std::fs::read_to_string(path).expect("the default job")
}

/// Increments per block, as on the tape of JPS6156064B2, give every file of a plan byte for byte as absolute lifts do.
#[test]
fn increments_per_block_give_the_motion_of_absolute_lifts() {
    let folder = Folder::new("plan-increments");
    for name in ["intake.csv", "exhaust.csv"] {
        let lift = shipped_lift_um(name);
        let row = |k: usize| format!("{}.{},{}\n", k / 10, k % 10, lift[(k + 1) % lift.len()] - lift[k]);
        let rows: String = (0..lift.len()).map(row).collect();
        std::fs::write(folder.join(name), format!("cam_angle_deg,increment_um\n{rows}")).expect("a table");
    }
    let job = folder.join("job.yaml");
    std::fs::write(&job, four_lobes()).expect("a job");
    let (absolute, increments) = (folder.join("absolute"), folder.join("increments"));
    let a = planned("four_lobe_camshaft", &absolute, &[]);
    let b = planned(&job.display().to_string(), &increments, &[]);
    assert_ne!(a["job_hash"], b["job_hash"], "other files");
    for lobe in ["I1", "E1", "I2", "E2"] {
        for file in ["contour.csv", "tool_path.csv", "speed_plan.csv"] {
            let read = |out: &Path| std::fs::read(out.join(lobe).join(file)).expect("a file of the plan");
            assert!(read(&absolute) == read(&increments), "{lobe}/{file} differs");
        }
    }
}

/// An exhaust table of 0.2 degrees beside an intake table of 0.1: the same cams, and the infeed in blocks of 0.1 degrees.
#[test]
fn tables_of_different_division_make_one_part() {
    let folder = Folder::new("plan-divisions");
    for (name, every) in [("intake.csv", 1), ("exhaust.csv", 2)] {
        let lift = shipped_lift_um(name);
        let row = |k: usize| format!("{}.{},{}\n", k / 10, k % 10, lift[k]);
        let rows: String = (0..lift.len()).step_by(every).map(row).collect();
        std::fs::write(folder.join(name), format!("cam_angle_deg,lift_um\n{rows}")).expect("a table");
    }
    let job = folder.join("job.yaml");
    std::fs::write(&job, four_lobes() + "blocks_per_turn: 3600\n").expect("a job");
    let (shipped, coarse) = (folder.join("shipped"), folder.join("coarse"));
    let a = planned("four_lobe_camshaft", &shipped, &[]);
    let b = planned(&job.display().to_string(), &coarse, &[]);
    for lobe in 0..4 {
        for key in ["turns", "start_block"] {
            assert_eq!(a["lobes"][lobe][key], b["lobes"][lobe][key], "{lobe} {key}");
        }
    }
    let x_mm = |out: &Path| table(&out.join("E1/tool_path.csv")).1.iter().map(|row| row[1]).collect::<Vec<f64>>();
    let apart = x_mm(&shipped).iter().zip(x_mm(&coarse)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart > 0.0 && apart < 1.5e-3, "two readings of one cam to half a digit of 1 um: {apart} mm apart");
}

#[test]
fn every_file_has_its_columns_and_agrees_with_the_others() {
    let folder = Folder::new("plan-files");
    let summary = planned("four_lobe_camshaft", folder.path(), &[]);
    let written: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("summary.json")).expect("summary.json"))
            .expect("JSON");
    assert_eq!(summary, written, "what is printed is what is written");
    assert!(summary["saved_s"].as_f64().expect("a number") > 0.0, "not turning the part saves time");
    for key in ["job_hash", "machine_hash", "plan_hash"] {
        assert_eq!(summary[key].as_str().expect("text").len(), 64, "{key}");
    }
    let lobes = summary["lobes"].as_array().expect("lobes");
    assert_eq!(
        lobes.iter().map(|lobe| lobe["name"].as_str().expect("text")).collect::<Vec<_>>(),
        ["I1", "E1", "I2", "E2"]
    );
    for lobe in lobes {
        let folder = folder.join(lobe["name"].as_str().expect("text"));
        let (header, contour) = table(&folder.join("contour.csv"));
        assert_eq!(header, "azimuth_deg,radius_mm,normal_deg,curvature_1_mm");
        let (header, path) = table(&folder.join("tool_path.csv"));
        assert_eq!(header, "c_deg,x_mm,contact_azimuth_deg,wheel_line_deg,x_axis_mm");
        let (header, speed) = table(&folder.join("speed_plan.csv"));
        assert_eq!(header, "c_deg,t_s,c_rad_s,c_rad_s2,c_rad_s3,x_mm_s,x_mm_s2,x_mm_s3,removal_mm2_s,pass");
        assert_eq!((contour.len(), path.len()), (3600, 3600));
        assert!(contour.iter().chain(&path).chain(&speed).flatten().all(|value| value.is_finite()));
        // The largest lift stands on the contour: base circle + lift.
        let base = if lobe["profile"] == "intake" { 16.0 } else { 15.5 };
        let nose = contour.iter().map(|row| row[1]).fold(0.0, f64::max);
        assert!((nose - base - lobe["max_lift_mm"].as_f64().expect("a number")).abs() < 1e-6, "{nose}");
        check_speed_plan(lobe, &speed);
    }
}

/// Rows one interpolation period apart; each derivative is the difference quotient of the one before it; the removal
/// rate ends at 0 with the spark-out, and its integral is the stock.
fn check_speed_plan(lobe: &serde_json::Value, rows: &[Vec<f64>]) {
    let number = |key: &str| lobe["passes"][0][key].as_f64().expect("a number");
    let period = rows[1][1];
    assert!((period - 0.001).abs() < 1e-15, "{period}");
    assert!((rows[0][0].rem_euclid(360.0) - rows[rows.len() - 1][0].rem_euclid(360.0)).abs() < 1e-6, "whole turns");
    assert!((rows[rows.len() - 1][0] - rows[0][0] - 360.0 * number("turns")).abs() < 1e-6);
    assert!((rows[rows.len() - 1][1] - number("cut_s")).abs() <= period);
    for pair in rows.windows(2).take(rows.len() - 2) {
        let quotient = |column: usize| (pair[1][column] - pair[0][column]) / period;
        let mean = |column: usize| 0.5 * (pair[1][column] + pair[0][column]);
        assert!((quotient(0).to_radians() - mean(2)).abs() < 1e-2, "C at {} s", pair[0][1]);
        let x_acceleration = rows.iter().map(|row| row[6].abs()).fold(1.0, f64::max);
        assert!((quotient(5) - mean(6)).abs() < 0.02 * x_acceleration, "X at {} s", pair[0][1]);
        assert!(pair[0][8] >= 0.0);
    }
    let last_turn = rows.iter().rev().take_while(|row| rows[rows.len() - 1][0] - row[0] < 359.0);
    assert!(last_turn.map(|row| row[8]).fold(0.0, f64::max) < 1e-9, "the last spark-out turn removes nothing");
}

/// Every tick of every cut: no more is removed than asked, by the figures of the table and by differences of its speeds in time
/// no limit is exceeded, and a turn takes less than half of what the one speed takes that peaks as high.
#[test]
fn at_a_constant_removal_rate_no_tick_exceeds_it_or_a_limit() {
    const RATE_MM2_S: f64 = 10.0;
    const PERIOD_S: f64 = 1e-3;
    let folder = Folder::new("plan-removal");
    let law = ["speed.law=constant_removal_rate", "speed.removal_rate_mm2_s=10.0", "work_speed_rpm=300.0"];
    let stops = planned("four_lobe_camshaft", folder.path(), &law.map(String::from));
    check_turns(&stops, folder.path(), RATE_MM2_S, PERIOD_S);
    assert!(stops.get("saved_by_turning_on_s").is_none(), "{stops}");
    // On the way onto the path and off it, too.
    let folder = Folder::new("plan-turning-on");
    let set: Vec<String> = law.into_iter().chain(["c_between_lobes=turns_on"]).map(String::from).collect();
    let turns = planned("four_lobe_camshaft", folder.path(), &set);
    check_turns(&turns, folder.path(), RATE_MM2_S, PERIOD_S);
    let seconds = |summary: &serde_json::Value, key: &str| summary[key].as_f64().expect("a number");
    let saved_s = seconds(&stops, "duration_s") - seconds(&turns, "duration_s");
    assert!(saved_s > 1.0 && (saved_s - seconds(&turns, "saved_by_turning_on_s")).abs() < 1e-9, "{saved_s}");
}

fn check_turns(summary: &serde_json::Value, folder: &Path, rate_mm2_s: f64, period_s: f64) {
    for lobe in summary["lobes"].as_array().expect("a list") {
        let name = lobe["name"].as_str().expect("a name");
        let pass = &lobe["passes"][0];
        let figure = |key: &str| pass[key].as_f64().unwrap_or_else(|| panic!("{name}: {key}"));
        assert!(figure("turn_s") < 0.5 * figure("constant_speed_turn_s"), "{lobe}");
        assert!(figure("least_turn_s") < figure("turn_s") && figure("turn_s") < 1.1 * figure("least_turn_s"), "{lobe}");
        for limit in pass["limits"].as_array().expect("a list") {
            assert!(limit["ratio"].as_f64().expect("a number") <= 1.0, "{name}: {limit}");
        }
        let (_, rows) = table(&folder.join(name).join("speed_plan.csv"));
        let largest = rows.iter().map(|row| row[8]).fold(0.0, f64::max);
        assert!(largest <= 1.001 * rate_mm2_s && largest > 0.99 * rate_mm2_s, "{name}: {largest} mm2/s");
        // Differences over a tick are means over it: they exceed no limit that the motion keeps.
        for pair in rows.windows(2) {
            let difference = |column: usize| (pair[1][column] - pair[0][column]) / period_s;
            assert!(difference(2).abs() <= 300.0 && difference(3).abs() <= 3e4, "{name} at {} s", pair[0][1]);
            assert!(difference(5).abs() <= 1e4 && difference(6).abs() <= 1e6, "{name} at {} s", pair[0][1]);
        }
    }
}

/// Every drawing is there as SVG and PNG, and is the same when it is made again.
#[test]
fn plots_are_written_for_every_lobe_and_are_the_same_again() {
    let folder = Folder::new("plan-plots");
    let set = ["--set", "speed={law: constant_removal_rate, removal_rate_mm2_s: 5.0}", "--set", "work_speed_rpm=200.0"];
    let files = |name: &str| {
        let out = folder.join(name);
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        let output =
            command.args(["plan", "eccentric", "--plots", "--out"]).arg(&out).args(set).output().expect("runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let read = |file: String| {
            (std::fs::read(out.join("A").join(&file)).unwrap_or_else(|error| panic!("{file}: {error}")), file)
        };
        let files = ["contour", "tool_path", "c_axis", "x_axis", "removal_rate"]
            .iter()
            .flat_map(|name| ["svg", "png"].map(|extension| read(format!("{name}.{extension}"))))
            .collect::<Vec<_>>();
        let index = std::fs::read_to_string(out.join("index.html")).expect("index.html");
        assert!(index.contains("Plan of eccentric") && index.contains("PLANNED: 1 lobe in"), "{index}");
        shows_every_drawing(&index, &out);
        files
    };
    let (once, again) = (files("once"), files("again"));
    for ((bytes, file), (other, _)) in once.iter().zip(&again) {
        assert_eq!(bytes, other, "{file}");
        if file.ends_with(".svg") {
            let text = std::str::from_utf8(bytes).expect("UTF-8");
            assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"), "{file}");
            assert!(text.contains("<title>eccentric · lobe A") && !text.contains("NaN"), "{file}");
        } else {
            assert!(bytes.starts_with(b"\x89PNG"), "{file}");
        }
    }
}

/// The index shows every SVG of its folder once, each with a sentence, and loads nothing from elsewhere.
fn shows_every_drawing(index: &str, out: &Path) {
    let shown: Vec<&str> = index.split("<img src=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let folders = std::fs::read_dir(out).expect("a folder").flatten().map(|entry| entry.path());
    let files = folders.flat_map(|path| match std::fs::read_dir(&path) {
        Ok(files) => files.flatten().map(|entry| entry.path()).collect(),
        Err(_) => vec![path],
    });
    let mut drawings: Vec<String> = files
        .filter(|file| file.extension().is_some_and(|extension| extension == "svg"))
        .map(|file| file.strip_prefix(out).expect("below the folder").display().to_string())
        .collect();
    drawings.sort();
    let mut sorted = shown.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, drawings);
    assert_eq!(index.matches("<figcaption>").count(), shown.len());
    assert!(!index.contains("<figcaption> ") && !index.contains("http") && !index.contains("<script"), "{index}");
    assert!(index.contains("width=device-width") && index.contains("@media print"), "{index}");
}

#[test]
fn a_job_that_cannot_be_made_leaves_no_files() {
    let folder = Folder::new("plan-refused");
    let out = folder.join("out");
    let output = plan("eccentric", &out, &["infeed.total_mm=0.35".into()]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("whole turns are needed"), "{errors}");
    assert!(!out.exists());
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number: {value}"))
}

/// A cylinder about an axis beside the spindle's has its circle in every plane: with its centre at (cx, cy) the rake plane y₀ meets it at
/// x = cx + √(r² − (y₀ − cy)²), and the insert's centre stands its radius farther out.
#[test]
fn an_eccentric_part_is_turned_along_the_closed_form() {
    let folder = Folder::new("plan-turned-eccentric");
    let (r, e, azimuth_deg, insert, plane, zero) = (21.0_f64, 2.5, 40.0_f64, 8.0, -14.0_f64, 2.0);
    let surface = format!(
        "surface={{kind: eccentric, from_mm: 0.0, to_mm: 10.0, radius_mm: {r}, eccentricity_mm: {e}, azimuth_deg: {azimuth_deg}}}"
    );
    let set = [surface, "turned={from_mm: 10.0, to_mm: 0.0}".into(), "finishing.along_z_mm=0.4".into()];
    let summary = planned("turned_cam", folder.path(), &set);
    let passes = summary["passes"].as_array().expect("passes");
    for (index, pass) in passes.iter().enumerate() {
        let leaves = number(&pass["leaves_mm"]);
        let (header, rows) = table(&folder.join(&format!("pass_{}/insert_path.csv", index + 1)));
        assert_eq!(header, "turned_deg,x_mm,z_mm,x_mm_rad,x_mm_rad2,z_mm_rad,z_mm_rad2,z_axis_mm");
        for row in &rows {
            let (sin, cos) = (azimuth_deg - row[0]).to_radians().sin_cos();
            let (cx, cy, dx, dy) = (e * cos, e * sin, e * sin, -e * cos);
            let chord = (r * r - (plane - cy).powi(2)).sqrt();
            assert!((row[1] - (cx + chord + insert + leaves)).abs() < 1e-9, "{} deg: {}", row[0], row[1]);
            assert!((row[3] - (dx + (plane - cy) * dy / chord)).abs() < 1e-8, "{} deg: {}", row[0], row[3]);
            assert!((row[7] - (row[2] - zero)).abs() < 1e-12);
        }
        // One feed a turn, from outside of the end to beyond the other.
        let (first, last) = (&rows[0], &rows[rows.len() - 1]);
        let feed = number(&pass["feed_mm"]);
        assert!((last[2] - first[2] + feed * (last[0] - first[0]) / 360.0).abs() < 1e-9, "{first:?} {last:?}");
        assert!(first[2] > 10.0 && last[2] < 0.0, "{first:?} {last:?}");
    }
    assert_eq!(passes.iter().map(|pass| number(&pass["leaves_mm"])).next_back(), Some(0.0));
}

#[test]
fn every_file_of_a_turned_part_has_its_columns_and_agrees_with_the_others() {
    let folder = Folder::new("plan-turned-files");
    let summary = planned("turned_cam", folder.path(), &[]);
    let written: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("summary.json")).expect("summary.json"))
            .expect("JSON");
    assert_eq!(summary, written, "what is printed is what is written");
    for key in ["job_hash", "machine_hash", "plan_hash"] {
        assert_eq!(summary[key].as_str().expect("text").len(), 64, "{key}");
    }
    let passes = summary["passes"].as_array().expect("passes");
    assert_eq!(passes.len(), 3);
    let depths: f64 = passes.iter().map(|pass| number(&pass["depth_mm"])).sum();
    let stock = (24.6_f64.powi(2) - 196.0).sqrt() - (400.0_f64 - 196.0).sqrt();
    assert!((depths - stock).abs() < 0.01, "{depths} {stock}");
    for (index, pass) in passes.iter().enumerate() {
        assert_eq!(pass["limits"].as_array().expect("limits").len(), 9);
        for limit in pass["limits"].as_array().expect("limits") {
            assert!(number(&limit["ratio"]) <= 1.0, "{limit}");
            assert!(limit["axis"] != "x_axis" || number(&limit["ratio"]) > 0.1, "X works: {limit}");
        }
        let feed = number(&pass["feed_mm"]);
        assert!((number(&pass["cusp_um"]) - 1e3 * feed * feed / 8.0 / 8.0).abs() < 1e-3, "{pass}");
        let (_, rows) = table(&folder.join(&format!("pass_{}/insert_path.csv", index + 1)));
        let x = |of: fn(f64, f64) -> f64, from: f64| rows.iter().map(|row| row[1]).fold(from, of);
        let (low, high) = (x(f64::min, f64::INFINITY), x(f64::max, 0.0));
        assert!((number(&pass["x_mm"][0]) - low).abs() < 1e-12 && (number(&pass["x_mm"][1]) - high).abs() < 1e-12);
        // Derivatives are those of the positions: to their fourth difference.
        for triple in rows.windows(3).step_by(17) {
            let step = (triple[1][0] - triple[0][0]).to_radians();
            let first = (triple[2][1] - triple[0][1]) / (2.0 * step);
            assert!((first - triple[1][3]).abs() < 1e-2, "{} {first}", triple[1][3]);
        }
    }
    let cusp = |pass: &serde_json::Value| number(&pass["highest_cusp"]["height_um"]);
    assert!(
        cusp(&passes[2]) > number(&passes[2]["cusp_um"]) && cusp(&passes[2]) < 2.0,
        "a section that bulges: {}",
        passes[2]
    );
    assert!(passes[0].get("highest_cusp").is_none());
    let (header, rows) = table(&folder.join("clearance.csv"));
    assert_eq!(
        header,
        "turned_deg,clearance_deg,clearance_z_mm,clearance_azimuth_deg,approach_deg,approach_z_mm,approach_azimuth_deg"
    );
    assert_eq!(rows.len(), 360);
    let clearance = &summary["clearance"];
    for (column, key) in [(1, "clearance"), (4, "approach")] {
        let min = rows.iter().map(|row| row[column]).fold(f64::INFINITY, f64::min);
        // Looked at on other places of the same surface.
        assert!((min - number(&clearance[key]["angle_deg"])).abs() < 0.1, "{key}: {min} {clearance}");
        assert!(min > number(&clearance[key]["least_deg"]));
    }
    assert!((number(&clearance["offset_angle_deg"]) - (14.0_f64 / 20.0).asin().to_degrees()).abs() < 1e-3);
    assert_eq!((&clearance["is_offset_preferred"], &clearance["is_offset_allowed"]), (&true.into(), &true.into()));
    let heights = &clearance["heights"];
    assert!(number(&heights["from_mm"]) < 14.0 && number(&heights["to_mm"]) > 14.0, "{heights}");
}

/// The surface that is written is one that can be read: the same part, to what a spline through its radii leaves.
#[test]
fn the_surface_that_is_written_plans_to_the_same_path() {
    let folder = Folder::new("plan-turned-again");
    let (first, again) = (folder.join("first"), folder.join("again"));
    let a = planned("turned_cam", &first, &[]);
    let grid = format!("surface={{kind: grid, file: {:?}}}", first.join("surface.csv").display().to_string());
    let b = planned("turned_cam", &again, &[grid]);
    assert_ne!(a["job_hash"], b["job_hash"], "another job");
    let path = |out: &Path| table(&out.join("pass_3/insert_path.csv")).1;
    let (one, other) = (path(&first), path(&again));
    assert_eq!(one.len(), other.len());
    let off = one.iter().zip(&other).map(|(one, other)| (one[1] - other[1]).abs()).fold(0.0, f64::max);
    println!("the path through surface.csv is {off:.2e} mm off");
    // A hundredth of the tolerance of its form.
    assert!(off < 1e-4, "{off} mm");
}

#[test]
fn a_turned_part_is_drawn_and_described_and_an_impossible_one_leaves_no_files() {
    let folder = Folder::new("plan-turned-plots");
    let out = folder.join("drawn");
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(["plan", "turned_cam", "--details", "--plots", "--set", "spindle={law: varied}", "--out"]).arg(&out);
    let output = command.output().expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for words in ["0.2 per z", "limits of the spindle speed", "clearance ", "of x_axis", "heights   from", "plan hash "]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    let index = std::fs::read_to_string(out.join("index.html")).expect("index.html");
    assert!(index.contains("PLANNED: 3 passes in"), "{index}");
    shows_every_drawing(&index, &out);
    for name in ["surface_map", "surface_view", "section", "x_axis", "clearance"] {
        let svg = std::fs::read_to_string(out.join(format!("{name}.svg"))).expect("a drawing");
        assert!(svg.contains("<title>turned_cam · turned") && !svg.contains("NaN"), "{name}");
        assert!(std::fs::read(out.join(format!("{name}.png"))).expect("a drawing").starts_with(b"\x89PNG"));
    }
    let out = folder.join("refused");
    let output = plan("turned_cam", &out, &["bar_radius_mm=24.0".into()]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("the part's largest radius"), "{errors}");
    assert!(!out.exists());
}
