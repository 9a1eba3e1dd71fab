// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;

const STUDY: &str = "schema: camwright/study/1
name: small
job: eccentric
factors:
  work_speed_rpm: {from: 30, to: 60, steps: 4}
  infeed.spark_out_turns: {from: 1, to: 4, steps: 2}
  machine.x_axis.drive.kv_1_s: [150.0, 200.0]
design: {kind: grid}
";

fn study(text: &str, overrides: &[&str]) -> Result<Study, Vec<String>> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let errors = |errors: Vec<ConfigError>| errors.iter().map(ToString::to_string).collect();
    read(&Located::new("study.yaml", text), &overrides).map_err(errors)
}

fn refusals(text: &str) -> String {
    study(text, &[]).expect_err("a bad study").join("\n")
}

#[test]
fn a_study_is_read_with_its_defaults() {
    let study = study(STUDY, &[]).expect("a study");
    assert_eq!((study.case_count, study.replicates, study.seed), (16, 1, 1));
    let keys: Vec<&str> = study.factors.iter().map(|factor| factor.key.as_str()).collect();
    assert_eq!(keys, ["work_speed_rpm", "infeed.spark_out_turns", "machine.x_axis.drive.kv_1_s"], "as in the file");
    assert_eq!(study.factors.iter().map(|factor| factor.is_whole).collect::<Vec<_>>(), [false, true, false]);
    assert_eq!(study.limits, [(StudyResponse::FormErrorMaxUm, 5.0), (StudyResponse::BurnIndex, 1.0)]);
    assert_eq!(study.minimise, StudyResponse::JobTimeS);
}

#[test]
fn settings_reach_job_and_machine() {
    let study = study(STUDY, &[]).expect("a study");
    let settings = [
        ("job.work_speed_rpm".to_owned(), YamlValue::Float(42.5)),
        ("machine.x_axis.drive.kv_1_s".to_owned(), YamlValue::Float(150.0)),
    ];
    let (job, machine) = study.base.sources_with(&settings).expect("a job");
    assert!(job.contains("work_speed_rpm: 42.5\n") && machine.contains("kv_1_s: 150"), "{job}{machine}");
    let Ok(AnyJob::Ground(job)) = study.base.job_with(&settings) else { panic!("a grinding job") };
    assert_eq!(job.machine.description.axes[1].drive.kv_1_s.to_bits(), 150.0_f64.to_bits());
}

#[test]
fn every_error_is_reported_with_its_line_and_a_hint() {
    let text = STUDY
        .replace("work_speed_rpm: {from: 30", "work_sped_rpm: {from: 30")
        .replace("x_axis.drive", "x_axs.drive")
        .replace("from: 1, to: 4", "from: 4, to: 1");
    let found = refusals(&text);
    for words in [
        "study.yaml:5: work_sped_rpm is an unknown key; did you mean work_speed_rpm?",
        "study.yaml:6: factors.infeed.spark_out_turns is an empty range, from 4 to 1; from must be below to",
        "study.yaml:7: x_axs is an unknown key; did you mean x_axis?",
    ] {
        assert!(found.contains(words), "{words}: {found}");
    }
    assert_eq!(found.lines().count(), 3, "{found}");
}

#[test]
fn extremes_are_checked_with_the_job() {
    let found = refusals(&STUDY.replace("from: 30, to: 60", "from: -1, to: 200000"));
    assert!(found.contains("study.yaml:5: work_speed_rpm is -1; it must be 0.01 to 95000"), "{found}");
    assert!(found.contains("study.yaml:5: work_speed_rpm is 200000; it must be 0.01 to 95000"), "{found}");
    let found = refusals(&STUDY.replace("[150.0, 200.0]", "[150.0, -3.0]"));
    assert!(found.contains("study.yaml:7: x_axis.drive.kv_1_s is -3"), "{found}");
}

#[test]
fn too_many_cases_are_refused() {
    let text = "schema: camwright/study/1\nname: a\njob: eccentric\nfactors:\n  work_speed_rpm: {from: 30, to: 60, steps: 1000}\n  stock_mm: {from: 0.1, to: 0.3, steps: 1000}\n  rapid_speed_mm_s: {from: 50, to: 100, steps: 1000}\ndesign: {kind: grid}\n";
    let found = refusals(text);
    assert!(found.starts_with("study.yaml:8: the study has 1000000000 cases; at most 100000 are allowed"), "{found}");
}

#[test]
fn unknown_keys_and_forms_of_a_study_are_refused() {
    for (from, to, words) in [
        ("design: {kind: grid}", "desing: {kind: grid}", "desing is an unknown key; did you mean design?"),
        ("kind: grid", "kind: gird", "design.kind is \"gird\"; it must be one of grid, latin_hypercube, sobol"),
        ("kind: grid", "kind: sobol", "design.samples is missing"),
        ("steps: 4", "stesp: 4", "factors.work_speed_rpm.stesp is an unknown key; did you mean steps?"),
        (", steps: 4", "", "factors.work_speed_rpm.steps is missing; the design grid needs it"),
        ("from: 30, ", "", "factors.work_speed_rpm.from is missing; a range needs from and to"),
        ("steps: 4", "random: uniform, steps: 4", "steps does not belong to random: uniform; remove it"),
        ("from: 30, ", "from: 0, scale: log, ", "factors.work_speed_rpm.from is 0; with scale: log it must be above 0"),
        ("[150.0, 200.0]", "[150.0, 150.0]", "drive.kv_1_s.1 repeats a value of the list"),
        ("[150.0, 200.0]", "[]", "has 0 entries; it must have 1 to 1000"),
        ("job: eccentric", "job: ecentric", "did you mean eccentric?"),
        ("job: eccentric", "job: plate_groove", "job"),
        (
            "design:",
            "seeds: [raw_part.sed]\ndesign:",
            "study.yaml:8: raw_part.sed is an unknown key; did you mean seed?",
        ),
        ("design:", "fixed: {stok_mm: 1}\ndesign:", "study.yaml:8: stok_mm is an unknown key; did you mean stock_mm?"),
        ("design:", "limits: {burn_indx: 1}\ndesign:", "limits.burn_indx is an unknown key; did you mean burn_index?"),
        ("design:", "minimise: time\ndesign:", "minimise is \"time\"; it must be one of form_error_max_um"),
    ] {
        let found = refusals(&STUDY.replacen(from, to, 1));
        assert!(found.contains(words), "{to}: {found}");
    }
}

#[test]
fn the_base_of_one_at_a_time_comes_from_the_files() {
    let one = STUDY.replace("kind: grid", "kind: one_at_a_time");
    let found = study(&one, &[]).expect("a study");
    let bases: Vec<_> = found.factors.iter().map(|factor| factor.base.clone()).collect();
    assert_eq!(bases, [Some(YamlValue::Float(60.0)), Some(YamlValue::Integer(3)), Some(YamlValue::Float(200.0))]);
    assert_eq!(found.case_count, 9);
    let unset = one.replace("design:", "  clearance_mm: [1.0, 2.0]\ndesign:");
    let words = "factors.clearance_mm.base is missing; the files do not set clearance_mm";
    assert!(refusals(&unset).contains(words));
    assert!(study(&unset.replace("[1.0, 2.0]", "{values: [1.0, 2.0], base: 1.0}"), &[]).is_ok());
}

#[test]
fn shipped_studies_are_listed_and_read() {
    let names: Vec<String> = list().into_iter().map(|(name, _)| name).collect();
    assert!(names.len() >= 2, "{names:?}");
    for name in names {
        load(&name, &[]).unwrap_or_else(|errors| panic!("{name}: {errors:?}"));
    }
}

#[test]
fn keys_of_a_study_can_be_overridden() {
    let found = study(STUDY, &["factors.infeed.spark_out_turns.steps=3", "design={kind: sobol, samples: 8}"]);
    let found = found.expect("a study");
    assert_eq!(found.case_count, 8);
    assert_eq!(found.factors[1].values.count(), Some(3));
}
