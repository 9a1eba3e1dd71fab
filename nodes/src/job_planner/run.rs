//! A job that runs, on a thread of its own: pages, blanks, execution, measuring.

use super::course::Course;
use super::identify::{self, Waiting};
use super::lobe_ticks::LobeTicks;
use super::setup::NotPutIn;
use super::{Shared, lock};
use crate::config::stiffness_file::KeptPlace;
use crate::convert::plan::{phase_from, phase_name};
use crate::planning::{self, MeasuredContacts, PreparedJob, hash_of};
use crate::ros::{ClientGoal, GoalHandle, GoalStatus};
use camwright::speed_plan::SpeedPlan;
use camwright_msgs::camwright_msgs::action::{
    ExecutePlan, ExecutePlanFeedback, ExecutePlanGoal, ExecutePlanResult, RunJob, RunJobFeedback, RunJobResult,
};
use camwright_msgs::camwright_msgs::msg::{JobStatus, LobeResult, PartLobe, PlanPage};
use camwright_msgs::camwright_msgs::srv::{IdentifyStiffnessResponse, InjectFaultRequest};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// How long a peer may take to answer a request.
const ANSWER: Duration = Duration::from_secs(10);
/// How long the finished part may take to arrive: one page of outline per lobe.
const MEASURING: Duration = Duration::from_secs(20);
/// How long a job may take to come to rest after it was cancelled.
const STOPPING: Duration = Duration::from_secs(60);
/// How often the interpolator is looked for while it executes.
const WATCH: Duration = Duration::from_secs(1);
/// How long it may be out of sight: longer than a discovery hiccup.
const OUT_OF_SIGHT: Duration = Duration::from_secs(5);

/// How the message of a dry run begins.
const DRY_RUN: &str = "dry run";

/// What a running job is told.
#[derive(Debug)]
pub(super) enum Event {
    /// Come to rest.
    Cancel,
    /// The interpolator has ended the plan.
    Ended(GoalStatus, ExecutePlanResult),
}

/// How a job ended that did not reach its end.
pub(super) enum Failure {
    /// Somebody wished so.
    Cancelled(String),
    /// It could not go on.
    Failed(String),
}

/// Who asked for the job, and is told how it ends.
#[derive(Debug, Clone)]
pub(super) enum Asker {
    /// A client of `~/run_job`.
    Goal(GoalHandle<RunJob>),
    /// One of `~/identify_stiffness`.
    Stiffness(Waiting),
}

/// One run of a job.
pub(super) struct Run {
    pub(super) shared: Arc<Shared>,
    pub(super) prepared: PreparedJob,
    asker: Asker,
    /// Stiffness that was measured and is kept, in the order of machining.
    pub(super) stiffness: Vec<KeptPlace>,
    /// What the turns save that were left out for the stock that was measured.
    pub(super) saved: Option<String>,
    /// First tick of the first of its plans, once that has ended.
    first_tick: Option<u64>,
    events: mpsc::Sender<Event>,
    inbox: mpsc::Receiver<Event>,
    pub(super) times: Arc<Mutex<LobeTicks>>,
}

impl Run {
    pub(super) fn new(
        shared: Arc<Shared>,
        prepared: PreparedJob,
        asker: Asker,
        events: mpsc::Sender<Event>,
        inbox: mpsc::Receiver<Event>,
    ) -> Self {
        Self {
            shared,
            prepared,
            asker,
            stiffness: Vec::new(),
            saved: None,
            first_tick: None,
            events,
            inbox,
            times: Arc::default(),
        }
    }

    /// The whole run; the course is idle again when it returns.
    pub(super) fn run(mut self) {
        let logger = self.shared.node.logger().clone();
        let _current = logger.enter();
        let name = self.prepared.job.spec.name.clone();
        let started = self.prepared.summary();
        self.shared.board.planned(JobStatus::EXECUTING, &self.prepared, &started);
        logger.info(&format!("job {started}"));
        for dress in planning::dresses(&self.prepared) {
            logger.info(&dress.to_string());
        }
        let mut result = RunJobResult { plan_hash: self.prepared.plan_hash().to_owned(), ..RunJobResult::default() };
        let outcome = self.proceed(&mut result);
        // Idle before the client hears of the end: it may send the next goal at once.
        *lock(&self.shared.course) = Course::Idle;
        let state = match outcome {
            Ok(()) => {
                result.success = true;
                logger.info(&format!("job {name} complete: {}", result.message));
                JobStatus::COMPLETE
            }
            Err(Failure::Cancelled(message)) => {
                result.message = message;
                logger.warn(&format!("job {name} stopped: {}", result.message));
                JobStatus::STOPPED
            }
            Err(Failure::Failed(message)) => {
                result.message = message;
                logger.error(&format!("job {name} aborted: {}", result.message));
                JobStatus::ABORTED
            }
        };
        self.shared.board.change(state, &result.message, &result.lobes);
        match (self.asker, state) {
            (Asker::Goal(goal), JobStatus::COMPLETE) => drop(goal.succeed(result)),
            (Asker::Goal(goal), JobStatus::STOPPED) => drop(goal.canceled(result)),
            (Asker::Goal(goal), _) => drop(goal.abort(result)),
            (Asker::Stiffness(waiting), _) => {
                let journals: Vec<_> = self.stiffness.iter().map(identify::message).collect();
                let success = result.success && journals.len() == result.lobes.len();
                let message = result.message;
                identify::answer(&waiting, &IdentifyStiffnessResponse { success, message, journals });
            }
        }
    }

    fn proceed(&mut self, result: &mut RunJobResult) -> Result<(), Failure> {
        // A job that begins in its middle goes on with the part as it is, and a dry run leaves it.
        let keeps = self.prepared.job.starts_in_the_middle
            || (self.prepared.dry_run_mm().is_some() && self.shared.parts.is_there());
        if !keeps {
            self.load_blanks()?;
        }
        let measures = self.prepared.measuring.is_some();
        if measures {
            self.measure_stock(result)?;
        }
        self.publish(&self.prepared.pages)?;
        if !measures {
            self.arm_faults()?;
        }
        self.listen();
        let done_s = self.prepared.measuring_s();
        let own_s = self.prepared.planned.plan.duration_s;
        let ended = self.execute(hash_of(&self.prepared.pages), done_s, own_s)?;
        let turns_left_out = ended.1.turns_left_out.clone();
        self.note(result, ended)?;
        let mut correction = None;
        let mut measured = MeasuredContacts::default();
        let is_dry = self.prepared.dry_run_mm().is_some();
        if self.prepared.expected_correction.is_some() {
            let second = self.correct()?;
            self.publish(&second.pages)?;
            lock(&self.times).next_half();
            let ended = self.execute(second.plan_hash(), done_s + own_s, second.planned.plan.duration_s)?;
            self.note(result, ended)?;
            correction = Some(second);
        } else if self.prepared.job.spec.identification.is_some() && !is_dry {
            measured = self.identify()?;
        }
        if is_dry {
            result.message = self.told_dry(result);
            return Ok(());
        }
        result.lobes = self.measure(result, &turns_left_out)?;
        measured.add_to(&mut result.lobes);
        if let Some(correction) = &correction {
            correction.add_to(&mut result.lobes);
        }
        let times = planning::compare_times(&self.prepared, &result.lobes, result.duration);
        let told: Vec<String> = times.iter().map(ToString::to_string).collect();
        self.shared.node.logger().info(&told.join("; "));
        result.message = self.told(result);
        Ok(())
    }

    /// Writes into the result of the job how one of its plans ended; nothing follows one that did not come to its end.
    pub(super) fn note(
        &mut self,
        result: &mut RunJobResult,
        (status, ended): (GoalStatus, ExecutePlanResult),
    ) -> Result<(), Failure> {
        result.first_tick = *self.first_tick.get_or_insert(ended.first_tick);
        (result.alarm, result.last_tick) = (ended.alarm, ended.last_tick);
        result.duration = self.seconds(result.last_tick.saturating_sub(result.first_tick));
        result.duration_with_indexing = result.duration + self.prepared.planned.saved_by_not_indexing_s();
        match status {
            GoalStatus::Succeeded => Ok(()),
            GoalStatus::Canceled => Err(Failure::Cancelled(ended.message)),
            _ => Err(Failure::Failed(ended.message)),
        }
    }

    pub(super) fn publish(&self, pages: &[PlanPage]) -> Result<(), Failure> {
        pages
            .iter()
            .try_for_each(|page| self.shared.plan.publish(page))
            .map_err(|error| failed_still(&error.to_string()))
    }

    fn told_dry(&self, result: &RunJobResult) -> String {
        format!(
            "{} in {:.2} s, predicted {:.2} s, with the wheel {} mm farther out: nothing was cut, and nothing is judged",
            DRY_RUN,
            result.duration,
            self.prepared.duration_s(),
            self.prepared.dry_run_mm().unwrap_or_default()
        )
    }

    fn told(&self, result: &RunJobResult) -> String {
        let (lobes, predicted_s) = (result.lobes.len(), self.prepared.duration_s());
        let late_s = result.duration - predicted_s;
        let mut took =
            format!("{lobes} lobes in {:.2} s, predicted {predicted_s:.2} s ({late_s:+.2} s)", result.duration);
        if let Some(saved_s) = self.prepared.planned.saved_by_turning_on_s() {
            let stops_s = result.duration + saved_s;
            took += &format!("; with C stopping between lobes {stops_s:.2} s: {saved_s:.2} s saved");
        }
        if let Some(saved) = &self.saved {
            took += &format!("; {saved}");
        }
        if self.prepared.job.spec.rotary_indexing {
            return format!("{took}, with rotary indexing before each");
        }
        format!(
            "{took}; with rotary indexing before each {:.2} s: {:.2} s saved",
            result.duration_with_indexing,
            result.duration_with_indexing - result.duration
        )
    }

    #[allow(clippy::cast_precision_loss, reason = "a job of 2^53 ticks would last 285 000 years")]
    fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 * self.prepared.machine.cycle_time_s()
    }

    /// Whether somebody wishes the end before anything has moved.
    fn check_cancelled(&self) -> Result<(), Failure> {
        match self.inbox.try_recv() {
            Ok(Event::Cancel) => Err(Failure::Cancelled("cancelled before anything moved".into())),
            _ => Ok(()),
        }
    }

    /// Puts the raw part between the centres.
    fn load_blanks(&self) -> Result<(), Failure> {
        let cancelled = || matches!(self.inbox.try_recv(), Ok(Event::Cancel));
        self.shared.put_in(&self.prepared, &cancelled).map_err(|reason| match reason {
            NotPutIn::Cancelled => Failure::Cancelled("cancelled before anything moved".into()),
            NotPutIn::Refused(reason) => failed_still(&reason),
        })
    }

    /// Hands the faults of the job to the machine, which strikes with them at their ticks.
    pub(super) fn arm_faults(&self) -> Result<(), Failure> {
        for fault in &self.prepared.job.faults {
            let request = InjectFaultRequest {
                fault: fault.kind.clone(),
                target: fault.target.clone(),
                value: fault.value,
                active: true,
                job_tick: fault.job_tick,
            };
            let answer =
                self.shared.inject_fault.call(&request, ANSWER).map_err(|error| failed_still(&error.to_string()))?;
            if !answer.success {
                return Err(failed_still(&format!("the fault {} cannot be set: {}", fault.kind, answer.message)));
            }
        }
        Ok(())
    }

    /// Hands a plan to the interpolator, before which so much of the job was done and which takes so long itself (s, as predicted), and
    /// waits for its end.
    pub(super) fn execute(
        &self,
        plan_hash: &str,
        done_s: f64,
        own_s: f64,
    ) -> Result<(GoalStatus, ExecutePlanResult), Failure> {
        self.check_cancelled()?;
        let wanted = ExecutePlanGoal {
            plan_hash: plan_hash.to_owned(),
            client: format!("{}, job {}", self.shared.node.fully_qualified_name(), self.prepared.job.spec.name),
        };
        let sent = self.shared.execute.send_goal(wanted, self.feedback(done_s, own_s), ANSWER);
        let plan = sent.map_err(|error| failed_still(&error.to_string()))?;
        if !plan.accepted() {
            return Err(failed_still("the axis interpolator refused the plan; its log says why"));
        }
        let events = self.events.clone();
        plan.result_with(move |status, result| drop(events.send(Event::Ended(status, result))))
            .map_err(|error| Failure::Failed(error.to_string()))?;
        self.wait(&plan)
    }

    fn wait(&self, plan: &ClientGoal<ExecutePlan>) -> Result<(GoalStatus, ExecutePlanResult), Failure> {
        let mut give_up: Option<Instant> = None;
        let mut seen = Instant::now();
        let mut alarmed: Option<Instant> = None;
        loop {
            match self.inbox.recv_timeout(WATCH) {
                Ok(Event::Ended(status, result)) => return Ok((status, result)),
                Ok(Event::Cancel) if give_up.is_none() => {
                    give_up = Some(Instant::now() + STOPPING);
                    self.shared.board.change(JobStatus::STOPPING, "coming to rest", &[]);
                    plan.cancel_with(|_| {}).map_err(|error| Failure::Failed(error.to_string()))?;
                }
                Ok(Event::Cancel) => {}
                Err(_) => {
                    if self.shared.execute.is_ready() {
                        seen = Instant::now();
                    }
                    if seen.elapsed() > OUT_OF_SIGHT {
                        return Err(Failure::Failed(
                            "the axis interpolator has left; the machine stops on the path by itself".into(),
                        ));
                    }
                    // DDS takes most of a minute to miss a node that died; an interpolator that lives ends a job with the alarm.
                    let stopped = self.shared.stopping_alarm();
                    alarmed = stopped.as_ref().map(|_| alarmed.unwrap_or_else(Instant::now));
                    if let (Some(alarm), Some(_)) = (stopped, alarmed.filter(|since| since.elapsed() > OUT_OF_SIGHT)) {
                        let message = format!(
                            "alarm {} has stopped the machine ({}), and the axis interpolator does not answer",
                            alarm.number, alarm.text
                        );
                        let ended = ExecutePlanResult { alarm: alarm.number, message, ..ExecutePlanResult::default() };
                        return Ok((GoalStatus::Aborted, ended));
                    }
                }
            }
            if give_up.is_some_and(|end| Instant::now() > end) {
                let message = format!("cancelled, but the axes did not come to rest within {} s", STOPPING.as_secs());
                return Err(Failure::Failed(message));
            }
        }
    }

    /// Passes the interpolator's feedback on in the words of the job, of which so much was done before and so much is this plan (s, as
    /// predicted).
    fn feedback(&self, done_s: f64, own_s: f64) -> impl FnMut(ExecutePlanFeedback) + Send + 'static {
        let goal = match &self.asker {
            Asker::Goal(goal) => Some(goal.clone()),
            Asker::Stiffness(_) => None,
        };
        let times = Arc::clone(&self.times);
        let names: Vec<String> = self.prepared.planned.plan.lobes.clone();
        let mut last_index = 0;
        let after_s = (self.prepared.duration_s() - done_s - own_s).max(0.0);
        let whole_s = done_s + own_s + after_s;
        move |feedback| {
            let lobe = usize::try_from(feedback.lobe).ok().filter(|index| *index < names.len());
            lock(&times).note(lobe, feedback.tick);
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

    /// The form of every lobe of the finished part.
    fn measure(&self, ended: &RunJobResult, turns_left_out: &[u32]) -> Result<Vec<LobeResult>, Failure> {
        let lobes = &self.prepared.planned.lobes;
        let names: Vec<&str> = lobes.iter().map(|lobe| lobe.design.name.as_str()).collect();
        let parts = self.shared.parts.wait_finished(&names, ended.first_tick, MEASURING).map_err(|missing| {
            Failure::Failed(format!("the job was executed, but the machine did not report the finished lobe {missing}"))
        })?;
        self.learn(&parts);
        let predicted = planning::lobe_times_s(&self.prepared);
        let times = lock(&self.times);
        let result = |(index, part): (usize, &PartLobe)| {
            let lobe = &lobes[index];
            let mut result = planning::lobe_result(&lobe.design, part).map_err(|e| Failure::Failed(e.to_string()))?;
            result.start_angle = lobe.start_rad;
            let left_out = turns_left_out.get(index).copied().unwrap_or_default();
            let planned = lobe.passes.iter().map(SpeedPlan::turns).sum::<u32>();
            result.turns = f64::from(planned.saturating_sub(left_out));
            result.duration = match times.of(index, ended.last_tick) {
                Some(ticks) => self.seconds(ticks),
                // Feedback may be lost on its way; then the plan's time is the best there is.
                None => predicted.get(index).copied().unwrap_or_default(),
            };
            Ok(result)
        };
        parts.iter().enumerate().map(result).collect()
    }
}

impl Run {
    /// Learns from a finished part where the job says so. What cannot be kept is told; the part is good or not all the same. A part
    /// that was begun twice teaches nothing.
    fn learn(&self, parts: &[PartLobe]) {
        if self.prepared.job.spec.compensation.is_none() || self.prepared.job.starts_in_the_middle {
            return;
        }
        let logger = self.shared.node.logger();
        match self.shared.learned.learn(&self.prepared, parts) {
            Ok(told) => told.iter().for_each(|told| logger.info(told)),
            Err(error) => logger.error(&format!("nothing was learned from the part: {error}")),
        }
    }
}

fn failed_still(reason: &str) -> Failure {
    Failure::Failed(format!("{reason}; nothing moved"))
}
