// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::cam::contour::Contour;
use crate::cam::follower::Follower;
use crate::cam::lift::LiftLaw;
use alloc::string::ToString;
use core::f64::consts::FRAC_PI_2;

const TOLERANCE_MM: f64 = 2e-3;

fn line(x: f64, y: f64) -> OutlineSegment {
    OutlineSegment { to_mm: [x, y], radius_mm: None }
}

fn arc(x: f64, y: f64, radius_mm: f64) -> OutlineSegment {
    OutlineSegment { to_mm: [x, y], radius_mm: Some(radius_mm) }
}

fn point(outline: &Outline, azimuth_rad: f64) -> [f64; 2] {
    let radius = outline.smallest_mm() + outline.sample(azimuth_rad).value;
    [radius * libm::cos(azimuth_rad), radius * libm::sin(azimuth_rad)]
}

fn azimuths(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.37) / f64::from(count))
}

/// Curvature from the radius and its derivatives over the azimuth.
fn curvature(outline: &Outline, azimuth_rad: f64) -> f64 {
    let Sample { value, first, second, .. } = outline.sample(azimuth_rad);
    let radius = outline.smallest_mm() + value;
    let square = radius * radius + first * first;
    (radius * radius + 2.0 * first * first - radius * second) / (square * libm::sqrt(square))
}

/// Signed distance from a rectangle with rounded corners, in closed form.
fn outside_rectangle([x, y]: [f64; 2], [half_x, half_y]: [f64; 2], radius: f64) -> f64 {
    let (dx, dy) = (x.abs() - half_x + radius, y.abs() - half_y + radius);
    libm::hypot(dx.max(0.0), dy.max(0.0)) + dx.max(dy).min(0.0) - radius
}

fn rectangle(half_x: f64, half_y: f64, radius: f64) -> Result<Outline, OutlineError> {
    let (x, y) = (half_x - radius, half_y - radius);
    let segments = [
        line(half_x, y),
        arc(x, half_y, radius),
        line(-x, half_y),
        arc(-half_x, y, radius),
        line(-half_x, -y),
        arc(-x, -half_y, radius),
        line(x, -half_y),
        arc(half_x, -y, radius),
    ];
    Outline::new([half_x, -y], &segments, TOLERANCE_MM)
}

#[test]
fn a_rounded_rectangle_keeps_its_flats_and_corners() {
    for (half_x, half_y, radius) in [(15.0, 15.0, 3.0), (20.0, 9.0, 4.0), (12.0, 12.0, 0.5)] {
        let outline = rectangle(half_x, half_y, radius).expect("an outline");
        let (mut flats, mut corners) = (0, 0);
        for azimuth_rad in azimuths(20_000) {
            let off = outside_rectangle(point(&outline, azimuth_rad), [half_x, half_y], radius);
            assert!(off > -1e-9 && off < TOLERANCE_MM + 1e-9, "{half_x} {half_y} {radius} {azimuth_rad}: {off}");
            let bend = curvature(&outline, azimuth_rad);
            assert!(bend > -1e-9 && bend < 1.0 / radius + 1e-9, "{azimuth_rad}: {bend}");
            flats += u32::from(bend.abs() < 1e-9 && (off - TOLERANCE_MM).abs() < 1e-9);
            corners += u32::from((bend - 1.0 / radius).abs() < 1e-9 && off.abs() < 1e-9);
        }
        assert!(flats > 8000 && corners > 100, "{flats} {corners}");
        assert!((outline.smallest_mm() - half_x.min(half_y) - TOLERANCE_MM).abs() < 1e-12);
    }
}

#[test]
fn derivatives_are_those_of_the_curve_and_the_acceleration_has_no_jump() {
    let outline = rectangle(20.0, 9.0, 4.0).expect("an outline");
    let breaks = outline.breaks();
    let step = 1e-6;
    for azimuth_rad in azimuths(3000) {
        if breaks.iter().any(|at| around_zero(at - azimuth_rad).abs() < 2.0 * step) {
            continue;
        }
        let [before, here, after] = [-step, 0.0, step].map(|step| outline.sample(azimuth_rad + step));
        let slope = |of: fn(&Sample) -> f64| (of(&after) - of(&before)) / (2.0 * step);
        for (found, wanted) in
            [(here.first, slope(|s| s.value)), (here.second, slope(|s| s.first)), (here.third, slope(|s| s.second))]
        {
            assert!((found - wanted).abs() < 1e-6 * (1.0 + found.abs()) + 2e-4, "{azimuth_rad}: {found} {wanted}");
        }
    }
    for at in breaks {
        let (before, after) = (outline.sample(at - 1e-9), outline.sample(at + 1e-9));
        assert!((before.value - after.value).abs() < 1e-6 && (before.first - after.first).abs() < 1e-5);
        assert!((before.second - after.second).abs() < 1e-3, "{at}: {before:?} {after:?}");
    }
}

/// Random pairs of discs with a belt round them: the distance from the belt is that from its support lines.
#[test]
fn random_outlines_stay_within_their_tolerance() {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |from: f64, to: f64| {
        // xorshift64 by Marsaglia.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        from + (to - from) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    let mut made = 0;
    for _ in 0..200 {
        let (one, two) = (random(4.0, 12.0), random(3.0, 8.0));
        let apart = random(0.3, 0.9) * (one + two) + (one - two).abs();
        let (tolerance, first) = (random(2e-4, 5e-3), -0.3 * apart);
        let second = first + apart;
        let up = FRAC_PI_2 - libm::asin((one - two) / apart);
        let on = |x: f64, radius: f64, angle: f64| [x + radius * libm::cos(angle), radius * libm::sin(angle)];
        let to = |to_mm: [f64; 2], radius_mm| OutlineSegment { to_mm, radius_mm };
        let start = on(second, two, 0.0);
        let segments = [
            to(on(second, two, up), Some(two)),
            to(on(first, one, up), None),
            to(on(first, one, 2.0 * FRAC_PI_2), Some(one)),
            to(on(first, one, -up), Some(one)),
            to(on(second, two, -up), None),
            to(start, Some(two)),
        ];
        let outline = match Outline::new(start, &segments, tolerance) {
            Ok(outline) => outline,
            Err(OutlineError::PassesAxis { .. } | OutlineError::BlendsOverlap { .. }) => continue,
            Err(error) => panic!("{error}: {one} {two} {apart}"),
        };
        made += 1;
        for azimuth_rad in azimuths(300) {
            let [x, y] = point(&outline, azimuth_rad);
            let beyond = |direction: f64| {
                let (sin, cos) = libm::sincos(direction);
                x * cos + y * sin - (first * cos + one).max(second * cos + two)
            };
            let coarse = (0..720).map(|i| TURN_RAD * f64::from(i) / 720.0);
            let around = coarse.max_by(|a, b| beyond(*a).total_cmp(&beyond(*b))).expect("720 directions");
            let fine = (-200..=200).map(|i| beyond(around + f64::from(i) * TURN_RAD / 144_000.0));
            let off = fine.fold(f64::NEG_INFINITY, f64::max);
            assert!(off > -1e-6 && off < tolerance + 1e-6, "{one} {two} {apart} {azimuth_rad}: {off}");
        }
    }
    assert!(made > 100, "{made}");
}

#[test]
fn a_polygon_is_the_outline_of_its_sides() {
    let square = Outline::polygon(4, 30.0, 3.0, TOLERANCE_MM).expect("a square");
    let same = rectangle(15.0, 15.0, 3.0).expect("a square");
    for azimuth_rad in azimuths(1000) {
        assert!((square.sample(azimuth_rad).value - same.sample(azimuth_rad).value).abs() < 1e-9);
    }
    let triangle = Outline::polygon(3, 20.0, 4.0, TOLERANCE_MM).expect("a triangle");
    for azimuth_rad in azimuths(100) {
        let turned = triangle.sample(azimuth_rad + TURN_RAD / 3.0);
        assert!((turned.value - triangle.sample(azimuth_rad).value).abs() < 1e-9);
    }
}

#[test]
fn a_hollow_flank_is_an_arc_of_negative_radius() {
    // A waist between two circles of 10 mm, 24 mm apart: hollow arcs of 20 mm that touch both.
    let (r, half, hollow) = (10.0_f64, 12.0_f64, 20.0_f64);
    let y = libm::sqrt((r + hollow) * (r + hollow) - half * half);
    let (tx, ty) = (half * hollow / (r + hollow), y * r / (r + hollow));
    let segments = [
        arc(tx, ty, r),
        arc(-tx, ty, -hollow),
        arc(-half - r, 0.0, r),
        arc(-tx, -ty, r),
        arc(tx, -ty, -hollow),
        arc(half + r, 0.0, r),
    ];
    let outline = Outline::new([half + r, 0.0], &segments, TOLERANCE_MM).expect("an outline");
    let waist = outline.smallest_mm();
    assert!((waist - (y - hollow) - TOLERANCE_MM).abs() < 1e-9, "{waist}");
    let law = LiftLaw::from_outline(outline).expect("a law");
    let contour = Contour::from_lift(&law, &Follower::KnifeEdge { offset_mm: 0.0 }, waist).expect("a contour");
    let wheel = contour.largest_wheel_radius_mm().expect("it is hollow");
    assert!((wheel - (hollow - TOLERANCE_MM)).abs() < 1e-6, "{wheel}");
}

#[test]
fn a_convex_outline_takes_any_wheel() {
    let square = Outline::polygon(4, 30.0, 3.0, TOLERANCE_MM).expect("a square");
    let base_mm = square.smallest_mm();
    let law = LiftLaw::from_outline(square).expect("a law");
    let contour = Contour::from_lift(&law, &Follower::KnifeEdge { offset_mm: 0.0 }, base_mm).expect("a contour");
    assert_eq!(contour.largest_wheel_radius_mm(), None);
}

#[test]
fn segments_that_are_no_outline_are_refused() {
    let refused = |start: [f64; 2], segments: &[OutlineSegment]| {
        Outline::new(start, segments, TOLERANCE_MM).expect_err("no outline").to_string()
    };
    let refusal = |segments: &[OutlineSegment]| refused([15.0, 0.0], segments);
    let circle = [arc(-15.0, 0.0, 15.0), arc(15.0, 0.0, 15.0)];
    assert!(Outline::new([15.0, 0.0], &circle, TOLERANCE_MM).is_ok());
    assert!(refusal(&[line(15.0, 0.0), circle[0], circle[1]]).contains("segment 1 ends where it begins"));
    assert!(refusal(&[arc(-15.0, 0.0, 14.0), circle[1]]).contains("an arc of radius 14 mm does not reach"));
    assert!(refusal(&[circle[0], arc(14.0, 0.0, 15.0)]).contains("the outline is closed"));
    assert!(refusal(&[circle[0], line(15.0, 0.0)]).contains("meet at an angle of"));
    assert!(refusal(&[arc(-15.0, 0.0, -15.0), arc(15.0, 0.0, -15.0)]).contains("counterclockwise"));
    assert!(refusal(&[circle[0], arc(15.0, 0.0, f64::NAN)]).contains("segment 2: its radius (mm) is NaN"));
    assert!(refusal(&[line(f64::INFINITY, 0.0), circle[1]]).contains("segment 1: x (mm) is inf"));
    assert!(refusal(&[circle[0]]).contains("2 to 1000 are allowed"));
    let beside = refused([30.0, 0.0], &[arc(10.0, 0.0, 10.0), arc(30.0, 0.0, 10.0)]);
    assert!(beside.contains("passes the axis"), "{beside}");
    let narrow = Outline::polygon(4, 30.0, 14.9999, TOLERANCE_MM).expect_err("no flat is left").to_string();
    assert!(narrow.contains("the blends at its ends need"), "{narrow}");
    for tolerance in [0.0, -1.0, f64::NAN] {
        assert!(Outline::new([15.0, 0.0], &circle, tolerance).is_err());
    }
}
