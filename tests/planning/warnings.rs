// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Warnings about a planned job on the command line: heat, limits that slow C, coarse tables, spark-out, and speeds and wheels that cannot be.

use super::support::Folder;
use std::f64::consts::TAU;
use std::process::Command;

/// Exit code and text of `camwright check` with overrides, in one line.
fn check(job: &str, set: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(["check", job]);
    for pair in set {
        command.args(["--set", pair]);
    }
    let output = command.output().expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap_or(-1), text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Number after some words of a text.
fn number_after(text: &str, words: &str) -> f64 {
    let at = text.find(words).unwrap_or_else(|| panic!("{words:?} is not in {text}")) + words.len();
    let end = |c: char| !c.is_ascii_digit() && c != '.';
    let number = text[at..].split(end).next().expect("a number");
    number.parse().unwrap_or_else(|error| panic!("{number:?} after {words:?}: {error}"))
}

/// Plate cam as a disc of 45 mm.
const DISC: [&str; 2] =
    ["profiles.lobes.lift={round: true}", "profiles.lobes.follower={kind: roller, radius_mm: 10.0}"];

/// On a disc of 45 mm the cut of a wheel of 60 mm is known on paper, and with it the burn index.
#[test]
fn a_burn_index_above_one_is_a_warning_with_its_value() {
    let process = |key: &str| {
        let text = include_str!("../../params/machines/cam_grinder.yaml");
        number_after(&text[text.find("process:").expect("process data")..], &format!("{key}: "))
    };
    let cut = |depth_mm: f64, rpm: f64| {
        let footprint_mm_s = 45.0 * rpm * TAU / 60.0;
        let diameter_mm = 2.0 / (1.0 / 60.0 + 1.0 / 45.0);
        (depth_mm / (1e-3 * process("safe_depth_um"))).powf(0.75)
            * (footprint_mm_s / process("safe_footprint_speed_mm_s")).sqrt()
            * (process("safe_equivalent_diameter_mm") / diameter_mm).powf(0.25)
    };
    // 3600 blocks of 0.1 µm: the whole infeed in one turn.
    let (code, text) = check("plate_cam", &[&DISC[..], &["infeed.per_block_um=0.1"]].concat());
    assert_eq!(code, 1, "{text}");
    let index = number_after(&text, "the predicted burn index is ");
    assert!((index - cut(0.36, 30.0)).abs() < 0.006, "{index}, on paper {}", cut(0.36, 30.0));
    assert!(text.contains("above 1: the part burns; lower infeed.per_block_um to "), "{text}");
    let (_, text) = check("plate_cam", &DISC);
    assert!(cut(0.036, 30.0) < 1.0 && !text.contains("burn index"), "{text}");
}

#[test]
fn no_shipped_job_has_a_warning() {
    for job in [
        "four_lobe_camshaft",
        "plate_cam",
        "brake_cam",
        "dressed_batch",
        "eccentric_disc",
        "journal_runout",
        "journal_size",
        "rough_and_finish",
        "turned_cam",
    ] {
        let (code, text) = check(job, &[]);
        assert_eq!(code, 0, "{job}: {text}");
    }
}

/// A size that the gauge cannot control, or that the job cannot reach, is refused or warned of with its key and the value that fits.
#[test]
fn a_gauge_controlled_size_is_checked_with_the_value_that_fits() {
    for (job, set, words) in [
        (
            "journal_size",
            "infeed.gauge_size.ends_above_um=-1",
            "infeed.gauge_size.ends_above_um is -1; it must be 0 to 10000",
        ),
        (
            "journal_size",
            "infeed.gauge_size.ends_above_um=90",
            "the journal has 72.0 um on the diameter before the pass",
        ),
        ("journal_size", "infeed.gauge_size.beyond_um=86.4", "raise infeed.total_mm"),
        ("journal_size", "rotary_indexing=true", "not with c_between_lobes: turns_on or rotary_indexing"),
        ("journal_runout", "infeed.gauge_size={ends_above_um: 10}", "leave out one of them"),
        ("four_lobe_camshaft", "infeed.gauge_size={ends_above_um: 10}", "the machine has no in-process gauge"),
        (
            "four_lobe_camshaft",
            "roughing=[{name: r, infeed: {total_mm: 0.36, per_block_um: 0.05, spark_out_turns: 1, gauge_size: {ends_above_um: 10}}, work_speed_rpm: 60}]",
            "give the size to the last pass",
        ),
        ("journal_runout", "runout_correction.published_step_deg=7", "it must be a whole part of 360 deg"),
        ("journal_runout", "runout_correction.published_window_deg=400", "it must be 540 to 1278"),
        (
            "journal_runout",
            "infeed.spark_out_turns=1",
            "spark_out_turns is 1; it must be at least 2 to measure how the deflection decays (identification)",
        ),
    ] {
        let (code, text) = check(job, &[set]);
        assert!(code == 2 && text.contains(words), "{set}: {code} {text}");
    }
    let (code, text) = check("journal_size", &["infeed.spark_out_turns=2", "infeed.gauge_size.ends_above_um=21.2"]);
    assert_eq!(code, 1, "{text}");
    let enough = number_after(&text, "more than 0.50 um; ");
    let wanted = number_after(&text, "tolerance 5; ");
    let (spark_out, ends) =
        (format!("infeed.spark_out_turns={enough}"), format!("infeed.gauge_size.ends_above_um={wanted}"));
    let (_, text) = check("journal_size", &[&spark_out]);
    assert!(!text.contains("on where in a turn"), "{text}");
    let (_, text) = check("journal_size", &["infeed.spark_out_turns=2", &ends]);
    assert!(!text.contains("off its finished radius"), "{text}");
    let (code, text) = check("journal_size", &["infeed.gauge_size.beyond_um=0"]);
    assert!(code == 1 && text.contains("alarm 142 will stop the machine: raise gauge_size.beyond_um to "), "{text}");
}

#[test]
fn a_speed_beyond_the_limit_of_c_names_that_limit_its_line_and_the_largest_speed() {
    let (code, text) = check("plate_cam", &["work_speed_rpm=400"]);
    assert_eq!(code, 2, "{text}");
    for words in [
        "the work speed of 400 rpm (41.888 rad/s) exceeds 300 rpm (31.416 rad/s), the limit of c_axis; ",
        "cam_grinder.yaml:12",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let largest = &text[text.find("the largest work speed that fits is").expect("a speed that fits")..];
    let rpm = number_after(largest, "rad/s (");
    let (code, text) = check("plate_cam", &[&format!("work_speed_rpm={rpm}")]);
    assert!(code < 2, "{text}");
    // Where X limits, its quantity is named, with figures that are not absurd.
    let (code, text) = check("plate_cam", &["work_speed_rpm=290"]);
    assert_eq!(code, 2, "{text}");
    assert!(
        text.contains("x_axis reaches a jerk of 950000 mm/s³ at cam angle ") && text.contains("cam_grinder.yaml:53"),
        "{text}"
    );
}

#[test]
fn a_limit_that_slows_c_for_much_of_a_turn_is_a_warning() {
    let set = ["speed.law=constant_removal_rate", "speed.removal_rate_mm2_s=200.0", "work_speed_rpm=300.0"];
    let (code, text) = check("plate_cam", &set);
    assert_eq!(code, 1, "{text}");
    for words in [
        "limits slow C for ",
        "the jerk limit of c_axis (30000 rad/s³, ",
        "cam_grinder.yaml:14",
        "work_speed_rpm allows 300.0: lower work_speed_rpm",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let reached = number_after(&text, "C reaches ");
    assert!(reached > 1.0 && reached < 300.0, "{text}");
    // A fastest turn is at its limits by definition.
    let (_, text) = check("plate_cam", &["speed.law=time_optimal", "work_speed_rpm=300.0"]);
    assert!(!text.contains("limits slow C"), "{text}");
}

#[test]
fn too_little_spark_out_is_a_warning_with_what_is_left_and_the_turns_that_do() {
    let (code, text) = check("four_lobe_camshaft", &["infeed.spark_out_turns=2"]);
    assert_eq!(code, 1, "{text}");
    let left = number_after(&text, "2 spark-out turns leave ");
    assert!((left - 6.64).abs() < 0.05, "{text}");
    assert!(text.contains("above the tolerance of 5 um; 3 leave "), "{text}");
}

/// 500 turns of 0.72 µm: a table of 0.05 mm leaves 25 µm open, one of 0.001 mm half a micrometre.
/// A table of whole degrees makes 360 blocks, and ten times the turns of the shipped job with 3600.
#[test]
fn many_turns_from_a_table_of_few_rows_are_a_warning() {
    let folder = Folder::new("few-rows");
    let shipped = include_str!("../../params/lifts/intake.csv").lines();
    let rows: Vec<&str> = shipped.filter(|line| !line.starts_with('#')).collect();
    let whole_degrees = rows[..1].iter().chain(rows[1..].iter().step_by(10)).copied();
    std::fs::write(folder.join("degrees.csv"), whole_degrees.collect::<Vec<_>>().join("\n")).expect("it is written");
    let table =
        format!("profiles.lobes.lift={{table: {}, resolution_mm: 0.001}}", folder.join("degrees.csv").display());
    let (code, text) = check("plate_cam", &[&table]);
    assert_eq!(code, 1, "{text}");
    let words = "the table has 360 rows, so a turn has 360 blocks, and infeed.per_block_um 0.01 makes 3.60 um per turn and 100 turns";
    assert!(text.contains(words) && text.contains("plate_cam.yaml:"), "{text}");
    for remedy in ["infeed.per_block_um=0.1", "blocks_per_turn=3600"] {
        let (_, text) = check("plate_cam", &[&table, remedy]);
        assert!(!text.contains("the table has 360 rows"), "{remedy}: {text}");
    }
}

#[test]
fn many_turns_from_a_coarse_table_are_a_warning() {
    let turns = ["infeed.per_block_um=0.0002"];
    let coarse = ["profiles.intake.lift.resolution_mm=0.05"];
    let (code, text) = check("four_lobe_camshaft", &[&turns[..], &coarse].concat());
    assert_eq!(code, 1, "{text}");
    for words in [
        "profile intake: 504 turns with 0.720 um of infeed each",
        "3600 rows of 0.05 mm leave 25.",
        "use a finer table",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    for set in [&turns[..], &coarse] {
        let (code, text) = check("four_lobe_camshaft", set);
        assert!(code < 2 && !text.contains("finer than the table"), "{text}");
    }
}

/// The refusal names the largest wheel that reaches a hollow: a little less fits, a little more does not.
#[test]
fn a_hollow_that_the_wheel_does_not_reach_names_the_largest_wheel() {
    // A steep rise of 20 mm over a small base circle has concave flanks.
    let steep = "profiles.lobes.lift={segments: [{law: dwell, angle_deg: 220}, {law: 4-5-6-7, angle_deg: 70, rise_mm: 20}, \
                 {law: 4-5-6-7, angle_deg: 70, rise_mm: -20}]}";
    let base = "profiles.lobes.base_radius_mm=30";
    let (code, text) = check("plate_cam", &[steep, base, "work_speed_rpm=2"]);
    assert_eq!(code, 2, "{text}");
    assert!(
        text.contains("lobe P, profile lobes: the wheel of radius 60.000 mm does not reach into the concave flank at"),
        "{text}"
    );
    let largest = number_after(&text, "the largest usable radius is ");
    for (share, fits) in [(0.98, true), (1.001, false)] {
        let wheel = format!("wheel_radius_mm={:.4}", largest * share);
        let (code, text) = check("plate_cam", &[steep, base, "work_speed_rpm=2", &wheel]);
        assert_eq!(code < 2, fits, "{largest} mm, {wheel}: {text}");
    }
}

/// A plan prints the same sentences as a check.
#[test]
fn a_plan_prints_the_warnings() {
    let folder = Folder::new("warnings-plan");
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(["plan", "four_lobe_camshaft", "--set", "infeed.spark_out_turns=2", "--out"]);
    let output = command.arg(folder.join("plan")).output().expect("camwright runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    assert!(errors.contains("warning: ") && errors.contains("2 spark-out turns leave 6.6"), "{errors}");
}

/// A list of infeeds, the published removal law and pulses are checked with the key that is wrong and the value that fits.
#[test]
fn infeed_lists_radial_stock_and_pulses_are_checked_by_key() {
    let no_block = "infeed.per_block_um=null";
    let list = |list: &'static str| -> Vec<&'static str> { vec![no_block, list] };
    for (job, set, words) in [
        (
            "plate_cam",
            list("infeed.per_turn_um=[60, 50]"),
            "the 2 values of the infeed per turn sum to 0.11 mm, the total infeed is 0.36 mm",
        ),
        ("plate_cam", list("infeed.per_turn_um=[60, 50]"), "(set by infeed.per_turn_um=[60, 50])"),
        ("plate_cam", list("infeed.per_turn_um=[]"), "infeed.per_turn_um has 0 entries; it must have 1 to 1000"),
        ("plate_cam", list("infeed.per_turn_um=[360, 0]"), "infeed.per_turn_um.1 is 0; it must be 0.000001 to 100000"),
        ("plate_cam", vec!["infeed.per_turn_um=[300, 60]"], "infeed has both per_turn_um and per_block_um"),
        (
            "journal_runout",
            vec![no_block, "infeed.per_turn_um=[300, 60]", "identification={}"],
            "pass grind has an infeed of its own for every turn, and the stiffness is measured at one steady feed per pass",
        ),
        (
            "crank_pins",
            vec!["speed={law: constant_radial_removal_rate, removal_rate_mm2_s: 2.0}"],
            "lobe P1 is a crank pin, whose radius about the spindle axis is no contour of one value per angle",
        ),
        ("plate_cam", vec!["pulses={c_deg: 0.001, x_um: 1, step_deg: 0.7}"], "it must be a whole part of 360 deg"),
    ] {
        let (code, text) = check(job, &set);
        assert!(code == 2 && text.contains(words), "{job} {set:?}: {code}, {text}");
    }
    let (code, text) = check("plate_cam", &["pulses={c_deg: 0.001, x_um: 1, max_frequency_hz: 100000}"]);
    assert!(code == 1 && text.contains("c_axis needs 180000 pulses per second"), "{code} {text}");
    // The sum of the values of a shop is the stock: no warning.
    let (code, text) = check("plate_cam", &list("infeed.per_turn_um=[50, 50, 45, 45, 40, 40, 30, 30, 20, 10]"));
    assert_eq!(code, 0, "{text}");
}
