// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stops: over a hard limit switch, and by the emergency stop.

use super::asker::{Asker, DISCOVERY, between_ns, now_ns};
use super::cell::{MachineMessage, PATIENCE, Watch};
use super::figures::Row;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, MoveTo, MoveToGoal};
use camwright_msgs::camwright_msgs::msg::{MachineIo, MachineStream};
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_ros::{ActionClient, Client, ClientGoal, GoalStatus};
use std::time::{Duration, Instant};

/// Shares of the wheelhead's speed at which it meets the switch: 100, 250 and 500 mm/s.
pub const SPEEDS: [(f64, &str); 3] = [(0.2, "100 mm/s"), (0.5, "250 mm/s"), (1.0, "500 mm/s")];
/// Error of the wheelhead's encoder (m): with it the hard limit switch, at 182 mm, comes within the soft limits, and an ordinary move
/// runs over it.
const MISREAD_M: f64 = -0.020;
/// Its reading at the switch (m).
const SWITCH_M: f64 = 0.182 + MISREAD_M;
/// From where to where it goes (m): it has its speed at the switch, and has not begun to brake there.
const FROM_M: f64 = SWITCH_M - 0.028;
const TO_M: f64 = SWITCH_M + 0.0175;
/// Share of the speed at the edge that the axis must have lost to count as braking.
const LOST_SHARE: f64 = 0.99;
/// The e-stop comes this long after the axes have begun to move, at most.
const LATEST: Duration = Duration::from_millis(150);

/// Numbers of the alarms of both stops.
const OVERTRAVEL: u16 = 12;
const ESTOP: u16 = 1;

/// Velocities of a tick and their publication time.
struct Tick {
    number: u64,
    published_ns: i64,
    velocity: [f64; 3],
}

/// Stop, from the tick of its cause on.
struct Stop {
    /// Tick of the cause, and its publication time.
    cause: (u64, i64),
    /// From there on.
    ticks: Vec<Tick>,
}

pub struct Operator {
    moves: ActionClient<MoveTo>,
    homes: ActionClient<Home>,
    estop: Client<SetBool>,
    reset: Client<Trigger>,
    inject: Client<InjectFault>,
}

fn ms(ticks: u64) -> Duration {
    Duration::from_millis(ticks)
}

impl Operator {
    pub fn new(asker: &Asker) -> Self {
        let moves = asker.node.action_client("axis_interpolator/move_to").expect("a client");
        let estop = asker.node.client("machine/estop").expect("a client");
        let reset = asker.node.client("machine/reset").expect("a client");
        let inject = asker.node.client("machine/inject_fault").expect("a client");
        inject.wait_for_service(DISCOVERY).expect("the machine");
        let homes = asker.node.action_client("axis_interpolator/home").expect("a client");
        homes.wait_for_server(DISCOVERY).expect("the interpolator");
        moves.wait_for_server(DISCOVERY).expect("the interpolator");
        estop.wait_for_service(DISCOVERY).expect("the machine");
        reset.wait_for_service(DISCOVERY).expect("the machine");
        Self { moves, homes, estop, reset, inject }
    }

    /// Begins a move; it is tried again while the interpolator has not heard that the machine is well again.
    fn begin(&self, targets: &[(&str, f64)], speed_factor: f64) -> ClientGoal<MoveTo> {
        let goal = MoveToGoal {
            joints: targets.iter().map(|(joint, _)| (*joint).to_owned()).collect(),
            positions: targets.iter().map(|(_, position)| *position).collect(),
            relative: false,
            speed_factor,
        };
        let deadline = Instant::now() + PATIENCE;
        loop {
            let sent = self.moves.send_goal(goal.clone(), |_| {}, PATIENCE).expect("a decision");
            if sent.accepted() {
                return sent;
            }
            assert!(Instant::now() < deadline, "the interpolator accepts no move");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Finds the zeros of the axes that need it.
    fn home(&self) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let sent = self.homes.send_goal(HomeGoal::default(), |_| {}, PATIENCE).expect("a decision");
            let (status, result) = sent.result(PATIENCE).expect("homing ends");
            if status == GoalStatus::Succeeded {
                return;
            }
            // The interpolator has still to hear that the alarms are gone.
            assert!(Instant::now() < deadline, "no homing: {}", result.message);
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// A move to its end.
    fn go(&self, targets: &[(&str, f64)]) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let (status, result) = self.begin(targets, 1.0).result(PATIENCE).expect("the move ends");
            if status == GoalStatus::Succeeded {
                return;
            }
            assert!(Instant::now() < deadline, "no move to {targets:?}: {}", result.message);
            // It has still to hear of the last reset, or an alarm ended the move; a machine that is well is not changed by one more.
            let _refused_or_not = self.reset.call(&TriggerRequest::default(), PATIENCE);
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn press(&self, pressed: bool) {
        self.estop.call(&SetBoolRequest { data: pressed }, PATIENCE).expect("the machine answers");
    }

    /// Makes the encoder of the wheelhead misread, while it has no power: else its drive would jump.
    fn mislead(&self, watch: &Watch) {
        self.press(true);
        watch.stream(|stream| matches!(stream.motion, MachineStream::MOTION_OFF | MachineStream::MOTION_FAULT));
        let request = InjectFaultRequest {
            fault: "encoder_offset".into(),
            target: "x_axis".into(),
            value: MISREAD_M,
            active: true,
            job_tick: 0,
        };
        let answer = self.inject.call(&request, PATIENCE).expect("the machine answers");
        assert!(answer.success, "{}", answer.message);
        // The jump of the reading is an alarm of its own, which is to be there before it is cleared.
        watch.stream(|stream| stream.alarms.len() > 1);
        self.press(false);
        self.reset();
    }

    /// Clears the alarms once the machine lets it.
    fn reset(&self) {
        let deadline = Instant::now() + PATIENCE;
        while !self.reset.call(&TriggerRequest::default(), PATIENCE).expect("the machine answers").success {
            assert!(Instant::now() < deadline, "the machine cannot be reset");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Hears the machine until every axis stands after a cause that its inputs show and that raises this alarm. `None` if another alarm was
/// first: on a computer that is busy otherwise setpoints may come too late.
fn stop_of(watch: &Watch, alarm: u16, is_cause: impl Fn(&MachineIo) -> bool) -> Option<Stop> {
    let deadline = Instant::now() + PATIENCE;
    let mut cause = None;
    let mut ticks: Vec<Tick> = Vec::new();
    let mut disturbed = false;
    loop {
        match watch.next() {
            MachineMessage::Io { tick, published_ns, io } if cause.is_none() && is_cause(&io) => {
                cause = Some((tick, published_ns));
            }
            MachineMessage::Joints { tick, published_ns, velocity } => {
                ticks.push(Tick { number: tick, published_ns, velocity });
            }
            MachineMessage::Stream { stream, .. } => {
                disturbed |= stream.alarms.iter().any(|number| *number != alarm);
                if disturbed && matches!(stream.motion, MachineStream::MOTION_FAULT | MachineStream::MOTION_OFF) {
                    eprintln!("a stop is not counted: alarms {:?}", stream.alarms);
                    return None;
                }
            }
            MachineMessage::Io { .. } => {}
        }
        let last = ticks.last().filter(|tick| stands(tick.velocity)).map(|tick| tick.number);
        if let Some(cause) = cause.filter(|(tick, _)| !disturbed && last.is_some_and(|last| last > *tick)) {
            ticks.retain(|tick| tick.number >= cause.0);
            return Some(Stop { cause, ticks });
        }
        assert!(Instant::now() < deadline, "the axes do not come to rest");
    }
}

/// A clamped axis has no velocity at all.
fn stands(velocity: [f64; 3]) -> bool {
    velocity.iter().all(|velocity| velocity.abs() < f64::MIN_POSITIVE)
}

impl Stop {
    /// The tick of rest.
    fn rest(&self) -> &Tick {
        self.ticks.last().expect("it ended with one")
    }

    /// Ticks from the cause until an axis (X) has lost speed.
    fn reaction_ticks(&self) -> u64 {
        let at_edge = self.ticks.first().map_or(0.0, |tick| tick.velocity[1].abs());
        let slower = self.ticks.iter().find(|tick| tick.velocity[1].abs() < LOST_SHARE * at_edge);
        slower.map_or(0, |tick| tick.number - self.cause.0)
    }
}

/// The wheelhead runs over its switch: rows of reaction, braking and both for each speed.
pub fn limits_and_estops(asker: &mut Asker, watch: &Watch, limits: &mut [Row], estops: &mut [Row]) {
    let operator = Operator::new(asker);
    let mut there = false;
    operator.mislead(watch);
    operator.home();
    operator.go(&[("x_axis", FROM_M)]);
    for round in 0.. {
        if !asker.goes_on() || estops[0].times.len() >= estops[0].wanted && limits.iter().all(Row::is_complete) {
            return;
        }
        let rows = &mut limits[3 * (round % SPEEDS.len())..][..3];
        if !rows[0].is_complete() {
            watch.catch_up();
            let over = operator.begin(&[("x_axis", TO_M)], SPEEDS[round % SPEEDS.len()].0);
            if let Some(stop) = stop_of(watch, OVERTRAVEL, |io| io.overtravel_x_max) {
                let whole = stop.rest().number - stop.cause.0;
                let reaction = stop.reaction_ticks();
                for (row, ticks) in rows.iter_mut().zip([reaction, whole - reaction, whole]) {
                    row.times.push(ms(ticks));
                }
            }
            let _aborted = over.result(PATIENCE).expect("the move ends");
            operator.reset();
            // Also shows that the interpolator has received the reset.
            operator.go(&[("x_axis", FROM_M)]);
        }
        if estops[0].times.len() < estops[0].wanted {
            there = !there;
            press_once(asker, watch, &operator, there, estops);
            operator.go(&[("x_axis", FROM_M)]);
        }
    }
}

/// All axes move when the e-stop is pressed.
fn press_once(asker: &mut Asker, watch: &Watch, operator: &Operator, there: bool, rows: &mut [Row]) {
    watch.catch_up();
    let (z, c) = if there { (0.08, 4.0) } else { (0.0, 0.0) };
    let travel = operator.begin(&[("x_axis", if there { 0.06 } else { FROM_M }), ("z_axis", z), ("c_axis", c)], 1.0);
    wait_for_motion(watch);
    std::thread::sleep(asker.dice.below(LATEST));
    let (asked_ns, asked) = (now_ns(), Instant::now());
    operator.press(true);
    let answered = asked.elapsed();
    if let Some(stop) = stop_of(watch, ESTOP, |io| io.estop) {
        let reaction = between_ns(asked_ns, stop.cause.1);
        let braking = ms(stop.rest().number - stop.cause.0);
        let whole = between_ns(asked_ns, stop.rest().published_ns);
        for (row, time) in rows.iter_mut().zip([answered, reaction, braking, whole]) {
            row.times.push(time);
        }
    }
    let _aborted = travel.result(PATIENCE).expect("the move ends");
    operator.press(false);
    operator.reset();
}

fn wait_for_motion(watch: &Watch) {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let MachineMessage::Joints { velocity, .. } = watch.next()
            && !stands(velocity)
        {
            return;
        }
        assert!(Instant::now() < deadline, "nothing moves");
    }
}
