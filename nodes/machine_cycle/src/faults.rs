// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Faults on their way to the machine: those of now, and those that wait for their tick of a job.

use super::messages::AskedFault;
use camwright::machine::description::MachineDescription;
use camwright::math::fixed_list::FixedList;
use camwright::simulation::fault::{Fault, FaultError};
use camwright_msgs::camwright_msgs::srv::InjectFaultRequest;

/// Faults of one tick; more wait for the next.
const AT_ONCE: usize = 8;
/// Faults that may wait for their tick of a job.
const WAITING: usize = 32;

/// Faults in fixed room, for the cyclic thread.
#[derive(Debug)]
pub struct Faults {
    now: [Option<Fault>; AT_ONCE],
    /// Faults by their tick of the next job, its first being 1.
    of_next_job: [Option<(u64, Fault)>; WAITING],
    /// Faults by their tick, of the running job.
    timed: [Option<(u64, Fault)>; WAITING],
}

camwright::snapshot!(Faults { now, of_next_job, timed } on {});

impl Default for Faults {
    fn default() -> Self {
        Self { now: [None; AT_ONCE], of_next_job: [None; WAITING], timed: [None; WAITING] }
    }
}

/// Faults of one tick.
type Due = FixedList<Fault, AT_ONCE>;

impl Faults {
    /// A fault for now (0), or for a tick of the next job. What finds no room is dropped: nobody asks for so many.
    pub fn add(&mut self, fault: Fault, job_tick: u64) {
        if job_tick == 0 {
            if let Some(place) = self.now.iter_mut().find(|place| place.is_none()) {
                *place = Some(fault);
            }
        } else if let Some(place) = self.of_next_job.iter_mut().find(|place| place.is_none()) {
            *place = Some((job_tick, fault));
        }
    }

    /// A job begins with this tick.
    pub fn begin_job(&mut self, tick: u64) {
        let of_job = std::mem::replace(&mut self.of_next_job, [None; WAITING]);
        self.timed = of_job.map(|fault| fault.map(|(job_tick, fault)| (tick + job_tick - 1, fault)));
    }

    /// The job is over; what has not struck in it does not.
    pub fn end_job(&mut self) {
        self.timed = [None; WAITING];
    }

    /// Those that strike with this tick.
    pub fn due(&mut self, tick: u64) -> Due {
        let mut due = Due::new();
        for fault in self.now.iter_mut().filter_map(Option::take) {
            due.push(fault);
        }
        for place in self.timed.iter_mut().filter(|timed| timed.is_some_and(|(at, _)| at <= tick)) {
            if !due.is_full()
                && let Some((_, fault)) = place.take()
            {
                due.push(fault);
            }
        }
        due
    }
}

/// The fault that is asked for.
pub fn asked_fault(request: InjectFaultRequest, machine: &MachineDescription) -> Result<AskedFault, FaultError> {
    let value = camwright_files::convert::fault_value(&request.fault, &request.target, request.value);
    let fault = Fault::from_name(&request.fault, &request.target, value, request.active, machine)?;
    Ok(AskedFault { fault, job_tick: request.job_tick, request })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_strikes_now_or_at_its_tick_of_the_next_job_only() {
        let mut faults = Faults::default();
        faults.add(Fault::EStop(true), 0);
        faults.add(Fault::WheelStall(true), 5);
        faults.add(Fault::PowerLoss(true), 9);
        assert_eq!(faults.due(100).to_vec(), [Fault::EStop(true)]);
        assert!(faults.due(5).is_empty(), "no job has begun");
        faults.begin_job(200);
        assert!(faults.due(203).is_empty());
        assert_eq!(faults.due(204).to_vec(), [Fault::WheelStall(true)]);
        faults.end_job();
        faults.begin_job(300);
        assert!(faults.due(400).is_empty(), "those of the job before do not strike in the next");
    }

    #[test]
    fn what_finds_no_place_in_a_tick_comes_with_the_next() {
        let mut faults = Faults::default();
        for _ in 0..12 {
            faults.add(Fault::EStop(true), 1);
        }
        faults.begin_job(10);
        assert_eq!((faults.due(10).len(), faults.due(11).len(), faults.due(12).len()), (8, 4, 0));
    }
}
