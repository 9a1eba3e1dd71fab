// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Crank pins, whose centre goes round the axis of C: what the wheel leaves of one, and what it feels.

use super::turned::{Eccentric, WHEEL_MM, turning};
use super::{follow, ideal, idle, machine, setpoint, soft_contact, stop_and_clear};
use camwright::cam::contour::LobeCentre;
use camwright::machine::description::{Axis, DriveSettings, GaugeDescription, GaugeKind, MachineDescription};
use camwright::machine::setpoint::Setpoint;
use camwright::math::range::minimum_and_maximum;
use camwright::math::units::TURN_RAD;
use camwright::simulation::Machine;
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, LobeError};

const Z_MM: f64 = 60.0;
const WIDTH_MM: f64 = 15.0;
const PIN: Eccentric = Eccentric { radius_mm: 25.0, offset_mm: 40.0 };
/// Azimuth of the pin's centre on the part.
const AT_RAD: f64 = 0.7;

/// The reference machine with ideal drives and a wheelhead that reaches past the axis.
pub(crate) fn crank_grinder(rotation_sense: i8) -> MachineDescription {
    let mut description = MachineDescription { rotation_sense, ..ideal() };
    let x = &mut description.axes[Axis::X.index()];
    (x.soft_limits, x.overtravel) = (Some((-30.0, 250.0)), Some((-32.0, 255.0)));
    description
}

/// A raw pin of this radius in front of the wheel.
pub(crate) fn loaded(description: &MachineDescription, radius_mm: f64) -> Machine {
    let mut machine = machine(description);
    let centre = Some(LobeCentre { distance_mm: PIN.offset_mm, azimuth_rad: AT_RAD });
    let radii = vec![radius_mm; DEFAULT_AZIMUTHS];
    machine.load_lobe_about("P1", "LS1", (WIDTH_MM, radii), centre).expect("a raw pin");
    machine
}

/// C turns so many times with X on the path of the pin.
pub(crate) fn chasing(description: &MachineDescription, turns: f64, ticks: u32) -> Vec<Setpoint> {
    let sense = f64::from(description.rotation_sense);
    turning(description, Z_MM, turns, ticks, |c| {
        let (x, first, second) = PIN.path(sense * c - AT_RAD);
        (x, sense * first, second)
    })
}

fn radii(machine: &Machine) -> &[f64] {
    machine.part().lobe("P1").expect("it was loaded").radii_mm()
}

/// Ground by its exact path on ideal drives the pin is round within 0.1 µm: cusps of the sweep, a count of X, and a count of C at
/// the throw, 0.07 µm.
#[test]
fn a_pin_is_ground_round_by_its_exact_path() {
    for sense in [1, -1] {
        let description = crank_grinder(sense);
        let mut machine = loaded(&description, 25.2);
        let setpoints = chasing(&description, 4.0, 8000);
        machine.place(setpoints[0].counts);
        let reports = follow(&mut machine, &setpoints);
        assert!(reports.iter().all(|report| report.raised.is_empty()), "{:?}", machine.alarms());
        let (low, high) = minimum_and_maximum(radii(&machine).iter().map(|radius| radius - PIN.radius_mm));
        eprintln!("sense {sense}: {:.3} to {:.3} um", 1e3 * low, 1e3 * high);
        assert!(low > -1e-4 && high < 1e-4 && high - low < 1e-4, "sense {sense}: {low} {high}");
        let removed: f64 = reports.iter().map(|report| report.removal.area_mm2).sum();
        let wanted = 0.5 * TURN_RAD * (25.2_f64.powi(2) - 25.0_f64.powi(2));
        assert!((removed - wanted).abs() < 1e-3 * wanted, "{removed} mm2 of {wanted}");
    }
}

/// First-order loops without feed-forward grind a pin whose throw is smaller by e ω²/(2 Kv²) to first order, and lag alone turns it by
/// nothing where both axes lag the same.
#[test]
fn lag_makes_the_throw_smaller_by_its_closed_form() {
    let kv = 100.0;
    let settings = DriveSettings {
        kv_1_s: kv,
        velocity_feed_forward: 0.0,
        acceleration_feed_forward: 0.0,
        ..DriveSettings::IDEAL
    };
    let mut description = crank_grinder(1).with_drives(settings);
    for axis in &mut description.axes {
        (axis.max_following_error, axis.min_following_error) = (20.0, 20.0);
    }
    let (turns, ticks) = (5.0, 37_500_u32);
    let mut machine = loaded(&description, 25.5);
    let setpoints = chasing(&description, turns, ticks);
    machine.place(setpoints[0].counts);
    follow(&mut machine, &setpoints);
    let speed = 1.875 * turns * TURN_RAD / (f64::from(ticks) * 1e-3);
    let wanted_mm = PIN.offset_mm * speed * speed / (2.0 * kv * kv);
    // A circle off its place by d is r + d cos(φ − at): towards the axis the pin stands out, away from it it is cut.
    let radius_at = |azimuth: f64| machine.part().lobe("P1").expect("loaded").radius_between_mm(azimuth);
    let shift = 0.5 * (radius_at(AT_RAD) - radius_at(AT_RAD + 0.5 * TURN_RAD));
    assert!(shift < 0.0 && (-shift - wanted_mm).abs() < 0.5 * wanted_mm, "{shift} mm, {wanted_mm} mm");
}

fn soft(sense: i8) -> MachineDescription {
    MachineDescription { contact: Some(soft_contact(Z_MM, WIDTH_MM)), ..crank_grinder(sense) }
}

/// The wheel presses on a pin that stands: the force acts along the line of both centres, on X by its share along the wheel line and on C by
/// its arm about the axis, e sin φ with φ the azimuth of that line from the throw.
#[test]
fn the_force_on_a_pin_acts_along_the_line_of_the_centres() {
    for sense in [1_i8, -1] {
        for angle in [0.0, 0.9, 1.6, 3.0, 4.4] {
            let description = soft(sense);
            let mut machine = loaded(&description, PIN.radius_mm);
            let c = f64::from(sense) * (angle + AT_RAD);
            let touch = PIN.path(angle).0;
            let ticks = 800_u32;
            let setpoints: Vec<Setpoint> = (0..=ticks)
                .map(|tick| {
                    let (share, first, second) = super::ease(f64::from(tick) / f64::from(ticks));
                    let (way, seconds) = (-0.08, f64::from(ticks) * 1e-3);
                    let x = [way * share, way * first / seconds, way * second / seconds / seconds];
                    setpoint(&description, [c, touch + 0.05 + x[0], Z_MM], [0.0, x[1], 0.0], [0.0, x[2], 0.0])
                })
                .collect();
            machine.place(setpoints[0].counts);
            follow(&mut machine, &setpoints[1..]);
            let report = idle(&mut machine, 50).pop().expect("50 ticks");
            let beta = -(PIN.offset_mm * angle.sin() / (PIN.radius_mm + WHEEL_MM)).asin();
            let force = report.normal_force_n;
            assert!(force > 14.0, "{angle}: {force} N");
            let (on_x, on_c) = (report.axes[1].effort, report.axes[0].effort);
            assert!((on_x + force * beta.cos()).abs() < 0.02 * force, "{angle}: {on_x} N of {force} N");
            let arm_m = PIN.offset_mm * (angle - beta).sin() * 1e-3;
            let wanted = -f64::from(sense) * force * arm_m;
            assert!((on_c - wanted).abs() < 0.02 * force * 0.04, "sense {sense}, {angle}: {on_c} Nm, {wanted} Nm");
        }
    }
}

/// Wheel and part deflect along the normal of the pin: what is left of its stock is the same all round, turn after turn.
#[test]
fn a_pin_gives_way_along_its_normal() {
    for sense in [1, -1] {
        let description = soft(sense);
        let law = description.contact.as_ref().and_then(|contact| contact.law(Z_MM, WIDTH_MM)).expect("a law");
        let mut machine = loaded(&description, PIN.radius_mm + 0.03);
        let setpoints = chasing(&description, 3.4, 4000);
        machine.place(setpoints[0].counts);
        follow(&mut machine, &setpoints);
        assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
        let left = (0..3).fold(PIN.radius_mm + 0.03, |radius, _| law.radius_after_mm(radius, PIN.radius_mm));
        let again = law.radius_after_mm(left, PIN.radius_mm);
        for (i, radius) in radii(&machine).iter().enumerate() {
            let off = (radius - left).abs().min((radius - again).abs());
            assert!(
                off < 5e-5 || (again..left).contains(radius),
                "sense {sense}, azimuth {i}: {radius} mm, {left} {again}"
            );
        }
    }
}

/// A stop at any phase takes the wheel off the pin wherever it swings, and cuts nothing below its size.
#[test]
fn a_stop_in_the_cut_clears_the_whole_swing_of_the_pin() {
    for at in (0..1600).step_by(199) {
        let description = crank_grinder(1);
        let mut machine = loaded(&description, 25.2);
        let setpoints = chasing(&description, 2.0, 4000);
        stop_and_clear(&mut machine, &setpoints, 2000 + at);
        let (low, _) = minimum_and_maximum(radii(&machine).iter().copied());
        assert!(low > PIN.radius_mm - 1e-4, "at {at}: {low} mm");
    }
}

/// A gauge on the axis reads nothing of a pin.
#[test]
fn the_gauge_on_the_axis_does_not_read_a_pin() {
    let gauge = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: 4.7,
        second_behind_wheel_rad: None,
        resolution_mm: 1e-4,
        noise_mm: 0.0,
        bandwidth_rad_s: None,
        seed: 1,
    };
    let description = MachineDescription { gauge: Some(gauge), ..crank_grinder(1) };
    let readings = |mut machine: Machine| {
        let setpoints = chasing(&description, 1.0, 2000);
        machine.place(setpoints[0].counts);
        follow(&mut machine, &setpoints).iter().filter(|report| report.gauge_mm[0].is_some()).count()
    };
    assert_eq!(readings(loaded(&description, 25.0)), 0);
    let mut about_the_axis = machine(&description);
    about_the_axis.load_lobe("J1", "LS1", WIDTH_MM, vec![10.0; 720]).expect("a journal");
    assert!(readings(about_the_axis) > 1000);
}

#[test]
fn a_centre_that_is_none_is_refused() {
    let description = crank_grinder(1);
    for (distance_mm, azimuth_rad) in [(-1.0, 0.0), (f64::NAN, 0.0), (40.0, f64::INFINITY)] {
        let centre = Some(LobeCentre { distance_mm, azimuth_rad });
        let refused = machine(&description).load_lobe_about("P1", "LS1", (WIDTH_MM, vec![25.0; 720]), centre);
        assert!(matches!(refused, Err(LobeError::Centre { .. })), "{refused:?}");
    }
}
