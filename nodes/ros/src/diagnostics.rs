// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `/diagnostics` at 1 Hz (REP-107).

use std::{
    fmt,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use camwright_msgs::{
    diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue},
    std_msgs::msg::Header,
};

use super::{error::RosError, executor::TimerHandle, node::Node, qos::Qos, topics::Publisher};

/// Report period of a node, by REP-107.
const PERIOD: Duration = Duration::from_secs(1);

type StatusReport = Box<dyn FnMut() -> Vec<DiagnosticStatus> + Send>;

struct DiagnosticsReporter {
    node: super::node::WeakNode,
    publisher: Publisher<DiagnosticArray>,
    hardware_id: String,
    report: Mutex<StatusReport>,
}

impl DiagnosticsReporter {
    fn publish(&self) {
        let Some(node) = self.node.upgrade() else { return };
        let mut status = (self.report.lock().unwrap_or_else(PoisonError::into_inner))();
        let fault = node.supervisor().fault();
        status.splice(0..0, fault.map(|fault| diagnostic_status(DiagnosticStatus::ERROR, "", fault, &[])));
        self.send(&node, status);
    }

    /// Publishes the fault of a dead thread and no other status: collecting the others could wait for that thread.
    fn publish_fault(&self, fault: &str) {
        if let Some(node) = self.node.upgrade() {
            self.send(&node, vec![diagnostic_status(DiagnosticStatus::ERROR, "", fault, &[])]);
        }
    }

    fn send(&self, node: &Node, mut status: Vec<DiagnosticStatus>) {
        // All cells of a domain share the topic: in a namespace the names of a cell are its own.
        let (namespace, source) = match node.namespace() {
            "/" => (String::new(), node.name().to_owned()),
            namespace => (format!("{namespace}/"), node.fully_qualified_name()),
        };
        for item in &mut status {
            item.name = if item.name.is_empty() { source.clone() } else { format!("{source}: {}", item.name) };
            if item.hardware_id.is_empty() {
                item.hardware_id = format!("{namespace}{}", self.hardware_id);
            }
        }
        if let Some(first) = status.first_mut() {
            first.values.extend(node.load().values());
        }
        let message = DiagnosticArray { header: Header { stamp: node.now(), ..Default::default() }, status };
        if let Err(error) = self.publisher.publish(&message) {
            node.logger().warn(&error.to_string());
        }
    }
}

/// A node's diagnostics; dropping it ends the reports.
#[must_use = "dropping it ends the reports"]
pub struct Diagnostics {
    reporter: Arc<DiagnosticsReporter>,
    _timer: TimerHandle,
}

impl fmt::Debug for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Diagnostics").field("hardware_id", &self.reporter.hardware_id).finish_non_exhaustive()
    }
}

impl Diagnostics {
    /// Reports at once, for a change of level that is urgent.
    pub fn report_now(&self) {
        if let Some(node) = self.reporter.node.upgrade() {
            let reporter = Arc::clone(&self.reporter);
            node.post(move || reporter.publish());
        }
    }
}

/// A status in one line: level (`DiagnosticStatus::OK` and so on), name of the part (empty for the node itself), sentence, figures.
pub fn diagnostic_status(level: u8, part: &str, message: &str, values: &[(&str, String)]) -> DiagnosticStatus {
    let values = values.iter().map(|(key, value)| KeyValue { key: (*key).to_string(), value: value.clone() }).collect();
    DiagnosticStatus { level, name: part.to_string(), message: message.to_string(), hardware_id: String::new(), values }
}

impl Node {
    /// Publishes what `report` says on `/diagnostics` once a second; it runs on the executor thread. The names it gives are those of
    /// parts; the node's name is put before them, with its namespace if it has one. The namespace is put before `hardware_id` too.
    ///
    /// # Errors
    /// The node is shut down.
    pub fn diagnostics(
        &self,
        hardware_id: &str,
        report: impl FnMut() -> Vec<DiagnosticStatus> + Send + 'static,
    ) -> Result<Diagnostics, RosError> {
        let reporter = Arc::new(DiagnosticsReporter {
            node: self.downgrade(),
            publisher: self.publisher("/diagnostics", &Qos::default_topic())?,
            hardware_id: hardware_id.to_string(),
            report: Mutex::new(Box::new(report)),
        });
        let failing = Arc::downgrade(&reporter);
        self.supervisor().on_fault(move |fault| {
            if let Some(reporter) = failing.upgrade() {
                reporter.publish_fault(fault);
            }
        });
        let reporting = Arc::clone(&reporter);
        let timer = self.timer(PERIOD, move || reporting.publish());
        Ok(Diagnostics { reporter, _timer: timer })
    }
}
