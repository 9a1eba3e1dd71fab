// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Last messages of the topics of a cell.

use camwright::machine::description::MachineDescription as Machine;
use camwright_files::convert::machine_now::described_machine;
use camwright_msgs::camwright_msgs::msg::{
    Alarm, CommandHolder, InterpolatorState, JobStatus, LobeForm, MachineDescription, MachineIo, MachineStream,
    PartLobe, PlanHeader, PlanPage, RecorderStatus,
};
use camwright_msgs::control_msgs::msg::DynamicJointState;
use camwright_ros::from_time;
use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

/// A node without a message for this time counts as missing.
pub(super) const SILENCE: Duration = Duration::from_secs(3);

/// Maximum number of lobes that are remembered of a job.
const MAX_LOBES: usize = 64;

/// Time over which viewers see the largest process values and following errors: that between two events.
const PEAK_HOLD: Duration = Duration::from_millis(250);
/// Maximum number of axis states in that time; at pace fast there are more.
const MAX_STATES: usize = 256;

/// Work on a lobe since the job began.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct LobeProgress {
    /// Largest burn index so far; `None` without process data.
    pub(super) burn_index: Option<f64>,
    /// The next motion has begun.
    is_done: bool,
}

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
    /// Machine file of the description; `None` if this version cannot read it.
    pub(super) machine_file: Option<Box<Machine>>,
    pub(super) stream: Option<Received<MachineStream>>,
    /// Time of the machine when its first message arrived (ns); none before.
    heard_since_ns: Option<i64>,
    pub(super) io: Option<MachineIo>,
    /// States of axes and wheel in the last [`PEAK_HOLD`], the newest at the end.
    axes: VecDeque<Received<DynamicJointState>>,
    /// Work on the lobes, by their names.
    progress: BTreeMap<String, LobeProgress>,
    /// `None` before the machine has reported them.
    pub(super) machine_alarms: Option<Vec<Alarm>>,
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
    /// Time at which the last message of a latched topic arrived.
    pub(super) latched_at: Option<Instant>,
    /// Number of changes of the shape.
    shape_version: u64,
}

impl CellSnapshot {
    pub(super) fn add_machine(&mut self, machine: MachineDescription) {
        self.machine_file = described_machine(&machine, &[]).ok().map(Box::new);
        self.machine = Some(machine);
    }

    pub(super) fn add_stream(&mut self, message: MachineStream) {
        let now_ns = from_time(&message.stamp);
        // A machine that was started again may begin at an earlier time.
        self.heard_since_ns = Some(self.heard_since_ns.map_or(now_ns, |since_ns| since_ns.min(now_ns)));
        self.stream = Some(Received { message, at: Instant::now() });
    }

    pub(super) fn add_axes(&mut self, message: DynamicJointState) {
        let at = Instant::now();
        let burn_index = joint_value(&message, "wheel_spindle", "burn_index");
        if let (Some(lobe), Some(burn_index)) = (self.lobe_in_work().map(str::to_owned), burn_index) {
            let progress = self.progress.entry(lobe).or_default();
            progress.burn_index = Some(progress.burn_index.unwrap_or(0.0).max(burn_index));
        }
        self.axes.retain(|state| at.saturating_duration_since(state.at) < PEAK_HOLD);
        if self.axes.len() >= MAX_STATES {
            self.axes.pop_front();
        }
        self.axes.push_back(Received { message, at });
    }

    /// Returns true if the machine sends no messages.
    pub(super) fn is_machine_silent(&self, now: Instant) -> bool {
        self.stream.as_ref().is_none_or(|stream| now.saturating_duration_since(stream.at) > SILENCE)
    }

    /// Returns true if the interpolator sends no messages.
    pub(super) fn is_interpolator_silent(&self, now: Instant) -> bool {
        self.interpolator.as_ref().is_none_or(|state| now.saturating_duration_since(state.at) > SILENCE)
    }

    /// Newest state of axes and wheel.
    pub(super) fn axes(&self) -> Option<&DynamicJointState> {
        self.axes.back().map(|state| &state.message)
    }

    /// Largest amount of an interface of a joint since the last event.
    pub(super) fn peak(&self, joint: &str, interface: &str) -> Option<f64> {
        let values = self.axes.iter().filter_map(|state| joint_value(&state.message, joint, interface));
        values.map(f64::abs).reduce(f64::max)
    }

    pub(super) fn add_job(&mut self, job: JobStatus) {
        if job.state == JobStatus::PLANNING {
            self.progress.clear();
        }
        self.job = Some(job);
    }

    /// Work on a lobe in this job.
    pub(super) fn progress(&self, lobe: &str) -> LobeProgress {
        self.progress.get(lobe).copied().unwrap_or_default()
    }

    /// Deviations of a finished lobe from its design along the normal (m), before the planner reports them; empty until then.
    pub(super) fn form_error(&self, design: &LobeForm) -> Vec<f64> {
        let finishes = |half: u8| half == PlanHeader::WHOLE || half == PlanHeader::SECOND;
        let is_of_job = self.plan.as_ref().is_some_and(|(_, plan)| plan.job == design.job && finishes(plan.half));
        let is_done = is_of_job && self.progress(&design.name).is_done;
        // An outline from before its end still has stock.
        let is_final = |outline: &&PartLobe| outline.name == design.name && outline.finished;
        let outline = self.outlines.iter().find(is_final).filter(|_| is_done);
        outline.map_or_else(Vec::new, |outline| deviations(&design.contour, &outline.radius))
    }

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
        if state.state == InterpolatorState::EXECUTING
            && before.is_some_and(|lobe| lobe != state.lobe)
            && let Some(lobe) = self.lobe_in_work().map(str::to_owned)
        {
            self.progress.entry(lobe).or_default().is_done = true;
        }
        self.shape_version += u64::from(before != Some(state.lobe));
        self.interpolator = Some(Received { message: state, at: Instant::now() });
    }

    /// Returns true once every node and the plan in execution were received.
    pub(super) fn is_complete(&self) -> bool {
        let in_execution = self.interpolator.as_ref().map(|received| &received.message.plan_hash);
        let has_plan = in_execution.is_some_and(|hash| hash.is_empty() || self.plan_in_work().is_some());
        let is_machine_known =
            self.machine.is_some() && self.io.is_some() && self.machine_alarms.is_some() && !self.axes.is_empty();
        has_plan
            && self.is_current()
            && is_machine_known
            && self.lease.is_some()
            && self.job.is_some()
            && self.recorder.is_some()
    }

    /// Returns false while the interpolator's state is from before the first message of the machine: its writer repeats older messages to
    /// a late reader, and they may take a second.
    pub(super) fn is_current(&self) -> bool {
        match (self.heard_since_ns, &self.interpolator) {
            (Some(since_ns), Some(state)) => from_time(&state.message.stamp) >= since_ns,
            _ => true,
        }
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

/// Value of an interface of a joint.
pub(super) fn joint_value(state: &DynamicJointState, joint: &str, interface: &str) -> Option<f64> {
    let index = state.joint_names.iter().position(|name| name == joint)?;
    let values = state.interface_values.get(index)?;
    let at = values.interface_names.iter().position(|name| name == interface)?;
    values.values.get(at).copied()
}

/// Deviations of radii from a contour along its normal, both in equal steps over a turn (m).
fn deviations(contour: &[f64], radius: &[f64]) -> Vec<f64> {
    let count = contour.len();
    if count < 3 || radius.len() != count {
        return Vec::new();
    }
    let step = 2.0 * std::f64::consts::TAU / count as f64;
    let deviation = |i: usize| {
        let slope = (contour[(i + 1) % count] - contour[(i + count - 1) % count]) / step;
        (radius[i] - contour[i]) * contour[i].abs() / slope.hypot(contour[i])
    };
    (0..count).map(deviation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// States of a job that has ended since then arrive first, however close to the machine's time they are.
    #[test]
    fn repeated_states_are_not_current() {
        let stamp = |ns: i64| camwright_ros::to_time(ns);
        let stream = |ns: i64| MachineStream { stamp: stamp(ns), ..MachineStream::default() };
        let state = |ns: i64| InterpolatorState { stamp: stamp(ns), ..InterpolatorState::default() };
        let mut snapshot = CellSnapshot::default();
        snapshot.add_interpolator(state(9_000_000_000));
        snapshot.add_stream(stream(10_000_000_000));
        assert!(!snapshot.is_current());
        snapshot.add_stream(stream(10_050_000_000));
        snapshot.add_interpolator(state(9_999_000_000));
        assert!(!snapshot.is_current());
        snapshot.add_interpolator(state(10_000_000_000));
        assert!(snapshot.is_current());
        // The machine was started again.
        snapshot.add_stream(stream(1_000_000_000));
        snapshot.add_interpolator(state(1_500_000_000));
        assert!(snapshot.is_current());
    }

    /// A lobe is judged by its outline after the wheel has left it, whichever message comes first.
    #[test]
    fn an_outline_from_before_the_end_of_a_lobe_is_not_judged() {
        let mut snapshot = CellSnapshot::default();
        let header = PlanHeader { job: "job".into(), lobes: vec!["A".into(), "B".into()], ..PlanHeader::default() };
        snapshot.add_page(PlanPage { plan_hash: "1".into(), header: vec![header], ..PlanPage::default() });
        let state = |tick: u64, lobe: i32| InterpolatorState {
            tick,
            lobe,
            plan_hash: "1".into(),
            state: InterpolatorState::EXECUTING,
            ..InterpolatorState::default()
        };
        let outline = |finished: bool, radius: f64| PartLobe {
            finished,
            name: "A".into(),
            radius: vec![radius; 8],
            ..PartLobe::default()
        };
        let design = LobeForm { job: "job".into(), name: "A".into(), contour: vec![0.02; 8], ..LobeForm::default() };
        for is_outline_first in [false, true] {
            snapshot.add_job(JobStatus { state: JobStatus::PLANNING, ..JobStatus::default() });
            snapshot.add_interpolator(state(10, 0));
            snapshot.add_outline(outline(false, 0.020_3));
            assert!(snapshot.form_error(&design).is_empty(), "in work");
            if is_outline_first {
                snapshot.add_outline(outline(true, 0.020_001));
                assert!(snapshot.form_error(&design).is_empty(), "the next motion has not begun");
            }
            snapshot.add_interpolator(state(20, 1));
            if !is_outline_first {
                assert!(snapshot.form_error(&design).is_empty(), "its outline is old");
                snapshot.add_outline(outline(true, 0.020_001));
            }
            let error = snapshot.form_error(&design);
            assert!(error.len() == 8 && error.iter().all(|error| (error - 1e-6).abs() < 1e-12), "{error:?}");
        }
    }

    /// A circle beside the axis that is larger than its design has the same excess everywhere along the normal.
    #[test]
    fn deviations_are_those_along_the_normal() {
        let circle = |radius: f64| {
            let at = move |i: u32| {
                let angle = std::f64::consts::TAU * f64::from(i) / 720.0;
                let beside = 0.004 * angle.sin();
                0.004 * angle.cos() + (radius * radius - beside * beside).sqrt()
            };
            (0..720).map(at).collect::<Vec<f64>>()
        };
        let found = deviations(&circle(0.02), &circle(0.02 + 3e-6));
        assert!(found.len() == 720 && found.iter().all(|excess| (excess - 3e-6).abs() < 2e-9), "{found:?}");
        assert!(deviations(&circle(0.02), &[0.02; 90]).is_empty(), "of a turned part");
    }
}
