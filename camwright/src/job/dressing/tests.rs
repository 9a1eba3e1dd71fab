// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::machine::fixture::Dresser;
use crate::machine::reference::cam_grinder;
use alloc::string::ToString;

fn machine() -> MachineDescription {
    let mut machine = cam_grinder();
    machine.dresser = Some(Dresser {
        x_mm: 60.0,
        z_mm: 340.0,
        width_mm: 2.0,
        infeed_speed_mm_s: 1.0,
        traverse_speed_mm_s: 5.0,
        dwell_s: 0.2,
        max_depth_mm: 0.1,
    });
    machine.wheel.grinding_ratio = Some(100.0);
    machine
}

fn lobe(area_mm2: f64) -> LobeStock<'static> {
    LobeStock { name: "L", stock_mm: 0.3, area_mm2, wheel: None }
}

fn course(spec: DressingSpec, wheel: WheelNow, areas: &[f64]) -> Result<WheelCourse, DressError> {
    let lobes: Vec<LobeStock<'_>> = areas.iter().map(|area| lobe(*area)).collect();
    WheelCourse::new(Some(&spec), &machine(), &wheel.into(), &lobes)
}

const BY_COUNT: DressingSpec =
    DressingSpec { every_lobes: Some(2), every_parts: None, predicted_error_mm: None, depth_mm: 0.02 };

/// `R_n+1 = R_n − depth − wear`; a lobe adds area / (2π R G) times the share of its stock that the worn wheel reaches.
#[test]
fn the_radius_follows_its_recursion() {
    let areas = [36.0, 40.0, 36.0, 40.0, 36.0];
    let course = course(BY_COUNT, WheelNow::dressed(60.0), &areas).expect("a course");
    let worn = |radius: f64, wear: f64, area: f64| {
        let mut after = wear;
        for _ in 0..50 {
            after = wear + area * (1.0 - after / 0.3) / (TURN_RAD * (radius - wear) * 100.0);
        }
        after
    };
    let mut radius = 60.0;
    for (n, dress) in course.dresses.iter().enumerate() {
        assert_eq!((dress.before_lobe, dress.reason), (2 * (n + 1), DressReason::Lobes(2)));
        let wear = worn(radius, worn(radius, 0.0, areas[2 * n]), areas[2 * n + 1]);
        radius = radius - 0.02 - wear;
        assert!((dress.wear_mm - wear).abs() < 1e-9, "{dress:?}");
        assert!((dress.radius_mm() - radius).abs() <= 1e-6, "{dress:?} {radius}");
        radius = dress.radius_mm();
    }
    assert_eq!(course.dresses.len(), 2);
    assert_eq!(course.radii_mm[1].to_bits(), 60.0_f64.to_bits());
    assert_eq!(course.radii_mm[4].to_bits(), course.dresses[1].radius_mm().to_bits());
}

/// Lobes and parts ground before this job count.
#[test]
fn what_was_ground_since_the_last_dress_counts() {
    let used = WheelNow { lobes_since_dress: 2, parts_since_dress: 3, ..WheelNow::dressed(60.0) };
    let found = course(BY_COUNT, used, &[36.0, 36.0]).expect("a course");
    assert_eq!(found.dresses[0].before_lobe, 0);
    let by_parts = DressingSpec { every_lobes: None, every_parts: Some(3), ..BY_COUNT };
    let found = course(by_parts, used, &[36.0, 36.0]).expect("a course");
    assert_eq!((found.dresses.len(), found.dresses[0].reason), (1, DressReason::Parts(3)));
    let fresh = WheelNow { parts_since_dress: 2, ..used };
    assert!(course(by_parts, fresh, &[36.0, 36.0]).expect("a course").dresses.is_empty());
}

/// No lobe ends with more wear than allowed, and no dress comes a lobe too early.
#[test]
fn no_lobe_is_further_off_than_predicted_error_allows() {
    let spec = DressingSpec { every_lobes: None, predicted_error_mm: Some(0.0035), ..BY_COUNT };
    // 36 mm² wear 0.95 µm: three lobes fit, a fourth does not.
    let found = course(spec, WheelNow::dressed(60.0), &[36.0; 10]).expect("a course");
    assert!(found.wear_mm.iter().all(|wear| *wear <= 0.0035), "{found:?}");
    assert_eq!(found.dresses.iter().map(|dress| dress.before_lobe).collect::<Vec<_>>(), [3, 6, 9]);
    let error = course(spec, WheelNow::dressed(60.0), &[36.0, 360.0]).expect_err("wears 9.5 um");
    let text = error.to_string();
    assert!(text.starts_with("lobe L: its 360.00 mm2 of stock wear a dressed wheel"), "{text}");
    assert!(text.ends_with("allows 3.500 um"), "{text}");
}

#[test]
fn what_cannot_be_dressed_is_refused_with_lobe_radius_and_bound() {
    let error = course(BY_COUNT, WheelNow::dressed(45.01), &[36.0; 3]).expect_err("below 45 mm");
    let text = error.to_string();
    assert!(text.starts_with("lobe L: the dress before it leaves a wheel of radius 44.98"), "{text}");
    assert!(text.contains("wheel.min_radius_mm is 45.0000 mm"), "{text}");
    let deep = DressingSpec { depth_mm: 0.2, ..BY_COUNT };
    let text = course(deep, WheelNow::dressed(60.0), &[36.0; 3]).expect_err("too deep").to_string();
    assert!(text.contains("the dresser is allowed 100.000 um"), "{text}");
    let never = DressingSpec { every_lobes: None, ..BY_COUNT };
    assert_eq!(course(never, WheelNow::dressed(60.0), &[36.0]), Err(DressError::NoReason));
    let mut bare = machine();
    bare.dresser = None;
    let error = WheelCourse::new(Some(&BY_COUNT), &bare, &WheelNow::dressed(60.0).into(), &[lobe(36.0)]);
    assert!(matches!(error, Err(DressError::NoDresser { .. })));
    bare = machine();
    bare.wheel.grinding_ratio = None;
    let predicted = DressingSpec { predicted_error_mm: Some(0.001), ..BY_COUNT };
    let error = WheelCourse::new(Some(&predicted), &bare, &WheelNow::dressed(60.0).into(), &[lobe(36.0)]);
    assert!(matches!(error, Err(DressError::NoWear { .. })));
}

/// π((r + s)² − r²) between two circles, wherever their centre is.
#[test]
fn the_stock_of_a_disc_is_a_ring() {
    let contour = Contour::eccentric(4.2, 19.0).expect("a disc");
    let ring = 0.5 * TURN_RAD * (19.3 * 19.3 - 19.0 * 19.0);
    assert!((stock_area_mm2(&contour, 0.3) - ring).abs() < 1e-9);
}

/// A disc of radius r at eccentricity E, path of wheel R kept for R − ΔR: the error is largest where the wheel line is square
/// to the line of centres, and there, with d = √((r + R)² − E²) − ΔR,
/// √(d² + E²) − (r + R − ΔR) ≈ ΔR(1 − cos β), sin β = E/(r + R).
#[test]
fn the_error_of_a_kept_path_on_an_eccentric_is_its_closed_form() {
    for (e, r, wheel, less) in [(4.2, 19.0, 60.0, 0.025), (4.2, 19.0, 60.0, 1.0), (8.0, 25.0, 40.0, 5.0)] {
        let contour = Contour::eccentric(e, r).expect("a disc");
        let path = ToolPath::for_wheel(&contour, wheel).expect("fits");
        let found = kept_path_error(&contour, &path, wheel - less).value;
        let d = libm::sqrt((r + wheel) * (r + wheel) - e * e) - less;
        let exact = libm::sqrt(d * d + e * e) - (r + wheel - less);
        assert!((found - exact).abs() < 1e-9, "{found} {exact}");
        let sine = e / (r + wheel);
        let first_order = less * (1.0 - libm::sqrt(1.0 - sine * sine));
        assert!((found / first_order - 1.0).abs() < 2.0 * less / (r + wheel), "{found} {first_order}");
    }
}

#[test]
fn a_path_made_for_the_wheel_leaves_nothing() {
    let contour = Contour::eccentric(4.2, 19.0).expect("a disc");
    let path = ToolPath::for_wheel(&contour, 60.0).expect("fits");
    assert!(kept_path_error(&contour, &path, 60.0).value.abs() < 1e-9);
}
