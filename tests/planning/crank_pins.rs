// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped crank pins, planned from the command line: X, contact and speed against the triangle of axis, pin and wheel, and what cannot be
//! ground is refused.

use crate::support;

use std::path::Path;
use support::{Folder, camwright, refusal_of_check};

const THROW_MM: f64 = 40.0;
const PIN_MM: f64 = 25.0;
const WHEEL_MM: f64 = 250.0;

fn planned(out: &Path, set: &[&str]) -> serde_json::Value {
    let out = out.display().to_string();
    let output = camwright(&["plan", "crank_pins", "--json", "--plots", "--out", &out], set);
    assert!(output.status.success(), "{set:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a summary in JSON")
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    text.lines().skip(1).map(numbers).collect()
}

/// Distance of the wheel's centre from the axis, and the contact angle.
fn closed_form(theta: f64) -> (f64, f64) {
    let (sin, cos) = theta.sin_cos();
    let arm = PIN_MM + WHEEL_MM;
    let root = (arm * arm - (THROW_MM * sin).powi(2)).sqrt();
    (THROW_MM * cos + root, -(THROW_MM * sin / arm).asin())
}

/// X of both pins to a hundredth of a micrometre and far below, the contact about the pin's own centre, the drawings with throw and
/// contact angle.
#[test]
fn the_shipped_pins_are_planned_by_their_closed_form() {
    let folder = Folder::new("crank-pins");
    let summary = planned(folder.path(), &[]);
    for (lobe, phase_deg) in [("P1", 0.0), ("P2", 180.0)] {
        let path = rows(&folder.join(&format!("{lobe}/tool_path.csv")));
        assert_eq!(path.len(), 3600);
        for row in &path {
            let (centre, beta) = closed_form((row[0] - phase_deg).to_radians());
            assert!((row[1] - centre).abs() < 1e-8, "{lobe}, C {}: {} mm, {centre} mm", row[0], row[1]);
            assert!((row[4] - (centre - WHEEL_MM)).abs() < 1e-8, "x_axis is one wheel radius nearer");
            let contact_deg = row[0] - phase_deg - beta.to_degrees();
            let apart = (row[2] - contact_deg + 180.0).rem_euclid(360.0) - 180.0;
            assert!(apart.abs() < 1e-6, "{lobe}, C {}: contact at {}, {contact_deg} expected", row[0], row[2]);
        }
        let lowest = path.iter().map(|row| row[4]).fold(f64::INFINITY, f64::min);
        assert!((lowest - (PIN_MM - THROW_MM)).abs() < 1e-6, "the wheel passes the axis: {lowest} mm");
        let drawing = std::fs::read_to_string(folder.join(&format!("{lobe}/contour.svg"))).expect("a drawing");
        assert!(
            drawing.contains("40.000 mm") && drawing.contains("8.36°"),
            "{lobe}: throw and contact angle are drawn"
        );
    }
    for lobe in summary["lobes"].as_array().expect("lobes") {
        let pin = |key: &str| lobe["crank_pin"][key].as_f64().expect("a number");
        assert!((pin("throw_mm") - THROW_MM).abs() < 1e-12);
        assert!((pin("max_contact_angle_deg") - (40.0_f64 / 275.0).asin().to_degrees()).abs() < 1e-9);
    }
}

/// In the turns of the finishing pass the contact runs along the pin at 40 mm/s: C times r dφ/dθ, with
/// dφ/dθ = (X + R)/((R + r) cos β). The roughing pass keeps to its removal rate.
#[test]
fn contact_speed_and_removal_rate_are_those_of_the_job() {
    let folder = Folder::new("crank-pin-speeds");
    let summary = planned(folder.path(), &[]);
    let speed = rows(&folder.join("P1/speed_plan.csv"));
    let footprint = |row: &Vec<f64>| {
        let (centre, beta) = closed_form(row[0].to_radians());
        row[2] * PIN_MM * centre / ((PIN_MM + WHEEL_MM) * beta.cos())
    };
    let finishing: Vec<&Vec<f64>> = speed.iter().filter(|row| row[9] > 1.5).collect();
    let middle = &finishing[finishing.len() / 4..3 * finishing.len() / 4];
    assert!(middle.len() > 1000, "{} rows", middle.len());
    // The speed plan stays a little below a bound between its knots.
    for row in middle {
        assert!((39.6..40.01).contains(&footprint(row)), "C {}: {} mm/s", row[0], footprint(row));
    }
    let mean = middle.iter().map(|row| footprint(row)).sum::<f64>() / middle.len() as f64;
    assert!((mean - 40.0).abs() < 0.05, "{mean} mm/s");
    let spread = |rows: &[&Vec<f64>]| {
        let speeds = rows.iter().map(|row| row[2]);
        let (low, high) = speeds.fold((f64::INFINITY, 0.0_f64), |(low, high), c| (low.min(c), high.max(c)));
        high / low
    };
    // C runs slower where the pin stands out: by (R + r + e)/(R + r − e).
    let expected = (PIN_MM + WHEEL_MM + THROW_MM) / (PIN_MM + WHEEL_MM - THROW_MM);
    assert!((spread(middle) - expected).abs() < 0.01, "{} {expected}", spread(middle));
    for lobe in summary["lobes"].as_array().expect("lobes") {
        let rough = &lobe["passes"][0];
        let max = rough["max_removal_mm2_s"].as_f64().expect("a rate");
        assert!(rough["speed_law"] == "constant_removal_rate" && max > 1.3 && max <= 1.5 * 1.02, "{max}");
    }
}

/// One key wrong each: the refusal names it, what is wrong, and what would do.
#[test]
fn pins_that_cannot_be_ground_are_refused() {
    let throw = |throw_mm: u32| format!("profiles.pin.lift={{crank_pin: {{throw_mm: {throw_mm}, diameter_mm: 50}}}}");
    let far = throw(320);
    for (set, words) in [
        (vec![far.as_str()], ["too small for the throw of 320 mm", "the smallest usable radius is 299.937 mm"]),
        (vec![&throw(60)], ["x_axis", "-25"]),
        (vec!["rapid_advance_mm=60"], ["lobe P2 with its stock reaches 65.150 mm", "rapid_advance_mm"]),
        (vec!["home.x_mm=60"], ["home.x_mm must be", "reach"]),
        (vec!["obstacles.web 2.from_mm=91"], ["obstacle web 2", "clearance"]),
        (vec!["lobes.P1.width_mm=30"], ["lobe P1", "wheel"]),
        (
            vec!["machine=journal_grinder", "measure_stock={margin_um: 50}", "obstacles=[]", "wheel_radius_mm=60"],
            ["lobe P1 is a crank pin", "measures about the spindle axis"],
        ),
        (vec!["profiles.pin.gauge={kind: flat}"], ["gauge", "a crank pin is measured about its own centre"]),
        (
            vec!["work_speed_rpm=140", "speed={law: constant_work_speed}"],
            ["work speed of 140 rpm", "the largest work speed that fits"],
        ),
    ] {
        let text = refusal_of_check("crank_pins", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
}

/// Neither a mill nor a lathe follows a pin; both say so.
#[test]
fn a_pin_is_refused_where_it_is_not_ground() {
    let pin = "profiles.disc.lift={eccentric: {eccentricity_mm: 40, diameter_mm: 50, diameter_is: disc}}";
    let output = camwright(&["check", "eccentric_disc"], &[pin]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("only a grinding job makes a crank pin"), "{text}");
}
