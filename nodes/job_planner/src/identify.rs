// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stiffness services: `~/identify_stiffness` measures the stiffness of the machine on the journals of a job, `~/get_stiffness` returns
//! the stored values.

use super::deferred::deferred;
use super::job_slot::JobSlot;
use super::request_origin::{PendingAnswer, RequestOrigin, answer};
use super::{NO_MACHINE, Shared, lock, settings};
use camwright::gauging::stiffness::MeasuredValue;
use camwright_files::convert::{m_from_mm, mm_from_m};
use camwright_files::job_file;
use camwright_files::stiffness_file::StoredContact;
use camwright_msgs::camwright_msgs::msg::JournalStiffness;
use camwright_msgs::camwright_msgs::srv::{
    GetStiffness, GetStiffnessRequest, GetStiffnessResponse, IdentifyStiffness, IdentifyStiffnessRequest,
    IdentifyStiffnessResponse,
};
use camwright_ros::{Responder, RosError, ServiceHandle};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

pub(super) fn offer(shared: &Arc<Shared>) -> Result<[ServiceHandle; 2], RosError> {
    let this = Arc::clone(shared);
    let identify = shared.node.service_deferred::<IdentifyStiffness>(
        "~/identify_stiffness",
        move |request, responder: Responder<IdentifyStiffness>| {
            let failed = |message| IdentifyStiffnessResponse { message, ..IdentifyStiffnessResponse::default() };
            begin(&this, request, responder.or_fail(failed));
        },
    )?;
    let failed = |message| GetStiffnessResponse { message, ..GetStiffnessResponse::default() };
    let get = deferred::<GetStiffness>(shared, "~/get_stiffness", get_stiffness, failed)?;
    Ok([identify, get])
}

fn refuse(waiting: &PendingAnswer, message: String) {
    answer(waiting, &IdentifyStiffnessResponse { message, ..IdentifyStiffnessResponse::default() });
}

/// Refuses at once what cannot be, or begins: the job is decided on by the planning thread and runs like any other.
fn begin(shared: &Arc<Shared>, request: IdentifyStiffnessRequest, responder: Responder<IdentifyStiffness>) {
    let waiting: PendingAnswer = Arc::new(Mutex::new(Some(responder)));
    if !shared.active.load(Ordering::Acquire) {
        return refuse(&waiting, "the node is not active; nothing moved".into());
    }
    if let Some(reason) = shared.cell.keeps_jobs_out() {
        return refuse(&waiting, format!("{reason}; nothing moved"));
    }
    {
        let mut course = lock(&shared.job_slot);
        if !matches!(*course, JobSlot::Idle) {
            return refuse(&waiting, format!("{course}; nothing moved"));
        }
        *course = JobSlot::Deciding(request.job.clone());
    }
    let (this, asked) = (Arc::clone(shared), Arc::clone(&waiting));
    let sent = shared.order(move || {
        let (job, overrides) = this.wanted(&request.job, &request.overrides);
        let overrides = measures_only(&this, &job, overrides, request.forget);
        this.board.planning(&job);
        let started = this.decide(&job, &overrides).and_then(|prepared| match this.active.load(Ordering::Acquire) {
            true => this.start(&mut lock(&this.job_slot), prepared, RequestOrigin::Stiffness(Arc::clone(&asked))),
            false => Err("the node is not active any more".into()),
        });
        if let Err(reason) = started {
            *lock(&this.job_slot) = JobSlot::Idle;
            this.board.refused(&job, &reason);
            refuse(&asked, format!("{reason}; nothing moved"));
        }
    });
    if !sent {
        *lock(&shared.job_slot) = JobSlot::Idle;
    }
}

/// The job as it is asked for, but that it measures and no more. What measures is a part of what corrects.
fn measures_only(shared: &Shared, job: &str, mut overrides: Vec<String>, forget: bool) -> Vec<String> {
    let used = settings::overrides(shared.node.parameters(), &overrides);
    if job_file::load(job, &used).is_ok_and(|job| job.spec.correction.is_none()) {
        overrides.push("runout_correction={}".into());
    }
    overrides.push("identification.only=true".into());
    overrides.extend(forget.then(|| "identification.afresh=true".to_owned()));
    overrides
}

fn get_stiffness(shared: &Shared, request: &GetStiffnessRequest) -> GetStiffnessResponse {
    let here = lock(&shared.machine).as_ref().map(|now| now.description.name.clone());
    let machine = if request.machine.is_empty() { here } else { Some(request.machine.clone()) };
    let kept = machine.ok_or_else(|| NO_MACHINE.to_owned()).and_then(|machine| shared.stiffness.load(&machine));
    match kept {
        Ok(kept) => GetStiffnessResponse {
            success: true,
            message: format!("{} places of {}, from {} parts", kept.places().len(), kept.machine, kept.parts),
            journals: kept.places().iter().map(message).collect(),
        },
        Err(message) => GetStiffnessResponse { message, ..GetStiffnessResponse::default() },
    }
}

/// Message of a stored contact.
pub(super) fn message(kept: &StoredContact) -> JournalStiffness {
    // N/mm and N/m differ as m and mm do, the other way round.
    let n_m = |measured: MeasuredValue| (mm_from_m(measured.value), mm_from_m(measured.uncertainty));
    let times_width = |measured: MeasuredValue| MeasuredValue {
        value: measured.value * kept.width_mm,
        uncertainty: measured.uncertainty * kept.width_mm,
    };
    let place = &kept.place;
    let (machine, grinding) = (n_m(place.machine_n_mm), n_m(times_width(place.grinding_n_mm2)));
    let (threshold, ratio) = (times_width(place.threshold_n_mm), place.ratio(kept.width_mm));
    JournalStiffness {
        name: kept.lobe.clone(),
        job: kept.job.clone(),
        part: kept.part,
        z: m_from_mm(place.z_mm),
        width: m_from_mm(kept.width_mm),
        machine_stiffness: machine.0,
        machine_stiffness_uncertainty: machine.1,
        grinding_stiffness: grinding.0,
        grinding_stiffness_uncertainty: grinding.1,
        threshold_force: threshold.value,
        threshold_force_uncertainty: threshold.uncertainty,
        ratio: ratio.value,
        ratio_uncertainty: ratio.uncertainty,
    }
}
