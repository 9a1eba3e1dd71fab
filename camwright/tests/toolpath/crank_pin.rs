// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel on a crank pin, which goes round the spindle axis: against closed forms, and against a wheel pushed to the pin by bisection.

use camwright::cam::compensation::FormCurve;
use camwright::cam::contour::{Contour, ContourError};
use camwright::math::units::TURN_RAD;
use camwright::toolpath::wheel_path::{ToolPath, ToolPathError};

/// Throw, radius of the pin, radius of the wheel (mm): the pin of throw 40 and diameter 50 with two wheels, a disc that just misses the
/// axis, a slender pin, a long throw under a large wheel.
const PINS: [(f64, f64, f64); 5] =
    [(40.0, 25.0, 60.0), (40.0, 25.0, 300.0), (19.0, 19.0, 15.0), (30.0, 8.0, 40.0), (120.0, 35.0, 450.0)];

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

fn path(throw_mm: f64, radius_mm: f64, wheel_mm: f64) -> ToolPath {
    let pin = Contour::pin(throw_mm, radius_mm).expect("a pin");
    ToolPath::for_wheel(&pin, wheel_mm).expect("the wheel goes round the axis")
}

/// X + R = e cos θ + √(L² − e² sin² θ), L = R + r, with its first and second derivative over θ.
fn closed_form(throw_mm: f64, length_mm: f64, angle: f64) -> (f64, f64, f64) {
    let (sin, cos) = angle.sin_cos();
    let (e, q) = (throw_mm, throw_mm * throw_mm * sin * cos);
    let root = (length_mm * length_mm - e * e * sin * sin).sqrt();
    let first = -e * sin - q / root;
    let second = -e * cos - e * e * (cos * cos - sin * sin) / root - q * q / root.powi(3);
    (e * cos + root, first, second)
}

#[test]
fn x_and_its_speed_and_acceleration_have_their_closed_form() {
    for (e, r, wheel) in PINS {
        let path = path(e, r, wheel);
        let mut worst = [0.0_f64; 3];
        for angle in angles(10_007) {
            let (value, first, second) = closed_form(e, r + wheel, angle);
            let found = path.sample(angle);
            worst[0] = worst[0].max((found.value + wheel - value).abs());
            worst[1] = worst[1].max((found.first - first).abs());
            worst[2] = worst[2].max((found.second - second).abs());
        }
        // A picometre, where 0.01 µm is asked for.
        assert!(worst[0] < 1e-9, "E {e}, r {r}, R {wheel}: X {worst:?}");
        assert!(worst[1] < 1e-6 && worst[2] < 1e-3, "E {e}, r {r}, R {wheel}: {worst:?}");
    }
}

/// The triangle of axis, pin and wheel: sin β = −e sin θ/(R + r). The wheel touches the pin on the line of both centres.
#[test]
fn contact_and_its_angle_have_their_closed_form() {
    for (e, r, wheel) in PINS {
        let path = path(e, r, wheel);
        let mut before = f64::NAN;
        for angle in angles(7201) {
            let beta = -(e * angle.sin() / (r + wheel)).asin();
            assert!((path.beta(angle) - beta).abs() < 1e-8, "{angle}: {} {beta}", path.beta(angle));
            let point = path.contact(angle);
            assert!((point.norm() - r).abs() < 1e-9, "{angle}: {point}");
            let azimuth = path.contact_azimuth(angle);
            assert!((azimuth - (angle - beta)).abs() < 1e-8, "{angle}: {azimuth}");
            assert!(before.is_nan() || azimuth > before, "{angle}: the contact turns back");
            before = azimuth;
            // The contact runs along the pin by its radius per angle, and dφ/dθ = (X + R)/((R + r) cos β).
            let ratio = r * closed_form(e, r + wheel, angle).0 / ((r + wheel) * beta.cos());
            assert!((path.footprint_speed_ratio_mm(angle) - ratio).abs() < 1e-4 * ratio, "{angle}");
        }
        let turned = path.contact_azimuth(TURN_RAD + 0.3) - path.contact_azimuth(0.3);
        assert!((turned - TURN_RAD).abs() < 1e-9, "once round the pin: {turned}");
    }
}

/// Oracle: a wheel that comes along the wheel line from outside, and stops where it meets the first of 36 000 points of the pin, which are
/// written down here.
#[test]
fn a_wheel_pushed_to_the_pin_stands_where_the_path_says() {
    for (e, r, wheel) in PINS {
        let path = path(e, r, wheel);
        let points: Vec<(f64, f64)> =
            (0..36_000).map(|i| TURN_RAD * f64::from(i) / 36_000.0).map(|a| (e + r * a.cos(), r * a.sin())).collect();
        // Between two points, s apart, the wheel comes nearer by s² (1/r + 1/R)/8.
        let bulge = (r * TURN_RAD / 36_000.0).powi(2) * (1.0 / r + 1.0 / wheel) / 8.0;
        for angle in angles(179) {
            let (sin, cos) = angle.sin_cos();
            let touches = |centre: f64| {
                let (x, y) = (centre * cos, centre * sin);
                let is_near = |(at_x, at_y): &(f64, f64)| (at_x - x).powi(2) + (at_y - y).powi(2) < wheel * wheel;
                (x - e).hypot(y) < r || points.iter().any(is_near)
            };
            let (mut inside, mut outside) = (0.0, e + r + wheel + 1.0);
            // Along the line the wheel leaves the pin once.
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                if touches(middle) { inside = middle } else { outside = middle }
            }
            let found = path.sample(angle).value + wheel;
            let off = found - outside;
            assert!(
                (-1e-9..=bulge / path.beta(angle).cos() + 1e-9).contains(&off),
                "E {e}, {angle}: {found} {outside}"
            );
        }
    }
}

/// A pin larger all round by a correction runs as a pin of that radius; a correction of two waves puts every contact that far off.
#[test]
fn a_corrected_pin_is_as_far_off_as_its_correction_says() {
    let (e, r, wheel, more) = (40.0, 25.0, 60.0, 0.003);
    let contour = Contour::pin(e, r).unwrap();
    let larger = ToolPath::compensated(&contour, &FormCurve::new(more, vec![]).unwrap(), wheel).unwrap();
    for angle in angles(1009) {
        let centre = closed_form(e, r + more + wheel, angle).0;
        assert!((larger.sample(angle).value + wheel - centre).abs() < 1e-8, "{angle}");
    }
    let waves = FormCurve::new(0.0, vec![[0.0, 0.0], [0.002, -0.001]]).unwrap();
    let path = ToolPath::compensated(&contour, &waves, wheel).unwrap();
    for angle in angles(1009) {
        let (point, azimuth) = (path.contact(angle), path.contact_azimuth(angle));
        assert!((point.norm() - r - waves.sample(azimuth).value).abs() < 1e-6, "{angle}");
    }
}

#[test]
fn a_wheel_that_cannot_go_round_the_axis_is_refused_with_the_smallest() {
    let contour = Contour::pin(40.0, 25.0).unwrap();
    let smallest = contour.smallest_wheel_radius_mm().expect("a pin has one");
    assert!((smallest - (40.0 / 80.0_f64.to_radians().sin() - 25.0)).abs() < 1e-9, "{smallest}");
    for (wheel, angle) in [(10.0, "90.00"), (15.0, "90.00"), (15.3, "83.00")] {
        let error = ToolPath::for_wheel(&contour, wheel).unwrap_err();
        assert!(matches!(error, ToolPathError::WheelTooSmall { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains("throw of 40 mm") && text.contains(angle) && text.contains("at most 80 deg"), "{text}");
        assert!(text.contains("smallest usable radius is 15.617 mm"), "{text}");
    }
    ToolPath::for_wheel(&contour, smallest + 1e-6).expect("it is just large enough");
    assert!(Contour::eccentric(4.2, 19.0).unwrap().smallest_wheel_radius_mm().is_none());
}

#[test]
fn a_pin_that_is_none_is_refused() {
    for throw_mm in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Contour::pin(throw_mm, 25.0), Err(ContourError::BadThrow { .. })), "{throw_mm}");
    }
    for radius_mm in [0.0, -1.0, f64::NAN] {
        assert!(matches!(Contour::pin(40.0, radius_mm), Err(ContourError::BadBaseRadius { .. })), "{radius_mm}");
    }
}

/// Without a throw a pin is the journal that it was, to the bit.
#[test]
fn a_pin_without_a_throw_is_a_journal() {
    let (pin, journal) = (path(0.0, 20.0, 60.0), ToolPath::for_wheel(&Contour::eccentric(0.0, 20.0).unwrap(), 60.0));
    let journal = journal.unwrap();
    for angle in angles(360) {
        assert_eq!(pin.sample(angle).value.to_bits(), journal.sample(angle).value.to_bits());
        assert_eq!(pin.contact_azimuth(angle).to_bits(), journal.contact_azimuth(angle).to_bits());
    }
}
