// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Preview of a job without publishing its plan: `~/preview_job`.

use super::{Shared, lock};
use camwright::machine::description::Axis;
use camwright::math::units::TURN_RAD;
use camwright::motion::cut_motion::chain;
use camwright_files::convert::time::duration_from_ns;
use camwright_files::convert::{m_from_mm, mm_from_m, si_from_core};
use camwright_msgs::builtin_interfaces::msg::Duration;
use camwright_msgs::camwright_msgs::srv::{PreviewJobRequest, PreviewJobResponse};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_planning::{self as planning, AnyPrepared, PreparedJob, PreparedTurning};

/// Points of a preview over one turn unless the request says otherwise: one per degree.
const PREVIEW_POINTS: u32 = 360;
/// Most points of a preview.
const MAX_PREVIEW_POINTS: u32 = 3600;

pub(super) fn answer(shared: &Shared, request: &PreviewJobRequest) -> PreviewJobResponse {
    match preview(shared, request) {
        Ok(response) => response,
        Err(message) => PreviewJobResponse { message, ..PreviewJobResponse::default() },
    }
}

fn preview(shared: &Shared, request: &PreviewJobRequest) -> Result<PreviewJobResponse, String> {
    let points = match request.points {
        0 => PREVIEW_POINTS,
        points if points <= MAX_PREVIEW_POINTS => points,
        points => return Err(format!("{points} points, at most {MAX_PREVIEW_POINTS} are allowed")),
    };
    let machine = lock(&shared.machine).clone();
    super::settings::check_against_job(shared.node.parameters(), &request.job, &request.overrides)?;
    let overrides = shared.used(&request.job, &request.overrides, machine.as_ref())?;
    let prepared = planning::prepare_any(&request.job, &overrides, machine.as_ref());
    match prepared.map_err(|error| error.to_string())? {
        AnyPrepared::Ground(prepared) => preview_lobe(&prepared, &request.lobe, points),
        AnyPrepared::Turned(prepared) => preview_part(&prepared, mm_from_m(request.z), points),
    }
}

/// A lobe that is ground.
fn preview_lobe(prepared: &PreparedJob, lobe: &str, points: u32) -> Result<PreviewJobResponse, String> {
    let names = &prepared.planned.plan.lobes;
    let lobe = match lobe {
        "" => 0,
        wanted => names
            .iter()
            .position(|name| name == wanted)
            .ok_or_else(|| format!("unknown lobe {wanted}; the lobes are {}", names.join(", ")))?,
    };
    let contour = &prepared.planned.lobes[lobe].design.contour;
    let radius = |i: u32| m_from_mm(contour.radius_at(f64::from(i) * TURN_RAD / f64::from(points)));
    Ok(PreviewJobResponse {
        success: true,
        message: prepared.summary(),
        duration: prepared.planned.plan.duration_s,
        duration_with_indexing: prepared.planned.plan.duration_with_indexing_s,
        contour_radius: (0..points).map(radius).collect(),
        turn: one_turn(prepared, lobe, points),
    })
}

/// The section of a turned part at a place along it, and the turn of its last pass in which the insert is there.
fn preview_part(prepared: &PreparedTurning, z_mm: f64, points: u32) -> Result<PreviewJobResponse, String> {
    let (spec, plan) = (&prepared.job.spec, &prepared.planned.plan);
    let (from_mm, to_mm) = spec.range_mm();
    if !(from_mm..=to_mm).contains(&z_mm) {
        return Err(format!("z is {z_mm} mm; the part is turned from {from_mm} to {to_mm} mm"));
    }
    let radius = |i: u32| m_from_mm(spec.surface.radius(f64::from(i) * TURN_RAD / f64::from(points), z_mm));
    Ok(PreviewJobResponse {
        success: true,
        message: prepared.summary(),
        duration: plan.duration_s,
        duration_with_indexing: plan.duration_s,
        contour_radius: (0..points).map(radius).collect(),
        turn: turn_at(prepared, z_mm, points).unwrap_or_default(),
    })
}

/// One turn of the last pass at its speed, the insert's centre at a place along the part in the middle of it.
fn turn_at(prepared: &PreparedTurning, z_mm: f64, points: u32) -> Option<JointTrajectory> {
    let pass = prepared.planned.passes.last()?;
    let (path, law) = (&pass.path, &pass.spindle.law);
    let (start, end) = (path.x().start(), path.x().end());
    // z runs one way along the path, and so does the angle over the time.
    let falls = path.z_at(end).value < path.z_at(start).value;
    let is_before = |at: f64| (path.z_at(at).value > z_mm) == falls;
    let middle = bisected(start, end, is_before);
    let first = (middle - 0.5 * TURN_RAD).clamp(start, (end - TURN_RAD).max(start));
    let (begin_s, end_s) = (law.place_of(first - start), law.place_of(first + TURN_RAD - start));
    let [x, z] = [Axis::X, Axis::Z].map(|axis| move |value: f64| si_from_core(axis, value));
    let points = (0..points).map(|i| {
        let at_s = begin_s + (end_s - begin_s) * f64::from(i) / f64::from(points);
        let c = law.sample(at_s);
        let (at_x, at_z) = (chain(path.x().sample(start + c.value), c), chain(path.z_at(start + c.value), c));
        JointTrajectoryPoint {
            positions: vec![c.value, x(at_x.value), z(at_z.value - prepared.job.spec.part_zero_mm)],
            velocities: vec![c.first, x(at_x.first), z(at_z.first)],
            accelerations: vec![c.second, x(at_x.second), z(at_z.second)],
            time_from_start: after_s(at_s - begin_s),
            ..JointTrajectoryPoint::default()
        }
    });
    Some(JointTrajectory {
        joint_names: Axis::ALL.iter().map(|axis| axis.joint().to_owned()).collect(),
        points: points.collect(),
        ..JointTrajectory::default()
    })
}

/// End of a property that holds from the low end on, by bisection.
fn bisected(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[allow(clippy::cast_possible_truncation, reason = "a turn of some seconds in ns")]
fn after_s(seconds: f64) -> Duration {
    duration_from_ns((seconds * 1e9).round() as i64)
}

/// One turn of a lobe's last pass at the programmed speed, from its cam angle 0 on.
fn one_turn(prepared: &PreparedJob, lobe: usize, points: u32) -> JointTrajectory {
    let plan = &prepared.planned.plan;
    let samples = plan.cuts_of(lobe).last().and_then(|cut| plan.turn_samples(cut, points)).unwrap_or_default();
    let phase_rad = f64::from(prepared.machine.rotation_sense) * prepared.planned.lobes[lobe].design.phase_rad;
    let x = |value: f64| si_from_core(Axis::X, value);
    let points = samples.iter().map(|sample| JointTrajectoryPoint {
        positions: vec![sample.angle_rad + phase_rad, x(sample.x.value)],
        velocities: vec![sample.c.first, x(sample.x.first)],
        accelerations: vec![sample.c.second, x(sample.x.second)],
        time_from_start: after_s(sample.time_s),
        ..JointTrajectoryPoint::default()
    });
    JointTrajectory {
        joint_names: vec![Axis::C.joint().to_owned(), Axis::X.joint().to_owned()],
        points: points.collect(),
        ..JointTrajectory::default()
    }
}
