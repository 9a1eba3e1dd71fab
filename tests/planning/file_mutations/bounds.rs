// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Work that a file asks for and does not get: refused with what, how much and how much is allowed, within the limits of every command.

use super::judge::{self, End};
use super::subjects::{SMALL_JOB, SMALL_TURNED, SURFACES, grid};
use super::support::{Folder, repository};
use super::{changed_bag, changed_bag::Original};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::cdr::sample_from_message;
use std::borrow::Cow;
use std::path::Path;

/// Result of a command on a job: its end and its output.
fn ends(folder: &Folder, job: &str, command: &str) -> (End, String) {
    folder.write("job.yaml", job);
    let arguments: Vec<String> = command.split(' ').map(str::to_owned).collect();
    let outcome = judge::run(Path::new(env!("CARGO_BIN_EXE_camwright")), &arguments, folder.path());
    (outcome.end, outcome.output)
}

fn shipped(name: &str) -> String {
    let path = repository().join("params/jobs").join(format!("{name}.yaml"));
    std::fs::read_to_string(path).expect("a shipped job")
}

#[test]
fn what_is_too_much_work_is_refused_with_what_is_allowed() {
    let folder = Folder::new("work-bounds");
    let lobe = "  - {name: I1, station: LS1, profile: intake, phase_deg: 210.0, width_mm: 14.0}\n";
    let small = |from: &str, to: &str| {
        assert!(SMALL_JOB.contains(from), "{from}");
        SMALL_JOB.replace(from, to)
    };
    let turned = SMALL_TURNED.replace("SURFACE", SURFACES[0]);
    for (job, command, expected) in [
        (
            small("work_speed_rpm: 60.0", "work_speed_rpm: 0.01")
                .replace("spark_out_turns: 4}", "spark_out_turns: 1000}"),
            "check job.yaml",
            "a job may take 86400 s",
        ),
        (small("work_speed_rpm: 60.0", "work_speed_rpm: 1e-12"), "check job.yaml", "it must be 0.01 to 95000"),
        (small("rapid_speed_mm_s: 100.0", "rapid_speed_mm_s: 1e-4"), "check job.yaml", "it must be 0.01 to 100000"),
        (small("spark_out_turns: 4}", "spark_out_turns: 4000000000}"), "check job.yaml", "it must be 0 to 1000"),
        (small(lobe, &lobe.repeat(20_000)), "check job.yaml", "lobes has 20000 entries; it must have 1 to 100"),
        (small("name: one_lobe", "name: ../../x"), "check job.yaml", "it must be 1 to 64 letters, digits"),
        (turned.replace("deepest_mm: 3.0", "deepest_mm: 0.018"), "check job.yaml", "at most 1000000 are allowed"),
        (
            shipped("plate_groove").replace("work_speed_rpm: 0.5,", "work_speed_rpm: 0.0005,"),
            "post job.yaml --out out",
            "a turn takes at least",
        ),
    ] {
        let (end, output) = ends(&folder, &job, command);
        assert!(end == End::Rule(2) && output.contains(expected), "{expected:?}: {end}: {output}");
    }
}

/// One radius off by a tenth makes hollows that the insert is looked for in again and again.
#[test]
fn a_surface_with_a_dent_is_planned_or_refused_in_time() {
    let folder = Folder::new("dents");
    let job = SMALL_TURNED.replace("SURFACE", SURFACES[4]);
    for (row, column, radius) in [(7, 3, "19.26855"), (7, 32, "18.86778"), (7, 22, "18.13997")] {
        let mut rows: Vec<Vec<String>> =
            grid(36, 13).lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
        rows[row][column] = radius.to_owned();
        folder.write("surface.csv", &rows.iter().map(|row| row.join(",") + "\n").collect::<String>());
        let (end, output) = ends(&folder, &job, "check job.yaml");
        assert!(matches!(end, End::Rule(_)), "{row} {column}: {end}: {output}");
    }
}

/// A cut of hours has a table that a person can open.
#[test]
fn a_slow_cut_has_a_table_of_bounded_length() {
    let folder = Folder::new("slow-cut");
    let job = shipped("plate_cam");
    let at = job.find("work_speed_rpm:").expect("its speed");
    let end = job[at..].find('\n').map_or(job.len(), |length| at + length);
    let job = format!("{}work_speed_rpm: 0.064{}", &job[..at], &job[end..]);
    let (end, output) = ends(&folder, &job, "plan job.yaml --out out");
    assert_eq!(end, End::Rule(0), "{output}");
    let table = std::fs::read_to_string(folder.join("out/P/speed_plan.csv")).expect("its table");
    let rows = table.lines().count();
    assert!((500_000..=1_000_100).contains(&rows), "{rows} rows");
}

#[test]
fn a_replay_does_not_run_to_where_a_damaged_number_leads() {
    let folder = Folder::new("leaping-bag");
    let original = Original::read(&repository().join("bags/golden/ground"), folder.join("leaping"));
    let place = original.places::<MachineStream>()[20];
    let stream = MachineStream { tick: 1 << 40, ..original.decoded(place) };
    let data = sample_from_message(&stream).expect("a message");
    let bag = original.rewritten(|index, message| match index == place {
        true => Some(Cow::Owned(data.clone())),
        false => changed_bag::as_it_was(message),
    });
    let arguments = ["replay".into(), bag.display().to_string(), "--against".into()];
    let outcome = judge::run(Path::new(env!("CARGO_BIN_EXE_camwright")), &arguments, folder.path());
    assert_eq!(outcome.end, End::Rule(1), "{}", outcome.output);
    assert!(outcome.output.contains("at most 1000000 are computed without a message"), "{}", outcome.output);
}
