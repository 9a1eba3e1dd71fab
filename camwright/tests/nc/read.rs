// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Written programs are read back with the same meaning.

use super::sample::{random_program, two_cams};
use camwright::gcode::{Dialect, Direction, MotionAction, NcAxis, Program, ProgramMotion, XValues, driven, read};

/// Motions as they were read against motions as they are meant: the very same places, and times to the digits of F.
pub(crate) fn assert_same(dialect: Dialect, program: &Program, motion: &ProgramMotion, what: &str) {
    let meant = driven(program);
    let read = motion.done.iter().filter_map(|done| match done.action {
        MotionAction::Rapid(pose) => Some((done, pose, None)),
        MotionAction::Feed { pose, time_s } => Some((done, pose, Some(time_s))),
        _ => None,
    });
    let read: Vec<_> = read.collect();
    assert_eq!(read.len(), meant.len(), "{what}: number of motions");
    for (index, ((done, pose, time_s), meant)) in read.iter().zip(&meant).enumerate() {
        for axis in NcAxis::ALL {
            let wanted = meant.pose[axis.index()].map(|count| program.format.value(axis, count).to_bits());
            assert_eq!(pose.position(axis).map(f64::to_bits), wanted, "{what}: motion {index}, {axis:?}, {done:?}");
        }
        match (time_s, meant.time_s) {
            (None, None) => {}
            (Some(time_s), Some(wanted)) => {
                let feed = 60.0 / wanted;
                let max = if dialect == Dialect::Fanuc { 6e-4_f64.max(6e-8 * feed) } else { 6e-7 * feed };
                assert!((60.0 / time_s - feed).abs() < max, "{what}: motion {index} {time_s} s, {wanted} s meant");
            }
            _ => panic!("{what}: motion {index} is {time_s:?}, meant {:?}", meant.time_s),
        }
        assert_eq!(done.call.map(|call| call as usize), meant.call, "{what}: motion {index}");
    }
}

#[test]
fn what_is_written_is_read_as_it_was_meant() {
    for dialect in Dialect::ALL {
        for x_values in [XValues::Radius, XValues::Diameter] {
            let program = two_cams(x_values);
            let files = dialect.write(&program).expect("it can be written");
            let motion = read(dialect, x_values, &files).expect("it can be read");
            assert_same(dialect, &program, &motion, &format!("{dialect:?} {x_values:?}"));
            let calls: Vec<_> = motion.calls.iter().map(|call| call.subprogram).collect();
            assert_eq!(calls, [0, 0, 1]);
            assert_eq!(motion.subprograms.len(), 2);
        }
    }
}

/// 60 s over F of every feed: three times 1, 2.5, 3, 3 and 60/486 s, and the pause of half a second.
#[test]
fn orders_stand_between_motions_in_their_places() {
    for dialect in Dialect::ALL {
        let files = dialect.write(&two_cams(XValues::Radius)).expect("it can be written");
        let motion = read(dialect, XValues::Radius, &files).expect("it can be read");
        let orders = motion
            .done
            .iter()
            .filter(|done| !matches!(done.action, MotionAction::Rapid(_) | MotionAction::Feed { .. }));
        let orders: Vec<_> = orders.map(|done| done.action).collect();
        let tolerance = if dialect == Dialect::Fanuc { None } else { Some(0.001) };
        assert_eq!(orders[0], MotionAction::ToolChange(1));
        assert_eq!(orders[1], MotionAction::SpindleOn { direction: Direction::Clockwise, rpm: 2400.0 });
        assert_eq!(orders[2..4], [MotionAction::Coolant(true), MotionAction::PathTolerance(tolerance)]);
        assert_eq!(orders[4..], [MotionAction::Dwell(0.5), MotionAction::Coolant(false), MotionAction::SpindleOff]);
        assert!((motion.time_s() - (0.5 + 3.0 * (9.5 + 60.0 / 486.0))).abs() < 1e-9);
    }
}

/// Line and file of what is done are those of the text.
#[test]
fn what_is_done_names_its_line() {
    for dialect in Dialect::ALL {
        let files = dialect.write(&two_cams(XValues::Radius)).expect("it can be written");
        let motion = read(dialect, XValues::Radius, &files).expect("it can be read");
        let nose = motion.done.iter().position(
            |done| matches!(done.action, MotionAction::Feed { pose, .. } if pose.position(NcAxis::X) == Some(43.85)),
        );
        let done = motion.done[nose.expect("the nose of the first call")];
        let line = files[done.file as usize].text.lines().nth(done.line as usize - 1);
        assert_eq!(line, Some("X43.5500 C180.0000 F20.0"));
        let call = motion.calls[done.call.expect("it is called") as usize];
        let line = files[call.file as usize].text.lines().nth(call.line as usize - 1).expect("a line");
        assert!(line.contains("150.0000") && line.contains("0.3000"), "{line}");
        assert_eq!(call.by, None);
    }
}

/// Random programs, through the text of every dialect and back.
#[test]
fn random_programs_come_back() {
    let mut motions = 0;
    for seed in 0..600 {
        let program = random_program(seed);
        for dialect in Dialect::ALL {
            let what = format!("seed {seed}, {dialect:?}");
            let files = dialect.write(&program).unwrap_or_else(|error| panic!("{what}: {error}"));
            let motion = read(dialect, program.format.x_values(), &files);
            let motion = motion.unwrap_or_else(|error| panic!("{what}: {error}\n{:?}", files));
            assert_same(dialect, &program, &motion, &what);
            motions += motion.done.len();
        }
    }
    assert!(motions > 30_000, "only {motions} motions and orders");
}
