// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped camshaft with two wheels, planned from the command line: visits, changes with their time, and what is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

fn planned(set: &[&str]) -> serde_json::Value {
    let folder = Folder::new("two-wheels");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "two_wheel_camshaft", "--json", "--out", &out], set);
    assert!(output.status.success(), "{set:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a summary in JSON")
}

/// All lobes are roughed before the change and finished after it. The change takes run-down, 5 s of the changer, run-up, and the way of its
/// commands; the first one waits for the wheel that runs down longest.
#[test]
fn a_change_separates_roughing_and_finishing() {
    let summary = planned(&["stock_mm=0.05", "roughing.0.infeed.total_mm=0.036"]);
    let names: Vec<&str> =
        summary["lobes"].as_array().expect("lobes").iter().filter_map(|lobe| lobe["name"].as_str()).collect();
    assert_eq!(names, ["I1-rough", "E1-rough", "I2-rough", "E2-rough", "I1", "E1", "I2", "E2"]);
    let changes = summary["wheel_changes"].as_array().expect("changes");
    let said: Vec<(&str, &str)> = (changes.iter())
        .map(|change| (change["wheel"].as_str().expect("a name"), change["before_lobe"].as_str().expect("a name")))
        .collect();
    assert_eq!(said, [("roughing", "I1-rough"), ("finishing", "I1")]);
    let commands_s = 4.0 * 2.0 * 0.1;
    for (change, (down_s, up_s)) in changes.iter().zip([(4.0, 4.0), (4.0, 1.5)]) {
        let s = change["duration_s"].as_f64().expect("a number");
        assert!((s - (down_s + 5.0 + up_s + commands_s)).abs() < 0.01 || change["before_lobe"] == "I1", "{change}");
    }
}

/// A wheel of a lobe grinds all of its passes, so such a job needs no visits; an order with needless changes is a warning.
#[test]
fn lobes_name_their_wheels() {
    let by_lobe = [
        "roughing=[]",
        "work_speed_rpm=40",
        "stock_mm=0.05",
        "lobes.I1.wheel=roughing",
        "lobes.E1.wheel=finishing",
        "lobes.I2.wheel=roughing",
        "lobes.E2.wheel=finishing",
    ];
    let summary = planned(&by_lobe);
    let wheels: Vec<&str> = (summary["wheel_changes"].as_array().expect("changes").iter())
        .filter_map(|change| change["wheel"].as_str())
        .collect();
    assert_eq!(wheels, ["roughing", "finishing", "roughing", "finishing"]);
    let set: Vec<&str> = by_lobe.iter().flat_map(|set| ["--set", set]).collect();
    let output = camwright(&[&["check", "two_wheel_camshaft"][..], &set].concat(), &[]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("needs 4 wheel changes") && text.contains("2 are enough"), "{text}");
}

/// Roughing with few spark-out turns leaves its deflection on the part: an approach of less is a warning with the value that is enough.
#[test]
fn an_approach_within_the_deflection_is_a_warning() {
    let warned = |approach: &str| {
        let set = format!("wheel_approach_mm={approach}");
        let output = camwright(&["check", "two_wheel_camshaft", "--set", &set], &[]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let text = warned("0.01");
    let enough = text.split("set wheel_approach_mm to ").nth(1).unwrap_or_else(|| panic!("no warning: {text}"));
    let enough = enough.split(' ').next().expect("a number");
    assert!(!warned(enough).contains("would meet the part"));
}

/// One key wrong each: the refusal names it, what is wrong, and what would do.
#[test]
fn wheels_that_cannot_be_mounted_are_refused() {
    for (set, words) in [
        (
            vec!["wheel=finish"],
            vec!["wheel", "no wheel finish; its wheels are roughing, finishing", "did you mean finishing"],
        ),
        (vec!["lobes.I1.wheel=small"], vec!["lobe I1: machine cam_grinder_two_wheels has no wheel small"]),
        (vec!["machine=cam_grinder"], vec!["machine cam_grinder has no wheel changer"]),
        (vec!["home.x_mm=130"], vec!["home.x_mm is 130, where the wheels are changed", "at least 140 mm"]),
        (vec!["wheel_approach_mm=0.09"], vec!["pass grind: its infeed of 0.09 mm must be more than wheel_approach_mm"]),
        (vec!["wheel_approach_mm=0"], vec!["wheel_approach_mm", "0.000001"]),
        (vec!["c_between_lobes=turns_on"], vec!["several wheels", "c_between_lobes: turns_on is not possible"]),
        (vec!["lobes.I1.width_mm=22"], vec!["lobe I1: width 22 mm is more than the wheel's 20 mm"]),
        (vec!["roughing.0.wheel_radius_mm=200"], vec!["wheel_radius_mm and wheel both say which wheel grinds"]),
    ] {
        let text = refusal_of_check("two_wheel_camshaft", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
    let folder = Folder::new("two-wheel-program");
    let out = folder.path().display().to_string();
    let output = camwright(&["post", "two_wheel_camshaft", "--out", &out], &[]);
    let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(!output.status.success() && text.contains("changes the wheel between its cuts"), "{text}");
}
