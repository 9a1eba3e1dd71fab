// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cam with a pocket in its base circle, planned from the command line: the wheel's path against the closed form, and what is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

const POCKET: &str = "{law: dwell, angle_deg: 120}, {law: 4-5-6-7, angle_deg: 60, rise_mm: -2}, {law: dwell, angle_deg: 120}, \
                      {law: 4-5-6-7, angle_deg: 60, rise_mm: 2}";

fn lift(keys: &str) -> String {
    format!("profiles.lobes.lift={{{keys}segments: [{POCKET}]}}")
}

/// On both dwells the wheel touches a circle about the axis: X is its radius, 45 mm and 43 mm, within 0.01 um. On the flanks X lies between
/// these.
#[test]
fn the_wheel_goes_into_the_pocket() {
    let folder = Folder::new("pockets");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "plate_cam", "--out", &out], &[&lift("lowest_lift_mm: -2, ")]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.join("P/tool_path.csv")).expect("the path of the wheel");
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for row in text.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        rows.push((cells[0], cells[1]));
    }
    let within = |from_deg: f64, to_deg: f64| rows.iter().filter(move |row| row.0 > from_deg && row.0 < to_deg);
    let wheel_mm = rows.iter().map(|row| row.1).fold(0.0, f64::max) - 45.0;
    let bottom = within(182.0, 298.0).filter(|row| (row.1 - wheel_mm - 43.0).abs() < 1e-5).count();
    let base = within(2.0, 118.0).filter(|row| (row.1 - wheel_mm - 45.0).abs() < 1e-5).count();
    assert!(
        bottom > 200 && bottom == within(182.0, 298.0).count() && base == within(2.0, 118.0).count(),
        "{bottom} {base}"
    );
    assert!(rows.iter().all(|row| row.1 - wheel_mm < 45.0 + 1e-5 && row.1 - wheel_mm > 43.0 - 1e-5));
}

/// A lift below 0 needs the key; a pocket that is deeper than it, steeper than the wheel, or deeper than the axis is refused.
#[test]
fn a_pocket_that_is_not_declared_or_not_reached_is_refused() {
    for (set, words) in [
        (
            vec![lift("")],
            "after segment 2 the lift is -2.000000 mm, below the base circle; `lowest_lift_mm` allows lifts below the base circle",
        ),
        (vec![lift("lowest_lift_mm: -1.5, ")], "below the lowest lift, -1.5 mm,"),
        (
            vec![lift("lowest_lift_mm: -2, ").replace("120", "165").replace("60,", "15,")],
            "does not reach into the concave flank at",
        ),
        (vec![lift("lowest_lift_mm: -2, "), "profiles.lobes.base_radius_mm=1.9".to_owned()], "profile lobes"),
    ] {
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let text = refusal_of_check("plate_cam", &set);
        assert!(text.contains(words), "{set:?}: {text}");
    }
}
