//! Last messages of the topics of a cell.

use camwright_msgs::camwright_msgs::msg::{
    Alarm, CommandHolder, InterpolatorState, JobStatus, LobeForm, MachineDescription, MachineIo, MachineStream,
    PartLobe, PlanHeader, PlanPage, RecorderStatus,
};
use camwright_msgs::control_msgs::msg::DynamicJointState;
use std::time::Instant;

/// Maximum number of lobes that are remembered of a job.
const MAX_LOBES: usize = 64;

/// Last message of a periodic topic and the time of its arrival.
#[derive(Debug)]
pub(super) struct Received<T> {
    pub(super) message: T,
    pub(super) at: Instant,
}

/// Last messages of a cell.
#[derive(Debug, Default)]
pub(super) struct CellSnapshot {
    /// Namespace of the cell.
    pub(super) namespace: String,
    /// Time at which the page began to listen.
    pub(super) since: Option<Instant>,
    /// The cell was ended on purpose; its last state stays on the page.
    pub(super) has_ended: bool,
    pub(super) machine: Option<MachineDescription>,
    pub(super) stream: Option<Received<MachineStream>>,
    pub(super) io: Option<MachineIo>,
    pub(super) axes: Option<DynamicJointState>,
    pub(super) machine_alarms: Vec<Alarm>,
    pub(super) interpolator: Option<Received<InterpolatorState>>,
    pub(super) interpolator_alarms: Vec<Alarm>,
    /// Holder of command over the cell.
    pub(super) lease: Option<CommandHolder>,
    pub(super) job: Option<JobStatus>,
    pub(super) recorder: Option<Received<RecorderStatus>>,
    /// Hash and header of the plan published last.
    pub(super) plan: Option<(String, PlanHeader)>,
    /// Lobes of the job that was planned last, in its order.
    pub(super) forms: Vec<LobeForm>,
    /// Outlines of the lobes, the newest at the end.
    pub(super) outlines: Vec<PartLobe>,
    /// Number of changes of the shape.
    shape_version: u64,
}

impl CellSnapshot {
    /// Returns the number of changes of the shape.
    pub(super) fn shape_version(&self) -> u64 {
        self.shape_version
    }

    /// Adds a design or a form; the first design of another job replaces all before.
    pub(super) fn add_form(&mut self, form: LobeForm) {
        self.shape_version += 1;
        let is_new_part = form.form_error.is_empty()
            && self.forms.iter().any(|other| other.name == form.name && !other.form_error.is_empty());
        if is_new_part || self.forms.first().is_some_and(|first| first.job != form.job) {
            self.forms.clear();
        }
        match self.forms.iter().position(|other| other.name == form.name) {
            Some(at) => self.forms[at] = form,
            None if self.forms.len() < MAX_LOBES => self.forms.push(form),
            None => {}
        }
    }

    pub(super) fn add_outline(&mut self, outline: PartLobe) {
        self.shape_version += 1;
        self.outlines.retain(|other| other.name != outline.name);
        if self.outlines.len() >= MAX_LOBES {
            self.outlines.remove(0);
        }
        self.outlines.push(outline);
    }

    pub(super) fn add_interpolator(&mut self, state: InterpolatorState) {
        let before = self.interpolator.as_ref().map(|received| received.message.lobe);
        self.shape_version += u64::from(before != Some(state.lobe));
        self.interpolator = Some(Received { message: state, at: Instant::now() });
    }

    /// Returns true once every node and the plan in execution were received.
    pub(super) fn is_complete(&self) -> bool {
        let in_execution = self.interpolator.as_ref().map(|received| &received.message.plan_hash);
        let has_plan = in_execution.is_some_and(|hash| hash.is_empty() || self.plan_in_work().is_some());
        let is_machine_known = self.machine.is_some() && self.io.is_some() && self.axes.is_some();
        has_plan && is_machine_known && self.lease.is_some() && self.job.is_some() && self.recorder.is_some()
    }

    /// A page of a plan; the first one has the header.
    pub(super) fn add_page(&mut self, mut page: PlanPage) {
        if let Some(header) = page.header.pop() {
            self.plan = Some((page.plan_hash, header));
        }
    }

    /// Header of the plan in execution.
    pub(super) fn plan_in_work(&self) -> Option<&PlanHeader> {
        let hash = &self.interpolator.as_ref()?.message.plan_hash;
        self.plan.as_ref().filter(|(of, _)| of == hash).map(|(_, header)| header)
    }

    /// Name of the lobe in work.
    pub(super) fn lobe_in_work(&self) -> Option<&str> {
        let index = usize::try_from(self.interpolator.as_ref()?.message.lobe).ok()?;
        self.plan_in_work()?.lobes.get(index).map(String::as_str)
    }

    /// Outline of the lobe in work; without one, the newest.
    pub(super) fn outline(&self) -> Option<&PartLobe> {
        let in_work = self.lobe_in_work().and_then(|name| self.outlines.iter().find(|outline| outline.name == name));
        in_work.or(self.outlines.last())
    }
}
