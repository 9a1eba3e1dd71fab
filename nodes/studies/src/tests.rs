// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Studies of a short job from file to results.

use super::*;
use camwright_files::locate::Located;
use camwright_files::study_file::{self, Study, StudyResponse};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Short cases: two that grind, one that the planner refuses, one that makes the machine stop.
const STUDY: &str = "schema: camwright/study/1
name: short
job: eccentric
fixed: {infeed.total_mm: 0.036, stock_mm: 0.03, infeed.spark_out_turns: 1}
factors:
  work_speed_rpm: [60.0, 90.0]
  home.x_mm: [150.0, 1000.0]
  raw_part.unknown_um: {random: uniform, from: -1.0, to: 1.0}
design: {kind: grid}
seeds: [raw_part.seed]
limits: {form_error_max_um: 20.0, burn_index: 2.0}
";

fn study(text: &str) -> Study {
    study_file::read(&Located::new("study.yaml", text), &[]).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Runs a study in a folder with some workers until so many cases are done; returns the number of cases that ran.
fn run(study: &Study, folder: &Path, workers: usize, stop_after: usize) -> (usize, StudyFolder) {
    let cases = cases(study);
    let folder = StudyFolder::create(folder).expect("a folder");
    folder.write_plan(study, &cases).expect("a plan");
    let (log, mut outcomes) = folder.open_log().expect("a log");
    let done = AtomicUsize::new(0);
    let settings = EngineSettings {
        workers,
        is_stopped: &|| done.load(Ordering::Relaxed) >= stop_after,
        on_done: &|count| done.store(count, Ordering::Relaxed),
    };
    run_cases(study, &cases, (&log, &mut outcomes), &settings).expect("it runs");
    folder.write_results(&StudyResults::new(study, &cases, &outcomes)).expect("results");
    (done.load(Ordering::Relaxed), folder)
}

fn bytes(folder: &StudyFolder, name: &str) -> Vec<u8> {
    std::fs::read(folder.file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn results_are_the_same_with_any_number_of_workers_and_after_a_stop() {
    let study = study(STUDY);
    let root = tempfile::tempdir().expect("a folder");
    let (ran, first) = run(&study, &root.path().join("one"), 1, usize::MAX);
    assert_eq!(ran, 4);
    for workers in [2, 4] {
        let (_, other) = run(&study, &root.path().join(workers.to_string()), workers, usize::MAX);
        for name in ["plan.json", "results.parquet", "results.csv"] {
            assert!(bytes(&other, name) == bytes(&first, name), "{name} with {workers} workers");
        }
    }
    let path = root.path().join("stopped");
    let (before, _) = run(&study, &path, 1, 1);
    let (after, resumed) = run(&study, &path, 2, usize::MAX);
    assert_eq!((before, after), (1, 3), "no case runs twice");
    let (again, _) = run(&study, &path, 2, usize::MAX);
    assert_eq!(again, 0);
    for name in ["plan.json", "results.parquet", "results.csv"] {
        assert!(bytes(&resumed, name) == bytes(&first, name), "{name} after a stop");
    }
}

#[test]
fn cases_that_ran_alone_give_the_same_results() {
    let study = study(STUDY);
    let root = tempfile::tempdir().expect("a folder");
    let (_, whole) = run(&study, &root.path().join("whole"), 2, usize::MAX);
    let (cases, path) = (cases(&study), root.path().join("alone"));
    let folder = StudyFolder::create(&path).expect("a folder");
    folder.write_plan(&study, &cases).expect("a plan");
    assert_eq!(
        folder.planned_hashes().expect("a plan"),
        cases.iter().map(|case| case.hash.clone()).collect::<Vec<_>>()
    );
    for case in cases.iter().rev() {
        let single = run_single_case(&study, &folder, &case.hash).expect("it runs");
        assert_eq!(folder.single_case(&case.hash), Some(single.outcome.clone()));
        let again = run_single_case(&study, &folder, &case.hash).expect("it ran");
        assert_eq!((single.ran_before, again.ran_before, again.outcome), (false, true, single.outcome));
    }
    // A file that a killed process left.
    std::fs::write(path.join("cases/0.json"), b"{\"case\":\"0\",\"sta").expect("it can be written");
    let (ran, _) = run(&study, &path, 2, usize::MAX);
    assert_eq!(ran, 0, "all cases are known");
    for name in ["plan.json", "results.parquet", "results.csv"] {
        assert!(bytes(&folder, name) == bytes(&whole, name), "{name}");
    }
}

#[test]
fn an_alarm_is_a_row_with_its_number_and_the_other_cases_run() {
    let study = study(
        "schema: camwright/study/1
name: alarm
job: eccentric
fixed: {infeed.total_mm: 0.036, stock_mm: 0.03, infeed.spark_out_turns: 1, machine.x_axis.min_following_error_mm: 0.001}
factors: {machine.x_axis.max_following_error_mm: [0.0011, 1.0]}
design: {kind: grid}
",
    );
    let root = tempfile::tempdir().expect("a folder");
    let (ran, folder) = run(&study, root.path(), 1, usize::MAX);
    assert_eq!(ran, 2);
    let (_, outcomes) = folder.open_log().expect("a log");
    let results = StudyResults::new(&study, &cases(&study), &outcomes);
    let [stopped, made] = &results.rows[..] else { panic!("{:?}", results.rows) };
    assert_eq!((stopped.outcome.status, stopped.outcome.alarm), (CaseStatus::Alarm, Some(32)));
    assert!(stopped.outcome.reason.contains("following error"), "{}", stopped.outcome.reason);
    assert_eq!(made.outcome.status, CaseStatus::Done);
    let csv = String::from_utf8(bytes(&folder, "results.csv")).expect("UTF-8");
    assert!(csv.lines().nth(1).is_some_and(|row| row.contains(",alarm,") && row.contains(",32,")), "{csv}");
}

#[test]
fn a_case_that_fails_is_a_row_with_its_reason() {
    let study = study(STUDY);
    let root = tempfile::tempdir().expect("a folder");
    let (_, folder) = run(&study, root.path(), 2, usize::MAX);
    let cases = cases(&study);
    let (_, outcomes) = folder.open_log().expect("a log");
    let results = StudyResults::new(&study, &cases, &outcomes);
    assert_eq!((results.count(CaseStatus::Done), results.count(CaseStatus::Refused)), (2, 2));
    let failures = results.failures();
    assert_eq!((failures.len(), failures[0].count), (1, 2), "{failures:?}");
    let csv = String::from_utf8(bytes(&folder, "results.csv")).expect("UTF-8");
    assert_eq!(csv.lines().count(), 5, "{csv}");
    assert!(
        csv.starts_with("case,hash,point,replicate,work_speed_rpm,home.x_mm,raw_part.unknown_um,raw_part.seed,status,")
    );
    let best = results.best().expect("a feasible case");
    let row = &results.rows[best.row];
    for response in StudyResponse::ALL {
        assert!(row.outcome.response(response).is_some(), "{response:?}");
    }
    let text = results.text(&folder);
    assert!(text.starts_with("GOOD: case ") && text.contains("\ncommand: camwright run "), "{text}");
    assert!(text.contains("cases:   2 done, 2 refused, 2 feasible"), "{text}");
    assert_eq!(results.json(&folder)["failures"][0]["count"], 2);
}

/// The results of a case are those of the job itself with the same settings.
#[test]
fn a_case_is_the_job_with_its_settings() {
    let study = study(STUDY);
    let case = &cases(&study)[0];
    let set: Vec<String> = study
        .base
        .fixed()
        .iter()
        .chain(&case.settings)
        .map(|(key, value)| format!("{key}={}", value.to_flow()))
        .collect();
    let prepared = camwright_planning::prepare("eccentric", &set, None).expect("a job");
    let (_, lobes) = camwright_planning::simulate_job(&prepared, &[], |_, _| {}).expect("a part");
    let outcome = run_case(&study, &case.settings);
    let error_um = camwright_files::convert::um_from_m(lobes[0].form_error_max.abs());
    assert_eq!(outcome.response(StudyResponse::FormErrorMaxUm), Some(error_um));
    assert_eq!(outcome.response(StudyResponse::BurnIndex), Some(lobes[0].burn_index_max));
    assert_eq!(outcome.worst_lobe.as_deref(), Some("A"));
}

#[test]
fn the_report_needs_no_other_file_and_escapes_texts() {
    let study = study(&STUDY.replace("name: short\n", "name: short\ntitle: <script>alert(1)</script>\n"));
    let root = tempfile::tempdir().expect("a folder");
    let (_, folder) = run(&study, root.path(), 2, usize::MAX);
    let page = String::from_utf8(bytes(&folder, "report.html")).expect("UTF-8");
    for outside in ["http", "src=", "<script", "url(", "@import", "<link"] {
        let found: Vec<&str> =
            page.lines().filter(|line| line.contains(outside) && !line.contains("http-equiv")).collect();
        assert!(found.is_empty(), "{outside}: {found:?}");
    }
    for part in
        ["Best feasible case", "Time against form error", "Main effects", "Failures by reason", "&lt;script&gt;"]
    {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN"), "every number is one");
}

#[test]
fn parquet_holds_the_rows_of_the_csv() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let study = study(STUDY);
    let root = tempfile::tempdir().expect("a folder");
    let (_, folder) = run(&study, root.path(), 2, usize::MAX);
    let file = std::fs::File::open(folder.file("results.parquet")).expect("a table");
    let reader = SerializedFileReader::new(file).expect("Parquet");
    let metadata = reader.metadata().file_metadata();
    assert_eq!(metadata.num_rows(), 4);
    let columns: Vec<&str> = metadata.schema().get_fields().iter().map(|field| field.name()).collect();
    let csv = String::from_utf8(bytes(&folder, "results.csv")).expect("UTF-8");
    assert_eq!(columns.join(","), csv.lines().next().unwrap_or_default());
}

/// Two ranges and a list; the fastest case that keeps the form error lies between the points of the design.
const SEARCHED: &str = "schema: camwright/study/1
name: searched
job: eccentric
fixed: {infeed.total_mm: 0.036, stock_mm: 0.03}
factors:
  work_speed_rpm: {from: 20.0, to: 120.0, steps: 2}
  raw_part.unknown_um: {from: -1.0, to: 1.0, steps: 2}
  infeed.spark_out_turns: [1, 2]
design: {kind: grid}
limits: {form_error_max_um: 4.1, burn_index: 2.0}
";

/// Searches in a folder; returns the number of cases that ran, and the cases.
fn searched(study: &Study, folder: &Path, workers: usize, stop_after: usize) -> (usize, Vec<StudyCase>, StudyFolder) {
    let folder = StudyFolder::create(folder).expect("a folder");
    let (log, mut outcomes) = folder.open_log().expect("a log");
    let done = AtomicUsize::new(0);
    let settings = EngineSettings {
        workers,
        is_stopped: &|| done.load(Ordering::Relaxed) >= stop_after,
        on_done: &|_| {
            done.fetch_add(1, Ordering::Relaxed);
        },
    };
    let cases = optimise(study, 40, (&log, &mut outcomes), &settings).expect("it runs");
    folder.write_plan(study, &cases).expect("a plan");
    folder.write_results(&StudyResults::new(study, &cases, &outcomes)).expect("results");
    (done.load(Ordering::Relaxed), cases, folder)
}

#[test]
fn a_search_beats_the_design_and_is_the_same_with_any_number_of_workers_and_after_a_stop() {
    let study = study(SEARCHED);
    let root = tempfile::tempdir().expect("a folder");
    let (ran, cases, one) = searched(&study, &root.path().join("one"), 1, usize::MAX);
    assert_eq!(ran, cases.len(), "no case runs twice");
    assert!(cases.len() > 16 && cases.len() <= 40, "{}", cases.len());
    let (_, outcomes) = one.open_log().expect("a log");
    let best = |cases: &[StudyCase]| {
        let results = StudyResults::new(&study, cases, &outcomes);
        results.best().map(|best| best.value)
    };
    let (of_design, of_all) = (best(&cases[..8]).unwrap_or(f64::INFINITY), best(&cases).expect("a feasible case"));
    assert!(of_all < 0.95 * of_design, "{of_all} s after {of_design} s");
    // The job file of the best case makes the part again.
    let results = StudyResults::new(&study, &cases, &outcomes);
    let row = &results.rows[results.best().expect("a feasible case").row];
    let (job, _) = study.base.sources_with(&row.case.settings).expect("a job file");
    assert_eq!(bytes(&one, "best_job.yaml"), job.as_bytes());
    let alone = Study { base: study_of_job(&job).base, ..study.clone() };
    assert_eq!(run_case(&alone, &[]).responses, row.outcome.responses);

    let (_, _, two) = searched(&study, &root.path().join("two"), 2, usize::MAX);
    let stopped = root.path().join("stopped");
    let (before, ..) = searched(&study, &stopped, 2, 12);
    let (after, _, resumed) = searched(&study, &stopped, 2, usize::MAX);
    assert_eq!(before + after, cases.len(), "no case runs twice");
    for name in ["plan.json", "results.parquet", "results.csv", "best_job.yaml"] {
        assert!(bytes(&two, name) == bytes(&one, name), "{name} with 2 workers");
        assert!(bytes(&resumed, name) == bytes(&one, name), "{name} after a stop");
    }
}

/// A study of a job file without factors that matter.
fn study_of_job(job: &str) -> Study {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("best_job.yaml");
    std::fs::write(&path, job).expect("it can be written");
    let text = format!(
        "schema: camwright/study/1\nname: alone\njob: {}\nfactors: {{work_speed_rpm: [60.0]}}\ndesign: {{kind: grid}}\n",
        path.display()
    );
    study(&text)
}
