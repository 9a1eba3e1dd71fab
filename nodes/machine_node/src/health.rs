// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Diagnostics of the machine: its alarms, the timing of its cycle, pending setpoints, drives, wheel and gauge.
//!
//! Each status is about the last second: a level goes up as soon as something is near its bound, and down again when it is not.

use super::buffer_advice::{BufferAdvice, US_PER_MS};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::math::units::{rpm_from_rad_s, um_from_mm};
use camwright::simulation::tick_report::TickReport;
use camwright_machine_cycle::bounds::{Bounds, BusTiming};
use camwright_machine_cycle::pacing::Pace;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use camwright_ros::realtime::Realtime;
use camwright_ros::running::NodeError;
use camwright_ros::{Diagnostics, Node, diagnostic_status};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Nanoseconds of a microsecond.
const NS_PER_US: f64 = 1000.0;
/// Shares of the alarm limit of the following error at which a warning and an error begin.
const NEAR: (f64, f64) = (0.7, 0.9);
/// Share of the drive limit from which on a force counts as limited.
const LIMITED: f64 = 0.99;
/// Share of the time with a limited force from which on a drive is too weak. A drive uses its whole force to speed up: short times are normal.
const TOO_WEAK: f64 = 0.5;
/// Shares of the feedback delay below which setpoints come late.
const LATE: (f64, f64) = (0.2, 0.05);
/// Shares of a wheel's usable radius below which it is about to be worn.
const WORN: (f64, f64) = (0.1, 0.02);

/// Time behind the system clock from which on stamps are too old (µs).
const SLIPPED_US: i64 = 50_000;

/// Values since the last report.
#[derive(Debug, Default)]
struct ReportedPeaks {
    /// Largest following error, as a share of that at which the drive trips.
    following: [f64; AXIS_COUNT],
    /// Largest force, as a share of what the drive has.
    force: [f64; AXIS_COUNT],
    /// Ticks with a force at the limit of the drive, and all ticks.
    limited_ticks: [u64; AXIS_COUNT],
    ticks: u64,
    wheel_rad_s: f64,
    readings: u64,
    last_reading_mm: Option<f64>,
    is_before_a_lobe: bool,
    lasting: Option<PersistentState>,
}

/// Health reports of the machine's threads.
#[derive(Debug, Clone, Default)]
pub(super) struct Health(Arc<Mutex<ReportedPeaks>>);

impl Health {
    fn seen(&self) -> MutexGuard<'_, ReportedPeaks> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks at a tick.
    pub(super) fn see(&self, report: &TickReport, machine: &MachineDescription) {
        let mut seen = self.seen();
        for axis in Axis::ALL {
            let (description, axis_report) = (machine.axis(axis), &report.axes[axis.index()]);
            let speed = (axis_report.velocity / description.limits.velocity).abs();
            let trips_at = (description.max_following_error * speed).max(description.min_following_error);
            let following = (axis_report.following_error / trips_at).abs();
            let force = (axis_report.effort / description.maximum_force()).abs();
            let place = axis.index();
            seen.following[place] = seen.following[place].max(following);
            seen.force[place] = seen.force[place].max(force);
            seen.limited_ticks[place] += u64::from(force >= LIMITED);
        }
        seen.ticks += 1;
        seen.wheel_rad_s = report.wheel_rad_s;
        seen.is_before_a_lobe = report.lobe.is_some();
        if let Some(reading_mm) = report.gauge_mm[0] {
            seen.readings += 1;
            seen.last_reading_mm = Some(reading_mm);
        }
    }

    /// Records a change of the persistent state.
    pub(super) fn update(&self, lasting: &PersistentState) {
        self.seen().lasting = Some(*lasting);
    }

    /// Reports once a second.
    pub(super) fn report(
        &self,
        node: &Node,
        machine: &MachineDescription,
        bounds: &Arc<Bounds>,
        (pace, realtime): (Pace, Realtime),
    ) -> Result<Diagnostics, NodeError> {
        bounds.min_lead_ticks.store(u64::MAX, Ordering::Relaxed);
        let (health, bounds, described) = (self.clone(), Arc::clone(bounds), machine.clone());
        let (mut late_before, mut dropped_before, mut slips_before, mut underruns_before) = (0, 0, 0, 0);
        let mut buffer = BufferAdvice::new(node, machine);
        let report = move || {
            let mut all = vec![
                cycle(&bounds, &mut late_before, [realtime.text(), realtime.text_of_others()]),
                setpoints(&bounds, &described, pace),
            ];
            all.push(telemetry(bounds.drops.count(), &mut dropped_before));
            if pace == Pace::Realtime {
                all.push(clock(&bounds, &mut slips_before));
                all.push(buffer.report(&bounds));
            }
            all.extend(drive_queue(&bounds.bus, &mut underruns_before));
            let mut seen = health.seen();
            all.push(drives(&seen));
            all.push(wheel(&seen, &described));
            if described.gauge.is_some() {
                all.push(gauge(&seen));
            }
            *seen = ReportedPeaks { lasting: seen.lasting, ..ReportedPeaks::default() };
            all
        };
        Ok(node.diagnostics(&machine.name, report)?)
    }
}

/// Alarms, and how well ticks keep the pace of the clock.
fn cycle(bounds: &Bounds, late_before: &mut u64, scheduling: [String; 2]) -> DiagnosticStatus {
    let [cyclic, others] = scheduling;
    let read = |value: &AtomicU64| value.load(Ordering::Relaxed);
    let (alarms, late, worst_us) =
        (read(&bounds.alarms), read(&bounds.late_ticks), bounds.worst_late_us.swap(0, Ordering::Relaxed));
    let late_now = late - std::mem::replace(late_before, late);
    let (level, message) = match (alarms, late_now) {
        (0, 0) => (DiagnosticStatus::OK, "running".to_owned()),
        (0, late) if late < 10 => (DiagnosticStatus::WARN, format!("{late} ticks late in the last second")),
        (0, late) => {
            (DiagnosticStatus::ERROR, format!("{late} ticks late in the last second: reduce the load of the computer"))
        }
        (alarms, _) => (DiagnosticStatus::ERROR, format!("{alarms} alarms need a reset")),
    };
    let values = [
        ("tick", read(&bounds.tick).to_string()),
        ("late_ticks", late.to_string()),
        ("late_in_the_last_second", late_now.to_string()),
        ("latest_us", worst_us.to_string()),
        ("scheduling", cyclic),
        ("scheduling_of_other_threads", others),
    ];
    diagnostic_status(level, "", &message, &values)
}

/// Samples that were dropped because a subscriber does not acknowledge.
fn telemetry(dropped: u64, before: &mut u64) -> DiagnosticStatus {
    let now = dropped - std::mem::replace(before, dropped);
    let (level, message) = match now {
        0 => (DiagnosticStatus::OK, "every message is sent".to_owned()),
        now => {
            (DiagnosticStatus::WARN, format!("{now} messages dropped in the last second: a subscriber is gone or slow"))
        }
    };
    let values = [("dropped", dropped.to_string()), ("dropped_in_the_last_second", now.to_string())];
    diagnostic_status(level, "telemetry", &message, &values)
}

/// Status of the stamps against the system clock.
fn clock(bounds: &Bounds, slips_before: &mut u64) -> DiagnosticStatus {
    let (slips, behind_us) = (bounds.slips.load(Ordering::Relaxed), bounds.behind_us.load(Ordering::Relaxed));
    let slips_now = slips - std::mem::replace(slips_before, slips);
    let behind_ms = behind_us as f64 / US_PER_MS;
    let level =
        if slips_now > 0 || behind_us.abs() > SLIPPED_US { DiagnosticStatus::WARN } else { DiagnosticStatus::OK };
    let message = format!("stamps are {behind_ms:.1} ms behind the system clock, {slips} slips since the start");
    diagnostic_status(level, "clock", &message, &[("behind_us", behind_us.to_string()), ("slips", slips.to_string())])
}

/// Status of the setpoint buffer: lead of a setpoint over its use.
fn setpoints(bounds: &Bounds, machine: &MachineDescription, pace: Pace) -> DiagnosticStatus {
    let min = bounds.min_lead_ticks.swap(u64::MAX, Ordering::Relaxed);
    let ahead = u64::from(machine.feedback_delay_ticks);
    if min == u64::MAX {
        return diagnostic_status(DiagnosticStatus::OK, "setpoints", "none in the last second", &[]);
    }
    let share = min as f64 / ahead as f64;
    // At pace fast ticks wait for their setpoints.
    let level = if pace == Pace::Fast { DiagnosticStatus::OK } else { below(share, LATE) };
    let message = format!("they arrived at least {min} of {ahead} ticks before use");
    let values = [("least_lead_ticks", min.to_string()), ("feedback_delay_ticks", ahead.to_string())];
    diagnostic_status(level, "setpoints", &message, &values)
}

/// Status of the queue to real drives and of their clock; `None`: the machine is simulated.
fn drive_queue(bus: &BusTiming, underruns_before: &mut u64) -> Option<DiagnosticStatus> {
    let read = |value: &AtomicU64| value.load(Ordering::Relaxed);
    let (full, queued, underruns) = (read(&bus.queue_ticks), read(&bus.queued), read(&bus.underruns));
    if full == 0 {
        return None;
    }
    let min = bus.min_queued.swap(u64::MAX, Ordering::Relaxed);
    let jitter_us = bus.max_jitter_ns.swap(0, Ordering::Relaxed) as f64 / NS_PER_US;
    let underruns_now = underruns - std::mem::replace(underruns_before, underruns);
    let (level, message) = match (underruns_now, min) {
        (1.., _) => (
            DiagnosticStatus::ERROR,
            "the queue ran empty: reduce the load of the computer, or raise hal.fifo_ticks".to_owned(),
        ),
        (0, u64::MAX) => (DiagnosticStatus::WARN, "the drives did not follow in the last second".to_owned()),
        (0, min) => (
            below(min as f64 / full as f64, LATE),
            format!("at least {min} of {full} setpoints waited, jitter of the servo period up to {jitter_us:.0} µs"),
        ),
    };
    let min = if min == u64::MAX { String::new() } else { min.to_string() };
    let values = [
        ("queued", queued.to_string()),
        (BusTiming::MIN_QUEUED, min),
        (BusTiming::QUEUE_TICKS, full.to_string()),
        (BusTiming::MAX_JITTER_US, format!("{jitter_us:.1}")),
        (BusTiming::UNDERRUNS, underruns.to_string()),
    ];
    Some(diagnostic_status(level, BusTiming::STATUS, &message, &values))
}

/// Status of the drives: following errors against the limits at which they trip, and forces.
///
/// A force at its limit is no fault: drives need it to speed up. One that lasts means that the axis cannot follow what is asked of it.
fn drives(seen: &ReportedPeaks) -> DiagnosticStatus {
    let percent = |share: f64| format!("{:.0}", 100.0 * share);
    let max = |shares: &[f64; AXIS_COUNT]| shares.iter().copied().fold(0.0, f64::max);
    let limited = seen.limited_ticks.map(|ticks| ticks as f64 / seen.ticks.max(1) as f64);
    let weak = Axis::ALL.into_iter().find(|axis| limited[axis.index()] > TOO_WEAK);
    let of_following = above(max(&seen.following), NEAR);
    let (level, message) = match weak {
        Some(axis) if of_following == DiagnosticStatus::OK => (
            DiagnosticStatus::WARN,
            format!(
                "{} needs the whole force of its drive for {} % of the time: reduce its acceleration or its load",
                axis.joint(),
                percent(limited[axis.index()])
            ),
        ),
        _ => (
            of_following,
            format!(
                "force up to {} % of the drive limit, following error up to {} % of the alarm limit",
                percent(max(&seen.force)),
                percent(max(&seen.following))
            ),
        ),
    };
    let values: Vec<(String, String)> = Axis::ALL
        .into_iter()
        .flat_map(|axis| {
            let (joint, place) = (axis.joint(), axis.index());
            [
                (format!("{joint}_force_percent"), percent(seen.force[place])),
                (format!("{joint}_following_percent"), percent(seen.following[place])),
                (format!("{joint}_force_limited_percent"), percent(limited[place])),
            ]
        })
        .collect();
    let values: Vec<(&str, String)> = values.iter().map(|(key, value)| (key.as_str(), value.clone())).collect();
    diagnostic_status(level, "drives", &message, &values)
}

/// Status of the wheel: remaining radius.
fn wheel(seen: &ReportedPeaks, machine: &MachineDescription) -> DiagnosticStatus {
    let speed = ("speed_rpm", format!("{:.0}", rpm_from_rad_s(seen.wheel_rad_s)));
    let (Some(lasting), false) = (&seen.lasting, machine.is_lathe()) else {
        return diagnostic_status(DiagnosticStatus::OK, "wheel", "no wear is known of", &[speed]);
    };
    let radius_mm = lasting.wheel_radius_mm - lasting.wheel_wear_mm;
    let mounted = machine.wheel_changer.as_ref().and_then(|changer| changer.wheels.get(lasting.mounted_wheel()));
    let described = mounted.map_or(&machine.wheel, |mounted| &mounted.wheel);
    let (new_mm, min_mm) = (described.new_radius_mm, described.min_radius_mm);
    let level = below((radius_mm - min_mm) / (new_mm - min_mm).max(f64::MIN_POSITIVE), WORN);
    let message = format!("{radius_mm:.3} mm in radius, worn at {min_mm:.3} mm");
    let mut values = vec![
        speed,
        ("radius_mm", format!("{radius_mm:.4}")),
        ("wear_since_dress_um", format!("{:.2}", um_from_mm(lasting.wheel_wear_mm))),
        ("lobes_since_dress", lasting.lobes_since_dress.to_string()),
    ];
    values.extend(mounted.map(|mounted| ("mounted", mounted.name.clone())));
    diagnostic_status(level, "wheel", &message, &values)
}

/// Status of the gauge.
fn gauge(seen: &ReportedPeaks) -> DiagnosticStatus {
    let message = match (seen.readings, seen.is_before_a_lobe) {
        (0, _) => "no readings in the last second".to_owned(),
        (readings, _) => format!("{readings} readings in the last second"),
    };
    let last = seen.last_reading_mm.map_or_else(String::new, |mm| format!("{mm:.5}"));
    let values = [
        ("readings", seen.readings.to_string()),
        ("last_reading_mm", last),
        ("lobe_before_the_wheel", seen.is_before_a_lobe.to_string()),
    ];
    diagnostic_status(DiagnosticStatus::OK, "gauge", &message, &values)
}

fn above(share: f64, (warning, error): (f64, f64)) -> u8 {
    if share >= error {
        DiagnosticStatus::ERROR
    } else if share >= warning {
        DiagnosticStatus::WARN
    } else {
        DiagnosticStatus::OK
    }
}

fn below(share: f64, (warning, error): (f64, f64)) -> u8 {
    above(-share, (-warning, -error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_escalate_towards_their_bound_and_come_down_again() {
        let levels = [0.1, 0.7, 0.89, 0.9, 2.0].map(|share| above(share, NEAR));
        let (ok, warn, error) = (DiagnosticStatus::OK, DiagnosticStatus::WARN, DiagnosticStatus::ERROR);
        assert_eq!(levels, [ok, warn, warn, error, error]);
        assert_eq!([0.5, 0.2, 0.1, 0.05, 0.0].map(|share| below(share, LATE)), [ok, warn, warn, error, error]);
    }

    #[test]
    fn a_force_at_its_limit_is_reported_once_it_lasts() {
        let x = Axis::X.index();
        let mut seen = ReportedPeaks { ticks: 1000, ..ReportedPeaks::default() };
        (seen.force[x], seen.limited_ticks[x], seen.following[x]) = (1.0, 400, 0.3);
        let status = drives(&seen);
        assert_eq!(status.level, DiagnosticStatus::OK, "it speeds up: {}", status.message);
        assert!(status.message.starts_with("force up to 100 % of the drive limit"), "{}", status.message);
        let limited = status.values.iter().find(|pair| pair.key == "x_axis_force_limited_percent");
        assert_eq!(limited.map(|pair| pair.value.as_str()), Some("40"));
        seen.limited_ticks[x] = 600;
        let status = drives(&seen);
        assert_eq!(status.level, DiagnosticStatus::WARN, "{}", status.message);
        assert!(status.message.starts_with("x_axis needs the whole force of its drive for 60 %"), "{}", status.message);
        seen.following[x] = 0.95;
        let status = drives(&seen);
        assert_eq!(status.level, DiagnosticStatus::ERROR, "it is about to trip: {}", status.message);
        assert!(status.message.contains("following error up to 95 %"), "{}", status.message);
    }

    #[test]
    fn the_queue_to_the_drives_is_reported_with_its_least_since_the_last_report() {
        let (bus, mut before) = (BusTiming::default(), 0);
        assert_eq!(drive_queue(&bus, &mut before), None, "simulated drives have no queue");
        bus.queue_ticks.store(150, Ordering::Relaxed);
        bus.min_queued.store(u64::MAX, Ordering::Relaxed);
        let mut report = || drive_queue(&bus, &mut before).expect("a queue");
        assert_eq!(report().level, DiagnosticStatus::WARN, "nothing follows");
        for (queued, jitter_ns) in [(148, 2_000), (120, 85_400), (149, 3_000)] {
            bus.see(queued, jitter_ns);
        }
        let status = report();
        let values: Vec<String> = status.values.iter().map(|pair| format!("{}={}", pair.key, pair.value)).collect();
        let wanted = ["queued=149", "min_queued=120", "queue_ticks=150", "max_jitter_us=85.4", "underruns=0"];
        assert_eq!((status.level, values), (DiagnosticStatus::OK, wanted.map(str::to_owned).to_vec()));
        // A fifth of the queue is near its end.
        bus.see(30, 1_000);
        let status = report();
        assert_eq!(status.level, DiagnosticStatus::WARN, "{}", status.message);
        assert!(status.message.contains("at least 30 of 150") && status.message.contains("1 µs"), "{}", status.message);
        bus.see(0, 1_000);
        bus.underruns.store(1, Ordering::Relaxed);
        assert_eq!(report().level, DiagnosticStatus::ERROR);
        bus.see(150, 1_000);
        assert_eq!(report().level, DiagnosticStatus::OK, "an underrun is of its second");
    }

    #[test]
    fn late_ticks_and_late_setpoints_are_those_of_the_last_second() {
        let bounds = Bounds::default();
        let mut before = 0;
        bounds.min_lead_ticks.store(u64::MAX, Ordering::Relaxed);
        assert_eq!(cycle(&bounds, &mut before, [const { String::new() }; 2]).level, DiagnosticStatus::OK);
        bounds.late_ticks.store(3, Ordering::Relaxed);
        assert_eq!(cycle(&bounds, &mut before, [const { String::new() }; 2]).level, DiagnosticStatus::WARN);
        bounds.late_ticks.store(40, Ordering::Relaxed);
        assert_eq!(cycle(&bounds, &mut before, [const { String::new() }; 2]).level, DiagnosticStatus::ERROR);
        assert_eq!(
            cycle(&bounds, &mut before, [const { String::new() }; 2]).level,
            DiagnosticStatus::OK,
            "a second without one"
        );
    }
}
