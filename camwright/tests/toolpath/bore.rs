// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel inside a bore, against closed forms and against what it sweeps.

use camwright::cam::contour::{Contour, ContourError};
use camwright::cam::follower::Follower;
use camwright::cam::form::Form;
use camwright::cam::lift::LiftLaw;
use camwright::job::grinding::InfeedDirection;
use camwright::motion::speed_plan::Cutting;
use camwright::toolpath::wheel_path::{ToolPath, ToolPathError};
use std::f64::consts::{PI, TAU};

const STEPS: u32 = 720;

fn angles() -> impl Iterator<Item = f64> {
    (0..STEPS).map(|step| TAU * f64::from(step) / f64::from(STEPS))
}

fn round(radius_mm: f64) -> Contour {
    let lift = LiftLaw::eccentric_flat(0.0, 0.0).expect("no lift");
    Contour::from_lift(&lift, &Follower::Flat, radius_mm).and_then(Contour::bore).expect("a bore")
}

/// Wall of a ring in a vane pump: two strokes a turn.
fn pump_ring() -> Contour {
    let lift = LiftLaw::from_fn(|angle| 0.75 * (1.0 - (2.0 * angle).cos())).expect("a law");
    Contour::from_lift(&lift, &Follower::KnifeEdge { offset_mm: 0.0 }, 20.0).and_then(Contour::bore).expect("a bore")
}

fn path(contour: &Contour, wheel_radius_mm: f64) -> ToolPath {
    ToolPath::for_wheel(contour, wheel_radius_mm).expect("the wheel fits")
}

#[test]
fn in_a_round_bore_x_is_minus_its_radius() {
    let path = path(&round(20.0), 12.0);
    let cutting = Cutting {
        wheel_radius_mm: 12.0,
        wheel_speed_m_s: 40.0,
        infeed_per_turn_mm: 0.01,
        infeed_direction: InfeedDirection::X,
    };
    for angle in angles() {
        let x = path.sample(angle);
        assert!((x.value + 20.0).abs() < 1e-9 && x.first.abs() < 1e-7, "{angle}: {x:?}");
        assert!(path.beta(angle).abs() < 1e-7);
        assert!((path.contact_azimuth(angle) - angle - PI).abs() < 1e-7, "{angle}: {}", path.contact_azimuth(angle));
        assert!((path.footprint_speed_ratio_mm(angle) - 20.0).abs() < 1e-6, "the contact runs along the wall");
        // 2/(1/12 - 1/20) = 60 mm: wheel and wall fit closely.
        let cut = cutting.cut(x, 2.0);
        assert!((cut.equivalent_diameter_mm - 60.0).abs() < 1e-5, "{cut:?}");
        assert!((cut.depth_mm - 0.01).abs() < 1e-12 && (cut.footprint_speed_mm_s - 40.0).abs() < 1e-5, "{cut:?}");
        assert!((cutting.removal_rate_ratio_mm2(x) - 0.2).abs() < 1e-8);
        assert!((cutting.radial_removal_rate_ratio_mm2(x) - 0.2).abs() < 1e-8);
    }
}

/// The wheel's centre goes round the centre of the bore, e off the axis, at the distance r − R.
#[test]
fn in_an_eccentric_bore_the_path_is_the_closed_form() {
    let (radius, off, wheel) = (20.0, 3.0, 12.0_f64);
    let contour = Contour::eccentric(off, radius).and_then(Contour::bore).expect("a bore");
    let path = path(&contour, wheel);
    for angle in angles() {
        let (sin, cos) = (angle + PI).sin_cos();
        let distance = off * cos + ((radius - wheel).powi(2) - (off * sin).powi(2)).sqrt();
        let x = path.sample(angle).value;
        assert!((x + distance + wheel).abs() < 2e-9, "{angle}: {x}");
        let contact = path.contact(angle);
        assert!(((contact.x - off).hypot(contact.y) - radius).abs() < 2e-6, "{angle}: {contact:?}");
        let azimuth = path.contact_azimuth(angle);
        assert!((azimuth.cos() * contact.norm() - contact.x).abs() < 1e-9 && (azimuth - angle - PI).abs() < 1.0);
    }
}

/// All wheels together sweep the bore: its wall is the farthest point of them along every ray.
#[test]
fn the_swept_wheels_leave_the_wall() {
    let (contour, wheel) = (pump_ring(), 12.0_f64);
    let path = path(&contour, wheel);
    let positions: Vec<(f64, f64)> = (0..36_000)
        .map(|step| TAU * f64::from(step) / 36_000.0)
        .map(|angle| (angle, path.sample(angle).value + wheel))
        .map(|(angle, centre)| (centre * angle.cos(), centre * angle.sin()))
        .collect();
    let mut radii = Vec::new();
    for azimuth in angles() {
        let (sin, cos) = azimuth.sin_cos();
        let farthest = positions.iter().filter_map(|(x, y)| {
            let (along, across) = (x * cos + y * sin, y * cos - x * sin);
            (across.abs() < wheel).then(|| along + (wheel * wheel - across * across).sqrt())
        });
        let radius = farthest.fold(0.0, f64::max);
        let design = 20.0 + 0.75 * (1.0 - (2.0 * azimuth).cos());
        assert!((radius - design).abs() < 2e-6, "{azimuth}: {radius} mm, design {design} mm");
        radii.push(-radius);
    }
    let form = Form::measure(&radii, &contour, 0.0).expect("radii");
    assert!(form.largest.deviation_mm.abs() < 2e-6, "{:?}", form.largest);
    // A smaller bore still has material.
    let smaller: Vec<f64> = radii.iter().map(|radius| radius + 0.01).collect();
    let form = Form::measure(&smaller, &contour, 0.0).expect("radii");
    assert!(form.deviations_mm.iter().all(|deviation| (0.0095..=0.01001).contains(deviation)), "{:?}", form.largest);
}

#[test]
fn a_wheel_that_is_too_large_is_refused_with_the_largest() {
    for (contour, wheel, largest) in [(round(20.0), 20.0, 20.0), (round(20.0), 60.0, 20.0)] {
        match ToolPath::for_wheel(&contour, wheel) {
            Err(ToolPathError::WheelFillsBore { bound_mm, .. }) => assert!((bound_mm - largest).abs() < 1e-6),
            other => panic!("{other:?}"),
        }
    }
    // The nose of the wall is tighter than its distance from the axis: radius of curvature (r² + r'²)^1.5/(r² + 2r'² − r r'').
    let tightest = angles()
        .map(|angle| {
            let (r, d, dd) = (20.75 - 0.75 * (2.0 * angle).cos(), 1.5 * (2.0 * angle).sin(), 3.0 * (2.0 * angle).cos());
            (r * r + d * d).powf(1.5) / (r * r + 2.0 * d * d - r * dd)
        })
        .fold(f64::INFINITY, f64::min);
    match ToolPath::for_wheel(&pump_ring(), 19.9) {
        Err(error @ ToolPathError::WheelFillsBore { bound_mm, .. }) => {
            assert!((bound_mm - tightest).abs() < 1e-4, "{bound_mm} {tightest}");
            assert!(error.to_string().contains("radius of curvature"), "{error}");
        }
        other => panic!("{other:?}"),
    }
    assert!(ToolPath::for_wheel(&pump_ring(), 0.99 * tightest).is_ok());
}

#[test]
fn a_crank_pin_is_no_bore() {
    let pin = Contour::pin(40.0, 25.0).expect("a pin");
    assert_eq!(pin.bore(), Err(ContourError::BoreWithThrow { throw_mm: 40.0 }));
}
