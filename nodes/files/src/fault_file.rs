// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Faults that a job file injects.

use super::ConfigError;
use super::machine_file::MachineConfig;
use super::yaml::Document;
use camwright::machine::description::MachineDescription;
use camwright::simulation::fault::Fault;
use schemars::JsonSchema;
use serde::Deserialize;

/// A fault that strikes at a tick of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct JobFault {
    /// Name in [`camwright::simulation::fault::FAULTS`].
    pub kind: String,
    pub target: String,
    /// Its size, in the unit of the service `machine/inject_fault`.
    pub value: f64,
    /// Tick of the job, its first being 1.
    pub job_tick: u64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultFile {
    /// Name of the fault, as in the service `machine/inject_fault`.
    kind: String,
    /// Target of the fault.
    #[serde(default)]
    target: String,
    /// Size of the fault, in the unit of the service.
    #[schemars(range(min = -1e12, max = 1e12))]
    #[serde(default = "one")]
    value: f64,
    /// Tick of the job at which the fault begins, from 1. Instead of `at_s`.
    #[schemars(range(min = 1))]
    at_tick: Option<u64>,
    /// Time since the first tick of the job. Instead of `at_tick`.
    #[schemars(range(min = 0.0, max = 1e6))]
    at_s: Option<f64>,
}

fn one() -> f64 {
    1.0
}

/// The faults of a job, and what is wrong with the others; without a machine nothing can be said of any.
pub(super) fn read_all(
    files: &[FaultFile],
    document: &Document,
    machine: Option<&MachineConfig>,
    findings: &mut Vec<ConfigError>,
) -> Vec<JobFault> {
    let Some(machine) = machine else { return Vec::new() };
    let mut faults = Vec::new();
    for (index, fault) in files.iter().enumerate() {
        match fault.read(document, index, &machine.description) {
            Ok(fault) => faults.push(fault),
            Err(error) => findings.push(error),
        }
    }
    faults
}

impl FaultFile {
    /// The fault, or what is wrong with it.
    #[allow(clippy::cast_possible_truncation, reason = "checked against a range before")]
    fn read(&self, document: &Document, index: usize, machine: &MachineDescription) -> Result<JobFault, ConfigError> {
        let refuse = |key: &str, message: String| document.error(&format!("faults.{index}{key}"), message);
        let job_tick = match (self.at_tick, self.at_s) {
            (Some(0), None) => {
                return Err(refuse(".at_tick", "at_tick is 0; the first tick of a job is 1".into()));
            }
            (Some(tick), None) => tick,
            (None, Some(at_s)) if (0.0..=1e6).contains(&at_s) => (at_s / machine.cycle_time_s()).ceil() as u64 + 1,
            (None, Some(at_s)) => {
                return Err(refuse(".at_s", format!("at_s is {at_s}; allowed: 0 to 1000000")));
            }
            _ => return Err(refuse("", "a fault needs one of at_tick and at_s".into())),
        };
        let value = crate::convert::fault_value(&self.kind, &self.target, self.value);
        Fault::from_name(&self.kind, &self.target, value, true, machine)
            .map_err(|error| refuse(".kind", error.to_string()))?;
        Ok(JobFault { kind: self.kind.clone(), target: self.target.clone(), value: self.value, job_tick })
    }
}
