// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::{
    Handshake, HandshakeFailure, HandshakeGoal, HandshakeProgress, HandshakeRequest, HandshakeStep, LoaderState,
    LoadingCommand, LoadingInputs, Timeouts, Wait,
};
use crate::simulation::work_area::ActuatorPosition;
use alloc::string::ToString;

const TIMEOUTS: Timeouts = Timeouts { machine_s: 5.0, enter_s: 20.0, inside_s: 30.0 };
const READY: LoaderState = LoaderState { available: true, inside: false, busy: false, has_fault: false };
const INSIDE: LoaderState = LoaderState { available: true, inside: true, busy: true, has_fault: false };

/// A machine that has just ended a part: door closed, chuck closed on the part, nobody in the work area.
const AFTER_A_PART: LoadingInputs = LoadingInputs {
    now_s: 0.0,
    door: ActuatorPosition::Closed,
    chuck: ActuatorPosition::Closed,
    part_present: true,
    entered: false,
    is_safe: false,
    loader: Some(READY),
};
const DOOR_OPEN: LoadingInputs = LoadingInputs { door: ActuatorPosition::Open, is_safe: true, ..AFTER_A_PART };
const ROBOT_INSIDE: LoadingInputs = LoadingInputs { entered: true, loader: Some(INSIDE), ..DOOR_OPEN };

fn begun(request: HandshakeRequest) -> Handshake {
    Handshake::begin(request, TIMEOUTS, 0.0)
}

/// A handshake whose robot is inside.
fn inside(request: HandshakeRequest) -> Handshake {
    let mut handshake = begun(request);
    for seen in [DOOR_OPEN, ROBOT_INSIDE] {
        assert_eq!(handshake.advance(&seen), HandshakeProgress::Going(None));
    }
    assert_eq!(handshake.step(), HandshakeStep::Inside);
    handshake
}

#[test]
fn an_exchange_goes_through_its_steps_and_gives_leave_in_two_of_them_only() {
    let mut handshake = begun(HandshakeRequest::Exchange);
    assert_eq!(handshake.advance(&AFTER_A_PART), HandshakeProgress::Going(Some(LoadingCommand::OpenDoor)));
    assert!(!handshake.clear_to_enter());
    let unsafe_yet = LoadingInputs { door: ActuatorPosition::Open, is_safe: false, ..AFTER_A_PART };
    assert_eq!(handshake.advance(&unsafe_yet), HandshakeProgress::Going(None), "the wheel is not in its place");
    assert!(!handshake.clear_to_enter());
    assert_eq!(handshake.advance(&DOOR_OPEN), HandshakeProgress::Going(None));
    assert!(handshake.clear_to_enter() && handshake.step() == HandshakeStep::Enter);
    assert_eq!(Handshake::chuck_refused(Some(&handshake), &DOOR_OPEN), Some("the loader is not cleared and inside"));
    assert_eq!(handshake.advance(&ROBOT_INSIDE), HandshakeProgress::Going(None));
    assert_eq!(Handshake::chuck_refused(Some(&handshake), &ROBOT_INSIDE), None);
    let empty = LoadingInputs { chuck: ActuatorPosition::Open, part_present: false, ..ROBOT_INSIDE };
    assert_eq!(handshake.advance(&empty), HandshakeProgress::Going(None));
    // Out for the next part: still busy, still cleared.
    let fetching = LoadingInputs { entered: false, loader: Some(LoaderState { inside: false, ..INSIDE }), ..empty };
    assert_eq!(handshake.advance(&fetching), HandshakeProgress::Going(None));
    assert!(handshake.clear_to_enter());
    assert_eq!(Handshake::chuck_refused(Some(&handshake), &fetching), Some("the loader is not in the work area"));
    assert_eq!(handshake.advance(&ROBOT_INSIDE), HandshakeProgress::Going(None));
    assert_eq!(handshake.advance(&DOOR_OPEN), HandshakeProgress::Going(None));
    assert_eq!(
        (handshake.step(), handshake.request(), handshake.clear_to_enter()),
        (HandshakeStep::CloseDoor, HandshakeRequest::None, false)
    );
    assert_eq!(handshake.advance(&DOOR_OPEN), HandshakeProgress::Going(Some(LoadingCommand::CloseDoor)));
    assert_eq!(handshake.advance(&AFTER_A_PART), HandshakeProgress::Done);
    assert_eq!(Handshake::chuck_refused(None, &ROBOT_INSIDE), Some("loading is not requested"));
}

#[test]
fn what_is_asked_for_follows_from_what_the_chuck_holds() {
    for (goal, present, machined, wanted) in [
        (HandshakeGoal::RawPart, false, false, HandshakeRequest::Load),
        (HandshakeGoal::RawPart, false, true, HandshakeRequest::Load),
        (HandshakeGoal::RawPart, true, false, HandshakeRequest::None),
        (HandshakeGoal::RawPart, true, true, HandshakeRequest::Exchange),
        (HandshakeGoal::Empty, true, false, HandshakeRequest::Unload),
        (HandshakeGoal::Empty, true, true, HandshakeRequest::Unload),
        (HandshakeGoal::Empty, false, false, HandshakeRequest::None),
    ] {
        assert_eq!(HandshakeRequest::for_goal(goal, present, machined), wanted, "{goal:?} {present} {machined}");
    }
}

#[test]
fn what_the_sensors_show_in_the_end_is_judged() {
    let empty = LoadingInputs { part_present: false, chuck: ActuatorPosition::Open, ..DOOR_OPEN };
    for (request, left, wanted) in [
        (HandshakeRequest::Load, empty, HandshakeFailure::PartMissing),
        (HandshakeRequest::Exchange, empty, HandshakeFailure::PartMissing),
        (HandshakeRequest::Unload, DOOR_OPEN, HandshakeFailure::PartStillThere),
        (HandshakeRequest::Exchange, DOOR_OPEN, HandshakeFailure::NotExchanged),
        (
            HandshakeRequest::Load,
            LoadingInputs { chuck: ActuatorPosition::Open, ..DOOR_OPEN },
            HandshakeFailure::ChuckNotClosed,
        ),
        (
            HandshakeRequest::Load,
            LoadingInputs { chuck: ActuatorPosition::Closing, ..DOOR_OPEN },
            HandshakeFailure::ChuckNotClosed,
        ),
    ] {
        assert_eq!(inside(request).advance(&left), HandshakeProgress::Failed(wanted), "{request:?}: {wanted}");
    }
    let mut unload = inside(HandshakeRequest::Unload);
    assert_eq!(unload.advance(&empty), HandshakeProgress::Going(None));
    assert_eq!(unload.step(), HandshakeStep::CloseDoor);
}

#[test]
fn a_robot_that_cannot_be_counted_on_is_waited_for_without_end_and_then_has_its_time() {
    for (loader, wait) in [
        (None, Wait::Silent),
        (Some(LoaderState { available: false, ..READY }), Wait::Unavailable),
        (Some(LoaderState { has_fault: true, ..READY }), Wait::Fault),
    ] {
        let mut handshake = begun(HandshakeRequest::Load);
        assert_eq!(handshake.advance(&DOOR_OPEN), HandshakeProgress::Going(None));
        for now_s in [10.0, 1e6] {
            assert_eq!(
                handshake.advance(&LoadingInputs { now_s, loader, ..DOOR_OPEN }),
                HandshakeProgress::Waiting(wait)
            );
            assert_eq!(handshake.timeout_left_s(now_s), None);
        }
        let back = |now_s: f64| LoadingInputs { now_s, ..DOOR_OPEN };
        assert_eq!(handshake.advance(&back(1e6 + 1.0)), HandshakeProgress::Going(None));
        assert_eq!(handshake.advance(&back(1e6 + 20.9)), HandshakeProgress::Going(None));
        let late = handshake.advance(&back(1e6 + 21.1));
        assert_eq!(late, HandshakeProgress::Failed(HandshakeFailure::TooLong(HandshakeStep::Enter, 20.0)));
    }
    // One that goes silent inside is the machine's alarm; the leave is not taken back.
    let mut handshake = inside(HandshakeRequest::Load);
    assert_eq!(
        handshake.advance(&LoadingInputs { loader: None, ..ROBOT_INSIDE }),
        HandshakeProgress::Waiting(Wait::Silent)
    );
    assert!(handshake.clear_to_enter());
}

#[test]
fn every_step_has_a_timeout_that_names_it() {
    for (mut handshake, seen, after_s, words) in [
        (begun(HandshakeRequest::Load), AFTER_A_PART, 5.1, "was not ready to be loaded within 5 s"),
        (inside(HandshakeRequest::Load), ROBOT_INSIDE, 30.1, "the loader did not leave the work area within 30 s"),
        (
            {
                let mut closing = inside(HandshakeRequest::Unload);
                let _closing = closing.advance(&LoadingInputs { part_present: false, ..DOOR_OPEN });
                closing
            },
            DOOR_OPEN,
            5.1,
            "the door did not close within 5 s",
        ),
    ] {
        match handshake.advance(&LoadingInputs { now_s: after_s, ..seen }) {
            HandshakeProgress::Failed(failure) => assert!(failure.to_string().contains(words), "{failure}"),
            other => panic!("{words}: {other:?}"),
        }
    }
}

#[test]
fn who_enters_without_leave_is_found_in_every_step_without_leave() {
    let mut opening = begun(HandshakeRequest::Load);
    assert_eq!(opening.advance(&LoadingInputs { entered: true, ..AFTER_A_PART }), HandshakeProgress::Uncleared);
    let mut closing = inside(HandshakeRequest::Load);
    assert_eq!(closing.advance(&DOOR_OPEN), HandshakeProgress::Going(None));
    assert_eq!(closing.advance(&ROBOT_INSIDE), HandshakeProgress::Uncleared);
}
