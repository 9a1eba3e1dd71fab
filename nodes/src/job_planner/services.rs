//! The planner's services. Files are read and jobs planned on the planning thread; answers come from there.

use super::{Shared, lock};
use crate::config::any_job;
use crate::planning::{self, Severity};
use crate::ros::{Responder, RosError, ServiceHandle};
use camwright_msgs::Service;
use camwright_msgs::camwright_msgs::srv::{
    ListJobs, ListJobsResponse, LoadJob, LoadJobRequest, LoadJobResponse, PreviewJob, ValidateJob, ValidateJobRequest,
    ValidateJobResponse,
};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use std::sync::Arc;

pub(super) fn offer(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, RosError> {
    let list = deferred::<ListJobs>(shared, "~/list_jobs", |_, _| list_jobs())?;
    let load = deferred::<LoadJob>(shared, "~/load_job", load_job)?;
    let validate = deferred::<ValidateJob>(shared, "~/validate_job", validate_job)?;
    let preview = deferred::<PreviewJob>(shared, "~/preview_job", super::preview::answer)?;
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
            duration: prepared.duration_s(),
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
