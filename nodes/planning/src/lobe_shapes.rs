// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Taper and crown of lobes: as planned, and as ground.

use super::PreparedJob;
use super::lobes::measured_form;
use camwright::job::axial_shape::profile_of_sections;
use camwright::math::units::um_from_mm;
use camwright::planner::LobeDesign;
use camwright_files::convert::{m_from_mm, mm_from_m};
use camwright_msgs::camwright_msgs::msg::{LobeShape, PartLobe};
use serde::Serialize;
use std::fmt;

/// Taper and crown of a lobe as it is planned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShapeSummary {
    /// Radius at the end towards the tailstock minus that at the other end.
    pub taper_um: f64,
    /// Radius in the middle minus the mean of both ends.
    pub crown_um: f64,
    /// Taper and crown that the wheel's rim gives a lobe of this width.
    pub rim_taper_um: f64,
    pub rim_crown_um: f64,
    /// Sections from the headstock on.
    pub sections: Vec<SectionSummary>,
}

/// One section of a lobe with taper or crown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionSummary {
    pub name: String,
    /// Middle from that of the lobe.
    pub offset_mm: f64,
    pub width_mm: f64,
    /// Distance of its design outside the contour.
    pub above_um: f64,
}

impl ShapeSummary {
    pub(super) fn from_design(prepared: &PreparedJob, design: &LobeDesign) -> Option<Self> {
        let axial = design.axial?;
        let wheel = prepared.machine.wheel_at(design.wheel(&prepared.machine));
        let ground = wheel.ground_profile(design.width_mm);
        let mut sections: Vec<SectionSummary> = design
            .sections()
            .into_iter()
            .map(|section| SectionSummary {
                name: section.name,
                offset_mm: section.offset_mm,
                width_mm: section.width_mm,
                above_um: um_from_mm(section.above_mm),
            })
            .collect();
        sections.sort_by(|a, b| a.offset_mm.total_cmp(&b.offset_mm));
        Some(Self {
            taper_um: um_from_mm(axial.taper_mm),
            crown_um: um_from_mm(axial.crown_mm),
            rim_taper_um: um_from_mm(ground.taper_mm),
            rim_crown_um: um_from_mm(ground.crown_mm),
            sections,
        })
    }
}

impl fmt::Display for ShapeSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { taper_um, crown_um, rim_taper_um, rim_crown_um, sections } = self;
        write!(
            f,
            "taper {taper_um:+.3} um, crown {crown_um:+.3} um; the rim grinds {rim_taper_um:+.3} and {rim_crown_um:+.3} um"
        )?;
        let of_section = |section: &SectionSummary| format!("{} {:+.3} um", section.name, section.above_um);
        let sections: Vec<String> = sections.iter().map(of_section).collect();
        if sections.is_empty() { Ok(()) } else { write!(f, "; sections {}", sections.join(", ")) }
    }
}

/// Taper and crown of a ground lobe from the outlines of its sections, its own first; `None` for a lobe without a shape, or with a section
/// that was not measured.
#[must_use]
pub fn lobe_shape(design: &LobeDesign, measured: &[PartLobe]) -> Option<LobeShape> {
    let axial = design.axial?;
    let mut means_mm = Vec::new();
    let mut errors = Vec::new();
    for section in design.sections() {
        let part = measured.iter().find(|part| part.name == section.name)?;
        let (form, _) = measured_form(design, part).ok()?;
        means_mm.push(section.above_mm + form.mean_mm());
        errors.push((section.offset_mm, m_from_mm(form.largest.deviation_mm)));
    }
    let found = profile_of_sections(means_mm.try_into().ok()?);
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(LobeShape {
        name: design.name.clone(),
        taper: m_from_mm(found.taper_mm),
        taper_design: m_from_mm(axial.taper_mm),
        crown: m_from_mm(found.crown_mm),
        crown_design: m_from_mm(axial.crown_mm),
        form_error: errors.into_iter().map(|(_, error)| error).collect(),
    })
}

/// Measured taper and crown of a lobe beside its design, in a sentence.
#[must_use]
pub fn shape_line(shape: &LobeShape) -> String {
    let um = |m: f64| um_from_mm(mm_from_m(m));
    let errors: Vec<String> = shape.form_error.iter().map(|error| format!("{:+.3}", um(*error))).collect();
    format!(
        "lobe {}: taper {:+.3} um (design {:+.3}), crown {:+.3} um (design {:+.3}), form error of its sections {} um from the headstock on",
        shape.name,
        um(shape.taper),
        um(shape.taper_design),
        um(shape.crown),
        um(shape.crown_design),
        errors.join(", ")
    )
}
