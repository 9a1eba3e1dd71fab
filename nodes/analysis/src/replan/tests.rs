// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A job planned, archived as messages, and planned again with something changed: what moves is known in closed form.

use super::archive::ArchivedJob;
use super::outcome::{ReplanOutcome, replan};
use camwright::machine::persistent_state::PersistentState;
use camwright_files::convert::machine_description::description_message;
use camwright_files::locate::locate;
use camwright_files::machine_file;
use camwright_msgs::camwright_msgs::msg::JobStatus;
use camwright_planning::{AnyPrepared, prepare_any};

/// A job as a bag has it: on the machine that it names, with the wheel that it names.
fn archived(job: &str, set: &[&str]) -> ArchivedJob {
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    let prepared = prepare_any(job, &set, None).expect("a job that can be made");
    let located = locate("machines", &prepared.machine().name, "yaml", None).expect("its machine");
    let file = machine_file::parse(&located.path, &located.text, &[]).expect("it is well formed");
    let mut lasting = PersistentState::new(&file.description);
    if let AnyPrepared::Ground(ground) = &prepared {
        lasting.wheel_radius_mm = ground.wheel_radius_mm;
    }
    let status = JobStatus {
        job: prepared.name().to_owned(),
        job_source: prepared.source().to_owned(),
        job_hash: prepared.job_hash().to_owned(),
        plan_hash: prepared.plan_hash().to_owned(),
        ..JobStatus::default()
    };
    let machine = Some(description_message(&file, &lasting));
    ArchivedJob { status, machine, files: prepared.files().to_vec(), pages: prepared.first_pages().to_vec() }
}

fn replanned(job: &ArchivedJob, set: &[&str], tolerance_um: f64) -> ReplanOutcome {
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    replan(job, &set, &[], tolerance_um).expect("it can be planned again")
}

/// The texts of what moved in steps of a phase.
fn moved(outcome: &ReplanOutcome, phase: &str) -> Vec<String> {
    let is_of = |line: &&super::ChangeLine| line.step.contains(&format!("({phase}"));
    outcome.lines.iter().filter(is_of).map(|line| line.text.clone()).collect()
}

/// The number behind a word in a text.
fn number(text: &str, behind: &str) -> f64 {
    let at = text.find(behind).unwrap_or_else(|| panic!("{behind} is not in {text}")) + behind.len();
    let word = text[at..].split_whitespace().next().expect("a word");
    word.parse().unwrap_or_else(|_| panic!("{word} is no number: {text}"))
}

#[test]
fn a_job_that_nothing_changed_is_planned_to_the_bit() {
    for job in ["eccentric", "journal_runout", "turned_cam"] {
        let job = archived(job, &[]);
        let outcome = replanned(&job, &[], 0.0);
        assert!(outcome.is_same && !outcome.moved(), "{outcome}");
        assert_eq!(outcome.to_string(), format!("the same plan {:.12}", job.status.plan_hash));
    }
}

/// For a disc of radius r with eccentricity e, the wheel's axis is sqrt((r + R)^2 - e^2 sin^2) + e cos away: a disc larger by 1 um moves it
/// outwards by (r + R) / sqrt((r + R)^2 - e^2 sin^2) um, most at 90 deg, and nothing else of the cut changes.
#[test]
fn a_larger_base_circle_moves_the_path_by_as_much() {
    let job = archived("eccentric", &[]);
    let outcome = replanned(&job, &["profiles.eccentric.base_radius_mm=14.801"], 0.0);
    let cut = moved(&outcome, "cut of A");
    let path = cut.iter().find(|text| text.starts_with("path of x_axis")).expect("the path moved");
    let (sum, eccentricity) = (19.0_f64 + 15.0, 4.2);
    let max = sum / (sum * sum - eccentricity * eccentricity).sqrt();
    assert!((number(path, "moved by ") - max).abs() < 1e-4 && path.ends_with("at 90.00 deg"), "{path}, but {max}");
    assert!(!cut.iter().any(|text| text.starts_with("begins") || text.starts_with("turns")), "{cut:?}");
    // Changes within the tolerance are counted and not reported.
    let within = replanned(&job, &["profiles.eccentric.base_radius_mm=14.801"], 1.1);
    assert!(!moved(&within, "cut of A").iter().any(|text| text.starts_with("path")) && within.within > 0, "{within}");
}

#[test]
fn speed_infeed_and_position_changes_are_reported_separately() {
    let job = archived("eccentric", &[]);
    // The infeed is the same but for where within a turn it is rounded to increments: 2 nm.
    let slower = replanned(&job, &["work_speed_rpm=30"], 0.01);
    let cut = moved(&slower, "cut of A");
    let speed = cut.iter().find(|text| text.starts_with("speed of c_axis")).expect("C turns more slowly");
    assert!((number(speed, "-> ") - 30.0).abs() < 0.1, "{speed}");
    assert!(!cut.iter().any(|text| text.starts_with("path") || text.starts_with("infeed")), "{cut:?}");
    assert!(slower.duration_s[1] > slower.duration_s[0] + 1.0, "{slower}");

    let home = replanned(&job, &["home.x_mm=149"], 0.0);
    let back = moved(&home, "return");
    assert!(back.iter().any(|text| text == "moves to another position of x_axis, by -1000.000000 um"), "{home}");
    assert!(moved(&home, "cut of A").is_empty(), "{home}");

    let turned = replanned(&job, &["lobes.A.phase_deg=5"], 0.0);
    let begins = moved(&turned, "cut of A");
    let angle = begins.iter().find(|text| text.starts_with("begins at another angle")).expect("its phase is another");
    assert!((number(angle, "by ").abs() - 5.0).abs() < 1e-4, "{angle}");

    let longer = replanned(&job, &["infeed.spark_out_turns=5"], 0.0);
    let turns = moved(&longer, "cut of A");
    assert!(turns.iter().any(|text| text.starts_with("turns ")), "{longer}");
}

#[test]
fn a_spiral_is_compared_over_its_angle() {
    let job = archived("turned_cam", &["turned.to_mm=22"]);
    let outcome = replanned(&job, &["part_zero_mm=2.5"], 0.0);
    let z = outcome.lines.iter().find(|line| line.text.starts_with("path of z_axis")).expect("the part lies elsewhere");
    assert!((number(&z.text, "moved by ").abs() - 500.0).abs() < 1e-6, "{}", z.text);
    assert!(!outcome.lines.iter().any(|line| line.text.starts_with("path of x_axis")), "{outcome}");
}

/// A job of our own with a table of our own beside it is planned again where neither is on the disk; without the table it is not.
#[test]
fn the_files_that_a_job_names_come_from_the_bag() {
    let folder = tempfile::tempdir().expect("a folder");
    let text =
        |kind: &str, name: &str, extension: &str| locate(kind, name, extension, None).expect("it is shipped").text;
    let job = text("jobs", "four_lobe_camshaft", "yaml")
        .replace("intake.csv", "own_in.csv")
        .replace("exhaust.csv", "own_ex.csv");
    std::fs::write(folder.path().join("own_job.yaml"), job).expect("a job");
    for (name, shipped) in [("own_in.csv", "intake"), ("own_ex.csv", "exhaust")] {
        std::fs::write(folder.path().join(name), text("lifts", shipped, "csv")).expect("a table");
    }
    let mut own = archived(&folder.path().join("own_job.yaml").display().to_string(), &[]);
    drop(folder);
    assert!(own.files.iter().map(|file| file.name.as_str()).eq(["own_in.csv", "own_ex.csv"]), "{}", own.files.len());
    assert!(replanned(&own, &[], 0.0).is_same);
    own.files.clear();
    let reason = replan(&own, &[], &[], 0.0).expect_err("its table is nowhere");
    assert!(reason.contains("the recorded job is refused: ") && reason.contains("own_in.csv"), "{reason}");
}

#[test]
fn jobs_that_cannot_be_replanned_report_the_reason() {
    let mut job = archived("eccentric", &[]);
    let refused = |job: &ArchivedJob, set: &[&str]| {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        replan(job, &set, &[], 0.0).expect_err("it cannot be planned")
    };
    assert!(
        refused(&job, &["work_speed_rpm=-1"]).contains("the recorded job "),
        "{}",
        refused(&job, &["work_speed_rpm=-1"])
    );
    job.pages.pop();
    assert!(refused(&job, &[]).contains(" pages are here"), "{}", refused(&job, &[]));
    job.pages.clear();
    assert!(refused(&job, &[]).contains("was not recorded"), "{}", refused(&job, &[]));
    job.machine = None;
    assert_eq!(refused(&job, &[]), "no machine description is recorded");
}
