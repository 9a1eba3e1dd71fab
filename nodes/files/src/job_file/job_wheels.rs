// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Wheels of a changer that a job names: by lobe, by pass, or for all.

use super::JobFile;
use crate::ConfigError;
use crate::schema::nearest;
use crate::yaml::Document;
use camwright::job::grinding::{JobError, JobSpec, Subject};
use camwright::machine::description::MachineDescription;

/// Wheel of every pass, by the name of its lobe.
pub(super) type WheelsOfLobes = Vec<(String, Vec<usize>)>;

/// Positions of the wheels in the changer for every lobe and pass; empty where the job names no wheel.
pub(super) fn of_passes(
    file: &JobFile,
    machine: &MachineDescription,
    document: &Document,
) -> Result<WheelsOfLobes, Vec<ConfigError>> {
    let mut findings = Vec::new();
    let mut find = |(key, subject): (&str, Subject), name: Option<&str>| {
        let place = |message: String| document.error(key, format!("{}{message}", subject.prefix()));
        let found = name.map(|name| position(machine, name).map_err(place));
        match found {
            Some(Err(error)) => {
                findings.push(error);
                None
            }
            Some(Ok(position)) => Some(position),
            None => None,
        }
    };
    let of_job = find(("wheel", Subject::Job), file.wheel.as_deref());
    let mut of_passes = Vec::new();
    for (index, rough) in file.roughing.iter().enumerate() {
        of_passes.push(find((&format!("roughing.{index}.wheel"), Subject::Pass(rough.name().into())), rough.wheel()));
    }
    let mut of_lobes = Vec::new();
    for (index, lobe) in file.lobes.iter().enumerate() {
        of_lobes.push(find((&format!("lobes.{index}.wheel"), Subject::Lobe(lobe.name.clone())), lobe.wheel.as_deref()));
    }
    let named: Vec<String> = (file.lobes.iter().enumerate().filter(|(_, lobe)| lobe.wheel_radius_mm.is_some()))
        .map(|(index, _)| format!("lobes.{index}.wheel_radius_mm"))
        .chain(
            (file.roughing.iter().enumerate().filter(|(_, rough)| rough.wheel_radius_mm().is_some()))
                .map(|(index, _)| format!("roughing.{index}.wheel_radius_mm")),
        )
        .collect();
    let names_wheels = of_job.is_some() || of_passes.iter().chain(&of_lobes).any(Option::is_some);
    if let Some(key) = named.first().filter(|_| names_wheels) {
        let message = format!("{key} and wheel both say which wheel grinds; remove one");
        findings.push(document.error(key, message));
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    if !names_wheels {
        return Ok(Vec::new());
    }
    let of_job = of_job.unwrap_or(0);
    // The last pass has the wheel of the job.
    let of_passes: Vec<usize> = of_passes.iter().map(|wheel| wheel.unwrap_or(of_job)).chain([of_job]).collect();
    let wheels = file.lobes.iter().zip(of_lobes).map(|(lobe, wheel)| {
        let wheels = wheel.map_or_else(|| of_passes.clone(), |wheel| vec![wheel; of_passes.len()]);
        (lobe.name.clone(), wheels)
    });
    Ok(wheels.collect())
}

/// Puts the visits of the wheels in the place of the lobes, if the job names wheels.
pub(super) fn visit(
    spec: &mut JobSpec,
    wheels: &WheelsOfLobes,
    approach_mm: f64,
    document: &Document,
) -> Result<(), ConfigError> {
    if wheels.is_empty() {
        return Ok(());
    }
    let of_lobe = |name: &str| wheels.iter().find(|(lobe, _)| lobe == name).map(|(_, wheels)| wheels.clone());
    let of_lobes = spec.lobes.iter().map(|lobe| {
        let lobe = lobe.plunge.as_ref().map_or(&lobe.name, |plunge| &plunge.lobe);
        of_lobe(lobe).unwrap_or_default()
    });
    let of_lobes: Vec<Vec<usize>> = of_lobes.collect();
    spec.visit_by_wheels(&of_lobes, approach_mm).map_err(|error| {
        let key = match &error {
            JobError::ApproachBeyondInfeed { .. } => "wheel_approach_mm",
            _ => "wheel",
        };
        document.error(key, error.to_string())
    })
}

fn position(machine: &MachineDescription, name: &str) -> Result<usize, String> {
    let Some(changer) = &machine.wheel_changer else {
        return Err(format!(
            "the job names wheel {name}, but machine {} has no wheel changer: remove the key, or make a job for each wheel",
            machine.name
        ));
    };
    changer.position(name).ok_or_else(|| {
        let known: Vec<&str> = changer.wheels.iter().map(|wheel| wheel.name.as_str()).collect();
        let hint = nearest(name, &known).map(|near| format!("; did you mean {near}?")).unwrap_or_default();
        format!("machine {} has no wheel {name}; its wheels are {}{hint}", machine.name, known.join(", "))
    })
}
