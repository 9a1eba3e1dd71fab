// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cell that is loaded by a robot: ten parts by the example's robot, and what becomes of everything that can go wrong between them.

use crate::cell;
use crate::loader_robot;
use crate::watched;

use camwright_msgs::camwright_msgs::action::{MoveTo, MoveToGoal};
use camwright_msgs::camwright_msgs::msg::{
    CellState, InterpolatorState, JobStatus, LoadingState, MachineAlarms, WorkArea,
};
use camwright_msgs::camwright_msgs::srv::{
    CellCommandRequest, InjectFault, InjectFaultRequest, SetCellMode, SetCellModeRequest,
};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_ros::{GoalStatus, ParameterValue, Qos, Subscription};
use cell::{Cell, PATIENCE};
use loader_robot::Robot;
use std::sync::mpsc;
use std::time::Instant;
use watched::LogLines;

/// A door of half a second and a chuck of a fifth; at pace fast they take no time.
const MACHINE: &str =
    "loading={door: {opens_ms: 500, closes_ms: 500}, chuck: {opens_ms: 200, closes_ms: 200}, safe_x_mm: 120}";
/// One lobe in few turns.
const SHORT: [&str; 3] = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];

/// The cell, its robot, and an operator who hears every state.
struct Loaded {
    cell: Cell,
    robot: Robot,
    states: mpsc::Receiver<CellState>,
    areas: mpsc::Receiver<WorkArea>,
    alarms: mpsc::Receiver<MachineAlarms>,
    motions: mpsc::Receiver<InterpolatorState>,
    _subscriptions: [Subscription; 4],
}

impl Loaded {
    /// `timeout_s`: how long the robot may be silent.
    fn start(timeout_s: f64) -> Self {
        let mut of_robot = None;
        let cell = Cell::start_with(&[MACHINE], |args| {
            let long = ParameterValue::Double(timeout_s);
            let args = args.with_parameter(None, "loader_timeout_s", long);
            of_robot = Some(args.clone());
            args
        });
        let robot = Robot::start(&of_robot.expect("it was called"), 10).expect("a robot");
        let node = &cell.client.node;
        let ((of_states, states), (of_areas, areas)) = (mpsc::channel(), mpsc::channel());
        let (of_alarms, alarms) = mpsc::channel();
        let (of_motions, motions) = mpsc::channel();
        let all = Qos::latched(1).keep_last(500);
        let subscriptions = [
            node.subscribe("axis_interpolator/state", &all, move |state, _| drop(of_motions.send(state))),
            node.subscribe("job_planner/cell_state", &all, move |state, _| drop(of_states.send(state))),
            node.subscribe("machine/work_area", &all, move |area, _| drop(of_areas.send(area))),
            node.subscribe("machine/alarms", &all, move |alarms, _| drop(of_alarms.send(alarms))),
        ]
        .map(|made| made.expect("a subscription"));
        Self { cell, robot, states, areas, alarms, motions, _subscriptions: subscriptions }
    }

    fn overrides() -> Vec<String> {
        SHORT.map(String::from).into()
    }

    fn start_run(&self, parts: u32) {
        self.robot.start_run("eccentric", &Self::overrides(), parts).expect("RESET and START are taken");
    }

    /// A run of one part, up to where its job moves the axes.
    fn grind(&self) {
        self.motions.try_iter().for_each(drop);
        self.start_run(1);
        let request = self.robot.enter().expect("it is inside");
        self.robot.change_part(request).expect("a part");
        self.robot.leave().expect("it leaves");
        let grinds = |cell: &CellState| cell.state == CellState::EXECUTE && cell.substate == "job eccentric";
        self.robot.cell("a job", grinds).expect("it grinds");
        // What happens before anything moves is no alarm of the job: the machine does not take the part.
        let moves = |motion: InterpolatorState| motion.state == InterpolatorState::EXECUTING && motion.lobe >= 0;
        while !self.motions.recv_timeout(PATIENCE).map(moves).expect("states of the motion") {}
    }

    fn state(&self, wanted: u8) -> CellState {
        self.robot.cell(&format!("state {wanted}"), |state| state.state == wanted).expect("the state")
    }

    fn command(&self, command: u8) -> Result<(), String> {
        let answer = self.robot.command(&CellCommandRequest { command, ..CellCommandRequest::default() });
        let answer = answer.expect("an answer");
        if answer.success { Ok(()) } else { Err(answer.message) }
    }

    fn fault(&self, fault: &str, active: bool) {
        let request = InjectFaultRequest { fault: fault.into(), active, ..InjectFaultRequest::default() };
        let answer = self.cell.client.call::<InjectFault>("machine/inject_fault", &request);
        assert!(answer.success, "{}", answer.message);
    }

    fn trigger(&self, service: &str) -> Result<String, String> {
        let answer = self.cell.client.call::<Trigger>(service, &TriggerRequest::default());
        if answer.success { Ok(answer.message) } else { Err(answer.message) }
    }

    fn area(&self, what: &str, wanted: impl Fn(&WorkArea) -> bool) -> WorkArea {
        loop {
            let area = self.areas.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no work area {what}"));
            if wanted(&area) {
                return area;
            }
        }
    }

    fn alarm(&self, number: u16) {
        loop {
            let alarms = self.alarms.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no alarm {number}"));
            if alarms.alarms.iter().any(|alarm| alarm.number == number) {
                return;
            }
        }
    }

    fn stop(self) {
        self.robot.node.shutdown();
        self.cell.stop();
    }
}

#[test]
fn the_robot_of_the_example_tends_ten_parts() {
    let loaded = Loaded::start(10.0);
    loaded.start_run(10);
    let served = loaded.robot.tend().expect("it comes to its end");
    let exchanges = [LoadingState::EXCHANGE; 9];
    assert_eq!(served, [&[LoadingState::LOAD][..], &exchanges, &[LoadingState::UNLOAD]].concat());
    let end = loaded.robot.cell("the counters", |state| state.state == CellState::COMPLETE && state.life.good == 10);
    let end = end.expect("ten good parts");
    assert_eq!((end.parts_wanted, end.parts_done, end.life.total, end.shift.total), (10, 10, 10, 10));
    assert!(end.holder.is_empty() && end.stop_reason.is_empty() && end.alarm == 0, "{end:?}");
    let accumulated: f64 = end.accumulated[1..].iter().sum();
    assert!((accumulated - end.accumulated[0]).abs() < 1e-6 && end.accumulated[6] > 0.0, "{:?}", end.accumulated);
    // Every way that the cell went is one of PackML's.
    let mut states = Vec::new();
    while states.last() != Some(&CellState::COMPLETE) {
        states.push(loaded.states.recv_timeout(PATIENCE).expect("every state, up to COMPLETE").state);
    }
    let mut ways: Vec<(u8, u8)> = states.windows(2).map(|pair| (pair[0], pair[1])).filter(|(a, b)| a != b).collect();
    ways.sort_unstable();
    ways.dedup();
    assert_eq!(
        ways,
        [(2, 15), (3, 6), (4, 3), (5, 14), (6, 13), (6, 16), (13, 5), (14, 6), (15, 4), (16, 17)],
        "{states:?}"
    );
    let area = loaded.area("at the end", |area| area.door == WorkArea::CLOSED && !area.part_present);
    assert!(!area.entered);
    assert_eq!(loaded.trigger("machine/reset_shift").expect("it is reset"), "the counters of the shift begin anew");
    let shift = loaded.robot.cell("a new shift", |state| state.shift.total == 0).expect("a new shift");
    assert_eq!((shift.life.total, shift.life.good), (10, 10));
    loaded.stop();
}

/// Who may say what: refused with the reason, and with who has command.
#[test]
fn commands_modes_and_jobs_of_others_are_refused_with_who_has_command() {
    let loaded = Loaded::start(10.0);
    let refused = loaded.command(CellCommandRequest::START).expect_err("it is stopped");
    assert_eq!(refused, "START is not taken in state STOPPED; it takes RESET, ABORT");
    assert!(loaded.command(77).expect_err("there is none").contains("allowed: 1 (RESET) to 9 (CLEAR)"));
    loaded.start_run(2);
    let waiting = loaded.state(CellState::SUSPENDED);
    assert!(waiting.holder.contains("run of eccentric, 0 of 2 parts done"), "{}", waiting.holder);
    let refused = loaded.command(CellCommandRequest::START).expect_err("it runs");
    assert!(refused.contains("START is not taken in state SUSPENDED") && refused.contains("has command"), "{refused}");
    let (goal, _) = loaded.cell.client.send("eccentric", &SHORT);
    assert!(!goal.accepted(), "a job of somebody else does not get between the parts of a run");
    let refused = loaded.command(CellCommandRequest::UNSUSPEND).expect_err("it waits for the robot");
    assert!(refused.contains("waits for the loader"), "{refused}");
    let mode =
        |mode: u8| loaded.cell.client.call::<SetCellMode>("job_planner/set_cell_mode", &SetCellModeRequest { mode });
    let answer = mode(CellState::MANUAL);
    assert!(!answer.success && answer.message.contains("cannot be changed in state SUSPENDED"), "{}", answer.message);
    // HOLD while the work area is free takes the leave back, UNHOLD asks again.
    loaded.robot.loading("a leave", |loading| loading.clear_to_enter).expect("a leave");
    loaded.command(CellCommandRequest::HOLD).expect("it holds");
    loaded.state(CellState::HELD);
    loaded.robot.loading("no leave", |loading| !loading.clear_to_enter).expect("none");
    loaded.command(CellCommandRequest::UNHOLD).expect("it goes on");
    loaded.robot.loading("a leave", |loading| loading.clear_to_enter).expect("a leave");
    loaded.command(CellCommandRequest::STOP).expect("it stops");
    let stopped = loaded.state(CellState::STOPPED);
    assert!(stopped.stop_reason == "STOP was commanded" && stopped.holder.is_empty(), "{stopped:?}");
    assert!(mode(CellState::MANUAL).success);
    loaded.command(CellCommandRequest::RESET).expect("in every mode");
    loaded.state(CellState::IDLE);
    let refused = loaded.command(CellCommandRequest::START).expect_err("in manual mode nothing starts");
    assert!(refused.contains("START is not taken in manual mode"), "{refused}");
    let (goal, _) = loaded.cell.client.send("eccentric", &SHORT);
    assert!(!goal.accepted());
    assert!(!mode(9).success);
    // By hand: no part, then one, then START grinds it and it stays in the chuck.
    assert!(mode(CellState::SEMI_AUTOMATIC).success);
    let refused = loaded.command(CellCommandRequest::START).expect_err("the door is open");
    assert!(refused.contains("nothing may start: the door is not closed"), "{refused}");
    let wheel = loaded.cell.client.call::<SetBool>("axis_interpolator/wheel", &SetBoolRequest { data: true });
    assert!(wheel.message.contains("nothing may start: the door is not closed"), "{}", wheel.message);
    loaded.trigger("machine/place_part").expect("door and chuck are open");
    loaded.trigger("machine/close_chuck").expect("nothing moves");
    loaded.trigger("machine/close_door").expect("nobody is inside");
    loaded.area("that is closed", |area| area.may_move && area.part_present);
    let start = CellCommandRequest {
        command: CellCommandRequest::START,
        job: "eccentric".into(),
        overrides: Loaded::overrides(),
        parts: 5,
    };
    // The planner may hear of the closed door after this test.
    let deadline = Instant::now() + PATIENCE;
    loop {
        let answer = loaded.robot.command(&start).expect("an answer");
        if answer.success {
            break;
        }
        assert!(answer.message.contains("the door is not closed") && Instant::now() < deadline, "{}", answer.message);
    }
    let end = loaded.state(CellState::COMPLETE);
    assert_eq!((end.parts_wanted, end.parts_done), (1, 1), "one part, whatever was asked for");
    assert!(loaded.trigger("machine/open_chuck").expect_err("the door is closed").contains("the door is not open"));
    loaded.stop();
}

/// `~/run_job` as ever, and the cell follows it; a hold by another client is a hold of the cell.
#[test]
fn a_job_of_run_job_moves_the_state_of_a_cell_without_a_robot() {
    let cell = Cell::start(&[]);
    let (sender, states) = mpsc::channel();
    let qos = Qos::latched(1).keep_last(500);
    let _subscription = cell.client.node.subscribe("job_planner/cell_state", &qos, move |state: CellState, _| {
        drop(sender.send(state));
    });
    let until = |wanted: u8| loop {
        let state = states.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no state {wanted}"));
        if state.state == wanted {
            return state;
        }
    };
    let (goal, feedback) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    until(CellState::EXECUTE);
    while feedback.recv_timeout(PATIENCE).expect("feedback").phase_name != "cut" {}
    let hold = |hold: bool| {
        let answer = cell.client.call::<SetBool>("axis_interpolator/feed_hold", &SetBoolRequest { data: hold });
        assert!(answer.success, "{}", answer.message);
    };
    hold(true);
    until(CellState::HOLDING);
    assert_eq!(until(CellState::HELD).stop_reason, "the feed is held");
    hold(false);
    until(CellState::UNHOLDING);
    until(CellState::EXECUTE);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Succeeded);
    until(CellState::COMPLETING);
    let complete = until(CellState::COMPLETE);
    assert_eq!(complete.job, "eccentric");
    // A cancel is a stop, an alarm an abort; a reset from any client clears it.
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted());
    until(CellState::EXECUTE);
    let _accepted = goal.cancel(PATIENCE).expect("an answer");
    until(CellState::STOPPING);
    until(CellState::STOPPED);
    let _stopped = goal.result(PATIENCE).expect("a result");
    let estop = |data: bool| {
        let answer = cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data });
        assert!(answer.success);
    };
    estop(true);
    let aborted = until(CellState::ABORTED);
    assert_eq!((aborted.alarm, aborted.remedy.as_str()), (1, "release the emergency stop, then reset"));
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(!goal.accepted());
    estop(false);
    // The button is seen with the next tick.
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {}
    until(CellState::CLEARING);
    until(CellState::STOPPED);
    let (goal, _) = cell.client.send("eccentric", &SHORT);
    assert!(goal.accepted(), "{:?}", cell.client.statuses.try_iter().last());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    until(CellState::COMPLETE);
    cell.stop();
}

#[test]
fn a_robot_that_dies_outside_is_waited_for_and_one_that_dies_inside_is_an_alarm() {
    let loaded = Loaded::start(1.5);
    loaded.robot.be_silent(true);
    loaded.start_run(1);
    let waiting = loaded.robot.cell("it is missed", |cell| cell.substate.contains("no message on loader/state"));
    assert_eq!(waiting.expect("it waits").state, CellState::SUSPENDED);
    loaded.robot.be_silent(false);
    let request = loaded.robot.enter().expect("it comes back and is let in");
    assert_eq!(request, LoadingState::LOAD);
    loaded.robot.be_silent(true);
    loaded.alarm(155);
    let aborted = loaded.state(CellState::ABORTED);
    assert_eq!(aborted.alarm, 155);
    let state = loaded.robot.loading("a state", |loading| loading.request == LoadingState::NONE).expect("a state");
    assert!(state.robot_in_work_area && state.clear_to_enter, "the leave is not taken back over its head: {state:?}");
    let refused = loaded.command(CellCommandRequest::CLEAR).expect_err("it is still in there");
    assert!(refused.contains("a person is in the work area"), "{refused}");
    loaded.state(CellState::ABORTED);
    loaded.robot.be_silent(false);
    loaded.robot.leave().expect("it is brought out");
    loaded.command(CellCommandRequest::CLEAR).expect("nobody is inside");
    loaded.state(CellState::STOPPED);
    loaded.stop();
}

/// Every outcome that the sensors show otherwise than asked for: held with its reason, and tried again by UNHOLD.
#[test]
fn a_part_that_is_missing_or_still_there_holds_the_cell_until_it_is_tried_again() {
    let loaded = Loaded::start(10.0);
    let held = |words: &str| {
        let held = loaded.robot.cell(words, |cell| cell.state == CellState::HELD && cell.stop_reason.contains(words));
        assert!(held.expect("it is held").remedy.contains("UNHOLD"));
        loaded.command(CellCommandRequest::UNHOLD).expect("it is tried again");
    };
    loaded.start_run(1);
    // It leaves without having put anything in.
    assert_eq!(loaded.robot.enter(), Ok(LoadingState::LOAD));
    let refused = loaded.trigger("machine/close_door").expect_err("it would be locked in");
    assert!(refused.contains("a person is in the work area"), "{refused}");
    loaded.robot.leave().expect("it leaves");
    held("the part is missing after it was loaded");
    // It puts one in and forgets the chuck.
    assert_eq!(loaded.robot.enter(), Ok(LoadingState::LOAD));
    loaded.trigger("machine/place_part").expect("the chuck is open");
    loaded.robot.leave().expect("it leaves");
    loaded.robot.cell("", |cell| cell.stop_reason.contains("the chuck does not hold")).expect("it is held");
    loaded.trigger("machine/close_chuck").expect("somebody closes it");
    loaded.area("a closed chuck", |area| area.chuck == WorkArea::CLOSED);
    loaded.state(CellState::HELD);
    loaded.command(CellCommandRequest::UNHOLD).expect("the raw part is in: the door closes and its job begins");
    // The part is ground; the robot comes for it and leaves it there.
    assert_eq!(loaded.robot.enter(), Ok(LoadingState::UNLOAD));
    loaded.robot.leave().expect("it leaves");
    held("the part is still in the chuck after it was unloaded");
    let served = loaded.robot.tend().expect("the end of the run");
    assert_eq!(served, [LoadingState::UNLOAD]);
    let refused = loaded.trigger("job_planner/open_chuck").expect_err("nobody is inside");
    assert!(refused.contains("the cell is COMPLETE"), "{refused}");
    loaded.stop();
}

#[test]
fn a_door_or_a_chuck_that_sticks_is_an_alarm_and_the_run_is_over() {
    let loaded = Loaded::start(10.0);
    loaded.start_run(1);
    assert_eq!(loaded.robot.enter(), Ok(LoadingState::LOAD));
    loaded.trigger("machine/place_part").expect("the chuck is open");
    loaded.fault("chuck_stuck", true);
    let refused = loaded.trigger("job_planner/close_chuck").expect_err("it does not close");
    assert!(refused.contains("alarm 154"), "{refused}");
    assert_eq!(loaded.state(CellState::ABORTED).alarm, 154);
    loaded.fault("chuck_stuck", false);
    loaded.robot.leave().expect("it leaves");
    loaded.command(CellCommandRequest::CLEAR).expect("the chuck moves again");
    loaded.state(CellState::STOPPED);
    // The chuck went on to its end; the robot finds its part held, takes nothing in its place, and the door sticks.
    loaded.fault("door_stuck", true);
    let refused = loaded.trigger("machine/close_door");
    assert!(refused.is_ok(), "{refused:?}");
    loaded.alarm(153);
    let aborted = loaded.robot.cell("alarm 153", |cell| cell.alarm == 153).expect("aborted");
    assert!(aborted.remedy.contains("find what blocks the door"), "{}", aborted.remedy);
    loaded.stop();
}

#[test]
fn an_emergency_stop_in_the_handshake_ends_the_run_and_nothing_starts_before_clear_reset_and_start() {
    let loaded = Loaded::start(10.0);
    loaded.start_run(2);
    let request = loaded.robot.enter().expect("it is inside");
    let estop = |data: bool| {
        let answer = loaded.cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data });
        assert!(answer.success);
    };
    estop(true);
    assert_eq!(loaded.state(CellState::ABORTED).alarm, 1);
    let refused = loaded.robot.change_part(request).expect_err("the chuck does not obey");
    assert!(refused.contains("the cell is ABORTED"), "{refused}");
    assert!(loaded.command(CellCommandRequest::CLEAR).is_err(), "it is pressed, and somebody is inside");
    estop(false);
    loaded.robot.leave().expect("it leaves");
    loaded.command(CellCommandRequest::CLEAR).expect("released, nobody inside");
    let stopped = loaded.state(CellState::STOPPED);
    assert!(stopped.stop_reason.is_empty() && stopped.alarm == 0);
    assert!(loaded.command(CellCommandRequest::START).is_err(), "RESET comes first");
    let moves = |motion: InterpolatorState| motion.state == InterpolatorState::EXECUTING;
    assert!(!loaded.motions.try_iter().any(moves), "no reset moves anything");
    loaded.start_run(1);
    assert_eq!(loaded.robot.tend(), Ok(vec![LoadingState::LOAD, LoadingState::UNLOAD]));
    loaded.stop();
}

/// X out of the way of the robot, by hand; false: the goal is rejected.
fn out(loaded: &Loaded) -> bool {
    let goal = MoveToGoal { joints: vec!["x_axis".into()], positions: vec![0.13], ..MoveToGoal::default() };
    let client = loaded.cell.client.node.action_client::<MoveTo>("axis_interpolator/move_to").expect("a client");
    client.wait_for_server(PATIENCE).expect("move_to");
    let sent = client.send_goal(goal, drop, PATIENCE).expect("a decision");
    if !sent.accepted() {
        return false;
    }
    let (status, result) = sent.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    true
}

/// SUSPEND and UNSUSPEND of who is outside the cell; then the door is forced, then the chuck: the axes stop, and the run is over.
#[test]
fn a_run_is_suspended_by_command_and_ended_by_a_door_or_a_chuck_that_is_forced() {
    let loaded = Loaded::start(10.0);
    loaded.grind();
    loaded.command(CellCommandRequest::SUSPEND).expect("it is suspended");
    assert_eq!(loaded.state(CellState::SUSPENDED).stop_reason, "SUSPEND was commanded");
    loaded.command(CellCommandRequest::UNSUSPEND).expect("it goes on");
    loaded.state(CellState::EXECUTE);
    for (fault, alarm, remedy) in
        [("door_forced", 150, "find out who opened the door"), ("chuck_forced", 152, "inspect the part and the chuck")]
    {
        loaded.fault(fault, true);
        let aborted = loaded.state(CellState::ABORTED);
        assert_eq!(aborted.alarm, alarm, "{}", aborted.stop_reason);
        assert!(aborted.remedy.contains(remedy), "{}", aborted.remedy);
        loaded.cell.client.status("is the end", |status| status.state == JobStatus::ABORTED);
        loaded.fault(fault, false);
        // It has to be at rest, and nobody in the work area.
        while loaded.command(CellCommandRequest::CLEAR).is_err() {}
        loaded.state(CellState::STOPPED);
        if alarm == 150 {
            // The wheel stands near the part: out by hand, and only with the door closed.
            let log = LogLines::subscribe(&loaded.cell);
            assert!(!out(&loaded), "the door is open");
            log.line(&["axis_interpolator/move_to rejected: nothing may start: the door is not closed"]);
            loaded.trigger("machine/close_door").expect("nobody is inside");
            loaded.area("that is closed", |area| area.may_move);
            // The interpolator may hear of the door later than this test.
            let deadline = Instant::now() + PATIENCE;
            while !out(&loaded) {
                assert!(Instant::now() < deadline, "the door is closed and the goal rejected: see the log");
            }
            loaded.grind();
        }
    }
    loaded.stop();
}

#[test]
fn who_enters_without_leave_stops_the_machine() {
    let loaded = Loaded::start(10.0);
    loaded.grind();
    loaded.robot.signal(|signals| signals.in_work_area = true);
    loaded.alarm(151);
    let aborted = loaded.state(CellState::ABORTED);
    assert_eq!(aborted.alarm, 151, "{}", aborted.stop_reason);
    assert!(loaded.command(CellCommandRequest::CLEAR).is_err());
    loaded.area("a person inside", |area| area.entered);
    loaded.robot.signal(|signals| signals.in_work_area = false);
    loaded.robot.loading("nobody inside", |loading| !loading.robot_in_work_area).expect("it is seen");
    // The machine has a subscription of its own to the signals of the robot.
    loaded.area("a clear area", |area| !area.entered);
    loaded.command(CellCommandRequest::CLEAR).expect("it has left");
    // The part that was begun is exchanged, not ground on.
    loaded.start_run(1);
    let served = loaded.robot.tend().expect("the end of the run");
    assert_eq!(served, [LoadingState::EXCHANGE, LoadingState::UNLOAD]);
    loaded.stop();
}
