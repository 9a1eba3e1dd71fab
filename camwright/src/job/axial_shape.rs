// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes with taper or crown: their three sections, and the wheels that can grind them.
//!
//! The wheel of the last pass gives the lobe its shape: [`AxialProfile`] states how. A lobe with a shape is ground and measured in three
//! sections of a third of its width. Mean radii at their middles determine taper and crown exactly, and three middles integrate a parabola
//! over the width but for a ninth of the mean height of the crown.

use super::check::within;
use super::error::{JobError, OtherRim};
use super::grinding::{JobSpec, LobeSpec};
use super::key::{JobKey, Subject};
use super::plunges::LobeSection;
use crate::machine::axial_profile::{AXIAL_TOLERANCE_MM, AxialProfile, MAX_AXIAL_MM};
use crate::machine::description::MachineDescription;
use alloc::boxed::Box;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Sections of a lobe with a shape, from the headstock on: end of the name, and middle as a share of the width.
const THIRDS: [(&str, f64); 3] = [("-head", -1.0 / 3.0), ("", 0.0), ("-tail", 1.0 / 3.0)];

/// Number of sections of a lobe that the wheel covers.
pub(crate) fn section_count(axial: Option<AxialProfile>) -> usize {
    if axial.is_some() { THIRDS.len() } else { 1 }
}

/// Sections of a lobe that the wheel covers, the middle one first; it has the name of the lobe.
pub(crate) fn sections(name: &str, width_mm: f64, axial: Option<AxialProfile>) -> Vec<LobeSection> {
    let Some(axial) = axial else {
        return alloc::vec![LobeSection { name: name.to_string(), offset_mm: 0.0, width_mm, above_mm: 0.0 }];
    };
    let [head, middle, tail] = THIRDS.map(|(end, share)| LobeSection {
        name: alloc::format!("{name}{end}"),
        offset_mm: share * width_mm,
        width_mm: width_mm / THIRDS.len() as f64,
        above_mm: axial.height_mm(share * width_mm, width_mm),
    });
    alloc::vec![middle, head, tail]
}

/// Taper and crown of a lobe by the mean heights of its sections, in the order of `sections` (mm).
#[must_use]
pub fn profile_of_sections([middle_mm, head_mm, tail_mm]: [f64; 3]) -> AxialProfile {
    AxialProfile::from_thirds([head_mm, middle_mm, tail_mm])
}

impl JobSpec {
    /// Profile of the wheel's rim over the width of the lobe, or visit to one, with this index.
    fn rim_over(&self, machine: &MachineDescription, lobe: usize) -> AxialProfile {
        let Some(lobe) = self.lobes.get(lobe) else { return AxialProfile::default() };
        let wheel = machine.wheel_at(lobe.wheel(machine));
        wheel.rim.over(wheel.width_mm, lobe.width_mm)
    }

    /// Largest height of the wheel's rim, over its middle, above what the wheel before it left of the lobe, or above the raw part (mm).
    #[must_use]
    pub(crate) fn rim_above_raw_mm(&self, machine: &MachineDescription, lobe: usize) -> f64 {
        let before = self.visit_before(lobe).map(|before| self.rim_over(machine, before)).unwrap_or_default();
        (self.rim_over(machine, lobe) + -before).highest_mm()
    }

    /// Largest depth of the rim below the design of its own section where the middle of the wheel stands on the contour (mm).
    #[must_use]
    pub(crate) fn rim_below_design_mm(&self, machine: &MachineDescription, lobe: usize) -> f64 {
        let axial = self.lobes.get(lobe).and_then(|lobe| lobe.axial).unwrap_or_default();
        (self.rim_over(machine, lobe) + axial).highest_mm()
    }

    /// Checks shapes against rims: the wheel that finishes a lobe grinds its shape, and another one leaves enough of it.
    pub(super) fn check_axial(&self, machine: &MachineDescription) -> Result<(), JobError> {
        for (index, lobe) in self.lobes.iter().enumerate() {
            check_range(lobe)?;
            let axial = lobe.axial.unwrap_or_default();
            let wheel = machine.wheel_at(lobe.wheel(machine));
            if let Some(plunge) = &lobe.plunge {
                if lobe.axial.is_some() || !wheel.rim.is_straight() {
                    let (lobe, rim_key) = (plunge.lobe.clone(), rim_key(lobe.wheel(machine)));
                    return Err(JobError::WideWithShape { lobe, wheel_mm: wheel.width_mm, rim_key });
                }
                continue;
            }
            let above_mm = axial.highest_mm();
            if above_mm > 0.0 && above_mm >= self.stock_mm {
                let (lobe, stock_mm) = (lobe.name.clone(), self.stock_mm);
                return Err(JobError::ShapeAboveStock { lobe, above_mm, stock_mm });
            }
            let ground = wheel.ground_profile(lobe.width_mm);
            let off_mm = (axial + -ground).largest_mm();
            if lobe.is_finished() && (off_mm > AXIAL_TOLERANCE_MM || off_mm.is_nan()) {
                return Err(JobError::OtherRim(Box::new(OtherRim {
                    lobe: lobe.name.clone(),
                    width_mm: lobe.width_mm,
                    wheel: machine
                        .wheel_name(lobe.wheel(machine))
                        .map_or_else(String::new, |name| alloc::format!(" {name}")),
                    design: axial,
                    ground,
                    off_mm,
                    fits: -axial.over(lobe.width_mm, wheel.width_mm),
                    rim_key: rim_key(lobe.wheel(machine)),
                })));
            }
            self.check_rim_of_visit(machine, index)?;
        }
        Ok(())
    }

    /// A wheel before the last leaves material on every section, and a later wheel begins above what the one before left.
    fn check_rim_of_visit(&self, machine: &MachineDescription, index: usize) -> Result<(), JobError> {
        let lobe = &self.lobes[index];
        let Some(visit) = lobe.visit.as_ref() else { return Ok(()) };
        let below_mm = self.rim_below_design_mm(machine, index);
        let left_mm = self.left_after_mm(visit.passes().end);
        if !visit.is_last && below_mm > 0.0 && below_mm >= left_mm {
            return Err(JobError::RoughedBelow { lobe: lobe.name.clone(), below_mm, left_mm });
        }
        let above_mm = self.rim_above_raw_mm(machine, index);
        let approach_mm = self.passes_of(index).first().map_or(0.0, |pass| pass.air_mm);
        if visit.first_pass > 0 && above_mm > 0.0 && above_mm >= approach_mm {
            return Err(JobError::RimBeyondApproach { lobe: lobe.name.clone(), above_mm, approach_mm });
        }
        Ok(())
    }

    /// Refuses a lobe whose sections have the names of other lobes or sections.
    pub(super) fn check_section_names(&self) -> Result<(), JobError> {
        for (index, lobe) in self.lobes.iter().enumerate().filter(|(_, lobe)| lobe.axial.is_some()) {
            let named = |section: &LobeSection| {
                let mut others = self.lobes.iter().enumerate().filter(|(other, _)| *other != index);
                others.find(|(_, other)| other.section_names().contains(&section.name))
            };
            if !lobe.is_finished() {
                continue;
            }
            let own = sections(&lobe.name, lobe.width_mm, lobe.axial);
            if let Some((section, (_, other))) = own.iter().find_map(|section| Some((section, named(section)?))) {
                let (lobe, other) = (lobe.name.clone(), other.name.clone());
                return Err(JobError::SectionName { lobe, section: section.name.clone(), other });
            }
        }
        Ok(())
    }
}

impl LobeSpec {
    /// Its own name and those of the sections that are finished with it.
    fn section_names(&self) -> Vec<String> {
        let sections = match &self.plunge {
            Some(plunge) => plunge.finished_sections(self.width_mm),
            None => sections(&self.name, self.width_mm, self.axial),
        };
        let finished = sections.into_iter().filter(|_| self.is_finished()).map(|section| section.name);
        core::iter::once(self.name.clone()).chain(finished).collect()
    }
}

fn check_range(lobe: &LobeSpec) -> Result<(), JobError> {
    let place = || Subject::Lobe(lobe.name.clone());
    let axial = lobe.axial.unwrap_or_default();
    for (key, value) in [(JobKey::Taper, axial.taper_mm), (JobKey::Crown, axial.crown_mm)] {
        within(place, key, value, (-MAX_AXIAL_MM, MAX_AXIAL_MM), "-0.5 to 0.5")?;
    }
    Ok(())
}

/// Key of the machine file with the rim of a wheel, by position.
fn rim_key(wheel: usize) -> String {
    match wheel.checked_sub(1) {
        None => "wheel.rim".to_string(),
        Some(further) => alloc::format!("wheel_changer.wheels.{further}.rim"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sections cover the width once, have the shape in their middles, and return it.
    #[test]
    fn three_sections_hold_the_shape() {
        let axial = AxialProfile { taper_mm: 0.012, crown_mm: -0.004 };
        let found = sections("T", 14.0, Some(axial));
        let names: Vec<&str> = found.iter().map(|section| section.name.as_str()).collect();
        assert_eq!(names, ["T", "T-head", "T-tail"]);
        assert!((found.iter().map(|section| section.width_mm).sum::<f64>() - 14.0).abs() < 1e-12);
        assert!((found[0].offset_mm - found[1].offset_mm - found[0].width_mm).abs() < 1e-12);
        assert!((found[2].offset_mm - found[0].offset_mm - found[0].width_mm).abs() < 1e-12);
        let back = profile_of_sections([found[0].above_mm, found[1].above_mm, found[2].above_mm]);
        assert!((back.taper_mm - axial.taper_mm).abs() < 1e-15 && (back.crown_mm - axial.crown_mm).abs() < 1e-15);
        let straight = sections("T", 14.0, None);
        assert_eq!((straight.len(), straight[0].width_mm.to_bits()), (1, 14.0_f64.to_bits()));
    }
}
