// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::turned::{Eccentric, WHEEL_MM, turning};
use super::{follow, ideal, idle, machine, travel};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, DriveSettings, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::setpoint::Setpoint;
use camwright::math::units::TURN_RAD;
use camwright::simulation::fault::Fault;
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, Removal};
use camwright::simulation::{Machine, MachineCommand};

/// Table at the first station.
const Z_MM: f64 = 60.0;

/// C turns `turns` times from 0, X on the disc's path over it; at rest at both ends.
pub(crate) fn path_setpoints(
    description: &MachineDescription,
    disc: Eccentric,
    turns: f64,
    ticks: u32,
) -> Vec<Setpoint> {
    let sense = f64::from(description.rotation_sense);
    turning(description, Z_MM, turns, ticks, |c| disc.path_over_c(sense, c))
}

pub(crate) fn loaded(description: &MachineDescription, blank_mm: f64) -> Machine {
    let mut machine = machine(description);
    machine.load_lobe("I1", "LS1", 15.0, vec![blank_mm; DEFAULT_AZIMUTHS]).expect("a round blank");
    machine
}

/// Follows setpoints without an alarm until the axes rest, and returns the removal.
fn run(machine: &mut Machine, setpoints: &[Setpoint]) -> Removal {
    let mut reports = follow(machine, setpoints);
    reports.extend(idle(machine, 1000));
    assert!(machine.is_at_rest());
    assert!(reports.iter().all(|report| report.stopping_alarm().is_none()));
    reports.iter().fold(Removal::default(), |sum, report| sum.and(report.removal))
}

/// Grinds the disc and returns the deviation of every azimuth (mm).
fn ground(description: &MachineDescription, disc: Eccentric, turns: f64, ticks: u32) -> Vec<f64> {
    let mut machine = loaded(description, disc.radius_mm + disc.offset_mm + 0.2);
    let setpoints = path_setpoints(description, disc, turns, ticks);
    machine.place(setpoints[0].counts);
    run(&mut machine, &setpoints);
    let lobe = machine.part().lobe("I1").expect("it was loaded");
    let step = TURN_RAD / DEFAULT_AZIMUTHS as f64;
    lobe.radii_mm().iter().enumerate().map(|(i, radius)| radius - disc.radius(i as f64 * step)).collect()
}

fn extremes(deviation: &[f64]) -> (f64, f64) {
    deviation.iter().fold((f64::MAX, f64::MIN), |(low, high), d| (low.min(*d), high.max(*d)))
}

#[test]
fn a_cylinder_is_ground_to_the_distance_of_the_wheel() {
    let (low, high) = extremes(&ground(&ideal(), Eccentric { radius_mm: 20.0, offset_mm: 0.0 }, 3.0, 2000));
    // 0.05 µm is what the sweep may leave as cusps, 0.01 µm is a count.
    assert!(low > -1e-5 && high < 5e-5, "{low} {high}");
}

/// X = E cos θ + √((r+R)² − E² sin² θ) gives the disc of radius r at distance E again, in both senses of rotation.
#[test]
fn an_eccentric_is_ground_by_its_exact_path() {
    for (radius_mm, offset_mm) in [(19.0, 4.2), (25.0, 1.0), (14.8, 6.0)] {
        for sense in [1, -1] {
            let mut description = ideal();
            description.rotation_sense = sense;
            let deviation = ground(&description, Eccentric { radius_mm, offset_mm }, 3.0, 6000);
            let (low, high) = extremes(&deviation);
            assert!(low > -1e-4 && high < 1e-4, "{radius_mm} {offset_mm} {sense}: {low} {high}");
        }
    }
}

/// Loops of first order with gain Kv and no feed-forward shrink an eccentricity E turned at speed w by E w²/(2 Kv²):
/// the side where the disc stands out is cut too deep by as much.
#[test]
fn servo_lag_grinds_the_eccentricity_smaller_by_its_closed_form() {
    let kv = 100.0;
    let mut lagging = ideal().with_drives(DriveSettings {
        kv_1_s: kv,
        velocity_feed_forward: 0.0,
        acceleration_feed_forward: 0.0,
        ..DriveSettings::IDEAL
    });
    // Such drives would trip: at 60 rpm C lags by 3.6°.
    for axis in &mut lagging.axes {
        (axis.max_following_error, axis.min_following_error) = (10.0, 10.0);
    }
    // The speed of the eased motion is largest in its middle, 1.875 times the mean.
    let (turns, ticks) = (9.0, 16_875_u32);
    let speed = 1.875 * turns * TURN_RAD / (f64::from(ticks) * 1e-3);
    let disc = Eccentric { radius_mm: 19.0, offset_mm: 4.2 };
    let (low, _) = extremes(&ground(&lagging, disc, turns, ticks));
    let expected = -disc.offset_mm * speed * speed / (2.0 * kv * kv);
    // The second harmonic of the path, E²/(4 (r+R)), shrinks four times as much.
    let second = disc.offset_mm.powi(2) / (4.0 * (disc.radius_mm + WHEEL_MM)) * 4.0 * speed * speed / (2.0 * kv * kv);
    assert!((low - expected).abs() < second + 0.03 * expected.abs(), "{low} {expected} {second}");
}

#[test]
fn what_is_removed_is_what_the_part_has_less() {
    let description = ideal();
    let disc = Eccentric { radius_mm: 19.0, offset_mm: 4.2 };
    let mut machine = loaded(&description, 23.4);
    let setpoints = path_setpoints(&description, disc, 2.0, 3000);
    machine.place(setpoints[0].counts);
    let removed: f64 = follow(&mut machine, &setpoints).iter().map(|report| report.removal.area_mm2).sum();
    let area = |radii: &[f64]| radii.iter().map(|r| r * r).sum::<f64>() * 0.5 * TURN_RAD / radii.len() as f64;
    let left = area(machine.part().lobe("I1").expect("it was loaded").radii_mm());
    assert!((removed + left - 0.5 * TURN_RAD * 23.4 * 23.4).abs() < 1e-8);
    assert!((left - 0.5 * TURN_RAD * 19.0 * 19.0).abs() < 1e-2, "the disc's own area is left: {left}");
}

#[test]
fn only_the_lobe_in_front_of_the_wheel_is_cut() {
    let description = ideal();
    let mut machine = loaded(&description, 23.4);
    machine.load_lobe("E1", "LS2", 15.0, vec![23.4; 720]).expect("a round blank");
    let setpoints = path_setpoints(&description, Eccentric { radius_mm: 19.0, offset_mm: 4.2 }, 1.0, 2000);
    machine.place(setpoints[0].counts);
    let reports = follow(&mut machine, &setpoints);
    assert!(reports.iter().all(|report| report.lobe == Some(0)));
    assert!(machine.part().lobe("E1").expect("it was loaded").radii_mm().iter().all(|r| (r - 23.4).abs() < 1e-15));
    assert!(machine.part().lobe("I1").expect("it was loaded").radii_mm().iter().any(|r| *r < 20.0));
}

#[test]
fn a_wheel_that_does_not_run_touches_and_does_not_cut() {
    let description = ideal();
    let mut machine = loaded(&description, 23.0);
    let to_station = travel(&machine, Axis::Z, Z_MM, 1500);
    follow(&mut machine, &to_station);
    let advance = travel(&machine, Axis::X, -98.0, 2000);
    let reports = follow(&mut machine, &advance);
    let raised: Vec<_> = reports.iter().flat_map(|report| report.raised.to_vec()).map(|alarm| alarm.kind).collect();
    assert_eq!(raised, [AlarmKind::WheelContact]);
    let last = *idle(&mut machine, 500).last().expect("500 ticks");
    assert!(
        !last.io.drives_on && last.axes[1].position > 25.0 - 1e-6,
        "off the part, and then without power: {last:?}"
    );
    assert!(machine.part().lobes()[0].radii_mm().iter().all(|r| (r - 23.0).abs() < 1e-15));
}

#[test]
fn a_wheel_that_stalls_in_the_cut_stops_the_axes() {
    let description = ideal();
    let mut machine = loaded(&description, 23.4);
    let setpoints = path_setpoints(&description, Eccentric { radius_mm: 19.0, offset_mm: 4.2 }, 2.0, 3000);
    machine.place(setpoints[0].counts);
    follow(&mut machine, &setpoints[..1000]);
    let report = machine.step(Some(&setpoints[1000]), &[], &[Fault::WheelStall(true)]);
    assert_eq!(report.raised.first().map(|alarm| alarm.kind), Some(AlarmKind::WheelStoppedInCut));
}

#[test]
fn the_wheel_runs_up_when_ordered_and_a_worn_one_warns() {
    let description = ideal();
    let lasting = PersistentState { wheel_radius_mm: 44.0, ..PersistentState::new(&description) };
    let mut machine = Machine::new(description, lasting).expect("valid");
    let report = machine.step(None, &[MachineCommand::WheelStart], &[]);
    assert_eq!(report.raised.first().map(|alarm| alarm.kind), Some(AlarmKind::WheelWorn));
    assert!(!report.io.wheel_running);
    assert!(idle(&mut machine, 2000).last().expect("2000 ticks").io.wheel_running);
    let report = machine.step(None, &[MachineCommand::WheelStop], &[]);
    assert!(!report.io.wheel_running && report.raised.is_empty());
}

#[test]
fn lobes_that_do_not_fit_the_machine_are_refused() {
    let mut machine = loaded(&ideal(), 20.0);
    let blank = || vec![20.0; 360];
    assert!(machine.load_lobe("E1", "LS9", 15.0, blank()).is_err());
    assert!(machine.load_lobe("E1", "LS1", 15.0, blank()).is_err(), "taken by I1");
    assert!(machine.load_lobe("I1", "LS1", 15.0, blank()).is_ok(), "the same lobe anew");
    assert_eq!(machine.part().lobes().len(), 1);
    machine.clear_part();
    assert!(!machine.step(None, &[], &[]).io.part_present);
}

/// A wheel worn by w whose centre keeps its path leaves w along the normal: the disc comes out with the radius r + w.
#[test]
fn a_worn_wheel_leaves_its_wear_all_round() {
    let description = ideal();
    let disc = Eccentric { radius_mm: 19.0, offset_mm: 4.2 };
    let lasting = PersistentState { wheel_wear_mm: 0.01, ..PersistentState::new(&description) };
    let mut machine = Machine::new(description.clone(), lasting).expect("valid");
    machine.load_lobe("I1", "LS1", 15.0, vec![23.4; DEFAULT_AZIMUTHS]).expect("a round blank");
    let setpoints = path_setpoints(&description, disc, 2.0, 4000);
    machine.place(setpoints[0].counts);
    run(&mut machine, &setpoints);
    let larger = Eccentric { radius_mm: 19.01, ..disc };
    let step = TURN_RAD / DEFAULT_AZIMUTHS as f64;
    for (i, radius) in machine.part().lobes()[0].radii_mm().iter().enumerate() {
        assert!((radius - larger.radius(i as f64 * step)).abs() < 1e-4, "{i}: {radius}");
    }
    // Without a grinding ratio nothing more is lost; the lobe is counted once, however long it is ground.
    assert_eq!(machine.lasting().wheel_wear_mm.to_bits(), 0.01_f64.to_bits());
    assert_eq!(machine.lasting().lobes_since_dress, 1);
}

/// Volume removed = G times volume lost: A = G·2π·R·w per width, while w is small against R.
#[test]
fn a_wheel_loses_what_it_grinds_over_its_grinding_ratio() {
    let mut description = ideal();
    description.wheel.grinding_ratio = Some(50.0);
    let disc = Eccentric { radius_mm: 19.0, offset_mm: 4.2 };
    let mut machine = loaded(&description, 23.4);
    let setpoints = path_setpoints(&description, disc, 2.0, 4000);
    machine.place(setpoints[0].counts);
    let removal = run(&mut machine, &setpoints);
    let expected = removal.area_mm2 / (TURN_RAD * WHEEL_MM * 50.0);
    let found = machine.lasting().wheel_wear_mm;
    assert!(expected > 0.01 && (found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

#[test]
fn a_wheel_that_would_turn_too_fast_is_not_started() {
    let mut description = ideal();
    // 100 m/s at 60 mm are 1666.7 rad/s.
    description.wheel.max_speed_rad_s = Some(1600.0);
    let mut machine = machine(&description);
    let report = machine.step(None, &[MachineCommand::WheelStart], &[]);
    assert_eq!(report.raised.first().map(|alarm| alarm.kind), Some(AlarmKind::WheelTooFast));
    assert!(!idle(&mut machine, 3000).last().expect("3000 ticks").io.wheel_running);
}
