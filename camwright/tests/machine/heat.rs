// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Process values at every degree of a lobe: power, specific energy, temperature.

use super::{ideal, machine, turned};
use camwright::machine::description::{
    Axis, ContactDescription, GrindingProcess, MachineDescription, ReferenceCut, StiffnessAt,
};
use camwright::machine::setpoint::Setpoint;
use camwright::math::units::TURN_RAD;
use camwright::simulation::MachineCommand;
use camwright::simulation::process_monitor::{Engaged, Heat, ProcessMonitor};
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, DEGREES, RemovalAtDegree};

const Z_MM: f64 = 60.0;
const WIDTH_MM: f64 = 15.0;
const WHEEL_MM: f64 = 60.0;
/// Infeed of a turn (mm), and the time of one (s).
const FEED_MM: f64 = 0.01;
const TURN_S: f64 = 0.4;

fn grinder(process: Option<GrindingProcess>) -> MachineDescription {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: Z_MM, n_mm: 5e4 }],
        grinding_n_mm2: 1e3,
        threshold_n_mm: 0.5,
        part_share: 0.5,
        modes: Vec::new(),
    };
    MachineDescription { contact: Some(contact), process, ..ideal() }
}

const PROCESS: GrindingProcess = GrindingProcess {
    specific_energy_j_mm3: 40.0,
    rubbing_n_mm2: 0.05,
    safe_cut: ReferenceCut { footprint_speed_mm_s: 300.0, depth_mm: 0.01, equivalent_diameter_mm: 30.0 },
};

/// Degrees of a lobe, and largest live values, of a raw outline that is ground over some turns with X as a function of C (mm over rad).
fn plunged(
    description: &MachineDescription,
    raw_mm: impl Fn(f64) -> f64,
    turns: f64,
    x: impl Fn(f64) -> (f64, f64, f64),
) -> (Vec<RemovalAtDegree>, Heat) {
    #[allow(clippy::cast_possible_truncation, reason = "some thousand ticks")]
    let ticks = (turns * TURN_S / description.cycle_time_s()) as u32;
    let setpoints: Vec<Setpoint> = turned::turning(description, Z_MM, turns, ticks, x);
    let mut machine = machine(description);
    let radii = (0..DEFAULT_AZIMUTHS).map(|i| raw_mm(TURN_RAD * i as f64 / DEFAULT_AZIMUTHS as f64)).collect();
    machine.load_lobe("I1", "LS1", WIDTH_MM, radii).expect("a raw part");
    machine.place(setpoints[0].counts);
    let mut live = ProcessMonitor::new(description).expect("a contact");
    let engaged = Engaged { wheel_radius_mm: WHEEL_MM, lobe_width_mm: WIDTH_MM };
    let mut peak = Heat::default();
    for setpoint in &setpoints[1..] {
        let report = machine.step(Some(setpoint), &[], &[]);
        live.add(&report, Some(engaged));
        // As often as viewers get it.
        if report.tick.is_multiple_of(20) {
            let values = live.take();
            assert_eq!(values.heat.is_some(), description.process.is_some());
            let heat = values.heat.unwrap_or_default();
            peak.power_w = peak.power_w.max(heat.power_w);
            peak.burn_index = peak.burn_index.max(heat.burn_index);
        }
    }
    assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
    let lobe = machine.part().lobe("I1").expect("it is there");
    (lobe.cut_record().map_or_else(Vec::new, |record| record.degrees().to_vec()), peak)
}

/// On a round part that is fed at one rate every degree takes what the formulas say: depth the feed of a turn, footprint speed that of the
/// surface, equivalent diameter 2Rr/(R + r).
#[test]
fn a_plunge_into_a_round_part_takes_the_power_of_the_closed_form() {
    let description = grinder(Some(PROCESS));
    let feed = |angle: f64| (20.3 - FEED_MM * angle / TURN_RAD, -FEED_MM / TURN_RAD, 0.0);
    let (degrees, live) = plunged(&description, |_| 20.3, 30.0, feed);
    assert_eq!(degrees.len(), DEGREES);
    let (wheel_mm, part_mm, wheel_m_s) = (WHEEL_MM, 20.1, description.wheel.surface_speed_m_s);
    let diameter_mm = 2.0 * wheel_mm * part_mm / (wheel_mm + part_mm);
    // C runs up and down at the ends; between them its speed is what the deepest cut met.
    let fastest = plunged_speed(&description, feed);
    let speed_mm_s = fastest * part_mm;
    let removal = FEED_MM * speed_mm_s;
    let power = 40.0 * removal + 0.05 * libm::sqrt(FEED_MM * diameter_mm) * wheel_m_s;
    let cut = ReferenceCut { footprint_speed_mm_s: speed_mm_s, depth_mm: FEED_MM, equivalent_diameter_mm: diameter_mm };
    for (degree, at) in degrees.iter().enumerate() {
        let close = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 0.03;
        assert!(close(at.power_w_mm, power), "{degree} deg: {at:?}, {power} W/mm");
        assert!(close(at.specific_energy_j_mm3, power / removal), "{degree} deg: {at:?}");
        assert!(close(at.burn_index, PROCESS.burn_index(&cut)), "{degree} deg: {at:?}");
    }
    is_live(live, &degrees, &description);
}

/// A lobe that was loaded with another wheel mounted is ground with the power of the wheel that grinds it: speed and width are its own.
#[test]
fn a_wheel_that_was_changed_grinds_with_its_own_speed_and_width() {
    let mut description = MachineDescription {
        wheel_changer: super::wheel_changer::two_wheels(0.0).wheel_changer,
        ..grinder(Some(PROCESS))
    };
    for wheel in &mut description.wheel_changer.as_mut().expect("a changer").wheels {
        wheel.wheel.grinding_ratio = None;
    }
    let mut machine = machine(&description);
    machine.load_lobe("I1", "LS1", WIDTH_MM, vec![20.3; DEFAULT_AZIMUTHS]).expect("a raw part");
    let mut live = ProcessMonitor::new(&description).expect("a contact");
    machine.step(None, &[MachineCommand::ChangeWheel { wheel: 1 }], &[]);
    (0..1000).for_each(|_| _ = machine.step(None, &[], &[]));
    let second = machine.description().wheel;
    assert_eq!((second.new_radius_mm, second.width_mm), (30.0, 12.0));
    live.mount(&second);
    let feed = |angle: f64| (20.3 - FEED_MM * angle / TURN_RAD, -FEED_MM / TURN_RAD, 0.0);
    let setpoints = turned::turning(&description, Z_MM, 30.0, 12_000, feed);
    machine.place(setpoints[0].counts);
    let engaged = Engaged { wheel_radius_mm: second.new_radius_mm, lobe_width_mm: WIDTH_MM };
    for setpoint in &setpoints[1..] {
        live.add(&machine.step(Some(setpoint), &[], &[]), Some(engaged));
    }
    let part_mm = 20.1;
    let diameter_mm = 2.0 * second.new_radius_mm * part_mm / (second.new_radius_mm + part_mm);
    let removal = FEED_MM * plunged_speed(&description, feed) * part_mm;
    let power = 40.0 * removal + 0.05 * libm::sqrt(FEED_MM * diameter_mm) * second.surface_speed_m_s;
    let close = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 0.03;
    let lobe = machine.part().lobe("I1").expect("it is there");
    for (degree, at) in lobe.cut_record().expect("a process").degrees().iter().enumerate() {
        assert!(close(at.power_w_mm, power), "{degree} deg: {at:?}, {power} W/mm");
    }
    let live = live.take().heat.expect("a process").power_w;
    assert!(close(live, power * second.width_mm), "{live} W, {power} W/mm");
}

/// Largest speed of C over a plunge (rad/s).
fn plunged_speed(description: &MachineDescription, x: impl Fn(f64) -> (f64, f64, f64)) -> f64 {
    let setpoints: Vec<Setpoint> = turned::turning(description, Z_MM, 30.0, 12_000, x);
    setpoints.iter().map(|setpoint| setpoint.velocity[Axis::C.index()]).fold(0.0, f64::max)
}

/// At a high spot of a raw part the wheel cuts more, takes more power, and the part gets hotter.
#[test]
fn what_stands_out_of_a_raw_part_is_cut_harder_and_hotter() {
    let description = grinder(Some(PROCESS));
    let feed = |angle: f64| (20.3 - FEED_MM * angle / TURN_RAD, -FEED_MM / TURN_RAD, 0.0);
    let (degrees, live) = plunged(&description, |azimuth| 20.28 + 0.015 * azimuth.cos(), 6.0, feed);
    let mean =
        |from: usize, of: fn(&RemovalAtDegree) -> f64| (from..from + 30).map(|i| of(&degrees[i])).sum::<f64>() / 30.0;
    let (out, back) = (mean(20, |at| at.power_w_mm), mean(165, |at| at.power_w_mm));
    assert!(out > 1.05 * back, "{out} W/mm where it stands out, {back} W/mm opposite");
    assert!(mean(20, |at| at.burn_index) > mean(165, |at| at.burn_index));
    is_live(live, &degrees, &description);
}

/// Live values, which a viewer computes from the reports, peak at the values of the record.
fn is_live(live: Heat, degrees: &[RemovalAtDegree], description: &MachineDescription) {
    let width_mm = WIDTH_MM.min(description.wheel.width_mm);
    let largest = |of: fn(&RemovalAtDegree) -> f64| degrees.iter().map(of).fold(0.0, f64::max);
    let (power_w, burn_index) = (width_mm * largest(|at| at.power_w_mm), largest(|at| at.burn_index));
    let is_close = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 0.03;
    assert!(is_close(live.power_w, power_w), "{live:?}, recorded {power_w} W");
    assert!(is_close(live.burn_index, burn_index), "{live:?}, recorded {burn_index}");
}

#[test]
fn a_machine_that_knows_nothing_of_the_process_keeps_no_record() {
    let feed = |angle: f64| (20.3 - FEED_MM * angle / TURN_RAD, -FEED_MM / TURN_RAD, 0.0);
    assert!(plunged(&grinder(None), |_| 20.3, 2.0, feed).0.is_empty());
}
