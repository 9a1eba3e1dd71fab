// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine with several wheels: it mounts one at rest and clear of the part, and every wheel keeps its size, wear and counts.

use super::grinding::loaded;
use super::turned::{Eccentric, turning};
use super::{follow, ideal, idle, machine, travel};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::axial_profile::AxialProfile;
use camwright::machine::description::{
    Axis, DescriptionError, LoadingDescription, MachineDescription, MagazineWheel, WheelChanger, WheelDescription,
};
use camwright::machine::fixture::Dresser;
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::wheel_state::{WheelNow, nm_from_mm};
use camwright::math::units::TURN_RAD;
use camwright::simulation::fault::{Fault, LoadingFault};
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::{Machine, MachineCommand};

/// Table at the first station.
const Z_MM: f64 = 60.0;

/// Ticks of a change.
const CHANGE: u32 = 700;

const FIRST: u32 = 0;
const SECOND: u32 = 1;

/// A machine with a second wheel of 30 mm, whose stored offset is wrong by this (mm); both wear. X rests at 120 mm.
pub(crate) fn two_wheels(setting_error_mm: f64) -> MachineDescription {
    let mut description = ideal();
    description.wheel.grinding_ratio = Some(200.0);
    let second = WheelDescription {
        new_radius_mm: 30.0,
        min_radius_mm: 25.0,
        width_mm: 12.0,
        surface_speed_m_s: 45.0,
        spin_up_s: 0.5,
        max_surface_speed_m_s: Some(60.0),
        max_speed_rad_s: None,
        grinding_ratio: Some(50.0),
        unbalance_mm: 0.0,
        rim: AxialProfile::default(),
    };
    let wheels = vec![
        MagazineWheel { name: "roughing".into(), wheel: description.wheel, setting_error_mm: 0.0 },
        MagazineWheel { name: "finishing".into(), wheel: second, setting_error_mm },
    ];
    description.wheel_changer = Some(WheelChanger { change_s: 0.7, min_x_mm: 100.0, wheels, mounted: 0 });
    description
}

fn kinds(reports: &[TickReport]) -> Vec<AlarmKind> {
    reports.iter().flat_map(|report| report.raised.to_vec()).map(|alarm| alarm.kind).collect()
}

fn order(machine: &mut Machine, command: MachineCommand) -> TickReport {
    machine.step(None, &[command], &[])
}

/// Changes the wheel of a machine whose X is clear, without an alarm.
fn change(machine: &mut Machine, wheel: u32) {
    let mut reports = vec![order(machine, MachineCommand::ChangeWheel { wheel })];
    reports.extend(idle(machine, CHANGE - 1));
    assert_eq!(kinds(&reports), []);
    assert_eq!(machine.description().mounted_wheel(), wheel as usize);
    assert!(!machine.is_mounting());
}

/// Grinds the lobe from where the machine is to a radius, and leaves it. Returns what it removed (mm²).
fn grind(machine: &mut Machine, radius_mm: f64) -> f64 {
    let description = machine.description().clone();
    let disc = Eccentric { radius_mm, offset_mm: 0.0 };
    let setpoints = turning(&description, Z_MM, 3.0, 2000, |c| disc.path_over_c(1.0, c));
    machine.place(setpoints[0].counts);
    let mut reports = follow(machine, &setpoints);
    let away = travel(machine, Axis::X, 80.0, 1000);
    reports.extend(follow(machine, &away));
    reports.push(order(machine, MachineCommand::WheelStop));
    reports.extend(idle(machine, 3000));
    assert!(reports.iter().all(|report| report.stopping_alarm().is_none()));
    reports.iter().map(|report| report.removal.area_mm2).sum()
}

fn radii(machine: &Machine) -> (f64, f64) {
    let radii = machine.part().lobe("I1").expect("it was loaded").radii_mm();
    radii.iter().fold((f64::MAX, f64::MIN), |(low, high), r| (low.min(*r), high.max(*r)))
}

#[test]
fn a_change_takes_its_time_and_then_the_new_wheel_counts() {
    let mut machine = machine(&two_wheels(0.0));
    order(&mut machine, MachineCommand::ChangeWheel { wheel: SECOND });
    assert!(machine.is_mounting() && machine.is_wheel_changing());
    // A tick before the end the old wheel is still expected in vain, and so is the new one.
    idle(&mut machine, CHANGE - 2);
    let (new, old) = (nm_from_mm(30.0), nm_from_mm(60.0));
    for radius_nm in [new, old] {
        let mut early = machine.clone();
        let report = order(&mut early, MachineCommand::ExpectWheel { radius_nm });
        assert_eq!(kinds(&[report]), [AlarmKind::OtherWheel], "{radius_nm}");
    }
    idle(&mut machine, 1);
    let report = machine.step(None, &[MachineCommand::ExpectWheel { radius_nm: new }, MachineCommand::WheelStart], &[]);
    assert_eq!(kinds(&[report]), []);
    assert_eq!(machine.description().wheel.width_mm.to_bits(), 12.0_f64.to_bits());
    // Its spindle is at 45 m/s after half a second: 1500 rad/s at 30 mm.
    let reports = idle(&mut machine, 499);
    assert!(!reports[497].io.wheel_running && reports[498].io.wheel_running);
    assert!((reports[498].wheel_rad_s - 1500.0).abs() < 1e-9, "{}", reports[498].wheel_rad_s);
    assert!((machine.orders().wheel_rad_s - 1500.0).abs() < 1e-9);
    let report = order(&mut machine, MachineCommand::ExpectWheel { radius_nm: old });
    assert_eq!(kinds(&[report]), [AlarmKind::OtherWheel]);
}

#[test]
fn the_mounted_wheel_takes_no_time_to_mount_even_in_the_cut() {
    let mut machine = machine(&two_wheels(0.0));
    order(&mut machine, MachineCommand::WheelStart);
    idle(&mut machine, 2500);
    let report = order(&mut machine, MachineCommand::ChangeWheel { wheel: FIRST });
    assert!(kinds(&[report]).is_empty() && report.io.wheel_running && !machine.is_mounting());
    // A machine without a changer has wheel 0 mounted.
    let mut simple = super::machine(&ideal());
    assert_eq!(kinds(&[order(&mut simple, MachineCommand::ChangeWheel { wheel: 0 })]), []);
    let report = order(&mut simple, MachineCommand::ChangeWheel { wheel: 1 });
    assert_eq!(kinds(&[report]), [AlarmKind::NoSuchWheel]);
    let text = report.raised.first().expect("one").to_string();
    assert!(text.contains("wheel 2 was asked for, the machine has 1"), "{text}");
}

#[test]
fn a_wheel_that_turns_or_is_not_clear_or_does_not_exist_is_not_changed() {
    let description = two_wheels(0.0);
    let ordered = |prepare: &dyn Fn(&mut Machine), wheel: u32| {
        let mut machine = machine(&description);
        prepare(&mut machine);
        let report = order(&mut machine, MachineCommand::ChangeWheel { wheel });
        assert!(!machine.is_mounting() && machine.description().mounted_wheel() == 0);
        let alarm = report.raised.first().copied().expect("an alarm");
        (alarm.kind, alarm.value, alarm.bound)
    };
    let starting = |machine: &mut Machine| _ = order(machine, MachineCommand::WheelStart);
    assert_eq!(ordered(&starting, SECOND), (AlarmKind::WheelNotChanged, 120.0, 100.0));
    // Running down is not at rest.
    let running_down = |machine: &mut Machine| {
        order(machine, MachineCommand::WheelStart);
        idle(machine, 2500);
        order(machine, MachineCommand::WheelStop);
        idle(machine, 1000);
    };
    assert_eq!(ordered(&running_down, SECOND).0, AlarmKind::WheelNotChanged);
    let advanced = |machine: &mut Machine| {
        let setpoints = travel(machine, Axis::X, -20.5, 1000);
        follow(machine, &setpoints);
        idle(machine, 100);
    };
    let (kind, x_mm, min_mm) = ordered(&advanced, SECOND);
    assert_eq!((kind, min_mm), (AlarmKind::WheelNotChanged, 100.0));
    assert!((x_mm - 99.5).abs() < 1e-4, "{x_mm}");
    let lost = |machine: &mut Machine| _ = order(machine, MachineCommand::LoseHome { axis: Axis::X });
    assert_eq!(ordered(&lost, SECOND).0, AlarmKind::NotHomed(Axis::X));
    assert_eq!(ordered(&|_| (), 2), (AlarmKind::NoSuchWheel, 3.0, 2.0));
    assert_eq!(ordered(&|_| (), u32::MAX).0, AlarmKind::NoSuchWheel);
}

#[test]
fn while_the_arm_moves_no_wheel_starts_and_x_stays_clear() {
    let mut machine = machine(&two_wheels(0.0));
    order(&mut machine, MachineCommand::ChangeWheel { wheel: SECOND });
    let mut started = machine.clone();
    let report = order(&mut started, MachineCommand::WheelStart);
    assert_eq!(kinds(&[report]), [AlarmKind::WheelNotChanged]);
    assert!(idle(&mut started, 600).iter().all(|report| report.wheel_rad_s == 0.0));
    let mut again = machine.clone();
    let report = order(&mut again, MachineCommand::ChangeWheel { wheel: FIRST });
    assert_eq!(kinds(&[report]), [AlarmKind::WheelNotChanged]);
    // X moves into the arm's way: an alarm within 0.05 mm of the bound, and once.
    let setpoints = travel(&machine, Axis::X, -25.0, 400);
    let reports = follow(&mut machine, &setpoints);
    assert_eq!(kinds(&reports), [AlarmKind::WheelNotChanged]);
    let alarm = reports.iter().find_map(|report| report.raised.first().copied()).expect("an alarm");
    assert!(alarm.value < 99.95 && alarm.value > 99.5, "{}", alarm.value);
    idle(&mut machine, CHANGE);
    assert_eq!(machine.description().mounted_wheel(), 1, "the arm finishes");
}

/// The arm finishes what it has begun, whatever stops the axes; it begins nothing while an alarm is active.
#[test]
fn an_emergency_stop_leaves_no_wheel_half_mounted() {
    for after in [1, CHANGE / 2, CHANGE - 1] {
        let mut machine = machine(&two_wheels(0.0));
        order(&mut machine, MachineCommand::ChangeWheel { wheel: SECOND });
        idle(&mut machine, after - 1);
        machine.step(None, &[], &[Fault::EStop(true)]);
        if after < CHANGE - 1 {
            assert!(machine.is_mounting() && machine.description().mounted_wheel() == 0, "{after}");
        }
        idle(&mut machine, CHANGE - 1 - after);
        assert!(!machine.is_mounting() && machine.description().mounted_wheel() == 1, "{after}");
        let report = order(&mut machine, MachineCommand::ChangeWheel { wheel: FIRST });
        assert!(!machine.is_mounting() && kinds(&[report]).is_empty());
        machine.step(None, &[], &[Fault::EStop(false)]);
        machine.reset().expect("the axes rest");
        change(&mut machine, FIRST);
    }
}

#[test]
fn a_door_that_is_forced_open_during_a_change_is_an_alarm_and_none_is_opened() {
    let times = [0.2, 0.2, 0.1, 0.1];
    let [door_opens_s, door_closes_s, chuck_opens_s, chuck_closes_s] = times;
    let loading = LoadingDescription { door_opens_s, door_closes_s, chuck_opens_s, chuck_closes_s, safe_x_mm: 100.0 };
    let mut machine = machine(&MachineDescription { loading: Some(loading), ..two_wheels(0.0) });
    order(&mut machine, MachineCommand::ChangeWheel { wheel: SECOND });
    assert!(machine.order_door(true).is_err());
    machine.step(None, &[], &[Fault::Loading(LoadingFault::DoorForced(true))]);
    assert_eq!(kinds(&idle(&mut machine, 1)), []);
    assert!(machine.alarms().iter().any(|alarm| alarm.kind == AlarmKind::DoorOpened));
}

/// A cutting point that is e nearer to the part than X says leaves a journal that is e smaller in radius, until the wheel is dressed.
#[test]
fn a_setting_error_grinds_the_journal_smaller_until_the_wheel_is_dressed() {
    for error_mm in [0.008, -0.005] {
        let mut description = two_wheels(error_mm);
        for wheel in &mut description.wheel_changer.as_mut().expect("a changer").wheels {
            wheel.wheel.grinding_ratio = None;
        }
        description.wheel.grinding_ratio = None;
        description.dresser = Some(Dresser {
            x_mm: 110.0,
            z_mm: 200.0,
            width_mm: 2.0,
            infeed_speed_mm_s: 1.0,
            traverse_speed_mm_s: 5.0,
            dwell_s: 0.0,
            max_depth_mm: 6.0,
        });
        let mut machine = loaded(&description, 20.6);
        let near = |(low, high): (f64, f64), wanted: f64| {
            assert!(low > wanted - 1e-5 && high < wanted + 5e-5, "{low} {high} {wanted}");
        };
        grind(&mut machine, 20.4);
        near(radii(&machine), 20.4);
        change(&mut machine, SECOND);
        grind(&mut machine, 20.2);
        near(radii(&machine), 20.2 - error_mm);
        // Back and forth, the error stays with its wheel.
        change(&mut machine, FIRST);
        grind(&mut machine, 20.1);
        near(radii(&machine), 20.1);
        change(&mut machine, SECOND);
        let counts = [0, description.axes[1].scale.counts(110.0), description.axes[2].scale.counts(200.0)];
        machine.place(counts);
        let report = order(&mut machine, MachineCommand::Dress { radius_nm: nm_from_mm(29.8) });
        assert_eq!(kinds(&[report]), []);
        assert_eq!(machine.lasting().wheel_zero_error_mm.to_bits(), 0.0_f64.to_bits());
        grind(&mut machine, 20.0);
        near(radii(&machine), 20.0);
        // The dresser knows the smallest radius of each wheel: 25 mm of this one.
        machine.place(counts);
        let report = order(&mut machine, MachineCommand::Dress { radius_nm: nm_from_mm(24.9) });
        assert_eq!(kinds(&[report]), [AlarmKind::NotDressed]);
    }
}

/// Each wheel loses A/(2π R G) of its own, keeps it in the magazine, and counts the lobes and parts that it ground.
#[test]
fn each_wheel_has_its_own_wear_and_counts() {
    let mut machine = loaded(&two_wheels(0.0), 22.0);
    let roughed = grind(&mut machine, 20.5);
    change(&mut machine, SECOND);
    assert_eq!((machine.lasting().wheel_wear_mm, machine.lasting().lobes_since_dress), (0.0, 0));
    let finished = grind(&mut machine, 20.2);
    let expected = [roughed / (TURN_RAD * 60.0 * 200.0), finished / (TURN_RAD * 30.0 * 50.0)];
    let wear = |machine: &Machine| [0, 1].map(|wheel| machine.lasting().wheel_at(wheel).expect("two wheels").wear_mm);
    let both = wear(&machine);
    for (found, expected) in both.iter().zip(expected) {
        assert!(expected > 1e-4 && (found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
    machine.count_part();
    change(&mut machine, FIRST);
    assert_eq!(wear(&machine).map(f64::to_bits), both.map(f64::to_bits), "mounting changes no wear");
    assert_eq!(machine.lasting().wheel_wear_mm.to_bits(), both[0].to_bits());
    // The next part only the first wheel grinds.
    machine.load_lobe("I1", "LS1", 15.0, vec![22.0; 3600]).expect("a round blank");
    grind(&mut machine, 21.0);
    machine.count_part();
    // And nobody grinds the one after it.
    machine.count_part();
    let counts = [0, 1].map(|wheel| {
        let wheel = machine.lasting().wheel_at(wheel).expect("two wheels");
        (wheel.lobes_since_dress, wheel.parts_since_dress)
    });
    assert_eq!(counts, [(2, 2), (1, 1)]);
    assert_eq!(machine.lasting().life.total, 3);
    let wheels = machine.lasting().wheels();
    assert_eq!(wheels.wheel(machine.description(), 1), machine.lasting().wheel_at(1).expect("two wheels").now());
}

#[test]
fn a_machine_begins_with_the_wheel_that_was_mounted_last() {
    let description = two_wheels(0.004);
    let mut first = machine(&description);
    change(&mut first, SECOND);
    let lasting = first.lasting().with_wheels(&first.lasting().wheels());
    assert_eq!(&lasting, first.lasting());
    let again = Machine::new(description.clone(), lasting).expect("the same machine");
    assert_eq!(again.description().mounted_wheel(), 1);
    assert_eq!(again.description().wheel.new_radius_mm.to_bits(), 30.0_f64.to_bits());
    assert_eq!(again.lasting(), first.lasting());
    // A state of a machine with one wheel is that of the mounted wheel.
    let one = PersistentState::new(&ideal()).with_wheel(WheelNow::dressed(59.0));
    let grown = Machine::new(description.clone(), one).expect("a machine that got a changer");
    assert_eq!(grown.lasting().wheel_at(0).map(|wheel| wheel.radius_mm), Some(59.0));
    assert_eq!(grown.lasting().wheel_at(1).map(|wheel| wheel.radius_mm), Some(30.0));
    let refused = Machine::new(ideal(), lasting).expect_err("no changer");
    assert_eq!(refused, DescriptionError::WheelStates { states: 2, wheels: 0 });
}

#[test]
fn impossible_changers_are_refused() {
    let refused = |change: &dyn Fn(&mut WheelChanger)| {
        let mut description = two_wheels(0.0);
        change(description.wheel_changer.as_mut().expect("a changer"));
        description.validate().expect_err("impossible").to_string()
    };
    assert!(refused(&|changer| _ = changer.wheels.pop()).contains("1 wheels"));
    assert!(refused(&|changer| changer.wheels[1].name = "roughing".into()).contains("two wheels"));
    assert!(refused(&|changer| changer.wheels[1].wheel.width_mm = 0.0).contains("wheel width (mm)"));
    assert!(refused(&|changer| changer.wheels[1].wheel.surface_speed_m_s = 70.0).contains("at most 60"));
    assert!(refused(&|changer| changer.wheels[1].setting_error_mm = f64::NAN).contains("setting error"));
    assert!(refused(&|changer| changer.change_s = 0.0).contains("time of a wheel change"));
    assert!(refused(&|changer| changer.min_x_mm = 1e4).contains("smallest x_axis"));
    assert!(refused(&|changer| changer.mounted = 2).contains("no wheel 2"));
    assert!(refused(&|changer| changer.mounted = 1).contains("finishing"));
    let lathe = camwright::machine::reference::lathe();
    let turned = MachineDescription { wheel_changer: two_wheels(0.0).wheel_changer, ..lathe };
    assert_eq!(turned.validate(), Err(DescriptionError::OnlyOfAGrinder { what: "a wheel changer" }));
}
