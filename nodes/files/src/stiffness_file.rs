// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The file in which the stiffness of a machine is kept, as it was measured on the journals of its jobs.

use super::ConfigError;
use super::contact_file::PER_MM;
use super::schema;
use super::yaml::Document;
use camwright::gauging::stiffness::MeasuredValue;
use camwright::gauging::stiffness_map::{MeasuredStiffness, SAME_PLACE_MM, StiffnessMap, StiffnessMapError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Newest version of the schema that this program reads.
const SCHEMA_VERSION: u32 = 1;

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StiffnessFile {
    schema: String,
    machine: String,
    parts: u64,
    places: Vec<ContactEntry>,
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ContactEntry {
    z_mm: f64,
    lobe: String,
    job: String,
    part: u64,
    width_mm: f64,
    machine_n_um: f64,
    machine_n_um_uncertainty: f64,
    grinding_n_um_mm: f64,
    grinding_n_um_mm_uncertainty: f64,
    threshold_n_mm: f64,
    threshold_n_mm_uncertainty: f64,
}

/// A place and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredContact {
    pub place: MeasuredStiffness,
    pub lobe: String,
    pub job: String,
    /// Which part it was, of those on which stiffness was measured.
    pub part: u64,
    /// Width of the cut (mm).
    pub width_mm: f64,
}

/// Stored stiffness of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredStiffness {
    /// Name of the machine.
    pub machine: String,
    /// Parts on which stiffness was measured.
    pub parts: u64,
    places: Vec<StoredContact>,
    map: StiffnessMap,
}

impl StoredStiffness {
    #[must_use]
    pub fn new(machine: &str) -> Self {
        Self { machine: machine.into(), parts: 0, places: Vec::new(), map: StiffnessMap::default() }
    }

    /// Parses the text of [`Self::text`].
    ///
    /// # Errors
    /// One sentence with file and line for what is not that: another schema, unknown keys, numbers that no measurement gives.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let document = Document::parse(path, text, &[])?;
        document.require_schema("stiffness", SCHEMA_VERSION)?;
        let file: StiffnessFile = schema::read(&document).map_err(|mut findings| findings.swap_remove(0))?;
        let mut kept = Self { parts: file.parts, ..Self::new(&file.machine) };
        for (index, place) in file.places.into_iter().enumerate() {
            let refuse = |error: StiffnessMapError| document.error(&format!("places.{index}"), error.to_string());
            let place = place.kept();
            // One place twice is another file's.
            if let Some(same) = kept.places.iter().find(|other| is_same(other, &place)) {
                let (first_mm, second_mm) = (same.place.z_mm, place.place.z_mm);
                return Err(refuse(StiffnessMapError::SamePlace { first_mm, second_mm, min_mm: SAME_PLACE_MM }));
            }
            kept.insert(place).map_err(refuse)?;
        }
        Ok(kept)
    }

    /// Text of the file.
    ///
    /// # Errors
    /// What YAML says.
    pub fn text(&self) -> Result<String, String> {
        let file = StiffnessFile {
            schema: format!("camwright/stiffness/{SCHEMA_VERSION}"),
            machine: self.machine.clone(),
            parts: self.parts,
            places: self.places.iter().map(ContactEntry::from_stored).collect(),
        };
        serde_saphyr::to_string(&file).map_err(|error| error.to_string())
    }

    /// The places, in the order of the table.
    #[must_use]
    pub fn places(&self) -> &[StoredContact] {
        &self.places
    }

    /// Interpolation between the positions.
    #[must_use]
    pub const fn map(&self) -> &StiffnessMap {
        &self.map
    }

    /// Keeps a place in the stead of what was kept for it.
    ///
    /// # Errors
    /// Numbers that no measurement gives; nothing has changed then.
    pub fn insert(&mut self, place: StoredContact) -> Result<(), StiffnessMapError> {
        let mut places: Vec<StoredContact> =
            self.places.iter().filter(|other| !is_same(other, &place)).cloned().collect();
        places.push(place);
        places.sort_by(|a, b| a.place.z_mm.total_cmp(&b.place.z_mm));
        self.map = StiffnessMap::new(places.iter().map(|kept| kept.place).collect())?;
        self.places = places;
        Ok(())
    }
}

fn is_same(one: &StoredContact, other: &StoredContact) -> bool {
    (one.place.z_mm - other.place.z_mm).abs() <= SAME_PLACE_MM
}

/// A number of a file: to a millionth of its unit.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

impl ContactEntry {
    fn from_stored(kept: &StoredContact) -> Self {
        let place = &kept.place;
        let [machine, grinding] = [place.machine_n_mm, place.grinding_n_mm2]
            .map(|of| [rounded(of.value / PER_MM), rounded(of.uncertainty / PER_MM)]);
        Self {
            z_mm: place.z_mm,
            lobe: kept.lobe.clone(),
            job: kept.job.clone(),
            part: kept.part,
            width_mm: kept.width_mm,
            machine_n_um: machine[0],
            machine_n_um_uncertainty: machine[1],
            grinding_n_um_mm: grinding[0],
            grinding_n_um_mm_uncertainty: grinding[1],
            threshold_n_mm: rounded(place.threshold_n_mm.value),
            threshold_n_mm_uncertainty: rounded(place.threshold_n_mm.uncertainty),
        }
    }

    fn kept(self) -> StoredContact {
        let per_um =
            |value: f64, uncertainty: f64| MeasuredValue { value: PER_MM * value, uncertainty: PER_MM * uncertainty };
        let place = MeasuredStiffness {
            z_mm: self.z_mm,
            machine_n_mm: per_um(self.machine_n_um, self.machine_n_um_uncertainty),
            grinding_n_mm2: per_um(self.grinding_n_um_mm, self.grinding_n_um_mm_uncertainty),
            threshold_n_mm: MeasuredValue { value: self.threshold_n_mm, uncertainty: self.threshold_n_mm_uncertainty },
        };
        StoredContact { place, lobe: self.lobe, job: self.job, part: self.part, width_mm: self.width_mm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(z_mm: f64, n_mm: f64) -> StoredContact {
        let measured = |value: f64, uncertainty: f64| MeasuredValue { value, uncertainty };
        StoredContact {
            place: MeasuredStiffness {
                z_mm,
                machine_n_mm: measured(n_mm, 51.5),
                grinding_n_mm2: measured(1512.25, 40.125),
                threshold_n_mm: measured(0.8, 0.125),
            },
            lobe: "J1".into(),
            job: "journal_runout".into(),
            part: 3,
            width_mm: 20.0,
        }
    }

    #[test]
    fn what_is_kept_goes_through_its_file_and_a_place_measured_again_replaces_what_was_there() {
        let mut kept = StoredStiffness { parts: 3, ..StoredStiffness::new("journal_grinder") };
        for (z_mm, n_mm) in [(150.0, 4012.5), (80.0, 6000.0), (150.25, 4050.0)] {
            kept.insert(place(z_mm, n_mm)).unwrap();
        }
        let z: Vec<f64> = kept.places().iter().map(|kept| kept.place.z_mm).collect();
        assert_eq!(z, [80.0, 150.25]);
        let read = StoredStiffness::parse(Path::new("kept.yaml"), &kept.text().unwrap()).unwrap();
        assert_eq!(read, kept);
        assert!(kept.insert(place(220.0, -1.0)).is_err());
        assert_eq!(read, kept, "nothing has changed");
    }

    #[test]
    fn an_invalid_stiffness_file_is_refused_with_its_line() {
        let mut kept = StoredStiffness::new("journal_grinder");
        kept.insert(place(80.0, 6000.0)).unwrap();
        let text = kept.text().unwrap();
        let refused = |text: &str| StoredStiffness::parse(Path::new("kept.yaml"), text).unwrap_err().to_string();
        assert!(refused(&text.replace("stiffness/1", "stiffness/9")).contains("kept.yaml:1"), "{text}");
        assert!(refused(&text.replace("stiffness/1", "machine/1")).contains("kept.yaml:1"));
        let negative = refused(&text.replace("machine_n_um: 6", "machine_n_um: -6"));
        assert!(negative.contains("kept.yaml:5") && negative.contains("machine stiffness"), "{negative}");
        assert!(refused(&text.replace("lobe:", "lobes:")).contains("kept.yaml:"));
        assert!(refused("nothing").contains("kept.yaml"));
    }
}
