// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel changer in machine files.

use super::ConfigError;
use super::machine_file::WheelFile;
use super::yaml::Document;
use camwright::machine::description::{MAX_WHEELS, MagazineWheel, WheelChanger};
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::Deserialize;

/// Name of a wheel without one.
const UNNAMED: &str = "wheel";

/// Changer of grinding wheels.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelChangerFile {
    /// Time of a change, with the wheel at rest.
    #[schemars(range(min = 0.1, max = 3600.0))]
    change_s: f64,
    /// Smallest position of `x_axis` at which it changes; within the soft limits of X.
    #[schemars(range(min = -1e5, max = 1e5))]
    pub(super) min_x_mm: f64,
    /// Wheels in addition to `wheel`, which is mounted on a machine without a state file.
    #[schemars(length(min = 1, max = MAX_WHEELS - 1))]
    pub(super) wheels: Vec<WheelFile>,
}

impl WheelChangerFile {
    /// The changer with this wheel mounted.
    pub(super) fn changer(&self, first: &WheelFile) -> WheelChanger {
        let wheel = |file: &WheelFile| MagazineWheel {
            name: name_of(file).to_owned(),
            wheel: file.wheel(),
            setting_error_mm: mm_from_um(file.setting_error_um),
        };
        WheelChanger {
            change_s: self.change_s,
            min_x_mm: self.min_x_mm,
            wheels: std::iter::once(first).chain(&self.wheels).map(wheel).collect(),
            mounted: 0,
        }
    }
}

fn name_of(file: &WheelFile) -> &str {
    file.name.as_deref().unwrap_or(UNNAMED)
}

/// All wheels of a machine with the keys that hold them.
pub(super) fn wheels<'a>(
    first: Option<&'a WheelFile>,
    changer: Option<&'a WheelChangerFile>,
) -> impl Iterator<Item = (String, &'a WheelFile)> {
    let further = changer.into_iter().flat_map(|changer| changer.wheels.iter().enumerate());
    let further = further.map(|(index, wheel)| (format!("wheel_changer.wheels.{index}"), wheel));
    first.into_iter().map(|wheel| ("wheel".to_owned(), wheel)).chain(further)
}

/// Everything that is wrong with names and offsets of the wheels.
pub(super) fn check(
    document: &Document,
    first: Option<&WheelFile>,
    changer: Option<&WheelChangerFile>,
) -> Vec<ConfigError> {
    let mut findings = Vec::new();
    if changer.is_none() {
        if first.is_some_and(|wheel| wheel.setting_error_um.abs() > 0.0) {
            let key = "wheel.setting_error_um";
            findings.push(
                document.error(key, format!("{key} needs wheel_changer: a wheel that is never changed has none")),
            );
        }
        return findings;
    }
    if first.is_none() {
        findings.push(document.error("wheel_changer", "wheel_changer needs wheel: a lathe has none".to_owned()));
    }
    let mut names: Vec<&str> = Vec::new();
    for (key, wheel) in wheels(first, changer) {
        if wheel.name.is_none() && key != "wheel" {
            findings.push(document.error(&key, format!("{key}.name is missing: jobs name the wheels of a changer")));
            continue;
        }
        let name = name_of(wheel);
        if names.contains(&name) {
            let message = format!("{key}.name is {name:?}, and so is that of another wheel; every wheel needs its own");
            findings.push(document.error(&format!("{key}.name"), message));
        }
        names.push(name);
    }
    findings
}

#[cfg(test)]
mod tests {
    use crate::{locate, machine_file};

    fn read(overrides: &[&str]) -> Result<machine_file::MachineConfig, String> {
        let located = locate::locate("machines", "cam_grinder_two_wheels", "yaml", None).expect("a shipped machine");
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let read = machine_file::read(&located.path, &located.text, &overrides);
        read.map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    }

    #[test]
    fn the_wheels_of_a_changer_are_read() {
        let machine = read(&["wheel_changer.wheels.0.setting_error_um=-3"]).expect("a changer").description;
        let changer = machine.wheel_changer.as_ref().expect("a changer");
        let names: Vec<&str> = changer.wheels.iter().map(|wheel| wheel.name.as_str()).collect();
        assert_eq!(names, ["roughing", "finishing"]);
        assert_eq!((changer.mounted, changer.wheels[0].wheel), (0, machine.wheel));
        assert_eq!(changer.wheels[1].wheel.new_radius_mm.to_bits(), 40.0_f64.to_bits());
        assert!((changer.wheels[1].setting_error_mm + 0.003).abs() < 1e-12);
    }

    #[test]
    fn wheels_that_do_not_fit_the_changer_are_refused_where_they_stand() {
        for (overrides, wanted) in [
            (&["wheel_changer.wheels.0.name=roughing"][..], "wheel_changer.wheels.0.name is \"roughing\""),
            (&["wheel_changer.wheels.0.name=null"], "wheel_changer.wheels.0.name"),
            (&["wheel_changer.wheels.0.new_radius_mm=20"], "wheel_changer.wheels.0.new_radius_mm is 20; it must be"),
            (
                &["wheel_changer.wheels.0.max_surface_speed_m_s=30"],
                "at most wheel_changer.wheels.0.max_surface_speed_m_s, 30",
            ),
            (&["wheel_changer.min_x_mm=1000"], "wheel_changer.min_x_mm is 1000; it must be"),
            (&["wheel_changer.change_s=0"], "change_s"),
            (&["wheel_changer.wheels=[]"], "wheel_changer.wheels"),
        ] {
            let error = read(overrides).expect_err(wanted);
            assert!(error.contains(wanted) && error.contains(".yaml:"), "{wanted}: {error}");
        }
        let located = locate::locate("machines", "cam_grinder", "yaml", None).expect("a shipped machine");
        let overrides = ["wheel.setting_error_um=2".to_owned()];
        let error = machine_file::parse(&located.path, &located.text, &overrides).expect_err("no changer").to_string();
        assert!(error.contains("wheel.setting_error_um needs wheel_changer"), "{error}");
    }
}
