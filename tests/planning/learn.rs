// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright learn`: reports of a measuring machine become the corrections of the next job.

use crate::support;

use camwright_files::job_file;
use std::f64::consts::TAU;
use std::process::{Command, Output};
use support::Folder;

/// Runs `camwright learn` in a folder.
fn learn(folder: &Folder, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(folder.path()).arg("learn").args(words).output().expect("camwright runs")
}

/// Refused, with one error that has these parts.
fn refused(folder: &Folder, words: &[&str], parts: &[&str]) {
    let output = learn(folder, words);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {error}");
    for part in parts {
        assert!(error.contains(part), "{words:?} does not report {part:?}: {error}");
    }
}

/// Rows of a report at 360 cam angles.
fn rows(header: &str, value: impl Fn(f64) -> f64) -> String {
    let row = |k: u32| format!("{k},{:.6}\n", value(f64::from(k) * TAU / 360.0));
    format!("{header}\n{}", (0..360).map(row).collect::<String>())
}

/// A size of 3 µm and a wave of 2 µm: the correction is −0.7 times both.
#[test]
fn a_report_of_deviations_is_the_correction_of_the_next_job() {
    let folder = Folder::new("learn");
    let deviation = |angle: f64| 3.0 + 2.0 * (5.0 * angle).cos();
    folder.write("gauge.csv", &rows("cam_angle_deg,deviation_um", deviation));
    let output = learn(&folder, &["four_lobe_camshaft", "--report", "I2=gauge.csv", "--out", "next.yaml", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let lobe = &report["lobes"][0];
    assert_eq!((&lobe["lobe"], &lobe["values"], &report["job"]), (&"I2".into(), &360.into(), &"next.yaml".into()));
    let number = |key: &str| lobe[key].as_f64().expect("a number");
    assert!((number("largest_um") - 5.0).abs() < 1e-3 && (number("correction_um") - 3.5).abs() < 1e-3, "{lobe}");
    let learned = |file: &str| {
        let job = job_file::load(&folder.join(file).display().to_string(), &[]).expect("a job");
        job.spec.compensation.expect("learns").learned
    };
    let corrections = learned("next.yaml");
    assert_eq!(corrections.iter().map(|learned| learned.lobe.as_str()).collect::<Vec<_>>(), ["I2"]);
    for k in 0..360 {
        let angle = f64::from(k) * TAU / 360.0;
        let off_um = 1e3 * corrections[0].correction.sample(angle).value + 0.7 * deviation(angle);
        assert!(off_um.abs() < 1e-3, "{k} deg: {off_um} um");
    }
    // The same error inward, of a second lobe, on top of that; and nothing is overwritten.
    folder.write("inward.csv", &rows("cam_angle_deg,deviation_mm", |angle| -1e-3 * deviation(angle)));
    let second = ["next.yaml", "--report", "E1=inward.csv", "--positive-inward", "--out", "third.yaml"];
    assert_eq!(learn(&folder, &second).status.code(), Some(0));
    let corrections = learned("third.yaml");
    assert_eq!(corrections.iter().map(|learned| learned.lobe.as_str()).collect::<Vec<_>>(), ["I2", "E1"]);
    let off_um = 1e3 * (corrections[0].correction.sample(0.4).value - corrections[1].correction.sample(0.4).value);
    assert!(off_um.abs() < 1e-3, "{off_um} um");
    refused(&folder, &second, &["third.yaml exists and is not overwritten"]);
    // Mounted off centre by 40 µm: the size and the wave are learned, the mounting is not. Its direction is that of the normal.
    let job = job_file::load("four_lobe_camshaft", &[]).expect("a job");
    let designs = camwright::planner::designs(&job.spec).expect("designs");
    let contour = &designs.iter().find(|design| design.name == "I1").expect("a lobe").contour;
    let mounted = |angle: f64| deviation(angle) + 40.0 * contour.normal(angle).x;
    folder.write("mounted.csv", &rows("cam_angle_deg,deviation_um", mounted));
    let words =
        ["four_lobe_camshaft", "--report", "I1=mounted.csv", "--align", "eccentricity", "--out", "aligned.yaml"];
    assert_eq!(learn(&folder, &words).status.code(), Some(0));
    let correction = &learned("aligned.yaml")[0].correction;
    for k in 0..360 {
        let angle = f64::from(k) * TAU / 360.0;
        let off_um = 1e3 * correction.sample(angle).value + 0.7 * deviation(angle);
        // A wave along an uneven normal is a little eccentric itself.
        assert!(off_um.abs() < 1.0, "{k} deg: {off_um} um");
    }
}

#[test]
fn a_report_that_cannot_be_the_lobe_is_refused() {
    let folder = Folder::new("learn-refused");
    folder.write("good.csv", &rows("cam_angle_deg,deviation_um", f64::cos));
    let job = "four_lobe_camshaft";
    let next = ["--out", "next.yaml"];
    let refuse = |words: &[&str], parts: &[&str]| {
        refused(&folder, &[&[job], words, &next].concat(), parts);
        assert!(!folder.join("next.yaml").exists(), "{words:?} leaves a file");
    };
    refuse(&["--report", "I9=good.csv"], &["lobe is \"I9\"; lobes of four_lobe_camshaft: I1, E1, I2, E2"]);
    refuse(&["--report", "I1=good.csv", "--report", "I1=good.csv"], &["lobe I1 has two reports; one is needed"]);
    refuse(&["--report", "I1=none.csv"], &["none.csv: not found as given"]);
    refuse(&["--report", "I1"], &["it must be LOBE=FILE"]);
    refuse(&["--report", "I1=good.csv", "--columns", "angle,error"], &["unknown column \"angle\""]);
    let large = rows("cam_angle_deg,deviation_um", |angle| 150.0 * angle.sin());
    folder.write("large.csv", &large);
    refuse(
        &["--report", "I1=large.csv"],
        &["deviates by up to 0.150 mm", "at most 0.1 mm", "--align eccentricity,phase"],
    );
    let sparse: String = large.lines().step_by(5).map(|line| format!("{line}\n")).collect();
    folder.write("sparse.csv", &sparse);
    refuse(
        &["--report", "I1=sparse.csv"],
        &["sparse.csv: lobe I1: ", "at most 18 harmonics", "form_compensation.harmonics"],
    );
    folder.write("words.csv", &large.replace("7,", "7,much"));
    refuse(&["--report", "I1=words.csv"], &["words.csv:9: \"much"]);
    folder.write("increments.csv", &rows("cam_angle_deg,increment_mm", |_| 0.0));
    refuse(&["--report", "I1=increments.csv"], &["holds increments; a report needs lifts, radii or deviations"]);
    folder.write("lifts.csv", &rows("cam_angle_deg,lift_mm", |_| 0.0));
    refuse(&["--report", "I1=lifts.csv", "--positive-inward"], &["only deviations can be positive inward"]);
    refuse(&["--report", "I1=lifts.csv"], &["deviates by up to"]);
    refused(&folder, &["turned_cam", "--report", "A=good.csv", "--out", "next.yaml"], &["turned_cam turns a part"]);
}
