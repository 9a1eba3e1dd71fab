// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Regenerative chatter in the simulated machine: planted waves shrink and grow from turn to turn as forecast.

use super::{ideal, machine, setpoint};
use camwright::job::speed_variation::SpeedVariation;
use camwright::machine::description::{
    Axis, ContactDescription, ContactMode, DriveSettings, MachineDescription, StiffnessAt, Structure,
};
use camwright::machine::setpoint::Setpoint;
use camwright::math::units::TURN_RAD;
use camwright::motion::path_stop::{rate_step, rate_step_slope};
use camwright::planner::chatter::{ContactCompliance, RegenerativeCut};
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;

const WIDTH_MM: f64 = 20.0;
/// Table at the first station.
const Z_MM: f64 = 60.0;
/// Time of a turn (s).
const TURN_S: f64 = 0.4;
/// Infeed of a turn (mm).
const FEED_MM: f64 = 0.004;
/// Amplitude of the planted waves (mm).
const PLANTED_MM: f64 = 0.000_1;

/// The reference machine with ideal drives, and this contact.
fn grinder(machine_n_mm: f64, grinding_n_mm: f64, modes: Vec<ContactMode>) -> MachineDescription {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: Z_MM, n_mm: machine_n_mm }],
        grinding_n_mm2: grinding_n_mm / WIDTH_MM,
        threshold_n_mm: 0.0,
        part_share: 0.5,
        modes,
    };
    MachineDescription { contact: Some(contact), ..ideal() }
}

/// The same with a drive of X whose structure swings.
fn on_a_drive(machine_n_mm: f64, grinding_n_mm: f64, structure_hz: f64) -> MachineDescription {
    let mut description = grinder(machine_n_mm, grinding_n_mm, Vec::new());
    let x = &mut description.axes[Axis::X.index()];
    x.inertia = 250.0;
    x.drive = DriveSettings {
        kv_1_s: 200.0,
        velocity_feed_forward: 0.99,
        acceleration_feed_forward: 0.97,
        velocity_loop_rad_s: Some(120.0 * TURN_RAD),
        velocity_integral_s: Some(0.01),
        structure: Some(Structure { frequency_rad_s: structure_hz * TURN_RAD, damping: 0.02, mass_share: 0.3 }),
        ..DriveSettings::IDEAL
    };
    description
}

fn forecast(description: &MachineDescription) -> RegenerativeCut {
    let contact = description.contact.as_ref().expect("a contact");
    RegenerativeCut {
        compliance: ContactCompliance::from_machine(description, Z_MM).expect("a contact"),
        grinding_n_mm: contact.grinding_n_mm2 * WIDTH_MM,
        turn_s: TURN_S,
        wheel: None,
    }
}

/// C turns at a mean speed, times a factor over the turns; X is fed by the same amount every turn.
fn setpoints(description: &MachineDescription, turns: f64, speed: &dyn Fn(f64) -> (f64, f64)) -> Vec<Setpoint> {
    const RAMP_S: f64 = 0.4;
    let mean = TURN_RAD / TURN_S;
    let (step_s, sub) = (description.cycle_time_s(), 50);
    let mut c = 0.0_f64;
    let mut setpoints = Vec::new();
    let mut time_s = 0.0;
    while c < turns * TURN_RAD {
        let share = |time_s: f64| {
            let u = (time_s / RAMP_S).min(1.0);
            (u * u * (3.0 - 2.0 * u), if u < 1.0 { 6.0 * u * (1.0 - u) / RAMP_S } else { 0.0 })
        };
        let ((ramp, rising), (factor, changes)) = (share(time_s), speed(c / TURN_RAD));
        let c1 = mean * ramp * factor;
        let c2 = mean * (rising * factor + ramp * changes * c1 / TURN_RAD);
        let slope = -FEED_MM / TURN_RAD;
        let x = 20.0 + PLANTED_MM + FEED_MM + slope * c;
        setpoints.push(setpoint(description, [c, x, Z_MM], [c1, slope * c1, 0.0], [c2, slope * c2, 0.0]));
        for k in 0..sub {
            let at = time_s + step_s * (f64::from(k) + 0.5) / f64::from(sub);
            c += mean * share(at).0 * speed(c / TURN_RAD).0 * step_s / f64::from(sub);
        }
        time_s += step_s;
    }
    setpoints
}

/// Amplitude of a number of waves per turn, a multiple of 4, through a window that the step of the infeed and the edge of the wheel lie outside of (mm).
fn amplitude_mm(radii: &[f64], waves: f64) -> f64 {
    let range = 450..3150;
    let count = range.len() as f64;
    let mut sums = [0.0; 3];
    for (k, i) in range.enumerate() {
        let window = 1.0 - (TURN_RAD * (k as f64 + 0.5) / count).cos();
        let (sin, cos) = (waves * TURN_RAD * i as f64 / DEFAULT_AZIMUTHS as f64).sin_cos();
        let radius = radii[i] - 20.0;
        sums = [sums[0] + window * radius * cos, sums[1] + window * radius * sin, sums[2] + window];
    }
    2.0 * sums[0].hypot(sums[1]) / sums[2]
}

/// Amplitude of the waves after each turn (mm).
fn ground(description: &MachineDescription, waves: u32, turns: f64, speed: &dyn Fn(f64) -> (f64, f64)) -> Vec<f64> {
    description.validate().expect("a possible machine");
    let radius =
        |i: usize| 20.0 + PLANTED_MM * (f64::from(waves) * TURN_RAD * i as f64 / DEFAULT_AZIMUTHS as f64).cos();
    let mut machine = machine(description);
    machine.load_lobe("I1", "LS1", WIDTH_MM, (0..DEFAULT_AZIMUTHS).map(radius).collect()).expect("a raw part");
    let setpoints = setpoints(description, turns, speed);
    machine.place(setpoints[0].counts);
    let per_turn = description.axis(Axis::C).scale.counts(TURN_RAD);
    let mut amplitudes = Vec::new();
    for pair in setpoints.windows(2) {
        machine.step(Some(&pair[1]), &[], &[]);
        if pair[1].counts[0] / per_turn > pair[0].counts[0] / per_turn {
            let radii = machine.part().lobe("I1").expect("it is there").radii_mm();
            amplitudes.push(amplitude_mm(radii, f64::from(waves)));
        }
    }
    assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
    amplitudes
}

fn constant(_: f64) -> (f64, f64) {
    (1.0, 0.0)
}

/// Mean factor of the amplitude per turn between two turns.
fn per_turn(amplitudes: &[f64], from: usize, to: usize) -> f64 {
    (amplitudes[to] / amplitudes[from]).powf(1.0 / (to - from) as f64)
}

/// Ideal drives and no modes: the contact is quasi-static, and every wave shrinks by kg/(kg + km), whatever its length.
#[test]
fn planted_waves_shrink_by_the_contact_law() {
    for (waves, machine_n_mm, grinding_n_mm) in [(12, 10e3, 40e3), (36, 10e3, 40e3), (60, 30e3, 30e3)] {
        let description = grinder(machine_n_mm, grinding_n_mm, Vec::new());
        let amplitudes = ground(&description, waves, 9.3, &constant);
        let wanted = grinding_n_mm / (grinding_n_mm + machine_n_mm);
        let found = per_turn(&amplitudes, 3, 7);
        let planted = forecast(&description).planted_wave_per_turn(f64::from(waves), TURN_RAD / TURN_S);
        assert!((planted - wanted).abs() < 1e-12);
        assert!((found / wanted - 1.0).abs() < 0.02, "{waves} waves: {found}, {wanted}: {amplitudes:?}");
    }
}

/// A turn multiplies waves of these numbers as forecast, within a tolerance, in the mean between two turns.
fn assert_as_forecast(description: &MachineDescription, cases: &[u32], turns: (usize, usize), tolerance: f64) {
    let cut = forecast(description);
    for waves in cases {
        let amplitudes = ground(description, *waves, 0.3 + (turns.1 + 1) as f64, &constant);
        let wanted = cut.planted_wave_per_turn(f64::from(*waves), TURN_RAD / TURN_S);
        let found = per_turn(&amplitudes, turns.0, turns.1);
        assert!((found / wanted - 1.0).abs() < tolerance, "{waves} waves: {found}, {wanted}: {amplitudes:?}");
    }
}

/// On a drive whose structure swings, waves of every frequency shrink as forecast from the machine file.
#[test]
fn planted_waves_on_a_drive_shrink_as_forecast() {
    let description = on_a_drive(40e3, 60e3, 150.0);
    assert!(!forecast(&description).dominant().expect("it vibrates").is_growing());
    assert_as_forecast(&description, &[40, 52, 60, 68], (1, 4), 0.01);
}

/// A soft structure in front of a stiff contact: waves near its frequency grow until the wheel leaves the part, others shrink.
#[test]
fn waves_grow_on_a_drive_that_chatters() {
    let description = on_a_drive(60e3, 40e3, 80.0);
    let cut = forecast(&description);
    let worst = cut.dominant().expect("it vibrates");
    assert!(worst.is_growing() && (worst.frequency_hz - 80.0).abs() < 5.0, "{worst:?}");
    let amplitudes = ground(&description, 32, 6.3, &constant);
    let largest = amplitudes.iter().copied().fold(0.0, f64::max);
    assert!(largest > 5.0 * PLANTED_MM && largest < FEED_MM, "{amplitudes:?}");
    assert_as_forecast(&description, &[44], (0, 3), 0.02);
}

/// A mode of 160 Hz that carries most of the compliance.
fn on_a_mode(grinding_n_mm: f64) -> MachineDescription {
    let mode = ContactMode { frequency_rad_s: 160.0 * TURN_RAD, damping: 0.08, compliance_share: 0.9 };
    grinder(30e3, grinding_n_mm, vec![mode])
}

/// With a mode of a tap test in the machine file waves shrink in a cut below the limit of the forecast.
#[test]
fn planted_waves_on_a_mode_shrink_below_the_limit() {
    let limit_n_mm = forecast(&on_a_mode(1e3)).unconditional_n_mm().expect("a mode chatters");
    let description = on_a_mode(0.8 * limit_n_mm);
    assert!(!forecast(&description).dominant().expect("it vibrates").is_growing());
    assert_as_forecast(&description, &[60, 64, 68, 72], (0, 2), 0.01);
}

/// In a cut beyond the limit they grow as forecast, and a variation of the work speed makes them shrink again.
#[test]
fn planted_waves_on_a_mode_grow_beyond_the_limit_and_a_varying_speed_stops_them() {
    let limit_n_mm = forecast(&on_a_mode(1e3)).unconditional_n_mm().expect("a mode chatters");
    let description = on_a_mode(1.6 * limit_n_mm);
    let cut = forecast(&description);
    let worst = cut.dominant().expect("it vibrates");
    assert!(worst.is_growing(), "{worst:?}");
    let nearest = (1..200).find(|waves| (f64::from(*waves) - worst.waves_per_turn).abs() <= 0.5);
    let waves = nearest.expect("fewer than 200");
    assert_as_forecast(&description, &[waves], (0, 3), 0.01);
    let variation = SpeedVariation { slower: 0.25, period_turns: 2.5 };
    let (forecast, _) = cut.varied_growth(&variation);
    assert!(forecast < 1.0, "{forecast}");
    let speed = |turns: f64| {
        const CHANGE_TURNS: f64 = 0.15;
        let since = turns.rem_euclid(0.5 * variation.period_turns) / CHANGE_TURNS;
        let (begins, ends) =
            if variation.is_slow(turns) { (1.0, variation.slow_rate()) } else { (variation.slow_rate(), 1.0) };
        match turns < 0.5 * variation.period_turns || since >= 1.0 {
            true => (if variation.is_slow(turns) { ends } else { 1.0 }, 0.0),
            false => {
                (begins + (ends - begins) * rate_step(since), (ends - begins) * rate_step_slope(since) / CHANGE_TURNS)
            }
        }
    };
    let (steady, varied) = (ground(&description, waves, 14.3, &constant), ground(&description, waves, 14.3, &speed));
    assert!(steady[13] > steady[3], "{steady:?}");
    assert!(varied[13] < 0.5 * PLANTED_MM && varied[13] < 0.2 * steady[13], "{varied:?}");
}
