//! A job that runs, on a thread of its own: pages, blanks, execution, measuring.

use super::course::Course;
use super::setup::NotPutIn;
use super::{Shared, lock};
use crate::convert::plan::{phase_from, phase_name};
use crate::planning::{self, PreparedCorrection, PreparedJob};
use crate::ros::{ClientGoal, GoalHandle, GoalStatus};
use camwright::cycle::rests_rad;
use camwright::runout::journal::LOG_ENDS_RAD;
use camwright::speed_plan::SpeedPlan;
use camwright_msgs::camwright_msgs::action::{
    ExecutePlan, ExecutePlanFeedback, ExecutePlanGoal, ExecutePlanResult, RunJob, RunJobFeedback, RunJobResult,
};
use camwright_msgs::camwright_msgs::msg::{JobStatus, LobeResult, PartLobe, PlanPage};
use camwright_msgs::camwright_msgs::srv::InjectFaultRequest;
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
enum Failure {
    /// Somebody wished so.
    Cancelled(String),
    /// It could not go on.
    Failed(String),
}

/// One run of a job.
pub(super) struct Run {
    shared: Arc<Shared>,
    prepared: PreparedJob,
    goal: GoalHandle<RunJob>,
    events: mpsc::Sender<Event>,
    inbox: mpsc::Receiver<Event>,
    times: Arc<Mutex<LobeTicks>>,
}

/// Ticks at which each lobe began and ended, as the interpolator told.
#[derive(Debug, Default)]
struct LobeTicks {
    current: Option<usize>,
    spans: Vec<(u64, Option<u64>)>,
    /// What the lobes took in the half before (ticks).
    before: Vec<u64>,
}

impl LobeTicks {
    /// The lobes come once more: the half before is over.
    fn next_half(&mut self) {
        let last = self.spans.iter().filter_map(|(_, end)| *end).max().unwrap_or_default();
        self.before = (0..self.spans.len()).filter_map(|lobe| self.of(lobe, last)).collect();
        (self.current, self.spans) = (None, Vec::new());
    }

    fn note(&mut self, lobe: Option<usize>, tick: u64) {
        if lobe == self.current {
            return;
        }
        if let Some(span) = self.current.and_then(|index| self.spans.get_mut(index)) {
            span.1 = Some(tick);
        }
        // Lobes come in the order of the plan; one that is missed leaves those after it without a time.
        if lobe == Some(self.spans.len()) {
            self.spans.push((tick, None));
        }
        self.current = lobe;
    }

    /// Ticks of a lobe; the last one may end with the job.
    fn of(&self, lobe: usize, last_tick: u64) -> Option<u64> {
        let (begin, end) = self.spans.get(lobe)?;
        let before = self.before.get(lobe).copied().unwrap_or_default();
        Some(before + end.unwrap_or(last_tick).saturating_sub(*begin))
    }
}

impl Run {
    pub(super) fn new(
        shared: Arc<Shared>,
        prepared: PreparedJob,
        goal: GoalHandle<RunJob>,
        events: mpsc::Sender<Event>,
        inbox: mpsc::Receiver<Event>,
    ) -> Self {
        Self { shared, prepared, goal, events, inbox, times: Arc::default() }
    }

    /// The whole run; the course is idle again when it returns.
    pub(super) fn run(self) {
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
        match outcome {
            Ok(()) => {
                result.success = true;
                logger.info(&format!("job {name} complete: {}", result.message));
                self.shared.board.change(JobStatus::COMPLETE, &result.message, &result.lobes);
                self.goal.succeed(result);
            }
            Err(Failure::Cancelled(message)) => {
                result.message = message;
                logger.warn(&format!("job {name} stopped: {}", result.message));
                self.shared.board.change(JobStatus::STOPPED, &result.message, &result.lobes);
                self.goal.canceled(result);
            }
            Err(Failure::Failed(message)) => {
                result.message = message;
                logger.error(&format!("job {name} aborted: {}", result.message));
                self.shared.board.change(JobStatus::ABORTED, &result.message, &result.lobes);
                self.goal.abort(result);
            }
        }
    }

    fn proceed(&self, result: &mut RunJobResult) -> Result<(), Failure> {
        // A job that begins in its middle goes on with the part as it is, and a dry run leaves it.
        let keeps = self.prepared.job.starts_in_the_middle
            || (self.prepared.dry_run_mm().is_some() && self.shared.parts.is_there());
        if !keeps {
            self.load_blanks()?;
        }
        self.publish(&self.prepared.pages)?;
        self.arm_faults()?;
        self.listen();
        let (status, mut ended) = self.execute(self.prepared.plan_hash(), 0.0)?;
        (result.alarm, result.first_tick, result.last_tick) = (ended.alarm, ended.first_tick, ended.last_tick);
        let mut correction = None;
        let status = match status {
            GoalStatus::Succeeded if self.prepared.expected_correction.is_some() => {
                let second = self.correct()?;
                self.publish(&second.pages)?;
                lock(&self.times).next_half();
                let done_s = self.prepared.planned.plan.duration_s;
                let (status, last) = self.execute(second.plan_hash(), done_s)?;
                (result.alarm, result.last_tick) = (last.alarm, last.last_tick);
                let (first_tick, turns_left_out) = (ended.first_tick, ended.turns_left_out);
                ended = ExecutePlanResult { first_tick, turns_left_out, ..last };
                correction = Some(second);
                status
            }
            status => status,
        };
        let ticks = ended.last_tick.saturating_sub(ended.first_tick);
        result.duration = self.seconds(ticks);
        result.duration_with_indexing = result.duration + self.prepared.planned.saved_by_not_indexing_s();
        match status {
            GoalStatus::Succeeded if self.prepared.dry_run_mm().is_some() => {
                result.message = self.told_dry(result);
                Ok(())
            }
            GoalStatus::Succeeded => {
                result.lobes = self.measure(&ended)?;
                if let Some(correction) = &correction {
                    correction.add_to(&mut result.lobes);
                }
                let times = planning::compare_times(&self.prepared, &result.lobes, result.duration);
                let told: Vec<String> = times.iter().map(ToString::to_string).collect();
                self.shared.node.logger().info(&told.join("; "));
                result.message = self.told(result);
                Ok(())
            }
            GoalStatus::Canceled => Err(Failure::Cancelled(ended.message)),
            _ => Err(Failure::Failed(ended.message)),
        }
    }

    fn publish(&self, pages: &[PlanPage]) -> Result<(), Failure> {
        pages
            .iter()
            .try_for_each(|page| self.shared.plan.publish(page))
            .map_err(|error| failed_still(&error.to_string()))
    }

    /// Listens to the gauge where the job needs it.
    fn listen(&self) {
        match (&self.prepared.expected_correction, &self.prepared.machine.gauge) {
            (Some(_), Some(gauge)) if self.prepared.dry_run_mm().is_none() => {
                self.shared.gaugings.listen(gauge.behind_wheel_rad);
            }
            _ => self.shared.gaugings.stop(),
        }
    }

    /// Decides from what the gauge read how the second half goes.
    fn correct(&self) -> Result<PreparedCorrection, Failure> {
        if let Some(dry) = self.prepared.dry_correction() {
            return Ok(dry);
        }
        let planned = &self.prepared.planned;
        let rests = rests_rad(&planned.plan, &self.prepared.machine);
        let names = planned.lobes.iter().map(|lobe| lobe.design.name.as_str());
        let wanted: Vec<(&str, f64)> = names.zip(rests.iter().map(|rest_rad| rest_rad - LOG_ENDS_RAD)).collect();
        let logs = self.shared.gaugings.wait(&wanted, MEASURING).map_err(|missing| {
            Failure::Failed(format!(
                "the gauge did not read lobe {missing} to the end of its dwell; the wheel is clear of the part"
            ))
        })?;
        self.shared.gaugings.stop();
        let correction = planning::correct(&self.prepared, &logs)
            .map_err(|error| Failure::Failed(format!("{error}; the wheel is clear of the part")))?;
        for told in correction.told(&self.prepared) {
            self.shared.node.logger().info(&told);
        }
        self.shared.node.logger().info(&format!(
            "second half: {:.2} s, plan {:.12}",
            correction.planned.plan.duration_s,
            correction.plan_hash()
        ));
        Ok(correction)
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
    fn arm_faults(&self) -> Result<(), Failure> {
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

    /// Hands a plan to the interpolator, before which so much of the job was done (s, as predicted), and waits for its end.
    fn execute(&self, plan_hash: &str, done_s: f64) -> Result<(GoalStatus, ExecutePlanResult), Failure> {
        self.check_cancelled()?;
        let wanted = ExecutePlanGoal {
            plan_hash: plan_hash.to_owned(),
            client: format!("{}, job {}", self.shared.node.fully_qualified_name(), self.prepared.job.spec.name),
        };
        let sent = self.shared.execute.send_goal(wanted, self.feedback(done_s), ANSWER);
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

    /// Passes the interpolator's feedback on in the words of the job, of which so much was done before (s, as predicted).
    fn feedback(&self, done_s: f64) -> impl FnMut(ExecutePlanFeedback) + Send + 'static {
        let (goal, times) = (self.goal.clone(), Arc::clone(&self.times));
        let names: Vec<String> = self.prepared.planned.plan.lobes.clone();
        let mut last_index = 0;
        let whole_s = self.prepared.duration_s();
        let first_s = self.prepared.planned.plan.duration_s;
        let (half_s, after_s) = if done_s > 0.0 { (whole_s - done_s, 0.0) } else { (first_s, whole_s - first_s) };
        move |feedback| {
            let lobe = usize::try_from(feedback.lobe).ok().filter(|index| *index < names.len());
            lock(&times).note(lobe, feedback.tick);
            last_index = lobe.unwrap_or(last_index);
            goal.feedback(&RunJobFeedback {
                phase: feedback.phase,
                phase_name: phase_from(feedback.phase).map_or("", phase_name).to_owned(),
                lobe: lobe.map_or_else(String::new, |index| names[index].clone()),
                lobe_index: u32::try_from(last_index).unwrap_or(u32::MAX),
                lobe_count: u32::try_from(names.len()).unwrap_or(u32::MAX),
                turn: feedback.turn,
                turns: feedback.turns,
                stock: feedback.stock,
                percent: (100.0 * done_s + feedback.percent * half_s) / whole_s,
                time_left: feedback.time_left + after_s,
            });
        }
    }

    /// The form of every lobe of the finished part.
    fn measure(&self, ended: &ExecutePlanResult) -> Result<Vec<LobeResult>, Failure> {
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
            let left_out = ended.turns_left_out.get(index).copied().unwrap_or_default();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lobe_lasts_from_its_first_tick_to_the_next_one_that_is_not_its() {
        let mut ticks = LobeTicks::default();
        for (lobe, tick) in [(None, 0), (Some(0), 100), (Some(0), 150), (Some(1), 300), (None, 450), (None, 500)] {
            ticks.note(lobe, tick);
        }
        assert_eq!((ticks.of(0, 600), ticks.of(1, 600), ticks.of(2, 600)), (Some(200), Some(150), None));
    }

    #[test]
    fn a_lobe_that_comes_twice_lasts_as_long_as_both_times() {
        let mut ticks = LobeTicks::default();
        for (lobe, tick) in [(None, 0), (Some(0), 100), (Some(1), 300), (None, 450)] {
            ticks.note(lobe, tick);
        }
        ticks.next_half();
        for (lobe, tick) in [(Some(0), 1000), (Some(1), 1040), (None, 1090)] {
            ticks.note(lobe, tick);
        }
        assert_eq!((ticks.of(0, 1100), ticks.of(1, 1100)), (Some(240), Some(200)));
    }

    #[test]
    fn the_last_lobe_may_end_with_the_job() {
        let mut ticks = LobeTicks::default();
        ticks.note(Some(0), 10);
        assert_eq!(ticks.of(0, 60), Some(50));
    }
}
