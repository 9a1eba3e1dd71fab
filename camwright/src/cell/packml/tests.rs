// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::{Command, CommandRefused, Mode, PackmlState, Unit};
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

/// A cell in a state, brought there by commands alone.
fn unit_in(state: PackmlState) -> Unit {
    use Command::{Abort, Clear, Hold, Reset, Start, Stop, Suspend, Unhold, Unsuspend};
    // A command, or `None` for the end of what is acted on.
    let way: &[Option<Command>] = match state {
        PackmlState::Stopped => &[],
        PackmlState::Resetting => &[Some(Reset)],
        PackmlState::Idle => &[Some(Reset), None],
        PackmlState::Starting => &[Some(Reset), None, Some(Start)],
        PackmlState::Execute => &[Some(Reset), None, Some(Start), None],
        PackmlState::Holding => &[Some(Reset), None, Some(Start), None, Some(Hold)],
        PackmlState::Held => &[Some(Reset), None, Some(Start), None, Some(Hold), None],
        PackmlState::Unholding => &[Some(Reset), None, Some(Start), None, Some(Hold), None, Some(Unhold)],
        PackmlState::Suspending => &[Some(Reset), None, Some(Start), None, Some(Suspend)],
        PackmlState::Suspended => &[Some(Reset), None, Some(Start), None, Some(Suspend), None],
        PackmlState::Unsuspending => &[Some(Reset), None, Some(Start), None, Some(Suspend), None, Some(Unsuspend)],
        PackmlState::Completing => &[Some(Reset), None, Some(Start), None, None],
        PackmlState::Complete => &[Some(Reset), None, Some(Start), None, None, None],
        PackmlState::Stopping => &[Some(Reset), None, Some(Stop)],
        PackmlState::Aborting => &[Some(Abort)],
        PackmlState::Aborted => &[Some(Abort), None],
        PackmlState::Clearing => &[Some(Abort), None, Some(Clear)],
    };
    let mut unit = Unit::new(0.0);
    for step in way {
        match step {
            Some(command) => assert!(unit.command(*command, 0.0).is_ok(), "{command} on the way to {state}"),
            None => assert!(unit.complete(0.0)),
        }
    }
    assert_eq!(unit.state(), state);
    unit
}

/// The table of the technical report, a line for each state: RESET START STOP HOLD UNHOLD SUSPEND UNSUSPEND ABORT CLEAR, then where the
/// state leads by itself. Written down apart from the code: by number, 0 for refused.
const TABLE: [(PackmlState, [u8; 9], u8); 17] = [
    (PackmlState::Clearing, [0, 0, 0, 0, 0, 0, 0, 8, 0], 2),
    (PackmlState::Stopped, [15, 0, 0, 0, 0, 0, 0, 8, 0], 0),
    (PackmlState::Starting, [0, 0, 7, 0, 0, 0, 0, 8, 0], 6),
    (PackmlState::Idle, [0, 3, 7, 0, 0, 0, 0, 8, 0], 0),
    (PackmlState::Suspended, [0, 0, 7, 10, 0, 0, 14, 8, 0], 0),
    (PackmlState::Execute, [0, 0, 7, 10, 0, 13, 0, 8, 0], 16),
    (PackmlState::Stopping, [0, 0, 0, 0, 0, 0, 0, 8, 0], 2),
    (PackmlState::Aborting, [0, 0, 0, 0, 0, 0, 0, 0, 0], 9),
    (PackmlState::Aborted, [0, 0, 0, 0, 0, 0, 0, 0, 1], 0),
    (PackmlState::Holding, [0, 0, 7, 0, 0, 0, 0, 8, 0], 11),
    (PackmlState::Held, [0, 0, 7, 0, 12, 0, 0, 8, 0], 0),
    (PackmlState::Unholding, [0, 0, 7, 0, 0, 0, 0, 8, 0], 6),
    (PackmlState::Suspending, [0, 0, 7, 0, 0, 0, 0, 8, 0], 5),
    (PackmlState::Unsuspending, [0, 0, 7, 0, 0, 0, 0, 8, 0], 6),
    (PackmlState::Resetting, [0, 0, 7, 0, 0, 0, 0, 8, 0], 4),
    (PackmlState::Completing, [0, 0, 7, 0, 0, 0, 0, 8, 0], 17),
    (PackmlState::Complete, [15, 0, 7, 0, 0, 0, 0, 8, 0], 0),
];

#[test]
fn every_command_in_every_state_follows_the_table_or_is_refused_with_a_reason() {
    for (state, row, by_itself) in TABLE {
        for (command, wanted) in Command::ALL.into_iter().zip(row) {
            let mut unit = unit_in(state);
            match unit.command(command, 1.0) {
                Ok(now) => assert_eq!(now as u8, wanted, "{command} in {state}"),
                Err(refused) => {
                    assert_eq!(wanted, 0, "{command} in {state}: {refused}");
                    assert_eq!(unit.state(), state, "nothing changes");
                    let text = refused.to_string();
                    assert!(text.starts_with(&format!("{command} is not taken in state {state}; ")), "{text}");
                    let (CommandRefused::State { .. }, true) = (refused, text.contains("it takes") || by_itself > 0)
                    else {
                        panic!("{text}");
                    };
                }
            }
        }
        let mut unit = unit_in(state);
        assert_eq!(unit.complete(1.0), by_itself > 0, "{state}");
        assert_eq!(unit.state() as u8, if by_itself > 0 { by_itself } else { state as u8 }, "{state}");
    }
    let text = Unit::new(0.0).command(Command::Start, 0.0).expect_err("it is stopped").to_string();
    assert_eq!(text, "START is not taken in state STOPPED; it takes RESET, ABORT");
}

#[test]
fn numbers_are_those_of_the_report_and_every_name_is_one() {
    let numbers: Vec<u8> = PackmlState::ALL.into_iter().map(|state| state as u8).collect();
    assert_eq!(numbers, (1..=17).collect::<Vec<u8>>());
    assert_eq!(TABLE.map(|(state, ..)| state), PackmlState::ALL);
    assert_eq!(Command::ALL.map(|command| command as u8), [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    for command in Command::ALL {
        assert_eq!(Command::from_number(command as u8), Some(command));
    }
    assert_eq!((Command::from_number(0), Command::from_number(10), Mode::from_number(5)), (None, None, None));
    for mode in Mode::ALL {
        assert_eq!(Mode::from_number(mode as u8), Some(mode));
    }
}

/// In every mode and state: the mode changes at rest only, and nothing but START depends on it.
#[test]
fn start_is_for_modes_that_produce_and_modes_change_at_rest() {
    for mode in Mode::ALL {
        let mut unit = unit_in(PackmlState::Idle);
        unit.select(mode).expect("at rest");
        for command in Command::ALL {
            let mut unit = unit;
            let is_taken = unit.command(command, 0.0);
            match (command, mode) {
                (Command::Start, Mode::Manual | Mode::SetUp) => {
                    assert_eq!(is_taken, Err(CommandRefused::Mode { mode }));
                }
                _ => {
                    assert_eq!(is_taken.is_ok(), PackmlState::Idle.commanded(command).is_some(), "{command} in {mode}");
                }
            }
        }
        for state in PackmlState::ALL {
            let mut unit = unit_in(state);
            let at_rest = matches!(
                state,
                PackmlState::Stopped | PackmlState::Idle | PackmlState::Complete | PackmlState::Aborted
            );
            assert_eq!(unit.select(mode).is_ok(), at_rest, "{mode} in {state}");
            assert_eq!(unit.mode(), if at_rest { mode } else { Mode::Automatic });
        }
    }
}

#[test]
fn times_add_up_to_all_of_it() {
    let mut unit = Unit::new(10.0);
    let steps = [(12.0, Some(Command::Reset)), (12.5, None), (20.0, Some(Command::Start)), (21.0, None), (51.0, None)];
    for (now_s, command) in steps {
        match command {
            Some(command) => assert!(unit.command(command, now_s).is_ok()),
            None => assert!(unit.complete(now_s)),
        }
    }
    let times_s = unit.accumulated_s(53.0);
    for (state, wanted_s) in [
        (PackmlState::Stopped, 2.0),
        (PackmlState::Resetting, 0.5),
        (PackmlState::Idle, 7.5),
        (PackmlState::Starting, 1.0),
        (PackmlState::Execute, 30.0),
        (PackmlState::Completing, 2.0),
    ] {
        assert!((times_s[state as usize] - wanted_s).abs() < 1e-12, "{state}: {times_s:?}");
    }
    assert!((times_s[0] - 43.0).abs() < 1e-12 && (times_s[1..].iter().sum::<f64>() - 43.0).abs() < 1e-12);
    assert!((unit.time_in_state_s(53.0) - 2.0).abs() < 1e-12);
    // A clock that is set back takes nothing away.
    assert!(unit.time_in_state_s(0.0) >= 0.0 && unit.accumulated_s(0.0)[0] >= 0.0);
}
