// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parts are put into the machine and taken out.

use super::Machine;
use crate::cam::contour::LobeCentre;
use crate::simulation::turned_part::{TurnedPart, TurnedPartError};
use crate::simulation::workpiece::{LobeError, Workpiece};
use alloc::vec::Vec;

impl Machine {
    /// Puts a raw part into the chuck of a lathe, in the place of one that is there. The insert's centre stands at `part_zero_mm` of the
    /// part where Z is 0, and at z = Z + `part_zero_mm` elsewhere: a positive Z draws the chuck back, towards −z of the part, so that the
    /// tool comes to a greater z of it.
    ///
    /// # Errors
    /// A machine that grinds; a zero that is no number.
    pub fn load_turned_part(&mut self, part: TurnedPart, part_zero_mm: f64) -> Result<(), TurnedPartError> {
        self.workholding.load_turned_part(part, part_zero_mm, &self.description)
    }

    /// Puts one lobe of a raw part between the centres, in the place of one with the same name: radii (mm) at azimuths
    /// i·2π/n from the keyway, in front of the wheel when the table stands at the station's position.
    ///
    /// # Errors
    /// An unknown station or one that is taken, an outline that is none.
    pub fn load_lobe(&mut self, name: &str, station: &str, width_mm: f64, radii: Vec<f64>) -> Result<(), LobeError> {
        self.load_lobe_about(name, station, (width_mm, radii), None)
    }

    /// The same for a lobe whose radii are about a centre off the axis, of a crank pin; azimuths are from the direction of the keyway.
    ///
    /// # Errors
    /// See [`Machine::load_lobe`]; a centre that is no place.
    pub fn load_lobe_about(
        &mut self,
        name: &str,
        station: &str,
        (width_mm, radii): (f64, Vec<f64>),
        centre: Option<LobeCentre>,
    ) -> Result<(), LobeError> {
        self.load_section(name, station, (0.0, width_mm, radii), centre)
    }

    /// The same for a section of a lobe that is wider than the wheel: the middle of the section stands beside the position of the station
    /// (mm along Z, before its width). The wheel grinds all sections of a lobe whose middles it faces, together.
    ///
    /// # Errors
    /// See [`Machine::load_lobe_about`]; sections that overlap, or more than a wheel can meet at once.
    pub fn load_section(
        &mut self,
        name: &str,
        station: &str,
        (offset_mm, width_mm, radii): (f64, f64, Vec<f64>),
        centre: Option<LobeCentre>,
    ) -> Result<(), LobeError> {
        self.workholding.load_section(name, station, (offset_mm, width_mm, radii), centre, &self.description)
    }

    /// Gives a lobe or section that is in the machine the radial compliance of the part on its supports there (mm/N).
    ///
    /// # Errors
    /// A number that is none or below 0; a lobe that is not there; a machine without `workholding`, unless the compliance is 0.
    pub fn set_part_compliance(&mut self, name: &str, part_mm_n: f64) -> Result<(), LobeError> {
        self.check_part_compliance(name, part_mm_n)?;
        self.workholding.set_part_compliance(name, part_mm_n)
    }

    /// Checks whether a lobe that is not in the machine yet could have this compliance (mm/N).
    ///
    /// # Errors
    /// See [`Machine::set_part_compliance`].
    pub fn check_part_compliance(&self, name: &str, part_mm_n: f64) -> Result<(), LobeError> {
        let is_possible = part_mm_n >= 0.0 && part_mm_n.is_finite();
        match is_possible && (part_mm_n == 0.0 || self.description.workholding.is_some()) {
            true => Ok(()),
            false => Err(LobeError::PartCompliance { name: name.into(), part_mm_n }),
        }
    }

    /// Azimuth of the part's keyway as it is clamped (rad): of a part that is clamped as it should be 0, which faces the wheel where
    /// C is 0.
    #[must_use]
    pub fn key_way_rad(&self) -> f64 {
        self.workholding.key_way_rad()
    }

    /// The part is clamped with its keyway there (rad); 0 if that is not finite. The outlines of its lobes are given as the
    /// part is clamped.
    pub fn set_keyway(&mut self, key_way_rad: f64) {
        self.workholding.set_keyway(key_way_rad);
    }

    /// Takes the part out.
    pub fn clear_part(&mut self) {
        self.workholding.clear();
        self.wheel.forget_lobe();
        if let Some(arm) = &mut self.changer {
            arm.take_ground();
        }
    }

    /// The part between the centres.
    #[must_use]
    pub fn part(&self) -> &Workpiece {
        self.workholding.part()
    }

    /// The part in the chuck of a lathe.
    #[must_use]
    pub fn turned_part(&self) -> Option<&TurnedPart> {
        self.workholding.turned().map(|clamped| &clamped.part)
    }

    /// Position of the insert's centre along that part when Z is 0 (mm); 0 without one.
    #[must_use]
    pub fn part_zero_mm(&self) -> f64 {
        self.workholding.turned().map_or(0.0, |clamped| clamped.zero_mm)
    }
}
