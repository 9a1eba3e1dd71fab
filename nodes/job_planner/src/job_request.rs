// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The one job there can be: from a goal's request to its thread.

use super::cell::CellEvent;
use super::execution::Execution;
use super::grinding_run::GrindingRun;
use super::job_slot::{JobEvent, JobSlot};
use super::request_origin::RequestOrigin;
use super::turning_run::TurningRun;
use super::{MEETING, Shared, lock, settings};
use camwright::machine::description::MachineDescription;
use camwright_files::access;
use camwright_files::any_job::{self, AnyJob};
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::job_file::{self, Job};
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal, RunJobResult};
use camwright_msgs::camwright_msgs::msg::{Alarm, JobStatus};
use camwright_planning::{self as planning, AnyPrepared};
use camwright_ros::{ActionHandler, GoalDecider, GoalDecision, GoalHandle, GoalId, RosError};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};

/// A job that `load_job` planned, and what it was planned with.
#[derive(Debug)]
pub(super) struct LoadedJob {
    /// Name or path it was loaded by.
    pub(super) name: String,
    /// Overrides of the request.
    pub(super) overrides: Vec<String>,
    /// Overrides as used, the parameters' included.
    used: Vec<String>,
    machine: Option<MachineNow>,
    prepared: AnyPrepared,
}

impl Shared {
    /// Asks a job that runs to come to rest; false if none does.
    pub(super) fn cancel(&self) -> bool {
        match &*lock(&self.job_slot) {
            JobSlot::Running(_, events) => events.send(JobEvent::Cancel).is_ok(),
            JobSlot::Idle | JobSlot::Deciding(_) | JobSlot::Prepared(_) => false,
        }
    }

    /// Name and overrides of a goal: an empty name is the loaded job, else the parameter's.
    pub(super) fn wanted(&self, job: &str, overrides: &[String]) -> (String, Vec<String>) {
        if !job.is_empty() {
            return (job.to_owned(), overrides.to_vec());
        }
        match &*lock(&self.loaded) {
            Some(loaded) => {
                let all = loaded.overrides.iter().chain(overrides).cloned().collect();
                (loaded.name.clone(), all)
            }
            None => (self.node.parameters().string(settings::JOB), overrides.to_vec()),
        }
    }

    /// The overrides of a job as it is planned: the parameters', the request's, and what its parts have taught.
    ///
    /// # Errors
    /// A file that requests over ROS may not name.
    pub(super) fn used(
        &self,
        name: &str,
        overrides: &[String],
        machine: Option<&MachineNow>,
    ) -> Result<Vec<String>, String> {
        Ok(self.used_job(name, overrides, machine)?.0)
    }

    /// The same, with the job if it was read with them.
    fn used_job(
        &self,
        name: &str,
        overrides: &[String],
        machine: Option<&MachineNow>,
    ) -> Result<(Vec<String>, Option<AnyJob>), String> {
        let used = settings::overrides(self.node.parameters(), overrides);
        let folders: Vec<PathBuf> =
            self.node.parameters().string_array(settings::FILE_FOLDERS).into_iter().map(PathBuf::from).collect();
        access::check(name, &used, &folders)?;
        Ok(self.with_what_is_known(name, used, machine))
    }

    /// Overrides with what the parts of a job have taught, and where they are clamped; the job if nothing is added to it.
    fn with_what_is_known(
        &self,
        name: &str,
        mut used: Vec<String>,
        machine: Option<&MachineNow>,
    ) -> (Vec<String>, Option<AnyJob>) {
        // What parts have taught, and where they are clamped, is of jobs that grind.
        if any_job::turns(name, &used) {
            return (used, None);
        }
        let Ok(job) = job_file::load(name, &used) else { return (used, None) };
        // A job on the part as it is; a phase from the request has priority.
        let is_given = used.iter().any(|pair| pair.starts_with("part_phase_deg="));
        let phase = (job.starts_in_the_middle || job.spec.dry_run_mm.is_some()) && !is_given;
        let phase = if phase { self.setup.phase_override() } else { None };
        let is_moved = phase.is_some();
        used.extend(phase);
        let description = machine.map_or(&job.machine.description, |now| &now.description);
        let (learned, kept) = (self.learned_by(&job, description), self.kept_for(&job, description));
        let count = used.len();
        let all: Vec<String> = used.into_iter().chain(learned).chain(kept).collect();
        let job = (all.len() == count && !is_moved).then(|| AnyJob::Ground(Box::new(job)));
        (all, job)
    }

    /// Learned corrections of a job.
    fn learned_by(&self, job: &Job, machine: &MachineDescription) -> Option<String> {
        job.spec.compensation.as_ref()?;
        match self.learned.load(&machine.name, &job.spec.name) {
            Ok(learned) => learned.override_for(job),
            Err(error) => {
                self.node.logger().error(&format!("{error}; the part is ground as designed"));
                None
            }
        }
    }

    /// The stiffness that is kept for the machine, where a job takes it.
    fn kept_for(&self, job: &Job, machine: &MachineDescription) -> Option<String> {
        job.spec.correction.as_ref()?;
        match self.stiffness.load(&machine.name) {
            Ok(kept) => {
                let contacts = planning::kept_contacts(&kept, job, machine);
                contacts.lines.iter().for_each(|lines| self.node.logger().warn(lines));
                contacts.over
            }
            Err(error) => {
                self.node.logger().error(&format!("{error}; no stiffness is taken from it"));
                None
            }
        }
    }

    /// Plans a job for the machine as it is now, or takes the loaded plan if nothing has changed since.
    fn prepare(&self, name: &str, overrides: &[String], machine: Option<MachineNow>) -> Result<AnyPrepared, String> {
        settings::check_against_job(self.node.parameters(), name, overrides)?;
        let (used, read) = self.used_job(name, overrides, machine.as_ref())?;
        let loaded = lock(&self.loaded);
        let same = |loaded: &&LoadedJob| loaded.name == name && loaded.used == used && loaded.machine == machine;
        if let Some(loaded) = loaded.as_ref().filter(same) {
            return Ok(loaded.prepared.clone());
        }
        drop(loaded);
        self.plan(name, &used, read, machine.as_ref())
    }

    /// Plans a job, or takes the last plan if job, files and machine are the same.
    fn plan(
        &self,
        name: &str,
        used: &[String],
        read: Option<AnyJob>,
        machine: Option<&MachineNow>,
    ) -> Result<AnyPrepared, String> {
        let job = read.map_or_else(|| any_job::load(name, used), Ok).map_err(|error| error.to_string())?;
        let known = lock(&self.known).clone();
        let is_same = |known: &AnyPrepared| machine.is_some_and(|machine| known.is_plan_of(&job, machine));
        if let Some(known) = known.filter(is_same) {
            return Ok(known);
        }
        let prepared = planning::plan_any(job, machine).map_err(|error| error.to_string())?;
        *lock(&self.known) = Some(prepared.clone());
        Ok(prepared)
    }

    /// The loaded job, or that of the parameter, planned for the machine as it is.
    pub(super) fn prepare_usual(&self, machine: MachineNow) -> Result<AnyPrepared, String> {
        let (name, overrides) = self.wanted("", &[]);
        self.prepare(&name, &overrides, Some(machine))
    }

    /// Plans a job and keeps it, for `load_job`.
    pub(super) fn load(&self, job: &str, overrides: &[String]) -> Result<AnyPrepared, String> {
        let (name, overrides) = self.wanted(job, overrides);
        let machine = lock(&self.machine).clone();
        settings::check_against_job(self.node.parameters(), &name, &overrides)?;
        let (used, read) = self.used_job(&name, &overrides, machine.as_ref())?;
        let prepared = self.plan(&name, &used, read, machine.as_ref())?;
        if matches!(*lock(&self.job_slot), JobSlot::Idle) {
            self.board.planned(JobStatus::IDLE, &prepared, &format!("loaded {}", prepared.summary()));
        }
        *lock(&self.loaded) = Some(LoadedJob { name, overrides, used, machine, prepared: prepared.clone() });
        Ok(prepared)
    }

    /// The first alarm that keeps the machine from moving.
    pub(super) fn stopping_alarm(&self) -> Option<Alarm> {
        lock(&self.alarms).iter().find(|alarm| alarm.active && alarm.severity >= Alarm::STOP).cloned()
    }

    /// An active alarm by its number.
    pub(super) fn alarm(&self, number: u16) -> Option<Alarm> {
        lock(&self.alarms).iter().find(|alarm| alarm.active && alarm.number == number).cloned()
    }

    /// Condition of machine or work area that rejects every job without a look at it.
    fn standing_obstacle(&self) -> Option<String> {
        let of_alarm = |alarm: Alarm| format!("alarm {} needs a reset: {}; {}", alarm.number, alarm.text, alarm.remedy);
        self.stopping_alarm().map(of_alarm).or_else(|| self.cell.hindrance())
    }

    /// Everything that stands between a goal and its first motion.
    pub(super) fn decide(&self, name: &str, overrides: &[String]) -> Result<AnyPrepared, String> {
        let there = |outcome: Result<(), RosError>| outcome.map_err(|error| error.to_string());
        there(self.load_lobe.wait_for_service(MEETING))?;
        there(self.execute.wait_for_server(MEETING))?;
        let machine = self.met_machine()?;
        if let Some(reason) = self.standing_obstacle() {
            return Err(reason);
        }
        self.prepare(name, overrides, Some(machine))
    }

    /// Plans and starts the job of a part of the cell's own run; the cell hears of it when that cannot be.
    pub(super) fn run_part(self: &Arc<Self>, name: String, overrides: Vec<String>) {
        {
            let mut course = lock(&self.job_slot);
            if !matches!(*course, JobSlot::Idle) {
                return self.cell.send(CellEvent::PartRefused(course.to_string()));
            }
            *course = JobSlot::Deciding(name.clone());
        }
        let shared = Arc::clone(self);
        let sent = self.order(move || {
            shared.board.planning(&name);
            let started = shared.decide(&name, &overrides).and_then(|prepared| match shared.cell.wants_part() {
                true => shared.start(&mut lock(&shared.job_slot), prepared, RequestOrigin::Cell),
                false => Err("it was stopped before anything moved".into()),
            });
            if let Err(reason) = started {
                *lock(&shared.job_slot) = JobSlot::Idle;
                shared.board.refused(&name, &reason);
                shared.cell.send(CellEvent::PartRefused(reason));
            }
        });
        if !sent {
            *lock(&self.job_slot) = JobSlot::Idle;
        }
    }

    /// Starts the thread of a job; without one the course stays as it is.
    pub(super) fn start(
        self: &Arc<Self>,
        course: &mut JobSlot,
        prepared: AnyPrepared,
        asker: RequestOrigin,
    ) -> Result<(), String> {
        let (events, inbox) = mpsc::channel();
        let name = prepared.name().to_owned();
        let execution = Execution::new(Arc::clone(self), &prepared, asker, events.clone(), inbox);
        let thread = self.node.supervisor().spawn("job", move || run(execution, prepared));
        let thread = thread.map_err(|error| format!("no thread for the job: {error}"))?;
        *course = JobSlot::Running(name, events);
        // The one before has ended: it set the course to idle as its last act.
        *lock(&self.run) = Some(thread);
        Ok(())
    }
}

/// A job from its start to its end, on a thread of its own.
fn run(execution: Execution, prepared: AnyPrepared) {
    let shared = Arc::clone(&execution.shared);
    let logger = shared.node.logger();
    let _current = logger.enter();
    let started = prepared.summary();
    shared.board.planned(JobStatus::EXECUTING, &prepared, &started);
    shared.lobe_forms.designed(&prepared);
    logger.info(&format!("job {started}"));
    match prepared {
        AnyPrepared::Ground(prepared) => GrindingRun::new(execution, *prepared).run(),
        AnyPrepared::Turned(prepared) => TurningRun::new(execution, *prepared).run(),
    }
}

/// Serves `~/run_job`.
#[derive(Debug)]
pub(super) struct RunHandler(pub(super) Arc<Shared>);

impl RunHandler {
    /// Decides on the planning thread.
    fn begin(&self, name: String, overrides: Vec<String>, decider: GoalDecider) {
        let shared = Arc::clone(&self.0);
        let sent = self.0.order(move || {
            shared.board.planning(&name);
            match shared.decide(&name, &overrides) {
                Ok(prepared) => {
                    shared.board.planned(JobStatus::PLANNING, &prepared, &prepared.summary());
                    *lock(&shared.job_slot) = JobSlot::Prepared(Box::new(prepared));
                    decider.accept();
                }
                Err(reason) => {
                    *lock(&shared.job_slot) = JobSlot::Idle;
                    shared.board.refused(&name, &reason);
                    decider.reject(&reason);
                }
            }
        });
        if !sent {
            *lock(&self.0.job_slot) = JobSlot::Idle;
        }
    }
}

impl ActionHandler<RunJob> for RunHandler {
    fn goal(&mut self, _id: GoalId, goal: &RunJobGoal) -> GoalDecision {
        let is_active = self.0.active.load(Ordering::Acquire);
        let obstacle = if is_active { self.0.cell.keeps_jobs_out() } else { Some("the node is not active".to_owned()) };
        if let Some(reason) = obstacle {
            self.0.board.rejected(&reason);
            return GoalDecision::Reject(reason);
        }
        let (name, mut overrides) = self.0.wanted(&goal.job, &goal.overrides);
        if !goal.start_lobe.is_empty() {
            overrides.push(format!("start_at={}", goal.start_lobe));
        }
        {
            let mut course = lock(&self.0.job_slot);
            if !matches!(*course, JobSlot::Idle) {
                return GoalDecision::Reject(course.to_string());
            }
            if let Some(reason) = self.0.standing_obstacle() {
                self.0.board.refused(&name, &reason);
                return GoalDecision::Reject(reason);
            }
            *course = JobSlot::Deciding(name.clone());
        }
        let (decider, decision) = GoalDecision::later();
        self.begin(name, overrides, decider);
        decision
    }

    fn accepted(&mut self, goal: GoalHandle<RunJob>) {
        let abort = |message: &str| {
            goal.abort(RunJobResult { message: format!("{message}; nothing moved"), ..RunJobResult::default() });
        };
        let mut course = lock(&self.0.job_slot);
        let prepared = match std::mem::take(&mut *course) {
            JobSlot::Prepared(prepared) => prepared,
            other => {
                *course = other;
                return abort("its plan is gone");
            }
        };
        if !self.0.active.load(Ordering::Acquire) {
            return abort("the node is not active any more");
        }
        if let Err(reason) = self.0.start(&mut course, *prepared, RequestOrigin::Goal(goal.clone())) {
            abort(&reason);
        }
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.cancel()
    }
}
