// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes of lines and arcs, and a snail cam, planned from the command line: X against the closed form on a flat, a corner and a spiral, and
//! what is no outline is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

const WHEEL_MM: f64 = 60.0;
const BLEND_MM: f64 = 0.002;

/// Distance of the wheel's centre from the axis over the azimuth, if it touches a flat: the flat lies so far from the axis.
fn on_a_flat(flat_mm: f64, azimuth_rad: f64) -> f64 {
    (flat_mm + BLEND_MM + WHEEL_MM) / azimuth_rad.cos()
}

/// The same if it touches an arc about a point at a distance in the direction of azimuth 0.
fn on_an_arc(centre_mm: f64, radius_mm: f64, azimuth_rad: f64) -> f64 {
    let (sin, cos) = azimuth_rad.sin_cos();
    centre_mm * cos + ((radius_mm + WHEEL_MM).powi(2) - (centre_mm * sin).powi(2)).sqrt()
}

/// X equals the closed form within 0.01 µm wherever the wheel touches a flat or a corner. On the blends it lies between the two.
#[test]
fn the_wheel_follows_flats_and_corners() {
    let folder = Folder::new("punches");
    let out = folder.path().display().to_string();
    let set = format!("wheel_radius_mm={WHEEL_MM}");
    let output = camwright(&["plan", "punches", "--plots", "--out", &out], &[&set]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.join("A/tool_path.csv")).expect("the path of the wheel");
    let (mut flats, mut corners, mut between) = (0, 0, 0);
    for row in text.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let from_flat = (row[0] + 45.0).rem_euclid(90.0) - 45.0;
        let from_corner = row[0].rem_euclid(90.0) - 45.0;
        let flat = on_a_flat(15.0, from_flat.to_radians());
        let corner = on_an_arc(11.0 * 2.0_f64.sqrt(), 4.0, from_corner.to_radians());
        let (off_flat, off_corner) = (row[1] - flat, row[1] - corner);
        if off_flat.abs() < 1e-5 {
            flats += 1;
        } else if off_corner.abs() < 1e-5 {
            corners += 1;
        } else {
            between += 1;
            assert!(off_flat < 0.0 && (0.0..BLEND_MM).contains(&off_corner), "C {}: {off_flat} {off_corner}", row[0]);
        }
    }
    assert!(flats > 600 && corners > 2500 && between < 300, "{flats} {corners} {between}");
}

const NO_PHASE: &str = "lobes.B.phase_deg=0";
const POINTS: &str = "profiles.oblong.lift={table: oblong_points, reading: lines_and_arcs}";

/// The path of a wheel round the oblong of lines and arcs, from its points: where it touches a flat its distance is that of one line to a
/// nanometre, and everywhere that of the drawing within the digit of the points.
#[test]
fn the_oblong_is_found_again_in_its_points() {
    let folder = Folder::new("punches-points");
    let rows = |name: &str, set: &[&str]| -> Vec<(f64, f64)> {
        let out = folder.join(name).display().to_string();
        let output = camwright(&["plan", "punches", "--details", "--out", &out], set);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        if set.contains(&POINTS) {
            let text = String::from_utf8_lossy(&output.stdout).replace("\n  ", " ");
            assert!(text.contains("lift oblong   lines 2, arcs 4 (R 10.0000, 10.0000, 10.0000, 10.0000 mm)"), "{text}");
        }
        let text = std::fs::read_to_string(folder.join(name).join("B/tool_path.csv")).expect("the path of the wheel");
        let rows = text.lines().skip(1).map(|row| {
            let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
            (cells[0], cells[1])
        });
        rows.collect()
    };
    let set = format!("wheel_radius_mm={WHEEL_MM}");
    let (drawn, found) = (rows("drawn", &[&set, NO_PHASE]), rows("found", &[&set, NO_PHASE, POINTS]));
    assert_eq!(drawn.len(), found.len());
    let (mut flats, mut flat_mm) = (0, (f64::INFINITY, f64::NEG_INFINITY));
    for ((c_deg, drawn_mm), (_, found_mm)) in drawn.into_iter().zip(found) {
        assert!((found_mm - drawn_mm).abs() < 1e-3, "C {c_deg}: {found_mm} for {drawn_mm}");
        // Well inside of the flats at azimuth 90 and 270: the wheel touches at (10 + R) tan(azimuth - 90), at most 8 mm from its middle.
        let from_flat = ((c_deg - 90.0 + 90.0).rem_euclid(180.0) - 90.0).to_radians();
        if (from_flat.sin() * (10.0 + WHEEL_MM)).abs() < 6.0 {
            let line_mm = found_mm * from_flat.cos() - WHEEL_MM - BLEND_MM;
            flat_mm = (flat_mm.0.min(line_mm), flat_mm.1.max(line_mm));
            flats += 1;
        }
    }
    assert!(flats > 150 && (flat_mm.0 - 10.0).abs() < 5e-4, "{flats} {flat_mm:?}");
    // Symmetric points have parallel flats.
    assert!(flat_mm.1 - flat_mm.0 < 1e-9, "{flat_mm:?}");
}

/// A wrong point, a corner and a table without points are refused, with the line of the file.
#[test]
fn points_without_lines_and_arcs_are_refused() {
    let folder = Folder::new("punches-refused");
    let table = std::fs::read_to_string(support::repository().join("params/lifts/oblong_points.csv")).expect("shipped");
    let lines: Vec<&str> = table.lines().collect();
    let with = |number: usize, line: &str| {
        let mut lines = lines.clone();
        lines[number - 1] = line;
        lines.join("\n")
    };
    let square: Vec<String> = (0..80)
        .map(|i| {
            let (side, along) = (i / 20, f64::from(i % 20) - 9.5);
            let (sin, cos) = (f64::from(side) * std::f64::consts::FRAC_PI_2).sin_cos();
            format!("{:.3},{:.3}", 10.0 * cos - along * sin, 10.0 * sin + along * cos)
        })
        .collect();
    let square = format!("x_mm,y_mm\n{}\n", square.join("\n"));
    for (text, words) in [
        (
            with(45, "1.500,10.020"),
            ["points.csv:45", "um away from the nearest outline of tangent lines and arcs; allowed: 1 um"],
        ),
        (square, ["points.csv:", "two lines meet in a corner at this point"]),
        (
            format!("radius_mm\n{}", "20.0\n".repeat(360)),
            ["profile oblong", "lines_and_arcs needs points (columns x_mm and y_mm)"],
        ),
    ] {
        folder.write("points.csv", &text);
        let path = folder.join("points.csv").display().to_string();
        let set = format!("profiles.oblong.lift={{table: {path}, reading: lines_and_arcs}}");
        let text = refusal_of_check("punches", &[&set]);
        assert!(words.iter().all(|word| text.contains(word)), "{words:?}: {text}");
    }
}

/// One key wrong each: the refusal names it, what is wrong, and what would do.
#[test]
fn what_is_no_outline_is_refused() {
    let outline =
        |segments: &str| format!("profiles.oblong.lift={{outline: {{start_mm: [18, 0], segments: [{segments}]}}}}");
    for (set, words) in [
        (
            outline("{to_mm: [-18, 0], radius_mm: 18}, {to_mm: [18, 0]}"),
            ["segments 2 and 1 meet at an angle of 90.0000 deg", "it must be below 0.05 deg: put an arc"],
        ),
        (
            outline("{to_mm: [-18, 0], radius_mm: 17}, {to_mm: [18, 0], radius_mm: 18}"),
            ["segment 1", "radius 17 mm does not reach"],
        ),
        (
            outline("{to_mm: [-18, 0], radius_mm: 18}, {to_mm: [17, 0], radius_mm: 18}"),
            ["segment 2", "the outline is closed"],
        ),
        (
            "profiles.square.lift.polygon.corner_radius_mm=14.9999".into(),
            ["blends at its ends need", "smaller tolerance"],
        ),
        (
            "profiles.square.lift.polygon.corner_radius_mm=15".into(),
            ["corner radius", "below half the distance across the flats"],
        ),
        ("profiles.square.lift.polygon.sides=2".into(), ["sides is 2", "3 to 500"]),
        ("profiles.square.lift.polygon.blend_within_um=0".into(), ["blend_within_um is 0", "0.01 to 1000"]),
        ("profiles.square.base_radius_mm=15".into(), ["base_radius_mm is given", "defines the contour itself"]),
        ("profiles.square.lift.start_deg=3".into(), ["start_deg is about segments", "this lift has none"]),
    ] {
        let text = refusal_of_check("punches", &[&set]);
        for word in words {
            assert!(text.contains(word), "{set}: {word:?} is not in {text}");
        }
    }
}

/// A hollow flank bounds the wheel, and the refusal says which wheel would do.
#[test]
fn a_wheel_that_does_not_fit_into_a_hollow_is_refused() {
    // Two circles of 10 mm, 24 mm apart, and hollow arcs of 20 mm that touch both.
    let (r, half, hollow) = (10.0_f64, 12.0_f64, 20.0_f64);
    let y = ((r + hollow).powi(2) - half * half).sqrt();
    let (tx, ty, end) = (half * hollow / (r + hollow), y * r / (r + hollow), half + r);
    let set = format!(
        "profiles.oblong.lift={{outline: {{start_mm: [{end}, 0], segments: [{{to_mm: [{tx}, {ty}], radius_mm: {r}}}, \
         {{to_mm: [-{tx}, {ty}], radius_mm: -{hollow}}}, {{to_mm: [-{end}, 0], radius_mm: {r}}}, {{to_mm: [-{tx}, -{ty}], radius_mm: {r}}}, \
         {{to_mm: [{tx}, -{ty}], radius_mm: -{hollow}}}, {{to_mm: [{end}, 0], radius_mm: {r}}}]}}}}"
    );
    let text = refusal_of_check("punches", &[&set, "wheel_radius_mm=60"]);
    assert!(text.contains("19.998"), "the largest wheel: {text}");
}

/// Value at an angle between rows at even angles over a turn, by the cubic through four of them.
fn between_rows(rows: &[f64], angle_deg: f64) -> f64 {
    let place = angle_deg.rem_euclid(360.0) / 360.0 * rows.len() as f64;
    let (index, t) = (place.floor(), place.fract());
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the number of rows")]
    let first = index as usize + rows.len() - 1;
    weights.iter().enumerate().map(|(i, weight)| weight * rows[(first + i) % rows.len()]).sum()
}

/// On the spiral the centre of the roller runs on p = p0 + k φ, and that of the wheel on its parallel curve at the difference of the radii.
/// The refusal of a steeper drop names the largest wheel that reaches into its corner, and one that has a path.
#[test]
fn a_snail_cam_follows_its_spiral_and_its_drop_bounds_the_wheel() {
    let folder = Folder::new("snail");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "snail_cam", "--out", &out], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.join("S/tool_path.csv")).expect("the path of the wheel");
    let centres: Vec<f64> = (text.lines().skip(1))
        .map(|row| row.split(',').nth(1).and_then(|cell| cell.parse().ok()).expect("a number"))
        .collect();
    let (roller_mm, per_rad_mm) = (8.0, 7.6 / 270.0_f64.to_radians());
    for cam_deg in 40..260 {
        let pitch_mm = 24.0 + roller_mm + 0.2 + per_rad_mm * (f64::from(cam_deg) - 15.0).to_radians();
        let along = (WHEEL_MM - roller_mm) / pitch_mm.hypot(per_rad_mm);
        let (x, y) = (pitch_mm * (1.0 + along), -along * per_rad_mm);
        let error_mm = between_rows(&centres, f64::from(cam_deg) + y.atan2(x).to_degrees()) - x.hypot(y);
        assert!(error_mm.abs() < 1e-9, "{error_mm} mm at {cam_deg} deg");
    }

    let steeper = ["profiles.snail.lift.segments.3.angle_deg=55", "profiles.snail.lift.segments.1.angle_deg=275"];
    let text = refusal_of_check("snail_cam", &steeper);
    let radius_mm = |words: &str| -> f64 {
        let named = text.split_once(words).and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
        named.unwrap_or_else(|| panic!("no wheel is named: {text}"))
    };
    let (largest_mm, recommended_mm) = (radius_mm("the largest usable radius is "), radius_mm("mm; at most "));
    let wheel = |radius_mm: f64| format!("wheel_radius_mm={radius_mm}");
    let (fits, does_not) = (wheel(recommended_mm), wheel(largest_mm + 0.01));
    let output = camwright(&["check", "snail_cam"], &[steeper[0], steeper[1], &fits]);
    assert!(output.status.success(), "{recommended_mm} mm: {}", String::from_utf8_lossy(&output.stdout));
    let text = refusal_of_check("snail_cam", &[steeper[0], steeper[1], &does_not]);
    assert!(text.contains("does not reach into the concave flank"), "{text}");
}
