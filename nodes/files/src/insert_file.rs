// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Insert of a lathe in a machine file.

use camwright::machine::description::InsertDescription;
use camwright::math::units::{rad_from_deg, rad_s_from_rpm};
use schemars::JsonSchema;
use serde::Deserialize;

/// A round, driven insert.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InsertFile {
    /// R, radius of the insert. X is the distance of its centre from the spindle axis in the rake plane.
    #[schemars(range(min = 0.1, max = 100.0))]
    radius_mm: f64,
    /// H, height of the rake face above the spindle axis.
    #[schemars(range(min = -500.0, max = 500.0))]
    pub(super) height_mm: f64,
    /// Lowest height that the tool can be set to.
    #[schemars(range(min = -500.0, max = 500.0))]
    pub(super) height_min_mm: f64,
    /// Highest height that the tool can be set to.
    #[schemars(range(min = -500.0, max = 500.0))]
    pub(super) height_max_mm: f64,
    /// Relief of the flank from the normal of the rake face.
    #[schemars(range(min = 0.0, max = 45.0))]
    relief_deg: f64,
    /// Speed of the edge along itself.
    #[schemars(range(min = 0.01, max = 100.0))]
    surface_speed_m_s: f64,
    /// Time to reach the speed.
    #[schemars(range(min = 0.0, max = 600.0))]
    spin_up_s: f64,
    /// Speed that the spindle allows. Default: unknown.
    #[schemars(range(min = 1.0, max = 1e6))]
    max_speed_rpm: Option<f64>,
}

impl InsertFile {
    pub(super) fn insert(&self) -> InsertDescription {
        InsertDescription {
            radius_mm: self.radius_mm,
            height_mm: self.height_mm,
            height_range_mm: (self.height_min_mm, self.height_max_mm),
            relief_rad: rad_from_deg(self.relief_deg),
            surface_speed_m_s: self.surface_speed_m_s,
            spin_up_s: self.spin_up_s,
            max_speed_rad_s: self.max_speed_rpm.map(rad_s_from_rpm),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::locate::locate;
    use crate::machine_file;
    use std::path::Path;

    fn shipped(name: &str) -> String {
        locate("machines", name, "yaml", None).expect("it is shipped").text
    }

    fn refusal(text: &str, overrides: &[&str]) -> String {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let error = machine_file::parse(Path::new("m.yaml"), text, &overrides).expect_err("it is no machine");
        error.to_string()
    }

    #[test]
    fn the_shipped_lathe_has_an_insert_below_the_axis_and_no_stations() {
        let machine =
            machine_file::parse(Path::new("lathe.yaml"), &shipped("lathe"), &[]).expect("a machine").description;
        let insert = machine.insert.expect("a lathe");
        assert!(machine.stations.is_empty() && insert.height_mm < 0.0 && insert.radius_mm > 0.0);
        assert_eq!(machine.wheel, insert.tool());
        assert!(machine.with_good_drives().is_some());
        let grinder = machine_file::parse(Path::new("g.yaml"), &shipped("cam_grinder"), &[]).expect("a machine");
        assert!(!grinder.description.is_lathe());
    }

    #[test]
    fn a_machine_with_both_tools_or_none_is_refused_and_so_is_a_height_out_of_range() {
        let (lathe, grinder) = (shipped("lathe"), shipped("cam_grinder"));
        let insert = &lathe[lathe.find("\ninsert:").expect("its section")..];
        assert!(refusal(&(grinder.clone() + insert), &[]).contains("this one has both"));
        assert!(refusal(&lathe[..lathe.find("\ninsert:").expect("its section")], &[]).contains("this one has neither"));
        assert!(refusal(&lathe, &["insert.height_mm=31.0"]).contains("insert.height_mm is 31; it must be -30 to 30"));
        let with_gauge = lathe + "\ngap_detector: {holds_ms: 5.0}\n";
        assert!(refusal(&with_gauge, &[]).contains("cannot have a gap detector"));
        let without_dogs = grinder.replace("dog_length_mm: 8.0\n", "");
        assert!(refusal(&without_dogs, &[]).contains("dog_length_mm is missing"));
    }
}
