// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped ring of a vane pump, planned from the command line: X against the radius of the wall where it does not change, and what cannot
//! be ground is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

/// In the dwells the wall is round, so X is minus its radius; between them it never leaves that range.
#[test]
fn the_shipped_ring_is_planned_by_its_closed_form() {
    let folder = Folder::new("bores");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "pump_ring", "--json", "--plots", "--out", &out], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.join("R1/tool_path.csv")).expect("a path");
    let numbers = |line: &str| -> Vec<f64> { line.split(',').map(|cell| cell.parse().expect("a number")).collect() };
    let rows: Vec<Vec<f64>> = text.lines().skip(1).map(numbers).collect();
    assert_eq!(rows.len(), 3600);
    for row in &rows {
        // The wheel grinds the wall on the far side of the axis; the ring repeats after half a turn.
        let (at_deg, x_mm) = (row[0].rem_euclid(180.0), row[4]);
        assert!((-21.5 - 1e-6..=-20.0 + 1e-6).contains(&x_mm), "C {}: {x_mm} mm", row[0]);
        let radius_mm = match at_deg {
            at if (3.0..27.0).contains(&at) => 20.0,
            at if (93.0..117.0).contains(&at) => 21.5,
            _ => continue,
        };
        assert!((x_mm + radius_mm).abs() < 1e-5, "C {}: {x_mm} mm in a dwell of radius {radius_mm} mm", row[0]);
    }
}

#[test]
fn what_a_bore_cannot_have_is_refused() {
    for (set, words) in [
        (vec!["wheel_radius_mm=19.9"], ["does not fit into the bore", "must be smaller"]),
        (vec!["rapid_advance_mm=17"], ["beyond the axis in bore R1", "use a smaller wheel"]),
        (vec!["home.x_mm=20"], ["beyond the axis in bore R1", "home.x_mm"]),
        (vec!["form_compensation={}"], ["lobe R1 is a bore", "form_compensation"]),
        (
            vec!["profiles.wall.gauge={kind: flat}"],
            ["profile wall", "gauge is a follower that rides on an outer contour"],
        ),
        (
            vec![
                "profiles.wall.base_radius_mm=null",
                "profiles.wall.follower=null",
                "profiles.wall.lift={crank_pin: {throw_mm: 5, diameter_mm: 30}}",
            ],
            ["profile wall", "a crank pin is an outer contour"],
        ),
        (vec!["profiles.wall.internal=maybe"], ["internal", "maybe"]),
    ] {
        let text = refusal_of_check("pump_ring", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
    let output = camwright(&["post", "pump_ring", "--out", "/nowhere"], &[]);
    let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(output.status.code() == Some(2) && text.contains("grinds an internal contour"), "{text}");
    let output = camwright(&["check", "plate_groove"], &["profiles.two_dwells.internal=true"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert!(output.status.code() == Some(2) && text.contains("internal"), "{text}");
}
