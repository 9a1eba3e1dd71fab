// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A journal that runs out, on the simulated machine: its gauge reads, one turn corrects, and the part is round.

use super::{ideal, machine, setpoint};
use camwright::gauging::correction::{Correction, CorrectionStart, CorrectionTarget};
use camwright::gauging::gauge::Gauge;
use camwright::gauging::record::{GaugeRecord, RunoutReading};
use camwright::gauging::state::{MeasureSettings, PartState};
use camwright::gauging::wheel_log::{WheelLog, WheelPosition};
use camwright::machine::contact_law::ContactLaw;
use camwright::machine::description::{
    ContactDescription, GaugeDescription, GaugeKind, MachineDescription, StiffnessAt,
};
use camwright::math::hermite::Sample;
use camwright::math::units::TURN_RAD;
use camwright::simulation::Machine;
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;

const WIDTH_MM: f64 = 20.0;
const KG_N_MM: f64 = 5.0e4;
const Z_MM: f64 = 60.0;
/// The wheel comes from where it touches nothing (mm), by so much a turn, for so many turns, and then dwells for two.
const FROM_MM: f64 = 20.15;
const FEED_MM: f64 = 0.01;
const FEED_TURNS: f64 = 12.0;
const DWELL_TURNS: f64 = 2.0;
/// The gauge is heard from a turn before the dwell on.
const HEARD_FROM_RAD: f64 = (FEED_TURNS - 1.0) * TURN_RAD;
const SPEED_RAD_S: f64 = TURN_RAD;

fn journal_grinder(machine_n_mm: f64, gamma_deg: f64, noise_mm: f64) -> (MachineDescription, ContactLaw) {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: Z_MM, n_mm: machine_n_mm }],
        grinding_n_mm2: KG_N_MM / WIDTH_MM,
        threshold_n_mm: 15.0 / WIDTH_MM,
        part_share: 0.7,
        modes: Vec::new(),
    };
    let law = contact.law(Z_MM, WIDTH_MM).expect("a law");
    let gauge = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: gamma_deg.to_radians(),
        second_behind_wheel_rad: None,
        resolution_mm: 0.0,
        noise_mm,
        bandwidth_rad_s: None,
        seed: 7,
    };
    (MachineDescription { contact: Some(contact), gauge: Some(gauge), ..ideal() }, law)
}

/// A machine that turns a journal of radius 20 mm and some stock, 50 µm out of round by two harmonics.
struct TurningJournal {
    machine: Machine,
    tick: u32,
    readings: Vec<RunoutReading>,
    positions: Vec<WheelPosition>,
}

impl TurningJournal {
    fn new(description: &MachineDescription) -> Self {
        let azimuth = |i: usize| TURN_RAD * i as f64 / DEFAULT_AZIMUTHS as f64;
        let raw = |azimuth: f64| 20.12 + 0.02 * (azimuth - 1.0).cos() + 0.005 * (3.0 * azimuth).sin();
        let mut machine = machine(description);
        let radii = (0..DEFAULT_AZIMUTHS).map(|i| raw(azimuth(i))).collect();
        machine.load_lobe("J1", "LS1", WIDTH_MM, radii).expect("a raw journal");
        let start = setpoint(description, [0.0, FROM_MM, Z_MM], [0.0; 3], [0.0; 3]);
        machine.place(start.counts);
        Self { machine, tick: 0, readings: Vec::new(), positions: Vec::new() }
    }

    /// C and its speed and acceleration at a tick: to its speed in a quarter of a second, and on.
    fn c(tick: u32) -> Sample {
        let (seconds, run_up_s) = (f64::from(tick) * 1e-3, 0.25);
        let acceleration = SPEED_RAD_S / run_up_s;
        match seconds < run_up_s {
            true => Sample {
                value: 0.5 * acceleration * seconds * seconds,
                first: acceleration * seconds,
                second: acceleration,
                ..Sample::default()
            },
            false => {
                Sample { value: SPEED_RAD_S * (seconds - 0.5 * run_up_s), first: SPEED_RAD_S, ..Sample::default() }
            }
        }
    }

    /// Until C has come to an angle, X over it (mm over rad).
    fn until(&mut self, end_rad: f64, x: impl Fn(f64) -> Sample) {
        while Self::c(self.tick).value < end_rad {
            self.tick += 1;
            let c = Self::c(self.tick);
            let x = x(c.value);
            let description = self.machine.description();
            let next = setpoint(
                description,
                [c.value, x.value, Z_MM],
                [c.first, x.first * c.first, 0.0],
                [c.second, x.second * c.first * c.first + x.first * c.second, 0.0],
            );
            let report = self.machine.step(Some(&next), &[], &[]);
            let c_rad = self.machine.description().axes[0].scale.position(next.counts[0]);
            self.positions.push(WheelPosition { c_rad, x_mm: report.axes[1].position });
            if c_rad > HEARD_FROM_RAD {
                let value_mm = report.gauge_mm[0].expect("C turns, the journal is there");
                self.readings.push(RunoutReading { c_rad, value_mm, tick: report.tick });
            }
        }
        assert!(self.machine.alarms().is_empty(), "{:?}", self.machine.alarms());
    }

    /// Largest radius less the smallest (mm).
    fn runout_mm(&self) -> f64 {
        let radii = self.machine.part().lobe("J1").expect("it is there").radii_mm();
        let (low, high) =
            radii.iter().fold((f64::INFINITY, 0.0), |(low, high), r| (f64::min(low, *r), f64::max(high, *r)));
        high - low
    }
}

fn feed_and_dwell(c_rad: f64) -> Sample {
    let slope = -FEED_MM / TURN_RAD;
    match c_rad < FEED_TURNS * TURN_RAD {
        true => Sample { value: FROM_MM + slope * c_rad, first: slope, ..Sample::default() },
        false => Sample { value: FROM_MM - FEED_MM * FEED_TURNS, ..Sample::default() },
    }
}

/// Runout before the turn that corrects and what it leaves (mm), and the correction's own forecast of both.
fn corrected(machine_n_mm: f64, gamma_deg: f64, noise_mm: f64) -> ((f64, f64), (f64, f64)) {
    let (description, law) = journal_grinder(machine_n_mm, gamma_deg, noise_mm);
    let mut turning = TurningJournal::new(&description);
    let ends = (FEED_TURNS + DWELL_TURNS) * TURN_RAD;
    turning.until(ends, feed_and_dwell);
    let (readings, positions) = (turning.readings.clone(), turning.positions.clone());
    let gauge = Gauge::diameter(gamma_deg.to_radians()).expect("a gauge that sees a cut");
    let record = GaugeRecord::from_one(gauge, &readings).expect("a record");
    let log = WheelLog::new(&positions).expect("a log");
    let part = PartState::measure(&record, log, law, &MeasureSettings::default()).expect("a part");
    let start = CorrectionStart::AtMinRadius { from_rad: ends };
    let correction =
        Correction::exact(&part, start, CorrectionTarget::MinRadius { extra_depth_mm: 0.0 }).expect("a turn");
    let begins = correction.start_rad();
    turning.until(begins, feed_and_dwell);
    let before_mm = turning.runout_mm();
    turning.until(begins + TURN_RAD, |c| correction.at(c - begins));
    // Its leading edge has begun nothing: the wheel stays where it takes nothing any more.
    turning.until(begins + 1.1 * TURN_RAD, |_| Sample { value: correction.leaves_mm(), ..Sample::default() });
    let forecast = correction.forecast().expect("of an exact correction");
    ((before_mm, turning.runout_mm()), (forecast.before_mm, forecast.left_mm))
}

/// On the simulated machine, whose wheel is a circle that presses along the normal of what it makes, one turn takes 99 % of the
/// runout, however soft the machine and wherever the gauge; doing nothing would have left kg/(kg + km) of it.
#[test]
fn one_turn_makes_a_journal_round_on_the_machine() {
    for (ratio, gamma_deg) in
        [(0.05, 270.0), (0.1, 270.0), (0.2, 270.0), (0.5, 270.0), (0.2, 90.0), (0.2, 135.0), (0.2, 225.0), (0.2, 315.0)]
    {
        let ((before_mm, left_mm), (reported_before_mm, _)) = corrected(ratio * KG_N_MM, gamma_deg, 0.0);
        eprintln!("km/kg {ratio}, gauge at {gamma_deg} deg: {:.3} um, {:.4} um left", 1e3 * before_mm, 1e3 * left_mm);
        assert!((reported_before_mm - before_mm).abs() < 0.02 * before_mm, "{reported_before_mm} mm, {before_mm} mm");
        assert!(left_mm < 0.01 * before_mm, "km/kg {ratio}, {gamma_deg} deg: {left_mm} of {before_mm} mm left");
    }
}

/// With noise of 0.2 µm at km/kg = 0.2 it leaves 1.5 µm at most.
#[test]
fn a_noisy_gauge_is_good_for_a_micrometre_and_a_half() {
    let ((before_mm, left_mm), _) = corrected(0.2 * KG_N_MM, 270.0, 2e-4);
    eprintln!("{:.3} um, {:.3} um left", 1e3 * before_mm, 1e3 * left_mm);
    assert!(left_mm < 1.5e-3, "{left_mm} of {before_mm} mm");
}
