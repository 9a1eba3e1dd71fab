// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Support of the part in a job: shaft, headstock, tailstock and steady rest.

use super::error::JobError;
use super::grinding::{JobSpec, LobeSpec};
use super::key::{JobKey, Subject};
use super::plunges;
use super::supported_shaft::{ShaftLayout, SupportedShaft, round_bending_n_mm2};
use crate::machine::description::MachineDescription;

/// Hold of the part at the headstock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HeadstockGrip {
    /// A centre carries radial force only.
    #[default]
    Centre,
    /// A chuck also resists tilt.
    Chuck,
}

/// The part as a round shaft on the supports of the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartSupport {
    /// Diameter of the shaft (mm).
    pub diameter_mm: f64,
    /// Young's modulus (N/mm²).
    pub modulus_n_mm2: f64,
    /// Position of the headstock's centre, or of the front of the jaws of its chuck, along `z_axis` (mm).
    pub headstock_z_mm: f64,
    /// Distance to the centre of the tailstock; without tailstock the free length (mm).
    pub length_mm: f64,
    pub grip: HeadstockGrip,
    /// The tailstock holds the other end.
    pub tailstock: bool,
    /// Position of the steady rest along `z_axis` (mm); `None`: not in use.
    pub steady_rest_z_mm: Option<f64>,
}

/// Ranges of the figures of a shaft: diameter, length (mm), modulus (N/mm²), positions (mm).
const DIAMETERS_MM: (f64, f64) = (1.0, 1e3);
const LENGTHS_MM: (f64, f64) = (10.0, 1e4);
const MODULI_N_MM2: (f64, f64) = (1e3, 1e6);
const POSITIONS_MM: (f64, f64) = (-1e4, 1e4);

impl PartSupport {
    /// Shaft on the supports of a machine; `None` where the machine lacks one of them, or a centre would hold the shaft alone.
    #[must_use]
    pub fn shaft(&self, machine: &MachineDescription) -> Option<SupportedShaft> {
        let layout = ShaftLayout {
            headstock_z_mm: self.headstock_z_mm,
            length_mm: self.length_mm,
            bending_n_mm2: round_bending_n_mm2(self.modulus_n_mm2, self.diameter_mm),
            is_chucked: self.grip == HeadstockGrip::Chuck,
            has_tailstock: self.tailstock,
            steady_rest_z_mm: self.steady_rest_z_mm,
        };
        SupportedShaft::new(&layout, machine.workholding.as_ref()?)
    }

    fn check_ranges(&self) -> Result<(), JobError> {
        let figures = [
            (JobKey::PartDiameter, Some(self.diameter_mm), DIAMETERS_MM, "1 to 1000"),
            (JobKey::PartLength, Some(self.length_mm), LENGTHS_MM, "10 to 10000"),
            (JobKey::PartModulus, Some(self.modulus_n_mm2), MODULI_N_MM2, "1000 to 1000000 (1 to 1000 GPa)"),
            (JobKey::HeadstockZ, Some(self.headstock_z_mm), POSITIONS_MM, "-10000 to 10000"),
        ];
        for (key, value, (low, high), wanted) in figures {
            if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                return Err(JobError::OutOfRange { place: Subject::Job, key, value, wanted });
            }
        }
        Ok(())
    }

    fn check_machine(&self, machine: &MachineDescription) -> Result<(), JobError> {
        let lacks = |what, key| Err(JobError::NoSupport { machine: machine.name.clone(), what, key });
        if machine.contact.is_none() {
            return lacks("contact, so nothing deflects", "contact");
        }
        let Some(workholding) = &machine.workholding else {
            return lacks("stiffness of its supports", "workholding");
        };
        if self.grip == HeadstockGrip::Chuck && workholding.chuck_tilt_n_mm_rad.is_none() {
            return lacks("tilting stiffness of a chuck", "workholding.chuck_tilt_n_m_rad");
        }
        if self.tailstock && workholding.tailstock_n_mm.is_none() {
            return lacks("stiffness of a tailstock", "workholding.tailstock_stiffness_n_um");
        }
        if self.grip == HeadstockGrip::Centre && !self.tailstock {
            return Err(JobError::LoosePart);
        }
        let Some(z_mm) = self.steady_rest_z_mm else { return Ok(()) };
        let Some(rest) = workholding.steady_rest else { return lacks("steady rest", "workholding.steady_rest") };
        let half_mm = 0.5 * rest.jaw_width_mm;
        let (low_mm, high_mm) = (self.headstock_z_mm + half_mm, self.headstock_z_mm + self.length_mm - half_mm);
        if !(low_mm..=high_mm).contains(&z_mm) {
            return Err(JobError::RestOutside { z_mm, low_mm, high_mm });
        }
        Ok(())
    }

    /// A lobe stands between the supports, and beside the jaws of the steady rest.
    fn check_lobe(&self, lobe: &LobeSpec, machine: &MachineDescription) -> Result<(), JobError> {
        let Some(station) = machine.station(&lobe.station) else { return Ok(()) };
        let z_mm = station.position_mm + plunges::offset_of(lobe);
        let (from_mm, to_mm) = (z_mm - 0.5 * lobe.width_mm, z_mm + 0.5 * lobe.width_mm);
        let (low_mm, high_mm) = (self.headstock_z_mm, self.headstock_z_mm + self.length_mm);
        let name = || lobe.name.clone();
        if !(from_mm >= low_mm && to_mm <= high_mm) {
            return Err(JobError::OutsideSupports { lobe: name(), from_mm, to_mm, low_mm, high_mm });
        }
        let rest = machine.workholding.and_then(|workholding| workholding.steady_rest);
        let Some((rest, rest_mm)) = rest.zip(self.steady_rest_z_mm) else { return Ok(()) };
        let (jaws_from_mm, jaws_to_mm) = (rest_mm - 0.5 * rest.jaw_width_mm, rest_mm + 0.5 * rest.jaw_width_mm);
        if from_mm < jaws_to_mm && to_mm > jaws_from_mm {
            return Err(JobError::UnderSteadyRest { lobe: name(), from_mm, to_mm, jaws_from_mm, jaws_to_mm });
        }
        Ok(())
    }
}

/// Radial compliance of the part on its supports (mm/N) beside the position of a station (mm); 0 of a job without `part_support`, and without
/// the station.
pub(crate) fn compliance_mm_n(
    support: Option<&PartSupport>,
    machine: &MachineDescription,
    station: &str,
    offset_mm: f64,
) -> f64 {
    let shaft = support.and_then(|support| support.shaft(machine)).zip(machine.station(station));
    shaft.map_or(0.0, |(shaft, station)| shaft.compliance_mm_n(station.position_mm + offset_mm))
}

impl JobSpec {
    /// Radial compliance of the part on its supports where the wheel grinds a lobe, or a plunge of one (mm/N); 0 of a job without
    /// `part_support`.
    #[must_use]
    pub fn lobe_compliance_mm_n(&self, machine: &MachineDescription, lobe: &LobeSpec) -> f64 {
        compliance_mm_n(self.part_support.as_ref(), machine, &lobe.station, plunges::offset_of(lobe))
    }

    pub(super) fn check_part_support(&self, machine: &MachineDescription) -> Result<(), JobError> {
        let Some(support) = &self.part_support else { return Ok(()) };
        support.check_ranges()?;
        support.check_machine(machine)?;
        self.lobes.iter().try_for_each(|lobe| support.check_lobe(lobe, machine))
    }
}
