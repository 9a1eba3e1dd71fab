// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::machine::description::Axis;
use crate::machine::reference::cam_grinder;
use crate::math::units::TURN_RAD;

const STEP_S: f64 = 0.25e-3;

fn servo(drive: DriveSettings) -> Servo {
    let mut axis = cam_grinder().axis(Axis::X).clone();
    axis.drive = drive;
    Servo::new(&axis, STEP_S)
}

fn drive(kv: f64, ff: f64, bandwidth: Option<f64>) -> DriveSettings {
    DriveSettings {
        kv_1_s: kv,
        velocity_feed_forward: ff,
        acceleration_feed_forward: 0.0,
        velocity_loop_rad_s: bandwidth,
        ..DriveSettings::IDEAL
    }
}

/// A drive with everything that is in the way of a good one.
fn ordinary() -> DriveSettings {
    DriveSettings {
        velocity_integral_s: Some(0.01),
        coulomb_friction: 40.0,
        viscous_friction: 0.3,
        encoder_step_counts: 1.0,
        ..drive(200.0, 0.99, Some(120.0 * TURN_RAD))
    }
}

/// Drives an axis along a path (counts over s) with its two derivatives; calls `see` with time, setpoint and drive after every step.
fn follow(servo: &mut Servo, steps: u32, way: impl Fn(f64) -> [f64; 3], mut see: impl FnMut(f64, f64, &Servo)) {
    for k in 1..=steps {
        let (from, to) = (f64::from(k - 1) * STEP_S, f64::from(k) * STEP_S);
        let [position, velocity, _] = way(to);
        let distance = position - way(from)[0];
        let acceleration = way(0.5 * (from + to))[2];
        servo.step(ServoCommand { position, distance, velocity, acceleration, disturbance: 0.0 });
        see(to, position, servo);
    }
}

fn sine(amplitude: f64, w: f64) -> impl Fn(f64) -> [f64; 3] {
    move |t| [amplitude * libm::sin(w * t), amplitude * w * libm::cos(w * t), -amplitude * w * w * libm::sin(w * t)]
}

/// Constant speed v: following error v (1 − ff)/Kv, with and without a lag in the velocity loop, with and without its integral.
#[test]
fn at_constant_speed_the_error_is_speed_over_gain() {
    let v = 2.0e6;
    let integral = DriveSettings { velocity_integral_s: Some(0.01), ..drive(150.0, 0.97, Some(500.0)) };
    let wrong = DriveSettings { gain_error: 0.1, ..drive(100.0, 0.0, Some(600.0)) };
    for drive in [
        drive(100.0, 0.0, None),
        drive(300.0, 0.9, None),
        drive(100.0, 0.0, Some(600.0)),
        drive(150.0, 0.97, Some(500.0)),
        integral,
        wrong,
    ] {
        let mut servo = servo(drive);
        follow(&mut servo, 40_000, |t| [v * t, v, 0.0], |_, _, _| {});
        let expected = v * (1.0 - drive.velocity_feed_forward) / (drive.kv_1_s * (1.0 + drive.gain_error));
        assert!((servo.error() - expected).abs() < 1e-5 * expected, "{} {expected}", servo.error());
        assert!((servo.velocity() - v).abs() < 1e-6 * v);
    }
}

/// From rest, a step to speed v gives e(t) = v (1 − ff)/Kv (1 − exp(−Kv t)) with an ideal velocity loop.
#[test]
fn the_error_of_a_ramp_grows_exponentially() {
    let (v, kv) = (1.0e6, 120.0);
    let mut servo = servo(drive(kv, 0.0, None));
    let see = |t: f64, _: f64, servo: &Servo| {
        let expected = v / kv * (1.0 - libm::exp(-kv * t));
        assert!((servo.error() - expected).abs() < 1e-6 * v / kv, "{t}");
    };
    follow(&mut servo, 400, |t| [v * t, v, 0.0], see);
}

/// Behind a velocity loop of bandwidth w the same step gives the lag of second order s²/w + s + Kv; the drive samples, and looks back
/// by a step, which is worth some of them.
#[test]
fn the_error_of_a_ramp_is_that_of_the_second_order_lag() {
    let (v, kv, w) = (1.0e6, 100.0, 600.0);
    for integral in [None, Some(0.01)] {
        let mut servo = servo(DriveSettings { velocity_integral_s: integral, ..drive(kv, 0.0, Some(w)) });
        let root = libm::sqrt(w * w - 4.0 * kv * w);
        let (fast, slow) = (0.5 * (w + root), 0.5 * (w - root));
        // ë + w ė + w Kv e = w v from e = 0, ė = v.
        let rest = v / kv;
        let a = (v - rest * fast) / (fast - slow);
        let b = -rest - a;
        let see = |t: f64, _: f64, servo: &Servo| {
            let expected = rest + a * libm::exp(-slow * t) + b * libm::exp(-fast * t);
            assert!((servo.error() - expected).abs() < v * 2.0 * STEP_S, "{t}: {} {expected}", servo.error());
        };
        follow(&mut servo, 400, |t| [v * t, v, 0.0], see);
    }
}

#[test]
fn an_ideal_drive_is_exactly_at_its_setpoint() {
    let mut servo = servo(DriveSettings::IDEAL);
    for k in 0..10_000_u32 {
        let distance = f64::from((k * 7919) % 1000) - 500.0;
        let moved = servo.step(ServoCommand { distance, velocity: distance / STEP_S, ..ServoCommand::default() });
        assert_eq!((moved.to_bits(), servo.error().to_bits()), (distance.to_bits(), 0.0_f64.to_bits()));
    }
}

/// Part of a sine of amplitude A and frequency W that a lag leaves in size (not in time): with a loop (Kv + ff s)/(s + Kv) it comes out
/// as A |(Kv + ff jW)/(Kv + jW)|, that is smaller by A W²/Kv² ((1 − ff) − (1 − ff)²/2) to second order.
#[test]
fn a_first_order_lag_leaves_the_residual_of_its_second_order() {
    let (amplitude, w) = (3.0e5, TURN_RAD * 3.0);
    for (kv, ff) in [(100.0, 0.0), (100.0, 0.5), (300.0, 0.0), (300.0, 0.9)] {
        let mut servo = servo(drive(kv, ff, None));
        let mut largest = 0.0_f64;
        let see = |t: f64, position: f64, servo: &Servo| {
            if t > 2.5 {
                largest = largest.max((position - servo.error()).abs());
            }
        };
        follow(&mut servo, 20_000, sine(amplitude, w), see);
        let expected = amplitude * libm::hypot(kv, ff * w) / libm::hypot(kv, w);
        assert!((largest - expected).abs() < 1e-5 * amplitude, "{largest} {expected}");
        let lacking = 1.0 - ff;
        let residual = amplitude * w * w / (kv * kv) * (lacking - 0.5 * lacking * lacking);
        assert!((amplitude - largest - residual).abs() < 0.05 * residual, "{} {residual}", amplitude - largest);
    }
}

/// With whole feed-forward and the force that the mass needs a drive with a motor follows a smooth setpoint.
#[test]
fn whole_feed_forward_leaves_little_of_the_lag() {
    let run = |settings: DriveSettings| {
        let mut servo = servo(settings);
        let mut largest = 0.0_f64;
        let see = |t: f64, _: f64, servo: &Servo| {
            if t > 2.5 {
                largest = largest.max(servo.error().abs());
            }
        };
        follow(&mut servo, 20_000, sine(3.0e5, TURN_RAD * 3.0), see);
        largest
    };
    let without = run(drive(200.0, 0.0, Some(628.0)));
    let whole = DriveSettings { acceleration_feed_forward: 1.0, ..drive(200.0, 1.0, Some(628.0)) };
    assert!(run(whole) < 1e-5 * without, "{} {without}", run(whole));
    let integral = DriveSettings { velocity_integral_s: Some(0.01), ..whole };
    assert!(run(integral) < 1e-5 * without, "{} {without}", run(integral));
}

/// A lasting force F holds a drive that has only gains off by F/(m w Kv); the integral of the velocity loop takes that away.
#[test]
fn a_lasting_force_leaves_what_the_gains_allow_and_the_integral_nothing() {
    let axis = cam_grinder().axis(Axis::X).clone();
    let (force, kv, w) = (300.0, 200.0, 700.0);
    let mut stiff = servo(drive(kv, 1.0, Some(w)));
    let mut integral = servo(DriveSettings { velocity_integral_s: Some(0.01), ..drive(kv, 1.0, Some(w)) });
    for _ in 0..8000 {
        for servo in [&mut stiff, &mut integral] {
            servo.step(ServoCommand { disturbance: force, ..ServoCommand::default() });
        }
    }
    // The axis is pushed ahead of its setpoint.
    let expected = -force * 1e3 / (axis.inertia * w * kv) * axis.scale.counts_per_unit();
    assert!((stiff.error() - expected).abs() < 1e-6 * expected.abs(), "{} {expected}", stiff.error());
    assert!(integral.error().abs() < 1e-6 * expected.abs(), "{}", integral.error());
    for servo in [stiff, integral] {
        assert!((servo.force().expect("a motor") + force).abs() < 1e-3, "the motor holds against it");
    }
}

/// At a reversal friction turns round, 2 Fc: the gains alone would deflect by 2 Fc/(m w Kv) before the integral has it; a drive that
/// knows its friction leaves a small part of that.
#[test]
fn friction_leaves_its_mark_at_reversals_and_feed_forward_wipes_it_off() {
    let axis = cam_grinder().axis(Axis::X).clone();
    let run = |settings: DriveSettings| {
        let mut servo = servo(settings);
        let mut largest = 0.0_f64;
        let see = |t: f64, _: f64, servo: &Servo| {
            if t > 1.0 {
                largest = largest.max(servo.error().abs());
            }
        };
        follow(&mut servo, 8000, sine(2.0e5, TURN_RAD), see);
        largest
    };
    let whole = DriveSettings {
        acceleration_feed_forward: 1.0,
        velocity_integral_s: Some(0.02),
        coulomb_friction: 40.0,
        ..drive(200.0, 1.0, Some(700.0))
    };
    let bound = 2.0 * 40.0 * 1e3 / (axis.inertia * 700.0 * 200.0) * axis.scale.counts_per_unit();
    let marked = run(whole);
    assert!(marked > 0.3 * bound && marked < bound, "{marked} {bound}");
    let wiped = run(DriveSettings { friction_feed_forward: 1.0, ..whole });
    assert!(wiped < 0.1 * marked, "{wiped} {marked}");
    assert!(run(DriveSettings { coulomb_friction: 0.0, ..whole }) < 1e-3 * bound);
}

/// The tool is behind by half the play on the way out, ahead by as much on the way back.
#[test]
fn backlash_is_the_difference_between_both_directions() {
    let axis = cam_grinder().axis(Axis::X).clone();
    let whole = DriveSettings { backlash: 0.004, acceleration_feed_forward: 1.0, ..drive(200.0, 1.0, Some(700.0)) };
    let mut servo = servo(whole);
    let mut tool = [0.0; 2];
    let see = |t: f64, position: f64, servo: &Servo| {
        let passing = libm::cos(TURN_RAD * t);
        if position.abs() < 2e3 && t > 0.2 {
            tool[usize::from(passing < 0.0)] = servo.tool_ahead() - servo.error();
        }
    };
    follow(&mut servo, 8000, sine(2.0e5, TURN_RAD), see);
    let counts = 0.004 * axis.scale.counts_per_unit();
    assert!((tool[1] - tool[0] - counts).abs() < 1.0, "{tool:?} {counts}");
}

/// An encoder that shows counts lets the axis wander within a count or so of where an exact one holds it, for ever; noise a little more.
#[test]
fn an_encoder_in_counts_holds_the_axis_within_counts() {
    let whole = DriveSettings { acceleration_feed_forward: 1.0, ..drive(200.0, 1.0, Some(700.0)) };
    for (step, noise, integral, max) in
        [(1.0, 0.0, None, 1.0), (1.0, 0.0, Some(0.01), 1.0), (1.0, 0.5, Some(0.01), 2.0), (20.0, 0.0, Some(0.01), 20.0)]
    {
        let coarse = DriveSettings {
            encoder_step_counts: step,
            encoder_noise_counts: noise,
            velocity_integral_s: integral,
            ..whole
        };
        let mut servo = servo(coarse);
        let mut largest = 0.0_f64;
        let see = |t: f64, _: f64, servo: &Servo| {
            if t > 0.5 {
                largest = largest.max(servo.error().abs());
            }
        };
        follow(&mut servo, 20_000, |t| [1234.5 * t, 1234.5, 0.0], see);
        assert!(largest < max && largest > 1e-3, "{step} {noise}: {largest}");
    }
}

/// A motor that cannot give what is asked gives what it can: the error grows as the way that is missing. Nothing winds up meanwhile: when
/// the setpoint rests the axis swings past it no farther than without an integral, and comes to its setpoint.
#[test]
fn a_motor_at_its_limit_falls_behind_and_does_not_wind_up() {
    let axis = cam_grinder().axis(Axis::X).clone();
    let counts = axis.scale.counts_per_unit();
    let run = |integral_s: Option<f64>, friction: f64| {
        // 400 N on 400 kg: 1 m/s², where 3 are asked for 0.1 s.
        let weak = DriveSettings {
            max_force: Some(400.0),
            acceleration_feed_forward: 1.0,
            velocity_integral_s: integral_s,
            coulomb_friction: friction,
            viscous_friction: 0.0,
            ..ordinary()
        };
        let mut servo = servo(weak);
        let (asked, s) = (3000.0 * counts, 0.1);
        let way = move |t: f64| match t < s {
            true => [0.5 * asked * t * t, asked * t, asked],
            false => [0.5 * asked * s * s, 0.0, 0.0],
        };
        let (mut min, mut max) = (0.0_f64, 0.0_f64);
        let see = |t: f64, _: f64, servo: &Servo| {
            (min, max) = (min.min(servo.error()), max.max(servo.error()));
            assert!(servo.force().expect("a motor").abs() <= 400.0 * (1.0 + 1e-12));
            if t < 0.0999 {
                let missing = 0.5 * (asked - (400.0 - friction) / 400.0 * 1000.0 * counts) * t * t;
                assert!((servo.error() - missing).abs() < 1e-6 * missing + 1.0, "{t}: {} {missing}", servo.error());
            }
        };
        follow(&mut servo, 40_000, way, see);
        assert!(servo.error().abs() < 1.0, "{}", servo.error());
        min / max
    };
    let without = run(None, 0.0);
    let integral = run(Some(0.01), 0.0);
    assert!(integral > 1.02 * without, "{integral} {without}");
    // Friction helps to brake.
    assert!(run(Some(0.01), 40.0) > without);
}

#[test]
fn neither_speed_nor_acceleration_exceeds_what_the_drive_can() {
    let axis = cam_grinder().axis(Axis::X).clone();
    let counts = axis.scale.counts_per_unit();
    for drive in [axis.drive, DriveSettings { coulomb_friction: 0.0, viscous_friction: 0.0, ..ordinary() }] {
        let mut servo = servo(drive);
        servo.disturb(-200.0 * counts);
        let mut before = 0.0;
        for _ in 0..16_000 {
            servo.step(ServoCommand::default());
            let acceleration = (servo.velocity() - before).abs() / STEP_S;
            assert!(servo.velocity().abs() <= axis.limits.velocity * counts * DRIVE_HEADROOM * (1.0 + 1e-3));
            assert!(acceleration <= axis.limits.acceleration * counts * DRIVE_HEADROOM * (1.0 + 1e-9));
            before = servo.velocity();
        }
        assert!(servo.error().abs() < 1.0, "{}", servo.error());
    }
}

#[test]
fn without_power_the_axis_brakes_at_its_acceleration_limit() {
    let axis = cam_grinder().axis(Axis::X).clone();
    let counts = axis.scale.counts_per_unit();
    for drive in [DriveSettings::IDEAL, ordinary()] {
        let mut servo = servo(drive);
        let speed = 400.0 * counts;
        follow(&mut servo, 4000, |t| [speed * t, speed, 0.0], |_, _, _| {});
        servo.release();
        let began = servo.velocity() / counts;
        assert!((began - 400.0).abs() < 1e-3, "{began}");
        let mut distance = 0.0;
        while servo.velocity() > 0.0 {
            distance += servo.coast();
        }
        // v²/(2 a); the last step, at whose end it rests, goes up to a h²/8 farther.
        let (a, farther) =
            (axis.limits.acceleration, distance / counts - began * began / (2.0 * axis.limits.acceleration));
        assert!((-1e-9..a * STEP_S * STEP_S / 8.0 + 1e-9).contains(&farther), "{farther}");
    }
}

/// Two complete drives of the same axis behave identically, noise included.
#[test]
fn a_drive_repeats_itself_bit_for_bit() {
    let run = || {
        let mut servo = servo(DriveSettings { encoder_noise_counts: 0.5, ..ordinary() });
        let mut bits = 0_u64;
        let see = |_: f64, _: f64, servo: &Servo| bits = bits.rotate_left(5) ^ servo.error().to_bits();
        follow(&mut servo, 4000, sine(2.0e5, TURN_RAD), see);
        bits
    };
    assert_eq!(run(), run());
}
