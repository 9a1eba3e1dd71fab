// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Insert of a lathe in a machine file.

use super::ConfigError;
use super::yaml::Document;
use camwright::machine::description::{EdgeArc, InsertDescription, InsertRotation, InsertSpindle};
use camwright::math::units::{rad_from_deg, rad_s_from_rpm};
use schemars::JsonSchema;
use serde::Deserialize;

/// A round insert, driven or clamped.
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
    /// Arc of the edge that may cut. Default: the whole circle.
    pub(super) edge: Option<EdgeFile>,
    /// True for an insert on a spindle of its own, false for a clamped one, which needs no speed. Default: true.
    #[serde(default = "rotates")]
    rotates: bool,
    /// Speed of the edge along itself. Required if the insert rotates.
    #[schemars(range(min = 0.01, max = 100.0))]
    surface_speed_m_s: Option<f64>,
    /// Time to reach the speed. Required if the insert rotates.
    #[schemars(range(min = 0.0, max = 600.0))]
    spin_up_s: Option<f64>,
    /// Speed that the spindle allows. Default: unknown.
    #[schemars(range(min = 1.0, max = 1e6))]
    max_speed_rpm: Option<f64>,
    /// Direction of a rotating insert, seen from its spindle towards the rake face: clockwise is M3, counterclockwise M4. Default: clockwise.
    rotation: Option<RotationFile>,
}

/// Arc of the edge of a round insert.
///
/// Angles are in the rake plane at the insert's centre: 0 faces the spindle axis (-X), positive angles lie towards +z of the part, away from
/// the chuck.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EdgeFile {
    /// Begin of the arc: 0 faces the spindle axis (-X), positive angles lie towards +z of the part.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub(super) from_deg: f64,
    /// End of the arc, above its begin.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub(super) to_deg: f64,
}

/// Direction of a rotating insert.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum RotationFile {
    Clockwise,
    Counterclockwise,
}

const fn rotates() -> bool {
    true
}

impl InsertFile {
    pub(super) fn insert(&self, document: &Document) -> Result<InsertDescription, ConfigError> {
        Ok(InsertDescription {
            radius_mm: self.radius_mm,
            height_mm: self.height_mm,
            height_range_mm: (self.height_min_mm, self.height_max_mm),
            relief_rad: rad_from_deg(self.relief_deg),
            edge: self
                .edge
                .map(|edge| EdgeArc { from_rad: rad_from_deg(edge.from_deg), to_rad: rad_from_deg(edge.to_deg) }),
            spindle: self.spindle(document)?,
        })
    }

    fn spindle(&self, document: &Document) -> Result<Option<InsertSpindle>, ConfigError> {
        if !self.rotates {
            let stated = [
                ("surface_speed_m_s", self.surface_speed_m_s.is_some()),
                ("spin_up_s", self.spin_up_s.is_some()),
                ("max_speed_rpm", self.max_speed_rpm.is_some()),
                ("rotation", self.rotation.is_some()),
            ];
            return match stated.into_iter().find(|(_, is_stated)| *is_stated) {
                None => Ok(None),
                Some((key, _)) => {
                    let message =
                        format!("insert.{key} is for an insert that rotates: remove it, or insert.rotates: false");
                    Err(document.error(&format!("insert.{key}"), message))
                }
            };
        }
        let required = |key: &str, value: Option<f64>| {
            let message = || {
                format!(
                    "insert.{key} is missing: an insert that rotates needs it (insert.rotates: false is a clamped one)"
                )
            };
            value.ok_or_else(|| document.error("insert", message()))
        };
        Ok(Some(InsertSpindle {
            surface_speed_m_s: required("surface_speed_m_s", self.surface_speed_m_s)?,
            spin_up_s: required("spin_up_s", self.spin_up_s)?,
            max_speed_rad_s: self.max_speed_rpm.map(rad_s_from_rpm),
            rotation: match self.rotation {
                None | Some(RotationFile::Clockwise) => InsertRotation::Clockwise,
                Some(RotationFile::Counterclockwise) => InsertRotation::Counterclockwise,
            },
        }))
    }
}

#[cfg(test)]
mod tests {
    use crate::locate::locate;
    use crate::machine_file;
    use camwright::machine::description::InsertRotation;
    use std::f64::consts::FRAC_PI_2;
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

    #[test]
    fn an_insert_rotates_either_way_or_not_at_all() {
        let lathe = shipped("lathe");
        let parsed = |text: &str, overrides: &[&str]| {
            let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
            let machine = machine_file::parse(Path::new("m.yaml"), text, &overrides);
            machine.unwrap_or_else(|errors| panic!("{errors:?}")).description
        };
        let insert = |overrides: &[&str]| parsed(&lathe, overrides).insert.expect("a lathe");
        let rotation = |overrides: &[&str]| insert(overrides).spindle.map(|spindle| spindle.rotation);
        assert_eq!(rotation(&[]), Some(InsertRotation::Clockwise));
        assert_eq!(rotation(&["insert.rotation=clockwise"]), rotation(&[]));
        assert_eq!(rotation(&["insert.rotation=counterclockwise"]), Some(InsertRotation::Counterclockwise));
        assert_eq!(insert(&[]).edge, None);
        let edge = insert(&["insert.edge={from_deg: -90.0, to_deg: 30.0}"]).edge.expect("an arc");
        assert!((edge.from_rad + FRAC_PI_2).abs() < 1e-12 && (edge.to_rad - FRAC_PI_2 / 3.0).abs() < 1e-12);
        let keys = ["surface_speed_m_s", "spin_up_s", "max_speed_rpm"];
        let is_spindle = |line: &&str| keys.iter().any(|key| line.trim_start().starts_with(&format!("{key}:")));
        let (axes, tool) = lathe.split_at(lathe.find("\ninsert:").expect("its section"));
        let tool: String = tool.lines().filter(|line| !is_spindle(line)).map(|line| format!("{line}\n")).collect();
        let clamped = format!("{axes}{tool}  rotates: false\n");
        let machine = parsed(&clamped, &[]);
        assert!(machine.cuts_at_rest() && machine.wheel.surface_speed_m_s == 0.0);
        // A spindle without a speed, and a speed without a spindle.
        for (text, set, words) in [
            (&clamped, "insert.rotates=true", "insert.surface_speed_m_s is missing"),
            (&clamped, "insert.spin_up_s=1.0", "insert.spin_up_s is for an insert that rotates"),
            (&clamped, "insert.rotation=clockwise", "insert.rotation is for an insert that rotates"),
            (&lathe, "insert.rotates=false", "insert.surface_speed_m_s is for an insert that rotates"),
            (&lathe, "insert.rotation=m3", "clockwise, counterclockwise"),
            (&lathe, "insert.edge={from_deg: 20.0, to_deg: 10.0}", "insert.edge.to_deg is 10; it must be 20 to inf"),
            (&lathe, "insert.edge={from_deg: -200.0, to_deg: 10.0}", "from_deg is -200; it must be -180 to 180"),
        ] {
            let error = refusal(text, &[set]);
            assert!(error.contains(words), "{set}: {error}");
        }
        let error = refusal(&clamped.replace("rotates: false", "rotates: true"), &[]);
        // The first line of its section.
        let line = clamped.lines().position(|line| line == "insert:").expect("its section") + 2;
        assert!(error.contains(&format!("m.yaml:{line}: insert.surface_speed_m_s is missing")), "{error}");
    }
}
