//! Lobes of lines and arcs, planned from the command line: X against the wheel on a flat and round a corner, and what is no outline is
//! refused.

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
