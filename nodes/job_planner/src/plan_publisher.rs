// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Publisher of the planner's job: `~/job_status`, plan pages and job files.

use super::cell::CellEvent;
use super::lock;
use camwright_files::convert::job_files::{MAX_PAGES, pages_from_files};
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::{JobFilePage, JobStatus};
use camwright_planning::AnyPrepared;
use camwright_ros::{Node, Publisher, Qos, RosError};
use std::sync::{Mutex, mpsc};

/// The latched status and what it said last.
#[derive(Debug)]
pub(super) struct PlanPublisher {
    node: Node,
    publisher: Publisher<JobStatus>,
    /// Files of the job, and the job whose files were published last.
    files: Publisher<JobFilePage>,
    published_hash: Mutex<String>,
    /// Held while publishing, so that the last message is the last change.
    last: Mutex<JobStatus>,
    /// The cell, which follows what becomes of jobs.
    cell: mpsc::Sender<CellEvent>,
}

impl PlanPublisher {
    pub(super) fn new(node: &Node, cell: mpsc::Sender<CellEvent>) -> Result<Self, RosError> {
        let publisher = node.publisher("~/job_status", &Qos::latched(1))?;
        let files = node.publisher("~/job_files", &Qos::latched(MAX_PAGES))?;
        let (last, published_hash) = (Mutex::default(), Mutex::default());
        let board = Self { node: node.clone(), publisher, files, published_hash, last, cell };
        board.set(|_| {});
        Ok(board)
    }

    fn set(&self, change: impl FnOnce(&mut JobStatus)) {
        let mut last = lock(&self.last);
        change(&mut last);
        last.stamp = self.node.now();
        if let Err(error) = self.publisher.publish(&last) {
            self.node.logger().warn(&error.to_string());
        }
        let _ending = self.cell.send(CellEvent::Job(Box::new(last.clone())));
    }

    /// A job is being planned.
    pub(super) fn planning(&self, job: &str) {
        let message = format!("planning {job}");
        self.set(|status| {
            *status = JobStatus { state: JobStatus::PLANNING, job: job.into(), message, ..JobStatus::default() }
        });
    }

    /// A job was refused before anything moved.
    pub(super) fn refused(&self, job: &str, reason: &str) {
        let message = format!("refused, nothing moved: {reason}");
        self.set(|status| {
            *status = JobStatus { state: JobStatus::IDLE, job: job.into(), message, ..JobStatus::default() }
        });
    }

    /// A goal was rejected. Without a job, the status keeps the reason; a job and its result keep theirs.
    pub(super) fn rejected(&self, reason: &str) {
        let mut last = lock(&self.last);
        let message = format!("refused, nothing moved: {reason}");
        if last.state != JobStatus::IDLE || last.message == message {
            return;
        }
        last.message = message;
        last.stamp = self.node.now();
        if let Err(error) = self.publisher.publish(&last) {
            self.node.logger().warn(&error.to_string());
        }
    }

    /// A job is planned; `state` says what becomes of it.
    pub(super) fn planned(&self, state: u8, prepared: &AnyPrepared, message: &str) {
        self.publish_files(prepared);
        self.set(|status| {
            *status = JobStatus {
                state,
                job: prepared.name().to_owned(),
                job_source: prepared.source().to_owned(),
                job_hash: prepared.job_hash().to_owned(),
                plan_hash: prepared.plan_hash().to_owned(),
                message: message.to_owned(),
                ..JobStatus::default()
            };
        });
    }

    /// The files that a job names, once for each job.
    fn publish_files(&self, prepared: &AnyPrepared) {
        let mut published_hash = lock(&self.published_hash);
        if *published_hash == prepared.job_hash() {
            return;
        }
        prepared.job_hash().clone_into(&mut published_hash);
        for page in pages_from_files(prepared.job_hash(), prepared.files()) {
            if let Err(error) = self.files.publish(&page) {
                self.node.logger().warn(&error.to_string());
            }
        }
    }

    /// The job is being brought to rest.
    pub(super) fn stopping(&self) {
        self.set(|status| {
            status.state = JobStatus::STOPPING;
            status.message = "coming to rest".into();
        });
    }

    /// The job has ended.
    pub(super) fn ended(&self, state: u8, result: &RunJobResult) {
        self.set(|status| {
            status.state = state;
            status.message.clone_from(&result.message);
            status.lobes.clone_from(&result.lobes);
            status.shapes.clone_from(&result.shapes);
            status.turned.clone_from(&result.turned);
        });
    }
}
