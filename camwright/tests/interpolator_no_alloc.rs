//! The cyclic path does not allocate: a whole job with a hold, an override and a cancel under an allocator that aborts.

#[path = "interpolator/bench.rs"]
#[allow(dead_code, clippy::cast_possible_truncation, clippy::float_cmp, reason = "shared with the other tests")]
mod bench;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use bench::{ORIGIN, SWITCH, machine, two_cuts, whole_job};
use camwright::interpolator::{Event, Interpolator, Motion, Outcome, Prepared, Request, TickInputs};
use camwright::job::SpeedLaw;
use camwright::machine::description::Axis;
use camwright::setpoint::{Input, Latch, StopPoint};
use std::sync::Arc;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn neither_a_step_nor_a_stop_nor_feedback_allocates() {
    let machine = machine();
    let whole = (whole_job(&machine, 6.0), [0; 3], false);
    let (turning_on, start) = two_cuts(&machine, SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 });
    for ((plan, start, homed), cancel_at) in
        [(whole.clone(), 0), (whole, 5_500), ((turning_on.clone(), start, true), 0), ((turning_on, start, true), 5_500)]
    {
        let prepared = Box::new(Prepared::new(Motion::Plan(Arc::new(plan)), &machine).expect("good plan"));
        let mut interpolator = Interpolator::new(&machine);
        interpolator.resync(start);
        interpolator.set_homed(Axis::C, homed);
        let mut tail = [StopPoint::default(); 32];
        let outcome = assert_no_alloc(|| {
            if interpolator.start(prepared).is_err() {
                return None;
            }
            let mut before = start;
            for tick in 0..40_000_u64 {
                let requests: &[Request] = match tick {
                    300 | 5_000 => &[Request::Hold],
                    600 | 6_200 => &[Request::Unhold],
                    5_100 => &[Request::SetOverride(0.5)],
                    _ if tick == cancel_at && tick > 0 => &[Request::Cancel],
                    _ => &[],
                };
                let out = interpolator.step(&TickInputs { tick, requests });
                interpolator.stop_tail(&mut tail);
                let now = out.setpoint.counts;
                let edge = |axis: Axis, at: i64| before[axis.index()] < at && now[axis.index()] >= at;
                if edge(Axis::C, ORIGIN) {
                    let (input, axis) = (Input::Origin, Axis::C);
                    interpolator.feedback(&Latch { tick, input, rising: true, axis, counts: ORIGIN });
                }
                if edge(Axis::Z, SWITCH) {
                    let (input, axis) = (Input::Station(0), Axis::Z);
                    interpolator.feedback(&Latch { tick, input, rising: true, axis, counts: SWITCH });
                }
                before = now;
                for event in out.events.iter() {
                    if let Event::Finished(outcome) = event {
                        return Some(*outcome);
                    }
                }
            }
            None
        });
        let expected = if cancel_at > 0 { Outcome::Cancelled } else { Outcome::Completed };
        assert_eq!(outcome, Some(expected));
    }
}
