// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Outlines found again in their points.

use super::*;
use crate::cam::outline::Outline;
use crate::math::random::unit_numbers;

/// Points on lines and arcs about corners: the closed form of a convex polygon of corners (x, y, radius).
fn points_of(corners: &[(f64, f64, f64)], per_arc: usize, step_mm: f64, digit_mm: f64) -> Vec<ContourPoint> {
    let count = corners.len();
    let centre = |i: usize| Vector2::new(corners[i % count].0, corners[i % count].1);
    // Normal of the common tangent of two neighbours, outside of both.
    let normal = |i: usize| {
        let (way, shrink) = (centre(i + 1) - centre(i), corners[i % count].2 - corners[(i + 1) % count].2);
        azimuth(way) - 0.5 * PI + libm::asin(shrink / way.norm())
    };
    let mut points = Vec::new();
    for i in 0..count {
        let (before, after) = (normal(i + count - 1), normal(i));
        let turn = wrap_turn(after - before);
        for k in 0..per_arc {
            points.push(centre(i) + corners[i].2 * unit(before + turn * (k as f64 + 0.5) / per_arc as f64));
        }
        let from = centre(i) + corners[i].2 * unit(after);
        let to = centre(i + 1) + corners[(i + 1) % count].2 * unit(after);
        let steps = libm::ceil((to - from).norm() / step_mm);
        let mut k = 0.5;
        while k < steps {
            points.push(from + (to - from) * (k / steps));
            k += 1.0;
        }
    }
    let rounded = |value: f64| libm::round(value / digit_mm) * digit_mm;
    let point = |(line, point): (usize, &Vector2<f64>)| ContourPoint {
        line: line + 1,
        x_mm: rounded(point.x),
        y_mm: rounded(point.y),
    };
    points.iter().enumerate().map(point).collect()
}

/// Rectangle 36 by 20 mm with corners of 4 mm, at 1 µm: its drawing is found again, and its flats are flat.
#[test]
fn a_rounded_rectangle_is_found_again() {
    let corners = [(14.0, -6.0, 4.0), (14.0, 6.0, 4.0), (-14.0, 6.0, 4.0), (-14.0, -6.0, 4.0)];
    let fitted = lines_and_arcs(&points_of(&corners, 12, 0.4, 0.001), 0.001).expect("an outline");
    assert_eq!((fitted.segments.len(), fitted.lines()), (8, 4));
    let radii: Vec<f64> = fitted.segments.iter().filter_map(|segment| segment.radius_mm).collect();
    assert!(radii.iter().all(|radius| (radius - 4.0).abs() < 1e-3), "{radii:?}");
    let outline = Outline::new(fitted.start_mm, &fitted.segments, 0.002).expect("a smooth outline");
    // The distance of the middle of each flat, and the flat beside it: a line has the distance d/cos.
    for (azimuth_rad, distance_mm) in [(0.0, 18.0), (0.5 * PI, 10.0), (PI, 18.0), (1.5 * PI, 10.0)] {
        let at = |angle: f64| outline.sample(azimuth_rad + angle).value + outline.smallest_mm();
        assert!((at(0.0) - distance_mm).abs() < 0.003, "{} at {azimuth_rad}", at(0.0));
        let tilt = (at(0.2) - at(-0.2)) / (2.0 * libm::sin(0.2));
        for angle in [-0.2, -0.1, 0.1, 0.2] {
            let line = at(angle) * libm::cos(angle) - tilt * libm::sin(angle);
            assert!((line - at(0.0)).abs() < 2e-5, "{} um", 1e3 * (line - at(0.0)));
        }
    }
}

/// Random convex polygons with other radii at each corner: every element is that of the drawing.
#[test]
fn random_polygons_are_found_again() {
    let mut unit_number = unit_numbers(2711);
    let mut between = move |from: f64, to: f64| from + (to - from) * unit_number();
    for case in 0..200 {
        let count = 3 + case % 5;
        let turn = between(0.0, TURN_RAD);
        let corners: Vec<(f64, f64, f64)> = (0..count)
            .map(|i| {
                let angle = turn + TURN_RAD * (i as f64 + between(-0.15, 0.15)) / count as f64;
                let distance = between(14.0, 18.0);
                (distance * libm::cos(angle), distance * libm::sin(angle), between(2.0, 5.0))
            })
            .collect();
        let digit_mm = [1e-3, 1e-4][case % 2];
        let points = points_of(&corners, 16, 0.5, digit_mm);
        let fitted =
            lines_and_arcs(&points, digit_mm).unwrap_or_else(|error| panic!("case {case}: {error} {corners:?}"));
        assert!(fitted.max_deviation_mm <= digit_mm);
        assert_eq!(fitted.lines(), count, "case {case}");
        let radii = fitted.segments.iter().filter(|segment| segment.radius_mm.is_some()).count();
        assert_eq!(radii, count, "case {case}");
        // The points before their rounding, others between them, lie on the outline.
        let outline = Outline::new(fitted.start_mm, &fitted.segments, 1e-6)
            .unwrap_or_else(|error| panic!("case {case}: {error}"));
        for point in points_of(&corners, 37, 0.3, 1e-12) {
            let radius_mm = outline.sample(libm::atan2(point.y_mm, point.x_mm)).value + outline.smallest_mm();
            let error_mm = radius_mm - libm::hypot(point.x_mm, point.y_mm);
            assert!(error_mm.abs() < 2.0 * digit_mm, "case {case}: {error_mm} mm at {point:?}");
        }
    }
}

/// Arcs alone, one of them hollow: a kidney of four arcs.
#[test]
fn hollow_arcs_are_found_again() {
    // Ends of radius 8 about (±12, 0), a back of radius 20 + 8 about (0, y) outside, a waist of radius 40 from above.
    let (end, hollow) = (8.0, 40.0);
    let waist = Vector2::new(0.0, libm::sqrt((hollow + end) * (hollow + end) - 144.0));
    let back = 30.0;
    let below = Vector2::new(0.0, libm::sqrt((back - end) * (back - end) - 144.0));
    let mut points = Vec::new();
    let mut arc = |centre: Vector2<f64>, radius: f64, from: f64, to: f64| {
        let count = libm::ceil((to - from).abs() * radius.abs() / 0.4);
        let mut k = 0.5;
        while k < count {
            points.push(centre + radius.abs() * unit(from + (to - from) * k / count));
            k += 1.0;
        }
    };
    let (right, left) = (Vector2::new(12.0, 0.0), Vector2::new(-12.0, 0.0));
    let at_back = |centre: Vector2<f64>| azimuth(centre - below);
    let at_waist = |centre: Vector2<f64>| azimuth(waist - centre);
    arc(right, end, at_back(right), at_waist(right));
    arc(waist, -hollow, at_waist(right) - PI, at_waist(left) - PI);
    arc(left, end, at_waist(left), at_back(left) + TURN_RAD);
    arc(below, back, at_back(left), at_back(right) - 0.0);
    let points: Vec<ContourPoint> = (points.iter().enumerate())
        .map(|(line, point)| ContourPoint { line: line + 1, x_mm: point.x, y_mm: point.y })
        .collect();
    let fitted = lines_and_arcs(&points, 1e-4).expect("an outline");
    let mut radii: Vec<f64> = fitted.segments.iter().filter_map(|segment| segment.radius_mm).collect();
    radii.sort_by(f64::total_cmp);
    radii.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let expected = [-40.0, 8.0, 8.0, 30.0];
    assert!(
        radii.len() <= 4 && radii.iter().all(|radius| expected.iter().any(|wanted| (radius - wanted).abs() < 1e-6)),
        "{radii:?}"
    );
}

#[test]
fn what_is_no_outline_of_lines_and_arcs_is_refused_with_its_place() {
    let square = [(10.0, -10.0), (10.0, 10.0), (-10.0, 10.0), (-10.0, -10.0)];
    let mut points = Vec::new();
    for (i, (x, y)) in square.iter().enumerate() {
        let (to_x, to_y) = square[(i + 1) % 4];
        for k in 0..20 {
            let share = f64::from(k) / 20.0;
            let line = points.len() + 1;
            points.push(ContourPoint { line, x_mm: x + share * (to_x - x), y_mm: y + share * (to_y - y) });
        }
    }
    let error = lines_and_arcs(&points, 1e-3).expect_err("corners");
    assert!(matches!(error, OutlineFitError::Corner { line } if (line - 1) % 20 <= 1), "{error:?}");

    // A point that lies wrong.
    let corners = [(14.0, -6.0, 4.0), (14.0, 6.0, 4.0), (-14.0, 6.0, 4.0), (-14.0, -6.0, 4.0)];
    let mut points = points_of(&corners, 12, 0.4, 0.001);
    points[30].x_mm += 0.02;
    let error = lines_and_arcs(&points, 0.001).expect_err("a wrong point");
    let OutlineFitError::TooFar { line: 31, deviation_um, .. } = error else { panic!("{error:?}") };
    assert!((deviation_um - 20.0).abs() < 2.0, "{deviation_um}");

    assert!(matches!(lines_and_arcs(&points, 0.0), Err(OutlineFitError::Tolerance { .. })));
    assert!(matches!(lines_and_arcs(&points[..10], 0.001), Err(OutlineFitError::Points(_))));
    // An ellipse has no arc of its own anywhere.
    let ellipse: Vec<ContourPoint> = (0..3600_u32)
        .map(|i| {
            let (sin, cos) = libm::sincos(TURN_RAD * f64::from(i) / 3600.0);
            ContourPoint { line: i as usize + 1, x_mm: 30.0 * cos, y_mm: 20.0 * sin }
        })
        .collect();
    let error = lines_and_arcs(&ellipse, 1e-6).expect_err("no arcs");
    assert!(matches!(error, OutlineFitError::TooMany { .. }), "{error:?}");
}

#[test]
fn a_disc_is_two_arcs() {
    let disc: Vec<ContourPoint> = (0..360_u32)
        .map(|i| {
            let (sin, cos) = libm::sincos(TURN_RAD * f64::from(i) / 360.0);
            ContourPoint { line: i as usize + 1, x_mm: 2.0 + 20.0 * cos, y_mm: 20.0 * sin }
        })
        .collect();
    let fitted = lines_and_arcs(&disc, 1e-4).expect("a disc");
    assert_eq!(fitted.segments.len(), 2);
    assert!(fitted.segments.iter().all(|segment| segment.radius_mm.is_some_and(|radius| (radius - 20.0).abs() < 1e-9)));
}
