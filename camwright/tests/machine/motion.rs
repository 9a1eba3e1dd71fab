// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::{HOMING_AT_A_SWITCH, cam_grinder, follow, ideal, idle, machine, travel};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, DriveSettings};
use camwright::machine::setpoint::{Input, Latch};
use camwright::math::units::TURN_RAD;
use camwright::simulation::fault::Fault;
use camwright::simulation::tick_report::{MotionState, TickReport};
use camwright::simulation::{Machine, MachineCommand, ResetRefused};

const C: usize = 0;
const X: usize = 1;
const Z: usize = 2;

/// Content of a report without its tick.
fn timeless(report: &TickReport) -> TickReport {
    let mut report = *report;
    report.tick = 0;
    report.latches = Default::default();
    report
}

/// Every number of a report, bit for bit.
fn bits(report: &TickReport) -> Vec<u64> {
    report
        .axes
        .iter()
        .flat_map(|axis| {
            let floats = [axis.position, axis.velocity, axis.effort, axis.following_error].map(f64::to_bits);
            [axis.setpoint_counts.cast_unsigned(), axis.counts.cast_unsigned()].into_iter().chain(floats)
        })
        .chain([report.removal.area_mm2.to_bits(), report.removal.depth_mm.to_bits()])
        .collect()
}

fn kinds(reports: &[TickReport]) -> Vec<AlarmKind> {
    reports.iter().flat_map(|report| report.raised.iter().map(|alarm| alarm.kind).collect::<Vec<_>>()).collect()
}

fn latches(reports: &[TickReport]) -> Vec<Latch> {
    reports.iter().flat_map(|report| report.latches.to_vec()).collect()
}

#[test]
fn with_ideal_drives_the_axes_stand_on_every_setpoint() {
    let mut machine = machine(&ideal());
    for (axis, distance) in [(Axis::C, 40.0), (Axis::X, -80.0), (Axis::Z, 150.0)] {
        let setpoints = travel(&machine, axis, distance, 3000);
        for (report, setpoint) in follow(&mut machine, &setpoints).iter().zip(&setpoints) {
            for i in [C, X, Z] {
                assert_eq!(report.axes[i].counts, setpoint.counts[i]);
                // Rounding on the way to counts per second and back.
                assert!((report.axes[i].velocity - setpoint.velocity[i]).abs() <= 1e-15 * setpoint.velocity[i].abs());
            }
            assert!(report.raised.is_empty());
        }
    }
}

/// The state after rest is the same bits however long the rest was.
#[test]
fn idle_ticks_of_any_number_change_no_bit_of_what_follows() {
    let run = |idle_ticks: u32| {
        let mut machine = machine(&cam_grinder());
        let setpoints = travel(&machine, Axis::X, -40.0, 700);
        follow(&mut machine, &setpoints);
        idle(&mut machine, 500);
        assert!(machine.is_at_rest(), "half a second is enough to settle");
        idle(&mut machine, idle_ticks);
        let mut reports = Vec::new();
        for (axis, distance) in [(Axis::X, -20.0), (Axis::C, 7.0)] {
            let setpoints = travel(&machine, axis, distance, 600);
            reports.extend(follow(&mut machine, &setpoints));
            reports.extend(idle(&mut machine, 300));
        }
        reports
    };
    let reference = run(10);
    for ticks in [0, 1, 11, 10_000] {
        for (a, b) in reference.iter().zip(&run(ticks)) {
            assert_eq!(timeless(a), timeless(b), "{ticks} idle ticks");
            assert_eq!(bits(a), bits(b), "{ticks} idle ticks");
        }
    }
}

/// e₀ decays at least as fast as exp(−t·min(Kv, w/4)); then 8 ticks.
#[test]
fn an_axis_settles_within_the_time_its_gain_gives() {
    let drive = |kv_1_s: f64, velocity_loop_rad_s: Option<f64>| DriveSettings {
        kv_1_s,
        velocity_feed_forward: 0.9,
        acceleration_feed_forward: 0.0,
        velocity_loop_rad_s,
        ..DriveSettings::IDEAL
    };
    for drive in [drive(50.0, Some(600.0)), drive(200.0, Some(600.0)), drive(100.0, None), DriveSettings::IDEAL] {
        let mut machine = machine(&cam_grinder().with_drives(drive));
        let setpoints = travel(&machine, Axis::X, -60.0, 800);
        let last = *follow(&mut machine, &setpoints).last().expect("800 ticks");
        let error = (last.axes[X].following_error * 1.0e5).abs().max(1.0);
        let rate = drive.velocity_loop_rad_s.map_or(drive.kv_1_s, |w| drive.kv_1_s.min(w / 4.0));
        // Ten times the error covers the swing of a loop with complex poles.
        let bound = 1000.0 * (20.0 * error).ln() / rate + 8.0 + 2.0;
        let ticks = (1..5000).find(|_| {
            machine.step(None, &[], &[]);
            machine.is_at_rest()
        });
        let ticks = ticks.expect("every drive settles");
        assert!(f64::from(ticks) <= bound, "{ticks} ticks, bound {bound} for {drive:?}");
        assert_eq!(machine.step(None, &[], &[]).axes[X].following_error.to_bits(), 0.0_f64.to_bits());
    }
}

#[test]
fn two_machines_given_the_same_do_the_same() {
    let run = || {
        let mut machine = machine(&cam_grinder());
        let mut reports = Vec::new();
        for (axis, distance) in [(Axis::Z, 230.0), (Axis::C, 20.0), (Axis::X, -60.0)] {
            let setpoints = travel(&machine, axis, distance, 2000);
            reports.extend(follow(&mut machine, &setpoints));
        }
        reports
    };
    assert_eq!(run(), run());
}

/// The power-up position is 217.3°: turning on, the mark comes after 142.7°, turning back after 217.3°.
#[test]
fn the_origin_is_caught_at_the_same_place_at_every_speed_and_in_both_directions() {
    let turn = 3_600_000;
    for drive in [DriveSettings::IDEAL, cam_grinder().axes[C].drive] {
        for (distance, expected) in [(TURN_RAD, turn - 2_173_000), (-TURN_RAD, -2_173_000)] {
            for ticks in [700, 1000, 3000, 30_011] {
                let mut machine = machine(&cam_grinder().with_drives(drive));
                let setpoints = travel(&machine, Axis::C, distance, ticks);
                let mut reports = follow(&mut machine, &setpoints);
                reports.extend(idle(&mut machine, 300));
                assert!(kinds(&reports).is_empty());
                let caught = latches(&reports);
                assert_eq!(caught.len(), 1, "once a turn");
                assert_eq!((caught[0].input, caught[0].rising, caught[0].axis), (Input::Origin, true, Axis::C));
                assert_eq!(caught[0].counts, expected);
                let before = reports.iter().rev().find(|report| report.tick < caught[0].tick);
                let after = reports.iter().find(|report| report.tick == caught[0].tick).expect("the tick was run");
                let span = [before.map_or(0, |report| report.axes[C].counts), after.axes[C].counts];
                assert!(span[0].min(span[1]) - 1 <= expected && expected <= span[0].max(span[1]) + 1);
            }
        }
    }
}

/// After homing C = 0 is where the keyway's centre faces the wheel: there the detector sees its mark.
#[test]
fn homing_makes_the_caught_position_zero() {
    let mut machine = machine(&cam_grinder());
    assert!(!machine.step(None, &[], &[]).axes[C].is_homed);
    let setpoints = travel(&machine, Axis::C, 3.0, 800);
    let mut reports = follow(&mut machine, &setpoints);
    reports.extend(idle(&mut machine, 300));
    let counts = latches(&reports)[0].counts;
    let before = machine.setpoint().counts[C];
    let report = machine.step(None, &[MachineCommand::SetHome { axis: Axis::C, counts }], &[]);
    assert!(report.axes[C].is_homed);
    assert_eq!(report.axes[C].setpoint_counts, before - counts);
    assert_eq!(report.axes[C].counts, before - counts);
    assert!(machine.is_at_rest(), "a new reading moves nothing");
    let back = -machine.description().axes[C].scale.position(before - counts);
    let setpoints = travel(&machine, Axis::C, back, 800);
    follow(&mut machine, &setpoints);
    let report = *idle(&mut machine, 300).last().expect("300 ticks");
    assert_eq!(report.axes[C].counts, 0);
    assert!(report.io.origin);
}

#[test]
fn station_switches_latch_the_table_where_the_dog_meets_them() {
    for ticks in [1500, 4000, 9973] {
        let mut machine = machine(&cam_grinder());
        let setpoints = travel(&machine, Axis::Z, 150.0, ticks);
        let mut reports = follow(&mut machine, &setpoints);
        reports.extend(idle(&mut machine, 300));
        let setpoints = travel(&machine, Axis::Z, -150.0, ticks);
        reports.extend(follow(&mut machine, &setpoints));
        reports.extend(idle(&mut machine, 300));
        let caught: Vec<_> = latches(&reports).iter().map(|l| (l.input, l.rising, l.counts)).collect();
        let (first, second) = (Input::Station(0), Input::Station(1));
        // Closes at 60 and 110 mm, dog 8 mm, hysteresis 0.5 mm; 10,000 counts per mm.
        let expected = [
            (first, true, 600_000),
            (first, false, 685_000),
            (second, true, 1_100_000),
            (second, false, 1_185_000),
            (second, true, 1_180_000),
            (second, false, 1_095_000),
            (first, true, 680_000),
            (first, false, 595_000),
        ];
        assert_eq!(caught, expected);
    }
}

#[test]
fn the_inputs_show_the_switch_while_the_dog_is_on_it() {
    let mut machine = machine(&ideal());
    let setpoints = travel(&machine, Axis::Z, 112.0, 2000);
    let report = *follow(&mut machine, &setpoints).last().expect("2000 ticks");
    assert!(report.io.station(1) && !report.io.station(0) && !report.io.station(63) && !report.io.station(64));
}

#[test]
fn a_stuck_detector_catches_nothing() {
    let mut machine = machine(&cam_grinder());
    machine.step(None, &[], &[Fault::StuckInput { input: Input::Origin, level: Some(false) }]);
    let setpoints = travel(&machine, Axis::C, 2.0 * TURN_RAD, 2000);
    let reports = follow(&mut machine, &setpoints);
    assert!(latches(&reports).is_empty() && reports.iter().all(|report| !report.io.origin));
}

/// With the setpoint at speed v and no gain left, the error grows to the trip level max·v over the largest v, no farther.
#[test]
fn a_drive_without_gain_trips_at_its_following_error() {
    let description = cam_grinder();
    let mut machine = machine(&description);
    let setpoints = travel(&machine, Axis::X, -100.0, 1000);
    follow(&mut machine, &setpoints[..500]);
    let mut reports =
        vec![machine.step(Some(&setpoints[500]), &[], &[Fault::DriveGain { axis: Axis::X, factor: 0.0 }])];
    reports.extend(follow(&mut machine, &setpoints[501..800]));
    assert_eq!(kinds(&reports), [AlarmKind::FollowingError(Axis::X)]);
    let alarm = machine.alarms()[0];
    let axis = &description.axes[X];
    let at = usize::try_from(alarm.tick - 1).expect("a tick of this test");
    let limit = axis.max_following_error * setpoints[at].velocity[X].abs() / axis.limits.velocity;
    assert!((alarm.bound - limit.max(axis.min_following_error)).abs() < 1e-12);
    assert!(alarm.value > alarm.bound && alarm.value < alarm.bound + 0.3, "{alarm:?}");
    assert!(!reports.last().expect("ticks were run").io.drives_on);
}

#[test]
fn beyond_a_hard_limit_the_power_goes_and_a_reset_lets_the_axis_back() {
    let mut description = ideal();
    description.axes[X].soft_limits = None;
    let mut machine = machine(&description);
    let setpoints = travel(&machine, Axis::X, -119.0, 1500);
    let reports = follow(&mut machine, &setpoints);
    assert_eq!(kinds(&reports), [AlarmKind::Overtravel(Axis::X)]);
    let last = reports.last().expect("1500 ticks");
    assert!(last.io.overtravel_x_min && !last.io.drives_on);
    assert_eq!(last.motion, MotionState::Fault);
    assert_eq!(last.axes[X].setpoint_counts, last.axes[X].counts, "without power the setpoint is where the axis is");
    machine.reset().expect("the axis rests");
    let setpoints = travel(&machine, Axis::X, 20.0, 800);
    let reports = follow(&mut machine, &setpoints);
    assert!(kinds(&reports).is_empty());
    assert!(!reports.last().expect("800 ticks").io.overtravel_x_min);
}

/// The stop keeps the acceleration limit, and afterwards setpoints move nothing until a reset.
#[test]
fn a_setpoint_beyond_a_soft_limit_stops_the_axes() {
    let description = ideal();
    let mut machine = machine(&description);
    // Soft limit at 5 mm, the move ends at 2 mm and would be on its last millimetres at speed.
    let setpoints = travel(&machine, Axis::X, -118.0, 1500);
    let reports = follow(&mut machine, &setpoints);
    assert_eq!(kinds(&reports), [AlarmKind::SoftLimit(Axis::X)]);
    for pair in reports.windows(2) {
        let acceleration = (pair[1].axes[X].velocity - pair[0].axes[X].velocity) / 1e-3;
        assert!(acceleration.abs() <= description.axes[X].limits.acceleration * 1.001, "{acceleration}");
    }
    let last = reports.last().expect("1500 ticks");
    assert_eq!(last.motion, MotionState::Fault);
    assert!(last.axes[X].position > 4.9, "{}", last.axes[X].position);
    let stopped = last.axes[X].counts;
    let setpoints = travel(&machine, Axis::X, 10.0, 500);
    assert!(follow(&mut machine, &setpoints).iter().all(|report| report.axes[X].counts == stopped));
    machine.reset().expect("the axes rest");
    follow(&mut machine, &setpoints);
    assert_eq!(machine.step(None, &[], &[]).axes[X].counts, stopped + 1_000_000);
}

#[test]
fn silence_in_motion_is_an_underrun_and_a_stop() {
    let mut machine = machine(&cam_grinder());
    let setpoints = travel(&machine, Axis::X, -60.0, 600);
    follow(&mut machine, &setpoints[..300]);
    let reports = idle(&mut machine, 600);
    assert_eq!(kinds(&reports), [AlarmKind::Underrun]);
    assert_eq!(reports[1].motion, MotionState::Stopping);
    assert_eq!(reports.last().map(|report| report.motion), Some(MotionState::Fault));
    assert!(machine.setpoint().velocity.iter().all(|velocity| *velocity == 0.0));
    machine.reset().expect("the axes rest");
    assert_eq!(machine.step(None, &[], &[]).motion, MotionState::Standstill);
}

/// An alarm of the node lets the tail of the last chunk run out, then nothing moves until a reset.
#[test]
fn a_stop_alarm_follows_the_stream_until_it_rests() {
    let mut machine = machine(&ideal());
    let setpoints = travel(&machine, Axis::X, -60.0, 600);
    follow(&mut machine, &setpoints[..300]);
    machine.raise(AlarmKind::CommandGap, 7.0, 6.0);
    let reports = follow(&mut machine, &setpoints[300..]);
    assert_eq!(kinds(&reports), [AlarmKind::CommandGap]);
    let last = reports.last().expect("300 ticks");
    assert_eq!(last.axes[X].counts, setpoints[599].counts[X]);
    let more = travel(&machine, Axis::X, 10.0, 300);
    follow(&mut machine, &more);
    let report = machine.step(None, &[], &[]);
    assert_eq!((report.axes[X].counts, report.motion), (last.axes[X].counts, MotionState::Fault));
}

#[test]
fn an_emergency_stop_takes_the_power_and_holds_off_a_reset() {
    let mut machine = machine(&cam_grinder());
    machine.step(None, &[MachineCommand::WheelStart], &[]);
    let setpoints = travel(&machine, Axis::X, -60.0, 600);
    follow(&mut machine, &setpoints[..300]);
    let report = machine.step(Some(&setpoints[300]), &[], &[Fault::EStop(true)]);
    assert!(report.io.estop && report.io.drives_on, "the drives bring the axes to rest first");
    assert_eq!(machine.reset(), Err(ResetRefused::EStopPressed));
    let reports = idle(&mut machine, 200);
    assert!(!reports.last().expect("200 ticks").io.drives_on);
    let deceleration = (reports[0].axes[X].velocity - reports[1].axes[X].velocity).abs() / 1e-3;
    assert!(deceleration <= cam_grinder().axes[X].limits.acceleration * 1.2001, "what a drive can do");
    assert_eq!(reports.last().map(|report| report.motion), Some(MotionState::Fault));
    machine.step(None, &[], &[Fault::EStop(false)]);
    machine.reset().expect("released, and the axes rest");
    let before = machine.setpoint();
    let report = *follow(&mut machine, &setpoints[301..302]).last().expect("one tick");
    assert!(matches!(
        report.raised.first().map(|alarm| alarm.kind),
        Some(AlarmKind::SetpointAcceleration(Axis::X) | AlarmKind::SetpointJump(Axis::X))
    ));
    assert_eq!(machine.setpoint().counts, before.counts, "the old motion is not taken up again");
}

#[test]
fn a_drive_fault_holds_off_a_reset_until_it_is_gone() {
    let mut machine = machine(&cam_grinder());
    machine.step(None, &[], &[Fault::DriveFault { axis: Axis::Z, active: true }]);
    idle(&mut machine, 5);
    assert_eq!(machine.reset(), Err(ResetRefused::DriveFault(Axis::Z)));
    machine.step(None, &[], &[Fault::DriveFault { axis: Axis::Z, active: false }]);
    assert_eq!(machine.reset(), Ok(()));
    assert!(machine.step(None, &[], &[]).io.drives_on);
}

/// The drive follows its encoder, so an encoder with an error of 5 µm, less than the slip detection, shifts the axis back by 5 µm: the table leaves
/// its switch later by that distance.
#[test]
fn an_encoder_that_slips_moves_the_axis_and_not_the_reading() {
    let mut machine = machine(&cam_grinder());
    machine.step(None, &[], &[Fault::EncoderOffset { axis: Axis::Z, offset: 0.005 }]);
    idle(&mut machine, 500);
    assert!(machine.is_at_rest());
    assert_eq!(machine.step(None, &[], &[]).axes[Z].counts, 0);
    let setpoints = travel(&machine, Axis::Z, 100.0, 2000);
    let caught = latches(&follow(&mut machine, &setpoints));
    assert_eq!(caught[0].counts, 600_050);
}

#[test]
fn drives_switched_off_hold_nothing_up_when_switched_on_again() {
    let mut machine = machine(&cam_grinder());
    machine.set_drives(false);
    let report = machine.step(None, &[], &[]);
    assert_eq!((report.motion, report.io.drives_on), (MotionState::Off, false));
    machine.set_drives(true);
    let setpoints = travel(&machine, Axis::X, -10.0, 400);
    let reports = follow(&mut machine, &setpoints);
    assert!(kinds(&reports).is_empty());
    assert_eq!(idle(&mut machine, 300).last().map(|report| report.axes[X].counts), Some(11_000_000));
}

/// Random streams, plausible and not: the axes never exceed what the drives can, nothing is ever not a number.
#[test]
fn whatever_comes_the_axes_keep_their_limits() {
    let mut seed: u64 = 0x9e37_79b9_7f4a_7c15;
    eprintln!("seed {seed:#x}");
    let mut random = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        f64::from(u32::try_from(seed >> 32).expect("32 bits")) / f64::from(u32::MAX)
    };
    let description = cam_grinder();
    let mut machine = machine(&description);
    let mut before: Option<TickReport> = None;
    for _ in 0..200 {
        let axis = Axis::ALL[usize::from(random() > 0.4) + usize::from(random() > 0.7)];
        let setpoints = travel(&machine, axis, 60.0 * (random() - 0.5), 200 + u32::from(random() > 0.5) * 800);
        for setpoint in &setpoints {
            let mut setpoint = *setpoint;
            if random() < 0.002 {
                setpoint.counts[axis.index()] += 100_000;
            }
            if random() < 0.001 {
                setpoint.velocity[axis.index()] = f64::NAN;
            }
            let setpoint = if random() < 0.001 { None } else { Some(&setpoint) };
            let report = machine.step(setpoint, &[], &[]);
            for (i, axis) in report.axes.iter().enumerate() {
                assert!(axis.velocity.is_finite() && axis.effort.is_finite() && axis.following_error.is_finite());
                let limits = description.axes[i].limits;
                assert!(axis.velocity.abs() <= 1.2001 * limits.velocity);
                if let Some(before) = before {
                    let acceleration = (axis.velocity - before.axes[i].velocity).abs() / 1e-3;
                    assert!(acceleration <= 1.2001 * limits.acceleration, "{i}: {acceleration}");
                }
            }
            before = Some(report);
        }
        idle(&mut machine, 1500);
        assert!(machine.is_at_rest(), "{:?}", machine.alarms());
        machine.reset().expect("the axes rest");
    }
}

#[test]
fn a_machine_that_is_none_is_refused() {
    let mut description = cam_grinder();
    description.axes[X].drive.kv_1_s = f64::NAN;
    let lasting = camwright::machine::persistent_state::PersistentState::new(&description);
    assert!(Machine::new(description, lasting).is_err());
}

/// A home switch is among the reported inputs, closed from its switching point to the end of the travel; a machine without one has none.
#[test]
fn the_inputs_say_whether_a_slide_stands_on_its_home_switch() {
    let home = Input::OTHERS.iter().position(|input| *input == Input::Home(Axis::X)).expect("it is one of them");
    let mut description = ideal();
    assert!(!Input::Home(Axis::X).is_on(&description));
    description.axes[1].homing = Some(HOMING_AT_A_SWITCH);
    assert!(Input::Home(Axis::X).is_on(&description));
    for (x_mm, closed) in [(150, false), (210, true)] {
        let mut machine = machine(&description);
        machine.place([0, x_mm * 100_000, 0]);
        let report = machine.step(None, &[], &[]);
        assert_eq!(report.io.other(home), closed, "{x_mm} mm");
        assert!(!report.io.other(Input::OTHERS.len()));
    }
}
