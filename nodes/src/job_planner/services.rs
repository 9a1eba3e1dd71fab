//! The planner's services. Files are read and jobs planned on the planning thread; answers come from there.

use super::{Shared, lock};
use crate::config::any_job;
use crate::convert::time::duration_from_ns;
use crate::convert::{m_from_mm, si_from_core};
use crate::planning::{self, PreparedJob, Severity};
use crate::ros::{Responder, RosError, ServiceHandle};
use camwright::machine::description::Axis;
use camwright::units::TURN_RAD;
use camwright_msgs::Service;
use camwright_msgs::camwright_msgs::srv::{
    ListJobs, ListJobsResponse, LoadJob, LoadJobRequest, LoadJobResponse, PreviewJob, PreviewJobRequest,
    PreviewJobResponse, ValidateJob, ValidateJobRequest, ValidateJobResponse,
};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use std::sync::Arc;

/// Points of a preview over one turn unless the request says otherwise: one per degree.
const PREVIEW_POINTS: u32 = 360;
/// Most points of a preview.
const MOST_PREVIEW_POINTS: u32 = 3600;

pub(super) fn offer(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, RosError> {
    let list = deferred::<ListJobs>(shared, "~/list_jobs", |_, _| list_jobs())?;
    let load = deferred::<LoadJob>(shared, "~/load_job", load_job)?;
    let validate = deferred::<ValidateJob>(shared, "~/validate_job", validate_job)?;
    let preview = deferred::<PreviewJob>(shared, "~/preview_job", preview_job)?;
    let this = Arc::clone(shared);
    let stop = shared.node.service::<Trigger>("~/stop", move |_| {
        let success = this.cancel();
        let message = if success { "coming to rest" } else { "no job is running" };
        TriggerResponse { success, message: message.to_owned() }
    })?;
    let [identify, get_stiffness] = super::identify::offer(shared)?;
    Ok(vec![list, load, validate, preview, stop, identify, get_stiffness])
}

/// A service that answers from the planning thread.
pub(super) fn deferred<S: Service>(
    shared: &Arc<Shared>,
    name: &str,
    answer: fn(&Shared, &S::Request) -> S::Response,
) -> Result<ServiceHandle, RosError> {
    let this = Arc::clone(shared);
    shared.node.service_deferred::<S>(name, move |request, responder: Responder<S>| {
        let shared = Arc::clone(&this);
        // While the node ends there is nobody to ask; the client's request is then not answered.
        let _ending = this.order(move || responder.send(&answer(&shared, &request)));
    })
}

fn list_jobs() -> ListJobsResponse {
    let mut response = ListJobsResponse::default();
    for (name, title, path) in any_job::list() {
        response.jobs.push(name);
        response.titles.push(title);
        response.paths.push(path.display().to_string());
    }
    response
}

fn load_job(shared: &Shared, request: &LoadJobRequest) -> LoadJobResponse {
    match shared.load(&request.job, &request.overrides) {
        Ok(prepared) => LoadJobResponse {
            success: true,
            message: prepared.summary(),
            plan_hash: prepared.plan_hash().to_owned(),
            duration: prepared.planned.plan.duration_s,
        },
        Err(message) => LoadJobResponse { message, ..LoadJobResponse::default() },
    }
}

fn validate_job(shared: &Shared, request: &ValidateJobRequest) -> ValidateJobResponse {
    let machine = lock(&shared.machine).clone();
    let overrides = shared.used(&request.job, &request.overrides, machine.as_ref());
    match planning::check(&request.job, &overrides, machine.as_ref()) {
        Ok(report) => ValidateJobResponse {
            success: report.worst() != Some(Severity::Error),
            message: match report.first_error() {
                Some(error) => error.to_string(),
                None => report.summary.clone().unwrap_or_default(),
            },
            findings: report.findings.iter().map(ToString::to_string).collect(),
        },
        Err(error) => {
            let findings = vec![format!("{}: {error}", Severity::Error)];
            ValidateJobResponse { success: false, message: error.to_string(), findings }
        }
    }
}

fn preview_job(shared: &Shared, request: &PreviewJobRequest) -> PreviewJobResponse {
    match preview(shared, request) {
        Ok(response) => response,
        Err(message) => PreviewJobResponse { message, ..PreviewJobResponse::default() },
    }
}

fn preview(shared: &Shared, request: &PreviewJobRequest) -> Result<PreviewJobResponse, String> {
    let points = match request.points {
        0 => PREVIEW_POINTS,
        points if points <= MOST_PREVIEW_POINTS => points,
        points => return Err(format!("{points} points, at most {MOST_PREVIEW_POINTS} are allowed")),
    };
    let machine = lock(&shared.machine).clone();
    let overrides = shared.used(&request.job, &request.overrides, machine.as_ref());
    let prepared = planning::prepare(&request.job, &overrides, machine.as_ref()).map_err(|error| error.to_string())?;
    let names = &prepared.planned.plan.lobes;
    let lobe = match request.lobe.as_str() {
        "" => 0,
        wanted => names
            .iter()
            .position(|name| name == wanted)
            .ok_or_else(|| format!("there is no lobe {wanted}; the job has {}", names.join(", ")))?,
    };
    let contour = &prepared.planned.lobes[lobe].design.contour;
    let radius = |i: u32| m_from_mm(contour.radius_at(f64::from(i) * TURN_RAD / f64::from(points)));
    Ok(PreviewJobResponse {
        success: true,
        message: prepared.summary(),
        duration: prepared.planned.plan.duration_s,
        duration_with_indexing: prepared.planned.plan.duration_with_indexing_s,
        contour_radius: (0..points).map(radius).collect(),
        turn: one_turn(&prepared, lobe, points),
    })
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
        #[allow(clippy::cast_possible_truncation, reason = "a turn of a few seconds in ns")]
        time_from_start: duration_from_ns((sample.time_s * 1e9).round() as i64),
        ..JointTrajectoryPoint::default()
    });
    JointTrajectory {
        joint_names: vec![Axis::C.joint().to_owned(), Axis::X.joint().to_owned()],
        points: points.collect(),
        ..JointTrajectory::default()
    }
}
