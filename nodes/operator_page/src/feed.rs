//! What was heard of the cell, and who waits for news of it.

use super::status::{Shape, Status};
use camwright_msgs::camwright_msgs::msg::{
    Alarm, CommandHolder, InterpolatorState, JobStatus, LobeForm, MachineDescription, MachineIo, MachineStream,
    PartLobe, PlanHeader, PlanPage, RecorderStatus,
};
use camwright_msgs::control_msgs::msg::DynamicJointState;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most lobes that are remembered of a job.
const MAX_LOBES: usize = 64;

/// Something that is published again and again, and when it was heard last.
#[derive(Debug)]
pub(super) struct Heard<T> {
    pub(super) said: T,
    pub(super) at: Instant,
}

/// The cell, as far as it was heard.
#[derive(Debug, Default)]
pub(super) struct Known {
    pub(super) cell: String,
    pub(super) machine: Option<MachineDescription>,
    pub(super) stream: Option<Heard<MachineStream>>,
    pub(super) io: Option<MachineIo>,
    pub(super) axes: Option<DynamicJointState>,
    pub(super) machine_alarms: Vec<Alarm>,
    pub(super) interpolator: Option<Heard<InterpolatorState>>,
    pub(super) interpolator_alarms: Vec<Alarm>,
    /// Holder of command over the cell.
    pub(super) lease: Option<CommandHolder>,
    pub(super) job: Option<JobStatus>,
    pub(super) recorder: Option<Heard<RecorderStatus>>,
    /// Hash and header of the plan published last.
    pub(super) plan: Option<(String, PlanHeader)>,
    /// Of the job that was planned last, in its order.
    pub(super) forms: Vec<LobeForm>,
    /// The lobes of the part, the one that was heard of last at the end.
    pub(super) outlines: Vec<PartLobe>,
    /// Counts what `shape` shows.
    shape_version: u64,
}

impl Known {
    /// A design or a form: the first design of another job takes the place of all before.
    pub(super) fn take_form(&mut self, form: LobeForm) {
        self.shape_version += 1;
        let is_new_part = form.form_error.is_empty()
            && self.forms.iter().any(|known| known.name == form.name && !known.form_error.is_empty());
        if is_new_part || self.forms.first().is_some_and(|first| first.job != form.job) {
            self.forms.clear();
        }
        match self.forms.iter().position(|known| known.name == form.name) {
            Some(at) => self.forms[at] = form,
            None if self.forms.len() < MAX_LOBES => self.forms.push(form),
            None => {}
        }
    }

    pub(super) fn take_outline(&mut self, outline: PartLobe) {
        self.shape_version += 1;
        self.outlines.retain(|known| known.name != outline.name);
        if self.outlines.len() >= MAX_LOBES {
            self.outlines.remove(0);
        }
        self.outlines.push(outline);
    }

    pub(super) fn take_interpolator(&mut self, state: InterpolatorState) {
        let before = self.interpolator.as_ref().map(|heard| heard.said.lobe);
        self.shape_version += u64::from(before != Some(state.lobe));
        self.interpolator = Some(Heard { said: state, at: Instant::now() });
    }

    /// Every node of the cell was heard, and the plan in execution.
    pub(super) fn is_complete(&self) -> bool {
        let in_execution = self.interpolator.as_ref().map(|heard| &heard.said.plan_hash);
        let has_plan = in_execution.is_some_and(|hash| hash.is_empty() || self.plan_in_work().is_some());
        let is_machine_known = self.machine.is_some() && self.io.is_some() && self.axes.is_some();
        has_plan && is_machine_known && self.lease.is_some() && self.job.is_some() && self.recorder.is_some()
    }

    /// A page of a plan; the first one has the header.
    pub(super) fn take_page(&mut self, mut page: PlanPage) {
        if let Some(header) = page.header.pop() {
            self.plan = Some((page.plan_hash, header));
        }
    }

    /// Header of the plan in execution.
    pub(super) fn plan_in_work(&self) -> Option<&PlanHeader> {
        let hash = &self.interpolator.as_ref()?.said.plan_hash;
        self.plan.as_ref().filter(|(of, _)| of == hash).map(|(_, header)| header)
    }

    /// Name of the lobe that is worked on.
    pub(super) fn lobe_in_work(&self) -> Option<&str> {
        let index = usize::try_from(self.interpolator.as_ref()?.said.lobe).ok()?;
        self.plan_in_work()?.lobes.get(index).map(String::as_str)
    }

    /// The lobe that is worked on or, without one, the one that was heard of last.
    pub(super) fn outline(&self) -> Option<&PartLobe> {
        let in_work = self.lobe_in_work().and_then(|name| self.outlines.iter().find(|outline| outline.name == name));
        in_work.or(self.outlines.last())
    }
}

/// Shared by the subscriptions and by all viewers.
#[derive(Debug, Default)]
pub(super) struct Feed {
    known: Mutex<Known>,
    /// Grows with everything that was heard.
    version: Mutex<u64>,
    changed: Condvar,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    pub(super) fn set_cell(&self, namespace: &str) {
        self.hear(|known| namespace.clone_into(&mut known.cell));
    }

    /// Takes something that was heard.
    pub(super) fn hear(&self, take: impl FnOnce(&mut Known)) {
        take(&mut lock(&self.known));
        *lock(&self.version) += 1;
        self.changed.notify_all();
    }

    /// Waits for something newer than `seen`, at most this long; the newest version.
    pub(super) fn wait_news(&self, seen: u64, most: Duration) -> u64 {
        let version = lock(&self.version);
        let waited = self.changed.wait_timeout_while(version, most, |version| *version <= seen);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// The cell once `is_enough` was heard of it, or after so long as far as it was heard then.
    pub(super) fn look(&self, most: Duration, is_enough: impl Fn(&Known) -> bool) -> Status {
        let deadline = Instant::now() + most;
        let mut seen = 0;
        loop {
            let known = lock(&self.known);
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || is_enough(&known) {
                return Status::of(&known, Instant::now());
            }
            drop(known);
            seen = self.wait_news(seen, left);
        }
    }

    /// Lets some time pass.
    pub(super) fn pause(&self, time: Duration) {
        std::thread::sleep(time);
    }

    /// The status as JSON, and the shape where it is newer than what was seen of it.
    pub(super) fn events(&self, seen: &mut Option<u64>) -> (String, Option<String>) {
        let known = lock(&self.known);
        let status = json(&Status::of(&known, Instant::now()));
        let newest = Some(known.shape_version);
        let shape = (*seen != newest).then(|| json(&Shape::of(&known)));
        *seen = newest;
        (status, shape)
    }

    pub(super) fn snapshot(&self) -> String {
        let (status, shape) = self.events(&mut None);
        format!("{{\"status\":{status},\"shape\":{}}}\n", shape.unwrap_or_else(|| "null".to_owned()))
    }
}

fn json(value: &impl serde::Serialize) -> String {
    // Texts, numbers and lists of them can always be written.
    serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned())
}
