// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::job::speed_variation::SpeedVariation;
use crate::machine::description::{
    Axis, ContactDescription, ContactMode, DriveSettings, MachineDescription, StiffnessAt, Structure,
};
use crate::machine::reference::cam_grinder;
use crate::math::complex::Complex;
use crate::math::noise::Noise;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// The reference grinder with a drive that has loops and a structure, and a contact.
fn grinder() -> MachineDescription {
    let mut machine = cam_grinder();
    let x = machine.axes.iter_mut().find(|axis| axis.axis == Axis::X).unwrap();
    x.drive = DriveSettings {
        kv_1_s: 200.0,
        velocity_loop_rad_s: Some(TURN_RAD * 120.0),
        velocity_integral_s: Some(0.01),
        structure: Some(Structure { frequency_rad_s: TURN_RAD * 150.0, damping: 0.04, mass_share: 0.2 }),
        ..DriveSettings::IDEAL
    };
    machine.contact = Some(ContactDescription {
        stiffness: alloc::vec![StiffnessAt { z_mm: 0.0, n_mm: 40e3 }],
        grinding_n_mm2: 1.5e3,
        threshold_n_mm: 0.8,
        part_share: 0.5,
        modes: Vec::new(),
    });
    machine
}

fn single(stiffness_n_mm: f64, damping: f64, frequency_hz: f64) -> ContactCompliance {
    ContactCompliance::single_mode(VibrationMode { frequency_rad_s: TURN_RAD * frequency_hz, damping, stiffness_n_mm })
}

/// Time-domain simulation of a cut with delay, by itself: modes with Runge and Kutta's method, a surface of `PER_TURN` points. Returns
/// the growth of the surface per turn.
fn simulated_growth(
    cut: &RegenerativeCut,
    speed_of_turn: &dyn Fn(f64) -> f64,
    noise: &mut Noise,
    turns: (usize, usize),
) -> f64 {
    const PER_TURN: usize = 3000;
    let modes: Vec<(f64, f64, f64)> =
        cut.compliance.modes.iter().map(|m| (m.frequency_rad_s, m.damping, m.stiffness_n_mm)).collect();
    let mut surface: Vec<f64> = (0..PER_TURN).map(|_| 1e-3 * noise.normal()).collect();
    // Smooth it: waves shorter than a few points are none.
    for _ in 0..4 {
        surface = (0..PER_TURN).map(|i| (0..12).map(|k| surface[(i + k) % PER_TURN]).sum::<f64>() / 12.0).collect();
    }
    let mut state: Vec<(f64, f64)> = alloc::vec![(0.0, 0.0); modes.len()];
    let soft = 1.0 / cut.grinding_n_mm + cut.compliance.spring_mm_n;
    let force = |surface: f64, state: &[(f64, f64)]| (surface - state.iter().map(|s| s.0).sum::<f64>()) / soft;
    let slope = |surface: f64, state: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let force = force(surface, state);
        let one =
            |((w, z, k), (q, p)): (&(f64, f64, f64), &(f64, f64))| (*p, w * w * (force / k - q) - 2.0 * z * w * p);
        modes.iter().zip(state).map(one).collect()
    };
    let moved = |state: &[(f64, f64)], by: &[(f64, f64)], h: f64| -> Vec<(f64, f64)> {
        state.iter().zip(by).map(|(s, d)| (s.0 + h * d.0, s.1 + h * d.1)).collect()
    };
    let mut sizes = Vec::new();
    for turn in 0..turns.1 {
        // Points that the wheel passes next turn, as they are before their cut.
        let before = surface.clone();
        let mut sum = 0.0;
        for i in 0..PER_TURN {
            let at = turn as f64 + i as f64 / PER_TURN as f64;
            let h = cut.turn_s / (speed_of_turn(at) * PER_TURN as f64);
            let here = before[i];
            let next = if i + 1 < PER_TURN { before[i + 1] } else { surface[0] };
            let middle = 0.5 * (here + next);
            let depth = force(here, &state) / cut.grinding_n_mm;
            surface[i] = here - depth;
            let a = slope(here, &state);
            let b = slope(middle, &moved(&state, &a, 0.5 * h));
            let c = slope(middle, &moved(&state, &b, 0.5 * h));
            let d = slope(next, &moved(&state, &c, h));
            for (index, s) in state.iter_mut().enumerate() {
                s.0 += h / 6.0 * (a[index].0 + 2.0 * b[index].0 + 2.0 * c[index].0 + d[index].0);
                s.1 += h / 6.0 * (a[index].1 + 2.0 * b[index].1 + 2.0 * c[index].1 + d[index].1);
            }
            sum += depth * depth;
        }
        sizes.push(sum.sqrt());
    }
    (sizes[turns.1 - 1] / sizes[turns.0]).powf(1.0 / (turns.1 - 1 - turns.0) as f64)
}

fn constant(_: f64) -> f64 {
    1.0
}

/// 2 k ζ (1 + ζ), the closed form of a single mode.
#[test]
fn a_single_mode_allows_twice_its_stiffness_times_its_damping() {
    for (stiffness, damping) in [(20e3, 0.02), (50e3, 0.05), (8e3, 0.15)] {
        let cut = RegenerativeCut {
            compliance: single(stiffness, damping, 180.0),
            grinding_n_mm: 1.0,
            turn_s: 0.7,
            wheel: None,
        };
        let limit = cut.unconditional_n_mm().unwrap();
        let wanted = 2.0 * stiffness * damping * (1.0 + damping);
        assert!((limit / wanted - 1.0).abs() < 1e-6, "{limit} {wanted}");
        let (_, rad_s) = cut.compliance.most_negative().unwrap();
        assert!((rad_s / (TURN_RAD * 180.0) / (1.0 + 2.0 * damping).sqrt() - 1.0).abs() < 1e-3);
    }
}

/// The lowest point of a lobe has the phase 3π/2 + ζ-ish beyond whole waves, and just inside of the boundary a wave decays, just outside
/// it grows, at every work speed.
#[test]
fn the_lobes_separate_growth_from_decay() {
    let mut noise = Noise::new(4);
    for case in 0..20 {
        let compliance = single(20e3, 0.02 + 0.06 * noise.uniform(), 60.0 + 100.0 * noise.uniform());
        let speed_rad_s = TURN_RAD * (0.5 + 12.0 * noise.uniform());
        let lobes = StabilityLobes::new(&compliance, [speed_rad_s]);
        let boundary = lobes.points[0];
        let growth = |factor: f64| {
            let cut = RegenerativeCut {
                compliance: compliance.clone(),
                grinding_n_mm: factor * boundary.grinding_n_mm,
                turn_s: TURN_RAD / speed_rad_s,
                wheel: None,
            };
            assert!(boundary.grinding_n_mm >= cut.unconditional_n_mm().unwrap() * (1.0 - 1e-4));
            cut.dominant().unwrap()
        };
        let (inside, outside) = (growth(0.97), growth(1.03));
        assert!(!inside.is_growing() && outside.is_growing(), "{case}: {inside:?} {outside:?} {boundary:?}");
        let at = growth(1.0);
        assert!((at.per_turn - 1.0).abs() < 2e-3, "{case}: {at:?}");
        assert!((at.frequency_hz / boundary.frequency_hz - 1.0).abs() < 2e-3, "{case}: {at:?} {boundary:?}");
    }
}

/// An own simulation of the delayed cut grows and decays as forecast.
#[test]
fn growth_agrees_with_a_simulation_in_time() {
    let mut noise = Noise::new(11);
    let (mut growing, mut decaying) = (0, 0);
    for case in 0..24 {
        let mode = |noise: &mut Noise| VibrationMode {
            frequency_rad_s: TURN_RAD * (40.0 + 120.0 * noise.uniform()),
            damping: 0.02 + 0.08 * noise.uniform(),
            stiffness_n_mm: 10e3 + 40e3 * noise.uniform(),
        };
        let mut modes = alloc::vec![mode(&mut noise)];
        if case % 3 == 0 {
            modes.push(mode(&mut noise));
        }
        let spring_mm_n = if case % 2 == 0 { 0.0 } else { 2e-5 * noise.uniform() };
        let compliance = ContactCompliance { spring_mm_n, modes, drive: None };
        let mut cut =
            RegenerativeCut { compliance, grinding_n_mm: 1.0, turn_s: 0.15 + 0.25 * noise.uniform(), wheel: None };
        // Pure springs may have no limit.
        let limit = cut.unconditional_n_mm().unwrap_or(20e3).min(60e3);
        let factor = if case % 4 < 2 { 0.3 + 0.6 * noise.uniform() } else { 1.1 + 2.0 * noise.uniform() };
        cut.grinding_n_mm = limit * factor;
        let forecast = cut.dominant().unwrap();
        let simulated = simulated_growth(&cut, &constant, &mut noise, (50, 90));
        let difference = (simulated / forecast.per_turn - 1.0).abs();
        assert!(difference < 0.01, "{case}: {simulated} {forecast:?} {cut:?}");
        match forecast.is_growing() {
            true => growing += 1,
            false => decaying += 1,
        }
        if (forecast.per_turn - 1.0).abs() > 0.01 {
            assert_eq!(forecast.is_growing(), simulated > 1.0, "{case}");
        }
    }
    assert!(growing >= 5 && decaying >= 5, "{growing} {decaying}");
}

/// A spring alone is the contact law: every wave of every speed decays by kg/(kg + km).
#[test]
fn on_a_spring_the_forecast_is_the_contact_law() {
    let cut = RegenerativeCut {
        compliance: ContactCompliance { spring_mm_n: 1.0 / 10e3, modes: Vec::new(), drive: None },
        grinding_n_mm: 50e3,
        turn_s: 1.0,
        wheel: None,
    };
    let wave = cut.part_waves()[0];
    assert!((wave.per_turn - 1.0 / 1.2).abs() < 1e-9 && (wave.waves_per_turn - 1.0).abs() < 1e-9, "{wave:?}");
    assert_eq!(cut.unconditional_n_mm(), None);
}

/// A worn wheel: on a structure that chatters with the part at no speed its waves decay, beyond that they grow, slowly.
#[test]
fn waves_of_the_wheel_grow_slowly_beyond_the_unconditional_limit() {
    let compliance = single(20e3, 0.04, 150.0);
    let cut = |factor: f64| {
        let part = RegenerativeCut { compliance: compliance.clone(), grinding_n_mm: 1.0, turn_s: 1.0, wheel: None };
        let grinding_n_mm = factor * part.unconditional_n_mm().unwrap();
        let wheel = WheelRegeneration::new(grinding_n_mm, 200.0, 100.0, (80e3, 2.0 / 155.9));
        RegenerativeCut { grinding_n_mm, wheel: Some(wheel), ..part }
    };
    // ks = kg · 200 · 800.
    assert!((cut(1.0).wheel.unwrap().stiffness_n_mm / cut(1.0).grinding_n_mm - 160e3).abs() < 1e-6);
    let (calm, chatters) = (cut(0.8).dominant_of_wheel().unwrap(), cut(3.0).dominant_of_wheel().unwrap());
    assert!(calm.per_turn < 1.0 && calm.per_turn > 0.999, "{calm:?}");
    assert!(chatters.per_turn > 1.0 && chatters.per_turn < 1.001, "{chatters:?}");
    // Without wear of the wheel its waves are none, and the part's are nearly the same.
    let without = RegenerativeCut { wheel: None, ..cut(3.0) };
    assert_eq!(without.dominant_of_wheel(), None);
    let (with, without) = (cut(3.0).dominant().unwrap(), without.dominant().unwrap());
    assert!((with.per_turn / without.per_turn - 1.0).abs() < 1e-2, "{with:?} {without:?}");
}

/// A simulation whose speed varies agrees with the mean growth, and a variation that repeats every turn does nothing.
#[test]
fn a_varying_speed_averages_the_growth() {
    let compliance = single(20e3, 0.03, 150.0);
    let mut cut = RegenerativeCut { compliance, grinding_n_mm: 1.0, turn_s: 0.4, wheel: None };
    cut.grinding_n_mm = 1.6 * cut.unconditional_n_mm().unwrap();
    let constant_speed = cut.dominant().unwrap().per_turn;
    assert!(constant_speed > 1.1, "{constant_speed}");
    let simulated = |speed: &dyn Fn(f64) -> f64| simulated_growth(&cut, speed, &mut Noise::new(3), (90, 178));
    let cases = [(0.2, 1.5, 0.06), (0.3, 2.0, 0.01), (0.5, 2.0, 0.02), (0.2, 2.5, 0.03), (0.2, 3.0, 0.12)];
    for (slower, period_turns, tolerance) in cases {
        let variation = SpeedVariation { slower, period_turns };
        let (forecast, _) = cut.varied_growth(&variation);
        let simulated = simulated(&|turn| if variation.is_slow(turn) { variation.slow_rate() } else { 1.0 });
        assert!((simulated / forecast - 1.0).abs() < tolerance, "{slower} {period_turns}: {simulated} {forecast}");
        assert!(simulated < 0.7 && forecast < 0.7, "{slower} {period_turns}: {simulated} {forecast} {constant_speed}");
    }
    // The same speed at every place in every turn: a constant delay, that of the time of a turn.
    let simulated = simulated(&|turn| 1.0 + 0.2 * (TURN_RAD * turn).sin());
    let of_turn = cut.at_turn(cut.turn_s / (1.0_f64 - 0.04).sqrt()).dominant().unwrap().per_turn;
    assert!((simulated / of_turn - 1.0).abs() < 0.01, "{simulated} {of_turn}");
}

/// The drive of the reference grinder: softer than its own mass alone below the loop, and its structure swings in front of the slide.
#[test]
fn the_drive_yields_to_a_force_as_its_loops_let_it() {
    let machine = grinder();
    let contact = ContactCompliance::from_machine(&machine, machine.stations[0].position_mm).unwrap();
    assert!(contact.spring_mm_n > 0.0);
    // A steady force does not move a drive with an integral.
    let Some(drive) = contact.drive else { panic!("a drive with loops") };
    let still = crate::math::complex::magnitude(drive.at(Complex::new(0.0, 0.05)));
    let moving = crate::math::complex::magnitude(drive.at(Complex::new(0.0, 300.0)));
    assert!(still < 0.01 * moving, "{still} {moving}");
}

/// Mode and spring share the static stiffness.
#[test]
fn modes_of_the_machine_file_are_shares_of_its_compliance() {
    let mut machine = grinder();
    let z_mm = machine.stations[0].position_mm;
    let contact = machine.contact.as_mut().unwrap();
    contact.modes = alloc::vec![ContactMode { frequency_rad_s: 2000.0, damping: 0.03, compliance_share: 0.4 }];
    let n_mm = contact.machine_n_mm(z_mm);
    let mut compliance = ContactCompliance::from_machine(&machine, z_mm).unwrap();
    compliance.drive = None;
    let at_rest = compliance.at(Complex::new(0.0, 1e-6));
    assert!((at_rest.re * n_mm - 1.0).abs() < 1e-9, "{at_rest} {n_mm}");
}
