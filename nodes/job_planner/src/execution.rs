// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Common parts of all running jobs: the client, the execution of plans by the interpolator, the end.

use super::job_slot::{JobEvent, JobSlot};
use super::lobe_ticks::LobeTicks;
use super::partners::Identity;
use super::plan_progress::PlanProgress;
use super::request_origin::{self, RequestOrigin};
use super::{Shared, lock};
use camwright::machine::alarm::AlarmKind;
use camwright_files::convert::plan::{phase_from, phase_name};
use camwright_files::fault_file::JobFault;
use camwright_msgs::camwright_msgs::action::{
    ExecutePlan, ExecutePlanFeedback, ExecutePlanGoal, ExecutePlanResult, RunJobFeedback, RunJobResult,
};
use camwright_msgs::camwright_msgs::msg::{JobStatus, JournalStiffness, PlanPage};
use camwright_msgs::camwright_msgs::srv::{IdentifyStiffnessResponse, InjectFaultRequest};
use camwright_planning::AnyPrepared;
use camwright_ros::{ClientGoal, GoalStatus};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// Maximum time of a peer's answer.
pub(super) const ANSWER: Duration = Duration::from_secs(10);
/// Maximum time for coming to rest after a cancel.
const STOPPING: Duration = Duration::from_secs(60);
/// Period of the check for the interpolator during execution.
const WATCH: Duration = Duration::from_millis(200);
/// Maximum absence of the interpolator: longer than a discovery hiccup.
const OUT_OF_SIGHT: Duration = Duration::from_secs(5);

/// Reason for the early end of a job.
pub(super) enum JobFailure {
    Cancelled(String),
    /// It could not go on.
    Failed(String),
}

impl JobFailure {
    /// It could not go on, and nothing has moved yet.
    pub(super) fn still(reason: &str) -> Self {
        Self::Failed(format!("{reason}; nothing moved"))
    }
}

/// Share of a plan in a job (s, predicted).
#[derive(Debug, Clone, Copy)]
pub(super) struct PlanShare {
    pub(super) done_s: f64,
    pub(super) own_s: f64,
    pub(super) whole_s: f64,
}

/// A job in execution.
pub(super) struct Execution {
    pub(super) shared: Arc<Shared>,
    asker: RequestOrigin,
    /// Name of the job.
    name: String,
    /// Names of what it makes one after the other: its lobes.
    lobes: Vec<String>,
    faults: Vec<JobFault>,
    cycle_time_s: f64,
    /// First tick of the first of its plans, once that has ended.
    first_tick: Option<u64>,
    events: mpsc::Sender<JobEvent>,
    inbox: mpsc::Receiver<JobEvent>,
    pub(super) times: Arc<Mutex<LobeTicks>>,
    /// Progress of the plan in execution.
    pub(super) progress: Arc<Mutex<PlanProgress>>,
}

impl Execution {
    pub(super) fn new(
        shared: Arc<Shared>,
        prepared: &AnyPrepared,
        asker: RequestOrigin,
        events: mpsc::Sender<JobEvent>,
        inbox: mpsc::Receiver<JobEvent>,
    ) -> Self {
        Self {
            shared,
            asker,
            name: prepared.name().to_owned(),
            lobes: prepared.lobes().to_vec(),
            faults: prepared.faults().to_vec(),
            cycle_time_s: prepared.machine().cycle_time_s(),
            first_tick: None,
            events,
            inbox,
            times: Arc::default(),
            progress: Arc::default(),
        }
    }

    /// Publishes the end of the job; the slot is idle again when it returns. `journals` holds the measurements for clients that requested
    /// stiffness.
    pub(super) fn end(
        self,
        outcome: Result<(), JobFailure>,
        mut result: RunJobResult,
        journals: Vec<JournalStiffness>,
    ) {
        let (logger, name) = (self.shared.node.logger(), &self.name);
        // Idle before the client hears of the end: it may send the next goal at once.
        *lock(&self.shared.job_slot) = JobSlot::Idle;
        let state = match outcome {
            Ok(()) => {
                logger.info(&format!("job {name} complete: {}", result.message));
                JobStatus::COMPLETE
            }
            Err(JobFailure::Cancelled(message)) => {
                result.message = self.explained(message, &result);
                logger.warn(&format!("job {name} stopped: {}", result.message));
                JobStatus::STOPPED
            }
            Err(JobFailure::Failed(message)) => {
                // An alarm of the machine is the cause, wherever the job noticed that it cannot go on.
                if let (0, Some(alarm)) = (result.alarm, self.shared.stopping_alarm()) {
                    result.alarm = alarm.number;
                }
                result.message = self.explained(message, &result);
                logger.error(&format!("job {name} aborted: {}", result.message));
                JobStatus::ABORTED
            }
        };
        self.shared.board.ended(state, &result);
        match (self.asker, state) {
            (RequestOrigin::Goal(goal), JobStatus::COMPLETE) => drop(goal.succeed(result)),
            (RequestOrigin::Goal(goal), JobStatus::STOPPED) => drop(goal.canceled(result)),
            (RequestOrigin::Goal(goal), _) => drop(goal.abort(result)),
            (RequestOrigin::Cell, _) => {}
            (RequestOrigin::Stiffness(waiting), _) => {
                let success = state == JobStatus::COMPLETE && journals.len() == result.lobes.len();
                let message = result.message;
                request_origin::answer(&waiting, &IdentifyStiffnessResponse { success, message, journals });
            }
        }
    }

    /// Message of a job that did not come to its end: with text and remedy of its alarm, and the lobes that are finished.
    fn explained(&self, message: String, result: &RunJobResult) -> String {
        let mut text = message;
        let mut add = |part: &str| {
            if !text.contains(part) {
                text = format!("{text}; {part}");
            }
        };
        if result.alarm != 0 {
            let raised = self.shared.alarm(result.alarm).map(|alarm| (alarm.text, alarm.remedy));
            let of_kind = || {
                let entry = AlarmKind::from_number(result.alarm)?.entry();
                Some((entry.name.to_owned(), entry.remedy.to_owned()))
            };
            if let Some((cause, remedy)) = raised.or_else(of_kind) {
                add(&cause);
                add(&format!("remedy: {remedy}"));
            }
        }
        if !result.lobes.is_empty() {
            let names: Vec<&str> = result.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
            add(&format!("finished: {} of {} lobes ({})", names.len(), self.lobes.len(), names.join(", ")));
        }
        text
    }

    /// Writes into the result of the job how one of its plans ended; nothing follows one that did not come to its end.
    pub(super) fn note(
        &mut self,
        result: &mut RunJobResult,
        (status, ended): (GoalStatus, ExecutePlanResult),
    ) -> Result<(), JobFailure> {
        result.first_tick = *self.first_tick.get_or_insert(ended.first_tick);
        (result.alarm, result.last_tick) = (ended.alarm, ended.last_tick);
        result.duration = self.seconds(result.last_tick.saturating_sub(result.first_tick));
        result.duration_with_indexing = result.duration;
        match status {
            GoalStatus::Succeeded => Ok(()),
            GoalStatus::Canceled => Err(JobFailure::Cancelled(ended.message)),
            _ => Err(JobFailure::Failed(ended.message)),
        }
    }

    /// Sends the pages of a plan.
    pub(super) fn publish(&self, pages: &[PlanPage]) -> Result<(), JobFailure> {
        pages
            .iter()
            .try_for_each(|page| self.shared.plan.publish(page))
            .map_err(|error| JobFailure::still(&error.to_string()))
    }

    /// Machine time of so many ticks (s).
    pub(super) fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 * self.cycle_time_s
    }

    /// Returns whether a client cancelled the job before anything moved.
    pub(super) fn is_cancelled(&self) -> bool {
        matches!(self.inbox.try_recv(), Ok(JobEvent::Cancel))
    }

    /// Hands the faults of the job to the machine, which strikes with them at their ticks.
    pub(super) fn arm_faults(&self) -> Result<(), JobFailure> {
        for fault in &self.faults {
            let request = InjectFaultRequest {
                fault: fault.kind.clone(),
                target: fault.target.clone(),
                value: fault.value,
                active: true,
                job_tick: fault.job_tick,
            };
            let answer = self
                .shared
                .inject_fault
                .call(&request, ANSWER)
                .map_err(|error| JobFailure::still(&error.to_string()))?;
            if !answer.success {
                return Err(JobFailure::still(&format!("the fault {} cannot be set: {}", fault.kind, answer.message)));
            }
        }
        Ok(())
    }

    /// Hands a plan to the interpolator and waits for its end.
    pub(super) fn execute(
        &self,
        plan_hash: &str,
        share: PlanShare,
    ) -> Result<(GoalStatus, ExecutePlanResult), JobFailure> {
        if self.is_cancelled() {
            return Err(JobFailure::Cancelled("cancelled before anything moved".into()));
        }
        self.shared.cell.wait_for_interpolator(ANSWER).map_err(JobFailure::still)?;
        let interpolator = self.shared.interpolator.identity();
        let wanted = ExecutePlanGoal {
            plan_hash: plan_hash.to_owned(),
            client: format!("{}, job {}", self.shared.node.fully_qualified_name(), self.name),
        };
        let sent = self.shared.execute.send_goal(wanted, self.feedback(share), ANSWER);
        let plan = sent.map_err(|error| JobFailure::still(&error.to_string()))?;
        if !plan.accepted() {
            // An alarm between the decision on the job and this goal.
            if let Some(alarm) = self.shared.stopping_alarm() {
                let message = format!("alarm {} stops the machine: {}; nothing moved", alarm.number, alarm.text);
                let ended = ExecutePlanResult { alarm: alarm.number, message, ..ExecutePlanResult::default() };
                return Ok((GoalStatus::Aborted, ended));
            }
            return Err(JobFailure::still("the axis interpolator rejected the plan; its log shows the reason"));
        }
        let events = self.events.clone();
        plan.result_with(move |status, result| drop(events.send(JobEvent::Ended(status, result))))
            .map_err(|error| JobFailure::Failed(error.to_string()))?;
        self.wait(&plan, interpolator)
    }

    fn wait(
        &self,
        plan: &ClientGoal<ExecutePlan>,
        interpolator: Identity,
    ) -> Result<(GoalStatus, ExecutePlanResult), JobFailure> {
        let mut give_up: Option<Instant> = None;
        let mut seen = Instant::now();
        let mut alarmed: Option<Instant> = None;
        loop {
            match self.inbox.recv_timeout(WATCH) {
                Ok(JobEvent::Ended(status, result)) => return Ok((status, result)),
                Ok(JobEvent::Cancel) if give_up.is_none() => {
                    give_up = Some(Instant::now() + STOPPING);
                    self.shared.board.stopping();
                    plan.cancel_with(|_| {}).map_err(|error| JobFailure::Failed(error.to_string()))?;
                }
                Ok(JobEvent::Cancel) => {}
                Err(_) => {
                    if self.shared.execute.is_ready() {
                        seen = Instant::now();
                    }
                    if seen.elapsed() > OUT_OF_SIGHT {
                        return Err(JobFailure::Failed(
                            "the axis interpolator has left; the machine stops on the path by itself".into(),
                        ));
                    }
                    // DDS takes most of a minute to miss a node that died; an interpolator that lives ends a job with the alarm.
                    let stopped = self.shared.stopping_alarm();
                    alarmed = stopped.as_ref().map(|_| alarmed.unwrap_or_else(Instant::now));
                    if let (Some(alarm), Some(_)) = (&stopped, alarmed.filter(|since| since.elapsed() > OUT_OF_SIGHT)) {
                        return Ok(without_interpolator(alarm.number, &alarm.text));
                    }
                    if let Err(reason) = self.shared.interpolator.check(interpolator, stopped.is_some()) {
                        // It arrives once the connection is back, where one direction alone was lost.
                        let _gone_or_asked = plan.cancel_with(drop);
                        return Ok(match stopped {
                            Some(alarm) => without_interpolator(alarm.number, &alarm.text),
                            None => {
                                let message = format!("{reason}; the axes come to rest on the path by themselves");
                                let alarm = AlarmKind::PlannerLost.entry().number;
                                let ended = ExecutePlanResult { alarm, message, ..ExecutePlanResult::default() };
                                (GoalStatus::Aborted, ended)
                            }
                        });
                    }
                }
            }
            if give_up.is_some_and(|end| Instant::now() > end) {
                let message = format!("cancelled, but the axes did not come to rest within {} s", STOPPING.as_secs());
                return Err(JobFailure::Failed(message));
            }
        }
    }

    /// Passes the interpolator's feedback on in the words of the job.
    fn feedback(
        &self,
        PlanShare { done_s, own_s, whole_s }: PlanShare,
    ) -> impl FnMut(ExecutePlanFeedback) + Send + 'static {
        let goal = match &self.asker {
            RequestOrigin::Goal(goal) => Some(goal.clone()),
            RequestOrigin::Stiffness(_) | RequestOrigin::Cell => None,
        };
        let (times, progress) = (Arc::clone(&self.times), Arc::clone(&self.progress));
        *lock(&progress) = PlanProgress::default();
        let names = self.lobes.clone();
        let mut last_index = 0;
        let after_s = (whole_s - done_s - own_s).max(0.0);
        let whole_s = done_s + own_s + after_s;
        move |feedback| {
            let lobe = usize::try_from(feedback.lobe).ok().filter(|index| *index < names.len());
            lock(&times).note(lobe, feedback.tick);
            lock(&progress).note(&feedback);
            last_index = lobe.unwrap_or(last_index);
            let Some(goal) = &goal else { return };
            goal.feedback(&RunJobFeedback {
                phase: feedback.phase,
                phase_name: phase_from(feedback.phase).map_or("", phase_name).to_owned(),
                lobe: lobe.map_or_else(String::new, |index| names[index].clone()),
                lobe_index: u32::try_from(last_index).unwrap_or(u32::MAX),
                lobe_count: u32::try_from(names.len()).unwrap_or(u32::MAX),
                turn: feedback.turn,
                turns: feedback.turns,
                stock: feedback.stock,
                percent: (100.0 * done_s + feedback.percent * own_s) / whole_s,
                time_left: feedback.time_left + after_s,
            });
        }
    }
}

/// Result of a plan whose end the interpolator does not report.
fn without_interpolator(alarm: u16, text: &str) -> (GoalStatus, ExecutePlanResult) {
    let message = format!("alarm {alarm} has stopped the machine ({text}), and the axis interpolator does not answer");
    (GoalStatus::Aborted, ExecutePlanResult { alarm, message, ..ExecutePlanResult::default() })
}
