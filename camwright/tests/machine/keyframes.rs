// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Keyframes: a machine that is taken up from one goes on as if nothing had been, and no octets can make it fail.
#![allow(clippy::print_stdout, reason = "seeds and sizes are printed")]

use super::turned::{self, Eccentric};
use super::{ideal, machine};
use camwright::machine::description::{
    Axis, ContactDescription, ContactMode, GapDetector, GaugeDescription, GaugeKind, GrindingProcess, KeyWayProbe,
    LoadingDescription, MachineDescription, MagazineWheel, ReferenceCut, SteadyRest, StiffnessAt, Structure,
    ThermalDescription, WorkholdingDescription,
};
use camwright::machine::reference::lathe;
use camwright::machine::setpoint::{Input, Setpoint};
use camwright::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError, SnapshotValue};
use camwright::simulation::buffer::{Chunk, SetpointBuffer, TailPoint};
use camwright::simulation::fault::{Fault, GaugeFault, LoadingFault};
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::turned_part::{PartGrid, TurnedPart};
use camwright::simulation::{Machine, MachineCommand};

/// A machine with everything that one can have.
fn equipped() -> MachineDescription {
    let mut description = MachineDescription {
        process: Some(GrindingProcess {
            specific_energy_j_mm3: 40.0,
            rubbing_n_mm2: 0.05,
            safe_cut: ReferenceCut { footprint_speed_mm_s: 300.0, depth_mm: 0.01, equivalent_diameter_mm: 30.0 },
        }),
        contact: Some(ContactDescription {
            stiffness: vec![StiffnessAt { z_mm: 60.0, n_mm: 4e4 }, StiffnessAt { z_mm: 90.0, n_mm: 3e4 }],
            grinding_n_mm2: 1.5e3,
            threshold_n_mm: 0.8,
            part_share: 0.5,
            modes: vec![ContactMode { frequency_rad_s: 1200.0, damping: 0.05, compliance_share: 0.3 }],
        }),
        workholding: Some(WorkholdingDescription {
            headstock_n_mm: 1e5,
            chuck_tilt_n_mm_rad: None,
            tailstock_n_mm: Some(8e4),
            steady_rest: Some(SteadyRest { n_mm: 5e4, jaw_width_mm: 15.0 }),
        }),
        gauge: Some(GaugeDescription {
            kind: GaugeKind::Diameter,
            behind_wheel_rad: 4.7,
            second_behind_wheel_rad: Some(3.0),
            resolution_mm: 1e-4,
            noise_mm: 2e-4,
            bandwidth_rad_s: Some(300.0),
            seed: 1,
        }),
        thermal: Some(ThermalDescription { growth_mm: 0.02, time_constant_s: 900.0, start_share: 0.3 }),
        loading: Some(LoadingDescription {
            door_opens_s: 0.2,
            door_closes_s: 0.3,
            chuck_opens_s: 0.1,
            chuck_closes_s: 0.1,
            safe_x_mm: 100.0,
        }),
        gap_detector: Some(GapDetector { holds_s: 0.02 }),
        key_way_probe: Some(KeyWayProbe { at_rad: 1.0, width_rad: 0.1 }),
        ..ideal()
    };
    description.wheel.unbalance_mm = 1e-4;
    for axis in &mut description.axes {
        axis.drive = camwright::machine::reference::cam_grinder().axes[axis.axis.index()].drive;
        axis.drive.velocity_integral_s = Some(0.01);
        axis.drive.coulomb_friction = 1.0;
        axis.drive.structure = Some(Structure { frequency_rad_s: 900.0, damping: 0.04, mass_share: 0.2 });
        (axis.drive.encoder_step_counts, axis.drive.encoder_noise_counts) = (1.0, 0.3);
    }
    description
}

/// Events in the ticks of a run.
struct RunEvents {
    machine: Machine,
    setpoints: Vec<Setpoint>,
    commands: Vec<(u64, MachineCommand)>,
    faults: Vec<(u64, Fault)>,
    ticks: u64,
    /// The tick after which it begins.
    begun: u64,
}

/// A lobe is ground, everything that can strike it does, and after an alarm it is reset and goes on.
fn grinding() -> RunEvents {
    let description = equipped();
    let mut machine = machine(&description);
    let lobe = Eccentric { radius_mm: 22.8, offset_mm: 0.1 };
    machine.order_door(true).expect("nothing moves");
    let rest = |machine: &mut Machine, ticks: u64| (0..ticks).for_each(|_| _ = machine.step(None, &[], &[]));
    rest(&mut machine, 300);
    machine.change_part(true).expect("the chuck is open");
    machine.order_chuck(false).expect("the door is open");
    machine.order_door(false).expect("nobody is inside");
    rest(&mut machine, 400);
    for (name, station, max_mm) in [("I1", "LS1", 23.1), ("E1", "LS2", 24.0)] {
        machine.load_lobe(name, station, 15.0, vec![max_mm; 720]).expect("a round blank");
        machine.set_part_compliance(name, 4e-5).expect("the machine has supports");
    }
    let setpoints = turned::turning(&description, 60.0, 6.0, 2400, |c| lobe.path_over_c(1.0, c));
    machine.place(setpoints[0].counts);
    let commands = [
        (3, MachineCommand::WheelStart),
        (50, MachineCommand::WatchForce { max_n: 40 }),
        (400, MachineCommand::Ask { input: Input::Origin }),
        (3900, MachineCommand::LoseHome { axis: Axis::Z }),
    ];
    let faults = [
        (200, Fault::EncoderOffset { axis: Axis::Z, offset: 1e-5 }),
        (600, Fault::DriveGain { axis: Axis::X, factor: 0.95 }),
        (700, Fault::WheelOverspeed(1.01)),
        (900, Fault::SharedInput(Some([Input::KeyWay, Input::Origin]))),
        (1100, Fault::BouncingSwitch { station: 1, active: true }),
        (1300, Fault::DoubleOrigin(Some(0.5))),
        (1700, Fault::Gauge(Some(GaugeFault::Stuck))),
        (2000, Fault::PowerLoss(true)),
        (2900, Fault::PowerLoss(false)),
        (3100, Fault::Loading(LoadingFault::Person(true))),
        (3300, Fault::Loading(LoadingFault::Person(false))),
        (3400, Fault::StuckInput { input: Input::Station(0), level: Some(true) }),
    ];
    let begun = machine.tick();
    RunEvents { machine, setpoints, commands: commands.into(), faults: faults.into(), ticks: 4500, begun }
}

/// A crank pin is ground and something strikes.
fn pin_chasing() -> RunEvents {
    let sense = 1;
    let axes = super::pins::crank_grinder(sense).axes;
    let mut description = MachineDescription { loading: None, ..equipped() };
    let limits = axes.map(|axis| (axis.soft_limits, axis.overtravel));
    for (axis, (soft_limits, overtravel)) in description.axes.iter_mut().zip(limits) {
        (axis.soft_limits, axis.overtravel) = (soft_limits, overtravel);
    }
    let mut machine = super::pins::loaded(&description, 25.07);
    let setpoints = super::pins::chasing(&description, 3.0, 4000);
    machine.place(setpoints[0].counts);
    let faults = vec![(600, Fault::DriveGain { axis: Axis::X, factor: 0.95 }), (2600, Fault::EStop(true))];
    RunEvents { machine, setpoints, commands: Vec::new(), faults, ticks: 3500, begun: 0 }
}

/// Three sections of a wide lobe are ground together by a wheel that vibrates, and something strikes.
fn wide_grinding() -> RunEvents {
    let mut description = MachineDescription { loading: None, ..equipped() };
    description.wheel.width_mm = 25.0;
    let mut machine = super::sections::loaded(&description);
    let disc = Eccentric { radius_mm: 19.9, offset_mm: 0.1 };
    let setpoints = turned::turning(&description, 62.0, 6.0, 3000, |c| disc.path_over_c(1.0, c));
    machine.place(setpoints[0].counts);
    let faults = vec![(600, Fault::DriveGain { axis: Axis::X, factor: 0.95 }), (1600, Fault::EStop(true))];
    RunEvents { machine, setpoints, commands: Vec::new(), faults, ticks: 2500, begun: 0 }
}

/// Three sections of a tapered lobe are ground together by a rim with a profile on a wheel that vibrates, and something strikes.
fn taper_grinding() -> RunEvents {
    let description = super::tapered::with_rim(MachineDescription { loading: None, ..equipped() });
    let mut machine = super::tapered::loaded(&description);
    let disc = Eccentric { radius_mm: 19.9, offset_mm: 0.1 };
    let setpoints = turned::turning(&description, 61.0, 6.0, 3000, |c| disc.path_over_c(1.0, c));
    machine.place(setpoints[0].counts);
    let faults = vec![(600, Fault::DriveGain { axis: Axis::X, factor: 0.95 }), (1600, Fault::EStop(true))];
    RunEvents { machine, setpoints, commands: Vec::new(), faults, ticks: 2500, begun: 0 }
}

/// A wheel is changed, the new one grinds, and something strikes.
fn changing() -> RunEvents {
    let mut description = MachineDescription { loading: None, ..equipped() };
    description.wheel_changer = super::wheel_changer::two_wheels(0.003).wheel_changer.map(|mut changer| {
        changer.wheels[0].wheel = description.wheel;
        changer.min_x_mm = 30.0;
        changer
    });
    let mut machine = machine(&description);
    machine.load_lobe("I1", "LS1", 15.0, vec![23.1; 720]).expect("a round blank");
    machine.set_part_compliance("I1", 4e-5).expect("the machine has supports");
    // X approaches its end as the third power of the angle that is left.
    let (turns, begin_mm, end_mm) = (6.0, 40.0, 22.7);
    let whole = turns * std::f64::consts::TAU;
    let advance = turned::turning(&description, 60.0, turns, 3000, |c| {
        let (left, k) = (1.0 - c / whole, begin_mm - end_mm);
        (end_mm + k * left.powi(3), -3.0 * k * left.powi(2) / whole, 6.0 * k * left / whole.powi(2))
    });
    machine.place(advance[0].counts);
    let setpoints = std::iter::repeat_n(advance[0], 3400).chain(advance).collect();
    let commands = vec![
        (1, MachineCommand::WheelStop),
        (2100, MachineCommand::ChangeWheel { wheel: 1 }),
        (2810, MachineCommand::WheelStart),
    ];
    RunEvents { machine, setpoints, commands, faults: vec![(6300, Fault::EStop(true))], ticks: 6800, begun: 0 }
}

/// A bar is turned until the insert loses its speed.
fn turning() -> RunEvents {
    let description = lathe();
    let mut machine = machine(&description);
    let grid = PartGrid { azimuths: 180, columns: 60, from_mm: 0.0, to_mm: 10.0 };
    let bar = TurnedPart::round("bar".into(), grid, 20.0).expect("a bar");
    machine.load_turned_part(bar, 0.0).expect("a lathe");
    let x_mm = f64::sqrt(20.0 * 20.0 - 14.0 * 14.0) + 8.0 - 0.2;
    let setpoints =
        turned::turning(&description, 5.0, 3.0, 1500, |c| (x_mm + 0.05 * c.sin(), 0.05 * c.cos(), -0.05 * c.sin()));
    machine.place(setpoints[0].counts);
    RunEvents {
        machine,
        setpoints,
        commands: Vec::new(),
        faults: vec![(1100, Fault::WheelStall(true))],
        ticks: 2500,
        begun: 0,
    }
}

impl RunEvents {
    fn tick(&mut self) -> TickReport {
        let next = self.machine.tick() + 1 - self.begun;
        let of_tick = |tick: &u64| *tick == next;
        let commands: Vec<_> = self.commands.iter().filter(|(tick, _)| of_tick(tick)).map(|(_, c)| *c).collect();
        let faults: Vec<_> = self.faults.iter().filter(|(tick, _)| of_tick(tick)).map(|(_, fault)| *fault).collect();
        let setpoint = usize::try_from(next).ok().and_then(|next| self.setpoints.get(next)).copied();
        self.machine.step(setpoint.as_ref(), &commands, &faults)
    }
}

fn octets_of(kept: &mut impl Snapshot) -> Vec<u8> {
    let mut measured = SnapshotCodec::measuring();
    kept.snapshot(&mut measured).expect("it can be measured");
    let mut octets = vec![0; measured.octets()];
    let mut codec = SnapshotCodec::writing(&mut octets);
    kept.snapshot(&mut codec).expect("there is room");
    assert_eq!(codec.octets(), measured.octets());
    octets
}

fn taken_up(description: &MachineDescription, octets: &[u8]) -> Result<Machine, String> {
    let mut again = machine(description);
    let mut codec = SnapshotCodec::reading(octets);
    let kept = again.snapshot(&mut codec).and_then(|()| codec.end());
    kept.map(|()| again).map_err(|error| format!("{}: {error}", codec.place()))
}

/// Every 83 ticks the machine is thrown away, and another goes on from its keyframe.
#[test]
fn a_machine_goes_on_from_its_keyframe_to_the_bit() {
    for make in [grinding, pin_chasing, wide_grinding, taper_grinding, changing, turning] {
        let (mut whole, mut broken) = (make(), make());
        let (mut removed, mut raised, mut edges) = (0.0, 0, 0);
        for _ in 0..whole.ticks {
            if broken.machine.tick() % 83 == 40 {
                let octets = octets_of(&mut broken.machine);
                let again = taken_up(broken.machine.description(), &octets).expect("what was written can be read");
                assert_eq!(again, broken.machine, "tick {}", again.tick());
                broken.machine = again;
            }
            let (one, other) = (whole.tick(), broken.tick());
            assert_eq!(format!("{one:?}"), format!("{other:?}"), "tick {}", one.tick);
            removed += one.removal.area_mm2 + one.turned.volume_mm3;
            raised += one.raised.len();
            edges += one.latches.len();
            if one.tick - whole.begun == 2950 {
                let _refused = (whole.machine.reset(), broken.machine.reset());
            }
        }
        assert!(removed > 5.0 && raised > 0, "{removed} mm² or mm³, {raised} alarms, {edges} edges");
        assert_eq!(octets_of(&mut whole.machine), octets_of(&mut broken.machine));
    }
}

#[test]
fn what_differs_is_named_with_both_values() {
    let mut run = grinding();
    for _ in 0..500 {
        run.tick();
    }
    let octets = octets_of(&mut run.machine);
    assert_eq!(run.machine.snapshot(&mut SnapshotCodec::comparing(&octets)), Ok(()));
    let before = run.machine.clone();
    run.machine.set_keyway(0.25);
    let after = run.machine.clone();
    let mut codec = SnapshotCodec::comparing(&octets);
    let differs = SnapshotError::Differs { recorded: SnapshotValue::Number(0.0), now: SnapshotValue::Number(0.25) };
    assert_eq!(run.machine.snapshot(&mut codec), Err(differs));
    assert_eq!(codec.place().to_string(), "key_way_rad");
    assert_eq!(run.machine, after, "comparing leaves all as it is");
    run.machine = before;
    run.tick();
    let mut codec = SnapshotCodec::comparing(&octets);
    let error = run.machine.snapshot(&mut codec).expect_err("a tick later");
    assert_eq!(format!("{}: {error}", codec.place()), "tick: it was 1200, it is 1201");
    let mut other = taken_up(run.machine.description(), &octets).expect("a machine");
    other.load_lobe("I1", "LS1", 15.0, vec![23.1; 720]).expect("the raw lobe again");
    let mut codec = SnapshotCodec::comparing(&octets);
    let error = other.snapshot(&mut codec).expect_err("a cut lobe");
    let text = format!("{}: {error}", codec.place());
    assert!(text.starts_with("part[0].radii[") && text.ends_with("it is 23.1"), "{text}");
}

/// A keyframe in the middle of a change goes on with it; one whose wheels the machine does not have is refused.
#[test]
fn a_change_of_the_wheel_goes_on_from_its_middle() {
    let mut run = changing();
    for _ in 0..2400 {
        run.tick();
    }
    assert!(run.machine.is_mounting());
    let octets = octets_of(&mut run.machine);
    let description = changing().machine.description().clone();
    let mut again = taken_up(&description, &octets).expect("a machine in a change");
    for _ in 0..398 {
        again.step(None, &[], &[]);
    }
    assert!(again.is_mounting() && again.description().mounted_wheel() == 0);
    again.step(None, &[], &[]);
    assert!(!again.is_mounting() && again.description().mounted_wheel() == 1);
    let octets = octets_of(&mut again);
    let other = taken_up(&description, &octets).expect("a machine with its second wheel");
    assert_eq!(other, again);
    assert_eq!(other.description().wheel.new_radius_mm.to_bits(), 30.0_f64.to_bits());
    let mut three = description;
    three.wheel_changer.iter_mut().for_each(|changer| {
        let name = "polishing".to_owned();
        changer.wheels.push(MagazineWheel { name, ..changer.wheels[1].clone() });
    });
    let error = taken_up(&three, &octets).expect_err("two wheels are not three");
    assert!(error.contains("the changer has no such wheels"), "{error}");
}

#[test]
fn setpoints_that_wait_are_kept_with_their_tail_and_shifts() {
    let description = ideal();
    let rest = machine(&description).setpoint();
    let mut buffer = SetpointBuffer::new(&description, rest);
    let dense = [rest; 20];
    let tail = [TailPoint { tick: 40, setpoint: rest }, TailPoint { tick: 60, setpoint: rest }];
    let chunk = Chunk { first_tick: 1, dense: &dense, tail: &tail, is_final: false };
    buffer.accept(&chunk, 0).expect("it rests");
    buffer.schedule_home(30, Axis::X, 77);
    for tick in 1..=9 {
        buffer.executed(tick);
    }
    let octets = octets_of(&mut buffer);
    let mut again = SetpointBuffer::new(&description, rest);
    again.snapshot(&mut SnapshotCodec::reading(&octets)).expect("what was written");
    assert_eq!(again, buffer);
    for tick in 10..70 {
        assert_eq!(again.at(tick), buffer.at(tick));
        assert_eq!(again.is_underrun(tick), buffer.is_underrun(tick));
    }
}

/// Most of a keyframe is the part: `cargo test -p camwright --test integration room_of_a_keyframe -- --nocapture`.
#[test]
fn room_of_a_keyframe() {
    let mut grinder = grinding().machine;
    for (name, station) in [("I1", "LS1"), ("E1", "LS2"), ("I2", "LS3"), ("E2", "LS4")] {
        grinder.load_lobe(name, station, 15.0, vec![24.0; 3600]).expect("a round blank");
    }
    let mut lathes = [(360, 400), (720, 2900)].map(|(azimuths, columns)| {
        let mut machine = machine(&lathe());
        let grid = PartGrid { azimuths, columns, from_mm: 0.0, to_mm: 40.0 };
        let bar = TurnedPart::round("bar".into(), grid, 20.0).expect("a bar");
        machine.load_turned_part(bar, 0.0).expect("a lathe");
        machine
    });
    let [bar, largest] = &mut lathes;
    for (what, radii, machine) in [
        ("four lobes of 3600 radii", 4 * 2 * 3600, &mut grinder),
        ("a bar of 360 x 400 cells", 360 * 400, bar),
        ("the largest bar, 720 x 2900 cells", 720 * 2900, largest),
    ] {
        let octets = octets_of(machine);
        println!("{what}: {} kB", octets.len() / 1000);
        let besides = octets.len() - 8 * radii;
        assert!(besides < 70_000, "{what}: {besides} B besides {radii} radii");
    }
}

/// A small generator, so that the seed decides everything.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        usize::try_from(self.next() % bound as u64).expect("below the bound")
    }
}

/// Numbers that harm, in the place of one.
fn harmful(random: &mut Random) -> [u8; 8] {
    let numbers = [f64::NAN, f64::INFINITY, -1e300, 1e15, -1e15, 9e14, 1e9, -1e9, 1e-300, -0.0];
    let words = [u64::MAX, 1 << 53, (1 << 53) - 1, 1 << 31, (1 << 31) - 1, 4096, 0];
    match random.below(numbers.len() + words.len()) {
        at if at < numbers.len() => numbers[at].to_le_bytes(),
        at => words[at - numbers.len()].to_le_bytes(),
    }
}

/// Octets that were changed are refused, or make a machine that runs: neither fails, and neither takes for ever.
fn survives(make: fn() -> RunEvents, states: &[u64], tries: usize, seed: u64) {
    println!("seed {seed}");
    let mut random = Random(seed);
    let (mut refused, mut ran) = (0, 0);
    for state in states {
        let mut run = make();
        while run.machine.tick() - run.begun < *state {
            run.tick();
        }
        let whole = octets_of(&mut run.machine);
        for _ in 0..40 {
            let end = random.below(whole.len());
            assert!(taken_up(run.machine.description(), &whole[..end]).is_err(), "{end} of {}", whole.len());
        }
        // Most of it are radii; what else there is lies before and behind them.
        let radii = 16 * 720 * 4;
        for _ in 0..tries {
            let mut octets = whole.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(whole.len());
                let at = if random.below(4) > 0 && at > 2000 {
                    (whole.len() - 2000).saturating_sub(radii) + random.below(radii)
                } else {
                    at
                };
                let at = if random.below(2) == 0 { random.below(2000) } else { at.min(whole.len() - 8) };
                if random.below(2) == 0 {
                    octets[at] ^= 1 << random.below(8);
                } else {
                    octets[at..at + 8].copy_from_slice(&harmful(&mut random));
                }
            }
            let Ok(again) = taken_up(run.machine.description(), &octets) else {
                refused += 1;
                continue;
            };
            ran += 1;
            let begun = again.tick().saturating_sub(*state);
            let mut other = RunEvents { machine: again, begun, ..make() };
            for _ in 0..25 {
                other.tick();
            }
            for axis in [false, true] {
                let fault = [Fault::EStop(axis)];
                other.machine.step(None, &[MachineCommand::WheelStart], &fault);
                let _maybe = other.machine.reset();
            }
            for _ in 0..25 {
                other.machine.step(None, &[], &[]);
            }
        }
    }
    assert!(refused > tries / 10 && ran > tries / 10, "{refused} refused, {ran} ran");
}

#[test]
fn no_octets_make_a_grinder_fail() {
    survives(grinding, &[0, 700, 1500, 2100, 3350], tries(150), 20);
}

#[test]
fn no_octets_make_a_lathe_fail() {
    survives(turning, &[0, 700, 1150], tries(80), 21);
}

/// A longer campaign: `CAMWRIGHT_MUTATIONS=20000 cargo test -p camwright --test integration no_octets`.
fn tries(ordinary: usize) -> usize {
    std::env::var("CAMWRIGHT_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(ordinary)
}
