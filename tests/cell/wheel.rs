// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel of a job from the command line: dressed within it, too large for a flank, wanted twice, too fast, in the way.

use crate::support;

use camwright_bag::Bag;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::{Domain, Folder, camwright};

fn planned(job: &str, name: &str, set: &[&str]) -> serde_json::Value {
    let folder = Folder::new(&format!("wheel-{name}"));
    let output = camwright(&["plan", job, "--json", "--out", &folder.path().display().to_string()], set);
    assert!(output.status.success(), "{job} {set:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a summary in JSON")
}

/// Refusal text of `camwright plan`.
fn refusal(job: &str, set: &[&str]) -> String {
    let folder = Folder::new("wheel-refused");
    let output = camwright(&["plan", job, "--out", &folder.path().display().to_string()], set);
    assert_eq!(output.status.code(), Some(2), "{job} {set:?} was planned");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let error = text.lines().find(|line| line.starts_with("error: "));
    error.unwrap_or_else(|| panic!("no error in {text}")).to_owned()
}

fn assert_contains(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word:?} is not in: {text}");
    }
}

/// E 4.2, r 19, wheel 60 less 20 µm: √((√(79² − 4.2²) − 0.02)² + 4.2²) − 78.98 mm is left by the path of the larger wheel.
#[test]
fn the_error_of_a_kept_path_is_reported_for_every_dress() {
    let set = [
        "machine=cam_grinder_with_dresser",
        "wheel_radius_mm=60",
        "lobes=[{name: A, station: LS1, profile: eccentric, phase_deg: 0, width_mm: 14}, \
         {name: B, station: LS2, profile: eccentric, phase_deg: 90, width_mm: 14}]",
        "dressing={every_lobes: 1, depth_um: 20}",
    ];
    let summary = planned("eccentric", "kept", &set);
    let dresses = summary["dresses"].as_array().expect("a list");
    assert_eq!(dresses.len(), 1, "{dresses:?}");
    let dress = &dresses[0];
    assert_eq!((dress["before_lobe"].as_str(), dress["reason"].as_str()), (Some("B"), Some("1 lobes ground")));
    let number = |key: &str| dress[key].as_f64().expect("a number");
    assert!((number("radius_mm") - (60.0 - 0.02 - number("wear_um") / 1e3)).abs() < 1e-6, "{dress}");
    let (e, r, wheel): (f64, f64, f64) = (4.2, 19.0, 60.0);
    let less = wheel - number("radius_mm");
    let d = ((r + wheel).powi(2) - e * e).sqrt() - less;
    let exact_um = 1e3 * (d.hypot(e) - (r + wheel - less));
    let error_um = dress["kept_path"]["error_um"].as_f64().expect("a number");
    assert!((error_um - exact_um).abs() < 1e-6 && error_um > 0.02, "{error_um} um, by its closed form {exact_um} um");
}

#[test]
fn a_wheel_that_a_dress_would_use_up_is_refused() {
    let text = refusal("dressed_batch", &["wheel_radius_mm=42.5", "dressing={every_lobes: 1, depth_um: 40}"]);
    assert_contains(&text, &["a wheel of radius 42.4", "turns at 18", "its spindle is allowed 18000.0 rpm"]);
    let slower = Folder::new("wheel-slower");
    let machine = machine_with(&slower, "max_speed_rpm: 18000.0", "max_speed_rpm: 30000.0");
    let machine = format!("machine={}", machine.display());
    let text =
        refusal("dressed_batch", &[&machine, "wheel_radius_mm=40.06", "dressing={every_lobes: 1, depth_um: 40}"]);
    assert_contains(
        &text,
        &["lobe I2: the dress before it leaves a wheel of radius 39.97", "wheel.min_radius_mm is 40.0000 mm"],
    );
}

/// A copy of the machine with a dresser, with one thing changed.
fn machine_with(folder: &Folder, from: &str, to: &str) -> PathBuf {
    let path = support::repository().join("params/machines/cam_grinder_with_dresser.yaml");
    let text = std::fs::read_to_string(path).expect("the machine");
    assert!(text.contains(from), "{from}");
    let changed = folder.join("machine.yaml");
    std::fs::write(&changed, text.replace(from, to)).expect("a machine file");
    changed
}

#[test]
fn a_wheel_beyond_its_strength_is_refused() {
    let folder = Folder::new("wheel-burst");
    let machine = machine_with(&folder, "\n  surface_speed_m_s: 80.0", "\n  surface_speed_m_s: 120.0");
    let text = refusal("dressed_batch", &[&format!("machine={}", machine.display())]);
    assert_contains(&text, &["machine.yaml:", "wheel.surface_speed_m_s is 120", "wheel.max_surface_speed_m_s, 100"]);
}

/// 9 mm of lift within 50° each way: a hollow flank that a wheel of 60 mm does not reach into.
const HOLLOW: &str = "profiles.exhaust.lift={start_deg: 130, segments: [{law: 4-5-6-7, angle_deg: 50, rise_mm: 9}, \
                      {law: 4-5-6-7, angle_deg: 50, rise_mm: -9}, {law: dwell, angle_deg: 260}]}";

#[test]
fn a_hollow_flank_names_its_lobes_the_largest_wheel_and_where() {
    let text = refusal("four_lobe_camshaft", &[HOLLOW]);
    let words = [
        "lobes E1, E2, profile exhaust: the wheel of radius 60.000 mm does not reach into the concave flank at cam angle",
        "the largest usable radius is",
        "the machine has one wheel: make a job of I1, I2 and another, with a smaller wheel, of E1, E2",
    ];
    assert_contains(&text, &words);
    let largest: f64 = text
        .split("the largest usable radius is ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .and_then(|number| number.parse().ok())
        .unwrap_or_else(|| panic!("no radius in {text}"));
    assert!(largest < 60.0 && largest > 5.0, "{largest}");
    // What it says is so, and `check` does not say it again for every lobe.
    planned(
        "four_lobe_camshaft",
        "smaller",
        &[HOLLOW, &format!("wheel_radius_mm={}", 0.9 * largest), "work_speed_rpm=20"],
    );
    let output = camwright(&["check", "four_lobe_camshaft"], &[HOLLOW]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert_eq!(text.lines().filter(|line| line.contains("does not reach into")).count(), 1, "{text}");
}

#[test]
fn a_job_for_two_wheels_is_refused_with_what_each_lobe_takes() {
    let text = refusal("four_lobe_camshaft", &[HOLLOW, "lobes.E1.wheel_radius_mm=25"]);
    let words = [
        "the machine has one wheel, of radius 60.000 mm, and the job needs 25 mm for lobe E1; lobe I1 takes any",
        "lobe E1 takes less than",
        "split it into one job per wheel",
    ];
    assert_contains(&text, &words);
    let text = refusal("rough_and_finish", &["roughing.0.wheel_radius_mm=100"]);
    assert_contains(&text, &["the job needs 100 mm for pass rough", "split it into one job per wheel"]);
    planned("rough_and_finish", "same", &["roughing.0.wheel_radius_mm=60"]);
}

#[test]
fn what_stands_in_the_wheels_way_is_named_with_how_much_is_missing() {
    let collar = "obstacles=[{name: collar, from_mm: 138, to_mm: 150, radius_mm: 25}]";
    let text = refusal("four_lobe_camshaft", &["lobes.E1.station=LS3", "lobes.I2.station=LS2", collar, "home.x_mm=20"]);
    assert_contains(&text, &["home.x_mm leaves x_axis at 20.000 mm"]);
    let wide = "obstacles=[{name: collar, from_mm: 137, to_mm: 150, radius_mm: 25}]";
    let text = refusal("four_lobe_camshaft", &[wide]);
    assert_contains(
        &text,
        &["E1: ", "where obstacle collar reaches 25.000 mm", "x_axis must stay at 26.000 mm or more", "farther out"],
    );
    planned("four_lobe_camshaft", "beside", &[collar]);
    let text = refusal("dressed_batch", &["home.x_mm=80"]);
    assert_contains(&text, &["where the headstock reaches 90.000 mm", "x_axis must stay at 91.000 mm or more"]);
    let text = refusal("four_lobe_camshaft", &["obstacles=[{name: collar, from_mm: 150, to_mm: 137, radius_mm: 25}]"]);
    assert_contains(&text, &["obstacle collar reaches from 150 to 137 mm", "it must begin before it ends"]);
}

/// Two parts on one machine: the second begins with the wheel that the first left, and the machine reports its radius.
#[test]
fn the_wheel_of_one_run_is_the_wheel_of_the_next() {
    let folder = Folder::new("wheel-run");
    let domain = Domain::reserve();
    let run = |name: &str| -> Vec<f64> {
        let bag = folder.join(name);
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
        command.env("XDG_STATE_HOME", folder.path()).args(["run", "dressed_batch", "--json", "--bag"]).arg(&bag);
        let output = command.output().expect("camwright runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        radii_mm(&bag)
    };
    let dresses = |state: &str| -> (f64, u64) {
        let number = |key: &str| {
            let line =
                state.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_else(|| panic!("{key} in {state}"));
            line.trim().parse::<f64>().expect("a number")
        };
        #[allow(clippy::cast_possible_truncation, reason = "a small count")]
        (number("wheel_radius_mm:"), number("dress_count:") as u64)
    };
    let state = || {
        let path = folder.join("camwright/cam_grinder_with_dresser.yaml");
        dresses(&std::fs::read_to_string(path).expect("what outlives a run"))
    };
    let finished = run("first");
    let (first_mm, first_count) = state();
    assert_eq!(first_count, 1);
    assert!(
        (finished[0] - 60.0).abs() < 1e-9 && (finished[finished.len() - 1] - first_mm).abs() < 1e-9,
        "{finished:?}, {first_mm}"
    );
    let finished = run("second");
    let (second_mm, second_count) = state();
    assert_eq!(second_count, 3, "its first lobe is beyond what the first part left of the wheel");
    assert!(
        (finished[0] - first_mm).abs() < 1e-9 && (finished[finished.len() - 1] - second_mm).abs() < 1e-9,
        "{finished:?}"
    );
    assert!(second_mm < first_mm - 0.006, "{second_mm}");
}

/// Wheel radii reported by a run's machine, in their order.
fn radii_mm(bag: &Path) -> Vec<f64> {
    use byteorder::LittleEndian;
    use camwright_msgs::camwright_msgs::msg::MachineDescription;
    let bag = Bag::open(bag).expect("a bag");
    let mut messages = bag.messages();
    let mut radii = Vec::new();
    while let Some(message) = messages.next_message().expect("a readable bag") {
        if bag.topics()[message.topic].name == "/machine/description" {
            // Four octets say how the rest is encoded.
            let decoded = cdr_encoding::from_bytes::<MachineDescription, LittleEndian>(&message.data[4..]);
            let (description, _) = decoded.expect("a description");
            radii.push(1e3 * description.wheel_radius);
        }
    }
    assert!(!radii.is_empty(), "the machine is in the bag");
    radii
}
