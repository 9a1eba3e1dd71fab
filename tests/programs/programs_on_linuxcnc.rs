// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs for LinuxCNC on its own interpreter: it must make of them what our reader makes of them, and that is what was meant.

#![allow(clippy::print_stdout, reason = "figures, with --nocapture")]

#[path = "../../camwright/tests/nc/sample.rs"]
mod sample;
use crate::support;

use camwright::gcode::post::ProgramRun;
use camwright::gcode::{
    Block, Dialect, MIN_RATE_MM_MIN, MotionAction, NcAxis, Program, ProgramMotion, ProgramPose, Step, XValues,
    raised_feeds, read,
};
use camwright_planning::{compare_program, write_program};
use sample::{random_program, target, two_cams};
use support::{Driven, LinuxCnc};

/// Canonical output has four decimal places, of a place and of its shift.
const PLACE_MM: f64 = 1.000_01e-4;
/// And of a rate.
const RATE_PER_MIN: f64 = 0.500_01e-4;

/// One program through both interpreters. Time is compared by the rate that makes it: LinuxCNC raises rates, which is no difference here.
fn compare(linuxcnc: &LinuxCnc, name: &str, program: &Program) -> (ProgramMotion, Vec<Driven>) {
    let files = Dialect::LinuxCnc.write(program).expect("it can be written");
    let motion = read(Dialect::LinuxCnc, program.format.x_values(), &files).expect("it can be read");
    let driven = linuxcnc.drive(&files[0].text).unwrap_or_else(|error| panic!("{name}: {error}\n{}", files[0].text));
    let mut pose = ProgramPose::default();
    for (index, (done, driven)) in motion.done.iter().zip(&driven).enumerate() {
        let what = format!("{name}, {index}: {done:?} is {driven:?}");
        match (done.action, driven.action) {
            (MotionAction::Rapid(to), MotionAction::Rapid(there)) => assert_there(&to, &there, &what),
            (MotionAction::Feed { pose: to, time_s }, MotionAction::Feed { pose: there, .. }) => {
                assert_there(&to, &there, &what);
                let meant = way_of_rate(&pose, &to) / time_s * 60.0;
                let min = meant.max(MIN_RATE_MM_MIN);
                assert!((driven.rate_per_min - min).abs() < RATE_PER_MIN + 1e-12 * min, "{what}: {min}/min");
            }
            (MotionAction::PathTolerance(Some(a)), MotionAction::PathTolerance(Some(b)))
            | (MotionAction::Dwell(a), MotionAction::Dwell(b)) => {
                assert!((a - b).abs() < PLACE_MM, "{what}");
            }
            (read, there) => assert_eq!(read, there, "{what}"),
        }
        if let MotionAction::Rapid(to) | MotionAction::Feed { pose: to, .. } = done.action {
            pose = to;
        }
    }
    assert!(driven.len() >= motion.done.len(), "{name}: LinuxCNC does less");
    // At the end of a program it stops spindle and coolant by itself.
    let more = &driven[motion.done.len()..];
    assert!(
        more.iter().all(|more| matches!(more.action, MotionAction::SpindleOff | MotionAction::Coolant(false))),
        "{name}: LinuxCNC does more: {more:?}"
    );
    (motion, driven)
}

fn assert_there(read: &ProgramPose, there: &ProgramPose, what: &str) {
    for axis in NcAxis::ALL {
        let Some(place) = read.position(axis) else { continue };
        let scale = if axis == NcAxis::C { camwright::math::units::rad_from_deg(1.0) } else { 1.0 };
        let off = (place - there.position(axis).expect("all axes are somewhere")).abs();
        assert!(off < PLACE_MM * scale, "{what}: {axis:?} is {off} off");
    }
}

/// The way by which LinuxCNC makes a rate of a time: mm of the linear axes, or where none moves degrees of C.
fn way_of_rate(from: &ProgramPose, to: &ProgramPose) -> f64 {
    let way = |axis| match (from.position(axis), to.position(axis)) {
        (Some(from), Some(to)) => to - from,
        // It takes axes that were nowhere for being at 0.
        (None, Some(to)) => to,
        _ => 0.0,
    };
    let linear = [NcAxis::X, NcAxis::Y, NcAxis::Z].map(|axis| way(axis).powi(2)).iter().sum::<f64>().sqrt();
    if linear > 0.0 { linear } else { camwright::math::units::deg_from_rad(way(NcAxis::C)).abs() }
}

#[test]
fn a_small_program_does_on_linuxcnc_what_is_read() {
    let Some(linuxcnc) = LinuxCnc::find() else { return };
    for (x_values, name) in [(XValues::Radius, "radius"), (XValues::Diameter, "diameter")] {
        let (motion, _) = compare(&linuxcnc, name, &two_cams(x_values));
        assert_eq!(motion.done.len(), 32);
    }
}

/// Everything that blocks, calls and formats can be.
#[test]
fn random_programs_do_on_linuxcnc_what_is_read() {
    let Some(linuxcnc) = LinuxCnc::find() else { return };
    let mut done = 0;
    for seed in 0..150 {
        done += compare(&linuxcnc, &format!("seed-{seed}"), &random_program(seed)).0.done.len();
    }
    assert!(done > 5_000, "only {done} blocks were compared");
}

/// The reported raised feeds are correct: the block takes the reported time, and no other block takes less than programmed.
#[test]
fn linuxcnc_raises_the_feeds_that_are_found() {
    let Some(linuxcnc) = LinuxCnc::find() else { return };
    let mut raised = 0;
    for seed in 0..40 {
        let mut program = random_program(seed);
        // From a known place, in small steps.
        program.main.retain(|step| !matches!(step, Step::Call(_)));
        program.subprograms.clear();
        let start = NcAxis::ALL.map(|axis| (axis, 0));
        program.main.insert(0, Step::Block(Block::Rapid(target(&start))));
        for (step, x) in (1..60).zip([1, 2, 4, 5, 7, 20, 21, 23, 22].into_iter().cycle()) {
            let time_s = 0.01 * 1.2_f64.powi(step);
            let target = target(&[(NcAxis::X, x), (NcAxis::C, i64::from(step) * 1000)]);
            program.main.push(Step::Block(Block::Feed { target, time_s }));
        }
        let found = raised_feeds(&program);
        let (motion, driven) = compare(&linuxcnc, &format!("raised-{seed}"), &program);
        // Comments do nothing; everything else is done once.
        let steps = program.main.iter().enumerate();
        let steps = steps.filter(|(_, step)| !matches!(step, Step::Block(Block::Comment(_))));
        let mut pose = ProgramPose::default();
        for (((block, _), done), driven) in steps.zip(&motion.done).zip(&driven) {
            if let MotionAction::Feed { pose: to, time_s } = done.action {
                let there_s = way_of_rate(&pose, &to) / driven.rate_per_min * 60.0;
                let raised_feed = found.iter().find(|raised| raised.place.block == block + 1);
                let wanted = raised_feed.map_or(time_s, |raised| raised.driven_s);
                let max = 1e-6 + RATE_PER_MIN / driven.rate_per_min;
                assert!(
                    (there_s / wanted - 1.0).abs() < max || there_s == 0.0,
                    "seed {seed}, block {block}: {there_s} s, {wanted} s"
                );
            }
            if let MotionAction::Rapid(to) | MotionAction::Feed { pose: to, .. } = done.action {
                pose = to;
            }
        }
        raised += found.len();
    }
    assert!(raised > 200, "only {raised} feeds were raised");
}

/// Programs that LinuxCNC rejects are rejected by our reader too.
#[test]
fn what_linuxcnc_refuses_is_not_read() {
    let Some(linuxcnc) = LinuxCnc::find() else { return };
    let begin = "G21 G90 G93\nG0 X1 C1\n";
    let faults = [
        "G1 X2\n",
        "G0 G1 X2\n",
        "X1 X2\n",
        "G1 X2 F-1\n",
        "o<nothing> call\n",
        "G0 X1.2.3\n",
        "(open\n",
        "G1000\n",
        "G7 G8\n",
    ];
    for fault in faults {
        let text = format!("{begin}{fault}M2\n");
        assert!(linuxcnc.drive(&text).is_err(), "LinuxCNC takes {fault}");
        let file = camwright::gcode::ProgramFile { name: "a.ngc".into(), text };
        assert!(read(Dialect::LinuxCnc, XValues::Radius, &[file]).is_err(), "{fault} is read");
    }
}

/// The whole way of every shipped job: its program is written to the disk, LinuxCNC interprets it, and what the axes do then lies within the
/// tolerance of the paths that were planned. The interpreter prints four places, as many as the programs have.
#[test]
fn programs_of_jobs_drive_their_paths_on_linuxcnc() {
    let Some(linuxcnc) = LinuxCnc::find() else { return };
    for (job, set) in [
        ("eccentric_disc", vec![]),
        ("eccentric_disc", vec!["profiles.disc.lift.eccentric.diameter_is=largest", "nc.knots=on_curve"]),
        ("eccentric_disc", vec!["tool.cuts_with=face", "nc.x_values=diameter"]),
        ("plate_groove", vec!["nc.rotation_sense=-1"]),
        ("barrel_groove", vec![]),
        ("barrel_groove", vec!["grooves.B.y_axis=false"]),
        ("level_wind", vec!["nc.rotation_sense=-1"]),
        ("level_wind", vec!["tool.radius_mm=3"]),
        ("barrel_indexer", vec![]),
        ("barrel_indexer", vec!["nc.rotation_sense=-1", "passes.finish.turns=2"]),
        ("four_lobe_camshaft", vec![]),
        ("rough_and_finish", vec!["nc.x_of=cutting_edge", "nc.x_values=diameter"]),
        ("plate_cam", vec!["nc.rotation_sense=-1"]),
        ("brake_cam", vec![]),
        ("turned_cam", vec!["turned.to_mm=21", "nc.finish_tolerance_um=2"]),
        (
            "turned_cam",
            vec![
                "turned.to_mm=21",
                "nc.finish_tolerance_um=5",
                // Half of a diameter with three places has four.
                "nc.x_values=diameter",
                "nc.linear_decimals=3",
                "nc.x_of=cutting_edge",
                "nc.rotation_sense=-1",
            ],
        ),
    ] {
        let what = format!("{job} {set:?}");
        let set: Vec<String> = set.into_iter().map(str::to_owned).collect();
        let folder = support::Folder::new("linuxcnc-job");
        let summary = write_program(job, &set, folder.path(), |_| {}).unwrap_or_else(|error| panic!("{what}: {error}"));
        let text = std::fs::read_to_string(folder.join(&summary.files[0])).expect("a program");
        let driven = linuxcnc.drive(&text).unwrap_or_else(|error| panic!("{what}: {error}"));
        let place = |pose: ProgramPose| NcAxis::ALL.map(|axis| pose.position(axis).unwrap_or(f64::NAN));
        let ran = driven.iter().filter_map(|driven| match driven.action {
            MotionAction::Rapid(pose) => Some(ProgramRun { pose: place(pose), time_s: None }),
            MotionAction::Feed { pose, time_s } => Some(ProgramRun { pose: place(pose), time_s: Some(time_s) }),
            _ => None,
        });
        let ran: Vec<ProgramRun> = ran.collect();
        let compared = compare_program(job, &set, &ran).unwrap_or_else(|error| panic!("{what}: {error}"));
        println!(
            "{what}: {} motions, {:.4} um off the paths at most, {:.1} % of the tolerance",
            compared.moves,
            compared.error_um(),
            100.0 * compared.share_of_tolerance
        );
        assert!(compared.moves == summary.read_back.moves, "{what}: {} {}", compared.moves, summary.read_back.moves);
        assert!(compared.share_of_tolerance <= 1.0, "{what}: {compared:?}");
        assert!(
            (compared.share_of_tolerance - summary.read_back.share_of_tolerance).abs() < 0.2,
            "{what}: {compared:?}"
        );
    }
}
