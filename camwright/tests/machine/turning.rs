// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A lathe as it runs: setpoints of an eccentric in, what the insert leaves of a bar out.

use camwright::cam::surface::SurfacePoint;
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, DriveSettings, MachineDescription, Structure};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::{cam_grinder, lathe};
use camwright::machine::setpoint::Setpoint;
use camwright::simulation::fault::Fault;
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::turned_part::{FormMap, PartGrid, TurnedPart, TurnedPartError};
use camwright::simulation::{Machine, MachineCommand};
use std::f64::consts::TAU;

const RADIUS: f64 = 20.0;
const OFF: f64 = 1.5;
const FEED: f64 = 0.2;
const ZERO: f64 = 7.0;
const LENGTH: f64 = 3.0;

fn at(description: &MachineDescription, height_mm: f64) -> MachineDescription {
    description.clone().with_rake_height(height_mm).expect("within its range")
}

fn bar(radius_mm: f64) -> TurnedPart {
    let grid = PartGrid { azimuths: 720, columns: 301, from_mm: 0.0, to_mm: LENGTH };
    TurnedPart::round("bar".into(), grid, radius_mm).expect("a bar")
}

/// A disc whose centre lies off the axis, as a radius over azimuth.
fn disc(azimuth: f64, _z: f64) -> SurfacePoint {
    let (sin, cos) = azimuth.sin_cos();
    let along = (RADIUS * RADIUS - OFF * OFF * sin * sin).sqrt();
    SurfacePoint {
        radius_mm: OFF * cos + along,
        by_azimuth: -OFF * sin - OFF * OFF * sin * cos / along,
        ..SurfacePoint::default()
    }
}

/// X of the insert's centre on the disc in the rake plane at the height H, and its first two derivatives by θ: with the disc's centre at
/// e (cos θ, −sin θ), X = e cos θ + √(r² − (H + e sin θ)²) + R.
fn path(theta: f64, height: f64, insert: f64) -> (f64, f64, f64) {
    let (sin, cos) = theta.sin_cos();
    let above = height + OFF * sin;
    let along = (RADIUS * RADIUS - above * above).sqrt();
    let first = -above * OFF * cos / along;
    let second = (-OFF * OFF * cos * cos + above * OFF * sin - first * first) / along;
    (OFF * cos + along + insert, -OFF * sin + first, -OFF * cos + second)
}

/// Setpoints of a spiral: C to so many rpm in a second and on, X and Z as C turns. The insert comes from beside the bar.
fn spiral(description: &MachineDescription, rpm: f64) -> Vec<Setpoint> {
    let insert = description.insert.expect("a lathe");
    let (speed, sense) = (rpm / 60.0 * TAU, f64::from(description.rotation_sense));
    let begin = -insert.radius_mm - 0.5;
    let turns = (LENGTH + 2.0 * insert.radius_mm + 1.0) / FEED;
    #[allow(clippy::cast_possible_truncation, reason = "some ten thousands")]
    let ticks = 1000 + (turns * 60.0 / rpm * 1000.0) as u32;
    let setpoints = (0..=ticks).map(|k| {
        let t = f64::from(k) * 1e-3;
        // Speed over a second as 3u² − 2u³.
        let (c, v, a) = if t < 1.0 {
            (speed * (t.powi(3) - 0.5 * t.powi(4)), speed * (3.0 * t * t - 2.0 * t.powi(3)), speed * 6.0 * (t - t * t))
        } else {
            (speed * (t - 0.5), speed, 0.0)
        };
        let (x, first, second) = path(sense * c, insert.height_mm, insert.radius_mm);
        let z = begin - ZERO + FEED * c / TAU;
        let position = [c, x, z];
        Setpoint {
            counts: std::array::from_fn(|i| description.axes[i].scale.counts(position[i])),
            velocity: [v, sense * first * v, FEED * v / TAU],
            acceleration: [a, sense * first * a + second * v * v, FEED * a / TAU],
        }
    });
    setpoints.collect()
}

fn machine(description: &MachineDescription, raw_mm: f64) -> Machine {
    let mut machine = Machine::new(description.clone(), PersistentState::new(description)).expect("valid");
    machine.load_turned_part(bar(raw_mm), ZERO).expect("a lathe");
    machine
}

/// Turns the bar; returns the machine afterwards, and the reports of all ticks.
fn turned(description: &MachineDescription, rpm: f64) -> (Machine, Vec<TickReport>) {
    let setpoints = spiral(description, rpm);
    let mut machine = machine(description, RADIUS + OFF + 0.3);
    machine.place(setpoints[0].counts);
    let reports = setpoints[1..].iter().map(|setpoint| machine.step(Some(setpoint), &[], &[])).collect();
    (machine, reports)
}

fn form(machine: &Machine) -> FormMap {
    FormMap::new(machine.turned_part().expect("it was loaded"), disc, 0.0, LENGTH).expect("a map")
}

/// Half a count of X is 5 nm, of C 0.02 µm along the arc on a slope of at most 0.08; the Hermite between two ticks is X'''' T⁴/384.
#[test]
fn ideal_drives_leave_the_cusps_of_the_feed_and_nothing_else() {
    for (height, sense) in [(0.0, 1), (-14.0, 1), (-14.0, -1)] {
        let ideal =
            at(&MachineDescription { rotation_sense: sense, ..lathe() }.with_drives(DriveSettings::IDEAL), height);
        let (machine, reports) = turned(&ideal, 120.0);
        assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
        let map = form(&machine);
        let cusp = FEED * FEED / (8.0 * ideal.insert.expect("a lathe").radius_mm);
        let (high, low) = (map.highest(), map.lowest());
        assert!(low.deviation_mm > -1e-4, "H {height}: {low:?}");
        assert!(high.deviation_mm < cusp + 1e-4, "H {height}: {high:?} over {cusp}");
        let cusps = map.cusps(FEED).expect("20 columns in a feed");
        // The rake plane cuts the surface at an angle: along the normal the cusp is lower by its cosine.
        let along_normal = cusp * (1.0 - (height / RADIUS).powi(2)).sqrt();
        assert!((cusps.mean_mm - along_normal).abs() < 0.1 * along_normal, "{cusps:?} {along_normal}");
        let part = machine.turned_part().expect("it was loaded");
        let gone: f64 = reports.iter().map(|report| report.turned.volume_mm3).sum();
        let per_width: f64 = reports.iter().map(|report| report.removal.area_mm2).sum();
        let volume = bar(RADIUS + OFF + 0.3).volume_mm3() - part.volume_mm3();
        assert!((gone - volume).abs() < 1e-6 * volume && (per_width * 16.0 - volume).abs() < 1e-6 * volume);
        let deepest = reports.iter().map(|report| report.removal.depth_mm).fold(0.0, f64::max);
        // 3.3 mm over the nose the edge of radius 8 rises by 1.4 of the feed (below the axis by somewhat more); there the bar is met first.
        assert!(deepest > FEED && deepest < 2.0 * FEED, "{deepest}");
        assert!(reports.iter().any(|report| report.turned.deepest.is_some_and(|(_, z)| z > 1.0)));
        assert!(reports.iter().all(|report| report.lobe.is_none() && report.io.part_present));
    }
}

/// A slide whose structure swings at f hangs back by its acceleration over (2πf)²: e ω² over it, 0.4 µm at 150 rpm and 1.7 µm at 300 with
/// 150 Hz. The loops lag by X'' ω² (1 − ff)/Kv² in addition, some hundredths.
#[test]
fn ordinary_drives_leave_more_the_faster_the_part_turns() {
    let mut description = at(&lathe(), 0.0);
    let structure = Structure { frequency_rad_s: 150.0 * TAU, damping: 0.04, mass_share: 0.2 };
    description.axes[1].drive.structure = Some(structure);
    let errors = [150.0, 300.0].map(|rpm| {
        let (machine, _) = turned(&description, rpm);
        assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
        let map = form(&machine);
        let cusp = FEED * FEED / (8.0 * 8.0);
        let error_mm = (map.highest().deviation_mm - cusp).max(-map.lowest().deviation_mm);
        let expected_mm = OFF * (rpm / 60.0 * TAU / structure.frequency_rad_s).powi(2);
        assert!((error_mm - expected_mm).abs() < 0.35 * expected_mm, "{rpm} rpm: {error_mm} {expected_mm}");
        error_mm
    });
    assert!(errors[1] > 3.0 * errors[0], "{errors:?}");
}

#[test]
fn an_insert_that_loses_its_speed_in_the_cut_stops_the_lathe_off_the_part() {
    let description = at(&lathe().with_drives(DriveSettings::IDEAL), 0.0);
    let setpoints = spiral(&description, 120.0);
    let mut machine = machine(&description, RADIUS + OFF + 0.3);
    machine.place(setpoints[0].counts);
    let mut raised = Vec::new();
    for (k, setpoint) in setpoints[1..].iter().enumerate() {
        let stall = [Fault::WheelStall(true)];
        let report = machine.step(Some(setpoint), &[], if k == 24_000 { &stall } else { &[] });
        raised.extend(report.raised.iter().map(|alarm| alarm.kind));
        if !raised.is_empty() {
            break;
        }
    }
    assert_eq!(raised, [AlarmKind::WheelStoppedInCut]);
    let before = machine.turned_part().expect("loaded").volume_mm3();
    for _ in 0..20_000 {
        machine.step(None, &[], &[]);
    }
    assert!(machine.is_at_rest());
    let x_mm = machine.truth()[Axis::X.index()].0;
    assert!(x_mm > RADIUS + OFF + 0.3 + 8.0 + 1.9, "{x_mm}");
    assert!(machine.turned_part().expect("loaded").volume_mm3() < before, "on its way to rest it still had speed");
}

#[test]
fn an_insert_that_does_not_turn_must_not_touch_the_part() {
    for height in [0.0, -14.0] {
        let description = at(&lathe().with_drives(DriveSettings::IDEAL), height);
        let mut machine = machine(&description, RADIUS);
        let x_mm = (RADIUS * RADIUS - height * height).sqrt() + 8.0;
        let x = description.axes[1].scale;
        machine.place([0, x.counts(x_mm + 0.002), description.axes[2].scale.counts(1.0 - ZERO)]);
        for _ in 0..2000 {
            machine.step(None, &[MachineCommand::WheelStop], &[]);
        }
        assert!(machine.alarms().is_empty());
        let mut raised = Vec::new();
        for k in 1..=200 {
            let mut setpoint = machine.setpoint();
            (setpoint.counts[1], setpoint.velocity[1]) = (x.counts(x_mm + 0.002 - 2e-5 * f64::from(k)), -0.02);
            raised.extend(machine.step(Some(&setpoint), &[], &[]).raised.iter().map(|alarm| alarm.kind));
            if !raised.is_empty() {
                break;
            }
        }
        assert_eq!(raised, [AlarmKind::WheelContact], "H {height}");
        let part = machine.turned_part().expect("loaded");
        assert!((part.minimum_mm() - RADIUS).abs() < 1e-12, "it cuts nothing");
    }
}

#[test]
fn only_a_lathe_takes_a_part_to_turn() {
    let description = cam_grinder();
    let mut grinder = Machine::new(description.clone(), PersistentState::new(&description)).expect("valid");
    assert!(matches!(grinder.load_turned_part(bar(20.0), 0.0), Err(TurnedPartError::NotALathe { .. })));
    let mut lathe = machine(&lathe(), 20.0);
    assert!(matches!(lathe.load_turned_part(bar(20.0), f64::NAN), Err(TurnedPartError::Zero { .. })));
    lathe.clear_part();
    assert!(lathe.turned_part().is_none() && !lathe.step(None, &[], &[]).io.part_present);
}
