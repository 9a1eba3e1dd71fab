// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Drives with motors on a whole machine: form error of a lobe, behaviour at rest, reported force.

use super::turned::{Eccentric, turning};
use super::{cam_grinder, follow, idle, machine, travel};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::{LiftLaw, MotionProgram, MotionSegment};
use camwright::cam::motion_law::MotionLaw;
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{
    Axis, ContactDescription, DescriptionError, DriveSettings, MachineDescription, StiffnessAt, Structure,
};
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::simulation::servo::{Servo, ServoCommand};
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;
use camwright::toolpath::wheel_path::ToolPath;

const X: usize = 1;

/// The reference machine with everything that is in the way of good drives.
fn ordinary() -> MachineDescription {
    let mut description = cam_grinder();
    for axis in &mut description.axes {
        let rotary = axis.axis == Axis::C;
        axis.drive = DriveSettings {
            gain_error: if rotary { 0.01 } else { 0.0 },
            velocity_integral_s: Some(0.01),
            max_force: Some(if rotary { 80.0 } else { 6000.0 }),
            coulomb_friction: if rotary { 1.0 } else { 20.0 },
            viscous_friction: if rotary { 0.05 } else { 0.2 },
            backlash: if axis.axis == Axis::Z { 0.002 } else { 0.0 },
            structure: Some(Structure { frequency_rad_s: 140.0 * TURN_RAD, damping: 0.04, mass_share: 0.2 }),
            encoder_step_counts: 1.0,
            encoder_noise_counts: 0.3,
            ..axis.drive
        };
    }
    description
}

/// Largest deviation of the wheel from the reference lobe (roller 8.5, base 16, lift 6, 3-4-5 over 62°) along its normal, with a wheel
/// of 60 mm at 60 rpm (µm): C at constant speed behind by its own lag, X where its drive holds it.
fn normal_error_um(x_drive: DriveSettings, c_drive: DriveSettings) -> f64 {
    const STEP_S: f64 = 0.25e-3;
    let half = rad_from_deg(62.0);
    let segment = |law, angle_rad, rise_mm| MotionSegment { law, angle_rad, rise_mm };
    let segments = [
        segment(MotionLaw::Polynomial345, half, 6.0),
        segment(MotionLaw::Polynomial345, half, -6.0),
        segment(MotionLaw::Dwell, TURN_RAD - 2.0 * half, 0.0),
    ];
    let law = LiftLaw::from_program(MotionProgram::new(0.0, &segments).expect("a turn")).expect("a lift");
    let roller = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
    let path = ToolPath::for_wheel(&Contour::from_lift(&law, &roller, 16.0).expect("a cam"), 60.0).expect("a path");
    let (mut c, mut x) = (cam_grinder().axis(Axis::C).clone(), cam_grinder().axis(Axis::X).clone());
    (c.drive, x.drive) = (c_drive, x_drive);
    let (per_rad, per_mm) = (c.scale.counts_per_unit(), x.scale.counts_per_unit());
    let (mut c, mut x) = (Servo::new(&c, STEP_S), Servo::new(&x, STEP_S));
    let speed = TURN_RAD;
    let mut worst = 0.0_f64;
    for k in 0..12_000_u32 {
        let (from, to) = (speed * STEP_S * f64::from(k), speed * STEP_S * f64::from(k + 1));
        c.step(ServoCommand { distance: (to - from) * per_rad, velocity: speed * per_rad, ..ServoCommand::default() });
        let (start, end) = (path.sample(from), path.sample(to));
        x.step(ServoCommand {
            distance: (end.value - start.value) * per_mm,
            velocity: end.first * speed * per_mm,
            acceleration: path.sample(0.5 * (from + to)).second * speed * speed * per_mm,
            ..ServoCommand::default()
        });
        if k >= 8000 {
            let angle = to - c.error() / per_rad;
            let off = end.value - x.error() / per_mm - path.sample(angle).value;
            worst = worst.max((off * path.beta(angle).cos()).abs());
        }
    }
    1e3 * worst
}

/// Loops of first order with gain Kv lag alike and yet leave X″Ċ²/(2 Kv²) cos β; feed-forward leaves (1 − ff) of it; a gain of C that is
/// wrong adds X′Ċ (1/KvX − 1/KvC) cos β, which has both signs on the two flanks.
#[test]
fn drives_leave_of_the_reference_lobe_what_their_gains_say() {
    let first_order = |kv: f64, ff: f64, gain_error: f64| DriveSettings {
        kv_1_s: kv,
        velocity_feed_forward: ff,
        gain_error,
        ..DriveSettings::IDEAL
    };
    let alike = |kv: f64, ff: f64| normal_error_um(first_order(kv, ff, 0.0), first_order(kv, ff, 0.0));
    let plain = alike(100.0, 0.0);
    for (found, wanted, within) in
        [(plain, 122.0, 2.0), (alike(300.0, 0.0), 20.0, 1.0), (alike(300.0, 0.99), 0.42, 0.02)]
    {
        eprintln!("{found:.3} um, {wanted}");
        assert!((found - wanted).abs() < within, "{found} um, not {wanted}");
    }
    for (gain_error, wanted, within) in [(0.01, 2.0, 0.5), (-0.01, -2.0, 0.5), (0.1, 19.0, 2.0), (-0.1, 34.0, 2.0)] {
        let found = normal_error_um(first_order(100.0, 0.0, 0.0), first_order(100.0, 0.0, gain_error)) - plain;
        eprintln!("KvC {:+} %: {found:+.2} um, {wanted:+}", 100.0 * gain_error);
        assert!((found - wanted).abs() < within, "{gain_error}: {found} um, not {wanted}");
    }
}

fn timeless(report: &TickReport) -> TickReport {
    let mut report = *report;
    report.tick = 0;
    report.latches = Default::default();
    report
}

/// Noise, friction, play and ringing end where an axis rests: however long it rests, what follows has the same bits.
#[test]
fn idle_ticks_change_nothing_of_drives_with_motors() {
    let run = |idle_ticks: u32| {
        let mut machine = machine(&ordinary());
        for (axis, distance) in [(Axis::X, -40.0), (Axis::Z, 30.0)] {
            let setpoints = travel(&machine, axis, distance, 700);
            follow(&mut machine, &setpoints);
        }
        idle(&mut machine, 1000);
        assert!(machine.is_at_rest(), "a second is enough to settle");
        idle(&mut machine, idle_ticks);
        let mut reports = Vec::new();
        for (axis, distance) in [(Axis::X, -20.0), (Axis::C, 7.0), (Axis::Z, -12.0)] {
            let setpoints = travel(&machine, axis, distance, 600);
            reports.extend(follow(&mut machine, &setpoints));
            reports.extend(idle(&mut machine, 300));
        }
        reports
    };
    let reference = run(10);
    for ticks in [0, 1, 11, 5_000] {
        for (a, b) in reference.iter().zip(&run(ticks)) {
            assert_eq!(timeless(a), timeless(b), "{ticks} idle ticks");
        }
    }
}

/// A motor that is too weak for what is asked ends in a following error, power off and rest, not in anything worse.
#[test]
fn a_motor_that_is_too_weak_trips_at_its_following_error() {
    let mut description = ordinary();
    description.axes[X].drive.max_force = Some(300.0);
    let mut machine = machine(&description);
    let setpoints = travel(&machine, Axis::X, -100.0, 500);
    let mut reports = follow(&mut machine, &setpoints);
    reports.extend(idle(&mut machine, 1000));
    let raised: Vec<AlarmKind> =
        reports.iter().flat_map(|report| report.raised.to_vec()).map(|alarm| alarm.kind).collect();
    assert_eq!(raised, [AlarmKind::FollowingError(Axis::X)]);
    assert!(reports.iter().all(|report| report.axes[X].effort.is_finite()));
    assert!(machine.is_at_rest() && !reports.last().expect("ticks were run").io.drives_on);
}

/// Before motion the effort is nothing; in motion at constant speed it is the friction; it turns round with the direction.
#[test]
fn the_effort_of_a_steady_axis_is_its_friction() {
    let mut description = ordinary();
    description.axes[X].drive.encoder_noise_counts = 0.0;
    let mut machine = machine(&description);
    for way in [-1.0, 1.0] {
        let setpoints = travel(&machine, Axis::X, 60.0 * way, 6000);
        let reports = follow(&mut machine, &setpoints);
        // Where the eased speed is largest nothing accelerates.
        let middle = &reports[2900..3100];
        let mean = middle.iter().map(|report| report.axes[X].effort).sum::<f64>() / 200.0;
        let speed = 60.0 / 6.0 * 1.875;
        let wanted = way * (20.0 + 0.2 * speed);
        assert!((mean - wanted).abs() < 0.02 * wanted.abs(), "{mean} N, {wanted} N");
        idle(&mut machine, 1000);
    }
}

/// In a plunge the motor of X holds against the normal force: what it makes, in the mean of a turn, is that force and the friction. C
/// turns a round part, so its motor feels no arm.
#[test]
fn the_grinding_force_is_seen_in_the_motor() {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 3.0e4 }],
        grinding_n_mm2: 2.0e3,
        threshold_n_mm: 1.0,
        part_share: 0.5,
        modes: Vec::new(),
    };
    let description = MachineDescription { contact: Some(contact), ..ordinary() };
    let mut machine = machine(&description);
    machine.load_lobe("I1", "LS1", 15.0, vec![20.0; DEFAULT_AZIMUTHS]).expect("a round blank");
    let feed_mm = 0.01;
    let setpoints =
        turning(&description, 60.0, 12.2, 6000, |angle| (20.0 - feed_mm * angle / TURN_RAD, -feed_mm / TURN_RAD, 0.0));
    machine.place(setpoints[0].counts);
    let reports = follow(&mut machine, &setpoints[1..]);
    assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
    // A turn in the middle, at 3.8 turns a second.
    let turn = &reports[2900..3163];
    let mean = |of: &dyn Fn(&TickReport) -> f64| turn.iter().map(of).sum::<f64>() / turn.len() as f64;
    let force = mean(&|report| report.normal_force_n);
    let effort = mean(&|report| report.axes[X].effort);
    // kg·f + F0, all but reached after six turns.
    assert!((force - 315.0).abs() < 5.0, "{force} N");
    // X creeps towards the part at less than a count a step: friction holds it now and then, and may take any share.
    assert!((effort + force).abs() < 21.0, "{effort} N, {force} N");
    let torque = mean(&|report| report.axes[0].effort);
    assert!((torque - (1.0 + 0.05 * 1.875 * 12.2 * TURN_RAD / 6.0)).abs() < 0.2, "{torque} N m");
}

/// The wheel pushes the part out of its way by the arm of the contact: on the flanks of an eccentric C feels F·E sin θ, more or less,
/// once with and once against its motion, in both senses of rotation.
#[test]
fn the_headstock_feels_the_force_by_its_arm() {
    for sense in [1, -1] {
        let contact = ContactDescription {
            stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 3.0e4 }],
            grinding_n_mm2: 2.0e3,
            threshold_n_mm: 1.0,
            part_share: 0.5,
            modes: Vec::new(),
        };
        let mut description = MachineDescription { contact: Some(contact), rotation_sense: sense, ..ordinary() };
        description.axes[0].drive.coulomb_friction = 0.0;
        description.axes[0].drive.viscous_friction = 0.0;
        // A count a servo step is 0.2 N m of a loop that sees only counts.
        description.axes[0].drive = description.axes[0].drive.with_exact_encoder();
        let disc = Eccentric { radius_mm: 19.0, offset_mm: 4.2 };
        let raw = Eccentric { radius_mm: 19.05, offset_mm: 4.2 };
        let step = TURN_RAD / DEFAULT_AZIMUTHS as f64;
        let mut machine = machine(&description);
        let radii = (0..DEFAULT_AZIMUTHS).map(|i| raw.radius(i as f64 * step)).collect();
        machine.load_lobe("I1", "LS1", 15.0, radii).expect("a blank");
        let setpoints = turning(&description, 60.0, 1.0, 8000, |c| disc.path_over_c(f64::from(sense), c));
        machine.place(setpoints[0].counts);
        let reports = follow(&mut machine, &setpoints[1..]);
        assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
        let mut worst = 0.0_f64;
        let mut largest = 0.0_f64;
        for (report, setpoint) in reports.iter().zip(&setpoints[1..]).skip(500).take(6500) {
            // Arm of the normal, which passes through the disc's centre, about the axis.
            let (c, wheel_mm) = (report.axes[0].position, 60.0);
            let theta = f64::from(sense) * c;
            let centre_mm = disc.path(theta).0 + wheel_mm;
            let (along, across) = (centre_mm - 4.2 * theta.cos(), 4.2 * theta.sin());
            let arm_mm = centre_mm * across / along.hypot(across);
            let wanted = -f64::from(sense) * report.normal_force_n * arm_mm * 1e-3;
            let inertia = description.axes[0].inertia * setpoint.acceleration[0];
            worst = worst.max((report.axes[0].effort - inertia - wanted).abs());
            largest = largest.max(wanted.abs());
        }
        eprintln!("sense {sense}: torque up to {largest} N m, off by {worst} N m at most");
        assert!(largest > 1.0 && worst < 0.1 * largest, "sense {sense}: {worst} of {largest} N m");
    }
}

/// Figures that make no drive are named, with the axis.
#[test]
fn drives_that_are_none_are_refused() {
    let refused = |change: &dyn Fn(&mut DriveSettings)| {
        let mut description = ordinary();
        change(&mut description.axes[X].drive);
        description.validate().expect_err("no drive").to_string()
    };
    assert_eq!(ordinary().validate(), Ok(()));
    assert_eq!(
        refused(&|drive| drive.velocity_loop_rad_s = Some(5000.0)),
        "x_axis: velocity loop bandwidth (rad/s) is 5000; at most 4000 is allowed"
    );
    assert!(refused(&|drive| drive.velocity_integral_s = None).contains("needs an integral time"));
    assert!(refused(&|drive| drive.velocity_loop_rad_s = None).contains("need a bandwidth"));
    assert!(refused(&|drive| drive.gain_error = -1.0).contains("position loop gain with its error"));
    assert!(refused(&|drive| drive.coulomb_friction = -1.0).contains("Coulomb friction"));
    assert!(refused(&|drive| drive.encoder_noise_counts = f64::NAN).contains("noise of the encoder"));
    let swinging = Structure { frequency_rad_s: 800.0, damping: 0.04, mass_share: 0.95 };
    assert!(refused(&|drive| drive.structure = Some(swinging)).contains("at most 0.9"));
    let mut description = ordinary();
    description.axes[X].good_drive = Some(DriveSettings { kv_1_s: 0.0, ..DriveSettings::IDEAL });
    assert!(description.validate().is_err());
    description.axes[X].good_drive = None;
    description.contact = Some(ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 1.0e6 }],
        grinding_n_mm2: 2.0e3,
        threshold_n_mm: 1.0,
        part_share: 0.5,
        modes: Vec::new(),
    });
    assert!(matches!(description.validate(), Err(DescriptionError::AboveLimit { .. })));
}
