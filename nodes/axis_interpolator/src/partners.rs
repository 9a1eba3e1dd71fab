// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Looks after the machine and the planner: a motion ends when the machine falls silent or is started again, a plan when its planner does.

use super::goals::RunningGoal;
use super::{Shared, lock};
use camwright::interpolator::MotionRequest;
use camwright::machine::alarm::AlarmKind;
use camwright_ros::Guid;
use camwright_threads::silence::Silence;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Longest time for the pages of a plan to arrive after a goal that names it.
const PAGES: Duration = Duration::from_secs(10);

/// Topic of the machine's messages.
pub(super) const MACHINE_STREAM: &str = "machine/stream";
/// Topic of the planner's messages.
pub(super) const PLANNER_STATE: &str = "job_planner/cell_state";

/// A partner that has sent at least one message.
#[derive(Debug)]
struct Partner {
    participant: Guid,
    silence: Silence,
}

/// The partners of the interpolator.
#[derive(Debug)]
pub(super) struct InterpolatorPartners {
    limit: Duration,
    machine: Option<Partner>,
    planner: Option<Partner>,
    /// Who published the plan that is executed.
    plan_by: Option<Guid>,
    pages: Silence,
}

/// The participant of an endpoint.
fn participant(endpoint: Guid) -> Guid {
    let mut participant = endpoint;
    participant[12..].fill(0);
    participant
}

impl InterpolatorPartners {
    pub(super) fn new(limit: Duration) -> Self {
        Self { limit, machine: None, planner: None, plan_by: None, pages: Silence::new(PAGES) }
    }

    /// The machine is alive; true if another one was before.
    fn record_machine(&mut self, writer: Guid) -> bool {
        let participant = participant(writer);
        let is_other = self.machine.as_ref().is_some_and(|machine| machine.participant != participant);
        self.machine = Some(Partner { participant, silence: Silence::new(self.limit) });
        is_other
    }

    /// The planner is alive. It plans on threads of its own and sends a message once a second.
    fn record_planner(&mut self, writer: Guid) {
        self.planner = Some(Partner { participant: participant(writer), silence: Silence::new(2 * self.limit) });
    }

    fn silent_machine(&self) -> Option<String> {
        let machine = self.machine.as_ref().filter(|machine| machine.silence.is_lost())?;
        let limit_s = machine.silence.limit_s();
        Some(format!(
            "no message from the machine on {MACHINE_STREAM} for {limit_s} s: its node or the network is lost"
        ))
    }
}

impl Shared {
    /// Who sends `machine/stream`; another machine than before ends what is under way.
    pub(super) fn receive_machine(&self, writer: Guid) {
        let is_other = lock(&self.partners).record_machine(writer);
        if is_other {
            self.tick.store(0, Ordering::Release);
            self.lose_machine("the machine was started again: its axes have to be homed");
        }
    }

    pub(super) fn receive_planner(&self, writer: Guid) {
        lock(&self.partners).record_planner(writer);
    }

    /// Who published the pages of a plan.
    pub(super) fn receive_pages(&self, writer: Guid) {
        lock(&self.partners).plan_by = Some(participant(writer));
    }

    /// Why the machine takes no motion.
    pub(super) fn silent_machine(&self) -> Option<String> {
        lock(&self.partners).silent_machine()
    }

    /// Looks after all of them, ten times a second.
    pub(super) fn check_partners(&self) {
        let is_lost = lock(&self.partners).machine.as_mut().is_some_and(|machine| machine.silence.poll());
        if is_lost {
            let text = self.silent_machine().unwrap_or_default();
            self.lose_machine(&text);
        }
        self.check_planner();
        self.check_pages();
    }

    fn lose_machine(&self, text: &str) {
        self.refuse_arrival(text);
        {
            let mut served = lock(&self.served);
            if served.is_busy() {
                served.end_because(text);
                served.alarm = Some((AlarmKind::MachineLost.entry().number, text.to_owned()));
            }
        }
        lock(&self.held).take();
        self.node.logger().error(text);
        self.send(super::ToEngine::MachineLost);
    }

    fn check_planner(&self) {
        let lost = {
            let mut partners = lock(&self.partners);
            let plan_by = partners.plan_by;
            let planner = partners.planner.as_mut().filter(|planner| Some(planner.participant) == plan_by);
            planner.and_then(|planner| planner.silence.poll().then_some(planner.silence.limit_s()))
        };
        let Some(limit_s) = lost else { return };
        let mut served = lock(&self.served);
        if !matches!(served.goal(), Some(RunningGoal::Plan(_))) {
            return;
        }
        let text = format!(
            "no message from the job planner on {PLANNER_STATE} for {limit_s} s, its node or the network is lost: its plan is cancelled"
        );
        served.alarm = Some((AlarmKind::PlannerLost.entry().number, text.clone()));
        drop(served);
        self.node.logger().error(&text);
        self.request(MotionRequest::Cancel);
    }

    /// A goal whose plan does not arrive is refused.
    fn check_pages(&self) {
        let waits = lock(&self.plans).waiting().is_some();
        let is_late = {
            let mut partners = lock(&self.partners);
            if !waits {
                partners.pages.reset();
            }
            partners.pages.poll()
        };
        if waits && is_late {
            lock(&self.plans).forget_waiting();
            lock(&self.served).refuse(&format!("the pages of its plan did not arrive within {} s", PAGES.as_secs()));
        }
    }
}
