//! What a machine file says about the insert of a lathe.

use super::ConfigError;
use super::machine_file::RangeCheck;
use camwright::machine::description::InsertDescription;
use camwright::math::units::{rad_from_deg, rad_s_from_rpm};
use serde::Deserialize;

/// A round, driven insert.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InsertFile {
    radius_mm: f64,
    height_mm: f64,
    height_min_mm: f64,
    height_max_mm: f64,
    relief_deg: f64,
    surface_speed_m_s: f64,
    spin_up_s: f64,
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

    pub(super) fn check(&self, within: &RangeCheck<'_>) -> Result<(), ConfigError> {
        within("insert.radius_mm", self.radius_mm, 0.1, 100.0)?;
        within("insert.height_min_mm", self.height_min_mm, -500.0, 500.0)?;
        within("insert.height_max_mm", self.height_max_mm, self.height_min_mm, 500.0)?;
        within("insert.height_mm", self.height_mm, self.height_min_mm, self.height_max_mm)?;
        within("insert.relief_deg", self.relief_deg, 0.0, 45.0)?;
        within("insert.surface_speed_m_s", self.surface_speed_m_s, 0.01, 100.0)?;
        within("insert.spin_up_s", self.spin_up_s, 0.0, 600.0)?;
        self.max_speed_rpm.map_or(Ok(()), |value| within("insert.max_speed_rpm", value, 1.0, 1e6))
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
        assert!(refusal(&lathe[..lathe.find("\ninsert:").expect("its section")], &[]).contains("has neither"));
        assert!(refusal(&lathe, &["insert.height_mm=31.0"]).contains("insert.height_mm is 31, allowed is -30 to 30"));
        let with_gauge = lathe + "\ngap_detector: {holds_ms: 5.0}\n";
        assert!(refusal(&with_gauge, &[]).contains("cannot have a gap detector"));
        let without_dogs = grinder.replace("dog_length_mm: 8.0\n", "");
        assert!(refusal(&without_dogs, &[]).contains("dog_length_mm is missing"));
    }
}
