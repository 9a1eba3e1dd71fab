//! Content of the page and of `camwright status`, as JSON: shop units, named in each key.

use super::cell_snapshot::CellSnapshot;
use super::texts::{self, SILENCE, StatusLine, Tone};
use camwright::math::units::{deg_from_rad, rpm_from_rad_s};
use camwright_files::convert::plan::{phase_from, phase_name};
use camwright_files::convert::{mm_from_m, um_from_m as um};
use camwright_msgs::camwright_msgs::msg::{Alarm, LobeForm, MachineDescription, PartLobe};
use camwright_msgs::control_msgs::msg::InterfaceValue;
use serde::Serialize;
use std::time::Instant;

/// The cell in a moment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Status {
    pub(super) cell: String,
    pub(super) machine: String,
    pub(super) state: StatusLine,
    pub(super) verdict: StatusLine,
    pub(super) alarms: Vec<AlarmLine>,
    pub(super) job: Option<JobLine>,
    pub(super) lobe: Option<LobeLine>,
    pub(super) results: Vec<ResultLine>,
    pub(super) axes: Vec<AxisLine>,
    pub(super) wheel: Option<WheelLine>,
    /// Percent of the programmed speed; none without an interpolator.
    pub(super) override_percent: Option<f64>,
    pub(super) is_held: bool,
    pub(super) is_homed: bool,
    /// Who has command of the axes.
    pub(super) holder: String,
    /// Holder of the lease of command over the cell; empty: none.
    pub(super) lease: String,
    pub(super) recorder: Option<RecorderLine>,
    /// Time since the machine's first tick.
    pub(super) machine_time_s: f64,
}

/// An alarm and what to do about it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct AlarmLine {
    pub(super) number: u16,
    pub(super) severity: &'static str,
    pub(super) source: String,
    pub(super) text: String,
    pub(super) remedy: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct JobLine {
    pub(super) name: String,
    pub(super) message: String,
    pub(super) percent: f64,
    pub(super) time_left_s: f64,
}

/// Lobe in work.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct LobeLine {
    pub(super) name: String,
    pub(super) number: usize,
    /// Number of lobes of the job; none before its plan arrives.
    pub(super) count: Option<usize>,
    pub(super) phase: &'static str,
    pub(super) turn: f64,
    pub(super) turns: f64,
    pub(super) stock_um: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct ResultLine {
    pub(super) name: String,
    pub(super) error_um: f64,
    pub(super) rms_um: f64,
    pub(super) allowed_um: f64,
    pub(super) is_good: bool,
    pub(super) duration_s: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct AxisLine {
    pub(super) name: String,
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) following_error: f64,
    pub(super) position_unit: &'static str,
    pub(super) velocity_unit: &'static str,
    pub(super) following_error_unit: &'static str,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct WheelLine {
    pub(super) radius_mm: f64,
    pub(super) wear_um: f64,
    /// None before the machine has reported it.
    pub(super) is_running: Option<bool>,
    /// Position of its cutting point: distance from the axis, and azimuth on the part; not reported for a lathe's
    /// insert.
    pub(super) at_mm: f64,
    pub(super) line_deg: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct RecorderLine {
    pub(super) tone: Tone,
    pub(super) state: String,
    pub(super) bag: String,
    pub(super) megabytes: f64,
    pub(super) written: u64,
    pub(super) dropped: u64,
}

impl Status {
    pub(super) fn from_snapshot(snapshot: &CellSnapshot, now: Instant) -> Self {
        let interpolator = snapshot.interpolator.as_ref().map(|received| &received.message);
        Self {
            cell: snapshot.namespace.clone(),
            machine: snapshot.machine.as_ref().map_or_else(String::new, |machine| machine.name.clone()),
            state: texts::state(snapshot, now),
            verdict: verdict(snapshot),
            alarms: texts::alarms(snapshot).map(alarm).collect(),
            job: job(snapshot),
            lobe: lobe(snapshot),
            results: results(snapshot),
            axes: axes(snapshot),
            wheel: snapshot.machine.as_ref().map(|machine| wheel(machine, snapshot)),
            override_percent: interpolator.map(|state| 100.0 * state.feed_override),
            is_held: interpolator.is_some_and(|state| (2..=4).contains(&state.state)),
            is_homed: interpolator.is_some_and(|state| state.is_homed),
            holder: interpolator.map_or_else(String::new, |state| state.holder.clone()),
            lease: lease(snapshot),
            recorder: recorder(snapshot, now),
            machine_time_s: machine_time_s(snapshot),
        }
    }
}

/// Name of the holder of the lease, and whether others may command too.
fn lease(snapshot: &CellSnapshot) -> String {
    match &snapshot.lease {
        Some(lease) if lease.shared => format!("{} (shared)", lease.holder),
        Some(lease) => lease.holder.clone(),
        None => String::new(),
    }
}

fn machine_time_s(snapshot: &CellSnapshot) -> f64 {
    let cycle_s = snapshot.machine.as_ref().map_or(0.0, |machine| f64::from(machine.cycle_time_ns) * 1e-9);
    snapshot.stream.as_ref().map_or(0.0, |stream| stream.message.tick as f64 * cycle_s)
}

fn alarm(alarm: &Alarm) -> AlarmLine {
    let severity = match alarm.severity {
        Alarm::WARNING => "warning",
        Alarm::STOP => "stop",
        _ => "power off",
    };
    AlarmLine {
        number: alarm.number,
        severity,
        source: alarm.source.clone(),
        text: alarm.text.clone(),
        remedy: alarm.remedy.clone(),
    }
}

fn job(snapshot: &CellSnapshot) -> Option<JobLine> {
    let status = snapshot.job.as_ref().filter(|status| !status.job.is_empty())?;
    let (percent, time_left_s) = snapshot
        .interpolator
        .as_ref()
        .map_or((0.0, 0.0), |received| (received.message.percent, received.message.time_left));
    // What was read of the interpolator before and after is not this job's.
    let (percent, time_left_s) = match status.state {
        2 | 3 => (percent, time_left_s),
        4 => (100.0, 0.0),
        _ => (0.0, 0.0),
    };
    Some(JobLine { name: status.job.clone(), message: status.message.clone(), percent, time_left_s })
}

fn lobe(snapshot: &CellSnapshot) -> Option<LobeLine> {
    let state = &snapshot.interpolator.as_ref()?.message;
    let index = usize::try_from(state.lobe).ok()?;
    let name = snapshot.lobe_in_work().map_or_else(|| format!("number {}", index + 1), str::to_owned);
    Some(LobeLine {
        name,
        number: index + 1,
        count: snapshot.plan_in_work().map(|plan| plan.lobes.len()),
        phase: phase_from(state.phase).map_or("", phase_name),
        turn: state.turn,
        turns: state.turns,
        stock_um: um(state.stock),
    })
}

fn results(snapshot: &CellSnapshot) -> Vec<ResultLine> {
    let Some(status) = &snapshot.job else { return Vec::new() };
    let allowed =
        |name: &str| snapshot.forms.iter().find(|form| form.name == name).map_or(f64::INFINITY, |form| form.tolerance);
    let line = |name: &str, error: f64, rms: f64, allowed: f64, duration_s: f64| ResultLine {
        name: name.to_owned(),
        error_um: um(error),
        rms_um: um(rms),
        allowed_um: um(allowed),
        is_good: error.abs() <= allowed,
        duration_s,
    };
    let lobes = status.lobes.iter().filter(|lobe| allowed(&lobe.name).is_finite());
    let lobes = lobes.map(|l| line(&l.name, l.form_error_max, l.form_error_rms, allowed(&l.name), l.duration));
    let turned = status.turned.iter();
    let turned = turned.map(|t| line(&t.name, t.form_error_max, t.form_error_rms, t.form_error_allowed, t.duration));
    lobes.chain(turned).collect()
}

/// Verdict on the part: set once all of it has been judged, until the next part starts.
fn verdict(snapshot: &CellSnapshot) -> StatusLine {
    let results = results(snapshot);
    let worst =
        results.iter().max_by(|a, b| (a.error_um.abs() / a.allowed_um).total_cmp(&(b.error_um.abs() / b.allowed_um)));
    let Some(worst) = worst else { return StatusLine::new(Tone::Neutral, "", "no part measured yet") };
    let worst_text = format!("{} {:+.2} µm, allowed ±{:.1} µm", worst.name, worst.error_um, worst.allowed_um);
    let bad = results.iter().filter(|result| !result.is_good).count();
    match bad {
        0 => StatusLine::new(Tone::Good, "good", format!("worst: {worst_text}")),
        bad => StatusLine::new(
            Tone::Error,
            "not good",
            format!("{bad} of {} out of tolerance, worst: {worst_text}", results.len()),
        ),
    }
}

fn axes(snapshot: &CellSnapshot) -> Vec<AxisLine> {
    let Some(axes) = &snapshot.axes else { return Vec::new() };
    let linear = |joint: &str| {
        let machine = snapshot.machine.as_ref();
        machine.is_some_and(|machine| machine.axes.iter().any(|axis| axis.joint == joint && axis.linear))
    };
    axes.joint_names
        .iter()
        .zip(&axes.interface_values)
        .map(|(joint, values)| axis(joint, values, linear(joint)))
        .collect()
}

fn axis(joint: &str, values: &InterfaceValue, is_linear: bool) -> AxisLine {
    let value = |name: &str| {
        let at = values.interface_names.iter().position(|interface| interface == name);
        at.and_then(|at| values.values.get(at)).copied().unwrap_or_default()
    };
    let [position, velocity, following_error] = ["position", "velocity", "following_error"].map(value);
    let name = joint.to_owned();
    if is_linear {
        let units = ["mm", "mm/s", "µm"];
        return line(name, [mm_from_m(position), mm_from_m(velocity), um(following_error)], units);
    }
    // One turn is like the other.
    line(
        name,
        [deg_from_rad(position).rem_euclid(360.0), rpm_from_rad_s(velocity), deg_from_rad(following_error)],
        ["°", "1/min", "°"],
    )
}

fn line(name: String, [position, velocity, following_error]: [f64; 3], units: [&'static str; 3]) -> AxisLine {
    let [position_unit, velocity_unit, following_error_unit] = units;
    AxisLine { name, position, velocity, following_error, position_unit, velocity_unit, following_error_unit }
}

fn wheel(machine: &MachineDescription, snapshot: &CellSnapshot) -> WheelLine {
    WheelLine {
        radius_mm: mm_from_m(machine.wheel_radius),
        wear_um: um(machine.wheel_wear),
        is_running: snapshot.io.as_ref().map(|io| io.wheel_running),
        at_mm: mm_from_m(position(snapshot, "x_axis").unwrap_or_default()),
        line_deg: position(snapshot, "c_axis")
            .filter(|_| !machine.stations.is_empty())
            .map(|c| (f64::from(machine.rotation_sense) * deg_from_rad(c)).rem_euclid(360.0)),
    }
}

/// Position of an axis (m or rad).
fn position(snapshot: &CellSnapshot, joint: &str) -> Option<f64> {
    let axes = snapshot.axes.as_ref()?;
    let at = axes.joint_names.iter().position(|other| other == joint)?;
    axes.interface_values.get(at)?.values.first().copied()
}

fn recorder(snapshot: &CellSnapshot, now: Instant) -> Option<RecorderLine> {
    let received = snapshot.recorder.as_ref()?;
    let message = &received.message;
    let (tone, state) = if now.saturating_duration_since(received.at) > SILENCE {
        (Tone::Error, "silent".to_owned())
    } else if message.dropped > 0 {
        (Tone::Error, format!("{} messages lost", message.dropped))
    } else if message.paused {
        (Tone::Attention, "paused".to_owned())
    } else if message.recording {
        (Tone::Good, "recording".to_owned())
    } else {
        (Tone::Attention, "not recording".to_owned())
    };
    let megabytes = message.bytes as f64 / 1e6;
    Some(RecorderLine {
        tone,
        state,
        bag: message.bag.clone(),
        megabytes,
        written: message.written,
        dropped: message.dropped,
    })
}

/// Drawn outline: over the azimuth of the part, in equal steps from the wheel's line at C 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Shape {
    designs: Vec<DesignLine>,
    part: Option<PartLine>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct DesignLine {
    name: String,
    tolerance_um: f64,
    contour_mm: Vec<f64>,
    /// Empty until it was ground.
    error_um: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct PartLine {
    name: String,
    radius_mm: Vec<f64>,
}

impl Shape {
    pub(super) fn from_snapshot(snapshot: &CellSnapshot) -> Self {
        Self { designs: snapshot.forms.iter().map(design).collect(), part: snapshot.outline().map(part) }
    }
}

fn design(form: &LobeForm) -> DesignLine {
    DesignLine {
        name: form.name.clone(),
        tolerance_um: um(form.tolerance),
        contour_mm: form.contour.iter().map(|r| rounded(mm_from_m(*r))).collect(),
        error_um: form.form_error.iter().map(|e| rounded(um(*e))).collect(),
    }
}

fn part(lobe: &PartLobe) -> PartLine {
    PartLine { name: lobe.name.clone(), radius_mm: lobe.radius.iter().map(|r| rounded(mm_from_m(*r))).collect() }
}

/// To five digits following_error the point: hundredths of a micrometre of a radius.
fn rounded(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}
