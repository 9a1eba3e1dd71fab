// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped lobes with taper and crown, planned from the command line: figures, drawing, and what is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

/// Taper goes with the width of a lobe, crown with its square; the sections are a third of the width, and the motion is that of straight lobes.
#[test]
fn the_plan_states_taper_and_crown() {
    let folder = Folder::new("tapered-lobes");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "tapered_lobes", "--json", "--plots", "--out", &out], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a summary in JSON");
    let lobes = summary["lobes"].as_array().expect("lobes");
    for (lobe, (taper_um, crown_um, width_mm)) in lobes.iter().zip([(10.0, 2.5, 12.5), (12.0, 3.6, 15.0)]) {
        let value = |key: &str| lobe["shape"][key].as_f64().expect("a number");
        for (key, wanted) in
            [("taper_um", taper_um), ("crown_um", crown_um), ("rim_taper_um", taper_um), ("rim_crown_um", crown_um)]
        {
            assert!((value(key) - wanted).abs() < 1e-9, "{key}: {}, {wanted}", value(key));
        }
        let sections = lobe["shape"]["sections"].as_array().expect("sections");
        let of_section = |key: &str| -> Vec<f64> {
            sections.iter().map(|section| section[key].as_f64().expect("a number")).collect()
        };
        let third_mm = width_mm / 3.0;
        for (offset_mm, wanted) in of_section("offset_mm").into_iter().zip([-third_mm, 0.0, third_mm]) {
            assert!((offset_mm - wanted).abs() < 1e-9, "{offset_mm}, {wanted}");
        }
        let beside_um = 4.0 * crown_um / 9.0;
        for (above_um, wanted) in
            of_section("above_um").into_iter().zip([-taper_um / 3.0 - beside_um, 0.0, taper_um / 3.0 - beside_um])
        {
            assert!((above_um - wanted).abs() < 1e-9, "{above_um}, {wanted}");
        }
        let name = lobe["name"].as_str().expect("a name");
        let drawing = std::fs::read_to_string(folder.join(&format!("{name}/shape.svg"))).expect("a drawing");
        assert!(drawing.contains(&format!("{name}-tail")) && drawing.contains("rim of the wheel"), "{name}");
    }
    let straight = |set: &[&str]| {
        let output = camwright(&["plan", "tapered_lobes", "--json", "--out", &out], set);
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a summary in JSON");
        (summary["duration_s"].as_f64().expect("a number"), summary["lobes"][0].get("shape").is_some())
    };
    let set =
        ["machine=cam_grinder", "lobes.A.taper_um=0", "lobes.A.crown_um=0", "lobes.B.taper_um=0", "lobes.B.crown_um=0"];
    assert_eq!(straight(&set), (summary["duration_s"].as_f64().expect("a number"), false));
}

/// One key wrong each: the refusal names file, line, what the wheel grinds, and the rim that would do.
#[test]
fn rims_that_grind_another_shape_are_refused() {
    for (set, words) in [
        (
            vec!["lobes.A.taper_um=-10"],
            vec![
                "tapered_lobes.yaml:",
                "lobe A: taper_um is -10.000 and crown_um 2.500; wheel grinds 10.000 and 2.500",
                "20",
            ],
        ),
        (
            vec!["machine=cam_grinder"],
            vec!["wheel grinds 0.000 and 0.000", "wheel.rim.taper_um -20.000 and wheel.rim.crown_um -10.000"],
        ),
        (
            vec!["lobes.B.taper_um=0", "lobes.B.crown_um=0"],
            vec!["lobe B: taper_um is 0.000", "wheel grinds 12.000 and 3.600", "wheel.rim.taper_um 0.000"],
        ),
        (vec!["lobes.A.crown_um=3.2"], vec!["lobe A", "0.700 um off where 0.5 um are allowed"]),
        (vec!["lobes.A.taper_um=900"], vec!["taper_um", "500"]),
        (
            vec!["lobes.A.width_mm=40", "lobes.A.plunge_overlap_mm=3"],
            vec!["lobe A is wider than the wheel", "straight rim"],
        ),
        (vec!["lobes.B.name=\"A-head\""], vec!["section A-head has the name of lobe A-head"]),
    ] {
        let text = refusal_of_check("tapered_lobes", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
}

/// A wrong rim in the machine file: the job is refused with its file and the line of the lobe.
#[test]
fn a_wrong_rim_is_refused_with_file_and_line() {
    let folder = Folder::new("wrong-rim");
    let shipped = |path: &str| std::fs::read_to_string(support::repository().join(path)).expect("a shipped file");
    let machine =
        shipped("params/machines/cam_grinder_profiled_wheel.yaml").replace("taper_um: -20.0", "taper_um: -22.0");
    let job = shipped("params/jobs/tapered_lobes.yaml")
        .replace("machine: cam_grinder_profiled_wheel", "machine: ./machine.yaml");
    let line = 1 + job.lines().position(|line| line.contains("name: B")).expect("lobe B");
    std::fs::write(folder.join("machine.yaml"), machine).expect("a file");
    std::fs::write(folder.join("job.yaml"), job).expect("a file");
    let text = refusal_of_check(&folder.join("job.yaml").display().to_string(), &[]);
    let place = format!("job.yaml:{line}: lobe B: taper_um is 12.000 and crown_um 3.600; wheel grinds 13.200");
    assert!(text.contains(&place), "{place:?} is not in {text}");
    assert!(text.contains("wheel.rim.taper_um -20.000"), "{text}");
}
