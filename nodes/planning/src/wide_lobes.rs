// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes wider than the wheel: their plunges as planned, and the sections that these left.

use super::PreparedJob;
use super::lobes::measured_form;
use camwright::cam::form::Form;
use camwright::math::units::{deg_from_rad, um_from_mm, wrap_turn};
use camwright::planner::LobeDesign;
use camwright_msgs::camwright_msgs::msg::PartLobe;
use serde::Serialize;
use std::fmt;

/// One plunge of a wide lobe as it is planned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlungeSummary {
    /// Name of the lobe.
    pub lobe: String,
    /// Number of the plunge, from 1 at the headstock, and of all plunges of the lobe.
    pub number: u32,
    pub count: u32,
    /// Position of the table.
    pub z_mm: f64,
    /// Overlap with each neighbour.
    pub overlap_mm: f64,
}

impl PlungeSummary {
    pub(super) fn from_design(prepared: &PreparedJob, design: &LobeDesign) -> Option<Self> {
        let plunge = design.plunge.as_ref()?;
        Some(Self {
            lobe: plunge.lobe.clone(),
            number: plunge.number,
            count: plunge.count,
            z_mm: design.z_mm(&prepared.machine)?,
            overlap_mm: plunge.overlap_mm(design.width_mm),
        })
    }
}

impl fmt::Display for PlungeSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lobe, number, count, z_mm, overlap_mm } = self;
        write!(
            f,
            "{number} of {count} of lobe {lobe}, table at {z_mm:.3} mm, overlap with its neighbours {overlap_mm:.3} mm"
        )
    }
}

/// Form of a ground lobe that is wider than the wheel.
#[derive(Debug, Clone, PartialEq)]
pub struct WideLobeForm {
    /// Name of the lobe.
    pub lobe: String,
    /// Name and largest form error of every section, from the headstock on (mm).
    pub sections: Vec<(String, f64)>,
    /// The largest step; `None` if a single plunge was measured.
    pub step: Option<PlungeStep>,
}

/// Step between two neighbouring plunges: difference of their form errors at one azimuth, from the headstock on.
#[derive(Debug, Clone, PartialEq)]
pub struct PlungeStep {
    /// Names of the plunges.
    pub between: [String; 2],
    /// Along the normal, positive if the second plunge left more (mm).
    pub height_mm: f64,
    /// Its mean over the turn (mm).
    pub mean_mm: f64,
    /// Its cam angle (rad).
    pub cam_angle_rad: f64,
}

impl fmt::Display for WideLobeForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let section = |(name, error_mm): &(String, f64)| format!("{name} {:+.3}", um_from_mm(*error_mm));
        let sections: Vec<String> = self.sections.iter().map(section).collect();
        write!(f, "lobe {}: form error of its sections {} um", self.lobe, sections.join(", "))?;
        let Some(PlungeStep { between: [from, to], height_mm, mean_mm, cam_angle_rad }) = &self.step else {
            return Ok(());
        };
        let [height_um, mean_um] = [height_mm, mean_mm].map(|mm| um_from_mm(*mm));
        let angle_deg = deg_from_rad(*cam_angle_rad);
        write!(f, "; largest step {height_um:+.3} um from {from} to {to} at {angle_deg:.1} deg (mean {mean_um:+.3} um)")
    }
}

/// The form of every wide lobe of a job, from the sections that were measured.
#[must_use]
pub fn wide_lobe_forms(prepared: &PreparedJob, measured: &[PartLobe]) -> Vec<WideLobeForm> {
    let designs = || prepared.planned.lobes.iter().map(|lobe| &lobe.design);
    let mut names: Vec<&str> = Vec::new();
    for plunge in designs().filter_map(|design| design.plunge.as_ref()) {
        if !names.contains(&plunge.lobe.as_str()) {
            names.push(&plunge.lobe);
        }
    }
    let form_of = |name: &&str| {
        let plunges: Vec<&LobeDesign> =
            designs().filter(|design| design.plunge.as_ref().is_some_and(|plunge| plunge.lobe == **name)).collect();
        wide_lobe_form(name, &plunges, measured)
    };
    names.iter().filter_map(form_of).collect()
}

/// The form of one wide lobe; `None` if one of its sections was not measured.
fn wide_lobe_form(lobe: &str, plunges: &[&LobeDesign], measured: &[PartLobe]) -> Option<WideLobeForm> {
    let mut sections = Vec::new();
    let mut left: Vec<(&LobeDesign, Form, f64)> = Vec::new();
    for design in plunges {
        for (index, section) in design.sections().into_iter().enumerate() {
            let part = measured.iter().find(|part| part.name == section.name)?;
            let (form, phase_rad) = measured_form(design, part).ok()?;
            sections.push((section.offset_mm, section.name, form.largest.deviation_mm));
            if index == 0 {
                left.push((design, form, phase_rad));
            }
        }
    }
    sections.sort_by(|a, b| a.0.total_cmp(&b.0));
    let steps = left.windows(2).filter_map(|pair| step_between(&pair[0], &pair[1]));
    Some(WideLobeForm {
        lobe: lobe.to_owned(),
        sections: sections.into_iter().map(|(_, name, error_mm)| (name, error_mm)).collect(),
        step: steps.max_by(|a, b| a.height_mm.abs().total_cmp(&b.height_mm.abs())),
    })
}

fn step_between(
    (one, one_form, phase_rad): &(&LobeDesign, Form, f64),
    (other, other_form, _): &(&LobeDesign, Form, f64),
) -> Option<PlungeStep> {
    let count = one_form.deviations_mm.len();
    if count == 0 || count != other_form.deviations_mm.len() {
        return None;
    }
    let steps = one_form.deviations_mm.iter().zip(&other_form.deviations_mm).map(|(one, other)| other - one);
    let mean_mm = steps.clone().sum::<f64>() / count as f64;
    let (index, height_mm) = steps.enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let azimuth_rad = index as f64 / count as f64 * camwright::math::units::TURN_RAD;
    Some(PlungeStep {
        between: [one.name.clone(), other.name.clone()],
        height_mm,
        mean_mm,
        cam_angle_rad: wrap_turn(one.contour.cam_angle_at(azimuth_rad - phase_rad)),
    })
}
