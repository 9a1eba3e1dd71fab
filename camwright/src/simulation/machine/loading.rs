//! Parts are put into the machine and taken out.

use super::Machine;
use super::turning::Clamped;
use crate::simulation::turned_part::{TurnedPart, TurnedPartError};
use crate::simulation::workpiece::{CutRecord, Lobe, LobeError};
use alloc::string::{String, ToString};
use alloc::vec::Vec;

impl Machine {
    /// Puts a raw part into the chuck of a lathe, in the place of one that is there. The insert's centre stands at `part_zero_mm` of the
    /// part where Z is 0, and at z = Z + `part_zero_mm` elsewhere: a positive Z draws the chuck back, towards −z of the part, so that the
    /// tool comes to a greater z of it.
    ///
    /// # Errors
    /// A machine that grinds; a zero that is no number.
    pub fn load_turned_part(&mut self, part: TurnedPart, part_zero_mm: f64) -> Result<(), TurnedPartError> {
        let name = || part.name().into();
        if self.description.insert.is_none() {
            return Err(TurnedPartError::NotALathe { name: name() });
        }
        if !part_zero_mm.is_finite() {
            return Err(TurnedPartError::Zero { name: name(), part_zero_mm });
        }
        self.turned = Some(Clamped { part, zero_mm: part_zero_mm });
        Ok(())
    }

    /// Puts one lobe of a raw part between the centres, in the place of one with the same name: radii (mm) at azimuths
    /// i·2π/n from the key-way, in front of the wheel when the table stands at the station's position.
    ///
    /// # Errors
    /// An unknown station or one that is taken, an outline that is none.
    pub fn load_lobe(&mut self, name: &str, station: &str, width_mm: f64, radii: Vec<f64>) -> Result<(), LobeError> {
        let index = self
            .description
            .stations
            .iter()
            .position(|s| s.switch == station)
            .ok_or_else(|| LobeError::UnknownStation { name: name.to_string(), station: station.to_string() })?;
        if let Some(other) = self.part.lobes().iter().find(|lobe| lobe.station() == index && lobe.name() != name) {
            return Err(LobeError::StationTaken {
                name: name.to_string(),
                station: station.to_string(),
                other: other.name().to_string(),
            });
        }
        let mut lobe = Lobe::new(String::from(name), index, width_mm, radii)?;
        if let Some(record) = CutRecord::of(&self.description) {
            lobe.record(record);
        }
        self.part.load(lobe);
        Ok(())
    }

    /// Azimuth of the part's key-way as it is clamped (rad): of a part that is clamped as it should be 0, which faces the wheel where
    /// C is 0.
    #[must_use]
    pub fn key_way_rad(&self) -> f64 {
        self.key_way_rad
    }

    /// The part is clamped with its key-way there (rad). What is no number is taken for 0. The outlines of its lobes are given as the
    /// part is clamped.
    pub fn set_key_way(&mut self, key_way_rad: f64) {
        self.key_way_rad = if key_way_rad.is_finite() { key_way_rad } else { 0.0 };
    }

    /// Takes the part out.
    pub fn clear_part(&mut self) {
        self.part.clear();
        self.turned = None;
        self.key_way_rad = 0.0;
        self.ground = None;
    }
}
