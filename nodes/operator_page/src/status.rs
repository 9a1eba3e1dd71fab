// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Content of the page and of `camwright status`, as JSON: shop units, named in each key.

use super::cell_snapshot::{CellSnapshot, SILENCE, joint_value};
use super::state_line::{self, StatusLine, Tone};
use camwright::machine::description::Axis;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s};
use camwright_files::convert::plan::{phase_from, phase_name};
use camwright_files::convert::{allowed_form_errors, centre_offset, core_from_si, mm_from_m, um_from_m as um};
use camwright_msgs::camwright_msgs::msg::{Alarm, JobStatus, LobeForm, MachineDescription, PartLobe};
use camwright_msgs::control_msgs::msg::DynamicJointState;
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
    /// Contact of wheel and part; none for a machine that does not report it.
    pub(super) cutting: Option<CuttingLine>,
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
    /// Largest burn index; none without process data.
    pub(super) burn_index: Option<f64>,
    pub(super) verdict: Verdict,
    pub(super) is_good: bool,
    /// Time for the lobe; none before the planner reports it at the end of the job.
    pub(super) duration_s: Option<f64>,
}

/// Verdict on a lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Verdict {
    Good,
    Out,
    Burnt,
}

/// Contact of wheel and part: largest values since the last event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct CuttingLine {
    pub(super) is_in_contact: bool,
    /// Power of the wheel spindle for the cut; none without process data.
    pub(super) power_w: Option<f64>,
    pub(super) normal_force_n: f64,
    /// Force of the drive of `x_axis`.
    pub(super) normal_force_limit_n: Option<f64>,
    pub(super) tangential_force_n: Option<f64>,
    /// Above 1 the part burns.
    pub(super) burn_index: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct AxisLine {
    pub(super) name: String,
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) following_error: f64,
    /// Largest share of the trip level since the last event; none if the machine file is unknown.
    pub(super) following_error_share: Option<f64>,
    pub(super) position_unit: &'static str,
    pub(super) velocity_unit: &'static str,
    pub(super) following_error_unit: &'static str,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct WheelLine {
    /// Name of the mounted wheel of a changer.
    pub(super) name: Option<String>,
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
            state: state_line::state(snapshot, now),
            verdict: verdict(snapshot),
            alarms: state_line::alarms(snapshot).map(alarm).collect(),
            job: job(snapshot),
            lobe: lobe(snapshot),
            results: results(snapshot),
            axes: axes(snapshot),
            wheel: snapshot.machine.as_ref().map(|machine| wheel(machine, snapshot)),
            cutting: cutting(snapshot, now),
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

pub(super) fn alarm(alarm: &Alarm) -> AlarmLine {
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

pub(super) fn job(snapshot: &CellSnapshot) -> Option<JobLine> {
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

/// Results of the planner; during the job those of the lobes that are done, from their outlines.
fn results(snapshot: &CellSnapshot) -> Vec<ResultLine> {
    let reported = snapshot.job.as_ref().filter(|status| !status.lobes.is_empty() || !status.turned.is_empty());
    let Some(status) = reported else {
        return snapshot.forms.iter().filter_map(|form| result_of_outline(snapshot, form)).collect();
    };
    let lobes = status.lobes.iter().filter(|lobe| lobe.form_error_allowed > 0.0).map(|lobe| {
        let burn_index = Some(lobe.burn_index_max).filter(|burn_index| *burn_index > 0.0);
        let errors = (lobe.form_error_max, lobe.form_error_rms);
        ResultLine::new(&lobe.name, errors, lobe.form_error_allowed, burn_index, Some(lobe.duration))
    });
    let turned = status.turned.iter().map(|part| {
        let errors = (part.form_error_max, part.form_error_rms);
        ResultLine::new(&part.name, errors, part.form_error_allowed, None, Some(part.duration))
    });
    lobes.chain(turned).collect()
}

fn result_of_outline(snapshot: &CellSnapshot, form: &LobeForm) -> Option<ResultLine> {
    let errors = snapshot.form_error(form);
    let judged = errors.iter().copied().zip(allowed_form_errors(form));
    let (largest, allowed) = judged.max_by(|a, b| (a.0.abs() / a.1).total_cmp(&(b.0.abs() / b.1)))?;
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    let burn_index = snapshot.progress(&form.name).burn_index;
    Some(ResultLine::new(&form.name, (largest, rms), allowed, burn_index, None))
}

impl ResultLine {
    /// Judges a lobe from its worst error, root mean square and allowed error (m).
    fn new(
        name: &str,
        (error, rms): (f64, f64),
        allowed: f64,
        burn_index: Option<f64>,
        duration_s: Option<f64>,
    ) -> Self {
        let verdict = match burn_index {
            Some(burn_index) if burn_index > 1.0 => Verdict::Burnt,
            _ if error.abs() <= allowed => Verdict::Good,
            _ => Verdict::Out,
        };
        Self {
            name: name.to_owned(),
            error_um: um(error),
            rms_um: um(rms),
            allowed_um: um(allowed),
            burn_index,
            verdict,
            is_good: verdict == Verdict::Good,
            duration_s,
        }
    }
}

/// Verdict on the part: final once all of it is judged, until the next part starts.
fn verdict(snapshot: &CellSnapshot) -> StatusLine {
    let results = results(snapshot);
    let share = |result: &ResultLine| result.error_um.abs() / result.allowed_um;
    let Some(worst) = results.iter().max_by(|a, b| share(a).total_cmp(&share(b))) else {
        return StatusLine::new(Tone::Neutral, "", "no lobe measured yet");
    };
    let error = format!("worst: {} {:+.2} µm, allowed ±{:.1} µm", worst.name, worst.error_um, worst.allowed_um);
    let count = results.len();
    let burnt = results.iter().filter(|result| result.verdict == Verdict::Burnt);
    let hottest =
        burnt.filter_map(|result| Some((result.burn_index?, &result.name))).max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((burn_index, name)) = hottest {
        return StatusLine::new(
            Tone::Error,
            "burnt",
            format!("{name} has burn index {burn_index:.2}, allowed 1; {error}"),
        );
    }
    let out = results.iter().filter(|result| !result.is_good).count();
    if out > 0 {
        return StatusLine::new(Tone::Error, "out", format!("{out} of {count} out of tolerance, {error}"));
    }
    let is_final = results.iter().all(|result| result.duration_s.is_some());
    if is_final {
        return StatusLine::new(Tone::Good, "good", error);
    }
    let ended = [JobStatus::STOPPED, JobStatus::ABORTED];
    let (tone, word) = match &snapshot.job {
        Some(job) if ended.contains(&job.state) => (Tone::Attention, "unfinished"),
        _ => (Tone::Active, "good so far"),
    };
    StatusLine::new(tone, word, format!("{count} of {} lobes measured, {error}", snapshot.forms.len()))
}

fn cutting(snapshot: &CellSnapshot, now: Instant) -> Option<CuttingLine> {
    // Values of a machine that is gone are not live.
    let wheel_joint = &snapshot.machine.as_ref().filter(|_| !snapshot.is_machine_silent(now))?.wheel_joint;
    let normal_force_n = snapshot.peak(wheel_joint, "normal_force")?;
    let power_w = snapshot.peak(wheel_joint, "power");
    let machine = snapshot.machine_file.as_ref();
    let wheel_m_s = machine.map(|machine| machine.wheel.surface_speed_m_s).filter(|speed| *speed > 0.0);
    Some(CuttingLine {
        is_in_contact: normal_force_n > 0.0,
        power_w,
        normal_force_n,
        normal_force_limit_n: machine.map(|machine| machine.axis(Axis::X).maximum_force()),
        tangential_force_n: power_w.zip(wheel_m_s).map(|(power_w, speed)| power_w / speed),
        burn_index: snapshot.peak(wheel_joint, "burn_index"),
    })
}

/// Largest share of the trip level of the following error since the last event.
fn following_error_share(snapshot: &CellSnapshot, joint: &str, velocity: f64) -> Option<f64> {
    let axis = Axis::from_joint(joint)?;
    let description = snapshot.machine_file.as_ref()?.axis(axis);
    let [velocity, peak] = [velocity, snapshot.peak(joint, "following_error")?].map(|value| core_from_si(axis, value));
    let level = description.max_following_error * (velocity / description.limits.velocity).abs();
    Some(peak / level.max(description.min_following_error))
}

fn axes(snapshot: &CellSnapshot) -> Vec<AxisLine> {
    let (Some(axes), Some(machine)) = (snapshot.axes(), &snapshot.machine) else { return Vec::new() };
    let is_reported = |joint: &str| axes.joint_names.iter().any(|name| name == joint);
    let described = machine.axes.iter().filter(|axis| is_reported(&axis.joint));
    described.map(|described| axis(snapshot, axes, &described.joint, described.linear)).collect()
}

fn axis(snapshot: &CellSnapshot, axes: &DynamicJointState, joint: &str, is_linear: bool) -> AxisLine {
    let values = ["position", "velocity", "following_error"];
    let [position, velocity, following_error] =
        values.map(|interface| joint_value(axes, joint, interface).unwrap_or_default());
    let (name, following_error_share) = (joint.to_owned(), following_error_share(snapshot, joint, velocity));
    if is_linear {
        return AxisLine {
            name,
            position: mm_from_m(position),
            velocity: mm_from_m(velocity),
            following_error: um(following_error),
            following_error_share,
            position_unit: "mm",
            velocity_unit: "mm/s",
            following_error_unit: "µm",
        };
    }
    AxisLine {
        name,
        // Full turns are not shown.
        position: deg_from_rad(position).rem_euclid(360.0),
        velocity: rpm_from_rad_s(velocity),
        following_error: deg_from_rad(following_error),
        following_error_share,
        position_unit: "°",
        velocity_unit: "1/min",
        following_error_unit: "°",
    }
}

fn wheel(machine: &MachineDescription, snapshot: &CellSnapshot) -> WheelLine {
    WheelLine {
        name: (!machine.wheel.is_empty()).then(|| machine.wheel.clone()),
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
    joint_value(snapshot.axes()?, joint, "position")
}

fn recorder(snapshot: &CellSnapshot, now: Instant) -> Option<RecorderLine> {
    let received = snapshot.recorder.as_ref()?;
    let message = &received.message;
    let (tone, state) = if snapshot.has_ended && message.dropped == 0 {
        (Tone::Neutral, "ended".to_owned())
    } else if now.saturating_duration_since(received.at) > SILENCE {
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
    /// Allowed error at each azimuth.
    allowed_um: Vec<f64>,
    contour_mm: Vec<f64>,
    /// Centre of a crank pin from the axis; of every other lobe the axis.
    centre_mm: [f64; 2],
    /// Empty until it was ground.
    error_um: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct PartLine {
    name: String,
    radius_mm: Vec<f64>,
    /// Centre of a crank pin from the axis; of every other lobe the axis.
    centre_mm: [f64; 2],
}

impl Shape {
    pub(super) fn from_snapshot(snapshot: &CellSnapshot) -> Self {
        Self {
            designs: snapshot.forms.iter().map(|form| design(snapshot, form)).collect(),
            part: snapshot.outline().map(part),
        }
    }
}

fn design(snapshot: &CellSnapshot, form: &LobeForm) -> DesignLine {
    let measured = snapshot.form_error(form);
    let form_error = if form.form_error.is_empty() { &measured } else { &form.form_error };
    DesignLine {
        name: form.name.clone(),
        allowed_um: allowed_form_errors(form).map(|allowed| rounded(um(allowed))).collect(),
        contour_mm: form.contour.iter().map(|r| rounded(mm_from_m(*r))).collect(),
        centre_mm: centre_mm(&form.centre),
        error_um: form_error.iter().map(|e| rounded(um(*e))).collect(),
    }
}

fn part(lobe: &PartLobe) -> PartLine {
    let radius_mm = lobe.radius.iter().map(|r| rounded(mm_from_m(*r))).collect();
    PartLine { name: lobe.name.clone(), radius_mm, centre_mm: centre_mm(&lobe.centre) }
}

/// Position of a centre from its distance (m) and azimuth (rad).
fn centre_mm(values: &[f64]) -> [f64; 2] {
    centre_offset(values).unwrap_or_default().map(|offset| rounded(mm_from_m(offset)))
}

/// Rounds to five decimals: hundredths of a micrometre of a radius.
fn rounded(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}
