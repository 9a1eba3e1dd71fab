// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The planner's services. Files are read and jobs planned on the planning thread; answers come from there.

use super::deferred::deferred;
use super::{Shared, lock, settings};
use camwright_files::any_job;
use camwright_msgs::camwright_msgs::srv::{
    ListJobs, ListJobsRequest, ListJobsResponse, LoadJob, LoadJobRequest, LoadJobResponse, PreviewJob,
    PreviewJobResponse, ValidateJob, ValidateJobRequest, ValidateJobResponse,
};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_planning::{self as planning, Severity};
use camwright_ros::{RosError, ServiceHandle};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Age up to which a list of the jobs on disk is sent again.
const LIST_AGE: Duration = Duration::from_secs(1);

pub(super) fn offer(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, RosError> {
    let list = shared.node.service::<ListJobs>("~/list_jobs", JobList::default().into_answer())?;
    let failed = |message| LoadJobResponse { message, ..LoadJobResponse::default() };
    let load = deferred::<LoadJob>(shared, "~/load_job", load_job, failed)?;
    let failed = |message: String| {
        let findings = vec![format!("{}: {message}", Severity::Error)];
        ValidateJobResponse { success: false, message, findings }
    };
    let validate = deferred::<ValidateJob>(shared, "~/validate_job", validate_job, failed)?;
    let failed = |message| PreviewJobResponse { message, ..PreviewJobResponse::default() };
    let preview = deferred::<PreviewJob>(shared, "~/preview_job", super::preview::answer, failed)?;
    let this = Arc::clone(shared);
    let stop = shared.node.service::<Trigger>("~/stop", move |_| {
        let success = this.cancel();
        let message = if success { "coming to rest" } else { "no job is running" };
        TriggerResponse { success, message: message.to_owned() }
    })?;
    let [identify, get_stiffness] = super::identify::offer(shared)?;
    Ok(vec![list, load, validate, preview, stop, identify, get_stiffness])
}

/// The jobs on disk, which are not read again for every call.
#[derive(Default)]
struct JobList(Option<(Instant, ListJobsResponse)>);

impl JobList {
    fn into_answer(mut self) -> impl FnMut(ListJobsRequest) -> ListJobsResponse + Send + 'static {
        move |_| {
            if let Some((read, response)) = &self.0
                && read.elapsed() < LIST_AGE
            {
                return response.clone();
            }
            let response = list_jobs();
            self.0 = Some((Instant::now(), response.clone()));
            response
        }
    }
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
    if let Err(message) = settings::check_against_job(shared.node.parameters(), &request.job, &request.overrides) {
        let findings = vec![format!("{}: {message}", Severity::Error)];
        return ValidateJobResponse { success: false, message, findings };
    }
    let overrides = match shared.used(&request.job, &request.overrides, machine.as_ref()) {
        Ok(overrides) => overrides,
        Err(message) => {
            let findings = vec![format!("{}: {message}", Severity::Error)];
            return ValidateJobResponse { success: false, message, findings };
        }
    };
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
