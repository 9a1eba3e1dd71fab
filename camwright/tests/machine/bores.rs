// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bores: what the wheel inside leaves of the wall, and what it feels.

use super::turned::turning;
use super::{follow, ideal, machine, soft_contact, stop_and_clear};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::form::Form;
use camwright::cam::lift::LiftLaw;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::setpoint::Setpoint;
use camwright::math::range::minimum_and_maximum;
use camwright::math::units::TURN_RAD;
use camwright::simulation::Machine;
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, LobeError};
use camwright::toolpath::wheel_path::ToolPath;

const Z_MM: f64 = 60.0;
const WIDTH_MM: f64 = 10.0;
const WHEEL_MM: f64 = 12.0;
/// Azimuth of cam angle 0 on the part.
const AT_RAD: f64 = 0.7;

/// Wall of a ring in a vane pump: two strokes of 1.5 mm a turn.
fn wall() -> Contour {
    let lift = LiftLaw::from_fn(|angle| 0.75 * (1.0 - (2.0 * angle).cos())).expect("a law");
    Contour::from_lift(&lift, &Follower::KnifeEdge { offset_mm: 0.0 }, 20.0).and_then(Contour::bore).expect("a bore")
}

/// The reference machine with ideal drives, a small wheel, and a wheelhead that reaches past the axis.
fn bore_grinder(rotation_sense: i8) -> MachineDescription {
    let mut description = MachineDescription { rotation_sense, ..ideal() };
    description.wheel.new_radius_mm = WHEEL_MM;
    description.wheel.min_radius_mm = 8.0;
    description.wheel.surface_speed_m_s = 30.0;
    description.wheel.width_mm = WIDTH_MM;
    let x = &mut description.axes[Axis::X.index()];
    (x.soft_limits, x.overtravel) = (Some((-40.0, 250.0)), Some((-42.0, 255.0)));
    description
}

/// A raw wall with this stock in front of the wheel.
fn loaded(description: &MachineDescription, stock_mm: f64) -> Machine {
    let mut machine = machine(description);
    let contour = wall();
    let radius = |i: usize| contour.radius_at(TURN_RAD * i as f64 / DEFAULT_AZIMUTHS as f64 - AT_RAD);
    let radii = (0..DEFAULT_AZIMUTHS).map(|i| stock_mm - radius(i)).collect();
    machine.load_lobe("B1", "LS1", WIDTH_MM, radii).expect("a raw bore");
    machine
}

/// C turns so many times with X on the path of the wall.
fn along_the_wall(description: &MachineDescription, turns: f64, ticks: u32) -> Vec<Setpoint> {
    let path = ToolPath::for_wheel(&wall(), WHEEL_MM).expect("the wheel fits");
    let sense = f64::from(description.rotation_sense);
    turning(description, Z_MM, turns, ticks, |c| {
        let x = path.sample(sense * c - AT_RAD);
        (x.value, sense * x.first, x.second)
    })
}

fn radii(machine: &Machine) -> &[f64] {
    machine.part().lobe("B1").expect("it was loaded").radii_mm()
}

/// Ground by its exact path on ideal drives the wall has its form within 0.1 µm, and what was removed is the area between both walls.
#[test]
fn a_bore_is_ground_to_its_form_by_its_exact_path() {
    for sense in [1, -1] {
        let description = bore_grinder(sense);
        let mut machine = loaded(&description, 0.2);
        let raw = radii(&machine).to_vec();
        let setpoints = along_the_wall(&description, 4.0, 8000);
        machine.place(setpoints[0].counts);
        let reports = follow(&mut machine, &setpoints);
        assert!(reports.iter().all(|report| report.raised.is_empty()), "{:?}", machine.alarms());
        let form = Form::measure(radii(&machine), &wall(), AT_RAD).expect("radii");
        let (low, high) = minimum_and_maximum(form.deviations_mm.iter().copied());
        assert!(low > -1e-4 && high < 1e-4, "sense {sense}: {low} to {high} mm");
        let removed: f64 = reports.iter().map(|report| report.removal.area_mm2).sum();
        let half_step = 0.5 * TURN_RAD / raw.len() as f64;
        let wanted: f64 =
            radii(&machine).iter().zip(&raw).map(|(after, raw)| (after * after - raw * raw) * half_step).sum();
        assert!(wanted > 20.0 && (removed - wanted).abs() < 1e-9 * wanted, "{removed} mm2 of {wanted}");
    }
}

fn soft(sense: i8) -> MachineDescription {
    MachineDescription { contact: Some(soft_contact(Z_MM, WIDTH_MM)), ..bore_grinder(sense) }
}

/// Wheel and wall deflect along the normal: what is left of an even stock is the same all round, turn after turn, by the contact law.
#[test]
fn a_wall_gives_way_along_its_normal() {
    for sense in [1, -1] {
        let description = soft(sense);
        let law = description.contact.as_ref().and_then(|contact| contact.law(Z_MM, WIDTH_MM)).expect("a law");
        let mut machine = loaded(&description, 0.03);
        let setpoints = along_the_wall(&description, 3.4, 8000);
        machine.place(setpoints[0].counts);
        let reports = follow(&mut machine, &setpoints);
        assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
        assert!(reports.iter().all(|report| report.normal_force_n < 500.0));
        let left = (0..3).fold(0.03, |stock, _| law.radius_after_mm(stock, 0.0));
        let again = law.radius_after_mm(left, 0.0);
        let form = Form::measure(radii(&machine), &wall(), AT_RAD).expect("radii");
        for (i, deviation) in form.deviations_mm.iter().enumerate() {
            let off = (deviation - left).abs().min((deviation - again).abs());
            assert!(
                off < 2e-4 || (again..left).contains(deviation),
                "sense {sense}, azimuth {i}: {deviation} mm, {left} {again}"
            );
        }
    }
}

/// A stop at any phase takes the wheel off the wall, towards the axis, and cuts nothing below the size.
#[test]
fn a_stop_in_the_cut_takes_the_wheel_off_the_wall() {
    for at in (0..1600).step_by(399) {
        let description = bore_grinder(1);
        let mut machine = loaded(&description, 0.2);
        let setpoints = along_the_wall(&description, 2.0, 4000);
        stop_and_clear(&mut machine, &setpoints, 2000 + at);
        let x_mm = machine.truth()[Axis::X.index()].0;
        assert!(x_mm < -12.0, "at {at}: it retracts by the clearance and not out of the part: {x_mm} mm");
        let form = Form::measure(radii(&machine), &wall(), AT_RAD).expect("radii");
        assert!(form.deviations_mm.iter().all(|deviation| *deviation > -1e-4), "at {at}");
    }
}

#[test]
fn radii_of_both_signs_are_no_outline() {
    let description = bore_grinder(1);
    for index in [0, 5] {
        let mut radii = vec![-20.0; 720];
        radii[index] = 20.0;
        let refused = machine(&description).load_lobe("B1", "LS1", WIDTH_MM, radii);
        assert!(matches!(refused, Err(LobeError::Radius { .. })), "{refused:?}");
    }
}
