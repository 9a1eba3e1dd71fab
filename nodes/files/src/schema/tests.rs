// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::file_kind::FileKind;
use crate::locate::{Located, locate};
use crate::{any_job, machine_file};
use std::path::Path;

/// Every key has a description, every number a range, but for those whose range the core knows.
#[test]
fn every_key_is_described_and_every_number_has_a_range() {
    const RANGE_OF_THE_CORE: [&str; 22] = [
        "base_radius_mm",
        "offset_mm",
        "radius_mm",
        "pivot_mm",
        "face_offset_mm",
        "bent_between_mm",
        "seed",
        "program_number",
        "tool_number",
        "spindle_rpm",
        "sequence",
        "from_mm",
        "to_mm",
        "eccentricity_mm",
        "azimuth_deg",
        "first_mm",
        "second_mm",
        "mean_mm",
        "amplitude_mm",
        "phase_deg",
        "from",
        "to",
    ];
    for kind in FileKind::ALL {
        for key in keys(&kind.schema()) {
            assert!(!key.description.is_empty(), "{kind:?}: {} has no description", key.path);
            let name = key.path.rsplit('.').next().unwrap_or_default().trim_end_matches("[]");
            let is_number = key.kind.contains("number") && key.words.is_empty();
            let of_core = RANGE_OF_THE_CORE.contains(&name) || name == "start_at" || name == "header_lines";
            assert!(
                !is_number || of_core || key.range.max.is_some() || name == "at_tick",
                "{kind:?}: {} has no range",
                key.path
            );
        }
    }
}

/// Broken variants of a scalar line of a shipped file, each with a text of its refusal.
fn broken(line: &str) -> Vec<(String, &'static str)> {
    let Some((key, value)) = line.split_once(": ") else { return Vec::new() };
    let (indent, name) = key.split_at(key.len() - key.trim_start_matches([' ', '-']).len());
    let value = value.split(" #").next().unwrap_or_default().trim();
    let is_plain = name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    if !is_plain || value.is_empty() || name == "schema" || value.starts_with(['{', '[', '|', '>']) {
        return Vec::new();
    }
    let mut changes = vec![(format!("{indent}{name}_x: {value}"), "is an unknown key")];
    if value.parse::<f64>().is_ok() {
        changes.push((format!("{indent}{name}: wide"), "is the text \"wide\"; it must be"));
    }
    changes.push((format!("{indent}{name}: {{a: 1}}"), "is keys with values; it must be"));
    changes
}

/// Each scalar of every shipped job and machine is misspelt and given another type; the refusal names the line and the key.
#[test]
fn every_broken_line_of_a_shipped_file_is_refused_with_line_and_key() {
    let jobs = crate::locate::list("jobs").into_iter().map(|name| ("jobs", name));
    let machines = crate::locate::list("machines").into_iter().map(|name| ("machines", name));
    let mut count = 0;
    for (kind, name) in jobs.chain(machines) {
        let text = locate(kind, &name, "yaml", None).expect("a shipped file").text;
        for (at, line) in text.lines().enumerate() {
            for (change, words) in broken(line) {
                let changed: Vec<&str> =
                    text.lines().enumerate().map(|(index, old)| if index == at { &change } else { old }).collect();
                let changed = changed.join("\n");
                let refused: Vec<String> = if kind == "jobs" {
                    let read = any_job::read(&Located::new("f.yaml", changed), &[]);
                    read.map(drop).expect_err("refused").iter().map(ToString::to_string).collect()
                } else {
                    let read = machine_file::read(Path::new("f.yaml"), &changed, &[]);
                    read.map(drop).expect_err("refused").iter().map(ToString::to_string).collect()
                };
                let start = format!("f.yaml:{}: ", at + 1);
                let is_named = |error: &&String| error.starts_with(&start) && error.contains(words);
                assert!(refused.iter().any(|error| is_named(&error)), "{kind}/{name}: {change:?}: {refused:?}");
                count += 1;
            }
        }
    }
    assert!(count > 1000, "{count}");
}

#[test]
fn many_errors_are_reported_at_once_and_bounded() {
    let lobes: String =
        (0..90).map(|n| format!("  - {{name: \"{n}/\", station: S, profile: 5, phase_deg: a}}\n")).collect();
    let text = format!("schema: camwright/job/1\nlobes:\n{lobes}");
    let errors = crate::job_file::read(&Located::new("f.yaml", text), &[]).map(drop).expect_err("refused");
    assert_eq!(errors.len(), MAX_FINDINGS + 1);
    assert!(errors[MAX_FINDINGS].to_string().contains("more errors; correct these first"));
}

#[test]
fn a_missing_key_is_named_with_its_meaning() {
    let text = "schema: camwright/job/1\nname: a\n";
    let errors = crate::job_file::read(&Located::new("f.yaml", text), &[]).map(drop).expect_err("refused");
    let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let wanted = "f.yaml: infeed is missing: Infeed of the last pass";
    assert!(texts.iter().any(|text| text.ends_with(&wanted["f.yaml: ".len()..])), "{texts:?}");
}

#[test]
fn words_and_units_are_in_the_table() {
    let table = table(&FileKind::Job.schema());
    for row in [
        "| `infeed.per_turn_um` | µm | 0.000001 to 100000, or a list of such values |  | Infeed per turn, the same in every turn, or a list \
         with the infeed of each turn, whose sum is `total_mm` within half a count of X. Instead of `per_block_um`. |",
        "| `infeed.total_mm` | mm | 0.000001 to 100 | required |",
        "| `c_between_lobes` |  | stops, turns_on | `stops` | Motion of C between two lobes. `stops`: Grinds every lobe",
        "| `lobes[].width_mm` | mm | 0.000001 to 10000 | required | Width of the lobe",
        "| `infeed.spark_out_turns` | turns | 0 to 1000, whole | required |",
    ] {
        assert!(table.contains(row), "{row}:\n{table}");
    }
}

#[test]
fn a_name_without_its_unit_means_the_name() {
    let known = ["work_speed_rpm", "work_speed_range_percent", "wheel_radius_mm", "x"];
    assert_eq!(nearest("work_speed", &known), Some("work_speed_rpm"));
    assert_eq!(nearest("wheel_radius", &known), Some("wheel_radius_mm"));
    assert_eq!(nearest("work_sped_rpm", &known), Some("work_speed_rpm"));
    assert_eq!((nearest("feed", &known), nearest("whe", &known)), (None, None));
}
