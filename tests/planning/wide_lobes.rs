// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped wide lobe, planned from the command line: number and positions of its plunges, the drawings, and what is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

const STATION_MM: f64 = 125.0;
const WHEEL_MM: f64 = 25.0;

fn planned(set: &[&str]) -> (Folder, serde_json::Value) {
    let folder = Folder::new("wide-lobes");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "wide_lobes", "--json", "--plots", "--out", &out], set);
    assert!(output.status.success(), "{set:?}: {}", String::from_utf8_lossy(&output.stderr));
    let summary = serde_json::from_slice(&output.stdout).expect("a summary in JSON");
    (folder, summary)
}

/// n = 1 + ⌈(W − B)/(B − o)⌉ plunges, flush with both ends of the lobe and evenly spaced; each with its passes and a drawing.
#[test]
fn plunges_stand_side_by_side() {
    for (width_mm, overlap_mm, count) in [(60.0, 3.0, 3_u32), (47.0, 3.0, 2), (47.1, 3.0, 3), (60.0, 8.0, 4)] {
        let set = [
            format!("lobes.W.width_mm={width_mm}"),
            format!("lobes.W.plunge_overlap_mm={overlap_mm}"),
            "roughing.0.infeed.total_mm=0.036".into(),
            "stock_mm=0.05".into(),
        ];
        let (folder, summary) = planned(&set.each_ref().map(String::as_str));
        let lobes = summary["lobes"].as_array().expect("lobes");
        let plunges: Vec<&serde_json::Value> = lobes.iter().filter(|lobe| lobe["plunge"]["lobe"] == "W").collect();
        assert_eq!(plunges.len(), count as usize, "{width_mm} mm");
        assert!(lobes.last().is_some_and(|lobe| lobe["name"] == "N" && lobe.get("plunge").is_none()));
        let spacing_mm = (width_mm - WHEEL_MM) / f64::from(count - 1);
        for (number, lobe) in (1..=count).zip(plunges) {
            let value = |key: &str| lobe["plunge"][key].as_f64().expect("a number");
            let wanted_mm = STATION_MM - 0.5 * (width_mm - WHEEL_MM) + f64::from(number - 1) * spacing_mm;
            assert!((value("z_mm") - wanted_mm).abs() < 1e-9, "{} mm, {wanted_mm} mm", value("z_mm"));
            assert!((value("overlap_mm") - (WHEEL_MM - spacing_mm)).abs() < 1e-9 && value("overlap_mm") >= overlap_mm);
            assert_eq!(lobe["passes"].as_array().map(Vec::len), Some(2));
            let name = lobe["name"].as_str().expect("a name");
            let drawing = std::fs::read_to_string(folder.join(&format!("{name}/plunges.svg"))).expect("a drawing");
            assert!(drawing.contains(&format!("W-{number} at {wanted_mm:.3} mm")) || count > 3, "{name}");
        }
    }
}

/// The table of a job for another control stands at the plunges too.
#[test]
fn programs_stand_at_the_plunges() {
    let folder = Folder::new("wide-lobe-program");
    let out = folder.path().display().to_string();
    let output = camwright(&["post", "wide_lobes", "--out", &out], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files = std::fs::read_dir(folder.path()).expect("a folder").filter_map(|entry| entry.ok()?.path().into());
    let text: String = files.filter_map(|path: std::path::PathBuf| std::fs::read_to_string(path).ok()).collect();
    for z_mm in ["Z107.5", "Z125.", "Z142.5", "Z225."] {
        assert!(text.contains(z_mm), "{z_mm} is not in the program");
    }
}

/// One key wrong each: the refusal names it, what is wrong, and what would do.
#[test]
fn wide_lobes_that_cannot_be_ground_are_refused() {
    for (set, words) in [
        (vec!["lobes.W.plunge_overlap_mm=0"], ["plunge_overlap_mm", "0.000001"]),
        (vec!["lobes.W.plunge_overlap_mm=-1"], ["plunge_overlap_mm", "-1"]),
        (
            vec!["lobes.W.plunge_overlap_mm=9"],
            ["plunge_overlap_mm is 9", "at most 8.333, a third of the wheel's 25 mm"],
        ),
        (vec!["lobes.N.width_mm=30"], ["lobe N: width 30 mm is more than the wheel's 25 mm", "plunge_overlap_mm"]),
        (vec!["lobes.W.width_mm=1500"], ["lobe W: width_mm is 1500", "at most 12 plunges"]),
        (vec!["lobes.W.width_mm=70"], ["obstacle collar", "clearance"]),
        (vec!["obstacles=[]", "lobes.N.station=LS3", "lobes.W.width_mm=100"], ["would also grind lobe N", "W-"]),
        (
            vec![
                "lobes.W.station=LS1",
                "lobes.W.width_mm=240",
                "obstacles=[]",
                "lobes=[{name: W, station: LS1, profile: pump, phase_deg: 0, width_mm: 240, plunge_overlap_mm: 3}]",
            ],
            ["z_axis", "the plunge beside the station's switch"],
        ),
        (
            vec!["machine=journal_grinder", "measure_stock={margin_um: 50}"],
            ["lobe W is wider than the wheel", "leave out measure_stock"],
        ),
        (vec!["lobes.N.name=\"W-2\""], ["both named W-2", "names must differ"]),
    ] {
        let text = refusal_of_check("wide_lobes", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
}
