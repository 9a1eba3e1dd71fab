// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The interpolator with the simulated machine: nothing it sends is implausible, and the zero it finds is the true one.

use super::bench::{PER_MM, SAFE_X, TURN, TestNoise, machine, whole_job};
use camwright::interpolator::{
    Interpolator, InterpolatorEvent, Motion, MotionOutcome, MotionRequest, Order, OrderKind, Prepared, TickInputs,
};
use camwright::machine::description::Axis;
use camwright::machine::persistent_state::PersistentState;
use camwright::math::units::rad_from_deg;
use camwright::simulation::{Machine, MachineCommand};
use std::sync::Arc;

/// Runs a motion on a machine that powers up with C at 217.3 degrees, with requests at given ticks.
fn run(motion: Motion, requests: &[(u64, MotionRequest)]) -> (MotionOutcome, Vec<Order>, Machine) {
    let mut description = machine();
    description.axes[0].power_up_position = rad_from_deg(217.3);
    let mut interpolator = Interpolator::new(&description);
    let prepared = Prepared::new(motion, &description).unwrap_or_else(|error| panic!("{error}"));
    let lasting = PersistentState::new(&description);
    let mut machine = Machine::new(description, lasting).expect("a machine");
    interpolator.start(Box::new(prepared)).unwrap_or_else(|(error, _)| panic!("{error}"));
    let mut orders: Vec<Order> = Vec::new();
    for tick in 1..60_000 {
        let now: Vec<MotionRequest> =
            requests.iter().filter(|(at, _)| *at == tick).map(|(_, request)| *request).collect();
        let out = interpolator.step(&TickInputs { tick, requests: &now });
        let commands: Vec<MachineCommand> =
            orders.iter().filter(|order| order.tick == tick).map(|order| order.kind.into()).collect();
        orders.extend(out.orders.iter().copied());
        let report = machine.step(Some(&out.setpoint), &commands, &[]);
        assert_eq!(report.tick, tick);
        assert!(report.raised.iter().next().is_none(), "{requests:?} tick {tick}: {:?}", report.raised.first());
        for latch in report.latches.iter() {
            assert!(interpolator.feedback(latch));
        }
        for event in out.events.iter() {
            if let InterpolatorEvent::Finished(outcome) = event {
                return (*outcome, orders, machine);
            }
        }
    }
    panic!("not finished");
}

/// The encoder reads 0 where the headstock stands at 217.3 degrees; the keyway faces the wheel 142.7 degrees on.
#[test]
fn homing_finds_the_machines_own_zero() {
    let (outcome, orders, machine) = run(Motion::Home(vec![Axis::C]), &[]);
    assert_eq!(outcome, MotionOutcome::Completed);
    let counts = i64::from(1427) * TURN / 3600;
    assert_eq!(orders[1].kind, OrderKind::SetHome { axis: Axis::C, counts });
    assert_eq!(machine.setpoint().counts[0], 0);
}

/// With ordinary drives, through holds and overrides: the machine, which checks every setpoint, has nothing to say.
#[test]
fn nothing_that_is_sent_is_implausible_to_the_machine() {
    let description = machine();
    let plan = Arc::new(whole_job(&description, 6.0));
    let seed = 12;
    let mut random = TestNoise(seed);
    for case in 0..8 {
        let mut requests = Vec::new();
        let mut at = 0;
        for _ in 0..12 {
            at += 1 + random.below(1400);
            requests.push((at, MotionRequest::SetOverride(0.3 + 0.7 * random.next())));
            requests.push((at + random.below(300), MotionRequest::Hold));
            at += 300 + random.below(900);
            requests.push((at, MotionRequest::Unhold));
        }
        let (outcome, _, machine) = run(Motion::Plan(plan.clone()), &requests);
        assert_eq!(outcome, MotionOutcome::Completed, "seed {seed} case {case}");
        let counts = machine.setpoint().counts;
        assert_eq!((counts[0].rem_euclid(TURN), counts[1], counts[2]), (0, SAFE_X, 50 * PER_MM));
    }
}
